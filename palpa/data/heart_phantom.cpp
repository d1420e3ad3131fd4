// Beating chamber with a ring vortex.
#include "palpa/data/phantom_parts.h"

namespace palpa {

using namespace detail::phantom;

namespace {

constexpr double chamber_radius_m = 27e-3, chamber_half_height_m = 32e-3;
constexpr Ellipsoid chamber({0, 0, 0}, {1e3 * chamber_radius_m, 1e3 * chamber_radius_m, 1e3 * chamber_half_height_m});
constexpr double ring_peak_m_per_s = 0.6;

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

/// Strength and position of the ring at a moment of the beat, as an angle [rad].
Ring ring_at(double angle) noexcept {
  constexpr double strongest_m_per_s = 0.53;  // of f: for a fastest blood of 0.6 m/s at that moment
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

/// Base of the beating chamber's fields.
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
    // Peak speed of the ring, stretched by exp(2 · 0.06) at most, and of the wall.
    constexpr double fastest = 1.13 * ring_peak_m_per_s + 0.04;
    return {{-fastest, fastest}, {-fastest, fastest}, {-fastest, fastest}};
  }
};

}  // namespace

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

}  // namespace palpa
