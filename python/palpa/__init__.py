"""Palpa: touch volumetric data. Scenes, sessions, runs and traces of the C++ library, under the same names and in the same units.

    import palpa
    scene = palpa.Scene(stiffness_n_per_m=400)
    head = scene.add("head", palpa.head_phantom())
    scene.add("skin", palpa.SurfaceAndFriction(field=head, levels=[dict(value=-300, strength_n=0.8, friction_n=0.1)]))
    session = palpa.Session(scene)
    for n in range(100):
        tick = session.tick((0, 0.02, 0.05 - 0.0001 * n), 1e-3)     # tick.proxy_m, tick.force_n, tick.error_bound_m

Numbers have their unit in their name; lengths are metres. Wrong input raises an exception of one line with the remedy:
LoadError and SceneError for files and scenes, else TypeError and ValueError.
"""

import os as _os
import pathlib as _pathlib
import sys as _sys


def _why_not_here():
    """Reason why this interpreter cannot load the binding module; empty: unknown."""
    import importlib.machinery
    import importlib.util
    import re

    here = _pathlib.Path(__file__).absolute().parent
    ours = f"{_sys.implementation.name} {_sys.version_info[0]}.{_sys.version_info[1]}"
    if not any((here / f"_palpa{suffix}").exists() for suffix in importlib.machinery.EXTENSION_SUFFIXES):
        for file in here.glob("_palpa.*"):
            made_for = re.search(r"\.cpython-3(\d+)-", file.name)
            if made_for:
                builds = f", or build it for this one (-DPython_EXECUTABLE={_sys.executable})" if _sys.version_info >= (3, 11) else ""
                return (f"palpa was built for CPython 3.{made_for[1]}, this is {ours} ({_sys.executable}); use "
                        f"python3.{made_for[1]}{builds}")
        if not (here / "_version.py").exists():
            return (f"palpa: {here} holds the package's sources, without the module that is built of them; PYTHONPATH takes the folder "
                    "'python' of the build folder, build/release/python")
        return f"palpa: its module _palpa is not built in {here}; cmake --build makes it as palpa_python"
    if importlib.util.find_spec("numpy") is None:
        return (f"palpa needs numpy, which {_sys.executable} has not; install it there (Debian's own python3: "
                "apt install python3-numpy)")
    return ""


def _check_numpy(of, pybind11):
    """Raises ImportError for a numpy that the module cannot read: pybind11 supports numpy 2 from its version 2.12 on."""
    if int(of.split(".")[0]) >= 2 and tuple(map(int, pybind11.split(".")[:2])) < (2, 12):
        raise ImportError(f"palpa was built with pybind11 {pybind11}, which reads arrays of numpy 1 only, and this is numpy {of}; "
                          "install \"numpy<2\", or build palpa with pybind11 2.12 or later", name="palpa")


try:
    from ._version import pybind11 as _pybind11, version as __version__
    import numpy as _numpy

    _check_numpy(_numpy.__version__, _pybind11)
    from . import _palpa
except ImportError as _error:
    _why = _why_not_here()
    if _why:
        raise ImportError(_why, name="palpa") from None
    raise

if _palpa.version != __version__:
    raise ImportError(f"palpa: the module is of version {_palpa.version}, the package of {__version__}; install both anew")

# In a build folder palpa-read is in bin beside this package's folder; installed, the library has its path.
_reader = _pathlib.Path(__file__).absolute().parents[2] / "bin" / "palpa-read"
if _reader.exists():
    _os.environ.setdefault("PALPA_READER", str(_reader))

from ._palpa import (DeviceLimits, DeviceState, Energy, Field, GuardedSession, GuardedTick, HeldLevel, ModeContext, LoadError, Mask, ModeForce, PrimitiveSink,
                     MouseHand, ScalarSample, SceneError, Session, StepResult, Strength, Tick, TickStatus, VectorSample, Volume, beating_chamber, bored_block, burgers_vortex, head_phantom, lamb_oseen_vortex, laws,
                     plane_field, ring_vortex, sphere_field, wing_wake)
from ._device import Device
from ._images import from_image
from ._live import Live, live
from ._modes import CFunction, Mode, load_plugin, make_classes as _make_classes
from ._scene import (CouplingOptions, PalpaWarning, Scene, SceneHand, SceneMode, TimeOptions, ToolOptions, Workspace, array_volume, load_scene,
                     read_volume)
from ._parameters import Named as _Named, say_what_cannot_be_set as _say_what_cannot_be_set
from ._renamed import keep_old_names as _keep_old_names, old_names_of as _old_names_of
from ._session import Ticks, modes as _modes_of_session, not_pickled as _not_pickled, rollout, ticks as _ticks
from ._store import Store, open_store, prepare
from ._trace import LawComparison, Replay, Trace, compare_laws, run
from ._vtk import FeltActors, MousePointer, from_vtk, strength_from_vtk, to_pyvista, to_vtk

LoadError.__doc__ = "A file that cannot be read or written: one line with the place, what is wrong and what would be right."
SceneError.__doc__ = "A scene that does not fit together: one line with its place, file and line where it has one."
_make_classes(_sys.modules[__name__])
# Rows of `ticks` hold the status as a number, which compares with a TickStatus.
TickStatus.__eq__ = lambda status, other: int(status) == (int(other) if isinstance(other, TickStatus) else other)
TickStatus.__ne__ = lambda status, other: int(status) != (int(other) if isinstance(other, TickStatus) else other)
Session.ticks, Session.modes, Session.__reduce__ = _ticks, _modes_of_session, _not_pickled
Volume.fields = property(lambda volume: _Named("the volume", "field", volume._fields()), doc="its fields by name")
Session.scene = property(lambda session: Scene(_of=session._scene()), doc="a copy of its scene")

for _thing in list(vars().values()):
    if isinstance(_thing, type) and _thing.__module__ == "palpa._palpa" and not issubclass(_thing, Exception):
        _say_what_cannot_be_set(_thing)
for _name, _thing in list(vars().items()):  # public names in messages
    if not _name.startswith("_") and getattr(_thing, "__module__", "").startswith("palpa._"):
        try:
            _thing.__module__ = "palpa"
        except (AttributeError, TypeError):
            pass
__all__ = sorted(name for name in vars() if not name.startswith("_"))

# After the list of public names: these are none.
_keep_old_names(Field, extents="value_ranges")
_keep_old_names(Live, look="latest", account="statistics")
__getattr__ = _old_names_of(_sys.modules[__name__], Here="ModeContext", Out="PrimitiveSink", ModeTick="ModeForce", Pointer="MouseHand")
