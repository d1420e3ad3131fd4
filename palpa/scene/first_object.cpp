#include "palpa/scene/first_object.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>

namespace palpa::detail {
namespace {

// [cells] A smaller part is noise. More: small parts are left out; less: specks widen the object's box.
constexpr std::size_t speck = 8;

/// Number of object cells in any block of a lattice, by a summed-area table.
class Counts {
 public:
  Counts(const Lattice& lattice, const std::vector<char>& cells)
      : n_{lattice.count(0), lattice.count(1), lattice.count(2)},
        sums_(static_cast<std::size_t>(n_[0] + 1) * (n_[1] + 1) * (n_[2] + 1), 0) {
    for (int k = 1; k <= n_[2]; ++k)
      for (int j = 1; j <= n_[1]; ++j)
        for (int i = 1; i <= n_[0]; ++i) {
          at(i, j, k) = cells[lattice.number(i - 1, j - 1, k - 1)] + at(i - 1, j, k) + at(i, j - 1, k) + at(i, j, k - 1) -
                        at(i - 1, j - 1, k) - at(i - 1, j, k - 1) - at(i, j - 1, k - 1) + at(i - 1, j - 1, k - 1);
        }
  }
  std::int64_t in_cube(const std::array<int, 3>& first, int side) {
    int a[3], b[3];
    for (int axis = 0; axis < 3; ++axis) {
      a[axis] = std::clamp(first[static_cast<std::size_t>(axis)], 0, n_[axis]);
      b[axis] = std::clamp(first[static_cast<std::size_t>(axis)] + side, 0, n_[axis]);
    }
    return at(b[0], b[1], b[2]) - at(a[0], b[1], b[2]) - at(b[0], a[1], b[2]) - at(b[0], b[1], a[2]) + at(a[0], a[1], b[2]) +
           at(a[0], b[1], a[2]) + at(b[0], a[1], a[2]) - at(a[0], a[1], a[2]);
  }

 private:
  std::int64_t& at(int i, int j, int k) { return sums_[static_cast<std::size_t>((k * (n_[1] + 1) + j) * (n_[0] + 1) + i)]; }

  int n_[3];
  std::vector<std::int64_t> sums_;
};

/// All cells connected to a cell through faces; sets them to 0.
std::vector<std::size_t> part_taken(const Lattice& lattice, std::vector<char>& left, std::size_t from) {
  std::vector<std::size_t> part{from};
  left[from] = 0;
  for (std::size_t next = 0; next < part.size(); ++next) {
    const std::array<int, 3> at = lattice.indices(part[next]);
    for (int axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1}) {
        std::array<int, 3> beside = at;
        int& index = beside[static_cast<std::size_t>(axis)];
        index += step;
        if (index < 0 || index >= lattice.count(axis)) continue;
        const std::size_t number = lattice.number(beside[0], beside[1], beside[2]);
        if (!left[number]) continue;
        left[number] = 0;
        part.push_back(number);
      }
  }
  return part;
}

double along(const Vec3& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

}  // namespace

Lattice::Lattice(const Box& box) : cell_m_(largest_component(box.size_m()) / longest) {
  for (int a = 0; a < 3; ++a) {
    count_[static_cast<std::size_t>(a)] =
        std::clamp(static_cast<int>(std::ceil(along(box.size_m(), a) / cell_m_ - 1e-9)), 1, longest);
  }
  low_m_ = box.centre_m() - 0.5 * cell_m_ * Vec3{1.0 * count_[0], 1.0 * count_[1], 1.0 * count_[2]};
}

std::array<int, 3> Lattice::indices(std::size_t number) const noexcept {
  const auto nx = static_cast<std::size_t>(count_[0]), ny = static_cast<std::size_t>(count_[1]);
  return {static_cast<int>(number % nx), static_cast<int>(number / nx % ny), static_cast<int>(number / nx / ny)};
}

std::optional<std::size_t> Lattice::cell_at(const Vec3& world_m) const noexcept {
  const Vec3 at = (world_m - low_m_) / cell_m_;
  const double along[3] = {at.x, at.y, at.z};
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(along[a] >= 0.0 && along[a] < count_[a])) return std::nullopt;
  }
  return number(static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z));
}

Vec3 Lattice::middle_m(std::size_t number) const noexcept {
  const std::array<int, 3> at = indices(number);
  return low_m_ + cell_m_ * Vec3{at[0] + 0.5, at[1] + 0.5, at[2] + 0.5};
}

Box Lattice::box_m(const std::array<int, 3>& first, const std::array<int, 3>& last) const noexcept {
  return {low_m_ + cell_m_ * Vec3{1.0 * first[0], 1.0 * first[1], 1.0 * first[2]},
          low_m_ + cell_m_ * Vec3{last[0] + 1.0, last[1] + 1.0, last[2] + 1.0}};
}

