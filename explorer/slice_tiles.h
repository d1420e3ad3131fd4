// Tiles of finer octaves, for slices of volumes larger than memory.
#pragma once

#include <array>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <vector>

#include "palpa/data/octaves.h"

namespace palpa::explorer {

/// Block of voxels of an octave: 64 × 64 along a slice, 8 across it.
struct TilePlace {
  int octave = 0;
  int across = 0;                       ///< axis of the grid across the slice: 0, 1, 2
  std::array<std::int64_t, 3> block{};  ///< [blocks] along i, j, k
  friend auto operator<=>(const TilePlace&, const TilePlace&) = default;
};

/// Tile that was read.
struct SliceTile {
  TilePlace place;
  OctaveWindow window;  ///< voxels of the tile and those that its samples need; without a grid where some are lost
};

/// Part of a slice, a rectangle in the frame of the octaves.
struct SliceArea {
  Vec3 centre_m;
  Vec3 half_right_m, half_up_m;  ///< from the centre to the middle of two sides
  double step_m = 0.0;           ///< distance of samples
};

/// Tiles of a part of a slice.
struct TilesOfArea {
  int across = 0;                  ///< as in TilePlace
  int wanted = 0;                  ///< octave
  int finest = 0, coarsest = 0;    ///< octaves of which there are samples in the part
  std::vector<TilePlace> missing;  ///< coarse first, then those near the centre
};

/// Tiles of a field, the last used ones in memory. Samples in a tile are those of its octave as a whole, to the bit, so that
/// tiles have no seams. Used by the window's thread, but for `read`.
class SliceTiles {
 public:
  static constexpr std::int64_t along_voxels = 64, across_voxels = 8;

  explicit SliceTiles(std::shared_ptr<const Octaves> octaves);
  const Octaves& octaves() const noexcept { return *octaves_; }

  /// Tiles of the octave with about a voxel a sample, if they take at most a quarter of the memory, else of a coarser one; and
  /// of those between it and octave `known`, of which the whole is in memory.
  TilesOfArea tiles_of(const SliceArea& area, int known);
  /// Value of the finest tile there from octave `finest` on, of vectors their magnitude; none without a tile.
  std::optional<double> value_at(const Vec3& at_m, int across, int finest) const;
  /// Box of a tile's samples, in the frame of the octaves, as its corners.
  std::array<Vec3, 8> corners_m(const TilePlace& place) const noexcept;

  /// Reads missing tiles one after the other for a thirtieth of a second, at least one, from a source of its own, whose reader
  /// has the priority of the calling thread. Blocks. Throws LoadError if the voxels cannot be read any more.
  std::vector<SliceTile> read(const std::vector<TilePlace>& missing, std::stop_token stop);
  /// Of the voxels in memory.
  std::int64_t bytes() const noexcept { return bytes_; }
  /// Adds tiles that were read, and drops those used longest ago.
  void keep(std::vector<SliceTile> tiles);

 private:
  struct Lattice {
    Mat3 to_steps;  ///< [steps/m]
    Vec3 origin_m;
    std::array<std::int64_t, 3> dims{};  ///< [voxels]
  };
  Vec3 steps_of(int octave, const Vec3& at_m) const noexcept;
  std::int64_t bytes_of(const TilePlace& place) const noexcept;
  GridWindow window_of(const TilePlace& place) const noexcept;
  std::vector<TilePlace> places_in(const SliceArea& area, int octave, int across) const;

  std::shared_ptr<const Octaves> octaves_;
  std::vector<Lattice> lattices_;  ///< of the octaves
  std::list<SliceTile> tiles_;     ///< the last used first
  std::map<TilePlace, std::list<SliceTile>::iterator> at_;
  std::int64_t bytes_ = 0;

  std::mutex reading_;  ///< of the source
  std::shared_ptr<VoxelSource> source_;
};

}  // namespace palpa::explorer
