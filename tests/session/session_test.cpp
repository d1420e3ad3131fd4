// The tick on analytic data.
#include "palpa/session/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <map>
#include <numbers>

#include "palpa/data/analytic.h"
#include "palpa/data/grid.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "tests/session/hands.h"

namespace palpa {
namespace session_test {

constexpr double dt = 1e-3;

// One hand metre is one world metre, origins together: hand and world positions are equal.
Workspace plain_workspace() {
  Workspace workspace;
  workspace.scale = 1.0;
  workspace.center_m = Vec3{};
  workspace.towards_user = "+z";
  workspace.up = "+y";
  return workspace;
}

Scene plain_scene(CouplingOptions coupling) {
  Scene scene(coupling);
  scene.set(plain_workspace());
  return scene;
}

Scene ball(double strength_n, double friction_n = 0.0, double friction_coefficient = 0.0, double k = 800) {
  Scene scene = plain_scene({.stiffness_n_per_m = k});
  const FieldRef field = scene.add("ball", sphere_field(0.05));
  scene.add("surface", SurfaceAndFriction{.field = field,
                                          .levels = {{.name = "skin", .value = 0.0, .strength_n = strength_n}},
                                          .friction_n = friction_n,
                                          .friction_coefficient = friction_coefficient});
  return scene;
}

// Moves straight from a to b in steps of at most 0.2 mm; returns the last tick.
Tick stroke(Session& session, const Vec3& a, const Vec3& b, double speed_m_per_s = 0.2) {
  const int n = std::max(1, static_cast<int>(std::ceil(distance(a, b) / (speed_m_per_s * dt))));
  Tick tick;
  for (int i = 1; i <= n; ++i) tick = session.tick({.position_m = a + (static_cast<double>(i) / n) * (b - a)}, dt);
  return tick;
}

int count(const Session& session, SessionEventKind kind) {
  int n = 0;
  for (const SessionEvent& event : session.events()) n += event.kind == kind;
  return n;
}

TEST(Tick, IsTheProbeItselfWithoutPrimitivesAndItsForceExactlyZero) {
  Scene scene = plain_scene({.stiffness_n_per_m = 800, .damping_ns_per_m = 1.0});
  const FieldRef field = scene.add("ball", sphere_field(0.05));
  scene.add("surface", SurfaceAndFriction{.field = field, .levels = {{.value = 0.0, .strength_n = 2.0}}});
  Session session(scene);
  test::Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = random.direction() * random.uniform(0.06, 0.2);  // jumps anywhere outside … and through: see below
    session.reset();
    Tick tick = session.tick({.position_m = p}, dt);
    tick = session.tick({.position_m = 1.01 * p}, dt);
    EXPECT_EQ(tick.proxy_m, 1.01 * p);
    EXPECT_EQ(tick.force_n, Vec3{});
    EXPECT_EQ(tick.status, TickStatus::complete);
  }
}

TEST(Surface, HoldsTheProxyOnTheLevelUntilStiffnessTimesDepthIsTheStrength) {
  for (const double strength : {0.5, 2.0, 4.0}) {
    Session session(ball(strength));
    const double k = 800;
    stroke(session, {0, 0, 0.08}, {0, 0, 0.0501});
    const double depth = 0.98 * strength / k;
    const Tick held = stroke(session, {0, 0, 0.0501}, {0, 0, 0.05 - depth}, 0.05);
    EXPECT_NEAR(held.proxy_m.z, 0.05, 1e-9);
    EXPECT_NEAR(held.force_n.z, k * depth, 1e-5);
    EXPECT_NEAR(norm(held.force_n - Vec3{0, 0, held.force_n.z}), 0.0, 1e-9);
    const Tick through = stroke(session, {0, 0, 0.05 - depth}, {0, 0, 0.05 - 1.1 * strength / k}, 0.01);
    EXPECT_NEAR(norm(through.force_n), 0.0, 1e-12) << "the shell lets go";
  }
}

TEST(Surface, TellsOnsetAndBreakThroughOnce) {
  Session session(ball(1.0));
  int onsets = 0, break_throughs = 0;
  for (double z = 0.08; z > 0.03; z -= 1e-4) {
    session.tick({.position_m = {0, 0, z}}, dt);
    onsets += count(session, SessionEventKind::onset);
    break_throughs += count(session, SessionEventKind::break_through);
    if (break_throughs) {
      EXPECT_EQ(onsets, 1) << "first met, then pressed through";
    }
  }
  EXPECT_EQ(onsets, 1);
  EXPECT_EQ(break_throughs, 1);
}

TEST(Surface, IsOneSidedAndMetAgainAfterLeaving) {
  Session session(ball(1.0));
  stroke(session, {0, 0, 0.08}, {0, 0, 0.03});
  const Tick inside = stroke(session, {0, 0, 0.03}, {0, 0, 0.07});
  EXPECT_EQ(inside.force_n, Vec3{}) << "nothing holds on the way out";
  const Tick again = stroke(session, {0, 0, 0.07}, {0, 0, 0.0495});
  EXPECT_NEAR(again.force_n.z, 0.4, 1e-6) << "and it is there again";
}

TEST(Surface, OfALowSolidHoldsFromInside) {
  Scene scene = plain_scene({.stiffness_n_per_m = 800});
  const FieldRef field = scene.add("ball", sphere_field(0.05));
  scene.add("wall",
            SurfaceAndFriction{
                .field = field, .solid = SurfaceAndFriction::Solid::low, .levels = {{.value = 0.0, .strength_n = 3.0}}});
  Session session(scene);
  const Tick tick = stroke(session, {0, 0, 0.02}, {0.0515, 0, 0});
  EXPECT_NEAR(norm(tick.proxy_m), 0.05, 1e-7);
  EXPECT_NEAR(tick.force_n.x, -1.2, 1e-2);
}

TEST(Surface, OfBothSidesHoldsEither) {
  Scene scene = plain_scene({.stiffness_n_per_m = 800});
  const FieldRef field = scene.add("ball", sphere_field(0.05));
  scene.add("skin",
            SurfaceAndFriction{
                .field = field, .solid = SurfaceAndFriction::Solid::both, .levels = {{.value = 0.0, .strength_n = 3.0}}});
  Session from_outside(scene);
  EXPECT_GT(stroke(from_outside, {0, 0, 0.08}, {0, 0, 0.049}).force_n.z, 0.7);
  Session from_inside(scene);
  EXPECT_LT(stroke(from_inside, {0, 0, 0.02}, {0, 0, 0.051}).force_n.z, -0.7);
}

TEST(Surface, ShellsAreMetOneByOne) {
  Scene scene = plain_scene({.stiffness_n_per_m = 1000});
  const FieldRef field = scene.add("ball", sphere_field(0.05));
  scene.add("shells", SurfaceAndFriction{.field = field,
                                         .levels = {{.name = "outer", .value = 0.0, .strength_n = 0.5},
                                                    {.name = "middle", .value = 0.005, .strength_n = 1.0},
                                                    {.name = "inner", .value = 0.010, .strength_n = 2.0}}});
  Session session(scene);
  std::vector<double> met, broken;
  double largest = 0.0;
  for (double z = 0.07; z > 0.03; z -= 2e-5) {
    const Tick tick = session.tick({.position_m = {0, 0, z}}, dt);
    largest = std::max(largest, norm(tick.force_n));
    for (const SessionEvent& event : session.events()) {
      if (event.kind == SessionEventKind::onset) met.push_back(event.value);
      if (event.kind == SessionEventKind::break_through) broken.push_back(event.value);
    }
  }
  EXPECT_EQ(met, (std::vector<double>{0.0, 0.005, 0.010}));
  EXPECT_EQ(broken, met);
  EXPECT_NEAR(largest, 2.0, 0.03);
}

TEST(Surface, StaysOnTheSphereRoundManyTurns) {  // no drift of π v T per turn
  Session session(ball(5.0));
  const double depth = 1e-3, speed = 0.4, radius = 0.05;
  stroke(session, {0, 0, 0.06}, {0, 0, radius - depth});
  double worst = 0.0;
  const int per_turn = static_cast<int>(2 * std::numbers::pi * radius / (speed * dt));
  for (int i = 0; i <= 3 * per_turn; ++i) {
    const double a = 2 * std::numbers::pi * i / per_turn;
    const Tick tick = session.tick({.position_m = {(radius - depth) * std::sin(a), 0, (radius - depth) * std::cos(a)}}, dt);
    worst = std::max(worst, std::abs(norm(tick.proxy_m) - radius));
    EXPECT_EQ(tick.status, TickStatus::complete);
  }
  EXPECT_LT(worst, 1e-6);
}

TEST(Friction, SticksIffInsideItsDisc) {
  test::Random random(5);
  for (int i = 0; i < 200; ++i) {
    const bool coulomb = i % 2 == 0;
    const double k = 800, normal_n = random.uniform(0.3, 3.0);
    const double limit_n = coulomb ? 0.4 * normal_n : 0.3;
    const double share = i % 4 < 2 ? random.uniform(0.1, 0.97) : random.uniform(1.03, 4.0);
    Scene scene = plain_scene({.stiffness_n_per_m = k});
    const FieldRef field = scene.add("floor", plane_field(0.2));
    scene.add("floor", SurfaceAndFriction{.field = field,
                                          .levels = {{.value = 0.0, .strength_n = 8.0}},
                                          .friction_n = coulomb ? 0.0 : 0.3,
                                          .friction_coefficient = coulomb ? 0.4 : 0.0});
    Session session(scene);
    const double depth = normal_n / k;
    const Tick touched = stroke(session, {0, 0, 0.01}, {0, 0, -depth}, 0.02);
    ASSERT_NEAR(touched.force_n.z, normal_n, 1e-6);
    const double angle = random.uniform(0, 6.28);
    const Vec3 aside{std::cos(angle), std::sin(angle), 0};
    const Vec3 at{touched.proxy_m.x, touched.proxy_m.y, -depth};
    const Tick pulled = session.tick({.position_m = at + (share * limit_n / k) * aside}, dt);
    const double moved = distance(pulled.proxy_m, touched.proxy_m);
    const double tangential_n = norm(pulled.force_n - Vec3{0, 0, pulled.force_n.z});
    if (share < 1.0) {
      EXPECT_NEAR(moved, 0.0, 1e-12);
      EXPECT_NEAR(tangential_n, share * limit_n, 1e-9);
    } else {
      EXPECT_GT(moved, 0.0);
      EXPECT_NEAR(tangential_n, limit_n, 1e-9);
    }
  }
}

TEST(Viscosity, TrueGivesForceInProportionToSpeedAndCoulombDoesNot) {
  for (const double speed : {0.02, 0.1, 0.4}) {
    Scene scene({.stiffness_n_per_m = 500});
    scene.add("air", Viscosity{.drag_ns_per_m = 3.0});
    Session session(scene);
    const Tick tick = stroke(session, {}, {0.1, 0, 0}, speed);
    EXPECT_NEAR(tick.force_n.x, -3.0 * speed, 1e-9) << "f = c v";

    Scene coulomb({.stiffness_n_per_m = 500});
    coulomb.add("air", Viscosity{.strength_n = 0.7});
    Session dry(coulomb);
    EXPECT_NEAR(stroke(dry, {}, {0.1, 0, 0}, speed).force_n.x, -0.7, 1e-12);
  }
}

TEST(Follow, HoldsAcrossTheFieldAndLetsGoAlongIt) {
  Scene scene = plain_scene({.stiffness_n_per_m = 500});
  const FieldRef flow = scene.add("flow", lamb_oseen_vortex(0.02, 0.01));
  scene.add("rail", Follow{.field = flow, .strength_n = 1.0});
  Session session(scene);
  // Round the vortex with the hand: the proxy stays on its circle within 1 % of the drift of a one-step scheme, π · step length
  // per turn.
  const double radius = 0.02, speed = 0.1;
  const int per_turn = static_cast<int>(2 * std::numbers::pi * radius / (speed * dt));
  session.tick({.position_m = {radius, 0, 0}}, dt);
  Tick tick;
  for (int i = 1; i <= per_turn; ++i) {
    const double a = 2 * std::numbers::pi * i / per_turn;
    tick = session.tick({.position_m = {radius * std::cos(a), radius * std::sin(a), 0}}, dt);
  }
  EXPECT_NEAR(norm(tick.proxy_m), radius, 0.05 * std::numbers::pi * speed * dt);
  // Across: held up to strength/k.
  const Vec3 out = normalized(tick.proxy_m);
  const Tick pulled = session.tick({.position_m = tick.proxy_m + (0.9 / 500) * out}, dt);
  EXPECT_NEAR(distance(pulled.proxy_m, tick.proxy_m), 0.0, 1e-5);
  EXPECT_NEAR(norm(pulled.force_n), 0.9, 1e-2);
}

// A ball far from any edge of data, so that no strength fades: a strength never exceeds k/2 × the depth in the data.
class EndlessBall final : public Field {
 public:
  int components() const noexcept override { return 1; }
  ScalarSample scalar(const Vec3& x) const noexcept override { return {0.05 - norm(x), -normalized(x), true}; }
  double spacing_m() const noexcept override { return 1e-3; }
  Box bounds_m() const noexcept override { return {{-10, -10, -10}, {10, 10, 10}}; }
  double depth_m(const Vec3&) const noexcept override { return 10.0; }
  std::vector<ValueRange> value_ranges() const override { return {{-17.0, 0.05}}; }
};

Scene unbreakable_ball() {
  Scene scene = plain_scene({.stiffness_n_per_m = 800});
  Volume volume;
  volume.fields.push_back({"ball", "", std::make_shared<EndlessBall>()});
  const FieldRef field = scene.add("ball", volume);
  scene.add("surface", SurfaceAndFriction{.field = field, .levels = {{.value = 0.0, .strength_n = 1000.0}}});
  return scene;
}

TEST(Path, DoesNotDependOnSpeed) {
  std::vector<Vec3> ends;
  for (const double speed : {0.02, 0.1, 0.5}) {
    Session session(ball(3.0, 0.2));
    stroke(session, {0.01, 0, 0.07}, {0.01, 0, 0.048}, speed);
    ends.push_back(stroke(session, {0.01, 0, 0.048}, {-0.015, 0.01, 0.046}, speed).proxy_m);
  }
  EXPECT_NEAR(distance(ends[0], ends[1]), 0.0, 2e-5);
  EXPECT_NEAR(distance(ends[1], ends[2]), 0.0, 2e-4);
}

TEST(Path, NeverJumpsOverAStrongSurface) {
  test::Random random(7);
  for (int i = 0; i < 300; ++i) {
    Session session(unbreakable_ball());
    const Vec3 from = 0.12 * random.direction();
    const Vec3 to = random.in_cube(0.03);
    const double speed = random.uniform(0.1, 10.0);
    Tick tick;
    const int n = std::max(1, static_cast<int>(distance(from, to) / (speed * dt)));
    for (int j = 0; j <= n + 40; ++j) {
      tick = session.tick({.position_m = from + (std::min(j, n) / static_cast<double>(n)) * (to - from)}, dt);
      ASSERT_GE(norm(tick.proxy_m), 0.05 - 1e-5) << "stroke " << i << " at " << speed << " m/s";
    }
  }
}

TEST(Path, AtTheCapTheRestIsWalkedInLaterTicks) {
  Session session(unbreakable_ball());
  session.tick({.position_m = {0, 0.02, 0.1}}, dt);
  Tick tick = session.tick({.position_m = {0, 0.02, -0.1}}, dt);  // 200 m/s through the ball
  EXPECT_EQ(tick.status, TickStatus::waiting);
  EXPECT_EQ(tick.sub_steps, Session::max_sub_steps);
  EXPECT_TRUE(is_finite(tick.force_n));
  for (int i = 0; i < 400 && tick.status == TickStatus::waiting; ++i) tick = session.tick({.position_m = {0, 0.02, -0.1}}, dt);
  EXPECT_NE(tick.status, TickStatus::waiting);
  EXPECT_GE(norm(tick.proxy_m), 0.05 - 1e-5);
}

TEST(Rest, AStillHandIsAStillProxy) {
  test::Random random(9);
  for (int i = 0; i < 200; ++i) {
    Session session(ball(3.0, 0.1));
    const Vec3 outside = 0.07 * random.direction();
    const Vec3 pressed = (0.05 - random.uniform(0.0001, 0.003)) * normalized(outside + random.in_cube(0.01));
    stroke(session, outside, pressed);
    Tick tick;
    for (int j = 0; j < 100; ++j) tick = session.tick({.position_m = pressed}, dt);
    const Vec3 rest = tick.proxy_m;
    for (int j = 0; j < 50; ++j) EXPECT_NEAR(distance(session.tick({.position_m = pressed}, dt).proxy_m, rest), 0.0, 1e-12);
  }
}

// A mode with invalid output is named and never reaches the hand.
struct Broken {
  static constexpr auto type = "test.broken";
  int what = 0;
  static constexpr auto parameters() { return std::tuple<>{}; }
  void place(const ModeContext& here, PrimitiveSink out) const noexcept {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    if (what == 0) out.point(0, here.proxy_m, nan);
    if (what == 1) out.point(0, here.proxy_m, -1.0);
    if (what == 2) out.plane(0, here.proxy_m, {0, 0, 2}, 1.0);
    if (what == 3) out.point(0, {nan, nan, nan}, 1.0);
    if (what == 4) out.directed(0, {nan, 0, 0}, 1.0);
  }
};

TEST(BrokenMode, IsNamedOnceAndFeltNever) {
  for (int what = 0; what < 5; ++what) {
    Scene scene;
    scene.add("good", Viscosity{.strength_n = 0.1});
    scene.add("bad", Broken{.what = what});
    Session session(scene);
    int faults = 0;
    for (int i = 0; i < 50; ++i) {
      const Tick tick = session.tick({.position_m = {1e-4 * i, 0, 0}}, dt);
      EXPECT_GT(tick.dropped, 0);
      for (const SessionEvent& event : session.events()) {
        if (event.kind != SessionEventKind::fault) continue;
        ++faults;
        EXPECT_EQ(scene.modes()[static_cast<std::size_t>(event.mode)].name, "bad");
        EXPECT_NE(event.text, nullptr);
      }
      EXPECT_EQ(session.modes()[1].force_n, Vec3{});
      EXPECT_LE(norm(tick.force_n), 0.1 + 1e-12);
    }
    EXPECT_EQ(faults, 1);
  }
}

// A field of invalid values: the force stays finite.
class Nonsense final : public Field {
 public:
  explicit Nonsense(double value) : value_(value) {}
  int components() const noexcept override { return 1; }
  ScalarSample scalar(const Vec3& x) const noexcept override {
    return {std::fmod(x.z * 1e4, 2.0) > 0 ? value_ : -value_, {value_, -value_, value_}, true};
  }
  double spacing_m() const noexcept override { return 1e-3; }
  Box bounds_m() const noexcept override { return {{-1, -1, -1}, {1, 1, 1}}; }
  double depth_m(const Vec3&) const noexcept override { return 1.0; }
  std::vector<ValueRange> value_ranges() const override { return {{-1, 1}}; }

