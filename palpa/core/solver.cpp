#include "palpa/core/solver.h"

#include <cassert>
#include <limits>

#include "palpa/core/newton_form.h"

namespace palpa {

using newton_form::epsilon;
using newton_form::gap;
using newton_form::Plane;
using newton_form::Proof;
using newton_form::size_of;
using newton_form::Span;
using newton_form::State;

namespace {

// The bound asked for is tighter than the one claimed as exact: stopping at the claim itself left
// nearly parallel lines a little above it.
constexpr double wanted_bound_m = 2e-10;

constexpr int max_refinements = 8;
constexpr int max_in_vain = 2;
constexpr int max_choices = 10;       // of the active set; it can go round in a circle
constexpr int max_newton_steps = 30;  // of the multipliers, for each penalty
constexpr int max_line_search = 40;
constexpr int max_levels = 16;

// What k and T may be, far beyond any device: with the limits of PrimitiveSet nothing overflows.
constexpr double softest_n_per_m = 1e-12;
constexpr double stiffest_n_per_m = 1e12;
constexpr double shortest_time_s = 1e-15;

bool usable(const Vec3& position_m) noexcept {
  return is_finite(position_m) && largest_component(position_m) <= largest_position_m;
}

/// A symmetric 3×3 matrix M ≥ I.
struct Stiffness {
  double xx = 1.0, xy = 0.0, xz = 0.0, yy = 1.0, yz = 0.0, zz = 1.0;

  void add_outer(double f, const Vec3& e) noexcept {
    const Vec3 fe = f * e;
    xx += fe.x * e.x, xy += fe.x * e.y, xz += fe.x * e.z, yy += fe.y * e.y, yz += fe.y * e.z, zz += fe.z * e.z;
  }
  void add_identity(double f) noexcept { xx += f, yy += f, zz += f; }
};

/// M = L D Lᵀ, solved for as many right sides as wanted. No pivoting is needed, as D ≥ 1 but for rounding.
class Factor {
 public:
  explicit Factor(const Stiffness& M) noexcept : by_dx_(1.0 / M.xx), lyx_(M.xy * by_dx_), lzx_(M.xz * by_dx_) {
    by_dy_ = 1.0 / std::max(1.0, M.yy - lyx_ * M.xy);
    const double fzy = M.yz - lyx_ * M.xz;
    lzy_ = fzy * by_dy_;
    by_dz_ = 1.0 / std::max(1.0, M.zz - lzx_ * M.xz - lzy_ * fzy);
  }
  Vec3 solve(const Vec3& g) const noexcept {
    const double gy = g.y - lyx_ * g.x;
    const double z = (g.z - lzx_ * g.x - lzy_ * gy) * by_dz_;
    const double y = gy * by_dy_ - lzy_ * z;
    return {g.x * by_dx_ - lyx_ * y - lzx_ * z, y, z};
  }

