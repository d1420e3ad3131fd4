"""To and from VTK's Python module: its readers' data equal Palpa's; a live scene under the mouse."""

import gc
import time

import numpy as np
import pytest

import palpa

vtk = pytest.importorskip("vtk")
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy  # noqa: E402


def only(volume):
    (field,) = volume.fields.values()
    return field


def oblique(dtype="int16"):
    """4 × 3 × 2 points with unique values."""
    image = vtk.vtkImageData()
    image.SetExtent(1, 4, -1, 1, 2, 3)
    image.SetSpacing(0.001, 0.002, 0.003)
    image.SetOrigin(0.1, 0.2, 0.3)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    image.SetDirectionMatrix(*(turn * np.sign(np.linalg.det(turn))).ravel())
    values = (np.arange(24) ** 2 % 101).astype(dtype)
    array = numpy_to_vtk(values, deep=True)
    array.SetName("ct")
    image.GetPointData().SetScalars(array)
    return image


def places(data):
    return np.array([data.GetPoint(n) for n in range(data.GetNumberOfPoints())])


@pytest.mark.parametrize("dtype", ["uint8", "int8", "int16", "uint16", "int32", "uint32", "int64", "float32", "float64"])
def test_an_image_has_its_values_at_its_places(dtype):
    image = oblique(dtype)
    values = vtk_to_numpy(image.GetPointData().GetScalars()).astype(float)
    volume = palpa.from_vtk(image)
    assert list(volume.fields) == ["ct"]
    np.testing.assert_allclose(only(volume)(places(image))[0], values, atol=1e-6)
    in_mm = palpa.from_vtk(image, metres_per_unit=0.001)
    np.testing.assert_allclose(only(in_mm)(places(image) * 0.001)[0], values, atol=1e-6)
    back = palpa.to_vtk(only(volume), name="ct")
    np.testing.assert_allclose(places(back), places(image), atol=1e-12)
    np.testing.assert_array_equal(vtk_to_numpy(back.GetPointData().GetScalars()), values)


def test_nothing_is_copied_and_all_of_it_is_kept():
    image = oblique()
    view = vtk_to_numpy(image.GetPointData().GetScalars())
    field = only(palpa.from_vtk(image))
    assert np.shares_memory(field.voxels, view) and not field.voxels.flags.writeable
    copy = only(palpa.from_vtk(image, copy=True))
    assert not np.shares_memory(copy.voxels, view)
    expected = view.copy()
    del image, view
    gc.collect()
    np.testing.assert_array_equal(field.voxels.ravel(), expected)


def test_planes_at_uneven_distances_and_cells():
    grid = vtk.vtkRectilinearGrid()
    grid.SetDimensions(3, 2, 3)
    for put, at in ((grid.SetXCoordinates, (0, 0.1, 0.4)), (grid.SetYCoordinates, (0, 0.1)), (grid.SetZCoordinates, (0, 0.3, 0.4))):
        put(numpy_to_vtk(np.array(at, float), deep=True))
    for data, count in ((grid.GetPointData(), 18), (grid.GetCellData(), 4)):
        array = numpy_to_vtk(np.arange(count, dtype=float) ** 2, deep=True)
        array.SetName("v")
        data.AddArray(array)
    image = vtk.vtkImageData()
    image.SetDimensions(3, 2, 2)
    image.SetOrigin(0.5, 0, 0)
    array = numpy_to_vtk(np.array([1.0, 3.0]), deep=True)
    array.SetName("c")
    image.GetCellData().AddArray(array)
    values = only(palpa.from_vtk(image))([(1, 0.5, 0.5), (1.5, 0.5, 0.5), (2, 0.5, 0.5)])[0]
    np.testing.assert_allclose(values, [1, 2, 3])
    volume = palpa.from_vtk(grid)
    assert list(volume.fields) == ["v", "v_cells"]
    np.testing.assert_allclose(volume.fields["v"](places(grid))[0], np.arange(18) ** 2.0)
    np.testing.assert_allclose(volume.fields["v_cells"]((0.25, 0.05, 0.35))[0], 3.0**2)


