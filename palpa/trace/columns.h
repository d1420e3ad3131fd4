// Columns of a trace's files: one table for writing, reading, comparison and documentation.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/data/octaves.h"
#include "palpa/trace/trace.h"

namespace palpa::detail {

struct ModeRow {
  std::int64_t tick;
  std::string_view mode;
  const ModeForce& result;
};

struct BalanceRow {
  std::int64_t tick;
  std::int64_t number;  ///< of the sub-step in its tick, from 0
  const SubStep& step;
};

struct PrimitiveRow {
  std::int64_t tick;
  std::int64_t sub_step;
  std::string_view mode;
  const PlacedPrimitive& placed;
  std::optional<double> captured_value;
  std::optional<double> stiffness_n_per_m;
  std::optional<double> friction_coefficient;
  std::optional<std::int64_t> friction_plane;
};

struct WorkRow {
  std::int64_t tick;
  std::int64_t sub_step;
  std::string_view mode;
  const PlacedPrimitive& placed;
  double work_j;
};

struct EventRow {
  std::int64_t tick;
  double t_s;
  std::string_view kind;
  std::string_view subject;
  std::string_view value;
};

struct BreakThroughRow {
  std::int64_t tick;
  double t_s;
  std::string_view mode;
  const SessionEvent& event;
};

struct WindowRow {
  std::int64_t tick;
  std::string_view volume, field;
  const WindowPlace& place;
  int frame;
};

struct ChunkRow {
  std::string_view volume, field;
  const ChunkSum& sum;
  int frame;
};

/// Kinds of traces that have columns which others lack.
struct TraceKind {
  bool has_tool = false;     ///< of a tool with an orientation
  bool has_octaves = false;  ///< of a volume larger than memory
};

/// Column, or the three of a vector, or the four of a turn.
template <class Row>
struct Column {
  std::string_view name;     ///< a vector's without the unit
  std::string_view unit;     ///< of a vector, the suffix of its columns' names; a scalar's is in its name
  std::string_view meaning;  ///< for docs/trace.md
  int cells;                 ///< 1, 3 for a vector, 4 for a turn
  bool later;                ///< missing in the first traces, or of a kind of traces
  bool TraceKind::* of;      ///< only in traces of this kind, behind all others; nullptr: in all
  void (*write)(const Row& row, std::string& line);
  /// Parses the column's cells; false if invalid. Null for columns that are never read.
  bool (*read)(std::span<const std::string_view> cells, Row& row);
};

/// Names of a column's cells: NAME, or NAME_x_UNIT, NAME_y_UNIT, NAME_z_UNIT, or NAME_w, NAME_x, NAME_y, NAME_z.
std::vector<std::string> cell_names(std::string_view name, std::string_view unit, int cells);

/// File of a trace.
template <class Row>
struct Table {
  const char* file;
  const char* contents;  ///< one sentence
  std::span<const Column<Row>> columns;

  TraceKind kind{true, true};  ///< only columns of this kind are written

  Table of(TraceKind wanted) const { return {file, contents, columns, wanted}; }
  bool has(const Column<Row>& column) const { return !column.of || kind.*column.of; }
  /// Names of all cells of a row, in the order of writing.
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const Column<Row>& column : columns) {
      if (!has(column)) continue;
      for (std::string& name : cell_names(column.name, column.unit, column.cells)) all.push_back(std::move(name));
    }
    return all;
  }
  /// Whether recordings may lack this cell's column.
  bool is_later(std::string_view cell) const {
    for (const Column<Row>& column : columns) {
      if (!column.later) continue;
      const std::vector<std::string> cells = cell_names(column.name, column.unit, column.cells);
      if (std::find(cells.begin(), cells.end(), cell) != cells.end()) return true;
    }
    return false;
  }
  void write(const Row& row, std::string& out) const {
    bool first = true;
    for (const Column<Row>& column : columns) {
      if (!has(column)) continue;
      if (!first) out += ',';
      first = false;
      column.write(row, out);
    }
    out += '\n';
  }
};

// With the columns of all kinds of traces.
const Table<TickFrame>& ticks_table();
const Table<ModeRow>& modes_table();
const Table<BalanceRow>& balances_table();
const Table<PrimitiveRow>& primitives_table();
const Table<WorkRow>& works_table();
const Table<EventRow>& events_table();
const Table<BreakThroughRow>& break_throughs_table();
const Table<TickFrame>& timing_table();
const Table<WindowRow>& windows_table();
const Table<ChunkRow>& chunks_table();

}  // namespace palpa::detail
