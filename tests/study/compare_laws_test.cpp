// Earlier systems' laws against the exact law, on equal balances of whole scenes.
#include "palpa/study/compare_laws.h"

#include <gmock/gmock.h>

#include <numbers>

#include "palpa/data/analytic.h"
#include "palpa/mode/modes.h"
#include "study_fixture.h"

namespace palpa {
namespace compare_laws_test {

const std::vector<std::string> all_laws{"exact", "paper-2005", "ikits-2003", "ikits-2003-sequential", "no-proxy"};

enum : unsigned { surface = 1, rail = 2, second_rail = 4 };

/// Modes on a ball and in two vortices at an angle to each other.
Scene scene_of(unsigned modes) {
  Scene scene({.stiffness_n_per_m = 800, .damping_ns_per_m = 0.0});
  const FieldRef ball = scene.add("ball", sphere_field(0.05));
  const FieldRef flow = scene.add("flow", lamb_oseen_vortex());
  Similarity turned;
  turned.rotation = {{{1, 0, 0}, {0, std::cos(0.8), -std::sin(0.8)}, {0, std::sin(0.8), std::cos(0.8)}}};
  const FieldRef other = scene.add("other", lamb_oseen_vortex(), turned);
  if (modes & surface) {
    scene.add("surface", SurfaceAndFriction{
                             .field = ball, .levels = {{.name = "skin", .value = 0.0, .strength_n = 2.0}}, .friction_n = 0.2});
  }
  if (modes & rail) scene.add("rail", Follow{.field = flow, .strength_n = 0.6});
  if (modes & second_rail) scene.add("second", Follow{.field = other, .strength_n = 0.5});
  return scene;
}

/// Circles near the front of the ball, in and out of it.
std::vector<Probe> hand() {
  std::vector<Probe> probes;
  for (int i = 0; i < 3000; ++i) {
    const double t = i * 1e-3;
    const double turn = 2 * std::numbers::pi * t;
    probes.push_back({.position_m = {0.02 * std::cos(turn), 0.02 * std::sin(turn), 0.05 - 0.006 * std::sin(0.7 * turn)}});
  }
  return probes;
}

const LawErrors& of(const LawComparison& comparison, const std::string& law) {
  for (const LawErrors& errors : comparison.laws) {
    if (errors.law == law) return errors;
  }
  throw std::out_of_range(law);
}

TEST(CompareLaws, AgreeToRoundingWhereAllPrimitivesAreOrthogonal) {
  for (const unsigned modes : {surface, rail, second_rail}) {
    const LawComparison result = compare_laws(scene_of(modes), hand(), 1e-3, all_laws);
    EXPECT_EQ(result.ticks, 3000);
    EXPECT_GT(result.balances, 500);
    EXPECT_EQ(result.oblique_balances, 0);
    EXPECT_EQ(result.left_out, 0);
    for (const char* law : {"exact", "ikits-2003", "ikits-2003-sequential"}) {
      EXPECT_LE(of(result, law).posed_m.max, 1e-9) << law << " modes " << modes;
    }
  }
}

TEST(CompareLaws, ThatMoveAlongEachConstraintAreOffWhereTheyAreNot) {
  for (const unsigned modes : {surface | rail, rail | second_rail, surface | rail | second_rail}) {
    const LawComparison result = compare_laws(scene_of(modes), hand(), 1e-3, all_laws);
    EXPECT_GT(result.oblique_balances, 500) << modes;
    EXPECT_LE(of(result, "exact").posed_m.max, 1e-9);
    for (const char* law : {"paper-2005", "ikits-2003", "ikits-2003-sequential"}) {
      EXPECT_GT(of(result, law).posed_m.p99, 1e-5) << law << " modes " << modes;
      EXPECT_DOUBLE_EQ(of(result, law).posed_n.p99, 800 * of(result, law).posed_m.p99);
    }
    // Adding the moves of two constraints subtracts nothing for their overlap.
    EXPECT_GT(of(result, "ikits-2003").posed_m.p99, of(result, "ikits-2003-sequential").posed_m.p99) << modes;
  }
}

TEST(CompareLaws, TheExactOneByItselfFeelsTheSame) {
  Scene scene = scene_of(surface | rail);
  scene.set_law("no-proxy");  // the scene's own law does not count
  const LawComparison result = compare_laws(scene, hand(), 1e-3, all_laws);
  EXPECT_EQ(of(result, "exact").alone_m.max, 0.0);
  EXPECT_EQ(of(result, "exact").alone_mean_n, 0.0);
  EXPECT_GT(of(result, "ikits-2003").alone_m.p99, 0.0);
}

TEST(CompareLaws, CountsOnlyTicksWhoseProbeIsThere) {
  std::vector<Probe> probes = hand();
  for (std::size_t i = 0; i < probes.size(); i += 10) probes[i].valid = false;
  EXPECT_EQ(compare_laws(scene_of(rail), probes, 1e-3, all_laws).ticks, 2700);
  const LawComparison none = compare_laws(scene_of(rail), {}, 1e-3, all_laws);
  EXPECT_EQ(none.ticks, 0);
  EXPECT_EQ(none.balances, 0);
  EXPECT_THAT(to_markdown(none), testing::HasSubstr("| `no-proxy` | 0 | 0 |"));
}

TEST(CompareLaws, KnowsWhichPrimitivesAreOrthogonal) {
  const auto placed = [](PrimitiveKind kind, const Vec3& q) {
    return PlacedPrimitive{{kind, {}, {}, q, 1.0, 0.0}, {}, {}, {}};
  };
  using enum PrimitiveKind;
  const Vec3 x{1, 0, 0}, y{0, 1, 0};
  const Vec3 between = normalized(Vec3{1, 1, 0});
  struct Case {
    PlacedPrimitive a, b;
    bool oblique;
  };
  for (const Case& c : {Case{placed(plane, x), placed(plane, y), false}, Case{placed(plane, x), placed(plane, between), true},
                        Case{placed(plane, x), placed(line, x), false}, Case{placed(plane, x), placed(line, between), true},
                        Case{placed(line, x), placed(line, y), true}, Case{placed(point, {}), placed(plane, x), false},
                        Case{placed(directed, x), placed(point, {}), false}}) {
    const PlacedPrimitive both[] = {c.a, c.b};
    const PlacedPrimitive turned[] = {c.b, c.a};
    EXPECT_EQ(has_oblique_primitives(both), c.oblique);
    EXPECT_EQ(has_oblique_primitives(turned), c.oblique);
  }
}

TEST(CompareLaws, RefusesALawThatIsNone) {
  const std::vector<std::string> laws{"exactly"};
  EXPECT_THROW(compare_laws(scene_of(rail), hand(), 1e-3, laws), SceneError);
}

// ---- run and replay by the scene's law

class RunByLaw : public StudyTest, public testing::WithParamInterface<const char*> {};

TEST_P(RunByLaw, IsReplayedToTheByte) {
  RunOptions o = options("trace", 1.5);
  o.primitives = true;
  o.scene_options.sets = {{"law.method", GetParam()}};
  run(o);
  const ReplayResult again = replay(o.out);
  EXPECT_TRUE(again.difference.same) << again.difference.where;
  EXPECT_EQ(again.difference.ticks, 1500);
  const std::string method = GetParam();
  EXPECT_EQ(read(o.out / "balances.csv").find(",baseline,") != std::string::npos, method != "exact");
  EXPECT_EQ(read(o.out / "balances.csv").find(",exact,") != std::string::npos, method == "exact");
}

INSTANTIATE_TEST_SUITE_P(Laws, RunByLaw,
                         testing::Values("exact", "paper-2005", "ikits-2003", "ikits-2003-sequential", "no-proxy"),
                         [](const auto& i) {
                           std::string name = i.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace compare_laws_test
}  // namespace palpa
