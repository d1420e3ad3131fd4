"""The user's own devices behind the limiter: its promises hold for any Python code."""

import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import palpa
from live_test import wait_for


def wall_scene(strength_n=10):
    scene = palpa.Scene(stiffness_n_per_m=500, damping_ns_per_m=0, max_force_n=8)
    scene.add("floor", palpa.plane_field())
    scene.workspace.scale, scene.workspace.center = 1, (0, 0, 0)
    scene.add("wall", palpa.SurfaceAndFriction(field="floor", levels=[dict(value=0, strength_n=strength_n)]))
    return scene


class Handle(palpa.Device):
    """A simulated device that a hand lowers into the wall; it records its commands with their times."""

    # Without motors: a busy machine's late ticks are no fault.
    limits = palpa.DeviceLimits(max_force_n=2, max_stiffness_n_per_m=1000, has_motors=False)

    def __init__(self, depth_m=0.003):
        self.depth_m, self.sent, self.closed, self.reads = depth_m, [], 0, 0
        self.on_read = self.on_write = lambda: None
        self.threads = set()

    def read(self):
        self.threads.add(threading.get_ident())
        self.reads += 1
        self.on_read()
        return palpa.DeviceState((0, 0, max(-self.depth_m, 0.005 - 1e-5 * self.reads)))

    def write(self, force_n):
        self.threads.add(threading.get_ident())
        self.on_write()
        self.sent.append((time.monotonic(), float(force_n[2]), np.linalg.norm(force_n)))

    def close(self):
        self.closed += 1

    def pushes(self):
        return bool(self.sent) and self.sent[-1][1] > 0.5

    def wait_for_push(self, condition=lambda: True):
        """On a busy machine a pause of 50 ms is a fault, and the session restarts within the wall: then it is lowered once
        more."""
        for _ in range(10):
            end = time.monotonic() + 5
            while time.monotonic() < end:
                if self.pushes() and condition():
                    return
                time.sleep(0.01)
            self.reads = 0
        raise AssertionError("waited in vain")


def test_a_device_in_python_is_driven_behind_the_guard():
    handle = Handle(depth_m=0.02)  # demands 10 N
    with palpa.live(wall_scene(), device=handle, duration_s=60) as live:
        handle.wait_for_push(lambda: live.latest()["guard"] == "limited")
        with pytest.raises(ValueError, match="held by another live scene"):
            palpa.live(wall_scene(), device=handle)
        assert live.latest()["fault"] is None
    forces = np.array([force for _, _, force in handle.sent])
    assert forces.max() <= 2.0 and forces.max() > 1.9, "the device's limit"
    assert forces[-1] == 0.0 and handle.closed == 1 and len(handle.threads) == 1
    ticks = live.stop().ticks
    assert ticks["guard"][0] == "waiting" and {"ramp", "limited"} <= set(ticks["guard"])
    steps = np.linalg.norm(np.diff(ticks["command_n"], axis=0), axis=1)
    assert steps.max() <= 1000 * np.diff(ticks["t_s"])[steps.argmax()] + 1e-9 or ticks["command_n"][steps.argmax() + 1, 2] == 0
    with palpa.live(wall_scene(), device=handle, duration_s=0.1):  # again, after its release
        pass


