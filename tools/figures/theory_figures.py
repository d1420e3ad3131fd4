"""The figures of docs/theory.md: answers of the exact law, its proven bound, and sweeps over forces."""

import functools

import numpy as np

from common import *

reached_m = 1e-9


def sweep(primitives, forces_n, probe_m, stiffness_n_per_m):
    """Each force in turn becomes optimal while the others are held: one sweep of dual ascent.

    forces_n: [N] a row for each primitive (without drag), replaced. Returns the proxy at which the spring then holds [m]."""
    for i, primitive in enumerate(primitives):
        if primitive[0] == "directed":
            continue
        others_n = forces_n.sum(axis=0) - forces_n[i]
        force_n = stiffness_n_per_m * residual(primitive, probe_m + others_n / stiffness_n_per_m)
        length_n = norm(force_n)
        forces_n[i] = force_n * (primitive[3] / length_n if length_n > primitive[3] else 1.0)
    return probe_m + forces_n.sum(axis=0) / stiffness_n_per_m


def sweeps_towards_balance(seed, sweeps):
    """Sweeps over two oblique planes, a line and a point, number `seed` of these sets: after each the distance to the balance,
    its proven bound [m], and the residual of the paper's printed forces (Eqs. 2 to 8) there [N]."""
    k, draw = 600.0, Draw(seed, 256)
    normal = draw.direction()
    tilt = np.tan(np.radians(draw.uniform(20, 70)))
    other = normalized(normal + tilt * normalized(np.cross(normal, draw.direction())))
    placed = []
    for kind, direction, least_n, most_n in (("plane", normal, 0.5, 3), ("plane", other, 0.5, 3), ("line", None, 0.2, 1),
                                             ("point", (0, 0, 0), 0.1, 0.5)):
        at_m = draw.in_cube(1e-3)
        placed.append((kind, at_m, draw.direction() if direction is None else direction, draw.uniform(least_n, most_n), 0.0))
    probe_m = -0.003 * normalized(normal + other) + draw.in_cube(0.002)
    balance_m = figure_laws.Law("exact").solve(placed, (0, 0, 0), probe_m, k)[0]
    forces_n, rows = np.zeros((4, 3)), []
    for _ in range(sweeps):
        x_m = sweep(placed, forces_n, probe_m, k)
        left_n = -k * (x_m - probe_m) + sum(p[3] * normalized(residual(p, x_m)) for p in placed)
        rows.append((norm(x_m - balance_m), figure_laws.error_bound_m(placed, forces_n, x_m, probe_m, k), norm(left_n)))
    return np.array(rows)


def edge_of(angle_deg):
    """Two planes of 5 N through 0, and a probe 4 mm below their common edge: (planes, probe [m], stiffness [N/m])."""
    half = np.radians(0.5 * angle_deg)
    planes = [plane((side * np.sin(half), np.cos(half), 0), 5.0) for side in (1, -1)]
    return planes, np.array([0, -0.004, 0]), 500.0


def sweeps_into_edge(angle_deg, cap):
    """The distance [m] of the proxy to the edge after each of up to `cap` sweeps, the last one below 1e-9 m."""
    planes, probe_m, k = edge_of(angle_deg)
    a, b = (np.array(each[2][:2]) for each in planes)
    force_a = force_b = np.zeros(2)  # as `sweep`, which would take minutes for the flattest edges
    distances_m = []
    while len(distances_m) < cap and not (distances_m and distances_m[-1] < reached_m):
        force_a = min(5.0, max(0.0, k * (-a @ (probe_m[:2] + force_b / k)))) * a
        force_b = min(5.0, max(0.0, k * (-b @ (probe_m[:2] + force_a / k)))) * b
        x_m = probe_m[:2] + (force_a + force_b) / k
        distances_m.append(float(np.hypot(*x_m)))
    return np.array(distances_m)


