// The exact law against the 113-bit reference, over at least a million problems of every family: true errors,
// proven bounds, and whether each figure that was asked for is met.
//
//   bench_solver_accuracy [--problems 1000000] [--seed 1] [--threads 2] [--family NAME] [--arbitrary-bits N]
//   bench_solver_accuracy --only FAMILY,N,DRAGS,SEED
//
// The problems are spread over the families of tests/solver/problem_families.h, with and without drags, and over
// 0 to 64 primitives (most of them few), a few with 1000. Each is solved from nothing (cold), and again after a
// balance of the same primitives with the probe 0.1 mm beside it (warm); shares and quantiles are of the cold
// solves, maxima of errors are of both. The seed of a problem depends on --seed, its family and its number alone,
// so any number of threads gives the same problems and the same answers. A problem that the reference does not
// certify is counted and printed; its error is not used.
//
// --arbitrary-bits N poses N problems made of arbitrary bits instead, those of tests/solver/arbitrary_bits.h, and checks
// that every answer is finite and bad input is said to be bad. --only poses one problem and prints it in full.
//
// The exit status is 1 if a figure is missed.
#include <palpa/solver/solver.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "palpa/base/printed.h"
#include "palpa/data/quantile.h"
#include "tests/solver/arbitrary_bits.h"
#include "tests/solver/problem_families.h"
#include "tests/solver/random_problems.h"
#include "tests/solver/reference.h"

namespace {

using namespace palpa;
using detail::text;
using test::Family;
using test::Problem;
using test::Random;

constexpr int most_primitives = 1000;
constexpr int stages = 4;
// The reference rounds to 113 bits: less than this is no error of the law (whose bound may be 0).
constexpr double reference_rounding_m = 1e-30;

struct Options {
  std::int64_t problems = 1'000'000;
  std::uint64_t seed = 1;
  int threads = 2;
  std::int64_t arbitrary_bits = 0;
  std::string family;
  std::string only;
};

/// One problem by what it is made of.
struct Draw {
  const Family* family = nullptr;
  int n = 0;
  bool drags = false;
  std::uint64_t seed = 0;
};

/// The finaliser of splitmix64: every bit of the result depends on every bit of `x`.
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ull;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ull;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBull;
  return x ^ (x >> 31);
}

/// How many primitives problem `index` of a family has: most have up to 8, one of 5000 has 1000.
int primitives_of(std::int64_t index) {
  if (index % 5000 == 2500) return most_primitives;
  Random random(mixed(static_cast<std::uint64_t>(index) + 77));
  const int cell = random.below(1000);
  if (cell < 10) return 0;
  if (cell < 250) return 1 + random.below(2);
  if (cell < 700) return 3 + random.below(4);
  if (cell < 900) return 5 + random.below(6);
  if (cell < 985) return 9 + random.below(8);
  return 17 + random.below(48);
}

Draw draw(const Options& options, std::size_t family, std::int64_t index) {
  return {&test::families()[family], primitives_of(index / 2), index % 2 == 1,
          mixed(mixed(mixed(options.seed) + family) + static_cast<std::uint64_t>(index))};
}

Problem problem_of(const Draw& d) {
  Random random(d.seed);
  return d.family->make(random, d.n, d.drags);
}

struct Answer {
  Balance balance;
  double error_m = 0.0;  ///< against the reference; NaN where that is not certified
  double plain_bound_m = 0.0;
};

struct Solved {
  Draw draw;
  int refused = 0;
  bool certified = false;
  double reference_bound_m = 0.0;
  Answer cold;
  Answer warm;
};

