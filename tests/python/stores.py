"""Helpers of the tests of stores: voxels, stores of them, scenes that feel them."""

import csv
import functools
import hashlib
import os
import pathlib
import subprocess

import numpy as np
import pytest

zarr = pytest.importorskip("zarr", reason="python3-zarr is not installed")

shape = (150, 200, 300)  # z, y, x: neither a multiple of a chunk nor even in every octave


@functools.cache
def voxels_of(kind):
    k, j, i = np.ogrid[: shape[0], : shape[1], : shape[2]]
    noise = np.random.default_rng(1).integers(0, 20, shape, np.uint8)
    values = (128 + 60 * np.sin(i / 9) * np.cos(j / 7) + 40 * np.sin(k / 11) + noise).clip(0, 255)
    if kind == "float32":
        values = values.astype(np.float32) / 7
        values[20:25, 30:40, 50:60] = np.nan
    else:
        values = values.astype(np.uint8) if kind == "uint8" else (values * 37 - 3000).astype(kind)
    values.flags.writeable = False
    return values


@functools.cache
def octave_of(kind, n):
    return halved(octave_of(kind, n - 1)) if n else voxels_of(kind)


def halved(fine):
    """Means over the voxels that exist: of whole numbers rounded half up."""
    whole = np.issubdtype(fine.dtype, np.integer)
    sums, count = fine.astype(np.int64 if whole else np.float64), np.ones(fine.shape, np.int64)
    for axis in range(3):
        odd = sums.shape[axis] % 2
        pad = [(0, odd if a == axis else 0) for a in range(3)]
        sums, count = np.pad(sums, pad), np.pad(count, pad)
        even = tuple(slice(0, None, 2) if a == axis else slice(None) for a in range(3))
        other = tuple(slice(1, None, 2) if a == axis else slice(None) for a in range(3))
        sums, count = sums[even] + sums[other], count[even] + count[other]
    return ((2 * sums + count) // (2 * count) if whole else sums / count).astype(fine.dtype)


def palpa_run(program, *arguments, **more):
    return subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, **more)


def how(kind, shape=shape):
    return ["--set", f"type={kind}", "--set", f"dims=[{shape[2]},{shape[1]},{shape[0]}]", "--set", "spacing_m=[1e-6,1e-6,2e-6]"]


def raw_store(program, folder, kind, *more, name="v.zarr"):
    """A store of octave 0 alone, written in two parts."""
    voxels_of(kind).tofile(folder / "v.raw")
    for part in ("2/2", "1/2"):
        done = palpa_run(program, "convert", folder / "v.raw", folder / name, "--part", part, *how(kind), *more)
        assert done.returncode == 0, done.stderr
    return folder / name


def digest(store):
    """Names and bytes of all files."""
    files = sorted(path for path in store.rglob("*") if path.is_file())
    return {str(path.relative_to(store)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def prepare(program, store, *more, **also):
    done = palpa_run(program, "prepare", store, *more, **also)
    assert done.returncode == 0, done.stderr
    return done


def octaves_of(store):
    group = zarr.open(str(store), "r")
    paths = [each["path"] for each in group.attrs["multiscales"][0]["datasets"]]
    return [group[path] for path in paths]


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """Prepared stores by kind of voxel and options of `convert`, each made once: not to be written."""
    program = pathlib.Path(os.environ["PALPA_BIN"]) / "palpa"
    if not program.exists():
        pytest.skip("the program palpa is not built")

    @functools.cache
    def made(kind, *more):
        store = raw_store(program, tmp_path_factory.mktemp(kind), kind, *more)
        prepare(program, store)
        return store

    return made


felt = """palpa = 1
[coupling]
stiffness_n_per_m = 400
[volume.v]
file = "{store}"
memory_mb = {memory_mb}
filter = "smooth"
[workspace]
fit = "v"
[[mode]]
name = "surface"
type = "surface_and_friction"
field = "v"
[[mode.level]]
name = "wall"
value = {value}
strength_n = 2
friction_coefficient = 0.3
"""


def run_on(program, folder, store, memory_mb, out, hand="sim:stroke", value=140):
    scene = folder / f"{out}.toml"
    scene.write_text(felt.format(store=store, memory_mb=memory_mb, value=value))
    done = palpa_run(program, "run", scene, "--hand", hand, "--duration-s", "1", "--primitives", "--out", folder / out)
    assert done.returncode == 0, done.stderr
    kept = {path.name: path.read_text() for path in (folder / out).glob("*.csv") if path.name not in ("timing.csv", "chunks.csv")}
    kept["ticks.csv"] = without_octaves(kept["ticks.csv"])
    return kept


def without_octaves(ticks):
    """The columns that a trace of a volume in memory has as well."""
    rows = list(csv.reader(ticks.splitlines()))
    columns = [n for n, name in enumerate(rows[0]) if name not in ("felt_octave", "forced_octave")]
    return "\n".join(",".join(row[n] for n in columns) for row in rows)
