#!/usr/bin/env python3
"""The testable claims of the paper of 2005, measured: prints the table of docs/reproduction.md.

reproduction.py [FOLDER]      also draws its figure into FOLDER

A verdict is read from the numbers, never written beside them. The same numbers on every run of one machine; about a minute."""

import functools
import math
import sys

import numpy as np

from common import *
from paper_figures import plane_and_point

k_n_per_m = 400.0  # of every claim that names no other
exact_m, exact_n = 1e-12, 1e-9  # zero of a claim's "exactly": far below an encoder's step
strength_n = 1.2
claims = []


def claim(text, condition=""):
    """Registers a claim, whose function returns (measurement, whether it holds). condition: of its validity."""
    def take(measure):
        claims.append((text, condition, measure))
        return measure
    return take


def balance(law, primitives, probe_m, start_m=(0, 0, 0)):
    return law.solve(primitives, start_m, probe_m, k_n_per_m)


def largest(*values):
    return max((np.max(np.abs(value)) for value in values), default=0.0)


@claim("a plane keeps the proxy on it while the feedback is below its strength (Fig. 3 a-c)")
def plane_holds():
    law, wall = figure_laws.Law("exact"), [plane((0, 1, 0), strength_n)]
    off_m = largest([balance(law, wall, (0, -strength_n / k_n_per_m * i / 1000.0, 0))[0][1] for i in range(1001)])
    return f"furthest from the plane {off_m:.1e} m, 1001 depths", off_m <= exact_m


@claim("beyond it the proxy follows below the plane, s/k from the probe (Fig. 3 d)")
def plane_gives_way():
    law, off_m, jump, before_m, step_m = figure_laws.Law("exact"), 0.0, 0.0, np.zeros(3), 1e-5
    for i in range(2001):
        probe_m = np.array([0, -step_m * (i if i <= 1000 else 2000 - i), 0])
        proxy_m = balance(law, [plane((0, 1, 0), strength_n)], probe_m, before_m)[0]
        if -probe_m[1] > strength_n / k_n_per_m + exact_m:
            off_m = max(off_m, abs(norm(proxy_m - probe_m) - strength_n / k_n_per_m))
        jump, before_m = max(jump, norm(proxy_m - before_m) / step_m if i else 0.0), proxy_m
    return (f"off s/k by {off_m:.1e} m at most; on the way in and out the proxy moves by {jump:.3f} of the hand's step at most",
            off_m <= exact_m and jump <= 1.0 + 1e-9)


@claim("points and lines do likewise")
def point_and_line():
    law, draw, held_m, slipped_m, along_m = figure_laws.Law("exact"), Draw(3, 16384), 0.0, 0.0, 0.0
    for primitive in (point(strength_n), line((0, 0, 1), strength_n)):
        for _ in range(2000):
            probe_m = draw.in_cube(0.006)
            proxy_m = balance(law, [primitive], probe_m)[0]
            if primitive[0] == "line":
                along_m = max(along_m, abs(proxy_m[2] - probe_m[2]))
            if k_n_per_m * norm(residual(primitive, probe_m)) <= strength_n:
                held_m = max(held_m, norm(residual(primitive, proxy_m)))
            else:
                slipped_m = max(slipped_m, abs(norm(proxy_m - probe_m) - strength_n / k_n_per_m))
    return (f"off what holds {held_m:.1e} m, off s/k {slipped_m:.1e} m, along the line {along_m:.1e} m at most, 4000 pulls",
            max(held_m, slipped_m, along_m) <= exact_m)


@claim("a plane and a point balance the spring (Fig. 2)")
def plane_and_point_balance():
    forces_n = plane_and_point()[3]
    left_n, of_plane, of_point, of_spring = norm(forces_n[0] + forces_n[1] + forces_n[2]), *map(norm, forces_n)
    return f"{of_plane:.2f} N and {of_point:.2f} N against {of_spring:.2f} N: {left_n:.1e} N left over", left_n <= exact_n


bisector, across = np.array([0, -1.0, 0]), np.array([1.0, 0, 0])


def share_of_way(law, angle_deg, direction):
    """The proxy of two planes without strength, as a share of the hand's path [1]."""
    return (law_of_planes(law, angle_deg, 0.01 * direction) * direction).sum() / 0.01