/// One thread's solver and set.
class Bench {
 public:
  Solved solve(const Draw& d) {
    const Problem problem = problem_of(d);
    test::fill(set_, problem);
    Solved solved;
    solved.draw = d;
    solved.refused = set_.dropped();
    const test::Reference reference = test::reference_balance(problem);
    solved.certified = reference.certified;
    solved.reference_bound_m = static_cast<double>(reference.bound_m);
    solver_.reset();
    solved.cold = answer(problem, problem.probe_m, reference);
    Random random(~d.seed);
    const Vec3 before_m = problem.probe_m + 1e-4 * random.direction();
    solver_.reset();
    solver_.solve(set_, problem.start_m, before_m, problem.stiffness_n_per_m, problem.time_step_s);
    solved.warm = answer(problem, problem.probe_m, reference);
    return solved;
  }

  const Solver& solver() const { return solver_; }

 private:
  Answer answer(const Problem& problem, const Vec3& probe_m, const test::Reference& reference) {
    Answer a;
    a.balance = solver_.solve(set_, problem.start_m, probe_m, problem.stiffness_n_per_m, problem.time_step_s);
    a.error_m = reference.certified ? test::error_m(reference, a.balance.position_m) : std::nan("");
    if (a.error_m < reference_rounding_m) a.error_m = 0.0;
    a.plain_bound_m = test::plain_bound_m(problem, solver_.forces_n(), a.balance.position_m, solver_.remainder_m());
    return a;
  }

  PrimitiveSet set_{most_primitives};
  Solver solver_{most_primitives};
};

/// Not a promise kept: the true error above the returned bound, above 1e-9 m where the answer calls itself exact, a
/// number that is not finite, a primitive refused or input called bad.
bool fails(const Solved& s) {
  if (s.refused > 0) return true;
  for (const Answer* a : {&s.cold, &s.warm}) {
    const Balance& b = a->balance;
    if (!is_finite(b.position_m) || !std::isfinite(b.error_bound_m) || b.status == BalanceStatus::bad_input) return true;
    if (!(a->plain_bound_m >= 0.0)) return true;
    if (s.certified && !(a->error_m <= b.error_bound_m)) return true;
    if (s.certified && b.status == BalanceStatus::exact && !(a->error_m <= exact_bound_m)) return true;
  }
  return false;
}

struct FamilyTable {
  std::int64_t problems = 0;
  std::int64_t uncertified = 0;
  std::int64_t failed = 0;
  std::int64_t plain_exact = 0;
  std::int64_t bound_exact = 0;
  std::int64_t capped = 0;
  double error_max_m = 0.0;
  double error_to_bound_max = 0.0;
  double exact_error_max_m = 0.0;
  double plain_bound_max_m = 0.0;
  std::array<std::int64_t, stages> by_stage{};
  int iterations_max = 0;
  std::vector<double> bounds_m;
  std::vector<Solved> failing;
  std::vector<Solved> unusable;  ///< the reference does not certify them
  std::vector<Solved> worst;     ///< the few largest plain bounds above 1e-9 m

  void add(const Solved& s) {
    ++problems;
    if (fails(s)) {
      ++failed;
      failing.push_back(s);
    }
    if (!s.certified) {
      ++uncertified;
      unusable.push_back(s);
    }
    plain_exact += s.cold.plain_bound_m <= exact_bound_m;
    bound_exact += s.cold.balance.error_bound_m <= exact_bound_m;
    if (!(s.cold.plain_bound_m <= exact_bound_m)) add_worst(s);
    capped += s.cold.balance.status == BalanceStatus::capped;
    plain_bound_max_m = std::max(plain_bound_max_m, s.cold.plain_bound_m);
    ++by_stage[static_cast<std::size_t>(std::clamp(s.cold.balance.stage, 0, stages - 1))];
    iterations_max = std::max(iterations_max, s.cold.balance.iterations);
    bounds_m.push_back(s.cold.balance.error_bound_m);
    if (!s.certified) return;
    for (const Answer* a : {&s.cold, &s.warm}) {
      error_max_m = std::max(error_max_m, a->error_m);
      if (a->error_m > 0.0) error_to_bound_max = std::max(error_to_bound_max, a->error_m / a->balance.error_bound_m);
      if (a->balance.status == BalanceStatus::exact) exact_error_max_m = std::max(exact_error_max_m, a->error_m);
    }
  }

