"""Traces: recordings of sessions, as arrays."""

from __future__ import annotations

import base64
import csv
import difflib
import html
import json
import os
import re
import tomllib
import warnings
import weakref
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy

from . import _palpa
from ._modes import plugins
from ._parameters import Strict
from ._plots import png_or_none, trace_figure
from ._scene import PalpaWarning, Scene, paths


class Replay(NamedTuple):
    """Comparison of two traces: `same` to the bit, else `where` they first differ; number of compared `ticks`; `cut`: reason
    why these are not all, or empty."""

    same: bool
    where: str
    ticks: int
    cut: str


# Columns that are no floats (docs/trace.md).
_whole = frozenset("tick sub_steps iterations dropped buttons primitives sub_step stage slot circumstances".split())
_flags = frozenset("probe_valid split_shared".split())
_texts = frozenset("status guard guard_cause mode kind subject value stop state".split())


def _table(path):
    """File of a trace as a structured array, up to its last whole line. NAME_x_U, NAME_y_U, NAME_z_U become one field
    NAME_U."""
    text = path.read_text(encoding="utf-8")
    rows = list(csv.reader(text[: text.rfind("\n") + 1].splitlines()))
    names, rows = rows[0], rows[1:]
    cells = list(zip(*rows)) if rows else [()] * len(names)
    columns, at = [], 0
    while at < len(names):
        vector = re.fullmatch(r"(.+)_x(_.+)?", names[at])
        if vector and at + 2 < len(names) and names[at + 1] == f"{vector[1]}_y{vector[2] or ''}":
            columns.append((vector[1] + (vector[2] or ""), numpy.array([[float(c) for c in cells[at + i]] for i in range(3)]).T))
            at += 3
            continue
        name, values = names[at], cells[at]
        if name in _texts:
            columns.append((name, numpy.array(values, dtype=str)))
        elif name in _whole:
            columns.append((name, numpy.array([int(c) for c in values], dtype=numpy.int64)))
        elif name in _flags:
            columns.append((name, numpy.array([c == "1" for c in values], dtype=bool)))
        else:
            columns.append((name, numpy.array([float(c) if c else numpy.nan for c in values], dtype=float)))
        at += 1
    made = numpy.empty(len(rows), dtype=[(name, values.dtype, values.shape[1:]) for name, values in columns])
    for name, values in columns:
        made[name] = values
    return made


class Trace(Strict):
    """A recording: a folder with one table per file (docs/trace.md).

    A temporary trace is deleted with its object; `with` or `close` deletes it earlier. warnings: a sentence each: how a
    recorded hand was placed, why nothing was felt, …
    ticks, modes, events, timing, balances, primitives, … are structured arrays: trace.ticks["force_n"] has the shape (n, 3).
    """

    folder: Path
    warnings: tuple[str, ...]

    def __init__(self, folder: str | PathLike, *, _summary: Any = None, _warnings: Sequence[str] = (),
                 _temporary: Any = None) -> None:
        self._summary, self._temporary, self._tables = _summary, _temporary, {}
        self.folder = Path(folder)
        self.warnings = tuple(_warnings)
        if not (self.folder / "trace.toml").is_file():
            raise _palpa.LoadError(f"{self.folder}: is no trace; a trace is a folder with a trace.toml in it")

    def close(self) -> None:
        """Deletes a temporary trace now; does nothing for a trace in a named folder, or if called again."""
        if self._temporary is not None:
            self._temporary.remove()

    def __reduce__(self):
        if self._temporary is not None:
            raise TypeError("a temporary trace is not pickled, because its folder ends with its object; run(…, out=folder) keeps the "
                            "folder, or pickle its tables: trace.ticks")
        return _unpickled, (str(self.folder.absolute()), self._summary, self.warnings)

    def __enter__(self) -> Trace:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    @property
    def header(self) -> dict[str, Any]:
        """contents of trace.toml: a dict"""
        return tomllib.loads((self.folder / "trace.toml").read_text(encoding="utf-8"))

    @property
    def summary(self) -> dict[str, Any] | None:
        """the numbers of its run, as in `palpa run --json`; None for a trace that was opened"""
        return self._summary

    @property
    def scene_text(self) -> str:
        """its scene file, as text"""
        return (self.folder / "scene.toml").read_text(encoding="utf-8")

    def __getattr__(self, name: str) -> Any:
        path = self.folder / f"{name}.csv" if not name.startswith("_") else None
        if path is None or not path.is_file():
            near = difflib.get_close_matches(name, [*self.tables, *self._names()], 1)
            raise AttributeError(f"the trace has no table {name!r}; there are: {', '.join(self.tables)}"
                                 + (f"; did you mean {near[0]!r}?" if near else ""))
        if name not in self._tables:
            self._tables[name] = _table(path)
        return self._tables[name]

    def __dir__(self):
        return [*super().__dir__(), *self.tables]

    @property
    def tables(self) -> list[str]:
        """the names of its tables"""
        return sorted(path.stem for path in self.folder.glob("*.csv"))

    def frame(self, name: str = "ticks") -> Any:
        """A table as a DataFrame of pandas, with the file's columns."""
        import pandas

        return pandas.read_csv(self.folder / f"{name}.csv", float_precision="round_trip")

    def export(self, file: str | PathLike, *, replace: bool = False) -> None:
        """Writes the trace's path and forces in the data's world for other programs: by the ending .vtp (ParaView), .csv, .h5
        or .mrk.json (3D Slicer). replace: overwrites an existing file. Raises LoadError."""
        _palpa.export_trace(self.folder, file, replace)

    def replay(self, *, data: Sequence[str | PathLike] = ()) -> Replay:
        """Repeats the run with its recorded hand and compares: a Replay. Raises LoadError if its scene cannot be loaded."""
        return Replay(*_palpa.replay(self.folder, paths(data, "data"), list(plugins)))

    def compare(self, other: Trace | str | PathLike) -> Replay:
        """Compares with another trace, all tables but timing: a Replay."""
        other = other.folder if isinstance(other, Trace) else Path(other)
        return Replay(*_palpa.compare_traces(self.folder, other), "")

    def plot(self) -> Any:
        """A figure of matplotlib: the spring's force, the force on the hand and each mode's part over time, with lines at
        contacts and break-throughs; and the distance between probe and proxy. Raises ImportError without matplotlib."""
        return trace_figure(self)

    def _repr_png_(self):
        return png_or_none(trace_figure, self)

    def _repr_html_(self):
        if self._summary is None:
            return None
        rows = "".join(f"<tr><td>{html.escape(str(key))}</td><td>{html.escape(format(value, '.4g'))}</td></tr>"
                       for key, value in self._summary.items() if isinstance(value, (int, float)))
        png = self._repr_png_()
        image = f'<img src="data:image/png;base64,{base64.b64encode(png).decode()}">' if png else ""
        return f"{image}<details><summary>{html.escape(repr(self))}</summary><table>{rows}</table></details>"

    def __repr__(self):
        return f"Trace({str(self.folder)!r})"


