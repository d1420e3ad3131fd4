// How parts of a scene are written: from the lists that they are read by.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "palpa/data/volume.h"
#include "palpa/solver/similarity.h"

namespace palpa::detail {

/// One key of a scene file with its value, as TOML.
struct Said {
  std::string key;
  std::string value;
  friend bool operator==(const Said&, const Said&) = default;
};

/// What [volume.NAME] says for a request: `file` first, with whole paths, so that it holds in any folder; then what is not
/// as it is without being said. Allocates.
std::vector<Said> said(const VolumeRequest& request);

/// The value of a key among them; empty if it is not there.
std::string value_of(const std::vector<Said>& said, std::string_view key);

}  // namespace palpa::detail