 private:
  double by_dx_, lyx_, lzx_, by_dy_, lzy_, by_dz_;
};

// The force of a primitive that is pulled by w, within its span, through a spring of stiffness τ (1: the
// coupling itself): the u of ∂φ at R = (w − u)/τ. It gives what is asked up to s; beyond, s and the
// drag's share of the rest.
double length_given(double demanded, double s, double gamma, double tau) noexcept {
  return gamma > 0.0 ? s + gamma * ((demanded - s) / (tau + gamma)) : s;
}
Vec3 answer(const Span& p, const Vec3& w, double tau) noexcept {
  const double squared = norm_squared(w);
  if (squared <= p.s * p.s) return w;
  const double demanded = std::sqrt(squared);
  return (length_given(demanded, p.s, p.gamma, tau) / demanded) * w;
}
double answer(const Plane& p, double w, double tau) noexcept {
  if (w <= p.s) return std::max(0.0, w);
  return length_given(w, p.s, p.gamma, tau);
}

// A number as the sum of two doubles: twice the precision, by error-free sums and products (Knuth, Dekker).
struct Double2 {
  double high = 0.0, low = 0.0;
};
Double2 two_sum(double a, double b) noexcept {
  const double sum = a + b;
  const double of_b = sum - a;
  return {sum, (a - (sum - of_b)) + (b - of_b)};
}
Double2 two_product(double a, double b) noexcept {
  constexpr double splitter = 134217729.0;  // 2²⁷ + 1
  const double a_split = splitter * a, b_split = splitter * b;
  const double a_high = a_split - (a_split - a), b_high = b_split - (b_split - b);
  const double a_low = a - a_high, b_low = b - b_high;
  const double product = a * b;
  return {product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low};
}
Double2 sum(Double2 a, Double2 b) noexcept {
  const Double2 high = two_sum(a.high, b.high);
  return two_sum(high.high, high.low + (a.low + b.low));
}
Double2 product(Double2 a, double b) noexcept {
  const Double2 high = two_product(a.high, b);
  return {high.high, high.low + a.low * b};
}
double rounded(Double2 a) noexcept { return a.high + a.low; }

/// a − o, along q and across it, for q of unit length but for rounding.
struct Slide {
  double along = 0.0;
  Vec3 across;
};
Slide slide(const Vec3& q, const Vec3& a, const Vec3& o) noexcept {
  const Double2 x = two_sum(a.x, -o.x), y = two_sum(a.y, -o.y), z = two_sum(a.z, -o.z);
  const Double2 along = sum(sum(product(x, q.x), product(y, q.y)), product(z, q.z));
  const Double2 squared = sum(sum(two_product(q.x, q.x), two_product(q.y, q.y)), two_product(q.z, q.z));
  const double longer = (squared.high - 1.0) + squared.low;  // |q|² − 1
  const Double2 share = {-along.high, along.high * longer - along.low};
  return {rounded(along),
          {rounded(sum(x, product(share, q.x))), rounded(sum(y, product(share, q.y))), rounded(sum(z, product(share, q.z)))}};
}

}  // namespace

/// The problem in newtons about an origin, the iterate (Z and all u), and the best iterate so far.
class Solver::Work {
 public:
  explicit Work(std::size_t capacity)
      : planes_(std::make_unique<Plane[]>(capacity)),
        spans_(std::make_unique<Span[]>(capacity)),
        best_forces_(std::make_unique<Vec3[]>(capacity)) {}

  void pose(std::span<const Primitive> primitives, const Vec3* warm_n, const Vec3& start_m, const Vec3& probe_m, double k,
            double T, const Vec3& directed_n, double directed_size_n, double directed_terms) noexcept;

  /// Finds the balance of what was posed.
  void solve() noexcept;

  /// Writes the best balance found, and its forces in the order of the set (directed ones are left alone).
  void give(Balance& balance, Vec3& remainder_m, Vec3* forces_n) const noexcept;

  /// Room for forces in the order of the set, free until `solve`.
  Vec3* spare_forces() noexcept { return best_forces_.get(); }

 private:
  bool prove(int stage) noexcept;
  void sweep() noexcept;
  void choose() noexcept;
  void multiply() noexcept;
  void keep() noexcept;
  void restore() noexcept;
  double slope(const Vec3& at, const Vec3& d, double tau) const noexcept;
  void recentre() noexcept;
  void anchor(Plane& plane) const noexcept;
  void anchor(Span& span) const noexcept;
  void add_common_points() noexcept;
  Vec3 sum() const noexcept;

  std::unique_ptr<Plane[]> planes_;
  std::unique_ptr<Span[]> spans_;  // lines first, then points
  std::unique_ptr<Vec3[]> best_forces_;
  std::size_t plane_count_ = 0, line_count_ = 0, span_count_ = 0, all_spans_ = 0;
  bool common_ = false, warm_ = false;

