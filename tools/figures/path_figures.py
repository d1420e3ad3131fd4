"""The figures of docs/path.md: sessions on the proxy's path, and with one exact balance a tick, as in earlier systems."""

import functools

import numpy as np

from common import *

voxel_m, wall_m = 1e-3, 3e-4


class PlaneAtProxy(palpa.Mode):
    """A plane through the proxy at any position: Eq. 7 of the paper with the local normal."""

    fields = ("field",)

    def __init__(self, field, strength_n):
        self.field, self.strength_n = field, strength_n

    def place(self, here, out):
        sample = here.scalar(self.field)
        if sample.inside and sample.gradient.any():
            out.plane(0, here.proxy_m, -normalized(sample.gradient), self.strength_n)


def off_sphere_m(one_step, on_level, speed_m_per_s, turns=1.0):
    """Distance of the proxy from a sphere of 50 mm [m], tick by tick, for a hand once round 1 mm below it, 800 N/m, ticks of 1
    ms. on_level: a plane on the captured level; else one through the proxy."""
    sphere_m, depth_m, scene = 0.05, 1e-3, plain_scene(800.0)
    ball = scene.add("ball", palpa.sphere_field(radius_m=sphere_m))
    scene.add("surface", skin(ball, 100.0) if on_level else PlaneAtProxy(ball, 100.0))
    e1 = normalized((1.0, 0.3, 0.2))  # a plane in general orientation
    e2 = normalized(np.cross(e1, (0.2, -0.1, 1.0)))
    at = lambda turn, radius_m: np.outer(radius_m * np.cos(turn), e1) + np.outer(radius_m * np.sin(turn), e2)
    per_turn = int(np.ceil(2 * np.pi * (sphere_m - depth_m) / (speed_m_per_s * tick_s)))
    # The plane at the proxy is at the hand's start, the level at first contact.
    depths_m = np.concatenate([[-1e-4] if on_level else [], np.linspace(0, depth_m, 21)])
    begin = at(np.zeros(len(depths_m)), sphere_m - depths_m)
    way = at(2 * np.pi * np.arange(1, int(turns * per_turn) + 1) / per_turn, sphere_m - depth_m)
    proxies_m = figure_laws.Session(scene, one_step).ticks(np.vstack([begin, way]))[0][len(begin):]
    return np.linalg.norm(proxies_m, axis=1) - sphere_m


@figure("path-drift", 1120, 400, columns=2)
def drift(turning, once):
    """A hand goes round 1 mm below a sphere of 50 mm, ticks of T = 1 ms, balances exact. A plane through the proxy leaves the
    sphere by π v T in each turn; on the path its normal is that of the middle of the step, and far less is left. On the level
    that was met there is no drift, only, in one step a tick, the sag of one step; on the path none but rounding."""
    speeds = np.array([0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0])
    for name, one_step, on_level, color, ls in (
            ("at the proxy, one step", True, False, vermilion, "-"), ("at the proxy, path", False, False, orange, "--"),
            ("on the level, one step", True, True, green, "-"), ("on the level, path (ours)", False, True, blue, "-")):
        off_m = off_sphere_m(one_step, on_level, 0.4, 3.0)
        turning.plot(3.0 * np.arange(1, len(off_m) + 1) / len(off_m), 1e3 * off_m, color=color, ls=ls)
        last_m = np.array([off_sphere_m(one_step, on_level, speed)[-1] for speed in speeds])
        once.plot(speeds, np.maximum(1e-10, 1e6 * np.abs(last_m)), color=color, ls=ls, label=name)
    once.plot([0.01, 10], [1e6 * np.pi * speed * tick_s for speed in (0.01, 10)], color=black, ls=":", label="π v T")
    plot(turning, "Turn by turn, at 0.4 m/s", "turns", "off the sphere / mm", (0, 3), (-0.5, 4.5))
    plot(once, "After one turn", "speed of the hand / (m/s)", "off the sphere / µm", (0.01, 10), (1e-10, 1e6), "xy")


