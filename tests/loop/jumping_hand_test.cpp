// Hands that jump in a volume larger than memory.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

#include "palpa/data/octaves.h"
#include "palpa/loop/window_feed.h"
#include "palpa/mode/modes.h"
#include "palpa/scene/scene.h"

namespace palpa {
namespace {

constexpr double spacing_m = 4e-6;
constexpr std::int64_t size = 1 << 17;  // [voxels] along each axis: 4.5 PB of octave 0

/// Voxels by a formula, 16 per voxel of octave 0 along x and 0 in the middle: of any octave the exact means.
class Slope final : public VoxelSource {
 public:
  bool read(int octave, const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& dims,
            std::byte* to) override {
    std::vector<std::int16_t> row(static_cast<std::size_t>(dims[0]));
    for (std::int64_t i = 0; i < dims[0]; ++i) {
      const std::int64_t twice = ((2 * (first[0] + i) + 1) << octave) - size;  // [half voxels] of its centre from the middle
      row[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(std::clamp<std::int64_t>(8 * twice, -32000, 32000));
    }
    const std::size_t bytes = row.size() * sizeof row[0];
    for (std::int64_t n = 0; n < dims[1] * dims[2]; ++n, to += bytes) std::memcpy(to, row.data(), bytes);
    const std::int64_t all = dims[1] * dims[2] * static_cast<std::int64_t>(bytes);
    most_bytes = std::max(most_bytes, all), sum_bytes += all;
    return true;
  }
  std::int64_t most_bytes = 0, sum_bytes = 0;
};

/// Memory of this process [bytes].
double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  double pages = 0.0;
  file >> pages >> pages;
  return pages * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

// A jump whose windows would take more than 256 MB in octaves 0 to 3 is felt in octave 4 in that tick, on a wall where octave 0
// has it; then the felt octave becomes finer. However many jumps, memory stays within the windows that are kept.
TEST(JumpingHand, FeelsACoarserOctaveInBoundedMemory) {
  const auto source = std::make_shared<Slope>();
  Octaves::Shape shape{.finest = {.dims = {size, size, size}, .index_to_world_m = spacing_m * Mat3::identity()},
                       .count = 11,
                       .type = VoxelType::int16,
                       .filter = Filter::smooth,
                       .ranges = {{-32000, 32000}},
                       .source = source};
  const double half_m = 0.5 * spacing_m * static_cast<double>(size - 1);
  shape.finest.origin_m = {-half_m, -half_m, -half_m};
  Volume volume;
  volume.fields.emplace_back().name = "slope";
  volume.fields.front().field = std::make_shared<const Octaves>(std::move(shape));
  Scene scene({.stiffness_n_per_m = 400});
  const FieldRef field = scene.add("slope", volume, {}, Filter::smooth);
  scene.add("surface", SurfaceAndFriction{.field = field, .levels = {{.value = 0.0, .strength_n = 100.0}}});
  scene.edit<Workspace>([](Workspace& workspace) { workspace.scale = 1.0, workspace.fit.clear(); });

  Session session(scene);
  WindowFeed feed(session);
  const double before_bytes = resident_bytes();
  double most_bytes = 0.0;
  for (int jump = 0; jump < 10; ++jump) {
    const Vec3 from_m{-1000 * spacing_m, 2500 * jump * spacing_m, 0.0}, to_m = from_m + Vec3{1920 * spacing_m, 0.0, 0.0};
    session.reset();
    for (int tick = 0; tick < 3; ++tick) feed.tick({.position_m = from_m}, 1e-3);
    Tick now = feed.tick({.position_m = to_m}, 1e-3);
    EXPECT_EQ(now.felt_octave, 4.0);
    EXPECT_NE(now.status, TickStatus::waiting);
    for (int tick = 0; tick < (jump < 9 ? 3 : 110); ++tick) {
      EXPECT_NEAR(now.proxy_m.x, 0.0, 1e-9) << jump << ", " << tick;
      EXPECT_NEAR(norm(now.force_n), 400 * 920 * spacing_m, 1e-6) << jump << ", " << tick;
      now = feed.tick({.position_m = to_m}, 1e-3);
    }
    if (jump == 9) {
      EXPECT_EQ(now.felt_octave, 0.0);
    }
    most_bytes = std::max(most_bytes, resident_bytes() - before_bytes);
  }
  EXPECT_LE(source->most_bytes, 256'000'000);
  EXPECT_GT(source->sum_bytes, 700'000'000);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which need memory of their own
  EXPECT_LT(most_bytes, 450e6);
#endif
}

}  // namespace
}  // namespace palpa
