"""Scenes and volumes."""

from __future__ import annotations

import inspect
import json
import warnings
from collections.abc import Iterable, Mapping, Sequence
from operator import index
from os import PathLike
from typing import Any, NamedTuple

from numpy import allclose, bool_, broadcast_to, eye, float32, float64, generic, ma, nan, ndarray
from numpy.typing import ArrayLike

from . import _palpa
from ._modes import Mode, mode_of
from ._palpa import Mask, Volume
from ._parameters import Named, Parameters, Strict, make_class
from ._plots import png_or_none, scene_figure

CouplingOptions = make_class("CouplingOptions", Parameters, "The spring between hand and proxy.", _palpa.part_keys("coupling"),
                             lambda: _palpa.Scene()._coupling())
Workspace = make_class("Workspace", Parameters, "How the hand's reach lies in the world.", _palpa.part_keys("workspace"),
                       lambda: _palpa.Scene()._workspace())
TimeOptions = make_class("TimeOptions", Parameters, "How the data's time goes while the hand feels.", _palpa.part_keys("time"),
                         lambda: _palpa.Scene()._time())
ToolOptions = make_class("ToolOptions", Parameters, "The tool in the hand: where it touches the data. It is set as a whole.",
                         _palpa.part_keys("tool"), _palpa.new_tool)


def _part_property(cls, name, doc):
    getter = getattr(_palpa.Scene, f"_{name}")

    def get(self):
        return cls._of(getter(self))

    def put(self, value):
        if not isinstance(value, cls):
            raise TypeError(f"Scene: '{name}' takes a palpa.{cls.__name__}, not {type(value).__name__}")
        into = get(self)
        for key, each in value._values().items():
            setattr(into, key, each)

    return property(get, put, doc=doc)


class SceneMode(Strict):
    """A mode of a scene. Changes apply to the scene."""

    def __init__(self, scene: Scene, name: str) -> None:
        self._scene, self._name = scene, name

    @property
    def _elsewhere(self):
        mode = self.mode
        return [("mode", type(mode)._attributes)] if mode is not None else []

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(self._unknown(name))

    @property
    def name(self) -> str:
        """its name in events, tables and traces"""
        return self._name

    @property
    def mode(self) -> Mode | None:
        """the mode itself; None for a mode in Python or C"""
        return mode_of(self._scene._mode(self._name))

    @property
    def enabled(self) -> bool:
        """False: it places no primitives"""
        return self._scene._is_enabled(self._name)

    @enabled.setter
    def enabled(self, enabled: bool) -> None:
        _check_flag("SceneMode", "enabled", enabled)
        self._scene._enable(self._name, enabled)

    @property
    def feet(self) -> str | None:
        """"all" or "first": the feet of a tool that feel it; None: all of a mode with levels, else the first"""
        return self._scene._feet(self._name)

    @feet.setter
    def feet(self, feet: str | None) -> None:
        self._scene._set_feet(self._name, feet)

    @property
    def masks(self) -> tuple[Mask, ...]:
        """factors between 0 and 1 on all its strengths and drags: palpa.Mask each"""
        return self._scene._masks(self._name)

    @masks.setter
    def masks(self, masks: Iterable[Mask]) -> None:
        self._scene._set_masks(self._name, _masks(masks))

    def __repr__(self):
        return f"SceneMode(name={self._name!r}, mode={self.mode!r}, enabled={self.enabled})"


class SceneHand(NamedTuple):
    """A hand of a scene of several: `at_m` [m], shape (3,), the middle of its reach in the workspace's hand frame; `tool`, a copy
    of its palpa.ToolOptions."""

    at_m: Any
    tool: Any


def _check_flag(place, name, value):
    if not isinstance(value, (bool, bool_)):
        raise TypeError(f"{place}: '{name}' takes True or False, not {type(value).__name__}")


def _masks(given):
    if isinstance(given, (Mask, str)) or not isinstance(given, Iterable):
        raise TypeError(f"'masks' takes a list of palpa.Mask: [palpa.Mask(…)], not {type(given).__name__}")
    return list(given)


def _of_coupling(name):
    """Property of a scene for a key of its coupling."""
    return property(lambda scene: getattr(scene.coupling, name), lambda scene, value: setattr(scene.coupling, name, value),
                    doc=getattr(CouplingOptions, name).__doc__)


