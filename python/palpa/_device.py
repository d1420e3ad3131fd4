"""A device of one's own, behind the guard."""

from __future__ import annotations

from typing import Any

from . import _palpa


class Device:
    """A haptic device that is driven by Python: palpa.live(scene, device=MyDevice()).

        class Serial(palpa.Device):
            limits = palpa.DeviceLimits(max_force_n=5, encoder_step_m=2e-5)

            def read(self):                  # hand frame: x right, y up, z towards the user
                return palpa.DeviceState(self.port.position_m(), buttons=self.port.buttons())

            def write(self, force_n):        # an array of 3 numbers [N]; held on the hand until the next one
                self.port.send(force_n)

    `read` and `write` are called by a thread of the device's own, one after the other, up to a thousand times a second, and
    return within 20 ms. What `write` is given has gone through the guard (docs/safety.md). Where one of them raises, or does not
    return for 50 ms, the device has a fault: zero is written as soon as it can be, nothing but zero until a whole exchange has
    gone well, and then the force comes back by the guard's gate and ramp. While a call does not return nothing can be written;
    `release` may let go another way, and a device should let go by itself when no force reaches it.
    """

    limits: _palpa.DeviceLimits

    def read(self) -> Any:
        """Where the hand is: a palpa.DeviceState, three numbers [m], or None where the position is not known."""
        raise NotImplementedError(f"{type(self).__name__} has no method 'read(self)'")

    def write(self, force_n: Any) -> None:
        """Holds a force [N], shape (3,), on the hand until the next one."""
        raise NotImplementedError(f"{type(self).__name__} has no method 'write(self, force_n)'")

    def release(self) -> None:
        """Lets go without `read` and `write`, one of which does not return: called once by another thread when the 50 ms are over.
        It waits for nothing that they may hold: it interrupts their call, closes the port or opens a relay, say. It may do
        nothing, as this one."""

    def close(self) -> None:
        """Called once at the end, after zero was written."""
