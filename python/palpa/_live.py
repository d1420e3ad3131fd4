"""Live scenes: felt in real time on a thread of their own, which waits for nobody."""

from __future__ import annotations

import atexit
import weakref
from os import PathLike
from typing import Any

from . import _palpa
from ._modes import plugins
from ._palpa import Pointer
from ._scene import Scene
from ._trace import Trace, _new_folder

_running = weakref.WeakSet()


@atexit.register
def _stop_all():
    for live in list(_running):
        live.stop()


class Live:
    """A scene that is being felt. Made by palpa.live; `with` ends it. Any thread may ask and change."""

    def __init__(self, _live: Any, _folder: Any, _temporary: Any) -> None:
        self._live, self._folder, self._temporary, self._trace = _live, _folder, _temporary, None
        _running.add(self)

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
        """The latest tick: a dict with tick, t_s, probe_m, proxy_m, force_n, command_n, guard, status."""
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
            lost = self._live.finish()
            _running.discard(self)
            if lost:
                raise _palpa.LoadError(lost)
            self._trace = Trace(self._folder, _temporary=self._temporary)
        return self._trace

    def __enter__(self) -> Live:
        return self

    def __exit__(self, *error: object) -> None:
        self.stop()


def live(scene: Scene, *, hand: str | PathLike | None = None, device: str | Pointer | None = None, rate_hz: float = 1000.0,
         duration_s: float | None = None, out: str | PathLike | None = None, hold: str | None = None,
         fit: bool | None = None) -> Live:
    """Feels a scene in real time and records it: a Live, at once.

    device: of a person's hand, as `palpa devices` calls it, or a palpa.Pointer, the mouse of a window; or hand: a simulated or recorded one, as of palpa.run, which holds
    `device`. rate_hz: [Hz] 100 to 20000. duration_s: [s] None: until it is stopped; of a simulated hand 10 s.
    Raises SceneError for a scene with modes in Python: they cannot keep time.
    """
    folder, temporary = _new_folder(out)
    pointer, device = (device, None) if isinstance(device, Pointer) else (None, device)
    if pointer is not None and hand is not None:
        raise TypeError("'hand' and a palpa.Pointer are two hands; name one")
    given = dict(hand=None if hand is None else str(hand), device=device, rate_hz=rate_hz, duration_s=duration_s, out=folder,
                 hold=hold, fit=fit, plugins=list(plugins))
    return Live(_palpa.live(scene, given, pointer), folder, temporary)
