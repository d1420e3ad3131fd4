// Segmentation of the data: object, its parts and box, and a close-up.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "palpa/data/field.h"

namespace palpa::detail {

/// Cubes that fill a box of the world, `longest` of them along its longest side, centred on the other axes.
class Lattice {
 public:
  /// [cells] More: time and memory, by the third power; fewer: thin parts fall apart.
  static constexpr int longest = 96;

  explicit Lattice(const Box& box);
  int count(int axis) const noexcept { return count_[static_cast<std::size_t>(axis)]; }
  std::size_t size() const noexcept { return static_cast<std::size_t>(count_[0]) * count_[1] * count_[2]; }
  double cell_m() const noexcept { return cell_m_; }
  std::size_t number(int i, int j, int k) const noexcept {
    return (static_cast<std::size_t>(k) * count_[1] + j) * count_[0] + i;
  }
  std::array<int, 3> indices(std::size_t number) const noexcept;
  /// Number of the cell around a place [m]; none outside.
  std::optional<std::size_t> cell_at(const Vec3& world_m) const noexcept;
  /// [m] of a cell.
  Vec3 middle_m(std::size_t number) const noexcept;
  /// [m] around cells from `first` to `last`, both included.
  Box box_m(const std::array<int, 3>& first, const std::array<int, 3>& last) const noexcept;

 private:
  std::array<int, 3> count_{};
  double cell_m_ = 0.0;
  Vec3 low_m_;
};

/// Largest connected parts of the solid, without a head rest or specks in the air.
struct Object {
  std::vector<char> cells;        ///< of a lattice: 1 in the object
  std::vector<std::size_t> part;  ///< numbers of the cells of its largest part
  Box box_m;                      ///< around all of it
  double share = 0.0;             ///< [1] of that box in the object
};

/// Parts connected through faces, from the largest on, until they hold `enough` [1] of all object cells; specks of less than
/// eight cells only if there is nothing else. Without any cell: empty, with the lattice's box.
/// \param is_object  for each cell of the lattice
Object largest_parts(const Lattice& lattice, std::vector<char> is_object, double enough);

/// Mean position [1] along y of solid cells outside of the object: 0 is the middle of the object's box, -1 half its side or
/// more below, 1 above. 0 also for hardly any cells.
double beside_at_y(const Lattice& lattice, const Object& object, const std::vector<char>& is_solid);

/// The middle [m] of the cube `side_m` [m] wide, cells of the lattice rounded up, that holds most of the object.
Vec3 fullest_cube_m(const Lattice& lattice, const Object& object, double side_m);

/// First point [m] of the object on the straight path to `towards_m` from the direction `from` [1], an axis of the lattice;
/// none if the path misses it.
std::optional<Vec3> met_from(const Lattice& lattice, const Object& object, const Vec3& towards_m, const Vec3& from);

}  // namespace palpa::detail
