"""Figures of docs/design.md: the two main paths, step by step."""

from matplotlib.patches import Rectangle

from common import black, blue, figure, green, grey, vermilion

# Rows: layer, function, input and output, file.
tick_rows = [
    ("device", "Device::read", "a device → Probe", "device/device.h"),
    ("session", "Session::tick", "Probe, time step → Tick", "session/session.cpp"),
    ("session", "ProbeQueue::push", "probe position → segments of its path", "session/probe_queue.h"),
    ("session", "ModeRuntime::place", "proxy, segment → primitives", "session/mode_runtime.h"),
    ("mode", "Mode::place", "samples of the data → primitives", "mode/mode.h"),
    ("session", "ContactProblem::balance", "primitives → Balance, by the law", "session/contact_problem.h"),
    ("solver", "Solver::solve", "primitives, probe → balance and its bound", "solver/solver.h"),
    ("mode", "Crossings::first_event", "the move → the part of it that is free", "mode/crossings.h"),
    ("session", "ContactTable::update", "the accepted sub-step → contacts, events", "session/contact_table.h"),
    ("session", "ProxyPath::walk", "all sub-steps of the tick → Walk", "session/proxy_path.h"),
    ("session", "CouplingForce::update", "Walk → force of spring and damper", "session/coupling_force.h"),
    ("session", "Ledger::end", "sub-steps, contacts → Energy", "session/ledger.h"),
    ("loop", "GuardedSession::tick", "Tick → command within all limits", "loop/loop.h"),
    ("device", "Device::write", "command → a device", "device/device.h"),
]
voxel_rows = [
    ("base", "InputFile", "name → ordinary file of known size", "base/input_file.h"),
    ("file", "volume_reader", "file → request to palpa-read", "file/read_volume.h"),
    ("reader", "palpa-read", "file → header, then voxels; in the sandbox", "reader/serve.cpp"),
    ("file", "protocol", "checked sizes → pages mapped by both", "file/protocol.h"),
    ("data", "grid_field", "voxels, geometry → Field", "data/grid.h"),
    ("data", "Field::scalar", "position → value, gradient", "data/field.h"),
    ("mode", "ModeContext::scalar", "hand position → sample per hand metre", "mode/mode_context.h"),
]


def steps(axes, title, rows, colors):
    """Rows from top to bottom, an arrow from each to the next."""
    axes.set_title(title)
    axes.set(xlim=(0, 100), ylim=(len(rows) - 0.1, -0.75))
    axes.axis("off")
    for x, head in ((1, "layer"), (13, "function"), (45, "input → output"), (97, "source")):
        axes.text(x, -0.55, head, color=grey, ha="right" if x == 97 else "left", va="center", fontsize=8.5)
    for i, (layer, function, flow, source) in enumerate(rows):
        color = colors[layer]
        axes.add_patch(Rectangle((12, i - 0.3), 30, 0.6, fill=False, edgecolor=color, linewidth=1.2))
        axes.text(1, i, layer, color=color, va="center", weight="bold")
        axes.text(13, i, function, color=black, va="center", family="DejaVu Sans Mono", fontsize=8.5)
        axes.text(45, i, flow, color=black, va="center", fontsize=8.5)
        axes.text(97, i, source, color=grey, va="center", ha="right", fontsize=8)
        if i + 1 < len(rows):
            axes.annotate("", (27, i + 0.7), (27, i + 0.3), arrowprops={"arrowstyle": "-|>", "color": grey, "lw": 1.0})


@figure("design-tick", 1120, 560, columns=1)
def tick(axes):
    """From a probe position to the force: every step takes the values of the steps above it, and none goes back."""
    steps(axes, "From a probe position to the force", tick_rows,
          {"device": vermilion, "session": blue, "mode": green, "solver": black, "loop": vermilion})


@figure("design-voxel", 1120, 330, columns=1)
def voxel(axes):
    """From a voxel in a file to a field: the only program that parses the file is in a sandbox."""
    steps(axes, "From a voxel in a file to a field", voxel_rows,
          {"base": grey, "file": blue, "reader": vermilion, "data": green, "mode": black})