@claim("added moves are exact for orthogonal constraints only (Fig. 5)")
def orthogonality():
    angles = np.arange(10, 171, 5)
    missed = np.array([abs(share_of_way("ikits-2003", angle, bisector) - 1.0) for angle in angles])
    law_off = largest(missed - [abs(math.cos(angle * math.pi / 180.0)) for angle in angles.tolist()])
    ours = largest([share_of_way("exact", angle, bisector) - 1.0 for angle in angles])
    right_angle = missed[angles == 90][0]
    return (f"at 90 degrees they miss the probe by {right_angle:.1e} of the way, at 60 by {missed[angles == 60][0]:.3f}; "
            f"off |cos| by {law_off:.1e}; the balance misses by {ours:.1e} at any angle", max(right_angle, law_off, ours) < 1e-9)


@claim("the individual movements are too large", "along what the axes share; across it they are too small")
def too_large():
    along, sideways = (share_of_way("ikits-2003", 60.0, direction) for direction in (bisector, across))
    return f"at 60 degrees {along:.3f} of the way along the bisector, {sideways:.3f} across it", along > 1.0 > sideways


@claim("any set of primitives may be combined")
def any_set():
    draw, bound_m, order_m, sets = Draw(7, 2**21), 0.0, 0.0, 20000
    kinds = ("point", "line", "plane", "directed")
    for _ in range(sets):
        primitives = [None] * (1 + draw.below(12))
        for i in range(len(primitives)):
            kind = kinds[draw.below(4)]
            primitives[i] = (kind, draw.in_cube(1e-3), draw.direction(), draw.uniform(0.1, 3.0), 0.0)
        probe_m = draw.in_cube(5e-3)
        first = balance(figure_laws.Law("exact"), primitives, probe_m)
        for n in range(len(primitives), 1, -1):
            other = draw.below(n)
            primitives[n - 1], primitives[other] = primitives[other], primitives[n - 1]
        second = balance(figure_laws.Law("exact"), primitives, probe_m)
        bound_m, order_m = max(bound_m, first[2], second[2]), max(order_m, norm(first[0] - second[0]))
    return (f"{sets} sets of 1 to 12: proven within {bound_m:.1e} m of their one balance; another order moves it by {order_m:.1e} m "
            "at most", bound_m < 1e-6 and order_m <= 2.0 * bound_m)


@claim("force functions and proxy methods are special cases")
def unifies():
    draw, earlier, off_n, step_m = Draw(8, 2**19), figure_laws.Law("ikits-2003"), 0.0, 0.0
    for _ in range(5000):
        direction, force_n, probe_m = draw.direction(), draw.uniform(0, 3), draw.in_cube(5e-3)
        law = figure_laws.Law("exact")
        felt_n = k_n_per_m * (balance(law, [directed(direction, force_n)], probe_m)[0] - probe_m)
        off_n = max(off_n, norm(felt_n - force_n * direction))
        x = draw.direction()
        y = normalized(np.cross(x, draw.direction()))
        axes = [plane(axis, draw.uniform(0, 3)) for axis in (x, y, np.cross(x, y))]
        law.reset()
        earlier.reset()
        step_m = max(step_m, norm(balance(law, axes, probe_m)[0] - balance(earlier, axes, probe_m)[0]))
    return (f"a directed force alone is felt as itself to {off_n:.1e} N; orthogonal planes step as in 2003 to {step_m:.1e} m, 5000 "
            "of each", off_n <= exact_n and step_m <= exact_m)


@claim("a plane and a line make a surface with friction (Fig. 4)")
def friction():
    line_n, depth_m = 0.3, 0.004
    probe_mm, proxy_mm, friction_n, normal_n = (each[:1000] for each in friction_loop(depth_m, 3.0, line_n, k_n_per_m, 0.005, 1000))
    cone_mm = 1e3 * line_n / k_n_per_m
    slid_mm, kinetic_n = largest(proxy_mm[probe_mm <= cone_mm]), largest(np.abs(friction_n[probe_mm > cone_mm + 1e-9]) - line_n)
    off_n = largest(normal_n - k_n_per_m * depth_m)
    return (f"within the cone it slides {slid_mm:.1e} mm; beyond it {kinetic_n:.1e} N from the line's strength; {off_n:.1e} N from k "
            "depth", slid_mm <= 1e-9 and kinetic_n <= exact_n and off_n <= exact_n)


core_m = 0.01


