"""Runs, traces, replays, comparisons of laws."""

import re
import subprocess

import numpy as np
import pytest

import palpa
from scene_test import head_scene
from session_test import path_of

scene_text = """palpa = 1
[volume.v]
analytic = "lamb_oseen_vortex"
[[mode]]
name = "rail"
type = "follow"
field = "v"
[[mode]]
name = "syrup"
type = "viscosity"
drag_ns_per_m = 1
"""


@pytest.fixture
def scene_file(tmp_path):
    (tmp_path / "scene.toml").write_text(scene_text)
    return tmp_path / "scene.toml"


def test_a_run_is_that_of_the_program(scene_file, tmp_path, palpa_program):
    ours = palpa.run(scene_file, "sim:stroke", duration_s=1, out=tmp_path / "ours", primitives=True)
    subprocess.run([palpa_program, "run", scene_file, "--hand", "sim:stroke", "--duration-s", "1", "--out", tmp_path / "theirs",
                    "--primitives"], check=True, capture_output=True)
    names = sorted(path.name for path in (tmp_path / "theirs").iterdir())
    assert names == sorted(path.name for path in ours.folder.iterdir())
    for name in set(names) - {"timing.csv", "trace.toml"}:
        assert (ours.folder / name).read_bytes() == (tmp_path / "theirs" / name).read_bytes(), name
    assert ours.compare(tmp_path / "theirs").same
    assert ours.summary["ticks"] == 1000


def test_tables_are_arrays(scene_file):
    trace = palpa.run(scene_file, "sim:stroke", duration_s=0.5, primitives=True)
    ticks = trace.ticks
    assert ticks.shape == (500,) and ticks["force_n"].shape == (500, 3) and ticks["tick"].dtype == np.int64
    assert set(trace.tables) >= {"ticks", "modes", "events", "balances", "primitives", "timing"}
    for name in trace.tables:  # each column has a type that its cells have
        assert getattr(trace, name).dtype.names
    np.testing.assert_allclose(ticks["t_s"], np.arange(500) / 1000)
    for column, name in enumerate(("force_x_n", "force_y_n", "force_z_n")):
        lines = (trace.folder / "ticks.csv").read_text().splitlines()
        at = lines[0].split(",").index(name)
        assert [float(line.split(",")[at]) for line in lines[1:]] == list(ticks["force_n"][:, column])
    assert set(trace.modes["mode"]) == {"rail", "syrup"}
    with pytest.raises(AttributeError, match="no table 'tocks'; there are: .*ticks"):
        trace.tocks


def test_a_temporary_trace_goes_with_its_object(scene_file, tmp_path):
    trace = palpa.run(scene_file, "sim:press", duration_s=0.1)
    folder = trace.folder
    assert folder.is_dir()
    del trace
    assert not folder.exists()
    kept = palpa.run(scene_file, "sim:press", duration_s=0.1, out=tmp_path / "kept")
    del kept
    assert palpa.Trace(tmp_path / "kept").header["complete"] is True


def test_a_trace_is_felt_again(scene_file):
    trace = palpa.run(scene_file, "sim:circle", duration_s=0.5)
    replay = trace.replay()
    assert replay.same and replay.ticks == 500 and replay.where == "" and replay.cut == ""
    ticks = trace.folder / "ticks.csv"
    lines = ticks.read_text().splitlines(keepends=True)
    cells = lines[100].split(",")
    at = lines[0].split(",").index("force_x_n")
    cells[at] = "7"
    lines[100] = ",".join(cells)
    ticks.write_text("".join(lines))
    replay = palpa.Trace(trace.folder).replay()
    assert not replay.same and "ticks.csv:101" in replay.where


def test_an_incomplete_trace_is_read_to_its_last_whole_line(scene_file):
    trace = palpa.run(scene_file, "sim:press", duration_s=0.1)
    path = trace.folder / "ticks.csv"
    path.write_bytes(path.read_bytes()[:-5])
    assert len(palpa.Trace(trace.folder).ticks) == 99
    path.write_text(path.read_text().splitlines(keepends=True)[0])
    assert palpa.Trace(trace.folder).ticks["force_n"].shape == (0, 3)


def test_a_scene_of_arrays_runs_and_says_why_it_is_not_replayed():
    scene = palpa.Scene()
    array = np.zeros((20, 20, 20), np.float32)
    array[:10] = 100
    scene.add_array("block", array, 0.005)
    scene.add("s", palpa.SurfaceAndFriction(field="block", levels=[dict(value=50, strength_n=1)]))
    trace = palpa.run(scene, "sim:press", duration_s=0.5)
    assert trace.summary["contact_share"] > 0
    with pytest.raises(palpa.LoadError, match="scene.toml"):
        trace.replay()


@pytest.mark.parametrize("given, error, words", [
    (dict(hand="sim:prod"), palpa.LoadError, "press"),
    (dict(hand="/nowhere.csv"), palpa.LoadError, "/nowhere.csv"),
    (dict(hand="sim:press", duration_s=-1), palpa.LoadError, "duration"),
    (dict(hand="sim:press", rate_hz=0), palpa.LoadError, "rate"),
    (dict(hand="sim:press", rate_hz="fast"), TypeError, "'rate_hz' takes a number"),
    (dict(hand="sim:press", hold="tight"), ValueError, "no hold 'tight'; there are: rigid, relaxed, firm"),
    (dict(hand="sim:press", out="/nowhere/trace"), palpa.LoadError, "/nowhere"),
    (dict(hand="sim:press", device="hammer"), palpa.LoadError, "hammer"),
])
def test_what_cannot_be_run_is_told_in_one_line(scene_file, given, error, words):
    with pytest.raises(error) as told:
        palpa.run(scene_file, **given)
    assert words in str(told.value) and "\n" not in str(told.value)
    with pytest.raises(error):
        palpa.run(palpa.load_scene(scene_file), **given)


def test_a_folder_that_is_no_trace_is_told(tmp_path):
    with pytest.raises(palpa.LoadError, match="is no trace"):
        palpa.Trace(tmp_path)


def test_laws_are_compared():
    path = path_of(1500)
    comparison = palpa.compare_laws(head_scene(), path, 1e-3, ["paper-2005", "no-proxy"])
    assert comparison.ticks == 1500 and set(comparison.posed_m) == {"paper-2005", "no-proxy"}
    assert (np.diff(comparison.posed_m["paper-2005"]) >= 0).all() and len(comparison.alone_n["no-proxy"]) == 1500
    assert "paper-2005" in str(comparison) and "|" in comparison._repr_markdown_()
    with pytest.raises(palpa.SceneError, match="no law 'nonsense'"):
        palpa.compare_laws(head_scene(), path, 1e-3, ["nonsense"])
    by_name = {}
    for law in palpa.laws():
        scene = head_scene()
        scene.law = law
        by_name[law] = palpa.Session(scene).ticks(path, 1e-3)["force_n"]
    assert not (by_name["exact"] == by_name["no-proxy"]).all(), "a session feels by the law that its scene names"


def test_pandas_frames_where_pandas_is(scene_file):
    pandas = pytest.importorskip("pandas")
    trace = palpa.run(scene_file, "sim:press", duration_s=0.1)
    frame = trace.frame()
    assert isinstance(frame, pandas.DataFrame) and list(frame["force_z_n"]) == list(trace.ticks["force_n"][:, 2])
