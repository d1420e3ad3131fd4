#include "explorer/function_editor.h"

#include <QVTKOpenGLNativeWidget.h>
#include <vtkAxis.h>
#include <vtkBrush.h>
#include <vtkCallbackCommand.h>
#include <vtkChartXY.h>
#include <vtkColorTransferFunction.h>
#include <vtkCompositeControlPointsItem.h>
#include <vtkCompositeTransferFunctionItem.h>
#include <vtkContextScene.h>
#include <vtkContextView.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkPen.h>
#include <vtkPiecewiseControlPointsItem.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPiecewiseFunctionItem.h>
#include <vtkPlotBar.h>
#include <vtkRenderer.h>
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>

#include <QComboBox>
#include <QEvent>
#include <QGuiApplication>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QLabel>
#include <QMouseEvent>
#include <QPushButton>
#include <QTableWidget>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>

#include "palpa/view/canvas.h"
#include "palpa/view/colors.h"

namespace palpa::explorer {
namespace {

constexpr std::size_t bars = 128;       // of the drawn histogram
constexpr double snaps_within = 0.02;   // [1] of the range: a point released this near to a valley snaps to it
constexpr int settle_ms = 40;           // from a drag to the scene's update
constexpr double deepest_valley = 0.6;  // [1] of the lower of its two hills: shallower valleys are noise

QString number(double value) { return QString::number(value, 'g', 6); }

QString hex_of(const double rgb[3]) { return QColor::fromRgbF(rgb[0], rgb[1], rgb[2]).name(); }

}  // namespace

std::vector<double> valleys_of(const Histogram& histogram) {
  const Histogram coarse = histogram.in_classes(bars);
  std::vector<double> smooth(coarse.counts.size());
  for (std::size_t i = 0; i < smooth.size(); ++i) {
    double sum = 0.0, weights = 0.0;
    for (int k = -3; k <= 3; ++k) {
      const auto at = static_cast<std::ptrdiff_t>(i) + k;
      if (at < 0 || at >= static_cast<std::ptrdiff_t>(smooth.size())) continue;
      const double weight = 4.0 - std::abs(k);
      sum += weight * std::log1p(static_cast<double>(coarse.counts[static_cast<std::size_t>(at)]));
      weights += weight;
    }
    smooth[i] = sum / weights;
  }
  std::vector<double> valleys;
  for (std::size_t i = 1; i + 1 < smooth.size(); ++i) {
    if (!(smooth[i] < smooth[i - 1] && smooth[i] <= smooth[i + 1])) continue;
    const double before = *std::max_element(smooth.begin(), smooth.begin() + static_cast<std::ptrdiff_t>(i));
    const double after = *std::max_element(smooth.begin() + static_cast<std::ptrdiff_t>(i), smooth.end());
    // Counts are logarithmic.
    if (smooth[i] < std::min(before, after) + std::log(deepest_valley))
      valleys.push_back(0.5 * (coarse.edge(i) + coarse.edge(i + 1)));
  }
  return valleys;
}

/// Chart with VTK's control points.
struct FunctionEditor::Chart {
  Chart() {
    window->SetMultiSamples(0);
    widget->setRenderWindow(window);
    view->SetRenderWindow(window);
    view->SetInteractor(widget->interactor());
    view->GetScene()->AddItem(chart);
    chart->SetShowLegend(false);
    chart->SetTooltip(nullptr);  // its values are shares of the largest result, the axis is in newtons
    chart->SetForceAxesToBounds(true);
    chart->GetAxis(vtkAxis::BOTTOM)->SetTitle("");
    for (const int axis : {vtkAxis::LEFT, vtkAxis::BOTTOM}) {
      chart->GetAxis(axis)->SetBehavior(vtkAxis::FIXED);
      chart->GetAxis(axis)->GetTitleProperties()->SetBold(false);
    }
    for (vtkPiecewiseFunction* function : {strength.Get(), opacity.Get()}) function->AllowDuplicateScalarsOn();
    colors->AllowDuplicateScalarsOn();
    widget->setMinimumSize(260, 180);
    widget->setAccessibleName(FunctionEditor::tr("Function over the histogram"));
    widget->setObjectName("function_chart");
  }
  void set_points(const Shown& shown);
  void show_plots(const Shown& shown, bool lists_strength);
  void scale_axes(const Shown& shown);