  void add(const FamilyTable& t) {
    problems += t.problems, uncertified += t.uncertified, failed += t.failed;
    plain_exact += t.plain_exact, bound_exact += t.bound_exact, capped += t.capped;
    error_max_m = std::max(error_max_m, t.error_max_m);
    error_to_bound_max = std::max(error_to_bound_max, t.error_to_bound_max);
    exact_error_max_m = std::max(exact_error_max_m, t.exact_error_max_m);
    plain_bound_max_m = std::max(plain_bound_max_m, t.plain_bound_max_m);
    iterations_max = std::max(iterations_max, t.iterations_max);
    for (int i = 0; i < stages; ++i) by_stage[i] += t.by_stage[i];
    bounds_m.insert(bounds_m.end(), t.bounds_m.begin(), t.bounds_m.end());
    failing.insert(failing.end(), t.failing.begin(), t.failing.end());
    unusable.insert(unusable.end(), t.unusable.begin(), t.unusable.end());
    for (const Solved& s : t.worst) add_worst(s);
  }

  void add_worst(const Solved& s) {
    constexpr std::size_t kept = 3;
    const auto worse = [](const Solved& a, const Solved& b) {
      return a.cold.plain_bound_m != b.cold.plain_bound_m ? a.cold.plain_bound_m > b.cold.plain_bound_m
                                                          : a.draw.seed < b.draw.seed;
    };
    worst.insert(std::upper_bound(worst.begin(), worst.end(), s, worse), s);
    if (worst.size() > kept) worst.pop_back();
  }

  double share(std::int64_t part) const {
    return problems > 0 ? static_cast<double>(part) / static_cast<double>(problems) : 1.0;
  }
};

std::string reproducing(const Draw& d) {
  return std::string(d.family->name) + "," + std::to_string(d.n) + "," + (d.drags ? "1" : "0") + "," + std::to_string(d.seed);
}

void print_lines(const char* what, std::vector<Solved>& list) {
  if (list.empty()) return;
  std::sort(list.begin(), list.end(), [](const Solved& a, const Solved& b) {
    return std::string_view(a.draw.family->name) != b.draw.family->name
               ? std::string_view(a.draw.family->name) < b.draw.family->name
               : a.draw.seed < b.draw.seed;
  });
  constexpr std::size_t most_lines = 200;
  std::printf("\n%s: %zu\n", what, list.size());
  for (std::size_t i = 0; i < std::min(list.size(), most_lines); ++i) {
    const Solved& s = list[i];
    std::printf("  --only %-60s", reproducing(s.draw).c_str());
    if (!s.certified) std::printf(" reference %.1e m", s.reference_bound_m);
    for (const auto& [name, a] : {std::pair{"cold", &s.cold}, std::pair{"warm", &s.warm}}) {
      std::printf("  %s: error %.2e bound %.2e plain %.2e m, %s, stage %d", name, a->error_m, a->balance.error_bound_m,
                  a->plain_bound_m, s.refused > 0 ? "primitives refused" : name_of(a->balance.status), a->balance.stage);
    }
    std::printf("\n");
  }
  if (list.size() > most_lines) std::printf("  ... and %zu more\n", list.size() - most_lines);
}

/// All problems of the run by family, and again without and with drags.
struct Tables {
  std::vector<FamilyTable> by_family{test::families().size()};
  std::array<FamilyTable, 2> by_drags;

  void add(std::size_t family, const Solved& s) {
    by_family[family].add(s);
    by_drags[s.draw.drags ? 1 : 0].add(s);
  }
  void add(const Tables& t) {
    for (std::size_t i = 0; i < by_family.size(); ++i) by_family[i].add(t.by_family[i]);
    for (std::size_t i = 0; i < by_drags.size(); ++i) by_drags[i].add(t.by_drags[i]);
  }
};