def random_steps(elsewhere, count):
    """Ticks with primitives of any direction and strength, new in each tick: all through the proxy, or (elsewhere) up to 3 mm
    away from it and with directed forces. Returns the work on the hand less the spring's release, and k/2 |step|² [J]."""
    k, draw, law = 500.0, Draw(12 if elsewhere else 11, 32768), figure_laws.Law("exact")
    kinds, rows, proxy_m, probe_m = ("point", "line", "plane", "directed"), [], np.zeros(3), np.zeros(3)
    for _ in range(count):
        placed = []
        for _ in range(1 + int(draw.uniform(0, 5))):
            kind = kinds[int(draw.uniform(0, 4 if elsewhere else 3))]
            at_m = proxy_m + (draw.in_cube(0.003) if elsewhere else 0)
            placed.append((kind, at_m, draw.direction(), draw.uniform(0, 0.3 if kind == "directed" else 1.0), 0.0))
        step_m = 10.0 ** draw.uniform(-2, 0) * draw.in_cube(0.003)
        next_m, stretch_m = law.solve(placed, proxy_m, probe_m + step_m, k)[0], proxy_m - probe_m
        released_j = 0.5 * k * (stretch_m @ stretch_m - norm(next_m - probe_m - step_m) ** 2)
        rows.append((k * stretch_m @ step_m - released_j, 0.5 * k * step_m @ step_m))
        proxy_m, probe_m = next_m, probe_m + step_m
    return np.array(rows).T


@figure("theory-energy", 1240, 360, columns=3)
def energy(energies, forces, felt):
    """A plane of 1 N at 0 and a spring of 400 N/m. The energy has a kink at the plane; its lowest point is where the spring's
    force is one that the plane can exert, at the kink any up to 1 N. To the right a point with strength, drag (0.2 N s/m, ticks
    of 1 ms), or both."""
    k, s, law = 400.0, 1.0, figure_laws.Law("exact")
    wall = plane((1, 0, 0), s)
    forces.plot([-6, 0], [s, s], color=black, label="plane")
    forces.plot([0, 0], [0, s], color=vermilion, label="any of it at 0")
    forces.plot([0, 4], [0, 0], color=black)
    for probe_mm, color in ((1.5, green), (-1.5, blue), (-4.0, purple)):
        energy_mj = lambda x_mm: 1e3 * (0.5 * k * 1e-6 * (x_mm - probe_mm) ** 2 + s * 1e-3 * np.maximum(0, -x_mm))
        places_mm = np.linspace(-6, 4, 201)
        energies.plot(places_mm, energy_mj(places_mm), color=color, label=f"p = {probe_mm:g} mm")
        x_mm = 1e3 * law.solve([wall], (0, 0, 0), (1e-3 * probe_mm, 0, 0), k)[0][0]
        energies.plot(x_mm, energy_mj(x_mm), "o", color=color)
        ends_mm = np.array([max(-6.0, probe_mm - 400 / k), min(4.0, probe_mm + 1600 / k)])
        forces.plot(ends_mm, 1e-3 * k * (ends_mm - probe_mm), color=color, ls="--")
        forces.plot(x_mm, 1e-3 * k * (x_mm - probe_mm), "o", color=color)
    plot(energies, "Energy of three probes p", "place of the proxy / mm", "energy / mJ", (-6, 4), (-0.2, 8))
    plot(forces, "Spring and plane agree", "place of the proxy / mm", "force / N", (-6, 4), (-0.4, 1.6))
    ways_mm = np.linspace(0, 6, 121)
    for name, strength_n, drag, color, ls in (("strength", s, 0.0, blue, "-"), ("drag", 0.0, 0.2, green, "--"),
                                              ("both", s, 0.2, vermilion, "-")):
        at_m = [law.solve([point(strength_n, drag=drag)], (0, 0, 0), (1e-3 * way, 0, 0), k)[0][0] for way in ways_mm]
        felt.plot(ways_mm, k * np.abs(at_m - 1e-3 * ways_mm), color=color, ls=ls, label=name)
    plot(felt, "What is felt", "way in one tick / mm", "force / N", (0, 6), (0, 1.6))


def furthest(primitive, e):
    """Support point [N] of a primitive's force set, in the drawing's plane, in the direction e."""
    kind, _, direction, strength_n, _ = primitive
    q = np.asarray(direction, float)
    if kind == "point":
        return strength_n * e
    return strength_n * normalized(e - (q @ e) * q) if kind == "line" else strength_n * max(0.0, np.sign(q @ e)) * q


def outline(primitives, middle, mm_per_n):
    turns = np.radians(np.arange(361) + 0.5)  # never exactly across a direction
    sums_n = [sum(furthest(p, np.array([np.cos(turn), np.sin(turn), 0])) for p in primitives) for turn in turns]
    return np.asarray(middle) + mm_per_n * np.array(sums_n)[:, :2]


