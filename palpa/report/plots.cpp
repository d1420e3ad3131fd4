#include "palpa/report/plots.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "palpa/report/html.h"
#include "palpa/report/numbers.h"
#include "palpa/report/words.h"

namespace palpa::detail {
namespace {

using Json = nlohmann::ordered_json;

/// Energies below this [mJ] are rounding. Less: a curve of rounding; more: small energies have none.
constexpr double least_mj = 1e-9;
/// Torques [N·m] that differ by less are equal. Less: a second curve of rounding; more: a limit has none.
constexpr double least_torque_nm = 1e-7;

constexpr palpa::CurveColor mode_colors[] = {palpa::CurveColor::blue,   palpa::CurveColor::vermilion, palpa::CurveColor::green,
                                             palpa::CurveColor::purple, palpa::CurveColor::orange,    palpa::CurveColor::sky,
                                             palpa::CurveColor::black};

std::vector<Mark> marks_of(const Recorded& recorded) {
  std::vector<Mark> marks;
  for (const RecordedEvent& event : recorded.events) {
    if (event.kind == "onset") marks.push_back({event.t_s, "onset"});
    if (event.kind == "break_through") marks.push_back({event.t_s, "break-through"});
    if (event.kind == "fault") marks.push_back({event.t_s, "fault"});
  }
  return marks;
}

TimePlot force_plot(const Recorded& recorded) {
  const auto& ticks = recorded.ticks;
  TimePlot made{
      .id = "force",
      .plot = {.title = "Force on the hand", .x_label = "time / s", .y_label = "force / N", .marks = marks_of(recorded)},
      .label = text("Force over time: at most %.3f N on the hand.", recorded.summary.force_max_n),
      .caption = "Force on the hand. Markers on top: onsets and break-throughs of levels."};
  if (recorded.summary.guard_limited_ticks > 0) {
    made.plot.series.push_back(over_time(recorded.ticks, "requested (Eq. 1), before the guard", palpa::CurveColor::orange,
                                         Stroke::dashed, [&](std::size_t i) {
                                           const bool limited = ticks[i].command.guard == GuardState::limited;
                                           return norm(limited ? ticks[i].result.force_n : ticks[i].command.force_n);
                                         }));
    made.caption =
        "Force on the hand, and the force requested by the coupling where the guard limited it. Markers on top: onsets and "
        "break-throughs of levels.";
  }
  made.plot.series.push_back(over_time(recorded.ticks, "on the hand", palpa::CurveColor::black, Stroke::solid,
                                       [&](std::size_t i) { return norm(ticks[i].command.force_n); }));
  return made;
}

/// Torque of a tool: on the hand, and of the coupling where the device drives none or the guard limited it.
TimePlot torque_plot(const Recorded& recorded) {
  const auto& ticks = recorded.ticks;
  const LargestTorques most = largest_torques(recorded);
  const bool is_driven = most.on_hand_nm > 0.0;
  const auto differs = [](const TickFrame& f) { return norm(f.result.torque_nm - f.command.torque_nm) > least_torque_nm; };
  TimePlot made{
      .id = "torque",
      .plot = {.title = is_driven ? "Torque on the hand" : "Torque of the coupling",
               .x_label = "time / s",
               .y_label = "torque / mN\u00b7m",
               .marks = marks_of(recorded)},
      .label = text("Torque over time: at most %.3f mN\u00b7m.", 1e3 * (is_driven ? most.on_hand_nm : most.coupling_nm)),
      .caption = is_driven ? "Torque on the hand, about the device's point."
                           : "Torque of the coupling about the device's point. The device drives no torque, so the "
                             "hand does not feel it."};
  if (!is_driven || std::any_of(ticks.begin(), ticks.end(), differs)) {
    made.plot.series.push_back(over_time(ticks, "of the coupling, before the guard", palpa::CurveColor::orange, Stroke::dashed,
                                         [&](std::size_t i) { return 1e3 * norm(ticks[i].result.torque_nm); }));
    if (is_driven) made.caption += " Dashed: of the coupling, before the guard.";
  }
  if (is_driven)
    made.plot.series.push_back(over_time(ticks, "on the hand", palpa::CurveColor::black, Stroke::solid,
                                         [&](std::size_t i) { return 1e3 * norm(ticks[i].command.torque_nm); }));
  return made;
}

TimePlot modes_plot(const Recorded& recorded) {
  TimePlot made{.id = "modes",
                .plot = {.title = "Force of each mode", .x_label = "time / s", .y_label = "force / N"},
                .label = "Force of each mode over time.",
                .caption = "Force of each mode on the proxy. Above 1 mN a mode is in contact."};
  if (recorded.summary.guard_limited_ticks > 0) made.caption += " Before the guard's limit.";
  for (std::size_t m = 0; m < recorded.modes.size(); ++m) {
    constexpr Stroke strokes[] = {Stroke::solid, Stroke::dashed, Stroke::dotted};
    made.plot.series.push_back(over_time(recorded.ticks, recorded.modes[m], mode_colors[m % std::size(mode_colors)],
                                         strokes[m % 3], [&](std::size_t i) { return norm(recorded.pushes[m][i].force_n); }));
  }
  made.plot.marks = marks_of(recorded);
  return made;
}

TimePlot distance_plot(const Recorded& recorded) {
  double largest_m = 0.0;
  for (const TickFrame& frame : recorded.ticks) {
    const double apart_m = distance(frame.result.proxy_m, frame.result.probe_m);
    if (std::isfinite(apart_m)) largest_m = std::max(largest_m, apart_m);
  }
  return {.id = "distance",
          .plot = {.title = "Distance from probe to proxy",
                   .x_label = "time / s",
                   .y_label = "distance / mm",
                   .series = {over_time(recorded.ticks, "|proxy \u2212 probe|", palpa::CurveColor::blue, Stroke::solid,
                                        [&](std::size_t i) {
                                          const Tick& tick = recorded.ticks[i].result;
                                          return 1e3 * distance(tick.proxy_m, tick.probe_m);
                                        })},
                   .marks = marks_of(recorded)},
          .label = text("Distance of proxy and probe over time: at most %.3f mm.", 1e3 * largest_m),
          .caption =
              "Distance between the proxy, held by the data, and the probe, the position of the hand, in the hand's frame. "
              "Times the stiffness it is the force of the spring."};
}

TimePlot energy_plot(const Recorded& recorded) {
  TimePlot made{.id = "energy",
                .plot = {.title = "Energy", .x_label = "time / s", .y_label = "energy / mJ"},
                .label = "Energy over time.",
                .caption =
                    "The work of the hand up to each moment and its balance: dissipated by the modes, lost at releases, and "
                    "stored in the coupling's spring, which returns it."};
  const auto cumulated = [&](const char* name, palpa::CurveColor color, Stroke stroke, auto of_tick) {
    double sum_j = 0.0;
    made.plot.series.push_back(over_time(recorded.ticks, name, color, stroke, [&](std::size_t i) {
      const double sum_mj = 1e3 * (sum_j += of_tick(recorded.ticks[i]));
      return std::abs(sum_mj) < least_mj ? 0.0 : sum_mj;
    }));
  };
  cumulated("work of the hand", palpa::CurveColor::black, Stroke::solid,
            [](const TickFrame& f) { return -f.command.work_on_hand_j; });
  cumulated("dissipated by the modes", palpa::CurveColor::green, Stroke::solid,
            [](const TickFrame& f) { return f.result.energy.dissipated_j - f.result.energy.injected_j; });
  cumulated("lost at releases", palpa::CurveColor::vermilion, Stroke::dashed,
            [](const TickFrame& f) { return f.result.energy.released_j; });
  made.plot.series.push_back(over_time(recorded.ticks, "stored in the spring", palpa::CurveColor::blue, Stroke::dotted,
                                       [&](std::size_t i) { return 1e3 * recorded.ticks[i].result.energy.stored_j; }));
  made.plot.marks = marks_of(recorded);
  return made;
}

/// Felt octave of volumes larger than memory.
TimePlot octave_plot(const Recorded& recorded) {
  const auto& ticks = recorded.ticks;
  const auto count_of = [&](auto&& is_so) {
    return static_cast<double>(std::count_if(ticks.begin(), ticks.end(), [&](const TickFrame& f) { return is_so(f.result); }));
  };
  const double finest = count_of([](const Tick& tick) { return tick.felt_octave == 0.0; });
  const double forced = count_of([](const Tick& tick) { return tick.forced_octave; });
  const double share = 100.0 * finest / static_cast<double>(std::max<std::size_t>(ticks.size(), 1));
  return {.id = "octave",
          .plot = {.title = "Felt octave",
                   .x_label = "time / s",
                   .y_label = "octave",
                   .series = {over_time(ticks, "felt octave", palpa::CurveColor::purple, Stroke::solid,
                                        [&](std::size_t i) { return ticks[i].result.felt_octave; })}},
          .label = text("Felt octave over time: 0 in %.1f %% of the ticks.", share),
          .caption = text("Octave 0 has the voxels of the file, each next octave half as fine; between two of them both are "
                          "blended. Octave 0 was felt in %.1f %% of the ticks; in %.0f a coarser one was taken at once, since "
                          "the windows did not hold the way of the tick.",
                          share, forced)};
}

TimePlot time_plot(const Recorded& recorded) {
  const Summary& s = recorded.summary;
  return {.id = "time",
          .plot = {.title = "Time inside the tick",
                   .x_label = "time / s",
                   .y_label = "tick / \u00b5s",
                   .series = {over_time(recorded.ticks, "tick", palpa::CurveColor::blue, Stroke::solid,
                                        [&](std::size_t i) { return recorded.ticks[i].tick_us; })}},
          .label = text("Time inside the tick: median %.1f \u00b5s, 99 %% below %.1f \u00b5s.", s.tick_p50_us, s.tick_p99_us),
          .caption =
              text("Median %.1f \u00b5s, 99 %% below %.1f \u00b5s, at most %.1f \u00b5s. A tick of 1 kHz has 1000 \u00b5s.%s",
                   s.tick_p50_us, s.tick_p99_us, s.tick_max_us,
                   was_in_real_time(recorded) ? ""
                                              : " This run was not in real time: a longer tick was interrupted by other "
                                                "programs, and no device missed a force.")};
}

/// Rows that represent all: `always`, and for each time interval its first row and the minimum and maximum of each series.
std::vector<std::size_t> rows_kept(const std::vector<Series>& series, std::size_t most_rows,
                                   const std::vector<std::size_t>& always) {
  const std::size_t count = series.front().xs.size();
  std::set<std::size_t> kept(always.begin(), always.end());
  const std::size_t parts = most_rows <= count ? std::max<std::size_t>(1, most_rows / (2 * series.size() + 1)) : count;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t begin = part * count / parts, end = (part + 1) * count / parts;
    if (begin == end) continue;
    kept.insert(begin);
    for (const Series& one : series) {
      const auto [lowest, highest] = std::minmax_element(one.ys.begin() + static_cast<std::ptrdiff_t>(begin),
                                                         one.ys.begin() + static_cast<std::ptrdiff_t>(end));
      kept.insert(static_cast<std::size_t>(lowest - one.ys.begin()));
      kept.insert(static_cast<std::size_t>(highest - one.ys.begin()));
    }
  }
  if (count > 0) kept.insert(count - 1);
  return {kept.begin(), kept.end()};
}

const char* name_of(palpa::CurveColor color) {
  switch (color) {
    case palpa::CurveColor::black: return "ink";
    case palpa::CurveColor::blue: return "blue";
    case palpa::CurveColor::vermilion: return "vermilion";
    case palpa::CurveColor::green: return "green";
    case palpa::CurveColor::purple: return "purple";
    case palpa::CurveColor::sky: return "sky";
    case palpa::CurveColor::orange: return "orange";
    case palpa::CurveColor::grey: break;
  }
  return "grey";
}

const char* name_of(Stroke stroke) {
  switch (stroke) {
    case Stroke::solid: break;
    case Stroke::dashed: return "dashed";
    case Stroke::dotted: return "dotted";
  }
  return "solid";
}

}  // namespace

