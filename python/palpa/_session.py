"""Ticks of a session along a path, with the forces of its modes and its events."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy
from numpy.typing import ArrayLike

from . import _palpa
from ._parameters import Named


class Ticks(numpy.ndarray):
    """The ticks of a path: a structured array, a row per tick, with the modes' forces and the events as attributes.

    Its fields: t_s [s] since the first of these ticks; probe_m, proxy_m, proxy_velocity_m_per_s, force_n, 3 numbers each;
    error_bound_m, sub_steps, iterations, status (a palpa.TickStatus as a number: rows["status"] == palpa.TickStatus.resting),
    dropped; and the energy of each tick, stored_j … ticks_j (palpa.Energy).
    """

    mode_force_n: Any  # by mode its force on the proxy [N], shape (n, 3)
    events: Any  # (tick, kind, subject, value) each, tick counting from 0

    @classmethod
    def _of(cls, rows, forces, names, events):
        made = rows.view(cls)
        made.mode_force_n = Named("the session", "mode", {name: forces[:, m] for m, name in enumerate(names)})
        made.events = events
        return made

    def __array_finalize__(self, of):  # a slice of the rows has neither
        self.mode_force_n = self.events = None

    def __getattr__(self, name: str) -> Any:
        if name in (self.dtype.names or ()):
            raise AttributeError(f"Ticks: no attribute {name!r}; it is a column: rows[{name!r}]")
        raise AttributeError(f"Ticks: no attribute {name!r}")

    @property
    def statuses(self) -> list[_palpa.TickStatus]:
        """the status of each tick, as in Tick.status"""
        return [_palpa.TickStatus(int(status)) for status in self["status"]]

    def frame(self) -> Any:
        """A DataFrame of pandas, a column for each number: force_n is force_x_n, force_y_n, force_z_n."""
        import pandas

        columns = {}
        for name in self.dtype.names:
            values = numpy.asarray(self[name])
            if values.ndim == 1:
                columns[name] = values
                continue
            stem, _, unit = name.partition("_m_per_s") if name.endswith("_m_per_s") else name.rpartition("_")
            unit = unit or "m_per_s"
            for at, axis in enumerate("xyz"):
                columns[f"{stem}_{axis}_{unit}"] = values[:, at]
        return pandas.DataFrame(columns)


def ticks(self: _palpa.Session, positions_m: ArrayLike, dt_s: ArrayLike) -> Ticks:
    """A tick for each row of positions_m, shape (n, 3), at the speed of C++; other Python threads continue meanwhile.

    dt_s: [s] one time step for all, or shape (n,); above 0 and at most 1, else ValueError.
    Returns palpa.Ticks, a structured array, with attributes `mode_force_n` and `events` of all ticks.
    """
    return Ticks._of(*self._ticks(positions_m, dt_s))


def modes(self: _palpa.Session) -> Mapping[str, _palpa.ModeForce]:
    """Forces of the last tick: a ModeForce for each mode, by name."""
    return Named("the session", "mode", self._modes())
