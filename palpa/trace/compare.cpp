#include <algorithm>
#include <limits>

#include "palpa/base/sanitized.h"
#include "palpa/trace/columns.h"
#include "palpa/trace/csv.h"
#include "palpa/trace/trace.h"

namespace palpa {

namespace fs = std::filesystem;

namespace {

// CSV file under comparison: its rows, and the positions of the compared columns.
class Sheet {
 public:
  Sheet(const fs::path& file, const std::vector<std::string>& names) : lines_(file) {
    std::string_view line;
    if (!lines_.next(line)) return;
    has_header_ = true;
    detail::split(line, cells_);
    for (const std::string& name : names) {
      const auto found = std::find(cells_.begin(), cells_.end(), name);
      if (found == cells_.end()) {
        if (missing_.empty()) missing_ = name;
      } else {
        at_.push_back(static_cast<std::size_t>(found - cells_.begin()));
      }
    }
  }
  bool has_header() const noexcept { return has_header_; }
  const std::string& missing() const noexcept { return missing_; }
  bool next() {
    std::string_view line;
    if (!lines_.next(line)) return false;
    detail::split(line, cells_);
    return true;
  }
  /// Cell of compared column number `i`; empty if the row is too short.
  std::string_view cell(std::size_t i) const { return at_[i] < cells_.size() ? cells_[at_[i]] : std::string_view(); }
  std::int64_t line_number() const noexcept { return lines_.number(); }

 private:
  detail::LineFile lines_;
  std::vector<std::string_view> cells_;
  std::vector<std::size_t> at_;
  bool has_header_ = false;
  std::string missing_;
};

std::int64_t tick_of(const Sheet& sheet) {
  std::int64_t tick = -1;
  detail::take_number(sheet.cell(0), tick);
  return tick;
}

struct Compared {
  std::string difference;  // empty: none
  std::int64_t rows = 0;
};

// Presence of the file: in every trace, or only with rows.
enum class There { always, where_needed };

// Compares a file, rows of a recording up to `last_tick`: later rows of a truncated recording may be incomplete.
Compared compare_file(const fs::path& recorded, const fs::path& again, const char* file, const std::vector<std::string>& names,
                      There there, bool complete, std::int64_t last_tick) {
  Sheet a(recorded / file, names);
  Sheet b(again / file, names);
  Compared result;
  const std::string name = file;
  if (!a.has_header() && there == There::always) {
    if (complete) result.difference = name + ": is missing or empty in the recording";
    return result;
  }
  if (!b.has_header() && there == There::always) return {name + ": is missing or empty in the replay", 0};
  for (const auto& [sheet, whose] : {std::pair{&a, "the recording"}, std::pair{&b, "the replay"}}) {
    if (!sheet->missing().empty()) return {name + ":1: column " + sheet->missing() + " is missing in " + whose, 0};
  }
  const auto next_recorded = [&] { return a.next() && tick_of(a) <= last_tick; };
  while (next_recorded()) {
    const std::string place = name + ":" + std::to_string(a.line_number()) + ": ";
    if (!b.next()) return {place + "the recording continues, the replay ends", result.rows};
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (a.cell(i) != b.cell(i)) {
        result.difference = place + "column " + names[i] + ": " + std::string(a.cell(i)) + " against " + std::string(b.cell(i));
        return result;
      }
    }
    ++result.rows;
  }
  if (complete && b.next()) {
    result.difference = name + ":" + std::to_string(b.line_number()) + ": the recording ends, the replay continues";
  }
  return result;
}

// Last tick with a whole line in ticks.csv. Other files may have rows of later ticks.
std::int64_t last_tick_of(const fs::path& folder) {
  Sheet sheet(folder / detail::ticks_table().file, {"tick"});
  std::int64_t last = -1;
  if (!sheet.has_header() || !sheet.missing().empty()) return last;
  while (sheet.next()) last = tick_of(sheet);
  return last;
}

}  // namespace

TraceDifference compare_traces(const fs::path& recorded, const fs::path& again, std::int64_t last_tick) {
  const TraceReader a(recorded);
  const TraceReader b(again);
  const bool complete = a.header().complete && last_tick == std::numeric_limits<std::int64_t>::max();
  if (!complete) last_tick = std::min(last_tick, last_tick_of(recorded));

  TraceDifference result;
  const auto compare = [&](const auto& table, There there = There::always) {
    if (!result.same) return std::int64_t{0};
    std::vector<std::string> names = table.names();
    std::erase_if(names, [&](const std::string& name) {
      return table.is_later(name) && !Sheet(recorded / table.file, {name}).missing().empty();
    });
    Compared compared = compare_file(recorded, again, table.file, names, there, complete, last_tick);
    result.same = compared.difference.empty();
    result.where = detail::sanitized(compared.difference);  // cells of a trace are untrusted
    return compared.rows;
  };
  if (a.scene_text() != b.scene_text()) {
    result.same = false;
    result.where = "scene.toml: the scenes differ";
  }
  result.ticks = compare(detail::ticks_table());
  compare(detail::modes_table());
  compare(detail::events_table());
  compare(detail::break_throughs_table(), There::where_needed);
  compare(detail::windows_table(), There::where_needed);
  if (a.header().primitives) {
    compare(detail::balances_table());
    compare(detail::primitives_table());
    compare(detail::works_table(), There::where_needed);
  }
  return result;
}

}  // namespace palpa