Object largest_parts(const Lattice& lattice, std::vector<char> is_object, double enough) {
  std::vector<std::vector<std::size_t>> parts;
  std::size_t all = 0;
  for (std::size_t n = 0; n < is_object.size(); ++n) {
    if (!is_object[n]) continue;
    parts.push_back(part_taken(lattice, is_object, n));
    all += parts.back().size();
  }
  std::ranges::stable_sort(parts, std::greater(), &std::vector<std::size_t>::size);
  Object object;
  object.cells.assign(lattice.size(), 0);
  object.box_m = lattice.box_m({0, 0, 0}, {lattice.count(0) - 1, lattice.count(1) - 1, lattice.count(2) - 1});
  if (parts.empty()) return object;

  std::array<int, 3> first{Lattice::longest, Lattice::longest, Lattice::longest}, last{-1, -1, -1};
  std::size_t held = 0;
  for (const std::vector<std::size_t>& part : parts) {
    if (held > 0 && (part.size() < speck || static_cast<double>(held) >= enough * static_cast<double>(all))) break;
    held += part.size();
    for (const std::size_t number : part) {
      object.cells[number] = 1;
      const std::array<int, 3> at = lattice.indices(number);
      for (std::size_t a = 0; a < 3; ++a) first[a] = std::min(first[a], at[a]), last[a] = std::max(last[a], at[a]);
    }
  }
  object.part = std::move(parts.front());
  object.box_m = lattice.box_m(first, last);
  object.share =
      static_cast<double>(held) / (1.0 * (last[0] - first[0] + 1) * (last[1] - first[1] + 1) * (last[2] - first[2] + 1));
  return object;
}

double beside_at_y(const Lattice& lattice, const Object& object, const std::vector<char>& is_solid) {
  const double middle_m = object.box_m.centre_m().y, half_m = 0.5 * object.box_m.size_m().y;
  std::size_t held = 0, beside = 0;
  double sum = 0.0;
  for (std::size_t n = 0; n < is_solid.size(); ++n) {
    held += object.cells[n] != 0;
    if (!is_solid[n] || object.cells[n]) continue;
    ++beside;
    sum += std::clamp((lattice.middle_m(n).y - middle_m) / half_m, -1.0, 1.0);
  }
  // [1] Cells beside the object, as a share of it, that are ignored. Less: specks in the air turn the view; more: a thin head
  // rest is missed.
  constexpr double next_to_nothing = 0.003;
  return static_cast<double>(beside) > next_to_nothing * static_cast<double>(held) ? sum / static_cast<double>(beside) : 0.0;
}

Vec3 fullest_cube_m(const Lattice& lattice, const Object& object, double side_m) {
  Counts counts(lattice, object.cells);
  const int side = std::max(1, static_cast<int>(std::ceil(side_m / lattice.cell_m() - 1e-9)));
  std::int64_t best = -1;
  std::array<int, 3> best_at{}, first{}, last{};
  for (std::size_t a = 0; a < 3; ++a) {  // centred along an axis where the cube is longer than the lattice
    const int over = lattice.count(static_cast<int>(a)) - side;
    first[a] = over < 0 ? over / 2 : 0;
    last[a] = over < 0 ? over / 2 : over;
  }
  for (int k = first[2]; k <= last[2]; ++k)
    for (int j = first[1]; j <= last[1]; ++j)
      for (int i = first[0]; i <= last[0]; ++i) {
        const std::int64_t count = counts.in_cube({i, j, k}, side);
        if (count > best) best = count, best_at = {i, j, k};
      }
  return lattice.box_m(best_at, {best_at[0] + side - 1, best_at[1] + side - 1, best_at[2] + side - 1}).centre_m();
}

std::optional<Vec3> met_from(const Lattice& lattice, const Object& object, const Vec3& towards_m, const Vec3& from) {
  // In the column of cells through `towards_m`, the object's outermost cell.
  double furthest_m = -1e300;
  std::optional<Vec3> met;
  for (std::size_t n = 0; n < object.cells.size(); ++n) {
    if (!object.cells[n]) continue;
    const Vec3 way_m = lattice.middle_m(n) - towards_m;
    const double out_m = dot(way_m, from);
    if (largest_component(way_m - out_m * from) > (0.5 + 1e-6) * lattice.cell_m() || out_m <= furthest_m) continue;
    furthest_m = out_m;
    met = towards_m + (out_m + 0.5 * lattice.cell_m()) * from;
  }
  return met;
}

}  // namespace palpa::detail
