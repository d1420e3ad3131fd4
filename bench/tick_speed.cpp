// Time of a tick: five modes on volumes of 256³, with caches evicted and under a recorded hand, and one surface on volumes of
// 128³ to 1024³.
//
//   bench_tick_speed [--part evicted|hot|sizes]… [--ticks N] [--hand FILE] [--pages small|huge]
//
// Without --part: evicted, sizes, and with a hand hot. --ticks: evicted ticks of each table's row instead of 2000. --hand: a
// recorded hand (hand.h), held firmly. --pages: of the voxels. Pins itself to its first core. Times are by the cycle counter;
// ticks with a context switch or a page fault are counted apart.
#include <palpa/device/hand.h>
#include <palpa/loop/loop.h>
#include <palpa/palpa.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "bench/five_modes.h"
#include "bench/solver_clock.h"
#include "palpa/data/quantile.h"
#include "palpa/trace/trace.h"

namespace {

using namespace palpa;
using namespace palpa::bench;

constexpr double dt_s = 1e-3;

struct Options {
  std::vector<std::string_view> parts;
  int ticks = 2000;
  std::string hand;
  bool wants(std::string_view part) const {
    return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
  }
};

const char* interpolants_of(std::optional<Filter> filter) {
  return filter ? "trilinear; what is derived (q, smooth) is smooth" : "int16 smooth, float trilinear; q and smooth smooth";
}

/// 64 MiB in small pages: a write evicts all other memory, code too, from caches and TLB.
class Other {
 public:
  Other() : data_(static_cast<unsigned char*>(std::aligned_alloc(1 << 21, bytes))) {
    ::madvise(data_, bytes, MADV_NOHUGEPAGE);
    for (std::size_t i = 0; i < bytes; ++i) data_[i] = 1;
  }
  ~Other() { std::free(data_); }
  Other(const Other&) = delete;
  Other& operator=(const Other&) = delete;
  void evict() noexcept {
    for (std::size_t i = 0; i < bytes; i += 64) ++data_[i];
  }

