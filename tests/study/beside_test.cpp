// Comparison of two runs of one hand: differences, and their perceptibility, on known forces.
#include "palpa/study/beside.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace palpa {
namespace beside_test {

using testing::HasSubstr;
using testing::IsEmpty;

/// A second of a hand that moves along x; the force is `force(t)`.
template <class Force>
FeltRun run_with(const Force& force) {
  FeltRun run{.stiffness_n_per_m = 500.0};
  for (int i = 0; i < 1000; ++i) {
    const double t_s = 1e-3 * i;
    run.ticks.push_back({.t_s = t_s, .dt_s = 1e-3, .probe_m = {0.1 * t_s, 0, 0}, .command_n = force(t_s), .usable = true});
  }
  return run;
}

Vec3 turned(double force_n, double angle_deg) {
  const double angle = angle_deg * std::numbers::pi / 180.0;
  return {force_n * std::cos(angle), force_n * std::sin(angle), 0};
}

TEST(Beside, ARunBesideItselfDoesNotDiffer) {
  const FeltRun run = run_with([](double t_s) { return turned(3.0 * t_s, 100.0 * t_s); });
  EXPECT_THAT(where_hands_part(run, run), IsEmpty());
  const FeltDifference difference = compare_felt(run, run);
  EXPECT_EQ(difference.rms_n, 0.0);
  EXPECT_EQ(difference.noticeable_share, 0.0);
  EXPECT_THAT(difference.intervals, IsEmpty());
  for (const double apart_n : difference.difference_n) EXPECT_EQ(apart_n, 0.0);
}

TEST(Beside, ChangedPlacesTheyDifferByAsMuch) {
  const FeltRun a = run_with([](double t_s) { return turned(2.0 * t_s, 30.0); });
  const FeltRun b = run_with([](double t_s) { return turned(2.0 * t_s * t_s, 90.0 * t_s); });
  const FeltDifference ab = compare_felt(a, b), ba = compare_felt(b, a);
  EXPECT_EQ(ab.difference_n, ba.difference_n);
  EXPECT_EQ(ab.noticeable, ba.noticeable);
  EXPECT_EQ(ab.rms_n, ba.rms_n);
  EXPECT_EQ(ab.largest, ba.largest);
  EXPECT_GT(ab.noticeable_share, 0.0);
  EXPECT_EQ(ab.intervals.size(), ba.intervals.size());
}

TEST(Beside, StrengthsAreToldApartAboveSevenPercentAndThirtyMillinewtons) {
  EXPECT_FALSE(are_distinguishable({5.0, 0, 0}, {5.3, 0, 0}));
  EXPECT_TRUE(are_distinguishable({5.0, 0, 0}, {5.4, 0, 0}));
  EXPECT_FALSE(are_distinguishable({0.1, 0, 0}, {0.129, 0, 0})) << "29 % of nearly nothing";
  EXPECT_TRUE(are_distinguishable({0.1, 0, 0}, {0.131, 0, 0}));
  EXPECT_FALSE(are_distinguishable({}, {0.029, 0, 0}));
  EXPECT_TRUE(are_distinguishable({}, {0.031, 0, 0}));
}

TEST(Beside, DirectionsAreToldApartAboveThirtyDegreesWhereBothAreFelt) {
  EXPECT_FALSE(are_distinguishable(turned(1.0, 0.0), turned(1.0, 29.0)));
  EXPECT_TRUE(are_distinguishable(turned(1.0, 0.0), turned(1.0, 31.0)));
  EXPECT_FALSE(are_distinguishable(turned(0.02, 0.0), turned(0.02, 180.0))) << "too weak to have a direction";
  EXPECT_NEAR(turned_deg(turned(0.5, 10.0), turned(2.0, 130.0)), 120.0, 1e-9);
  EXPECT_NEAR(turned_deg(turned(0.5, 0.0), turned(0.5, 180.0)), 180.0, 1e-9);
}

TEST(Beside, StretchesAreWhereTheyDifferAndShortGapsAreBridged) {
  const FeltRun flat = run_with([](double) { return Vec3{1, 0, 0}; });
  // Twice as strong from 0.2 to 0.3 s but for 20 ms, and from 0.6 s to 0.65 s even stronger.
  const FeltRun other = run_with([](double t_s) {
    const bool first = t_s > 0.1995 && t_s < 0.2995 && !(t_s > 0.2395 && t_s < 0.2595);
    const bool second = t_s > 0.5995 && t_s < 0.6495;
    return Vec3{first ? 2.0 : second ? 3.0 : 1.0, 0, 0};
  });
  const FeltDifference difference = compare_felt(flat, other);
  ASSERT_EQ(difference.intervals.size(), 2u);
  EXPECT_EQ(difference.intervals[0].first, 200u);
  EXPECT_EQ(difference.intervals[0].last, 299u);
  EXPECT_EQ(difference.intervals[1].first, 600u);
  EXPECT_EQ(difference.intervals[1].last, 649u);
  EXPECT_DOUBLE_EQ(difference.noticeable_share, 0.130);
  EXPECT_EQ(difference.largest, 600u);
  EXPECT_DOUBLE_EQ(difference.rms_n, std::sqrt((80 * 1.0 + 50 * 4.0) / 1000.0));
}

TEST(Beside, OnlyTicksInWhichOneOfThemPushesCount) {
  const FeltRun none = run_with([](double) { return Vec3{}; });
  const FeltRun late = run_with([](double t_s) { return t_s > 0.4995 ? Vec3{0, 1, 0} : Vec3{}; });
  const FeltDifference difference = compare_felt(none, late);
  EXPECT_EQ(difference.in_contact, 500u);
  EXPECT_EQ(difference.noticeable_share, 1.0);
  EXPECT_EQ(compare_felt(none, none).in_contact, 0u);
}

TEST(Beside, SaysWhereTheHandsPart) {
  const FeltRun run = run_with([](double) { return Vec3{1, 0, 0}; });
  FeltRun other = run;
  other.ticks.resize(700);
  EXPECT_THAT(where_hands_part(run, other), IsEmpty()) << "as far as both go";
  for (std::size_t i = 300; i < other.ticks.size(); ++i) other.ticks[i].probe_m.y += 2e-3;
  EXPECT_THAT(where_hands_part(run, other), testing::AllOf(HasSubstr("tick 300 (0.300 s)"), HasSubstr("2 mm")));
  other = run;
  other.ticks[5].t_s += 1e-4;
  EXPECT_THAT(where_hands_part(run, other), testing::AllOf(HasSubstr("tick 5 "), HasSubstr("times")));
  other = run;
  other.ticks[7].usable = false;
  EXPECT_THAT(where_hands_part(run, other), testing::AllOf(HasSubstr("tick 7 "), HasSubstr("not known")));
  other.ticks[7].probe_m.x = std::nan("");
  other.ticks[7].usable = true;
  EXPECT_THAT(where_hands_part(run, other), HasSubstr("tick 7 ")) << "a number that is none is no place";
}

}  // namespace beside_test
}  // namespace palpa
