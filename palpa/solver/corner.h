// Geometry of a corner: nearest feasible point. Internal.
#pragma once

#include <span>

#include "palpa/solver/primitives.h"

namespace palpa::detail {

/// Face of a corner: up to three facets with independent normals, and their span.
///
/// The basis is orthonormal, orthogonalised twice from the normals in order: n_A = q T with T triangular. The Gram matrix of
/// the normals would lose the differences of nearly parallel facets.
struct Face {
  int size = 0;
  int facet[3] = {};
  Vec3 q[3];
  double T[3][3] = {};  // column j: components of facet j's normal along q

  /// Projection of `v` on the span.
  Vec3 across(const Vec3& v) const noexcept {
    Vec3 sum;
    for (int i = 0; i < size; ++i) sum += dot(q[i], v) * q[i];
    return sum;
  }
  /// Adds facet `j` with normal `n`, unless shorter than 1e-12 outside the span.
  bool take(int j, const Vec3& n) noexcept;
  /// Vector w of the span with n·w = c[facet] for the face's facets.
  Vec3 hull(const double* c) const noexcept;
  /// The t with Σ t n = v for a vector v of the span, in the order of the face's facets.
  void shares(const Vec3& v, double* t) const noexcept;
  /// Upper bound on |t| for |v| = 1: the Frobenius norm of T⁻¹.
  double inverse_norm() const noexcept;
};

/// The least w with nᵢ·w ≥ cᵢ for all i: w = Σ tᵢ nᵢ with at most three tᵢ > 0, the facets of `face`.
struct LeastWay {
  Vec3 w;
  Face face;
  double t[3] = {};   // of the face's facets, ≥ 0
  bool found = true;  // false: no such w exists
};

/// Goldfarb and Idnani's dual active set (1983) in three dimensions. Needs no start; the error of w is a few roundings of the c
/// of its face, times the inverse of T. For normals of unit length, at most `most_facets`, and any finite c.
/// \param guess  a face of these normals, as of a similar c: where it is the face, it costs a third
LeastWay least_way(std::span<const Vec3> normals, const double* c, const Face& guess = {}) noexcept;

/// σ = max over unit vectors e of min nᵢ·e, or 0 if not positive.
double width_of(std::span<const Vec3> normals) noexcept;

/// Whether a corner of `facets`, at least one, can take a further one with the unit vector `normal` [1].
bool can_take_facet(std::span<const Primitive> facets, const Vec3& normal) noexcept;

/// Vector from x to the nearest point free of all facets [m]; at most `most_facets`.
Vec3 way_out(std::span<const Primitive> facets, const Vec3& x_m) noexcept;

}  // namespace palpa::detail