  std::span<const Primitive> primitives_;
  Vec3 origin_m_, probe_m_, directed_n_;
  double k_ = 1.0, by_k_ = 1.0, directed_size_n_ = 0.0, directed_terms_ = 0.0, wanted_n_ = 0.0, shown_n2_ = 0.0,
         balanced_n_ = 0.0;

  Vec3 C_, Z_, kept_Z_;
  double C_size_ = 0.0;

  Vec3 best_origin_m_, best_Z_;
  double best_bound_n_ = 0.0;
  bool precise_ = false, anchored_precisely_ = false;
  int best_stage_ = 0, iterations_ = 0;
  bool best_is_last_ = false;
};

// Anchors against the origin. What rounding takes from B is a shift of the anchor: where the proxy rests
// with strength s it costs √(s|shift|) in the bound, so where that would show, the difference and its part
// along q are taken in twice the precision.
void Solver::Work::anchor(Plane& p) const noexcept {
  const Vec3& a = primitives_[p.index].position_m;
  const Vec3 B = k_ * (a - origin_m_);
  p.b = dot(p.q, B);
  p.size = size_of(B);
  if (!precise_ && !(p.s * p.size * epsilon > shown_n2_)) return;
  p.b = k_ * slide(p.q, a, origin_m_).along;
  p.size = std::abs(p.b);
}
void Solver::Work::anchor(Span& p) const noexcept {
  const Vec3& a = primitives_[p.index].position_m;
  p.B = k_ * (a - origin_m_);
  p.size = size_of(p.B);
  if (p.q == Vec3{}) return;
  if (precise_ || p.s * p.size * epsilon > shown_n2_) {
    p.B = k_ * slide(p.q, a, origin_m_).across;
    p.size = size_of(p.B);
  } else {
    p.B = p.across(p.B);
  }
}

void Solver::Work::pose(std::span<const Primitive> primitives, const Vec3* warm_n, const Vec3& start_m, const Vec3& probe_m,
                        double k, double T, const Vec3& directed_n, double directed_size_n, double directed_terms) noexcept {
  primitives_ = primitives;
  origin_m_ = start_m, probe_m_ = probe_m, directed_n_ = directed_n;
  k_ = k, by_k_ = 1.0 / k, directed_size_n_ = directed_size_n, directed_terms_ = directed_terms, wanted_n_ = k * wanted_bound_m;
  shown_n2_ = 0.1 * wanted_n_ * wanted_n_;
  balanced_n_ = 2e-6 * wanted_n_;
  best_bound_n_ = std::numeric_limits<double>::max();
  iterations_ = 0;
  precise_ = anchored_precisely_ = false;

  // Primitives at the start, where modes place them, get B = 0 exactly.
  const Vec3 way_n = k * (probe_m - start_m);
  C_ = way_n + directed_n;
  C_size_ = 2.0 * size_of(way_n) + directed_size_n;
  plane_count_ = 0;
  line_count_ = 0;
  std::size_t points = 0;
  for (const Primitive& p : primitives)
    points += p.kind == PrimitiveKind::point, line_count_ += p.kind == PrimitiveKind::line;
  all_spans_ = line_count_ + points;
  std::size_t line = 0, point = line_count_;
  warm_ = false;
  const Vec3* first_m = nullptr;
  common_ = points > 0 && primitives.size() > points;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    if (p.kind == PrimitiveKind::directed) continue;
    if (!first_m) first_m = &p.position_m;
    const double gamma = newton_form::gamma_of(p, k, T);
    common_ = common_ && p.position_m == *first_m && (gamma == 0.0 || p.kind == PrimitiveKind::point);
    if (p.kind == PrimitiveKind::plane) {
      Plane& plane = planes_[plane_count_++];
      plane.q = p.direction, plane.s = p.strength_n, plane.gamma = gamma, plane.index = static_cast<std::uint32_t>(i);
      anchor(plane);
      plane.t = std::max(0.0, dot(p.direction, warm_n[i]));
      if (gamma == 0.0) plane.t = std::min(plane.t, p.strength_n);
      warm_ = warm_ || plane.t > 0.0;
    } else {
      Span& span = spans_[p.kind == PrimitiveKind::line ? line++ : point++];
      span.q = p.direction, span.s = p.strength_n, span.gamma = gamma, span.index = static_cast<std::uint32_t>(i);
      anchor(span);
      span.u = span.across(warm_n[i]);
      warm_ = warm_ || span.u != Vec3{};
      if (gamma == 0.0 && norm_squared(span.u) > p.strength_n * p.strength_n) span.u = (p.strength_n / norm(span.u)) * span.u;
    }
  }
  common_ = common_ && plane_count_ + line_count_ > 0;
  span_count_ = common_ ? line_count_ : all_spans_;
}

