#!/usr/bin/env python3
"""Minimal renderer, and a template for adapters of other renderers: a spring on the penetration that value and slope at the
probe give to first order. No proxy, no memory, standard library only.

    penalty.py CASE.json
"""
import array
import json
import math
import pathlib
import sys

case_file = pathlib.Path(sys.argv[1])
case = json.loads(case_file.read_text())
rule, told = case["rule"], case["volume"]
if rule["kind"] != "surface" or rule["friction_coefficient"] > 0:
    print("unsupported: surfaces without friction alone", flush=True)
    sys.exit()

voxels = array.array({"uint8": "B", "uint16": "H", "int16": "h"}[told["type"]])
voxels.frombytes((case_file.parent / told["file"]).read_bytes()[told["header_bytes"]:])
size, spacing, origin = told["size"], told["spacing_m"], told["origin_m"]
levels = [level["value"] for level in rule["levels"]]
stiffness, limit = case["stiffness_n_per_m"], case["force_limit_n"]


def value_and_slope(x):
    """Trilinear value at x, and its exact slope; None outside."""
    low, share = [], []
    for a in range(3):
        at = (x[a] - origin[a]) / spacing[a]
        if not 0 <= at <= size[a] - 1:
            return None
        low.append(min(int(at), size[a] - 2))
        share.append(at - low[a])
    value, slope = 0.0, [0.0, 0.0, 0.0]
    for corner in range(8):
        upper = [corner >> a & 1 for a in range(3)]
        weight = [share[a] if upper[a] else 1 - share[a] for a in range(3)]
        i, j, k = (low[a] + upper[a] for a in range(3))
        voxel = voxels[(k * size[1] + j) * size[0] + i]
        value += weight[0] * weight[1] * weight[2] * voxel
        for a in range(3):
            others = weight[(a + 1) % 3] * weight[(a + 2) % 3]
            slope[a] += (1 if upper[a] else -1) * others * voxel / spacing[a]
    return value, slope


def force(x):
    here = value_and_slope(x)
    passed = [level for level in levels if here and here[0] > level]
    steepness = math.hypot(*here[1]) if here else 0.0
    if not passed or steepness == 0.0:
        return 0.0, 0.0, 0.0
    deep = min((here[0] - passed[-1]) / steepness, 0.005)  # a nearly flat slope does not locate the level
    pushed = min(stiffness * deep, limit)
    return tuple(-pushed * s / steepness for s in here[1])


print("ready", flush=True)
for line in sys.stdin:
    print(*force([float(word) for word in line.split()[1:]]), flush=True)
