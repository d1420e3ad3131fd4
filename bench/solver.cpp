// Time of a balance: the exact law by family, number of primitives and stage, and in scenes under a moving hand.
//
//   bench_solver [--problems 200] [--family NAME] [--part scenes|families|tools]
//
// Times are of `Solver::solve` alone, by the clock named at the top, less the clock's own time. Each problem is timed 3 times
// and the best kept; median, p99 and maximum are over problems, so that they show hard problems, not a noisy machine. Cold: an
// empty law. Warm: the law has just solved the problem with the probe 0.1 mm beside it (in the scenes: the tick before). Hot:
// the problem is in the caches. Evicted: 64 MB of other memory were touched after the problem's set-up. --problems is per
// family and number of primitives; a quarter of that at 64, a tenth at 1000, a twentieth with evicted caches. Tools: of
// `PoseSolver::solve` in walks on a plane, a sphere and in a hole, and jammed at random, --problems of each.
//
// The exit status is 1 if a required figure is missed or a solve allocates.
#include <palpa/solver/solver.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "solver_clock.h"
#include "solver_scenes.h"
#include "solver_tools.h"
#include "tests/solver/counted_allocations.h"
#include "tests/solver/problem_families.h"
#include "tests/solver/random_problems.h"

namespace {

using namespace palpa;
using bench::Clock;
using bench::Scene;
using test::Family;
using test::Problem;
using test::Random;

constexpr int repeats = 3;
constexpr int stages = 4;
constexpr int most_primitives = 1000;
constexpr std::array<int, 8> sizes{1, 2, 3, 5, 8, 16, 64, most_primitives};
// Families as modes place primitives; each of the others has one difficulty.
constexpr std::string_view ordinary[] = {"random", "haptic", "haptic_slipping"};

struct Options {
  int problems = 200;
  std::string family;
  std::string part;  ///< empty: all
};

bool is_ordinary(const Family& family) {
  return std::find(std::begin(ordinary), std::end(ordinary), family.name) != std::end(ordinary);
}

int count_for(const Options& options, int n) {
  return std::max(n >= 1000 ? 4 : 10, n >= 1000 ? options.problems / 10 : n >= 64 ? options.problems / 4 : options.problems);
}

std::vector<Problem> problems_of(const Family& family, int n, int count, bool drags) {
  std::vector<Problem> problems;
  for (int i = 0; i < count; ++i) {
    Random random(static_cast<std::uint64_t>(100'000 * n + 2 * i + (drags ? 1 : 0)));
    problems.push_back(family.make(random, n, drags));
  }
  return problems;
}

class Values {
 public:
  void add(double value) { values_.push_back(value), sorted_ = false; }
  void add(const Values& other) {
    values_.insert(values_.end(), other.values_.begin(), other.values_.end());
    sorted_ = false;
  }
  bool empty() const { return values_.empty(); }
  std::size_t size() const { return values_.size(); }
  /// 0 to 1: the smallest value that this share does not exceed (detail::quantile may return its predecessor).
  double quantile(double q) const {
    if (values_.empty()) return 0.0;
    if (!sorted_) std::sort(values_.begin(), values_.end());
    sorted_ = true;
    const double rank = std::ceil(q * static_cast<double>(values_.size())) - 1.0;
    return values_[static_cast<std::size_t>(std::max(0.0, rank))];
  }
  double median() const { return quantile(0.5); }
  double max() const { return quantile(1.0); }

 private:
  mutable std::vector<double> values_;
  mutable bool sorted_ = false;
};

/// All solves of one kind: times, stages, bounds.
struct Tally {
  Values time_ns;
  std::array<Values, stages> stage_time_ns;
  Values bound_m;
  int exact = 0;

  void add(double ns, const Balance& balance) {
    time_ns.add(ns);
    stage_time_ns[static_cast<std::size_t>(std::clamp(balance.stage, 0, stages - 1))].add(ns);
    bound_m.add(balance.error_bound_m);
    exact += balance.status == BalanceStatus::exact;
  }
  void add(const Tally& other) {
    time_ns.add(other.time_ns);
    for (int i = 0; i < stages; ++i) stage_time_ns[i].add(other.stage_time_ns[i]);
    bound_m.add(other.bound_m);
    exact += other.exact;
  }
  double share(int stage) const {
    return time_ns.empty() ? 0.0 : static_cast<double>(stage_time_ns[stage].size()) / static_cast<double>(time_ns.size());
  }
};

struct Cell {
  Tally cold, warm, cold_evicted, warm_evicted;
  void add(const Cell& other) {
    cold.add(other.cold), warm.add(other.warm);
    cold_evicted.add(other.cold_evicted), warm_evicted.add(other.warm_evicted);
  }
};

class Bench {
 public:
  const Clock& clock() const { return clock_; }
  long allocations() const { return allocations_; }
  long solves() const { return solves_; }

  void evict_caches() {
    for (std::size_t byte = 0; byte < other_.size(); byte += 64) ++other_[byte];
  }

  double time_ns(Law& law, const Problem& problem, const Vec3& probe_m, Balance& balance) {
    const long before = test::allocations;
    const std::uint64_t begin = Clock::now();
    balance = law.solve(set_, problem.start_m, probe_m, problem.stiffness_n_per_m, problem.time_step_s);
    const std::uint64_t end = Clock::now();
    allocations_ += test::allocations - before;
    ++solves_;
    return std::max(0.0, clock_.ns_between(begin, end) - clock_.own_ns());
  }

  double cold_ns(Law& law, const Problem& problem, bool evicted, Balance& balance) {
    test::fill(set_, problem);
    double best = 1e300;
    for (int repeat = 0; repeat < repeats; ++repeat) {
      law.reset();
      if (evicted) evict_caches();
      best = std::min(best, time_ns(law, problem, problem.probe_m, balance));
    }
    return best;
  }

  /// The best of some solves after a solve with the probe at `before_m`.
  double warm_ns(Law& law, const Problem& problem, const Vec3& before_m, bool evicted, Balance& balance) {
    test::fill(set_, problem);
    double best = 1e300;
    for (int repeat = 0; repeat < repeats; ++repeat) {
      law.reset();
      law.solve(set_, problem.start_m, before_m, problem.stiffness_n_per_m, problem.time_step_s);
      if (evicted) evict_caches();
      best = std::min(best, time_ns(law, problem, problem.probe_m, balance));
    }
    return best;
  }

  Cell measure(const std::vector<Problem>& problems) {
    Cell cell;
    Balance balance;
    const std::size_t evicted = std::max<std::size_t>(3, problems.size() / 20);
    for (std::size_t i = 0; i < problems.size(); ++i) {
      const Problem& problem = problems[i];
      Random random(i);
      const Vec3 before_m = problem.probe_m + 1e-4 * random.direction();
      double ns = cold_ns(solver_, problem, false, balance);
      cell.cold.add(ns, balance);
      ns = warm_ns(solver_, problem, before_m, false, balance);
      cell.warm.add(ns, balance);
      if (i >= evicted) continue;
      ns = cold_ns(solver_, problem, true, balance);
      cell.cold_evicted.add(ns, balance);
      ns = warm_ns(solver_, problem, before_m, true, balance);
      cell.warm_evicted.add(ns, balance);
    }
    return cell;
  }

  /// All ticks of a scene in order, repeated; of each tick the best.
  Cell measure(const Scene& scene) {
    Cell cell;
    Balance balance;
    const std::size_t ticks = scene.ticks.size(), every = ticks / 100;
    std::vector<double> warm_ns(ticks, 1e300);
    std::vector<Balance> balances(ticks);
    for (int repeat = 0; repeat < repeats; ++repeat) {
      solver_.reset();
      for (std::size_t i = 0; i < ticks; ++i) {
        test::fill(set_, scene.ticks[i]);
        warm_ns[i] = std::min(warm_ns[i], time_ns(solver_, scene.ticks[i], scene.ticks[i].probe_m, balances[i]));
      }
    }
    for (std::size_t i = 1; i < ticks; ++i) cell.warm.add(warm_ns[i], balances[i]);  // the first had no tick before
    for (const Problem& problem : scene.ticks) {
      const double ns = cold_ns(solver_, problem, false, balance);
      cell.cold.add(ns, balance);
    }
    for (std::size_t i = 1; i < ticks; i += every) {
      double best = 1e300;
      for (int repeat = 0; repeat < repeats; ++repeat) {
        solver_.reset();
        for (const std::size_t tick : {i - 1, i}) {
          test::fill(set_, scene.ticks[tick]);
          if (tick == i) evict_caches();
          const double ns = time_ns(solver_, scene.ticks[tick], scene.ticks[tick].probe_m, balance);
          if (tick == i) best = std::min(best, ns);
        }
      }
      cell.warm_evicted.add(best, balance);
      const double ns = cold_ns(solver_, scene.ticks[i], true, balance);
      cell.cold_evicted.add(ns, balance);
    }
    return cell;
  }

 private:
  Clock clock_;
  std::vector<unsigned char> other_ = std::vector<unsigned char>(std::size_t{64} << 20);
  PrimitiveSet set_{most_primitives};
  Solver solver_{most_primitives};
  long allocations_ = 0;
  long solves_ = 0;
};

void print_times_head(const char* first) {
  std::printf("%-38s %4s | %-26s | %-26s | %-26s | %-26s\n", first, "n", "hot cold", "hot warm", "evicted cold",
              "evicted warm");
  std::printf("%-38s %4s", "", "");
  for (int i = 0; i < 4; ++i) std::printf(" | %8s %8s %8s", "median", "p99", "max");
  std::printf("   [ns]\n");
}

void print_times(const char* name, int n, const Cell& cell) {
  std::printf("%-38s %4d", name, n);
  for (const Tally* tally : {&cell.cold, &cell.warm, &cell.cold_evicted, &cell.warm_evicted}) {
    std::printf(" | %8.0f %8.0f %8.0f", tally->time_ns.median(), tally->time_ns.quantile(0.99), tally->time_ns.max());
  }
  std::printf("\n");
}

void print_stages_head(const char* first) {
  std::printf("%-38s %4s %-5s", first, "n", "");
  for (int stage = 0; stage < stages; ++stage) std::printf(" | stage %d %% %7s %8s", stage, "med ns", "max ns");
  std::printf(" | %7s %9s %9s\n", "exact %", "bound med", "max [m]");
}

void print_stages(const char* name, int n, const Cell& cell) {
  for (const auto& [kind, tally] : {std::pair{"cold", &cell.cold}, std::pair{"warm", &cell.warm}}) {
    std::printf("%-38s %4d %-5s", name, n, kind);
    for (int stage = 0; stage < stages; ++stage) {
      const Values& times = tally->stage_time_ns[stage];
      std::printf(" | %9.2f %7.0f %8.0f", 100.0 * tally->share(stage), times.median(), times.max());
    }
    std::printf(" | %7.2f %9.2e %9.2e\n",
                100.0 * tally->exact / static_cast<double>(std::max<std::size_t>(1, tally->time_ns.size())),
                tally->bound_m.median(), tally->bound_m.max());
  }
}

struct Row {
  std::string name;
  int n = 0;
  Cell cell;
};

void print_rows(const char* first, const std::vector<Row>& rows) {
  std::printf("\n");
  print_times_head(first);
  for (const Row& row : rows) print_times(row.name.c_str(), row.n, row.cell);
  std::printf("\n");
  print_stages_head(first);
  for (const Row& row : rows) print_stages(row.name.c_str(), row.n, row.cell);
}

class Figures {
 public:
  void at_most(const std::string& what, double value, double limit, const char* unit) {
    const bool met = value <= limit;
    char line[200];
    std::snprintf(line, sizeof line, "%-7s %-66s %10.4g %s (asked: at most %g)", met ? "met" : "MISSED", what.c_str(), value,
                  unit, limit);
    lines_.push_back(line);
    missed_ += !met;
  }
  int missed() const { return missed_; }
  void print() const {
    std::printf("\nfigures asked for\n");
    for (const std::string& line : lines_) std::printf("%s\n", line.c_str());
  }

 private:
  std::vector<std::string> lines_;
  int missed_ = 0;
};

void measure_scenes(Bench& bench, Figures& figures) {
  std::vector<Row> rows;
  for (const Scene& scene : bench::scenes()) rows.push_back({scene.name, scene.primitives, bench.measure(scene)});
  std::printf("\nScenes under a moving hand, 6000 ticks at 1 kHz, k = 800 N/m, primitives placed at the proxy every tick\n");
  print_rows("scene", rows);
  for (int i = 0; i < 3; ++i)
    figures.at_most(rows[i].name + ": hot, warm, median", rows[i].cell.warm.time_ns.median(), 100, "ns");
  figures.at_most(rows[4].name + ": hot, warm, median", rows[4].cell.warm.time_ns.median(), 400, "ns");
  figures.at_most(rows[4].name + ": hot, warm, p99", rows[4].cell.warm.time_ns.quantile(0.99), 600, "ns");
  figures.at_most(rows[5].name + ": hot, cold, p99", rows[5].cell.cold.time_ns.quantile(0.99), 20'000, "ns");
}

void measure_families(Bench& bench, const Options& options, Figures& figures) {
  std::vector<Row> rows, pooled;
  for (const int n : sizes) {
    for (const bool drags : {false, true}) {
      const char* with = drags ? "with drags" : "without drags";
      Row easy{std::string("ordinary families, ") + with, n, {}}, hard{std::string("degenerate families, ") + with, n, {}},
          corners{std::string("families of corners and elastic, ") + with, n, {}};
      for (const Family& family : test::families()) {
        if (!options.family.empty() && options.family != family.name) continue;
        const Cell cell = bench.measure(problems_of(family, n, std::max(2, count_for(options, n) / 2), drags));
        const auto same =
            std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return r.name == family.name && r.n == n; });
        Row& row = same != rows.end() ? *same : rows.emplace_back(Row{family.name, n, {}});
        row.cell.add(cell);
        (family.is_new ? corners : is_ordinary(family) ? easy : hard).cell.add(cell);
      }
      pooled.push_back(easy);
      pooled.push_back(hard);
      pooled.push_back(corners);
      const double p99_ns = easy.cell.cold.time_ns.quantile(0.99);
      if (!options.family.empty()) continue;
      if (n == 16) figures.at_most("16 primitives, ordinary, " + std::string(with) + ": hot, cold, p99", p99_ns, 20'000, "ns");
      if (n == 1000)
        figures.at_most("1000 primitives, ordinary, " + std::string(with) + ": hot, cold, p99", p99_ns, 900'000, "ns");
    }
  }
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.name < b.name; });
  std::printf("\nFamilies of problems, half of them with drags\n");
  print_rows("family", rows);
  if (!options.family.empty()) return;
  std::stable_sort(pooled.begin(), pooled.end(), [](const Row& a, const Row& b) { return a.name > b.name; });
  std::printf(
      "\nordinary: random, haptic, haptic_slipping; of corners and elastic: those with one or more; degenerate: all others\n");
  print_rows("", pooled);
}

Values times_us(const bench::ToolTimes& tool) {
  Values values;
  for (const double ns : tool.times_ns) values.add(1e-3 * ns);
  return values;
}

void print_tool(const bench::ToolTimes& tool, const Values& us) {
  std::printf("%-24s %4d %-8s %6.1f %8zu | %8.2f %8.2f %9.1f | %9.2e %6d\n", tool.name.c_str(), tool.feet,
              tool.friction ? "friction" : "", tool.rows, us.size(), us.median(), us.quantile(0.99), us.max(),
              tool.largest_bound_m, tool.capped);
}

void measure_tools(Bench& bench, const Options& options, Figures& figures) {
  std::printf("\nTools: balances of walks at 1 kHz, warm, the best of 3 repetitions\n");
  std::printf("%-24s %4s %-8s %6s %8s | %8s %8s %9s | %9s %6s   [us]\n", "walk", "feet", "", "rows", "balances", "median",
              "p99", "max", "bound [m]", "capped");
  for (const bench::ToolTimes& tool : bench::times_of_walks(bench.clock())) {
    const Values us = times_us(tool);
    print_tool(tool, us);
    if (tool.feet != 16 && tool.feet != 256) continue;
    const std::string what = tool.name + ", " + std::to_string(tool.feet) + " feet" + (tool.friction ? ", friction" : "");
    const double allowed = tool.friction ? 2.0 : 1.0;
    if (tool.feet == 16) figures.at_most(what + ": median", us.median(), allowed, "us");
    figures.at_most(what + ": p99", us.quantile(0.99), allowed * (tool.feet == 16 ? 10 : 60), "us");
  }
  for (const bench::ToolTimes& tool : bench::times_jammed(bench.clock(), options.problems)) {
    const Values us = times_us(tool);
    print_tool(tool, us);
    figures.at_most(tool.name + ", " + std::to_string(tool.feet) + " feet: max", us.max(), 1000, "us");
  }
}

std::optional<Options> options_of(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string_view key = argv[i];
    if (key == "--part" && i + 1 < argc) {
      options.part = argv[++i];
      constexpr std::string_view parts[] = {"scenes", "families", "tools"};
      if (std::find(std::begin(parts), std::end(parts), options.part) == std::end(parts)) return std::nullopt;
    } else if (key == "--problems" && i + 1 < argc) {
      options.problems = std::atoi(argv[++i]);
    } else if (key == "--family" && i + 1 < argc) {
      options.family = argv[++i];
    } else {
      return std::nullopt;
    }
  }
  if (options.problems < 1) return std::nullopt;
  if (!options.family.empty() && !test::family_named(options.family)) return std::nullopt;
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  const std::optional<Options> options = options_of(argc, argv);
  if (!options) {
    std::fputs("usage: bench_solver [--problems N] [--family NAME] [--part scenes|families|tools]\n", stderr);
    return 2;
  }
  Bench bench;
  std::printf("clock: %s, in steps of %.1f ns; its own cost, taken off every time: %.1f ns\n", Clock::name(),
              bench.clock().step_ns(), bench.clock().own_ns());
  Figures figures;
  const auto asked = [&](std::string_view part) {
    if (!options->part.empty()) return options->part == part;
    return options->family.empty() || part == "families";
  };
  if (asked("scenes")) measure_scenes(bench, figures);
  if (asked("tools")) measure_tools(bench, *options, figures);
  if (asked("families")) measure_families(bench, *options, figures);
  if (bench.solves() > 0)
    figures.at_most("allocations in " + std::to_string(bench.solves()) + " solves", static_cast<double>(bench.allocations()), 0,
                    "");
  figures.print();
  return figures.missed() == 0 ? 0 : 1;
}
