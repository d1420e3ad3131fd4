// Real devices by name, and the notes of a user's devices.toml.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "palpa/device/backend.h"

namespace palpa {

/// Parsed description `NAME[,KEY=VALUE…]`.
struct DeviceDescription {
  std::string name;
  DeviceSettings settings;
};
/// Throws LoadError with the remedy.
DeviceDescription device_description(const std::string& text);

/// Kinds of devices of this installation, each loaded from its shared object; they stay loaded. In the order of their names.
/// Throws LoadError on another version.
std::vector<const DeviceBackend*> device_backends();
/// Kind by name. Throws LoadError with the list of kinds.
const DeviceBackend& device_backend(const std::string& name);

/// User's notes on a kind of device, and the measurements of `palpa devices --setup`: a table of devices.toml.
struct DeviceNotes {
  std::optional<double> max_force_n;  ///< these seven may only lower the device's own
  std::optional<double> continuous_force_n;
  std::optional<double> max_stiffness_n_per_m;
  std::optional<double> max_damping_ns_per_m;
  std::optional<double> max_torque_nm;
  std::optional<double> max_turn_stiffness_nm_per_rad;
  std::optional<double> max_turn_damping_nms_per_rad;
  std::optional<double> encoder_step_m;    ///< measured
  std::optional<double> damping_ns_per_m;  ///< measured
  friend bool operator==(const DeviceNotes&, const DeviceNotes&) = default;
};
/// The user's file: $PALPA_DEVICES, else palpa/devices.toml in $XDG_CONFIG_HOME or ~/.config.
std::filesystem::path device_notes_file();
/// Notes on a kind of device in the file; none without the file. Throws LoadError with file and line.
DeviceNotes device_notes(const std::filesystem::path& file, const std::string& name);
/// Writes the measurements of a kind of device into the file, created if missing; keeps all else but comments. Throws
/// LoadError.
void keep_device_notes(const std::filesystem::path& file, const std::string& name, const DeviceNotes& notes);
/// Device limits with the notes. Throws LoadError if these would raise a limit; `place` names them.
DeviceLimits with_notes(const DeviceLimits& limits, const DeviceNotes& notes, const std::string& place);

/// Opens a device with the limits of the user's file. Throws LoadError.
std::unique_ptr<Device> open_device(const DeviceDescription& description,
                                    const std::filesystem::path& notes_file = device_notes_file());

}  // namespace palpa
