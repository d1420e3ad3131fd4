#include "palpa/trace/columns.h"

#include <type_traits>
#include <utility>

#include "palpa/trace/csv.h"
#include "palpa/trace/trace.h"

namespace palpa {

namespace {
const char* name_in(std::initializer_list<const char*> names, std::size_t i) noexcept {
  return i < names.size() ? names.begin()[i] : "?";
}
}  // namespace

const char* name_of(TickStatus status) noexcept {
  return name_in({"resting", "waiting", "capped", "bad_input"}, static_cast<std::size_t>(status));
}
const char* name_of(Stop stop) noexcept {
  return name_in({"full", "event", "release", "energy", "cap"}, static_cast<std::size_t>(stop));
}
const char* name_of(SessionEventKind kind) noexcept {
  return name_in({"onset", "break_through", "fault", "warning"}, static_cast<std::size_t>(kind));
}

namespace detail {
namespace {

template <class Value>
concept Named = requires(Value value) { name_of(value); };

using Cells = std::span<const std::string_view>;

template <class Value>
void put(std::string& line, const Value& value) {
  if constexpr (std::is_same_v<Value, Vec3>) {
    put_number(line, value.x);
    line += ',';
    put_number(line, value.y);
    line += ',';
    put_number(line, value.z);
  } else if constexpr (std::is_same_v<Value, Turn>) {
    put_number(line, value.w);
    line += ',';
    put(line, Vec3{value.x, value.y, value.z});
  } else if constexpr (std::is_same_v<Value, bool>) {
    line += value ? '1' : '0';
  } else if constexpr (std::is_same_v<Value, std::string_view>) {
    put_text(line, value);
  } else if constexpr (std::is_same_v<Value, std::optional<double>> || std::is_same_v<Value, std::optional<std::int64_t>>) {
    if (value) put_number(line, *value);
  } else if constexpr (Named<Value>) {
    line += name_of(value);
  } else {
    put_number(line, value);
  }
}

template <class Value>
bool take(Cells cells, Value& value) {
  if constexpr (std::is_same_v<Value, Vec3>) {
    return take_number(cells[0], value.x) && take_number(cells[1], value.y) && take_number(cells[2], value.z);
  } else if constexpr (std::is_same_v<Value, Turn>) {
    return take_number(cells[0], value.w) && take_number(cells[1], value.x) && take_number(cells[2], value.y) &&
           take_number(cells[3], value.z);
  } else if constexpr (std::is_same_v<Value, bool>) {
    value = cells[0] == "1";
    return value || cells[0] == "0";
  } else if constexpr (Named<Value>) {
    for (std::underlying_type_t<Value> i = 0; std::string_view(name_of(Value{i})) != "?"; ++i) {
      value = Value{i};
      if (cells[0] == name_of(value)) return true;
    }
    return false;
  } else {
    return take_number(cells[0], value);
  }
}

template <class Value>
constexpr int cells_of = std::is_same_v<Value, Vec3>   ? 3
                         : std::is_same_v<Value, Turn> ? 4
                                                       : 1;

// `Get` is a lambda from a row to its member; rows that are only written hold const values.
template <class Row, class Get>
Column<Row> column(std::string_view name, std::string_view unit, std::string_view meaning, Get) {
  using Value = std::remove_reference_t<std::invoke_result_t<Get, Row&>>;
  Column<Row> made{.name = name,
                   .unit = unit,
                   .meaning = meaning,
                   .cells = cells_of<std::remove_const_t<Value>>,
                   .later = false,
                   .of = nullptr,
                   .write = [](const Row& row, std::string& line) { put(line, Get{}(row)); },
                   .read = nullptr};
  if constexpr (std::is_same_v<Row, TickFrame>) made.read = [](Cells cells, Row& row) { return take(cells, Get{}(row)); };
  return made;
}

// Column missing in the first traces.
template <class Row>
Column<Row> later(Column<Row> column) {
  column.later = true;
  return column;
}

// Column of a tool with an orientation.
template <class Row>
Column<Row> of_tool(Column<Row> column) {
  column.later = true;
  column.of = &TraceKind::has_tool;
  return column;
}

// Column of volumes larger than memory.
template <class Row>
Column<Row> of_octaves(Column<Row> column) {
  column.later = true;
  column.of = &TraceKind::has_octaves;
  return column;
}

// Column with the value `row.MEMBER`.
#define COLUMN(ROW, NAME, UNIT, MEMBER, MEANING) column<ROW>(NAME, UNIT, MEANING, [](auto& row) -> auto& { return row.MEMBER; })

}  // namespace

std::vector<std::string> cell_names(std::string_view name, std::string_view unit, int cells) {
  if (cells == 1) return {std::string(name)};
  const std::string end = unit.empty() ? std::string() : "_" + std::string(unit);
  std::vector<std::string> names;
  if (cells == 4) names.push_back(std::string(name) + "_w" + end);
  for (const char* axis : {"_x", "_y", "_z"}) names.push_back(std::string(name) + axis + end);
  return names;
}

const Table<TickFrame>& ticks_table() {
  static const Column<TickFrame> columns[] = {
      COLUMN(TickFrame, "tick", "", tick, "number of the tick, from 0"),
      COLUMN(TickFrame, "t_s", "", t_s, "time since the session began"),
      COLUMN(TickFrame, "dt_s", "", dt_s, "time step that the session was given"),
      COLUMN(TickFrame, "probe", "m", result.probe_m, "the hand's point, as the device reports it"),
      COLUMN(TickFrame, "probe_velocity", "m_per_s", result.probe_velocity_m_per_s, "its velocity"),
      COLUMN(TickFrame, "probe_valid", "", result.probe_valid, "1: the device knew where it was"),
      COLUMN(TickFrame, "proxy", "m", result.proxy_m, "the probe's partner in the data"),
      COLUMN(TickFrame, "proxy_velocity", "m_per_s", result.proxy_velocity_m_per_s, "its velocity, as the damper sees it"),
      COLUMN(TickFrame, "force", "n", result.force_n, "Eq. 1, unlimited"),
      COLUMN(TickFrame, "command", "n", command.force_n, "what was sent to the device: the force after the guard"),
      COLUMN(TickFrame, "error_bound_m", "", result.error_bound_m, "proven error of the balance, worst of the sub-steps"),
      COLUMN(TickFrame, "sub_steps", "", result.sub_steps, "balances along the proxy's path"),
      COLUMN(TickFrame, "iterations", "", result.iterations, "of the law, over all sub-steps"),
      COLUMN(TickFrame, "status", "", result.status, "resting, waiting, capped or bad_input"),
      COLUMN(TickFrame, "dropped", "", result.dropped, "primitives that were refused"),
      COLUMN(TickFrame, "stored_j", "", result.energy.stored_j, "energy in the coupling's spring after the tick"),
      COLUMN(TickFrame, "dissipated_j", "", result.energy.dissipated_j, "taken out by modes"),
      COLUMN(TickFrame, "injected_j", "", result.energy.injected_j, "brought in by modes"),
      COLUMN(TickFrame, "path_j", "", result.energy.path_and_release_j, "price of walking the path in sub-steps"),
      COLUMN(TickFrame, "damper_j", "", result.energy.damper_j, "work on the hand of the held damper force, and of what waits"),
      COLUMN(TickFrame, "moved_j", "", result.energy.data_motion_j, "work of the data's own motion"),
      COLUMN(TickFrame, "work_on_hand_j", "", command.work_on_hand_j,
             "work on the hand of the command that was held since the last tick"),
      COLUMN(TickFrame, "guard", "", command.guard,
             "pass, limited, fault, waiting, ramp, damped, falling or off (docs/safety.md)"),
      COLUMN(TickFrame, "buttons", "", buttons, "pressed buttons, one bit each"),
      later(COLUMN(TickFrame, "let_go_j", "", result.energy.released_j,
                   "lost by the spring where the proxy went further than hand and data took it")),
      later(COLUMN(TickFrame, "held_back_j", "", command.withheld_j, "work on the hand that the guard withheld")),
      later(COLUMN(TickFrame, "ticks_j", "", result.energy.sampling_j, "brought in by holding the force for a tick")),
      later(COLUMN(TickFrame, "ticks_bound_j", "", result.energy.sampling_bound_j, "k/2 of the probe's step, squared")),
      later(COLUMN(TickFrame, "elastic_j", "", result.energy.elastic_j, "energy in elastic levels after the tick")),
      later(COLUMN(TickFrame, "guard_cause", "", command.cause, "why the guard lets nothing or less through, else none")),
      later(COLUMN(
          TickFrame, "circumstances", "", circumstances,
          "what the loop knew, one bit each from 1 on: device fault, link lost, late, view moves, panic, resume, new scene")),
      of_octaves(COLUMN(TickFrame, "felt_octave", "", result.felt_octave,
                        "of volumes larger than memory: 0 the finest, between n and n + 1 a blend of both")),
      of_octaves(COLUMN(TickFrame, "forced_octave", "", result.forced_octave,
                        "1: it was raised at once, since the windows would not have held this tick's way")),
      of_tool(COLUMN(TickFrame, "probe_turn", "", result.probe_turn,
                     "orientation of the handle, a unit quaternion, as the device reports it")),
      of_tool(COLUMN(TickFrame, "proxy_turn", "", result.proxy_turn, "that of the tool in the data")),
      of_tool(COLUMN(TickFrame, "torque", "nm", result.torque_nm, "about the probe, unlimited")),
      of_tool(COLUMN(TickFrame, "command_torque", "nm", command.torque_nm, "sent to the device: the torque after the guard")),
      of_tool(COLUMN(TickFrame, "unfelt_j", "", command.unfelt_j,
                     "brought in by turning a handle that is sensed and not driven: work that the torque did not draw")),
  };
  static const Table<TickFrame> table{"ticks.csv", "One row per tick.", columns};
  return table;
}

const Table<ModeRow>& modes_table() {
  static const Column<ModeRow> columns[] = {
      COLUMN(ModeRow, "tick", "", tick, "number of the tick"),
      COLUMN(ModeRow, "mode", "", mode, "name of the mode in the scene"),
      COLUMN(ModeRow, "force", "n", result.force_n,
             "on the proxy, in the last sub-step, in the least split; above 1 mN the mode is in contact"),
      COLUMN(ModeRow, "dissipated_j", "", result.dissipated_j, "taken out in this tick"),
      COLUMN(ModeRow, "injected_j", "", result.injected_j, "brought in in this tick"),
      COLUMN(ModeRow, "primitives", "", result.primitives, "in the last sub-step"),
      COLUMN(ModeRow, "split_shared", "", result.split_shared, "1: redundant with others, other splits would balance too"),
  };
  static const Table<ModeRow> table{"modes.csv", "Who pushes: one row per tick and mode, modes in the scene's order.", columns};
  return table;
}

const Table<BalanceRow>& balances_table() {
  static const Column<BalanceRow> columns[] = {
      COLUMN(BalanceRow, "tick", "", tick, "number of the tick"),
      COLUMN(BalanceRow, "sub_step", "", number, "number of the sub-step in its tick, from 0"),
      COLUMN(BalanceRow, "dt_s", "", step.time_step_s, "time that the hand took for the piece of path walked"),
      COLUMN(BalanceRow, "start", "m", step.start_m, "the proxy before the sub-step"),
      COLUMN(BalanceRow, "probe", "m", step.probe_m, "the probe that the balance was solved for"),
      COLUMN(BalanceRow, "k_n_per_m", "", step.stiffness_n_per_m, "stiffness of the coupling"),
      COLUMN(BalanceRow, "directed", "n", step.directed_n, "sum of the directed forces"),
      COLUMN(BalanceRow, "balance", "m", step.balance.position_m, "the minimiser: where all forces cancel"),
      COLUMN(BalanceRow, "error_bound_m", "", step.balance.error_bound_m, "proven distance to the exact balance"),
      COLUMN(BalanceRow, "stage", "", step.balance.stage, "stage of the law that answered; 0: nothing to solve"),
      COLUMN(BalanceRow, "iterations", "", step.balance.iterations, "proofs and Newton steps, over all stages"),
      COLUMN(BalanceRow, "status", "", step.balance.status, "exact, capped, bad_input or baseline"),
      COLUMN(BalanceRow, "primitives", "", step.primitives, "how many were in the balance"),
      COLUMN(BalanceRow, "move_fraction", "", step.move_fraction, "proxy = start + move_fraction * (balance - start)"),
      COLUMN(BalanceRow, "stop", "", step.stop, "why the proxy went no further: full, event, release, energy or cap"),
      COLUMN(BalanceRow, "proxy", "m", step.proxy_m, "the proxy after the sub-step"),
      COLUMN(BalanceRow, "energy_before_j", "", step.energy_before_j, "spring energy less directed work, at the start"),
      COLUMN(BalanceRow, "energy_after_j", "", step.energy_after_j, "the same after the sub-step"),
      of_tool(COLUMN(BalanceRow, "start_turn", "", step.start_turn, "the tool's orientation before the sub-step")),
      of_tool(COLUMN(BalanceRow, "probe_turn", "", step.probe_turn, "the orientation that the balance was solved for")),
      of_tool(COLUMN(BalanceRow, "turn", "rad", step.balance.turn_rad, "rotation vector from the start to the minimiser")),
      of_tool(COLUMN(BalanceRow, "proxy_turn", "", step.proxy_turn, "the tool's orientation after the sub-step")),
      of_tool(COLUMN(BalanceRow, "turning_radius_m", "", step.turning_radius_m,
                     "the stiffness against turning is k_n_per_m times its square")),
  };
  static const Table<BalanceRow> table{"balances.csv", "With `--primitives`: one row per tick and sub-step.", columns};
  return table;
}

const Table<PrimitiveRow>& primitives_table() {
  static const Column<PrimitiveRow> columns[] = {
      COLUMN(PrimitiveRow, "tick", "", tick, "number of the tick"),
      COLUMN(PrimitiveRow, "sub_step", "", sub_step, "number of the sub-step in its tick, from 0"),
      COLUMN(PrimitiveRow, "mode", "", mode, "name of the mode that placed it"),
      COLUMN(PrimitiveRow, "slot", "", placed.primitive.id.slot, "the mode's own number of it"),
      COLUMN(PrimitiveRow, "kind", "", placed.primitive.kind,
             "point, line, plane, directed or facet: a plane of a corner, whose rows have one slot and one strength"),
      COLUMN(PrimitiveRow, "position", "m", placed.primitive.position_m, "where it is"),
      COLUMN(PrimitiveRow, "direction", "", placed.primitive.direction, "unit vector; unused by a point"),
      COLUMN(PrimitiveRow, "strength_n", "", placed.primitive.strength_n, "the most that it can hold"),
      COLUMN(PrimitiveRow, "drag_ns_per_m", "", placed.primitive.drag_ns_per_m, "viscous part"),
      COLUMN(PrimitiveRow, "captured_value", "", captured_value, "the level that a plane stands on; empty: none"),
      COLUMN(PrimitiveRow, "force", "n", placed.force_n, "on the proxy; the law's split, where several share one of many"),
      COLUMN(PrimitiveRow, "state", "", placed.state, "stick, slip or off"),
      COLUMN(PrimitiveRow, "stiffness_n_per_m", "", stiffness_n_per_m, "of an elastic level; empty: rigid"),
      COLUMN(PrimitiveRow, "friction_coefficient", "", friction_coefficient,
             "of Coulomb friction: strength_n is that times the force of its plane; empty: none"),
      COLUMN(PrimitiveRow, "friction_plane", "", friction_plane, "slot of that plane, of the same mode and foot; empty: none"),
      COLUMN(PrimitiveRow, "rides", "", placed.rides,
             "1: it lies where its foot began the sub-step, carried along by moving data, and so goes with the proxy"),
      of_tool(COLUMN(PrimitiveRow, "foot", "", placed.primitive.id.foot, "number of the foot on which it acts, from 0")),
      of_tool(COLUMN(PrimitiveRow, "lever", "m", placed.lever_m, "from the proxy to that foot, at the start of the sub-step")),
  };
  static const Table<PrimitiveRow> table{"primitives.csv", "With `--primitives`: one row per tick, sub-step and primitive.",
                                         columns};
  return table;
}

const Table<WorkRow>& works_table() {
  static const Column<WorkRow> columns[] = {
      COLUMN(WorkRow, "tick", "", tick, "number of the tick"),
      COLUMN(WorkRow, "sub_step", "", sub_step, "number of the sub-step in its tick, from 0"),
      COLUMN(WorkRow, "mode", "", mode, "name of the mode that placed the primitive"),
      COLUMN(WorkRow, "slot", "", placed.primitive.id.slot, "the mode's own number of it"),
      COLUMN(WorkRow, "carried", "m", placed.carried_m, "how far the data carry the proxy in the whole sub-step"),
      COLUMN(WorkRow, "work_j", "", work_j,
             "force . (proxy - start - move_fraction * carried), of a tool with turn x lever added to proxy - start, turn the "
             "rotation "
             "vector from start_turn to proxy_turn: above zero brought in, below taken out"),
  };
  static const Table<WorkRow> table{
      "works.csv",
      "With `--primitives`, where data move: one row for each row of `primitives.csv` whose data carried the proxy.", columns};
  return table;
}

const Table<EventRow>& events_table() {
  static const Column<EventRow> columns[] = {
      COLUMN(EventRow, "tick", "", tick, "the first tick that it holds for"),
      COLUMN(EventRow, "t_s", "", t_s, "time of that tick"),
      COLUMN(EventRow, "kind", "", kind,
             "set, enable, swap, map, clutch, onset, break_through, snap, fault, guard, lost_ticks, lost_rows or warning"),
      COLUMN(EventRow, "subject", "", subject, "who: a mode's name, `session`, or the guard's new state"),
      COLUMN(EventRow, "value", "", value,
             "onset, break_through: the level; snap: by how many newtons the force would have stepped; else what happened"),
  };
  static const Table<EventRow> table{"events.csv", "What happened: one row per event.", columns};
  return table;
}

const Table<BreakThroughRow>& break_throughs_table() {
  static const Column<BreakThroughRow> columns[] = {
      COLUMN(BreakThroughRow, "tick", "", tick, "number of the tick"),
      COLUMN(BreakThroughRow, "t_s", "", t_s, "time of that tick"),
      COLUMN(BreakThroughRow, "mode", "", mode, "name of the mode whose level gave way"),
      COLUMN(BreakThroughRow, "level", "", event.value, "the level, in the field's own unit"),
      COLUMN(BreakThroughRow, "depth_m", "", event.depth_m, "|proxy - probe| where its strength was reached"),
  };
  static const Table<BreakThroughRow> table{
      "break_throughs.csv", "Where levels gave way: one row for each time, how deep it had been pressed.", columns};
  return table;
}

const Table<TickFrame>& timing_table() {
  static const Column<TickFrame> columns[] = {
      COLUMN(TickFrame, "tick", "", tick, "number of the tick"),
      COLUMN(TickFrame, "late_us", "", late_us, "how late the tick began; 0 on a simulated clock"),
      COLUMN(TickFrame, "tick_us", "", tick_us, "time inside the session's tick"),
      COLUMN(TickFrame, "device_us", "", device_us, "time inside the device's read and write"),
  };
  static const Table<TickFrame> table{"timing.csv", "One row per tick: the only file that may differ between two runs.",
                                      columns};
  return table;
}

const Table<WindowRow>& windows_table() {
  static const Column<WindowRow> columns[] = {
      COLUMN(WindowRow, "tick", "", tick, "number of the tick before which it was laid"),
      COLUMN(WindowRow, "volume", "", volume, "name of the volume in the scene"),
      COLUMN(WindowRow, "field", "", field, "name of its field"),
      COLUMN(WindowRow, "octave", "", place.octave, "0 the finest"),
      COLUMN(WindowRow, "first_i", "", place.first[0], "first voxel of the window in the octave as it is sampled"),
      COLUMN(WindowRow, "first_j", "", place.first[1], ""),
      COLUMN(WindowRow, "first_k", "", place.first[2], ""),
      COLUMN(WindowRow, "voxels_i", "", place.dims[0], "number of its voxels"),
      COLUMN(WindowRow, "voxels_j", "", place.dims[1], ""),
      COLUMN(WindowRow, "voxels_k", "", place.dims[2], ""),
      COLUMN(WindowRow, "frame", "", frame, "number of the frame of a series, else 0"),
  };
  static const Table<WindowRow> table{"windows.csv",
                                      "Of volumes larger than memory, felt live: one row for each window that came.", columns};
  return table;
}

const Table<ChunkRow>& chunks_table() {
  static const Column<ChunkRow> columns[] = {
      COLUMN(ChunkRow, "octave", "", sum.octave, "0 the finest"),
      COLUMN(ChunkRow, "i", "", sum.at[0], "number of the chunk along i"),
      COLUMN(ChunkRow, "j", "", sum.at[1], ""),
      COLUMN(ChunkRow, "k", "", sum.at[2], ""),
      COLUMN(ChunkRow, "crc32", "", sum.crc32, "of its voxels within the octave, when it was first read"),
      COLUMN(ChunkRow, "volume", "", volume, "name of the volume in the scene"),
      COLUMN(ChunkRow, "field", "", field, "name of its field"),
      COLUMN(ChunkRow, "frame", "", frame, "number of the frame of a series, else 0"),
  };
  static const Table<ChunkRow> table{
      "chunks.csv",
      "Of volumes larger than memory: one row for each chunk that was read, in any order. A replay ends where one has changed.",
      columns};
  return table;
}

#undef COLUMN

namespace {

template <class Row>
void describe(const Table<Row>& table, std::string& out) {
  constexpr const char* head = "\n\n| column | meaning |\n|---|---|\n";
  out += "## " + std::string(table.file) + "\n\n" + table.contents + head;
  bool TraceKind::* of = nullptr;
  for (const Column<Row>& column : table.columns) {
    if (column.of != std::exchange(of, column.of))
      out += std::string(of == &TraceKind::has_tool ? "\nOf a [tool](scene.md) with an orientation also:"
                                                    : "\nOf a [volume larger than memory](large.md) also:") +
             head;
    out += "| ";
    bool first = true;
    for (const std::string& name : cell_names(column.name, column.unit, column.cells)) {
      out += std::string(first ? "" : ", ") + "`" + name + "`";
      first = false;
    }
    out += " | " + std::string(column.meaning) + " |\n";
  }
  out += '\n';
}

}  // namespace
}  // namespace detail

std::string trace_reference_markdown() {
  std::string out;
  detail::describe(detail::ticks_table(), out);
  detail::describe(detail::modes_table(), out);
  detail::describe(detail::balances_table(), out);
  detail::describe(detail::primitives_table(), out);
  detail::describe(detail::works_table(), out);
  detail::describe(detail::events_table(), out);
  detail::describe(detail::break_throughs_table(), out);
  detail::describe(detail::windows_table(), out);
  detail::describe(detail::chunks_table(), out);
  detail::describe(detail::timing_table(), out);
  out.pop_back();
  return out;
}

}  // namespace palpa
