// Editor for functions of a field's values, over its histogram: strength, and colour with opacity.
#pragma once

#include <QTimer>
#include <QWidget>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "palpa/data/statistics.h"
#include "palpa/mode/parameters.h"
#include "palpa/scene/scene.h"

class QComboBox;
class QLabel;
class QTableWidget;

namespace palpa::explorer {

/// Values at the histogram's valleys: boundaries between materials.
std::vector<double> valleys_of(const Histogram& histogram);

/// Control points, dragged on the histogram, typed into the table, snapped to valleys. Independent of scenes: reports each
/// change by a signal.
class FunctionEditor : public QWidget {
  Q_OBJECT
 public:
  /// \param has_opengl  false: table only
  explicit FunctionEditor(bool has_opengl, QWidget* parent = nullptr);
  ~FunctionEditor() override;

  struct Shown {
    QString title;                             ///< "strength of bone"
    std::string field;                         ///< name in the scene
    std::string unit;                          ///< of the field
    double low = 0.0, high = 1.0;              ///< of its values
    std::optional<TransferFunction> strength;  ///< results in `result_unit`
    std::optional<std::vector<ViewLayer::ColorPoint>> colors;
    double largest = 1.0;  ///< of the results
    QString result_unit;   ///< "N"
  };
  void show_functions(const Shown& shown);
  void show_histogram(const Histogram& histogram);
  const Shown& shown() const { return shown_; }
  /// Position of a point in the chart; none: no chart. \param share  [1] of the largest result, or opacity
  std::optional<QPoint> place_of(double value, double share) const;

 Q_SIGNALS:
  void strength_changed(const palpa::TransferFunction& strength);
  void colors_changed(const std::vector<palpa::ViewLayer::ColorPoint>& colors);
  /// A value was picked in the chart, for a level or a mask.
  void value_chosen(double value);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;
  void changeEvent(QEvent* event) override;

 private:
  void color_chart();
  struct Chart;
  void fill_table();
  bool lists_strength() const;
  void chart_changed();
  void typed(int row, int column);
  double snapped(double value) const;

  Shown shown_;
  std::vector<double> valleys_;
  std::unique_ptr<Chart> chart_;
  QLabel* title_;
  QTableWidget* table_;
  QComboBox* listed_;  ///< function listed in the table, if both are shown
  QTimer settle_;
  bool is_filling_ = false;
};

}  // namespace palpa::explorer
