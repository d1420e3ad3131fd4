// Colours of pictures. The lightness of every map rises or falls all the way, so that no two of its colours look alike to
// colour-blind eyes or in grey print.
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

/// Of "#rrggbb". Throws LoadError on anything else.
Color color_of(std::string_view hex);

/// From a value to a colour and an opacity, linear between points.
class ColorMap {
 public:
  struct Point {
    double value;
    Color color;
    double opacity;
  };
  /// Colours evenly from low to high, opaque.
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

/// Force on the hand, 0 to `high_n`: yellow where nothing is felt, then red, then violet.
ColorMap force_colors(double high_n);
/// Speeds and other magnitudes: from light green over blue to nearly black.
ColorMap magnitude_colors(double low, double high);
/// Grey, as scans are read.
ColorMap grey_colors(double low, double high);
/// CIE 1976 lightness L*, 0…100.
double lightness(const Color& color) noexcept;
/// The colour that is seen where one of this opacity [1] lies over a ground.
Color blended(const Color& over, double opacity, const Color& ground) noexcept;
/// The background of pictures of scenes.
inline constexpr Color ground_color{0.985, 0.985, 0.98};
/// The colour of mode number `mode`, of Okabe and Ito's set for all kinds of eyes.
Color mode_color(std::size_t mode);
/// The colour of a surface whose layer names none. \param number  of the surface, 0 for the outermost
Color surface_color(std::size_t number);

}  // namespace palpa::detail
