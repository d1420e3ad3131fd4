// Test interface of the stand-in for 3D Systems' library: millimetres and newtons, in the vendor's axes.
#pragma once

namespace palpa::test {

/// The stand-in exports a constant of this name, `hd_stand_in`, besides the vendor's functions.
struct HdStandIn {
  static constexpr int devices = 2;  ///< "first" and "second"; the default device is the first connected
  enum class What {
    there,
    calibrated,  ///< else it needs its inkwell
    error,       ///< a code that each frame reports; 0: none
    warm,        ///< temperature of its motors in hundredths
    stalls,      ///< the library's thread has no frames
    buttons,
    freedoms,  ///< of its encoders: 6, or 3 without a gimbal
  };
  void (*reset)(int device);
  void (*hold)(int device, const double place_mm[3], const double speed_mm_per_s[3]);
  void (*turn)(int device, const double transform[16]);  ///< by columns; of its rotation
  void (*force_n)(int device, double force_n[3]);
  void (*set)(int device, What what, int value);
  bool (*is_touched)(int device);  ///< its motors got a command since the last `reset`
};

}  // namespace palpa::test
