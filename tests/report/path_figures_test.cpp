// The numbers in the figures of docs/path.md obey the statements that they illustrate.
#include "tools/figures/path_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/report/markup.h"

namespace palpa {
namespace path_figures_test {

using detail::Walked;

TEST(PathFigures, AreWellFormedAndSayWhatTheyShow) {
  const std::vector<Figure> figures = path_figures();
  EXPECT_THAT(figures, testing::SizeIs(4));
  for (const Figure& figure : figures) {
    EXPECT_THAT(figure.name, testing::StartsWith("path-"));
    EXPECT_GT(figure.caption.size(), 40u) << figure.name;
    const std::string svg = svg_of(figure.sheet, figure.width_px, figure.height_px);
    EXPECT_EQ(markup_error(svg, false), "") << figure.name;
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

TEST(PathFigures, APlaneAtTheProxyDriftsByPiSpeedTimesTickOursDoesNot) {
  for (const double speed : {0.1, 1.0}) {
    const double drift_m = detail::off_sphere_m(Walked::one_step, false, speed).back();
    EXPECT_NEAR(drift_m, std::numbers::pi * speed * 1e-3, 0.1 * drift_m) << speed << " m/s";
    for (const double off_m : detail::off_sphere_m(Walked::path, true, speed)) EXPECT_LT(std::abs(off_m), 1e-9);
  }
}

TEST(PathFigures, InAGrooveThePathRestsAndOneStepATickDoesNot) {
  // The largest change of the force from tick to tick while the hand is still, after a few ticks to settle.
  const auto jump_n = [](const detail::InGroove& groove) {
    double most_n = 0.0;
    for (std::size_t i = groove.still_from + 10; i < groove.slides_from; ++i)
      most_n = std::max(most_n, norm(groove.force_n[i] - groove.force_n[i - 1]));
    return most_n;
  };
  const detail::InGroove ours = detail::press_into_groove(Walked::path);
  EXPECT_LT(jump_n(ours), 1e-3);
  EXPECT_GT(jump_n(detail::press_into_groove(Walked::one_step)), 0.1);
  // Several planes carry it together.
  const auto carries = [](const PlacedPrimitive& placed) { return norm(placed.force_n) > 1e-3; };
  EXPECT_GE(std::count_if(ours.planes.begin(), ours.planes.end(), carries), 2);
}

TEST(PathFigures, AThinWallHoldsThePathAtAnySpeed) {
  for (const double speed : {0.1, 1.0, 10.0}) {
    for (int i = 0; i < 10; ++i) {
      const detail::ThroughWall stroke = detail::stroke_through_wall(Walked::path, speed, speed * 1e-3 * i / 10.0);
      EXPECT_GT(stroke.probe_m.back(), detail::wall_m);
      EXPECT_NEAR(stroke.proxy_m.back(), 0.0, 1e-9) << speed << " m/s, " << i;
    }
  }
}

TEST(PathFigures, PathsConverge) {
  for (const auto& modes : {detail::convergence_in_scalars(), detail::convergence_in_vectors()}) {
    for (const detail::Convergence& mode : modes) {
      ASSERT_EQ(mode.differences_m.size(), 4u);
      EXPECT_LT(mode.differences_m.back(), 3e-6) << mode.mode;
      EXPECT_LT(mode.differences_m.back(), mode.differences_m.front()) << mode.mode;
    }
  }
}

}  // namespace path_figures_test
}  // namespace palpa
