"""Conversion to and from VTK's Python module, through numpy views, without a copy if possible."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy

from . import _palpa
from ._palpa import Field, Strength, Volume
from ._parameters import Strict
from ._scene import read_volume
from ._trace import Trace


def _numbers(array):
    """A VTK array as a numpy array, a view if contiguous; None if it holds no numbers."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    if not array.IsA("vtkDataArray"):
        return None
    if not array.HasStandardMemoryLayout() or array.GetDataTypeAsString() == "bit":
        packed = array.CreateDataArray(3 if array.GetDataTypeAsString() == "bit" else array.GetDataType())
        packed.DeepCopy(array)
        array = packed
    return vtk_to_numpy(array)


def _why_not(array, name, places):
    """Reason why a VTK array is unusable, half a sentence; empty: usable."""
    components = array.GetNumberOfComponents()
    if not array.IsA("vtkDataArray"):
        return "it holds no numbers"
    if components not in (1, 3):
        return f"{components} components; one or three can be felt"
    if components == 3 and array.GetDataTypeAsString() == "unsigned char":
        return "three bytes are a colour, not a vector"
    if array.GetNumberOfTuples() != places:
        return f"it has {array.GetNumberOfTuples()} values for {places} places"
    return "it marks ghosts, not data" if name == "vtkGhostType" else ""


def _has_blanks(data):
    def hides(ghosts, kind):
        return ghosts is not None and bool((_numbers(ghosts) & kind).any())

    return hides(data.GetPointGhostArray(), 2) or hides(data.GetCellGhostArray(), 32)  # HIDDENPOINT, HIDDENCELL


def _places(data, metres_per_unit):
    """Positions of a grid's points and cells: for each the shape (z, y, x) and arguments of _palpa.array_volume."""
    if data.IsA("vtkRectilinearGrid"):
        along = [metres_per_unit * numpy.array(_numbers(axis), float).ravel()
                 for axis in (data.GetXCoordinates(), data.GetYCoordinates(), data.GetZCoordinates())]
        middles = [0.5 * (x[1:] + x[:-1]) if len(x) > 1 else x for x in along]
        return [(tuple(len(x) for x in reversed(planes)), ((1, 1, 1), [1, 0, 0, 0, 1, 0, 0, 0, 1], None, [x.tolist() for x in planes]))
                for planes in (along, middles)]
    extent, spacing = data.GetExtent(), data.GetSpacing()
    count = [extent[2 * a + 1] - extent[2 * a] + 1 for a in range(3)]
    if min(count) < 1:
        raise _palpa.LoadError("has no voxels; give one whose extent is not empty")
    matrix = data.GetDirectionMatrix()
    axes = numpy.array([[matrix.GetElement(r, c) for c in range(3)] for r in range(3)])
    spacing_m = numpy.array(spacing) * metres_per_unit
    if not (numpy.isfinite(spacing_m).all() and (spacing_m != 0).all()):
        raise _palpa.LoadError("cannot be placed in the world (the step from voxel to voxel along an axis is zero or not "
                               "finite; it must be a length in metres); correct its geometry")
    axes, spacing_m = axes * numpy.sign(spacing_m), abs(spacing_m)
    start_m = metres_per_unit * numpy.array(data.GetOrigin())
    made = []
    for of_cells in (False, True):
        first = [extent[2 * a] + (0.5 if of_cells and count[a] > 1 else 0.0) for a in range(3)]
        shape = tuple(max(n - 1, 1) if of_cells else n for n in reversed(count))
        origin_m = start_m + axes @ (spacing_m * first)
        made.append((shape, (spacing_m.tolist(), axes.ravel().tolist(), origin_m.tolist(), None)))
    return made


