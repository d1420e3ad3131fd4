"""Scenes, volumes and what they are made of."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from typing import Any

from numpy import allclose, asarray, eye, float32, float64, ma, nan, ndarray, ndim
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


def _part_property(cls, getter, doc):
    def get(self):
        return cls._of(getter(self))

    def put(self, value):
        if not isinstance(value, cls):
            raise TypeError(f"takes a palpa.{cls.__name__}, not {type(value).__name__}")
        values = value._values()
        into = get(self)
        for name, each in values.items():
            setattr(into, name, each)

    return property(get, put, doc=doc)


class SceneMode(Strict):
    """A mode of a scene. What is changed here is changed in the scene."""

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
        """how events, tables and traces call it"""
        return self._name

    @property
    def mode(self) -> Mode | None:
        """the mode itself; None for one that is written in Python or C"""
        return mode_of(self._scene._mode(self._name))

    @property
    def enabled(self) -> bool:
        """False: it stays silent"""
        return self._scene._is_enabled(self._name)

    @enabled.setter
    def enabled(self, enabled: bool) -> None:
        self._scene._enable(self._name, enabled)

    @property
    def masks(self) -> tuple[Mask, ...]:
        """factors between 0 and 1 on all its strengths and drags: palpa.Mask each"""
        return self._scene._masks(self._name)

    @masks.setter
    def masks(self, masks: Iterable[Mask]) -> None:
        if isinstance(masks, Mask):
            raise TypeError("'masks' takes a list of palpa.Mask: [palpa.Mask(…)]")
        self._scene._set_masks(self._name, masks)

    def __repr__(self):
        return f"SceneMode(name={self._name!r}, mode={self.mode!r}, enabled={self.enabled})"


def _of_coupling(name):
    """A key of the coupling as a property of the scene."""
    return property(lambda scene: getattr(scene.coupling, name), lambda scene, value: setattr(scene.coupling, name, value),
                    doc=getattr(CouplingOptions, name).__doc__)


class Scene(_palpa.Scene, Strict):
    """A scene: volumes, modes, coupling, workspace, law. All that a session needs but the device.

    Keyword arguments are those of CouplingOptions: palpa.Scene(stiffness_n_per_m=400). They are attributes as well:
    scene.stiffness_n_per_m is scene.coupling.stiffness_n_per_m. An attribute that there is not raises AttributeError.
    """

    _elsewhere = (("workspace", Workspace._attributes), ("time", TimeOptions._attributes))

    def __init__(self, *, _of=None, **coupling):
        super().__init__(*([] if _of is None else [_of]))
        if coupling:
            try:
                self.coupling._fill(coupling)
            except TypeError as error:
                raise TypeError(str(error).replace("CouplingOptions", "Scene", 1)) from None

    coupling = _part_property(CouplingOptions, _palpa.Scene._coupling, "the spring between hand and proxy")
    workspace = _part_property(Workspace, _palpa.Scene._workspace, "how the hand's reach lies in the world")
    time = _part_property(TimeOptions, _palpa.Scene._time, "how the data's time goes while the hand feels")
    for _name in CouplingOptions._attributes:
        locals()[_name] = _of_coupling(_name)
    del _name

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(self._unknown(name))

    def add(self, name: str, what: Volume | Mode, *, masks: Iterable[Mask] = (), enabled: bool = True,
            filter: str | None = None) -> str:
        """Adds a volume, or a mode whose fields are there; returns the name of the volume's first field, or the mode's.

        filter: of a volume, "trilinear", "smooth" or "cubic"; None: the default of its voxels.
        masks, enabled: of a mode.
        """
        if isinstance(what, _palpa.Volume):
            return self._add_volume(name, what, filter)
        if isinstance(masks, Mask):
            raise TypeError("'masks' takes a list of palpa.Mask: [palpa.Mask(…)]")
        if not isinstance(what, Mode):
            raise TypeError(f"{name!r} is to be a palpa.Volume or a palpa.Mode, not {type(what).__name__}")
        self._add_mode(name, what._to_part(), masks, enabled)
        return name

    def add_array(self, name: str, array: ndarray, spacing_m: float | Sequence[float] | None = None, *,
                  origin_m: Sequence[float] | None = None, axes: ArrayLike | None = None, unit: str = "",
                  copy: bool = False, filter: str | None = None) -> str:
        """Adds an array as a volume, read where it is; returns the name of its field. See palpa.array_volume."""
        return self.add(name, array_volume(array, spacing_m, origin_m=origin_m, axes=axes, unit=unit, copy=copy), filter=filter)

    @property
    def volumes(self) -> Mapping[str, Volume]:
        """its volumes by name, with the filter through which they are felt"""
        return Named("the scene", "volume", self._volumes())

    @property
    def modes(self) -> Mapping[str, SceneMode]:
        """its modes by name: a SceneMode each"""
        return Named("the scene", "mode", {name: SceneMode(self, name) for name in self._mode_names()})

    def copy(self) -> Scene:
        """A scene of its own, with the same voxels."""
        return Scene(_of=self)

    __copy__ = copy
    __hash__ = None

    def __deepcopy__(self, memo):
        return self.copy()

    def plot(self) -> Any:
        """A figure of matplotlib: three slices through the middle of its first volume, with the levels that are felt as lines.
        Raises ImportError without matplotlib."""
        return scene_figure(self)

    def _repr_png_(self):
        return png_or_none(scene_figure, self)

    def __repr__(self):
        return f"Scene(volumes={list(self.volumes)}, modes={list(self.modes)})"


def array_volume(array: ndarray, spacing_m: float | Sequence[float] | None = None, *, origin_m: Sequence[float] | None = None,
                 axes: ArrayLike | None = None, unit: str = "", copy: bool = False) -> Volume:
    """A volume of one field that reads a numpy array where it is, in no time: its range is read when a scene needs it.

    array: indexed [z, y, x], or [z, y, x, component] with 3 components; uint8, int16, uint16, int32, float32 or float64 in any
    order of its axes, also reversed, as long as the voxels are close to one another. It is kept, and no longer writeable from
    then on, nor what it is a view of: its range is read once. Views of it that were made before stay writeable: nothing may be
    written through them.
    spacing_m: [m] between voxels, one number or along x, y, z; left out it is 1, with a PalpaWarning. origin_m: [m] of the voxel
    [0, 0, 0]; None: the middle of the array lies in the world's origin. axes: shape (3, 3), its columns the directions of x, y,
    z in the world, as ITK and VTK have them, each of length 1; None: the world's own. unit: a label.
    copy: True reads a copy, which may then be of other types and orders as well.
    NaN and infinity are voxels without data, and so are those that a masked array masks, of which a copy is read.
    """
    if isinstance(array, ma.MaskedArray):
        array = _without_masked(array)
    if spacing_m is None:
        import warnings

        spacing_m = 1.0
        widest = max(array.shape[:3]) - 1 if getattr(array, "ndim", 0) >= 3 else 0
        warnings.warn(f"'spacing_m' was not given: the voxels are 1 m apart, so that the array is {widest} m long; "
                      "0.001 is a millimetre", PalpaWarning, stacklevel=2)
    if not isinstance(spacing_m, str) and ndim(spacing_m) == 0:
        spacing_m = (float(spacing_m),) * 3
    directions = eye(3) if axes is None else asarray(axes, float)
    if directions.shape != (3, 3):
        raise ValueError(f"'axes' has the shape {directions.shape}; it is a matrix (3, 3), a column for each of x, y, z")
    lengths = (directions**2).sum(axis=0) ** 0.5
    if not allclose(lengths, 1.0, rtol=0.0, atol=_length_tolerance):
        raise ValueError(f"'axes' has columns of the lengths {', '.join(format(each, '.6g') for each in lengths)}; they are "
                         "directions, of length 1, and 'spacing_m' says the distances")
    return _palpa.array_volume(array, spacing_m, directions.ravel().tolist(), origin_m, None, unit, copy)


# Of a direction of which a file has six digits. More: distances are wrong; less: directions of files are refused.
_length_tolerance = 1e-5


def _without_masked(array):
    """The array with NaN, which is no data, where it is masked."""
    if not ma.is_masked(array):
        return array.data
    if array.dtype.kind not in "buif":
        raise TypeError(f"an array of {array.dtype} holds no voxels; use whole numbers or floats")
    holds_nan = float32 if array.dtype.itemsize <= (4 if array.dtype.kind == "f" else 2) else float64
    return array.astype(holds_nan).filled(nan)


def read_volume(path: str | PathLike | Sequence[str | PathLike], **how: object) -> Volume:
    """Opens a file, several that belong together (a list), or a folder, in a process of its own.

    how: what the file leaves open, as [volume.NAME] of a scene file has it (docs/scene.md): length_unit, frame, series, type,
    dims, spacing_m, …; `as_` for `as`. Raises LoadError.
    """
    files = [path] if not isinstance(path, (list, tuple)) else list(path)
    return _palpa.read_volume(files, {name.rstrip("_"): value for name, value in how.items()})


def load_scene(path: str | PathLike, *, data: Sequence[str | PathLike] = (), sets: Mapping[str, object] | None = None) -> Scene:
    """Reads a scene file. Raises SceneError with file, line and column.

    data: folders that are searched for its files. sets: values of keys, {"coupling.stiffness_n_per_m": 300}.
    """
    import warnings

    written = [(key, value if isinstance(value, str) else repr(value).lower() if isinstance(value, bool) else repr(value))
               for key, value in (sets or {}).items()]
    scene, told = _palpa.load_scene(path, list(data), written)
    for sentence in told:
        warnings.warn(sentence, PalpaWarning, stacklevel=2)
    return Scene(_of=scene)


Scene.__init__.__signature__ = inspect.Signature([
    inspect.Parameter("self", inspect.Parameter.POSITIONAL_OR_KEYWORD), *CouplingOptions.__signature__.parameters.values()])


class PalpaWarning(UserWarning):
    """Something that is probably not what was meant."""