  QVTKOpenGLNativeWidget* widget = new QVTKOpenGLNativeWidget;
  vtkNew<vtkGenericOpenGLRenderWindow> window;
  vtkNew<vtkContextView> view;
  vtkNew<vtkChartXY> chart;
  vtkNew<vtkTable> table;
  vtkNew<vtkPiecewiseFunction> strength, opacity;
  vtkNew<vtkColorTransferFunction> colors;
  vtkSmartPointer<vtkPiecewiseControlPointsItem> strength_item;
  vtkSmartPointer<vtkCompositeControlPointsItem> colors_item;
  vtkSmartPointer<vtkPiecewiseFunctionItem> strength_line;
  vtkSmartPointer<vtkCompositeTransferFunctionItem> colors_fill;
  vtkPlot* histogram = nullptr;
};

FunctionEditor::FunctionEditor(bool has_opengl, QWidget* parent)
    : QWidget(parent), title_(new QLabel), table_(new QTableWidget), listed_(new QComboBox) {
  auto* all = new QVBoxLayout(this);
  all->setContentsMargins(4, 4, 4, 4);
  auto* hint = new QLabel(tr("drag points · click adds one · Delete takes one away · double click sets a level"));
  hint->setToolTip(tr("A point that is let go near a valley of the histogram snaps to it, but not with Shift."));
  hint->setEnabled(false);
  for (QLabel* label : {title_, hint})
    label->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);  // cut in a narrow window
  hint->setAlignment(Qt::AlignRight);
  auto* head = new QHBoxLayout;
  head->addWidget(title_, 2);
  head->addWidget(hint, 3);
  all->addLayout(head);
  auto* row = new QHBoxLayout;
  if (has_opengl) {
    chart_ = std::make_unique<Chart>();
    Chart& c = *chart_;
    vtkNew<vtkCallbackCommand> observer;
    observer->SetClientData(this);
    observer->SetCallback([](vtkObject*, unsigned long, void* self, void*) {
      auto* editor = static_cast<FunctionEditor*>(self);
      if (!editor->is_filling_) editor->settle_.start();
    });
    for (vtkObject* object : {static_cast<vtkObject*>(c.strength.Get()), static_cast<vtkObject*>(c.opacity.Get()),
                              static_cast<vtkObject*>(c.colors.Get())})
      object->AddObserver(vtkCommand::ModifiedEvent, observer);
    c.widget->installEventFilter(this);
    row->addWidget(c.widget, 3);
  }
  table_->setObjectName("function_table");
  table_->setAccessibleName(tr("Points of the function"));
  table_->horizontalHeader()->setSectionResizeMode(QHeaderView::Stretch);
  table_->verticalHeader()->hide();
  table_->setMinimumWidth(220);
  connect(table_, &QTableWidget::cellChanged, this, &FunctionEditor::typed);
  listed_->addItems({tr("Points of the felt curve"), tr("Points of the drawn curve")});
  listed_->setObjectName("function_listed");
  listed_->setAccessibleName(tr("Curve of the points in the table"));
  listed_->hide();
  connect(listed_, qOverload<int>(&QComboBox::activated), this, [this] { show_functions(Shown(shown_)); });
  auto* points = new QVBoxLayout;
  points->addWidget(listed_);
  points->addWidget(table_);
  row->addLayout(points, 2);
  all->addLayout(row, 1);
  color_chart();
  settle_.setSingleShot(true);
  settle_.setInterval(settle_ms);
  connect(&settle_, &QTimer::timeout, this, &FunctionEditor::chart_changed);
}

FunctionEditor::~FunctionEditor() {
  is_filling_ = true;  // ignore the chart's last events
}

void FunctionEditor::color_chart() {
  if (!chart_) return;
  const QColor ground = palette().color(QPalette::Base), ink = palette().color(QPalette::Text);
  chart_->view->GetRenderer()->SetBackground(ground.redF(), ground.greenF(), ground.blueF());
  for (const int axis : {vtkAxis::LEFT, vtkAxis::BOTTOM}) {
    vtkAxis& one = *chart_->chart->GetAxis(axis);
    one.GetPen()->SetColor(static_cast<unsigned char>(ink.red()), static_cast<unsigned char>(ink.green()),
                           static_cast<unsigned char>(ink.blue()));
    for (vtkTextProperty* text : {one.GetLabelProperties(), one.GetTitleProperties()})
      text->SetColor(ink.redF(), ink.greenF(), ink.blueF());
  }
  if (chart_->widget->isVisible()) chart_->window->Render();
}