def test_what_has_no_grid_or_blank_cells_is_resampled(needs_reader):
    image = vtk.vtkImageData()
    image.SetDimensions(9, 9, 9)
    image.AllocateScalars(vtk.VTK_FLOAT, 1)
    image.GetPointData().GetScalars().SetName("v")
    image.GetPointData().GetScalars().Fill(5)
    image.AllocateCellGhostArray()
    image.GetCellGhostArray().SetValue(0, vtk.vtkDataSetAttributes.HIDDENCELL)
    volume = palpa.from_vtk(image)
    values = only(volume)([(0.5, 0.5, 0.5), (6.5, 6.5, 6.5)])[0]
    assert np.isnan(values[0]) and abs(values[1] - 5) < 1e-6 and any("resampled" in w for w in volume.warnings)
    image.GetCellGhostArray().SetValue(0, vtk.vtkDataSetAttributes.DUPLICATECELL)
    assert only(palpa.from_vtk(image)).voxels.shape == (9, 9, 9), "data like all others"


def test_what_is_wrong_is_one_line():
    image = vtk.vtkImageData()
    with pytest.raises(palpa.LoadError, match="vtkImageData: has no voxels; "):
        palpa.from_vtk(image)
    image.SetDimensions(2, 2, 2)
    with pytest.raises(palpa.LoadError, match="vtkImageData: has no array; one with 1 or 3 numbers"):
        palpa.from_vtk(image)
    image.AllocateScalars(vtk.VTK_UNSIGNED_CHAR, 3)
    with pytest.raises(palpa.LoadError, match="three bytes are a colour"):
        palpa.from_vtk(image)
    image.SetSpacing(0, 1, 1)
    image.AllocateScalars(vtk.VTK_FLOAT, 1)
    with pytest.raises(palpa.LoadError, match="vtkImageData: cannot be placed in the world"):
        palpa.from_vtk(image)
    with pytest.raises(palpa.LoadError, match="vtkPolyData: has no cells"):
        palpa.from_vtk(vtk.vtkPolyData())
    with pytest.raises(TypeError, match="'data' is a data set of VTK, not int"):
        palpa.from_vtk(3)
    with pytest.raises(ValueError, match="'metres_per_unit' is nan"):
        palpa.from_vtk(oblique(), metres_per_unit=float("nan"))


@pytest.mark.parametrize("name", ["cfd_wing/wing.vti", "mol_hydrogen/hydrogen.vti", "mri_flow_carotid/carotid.vtk"])
def test_vtks_own_readers_and_ours_are_felt_alike(name, shared, needs_reader):
    reader = vtk.vtkXMLImageDataReader() if name.endswith("vti") else vtk.vtkDataSetReader()
    reader.SetFileName(str(shared / name))
    if name.endswith("vtk"):
        reader.ReadAllScalarsOn(), reader.ReadAllVectorsOn()
    reader.Update()
    volumes = [palpa.from_vtk(reader.GetOutput()), palpa.read_volume(shared / name)]
    rows = []
    for volume in volumes:
        scene = palpa.Scene()
        first = scene.add("data", volume)
        field = next(iter(volume.fields.values()))
        if field.components == 1:
            scene.add("wall", palpa.SurfaceAndFriction(field=first, levels=[dict(value=0.8 * field.value_ranges[0][0] + 0.2 * field.value_ranges[0][1], strength_n=1)]))
        else:
            scene.add("rail", palpa.Follow(field=first, strength_n=1))
        s = np.arange(1000) * 1e-3
        rows.append(palpa.Session(scene).ticks(np.stack([0.06 * np.sin(7 * s), 0.05 * np.cos(5 * s), 0.06 * np.sin(3 * s)], 1), 1e-3))
    ours, theirs = ([f.value_ranges for f in v.fields.values()] for v in volumes)
    assert ours == theirs and list(volumes[0].fields) == list(volumes[1].fields)
    assert rows[0].tobytes() == rows[1].tobytes() and np.abs(rows[0]["force_n"]).max() > 0.05


