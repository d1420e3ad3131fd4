"""Shared parts of the figures: the library, primitives, random numbers, colours, drawings to scale, files.

The library is the package palpa and the module figure_laws beside it: of PYTHONPATH, else of the build folder PALPA_BUILD
(build/release)."""

import math
import os
import pathlib
import sys
import warnings

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib.figure import Figure  # noqa: E402

root = pathlib.Path(__file__).resolve().parents[2]
build = pathlib.Path(os.environ.get("PALPA_BUILD", root / "build" / "release"))
sys.path += [str(build / "python"), str(build / "tools")]
try:
    import figure_laws
    import palpa
except ImportError as error:
    sys.exit(f"{error}; build them, with PALPA_PYTHON: cmake --build {build} --target palpa_figures")

tick_s = 1e-3
warnings.filterwarnings("ignore", category=palpa.PalpaWarning)  # of the shipped scenes

# Okabe and Ito's colours, which the colour-blind can distinguish, and a grey; on white, for pages light and dark.
black, blue, vermilion, green = "#000000", "#0072b2", "#d55e00", "#009e73"
purple, sky, orange, grey = "#b25c94", "#3e9cd1", "#cc8c00", "#787878"
many_colors = (blue, vermilion, green, orange, purple, sky, black)

matplotlib.rcParams.update({
    "font.size": 9.5, "font.sans-serif": ["DejaVu Sans"], "axes.titlesize": 10.5, "axes.titleweight": "bold",
    "axes.grid": True, "axes.axisbelow": True, "grid.color": "#e4e4e4", "grid.linewidth": 0.7, "axes.edgecolor": "#5a5a5a",
    "axes.spines.top": False, "axes.spines.right": False, "lines.linewidth": 1.3, "lines.markersize": 3.5,
    "legend.frameon": False, "legend.fontsize": 9, "svg.fonttype": "none", "svg.hashsalt": "palpa"})


# Primitives, as figure_laws takes them: (kind, position [m], direction [1], strength [N], drag [N s/m]).

def point(strength_n, at_m=(0, 0, 0), drag=0.0):
    return "point", at_m, (0, 0, 0), strength_n, drag


def line(direction, strength_n, at_m=(0, 0, 0)):
    return "line", at_m, direction, strength_n, 0.0


def plane(normal, strength_n, at_m=(0, 0, 0)):
    return "plane", at_m, normal, strength_n, 0.0


def directed(direction, strength_n):
    return "directed", (0, 0, 0), direction, strength_n, 0.0


def residual(primitive, x_m):
    """The vector [m] from the proxy to the primitive within its span (Eqs. 3 to 7); zero for a directed force."""
    kind, at_m, direction, _, _ = primitive
    if kind == "directed":
        return np.zeros(3)
    off_m, along = np.asarray(at_m, float) - x_m, np.asarray(direction, float)
    if kind == "line":
        return off_m - (along @ off_m) * along
    return max(0.0, along @ off_m) * along if kind == "plane" else off_m


def norm(vector):
    return float(np.sqrt(np.dot(vector, vector)))


def normalized(vector):
    length = norm(vector)
    return np.asarray(vector, float) / length if length > 0 else np.zeros(3)


def law_of_planes(law, angle_deg, probe_m):
    """A law's proxy, from 0, with two planes without strength whose normals are angle_deg apart."""
    half = 0.5 * angle_deg * np.pi / 180.0
    planes = [plane((side * math.sin(half), math.cos(half), 0), 0.0) for side in (1, -1)]
    return figure_laws.Law(law).solve(planes, (0, 0, 0), probe_m, 100.0)[0]


def friction_loop(depth_m, plane_n, line_n, stiffness_n_per_m, stroke_m, steps):
    """A probe below a surface is dragged to the right and back; plane and line are placed at the proxy, anew in each step.

    Returns, along the surface, probe and proxy [mm], and the forces of line and plane [N]."""
    law, proxy_m, rows = figure_laws.Law("exact"), np.zeros(3), []
    for i in range(2 * steps + 1):
        along_m = stroke_m * (i if i <= steps else 2 * steps - i) / steps
        primitives = [plane((0, 1, 0), plane_n, proxy_m), line((0, 1, 0), line_n, proxy_m)]
        proxy_m, forces_n, _, _ = law.solve(primitives, proxy_m, (along_m, -depth_m, 0), stiffness_n_per_m)
        rows.append((1e3 * along_m, 1e3 * proxy_m[0], forces_n[1, 0], forces_n[0, 1]))
    return np.array(rows).T


