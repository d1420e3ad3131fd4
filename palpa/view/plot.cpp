#include "palpa/view/plot.h"

#include <vtkAxis.h>
#include <vtkBrush.h>
#include <vtkChartLegend.h>
#include <vtkChartXY.h>
#include <vtkContext2D.h>
#include <vtkContextActor.h>
#include <vtkContextItem.h>
#include <vtkContextScene.h>
#include <vtkDoubleArray.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPen.h>
#include <vtkPlotLine.h>
#include <vtkPlotPoints.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "palpa/base/printed.h"
#include "palpa/view/offscreen.h"
#include "palpa/view/svg_device.h"

namespace palpa {
namespace {

constexpr std::array<std::array<unsigned char, 3>, 8> palette{
    {{0, 0, 0}, {0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {178, 92, 148}, {62, 156, 209}, {204, 140, 0}, {120, 120, 120}}};
const std::array<unsigned char, 3>& rgb(CurveColor color) { return palette[static_cast<std::size_t>(color) % palette.size()]; }

int line_type(Stroke stroke) {
  return stroke == Stroke::dashed ? vtkPen::DASH_LINE : stroke == Stroke::dotted ? vtkPen::DOT_LINE : vtkPen::SOLID_LINE;
}

/// Range of an axis and its ticks, at 1, 2 or 5 times a power of ten.
struct Ticks {
  double low = 0.0, high = 1.0;
  std::vector<double> at;
  std::vector<std::string> labels;
};

Ticks ticks_of(double low, double high, bool widen, int wanted) {
  // Limits that cannot overflow, and a range wider than rounding.
  low = std::clamp(low, -1e300, 1e300);
  high = std::clamp(high, -1e300, 1e300);
  if (!(high - low > 1e-9 * std::max(std::abs(low), std::abs(high))) || high - low < 1e-300) {
    const double half = std::max(0.5 * std::abs(low), low == 0.0 ? 0.5 : 1e-300);
    low -= half;
    high += half;
  }
  const double rough = (high - low) / wanted;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= rough * 0.999) step = factor * power;
  }
  Ticks ticks{.low = low, .high = high, .at = {}, .labels = {}};
  if (widen) {
    ticks.low = step * std::floor(low / step + 1e-9);
    ticks.high = step * std::ceil(high / step - 1e-9);
  } else if (const double next = step * std::round(high / step); std::abs(next - high) < 1e-3 * (high - low)) {
    ticks.high = std::max(high, next);  // an axis up to 9.999 s gets its tick at 10 s
  }
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 12);
  const double first = std::ceil(ticks.low / step - 1e-9);
  for (int i = 0; (first + i) * step <= ticks.high + 1e-9 * step; ++i) {
    const double value = (first + i) * step + 0.0;
    const bool wide = std::abs(step) >= 1e6 || step < 1e-6;
    ticks.at.push_back(value);
    ticks.labels.push_back(wide ? detail::text("%.6g", value) : detail::text("%.*f", decimals, value));
  }
  return ticks;
}

/// Smallest and largest finite value of all series along one axis.
template <class Get>
std::pair<double, double> extent(const Plot& plot, Get get, double low, double high) {
  for (const Series& series : plot.series) {
    for (std::size_t i = 0; i < std::min(series.xs.size(), series.ys.size()); ++i) {
      if (!std::isfinite(series.xs[i]) || !std::isfinite(series.ys[i])) continue;
      low = std::min(low, get(series, i));
      high = std::max(high, get(series, i));
    }
  }
  return {low, high};
}

void set_ticks(vtkAxis* axis, const Ticks& ticks, double length_px, float scale) {
  axis->SetBehavior(vtkAxis::FIXED);
  axis->SetRange(0.0, length_px);
  vtkNew<vtkDoubleArray> positions;
  vtkNew<vtkStringArray> labels;
  for (std::size_t i = 0; i < ticks.at.size(); ++i) {
    positions->InsertNextValue((ticks.at[i] - ticks.low) / (ticks.high - ticks.low) * length_px);
    labels->InsertNextValue(ticks.labels[i]);
  }
  axis->SetCustomTickPositions(positions, labels);
  axis->SetTitle("");  // VTK reserves 10 pixels for it at any scale; LabelItem draws it instead
  axis->GetLabelProperties()->SetFontSize(static_cast<int>(12 * scale));
  axis->GetPen()->SetColor(90, 90, 90);
  axis->GetPen()->SetWidth(scale);
  axis->GetGridPen()->SetColor(228, 228, 228);
  axis->GetGridPen()->SetWidth(scale);
  axis->SetTickLength(4 * scale);
  axis->SetLabelOffset(6 * scale);
}

