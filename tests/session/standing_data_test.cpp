// Data that could change with time and do not: felt as plain ones, to the bit, for the work of plain ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "palpa/data/analytic.h"
#include "palpa/data/sampled.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/timed_field.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/session/session.h"

namespace palpa {
namespace standing_data_test {

constexpr double dt_s = 1e-3, voxel_m = 1e-3;
constexpr std::int64_t n = 48;
constexpr double half_m = 0.5 * (n - 1) * voxel_m;

/// Calls so far of a field that passes them on.
struct Calls {
  int samples = 0, pieces = 0, bounds = 0, depths = 0;
};
class Counted final : public Field {
 public:
  Counted(FieldPtr of, Calls& calls) : of_(std::move(of)), calls_(calls) {}
  int components() const noexcept override { return of_->components(); }
  ScalarSample scalar(const Vec3& x) const noexcept override { return ++calls_.samples, of_->scalar(x); }
  VectorSample vector(const Vec3& x) const noexcept override { return ++calls_.samples, of_->vector(x); }
  Mat3 hessian(const Vec3& x) const noexcept override { return ++calls_.samples, of_->hessian(x); }
  PolynomialPiece piece_along(const Vec3& from, const Vec3& to, double begin, const ValueRange& quiet) const noexcept override {
    return ++calls_.pieces, of_->piece_along(from, to, begin, quiet);
  }
  LipschitzBound lipschitz_bound(const Vec3& x) const noexcept override { return ++calls_.bounds, of_->lipschitz_bound(x); }
  int values_per_sample() const noexcept override { return of_->values_per_sample(); }
  double spacing_m() const noexcept override { return of_->spacing_m(); }
  Box bounds_m() const noexcept override { return of_->bounds_m(); }
  double depth_m(const Vec3& x) const noexcept override { return ++calls_.depths, of_->depth_m(x); }
  std::vector<ValueRange> value_ranges() const override { return of_->value_ranges(); }

