// A trace in the window: felt again once, then shown at any moment.
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

class QLabel;
class QToolButton;

namespace palpa::explorer {

/// A hand's whole way through a scene.
struct FeltTrace {
  struct Row {
    std::int64_t tick = 0;
    double t_s = 0.0;
    Vec3 probe_m, proxy_m, command_n;
    std::size_t first_primitive = 0, primitives = 0;  ///< of `placed`
  };
  struct Event {
    std::size_t row = 0;
    std::string kind, subject;
  };
  std::string name;
  std::vector<Row> rows;  ///< one a tick, or fewer of a long trace
  std::vector<PlacedPrimitive> placed;
  std::vector<Event> events;
  double duration_s = 0.0;

  Moment moment(std::size_t row) const;
};

/// A hand that can be felt again.
struct PlayedHand {
  std::filesystem::path trace;  ///< a recorded session's, or …
  std::string description;      ///< … a simulated or recorded hand, as of `palpa run --hand`
};
/// Feels the hand in a scene: that which it was recorded in, or another one (what if?). Any thread. Throws LoadError, also
/// when it is asked to stop.
FeltTrace feel_again(const PlayedHand& hand, const LoadedScene& loaded, std::stop_token stop = {});

/// Time bar, force over time, events.
class Player : public QWidget {
  Q_OBJECT
 public:
  explicit Player(QWidget* parent = nullptr);
  /// \param first  its curve is drawn first; a second one is compared with it
  void show_trace(std::shared_ptr<const FeltTrace> first, std::shared_ptr<const FeltTrace> second = {});
  bool has_trace() const { return first_ != nullptr; }
  /// Time has passed for the window [s].
  void pass(double dt_s);
  void play(bool on);
  void step_to_event(int direction);
  void seek(double t_s);
  double at_s() const { return at_s_; }
  /// Of the longer of the two [s].
  double duration_s() const { return duration_s_; }
  Moment moment() const;
  std::optional<Moment> other_moment() const;
  /// Places of the proxy for a trail that ends now.
  std::vector<std::size_t> trail(std::size_t most) const;
  const FeltTrace* trace() const { return first_.get(); }
  const FeltTrace* other_trace() const { return second_.get(); }
  QSize sizeHint() const override { return {900, 150}; }

 Q_SIGNALS:
  void moved();

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  static std::size_t row_at(const FeltTrace& trace, double t_s);
  void show_time();

  std::shared_ptr<const FeltTrace> first_, second_;
  LivePlot* plot_;
  QSlider* bar_;
  QToolButton* play_;
  QLabel* words_;
  double duration_s_ = 0.0;  ///< of the longer one
  double at_s_ = 0.0;
  bool plays_ = false;
};

}  // namespace palpa::explorer
