"""First scenes, pictures and errors of stores that are felt through windows."""

import json
import os
import pathlib
import shutil

import numpy as np
import pytest

zarr = pytest.importorskip("zarr", reason="python3-zarr is not installed")

from stores import felt, octaves_of, palpa_run, prepare, shape


def rock(folder, program, dtype="uint8", frames=0):
    """A store of a body with pores of a few voxels, whose values the means of coarser octaves do not have; and its voxels."""
    k, j, i = np.mgrid[: shape[0], : shape[1], : shape[2]]
    r = np.sqrt(((i - 150) / 120) ** 2 + ((j - 100) / 80) ** 2 + ((k - 75) / 60) ** 2)
    pores = np.sin(i / 1.3) * np.sin(j / 1.3) * np.sin(k / 1.3) > 0.3
    noise = np.random.default_rng(3).normal(0, 5, shape)
    values = (np.where(r > 1, 30, np.where(pores, 40, 150)) + noise).clip(0, 255).astype(dtype)
    store = folder / "rock.zarr"
    group = zarr.open_group(str(store), "w")
    data = np.stack([np.zeros_like(values)] * (frames - 1) + [values]) if frames else values
    group.create_dataset("0", data=data, chunks=(1,) * bool(frames) + (32, 32, 32), dimension_separator="/")
    axes = ([{"name": "t", "type": "time"}] if frames else []) + [{"name": name, "type": "space", "unit": "micrometer"} for name in "zyx"]
    scale = [1] * bool(frames) + [4, 4, 4]
    group.attrs["multiscales"] = [{"version": "0.4", "axes": axes, "datasets": [
        {"path": "0", "coordinateTransformations": [{"type": "scale", "scale": scale}]}]}]
    prepare(program, store)
    return store, values


def otsu(values):
    """The level that divides whole numbers best, by its definition."""
    counts = np.bincount(values.ravel(), minlength=256).astype(float)
    below, number = np.cumsum(counts), np.arange(256)
    sums = np.cumsum(counts * number)
    with np.errstate(invalid="ignore", divide="ignore"):
        between = below * (below[-1] - below) * (sums / below - (sums[-1] - sums) / (below[-1] - below)) ** 2
    return np.flatnonzero(between >= np.nanmax(between) * (1 - 1e-9)).mean() + 0.5


def test_a_first_scene_has_the_levels_of_the_file(tmp_path, palpa_program):
    store, values = rock(tmp_path, palpa_program)
    scene = tmp_path / "first.toml"
    done = palpa_run(palpa_program, "info", store, "--set", "memory_mb=1", "--scene", scene, "--picture", tmp_path / "rock.png")
    assert done.returncode == 0 and f"Wrote {scene}" in done.stderr, done.stderr
    text = scene.read_text()
    (level,) = [float(line.split("#")[0].split("=")[1]) for line in text.splitlines() if line.startswith("value = ")][:1]
    assert level == pytest.approx(otsu(values), abs=8)
    assert "um of the hand" in text and "memory_mb = 1" in text
    assert (tmp_path / "rock.png").stat().st_size > 10000

    run = palpa_run(palpa_program, "run", scene, "--hand", "sim:stroke", "--duration-s", "1", "--out", tmp_path / "trace")
    assert run.returncode == 0 and "in contact" in run.stdout, run.stderr
    again = palpa_run(palpa_program, "replay", tmp_path / "trace")
    assert "identical in all 1000 ticks" in again.stdout, again.stdout + again.stderr
    check = palpa_run(palpa_program, "check", scene, "--device", "inverse3")
    assert check.returncode in (0, 1) and "coupling" in check.stdout, check.stderr
    report = palpa_run(palpa_program, "report", tmp_path / "trace", "--pictures", tmp_path / "pictures")
    assert report.returncode == 0, report.stderr
    assert (tmp_path / "pictures/scene.png").stat().st_size > 10000
    page = (tmp_path / "trace/report.html").read_text()
    assert "surface, octave 1" in page and "Octave 0 has the voxels of the file" in page


def test_a_first_scene_of_a_flow_uses_the_curl_in_its_store(tmp_path, palpa_program):
    k, j, i = np.mgrid[:70, :90, :140].astype(np.float32)
    around = np.exp(-((i - 70) ** 2 + (j - 45) ** 2) / 600)
    np.stack([0.2 - (j - 45) * around / 20, (i - 70) * around / 20, 0 * k], -1).astype(np.float32).tofile(tmp_path / "v.raw")
    store, scene = tmp_path / "v.zarr", tmp_path / "first.toml"
    done = palpa_run(palpa_program, "convert", tmp_path / "v.raw", store, "--set", "type=float32", "--set", "dims=[140,90,70]",
                     "--set", "components=last", "--set", "spacing_m=[1e-3,1e-3,1e-3]")
    assert done.returncode == 0, done.stderr
    first = ("info", store, "--set", "memory_mb=1", "--scene", scene, "--force")
    assert palpa_run(palpa_program, *first).returncode == 0
    (command,) = [line.split(" writes ")[0][2:] for line in scene.read_text().splitlines() if line.startswith("# palpa prepare")]
    assert command == f"palpa prepare {store} --derive curl=vector" and "curl_vector" not in scene.read_text()
    done = palpa_run(palpa_program, *command.split()[1:])
    assert done.returncode == 0, done.stderr
    done = palpa_run(palpa_program, *first)
    assert done.returncode == 0, done.stderr
    assert 'of = "magnitude(v.curl_vector)"' in scene.read_text() and "# palpa prepare" not in scene.read_text()
    run = palpa_run(palpa_program, "run", scene, "--hand", "sim:stroke", "--duration-s", "1", "--out", tmp_path / "trace")
    assert run.returncode == 0 and "in contact" in run.stdout, run.stderr


