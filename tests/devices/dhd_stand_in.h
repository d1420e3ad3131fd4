// Test interface of the stand-in for Force Dimension's library, in the vendor's axes and units.
#pragma once

namespace palpa::test {

/// State of the first device of a stand-in in another process, in the file $PALPA_TESTS_DHD_SEEN, which outlives that process.
struct DhdSeen {
  double place_m[3];      ///< of the handle; written by the test
  double last_word_n[3];  ///< the last commanded force
};

/// The stand-in exports a function of this name, `dhd_stand_in`, besides the vendor's.
struct DhdStandIn {
  static constexpr int devices = 2;
  enum class What {
    there,
    power,        ///< its supply is on
    initialized,  ///< its position is initialised
    off_button,   ///< 1: the button on its base was pressed to switch the force off; 0: pressed again
    speed_brake,  ///< 1: its speed was too high: it brakes and makes no force until it is enabled again
    freezes,      ///< calls of the exchange return after 100 ms
    lies,         ///< its positions are not numbers
    refuses,
    buttons,
    wrist,       ///< 0: none, as an omega.3; 1: sensed, as an omega.6; 2: with motors, as a sigma.7. Before it is opened
    wrist_lies,  ///< its orientation is no rotation
  };
  void (*reset)(int device);
  void (*hold)(int device, const double place_m[3], const double speed_m_per_s[3]);
  void (*turn)(int device, const double rows[3][3]);  ///< orientation frame of the wrist
  void (*force_n)(int device, double force_n[3]);
  void (*torque_nm)(int device, double torque_nm[3]);
  void (*set)(int device, What what, int value);
  bool (*brakes)(int device);
  /// True if its motors got a command since the last `reset`, or it was opened in a library that opens by number.
  bool (*is_touched)(int device);
};

}  // namespace palpa::test