 private:
  double value_;
};

TEST(BadData, NeverGivesANonFiniteForce) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double value : {nan, std::numeric_limits<double>::infinity(), 1e308, 1e-320, 0.0}) {
    Scene scene = plain_scene({.stiffness_n_per_m = 800, .damping_ns_per_m = 0.5});
    Volume volume;
    volume.fields.push_back({"v", "", std::make_shared<Nonsense>(value)});
    const FieldRef field = scene.add("v", volume);
    scene.add("s", SurfaceAndFriction{.field = field, .levels = {{.value = 0.0, .strength_n = 2.0}}, .friction_n = 0.1});
    scene.add("m", SurfaceAndFriction{.field = field, .strength_n = {field, TransferFunction({{-1e9, 1.0}, {1e9, 1.0}}, 1.0)}});
    Session session(scene);
    test::Random random(3);
    const test::Wander hand(random, 0.05);
    for (int i = 0; i < 2000; ++i) {
      const Tick tick = session.tick({.position_m = hand.at(dt * i)}, dt);
      ASSERT_TRUE(is_finite(tick.force_n) && is_finite(tick.proxy_m) && is_finite(tick.proxy_velocity_m_per_s)) << value;
    }
  }
}

TEST(InvalidProbe, GivesNoForceAndStartsAnew) {
  Session session(ball(3.0));
  EXPECT_GT(norm(stroke(session, {0, 0, 0.08}, {0, 0, 0.048}).force_n), 1.0);
  const Tick lost = session.tick({.position_m = {0, 0, 0.048}, .valid = false}, dt);
  EXPECT_EQ(lost.force_n, Vec3{});
  EXPECT_FALSE(lost.probe_valid);
  const Tick back = session.tick({.position_m = {0, 0, 0.045}}, dt);
  EXPECT_EQ(back.force_n, Vec3{}) << "the proxy starts at the probe, no pull from where it was";
}

