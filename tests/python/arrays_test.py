"""Arrays as voxels, and fields sampled in bulk."""

import gc
import threading
import weakref

import numpy as np
import pytest

import palpa

types = ["uint8", "int16", "uint16", "int32", "float32", "float64"]
spacing_m = (0.001, 0.002, 0.003)


def numbers(dtype="float64", shape=(5, 6, 7)):
    return np.random.default_rng(1).integers(0, 200, shape).astype(dtype)


def only(volume):
    (field,) = volume.fields.values()
    return field


def centres_m(shape):
    """Positions of an array's voxels about the origin, in the array's index order."""
    z, y, x = np.meshgrid(*[np.arange(n) - (n - 1) / 2 for n in shape[:3]], indexing="ij")
    return np.stack([x, y, z], axis=-1) * spacing_m


@pytest.mark.parametrize("dtype", types)
def test_voxels_of_every_type_are_read_where_they_are(dtype):
    array = numbers(dtype)
    field = only(palpa.array_volume(array, spacing_m, unit="HU"))
    values, gradients = field(centres_m(array.shape))
    assert values.shape == array.shape and gradients.shape == array.shape + (3,)
    np.testing.assert_allclose(values, array, rtol=1e-12)
    assert field.value_ranges == [(float(array.min()), float(array.max()))] and field.unit == "HU"


orders = {
    "C": lambda a: np.ascontiguousarray(a),
    "Fortran": lambda a: np.asfortranarray(a),
    "reversed": lambda a: np.ascontiguousarray(a[::-1, ::-1, ::-1])[::-1, ::-1, ::-1],
    "one reversed": lambda a: np.ascontiguousarray(a[:, ::-1])[:, ::-1],
    "xyz": lambda a: np.ascontiguousarray(a.transpose(2, 1, 0)).transpose(2, 1, 0),
    "yzx": lambda a: np.ascontiguousarray(a.transpose(1, 0, 2)).transpose(1, 0, 2),
    "yxz reversed": lambda a: np.ascontiguousarray(a.transpose(1, 2, 0)[::-1])[::-1].transpose(2, 0, 1),
    "slab": lambda a: np.concatenate([a * 0, a, a * 0])[len(a) : 2 * len(a)],
}


@pytest.mark.parametrize("order", orders)
def test_any_order_of_axes_needs_no_copy(order):
    array = orders[order](numbers())
    assert (array == numbers()).all(), "the test's own orders"
    field = only(palpa.array_volume(array, spacing_m))
    values, gradients = field(centres_m(array.shape))
    np.testing.assert_allclose(values, array, rtol=1e-9)
    inner = centres_m(array.shape)[2, 3, 3] + np.array([2e-4, 3e-4, 4e-4])
    step = np.eye(3) * 1e-7
    slopes = (field(inner + step)[0] - field(inner - step)[0]) / 2e-7
    np.testing.assert_allclose(field(inner)[1], slopes, rtol=1e-5)


@pytest.mark.parametrize("shape", [(1, 6, 7), (5, 1, 7), (5, 6, 1), (1, 1, 7)])
def test_an_axis_may_have_one_voxel(shape):
    array = numbers(shape=shape)
    np.testing.assert_allclose(only(palpa.array_volume(array, spacing_m))(centres_m(shape))[0], array, rtol=1e-12)


@pytest.mark.parametrize("order", ["C", "Fortran on the grid", "reversed"])
def test_vectors_have_a_fourth_axis(order):
    array = np.random.default_rng(2).normal(size=(4, 5, 6, 3))
    if order == "reversed":
        array = np.ascontiguousarray(array[::-1])[::-1]
    elif order != "C":
        array = np.ascontiguousarray(array.transpose(2, 1, 0, 3)).transpose(2, 1, 0, 3)
    field = only(palpa.array_volume(array, spacing_m))
    values, jacobians = field(centres_m(array.shape))
    assert field.components == 3 and jacobians.shape == array.shape + (3,)
    np.testing.assert_allclose(values, array, rtol=1e-9, atol=1e-12)


def test_origin_and_middle():
    array = numbers()
    np.testing.assert_allclose(only(palpa.array_volume(array, spacing_m)).bounds_m[0], [-0.003, -0.005, -0.006])
    np.testing.assert_allclose(only(palpa.array_volume(array, spacing_m, origin_m=(1, 2, 3))).bounds_m[0], [1, 2, 3])
    np.testing.assert_allclose(only(palpa.array_volume(array, 0.5)).bounds_m[1], [1.5, 1.25, 1.0])