def _of_grid(data, metres_per_unit, copy):
    parts, left_out, names = [], [], set()
    for of_cells, (shape, placed) in enumerate(_places(data, metres_per_unit)):
        arrays = data.GetCellData() if of_cells else data.GetPointData()
        for n in range(arrays.GetNumberOfArrays()):
            array = arrays.GetAbstractArray(n)
            called = array.GetName() or f"array_{n}"
            why = _why_not(array, called, math.prod(shape))
            if why:
                if called != "vtkGhostType":
                    left_out.append(f"array '{called}' is left out: {why}")
                continue
            name, again = called, 2
            while name in names:
                name = called + ("_cells" if of_cells else "_") + ("" if of_cells and again == 2 else str(again))
                again += 1
            names.add(name)
            values = _numbers(array)
            as_it_is = values.dtype.name in ("uint8", "int16", "uint16", "int32", "float32", "float64")
            values = values.reshape(shape + ((3,) if array.GetNumberOfComponents() == 3 else ()))
            parts.append((name, _palpa.array_volume(values, *placed, "", copy or not as_it_is)))
    if not parts:
        raise _palpa.LoadError(f"has no array that can be felt ({left_out[-1]}); one with 1 or 3 numbers is needed" if left_out
                               else "has no array; one with 1 or 3 numbers for each point or cell is needed")
    return _palpa.joined_volume(parts, left_out)


def _resampled(data, metres_per_unit):
    from vtkmodules.vtkIOXML import vtkXMLDataSetWriter

    with tempfile.TemporaryDirectory(prefix="palpa-from-vtk-") as folder:
        writer = vtkXMLDataSetWriter()
        writer.SetInputData(data)
        file = f"{folder}/data.xml"
        writer.SetFileName(file)
        writer.SetDataModeToAppended()
        writer.EncodeAppendedDataOff()
        writer.SetCompressorTypeToNone()
        if writer.Write() != 1:
            raise _palpa.LoadError("cannot be resampled: VTK cannot write it into a file on its way; make room, or set TMPDIR")
        try:
            volume = read_volume(file)
        except _palpa.LoadError as error:
            raise _palpa.LoadError(str(error).removeprefix(f"{file}: ")) from None
    return _palpa.in_other_unit(volume, metres_per_unit)


def from_vtk(data: Any, *, metres_per_unit: float = 1.0, copy: bool = False) -> Volume:
    """A volume from a VTK data set: every point or cell array of one or three components is a field.

    vtkImageData and vtkRectilinearGrid are read in place, at once; their arrays are kept, and must not change while in use:
    copy=True if the pipeline continues. Other data sets (curvilinear, unstructured, with blank points or cells) are resampled
    by palpa-read, like a file, and `warnings` report the error.
    metres_per_unit: [m] VTK has no unit of length: 0.001 for millimetres.
    Raises LoadError, one line.
    """
    if not hasattr(data, "IsA") or not data.IsA("vtkDataSet"):
        raise TypeError(f"'data' is a data set of VTK, not {type(data).__name__}; ask its filter for GetOutput()")
    if not (metres_per_unit > 0 and math.isfinite(metres_per_unit)):
        raise ValueError(f"'metres_per_unit' is {metres_per_unit}; it lies above 0")
    try:
        if data.IsA("vtkImageData") or data.IsA("vtkRectilinearGrid"):
            if not _has_blanks(data):
                return _of_grid(data, metres_per_unit, copy)
        if data.GetNumberOfCells() == 0:
            raise _palpa.LoadError("has no cells; give one with a volume")
        return _resampled(data, metres_per_unit)
    except (_palpa.LoadError, ValueError) as error:
        raise _palpa.LoadError(f"{data.GetClassName()}: {error}") from None