// Scaling the data and the map together: by a power of two bit-identical, by any factor equal to rounding between common
// events.
std::vector<Tick> felt_at_scale(double scale) {
  Scene scene({.stiffness_n_per_m = 800, .damping_ns_per_m = 0.3});
  const FieldRef head = scene.add("head", sampled(head_phantom(), 40), {.scale = scale});
  const FieldRef flow = scene.add("flow", sampled(burgers_vortex(), 32), {.scale = 3.0 * scale});
  scene.add("skin", SurfaceAndFriction{.field = head,
                                       .levels = {{.value = -300, .strength_n = 0.8}, {.value = 300, .strength_n = 4.0}},
                                       .friction_n = 0.1});
  scene.add("rail", Follow{.field = flow, .strength_n = 0.3});
  Session session(scene);
  test::Random random(21);
  const test::Wander hand(random, 0.08);
  std::vector<Tick> ticks;
  for (int i = 0; i < 1500; ++i) ticks.push_back(session.tick({.position_m = hand.at(dt * i)}, dt));
  return ticks;
}

TEST(Scale, ByAPowerOfTwoGivesTheSameBits) {
  const std::vector<Tick> one = felt_at_scale(1.0);
  for (const int power : {-30, -7, 5, 23}) {
    const std::vector<Tick> other = felt_at_scale(std::ldexp(1.0, power));
    for (std::size_t i = 0; i < one.size(); ++i) {
      ASSERT_EQ(one[i].proxy_m, other[i].proxy_m) << "2^" << power << " at tick " << i;
      ASSERT_EQ(one[i].force_n, other[i].force_n);
      ASSERT_EQ(one[i].sub_steps, other[i].sub_steps);
    }
  }
}

