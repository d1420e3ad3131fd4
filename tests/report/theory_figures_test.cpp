// The numbers in the figures of docs/theory.md obey the statements that they illustrate.
#include "tools/figures/theory_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/report/markup.h"

namespace palpa {
namespace theory_figures_test {

TEST(TheoryFigures, AreWellFormedAndSayWhatTheyShow) {
  const std::vector<Figure> figures = theory_figures();
  EXPECT_THAT(figures, testing::SizeIs(5));
  for (const Figure& figure : figures) {
    EXPECT_THAT(figure.name, testing::StartsWith("theory-"));
    EXPECT_GT(figure.caption.size(), 40u) << figure.name;
    const std::string svg = svg_of(figure.sheet, figure.width_px, figure.height_px);
    EXPECT_EQ(markup_error(svg, false), "") << figure.name;
    EXPECT_EQ(svg, svg_of(figure.sheet, figure.width_px, figure.height_px)) << figure.name;
    for (const auto& panel : figure.sheet.panels) {
      const Plot* plot = std::get_if<Plot>(&panel);
      if (!plot) continue;
      EXPECT_FALSE(plot->x_label.empty() || plot->y_label.empty()) << figure.name;
      for (const Series& series : plot->series) {
        EXPECT_FALSE(series.xs.empty()) << figure.name << " " << series.name;
        EXPECT_EQ(series.xs.size(), series.ys.size());
      }
    }
  }
}

TEST(TheoryFigures, BoundsLieAboveErrors) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    for (const detail::NearBalance& near : detail::sweeps_towards_balance(seed, 30))
      EXPECT_GE(near.bound_m, near.error_m - 1e-9) << seed;
  }
}

TEST(TheoryFigures, SweepsLeaveTheSquaredCosineOfTheError) {
  for (const double angle_deg : {5.0, 30.0, 70.0}) {
    const std::vector<double> distances_m = detail::sweeps_into_edge(angle_deg, 100000);
    EXPECT_LT(distances_m.back(), 1e-9) << angle_deg;
    const double squared = std::pow(std::cos(angle_deg * std::numbers::pi / 180.0), 2);
    for (std::size_t i = 1; i + 1 < distances_m.size(); ++i)
      EXPECT_NEAR(distances_m[i] / distances_m[i - 1], squared, 1e-4) << angle_deg;
  }
}

TEST(TheoryFigures, TheExactLawHardlyFeelsTheAngle) {
  for (const Figure& figure : theory_figures()) {
    if (figure.name != "theory-sweeps") continue;
    const Plot& plot = std::get<Plot>(figure.sheet.panels.at(1));
    ASSERT_EQ(plot.series.size(), 3u);
    const Series &sweeps = plot.series[1], &ours = plot.series[2];
    ASSERT_EQ(ours.name, "exact law");
    EXPECT_EQ(ours.xs, sweeps.xs) << "it reaches the edge at every angle";
    EXPECT_GT(sweeps.ys.front(), 100.0 * ours.ys.front());
    const auto [least, most] = std::minmax_element(ours.ys.begin(), ours.ys.end());
    EXPECT_LE(*most, 10.0 * *least);
  }
}

TEST(TheoryFigures, StepsThroughTheProxyLeakNoMoreThanProvenOthersDo) {
  int above = 0;
  for (const detail::EnergyOfStep& step : detail::random_steps(false, 1000)) EXPECT_LE(step.leak_j, step.bound_j + 1e-11);
  for (const detail::EnergyOfStep& step : detail::random_steps(true, 1000)) above += step.leak_j > step.bound_j;
  EXPECT_GT(above, 50);
}

}  // namespace theory_figures_test
}  // namespace palpa
