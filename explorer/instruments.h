// Live plots: force over the last seconds, by mode, its spectrum, and the timing of the loop.
#pragma once

#include <QLabel>
#include <QWidget>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "explorer/live_plot.h"
#include "explorer/sample_ring.h"
#include "palpa/loop/loop.h"
#include "palpa/study/summary.h"

namespace palpa::explorer {

class Instruments : public QWidget {
  Q_OBJECT
 public:
  explicit Instruments(QWidget* parent = nullptr);

  /// Empties the curves. \param hand  of the scene, whose ticks are drawn
  void start(const std::vector<std::string>& modes, std::size_t hand = 0);
  /// Sets whether the torque has a curve, where there is room; the spectrum gives way.
  void show_torque(bool shown);
  /// Modes of the curves.
  const std::vector<std::string>& modes() const { return modes_; }
  /// Draws the pending samples of the loop.
  void update_from(SampleRing& ring);
  /// \param has_tool  says the torque, too
  void show_statistics(const LoopStatistics& statistics, const TickFrame& frame, bool has_tool, const char* device_fault);
  /// One tick in a plot.
  struct Shown {
    double t_s = 0.0;
    Vec3 probe_m, proxy_m, command_n, command_nm;
    std::array<float, most_shown_modes> mode_n{};
    double error_bound_m = 0.0;
  };
  const std::deque<Shown>& shown() const { return shown_; }
  /// Summary of all ticks since the start.
  Summary summary() const { return summary_->finish(0.0); }
  /// Time span of the force plot.
  static constexpr double shown_s = 6.0;
  QSize sizeHint() const override { return {900, 190}; }

 protected:
  void resizeEvent(QResizeEvent* event) override;

 private:
  /// Column of the labels.
  QWidget* make_words();
  /// One curve for each of `count` values of a tick; the largest value of any, at least `least`.
  template <class Value>
  std::vector<QVector<QPointF>> curves_of(std::size_t count, double& most, const Value& value) const;
  void draw_force();
  void draw_torque();
  void draw_spectrum();

  LivePlot* force_;
  LivePlot* torque_;
  LivePlot* spectrum_;
  std::vector<std::string> modes_;
  std::size_t curves_ = 0;  // of the force: total, then each mode
  QLabel* times_;
  QLabel* guard_;
  QLabel* energies_;
  std::deque<Shown> shown_;
  std::unique_ptr<SummaryBuilder> summary_;
  int drawn_ = 0;
  std::size_t hand_ = 0;
  bool has_torque_ = false;
};

}  // namespace palpa::explorer
