// Tables of a report.
#pragma once

#include <string>

#include "palpa/report/path_names.h"
#include "palpa/report/recorded.h"

namespace palpa::detail {

std::string summary_markup(const Recorded& recorded);
/// Energy balance of the hand's motion.
std::string energy_markup(const Recorded& recorded);
std::string modes_markup(const Recorded& recorded);
/// Each event links to its moment in the view (report.js).
std::string events_markup(const Recorded& recorded, const PathNames& names);
/// Origin of the trace, and checksums of its data.
std::string origin_markup(const Recorded& recorded, const PathNames& names);

}  // namespace palpa::detail