def felt_in_vortex(mode, positions_m):
    """A session of one mode in a vortex along the world's z axis, after a tick at each of these positions of the world [m]:
    its proxies, there, its forces [N], turned so, and the primitives of the last balance."""
    scene = palpa.Scene(stiffness_n_per_m=k_n_per_m)
    mode.field = scene.add("vortex", palpa.lamb_oseen_vortex(circulation_m2_per_s=0.02, core_radius_m=core_m))
    scene.add("mode", mode)
    to_world = scene.hand_to_world()
    turn, session = to_world[:3, :3] / np.cbrt(np.linalg.det(to_world[:3, :3])), figure_laws.Session(scene)
    proxies_m, forces_n, _ = session.ticks(np.linalg.solve(to_world[:3, :3], (positions_m - to_world[:3, 3]).T).T)
    placed = [(turn @ direction, strength) for direction, strength, _ in session.last_primitives()]
    return proxies_m @ to_world[:3, :3].T + to_world[:3, 3], forces_n @ turn.T, placed, to_world


@claim("the follow mode restricts motion across the field")
def follows():
    radius_m, ticks = 0.02, np.arange(6000)
    scale = np.cbrt(np.linalg.det(felt_in_vortex(palpa.Follow(strength_n=2.0), np.zeros((1, 3)))[3][:3, :3]))
    # The hand pulls outwards by half of the rail's strength, and leads the proxy round three times.
    turn = 2 * np.pi * np.maximum(0, ticks - 300) / 1900.0
    radial = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    out_m = radius_m + scale * 0.5 * 2.0 / k_n_per_m * np.minimum(1.0, ticks / 300.0)
    proxies_m, forces_n, _, _ = felt_in_vortex(palpa.Follow(strength_n=2.0), out_m[:, None] * radial)
    drift_m = largest(np.linalg.norm(proxies_m, axis=1) - radius_m)
    across_n = largest((forces_n * radial).sum(axis=1))
    along_n = largest((forces_n * np.cross((0, 0, 1), radial)).sum(axis=1)[301:])
    return (f"three turns round a vortex, pulled outwards: {across_n:.3f} N across the flow, {along_n:.3f} N along it, drift "
            f"{1e3 * drift_m:.1e} mm of 20 mm", drift_m < 0.05 * radius_m and along_n < 0.05 and across_n > 0.9)


@functools.cache
def core_directions():
    """At each of 36 radii [core radii] and of plane and force: (angle to the core [degrees], strength [N]) of the primitive
    there."""
    radii, rows = 0.05 * np.arange(1, 37), []
    for mode in (palpa.VortexPlane, palpa.VortexForce):
        for radius in radii:
            places_m = np.outer(radius * core_m + 5e-6 * np.arange(20), (1, 0, 0))
            placed = [p for p in felt_in_vortex(mode(strength_n=1.0), places_m)[2] if p[1] > 0]
            rows.append((np.degrees(np.arccos(np.clip(-placed[-1][0][0], -1, 1))), placed[-1][1]) if placed else (0.0, 0.0))
    return radii, np.array(rows).reshape(2, 36, 2)


@claim("the vortex plane conveys place, shape and extension better than the force",
       "for shape and extension: the plane lets in and holds back, so it has an inside, and a force has none; the place both convey "
       "alike. What people recognise was measured neither by the paper nor here")
def vortex_plane():
    acting = core_directions()[1]
    share = np.abs(np.arange(8001) / 4000.0 - 1.0)
    felt_n = [np.linalg.norm(felt_in_vortex(mode(strength_n=1.0), np.outer(0.0001 + 0.03 * share, (1, 0, 0)))[1], axis=1)
              for mode in (palpa.VortexPlane, palpa.VortexForce)]
    (plane_in, plane_out), (force_in, force_out) = ((each[:4001].max(), each[4001:].max()) for each in felt_n)
    counts, degrees = (acting[:, :, 1] > 0).sum(axis=1), acting[:, :, 0].max(axis=1)
    return (f"plane and force point to the core within {degrees[0]:.2f} and {degrees[1]:.2f} degrees; the hand feels outwards "
            f"{plane_out:.2f} N and inwards {plane_in:.2f} N at most with the plane, {force_out:.2f} N and {force_in:.2f} N with the "
            f"force; they act at {counts[0]} and {counts[1]} of 36 radii", degrees[0] < 1.0 and plane_in < 0.05 * plane_out)


