#include <algorithm>
#include <functional>
#include <optional>
#include <stdexcept>

#include "palpa/base/limits.h"
#include "palpa/trace/rows.h"
#include "palpa/trace/trace.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;
using detail::each_row;
using detail::Row;

/// Columns under construction while a trace's files are read; of equal lengths, the number of ticks.
class PathBuilder {
 public:
  explicit PathBuilder(const TraceReader& trace) : map_(trace.header().hand_to_world) {
    for (const TraceTick& tick : trace.ticks()) ticks_.push_back(tick.frame);
    whole("tick", [](const TickFrame& f) { return static_cast<double>(f.tick); });
    number("t_s", [](const TickFrame& f) { return f.t_s; });
    vector("proxy_m", [this](const TickFrame& f) { return map_.to_world(f.result.proxy_m); });
    vector("probe_m", [this](const TickFrame& f) { return map_.to_world(f.result.probe_m); });
    whole("probe_valid", [](const TickFrame& f) { return f.result.probe_valid ? 1.0 : 0.0; });
    vector("force_n", [this](const TickFrame& f) { return map_.turned_to_world(f.result.force_n); });
    vector("command_n", [this](const TickFrame& f) { return map_.turned_to_world(f.command.force_n); });
    number("error_bound_m", [this](const TickFrame& f) { return map_.scale * f.result.error_bound_m; });
    whole("status", [](const TickFrame& f) { return static_cast<double>(f.result.status); });
    whole("guard", [](const TickFrame& f) { return static_cast<double>(f.command.guard); });
    whole("buttons", [](const TickFrame& f) { return static_cast<double>(f.buttons); });
    if (!trace.header().has_tool) return;
    turn("probe_turn", [](const TickFrame& f) { return f.result.probe_turn; });
    turn("proxy_turn", [](const TickFrame& f) { return f.result.proxy_turn; });
    vector("torque_nm", [this](const TickFrame& f) { return map_.turned_to_world(f.result.torque_nm); });
    vector("command_torque_nm", [this](const TickFrame& f) { return map_.turned_to_world(f.command.torque_nm); });
  }

  void add_modes(const fs::path& folder) {
    each_row(folder / "modes.csv", {"tick", "mode", "force_x_n", "force_y_n", "force_z_n"}, [&](const Row& row) {
      if (const auto at = row_of(row.number<std::int64_t>(0))) {
        double* const to = &column("mode." + row.text(1) + ".force_n", 3, false, row).values[3 * *at];
        const Vec3 force_n = map_.turned_to_world(row.vector(2));
        to[0] = force_n.x, to[1] = force_n.y, to[2] = force_n.z;
      }
      return true;
    });
  }

  /// Adds the strengths of the last sub-step of each tick, if primitives were recorded.
  void add_strengths(const fs::path& folder) {
    std::int64_t tick = -1, sub_step = -1;
    std::vector<double*> of_tick;
    each_row(folder / "primitives.csv", {"tick", "sub_step", "mode", "strength_n"}, [&](const Row& row) {
      const auto number = row.number<std::int64_t>(0), step = row.number<std::int64_t>(1);
      const auto at = row_of(number);
      if (!at) return true;
      if (number == tick && step != sub_step) {
        for (double* const strength_n : of_tick) *strength_n = 0.0;
      }
      if (number != tick || step != sub_step) of_tick.clear();
      tick = number, sub_step = step;
      double* const to = &column("mode." + row.text(2) + ".strength_n", 1, false, row).values[*at];
      *to += row.number<double>(3);
      of_tick.push_back(to);
      return true;
    });
  }

  void add_events(const fs::path& folder) {
    each_row(folder / "events.csv", {"tick", "t_s", "kind", "subject", "value"}, [&](const Row& row) {
      if (ticks_.empty()) return false;
      // An event between ticks belongs to the next tick, after the last to the last.
      const auto number = row.number<std::int64_t>(0);
      const std::size_t at = std::min(first_from(number), ticks_.size() - 1);
      column("event." + row.text(2), 1, true, row).values[at] += 1.0;
      path_.events.push_back({at, row.text(2), row.text(3), row.text(4)});
      return true;
    });
  }

  FeltPath take() { return std::move(path_); }

 private:
  void number(const char* name, const std::function<double(const TickFrame&)>& of, bool is_whole = false) {
    FeltColumn& made = path_.columns.emplace_back(FeltColumn{name, 1, is_whole, {}});
    for (const TickFrame& frame : ticks_) made.values.push_back(of(frame));
  }
  void whole(const char* name, const std::function<double(const TickFrame&)>& of) { number(name, of, true); }
  void vector(const char* name, const std::function<Vec3(const TickFrame&)>& of) {
    FeltColumn& made = path_.columns.emplace_back(FeltColumn{name, 3, false, {}});
    for (const TickFrame& frame : ticks_) {
      const Vec3 v = of(frame);
      made.values.insert(made.values.end(), {v.x, v.y, v.z});
    }
  }

  /// A rotation of the hand frame about the same axis of the world.
  void turn(const char* name, const std::function<Turn(const TickFrame&)>& of) {
    FeltColumn& made = path_.columns.emplace_back(FeltColumn{name, 4, false, {}});
    for (const TickFrame& frame : ticks_) {
      const Turn turn = of(frame);
      const Vec3 axis = map_.turned_to_world({turn.x, turn.y, turn.z});
      made.values.insert(made.values.end(), {turn.w, axis.x, axis.y, axis.z});
    }
  }

  std::size_t first_from(std::int64_t tick) const {
    const auto found =
        std::lower_bound(ticks_.begin(), ticks_.end(), tick, [](const TickFrame& f, std::int64_t t) { return f.tick < t; });
    return static_cast<std::size_t>(found - ticks_.begin());
  }
  std::optional<std::size_t> row_of(std::int64_t tick) const {
    const std::size_t at = first_from(tick);
    return at < ticks_.size() && ticks_[at].tick == tick ? std::optional(at) : std::nullopt;
  }

  /// Column by name, of zeros if new.
  FeltColumn& column(const std::string& name, int components, bool is_whole, const Row& row) {
    for (FeltColumn& known : path_.columns) {
      if (known.name == name) return known;
    }
    // Most names that modes can have; the file is untrusted.
    if (path_.columns.size() >= 4 * limit::modes.count()) row.refuse(0);
    return path_.columns.emplace_back(
        FeltColumn{name, components, is_whole, std::vector<double>(ticks_.size() * static_cast<std::size_t>(components))});
  }

  Similarity map_;
  std::vector<TickFrame> ticks_;
  FeltPath path_;
};

}  // namespace

const FeltColumn& FeltPath::column(std::string_view name) const {
  const auto found = std::find_if(columns.begin(), columns.end(), [&](const FeltColumn& c) { return c.name == name; });
  if (found == columns.end()) throw std::out_of_range("no column " + std::string(name));
  return *found;
}

FeltPath felt_path(const fs::path& folder) {
  const TraceReader trace(folder);
  PathBuilder builder(trace);
  builder.add_modes(folder);
  builder.add_strengths(folder);
  builder.add_events(folder);
  return builder.take();
}

}  // namespace palpa
