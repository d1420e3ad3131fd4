// What the tests ask of the stand-in for Force Dimension's library: in the vendor's axes and units.
#pragma once

namespace palpa::test {

/// What a stand-in in another process shows: a file of this, which $PALPA_TESTS_DHD_SEEN names there, stays when that process
/// ends, however it does. Of the first device.
struct DhdSeen {
  double place_m[3];      ///< of the handle; written by the test
  double last_word_n[3];  ///< the force that was asked for last
};

/// One function of this name, `dhd_stand_in`, is exported by the stand-in besides the vendor's.
struct DhdStandIn {
  static constexpr int devices = 2;
  enum class What {
    there,        ///< plugged in
    power,        ///< its supply is on
    initialized,  ///< it knows its place
    off_button,   ///< 1: the button on its base was pressed to switch the force off; 0: pressed again
    speed_brake,  ///< 1: its speed was too high: it holds by its brakes and makes no force until it is enabled again
    freezes,      ///< calls of the exchange return after 100 ms
    lies,         ///< its positions are not numbers
    refuses,      ///< it takes no force
    buttons,      ///< mask
  };
  void (*reset)(int device);
  void (*hold)(int device, const double place_m[3], const double speed_m_per_s[3]);
  void (*force_n)(int device, double force_n[3]);  ///< that the motors make now
  void (*set)(int device, What what, int value);
  bool (*brakes)(int device);
  /// Whether anything was said to its motors since the last `reset`, or, where the library opens by number, it was opened.
  bool (*is_touched)(int device);
};

}  // namespace palpa::test
