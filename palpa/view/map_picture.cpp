#include "palpa/view/map_picture.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "palpa/base/printed.h"
#include "palpa/data/parallel.h"
#include "palpa/data/timed_field.h"
#include "palpa/mode/modes.h"
#include "palpa/view/canvas.h"
#include "palpa/view/colors.h"
#include "palpa/view/offscreen.h"

namespace palpa {
namespace {

using detail::Canvas;
using detail::Color;
using detail::ColorMap;
using detail::PixelPoint;
using detail::Side;

constexpr Color ink{0.13, 0.13, 0.15};
constexpr Color paper{1.0, 1.0, 1.0};
constexpr Color level_color{0.30, 0.30, 0.33};
constexpr Color unsettled_color{0.35, 0.70, 0.90};
// [1] Arrows along a side. More: they hide the colours; fewer: changes of direction are lost.
constexpr int arrows_along = 22;
// [1] Of the largest force: weaker forces fade to the paper's colour and have no arrow.
constexpr double faint_share = 0.04;

/// Orientation of a slice in the picture.
struct Sides {
  int across, right, up;       ///< axes of the hand: 0, 1, 2
  double right_sign, up_sign;  ///< [1] 1 or -1
  const char *right_words, *up_words;
};
constexpr std::array<Sides, 3> all_sides{{{0, 2, 1, 1, 1, "z / mm, towards you", "y / mm, up"},
                                          {1, 0, 2, 1, -1, "x / mm, to the right", "z / mm, away from you"},
                                          {2, 0, 1, 1, 1, "x / mm, to the right", "y / mm, up"}}};

double part(const Vec3& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
Vec3 along(int axis) { return {axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0}; }

/// One of the map's forces, interpolated between its points.
class Slice {
 public:
  Slice(const ForceMap& map, Vec3 MapPoint::*force) : map_(map), force_(force) {
    const auto flat = std::find(map.lattice.points.begin(), map.lattice.points.end(), 1);
    assert(flat != map.lattice.points.end());
    sides_ = all_sides[static_cast<std::size_t>(flat - map.lattice.points.begin())];
    columns_ = map.lattice.points[static_cast<std::size_t>(sides_.right)];
    rows_ = map.lattice.points[static_cast<std::size_t>(sides_.up)];
  }

  const Sides& sides() const { return sides_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }

  /// \param column, row  from the picture's lower left point, fractional
  Vec3 place_m(double column, double row) const {
    return map_.lattice.low_m +
           map_.lattice.spacing_m * (axis_index(column, columns_, sides_.right_sign) * along(sides_.right) +
                                     axis_index(row, rows_, sides_.up_sign) * along(sides_.up));
  }
  /// Fractional column and row of a pixel. \param y  from the top
  double column_of(int x, int side_px) const { return (x + 0.5) / side_px * columns_ - 0.5; }
  double row_of(int y, int side_px) const { return (side_px - y - 0.5) / side_px * rows_ - 0.5; }
  Vec3 pixel_place_m(int x, int y, int side_px) const { return place_m(column_of(x, side_px), row_of(y, side_px)); }
  /// \return  [N]
  Vec3 at(double column, double row) const {
    const int i = std::clamp(static_cast<int>(column), 0, columns_ - 2), j = std::clamp(static_cast<int>(row), 0, rows_ - 2);
    const double s = std::clamp(column - i, 0.0, 1.0), t = std::clamp(row - j, 0.0, 1.0);
    return (1 - t) * ((1 - s) * of(i, j) + s * of(i + 1, j)) + t * ((1 - s) * of(i, j + 1) + s * of(i + 1, j + 1));
  }
  /// \return  [N]
  Vec3 nearest(double column, double row) const {
    return of(static_cast<int>(std::lround(column)), static_cast<int>(std::lround(row)));
  }

  /// Index of a point in the map.
  std::size_t number(int column, int row) const {
    std::array<int, 3> index{0, 0, 0};
    index[static_cast<std::size_t>(sides_.right)] = static_cast<int>(axis_index(column, columns_, sides_.right_sign));
    index[static_cast<std::size_t>(sides_.up)] = static_cast<int>(axis_index(row, rows_, sides_.up_sign));
    return map_.lattice.number(index[0], index[1], index[2]);
  }

 private:
  static double axis_index(double n, int count, double sign) { return sign > 0.0 ? n : count - 1 - n; }
  Vec3 of(int column, int row) const { return map_.points[number(column, row)].*force_; }

  const ForceMap& map_;
  Vec3 MapPoint::*force_;
  Sides sides_{};
  int columns_ = 0, rows_ = 0;
};

/// Contour lines of the levels of a scene's modes.
class LevelLines {
 public:
  LevelLines(const Scene& scene, const Slice& slice, int side_px, double line_px) {
    const Similarity hand_to_world = scene.hand_to_world();
    std::vector<Level> levels;
    for (const SceneMode& mode : scene.modes()) {
      const SurfaceAndFriction* const surface = mode.mode.as<SurfaceAndFriction>();
      if (!mode.enabled || !surface) continue;
      const FieldPtr field = frozen(scene.field(surface->field).field, scene.time().at(0.0));
      for (const SurfaceAndFriction::Level& level : surface->levels) {
        levels.push_back({field, level.value});
        names_ += (names_.empty() ? "" : ", ") + (level.name.empty() ? detail::number_words(level.value) : level.name);
      }
    }
    cover_.resize(static_cast<std::size_t>(side_px) * static_cast<std::size_t>(side_px));
    const double pixel_m = norm(slice.pixel_place_m(1, 0, side_px) - slice.pixel_place_m(0, 0, side_px));
    const Vec3 across = along(slice.sides().across);
    detail::in_parts(side_px, 16, [&](std::int64_t first, std::int64_t last) {
      for (int y = static_cast<int>(first); y < last; ++y) {
        for (int x = 0; x < side_px; ++x) {
          const Vec3 world_m = hand_to_world.to_world(slice.pixel_place_m(x, y, side_px));
          double& cover = cover_[static_cast<std::size_t>(y * side_px + x)];
          for (const Level& level : levels) {
            const ScalarSample sample = level.field->scalar(world_m);
            if (!sample.inside) continue;
            const Vec3 slope = hand_to_world.gradient_to_hand(sample.gradient);
            const double per_px = norm(slope - dot(slope, across) * across) * pixel_m;
            const double away_px = std::abs(sample.value - level.value) / std::max(per_px, 1e-300);
            cover = std::max(cover, std::clamp(0.5 * line_px + 0.5 - away_px, 0.0, 1.0));
          }
        }
      }
    });
  }

  /// Of the levels, with commas; empty: none.
  const std::string& names() const { return names_; }
  /// Coverage of a pixel by a line [1]. \param y  from the top
  double cover(int x, int y, int side_px) const { return cover_[static_cast<std::size_t>(y * side_px + x)]; }

 private:
  struct Level {
    FieldPtr field;
    double value;  ///< the field's own unit
  };
  std::string names_;
  std::vector<double> cover_;
};

/// Position of a panel, in pixels from the lower left corner.
struct Panel {
  double left_px, bottom_px, side_px;
  double x_px(double column, const Slice& slice) const { return left_px + (column + 0.5) / slice.columns() * side_px; }
  double y_px(double row, const Slice& slice) const { return bottom_px + (row + 0.5) / slice.rows() * side_px; }
};

/// Colour for a force; faint forces fade to the paper's.
Color color_at(const ColorMap& colors, double force_n) {
  return detail::blended(colors.at(force_n).color, std::clamp(force_n / (faint_share * colors.high()), 0.0, 1.0), paper);
}

Picture painted(const Slice& slice, const LevelLines& lines, const ColorMap& colors, int side_px) {
  Picture picture{.width_px = side_px, .height_px = side_px, .rgb = {}};
  picture.rgb.reserve(3 * static_cast<std::size_t>(side_px) * static_cast<std::size_t>(side_px));
  for (int y = 0; y < side_px; ++y) {
    for (int x = 0; x < side_px; ++x) {
      Color color = color_at(colors, norm(slice.at(slice.column_of(x, side_px), slice.row_of(y, side_px))));
      if (const double cover = lines.cover(x, y, side_px); cover > 0.0)
        color = detail::blended(detail::lightness(color) > 55.0 ? level_color : paper, 0.85 * cover, color);
      for (const double value : {color.red, color.green, color.blue})
        picture.rgb.push_back(static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0))));
    }
  }
  return picture;
}