Vec3 Solver::Work::sum() const noexcept {
  Vec3 sum = C_;
  for (std::size_t i = 0; i < plane_count_; ++i) sum += planes_[i].t * planes_[i].q;
  for (std::size_t i = 0; i < span_count_; ++i) sum += spans_[i].u;
  return sum;
}

// Keeps (Z, u) if its bound is the best so far, and says whether that is good enough.
bool Solver::Work::prove(int stage) noexcept {
  const Vec3 rest = Z_;
  if (common_) add_common_points();
  Proof proof(Z_, C_, C_size_, directed_terms_ + 1.0);
  const double size_of_Z = size_of(Z_);
  for (std::size_t i = 0; i < plane_count_; ++i) proof.add(gap(planes_[i], Z_, size_of_Z), planes_[i].t * planes_[i].q);
  for (std::size_t i = 0; i < span_count_; ++i) proof.add(gap(spans_[i], Z_), spans_[i].u);
  const double bound_n = proof.bound();
  ++iterations_;
  bool proven = bound_n <= wanted_n_;
  if (!proven && proof.plain_bound() <= 0.5 * wanted_n_) {
    // All that is missing is rounding.
    proven = bound_n <= 4.0 * wanted_n_ || anchored_precisely_;
    precise_ = true;
    common_ = false;  // the rest and the points are looked at together from here on
  }
  const bool done = proven && proof.left() <= 1e-3 * wanted_n_ + proof.rounding();
  best_is_last_ = done || bound_n < best_bound_n_;
  if (best_is_last_) {
    best_bound_n_ = bound_n;
    best_origin_m_ = origin_m_, best_Z_ = Z_;
    best_stage_ = stage;
    if (!done) {
      for (std::size_t i = 0; i < plane_count_; ++i) best_forces_[planes_[i].index] = planes_[i].t * planes_[i].q;
      for (std::size_t i = 0; i < span_count_; ++i) best_forces_[spans_[i].index] = spans_[i].u;
    }
  }
  if (common_ && !done) span_count_ = line_count_, Z_ = rest;
  return done;
}

// 1. Sweeps: block coordinate descent of the dual. With all forces but u held, Z without it is Z − u, and
// u answers the pull P(B − (Z − u)) = R + u of the coupling itself.
void Solver::Work::sweep() noexcept {
  for (std::size_t i = 0; i < plane_count_; ++i) {
    Plane& p = planes_[i];
    const double t = answer(p, p.residual(Z_) + p.t, 1.0);
    Z_ += (t - p.t) * p.q;
    p.t = t;
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    Span& p = spans_[i];
    const Vec3 u = answer(p, p.across(p.B - Z_ + p.u), 1.0);
    Z_ += u - p.u;
    p.u = u;
  }
  Z_ = sum();
}

