#include "explorer/paint.h"

#include <QFontMetricsF>
#include <QPainterPath>
#include <QPolygonF>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "palpa/vtk/felt_tool.h"

namespace palpa::explorer {
namespace {

// In pixels, legible in any view.
constexpr double disc_px = 34.0;   // radius of a plane's disc. Larger: hides the data; smaller: hides its tilt
constexpr double rod_px = 46.0;    // half the length of a line
constexpr double arrow_px = 84.0;  // of the largest force
constexpr double force_px = 24.0;  // from the proxy to the number of the force. Nearer: on the ball
constexpr double least_shown_n = 1e-3;

/// Arrow with a head sized by the pen.
void arrow(QPainter& painter, const QPointF& from, const QPointF& to, const QColor& color, double width) {
  const QPointF way = to - from;
  const double length = std::hypot(way.x(), way.y());
  painter.setPen(QPen(color, width, Qt::SolidLine, Qt::RoundCap));
  if (length < 3.0 * width) {  // along the line of sight: a dot
    painter.setBrush(color);
    painter.drawEllipse(to, width, width);
    return;
  }
  const QPointF along = way / length, across{-along.y(), along.x()};
  const double head = std::min(5.0 * width, 0.5 * length);
  painter.drawLine(from, to - 0.8 * head * along);
  painter.setPen(Qt::NoPen);
  painter.setBrush(color);
  painter.drawPolygon(QPolygonF({to, to - head * along + 0.45 * head * across, to - head * along - 0.45 * head * across}));
}

void ball(QPainter& painter, const QPointF& at, double radius, const QColor& color, const QColor& rim) {
  QRadialGradient light(at - QPointF(0.35 * radius, 0.35 * radius), 1.4 * radius);
  light.setColorAt(0.0, color.lighter(190));
  light.setColorAt(1.0, color);
  painter.setPen(QPen(rim, 1.4));
  painter.setBrush(light);
  painter.drawEllipse(at, radius, radius);
}

/// Two directions perpendicular to a unit vector.
std::pair<Vec3, Vec3> across(const Vec3& q) {
  const Vec3 other = std::abs(q.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 a = normalized(cross(q, other));
  return {a, cross(q, a)};
}

void disc(QPainter& painter, const detail::View& view, const Vec3& at_m, const Vec3& normal, const QColor& color, bool idle) {
  const auto [a, b] = across(normal);
  QPolygonF rim;
  const double disc_m = disc_px / view.px_per_m();
  for (int i = 0; i < 40; ++i) {
    const double angle = 2.0 * M_PI * i / 40.0;
    rim << on_screen(view, at_m + disc_m * (std::cos(angle) * a + std::sin(angle) * b));
  }
  QColor fill = color;
  fill.setAlphaF(idle ? 0.15 : 0.4);
  painter.setPen(QPen(color, idle ? 1.0 : 1.8));
  painter.setBrush(fill);
  painter.drawPolygon(rim);
}

void primitive(QPainter& painter, const detail::View& view, const Moment& moment, const PlacedPrimitive& placed,
               double most_n) {
  const Primitive& p = placed.primitive;
  const QColor color = color_of_mode(p.id.mode);
  const double force_n = norm(placed.force_n);
  const bool idle = force_n < least_shown_n;
  const double rod_m = rod_px / view.px_per_m();
  const double length_m = (10.0 + arrow_px * std::clamp(force_n / most_n, 0.0, 1.0)) / view.px_per_m();
  switch (p.kind) {
    case PrimitiveKind::plane:
    case PrimitiveKind::corner:
      disc(painter, view, p.position_m, p.direction, color, idle);
      if (!idle)
        arrow(painter, on_screen(view, p.position_m), on_screen(view, p.position_m + length_m * p.direction), color, 2.5);
      break;
    case PrimitiveKind::line:
      painter.setPen(QPen(color, idle ? 1.5 : 3.0, Qt::SolidLine, Qt::RoundCap));
      painter.drawLine(on_screen(view, p.position_m - rod_m * p.direction),
                       on_screen(view, p.position_m + rod_m * p.direction));
      break;
    case PrimitiveKind::point: {
      QColor fill = color;
      fill.setAlphaF(0.5);
      painter.setPen(QPen(color, 1.5));
      painter.setBrush(fill);
      const double radius = 4.0 + 10.0 * std::clamp(force_n / most_n, 0.0, 1.0);
      painter.drawEllipse(on_screen(view, p.position_m), radius, radius);
      break;
    }
    case PrimitiveKind::directed:
      if (!idle)
        arrow(painter, on_screen(view, moment.proxy_m + placed.lever_m),
              on_screen(view, moment.proxy_m + placed.lever_m + length_m * normalized(placed.force_n)), color, 3.0);
      break;
  }
}

/// Outline colour with contrast to an ink.
QColor rim_of(const QColor& ink) { return ink.lightness() > 127 ? QColor(0, 0, 0, 150) : QColor(255, 255, 255, 150); }

/// Name of a direction of the world, along or against an axis. Worlds of medical data are LPS.
QString name_of_direction(int axis, bool against, bool medical) {
  static constexpr const char* patient[3][2] = {{"L", "R"}, {"P", "A"}, {"S", "I"}};
  static constexpr const char* plain[3][2] = {{"+x", "−x"}, {"+y", "−y"}, {"+z", "−z"}};
  return QString::fromUtf8((medical ? patient : plain)[axis][against ? 1 : 0]);
}

}  // namespace

QColor to_qt(const detail::Color& color) { return QColor::fromRgbF(color.red, color.green, color.blue); }
QColor color_of_mode(std::size_t mode) { return to_qt(detail::mode_color(mode)); }

QPointF on_screen(const detail::View& view, const Vec3& at_m) { return {view.x_px(at_m), view.height_px - view.y_px(at_m)}; }

void paint_trail(QPainter& painter, const detail::View& view, std::span<const TrailPoint> trail, double most_n) {
  const detail::ColorMap colors = detail::force_colors(std::max(most_n, 1e-3));
  for (std::size_t i = 1; i < trail.size(); ++i) {
    QColor color = to_qt(colors.at(trail[i].force_n).color);
    color.setAlphaF(0.25 + 0.75 * static_cast<double>(i) / static_cast<double>(trail.size()));
    painter.setPen(QPen(color, 3.0, Qt::SolidLine, Qt::RoundCap));
    painter.drawLine(on_screen(view, trail[i - 1].at_m), on_screen(view, trail[i].at_m));
  }
}

void paint_streamlines(QPainter& painter, const detail::View& view, std::span<const detail::Streamline> lines) {
  const QColor color(0, 90, 140, 190);
  for (const detail::Streamline& line : lines) {
    if (line.size() < 3) continue;
    QPolygonF way;
    for (const detail::StreamPoint& point : line) way << on_screen(view, point.position_m);
    painter.setPen(QPen(color, 1.4));
    painter.setBrush(Qt::NoBrush);
    painter.drawPolyline(way);
    arrow(painter, way[way.size() - 3], way.back(), color, 1.4);
  }
}

/// Nothing without a window.
static void paint_window(QPainter& painter, const detail::View& view, const Moment& moment) {
  if (!moment.has_window) return;
  painter.setPen(QPen(QColor(120, 170, 230, 170), 1.2, Qt::DashLine));
  for (std::size_t corner = 0; corner < moment.window_m.size(); ++corner) {
    for (const std::size_t axis : {1U, 2U, 4U}) {
      if ((corner & axis) == 0)
        painter.drawLine(on_screen(view, moment.window_m[corner]), on_screen(view, moment.window_m[corner | axis]));
    }
  }
}

void paint_moment(QPainter& painter, const detail::View& view, const Moment& moment, double most_n) {
  if (moment.tick < 0) return;
  paint_window(painter, view, moment);
  for (std::size_t i = 0; i < moment.count; ++i) primitive(painter, view, moment, moment.primitives[i], std::max(most_n, 1e-3));
  const QPointF proxy = on_screen(view, moment.proxy_m), probe = on_screen(view, moment.probe_m);
  painter.setPen(QPen(QColor(90, 90, 96), 2.0, Qt::DashLine));
  painter.drawLine(proxy, probe);
  painter.setPen(QPen(QColor(255, 255, 255, 200), 1.0));
  painter.setBrush(QColor(110, 110, 120, 110));
  painter.drawEllipse(probe, 5.0, 5.0);
  ball(painter, proxy, 7.0, QColor(22, 22, 28), Qt::white);
}

void paint_tool(QPainter& painter, const detail::View& view, const Tool& tool, const Moment& moment) {
  if (moment.tick < 0 || !moment.has_tool || tool.is_point()) return;
  if (!is_unit(moment.probe_turn, 1e-3) || !is_unit(moment.proxy_turn, 1e-3)) return;
  std::vector<std::size_t> order(tool.feet());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const Pose probe{moment.probe_m, moment.probe_turn}, proxy{moment.proxy_m, moment.proxy_turn};
  // From back to front.
  std::ranges::sort(order, {}, [&](std::size_t foot) { return dot(tool.foot_m(proxy, foot), view.towards); });
  painter.setPen(QPen(QColor(255, 255, 255, 160), 0.8));
  painter.setBrush(QColor(110, 110, 120, 90));
  for (const std::size_t foot : order) painter.drawEllipse(on_screen(view, tool.foot_m(probe, foot)), 3.0, 3.0);
  const float most_n = *std::ranges::max_element(moment.feet_n);
  for (const std::size_t foot : order) {
    const double red = redness(moment.feet_n[foot], most_n);
    const detail::FeltColor color = detail::foot_color(red);
    ball(painter, on_screen(view, tool.foot_m(proxy, foot)), 4.0 + 2.5 * red, QColor::fromRgbF(color[0], color[1], color[2]),
         QColor(255, 255, 255, 200));
  }
}

bool look_alike(std::span<const SeenHand> a, std::span<const SeenHand> b) {
  return std::ranges::equal(a, b, [](const SeenHand& x, const SeenHand& y) { return x.moment.looks_like(y.moment); });
}

void paint_hands(QPainter& painter, const detail::View& view, std::span<const SeenHand> hands, double most_n) {
  for (const SeenHand& hand : hands) {
    paint_moment(painter, view, hand.moment, most_n);
    paint_tool(painter, view, hand.tool, hand.moment);
  }
}

QString words_of_wrench(const Moment& moment) {
  const QString force = QString("%1 N").arg(norm(moment.command_n), 0, 'f', 2);
  return moment.has_tool ? force + QString::fromUtf8(", %1 mN·m").arg(1e3 * norm(moment.torque_nm), 0, 'f', 0) : force;
}

void paint_force(Texts& texts, const detail::View& view, const Moment& moment, const QColor& ink, const QColor& ground) {
  const double force_n = norm(moment.command_n);
  const QPointF proxy = on_screen(view, moment.proxy_m);
  if (moment.tick < 0 || force_n < 0.005 || !QRectF(0, 0, view.width_px, view.height_px).contains(proxy)) return;
  bool bears = false, faces = false;
  for (std::size_t i = 0; i < moment.count; ++i) {
    const Primitive& p = moment.primitives[i].primitive;
    const bool is_surface = p.kind == PrimitiveKind::plane || p.kind == PrimitiveKind::corner;
    if (!is_surface || norm(moment.primitives[i].force_n) < least_shown_n) continue;
    bears = true;
    faces = faces || dot(p.direction, view.towards) > 0.0;
  }
  if (bears && !faces) return;
  QPainter& painter = texts.painter();
  painter.save();
  QFont large = painter.font();
  large.setPointSizeF(1.7 * large.pointSizeF());
  large.setBold(true);
  painter.setFont(large);
  const QString words = words_of_wrench(moment);
  const double width = painter.fontMetrics().horizontalAdvance(words) + 8.0, height = painter.fontMetrics().height() + 4.0;
  // Beside a tool, not on its feet in contact.
  double feet_right_m = 0.0;
  for (std::size_t i = 0; i < moment.count; ++i) feet_right_m += dot(moment.primitives[i].lever_m, view.right);
  const bool has_room_left = proxy.x() - force_px - width > 0.0;
  const bool is_right = proxy.x() + force_px + width < view.width_px && !(feet_right_m > 0.0 && has_room_left);
  const double y = std::clamp(proxy.y() - force_px, 0.5 * height, view.height_px - 0.5 * height);
  texts.paint_card({proxy.x() + (is_right ? force_px : -force_px), y}, words, is_right ? Qt::AlignLeft : Qt::AlignRight, ink,
                   ground, view.width_px);
  painter.restore();
}

void paint_ghost(QPainter& painter, const detail::View& view, const Vec3& at_m) {
  const QPointF at = on_screen(view, at_m);
  painter.setBrush(QColor(22, 22, 28, 70));
  painter.setPen(QPen(QColor(255, 255, 255, 220), 2.2));
  painter.drawEllipse(at, 7.0, 7.0);
  painter.setPen(QPen(QColor(22, 22, 28, 220), 1.0));
  painter.drawEllipse(at, 8.2, 8.2);
}

QString coordinate_words(int axis, double at_m, bool medical, double world_per_hand) {
  // A hand's reach is about 0.2 m.
  struct Unit {
    const char* name;
    double per_m;
  };
  const Unit unit = world_per_hand < 10.0 ? Unit{"mm", 1e3} : world_per_hand < 1e4 ? Unit{"m", 1.0} : Unit{"km", 1e-3};
  static constexpr const char* plain[] = {"x", "y", "z"};
  const QString name = medical ? name_of_direction(axis, at_m < 0.0, true) : QString(plain[axis]);
  const double value = unit.per_m * (medical ? std::abs(at_m) : at_m);
  return QString("%1 %2 %3").arg(name).arg(std::abs(value) < 0.05 ? 0.0 : value, 0, 'f', 1).arg(unit.name);
}

void Texts::paint_card(const QPointF& at, const QString& words, Qt::Alignment side, const QColor& ink, const QColor& ground,
                       double room_px) {
  constexpr int flags = Qt::AlignCenter | Qt::TextWordWrap;
  QRectF box = painter_.boundingRect(QRectF(0, 0, room_px, 1e4), flags, words).adjusted(-4, -2, 4, 2);
  box.moveCenter(at);
  if (side & Qt::AlignLeft) box.moveLeft(at.x());
  if (side & Qt::AlignRight) box.moveRight(at.x());
  if (side & Qt::AlignTop) box.moveTop(at.y());
  if (side & Qt::AlignBottom) box.moveBottom(at.y());
  painter_.setPen(Qt::NoPen);
  painter_.setBrush(ground);
  painter_.drawRoundedRect(box, 3, 3);
  painter_.setPen(ink);
  painter_.drawText(box, flags, words);
  shown_.push_back({box, words});
}

bool Texts::paint_rimmed(const QRectF& box, int flags, const QString& words, const QColor& ink) {
  const QRectF letters = painter_.boundingRect(box, flags, words);
  const QRectF inner = letters.adjusted(0, 1, 0, -1);  // rows of a text touch
  if (std::ranges::any_of(shown_, [&](const PlacedText& other) { return other.box.intersects(inner); })) return false;
  painter_.setPen(rim_of(ink));
  for (const QPointF& shift : {QPointF(-1, 0), QPointF(1, 0), QPointF(0, -1), QPointF(0, 1)})
    painter_.drawText(box.translated(shift), flags, words);
  painter_.setPen(ink);
  painter_.drawText(box, flags, words);
  shown_.push_back({letters, words});
  return true;
}

void paint_scale_bar(Texts& texts, const detail::View& view, double world_per_hand, const QColor& ink) {
  const double world_per_px = world_per_hand / view.px_per_m();
  const double length_m = detail::round_length(0.22 * view.width_px * world_per_px);
  const double px = length_m / world_per_px;
  const double x = 14.0, y = view.height_px - 16.0;
  if (!texts.paint_rimmed(QRectF(x, y - 22, std::max(px, 90.0), 16), Qt::AlignLeft | Qt::AlignVCenter,
                          QString::fromStdString(detail::length_words(length_m)), ink))
    return;
  QPainter& painter = texts.painter();
  for (const QPen& pen : {QPen(rim_of(ink), 4.0), QPen(ink, 2.0)}) {
    painter.setPen(pen);
    painter.drawLine(QPointF(x, y), QPointF(x + px, y));
    painter.drawLine(QPointF(x, y - 4), QPointF(x, y + 4));
    painter.drawLine(QPointF(x + px, y - 4), QPointF(x + px, y + 4));
  }
}

void paint_directions(Texts& texts, const detail::View& view, std::span<const Vec3, 3> axes, bool medical, const QColor& ink,
                      double top_px) {
  const auto nearest = [&](const Vec3& direction) {
    int best = 0;
    double most = -2.0;
    for (int i = 0; i < 6; ++i) {
      const double along = (i % 2 == 0 ? 1.0 : -1.0) * dot(normalized(axes[static_cast<std::size_t>(i / 2)]), direction);
      if (along > most) most = along, best = i;
    }
    return name_of_direction(best / 2, best % 2 != 0, medical);
  };
  QPainter& painter = texts.painter();
  painter.save();
  QFont font = painter.font();
  font.setBold(true);
  painter.setFont(font);
  const double w = view.width_px, h = view.height_px;
  texts.paint_rimmed(QRectF(w - 34, h / 2 - 10, 28, 20), Qt::AlignRight | Qt::AlignVCenter, nearest(view.right), ink);
  texts.paint_rimmed(QRectF(6, h / 2 - 10, 28, 20), Qt::AlignLeft | Qt::AlignVCenter, nearest(-view.right), ink);
  texts.paint_rimmed(QRectF(w / 2 - 20, top_px, 40, 18), Qt::AlignCenter, nearest(view.up), ink);
  texts.paint_rimmed(QRectF(w / 2 - 20, h - 22, 40, 18), Qt::AlignCenter, nearest(-view.up), ink);
  painter.restore();
}

void paint_axes(QPainter& painter, const detail::View& view, const QPointF& at, std::span<const Vec3, 3> axes, bool medical,
                const QColor& ink) {
  // x, y, z in red, green and blue, in hues distinct for colour-blind users.
  static const QColor colors[3] = {QColor(213, 94, 0), QColor(0, 158, 115), QColor(0, 114, 178)};
  constexpr double length_px = 26.0;
  std::array<int, 3> order{0, 1, 2};
  const auto depth = [&](int axis) { return dot(normalized(axes[static_cast<std::size_t>(axis)]), view.towards); };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return depth(a) < depth(b); });
  painter.save();
  QFont font = painter.font();
  font.setBold(true);
  painter.setFont(font);
  for (const int axis : order) {
    const Vec3 along = normalized(axes[static_cast<std::size_t>(axis)]);
    const QPointF direction(dot(along, view.right), -dot(along, view.up));
    const QPointF end = at + length_px * direction;
    painter.setPen(QPen(colors[axis], 3.0, Qt::SolidLine, Qt::RoundCap));
    painter.drawLine(at, end);
    const QPointF beyond = end + 9.0 * (std::hypot(direction.x(), direction.y()) > 0.2 ? direction : QPointF(0.7, 0.7));
    Texts(painter).paint_rimmed(QRectF(beyond.x() - 14, beyond.y() - 9, 28, 18), Qt::AlignCenter,
                                name_of_direction(axis, false, medical), ink);
  }
  painter.restore();
}

