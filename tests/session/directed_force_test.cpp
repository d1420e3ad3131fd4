// Directed forces in the tick: force on a still hand for any modes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "palpa/data/analytic.h"
#include "palpa/mode/modes.h"
#include "palpa/session/session.h"
#include "tests/session/hands.h"

namespace palpa {
namespace directed_force_test {

constexpr double dt = 1e-3;

// The worst of all data: a random force at every position, of up to 3 N.
struct Noise {
  static constexpr auto type = "test.noise";
  FieldRef field;
  double seed = 1;
  static constexpr auto parameters() {
    return std::tuple{param("field", &Noise::field, "where it is"), param("seed", &Noise::seed, "which noise", Range{0, 1e9})};
  }
  void place(const ModeContext& here, PrimitiveSink out) const noexcept {
    std::uint64_t bits[3];
    std::memcpy(bits, &here.at_m, sizeof bits);
    std::uint64_t h = static_cast<std::uint64_t>(seed) * 0x9e3779b97f4a7c15u;
    for (const std::uint64_t b : bits) h = (h ^ (b >> 20)) * 0xbf58476d1ce4e5b9u, h ^= h >> 31;
    const double a = static_cast<double>(h & 0xffff) / 0xffff, b = static_cast<double>(h >> 16 & 0xffff) / 0xffff;
    const double z = 2 * b - 1, r = std::sqrt(std::max(0.0, 1 - z * z));
    out.directed(0, {r * std::cos(6.28318 * a), r * std::sin(6.28318 * a), z},
                 3.0 * static_cast<double>(h >> 32 & 0xffff) / 0xffff);
  }
};

// d = −L (x − c): the balance is known.
struct Well {
  static constexpr auto type = "test.well";
  FieldRef field;
  double slope_n_per_m = 100;
  bool outwards = false;
  static constexpr auto parameters() {
    return std::tuple{param("field", &Well::field, "where it is"), param("slope", &Well::slope_n_per_m, "L", Range{0, 1e9}),
                      param("outwards", &Well::outwards, "pushes away instead")};
  }
  void place(const ModeContext& here, PrimitiveSink out) const noexcept {
    const Vec3 pull_n = (outwards ? slope_n_per_m : -slope_n_per_m) * here.at_m;
    if (norm(pull_n) > 0) out.directed(0, normalized(pull_n), norm(pull_n));
  }
};

// 2 N on one side, 0 on the other.
struct HalfSpace {
  static constexpr auto type = "test.half_space";
  FieldRef field;
  static constexpr auto parameters() { return std::tuple{param("field", &HalfSpace::field, "where it is")}; }
  void place(const ModeContext& here, PrimitiveSink out) const noexcept {
    if (here.at_m.x < 0) out.directed(0, {0, 1, 0}, 2.0);
  }
};

Scene scene_with_ball() {
  Scene scene({.stiffness_n_per_m = 600});
  scene.add("ball", sphere_field(0.05));
  scene.edit<Workspace>([&](auto& workspace) { workspace.scale = 1.0; });
  return scene;
}

TEST(DirectedForce, AStillHandComesToRestInAnyData) {
  test::Random random(4);
  for (int modes = 1; modes <= 3; ++modes) {
    Scene scene = scene_with_ball();
    for (int m = 0; m < modes; ++m) scene.add("noise" + std::to_string(m), Noise{.field = {"ball"}, .seed = m + 1.0});
    double worst_n = 0.0;
    for (int place = 0; place < 300; ++place) {
      Session session(scene);
      const Vec3 p = random.in_cube(0.04);
      Vec3 low{1e9, 1e9, 1e9}, high = -low;
      for (int i = 0; i < 220; ++i) {
        const Tick t = session.tick({.position_m = p + (i < 20 ? 0.0002 * (20 - i) : 0.0) * Vec3{1, 0, 0}}, dt);
        if (i < 180) continue;
        low = {std::min(low.x, t.force_n.x), std::min(low.y, t.force_n.y), std::min(low.z, t.force_n.z)};
        high = {std::max(high.x, t.force_n.x), std::max(high.y, t.force_n.y), std::max(high.z, t.force_n.z)};
      }
      worst_n = std::max(worst_n, norm(high - low));
    }
    EXPECT_LT(worst_n, 1e-6) << modes << " modes of noise";
  }
}

TEST(DirectedForce, BelowHalfTheStiffnessNothingIsHeldBack) {
  for (const double slope : {10.0, 100.0, 250.0, 299.0}) {
    Scene scene = scene_with_ball();
    scene.add("well", Well{.field = {"ball"}, .slope_n_per_m = slope});
    Session session(scene);
    test::Random random(5);
    const test::Wander hand(random, 0.03);
    for (int i = 0; i < 3000; ++i) {
      const Vec3 p = hand.at(0.2 * i * dt);
      const Tick t = session.tick({.position_m = p}, dt);
      for (const SessionEvent& event : session.events()) FAIL() << event.text << " at slope " << slope;
      // One sample at the middle of each move: the fixed point's error is of second order.
      if (i > 0) {
        EXPECT_LT(distance(t.proxy_m, 600.0 / (600.0 + slope) * p), 2e-4);
      }
    }
    Tick rest;
    const Vec3 p{0.01, 0.02, -0.01};
    for (int i = 0; i < 100; ++i) rest = session.tick({.position_m = p}, dt);
    EXPECT_LT(distance(rest.proxy_m, 600.0 / (600.0 + slope) * p), 1e-9);
  }
}

// The sum counts: one may be steeper than its share, and two may cancel.
TEST(DirectedForce, OfSeveralModesTheSumIsLimited) {
  for (const auto& [one, other] : {std::pair{250.0, 10.0}, std::pair{140.0, 140.0}, std::pair{2000.0, -1900.0}}) {
    Scene scene = scene_with_ball();
    scene.add("one", Well{.field = {"ball"}, .slope_n_per_m = one});
    scene.add("other", Well{.field = {"ball"}, .slope_n_per_m = std::abs(other), .outwards = other < 0});
    Session session(scene);
    const double slope = one + other;
    Tick t;
    for (int i = 0; i < 300; ++i) {
      const Vec3 p = std::min(1.0, i / 200.0) * Vec3{0.01, 0.02, -0.01};
      t = session.tick({.position_m = p}, dt);
      for (const SessionEvent& event : session.events()) FAIL() << event.text << " at " << one << " and " << other;
    }
    EXPECT_LT(distance(t.proxy_m, 600.0 / (600.0 + slope) * Vec3{0.01, 0.02, -0.01}), 1e-9) << one << " and " << other;
  }
}

TEST(DirectedForce, OneThatIsTooSteepIsToldOnceAndChangesByHalfTheStiffness) {
  Scene scene = scene_with_ball();
  scene.add("noise", Noise{.field = {"ball"}});
  Session session(scene);
  test::Random random(6);
  const test::Wander hand(random, 0.03);
  int told = 0;
  Vec3 before_n;
  double before_m = 0.0;
  for (int i = 0; i < 5000; ++i) {
    session.tick({.position_m = hand.at(i * dt)}, dt);
    for (const SessionEvent& event : session.events()) told += event.kind == SessionEventKind::warning;
    for (const SubStep& step : session.sub_steps()) {
      // The data are sampled between the start and the middle of a step towards its trial balance, which may lie as far as the
      // change of force allows: 3 N / k.
      const double path_m = before_m + distance(step.proxy_m, step.start_m) + 0.5 * norm(step.directed_n - before_n) / 600.0;
      if (i > 0) {
        ASSERT_LE(norm(step.directed_n - before_n), 300.0 * path_m + 0.5 * 3.0 / 4.0 + 1e-9);
      }
      before_n = step.directed_n;
      before_m = distance(step.proxy_m, step.start_m);
    }
  }
  EXPECT_EQ(told, 1);
}

// A mode that falls silent releases along the path, not at once.
TEST(DirectedForce, DoesNotVanishInOneTickWhereItsModeStops) {
  Scene scene = scene_with_ball();
  scene.add("half", HalfSpace{.field = {"ball"}});
  Session session(scene);
  Vec3 last_n;
  for (int i = 0; i <= 400; ++i) {
    const Tick t = session.tick({.position_m = {-0.02 + 1e-4 * i, 0, 0}}, dt);
    if (i > 0) {
      EXPECT_LT(norm(t.force_n - last_n), 300.0 * 3e-4) << "at x = " << t.proxy_m.x;
    }
    last_n = t.force_n;
  }
  EXPECT_LT(norm(last_n), 1e-6) << "in the end it is gone";
}

}  // namespace directed_force_test
}  // namespace palpa
