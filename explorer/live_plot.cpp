#include "explorer/live_plot.h"

#include <qwt_legend.h>
#include <qwt_plot.h>
#include <qwt_plot_curve.h>
#include <qwt_plot_grid.h>
#include <qwt_plot_marker.h>
#include <qwt_plot_zoneitem.h>
#include <qwt_scale_engine.h>
#include <qwt_scale_map.h>
#include <qwt_text.h>

#include <QVBoxLayout>
#include <algorithm>
#include <vector>

namespace palpa::explorer {

struct LivePlot::Parts {
  QwtPlot* plot = nullptr;
  std::vector<QwtPlotCurve*> curves;
  std::vector<QwtPlotMarker*> marks;
};

LivePlot::LivePlot(const QString& name, const QString& x_label, const QString& y_label, QWidget* parent)
    : QWidget(parent), parts_(std::make_unique<Parts>()) {
  auto* plot = parts_->plot = new QwtPlot;
  const auto label = [&](int axis, const QString& words) {
    QFont font = plot->font();
    font.setPointSizeF(0.85 * font.pointSizeF());
    QwtText text(words);
    text.setFont(font);
    plot->setAxisTitle(axis, text);
    plot->setAxisFont(axis, font);
  };
  label(QwtPlot::xBottom, x_label);
  label(QwtPlot::yLeft, y_label);
  plot->setAutoFillBackground(false);
  auto* grid = new QwtPlotGrid;
  grid->setPen(QPen(QColor(128, 128, 128, 60), 1));
  grid->attach(plot);
  auto* all = new QVBoxLayout(this);
  all->setContentsMargins(0, 0, 0, 0);
  all->addWidget(plot);
  setAccessibleName(name);
  setMinimumSize(180, 120);
}

LivePlot::~LivePlot() = default;

void LivePlot::clear() {
  for (QwtPlotCurve* curve : parts_->curves) delete curve;
  parts_->curves.clear();
  clear_marks();
}

int LivePlot::add_curve(const QString& name, const QColor& color, double width) {
  auto* curve = new QwtPlotCurve(name);
  curve->setPen(QPen(color, width));
  curve->setLegendAttribute(QwtPlotCurve::LegendShowLine);
  curve->setZ(30.0 - static_cast<double>(parts_->curves.size()));
  curve->attach(parts_->plot);
  parts_->curves.push_back(curve);
  return static_cast<int>(parts_->curves.size()) - 1;
}

void LivePlot::set_curve(int number, const QVector<QPointF>& points) {
  parts_->curves[static_cast<std::size_t>(number)]->setSamples(points);
}

void LivePlot::show_legend() { parts_->plot->insertLegend(new QwtLegend, QwtPlot::RightLegend); }

void LivePlot::set_logarithmic() {
  parts_->plot->setAxisScaleEngine(QwtPlot::xBottom, new QwtLogScaleEngine);
  parts_->plot->setAxisScaleEngine(QwtPlot::yLeft, new QwtLogScaleEngine);
}

void LivePlot::set_x_range(double low, double high) { parts_->plot->setAxisScale(QwtPlot::xBottom, low, high); }
void LivePlot::set_y_range(double low, double high) { parts_->plot->setAxisScale(QwtPlot::yLeft, low, high); }

void LivePlot::shade(double low, double high, const QColor& color) {
  auto* band = new QwtPlotZoneItem;
  band->setOrientation(Qt::Vertical);
  band->setInterval(low, high);
  band->setBrush(color);
  band->setPen(QPen(Qt::NoPen));
  band->attach(parts_->plot);
}

void LivePlot::mark(double x, const QColor& color) {
  auto* mark = new QwtPlotMarker;
  mark->setLineStyle(QwtPlotMarker::VLine);
  mark->setLinePen(QPen(color, 1.0));
  mark->setXValue(x);
  mark->attach(parts_->plot);
  parts_->marks.push_back(mark);
}

void LivePlot::clear_marks() {
  for (QwtPlotMarker* mark : parts_->marks) delete mark;
  parts_->marks.clear();
}

void LivePlot::resizeEvent(QResizeEvent* event) {
  QWidget::resizeEvent(event);
  // As many numbers as have room above each other: Qwt makes eight at any height.
  const int rows = height() / (2 * fontMetrics().height()) - 1;  // one is the axis below
  parts_->plot->setAxisMaxMajor(QwtPlot::yLeft, std::clamp(rows, 1, 8));
}

void LivePlot::draw() { parts_->plot->replot(); }

double LivePlot::x_at(double px) const {
  const QPoint on_canvas = parts_->plot->canvas()->mapFrom(this, QPoint(static_cast<int>(px), 0));
  return parts_->plot->invTransform(QwtPlot::xBottom, on_canvas.x());
}

}  // namespace palpa::explorer
