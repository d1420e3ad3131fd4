// What two scenes say differently.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpa::detail {

/// A value that differs, under the path of its key as `--set` takes it; empty: the scene does not say it.
struct SceneDifference {
  std::string key;
  std::string first, second;
};

/// Compares two scenes as TOML; titles and text that is no TOML count as nothing. In the order of the keys. Allocates; any
/// thread.
std::vector<SceneDifference> scene_differences(std::string_view first, std::string_view second);

/// "law.method: exact / paper-2005"; "not said" for an empty value.
std::string words_of(const SceneDifference& difference);

}  // namespace palpa::detail