@pytest.mark.parametrize("where", ["on_read", "on_write"])
def test_what_it_raises_takes_the_force_away(where):
    handle = Handle()
    with pytest.warns(palpa.PalpaWarning, match="raised OSError: the cable.*released"):
        with palpa.live(wall_scene(), device=handle, duration_s=60) as live:
            handle.wait_for_push()
            fails = [True]

            def fail():
                if fails:
                    raise OSError("the cable is out")

            at, failed_s = len(handle.sent), time.monotonic()
            setattr(handle, where, fail)
            wait_for(lambda: live.latest()["fault"] == "the device's own code raised an exception")
            wait_for(lambda: not live.latest()["command_n"].any())
            time.sleep(0.3)
            assert not live.latest()["command_n"].any()
            sent = [force for begin_s, _, force in handle.sent[at:] if begin_s > failed_s + 0.02]
            assert not any(sent), "nothing but zero while it fails"
            if where == "on_read":  # still writable
                assert handle.sent[-1][2] == 0.0 and handle.sent[-1][0] > failed_s
            fails.clear()
            wait_for(lambda: live.latest()["fault"] is None)
            begin = len(handle.sent)
            handle.reads = 0  # the session restarts at the hand: it comes down again
            handle.wait_for_push()
            back = [force for _, _, force in handle.sent[begin:]]
            assert back[0] == 0.0, "and comes back by gate and ramp"
    assert handle.sent[-1][2] == 0.0 and handle.closed == 1
    trace = live.stop()
    assert any("the cable is out" in sentence for sentence in trace.warnings)
    assert "device_fault" in set(trace.ticks["guard_cause"]) | {str(value) for value in trace.events["value"]}


@pytest.mark.parametrize("where", ["on_read", "on_write"])
def test_what_does_not_return_takes_the_force_away(where):
    handle, goes_on = Handle(), threading.Event()
    with palpa.live(wall_scene(), device=handle, duration_s=60) as live:
        handle.wait_for_push()
        setattr(handle, where, lambda: goes_on.wait(20))
        wait_for(lambda: live.latest()["fault"] == "the device's own code does not return")
        wait_for(lambda: not live.latest()["command_n"].any())
        time.sleep(0.1)
        at = len(handle.sent)
        setattr(handle, where, lambda: None)
        goes_on.set()
        wait_for(lambda: len(handle.sent) > at + 1)
        first = handle.sent[at + (where == "on_write")]
        assert first[2] == 0.0, "the first word after it is zero"
        handle.reads = 0
        handle.wait_for_push()
    assert handle.sent[-1][2] == 0.0


def test_code_that_never_returns_holds_nobody_up():
    handle, goes_on = Handle(), threading.Event()
    live = palpa.live(wall_scene(), device=handle, duration_s=60)
    handle.wait_for_push()
    handle.on_read = lambda: goes_on.wait(30)
    time.sleep(0.1)
    begin_s = time.monotonic()
    with pytest.warns(palpa.PalpaWarning, match="did not return at the end"):
        live.stop()
    assert time.monotonic() - begin_s < 10
    goes_on.set()
    wait_for(lambda: handle.closed == 1)
    assert handle.sent[-1][2] == 0.0


@pytest.mark.parametrize("end", ["", "sys.exit(3)", "1 / 0", "os.kill(os.getpid(), signal.SIGINT); time.sleep(5)", "del live; gc.collect()",
                                 "signal.signal(signal.SIGTERM, lambda *_: sys.exit(1)); os.kill(os.getpid(), signal.SIGTERM); time.sleep(5)"])
def test_however_a_program_ends_the_last_word_is_zero(end, tmp_path):
    program = f"""
import gc, os, signal, sys, time
sys.path.insert(0, {str(__file__.rsplit('/', 1)[0])!r})
from device_test import Handle, wall_scene
import palpa
log = open({str(tmp_path / 'log')!r}, "w", buffering=1)
class Logged(Handle):
    def write(self, force_n):
        super().write(force_n)
        print(float(force_n[2]), file=log)
    def close(self):
        print("closed", file=log)
handle = Logged()
live = palpa.live(wall_scene(), device=handle, duration_s=100)
handle.wait_for_push()
{end}
"""
    child = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    lines = (tmp_path / "log").read_text().splitlines()
    assert lines[-2:] == ["0.0", "closed"] and max(float(line) for line in lines[:-1]) > 0.5, child.stderr


def test_what_is_no_position_is_none():
    for returned in (None, (np.nan, 0, 0), palpa.DeviceState((0, 0, 0), valid=False)):
        handle = Handle()
        with palpa.live(wall_scene(), device=handle, duration_s=60) as live:
            handle.wait_for_push()
            handle.read = lambda returned=returned: returned
            wait_for(lambda: not live.latest()["command_n"].any())
            assert live.latest()["guard"] in ("falling", "waiting")
    handle = Handle()
    with palpa.live(wall_scene(), device=handle, duration_s=60) as live:
        handle.wait_for_push()
        handle.read = lambda: palpa.DeviceState((0, 0, -0.003), fault="too warm")
        wait_for(lambda: live.latest()["fault"] == "too warm" and not live.latest()["command_n"].any())


