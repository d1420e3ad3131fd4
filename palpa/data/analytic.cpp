#include "palpa/data/analytic.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "palpa/base/printed.h"
#include "palpa/data/timed_field.h"
#include "palpa/data/volume.h"

namespace palpa {
namespace {

/// A formula over its box; nothing outside it. `Law` answers a ScalarSample or a VectorSample.
template <class Law>
class Formula final : public Field {
 public:
  Formula(const Box& box, double spacing_m, std::vector<ValueRange> value_ranges, Law law)
      : box_(box), spacing_m_(spacing_m), extents_(std::move(value_ranges)), law_(std::move(law)) {}

  int components() const noexcept override { return is_vector ? 3 : 1; }
  ScalarSample scalar(const Vec3& world_m) const noexcept override {
    if constexpr (!is_vector) {
      if (!holds(world_m)) return {};
      const ScalarSample s = law_(world_m);
      if (std::isfinite(s.value) && is_finite(s.gradient)) return s;
    }
    return {};
  }
  VectorSample vector(const Vec3& world_m) const noexcept override {
    if constexpr (is_vector) {
      if (!holds(world_m)) return {};
      const VectorSample s = law_(world_m);
      if (is_finite(s.value) && is_finite(s.jacobian)) return s;
    }
    return {};
  }
  double spacing_m() const noexcept override { return spacing_m_; }
  Box bounds_m() const noexcept override { return box_; }
  double depth_m(const Vec3& world_m) const noexcept override {
    const Vec3 low = world_m - box_.low_m, high = box_.high_m - world_m;
    const double depth = std::min({low.x, low.y, low.z, high.x, high.y, high.z});
    return is_finite(low) && is_finite(high) ? depth : 0.0;
  }
  std::vector<ValueRange> value_ranges() const override { return extents_; }

 private:
  static constexpr bool is_vector = std::is_same_v<decltype(std::declval<Law>()(Vec3{})), VectorSample>;

  bool holds(const Vec3& x) const noexcept {
    return x.x >= box_.low_m.x && x.x <= box_.high_m.x && x.y >= box_.low_m.y && x.y <= box_.high_m.y && x.z >= box_.low_m.z &&
           x.z <= box_.high_m.z;
  }

  Box box_;
  double spacing_m_;
  std::vector<ValueRange> extents_;
  Law law_;
};

template <class Law>
Volume volume_of(std::string name, std::string unit, const Box& box, double spacing_m, std::vector<ValueRange> value_ranges,
                 Law law) {
  Volume volume;
  volume.format = "formula";
  volume.fields.push_back({std::move(name), std::move(unit),
                           std::make_shared<const Formula<Law>>(box, spacing_m, std::move(value_ranges), std::move(law))});
  return volume;
}

template <class Law>
void add_field(Volume& volume, std::string name, std::string unit, std::vector<ValueRange> value_ranges, Law law) {
  const Field& first = *volume.fields.front().field;
  volume.fields.push_back(
      volume_of(std::move(name), std::move(unit), first.bounds_m(), first.spacing_m(), std::move(value_ranges), std::move(law))
          .fields.front());
}

Box cube(double half_m) { return {{-half_m, -half_m, -half_m}, {half_m, half_m, half_m}}; }

void check_length(const char* what, double length_m) {
  if (std::isfinite(length_m) && length_m > 0.0) return;
  throw std::invalid_argument(std::string(what) + " is " + detail::text("%g", length_m) + "; it must be a length above 0 m");
}

// ---- vortices ------------------------------------------------------------------------------------------

/// φ(s) = (1 − exp(−s))/s and dφ/ds. Near s = 0 both are differences of nearly equal numbers; there the
/// series Σ (−s)ⁿ/(n+1)! takes over, whose 17 terms are exact to rounding below s = 1/2.
struct Swirl {
  double phi;
  double slope;
};
Swirl swirl(double s) noexcept {
  if (s < 0.5) {
    double factorial = 355687428096000.0;  // 17!
    double phi = 1.0 / factorial;          // term n = 16 of φ, without its power of −s
    double slope = 0.0;
    for (int n = 16; n >= 1; --n) {
      slope = slope * -s + n / factorial;
      factorial /= n + 1;
      phi = phi * -s + 1.0 / factorial;
    }
    return {phi, -slope};
  }
  const double decay = std::exp(-s);
  return {(1.0 - decay) / s, (decay * (1.0 + s) - 1.0) / (s * s)};
}

/// u = ω (−y, x, 0) + a (−x/2, −y/2, z) with ω = Γ/(2πr_c²) φ(r²/r_c²): one expression for both vortices,
/// without a division by r.
struct Vortex {
  double core_radius_m;
  double axis_rate_per_s;  ///< Γ/(2πr_c²), ω on the axis
  double strain_per_s;