// Points among others at one anchor, these without drag: φ of the points together is a function of |R|
// alone, and the rest's is homogeneous, so the balance is the rest's, drawn towards the anchor as by one
// point of all the points' strength and drag.
void Solver::Work::add_common_points() noexcept {
  double s = 0.0, gamma = 0.0;
  for (std::size_t i = line_count_; i < all_spans_; ++i) s += spans_[i].s, gamma += spans_[i].gamma;
  const Vec3& B = spans_[line_count_].B;
  const Vec3 w = B - Z_;
  const double demanded = std::sqrt(norm_squared(w));
  if (demanded <= s) {
    const double share = s > 0.0 ? 1.0 / s : 0.0;
    for (; span_count_ < all_spans_; ++span_count_) spans_[span_count_].u = (spans_[span_count_].s * share) * w;
    Z_ = B;
    return;
  }
  const double beyond = (demanded - s) / (1.0 + gamma);
  const Vec3 e = (1.0 / demanded) * w;
  for (; span_count_ < all_spans_; ++span_count_) {
    Span& p = spans_[span_count_];
    p.u = (p.s + p.gamma * beyond) * e;
  }
  // What the rest stood on it still stands on: its residuals shrink with w.
  Z_ = B - beyond * e;
}

// Moves the origin to the proxy as a double can say it. Residuals of what the proxy rests on are then
// differences of nearby doubles: exact where rounding would otherwise be multiplied by τ.
void Solver::Work::recentre() noexcept {
  const Vec3 z_m = by_k_ * Z_;
  const Vec3 origin_m = origin_m_ + z_m;
  Z_ = k_ * ((origin_m_ - origin_m) + z_m);
  origin_m_ = origin_m;
  anchored_precisely_ = precise_;
  const Vec3 way_n = k_ * (probe_m_ - origin_m);
  C_ = way_n + directed_n_;
  C_size_ = 2.0 * size_of(way_n) + directed_size_n_;
  for (std::size_t i = 0; i < plane_count_; ++i) anchor(planes_[i]);
  for (std::size_t i = 0; i < all_spans_; ++i) anchor(spans_[i]);
}

// 2. Active set. With w = R + u the pull that a sweep would see, a primitive sticks where |w| ≤ s; there
// R = 0 is asked for, by a spring of stiffness τ that starts from u. Where it slips, its force is s + γ|R|
// along e = w/|w|, and for a move dZ it changes by −γ along e and by −K across it, K = |u|/(|w| − |u|)
// with the |u| that answers w. All together is one linear system for dZ:
//     M dZ = C + Σ(force at dZ = 0) − Z,   M = I + ΣK.
// The spring leaves R = (u⁺ − u)/τ, and the turn of the slipping forces leaves a force. Solving again with
// the same M, for that force and that R (known so, not as a difference of large numbers), takes both to
// rounding.
void Solver::Work::choose() noexcept {
  constexpr double tau = 1e8;
  Stiffness M;
  Vec3 g = C_ - Z_;
  for (std::size_t i = 0; i < plane_count_; ++i) {
    Plane& p = planes_[i];
    const double r = p.residual(Z_);
    const double w = r + p.t;
    if (w <= 0.0) {
      p.state = State::off, p.t = 0.0;
    } else if (w <= p.s) {
      p.state = State::stick, p.r = tau * r;
      g += (p.t + p.r) * p.q;
      M.add_outer(tau, p.q);
    } else {
      p.state = State::slip, p.r = r;
      g += (p.s + p.gamma * r) * p.q;
      M.add_outer(p.gamma, p.q);
    }
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    Span& p = spans_[i];
    const Vec3 R = p.residual(Z_);
    const Vec3 w = R + p.u;
    const double squared = norm_squared(w);
    double across = tau;
    if (squared <= p.s * p.s) {
      p.state = State::stick, p.R = tau * R;
      g += p.u + p.R;
    } else {
      p.state = State::slip, p.R = R;
      const double demanded = std::sqrt(squared);
      const double given = length_given(demanded, p.s, p.gamma, 1.0);
      const Vec3 e = (1.0 / demanded) * w;
      across = std::min(tau, given / (demanded - given));
      const double along = dot(e, R);
      g += (p.s + p.gamma * along - across * along) * e + across * R;
      M.add_outer(p.gamma - across, e);
    }
    M.add_identity(across);
    M.add_outer(-across, p.q);
  }
  const Factor factor(M);
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < max_refinements; ++i) {
    const Vec3 dZ = factor.solve(g);
    Z_ += dZ;
    Vec3 left = C_ - Z_;
    Vec3 held;  // τR of all that stick
    for (std::size_t j = 0; j < plane_count_; ++j) {
      Plane& p = planes_[j];
      if (p.state == State::off) continue;
      if (p.state == State::stick) {
        p.r -= tau * dot(p.q, dZ);
        p.t += p.r;
        held += p.r * p.q;
      } else {
        p.r -= dot(p.q, dZ);
        p.t = p.s + p.gamma * std::max(0.0, p.r);
      }
      left += p.t * p.q;
    }
    for (std::size_t j = 0; j < span_count_; ++j) {
      Span& p = spans_[j];
      if (p.state == State::stick) {
        p.R = p.across(p.R - tau * dZ);
        p.u += p.R;
        held += p.R;
      } else {
        const Vec3 R = p.R - p.across(dZ);
        if (dot(p.R + p.u, R) > 0.0) {  // else it would pass its anchor: it keeps its force
          const double reach = std::sqrt(norm_squared(R));
          p.u = ((p.s + p.gamma * reach) / reach) * p.across(R);
        }
        p.R = R;
      }
      left += p.u;
    }
    const double size = size_of(left);
    if ((i > 0 && size <= balanced_n_) || !(size < 0.5 * before)) break;
    before = size;
    g = left + held;
  }
  for (std::size_t i = 0; i < plane_count_; ++i) {
    Plane& p = planes_[i];
    if (p.state == State::stick) p.t = std::clamp(p.t, 0.0, p.s);
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    Span& p = spans_[i];
    if (p.state != State::stick) continue;
    p.u = p.across(p.u);
    const double squared = norm_squared(p.u);
    if (squared > p.s * p.s) p.u *= p.s / std::sqrt(squared);
  }
}

