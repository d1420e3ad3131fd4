// The tables of a report.
#pragma once

#include <string>

#include "palpa/report/path_names.h"
#include "palpa/report/recorded.h"

namespace palpa::detail {

std::string summary_markup(const Recorded& recorded);
/// Where the energy of the hand's motion went.
std::string energy_markup(const Recorded& recorded);
std::string modes_markup(const Recorded& recorded);
/// Each event is a link to its moment in the view, which report.js follows.
std::string events_markup(const Recorded& recorded, const PathNames& names);
/// How the trace came about, and the checksums of its data.
std::string origin_markup(const Recorded& recorded, const PathNames& names);

}  // namespace palpa::detail
