// What was felt, in sentences made from the numbers.
#pragma once

#include <string>
#include <vector>

#include "palpa/report/recorded.h"

namespace palpa::detail {

/// Sentences without markup, most important first. Each number has its unit.
std::vector<std::string> words_of(const Recorded& recorded);

/// "skin of surface" for the level that an onset or a break-through is about; its value where it has no name.
std::string level_of(const Recorded& recorded, const RecordedEvent& event);

}  // namespace palpa::detail
