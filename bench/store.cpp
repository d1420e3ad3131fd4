// Makes a synthetic store of any size: bench_store make OUT.zarr SIDE [2|3]
//
// SIDE³ voxels of 8 bits: two gyroids, with periods of 161 and 24 voxels, and noise. Compare with bench/store.py.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/data/parallel.h"
#include "palpa/file/store_writer.h"

namespace {

constexpr double periods[] = {161.0, 24.0};
constexpr double amplitudes[] = {70.0, 25.0};
constexpr unsigned noise = 16;  // levels

struct Waves {
  std::vector<float> sine, cosine;
};

Waves waves(std::int64_t side, double period) {
  Waves result;
  for (std::int64_t n = 0; n < side; ++n) {
    const double at = 2.0 * std::numbers::pi * static_cast<double>(n) / period;
    result.sine.push_back(static_cast<float>(std::sin(at)));
    result.cosine.push_back(static_cast<float>(std::cos(at)));
  }
  return result;
}

/// Noise of a voxel by its place alone: the same for any number of threads.
unsigned hashed(std::uint64_t place) {
  place *= 0x9e3779b97f4a7c15u;
  place ^= place >> 29;
  return static_cast<unsigned>((place * 0xbf58476d1ce4e5b9u) >> 40);
}

int make(const char* out, std::int64_t side, int zarr) {
  const Waves waves_of[] = {waves(side, periods[0]), waves(side, periods[1])};
  const auto slice = [&](std::int64_t k, double* values) {
    palpa::detail::in_parts(side, 16, [&](std::int64_t from, std::int64_t to) {
      for (std::int64_t j = from; j < to; ++j)
        for (std::int64_t i = 0; i < side; ++i) {
          const auto x = static_cast<std::size_t>(i), y = static_cast<std::size_t>(j), z = static_cast<std::size_t>(k);
          double value = 120.0;
          for (std::size_t n = 0; n < 2; ++n) {
            const Waves& w = waves_of[n];
            value += amplitudes[n] / 1.5 *
                     static_cast<double>(w.sine[x] * w.cosine[y] + w.sine[y] * w.cosine[z] + w.sine[z] * w.cosine[x]);
          }
          value += hashed(static_cast<std::uint64_t>((k * side + j) * side + i)) % noise;
          values[j * side + i] = std::clamp(std::floor(value), 0.0, 255.0);
        }
    });
  };
  palpa::WrittenVolume volume;
  volume.grid.dims = {side, side, side};
  volume.grid.index_to_world_m = 1e-6 * palpa::Mat3::identity();
  volume.length_unit = "um";
  volume.fields.push_back({"gyroids", "", palpa::VoxelType::uint8, 1, slice});
  palpa::write_store(volume, out, {.zarr = zarr});
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::int64_t side = 0;
  const bool good = argc >= 4 && argc <= 5 && std::strcmp(argv[1], "make") == 0 &&
                    std::from_chars(argv[3], argv[3] + std::strlen(argv[3]), side).ec == std::errc{} && side > 0 &&
                    side <= 16384;
  if (!good) {
    std::fputs("bench_store make OUT.zarr SIDE [2|3]: SIDE voxels along each axis, up to 16384; version of Zarr\n", stderr);
    return 2;
  }
  try {
    return make(argv[2], side, argc == 5 ? std::atoi(argv[4]) : 0);
  } catch (const palpa::LoadError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
