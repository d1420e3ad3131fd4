// The measured program of bench_versions: one scene under one hand, whose path is recorded once and replayed in every version.
//
//   bench_tick_cost record SCENE HAND TICKS PROBES [DATA]     a firm hand's probes to the file PROBES
//   bench_tick_cost hot SCENE PROBES [DATA]                   microseconds per tick of some passes, a line each
//   bench_tick_cost count SCENE PROBES [DATA]                 the number of ticks under valgrind's callgrind
//   bench_tick_cost lines SCENE PROBES [DATA]                 the number of ticks that callgrind dumps one by one
//   bench_tick_cost prefilter VOXELS                          milliseconds of the cubic filter's preparation, a line each
//
// SCENE is a file; "five", five modes on 256³ voxels under a hand without a name; or "empty:FILE", a file's scene with no mode
// enabled. callgrind must begin with --instr-atstart=no.
#include <palpa/loop/loop.h>
#include <palpa/palpa.h>
#include <time.h>
#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#else  // no counts without valgrind's header
#define CALLGRIND_START_INSTRUMENTATION
#define CALLGRIND_STOP_INSTRUMENTATION
#define CALLGRIND_DUMP_STATS
#endif

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <string>
#include <string_view>

#include "bench/five_modes.h"
#include "palpa/device/hand.h"
#include "palpa/study/run.h"
#include "palpa/trace/trace.h"

namespace {

using namespace palpa;
using Clock = std::chrono::steady_clock;

constexpr double dt_s = 1e-3;
constexpr int passes = 5;
constexpr std::string_view disabled = "empty:";

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// This thread's processor time, independent of other load.
double thread_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

RunOptions options_of(std::string_view scene, const char* data) {
  RunOptions options;
  options.scene = scene.starts_with(disabled) ? scene.substr(disabled.size()) : scene;
  options.hold = Hold::firm;
  options.recording.center = true;
  if (data) options.scene_options.data_folders = {data};
  return options;
}

Scene scene_of(std::string_view name, const char* data) {
  if (name == "five") return bench::five_modes({bench::ball_on(256), bench::flow_on(256), bench::warmth_on(256)}, {});
  const RunOptions options = options_of(name, data);
  Scene scene = load_scene(options.scene, volume_reader(), standard_modes(), options.scene_options).scene;
  if (name.starts_with(disabled)) {
    for (const SceneMode& mode : std::vector<SceneMode>(scene.modes()))
      scene.edit_mode(mode.name, [](SceneMode& one) { one.enabled = false; });
  }
  return scene;
}

std::vector<Vec3> way_of_hand(std::string_view name, const std::string& hand, int ticks, const char* data) {
  std::vector<Vec3> way_m;
  if (name == "five") {
    bench::Round round(bench::ball_m - bench::deep_m);
    way_m.push_back((1.0 + 2.0 * bench::deep_m / bench::ball_m) * round.next());
    while (static_cast<int>(way_m.size()) < ticks) way_m.push_back(round.next());
    return way_m;
  }
  RunOptions options = options_of(name, data);
  options.hand = hand;
  PreparedRun prepared = prepare(options);
  Session session(prepared.loaded.scene);
  run_simulated(session, *prepared.hand, {.rate_hz = 1.0 / dt_s, .duration_s = ticks * dt_s}, nullptr,
                [&](const TickFrame& frame, const Session&) { way_m.push_back(frame.result.probe_m); });
  return way_m;
}

std::vector<Vec3> read_way(const char* file) {
  std::ifstream in(file);
  std::vector<Vec3> way_m;
  for (Vec3 x; in >> x.x >> x.y >> x.z;) way_m.push_back(x);
  if (way_m.size() < 2) throw LoadError(std::string(file) + ": no probes");
  return way_m;
}

void record(const std::vector<Vec3>& way_m, const char* file) {
  std::ofstream out(file);
  out << std::setprecision(17);
  for (const Vec3& x : way_m) out << x.x << ' ' << x.y << ' ' << x.z << '\n';
  if (!out.flush()) throw LoadError(std::string(file) + ": cannot be written");
}

void hot(const Scene& scene, const std::vector<Vec3>& way_m) {
  for (int pass = 0; pass < passes; ++pass) {
    Session session(scene);
    const double begin_s = thread_seconds();
    for (const Vec3& x : way_m) session.tick({.position_m = x}, dt_s);
    std::printf("%.6f\n", 1e6 * (thread_seconds() - begin_s) / static_cast<double>(way_m.size()));
  }
}

void count(const Scene& scene, const std::vector<Vec3>& way_m) {
  Session session(scene);
  session.tick({.position_m = way_m[0]}, dt_s);
  CALLGRIND_START_INSTRUMENTATION;
  for (std::size_t i = 1; i < way_m.size(); ++i) session.tick({.position_m = way_m[i]}, dt_s);
  CALLGRIND_STOP_INSTRUMENTATION;
  std::printf("%zu\n", way_m.size() - 1);
}

void lines(const Scene& scene, const std::vector<Vec3>& way_m) {
  constexpr std::size_t shown = 100;
  const std::size_t every = std::max<std::size_t>(1, way_m.size() / shown);
  Session session(scene);
  std::size_t dumped = 0;
  for (std::size_t i = 0; i < way_m.size(); ++i) {
    const bool shows = i % every == every - 1;
    if (shows) CALLGRIND_START_INSTRUMENTATION;
    session.tick({.position_m = way_m[i]}, dt_s);
    if (shows) {
      CALLGRIND_STOP_INSTRUMENTATION;
      CALLGRIND_DUMP_STATS;
      ++dumped;
    }
  }
  std::printf("%zu\n", dumped);
}

void prefilter(int voxels) {
  GridGeometry geometry;
  geometry.dims = {voxels, voxels, voxels};
  auto values = std::make_shared<std::vector<float>>(static_cast<std::size_t>(geometry.voxels()));
  for (std::size_t i = 0; i < values->size(); ++i) (*values)[i] = static_cast<float>(i * 2654435761u % 4096);
  const FieldPtr field = grid_field(geometry, {VoxelType::float32, 1, {values, values->data()}});
  for (int pass = 0; pass < passes; ++pass) {
    const auto begin = Clock::now();
    const FieldPtr made = filtered(field, Filter::cubic);
    std::printf("%.3f\n", 1e3 * seconds_since(begin));
  }
}

int usage() {
  std::fprintf(stderr,
               "usage: bench_tick_cost record SCENE HAND TICKS PROBES [DATA] | hot|count|lines SCENE PROBES [DATA] | "
               "prefilter VOXELS\n");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view what = argc > 1 ? argv[1] : "";
  try {
    if (what == "prefilter" && argc == 3) {
      prefilter(std::max(8, std::atoi(argv[2])));
    } else if (what == "record" && (argc == 6 || argc == 7)) {
      record(way_of_hand(argv[2], argv[3], std::atoi(argv[4]), argc > 6 ? argv[6] : nullptr), argv[5]);
    } else if (argc == 4 || argc == 5) {
      const Scene scene = scene_of(argv[2], argc > 4 ? argv[4] : nullptr);
      const std::vector<Vec3> way_m = read_way(argv[3]);
      if (what == "hot") {
        hot(scene, way_m);
      } else if (what == "count") {
        count(scene, way_m);
      } else if (what == "lines") {
        lines(scene, way_m);
      } else {
        return usage();
      }
    } else {
      return usage();
    }
  } catch (const LoadError& error) {
    std::fprintf(stderr, "bench_tick_cost: %s\n", error.what());
    return 2;
  }
  return 0;
}