@figure("theory-sum", 1200, 430, columns=3)
def sum_of_sets(sets, total, space):
    """A plane, a line and a point at one place. Left: the forces that each can exert. Middle: the sums of them, four demands of
    a hand (blue), and the nearest force that can be given (red). Demand 1 lies inside: the proxy rests. Elsewhere what is
    missing, as the arrow, moves the proxy. Right: probes and proxies of these demands, k = 200 N/m."""
    k, mm_per_n, along = 200.0, 10.0, np.array([np.cos(np.pi / 3), np.sin(np.pi / 3)])
    placed = [plane((0, 1, 0), 1.0), line((*along, 0), 0.8), point(0.4)]
    drawing(sets, "What each can exert", (-20, -19), (20, 19))
    for primitive, middle, name, color in zip(placed, ((-11, -4), (0, 3), (12, 2)), ("plane, 1 N", "line, 0.8 N", "point, 0.4 N"),
                                              (black, green, purple)):
        corners = outline([primitive], middle, mm_per_n)
        if primitive[0] == "point":
            area(sets, corners, color)
        path(sets, corners, color, width=1.8)
        dot(sets, middle, color, 2.3)
        label(sets, (middle[0], -10), name, "center", color)
    path(sets, [(-5, -15), (5, -15)], grey, width=1.5)
    label(sets, (0, -17.5), "1 N", "center", grey)
    drawing(total, "Their sum, and what hands demand", (-20, -14), (20, 24))
    border = outline(placed, (0, 0), mm_per_n)
    area(total, border, sky)
    path(total, border, blue, width=1.5)
    dot(total, (0, 0), black, 2.3)
    label(total, (0.8, -1.6), "0")
    drawing(space, "The same in space", (-10, -12), (10, 7))
    surface(space, -9, 9, 0, 11)
    path(space, [-6.3 * along, 6.3 * along], green, width=1.5)
    dot(space, (0, 0), purple, 3.8)
    for n, demand_n in enumerate(np.array([(-0.45, 0.75, 0), (1.1, 1.55, 0), (-0.9, -0.6, 0), (-1.55, 1.4, 0)]), 1):
        probe_m = -demand_n / k
        proxy_m, forces_n, _, _ = figure_laws.Law("exact").solve(placed, (0, 0, 0), probe_m, k)
        demanded, given = mm_per_n * demand_n[:2], mm_per_n * forces_n.sum(axis=0)[:2]
        if norm(given - demanded) > 1e-5:
            arrow(total, demanded, given, vermilion)
        ring(total, given, vermilion)
        dot(total, demanded, blue)
        label(total, demanded + (1.6, 1.2), str(n), color=blue)
        probe_and_proxy(space, mm(probe_m), mm(proxy_m))
        label(space, mm(probe_m) + (0.6, -0.7), str(n), color=blue)


@figure("theory-bound", 1120, 400, columns=2)
def bound(way, all_sets):
    """Two oblique planes, a line and a point, k = 600 N/m, with the forces of the first sweeps. The bound lies above the error
    and falls with it, as its root where something holds that is not quite reached. What the printed forces leave over falls only
    where nothing holds; elsewhere no test of it tells 1 mm from 1 nm."""
    near = sweeps_towards_balance(29, 40)
    last = np.array([sweeps_towards_balance(seed, 1 + seed % 12)[-1] for seed in range(1, 401)])
    for axes, rows, xs, looks in ((way, near, np.arange(1, 41), ("-", "-", "--")), (all_sets, last, 1e3 * last[:, 0], ("o",) * 3)):
        axes.plot(xs, 1e3 * rows[:, 2] / 600.0, looks[2], color=grey, label="residual force / k")
        axes.plot(xs, 1e3 * rows[:, 1], looks[0], color=vermilion, label="proven bound")
    way.plot(np.arange(1, 41), 1e3 * near[:, 0], color=blue, label="error")
    all_sets.plot([1e-6, 10], [1e-6, 10], color=blue, label="error itself")
    plot(way, "One set, sweep by sweep", "sweeps", "distance / mm", (0, 40), (1e-7, 20), "y")
    plot(all_sets, "400 sets", "error / mm", "distance / mm", (1e-6, 10), (1e-7, 20), "xy")