  VectorSample operator()(const Vec3& x) const noexcept {
    const double px = x.x / core_radius_m, py = x.y / core_radius_m;
    const Swirl f = swirl(px * px + py * py);
    const double w = axis_rate_per_s * f.phi;
    const double bend = 2.0 * axis_rate_per_s * f.slope;  // r_c dω/dx = bend · x/r_c
    const double a = strain_per_s;
    VectorSample s;
    s.inside = true;
    s.value = {-w * x.y - 0.5 * a * x.x, w * x.x - 0.5 * a * x.y, a * x.z};
    s.jacobian = {{{-0.5 * a - bend * px * py, -w - bend * py * py, 0.0},
                   {w + bend * px * px, -0.5 * a + bend * px * py, 0.0},
                   {0.0, 0.0, a}}};
    return s;
  }
};

Volume vortex(double circulation_m2_per_s, double core_radius_m, double strain_per_s) {
  check_length("a vortex's core radius", core_radius_m);
  if (!std::isfinite(strain_per_s) || strain_per_s < 0.0) {
    throw std::invalid_argument("a vortex's strain is " + detail::text("%g", strain_per_s) + "; it must be 0 1/s or more");
  }
  const double rate = circulation_m2_per_s / (2.0 * std::numbers::pi * core_radius_m * core_radius_m);
  if (!std::isfinite(rate)) throw std::invalid_argument("a vortex's circulation must be finite, also over its core's area");
  const double half_m = 6.0 * core_radius_m;
  constexpr double s = 1.2564312086261697;  // where u_t is largest: 1 + 2s = exp(s)
  const double fastest = std::abs(rate) * core_radius_m * (1.0 - std::exp(-s)) / std::sqrt(s);
  const double across = fastest + 0.5 * strain_per_s * half_m, along = strain_per_s * half_m;
  return volume_of("velocity", "m/s", cube(half_m), core_radius_m / 8.0,
                   {{-across, across}, {-across, across}, {-along, along}}, Vortex{core_radius_m, rate, strain_per_s});
}

// ---- the head ------------------------------------------------------------------------------------------

/// Signed distance to a shape [m], negative inside, and its gradient [1]: true to first order near the
/// surface; far from it only the sign is right, and that it is far, which is enough for an edge of 2 mm.
struct Distance {
  double d;
  Vec3 g;
};

struct Ellipsoid {
  Vec3 centre;
  Vec3 inverse_squared;
  double smallest;

  /// Centre and semi-axes in millimetres.
  constexpr Ellipsoid(Vec3 centre_mm, Vec3 semi_axes_mm)
      : centre(1e-3 * centre_mm),
        inverse_squared{1e6 / (semi_axes_mm.x * semi_axes_mm.x), 1e6 / (semi_axes_mm.y * semi_axes_mm.y),
                        1e6 / (semi_axes_mm.z * semi_axes_mm.z)},
        smallest(1e-3 * std::min({semi_axes_mm.x, semi_axes_mm.y, semi_axes_mm.z})) {}

  static constexpr Vec3 times(const Vec3& a, const Vec3& b) noexcept { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

  /// d = k₀(k₀ − 1)/k₁ with k₀ = |x/a|, k₁ = |x/a²| (a: the semi-axes).
  Distance operator()(const Vec3& x) const noexcept {
    const Vec3 r = x - centre;
    const Vec3 u = times(r, inverse_squared);
    const double squared = dot(r, u);
    if (squared < 0.04) return {-0.5 * smallest, {}};  // deep inside, where the expression is singular
    const double k0 = std::sqrt(squared);
    const double inverse_k1 = 1.0 / std::sqrt(norm_squared(u));
    const double d = k0 * (k0 - 1.0) * inverse_k1;
    return {d, (2.0 - 1.0 / k0) * inverse_k1 * u - d * inverse_k1 * inverse_k1 * times(u, inverse_squared)};
  }
};

struct Capsule {
  Vec3 start;
  Vec3 axis;
  double radius;

