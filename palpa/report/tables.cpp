#include "palpa/report/tables.h"

#include <algorithm>

#include "palpa/data/volume.h"
#include "palpa/report/html.h"
#include "palpa/report/words.h"
#include "palpa/study/energy_table.h"
#include "palpa/version.h"

namespace palpa::detail {
namespace {

constexpr std::size_t most_events = 50;  // [1] listed. More: a longer page; fewer: the rest is only in events.csv

std::string count(std::int64_t number) { return grouped(number); }
std::string percent(double share) { return text("%.1f %%", 100.0 * share); }
std::string newtons(double force_n) { return text("%.3f N", force_n); }
std::string millinewton_metres(double torque_nm) { return text("%.3f mN\u00b7m", 1e3 * torque_nm); }
std::string millijoules(double energy_j) { return text("%.3f mJ", 1e3 * energy_j + 0.0); }

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : " ") + word;
  return all.empty() ? "none" : all;
}

/// Largest coupling force before limits.
double asked_max_n(const Recorded& recorded) {
  double most_n = 0.0;
  for (const TickFrame& frame : recorded.ticks) most_n = std::max(most_n, norm(frame.result.force_n));
  return most_n;
}

/// Files of one folder, such as the slices of a scan, share a row.
std::vector<std::vector<std::string>> rows_of_files(const std::vector<SourceFile>& files, const PathNames& names) {
  constexpr std::size_t most_files = 8;  // [1] of a folder, listed. More: a longer page; fewer: checksums are only in the trace
  std::vector<std::vector<std::string>> rows;
  const auto size = [](std::uint64_t bytes) { return grouped(static_cast<long long>(bytes)) + " bytes"; };
  for (std::size_t i = 0; i < files.size();) {
    const auto folder = [&](std::size_t n) { return std::filesystem::path(files[n].path).parent_path(); };
    std::size_t end = i;
    std::uint64_t bytes = 0;
    for (; end < files.size() && folder(end) == folder(i); ++end) bytes += files[end].bytes;
    if (end - i > most_files) {
      rows.push_back(
          {names.of_path(files[i].path) + " and " + std::to_string(end - i - 1) + " more", "in trace.toml", size(bytes)});
      i = end;
      continue;
    }
    for (; i < end; ++i) rows.push_back({names.of_path(files[i].path), files[i].sha256.text(), size(files[i].bytes)});
  }
  return rows;
}

}  // namespace

std::string summary_markup(const Recorded& recorded) {
  const Summary& s = recorded.summary;
  std::vector<std::vector<std::string>> rows{{"recorded", recorded.header.complete ? "completely" : "incomplete"},
                                             {"duration", text("%.3f s", s.duration_s)},
                                             {"ticks", count(s.ticks)},
                                             {"in contact", percent(s.contact_share) + " of the ticks"},
                                             {"force on the hand, mean in contact", newtons(s.force_mean_n)},
                                             {"force on the hand, largest", newtons(s.force_max_n)}};
  if (s.guard_limited_ticks > 0) rows.push_back({"force requested, largest, before the guard", newtons(asked_max_n(recorded))});
  if (recorded.header.has_tool) {
    const LargestTorques most = largest_torques(recorded);
    rows.push_back({"torque on the hand, largest",
                    most.on_hand_nm > 0.0 ? millinewton_metres(most.on_hand_nm) : "none: the device drives no torque"});
    rows.push_back({"torque of the coupling, largest, before the guard", millinewton_metres(most.coupling_nm)});
    if (s.unfelt_j != 0.0) rows.push_back({"energy brought in by turning, unfelt", millijoules(s.unfelt_j)});
  }
  for (std::vector<std::string> row : std::vector<std::vector<std::string>>{
           {"first break-through", s.first_break_through_s < 0.0 ? "none" : text("%.3f s", s.first_break_through_s)},
           {"sub-steps per tick", text("mean %.2f, at most %d", s.sub_steps_mean, s.sub_steps_max)},
           {"largest proven error of a balance", text("%.2g m", s.error_bound_max_m)},
           {was_in_real_time(recorded) ? "tick time, median | 99 % | largest"
                                       : "tick time, median | 99 % | largest (not in real time)",
            text("%.1f | %.1f | %.1f \u00b5s", s.tick_p50_us, s.tick_p99_us, s.tick_max_us)},
           {"ticks waiting | capped | bad input",
            count(s.waiting_ticks) + " | " + count(s.capped_ticks) + " | " + count(s.bad_input_ticks)},
           {"ticks limited by the guard | faults", count(s.guard_limited_ticks) + " | " + count(s.faults)},
           {"primitives refused", count(s.dropped_primitives)}}) {
    rows.push_back(std::move(row));
  }
  return table({"quantity", "value"}, rows, 1);
}

