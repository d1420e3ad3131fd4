"""A custom device behind the guard: a handle on a byte stream like a serial port, here with simulated firmware.

    PYTHONPATH=build/release/python python3 examples/08_python_device/device.py
"""

import socket
import struct
import threading
import time

import numpy as np

import palpa


class Firmware(threading.Thread):
    """Simulated device and hand: a motorised handle of 0.3 kg, which a hand lowers after two seconds to 6 mm behind the skin, by a
    spring of 100 N/m. Receives 'f' and three floats, the force, and answers with three floats, the position. Like every device
    should, it releases the handle 50 ms after the last force."""

    def __init__(self):
        super().__init__(daemon=True)
        self.port, self._inside = socket.socketpair()
        self.forces_n = []

    def run(self):
        z_m, speed_m_per_s, force_n = 0.055, 0.0, 0.0
        begin_s = last_s = time.monotonic()
        self._inside.settimeout(0.05)
        while True:
            try:
                message = self._inside.recv(13)
                if not message:
                    return
                force_n = struct.unpack("<c3f", message)[3]
                self.forces_n.append(force_n)
            except TimeoutError:
                force_n = 0.0
            now_s = time.monotonic()
            dt_s, last_s = min(now_s - last_s, 0.005), now_s
            wanted_m = max(0.0416, 0.055 - 0.01 * max(0.0, now_s - begin_s - 2.0))
            speed_m_per_s += dt_s * (force_n + 100 * (wanted_m - z_m) - 8 * speed_m_per_s) / 0.3
            z_m += dt_s * speed_m_per_s
            self._inside.send(struct.pack("<3f", 0.0, 0.02, z_m))


class Serial(palpa.Device):
    """The driver: what a program for a device of one's own has to write."""

    limits = palpa.DeviceLimits(max_force_n=2.0, max_stiffness_n_per_m=1000, encoder_step_m=2e-5)

    def __init__(self, port):
        self.port, self.position_m = port, None
        port.settimeout(0.02)  # a blocked call holds the last force: an exception is better, it counts as a fault

    def read(self):
        return self.position_m  # three numbers [m] in the hand frame; None: unknown

    def write(self, force_n):
        self.port.send(struct.pack("<c3f", b"f", *force_n))
        self.position_m = struct.unpack("<3f", self.port.recv(12))

    def close(self):
        self.port.close()


scene = palpa.Scene(stiffness_n_per_m=400)
head = scene.add("head", palpa.head_phantom())
scene.add("skin", palpa.SurfaceAndFriction(field=head, levels=[dict(value=-300, strength_n=0.8, friction_n=0.1)]))

firmware = Firmware()
firmware.start()
with palpa.live(scene, device=Serial(firmware.port), duration_s=5) as live:
    while live.is_running:
        time.sleep(0.5)
        seen = live.latest()
        print(f"{seen['t_s']:.1f} s: {seen['guard']}, {seen['command_n'][2]:.2f} N at {1e3 * seen['probe_m'][2]:.1f} mm")
with live.stop() as trace:
    command_n = trace.ticks["command_n"]
    print(f"the skin held the handle with {np.abs(command_n).max():.2f} N")
    assert np.linalg.norm(command_n, axis=1).max() <= 2.0
assert firmware.forces_n[-1] == 0.0, "the last word to a motor is zero"
