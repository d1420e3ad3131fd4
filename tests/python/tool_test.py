"""Tools: their keys, the feet of modes, turns and torques of ticks."""

import pickle
import time

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


def test_force_and_torque_of_a_flat_rod_follow_the_lever_rule():
    # A rod of two feet 60 mm apart, held 10 mm off its middle: the torque of equal depth is the force times that lever.
    scene = floor_scene(tool=palpa.ToolOptions(points_m=[(-0.03, 0, 0), (0.03, 0, 0)], centre_m=(0.01, 0, 0), turning_radius_m=0.1),
                        max_torque_nm=1)
    session = palpa.Session(scene)
    for depth_m in (-0.001, 0.001, 0.002, 0.004):
        tick = session.tick((0, 0, -depth_m), 1e-3)
    assert tick.status == palpa.TickStatus.resting and tick.error_bound_m <= 1e-9
    np.testing.assert_allclose(tick.force_n, (0, 0, 2), atol=1e-8)
    np.testing.assert_allclose(tick.torque_nm, 0, atol=1e-8)
    tilted = (np.cos(0.002), 0, np.sin(0.002), 0)
    for _ in range(3):
        tick = session.tick((0, 0, -0.004), 1e-3, turn=tilted)
    turned = 2 * np.arctan2(tick.proxy_turn[2], tick.proxy_turn[0])
    np.testing.assert_allclose(tick.torque_nm, (0, 500 * 0.1**2 * (turned - 0.004), 0), atol=1e-9)
    assert abs(turned) < 1e-6, "both feet stay on the floor"
    steps = session.sub_steps()
    assert all(step["turning_radius_m"] == 0.1 for step in steps)
    placed = session.primitives()[slice(*steps[-1]["primitives"])]
    assert {each["foot"] for each in placed} == {0, 1}
    np.testing.assert_allclose(sorted(each["lever_m"][0] for each in placed), (-0.04, 0.02), atol=1e-5)


def test_a_turn_that_is_no_rotation_is_bad_input():
    session = palpa.Session(floor_scene(tool=palpa.ToolOptions(**ROD)))
    for wrong in ((0, 0, 0, 0), (1, 1, 0, 0), (np.nan, 0, 0, 0), (np.inf, 0, 0, 0)):
        tick = session.tick((0, 0, 0.05), 1e-3, turn=wrong)
        assert tick.status == palpa.TickStatus.bad_input and (tick.force_n == 0).all() and (tick.torque_nm == 0).all()
    assert session.tick((0, 0, 0.05), 1e-3, turn=(0.9995, 0, 0, 0)).status == palpa.TickStatus.resting, "rounded digits"


def test_a_device_of_ones_own_is_turned_and_drives_torque():
    class Held(palpa.Device):
        limits = palpa.DeviceLimits(max_force_n=3, max_torque_nm=0.1)

        def __init__(self):
            self.written, self.reads = [], 0

        def read(self):
            self.reads += 1
            # Presses and lifts again: after ticks missed on a busy machine the force returns where nothing is felt.
            pressed, lifted = min(self.reads % 1200, 1000), max(self.reads % 1200 - 1000, 0)
            return palpa.DeviceState((0, 0, 0.036 - 1e-5 * pressed + 5e-5 * lifted), turn=(np.cos(0.05), 0, np.sin(0.05), 0))

        def write(self, force_n, torque_nm):
            self.written.append((force_n.copy(), torque_nm.copy()))

    device = Held()
    with palpa.live(floor_scene(tool=palpa.ToolOptions(**ROD)), device=device, duration_s=20) as live:
        while live.is_running and not any(np.linalg.norm(torque) > 1e-3 for _, torque in device.written[-500:]):
            time.sleep(0.05)
    torques = np.array([np.linalg.norm(torque) for _, torque in device.written])
    assert torques.max() > 1e-3 and torques.max() <= 0.1 + 1e-12
    assert (device.written[-1][0] == 0).all() and (device.written[-1][1] == 0).all(), "zero at the end"
    assert palpa.DeviceState((0, 0, 0)).turn is None and palpa.DeviceState((0, 0, 0), turn=(0, 1, 0, 0)).turn[1] == 1
    guarded = palpa.GuardedSession(floor_scene(tool=palpa.ToolOptions(**ROD)), palpa.DeviceLimits(max_force_n=3, max_torque_nm=0.1))
    assert guarded.tick((0, 0, 0.05), 1e-3, turn=(0, 1, 0, 0)).command_torque_nm.shape == (3,)


def rotation_vectors(count):
    """Turns of a handle that tilts and rolls, of a length below pi."""
    share = np.linspace(0, 1, count)
    return np.column_stack([0.3 * np.sin(5 * share), 0.5 * share, -0.2 * share**2])