def test_what_is_no_device_is_refused():
    class Unlimited(palpa.Device):
        pass

    for device, error, words in ((Unlimited(), TypeError, "limits = palpa.DeviceLimits"), (object(), TypeError, "palpa.Device"),
                                 (Unlimited, TypeError, "palpa.Device")):
        with pytest.raises(error, match=words):
            palpa.live(wall_scene(), device=device)
    with pytest.raises(TypeError, match="two hands"):
        palpa.live(wall_scene(), device=Handle(), hand="sim:press")
    for wrong in (dict(max_force_n=-1), dict(max_force_n=float("nan")), dict(max_force_n=2, max_stiffness_n_per_m=0)):
        with pytest.raises(ValueError, match=list(wrong)[-1]):
            palpa.DeviceLimits(**wrong)
    with pytest.raises(TypeError):
        palpa.DeviceLimits()

    class Silent(palpa.Device):
        limits = palpa.DeviceLimits(max_force_n=1)

    with pytest.warns(palpa.PalpaWarning, match="NotImplementedError: Silent has no method 'read"):
        with palpa.live(wall_scene(), device=Silent(), duration_s=60) as live:
            wait_for(lambda: live.latest()["fault"] is not None)


def test_a_guarded_session_is_the_guard_for_a_loop_of_ones_own():
    limits = palpa.DeviceLimits(max_force_n=2, max_stiffness_n_per_m=400)
    guarded = palpa.GuardedSession(wall_scene(), limits)
    frames = [guarded.tick((0, 0, max(-0.01, 0.002 - 1e-5 * n)), 1e-3) for n in range(3000)]
    command = np.array([frame.command_n for frame in frames])
    asked = np.array([frame.tick.force_n for frame in frames])
    sizes = np.linalg.norm(command, axis=1)
    assert sizes.max() <= 2.0 and sizes[-1] > 1.99, "limit"
    assert np.linalg.norm(np.diff(command, axis=0), axis=1).max() <= 1.0 + 1e-9, "slew"
    np.testing.assert_allclose(asked[-1], (0, 0, 400 * 0.01), atol=1e-9), "no stiffer than the device bears"
    assert frames[0].guard == "waiting" and {frame.guard for frame in frames} >= {"ramp", "limited"}
    # A fault: zero within three ticks, and back only through gate and ramp.
    after = [guarded.tick((0, 0, -0.01), 1e-3, fault=n < 5) for n in range(200)]
    assert np.linalg.norm(after[3].command_n) == 0 and after[4].guard in ("falling", "waiting")
    assert all(np.linalg.norm(frame.command_n) < 0.5 for frame in after[3:])
    for wrong in (dict(position_m=(np.nan, 0, 0)), dict(position_m=(0, 0, -0.01), valid=False)):
        assert not np.array([guarded.tick(dt_s=1e-3, **wrong).command_n for _ in range(4)])[-1].any()
    guarded.panic()
    for _ in range(5):
        frame = guarded.tick((0, 0, -0.01), 1e-3)
    assert frame.guard == "off" and not frame.command_n.any()
    guarded.resume()
    assert guarded.tick((0, 0, -0.01), 1e-3).guard == "waiting"
    with pytest.raises(TypeError, match="position_m"):
        guarded.tick("down", 1e-3)


