// Files of tests: written into a temporary folder, or found among the shared data.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/data/grid.h"
#include "palpa/data/volume.h"
#include "palpa/file/read_volume.h"

namespace palpa::test {

namespace fs = std::filesystem;

/// A folder of its own for each test, gone with it.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  fs::path write(const std::string& name, const std::string& bytes) const;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

class ReaderTest : public ::testing::Test {
 protected:
  void SetUp() override;

  Volume read(const fs::path& file, VolumeRequest request = {}) const;
  TemporaryFolder folder_;
  ReadOptions options_;
};

/// Options with the path of the built reader; an empty path without it.
ReadOptions built_reader();
/// A file of the shared data; empty without it.
fs::path shared_file(const std::string& name);

/// Runs `act`, which must throw a LoadError of one line; returns its text.
std::string error_of(const std::function<void()>& act);

/// The bytes of a number, native or swapped.
template <class T>
std::string bytes_of(T value, bool big_endian = false) {
  std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
  return big_endian ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

std::string gzipped(const std::string& bytes);
/// Empty if it is no whole file, or of more than 16 MiB.
std::string gunzipped(const std::string& bytes);

/// A grid in the file's own frame and unit.
struct FileGrid {
  std::int64_t dims[3];
  Mat3 step;  ///< column = step of one index
  Vec3 origin;
  Vec3 at(const Vec3& index) const { return step * index + origin; }
};
/// Columns of different lengths, not at right angles.
FileGrid sheared_grid();

/// A linear function of the position in Palpa's world [m]; trilinear sampling must reproduce it exactly.
struct Linear {
  Vec3 gradient{300, -200, 500};
  double at_origin = 7.0;
  double operator()(const Vec3& world_m) const { return dot(gradient, world_m) + at_origin; }
};

/// The voxels of a linear function as bytes, i fastest, by the world positions of the file's.
template <class T>
std::string linear_voxels(const FileGrid& grid, const std::function<Vec3(const Vec3&)>& to_world_m, bool big_endian = false,
                          const Linear& linear = {}) {
  std::string bytes;
  for (std::int64_t k = 0; k < grid.dims[2]; ++k)
    for (std::int64_t j = 0; j < grid.dims[1]; ++j)
      for (std::int64_t i = 0; i < grid.dims[0]; ++i) {
        const Vec3 file = grid.at({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
        bytes += bytes_of(static_cast<T>(linear(to_world_m(file))), big_endian);
      }
  return bytes;
}

/// Expects that linear function at positions all over the grid, and no data outside.
void expect_linear(const Field& field, const FileGrid& grid, const std::function<Vec3(const Vec3&)>& to_world_m,
                   const Linear& linear = {});

/// A child of any thread of this process; 0: none.
int child_process();

bool warns_of(const Volume& volume, const std::string& part);
std::string all_warnings(const Volume& volume);

}  // namespace palpa::test
