#include "explorer/slice_tiles.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "explorer/slice_view.h"

namespace palpa::explorer {
namespace {

constexpr std::int64_t most_bytes = 256'000'000;  // of all tiles. More: memory; less: tiles are read again on the way back
constexpr std::int64_t most_area_bytes = most_bytes / 4;  // three slices, and the coarser octaves of each
// Between a picture and the next. Longer: tiles come in bursts; shorter: more work of the window.
constexpr auto longest_read = std::chrono::milliseconds(33);
constexpr std::int64_t brick_voxels = 8;   // where windows begin
constexpr std::int64_t beyond_voxels = 3;  // of a tile, for samples of a smooth filter
/// [voxels] Samples at the border of a tile are in the one that begins there, whatever the rounding of their positions.
constexpr double rounding_voxels = 1e-6;

std::int64_t side_of(const TilePlace& place, std::size_t axis) noexcept {
  return static_cast<int>(axis) == place.across ? SliceTiles::across_voxels : SliceTiles::along_voxels;
}

/// \param voxels  [1] of the octave along the axis
std::int64_t block_at(double steps, std::int64_t voxels, std::int64_t side) noexcept {
  const double within = std::clamp(steps + rounding_voxels, 0.0, static_cast<double>(voxels - 1));
  return static_cast<std::int64_t>(within) / side;
}

std::array<double, 3> as_array(const Vec3& v) noexcept { return {v.x, v.y, v.z}; }

}  // namespace

SliceTiles::SliceTiles(std::shared_ptr<const Octaves> octaves) : octaves_(std::move(octaves)) {
  for (int octave = 0; octave < octaves_->count(); ++octave) {
    const GridGeometry& grid = octaves_->sampled_grid(octave);
    lattices_.push_back({detail::scaled_inverse(grid.index_to_world_m), grid.origin_m, grid.dims});
  }
}

Vec3 SliceTiles::steps_of(int octave, const Vec3& at_m) const noexcept {
  const Lattice& lattice = lattices_[static_cast<std::size_t>(octave)];
  return lattice.to_steps * (at_m - lattice.origin_m);
}

/// Voxels in memory for a tile.
GridWindow SliceTiles::window_of(const TilePlace& place) const noexcept {
  GridWindow window;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t side = side_of(place, a), first = place.block[a] * side;
    window.first[a] = std::max<std::int64_t>(first - brick_voxels, 0);
    window.dims[a] =
        std::min(first + side + beyond_voxels, lattices_[static_cast<std::size_t>(place.octave)].dims[a]) - window.first[a];
  }
  return window;
}

std::int64_t SliceTiles::bytes_of(const TilePlace& place) const noexcept {
  const GridWindow window = window_of(place);
  return window.dims[0] * window.dims[1] * window.dims[2] * static_cast<std::int64_t>(size_of(octaves_->shape().type)) *
         octaves_->components();
}

std::array<Vec3, 8> SliceTiles::corners_m(const TilePlace& place) const noexcept {
  std::array<Vec3, 8> corners;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const auto end = [&](std::size_t a) {
      return static_cast<double>((place.block[a] + static_cast<std::int64_t>(corner >> a & 1)) * side_of(place, a));
    };
    corners[corner] = octaves_->sampled_grid(place.octave).to_world({end(0), end(1), end(2)});
  }
  return corners;
}

/// Tiles that meet a part of a slice, those near its centre first.
std::vector<TilePlace> SliceTiles::places_in(const SliceArea& area, int octave, int across) const {
  const Lattice& lattice = lattices_[static_cast<std::size_t>(octave)];
  const Vec3 middle = steps_of(octave, area.centre_m);
  const Vec3 right = lattice.to_steps * area.half_right_m, up = lattice.to_steps * area.half_up_m;
  const std::array<double, 3> at = as_array(middle), u = as_array(right), v = as_array(up), normal = as_array(cross(right, up));
  TilePlace place{octave, across, {}};
  std::array<std::int64_t, 3> first{}, last{};
  for (std::size_t a = 0; a < 3; ++a) {
    const double half = std::abs(u[a]) + std::abs(v[a]);
    if (!(at[a] + half >= -1.0 && at[a] - half <= static_cast<double>(lattice.dims[a]))) return {};
    first[a] = block_at(at[a] - half, lattice.dims[a], side_of(place, a));
    last[a] = block_at(at[a] + half, lattice.dims[a], side_of(place, a));
  }
  std::vector<std::pair<double, TilePlace>> found;
  auto& [i, j, k] = place.block;
  for (k = first[2]; k <= last[2]; ++k) {
    for (j = first[1]; j <= last[1]; ++j) {
      for (i = first[0]; i <= last[0]; ++i) {
        double off = 0.0, reach = 0.0, squared = 0.0;  // from the plane, of the box along its normal, from the centre
        for (std::size_t a = 0; a < 3; ++a) {
          const auto half = 0.5 * static_cast<double>(side_of(place, a));
          const double way = static_cast<double>(2 * place.block[a] + 1) * half - at[a] - rounding_voxels;
          off += normal[a] * way, reach += std::abs(normal[a]) * half, squared += way * way;
        }
        if (std::abs(off) <= reach) found.push_back({squared, place});
      }
    }
  }
  std::ranges::sort(found);
  std::vector<TilePlace> places;
  for (const auto& one : found) places.push_back(one.second);
  return places;
}

