#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "palpa/base/input_file.h"
#include "palpa/base/load_error.h"
#include "palpa/base/printed.h"
#include "palpa/base/wording.h"
#include "palpa/device/hand.h"
#include "palpa/device/repeated_rows.h"

namespace palpa {

namespace fs = std::filesystem;

namespace {

// Longest gap between rows that is interpolated: the probe is not valid in a longer one. Longer: motion is invented; shorter:
// slow recordings fall apart.
constexpr double longest_filled_gap_s = 0.1;
// Tolerance of a row's time [s]: of the last row of any recording, and of each given position, which are at ticks. Longer:
// dense rows shift; shorter: rounding makes other times of them.
constexpr double same_time_s = 1e-9;
// Least number, and share [1] of all rows, of repeated rows for a warning. More: an assumption is not reported; fewer: a short
// rest of the hand is reported.
constexpr std::size_t min_reported_repeats = 8;
constexpr double min_reported_share = 0.1;
constexpr double farthest_m = 1000.0;              // a position further away is refused: another unit, or noise
constexpr std::size_t longest_line_bytes = 65536;  // a longer line is refused: no table. More: more memory for a wrong file

// Row of a recording; later a knot of its interpolant.
struct Knot {
  double time_s = 0.0;
  Vec3 position_m;
  Vec3 slope_m_per_s;
  bool valid = true;
  std::uint32_t buttons = 0;
  std::optional<Turn> turn{};
};

// Three digits are enough for a person.
std::string brief(double value) { return detail::text("%.3g", value); }

// ---- Fritsch and Carlson (1980), one axis ----

// Slopes of a run of connected knots. A cubic is monotone if both slopes have the sign of the secant and are at most three
// times as steep.
void set_slopes(std::vector<Knot>& knots, std::size_t first, std::size_t last, double Vec3::*axis) {
  if (first == last) return;
  const auto secant = [&](std::size_t i) {
    const double slope = (knots[i + 1].position_m.*axis - knots[i].position_m.*axis) / (knots[i + 1].time_s - knots[i].time_s);
    return std::isfinite(slope) ? slope : 0.0;
  };
  knots[first].slope_m_per_s.*axis = secant(first);
  knots[last].slope_m_per_s.*axis = secant(last - 1);
  for (std::size_t i = first + 1; i < last; ++i) {
    const double before = secant(i - 1);
    const double after = secant(i);
    const bool turns = before == 0.0 || after == 0.0 || (before > 0.0) != (after > 0.0);
    const double steepest = 3.0 * std::min(std::abs(before), std::abs(after));
    knots[i].slope_m_per_s.*axis = turns ? 0.0 : std::clamp(0.5 * before + 0.5 * after, -steepest, steepest);
  }
}

// Cubic between two knots; clamped, so that rounding cannot leave their interval either.
double between(double from, double to, double slope_from, double slope_to, double length_s, double u) noexcept {
  const double v = 1.0 - u;
  const double value =
      v * v * (1.0 + 2.0 * u) * from + u * u * (3.0 - 2.0 * u) * to + u * v * length_s * (v * slope_from - u * slope_to);
  return std::clamp(value, std::min(from, to), std::max(from, to));
}

bool connected(const Knot& a, const Knot& b) noexcept {
  return a.valid && b.valid && b.time_s - a.time_s <= longest_filled_gap_s;
}

class Recording final : public Target {
 public:
  /// \param notes    assumptions on the rows, a sentence each
  /// \param near_s  [s] tolerance of a row's time
  Recording(std::vector<Knot> knots, bool has_own_placement, std::vector<std::string> notes, double near_s = 0.0)
      : knots_(std::move(knots)), has_own_placement_(has_own_placement), notes_(std::move(notes)), near_s_(near_s) {
    for (std::size_t first = 0; first < knots_.size();) {
      std::size_t last = first;
      while (last + 1 < knots_.size() && connected(knots_[last], knots_[last + 1])) ++last;
      for (double Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) set_slopes(knots_, first, last, axis);
      first = last + 1;
    }
  }