def shares_up_to(ascending, low):
    """Cumulative share of the values [%], a curve that never falls. Values below low count at low."""
    values, count = np.maximum(ascending, low), len(ascending)
    places, first = np.unique(values, return_index=True)
    return places, 100.0 * np.append(first[1:], count)[:len(places)] / max(count, 1)


class Draw:
    """Random numbers, identical on every machine."""

    def __init__(self, seed, count=4096):
        self._seed, self._count, self._next, self._numbers = seed, count, 0, figure_laws.uniform(seed, count).tolist()

    def uniform(self, low, high):
        if self._next == self._count:
            self._count *= 4
            self._numbers = figure_laws.uniform(self._seed, self._count).tolist()
        self._next += 1
        return low + (high - low) * self._numbers[self._next - 1]

    def below(self, count):
        return int(self.uniform(0.0, count))

    def in_cube(self, half):
        return np.array([self.uniform(-half, half) for _ in range(3)])

    def direction(self):
        while True:
            v = self.in_cube(1.0)
            if 0.1 < norm(v) < 1.0:
                return normalized(v)


def plain_scene(stiffness_n_per_m):
    """One hand metre is one metre of the data, axes and origins together."""
    scene = palpa.Scene(stiffness_n_per_m=stiffness_n_per_m)
    scene.workspace.scale, scene.workspace.center = 1.0, (0, 0, 0)
    scene.workspace.towards_user, scene.workspace.up = "+z", "+y"
    return scene


def skin(field, strength_n, **more):
    return palpa.SurfaceAndFriction(field=field, levels=[dict(name="skin", value=0.0, strength_n=strength_n)], **more)


figures = {}  # name: function that draws it


def figure(name, width_px, height_px, columns, rows=1):
    """Registers a function of its axes, row by row, as the figure of this name; its result, or its docstring, is the caption."""
    def take(draw):
        def make():
            made = Figure(figsize=(width_px / 96, height_px / 96), dpi=96, layout="constrained")
            made.get_layout_engine().set(w_pad=0.06, h_pad=0.08)
            made.caption = draw(*made.subplots(rows, columns, squeeze=False).flat) or " ".join(draw.__doc__.split())
            return made
        figures[name] = make
        return make
    return take


def write(folder, names):
    """Writes figures as NAME.svg and NAME.png, byte-identical each time; returns the files."""
    pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
    files = []
    for name in names:
        made = figures[name]()
        for ending, metadata in (("svg", {"Date": None, "Description": made.caption}), ("png", {"Software": None})):
            files.append(pathlib.Path(folder) / f"{name}.{ending}")
            made.savefig(files[-1], metadata=metadata)
    return files


def plot(axes, title, x_label, y_label, x_range=None, y_range=None, log="", legend=True):
    """Labels and ranges of a finished plot; log holds the names of its logarithmic axes."""
    axes.set_title(title)
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    if "x" in log:
        axes.set_xscale("log")
    if "y" in log:
        axes.set_yscale("log")
    axes.set_xlim(x_range)
    axes.set_ylim(y_range)
    if legend and axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)


# Drawings to scale, in mm

def drawing(axes, title, low, high):
    axes.set_title(title)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.axis("off")


def mm(at_m):
    return 1e3 * np.asarray(at_m, float)[:2]


def path(axes, points, color=black, ls="-", width=1.2):
    axes.plot(*np.transpose(points), color=color, ls=ls, lw=width, clip_on=False)


def area(axes, points, color):
    axes.fill(*np.transpose(points), color=color, alpha=0.15, lw=0)


def arrow(axes, start, end, color, width=1.6):
    axes.annotate("", xy=end, xytext=start, annotation_clip=False,
                  arrowprops=dict(arrowstyle="-|>,head_length=0.45,head_width=0.2", color=color, lw=width, shrinkA=0, shrinkB=0))


def dot(axes, at, color, radius=3.4):
    axes.plot(*at[:2], "o", color=color, ms=2 * radius, mew=0, clip_on=False, zorder=4)


def ring(axes, at, color, radius=4.9):
    axes.plot(*at[:2], "o", mfc="white", mec=color, ms=2 * radius, mew=1.2, clip_on=False, zorder=3)


def label(axes, at, text, align="left", color=black):
    axes.text(*at[:2], text, ha=align, va="center", color=color, clip_on=False, zorder=5)


def surface(axes, left, right, y, depth):
    """A surface in side view: a line with its inside shaded."""
    area(axes, [(left, y), (right, y), (right, y - depth), (left, y - depth)], grey)
    path(axes, [(left, y), (right, y)], width=1.6)


def probe_and_proxy(axes, probe, proxy):
    path(axes, [probe, proxy], blue, "--")
    ring(axes, proxy, vermilion)
    dot(axes, probe, blue)