// 3. Method of multipliers. For a penalty τ, the convex, once differentiable
//     Ψ(Z) = ½|Z − C|² + Σ max_v [v·R − φ*(v) − |v − u|²/(2τ)],   ∇Ψ = Z − C − Σ answer(u + τR)
// is minimised by Newton's method; the forces that answer there are the next u. Every pass brings the
// forces nearer to a balanced set, by a factor that falls with τ.
double Solver::Work::slope(const Vec3& at, const Vec3& d, double tau) const noexcept {
  double slope = dot(at - C_, d);
  for (std::size_t i = 0; i < plane_count_; ++i) {
    const Plane& p = planes_[i];
    slope -= answer(p, p.t + tau * p.residual(at), tau) * dot(p.q, d);
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    const Span& p = spans_[i];
    slope -= dot(answer(p, p.u + tau * p.residual(at), tau), d);
  }
  return slope;
}

void Solver::Work::multiply() noexcept {
  double tau = 1e3;
  for (int level = 0; level < max_levels; ++level, tau = std::min(1e14, tau * 10.0)) {
    recentre();
    for (int step = 0; step < max_newton_steps; ++step) {
      Stiffness M;
      Vec3 g = C_ - Z_;
      double size = size_of(C_);
      for (std::size_t i = 0; i < plane_count_; ++i) {
        const Plane& p = planes_[i];
        const double w = p.t + tau * p.residual(Z_);
        const double t = answer(p, w, tau);
        g += t * p.q;
        size += t;
        if (w > 0.0) M.add_outer(w <= p.s ? tau : tau * (p.gamma / (tau + p.gamma)), p.q);
      }
      for (std::size_t i = 0; i < span_count_; ++i) {
        const Span& p = spans_[i];
        const Vec3 w = p.u + tau * p.residual(Z_);
        const double squared = norm_squared(w);
        double across = tau;
        if (squared <= p.s * p.s) {
          g += w;
        } else {
          const double demanded = std::sqrt(squared);
          const double given = length_given(demanded, p.s, p.gamma, tau) / demanded;
          g += given * w;
          across = tau * given;
          M.add_outer(tau * (p.gamma / (tau + p.gamma)) - across, w / demanded);
        }
        size += size_of(p.u);
        M.add_identity(across);
        M.add_outer(-across, p.q);
      }
      ++iterations_;
      if (size_of(g) <= std::max(4.0 * epsilon, 1e-6 / tau) * size) break;
      const Vec3 d = Factor(M).solve(g);
      const double start = -dot(g, d);
      if (!(start < 0.0) || !is_finite(d)) break;
      // Along d the slope only grows, from `start` < 0. A step that ends past its zero by little, or before
      // it, is taken; otherwise the zero is drawn in from both sides.
      double low = 0.0, high = 1.0, at_low = start, share = 1.0;
      double at_share = slope(Z_ + d, d, tau);
      for (int i = 0; i < max_line_search && at_share > -0.5 * start; ++i) {
        high = share;
        const double secant = low + (high - low) * (at_low / (at_low - at_share));
        share = std::clamp(secant, low + 0.1 * (high - low), low + 0.6 * (high - low));
        at_share = slope(Z_ + share * d, d, tau);
        while (at_share < 0.5 * start && i < max_line_search) {  // too short: move the near end
          low = share, at_low = at_share;
          share = 0.5 * (low + high);
          at_share = slope(Z_ + share * d, d, tau);
          ++i;
        }
      }
      Z_ += share * d;
    }
    for (std::size_t i = 0; i < plane_count_; ++i) {
      Plane& p = planes_[i];
      p.t = answer(p, p.t + tau * p.residual(Z_), tau);
    }
    for (std::size_t i = 0; i < span_count_; ++i) {
      Span& p = spans_[i];
      p.u = p.across(answer(p, p.u + tau * p.residual(Z_), tau));
    }
    if (prove(3)) return;
    if (level == 0 || tau > 1e8) {
      keep();
      recentre();
      choose();
      if (prove(3)) return;
      restore();
    }
  }
}

