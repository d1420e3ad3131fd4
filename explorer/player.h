// Player of a trace: replayed once, then shown at any moment.
#pragma once

#include <QSlider>
#include <QWidget>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "explorer/live_plot.h"
#include "explorer/sample_ring.h"
#include "palpa/scene/load_scene.h"
#include "palpa/study/felt.h"

class QLabel;
class QToolButton;

namespace palpa::explorer {

/// Replayed session of a hand.
struct FeltTrace {
  struct Row {
    std::int64_t tick = 0;
    double t_s = 0.0;
    Vec3 probe_m, proxy_m, command_n;
    std::size_t first_primitive = 0, primitives = 0;  ///< range of `placed`
    bool has_tool = false;
    Turn probe_turn{}, proxy_turn{};
    Vec3 torque_nm{};  ///< sent to the device
  };
  struct Event {
    std::size_t row = 0;
    std::string kind, subject;
  };
  std::string name;
  std::vector<Row> rows;  ///< one per tick, or fewer for a long trace
  std::vector<PlacedPrimitive> placed;
  std::vector<Event> events;
  FeltRun run;  ///< all ticks, without modes: for comparison
  /// Input of a tick. Kept of a hand that no trace has.
  struct HandTick {
    std::int64_t tick = 0;
    double t_s = 0.0, dt_s = 0.0;
    Probe probe;
  };
  std::vector<HandTick> hand;
  double encoder_step_m = 0.0, max_force_n = 0.0, max_torque_nm = 0.0;  ///< of that hand's device
  double duration_s = 0.0;

  Moment moment(std::size_t row) const;
};

/// A hand that can be replayed.
struct PlayedHand {
  std::filesystem::path trace;               ///< of a recorded session, or …
  std::string description;                   ///< … a simulated or recorded hand, as for `palpa run --hand`, or …
  std::shared_ptr<const FeltTrace> again{};  ///< … the inputs of its replay; null: none
  std::size_t number = 0;                    ///< of the hand of the scene
};
/// Replays the hand in its own or another scene; its positions are in the window's hand frame. Any thread. Throws LoadError,
/// also when stopped.
FeltTrace feel_again(const PlayedHand& hand, const LoadedScene& loaded, std::stop_token stop = {});

/// Time bar, force over time, of a tool also torque, events, summary of a comparison.
class Player : public QWidget {
  Q_OBJECT
 public:
  explicit Player(QWidget* parent = nullptr);
  /// \param first   drawn first; `second` is compared with it
  /// \param others  of the scene's other hands, in its order
  void show_trace(std::shared_ptr<const FeltTrace> first, std::shared_ptr<const FeltTrace> second = {},
                  std::vector<std::shared_ptr<const FeltTrace>> others = {});
  bool has_trace() const { return first_ != nullptr; }
  /// Advances the clock by `dt_s` [s].
  void pass(double dt_s);
  void play(bool on);
  /// Goes to the next (1) or previous (-1) event of any kind, or the largest difference; says which, or which there are.
  void step_to_event(int direction);
  void seek(double t_s);
  double at_s() const { return at_s_; }
  /// Duration of the longer trace [s].
  double duration_s() const { return duration_s_; }
  Moment moment() const;
  std::optional<Moment> other_moment() const;
  /// Of the scene's other hands, in their order; empty without their traces.
  std::vector<Moment> hands() const;
  /// Row indices for a trail that ends at the current moment.
  std::vector<std::size_t> trail(std::size_t most) const;
  const FeltTrace* trace() const { return first_.get(); }
  const FeltTrace* other_trace() const { return second_.get(); }
  QSize sizeHint() const override { return {900, 150}; }

 Q_SIGNALS:
  void moved();
  void said(const QString& words, bool is_problem);

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  LivePlot* new_plot(const QString& name, const QString& unit);
  static std::size_t row_at(const FeltTrace& trace, double t_s);
  void show_time();
  /// Says how the second trace's force differs from the first's.
  void compare();

  std::shared_ptr<const FeltTrace> first_, second_;
  std::vector<std::shared_ptr<const FeltTrace>> others_;
  LivePlot *force_, *torque_;
  QSlider* bar_;
  QToolButton* play_;
  QLabel* words_;
  QLabel* difference_;          ///< of two traces
  QToolButton* to_difference_;  ///< to the largest
  std::optional<double> largest_difference_s_;
  double duration_s_ = 0.0;  ///< of the longer trace
  double at_s_ = 0.0;
  bool plays_ = false;
};

}  // namespace palpa::explorer
