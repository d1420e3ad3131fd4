// What is painted over a view, in three dimensions or a slice: proxy, probe, spring, primitives, trail, and marks.
#pragma once

#include <QColor>
#include <QPainter>
#include <array>
#include <span>
#include <string>

#include "explorer/sample_ring.h"
#include "palpa/view/canvas.h"
#include "palpa/view/colors.h"
#include "palpa/view/streamlines.h"
#include "palpa/view/view.h"

namespace palpa::explorer {

QColor to_qt(const detail::Color& color);
/// The colour of mode number `mode`, as in pictures and reports.
QColor color_of_mode(std::size_t mode);

/// A view in device-independent pixels from the upper left corner, as Qt counts.
QPointF on_screen(const detail::View& view, const Vec3& at_m);

/// One point of the trail: where the proxy was, and the force then.
struct TrailPoint {
  Vec3 at_m;
  double force_n;
};
void paint_trail(QPainter& painter, const detail::View& view, std::span<const TrailPoint> trail, double most_n);
/// Streamlines near the proxy, each with an arrow where it goes.
void paint_streamlines(QPainter& painter, const detail::View& view, std::span<const detail::Streamline> lines);
/// The primitives coloured by mode and as large as their force, the spring, the probe (faded) and the proxy.
/// \param most_n  [N] the force that is drawn largest
void paint_moment(QPainter& painter, const detail::View& view, const Moment& moment, double most_n);
/// A length of the data in mm, or what fits, at the lower left. \param world_per_hand  [1] metres of the world in one of the
/// hand
void paint_scale_bar(QPainter& painter, const detail::View& view, double world_per_hand, const QColor& ink);
/// Letters of the patient's directions at the edges (R L A P S I), or the axes' names. \param axes  the world's, hand frame
void paint_directions(QPainter& painter, const detail::View& view, std::span<const Vec3, 3> axes, bool medical,
                      const QColor& ink);
/// Where the world's axes point: three short lines from one point, each with its patient's direction or its name.
void paint_axes(QPainter& painter, const detail::View& view, const QPointF& at, std::span<const Vec3, 3> axes, bool medical,
                const QColor& ink);
/// Legend and colour bars at the right edge.
void paint_explanations(QPainter& painter, const QRect& area, std::span<const detail::LegendEntry> legend,
                        std::span<const detail::ColorBar> bars, const QColor& ink, const QColor& ground);
/// Words with a rim, legible over anything light or dark.
void paint_rimmed(QPainter& painter, const QRectF& box, int flags, const QString& words, const QColor& ink);
/// Words on a ground that makes them legible over anything.
void paint_words(QPainter& painter, const QPointF& at, const QString& words, Qt::Alignment side, const QColor& ink,
                 const QColor& ground);

}  // namespace palpa::explorer
