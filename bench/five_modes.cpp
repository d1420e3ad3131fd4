#include "bench/five_modes.h"

#include <sys/mman.h>

#include <cmath>
#include <cstdlib>

namespace palpa::bench {

bool huge_pages = false;

namespace {

constexpr double core_m = 0.060;

GridGeometry cube_of(int voxels) {
  const double step_m = edge_m / (voxels - 1);
  GridGeometry geometry;
  geometry.dims = {voxels, voxels, voxels};
  geometry.index_to_world_m = {{{step_m, 0, 0}, {0, step_m, 0}, {0, 0, step_m}}};
  geometry.origin_m = {-0.5 * edge_m, -0.5 * edge_m, -0.5 * edge_m};
  return geometry;
}

std::shared_ptr<void> in_pages(std::size_t bytes) {
  constexpr std::size_t page = std::size_t{2} << 20;
  const std::size_t rounded = (bytes + page - 1) / page * page;
  void* memory = std::aligned_alloc(page, rounded);
  if (memory == nullptr) throw LoadError("not enough memory for a volume");
  ::madvise(memory, rounded, huge_pages ? MADV_HUGEPAGE : MADV_NOHUGEPAGE);
  return {memory, std::free};
}

/// A grid as a reader makes it: trilinear until a scene sets a filter.
template <class T, int Components, class At>
Volume volume_on(int voxels, VoxelType type, double scale, const char* unit, At at) {
  const GridGeometry geometry = cube_of(voxels);
  const std::size_t bytes = static_cast<std::size_t>(geometry.voxels()) * Components * sizeof(T);
  const std::shared_ptr<void> data = in_pages(bytes);
  T* out = static_cast<T*>(data.get());
  for (int k = 0; k < voxels; ++k) {
    for (int j = 0; j < voxels; ++j) {
      for (int i = 0; i < voxels; ++i, out += Components) at(geometry.to_world({double(i), double(j), double(k)}), out);
    }
  }
  Volume volume;
  volume.format = "grid";
  volume.fields.push_back({"value", unit, grid_field(geometry, {type, Components, data}, scale)});
  return volume;
}

}  // namespace

Volume ball_on(int voxels) {
  return volume_on<std::int16_t, 1>(voxels, VoxelType::int16, 1e-5, "m", [](const Vec3& x, std::int16_t* out) {
    *out = static_cast<std::int16_t>(std::lround(1e5 * (ball_m - norm(x))));
  });
}

Volume flow_on(int voxels) {
  return volume_on<float, 3>(voxels, VoxelType::float32, 1.0, "m/s", [](const Vec3& x, float* out) {
    const double r2 = (x.x * x.x + x.y * x.y) / (core_m * core_m);
    const double turn = r2 > 1e-9 ? (1.0 - std::exp(-r2)) / r2 : 1.0;
    out[0] = static_cast<float>(-turn * x.y / core_m);
    out[1] = static_cast<float>(turn * x.x / core_m);
    out[2] = 0.5F;
  });
}

Volume warmth_on(int voxels) {
  return volume_on<std::int16_t, 1>(voxels, VoxelType::int16, 1e-2, "K", [](const Vec3& x, std::int16_t* out) {
    const Vec3 from = x - Vec3{0.1, 0.1, 0.1};
    *out = static_cast<std::int16_t>(std::lround(1e4 * std::exp(-norm_squared(from) / 0.02)));
  });
}

Scene in_reach(const Vec3& centre_m) {
  Scene scene({.stiffness_n_per_m = 500.0, .damping_ns_per_m = 0.2});
  scene.set(Workspace{.scale = 1.0, .center_m = centre_m, .towards_user = "+z", .up = "+y"});
  return scene;
}

SurfaceAndFriction skin_of(const FieldRef& body) {
  return {.field = body, .levels = {{.name = "skin", .value = 0.0, .strength_n = 3.0}}, .friction_coefficient = 0.2};
}

Scene five_modes(const Volumes& volumes, std::optional<Filter> filter, const Vec3& centre_m) {
  Scene scene = in_reach(centre_m);
  const FieldRef body = scene.add("body", volumes.body, {}, filter);
  const FieldRef flow = scene.add("flow", volumes.flow, {}, filter);
  const FieldRef warmth = scene.add("warmth", volumes.warmth, {}, filter);
  scene.add("skin", skin_of(body));
  scene.add("pull", GradientForce{.field = warmth, .strength_n = 0.3});
  scene.add("stream", Follow{.field = flow, .strength_n = 0.3});
  scene.add("air", Viscosity{.field = flow, .strength_n = 0.05, .drag_ns_per_m = 0.5});
  scene.add("tube", VortexPlane{.field = flow, .strength_n = 0.3});
  return scene;
}

Vec3 Round::next() {
  way_m_ += hand_m_per_s * 1e-3;
  const double along = way_m_ / reach_m_, turn = 0.377 * along;
  const Vec3 flat{std::cos(along), std::sin(along), 0.0};
  return reach_m_ * Vec3{flat.x, std::cos(turn) * flat.y, std::sin(turn) * flat.y};
}

}  // namespace palpa::bench
