// Volumes of the benchmark: sampling, NRRD output and input.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa::haptics {

/// Samples on a grid along the axes of the world.
struct SampledGrid {
  std::array<int, 3> size{};
  Vec3 spacing_m;
  Vec3 origin_m;

  Vec3 place_m(int i, int j, int k) const { return origin_m + Vec3{i * spacing_m.x, j * spacing_m.y, k * spacing_m.z}; }
  /// Calls `f` with the position [m] of each sample, in storage order.
  template <class F>
  void each(F f) const {
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        for (int i = 0; i < size[0]; ++i) f(place_m(i, j, k));
      }
    }
  }
  std::size_t samples() const { return static_cast<std::size_t>(size[0]) * size[1] * size[2]; }
};
/// A cube about the origin; `edge_m` [m] is measured between the outer faces of its voxels.
SampledGrid cube(int samples, double edge_m);

/// Samples of one of these types, interleaved vectors, x fastest.
struct SampledVolume {
  SampledGrid grid;
  std::string type;  ///< "uint8", "uint16", "int16" or "float32"
  int components = 1;
  std::vector<float> samples;  ///< [own unit] exact: integers, or float32 values

  /// Trilinear interpolation of one component; 0 outside of the grid. [own unit]
  double value(const Vec3& x_m) const;
  /// Central differences at the samples, trilinear between them. [own unit/m]
  Vec3 slope_per_m(const Vec3& x_m) const;
  bool holds(const Vec3& x_m) const;
};

/// Returns the bytes before the first sample. Throws LoadError.
std::size_t write_nrrd(const SampledVolume& volume, const std::filesystem::path& file);
/// Reads files of `write_nrrd`. Throws LoadError.
SampledVolume read_nrrd(const std::filesystem::path& file);

/// Random numbers by splitmix64 (Steele, Lea and Flood, 2014): integers only, identical everywhere.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : state_(seed) {}
  /// Nearly normal [1], standard deviation 1: sum of twelve uniform numbers.
  double next();

 private:
  std::uint64_t state_;
};

}  // namespace palpa::haptics
