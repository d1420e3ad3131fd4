// The solver against the certified reference over every family. PALPA_PROBLEMS_TIMES=86 in the environment makes
// NeverExceedsTheBound take 86 times as many problems, about a million.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <tuple>

#include "tests/solver/all_faces.h"
#include "tests/solver/counted_allocations.h"
#include "tests/solver/reference.h"
#include "tests/solver/solved.h"

namespace palpa::test {
namespace degenerate_test {

// Share of a family's problems that may have a plain bound above 1e-9 m: rounding to double alone can keep it there.
double allowed_share(const Family& family) {
  if (family.at_proxy) return 0.0;
  const std::string_view name = family.name;
  if (name == "nearly_parallel_lines") return 0.01;
  if (name == "wide_strengths") return 0.04;
  if (name == "mixture" || name == "elastic_mixture") return 0.05;
  if (name == "corner_mixture" || name == "elastic_corner_mixture") return 0.01;
  return 0.001;
}

// One test for each family, with and without drags.
class Accuracy : public testing::TestWithParam<std::tuple<std::size_t, bool>> {
 protected:
  const Family& family() const { return families()[std::get<0>(GetParam())]; }
  bool drags() const { return std::get<1>(GetParam()); }

  void check(const Recipe& recipe) {
    const Problem problem = recipe.problem();
    const Solved result = solved(problem);
    const Balance& balance = result.balance;
    ++problems_;
    ASSERT_TRUE(is_finite(balance.position_m)) << recipe;
    ASSERT_NE(balance.status, BalanceStatus::bad_input) << recipe;
    EXPECT_EQ(balance.status == BalanceStatus::exact, balance.error_bound_m <= exact_bound_m) << recipe;
    worst_bound_m_ = std::max(worst_bound_m_, balance.error_bound_m);
    if (family().at_proxy) {
      EXPECT_LE(balance.error_bound_m, 1e-9) << recipe;
    }
    const double plain_m = plain_bound_m(problem, result.forces_n, balance.position_m, result.remainder_m);
    worst_plain_m_ = std::max(worst_plain_m_, plain_m);
    above_ += !(plain_m <= 1e-9);

    const Reference reference = reference_balance(problem);
    if (!reference.certified) {
      ++uncertified_;
      std::printf("reference not certified: %s%s, n = %d, seed %llu: %.1e m\n", family().name, drags() ? " with drags" : "",
                  recipe.n, static_cast<unsigned long long>(recipe.seed), static_cast<double>(reference.bound_m));
      return;
    }
    const double error = error_m(reference, balance.position_m);
    worst_error_m_ = std::max(worst_error_m_, error);
    // The reference itself is off by its own bound at most.
    const double slack = static_cast<double>(reference.bound_m);
    EXPECT_LE(error, balance.error_bound_m + slack) << recipe;
    if (balance.status == BalanceStatus::exact) {
      EXPECT_LE(error, 1e-9 + slack) << recipe << ", bound " << balance.error_bound_m;
    }
  }

  // At most as many above 1e-9 m as chance allows at the family's share (four standard deviations and one).
  void check_share() {
    const double expected = allowed_share(family()) * problems_;
    EXPECT_LE(above_, family().at_proxy ? 0.0 : expected + 4.0 * std::sqrt(expected) + 1.0)
        << "of " << problems_ << " have a plain bound above 1e-9 m; the worst is " << worst_plain_m_;
    std::printf(
        "%d problems: error <= %.1e m, bound <= %.1e m, plain bound <= %.1e m, above 1e-9 m %d, reference not certified %d\n",
        problems_, worst_error_m_, worst_bound_m_, worst_plain_m_, above_, uncertified_);
  }

