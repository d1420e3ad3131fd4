#include "palpa/report/signal.h"

#include <algorithm>
#include <cmath>

#include "palpa/report/html.h"

namespace palpa::detail {
namespace {

constexpr std::size_t most_steps = 20;  // [1] listed, the largest first. More: a longer page; fewer: causes are missed

std::string millinewtons(double force_n) { return text("%.2f mN", 1e3 * force_n); }
std::string steepness(double n_per_ms) { return text("%.3f N/ms", n_per_ms); }

/// Adds the events of a tick; `next` advances through them.
void add_events(const Recorded& recorded, std::size_t& next, std::int64_t number, FeltTick& tick) {
  for (; next < recorded.events.size() && recorded.events[next].tick <= number; ++next) {
    const std::string& kind = recorded.events[next].kind;
    tick.onset |= kind == "onset";
    tick.broke_through |= kind == "break_through";
    tick.other_event |= kind == "fault" || kind == "warning";
  }
}

/// k, from the tick with the longest spring, where rounding matters least.
double stiffness_n_per_m(const Recorded& recorded) {
  double longest_m = 0.0, stiffness = 0.0;
  for (const TickFrame& frame : recorded.ticks) {
    const double apart_m = distance(frame.result.proxy_m, frame.result.probe_m);
    if (!(apart_m > longest_m) || !(frame.result.energy.stored_j > 0.0)) continue;
    longest_m = apart_m;
    stiffness = 2.0 * frame.result.energy.stored_j / (apart_m * apart_m);
  }
  return stiffness;
}

}  // namespace

Series amplitudes(const Spectrum& spectrum, std::string name, CurveColor color, Stroke stroke) {
  Series series{.name = std::move(name), .color = color, .stroke = stroke};
  for (std::size_t i = 1; i < spectrum.power_per_hz.size(); ++i) {
    series.xs.push_back(static_cast<double>(i) * spectrum.step_hz);
    series.ys.push_back(1e3 * std::sqrt(spectrum.power_per_hz[i]));
  }
  return series;
}

Plot spectrum_plot(std::string title, std::vector<Series> curves) {
  return {.title = std::move(title),
          .x_label = "frequency / Hz",
          .y_label = "force / (mN/\u221aHz)",
          .series = std::move(curves),
          .marks = {{tactile_low_hz, "tactile band"}, {tactile_high_hz, "tactile band"}},
          .x_range = std::pair{1.0, 1000.0},
          .y_range = std::pair{1e-3, 1e3},
          .x_log = true,
          .y_log = true};
}

FeltRun felt_run_of(const Recorded& recorded) {
  FeltRun run{.stiffness_n_per_m = stiffness_n_per_m(recorded)};
  for (std::size_t m = 0; m < recorded.modes.size(); ++m) {
    FeltMode mode{.name = recorded.modes[m]};
    for (const ModeSummary& known : recorded.summary.modes)
      mode.is_directed |= known.name == mode.name && places_directed_forces(known.type);
    for (const ModeForce& tick : recorded.pushes[m]) mode.force_n.push_back(tick.force_n);
    run.modes.push_back(std::move(mode));
  }
  std::size_t next_event = 0;
  for (const TickFrame& frame : recorded.ticks) {
    FeltTick tick = felt_tick(frame);
    add_events(recorded, next_event, frame.tick, tick);
    run.ticks.push_back(tick);
  }
  return run;
}

Signal signal_of(const Recorded& recorded, const Scene* scene) {
  Signal signal{.rate_hz = recorded.header.dt_s > 0.0 ? 1.0 / recorded.header.dt_s : 0.0, .run = felt_run_of(recorded)};
  if (signal.rate_hz == 0.0 || signal.run.ticks.empty()) return signal;
  const FeltSignals quiet = quiet_signals_of(signal.run, -INFINITY, INFINITY);
  signal.command = spectrum_of(quiet.command_n, signal.rate_hz);
  signal.spring = spectrum_of(quiet.spring_n, signal.rate_hz);
  if (scene) {
    const EdgesOfData edges(*scene);
    signal.steps = excess_steps(signal.run, &edges);
    signal.at_edges_n_per_ms = steepest_at_edges_n_per_ms(signal.run, edges);
  } else {
    signal.steps = excess_steps(signal.run, nullptr);
    signal.at_edges_n_per_ms = -1.0;
  }
  return signal;
}

std::string signal_markup(const Signal& signal) {
  std::vector<std::vector<std::string>> rows;
  if (signal.command.step_hz > 0.0) {
    const double felt_n = signal.command.band_rms(tactile_low_hz, tactile_high_hz);
    const double spring_n = signal.spring.band_rms(tactile_low_hz, tactile_high_hz);
    rows = {{"force, 20 to 500 Hz, root mean square", millinewtons(felt_n)},
            {"force, 100 to 500 Hz, root mean square", millinewtons(signal.command.band_rms(rough_low_hz, tactile_high_hz))},
            {"k times the probe, 20 to 500 Hz", millinewtons(spring_n)}};
    if (spring_n > 0.0) rows.push_back({"force : k times the probe", text("%.2f", felt_n / spring_n)});
  } else {
    rows.push_back({"force, 20 to 500 Hz", "no contact is long enough"});
  }
  rows.push_back({"limited by the guard", text("%.1f %% of the ticks", 100.0 * saturated_share(signal.run))});
  const bool broke =
      std::any_of(signal.run.ticks.begin(), signal.run.ticks.end(), [](const FeltTick& tick) { return tick.broke_through; });
  rows.push_back({"steepest fall at a break-through", broke ? steepness(steepest_fall_n_per_ms(signal.run)) : "none"});
  rows.push_back({"steepest change at an end of data", signal.at_edges_n_per_ms < 0.0 ? "data not available"
                                                       : signal.at_edges_n_per_ms == 0.0
                                                           ? "none near"
                                                           : steepness(signal.at_edges_n_per_ms)});
  return table({"quantity", "value"}, rows, 1);
}

std::string steps_markup(const Signal& signal) {
  std::string out = text(
      "<h3>Steps</h3>\n<p>Steps of more than %.0f mN within a tick beyond what the spring makes of the hand's own motion. ",
      1e3 * felt_step_n);
  if (signal.steps.empty()) return out + "None.</p>\n";
  std::vector<std::vector<std::string>> rows;
  for (const StepCause cause : step_causes) {
    int count = 0;
    double largest_n = 0.0;
    for (const ExcessStep& step : signal.steps) {
      if (step.cause != cause) continue;
      ++count;
      largest_n = std::max(largest_n, step.excess_n);
    }
    if (count == 0) continue;
    rows.push_back({name_of(cause), has_event(cause) ? "yes" : "no", grouped(count),
                    text("%.2f", count / duration_s(signal.run)), text("%.3f N", largest_n)});
  }
  out += "Steps without an event come from nothing that the scene names.</p>\n" +
         table({"cause", "has an event", "steps", "per second", "largest excess"}, rows, 2);

  std::vector<ExcessStep> unexplained;
  std::copy_if(signal.steps.begin(), signal.steps.end(), std::back_inserter(unexplained),
               [](const ExcessStep& step) { return !has_event(step.cause); });
  if (unexplained.empty()) return out;
  std::stable_sort(unexplained.begin(), unexplained.end(),
                   [](const auto& a, const auto& b) { return a.excess_n > b.excess_n; });
  unexplained.resize(std::min(unexplained.size(), most_steps));
  out +=
      "<p>The largest of those without an event:</p>\n<div class=\"wide\"><table>\n<thead><tr><th scope=\"col\">time</th>"
      "<th scope=\"col\">cause</th><th scope=\"col\">mode that changed most</th><th scope=\"col\" class=\"number\">step</th>"
      "<th scope=\"col\" class=\"number\">excess</th></tr></thead>\n<tbody>\n";
  for (const ExcessStep& step : unexplained) {
    const std::string mode = step.mode < 0 ? "none" : signal.run.modes[static_cast<std::size_t>(step.mode)].name;
    out += text("<tr><td><a href=\"#view\" data-time=\"%.6f\">%.3f s</a></td><td>%s</td><td>", step.t_s, step.t_s,
                name_of(step.cause)) +
           escaped(mode) +
           text("</td><td class=\"number\">%.3f N</td><td class=\"number\">%.3f N</td></tr>\n", step.step_n, step.excess_n);
  }
  return out + "</tbody></table></div>\n";
}

}  // namespace palpa::detail
