// Walk through a unit, depth first: chunks in, means and facts out.
#pragma once

#include <functional>
#include <map>
#include <vector>

#include "palpa/file/store_reader.h"
#include "palpa/file/unit_plan.h"

namespace palpa::detail {

/// Chunks of a store in a given order, with requests ahead. One thread.
class ChunkStream {
 public:
  /// \param goes_on  checked while a chunk is awaited; false ends with LoadError "interrupted"
  ChunkStream(StoreReader& reader, std::function<bool()> goes_on);
  /// Sets the next chunks, after all before have been taken.
  void follow(std::vector<StoreChunk> order);
  /// Gives the next chunk to `act`, as a StoreRead and its content, empty unless present. Throws LoadError of the reader.
  void take(const std::function<void(const StoreRead&, std::span<const std::byte>)>& act);

 private:
  void request_ahead();

  StoreReader& reader_;
  std::function<bool()> goes_on_;
  std::vector<StoreChunk> order_;
  std::size_t requested_ = 0, taken_ = 0;  ///< [chunks] of the order
  std::vector<int> free_;                  ///< slots
  std::map<StoreChunk, StoreRead> arrived_;
};

/// Voxels of an absent chunk. \param chunk  [voxels]
std::vector<std::byte> filled_chunk(const StoreField& field, const VoxelIndex& chunk);

/// Receiver of a walk. Indices are within the octave.
struct WalkSink {
  /// Voxels of a chunk of an octave above the base.
  std::function<void(int octave, const VoxelIndex& at, const VoxelBlock& chunk)> voxels;
  std::function<void(int octave, const VoxelIndex& at, const ChunkFacts& facts)> facts;
  /// Voxels of a chunk of octave 0, a part of a block. \param low, size  [voxels]
  std::function<void(const VoxelKind& kind, const VoxelBlock& block, const VoxelIndex& low, const VoxelIndex& size)> finest;
  /// Damaged chunk, whose voxels are taken as the fill value if this returns.
  std::function<void(const StoreRead& chunk)> damaged;
};

/// Walk of one thread through blocks of a frame of a field.
class UnitWalk {
 public:
  /// \param octave_in_store  [octaves] subtracted from an octave's number for the reader
  UnitWalk(const UnitPlan& plan, const StoreContents& contents, ChunkStream& chunks, WalkSink sink, int octave_in_store = 0);

  /// Begins with an octave of chunks; those of coarser octaves are means of them.
  void set_item(int frame, int field, int from_octave);
  /// Makes a block: reads what is below it, and emits chunks of all octaves above the first, facts of all below its own.
  VoxelBlock made(int octave, const VoxelIndex& at);
  /// Makes a block of blocks that are there. \param ready  blocks of the octave `ready_octave`, by their index
  VoxelBlock made_of(int octave, const VoxelIndex& at, int ready_octave, std::map<VoxelIndex, VoxelBlock>& ready);
  /// Emits the facts of a block's chunks, of an octave whose next one is not made of it here.
  void emit_facts(int octave, const VoxelIndex& at, const VoxelBlock& block);
  /// Reads blocks of an octave, and emits their facts.
  void read_facts(int octave, const VoxelIndex& first, const VoxelIndex& end);

 private:
  VoxelBlock block_of(int octave, const VoxelIndex& at);
  VoxelBlock gathered(int octave, const VoxelIndex& at);
  void add_chunks(int octave, const VoxelIndex& at, std::vector<StoreChunk>& order) const;
  void add_chunks_below(int octave, const VoxelIndex& at, std::vector<StoreChunk>& order) const;
  void emit_facts_over(int octave, const VoxelIndex& at, const VoxelBlock& block, const VoxelBlock* coarse,
                       const VoxelIndex& coarse_at);
  void emit_voxels(int octave, const VoxelIndex& at, const VoxelBlock& block);
  VoxelIndex children(int octave) const noexcept;

  const UnitPlan& plan_;
  const StoreContents& contents_;
  ChunkStream& chunks_;
  WalkSink sink_;
  int shift_ = 0;
  int frame_ = 0, field_ = 0, from_ = 0;
  VoxelKind kind_;
  int ready_octave_ = -1;
  std::map<VoxelIndex, VoxelBlock>* ready_ = nullptr;
};

}  // namespace palpa::detail
