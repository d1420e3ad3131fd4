// The front of what a simulated hand feels: a surface at and around the place where the hand meets it.
#pragma once

#include <memory>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa {

/// A surface that a hand can follow at a depth of its choice. Immutable; sampling allocates nothing.
class Front {
 public:
  virtual ~Front() = default;
  /// The hand's place [m] at these two coordinates of the front, `depth_m` behind it. Smooth in all three arguments, finite for
  /// finite ones. Any thread.
  /// \param u        [1] or [m], as the front says
  /// \param v        [m]
  /// \param depth_m  [m] below zero: before the front
  virtual Vec3 at(double u, double v, double depth_m) const noexcept = 0;
};

/// Heights on a lattice, smoothed by a uniform cubic B-spline: two continuous derivatives, never above the highest or below the
/// lowest. Beyond the lattice the relief is flat.
class Relief {
 public:
  /// \param heights  [m] `columns` values for each of `rows` rows, u the faster
  /// \param u_turns  the columns are a ring: the first follows the last
  Relief(std::vector<double> heights, int columns, int rows, bool u_turns);
  /// The height [m] at a place of the lattice.
  /// \param column  [1] 0: the first
  /// \param row     [1] 0: the first
  double at(double column, double row) const noexcept;

 private:
  std::vector<double> heights_;
  int columns_, rows_;
  bool u_turns_;
};

/// A relief of z [m] that faces the user: u and v are x and y [m] beside `place_m`, whose z is not used.
/// \param column     [1] where `place_m` stands in the relief
/// \param row        [1] where `place_m` stands in the relief
/// \param spacing_m  [m] between columns, and between rows
std::shared_ptr<const Front> relief_facing(const Vec3& place_m, Relief relief, double column, double row, double spacing_m);
/// As `cylinder_around`, with a relief of the radius [m] instead of one radius: columns are `turns_per_column` [1] apart, rows
/// `spacing_m` [m], and `row` [1] lies at the height of the centre.
std::shared_ptr<const Front> relief_around(const Vec3& centre_m, Relief relief, double turns_per_column, double row,
                                           double spacing_m);

}  // namespace palpa
