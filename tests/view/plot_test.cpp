// Plots: peaks are kept, bytes are reproducible, and no text can break the page.
#include "palpa/view/plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/report/markup.h"

namespace palpa {
namespace plot_test {

using testing::HasSubstr;
using testing::Not;

Series random_series(std::size_t points, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> step(0.0, 1.0);
  Series series{.name = "walk"};
  double y = 0.0;
  for (std::size_t i = 0; i < points; ++i) {
    series.xs.push_back(1e-3 * static_cast<double>(i));
    series.ys.push_back(i % 977 == 5 ? 40.0 * step(random) : y += step(random));
  }
  return series;
}

TEST(Thinned, KeepsLowestAndHighestOfEveryColumn) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const Series whole = random_series(20000, seed);
    constexpr int columns = 300;
    const double high = whole.xs.back();
    const Series few = thinned(whole, 0.0, high, columns);
    ASSERT_EQ(few.xs.size(), few.ys.size());
    EXPECT_LE(few.xs.size(), 4u * (columns + 1));
    EXPECT_EQ(*std::max_element(few.ys.begin(), few.ys.end()), *std::max_element(whole.ys.begin(), whole.ys.end()));
    EXPECT_EQ(*std::min_element(few.ys.begin(), few.ys.end()), *std::min_element(whole.ys.begin(), whole.ys.end()));
    EXPECT_TRUE(std::is_sorted(few.xs.begin(), few.xs.end()));
    EXPECT_EQ(few.xs.front(), whole.xs.front());
    EXPECT_EQ(few.xs.back(), whole.xs.back());

    const auto columns_of = [&](const Series& series) {
      std::vector<std::pair<double, double>> extremes(columns + 1, {1e300, -1e300});
      for (std::size_t i = 0; i < series.xs.size(); ++i) {
        auto& [lowest, highest] = extremes[static_cast<std::size_t>(series.xs[i] / high * columns)];
        lowest = std::min(lowest, series.ys[i]);
        highest = std::max(highest, series.ys[i]);
      }
      return extremes;
    };
    EXPECT_EQ(columns_of(few), columns_of(whole));
  }
}

TEST(Thinned, ShortSeriesStayAsTheyAre) {
  const Series whole = random_series(100, 4);
  EXPECT_EQ(thinned(whole, 0.0, 1.0, 300).ys, whole.ys);
}

TEST(Thinned, EveryPointThatIsKeptWasThere) {
  const Series whole = random_series(5000, 7);
  const Series few = thinned(whole, 0.0, 5.0, 50);
  for (std::size_t i = 0; i < few.xs.size(); ++i) {
    const auto at = static_cast<std::size_t>(std::lround(1e3 * few.xs[i]));
    EXPECT_EQ(few.ys[i], whole.ys[at]);
  }
}

TEST(Thinned, LeavesOutWhatIsNotFinite) {
  Series whole = random_series(5000, 8);
  whole.ys[17] = std::numeric_limits<double>::quiet_NaN();
  whole.ys[18] = std::numeric_limits<double>::infinity();
  for (const double y : thinned(whole, 0.0, 5.0, 50).ys) EXPECT_TRUE(std::isfinite(y));
}

Plot some_plot() {
  Plot plot{.title = "Force", .x_label = "time / s", .y_label = "force / N", .series = {random_series(3000, 1)}};
  plot.series.push_back({.name = "dots", .xs = {0.5, 1.5}, .ys = {1, 2}, .color = CurveColor::vermilion, .points_only = true});
  plot.marks = {{0.3, "onset"}, {0.7, "onset"}, {1.1, "break-through"}};
  return plot;
}

TEST(Svg, IsWellFormedAndSaysItsLabels) {
  const std::string svg = svg_of(some_plot());
  EXPECT_EQ(markup_error(svg, false), "");
  for (const char* text : {"Force", "time / s", "force / N", "walk", "dots", "onset", "break-through"}) {
    EXPECT_THAT(svg, HasSubstr(std::string(text) + "</text>"));
  }
  EXPECT_THAT(svg, HasSubstr("viewBox=\"0 0 760 300\""));
}

TEST(Svg, IsTheSameTwice) { EXPECT_EQ(svg_of(some_plot()), svg_of(some_plot())); }

TEST(Svg, HostileNamesStayText) {
  Plot plot = some_plot();
  plot.title = "<script>alert('x')</script> & \"q\"";
  plot.series[0].name = "</text><b>";
  plot.marks[0].kind = "<img src=x>";
  const std::string svg = svg_of(plot);
  EXPECT_EQ(markup_error(svg, false), "");
  EXPECT_THAT(svg, Not(HasSubstr("<script")));
  EXPECT_THAT(svg, Not(HasSubstr("<img")));
  EXPECT_THAT(svg, HasSubstr("&lt;script&gt;"));
}

TEST(Svg, AnAxisByPowersOfTenSaysThem) {
  Plot plot{.title = "powers", .series = {{.xs = {1e-5, 1e-3, 0.1, 10.0}, .ys = {1, 2, 3, 4}}}, .x_log = true};
  const std::string svg = svg_of(plot);
  for (const char* text : {"1e-5", "1e-4", "0.001", "0.01", "0.1", "1", "10"}) {
    EXPECT_THAT(svg, HasSubstr(">" + std::string(text) + "</text>"));
  }
  // Equal steps on a linear axis give an equal curve.
  Plot linear{.title = "powers", .series = {{.xs = {-5, -3, -1, 1}, .ys = {1, 2, 3, 4}}}};
  const auto points = [](const std::string& drawn) {
    std::vector<std::string> found;
    for (std::size_t at = drawn.find("points=\""); at != std::string::npos; at = drawn.find("points=\"", at + 1)) {
      found.push_back(drawn.substr(at, drawn.find('"', at + 8) - at));
    }
    return found;
  };
  ASSERT_FALSE(points(svg).empty());
  EXPECT_EQ(points(svg), points(svg_of(linear)));
  // Values without a logarithm are left out.
  for (const double none : {0.0, -2.0, std::numeric_limits<double>::quiet_NaN()}) {
    Plot more = plot;
    more.series[0].xs.push_back(none);
    more.series[0].ys.push_back(2.5);
    EXPECT_EQ(svg_of(more), svg) << none;
  }
  for (const auto& [low, high] : {std::pair{0.0, 1.0}, {-1.0, 1.0}, {1.0, 1.0}, {1e-300, 1e300}, {3.0, 4.0}}) {
    plot.x_range = {low, high};
    EXPECT_EQ(markup_error(svg_of(plot), false), "") << low << " " << high;
  }
}

