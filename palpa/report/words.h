// Summary sentences of a trace.
#pragma once

#include <string>
#include <vector>

#include "palpa/report/recorded.h"
#include "palpa/scene/scene.h"

namespace palpa::detail {

/// Sentences without markup, most important first. Each number has its unit.
std::vector<std::string> format_recorded(const Recorded& recorded);

/// Line under the title: duration, hand, version of palpa.
std::string subtitle_of(const Recorded& recorded);

/// For a trace with hardly any contact: that fact, the run's warnings, and, with the scene, positions with contact. Empty:
/// enough contact.
/// \param scene  nullptr: no data
std::string explain_little_contact(const Recorded& recorded, const Scene* scene);

/// Reason of an event, with unit: "the force fell by 0.20 N"; empty for onsets and break-throughs, which a level explains.
std::string why_of(const RecordedEvent& event);

/// True for a run in real time: on a simulated clock no tick is late.
bool was_in_real_time(const Recorded& recorded);

/// "skin of surface" for the level of an onset or break-through; its value if unnamed.
std::string level_of(const Recorded& recorded, const RecordedEvent& event);

}  // namespace palpa::detail
