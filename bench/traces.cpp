// Bounds of the balances in traces, by the formula of docs/trace.md alone; and differences between two traces of one hand.
//
//   bench_traces FOLDER…               traces recorded with --primitives: one line each
//   bench_traces --compare OLD NEW     largest and p99 change of the proxy, the force and the probe per tick
#include <palpa/palpa.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/data/quantile.h"
#include "tests/laws/trace_check.h"

namespace {

using namespace palpa;
namespace fs = std::filesystem;

struct Worst {
  double value = 0.0;
  std::int64_t tick = -1;
  void take(double candidate, std::int64_t at) {
    if (candidate > value || tick < 0) *this = {candidate, at};
  }
};

void print_check_header() {
  std::printf("%-28s %9s %7s %10s %11s %11s %12s %13s %8s\n", "trace", "balances", "capped", "claimed_m", "recomputed",
              "above claim", "beyond round", "capped: r/c", "us/row");
  std::printf("%-28s %9s %7s %10s %11s %11s %12s %13s\n", "", "", "", "worst", "worst [m]", "worst [m]", "rows", "worst");
}

/// True if no balance exceeds its bound by more than rounding.
bool check(const fs::path& trace) {
  std::int64_t balances = 0, capped = 0, promise_nothing = 0, within = 0, beyond = 0;
  Worst claimed, recomputed, above, ratio;
  const auto begin = std::chrono::steady_clock::now();
  test::check_balances(trace, [&](const test::CheckedBalance& b) {
    if (b.status != "exact" && b.status != "capped") {
      ++promise_nothing;
      return;
    }
    ++balances;
    claimed.take(b.claimed_m, b.tick);
    recomputed.take(b.bound_m, b.tick);
    above.take(b.bound_m - b.claimed_m, b.tick);
    within += b.bound_m <= exact_bound_m;
    beyond += !(b.bound_m <= b.claimed_m + b.rounding_m);
    if (b.status == "capped") {
      ++capped;
      ratio.take(b.bound_m / b.claimed_m, b.tick);
    }
  });
  const double wall_us = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
  const std::string name = trace.filename().empty() ? trace.parent_path().filename().string() : trace.filename().string();
  std::printf("%-28s %9lld %7lld %10.3g %11.3g %11.2g %12lld %13s %8.2f\n", name.c_str(), static_cast<long long>(balances),
              static_cast<long long>(capped), claimed.value, recomputed.value, above.value, static_cast<long long>(beyond),
              capped ? std::to_string(ratio.value).c_str() : "-",
              wall_us / static_cast<double>(std::max<std::int64_t>(1, balances)));
  std::printf("%-28s worst claimed in tick %lld, recomputed in tick %lld; %.6g %% recomputed <= 1e-9 m", "",
              static_cast<long long>(claimed.tick), static_cast<long long>(recomputed.tick),
              100.0 * static_cast<double>(within) / static_cast<double>(std::max<std::int64_t>(1, balances)));
  if (promise_nothing > 0) std::printf("; %lld more balances promise no bound", static_cast<long long>(promise_nothing));
  std::printf("\n");
  return beyond == 0;
}

struct Row {
  std::int64_t tick = 0;
  double t_s = 0.0;
  Vec3 probe_m, proxy_m, force_n;
  std::string status;
  double bound_m = 0.0;
};

class Ticks {
 public:
  explicit Ticks(const fs::path& trace) : rows_(trace / "ticks.csv") {}
  bool next(Row& row) {
    if (!rows_.next()) return false;
    row = {rows_.integer("tick"),        rows_.number("t_s"),        rows_.vector("probe", "m"),
           rows_.vector("proxy", "m"),   rows_.vector("force", "n"), std::string(rows_.text("status")),
           rows_.number("error_bound_m")};
    return true;
  }
  std::string place() const { return rows_.place(); }

