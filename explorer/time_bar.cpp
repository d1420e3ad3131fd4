#include "explorer/time_bar.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QSignalBlocker>
#include <QSlider>
#include <QStyle>
#include <QToolButton>
#include <algorithm>
#include <cmath>
#include <utility>

#include "palpa/data/octave_parts.h"

namespace palpa::explorer {
namespace {

constexpr int least_steps = 200;  // [1] of the slider. Fewer: a drag between two poses is coarse
constexpr int most_steps = 100'000;

}  // namespace

TimeBar::TimeBar(std::function<double()> elapsed_s, QWidget* parent)
    : QWidget(parent),
      slider_(new QSlider(Qt::Horizontal)),
      play_(new QToolButton),
      words_(new QLabel),
      elapsed_s_(std::move(elapsed_s)) {
  slider_->setObjectName("data_time");
  slider_->setAccessibleName(tr("Time of the data"));
  slider_->setToolTip(tr("Hold the data at a moment; arrow keys: frame by frame"));
  play_->setObjectName("play");
  play_->setCheckable(true);
  play_->setAutoRaise(true);
  play_->setAccessibleName(tr("Play the data"));
  play_->setToolTip(tr("Play the data in a loop, or hold them"));
  words_->setObjectName("data_time_words");
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(4, 2, 4, 2);
  row->addWidget(play_);
  row->addWidget(slider_, 1);
  row->addWidget(words_);
  connect(slider_, &QSlider::valueChanged, this, &TimeBar::hold_at);
  connect(play_, &QToolButton::toggled, this, &TimeBar::play);
  hide();
}

void TimeBar::show_scene(const Scene& scene) {
  length_s_ = 0.0;
  for (const SceneVolume& volume : scene.volumes()) {
    for (const VolumeField& one : volume.volume.fields) {
      const TimedField* field = timed(*one.field);
      if (!changes_with_time(*one.field) || field->cycle_s() <= length_s_) continue;
      length_s_ = field->cycle_s();
      frame_s_ = field->time_spacing_s();
    }
  }
  time_ = scene.time();
  setVisible(length_s_ > 0.0);
  if (!(length_s_ > 0.0)) return;
  // Whole steps a frame, so that arrow keys stop at frames.
  const int frames = std::clamp(static_cast<int>(std::lround(length_s_ / frame_s_)), 1, most_steps);
  const int steps_of_frame = std::max(1, (least_steps + frames - 1) / frames);
  const QSignalBlocker quiet(slider_), silent(play_);
  slider_->setRange(0, frames * steps_of_frame);
  slider_->setSingleStep(steps_of_frame);
  slider_->setPageStep(std::max(1, frames / 10) * steps_of_frame);
  play_->setChecked(plays());
  play_->setIcon(style()->standardIcon(plays() ? QStyle::SP_MediaPause : QStyle::SP_MediaPlay));
  show_time();
}

void TimeBar::follow() {
  if (plays()) show_time();
}

void TimeBar::show_time() {
  at_s_ = time_.at(elapsed_s_()).within(length_s_);
  const QSignalBlocker quiet(slider_);
  if (!slider_->isSliderDown()) slider_->setValue(static_cast<int>(std::lround(slider_->maximum() * at_s_ / length_s_)));
  words_->setText(tr("time of the data %1 s of %2 s").arg(at_s_, 0, 'f', 3).arg(length_s_, 0, 'g', 4));
}

void TimeBar::hold_at(int step) {
  TimeOptions held = time_;
  held.play = TimeOptions::Play::hold;
  held.start_s = length_s_ * step / slider_->maximum();
  Q_EMIT asked(held);
}

void TimeBar::play(bool on) {
  follow();
  TimeOptions next = time_;
  next.play = on ? TimeOptions::Play::loop : TimeOptions::Play::hold;
  // The session's clock runs on: the loop is begun so far back that it goes on from here.
  next.start_s = on ? DataTime(at_s_ - next.speed * elapsed_s_(), true).within(length_s_) : at_s_;
  Q_EMIT asked(next);
}

}  // namespace palpa::explorer
