"""Stores larger than memory: written, prepared in parts, read by other programs."""

import hashlib
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time
import zlib

import numpy as np
import pytest

zarr = pytest.importorskip("zarr", reason="python3-zarr is not installed")

from stores import digest, felt, halved, how, octave_of, octaves_of, palpa_run, prepare, prepared, raw_store, run_on, shape, voxels_of

root = pathlib.Path(__file__).resolve().parents[2]
part = tuple(slice(length) for length in (60, 72, 300))  # of the voxels, with as many octaves


@pytest.mark.parametrize("kind", ["uint8", "int16", "uint16", "int32", "float32"])
def test_octaves_are_means_of_the_file(kind, prepared):
    octaves = octaves_of(prepared(kind))
    assert [octave.shape for octave in octaves] == [(150, 200, 300), (75, 100, 150), (38, 50, 75)]
    for n, octave in enumerate(octaves):
        expected = octave_of(kind, n)
        assert octave.dtype == expected.dtype and octave.chunks == (32, 32, 32)
        np.testing.assert_array_equal(octave[:], expected)


@pytest.mark.parametrize("kind", ["uint8", "float32"])
def test_facts_are_those_of_each_chunk(kind, prepared):
    store = prepared(kind)
    for n in range(len(octaves_of(store))):
        facts = zarr.open(str(store), "r")[f"palpa/facts/{n}"][0, 0]
        fine, coarse = octave_of(kind, n), octave_of(kind, n + 1)
        upper = np.repeat(np.repeat(np.repeat(coarse, 2, 0), 2, 1), 2, 2)[tuple(map(slice, fine.shape))]
        assert facts.shape == (*(-(-length // 32) for length in fine.shape), 4)
        for at in np.ndindex(facts.shape[:3]):
            box = tuple(slice(32 * index, 32 * index + 32) for index in at)
            chunk = fine[box]
            lost = chunk.astype(float) - upper[box].astype(float)
            rms = 0 if n == 2 else np.sqrt(np.nanmean(lost**2))
            found = facts[at]
            assert (found[0], found[1]) == (np.nanmin(chunk), np.nanmax(chunk))
            assert found[2] == pytest.approx(rms, rel=1e-12)
            assert found[3] == zlib.crc32(np.ascontiguousarray(chunk).tobytes())


def expect_histogram_of(values, store, program):
    """Exact over all values, in at most 256 classes whose width is a power of two."""
    (field,) = json.loads(palpa_run(program, "info", store, "--json").stdout)["store"]["fields"]
    found = field["histogram"]
    values = values[np.isfinite(values)].astype(float)
    edges = np.linspace(found["low"], found["high"], len(found["counts"]) + 1)
    np.testing.assert_array_equal(found["counts"], np.histogram(values, bins=edges)[0])
    assert 128 <= len(found["counts"]) <= 256 and sum(found["counts"]) == values.size
    assert np.frexp(edges[1] - edges[0])[0] == 0.5 and found["counts"][0] > 0 and found["counts"][-1] > 0


@pytest.mark.parametrize("kind", ["uint8", "int16", "int32", "float32"])
def test_histograms_are_those_of_numpy(kind, prepared, palpa_program):
    expect_histogram_of(voxels_of(kind), prepared(kind), palpa_program)


def test_histograms_of_many_chunks_leave_none_out(tmp_path, palpa_program):
    values = np.random.default_rng(7).normal(0, 50, (136, 136, 136)).astype(np.float32)
    values[77, 5, 99] = -4000  # in one chunk of 4913
    group = zarr.open_group(str(tmp_path / "v.zarr"), "w")
    array = group.create_dataset("0", data=values, chunks=(8, 8, 8), dimension_separator="/")
    assert array.nchunks == 4913
    group.attrs["multiscales"] = [{"version": "0.4", "axes": [{"name": axis, "type": "space"} for axis in "zyx"],
                                   "datasets": [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 1]}]}]}]
    prepare(palpa_program, tmp_path / "v.zarr")
    expect_histogram_of(values, tmp_path / "v.zarr", palpa_program)


