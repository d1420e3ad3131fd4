// First contact of a hand with a scene, against the closed form of a ball's front.
#include "palpa/study/reach.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "palpa/data/analytic.h"
#include "palpa/data/phantom_parts.h"
#include "palpa/device/front.h"
#include "palpa/loop/loop.h"
#include "palpa/mode/modes.h"
#include "palpa/study/summary.h"

namespace palpa {
namespace reach_test {

using testing::HasSubstr;
using testing::Not;

constexpr double radius_m = 0.05;
constexpr double stiffness_n_per_m = 500.0;

/// A ball about `centre_m` [m] of the hand, as one shell of this strength, with a viscous inside.
Scene ball(const Vec3& centre_m, double strength_n, double drag_ns_per_m = 0.0) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m, .max_force_n = 3.3});
  const FieldRef depth = scene.add("ball", sphere_field(radius_m));
  scene.set(Workspace{.scale = 1.0, .center_m = -centre_m, .towards_user = "+z", .up = "+y"});
  scene.add("shell", SurfaceAndFriction{.field = depth, .levels = {{.name = "shell", .strength_n = strength_n}}});
  if (drag_ns_per_m > 0.0) {
    scene.add("syrup", Viscosity{.field = depth, .drag_ns_per_m = drag_ns_per_m},
              {Mask{.of = depth, .curve = TransferFunction({{0.0, 0.0}, {0.001, 1.0}, {1.0, 1.0}})}});
  }
  return scene;
}

Summary summary_of(const Scene& scene, std::unique_ptr<Target> target, Hold hold, double duration_s = 8.0) {
  Session session(scene);
  SummaryBuilder builder(scene);
  const auto hand = hand_device(std::move(target), hold);
  run_simulated(session, *hand, {.duration_s = duration_s, .time_ticks = false}, nullptr,
                [&](const TickFrame& frame, const Session& felt) { builder.add(frame, felt); });
  return builder.finish(1.0);
}

double contact_share(const Scene& scene, std::unique_ptr<Target> target, Hold hold) {
  return summary_of(scene, std::move(target), hold).contact_share;
}

TEST(Reach, TheFrontOfABallIsTheBall) {
  for (const Vec3& centre_m : {Vec3{}, Vec3{0.02, -0.01, -0.015}}) {
    const Encounter met = Reach(ball(centre_m, 1.0)).encounter(simulated_motion("sim:stroke"), Hold::rigid);
    const Vec3 place_m = met.facing->at(0, 0, 0) - centre_m;
    // A smoothing spline lies below a ball's crown by about spacing²/(6 R), and a path has steps of 1 mm.
    EXPECT_NEAR(norm(place_m), radius_m, 1.5e-3);
    for (double angle = 0; angle < 6.28; angle += 0.7) {
      const Vec3 on_m = met.facing->at(0.02 * std::cos(angle), 0.02 * std::sin(angle), 0) - centre_m;
      EXPECT_NEAR(norm(on_m), radius_m, 1.5e-3) << angle;
    }
  }
}

TEST(Reach, ItsHelixGoesRoundTheBall) {
  const Encounter met = Reach(ball({}, 1.0)).encounter(simulated_motion("sim:helix"), Hold::rigid);
  for (double turns = 0; turns < 1; turns += 0.13) {
    EXPECT_NEAR(norm(met.around->at(turns, 0.0, 0.0)), radius_m, 2.5e-3) << turns;
  }
}

TEST(Reach, AHandGoesAsDeepAsHalfOfWhatALevelBears) {
  for (const double strength_n : {1.0, 2.0}) {
    const Reach reach(ball({}, strength_n));
    const double half_m = 0.5 * strength_n / stiffness_n_per_m;
    // Steps of 1 mm; on a ball most paths are oblique, and longer by as much.
    EXPECT_NEAR(reach.encounter(simulated_motion("sim:stroke"), Hold::rigid).depth_m, half_m, 1.2e-3);
    const double arm = relaxed_arm.stiffness_n_per_m;
    EXPECT_NEAR(reach.encounter(simulated_motion("sim:stroke"), Hold::relaxed).depth_m, half_m + 0.5 * strength_n / arm,
                1.2e-3 * (1.0 + stiffness_n_per_m / arm));
  }
}

