// Palpa as a renderer under the benchmark's public protocol: a case's file becomes a scene, each line a tick.
//
//   bench_haptics_palpa [--law NAME] CASE.json
//
// NAME is a law of docs/laws.md: exact, paper-2005, ikits-2003, ikits-2003-sequential or no-proxy.
#include <palpa/palpa.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace {

using namespace palpa;
using nlohmann::json;

Vec3 vector_of(const json& numbers) { return {numbers.at(0), numbers.at(1), numbers.at(2)}; }

VolumeRequest request_of(const json& told, const std::filesystem::path& folder) {
  VolumeRequest request;
  request.files = {folder / std::string(told.at("file"))};
  request.length_unit = "m";
  request.layout.type = told.at("type");
  request.layout.header_bytes = told.at("header_bytes");
  request.layout.dims = told.at("size");
  request.layout.spacing_m = vector_of(told.at("spacing_m"));
  request.layout.origin_m = vector_of(told.at("origin_m"));
  if (told.at("components") == 3) request.layout.components = "last";
  return request;
}

/// Above any force of the cases.
constexpr double rigid_n = 100.0;

SurfaceAndFriction surface_of(const json& rule, const FieldRef& field) {
  SurfaceAndFriction surface{.field = field, .friction_coefficient = rule.at("friction_coefficient")};
  for (const json& level : rule.at("levels")) {
    const json& strength = level.at("strength_n");
    surface.levels.push_back({.value = level.at("value"), .strength_n = strength.is_null() ? rigid_n : strength.get<double>()});
  }
  return surface;
}

/// False for a rule without a mode in Palpa.
bool add_rule(Scene& scene, const json& rule, const FieldRef& field) {
  const std::string kind = rule.at("kind");
  if (kind == "surface") {
    scene.add("rule", surface_of(rule, field));
  } else if (kind == "streamline") {
    scene.add("rule", Follow{.field = field, .strength_n = rule.at("strength_n").get<double>()});
  } else if (kind == "vortex_hold") {
    scene.add("rule", VortexPlane{.field = field, .strength_n = rule.at("strength_n").get<double>()});
  } else if (kind == "vortex_pull") {
    scene.add("rule", VortexForce{.field = field, .strength_n = rule.at("strength_n").get<double>()});
  } else {
    return false;
  }
  return true;
}

int feel(const std::filesystem::path& file, const std::string& law) {
  std::ifstream in(file);
  const json told = json::parse(in);
  Scene scene({.stiffness_n_per_m = told.at("stiffness_n_per_m")});
  scene.set_law(law);
  // The hand's metres are the volume's, along the same axes.
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}, .towards_user = "+z", .up = "+y"});
  const FieldRef field = scene.add("data", read_volume(request_of(told.at("volume"), file.parent_path())));
  if (!add_rule(scene, told.at("rule"), field)) {
    std::puts("unsupported: no such rule");
    return 0;
  }
  Session session(scene);
  const double time_step_s = told.at("time_step_s");
  std::puts("ready");
  std::fflush(stdout);
  double t_s = 0.0;
  Vec3 x_m;
  while (std::scanf("%lf %lf %lf %lf", &t_s, &x_m.x, &x_m.y, &x_m.z) == 4) {
    const auto begin = std::chrono::steady_clock::now();
    const Vec3 f_n = session.tick({.position_m = x_m}, time_step_s).force_n;
    const double took_us = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
    std::printf("%.9g %.9g %.9g %.2f\n", f_n.x, f_n.y, f_n.z, took_us);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const bool named = argc == 4 && std::string(argv[1]) == "--law";
  if (argc != 2 && !named) {
    std::fprintf(stderr, "usage: bench_haptics_palpa [--law NAME] CASE.json\n");
    return 2;
  }
  try {
    return feel(std::filesystem::absolute(argv[argc - 1]), named ? argv[2] : "exact");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_haptics_palpa: %s\n", error.what());
    return 2;
  }
}
