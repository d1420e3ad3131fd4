#include "explorer/instruments.h"

#include <QFontDatabase>
#include <QHBoxLayout>
#include <QScrollArea>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>

#include "explorer/paint.h"
#include "palpa/study/energy_table.h"
#include "palpa/study/spectrum.h"

namespace palpa::explorer {
namespace {

// [1] Points of a drawn curve. More: slower; fewer: short peaks merge, although each interval keeps its largest value.
constexpr std::size_t most_points = 700;
constexpr double spectrum_s = 2.0;  // of force in the spectrum
constexpr int pictures_per_spectrum = 8;
constexpr int pictures_per_curve = 2;
// [pixels] Width from which a second curve, and a third, is beside the force's. Less: that has no room.
constexpr int second_px = 800, third_px = 1100;

/// Round end of an axis above its largest value.
double axis_end(double most) { return std::max(detail::round_length(1.25 * most), 1.05 * most); }

QString words_of(GuardState state) {
  switch (state) {
    case GuardState::pass: return Instruments::tr("on");
    case GuardState::limited: return Instruments::tr("at its limit");
    case GuardState::ramp: return Instruments::tr("coming");
    case GuardState::falling: return Instruments::tr("going");
    default: return name_of(state);
  }
}

}  // namespace

Instruments::Instruments(QWidget* parent)
    : QWidget(parent),
      force_(new LivePlot(tr("Force over the last seconds"), tr("time / s"), tr("force / N"))),
      torque_(new LivePlot(tr("Torque over the last seconds"), tr("time / s"), QString::fromUtf8("torque / mN·m"))),
      spectrum_(new LivePlot(tr("Spectrum of the force"), tr("frequency / Hz"), tr("N / √Hz"))),
      times_(new QLabel),
      guard_(new QLabel),
      energies_(new QLabel) {
  force_->set_x_range(-shown_s, 0.0);
  force_->show_legend();
  torque_->setObjectName("torque");
  torque_->set_x_range(-shown_s, 0.0);
  torque_->hide();
  spectrum_->set_logarithmic();
  spectrum_->set_x_range(4.0, 500.0);
  spectrum_->set_y_range(1e-6, 1.0);
  spectrum_->shade(tactile_low_hz, tactile_high_hz, QColor(230, 159, 0, 40));
  spectrum_->setToolTip(
      tr("Shaded: the band in which skin feels vibration, %1 to %2 Hz").arg(tactile_low_hz).arg(tactile_high_hz));
  spectrum_->add_curve(tr("force"), color_of_mode(0), 1.5);
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(4, 4, 4, 4);
  row->addWidget(force_, 5);
  row->addWidget(torque_, 3);
  row->addWidget(spectrum_, 2);
  row->addWidget(make_words());
  start({});
}

QWidget* Instruments::make_words() {
  for (QLabel* label : {times_, guard_, energies_}) {
    label->setTextInteractionFlags(Qt::TextSelectableByMouse);
    label->setTextFormat(Qt::PlainText);
    label->setAlignment(Qt::AlignTop | Qt::AlignLeft);
  }
  guard_->setWordWrap(true);
  QFont large = guard_->font();
  large.setPointSizeF(1.2 * large.pointSizeF());
  large.setBold(true);
  guard_->setFont(large);
  times_->setAccessibleName(tr("Times of the loop"));
  guard_->setAccessibleName(tr("State of the guard"));
  energies_->setAccessibleName(tr("Energies"));
  // Growing text must not move the picture above it.
  auto* column = new QWidget;
  auto* scroll = new QScrollArea;
  scroll->setWidget(column);
  scroll->setWidgetResizable(true);
  scroll->setFrameShape(QFrame::NoFrame);
  scroll->setMinimumWidth(300);
  scroll->setSizePolicy(QSizePolicy::Fixed, QSizePolicy::Ignored);
  auto* words = new QVBoxLayout(column);
  words->setContentsMargins(0, 0, 0, 0);
  for (QLabel* label : {times_, energies_}) {
    QFont small = label->font();
    small.setPointSizeF(0.82 * small.pointSizeF());
    label->setFont(small);
  }
  QFont digits = QFontDatabase::systemFont(QFontDatabase::FixedFont);
  digits.setPointSizeF(times_->font().pointSizeF());
  energies_->setFont(digits);
  words->addWidget(guard_);
  words->addWidget(times_);
  words->addWidget(energies_);
  words->addStretch();
  return scroll;
}

void Instruments::resizeEvent(QResizeEvent* event) {
  QWidget::resizeEvent(event);
  show_torque(has_torque_);
}

void Instruments::show_torque(bool shown) {
  has_torque_ = shown;
  torque_->setVisible(shown && width() >= second_px);
  spectrum_->setVisible(width() >= (shown ? third_px : second_px));
}

void Instruments::start(const std::vector<std::string>& modes, std::size_t hand) {
  modes_ = modes;
  hand_ = hand;
  for (LivePlot* plot : {force_, torque_}) plot->clear();
  torque_->add_curve(tr("on the hand"), palette().color(QPalette::WindowText), 2.0);
  shown_.clear();
  curves_ = 1 + std::min(modes.size(), most_shown_modes);
  force_->add_curve(tr("on the hand"), palette().color(QPalette::WindowText), 2.0);
  std::vector<ModeSummary> named;
  for (std::size_t i = 0; i + 1 < curves_; ++i) {
    force_->add_curve(QString::fromStdString(modes[i]), color_of_mode(i), 1.2);
    named.push_back({.name = modes[i]});
  }
  summary_ = std::make_unique<SummaryBuilder>(std::move(named));
  force_->draw();
}

void Instruments::update_from(SampleRing& ring) {
  Sample sample;
  bool any = false;
  while (ring.take(sample)) {
    if (sample.hand != hand_) continue;  // from before another was led
    const TickFrame& frame = sample.frame;
    if (!shown_.empty() && frame.t_s < shown_.back().t_s) shown_.clear();  // a new session
    Shown shown{.t_s = frame.t_s,
                .probe_m = frame.result.probe_m,
                .proxy_m = frame.result.proxy_m,
                .command_n = frame.command.force_n,
                .command_nm = frame.command.torque_nm,
                .error_bound_m = frame.result.error_bound_m};
    for (std::size_t i = 0; i < sample.count; ++i) shown.mode_n[i] = static_cast<float>(norm(sample.modes[i].force_n));
    shown_.push_back(shown);
    summary_->add(frame, {sample.modes.data(), sample.count}, {});
    any = true;
  }
  while (!shown_.empty() && shown_.front().t_s < shown_.back().t_s - shown_s) shown_.pop_front();
  if (!any || !isVisible()) return;
  if (drawn_ % pictures_per_curve == 0) draw_force();
  if (drawn_ % pictures_per_curve == 0 && has_torque_) draw_torque();
  if (drawn_++ % pictures_per_spectrum == 0) draw_spectrum();
}

template <class Value>
std::vector<QVector<QPointF>> Instruments::curves_of(std::size_t count, double& most, const Value& value) const {
  const std::size_t stride = shown_.size() / most_points + 1;
  std::vector<QVector<QPointF>> points(count);
  const double now_s = shown_.back().t_s;
  // Intervals by absolute index, so that a peak does not flicker while it moves left.
  std::vector<double> peaks(count, 0.0);
  for (std::size_t i = 0; i < shown_.size(); ++i) {
    const Shown& sample = shown_[i];
    for (std::size_t m = 0; m < count; ++m) peaks[m] = std::max(peaks[m], value(sample, m));
    const auto bucket = [&](const Shown& s) {
      return static_cast<std::int64_t>(std::floor(s.t_s * 1e3 + 0.5)) / static_cast<std::int64_t>(stride);
    };
    if (i + 1 < shown_.size() && bucket(shown_[i + 1]) == bucket(sample)) continue;
    for (std::size_t m = 0; m < count; ++m) {
      points[m].push_back({sample.t_s - now_s, peaks[m]});
      most = std::max(most, peaks[m]);
      peaks[m] = 0.0;
    }
  }
  return points;
}

void Instruments::draw_force() {
  double most_n = 0.5;
  const std::vector<QVector<QPointF>> points = curves_of(curves_, most_n, [](const Shown& sample, std::size_t curve) {
    return curve == 0 ? norm(sample.command_n) : double(sample.mode_n[curve - 1]);
  });
  for (std::size_t m = 0; m < curves_; ++m) force_->set_curve(static_cast<int>(m), points[m]);
  force_->set_y_range(0.0, axis_end(most_n));
  force_->draw();
}

void Instruments::draw_torque() {
  double most_mnm = 5.0;
  const std::vector<QVector<QPointF>> points =
      curves_of(1, most_mnm, [](const Shown& sample, std::size_t) { return 1e3 * norm(sample.command_nm); });
  torque_->set_curve(0, points.front());
  torque_->set_y_range(0.0, axis_end(most_mnm));
  torque_->draw();
}

void Instruments::draw_spectrum() {
  std::vector<Vec3> signal;
  const double from_s = shown_.back().t_s - spectrum_s;
  double first_s = shown_.back().t_s;
  for (const Shown& sample : shown_) {
    if (sample.t_s < from_s) continue;
    first_s = std::min(first_s, sample.t_s);
    signal.push_back(sample.command_n);
  }
  const double length_s = shown_.back().t_s - first_s;
  if (!(length_s > 0.5)) return;
  const Spectrum spectrum = spectrum_of(signal, static_cast<double>(signal.size() - 1) / length_s);
  QVector<QPointF> points;
  for (std::size_t i = 1; i < spectrum.power_per_hz.size(); ++i)
    points.push_back({static_cast<double>(i) * spectrum.step_hz, std::max(1e-9, std::sqrt(spectrum.power_per_hz[i]))});
  spectrum_->set_curve(0, points);
  spectrum_->draw();
}

void Instruments::show_statistics(const LoopStatistics& statistics, const TickFrame& frame, bool has_tool,
                                  const char* device_fault) {
  const double bound_m = shown_.empty() ? 0.0 : double(shown_.back().error_bound_m);
  times_->setText(tr("tick %1 µs (p99 %2), late p99 %3 µs\n%4 ticks, %5 missed; error at most %6 m")
                      .arg(statistics.tick.p50_us, 0, 'f', 0)
                      .arg(statistics.tick.p99_us, 0, 'f', 0)
                      .arg(statistics.late.p99_us, 0, 'f', 0)
                      .arg(statistics.ticks)
                      .arg(statistics.missed)
                      .arg(bound_m, 0, 'g', 2));
  QString words = tr("Force: %1, %2 N").arg(words_of(frame.command.guard)).arg(norm(frame.command.force_n), 0, 'f', 2);
  if (has_tool) words += tr(", torque %1 mN·m").arg(1e3 * norm(frame.command.torque_nm), 0, 'f', 0);
  if (device_fault)
    words += QString(" – ") + device_fault;
  else if (frame.command.cause == GuardCause::no_position)
    words += tr(" – the hand was put elsewhere");
  else if (frame.command.cause == GuardCause::panic)
    words += tr(" – it was turned off");
  else if (frame.command.cause != GuardCause::none)
    words += QString(" – ") + format_cause(frame.command.cause);
  guard_->setText(words);
  const EnergyTable table = energy_table(summary());
  QString rows = tr("energy / mJ\n");
  for (const auto& [sign, entries] : {std::pair("in ", &table.in), std::pair("out", &table.out)})
    for (const EnergyEntry& entry : *entries)
      rows += QString("%1 %2  %3\n").arg(sign).arg(1e3 * entry.energy_j, 9, 'f', 3).arg(QString::fromStdString(entry.label));
  energies_->setText(rows);
}

}  // namespace palpa::explorer
