#include "palpa/report/report.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <optional>
#include <system_error>

#include "palpa/baseline/law.h"
#include "palpa/mode/plugin.h"
#include "palpa/report/html.h"
#include "palpa/report/recorded.h"
#include "palpa/report/words.h"
#include "palpa/study/recorded_scene.h"
#include "palpa/tick/session.h"
#include "palpa/version.h"
#include "palpa/view/plot.h"
#include "palpa/view/scene_picture.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;
using namespace detail;

constexpr std::size_t most_events = 50;

/// Black on white on paper and by day, light on dark by night; plots and pictures keep their white card. Wide
/// things scroll by themselves, so that a phone shows text at its own width.
constexpr const char* style = R"css(
:root { color-scheme: light dark; --ink: #1b1b1b; --soft: #5c5c5c; --paper: #ffffff; --line: #d5d5d5; --band: #f4f4f2; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8e6e3; --soft: #a8a6a3; --paper: #17191c; --line: #3b3f45; --band: #212429; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1rem 1rem 3rem; max-width: 56rem; background: var(--paper); color: var(--ink);
  font: 1rem/1.5 system-ui, "Helvetica Neue", Arial, sans-serif; overflow-wrap: anywhere; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 1rem 0 0.25rem; }
h2 { font-size: 1.2rem; margin: 2rem 0 0.5rem; padding-top: 0.5rem; border-top: 1px solid var(--line); }
.soft { color: var(--soft); }
.notice { border-left: 0.3rem solid #d55e00; background: var(--band); padding: 0.5rem 0.75rem; }
.felt li { margin: 0.2rem 0; }
figure { margin: 1rem 0; }
figure .card { background: #ffffff; border: 1px solid var(--line); border-radius: 0.4rem; overflow-x: auto; }
figure svg { display: block; width: 100%; min-width: 34rem; height: auto; }
figure img { display: block; width: 100%; height: auto; border-radius: 0.4rem; }
figcaption { color: var(--soft); font-size: 0.9rem; margin-top: 0.3rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 0.9rem; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: 0.3rem 0.6rem; border-bottom: 1px solid var(--line); vertical-align: top;
  overflow-wrap: normal; }
th { font-weight: 600; }
th.number, td.number { text-align: right; }
td.number { white-space: nowrap; }
tbody tr:nth-child(even) { background: var(--band); }
pre { background: var(--band); border: 1px solid var(--line); border-radius: 0.4rem; padding: 0.75rem; overflow-x: auto;
  font: 0.85rem/1.4 ui-monospace, "DejaVu Sans Mono", monospace; }
code { font-family: ui-monospace, "DejaVu Sans Mono", monospace; font-size: 0.85em; overflow-wrap: anywhere; }
@media print {
  :root { --ink: #000000; --soft: #444444; --paper: #ffffff; --line: #bbbbbb; --band: #f4f4f2; }
  body { max-width: none; padding: 0; font-size: 10pt; }
  figure, tr { break-inside: avoid; }
  h2 { break-after: avoid; }
  figure svg { min-width: 0; }
  pre { white-space: pre-wrap; overflow-wrap: anywhere; }
  .wide { overflow: visible; }
  table { font-size: 7.5pt; }
  th, td { padding: 0.15rem 0.3rem; overflow-wrap: anywhere; }
}
)css";

void write_file(const fs::path& file, const std::string& bytes) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  int error = descriptor < 0 ? errno : 0;
  for (std::size_t done = 0; error == 0 && done < bytes.size();) {
    const ssize_t wrote = ::write(descriptor, bytes.data() + done, bytes.size() - done);
    if (wrote >= 0) {
      done += static_cast<std::size_t>(wrote);
    } else if (errno != EINTR) {
      error = errno;
    }
  }
  if (descriptor >= 0 && ::close(descriptor) != 0 && error == 0) error = errno;
  if (error != 0) {
    throw LoadError(file.string() + ": cannot be written (" + std::generic_category().message(error) +
                    "); choose a place that can");
  }
}

/// A picture of the report as a file of its own, where that is asked for.
void keep(const ReportOptions& options, const char* name, const std::string& bytes) {
  if (!options.pictures.empty()) write_file(options.pictures / name, bytes);
}

/// A figure with a text for those who do not see it.
std::string figure(const std::string& content, const std::string& caption) {
  return "<figure>\n<div class=\"card\">" + content + "</div>\n<figcaption>" + escaped(caption) + "</figcaption>\n</figure>\n";
}

std::string image(const ReportOptions& options, const char* name, const Picture& picture, const std::string& alt,
                  const std::string& caption) {
  const std::string png = png_of(picture);
  keep(options, name, png);
  return figure("<img width=\"" + std::to_string(picture.width_px) + "\" height=\"" + std::to_string(picture.height_px) +
                    "\" alt=\"" + escaped(alt) + "\" src=\"" + png_address(png) + "\">",
                caption);
}

/// An SVG that says what it shows.
std::string labelled(const ReportOptions& options, const char* name, std::string svg, const std::string& label) {
  keep(options, name, svg);
  return svg.insert(4, " role=\"img\" aria-label=\"" + escaped(label) + "\"");
}

// The plots. All share the time axis and the marks.

std::vector<Mark> marks_of(const Recorded& recorded) {
  std::vector<Mark> marks;
  for (const RecordedEvent& event : recorded.events) {
    if (event.kind == "onset") marks.push_back({event.t_s, "onset"});
    if (event.kind == "break_through") marks.push_back({event.t_s, "break-through"});
    if (event.kind == "fault") marks.push_back({event.t_s, "fault"});
  }
  return marks;
}

template <class Value>
Series over_time(const Recorded& recorded, std::string name, Color color, Stroke stroke, Value value) {
  Series series{.name = std::move(name), .color = color, .stroke = stroke};
  series.xs.reserve(recorded.ticks.size());
  series.ys.reserve(recorded.ticks.size());
  for (std::size_t i = 0; i < recorded.ticks.size(); ++i) {
    series.xs.push_back(recorded.ticks[i].t_s);
    series.ys.push_back(value(i));
  }
  return series;
}

constexpr Color mode_colors[] = {Color::blue,   Color::vermilion, Color::green, Color::purple,
                                 Color::orange, Color::sky,       Color::black};

Plot force_plot(const Recorded& recorded) {
  const auto& ticks = recorded.ticks;
  return {.title = "Force",
          .x_label = "time / s",
          .y_label = "force / N",
          .series = {over_time(recorded, "spring (Eq. 1)", Color::sky, Stroke::solid,
                               [&](std::size_t i) { return norm(ticks[i].result.force_n); }),
                     over_time(recorded, "on the hand", Color::black, Stroke::dashed,
                               [&](std::size_t i) { return norm(ticks[i].command_n); })},
          .marks = marks_of(recorded)};
}

Plot modes_plot(const Recorded& recorded) {
  Plot plot{.title = "Force of each mode", .x_label = "time / s", .y_label = "force / N"};
  for (std::size_t m = 0; m < recorded.modes.size(); ++m) {
    constexpr Stroke strokes[] = {Stroke::solid, Stroke::dashed, Stroke::dotted};
    plot.series.push_back(over_time(recorded, recorded.modes[m], mode_colors[m % std::size(mode_colors)], strokes[m % 3],
                                    [&](std::size_t i) { return norm(recorded.pushes[m][i].force_n); }));
  }
  plot.marks = marks_of(recorded);
  return plot;
}

Sheet position_plots(const Recorded& recorded) {
  Sheet sheet;
  constexpr std::pair<const char*, double Vec3::*> axes[] = {
      {"x (right) / mm", &Vec3::x}, {"y (up) / mm", &Vec3::y}, {"z (to the user) / mm", &Vec3::z}};
  for (const auto& [label, axis] : axes) {
    const auto position = [&, axis = axis](const char* name, Color color, Stroke stroke, Vec3 Tick::*which) {
      return over_time(recorded, name, color, stroke,
                       [&, which, axis](std::size_t i) { return 1e3 * (recorded.ticks[i].result.*which).*axis; });
    };
    Plot plot{.title = sheet.panels.empty() ? "Probe and proxy" : "",
              .x_label = sheet.panels.size() == 2 ? "time / s" : "",
              .y_label = label,
              .series = {position("proxy", Color::vermilion, Stroke::solid, &Tick::proxy_m),
                         position("probe", Color::blue, Stroke::dashed, &Tick::probe_m)},
              .marks = marks_of(recorded)};
    sheet.panels.emplace_back(std::move(plot));
  }
  return sheet;
}

Plot energy_plot(const Recorded& recorded) {
  const auto sum = [&](double Energy::*entry) {
    std::vector<double> sums_mj;
    double sum_j = 0.0;
    for (const TickFrame& frame : recorded.ticks) sums_mj.push_back(1e3 * (sum_j += frame.result.energy.*entry));
    return sums_mj;
  };
  Plot plot{.title = "Energy", .x_label = "time / s", .y_label = "energy / mJ"};
  const auto cumulated = [&](const char* name, Color color, Stroke stroke, double Energy::*entry) {
    plot.series.push_back(over_time(recorded, name, color, stroke, [](std::size_t) { return 0.0; }));
    plot.series.back().ys = sum(entry);
  };
  cumulated("dissipated so far", Color::green, Stroke::solid, &Energy::dissipated_j);
  cumulated("injected so far", Color::vermilion, Stroke::dashed, &Energy::injected_j);
  plot.series.push_back(over_time(recorded, "stored in the spring", Color::blue, Stroke::dotted,
                                  [&](std::size_t i) { return 1e3 * recorded.ticks[i].result.energy.stored_j; }));
  plot.marks = marks_of(recorded);
  return plot;
}

Plot time_plot(const Recorded& recorded) {
  return {.title = "Time inside the tick",
          .x_label = "time / s",
          .y_label = "tick / \u00b5s",
          .series = {over_time(recorded, "tick", Color::blue, Stroke::solid,
                               [&](std::size_t i) { return recorded.ticks[i].tick_us; })},
          .marks = {}};
}

std::string plots(const Recorded& recorded, const ReportOptions& options) {
  const Summary& s = recorded.summary;
  std::string out = "<h2 id=\"plots\">Plots</h2>\n";
  out +=
      figure(labelled(options, "force.svg", svg_of(force_plot(recorded), 760, 280, "force-"),
                      text("Force over time: at most %.3f N on the hand.", s.force_max_n)),
             "The pull of the coupling before any limit, and what the guard let out to the hand. Signs on top: where a level "
             "set in or was broken through.");
  if (!recorded.modes.empty()) {
    out += figure(
        labelled(options, "modes.svg", svg_of(modes_plot(recorded), 760, 280, "modes-"), "Force of each mode over time."),
        "How hard each mode pushed the proxy. Above 1 mN a mode is in contact.");
  }
  out += figure(labelled(options, "position.svg", svg_of(position_plots(recorded), 760, 560, "position-"),
                         "Position of probe and proxy over time along three axes."),
                "Where the hand (probe) was and where the data held its partner (proxy), in the hand's frame. Their distance "
                "times the stiffness is the force.");
  out += figure(labelled(options, "energy.svg", svg_of(energy_plot(recorded), 760, 280, "energy-"),
                         text("Energy over time: %.3f mJ dissipated, %.3f mJ injected in all.", 1e3 * s.energy.dissipated_j,
                              1e3 * s.energy.injected_j)),
                "What the modes took out of the motion and brought in, summed up, and what the coupling's spring holds.");
  if (s.tick_max_us > 0.0) {
    out += figure(
        labelled(options, "time.svg", svg_of(time_plot(recorded), 760, 220, "time-"),
                 text("Time inside the tick: median %.1f \u00b5s, 99 %% below %.1f \u00b5s.", s.tick_p50_us, s.tick_p99_us)),
        text("Median %.1f \u00b5s, 99 %% below %.1f \u00b5s, at most %.1f \u00b5s. A tick of 1 kHz has 1000 \u00b5s.",
             s.tick_p50_us, s.tick_p99_us, s.tick_max_us));
  } else {
    out += "<p class=\"soft\">The time inside the tick was not measured.</p>\n";
  }
  return out;
}

// The pictures.

/// The tick to look at closely: most modes in contact, then the largest force.
std::optional<std::size_t> busiest_tick(const Recorded& recorded) {
  std::optional<std::size_t> best;
  std::pair<int, double> most{0, 0.0};
  for (std::size_t i = 0; i < recorded.ticks.size(); ++i) {
    int modes = 0;
    for (const auto& pushes : recorded.pushes) modes += norm(pushes[i].force_n) > contact_force_n;
    const std::pair<int, double> now{modes, norm(recorded.ticks[i].result.force_n)};
    if (modes > 0 && now > most) {
      most = now;
      best = i;
    }
  }
  return best;
}

/// The primitives of the chosen tick: as recorded, or felt again up to it.
Moment moment_at(const fs::path& trace, const Recorded& recorded, const Scene& scene, std::size_t chosen) {
  const Tick& tick = recorded.ticks[chosen].result;
  Moment moment{.probe_m = tick.probe_m,
                .proxy_m = tick.proxy_m,
                .primitives = {},
                .mode_names = recorded.modes,
                .time_s = recorded.ticks[chosen].t_s};
  if (recorded.header.primitives) {
    moment.primitives = recorded_primitives(trace, recorded, recorded.ticks[chosen].tick);
    return moment;
  }
  Session session(scene, baseline::law(scene), recorded.header.device_encoder_step_m);
  Vec3 proxy_m;
  for (std::size_t i = 0; i <= chosen; ++i) {
    const Tick& was = recorded.ticks[i].result;
    const Probe probe{.position_m = was.probe_m,
                      .velocity_m_per_s = was.probe_velocity_m_per_s,
                      .valid = was.probe_valid,
                      .buttons = recorded.ticks[i].buttons};
    proxy_m = session.tick(probe, recorded.ticks[i].dt_s).proxy_m;
  }
  constexpr double same_place_m = 1e-6;
  if (!(distance(proxy_m, tick.proxy_m) <= same_place_m)) {
    throw LoadError(trace.string() +
                    text(": felt again, the proxy is %.3g mm from where it was; ", 1e3 * distance(proxy_m, tick.proxy_m)) +
                    "record with --primitives, or use the palpa that recorded it");
  }
  if (!session.sub_steps().empty()) {
    const SubStep& last = session.sub_steps().back();
    const auto placed = session.placed().subspan(last.first_primitive, last.primitives);
    moment.primitives.assign(placed.begin(), placed.end());
  }
  return moment;
}

std::string pictures_of_moment(const fs::path& trace, const Recorded& recorded, const Scene& scene,
                               const std::vector<PathPoint>& path, const ReportOptions& options) {
  const std::optional<std::size_t> chosen = busiest_tick(recorded);
  if (!chosen) return "<p class=\"soft\">No mode pushed, so there is no moment to look at closely.</p>\n";
  const TickFrame& frame = recorded.ticks[*chosen];
  const Moment moment = moment_at(trace, recorded, scene, *chosen);
  const double reach_m = distance(moment.probe_m, moment.proxy_m);
  const Picture picture = scene_picture(scene, path, moment, close_up(scene, moment));
  std::string who;
  for (std::size_t m = 0; m < recorded.modes.size(); ++m) {
    const double force_n = norm(recorded.pushes[m][*chosen].force_n);
    if (force_n > contact_force_n) who += (who.empty() ? "" : ", ") + recorded.modes[m] + text(" %.2f N", force_n);
  }
  const std::string caption =
      text("The moment at %.3f s, in which most modes pushed and the force was largest: ", frame.t_s) + who +
      text("; the spring pulls with %.2f N, the proxy is %.2f mm from the probe. ", norm(frame.result.force_n), 1e3 * reach_m) +
      std::to_string(moment.primitives.size()) + (moment.primitives.size() == 1 ? " primitive." : " primitives.");
  return image(options, "moment.png", picture, "Close-up of probe, proxy and primitives. " + caption, caption);
}

std::string pictures(const fs::path& trace, const Recorded& recorded, const ReportOptions& options) {
  std::string out = "<h2 id=\"pictures\">Pictures</h2>\n";
  const auto refuse = [](const std::string& why) { return "<p class=\"notice\">No picture: " + escaped(why) + "</p>\n"; };
  std::optional<LoadedScene> loaded;
  try {
    if (options.plugins.empty() && !recorded.header.plugins.empty()) {
      throw LoadError((trace / "trace.toml").string() + ": was felt with the plug-in " + recorded.header.plugins.front() +
                      "; name it with --plugin if you trust it");
    }
    loaded = load_recorded_scene(trace, TraceReader(trace), options.data_folders, options.read, modes_with(options.plugins));
  } catch (const LoadError& error) {
    return out + refuse(error.what());
  }
  std::vector<PathPoint> path;
  for (const TickFrame& frame : recorded.ticks) {
    if (frame.result.probe_valid && is_finite(frame.result.probe_m)) {
      path.push_back({frame.result.probe_m, frame.result.proxy_m, frame.command_n, frame.result.force_n});
    }
  }
  try {
    out += image(options, "scene.png", scene_picture(loaded->scene, path, std::nullopt, overview(loaded->scene, path)),
                 "The scene with the path of the hand, coloured by force.",
                 "The scene as the user sees it, with the path of probe and proxy, coloured by force.");
  } catch (const LoadError& error) {
    out += refuse(error.what());
  }
  try {
    out += pictures_of_moment(trace, recorded, loaded->scene, path, options);
  } catch (const LoadError& error) {
    out += refuse(error.what());
  }
  return out;
}

// The tables.

std::string tables(const Recorded& recorded) {
  const Summary& s = recorded.summary;
  const auto count = [](std::int64_t number) { return grouped(number); };
  const auto percent = [](double share) { return text("%.1f %%", 100.0 * share); };
  const auto newtons = [](double force_n) { return text("%.3f N", force_n); };
  const auto millijoules = [](double energy_j) { return text("%.3f mJ", 1e3 * energy_j + 0.0); };

  std::string out = "<h2 id=\"summary\">Summary</h2>\n";
  out += table(
      {"what", "value"},
      {{"recorded", recorded.header.complete ? "completely" : "incomplete"},
       {"duration", text("%.3f s", s.duration_s)},
       {"ticks", count(s.ticks)},
       {"in contact", percent(s.contact_share) + " of the ticks"},
       {"force on the hand, mean in contact", newtons(s.force_mean_n)},
       {"force on the hand, largest", newtons(s.force_max_n)},
       {"first break-through", s.first_break_through_s < 0.0 ? "none" : text("%.3f s", s.first_break_through_s)},
       {"sub-steps per tick", text("mean %.2f, at most %d", s.sub_steps_mean, s.sub_steps_max)},
       {"worst proven error of a balance", text("%.2g m", s.error_bound_max_m)},
       {"tick time, median | 99 % | largest", text("%.1f | %.1f | %.1f \u00b5s", s.tick_p50_us, s.tick_p99_us, s.tick_max_us)},
       {"ticks waiting | capped | bad input",
        count(s.waiting_ticks) + " | " + count(s.capped_ticks) + " | " + count(s.bad_input_ticks)},
       {"ticks limited by the guard | faults", count(s.guard_limited_ticks) + " | " + count(s.faults)},
       {"primitives refused", count(s.dropped_primitives)},
       {"energy dissipated | injected", millijoules(s.energy.dissipated_j) + " | " + millijoules(s.energy.injected_j)},
       {"energy of walking in sub-steps | damper", millijoules(s.energy.path_j) + " | " + millijoules(s.energy.damper_j)},
       {"work of the data's own motion", millijoules(s.energy.moved_j)},
       {"energy stored at the end", millijoules(s.energy.stored_j)},
       {"work on the hand", millijoules(s.energy.work_on_hand_j)}},
      1);

  out += "<h2 id=\"modes\">Modes</h2>\n";
  std::vector<std::vector<std::string>> rows;
  for (const ModeSummary& mode : s.modes) {
    rows.push_back({mode.name, mode.type, percent(mode.contact_share), newtons(mode.force_mean_n), newtons(mode.force_max_n),
                    millijoules(mode.dissipated_j), millijoules(mode.injected_j), count(mode.onsets),
                    count(mode.break_throughs)});
  }
  out +=
      table({"mode", "type", "in contact", "mean force", "largest force", "dissipated", "injected", "onsets", "break-throughs"},
            rows, 2);

  out += "<h2 id=\"events\">Events</h2>\n";
  if (recorded.events.empty()) return out + "<p>None.</p>\n";
  rows.clear();
  for (std::size_t i = 0; i < std::min(most_events, recorded.events.size()); ++i) {
    const RecordedEvent& event = recorded.events[i];
    const bool at_level = event.kind == "onset" || event.kind == "break_through";
    rows.push_back({text("%.3f s", event.t_s), event.kind, at_level ? level_of(recorded, event) : event.subject,
                    at_level ? "" : event.value});
  }
  out += table({"time", "what", "where (values in the field's own unit)", "why"}, rows, 4);
  if (recorded.events.size() > most_events) {
    out += "<p class=\"soft\">The first " + std::to_string(most_events) + " of " +
           escaped(grouped(static_cast<long long>(recorded.events.size()))) + " events; all are in events.csv.</p>\n";
  }
  return out;
}

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : " ") + word;
  return all.empty() ? "none" : all;
}

