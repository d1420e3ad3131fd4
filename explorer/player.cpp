#include "explorer/player.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QMouseEvent>
#include <QStyle>
#include <QToolButton>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>
#include <map>

#include "explorer/hand_frame.h"
#include "explorer/paint.h"
#include "palpa/loop/loop.h"
#include "palpa/study/beside_words.h"
#include "palpa/study/recording.h"
#include "palpa/study/run.h"
#include "palpa/trace/trace.h"

namespace palpa::explorer {
namespace {

// [1] Moments kept of a trace: 100 s at 1 kHz. More: memory; fewer: long traces are coarser.
constexpr std::size_t most_rows = 100'000;
constexpr int bar_steps = 10'000;
constexpr std::size_t most_points = 1500;

double force_n(const FeltTrace::Row& row) { return norm(row.command_n); }
double torque_mnm(const FeltTrace::Row& row) { return 1e3 * norm(row.torque_nm); }

QVector<QPointF> curve_of(const FeltTrace& trace, double (*value)(const FeltTrace::Row&)) {
  QVector<QPointF> points;
  const std::size_t stride = trace.rows.size() / most_points + 1;
  double peak = 0.0;
  for (std::size_t i = 0; i < trace.rows.size(); ++i) {
    peak = std::max(peak, value(trace.rows[i]));
    if (i % stride != 0) continue;
    points.push_back({trace.rows[i].t_s, peak});
    peak = 0.0;
  }
  return points;
}

bool has_tool(const FeltTrace& trace) { return std::ranges::any_of(trace.rows, &FeltTrace::Row::has_tool); }

QToolButton* button(QStyle::StandardPixmap sign, const QString& name) {
  auto* made = new QToolButton;
  made->setIcon(made->style()->standardIcon(sign));
  made->setToolTip(name);
  made->setAccessibleName(name);
  made->setAutoRaise(true);
  return made;
}

Probe probe_of(const TickFrame& was) {
  return {.position_m = was.result.probe_m,
          .velocity_m_per_s = was.result.probe_velocity_m_per_s,
          .valid = was.result.probe_valid,
          .buttons = was.buttons,
          .turn = was.result.probe_turn};
}

QString words_of_event(const std::string& kind) {
  if (kind == name_of(SessionEventKind::onset)) return Player::tr("contact");
  if (kind == name_of(SessionEventKind::break_through)) return Player::tr("break-through");
  return QString::fromStdString(kind);
}

/// A hand's ticks in a scene. Throws LoadError when stopped.
class Replaying {
 public:
  /// \param hand  of the scene
  Replaying(const LoadedScene& loaded, std::size_t hand, std::stop_token stop)
      : loaded_(loaded), origin_m_(frame_origin_m(loaded.scene, hand)), stop_(std::move(stop)) {
    loaded_.scene = loaded.scene.of_hand(hand);
  }

  void feel_trace(const std::filesystem::path& folder) {
    const TraceReader reader(folder);
    const std::vector<TraceTick> ticks = reader.ticks();
    const TraceHeader& header = reader.header();
    felt_.name = (folder.filename().empty() ? folder.parent_path().filename() : folder.filename()).string();
    stride_ = ticks.size() / most_rows + 1;
    Session session(loaded_.scene, header.device_encoder_step_m);
    GuardedSession guarded(session, detail::guard_options_of(header));
    for (const TraceTick& tick : ticks) {
      const TickFrame& was = tick.frame;
      add(guarded.tick(was.tick, was.t_s, was.dt_s, probe_of(was), was.circumstances), session);
    }
  }
  void feel_replay(const FeltTrace& first) {
    felt_.name = first.name;
    stride_ = first.hand.size() / most_rows + 1;
    Session session(loaded_.scene, first.encoder_step_m);
    GuardedSession guarded(
        session, GuardOptions{.max_force_n = first.max_force_n, .motors = false, .max_torque_nm = first.max_torque_nm});
    for (const FeltTrace::HandTick& was : first.hand) add(guarded.tick(was.tick, was.t_s, was.dt_s, was.probe), session);
  }
  void feel_hand(const std::string& description) {
    RunOptions options;
    options.hand = description;
    PreparedRun prepared = prepare(loaded_, options);
    felt_.name = description;
    felt_.encoder_step_m = prepared.hand->limits().encoder_step_m;
    felt_.max_force_n = prepared.hand->limits().max_force_n;
    felt_.max_torque_nm = prepared.hand->limits().max_torque_nm;
    stride_ = static_cast<std::size_t>(prepared.duration_s * options.rate_hz) / most_rows + 1;
    Session session(loaded_.scene, felt_.encoder_step_m);
    run_simulated(session, *prepared.hand, {.rate_hz = options.rate_hz, .duration_s = prepared.duration_s}, nullptr,
                  [&](const TickFrame& frame, const Session& now) {
                    felt_.hand.push_back({frame.tick, frame.t_s, frame.dt_s, probe_of(frame)});
                    add(frame, now);
                  });
  }

