// Laws of a tool's balance (pose_solver.h, docs/theory.md 10), without a reference: closed forms, and relations between the
// balances of two problems to the sum of their bounds.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "palpa/solver/corner.h"
#include "palpa/solver/pose_solver.h"
#include "palpa/solver/solver.h"
#include "tests/solver/arbitrary_bits.h"
#include "tests/solver/counted_allocations.h"
#include "tests/solver/pose_problems.h"

namespace palpa::test {
namespace pose_test {

constexpr double half_ulp = 0x1p-53;

// Each family with 1 to 16 feet.
template <class Check>
void over_problems(int repetitions, Check check) {
  for (const PoseFamily& family : pose_families()) {
    for (const int feet : {1, 2, 4, 16}) {
      for (int i = 0; i < repetitions; ++i) {
        Random random(static_cast<std::uint64_t>(1'000'003 * feet + i));
        const PoseProblem problem = family.make(random, feet);
        SCOPED_TRACE(testing::Message() << family.name << ", " << feet << " feet, number " << i);
        check(problem, random);
      }
    }
  }
}

Motion motion_of(const PoseProblem& problem, const Balance& balance) {
  return {balance.position_m - problem.start.position_m, problem.turning_radius_m * balance.turn_rad};
}
// Motion that would bring the tool to the device.
Motion wanted_of(const PoseProblem& problem) {
  return {problem.probe.position_m - problem.start.position_m,
          problem.turning_radius_m * rotation_between_rad(problem.start.turn, problem.probe.turn)};
}
// Rounding of a motion and of the rotation vector between turns [m].
double rounding_of(const PoseProblem& problem, const Motion& motion) {
  return 16.0 * half_ulp * (length(motion) + norm(problem.start.position_m) + problem.turning_radius_m);
}
void expect_same(const PoseProblem& problem, const Balance& a, const Balance& b, double rounding_m) {
  const Motion at = motion_of(problem, a);
  EXPECT_LE(length(at - motion_of(problem, b)), a.error_bound_m + b.error_bound_m + rounding_m + rounding_of(problem, at))
      << "bounds " << a.error_bound_m << " and " << b.error_bound_m << ", rounding " << rounding_m;
}

double width_of(std::span<const Primitive> whole) {
  if (whole.size() == 1) return 1.0;
  std::vector<Vec3> normals;
  for (const Primitive& facet : whole) normals.push_back(facet.direction);
  return detail::width_of(normals);
}

// Largest move of the balance [m] when each residual changes by up to `change_m(p)`: E changes by (s + C (|r| + δ)) δ each, a
// corner's by s δ/σ, and k times the square of the move is at most the sum of those changes at the two balances.
template <class Change>
double moved_by_m(const PoseProblem& problem, const Balance& balance, Change change_m) {
  double change_j = 0.0;
  for (std::size_t i = 0; i < problem.primitives.size(); ++i) {
    const Primitive& p = problem.primitives[i];
    if (p.kind == PrimitiveKind::directed) continue;
    const double delta_m = change_m(p) / width_of(whole_of(problem.primitives, i));
    const Vec3 foot_m = balance_at_foot(balance, problem.levers_m[p.id.foot], problem.turning_radius_m).position_m;
    const double reach_m = 2.0 * norm(residual(p, foot_m)) + delta_m;
    change_j += (2.0 * p.strength_n + p.drag_ns_per_m / problem.time_step_s * reach_m) * delta_m;
  }
  return std::sqrt(change_j / problem.stiffness_n_per_m);
}

TEST(PoseSolver, WithOneFootAtTheCentreIsThePoint) {
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    const Problem point = random_problem(random, 1 + random.below(16), i % 2 == 1);
    PoseProblem tool;
    tool.primitives = point.primitives;
    tool.start = {point.start_m, random_turn(random, 3.0)};
    tool.probe = {point.probe_m, turned_further(tool.start.turn, random.in_cube(0.5))};
    tool.levers_m = {{}};
    tool.stiffness_n_per_m = point.stiffness_n_per_m;
    PrimitiveSet set(16);
    fill(set, point);
    const Balance at = solve_once(set, point.start_m, point.probe_m, point.stiffness_n_per_m, point.time_step_s);
    const Balance balance = solved(tool).balance;
    EXPECT_LE(distance(balance.position_m, at.position_m), balance.error_bound_m + at.error_bound_m + 1e-17);
    EXPECT_LE(distance(balance.turn_rad, rotation_between_rad(tool.start.turn, tool.probe.turn)),
              balance.error_bound_m / tool.turning_radius_m + 4e-15)
        << "nothing turns it from the device's orientation";
  }
}

TEST(PoseSolver, TurnsWithTheScene) {
  over_problems(6, [](const PoseProblem& problem, Random& random) {
    const Turn turn = random_turn(random, 3.0);
    const Vec3 shift_m = random.in_cube(0.02);
    PoseProblem other = problem;
    for (Pose* pose : {&other.start, &other.probe})
      *pose = {rotated(turn, pose->position_m) + shift_m, unit_turn(turn * pose->turn)};
    for (Vec3& lever_m : other.levers_m) lever_m = rotated(turn, lever_m);
    for (Primitive& p : other.primitives) {
      if (p.kind != PrimitiveKind::directed) p.position_m = rotated(turn, p.position_m) + shift_m;
      p.direction = p.kind == PrimitiveKind::point ? Vec3{} : normalized(rotated(turn, p.direction));
    }
    const Balance a = solved(problem).balance, b = solved(other).balance;
    Balance back = b;
    back.position_m = rotated(inverse(turn), b.position_m - shift_m);
    back.turn_rad = rotated(inverse(turn), b.turn_rad);
    double directed_n = 0.0;
    for (const Primitive& p : problem.primitives) {
      if (p.kind == PrimitiveKind::directed)
        directed_n += p.strength_n * (1.0 + norm(problem.levers_m[p.id.foot]) / problem.turning_radius_m);
    }
    const auto rounding_of_place = [&](const Vec3& x_m) { return 32.0 * half_ulp * (norm(x_m) + norm(shift_m)); };
    const double rounding_m =
        rounding_of_place(a.position_m) + rounding_of_place(problem.probe.position_m) +
        32.0 * half_ulp * (directed_n / problem.stiffness_n_per_m + problem.turning_radius_m * (1.0 + norm(a.turn_rad))) +
        moved_by_m(problem, a, [&](const Primitive& p) {
          const double lever_m = norm(problem.levers_m[p.id.foot]) * (1.0 + norm(a.turn_rad));
          return rounding_of_place(p.position_m) + rounding_of_place(a.position_m) +
                 64.0 * half_ulp * (lever_m + distance(p.position_m, a.position_m));
        });
    expect_same(problem, a, back, rounding_m);
  });
}

TEST(PoseSolver, IsTheSameInAnyOrderOfFeet) {
  over_problems(6, [](const PoseProblem& problem, Random& random) {
    const std::size_t n = problem.levers_m.size();
    std::vector<std::size_t> place(n);  // of each foot
    for (std::size_t i = 0; i < n; ++i) place[i] = i;
    for (std::size_t i = n; i-- > 1;)
      std::swap(place[i], place[static_cast<std::size_t>(random.below(static_cast<int>(i) + 1))]);
    PoseProblem other = problem;
    for (std::size_t i = 0; i < n; ++i) other.levers_m[place[i]] = problem.levers_m[i];
    for (Primitive& p : other.primitives) p.id.foot = static_cast<std::uint16_t>(place[p.id.foot]);
    std::stable_sort(other.primitives.begin(), other.primitives.end(),
                     [](const Primitive& a, const Primitive& b) { return a.id.foot < b.id.foot; });
    expect_same(problem, solved(problem).balance, solved(other).balance, 0.0);
  });
}

// Each primitive in parts that add up to it without rounding, at feet of one place.
TEST(PoseSolver, TakesFeetAtOnePlaceForOneFootOfTheirSharesTogether) {
  over_problems(6, [](const PoseProblem& problem, Random&) {
    PoseProblem split = problem;
    const std::size_t n = problem.levers_m.size();
    split.levers_m.insert(split.levers_m.end(), problem.levers_m.begin(), problem.levers_m.end());
    split.primitives.clear();
    for (const double share : {0.25, 0.75}) {
      for (Primitive p : problem.primitives) {
        p.strength_n *= share, p.drag_ns_per_m *= share, p.stiffness_n_per_m *= share;
        if (share == 0.75) p.id.foot = static_cast<std::uint16_t>(p.id.foot + n);
        split.primitives.push_back(p);
      }
    }
    // Three quarters of a double can be rounded.
    double forces_n = 0.0;
    const Balance whole = solved(problem).balance;
    for (const Primitive& p : problem.primitives) {
      const Vec3 foot_m = balance_at_foot(whole, problem.levers_m[p.id.foot], problem.turning_radius_m).position_m;
      const double beta = norm(problem.levers_m[p.id.foot]) / problem.turning_radius_m;
      forces_n += (p.strength_n + p.drag_ns_per_m / problem.time_step_s * norm(residual(p, foot_m))) * (1.0 + beta);
    }
    expect_same(problem, whole, solved(split).balance, 4.0 * half_ulp * forces_n / problem.stiffness_n_per_m);
  });
}

// All lengths and all forces twice as large: powers of two have no rounding.
TEST(PoseSolver, KnowsNoScale) {
  over_problems(6, [](const PoseProblem& problem, Random&) {
    for (const auto& [lengths, forces] : {std::pair{2.0, 2.0}, std::pair{1.0, 0.25}, std::pair{0.5, 4.0}}) {
      PoseProblem other = problem;
      other.start.position_m *= lengths, other.probe.position_m *= lengths;
      for (Vec3& lever_m : other.levers_m) lever_m *= lengths;
      other.turning_radius_m *= lengths;
      other.stiffness_n_per_m *= forces / lengths;
      for (Primitive& p : other.primitives) {
        p.position_m *= lengths;
        p.strength_n *= forces, p.drag_ns_per_m *= forces / lengths, p.stiffness_n_per_m *= forces / lengths;
      }
      Balance b = solved(other).balance;
      b.position_m = b.position_m / lengths, b.error_bound_m /= lengths;
      expect_same(problem, solved(problem).balance, b, 0.0);
    }
  });
}

// Without contact the wrench of the spring is that of the directed forces, K (z − c) = Σ Jᵀd. About another point g of the
// handle the wrench is (f, τ + (p − g) × f) and the spring K = XᵀK₀X with X from the motion of g to that of the centre: the
// same balance.
TEST(PoseSolver, HasTheWrenchOfItsDirectedForcesAboutAnyPointOfTheHandle) {
  Random random(7);
  for (int i = 0; i < 500; ++i) {
    PoseProblem problem = pose_families()[0].make(random, 1 + random.below(16));
    Vec3 force_n, torque_nm, torque_at_g_nm;
    const Vec3 g = random.in_cube(0.1);  // from the centre
    for (Primitive& p : problem.primitives) {
      p.kind = PrimitiveKind::directed, p.position_m = {}, p.direction = random.direction();
      const Vec3 one_n = p.strength_n * p.direction, lever_m = problem.levers_m[p.id.foot];
      force_n += one_n, torque_nm += cross(lever_m, one_n), torque_at_g_nm += cross(lever_m - g, one_n);
    }
    const Balance balance = solved(problem).balance;
    const double k = problem.stiffness_n_per_m, kappa = k * problem.turning_radius_m * problem.turning_radius_m;
    const Motion stretch = motion_of(problem, balance) - wanted_of(problem);
    const Vec3 turned_rad = stretch.arc_m / problem.turning_radius_m;
    EXPECT_LE(norm(k * stretch.way_m - force_n), k * balance.error_bound_m + 1e-13);
    EXPECT_LE(norm(kappa * turned_rad - torque_nm), k * problem.turning_radius_m * balance.error_bound_m + 1e-13);
    // The stretch as g has it, and the transported spring.
    const Vec3 way_of_g_m = stretch.way_m + cross(turned_rad, g);
    const Vec3 at_g_n = k * (way_of_g_m - cross(turned_rad, g));
    const Vec3 at_g_nm = kappa * turned_rad - cross(g, at_g_n);
    EXPECT_LE(norm(at_g_n - force_n), k * balance.error_bound_m + 1e-13);
    EXPECT_LE(norm(at_g_nm - torque_at_g_nm), k * (problem.turning_radius_m + 0.2) * balance.error_bound_m + 1e-13);
  }
}

// |Δz|² ≤ Δz·Δc in the metric; each balance is off by its bound at most.
TEST(PoseSolver, IsFirmlyNonExpansiveInTheMetric) {
  over_problems(10, [](const PoseProblem& problem, Random& random) {
    const Balance first = solved(problem).balance;
    for (const double far : {0.3, 1e-3, 1e-6}) {
      PoseProblem moved = problem;
      moved.probe.position_m += 0.02 * far * random.in_cube(1.0);
      moved.probe.turn = turned_further(problem.probe.turn, far * random.in_cube(1.0));
      if (norm(rotation_between_rad(moved.start.turn, moved.probe.turn)) > 3.0) continue;  // the logarithm jumps at π
      const Balance second = solved(moved).balance;
      const Motion dz = motion_of(moved, second) - motion_of(problem, first), dc = wanted_of(moved) - wanted_of(problem);
      const double off = first.error_bound_m + second.error_bound_m + 2.0 * rounding_of(problem, motion_of(problem, first));
      EXPECT_LE(dot(dz, dz), dot(dz, dc) + off * (2.0 * (length(dz) + off) + off + length(dc)));
    }
  });
}

// The spring's wrench k (c − z), with the torque divided by ρ, changes by at most k per metre of the metric: no number of feet
// makes the tool stiffer. A tool held by strong points has that stiffness.
TEST(PoseSolver, IsNoStifferThanItsSpring) {
  double steepest = 0.0;
  over_problems(6, [&](const PoseProblem& made, Random& random) {
    for (const bool is_held : {false, true}) {
      PoseProblem problem = made;
      for (Primitive& p : problem.primitives) {
        if (is_held && p.kind == PrimitiveKind::point) p.strength_n = 1e3;
      }
      const Balance first = solved(problem).balance;
      PoseProblem moved = problem;
      moved.probe.position_m += random.in_cube(1e-3);
      moved.probe.turn = turned_further(problem.probe.turn, random.in_cube(0.02));
      if (norm(wanted_of(moved).arc_m) > 3.0 * moved.turning_radius_m) return;
      const Balance second = solved(moved).balance;
      const Motion dc = wanted_of(moved) - wanted_of(problem), dz = motion_of(moved, second) - motion_of(problem, first);
      const double off = first.error_bound_m + second.error_bound_m + rounding_of(problem, dc);
      EXPECT_LE(length(dc - dz), length(dc) + off);
      steepest = std::max(steepest, length(dc - dz) / length(dc));
    }
  });
  EXPECT_GE(steepest, 1.0 - 1e-6);
}

TEST(PoseSolver, IsTheSameFromAnyStart) {
  over_problems(4, [](const PoseProblem& made, Random& random) {
    PoseProblem problem = made;
    const std::size_t capacity = std::max<std::size_t>(2, problem.primitives.size());
    PoseSolver solver(capacity, problem.levers_m.size());
    PrimitiveSet set(capacity);
    for (int tick = 0; tick < 6; ++tick) {
      expect_same(problem, solved(problem, solver, set).balance, solved(problem).balance, 0.0);
      const double far = tick % 2 == 0 ? 1e-6 : 5e-4;
      problem.probe.position_m += random.in_cube(far);
      problem.probe.turn = turned_further(problem.probe.turn, 20.0 * random.in_cube(far));
      if (tick == 3) solver.reset();
      if (tick == 4) std::reverse(problem.levers_m.begin(), problem.levers_m.end());
    }
  });
}

TEST(PoseSolver, NeedsNoAllocation) {
  over_problems(2, [](const PoseProblem& problem, Random&) {
    const std::size_t capacity = std::max<std::size_t>(2, problem.primitives.size());
    PoseSolver solver(capacity, problem.levers_m.size());
    PrimitiveSet set(capacity);
    fill(set, problem);
    const ToolStep step = problem.step();
    const long before = allocations;
    for (int i = 0; i < 2; ++i) solver.solve(set, step);
    solver.reset();
    solver.solve(set, step);
    EXPECT_EQ(allocations, before);
  });
}

TEST(PoseSolver, AnswersTheDeviceInFreeSpaceToTheBit) {
  Random random(8);
  for (int i = 0; i < 200; ++i) {
    PoseProblem problem = pose_families()[0].make(random, 4);
    for (Primitive& p : problem.primitives) p.position_m -= 0.5 * p.direction;
    const Balance far = solved(problem).balance;
    problem.primitives.clear();
    const Balance none = solved(problem).balance;
    for (const Balance& balance : {far, none}) {
      EXPECT_EQ(balance.position_m, problem.probe.position_m);
      EXPECT_EQ(balance.turn_rad, rotation_between_rad(problem.start.turn, problem.probe.turn));
      EXPECT_LE(balance.error_bound_m, 1e-15);
    }
  }
}

// A rod on two feet, its centre off the middle, pressed straight down: the loads share as the levers do.
TEST(PoseSolver, LoadsARodOnTwoFeetByTheLeverRule) {
  PoseProblem problem;
  problem.levers_m = {{-0.03, 0, 0}, {0.05, 0, 0}};
  problem.stiffness_n_per_m = 400;
  problem.probe.position_m = {0, 0, -0.006};
  for (std::uint16_t foot = 0; foot < 2; ++foot)
    problem.primitives.push_back({PrimitiveKind::plane, {0, foot, foot}, problem.levers_m[foot], {0, 0, 1}, 5});
  const PoseSolved result = solved(problem);
  EXPECT_EQ(result.balance.status, BalanceStatus::exact);
  EXPECT_LE(norm(result.balance.position_m), 1e-12);
  EXPECT_LE(norm(result.balance.turn_rad), 1e-12);
  EXPECT_NEAR(result.forces_n[0].z, 1.5, 1e-9);
  EXPECT_NEAR(result.forces_n[1].z, 0.9, 1e-9);
}

// Coupling and tool in series: a foot across a wall feels 1/(1/k + |b × n|²/κ).
TEST(PoseSolver, FeelsAWallThroughBothSprings) {
  Random random(9);
  for (int i = 0; i < 500; ++i) {
    PoseProblem problem;
    problem.levers_m = {random.in_cube(0.1)};
    problem.turning_radius_m = random.uniform(0.01, 0.1);
    problem.stiffness_n_per_m = random.uniform(100, 2000);
    const Vec3 n = random.direction();
    problem.primitives = {{PrimitiveKind::plane, {}, problem.step().foot_m(0), n, 100}};
    const double depth_m = random.uniform(0, 0.005), k = problem.stiffness_n_per_m;
    problem.probe.position_m = -depth_m * n;
    const double kappa = k * problem.turning_radius_m * problem.turning_radius_m;
    const double felt_n = depth_m / (1.0 / k + norm_squared(cross(problem.levers_m[0], n)) / kappa);
    const PoseSolved result = solved(problem);
    EXPECT_NEAR(norm(result.forces_n[0]), felt_n, k * result.balance.error_bound_m + 1e-13);
    EXPECT_LE(norm(k * (result.balance.position_m - problem.probe.position_m) - felt_n * n),
              k * result.balance.error_bound_m + 1e-13);
  }
}

// A ring of N feet, each held by s, spun by more than they hold: N s r; and slid: N s.
TEST(PoseSolver, SpinsARingAgainstTheStrengthOfAllFeetTimesItsRadius) {
  constexpr int n = 8;
  constexpr double radius_m = 0.01, strength_n = 0.1;
  PoseProblem problem;
  problem.turning_radius_m = 0.03, problem.stiffness_n_per_m = 500;
  for (std::uint16_t foot = 0; foot < n; ++foot) {
    const double angle_rad = 2.0 * 3.14159265358979323846 * foot / n;
    problem.levers_m.push_back({radius_m * std::cos(angle_rad), radius_m * std::sin(angle_rad), 0});
    problem.primitives.push_back({PrimitiveKind::line, {0, foot, foot}, problem.levers_m.back(), {0, 0, 1}, strength_n});
  }
  const double kappa = 500 * 0.03 * 0.03;
  problem.probe.turn = turn_by({0, 0, 0.1});
  const Balance spun = solved(problem).balance;
  EXPECT_NEAR(kappa * (0.1 - spun.turn_rad.z), n * strength_n * radius_m, kappa * spun.error_bound_m / 0.03 + 1e-15);
  EXPECT_LE(norm(spun.position_m), spun.error_bound_m);
  problem.probe = {{0.02, 0, 0}, {}};
  const Balance slid = solved(problem).balance;
  EXPECT_NEAR(500 * (0.02 - slid.position_m.x), n * strength_n, 500 * slid.error_bound_m + 1e-15);
}

// Feet move on arcs: a foot ends at most |ω|²|b|/2 off its linear way, at most |ω|h/4 where no foot moves further than h/2.
TEST(PoseSolver, HasFeetOnArcsNearTheirLinearWays) {
  Random random(13);
  double tightest = 0.0;
  for (int i = 0; i < 10000; ++i) {
    const Vec3 lever_m = random.in_cube(0.1), turn_rad = random.log_uniform(1e-6, 1.0) * random.direction();
    const double off_m = distance(rotated(turn_by(turn_rad), lever_m), lever_m + cross(turn_rad, lever_m));
    const double across_m = norm(cross(normalized(turn_rad), lever_m));
    EXPECT_LE(off_m, 0.5 * norm_squared(turn_rad) * across_m + 2e-16);
    EXPECT_LE(off_m, 0.5 * norm(turn_rad) * norm(cross(turn_rad, lever_m)) + 2e-16) << "half the angle times its way";
    if (norm(turn_rad) > 1e-3) tightest = std::max(tightest, off_m / (0.5 * norm_squared(turn_rad) * across_m));
  }
  EXPECT_GE(tightest, 0.999);
}

TEST(PoseSolver, RefusesWhatIsNoProblem) {
  Random random(10);
  const PoseProblem good = pose_families()[0].make(random, 4);
  ASSERT_EQ(solved(good).balance.status, BalanceStatus::exact);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const auto expect_refused = [&](const char* name, auto spoil) {
    PoseProblem problem = good;
    spoil(problem);
    const std::size_t capacity = good.primitives.size();
    PrimitiveSet set(capacity);
    fill(set, good);
    PoseSolver solver(capacity, 4);
    solver.solve(set, good.step());
    const Balance balance = solver.solve(set, problem.step());
    EXPECT_EQ(balance.status, BalanceStatus::bad_input) << name;
    EXPECT_EQ(balance.turn_rad, Vec3{}) << name;
    EXPECT_TRUE(is_finite(balance.position_m)) << name;
    if (is_finite(problem.start.position_m) && norm(problem.start.position_m) < 1e6) {
      EXPECT_EQ(balance.position_m, problem.start.position_m) << name;
    }
    EXPECT_EQ(balance.error_bound_m, std::numeric_limits<double>::max()) << name;
    for (const Vec3& force : solver.forces_n()) EXPECT_EQ(force, Vec3{}) << name;
    const std::vector<Vec3> none(capacity);
    EXPECT_EQ(PoseSolver::error_bound_m(set, none, problem.step(), {}), std::numeric_limits<double>::max()) << name;
  };
  for (const double value : {nan, inf, -inf}) {
    expect_refused("start", [&](PoseProblem& p) { p.start.position_m.y = value; });
    expect_refused("probe", [&](PoseProblem& p) { p.probe.position_m.z = value; });
    expect_refused("turn", [&](PoseProblem& p) { p.start.turn.w = value; });
    expect_refused("turn of the probe", [&](PoseProblem& p) { p.probe.turn.x = value; });
    expect_refused("lever", [&](PoseProblem& p) { p.levers_m[2].x = value; });
    expect_refused("k", [&](PoseProblem& p) { p.stiffness_n_per_m = value; });
    expect_refused("radius", [&](PoseProblem& p) { p.turning_radius_m = value; });
  }
  expect_refused("no rotation", [](PoseProblem& p) { p.probe.turn = {}, p.probe.turn.w = 0; });
  expect_refused("length 1.01", [](PoseProblem& p) { p.start.turn = {1.01, 0, 0, 0}; });
  expect_refused("radius 0", [](PoseProblem& p) { p.turning_radius_m = 0; });
  expect_refused("radius -1", [](PoseProblem& p) { p.turning_radius_m = -1; });
  expect_refused("k 0", [](PoseProblem& p) { p.stiffness_n_per_m = 0; });
  expect_refused("far", [](PoseProblem& p) { p.probe.position_m.x = 1e7; });
  expect_refused("foot without lever", [](PoseProblem& p) { p.levers_m.pop_back(); });
  expect_refused("no levers", [](PoseProblem& p) { p.levers_m.clear(); });
}

TEST(PoseSolver, RefusesADragWithoutTime) {
  PoseProblem problem;
  problem.levers_m = {{0.01, 0, 0}};
  problem.primitives = {{PrimitiveKind::point, {}, {0.01, 0, 0}, {}, 1, 1}};
  for (const double time_step_s : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    problem.time_step_s = time_step_s;
    EXPECT_EQ(solved(problem).balance.status, BalanceStatus::bad_input);
  }
  problem.primitives[0].drag_ns_per_m = 0;
  EXPECT_EQ(solved(problem).balance.status, BalanceStatus::exact);
}

#ifdef NDEBUG
TEST(PoseSolver, RefusesASetLargerThanItsCapacity) {
  Random random(11);
  const PoseProblem problem = pose_families()[0].make(random, 4);
  PrimitiveSet set(4);
  fill(set, problem);
  PoseSolver small(3, 4), few_feet(4, 3);
  EXPECT_EQ(small.solve(set, problem.step()).status, BalanceStatus::bad_input);
  EXPECT_EQ(few_feet.solve(set, problem.step()).status, BalanceStatus::bad_input);
}
#endif

// Problems of arbitrary bits: finite answers, and the bound of a solver that never lies about its status.
TEST(PoseSolver, IsFiniteForArbitraryBits) {
  using namespace arbitrary;
  Random random(12);
  constexpr int most = 8;
  PoseSolver solver(most, most);
  PrimitiveSet set(most);
  int exact = 0, bad_input = 0;
  for (int i = 0; i < 100000; ++i) {
    constexpr int shares[] = {1, 4, 30, 300};
    const int one_in = shares[random.below(4)];
    const auto turn = [&] {
      Turn one = random_turn(random, 3.1);
      for (double* part : {&one.w, &one.x, &one.y, &one.z})
        if (random.below(4 * one_in) == 0) *part = hostile(random);
      return one;
    };
    PoseProblem problem;
    problem.start = {place(random, one_in), turn()};
    problem.probe = {place(random, one_in), turn()};
    problem.stiffness_n_per_m = number(random, one_in, 1, 3000);
    problem.turning_radius_m = number(random, one_in, 0.001, 0.1);
    problem.time_step_s = number(random, one_in, 1e-4, 1e-2);
    for (int foot = random.below(most + 1); foot > 0; --foot) problem.levers_m.push_back(place(random, one_in));
    set.clear(problem.start.position_m);
    for (int n = random.below(most + 1); n > 0; --n) {
      const auto foot = static_cast<std::size_t>(random.below(most));
      const Vec3 foot_m = foot < problem.levers_m.size() ? problem.step().foot_m(foot) : Vec3{};
      if (random.below(10) > 0 && foot >= problem.levers_m.size()) continue;
      set.begin_foot(static_cast<std::uint16_t>(foot), foot_m);
      Primitive p;
      p.kind = static_cast<PrimitiveKind>(random.below(5));
      p.id.slot = static_cast<std::uint16_t>(n);
      p.position_m = random.below(2) == 0 ? foot_m : place(random, one_in);
      p.direction = direction(random, one_in);
      p.strength_n = number(random, one_in, 0, 5);
      p.drag_ns_per_m = random.below(2) == 0 ? 0.0 : number(random, one_in, 0, 20);
      if (random.below(4) == 0) p.stiffness_n_per_m = number(random, one_in, 10, 1000);
      set.add(p);
    }
    const ToolStep step = problem.step();
    const Balance balance = solver.solve(set, step);
    ASSERT_TRUE(is_finite(balance.position_m) && is_finite(balance.turn_rad) && std::isfinite(balance.error_bound_m)) << i;
    ASSERT_GE(balance.error_bound_m, 0.0) << i;
    ASSERT_EQ(solver.forces_n().size(), set.size()) << i;
    for (const Vec3& force : solver.forces_n()) ASSERT_TRUE(is_finite(force)) << i;
    if (balance.status != BalanceStatus::bad_input) {
      EXPECT_EQ(balance.status == BalanceStatus::exact, balance.error_bound_m <= exact_bound_m) << i;
      const double certified_m = PoseSolver::error_bound_m(set, solver.forces_n(), step, balance);
      EXPECT_GE(certified_m, 0.0) << i;
      for (const Primitive& p : set.primitives()) {
        const Balance at = balance_at_foot(balance, problem.levers_m[p.id.foot], problem.turning_radius_m);
        EXPECT_TRUE(is_finite(at.position_m) && std::isfinite(at.error_bound_m)) << i;
      }
    }
    exact += balance.status == BalanceStatus::exact;
    bad_input += balance.status == BalanceStatus::bad_input;
  }
  EXPECT_GE(exact, 10000);
  EXPECT_GE(bad_input, 10000);
}

}  // namespace pose_test
}  // namespace palpa::test
