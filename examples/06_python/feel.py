"""Feel an array: a ball of 80³ voxels with a hard core, along a path of the hand; prints the forces.

    PYTHONPATH=build/release/python python3 examples/06_python/feel.py
"""

import numpy as np

import palpa

# Voxels in a numpy array, indexed [z, y, x]; Palpa uses them in place.
z, y, x = np.mgrid[-1:1:80j, -1:1:80j, -1:1:80j]
ball = (1000 * np.exp(-4 * (x**2 + y**2 + z**2))).astype(np.int16)

scene = palpa.Scene(stiffness_n_per_m=600)
field = scene.add_array("ball", ball, spacing_m=0.001)
scene.add("shells", palpa.SurfaceAndFriction(field=field, friction_n=0.1, levels=[
    dict(name="rind", value=400, strength_n=1.0), dict(name="core", value=800, strength_n=4.0)]))

# Down onto the ball and through its rind, then sideways: one tick of a millisecond per position.
down = np.linspace(0.07, 0.005, 1500)
aside = np.linspace(0, 0.015, 500)
hand_m = np.vstack([np.column_stack([0 * down, 0 * down, down]), np.column_stack([aside, 0 * aside, 0 * aside + 0.005])])
session = palpa.Session(scene)
rows = session.ticks(hand_m, 1e-3)
force_n = np.linalg.norm(rows["force_n"], axis=1)
gives_way = np.flatnonzero(np.diff(force_n) < -0.3)  # ticks of a break-through
rind, core = force_n[gives_way[0]], force_n[gives_way[-1]]
print(f"the rind bears {rind:.2f} N, and gives way after {gives_way[0]} ms; the core bears {core:.2f} N")
assert abs(rind - 1.0) < 0.05 and abs(core - 4.0) < 0.05

# The field itself, at a hundred thousand positions at once.
values, gradients = scene.field(field)(np.random.default_rng(0).uniform(-0.03, 0.03, (100_000, 3)))
print(f"mean value {np.nanmean(values):.1f}, steepest {np.linalg.norm(gradients, axis=1).max():.0f} per metre")
