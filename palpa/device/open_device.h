// Real devices by name, and what a user's devices.toml says of them.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "palpa/device/backend.h"

namespace palpa {

/// A description `NAME[,KEY=VALUE…]`, read.
struct DeviceDescription {
  std::string name;
  DeviceSettings settings;
};
/// Throws LoadError that says what would be right.
DeviceDescription device_description(const std::string& text);

/// The kinds of devices that this installation can drive, each loaded from its shared object; they stay loaded. In the order of
/// their names. Throws LoadError on one that is not of this version.
std::vector<const DeviceBackend*> device_backends();
/// One of them. Throws LoadError that says which there are.
const DeviceBackend& device_backend(const std::string& name);

/// What a user says of a kind of device, and what `palpa devices --setup` measured: one table of devices.toml.
struct DeviceNotes {
  std::optional<double> max_force_n;  ///< these four may only be lower than the device's own
  std::optional<double> continuous_force_n;
  std::optional<double> max_stiffness_n_per_m;
  std::optional<double> max_damping_ns_per_m;
  std::optional<double> encoder_step_m;    ///< measured
  std::optional<double> damping_ns_per_m;  ///< measured
  friend bool operator==(const DeviceNotes&, const DeviceNotes&) = default;
};
/// The user's file: $PALPA_DEVICES, else palpa/devices.toml in $XDG_CONFIG_HOME or ~/.config.
std::filesystem::path device_notes_file();
/// What the file says of a kind of device; nothing where there is no such file. Throws LoadError with file and line.
DeviceNotes device_notes(const std::filesystem::path& file, const std::string& name);
/// Writes what was measured of a kind of device into the file, which is made where it is not there; all else in it stays, but
/// comments. Throws LoadError.
void keep_device_notes(const std::filesystem::path& file, const std::string& name, const DeviceNotes& notes);
/// A device's limits with the notes. Throws LoadError where these would raise a limit; `place` names them.
DeviceLimits with_notes(const DeviceLimits& limits, const DeviceNotes& notes, const std::string& place);

/// Opens a device and holds it to what the user's file says. Throws LoadError.
std::unique_ptr<Device> open_device(const DeviceDescription& description,
                                    const std::filesystem::path& notes_file = device_notes_file());

}  // namespace palpa
