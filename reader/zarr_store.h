// Open store: its content, and its chunks as voxels of Palpa.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "palpa/file/store_protocol.h"
#include "zarr_chunks.h"
#include "zarr_image.h"

namespace palpa::reader {

/// Scratch memory of a thread.
struct ZarrScratch {
  std::vector<std::byte> packed, raw;
};

class ZarrStore {
 public:
  /// Reads the metadata. Throws LoadError with a sentence.
  /// \param most_chunk_bytes  larger chunks are refused
  /// \param fetch             socket of palpa-fetch, of a web address; else -1
  ZarrStore(const std::string& path, std::uint64_t most_chunk_bytes, int fetch);

  const StoreContents& contents() const noexcept { return contents_; }
  /// Whether its files are fetched, so that each costs a round trip.
  bool is_fetched() const noexcept { return folder_.is_fetched(); }
  bool names_fields() const noexcept { return names_fields_; }
  /// [m] of the file's unit of length; its name is in `contents`.
  double unit_m() const noexcept { return unit_m_; }
  /// Most bytes of scratch memory for a chunk.
  std::uint64_t scratch_bytes() const noexcept;

  /// Reads a chunk that has a place, as `StoreReader::content` has it, into `to` of `protocol::content_bytes`. Any number of
  /// threads, each with its own scratch memory. Throws bad_alloc only.
  ZarrRead read(const StoreChunk& chunk, std::span<std::byte> to, ZarrScratch& scratch) const;
  /// Paths in the store of the metadata and of the files of a chunk. Allocates.
  std::vector<std::string> metadata_files() const;
  std::vector<std::string> files_of(const StoreChunk& chunk) const;

 private:
  struct Place {
    std::array<std::int64_t, 8> at{};  ///< [chunks] along the array's indices
    std::int64_t offset = 0;           ///< [numbers] of the first voxel in the chunk
  };
  void take_fields();
  void take_octaves();
  void take_facts();
  Mat3 steps_m(const ZarrLevel& level) const;
  bool has_steps_of(const ZarrLevel& level, const Mat3& finest, double times, const std::array<std::int64_t, 3>& dims) const;
  Place place_of(const ZarrArray& array, const StoreChunk& chunk, std::int64_t channel) const;
  bool is_as_delivered(const ZarrArray& array, const StoreField& field) const;
  ZarrRead read_facts(const StoreChunk& chunk, std::span<std::byte> to, ZarrScratch& scratch) const;
  ZarrRead look_for_chunks(const StoreChunk& of_facts, std::span<std::byte> to) const;

  ZarrFolder folder_;
  ZarrChunks chunks_{folder_};
  ZarrImage image_;
  StoreContents contents_;
  std::vector<std::vector<std::int64_t>> channels_;  ///< of each field: one, or those along x, y, z
  std::vector<ZarrArray> facts_;                     ///< of each octave; without `shape`: none
  bool names_fields_ = false;
  double unit_m_ = 1e-6;
  std::array<double, 3> axis_unit_m_{1e-6, 1e-6, 1e-6};
};

}  // namespace palpa::reader