TEST(Scale, ByAnyFactorGivesTheSameForcesToRounding) {
  const std::vector<Tick> one = felt_at_scale(1.0);
  for (const double scale : {1e-9, 3e-4, 777.0, 1e7}) {
    const std::vector<Tick> other = felt_at_scale(scale);
    // Common events: up to the first tick whose number of sub-steps differs by an event at the edge of rounding.
    std::size_t common = 0;
    while (common < one.size() && one[common].sub_steps == other[common].sub_steps) ++common;
    EXPECT_GT(common, one.size() / 2);
    for (std::size_t i = 0; i < common; ++i)
      ASSERT_NEAR(distance(one[i].force_n, other[i].force_n), 0.0, 1e-6) << scale << " at " << i;
  }
}

TEST(Session, TurningTheWorldAndTheHandTogetherTurnsTheForce) {
  test::Random random(31);
  const Mat3 rotation = random.rotation();
  Scene scene = plain_scene({.stiffness_n_per_m = 800});
  const FieldRef field = scene.add("ball", sphere_field(0.05));
  scene.add("s", SurfaceAndFriction{.field = field, .levels = {{.value = 0.0, .strength_n = 3.0}}, .friction_n = 0.2});
  Scene turned = plain_scene({.stiffness_n_per_m = 800});
  const FieldRef turned_field = turned.add("ball", sphere_field(0.05), {.rotation = rotation});
  turned.add("s", SurfaceAndFriction{.field = turned_field, .levels = {{.value = 0.0, .strength_n = 3.0}}, .friction_n = 0.2});
  Session a(scene), b(turned);
  const test::Wander hand(random, 0.08);
  int in_contact = 0;
  for (int i = 0; i < 4000; ++i) {
    const Tick ta = a.tick({.position_m = hand.at(dt * i)}, dt);
    const Tick tb = b.tick({.position_m = rotation * hand.at(dt * i)}, dt);
    ASSERT_NEAR(distance(tb.force_n, rotation * ta.force_n), 0.0, 1e-7) << i;
    in_contact += norm(ta.force_n) > 1e-3;
  }
  EXPECT_GT(in_contact, 100);
}

