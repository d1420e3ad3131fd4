#include "bench/haptics/cases.h"

#include <algorithm>
#include <cmath>

#include "bench/haptics/shape.h"

namespace palpa::haptics {

using nlohmann::json;

void Trajectory::press(const Vec3& place_m, const Vec3& outward, double force_n, Phase phase) {
  const Vec3 probe_m = place_m - (force_n / stiffness_n_per_m) * outward;
  touches.push_back({turn_ * probe_m, turn_ * (std::max(force_n, 0.0) * outward), phase});
}

void Trajectory::held(const Vec3& probe_m, const Vec3& place_m, Phase phase) {
  touches.push_back({turn_ * probe_m, turn_ * (stiffness_n_per_m * (place_m - probe_m)), phase});
}

nlohmann::json surface_rule(const Sampling& sampling, double friction_coefficient) {
  const double top = std::exp2(sampling.bits) - 1.0;
  return {{"kind", "surface"},
          {"solid", "high"},
          {"levels", json::array({{{"value", 0.5 * top}, {"strength_n", nullptr}}})},
          {"friction_coefficient", friction_coefficient}};
}

SampledVolume sampled(const json& description, const Sampling& sampling) {
  const Shape shape = shape_of(description, {});
  SampledVolume volume{.grid = cube(sampling.samples, sampling.edge_m), .type = sampling.bits > 8 ? "uint16" : "uint8"};
  const double top = std::exp2(sampling.bits) - 1.0, ramp_m = sampling.ramp_voxels * volume.grid.spacing_m.x;
  volume.samples.reserve(volume.grid.samples());
  Noise random(11);
  volume.grid.each([&](const Vec3& x_m) {
    const double inside = std::clamp(0.5 + 0.5 * shape.depth_m(x_m) / ramp_m, 0.0, 1.0);
    double share = 0.1 + 0.8 * inside;
    if (sampling.noise > 0.0) share += 0.8 * sampling.noise * random.next();
    volume.samples.push_back(static_cast<float>(std::round(top * std::clamp(share, 0.0, 1.0))));
  });
  return volume;
}

std::string format_sampling(const Sampling& s) {
  std::string words = "-" + std::to_string(s.samples) + "-" + std::to_string(s.bits) + "bit";
  if (s.noise > 0.0) words += "-noise" + std::to_string(std::lround(100.0 * s.noise));
  if (s.ramp_voxels != Sampling{}.ramp_voxels) words += "-ramp" + std::to_string(s.ramp_voxels);
  return words;
}

void add_surface_case(Suite& suite, const Body& body, const Sampling& sampling, Case told) {
  told.volume = body.name + format_sampling(sampling);
  suite.volumes.emplace(told.volume, [=] { return sampled(body.shape, sampling); });
  if (told.rule.is_null()) told.rule = surface_rule(sampling);
  suite.cases.push_back(std::move(told));
}

}  // namespace palpa::haptics