  constexpr Capsule(Vec3 start_mm, Vec3 end_mm, double radius_mm)
      : start(1e-3 * start_mm), axis(1e-3 * (end_mm - start_mm)), radius(1e-3 * radius_mm) {}

  Distance operator()(const Vec3& x) const noexcept {
    const Vec3 from_start = x - start;
    const double t = std::clamp(dot(from_start, axis) / norm_squared(axis), 0.0, 1.0);
    const Vec3 r = from_start - t * axis;
    const double length = std::sqrt(norm_squared(r));
    return {length - radius, length > 0.0 ? r / length : Vec3{}};
  }
};

/// A box with round edges.
struct RoundBox {
  Vec3 centre;
  Vec3 half;  ///< of the box that is rounded
  double radius;

  constexpr RoundBox(Vec3 centre_mm, Vec3 half_mm, double radius_mm)
      : centre(1e-3 * centre_mm), half(1e-3 * half_mm), radius(1e-3 * radius_mm) {}

  Distance operator()(const Vec3& x) const noexcept {
    const Vec3 r = x - centre;
    const Vec3 q{std::max(std::abs(r.x) - half.x, 0.0), std::max(std::abs(r.y) - half.y, 0.0),
                 std::max(std::abs(r.z) - half.z, 0.0)};
    const double length = std::sqrt(norm_squared(q));
    if (!(length > 0.0)) return {-radius, {}};
    return {length - radius, Vec3{std::copysign(q.x, r.x), std::copysign(q.y, r.y), std::copysign(q.z, r.z)} / length};
  }
};

/// The union of two shapes, with the crease between them filled over a width.
Distance joined(const Distance& a, const Distance& b, double width_m) noexcept {
  const double h = std::clamp(0.5 + 0.5 * (b.d - a.d) / width_m, 0.0, 1.0);
  return {b.d + h * (a.d - b.d) - width_m * h * (1.0 - h), h * a.g + (1.0 - h) * b.g};
}
Distance negated(const Distance& a) noexcept { return {-a.d, -a.g}; }
/// The part that both shapes share, its crease rounded over a width.
Distance shared(const Distance& a, const Distance& b, double width_m) noexcept {
  return negated(joined(negated(a), negated(b), width_m));
}
/// The shape grown by a length.
Distance grown(const Distance& a, double by_m) noexcept { return {a.d - by_m, a.g}; }

// Width of all edges, two sample spacings. Less: gradients are missed between samples; more: thin bone fades.
constexpr double edge_m = 2e-3;

/// 1 inside, 0 outside, a quintic between: value, slope and curvature join.
struct Weight {
  double w;
  Vec3 g;
};
Weight weight_of(const Distance& a) noexcept {
  const double t = 0.5 - a.d / edge_m;
  if (t <= 0.0) return {0.0, {}};
  if (t >= 1.0) return {1.0, {}};
  const double rest = 1.0 - t;
  return {t * t * t * (10.0 + t * (6.0 * t - 15.0)), (-30.0 * t * t * rest * rest / edge_m) * a.g};
}

/// Paints a shape over what is there.
void paint(ScalarSample& onto, double value_hu, const Distance& shape) noexcept {
  const Weight a = weight_of(shape);
  onto.gradient = (1.0 - a.w) * onto.gradient + (value_hu - onto.value) * a.g;
  onto.value += a.w * (value_hu - onto.value);
}

constexpr double air_hu = -1000.0, tissue_hu = 40.0, bone_hu = 1000.0, brain_hu = 35.0;

// Millimetres; x to the left, y to the back, z to the top. Of pairs (ear, eye, sinus, …) one is given; the head is symmetric.
constexpr Ellipsoid cranium({0, 8, 45}, {76, 92, 73});
constexpr Ellipsoid cranium_bone({0, 8, 45}, {70, 86, 67});
constexpr Ellipsoid brain({0, 8, 45}, {63, 79, 60});
constexpr Ellipsoid face({0, -22, -35}, {60, 66, 82});
constexpr Ellipsoid face_bone({0, -22, -35}, {53, 59, 75});
constexpr Ellipsoid face_inside({0, -22, -35}, {45, 51, 67});
constexpr Capsule neck({0, 22, -200}, {0, 22, -50}, 52);
constexpr Capsule nose({0, -78, 0}, {0, -96, -30}, 9);
constexpr Ellipsoid ear({72, 14, 20}, {7, 14, 23});
constexpr Capsule eye_socket({32, -78, -3}, {26, -62, -3}, 15);
constexpr Capsule spine({0, 42, -200}, {0, 42, -30}, 15);
constexpr RoundBox nasal_wall({0, -54, -24}, {12, 21, 13}, 5.5);  // one for both sides: no seam on the septum
constexpr RoundBox nasal_cavity({8, -54, -24}, {4, 21, 13}, 2.5);
constexpr Ellipsoid sinus({31, -53, -38}, {11, 14, 14});
constexpr Capsule nostril({6, -94, -42}, {7, -76, -28}, 3);
constexpr Capsule throat({0, -28, -30}, {0, 12, -70}, 7);
constexpr Capsule windpipe({0, 12, -70}, {0, 12, -200}, 7);
constexpr double face_bone_back_m = -5e-3;  // behind it the jaw is open

/// Painted in layers, each over those before: tissue, bone, cavities, the brain last; outside of the skin is air.
ScalarSample head(const Vec3& world) noexcept {
  const Vec3 x{std::abs(world.x), world.y, world.z};
  const Distance brain_at = brain(x);
  if (brain_at.d <= -0.5 * edge_m) return {brain_hu, {}, true};

  const Distance skin_of_face = joined(joined(cranium(x), face(x), 25e-3), neck(x), 20e-3);
  const Weight skin = weight_of(joined(joined(skin_of_face, nose(x), 8e-3), ear(x), 10e-3));
  if (skin.w == 0.0) return {air_hu, {}, true};

  ScalarSample inner{tissue_hu, {}, true};
  const Distance skull = cranium_bone(x);
  const Distance jaw = shared(face_bone(x), {x.y - face_bone_back_m, {0, 1, 0}}, 10e-3);
  paint(inner, bone_hu, joined(skull, jaw, 25e-3));
  paint(inner, tissue_hu, shared(face_inside(x), negated(skull), 5e-3));
  paint(inner, tissue_hu, eye_socket(x));
  paint(inner, bone_hu, spine(x));
  const Distance sinus_at = sinus(x);
  paint(inner, bone_hu, nasal_wall(x));
  paint(inner, bone_hu, grown(sinus_at, 3e-3));
  paint(inner, air_hu, nasal_cavity(x));
  paint(inner, air_hu, sinus_at);
  paint(inner, air_hu, nostril(x));
  paint(inner, air_hu, throat(x));
  paint(inner, air_hu, windpipe(x));
  paint(inner, brain_hu, brain_at);

  ScalarSample s{air_hu + skin.w * (inner.value - air_hu), (inner.value - air_hu) * skin.g + skin.w * inner.gradient, true};
  s.gradient.x = world.x < 0.0 ? -s.gradient.x : s.gradient.x;
  return s;
}

// ---- the heart -----------------------------------------------------------------------------------------

constexpr double chamber_radius_m = 27e-3, chamber_half_height_m = 32e-3;
constexpr Ellipsoid chamber({0, 0, 0}, {1e3 * chamber_radius_m, 1e3 * chamber_radius_m, 1e3 * chamber_half_height_m});
constexpr double ring_peak_m_per_s = 0.6;

Mat3 plus(const Mat3& a, const Mat3& b) noexcept { return {{a.row[0] + b.row[0], a.row[1] + b.row[1], a.row[2] + b.row[2]}}; }
/// a bᵀ
Mat3 outer(const Vec3& a, const Vec3& b) noexcept { return {{a.x * b, a.y * b, a.z * b}}; }

/// u = ∇×(f (−y, x, 0)) = (−x f_z, −y f_z, 2f + x f_x + y f_y), f = strength · exp(E) · (1 − e)³.
struct Ring {
  double strength_m_per_s;
  double centre_m;  ///< z₀

