// Timing of a live loop: against a bare loop, with and without rehearsals, under scene changes, and with busy processors and
// foreign caches.
//
//   bench_live SCENE HAND DATA_FOLDER [SECONDS [RATE_HZ [loaded]]]
//
// SECONDS (60) are for each kind, in interleaved blocks of 5 s, so that other load of the machine meets all kinds alike. A
// trace is written throughout.
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <numeric>
#include <thread>
#include <vector>

#include "palpa/device/hand.h"
#include "palpa/device/paced_hand.h"
#include "palpa/loop/loop.h"
#include "palpa/study/run.h"

namespace {

using namespace palpa;

constexpr double block_s = 5.0;

struct Kind {
  const char* name;
  bool is_bare = false, rehearses = true;
  double changes_per_s = 0.0;
  double swaps_per_s = 0.0;
  std::vector<float> late_us{}, tick_us{};
  std::int64_t missed = 0, ticks = 0, scenes = 0;
  double jump_n = 0.0;  // the largest between two ticks
};

double now_s(clockid_t clock = CLOCK_MONOTONIC) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

long resident_kib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmRSS:", 0) == 0) return std::atol(line.c_str() + 6);
  return 0;
}

class Load {
 public:
  explicit Load(bool is_wanted) {
    if (is_wanted) thread_ = std::thread([this] { run(); });
  }
  ~Load() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;

 private:
  void run() {
    std::vector<unsigned char> other(std::size_t{64} << 20);
    while (!ends_)
      for (std::size_t byte = 0; byte < other.size() && !ends_; byte += 64) ++other[byte];
  }
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

void bare_block(Kind& kind, double rate_hz) {
  const RealTimeThread real_time;
  const double begin_s = now_s() + 0.01;
  for (std::int64_t n = 0; static_cast<double>(n) < block_s * rate_hz; ++n) {
    const double deadline_s = begin_s + static_cast<double>(n) / rate_hz, whole_s = std::floor(deadline_s);
    const timespec until{.tv_sec = static_cast<time_t>(whole_s), .tv_nsec = static_cast<long>(1e9 * (deadline_s - whole_s))};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
    const double late_s = now_s() - deadline_s;
    kind.late_us.push_back(static_cast<float>(1e6 * late_s));
    ++kind.ticks;
    const auto skipped = static_cast<std::int64_t>(late_s * rate_hz);
    kind.missed += skipped;
    n += skipped;
  }
}

/// The recording from a later moment on, repeated.
class Later final : public Target {
 public:
  Later(std::shared_ptr<const Target> target, double begin_s) : target_(std::move(target)), begin_s_(begin_s) {}
  Point at(double time_s) const noexcept override { return target_->at(std::fmod(begin_s_ + time_s, target_->duration_s())); }
  double duration_s() const noexcept override { return std::numeric_limits<double>::infinity(); }

