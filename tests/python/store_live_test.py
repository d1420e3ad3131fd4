"""Stores larger than memory, felt through windows: on a simulated clock and live."""

import csv
import json
import os
import pathlib
import shutil
import signal
import subprocess
import time

import numpy as np
import pytest

zarr = pytest.importorskip("zarr", reason="python3-zarr is not installed")

from stores import felt, palpa_run, prepare, prepared, raw_store, run_on, without_octaves


@pytest.fixture(scope="module")
def hand(prepared, tmp_path_factory):
    """A simulated hand as it was placed by octave 0: by a store larger than memory it would be by the coarsest."""
    folder = tmp_path_factory.mktemp("hand")
    run_on(pathlib.Path(os.environ["PALPA_BIN"]) / "palpa", folder, prepared("uint8"), 1000, "placed")
    return folder / "placed" / "ticks.csv"


@pytest.mark.parametrize("version", "23")
def test_felt_through_windows_to_the_bit(version, prepared, hand, tmp_path, palpa_program):
    store = prepared("uint8", *(["--zarr", "3"] if version == "3" else []))
    windows = run_on(palpa_program, tmp_path, store, 1, "windows", hand)
    whole = run_on(palpa_program, tmp_path, store, 1000, "whole", hand)
    assert windows == whole and len(windows["ticks.csv"].splitlines()) > 900
    again = palpa_run(palpa_program, "replay", tmp_path / "windows")
    assert again.returncode == 0 and "identical in all 1000 ticks" in again.stdout, again.stdout + again.stderr


def test_voxels_up_to_a_width(prepared, hand, tmp_path, palpa_program):
    store = prepared("uint8")  # its voxels are 2 um wide along z
    limited = run_on(palpa_program, tmp_path, store, "1\ncoarsest_mm = 0.002", "limited", hand)
    assert limited == run_on(palpa_program, tmp_path, store, 1, "windows", hand)
    (tmp_path / "s.toml").write_text(felt.format(store=store, memory_mb="1\ncoarsest_mm = 0.001", value=140))
    done = palpa_run(palpa_program, "run", tmp_path / "s.toml", "--hand", "sim:stroke", "--duration-s", "0.1")
    assert done.returncode != 0 and "voxels of 0.002 mm, wider than coarsest_mm = 0.001" in done.stderr, done.stderr
    assert done.stderr.count("\n") == 1


def test_a_damaged_chunk_leaves_the_coarser_octave_there(prepared, hand, tmp_path, palpa_program):
    store = tmp_path / "v.zarr"
    shutil.copytree(prepared("uint8"), store)
    whole = run_on(palpa_program, tmp_path, store, 1, "whole", hand)
    for chunk in (path for path in (store / "0").rglob("*") if path.is_file() and path.name.isdigit()):
        chunk.write_bytes(b"damage" + chunk.read_bytes()[6:])
    coarser = run_on(palpa_program, tmp_path, store, 1, "coarser", hand)
    assert coarser.keys() == whole.keys() and coarser["ticks.csv"] != whole["ticks.csv"]
    again = palpa_run(palpa_program, "run", tmp_path / "coarser.toml", "--hand", hand, "--duration-s", "0.1")
    assert again.returncode == 0 and "of octave 0 is damaged" in again.stderr, again.stderr


def test_a_replay_ends_where_a_chunk_has_changed(prepared, tmp_path, palpa_program):
    store = prepared("uint8")
    run_on(palpa_program, tmp_path, store, 1, "felt")
    columns = (tmp_path / "felt" / "chunks.csv").read_text().splitlines()
    assert columns[0] == "octave,i,j,k,crc32,volume,field,frame" and len(columns) > 1
    octave, i, j, k, crc = columns[1].split(",")[:5]
    assert int(crc) < 2**32
    (tmp_path / "felt" / "chunks.csv").write_text("\n".join([columns[0], columns[1].replace(crc, str(int(crc) ^ 1))]) + "\n")
    again = palpa_run(palpa_program, "replay", tmp_path / "felt")
    assert again.returncode != 0 and again.stderr.count("\n") == 1, again.stderr
    assert f"chunk {i}, {j}, {k} of octave {octave}" in again.stderr