  double duration_s() const noexcept override { return knots_.back().time_s; }
  std::vector<std::string> warnings() const override {
    std::vector<std::string> notes = notes_;
    double lost_s = 0.0;
    double first_s = -1.0;
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
      if (!knots_[i].valid || !knots_[i + 1].valid || connected(knots_[i], knots_[i + 1])) continue;
      if (first_s < 0.0) first_s = knots_[i].time_s;
      lost_s += knots_[i + 1].time_s - knots_[i].time_s;
    }
    if (lost_s == 0.0) return notes;
    notes.push_back("for " + brief(lost_s) + " of " + brief(duration_s()) + " s the recording has gaps, the first after " +
                    brief(first_s) + " s, without force: rows are more than 100 ms apart there; record at least 10 a second");
    return notes;
  }
  bool has_own_placement() const noexcept override { return has_own_placement_; }

  Point at(double time_s) const noexcept override {
    const auto after = std::upper_bound(knots_.begin(), knots_.end(), time_s + near_s_,
                                        [](double time, const Knot& knot) { return time < knot.time_s; });
    if (after == knots_.begin()) return {.position_m = knots_.front().position_m, .valid = false, .turn = knots_.front().turn};
    const Knot& a = *(after - 1);
    Point point{.position_m = a.position_m, .valid = a.valid, .buttons = a.buttons, .turn = a.turn};
    if (time_s <= a.time_s + (after == knots_.end() ? same_time_s : near_s_)) return point;
    point.valid = after != knots_.end() && connected(a, *after);
    if (!point.valid) return point;
    const Knot& b = *after;
    const double length_s = b.time_s - a.time_s;
    const double u = (time_s - a.time_s) / length_s;
    for (double Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
      point.position_m.*axis =
          between(a.position_m.*axis, b.position_m.*axis, a.slope_m_per_s.*axis, b.slope_m_per_s.*axis, length_s, u);
    }
    if (a.turn && b.turn) point.turn = turned_further(*a.turn, u * rotation_between_rad(*a.turn, *b.turn));
    return point;
  }

 private:
  std::vector<Knot> knots_;
  bool has_own_placement_;
  std::vector<std::string> notes_;
  double near_s_;
};

// ---- the file ----

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t comma = line.find(','); comma != std::string_view::npos; comma = line.find(',')) {
    cells.push_back(line.substr(0, comma));
    line.remove_prefix(comma + 1);
  }
  cells.push_back(line);
  for (std::string_view& cell : cells) {
    while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
    while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t' || cell.back() == '\r')) cell.remove_suffix(1);
  }
  return cells;
}

template <class Number>
bool read_number(std::string_view text, Number& value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  // A decimal too small for a double counts as zero; one too large is refused.
  if constexpr (std::is_same_v<Number, double>) {
    if (error == std::errc::result_out_of_range && text.find("e-") != std::string_view::npos) {
      value = 0.0;
      return end == text.data() + text.size();
    }
  }
  return error == std::errc{} && end == text.data() + text.size();
}

constexpr std::string_view right_forms =
    "a recorded hand is the ticks.csv of a trace (t_s, probe_x_m, probe_y_m, probe_z_m, …), or has the columns "
    "t_s,x_m,y_m,z_m[,buttons][,turn_w,turn_x,turn_y,turn_z] (or time,x,y,z in seconds and metres), "
    "or those of a Haply log (Time, Cursor Position X, Cursor Position Y, Cursor Position Z, …), or x,y,z,… without time, with "
    "--hand-rate-hz";

