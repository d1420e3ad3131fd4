// Every balance of every shipped scene under a hand, checked from the trace's files alone (docs/trace.md).
#include "tests/laws/trace_check.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "palpa/device/hand.h"
#include "palpa/palpa.h"
#include "palpa/solver/pose_solver.h"
#include "palpa/study/run.h"
#include "palpa/trace/trace.h"
#include "tests/laws/shipped_scenes.h"
#include "tests/solver/all_faces.h"

namespace palpa {
namespace trace_check_test {

namespace fs = std::filesystem;

class ShippedTrace : public testing::TestWithParam<std::string> {
 protected:
  const fs::path folder_ = fs::temp_directory_path() / ("palpa-trace-" + GetParam() + "-" + std::to_string(::getpid()));
  void SetUp() override { fs::remove_all(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
};

TEST_P(ShippedTrace, ProvesEachOfItsBalances) {
  if (const std::string missing = test::missing_for(GetParam()); !missing.empty()) GTEST_SKIP() << missing;
  RunOptions options;
  options.scene = test::scene_file(GetParam());
  options.read.reader = test::reader();
  options.out = folder_;
  options.primitives = true;
  options.duration_s = 4.0;
  if (GetParam().ends_with("_phantom")) {
    options.hand = "sim:random";
  } else {
    options.hand = (test::shared_data() / "trajectories/inverse3_woodcarving_20231121_102837.csv").string();
    options.hold = Hold::firm;
    options.scene_options.data_folders = {test::shared_data_folder()};
  }
  run(options);

  int balances = 0, capped = 0, proven = 0;
  double worst_claimed_m = 0.0, worst_m = 0.0, worst_excess_m = -1.0;
  test::check_balances(folder_, [&](const test::CheckedBalance& b) {
    ASSERT_TRUE(b.status == "exact" || b.status == "capped") << "tick " << b.tick << ": " << b.status;
    ++balances;
    capped += b.status == "capped";
    if (b.status == "exact") {
      ASSERT_LE(b.claimed_m, exact_bound_m) << "tick " << b.tick;
    }
    ASSERT_LE(b.bound_m, b.claimed_m + b.rounding_m) << "tick " << b.tick << ", sub-step " << b.sub_step;
    proven += b.bound_m <= exact_bound_m;
    worst_claimed_m = std::max(worst_claimed_m, b.claimed_m);
    worst_m = std::max(worst_m, b.bound_m);
    worst_excess_m = std::max(worst_excess_m, b.bound_m - b.claimed_m);
  });
  std::printf(
      "%s: %d balances, %d capped; claimed at most %.3g m, recomputed at most %.3g m, %.3g m above its claim; "
      "%.4g %% recomputed <= 1e-9 m\n",
      GetParam().c_str(), balances, capped, worst_claimed_m, worst_m, worst_excess_m, 100.0 * proven / balances);
  EXPECT_GE(balances, 3900) << "the hand did not come through";
}

INSTANTIATE_TEST_SUITE_P(Scenes, ShippedTrace, testing::ValuesIn(test::shipped_scenes()),
                         [](const auto& scene) { return scene.param; });

// The check rejects a falsified force, position or bound.
TEST(TraceCheck, SeesWhatIsMadeUp) {
  const fs::path folder = fs::temp_directory_path() / ("palpa-trace-check-" + std::to_string(::getpid()));
  fs::create_directory(folder);
  // One plane through the origin holds a probe 1 mm behind it, k = 1000 N/m: force 1 N, balance at the origin.
  const auto checked =
      [&](const std::string& balance_z_m, const std::string& force_z_n) {
        std::ofstream(folder / "balances.csv")
            << "tick,sub_step,dt_s,probe_x_m,probe_y_m,probe_z_m,k_n_per_m,directed_x_n,directed_y_n,directed_z_n,"
               "balance_x_m,balance_y_m,balance_z_m,error_bound_m,status,primitives\n0,0,0.001,0,0,-0.001,1000,0,0,0,0,0,"
            << balance_z_m << ",1e-12,exact,1\n";
        std::ofstream(folder / "primitives.csv")
            << "tick,sub_step,kind,position_x_m,position_y_m,position_z_m,direction_x,direction_y,direction_z,strength_n,"
               "drag_ns_per_m,force_x_n,force_y_n,force_z_n\n0,0,plane,0,0,0,0,0,1,2,0,0,0,"
            << force_z_n << "\n";
        test::CheckedBalance seen;
        test::check_balances(folder, [&](const test::CheckedBalance& b) { seen = b; });
        return seen;
      };
  EXPECT_LE(checked("0", "1").bound_m, 1e-15);
  EXPECT_NEAR(checked("0", "0.9").bound_m, 1e-4, 1e-12);     // 0.1 N left over
  EXPECT_GE(checked("-1e-6", "1").bound_m, 1e-6);            // off the plane's side that holds
  EXPECT_GE(checked("-0.001", "0").bound_m, 1e-3);           // without any hold
  EXPECT_GE(checked("1e-6", "1.001").bound_m, 1e-6);         // pulls back on its free side
  EXPECT_NEAR(checked("0.002", "3").bound_m, 3.0e-3, 2e-3);  // beyond its strength: 2 N count, not 3
  EXPECT_THROW(checked("zero", "1"), LoadError);
  fs::remove(folder / "primitives.csv");
  EXPECT_THROW(test::check_balances(folder, [](const test::CheckedBalance&) {}), LoadError);
  fs::remove_all(folder);
}

// The check of rests rejects a drag that bears off its recorded position, which takes motion.
TEST(TraceCheck, SeesARestThatNothingBears) {
  const fs::path folder = fs::temp_directory_path() / ("palpa-trace-rest-" + std::to_string(::getpid()));
  fs::create_directory(folder);
  std::ofstream(folder / "ticks.csv") << "tick,status\n0,resting\n";
  // A point of 0.05 N and 1 N·s/m at the proxy, a plane of 2 N in front of it; k = 500 N/m, the probe 10 mm behind.
  const auto left_n = [&](const std::string& plane_z_m, const std::string& strength_n) {
    std::ofstream(folder / "balances.csv") << "tick,dt_s,probe_x_m,probe_y_m,probe_z_m,k_n_per_m,directed_x_n,directed_y_n,"
                                              "directed_z_n,proxy_x_m,proxy_y_m,proxy_z_m,primitives\n"
                                              "0,0.001,0,0,-0.01,500,0,0,0,0,0,0,2\n";
    std::ofstream(folder / "primitives.csv")
        << "tick,mode,slot,kind,position_x_m,position_y_m,position_z_m,direction_x,direction_y,direction_z,strength_n,"
           "drag_ns_per_m\n0,inside,0,point,0,0,0,0,0,0,0.05,1\n0,surface,0,plane,0,0,"
        << plane_z_m << ",0,0,1," << strength_n << ",0\n";
    double left = -1.0;
    test::check_rests(folder, 1e-6, [&](const test::CheckedRest& rest) { left = rest.left_n; });
    return left;
  };
  EXPECT_NEAR(left_n("-0.001", "2"), 5.0 - 0.05, 1e-5);  // off the plane
  EXPECT_NEAR(left_n("0", "2"), 5.0 - 2.05, 1e-5);       // on it, and above its strength
  EXPECT_NEAR(left_n("0", "7"), 0.0, 1e-5);
  EXPECT_NEAR(left_n("0.003", "4.95"), 0.0, 1e-5);  // behind it: all of its strength
  fs::remove_all(folder);
}

// Corners among others, recorded by their facets that carry force.
TEST(TraceCheck, ProvesCornersFromTheirRows) {
  const fs::path folder = fs::temp_directory_path() / ("palpa-trace-corners-" + std::to_string(::getpid()));
  fs::remove_all(folder);
  test::Random random(12);
  TraceWriter writer(folder, {.primitives = true}, "", {"one"});
  constexpr int problems = 500;
  for (int i = 0; i < problems; ++i) {
    test::Problem problem = test::random_problem(random, random.below(4), false);
    const double within_m = random.below(2) == 0 ? 0.0 : 0.001;
    test::add_corner(problem, test::some_facets(random, problem.start_m, within_m, 2 + random.below(7)),
                     random.uniform(0.1, 5));
    PrimitiveSet set;
    test::fill(set, problem);
    Solver solver;
    SubStep step{
        .time_step_s = problem.time_step_s, .probe_m = problem.probe_m, .stiffness_n_per_m = problem.stiffness_n_per_m};
    step.balance = solver.solve(set, problem.start_m, problem.probe_m, problem.stiffness_n_per_m, problem.time_step_s);
    step.primitives = static_cast<std::uint32_t>(set.size());
    std::vector<PlacedPrimitive> placed;
    for (std::size_t j = 0; j < set.size(); ++j) {
      placed.push_back({.primitive = set[j], .force_n = solver.forces_n()[j]});
      if (set[j].kind == PrimitiveKind::directed) step.directed_n += solver.forces_n()[j];
    }
    TickFrame frame;
    frame.tick = i;
    writer.append(frame, {}, {&step, 1}, placed, {});
  }
  writer.finish();
  int balances = 0;
  test::check_balances(folder, [&](const test::CheckedBalance& b) {
    ++balances;
    EXPECT_LE(b.bound_m, b.claimed_m + b.rounding_m) << b.tick;
    EXPECT_LE(b.bound_m, 1e-8) << b.tick;
  });
  EXPECT_EQ(balances, problems);
  fs::remove_all(folder);
}

// Primitives of every kind at a foot.
void place_at_foot(test::Random& random, const Vec3& foot_m, PrimitiveSet& set) {
  const Vec3 away_m = random.in_cube(0.001);
  switch (random.below(5)) {
    case 0: set.plane(0, foot_m + away_m, random.direction(), random.uniform(0.1, 5)); break;
    case 1: set.elastic_plane(0, foot_m + away_m, random.direction(), random.uniform(0.1, 5), random.uniform(50, 2000)); break;
    case 2: set.line(0, foot_m, random.direction(), random.uniform(0, 1), random.uniform(0, 3)); break;
    case 3: set.point(0, foot_m, random.uniform(0, 1), random.uniform(0, 3)); break;
    default: {
      const double strength_n = random.uniform(0.1, 5);
      for (const test::Facet& facet : test::some_facets(random, foot_m, 0.001, 3)) {
        set.add({.kind = PrimitiveKind::corner,
                 .position_m = facet.position_m,
                 .direction = facet.normal,
                 .strength_n = strength_n});
      }
    }
  }
  if (random.below(3) == 0) set.directed(1, random.direction(), random.uniform(0, 1));
}

// Balances of a tool, from their rows alone; each row that is falsified loses the proof.
TEST(TraceCheck, ProvesToolsFromTheirRows) {
  const fs::path folder = fs::temp_directory_path() / ("palpa-trace-tools-" + std::to_string(::getpid()));
  test::Random random(48);
  constexpr int problems = 400;
  // Values falsified by a millimetre, a hundredth of a radian or a tenth.
  enum Falsified { nothing, turn, lever, radius, probe_turn, kinds };
  for (int falsified = nothing; falsified < kinds; ++falsified) {
    fs::remove_all(folder);
    TraceWriter writer(folder, {.primitives = true, .has_tool = true}, "", {"one"});
    for (int i = 0; i < problems; ++i) {
      const std::size_t feet = 1 + static_cast<std::size_t>(random.below(8));
      const Pose start{random.in_cube(0.05), turn_by(random.uniform(0, 3) * random.direction())};
      std::vector<Vec3> levers_m;
      for (std::size_t n = 0; n < feet; ++n) levers_m.push_back(random.in_cube(0.05));
      const Pose probe{start.position_m + random.in_cube(0.005),
                       turned_further(start.turn, random.uniform(0, 0.3) * random.direction())};
      const ToolStep posed{start, probe, levers_m, random.uniform(100, 2000), random.uniform(0.005, 0.1), 1e-3};
      PrimitiveSet set(256);
      set.clear(start.position_m);
      for (std::size_t n = 0; n < feet; ++n) {
        set.begin_foot(static_cast<std::uint16_t>(n), posed.foot_m(n));
        set.begin_mode(0);
        place_at_foot(random, posed.foot_m(n), set);
      }
      PoseSolver solver(256, feet);
      SubStep step{.time_step_s = posed.time_step_s,
                   .start_m = start.position_m,
                   .probe_m = probe.position_m,
                   .stiffness_n_per_m = posed.stiffness_n_per_m,
                   .primitives = static_cast<std::uint32_t>(set.size())};
      step.balance = solver.solve(set, posed);
      step.start_turn = start.turn;
      step.probe_turn = probe.turn;
      step.turning_radius_m = posed.turning_radius_m;
      std::vector<PlacedPrimitive> placed;
      for (std::size_t j = 0; j < set.size(); ++j) {
        placed.push_back({.primitive = set[j], .force_n = solver.forces_n()[j], .lever_m = levers_m[set[j].id.foot]});
        if (set[j].kind == PrimitiveKind::directed) step.directed_n += solver.forces_n()[j];
        if (falsified == lever) placed.back().lever_m += Vec3{1e-3, 1e-3, 1e-3};
      }
      if (falsified == turn) step.balance.turn_rad += Vec3{0.01, 0.01, 0.01};
      if (falsified == radius) step.turning_radius_m *= 1.1;
      if (falsified == probe_turn) step.probe_turn = turned_further(step.probe_turn, {0.01, 0.01, 0.01});
      TickFrame frame;
      frame.tick = i;
      writer.append(frame, {}, {&step, 1}, placed, {});
    }
    writer.finish();
    int balances = 0, proven = 0;
    test::check_balances(folder, [&](const test::CheckedBalance& b) {
      ++balances;
      proven += b.bound_m <= b.claimed_m + b.rounding_m;
      if (falsified != nothing) return;
      EXPECT_LE(b.bound_m, b.claimed_m + b.rounding_m) << b.tick;
      EXPECT_LE(b.bound_m, 1e-8) << b.tick;
    });
    EXPECT_EQ(balances, problems);
    // Some tools turn with nothing that would notice it.
    if (falsified != nothing) {
      EXPECT_LE(proven, problems / 10) << falsified;
    }
  }
  fs::remove_all(folder);
}

}  // namespace trace_check_test
}  // namespace palpa