TEST(Reach, EveryMotionBegins20MillimetresBeforeItAndFeelsIt) {
  for (const Vec3& centre_m : {Vec3{}, Vec3{-0.03, 0.02, -0.03}}) {
    const Scene scene = ball(centre_m, 1.0);
    const Reach reach(scene);
    for (const char* path : {"sim:press", "sim:stroke", "sim:circle", "sim:helix", "sim:random"}) {
      const SimulatedMotion motion = simulated_motion(path);
      const Encounter met = reach.encounter(motion, Hold::relaxed);
      auto target = simulated_target(motion, met);
      const Vec3 begin_m = target->at(0).position_m;
      EXPECT_NEAR(norm(begin_m - centre_m), radius_m + 0.02, 3e-3) << path;
      EXPECT_GE(contact_share(scene, std::move(target), Hold::relaxed), 0.3) << path;
    }
  }
}

// A shell that lets a hand in without force, as a vortex plane does from one side: met by the paths, felt by none.
TEST(Reach, ALevelWithoutForceFromTheUserIsNoContact) {
  Scene scene = ball({}, 1.0);
  scene.edit<SurfaceAndFriction>("shell", [](SurfaceAndFriction& shell) { shell.levels.front().strength_n = Strength{1e-9}; });
  const Reach reach(scene);
  EXPECT_TRUE(reach.is_empty());
  EXPECT_THAT(explain_little_contact(reach, std::vector<Vec3>{{0.0, 0.0, 0.1}}, ""), Not(HasSubstr("never known")));
}

TEST(Reach, AWayThatIsMovedWithItsSceneIsTheSame) {
  const SimulatedMotion motion = simulated_motion("sim:circle");
  const Vec3 moved_m{0.01, -0.02, 0.0};  // whole cells of the lattice
  const auto here = simulated_target(motion, Reach(ball({0, 0, -0.02}, 1.0)).encounter(motion, Hold::rigid));
  const auto there = simulated_target(motion, Reach(ball(Vec3{0, 0, -0.02} + moved_m, 1.0)).encounter(motion, Hold::rigid));
  for (double t_s = 0; t_s < 5; t_s += 0.37) {
    // The point is drawn to the middle of the workspace, so only the common part is compared: the ball itself.
    EXPECT_NEAR(norm(here->at(t_s).position_m - Vec3{0, 0, -0.02}),
                norm(there->at(t_s).position_m - Vec3{0, 0, -0.02} - moved_m), 2e-3);
  }
}

TEST(Reach, WhereLittleCanBeFeltAMotionStaysThere) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m, .max_force_n = 3.3});
  const FieldRef depth = scene.add("pea", sphere_field(0.008));
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{0.013, -0.021, 0.0}});
  scene.add("shell", SurfaceAndFriction{.field = depth, .levels = {{.name = "shell", .strength_n = 1.0}}});
  const Encounter met = Reach(scene).encounter(simulated_motion("sim:circle"), Hold::rigid);
  EXPECT_LE(met.radius_m, 0.011);
  EXPECT_NEAR(distance(met.facing->at(0, 0, 0), {-0.013, 0.021, 0.008}), 0.0, 5e-3);
  // Given parameters override the fit.
  const SimulatedMotion wide = simulated_motion("sim:circle,radius_m=0.04,depth_m=0.001");
  const auto target = simulated_target(wide, met);
  const Vec3 at_m = target->at(4).position_m - met.facing->at(0, 0, 0);
  EXPECT_NEAR(std::hypot(at_m.x, at_m.y), 0.04, 1e-12);
}

/// A hand that goes to and fro, far away.
class ToAndFro final : public Target {
 public:
  Point at(double time_s) const noexcept override {
    return {.position_m = Vec3{5.0, -3.0, 2.0} + 0.02 * Vec3{std::sin(time_s), std::cos(0.7 * time_s), std::sin(2.3 * time_s)}};
  }
  double duration_s() const noexcept override { return 8.0; }
};

TEST(Reach, ARecordingIsLaidWhereItFeelsMost) {
  const Scene scene = ball({0.01, 0.02, -0.01}, 1.0, 1.0);
  const Reach reach(scene);
  const auto recording = std::make_shared<ToAndFro>();
  const RecordingPlacement laid = reach.place_recording(recording, Hold::rigid);
  EXPECT_GE(laid.contact_share, 0.6);
  EXPECT_NEAR(contact_share(scene, displaced(recording, laid.offset_m), Hold::rigid), laid.contact_share, 0.05);
  EXPECT_LE(distance(recording->at(0).position_m + laid.offset_m, {0.01, 0.02, -0.01}), 0.1);
}

