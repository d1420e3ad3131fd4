#include "palpa/report/recorded.h"

#include <toml++/toml.h>

#include <algorithm>
#include <span>

#include "palpa/base/limits.h"
#include "palpa/base/toml_problem.h"
#include "palpa/base/wording.h"
#include "palpa/trace/rows.h"

namespace palpa::detail {
namespace {

namespace fs = std::filesystem;

/// Index of a tick's number in `ticks` (ascending); their size if missing.
std::size_t index_of(const std::vector<TickFrame>& ticks, std::int64_t number) {
  const auto found = std::lower_bound(ticks.begin(), ticks.end(), number,
                                      [](const TickFrame& frame, std::int64_t wanted) { return frame.tick < wanted; });
  return found != ticks.end() && found->tick == number ? static_cast<std::size_t>(found - ticks.begin()) : ticks.size();
}

void read_modes(const fs::path& folder, Recorded& recorded) {
  const std::vector<std::string> names{"tick",         "mode",       "force_x_n",  "force_y_n",   "force_z_n",
                                       "dissipated_j", "injected_j", "primitives", "split_shared"};
  each_row(folder / "modes.csv", names, [&](const Row& row) {
    const std::string mode = row.text(1);
    auto known = std::find(recorded.modes.begin(), recorded.modes.end(), mode);
    if (known == recorded.modes.end()) {
      if (recorded.modes.size() == limit::modes.count()) row.refuse(1);
      recorded.modes.push_back(mode);
      recorded.pushes.emplace_back(recorded.ticks.size());
      known = recorded.modes.end() - 1;
    }
    const std::size_t tick = index_of(recorded.ticks, row.number<std::int64_t>(0));
    if (tick == recorded.ticks.size()) return true;
    recorded.pushes[static_cast<std::size_t>(known - recorded.modes.begin())][tick] = {.force_n = row.vector(2),
                                                                                       .dissipated_j = row.number<double>(5),
                                                                                       .injected_j = row.number<double>(6),
                                                                                       .primitives = row.number<int>(7),
                                                                                       .split_shared = row.number<int>(8) != 0};
    return true;
  });
}

/// Title, types of modes, and named levels of the scene's text; nothing if that is no TOML.
void read_scene(Recorded& recorded, std::vector<ModeSummary>& modes) {
  toml::table parsed;
  try {
    if (!problem_with_toml(recorded.scene_text)) parsed = toml::parse(std::string_view(recorded.scene_text));
  } catch (const toml::parse_error&) {
    return;
  }
  recorded.title = parsed["title"].value_or(std::string());
  const toml::array* tables = parsed["mode"].as_array();
  if (!tables) return;
  for (const toml::node& table : *tables) {
    const toml::node_view<const toml::node> mode{table};
    const std::string name = mode["name"].value_or(std::string());
    for (ModeSummary& known : modes) {
      if (known.name == name) known.type = mode["type"].value_or(std::string());
    }
    const toml::array* levels = mode["level"].as_array();
    if (!levels) continue;
    for (const toml::node& entry : *levels) {
      const toml::node_view<const toml::node> level{entry};
      const std::string called = level["name"].value_or(std::string());
      if (!called.empty()) recorded.levels.push_back({name, called, level["value"].value_or(0.0)});
    }
  }
}

/// Recorded events of a tick as session events, of the kinds that a summary counts.
std::vector<SessionEvent> session_events(const Recorded& recorded, std::size_t& next, std::int64_t tick) {
  std::vector<SessionEvent> events;
  for (; next < recorded.events.size() && recorded.events[next].tick <= tick; ++next) {
    const RecordedEvent& event = recorded.events[next];
    SessionEvent made;
    if (event.kind == "onset") {
      made.kind = SessionEventKind::onset;
    } else if (event.kind == "break_through") {
      made.kind = SessionEventKind::break_through;
    } else if (event.kind == "fault" && event.subject != "guard") {
      made.kind = SessionEventKind::fault;
    } else {
      continue;
    }
    const auto mode = std::find(recorded.modes.begin(), recorded.modes.end(), event.subject);
    if (mode != recorded.modes.end()) made.mode = static_cast<std::int32_t>(mode - recorded.modes.begin());
    events.push_back(made);
  }
  return events;
}

}  // namespace

LargestTorques largest_torques(const Recorded& recorded) noexcept {
  LargestTorques most;
  double coupling_at_s = 0.0;
  for (const TickFrame& frame : recorded.ticks) {
    if (const double nm = norm(frame.command.torque_nm); nm > most.on_hand_nm) {
      most.on_hand_nm = nm;
      most.at_s = frame.t_s;
    }
    if (const double nm = norm(frame.result.torque_nm); nm > most.coupling_nm) {
      most.coupling_nm = nm;
      coupling_at_s = frame.t_s;
    }
  }
  if (most.on_hand_nm == 0.0) most.at_s = coupling_at_s;
  return most;
}

Recorded read_recorded(const fs::path& folder) {
  const TraceReader reader(folder);
  Recorded recorded;
  recorded.header = reader.header();
  recorded.scene_text = reader.scene_text();
  recorded.has_energy = reader.has_energy();
  for (const TraceTick& tick : reader.ticks()) recorded.ticks.push_back(tick.frame);

  each_row(folder / "timing.csv", {"tick", "late_us", "tick_us", "device_us"}, [&](const Row& row) {
    const std::size_t tick = index_of(recorded.ticks, row.number<std::int64_t>(0));
    if (tick == recorded.ticks.size()) return true;
    recorded.ticks[tick].late_us = row.number<double>(1);
    recorded.ticks[tick].tick_us = row.number<double>(2);
    recorded.ticks[tick].device_us = row.number<double>(3);
    return true;
  });
  read_modes(folder, recorded);
  each_row(folder / "events.csv", {"tick", "t_s", "kind", "subject", "value"}, [&](const Row& row) {
    recorded.events.push_back({row.number<std::int64_t>(0), row.number<double>(1), row.text(2), row.text(3), row.text(4)});
    return true;
  });

  std::vector<ModeSummary> modes;
  for (const std::string& name : recorded.modes) modes.push_back({.name = name});
  read_scene(recorded, modes);
  SummaryBuilder builder(std::move(modes));
  std::vector<ModeForce> pushes(recorded.modes.size());
  std::size_t next_event = 0;
  double inside_s = 0.0;
  for (std::size_t i = 0; i < recorded.ticks.size(); ++i) {
    for (std::size_t m = 0; m < pushes.size(); ++m) pushes[m] = recorded.pushes[m][i];
    builder.add(recorded.ticks[i], pushes, session_events(recorded, next_event, recorded.ticks[i].tick));
    inside_s += 1e-6 * recorded.ticks[i].tick_us;
  }
  recorded.summary = builder.finish(inside_s);
  return recorded;
}

std::vector<std::vector<PlacedPrimitive>> recorded_primitives(const fs::path& folder, const Recorded& recorded,
                                                              std::span<const std::int64_t> ticks) {
  std::vector<std::vector<PlacedPrimitive>> all(ticks.size());
  std::size_t next = 0;
  std::int64_t sub_step = -1;
  std::vector<std::string> names{"tick",          "sub_step",     "mode",        "slot",        "kind",        "position_x_m",
                                 "position_y_m",  "position_z_m", "direction_x", "direction_y", "direction_z", "strength_n",
                                 "drag_ns_per_m", "force_x_n",    "force_y_n",   "force_z_n",   "state"};
  const std::size_t of_tool = names.size();
  if (recorded.header.has_tool) names.insert(names.end(), {"foot", "lever_x_m", "lever_y_m", "lever_z_m"});
  each_row(folder / "primitives.csv", names, [&](const Row& row) {
    const auto number = row.number<std::int64_t>(0);
    while (next < ticks.size() && ticks[next] < number) {
      ++next;
      sub_step = -1;
    }
    if (next == ticks.size()) return false;
    if (number != ticks[next]) return true;
    std::vector<PlacedPrimitive>& primitives = all[next];
    if (row.number<std::int64_t>(1) != sub_step) primitives.clear();
    sub_step = row.number<std::int64_t>(1);
    PlacedPrimitive placed;
    Primitive& primitive = placed.primitive;
    const auto mode = std::find(recorded.modes.begin(), recorded.modes.end(), row.text(2));
    primitive.id = {static_cast<std::uint16_t>(mode - recorded.modes.begin()), row.number<std::uint16_t>(3)};
    const auto named = [&](auto& value, std::size_t column, std::initializer_list<std::decay_t<decltype(value)>> known) {
      for (const auto one : known) {
        if (row.text(column) == name_of(one)) {
          value = one;
          return;
        }
      }
      row.refuse(column);
    };
    named(primitive.kind, 4,
          {PrimitiveKind::point, PrimitiveKind::line, PrimitiveKind::plane, PrimitiveKind::directed, PrimitiveKind::corner});
    primitive.position_m = row.vector(5);
    primitive.direction = row.vector(8);
    primitive.strength_n = row.number<double>(11);
    primitive.drag_ns_per_m = row.number<double>(12);
    placed.force_n = row.vector(13);
    named(placed.state, 16, {PrimitiveState::stick, PrimitiveState::slip, PrimitiveState::off});
    if (recorded.header.has_tool) {
      primitive.id.foot = row.number<std::uint16_t>(of_tool);
      placed.lever_m = row.vector(of_tool + 1);
    }
    primitives.push_back(placed);
    return true;
  });
  return all;
}

}  // namespace palpa::detail