 private:
  int problems_ = 0;
  int above_ = 0;
  int uncertified_ = 0;
  double worst_error_m_ = 0.0;
  double worst_bound_m_ = 0.0;
  double worst_plain_m_ = 0.0;
};

TEST_P(Accuracy, NeverExceedsTheBound) {
  const char* asked = std::getenv("PALPA_PROBLEMS_TIMES");
  const int times = asked ? std::max(1, std::atoi(asked)) : 1;
  for_each_problem(family(), drags(), {0}, 1, [&](const Recipe& recipe) { check(recipe); });
  for_each_problem(family(), drags(), {1, 2, 3, 4, 5, 6, 7, 8}, 12 * times, [&](const Recipe& recipe) { check(recipe); });
  for_each_problem(family(), drags(), {16, 32}, 4 * times, [&](const Recipe& recipe) { check(recipe); });
  for_each_problem(family(), drags(), {64}, 2 * times, [&](const Recipe& recipe) { check(recipe); });
  for_each_problem(family(), drags(), {1000}, 1, [&](const Recipe& recipe) { check(recipe); });
  check_share();
}

// At rest, a session's usual state: repeated solves of one point, from where it was.
TEST_P(Accuracy, IsKeptAlongAWarmPath) {
  for_each_problem(family(), drags(), {1, 2, 3, 5, 6, 12}, 2, [&](const Recipe& recipe) {
    Problem problem = recipe.problem();
    Random random(recipe.seed + 1);
    const std::size_t capacity = problem.primitives.size();
    Solver solver(capacity);
    PrimitiveSet set(capacity);
    for (int tick = 0; tick < 6; ++tick) {
      const Solved result = solved(problem, solver, set);
      const Reference reference = reference_balance(problem);
      if (reference.certified) {
        EXPECT_LE(error_m(reference, result.balance.position_m),
                  result.balance.error_bound_m + static_cast<double>(reference.bound_m))
            << recipe << ", tick " << tick;
      }
      problem.probe_m += random.in_cube(tick % 2 == 0 ? 1e-6 : 1e-4);
    }
  });
}

TEST_P(Accuracy, NeedsNoAllocation) {
  for_each_problem(family(), drags(), {0, 1, 3, 8, 64}, 2, [&](const Recipe& recipe) {
    const Problem problem = recipe.problem();
    const std::size_t capacity = std::max<std::size_t>(1, problem.primitives.size());
    Solver solver(capacity);
    PrimitiveSet set(capacity);
    fill(set, problem);
    const long before = allocations;
    for (int i = 0; i < 2; ++i)
      solver.solve(set, problem.start_m, problem.probe_m, problem.stiffness_n_per_m, problem.time_step_s);
    EXPECT_EQ(allocations, before) << recipe;
  });
}

INSTANTIATE_TEST_SUITE_P(Over, Accuracy, testing::Combine(testing::Range<std::size_t>(0, families().size()), testing::Bool()),
                         [](const auto& test) {
                           return families()[std::get<0>(test.param)].name +
                                  std::string(std::get<1>(test.param) ? "_with_drags" : "");
                         });

// The reference's own proof against the closed form of a balance.
TEST(Reference, IsTheClosedFormOfOnePrimitive) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    Problem problem;
    problem.start_m = random.in_cube(0.05);
    problem.stiffness_n_per_m = random.uniform(100, 3000);
    const double s = random.uniform(0, 5), c = i % 2 == 0 ? 0.0 : random.uniform(0, 20);
    const double depth_m = random.uniform(0, 0.01);
    const Vec3 away = random.direction();
    problem.primitives = {{PrimitiveKind::point, {}, problem.start_m, {}, s, c}};
    problem.probe_m = problem.start_m + depth_m * away;
    const Reference reference = reference_balance(problem);
    ASSERT_TRUE(reference.certified);
    // |x − a| = (k d − s)₊/(k + c/T)
    const double k = problem.stiffness_n_per_m;
    const double out_m = std::max(0.0, k * depth_m - s) / (k + c / problem.time_step_s);
    EXPECT_NEAR(error_m(reference, problem.start_m + out_m * away), 0.0, 1e-16);
  }
}

TEST(Reference, IsTheClosedFormOfOneCorner) {
  Random random(2);
  for (int i = 0; i < 500; ++i) {
    Problem problem;
    problem.start_m = random.in_cube(0.05);
    problem.probe_m = problem.start_m + random.in_cube(0.004);
    const Facets facets = some_facets(random, problem.start_m, random.below(2) == 0 ? 0.0 : 0.002, 1 + random.below(8));
    const Vec3 way_m = way_out_by_all_faces(facets, problem.probe_m);
    const double gone_m = random.uniform(0.3, 2.0) * norm(way_m);
    add_corner(problem, facets, gone_m * problem.stiffness_n_per_m);
    const Reference reference = reference_balance(problem);
    ASSERT_TRUE(reference.certified) << i;
    EXPECT_LE(error_m(reference, problem.probe_m + (norm(way_m) > 0.0 ? std::min(1.0, gone_m / norm(way_m)) : 0.0) * way_m),
              1e-15)
        << i;
  }
}

TEST(Reference, TakesNoWrongPositionForTheBalance) {
  const Family& family = families()[1];
  int certified = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const Problem problem = family.make(random, 5, seed % 2 == 0);
    const Solved result = solved(problem);
    const Reference reference = reference_balance(problem);
    certified += reference.certified;
    const Vec3 off_m = random.in_cube(1e-5);
    const Vec3 wrong_m = result.balance.position_m + off_m;
    // Both bounds hold: the wrong position's bound is at least its distance.
    EXPECT_GE(plain_bound_m(problem, result.forces_n, wrong_m, {}) * (1 + 1e-9), error_m(reference, wrong_m) - 1e-14);
    EXPECT_GE(plain_bound_m(problem, result.forces_n, result.balance.position_m, off_m) * (1 + 1e-9),
              error_m(reference, wrong_m) - 1e-14);
    EXPECT_NEAR(error_m(reference, wrong_m), norm(off_m), result.balance.error_bound_m + 1e-14);
  }
  EXPECT_EQ(certified, 50);
}

}  // namespace degenerate_test
}  // namespace palpa::test
