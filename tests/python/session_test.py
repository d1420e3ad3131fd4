"""Sessions: ticked one by one, or along a whole path; threads, interrupts, lifetimes."""

import gc
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import palpa
from scene_test import head_scene


def path_of(n):
    t = np.linspace(0, 1, n)
    return np.stack([0.02 * np.sin(9 * t), 0.02 * np.cos(7 * t), 0.08 - 0.06 * t], axis=1)


def test_a_path_at_once_is_tick_by_tick():
    scene = head_scene()
    path = path_of(2000)
    one_by_one, at_once = palpa.Session(scene), palpa.Session(scene)
    rows = at_once.ticks(path, 1e-3)
    assert rows.shape == (2000,)
    touched = 0
    for position, row in zip(path, rows):
        tick = one_by_one.tick(position, 1e-3)
        for name in ("probe_m", "proxy_m", "proxy_velocity_m_per_s", "force_n"):
            assert getattr(tick, name).tobytes() == row[name].tobytes()
        assert (tick.error_bound_m, tick.sub_steps, tick.iterations, int(tick.status), tick.dropped) == (
            row["error_bound_m"], row["sub_steps"], row["iterations"], row["status"], row["dropped"])
        touched += np.linalg.norm(tick.force_n) > 0.1
    assert touched > 50, "nothing was felt"
    assert one_by_one.modes()["skin"].force_n.shape == (3,)


def test_a_plane_pushes_back_by_hookes_law():
    scene = palpa.Scene(stiffness_n_per_m=500, damping_ns_per_m=0)
    scene.add("floor", palpa.plane_field())
    scene.workspace.scale = 1
    scene.workspace.center = (0, 0, 0)
    scene.add("floor", palpa.SurfaceAndFriction(field="floor", levels=[dict(value=0, strength_n=100)]))
    session = palpa.Session(scene)
    for depth_m in (-0.01, 0.0, 0.002, 0.01):
        tick = session.tick((0, 0, -depth_m), 1e-3)
        np.testing.assert_allclose(tick.force_n, (0, 0, 500 * max(depth_m, 0)), atol=1e-9)
    assert tick.status == palpa.TickStatus.resting and tick.error_bound_m <= 1e-9
    assert [kind for kind, _, _ in palpa.Session(scene).events()] == []


def test_positions_are_any_three_numbers():
    session = palpa.Session(head_scene())
    want = session.tick((0, 0.02, 0.5), 1e-3).probe_m
    for same in ([0, 0.02, 0.5], np.array([0, 0.02, 0.5]), np.array([0, 0.02, 0.5, 9], dtype=">f8")[:3], np.array([[0, 0.02, 0.5]])[0]):
        assert (session.tick(same, 1e-3).probe_m == want).all()
    for wrong in ((1, 2), (1, 2, "3"), 7, None, "abc", np.zeros((3, 1)), np.array([1, 2, "x"])):
        with pytest.raises(TypeError, match="'position_m' takes three numbers"):
            session.tick(wrong, 1e-3)
    with pytest.raises(TypeError, match="'positions_m' takes an array of numbers of shape"):
        session.ticks(np.zeros((4, 2)), 1e-3)
    with pytest.raises(ValueError, match="3 time steps for 4 positions"):
        session.ticks(np.zeros((4, 3)), np.full(3, 1e-3))
    assert session.ticks(np.zeros((0, 3)), 1e-3).shape == (0,)


def test_what_cannot_be_used_has_a_status_and_no_force():
    session = palpa.Session(head_scene())
    for position, dt_s in (((np.nan, 0, 0), 1e-3), ((np.inf, 0, 0), 1e-3), ((0, 0, 0), 0), ((0, 0, 0), -1), ((0, 0, 0), np.nan)):
        tick = session.tick(position, dt_s)
        assert tick.status == palpa.TickStatus.bad_input and not tick.force_n.any()
    rows = session.ticks(np.full((3, 3), np.nan), 1e-3)
    assert (rows["status"] == int(palpa.TickStatus.bad_input)).all()


