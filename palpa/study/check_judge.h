// Grading of a check's trials.
#pragma once

#include <cstddef>
#include <vector>

#include "palpa/study/check.h"

namespace palpa::detail {

struct TrialMade {
  std::size_t place = 0;  ///< [1] index of its place in the report
  Trial trial;
  TrialFigures figures;
};

/// Computes `findings`, `grade` and `verdict` of a report with known plant, coupling, places and stable stiffness.
/// \param all  empty: no contact. Allocates; any thread.
void judge(const Scene& scene, const std::vector<TrialMade>& all, CheckReport& report);

}  // namespace palpa::detail
