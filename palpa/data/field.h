// A field: scalar or vector data that can be sampled at a position of the world.
#pragma once

#include <memory>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa {

/// A scalar sample. Finite whatever the position; all zero where `inside` is false.
struct ScalarSample {
  double value = 0.0;   ///< the field's own unit
  Vec3 gradient;        ///< [unit/m]
  bool inside = false;  ///< the field has data here
};

/// A vector sample. Finite whatever the position; all zero where `inside` is false.
struct VectorSample {
  Vec3 value;     ///< the field's own unit
  Mat3 jacobian;  ///< [unit/m] row = component, column = axis of position
  bool inside = false;
};

/// An axis-aligned box of the world.
struct Box {
  Vec3 low_m;
  Vec3 high_m;
  Vec3 centre_m() const noexcept { return 0.5 * (low_m + high_m); }
  Vec3 size_m() const noexcept { return high_m - low_m; }
};

/// The smallest and the largest value of one component.
struct ValueRange {
  double min = 0.0;  ///< the field's own unit
  double max = 0.0;  ///< the field's own unit
  friend bool operator==(const ValueRange&, const ValueRange&) = default;
};

/// A bound on a field around a position: at a distance of at most `radius_m` the value differs from the one at the position by
/// at most `change(distance)`, and there are data if and only if there are data at the position. Proven, but often far from
/// tight.
struct LipschitzBound {
  double radius_m = 0.0;     ///< [m] 0: nothing is known
  double slope_per_m = 0.0;  ///< [unit/m]
  double rounding = 0.0;     ///< the field's own unit: two samples may differ by this as well

  /// The largest change of the value, in the field's own unit, over a distance [m] of at most `radius_m`.
  double change(double distance_m) const noexcept { return slope_per_m * distance_m + rounding; }
  /// The same in a frame where lengths are `scale` [1] times as long, and positions are rounded by up to `shift_m` [m].
  LipschitzBound scaled(double scale, double shift_m) const noexcept;
};

/// A piece of a straight way through a scalar field, on which the value is one polynomial, or is known to stay within bounds.
struct PolynomialPiece {
  double end = 1.0;      ///< [1] share of the way where the piece ends
  bool inside = false;   ///< the field has data on the piece, perhaps except at its ends
  int degree = -1;       ///< [1] of the polynomial, 0…9; −1: only known is that the value stays in the quiet interval
  double control[10]{};  ///< Bernstein coefficients of the value from begin to end, the field's own unit; their hull holds it
};

/// Data over the world. Immutable, so any number of threads may sample one field at once; sampling
/// never allocates, throws or returns a value that is not finite, for any position at all.
///
/// Positions are world metres. The derivative is that of the interpolant that `value` is read from,
/// not another estimate of it.
class Field {
 public:
  virtual ~Field() = default;

  /// 1 for a scalar field, 3 for a vector field.
  virtual int components() const noexcept = 0;
  /// Value and gradient at a world position; outside for a vector field.
  virtual ScalarSample scalar(const Vec3& world_m) const noexcept;
  /// Value and Jacobian at a world position; outside for a scalar field.
  virtual VectorSample vector(const Vec3& world_m) const noexcept;

  /// Second derivative of a scalar field [unit/m²] at a world position, row and column = axis of position;
  /// zero outside and for a vector field. Exact where the interpolant is smooth (derived fields); here,
  /// by differences of the gradient over half a spacing.
  virtual Mat3 hessian(const Vec3& world_m) const noexcept;

  /// The piece of the straight way from `from_m` to `to_m` [m] that begins at the share `begin` [1], with a scalar field's
  /// value there as one polynomial of the share. Pieces have no gaps: the next one begins where this one ends, and each has a
  /// length. Where the field has no data, the piece says so (`inside`); on a way that is not finite, such a piece reaches to
  /// its end.
  ///
  /// Grids are exact: a polynomial is the interpolant itself, within one cell. Where the value provably stays between both
  /// ends of `quiet`, in the field's own unit (min <= value < max, to rounding), a piece may have no polynomial (degree −1) and
  /// be as long as that can be found out cheaply; an empty interval (min > max) asks for polynomials throughout. This
  /// implementation, for formulas: cubics through value and slope at both ends, over at most a quarter of a spacing.
  ///
  /// For a vector field pieces have degree −1 and only say where there are data. Formulas look for holes only in the middle of
  /// each piece.
  virtual PolynomialPiece piece_along(const Vec3& from_m, const Vec3& to_m, double begin,
                                      const ValueRange& quiet) const noexcept;

  /// A bound on the field around a world position [m]: on grids it reaches about one cell; of a vector field it bounds the
  /// length of the value's change. This implementation, and fields that change with time: radius 0. Takes a fraction of a
  /// sample's time.
  virtual LipschitzBound lipschitz_bound(const Vec3& world_m) const noexcept {
    return static_cast<void>(world_m), LipschitzBound{};
  }

  /// How many values are summed for one sample [1], at least 1: what it costs, counted and never timed. Of directions without
  /// sign, products of their parts. This implementation, for formulas: 8, as many as of a trilinear grid of numbers.
  virtual int values_per_sample() const noexcept { return 8; }

  /// The length [m] over which the field may change its course, > 0 and finite: the least distance
  /// between neighbouring planes of samples of a grid, or the size of the finest feature of a formula.
  virtual double spacing_m() const noexcept = 0;
  /// The same [m] at a world position [m]: for a rectilinear grid that of its cell there, for other fields `spacing_m()`.
  virtual double local_spacing_m(const Vec3& world_m) const noexcept { return static_cast<void>(world_m), spacing_m(); }
  /// A box [m] outside which the field has no data. Formulas state the box they are meant for.
  virtual Box bounds_m() const noexcept = 0;
  /// How deep [m] a position lies within the data: the distance to the nearest face of the grid (or of the formula's box) or,
  /// if less, to the nearest cell that has no value because of voxels that are not finite. The latter may be too small, down to
  /// 1/√3 of the true one (less on sheared grids). Zero or less outside, zero where voxels are missing; changes by no more than
  /// the position moves. Finite whatever the position. Strengths fade with it, so that they end before the data do.
  virtual double depth_m(const Vec3& world_m) const noexcept = 0;
  /// Range of each component over the finite samples of a grid; of a formula, or of vectors turned by a
  /// pose, a range that holds all its values. 0 to 0 where no sample is finite. Allocates.
  virtual std::vector<ValueRange> value_ranges() const = 0;

 protected:
  /// A piece as `piece_along` has it for formulas: no longer than `longest_m` [m].
  PolynomialPiece cubic_piece(const Vec3& from_m, const Vec3& to_m, double begin, double longest_m) const noexcept;
};

using FieldPtr = std::shared_ptr<const Field>;

}  // namespace palpa