double width_of_explanations(const QFont& font, std::span<const detail::LegendEntry> legend,
                             std::span<const detail::ColorBar> bars) {
  if (legend.empty() && bars.empty()) return 0.0;
  const QFontMetricsF metrics(font);
  const double em = metrics.height();
  double width = 5.0 * em;
  for (const detail::LegendEntry& entry : legend)
    width = std::max(width, metrics.horizontalAdvance(QString::fromStdString(entry.words)) + 2.2 * em);
  for (const detail::ColorBar& bar : bars)
    width = std::max(width, metrics.horizontalAdvance(QString::fromStdString(bar.title)) + em);
  return width + 0.6 * em;
}

void paint_explanations(Texts& texts, const QRect& area, std::span<const detail::LegendEntry> legend,
                        std::span<const detail::ColorBar> bars, const QColor& ink, const QColor& ground) {
  if (legend.empty() && bars.empty()) return;
  QPainter& painter = texts.painter();
  const QFontMetricsF metrics(painter.font());
  const double em = metrics.height();
  const double width = width_of_explanations(painter.font(), legend, bars);
  const double height = 0.8 * em + 1.25 * em * static_cast<double>(legend.size()) + 9.6 * em * static_cast<double>(bars.size());
  painter.setPen(Qt::NoPen);
  painter.setBrush(ground);
  const QRectF card(area.right() - width - 0.3 * em, area.top(), width, height);
  painter.drawRoundedRect(card, 4, 4);
  texts.keep_free(card);
  double y = area.top() + 0.5 * em;
  const double right = area.right() - 0.6 * em;
  for (const detail::LegendEntry& entry : legend) {
    const QString words = QString::fromStdString(entry.words);
    const double advance = metrics.horizontalAdvance(words);
    painter.setPen(ink);
    painter.drawText(QPointF(right - advance, y + metrics.ascent()), words);
    const QRectF patch(right - advance - 1.4 * em, y + 0.15 * em, em, 0.7 * em);
    painter.setPen(entry.rim ? QPen(to_qt(*entry.rim), 2.0) : QPen(ink, 1.0));
    painter.setBrush(entry.colors.empty() ? QColor(Qt::gray) : to_qt(entry.colors.front()));
    painter.drawRect(patch);
    y += 1.25 * em;
  }
  for (const detail::ColorBar& bar : bars) {
    y += 0.5 * em;
    painter.setPen(ink);
    painter.drawText(QRectF(area.left(), y, right - area.left(), em), Qt::AlignRight, QString::fromStdString(bar.title));
    y += 1.5 * em;
    const double bar_height = 7.0 * em;
    QLinearGradient shades(0, y + bar_height, 0, y);
    const double span = bar.map.high() - bar.map.low();
    for (const auto& point : bar.map.points())
      shades.setColorAt(span > 0.0 ? std::clamp((point.value - bar.map.low()) / span, 0.0, 1.0) : 0.0, to_qt(point.color));
    painter.setBrush(shades);
    painter.setPen(QPen(ink, 1.0));
    painter.drawRect(QRectF(right - em, y, em, bar_height));
    for (const double share : {0.0, 0.5, 1.0}) {
      const QString number = QString::fromStdString(detail::number_words(bar.map.low() + share * span));
      painter.drawText(QRectF(area.left(), y + (1.0 - share) * bar_height - 0.5 * em, right - 1.4 * em - area.left(), em),
                       Qt::AlignRight | Qt::AlignVCenter, number);
    }
    y += bar_height + 0.6 * em;
  }
}

}  // namespace palpa::explorer