def live_run(program, folder, store, out, seconds="1.5", hand="sim:stroke"):
    scene = folder / f"{out}.toml"
    scene.write_text(felt.format(store=store, memory_mb=1, value=140))
    arguments = ("run", scene, "--realtime", "--hand", hand, "--duration-s", seconds, "--out", folder / out, "--json")
    done = palpa_run(program, *arguments)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), done.stderr


def test_check_expects_the_octaves_that_info_does(prepared, tmp_path, palpa_program):
    store = prepared("uint8")
    info = json.loads(palpa_run(palpa_program, "info", store, "--set", "memory_mb=1", "--json").stdout)["store"]["felt_live"]
    workspace = f"scale = {1e-6 / info['voxel_hand_m']}\ncenter = [150e-6, 100e-6, 150e-6]"
    scene = tmp_path / "s.toml"
    scene.write_text(felt.format(store=store, memory_mb=1, value=140).replace('fit = "v"', workspace))
    check = palpa_run(palpa_program, "check", scene, "--device", "omega", "--json")
    expected = json.loads(check.stdout)["felt_live"]["v"]
    assert expected["voxel_hand_m"] == pytest.approx(info["voxel_hand_m"], rel=1e-12)
    for here, there in zip(expected["speeds"], info["speeds"], strict=True):
        for share in ("finest_share", "as_fine_as_way_share"):  # a chunk takes another time on a busy machine
            assert here[share] == pytest.approx(there[share], abs=0.1), (expected, info)
    table = palpa_run(palpa_program, "check", scene, "--device", "omega").stdout
    assert "octaves    v: at octave 0 about" in table and "TOO SLOWLY" not in table


def test_a_live_run_is_felt_again_to_the_bit(prepared, tmp_path, palpa_program):
    store = prepared("uint8")
    felt_live, _ = live_run(palpa_program, tmp_path, store, "live")
    assert felt_live["loop"]["windows"]["made"] > 0 and felt_live["felt_octaves"]["finest_share"] > 0.1
    windows = list(csv.DictReader((tmp_path / "live" / "windows.csv").open()))
    assert {window["octave"] for window in windows} == {"0", "1"} and {window["volume"] for window in windows} == {"v"}
    again = palpa_run(palpa_program, "replay", tmp_path / "live")
    assert again.returncode == 0 and "identical in all" in again.stdout, again.stdout + again.stderr


@pytest.fixture(scope="module")
def series(tmp_path_factory):
    """A prepared store of four frames, whose waves travel by a third of a voxel from frame to frame."""
    folder = tmp_path_factory.mktemp("series")
    k, j, i = np.ogrid[:60, :72, :300]
    group = zarr.open_group(str(folder / "v.zarr"), "w")
    frames = [(128 + 60 * np.sin((i - n / 3) / 9) * np.cos(j / 7) + 40 * np.sin(k / 11)).astype(np.uint8) for n in range(4)]
    group.create_dataset("0", data=np.stack(frames), chunks=(1, 32, 32, 32), dimension_separator="/")
    axes = [{"name": "t", "type": "time", "unit": "second"}] + [{"name": axis, "type": "space", "unit": "micrometer"} for axis in "zyx"]
    scale = [{"type": "scale", "scale": [1, 2, 1, 1]}]
    group.attrs["multiscales"] = [{"version": "0.4", "axes": axes, "datasets": [{"path": "0", "coordinateTransformations": scale}]}]
    prepare(pathlib.Path(os.environ["PALPA_BIN"]) / "palpa", folder / "v.zarr")
    return folder / "v.zarr"


def run_series(program, folder, store, memory_mb, out, *arguments):
    keys = f"{memory_mb}\nframe_period_s = 0.05"
    (folder / f"{out}.toml").write_text(felt.format(store=store, memory_mb=keys, value=140) + '[time]\nplay = "loop"\n')
    done = palpa_run(program, "run", folder / f"{out}.toml", "--duration-s", "1", "--out", folder / out, *arguments)
    assert done.returncode == 0, done.stderr
    return (folder / out / "ticks.csv").read_text()


def frames_in(table):
    return {row["frame"] for row in csv.DictReader(table.open())}


