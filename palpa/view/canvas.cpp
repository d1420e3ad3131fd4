#include "palpa/view/canvas.h"

#include <vtkActor2D.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <utility>

namespace palpa::detail {
namespace {

constexpr Color ink{0.13, 0.13, 0.15};
constexpr Color paper{1.0, 1.0, 1.0};
constexpr int dpi = 72;  // a point of type is a pixel

void style(vtkTextProperty& text, double size_px, bool bold) {
  text.SetFontFamilyToArial();
  text.SetFontSize(static_cast<int>(std::lround(size_px)));
  text.SetBold(bold);
  text.SetColor(ink.red, ink.green, ink.blue);
}

}  // namespace

Canvas::Canvas(vtkRenderer* renderer, int width_px, int height_px)
    : renderer_(renderer),
      width_px_(width_px),
      height_px_(height_px),
      em_px_(std::min(width_px / 1.2, 1.0 * height_px) / 41.0) {}

void Canvas::polygon(std::span<const PixelPoint> corners, const Color& color, double opacity) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> cells;
  cells->InsertNextCell(static_cast<int>(corners.size()));
  for (const PixelPoint& corner : corners) cells->InsertCellPoint(points->InsertNextPoint(corner.x_px, corner.y_px, 0.0));
  vtkNew<vtkPolyData> shape;
  shape->SetPoints(points);
  shape->SetPolys(cells);
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(shape);
  vtkNew<vtkActor2D> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(color.red, color.green, color.blue);
  actor->GetProperty()->SetOpacity(opacity);
  renderer_->AddActor2D(actor);
}

void Canvas::rectangle(double x_px, double y_px, double width_px, double height_px, const Color& color, double opacity) {
  const PixelPoint corners[] = {
      {x_px, y_px}, {x_px + width_px, y_px}, {x_px + width_px, y_px + height_px}, {x_px, y_px + height_px}};
  polygon(corners, color, opacity);
}

void Canvas::line(PixelPoint from, PixelPoint to, double thickness_px, const Color& color) {
  const double dx = to.x_px - from.x_px;
  const double dy = to.y_px - from.y_px;
  const double length = std::hypot(dx, dy);
  if (!(length > 0.0)) return;
  const double nx = -0.5 * thickness_px * dy / length;
  const double ny = 0.5 * thickness_px * dx / length;
  const PixelPoint corners[] = {{from.x_px - nx, from.y_px - ny},
                                {to.x_px - nx, to.y_px - ny},
                                {to.x_px + nx, to.y_px + ny},
                                {from.x_px + nx, from.y_px + ny}};
  polygon(corners, color);
}

void Canvas::text(std::string_view given, double x_px, double y_px, Side x_is, double size_em, bool bold) {
  if (given.empty()) return;
  const std::string words = in_letters_of_font(given);
  const double width = width_px_of(words, size_em, bold);
  const double pad = 0.25 * em_px_;
  const double left = x_is == Side::left ? x_px : x_is == Side::middle ? x_px - 0.5 * width : x_px - width;
  rectangle(left - pad, y_px - 0.62 * size_em * em_px_, width + 2 * pad, 1.24 * size_em * em_px_, paper, 0.72);

  vtkNew<vtkTextActor> actor;
  actor->SetInput(words.c_str());
  style(*actor->GetTextProperty(), size_em * em_px_, bold);
  actor->GetTextProperty()->SetJustificationToLeft();
  actor->GetTextProperty()->SetVerticalJustificationToBottom();
  // On the baseline, not on the middle of these letters: a row of texts stands on one line.
  actor->SetPosition(std::round(left), std::round(y_px - 0.5 * size_em * em_px_));
  actor->GetTextProperty()->UseTightBoundingBoxOff();
  renderer_->AddActor2D(actor);
}

double Canvas::width_px_of(std::string_view words, double size_em, bool bold) const {
  vtkNew<vtkTextProperty> property;
  style(*property, size_em * em_px_, bold);
  int box[4] = {0, 0, 0, 0};
  vtkTextRenderer::GetInstance()->GetBoundingBox(property, in_letters_of_font(words), box, dpi);
  return box[1] - box[0] + 1;
}

std::string Canvas::fitted(std::string_view words, double width_px, double size_em, bool bold) const {
  std::string shown(words);
  while (!shown.empty() && width_px_of(shown, size_em, bold) > width_px) {
    std::size_t keep = words.size() - 1;
    while (keep > 0 && (static_cast<unsigned char>(words[keep]) & 0xC0U) == 0x80U) --keep;  // whole letters of UTF-8
    words = words.substr(0, keep);
    shown = std::string(words) + "...";
  }
  return shown;
}

