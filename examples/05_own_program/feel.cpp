// A program with its own data, computed or from a file, and a hand that presses on them.
//
//   feel                 computed data
//   feel head.nrrd 300   a file (through palpa-read) and the level
#include <palpa/palpa.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

namespace {

/// Voxels need no file: a bump of 64³ voxels of 1 mm, 100 in the middle, 0 outside.
palpa::Volume bump() {
  constexpr int n = 64;
  auto values = std::make_shared<std::vector<float>>();
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const double r = std::hypot(i - 31.5, j - 31.5, k - 31.5) / 20.0;
        values->push_back(static_cast<float>(100.0 * std::exp(-r * r)));
      }
    }
  }
  const palpa::GridGeometry grid{.dims = {n, n, n}, .index_to_world_m = 1e-3 * palpa::Mat3::identity()};
  palpa::Volume volume;
  volume.fields = {{.name = "bump", .unit = "1", .field = palpa::grid_field(grid, {.data = {values, values->data()}})}};
  return volume;
}

}  // namespace

int main(int argc, char** argv) try {
  palpa::Scene scene({.stiffness_n_per_m = 400});
  const palpa::FieldRef data = scene.add("data", argc > 1 ? palpa::read_volume(argv[1]) : bump());
  const double level = argc > 2 ? std::atof(argv[2]) : 50.0;
  scene.add("surface", palpa::SurfaceAndFriction{.field = data, .levels = {{.value = level, .strength_n = 4.0}}});
  for (const std::string& warning : scene.check()) std::fprintf(stderr, "%s\n", warning.c_str());

  // A hand that presses from the front; a real device would supply its positions here.
  palpa::Session session(scene);
  double most_n = 0.0;
  int touching = 0;
  constexpr int ticks = 4000;
  for (int i = 0; i < ticks; ++i) {
    const double depth_m = 0.05 * std::sin(3.14159265358979 * i / ticks);
    const palpa::Tick tick = session.tick({.position_m = {0, 0, 0.07 - depth_m}}, 1e-3);
    most_n = std::max(most_n, norm(tick.force_n));
    touching += norm(tick.force_n) > 1e-3;
  }
  std::printf("touched the surface in %d of %d ticks, with at most %.2f N\n", touching, ticks, most_n);
  return touching > 0 ? 0 : 1;
} catch (const palpa::LoadError& error) {  // anything that cannot be loaded or used, in one line
  std::fprintf(stderr, "feel: %s\n", error.what());
  return 2;
}