  VectorSample operator()(const Vec3& x) const noexcept {
    constexpr double radius = 14e-3, core = 8e-3;
    constexpr double per_a = 1.0 / (chamber_radius_m * chamber_radius_m);
    constexpr double per_h = 1.0 / (chamber_half_height_m * chamber_half_height_m);
    VectorSample s;
    s.inside = true;
    const double squared = x.x * x.x + x.y * x.y;
    const double rest = 1.0 - squared * per_a - x.z * x.z * per_h;
    if (!(rest > 0.0)) return s;

    const double p = (squared - radius * radius) / (2.0 * radius * core), q = (x.z - centre_m) / core;
    const Vec3 dp{x.x / (radius * core), x.y / (radius * core), 0.0};
    const double g = strength_m_per_s * std::exp(-p * p - q * q);
    const Vec3 exponent{-2.0 * p * dp.x, -2.0 * p * dp.y, -2.0 * q / core};  // ∇E, E = −p² − q²
    const double bend = -2.0 * p / (radius * core);
    const Mat3 exponent2 = plus(-2.0 * outer(dp, dp), {{{bend, 0, 0}, {0, bend, 0}, {0, 0, -2.0 / (core * core)}}});

    const double w = rest * rest * rest;
    const Vec3 dw = -3.0 * rest * rest * Vec3{2.0 * per_a * x.x, 2.0 * per_a * x.y, 2.0 * per_h * x.z};
    const Vec3 de{2.0 * per_a * x.x, 2.0 * per_a * x.y, 2.0 * per_h * x.z};
    const double curve = -6.0 * rest * rest;
    const Mat3 dw2 = plus(6.0 * rest * outer(de, de), {{{curve * per_a, 0, 0}, {0, curve * per_a, 0}, {0, 0, curve * per_h}}});

    const double f = g * w;
    const Vec3 df = g * (w * exponent + dw);
    const Mat3 mixed = outer(exponent, dw);
    const Mat3 h = g * plus(plus(w * plus(exponent2, outer(exponent, exponent)), dw2), plus(mixed, transposed(mixed)));

    s.value = {-x.x * df.z, -x.y * df.z, 2.0 * f + x.x * df.x + x.y * df.y};
    s.jacobian = {{-x.x * h.row[2] - Vec3{df.z, 0, 0}, -x.y * h.row[2] - Vec3{0, df.z, 0},
                   x.x * h.row[0] + x.y * h.row[1] + Vec3{3.0 * df.x, 3.0 * df.y, 2.0 * df.z}}};
    return s;
  }
};

/// Strength and place of the ring at a moment of the beat, as an angle [rad].
Ring ring_at(double angle) noexcept {
  constexpr double strongest_m_per_s = 0.53;  // of f: makes the fastest blood 0.6 m/s at that moment
  return {(0.6 + 0.4 * std::sin(angle)) * strongest_m_per_s, -6e-3 * std::cos(angle)};
}

ScalarSample blood_in_chamber(const Vec3& x) noexcept {
  const Weight blood = weight_of(chamber(x));
  return {blood.w, blood.g, true};
}

constexpr double beat_s = 0.8, beat_stretch = 0.06;

/// S, by its diagonal, and ṠS⁻¹ [1/s].
struct BeatingWall {
  Vec3 stretch, rate_per_s;
  double angle;  ///< [rad] of the beat