std::vector<TimePlot> time_plots(const Recorded& recorded) {
  std::vector<TimePlot> plots{force_plot(recorded)};
  if (recorded.header.has_tool) plots.push_back(torque_plot(recorded));
  if (!recorded.modes.empty()) plots.push_back(modes_plot(recorded));
  plots.push_back(distance_plot(recorded));
  plots.push_back(energy_plot(recorded));
  if (recorded.header.has_octaves) plots.push_back(octave_plot(recorded));
  if (recorded.summary.tick_max_us > 0.0) plots.push_back(time_plot(recorded));
  return plots;
}

std::string json_of(const std::vector<TimePlot>& plots, std::size_t most_rows, const std::vector<std::size_t>& always) {
  Json all = Json::array();
  for (const TimePlot& one : plots) {
    const std::vector<Series>& series = one.plot.series;
    Json curves = Json::array();
    for (const Series& curve : series)
      curves.push_back({{"name", curve.name}, {"color", name_of(curve.color)}, {"stroke", name_of(curve.stroke)}});
    Json rows = Json::array();
    for (const std::size_t row : rows_kept(series, most_rows, always)) {
      Json values = Json::array({rounded(series.front().xs[row], 8)});
      for (const Series& curve : series) values.push_back(rounded(curve.ys[row], 4));
      rows.push_back(std::move(values));
    }
    all.push_back({{"id", one.id}, {"y", one.plot.y_label}, {"curves", curves}, {"rows", rows}});
  }
  return all.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace palpa::detail