def _unpickled(folder, summary, told):
    return Trace(folder, _summary=summary, _warnings=told)


class _Temporary:
    """Temporary folder, deleted with its object or at exit, only by the process that made it: a forked process has a copy of
    the object, but does not own the folder."""

    def __init__(self):
        import tempfile

        self.name = tempfile.mkdtemp(prefix="palpa-")
        self._finalizer = weakref.finalize(self, _remove, self.name, os.getpid())

    def remove(self):
        self._finalizer()


def _remove(folder, made_by):
    import shutil

    if os.getpid() == made_by:
        shutil.rmtree(folder, ignore_errors=True)


def _new_folder(out):
    """Folder of a new trace, and, if none is named, its temporary parent."""
    if out is not None:
        if not isinstance(out, (str, os.PathLike)):
            raise TypeError(f"'out' takes the path of a folder that is made, not {type(out).__name__}")
        return Path(out), None
    temporary = _Temporary()
    return Path(temporary.name) / "trace", temporary


def _in_python(sentence):
    """Sentence with the program's options replaced by Python keywords."""
    return re.sub(r"--hand-(place|hold) (\w+)", r"\1='\2'", sentence)


def _tell(told):
    """Raises sentences as warnings; returns them with Python keywords."""
    told = tuple(_in_python(sentence) for sentence in told)
    for sentence in told:
        warnings.warn(sentence, PalpaWarning, stacklevel=3)
    return told


def _hand_given(hand, dt_s, rate_hz, place, fit):
    """Options for the library from a hand: simulated, a file, or positions."""
    is_word = isinstance(hand, (str, os.PathLike))
    if fit is not None:
        if place is not None:
            raise TypeError("'place' says where a recording lies; leave out 'fit'")
        if is_word and not str(hand).startswith("sim:"):
            place = _palpa.place_by_fit(hand, bool(fit))
            warnings.warn(f"'fit' is called place={place!r} now", PalpaWarning, stacklevel=3)
    if is_word:
        if dt_s is not None:
            raise TypeError("'dt_s' is the time step of an array of positions; a file has its own times")
        return dict(hand=str(hand), place=place, rate_hz=1000.0 if rate_hz is None else rate_hz)
    positions_m = _palpa.numbers_of(hand)  # NaN where masked: the position is unknown
    if positions_m is None or positions_m.ndim != 2 or positions_m.shape[1] != 3:
        raise TypeError("'hand' takes 'sim:…', the path of a recorded hand, or an array of positions [m] of shape (n, 3), not "
                        + (f"an array of shape {positions_m.shape}" if isinstance(hand, numpy.ndarray) and positions_m is not None
                           else type(hand).__name__))
    if dt_s is None or numpy.ndim(dt_s) != 0:
        raise TypeError("an array of positions has one time step: run(scene, positions_m, dt_s), 1e-3 for a millisecond")
    dt_s = _palpa.time_step_of(dt_s)
    if place not in (None, "as_recorded"):
        raise ValueError("an array of positions is felt where it is: place='as_recorded' or none; move the array instead")
    return dict(positions_m=positions_m, dt_s=dt_s, rate_hz=1.0 / dt_s if rate_hz is None else rate_hz)


