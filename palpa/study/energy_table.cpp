#include "palpa/study/energy_table.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "palpa/base/printed.h"
#include "palpa/study/summary.h"

namespace palpa {
namespace {

double sum_of(const std::vector<EnergyEntry>& entries) noexcept {
  double sum_j = 0.0;
  for (const EnergyEntry& entry : entries) sum_j += entry.energy_j;
  return sum_j;
}

/// Key of a mode: its name, unless taken by a fixed entry.
std::string key_of_mode(const std::string& name) {
  const bool taken = name == "let_go" || name == "damper" || name == "spring" || name == "elastic_levels";
  return taken ? "mode." + name : name;
}

std::string printed(double value, int decimals) {
  std::string text = detail::text("%.*f", decimals, value);
  if (text.front() == '-' && text.find_first_of("123456789") == std::string::npos) text.erase(0, 1);
  return text;
}

}  // namespace

double EnergyTable::in_j() const noexcept { return sum_of(in); }
double EnergyTable::out_j() const noexcept { return sum_of(out); }

EnergyTable energy_table(const Summary& s) {
  const Energy& e = s.energy;
  EnergyTable table;
  table.in = {{"hand", "hand", 0.0 - s.work_on_hand_j},
              {"guard_held_back", "withheld by the guard", 0.0 - s.withheld_j},
              {"data", "moving data", e.data_motion_j},
              {"ticks", "sampling (zero-order hold)", e.sampling_j}};
  std::int64_t breaks = 0;
  for (const ModeSummary& mode : s.modes) {
    table.out.push_back({key_of_mode(mode.name), mode.name, mode.dissipated_j - mode.injected_j});
    breaks += mode.break_throughs;
  }
  const std::string times = breaks == 1  ? " (1 break-through)"
                            : breaks > 0 ? " (" + std::to_string(breaks) + " break-throughs)"
                                         : "";
  table.out.push_back({"let_go", "released" + times, e.released_j});
  table.out.push_back({"damper", "damper", 0.0 - e.damper_j});
  table.out.push_back({"spring", "stored in the spring", e.stored_j});
  if (e.elastic_j > 0.0) table.out.push_back({"elastic_levels", "stored in elastic levels", e.elastic_j});
  table.sampling_gained_j = s.sampling_gained_j;
  table.sampling_bound_j = e.sampling_bound_j;
  if (s.gaining_m2_per_s > 0.0) table.covering_damping_ns_per_m = s.sampling_gained_j / s.gaining_m2_per_s;
  return table;
}

EnergyTable without_negative_entries(EnergyTable table) {
  std::vector<EnergyEntry> in, out;
  const auto sort = [](const std::vector<EnergyEntry>& from, std::vector<EnergyEntry>& same, std::vector<EnergyEntry>& other) {
    for (const EnergyEntry& entry : from) {
      if (entry.energy_j < 0.0) {
        other.push_back({entry.key, entry.label, -entry.energy_j});
      } else {
        same.push_back(entry);
      }
    }
  };
  sort(table.in, in, out);
  sort(table.out, out, in);
  table.in = std::move(in);
  table.out = std::move(out);
  return table;
}

std::string to_table(const EnergyTable& given) {
  const EnergyTable table = without_negative_entries(given);
  struct Line {
    std::string label, energy;
  };
  double largest_mj = 0.0;
  for (const auto* side : {&table.in, &table.out}) {
    for (const EnergyEntry& entry : *side) largest_mj = std::max(largest_mj, 1e3 * std::abs(entry.energy_j));
  }
  const int decimals = largest_mj >= 100.0 ? 1 : largest_mj >= 10.0 ? 2 : 3;
  const std::size_t rows = std::max(table.in.size(), table.out.size());
  const auto column = [&](const char* title, const std::vector<EnergyEntry>& entries) {
    std::vector<Line> lines{{title, "mJ"}};
    for (const EnergyEntry& entry : entries) lines.push_back({entry.label, printed(1e3 * entry.energy_j, decimals)});
    lines.resize(rows + 1);
    lines.push_back({"sum", printed(1e3 * sum_of(entries), decimals)});
    std::size_t label_width = 0, energy_width = 0;
    for (const Line& line : lines) {
      label_width = std::max(label_width, line.label.size());
      energy_width = std::max(energy_width, line.energy.size());
    }
    for (Line& line : lines) {
      line.label.resize(label_width, ' ');
      line.energy.insert(0, energy_width - line.energy.size(), ' ');
    }
    return lines;
  };
  const std::vector<Line> in = column("energy in", table.in), out = column("energy out", table.out);
  std::string text;
  for (std::size_t i = 0; i < in.size(); ++i) {
    std::string line = "  " + in[i].label + "  " + in[i].energy + "    " + out[i].label + "  " + out[i].energy;
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  const std::string gained = printed(1e3 * table.sampling_gained_j, decimals);
  if (gained.find_first_of("123456789") == std::string::npos) return text;
  double sampling_j = 0.0;
  for (const EnergyEntry& entry : given.in) sampling_j += entry.key == "ticks" ? entry.energy_j : 0.0;
  text += "  sampling: " + gained + " mJ added, " + printed(1e3 * (table.sampling_gained_j - sampling_j), decimals) +
          " mJ removed; bound k/2 sum |step|^2 = " + printed(1e3 * table.sampling_bound_j, decimals) +
          " mJ; passive if the hand adds damping b >= " + printed(table.covering_damping_ns_per_m, 3) + " N s/m\n";
  return text;
}

std::string to_json(const EnergyTable& table) {
  using Json = nlohmann::ordered_json;
  Json json;
  for (const EnergyEntry& entry : table.in) json["in"][entry.key] = entry.energy_j;
  for (const EnergyEntry& entry : table.out) json["out"][entry.key] = entry.energy_j;
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace palpa
