// A plot whose curves change thirty times a second.
#pragma once

#include <QColor>
#include <QPointF>
#include <QVector>
#include <QWidget>
#include <memory>

namespace palpa::explorer {

/// Curves over one x axis. Qwt is behind it, whose headers are no C++20: this one includes none of them.
class LivePlot : public QWidget {
 public:
  /// \param name  for who cannot see it; the labels have their units
  LivePlot(const QString& name, const QString& x_label, const QString& y_label, QWidget* parent = nullptr);
  ~LivePlot() override;

  /// Takes all curves away.
  void clear();
  /// Adds a curve; returns its number. \param width  [pixels]
  int add_curve(const QString& name, const QColor& color, double width);
  void set_curve(int number, const QVector<QPointF>& points);
  void show_legend();
  void set_logarithmic();
  /// In the axes' own units.
  void set_x_range(double low, double high);
  void set_y_range(double low, double high);
  /// A shaded band of the x axis, in its own unit.
  void shade(double low, double high, const QColor& color);
  /// A thin upright line, in the x axis' own unit.
  void mark(double x, const QColor& color);
  void clear_marks();
  void draw();
  /// The x axis' value at a place of the widget, in its own unit.
  double x_at(double px) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpa::explorer
