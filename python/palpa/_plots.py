"""Plots and pictures for notebooks, by matplotlib if installed."""

from __future__ import annotations

import io
from typing import Any

import numpy

# As in pictures and reports: Okabe and Ito's colour-blind safe set.
_colors = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")


def _figure(width, height):
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise ImportError("plots need matplotlib, which is not installed; install python3-matplotlib") from None

    class Shown(Figure):
        """Figure that a notebook shows with any matplotlib backend."""

        def _repr_png_(self):
            return png_of(self)

    return Shown(figsize=(width, height), layout="constrained")


def trace_figure(trace: Any) -> Any:
    ticks = trace.ticks
    figure = _figure(9, 5)
    force, depth = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    force.plot(ticks["t_s"], numpy.linalg.norm(ticks["force_n"], axis=1), color="#444444", label="spring")
    force.plot(ticks["t_s"], numpy.linalg.norm(ticks["command_n"], axis=1), color="#444444", lw=0.8, ls=":", label="reaches the hand")
    modes, time_of = trace.modes, dict(zip(ticks["tick"].tolist(), ticks["t_s"].tolist()))
    for n, name in enumerate(dict.fromkeys(modes["mode"].tolist())):
        rows = modes[modes["mode"] == name]
        force.plot([time_of.get(tick, numpy.nan) for tick in rows["tick"].tolist()], numpy.linalg.norm(rows["force_n"], axis=1),
                   color=_colors[n % len(_colors)], lw=1, label=name)
    for event in trace.events if "events" in trace.tables else ():
        if event["kind"] in ("onset", "break_through"):
            force.axvline(event["t_s"], color="#bbbbbb", lw=0.6, zorder=0)
    force.set_ylabel("force / N")
    force.legend(loc="upper right", fontsize="small")
    depth.plot(ticks["t_s"], 1e3 * numpy.linalg.norm(ticks["probe_m"] - ticks["proxy_m"], axis=1), color="#444444")
    depth.set_ylabel("probe to proxy / mm")
    depth.set_xlabel("time / s")
    return figure


def scene_figure(scene: Any) -> Any:
    """Three slices through the middle of the scene's first volume, with the levels of its modes as lines."""
    name, volume = next(iter(scene.volumes.items()))
    field = next(iter(volume.fields.values()))
    levels = sorted({level.value for mode in scene.modes.values() if hasattr(mode.mode, "levels")
                     and str(mode.mode.field).split(".")[0] == name for level in mode.mode.levels})
    low, high = field.bounds_m
    figure = _figure(10, 3.6)
    for axes, (across, up, through) in zip(figure.subplots(1, 3), ((0, 1, 2), (0, 2, 1), (1, 2, 0))):
        a, b = numpy.linspace(low[across], high[across], 160), numpy.linspace(low[up], high[up], 160)
        places = numpy.empty((160, 160, 3))
        places[..., across], places[..., up] = numpy.meshgrid(a, b)
        places[..., through] = 0.5 * (low[through] + high[through])
        values = field(places)[0]
        if field.components == 3:
            values = numpy.linalg.norm(values, axis=-1)
        extent = [1e3 * a[0], 1e3 * a[-1], 1e3 * b[0], 1e3 * b[-1]]
        image = axes.imshow(values, origin="lower", extent=extent, cmap="gray" if field.components == 1 else "viridis_r")
        shown = [level for level in levels if field.components == 1 and numpy.nanmin(values) < level < numpy.nanmax(values)]
        if shown:
            axes.contour(values, levels=shown, extent=extent, colors=_colors[1], linewidths=0.9, linestyles="solid")
        axes.set_xlabel(f"{'xyz'[across]} / mm")
        axes.set_ylabel(f"{'xyz'[up]} / mm")
    figure.colorbar(image, label=f"{name} / {field.unit}" if field.unit else name)
    return figure


def png_of(figure: Any) -> bytes:
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=96)
    return file.getvalue()


def png_or_none(make: Any, what: Any) -> bytes | None:
    """PNG for a notebook; None, so that it shows text, without matplotlib or anything to draw."""
    try:
        return png_of(make(what))
    except (ImportError, StopIteration):
        return None