std::string in_letters_of_font(std::string_view words) {
  static constexpr std::pair<std::string_view, std::string_view> spelled[] = {
      {"ρ", "rho"},   {"∞", "_inf"}, {"α", "alpha"}, {"λ", "lambda"}, {"μ", "µ"}, {"ν", "nu"},
      {"ω", "omega"}, {"τ", "tau"},  {"…", "..."},   {"–", "-"},      {"−", "-"}, {"₂", "2"}};
  std::string out;
  while (!words.empty()) {
    const auto* known = std::ranges::find_if(spelled, [&](const auto& s) { return words.starts_with(s.first); });
    if (known != std::end(spelled)) {
      out += known->second;
      words.remove_prefix(known->first.size());
      continue;
    }
    const auto lead = static_cast<unsigned char>(words.front());
    std::size_t length = 1;  // of the letter, in UTF-8
    while (lead >= 0xC0U && length < words.size() && (static_cast<unsigned char>(words[length]) & 0xC0U) == 0x80U) ++length;
    out += lead > 0xC3U ? "?" : words.substr(0, length);
    words.remove_prefix(length);
  }
  return out;
}

double round_length(double limit) noexcept {
  const double power = std::pow(10.0, std::floor(std::log10(limit)));
  for (const double step : {5.0, 2.0}) {
    if (step * power <= limit) return step * power;
  }
  return power;
}

std::string length_words(double length_m) {
  struct Unit {
    double from_m;
    double size_m;
    const char* name;
  };
  static constexpr Unit units[] = {
      {1e3, 1e3, "km"}, {0.9999, 1.0, "m"}, {0.0999e-3, 1e-3, "mm"}, {0.0999e-6, 1e-6, "µm"}, {0.0, 1e-9, "nm"}};
  for (const Unit& unit : units) {
    if (length_m >= unit.from_m) return number_words(length_m / unit.size_m) + " " + unit.name;
  }
  return {};
}

std::string number_words(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value == 0.0 ? 0.0 : value);
  // %g turns to powers of ten from 1000 on; people read whole numbers up to a hundred thousand.
  if (std::abs(value) >= 999.5 && std::abs(value) < 1e5) std::snprintf(text, sizeof text, "%.0f", value);
  return text;
}

void draw_title(Canvas& canvas, std::string_view title) {
  const double em = canvas.em_px();
  const double room_px = canvas.width_px() - 2 * em;
  // Smaller before shorter.
  const double size_em = std::clamp(1.25 * room_px / canvas.width_px_of(title, 1.25, true), 0.8, 1.25);
  canvas.text(canvas.fitted(title, room_px, size_em, true), em, canvas.height_px() - 1.4 * em, Side::left, size_em, true);
}

void draw_color_bars(Canvas& canvas, std::span<const ColorBar> bars) {
  const double em = canvas.em_px();
  const double height = 8.0 * em;
  const double width = 1.0 * em;
  const double right = canvas.width_px() - 1.0 * em;
  double top = canvas.height_px() - 5.2 * em;
  for (const ColorBar& bar : bars) {
    if (top - height < 0.5 * canvas.height_px() && top > 0.5 * canvas.height_px() - em)
      top = 0.5 * canvas.height_px() - 3.0 * em;
    canvas.text(bar.title, right, top + 1.3 * em, Side::right);
    const double bottom = top - height;
    const double low = bar.map.low();
    const double span = bar.map.high() - low;
    canvas.rectangle(right - width - 1, bottom - 1, width + 2, height + 2, ink);
    constexpr int steps = 96;
    for (int i = 0; i < steps; ++i) {
      const Color color = bar.map.at(low + (i + 0.5) / steps * span).color;
      canvas.rectangle(right - width, bottom + i * height / steps, width, height / steps + 0.5, color);
    }
    if (span > 0.0) {
      const double step = round_length(span / 2.0);
      for (double value = std::ceil(low / step - 1e-9) * step; value <= bar.map.high() + 1e-9 * span; value += step) {
        const double y = bottom + (value - low) / span * height;
        canvas.line({right - width - 0.35 * em, y}, {right - width, y}, 0.08 * em, ink);
        canvas.text(number_words(std::abs(value) < 1e-9 * step ? 0.0 : value), right - width - 0.7 * em, y, Side::right, 0.9);
      }
    }
    top = bottom - 4.0 * em;
  }
}

