// What the trials of a check are graded by.
#pragma once

#include <cstddef>
#include <vector>

#include "palpa/study/check.h"

namespace palpa::detail {

/// A trial that was made.
struct TrialMade {
  std::size_t place = 0;  ///< [1] index of its place in the report
  Trial trial;
  TrialFigures figures;
};

/// Fills `findings`, `grade` and `verdict` of a report, whose plant, coupling, places and stable stiffness are known.
/// \param all  empty: nothing is felt. Allocates; any thread.
void judge(const Scene& scene, const std::vector<TrialMade>& all, CheckReport& report);

}  // namespace palpa::detail
