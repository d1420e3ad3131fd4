// Families of a tool's balance problems: identical on every machine.
#pragma once

#include <span>
#include <vector>

#include "palpa/solver/pose_solver.h"
#include "tests/solver/random_problems.h"

namespace palpa::test {

struct PoseProblem {
  std::vector<Primitive> primitives;  ///< with their feet, in the order of the feet
  std::vector<Vec3> levers_m;         ///< by foot
  Pose start, probe;
  double stiffness_n_per_m = 800.0;
  double turning_radius_m = 0.03;
  double time_step_s = 1e-3;

  ToolStep step() const { return {start, probe, levers_m, stiffness_n_per_m, turning_radius_m, time_step_s}; }
};

/// Fills `set` with the problem's primitives, each of its foot.
void fill(PrimitiveSet& set, const PoseProblem& problem);

struct PoseSolved {
  Balance balance;
  std::vector<Vec3> forces_n;
};
/// The balance by `solver`, with `set` as room for the primitives.
PoseSolved solved(const PoseProblem& problem, PoseSolver& solver, PrimitiveSet& set);
/// The balance from a cold start.
PoseSolved solved(const PoseProblem& problem);

Turn random_turn(Random& random, double most_rad);

/// Generator of problems of tools with 1 to 256 feet. k is 300 to 3000 N/m unless said otherwise, strengths are up to 5 N
/// divided by the feet, the probe is some millimetres and up to 0.3 rad from the start.
///   pad               feet of a plane, on a plane or up to half a millimetre off it
///   pad_friction      likewise, each foot with a line across
///   groove            each foot at one of two planes
///   peg               feet along an axis, between opposed planes of a hole
///   bumps             a plane at each foot, normals about an axis
///   rails             lines
///   drags             points, lines and planes at the feet, with drags
///   corners           a corner of two to four facets at each foot
///   elastic           planes as stiff as the coupling, some far from that
///   directed          a directed force at each foot, and a plane
///   points            points at or near the feet
///   nearly_parallel   planes of both senses, 1e-9 to 1e-2 rad apart
///   jammed            likewise, 1e-9 to 1e-6 or 1e-3 to 1 rad apart, with lines
///   coincident        feet at two places, points and planes
///   mixed             primitives of all kinds, also turns of up to 2.8 rad, k of 1 to 1e6 N/m, feet at the centre
///   spread            a problem of problem_families.h, its primitives shared out to the feet
struct PoseFamily {
  const char* name;
  PoseProblem (*make)(Random& random, int feet);
  bool is_extreme = false;  ///< strengths, stiffnesses or places without bound: rounding alone may keep a bound above 1e-9 m
};

std::span<const PoseFamily> pose_families();

}  // namespace palpa::test