def run(scene: Scene | str | PathLike, hand: str | PathLike | numpy.typing.ArrayLike, dt_s: float | None = None, *,
        duration_s: float | None = None, rate_hz: float | None = None, out: str | PathLike | None = None, hold: str | None = None,
        device: str | None = None, place: str | None = None, primitives: bool = False, data: Sequence[str | PathLike] = (),
        fit: bool | None = None) -> Trace:
    """Runs a scene with a hand and records it: a Trace.

    scene: a Scene, or the path of a scene file. hand: "sim:press", "sim:stroke", "sim:circle", "sim:helix", "sim:random", with
    keys after a comma (docs/hands.md); the path of a recorded hand; or positions [m] of shape (n, 3) in the hand frame, with
    dt_s [s], a tick each and never moved.
    place: placement of a recorded hand, "fitted" (with most contact; the default, except for ticks.csv of a trace), "centred"
    or "as_recorded". duration_s: [s] None: the recording's, or 10. rate_hz: [Hz] 1 to 100000; None: 1000, for positions 1 /
    dt_s. out: the trace's folder, which must not exist; None: a temporary folder, deleted with the Trace. hold: "rigid",
    "relaxed", "firm". device: device of a simulated hand, "touch", … primitives: records sub-steps and primitives, too.
    fit: name of `place` in earlier versions.
    Remarks on the run are PalpaWarnings, also in trace.warnings: a hand that was moved, nothing felt, …
    Ctrl-C ends it; the recording in `out` up to then is complete.
    """
    given = _hand_given(hand, dt_s, rate_hz, place, fit)
    if not isinstance(scene, (Scene, str, PathLike)):
        raise TypeError(f"'scene' takes a palpa.Scene or the path of a scene file, not {type(scene).__name__}")
    folder, temporary = _new_folder(out)
    given.update(duration_s=duration_s, out=folder, hold=hold, device=device, primitives=primitives, data=paths(data, "data"),
                 plugins=list(plugins))
    if not isinstance(scene, Scene):
        given["scene"] = scene
    try:
        summary, told = _palpa.run(scene, given)
    except _palpa.LoadError as error:
        several = re.search(r"^(.*: the scene has .* hands .*), and 1 is given; .* only_hand=(\w+)$", str(error))
        if not several:
            raise
        raise _palpa.LoadError(f"{several[1]}; feel one of them: palpa.run(palpa.load_scene(…, hand={several[2]!r}), …)") from None
    return Trace(folder, _summary=json.loads(summary), _warnings=_tell(told), _temporary=temporary)


class LawComparison(Strict):
    """Laws of earlier systems against the exact one, under one hand.

    ticks, balances, left_out: numbers of compared ticks and balances, and of sub-steps that could not be compared.
    posed_m: by law, its errors [m] on the exact law's balances, in rising order.
    alone_n: by law, its force differences [N] when it runs the scene alone, in rising order.
    """

    ticks: int
    balances: int
    left_out: int
    posed_m: dict[str, numpy.ndarray]
    alone_n: dict[str, numpy.ndarray]

    def __init__(self, _told: tuple[Any, ...]) -> None:
        self.ticks, self.balances, self.left_out, errors, self._markdown = _told
        self.posed_m = {law: posed for law, (posed, _) in errors.items()}
        self.alone_n = {law: alone for law, (_, alone) in errors.items()}

    def __str__(self):
        return self._markdown

    def __repr__(self):
        return f"LawComparison(laws={list(self.posed_m)}, ticks={self.ticks}, balances={self.balances})"

    def _repr_markdown_(self):
        return self._markdown


def compare_laws(scene: Scene, positions_m: numpy.typing.ArrayLike, dt_s: float,
                 laws: Sequence[str] | None = None) -> LawComparison:
    """Runs a scene with the exact law at positions_m, shape (n, 3), a tick of dt_s [s] each; solves every balance by each of
    `laws`, too, then runs the scene with each law alone. None: all of palpa.laws(). A LawComparison."""
    laws = _palpa.laws()[1:] if laws is None else [laws] if isinstance(laws, str) else list(laws)
    return LawComparison(_palpa.compare_laws(scene, positions_m, dt_s, laws))