def test_a_trace_is_a_line_with_every_column(tmp_path):
    scene = palpa.Scene()
    scene.add("ball", palpa.sphere_field())
    scene.add("wall", palpa.SurfaceAndFriction(field="ball", levels=[dict(value=0, strength_n=2)]))
    trace = palpa.run(scene, "sim:press", duration_s=0.5)
    line = palpa.to_vtk(trace)
    matrix = scene.hand_to_world()
    np.testing.assert_allclose(places(line), trace.ticks["proxy_m"] @ matrix[:3, :3].T + matrix[:3, 3], atol=1e-12)
    force_n = vtk_to_numpy(line.GetPointData().GetArray("mode.wall.force_n"))
    assert force_n.shape == (500, 3) and np.abs(force_n).max() > 0.1
    threshold = vtk.vtkThreshold()  # of cells: the line is one cell, so the selection is by vertices
    threshold.SetInputData(line)
    threshold.SetInputArrayToProcess(0, 0, 0, 0, "t_s")
    threshold.SetLowerThreshold(0.1), threshold.SetUpperThreshold(0.2)
    threshold.SetThresholdFunction(threshold.THRESHOLD_BETWEEN)
    threshold.Update()
    assert threshold.GetOutput().GetNumberOfPoints() == np.count_nonzero((trace.ticks["t_s"] >= 0.1) & (trace.ticks["t_s"] <= 0.2))
    trace.export(tmp_path / "felt.csv")
    assert len((tmp_path / "felt.csv").read_text().splitlines()) == 501
    with pytest.raises(palpa.LoadError, match="exists already"):
        trace.export(tmp_path / "felt.csv")


def test_transfer_functions_there_and_back():
    strength = palpa.Strength(of="ct", points=[(-300, 0), (0, 1), (0, 4), (500, 5)], outside=0)
    seen = palpa.to_vtk(strength, factor=0.2)
    back = palpa.strength_from_vtk(seen, "ct", factor=5)
    for value in np.arange(-400, 600, 7.3):
        below = [p for p in strength.points if p[0] <= value]
        above = [p for p in strength.points if p[0] > value]
        expected = np.interp(value, [below[-1][0], above[0][0]], [below[-1][1], above[0][1]]) if below and above else 0
        assert abs(seen.GetValue(value) - 0.2 * expected) < 1e-9
    assert [round(p[1], 9) for p in back.points if p[1] > 0] == [1, 4, 5]
    begins_with_a_step = palpa.to_vtk(palpa.Strength(of="ct", points=[(0, 1), (1, 2)], outside=0))
    assert [begins_with_a_step.GetValue(v) for v in (-1, 0, 0.5, 1, 2)] == [0, 1, 1.5, 2, 0]
    clamps = vtk.vtkPiecewiseFunction()
    with pytest.raises(ValueError, match="has no points"):
        palpa.strength_from_vtk(clamps, "ct")
    clamps.AddPoint(0, 0), clamps.AddPoint(1, 1)
    with pytest.raises(ValueError, match="clamps to 0 below and to 1 above"):
        palpa.strength_from_vtk(clamps, "ct")


