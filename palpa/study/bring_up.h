// Calibration of a device with a person's help: `palpa devices NAME --setup`.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "palpa/device/device.h"
#include "palpa/loop/loop.h"

namespace palpa {

/// Result of a calibration. None: not measurable.
struct DeviceCalibration {
  bool has_valid_position = false;
  bool pushes_rightly = false;           ///< along each axis, to the commanded side
  std::optional<double> encoder_step_m;  ///< smallest steps of its positions in slow motion
  std::optional<double> velocity_lag_s;  ///< of its velocity behind its positions
  std::optional<double> delay_s;         ///< from a written force to a measured motion
  std::optional<double> mass_kg;         ///< these three from a swing on a spring, without a hand on the handle
  std::optional<double> damping_ns_per_m;
  std::optional<double> friction_n;   ///< Coulomb's
  std::vector<std::string> findings;  ///< sentences, in the order of the steps
};

/// Shows a sentence to the person and blocks until it is done; false: skip this step.
using AskPerson = std::function<bool(const std::string&)>;

/// Calibrates an open device. No force is longer than 1 N or a third of the device's limit, and none remains at return. Takes
/// about half a minute besides the person's time. Allocates; one thread, that of the device.
/// \param clock  of reads and writes once a millisecond
/// \param stop   ends it after the current millisecond
/// Pulses and their delay: the parabola of a mass under a constant force. Swing: least squares of the balance of energy m
/// Δ(v²)/2 + b ∫v² dt + f ∫|v| dt = ∫F·v dt over pieces of it.
DeviceCalibration bring_up(Device& device, LoopClock& clock, const AskPerson& ask, const std::atomic<bool>& stop);

/// Real-time clock for `bring_up`.
std::unique_ptr<LoopClock> wall_clock();

}  // namespace palpa
