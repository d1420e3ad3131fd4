// The tests' reference of a tool's balance in floating point of 113 bits, with its own certificate.
#pragma once

#include <span>

#include "tests/solver/pose_problems.h"
#include "tests/solver/reference.h"

namespace palpa::test {

struct PoseReference {
  Quad way_m[3] = {};      ///< ξ
  Quad arc_m[3] = {};      ///< ρω
  Quad bound_m = 0;        ///< proven distance, in the metric, to the exact balance (without rounding at 113 bits)
  bool certified = false;  ///< bound_m <= 1e-14
  int iterations = 0;      ///< Newton steps at 113 bits
};

/// The minimiser of E of pose_solver.h for the problem as given by its doubles: directions q/|q| and the rotation vector
/// between the turns in 113 bits; a foot starts at its `foot_m`. Found as in reference.h. Allocates; any thread.
PoseReference reference_pose(const PoseProblem& problem);

/// Distance [m] in the metric of a balance's pose from the reference.
double error_m(const PoseReference& reference, const PoseProblem& problem, const Balance& balance);

/// Distance [m] of a foot's position from its place at the reference's balance, on its linear way.
double foot_error_m(const PoseReference& reference, const PoseProblem& problem, std::size_t foot, const Vec3& position_m);

}  // namespace palpa::test
