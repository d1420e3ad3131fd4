// Throughput of a slice's map on one core and on all: probe positions and points per second.
//
//   bench_map SCENE [POINTS [DATA_FOLDER]]
#include "palpa/study/map.h"

#include <palpa/palpa.h>

#include <cstdio>
#include <cstdlib>
#include <thread>

#include "palpa/file/read_volume.h"

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: %s SCENE [POINTS [DATA_FOLDER]]\n", argv[0]);
    return 2;
  }
  try {
    palpa::SceneOptions options;
    if (argc > 3) options.data_folders = {argv[3]};
    const palpa::LoadedScene loaded = palpa::load_scene(argv[1], palpa::volume_reader(), palpa::standard_modes(), options);
    const int points = argc > 2 ? std::atoi(argv[2]) : 256;
    std::puts("| slice | cores | s | points/s | probe positions/s | times one core |\n|---|---|---|---|---|---|");
    for (const int axis : {0, 1}) {
      double one_core_s = 0.0;
      for (int threads = 1; threads <= static_cast<int>(std::thread::hardware_concurrency()); threads *= 2) {
        palpa::ForceMap map(palpa::map_slice(axis, 0.0, 0.18, points));
        const palpa::MapWork work = palpa::feel_map(loaded.scene, map, {.threads = threads});
        if (threads == 1) one_core_s = work.seconds;
        std::printf("| across %c, %d² | %d | %.2f | %.0f | %.0f | %.2f |\n", "xyz"[axis], points, work.threads, work.seconds,
                    static_cast<double>(work.points) / work.seconds, static_cast<double>(work.ticks) / work.seconds,
                    one_core_s / work.seconds);
        std::fflush(stdout);
      }
    }
    return 0;
  } catch (const palpa::LoadError& error) {
    std::fprintf(stderr, "bench_map: %s\n", error.what());
    return 2;
  }
}
