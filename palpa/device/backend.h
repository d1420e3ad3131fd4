// A kind of real device: what its shared object gives to the program that loads it.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "palpa/device/device.h"

namespace palpa {

/// What follows the name in `--device NAME[,KEY=VALUE…]`, in order.
using DeviceSettings = std::vector<std::pair<std::string, std::string>>;

/// A device that is there.
struct FoundDevice {
  std::string description;  ///< what `--device` takes for it, as `inverse3,id=049D`
  std::string words;        ///< what it is, for a person
};

/// What came of looking for devices of one kind.
struct DeviceSearch {
  std::vector<FoundDevice> found;
  std::vector<std::string> missing;  ///< sentences: what is not there, and how to get it
};

struct DeviceSetting {
  const char* key;
  const char* meaning;  ///< with its unit and what holds without it
};

/// One kind of device. Its shared object, `palpa-device-NAME.so`, exports it as `palpa_device_backend`, a constant of C
/// linkage. Both functions may take seconds, allocate and throw LoadError, and are for one thread at a time. `open_device`
/// calls `open` with signals blocked, so that no thread of the driver's takes one.
///
/// tests/devices/conformance_test.cpp holds every kind to the laws of Device: a rig for it is one class (rig.h).
struct DeviceBackend {
  const char* palpa_version;  ///< `palpa::version`: of another one, nothing else is looked at
  const char* name;           ///< in `--device NAME`: lower case
  const char* title;          ///< which devices these are
  const char* axes;           ///< which way its own axes point, in words
  std::vector<DeviceSetting> (*settings)();
  DeviceSearch (*search)(const DeviceSettings& settings);
  /// Waits at most a few seconds for its first position. The device never moves by itself. What comes of it stays with the
  /// device that was opened, and touches no other, also where the settings say "the first". Throws LoadError: which device,
  /// what is wrong, what would be right.
  std::unique_ptr<Device> (*open)(const DeviceSettings& settings);
};

}  // namespace palpa