 private:
  std::shared_ptr<const Target> target_;
  double begin_s_;
};

std::unique_ptr<SimulatedDevice> hand_at(const PreparedRun& prepared, double begin_s) {
  return hand_device(std::make_shared<Later>(prepared.target, begin_s), Hold::rigid);
}

void change(Scene& scene, std::int64_t n, bool is_swap) {
  if (is_swap) {
    return scene.edit_mode(scene.modes().back().name, [&](SceneMode& mode) { mode.enabled = n % 2 == 0; });
  }
  scene.edit<CouplingOptions>([&](auto& coupling) { coupling.damping_ns_per_m = 0.2 + 0.1 * static_cast<double>(n % 2); });
}

void live_block(Kind& kind, const PreparedRun& prepared, double begin_s, double rate_hz, Recorder& recorder) {
  const auto hand = hand_at(prepared, begin_s);
  PacedHand paced(*hand);
  LiveScene scene(prepared.loaded.scene);
  LiveOptions options{.rate_hz = rate_hz, .duration_s = block_s, .rehearse = kind.rehearses};
  options.guard = guard_options_for(hand->limits(), prepared.loaded.scene.coupling().max_force_n);
  LiveLoop loop(scene, paced, options, &recorder);
  std::atomic<bool> stop{false}, ended{false};
  std::thread felt([&] {
    const RealTimeThread real_time;
    Vec3 last_n;
    std::int64_t last = -1;
    loop.run(stop, [&](const TickFrame& frame, const Session&) {
      kind.late_us.push_back(static_cast<float>(frame.late_us));
      kind.tick_us.push_back(static_cast<float>(frame.tick_us));
      // The hand's own motion in a skipped tick does not count.
      if (frame.tick == last + 1) kind.jump_n = std::max(kind.jump_n, distance(frame.command.force_n, last_n));
      last_n = frame.command.force_n;
      last = frame.tick;
    });
    ended = true;
  });
  const double per_s = std::max(kind.changes_per_s, kind.swaps_per_s);
  for (std::int64_t n = 1; !ended; ++n) {
    std::this_thread::sleep_for(std::chrono::duration<double>(per_s > 0.0 ? 1.0 / per_s : 0.01));
    if (per_s > 0.0) scene.change([&](Scene& changed) { change(changed, n, kind.swaps_per_s > 0.0); });
  }
  felt.join();
  const LoopStatistics statistics = loop.statistics();
  kind.missed += statistics.missed;
  kind.ticks += statistics.ticks;
  kind.scenes += statistics.scenes;
}

double hot_mean_us(const PreparedRun& prepared, double seconds, double rate_hz) {
  const auto made = hand_at(prepared, 0.0);
  SimulatedDevice& hand = *made;
  Session session(prepared.loaded.scene);
  GuardedSession guarded(session, hand.limits().max_force_n);
  const auto ticks = static_cast<std::int64_t>(seconds * rate_hz);
  double spent_s = 0.0;
  for (std::int64_t n = 0; n < ticks; ++n) {
    hand.advance(1.0 / rate_hz);
    const DeviceState state = hand.read();
    const double begin_s = now_s(CLOCK_THREAD_CPUTIME_ID);
    const TickFrame frame =
        guarded.tick(n, static_cast<double>(n) / rate_hz, 1.0 / rate_hz,
                     {.position_m = state.position_m, .velocity_m_per_s = state.velocity_m_per_s, .valid = state.valid});
    spent_s += now_s(CLOCK_THREAD_CPUTIME_ID) - begin_s;
    hand.write(frame.command.force_n);
  }
  return 1e6 * spent_s / static_cast<double>(ticks);
}

void print(const char* what, std::vector<float> times_us) {
  if (times_us.empty()) return;
  std::sort(times_us.begin(), times_us.end());
  const auto at = [&](double share) {
    return static_cast<double>(times_us[static_cast<std::size_t>(share * static_cast<double>(times_us.size() - 1))]);
  };
  std::printf("  %-22s p50 %7.1f  p99 %7.1f  p99.9 %7.1f  max %8.1f us\n", what, at(0.5), at(0.99), at(0.999), at(1.0));
}
double at(std::vector<float> times_us, double share) {
  std::sort(times_us.begin(), times_us.end());
  return times_us.empty()
             ? 0.0
             : static_cast<double>(times_us[static_cast<std::size_t>(share * static_cast<double>(times_us.size() - 1))]);
}

void measure(const RunOptions& options, double seconds, double rate_hz, bool loaded) {
  const PreparedRun prepared = prepare(options);
  const double hot_us = hot_mean_us(prepared, seconds, rate_hz);
  Kind kinds[] = {{.name = "bare loop", .is_bare = true},
                  {.name = "with rehearsals"},
                  {.name = "without", .rehearses = false},
                  {.name = "200 changes a second", .changes_per_s = 200.0},
                  {.name = "20 swaps a second", .swaps_per_s = 20.0}};
  for (Kind& kind : kinds) {
    kind.late_us.reserve(static_cast<std::size_t>((seconds + 2 * block_s) * rate_hz));
    kind.tick_us.reserve(kind.late_us.capacity());
  }
  const auto folder = std::filesystem::temp_directory_path() / ("palpa-bench-live-" + std::to_string(::getpid()));
  std::vector<std::string> modes;
  for (const SceneMode& mode : prepared.loaded.scene.modes()) modes.push_back(mode.name);
  const Load load(loaded);
  long first_kib = 0;
  {
    TraceWriter writer(folder, {.motors = true}, "", modes);
    Recorder recorder(writer);
    for (double felt_s = 0.0; felt_s < seconds; felt_s += block_s) {
      for (Kind& kind : kinds) {
        if (kind.is_bare)
          std::thread([&] { bare_block(kind, rate_hz); }).join();
        else
          live_block(kind, prepared, felt_s, rate_hz, recorder);
      }
      if (first_kib == 0) first_kib = resident_kib();
    }
  }
  std::filesystem::remove_all(folder);
  std::printf("%g Hz%s, %g s of each, hot mean of a tick %.1f us\n", rate_hz, loaded ? ", loaded" : "", seconds, hot_us);
  for (const Kind& kind : kinds) {
    std::printf("%s: missed %lld of %lld ticks", kind.name, static_cast<long long>(kind.missed),
                static_cast<long long>(kind.missed + kind.ticks));
    if (kind.scenes > 0) std::printf(", %lld scenes", static_cast<long long>(kind.scenes));
    if (!kind.is_bare) std::printf(", largest step of the force %.4f N", kind.jump_n);
    std::puts("");
    print("late", kind.late_us);
    if (kind.is_bare) continue;
    print("tick (processor)", kind.tick_us);
    std::printf("  against the hot mean   p50 %.2f  p99 %.2f\n", at(kind.tick_us, 0.5) / hot_us,
                at(kind.tick_us, 0.99) / hot_us);
  }
  std::printf("memory: %ld KiB after the first round, %ld KiB at the end\n", first_kib, resident_kib());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4 || argc > 7) {
    std::fprintf(stderr, "usage: %s SCENE HAND DATA_FOLDER [SECONDS [RATE_HZ [loaded]]]\n", argv[0]);
    return 2;
  }
  RunOptions options;
  options.scene = argv[1];
  options.hand = argv[2];
  options.scene_options.data_folders = {argv[3]};
  try {
    measure(options, argc > 4 ? std::atof(argv[4]) : 60.0, argc > 5 ? std::atof(argv[5]) : 1000.0,
            argc > 6 && std::strcmp(argv[6], "loaded") == 0);
  } catch (const LoadError& error) {
    std::fprintf(stderr, "bench_live: %s\n", error.what());
    return 2;
  }
}
