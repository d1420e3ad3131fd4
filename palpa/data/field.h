// Field: scalar or vector data sampled at world positions.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "palpa/solver/similarity.h"
#include "palpa/solver/vec3.h"

namespace palpa {

/// Scalar sample. Finite at any position; all zero if not `inside`.
struct ScalarSample {
  double value = 0.0;   ///< the field's own unit
  Vec3 gradient;        ///< [unit/m]
  bool inside = false;  ///< the field has data here
};

/// Vector sample. Finite at any position; all zero if not `inside`.
struct VectorSample {
  Vec3 value;     ///< the field's own unit
  Mat3 jacobian;  ///< [unit/m] row = component, column = axis of position
  bool inside = false;
};

/// Axis-aligned box of the world.
struct Box {
  Vec3 low_m;
  Vec3 high_m;
  Vec3 centre_m() const noexcept { return 0.5 * (low_m + high_m); }
  Vec3 size_m() const noexcept { return high_m - low_m; }
};

/// Smallest and largest value of a component.
struct ValueRange {
  double min = 0.0;  ///< the field's own unit
  double max = 0.0;  ///< the field's own unit
  friend bool operator==(const ValueRange&, const ValueRange&) = default;
};

/// Bound on a field around a centre: within `radius_m` of it, the value differs from the value at the centre by at most
/// `change(distance)`, from the tangent there by at most `off_tangent(distance)`, and there are data if and only if the centre
/// has data. Proven, but often far from tight.
struct LipschitzBound {
  double radius_m = 0.0;     ///< [m] 0: no bound
  double slope_per_m = 0.0;  ///< [unit/m]
  double rounding = 0.0;     ///< the field's own unit: rounding error of the difference of two samples
  /// [unit/m²] Of the second derivative, along any direction. Infinity: the gradient may jump, or the field has several
  /// components
  double bend_per_m2 = std::numeric_limits<double>::infinity();
  /// The field's own unit: all values within the radius, but for rounding; all numbers where they are not known.
  ValueRange values{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};

  /// Largest change of the value, in the field's own unit, over a distance [m] of at most `radius_m`.
  double change(double distance_m) const noexcept { return slope_per_m * distance_m + rounding; }
  /// Largest difference, in the field's own unit, between the value and the tangent of the sample at the centre, over a
  /// distance [m] of at most `radius_m`, positive. Rounding of the gradient and of the positions: less than 8 times that of a
  /// difference.
  double off_tangent(double distance_m) const noexcept { return 0.5 * bend_per_m2 * distance_m * distance_m + 8.0 * rounding; }
  /// Likewise between the value on a straight way of this length [m] within the radius, and the chord of those at both ends.
  double off_chord(double distance_m) const noexcept { return 0.125 * bend_per_m2 * distance_m * distance_m + 8.0 * rounding; }
  /// This bound in a frame of lengths `scale` [1] times as long, with positions rounded by up to `shift_m` [m].
  LipschitzBound scaled(double scale, double shift_m) const noexcept;
  /// This bound in the world of a pose, for positions around `world_m` [m].
  LipschitzBound posed(const Similarity& pose, const Vec3& world_m) const noexcept;
};

/// Piece of a segment through a scalar field on which the value is one polynomial, or within known bounds.
struct PolynomialPiece {
  double end = 1.0;      ///< [1] share of the segment at the piece's end
  bool inside = false;   ///< the piece has data, perhaps except at its ends
  int degree = -1;       ///< [1] of the polynomial, 0…9; −1: no polynomial, the value stays in the quiet interval
  double control[10]{};  ///< Bernstein coefficients from start to end, the field's own unit; the value lies in their hull
};

/// Data as a function of world position. Immutable, so any number of threads may sample a field at once; sampling never
/// allocates, throws or returns a non-finite value, at any position.
///
/// Positions are world metres. The derivative is that of the interpolant that gives `value`, not a separate estimate.
class Field {
 public:
  virtual ~Field() = default;