/// Area enclosed by a plot's axes, and its ranges of the data.
struct Area {
  vtkRectf place;
  Ticks x, y;

  /// The chart is in pixels, not in the data's units: the SVG keeps only six digits.
  double x_px(double x_value) const { return (x_value - x.low) / (x.high - x.low) * place.GetWidth(); }
  double y_px(double y_value) const { return (y_value - y.low) / (y.high - y.low) * place.GetHeight(); }
  bool holds(double x_value, double y_value) const {
    return x_value >= x.low && x_value <= x.high && y_value >= y.low && y_value <= y.high;
  }
};

vtkSmartPointer<vtkTable> table_of(const Series& series, const Area& area) {
  vtkNew<vtkDoubleArray> xs, ys;
  xs->SetName("x");
  ys->SetName("y");
  for (std::size_t i = 0; i < std::min(series.xs.size(), series.ys.size()); ++i) {
    // An SVG is not clipped: leave out points outside of the area.
    if (!area.holds(series.xs[i], series.ys[i])) continue;
    xs->InsertNextValue(area.x_px(series.xs[i]));
    ys->InsertNextValue(area.y_px(series.ys[i]));
  }
  auto table = vtkSmartPointer<vtkTable>::New();
  table->AddColumn(xs);
  table->AddColumn(ys);
  return table;
}

/// Adds a series to the chart, which owns its data.
void add_series(vtkChartXY* chart, const Area& area, const Series& series, int marker, float marker_px, float width_px) {
  const vtkSmartPointer<vtkTable> table = table_of(series, area);
  if (table->GetNumberOfRows() == 0) return;
  vtkPlot* plot = chart->AddPlot(series.points_only ? vtkChart::POINTS : vtkChart::LINE);
  plot->SetInputData(table, 0, 1);
  const auto& color = rgb(series.color);
  plot->SetColor(color[0], color[1], color[2], 255);
  plot->SetWidth(width_px);
  // Dots of a wide pen are hardly visible: use dashes and dots.
  const bool unseen = series.stroke == Stroke::dotted && width_px > 1.0f;
  plot->GetPen()->SetLineType(unseen ? static_cast<int>(vtkPen::DASH_DOT_LINE) : line_type(series.stroke));
  plot->SetLabel("\u00a0" + series.name);  // space behind the sign
  plot->SetLegendVisibility(!series.name.empty());
  if (auto* points = vtkPlotPoints::SafeDownCast(plot)) {
    points->SetMarkerStyle(series.points_only ? marker : vtkPlotPoints::NONE);
    points->SetMarkerSize(marker_px);
  }
}

/// Approximate width of a text [px]: fonts differ little.
float width_of(const std::string& text, int size) {
  const auto characters = std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; });
  return 0.58f * static_cast<float>(size) * static_cast<float>(characters);
}

constexpr int label_size = 12, axis_size = 13, title_size = 15;  // [px] larger: less room for curves; smaller: hard to read

/// Legend entries: named series, and kinds of marks.
std::vector<std::string> legend_of(const Plot& plot) {
  std::vector<std::string> names;
  for (const Series& series : plot.series) {
    if (!series.name.empty()) names.push_back(series.name);
  }
  for (const Mark& mark : plot.marks) {
    if (std::find(names.begin(), names.end(), mark.kind) == names.end()) names.push_back(mark.kind);
  }
  if (names.size() == 1 && plot.marks.empty()) names.clear();
  return names;
}