def test_a_frame_of_a_store_is_felt(tmp_path, palpa_program):
    store, values = rock(tmp_path, palpa_program, frames=2)
    info = palpa_run(palpa_program, "info", store, "--set", "memory_mb=1", "--set", "frame=1", "--scene", tmp_path / "first.toml")
    assert info.returncode == 0 and "frame = 1 " in (tmp_path / "first.toml").read_text(), info.stderr
    empty = palpa_run(palpa_program, "info", store, "--set", "memory_mb=1", "--set", "frame=0", "--scene", tmp_path / "empty.toml")
    assert empty.returncode == 2 and "has no two classes of values" in empty.stderr, empty.stderr
    run = palpa_run(palpa_program, "run", tmp_path / "first.toml", "--hand", "sim:stroke", "--duration-s", "0.3")
    assert run.returncode == 0, run.stderr
    for wrong, words in (("frame=5", "has 2 frames, not frame 5; name one from 0 to 1"),):
        done = palpa_run(palpa_program, "info", store, "--set", "memory_mb=1", "--set", wrong, "--scene", tmp_path / "wrong.toml")
        assert done.returncode == 2 and words in done.stderr, done.stderr
    all_frames = (tmp_path / "first.toml").read_text().replace("frame = 1 ", "frame_period_s = 0.1 ")
    (tmp_path / "all.toml").write_text(all_frames)
    done = palpa_run(palpa_program, "run", tmp_path / "all.toml", "--hand", "sim:stroke", "--duration-s", "0.3")
    assert done.returncode == 0, done.stderr


def wrong_stores():
    """Faults of a store that is felt through windows, each with the words of its line."""

    def decimate(of):
        octaves = octaves_of(of)
        for n in (1, 2):
            zarr.open(str(of), "r+")[str(n)][:] = octaves[0][:: 2**n, :: 2**n, :: 2**n]

    def spoil(of):
        zarr.open(str(of), "r+")["1"][:] = np.random.default_rng(1).integers(0, 255, octaves_of(of)[1].shape)

    def without_octaves(of):
        attributes = json.loads((of / ".zattrs").read_text())
        attributes["multiscales"][0]["datasets"] = attributes["multiscales"][0]["datasets"][:1]
        (of / ".zattrs").unlink()
        (of / ".zattrs").write_text(json.dumps(attributes))

    def damage_coarsest(of):
        for path in (of / "2").rglob("*"):
            if path.is_file() and path.name.isdigit():
                path.unlink()  # a link to the chunk of another test
                path.write_bytes(b"no chunk")

    return {
        "coarsest": (damage_coarsest, "", "the coarsest octave cannot be read"),
        "octaves": (without_octaves, "", "its octaves end at 300 voxels"),
        "decimation": (decimate, "", "every second voxel"),
        "neither": (spoil, "", "no means of octave 0"),
        "array": (None, "fields = {v = {array = 'none'}}", "has no array 'none'"),
        "arrays": (None, "fields = {v = {arrays = ['a', 'b', 'c']}}", "is of three arrays"),
        "frame": (None, "frame = 3", "not frame 3"),
        "frames": (None, "frame_period_s = 0.1", "holds one frame, so it is no time series"),
    }


@pytest.fixture(scope="module")
def small_rock(tmp_path_factory):
    program = pathlib.Path(os.environ["PALPA_BIN"]) / "palpa"
    if not program.exists():
        pytest.skip("the program palpa is not built")
    return rock(tmp_path_factory.mktemp("rock"), program)[0]


@pytest.mark.parametrize("kind", wrong_stores())
def test_an_error_names_its_store_once(kind, small_rock, tmp_path, palpa_program):
    spoil, key, words = wrong_stores()[kind]
    store = tmp_path / "rock.zarr" if spoil else small_rock
    if spoil:
        shutil.copytree(small_rock, store, copy_function=os.link)
        spoil(store)
    (tmp_path / "s.toml").write_text(felt.format(store=store, memory_mb=f"1\n{key}", value=100))
    done = palpa_run(palpa_program, "run", tmp_path / "s.toml", "--hand", "sim:stroke", "--duration-s", "0.1")
    assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.count("rock.zarr") == 1 and words in done.stderr and "; " in done.stderr and "bug" not in done.stderr, done.stderr
    done = palpa_run(palpa_program, "info", store, "--scene", "--set", "memory_mb=1", *(["--set", key.replace(" = ", "=", 1)] if key else []))
    if kind in ("coarsest", "octaves", "decimation", "neither", "frame"):
        assert done.returncode == 2 and done.stderr.count("\n") == 1 and done.stderr.count("rock.zarr") == 1, done.stderr
        assert words in done.stderr and "bug" not in done.stderr, done.stderr