/// Draws every problem once, in `options.threads` threads.
Tables solve_all(const Options& options) {
  std::vector<std::size_t> families;
  for (std::size_t i = 0; i < test::families().size(); ++i) {
    if (options.family.empty() || options.family == test::families()[i].name) families.push_back(i);
  }
  const auto count = static_cast<std::int64_t>(families.size());
  const std::int64_t each = (options.problems + count - 1) / count;
  constexpr std::int64_t at_once = 10;
  std::atomic<std::int64_t> next = 0;
  std::vector<Tables> parts(static_cast<std::size_t>(options.threads));
  const auto work = [&](Tables& part) {
    Bench bench;
    for (;;) {
      const std::int64_t begin = at_once * next++;
      if (begin >= each) return;
      for (const std::size_t family : families) {
        for (std::int64_t i = begin; i < std::min(begin + at_once, each); ++i) {
          part.add(family, bench.solve(draw(options, family, i)));
        }
      }
    }
  };
  std::vector<std::thread> threads;
  for (Tables& part : parts) threads.emplace_back([&work, &part] { work(part); });
  for (std::thread& thread : threads) thread.join();
  Tables tables;
  for (const Tables& part : parts) tables.add(part);
  return tables;
}

void print_head() {
  std::printf("%-34s %8s %6s %9s %8s %9s %9s %10s %9s %9s %9s %7s %23s %5s\n", "family", "problems", "no ref", "max error",
              "max", "max error", "plain", "max plain", "bound", "bound p99", "bound max", "capped", "share by stage [%]",
              "max");
  std::printf("%-34s %8s %6s %9s %8s %9s %9s %10s %9s %9s %9s %7s %5s %5s %5s %5s %5s\n", "", "", "", "[m]", "err/bnd",
              "exact [m]", "<=1e-9 %", "[m]", "<=1e-9 %", "[m]", "[m]", "", "0", "1", "2", "3", "iter");
}

void print_row(const char* name, const FamilyTable& t) {
  std::vector<double> bounds_m = t.bounds_m;
  std::printf("%-34s %8lld %6lld %9.2e %8.2g %9.2e %9.4f %10.2e %9.4f %9.2e %9.2e %7lld", name,
              static_cast<long long>(t.problems), static_cast<long long>(t.uncertified), t.error_max_m, t.error_to_bound_max,
              t.exact_error_max_m, 100.0 * t.share(t.plain_exact), t.plain_bound_max_m, 100.0 * t.share(t.bound_exact),
              detail::quantile(bounds_m, 0.99), detail::quantile(bounds_m, 1.0), static_cast<long long>(t.capped));
  for (const std::int64_t count : t.by_stage) std::printf(" %5.1f", 100.0 * t.share(count));
  std::printf(" %5d\n", t.iterations_max);
}

/// One line of the verdict; whether it is met.
bool verdict(bool met, const std::string& what) {
  std::printf("%-7s %s\n", met ? "met" : "MISSED", what.c_str());
  return met;
}

/// The share of plain bounds at most 1e-9 m that a family must reach.
double wanted_share(const Family& family) {
  const std::string_view name = family.name;
  if (family.at_proxy) return 1.0;
  if (name == "nearly_parallel_lines") return 0.99;
  if (name == "wide_strengths") return 0.96;
  if (name == "mixture" || name == "elastic_mixture") return 0.95;
  if (name == "corner_mixture" || name == "elastic_corner_mixture") return 0.99;
  return 0.999;
}