/// Labels of a logarithmic axis: exponents become powers of ten; a short range has ticks at 2 and 5 times each, too.
void name_powers(Ticks& ticks) {
  if (ticks.high - ticks.low < 3.0 && std::max(std::abs(ticks.low), std::abs(ticks.high)) < 6.0) {
    ticks.at.clear();
    ticks.labels.clear();
    for (double power = std::floor(ticks.low); power <= ticks.high; ++power) {
      for (const double digit : {1.0, 2.0, 5.0}) {
        const double at = power + std::log10(digit);
        if (at < ticks.low - 1e-9 || at > ticks.high + 1e-9) continue;
        ticks.at.push_back(at);
        ticks.labels.push_back(detail::text("%.6g", digit * std::pow(10.0, power)));
      }
    }
    return;
  }
  for (std::size_t i = 0; i < ticks.at.size(); ++i) {
    const double exponent = ticks.at[i];
    if (std::abs(exponent) < 3.5) {
      ticks.labels[i] = detail::text("%.3g", std::pow(10.0, exponent));
      continue;
    }
    ticks.labels[i] = "1e" + ticks.labels[i];  // VTK's font has no raised minus
  }
}

/// Area of the axes, with room for title, labels and legend around it.
Area area_of(const Plot& plot, const vtkRectf& place, float scale) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::pair<double, double> xs = plot.x_range.value_or(extent(
      plot, [](const Series& s, std::size_t i) { return s.xs[i]; }, infinity, -infinity));
  if (!std::isfinite(xs.first) || !std::isfinite(xs.second)) xs = {0.0, 1.0};
  const double least = plot.y_log ? infinity : 0.0;  // a linear axis includes zero
  std::pair<double, double> ys = plot.y_range.value_or(extent(
      plot, [](const Series& s, std::size_t i) { return s.ys[i]; }, least, -least));
  if (!std::isfinite(ys.first) || !std::isfinite(ys.second)) ys = {0.0, 1.0};
  const auto wanted_of = [](int wanted, const std::pair<double, double>& range, bool log) {
    const int decades = static_cast<int>(std::clamp(range.second - range.first, 1.0, 700.0));
    return log ? std::min(wanted, decades) : wanted;
  };
  const int high = std::max(3, static_cast<int>(place.GetHeight() / (55 * scale)));
  Area area;
  area.y = ticks_of(ys.first, ys.second, !plot.y_range, wanted_of(high, ys, plot.y_log));
  if (plot.y_log) name_powers(area.y);

  float left = 0, right = 18;
  for (const std::string& label : area.y.labels) left = std::max(left, width_of(label, label_size));
  left += plot.y_label.empty() ? 14.0f : 34.0f;
  for (const std::string& name : legend_of(plot)) right = std::max(right, width_of(name, label_size) + 48);
  const float top = plot.title.empty() ? 10.0f : 32.0f;
  const float bottom = plot.x_label.empty() ? 24.0f : 44.0f;
  area.place = vtkRectf(place.GetX() + left * scale, place.GetY() + bottom * scale, place.GetWidth() - (left + right) * scale,
                        place.GetHeight() - (top + bottom) * scale);
  const int wide = std::max(3, static_cast<int>(area.place.GetWidth() / (65 * scale)));
  area.x = ticks_of(xs.first, xs.second, false, wanted_of(wide, xs, plot.x_log));
  if (plot.x_log) name_powers(area.x);
  return area;
}

/// Replaces values along logarithmic axes by decimal logarithms, so that all drawing is linear.
Plot by_powers_of_ten(Plot plot) {
  const auto log = [](double& value) { value = value > 0.0 ? std::log10(value) : std::numeric_limits<double>::quiet_NaN(); };
  const auto log_of_both = [&](std::optional<std::pair<double, double>>& range) {
    if (!range) return;
    log(range->first);
    log(range->second);
  };
  for (Series& series : plot.series) {
    if (plot.x_log) std::for_each(series.xs.begin(), series.xs.end(), log);
    if (plot.y_log) std::for_each(series.ys.begin(), series.ys.end(), log);
  }
  if (plot.x_log) {
    for (Mark& mark : plot.marks) log(mark.x);
    log_of_both(plot.x_range);
  }
  if (plot.y_log) log_of_both(plot.y_range);
  return plot;
}

