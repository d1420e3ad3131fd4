"""Costs of the Python binding.

    PYTHONPATH=build/release/python python3 bench/python_costs.py [build/bench/bin/bench_python_path]

The argument: a C++ program that runs the identical path (bench/python_path.cpp).
"""

import resource
import subprocess
import sys
import time

import numpy as np

import palpa


# Processor time of all threads, independent of other load.
clock = time.process_time


def best(work, repeats=5):
    times = []
    for _ in range(repeats):
        begin = clock()
        work()
        times.append(clock() - begin)
    return min(times)


def scene():
    made = palpa.Scene(stiffness_n_per_m=400)
    made.add("head", palpa.head_phantom())
    made.add("skin", palpa.SurfaceAndFriction(field="head", levels=[dict(value=-300, strength_n=0.8, friction_n=0.1)]))
    return made


def path(n):
    t = np.arange(n) * 1e-3
    return np.stack([0.03 * np.sin(t), 0.02 * np.cos(0.7 * t), 0.075 + 0.015 * np.sin(2 * t)], axis=1)


n = 200_000
where = path(n)
at_once = best(lambda: palpa.Session(scene()).ticks(where, 1e-3), 3)
session, rows = palpa.Session(scene()), [tuple(row) for row in where]


def one_by_one():
    tick = session.tick
    for row in rows:
        tick(row, 1e-3)


single = best(one_by_one, 3)
print(f"a path as an array: {1e6 * at_once / n:.3f} us a tick")
print(f"tick by tick: {1e6 * single / n:.3f} us a tick, {1e6 * (single - at_once) / n:.3f} us more")
if len(sys.argv) > 1:
    cpp = min(float(subprocess.run([sys.argv[1], str(n)], capture_output=True, text=True, check=True).stdout) for _ in range(3))
    print(f"the same path in C++: {cpp:.3f} us a tick; as an array {1e6 * at_once / n / cpp:.3f} times that")

for shape in ((256,) * 3, (512,) * 3):
    array = np.random.default_rng(0).integers(-1000, 2000, shape, dtype=np.int16)

    def resident_mb():
        return int(open("/proc/self/statm").read().split()[1]) * 4096 / 2**20

    before = resident_mb()
    took = best(lambda: palpa.array_volume(array, 0.001), 3)
    added = best(lambda: palpa.Scene().add_array("data", array, 0.001), 3)
    print(f"array of {shape[0]}^3 int16 ({array.nbytes / 2**20:.0f} MiB) to a volume: {1e3 * took:.3f} ms, into a scene: "
          f"{1e3 * added:.1f} ms, {resident_mb() - before:.1f} MiB more memory; numpy.copy {1e3 * best(array.copy, 3):.1f} ms")
    (field,) = palpa.array_volume(array, 0.001).fields.values()
    for name, spread in (("along a way", None), ("anywhere", 1)):
        points = np.random.default_rng(1).uniform(-0.1, 0.1, (4_000_000, 3))
        if spread is None:
            points = np.sort(points, axis=0)
        took = best(lambda: field(points), 3)
        begin = time.perf_counter()
        field(points)
        print(f"  trilinear samples with gradients, {name}: {len(points) / took / 1e6:.1f} M/s and core, "
              f"{len(points) / (time.perf_counter() - begin) / 1e6:.1f} M/s on all")


# A rollout of 64 paths of 10 s. On free cores the caller's share runs alone, the rest on all threads.
def spent_s(who):
    usage = resource.getrusage(who)
    return usage.ru_utime + usage.ru_stime


scene_of_all, paths, one_s = scene(), [path(10_000) + [1e-4 * i, 0, 0] for i in range(64)], 0.0
for threads in (1, 2):
    wall_s, all_s, alone_s = time.monotonic(), spent_s(resource.RUSAGE_SELF), spent_s(resource.RUSAGE_THREAD)
    palpa.rollout(scene_of_all, paths, 1e-3, threads=threads)
    wall_s, all_s = time.monotonic() - wall_s, spent_s(resource.RUSAGE_SELF) - all_s
    alone_s = spent_s(resource.RUSAGE_THREAD) - alone_s
    one_s = one_s or all_s
    free = one_s / (alone_s + (all_s - alone_s) / threads)
    print(f"rollout, {threads} threads: {wall_s:.2f} s, of processors {all_s:.2f} s, on free cores {free:.2f} times as fast as one")