def groove_scene():
    """A V-groove of 40 degrees along z in voxels of 1 mm, 800 N/m, strength 4 N. The grid is turned about the groove, so that
    its cells lie askew."""
    half_rad, turn_rad, count = np.radians(20.0), 0.15, 44
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    steps = voxel_m * (np.arange(count) - 0.5 * (count - 1))
    x, y = np.meshgrid(steps, steps)
    across, up = c * x - s * y, s * x + c * y
    depths_m = np.abs(across) * np.cos(half_rad) - up * np.sin(half_rad)
    voxels = np.broadcast_to(np.clip(depths_m, -3 * voxel_m, 3 * voxel_m).astype(np.float32), (count,) * 3).copy()
    scene = plain_scene(800.0)
    solid = scene.add_array("solid", voxels, voxel_m, axes=[[c, -s, 0], [s, c, 0], [0, 0, 1]], filter="trilinear")
    scene.add("surface", skin(solid, 4.0))
    return scene, scene.field(solid)


@functools.cache
def press_into_groove(one_step):
    """A hand presses into the groove, holds still for 100 ticks, and slides along it. Returns forces [N] and proxies [m] tick
    by tick, the ticks of its stop and its new start, the probe [m] while it is still, and the planes (direction, strength,
    force) of its last balance then."""
    aside_m, top_m, least_m = 0.1 * voxel_m, 3e-3, -0.85 * 4.0 * np.sin(np.radians(20.0)) / 800.0
    heights_m = np.arange(top_m, least_m, -0.05 * tick_s)
    end_m, along_m = heights_m[-1] - 0.05 * tick_s, 0.05 * tick_s * np.arange(1, 151)
    column = lambda x, y, z: np.column_stack(np.broadcast_arrays(x, y, z))
    session, parts = figure_laws.Session(groove_scene()[0], one_step), []
    for probes_m in (column(aside_m, heights_m, 0), column(aside_m, [end_m] * 100, 0),
                     column(aside_m + 0.1 * voxel_m * np.sin(2 * np.pi * along_m / 5e-3), end_m, along_m)):
        parts.append(session.ticks(probes_m))
        if len(parts) == 2:
            planes = session.last_primitives()
    proxies_m, forces_n = (np.vstack([part[i] for part in parts]) for i in (0, 1))
    still = len(heights_m)
    return forces_n, proxies_m, still, still + 100, np.array([aside_m, end_m, 0]), planes


@figure("path-groove", 1240, 400, columns=3)
def groove(section, up, across):
    """A hand presses into a groove of 40 degrees in voxels of 1 mm, then holds still, then slides along it (dotted lines);
    800 N/m, strength 4 N. Left: the level, and the planes that hold the proxy (ring) in one balance, with their forces. With one
    plane at a time each side leads into the other: the proxy is thrown from side to side and sinks in, the hand still or not."""
    field = groove_scene()[1]
    x_mm, y_mm = np.arange(-2.4, 2.401, 0.01), np.arange(4.0, -2.0, -0.001)
    values, _ = field(1e-3 * np.stack(np.broadcast_arrays(x_mm[:, None], y_mm, 0.0), axis=-1))
    level = np.column_stack([x_mm, np.where((values >= 0).any(axis=1), y_mm[np.argmax(values >= 0, axis=1)], np.nan)])
    level = level[level[:, 1] < 4.0]  # from above down to the level
    drawing(section, "Across the groove, hand still", (-2.4, -2.0), (2.4, 4.0))
    area(section, [*level, (2.4, 4.0), (2.4, -2.0), (-2.4, -2.0), (-2.4, 4.0)], grey)
    path(section, level, width=1.5)
    for one_step, color, name in ((True, vermilion, "one step a tick"), (False, blue, "ours")):
        forces_n, proxies_m, still, slides, probe_m, planes = press_into_groove(one_step)
        times_s = tick_s * np.arange(len(forces_n))
        up.plot(times_s, forces_n[:, 1], color=color)
        across.plot(times_s, forces_n[:, 0], color=color, label=name)
    for axes in (up, across):
        for tick in (still, slides):
            axes.axvline(tick_s * tick, color=grey, ls=":")
    proxy = mm(proxies_m[slides - 1])
    for normal, _, force_n in planes:  # the library's
        if norm(force_n) > 1e-3:
            side = 1.5 * normalized((normal[1], -normal[0], 0))[:2]
            path(section, [proxy - side, proxy + side], vermilion, "--")
            arrow(section, proxy, proxy + 0.5 * force_n[:2], vermilion)
    path(section, [mm(probe_m), proxy], blue, ":")
    dot(section, mm(probe_m), blue)
    ring(section, proxy, blue, 3.8)
    label(section, mm(probe_m) + (0.2, 0), "probe", color=blue)
    path(section, [(-2.2, -1.7), (-1.2, -1.7)], width=1.5)
    label(section, (-1.7, -1.45), "1 mm", "center")
    plot(up, "Force out of the groove", "time / s", "force / N", (0, times_s[-1]), (-0.1, 2.4))
    plot(across, "Force across it", "time / s", "force / N", (0, times_s[-1]), (-1.1, 1.1))


