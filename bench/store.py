#!/usr/bin/env python3
"""Time and memory of preparing a store beside reading it, and beside Dask arrays that make the same octaves, in one run:

    bench_store make big.zarr 512 2
    python3 bench/store.py PALPA big.zarr [--no-dask] [--rounds 3]

Needs python3-zarr; for the last row python3-dask. Each round runs all of them, so that a busy machine slows all; the ratios are
of medians. Files are dropped from the page cache before each (by posix_fadvise)."""

import argparse
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import time


def drop(folder):
    os.sync()
    for path in folder.rglob("*"):
        if path.is_file():
            with open(path, "rb") as file:
                os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)


def timed(arguments):
    """Seconds, and peak memory of the largest process [MB]."""
    begin = time.monotonic()
    process = subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    words = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(words.decode())
    return time.monotonic() - begin, usage.ru_maxrss / 1e3


def pyramid(store, out):
    """The octaves by Dask arrays: means of 2 x 2 x 2, rounded half up, each from the stored one before."""
    import dask.array as da
    import numpy as np
    import zarr

    compressor = zarr.Blosc(cname="lz4", clevel=5, shuffle=2)
    fine, number = da.from_zarr(store, component="0"), 0
    while max(fine.shape) > 128:
        number += 1
        sums = da.coarsen(np.sum, fine.astype(np.uint16), {0: 2, 1: 2, 2: 2}, trim_excess=True)
        coarse = ((sums + 4) // 8).astype(fine.dtype).rechunk((32, 32, 32))
        coarse.to_zarr(out, component=str(number), compressor=compressor)
        fine = da.from_zarr(out, component=str(number))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("palpa")
    parser.add_argument("store", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--no-dask", action="store_true")
    given = parser.parse_args()
    out = given.store.with_name(given.store.name + ".bench")
    runs = {"cat": ["sh", "-c", f"find '{given.store}/0' -type f -print0 | xargs -0 cat > /dev/null"],
            "palpa prepare": [given.palpa, "prepare", given.store, "--into", out],
            "palpa prepare --part 1/1": [given.palpa, "prepare", given.store, "--into", out, "--part", "1/1"]}
    if not given.no_dask:
        runs["Dask arrays"] = [sys.executable, __file__, "pyramid", given.store, out]
    figures = {name: [] for name in runs}
    for _ in range(given.rounds):
        for name, arguments in runs.items():
            shutil.rmtree(out, ignore_errors=True)
            drop(given.store)
            figures[name].append(timed(arguments))
    shutil.rmtree(out, ignore_errors=True)
    base = [statistics.median(each[n] for each in figures["palpa prepare"]) for n in (0, 1)]
    print("| | s | of prepare | peak MB of a process | of prepare |\n|---|---|---|---|---|")
    for name, rows in figures.items():
        seconds, megabytes = (statistics.median(each[n] for each in rows) for n in (0, 1))
        print(f"| {name} | {seconds:.1f} | {seconds / base[0]:.2f} | {megabytes:.0f} | {megabytes / base[1]:.2f} |")


if __name__ == "__main__":
    if len(sys.argv) == 4 and sys.argv[1] == "pyramid":
        pyramid(sys.argv[2], sys.argv[3])
    else:
        main()