 private:
  static constexpr std::size_t bytes = std::size_t{64} << 20;
  unsigned char* data_;
};

struct Disturbed {
  long switches = 0, faults = 0;
  static Disturbed now() noexcept {
    rusage use{};
    ::getrusage(RUSAGE_THREAD, &use);
    return {use.ru_nvcsw + use.ru_nivcsw, use.ru_minflt + use.ru_majflt};
  }
};

struct Times {
  std::vector<double> us;
  std::vector<double> sub_steps;
  int switched = 0, faulted = 0;  // counted apart
  double of(double share) { return detail::quantile(us, share); }
};

/// \param warms_code  session of other data, felt alike behind each eviction: the code is in the caches then, the data are not
Times measure(const Scene& scene, double reach_m, int ticks, Other* other, Session* warms_code = nullptr) {
  const bench::Clock clock;
  Session session(scene);
  Round round(reach_m);
  const auto tick_both = [&](const Probe& probe) {
    session.tick(probe, dt_s);
    if (warms_code) warms_code->tick(probe, dt_s);
  };
  tick_both({.position_m = (1.0 + 2.0 * deep_m / ball_m) * ball_m / reach_m * round.next()});
  for (int i = 0; i < 200; ++i) tick_both({.position_m = round.next()});
  Times times;
  times.us.reserve(static_cast<std::size_t>(ticks));
  times.sub_steps.reserve(static_cast<std::size_t>(ticks));
  while (static_cast<int>(times.us.size()) < ticks) {
    const Probe probe{.position_m = round.next()};
    if (other) other->evict();
    if (warms_code) warms_code->tick(probe, dt_s);
    const Disturbed before = Disturbed::now();
    const std::uint64_t begin = bench::Clock::now();
    const Tick tick = session.tick(probe, dt_s);
    const std::uint64_t end = bench::Clock::now();
    const Disturbed after = Disturbed::now();
    times.switched += after.switches != before.switches;
    times.faulted += after.faults != before.faults;
    if (after.switches != before.switches || after.faults != before.faults) continue;
    times.us.push_back(1e-3 * (clock.ns_between(begin, end) - clock.own_ns()));
    times.sub_steps.push_back(tick.sub_steps);
  }
  return times;
}

double mean(const std::vector<double>& numbers) {
  double sum = 0.0;
  for (const double n : numbers) sum += n;
  return sum / static_cast<double>(numbers.size());
}

void evicted(const Options& options) {
  Other other;
  const Volumes volumes{ball_on(256), flow_on(256), warmth_on(256)};
  const Volumes others{ball_on(256), flow_on(256), warmth_on(256)};
  std::printf("Five modes (skin, gradient force, follow, viscosity, vortex plane) on 256^3: int16, float32 x 3, int16\n");
  std::printf("hand %.2f m/s, voxel %.3f mm, voxels in %s pages\n", hand_m_per_s, 1e3 * edge_m / 255.0,
              huge_pages ? "huge" : "small");
  std::printf("%-52s %-12s %8s %8s %8s %9s %9s %9s\n", "interpolants", "caches", "p50 us", "p99 us", "max us", "sub-steps",
              "switched", "faulted");
  for (const std::optional<Filter> filter : {std::optional<Filter>{}, std::optional<Filter>{Filter::trilinear}}) {
    const Scene scene = five_modes(volumes, filter);
    Session warms_code(five_modes(others, filter));
    const auto print = [&](const char* caches, Times t) {
      std::printf("%-52s %-12s %8.2f %8.2f %8.2f %9.2f %9d %9d\n", interpolants_of(filter), caches, t.of(0.5), t.of(0.99),
                  t.of(1.0), mean(t.sub_steps), t.switched, t.faulted);
    };
    print("hot", measure(scene, ball_m - deep_m, 20 * options.ticks, nullptr));
    print("data evicted", measure(scene, ball_m - deep_m, options.ticks, &other, &warms_code));
    print("evicted", measure(scene, ball_m - deep_m, options.ticks, &other));
  }
}

void sizes(const Options& options) {
  Other other;
  std::printf("One surface with friction on int16, smooth, caches evicted, hand %.2f m/s, voxels in %s pages\n", hand_m_per_s,
              huge_pages ? "huge" : "small");
  std::printf("%8s %8s %8s %8s %9s %9s %9s\n", "voxels", "p50 us", "p99 us", "of 128^3", "sub-steps", "switched", "faulted");
  double first_us = 0.0;
  for (const int voxels : {128, 256, 512, 1024}) {
    Scene scene = in_reach({});
    const FieldRef body = scene.add("body", ball_on(voxels));
    scene.add("skin", skin_of(body));
    Times t = measure(scene, ball_m - deep_m, options.ticks, &other);
    if (first_us == 0.0) first_us = t.of(0.5);
    std::printf("%6d^3 %8.2f %8.2f %8.2f %9.2f %9d %9d\n", voxels, t.of(0.5), t.of(0.99), t.of(0.5) / first_us,
                mean(t.sub_steps), t.switched, t.faulted);
  }
}

void hot(const Options& options) {
  const Volumes volumes{ball_on(256), flow_on(256), warmth_on(256)};
  std::printf("The same five modes under %s, held firmly, 1000 Hz\n", options.hand.c_str());
  std::printf("%-52s %9s %9s %9s %9s %9s\n", "interpolants", "ticks", "ticks/s", "us", "sub-steps", "contact");
  for (const std::optional<Filter> filter : {std::optional<Filter>{}, std::optional<Filter>{Filter::trilinear}}) {
    const Scene scene = five_modes(volumes, filter, {0.0, 0.0, ball_m});
    const std::unique_ptr<SimulatedDevice> hand = open_hand(options.hand, Hold::firm);
    std::vector<Probe> probes;
    std::vector<double> sub_steps;
    int pressed = 0;
    Session session(scene);
    run_simulated(session, *hand, {.rate_hz = 1.0 / dt_s, .duration_s = hand->duration_s()}, nullptr,
                  [&](const TickFrame& frame, const Session& felt) {
                    probes.push_back({.position_m = frame.result.probe_m,
                                      .velocity_m_per_s = frame.result.probe_velocity_m_per_s,
                                      .valid = frame.result.probe_valid});
                    sub_steps.push_back(frame.result.sub_steps);
                    pressed += norm(felt.modes()[0].force_n) > 0.0;
                  });
    double best_s = 1e9;
    for (int pass = 0; pass < 3; ++pass) {
      const bench::Clock clock;
      Session again(scene);
      const std::uint64_t begin = bench::Clock::now();
      for (const Probe& probe : probes) again.tick(probe, dt_s);
      best_s = std::min(best_s, 1e-9 * clock.ns_between(begin, bench::Clock::now()));
    }
    const double count = static_cast<double>(probes.size());
    std::printf("%-52s %9zu %9.0f %9.2f %9.2f %8.1f%%\n", interpolants_of(filter), probes.size(), count / best_s,
                1e6 * best_s / count, mean(sub_steps), 100.0 * pressed / count);
  }
}

void stay_on_this_core() {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(static_cast<std::size_t>(std::max(0, ::sched_getcpu())), &cores);
  if (::sched_setaffinity(0, sizeof(cores), &cores) != 0) std::printf("not pinned to a core\n");
}

int usage() {
  std::fprintf(stderr,
               "usage: bench_tick_speed [--part evicted|hot|sizes]... [--ticks N] [--hand FILE] [--pages small|huge]\n");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (i + 1 >= argc) return usage();
    const char* value = argv[++i];
    if (argument == "--part") {
      options.parts.emplace_back(value);
    } else if (argument == "--ticks") {
      options.ticks = std::max(100, std::atoi(value));
    } else if (argument == "--pages") {
      huge_pages = std::string_view(value) == "huge";
    } else if (argument == "--hand") {
      options.hand = value;
    } else {
      return usage();
    }
  }
  try {
    stay_on_this_core();
    if (options.wants("evicted")) evicted(options);
    if (options.wants("sizes")) sizes(options);
    if (options.wants("hot") && !options.hand.empty()) hot(options);
  } catch (const LoadError& error) {
    std::fprintf(stderr, "bench_tick_speed: %s\n", error.what());
    return 1;
  }
  return 0;
}
