// Plots and drawings to scale, as SVG and as pictures.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "palpa/view/picture.h"

namespace palpa {

/// The colours of Okabe and Ito, which the colour-blind can tell apart, and a grey for what matters less.
enum class CurveColor : std::uint8_t { black, blue, vermilion, green, purple, sky, orange, grey };

enum class Stroke : std::uint8_t { solid, dashed, dotted };

/// One curve of a plot, or a set of points. What is not finite is left out.
struct Series {
  std::string name{};        ///< for the legend; empty: not in it
  std::vector<double> xs{};  ///< in the x axis' own unit
  std::vector<double> ys{};  ///< in the y axis' own unit; as many
  CurveColor color = CurveColor::blue;
  Stroke stroke = Stroke::solid;
  bool points_only = false;
};

/// Something that happened at a place of the x axis: a thin upright line with a sign on top, one for each kind.
struct Mark {
  double x = 0.0;      ///< in the x axis' own unit
  std::string kind{};  ///< for the legend
};

/// A plot as a value. Units stand in the labels: "force / N". Points outside of a given range are left out.
struct Plot {
  std::string title{};
  std::string x_label{};
  std::string y_label{};
  std::vector<Series> series{};
  std::vector<Mark> marks{};
  std::optional<std::pair<double, double>> x_range{};  ///< in the axis' own unit; none: all values
  std::optional<std::pair<double, double>> y_range{};  ///< in the axis' own unit; none: all values, and zero
  bool x_log = false;                                  ///< the x axis goes by powers of ten; what is not above zero is left out
  bool y_log = false;                                  ///< the same for the y axis
};

/// A point of a drawing.
struct DrawingPoint {
  double x_mm = 0.0;  ///< to the right
  double y_mm = 0.0;  ///< up
};

/// A drawing to scale: the same millimetres along both axes. Nothing is clipped: the whole of `low` … `high`
/// is seen.
struct Drawing {
  enum class Shape : std::uint8_t { path, area, arrow, dot, ring, text };
  struct Part {
    Shape shape = Shape::path;
    std::vector<DrawingPoint> points{};  ///< path, area: its corners; arrow: from, to; dot, ring, text: where
    CurveColor color = CurveColor::black;
    Stroke stroke = Stroke::solid;
    float width_px = 1.6f;   ///< [px] of lines
    float radius_px = 4.5f;  ///< [px] of dot and ring
    std::string text{};
    int align = 0;  ///< of a text: -1 begins at its point, 0 stands in the middle, 1 ends there
  };

  std::string title{};
  DrawingPoint low{};
  DrawingPoint high{};
  std::vector<Part> parts{};

  /// A line of `width_px` [px] through points.
  void path(std::vector<DrawingPoint> points, CurveColor color = CurveColor::black, Stroke stroke = Stroke::solid,
            float width_px = 1.6f);
  /// Lightly filled.
  void area(std::vector<DrawingPoint> points, CurveColor color);
  /// A shaft of `width_px` [px] with its head at `to`.
  void arrow(DrawingPoint from, DrawingPoint to, CurveColor color, float width_px = 2.2f);
  /// A disc of `radius_px` [px].
  void dot(DrawingPoint at, CurveColor color, float radius_px = 4.5f);
  /// A circle of `radius_px` [px], white inside.
  void ring(DrawingPoint at, CurveColor color, float radius_px = 4.5f);
  void text(DrawingPoint at, std::string text, int align = 0, CurveColor color = CurveColor::black);
};

/// Plots and drawings side by side, row by row.
struct Sheet {
  int columns = 1;
  std::vector<std::variant<Plot, Drawing>> panels;
};

/// As an SVG element of `width_px` × `height_px`, which scales: the vector form of the same chart that
/// `picture_of` shows. Its ids begin with `id_prefix`, so that several can stand in one page. The same sheet
/// gives the same bytes. One thread at a time.
std::string svg_of(const Sheet& sheet, int width_px, int height_px, const std::string& id_prefix = "");
std::string svg_of(const Plot& plot, int width_px = 760, int height_px = 300, const std::string& id_prefix = "");

/// As a picture, drawn off-screen. Throws LoadError where nothing can be drawn (no EGL).
Picture picture_of(const Sheet& sheet, int width_px, int height_px);
Picture picture_of(const Plot& plot, int width_px = 760, int height_px = 300);

/// A long series with few points: in each of `columns` parts of `x_low` … `x_high` its first, lowest,
/// highest and last point, in order, so that no peak is lost. Shorter ones stay as they are.
/// \param x_low   in the x axis' own unit
/// \param x_high  in the x axis' own unit
Series thinned(const Series& series, double x_low, double x_high, int columns);

}  // namespace palpa
