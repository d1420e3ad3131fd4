// Volumes of the benchmark: made, written as NRRD, read again.
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
  std::array<int, 3> size{};  ///< samples along x, y, z
  Vec3 spacing_m;
  Vec3 origin_m;  ///< of the first sample

  Vec3 place_m(int i, int j, int k) const { return origin_m + Vec3{i * spacing_m.x, j * spacing_m.y, k * spacing_m.z}; }
  /// Calls `f` with the place [m] of each sample, in the order of samples.
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
/// A cube about the origin, from face to face of its outermost voxels `edge_m` [m] long.
SampledGrid cube(int samples, double edge_m);

/// Samples of one of these types, those of a vector together, x fastest.
struct SampledVolume {
  SampledGrid grid;
  std::string type;  ///< "uint8", "uint16", "int16" or "float32"
  int components = 1;
  std::vector<float> samples;  ///< [own unit] exact: whole numbers, or what a float32 holds

  /// Between samples, of one component: straight along each axis; 0 outside of the grid. [own unit]
  double value(const Vec3& x_m) const;
  /// Central differences at the samples, straight along each axis between them. [own unit/m]
  Vec3 slope_per_m(const Vec3& x_m) const;
  bool holds(const Vec3& x_m) const;
};

/// Writes it, and returns the bytes before the first sample. Throws LoadError.
std::size_t write_nrrd(const SampledVolume& volume, const std::filesystem::path& file);
/// Reads what `write_nrrd` has written. Throws LoadError.
SampledVolume read_nrrd(const std::filesystem::path& file);

/// Random numbers by splitmix64 (Steele, Lea and Flood, 2014): whole numbers alone, so the same everywhere.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : state_(seed) {}
  /// Nearly normal [1], deviation 1: twelve uniform numbers, added.
  double next();

 private:
  std::uint64_t state_;
};

}  // namespace palpa::haptics