void draw_arrow(Canvas& canvas, PixelPoint tail, PixelPoint tip, double thickness_px, const Color& color) {
  const double dx = tip.x_px - tail.x_px, dy = tip.y_px - tail.y_px, length = std::hypot(dx, dy);
  if (!(length > 0.0)) return;
  const double head = std::min(4.2 * thickness_px, 0.7 * length), ux = dx / length, uy = dy / length;
  const PixelPoint foot{tip.x_px - head * ux, tip.y_px - head * uy};
  canvas.line(tail, foot, thickness_px, color);
  const PixelPoint corners[] = {tip,
                                {foot.x_px - 0.45 * head * uy, foot.y_px + 0.45 * head * ux},
                                {foot.x_px + 0.45 * head * uy, foot.y_px - 0.45 * head * ux}};
  canvas.polygon(corners, color);
}

void draw_arrows(Canvas& canvas, const Slice& slice, const Panel& panel, const ColorMap& colors) {
  const double cell_px = panel.side_px / arrows_along;
  for (int j = 0; j < arrows_along; ++j) {
    for (int i = 0; i < arrows_along; ++i) {
      const double column = (i + 0.5) * slice.columns() / arrows_along - 0.5,
                   row = (j + 0.5) * slice.rows() / arrows_along - 0.5;
      const Vec3 force_n = slice.nearest(column, row);
      const double right_n = slice.sides().right_sign * part(force_n, slice.sides().right),
                   up_n = slice.sides().up_sign * part(force_n, slice.sides().up);
      if (std::hypot(right_n, up_n) < faint_share * colors.high()) continue;
      const double px_per_n = 0.46 * cell_px / colors.high();
      const double x = panel.x_px(column, slice), y = panel.y_px(row, slice);
      const double dx = px_per_n * right_n, dy = px_per_n * up_n;
      const Color color = detail::lightness(color_at(colors, norm(force_n))) > 60.0 ? ink : paper;
      draw_arrow(canvas, {x - dx, y - dy}, {x + dx, y + dy}, 0.09 * cell_px, color);
    }
  }
}

