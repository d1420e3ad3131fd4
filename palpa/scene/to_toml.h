// TOML output of a scene's parts, by the lists that they are read by.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "palpa/data/volume.h"
#include "palpa/solver/similarity.h"

namespace palpa::detail {

/// Key of a scene file with its value, as TOML.
struct Said {
  std::string key;
  std::string value;
  friend bool operator==(const Said&, const Said&) = default;
};

/// Keys of [volume.NAME] for a request: `file` first, with absolute paths, valid in any folder; then all values that differ
/// from their defaults. Allocates.
std::vector<Said> said(const VolumeRequest& request);

/// Value of a key; empty if missing.
std::string value_of(const std::vector<Said>& said, std::string_view key);

}  // namespace palpa::detail
