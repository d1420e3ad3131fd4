// Plot for curves that change 30 times a second.
#pragma once

#include <QColor>
#include <QPointF>
#include <QVector>
#include <QWidget>
#include <memory>

namespace palpa::explorer {

/// Curves over one x axis. Includes none of Qwt's headers, which are not C++20.
class LivePlot : public QWidget {
 public:
  /// \param name  for screen readers; the labels include units
  LivePlot(const QString& name, const QString& x_label, const QString& y_label, QWidget* parent = nullptr);
  ~LivePlot() override;

  /// Removes all curves.
  void clear();
  /// Adds a curve; returns its index. \param width  [pixels]
  int add_curve(const QString& name, const QColor& color, double width);
  void set_curve(int number, const QVector<QPointF>& points);
  void show_legend();
  void set_logarithmic();
  /// In the axes' own units.
  void set_x_range(double low, double high);
  void set_y_range(double low, double high);
  /// Shades a band of the x axis, in its own unit.
  void shade(double low, double high, const QColor& color);
  /// Draws a thin vertical line, in the x axis' own unit.
  void mark(double x, const QColor& color);
  void clear_marks();
  void draw();
  /// Value of the x axis at a pixel of the widget, in its own unit.
  double x_at(double px) const;

 private:
  void resizeEvent(QResizeEvent* event) override;
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpa::explorer
