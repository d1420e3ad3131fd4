// Blends of two fields: samples, and polynomials along a segment.
#pragma once

#include <algorithm>
#include <functional>

#include "palpa/data/field.h"

namespace palpa::detail {

/// (1 − u) a + u b, of values and derivatives; without data unless both have them.
ScalarSample blend(const ScalarSample& a, const ScalarSample& b, double u) noexcept;
Mat3 blend(const Mat3& a, const Mat3& b, double u) noexcept;
VectorSample blend(const VectorSample& a, const VectorSample& b, double u) noexcept;
/// Bound on a blend: data begin and end where those of either field do. `largest`: of both fields' values, in their own unit.
LipschitzBound blend(const LipschitzBound& a, const LipschitzBound& b, double u, double largest) noexcept;

/// (1 − u) a + u b of two pieces that begin at the share `begin` [1], up to the end of the shorter one.
PolynomialPiece joined_pieces(PolynomialPiece a, PolynomialPiece b, double begin, double u) noexcept;
/// Piece of (1 − u) a + u b on a segment from the share `begin` [1] on, as `Field::piece_along`: as long as both pieces, quiet
/// if both are.
/// \param u         [1] share of the second field
/// \param piece_of  (false or true: of the second field, quiet interval) → its piece
template <class PieceOf>
PolynomialPiece blended_piece(double begin, double u, const ValueRange& quiet, PieceOf&& piece_of) noexcept {
  PolynomialPiece a = piece_of(false, quiet), b = piece_of(true, quiet);
  if (!a.inside || !b.inside) return {.end = !a.inside && !b.inside ? std::min(a.end, b.end) : !a.inside ? a.end : b.end};
  // Quiet in both implies quiet between them; else polynomials of both are requested.
  if (a.degree < 0 && b.degree < 0) return a.end <= b.end ? a : b;
  constexpr ValueRange never{1.0, -1.0};
  if (a.degree < 0) a = piece_of(false, never);
  if (b.degree < 0) b = piece_of(true, never);
  return joined_pieces(a, b, begin, u);
}

/// First part of a polynomial, up to the share `share` [1] of its piece, as Bernstein coefficients over that part (P. de
/// Casteljau).
void keep_first(PolynomialPiece& piece, double share) noexcept;

/// Noise of the gradient [unit/m], below which its direction is not used: three standard deviations of its components' noise,
/// from their median second difference between neighbours, which smooth data and (rare) edges hardly change.
/// \param place   [m] position of the n-th of `places` [1] samples, n from 1
double noise_of_gradient(const Field& field, int places, const std::function<Vec3(int)>& place);

}  // namespace palpa::detail