// Form of a file: its column names and the meaning of its rows.
struct Form {
  std::array<const char*, 5> time;  // alternatives; none: time from the rate
  std::array<const char*, 3> position;
  std::array<const char*, 4> turn{};
  const char* valid = nullptr;    // null: every row is valid
  const char* buttons = nullptr;  // null: none
  bool own = false;               // ticks.csv of a trace: known origin, and every row is a sample of the hand itself
  bool haply = false;
  bool bare = false;  // column names may lack units
};
constexpr std::array<const char*, 5> names_of_time{"t_s", "time_s", "time", "timestamp", "t"};
constexpr std::array<const char*, 4> names_of_turn{"turn_w", "turn_x", "turn_y", "turn_z"};
constexpr Form forms[] = {
    {.time = {"t_s"},
     .position = {"probe_x_m", "probe_y_m", "probe_z_m"},
     .turn = {"probe_turn_w", "probe_turn_x", "probe_turn_y", "probe_turn_z"},
     .valid = "probe_valid",
     .buttons = "buttons",
     .own = true},
    {.time = {"t_s"}, .position = {"x_m", "y_m", "z_m"}, .turn = names_of_turn, .buttons = "buttons"},
    {.time = {"Time"}, .position = {"Cursor Position X", "Cursor Position Y", "Cursor Position Z"}, .haply = true},
    {.time = names_of_time, .position = {"x_m", "y_m", "z_m"}, .turn = names_of_turn, .buttons = "buttons", .bare = true},
    {.time = names_of_time, .position = {"x", "y", "z"}, .turn = names_of_turn, .buttons = "buttons", .bare = true},
    {.time = {}, .position = {"x", "y", "z"}, .turn = names_of_turn},
};

constexpr std::size_t absent = std::numeric_limits<std::size_t>::max();

struct Places {
  std::size_t time = absent;
  std::size_t position[3] = {absent, absent, absent};
  std::size_t turn[4] = {absent, absent, absent, absent};
  std::size_t valid = absent;
  std::size_t buttons = absent;
};

std::size_t place_of(const char* name, const std::vector<std::string_view>& header) {
  if (!name) return absent;
  const auto found = std::find(header.begin(), header.end(), name);
  return found == header.end() ? absent : static_cast<std::size_t>(found - header.begin());
}

// Form with the header's columns; null if none. With a given rate, a column of time without a unit is skipped.
const Form* form_of(const std::vector<std::string_view>& header, bool rate_given, Places& places) {
  for (const Form& form : forms) {
    if (form.bare && rate_given) continue;
    places = {};
    for (const char* name : form.time) {
      if (places.time == absent) places.time = place_of(name, header);
    }
    places.valid = place_of(form.valid, header);
    places.buttons = place_of(form.buttons, header);
    bool whole = !form.time.front() || places.time != absent;
    for (int axis = 0; axis < 3; ++axis) {
      places.position[axis] = place_of(form.position[axis], header);
      whole = whole && places.position[axis] != absent;
    }
    for (std::size_t i = 0; i < 4; ++i) places.turn[i] = place_of(form.turn[i], header);
    if (whole) return &form;
  }
  return nullptr;
}

class File {
 public:
  explicit File(const fs::path& path) : path_(path), stream_(path) {
    stream_.file().expect_open("name a recorded hand (a CSV file, of a trace its ticks.csv) or sim:…");
  }
  /// Next line that is not empty.
  bool next(std::string& line) {
    do {
      line.clear();
      ++number_;
      for (int c = stream_.get(); c != '\n'; c = stream_.get()) {
        if (c == std::char_traits<char>::eof()) {
          if (line.empty()) return false;
          is_cut_ = true;
          break;
        }
        line += static_cast<char>(c);
        if (line.size() > longest_line_bytes) refuse("the line is longer than 64 kB", right_forms);
      }
    } while (line.empty() || line == "\r");
    return true;
  }
  /// Whether the last line has no end: its writer may have been stopped within it.
  bool is_cut() const noexcept { return is_cut_; }
  std::int64_t line_number() const noexcept { return number_; }
  [[noreturn]] void refuse(const std::string& what, std::string_view right) const {
    throw LoadError(path_.string() + ":" + std::to_string(number_) + ": " + what + "; " + std::string(right));
  }

 private:
  fs::path path_;
  detail::InputStream stream_;
  std::int64_t number_ = 0;
  bool is_cut_ = false;
};

