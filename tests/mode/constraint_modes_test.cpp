// Front shape, transverse damping, and noise weights of modes with gradient directions: their primitives.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "palpa/mode/modes.h"
#include "palpa/mode/placement.h"
#include "tests/mode/placed.h"
#include "tests/mode/resolved.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace constraint_modes_test {

const FieldRef first = test::resolved("first", 0);

/// A field that is a formula everywhere within a metre.
class Everywhere final : public Field {
 public:
  explicit Everywhere(std::function<Vec3(const Vec3&)> velocity) : velocity_(std::move(velocity)) {}
  explicit Everywhere(std::function<ScalarSample(const Vec3&)> scalar) : scalar_(std::move(scalar)) {}
  int components() const noexcept override { return scalar_ ? 1 : 3; }
  ScalarSample scalar(const Vec3& x) const noexcept override { return scalar_ ? scalar_(x) : ScalarSample{}; }
  VectorSample vector(const Vec3& x) const noexcept override {
    return velocity_ ? VectorSample{velocity_(x), {}, true} : VectorSample{};
  }
  double spacing_m() const noexcept override { return 1e-3; }
  Box bounds_m() const noexcept override { return {{-1, -1, -1}, {1, 1, 1}}; }
  double depth_m(const Vec3&) const noexcept override { return 1.0; }
  std::vector<ValueRange> value_ranges() const override { return {{-1, 1}, {-1, 1}, {-1, 1}}; }

 private:
  std::function<Vec3(const Vec3&)> velocity_;
  std::function<ScalarSample(const Vec3&)> scalar_;
};

/// φ = steepness · z.
FieldPtr slope(double steepness) {
  return std::make_shared<Everywhere>([=](const Vec3& x) { return ScalarSample{steepness * x.z, {0, 0, steepness}, true}; });
}

using test::Place;

TEST(FrontShape, IsAPlaneAtTheProxyWhoseFreeSideIsDownstream) {
  test::Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Vec3 flow = std::exp(random.uniform(-5, 5)) * random.direction(), at = random.in_cube(0.05);
    Place place(std::make_shared<Everywhere>([=](const Vec3&) { return flow; }), at);
    const PrimitiveSet& set = place.of(FrontShape{.field = first, .strength_n = 0.7, .drag_ns_per_m = 2.0});
    ASSERT_EQ(set.size(), 1u);
    EXPECT_EQ(set.dropped(), 0);
    EXPECT_EQ(set[0].kind, PrimitiveKind::plane);
    EXPECT_EQ(set[0].position_m, at);
    EXPECT_LT(norm(set[0].direction - normalized(flow)), 1e-12);
    EXPECT_EQ(set[0].strength_n, 0.7);
    EXPECT_EQ(set[0].drag_ns_per_m, 2.0);
    EXPECT_EQ(residual(set[0], at + 1e-3 * normalized(flow)), Vec3{}) << "with the flow it is free";
    EXPECT_NEAR(norm(residual(set[0], at - 1e-3 * normalized(flow))), 1e-3, 1e-12) << "against it, it holds";
  }
}

TEST(TransverseDamping, IsALineAlongTheFieldWithDragAcrossOnly) {
  test::Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Vec3 flow = random.direction(), at = random.in_cube(0.05);
    Place place(std::make_shared<Everywhere>([=](const Vec3&) { return flow; }), at);
    const PrimitiveSet& set = place.of(TransverseDamping{.field = first, .drag_ns_per_m = 3.0});
    ASSERT_EQ(set.size(), 1u);
    EXPECT_EQ(set[0].kind, PrimitiveKind::line);
    EXPECT_EQ(set[0].strength_n, 0.0);
    EXPECT_EQ(set[0].drag_ns_per_m, 3.0);
    EXPECT_LT(norm(residual(set[0], at + 1e-3 * flow)), 1e-15);
  }
  EXPECT_NE((TransverseDamping{.drag_ns_per_m = 0.0}).problem(), "");
  EXPECT_EQ((TransverseDamping{.drag_ns_per_m = 0.0, .strength_n = 0.5}).problem(), "");
}

TEST(VectorModes, AreSilentWhereTheFieldIsZero) {
  const auto still = std::make_shared<Everywhere>([](const Vec3&) { return Vec3{}; });
  Place place(still, {});
  EXPECT_TRUE(place.of(FrontShape{.field = first}).empty());
  EXPECT_TRUE(place.of(TransverseDamping{.field = first}).empty());
}