// Modes that push in the same places draw no recording away from a place where all are met, and some far longer.
TEST(Reach, ARecordingIsLaidForLongContactHoweverManyModesShareASmallPlace) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m, .max_force_n = 3.3});
  const auto depth_of = [](double first_radius_m, const Vec3& first_m, double other_radius_m, const Vec3& other_m) {
    return detail::phantom::volume_of(
        "depth", "m", detail::phantom::cube(0.1), 1e-3, {{-0.3, 0.1}}, [=](const Vec3& x) noexcept {
          const double one_m = first_radius_m - distance(x, first_m), two_m = other_radius_m - distance(x, other_m);
          return ScalarSample{std::max(one_m, two_m), {}, true};
        });
  };
  const Vec3 middle_m{-0.035, 0.0, 0.0}, apart_m{0.06, 0.04, 0.0};
  const TransferFunction inside({{0.0, 0.0}, {0.001, 1.0}, {1.0, 1.0}});
  const FieldRef wide = scene.add("wide", depth_of(0.05, middle_m, 0.02, apart_m));
  const FieldRef small = scene.add("small", depth_of(0.012, middle_m, 0.02, apart_m));
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}, .towards_user = "+z", .up = "+y"});
  scene.add("water", Viscosity{.field = wide, .drag_ns_per_m = 1.0}, {Mask{.of = wide, .curve = inside}});
  for (const char* name : {"one", "two", "three", "four"})
    scene.add(name, Viscosity{.field = small, .drag_ns_per_m = 1.0}, {Mask{.of = small, .curve = inside}});
  const RecordingPlacement laid = Reach(scene).place_recording(std::make_shared<ToAndFro>(), Hold::rigid);
  EXPECT_GE(laid.contact_share, 0.9);
}

// To a position with as much contact as near by, from a recording's largest distance.
TEST(Reach, ARecordingIsLaidHoweverFarItLies) {
  const Scene scene = ball({0.01, 0.02, -0.01}, 1.0, 1.0);
  const Reach reach(scene);
  const auto near = std::make_shared<ToAndFro>();
  const double felt_near = reach.place_recording(near, Hold::rigid).contact_share;
  for (const Vec3& shift_m : {Vec3{500.0, 0.0, 0.0}, {-990.0, 0.0, 100.0}, {0.0, -300.0, -990.0}, {700.0, 500.0, 500.0}}) {
    const std::shared_ptr<const Target> far = displaced(near, shift_m);
    const RecordingPlacement laid = reach.place_recording(far, Hold::rigid);
    EXPECT_NEAR(laid.contact_share, felt_near, 0.05) << shift_m.x;
    EXPECT_LE(distance(far->at(0).position_m + laid.offset_m, {0.01, 0.02, -0.01}), 0.1) << shift_m.x;
  }
}

/// A hand that begins at its deepest point.
class OutAndIn final : public Target {
 public:
  Point at(double time_s) const noexcept override {
    return {.position_m = 0.02 * Vec3{std::sin(time_s), std::sin(0.7 * time_s), -std::cos(2.3 * time_s)}};
  }
  double duration_s() const noexcept override { return 8.0; }
};

// In an unbreakable level it would stay at its start.
TEST(Reach, ARecordingBeginsInFrontOfALevel) {
  const Scene scene = ball({0.0, 0.0, 0.0}, 20.0, 1.0);
  const auto recording = std::make_shared<OutAndIn>();
  const RecordingPlacement laid = Reach(scene).place_recording(recording, Hold::firm);
  const Vec3 first_m = recording->at(0).position_m + laid.offset_m;
  EXPECT_GT(norm(first_m), radius_m) << first_m.x << ' ' << first_m.y << ' ' << first_m.z;
  EXPECT_GT(laid.contact_share, 0.1);
}

// Behind a shell that holds a rigid hand is over the limit: most contact would be most of the time at it.
TEST(Reach, ARecordingBesideALevelThatHoldsStaysBelowTheLimit) {
  for (const double strength_n : {5.0, 20.0, 100.0}) {
    const Scene scene = ball({0.01, 0.0, 0.0}, strength_n);
    const auto recording = std::make_shared<ToAndFro>();
    const RecordingPlacement laid = Reach(scene).place_recording(recording, Hold::rigid);
    const Summary felt = summary_of(scene, displaced(recording, laid.offset_m, laid.scale), Hold::rigid);
    EXPECT_LE(felt.guard_limited_ticks, felt.ticks / 100) << strength_n << " N, " << laid.scale;
    EXPECT_GE(felt.contact_share, 0.2) << strength_n << " N, " << laid.scale;
  }
}

