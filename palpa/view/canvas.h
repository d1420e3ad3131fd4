// Flat drawing over a picture: text and filled shapes, in pixels from the lower left corner; and the explanations beside a
// picture: title, legend, colour bars, scale bar, orientation marks.
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

/// Draws with VTK's own font, so that the letters are the same on every machine.
class Canvas {
 public:
  /// \param renderer  outlives this
  Canvas(vtkRenderer* renderer, int width_px, int height_px);

  int width_px() const noexcept { return width_px_; }
  int height_px() const noexcept { return height_px_; }
  /// The size of ordinary text, and the unit of all distances.
  double em_px() const noexcept { return em_px_; }

  void polygon(std::span<const PixelPoint> corners, const Color& color, double opacity = 1.0);
  void rectangle(double x_px, double y_px, double width_px, double height_px, const Color& color, double opacity = 1.0);
  void line(PixelPoint from, PixelPoint to, double thickness_px, const Color& color);
  /// A picture whose lower left corner is there; what is drawn later lies on it.
  void picture(const Picture& picture, double x_px, double y_px);
  /// Text whose line's middle is at y_px, on a ground that makes it legible over anything.
  void text(std::string_view words, double x_px, double y_px, Side x_is, double size_em = 1.0, bool bold = false);
  double width_px_of(std::string_view words, double size_em = 1.0, bool bold = false) const;
  /// The words, cut and ended with "..." where they are wider.
  std::string fitted(std::string_view words, double width_px, double size_em, bool bold) const;

 private:
  vtkRenderer* renderer_;
  int width_px_;
  int height_px_;
  double em_px_;
};

/// Says what a colour means.
struct ColorBar {
  std::string title;  ///< "force / N"
  ColorMap map;
};

struct LegendEntry {
  enum class Sign { patch, line };
  std::string words;
  std::vector<Color> colors;  ///< as they are seen on the ground; several: side by side along the sign
  Sign sign = Sign::patch;
  std::optional<Color> rim{};  ///< of a patch: what its edge is seen in; none: ink
};

/// Where a picture's parts lie, in pixels from the lower left corner: a strip for the title on top, a column for explanations
/// on the right, and the scene in the rest; outside of that nothing of the scene is seen.
struct Layout {
  /// \param titled  without a title there is no strip
  Layout(const Canvas& canvas, bool titled);

  double scene_right_px;
  double scene_top_px;
};

/// The words with the letters that VTK's font has, which are those of Latin-1: "rho_inf" for ρ∞, '?' for the rest.
std::string in_letters_of_font(std::string_view words);

/// 1, 2 or 5 times a power of ten, not above `limit` > 0.
double round_length(double limit) noexcept;
/// A length in nm, µm, mm, m or km: "20 mm". \param like_m  a length whose unit is used, such as the longest of a picture; 0:
/// its own \param file_unit_m  not 0: of the file's own units, as "20 file units"
std::string length_words(double length_m, double like_m = 0.0, double file_unit_m = 0.0);
/// A number in as few digits as tell it: "0.25", "-300", "2e-05"; three where `step` does not ask for more.
/// \param step  0, or what the next number of a row is away, from which it is to be told
std::string number_words(double value, double step = 0.0);

/// A number below a colour bar.
struct BarNumber {
  std::string words;
  double at;         ///< [1] share of the bar
  double middle_px;  ///< of the words, from the bar's left end
};
/// The bar's largest and smallest value, and between them round numbers at equal distances, where their words stay apart; words
/// lie within the bar where they fit at all.
/// \param low, high  of the bar, low < high
/// \param width_of   [px] of words
std::vector<BarNumber> numbers_below(double low, double high, double width_px,
                                     const std::function<double(std::string_view)>& width_of);

/// Paints strip and column white, over the scene, and writes the title.
void draw_margins(Canvas& canvas, const Layout& layout, std::string_view title);
/// Legend and colour bars, from the top of the column down.
void draw_explanations(Canvas& canvas, const Layout& layout, std::span<const LegendEntry> entries,
                       std::span<const ColorBar> bars);
/// At the bottom of the column. \param world_per_hand  the world's metres in one metre of the hand
void draw_scale_bar(Canvas& canvas, const Layout& layout, const View& view, double world_per_hand, double file_unit_m = 0.0);
/// Letters of the patient's directions at the scene's four edges. `axes`: the world's axes in the hand frame, LPS.
void draw_orientation(Canvas& canvas, const Layout& layout, const View& view, std::span<const Vec3, 3> axes);
/// The world's axes as arrows x, y, z above the scale bar.
void draw_axes(Canvas& canvas, const View& view, std::span<const Vec3, 3> axes);

}  // namespace palpa::detail