void FunctionEditor::changeEvent(QEvent* event) {
  QWidget::changeEvent(event);
  if (event->type() == QEvent::PaletteChange) color_chart();
}

void FunctionEditor::Chart::set_points(const Shown& shown) {
  strength->RemoveAllPoints();
  opacity->RemoveAllPoints();
  colors->RemoveAllPoints();
  if (shown.strength)
    for (const TransferFunction::Point& point : shown.strength->points())
      strength->AddPoint(point.value, point.result / shown.largest);
  if (shown.colors) {
    for (const ViewLayer::ColorPoint& point : *shown.colors) {
      const detail::Color color = detail::color_of(point.color);
      colors->AddRGBPoint(point.value, color.red, color.green, color.blue);
      opacity->AddPoint(point.value, point.opacity);
    }
  }
}

void FunctionEditor::Chart::show_plots(const Shown& shown, bool lists_strength) {
  const auto keep = [&](auto& item, bool wanted, auto make) {
    if (item && !wanted) {
      chart->RemovePlotInstance(item);
      item = nullptr;
    } else if (!item && wanted) {
      item = make();
      chart->AddPlot(item);
    }
    if (item) item->SetUserBounds(shown.low, shown.high, 0.0, 1.0);
  };
  keep(colors_fill, shown.colors.has_value(), [&] {
    auto item = vtkSmartPointer<vtkCompositeTransferFunctionItem>::New();
    item->SetColorTransferFunction(colors);
    item->SetOpacityFunction(opacity);
    item->SetMaskAboveCurve(true);
    item->SetOpacity(0.75);
    return item;
  });
  keep(strength_line, shown.strength.has_value(), [&] {
    auto item = vtkSmartPointer<vtkPiecewiseFunctionItem>::New();
    item->SetPiecewiseFunction(strength);
    item->SetColor(0.84, 0.37, 0.0);
    item->SetMaskAboveCurve(true);
    item->SetOpacity(0.35);
    return item;
  });
  // Only the function listed in the table has points and mouse events.
  keep(strength_item, lists_strength, [&] {
    auto item = vtkSmartPointer<vtkPiecewiseControlPointsItem>::New();
    item->SetPiecewiseFunction(strength);
    item->GetPen()->SetColorF(0.84, 0.37, 0.0);
    item->GetPen()->SetWidth(2.5);
    item->GetBrush()->SetColorF(0.84, 0.37, 0.0);
    return item;
  });
  keep(colors_item, !lists_strength, [&] {
    auto item = vtkSmartPointer<vtkCompositeControlPointsItem>::New();
    item->SetColorTransferFunction(colors);
    item->SetOpacityFunction(opacity);
    item->SetPointsFunction(vtkCompositeControlPointsItem::ColorAndOpacityPointsFunction);
    return item;
  });
}

void FunctionEditor::Chart::scale_axes(const Shown& shown) {
  const double margin = 0.02 * (shown.high - shown.low);
  chart->GetAxis(vtkAxis::BOTTOM)->SetRange(shown.low - margin, shown.high + margin);
  chart->GetAxis(vtkAxis::BOTTOM)->SetTitle(shown.field + (shown.unit.empty() ? "" : " / " + shown.unit));
  chart->GetAxis(vtkAxis::LEFT)->SetRange(-0.03, 1.05);
  chart->GetAxis(vtkAxis::LEFT)
      ->SetTitle(shown.strength ? (shown.result_unit.isEmpty() ? "share" : "strength / " + shown.result_unit.toStdString())
                                : "opacity");
  vtkNew<vtkDoubleArray> places;
  vtkNew<vtkStringArray> words;
  for (int i = 0; i <= 4; ++i) {
    places->InsertNextValue(0.25 * i);
    words->InsertNextValue(detail::number_words(0.25 * i * (shown.strength ? shown.largest : 1.0)));
  }
  chart->GetAxis(vtkAxis::LEFT)->SetCustomTickPositions(places, words);
}

