// Contact sampled by Reach, in cells of the hand's workspace.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "palpa/study/feeler.h"

namespace palpa::detail {

// Sampled region and resolution; `across` and `along` follow from the lengths. Larger, or finer cells: slower, by the number of
// paths; smaller: objects within a device's reach are missed; coarser: thin ones are.
inline constexpr double half_m = 0.09;         // half the side of the cube about the centre of the workspace
inline constexpr double before_m = 0.02;       // distance of the paths' start before the cube, and of hands before the front
inline constexpr double cell_m = 0.01;         // size of a cell across the paths
inline constexpr double cell_z_m = 0.005;      // size along the paths
inline constexpr int across = 19, along = 40;  // [cells] 2 · half_m / cell_m + 1, and (2 · half_m + before_m) / cell_z_m

/// Contact by cell. Cell 0 of each axis is at the left, at the bottom, and next to the user.
struct ReachLattice {
  struct Cell {
    std::uint64_t modes = 0;  // modes that push here, a bit each; all from the 64th on share the last bit
    bool front = false;       // contact begins in this cell or the one before
    bool beyond = false;      // the force exceeds the scene's limit
    double worth = 0.0;       // 1 on average over cells in contact; more for many modes, or modes that rarely push elsewhere
  };
  static std::size_t number(int i, int j, int k) { return static_cast<std::size_t>((k * across + j) * across + i); }
  static Vec3 way_begin_m(int i, int j) { return {(i - across / 2) * cell_m, (j - across / 2) * cell_m, half_m + before_m}; }
  static Vec3 middle_m(int i, int j, int k) { return way_begin_m(i, j) - Vec3{0.0, 0.0, (k + 0.5) * cell_z_m}; }
  Cell at(int i, int j, int k) const {
    if (i < 0 || j < 0 || k < 0 || i >= across || j >= across || k >= along) return {};
    return cells[number(i, j, k)];
  }
  bool felt(int i, int j, int k) const { return at(i, j, k).modes != 0; }
  /// Whether the path nearest to this hand position [m] has met a level before the position's depth.
  bool is_behind_a_level(const Vec3& place_m) const {
    const auto column = [](double m) {
      return std::clamp(static_cast<int>(std::lround(m / cell_m)) + across / 2, 0, across - 1);
    };
    const Way& way = ways.at(column(place_m.x), column(place_m.y));
    return way.at_level && half_m + before_m - place_m.z > *way.onset_m;
  }
  /// Modes that push anywhere along a path.
  std::uint64_t modes_along(int i, int j) const {
    std::uint64_t modes = 0;
    for (int k = 0; k < along; ++k) modes |= at(i, j, k).modes;
    return modes;
  }
  void set_worth() {
    std::array<double, 64> cells_of{};
    for (const Cell& cell : cells) {
      for (std::size_t m = 0; m < 64; ++m) cells_of[m] += static_cast<double>(cell.modes >> m & 1);
    }
    double sum = 0.0, felt_cells = 0.0;
    for (Cell& cell : cells) {
      for (std::size_t m = 0; m < 64; ++m) {
        if (cell.modes >> m & 1) cell.worth += 1.0 / std::sqrt(cells_of[m]);
      }
      sum += cell.worth;
      felt_cells += cell.modes != 0;
    }
    for (Cell& cell : cells) cell.worth *= felt_cells / std::max(sum, 1e-300);
  }

  std::vector<Cell> cells = std::vector<Cell>(static_cast<std::size_t>(across * across * along));
  Ways ways{across, across, false, std::vector<Way>(static_cast<std::size_t>(across* across))};
};

}  // namespace palpa::detail
