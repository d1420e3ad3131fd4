// Seconds for a picture of a scene under a hand, reading included.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <vector>

#include "palpa/session/session.h"
#include "palpa/study/run.h"
#include "palpa/view/picture.h"

namespace {

using namespace palpa;

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

std::vector<PathPoint> felt_path(const Scene& scene, SimulatedDevice& hand, double duration_s) {
  constexpr double dt_s = 1e-3;
  Session session(scene);
  std::vector<PathPoint> path;
  for (int i = 0; i < static_cast<int>(duration_s / dt_s); ++i) {
    const DeviceState state = hand.read();
    const Tick tick = session.tick({.position_m = state.position_m}, dt_s);
    path.push_back({state.position_m, tick.proxy_m, tick.force_n});
    hand.write(tick.force_n);
    hand.advance(dt_s);
  }
  return path;
}

int measure(const RunOptions& options) {
  std::printf("%8s %8s %8s %8s %8s\n", "read_s", "felt_s", "draw_s", "png_s", "read/%");
  for (int round = 0; round < 3; ++round) {
    const double start_s = now_s();
    const PreparedRun prepared = prepare(options);
    const double read_s = now_s();
    const std::vector<PathPoint> path = felt_path(prepared.loaded.scene, *prepared.hand, std::min(prepared.duration_s, 10.0));
    const double felt_s = now_s();
    const Picture picture = scene_picture(prepared.loaded.scene, path, {});
    const double drawn_s = now_s();
    const std::string png = png_of(picture);
    const double end_s = now_s();
    const double picture_s = (read_s - start_s) + (end_s - felt_s);
    std::printf("%8.2f %8.2f %8.2f %8.2f %8.0f   %.2f s a picture, %zu bytes\n", read_s - start_s, felt_s - read_s,
                drawn_s - felt_s, end_s - drawn_s, 100.0 * (read_s - start_s) / picture_s, picture_s, png.size());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3 || argc > 4) {
    std::fprintf(stderr, "usage: %s SCENE HAND [DATA_FOLDER]\n", argv[0]);
    return 2;
  }
  RunOptions options;
  options.scene = argv[1];
  options.hand = argv[2];
  if (argc > 3) options.scene_options.data_folders = {argv[3]};
  try {
    return measure(options);
  } catch (const LoadError& error) {
    std::fprintf(stderr, "bench_pictures: %s\n", error.what());
    return 2;
  }
}