def _image_of(field, name, samples):
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData

    affine, values = field.affine_m, field.voxels
    if affine is not None:
        spacing = numpy.linalg.norm(affine[:3, :3], axis=0)
        axes = affine[:3, :3] / spacing
    if affine is None or abs(axes.T @ axes - numpy.eye(3)).max() > 1e-6:
        if samples < 2:
            raise ValueError("an image needs two samples or more along its longest side")
        low, high = field.bounds_m
        count = numpy.maximum(numpy.round((high - low) / (high - low).max() * (samples - 1)), 0).astype(int) + 1
        spacing = numpy.where(count > 1, (high - low) / numpy.maximum(count - 1, 1), (high - low).max() / (samples - 1))
        axes, affine = numpy.eye(3), numpy.eye(4)
        affine[:3, 3] = low
        z, y, x = numpy.meshgrid(*(numpy.linspace(low[a], high[a], count[a]) for a in (2, 1, 0)), indexing="ij")
        values = field(numpy.stack([x, y, z], axis=-1))[0].astype(numpy.float32)
    image = vtkImageData()
    image.SetDimensions(*(int(n) for n in reversed(values.shape[:3])))
    image.SetSpacing(*spacing)
    image.SetOrigin(*affine[:3, 3])
    image.SetDirectionMatrix(*axes.ravel())
    array = numpy_to_vtk(values.reshape(-1, field.components), deep=True)
    array.SetName(name)
    image.GetPointData().SetScalars(array) if field.components == 1 else image.GetPointData().SetVectors(array)
    return image


def _path_of(trace):
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

    with tempfile.TemporaryDirectory(prefix="palpa-to-vtk-") as folder:
        trace.export(Path(folder) / "felt.vtp")
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(f"{folder}/felt.vtp")
        reader.Update()
        return reader.GetOutput()


def _function_of(strength, factor):
    from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction

    function = vtkPiecewiseFunction()
    points, outside = strength.points, strength.outside
    last = None
    if points and points[0][1] != outside:
        function.AddPoint(math.nextafter(points[0][0], -math.inf), factor * outside)
    for value, result in points:
        last = math.nextafter(value, math.inf) if value == last else value  # VTK has one point per value
        function.AddPoint(last, factor * result)
    if points and points[-1][1] != outside:
        function.AddPoint(math.nextafter(last, math.inf), factor * outside)
    function.ClampingOn()
    return function


def to_vtk(what: Field | Volume | Trace | Strength, *, name: str = "value", samples: int = 128, factor: float = 1.0) -> Any:
    """A field, or a volume's first field, as vtkImageData: its voxels or, for a formula, `samples` along its longest side. A
    trace as vtkPolyData: the proxy's path with every column as an array. A strength as vtkPiecewiseFunction, times `factor`
    [1/N]. All results are copies."""
    if isinstance(what, Volume):
        name, what = next(iter(what.fields.items()))
    if isinstance(what, Field):
        return _image_of(what, name, samples)
    if isinstance(what, Trace):
        return _path_of(what)
    if isinstance(what, Strength):
        return _function_of(what, factor)
    raise TypeError(f"'what' is a palpa.Field, Volume, Trace or Strength, not {type(what).__name__}")


def to_pyvista(what: Field | Volume | Trace, *, name: str = "value", samples: int = 128) -> Any:
    """A field, a volume's first field, or a trace, as a mesh of pyvista: palpa.to_vtk, wrapped. palpa.from_vtk takes pyvista's
    meshes. Raises ImportError without pyvista."""
    try:
        import pyvista
    except ImportError:
        raise ImportError("palpa.to_pyvista needs pyvista: pip install pyvista; palpa.to_vtk works without") from None
    if isinstance(what, Strength):
        raise TypeError("'what' is a palpa.Field, Volume or Trace, not Strength; palpa.to_vtk makes a function of VTK of it")
    return pyvista.wrap(to_vtk(what, name=name, samples=samples))


def strength_from_vtk(function: Any, of: str, *, factor: float = 1.0) -> Strength:
    """A vtkPiecewiseFunction as a strength of the field `of`: `factor` [N] per 1 in VTK. Straight pieces are kept, a curved
    piece becomes 32. Beyond its points it is 0 without clamping, else the value of its ends, which must be equal. Raises
    ValueError."""
    count = function.GetSize()
    if count == 0:
        raise ValueError("vtkPiecewiseFunction: has no points; add one")
    pieces = 32  # per curved piece. More: slower evaluation; fewer: corners are felt
    points, node = [], [0.0] * 4
    for n in range(count):
        before, node = node, [0.0] * 4
        function.GetNodeValue(n, node)
        if n > 0 and (before[2] != 0.5 or before[3] != 0.0):
            for i in range(1, pieces):
                value = before[0] + (node[0] - before[0]) * i / pieces
                points.append((value, factor * function.GetValue(value)))
        points.append((node[0], factor * node[1]))
    outside = 0.0
    if function.GetClamping():
        if points[0][1] != points[-1][1]:
            raise ValueError(f"vtkPiecewiseFunction: clamps to {points[0][1]:g} below and to {points[-1][1]:g} above; a transfer "
                             "function is one number beyond its points: turn clamping off, or make its ends alike")
        outside = points[0][1]
    return Strength(of=of, points=points, outside=outside)


