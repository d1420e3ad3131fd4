// Traces of tools, checked from their files alone (docs/trace.md).
#include <gtest/gtest.h>
#include <unistd.h>

#include <map>

#include "palpa/device/hand.h"
#include "palpa/palpa.h"
#include "palpa/study/run.h"
#include "tests/laws/shipped_scenes.h"
#include "tests/laws/trace_check.h"

namespace palpa {
namespace tool_traces_test {

namespace fs = std::filesystem;
using Sets = std::vector<std::pair<std::string, std::string>>;

struct Held {
  Sets tool;
  double ahead_m;  // of the hand, its foremost foot
};
const Held stylus{{{"tool.shape", "rod"}, {"tool.length_m", "0.06"}, {"tool.points", "13"}, {"tool.centre_m", "[0, 0, 0.03]"}},
                  0.06};
const Held pad{{{"tool.shape", "pad"}, {"tool.radius_m", "0.012"}, {"tool.points", "24"}, {"tool.share", "0.0416"}}, 0.0};
const Held ball{{{"tool.shape", "ball"}, {"tool.radius_m", "0.006"}, {"tool.points", "32"}}, 0.006};

class ToolTraces : public testing::Test {
 protected:
  const fs::path folder_ = fs::temp_directory_path() / ("palpa-tool-traces-" + std::to_string(::getpid()));
  void SetUp() override { fs::remove_all(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  /// Runs a hand that meets the face, about 57 mm in front of the middle, with the foremost foot.
  void record(const Held& held, const std::string& hand) const {
    constexpr double face_m = 0.057, ball_m = 0.075;  // of the data; of the front that hands without a scene meet
    RunOptions options;
    options.scene = test::scene_file("head_phantom");
    options.out = folder_;
    options.primitives = true;
    options.duration_s = 2.0;
    options.target = displaced(simulated_target(hand), {0, 0, face_m + held.ahead_m - ball_m});
    options.hold = Hold::relaxed;
    options.scene_options.sets = held.tool;
    run(options);
  }
};

TEST_F(ToolTraces, ProveEachOfTheirBalances) {
  for (const auto& [tool, hand] : {std::pair{stylus, "sim:stroke,tilt_rad=0.4"}, std::pair{pad, "sim:press,tilt_rad=0.1"},
                                   std::pair{ball, "sim:random,tilt_rad=0.8"}}) {
    fs::remove_all(folder_);
    record(tool, hand);
    int balances = 0, capped = 0;
    test::check_balances(folder_, [&](const test::CheckedBalance& b) {
      ASSERT_TRUE(b.status == "exact" || b.status == "capped") << "tick " << b.tick << ": " << b.status;
      ++balances;
      capped += b.status == "capped";
      if (b.status == "exact") {
        ASSERT_LE(b.claimed_m, exact_bound_m) << "tick " << b.tick;
      }
      ASSERT_LE(b.bound_m, b.claimed_m + b.rounding_m) << hand << ": tick " << b.tick << ", sub-step " << b.sub_step;
    });
    EXPECT_GE(balances, 1900) << hand;
    EXPECT_LE(capped, balances / 100) << hand;
    double force_n = 0.0;
    for (const auto& [tick] : TraceReader(folder_).ticks()) force_n = std::max(force_n, norm(tick.result.force_n));
    EXPECT_GT(force_n, 0.1) << hand << ": it is felt";
  }
}

// Force and torque of each tick without damper are those of the spring between both poses of its row, but for the time after a
// waiting row, in which what was withheld returns.
TEST_F(ToolTraces, HaveTheForceAndTorqueOfTheSpring) {
  Held undamped = stylus;
  undamped.tool.emplace_back("coupling.damping_ns_per_m", "0");
  record(undamped, "sim:stroke,tilt_rad=0.4");
  test::CsvRows ticks(folder_ / "ticks.csv"), balances(folder_ / "balances.csv");
  ASSERT_TRUE(balances.next());
  const double k = balances.number("k_n_per_m"), radius_m = balances.number("turning_radius_m");
  double largest_nm = 0.0;
  std::int64_t returned_at = 0;
  while (ticks.next()) {
    if (ticks.text("status") == "waiting") returned_at = ticks.integer("tick") + 40;
    if (ticks.text("status") != "resting" || ticks.integer("tick") < returned_at) continue;
    const Vec3 force_n = k * (ticks.vector("proxy", "m") - ticks.vector("probe", "m"));
    const Vec3 torque_nm = k * radius_m * radius_m * rotation_between_rad(ticks.turn("probe_turn"), ticks.turn("proxy_turn"));
    EXPECT_LE(distance(ticks.vector("force", "n"), force_n), 1e-9) << ticks.place();
    EXPECT_LE(distance(ticks.vector("torque", "nm"), torque_nm), 1e-9) << ticks.place();
    largest_nm = std::max(largest_nm, norm(torque_nm));
  }
  EXPECT_GT(largest_nm, 1e-3);
}

// Steps of a tick follow one another, and each moves its share of the way to its balance.
TEST_F(ToolTraces, HaveStepsThatFollowOneAnother) {
  record(ball, "sim:press,tilt_rad=0.5");
  test::CsvRows balances(folder_ / "balances.csv");
  Pose last;
  bool first = true;
  int moved = 0;
  while (balances.next()) {
    const Pose start{balances.vector("start", "m"), balances.turn("start_turn")};
    const Pose proxy{balances.vector("proxy", "m"), balances.turn("proxy_turn")};
    EXPECT_TRUE(is_unit(proxy.turn, 1e-14)) << balances.place();
    if (!first) {
      EXPECT_LE(distance(start.position_m, last.position_m), 1e-12) << balances.place();
      EXPECT_LE(norm(rotation_between_rad(start.turn, last.turn)), 1e-12) << balances.place();
    }
    if (balances.text("stop") == "full") {
      const double share = balances.number("move_fraction");
      const Vec3 way_m = share * (balances.vector("balance", "m") - start.position_m);
      EXPECT_LE(distance(proxy.position_m, start.position_m + way_m), 1e-9) << balances.place();
      EXPECT_LE(norm(rotation_between_rad(turned_further(start.turn, share * balances.vector("turn", "rad")), proxy.turn)),
                1e-7)
          << balances.place();
      ++moved;
    }
    last = proxy;
    first = false;
  }
  EXPECT_GT(moved, 1000);
}

// The energies that modes take out and bring in, by tick, are the works of their primitives at their feet, less what elastic
// levels gave.
TEST_F(ToolTraces, HaveTheWorksOfTheirFeet) {
  record(stylus, "sim:stroke,tilt_rad=0.4");
  std::map<std::int64_t, std::pair<double, double>> works;  // dissipated, injected
  test::check_works(folder_, [&](const test::CheckedWork& work) {
    auto& [dissipated_j, injected_j] = works[work.tick];
    (work.work_j < 0.0 ? dissipated_j : injected_j) += std::abs(work.work_j);
  });
  test::CsvRows ticks(folder_ / "ticks.csv");
  double all_j = 0.0, last_elastic_j = 0.0;
  while (ticks.next()) {
    const auto [dissipated_j, injected_j] = works[ticks.integer("tick")];
    const double elastic_j = ticks.number("elastic_j");
    // A mode's works of opposite sign cancel within a tick, so the sum is what both have in common.
    EXPECT_NEAR(ticks.number("injected_j") - ticks.number("dissipated_j"),
                injected_j - dissipated_j + elastic_j - last_elastic_j, 1e-12)
        << ticks.place();
    last_elastic_j = elastic_j;
    all_j += dissipated_j;
  }
  EXPECT_GT(all_j, 1e-4);
}

}  // namespace tool_traces_test
}  // namespace palpa
