// Comparison of two scenes.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpa::detail {

/// Differing value, with the path of its key as for `--set`; empty: missing.
struct SceneDifference {
  std::string key;
  std::string first, second;
};

/// Compares two scenes as TOML, in the order of keys; titles are ignored, and a text that is no TOML counts as empty.
/// Allocates; any thread.
std::vector<SceneDifference> scene_differences(std::string_view first, std::string_view second);

/// "law.method: exact / paper-2005"; "not said" for an empty value.
std::string format_difference(const SceneDifference& difference);

}  // namespace palpa::detail