def test_octaves_lie_half_a_voxel_further_in(prepared):
    (image,) = json.loads((prepared("uint8") / ".zattrs").read_text())["multiscales"]
    assert [axis["name"] for axis in image["axes"]] == ["z", "y", "x"]
    for n, dataset in enumerate(image["datasets"]):
        scale, shift = dataset["coordinateTransformations"]
        np.testing.assert_allclose(scale["scale"], np.array([2e-6, 1e-6, 1e-6]) * 2**n)
        np.testing.assert_allclose(shift["translation"], np.array([2e-6, 1e-6, 1e-6]) * (2**n - 1) / 2, atol=1e-20)


def write_long_file(file):
    """Voxels of five units in a row, with an octave 6 that units do not make."""
    k, j, i = np.ogrid[:33, :40, :4200]
    noise = np.random.default_rng(2).integers(0, 9, (33, 40, 4200), np.uint8)
    (100 + 50 * np.sin(i / 31 + j / 13) * np.cos(k / 5) + noise).astype(np.uint16).tofile(file)


def long_store(program, folder, name, *more):
    done = palpa_run(program, "convert", folder / "long.raw", folder / name, "--part", "1/1", "--set", "type=uint16", "--set",
                     "dims=[4200,40,33]", *more)
    assert done.returncode == 0, done.stderr
    return folder / name


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    """The long store, and the digest of it when it is prepared in one call."""
    program = pathlib.Path(os.environ["PALPA_BIN"]) / "palpa"
    if not program.exists():
        pytest.skip("the program palpa is not built")
    folder = tmp_path_factory.mktemp("reference")
    write_long_file(folder / "long.raw")
    stores = {zarr_version: long_store(program, folder, f"long{zarr_version}.zarr", "--zarr", zarr_version) for zarr_version in "23"}
    digests = {}
    for version, store in stores.items():
        shutil.copytree(store, folder / "whole.zarr")
        prepare(program, folder / "whole.zarr")
        digests[version] = digest(folder / "whole.zarr")
        shutil.rmtree(folder / "whole.zarr")
    return stores, digests


def copied(reference, folder, version="2"):
    stores, digests = reference
    shutil.copytree(stores[version], folder / "copy.zarr")
    return folder / "copy.zarr", digests[version]


@pytest.mark.parametrize("version", "23")
@pytest.mark.parametrize("count", [1, 2, 3, 4, 9])
def test_any_number_of_parts_in_any_order_gives_the_same_bytes(count, version, reference, tmp_path, palpa_program):
    store, expected = copied(reference, tmp_path, version)
    parts = list(range(1, count + 1))
    random.Random(count).shuffle(parts)
    for part in parts + parts[:1]:  # one of them twice
        prepare(palpa_program, store, "--part", f"{part}/{count}")
    prepare(palpa_program, store)
    assert digest(store) == expected


def test_prepared_twice_nothing_changes(reference, tmp_path, palpa_program):
    store, expected = copied(reference, tmp_path)
    prepare(palpa_program, store, "--threads", 3)
    again = prepare(palpa_program, store, "--threads", 1)
    assert "5 units" in again.stderr and "5 of them before" in again.stderr
    assert digest(store) == expected


def test_a_store_without_histograms_of_units_keeps_its_own_until_it_is_prepared_again(reference, tmp_path, palpa_program):
    store, expected = copied(reference, tmp_path)
    prepare(palpa_program, store)
    shutil.rmtree(store / "palpa/histograms")
    (field,) = json.loads(palpa_run(palpa_program, "info", store, "--json").stdout)["store"]["fields"]
    assert sum(field["histogram"]["counts"]) == 4200 * 40 * 33
    prepare(palpa_program, store)
    assert digest(store) == expected


def test_two_calls_at_once_give_the_same_bytes(reference, tmp_path, palpa_program):
    store, expected = copied(reference, tmp_path)
    both = [subprocess.Popen([palpa_program, "prepare", store], stderr=subprocess.DEVNULL) for _ in range(2)]
    assert [each.wait() for each in both] == [0, 0]
    assert digest(store) == expected


