"""Stores larger than memory: preparation, and chunks as arrays."""

from __future__ import annotations

from os import PathLike, fspath
from typing import Any

from numpy import ndarray

from . import _palpa


def prepare(store: str | PathLike[str], *, part: tuple[int, int] | None = None, into: str | PathLike[str] | None = None,
            threads: int = 0, check: bool = False, derive: str | None = None) -> dict[str, Any]:
    """Makes an OME-Zarr store ready: its coarser octaves, and range and checksum of each chunk.

    part: (number, count), from (1, n) to (n, n): only these units, on one core; a last call without it makes the rest.
    into: write beside a store that must not be changed, into this folder. threads: 0 is all cores.
    check: write nothing; 'wrong_chunks' of the result names what is not as it was prepared.
    derive: "q=velocity" writes this derived field of the store instead, as `palpa prepare --derive`.
    Returns the counts of `palpa prepare --json`. Any process, any order, any number of times: the bytes are the same."""
    if part is not None:
        part = tuple(part)
        if len(part) != 2 or not all(isinstance(n, int) for n in part):
            raise TypeError(f"prepare: 'part' takes number and count, as (3, 64), not {part!r}")
    if threads < 0:
        raise ValueError(f"prepare: 'threads' is {threads}; give 1 or more, or 0 for all cores")
    return _palpa.prepare_store(fspath(store), part, None if into is None else fspath(into), threads, check, derive or "")


class Store:
    """An open OME-Zarr store, read chunk by chunk by a sandboxed program. `open_store` makes it."""

    def __init__(self, path: str | PathLike[str]) -> None:
        self._store = _palpa.StoreOfChunks(fspath(path))
        self.path = fspath(path)
        contents = self._store.contents()
        self.format: str = contents["format"]
        self.length_unit: str = contents["length_unit"]  # of the file; all numbers here are metres
        self.fields: list[dict[str, Any]] = contents["fields"]
        self.octaves: list[dict[str, Any]] = contents["octaves"]  # from the finest; dims and chunk along i, j, k
        self.frames: int = contents["frames"]
        self.period_s: float = contents["period_s"]
        self.prepared: bool = contents["prepared"]
        self.warnings: list[str] = contents["warnings"]

    def __repr__(self) -> str:
        dims = " x ".join(map(str, self.octaves[0]["dims"]))
        names = ", ".join(field["name"] for field in self.fields)
        return f"Store({self.path!r}: {dims} voxels, {len(self.octaves)} octaves, {names})"

    def read(self, octave: int, box: tuple[tuple[int, int], tuple[int, int], tuple[int, int]], *, frame: int = 0,
             field: int | str = 0) -> ndarray:
        """Voxels of a box, ((i0, i1), (j0, j1), (k0, k1)), the ends not included: an array [k, j, i], of a vector [k, j, i, 3]."""
        try:
            (i0, i1), (j0, j1), (k0, k1) = box
        except (TypeError, ValueError):
            raise TypeError(f"Store.read: 'box' takes first and end along i, j, k, as ((0, 64), (0, 64), (0, 32)), not {box!r}") from None
        return self._store.read(octave, [i0, j0, k0], [i1, j1, k1], frame, self._number_of(field))

    def chunk(self, octave: int, i: int, j: int, k: int, *, frame: int = 0, field: int | str = 0) -> ndarray:
        """Voxels of a chunk, by its place [chunks]; smaller at the end of an octave."""
        if not 0 <= octave < len(self.octaves):
            raise IndexError(f"no octave {octave}; they go from 0 to {len(self.octaves) - 1}")
        dims, chunk = self.octaves[octave]["dims"], self.octaves[octave]["chunk"]
        box = tuple((at * c, min((at + 1) * c, n)) for at, c, n in zip((i, j, k), chunk, dims))
        return self.read(octave, box, frame=frame, field=field)

    def _number_of(self, field: int | str) -> int:
        if isinstance(field, int):
            return field
        names = [each["name"] for each in self.fields]
        if field not in names:
            raise KeyError(f"no field {field!r}; there are: {', '.join(names)}")
        return names.index(field)


def open_store(path: str | PathLike[str]) -> Store:
    """Opens an OME-Zarr store, without reading any voxel. Raises LoadError, one line."""
    return Store(path)
