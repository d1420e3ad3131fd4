// What was felt, in sentences made from the numbers.
#pragma once

#include <string>
#include <vector>

#include "palpa/report/recorded.h"

namespace palpa::detail {

/// Sentences without markup, most important first. Each number has its unit.
std::vector<std::string> words_of(const Recorded& recorded);

/// Who recorded what, how long: the line under the title.
std::string subtitle_of(const Recorded& recorded);

/// For a trace in which no mode pushed: that, and what the run had to say of it.
std::string nothing_felt(const Recorded& recorded);

/// "skin of surface" for the level that an onset or a break-through is about; its value where it has no name.
std::string level_of(const Recorded& recorded, const RecordedEvent& event);

}  // namespace palpa::detail
