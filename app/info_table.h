// Facts of a data file as `palpa info` prints them: as words for people, as JSON for programs.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/info_facts.h"
#include "app/info_place.h"

namespace palpa::app {

struct InfoTable {
  std::string words;
  /// The keys will not change, and have their units (docs/start.md). Numbers that are not finite are null.
  nlohmann::ordered_json json;
};

/// \param places  to sample; vectors are along the world's axes
/// \param level   of scalar fields, in the unit of each: adds losses of the smooth filter there, and motion of the level from
///                frame to frame
InfoTable info_table(const Facts& facts, const std::vector<AskedPlace>& places, const std::optional<double>& level);

}  // namespace palpa::app