  FeltTrace felt() {
    if (felt_.rows.empty()) throw LoadError(felt_.name + ": has no ticks; record for longer");
    felt_.duration_s = felt_.rows.back().t_s;
    for (FeltTrace::Event& event : felt_.events) event.row = std::min(event.row, felt_.rows.size() - 1);
    return std::move(felt_);
  }

 private:
  void add(const TickFrame& frame, const Session& session) {
    if (stop_.stop_requested()) throw LoadError("the hand was not felt to its end: it was cancelled; play it again");
    for (const SessionEvent& event : session.events()) {
      std::string subject = event.mode >= 0 ? loaded_.scene.modes()[static_cast<std::size_t>(event.mode)].name : "session";
      felt_.events.push_back({felt_.rows.size(), name_of(event.kind), std::move(subject)});
    }
    felt_.run.ticks.push_back(felt_tick(frame));
    if (seen_++ % stride_ != 0) return;
    FeltTrace::Row& row = felt_.rows.emplace_back(FeltTrace::Row{.tick = frame.tick,
                                                                 .t_s = frame.t_s,
                                                                 .probe_m = frame.result.probe_m + origin_m_,
                                                                 .proxy_m = frame.result.proxy_m + origin_m_,
                                                                 .command_n = frame.command.force_n,
                                                                 .first_primitive = felt_.placed.size()});
    row.has_tool = session.scene().tool().shape != ToolOptions::Shape::point;
    row.probe_turn = frame.result.probe_turn;
    row.proxy_turn = frame.result.proxy_turn;
    row.torque_nm = frame.command.torque_nm;
    if (session.sub_steps().empty()) return;
    const SubStep& last = session.sub_steps().back();
    row.primitives = last.primitives;
    const auto first = session.primitives().begin() + last.first_primitive;
    felt_.placed.insert(felt_.placed.end(), first, first + last.primitives);
    for (std::size_t i = row.first_primitive; i < felt_.placed.size(); ++i) felt_.placed[i].primitive.position_m += origin_m_;
  }

