// Hands without a device: simulated ones and recorded ones.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "palpa/device/device.h"

namespace palpa {

/// The mechanics of a hand that holds a device: one mass on a spring and a damper to where the hand
/// wants to be, pushed by the force that the device renders.
struct Arm {
  double mass_kg = 0.5;                 ///< hand and device
  double damping_ns_per_m = 6.0;
  double stiffness_n_per_m = 135.0;     ///< relaxed; 500: firm
};

/// What a device adds to the arm: presets by name, or none.
struct DevicePlant {
  std::string name;                     ///< "touch", "omega", "falcon", "inverse3"; empty: an ideal device
  double mass_kg = 0.0;
  double damping_ns_per_m = 0.0;        ///< physical
  double coulomb_friction_n = 0.0;
  double encoder_step_m = 0.0;
  int delay_ticks = 0;                  ///< of the force
  DeviceLimits limits;
};
/// A preset; throws LoadError that lists the names.
DevicePlant device_plant(const std::string& name);

/// Where a hand wants to be at a time.
class Target {
 public:
  virtual ~Target() = default;
  struct Point {
    Vec3 position_m;
    bool valid = true;
    std::uint32_t buttons = 0;
  };
  virtual Point at(double time_s) const noexcept = 0;
  virtual double duration_s() const noexcept = 0;
};

/// A simulated hand's path, `sim:press|stroke|circle|helix|random[,KEY=VALUE…]` (formats.md §2); throws
/// LoadError that says what would be right. Same text, same path, on every machine.
std::unique_ptr<Target> simulated_target(const std::string& description);

/// How a recording is held.
enum class Hold { rigid, relaxed, firm };

struct RecordingOptions {
  double hand_rate_hz = 0.0;              ///< of a file without time; 0: not given
  std::optional<bool> center;             ///< none: by the file's kind
};

/// A recorded hand (formats.md §2). Gaps up to 100 ms are filled by a monotone cubic; in longer ones
/// the probe is not valid. Throws LoadError.
std::unique_ptr<Target> recorded_target(const std::filesystem::path& file, const RecordingOptions& options = {});

/// A hand that follows `target`: rigidly (no force moves it), or with an arm that a force can hold.
std::unique_ptr<SimulatedDevice> hand_device(std::unique_ptr<Target> target, Hold hold, const DevicePlant& plant = {});

/// The hand that `--hand` names, as a device: `sim:…` or a file.
std::unique_ptr<SimulatedDevice> open_hand(const std::string& description, std::optional<Hold> hold,
                                           const RecordingOptions& options = {}, const DevicePlant& plant = {});

}  // namespace palpa
