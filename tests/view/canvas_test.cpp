// Numbers below a colour bar are legible for any quantity.
#include "palpa/view/canvas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

namespace palpa::detail {
namespace canvas_test {

TEST(NumbersBelow, StayApartWithinTheBarAndAreWhereTheyBelong) {
  constexpr double letter_px = 9.0;
  const auto width_of = [](std::string_view words) { return letter_px * static_cast<double>(words.size()); };
  int bars = 0;
  for (const double low : {0.0, 0.985, -0.3, 1e-6, 1234.5, -1e9, 99.9}) {
    for (double span = 1e-9; span < 1e9; span *= 1.37) {
      if (span < 1e-9 * std::abs(low)) continue;
      for (const double width_px : {60.0, 220.0, 500.0}) {
        const std::vector<BarNumber> numbers = numbers_below(low, low + span, width_px, width_of);
        ASSERT_FALSE(numbers.empty()) << low << ' ' << span;
        double end_px = -letter_px;
        for (const BarNumber& number : numbers) {
          const double half_px = 0.5 * width_of(number.words);
          EXPECT_NEAR(std::strtod(number.words.c_str(), nullptr), low + number.at * span, 1e-2 * span);
          EXPECT_GE(number.middle_px - half_px, numbers.size() > 1 ? end_px + 0.4 * letter_px : -half_px) << low << ' ' << span;
          end_px = number.middle_px + half_px;
          EXPECT_LE(end_px, std::max(width_px, 2.0 * half_px) + 1e-9);
        }
        ++bars;
      }
    }
  }
  EXPECT_GT(bars, 500);
}

TEST(NumbersBelow, SayTheLargestAndTheSmallestValue) {
  constexpr double letter_px = 9.0;
  const auto width_of = [](std::string_view words) { return letter_px * static_cast<double>(words.size()); };
  for (const double low : {0.0, 0.17, -300.0, -1.5, 1e-4}) {
    for (const double span : {0.83, 2.086, 7.3, 1082.0, 99.5}) {
      const std::vector<BarNumber> numbers = numbers_below(low, low + span, 260.0, width_of);
      ASSERT_GE(numbers.size(), 2u) << low << ' ' << span;
      EXPECT_EQ(numbers.front().at, 0.0);
      EXPECT_EQ(numbers.back().at, 1.0);
      EXPECT_NEAR(std::strtod(numbers.front().words.c_str(), nullptr), low, 1e-2 * span);
      EXPECT_NEAR(std::strtod(numbers.back().words.c_str(), nullptr), low + span, 1e-2 * span);
    }
  }
}

TEST(NumbersBelow, EndWhereTheStepIsLostInRounding) {
  const auto width_of = [](std::string_view words) { return static_cast<double>(words.size()); };
  for (const double low : {1e9, 1e300, -3.0}) {
    EXPECT_LE(numbers_below(low, std::nextafter(low, 1e308), 500.0, width_of).size(), 8u);
  }
}

}  // namespace canvas_test
}  // namespace palpa::detail
