// Limiter output: finite, within the limit, and along the force.
#include "palpa/guard/guard.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <random>

namespace palpa {
namespace guard_test {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(Guard, AForceWithinTheLimitPassesToTheBit) {
  Guard guard(3.3);
  for (const Vec3& force : {Vec3{}, Vec3{1, -2, 0.5}, Vec3{3.3, 0, 0}, Vec3{-0.0, 1e-320, 0}}) {
    const Guard::Passed passed = guard.pass(force);
    EXPECT_EQ(passed.command_n, force);
    EXPECT_EQ(passed.state, GuardState::pass);
  }
}

TEST(Guard, AForceBeyondTheLimitKeepsItsDirectionAndNeverExceedsTheLimit) {
  std::mt19937_64 engine(2);
  for (int i = 0; i < 100'000; ++i) {
    const double limit = 0.1 + static_cast<double>(engine() % 1000) / 100;
    const auto any = [&] { return std::bit_cast<double>(engine() & ~(std::uint64_t{1} << 62)); };  // below 2
    const double scale = i % 3 == 0 ? 1e308 : i % 3 == 1 ? 1e3 : 1.0;
    const Vec3 force{scale * any(), scale * any(), scale * any()};
    if (!is_finite(force)) continue;
    const Guard::Passed passed = Guard(limit).pass(force);
    ASSERT_LE(norm(passed.command_n), limit);
    if (passed.state == GuardState::pass) continue;
    ASSERT_EQ(passed.state, GuardState::limited);
    ASSERT_NEAR(norm(passed.command_n), limit, 1e-14 * limit);
    ASSERT_NEAR(norm(cross(normalized(force), passed.command_n)), 0.0, 1e-14 * limit);
    ASSERT_GT(dot(normalized(force), passed.command_n), 0.0);
  }
}

TEST(Guard, NothingThatIsNotFinitePasses) {
  Guard guard(3.3);
  for (const double bad : {nan, infinite, -infinite}) {
    for (const Vec3& force : {Vec3{bad, 0, 0}, Vec3{1, bad, 0}, Vec3{0, 0, bad}, Vec3{bad, bad, bad}}) {
      const Guard::Passed passed = guard.pass(force);
      EXPECT_EQ(passed.command_n, Vec3{});
      EXPECT_EQ(passed.state, GuardState::fault);
    }
  }
  EXPECT_EQ(guard.pass({1, 0, 0}).state, GuardState::pass);
}

TEST(Guard, ALimitThatIsNoneLetsNothingThrough) {
  for (const double bad : {nan, -1.0, 0.0}) EXPECT_EQ(Guard(bad).pass({1, 2, 3}).command_n, Vec3{});
}

}  // namespace guard_test
}  // namespace palpa
