// Sentences on the difference of two runs of one hand, for reports and windows.
#pragma once

#include <string>
#include <vector>

#include "palpa/study/beside.h"

namespace palpa::detail {

/// "1.20 N"; three digits below 0.1 N. Allocates; any thread.
std::string newtons(double force_n);
/// "0.412 s". Allocates; any thread.
std::string seconds(double time_s);
/// Position in the hand frame [m] as millimetres right, up and towards the user: "+1.0, -2.0, +0.0 mm". Allocates; any thread.
std::string place_words(const Vec3& hand_m);

/// One sentence each: verdict whether a hand would tell the runs apart; largest difference, time and place; root mean square.
/// Allocates; any thread. \param difference  of these runs, by `compare_felt`
std::vector<std::string> difference_sentences(const FeltRun& first, const FeltRun& second, const FeltDifference& difference);

}  // namespace palpa::detail