// Hand and spring together: with the device's own damping b ≥ kT/2 + D no surface, friction or rail makes a free hand faster
// than it came.
TEST(Energy, AClosedLoopWithEnoughDampingNeverGains) {
  test::Random random(41);
  for (int run = 0; run < 60; ++run) {
    const double k = random.uniform(200, 1500), D = run % 2 ? 0.0 : random.uniform(0.0, 0.3), mass = random.uniform(0.1, 0.5);
    const double b = 1.02 * (k * dt / 2 + D);
    Scene scene = plain_scene({.stiffness_n_per_m = k, .damping_ns_per_m = D});
    const FieldRef field = scene.add("ball", sphere_field(0.05));
    scene.add("s", SurfaceAndFriction{
                       .field = field,
                       .levels = {{.value = 0.0, .strength_n = random.uniform(0.5, 5.0)}, {.value = 0.006, .strength_n = 3.0}},
                       .friction_n = run % 3 ? 0.0 : 0.3});
    if (run % 4 == 1) scene.add("v", Viscosity{.strength_n = 0.05, .drag_ns_per_m = 0.2});
    Session session(scene);
    Vec3 p = 0.055 * random.direction();
    Vec3 v = 0.3 * normalized(-p + random.in_cube(0.02));
    const double start_j = 0.5 * mass * norm_squared(v);
    double most_j = 0.0;
    session.tick({.position_m = p}, dt);
    Vec3 force;
    for (int i = 0; i < 1500; ++i) {
      // Exact motion under the held force: m v' = f − b v.
      const double decay = std::exp(-b * dt / mass);
      const Vec3 settled = force / b;
      p += settled * dt + (mass / b) * (1.0 - decay) * (v - settled);
      v = settled + decay * (v - settled);
      const Tick tick = session.tick({.position_m = p}, dt);
      force = tick.force_n;
      most_j = std::max(most_j, 0.5 * mass * norm_squared(v) + tick.energy.stored_j);
    }
    EXPECT_LE(most_j, start_j) << "k " << k << " D " << D << " run " << run;
  }
}

