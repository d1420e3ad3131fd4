"""Images of SimpleITK and xarray, and meshes of pyvista. Where a package is not installed, a stand-in with its interface."""

import gc
import sys
import types
import weakref

import numpy as np
import pytest

import palpa

try:
    import xarray
except ImportError:
    xarray = None


class Coordinate:
    def __init__(self, values, units=None):
        self.values, self.attrs = np.asarray(values), {} if units is None else {"units": units}


class DataArray:
    """The members of xarray.DataArray that are read."""

    def __init__(self, values, dims, coords, attrs):
        self.values, self.dims, self.coords, self.attrs = values, dims, coords, attrs
        self.sizes = dict(zip(dims, values.shape))

    def transpose(self, *dims):
        return DataArray(self.values.transpose([self.dims.index(dim) for dim in dims]), dims, self.coords, self.attrs)


def data_array(values, dims, coords, units=None, attrs={}):
    if xarray is None:
        return DataArray(values, dims, {name: Coordinate(c, units) for name, c in coords.items()}, dict(attrs))
    return xarray.DataArray(values, dims=dims, attrs=attrs,
                            coords={name: (name, np.asarray(c), {} if units is None else {"units": units}) for name, c in coords.items()})


class Image:
    """The members of SimpleITK.Image that are read."""

    def __init__(self, values, spacing, origin, direction, components=1):
        self.values, self.spacing, self.origin, self.direction, self.components = values, spacing, origin, direction, components

    def GetDimension(self):
        return self.values.ndim - (self.components > 1)

    def GetNumberOfComponentsPerPixel(self):
        return self.components

    def GetSpacing(self):
        return self.spacing

    def GetOrigin(self):
        return self.origin

    def GetDirection(self):
        return tuple(self.direction.ravel())


@pytest.fixture
def sitk(monkeypatch):
    """A module with SimpleITK's images, whose views of memory do not keep the image."""
    module = types.ModuleType("SimpleITK_stand_in")
    module.GetArrayViewFromImage = lambda image: np.lib.stride_tricks.as_strided(image.values, writeable=False)
    monkeypatch.setitem(sys.modules, "SimpleITK_stand_in", module)
    monkeypatch.setattr(Image, "__module__", "SimpleITK_stand_in")
    return Image


def only(volume):
    (field,) = volume.fields.values()
    return field


shape = (5, 6, 7)
numbers = np.random.default_rng(1).normal(size=shape).astype("float32")
coords = dict(z=np.linspace(30, 38, 5), y=np.linspace(10, 0, 6), x=[0, 1, 3, 4, 6, 8, 9])


def at(indices, axes=coords):
    return np.array([axes[name][i] for name, i in zip("xyz", reversed(indices))], float)


@pytest.mark.parametrize("dims", [("z", "y", "x"), ("x", "y", "z"), ("y", "x", "z")])
def test_a_dataarray_lies_where_its_coordinates_say(dims):
    given = data_array(numbers.transpose(["zyx".index(dim) for dim in dims]), dims, coords, "mm", {"units": "K"})
    field = only(palpa.from_image(given))
    assert field.unit == "K" and field.value_ranges == [(float(numbers.min()), float(numbers.max()))]
    for indices in ((0, 0, 0), (2, 3, 4), (4, 5, 6), (1, 0, 5)):
        np.testing.assert_allclose(field(1e-3 * at(indices))[0], numbers[indices], atol=1e-6)
    low, high = field.bounds_m
    np.testing.assert_allclose((low, high), [(0, 0, 0.03), (0.009, 0.01, 0.038)])
    np.testing.assert_allclose(only(palpa.from_image(given, metres_per_unit=1)).bounds_m[1], (9, 10, 38))


def test_a_dataarray_of_vectors_and_without_units():
    vectors = np.random.default_rng(2).normal(size=(3, *shape))
    with pytest.warns(palpa.PalpaWarning, match="coordinates along 'X' have no units: they are read as metres"):
        given = data_array(vectors, ("component", "z", "y", "X"), {"z": coords["z"], "y": coords["y"], "X": coords["x"]})
        field = only(palpa.from_image(given))
    assert field.components == 3
    np.testing.assert_allclose(field(at((2, 3, 4)))[0], vectors[:, 2, 3, 4], atol=1e-12)


