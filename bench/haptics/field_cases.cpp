// Vector fields: a hand on streamlines and in vortices.
#include <cmath>

#include "bench/haptics/cases.h"
#include "bench/haptics/shape.h"
#include "palpa/device/sine_cosine.h"

namespace palpa::haptics {

using detail::sine_cosine;
using nlohmann::json;

namespace {

constexpr double edge_m = 0.072;
constexpr double core_m = 0.012;  // radius of the largest speed

// In the frame of the axis, which is z. [m/s]
Vec3 solid_turning(const Vec3& x) { return {-x.y, x.x, 0}; }
Vec3 rising(const Vec3& x) { return {-x.y, x.x, 0.002}; }
// Scully's vortex: smooth, without sine or exponential; 1 m/s at its fastest.
Vec3 vortex(const Vec3& x) { return 2.0 * core_m / (x.x * x.x + x.y * x.y + core_m * core_m) * Vec3{-x.y, x.x, 0}; }

using Flow = Vec3 (*)(const Vec3&);

/// Shares [1] of the fastest flow in steps of 1e-4.
/// \param drift  [1] added everywhere: a moving vortex or a moving observer
/// \param noise  [1] standard deviation of each component
SampledVolume sampled_flow(Flow flow, const Mat3& turn, int samples, const Vec3& drift, double noise) {
  SampledVolume volume{.grid = cube(samples, edge_m), .type = "float32", .components = 3};
  std::vector<Vec3> velocities;
  double fastest = 0.0;
  volume.grid.each([&](const Vec3& x_m) {
    velocities.push_back(turn * flow(transposed(turn) * x_m));
    fastest = std::max(fastest, norm(velocities.back()));
  });
  Noise random(13);
  const auto kept = [&](double share) {
    if (noise > 0.0) share += noise * random.next();
    return static_cast<float>(std::round(1e4 * share) / 1e4);
  };
  for (const Vec3& u : velocities) {
    const Vec3 v = u / fastest + drift;
    volume.samples.insert(volume.samples.end(), {kept(v.x), kept(v.y), kept(v.z)});
  }
  return volume;
}

struct Streamline {
  std::string name;
  Flow flow;
  double radius_m;
  double rise_m;
  int period_ticks;
  double noise;
  bool quick = false;
};

// Along a streamline, pulled off it to either side by up to 0.8 N.
void add_streamline(Suite& suite, const Streamline& line) {
  const json turn{4, 1, 2, -1};
  const json shape{{"kind", "helix"}, {"radius_m", line.radius_m}, {"rise_m", line.rise_m}, {"turn", turn}};
  suite.volumes[line.name] = [=] { return sampled_flow(line.flow, turn_of(turn), 48, {}, line.noise); };
  constexpr int turns = 4;
  constexpr double radian_turns = 1.0 / 6.283185307179586;
  Trajectory trajectory(turn_of(turn));
  const double first_rad = line.rise_m > 0.0 ? -12.5 : 0.0;  // centres the curve in the data
  for (int i = -50; i <= turns * line.period_ticks; ++i) {
    const double turned = i < 0 ? 0.0 : static_cast<double>(i) / line.period_ticks;
    const auto around = sine_cosine(turned + first_rad * radian_turns);
    const Vec3 out{around.cosine, around.sine, 0};
    const Vec3 place = line.radius_m * out + Vec3{0, 0, line.rise_m * (turned / radian_turns + first_rad)};
    const double pull_n = 0.8 * sine_cosine(3.0 * turned).sine;
    trajectory.held(place - (pull_n / stiffness_n_per_m) * out, place);
  }
  const bool closed = line.rise_m == 0.0;
  suite.cases.push_back({.name = line.name,
                         .family = "streamlines",
                         .volume = line.name,
                         .rule = {{"kind", "streamline"}, {"strength_n", 2.0}},
                         .shape = shape,
                         .scores = closed
                                       ? std::vector<std::string>{"surface", "direction", "force", "drift", "energy", "ripple"}
                                       : std::vector<std::string>{"surface", "direction", "force", "ripple"},
                         .touches = std::move(trajectory.touches),
                         .quick = line.quick,
                         .period_ticks = closed ? line.period_ticks : 0});
}

struct Vortex {
  std::string name;
  Vec3 drift;  // [1] of the fastest flow
  double noise;
  bool quick = false;
};

void add_vortex(Suite& suite, const Vortex& wanted) {
  const json turn{5, 1, -2, 1};
  suite.volumes[wanted.name] = [=] { return sampled_flow(vortex, turn_of(turn), 64, wanted.drift, wanted.noise); };

  // Repeated circles in and out within half the core's radius: the proxy keeps the smallest radius reached.
  Trajectory hold(turn_of(turn));
  double held_m = core_m;
  constexpr double strength_n = 1.0;
  for (int i = 0; i < 3000; ++i) {
    const double t = time_step_s * i;
    const auto around = sine_cosine(0.9 * t);
    const double r = 0.006 + 0.0009 * sine_cosine(0.8 * t).sine;
    const Vec3 out{around.cosine, around.sine, 0}, up{0, 0, 0.010 * sine_cosine(0.4 * t).sine};
    held_m = std::min(held_m, r);  // at most 0.9 N off
    hold.held(r * out + up, held_m * out + up);
  }
  suite.cases.push_back({.name = wanted.name + "-hold",
                         .family = "vortices",
                         .volume = wanted.name,
                         .rule = {{"kind", "vortex_hold"}, {"strength_n", strength_n}},
                         .shape = nullptr,
                         .scores = {"direction", "force", "lost", "ripple"},
                         .touches = std::move(hold.touches),
                         .quick = wanted.quick});

  // Circles between a quarter and three quarters of the core's radius: only the direction counts.
  Trajectory pull(turn_of(turn));
  for (int i = 0; i < 3000; ++i) {
    const double t = time_step_s * i;
    const auto around = sine_cosine(0.7 * t + 0.1 * sine_cosine(1.3 * t).sine);
    const double r = core_m * (0.5 + 0.25 * sine_cosine(0.6 * t).sine);
    const Vec3 out{around.cosine, around.sine, 0}, up{0, 0, 0.012 * sine_cosine(0.5 * t).sine};
    const Vec3 probe = r * out + up;
    pull.held(probe, probe - (0.5 / stiffness_n_per_m) * out);
  }
  suite.cases.push_back({.name = wanted.name + "-pull",
                         .family = "vortices",
                         .volume = wanted.name,
                         .rule = {{"kind", "vortex_pull"}, {"strength_n", 0.5}},
                         .shape = nullptr,
                         .scores = {"direction"},
                         .touches = std::move(pull.touches),
                         .quick = wanted.quick});
}

}  // namespace

void add_field_cases(Suite& suite) {
  add_streamline(suite, {"circle", solid_turning, 0.020, 0.0, 1200, 0.0, true});
  add_streamline(suite, {"circle-noise1", solid_turning, 0.020, 0.0, 1200, 0.01});
  add_streamline(suite, {"circle-vortex", vortex, 0.014, 0.0, 900, 0.0});
  add_streamline(suite, {"helix", rising, 0.020, 0.002, 1200, 0.0});
  add_vortex(suite, {"vortex", {}, 0.0, true});
  add_vortex(suite, {"vortex-drifting", {0.2, -0.1, 0.2}, 0.0});
  add_vortex(suite, {"vortex-noise3", {}, 0.03});
}

}  // namespace palpa::haptics
