"""Tools: their keys, the feet of modes, turns and torques of ticks."""

import pickle

import numpy as np
import pytest

import palpa

ROD = dict(shape="rod", length_m=0.06, points=7)


def floor_scene(**given):
    scene = palpa.Scene(stiffness_n_per_m=500, **given)
    scene.add("floor", palpa.plane_field())
    scene.workspace.scale = 1
    scene.workspace.center = (0, 0, 0)
    scene.add("floor", palpa.SurfaceAndFriction(field="floor", levels=[dict(value=0, strength_n=100)]))
    return scene


def test_a_scene_has_a_point_until_a_tool_is_set():
    scene = floor_scene()
    bare = scene.copy()
    assert scene.tool == palpa.ToolOptions() and scene.tool.shape == "point"
    assert "[tool]" not in scene.to_toml()
    scene.tool = palpa.ToolOptions(**ROD)
    assert scene.tool == palpa.ToolOptions(**ROD) == floor_scene(tool=palpa.ToolOptions(**ROD)).tool
    assert scene != bare and scene == scene.copy()
    assert "[tool]\nshape = \"rod\"\nlength_m = 0.06\npoints = 7\n" in scene.to_toml()
    scene.tool.length_m = 0.08
    assert scene.tool.length_m == 0.08, "of the scene, not of a copy"
    scene.tool = floor_scene().tool
    assert scene == bare


def test_points_need_no_word():
    points = [(0, 0, 0), (0, 0.01, -0.02)]
    for given in (points, np.array(points), [list(point) for point in points]):
        tool = palpa.ToolOptions(points_m=given)
        assert tool.points_m == ((0, 0, 0), (0, 0.01, -0.02)) and tool.shape == "points"
    assert palpa.ToolOptions(points_m=[]) == palpa.ToolOptions()
    scene = floor_scene(tool=palpa.ToolOptions(points_m=points))
    assert scene.tool.points_m == tuple(points)


def test_what_fits_no_tool_is_refused_in_one_line():
    for wrong, message in ((dict(shape="rood"), "did you mean 'rod'"), (dict(share=0), "'share' is 0; it lies above 0"),
                           (dict(points=257), "'points' is 257; it lies between 1 and 256"),
                           (dict(points_m=[[0, 0, np.nan]]), "'points_m' is nan; it is a finite number")):
        with pytest.raises(ValueError, match=message):
            palpa.ToolOptions(**wrong)
    for wrong in (3, "points", [1, 2, 3], [[1, 2]], [["a", 2, 3]]):
        with pytest.raises(TypeError, match="ToolOptions: 'points_m' takes Sequence"):
            palpa.ToolOptions(points_m=wrong)
    with pytest.raises(TypeError, match="ToolOptions: no parameter 'lenght_m'; did you mean 'length_m'"):
        palpa.ToolOptions(lenght_m=1)
    scene = floor_scene()
    for wrong, message in ((dict(shape="rod"), "length_m of a rod must be above 0"), (dict(length_m=0.1), "length_m is of a rod"),
                           (dict(points_m=np.zeros((257, 3))), "'points_m' has more than 256 points")):
        with pytest.raises(palpa.SceneError, match=message):
            scene.tool = palpa.ToolOptions(**wrong)
        assert scene.tool == palpa.ToolOptions(), "nothing changed"
    with pytest.raises(TypeError, match="Scene: 'tool' takes a palpa.ToolOptions, not dict"):
        scene.tool = ROD
    with pytest.raises(AttributeError, match="did you mean 'tool.length_m'"):
        scene.length_m = 1


def test_modes_have_feet():
    scene = floor_scene()
    scene.add("thick", palpa.Viscosity(strength_n=1), feet="all")
    assert scene.modes["thick"].feet == "all" and scene.modes["floor"].feet is None
    scene.modes["floor"].feet = "first"
    assert "feet = \"first\"" in scene.to_toml() and scene.modes["floor"].feet == "first"
    scene.modes["floor"].feet = None
    assert scene.modes["floor"].feet is None
    for wrong in ("last", 3, True):
        with pytest.raises(ValueError, match="'feet' is 'all', 'first' or None, not"):
            scene.modes["floor"].feet = wrong
        with pytest.raises(ValueError, match="'feet' is 'all'"):
            scene.add("more", palpa.Viscosity(strength_n=1), feet=wrong)
    with pytest.raises(TypeError, match="'masks', 'enabled' and 'feet' are of modes"):
        scene.add("ball", palpa.sphere_field(), feet="all")


def test_tools_and_ticks_are_pickled():
    scene = floor_scene(tool=palpa.ToolOptions(points_m=[(0, 0, 0.01)], turning_radius_m=0.05), max_torque_nm=0.2)
    scene.modes["floor"].feet = "first"
    again = pickle.loads(pickle.dumps(scene))
    assert again.to_toml() == scene.to_toml() and again.tool == scene.tool and again.modes["floor"].feet == "first"
    assert pickle.loads(pickle.dumps(palpa.ToolOptions(**ROD))) == palpa.ToolOptions(**ROD)
    tick = palpa.Session(scene).tick((0, 0, -0.005), 1e-3, turn=(0.6, 0, 0.8, 0))
    copy = pickle.loads(pickle.dumps(tick))
    for name in ("torque_nm", "probe_turn", "proxy_turn"):
        assert getattr(copy, name).tobytes() == getattr(tick, name).tobytes()


def test_a_turn_is_four_numbers():
    session = palpa.Session(floor_scene(tool=palpa.ToolOptions(**ROD)))
    for wrong in ((1, 0, 0), 3, "turn", (1, 0, 0, "a"), np.eye(2)):
        with pytest.raises(TypeError, match=r"'turn' takes four numbers \[w, x, y, z\], not"):
            session.tick((0, 0, 0.05), 1e-3, turn=wrong)
    for same in ((1, 0, 0, 0), [1, 0, 0, 0], np.array([1.0, 0, 0, 0])):
        assert session.tick((0, 0, 0.05), 1e-3, turn=same).status == palpa.TickStatus.resting


def test_a_point_has_neither_turn_nor_torque():
    session = palpa.Session(floor_scene())
    for depth_m in (-0.001, 0.005):
        tick = session.tick((0, 0, -depth_m), 1e-3, turn=(0.6, 0, 0.8, 0))
    np.testing.assert_allclose(tick.force_n, (0, 0, 2.5), atol=1e-9)
    assert (tick.torque_nm == 0).all() and (tick.proxy_turn == (1, 0, 0, 0)).all()
    step, primitive = session.sub_steps()[-1], session.primitives()[-1]
    assert step["turning_radius_m"] == 0 and (step["turn_rad"] == 0).all() and (step["start_turn"] == (1, 0, 0, 0)).all()
    assert primitive["foot"] == 0 and (primitive["lever_m"] == 0).all()