 private:
  test::CsvRows rows_;
};

/// Change of a vector between the traces, over the ticks.
class Change {
 public:
  void take(const Vec3& before, const Vec3& after, const Row& old_row, const Row& new_row) {
    const double change = distance(before, after);
    changes_.push_back(change);
    if (changes_.size() > 1 && !(change > largest_)) return;
    largest_ = change;
    old_ = old_row;
    new_ = new_row;
  }
  void print(const char* what, const char* unit) {
    std::sort(changes_.begin(), changes_.end());
    const auto changed = changes_.end() - std::upper_bound(changes_.begin(), changes_.end(), 0.0);
    const double p99 = changes_[detail::rank_of(0.99, changes_.size())];
    std::printf("  %-6s largest change %.3g %s, p99 %.3g %s, %lld ticks changed", what, largest_, unit, p99, unit,
                static_cast<long long>(changed));
    if (largest_ > 0.0) {
      std::printf("; largest in tick %lld (%.4f s) at proxy (%.6f, %.6f, %.6f) m, old %s with bound %.3g m, new %s with %.3g m",
                  static_cast<long long>(old_.tick), old_.t_s, old_.proxy_m.x, old_.proxy_m.y, old_.proxy_m.z,
                  old_.status.c_str(), old_.bound_m, new_.status.c_str(), new_.bound_m);
    }
    std::printf("\n");
  }

 private:
  std::vector<double> changes_;
  double largest_ = 0.0;
  Row old_, new_;
};

/// The events of a trace as tick, kind and subject.
std::multiset<std::string> events(const fs::path& trace) {
  std::multiset<std::string> all;
  test::CsvRows rows(trace / "events.csv");
  while (rows.next()) {
    all.insert(std::string(rows.text("tick")) + "," + std::string(rows.text("kind")) + "," + std::string(rows.text("subject")));
  }
  return all;
}

void compare(const fs::path& old_trace, const fs::path& new_trace) {
  Ticks old_ticks(old_trace), new_ticks(new_trace);
  Change proxy, force, probe;
  Row a, b;
  std::int64_t ticks = 0, status_differs = 0;
  bool more_a = old_ticks.next(a), more_b = new_ticks.next(b);
  for (; more_a && more_b; more_a = old_ticks.next(a), more_b = new_ticks.next(b)) {
    if (a.tick != b.tick || a.t_s != b.t_s) {
      throw LoadError(new_ticks.place() + ": not the tick of " + old_ticks.place() + "; compare traces of the same hand");
    }
    proxy.take(a.proxy_m, b.proxy_m, a, b);
    force.take(a.force_n, b.force_n, a, b);
    probe.take(a.probe_m, b.probe_m, a, b);
    status_differs += a.status != b.status;
    ++ticks;
  }
  if (ticks == 0) throw LoadError(old_trace.string() + ", " + new_trace.string() + ": no ticks to compare");

  const std::multiset<std::string> old_events = events(old_trace), new_events = events(new_trace);
  std::vector<std::string> only_old, only_new;
  std::ranges::set_difference(old_events, new_events, std::back_inserter(only_old));
  std::ranges::set_difference(new_events, old_events, std::back_inserter(only_new));

  std::printf("%s -> %s: %lld ticks, %lld of them with another status\n", old_trace.string().c_str(),
              new_trace.string().c_str(), static_cast<long long>(ticks), static_cast<long long>(status_differs));
  if (more_a != more_b) std::printf("  %s goes on after that\n", (more_a ? old_trace : new_trace).string().c_str());
  proxy.print("proxy", "m");
  force.print("force", "N");
  probe.print("probe", "m");
  std::printf("  events: %zu old, %zu new; %zu only in the old trace, %zu only in the new one\n", old_events.size(),
              new_events.size(), only_old.size(), only_new.size());
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string_view> arguments(argv + 1, argv + argc);
  try {
    if (arguments.size() == 3 && arguments[0] == "--compare") {
      compare(arguments[1], arguments[2]);
      return 0;
    }
    if (arguments.empty() || arguments[0].starts_with("-")) {
      std::fprintf(stderr, "usage: %s FOLDER... | --compare OLD NEW\n", argv[0]);
      return 2;
    }
    bool all_proven = true;
    print_check_header();
    for (const std::string_view folder : arguments) all_proven = check(folder) && all_proven;
    return all_proven ? 0 : 1;
  } catch (const LoadError& error) {
    std::fprintf(stderr, "bench_traces: %s\n", error.what());
    return 2;
  }
}
