// Measures of walls stronger and weaker than a stroke.
#pragma once

#include "palpa/session/session.h"
#include "tests/path/shapes.h"

namespace palpa::test {

enum class WallKind { plate_formula, shell_formula, trilinear, smooth, trilinear_binary, smooth_binary };
const char* name_of(WallKind kind) noexcept;
inline std::ostream& operator<<(std::ostream& out, WallKind kind) { return out << name_of(kind); }

/// Random straight strokes through walls of 0.3 to 8 voxels, at any angle, with 0.1 to 10 m/s. Voxels are 1 mm.
struct WallCase {
  WallKind kind = WallKind::trilinear;
  int strokes = 200;
  std::uint64_t seed = 1;
};

/// Walls stronger than k × the whole stroke.
struct Held {
  int strokes = 0;
  int passed = 0;         ///< the proxy crossed the middle of the wall where the interpolant is solid: 0.05 voxel deep, or more
  int past_rims = 0;      ///< … where it is less deep than that: the rim of a hole, met with straight steps
  int through_holes = 0;  ///< … where the interpolant has a hole
  double excess_p99_voxels = 0.0;  ///< deepest point of each stroke's path in the solid, in depth of the interpolant
  double excess_max_voxels = 0.0;
  int never_felt = 0;     ///< no onset, though the path to the far side leads through the solid
  int unfinished = 0;     ///< still pending 1000 ticks after the stroke
  int first_passed = -1;  ///< number of the stroke, to reproduce it
};
Held measure_held_walls(const WallCase& wanted);

struct WeakWallCounts {
  int strokes = 0;
  int break_throughs = 0;
  int without_onset = 0;
  int missing = 0;  ///< through the solid without a break-through in the trace
};
WeakWallCounts measure_weak_walls(const WallCase& wanted);

/// A ball from a formula, pressed through at any angle and 0.1 to 10 m/s.
struct BreakThrough {
  int strokes = 0;
  int break_throughs = 0;
  int without_onset = 0;
  double depth_error_max_m = 0.0;  ///< | |proxy − probe| at the strength − s/k |
};
BreakThrough measure_break_through(int strokes);

/// Fast strokes (1 to 10 m/s) into a solid of a real volume from outside it.
struct SkullCase {
  double level = 300.0;        ///< in the field's own unit
  double least_slope = 200.0;  ///< [unit per voxel] the slope of depth where the data are flatter than an edge of bone
  int strokes = 100;
  std::uint64_t seed = 1;
};
struct Skull {
  int strokes = 0;
  int passed = 0;  ///< in by one face, deeper than 0.1 voxel, and out by the opposite face
  int deep = 0;    ///< anywhere deeper in the solid than 0.1 voxel
  int never_felt = 0;
  double excess_p99_voxels = 0.0;  ///< deepest point of each stroke's path: (value − level) / (|gradient|·spacing)
  double excess_max_voxels = 0.0;
  int unfinished = 0;
  int first_passed = -1;
};
Skull measure_skull(const FieldPtr& field, const SkullCase& wanted);

}  // namespace palpa::test