// A spline through equal voxels is constant but for its rounding, which must not hold the proxy as a level.
TEST(FlatData, DoNotHoldTheProxyForEver) {
  const GridGeometry geometry{{32, 32, 32}, 1e-3 * Mat3::identity(), {-0.016, -0.016, -0.016}};
  for (const Filter filter : {Filter::trilinear, Filter::smooth, Filter::cubic}) {
    for (const double base : {40.0, -1000.1, 1e5 / 3.0}) {
      auto voxels = std::make_shared<std::vector<float>>(32 * 32 * 32, static_cast<float>(base));
      for (std::size_t i = 0; i < 64; ++i) (*voxels)[i] += 500.0f;  // far from the hand, so that there is a range
      const FieldPtr flat = grid_field(geometry, {VoxelType::float32, 1, std::shared_ptr<const void>(voxels, voxels->data())});
      Volume volume;
      volume.fields.push_back({"signal", "", flat});
      Scene scene({.stiffness_n_per_m = 1200.0, .damping_ns_per_m = 0.0});
      const FieldRef field = scene.add("flat", volume, {}, filter);
      scene.add("material", SurfaceAndFriction{.field = field, .strength_n = Strength{0.4}, .friction_coefficient = 0.2});
      scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
      Session session(scene);
      test::Random random(3);
      const test::Wander hand(random, 0.01);
      int waiting = 0;
      for (int i = 0; i < 3000; ++i)
        waiting += session.tick({.position_m = hand.at(1e-3 * i)}, 1e-3).status == TickStatus::waiting;
      EXPECT_EQ(waiting, 0) << static_cast<int>(filter) << ", " << base;
    }
  }
}