TEST(Svg, AnUprightAxisByPowersOfTenSaysThem) {
  Plot plot{.title = "powers", .series = {{.xs = {1, 2, 3, 4}, .ys = {1e-5, 1e-3, 0.1, 10.0}}}, .y_log = true};
  const std::string svg = svg_of(plot, 400, 500);
  for (const char* text : {"1e-5", "0.001", "0.1", "10"}) EXPECT_THAT(svg, HasSubstr(">" + std::string(text) + "</text>"));
  for (const double none : {0.0, -2.0, std::numeric_limits<double>::infinity()}) {
    Plot more = plot;
    more.series[0].xs.push_back(2.5);
    more.series[0].ys.push_back(none);
    EXPECT_EQ(svg_of(more, 400, 500), svg) << none;
  }
  for (const auto& [low, high] : {std::pair{0.0, 1.0}, {-1.0, 1.0}, {1.0, 1.0}, {1e-300, 1e300}, {3.0, 4.0}}) {
    plot.y_range = {low, high};
    EXPECT_EQ(markup_error(svg_of(plot), false), "") << low << " " << high;
  }
}

TEST(Svg, IdsBeginWithTheirPrefix) {
  const std::string svg = svg_of(some_plot(), 700, 300, "a-");
  EXPECT_EQ(markup_error(svg, false), "");
  for (const std::string before : {"id=\"", "href=\"#", "url(#"}) {
    for (std::size_t at = svg.find(before); at != std::string::npos; at = svg.find(before, at + 1)) {
      EXPECT_EQ(svg.substr(at + before.size(), 2), "a-");
    }
  }
}

/// The numbers of the plotted curve, in pixels.
std::pair<double, double> extent_of_curve(const std::string& svg, const char* color) {
  std::pair<double, double> ys{1e300, -1e300};
  for (std::size_t at = svg.find(color); at != std::string::npos; at = svg.find(color, at + 1)) {
    std::size_t points = svg.find("points=\"", at);
    const std::size_t end = svg.find('"', points + 8);
    while ((points = svg.find(',', points + 1)) < end) {
      ys.first = std::min(ys.first, std::stod(svg.substr(points + 1)));
      ys.second = std::max(ys.second, std::stod(svg.substr(points + 1)));
    }
  }
  return ys;
}

TEST(Svg, ShowsTinyNumbersAsWellAsLargeOnes) {
  // A curve looks alike in any unit: VTK's SVG has six digits, and an energy of 1e-9 J would be a straight line.
  const auto svg_at_scale = [](double scale) {
    Plot plot{.x_label = "time / s", .y_label = "energy / J", .series = {{.name = "e", .xs = {}, .ys = {}}}};
    for (int i = 0; i <= 100; ++i) {
      plot.series[0].xs.push_back(0.1 * i);
      plot.series[0].ys.push_back(scale * (1.0 + std::sin(0.3 * i)));
    }
    return svg_of(plot);
  };
  const auto tiny = extent_of_curve(svg_at_scale(1e-9), "#0072b2"), large = extent_of_curve(svg_at_scale(1e6), "#0072b2");
  EXPECT_GT(large.second - large.first, 150.0);
  EXPECT_NEAR(tiny.second - tiny.first, large.second - large.first, 0.1);
}

TEST(Svg, TakesWhatCannotBePlotted) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Plot& plot : {Plot{}, Plot{.series = {{.xs = {nan}, .ys = {1.0}}}}, Plot{.series = {{.xs = {1.0}, .ys = {2.0}}}},
                           Plot{.series = {{.xs = {1.0, 1.0}, .ys = {0.0, 0.0}}}},
                           Plot{.series = {{.xs = {-infinity, 0, infinity}, .ys = {0, 1, infinity}}}},
                           Plot{.series = {{.xs = {-1e308, 1e308}, .ys = {-1e308, 1e308}}}},
                           Plot{.series = {{.xs = {0, 1e-320}, .ys = {0, 5e-324}}}},
                           Plot{.series = {{.xs = {1e15, 1e15 + 1}, .ys = {1, 2}}}, .marks = {{nan, "m"}}}}) {
    EXPECT_EQ(markup_error(svg_of(plot), false), "");
  }
}

TEST(Pictures, OfPlotsAreTheSameTwiceAndShowSomething) {
  const Picture first = picture_of(some_plot(), 500, 240);
  EXPECT_EQ(first.width_px, 500);
  EXPECT_EQ(first.height_px, 240);
  ASSERT_EQ(first.rgb.size(), 500u * 240u * 3u);
  EXPECT_EQ(first.rgb, picture_of(some_plot(), 500, 240).rgb);
  EXPECT_EQ(first.rgb[0], 255) << "the corner is paper";
  EXPECT_GT(std::count_if(first.rgb.begin(), first.rgb.end(), [](std::uint8_t c) { return c < 100; }), 500);
}

}  // namespace plot_test
}  // namespace palpa
