// Time of data that change with time.
#pragma once

#include <QWidget>
#include <functional>

#include "palpa/scene/scene.h"

class QLabel;
class QSlider;
class QToolButton;

namespace palpa::explorer {

/// Slider over the data's time, which holds them at a moment, and a play button. Hidden if no field changes with time.
class TimeBar : public QWidget {
  Q_OBJECT
 public:
  /// \param elapsed_s  [s] since the session began, now
  explicit TimeBar(std::function<double()> elapsed_s, QWidget* parent = nullptr);
  /// Adapts to the scene's fields and to its time.
  void show_scene(const Scene& scene);
  /// Shows the time of playing data.
  void follow();
  bool plays() const { return length_s_ > 0.0 && time_.play != TimeOptions::Play::hold; }
  /// Time that is shown [s], from 0 to the length of the data.
  double at_s() const { return at_s_; }

 Q_SIGNALS:
  /// Progress of the data's time that the user sets: held at a moment, or in a loop.
  void asked(const palpa::TimeOptions& time);

 private:
  void play(bool on);
  void hold_at(int step);
  void show_time();

  QSlider* slider_;
  QToolButton* play_;
  QLabel* words_;
  TimeOptions time_;
  double length_s_ = 0.0, frame_s_ = 1.0;  ///< of the longest loop, and from frame to frame
  std::function<double()> elapsed_s_;
  double at_s_ = 0.0;
};

}  // namespace palpa::explorer
