"""Runs, traces, replays, comparisons of laws."""

import os
import re
import subprocess
import sys
import warnings

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
    for name in trace.tables:  # each column has its cells' type
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


@pytest.fixture
def ball_scene():
    scene = palpa.Scene(stiffness_n_per_m=500, damping_ns_per_m=0)
    scene.add("ball", palpa.sphere_field(radius_m=0.03))
    scene.add("skin", palpa.SurfaceAndFriction(field="ball", levels=[dict(value=0, strength_n=3)]))
    scene.workspace.scale, scene.workspace.center = 1, (0, 0, 0)
    return scene


down_m = np.column_stack([np.zeros(2000), np.zeros(2000), np.linspace(0.032, 0.028, 2000)])


def written(path, names="t_s,x_m,y_m,z_m", end="\n"):
    rows = (f"{n / 1000:.6f},{x!r},{y!r},{z!r}" for n, (x, y, z) in enumerate(down_m.tolist()))
    path.write_text(names + "\n" + "\n".join(rows) + end)
    return path


def test_a_recorded_hand_lies_where_it_is_told_to(ball_scene, tmp_path):
    file = written(tmp_path / "hand.csv")
    want = palpa.Session(ball_scene).ticks(down_m, 1e-3)["force_n"]
    assert np.abs(want).max() > 0.9
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        felt = palpa.run(ball_scene, file, place="as_recorded")
    assert felt.warnings == () and len(felt.ticks) == 2000
    np.testing.assert_allclose(felt.ticks["force_n"], want, atol=1e-9)
    np.testing.assert_allclose(felt.ticks["probe_m"], down_m, atol=1e-15)
    centred = palpa.run(ball_scene, file, place="centred").ticks["probe_m"]
    np.testing.assert_allclose(centred, down_m - [0, 0, 0.03], atol=1e-12)
    for given in (dict(), dict(place="fitted")):
        with pytest.warns(palpa.PalpaWarning, match="The recording was .*moved by .*place='as_recorded'"):
            fitted = palpa.run(ball_scene, file, **given)
        assert any("moved by" in sentence for sentence in fitted.warnings)
        moved = fitted.ticks["probe_m"] - down_m
        assert np.linalg.norm(moved[0]) > 1e-3 and np.abs(moved - moved[0]).max() < 1e-9, "moved, not turned"
    own = written(tmp_path / "any-name.csv", "t_s,probe_x_m,probe_y_m,probe_z_m")
    np.testing.assert_allclose(palpa.run(ball_scene, own).ticks["probe_m"], down_m, atol=1e-15)
    with pytest.raises(ValueError, match="no place 'center'; .*'centred'"):
        palpa.run(ball_scene, file, place="center")


def test_the_earlier_word_for_the_place_is_read(ball_scene, tmp_path):
    file = written(tmp_path / "hand.csv")
    for fit, place in ((True, "fitted"), (False, "centred")):
        with pytest.warns(palpa.PalpaWarning, match=f"'fit' is called place='{place}' now"):
            old = palpa.run(ball_scene, file, fit=fit)
        np.testing.assert_array_equal(old.ticks["probe_m"], palpa.run(ball_scene, file, place=place).ticks["probe_m"])
    with pytest.raises(TypeError, match="'place' says where"):
        palpa.run(ball_scene, file, fit=True, place="fitted")
    palpa.run(ball_scene, "sim:press", fit=False, duration_s=0.1)


def test_positions_are_a_hand_that_is_never_moved(ball_scene):
    for dt_s in (1e-3, 1 / 3000, np.float32(0.002)):
        want = palpa.Session(ball_scene).ticks(down_m, dt_s)
        with palpa.run(ball_scene, down_m, dt_s) as felt:
            assert felt.warnings == () and len(felt.ticks) == 2000
            np.testing.assert_array_equal(felt.ticks["probe_m"], down_m)
            np.testing.assert_allclose(felt.ticks["force_n"], want["force_n"], atol=1e-9)
    assert len(palpa.run(ball_scene, down_m[:50].tolist(), 1e-3, place="as_recorded").ticks) == 50
    holed = down_m.copy()
    holed[1000] = np.nan
    assert not palpa.run(ball_scene, holed, 1e-3).ticks["probe_valid"][1000]
    for hand, dt_s, given, error, words in (
            (down_m, None, {}, TypeError, "one time step"), (down_m, np.full(2000, 1e-3), {}, TypeError, "one time step"),
            (down_m, 16, {}, ValueError, "'dt_s' is 16"), (down_m.T, 1e-3, {}, TypeError, "shape \\(3, 2000\\)"),
            (down_m, 1e-3, dict(place="fitted"), ValueError, "move the array"), (down_m[:0], 1e-3, {}, ValueError, "no row"),
            (3, 1e-3, {}, TypeError, "not int"), ("sim:press", 1e-3, {}, TypeError, "'dt_s'"),
            (1e6 * down_m, 1e-3, {}, ValueError, "positions are metres")):
        with pytest.raises(error, match=words):
            palpa.run(ball_scene, hand, dt_s, **given)