  explicit BeatingWall(DataTime at) noexcept {
    constexpr double turn = 2.0 * std::numbers::pi;
    angle = turn * at.within(beat_s) / beat_s;
    const double s = std::exp(beat_stretch * std::sin(angle)), rate = beat_stretch * std::cos(angle) * turn / beat_s;
    stretch = {s, s, 1.0 / (s * s)};
    rate_per_s = {rate, rate, -2.0 * rate};
  }
  Vec3 to_rest(const Vec3& x) const noexcept { return {x.x / stretch.x, x.y / stretch.y, x.z / stretch.z}; }
  Vec3 from_rest(const Vec3& x) const noexcept { return {x.x * stretch.x, x.y * stretch.y, x.z * stretch.z}; }
};

/// What the fields of the beating chamber share.
class BeatingField : public TimedField {
 public:
  double spacing_m() const noexcept override { return 1e-3; }
  Box bounds_m() const noexcept override { return {{-32e-3, -32e-3, -40e-3}, {32e-3, 32e-3, 40e-3}}; }
  double cycle_s() const noexcept override { return beat_s; }
  double time_spacing_s() const noexcept override { return beat_s / 20.0; }
  double depth_at(const Vec3& world_m, DataTime) const noexcept override {
    const Box box = bounds_m();
    const Vec3 low = world_m - box.low_m, high = box.high_m - world_m;
    return is_finite(low) && is_finite(high) ? std::min({low.x, low.y, low.z, high.x, high.y, high.z}) : 0.0;
  }
};

class BeatingSignal final : public BeatingField {
 public:
  int components() const noexcept override { return 1; }
  ScalarSample scalar_at(const Vec3& world_m, DataTime at) const noexcept override {
    if (!(depth_at(world_m, at) >= 0.0) || !is_finite(world_m)) return {};
    const BeatingWall wall(at);
    ScalarSample s = blood_in_chamber(wall.to_rest(world_m));
    s.gradient = wall.to_rest(s.gradient);
    return s;
  }
  Carried carried(const Vec3& world_m, DataTime from, DataTime to) const noexcept override {
    if (from == to) return {world_m};
    const Vec3 carried_m = BeatingWall(to).from_rest(BeatingWall(from).to_rest(world_m));
    return is_finite(carried_m) ? Carried{carried_m} : Carried{world_m, false};
  }
  std::vector<ValueRange> value_ranges() const override { return {{0.0, 1.0}}; }
};

class BeatingVelocity final : public BeatingField {
 public:
  int components() const noexcept override { return 3; }
  VectorSample vector_at(const Vec3& world_m, DataTime at) const noexcept override {
    if (!(depth_at(world_m, at) >= 0.0) || !is_finite(world_m)) return {};
    const BeatingWall wall(at);
    VectorSample s = ring_at(wall.angle)(wall.to_rest(world_m));
    const Vec3& r = wall.rate_per_s;
    s.value = wall.from_rest(s.value) + Vec3{r.x * world_m.x, r.y * world_m.y, r.z * world_m.z};
    const double stretch[3] = {wall.stretch.x, wall.stretch.y, wall.stretch.z};
    for (int i = 0; i < 3; ++i) s.jacobian.row[i] = stretch[i] * wall.to_rest(s.jacobian.row[i]);
    s.jacobian = plus(s.jacobian, {{{r.x, 0, 0}, {0, r.y, 0}, {0, 0, r.z}}});
    return s;
  }
  Carried carried(const Vec3& world_m, DataTime, DataTime) const noexcept override { return {world_m}; }
  std::vector<ValueRange> value_ranges() const override {
    // The ring's fastest, stretched by exp(2 · 0.06) at most, and the wall's own speed.
    constexpr double fastest = 1.13 * ring_peak_m_per_s + 0.04;
    return {{-fastest, fastest}, {-fastest, fastest}, {-fastest, fastest}};
  }
};

// ---- a wing --------------------------------------------------------------------------------------------

constexpr double free_stream_m_per_s = 1.0, wing_circulation_m2_per_s = 0.4, wing_core_m = 0.12;

/// A straight vortex from `start` along the unit vector `along`; `length` infinite for one without end.
///
/// u = Γ/(4π) K t × r, r = x − start, K = ∫ ds/(|x − s|² + ε²)^{3/2} = (l₁/s₁ − l₂/s₂)/h², with l the
/// distances along the line from both ends, s² = l² + h² and h² = ε² + (distance from the line)².
struct LineVortex {
  Vec3 start;
  Vec3 along;
  double length_m;
  double circulation_m2_per_s;