def stroke_through_wall(one_step, speed_m_per_s, first_m):
    """A straight stroke across a wall of 0.3 mm that is stronger than the whole stroke: probe and proxy along it [m], 0 on the
    wall's near side. first_m: the hand's start on its path, within one tick."""
    scene, step_m = plain_scene(800.0), speed_m_per_s * tick_s
    scene.add("surface", skin(scene.add("wall", figure_laws.plate(wall_m)), 20.0))
    x_m = np.arange(-0.012 + first_m, 0.010 + step_m, step_m)
    probes_m = np.column_stack(np.broadcast_arrays(x_m, 1e-3, 2e-3))
    return x_m, figure_laws.Session(scene, one_step).ticks(probes_m)[0][:, 0]


@figure("path-wall", 1120, 400, columns=2)
def wall(stroke, passed):
    """Straight strokes into a wall of 0.3 mm (grey) that bears more than the whole stroke, 800 N/m, ticks of 1 ms. A step that
    ends behind the wall has never seen it, or finds itself nearer to its back. On the path the wall is met where it is, at any
    speed."""
    speeds, strokes = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0), 40
    stroke.axhspan(0, 1e3 * wall_m, color="#c4c4c4", lw=0)
    for one_step, color, name in ((True, vermilion, "one step a tick"), (False, blue, "ours")):
        probe_m, proxy_m = stroke_through_wall(one_step, 2.0, 0.7e-3)
        stroke.plot(1e3 * probe_m, 1e3 * proxy_m, "o-", color=color)
        behind = [sum(stroke_through_wall(one_step, speed, speed * tick_s * (i + 0.5) / strokes)[1][-1] > wall_m
                      for i in range(strokes)) for speed in speeds]
        passed.plot(speeds, 100.0 * np.array(behind) / strokes, color=color, label=name)
    plot(stroke, "One stroke, 2 m/s", "probe / mm", "proxy / mm", (-6, 10), (-6, 10))
    plot(passed, "40 strokes at each speed", "speed / (m/s)", "proxies behind the wall / %", (0.01, 10), (-3, 103), "x")


steps_um = 300.0 / np.array([1, 2, 4, 8])


def differences_m(volume, mode, centre_m, radius_m):
    """Convergence of the path: a hand on a circle that tilts and breathes, 0.3 mm a tick; the largest distances [m] between
    its paths in 1 and 2, 2 and 4, 4 and 8, 8 and 16 steps a tick."""
    scene = plain_scene(500.0)
    scene.add(*volume)
    scene.add("felt", mode)
    turn = 3e-4 / radius_m * np.arange(350)
    r_m = radius_m * (1 + 0.1 * np.sin(0.7 * turn))
    hand_m = centre_m + np.column_stack([r_m * np.cos(turn), r_m * np.sin(turn), 0.1 * radius_m * np.sin(1.3 * turn)])
    begun = figure_laws.Session(scene, steps=16)
    above_m = np.outer(np.arange(0.012, 0, -1e-4), (0, 0, 1))  # it comes from outside, so that surfaces are met
    begun.ticks(np.vstack([hand_m[0] + above_m, hand_m[:200]]))
    paths_m = []
    for steps in (1, 2, 4, 8, 16):
        session = figure_laws.Session(scene, steps=steps)
        session.copy_state_from(begun)
        paths_m.append(session.ticks(hand_m[200:])[0])
    return [np.linalg.norm(a - b, axis=1).max() for a, b in zip(paths_m, paths_m[1:])]


