"""Live scenes: felt in real time on a thread of their own, which waits for nobody."""

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
from ._palpa import Pointer
from ._parameters import Strict
from ._scene import PalpaWarning, Scene
from ._trace import Trace, _hand_given, _in_python, _new_folder

_running = weakref.WeakSet()
# Those that cannot be taken, that neither end nor stop a program, and faults, after which nothing of Python runs.
_not_handled = {getattr(signal, "SIG" + name) for name in
                "KILL STOP CONT CHLD URG WINCH SEGV BUS FPE ILL TRAP SYS ABRT".split()}


@atexit.register
def _stop_all():
    for live in list(_running):
        if live._live.is_forked():  # by the process that it belongs to
            continue
        try:
            live.stop()
        except Exception:  # the others have to be stopped as well
            sys.excepthook(*sys.exc_info())


def _handle_signals():
    """From now on what ends or stops the program waits until a device in Python has no force. The library's own handlers cannot: they
    run within the very thread that has the interpreter, which the device's code needs. Those of the program are left alone."""
    if threading.current_thread() is threading.main_thread():
        for number in signal.valid_signals() - _not_handled:
            if signal.getsignal(number) == signal.SIG_DFL:
                signal.signal(number, _at_rest)


def _at_rest(number, _):
    def as_the_system_does():
        signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
        signal.signal(number, _at_rest)  # a program that was stopped goes on

    _palpa.with_motors_at_rest(as_the_system_does)


class Live(Strict):
    """A scene that is being felt. Made by palpa.live; `with` ends it. Any thread may ask and change."""

    def __init__(self, _live: Any, _folder: Any, _temporary: Any, _device: Device | None = None) -> None:
        self._live, self._folder, self._temporary, self._trace, self._told = _live, _folder, _temporary, None, ()
        self._device = _device
        _running.add(self)
        self._tell(4)

    def _tell(self, stacklevel):
        """Warns of what was not told yet."""
        told = tuple(_in_python(sentence) for sentence in self._live.told())
        fresh = [sentence for sentence in told if sentence not in self._told]
        self._told = (*self._told, *fresh)
        for sentence in fresh:
            warnings.warn(sentence, PalpaWarning, stacklevel=stacklevel)

    @property
    def scene(self) -> Scene:
        """the scene as it was set last, a copy; set another one to change what is felt from the next tick on"""
        return Scene(_of=self._live.scene())

    @scene.setter
    def scene(self, scene: Scene) -> None:
        self._live.set_scene(scene)

    @property
    def is_running(self) -> bool:
        """its loop is not over"""
        return not self._live.has_ended()

    def look(self) -> dict[str, Any]:
        """The latest tick: a dict with tick, t_s, probe_m, proxy_m, force_n, command_n, guard, guard_cause, status, and fault: what
        the device says is wrong with it, or None."""
        return self._live.look()

    def primitives(self) -> list[dict[str, Any]]:
        """What the modes placed in one of the latest ticks, to be drawn: a dict each with kind, mode (its number), position_m,
        direction, strength_n, force_n, hand frame."""
        return self._live.primitives()

    def account(self) -> dict[str, Any]:
        """How its loop keeps time: a dict with ticks, missed, unrecorded, scenes, and times in microseconds."""
        return self._live.account()

    def panic(self) -> None:
        """No force from the next tick on, until `resume`."""
        self._live.panic()

    def resume(self) -> None:
        """Lets it go on after a panic, with the gate and the ramp of a start."""
        self._live.resume()

    def stop(self) -> Trace:
        """Ends it: the motors have no force. Returns its Trace. Raises LoadError where recording failed on the way."""
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
        if not self._live.is_forked():  # it goes on in the process that it belongs to
            self.stop()


def live(scene: Scene, *, hand: str | PathLike | None = None, device: str | Pointer | Device | None = None,
         rate_hz: float = 1000.0, duration_s: float | None = None, out: str | PathLike | None = None, hold: str | None = None,
         place: str | None = None, fit: bool | None = None) -> Live:
    """Feels a scene in real time and records it: a Live, at once.

    device: of a person's hand, as `palpa devices` calls it; a palpa.Pointer, the mouse of a window; or a palpa.Device, driven by
    Python behind the guard. Or hand: a simulated or recorded one, as of palpa.run, which holds `device`; place, hold, fit: as
    there. rate_hz: [Hz] 100 to 20000. duration_s: [s] None: until it is stopped; of a simulated hand 10 s.
    Raises SceneError for a scene with modes in Python: they cannot keep time.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"'scene' takes a palpa.Scene, not {type(scene).__name__}")
    pointer = device if isinstance(device, Pointer) else None
    own = device if isinstance(device, Device) else None
    if (pointer is not None or own is not None) and hand is not None:
        raise TypeError(f"'hand' and a palpa.{'Pointer' if pointer is not None else 'Device'} are two hands; name one")
    if device is not None and pointer is None and own is None and not isinstance(device, str):
        raise TypeError(f"'device' takes a name, a palpa.Pointer or a palpa.Device, not {type(device).__name__}")
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