@functools.cache
def sweeps_over_angle():
    """Angles between two planes [degrees], sweeps until the error is 1 nm, their number by cos² a sweep, and the exact law's
    iterations."""
    rows = []
    for angle_deg in 90.0 ** ((np.arange(32) + 0.5) / 32):
        distances_m = sweeps_into_edge(angle_deg, 200000)
        formula = 1.0 + np.log(reached_m / distances_m[0]) / np.log(np.cos(np.radians(angle_deg)) ** 2)
        planes, probe_m, k = edge_of(angle_deg)
        proxy_m, _, _, iterations = figure_laws.Law("exact").solve(planes, (0, 0, 0), probe_m, k)
        rows.append((angle_deg, len(distances_m), max(1.0, formula), max(1, iterations) if norm(proxy_m) < reached_m else np.nan))
    return np.array(rows).T


@figure("theory-sweeps", 1120, 400, columns=2)
def sweeps(way, count):
    """A proxy is pressed into the edge of two planes. A sweep leaves cos² of the angle of the error, so nearly parallel planes
    take thousands. The exact law (cold start; its iterations, of any stage) hardly feels the angle."""
    for angle_deg, color in ((10, vermilion), (20, orange), (40, green), (60, sky), (80, blue)):
        distances_mm = 1e3 * sweeps_into_edge(angle_deg, 60)
        way.plot(np.arange(1, len(distances_mm) + 1), distances_mm, color=color, label=f"{angle_deg} degrees")
    plot(way, "Two planes: sweep by sweep", "sweeps", "error / mm", (0, 60), (1e-7, 10), "y")
    angles_deg, sweeps_, formula, ours = sweeps_over_angle()
    count.plot(angles_deg, formula, color=grey, ls="--", label="cos² a sweep")
    count.plot(angles_deg, sweeps_, "o", color=vermilion, label="sweeps")
    count.plot(angles_deg, ours, "o", color=blue, label="exact law")
    plot(count, "Until the error is 1 nm", "angle between the planes / degrees", "sweeps, iterations", (1, 100), (0.5, 1e5), "xy")


def work_on_circling_hand(placed):
    """The work [J] on a hand that goes in circles of 5 mm, five a second for 1 s, after each tick of 1 ms."""
    k, law, turns = 500.0, figure_laws.Law("exact"), 2 * np.pi * 5.0 * tick_s * np.arange(1001)
    probes_m = 0.005 * np.column_stack([np.cos(turns), np.sin(turns), 0 * turns])
    proxy_m, works_j = probes_m[0], [0.0]
    for n in range(1000):
        proxy_m = law.solve(placed(n, proxy_m), proxy_m, probes_m[n], k)[0]
        works_j.append(works_j[-1] + k * (proxy_m - probes_m[n]) @ (probes_m[n + 1] - probes_m[n]))
    return np.array(works_j)


@figure("theory-passivity", 1120, 400, columns=2)
def passivity(ratios, turns):
    """Energy that a hand gets beyond what the spring releases, k = 500 N/m. Left: random steps, with other primitives in each;
    through the proxy none leaks more than k/2 |step|², elsewhere and with directed forces some do. Right: a hand goes in circles
    of 5 mm five times a second, ticks of 1 ms. A strong fixed point uses up all that theorem B allows, a directed force that
    turns along knows no limit."""
    for name, color, elsewhere in (("elsewhere", orange, True), ("through the proxy", blue, False)):
        leak_j, bound_j = random_steps(elsewhere, 350)
        ratios.plot(1e6 * bound_j, leak_j / bound_j, "o", color=color, label=name)
    ratios.plot([1e-2, 1e4], [1, 1], color=black, ls="--", label="theorem B")
    plot(ratios, "Random steps", "k/2 |step of the hand|² / µJ", "leaked / (k/2 |step|²)", (1e-2, 1e4), (-4, 4), "x")
    times_s = tick_s * np.arange(1001)
    for name, color, placed in (
            ("directed, turning", vermilion, lambda n, at: [directed(normalized((-at[1], at[0], 0)), 0.12)]),
            ("strong point", sky, lambda n, at: [point(10.0)]),
            ("surface", green, lambda n, at: [plane((0, 1, 0), 10.0)]),
            ("turning rail", purple, lambda n, at: [line((np.cos(0.4 * (n + 1)), np.sin(0.4 * (n + 1)), 0), 0.15, at)])):
        turns.plot(times_s, 1e3 * work_on_circling_hand(placed), color=color, label=name)
    step_m = 2 * 0.005 * np.sin(np.pi * 5.0 * tick_s)
    turns.plot([0, 1], [0, 1e3 * 1000 * 0.5 * 500.0 * step_m**2], color=black, ls="--", label="theorem B")
    plot(turns, "A hand that goes in circles", "time / s", "work on the hand / mJ", (0, 1), (-10, 20))