void mark_unsettled(Canvas& canvas, const ForceMap& map, const Slice& slice, const Panel& panel) {
  const double size_px = std::max(2.0, panel.side_px / slice.columns());
  for (int row = 0; row < slice.rows(); ++row) {
    for (int column = 0; column < slice.columns(); ++column) {
      if (!map.points[slice.number(column, row)].unsettled) continue;
      canvas.rectangle(panel.x_px(column, slice) - 0.5 * size_px, panel.y_px(row, slice) - 0.5 * size_px, size_px, size_px,
                       unsettled_color);
    }
  }
}

void draw_frame(Canvas& canvas, const Slice& slice, const Panel& panel, const char* title) {
  const double em = canvas.em_px();
  const double right = panel.left_px + panel.side_px, top = panel.bottom_px + panel.side_px;
  const PixelPoint corners[] = {{panel.left_px, panel.bottom_px}, {right, panel.bottom_px}, {right, top}, {panel.left_px, top}};
  for (std::size_t n = 0; n < 4; ++n) canvas.line(corners[n], corners[(n + 1) % 4], 1.0, ink);
  canvas.text(title, 0.5 * (panel.left_px + right), top + 1.1 * em, Side::middle, 1.05, true);
  const auto marks = [&](int axis, bool is_up) {
    const double from_m = part(slice.place_m(-0.5, -0.5), axis);
    const double to_m = part(slice.place_m(slice.columns() - 0.5, slice.rows() - 0.5), axis);
    const double low_m = std::min(from_m, to_m), high_m = std::max(from_m, to_m);
    const double step_m = detail::round_length((high_m - low_m) / 3.5);
    for (double at_m = std::ceil(low_m / step_m) * step_m; at_m <= high_m + 1e-9; at_m += step_m) {
      const double share = (at_m - from_m) / (to_m - from_m);
      const std::string words = detail::number_words(std::abs(at_m) < 1e-9 ? 0.0 : 1e3 * at_m);
      const double x = panel.left_px + share * panel.side_px, y = panel.bottom_px + share * panel.side_px;
      if (is_up) {
        canvas.line({panel.left_px - 0.3 * em, y}, {panel.left_px, y}, 1.0, ink);
        canvas.text(words, panel.left_px - 0.6 * em, y, Side::right, 0.85);
      } else {
        canvas.line({x, panel.bottom_px - 0.3 * em}, {x, panel.bottom_px}, 1.0, ink);
        canvas.text(words, x, panel.bottom_px - 0.95 * em, Side::middle, 0.85);
      }
    }
  };
  marks(slice.sides().right, false);
  marks(slice.sides().up, true);
  canvas.text(slice.sides().right_words, 0.5 * (panel.left_px + right), panel.bottom_px - 2.3 * em, Side::middle, 0.9);
  canvas.text(slice.sides().up_words, panel.left_px - 0.6 * em, top + 1.1 * em, Side::left, 0.9);
}