std::string origin(const Recorded& recorded) {
  const TraceHeader& header = recorded.header;
  std::string out = "<h2 id=\"origin\">Origin</h2>\n";
  std::vector<std::string> sets, seeds;
  for (const auto& [path, value] : header.sets) sets.push_back(path + "=" + value);
  for (const std::uint64_t seed : header.seeds) seeds.push_back(std::to_string(seed));
  out += table({"what", "value"},
               {{"recorded by", "palpa " + header.palpa_version + ", trace format " + std::to_string(header.format)},
                {"reported by", std::string("palpa ") + version},
                {"arguments", joined(header.arguments)},
                {"settings", joined(sets)},
                {"plug-ins", joined(header.plugins)},
                {"seeds", joined(seeds)},
                {"time step", text("%g ms", 1e3 * header.dt_s)},
                {"device's limits",
                 text("%g N, %g N/m, radius %g m, encoder step %g m", header.device_max_force_n,
                      header.device_max_stiffness_n_per_m, header.device_workspace_radius_m, header.device_encoder_step_m)},
                {"world per hand", text("%g m per m", header.hand_to_world.scale)}},
               2);
  out += "<h2 id=\"files\">Data files</h2>\n";
  if (header.data_files.empty()) {
    out += "<p>None: the data are formulas.</p>\n";
  } else {
    std::vector<std::vector<std::string>> rows;
    for (const SourceFile& file : header.data_files) {
      rows.push_back({file.path, file.sha256, grouped(static_cast<long long>(file.bytes)) + " bytes"});
    }
    out += table({"file", "sha256", "size"}, rows, 2);
  }
  return out + "<h2 id=\"scene\">Scene</h2>\n<pre><code>" + escaped(recorded.scene_text) + "</code></pre>\n";
}

}  // namespace

