#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "palpa/mode/parameters.h"

namespace palpa {
namespace transfer_function_test {

using Side = TransferFunction::Side;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double largest = std::numeric_limits<double>::max();

TEST(TransferFunction, is_linear_between_points_and_outside_beyond_them) {
  const TransferFunction f({{-300, 0.5}, {100, 0.5}, {300, 4.5}}, 0.25);
  EXPECT_EQ(f.at(-301), 0.25);
  EXPECT_EQ(f.at(-300), 0.5);
  EXPECT_EQ(f.at(-17.3), 0.5);  // a plateau has its result exactly
  EXPECT_EQ(f.at(150), 1.5);
  EXPECT_EQ(f.at(300), 4.5);
  EXPECT_EQ(f.at(std::nextafter(300.0, 301.0)), 0.25);
  EXPECT_EQ(f.slope_at(-400), 0.0);
  EXPECT_EQ(f.slope_at(0), 0.0);
  EXPECT_EQ(f.slope_at(200), 0.02);
  EXPECT_EQ(f.slope_at(400), 0.0);
}

TEST(TransferFunction, takes_the_limit_from_the_asked_side_at_a_step) {
  const TransferFunction f({{0, 1}, {10, 2}, {10, 7}, {20, 8}});
  EXPECT_EQ(f.at(10, Side::below), 2.0);
  EXPECT_EQ(f.at(10, Side::above), 7.0);
  EXPECT_EQ(f.at(10), 7.0);
  EXPECT_NEAR(f.at(std::nextafter(10.0, 0.0)), f.at(10, Side::below), 1e-12);
  EXPECT_NEAR(f.at(std::nextafter(10.0, 20.0)), f.at(10, Side::above), 1e-12);
  EXPECT_EQ(f.slope_at(10, Side::below), 0.1);
  EXPECT_EQ(f.slope_at(10, Side::above), 0.1);
}

TEST(TransferFunction, has_its_end_points_from_either_side) {
  const TransferFunction f({{0, 1}, {0, 2}, {10, 3}}, 9.0);
  EXPECT_EQ(f.at(0, Side::below), 1.0);
  EXPECT_EQ(f.at(0, Side::above), 2.0);
  EXPECT_EQ(f.at(10, Side::below), 3.0);
  EXPECT_EQ(f.at(10, Side::above), 3.0);
  EXPECT_EQ(f.slope_at(0, Side::below), 0.0);
  EXPECT_EQ(f.slope_at(10, Side::above), 0.0);
  EXPECT_EQ(f.slope_at(10, Side::below), 0.1);
}

TEST(TransferFunction, slope_is_the_derivative_of_the_result) {
  const TransferFunction f({{-1, 3}, {0.5, -2}, {2, 0}, {7, 11}});
  for (double v = -0.95; v < 6.9; v += 0.1) {
    const double h = 1e-6;
    EXPECT_NEAR(f.slope_at(v), (f.at(v + h) - f.at(v - h)) / (2 * h), 1e-7) << v;
  }
}

TEST(TransferFunction, one_point_is_that_value_alone) {
  const TransferFunction f({{5, 2}}, 1.0);
  EXPECT_EQ(f.at(5), 2.0);
  EXPECT_EQ(f.at(4), 1.0);
  EXPECT_EQ(f.at(6), 1.0);
  EXPECT_EQ(f.slope_at(5), 0.0);
}

TEST(TransferFunction, is_finite_for_every_value) {
  const TransferFunction wide({{-1e300, -1e300}, {1e300, 1e300}});
  const TransferFunction steep({{0, -1e300}, {std::numeric_limits<double>::denorm_min(), 1e300}});
  for (const TransferFunction& f : {wide, steep, TransferFunction({{0, 1}, {1, 2}}), TransferFunction()}) {
    for (const double v : {nan, infinity, -infinity, largest, -largest, 0.0, 5e-324, 0.5}) {
      for (const Side side : {Side::below, Side::above}) {
        EXPECT_TRUE(std::isfinite(f.at(v, side))) << v;
        EXPECT_TRUE(std::isfinite(f.slope_at(v, side))) << v;
      }
    }
  }
  EXPECT_EQ(wide.at(0), 0.0);
  EXPECT_EQ(TransferFunction({{0, 1}, {1, 2}}, 3.0).at(nan), 0.0);
  EXPECT_EQ(TransferFunction().at(1.0), 0.0);
}

TEST(TransferFunction, scaling_values_by_a_power_of_two_changes_no_bit_of_the_result) {
  const TransferFunction f({{-0.3, 0.8}, {0.11, 1.7}, {0.3, 4.1}});
  const double factor = std::ldexp(1.0, -30);
  const TransferFunction g({{-0.3 * factor, 0.8}, {0.11 * factor, 1.7}, {0.3 * factor, 4.1}});
  for (double v = -0.4; v < 0.4; v += 0.0137) {
    EXPECT_EQ(f.at(v), g.at(v * factor));
    EXPECT_EQ(f.slope_at(v), g.slope_at(v * factor) * factor);
  }
}

// Zero in all of a neighbourhood or not: at points, between and beyond them; with a ramp, a step or a plateau beside it.
TEST(TransferFunction, stays_zero_where_no_value_nearby_has_another_result) {
  unsigned bits = 1;
  const auto is_drawn = [&] { return (bits = bits * 1664525u + 1013904223u) >> 31 == 0; };
  int zero = 0, other = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<TransferFunction::Point> points;
    for (int value = 0; value < 4; ++value) {
      points.push_back({static_cast<double>(value), is_drawn() || is_drawn() ? 0.0 : 1.0});
      if (is_drawn()) points.push_back({static_cast<double>(value), is_drawn() ? 0.0 : 2.0});
    }
    const double outside = is_drawn() ? 0.0 : 0.5;
    const TransferFunction f(points, outside);
    for (double v = -0.5; v <= 3.5; v += 0.5) {
      if (outside != 0.0 && (v == 0.0 || v == 3.0)) continue;
      const bool is_zero =
          f.at(v, Side::below) == 0.0 && f.at(v, Side::above) == 0.0 && f.at(v - 0.01) == 0.0 && f.at(v + 0.01) == 0.0;
      EXPECT_EQ(f.stays_zero_at(v), is_zero) << v;
      ++(is_zero ? zero : other);
    }
  }
  EXPECT_GT(zero, 1000);
  EXPECT_GT(other, 1000);
}

void expect_refused(std::vector<TransferFunction::Point> points, double outside, const char* word) {
  try {
    const TransferFunction f(std::move(points), outside);
    FAIL() << "accepted; expected a word about " << word;
  } catch (const std::invalid_argument& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr(word));
  }
}

TEST(TransferFunction, refuses_what_is_no_function_in_a_sentence) {
  expect_refused({}, 0, "no points");
  expect_refused({{1, 0}, {0, 0}}, 0, "fall");
  expect_refused({{0, 0}, {0, 1}, {0, 2}}, 0, "three points");
  expect_refused({{nan, 0}}, 0, "not finite");
  expect_refused({{0, infinity}}, 0, "not finite");
  expect_refused({{0, largest}}, 0, "not finite");
  expect_refused({{0, 0}}, nan, "outside");
}

}  // namespace transfer_function_test
}  // namespace palpa
