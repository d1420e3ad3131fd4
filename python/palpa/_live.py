"""Live scenes, rendered in real time on a thread of their own, which never blocks."""

from __future__ import annotations

import atexit
import os
import signal
import sys
import threading
import warnings
import weakref
from os import PathLike
from typing import Any

from . import _palpa
from ._device import Device
from ._modes import plugins
from ._palpa import MouseHand
from ._parameters import Strict
from ._sliders import sliders
from ._scene import PalpaWarning, Scene
from ._trace import Trace, _hand_given, _in_python, _new_folder

_running = weakref.WeakSet()
# Signals that cannot be caught, that neither end nor stop a program, and faults, after which Python cannot run.
_not_handled = {getattr(signal, "SIG" + name) for name in
                "KILL STOP CONT CHLD URG WINCH SEGV BUS FPE ILL TRAP SYS ABRT".split()}


@atexit.register
def _stop_all():
    for live in list(_running):
        if live._live.is_forked():  # its own process stops it
            continue
        try:
            live.stop()
        except Exception:  # the others must be stopped, too
            sys.excepthook(*sys.exc_info())


def _handle_signals():
    """Delays signals that end or stop the program until a Python device has no force. The library's own handlers cannot: they
    run in the thread that holds the interpreter, which the device's code needs. Handlers of the program stay."""
    if threading.current_thread() is threading.main_thread():
        for number in signal.valid_signals() - _not_handled:
            if signal.getsignal(number) == signal.SIG_DFL:
                signal.signal(number, _at_rest)


def _at_rest(number, _):
    def as_the_system_does():
        signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
        signal.signal(number, _at_rest)  # a stopped program may continue

    _palpa.with_motors_at_rest(as_the_system_does)


class Live(Strict):
    """A scene that runs in real time, from palpa.live; `with` ends it. Any thread may read and change it."""

    def __init__(self, _live: Any, _folder: Any, _temporary: Any, _device: Device | None = None) -> None:
        self._live, self._folder, self._temporary, self._trace, self._told = _live, _folder, _temporary, None, ()
        self._device = _device
        _running.add(self)
        self._tell(4)

    def _tell(self, stacklevel):
        """Raises new messages as warnings."""
        told = tuple(_in_python(sentence) for sentence in self._live.told())
        fresh = [sentence for sentence in told if sentence not in self._told]
        self._told = (*self._told, *fresh)
        for sentence in fresh:
            warnings.warn(sentence, PalpaWarning, stacklevel=stacklevel)

    @property
    def scene(self) -> Scene:
        """a copy of the scene set last; assign a scene to change it from the next tick on"""
        return Scene(_of=self._live.scene())

    @scene.setter
    def scene(self, scene: Scene) -> None:
        self._live.set_scene(scene)

    @property
    def is_running(self) -> bool:
        """True until its loop ends"""
        return not self._live.has_ended()

    def latest(self) -> dict[str, Any]:
        """The latest tick: a dict with tick, t_s, probe_m, proxy_m, force_n, command_n, guard, guard_cause, status, and fault:
        the device's fault, or None."""
        return self._live.latest()

    def primitives(self) -> list[dict[str, Any]]:
        """The primitives of one of the latest ticks, for drawing: a dict each with kind, mode (its index), position_m,
        direction, strength_n, force_n, hand frame."""
        return self._live.primitives()

    def statistics(self) -> dict[str, Any]:
        """Timing of its loop: a dict with ticks, missed, unrecorded, scenes, and times in microseconds."""
        return self._live.statistics()

    def panic(self) -> None:
        """Removes the force from the next tick on, until `resume`."""
        self._live.panic()

    def resume(self) -> None:
        """Resumes after a panic, with the gate and the ramp of a start."""
        self._live.resume()

    def sliders(self, *places: str) -> Any:
        """Sliders of ipywidgets for numbers of the scene, which change it from the next tick on.

        places: "coupling.stiffness_n_per_m", "skin.strength_n", "skin.levels[0].friction_n", …; none: the stiffness, and the
        strengths, frictions and drags that are above 0. Raises ImportError without ipywidgets, KeyError for other places."""
        return sliders(self, *places)

    def stop(self) -> Trace:
        """Ends the run: the motors have no force. Returns its Trace. Raises LoadError if recording has failed."""
        if self._trace is None:
            try:
                lost = self._live.finish()
            finally:
                _running.discard(self)
                if self._device is not None:
                    self._device._is_held = False
            if lost:
                raise _palpa.LoadError(lost)
            trace = self._trace = Trace(self._folder, _temporary=self._temporary)
            try:
                self._tell(3)
            finally:
                trace.warnings = self._told
        return self._trace

    def __repr__(self):
        return f"Live({'running' if self._trace is None and self.is_running else 'over'}, {self._folder})"

    def __enter__(self) -> Live:
        return self

    def __exit__(self, *error: object) -> None:
        if not self._live.is_forked():  # it runs on in its own process
            self.stop()


def live(scene: Scene, *, hand: str | PathLike | None = None, device: str | MouseHand | Device | None = None,
         rate_hz: float = 1000.0, duration_s: float | None = None, out: str | PathLike | None = None, hold: str | None = None,
         place: str | None = None, fit: bool | None = None) -> Live:
    """Runs a scene in real time and records it; returns a Live at once.

    device: name of a haptic device, as listed by `palpa devices`; a palpa.MouseHand, the mouse of a window; or a palpa.Device,
    driven by Python behind the guard. Or hand: a simulated or recorded hand, as in palpa.run, which holds `device`; place,
    hold, fit: as there. rate_hz: [Hz] 100 to 20000. duration_s: [s] None: until stopped; 10 s with a simulated hand.
    Raises SceneError for a scene with modes in Python: they are too slow for real time.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"'scene' takes a palpa.Scene, not {type(scene).__name__}")
    pointer = device if isinstance(device, MouseHand) else None
    own = device if isinstance(device, Device) else None
    if (pointer is not None or own is not None) and hand is not None:
        raise TypeError(f"'hand' and a palpa.{'MouseHand' if pointer is not None else 'Device'} are two hands; name one")
    if device is not None and pointer is None and own is None and not isinstance(device, str):
        raise TypeError(f"'device' takes a name, a palpa.MouseHand or a palpa.Device, not {type(device).__name__}")
    if own is not None and getattr(own, "_is_held", False):
        raise ValueError("'device' is held by another live scene; stop that first")
    if hand is not None and not isinstance(hand, (str, PathLike)):
        raise TypeError(f"'hand' takes 'sim:…' or the path of a recorded hand, not {type(hand).__name__}; palpa.run feels positions")
    given = dict(rate_hz=rate_hz) if hand is None else _hand_given(hand, None, rate_hz, place, fit)
    folder, temporary = _new_folder(out)
    given.update(device=device if isinstance(device, str) else None, duration_s=duration_s, out=folder, hold=hold,
                 plugins=list(plugins))
    if own is not None:
        _handle_signals()
    made = Live(_palpa.live(scene, given, pointer, own), folder, temporary, own)
    if own is not None:
        own._is_held = True
    return made