def test_a_dataarray_is_read_in_place_if_it_can_be():
    own = numbers.copy()
    field = only(palpa.from_image(data_array(own, ("z", "y", "x"), coords, "mm")))
    assert np.shares_memory(field.voxels, own) and not own.flags.writeable
    copied = only(palpa.from_image(data_array(numbers.astype("int64"), ("z", "y", "x"), coords, "mm")))
    assert copied.voxels.dtype == "float64"


@pytest.mark.parametrize("make, error, words", [
    (lambda: data_array(numbers, ("z", "y", "lon"), {}), ValueError, "three of them are x, y and z"),
    (lambda: data_array(numbers, ("z", "y", "x"), {"z": coords["z"], "y": coords["y"]}, "mm"), ValueError, "no coordinates along 'x'"),
    (lambda: data_array(numbers, ("z", "y", "x"), coords, "degrees_north"), ValueError, "'degrees_north', which is no length"),
    (lambda: data_array(numbers[None].repeat(4, 0), ("time", "z", "y", "x"), coords, "mm"), ValueError, r"array.isel\(time=0\)"),
    (lambda: numbers, TypeError, "'image' takes an image of SimpleITK or a DataArray of xarray, not ndarray"),
])
def test_what_is_no_image_is_told_in_one_line(make, error, words):
    with pytest.raises(error, match=words):
        palpa.from_image(make())


def test_an_image_of_simpleitk_lies_where_it_says(sitk):
    turn = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]], float)  # columns: the directions of x, y, z
    spacing, origin = (0.5, 0.6, 2.0), (-10.0, 20.0, 5.0)
    volume = palpa.from_image(sitk(numbers, spacing, origin, turn))
    field = only(volume)
    assert volume.medical_frame and field.voxels is not None
    for indices in ((0, 0, 0), (2, 3, 4), (4, 5, 6)):
        place_mm = np.array(origin) + turn @ (np.array(spacing) * indices[::-1])
        np.testing.assert_allclose(field(1e-3 * place_mm)[0], numbers[indices], atol=1e-5)
    vectors = np.random.default_rng(2).normal(size=(*shape, 3))
    assert only(palpa.from_image(sitk(vectors, spacing, origin, turn, 3))).components == 3
    for wrong in (sitk(numbers[0], spacing, origin, turn), sitk(np.zeros((*shape, 2)), spacing, origin, turn, 2)):
        with pytest.raises(ValueError, match="it has 3 dimensions, and 1 or 3 components, to be felt"):
            palpa.from_image(wrong)


def test_an_image_of_simpleitk_lives_as_long_as_it_is_felt(sitk):
    image = sitk(numbers.copy(), (1, 1, 1), (0, 0, 0), np.eye(3))
    gone = weakref.ref(image)
    volume = palpa.from_image(image)
    del image
    gc.collect()
    assert gone() is not None
    np.testing.assert_array_equal(only(volume).voxels, numbers)
    del volume
    gc.collect()
    assert gone() is None
    image = sitk(numbers.copy(), (1, 1, 1), (0, 0, 0), np.eye(3))
    volume = palpa.from_image(image, copy=True)
    image.values[:] = 0
    np.testing.assert_array_equal(only(volume).voxels, numbers)


def test_meshes_of_pyvista(monkeypatch):
    pytest.importorskip("vtkmodules")
    ball = palpa.sphere_field()
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(ImportError, match="needs pyvista: pip install pyvista; palpa.to_vtk works without"):
        palpa.to_pyvista(ball)
    wrapped = types.ModuleType("pyvista")
    wrapped.wrap = lambda data: ("wrapped", data)
    monkeypatch.setitem(sys.modules, "pyvista", wrapped)
    scene = palpa.Scene()
    scene.add("ball", ball)
    for what, kind in ((ball, "vtkImageData"), (scene.field("ball"), "vtkImageData"),
                       (palpa.run(scene, np.zeros((20, 3)), 1e-3), "vtkPolyData")):
        word, data = palpa.to_pyvista(what, samples=16) if kind == "vtkImageData" else palpa.to_pyvista(what)
        assert word == "wrapped" and data.IsA(kind) and data.GetNumberOfPoints() > 10
    with pytest.raises(TypeError, match="not Strength"):
        palpa.to_pyvista(palpa.Strength(of="a", points=[(0, 1)]))
