// Prints every number of every tick and its primitives exactly, for a comparison of builds.
//
//   ticks_to_compare SCENE HAND DURATION_S [DATA_FOLDER]
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "palpa/device/hand.h"
#include "palpa/file/read_volume.h"
#include "palpa/mode/mode.h"
#include "palpa/scene/load_scene.h"
#include "palpa/session/session.h"

namespace {

using namespace palpa;

constexpr double tick_s = 1e-3;

void print(const Vec3& v) { std::printf("%a %a %a ", v.x, v.y, v.z); }

void print(const Tick& tick) {
  for (const Vec3& v : {tick.probe_m, tick.proxy_m, tick.proxy_velocity_m_per_s, tick.force_n}) print(v);
  std::printf("%a %d %d %d %d %d\n", tick.error_bound_m, tick.sub_steps, tick.iterations, static_cast<int>(tick.status),
              tick.dropped, tick.work);
}

void print(const PlacedPrimitive& placed) {
  for (const Vec3& v : {placed.primitive.position_m, placed.primitive.direction, placed.force_n}) print(v);
  std::printf("%a %a %d\n", placed.primitive.strength_n, placed.primitive.drag_ns_per_m, static_cast<int>(placed.state));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 4) return 2;
  SceneOptions options;
  if (argc > 4) options.data_folders.emplace_back(argv[4]);
  const LoadedScene loaded = load_scene(argv[1], volume_reader(), standard_modes(), options);
  const auto hand = open_hand(argv[2], Hold::firm);
  Session session(loaded.scene);
  for (int n = 0; n < std::atof(argv[3]) / tick_s; ++n) {
    hand->advance(tick_s);
    const DeviceState state = hand->read();
    const Tick tick = session.tick({.position_m = state.position_m, .valid = state.valid}, tick_s);
    hand->write(tick.force_n);
    print(tick);
    for (const PlacedPrimitive& placed : session.primitives()) print(placed);
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