def quaternion_of(rotation_rad):
    angle = np.linalg.norm(rotation_rad)
    return (np.cos(angle / 2), *(np.sinc(angle / 2 / np.pi) / 2 * rotation_rad))


def test_ticks_take_turns_like_tick_and_tell_torques():
    scene = floor_scene(tool=palpa.ToolOptions(**ROD), max_torque_nm=1)
    path = np.column_stack([np.zeros(400), np.zeros(400), np.linspace(0.04, 0.02, 400)])
    turns = rotation_vectors(400)
    rows = palpa.Session(scene).ticks(path, 1e-3, turns)
    session = palpa.Session(scene)
    ticks = [session.tick(at, 1e-3, turn=quaternion_of(turn)) for at, turn in zip(path, turns)]
    for name in ("force_n", "torque_nm", "proxy_m"):
        np.testing.assert_allclose(rows[name], [getattr(tick, name) for tick in ticks], atol=1e-8)
    assert np.linalg.norm(rows["torque_nm"], axis=1).max() > 1e-3
    np.testing.assert_allclose(rows["probe_turn_rad"], turns, atol=1e-12)
    np.testing.assert_allclose([quaternion_of(turn) for turn in rows["proxy_turn_rad"]], [tick.proxy_turn for tick in ticks],
                               atol=1e-8)
    apart = rows["proxy_turn_rad"][-1] - rows["probe_turn_rad"][-1]
    assert np.linalg.norm(apart) > 0, "the floor turns it"
    upright = palpa.Session(scene).ticks(path, 1e-3)
    assert upright.tobytes() == palpa.Session(scene).ticks(path, 1e-3, np.zeros((400, 3))).tobytes()
    assert (upright["proxy_turn_rad"] == 0).all()


def test_turns_and_torques_are_columns_of_a_frame():
    pytest.importorskip("pandas")
    frame = palpa.Session(floor_scene(tool=palpa.ToolOptions(**ROD))).ticks(np.zeros((3, 3)), 1e-3).frame()
    assert {"torque_x_nm", "probe_turn_y_rad", "proxy_turn_z_rad"} <= set(frame.columns)


def test_rollouts_take_turns_like_ticks():
    scene = floor_scene(tool=palpa.ToolOptions(**ROD))
    paths = np.zeros((3, 200, 3)) + np.linspace(0.04, 0.02, 200)[None, :, None] * (0, 0, 1)
    turns = np.stack([rotation_vectors(200) * scale for scale in (0, 0.5, 1)])
    rolled = palpa.rollout(scene, paths, 1e-3, turns_rad=turns, threads=2)
    for path, turn, rows in zip(paths, turns, rolled):
        assert rows.tobytes() == palpa.Session(scene).ticks(path, 1e-3, turn).tobytes()
    several = palpa.rollout(scene, list(paths), 1e-3, turns_rad=list(turns))
    assert [rows.tobytes() for rows in several] == [rows.tobytes() for rows in rolled]


def test_turns_of_another_shape_are_refused():
    scene = floor_scene(tool=palpa.ToolOptions(**ROD))
    session, path = palpa.Session(scene), np.zeros((5, 3)) + (0, 0, 0.05)
    for wrong in (np.zeros((5, 4)), np.zeros(5), 3.0):
        with pytest.raises((TypeError, ValueError), match="'turns_rad'"):
            session.ticks(path, 1e-3, wrong)
    with pytest.raises(ValueError, match="'turns_rad' has 4 rotation vectors for 5 positions"):
        session.ticks(path, 1e-3, np.zeros((4, 3)))
    with pytest.raises(ValueError, match=r"'turns_rad\[1\]' has 4 rotation vectors for 5 positions"):
        palpa.rollout(scene, [path, path], 1e-3, turns_rad=[np.zeros((5, 3)), np.zeros((4, 3))])
    with pytest.raises(ValueError, match="'turns_rad' has 1 arrays for 2 paths; give one per path, or None"):
        palpa.rollout(scene, [path, path], 1e-3, turns_rad=[np.zeros((5, 3))])
    unknown = np.zeros((5, 3))
    unknown[2] = np.nan
    rows = session.ticks(path, 1e-3, unknown)
    assert [bool(bad) for bad in rows["status"] == palpa.TickStatus.bad_input] == [False, False, True, False, False]


def test_a_live_recording_of_a_point_refuses_a_tool():
    scene = floor_scene()
    with palpa.live(scene, hand="sim:press", duration_s=5) as live:
        held = live.scene
        held.tool = palpa.ToolOptions(**ROD)
        with pytest.raises(palpa.SceneError, match="a recording of a point has no columns for a tool; end it, and record the tool"):
            live.scene = held
        assert live.scene.tool == palpa.ToolOptions() and live.is_running
        live.scene = scene
