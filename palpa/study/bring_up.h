// What a device is like, measured with a person's help: `palpa devices NAME --setup`.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "palpa/device/device.h"
#include "palpa/loop/loop.h"

namespace palpa {

/// What was measured. What is none could not be.
struct DeviceCalibration {
  bool knows_its_place = false;
  bool pushes_rightly = false;           ///< along each axis, to the side that was asked for
  std::optional<double> encoder_step_m;  ///< smallest steps of its positions while it was moved slowly
  std::optional<double> velocity_lag_s;  ///< by which its velocity is behind its positions
  std::optional<double> delay_s;         ///< from a force that is written to a motion that is read
  std::optional<double> mass_kg;         ///< these three from a swing on a spring, with no hand on the handle
  std::optional<double> damping_ns_per_m;
  std::optional<double> friction_n;   ///< of Coulomb's kind
  std::vector<std::string> findings;  ///< sentences, in the order of the steps
};

/// Says a sentence to the person and waits until it is done; false: this step is to be left out.
using AskPerson = std::function<bool(const std::string&)>;

/// Measures a device that is open. No force is longer than 1 N or than a third of the device's, and none stays when it returns.
/// It takes about half a minute besides what the person takes. Allocates; one thread, that of the device.
/// \param clock  by which it reads and writes once a millisecond
/// \param stop   ends it after the millisecond under way
/// Pulses and their delay: the parabola of a mass under a constant force. Swing: least squares of the balance of energy
/// m Δ(v²)/2 + b ∫v² dt + f ∫|v| dt = ∫F·v dt over pieces of it.
DeviceCalibration bring_up(Device& device, LoopClock& clock, const AskPerson& ask, const std::atomic<bool>& stop);

/// The clock of the wall, for `bring_up`.
std::unique_ptr<LoopClock> wall_clock();

}  // namespace palpa