def test_a_series_is_felt_through_windows_to_the_bit(series, tmp_path, palpa_program):
    whole = run_series(palpa_program, tmp_path, series, 1000, "whole", "--hand", "sim:stroke")
    windows = run_series(palpa_program, tmp_path, series, 1, "windows", "--hand", tmp_path / "whole" / "ticks.csv")
    assert without_octaves(windows) == without_octaves(whole) and len(whole.splitlines()) > 900
    assert frames_in(tmp_path / "windows" / "chunks.csv") == {"0", "1", "2", "3"}
    again = palpa_run(palpa_program, "replay", tmp_path / "windows")
    assert again.returncode == 0 and "identical in all 1000 ticks" in again.stdout, again.stdout + again.stderr


def test_a_live_run_of_a_series_is_felt_again_to_the_bit(series, tmp_path, palpa_program):
    run_series(palpa_program, tmp_path, series, 1, "live", "--hand", "sim:stroke", "--realtime")
    assert frames_in(tmp_path / "live" / "windows.csv") == {"0", "1", "2", "3"}
    again = palpa_run(palpa_program, "replay", tmp_path / "live")
    assert again.returncode == 0 and "identical in all" in again.stdout, again.stdout + again.stderr


def test_a_live_run_says_which_chunk_is_damaged_and_goes_on(tmp_path, palpa_program):
    store = raw_store(palpa_program, tmp_path, "uint8")
    prepare(palpa_program, store)
    for chunk in (path for path in (store / "0").rglob("*") if path.is_file() and path.name.isdigit()):
        chunk.write_bytes(b"damage" + chunk.read_bytes()[6:])
    felt_live, said = live_run(palpa_program, tmp_path, store, "live")
    assert felt_live["felt_octaves"]["finest_share"] == 0.0 and felt_live["loop"]["windows"]["made"] > 0
    assert "of octave 0 is damaged" in said and str(store) in said
    again = palpa_run(palpa_program, "replay", tmp_path / "live")
    assert again.returncode == 0 and "identical in all" in again.stdout, again.stdout + again.stderr


def readers_of(run):
    listed = subprocess.run(["pgrep", "-P", str(run.pid), "palpa-read"], capture_output=True, text=True)
    return [int(child) for child in listed.stdout.split()]


@pytest.mark.parametrize("fault, waits_s, duration_s", [(signal.SIGKILL, (2.0, 1.5), 6), (signal.SIGSTOP, (2.0,), 18)])
def test_a_reader_that_ends_or_hangs_is_started_once_more(fault, waits_s, duration_s, prepared, tmp_path, palpa_program):
    store = prepared("uint8")
    scene = tmp_path / "s.toml"
    scene.write_text(felt.format(store=store, memory_mb=1, value=140))
    arguments = ["run", scene, "--realtime", "--hand", "sim:stroke", "--duration-s", duration_s, "--out", tmp_path / "live"]
    run = subprocess.Popen([palpa_program, *map(str, arguments), "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    first = []
    for wait_s in waits_s:
        time.sleep(wait_s)
        for child in readers_of(run):
            os.kill(child, fault)
            first.append(child)
    if fault == signal.SIGSTOP:  # ended after 10 s without progress
        time.sleep(13.0)
        later = readers_of(run)
        assert later and not set(later) & set(first)
    out, said = run.communicate(timeout=60)
    assert run.returncode == 0, said
    assert first and json.loads(out)["ticks"] > 1000
    again = palpa_run(palpa_program, "replay", tmp_path / "live")
    assert again.returncode == 0 and "identical in all" in again.stdout, again.stdout + again.stderr


def test_octaves_that_are_missing_are_made_by_prepare(tmp_path, palpa_program):
    large = np.zeros((40, 40, 600), np.uint8)
    array = zarr.open(str(tmp_path / "one.zarr"), mode="w", shape=large.shape, chunks=(32, 32, 32), dtype="u1")
    array[:] = large
    (tmp_path / "s.toml").write_text(felt.format(store=tmp_path / "one.zarr", memory_mb=0.1, value=1))
    done = palpa_run(palpa_program, "run", tmp_path / "s.toml", "--hand", "sim:stroke", "--duration-s", "0.1")
    assert done.returncode != 0 and "palpa prepare" in done.stderr and done.stderr.count("\n") == 1, done.stderr
