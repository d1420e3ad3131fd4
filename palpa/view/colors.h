// Colours of pictures. The lightness of each colour map is monotonic: distinct for colour-blind eyes and in grey print.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "palpa/scene/scene.h"

namespace palpa::detail {

/// Red, green, blue, 0…1 each.
struct Color {
  double red = 0.0;
  double green = 0.0;
  double blue = 0.0;
};

/// Parses "#rrggbb". Throws LoadError on anything else.
Color color_of(std::string_view hex);

/// Maps values to colour and opacity, linear between points.
class ColorMap {
 public:
  struct Point {
    double value;
    Color color;
    double opacity;
  };
  /// Opaque colours, evenly spaced from low to high.
  ColorMap(double low, double high, std::span<const std::string_view> hexes);
  /// Of a layer of a scene; at least one point.
  explicit ColorMap(const std::vector<ViewLayer::ColorPoint>& points);

  Point at(double value) const noexcept;
  double low() const noexcept { return points_.front().value; }
  double high() const noexcept { return points_.back().value; }
  const std::vector<Point>& points() const noexcept { return points_; }

 private:
  std::vector<Point> points_;
};

/// Force on the hand, 0 to `high_n`: yellow at zero, then red, then violet.
ColorMap force_colors(double high_n);
/// Speeds and other magnitudes: light green, blue, nearly black.
ColorMap magnitude_colors(double low, double high);
/// Grey, as usual for scans.
ColorMap grey_colors(double low, double high);
/// CIE 1976 lightness L*, 0…100.
double lightness(const Color& color) noexcept;
/// A colour with an opacity [1] over a background.
Color blended(const Color& over, double opacity, const Color& ground) noexcept;
/// Background of pictures of scenes.
inline constexpr Color ground_color{0.985, 0.985, 0.98};
/// Colour of mode index `mode`, of Okabe and Ito's colour-blind-safe set.
Color mode_color(std::size_t mode);
/// Colour of a surface whose layer has none. \param number  of the surface, 0 for the outermost
Color surface_color(std::size_t number);

}  // namespace palpa::detail
