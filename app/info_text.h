// What `palpa info` prints: for people, and for programs.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "app/info_facts.h"
#include "app/info_place.h"

namespace palpa::app {

/// The field's value at a world position [m], null outside its data. Vectors are along the world's axes.
nlohmann::ordered_json value_at(const Field& field, const Vec3& at_m);

/// For programs: the keys will not change, and say their units (docs/start.md). Numbers that are not finite are null.
/// \param places  to sample
/// \param level   of scalar fields, in each one's own unit: adds what the smooth filter loses there, and how far the level
/// moves
///                from frame to frame
nlohmann::ordered_json as_json(const Facts& facts, const std::vector<AskedPlace>& places, const std::optional<double>& level);

/// The same for people, to stdout.
void print_words(const Facts& facts, const std::vector<AskedPlace>& places, const std::optional<double>& level);

}  // namespace palpa::app