/// Marks of one kind, as a series at the top of the area.
struct Signs {
  std::string kind;
  std::vector<double> xs;  ///< in the x axis' own unit
};

/// Marks by kind; marks on one pixel are merged.
std::vector<Signs> signs_of(const Plot& plot, const Area& area, float scale) {
  std::vector<Signs> kinds;
  for (const Mark& mark : plot.marks) {
    auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const Signs& known) { return known.kind == mark.kind; });
    if (kind == kinds.end()) kind = kinds.insert(kinds.end(), {.kind = mark.kind, .xs = {}});
    if (!(mark.x >= area.x.low && mark.x <= area.x.high)) continue;
    if (!kind->xs.empty() && std::abs(area.x_px(mark.x) - area.x_px(kind->xs.back())) < 3 * scale) continue;
    kind->xs.push_back(mark.x);
  }
  return kinds;
}

/// Text centred at a position of a scene.
class LabelItem : public vtkContextItem {
 public:
  static LabelItem* New();
  vtkTypeMacro(LabelItem, vtkContextItem);

  void set(const std::string& label, float x_px, float y_px, float size_px, bool upright, bool bold) {
    label_ = label;
    at_ = {x_px, y_px};
    size_ = static_cast<int>(size_px);
    upright_ = upright;
    bold_ = bold;
  }
  bool Paint(vtkContext2D* painter) override {
    vtkTextProperty* look = painter->GetTextProp();
    look->SetColor(0.0, 0.0, 0.0);
    look->SetFontFamilyToArial();
    look->SetFontSize(size_);
    look->SetBold(bold_);
    look->SetItalic(false);
    look->SetOrientation(upright_ ? 90.0 : 0.0);
    look->SetJustificationToCentered();
    look->SetVerticalJustificationToCentered();
    painter->DrawString(at_[0], at_[1], label_);
    look->SetOrientation(0.0);
    return true;
  }

 protected:
  LabelItem() = default;
  ~LabelItem() override = default;

 private:
  std::string label_;
  std::array<float, 2> at_{};
  int size_ = 12;
  bool upright_ = false, bold_ = false;
};
vtkStandardNewMacro(LabelItem);

void add_label(vtkContextScene* scene, const std::string& label, float x_px, float y_px, float size_px, bool upright,
               bool bold) {
  if (label.empty()) return;
  vtkNew<LabelItem> item;
  item->set(label, x_px, y_px, size_px, upright, bold);
  scene->AddItem(item);
}

/// Puts the legend to the right of the chart's area.
void place_legend(vtkChartXY& chart, std::size_t entries, const vtkRectf& place, float scale) {
  chart.SetShowLegend(entries > 0);
  vtkChartLegend* legend = chart.GetLegend();
  legend->SetHorizontalAlignment(vtkChartLegend::CUSTOM);
  legend->SetVerticalAlignment(vtkChartLegend::CUSTOM);
  legend->SetPoint(place.GetX() + place.GetWidth() + 6 * scale,
                   place.GetY() + place.GetHeight() - 20 * scale * static_cast<float>(entries));
  legend->SetLabelSize(static_cast<int>(label_size * scale));
  legend->SetPadding(static_cast<int>(5 * scale));
  legend->SetSymbolWidth(static_cast<int>(26 * scale));
  legend->GetPen()->SetLineType(vtkPen::NO_PEN);
  legend->GetBrush()->SetColor(255, 255, 255, 0);
}

