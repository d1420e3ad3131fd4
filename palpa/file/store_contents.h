// Content of an OME-Zarr store: fields, octaves, chunks.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "palpa/data/grid.h"
#include "palpa/data/statistics.h"

namespace palpa {

/// Octave of a store: octave 0 is the finest; octave n has voxels 2ⁿ times as wide.
struct StoreOctave {
  GridGeometry grid;                    ///< [m] without planes
  std::array<std::int64_t, 3> chunk{};  ///< [voxels] of a chunk along i, j, k
  std::array<std::int64_t, 3> shard{};  ///< [voxels] of a shard; equal to `chunk` without shards
  std::string codec;                    ///< in words: "blosc (lz4, bitshuffle)"
  std::array<std::int64_t, 3> facts{};  ///< [chunks] of a chunk of facts along i, j, k; 0: the octave has none
  friend bool operator==(const StoreOctave&, const StoreOctave&) = default;
};

/// Field of a store. All fields of a store lie on equal grids.
struct StoreField {
  std::string name;
  std::string unit;                   ///< empty if unknown
  std::string file_type;              ///< of the file: "int8"; `type` may be wider
  VoxelType type = VoxelType::uint8;  ///< of delivered voxels
  int components = 1;                 ///< 1 or 3
  double fill = 0.0;                  ///< [raw] value of an absent chunk
  Histogram histogram{};              ///< [raw] of octave 0, of vectors of their length; without counts: unknown
  friend bool operator==(const StoreField&, const StoreField&) = default;
};

/// Content of a store, from its metadata alone.
struct StoreContents {
  std::string format;                ///< "OME-Zarr 0.4, Zarr v2"
  std::string length_unit;           ///< of the file, before conversion to metres
  bool length_unit_assumed = false;  ///< the file names no unit: micrometres
  std::vector<StoreField> fields;
  std::vector<StoreOctave> octaves;  ///< from the finest
  int frames = 1;
  double period_s = 0.0;              ///< [s] from frame to frame; 0 if unknown
  bool prepared = false;              ///< has the facts of its chunks (`StoreChunk::facts`)
  std::vector<std::string> warnings;  ///< half sentences
  friend bool operator==(const StoreContents&, const StoreContents&) = default;
};

/// Place of a chunk in a store.
struct StoreChunk {
  std::int32_t octave = 0;
  std::int32_t frame = 0;
  std::int32_t field = 0;
  bool facts = false;                ///< chunk of the octave's facts (`ChunkFacts`) instead of its voxels
  std::array<std::int64_t, 3> at{};  ///< [chunks] along i, j, k
  bool presence = false;             ///< of the chunks of a chunk of facts, whether the store has them, instead of voxels
  friend auto operator<=>(const StoreChunk&, const StoreChunk&) = default;
};

/// Facts of one chunk, written by `palpa prepare`.
struct ChunkFacts {
  double min = 0.0;    ///< [raw] of all components
  double max = 0.0;    ///< [raw]
  double rms = 0.0;    ///< [raw] root mean square of what the next octave loses
  double crc32 = 0.0;  ///< [1] of the delivered voxels within the octave, i fastest, little-endian; a whole number
};

/// State of a chunk that was read.
enum class ChunkState : std::uint8_t {
  present,
  absent,   ///< the store has no such chunk: the fill value everywhere
  damaged,  ///< does not decode to its size, or another checksum
};

}  // namespace palpa