std::string energy_markup(const Recorded& recorded) {
  if (!recorded.has_energy) {
    return "<p>This recording is of an older version and lacks part of each tick's energy. <code>palpa replay --json</code> "
           "computes the table.</p>\n";
  }
  const EnergyTable energy = without_negative_entries(energy_table(recorded.summary));
  std::vector<std::vector<std::string>> rows(std::max(energy.in.size(), energy.out.size()), std::vector<std::string>(4));
  const auto fill = [&](const std::vector<EnergyEntry>& entries, std::size_t column) {
    for (std::size_t i = 0; i < entries.size(); ++i) {
      rows[i][column] = entries[i].label;
      rows[i][column + 1] = millijoules(entries[i].energy_j);
    }
  };
  fill(energy.in, 0);
  fill(energy.out, 2);
  rows.push_back({"sum", millijoules(energy.in_j()), "sum", millijoules(energy.out_j())});
  std::string out = "<div class=\"sums\">\n" + table({"in", "energy", "out", "energy"}, rows, 0) + "</div>\n";
  out +=
      "<p>The energy from the hand equals the energy dissipated by modes and damper, lost at releases, and stored in the "
      "spring.";
  if (energy.covering_damping_ns_per_m > 0.0) {
    out += text(
        " The zero-order hold of the force added energy, at most %.3f mJ: the interaction is passive if the hand adds at least "
        "%.3f N\u00b7s/m of damping.",
        1e3 * energy.sampling_bound_j, energy.covering_damping_ns_per_m);
  }
  if (recorded.summary.unfelt_j != 0.0) {
    out += " Turning the handle brought in " + millijoules(recorded.summary.unfelt_j) +
           " that the hand did not feel, since the device drives no torque: this is part of the energy withheld.";
  }
  return out + "</p>\n";
}

std::string modes_markup(const Recorded& recorded) {
  std::vector<std::vector<std::string>> rows;
  for (const ModeSummary& mode : recorded.summary.modes) {
    rows.push_back({mode.name, mode.type, percent(mode.contact_share), newtons(mode.force_mean_n), newtons(mode.force_max_n),
                    millijoules(mode.dissipated_j), millijoules(mode.injected_j), count(mode.onsets),
                    count(mode.break_throughs)});
  }
  std::string out =
      table({"mode", "type", "in contact", "mean force", "largest force", "dissipated", "injected", "onsets", "break-throughs"},
            rows, 2);
  if (recorded.summary.guard_limited_ticks > 0)
    out += "<p class=\"soft\">Forces of modes are those on the proxy; the guard's limit comes after them.</p>\n";
  return out;
}

std::string events_markup(const Recorded& recorded, const PathNames& names) {
  if (recorded.events.empty()) return "<p>None.</p>\n";
  const std::size_t shown = std::min(most_events, recorded.events.size());
  std::string out =
      "<div class=\"wide\"><table class=\"events\">\n<thead><tr><th scope=\"col\">time</th><th scope=\"col\">what</th>"
      "<th scope=\"col\">where (values in the field's own unit)</th><th scope=\"col\">why</th></tr></thead>\n<tbody>\n";
  for (std::size_t i = 0; i < shown; ++i) {
    const RecordedEvent& event = recorded.events[i];
    const bool at_level = event.kind == "onset" || event.kind == "break_through";
    out += text("<tr><td><a href=\"#view\" data-time=\"%.6f\">%.3f s</a></td><td>", event.t_s, event.t_s) +
           escaped(event.kind) + "</td><td>" + escaped(at_level ? level_of(recorded, event) : event.subject) + "</td><td>" +
           escaped(names.in_text(why_of(event))) + "</td></tr>\n";
  }
  out += "</tbody></table></div>\n";
  if (recorded.events.size() > shown) {
    out += "<p class=\"soft\">The first " + std::to_string(shown) + " of " +
           escaped(count(static_cast<std::int64_t>(recorded.events.size()))) + " events; all are in events.csv.</p>\n";
  }
  return out;
}

std::string origin_markup(const Recorded& recorded, const PathNames& names) {
  const TraceHeader& header = recorded.header;
  std::string out;
  std::vector<std::string> sets, seeds, arguments, plugins;
  for (const auto& [path, value] : header.sets) sets.push_back(names.of_argument(path + "=" + value));
  for (const std::string& argument : header.arguments) arguments.push_back(names.of_argument(argument));
  for (const std::string& plugin : header.plugins) plugins.push_back(names.of_path(plugin));
  for (const std::uint64_t seed : header.seeds) seeds.push_back(std::to_string(seed));
  out += table({"quantity", "value"},
               {{"recorded by", "palpa " + header.palpa_version + ", trace format " + std::to_string(header.format)},
                {"reported by", std::string("palpa ") + version},
                {"arguments", joined(arguments)},
                {"settings", joined(sets)},
                {"plug-ins", joined(plugins)},
                {"seeds", joined(seeds)},
                {"time step", text("%g ms", 1e3 * header.dt_s)},
                {"device", header.device_name.empty() ? "ideal" : names.of_argument(header.device_name)},
                {"device's limits",
                 text("%g N, %g N/m, radius %g m, encoder step %g m", header.device_max_force_n,
                      header.device_max_stiffness_n_per_m, header.device_workspace_radius_m, header.device_encoder_step_m)},
                {"world per hand", text("%g m per m", header.hand_to_world.scale)}},
               2);
  out += "<h3>Data files</h3>\n";
  if (header.data_files.empty()) {
    out += "<p>None: the data are formulas.</p>\n";
  } else {
    out += table({"file", "sha256", "size"}, rows_of_files(header.data_files, names), 2);
  }
  return out;
}

}  // namespace palpa::detail