def test_killed_anywhere_it_continues_to_the_same_bytes(reference, tmp_path, palpa_program):
    store, expected = copied(reference, tmp_path)
    begin = time.monotonic()
    shutil.copytree(store, tmp_path / "timed.zarr")
    prepare(palpa_program, tmp_path / "timed.zarr")
    whole_s, chance = time.monotonic() - begin, random.Random(7)
    kills = 0
    for attempt in range(8):
        part = ["--part", f"{chance.randint(1, 3)}/3"] if attempt % 2 else []
        running = subprocess.Popen([palpa_program, "prepare", store, *part], stderr=subprocess.DEVNULL)
        time.sleep(chance.uniform(0.02, 0.8 * whole_s))
        running.send_signal(signal.SIGKILL)
        kills += running.wait() == -signal.SIGKILL
    assert kills > 0
    prepare(palpa_program, store)
    assert digest(store) == expected


@pytest.mark.parametrize("command", ["prepare", "convert"])
def test_a_full_disk_is_one_line_and_it_continues(command, reference, tmp_path, palpa_program):
    disk = tmp_path / "disk"
    disk.mkdir()
    used = sum(-(-path.stat().st_size // 4096) * 4096 for path in reference[0]["2"].rglob("*") if path.is_file())
    size = used + 400_000 if command == "prepare" else used // 2
    if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "none", disk], capture_output=True).returncode:
        pytest.skip("a small disk is mounted as root only")
    try:
        if command == "prepare":
            store, expected = copied(reference, disk)
            line = [palpa_program, "prepare", store]
        else:
            store, expected = disk / "copy.zarr", reference[1]["2"]
            line = [palpa_program, "convert", reference[0]["2"].parent / "long.raw", store, "--set", "type=uint16", "--set",
                    "dims=[4200,40,33]", "--part", "1/1"]
        done = palpa_run(*line)
        assert done.returncode == 2, done.stderr
        assert done.stderr.count("\n") == 1 and "make room" in done.stderr
        subprocess.run(["mount", "-o", f"remount,size={10 * used}", disk], check=True)
        assert palpa_run(*line).returncode == 0
        prepare(palpa_program, store)
        assert digest(store) | {".zattrs": 0} == expected | {".zattrs": 0}
    finally:
        subprocess.run(["umount", disk], check=True)