class RowReader {
 public:
  RowReader(const File& file, const Form& form, const Places& places, std::size_t width, double rate_hz)
      : file_(file), form_(form), places_(places), width_(width), rate_hz_(rate_hz) {
    const auto is_absent = [](std::size_t place) { return place == absent; };
    const auto missing = std::ranges::find_if(places.turn, is_absent);
    if (missing == std::end(places.turn) || std::ranges::all_of(places.turn, is_absent)) return;
    file.refuse("has a part of an orientation", "a quaternion has the columns turn_w, turn_x, turn_y and turn_z");
  }

  Knot read(std::string_view line) {
    const std::vector<std::string_view> cells = split(line);
    if (cells.size() != width_) {
      file_.refuse("has " + std::to_string(cells.size()) + " cells", "the header has " + std::to_string(width_));
    }
    const auto number = [&](std::size_t place, auto& value) { take(cells[place], value); };
    Knot knot;
    if (places_.time != absent) {
      number(places_.time, knot.time_s);
      if (!std::isfinite(knot.time_s)) file_.refuse("the time is not finite", "times are seconds and rise");
    } else {
      knot.time_s = static_cast<double>(rows_) / rate_hz_;
    }
    ++rows_;
    number(places_.position[0], knot.position_m.x);
    number(places_.position[1], knot.position_m.y);
    number(places_.position[2], knot.position_m.z);
    if (places_.buttons != absent) number(places_.buttons, knot.buttons);
    if (places_.valid != absent) {
      int valid = 0;
      number(places_.valid, valid);
      knot.valid = valid != 0;
    }
    if (!is_finite(knot.position_m)) knot.valid = false;
    if (knot.valid && largest_component(knot.position_m) > farthest_m) {
      file_.refuse("the position is more than 1000 m away", "positions are metres");
    }
    if (places_.turn[0] != absent) knot.turn = read_turn(cells, knot.valid);
    if (form_.haply) {
      if (knot.position_m == Vec3{}) knot.valid = false;
      knot.position_m.z = -knot.position_m.z;
    }
    return knot;
  }

 private:
  template <class Number>
  void take(std::string_view cell, Number& value) const {
    if (!read_number(cell, value))
      file_.refuse(detail::in_quotes(cell) + " is no number", "every cell of a recorded hand is one");
  }
  /// The orientation of a row; no rotation in a row without a position. Of a trace's row without one the position is unknown,
  /// too.
  Turn read_turn(const std::vector<std::string_view>& cells, bool& is_valid) const {
    Turn turn;
    double* const parts[] = {&turn.w, &turn.x, &turn.y, &turn.z};
    for (std::size_t i = 0; i < 4; ++i) take(cells[places_.turn[i]], *parts[i]);
    constexpr double tolerance = 1e-3;  // [1] of a length. More: no rotations pass; less: those of few digits are refused
    constexpr double exact = 1e-12;     // within it a trace's own bits stay
    if (is_unit(turn, tolerance)) return is_unit(turn, exact) ? turn : unit_turn(turn);
    if (form_.own) is_valid = false;  // a trace has what the device gave
    if (!is_valid) return {};
    file_.refuse("the orientation is no unit quaternion", "the squares of turn_w, turn_x, turn_y and turn_z add up to 1");
  }
  const File& file_;
  const Form& form_;
  const Places& places_;
  std::size_t width_;
  double rate_hz_;
  std::int64_t rows_ = 0;
};

// Drops rows that repeat the last position: the logger was faster than the device. Of a resting hand enough rows stay, evenly
// spread, to leave no gap; so the first step after the rest is no shorter than half of the longest interpolated gap. The last
// row stays, because it ends the recording.
std::vector<Knot> without_repeats(const std::vector<Knot>& rows) {
  std::vector<Knot> kept;
  for (std::size_t i = 0, next = 0; i < rows.size(); i = next) {
    kept.push_back(rows[i]);
    next = i + 1;  // the first other position, or the last
    while (next + 1 < rows.size() && rows[next].position_m == rows[i].position_m && rows[next].buttons == rows[i].buttons &&
           rows[next].turn == rows[i].turn)
      ++next;
    if (next >= rows.size()) break;
    for (std::size_t stays = i;;) {
      const double rest_s = rows[next].time_s - rows[stays].time_s;
      if (rest_s <= longest_filled_gap_s) break;
      const double until_s = rows[stays].time_s + rest_s / std::ceil(rest_s / longest_filled_gap_s);
      const auto later = std::upper_bound(rows.begin() + static_cast<std::ptrdiff_t>(stays) + 1,
                                          rows.begin() + static_cast<std::ptrdiff_t>(next), until_s,
                                          [](double time, const Knot& row) { return time < row.time_s; });
      stays = std::max(stays + 1, static_cast<std::size_t>(later - rows.begin()) - 1);
      if (stays >= next) break;
      kept.push_back(rows[stays]);
    }
  }
  return kept;
}