@claim("a point makes viscosity", "a strength alone is dry friction, the same at any speed; viscosity takes a drag")
def viscosity():
    off_n = []
    for wet in (False, True):
        for speed in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5):
            scene = palpa.Scene(stiffness_n_per_m=k_n_per_m)
            scene.add("syrup", palpa.Viscosity(drag_ns_per_m=2.0) if wet else palpa.Viscosity(strength_n=0.5))
            probes_m = np.outer(speed * tick_s * (np.arange(2000) - 1000), (1, 0, 0))
            off_n.append(norm(figure_laws.Session(scene).ticks(probes_m)[1][-1]) - (2.0 * speed if wet else 0.5))
    dry_n, wet_n = largest(off_n[:6]), largest(off_n[6:])
    return (f"with a strength the force is 0.5 N at 0.01 to 0.5 m/s, to {dry_n:.1e} N; with a drag 2 N s/m x speed, to {wet_n:.1e} N",
            max(dry_n, wet_n) < 1e-6)


@functools.cache
def paper_errors():
    """Sets in contact, two planes and a line at the proxy: error of the paper's solver [N] and its steps, 5000 of each."""
    draw, paper, rows = Draw(13, 2**18), figure_laws.Law("paper-2005"), []
    for _ in range(5000):
        primitives = [plane(draw.direction(), draw.uniform(0.5, 3)), plane(draw.direction(), draw.uniform(0.5, 3)),
                      line(draw.direction(), draw.uniform(0.1, 1))]
        probe_m = draw.in_cube(5e-3)
        paper.reset()
        theirs_m, _, _, steps = balance(paper, primitives, probe_m)
        rows.append((k_n_per_m * norm(theirs_m - balance(figure_laws.Law("exact"), primitives, probe_m)[0]), steps))
    return np.sort(np.array(rows).T, axis=1)


@claim("an adaptive step-length solver suffices in the loop", "where an error that can be felt is allowed in few sets")
def adaptive_solver():
    off_n, steps = paper_errors()
    percentile = lambda values, share: values[int(share * (len(values) - 1))]
    felt_n = 0.05  # a tenth of a force of half a newton: about a hand's threshold
    share = np.mean(off_n > felt_n)
    return (f"two planes and a line at random angles, one frame: the force is off by {percentile(off_n, 0.5):.3f} N in half of "
            f"{len(off_n)} sets, by more than {felt_n} N in {100 * share:.0f} % and by {percentile(off_n, 0.99):.2f} N in the worst "
            f"1 %; {percentile(steps, 0.5):.0f} steps in half, {steps[-1]:.0f} at most", share < 0.1)


@claim("surfaces that can be pressed through, without an intermediate surface")
def layers():
    scene, strengths_n = palpa.Scene(stiffness_n_per_m=k_n_per_m), np.array([0.5, 1.0, 2.0])
    levels = [dict(value=0.01 * i, strength_n=each) for i, each in enumerate(strengths_n)]
    scene.add("skins", palpa.SurfaceAndFriction(field=scene.add("wall", palpa.plane_field()), levels=levels))
    to_world = scene.hand_to_world()
    wall_m = np.linalg.solve(to_world, (0, 0, 0, 1))[:3]
    into = normalized(to_world[:3, :3].T @ (0, 0, -1))
    broken = figure_laws.Session(scene).ticks(wall_m + np.outer(1e-5 * np.arange(-100, 6000), into))[2][:3]
    off_n = largest(k_n_per_m * np.array([depth_m for _, depth_m in broken]) - strengths_n[:len(broken)])
    return (f"{len(broken)} of 3 nested levels, pressed through at 0.5, 1 and 2 N to {off_n:.4f} N",
            len(broken) == 3 and off_n <= k_n_per_m * 1e-5 + 1e-9)


@claim("rapid development of modes", "counted in lines; nobody was timed")
def modes_are_short():
    modes = {each for each in vars(palpa).values() if isinstance(each, type) and issubclass(each, palpa.Mode)}
    modes -= {palpa.Mode, palpa.CFunction}
    text = (root / "examples" / "03_own_mode.cpp").read_text().split("\n")
    begin = next(n for n, line in enumerate(text) if line.startswith("struct "))
    lines = text.index("};", begin) - begin + 1
    return (f"{len(modes)} modes beside a solver that knows none of them; a whole new one in {lines} lines "
            "(examples/03_own_mode.cpp)", lines < 50)