def test_check_names_what_is_wrong(reference, tmp_path, palpa_program):
    store, _ = copied(reference, tmp_path)
    prepare(palpa_program, store)
    good = palpa_run(palpa_program, "prepare", store, "--check")
    assert good.returncode == 0 and "as prepared" in good.stdout
    (store / "0/0/1/5").unlink()  # lost
    (store / "2/0/0/3").unlink()
    whole = (store / "1/0/0/4").read_bytes()
    (store / "1/0/0/4").write_bytes(whole[: len(whole) // 2])  # cut
    shutil.copy(store / "3/0/0/0", store / "3/0/0/2")  # exchanged
    for unit, numbers in ((2, 258), (3, 257)):
        np.arange(numbers, dtype="<f8").tofile(store / f"palpa/histograms/0/0/0/0/{unit}/0")
    bad = palpa_run(palpa_program, "prepare", store, "--check")
    assert bad.returncode == 1
    for words in ("octave 0, chunk 0/1/5 is lost", "octave 2, chunk 0/0/3 is missing", "octave 1, chunk 0/0/4 is damaged",
                  "octave 3, chunk 0/0/2 is not the mean", "the histogram of unit 0/0/2 of frame 0, field 0 is wrong",
                  "palpa/histograms/0/0/0/0/3/0: is no histogram that palpa wrote"):
        assert words in bad.stdout, bad.stdout


def test_beside_a_store_that_stays_as_it_is(reference, tmp_path, palpa_program):
    store, expected = copied(reference, tmp_path)
    before = digest(store)
    mine = tmp_path / "mine.zarr"
    prepare(palpa_program, store, "--into", mine)
    assert digest(store) == before
    made = {name: found for name, found in digest(mine).items() if "/" in name}
    assert made == {name: found for name, found in expected.items() if name.split("/")[0] in "123456" or name.startswith("palpa/")}
    octaves = octaves_of(mine)
    assert [octave.shape[2] for octave in octaves] == [2100, 1050, 525, 263, 132, 66]


@pytest.mark.parametrize("version", "23")
def test_under_mpirun_the_bytes_are_the_same(version, reference, tmp_path, palpa_program):
    if not shutil.which("mpirun"):
        pytest.skip("openmpi-bin is not installed")
    stores, digests = reference
    mpirun = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", "4"]
    raw = stores[version].parent / "long.raw"
    store = tmp_path / f"long{version}.zarr"
    subprocess.run([*mpirun, palpa_program, "convert", raw, store, "--part", "auto", "--zarr", version, "--set", "type=uint16", "--set",
                    "dims=[4200,40,33]"], check=True, capture_output=True)
    subprocess.run([*mpirun, palpa_program, "prepare", store, "--part", "auto"], check=True, capture_output=True)
    prepare(palpa_program, store)
    assert digest(store) | {".zattrs": 0, "zarr.json": 0} == digests[version] | {".zattrs": 0, "zarr.json": 0}


def test_chunks_of_others(tmp_path, palpa_program):
    """Planes, long chunks, separators and codecs of other programs, and an axis of channels."""
    values = voxels_of("uint16")[part]
    for number, (chunk, more) in enumerate([((1, 72, 300), {}), ((40, 50, 64), {"compressor": None, "dimension_separator": "."}),
                                            ((64, 16, 128), {"order": "F"}), ((60, 72, 300), {"fill_value": 3})]):
        store = tmp_path / f"other{number}.zarr"
        group = zarr.open_group(str(store), "w")
        group.create_dataset("scale0", data=values, chunks=chunk, **({"dimension_separator": "/"} | more))
        group.attrs["multiscales"] = [{"version": "0.4", "axes": [{"name": axis, "type": "space"} for axis in "zyx"],
                                       "datasets": [{"path": "scale0", "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 1]}]}]}]
        group.attrs["of others"] = {"kept": [1, 2]}
        prepare(palpa_program, store, "--part", "1/1")
        prepare(palpa_program, store)
        octaves, expected = octaves_of(store), values
        assert len(octaves) == 3 and zarr.open(str(store)).attrs["of others"] == {"kept": [1, 2]}
        for octave in octaves:
            np.testing.assert_array_equal(octave[:], expected)
            expected = halved(expected)
        assert palpa_run(palpa_program, "prepare", store, "--check").returncode == 0


turned = [[1, 0, 0], [0, 0.8, 0.6], [0, -0.6, 0.8]]


@pytest.mark.parametrize("reference", ["object", "text"])
@pytest.mark.parametrize("parts", [
    [{"type": "scale", "scale": [3, 2, 1]}],
    [{"type": "scale", "scale": [3, 2, 1]}, {"type": "translation", "translation": [5, 6, 7]}],
    [{"type": "translation", "translation": [5, 6, 7]}, {"type": "scale", "scale": [3, 2, 1]}, {"type": "rotation", "rotation": turned}]])
def test_octaves_of_version_06_lie_in_its_coordinate_systems(parts, reference, tmp_path, palpa_program):
    store = raw_store(palpa_program, tmp_path, "uint8", "--zarr", "3")
    whole = json.loads((store / "zarr.json").read_text())
    image = whole["attributes"]["ome"]["multiscales"][0]
    axes = [{"name": axis, "type": "space", "unit": "micrometer"} for axis in "zyx"]
    image["coordinateSystems"] = [{"name": "array", "axes": axes[::-1]}, {"name": "physical", "axes": axes}]
    del image["axes"]
    refer = (lambda kind, name: {kind: name}) if reference == "object" else (lambda kind, name: name)
    one = parts[0] if len(parts) == 1 else {"type": "sequence", "transformations": parts}
    image["datasets"] = [{"path": "0", "coordinateTransformations": [one | {"input": refer("path", "0"), "output": refer("name", "physical")}]}]
    whole["attributes"]["ome"]["version"] = "0.6"
    (store / "zarr.json").write_text(json.dumps(whole))
    prepare(palpa_program, store)
    assert palpa_run(palpa_program, "prepare", store, "--check").returncode == 0

    image = json.loads((store / "zarr.json").read_text())["attributes"]["ome"]["multiscales"][0]
    assert "axes" not in image and [dataset["path"] for dataset in image["datasets"]] == ["0", "1", "2"]
    for dataset in image["datasets"][1:]:
        (each,) = dataset["coordinateTransformations"]  # one, as the schema of 0.6 has it
        assert (each["input"], each["output"]) == (refer("path", dataset["path"]), refer("name", "physical"))
        assert [part["type"] for part in each["transformations"]][:2] == ["scale", "translation"]
        assert len(each["transformations"]) == 2 or "rotation" in str(parts)
    info = json.loads(palpa_run(palpa_program, "info", store, "--json").stdout)["store"]
    finest = info["octaves"][0]
    for n, octave in enumerate(info["octaves"]):
        matrix, origin = np.array(octave["index_to_world_m"]), np.array(octave["origin_m"])
        np.testing.assert_allclose(matrix, 2**n * np.array(finest["index_to_world_m"]), rtol=1e-12, atol=1e-18)
        first = np.array(finest["index_to_world_m"]) @ np.full(3, (2**n - 1) / 2) + finest["origin_m"]
        np.testing.assert_allclose(origin, first, rtol=1e-12, atol=1e-18)
    assert info["octaves_made_by"] == "means" and len(info["octaves"]) == 3


def test_arrays_of_python_are_those_of_zarr(tmp_path, palpa_program):
    import palpa

    store = raw_store(palpa_program, tmp_path, "int16")
    counts = palpa.prepare(store, part=(1, 1))
    assert counts["units"] == 1 and not counts["finished"]
    assert palpa.prepare(store)["finished"]
    assert palpa.prepare(store, check=True)["wrong"] == 0
    opened, octaves = palpa.open_store(store), octaves_of(store)
    assert [octave["dims"] for octave in opened.octaves] == [octave.shape[::-1] for octave in octaves]
    assert opened.prepared and opened.fields[0]["dtype"] == "int16" and opened.length_unit == "m"
    for n, octave in enumerate(octaves):
        np.testing.assert_array_equal(opened.read(n, tuple((0, length) for length in octave.shape[::-1])), octave[:])
    np.testing.assert_array_equal(opened.read(0, ((5, 90), (31, 33), (60, 70))), octaves[0][60:70, 31:33, 5:90])
    np.testing.assert_array_equal(opened.chunk(0, 9, 1, 4), octaves[0][128:150, 32:64, 288:300])
    for wrong in (lambda: opened.chunk(0, 10, 0, 0), lambda: opened.read(3, ((0, 1),) * 3), lambda: opened.read(0, ((0, 0),) * 3)):
        with pytest.raises(IndexError):
            wrong()
    with pytest.raises(palpa.LoadError, match="part"):
        palpa.prepare(store, part=(5, 4))


def test_dask_starts_the_parts(reference, tmp_path, palpa_program):
    pytest.importorskip("distributed", reason="python3-distributed is not installed")
    script = tmp_path / "parts.py"
    store, expected = copied(reference, tmp_path)
    script.write_text(f"""
import palpa
from distributed import Client, LocalCluster

def part(number):
    return palpa.prepare({str(store)!r}, part=(number, 4))["units"]

if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        print(sum(client.gather(client.map(part, range(1, 5)))), palpa.prepare({str(store)!r})["finished"])
""")
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=300)
    assert done.stdout == "5 True\n", done.stderr
    assert digest(store) == expected


def test_parts_of_a_map_join_to_the_same_bytes(tmp_path, palpa_program):
    def run(out, *more, launcher=()):
        line = [*launcher, palpa_program, "map", root / "scenes/head_phantom.toml", out, "--points", "24", *more]
        done = subprocess.run(list(map(str, line)), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr

    run(tmp_path / "whole.vti")
    for count in (5,):
        for part in reversed(range(1, count + 1)):
            run(tmp_path / "parts.vti", "--part", f"{part}/{count}")
        assert not (tmp_path / "parts.vti").exists()
        run(tmp_path / "parts.vti")
        assert (tmp_path / "parts.vti").read_bytes() == (tmp_path / "whole.vti").read_bytes()
        assert not list(tmp_path.glob("*.part*"))
        (tmp_path / "parts.vti").unlink()
    if shutil.which("mpirun"):
        run(tmp_path / "parts.vti", "--part", "auto", launcher=("mpirun", "--allow-run-as-root", "--oversubscribe", "-n", "2"))
        run(tmp_path / "parts.vti")
        assert (tmp_path / "parts.vti").read_bytes() == (tmp_path / "whole.vti").read_bytes()


def converted_in_parts(program, source, folder, *more):
    """A store of octave 0, written at once, and in parts of three counts with the same bytes."""
    whole = folder / "1" / "v.zarr"
    for count in (1, 2, 3):
        store = folder / str(count) / "v.zarr"
        store.parent.mkdir()
        for part in reversed(range(1, count + 1)):
            done = palpa_run(program, "convert", source, store, "--part", f"{part}/{count}", *more)
            assert done.returncode == 0, done.stderr
        assert digest(store) == digest(whole)
    return whole


def test_a_stack_of_tiff_in_parts(tmp_path, palpa_program):
    image = pytest.importorskip("PIL.Image", reason="python3-pil is not installed")
    values, stack = voxels_of("uint16"), tmp_path / "stack"
    stack.mkdir()
    for k, plane in enumerate(values):
        image.fromarray(plane).save(stack / f"s{k + 7}.tif", compression=(None, "tiff_lzw", "tiff_adobe_deflate", "packbits")[k % 4])
    spacing = ("--set", "spacing_m=[1e-6,1e-6,2e-6]")
    store = converted_in_parts(palpa_program, stack, tmp_path, *spacing)
    prepare(palpa_program, store)
    expected = values
    for octave in octaves_of(store):
        np.testing.assert_array_equal(octave[:], expected)
        expected = halved(expected)
    (tmp_path / "raw").mkdir()
    assert digest(raw_store(palpa_program, tmp_path / "raw", "uint16"))["0/.zarray"] == digest(store)["0/.zarray"]
    planes = [image.fromarray(plane) for plane in values[:3]]
    planes[0].save(tmp_path / "pages.tif", save_all=True, append_images=planes[1:])
    done = palpa_run(palpa_program, "convert", tmp_path / "pages.tif", tmp_path / "pages.zarr", *spacing)
    assert done.returncode == 0 and "warning" not in done.stderr, done.stderr
    np.testing.assert_array_equal(octaves_of(tmp_path / "pages.zarr")[0][:], values[:3])
    (stack / "s9.tif").write_bytes((stack / "s9.tif").read_bytes()[:-300])
    done = palpa_run(palpa_program, "convert", stack, tmp_path / "cut.zarr", *spacing)
    assert done.returncode == 2 and "'s9.tif' that " in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_a_file_of_rows_in_parts(tmp_path, palpa_program):
    """A vector whose bytes are in the other order, with its slices from the last, is read row by row."""
    values = np.random.default_rng(3).normal(size=(*shape[:2], 100, 3)).astype(">f4")
    header = ("NRRD0004\ntype: float\ndimension: 4\nspace dimension: 3\nsizes: 3 100 {} {}\nendian: big\nencoding: raw\n"
              "kinds: vector domain domain domain\nspace directions: none (1,0,0) (0,-1,0) (0,0,-2)\n").format(shape[1], shape[0])
    (tmp_path / "v.nrrd").write_bytes(header.encode() + b"\n" + values.tobytes())
    store = converted_in_parts(palpa_program, tmp_path / "v.nrrd", tmp_path)
    prepare(palpa_program, store)
    np.testing.assert_array_equal(octaves_of(store)[0][:], np.moveaxis(values[::-1, ::-1], -1, 0))


def smoothed(values, sigma=2.0):
    """Gaussian along each axis, cut off at four deviations, normalised within the grid."""
    reach = int(np.ceil(4 * sigma))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    for axis in range(3):
        along = lambda row: np.convolve(row, weights)[reach:-reach] / np.convolve(np.ones_like(row), weights)[reach:-reach]
        values = np.apply_along_axis(along, axis, values)
    return values


def jacobian(vectors, step):
    """[component, axis] of derivatives along x, y, z: central differences, one-sided at the border."""
    return np.array([[np.gradient(vectors[..., c], step, axis=2 - a) for a in range(3)] for c in range(3)])


def test_derived_fields_are_those_of_numpy(tmp_path, palpa_program):
    k, j, i = np.mgrid[:70, :90, :140]
    vectors = np.stack([np.sin(j / 9) + k / 90, np.sin(i / 7) * np.cos(k / 11), np.cos(i / 8 + j / 10)], -1).astype(np.float32)
    vectors.tofile(tmp_path / "v.raw")
    store = tmp_path / "v.zarr"
    done = palpa_run(palpa_program, "convert", tmp_path / "v.raw", store, "--set", "type=float32", "--set", "dims=[140,90,70]", "--set",
                     "components=last", "--set", "spacing_m=[1e-3,1e-3,1e-3]")
    assert done.returncode == 0, done.stderr
    j_of, s_of = jacobian(vectors.astype(float), 1e-3), jacobian(np.stack([smoothed(vectors[..., c].astype(float)) for c in range(3)], -1), 1e-3)
    square = np.einsum("ab...,bc...->ac...", s_of, s_of)
    expected = {"curl": np.stack([j_of[2, 1] - j_of[1, 2], j_of[0, 2] - j_of[2, 0], j_of[1, 0] - j_of[0, 1]]),
                "divergence": j_of[0, 0] + j_of[1, 1] + j_of[2, 2],
                "q": -0.5 * np.einsum("aa...->...", square),
                "lambda2": np.linalg.eigvalsh(np.moveaxis(0.5 * (square + square.swapaxes(0, 1)), (0, 1), (-2, -1)))[..., 1]}
    shutil.copytree(store, tmp_path / "parts.zarr")
    for name, values in expected.items():
        for part in ("2/3", "3/3", "1/3"):
            prepare(palpa_program, tmp_path / "parts.zarr", "--derive", f"{name}=vector", "--part", part)
        for each in (store, tmp_path / "parts.zarr"):
            prepare(palpa_program, each, "--derive", f"{name}=vector")
        made = store / "palpa/derived" / f"{name}_vector"
        assert digest(made) == digest(tmp_path / "parts.zarr/palpa/derived" / made.name)
        octaves = octaves_of(made)
        np.testing.assert_allclose(octaves[0][:], values, atol=2e-5 * np.abs(values).max())
        assert len(octaves) == 2 and octaves[0].dtype == np.float32
        assert palpa_run(palpa_program, "prepare", store, "--derive", f"{name}=vector", "--check").returncode == 0
    import palpa

    assert palpa.prepare(store, derive="q=vector")["units_done_before"] == 1
    fields = json.loads(palpa_run(palpa_program, "info", store, "--json").stdout)["fields"]
    assert [field["name"] for field in fields] == ["vector", "curl_vector", "divergence_vector", "lambda2_vector", "q_vector"]
    # A store beside memory names them like any other, and refuses to derive them anew.
    scene = felt.format(store=store, memory_mb=0.1, value=0)
    for field, says in (("v.q_vector", ""), ("q(v.vector)", "palpa prepare STORE --derive q=FIELD")):
        (tmp_path / "s.toml").write_text(scene.replace('field = "v"', f'field = "{field}"').replace('filter = "smooth"\n', ""))
        done = palpa_run(palpa_program, "run", tmp_path / "s.toml", "--hand", "sim:stroke", "--duration-s", "0.1")
        assert (done.returncode == 0) == (not says) and says in done.stderr and done.stderr.count("\n") <= 1, done.stderr
    for wrong, says in (("q=velocity", "no field 'velocity'"), ("q", "as in q=velocity"), ("coherence=vector", "as in q=velocity"),
                        ("gradient_magnitude=vector", "single values")):
        done = palpa_run(palpa_program, "prepare", store, "--derive", wrong)
        assert done.returncode == 2 and says in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_wrong_calls_are_one_line(tmp_path, palpa_program):
    voxels_of("uint8").tofile(tmp_path / "v.raw")
    (tmp_path / "empty.zarr").mkdir()
    for line, words in ((["prepare", tmp_path / "none.zarr"], "none.zarr: "), (["prepare", tmp_path / "empty.zarr"], "empty.zarr: "),
                        (["prepare", tmp_path, "--part", "3/2"], "--part 3/2: "), (["prepare", tmp_path, "--part", "auto"], "--part auto: "),
                        (["convert", tmp_path / "v.raw", tmp_path / "v.nrrd", "--part", "1/2", *how("uint8")], "--part")):
        environment = {name: value for name, value in os.environ.items() if not name.startswith(("OMPI_", "PMI_", "SLURM_"))}
        done = palpa_run(palpa_program, *line, env=environment)
        assert done.returncode == 2 and done.stderr.count("\n") == 1 and words in done.stderr and "; " in done.stderr, done.stderr
    store = raw_store(palpa_program, tmp_path, "uint8")
    again = palpa_run(palpa_program, "convert", tmp_path / "v.raw", store, *how("uint8"))
    assert again.returncode == 2 and "exists already" in again.stderr
    prepare(palpa_program, store)
    again = palpa_run(palpa_program, "convert", tmp_path / "v.raw", store, "--part", "1/2", *how("uint8"))
    assert again.returncode == 2 and "is prepared already" in again.stderr


@pytest.fixture(scope="module")
def zarrita(tmp_path_factory):
    """A folder with the package zarrita of npm and our script, where npm's registry can be reached."""
    if not shutil.which("npm"):
        pytest.skip("npm is not installed")
    folder = tmp_path_factory.mktemp("zarrita")
    try:
        done = subprocess.run(["npm", "install", "--no-audit", "--no-fund", "zarrita@0.7"], cwd=folder, capture_output=True, timeout=60)
    except subprocess.TimeoutExpired:
        pytest.skip("npm's registry does not answer")
    if done.returncode != 0:
        pytest.skip("npm's registry cannot be reached")
    shutil.copy(pathlib.Path(__file__).with_name("read_store.mjs"), folder)
    return folder


@pytest.mark.parametrize("version", "23")
def test_zarrita_reads_the_same_voxels(version, zarrita, reference, tmp_path, palpa_program):
    store, _ = copied(reference, tmp_path, version)
    prepare(palpa_program, store)
    paths = [str(n) for n in range(7)]
    done = subprocess.run(["node", "read_store.mjs", store, *paths], cwd=zarrita, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    expected = np.fromfile(reference[0]["2"].parent / "long.raw", np.uint16).reshape(33, 40, 4200)
    for n, line in enumerate(done.stdout.splitlines()):
        assert line.split() == [str(n), "uint16", "x".join(map(str, expected.shape)), hashlib.sha256(expected.tobytes()).hexdigest()]
        expected = halved(expected)
    assert n == 6


def test_vectors_are_three_channels(tmp_path, palpa_program):
    values = np.random.default_rng(5).normal(size=(60, 72, 300, 3)).astype(np.float32)
    values.tofile(tmp_path / "v.raw")
    store = tmp_path / "v.zarr"
    done = palpa_run(palpa_program, "convert", tmp_path / "v.raw", store, *how("float32", values.shape), "--set", "components=last")
    assert done.returncode == 0, done.stderr
    for octave in octaves_of(store):
        np.testing.assert_array_equal(octave[:], np.moveaxis(values, -1, 0))
        values = np.stack([halved(values[..., c]) for c in range(3)], -1)
    assert palpa_run(palpa_program, "prepare", store, "--check").returncode == 0
    import palpa

    opened = palpa.open_store(store)
    assert [(field["name"], field["components"]) for field in opened.fields] == [("vector", 3)]
    np.testing.assert_array_equal(opened.chunk(0, 1, 1, 1), np.moveaxis(octaves_of(store)[0][:, 32:64, 32:64, 32:64], 0, -1))


@pytest.mark.parametrize("kind, coarser", [("int8", "int8"), ("uint32", "uint32"), ("float16", "float32")])
def test_octaves_of_types_that_only_files_have(kind, coarser, tmp_path, palpa_program):
    store = tmp_path / f"{kind}.zarr"
    values = (voxels_of("uint16") % 256 - 128.0).astype(kind) if kind != "uint32" else voxels_of("uint8").astype("uint32") * 16_843_009
    group = zarr.open_group(str(store), "w")
    group.create_dataset("0", data=values, chunks=(64, 64, 64), dimension_separator="/")
    group.attrs["multiscales"] = [{"version": "0.4", "axes": [{"name": axis, "type": "space"} for axis in "zyx"],
                                   "datasets": [{"path": "0"}]}]
    prepare(palpa_program, store, "--part", "1/1")
    prepare(palpa_program, store)
    octaves, expected = octaves_of(store), values
    assert len(octaves) == 3
    for octave in octaves:
        np.testing.assert_array_equal(octave[:], expected)
        assert octave.dtype == expected.dtype
        expected = halved(expected.astype(coarser))
    assert palpa_run(palpa_program, "prepare", store, "--check").returncode == 0
    whole = run_on(palpa_program, tmp_path, store, 1000, "whole", value=float(np.median(values)))
    windows = run_on(palpa_program, tmp_path, store, 1, "windows", tmp_path / "whole" / "ticks.csv", value=float(np.median(values)))
    assert windows.keys() == whole.keys()
