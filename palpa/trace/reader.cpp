#include <algorithm>
#include <array>
#include <limits>

#include "palpa/base/input_file.h"
#include "palpa/base/limits.h"
#include "palpa/base/wording.h"
#include "palpa/trace/columns.h"
#include "palpa/trace/csv.h"
#include "palpa/trace/trace.h"
#include "palpa/trace/trace_toml.h"

namespace palpa {

namespace {

constexpr std::size_t nowhere = std::numeric_limits<std::size_t>::max();

// Index of each column's cells in a line, for a header in any order; `nowhere` for later columns that the recording lacks.
std::vector<std::size_t> find_columns(const detail::Table<TickFrame>& table, const std::vector<std::string_view>& header,
                                      const std::string& place) {
  std::vector<std::size_t> cells;
  for (const std::string& name : table.names()) {
    const auto found = std::find(header.begin(), header.end(), name);
    if (found != header.end()) {
      cells.push_back(static_cast<std::size_t>(found - header.begin()));
    } else if (table.is_later(name)) {
      cells.push_back(nowhere);
    } else {
      throw LoadError(place + ": column '" + name + "' is missing; a trace has all columns of docs/trace.md");
    }
  }
  return cells;
}

}  // namespace

TraceReader::TraceReader(const std::filesystem::path& folder) : folder_(folder), header_(detail::read_header(folder)) {
  scene_text_ =
      detail::read_whole(detail::InputFile(folder / "scene.toml"), limit::scene_bytes, "a trace holds the scene that was felt");
  detail::LineFile file(folder / detail::ticks_table().file);
  std::string_view line;
  if (!file.next(line)) return;
  std::vector<std::string_view> cells;
  detail::split(line, cells);
  header_.has_tool = std::find(cells.begin(), cells.end(), "probe_turn_w") != cells.end();
  header_.has_octaves = std::find(cells.begin(), cells.end(), "felt_octave") != cells.end();
}

bool TraceReader::has_energy() const {
  const detail::Table<TickFrame> table = detail::ticks_table().of({});
  detail::LineFile file(folder_ / table.file);
  std::string_view line;
  if (!file.next(line)) return true;
  std::vector<std::string_view> cells;
  detail::split(line, cells);
  const std::vector<std::size_t> at = find_columns(table, cells, file.place());
  return std::find(at.begin(), at.end(), nowhere) == at.end();
}

std::vector<TraceTick> TraceReader::ticks() const {
  const detail::Table<TickFrame>& table = detail::ticks_table();
  detail::LineFile file(folder_ / table.file);
  std::vector<TraceTick> ticks;
  std::string_view line;
  std::vector<std::string_view> cells;
  if (!file.next(line)) {
    if (header_.complete) throw LoadError((folder_ / table.file).string() + ": is missing or empty; a complete trace has it");
    return ticks;
  }
  detail::split(line, cells);
  const std::size_t width = cells.size();
  const std::vector<std::size_t> at = find_columns(table, cells, file.place());
  while (file.next(line)) {
    detail::split(line, cells);
    if (cells.size() != width) {
      throw LoadError(file.place() + ": has " + std::to_string(cells.size()) + " cells; the header has " +
                      std::to_string(width));
    }
    TickFrame& frame = ticks.emplace_back().frame;
    std::size_t first = 0;
    for (const detail::Column<TickFrame>& column : table.columns) {
      std::array<std::string_view, 4> own;
      const auto count = static_cast<std::size_t>(column.cells);
      bool is_there = true;
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t cell = at[first + i];
        is_there = is_there && cell != nowhere;
        own[i] = cell == nowhere ? std::string_view() : cells[cell];
      }
      first += count;
      if (!is_there || column.read({own.data(), count}, frame)) continue;
      std::string shown;
      for (std::size_t i = 0; i < count; ++i) shown += (i ? ", " : "") + detail::in_quotes(own[i]);
      throw LoadError(file.place() + ": column '" + std::string(column.name) + "' cannot be " + shown +
                      "; docs/trace.md says what it holds");
    }
  }
  return ticks;
}

std::vector<std::filesystem::path> traces_in(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  const auto is_trace = [](const fs::path& of) {
    std::error_code unknown;
    return fs::exists(of / "trace.toml", unknown);
  };
  if (is_trace(folder)) return {folder};
  std::vector<fs::path> traces;
  std::error_code unreadable;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, unreadable))
    if (is_trace(entry.path())) traces.push_back(entry.path());
  if (traces.empty()) return {folder};
  std::ranges::sort(traces);
  return traces;
}

}  // namespace palpa