def test_the_memory_is_shared_and_kept():
    array = np.zeros((200, 200, 200), dtype=np.float32)
    array[100] = 1
    reference = weakref.ref(array)
    scene = palpa.Scene()
    scene.add_array("a", array, 0.001, filter="trilinear")
    del array
    gc.collect()
    assert reference() is not None, "kept alive"
    assert not reference().flags.writeable
    scene.add("s", palpa.SurfaceAndFriction(field="a", levels=[dict(value=0.5)]))
    session = palpa.Session(scene)
    del scene
    gc.collect()
    session.ticks(np.zeros((100, 3)), 1e-3)
    assert reference() is not None
    del session
    gc.collect()
    assert reference() is None, "freed with the last that reads it"


def test_nobody_writes_into_what_is_read():
    whole = numbers()
    part = whole[1:4]
    palpa.array_volume(part, spacing_m)
    for array in (part, whole):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0, 0] = 1
    mine = numbers()
    volume = palpa.array_volume(mine, spacing_m, copy=True)
    before = only(volume)(np.zeros(3))[0]
    mine[:] = 0
    assert only(volume)(np.zeros(3))[0] == before != 0


def test_a_read_only_array_is_read():
    array = numbers()
    array.flags.writeable = False
    np.testing.assert_allclose(only(palpa.array_volume(array, spacing_m))(centres_m(array.shape))[0], array)
    np.testing.assert_allclose(only(palpa.array_volume(np.frombuffer(numbers("int16").tobytes(), "int16").reshape(5, 6, 7),
                                                       spacing_m))(centres_m(array.shape))[0], array)


@pytest.mark.parametrize("array, error, words", [
    (numbers("int64"), ValueError, "an array of int64 cannot be read where it is; copy=True reads a copy as float64"),
    (numbers("int8"), ValueError, "copy as int16"),
    (numbers("bool"), ValueError, "copy as uint8"),
    (numbers("float16"), ValueError, "copy as float32"),
    (numbers(">f4"), ValueError, "copy=True"),
    (numbers()[::2], ValueError, "not close to one another"),
    (numbers()[:, :3], ValueError, "not close to one another"),
    (np.broadcast_to(np.float32(1), (10**6, 10**6, 10**6)), ValueError, "not close to one another"),
    (numbers().astype(object), TypeError, "an array of object holds no voxels"),
    (numbers("complex128"), TypeError, "an array of complex128 holds no voxels"),
    (numbers("U3"), TypeError, "holds no voxels"),
    (np.zeros((3, 3), "f4"), ValueError, "shape (3, 3) is no volume"),
    (np.zeros((3, 3, 3, 3, 3), "f4"), ValueError, "is no volume"),
    (np.zeros((3, 3, 3, 4), "f4"), ValueError, "vectors that are not of 3 components"),
    (np.zeros((3, 0, 3), "f4"), ValueError, "has no voxels"),
    (np.float32(3), TypeError, "an array of numpy, not float32"),
    ([[[1, 2], [3, 4]]], TypeError, "an array of numpy, not list"),
    (None, TypeError, "an array of numpy, not NoneType"),
])
def test_what_is_no_volume_is_told_in_one_line(array, error, words):
    with pytest.raises(error) as told:
        palpa.array_volume(array, spacing_m)
    assert words in str(told.value) and "\n" not in str(told.value)


@pytest.mark.parametrize("dtype", ["int8", "bool", "uint32", "int64", "uint64", "float16", ">f4", ">i2", ">f8"])
def test_a_copy_may_be_of_any_type(dtype):
    array = numbers(dtype)[::2, :, ::-1]
    values = only(palpa.array_volume(array, spacing_m, copy=True))(centres_m(array.shape))[0]
    np.testing.assert_allclose(values, array.astype(float), rtol=1e-6)


def test_a_copy_never_rounds_in_silence():
    with pytest.raises(ValueError, match="beyond 2\\^53"):
        palpa.array_volume(np.full((2, 2, 2), 2**53 + 1, dtype=np.int64), 1, copy=True)


@pytest.mark.parametrize("spacing", [0, -1, (1, 2), (0, 1, 1), np.nan, (1, np.inf, 1), "wide", (1e-320, 1, 1)])
def test_spacings_that_make_no_grid_are_refused(spacing):
    with pytest.raises((ValueError, TypeError)) as told:
        palpa.array_volume(numbers(), spacing)
    assert "\n" not in str(told.value)


def test_voxels_that_are_not_finite_have_no_data():
    array = numbers()
    array[2, 3, 3] = np.nan
    field = only(palpa.array_volume(array, spacing_m))
    values, gradients = field(centres_m(array.shape))
    assert np.isnan(values[2, 3, 3]) and np.isnan(gradients[2, 3, 3]).all()
    assert values[0, 0, 0] == array[0, 0, 0]
    outside = field(np.array([[1, 0, 0], [np.nan, 0, 0], [np.inf, 0, 0], [1e300, 0, 0]]))
    assert np.isnan(outside[0]).all() and np.isnan(outside[1]).all()