 private:
  FieldPtr of_;
  Calls& calls_;
};

/// A ball, soft over hard, whose top is cut off by the end of the data.
FieldPtr ball() {
  auto values = std::make_shared<std::vector<float>>();
  for (std::int64_t i = 0; i < n * n * n; ++i) {
    const Vec3 x_m{static_cast<double>(i % n) * voxel_m - half_m, static_cast<double>(i / n % n) * voxel_m - half_m,
                   static_cast<double>(i / n / n) * voxel_m - half_m};
    const double r_m = norm(x_m - Vec3{0.0, 0.0, 0.012});
    const auto ramp = [&](double at_m) { return std::clamp((at_m - r_m) / (3.0 * voxel_m) + 0.5, 0.0, 1.0); };
    values->push_back(static_cast<float>(-1000.0 + 1050.0 * ramp(0.018) + 1200.0 * ramp(0.012)));
  }
  const GridGeometry geometry{{n, n, n}, voxel_m * Mat3::identity(), {-half_m, -half_m, -half_m}};
  return smooth_grid_field(geometry, {VoxelType::float32, 1, {values, values->data()}});
}

enum class Data { plain, at_frame, between_frames, ended, one_frame };

FieldPtr as(Data data, const FieldPtr& grid) {
  if (data == Data::plain) return grid;
  return data == Data::one_frame ? time_series({grid}, 1.0) : time_series({grid, grid}, 1.0);
}

Scene with_time(Scene scene, Data data) {
  using Play = TimeOptions::Play;
  if (data == Data::between_frames) scene.set(TimeOptions{Play::hold, 1.0, 0.5});
  if (data == Data::ended) scene.set(TimeOptions{Play::once, 1.0, 10.0});
  if (data == Data::one_frame) scene.set(TimeOptions{Play::hold, 1.0, 0.3});
  return scene;
}

Scene scan(Data data, const FieldPtr& grid) {
  Scene scene({.stiffness_n_per_m = 500.0, .damping_ns_per_m = 0.1, .max_force_n = 20.0});
  Volume volume;
  volume.fields.push_back({"ct", "", as(data, grid)});
  scene.add("ct", volume);
  SurfaceAndFriction surface{.field = {"ct"},
                             .levels = {{.name = "skin", .value = -300.0, .strength_n = 0.8, .stiffness_n_per_m = 300.0},
                                        {.name = "bone", .value = 300.0, .strength_n = 1.7}},
                             .friction_coefficient = 0.1};
  scene.add("surface", surface);
  scene.add("inside", Viscosity{.field = {"ct"}, .strength_n = 0.05, .drag_ns_per_m = 1.0});
  scene.add("pull", GradientForce{.field = {"ct"}, .strength_n = 0.1});
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  return with_time(std::move(scene), data);
}

Scene stream(Data data, const FieldPtr& grid) {
  Scene scene({.stiffness_n_per_m = 500.0, .damping_ns_per_m = 0.1, .max_force_n = 20.0});
  Volume volume;
  volume.fields.push_back({"u", "", as(data, grid)});
  scene.add("flow", volume);
  scene.add("rail", Follow{.field = {"flow"}, .strength_n = 0.3});
  scene.add("air", Viscosity{.field = {"magnitude(flow)"}, .strength_n = 0.05, .drag_ns_per_m = 0.5});
  scene.add("tube", VortexPlane{.field = {"flow"}, .strength_n = 0.3});
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  return with_time(std::move(scene), data);
}

/// Onto the ball at a height, along its skin, in and out, and then at rest.
std::vector<Vec3> way_at(double height_m) {
  std::vector<Vec3> way_m;
  for (int i = 0; i < 900; ++i) {
    const double t = std::min(i, 700) * dt_s, turn = 3.0 * t;
    const double radius_m = 0.020 - 0.004 * std::min(1.0, 5.0 * t) + 0.003 * std::sin(18.0 * t) * t;
    const double flat_m = std::sqrt(std::max(0.0, radius_m * radius_m - height_m * height_m));
    way_m.push_back({flat_m * std::cos(turn), flat_m * std::sin(turn), 0.012 + height_m});
  }
  return way_m;
}
// Ahead of the data's end by half a spacing; in it; beyond.
constexpr double heights_m[] = {0.0, half_m - 0.012 - 0.5 * voxel_m, half_m - 0.012 - 1.5 * voxel_m, half_m - 0.012};

void expect_equal_ticks(const Scene& plain, const Scene& standing, double most_work, int& with_force) {
  for (const double height_m : heights_m) {
    Session one(plain), other(standing);
    for (const Vec3& x_m : way_at(height_m)) {
      const Tick a = one.tick({.position_m = x_m}, dt_s), b = other.tick({.position_m = x_m}, dt_s);
      ASSERT_EQ(a.force_n, b.force_n);
      ASSERT_EQ(a.proxy_m, b.proxy_m);
      ASSERT_EQ(a.sub_steps, b.sub_steps);
      ASSERT_EQ(a.energy.stored_j, b.energy.stored_j);
      ASSERT_EQ(b.energy.data_motion_j, 0.0);
      ASSERT_LE(b.work, most_work * a.work);
      ASSERT_EQ(one.events().size(), other.events().size());
      with_force += norm(a.force_n) > 0.0;
    }
  }
}

TEST(StandingData, AreFeltAsPlainOnesToTheBit) {
  const FieldPtr head = ball(), flow = sampled(*lamb_oseen_vortex(0.01, 0.05).fields[0].field, 40);
  int with_force = 0;
  for (const Data data : {Data::at_frame, Data::between_frames, Data::ended, Data::one_frame}) {
    SCOPED_TRACE(static_cast<int>(data));
    // Between two frames the values of both are counted, and half of their sum is exact.
    const bool between = data == Data::between_frames;
    expect_equal_ticks(scan(Data::plain, head), scan(data, head), between ? 2.0 : 1.0, with_force);
    expect_equal_ticks(stream(Data::plain, flow), stream(data, flow), between ? 3.0 : 1.0, with_force);
  }
  EXPECT_GT(with_force, 10000);
}

TEST(StandingData, AreFeltAsPlainOnesByATool) {
  const FieldPtr head = ball();
  const auto felt_by_pad = [&](Data data) {
    Scene scene = scan(data, head);
    scene.set(ToolOptions{.shape = ToolOptions::Shape::pad, .radius_m = 0.004, .points = 7, .share = 1.0 / 7.0});
    return scene;
  };
  int with_force = 0;
  for (const Data data : {Data::at_frame, Data::between_frames, Data::ended})
    expect_equal_ticks(felt_by_pad(Data::plain), felt_by_pad(data), 2.0, with_force);
  EXPECT_GT(with_force, 5000);
}

/// Calls of a still hand's ticks.
Calls at_rest(Data data, const FieldPtr& grid, double height_m, int& work) {
  Calls calls;
  const Scene scene = scan(data, std::make_shared<const Counted>(grid, calls));
  Session session(scene);
  const std::vector<Vec3> way_m = way_at(height_m);
  for (const Vec3& x_m : way_m) session.tick({.position_m = x_m}, dt_s);
  calls = {};
  work = 0;
  for (int i = 0; i < 100; ++i) work += session.tick({.position_m = way_m.back()}, dt_s).work;
  return calls;
}

TEST(StandingData, AreSampledAsOftenAsPlainOnesByAHandAtRest) {
  const FieldPtr grid = ball();
  for (const double height_m : heights_m) {
    int plain_work = 0;
    const Calls plain = at_rest(Data::plain, grid, height_m, plain_work);
    for (const Data data : {Data::at_frame, Data::between_frames, Data::ended, Data::one_frame}) {
      const int frames = data == Data::between_frames ? 2 : 1;
      int work = 0;
      const Calls calls = at_rest(data, grid, height_m, work);
      EXPECT_LE(work, plain_work);
      EXPECT_LE(calls.samples, frames * plain.samples);
      EXPECT_LE(calls.pieces, frames * plain.pieces);
      EXPECT_LE(calls.bounds, frames * plain.bounds);
      EXPECT_LE(calls.depths, frames * plain.depths);
    }
  }
}

// A wall rises in a second, under a hand at rest in front of it: what bounded the values before must not outlast its moment.
TEST(ChangingData, ReachAHandAtRest) {
  const auto wall_at = [](double z_m) {
    auto values = std::make_shared<std::vector<float>>();
    for (std::int64_t i = 0; i < n * n * n; ++i)
      values->push_back(static_cast<float>((z_m - (static_cast<double>(i / n / n) * voxel_m - half_m)) / voxel_m));
    const GridGeometry geometry{{n, n, n}, voxel_m * Mat3::identity(), {-half_m, -half_m, -half_m}};
    return smooth_grid_field(geometry, {VoxelType::float32, 1, {values, values->data()}});
  };
  Scene scene({.stiffness_n_per_m = 500.0, .damping_ns_per_m = 0.0});
  Volume volume;
  volume.fields.push_back({"wall", "", time_series({wall_at(0.0), wall_at(0.002)}, 1.0)});
  scene.add("wall", volume);
  scene.add("skin", SurfaceAndFriction{.field = {"wall"}, .levels = {{.name = "skin", .value = 0.0, .strength_n = 3.0}}});
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  scene.set(TimeOptions{TimeOptions::Play::once, 1.0, 0.0});
  Session session(scene);
  const Vec3 hand_m{0.001, 0.002, 0.001};
  for (int i = 0; i < 3000; ++i) {
    const Tick tick = session.tick({.position_m = hand_m}, dt_s);
    const double wall_m = 0.002 * std::min(1.0, i * dt_s);
    EXPECT_NEAR(tick.proxy_m.z, std::max(hand_m.z, wall_m), 1e-5) << i;
  }
}

}  // namespace standing_data_test
}  // namespace palpa
