// Backend: the interface of a device driver's shared object to the program.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "palpa/device/device.h"

namespace palpa {

/// Settings after the name in `--device NAME[,KEY=VALUE…]`, in order.
using DeviceSettings = std::vector<std::pair<std::string, std::string>>;

struct FoundDevice {
  std::string description;  ///< its `--device` argument, as `inverse3,id=049D`
  std::string words;        ///< text for a person
};

struct DeviceSearch {
  std::vector<FoundDevice> found;
  std::vector<std::string> missing;  ///< sentences: missing parts, and how to get them
};

struct DeviceSetting {
  const char* key;
  const char* meaning;  ///< with its unit and default
};

/// Kind of device. Its shared object, `palpa-device-NAME.so`, exports it as `palpa_device_backend`, a constant of C linkage.
/// Both functions may take seconds, allocate and throw LoadError, and are called by one thread at a time. `open_device` calls
/// `open` with signals blocked, so that no driver thread receives one.
///
/// tests/devices/conformance_test.cpp tests every kind against the contract of Device: a rig for it is one class (rig.h).
struct DeviceBackend {
  const char* palpa_version;  ///< `palpa::version`: on a mismatch no other member is read
  const char* name;           ///< in `--device NAME`: lower case
  const char* title;
  const char* axes;  ///< directions of its own axes, in words
  std::vector<DeviceSetting> (*settings)();
  DeviceSearch (*search)(const DeviceSettings& settings);
  /// Blocks for at most a few seconds for the first position. The device never moves by itself. The result is bound to the
  /// opened device, and touches no other, even with the setting "the first". Throws LoadError: device, fault, remedy.
  std::unique_ptr<Device> (*open)(const DeviceSettings& settings);
};

}  // namespace palpa