TilesOfArea SliceTiles::tiles_of(const SliceArea& area, int known) {
  const Vec3 normal = cross(area.half_right_m, area.half_up_m);
  const Mat3 steps_m = transposed(octaves_->shape().finest.index_to_world_m);
  TilesOfArea tiles;
  double most = -1.0;
  for (int a = 0; a < 3; ++a) {
    const double along = std::abs(dot(steps_m.row[a], normal)) / norm(steps_m.row[a]);
    if (along > most * (1.0 + 1e-9)) tiles.across = a, most = along;
  }
  const double octave = std::floor(std::log2(std::max(area.step_m / octaves_->spacing_m(), 1.0)) + 1e-9);
  tiles.wanted = static_cast<int>(std::min(octave, static_cast<double>(known)));
  std::vector<std::vector<TilePlace>> places(static_cast<std::size_t>(known));  // by octave
  for (int n = tiles.wanted; n < known; ++n) {
    auto& of = places[static_cast<std::size_t>(n)];
    of = places_in(area, n, tiles.across);
    std::int64_t bytes = 0;
    for (const TilePlace& place : of) bytes += bytes_of(place);
    if (bytes > most_area_bytes) of.clear(), tiles.wanted = n + 1;
  }
  tiles.finest = tiles.coarsest = known;
  for (int n = known - 1; n >= tiles.wanted; --n) {
    bool is_whole = true;
    for (const TilePlace& place : places[static_cast<std::size_t>(n)]) {
      const auto found = at_.find(place);
      if (found == at_.end()) tiles.missing.push_back(place);
      const bool is_there = found != at_.end() && found->second->window.grid;
      if (found != at_.end()) tiles_.splice(tiles_.begin(), tiles_, found->second);
      if (is_there) tiles.finest = n;
      is_whole = is_whole && is_there;
    }
    if (!is_whole) continue;
    tiles.coarsest = n;
    tiles.missing.clear();  // below these tiles
  }
  return tiles;
}

std::optional<double> SliceTiles::value_at(const Vec3& at_m, int across, int finest) const {
  for (int octave = finest; octave < octaves_->count() - 1; ++octave) {
    TilePlace place{octave, across, {}};
    const std::array<double, 3> steps = as_array(steps_of(octave, at_m));
    for (std::size_t a = 0; a < 3; ++a)
      place.block[a] = block_at(steps[a], lattices_[static_cast<std::size_t>(octave)].dims[a], side_of(place, a));
    const auto found = at_.find(place);
    if (found == at_.end() || !found->second->window.grid) continue;
    if (const auto value = explorer::value_at(*found->second->window.grid, at_m)) return value;
  }
  return std::nullopt;
}

std::vector<SliceTile> SliceTiles::read(const std::vector<TilePlace>& missing, std::stop_token stop) {
  const std::lock_guard lock(reading_);
  std::vector<SliceTile> tiles;
  if (!source_) source_ = octaves_->shape().source->beside();
  const auto latest = std::chrono::steady_clock::now() + longest_read;
  for (const TilePlace& place : missing) {
    if (stop.stop_requested() || (!tiles.empty() && std::chrono::steady_clock::now() > latest)) break;
    const GridWindow window = window_of(place);
    tiles.push_back(
        {place, source_ ? octaves_->window_from(*source_, place.octave, window.first, window.dims) : OctaveWindow()});
  }
  return tiles;
}

void SliceTiles::keep(std::vector<SliceTile> tiles) {
  for (SliceTile& tile : tiles) {
    if (at_.contains(tile.place)) continue;
    bytes_ += bytes_of(tile.place);
    tiles_.push_front(std::move(tile));
    at_.emplace(tiles_.front().place, tiles_.begin());
  }
  while (bytes_ > most_bytes && tiles_.size() > tiles.size()) {
    bytes_ -= bytes_of(tiles_.back().place);
    at_.erase(tiles_.back().place);
    tiles_.pop_back();
  }
}

}  // namespace palpa::explorer