void FunctionEditor::show_functions(const Shown& shown) {
  if (settle_.isActive()) return;  // the user is dragging
  const bool other_field = shown.field != shown_.field || shown.low != shown_.low || shown.high != shown_.high;
  is_filling_ = true;
  shown_ = shown;
  title_->setText("<b>" + shown.title.toHtmlEscaped() + "</b>");
  listed_->setVisible(shown.strength && shown.colors);
  if (other_field) valleys_.clear();
  if (chart_) {
    Chart& c = *chart_;
    if (other_field && c.histogram) {
      c.chart->RemovePlotInstance(c.histogram);
      c.histogram = nullptr;
    }
    c.set_points(shown);
    c.show_plots(shown, lists_strength());
    c.scale_axes(shown);
    c.window->Render();
    c.widget->update();
  }
  fill_table();
  is_filling_ = false;
}

void FunctionEditor::show_histogram(const Histogram& histogram) {
  valleys_ = valleys_of(histogram);
  if (!chart_) return;
  Chart& c = *chart_;
  const Histogram coarse = histogram.in_classes(bars);
  double most = 1.0;
  for (const std::int64_t count : coarse.counts) most = std::max(most, std::log1p(static_cast<double>(count)));
  vtkNew<vtkFloatArray> values, counts;
  values->SetName("value");
  counts->SetName("count");
  for (std::size_t i = 0; i < coarse.counts.size(); ++i) {
    values->InsertNextValue(static_cast<float>(0.5 * (coarse.edge(i) + coarse.edge(i + 1))));
    counts->InsertNextValue(static_cast<float>(0.95 * std::log1p(static_cast<double>(coarse.counts[i])) / most));
  }
  c.table->Initialize();
  c.table->AddColumn(values);
  c.table->AddColumn(counts);
  if (c.histogram) c.chart->RemovePlotInstance(c.histogram);
  c.histogram = c.chart->AddPlot(vtkChart::BAR);
  c.histogram->SetInputData(c.table, 0, 1);
  c.histogram->SetColor(190, 196, 205, 255);
  c.histogram->GetPen()->SetColor(190, 196, 205, 255);
  // Behind the other plots.
  c.chart->LowerPlot(c.histogram);
  c.window->Render();
  c.widget->update();
}

std::optional<QPoint> FunctionEditor::place_of(double value, double share) const {
  if (!chart_) return {};
  const auto along = [](vtkAxis* axis, int component, double at) {
    const double from = axis->GetPoint1()[component], to = axis->GetPoint2()[component];
    return from + (at - axis->GetMinimum()) / (axis->GetMaximum() - axis->GetMinimum()) * (to - from);
  };
  const double ratio = chart_->widget->devicePixelRatioF();
  const double x = along(chart_->chart->GetAxis(vtkAxis::BOTTOM), 0, value) / ratio;
  const double y = along(chart_->chart->GetAxis(vtkAxis::LEFT), 1, share) / ratio;
  return QPoint(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(chart_->widget->height() - y)));
}

double FunctionEditor::snapped(double value) const {
  for (const double valley : valleys_)
    if (std::abs(valley - value) <= snaps_within * (shown_.high - shown_.low)) return valley;
  return value;
}

void FunctionEditor::chart_changed() {
  Chart& c = *chart_;
  const bool held = QGuiApplication::mouseButtons() != Qt::NoButton;
  const bool snaps = !held && !(QGuiApplication::keyboardModifiers() & Qt::ShiftModifier);
  if (shown_.strength) {
    std::vector<TransferFunction::Point> points;
    for (int i = 0; i < c.strength->GetSize(); ++i) {
      double node[4];
      c.strength->GetNodeValue(i, node);
      const auto& before = shown_.strength->points();
      // Only a moved point snaps.
      const bool moved =
          std::none_of(before.begin(), before.end(), [&](const TransferFunction::Point& p) { return p.value == node[0]; });
      points.push_back({snaps && moved ? snapped(node[0]) : node[0], std::max(0.0, node[1] * shown_.largest)});
    }
    std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
    if (!points.empty() && points != shown_.strength->points()) {
      TransferFunction made(points, shown_.strength->outside());
      shown_.strength = made;
      Q_EMIT strength_changed(made);
    }
  }
  if (shown_.colors) {
    std::vector<ViewLayer::ColorPoint> points;
    for (int i = 0; i < c.opacity->GetSize(); ++i) {
      double node[4], rgb[3];
      c.opacity->GetNodeValue(i, node);
      c.colors->GetColor(node[0], rgb);
      points.push_back({snaps ? snapped(node[0]) : node[0], hex_of(rgb).toStdString(), std::clamp(node[1], 0.0, 1.0)});
    }
    if (!points.empty() && points != *shown_.colors) {
      shown_.colors = points;
      Q_EMIT colors_changed(points);
    }
  }
  is_filling_ = true;
  fill_table();
  is_filling_ = false;
}

