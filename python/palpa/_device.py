"""Haptic devices driven by Python, behind the guard."""

from __future__ import annotations

from typing import Any

from . import _palpa


class Device:
    """A haptic device driven by Python: palpa.live(scene, device=MyDevice()).

        class Serial(palpa.Device):
            limits = palpa.DeviceLimits(max_force_n=5, encoder_step_m=2e-5)

            def read(self):                  # hand frame: x right, y up, z towards the user
                return palpa.DeviceState(self.port.position_m(), buttons=self.port.buttons())

            def write(self, force_n):        # an array of 3 numbers [N]; held on the hand until the next one
                self.port.send(force_n)

    A device that senses its handle's orientation gives DeviceState a `turn`. One that drives torque has max_torque_nm in its
    limits, and `write(self, force_n, torque_nm)`.

    The device's own thread calls `read` and `write` alternately, up to a thousand times a second; each must return within 20
    ms. `write` receives a force limited by the guard (docs/safety.md). If either raises, or does not return for 50 ms, the
    device has a fault: zero is written as soon as possible, only zero until a whole exchange has succeeded, and then the force
    returns by the guard's gate and ramp. While a call hangs nothing can be written; `release` may remove the force in another
    way, and a device should remove it by itself when no force arrives.
    """

    limits: _palpa.DeviceLimits

    def __repr__(self):
        return f"{type(self).__name__}(limits={getattr(self, 'limits', None)!r})"

    def read(self) -> Any:
        """Returns the hand's position: a palpa.DeviceState, three numbers [m], or None if it is unknown."""
        raise NotImplementedError(f"{type(self).__name__} has no method 'read(self)'")

    def write(self, force_n: Any) -> None:
        """Applies a force [N], shape (3,), to the hand until the next call."""
        raise NotImplementedError(f"{type(self).__name__} has no method 'write(self, force_n)'")

    def release(self) -> None:
        """Removes the force without `read` and `write`, one of which hangs: called once by another thread after the 50 ms.
        It must not block on anything that they hold: it interrupts their call, closes the port or opens a relay, for example.
        Default: does nothing."""

    def close(self) -> None:
        """Called once at the end, after zero force was written."""