  LoadedScene loaded_;  // of one hand
  Vec3 origin_m_;       // of its frame in the window's
  std::stop_token stop_;
  FeltTrace felt_;
  std::size_t stride_ = 1, seen_ = 0;
};

}  // namespace

Moment FeltTrace::moment(std::size_t row) const {
  const Row& at = rows[row];
  Moment moment{.tick = at.tick, .t_s = at.t_s, .probe_m = at.probe_m, .proxy_m = at.proxy_m, .command_n = at.command_n};
  moment.count = std::min(at.primitives, most_shown_primitives);
  std::copy_n(placed.begin() + static_cast<std::ptrdiff_t>(at.first_primitive), moment.count, moment.primitives.begin());
  if (at.has_tool)
    moment.take_tool({.probe_turn = at.probe_turn, .proxy_turn = at.proxy_turn}, at.torque_nm,
                     std::span(placed).subspan(at.first_primitive, at.primitives));
  return moment;
}

FeltTrace feel_again(const PlayedHand& hand, const LoadedScene& loaded, std::stop_token stop) {
  Replaying replaying(loaded, hand.number, stop);
  if (!hand.trace.empty())
    replaying.feel_trace(hand.trace);
  else if (hand.again)
    replaying.feel_replay(*hand.again);
  else
    replaying.feel_hand(hand.description);
  return replaying.felt();
}

LivePlot* Player::new_plot(const QString& name, const QString& unit) {
  auto* plot = new LivePlot(name, tr("time / s"), unit);
  plot->installEventFilter(this);
  for (QObject* child : plot->findChildren<QObject*>()) child->installEventFilter(this);
  return plot;
}

Player::Player(QWidget* parent)
    : QWidget(parent),
      force_(new_plot(tr("Force over the trace"), tr("force / N"))),
      torque_(new_plot(tr("Torque over the trace"), QString::fromUtf8("τ / mN·m"))),
      bar_(new QSlider(Qt::Horizontal)),
      play_(button(QStyle::SP_MediaPlay, tr("Play"))),
      words_(new QLabel),
      difference_(new QLabel),
      to_difference_(new QToolButton) {
  force_->show_legend();
  torque_->setObjectName("torque_of_trace");
  torque_->hide();
  bar_->setRange(0, bar_steps);
  bar_->setSingleStep(bar_steps / 500);
  bar_->setPageStep(bar_steps / 20);
  bar_->setObjectName("time_bar");
  bar_->setAccessibleName(tr("Time"));
  play_->setCheckable(true);
  play_->setObjectName("play");
  auto* before = button(QStyle::SP_MediaSkipBackward, tr("Previous event"));
  auto* after = button(QStyle::SP_MediaSkipForward, tr("Next event"));
  after->setObjectName("next_event");
  connect(play_, &QToolButton::toggled, this, &Player::play);
  connect(before, &QToolButton::clicked, this, [this] { step_to_event(-1); });
  connect(after, &QToolButton::clicked, this, [this] { step_to_event(1); });
  connect(bar_, &QSlider::valueChanged, this, [this](int step) {
    if (first_) seek(duration_s_ * step / bar_steps);
  });
  auto* row = new QHBoxLayout;
  for (QToolButton* one : {before, play_, after, to_difference_}) row->addWidget(one);
  row->addWidget(bar_, 1);
  row->addWidget(words_);
  words_->setMinimumWidth(260);
  difference_->setObjectName("difference");
  difference_->setAccessibleName(tr("Difference of the two traces"));
  difference_->setWordWrap(true);
  difference_->setMinimumHeight(2 * difference_->fontMetrics().lineSpacing());
  difference_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  to_difference_->setText(tr("Largest difference"));
  to_difference_->setObjectName("to_difference");
  to_difference_->setToolTip(tr("Go to the moment of the largest difference (N and B stop there, too)"));
  connect(to_difference_, &QToolButton::clicked, this, [this] {
    if (largest_difference_s_) seek(*largest_difference_s_);
  });
  auto* all = new QVBoxLayout(this);
  all->setContentsMargins(4, 2, 4, 2);
  auto* plots = new QHBoxLayout;
  plots->addWidget(force_, 3);
  plots->addWidget(torque_, 2);
  all->addLayout(plots, 1);
  all->addWidget(difference_);
  all->addLayout(row);
}

void Player::show_trace(std::shared_ptr<const FeltTrace> first, std::shared_ptr<const FeltTrace> second,
                        std::vector<std::shared_ptr<const FeltTrace>> others) {
  first_ = std::move(first);
  second_ = std::move(second);
  others_ = std::move(others);
  for (LivePlot* plot : {force_, torque_}) plot->clear();
  torque_->setVisible((first_ && has_tool(*first_)) || (second_ && has_tool(*second_)));
  plays_ = false;
  play_->setChecked(false);
  compare();
  if (!first_) return;
  duration_s_ = std::max(first_->duration_s, second_ ? second_->duration_s : 0.0);
  const auto draw = [&](LivePlot& plot, double (*value)(const FeltTrace::Row&), double most) {
    const auto add = [&](const FeltTrace& trace, const QColor& color) {
      plot.set_curve(plot.add_curve(QString::fromStdString(trace.name), color, 1.6), curve_of(trace, value));
      for (const FeltTrace::Row& row : trace.rows) most = std::max(most, value(row));
    };
    add(*first_, QColor(0, 114, 178));
    if (second_) add(*second_, QColor(213, 94, 0));
    plot.set_x_range(0.0, std::max(1e-3, duration_s_));
    plot.set_y_range(0.0, 1.1 * most);
  };
  draw(*force_, force_n, 0.1);
  draw(*torque_, torque_mnm, 1.0);
  seek(0.0);
}

void Player::compare() {
  largest_difference_s_.reset();
  difference_->setVisible(second_ != nullptr);
  QString words;
  if (second_) {
    const FeltRun &first = first_->run, &second = second_->run;
    if (const std::string part = where_hands_part(first, second); !part.empty()) {
      words = tr("The hands of the two traces differ: %1. Forces compare tick by tick for one hand.")
                  .arg(QString::fromStdString(part));
    } else {
      const FeltDifference difference = compare_felt(first, second);
      QStringList sentences;
      for (const std::string& one : detail::difference_sentences(first, second, difference))
        sentences << QString::fromStdString(one);
      if (sentences.size() > 1) sentences.swapItemsAt(0, 1);  // the largest difference first
      words = sentences.join(" ");
      if (difference.difference_n[difference.largest] > 0.0) largest_difference_s_ = first.ticks[difference.largest].t_s;
    }
  }
  difference_->setText(words);
  to_difference_->setVisible(largest_difference_s_.has_value());
}

std::size_t Player::row_at(const FeltTrace& trace, double t_s) {
  const auto at = std::upper_bound(trace.rows.begin(), trace.rows.end(), t_s,
                                   [](double t, const FeltTrace::Row& row) { return t < row.t_s; });
  return at == trace.rows.begin() ? 0 : static_cast<std::size_t>(at - trace.rows.begin()) - 1;
}

Moment Player::moment() const { return first_ ? first_->moment(row_at(*first_, at_s_)) : Moment{}; }
std::optional<Moment> Player::other_moment() const {
  if (!second_) return {};
  return second_->moment(row_at(*second_, at_s_));
}

std::vector<Moment> Player::hands() const {
  std::vector<Moment> moments;
  for (const auto& other : others_) moments.push_back(other->moment(row_at(*other, at_s_)));
  return moments;
}

std::vector<std::size_t> Player::trail(std::size_t most) const {
  std::vector<std::size_t> rows;
  if (!first_) return rows;
  const std::size_t end = row_at(*first_, at_s_) + 1, begin = end > 4 * most ? end - 4 * most : 0;
  for (std::size_t row = begin; row < end; row += 4) rows.push_back(row);
  return rows;
}

void Player::play(bool on) {
  if (on && first_ && at_s_ >= duration_s_) at_s_ = 0.0;
  plays_ = on && first_;
  if (play_->isChecked() != plays_) play_->setChecked(plays_);
  play_->setIcon(style()->standardIcon(plays_ ? QStyle::SP_MediaPause : QStyle::SP_MediaPlay));
}

void Player::pass(double dt_s) {
  if (!plays_) return;
  const double next_s = at_s_ + dt_s;
  if (next_s >= duration_s_) play(false);
  seek(next_s);
}

void Player::seek(double t_s) {
  if (!first_) return;
  at_s_ = std::clamp(t_s, 0.0, duration_s_);
  const QSignalBlocker quiet(bar_);
  bar_->setValue(static_cast<int>(std::lround(bar_steps * at_s_ / std::max(1e-9, duration_s_))));
  show_time();
  Q_EMIT moved();
}

void Player::step_to_event(int direction) {
  if (!first_) return Q_EMIT said(tr("Events are those of a trace: open one, or play a hand (Ctrl+T)."), false);
  struct Stop {
    double t_s;
    QString kind, subject;
  };
  std::vector<Stop> stops;
  for (const FeltTrace::Event& event : first_->events)
    stops.push_back({first_->rows[event.row].t_s, words_of_event(event.kind), QString::fromStdString(event.subject)});
  if (largest_difference_s_) stops.push_back({*largest_difference_s_, tr("largest difference"), {}});
  std::ranges::stable_sort(stops, {}, &Stop::t_s);
  const Stop* best = nullptr;
  std::map<QString, int> kinds;
  for (const Stop& stop : stops) {
    ++kinds[stop.kind];
    if (direction > 0 && stop.t_s > at_s_ + 1e-6 && !best) best = &stop;
    if (direction < 0 && stop.t_s < at_s_ - 1e-6) best = &stop;
  }
  if (best) {
    seek(best->t_s);
    return Q_EMIT said(best->subject.isEmpty() ? best->kind : tr("%1: %2").arg(best->kind, best->subject), false);
  }
  QStringList words;
  for (const auto& [kind, count] : kinds) words << QString("%1 × %2").arg(count).arg(kind);
  Q_EMIT said(kinds.empty()   ? tr("This trace has no event.")
              : direction > 0 ? tr("No event after this; the trace has %1.").arg(words.join(", "))
                              : tr("No event before this; the trace has %1.").arg(words.join(", ")),
              false);
}

void Player::show_time() {
  for (LivePlot* plot : {force_, torque_}) {
    plot->clear_marks();
    for (const FeltTrace::Event& event : first_->events)
      plot->mark(first_->rows[event.row].t_s, event.kind == name_of(SessionEventKind::break_through)
                                                  ? QColor(204, 121, 167, 170)
                                                  : QColor(128, 128, 128, 70));
    if (largest_difference_s_) plot->mark(*largest_difference_s_, QColor(200, 30, 20));
    plot->mark(at_s_, palette().color(QPalette::Highlight));
    plot->draw();
  }
  QString words = tr("%1 s of %2 s, %3").arg(at_s_, 0, 'f', 3).arg(duration_s_, 0, 'f', 2).arg(words_of_wrench(moment()));
  if (const std::optional<Moment> other = other_moment())
    words = tr("%1 s of %2 s, first %3, second %4")
                .arg(at_s_, 0, 'f', 3)
                .arg(duration_s_, 0, 'f', 2)
                .arg(words_of_wrench(moment()))
                .arg(words_of_wrench(*other));
  words_->setText(words);
}

bool Player::eventFilter(QObject* watched, QEvent* event) {
  if (first_ && (event->type() == QEvent::MouseButtonPress || event->type() == QEvent::MouseMove)) {
    const auto* mouse = static_cast<QMouseEvent*>(event);
    if (mouse->buttons() & Qt::LeftButton) {
      const QWidget* widget = qobject_cast<QWidget*>(watched);
      LivePlot* const plot = widget && (widget == torque_ || torque_->isAncestorOf(widget)) ? torque_ : force_;
      seek(plot->x_at(widget ? widget->mapTo(plot, mouse->pos()).x() : mouse->pos().x()));
      return true;
    }
  }
  return QWidget::eventFilter(watched, event);
}

}  // namespace palpa::explorer
