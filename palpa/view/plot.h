// Plots, as SVG and as pictures.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
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

/// Plots side by side, row by row.
struct Sheet {
  int columns = 1;
  std::vector<Plot> panels;
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