def test_a_mode_that_raises_is_a_fault_of_the_guarded_session():
    class Fragile(palpa.Mode):
        fails = False

        def place(self, here, out):
            if Fragile.fails:
                raise RuntimeError("lab")
            out.directed(0, (0, 0, 1), 1.0)

    scene = palpa.Scene(stiffness_n_per_m=500)
    scene.add("lab", Fragile())
    guarded = palpa.GuardedSession(scene, palpa.DeviceLimits(max_force_n=2))
    for _ in range(3000):
        frame = guarded.tick((0, 0, 0), 1e-3)
    assert np.linalg.norm(frame.command_n) > 0.5
    Fragile.fails = True
    with pytest.raises(RuntimeError, match="lab"):
        guarded.tick((0, 0, 0), 1e-3)
    Fragile.fails = False
    assert np.linalg.norm([guarded.tick((0, 0, 0), 1e-3).command_n for _ in range(3)][-1]) == 0
    with pytest.raises(palpa.SceneError, match="written in Python"):
        palpa.live(scene, device=Handle())


@pytest.mark.parametrize("how", ["no place", "nan", "no return", "raises"])
def test_what_is_not_there_holds_no_button(how):
    class WithButton(Handle):
        gone = threading.Event()
        back = threading.Event()

        def read(self):
            state = palpa.DeviceState(super().read().position_m, buttons=1)
            if not self.gone.is_set():
                return state
            if how == "no return":
                self.back.wait(20)
                return state
            if how == "raises":
                raise OSError("the cable is out")
            return palpa.DeviceState((0, 0, np.nan if how == "nan" else 0), valid=how == "nan", buttons=1)

    handle = WithButton()
    handle.gone.clear()
    handle.back.clear()
    with palpa.live(wall_scene(), device=handle, duration_s=60) as live:
        handle.wait_for_push()
        handle.gone.set()
        time.sleep(0.3)
        handle.back.set()
    ticks = live.stop().ticks
    assert ticks["buttons"][ticks["probe_valid"] != 0].min() == 1 and (ticks["probe_valid"] == 0).sum() > 50
    assert ticks["buttons"][ticks["probe_valid"] == 0].max() == 0


def test_a_device_lets_go_by_another_way_where_its_code_does_not_return():
    class Relay(Handle):
        released = 0

        def release(self):
            self.released += 1
            self.sent.append((time.monotonic(), 0.0, 0.0))

    handle, goes_on = Relay(), threading.Event()
    with palpa.live(wall_scene(), device=handle, duration_s=60) as live:
        handle.wait_for_push()
        handle.on_write = lambda: goes_on.wait(20)
        hung_s = time.monotonic()
        wait_for(lambda: handle.released)
        assert handle.sent[-1][2] == 0.0 and handle.sent[-1][0] - hung_s < 1, "not only once the call has returned"
        time.sleep(0.2)
        assert handle.released == 1, "once for each time"
        handle.on_write = lambda: None
        goes_on.set()
        wait_for(lambda: live.latest()["fault"] is None)
        handle.reads = 0
        handle.wait_for_push()
    assert handle.closed == 1 and handle.sent[-1][2] == 0.0


def test_a_program_that_ends_while_its_device_hangs_lets_go_and_ends(tmp_path):
    program = f"""
import sys, threading, time
sys.path.insert(0, {str(__file__.rsplit('/', 1)[0])!r})
from device_test import Handle, wall_scene
import palpa
class Relay(Handle):
    def release(self):
        open({str(tmp_path / 'released')!r}, "a").write("x")
handle = Relay()
live = palpa.live(wall_scene(), device=handle, duration_s=100)
handle.wait_for_push()
handle.on_read = lambda: time.sleep(30)
time.sleep(0.01)
sys.exit(3)
"""
    begin_s = time.monotonic()
    child = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert child.returncode == 3 and time.monotonic() - begin_s < 25, child.stderr
    assert (tmp_path / "released").read_text() == "x"