@pytest.mark.parametrize("parallel", [True, False])
def test_the_hand_goes_where_the_mouse_points(parallel):
    scene = palpa.Scene()
    scene.workspace.towards_user, scene.workspace.up = "-y", "+z"
    scene.add("ball", palpa.sphere_field())
    to_world, moved = scene.hand_to_world(), []

    class Hand:
        def move(self, way_m):
            moved.append(way_m)

    renderer, window, interactor = vtk.vtkRenderer(), vtk.vtkRenderWindow(), vtk.vtkRenderWindowInteractor()
    window.AddRenderer(renderer), window.SetSize(400, 300), interactor.SetRenderWindow(window)
    interactor.EnableRenderOff()  # no display
    interactor.SetInteractorStyle(vtk.vtkInteractorStyleTrackballCamera())
    camera = renderer.GetActiveCamera()
    camera.SetPosition(0.1, -0.5, 0.2), camera.SetFocalPoint(0, 0, 0), camera.SetViewUp(0, 0, 1)
    camera.SetParallelProjection(parallel), camera.SetParallelScale(0.1)
    keep = palpa.MousePointer(interactor, renderer, Hand(), to_world)

    def at(x, y, event="MouseMoveEvent"):
        interactor.SetEventInformation(x, y)
        interactor.InvokeEvent(event)

    def seen_at(place_m):
        matrix = camera.GetCompositeProjectionTransformMatrix(400 / 300, -1, 1)
        seen = np.array(matrix.MultiplyPoint((*place_m, 1)))
        return 0.5 * np.array([400, 300]) * seen[:2] / seen[3]

    start = seen_at((0, 0, 0))
    at(200, 150), moved.clear()
    at(223, 131)
    # The hand follows the mouse on the screen, in the plane of the focal point.
    assert np.allclose(seen_at(to_world[:3, :3] @ moved[0]) - start, (23, -19), atol=0.05)
    at(223, 131, "MouseWheelForwardEvent")
    assert np.allclose(np.linalg.norm(moved[-1]), 0.002)
    way = to_world[:3, :3] @ moved[-1]
    assert np.allclose(way / np.linalg.norm(way), camera.GetDirectionOfProjection())
    at(223, 131, "MouseWheelBackwardEvent")
    assert np.allclose(moved[-1], -moved[-2])
    position, count = camera.GetPosition(), len(moved)
    at(223, 131, "LeftButtonPressEvent"), at(250, 160), at(250, 160, "LeftButtonReleaseEvent")
    assert len(moved) == count and camera.GetPosition() != position  # a drag turns the view, and the hand rests
    assert keep is not None


def test_actors_follow_a_mouse_that_feels():
    scene = palpa.Scene()
    scene.add("ball", palpa.sphere_field())
    scene.add("wall", palpa.SurfaceAndFriction(field="ball", levels=[dict(value=0, strength_n=2)]))
    hand, renderer = palpa.MouseHand(), vtk.vtkRenderer()
    hand.put((0, 0, 0.09))
    actors = palpa.FeltActors(renderer, 0.1, scene.hand_to_world())
    with palpa.live(scene, device=hand) as live:
        kinds, visible, end = set(), 0, time.monotonic() + 10
        while time.monotonic() < end and ("plane" not in kinds or visible < 3):
            hand.move((0, 0, -0.0005))
            time.sleep(0.005)
            actors.update(live)  # a tick may pass before the next line reads the primitives
            kinds |= {p["kind"] for p in live.primitives()}
            visible = sum(a.GetVisibility() for a in renderer.GetActors())
        assert "plane" in kinds and visible >= 3
        with pytest.raises(ValueError, match="the hand of another live scene"):
            palpa.live(scene, device=hand)
    palpa.live(scene, device=hand).stop()
    with pytest.raises(TypeError, match="two hands"):
        palpa.live(scene, hand="sim:press", device=hand)


def test_a_length_of_the_world_is_no_size_of_a_picture():
    from scene_test import head_scene

    renderer, scene = vtk.vtkRenderer(), head_scene()
    scale = np.linalg.norm(scene.hand_to_world()[:3, 0])
    for wrong in (0.15 * scale + 0.5, 34.0, 0.0, -0.1, float("nan")):
        with pytest.raises(ValueError, match="metres of the hand.*divided by"):
            palpa.FeltActors(renderer, wrong, scene.hand_to_world())
    actors = palpa.FeltActors(renderer, 0.08, scene.hand_to_world())
    with pytest.raises(AttributeError, match="no attribute 'view_half_height_hand_m'"):
        actors.view_half_height_hand_m = 0.1
    with pytest.raises(TypeError, match="'view_half_height_hand_m' takes a number, not str"):
        palpa.FeltActors(renderer, "0.08")
    for wrong in (scene, np.eye(3), "identity"):
        with pytest.raises(TypeError, match="'hand_to_world' takes a matrix of shape"):
            palpa.FeltActors(renderer, 0.08, wrong)
