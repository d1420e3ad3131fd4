// Base of tests of stores.
#pragma once

#include <cstdlib>
#include <string>

#include "files.h"
#include "palpa/file/store_chunks.h"
#include "palpa/file/store_reader.h"
#include "zarr_file.h"

namespace palpa::test {

/// Value of voxels in the stores of write_zarr_stores.py.
inline double ramp(std::int64_t i, std::int64_t j, std::int64_t k) {
  return static_cast<double>((7 * i + 5 * j + 3 * k) % 100);
}

/// Tests of stores, in a folder of their own.
class StoreTest : public ReaderTest {
 protected:
  fs::path at(const std::string& name) const { return folder_.path() / name; }

  /// A store of one octave, as `value` has it.
  fs::path write(const std::string& name, ZarrToWrite array, const std::string& attributes = multiscales(1, false)) const {
    write_zarr_group(at(name), attributes, array.format);
    if (!array.value) array.value = [](const std::vector<std::int64_t>& v) { return ramp(v[2], v[1], v[0]); };
    write_zarr_array(at(name) / "0", array);
    return at(name);
  }

  StoreReader open(const fs::path& store, int slots = 4) const { return StoreReader(store, options_, slots); }
  std::string error_of_store(const fs::path& store) const {
    return error_of([&] { open(store); });
  }

  /// Reads one chunk; its numbers, empty unless it is present.
  std::vector<double> numbers(StoreReader& reader, const StoreChunk& chunk, StoreRead* how = nullptr) const {
    reader.request(chunk, 0);
    std::optional<StoreRead> read;
    for (int n = 0; n < 60 && !read; ++n) read = reader.next(1.0);
    EXPECT_TRUE(read);
    if (!read) return {};
    EXPECT_EQ(read->chunk, chunk);
    if (how != nullptr) *how = *read;
    if (read->state != ChunkState::present) return {};
    return numbers_in(reader.contents().fields.at(static_cast<std::size_t>(chunk.field)), reader.content(0));
  }

  /// Expects a value at each voxel of an octave, from all chunks.
  void expect_voxels(StoreReader& reader, const StoreChunk& place,
                     const std::function<double(std::int64_t, std::int64_t, std::int64_t)>& value) const {
    const StoreOctave& octave = reader.contents().octaves.at(static_cast<std::size_t>(place.octave));
    const VoxelBox box{{0, 0, 0}, octave.grid.dims};
    const auto voxels = voxels_in(reader, place, box);
    ASSERT_TRUE(voxels);
    std::size_t at = 0, wrong = 0;
    for (std::int64_t k = 0; k < box.count[2]; ++k)
      for (std::int64_t j = 0; j < box.count[1]; ++j)
        for (std::int64_t i = 0; i < box.count[0]; ++i, ++at) wrong += (*voxels)[at] != value(i, j, k);
    EXPECT_EQ(wrong, 0u);
  }

  /// The stores of zarr-python, written once; empty without it.
  static const fs::path& stores() {
    static const TemporaryFolder folder;
    static const fs::path written = [] {
      const std::string command = "/usr/bin/python3 -B '" STORES_WRITER "' '" + folder.path().string() + "' >'" +
                                  (folder.path() / "output").string() + "' 2>&1";
      return std::system(command.c_str()) == 0 ? folder.path() : fs::path();
    }();
    return written;
  }
};

/// Tests on stores of zarr-python.
class PythonStores : public StoreTest {
 protected:
  void SetUp() override {
    StoreTest::SetUp();
    if (stores().empty()) GTEST_SKIP() << "python3-zarr is not installed";
  }
};

}  // namespace palpa::test
