#include "palpa/view/colors.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include "palpa/base/load_error.h"
#include "palpa/vtk/felt_actors.h"

namespace palpa::detail {

Color color_of(std::string_view hex) {
  unsigned rgb = 0;
  if (hex.size() == 7 && hex[0] == '#') {
    const auto [end, error] = std::from_chars(hex.data() + 1, hex.data() + hex.size(), rgb, 16);
    if (error == std::errc() && end == hex.data() + hex.size()) {
      return {(rgb >> 16 & 255U) / 255.0, (rgb >> 8 & 255U) / 255.0, (rgb & 255U) / 255.0};
    }
  }
  throw LoadError("pictures: '" + std::string(hex) + "' is no colour; colours are written as \"#rrggbb\"");
}

ColorMap::ColorMap(double low, double high, std::span<const std::string_view> hexes) {
  for (std::size_t i = 0; i < hexes.size(); ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(hexes.size() - 1);
    points_.push_back({low + share * (high - low), color_of(hexes[i]), 1.0});
  }
}

ColorMap::ColorMap(const std::vector<ViewLayer::ColorPoint>& points) {
  for (const ViewLayer::ColorPoint& point : points) points_.push_back({point.value, color_of(point.color), point.opacity});
  std::stable_sort(points_.begin(), points_.end(), [](const Point& a, const Point& b) { return a.value < b.value; });
}

ColorMap::Point ColorMap::at(double value) const noexcept {
  const auto above = std::find_if(points_.begin(), points_.end(), [&](const Point& point) { return point.value > value; });
  if (above == points_.begin()) return points_.front();
  if (above == points_.end()) return points_.back();
  const Point& a = above[-1];
  const Point& b = above[0];
  const double t = (value - a.value) / (b.value - a.value);
  const auto mix = [t](double from, double to) { return from + t * (to - from); };
  return {value,
          {mix(a.color.red, b.color.red), mix(a.color.green, b.color.green), mix(a.color.blue, b.color.blue)},
          mix(a.opacity, b.opacity)};
}

ColorMap force_colors(double high_n) {
  // "inferno" from 0.9 down to 0.2 (N. Smith, S. van der Walt, CC0: bids.github.io/colormap).
  static constexpr std::string_view hexes[] = {"#f6d746", "#fca50a", "#f37819", "#dd513a",
                                               "#bc3754", "#932667", "#6a176e", "#420a68"};
  return {0.0, high_n, hexes};
}

ColorMap magnitude_colors(double low, double high) {
  // "mako" from 6/7 down to 1/7 (M. Waskom, "seaborn", J. Open Source Softw. 6(60), 3021, 2021).
  static constexpr std::string_view hexes[] = {"#8ad9b1", "#40b7ad", "#348fa7", "#37659e", "#413d7b", "#2e1e3b"};
  return {low, high, hexes};
}

ColorMap grey_colors(double low, double high) {
  static constexpr std::string_view hexes[] = {"#101010", "#f4f4f4"};
  return {low, high, hexes};
}

double lightness(const Color& color) noexcept {
  const auto linear = [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); };
  const double y = 0.2126 * linear(color.red) + 0.7152 * linear(color.green) + 0.0722 * linear(color.blue);
  return y > 0.008856 ? 116.0 * std::cbrt(y) - 16.0 : 903.3 * y;
}

Color blended(const Color& over, double opacity, const Color& ground) noexcept {
  const auto mix = [&](double a, double b) { return opacity * a + (1.0 - opacity) * b; };
  return {mix(over.red, ground.red), mix(over.green, ground.green), mix(over.blue, ground.blue)};
}

Color mode_color(std::size_t mode) {
  const FeltColor color = felt_color(mode);
  return {color[0], color[1], color[2]};
}

Color surface_color(std::size_t number) {
  static constexpr std::string_view hexes[] = {"#d99a7e", "#efe6d2", "#8fb0a9", "#a9a3c4", "#c9c9c9"};
  return color_of(hexes[number % std::size(hexes)]);
}

}  // namespace palpa::detail