def test_points_have_three_numbers():
    field = only(palpa.array_volume(numbers(), spacing_m))
    assert field(np.zeros(3))[0].shape == () and field([[0, 0, 0]])[1].shape == (1, 3)
    assert field(np.zeros((0, 3)))[0].shape == (0,) and field(np.zeros((2, 0, 3)))[1].shape == (2, 0, 3)
    for wrong in (np.zeros((3, 2)), 5, np.zeros((3, 0)), []):
        with pytest.raises(ValueError, match="its last axis is of 3"):
            field(wrong)
    with pytest.raises(TypeError, match="takes an array of numbers"):
        field(["a", "b", "c"])
    swapped = np.asfortranarray(centres_m((5, 6, 7)).astype(">f8"))
    assert (field(swapped)[0] == field(centres_m((5, 6, 7)))[0]).all()


def test_derived_fields_are_sampled_alike():
    scene = palpa.Scene()
    scene.add("flow", palpa.lamb_oseen_vortex())
    points = np.random.default_rng(3).uniform(-0.02, 0.02, (100000, 3))
    velocity, jacobian = scene.field("flow")(points)
    np.testing.assert_allclose(scene.field("magnitude(flow)")(points)[0], np.linalg.norm(velocity, axis=1), rtol=1e-12)
    radius = np.hypot(points[:, 0], points[:, 1])
    speed = 0.02 / (2 * np.pi * radius) * -np.expm1(-((radius / 0.01) ** 2))
    np.testing.assert_allclose(np.linalg.norm(velocity, axis=1), speed, rtol=1e-9)
    np.testing.assert_allclose(np.trace(jacobian, axis1=1, axis2=2), 0, atol=1e-9)
    with pytest.raises(palpa.SceneError, match="flow"):
        scene.field("flwo")


def test_many_threads_sample_one_field():
    field = only(palpa.array_volume(numbers("int16"), spacing_m))
    points = np.random.default_rng(4).uniform(-0.002, 0.002, (200000, 3))
    want, results = field(points), [None] * 6
    threads = [threading.Thread(target=lambda n=n: results.__setitem__(n, field(points))) for n in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all((a[0] == want[0]).all() and (a[1] == want[1]).all() for a in results)


def test_an_array_is_felt_as_its_file(tmp_path):
    array = (100 * np.exp(-np.sum(centres_m((20, 30, 40)) ** 2, axis=-1) / 3e-4)).astype("<f4")
    (tmp_path / "a.raw").write_bytes(array.tobytes())
    path = np.stack([np.linspace(-0.01, 0.01, 500), np.zeros(500), np.linspace(0.1, 0, 500)], axis=1)
    felt = []
    for volume in (palpa.array_volume(array, spacing_m), palpa.read_volume(
            tmp_path / "a.raw", type="float32", dims=(40, 30, 20), spacing_m=spacing_m,
            origin_m=tuple(centres_m((20, 30, 40))[0, 0, 0]))):
        scene = palpa.Scene()
        scene.add("a", volume)
        scene.add("s", palpa.SurfaceAndFriction(field="a", levels=[dict(value=50, strength_n=2)]))
        felt.append(palpa.Session(scene).ticks(path, 1e-3))
    assert felt[0].tobytes() == felt[1].tobytes() and np.abs(felt[0]["force_n"]).max() > 0.5


@pytest.mark.parametrize("dtype", ["uint8", "int16", "uint16", "int32", "float32", "float64"])
def test_what_is_masked_is_no_data(dtype):
    values = np.zeros((20, 20, 20), dtype)
    values[:10] = 100
    masked = np.ma.array(values, mask=np.zeros(values.shape, bool))
    masked[:, :, :10] = np.ma.masked
    scene = palpa.Scene()
    field = scene.field(scene.add_array("half", masked, 0.001, filter="trilinear"))
    assert np.isnan(field((-0.005, 0.003, -0.005))[0]) and field((0.005, 0.003, -0.005))[0] == 100
    scene.add("wall", palpa.SurfaceAndFriction(field="half", levels=[dict(value=50, strength_n=5)]))
    scene.workspace.scale, scene.workspace.center = 1, (0, 0, 0)
    for x, is_felt in ((-0.006, False), (0.006, True)):
        down = np.column_stack([np.full(400, x), np.zeros(400), np.linspace(0.008, -0.004, 400)])
        assert (np.abs(palpa.Session(scene).ticks(down, 1e-3)["force_n"]).max() > 0.1) == is_felt
    unmasked = np.ma.array(values)  # not copied
    assert np.shares_memory(palpa.array_volume(unmasked, 0.001).fields["data"].voxels, values)


def test_where_voxels_lie_is_said_in_full():
    array = np.zeros((3, 4, 5), np.float32)
    for spacing in (np.float32(0.001), np.int64(1), np.array(0.001), 1):
        assert palpa.array_volume(array, spacing).fields["data"].affine_m[0, 0] == float(spacing)
    with pytest.warns(palpa.PalpaWarning, match="'spacing_m' was not given: the voxels are 1 m apart, so that the array is 4 m long"):
        palpa.array_volume(array)
    with pytest.raises(ValueError, match="'axes' has columns of the lengths 2, 2, 2; they are directions"):
        palpa.array_volume(array, 0.001, axes=2 * np.eye(3))
    turned = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]])
    palpa.array_volume(array, 0.001, axes=turned.astype(np.float32))
    with pytest.raises(ValueError, match="'axes' has columns"):
        palpa.array_volume(array, 0.001, axes=np.full((3, 3), np.nan))