// Drops repeated rows that a logger made, and reports the assumed cause of repeats.
std::vector<Knot> with_repeats_judged(std::vector<Knot> rows, std::vector<std::string>& notes) {
  std::vector<detail::PositionChange> changes;
  std::size_t repeats = 0, last_change = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double step_m = largest_component(rows[i].position_m - rows[i - 1].position_m);
    if (step_m == 0.0 && rows[i].turn != rows[i - 1].turn) {
      last_change = i;  // the device was read anew
    } else if (step_m == 0.0) {
      ++repeats;
    } else {
      // Rows before the first change may repeat a position from before the recording.
      if (last_change > 0) changes.push_back({step_m, static_cast<int>(i - last_change)});
      last_change = i;
    }
  }
  const bool by_logger = detail::repeat_by_logger(changes);
  if (repeats >= min_reported_repeats &&
      static_cast<double>(repeats) >= min_reported_share * static_cast<double>(rows.size())) {
    const std::string share = std::to_string(repeats) + " of " + std::to_string(rows.size()) +
                              " rows repeat the position before them; they are taken for ";
    notes.push_back(share + (by_logger ? "those of a logger that is faster than its device, and are left out"
                                       : "a device at rest between two steps of its encoder, and are kept"));
  }
  return by_logger ? without_repeats(rows) : rows;
}

// Low and high corner of a recording's box.
std::pair<Vec3, Vec3> box_of(const std::vector<Knot>& knots) {
  Vec3 low = knots.front().position_m;
  Vec3 high = low;
  for (const Knot& knot : knots) {
    if (!knot.valid) continue;
    for (double Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
      low.*axis = std::min(low.*axis, knot.position_m.*axis);
      high.*axis = std::max(high.*axis, knot.position_m.*axis);
    }
  }
  return {low, high};
}

void center(std::vector<Knot>& knots) {
  const auto [low, high] = box_of(knots);
  const Vec3 middle = 0.5 * low + 0.5 * high;
  for (Knot& knot : knots) knot.position_m -= middle;
}

// Columns without a unit in their names may hold milliseconds or millimetres. Smaller limits: slow or wide recordings in SI
// units are refused; larger ones: other units pass. Recordings have more than two rows a second, and no hand moves over 3 m.
void check_units(const fs::path& path, const std::vector<Knot>& rows, std::string_view time_name, std::string_view x_name) {
  constexpr double slowest_row_s = 0.5;
  constexpr double widest_m = 3.0;
  const double mean_s = rows.back().time_s / static_cast<double>(std::max<std::size_t>(1, rows.size() - 1));
  if (!time_name.ends_with("_s") && mean_s > slowest_row_s) {
    throw LoadError(path.string() + ": rows would be " + brief(mean_s) + " s apart; '" + std::string(time_name) +
                    "' is in seconds (if it is, name it t_s)");
  }
  const auto [low, high] = box_of(rows);
  if (const double size_m = largest_component(high - low); !x_name.ends_with("_m") && size_m > widest_m) {
    throw LoadError(path.string() + ": the hand would move over " + brief(size_m) + " m; '" + std::string(x_name) +
                    "' is in metres (if it is, name it x_m, and so on)");
  }
}

}  // namespace

