"""Modes: built-in, from plug-ins, and user-defined in Python or C."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from types import MappingProxyType
from typing import Any

from . import _palpa
from ._parameters import Parameters, Strict, class_name, make_class


class Mode:
    """A mode: reads fields at the proxy and places primitives.

    A mode in Python is a class derived from this:

        class Ridge(palpa.Mode):
            fields = ("field",)             # attributes with names of the fields to read

            def __init__(self, field, strength_n=0.5):
                self.field, self.strength_n = field, strength_n

            def place(self, here, out):     # stateless: called any number of times
                sample = here.scalar(self.field)
                if sample.inside:
                    out.point(0, here.proxy_m, here.newtons(self.strength_n))

    `here` is a palpa.ModeContext, `out` a palpa.PrimitiveSink. Further members of the class, all optional:

    held_levels : names of attributes with values of the field that `field` names: the tick stops at each, and no sub-step crosses one
        that a plane stands on (`level=here.level(field, value)`). A mode with levels begins to act only at one.
    strengths : names of attributes that may hold a palpa.Strength, for here.newtons
    memory : {name: first value}, at most 31 numbers that the session keeps. Then the methods are place(self, here, memory, out)
        and on_step_accepted(self, step, memory), once per accepted sub-step, which alone changes the dict `memory`; `step` is a
        palpa.StepResult.
    strict : True: an invalid primitive (a direction that is not of unit length, NaN, a negative strength, a drag away from
        here.proxy_m) raises ValueError, with the mode's name. False: it is dropped, counted in Tick.dropped and reported once in
        Session.events, as for a mode in C++.

    Usable in a Session and in palpa.run, not in real time: for that a palpa.CFunction takes a C function.
    """

    fields: tuple[str, ...] = ()
    held_levels: tuple[str, ...] = ()
    strengths: tuple[str, ...] = ()
    memory: Mapping[str, float] = MappingProxyType({})
    strict: bool = True

    def place(self, *arguments: Any, **named: Any) -> None:
        """Places primitives: place(self, here, out), or place(self, here, memory, out) in a class with a memory."""
        raise NotImplementedError(f"{type(self).__name__} has no method 'place(self, here, out)'")

    def __repr__(self):
        said = [f"{name}={getattr(self, name, None)!r}" for name in (*self.fields, *self.held_levels, *self.strengths)]
        return f"{type(self).__name__}({', '.join(said)})"

    def _to_part(self):
        of_class = type(self).__name__
        fields = _names_of(self.fields, "fields")
        for name in fields:
            if not isinstance(getattr(self, name, None), str):
                raise TypeError(f"{of_class}: 'fields' has {name!r}, an attribute with the name of a field; it is "
                                + (type(getattr(self, name)).__name__ if hasattr(self, name) else "not there"))
        levels = [(name, value) for name in _names_of(self.held_levels, "held_levels") for value in self._levels_of(name)]
        if levels and "field" not in fields:
            raise TypeError(f"{of_class}: 'held_levels' are values of the field that the attribute 'field' names; 'fields' lists it, too")
        strengths = [(name, getattr(self, name)) for name in _names_of(self.strengths, "strengths")]
        strengths = [(name, strength) for name, strength in strengths if isinstance(strength, _palpa.Strength)]
        if bool(self.memory) != hasattr(self, "on_step_accepted"):
            raise TypeError(f"{of_class}: " + ("'memory' is changed by a method 'on_step_accepted(self, step, memory)', which it has not"
                                               if self.memory else "'on_step_accepted' changes a memory; 'memory' lists its numbers: {'held': 0.0}"))
        return _palpa.python_mode(self, [(name, getattr(self, name)) for name in fields], strengths, levels,
                                  list(self.memory.items()), bool(self.strict))

    def _levels_of(self, name):
        given = getattr(self, name, None)
        values = None if given is None else _palpa.numbers_of(given)
        if values is None or values.ndim > 1:
            raise TypeError(f"{type(self).__name__}: 'held_levels' has {name!r}, an attribute with a number or several; it is "
                            + (type(getattr(self, name)).__name__ if hasattr(self, name) else "not there"))
        return values.ravel().tolist()


class _ListedMode(Parameters, Mode):
    """A mode with a list of parameters."""

    _keys = ()

    def _to_part(self):
        return self._part


class CFunction(Strict, Mode):
    """A mode that is a C function, `int place(const double* in, double* out)`, fast enough for a live scene.

    function : an object with an `address` (a numba.cfunc), a function pointer of ctypes, or an address as an int
    scalars, vectors : names of the fields to read, at most 8 together
    `in`: proxy, probe and sample positions [m], 3 numbers each; time step [s]; coupling stiffness [N/m]; then of each scalar
    field inside (1 or 0), value, gradient (3) [unit/m]; of each vector field inside, value (3), Jacobian (9).
    `out`: room for 16 rows of 9: kind (0 point, 1 line, 2 plane, 3 directed force), position (3) [m], direction (3), strength
    [N], drag [N*s/m]. Returns the number of rows; rows beyond 16 are dropped with a PalpaWarning.
    Invalid primitives are dropped and counted in Tick.dropped. Masks and the fade at the edges of data act on strengths and
    drags.
    """

    function: Any
    scalars: tuple[str, ...]
    vectors: tuple[str, ...]

    def __init__(self, function: Any, scalars: Sequence[str] = (), vectors: Sequence[str] = ()) -> None:
        self.function, self.scalars, self.vectors = function, _names_of(scalars, "scalars"), _names_of(vectors, "vectors")
        self._address()

    def __repr__(self):
        named = getattr(self.function, "__name__", type(self.function).__name__)
        return f"CFunction({named}, scalars={self.scalars!r}, vectors={self.vectors!r})"

    def _address(self):
        import ctypes

        function = self.function
        if hasattr(function, "address"):
            address = function.address
        elif isinstance(function, ctypes._CFuncPtr):
            address = ctypes.cast(function, ctypes.c_void_p).value
        elif isinstance(function, int) and not isinstance(function, bool):
            address = function
        else:
            raise TypeError(f"'function' takes a function of C (numba.cfunc, ctypes or an address), not {type(function).__name__}")
        if not address:
            raise ValueError("'function' has the address 0; give that of a function of C")
        return address

    def _to_part(self):
        numbered = lambda kind, names: [(f"{kind} {n}", name) for n, name in enumerate(names)]
        return _palpa.c_function_mode(self._address(), numbered("scalar", self.scalars), numbered("vector", self.vectors),
                                      self.function)


def _names_of(names, attribute):
    """Names of fields as a tuple; refuses a single text, each letter of which would be a name."""
    if isinstance(names, str) or not all(isinstance(name, str) for name in names):
        raise TypeError(f"'{attribute}' takes names of fields, ('ct',), not {names!r}")
    return tuple(names)


classes = {}  # by mode type


def make_classes(module):
    """Makes the missing classes of mode types."""
    made = []
    for mode_type, summary, keys in _palpa.mode_types():
        if mode_type not in classes:
            classes[mode_type] = make_class(class_name(mode_type), _ListedMode, summary, keys,
                                            lambda mode_type=mode_type: _palpa.new_mode(mode_type))
            made.append(classes[mode_type])
            setattr(module, class_name(mode_type), classes[mode_type])
    return made


plugins = []  # files of loaded plug-ins


def load_plugin(file: str | PathLike) -> list[type[Mode]]:
    """Loads the modes of a plug-in, a shared library that runs with all rights of this process; returns their classes.

    Each becomes palpa.NAME, too: lab.ridge is palpa.LabRidge.
    """
    import sys

    if not isinstance(file, (str, PathLike)):
        raise TypeError(f"'file' takes the path of a shared library, not {type(file).__name__}")
    _palpa.load_plugin(file)
    plugins.append(file)
    return make_classes(sys.modules["palpa"])


def mode_of(part):
    """Object of a mode in a scene, which shares its parameters; None for a mode in Python or C."""
    cls = classes.get(part.type())
    return cls._of(part) if cls else None