class Scene(_palpa.Scene, Strict):
    """A scene: volumes, modes, coupling, workspace, law; everything for a session except the device.

    Keyword arguments are those of CouplingOptions: palpa.Scene(stiffness_n_per_m=400). They are attributes, too:
    scene.stiffness_n_per_m is scene.coupling.stiffness_n_per_m. An unknown attribute raises AttributeError.
    tool: palpa.ToolOptions; None: a point.
    """

    _elsewhere = (("workspace", Workspace._attributes), ("time", TimeOptions._attributes), ("tool", ToolOptions._attributes))

    def __init__(self, *, tool=None, _of=None, **coupling):
        super().__init__(*([] if _of is None else [_of]))
        if tool is not None:
            self.tool = tool
        if coupling:
            try:
                self.coupling._fill(coupling)
            except TypeError as error:
                raise TypeError(str(error).replace("CouplingOptions", "Scene", 1)) from None

    coupling = _part_property(CouplingOptions, "coupling", "the spring between hand and proxy")
    workspace = _part_property(Workspace, "workspace", "how the hand's reach lies in the world")
    time = _part_property(TimeOptions, "time", "how the data's time goes while the hand feels")

    @property
    def tool(self) -> ToolOptions:
        """the tool in the hand; a point by default"""
        return ToolOptions._of(self._tool())

    @tool.setter
    def tool(self, tool: ToolOptions) -> None:
        if not isinstance(tool, ToolOptions):
            raise TypeError(f"Scene: 'tool' takes a palpa.ToolOptions, not {type(tool).__name__}")
        self._set_tool(tool._part)

    for _name in CouplingOptions._attributes:
        locals()[_name] = _of_coupling(_name)
    del _name

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(self._unknown(name))

    def add(self, name: str, what: Volume | Mode, *, masks: Iterable[Mask] = (), enabled: bool = True,
            filter: str | None = None, feet: str | None = None) -> str:
        """Adds a volume, or a mode after its fields; returns the name of the volume's first field, or the mode's name.

        filter: for a volume, "trilinear", "smooth" or "cubic"; None: the default of its voxels.
        masks, enabled, feet: for a mode, as in palpa.SceneMode. The scene holds a copy: change it by scene.modes[name].mode.
        """
        if not isinstance(name, str):
            raise TypeError(f"Scene.add: 'name' takes a text, not {type(name).__name__}")
        _check_flag("Scene.add", "enabled", enabled)
        masks = _masks(masks)
        if isinstance(what, _palpa.Volume):
            if masks or not enabled or feet is not None:
                raise TypeError(f"Scene.add: 'masks', 'enabled' and 'feet' are of modes, and {name!r} is a volume")
            return self._add_volume(name, what, filter)
        if not isinstance(what, Mode):
            raise TypeError(f"{name!r} is to be a palpa.Volume or a palpa.Mode, not {type(what).__name__}")
        if filter is not None:
            raise TypeError(f"Scene.add: 'filter' is of volumes, and {name!r} is a mode")
        self._add_mode(name, what._to_part(), masks, enabled, feet)
        return name

    def add_array(self, name: str, array: ndarray, spacing_m: float | Sequence[float] | None = None, *,
                  origin_m: Sequence[float] | None = None, axes: ArrayLike | None = None, unit: str = "",
                  copy: bool = False, filter: str | None = None) -> str:
        """Adds an array as a volume, without a copy; returns the name of its field. See palpa.array_volume."""
        return self.add(name, _array_volume(array, spacing_m, origin_m, axes, unit, copy), filter=filter)

    @property
    def volumes(self) -> Mapping[str, Volume]:
        """its volumes by name, with their interpolation filters"""
        return Named("the scene", "volume", self._volumes())

    @property
    def modes(self) -> Mapping[str, SceneMode]:
        """its modes by name, as SceneMode"""
        return Named("the scene", "mode", {name: SceneMode(self, name) for name in self._mode_names()})

    @property
    def hands(self) -> Mapping[str, SceneHand]:
        """its hands by name, as SceneHand; empty: one hand without a name, with `tool`"""
        return Named("the scene", "hand", {name: SceneHand(at_m, ToolOptions._of(tool)) for name, at_m, tool in self._hands()})

    def add_hand(self, name: str, *, at_m: Sequence[float] = (0, 0, 0), tool: ToolOptions | None = None) -> None:
        """Adds one of several hands, a [[hand]] of a scene file. Raises SceneError. A palpa.Session, palpa.run and palpa.live of
        the scene are those of its first hand; `of_hand` makes the scenes of the others.

        at_m: [m] the middle of its reach, in the workspace's hand frame. tool: None: a point.
        """
        if not isinstance(name, str):
            raise TypeError(f"Scene.add_hand: 'name' takes a text, not {type(name).__name__}")
        tool = ToolOptions() if tool is None else tool
        if not isinstance(tool, ToolOptions):
            raise TypeError(f"Scene.add_hand: 'tool' takes a palpa.ToolOptions, not {type(tool).__name__}")
        self._add_hand(name, at_m, tool._part)

    def of_hand(self, hand: str | int) -> Scene:
        """The scene of a single hand, by its name or its number from 0: its tool, no other hand, the same voxels.

        Its hand frame begins at the hand's `at_m`. Raises SceneError for an unknown name, IndexError for a number.
        """
        if isinstance(hand, str):
            return Scene(_of=self._of_hand(hand))
        if isinstance(hand, bool) or not hasattr(hand, "__index__"):
            raise TypeError(f"'hand' takes the name or the number of a hand, not {type(hand).__name__}")
        count = max(1, len(self.hands))
        if not 0 <= index(hand) < count:
            raise IndexError(f"'hand' is {hand}; the scene has {count} {'hand' if count == 1 else 'hands'}, counted from 0")
        return Scene(_of=self._of_hand(index(hand)))

    def copy(self) -> Scene:
        """An independent scene that shares the voxels."""
        return Scene(_of=self)

    __copy__ = copy
    __hash__ = None

    def __deepcopy__(self, memo):
        return self.copy()

    def __reduce__(self):
        return _unpickled, (_palpa.scene_state(self),)

    def plot(self) -> Any:
        """A figure of matplotlib: three slices through the middle of its first volume, with the levels of its modes as lines.
        Raises ImportError without matplotlib."""
        return scene_figure(self)

    def _repr_png_(self):
        return png_or_none(scene_figure, self)

    def __repr__(self):
        return f"Scene(volumes={list(self.volumes)}, modes={list(self.modes)})"