void add_chart(vtkContextScene* scene, const Plot& given, const vtkRectf& place, float scale) {
  const Plot plot = by_powers_of_ten(given);
  const Area area = area_of(plot, place, scale);
  vtkNew<vtkChartXY> chart;
  scene->AddItem(chart);
  chart->SetAutoSize(false);
  chart->SetLayoutStrategy(vtkChart::AXES_TO_RECT);
  chart->SetSize(area.place);
  chart->SetRenderEmpty(true);
  set_ticks(chart->GetAxis(vtkAxis::BOTTOM), area.x, area.place.GetWidth(), scale);
  set_ticks(chart->GetAxis(vtkAxis::LEFT), area.y, area.place.GetHeight(), scale);

  // Lines of the marks first, beneath the curves; their signs last.
  const std::vector<Signs> kinds = signs_of(plot, area, scale);
  for (const Signs& kind : kinds) {
    for (const double x : kind.xs) {
      add_series(chart, area,
                 {.xs = {x, x}, .ys = {area.y.low, area.y.high}, .color = CurveColor::grey, .stroke = Stroke::dotted}, 0, 0.0f,
                 0.8f * scale);
    }
  }
  const int columns = std::max(1, static_cast<int>(area.place.GetWidth() / scale));
  constexpr int markers[] = {vtkPlotPoints::CIRCLE, vtkPlotPoints::SQUARE, vtkPlotPoints::DIAMOND};
  int next_marker = 0;
  for (const Series& series : plot.series) {
    const int marker = series.points_only ? markers[next_marker++ % 3] : 0;
    add_series(chart, area, thinned(series, area.x.low, area.x.high, columns), marker, 7 * scale, 1.6f * scale);
  }
  constexpr std::pair<int, CurveColor> looks[] = {{vtkPlotPoints::DIAMOND, CurveColor::grey},
                                                  {vtkPlotPoints::CROSS, CurveColor::black},
                                                  {vtkPlotPoints::SQUARE, CurveColor::vermilion}};
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const auto& [marker, color] = looks[i % 3];
    const double top = area.y.high - 0.03 * (area.y.high - area.y.low);
    add_series(chart, area,
               {.name = kinds[i].kind,
                .xs = kinds[i].xs,
                .ys = std::vector<double>(kinds[i].xs.size(), top),
                .color = color,
                .points_only = true},
               marker, 8 * scale, 1.6f * scale);
  }

  const float middle_x = area.place.GetX() + area.place.GetWidth() / 2,
              middle_y = area.place.GetY() + area.place.GetHeight() / 2;
  add_label(scene, plot.title, middle_x, place.GetY() + place.GetHeight() - 11 * scale, title_size * scale, false, true);
  add_label(scene, plot.x_label, middle_x, place.GetY() + 8 * scale, axis_size * scale, false, false);
  add_label(scene, plot.y_label, place.GetX() + 8 * scale, middle_y, axis_size * scale, true, false);

  place_legend(*chart, legend_of(plot).size(), area.place, scale);
}

/// Halves width and height, averaging four pixels each.
Picture halved(const Picture& fine) {
  Picture picture{.width_px = fine.width_px / 2, .height_px = fine.height_px / 2, .rgb = {}};
  picture.rgb.resize(static_cast<std::size_t>(picture.width_px) * picture.height_px * 3);
  const auto at = [&](int x, int y, int c) {
    return static_cast<int>(fine.rgb[(static_cast<std::size_t>(y) * fine.width_px + x) * 3 + c]);
  };
  std::size_t out = 0;
  for (int y = 0; y < picture.height_px; ++y) {
    for (int x = 0; x < picture.width_px; ++x) {
      for (int c = 0; c < 3; ++c) {
        const int sum = at(2 * x, 2 * y, c) + at(2 * x + 1, 2 * y, c) + at(2 * x, 2 * y + 1, c) + at(2 * x + 1, 2 * y + 1, c);
        picture.rgb[out++] = static_cast<std::uint8_t>((sum + 2) / 4);
      }
    }
  }
  return picture;
}

/// Fills a scene of `scale` times width × height pixels with the sheet.
void fill(vtkContextScene* scene, const Sheet& sheet, int width_px, int height_px, float scale) {
  const int columns = std::max(1, sheet.columns);
  const int rows = std::max(1, (static_cast<int>(sheet.panels.size()) + columns - 1) / columns);
  scene->SetGeometry(static_cast<int>(scale * static_cast<float>(width_px)),
                     static_cast<int>(scale * static_cast<float>(height_px)));
  const float width = scale * static_cast<float>(width_px) / static_cast<float>(columns);
  const float height = scale * static_cast<float>(height_px) / static_cast<float>(rows);
  const float margin = 6 * scale;
  for (std::size_t i = 0; i < sheet.panels.size(); ++i) {
    const auto column = static_cast<float>(static_cast<int>(i) % columns);
    const auto row = static_cast<float>(rows - 1 - static_cast<int>(i) / columns);
    const vtkRectf place(column * width + margin, row * height + margin, width - 2 * margin, height - 2 * margin);
    add_chart(scene, sheet.panels[i], place, scale);
  }
}

}  // namespace

