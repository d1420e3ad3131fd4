// Values of `--hand` in words, for the help, the man page and the completion.
#pragma once

#include <string>

namespace palpa::app {

struct Described {
  const char* name;
  const char* sentence;
};

inline constexpr Described simulated_hands[] = {
    {"sim:press", "presses in and out, periodically"},
    {"sim:stroke", "strokes over the surface to both sides, and slowly up and down"},
    {"sim:circle", "goes round in a circle on the surface"},
    {"sim:helix", "circles the whole object, slowly up and down"},
    {"sim:random", "moves at random beside and behind the surface, now and then out of it"},
};

inline constexpr Described simulated_hand_keys[] = {
    {"speed_m_per_s", "speed of the motion, up to 2 (0.1, at most one round a second)"},
    {"radius_m", "radius of the motion about the first contact, up to 0.2 (0.03, if there is room)"},
    {"depth_m", "target depth behind the surface, up to 0.15 (half of the depth at which the levels there break)"},
    {"tilt_rad", "the handle swings by this about x and z, up to 3, for a scene with a tool (0)"},
    {"seed", "a whole number, for sim:random (1)"},
};

inline constexpr Described recorded_hands[] = {
    {"t_s,x_m,y_m,z_m[,buttons]", "seconds and metres: x to the right, y up, z towards the user"},
    {"...,turn_w,turn_x,turn_y,turn_z", "beside any of these: the handle's orientation, a unit quaternion"},
    {"ticks.csv of a trace", "the recorded hand, at its recorded position"},
    {"Time,Cursor Position X,...", "logs of Haply's Inverse3"},
    {"x,y,z,...", "without time: --hand-rate-hz gives the rows per second"},
};

inline constexpr Described device_keys[] = {
    {"encoder_step_m", "step in which positions are read"},
    {"max_force_n", "largest force"},
    {"max_torque_nm", "largest torque, with a tool; 0: it drives none"},
    {"delay_ticks", "ticks between a force's writing and its acting, up to 64"},
    {"mass_kg", "mass that the hand moves along"},
    {"damping_ns_per_m", "damping of its mechanics"},
    {"coulomb_friction_n", "friction of its mechanics"},
    {"max_stiffness_n_per_m", "maximum stiffness that it is made for; a scene with more causes a warning"},
    {"workspace_radius_m", "radius of its workspace"},
};

std::string hand_words();

}  // namespace palpa::app