def _unpickled(state):
    return Scene(_of=_palpa.scene_of(state))


def array_volume(array: ndarray, spacing_m: float | Sequence[float] | None = None, *, origin_m: Sequence[float] | None = None,
                 axes: ArrayLike | None = None, unit: str = "", copy: bool = False) -> Volume:
    """A volume of one field that reads a numpy array in place, at once: its range is computed when a scene needs it.

    array: indexed [z, y, x], or [z, y, x, component] with 3 components; uint8, int16, uint16, int32, float32 or float64 in any
    order of its axes, also reversed, if the voxels are contiguous. The volume keeps it and makes it and its bases read-only,
    because its range is computed once. Earlier views of it stay writeable: do not write through them.
    spacing_m: [m] between voxels, one number or along x, y, z; default 1, with a PalpaWarning. origin_m: [m] of the voxel
    [0, 0, 0]; None: the array is centred at the world's origin. axes: shape (3, 3), columns of length 1, the directions of x,
    y, z in the world, as in ITK and VTK; None: the world's axes. unit: a label.
    copy: True reads a copy, from any numeric type and order.
    NaN and infinity are voxels without data, as are masked voxels of a masked array, which is copied.
    """
    return _array_volume(array, spacing_m, origin_m, axes, unit, copy)


def _array_volume(given, spacing_m, origin_m, axes, unit, copy):
    array = _without_masked(given) if isinstance(given, ma.MaskedArray) else given
    if spacing_m is None:
        spacing_m = 1.0
        widest = max(array.shape[:3]) - 1 if getattr(array, "ndim", 0) >= 3 else 0
        warnings.warn(f"'spacing_m' was not given: the voxels are 1 m apart, so that the array is {widest} m long; "
                      "0.001 is a millimetre", PalpaWarning, stacklevel=3)
    spacing = _palpa.numbers_of(spacing_m)
    if spacing is None or isinstance(spacing_m, bool) or spacing.shape not in ((), (3,)):
        raise TypeError(f"'spacing_m' takes a number or three numbers [x, y, z], not {spacing_m!r:.60}")
    directions = eye(3) if axes is None else _palpa.numbers_of(axes)
    if directions is None or directions.shape != (3, 3):
        shown = type(axes).__name__ if directions is None else f"an array of shape {directions.shape}"
        raise ValueError(f"'axes' takes a matrix of shape (3, 3), a column for each of x, y, z, not {shown}")
    lengths = (directions**2).sum(axis=0) ** 0.5
    if not allclose(lengths, 1.0, rtol=0.0, atol=_length_tolerance):
        raise ValueError(f"'axes' has columns of the lengths {', '.join(format(each, '.6g') for each in lengths)}; they are "
                         "directions, of length 1, and 'spacing_m' says the distances")
    volume = _palpa.array_volume(array, broadcast_to(spacing, 3), directions.ravel().tolist(), origin_m, None, unit, copy)
    if array is not given and not copy and not ma.is_masked(given):
        given.flags.writeable = False  # the volume reads a view of it
    return volume


