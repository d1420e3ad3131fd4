#include "palpa/scene/reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace palpa::detail {
namespace {

constexpr int longest = 48;

/// How many cells of any block of a lattice are object, by a table of sums from its corner.
class Counts {
 public:
  Counts(const Box& box, const std::function<bool(const Vec3&)>& is_object)
      : low_m_(box.low_m), cell_m_(largest_component(box.size_m()) / longest) {
    const Vec3 size_m = box.size_m();
    const double sizes_m[] = {size_m.x, size_m.y, size_m.z};
    for (int a = 0; a < 3; ++a) {
      n_[a] = std::clamp(static_cast<int>(std::ceil(sizes_m[a] / cell_m_ - 1e-9)), 1, longest);
    }
    // Cells of a flat side stand in its middle.
    const Vec3 over_m = cell_m_ * Vec3{1.0 * n_[0], 1.0 * n_[1], 1.0 * n_[2]} - size_m;
    low_m_ = low_m_ - 0.5 * over_m;
    sums_.assign(static_cast<std::size_t>(n_[0] + 1) * (n_[1] + 1) * (n_[2] + 1), 0);
    for (int k = 1; k <= n_[2]; ++k)
      for (int j = 1; j <= n_[1]; ++j)
        for (int i = 1; i <= n_[0]; ++i) {
          const Vec3 middle_m = low_m_ + cell_m_ * Vec3{i - 0.5, j - 0.5, k - 0.5};
          at(i, j, k) = (is_object(middle_m) ? 1 : 0) + at(i - 1, j, k) + at(i, j - 1, k) + at(i, j, k - 1) -
                        at(i - 1, j - 1, k) - at(i - 1, j, k - 1) - at(i, j - 1, k - 1) + at(i - 1, j - 1, k - 1);
        }
  }

  int n(int axis) const { return n_[axis]; }
  std::int64_t in_cube(const std::array<int, 3>& first, int side) {
    int a[3], b[3];
    for (int axis = 0; axis < 3; ++axis) {
      a[axis] = std::clamp(first[static_cast<std::size_t>(axis)], 0, n_[axis]);
      b[axis] = std::clamp(first[static_cast<std::size_t>(axis)] + side, 0, n_[axis]);
    }
    return at(b[0], b[1], b[2]) - at(a[0], b[1], b[2]) - at(b[0], a[1], b[2]) - at(b[0], b[1], a[2]) + at(a[0], a[1], b[2]) +
           at(a[0], b[1], a[2]) + at(b[0], a[1], a[2]) - at(a[0], a[1], a[2]);
  }
  /// The reach whose middle is this cube.
  Reach as_reach(const std::array<int, 3>& first, int side, std::int64_t count) const {
    const Vec3 middle{first[0] + 0.5 * side, first[1] + 0.5 * side, first[2] + 0.5 * side};
    return {low_m_ + cell_m_ * middle, 2.0 * cell_m_ * side, static_cast<double>(count) / (1.0 * side * side * side), false};
  }

 private:
  std::int64_t& at(int i, int j, int k) { return sums_[static_cast<std::size_t>((k * (n_[1] + 1) + j) * (n_[0] + 1) + i)]; }

  Vec3 low_m_;
  double cell_m_;
  int n_[3];
  std::vector<std::int64_t> sums_;
};

/// The reach whose middle, a cube of this side, is the fullest; across an axis that it is wider than, it stands in the middle.
Reach fullest(Counts& counts, int side) {
  std::int64_t best = -1;
  std::array<int, 3> best_at{};
  int first[3], last[3];
  for (int a = 0; a < 3; ++a) {
    const int over = counts.n(a) - side;
    first[a] = over < 0 ? over / 2 : 0;
    last[a] = over < 0 ? over / 2 : over;
  }
  for (int k = first[2]; k <= last[2]; ++k)
    for (int j = first[1]; j <= last[1]; ++j)
      for (int i = first[0]; i <= last[0]; ++i) {
        const std::int64_t count = counts.in_cube({i, j, k}, side);
        if (count > best) best = count, best_at = {i, j, k};
      }
  return counts.as_reach(best_at, side, best);
}

}  // namespace

Reach reach_with(const Box& box, const std::function<bool(const Vec3&)>& is_object, double wanted) {
  Counts counts(box, is_object);
  constexpr int half = longest / 2;
  const std::array<int, 3> middle{(counts.n(0) - half) / 2, (counts.n(1) - half) / 2, (counts.n(2) - half) / 2};
  Reach whole = counts.as_reach(middle, half, counts.in_cube(middle, half));
  whole.centre_m = box.centre_m();
  whole.whole = true;
  if (whole.share >= wanted) return whole;
  constexpr int smallest = longest / 10;
  for (int side = half; side > smallest; --side) {
    const Reach found = fullest(counts, side);
    if (found.share >= wanted) return found;
  }
  const Reach last = fullest(counts, smallest);
  return last.share > 0.0 ? last : whole;
}

Vec3 surface_before(const Reach& reach, const Box& box, const Vec3& towards_user,
                    const std::function<bool(const Vec3&)>& is_object) {
  const double way_m = largest_component(box.size_m());
  constexpr int steps = 200;
  for (int n = 0; n < steps; ++n) {
    const Vec3 at_m = reach.centre_m + (way_m * (1.0 - static_cast<double>(n) / steps)) * towards_user;
    if (is_object(at_m)) return at_m;
  }
  return reach.centre_m;
}

}  // namespace palpa::detail