def test_a_step_that_no_loop_takes_is_late():
    down = [(0, 0, max(-0.004, 0.002 - 1e-5 * n)) for n in range(3000)]
    guarded = palpa.GuardedSession(wall_scene(), palpa.DeviceLimits(max_force_n=2))
    in_milliseconds = [guarded.tick(position_m, 1) for position_m in down]
    assert not any(frame.command_n.any() for frame in in_milliseconds) and in_milliseconds[-1].guard_cause == "late"
    guarded = palpa.GuardedSession(wall_scene(), palpa.DeviceLimits(max_force_n=2))
    assert np.linalg.norm([guarded.tick(position_m, 1e-3).command_n for position_m in down][-1]) > 1
    after = [guarded.tick(down[-1], 0.5)] + [guarded.tick(down[-1], 1e-3) for _ in range(4)]
    assert after[0].guard == "falling" and not after[3].command_n.any(), "its device had hung"
    slow = palpa.GuardedSession(wall_scene(), palpa.DeviceLimits(max_force_n=2))
    assert np.linalg.norm([slow.tick(position_m, 0.02).command_n for position_m in down][-1]) > 1, "50 Hz is a loop"


def test_a_guarded_device_that_fails_hangs_and_comes_back():
    """The page's loop, over a port that fails in every way; forces are the motor's."""
    rng, state = np.random.default_rng(5), dict(z=0.002, held=np.zeros(3))
    guarded = palpa.GuardedSession(wall_scene(), palpa.DeviceLimits(max_force_n=2))
    sizes, returned_at = [], None
    for n in range(20000):
        state["z"] = max(-0.004, state["z"] - 1e-5)
        wrong = rng.choice(["", "raises", "nan", "gone", "hangs"], p=[0.9992, 2e-4, 2e-4, 2e-4, 2e-4])
        position_m, dt_s, valid, fault = (0, 0, state["z"]), 1e-3, True, wrong in ("raises", "gone")
        if wrong == "nan":
            position_m = (np.nan, 0, 0)
        if wrong == "gone":
            valid, state["z"] = False, 0.002
        if wrong == "hangs":
            dt_s = 0.3
        frame = guarded.tick(position_m, dt_s, valid=valid, fault=fault)
        size = np.linalg.norm(frame.command_n)
        assert np.isfinite(size) and size <= 2.0
        if sizes and size > sizes[-1]:
            assert size - sizes[-1] <= 1.0 + 1e-9, "slew"
        if wrong:
            assert size <= (0.26 * sizes[-1] if sizes else 0), (n, wrong, size)
            returned_at = n
        if returned_at is not None and 3 <= n - returned_at < 200:
            assert size < 0.6, "by the ramp alone"
        sizes.append(size)
    assert max(sizes) > 1.9 and returned_at is not None


@pytest.mark.parametrize("name, is_busy", [("SIGTERM", False), ("SIGTSTP", False)] + [(name, True) for name in (
    "SIGTERM SIGHUP SIGTSTP SIGQUIT SIGTTIN SIGTTOU SIGUSR1 SIGALRM SIGXCPU SIGPROF SIGRTMIN".split())])
def test_a_signal_that_python_leaves_to_the_system_waits_for_zero(name, is_busy, tmp_path):
    program = f"""
import sys, time
sys.path.insert(0, {str(__file__.rsplit('/', 1)[0])!r})
from device_test import Handle, wall_scene
import palpa
log = open({str(tmp_path / 'log')!r}, "w", buffering=1)
class Logged(Handle):
    def write(self, force_n):
        super().write(force_n)
        print(float(force_n[2]), file=log)
handle = Logged()
live = palpa.live(wall_scene(), device=handle, duration_s=100)
handle.wait_for_push()
print("pushes", flush=True)
while True:
    {"pass" if is_busy else "time.sleep(1)"}
"""
    number = getattr(signal, name)
    # In a group of its own: the system does not stop an orphaned process group.
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True, process_group=0)
    try:
        assert child.stdout.readline() == "pushes\n"
        child.send_signal(number)
        if name in ("SIGTSTP", "SIGTTIN", "SIGTTOU"):
            wait_for(lambda: pathlib.Path(f"/proc/{child.pid}/stat").read_text().split()[2] == "T")
        else:
            assert child.wait(20) == -number, "as the system ends it"
        assert (tmp_path / "log").read_text().splitlines()[-1] == "0.0"
    finally:
        child.kill(), child.wait(), child.stdout.close()
