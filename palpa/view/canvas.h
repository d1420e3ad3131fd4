// 2-D drawing over a picture (text, filled shapes, in pixels from the lower left corner) and its annotations: title, legend,
// colour bars, scale bar, orientation marks.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/view/colors.h"
#include "palpa/view/view.h"

class vtkRenderer;

namespace palpa {
struct Picture;
}

namespace palpa::detail {

struct PixelPoint {
  double x_px;
  double y_px;
};

enum class Side { left, middle, right };

/// Draws with VTK's built-in font: equal letters on every machine.
class Canvas {
 public:
  /// \param renderer  outlives this
  Canvas(vtkRenderer* renderer, int width_px, int height_px);

  int width_px() const noexcept { return width_px_; }
  int height_px() const noexcept { return height_px_; }
  /// Size of ordinary text; unit of distances.
  double em_px() const noexcept { return em_px_; }

  void polygon(std::span<const PixelPoint> corners, const Color& color, double opacity = 1.0);
  void rectangle(double x_px, double y_px, double width_px, double height_px, const Color& color, double opacity = 1.0);
  void line(PixelPoint from, PixelPoint to, double thickness_px, const Color& color);
  /// Picture with its lower left corner at the position; later drawing lies over it.
  void picture(const Picture& picture, double x_px, double y_px);
  /// Text with the middle of its line at y_px, on a contrasting background.
  void text(std::string_view words, double x_px, double y_px, Side x_is, double size_em = 1.0, bool bold = false);
  double width_px_of(std::string_view words, double size_em = 1.0, bool bold = false) const;
  /// Text, cut and ended with "..." if wider than `width_px`.
  std::string fitted(std::string_view words, double width_px, double size_em, bool bold) const;

 private:
  vtkRenderer* renderer_;
  int width_px_;
  int height_px_;
  double em_px_;
};

/// Colour bar with a title.
struct ColorBar {
  std::string title;  ///< "force / N"
  ColorMap map;
};

struct LegendEntry {
  enum class Sign { patch, line };
  std::string words;
  std::vector<Color> colors;  ///< as blended over the background; several: side by side along the sign
  Sign sign = Sign::patch;
  std::optional<Color> rim{};  ///< edge colour of a patch; none: ink
};

/// Areas of a picture, in pixels from the lower left corner: title strip on top, column for annotations on the right, scene in
/// the rest.
struct Layout {
  /// \param titled  false: no strip
  Layout(const Canvas& canvas, bool titled);

  double scene_right_px;
  double scene_top_px;
};

/// Text in VTK's font, which has Latin-1 letters only: "rho_inf" for ρ∞, '?' for others.
std::string in_letters_of_font(std::string_view words);

/// 1, 2 or 5 times a power of ten, not above `limit` > 0.
double round_length(double limit) noexcept;
/// A length in nm, µm, mm, m or km: "20 mm". \param like_m  length that decides the unit, such as the longest of a picture; 0:
/// `length_m` \param file_unit_m  not 0: length in the file's own units, as "20 file units"
std::string length_words(double length_m, double like_m = 0.0, double file_unit_m = 0.0);
/// A number in few digits: "0.25", "-300", "2e-05"; three, or more if `step` needs them.
/// \param step  distance to the next number of a row, which must remain distinct; or 0
std::string number_words(double value, double step = 0.0);

/// Number below a colour bar.
struct BarNumber {
  std::string words;
  double at;         ///< [1] share of the bar
  double middle_px;  ///< middle of the text, from the bar's left end
};
/// Largest and smallest value of a bar, and round numbers at equal distances between them, as far as their texts do not
/// overlap; texts lie within the bar if they fit.
/// \param low, high  of the bar, low < high
/// \param width_of   [px] of a text
std::vector<BarNumber> numbers_below(double low, double high, double width_px,
                                     const std::function<double(std::string_view)>& width_of);

/// Paints strip and column white, over the scene, and the title.
void draw_margins(Canvas& canvas, const Layout& layout, std::string_view title);
/// Legend and colour bars, from the top of the column down.
void draw_explanations(Canvas& canvas, const Layout& layout, std::span<const LegendEntry> entries,
                       std::span<const ColorBar> bars);
/// At the bottom of the column. \param world_per_hand  [1] world metres per hand metre
void draw_scale_bar(Canvas& canvas, const Layout& layout, const View& view, double world_per_hand, double file_unit_m = 0.0);
/// Letters of the patient's directions at the scene's four edges. `axes`: of the world, LPS, in the hand frame.
void draw_orientation(Canvas& canvas, const Layout& layout, const View& view, std::span<const Vec3, 3> axes);
/// Axes x, y, z of the world as arrows above the scale bar.
void draw_axes(Canvas& canvas, const View& view, std::span<const Vec3, 3> axes);

}  // namespace palpa::detail
