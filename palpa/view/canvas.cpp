#include "palpa/view/canvas.h"

#include <vtkActor2D.h>
#include <vtkCellArray.h>
#include <vtkImageData.h>
#include <vtkImageMapper.h>
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
#include <cstring>
#include <iterator>
#include <utility>

#include "palpa/base/printed.h"
#include "palpa/view/picture.h"

namespace palpa::detail {
namespace {

constexpr Color ink{0.13, 0.13, 0.15};
constexpr Color paper{1.0, 1.0, 1.0};
constexpr Color hairline{0.86, 0.86, 0.86};
// [em] Width of the annotation column. More: less room for the scene; less: texts are cut.
constexpr double column_em = 12.0;
constexpr int dpi = 72;  // one typographic point is one pixel

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

void Canvas::picture(const Picture& picture, double x_px, double y_px) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(picture.width_px, picture.height_px, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(picture.width_px);
  for (int row = 0; row < picture.height_px; ++row)
    std::memcpy(image->GetScalarPointer(0, picture.height_px - 1 - row, 0), picture.rgb.data() + row * row_bytes, row_bytes);
  vtkNew<vtkImageMapper> mapper;
  mapper->SetInputData(image);
  mapper->SetColorWindow(255.0);
  mapper->SetColorLevel(127.5);
  vtkNew<vtkActor2D> actor;
  actor->SetMapper(mapper);
  actor->SetPosition(std::round(x_px), std::round(y_px));
  renderer_->AddActor2D(actor);
}

void Canvas::text(std::string_view given, double x_px, double y_px, Side x_is, double size_em, bool bold) {
  if (given.empty()) return;
  const std::string words = in_letters_of_font(given);
  const double width = width_px_of(words, size_em, bold);
  const double pad = 0.25 * em_px_;
  const double left = x_is == Side::left ? x_px : x_is == Side::middle ? x_px - 0.5 * width : x_px - width;
  rectangle(left - pad, y_px - 0.62 * size_em * em_px_, width + 2 * pad, 1.24 * size_em * em_px_, paper);

  vtkNew<vtkTextActor> actor;
  actor->SetInput(words.c_str());
  style(*actor->GetTextProperty(), size_em * em_px_, bold);
  actor->GetTextProperty()->SetJustificationToLeft();
  actor->GetTextProperty()->SetVerticalJustificationToBottom();
  // Baseline, not the middle of these letters: texts of a row align.
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

std::string length_words(double length_m, double like_m, double file_unit_m) {
  if (file_unit_m > 0.0) return number_words(length_m / file_unit_m) + " file units";
  struct Unit {
    double from_m;
    double size_m;
    const char* name;
  };
  static constexpr Unit units[] = {
      {1e3, 1e3, "km"}, {0.9999, 1.0, "m"}, {0.0999e-3, 1e-3, "mm"}, {0.0999e-6, 1e-6, "µm"}, {0.0, 1e-9, "nm"}};
  for (const Unit& unit : units) {
    if ((like_m > 0.0 ? like_m : length_m) >= unit.from_m) return number_words(length_m / unit.size_m) + " " + unit.name;
  }
  return {};
}

std::string number_words(double value, double step) {
  const double orders =
      step > 0.0 && value != 0.0 ? std::floor(std::log10(std::abs(value))) - std::floor(std::log10(step)) : 0.0;
  const int digits = static_cast<int>(std::clamp(1.0 + orders, 3.0, 15.0));
  // %g switches to exponents from 1000 on; whole numbers are legible up to a hundred thousand.
  if (std::abs(value) >= 999.5 && std::abs(value) < 1e5 && !(step > 0.0 && step < 1.0)) return text("%.0f", value);
  return text("%.*g", digits, value == 0.0 ? 0.0 : value);
}

Layout::Layout(const Canvas& canvas, bool titled)
    : scene_right_px(canvas.width_px() - column_em * canvas.em_px()),
      scene_top_px(canvas.height_px() - (titled ? 2.8 * canvas.em_px() : 0.0)) {}

void draw_margins(Canvas& canvas, const Layout& layout, std::string_view title) {
  const double em = canvas.em_px();
  const double right = std::round(layout.scene_right_px);
  const double top = std::round(layout.scene_top_px);
  canvas.rectangle(right, 0.0, canvas.width_px() - right, canvas.height_px(), paper);
  canvas.rectangle(right, 0.0, 1.0, top, hairline);
  if (title.empty()) return;
  canvas.rectangle(0.0, top, canvas.width_px(), canvas.height_px() - top, paper);
  canvas.rectangle(0.0, top, right + 1.0, 1.0, hairline);
  const double room_px = canvas.width_px() - 2 * em;
  // A title that is too wide is first shrunk, then cut.
  const double size_em = std::clamp(1.25 * room_px / canvas.width_px_of(title, 1.25, true), 0.8, 1.25);
  canvas.text(canvas.fitted(title, room_px, size_em, true), em, canvas.height_px() - 1.4 * em, Side::left, size_em, true);
}

namespace {

/// Wraps text into at most three lines of `width_px`; the last is cut.
std::vector<std::string> lines_of(const Canvas& canvas, std::string_view words, double width_px, double size_em) {
  std::vector<std::string> lines{""};
  while (!words.empty()) {
    const std::size_t end = std::min(words.find(' '), words.size());
    const std::string longer = lines.back() + (lines.back().empty() ? "" : " ") + std::string(words.substr(0, end));
    if (lines.back().empty() || lines.size() == 3 || canvas.width_px_of(longer, size_em) <= width_px) {
      lines.back() = longer;
    } else {
      lines.emplace_back(words.substr(0, end));
    }
    words.remove_prefix(std::min(end + 1, words.size()));
  }
  for (std::string& line : lines) line = canvas.fitted(line, width_px, size_em, false);
  return lines;
}

void draw_sign(Canvas& canvas, const LegendEntry& entry, double x, double y, double width) {
  const double em = canvas.em_px();
  const bool line = entry.sign == LegendEntry::Sign::line;
  const double half = (line ? 0.16 : 0.42) * em;
  const double edge = line ? 0.0 : entry.rim ? 0.14 * em : 1.0;
  if (!line) canvas.rectangle(x, y - half, width, 2 * half, entry.rim.value_or(ink));
  const double part = (width - 2 * edge) / static_cast<double>(entry.colors.size());
  for (std::size_t i = 0; i < entry.colors.size(); ++i) {
    canvas.rectangle(x + edge + part * static_cast<double>(i), y - half + edge, part, 2 * (half - edge), entry.colors[i]);
  }
}

/// Returns the y of its lower end, where the next bar may begin.
double draw_color_bar(Canvas& canvas, const ColorBar& bar, double left, double width, double top) {
  const double em = canvas.em_px();
  double y = top;
  for (const std::string& line : lines_of(canvas, bar.title, width, 1.0)) {
    canvas.text(line, left, y, Side::left);
    y -= 1.25 * em;
  }
  const double height = 0.9 * em;
  const double bottom = y - 0.45 * height;
  const double low = bar.map.low();
  const double span = bar.map.high() - low;
  canvas.rectangle(left - 1, bottom - 1, width + 2, height + 2, ink);
  constexpr int steps = 96;  // [1] strips of one colour. More: slower; fewer: visible steps
  for (int i = 0; i < steps; ++i) {
    const double from = std::round(left + i * width / steps);
    canvas.rectangle(from, bottom, std::round(left + (i + 1) * width / steps) - from, height,
                     bar.map.at(low + (i + 0.5) / steps * span).color);
  }
  if (span > 0.0) {
    constexpr double size_em = 0.9;
    const auto width_of = [&](std::string_view words) { return canvas.width_px_of(words, size_em); };
    for (const BarNumber& number : numbers_below(low, bar.map.high(), width, width_of)) {
      const double x = left + number.at * width;
      canvas.line({x, bottom - 0.35 * em}, {x, bottom}, 0.08 * em, ink);
      canvas.text(number.words, left + number.middle_px, bottom - 0.95 * em, Side::middle, size_em);
    }
  }
  return bottom - 1.6 * em;
}

}  // namespace

namespace {

/// Round numbers; only the first if their texts would overlap.
std::vector<BarNumber> round_numbers(double low, double high, double width_px,
                                     const std::function<double(std::string_view)>& width_of) {
  const double span = high - low, gap_px = 0.5 * width_of("0");
  std::vector<BarNumber> numbers;
  for (const double steps : {2.0, 1.0}) {
    numbers.clear();
    bool are_apart = true;
    double end_px = -gap_px;
    const double step = round_length(span / steps);
    const double first = std::ceil(low / step - 1e-9) * step;
    constexpr int most = 8;  // enough: a step is at least a fifth of the span; also ends the loop if rounding swallows the step
    for (int n = 0; n < most && first + n * step <= high + 1e-9 * span; ++n) {
      const double value = first + n * step;
      const std::string words = number_words(std::abs(value) < 1e-9 * step ? 0.0 : value, step);
      const double at = (value - low) / span, half_px = std::min(0.5 * width_of(words), 0.5 * width_px);
      const double middle_px = std::clamp(at * width_px, half_px, width_px - half_px);
      are_apart = are_apart && middle_px - half_px >= end_px + gap_px;
      end_px = middle_px + half_px;
      numbers.push_back({words, at, middle_px});
    }
    if (are_apart) return numbers;
  }
  numbers.resize(std::min<std::size_t>(numbers.size(), 1));
  return numbers;
}

}  // namespace

std::vector<BarNumber> numbers_below(double low, double high, double width_px,
                                     const std::function<double(std::string_view)>& width_of) {
  std::vector<BarNumber> numbers = round_numbers(low, high, width_px, width_of);
  const double gap_px = 0.5 * width_of("0"), precision = 0.01 * round_length(0.5 * (high - low));
  const auto left_px = [&](const BarNumber& n) { return n.middle_px - 0.5 * width_of(n.words); };
  const auto right_px = [&](const BarNumber& n) { return n.middle_px + 0.5 * width_of(n.words); };
  const auto end = [&](double value, double at) {
    const std::string words = number_words(value, precision);
    const double half_px = 0.5 * width_of(words);
    return BarNumber{words, at, at > 0.5 ? width_px - half_px : half_px};
  };
  constexpr double there = 1e-6;  // [1] of the bar: rounding
  const BarNumber last = end(high, 1.0), first = end(low, 0.0);
  if (left_px(last) < 0.0) return numbers;
  while (!numbers.empty() && (right_px(numbers.back()) + gap_px > left_px(last) || numbers.back().at > 1.0 - there))
    numbers.pop_back();
  while (!numbers.empty() && (left_px(numbers.front()) - gap_px < right_px(first) || numbers.front().at < there))
    numbers.erase(numbers.begin());
  if (right_px(first) + gap_px <= left_px(last)) numbers.insert(numbers.begin(), first);
  numbers.push_back(last);
  return numbers;
}

void draw_explanations(Canvas& canvas, const Layout& layout, std::span<const LegendEntry> entries,
                       std::span<const ColorBar> bars) {
  constexpr double size_em = 0.92;
  const double em = canvas.em_px();
  const double left = layout.scene_right_px + em;
  const double width = canvas.width_px() - left - em;
  const double sign = 1.5 * em;
  double y = layout.scene_top_px - 1.3 * em;
  for (const LegendEntry& entry : entries) {
    draw_sign(canvas, entry, left, y, sign);
    for (const std::string& line : lines_of(canvas, entry.words, width - sign - 0.5 * em, size_em)) {
      canvas.text(line, left + sign + 0.5 * em, y, Side::left, size_em);
      y -= 1.15 * em;
    }
    y -= 0.4 * em;
  }
  y -= 0.9 * em;
  for (const ColorBar& bar : bars) y = draw_color_bar(canvas, bar, left, width, y) - 1.2 * em;
}

void draw_scale_bar(Canvas& canvas, const Layout& layout, const View& view, double world_per_hand, double file_unit_m) {
  const double em = canvas.em_px();
  const double world_m_per_px = world_per_hand / view.px_per_m();
  const double left = layout.scene_right_px + em;
  const double length_m = round_length((canvas.width_px() - left - em) * world_m_per_px);
  const double length_px = length_m / world_m_per_px;
  const double y = 1.2 * em;
  canvas.line({left, y}, {left + length_px, y}, 0.18 * em, ink);
  for (const double end : {left, left + length_px}) canvas.line({end, y - 0.35 * em}, {end, y + 0.35 * em}, 0.14 * em, ink);
  canvas.text(length_words(length_m, 0.0, file_unit_m), left + 0.5 * length_px, y + 1.15 * em, Side::middle);
}

void draw_orientation(Canvas& canvas, const Layout& layout, const View& view, std::span<const Vec3, 3> axes) {
  static constexpr char letters[3][2] = {{'L', 'R'}, {'P', 'A'}, {'S', 'I'}};
  // Letters for a direction of the picture, the nearest axis first; axes far off it are left out.
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
  const double w = layout.scene_right_px;
  const double h = layout.scene_top_px;
  canvas.text(marks_of(-view.right), 0.8 * em, 0.5 * canvas.height_px(), Side::left, 1.3, true);
  canvas.text(marks_of(view.right), w - 0.8 * em, 0.5 * canvas.height_px(), Side::right, 1.3, true);
  canvas.text(marks_of(view.up), 0.5 * w, h - 1.2 * em, Side::middle, 1.3, true);
  canvas.text(marks_of(-view.up), 0.5 * w, 1.2 * em, Side::middle, 1.3, true);
}

void draw_axes(Canvas& canvas, const View& view, std::span<const Vec3, 3> axes) {
  static constexpr const char* names[] = {"x", "y", "z"};
  const double em = canvas.em_px();
  const PixelPoint origin{canvas.width_px() - 5.0 * em, 7.2 * em};
  std::vector<PixelPoint> taken;
  const auto name = [&](const char* word, double x, double y) {
    for (const PixelPoint& other : taken) {
      if (std::hypot(x - other.x_px, y - other.y_px) < 1.2 * em) y -= 1.3 * em;
    }
    taken.push_back({x, y});
    canvas.text(word, x, y, Side::middle);
  };
  std::array<int, 3> order{0, 1, 2};  // farthest first
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return dot(axes[a], view.towards) < dot(axes[b], view.towards); });
  for (const int i : order) {
    const double dx = dot(axes[i], view.right);
    const double dy = dot(axes[i], view.up);
    const double length = std::hypot(dx, dy);
    const PixelPoint tip{origin.x_px + 2.6 * em * dx, origin.y_px + 2.6 * em * dy};
    canvas.line(origin, tip, 0.16 * em, ink);
    if (length > 0.45) {
      const double ux = dx / length;
      const double uy = dy / length;
      const PixelPoint head[] = {{tip.x_px + 0.5 * em * ux, tip.y_px + 0.5 * em * uy},
                                 {tip.x_px - 0.3 * em * uy, tip.y_px + 0.3 * em * ux},
                                 {tip.x_px + 0.3 * em * uy, tip.y_px - 0.3 * em * ux}};
      canvas.polygon(head, ink);
      name(names[i], tip.x_px + 1.1 * em * ux, tip.y_px + 1.1 * em * uy);
    } else {
      name(names[i], tip.x_px - 0.9 * em, tip.y_px - 0.9 * em);
    }
  }
}

}  // namespace palpa::detail