# For directions with six digits, as in files. More: distances are wrong; less: directions of files are refused.
_length_tolerance = 1e-5


def _without_masked(array):
    """View of the array; if voxels are masked, a copy with NaN in them, which is no data."""
    if not ma.is_masked(array):
        return array.data
    if array.dtype.kind not in "buif":
        raise TypeError(f"an array of {array.dtype} holds no voxels; use whole numbers or floats")
    holds_nan = float32 if array.dtype.itemsize <= (4 if array.dtype.kind == "f" else 2) else float64
    return array.astype(holds_nan).filled(nan)


def read_volume(path: str | PathLike | Sequence[str | PathLike], **how: object) -> Volume:
    """Opens a file, a list of related files, or a folder, in a separate process.

    how: properties that the file leaves open, as in [volume.NAME] of a scene file (docs/scene.md): length_unit, frame, series,
    type, dims, spacing_m, …; `as_` for `as`. Raises LoadError.
    """
    try:
        return _palpa.read_volume(paths(path, "path"), {name.rstrip("_"): value for name, value in how.items()})
    except AttributeError as error:
        raise TypeError(f"read_volume: {error}") from None


def paths(given, name):
    """A path or several paths as a list."""
    several = [given] if isinstance(given, (str, PathLike)) else list(given) if isinstance(given, Iterable) else [None]
    if not all(isinstance(each, (str, PathLike)) for each in several):
        raise TypeError(f"'{name}' takes a path or a list of paths, not {type(given).__name__}")
    return several


def load_scene(path: str | PathLike, *, data: Sequence[str | PathLike] = (), sets: Mapping[str, object] | None = None,
               hand: str | int | None = None) -> Scene:
    """Reads a scene file. Raises SceneError with file, line and column.

    data: folders to search for its files. sets: values of keys, {"coupling.stiffness_n_per_m": 300}. hand: of several hands
    only this one, as in Scene.of_hand; None: all.
    """
    if not isinstance(path, (str, PathLike)):
        raise TypeError(f"'path' takes the path of a scene file, not {type(path).__name__}")
    if not isinstance(sets or {}, Mapping) or not all(isinstance(key, str) for key in sets or {}):
        raise TypeError("'sets' takes a dict of values by their keys, as {'coupling.stiffness_n_per_m': 300}")
    written = [(key, value if isinstance(value, str) else _in_toml(key, value)) for key, value in (sets or {}).items()]
    scene, told = _palpa.load_scene(path, paths(data, "data"), written)
    for sentence in told:
        warnings.warn(sentence, PalpaWarning, stacklevel=2)
    return Scene(_of=scene) if hand is None else Scene(_of=scene).of_hand(hand)


def _in_toml(key, value):
    """A value in TOML."""
    if isinstance(value, (ndarray, generic)):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_in_toml(key, each) for each in value) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, (bool, int, float)):
        return repr(value).lower()
    raise TypeError(f"'sets': {key!r} takes a number, a text, True, False or a list of them, not {type(value).__name__}")


Scene.__init__.__signature__ = inspect.Signature([
    inspect.Parameter("self", inspect.Parameter.POSITIONAL_OR_KEYWORD), *CouplingOptions.__signature__.parameters.values(),
    inspect.Parameter("tool", inspect.Parameter.KEYWORD_ONLY, default=None, annotation="ToolOptions | None")])


class PalpaWarning(UserWarning):
    """Warning of probably unintended input or results."""
