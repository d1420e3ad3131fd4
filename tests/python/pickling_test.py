"""Pickling: scenes, volumes, fields, ticks and traces in other processes."""

import concurrent.futures
import functools
import multiprocessing
import pickle
import subprocess
import sys

import numpy as np
import pytest

import palpa
from scene_test import head_scene
from session_test import assert_alike

surface = functools.partial(palpa.SurfaceAndFriction, levels=[dict(value=100, strength_n=2, friction_n=0.1)])


def again(thing):
    return pickle.loads(pickle.dumps(thing))


def sweep(n, seed=0):
    """A path of the hand through the middle of any scene, again and again."""
    phase, t = np.random.default_rng(seed).uniform(0, 6, 3), np.linspace(0, 1, n)
    return (0.08 * np.cos(15 * t + phase[0]) * np.stack([np.cos(3 * t), np.sin(4 * t + phase[1]), np.cos(5 * t + phase[2])])).T


class Thick(palpa.Mode):
    """A mode of the user's own."""

    fields = ("field",)

    def __init__(self, field):
        self.field = field

    def place(self, here, out):
        if here.scalar(self.field).value > 100:
            out.point(0, here.proxy_m, here.newtons(0.3))


def felt(scene, path=None):
    return palpa.Session(scene).ticks(sweep(700) if path is None else path, 1e-3)


def in_a_fresh_process(thing, tmp_path):
    """Ticks of a scene that another interpreter has unpickled."""
    (tmp_path / "thing").write_bytes(pickle.dumps(thing))
    program = (f"import pickle, sys; sys.path[:0] = {sys.path!r}\nfrom pickling_test import felt\n"
               "pickle.dump(felt(pickle.load(open('thing', 'rb'))), open('told', 'wb'))\n")
    subprocess.run([sys.executable, "-c", program], check=True, cwd=tmp_path)
    return pickle.loads((tmp_path / "told").read_bytes())


def ball(dtype, order="C"):
    z, y, x = np.mgrid[-1:1:21j, -1:1:23j, -1:1:25j]
    values = 200 * np.exp(-3 * (x**2 + y**2 + z**2)) + 10 * np.sin(9 * x)
    return np.asarray(np.round(values) if np.dtype(dtype).kind in "iu" else values, dtype=dtype, order=order)


def of_array(dtype, order="C", **how):
    scene = palpa.Scene(stiffness_n_per_m=400)
    scene.add_array("ball", ball(dtype, order), 0.001, unit="HU", **how)
    scene.add("surface", surface(field="ball"))
    return scene


def of_vectors():
    scene = palpa.Scene()
    field = np.random.default_rng(1).normal(size=(9, 10, 11, 3)).astype("float32")
    field[0, 0, 0] = np.nan
    scene.add_array("flow", field, 0.002, axes=[[0, -1, 0], [1, 0, 0], [0, 0, 1]], origin_m=(0.01, 0.02, 0.03))
    scene.add("rail", palpa.Follow(field="flow", strength_n=palpa.Strength(of="magnitude(flow)", points=[(0, 0), (1, 1)], outside=1)),
              masks=[palpa.Mask(of="magnitude(flow)", points=[(0, 0.5), (2, 1)], outside=1)])
    scene.workspace.fit, scene.title = "flow", "vectors"
    return scene


def of_formulas():
    scene = head_scene()
    scene.add("flow", palpa.lamb_oseen_vortex(circulation_m2_per_s=0.03))
    scene.add("rail", palpa.Follow(field="flow", strength_n=0.2), enabled=False)
    scene.modes["skin"].mode.levels[0].stiffness_n_per_m = 900
    scene.add("ring", palpa.ring_vortex(beat=0.1))
    scene.add("signal", surface(field="ring.signal", levels=[dict(value=0.5)]))
    return scene


def of_the_beating_heart():
    scene = palpa.Scene()
    scene.add("heart", palpa.beating_chamber())
    scene.add("wall", surface(field="heart.signal", levels=[dict(value=0.5, strength_n=1)]))
    scene.time.play = "loop"
    return scene


def of_a_mode_in_python():
    scene = head_scene()
    scene.add("thick", Thick("head"))
    return scene


scenes = {
    "int16": lambda: of_array("int16"),
    "uint8, in Fortran's order": lambda: of_array("uint8", "F"),
    "float32, trilinear": lambda: of_array("float32", filter="trilinear"),
    "float64, cubic": lambda: of_array("float64", filter="cubic"),
    "vectors": of_vectors, "formulas": of_formulas, "moving": of_the_beating_heart, "mode in Python": of_a_mode_in_python,
}


@pytest.mark.parametrize("name", scenes)
def test_a_pickled_scene_is_felt_to_the_bit(name, tmp_path):
    scene = scenes[name]()
    other = again(again(scene))
    assert type(other) is palpa.Scene and other.to_toml() == scene.to_toml() and repr(other.volumes) == repr(scene.volumes)
    rows = felt(scene)
    assert np.abs(rows["force_n"]).max() > 0.05, "nothing was felt"
    assert_alike(felt(other), rows)
    assert_alike(in_a_fresh_process(scene, tmp_path), rows)