int measure(const Options& options) {
  const auto begin = std::chrono::steady_clock::now();
  const Tables solved = solve_all(options);
  const std::vector<FamilyTable>& tables = solved.by_family;
  FamilyTable all;
  std::vector<Solved> worst;
  print_head();
  for (std::size_t i = 0; i < tables.size(); ++i) {
    if (tables[i].problems == 0) continue;
    print_row(test::families()[i].name, tables[i]);
    all.add(tables[i]);
    worst.insert(worst.end(), tables[i].worst.begin(), tables[i].worst.end());
  }
  print_row("all without drags", solved.by_drags[0]);
  print_row("all with drags", solved.by_drags[1]);
  print_row("all", all);
  print_lines("problems that the reference does not certify (their errors are not used)", all.unusable);
  print_lines("the largest plain bounds above 1e-9 m, up to three of each family", worst);
  print_lines("failing problems", all.failing);

  std::printf("\n%lld problems, cold and warm, %lld of them without a certified reference, seed %llu, %.0f s\n",
              static_cast<long long>(all.problems), static_cast<long long>(all.uncertified),
              static_cast<unsigned long long>(options.seed),
              std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  bool met = verdict(all.failed == 0, std::to_string(all.failed) +
                                          " problems fail: error above the bound, above 1e-9 m where exact, " +
                                          "not finite, or refused");
  met &= verdict(all.error_to_bound_max <= 1.0, "true error / returned bound at most " + text("%.6g", all.error_to_bound_max));
  met &= verdict(all.exact_error_max_m <= exact_bound_m,
                 "true error where the answer is exact at most " + text("%.3g m", all.exact_error_max_m));
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const Family& family = test::families()[i];
    const FamilyTable& t = tables[i];
    if (t.problems == 0) continue;
    const double wanted = wanted_share(family);
    met &= verdict(t.share(t.plain_exact) >= wanted, std::string(family.name) + ": plain bound <= 1e-9 m in " +
                                                         text("%.4f %%", 100.0 * t.share(t.plain_exact)) +
                                                         " (asked: " + text("%g %%)", 100.0 * wanted));
    if (family.at_proxy) {
      met &= verdict(t.bound_exact == t.problems, std::string(family.name) + ": returned bound <= 1e-9 m in " +
                                                      text("%.4f %%", 100.0 * t.share(t.bound_exact)) + " (asked: 100 %)");
    }
  }
  return met ? 0 : 1;
}

// --only

void print(const char* name, const Vec3& v) { std::printf("%s %.17g %.17g %.17g\n", name, v.x, v.y, v.z); }

void print(const Problem& problem) {
  print("start [m]", problem.start_m);
  print("probe [m]", problem.probe_m);
  std::printf("k [N/m] %.17g   T [s] %.17g\n", problem.stiffness_n_per_m, problem.time_step_s);
  for (const Primitive& p : problem.primitives) {
    std::printf("%-8s strength %.17g N, drag %.17g N s/m", name_of(p.kind), p.strength_n, p.drag_ns_per_m);
    if (p.is_elastic()) std::printf(", stiffness %.17g N/m", p.stiffness_n_per_m);
    print(", at [m]", p.position_m);
    print("         direction", p.direction);
  }
}

int measure_one(const std::string& which) {
  const std::size_t first = which.find(','), second = which.find(',', first + 1), third = which.find(',', second + 1);
  if (third == std::string::npos) {
    std::fputs("bench_solver_accuracy: --only takes FAMILY,N,DRAGS,SEED\n", stderr);
    return 2;
  }
  Draw d;
  d.family = test::family_named(which.substr(0, first));
  d.n = std::atoi(which.c_str() + first + 1);
  d.drags = which[second + 1] == '1';
  d.seed = std::strtoull(which.c_str() + third + 1, nullptr, 10);
  if (d.family == nullptr || d.n < 0 || d.n > most_primitives) {
    std::fputs("bench_solver_accuracy: --only names no family, or not 0 to 1000 primitives; the families are\n", stderr);
    for (const Family& family : test::families()) std::fprintf(stderr, "  %s\n", family.name);
    return 2;
  }
  const Problem problem = problem_of(d);
  print(problem);
  Bench bench;
  const Solved s = bench.solve(d);
  const test::Reference reference = test::reference_balance(problem);
  print("reference [m]",
        {static_cast<double>(reference.x_m[0]), static_cast<double>(reference.x_m[1]), static_cast<double>(reference.x_m[2])});
  std::printf("reference's bound %.3e m, %s, %d iterations; %d primitives refused\n", s.reference_bound_m,
              s.certified ? "certified" : "NOT certified", reference.iterations, s.refused);
  for (const auto& [name, a] : {std::pair{"cold", &s.cold}, std::pair{"warm", &s.warm}}) {
    print(name, a->balance.position_m);
    std::printf("  error %.3e, bound %.3e, plain bound %.3e m; %s, stage %d, %d iterations\n", a->error_m,
                a->balance.error_bound_m, a->plain_bound_m, name_of(a->balance.status), a->balance.stage,
                a->balance.iterations);
  }
  std::printf("%s\n", fails(s) ? "FAILS" : "holds");
  return fails(s) ? 1 : 0;
}