Series thinned(const Series& series, double x_low, double x_high, int columns) {
  const std::size_t size = std::min(series.xs.size(), series.ys.size());
  if (columns < 1 || size <= 4 * static_cast<std::size_t>(columns) || !(x_high > x_low)) return series;
  Series result = series;
  result.xs.clear();
  result.ys.clear();
  const auto keep = [&](std::size_t i) {
    result.xs.push_back(series.xs[i]);
    result.ys.push_back(series.ys[i]);
  };
  const auto column_of = [&](std::size_t i) {
    return std::floor((series.xs[i] - x_low) / (x_high - x_low) * static_cast<double>(columns));
  };
  const auto usable = [&](std::size_t i) { return std::isfinite(series.xs[i]) && std::isfinite(series.ys[i]); };
  for (std::size_t i = 0; i < size;) {
    if (!usable(i)) {
      ++i;
      continue;
    }
    const std::size_t first = i;
    std::size_t last = i, lowest = i, highest = i;
    for (; i < size && (!usable(i) || column_of(i) == column_of(first)); ++i) {
      if (!usable(i)) continue;
      last = i;
      if (series.ys[i] < series.ys[lowest]) lowest = i;
      if (series.ys[i] > series.ys[highest]) highest = i;
    }
    std::array<std::size_t, 4> kept{first, lowest, highest, last};
    std::sort(kept.begin(), kept.end());
    const auto end = std::unique(kept.begin(), kept.end());
    std::for_each(kept.begin(), end, keep);
  }
  return result;
}

std::string svg_of(const Sheet& sheet, int width_px, int height_px, const std::string& id_prefix) {
  const detail::QuietVtk quiet;
  vtkNew<vtkContextScene> scene;
  fill(scene, sheet, width_px, height_px, 1.0f);

  vtkNew<vtkGenericOpenGLRenderWindow> window;  // unused, but items need a renderer of their scene
  vtkNew<vtkRenderer> renderer;
  window->SetSize(width_px, height_px);
  window->AddRenderer(renderer);
  scene->SetRenderer(renderer);

  const detail::SvgElements elements = detail::svg_elements(*scene, height_px);
  const std::string size = std::to_string(width_px) + "\" height=\"" + std::to_string(height_px);
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + size + "\" viewBox=\"0 0 " + std::to_string(width_px) + " " +
         std::to_string(height_px) + "\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\">\n" +
         "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n" + "<g id=\"" + id_prefix +
         "shapes\" fill=\"none\" stroke-linejoin=\"round\">\n" + elements.shapes + "</g>\n" + elements.texts + "</svg>\n";
}

std::string svg_of(const Plot& plot, int width_px, int height_px, const std::string& id_prefix) {
  return svg_of(Sheet{.columns = 1, .panels = {plot}}, width_px, height_px, id_prefix);
}

Picture picture_of(const Sheet& sheet, int width_px, int height_px) {
  detail::QuietVtk quiet;
  // Supersampled twice: smooth lines on every driver. Other factors do not fit `halved`.
  constexpr int fine = 2;
  detail::OffscreenWindow window(fine * width_px, fine * height_px);
  vtkRenderer* renderer = window.white();
  vtkNew<vtkContextActor> actor;
  actor->GetScene()->SetRenderer(renderer);
  fill(actor->GetScene(), sheet, width_px, height_px, static_cast<float>(fine));
  renderer->AddActor(actor);
  return halved(window.draw());
}

Picture picture_of(const Plot& plot, int width_px, int height_px) {
  return picture_of(Sheet{.columns = 1, .panels = {plot}}, width_px, height_px);
}

}  // namespace palpa