devices = ("touch", "desktop", "omega", "falcon", "inverse3")


@functools.cache
def stable_n_per_m(device, damping_ns_per_m):
    """The stiffness up to which every step of a ladder comes to rest: with an encoder some stiffer ones do, above some that do
    not, which bisection would hit or miss. From 100 N/m on: softer, a coarse encoder alone keeps a device moving."""
    stable, k = 0.0, 100.0
    while k < 6000.0 and figure_laws.comes_to_rest(device, damping_ns_per_m, k):
        stable, k = k, 1.05 * k
    return stable


def list_of(values):
    return ", ".join(f"{device} {value:.0f}" for device, value in zip(devices, values))


@claim("stable on the data that were felt", "up to a stiffness that the device sets and the paper does not name; on models of devices "
       "without delay, no device was tried")
def stable():
    at_1, at_0 = ([stable_n_per_m(device, damping) for device in devices] for damping in (1.0, 0.0))
    passive = [2.0 * figure_laws.device_damping_ns_per_m(device) / tick_s for device in devices]
    return (f"a device that is let go on a plane comes to rest up to [N/m], D = 1 N s/m: {list_of(at_1)}; D = 0: {list_of(at_0)}; "
            f"2b/T: {list_of(passive)}", min(at_1) >= 500.0)


@claim("the damping D of Eq. 1 steadies the loop", "for a device that is let go, and a D that is not too large; not for every hand")
def damping():
    at_0, at_1, at_4 = (np.array([stable_n_per_m(device, each) for device in devices]) for each in (0.0, 1.0, 4.0))
    passive = sum(figure_laws.device_damping_ns_per_m(device) > 1.0 for device in devices)
    return (f"D = 1 against 0 raises the stiffness that comes to rest on {(at_1 > at_0).sum()} of {len(devices)} devices, D = 4 "
            f"against 1 on {(at_4 > at_1).sum()}; at D = 4 [N/m]: {list_of(at_4)}; b > kT/2 + D, which would hold for any hand, can "
            f"hold at D = 1 on {passive}", (at_1 > at_0).all())


@figure("claims", 1120, 760, columns=2, rows=2)
def claims_figure(moves, vortices, errors, limits):
    """Claims 5 and 6, 11, 13, and 16 and 17."""
    angles = np.arange(5, 176, 5)
    for name, law, direction, color in (("2003, along the bisector", "ikits-2003", bisector, vermilion),
                                        ("2003, across it", "ikits-2003", across, orange), ("balance", "exact", bisector, blue)):
        moves.plot(angles, [share_of_way(law, angle, direction) for angle in angles], color=color, label=name)
    plot(moves, "Two constraints without strength", "angle between them / degrees", "move / way of the hand", (0, 180), (0, 2))
    radii, acting = core_directions()
    for name, rows, color in (("plane", acting[0], blue), ("directed force", acting[1], vermilion)):
        vortices.plot(radii, rows[:, 1], color=color, label=name)
    plot(vortices, "A vortex, from its axis out", "distance from the axis / core radius", "strength / N", y_range=(0, 1.2))
    errors.plot(*shares_up_to(paper_errors()[0], 1e-12), color=vermilion, label="up to this error")
    plot(errors, "The paper's solver on two planes and a line", "error of the force / N", "sets / %", (1e-12, 10), (0, 100), "x")
    dampings = (0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0)
    for n, (device, color) in enumerate(zip(devices, (black, blue, vermilion, green, purple))):
        # The last lie on earlier curves, which show between the dashes.
        limits.plot(dampings, [stable_n_per_m(device, each) for each in dampings], color=color, ls="-" if n < 3 else "--", label=device)
    plot(limits, "Let go on a plane", "damping D / N s/m", "stiffest that rests / N/m", y_range=(0, None))


def table():
    rows = ["| # | claim | measured | verdict |", "|---|---|---|---|"]
    for number, (text, condition, measure) in enumerate(claims, 1):
        measured, holds = measure()
        verdict = "**does not hold**" if not holds else f"**holds with a condition**: {condition}" if condition else "**holds**"
        rows.append(f"| {number} | {text} | {measured} | {verdict} |")
    return "\n".join(rows)


if __name__ == "__main__":
    if len(sys.argv) > 2:
        sys.exit(__doc__)
    print(table())
    if len(sys.argv) == 2:
        write(sys.argv[1], ["claims"])
