// Arbitrary bits as input: the answer is finite and within its bound.
#include "tests/solver/arbitrary_bits.h"

#include <gtest/gtest.h>

namespace palpa::test {
namespace arbitrary_bits_test {

TEST(ArbitraryBits, GetAFiniteAndHonestAnswer) {
  const ArbitraryBits run = solve_arbitrary_bits(300'000, 2);
  ASSERT_EQ(run.wrong, nullptr) << run.wrong << " in problem " << run.wrong_at;
  EXPECT_EQ(run.problems, 300'000);
  // Each kind of answer occurred often enough for the checks.
  EXPECT_GT(run.bad_input, 10'000);
  EXPECT_GT(run.exact, 10'000);
  EXPECT_GT(run.refused, 10'000);
}

TEST(ArbitraryBits, OfCornersGetAFiniteAndHonestAnswer) {
  const ArbitraryBits run = solve_arbitrary_bits(300'000, 3, true);
  ASSERT_EQ(run.wrong, nullptr) << run.wrong << " in problem " << run.wrong_at;
  EXPECT_EQ(run.problems, 300'000);
  EXPECT_GT(run.bad_input, 10'000);
  EXPECT_GT(run.exact, 10'000);
  EXPECT_GT(run.refused, 10'000);
}

}  // namespace arbitrary_bits_test
}  // namespace palpa::test
