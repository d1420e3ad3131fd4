"""The same library through ctypes, without the package palpa: feel.py [libpalpa.so.0.1]"""
import ctypes
import sys
from ctypes import POINTER, byref, c_char_p, c_double, c_int32, c_uint32, c_void_p, sizeof


class Probe(ctypes.Structure):
    _fields_ = [("size", c_uint32), ("buttons", c_uint32), ("valid", c_int32), ("has_velocity", c_int32),
                ("position_m", c_double * 3), ("velocity_m_per_s", c_double * 3), ("turn", c_double * 4)]


class Tick(ctypes.Structure):  # all fields of palpa_tick, in its order
    _fields_ = [("size", c_uint32), ("status", c_int32)] + [(name, c_double * 3) for name in (
        "force_n", "proxy_m", "proxy_velocity_m_per_s", "probe_m", "probe_velocity_m_per_s", "probe_step_m")] + [
        (name, c_double) for name in ("error_bound_m", "given_back_n", "unborne_n", "felt_octave")] + [
        (name, c_int32) for name in ("probe_valid", "forced_octave", "sub_steps", "iterations", "dropped", "work")] + [
        (name, c_double) for name in ("stored_j", "elastic_j", "dissipated_j", "injected_j", "path_and_release_j", "damper_j",
                                      "data_motion_j", "released_j", "sampling_j", "sampling_bound_j")] + [
        ("torque_nm", c_double * 3), ("probe_turn", c_double * 4), ("proxy_turn", c_double * 4),
        ("probe_turn_step_rad", c_double * 3)]


palpa = ctypes.CDLL(sys.argv[1] if len(sys.argv) > 1 else "libpalpa.so.0.1")
for name, result, arguments in [
        ("palpa_last_error", c_char_p, []), ("palpa_scene_parse", c_void_p, [c_char_p, c_char_p]),
        ("palpa_scene_free", None, [c_void_p]), ("palpa_session_new", c_void_p, [c_void_p, c_double]),
        ("palpa_session_free", None, [c_void_p]),
        ("palpa_session_tick", c_int32, [c_void_p, POINTER(Probe), c_double, POINTER(Tick)])]:
    getattr(palpa, name).restype, getattr(palpa, name).argtypes = result, arguments


def checked(value):
    if not value:
        sys.exit("feel: " + palpa.palpa_last_error().decode())
    return value


scene = checked(palpa.palpa_scene_parse(b"""palpa = 1
coupling = {stiffness_n_per_m = 400}
volume.head = {analytic = "head_phantom"}
[[mode]]
name = "skin"
type = "surface_and_friction"
field = "head"
level = [{name = "skin", value = -300, strength_n = 0.8, friction_n = 0.1}]
""", None))
session = checked(palpa.palpa_session_new(scene, 0.0))
palpa.palpa_scene_free(scene)
hand, tick = Probe(size=sizeof(Probe), valid=1, turn=(1, 0, 0, 0)), Tick(size=sizeof(Tick))
for n in range(41):  # a hand presses, 1 ms a tick
    hand.position_m = (0, 0.02, 0.05 - 1e-4 * n)
    checked(palpa.palpa_session_tick(session, byref(hand), 1e-3, byref(tick)) == 0)
palpa.palpa_session_free(session)
force_n = sum(f * f for f in tick.force_n) ** 0.5
print(f"force {force_n:.3f} N")
sys.exit(0 if force_n > 0.1 else 1)