void Solver::Work::keep() noexcept {
  kept_Z_ = Z_;
  for (std::size_t i = 0; i < plane_count_; ++i) planes_[i].kept = planes_[i].t;
  for (std::size_t i = 0; i < span_count_; ++i) spans_[i].kept = spans_[i].u;
}

void Solver::Work::restore() noexcept {
  for (std::size_t i = 0; i < plane_count_; ++i) planes_[i].t = planes_[i].kept;
  for (std::size_t i = 0; i < span_count_; ++i) spans_[i].u = spans_[i].kept;
}

void Solver::Work::solve() noexcept {
  Z_ = sum();
  sweep();
  // More than three at once are hardly ever done after a sweep, and looking costs as much as it.
  if (plane_count_ + span_count_ <= 3) {
    if (prove(1)) return;
  } else if (!warm_) {
    sweep();
  }
  int in_vain = 0;
  for (int i = 0; i < max_choices && in_vain < max_in_vain; ++i) {
    if (i > 0) {
      recentre();
      Z_ = sum();
      sweep();
    }
    const double before = best_bound_n_;
    choose();
    if (prove(2)) return;
    if (!(best_bound_n_ < 0.5 * before)) ++in_vain;
  }
  multiply();
}

void Solver::Work::give(Balance& balance, Vec3& remainder_m, Vec3* forces_n) const noexcept {
  const Vec3 z_m = by_k_ * best_Z_;
  balance.position_m = best_origin_m_ + z_m;
  remainder_m = (best_origin_m_ - balance.position_m) + z_m;
  balance.error_bound_m = best_bound_n_ * by_k_ * (1.0 + 2.0 * epsilon) + size_of(remainder_m) + 2.0 * epsilon * size_of(z_m);
  balance.stage = best_stage_;
  balance.iterations = iterations_;
  if (best_is_last_) {
    for (std::size_t i = 0; i < plane_count_; ++i) forces_n[planes_[i].index] = planes_[i].t * planes_[i].q;
    for (std::size_t i = 0; i < all_spans_; ++i) forces_n[spans_[i].index] = spans_[i].u;
  } else {
    for (std::size_t i = 0; i < plane_count_; ++i) forces_n[planes_[i].index] = best_forces_[planes_[i].index];
    for (std::size_t i = 0; i < all_spans_; ++i) forces_n[spans_[i].index] = best_forces_[spans_[i].index];
  }
}

