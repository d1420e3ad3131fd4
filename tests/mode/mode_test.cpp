// The contract of a mode: inputs, placed primitives, memory.
#include "palpa/mode/mode.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "palpa/data/analytic.h"
#include "palpa/mode/modes.h"
#include "tests/mode/resolved.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace mode_test {

// A scene's data for one mode: fields 0 (ball), 1 (vortex).
class AtHand : public testing::Test {
 protected:
  AtHand() { fields_ = {sphere_field(0.05).fields[0].field, lamb_oseen_vortex(0.02, 0.01).fields[0].field}; }

  // Places `mode` with the proxy at a hand position under this map; keeps the samples for the caller.
  template <class M>
  void place(const M& mode, const Vec3& proxy, const Similarity& map, const std::byte* memory = nullptr) {
    samples_ = std::make_unique<Samples>(fields_, map);
    ModeContext here(*samples_, proxy, masks_, read_);
    here.proxy_m = here.probe_m = proxy;
    here.time_step_s = 1e-3;
    here.stiffness_n_per_m = 800;
    here.finest_m = 1e-3;
    out_.clear(proxy);
    Mode any = mode;
    std::vector<std::byte> fresh(any.memory_bytes() + 1);
    any.start(fresh.data());
    any.place(here, memory ? memory : fresh.data(), out_);
  }

  std::vector<FieldPtr> fields_;
  std::vector<Mask> masks_;
  std::vector<std::int32_t> read_;
  std::unique_ptr<Samples> samples_;
  PrimitiveSet out_{16};
};

const FieldRef ball = test::resolved("ball", 0);
const FieldRef flow = test::resolved("flow", 1);

TEST_F(AtHand, SamplesAreOfTheHandFrame) {
  test::Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Similarity map{random.rotation(), random.uniform(0.1, 10), random.in_cube(0.01)};
    Samples samples(fields_, map);
    const Vec3 x = map.to_hand(random.in_cube(0.03));
    const auto value = [&](const Vec3& at) { return samples.scalar(0, at).value; };
    const auto vector = [&](const Vec3& at) { return samples.vector(1, at).value; };
    const ScalarSample s = samples.scalar(0, x);
    const VectorSample v = samples.vector(1, x);
    ASSERT_TRUE(s.inside && v.inside);
    const double h = 1e-6 / map.scale;
    const Vec3 d = random.direction();
    EXPECT_NEAR(dot(s.gradient, d) * map.length_to_hand(1.0),
                (value(x + h * d) - value(x - h * d)) / (2 * h) * map.length_to_hand(1.0), 1e-5);
    const Vec3 slope = (vector(x + h * d) - vector(x - h * d)) / (2 * h);
    EXPECT_NEAR(distance(v.jacobian * d, slope), 0.0, 1e-4 * (1 + norm(slope)));
    EXPECT_NEAR(norm(v.value), norm(fields_[1]->vector(map.to_world(x)).value), 1e-12) << "turned, not scaled";
  }
}

TEST_F(AtHand, StrengthsFadeNoSteeperThanHalfTheStiffness) {
  read_ = {0};
  for (double x = 0.0; x < 0.08; x += 1e-4) {
    place(Viscosity{.field = ball, .strength_n = 3.0}, {x, 0, 0}, {});
    const double depth = fields_[0]->depth_m({x, 0, 0});
    const double expected = depth > 0 ? std::min(3.0, 400 * depth) : 0.0;
    ASSERT_EQ(out_.size(), 1u);
    EXPECT_NEAR(out_[0].strength_n, expected, 1e-12);
  }
}

TEST_F(AtHand, MasksMultiplyAndOutsideTheirDataNothingIsFelt) {
  read_ = {0};
  masks_ = {{ball, TransferFunction({{0.0, 0.0}, {0.02, 1.0}}, 1.0)}, {ball, TransferFunction({{-1, 0.5}, {1, 0.5}})}};
  place(Viscosity{.strength_n = 2.0, .drag_ns_per_m = 4.0}, {0.04, 0, 0}, {});  // 10 mm deep: 0.5 · 0.5
  EXPECT_NEAR(out_[0].strength_n, 0.5, 1e-12);
  EXPECT_NEAR(out_[0].drag_ns_per_m, 1.0, 1e-12);
  place(Viscosity{.strength_n = 2.0}, {0.2, 0, 0}, {});
  EXPECT_EQ(out_[0].strength_n, 0.0);
}

TEST_F(AtHand, AStrengthOfAFieldIsItsTransferFunction) {
  place(Viscosity{.strength_n = {ball, TransferFunction({{0.0, 0.0}, {0.05, 5.0}})}}, {0.03, 0, 0}, {});
  EXPECT_NEAR(out_[0].strength_n, 2.0, 1e-12);
}

TEST_F(AtHand, FollowPlacesALineAlongTheFieldWhicheverItsSign) {
  const Similarity map{Mat3::identity(), 2.0, {}};
  place(Follow{.field = flow, .strength_n = 0.7}, {0.01, 0, 0}, map);
  ASSERT_EQ(out_.size(), 1u);
  EXPECT_EQ(out_[0].kind, PrimitiveKind::line);
  EXPECT_NEAR(std::abs(out_[0].direction.y), 1.0, 1e-12);
  EXPECT_EQ(out_[0].position_m, (Vec3{0.01, 0, 0}));
  place(Follow{.field = flow, .strength_n = 0.7}, {}, map);
  EXPECT_TRUE(out_.empty()) << "no direction where the field is zero";
}

