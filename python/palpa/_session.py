"""Ticks of a session along a path, with the forces of its modes and its events."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy
from numpy.typing import ArrayLike

from . import _palpa
from ._parameters import Named
from ._scene import Scene


class Ticks(numpy.ndarray):
    """The ticks of a path: a structured array, a row per tick, with the modes' forces and the events as attributes.

    Its fields: t_s [s] since the first of these ticks; probe_m, proxy_m, proxy_velocity_m_per_s, force_n, 3 numbers each; of a
    tool torque_nm and the rotation vectors probe_turn_rad and proxy_turn_rad, 3 numbers each, of a length up to pi;
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

    def __reduce__(self):
        forces = None if self.mode_force_n is None else dict(self.mode_force_n)
        return _unpickled, (numpy.array(self), forces, self.events)

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


def _unpickled(rows, forces, events):
    made = rows.view(Ticks)
    made.mode_force_n = None if forces is None else Named("the session", "mode", forces)
    made.events = events
    return made


def not_pickled(self):
    """`__reduce__` of a session."""
    raise TypeError("a Session is not pickled, because it runs on where it was made; pickle its scene (session.scene) and the ticks "
                    "of its path, and make a palpa.Session in the other process")


def ticks(self: _palpa.Session, positions_m: ArrayLike, dt_s: ArrayLike, turns_rad: ArrayLike | None = None) -> Ticks:
    """A tick for each row of positions_m, shape (n, 3), at the speed of C++; other Python threads continue meanwhile.

    dt_s: [s] one time step for all, or shape (n,); above 0 and at most 1, else ValueError.
    turns_rad: [rad] orientation of a tool's handle in each tick as a rotation vector, shape (n, 3), else ValueError; None: none.
    Returns palpa.Ticks, a structured array, with attributes `mode_force_n` and `events` of all ticks.
    """
    return Ticks._of(*self._ticks(positions_m, dt_s, turns_rad))


def rollout(scene: Scene | Sequence[Scene], paths_m: ArrayLike | Sequence[ArrayLike], dt_s: ArrayLike, *,
            turns_rad: ArrayLike | Sequence[ArrayLike] | None = None, threads: int | None = None, start: _palpa.Session | None = None) -> list[Ticks]:
    """Ticks of many paths of the hand, each in a session of its own, on several cores: a list of palpa.Ticks, one per path.

    scene: one for all paths, or one per path. paths_m: positions [m] of shape (n, 3) each, or one array of shape (paths, n, 3).
    dt_s: [s] as in Session.ticks. turns_rad: as there, one array per path, or one of shape (paths, n, 3). threads: None: one per core. start: a session of an equal scene, whose state every path
    starts with; None: fresh sessions.
    The ticks equal those of Session.ticks to the bit, for any number of threads. Modes in Python run on one core at a time.
    """
    scenes = [scene] if isinstance(scene, Scene) else list(scene)
    paths_m = list(paths_m)
    if not all(isinstance(each, Scene) for each in scenes):
        raise TypeError("'scene' takes a palpa.Scene, or a list of them, one per path")
    if len(scenes) != 1 and len(scenes) != len(paths_m):
        raise ValueError(f"'scene' has {len(scenes)} scenes for {len(paths_m)} paths; give one for all, or one per path")
    turns_rad = [] if turns_rad is None else list(turns_rad)
    if turns_rad and len(turns_rad) != len(paths_m):
        raise ValueError(f"'turns_rad' has {len(turns_rad)} arrays for {len(paths_m)} paths; give one per path, or None")
    if threads is None:
        threads = len(os.sched_getaffinity(0))
    if not isinstance(threads, int) or isinstance(threads, bool) or not 1 <= threads <= 1024:
        raise ValueError(f"'threads' is {threads!r}; it is a whole number from 1 to 1024")
    return [Ticks._of(*each) for each in _palpa.rollout(scenes, paths_m, dt_s, turns_rad, threads, start)]


def modes(self: _palpa.Session) -> Mapping[str, _palpa.ModeForce]:
    """Forces of the last tick: a ModeForce for each mode, by name."""
    return Named("the session", "mode", self._modes())
