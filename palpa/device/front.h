// Front of a simulated hand's object: the surface around the point of contact.
#pragma once

#include <memory>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa {

/// Surface that a hand follows at any depth. Immutable; sampling allocates nothing.
class Front {
 public:
  virtual ~Front() = default;
  /// Hand position [m] at two coordinates of the front, `depth_m` behind it. Smooth in all three arguments, finite for finite
  /// ones. Any thread.
  /// \param u        [1] or [m], by the front
  /// \param v        [m]
  /// \param depth_m  [m] negative: before the front
  virtual Vec3 at(double u, double v, double depth_m) const noexcept = 0;
};

/// Heights on a lattice, smoothed by a uniform cubic B-spline: two continuous derivatives, never above the highest or below the
/// lowest. Flat beyond the lattice.
class Relief {
 public:
  /// \param heights  [m] `columns` values for each of `rows` rows, u the faster
  /// \param u_turns  the columns are a ring: the first follows the last
  Relief(std::vector<double> heights, int columns, int rows, bool u_turns);
  /// Height [m] at a lattice position.
  /// \param column  [1] 0: the first
  /// \param row     [1] 0: the first
  double at(double column, double row) const noexcept;

 private:
  std::vector<double> heights_;
  int columns_, rows_;
  bool u_turns_;
};

/// Relief of z [m] that faces the user: u and v are x and y [m] relative to `place_m`, whose z is ignored.
/// \param column     [1] of `place_m` in the relief
/// \param row        [1] of `place_m` in the relief
/// \param spacing_m  [m] between columns, and between rows
std::shared_ptr<const Front> relief_facing(const Vec3& place_m, Relief relief, double column, double row, double spacing_m);
/// `cylinder_around` with a relief of the radius [m] instead of a constant: columns are `turns_per_column` [1] apart, rows
/// `spacing_m` [m], and `row` [1] is at the height of the centre.
std::shared_ptr<const Front> relief_around(const Vec3& centre_m, Relief relief, double turns_per_column, double row,
                                           double spacing_m);

}  // namespace palpa