def test_the_filter_can_be_asked_for():
    rough = np.random.default_rng(1).normal(size=(16, 16, 16)).astype(np.float32)
    z, y, x = np.mgrid[-1:1:32j, -1:1:32j, -1:1:32j]
    smooth = np.exp(-(x**2 + y**2 + z**2)).astype(np.float32)
    scene = palpa.Scene()
    for name, array, filter, expected in (
            ("whole", rough.astype(np.int16), None, "smooth"), ("rough", rough, None, "smooth"), ("fine", smooth, None, "cubic"),
            ("vectors", np.stack([smooth] * 3, axis=3), None, "trilinear"), ("asked", rough, "trilinear", "trilinear")):
        field = scene.field(scene.add_array(name, array, 0.001, filter=filter))
        assert field.filter == scene.volumes[name].filter == expected and expected in repr(field), name
        if expected in ("cubic", "trilinear") and field.components == 1:  # these interpolate the voxels
            places = (field.affine_m @ [5, 6, 7, 1])[:3]
            np.testing.assert_allclose(field(places)[0], array[7, 6, 5], rtol=1e-5)
    scene.add("formula", palpa.head_phantom())
    assert scene.field("formula").filter is None and scene.field("gradient_magnitude(fine)").filter == "smooth"


def test_what_is_masked_is_written_no_more_than_what_is_not():
    values = np.zeros((6, 6, 6), np.float32)
    masked = np.ma.array(values)
    volume = palpa.array_volume(masked, 0.001)
    with pytest.raises(ValueError, match="read-only"):
        masked[0, 0, 0] = 1
    assert volume.fields["data"].value_ranges == [(0, 0)]
    vectors = np.ma.masked_greater(np.ones((4, 4, 4, 3)) * [1, 2, 3], 2)
    assert np.isnan(palpa.array_volume(vectors, 0.001).fields["data"]((0, 0, 0))[0]).any()
    whole = np.ma.masked_equal(np.arange(216, dtype=np.int64).reshape(6, 6, 6), 0)
    assert np.isnan(palpa.array_volume(whole, 0.001).fields["data"]((-0.0025, -0.0025, -0.0025))[0])


def test_places_that_are_masked_are_none():
    field = only(palpa.array_volume(numbers(), spacing_m))
    points = np.ma.array(np.zeros((3, 3)), mask=[[0, 0, 0], [1, 0, 0], [1, 1, 1]])
    values, gradients = field(points)
    assert list(np.isnan(values)) == [False, True, True] and np.isnan(gradients[1]).all()
    for wrong in (np.zeros(3, complex), np.zeros(3, "datetime64[s]"), np.array(["1", "2", "3"])):
        with pytest.raises(TypeError, match="takes an array of numbers"):
            field(wrong)


@pytest.mark.parametrize("spacing", [True, 1j, "0.001", [0.001], [[0.001] * 3], {"x": 1}, np.zeros(4), "1 mm", object(), np.array(["1", "2", "3"]),
                                     np.timedelta64(1, "s")])
def test_a_spacing_is_a_number_or_three(spacing):
    with pytest.raises(TypeError, match="'spacing_m' takes a number or three numbers") as told:
        palpa.array_volume(numbers(), spacing)
    assert "\n" not in str(told.value)
    for right in ([np.float32(1)] * 3, (1, np.int8(1), 1.0), np.ones(3, np.float16), np.ones(3, ">i4"), np.uint8(1)):
        assert palpa.array_volume(numbers(), right).fields["data"].affine_m[2, 2] == 1