TEST_F(AtHand, ALevelIsPlacedOnlyOnceItHasBeenMet) {
  const SurfaceAndFriction mode{.field = ball, .levels = {{.value = 0.0, .strength_n = 2.0, .friction_n = 0.3}}};
  place(mode, {0, 0, 0.0498}, {});
  EXPECT_TRUE(out_.empty());
  const SurfaceAndFriction::Memory met{.shells = {{{.level = 0}}}};
  place(mode, {0, 0, 0.0498}, {}, reinterpret_cast<const std::byte*>(&met));
  ASSERT_EQ(out_.size(), 2u);
  EXPECT_NEAR(distance(out_[0].position_m, {0, 0, 0.05}), 0.0, 1e-12) << "one Newton step back to the level";
  EXPECT_NEAR(distance(out_[0].direction, {0, 0, 1}), 0.0, 1e-12) << "outwards: high values are solid";
  EXPECT_EQ(out_.captured(0).value, 0.0);
  EXPECT_EQ(out_[1].kind, PrimitiveKind::line);
  EXPECT_EQ(out_[1].position_m, (Vec3{0, 0, 0.0498})) << "friction passes through the proxy";
}

TEST_F(AtHand, CoulombFrictionNamesItsPlane) {
  const SurfaceAndFriction mode{.field = ball, .levels = {{.value = 0.0, .strength_n = 2.0}}, .friction_coefficient = 0.4};
  const SurfaceAndFriction::Memory met{.shells = {{{.level = 0}}}};
  place(mode, {0, 0, 0.0498}, {}, reinterpret_cast<const std::byte*>(&met));
  ASSERT_EQ(out_.size(), 2u);
  EXPECT_EQ(out_.friction_of(1).plane, 0);
  EXPECT_EQ(out_.friction_of(1).coefficient, 0.4);
}

TEST_F(AtHand, MaterialIsASurfaceWhereverTheProxyIs) {
  const SurfaceAndFriction mode{.field = ball, .strength_n = {ball, TransferFunction({{0.0, 0.0}, {0.01, 1.0}})}};
  place(mode, {0, 0, 0.045}, {});
  ASSERT_EQ(out_.size(), 1u);
  EXPECT_EQ(out_[0].position_m, (Vec3{0, 0, 0.045}));
  EXPECT_NEAR(out_[0].strength_n, 0.5, 1e-12);
  EXPECT_NEAR(out_.captured(0).value, 0.005, 1e-15);
}

TEST(SurfaceAndFriction, SaysWhatDoesNotFitTogether) {
  using S = SurfaceAndFriction;
  EXPECT_THAT((S{.field = ball}.problem()), testing::HasSubstr("neither levels nor strength_n"));
  EXPECT_THAT((S{.field = ball, .levels = {{.value = 1.0}}, .strength_n = 1.0}.problem()), testing::HasSubstr("both"));
  EXPECT_THAT((S{.field = ball, .levels = {{.value = 1.0}}, .friction_n = 1.0, .friction_coefficient = 1.0}.problem()),
              testing::HasSubstr("both"));
  EXPECT_EQ((S{.field = ball, .levels = {{.value = 1.0}}}.problem()), "");
}

TEST(Mode, IsAValue) {
  Mode a = Follow{.field = flow, .strength_n = 0.7};
  Mode b = a;
  struct Rename final : ParameterVisitor {
    void field(const ParameterInfo&, FieldRef& ref) override { ref.name = "other"; }
  } rename;
  b.visit(rename);
  EXPECT_EQ(a.as<Follow>()->field.name, "flow");
  EXPECT_EQ(b.as<Follow>()->field.name, "other");
  EXPECT_EQ(a.as<Viscosity>(), nullptr);
}

TEST(ModeCatalog, KnowsTheModesByTypeAndEachOnce) {
  ModeCatalog catalog = standard_modes();
  for (const char* type : {"surface_and_friction", "follow", "viscosity"}) ASSERT_NE(catalog.find(type), nullptr);
  EXPECT_EQ(catalog.find("lab.ridge"), nullptr);
  EXPECT_THROW(catalog.add(Follow{}), std::invalid_argument);
}

TEST(Parameters, OfEveryModeAreNamedExplainedAndCarryTheirUnit) {
  struct Check final : ParameterVisitor {
    void check(const ParameterInfo& info) {
      EXPECT_FALSE(info.name.empty());
      EXPECT_GT(info.sentence.size(), 10u) << info.name;
      ++seen;
    }
    static bool has_unit(std::string_view name) {
      return name.ends_with("_n") || name.ends_with("_m") || name.ends_with("_s") || name.ends_with("_ns_per_m") ||
             name.ends_with("_coefficient") || name.ends_with("_ratio");
    }
    void number(const ParameterInfo& info, double&) override {
      check(info);
      EXPECT_TRUE(has_unit(info.name) || info.kind == ParameterKind::level) << info.name;
    }
    void optional_number(const ParameterInfo& info, std::optional<double>&) override {
      check(info);
      EXPECT_TRUE(has_unit(info.name)) << info.name;
    }
    void strength(const ParameterInfo& info, Strength&) override {
      check(info);
      EXPECT_TRUE(info.name.ends_with("_n")) << info.name;
    }
    void flag(const ParameterInfo& info, bool&) override { check(info); }
    void text(const ParameterInfo& info, std::string&) override { check(info); }
    void choice(const ParameterInfo& info, int&) override { check(info); }
    void field(const ParameterInfo& info, FieldRef&) override { check(info); }
    void list(const ParameterInfo& info, ParameterList& list) override {
      check(info);
      list.visit_default(*this);
    }
    int seen = 0;
  } check;
  for (Mode mode : standard_modes().modes()) {
    EXPECT_FALSE(mode.summary().empty());
    mode.visit(check);
  }
  EXPECT_GT(check.seen, 15);
}

}  // namespace mode_test
}  // namespace palpa