scene_of_files = """palpa = 1
title = "of files"
[volume.ball]
file = "ball.raw"
type = "int16"
dims = [25, 23, 21]
spacing_m = [0.001, 0.001, 0.001]
filter = "trilinear"
pose = {translate_m = [0.002, 0, 0], rotate_axis_deg = [0, 0, 1, 30], scale = 1.25}
[volume.moves]
file = "ball.raw"
type = "int16"
dims = [25, 23, 21]
spacing_m = [0.001, 0.001, 0.001]
poses = [{time_s = 0.0, translate_m = [0, 0, 0]}, {time_s = 0.5, translate_m = [0.003, 0, 0]}]
[volume.named]
file = "ball.raw"
type = "int16"
dims = [25, 23, 21]
spacing_m = [0.001, 0.001, 0.001]
labels = {core = 190}
[volume.grid]
analytic = "beating_chamber"
sampled = 12
frames = 4
[volume.formula]
analytic = "sphere"
pose = {scale = 0.3}
[workspace]
fit = "ball"
[time]
play = "loop"
[[mode]]
name = "surface"
type = "surface_and_friction"
field = "ball"
[[mode.level]]
value = 100
strength_n = 2
[[mode]]
name = "moving"
type = "surface_and_friction"
field = "moves"
[[mode.level]]
value = 150
strength_n = 1
[view]
from = [1, 0, 0]
[[view.layer]]
show = "surface"
field = "ball"
level = 100
parts = "all"
colors = {points = [[0, "#102030", 0.5], [100, "#ffeedd", 1.0]]}
"""


@pytest.fixture
def files(tmp_path):
    ball("int16").tofile(tmp_path / "ball.raw")
    (tmp_path / "scene.toml").write_text(scene_of_files)
    return tmp_path


def test_a_scene_of_files_is_pickled_by_their_paths(files):
    scene = palpa.load_scene(files / "scene.toml")
    rows, text = felt(scene), pickle.dumps(scene)
    assert np.abs(rows["force_n"]).max() > 0.05, "nothing was felt"
    assert ball("int16").tobytes() not in pickle.dumps(scene.volumes["ball"]) and str(files / "ball.raw").encode() in text
    other = again(again(scene))
    assert other.to_toml() == scene.to_toml() and other == scene and other.volumes["ball"].files == scene.volumes["ball"].files
    assert_alike(felt(other), rows)
    assert_alike(in_a_fresh_process(scene, files), rows)
    volume = again(palpa.read_volume(files / "ball.raw", type="int16", dims=(25, 23, 21), spacing_m=(0.001,) * 3))
    assert (volume.fields["value"].voxels == ball("int16")).all()
    (files / "ball.raw").write_bytes(bytes(2 * 21 * 23 * 25))
    with pytest.raises(palpa.LoadError, match="ball.raw: the file is another than when this was pickled"):
        pickle.loads(text)


def test_pickled_scenes_in_a_pool_of_processes_give_the_same_bits():
    """Fresh interpreters, several scenes and paths: the bits of this process."""
    work = [(scenes[name](), sweep(400, seed)) for seed, name in enumerate(("int16", "vectors", "formulas", "mode in Python"))]
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        results = list(pool.map(felt, *zip(*work)))
    for (scene, path), rows in zip(work, results):
        assert type(rows) is palpa.Ticks and np.abs(rows["force_n"]).max() > 0.05
        assert_alike(rows, felt(scene, path))


def test_ticks_and_their_parts_are_pickled():
    session = palpa.Session(head_scene())
    for position in sweep(300):
        tick = session.tick(position, 1e-3)
        if np.linalg.norm(tick.force_n) > 0.1:
            break
    other = again(tick)
    for name in ("probe_m", "probe_velocity_m_per_s", "proxy_m", "proxy_velocity_m_per_s", "force_n"):
        assert getattr(other, name).tobytes() == getattr(tick, name).tobytes() and getattr(tick, name).any(), name
    for name in ("error_bound_m", "sub_steps", "iterations", "status", "dropped", "probe_valid"):
        assert getattr(other, name) == getattr(tick, name)
    assert repr(other.energy) == repr(tick.energy) and other.energy.stored_j == tick.energy.stored_j > 0
    skin = again(session.modes())["skin"]
    assert skin.force_n.tobytes() == session.modes()["skin"].force_n.tobytes() and skin.primitives == session.modes()["skin"].primitives > 0
    assert again(palpa.TickStatus.waiting) == palpa.TickStatus.waiting
    assert again(felt(head_scene())[3:9]).mode_force_n is None  # as of the slice itself


def test_volumes_and_fields_are_pickled():
    scene = of_array("int16")
    field = scene.field("ball")
    points_m = np.random.default_rng(2).uniform(-0.01, 0.01, (500, 3))
    other = again(field)
    assert (other.name, other.unit, other.filter, other.value_ranges) == (field.name, "HU", "smooth", field.value_ranges)
    assert all(a.tobytes() == b.tobytes() for a, b in zip(other(points_m), field(points_m)))
    volume = again(palpa.array_volume(ball("float32"), 0.001, unit="mm"))
    assert volume.fields["data"].unit == "mm" and (volume.fields["data"].voxels == ball("float32")).all()
    uneven = palpa.array_volume(ball("float32"), 0.001)
    assert again(uneven).filter == "trilinear"


def test_what_is_not_pickled_says_what_to_pickle(tmp_path):
    scene = head_scene()
    trace = palpa.run(scene, "sim:press", duration_s=0.1)
    by_c, flow = head_scene(), of_vectors()
    by_c.add("lab", palpa.CFunction(1 << 20, scalars=["head"]))
    for thing, words in ((palpa.Session(scene), "pickle its scene"), (trace, r"run\(…, out=folder\) keeps the folder"),
                         (by_c, "mode 'lab' is a function of C"), (flow.field("magnitude(flow)"), "pickle the scene")):
        with pytest.raises(TypeError, match=words):
            pickle.dumps(thing)
    kept = palpa.run(scene, "sim:press", duration_s=0.1, out=tmp_path / "trace")
    other = again(kept)
    assert other.ticks.tobytes() == kept.ticks.tobytes() and other.summary == kept.summary and other.warnings == kept.warnings
    other.close()
    assert (tmp_path / "trace/trace.toml").exists()