  struct Swirling {
    Vec3 velocity;
    Mat3 jacobian;
    double rate = 0.0;  ///< ω = Γ K/(4π) [1/s]
    Vec3 rate_gradient;
    double squared_m2 = 0.0;  ///< h²
    Vec3 squared_gradient_m;
  };
  Swirling operator()(const Vec3& x) const noexcept {
    const Vec3 r = x - start;
    const double l1 = dot(r, along);
    const Vec3 across = r - l1 * along;
    Swirling v;
    v.squared_m2 = norm_squared(across) + wing_core_m * wing_core_m;
    v.squared_gradient_m = 2.0 * across;
    const double s1 = std::sqrt(v.squared_m2 + l1 * l1);
    double g = l1 / s1 + 1.0;
    Vec3 dg = (along - (l1 / (s1 * s1)) * r) / s1;
    if (std::isfinite(length_m)) {
      const double l2 = l1 - length_m;
      const double s2 = std::sqrt(v.squared_m2 + l2 * l2);
      g -= l2 / s2 + 1.0;
      dg -= (along - (l2 / (s2 * s2)) * (r - length_m * along)) / s2;
    }
    const double factor = circulation_m2_per_s / (4.0 * std::numbers::pi * v.squared_m2);
    v.rate = factor * g;
    v.rate_gradient = factor * (dg - (g / v.squared_m2) * v.squared_gradient_m);
    const Vec3 turn = cross(along, r);
    v.velocity = v.rate * turn;
    const Mat3 turning{{{0, -along.z, along.y}, {along.z, 0, -along.x}, {-along.y, along.x, 0}}};
    v.jacobian = plus(outer(turn, v.rate_gradient), v.rate * turning);
    return v;
  }
};

constexpr double endless = std::numeric_limits<double>::infinity();
constexpr LineVortex wing_vortices[] = {
    {{0.25, -1.4, 0}, {0, 1, 0}, 2.8, wing_circulation_m2_per_s},
    {{0.25, 1.4, 0}, {1, 0, 0}, endless, wing_circulation_m2_per_s},
    {{0.25, -1.4, 0}, {1, 0, 0}, endless, -wing_circulation_m2_per_s},
};

VectorSample wake_velocity(const Vec3& x) noexcept {
  VectorSample s{{free_stream_m_per_s, 0, 0}, {}, true};
  for (const LineVortex& vortex_line : wing_vortices) {
    const LineVortex::Swirling v = vortex_line(x);
    s.value += v.velocity;
    s.jacobian = plus(s.jacobian, v.jacobian);
  }
  return s;
}

ScalarSample wake_pressure(const Vec3& x) noexcept {
  ScalarSample s{0.0, {}, true};
  for (const LineVortex& vortex_line : wing_vortices) {
    const LineVortex::Swirling v = vortex_line(x);
    s.value -= free_stream_m_per_s * v.velocity.x + 0.5 * v.rate * v.rate * v.squared_m2;
    s.gradient -= free_stream_m_per_s * v.jacobian.row[0] + v.rate * v.squared_m2 * v.rate_gradient +
                  0.5 * v.rate * v.rate * v.squared_gradient_m;
  }
  return s;
}

}  // namespace

Volume plane_field(double size_m) {
  check_length("the size of a plane's box", size_m);
  const double half_m = 0.5 * size_m;
  return volume_of("depth", "m", cube(half_m), size_m / 64.0, {{-half_m, half_m}}, [](const Vec3& x) noexcept {
    return ScalarSample{-x.z, {0.0, 0.0, -1.0}, true};
  });
}

Volume sphere_field(double radius_m) {
  check_length("a sphere's radius", radius_m);
  const double half_m = 1.5 * radius_m;
  return volume_of("depth", "m", cube(half_m), radius_m / 32.0, {{radius_m - norm({half_m, half_m, half_m}), radius_m}},
                   [radius_m](const Vec3& x) noexcept {
                     return ScalarSample{radius_m - norm(x), -normalized(x), true};
                   });
}

Volume head_phantom() {
  constexpr Box box{{-0.090, -0.115, -0.125}, {0.090, 0.110, 0.130}};
  Volume volume = volume_of("ct", "HU", box, 0.5 * edge_m, {{air_hu, bone_hu}}, [](const Vec3& x) noexcept { return head(x); });
  volume.medical_frame = true;
  return volume;
}

Volume lamb_oseen_vortex(double circulation_m2_per_s, double core_radius_m) {
  return vortex(circulation_m2_per_s, core_radius_m, 0.0);
}

Volume burgers_vortex(double circulation_m2_per_s, double core_radius_m, double strain_per_s) {
  return vortex(circulation_m2_per_s, core_radius_m, strain_per_s);
}

Volume ring_vortex(double beat) {
  if (!std::isfinite(beat))
    throw std::invalid_argument("a moment of the heartbeat must be a finite number; 0 to 1 is one beat");
  const Ring ring = ring_at(2.0 * std::numbers::pi * (beat - std::floor(beat)));
  const double peak = ring_peak_m_per_s * ring.strength_m_per_s / ring_at(0.5 * std::numbers::pi).strength_m_per_s;
  Volume volume = volume_of("velocity", "m/s", {{-30e-3, -30e-3, -35e-3}, {30e-3, 30e-3, 35e-3}}, 1e-3,
                            {{-peak, peak}, {-peak, peak}, {-peak, peak}}, ring);
  add_field(volume, "signal", "a.u.", {{0.0, 1.0}}, blood_in_chamber);
  return volume;
}

Volume beating_chamber() {
  Volume volume;
  volume.format = "formula";
  volume.fields = {{"velocity", "m/s", std::make_shared<const BeatingVelocity>()},
                   {"signal", "a.u.", std::make_shared<const BeatingSignal>()}};
  return volume;
}

Volume wing_wake() {
  constexpr Box box{{-0.5, -1.9, -0.6}, {3.0, 1.9, 0.6}};
  // A vortex of circulation Γ turns nothing faster than Γ/(4πε); three of them add up at most.
  constexpr double fastest = wing_circulation_m2_per_s / (4.0 * std::numbers::pi * wing_core_m);
  constexpr double u = free_stream_m_per_s;
  Volume volume =
      volume_of("velocity", "m/s", box, 0.25 * wing_core_m,
                {{u - fastest, u + fastest}, {-2.0 * fastest, 2.0 * fastest}, {-3.0 * fastest, 3.0 * fastest}}, wake_velocity);
  add_field(volume, "pressure", "m²/s²", {{-u * fastest - 6.0 * fastest * fastest, u * fastest}}, wake_pressure);
  return volume;
}

std::span<const AnalyticVolume> analytic_volumes() noexcept {
  static constexpr AnalyticVolume volumes[] = {
      {"plane", "a half space: depth below the plane z = 0, in metres", [] { return plane_field(); }},
      {"sphere", "a ball of 50 mm radius: depth below its surface, in metres", [] { return sphere_field(); }},
      {"head_phantom", "a head as CT sees it: skin, skull, brain, air cavities, in HU", [] { return head_phantom(); }},
      {"lamb_oseen_vortex", "a decaying vortex along z with a core of 10 mm, in m/s", [] { return lamb_oseen_vortex(); }},
      {"burgers_vortex", "a vortex along z held steady by strain, core of 10 mm, in m/s", [] { return burgers_vortex(); }},
      {"ring_vortex", "blood in a heart's chamber: a vortex ring of 14 mm radius, in m/s, and the MR signal",
       [] { return ring_vortex(); }},
      {"wing_wake", "the air behind a wing of 3 m span: two tip vortices, in m/s, and the pressure",
       [] { return wing_wake(); }},
  };
  return volumes;
}

std::span<const AnalyticVolume> beating_volumes() noexcept {
  static constexpr AnalyticVolume volumes[] = {
      {"beating_chamber", "the chamber and the ring of `ring_vortex`, beating once in 0.8 s: its fields change with time",
       [] { return beating_chamber(); }},
  };
  return volumes;
}

const AnalyticVolume* analytic_volume(std::string_view name) noexcept {
  for (const std::span<const AnalyticVolume> volumes : {analytic_volumes(), beating_volumes()}) {
    const auto found = std::ranges::find(volumes, name, &AnalyticVolume::name);
    if (found != volumes.end()) return &*found;
  }
  return nullptr;
}

}  // namespace palpa
