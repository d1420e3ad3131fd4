// Plots, as SVG and as pictures.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpa/view/picture.h"

namespace palpa {

/// Okabe and Ito's colour-blind-safe colours, and a grey for minor curves.
enum class CurveColor : std::uint8_t { black, blue, vermilion, green, purple, sky, orange, grey };

enum class Stroke : std::uint8_t { solid, dashed, dotted };

/// One curve of a plot, or a set of points. Non-finite values are left out.
struct Series {
  std::string name{};        ///< for the legend; empty: not listed
  std::vector<double> xs{};  ///< in the x axis' own unit
  std::vector<double> ys{};  ///< in the y axis' own unit; as many as `xs`
  CurveColor color = CurveColor::blue;
  Stroke stroke = Stroke::solid;
  bool points_only = false;
};

/// Event on the x axis: a thin vertical line with a sign on top, one per kind.
struct Mark {
  double x = 0.0;      ///< in the x axis' own unit
  std::string kind{};  ///< for the legend
};

/// A plot as a value. Labels include units: "force / N". Points outside of a given range are left out.
struct Plot {
  std::string title{};
  std::string x_label{};
  std::string y_label{};
  std::vector<Series> series{};
  std::vector<Mark> marks{};
  std::optional<std::pair<double, double>> x_range{};  ///< in the axis' own unit; none: all values
  std::optional<std::pair<double, double>> y_range{};  ///< in the axis' own unit; none: all values, and zero
  bool x_log = false;                                  ///< logarithmic x axis; values not above zero are left out
  bool y_log = false;                                  ///< as for y
};

/// Plots in a grid, row by row.
struct Sheet {
  int columns = 1;
  std::vector<Plot> panels;
};

/// SVG element of `width_px` × `height_px`, scalable: the vector form of `picture_of`. Its ids begin with `id_prefix`, for
/// several in one page. Equal sheets give equal bytes. One thread at a time.
std::string svg_of(const Sheet& sheet, int width_px, int height_px, const std::string& id_prefix = "");
std::string svg_of(const Plot& plot, int width_px = 760, int height_px = 300, const std::string& id_prefix = "");

/// Off-screen picture. Throws LoadError without EGL.
Picture picture_of(const Sheet& sheet, int width_px, int height_px);
Picture picture_of(const Plot& plot, int width_px = 760, int height_px = 300);

/// Reduces a long series: in each of `columns` parts of `x_low` … `x_high` its first, lowest, highest and last point, in order,
/// so that peaks are kept. Shorter series are unchanged.
/// \param x_low   in the x axis' own unit
/// \param x_high  in the x axis' own unit
Series thinned(const Series& series, double x_low, double x_high, int columns);

}  // namespace palpa