std::unique_ptr<Target> recorded_target(const fs::path& path, const RecordingOptions& options) {
  File file(path);
  std::string line;
  if (!file.next(line)) throw LoadError(path.string() + ": is empty; " + std::string(right_forms));
  if (line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);
  const std::string first_line = line;
  const std::vector<std::string_view> header = split(first_line);
  Places places;
  const bool rate_given = options.hand_rate_hz != 0.0;
  const Form* form = form_of(header, rate_given, places);
  if (!form) file.refuse("has none of the columns of a recorded hand", right_forms);
  if (rate_given && !(options.hand_rate_hz > 0.0 && options.hand_rate_hz <= 1e6)) {
    throw LoadError(path.string() +
                    ": the rate of its rows cannot be used; --hand-rate-hz lies above 0 and is at most 1000000");
  }
  const bool timed = places.time != absent;
  if (timed && rate_given) file.refuse("has its own times", "leave out --hand-rate-hz");
  if (!timed && !rate_given) {
    file.refuse("has no times", "give the rows per second with --hand-rate-hz, or name a column of seconds t_s");
  }

  RowReader reader(file, *form, places, header.size(), options.hand_rate_hz);
  std::vector<Knot> rows;
  std::vector<std::string> notes;
  while (file.next(line)) {
    if (file.is_cut()) {
      notes.push_back(
          "line " + std::to_string(file.line_number()) +
          " has no end, as where the writing of a file was stopped, and is left out; a last line ends like the others");
      break;
    }
    const Knot knot = reader.read(line);
    // Rows without a position are skipped, except in a trace: there the device was disconnected.
    if (!knot.valid && !form->own) continue;
    if (!rows.empty() && knot.time_s < rows.back().time_s) file.refuse("the time falls", "times are seconds and rise");
    if (!rows.empty() && knot.time_s == rows.back().time_s) rows.pop_back();
    rows.push_back(knot);
  }
  if (std::none_of(rows.begin(), rows.end(), [](const Knot& row) { return row.valid; })) {
    throw LoadError(path.string() + ": has no row with a position" + (file.is_cut() ? " that ends like a line" : "") + "; " +
                    std::string(right_forms));
  }
  // Positions of a disconnected device are meaningless: the last known one replaces them.
  Knot known = *std::find_if(rows.begin(), rows.end(), [](const Knot& row) { return row.valid; });
  const double begin_s = rows.front().time_s;
  for (Knot& row : rows) {
    row.time_s -= begin_s;
    if (row.valid) known = row;
    row.position_m = known.position_m;
    row.turn = known.turn;
  }
  if (form->bare) check_units(path, rows, header[places.time], header[places.position[0]]);
  if (form->haply) {
    rows = without_repeats(rows);
  } else if (!form->own) {
    rows = with_repeats_judged(std::move(rows), notes);
  }
  if (options.center.value_or(!form->own)) center(rows);
  return std::make_unique<Recording>(std::move(rows), form->own, std::move(notes));
}

std::unique_ptr<Target> sampled_target(std::span<const Vec3> positions_m, double time_step_s) {
  if (!(time_step_s > 0.0 && time_step_s <= 1.0))
    throw LoadError("hand: a time step of " + brief(time_step_s) + " s cannot be used; it lies above 0 and is at most 1 s");
  std::vector<Knot> knots;
  knots.reserve(positions_m.size());
  for (const Vec3& position_m : positions_m) {
    const bool valid = is_finite(position_m);
    if (valid && largest_component(position_m) > farthest_m)
      throw LoadError("hand: row " + std::to_string(knots.size()) + " is more than 1000 m away; positions are metres");
    knots.push_back({.time_s = static_cast<double>(knots.size()) * time_step_s,
                     .position_m = valid || knots.empty() ? position_m : knots.back().position_m,
                     .valid = valid});
  }
  const auto known = std::ranges::find_if(knots, &Knot::valid);
  if (known == knots.end()) throw LoadError("hand: has no row with a position; a row is three finite numbers, in metres");
  for (auto knot = knots.begin(); knot != known; ++knot) knot->position_m = known->position_m;
  return std::make_unique<Recording>(std::move(knots), true, std::vector<std::string>{}, same_time_s);
}

}  // namespace palpa