def test_eight_threads_feel_eight_sessions():
    scene, path = head_scene(), path_of(20000)
    want = palpa.Session(scene).ticks(path, 1e-3)
    results = [None] * 8

    def feel(n):
        results[n] = palpa.Session(scene).ticks(path, 1e-3)

    threads = [threading.Thread(target=feel, args=(n,)) for n in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(result.tobytes() == want.tobytes() for result in results)


def test_one_session_is_felt_by_one_thread_at_a_time():
    session, path, refused = palpa.Session(head_scene()), path_of(300000), []
    thread = threading.Thread(target=session.ticks, args=(path, 1e-3))
    thread.start()
    while thread.is_alive() and not refused:
        try:
            session.tick((0, 0, 0), 1e-3)
        except RuntimeError as error:
            refused.append(str(error))
    thread.join()
    assert "another thread feels this session" in refused[0]
    session.tick((0, 0, 0), 1e-3)


def test_other_threads_go_on_while_a_path_is_felt():
    session, counted = palpa.Session(head_scene()), 0
    thread = threading.Thread(target=session.ticks, args=(path_of(300000), 1e-3))
    thread.start()
    while thread.is_alive():
        counted += 1
        time.sleep(0)
    assert counted > 10


@pytest.mark.parametrize("work", [
    "palpa.Session(scene).ticks(np.tile([[0, 0.02, 0.08], [0, 0.02, -0.08]], (1_000_000, 1)), 1e-3)",
    "palpa.run(scene, 'sim:stroke', duration_s=1e5)",
    "scene.field('head')(np.zeros((200_000_000, 3)))",
])
def test_an_interrupt_ends_what_is_under_way(work):
    program = ("import palpa, numpy as np, sys\nscene = palpa.Scene()\nhead = scene.add('head', palpa.head_phantom())\n"
               "scene.add('skin', palpa.SurfaceAndFriction(field=head, levels=[dict(value=-300, strength_n=0.8)]))\n"
               f"print('ready', flush=True)\ntry:\n    {work}\nexcept KeyboardInterrupt:\n    print('interrupted')\n")
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    time.sleep(1.5)
    child.send_signal(signal.SIGINT)
    said, _ = child.communicate(timeout=60)
    assert said == "interrupted\n" and child.returncode == 0


def test_a_child_process_goes_on_with_its_copy():
    session = palpa.Session(head_scene())
    session.ticks(path_of(500), 1e-3)
    child = os.fork()
    if child == 0:
        ok = np.isfinite(session.ticks(path_of(500), 1e-3)["force_n"]).all()
        os._exit(0 if ok else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def test_the_session_keeps_its_own_scene():
    scene = head_scene()
    session = palpa.Session(scene)
    scene.modes["skin"].enabled = False
    assert session.scene.modes["skin"].enabled
    del scene
    gc.collect()
    assert np.isfinite(session.tick((0, 0.02, 0.05), 1e-3).force_n).all()


def test_sessions_leave_nothing_behind():
    def resident_kb():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024

    array = np.zeros((8, 8, 8), dtype=np.int16)
    array[:4] = 100

    def feel():
        scene = palpa.Scene()
        scene.add_array("a", array, 0.01, filter="trilinear")
        scene.add("s", palpa.SurfaceAndFriction(field="a", levels=[dict(value=50)]))
        palpa.Session(scene).tick((0, 0, 0), 1e-3)

    for _ in range(200):
        feel()
    references, before = sys.getrefcount(array), resident_kb()
    for _ in range(2000):
        feel()
    gc.collect()
    assert sys.getrefcount(array) == references
    assert resident_kb() - before < 8000


def test_ticks_tell_all_of_every_tick():
    scene, path = head_scene(), path_of(1500)
    scene.add("syrup", palpa.Viscosity(field="head", drag_ns_per_m=1))
    rows = palpa.Session(scene).ticks(path, 1e-3)
    one_by_one, events = palpa.Session(scene), []
    names = [name for name in dir(palpa.Energy) if name.endswith("_j")]
    assert len(names) == 9
    for n, position in enumerate(path):
        tick = one_by_one.tick(position, 1e-3)
        assert [rows[name][n] for name in names] == [getattr(tick.energy, name) for name in names]
        for name, mode in one_by_one.modes().items():
            assert (rows.mode_force_n[name][n] == mode.force_n).all()
        assert rows.statuses[n] is tick.status or rows.statuses[n] == tick.status
        events += [(n, *event) for event in one_by_one.events()]
    assert rows.events == events and any(kind == "onset" for _, kind, _, _ in events)
    np.testing.assert_allclose(rows["t_s"], np.arange(1500) * 1e-3, atol=1e-12)
    assert ((rows["status"] == palpa.TickStatus.resting) == [status == palpa.TickStatus.resting for status in rows.statuses]).all()
    # The modes' forces and the spring balance at a resting proxy.
    assert set(rows.mode_force_n) == {"skin", "syrup"} and rows.mode_force_n["skin"].shape == (1500, 3)
    with pytest.raises(KeyError, match="did you mean 'skin'"):
        rows.mode_force_n["skn"]
    pandas = pytest.importorskip("pandas")
    frame = rows.frame()
    assert isinstance(frame, pandas.DataFrame) and len(frame) == 1500
    assert list(frame["force_z_n"]) == list(rows["force_n"][:, 2])
    assert list(frame["proxy_velocity_x_m_per_s"]) == list(rows["proxy_velocity_m_per_s"][:, 0])


@pytest.mark.parametrize("dt_s", [16, 1.0000001, 0, -1e-3, float("nan"), float("inf"), [1e-3, 16, 1e-3]])
def test_a_time_step_in_milliseconds_is_refused(dt_s):
    session = palpa.Session(head_scene())
    with pytest.raises(ValueError, match="'dt_s' is .*; a time step is in seconds, above 0 and at most 1"):
        session.ticks(np.zeros((3, 3)), dt_s)
    assert session.tick((0, 0, 0), 1e-3).status == palpa.TickStatus.resting, "nothing was felt"


def test_a_place_that_is_masked_is_not_known():
    path = np.ma.array(path_of(20))
    path[3, 1] = path[7] = np.ma.masked
    scene = head_scene()
    rows = palpa.Session(scene).ticks(path, 1e-3)
    assert list(np.flatnonzero(rows["status"] == palpa.TickStatus.bad_input)) == [3, 7]
    session, guarded = palpa.Session(scene), palpa.GuardedSession(scene, palpa.DeviceLimits(max_force_n=1))
    for each in (path[3], path[7], [0, np.ma.masked, 0]):
        assert session.tick(each, 1e-3).status == guarded.tick(each, 1e-3).tick.status == palpa.TickStatus.bad_input
    with palpa.run(scene, path, 1e-3) as felt:
        assert list(np.flatnonzero(~felt.ticks["probe_valid"])) == [3, 7]
    for steps in (np.ma.array(np.full(20, 1e-3), mask=np.arange(20) == 4), np.full(20, 16), np.full(20, np.nan)):
        with pytest.raises(ValueError, match="'dt_s' is "):
            session.ticks(path_of(20), steps)


def test_wrong_time_steps_are_told_by_every_call():
    scene, path = head_scene(), path_of(20)
    guarded = palpa.GuardedSession(scene, palpa.DeviceLimits(max_force_n=1))
    for wrong in (16, 0, -1e-3, np.nan, np.inf, 1.0000001):
        for call in (lambda: palpa.Session(scene).ticks(path, wrong), lambda: palpa.run(scene, path, wrong),
                     lambda: palpa.compare_laws(scene, path, wrong, ["no-proxy"])):
            with pytest.raises(ValueError, match="'dt_s' is .*; a time step is in seconds, above 0 and at most 1"):
                call()
        assert palpa.Session(scene).tick(path[0], wrong).status == palpa.TickStatus.bad_input
        assert not guarded.tick(path[0], wrong).command_n.any()
    for wrong in (True, "1e-3", None, 1j):
        for call in (lambda: palpa.Session(scene).ticks(path, wrong), lambda: palpa.run(scene, path, wrong),
                     lambda: palpa.compare_laws(scene, path, wrong, ["no-proxy"])):
            with pytest.raises(TypeError, match="dt_s|time step") as told:
                call()
            assert "\n" not in str(told.value)
    with pytest.raises(TypeError, match="positions_m"):
        palpa.compare_laws(scene, path.astype(complex), 1e-3)


# ---- state, many paths ----


def wandering(n, seed):
    phase = np.random.default_rng(seed).uniform(0, 6, 3)
    t_s = np.arange(n) * 1e-3
    return np.column_stack([0.005 * np.sin(2 * t_s + phase[0]), 0.02 + 0.005 * np.sin(3 * t_s + phase[1]),
                            0.05 + 0.012 * np.cos(8 * t_s)])


def assert_alike(rows, others):
    assert rows.tobytes() == others.tobytes() and rows.events == others.events
    assert all((rows.mode_force_n[name] == force_n).all() for name, force_n in others.mode_force_n.items())


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_a_rollout_equals_the_ticks_of_each_path(threads):
    scene, paths = head_scene(), [wandering(n, n) for n in (900, 0, 700, 1, 1200)]
    together = palpa.rollout(scene, paths, 1e-3, threads=threads)
    assert len(together) == len(paths) and np.abs(together[0]["force_n"]).max() > 0.1
    for path, rows in zip(paths, together):
        assert_alike(rows, palpa.Session(scene).ticks(path, 1e-3))


def test_a_rollout_has_a_scene_for_each_path():
    soft, firm = head_scene(), head_scene()
    firm.modes["skin"].mode.levels[0].strength_n = 3
    path = wandering(800, 3)
    rows = palpa.rollout([soft, firm], np.array([path, path]), 1e-3)
    assert_alike(rows[1], palpa.Session(firm).ticks(path, 1e-3))
    assert np.abs(rows[1]["force_n"]).max() > np.abs(rows[0]["force_n"]).max()
    with pytest.raises(ValueError, match="2 scenes for 3 paths"):
        palpa.rollout([soft, firm], [path] * 3, 1e-3)


def test_a_rollout_begins_in_the_state_of_a_session():
    path, session = wandering(1500, 4), palpa.Session(head_scene())
    session.ticks(path[:1000], 1e-3)
    rows = palpa.rollout(head_scene(), [path[1000:]] * 2, 1e-3, start=session)
    assert_alike(rows[0], rows[1])
    assert_alike(rows[0], session.ticks(path[1000:], 1e-3))


def test_a_rollout_says_what_is_wrong():
    for wrong, why in (([np.zeros((4, 2))], r"'paths_m\[0\]' takes an array"), ([np.zeros((4, 3)), 1], r"'paths_m\[1\]' takes")):
        with pytest.raises(TypeError, match=why):
            palpa.rollout(head_scene(), wrong, 1e-3)
    with pytest.raises(ValueError, match="'threads' is 0"):
        palpa.rollout(head_scene(), [np.zeros((4, 3))], 1e-3, threads=0)
    with pytest.raises(TypeError, match="'scene' takes a palpa.Scene"):
        palpa.rollout("head.toml", [np.zeros((4, 3))], 1e-3)
    broken = head_scene()

    class Broken(palpa.Mode):
        def place(self, here, out):
            raise ArithmeticError("of the mode")

    broken.add("broken", Broken())
    with pytest.raises(ArithmeticError, match="of the mode"):
        palpa.rollout(broken, [wandering(50, 1)] * 3, 1e-3, threads=2)


def test_an_interrupt_ends_a_rollout():
    class Ended(Exception):
        pass

    def end(number, frame):
        raise Ended

    before = signal.signal(signal.SIGALRM, end)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        with pytest.raises(Ended):
            palpa.rollout(head_scene(), [wandering(100000, 1)] * 1000, 1e-3)
    finally:
        signal.signal(signal.SIGALRM, before)


def test_a_copied_state_goes_on_alike():
    path, first, second = wandering(1500, 5), palpa.Session(head_scene()), palpa.Session(head_scene())
    first.ticks(path[:1000], 1e-3)
    second.copy_state_from(first)
    assert_alike(second.ticks(path[1000:], 1e-3), first.ticks(path[1000:], 1e-3))
    with pytest.raises(ValueError, match="the scenes differ"):
        second.copy_state_from(palpa.Session(palpa.Scene()))
    firm = head_scene()
    firm.modes["skin"].mode.levels[0].strength_n = 3
    third = palpa.Session(firm)
    third.resume_in_changed_scene(first)
    proxy_m = first.tick(path[-1], 1e-3).proxy_m
    assert np.linalg.norm(third.tick(path[-1], 1e-3).proxy_m - proxy_m) < 1e-3, "the proxy began elsewhere"


def test_primitives_of_a_tick_balance_the_spring():
    session = palpa.Session(head_scene())
    for depth_m in np.linspace(0, 0.0018, 40):
        tick = session.tick((0, 0.02, 0.049 - depth_m), 1e-3)
        last = session.sub_steps()[-1]
        placed = session.primitives()[slice(*last["primitives"])]
        spring_n = last["stiffness_n_per_m"] * (last["probe_m"] - last["balance_m"])
        assert np.linalg.norm(spring_n + sum((each["force_n"] for each in placed), last["directed_n"])) < 1e-6
        assert (last["proxy_m"] == tick.proxy_m).all()
    assert {each["kind"] for each in placed} == {"plane", "line"} and {each["state"] for each in placed} <= {"stick", "slip"}
    assert placed[0]["strength_n"] == pytest.approx(0.8) and np.linalg.norm(placed[0]["direction"]) == pytest.approx(1)


def test_the_path_and_the_force_limit_of_a_session_can_be_set():
    session = palpa.Session(head_scene())
    session.refine_path(4)
    assert session.ticks(wandering(600, 1), 1e-3)["sub_steps"].max() >= 4
    session.set_force_limit(float("inf"))
    session.set_force_limit(3.3)
    for wrong in (0, 17):
        with pytest.raises(ValueError, match="between 1 and 16"):
            session.refine_path(wrong)
    for wrong in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match="'most_n' is"):
            session.set_force_limit(wrong)


def test_a_session_has_the_map_of_its_scene():
    scene = head_scene()
    assert (palpa.Session(scene).hand_to_world() == scene.hand_to_world()).all()
