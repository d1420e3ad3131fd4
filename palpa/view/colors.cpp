#include "palpa/view/colors.h"

#include <algorithm>
#include <charconv>
#include <string>

#include "palpa/core/load_error.h"

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
  static constexpr std::string_view hexes[] = {"#ddd5cb", "#f7b538", "#ee7014", "#c9302c", "#8a1253", "#3b0a45", "#14062b"};
  return {0.0, high_n, hexes};
}

ColorMap magnitude_colors(double low, double high) {
  static constexpr std::string_view hexes[] = {"#c3dbea", "#8dc0dd", "#559fcb", "#2b7bb4", "#0f5796", "#08306b"};
  return {low, high, hexes};
}

ColorMap grey_colors(double low, double high) {
  static constexpr std::string_view hexes[] = {"#101010", "#f4f4f4"};
  return {low, high, hexes};
}

Color mode_color(std::size_t mode) {
  static constexpr std::string_view hexes[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};
  return color_of(hexes[mode % std::size(hexes)]);
}

Color surface_color(std::size_t number) {
  static constexpr std::string_view hexes[] = {"#dcb594", "#f2ead6", "#8fb0a9", "#a9a3c4", "#c9c9c9"};
  return color_of(hexes[number % std::size(hexes)]);
}

}  // namespace palpa::detail
