"""Images of SimpleITK and xarray as volumes, with their geometry. Neither package is imported by palpa."""

from __future__ import annotations

import sys
import warnings
from typing import Any

import numpy

from . import _palpa
from ._palpa import Volume
from ._scene import PalpaWarning

_voxel_types = ("uint8", "int16", "uint16", "int32", "float32", "float64")
_along = [1, 0, 0, 0, 1, 0, 0, 0, 1]  # the world's axes


class _Kept:
    """Memory of an array that lives as long as its owner."""

    def __init__(self, array, owner):
        self.__array_interface__, self._owner = array.__array_interface__, owner


def from_image(image: Any, *, metres_per_unit: float | None = None, copy: bool = False) -> Volume:
    """A volume from an image of SimpleITK or a DataArray of xarray, where its voxels lie.

    SimpleITK: spacing, origin and direction, in the medical frame (LPS); lengths are millimetres. Three components are vectors.
    xarray: dimensions x, y and z, in any order and case, with coordinates, also at uneven distances; a fourth one of length 3
    are the components of vectors. Lengths have the coordinates' `units`, else metres, with a PalpaWarning. Its `units` is the label.
    metres_per_unit: [m] instead of these units of length. copy: True copies the voxels; without, they are read in place if their
    type and order allow it, and must not change while in use.
    Other images are arrays with a geometry: palpa.array_volume. Raises TypeError or ValueError.
    """
    if hasattr(image, "GetDirection") and hasattr(image, "GetNumberOfComponentsPerPixel"):
        return _of_sitk(image, 0.001 if metres_per_unit is None else metres_per_unit, copy)
    if hasattr(image, "dims") and hasattr(image, "coords") and hasattr(image, "transpose"):
        return _of_xarray(image, metres_per_unit, copy)
    raise TypeError(f"'image' takes an image of SimpleITK or a DataArray of xarray, not {type(image).__name__}; palpa.array_volume "
                    "takes arrays, palpa.from_vtk data of VTK, palpa.read_volume files")


def _of_sitk(image, metres_per_unit, copy):
    components = image.GetNumberOfComponentsPerPixel()
    if image.GetDimension() != 3 or components not in (1, 3):
        raise ValueError(f"the image has {image.GetDimension()} dimensions and {components} components; it has 3 dimensions, and 1 or "
                         "3 components, to be felt")
    sitk = sys.modules[type(image).__module__.partition(".")[0]]
    values = numpy.asarray(_Kept(sitk.GetArrayViewFromImage(image), image))
    spacing_m = [metres_per_unit * each for each in image.GetSpacing()]
    origin_m = [metres_per_unit * each for each in image.GetOrigin()]
    return _palpa.in_medical_frame(_palpa.array_volume(values, spacing_m, list(image.GetDirection()), origin_m, None, "",
                                                       copy or values.dtype.name not in _voxel_types))


def _of_xarray(array, metres_per_unit, copy):
    by_axis = {str(dim).lower(): dim for dim in array.dims}
    others = [dim for dim in array.dims if str(dim).lower() not in ("x", "y", "z")]
    if not {"x", "y", "z"} <= set(by_axis):
        raise ValueError(f"the DataArray has the dimensions {', '.join(map(str, array.dims))}; three of them are x, y and z: "
                         "array.rename(…)")
    if len(others) > 1 or others and array.sizes[others[0]] != 3:
        raise ValueError(f"the DataArray has the dimension {others[-1]!r} beside x, y and z, which is not of 3 components; take one "
                         f"place along it: array.isel({others[-1]}=0)")
    order = [by_axis[axis] for axis in "zyx"]
    planes_m = [_coordinates_m(array, dim, metres_per_unit) for dim in reversed(order)]
    values = numpy.asarray(array.transpose(*order, *others).values)
    in_place = values.dtype.name in _voxel_types and values.flags.c_contiguous
    return _palpa.array_volume(values, (1, 1, 1), _along, None, planes_m, str(array.attrs.get("units", "")), copy or not in_place)


def _coordinates_m(array, dim, metres_per_unit):
    """Coordinates of a dimension [m]."""
    if dim not in array.coords:
        raise ValueError(f"the DataArray has no coordinates along {dim!r}; give it some: array.assign_coords({dim}=…)")
    coordinate = array.coords[dim]
    if metres_per_unit is None:
        unit = str(coordinate.attrs.get("units", ""))
        metres_per_unit = _palpa.metres_of_unit(unit) if unit else 1.0
        if metres_per_unit is None:
            raise ValueError(f"the coordinates along {dim!r} are in {unit!r}, which is no length; give 'metres_per_unit'")
        if not unit:
            warnings.warn(f"the coordinates along {dim!r} have no units: they are read as metres; metres_per_unit=0.001 is a millimetre",
                          PalpaWarning, stacklevel=4)
    values = _palpa.numbers_of(coordinate.values)
    if values is None or values.ndim != 1:
        raise ValueError(f"the coordinates along {dim!r} are not a number for each voxel")
    return (metres_per_unit * values).tolist()