def _map_of(hand_to_world):
    matrix = numpy.eye(4) if hand_to_world is None else _palpa.numbers_of(hand_to_world)
    if matrix is None or matrix.shape != (4, 4):
        raise TypeError("'hand_to_world' takes a matrix of shape (4, 4), as scene.hand_to_world() is one")
    return matrix


# [m] Above any hand's reach. More: lengths of the world pass, and a ball fills the picture; less: distant views are refused.
_widest_unit_m = 0.5


class FeltActors(Strict):
    """Actors for any vtkRenderer: proxy, probe, the spring between them, primitives (planes as discs, lines as rods, points as
    balls, directed forces as arrows, in the colour of their mode).

    view_half_height_hand_m: [m of the hand] half the height of the picture, such as 0.08; the unit of sizes: a ball has 0.02 of
    it. Above 0, at most 0.5: no hand's reach is wider. To convert a length of the world, divide it by the scale of
    hand_to_world, the length of any of its first three columns. hand_to_world: shape (4, 4), scene.hand_to_world() if the
    renderer shows the data's world; None: it shows the hand frame.
    """

    _colors = (0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0xE69F00, 0x56B4E9)

    def __init__(self, renderer: Any, view_half_height_hand_m: float, hand_to_world: Any = None) -> None:
        from vtkmodules.vtkFiltersSources import vtkConeSource, vtkCylinderSource, vtkSphereSource
        from vtkmodules.vtkRenderingCore import vtkPolyDataMapper

        self._renderer, self._view_half_height_hand_m, self._tick = renderer, view_half_height_hand_m, None
        self._map = _map_of(hand_to_world)
        if not isinstance(view_half_height_hand_m, (int, float, numpy.number)):
            raise TypeError(f"'view_half_height_hand_m' takes a number, not {type(view_half_height_hand_m).__name__}")
        if not 0.0 < view_half_height_hand_m <= _widest_unit_m:
            scale = numpy.linalg.norm(self._map[:3, 0])
            raise ValueError(f"'view_half_height_hand_m' is {view_half_height_hand_m:g}; it is half the height of the picture in metres of the hand, above 0 and at most "
                             f"{_widest_unit_m:g}: a length of the world is divided by {scale:.4g}, the scale of hand_to_world")
        ball, rod, tip = vtkSphereSource(), vtkCylinderSource(), vtkConeSource()  # along y, from the origin
        ball.SetRadius(1.0), ball.SetThetaResolution(32), ball.SetPhiResolution(16)
        rod.SetRadius(1.0), rod.SetHeight(1.0), rod.SetCenter(0.0, 0.5, 0.0), rod.SetResolution(64)
        tip.SetDirection(0.0, 1.0, 0.0), tip.SetCenter(0.0, 0.5, 0.0), tip.SetHeight(1.0), tip.SetRadius(1.0), tip.SetResolution(32)
        self._mappers, self._actors, self._used = [], ([], [], []), [0, 0, 0]
        for shape in (ball, rod, tip):
            mapper = vtkPolyDataMapper()
            mapper.SetInputConnection(shape.GetOutputPort())
            self._mappers.append(mapper)

    def __repr__(self):
        return f"FeltActors(view_half_height_hand_m={self._view_half_height_hand_m})"

    def update(self, live: Any) -> bool:
        """Shows the latest tick of a palpa.Live, without blocking its loop. False: no new tick."""
        seen = live.latest()
        if seen["tick"] == self._tick:
            return False
        self._tick = seen["tick"]
        self.show(seen["probe_m"], seen["proxy_m"], live.primitives())
        return True

    def follow(self, live: Any, interactor: Any) -> None:
        """From now on shows the latest tick of a palpa.Live in the window of an initialised interactor, some sixty times a
        second; slower renderings take at most half of the time, so that mouse events are handled, too."""
        rests_until_s = 0.0

        def draw_if_due(*_):
            nonlocal rests_until_s
            begin_s = time.monotonic()
            if begin_s >= rests_until_s and self.update(live):
                interactor.Render()
                rests_until_s = 2 * time.monotonic() - begin_s

        interactor.AddObserver("TimerEvent", draw_if_due)
        interactor.CreateRepeatingTimer(16)

    def show(self, probe_m: Any, proxy_m: Any, primitives: Iterable[dict[str, Any]] = ()) -> None:
        """Shows these positions, hand frame; primitives as from Live.primitives()."""
        primitives = list(primitives)
        probe_m, proxy_m = numpy.asarray(probe_m, float), numpy.asarray(proxy_m, float)
        self._used = [0, 0, 0]
        most_n = max([1e-3, *(numpy.linalg.norm(p["force_n"]) for p in primitives)])
        for primitive in primitives:
            self._draw(primitive, proxy_m, most_n)
        u = self._view_half_height_hand_m
        self._rod(proxy_m, probe_m, 0.007 * u, (0.35, 0.35, 0.38))
        self._put(0, proxy_m, numpy.array([0, 0.02 * u, 0]), 0.02 * u, (0.08, 0.08, 0.10))
        self._put(0, probe_m, numpy.array([0, 0.02 * u, 0]), 0.02 * u, (0.45, 0.45, 0.48))
        for shape, actors in enumerate(self._actors):
            for actor in actors[self._used[shape]:]:
                actor.VisibilityOff()

    def remove(self) -> None:
        """Removes its actors from the renderer."""
        for actors in self._actors:
            for actor in actors:
                self._renderer.RemoveActor(actor)
            actors.clear()

    def _draw(self, primitive, proxy_m, most_n):
        u, at, q = self._view_half_height_hand_m, numpy.asarray(primitive["position_m"]), numpy.asarray(primitive["direction"])
        rgb = self._colors[primitive["mode"] % len(self._colors)]
        color = tuple((rgb >> shift & 255) / 255 for shift in (16, 8, 0))
        force_n = numpy.linalg.norm(primitive["force_n"])
        kind = primitive["kind"]
        if kind in ("plane", "facet", "corner"):
            self._rod(at - 0.002 * u * q, at + 0.002 * u * q, 0.2 * u, color, 0.2 if force_n < 1e-3 else 0.45)
            self._arrow(at, at + (0.1 + 0.2 * force_n / most_n) * u * q, 0.009 * u, color)
        elif kind == "line":
            self._rod(at - 0.3 * u * q, at + 0.3 * u * q, 0.008 * u, color)
        elif kind == "point":
            self._put(0, at, numpy.array([0, 0.03 * u, 0]), 0.03 * u, color)
        elif numpy.linalg.norm(q) > 0:
            self._arrow(proxy_m, proxy_m + (0.1 + 0.25 * force_n / most_n) * u * q / numpy.linalg.norm(q), 0.012 * u, color)

    def _rod(self, from_m, to_m, radius_m, color, opacity=1.0):
        if numpy.linalg.norm(to_m - from_m) > 0:
            self._put(1, from_m, to_m - from_m, radius_m, color, opacity)

    def _arrow(self, from_m, to_m, radius_m, color):
        length_m = numpy.linalg.norm(to_m - from_m)
        head_m = min(5.0 * radius_m, 0.6 * length_m)
        if head_m > 0:
            along = (to_m - from_m) / length_m
            self._rod(from_m, to_m - 0.9 * head_m * along, radius_m, color)
            self._put(2, to_m - head_m * along, head_m * along, 2.2 * radius_m, color)

    def _put(self, shape, from_m, way_m, radius_m, color, opacity=1.0):
        """Shows a further actor of a shape, scaled along its y axis to way_m and across to radius_m."""
        from vtkmodules.vtkCommonMath import vtkMatrix4x4
        from vtkmodules.vtkRenderingCore import vtkActor

        actors = self._actors[shape]
        if self._used[shape] == len(actors):
            made = vtkActor()
            made.SetMapper(self._mappers[shape])
            made.SetUserMatrix(vtkMatrix4x4())
            made.GetProperty().SetAmbient(0.25), made.GetProperty().SetDiffuse(0.75)
            self._renderer.AddActor(made)
            actors.append(made)
        actor = actors[self._used[shape]]
        self._used[shape] += 1
        turn = self._map[:3, :3]
        y = turn @ way_m
        along = y / numpy.linalg.norm(y)
        x = numpy.cross(along, (1, 0, 0) if abs(along[0]) < 0.7 else (0, 0, 1))
        x *= numpy.linalg.norm(turn[:, 0]) * radius_m / numpy.linalg.norm(x)
        columns = (x, y, numpy.cross(x, along), turn @ from_m + self._map[:3, 3])
        for c, column in enumerate(columns):
            for r in range(3):
                actor.GetUserMatrix().SetElement(r, c, column[r])
        actor.GetProperty().SetColor(*color)
        actor.GetProperty().SetOpacity(opacity)
        actor.VisibilityOn()