@functools.cache
def convergence_in_scalars():
    """Differences of paths in a ball, by mode."""
    material = palpa.SurfaceAndFriction(field="ball", strength_n=palpa.Strength(of="ball", points=[(-0.01, 0.2), (0.05, 0.4)]), friction_n=0.1)
    modes = {"surface": skin("ball", 20.0), "surface, friction_n": skin("ball", 20.0, friction_n=0.2),
             "surface, coefficient": skin("ball", 20.0, friction_coefficient=0.15), "material, friction_n": material,
             "viscosity": palpa.Viscosity(field="ball", strength_n=0.5),
             "viscosity, drag": palpa.Viscosity(field="ball", drag_ns_per_m=1.0),
             "gradient_force": palpa.GradientForce(field="ball", strength_n=1.0)}
    volume = ("ball", palpa.sphere_field())
    return {name: differences_m(volume, mode, np.array([0, 0, 0.0465]), 0.010) for name, mode in modes.items()}


@functools.cache
def convergence_in_vectors():
    """Differences of paths in a Lamb-Oseen vortex, by mode."""
    viscous = palpa.Strength(of="magnitude(flow)", points=[(0.0, 0.1), (1.0, 3.0)])
    modes = {"follow": (palpa.Follow(field="flow", strength_n=0.5), 0.010),
             "follow, drag": (palpa.Follow(field="flow", strength_n=0.0, drag_ns_per_m=1.0), 0.010),
             "viscosity of field": (palpa.Viscosity(strength_n=viscous), 0.010),
             "front_shape": (palpa.FrontShape(field="flow", strength_n=0.3), 0.010),
             "vector_force": (palpa.VectorForce(field="flow", strength_n=0.5), 0.015),
             "vortex_force": (palpa.VortexForce(field="flow", strength_n=0.3), 0.004),
             "vortex_plane": (palpa.VortexPlane(field="flow", strength_n=0.3), 0.0),
             "transverse_damping": (palpa.TransverseDamping(field="flow", drag_ns_per_m=1.0), 0.010),
             "vortex_line": (palpa.VortexLine(field="flow", strength_n=0.3), 0.004)}
    volume = ("flow", palpa.lamb_oseen_vortex())
    return {name: differences_m(volume, mode, np.array([at_m, 0, 0]), 0.005 if at_m < 0.005 else 0.006)
            for name, (mode, at_m) in modes.items()}


@figure("path-order", 1240, 520, columns=2)
def order(*panels):
    """How the path converges: a hand on a curved way, 0.3 mm a tick, in 1, 2, 4, 8 and 16 steps a tick; the largest distance
    between the paths of each and of twice as many. Left in a ball, right in a Lamb-Oseen vortex."""
    for axes, title, modes in zip(panels, ("Scalar fields", "Vector fields"), (convergence_in_scalars(), convergence_in_vectors())):
        for power, at_left_um, ls in ((1, 20.0, "--"), (2, 2e-5, ":")):
            axes.plot([37.5, 300], [at_left_um, at_left_um * 8**power], color=grey, ls=ls, label=f"order {power}")
        for n, (name, apart_m) in enumerate(modes.items()):
            axes.plot(steps_um, np.maximum(1e-5, 1e6 * np.array(apart_m)), color=many_colors[n % 7], ls="-" if n < 7 else "--",
                      label=name)
        plot(axes, title, "step of the hand / µm", "change when the step is halved / µm", (10, 1000), (1e-5, 1e3), "xy")
