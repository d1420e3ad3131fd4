// The geometry of a corner: which place that all its facets leave free is nearest. Internal.
#pragma once

#include <span>

#include "palpa/solver/primitives.h"

namespace palpa::detail {

/// A face of a corner: up to three facets with independent normals, and the directions that they span.
///
/// The basis is orthonormal, taken from the normals one by one, twice: n_A = q T with T triangular. The matrix of
/// the normals' products would lose what nearly parallel facets differ by.
struct Face {
  int size = 0;
  int facet[3] = {};
  Vec3 q[3];
  double T[3][3] = {};  // column j: the parts of facet j's normal along q

  /// What of `v` lies in the span.
  Vec3 across(const Vec3& v) const noexcept {
    Vec3 sum;
    for (int i = 0; i < size; ++i) sum += dot(q[i], v) * q[i];
    return sum;
  }
  /// Takes facet `j` with normal `n` in, unless its part across the span is shorter than 1e-12.
  bool take(int j, const Vec3& n) noexcept;
  /// The vector w of the span with n·w = c[facet] for the face's facets.
  Vec3 hull(const double* c) const noexcept;
  /// The t with Σ t n = v for a vector v of the span; of the face's facets in their order.
  void shares(const Vec3& v, double* t) const noexcept;
  /// The largest |t| that a v of length 1 can have, or more: the Frobenius norm of T⁻¹.
  double inverse_norm() const noexcept;
};

/// The least w with nᵢ·w ≥ cᵢ for all i: w = Σ tᵢ nᵢ with at most three tᵢ > 0, those of `face`.
struct CornerFoot {
  Vec3 w;
  Face face;
  double t[3] = {};   // of the face's facets, ≥ 0
  bool found = true;  // false: there is no such w
};

/// Goldfarb and Idnani's dual active set (1983) in three dimensions. It needs no start; w is off by a few roundings of
/// the c of its face, times the inverse of T. For normals of unit length, at most `most_facets`, and any finite c.
CornerFoot foot_of(std::span<const Vec3> normals, const double* c) noexcept;

/// σ = max over unit vectors e of min nᵢ·e, or 0 where that is not positive.
double width_of(std::span<const Vec3> normals) noexcept;

/// From x to the nearest place that all facets leave free [m]; at most `most_facets`.
Vec3 way_out(std::span<const Primitive> facets, const Vec3& x_m) noexcept;

}  // namespace palpa::detail
