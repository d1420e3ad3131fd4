// What was felt, in sentences made from the numbers.
#pragma once

#include <string>
#include <vector>

#include "palpa/report/recorded.h"
#include "palpa/scene/scene.h"

namespace palpa::detail {

/// Sentences without markup, most important first. Each number has its unit.
std::vector<std::string> words_of(const Recorded& recorded);

/// Who recorded what, how long: the line under the title.
std::string subtitle_of(const Recorded& recorded);

/// For a trace in which hardly a mode pushed: that, what the run had to say of it, and, with the scene, where something could
/// have been felt. Empty: enough was felt.
/// \param scene  nullptr: its data are not there
std::string why_little_is_felt(const Recorded& recorded, const Scene* scene);

/// Why an event happened, with its unit: "the force fell by 0.20 N"; empty for onsets and break-throughs, which a level
/// explains.
std::string why_of(const RecordedEvent& event);

/// Whether the run was felt in real time: on a simulated clock no tick begins late.
bool was_in_real_time(const Recorded& recorded);

/// "skin of surface" for the level that an onset or a break-through is about; its value where it has no name.
std::string level_of(const Recorded& recorded, const RecordedEvent& event);

}  // namespace palpa::detail