Solver::Solver(std::size_t capacity)
    : capacity_(capacity),
      forces_(std::make_unique<Vec3[]>(capacity)),
      ids_(std::make_unique<PrimitiveId[]>(capacity)),
      work_(std::make_unique<Work>(capacity)) {}

Solver::~Solver() = default;

Balance Solver::solve(const PrimitiveSet& set, const Vec3& start_m, const Vec3& probe_m, double k, double T) noexcept {
  assert(set.size() <= capacity_);
  const std::span<const Primitive> primitives = set.primitives().first(std::min(set.size(), capacity_));
  const std::size_t n = primitives.size();
  remainder_m_ = {};

  // Forces of the last balance, matched by who placed them; sets rarely change their order.
  bool same = size_ == n;
  Vec3 directed_n;
  double directed_size_n = 0.0, directed_terms = 0.0;
  bool drags = false;
  for (std::size_t i = 0; i < n; ++i) {
    const Primitive& p = primitives[i];
    same = same && ids_[i] == p.id;
    drags = drags || p.drag_ns_per_m > 0.0;
    if (p.kind != PrimitiveKind::directed) continue;
    directed_n += p.strength_n * p.direction;
    directed_size_n += 2.0 * p.strength_n;
    directed_terms += 1.0;
  }
  if (!same) match(primitives);

  const bool time_usable = !drags || (std::isfinite(T) && T >= shortest_time_s);
  if (!(k >= softest_n_per_m && k <= stiffest_n_per_m) || !time_usable || !usable(start_m) || !usable(probe_m)) {
    std::fill_n(forces_.get(), n, Vec3{});
    return {usable(start_m) ? start_m : Vec3{}, std::numeric_limits<double>::max(), BalanceStatus::bad_input, 0, 0};
  }
  // With nothing to balance the proxy is the probe itself, to the last bit.
  if (n == 0) return {probe_m, 0.0, BalanceStatus::exact, 0, 0};

  work_->pose(primitives, forces_.get(), start_m, probe_m, k, T, directed_n, directed_size_n, directed_terms);
  work_->solve();
  Balance balance;
  work_->give(balance, remainder_m_, forces_.get());
  for (std::size_t i = 0; i < n && directed_terms > 0.0; ++i) {
    if (primitives[i].kind == PrimitiveKind::directed) forces_[i] = primitives[i].strength_n * primitives[i].direction;
  }
  balance.status = balance.error_bound_m <= exact_bound_m ? BalanceStatus::exact : BalanceStatus::capped;
  return balance;
}

void Solver::match(std::span<const Primitive> primitives) noexcept {
  Vec3* const matched = work_->spare_forces();
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    matched[i] = {};
    for (std::size_t step = 0; step < size_; ++step) {  // the same place first
      const std::size_t j = (i + step) % size_;
      if (ids_[j] == primitives[i].id) {
        matched[i] = forces_[j];
        break;
      }
    }
  }
  size_ = primitives.size();
  for (std::size_t i = 0; i < size_; ++i) ids_[i] = primitives[i].id, forces_[i] = matched[i];
}

Balance solve_once(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                   double time_step_s) {
  Solver solver(std::max<std::size_t>(1, primitives.size()));
  return solver.solve(primitives, start_m, probe_m, stiffness_n_per_m, time_step_s);
}

}  // namespace palpa