def test_a_recording_that_was_cut_is_felt_and_told(ball_scene, tmp_path):
    whole = palpa.run(ball_scene, "sim:press", duration_s=0.2, out=tmp_path / "trace")
    ticks = tmp_path / "trace/ticks.csv"
    ticks.write_bytes(ticks.read_bytes()[:-20])
    with pytest.warns(palpa.PalpaWarning, match="line 201 has no end.*left out"):
        again = palpa.run(ball_scene, ticks)
    assert len(again.ticks) == 199
    np.testing.assert_allclose(again.ticks["probe_m"], whole.ticks["probe_m"][:199], atol=1e-12)


def test_what_is_to_be_known_of_a_run_is_a_warning(ball_scene, tmp_path):
    with pytest.warns(palpa.PalpaWarning, match="Nothing was felt"):
        trace = palpa.run(ball_scene, down_m + [0.5, 0, 0], 1e-3)
    assert any("Nothing was felt" in sentence for sentence in trace.warnings)
    file = tmp_path / "hand.csv"
    rows = np.floor(np.arange(2000) / 16.7)
    file.write_text("t_s,x_m,y_m,z_m\n" + "".join(
        f"{n / 1000},{0.02 * np.sin(0.1 * k):.6f},0,{0.031 + 0.005 * np.cos(0.13 * k):.6f}\n" for n, k in enumerate(rows)))
    with pytest.warns(palpa.PalpaWarning, match="rows repeat the position before them.*logger"):
        palpa.run(ball_scene, file, place="as_recorded")


def test_a_temporary_trace_is_closed_by_hand_or_by_with(scene_file):
    with palpa.run(scene_file, "sim:press", duration_s=0.1) as trace:
        assert trace.folder.is_dir()
    assert not trace.folder.parent.exists()
    trace.close()
    kept = palpa.run(scene_file, "sim:press", duration_s=0.1)
    kept.close()
    assert not kept.folder.exists()


def test_named_traces_are_not_removed(scene_file, tmp_path):
    with palpa.run(scene_file, "sim:press", duration_s=0.1, out=tmp_path / "t") as trace:
        pass
    trace.close()
    assert (tmp_path / "t/trace.toml").exists()


def test_a_forked_process_leaves_the_recording_alone_and_nothing_warns(scene_file):
    program = f"""
import os, sys, palpa
trace = palpa.run({str(scene_file)!r}, "sim:circle", duration_s=0.1)
live = palpa.live(palpa.load_scene({str(scene_file)!r}), hand="sim:circle", duration_s=60)
child = os.fork()
if child == 0:
    sys.exit()
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
child = os.fork()
if child == 0:
    del trace, live
    import gc
    gc.collect()
    sys.exit()
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
assert len(trace.ticks) == 100 and trace.folder.is_dir()
assert live.stop().header["complete"] is True
folders = [trace.folder, live.stop().folder]
del trace, live
assert not any(folder.exists() for folder in folders)
left = palpa.run({str(scene_file)!r}, "sim:circle", duration_s=0.1)
print(left.folder)
"""
    done = subprocess.run([sys.executable, "-W", "error::ResourceWarning", "-W", "ignore:This process:DeprecationWarning", "-c", program], capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    assert not os.path.exists(done.stdout.strip()), "it goes with the process that made it"


def test_attributes_of_a_trace_that_there_are_not_are_told(scene_file):
    trace = palpa.run(scene_file, "sim:press", duration_s=0.1)
    with pytest.raises(AttributeError, match="did you mean 'folder'"):
        trace.foldr = 3
    with pytest.raises(TypeError, match="'scene' takes a palpa.Scene"):
        palpa.run(3, "sim:press")


def test_a_forked_process_leaves_with_in_peace(scene_file):
    program = f"""
import os, sys, palpa
with palpa.live(palpa.load_scene({str(scene_file)!r}), hand="sim:circle", duration_s=60) as live, \\
        palpa.run({str(scene_file)!r}, "sim:circle", duration_s=0.1) as trace:
    child = os.fork()
    if child == 0:
        sys.exit(7)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
    assert live.is_running and len(trace.ticks) == 100
"""
    done = subprocess.run([sys.executable, "-W", "error", "-c", program], capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == "", done.stderr


def test_typos_on_a_trace_are_told_by_the_name_that_was_meant(scene_file):
    with palpa.run(scene_file, "sim:press", duration_s=0.1) as trace:
        for name, words in (("tick", "did you mean 'ticks'"), ("warning", "did you mean 'warnings'"), ("xyz", "there are: ")):
            with pytest.raises(AttributeError, match=words):
                getattr(trace, name)
        with pytest.raises(AttributeError):
            trace.frame = 3
    with palpa.live(palpa.load_scene(scene_file), hand="sim:press", duration_s=5) as live:
        for name in ("panic", "stop", "look", "scen", "is_running"):
            with pytest.raises(AttributeError):
                setattr(live, name, True)