void draw_legend(Canvas& canvas, std::span<const LegendEntry> entries) {
  const double em = canvas.em_px();
  double y = canvas.height_px() - 3.6 * em;
  for (const LegendEntry& entry : entries) {
    const double x = em;
    if (entry.sign == LegendEntry::Sign::line) {
      canvas.line({x, y}, {x + 1.4 * em, y}, 0.28 * em, entry.color);
    } else {
      canvas.rectangle(x, y - 0.42 * em, 1.4 * em, 0.84 * em, ink);
      canvas.rectangle(x + 1, y - 0.42 * em + 1, 1.4 * em - 2, 0.84 * em - 2, paper);
      canvas.rectangle(x + 1, y - 0.42 * em + 1, 1.4 * em - 2, 0.84 * em - 2, entry.color, std::max(entry.opacity, 0.45));
    }
    canvas.text(canvas.fitted(entry.words, 0.4 * canvas.width_px(), 0.95, false), x + 1.9 * em, y, Side::left, 0.95);
    y -= 1.45 * em;
  }
}

void draw_scale_bar(Canvas& canvas, const View& view, double world_per_hand) {
  const double em = canvas.em_px();
  const double world_m_per_px = world_per_hand / view.px_per_m();
  const double length_m = round_length(0.22 * canvas.width_px() * world_m_per_px);
  const double length_px = length_m / world_m_per_px;
  const double x = em;
  const double y = 1.2 * em;
  canvas.rectangle(x - 0.2 * em, y - 0.4 * em, length_px + 0.4 * em, 0.8 * em, paper, 0.72);
  canvas.line({x, y}, {x + length_px, y}, 0.18 * em, ink);
  for (const double end : {x, x + length_px}) canvas.line({end, y - 0.35 * em}, {end, y + 0.35 * em}, 0.14 * em, ink);
  canvas.text(length_words(length_m), x + 0.5 * length_px, y + 1.15 * em, Side::middle);
}

void draw_orientation(Canvas& canvas, const View& view, std::span<const Vec3, 3> axes) {
  static constexpr char letters[3][2] = {{'L', 'R'}, {'P', 'A'}, {'S', 'I'}};
  // The letters of a direction of the picture, the nearest axis first; what is far off says nothing.
  const auto marks_of = [&](const Vec3& direction) {
    std::array<int, 3> order{0, 1, 2};
    std::array<double, 3> along{};
    for (int i = 0; i < 3; ++i) along[i] = dot(axes[i], direction);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return std::abs(along[a]) > std::abs(along[b]); });
    std::string marks;
    for (const int i : order) {
      if (std::abs(along[i]) > 0.38) marks += letters[i][along[i] > 0.0 ? 0 : 1];
    }
    return marks;
  };
  const double em = canvas.em_px();
  const double w = canvas.width_px();
  const double h = canvas.height_px();
  canvas.text(marks_of(-view.right), 0.8 * em, 0.5 * h, Side::left, 1.3, true);
  canvas.text(marks_of(view.right), w - 0.8 * em, 0.5 * h, Side::right, 1.3, true);
  canvas.text(marks_of(view.up), 0.5 * w, h - 3.3 * em, Side::middle, 1.3, true);
  canvas.text(marks_of(-view.up), 0.5 * w, 1.3 * em, Side::middle, 1.3, true);
}

void draw_axes(Canvas& canvas, const View& view, std::span<const Vec3, 3> axes) {
  static constexpr const char* names[] = {"x", "y", "z"};
  const double em = canvas.em_px();
  const PixelPoint origin{canvas.width_px() - 4.2 * em, 3.6 * em};
  std::array<int, 3> order{0, 1, 2};  // the farthest first
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return dot(axes[a], view.towards) < dot(axes[b], view.towards); });
  for (const int i : order) {
    const double dx = dot(axes[i], view.right);
    const double dy = dot(axes[i], view.up);
    const double length = std::hypot(dx, dy);
    const PixelPoint tip{origin.x_px + 2.6 * em * dx, origin.y_px + 2.6 * em * dy};
    canvas.line(origin, tip, 0.16 * em, ink);
    if (length > 0.12) {
      const double ux = dx / length;
      const double uy = dy / length;
      const PixelPoint head[] = {{tip.x_px + 0.5 * em * ux, tip.y_px + 0.5 * em * uy},
                                 {tip.x_px - 0.3 * em * uy, tip.y_px + 0.3 * em * ux},
                                 {tip.x_px + 0.3 * em * uy, tip.y_px - 0.3 * em * ux}};
      canvas.polygon(head, ink);
      canvas.text(names[i], tip.x_px + 1.1 * em * ux, tip.y_px + 1.1 * em * uy, Side::middle);
    } else {
      canvas.text(names[i], tip.x_px - 0.9 * em, tip.y_px - 0.9 * em, Side::middle);
    }
  }
}

}  // namespace palpa::detail