// --arbitrary-bits

/// In runs of some thousand, each from a seed and a solver of its own.
int measure_arbitrary_bits(const Options& options) {
  constexpr std::int64_t in_a_run = 5000;
  std::atomic<std::int64_t> next = 0, problems = 0, bad = 0, refused = 0, capped = 0, wrongs = 0;
  const auto work = [&] {
    for (;;) {
      const std::int64_t index = next++;
      const std::int64_t left = options.arbitrary_bits - in_a_run * index;
      if (left <= 0) return;
      const std::uint64_t seed = mixed(mixed(options.seed) + static_cast<std::uint64_t>(index));
      const test::ArbitraryBits run = test::solve_arbitrary_bits(std::min(in_a_run, left), seed, index % 2 == 1);
      problems += run.problems, bad += run.bad_input, refused += run.refused, capped += run.capped;
      if (run.wrong && wrongs++ < 20) {
        std::printf("solve_arbitrary_bits(%lld, %lluu, %s): %s in problem %lld\n", static_cast<long long>(run.wrong_at + 1),
                    static_cast<unsigned long long>(seed), index % 2 == 1 ? "true" : "false", run.wrong, run.wrong_at);
      }
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < options.threads; ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  std::printf("%lld problems of arbitrary bits: %lld said to be bad input, %lld primitives refused, %lld capped\n",
              static_cast<long long>(problems), static_cast<long long>(bad), static_cast<long long>(refused),
              static_cast<long long>(capped));
  return verdict(wrongs == 0, std::to_string(wrongs) + " runs met a wrong answer: not finite, or bad input not said to be bad")
             ? 0
             : 1;
}

std::optional<Options> options_of(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; i += 2) {
    const std::string_view key = argv[i];
    if (i + 1 >= argc) return std::nullopt;
    const char* value = argv[i + 1];
    if (key == "--problems") {
      options.problems = std::atoll(value);
    } else if (key == "--seed") {
      options.seed = std::strtoull(value, nullptr, 10);
    } else if (key == "--threads") {
      options.threads = std::atoi(value);
    } else if (key == "--arbitrary-bits") {
      options.arbitrary_bits = std::atoll(value);
    } else if (key == "--family") {
      options.family = value;
    } else if (key == "--only") {
      options.only = value;
    } else {
      return std::nullopt;
    }
  }
  if (options.problems < 1 || options.threads < 1 || options.arbitrary_bits < 0) return std::nullopt;
  if (!options.family.empty() && !test::family_named(options.family)) return std::nullopt;
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  const std::optional<Options> options = options_of(argc, argv);
  if (!options) {
    std::fputs(
        "usage: bench_solver_accuracy [--problems N] [--seed N] [--threads N] [--family NAME] [--arbitrary-bits N]\n"
        "       bench_solver_accuracy --only FAMILY,N,DRAGS,SEED\n",
        stderr);
    return 2;
  }
  if (!options->only.empty()) return measure_one(options->only);
  if (options->arbitrary_bits > 0) return measure_arbitrary_bits(*options);
  return measure(*options);
}