class MousePointer(Strict):
    """Moves a palpa.MouseHand with the mouse over the picture, by the distance at the camera's focal point, and by 2 mm per
    notch of the wheel away from the viewer, or back. While a button is pressed the interactor's style uses the mouse to rotate
    the view, and the hand rests; the wheel moves only the hand. Keep a reference to it while in use.

    interactor: with its style set. renderer: of the camera in use. hand_to_world: as for FeltActors.
    """

    _notch_m = 0.002

    def __init__(self, interactor: Any, renderer: Any, pointer: Any, hand_to_world: Any = None) -> None:
        self._interactor, self._renderer, self._pointer = interactor, renderer, pointer
        to_world = _map_of(hand_to_world)[:3, :3]
        self._to_hand, self._scale = numpy.linalg.inv(to_world), numpy.cbrt(abs(numpy.linalg.det(to_world)))
        style = interactor.GetInteractorStyle()
        self._last_px = None
        for event in ("MouseMoveEvent", "LeaveEvent"):
            interactor.AddObserver(event, self._follow)
        for event in ("MouseWheelForwardEvent", "MouseWheelBackwardEvent"):  # in place of the style's use of the wheel
            style.AddObserver(event, self._follow)

    def __repr__(self):
        return f"MousePointer({self._pointer!r})"

    def _follow(self, _, event):
        if event == "LeaveEvent":  # the mouse may return anywhere
            self._last_px = None
            return
        camera, style = self._renderer.GetActiveCamera(), self._interactor.GetInteractorStyle()
        into = numpy.array(camera.GetDirectionOfProjection())
        right = numpy.cross(into, camera.GetViewUp())
        right /= numpy.linalg.norm(right)
        if event != "MouseMoveEvent":
            notch_m = self._notch_m * self._scale
            self._pointer.move(self._to_hand @ ((notch_m if "Forward" in event else -notch_m) * into))
            return
        at_px = numpy.array(self._interactor.GetEventPosition())
        x, y = at_px - (at_px if self._last_px is None else self._last_px)
        self._last_px = at_px
        if getattr(style, "GetState", int)() != 0:
            return
        half_m = (camera.GetParallelScale() if camera.GetParallelProjection()
                  else camera.GetDistance() * math.tan(0.5 * math.radians(camera.GetViewAngle())))
        per_px_m = 2 * half_m / max(self._renderer.GetSize()[1], 1)
        self._pointer.move(self._to_hand @ (per_px_m * (x * right + y * numpy.cross(right, into))))