// A proxy from a slope keeps its depth estimate; in flat data no value corrects it.
TEST(FlatData, DoNotHoldAProxyThatComesFromASlope) {
  const GridGeometry geometry{{32, 32, 32}, 1e-3 * Mat3::identity(), {-0.016, -0.016, -0.016}};
  for (const Filter filter : {Filter::trilinear, Filter::smooth, Filter::cubic}) {
    for (const double base : {40.0, -1000.0, 1e5 / 3.0}) {
      auto voxels = std::make_shared<std::vector<float>>();
      for (int k = 0; k < 32; ++k) {
        for (int j = 0; j < 32; ++j) {
          for (int i = 0; i < 32; ++i) {
            const double r = std::hypot(i - 20.0, j - 16.0, k - 16.0);
            voxels->push_back(static_cast<float>(base + 900.0 * std::clamp(1.5 - r / 4.0, 0.0, 1.0)));
          }
        }
      }
      Volume volume;
      volume.fields.push_back(
          {"signal", "", grid_field(geometry, {VoxelType::float32, 1, std::shared_ptr<const void>(voxels, voxels->data())})});
      Scene scene = plain_scene({.stiffness_n_per_m = 1200.0, .damping_ns_per_m = 0.0});
      const FieldRef field = scene.add("ball", volume, {}, filter);
      scene.add("material",
                SurfaceAndFriction{.field = field, .solid = SurfaceAndFriction::Solid::low, .strength_n = Strength{0.2}});
      scene.add("pull", GradientForce{.field = field, .strength_n = Strength{1.0}});
      Session session(scene);
      test::Random random(3);
      const test::Wander hand(random, 0.014);
      int waiting = 0;
      for (int i = 0; i < 10000; ++i)
        waiting += session.tick({.position_m = hand.at(1e-3 * i)}, 1e-3).status == TickStatus::waiting;
      EXPECT_LE(waiting, 10) << static_cast<int>(filter) << ", " << base;
    }
  }
}

