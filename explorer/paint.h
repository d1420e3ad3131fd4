// Overlay of a 3-D view or a slice: proxy, probe, spring, primitives, trail, and annotations.
#pragma once

#include <QColor>
#include <QPainter>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "explorer/sample_ring.h"
#include "palpa/view/canvas.h"
#include "palpa/view/colors.h"
#include "palpa/view/streamlines.h"
#include "palpa/view/view.h"

namespace palpa::explorer {

QColor to_qt(const detail::Color& color);
/// Colour of mode index `mode`, as in pictures and reports.
QColor color_of_mode(std::size_t mode);

/// Text in a picture, and the room that its letters take.
struct PlacedText {
  QRectF box;
  QString words;
};
/// Texts of one picture: of two that would meet, the one that is painted first stays, the other is left out.
class Texts {
 public:
  explicit Texts(QPainter& painter) : painter_(painter) {}
  QPainter& painter() { return painter_; }
  /// Text with a contrasting outline, legible on any background. False: left out.
  bool paint_rimmed(const QRectF& box, int flags, const QString& words, const QColor& ink);
  /// Text on a filled background, in rows no wider than `room_px`. \param side  of the text at `at`; else its middle
  void paint_card(const QPointF& at, const QString& words, Qt::Alignment side, const QColor& ink, const QColor& ground,
                  double room_px);
  /// Leaves out texts that would meet it.
  void keep_free(const QRectF& box) { shown_.push_back({box, {}}); }
  const std::vector<PlacedText>& shown() const { return shown_; }

 private:
  QPainter& painter_;
  std::vector<PlacedText> shown_;
};

/// Position in device-independent pixels from the upper left corner (Qt's convention).
QPointF on_screen(const detail::View& view, const Vec3& at_m);

/// Proxy position and force at that time.
struct TrailPoint {
  Vec3 at_m;
  double force_n;
};
void paint_trail(QPainter& painter, const detail::View& view, std::span<const TrailPoint> trail, double most_n);
/// Streamlines near the proxy, each with an arrow in flow direction.
void paint_streamlines(QPainter& painter, const detail::View& view, std::span<const detail::Streamline> lines);
/// Primitives (coloured by mode, sized by force), spring, probe (faded) and proxy; edges of the window
/// of the felt octave, of a volume larger than memory.
/// \param most_n  [N] force drawn at full size
void paint_moment(QPainter& painter, const detail::View& view, const Moment& moment, double most_n);
/// Feet of a tool: paler where the device holds it, and at the proxy, red by the force on each. Nothing for a moment without a
/// tool, or of a point.
void paint_tool(QPainter& painter, const detail::View& view, const Tool& tool, const Moment& moment);
/// A hand with its tool.
struct SeenHand {
  Tool tool{};
  Moment moment{};
};
/// True if a redraw can be skipped.
bool look_alike(std::span<const SeenHand> a, std::span<const SeenHand> b);
/// Primitives, probe, proxy and feet of each.
/// \param most_n  [N] as of `paint_moment`
void paint_hands(QPainter& painter, const detail::View& view, std::span<const SeenHand> hands, double most_n);
/// Force on the hand, and torque of a tool: "0.17 N", "0.17 N, 12 mN·m".
QString words_of_wrench(const Moment& moment);
/// Force on the hand in newtons, with the torque of a tool, large, beside the proxy: `words_of_wrench`. Nothing below 5 mN,
/// outside of the view, or while all surfaces that bear the hand are turned away.
void paint_force(Texts& texts, const detail::View& view, const Moment& moment, const QColor& ink, const QColor& ground);
/// Scale bar at the lower left, mm of the data or a unit that fits. \param world_per_hand  [1] world metres per hand metre
void paint_scale_bar(Texts& texts, const detail::View& view, double world_per_hand, const QColor& ink);
/// Letters of the patient's directions at the edges (R L A P S I), or the axes' names. \param axes  of the world, hand frame
/// \param top_px  [pixels] above: texts
void paint_directions(Texts& texts, const detail::View& view, std::span<const Vec3, 3> axes, bool medical, const QColor& ink,
                      double top_px = 22.0);
/// Axes of the world: three short lines from one point, each with its patient direction or name.
void paint_axes(QPainter& painter, const detail::View& view, const QPointF& at, std::span<const Vec3, 3> axes, bool medical,
                const QColor& ink);
/// [pixels] width of the card of `paint_explanations`; 0 without entries.
double width_of_explanations(const QFont& font, std::span<const detail::LegendEntry> legend,
                             std::span<const detail::ColorBar> bars);
/// Legend and colour bars at the right edge; keeps their card free of texts.
void paint_explanations(Texts& texts, const QRect& area, std::span<const detail::LegendEntry> legend,
                        std::span<const detail::ColorBar> bars, const QColor& ink, const QColor& ground);
/// Coordinate of the world, in the unit that fits scenes of this scale: "S 12.3 mm" or "z 12.3 mm".
/// \param world_per_hand  [1] world metres per hand metre
QString coordinate_words(int axis, double at_m, bool medical, double world_per_hand);
/// Semi-transparent proxy where a press would touch.
void paint_ghost(QPainter& painter, const detail::View& view, const Vec3& at_m);

}  // namespace palpa::explorer