bool FunctionEditor::lists_strength() const { return shown_.strength && (!shown_.colors || listed_->currentIndex() == 0); }

void FunctionEditor::fill_table() {
  const bool felt = lists_strength();
  table_->setColumnCount(felt ? 2 : 3);
  const QString value = shown_.unit.empty() ? tr("value") : tr("value / %1").arg(QString::fromStdString(shown_.unit));
  table_->setHorizontalHeaderLabels(
      felt ? QStringList{value, shown_.result_unit.isEmpty() ? tr("share") : tr("strength / %1").arg(shown_.result_unit)}
           : QStringList{value, tr("colour"), tr("opacity")});
  const std::size_t rows = felt ? shown_.strength->points().size() : shown_.colors ? shown_.colors->size() : 0;
  table_->setRowCount(static_cast<int>(rows));
  for (std::size_t i = 0; i < rows; ++i) {
    const auto set = [&](int column, const QString& words) {
      table_->setItem(static_cast<int>(i), column, new QTableWidgetItem(words));
    };
    if (felt) {
      set(0, number(shown_.strength->points()[i].value));
      set(1, number(shown_.strength->points()[i].result));
    } else {
      const ViewLayer::ColorPoint& point = (*shown_.colors)[i];
      set(0, number(point.value));
      set(1, QString::fromStdString(point.color));
      set(2, number(point.opacity));
      table_->item(static_cast<int>(i), 1)->setBackground(QColor(QString::fromStdString(point.color)));
    }
  }
}

void FunctionEditor::typed(int row, int column) {
  if (is_filling_) return;
  const QString words = table_->item(row, column)->text();
  bool is_number = false;
  const double given = words.toDouble(&is_number);
  const auto at = static_cast<std::size_t>(row);
  if (lists_strength()) {
    std::vector<TransferFunction::Point> points = shown_.strength->points();
    if (is_number && std::isfinite(given)) (column == 0 ? points[at].value : points[at].result) = given;
    std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
    shown_.strength = TransferFunction(points, shown_.strength->outside());
    Q_EMIT strength_changed(*shown_.strength);
  } else if (shown_.colors) {
    ViewLayer::ColorPoint& point = (*shown_.colors)[at];
    if (column == 1 && QColor(words).isValid()) point.color = QColor(words).name().toStdString();
    if (column == 0 && is_number) point.value = given;
    if (column == 2 && is_number) point.opacity = std::clamp(given, 0.0, 1.0);
    std::stable_sort(shown_.colors->begin(), shown_.colors->end(),
                     [](const auto& a, const auto& b) { return a.value < b.value; });
    Q_EMIT colors_changed(*shown_.colors);
  }
  show_functions(Shown(shown_));
}

bool FunctionEditor::eventFilter(QObject* watched, QEvent* event) {
  if (chart_ && watched == chart_->widget) {
    // VTK redraws its changes only on request.
    if (event->type() == QEvent::MouseMove || event->type() == QEvent::MouseButtonRelease || event->type() == QEvent::KeyPress)
      QTimer::singleShot(0, this, [this] {
        chart_->window->Render();
        chart_->widget->update();
      });
    if (event->type() == QEvent::MouseButtonRelease) settle_.start();
    if (event->type() == QEvent::MouseButtonDblClick) {
      const auto* mouse = static_cast<QMouseEvent*>(event);
      vtkAxis* const axis = chart_->chart->GetAxis(vtkAxis::BOTTOM);
      const double left = axis->GetPoint1()[0], right = axis->GetPoint2()[0];
      if (right > left) {
        const double px = mouse->localPos().x() * chart_->widget->devicePixelRatioF();
        const double value = axis->GetMinimum() + (px - left) / (right - left) * (axis->GetMaximum() - axis->GetMinimum());
        Q_EMIT value_chosen(snapped(value));
        return true;
      }
    }
  }
  return QWidget::eventFilter(watched, event);
}

}  // namespace palpa::explorer