// A force along a vortex without resistance drives the proxy round and round: no balance ends it, and the hand goes on.
TEST(Vortex, DoesNotKeepTheProxyFromFollowing) {
  Scene scene = plain_scene({.stiffness_n_per_m = 577.0, .damping_ns_per_m = 0.0});
  scene.edit<Workspace>([&](auto& workspace) { workspace.scale = 1.5; });
  const FieldRef swirl = scene.add("swirl", sampled(lamb_oseen_vortex(), 64));
  scene.add("along", Follow{.field = swirl, .strength_n = Strength{0.74}, .drag_ns_per_m = 0.62});
  scene.add("push", VectorForce{.field = swirl, .strength_n = Strength{0.87}});
  scene.add("across", TransverseDamping{.field = swirl, .drag_ns_per_m = 1.5});
  int waiting = 0, longest = 0;
  for (int seed = 0; seed < 4; ++seed) {
    test::Random random(seed);
    const test::Wander hand(random, 0.06);
    Session session(scene);
    for (int i = 0, run = 0; i < 10000; ++i) {
      const bool waits = session.tick({.position_m = hand.at(1e-3 * i)}, 1e-3).status == TickStatus::waiting;
      waiting += waits;
      run = waits ? run + 1 : 0;
      longest = std::max(longest, run);
    }
  }
  EXPECT_LE(longest, 10);
  EXPECT_LE(waiting, 4 * 100);
}

}  // namespace session_test
}  // namespace palpa