// w = 0 up to the noise, 1 from three times it on, smooth and increasing between; per metre of the world, under any map.
TEST(NoiseWeight, GoesFromNothingToAllBetweenOneAndThreeTimesTheNoise) {
  for (const double scale : {1e-3, 1.0, 1e4}) {
    const Similarity map{Mat3::identity(), scale, {}};
    double before = 0.0;
    for (double ratio = 0.0; ratio <= 4.0; ratio += 0.01) {
      Place place(slope(20.0 * ratio), {}, map);
      const double w = detail::gradient_weight(place.here(), place.here().scalar(first).gradient, 20.0);
      if (ratio <= 1.0) {
        EXPECT_EQ(w, 0.0);
      }
      if (ratio >= 3.0) {
        EXPECT_EQ(w, 1.0);
      }
      EXPECT_GE(w, before);
      EXPECT_LT(w - before, 0.01) << "no jump";
      before = w;
    }
    Place place(slope(1e-9), {}, map);
    EXPECT_EQ(detail::gradient_weight(place.here(), place.here().scalar(first).gradient, 0.0), 1.0) << "0 switches it off";
  }
}

TEST(NoiseWeight, FadesPullsAndSurfacesAlike) {
  SurfaceAndFriction surface{.field = first, .levels = {{.value = 0, .strength_n = 2.0}}, .friction_n = 0.5};
  surface.noise_per_m = 10.0;
  const GradientForce pull{.field = first, .strength_n = 1.0, .noise_per_m = 10.0};
  const SurfaceAndFriction::Memory on_level{.shells = {{{.level = 0}}}};
  for (const double ratio : {0.5, 1.5, 2.0, 2.5, 5.0}) {
    const double w = detail::smooth_step(ratio, 1.0, 3.0);
    Place a(slope(10.0 * ratio), {}), b(slope(10.0 * ratio), {});
    const PrimitiveSet& plane_and_line = a.of(surface, on_level);
    ASSERT_EQ(plane_and_line.size(), 2u);
    EXPECT_NEAR(plane_and_line[0].strength_n, 2.0 * w, 1e-12);
    EXPECT_NEAR(plane_and_line[1].strength_n, 0.5 * w, 1e-12);
    const PrimitiveSet& force = b.of(pull);
    ASSERT_EQ(force.size(), 1u);
    EXPECT_NEAR(force[0].strength_n, w, 1e-12);
  }
}

TEST(NoiseWeight, LeavesAPointInTheSolidWhereNoSurfaceIs) {
  SurfaceAndFriction shells{.field = first, .levels = {{.value = 0, .strength_n = 2.0}}};
  shells.noise_per_m = 10.0;
  shells.flat_strength_n = 0.4;
  SurfaceAndFriction material{.field = first, .strength_n = {first, TransferFunction({{-1, 1}, {1, 1}})}};
  material.noise_per_m = 10.0;
  material.flat_strength_n = 0.4;

  for (const double z : {-0.01, 0.01}) {
    Place shell_place(slope(1.0), {0, 0, z}), material_place(slope(1.0), {0, 0, z});
    const PrimitiveSet& of_shells = shell_place.of(shells, SurfaceAndFriction::Memory{});
    if (z < 0) {
      EXPECT_TRUE(of_shells.empty()) << "in the open nothing is felt";
    } else {
      ASSERT_EQ(of_shells.size(), 1u);
      EXPECT_EQ(of_shells[0].kind, PrimitiveKind::point);
      EXPECT_EQ(of_shells[0].position_m, (Vec3{0, 0, z}));
      EXPECT_NEAR(of_shells[0].strength_n, 0.4, 1e-12);
    }
    const PrimitiveSet& of_material = material_place.of(material, SurfaceAndFriction::Memory{});
    ASSERT_EQ(of_material.size(), 2u);
    EXPECT_EQ(of_material[0].kind, PrimitiveKind::point);
    EXPECT_EQ(of_material[1].strength_n, 0.0);
  }
  Place steep(slope(100.0), {0, 0, 0.01});
  EXPECT_TRUE(steep.of(shells, SurfaceAndFriction::Memory{}).empty()) << "where it is steep the surface says it all";
}

TEST(SurfaceAndFriction, SaysWhatDoesNotFitWithFlatStrength) {
  SurfaceAndFriction mode{.field = first, .levels = {{.value = 0}}};
  mode.flat_strength_n = 0.4;
  EXPECT_NE(mode.problem(), "") << "without noise";
  mode.noise_per_m = 1.0;
  EXPECT_EQ(mode.problem(), "");
  mode.solid = SurfaceAndFriction::Solid::both;
  EXPECT_NE(mode.problem(), "") << "no side is solid";
}

}  // namespace constraint_modes_test
}  // namespace palpa