/// Motion that is small for 40 s and wide afterwards.
class WideAtLast final : public Target {
 public:
  Point at(double time_s) const noexcept override {
    const double wide = time_s < 40.0 ? 0.2 : 1.0;
    return {0.015 * wide * Vec3{std::sin(2.0 * time_s), std::cos(3.0 * time_s), std::sin(1.3 * time_s)}};
  }
  double duration_s() const noexcept override { return 60.0; }
};

TEST(Reach, ARecordingThatWidensLateStaysBelowTheLimit) {
  const Scene scene = ball({0.01, 0.0, 0.0}, 20.0);
  const auto recording = std::make_shared<WideAtLast>();
  const RecordingPlacement laid = Reach(scene).place_recording(recording, Hold::rigid);
  const Summary felt = summary_of(scene, displaced(recording, laid.offset_m, laid.scale), Hold::rigid, 60.0);
  EXPECT_LE(felt.guard_limited_ticks, felt.ticks / 100) << laid.scale;
  EXPECT_GE(felt.contact_share, 0.2) << laid.scale;
}

TEST(Reach, TheNearestThingIsWhereItIs) {
  const Reach reach(ball({0, 0, -0.02}, 1.0, 1.0));
  const Vec3 places_m[] = {{0.0, 0.0, 0.1}, {0.09, 0.0, -0.02}, {0.0, 0.2, 0.1}};
  const auto nearest = reach.nearest(places_m);
  ASSERT_TRUE(nearest);
  EXPECT_NEAR(nearest->distance_m, 0.04, 0.0125);  // from the second position, to within a cell: 10 x 10 x 5 mm
  EXPECT_LT(nearest->direction.x, -0.03);
  EXPECT_NEAR(norm(nearest->direction), nearest->distance_m, 1e-12);
  EXPECT_THAT(format_nearest(*nearest), testing::AllOf(HasSubstr("mm away"), HasSubstr("to the left")));
  EXPECT_EQ(reach.felt_share(places_m), 0.0);
  const Vec3 within_m[] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.1}};
  EXPECT_EQ(reach.felt_share(within_m), 0.5);
}

TEST(Reach, WhereNothingCanBeFeltItSaysWhatWouldChangeThat) {
  Scene far = ball({}, 1.0);
  far.edit<Workspace>([&](auto& workspace) { workspace.center_m = Vec3{1.0, 0.0, 0.0}; });
  const Reach reach(far);
  EXPECT_TRUE(reach.is_empty());
  EXPECT_FALSE(reach.nearest(std::vector<Vec3>{Vec3{}}));
  EXPECT_THAT(explain_little_contact(reach, {}, ""), HasSubstr("fit = \"ball\""));

  Scene bare;
  EXPECT_THAT(explain_little_contact(Reach(bare), {}, ""), HasSubstr("[[mode]]"));
}

TEST(Reach, SaysFromWhichSideSomethingIsFelt) {
  // A level that holds from below only: a hand from the user's side never meets it.
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m, .max_force_n = 3.3});
  scene.add("wall", plane_field());
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}, .towards_user = "+z", .up = "+y"});
  scene.add("wall", SurfaceAndFriction{.field = {"wall"},
                                       .solid = SurfaceAndFriction::Solid::low,
                                       .levels = {{.value = 0.0, .strength_n = Strength{1.0}}}});
  EXPECT_THAT(explain_little_contact(Reach(scene), {}, ""),
              testing::AllOf(HasSubstr("straight from the user"), HasSubstr("from behind")));
  Scene nothing = scene;
  nothing.edit<Workspace>([&](auto& workspace) { workspace.center_m = Vec3{0.0, 0.0, 5.0}; });
  EXPECT_THAT(explain_little_contact(Reach(nothing), {}, ""), Not(HasSubstr("comes from")));
}

TEST(Reach, AsManyThreadsAsThereAreGiveTheSameAnswer) {
  const Scene scene = ball({0.01, 0.0, 0.0}, 1.0, 0.5);
  const SimulatedMotion motion = simulated_motion("sim:stroke");
  const auto once = simulated_target(motion, Reach(scene).encounter(motion, Hold::relaxed));
  const auto again = simulated_target(motion, Reach(scene).encounter(motion, Hold::relaxed));
  for (double t_s = 0; t_s < 10; t_s += 0.3) EXPECT_EQ(once->at(t_s).position_m, again->at(t_s).position_m);
}

}  // namespace reach_test
}  // namespace palpa
