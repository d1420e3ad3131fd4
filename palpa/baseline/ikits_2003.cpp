#include "palpa/baseline/ikits_2003.h"

namespace palpa::baseline {

namespace {

// [1] A direction whose component outside the span is shorter counts as spanned. Less: rounding becomes an axis of its own;
// more: with nearly parallel axes, the proxy follows the probe along an axis that should hold it.
constexpr double spanned_share = 1e-6;

// Orthonormal basis of the directions that the constraints span.
class Span {
 public:
  void add(const Vec3& direction) noexcept {
    Vec3 rest = direction;
    for (int pass = 0; pass < 2; ++pass) rest = outside(rest);  // the second pass removes the rounding of the first
    if (size_ < 3 && norm(rest) > spanned_share) basis_[size_++] = normalized(rest);
  }
  void add(const Primitive& p) noexcept {
    const Vec3& q = p.direction;
    if (p.kind == PrimitiveKind::plane) add(q);
    if (p.kind == PrimitiveKind::line) {
      const Vec3 across = normalized(cross(q, std::abs(q.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
      add(across);
      add(cross(q, across));
    }
  }
  Vec3 outside(Vec3 v) const noexcept {
    if (size_ == 3) return {};
    for (int i = 0; i < size_; ++i) v -= dot(basis_[i], v) * basis_[i];
    return v;
  }

 private:
  Vec3 basis_[3];
  int size_ = 0;
};

}  // namespace

EarlierLaw::Moved Ikits2003::move(const Posed& posed, std::span<Vec3> forces_n) noexcept {
  const double k = posed.stiffness_n_per_m;
  const double T = posed.time_step_s;
  const Vec3 way = posed.target_m - posed.start_m;
  Vec3 moved;
  Span span;
  for (std::size_t i = 0; i < posed.primitives.size(); ++i) {
    const Primitive& p = posed.primitives[i];
    if (p.kind != PrimitiveKind::plane && p.kind != PrimitiveKind::line) continue;
    forces_n[i] = answer_n(p, k * ((p.position_m - posed.start_m) - way), k, T);
    const Vec3 pending = moves_ == Moves::added ? way : way - moved;
    moved += part_in_span(p, pending) + forces_n[i] / k;
    span.add(p);
  }
  moved += span.outside(way);

  Moved result{posed.start_m + moved};
  for (std::size_t i = 0; i < posed.primitives.size(); ++i) {
    const Primitive& p = posed.primitives[i];
    if (p.kind != PrimitiveKind::point) continue;
    forces_n[i] = answer_n(p, k * (p.position_m - result.proxy_m), k, T);
    result.proxy_m += forces_n[i] / k;
  }
  return result;
}

}  // namespace palpa::baseline