std::string report_html(const fs::path& trace, const ReportOptions& options) {
  const Recorded recorded = read_recorded(trace);
  const std::string title = recorded.title.empty() ? "A trace without a title" : recorded.title;
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      escaped(title) + " \u2013 Palpa</title>\n<style>" + style + "</style>\n</head>\n<body>\n<main>\n<h1>" + escaped(title) +
      "</h1>\n<p class=\"soft\">Report of a trace, made by Palpa.</p>\n";
  if (!recorded.header.complete) {
    out += "<p class=\"notice\">This recording is incomplete. What follows is true of what there is.</p>\n";
  }
  out += "<h2 id=\"felt\">What was felt</h2>\n<ul class=\"felt\">\n";
  for (const std::string& sentence : words_of(recorded)) out += "<li>" + escaped(sentence) + "</li>\n";
  out += "</ul>\n";
  out += pictures(trace, recorded, options);
  if (!recorded.ticks.empty()) out += plots(recorded, options);
  return out + tables(recorded) + origin(recorded) + "</main>\n</body>\n</html>\n";
}

fs::path write_report(const fs::path& trace, const fs::path& out, const ReportOptions& options) {
  if (!options.pictures.empty()) {
    std::error_code error;
    fs::create_directories(options.pictures, error);
    if (error) throw LoadError(options.pictures.string() + ": cannot be made (" + error.message() + "); choose another folder");
  }
  const fs::path file = out.empty() ? trace / "report.html" : out;
  write_file(file, report_html(trace, options));
  return file;
}

}  // namespace palpa
