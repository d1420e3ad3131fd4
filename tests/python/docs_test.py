"""Statements of the pages about Python."""

import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest

import palpa

source = pathlib.Path(__file__).resolve().parents[2]


def blocks(page):
    return re.findall(r"^```python\n(.*?)^```", (source / page).read_text(encoding="utf-8"), re.M | re.S)


def test_the_examples_of_the_page_run_as_they_stand_there(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    examples = blocks("docs/python.md")
    assert len(examples) >= 9
    names = {}
    for example in examples:
        exec(compile(example, "docs/python.md", "exec"), names)


def test_the_lines_on_tools_feel_a_torque():
    (lines,) = blocks("docs/tools.md")
    names = {}
    exec(compile(lines, "docs/tools.md", "exec"), names)
    tick = names["t"]
    assert tick.force_n[2] > 0.1 and np.linalg.norm(tick.torque_nm) > 1e-3
    assert np.linalg.norm(tick.proxy_turn) == pytest.approx(1.0, abs=1e-12)


def test_the_readmes_lines_feel_the_same_as_those_in_cpp():
    """Equal to the bit, also for a hand that continues from there (readme_ticks.cpp.in)."""
    (lines,) = blocks("README.md")
    names = {}
    exec(compile(lines, "README.md", "exec"), names)
    program = pathlib.Path(palpa.__file__).parents[2] / "tests/python_readme_ticks"
    printed = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    theirs = np.array([float.fromhex(word) for word in printed.split()]).reshape(-1, 7)
    session, tick = names["session"], names["t"]
    for n, row in enumerate(theirs):
        assert list(row) == [*tick.proxy_m, *tick.force_n, tick.error_bound_m]
        tick = session.tick((0.0001 * n, 0.02, 0.12 - 0.0005 * n), 1e-3)
    assert len(theirs) == 200 and np.abs(theirs[:, 3:6]).max() > 0.1, "nothing is felt"


def test_the_readmes_lines_end_with_the_force_that_they_state(capsys):
    (lines,) = blocks("README.md")
    names = {}
    exec(compile(lines, "README.md", "exec"), names)
    force_n = np.linalg.norm(names["t"].force_n)
    assert force_n > 0.1, "nothing is felt"
    assert force_n == pytest.approx(float(re.search(r"([0-9.]+) N\b", lines)[1]), abs=0.05)
    assert np.linalg.norm(np.fromstring(capsys.readouterr().out.strip("[]\n"), sep=" ")) == pytest.approx(force_n, rel=1e-6)


def test_one_scene_in_toml_cpp_and_python(tmp_path):
    """Equal, with equal bytes in all tables of their traces."""
    values = (np.indices((12, 12, 12)).sum(axis=0) - 16).astype("<i2")
    (tmp_path / "ramp.raw").write_bytes(values.tobytes())
    program = pathlib.Path(palpa.__file__).parents[2] / "tests/python_same_scene"
    (tmp_path / "cpp.toml").write_bytes(subprocess.run([program, tmp_path, tmp_path / "cpp"], check=True, capture_output=True).stdout)

    made = palpa.Scene(stiffness_n_per_m=500, damping_ns_per_m=0.25)
    made.title = "a ramp"
    ramp = made.add("ramp", palpa.read_volume(tmp_path / "ramp.raw", type="int16", dims=(12, 12, 12),
                                              spacing_m=(0.001, 0.002, 0.003)))
    made.workspace.scale = 0.25
    made.workspace.up = "-y"
    made.add("wall", palpa.SurfaceAndFriction(
        field=ramp, solid="low", friction_n=0.2,
        levels=[palpa.SurfaceAndFriction.Level(name="zero", value=0, strength_n=2),
                dict(value=6, strength_n=palpa.Strength(of="gradient_magnitude(ramp)", points=[(0, 1), (2000, 3)], outside=3))]))
    made.add("syrup", palpa.Viscosity(drag_ns_per_m=1), masks=[palpa.Mask(of="ramp", points=[(-16, 0), (16, 1)])], enabled=False)

    (tmp_path / "written.toml").write_text("""palpa = 1
title = "a ramp"
[coupling]
stiffness_n_per_m = 500
damping_ns_per_m = 0.25
[workspace]
scale = 0.25
up = "-y"
[volume.ramp]
file = "ramp.raw"
type = "int16"
dims = [12, 12, 12]
spacing_m = [0.001, 0.002, 0.003]
[[mode]]
name = "wall"
type = "surface_and_friction"
field = "ramp"
solid = "low"
friction_n = 0.2
[[mode.level]]
name = "zero"
value = 0
strength_n = 2
[[mode.level]]
value = 6
strength_n = {of = "gradient_magnitude(ramp)", points = [[0, 1], [2000, 3]], outside = 3}
[[mode]]
name = "syrup"
type = "viscosity"
drag_ns_per_m = 1
enabled = false
mask = [{of = "ramp", points = [[-16, 0], [16, 1]]}]
""")
    loaded = palpa.load_scene(tmp_path / "written.toml")

    def without_volume(text):
        return re.sub(r"\[volume\.ramp\]\n(?:[^\[].*\n)*", "", text)

    assert made.to_toml() == (tmp_path / "cpp.toml").read_text()
    assert without_volume(made.to_toml()) == without_volume(loaded.to_toml())
    assert palpa.load_scene(tmp_path / "cpp.toml").to_toml() == made.to_toml()

    ours = palpa.run(made, "sim:press", duration_s=1, out=tmp_path / "ours", primitives=True)
    theirs = palpa.run(tmp_path / "written.toml", "sim:press", duration_s=1, out=tmp_path / "theirs", primitives=True)
    for table in sorted(set(ours.tables) - {"timing"}):
        text = (ours.folder / f"{table}.csv").read_bytes()
        assert text == (theirs.folder / f"{table}.csv").read_bytes() == (tmp_path / "cpp" / f"{table}.csv").read_bytes(), table
    assert (tmp_path / "cpp/scene.toml").read_bytes() == (ours.folder / "scene.toml").read_bytes()
    assert ours.summary["contact_share"] > 0 and ours.replay().same


def test_the_lines_on_parts_by_dask_prepare_a_store(tmp_path, palpa_program):
    pytest.importorskip("distributed", reason="python3-distributed is not installed")
    (lines,) = blocks("docs/large.md")
    np.arange(300 * 200 * 150).astype(np.uint16).tofile(tmp_path / "big.raw")
    subprocess.run([palpa_program, "convert", "big.raw", "big.zarr", "--part", "1/1", "--set", "type=uint16", "--set", "dims=[300,200,150]"],
                   cwd=tmp_path, check=True, capture_output=True)
    (tmp_path / "parts.py").write_text(lines)
    done = subprocess.run([sys.executable, "parts.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.stdout.startswith("True\n") and done.stdout.endswith(" (4, 8, 8)\n"), done.stderr
