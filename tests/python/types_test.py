"""The package's type stubs agree with the package, and find mistakes."""

import os
import pathlib
import shutil
import subprocess
import sys

import pytest

import palpa

package = pathlib.Path(palpa.__file__).parent
pytest.importorskip("mypy")


def checked(tmp_path, program):
    (tmp_path / "program.py").write_text(program)
    return subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", tmp_path / "program.py"], capture_output=True,
                          text=True, env={**os.environ, "MYPYPATH": str(package.parent)}, cwd=tmp_path)


def test_stubs_are_those_of_the_package(tmp_path):
    (tmp_path / "stubs/palpa").mkdir(parents=True)  # alone: private modules have no stubs
    shutil.copy(package / "__init__.pyi", tmp_path / "stubs/palpa")
    # Classes of C++: their metaclass is pybind11's, and classes without a constructor accept any arguments.
    of_cpp = [name for name in palpa.__all__ if "pybind11" in type(getattr(palpa, name)).__name__]
    assert "Tick" in of_cpp
    unconstructed = [name for name in of_cpp if not (getattr(palpa, name).__init__.__doc__ or "").startswith("__init__(self")]
    (tmp_path / "allowed").write_text("".join(f"palpa.{name}\n" for name in of_cpp)
                                      + "".join(f"palpa.{name}.__init__\n" for name in unconstructed if name != "Scene"))
    told = subprocess.run([sys.executable, "-m", "mypy.stubtest", "palpa", "--ignore-missing-stub", "--concise", "--allowlist",
                           tmp_path / "allowed"], capture_output=True, text=True, env={**os.environ, "MYPYPATH": str(tmp_path / "stubs")}, cwd=tmp_path)
    assert told.returncode == 0, told.stdout + told.stderr


def test_the_stubs_themselves_are_strict(tmp_path):
    told = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", package / "__init__.pyi"],
                          capture_output=True, text=True, cwd=tmp_path)
    assert told.returncode == 0, told.stdout + told.stderr


def test_modes_of_ones_own_pass_strictly(tmp_path):
    told = checked(tmp_path, """import pickle

import palpa


class Shell(palpa.Mode):
    fields, held_levels, strengths = ("field",), ("level",), ("strength_n",)
    memory = {"held": 0.0}

    def __init__(self, field: str, level: float, strength_n: float | palpa.Strength) -> None:
        self.field, self.level, self.strength_n = field, level, strength_n

    def place(self, here: palpa.ModeContext, memory: dict[str, float], out: palpa.PrimitiveSink) -> None:
        level = here.level(self.field, self.level)
        strength_n = here.newtons(self.strength_n, level)
        if memory["held"] and here.scalar(self.field, here.footing_m(0)).inside:
            out.plane(0, here.proxy_m, (0, 0, 1), strength_n, level=level)

    def on_step_accepted(self, step: palpa.StepResult, memory: dict[str, float]) -> None:
        memory["held"] = float(step.state(0) != "slip")
        for field, value, up in step.crossings:
            print(field, value, up, step.here.range(field))


class Syrup(palpa.Mode):
    fields = ("field",)
    field = "head"

    def place(self, here: palpa.ModeContext, out: palpa.PrimitiveSink) -> None:
        out.point(0, here.proxy_m, 0.0, here.drag(1.0))


scene: palpa.Scene = pickle.loads(pickle.dumps(palpa.Scene()))
scene.add("image", palpa.from_image(object(), metres_per_unit=0.001))
name: str = scene.add("shell", Shell("image", 0.5, palpa.Strength(of="image", points=[(0, 1)])))
rows: list[palpa.Ticks] = palpa.rollout(scene, [[[0.0, 0.0, 0.0]]], 1e-3)
for mode in palpa.Session(scene).modes().values():
    force_n: float = float(mode.force_n[0])
""")
    assert told.returncode == 0, told.stdout + told.stderr


def test_a_right_program_passes_and_a_wrong_one_does_not(tmp_path):
    right = """import numpy as np
import palpa

scene = palpa.Scene(stiffness_n_per_m=400)
head = scene.add("head", palpa.head_phantom())
scene.add("skin", palpa.SurfaceAndFriction(field=head, solid="high", levels=[dict(value=-300, strength_n=0.8)]))
mode = palpa.Follow(field=head, strength_n=palpa.Strength(of=head, points=[(0, 1)]))
mode.strength_n = 0.5
tick = palpa.Session(scene).tick((0, 0.02, 0.05), 1e-3)
force_n: float = float(tick.force_n[0]) + tick.error_bound_m
values, gradients = scene.field(head)(np.zeros((4, 3)))
trace = palpa.run(scene, "sim:stroke", duration_s=1)
same: bool = trace.replay().same
with palpa.live(scene, hand="sim:stroke") as live:
    live.scene = scene
"""
    told = checked(tmp_path, right)
    assert told.returncode == 0, told.stdout + told.stderr
    for line in ("palpa.Follow(strenght_n=1.0)", "palpa.Scene(stiffness_n_per_m='much')", "palpa.GradientForce(towards='up')",
                 "palpa.Session(scene).tock()", "palpa.run(scene, 'sim:press', duration_s='long')"):
        assert checked(tmp_path, right + line + "\n").returncode == 1, line