double largest_n(const ForceMap& map) {
  double most_n = 0.0;
  for (const MapPoint& point : map.points) most_n = std::max({most_n, norm(point.first_contact_n), norm(point.steady_n)});
  return most_n > 1e-9 ? most_n : 1.0;
}

}  // namespace

Picture map_picture(const Scene& scene, const ForceMap& map, const MapPictureOptions& options) {
  const int width = options.width_px, height = options.height_px;
  detail::check_size(width, height, 800, 400);
  const Slice first(map, &MapPoint::first_contact_n), steady(map, &MapPoint::steady_n);
  const ColorMap colors = detail::force_colors(largest_n(map));

  detail::OffscreenWindow window(width, height);
  Canvas canvas(window.white(), width, height);
  const double em = canvas.em_px();
  const detail::Layout layout(canvas, true);
  const double at_mm = 1e3 * part(map.lattice.low_m, first.sides().across);
  const std::string where =
      detail::text("across %c at %s mm", "xyz"[first.sides().across], detail::number_words(at_mm).c_str());
  detail::draw_margins(canvas, layout, (scene.title.empty() ? std::string("Force on the hand") : scene.title) + " - " + where);

  const double margin_px = 4.2 * em,
               side_px =
                   std::floor(std::min(0.5 * layout.scene_right_px - margin_px - 0.8 * em, layout.scene_top_px - 5.6 * em));
  const double bottom_px = std::round(0.5 * (layout.scene_top_px - side_px) + 0.6 * em);
  const Panel panels[] = {{std::round(margin_px), bottom_px, side_px},
                          {std::round(0.5 * layout.scene_right_px + margin_px), bottom_px, side_px}};
  const LevelLines lines(scene, first, static_cast<int>(side_px), 0.09 * em);
  for (const bool is_steady : {false, true}) {
    const Panel& panel = panels[is_steady ? 1 : 0];
    const Slice& slice = is_steady ? steady : first;
    canvas.picture(painted(slice, lines, colors, static_cast<int>(side_px)), panel.left_px, panel.bottom_px);
    draw_arrows(canvas, slice, panel, colors);
    if (is_steady) mark_unsettled(canvas, map, slice, panel);
    draw_frame(canvas, slice, panel, is_steady ? "steady" : "first contact");
  }

  std::vector<detail::LegendEntry> legend;
  if (!lines.names().empty()) legend.push_back({lines.names(), {level_color}, detail::LegendEntry::Sign::line});
  if (std::any_of(map.points.begin(), map.points.end(), [](const MapPoint& point) { return point.unsettled; }))
    legend.push_back({"here it does not settle", {unsettled_color}});
  const detail::ColorBar bars[] = {{"force on hand / N", colors}};
  detail::draw_explanations(canvas, layout, legend, bars);
  return window.draw();
}

}  // namespace palpa