  /// 1 for a scalar field, 3 for a vector field.
  virtual int components() const noexcept = 0;
  /// Value and gradient at a world position; outside for a vector field.
  virtual ScalarSample scalar(const Vec3& world_m) const noexcept;
  /// Value and Jacobian at a world position; outside for a scalar field.
  virtual VectorSample vector(const Vec3& world_m) const noexcept;

  /// Second derivative of a scalar field [unit/m²] at a world position, row and column = axis of position; zero outside and for
  /// a vector field. Exact for smooth interpolants (derived fields); by default, differences of the gradient over half a
  /// spacing.
  virtual Mat3 hessian(const Vec3& world_m) const noexcept;

  /// Piece of the segment from `from_m` to `to_m` [m] that begins at the share `begin` [1], with a scalar field's value as one
  /// polynomial of the share. Pieces are contiguous and of positive length. A piece without data has `inside` false; on a
  /// non-finite segment, it extends to the end.
  ///
  /// Exact for grids: the interpolant itself, within a cell. If the value provably stays within `quiet`, in the field's own
  /// unit (min <= value < max, to rounding), a piece may have no polynomial (degree −1) and be as long as cheap tests can
  /// prove; an empty interval (min > max) requests polynomials throughout. Default, for formulas: cubics through value and
  /// slope at both ends, over at most a quarter of a spacing.
  ///
  /// For a vector field pieces have degree −1 and only `inside` is meaningful. Formulas check for holes only in the middle of
  /// each piece.
  virtual PolynomialPiece piece_along(const Vec3& from_m, const Vec3& to_m, double begin,
                                      const ValueRange& quiet) const noexcept;

  /// Bound on the field around a world position [m]. Its radius is about a cell on grids, 0 by default. For a vector field it
  /// bounds the length of the value's change. Costs a fraction of a sample.
  virtual LipschitzBound lipschitz_bound(const Vec3& world_m) const noexcept {
    return static_cast<void>(world_m), LipschitzBound{};
  }

  /// Cost of a sample [1], at least 1: number of values summed (for axis fields, of products of components). Default, for
  /// formulas: 8, as for a trilinear scalar grid.
  virtual int values_per_sample() const noexcept { return 8; }

  /// Length scale [m] of the field, > 0 and finite: the least distance between neighbouring planes of samples of a grid, or the
  /// size of a formula's finest feature.
  virtual double spacing_m() const noexcept = 0;
  /// Length scale [m] at a world position [m]: of a rectilinear grid's cell there, else `spacing_m()`.
  virtual double local_spacing_m(const Vec3& world_m) const noexcept { return static_cast<void>(world_m), spacing_m(); }
  /// Box [m] outside which the field has no data. A formula's box is its stated domain.
  virtual Box bounds_m() const noexcept = 0;
  /// Depth [m] of a position within the data: the distance to the nearest face of the grid (or of the formula's box) or, if
  /// less, to the nearest cell without a value because of non-finite voxels. The latter may be too small, down to 1/√3 of the
  /// true distance (less on sheared grids). Zero or less outside, zero where voxels are missing; 1-Lipschitz; finite at any
  /// position. Strengths fade to zero with it, before the data end.
  virtual double depth_m(const Vec3& world_m) const noexcept = 0;
  /// Range of each component over the finite samples of a grid; of a formula, or of vectors rotated by a pose, a range that
  /// contains all its values. 0 to 0 if no sample is finite. Allocates.
  virtual std::vector<ValueRange> value_ranges() const = 0;

 protected:
  /// Piece as `piece_along` returns for formulas: no longer than `longest_m` [m].
  PolynomialPiece cubic_piece(const Vec3& from_m, const Vec3& to_m, double begin, double longest_m) const noexcept;
};

using FieldPtr = std::shared_ptr<const Field>;

}  // namespace palpa
