#include "palpa/data/filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "palpa/data/axis_grid.h"
#include "palpa/data/grid_base.h"
#include "palpa/data/halton.h"
#include "palpa/data/octaves.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/timed_field.h"
#include "palpa/data/unread_grid.h"

namespace palpa {
namespace {

FieldPtr made_of(const GridView& grid, Filter filter, bool without_sign) {
  const auto make = [&](auto* maker, auto... more) {
    return maker(grid.geometry, grid.voxels, grid.scale, grid.offset, more...);
  };
  if (without_sign) return make(axis_grid_field, filter);
  switch (filter) {
    case Filter::smooth: return make(smooth_grid_field);
    case Filter::cubic: return make(cubic_grid_field);
    default: return make(grid_field);
  }
}

/// The field with each grid below its poses and frames replaced by `make`.
template <class Make>
FieldPtr remade(const FieldPtr& field, const Make& make) {
  if (const PosedView* view = posed_of(*field)) return posed(remade(view->field, make), view->pose);
  if (const MovingView* view = moving_of(*field)) return moving(remade(view->field, make), view->track, view->per_length);
  if (const SeriesView* view = series_of(*field)) {
    std::vector<FieldPtr> frames;
    for (const FieldPtr& frame : view->frames) frames.push_back(remade(frame, make));
    return time_series(std::move(frames), view->period_s, view->between_frames);
  }
  const GridView* grid = grid_behind(*field);
  if (!grid) throw std::invalid_argument("it is a formula and has no voxels; sample it first");
  return make(*grid);
}

}  // namespace

namespace {
constexpr std::int64_t roughness_reach = 2;  // voxels to either side of a fourth difference
}  // namespace

double roughness(const GridView& grid) noexcept {
  constexpr std::int64_t places = 8192, reach = roughness_reach;  // more places: slower; fewer: less certain
  const auto& dims = grid.geometry.dims;
  const std::int64_t components = grid.voxels.components;
  const std::int64_t stride[3] = {components, components * dims[0], components * dims[0] * dims[1]};
  double roughest = 0.0;
  detail::with_values_of(grid.voxels, [&]<class T>(const T* values) {
    struct Along {
      double second = 0.0, fourth = 0.0, largest = 0.0;
      int used = 0;
    } along[3];
    for (int n = 1; n <= std::min(places, grid.geometry.voxels()); ++n) {
      const double share[3] = {detail::radical_inverse<2>(n), detail::radical_inverse<3>(n), detail::radical_inverse<5>(n)};
      for (std::size_t a = 0; a < 3; ++a) {
        if (dims[a] < 2 * reach + 1) continue;
        auto& [second, fourth, largest, used] = along[a];
        std::int64_t first = 0;
        for (std::size_t b = 0; b < 3; ++b) {
          const std::int64_t begin = b == a ? reach : 0, count = dims[b] - 2 * begin;
          first +=
              stride[b] * std::min(begin + static_cast<std::int64_t>(share[b] * static_cast<double>(count)), begin + count - 1);
        }
        for (std::int64_t c = 0; c < components; ++c) {
          const T* v = values + first + c;
          const auto at = [&](std::int64_t m) { return static_cast<double>(v[m * stride[a]]); };
          const double two = at(-1) - 2.0 * at(0) + at(1);
          const double four = at(-2) - 4.0 * at(-1) + 6.0 * at(0) - 4.0 * at(1) + at(2);
          if (!std::isfinite(two * two + four * four)) continue;
          second += two * two;
          fourth += four * four;
          largest = std::max(largest, std::abs(at(0)));
          ++used;
        }
      }
    }
    for (const auto& [second, fourth, largest, used] : along) {
      const double rounding =
          16.0 * largest * std::numeric_limits<std::conditional_t<std::is_integral_v<T>, double, T>>::epsilon();
      if (fourth > used * rounding * rounding) roughest = std::max(roughest, fourth / second);
    }
  });
  return roughest;
}

FilterChoice default_filter(const GridView& grid) noexcept {
  const VoxelType type = grid.voxels.type;
  const auto& dims = grid.geometry.dims;
  if (type != VoxelType::float32 && type != VoxelType::float64) return {Filter::smooth, "evens out the steps of whole numbers"};
  if (grid.voxels.components == 3) return {Filter::trilinear, "directions are values, which do not jump between voxels"};
  if (grid.geometry.is_rectilinear())
    return {Filter::trilinear, "planes lie at uneven distances, between which a spline would bend what is straight"};
  if (std::max({dims[0], dims[1], dims[2]}) < 2 * roughness_reach + 1)
    return {Filter::trilinear, "there are too few voxels to tell what lies between them"};
  // [1] Roughness above which data are smoothed. Less: smooth data are smoothed as well; more: `cubic` keeps noise.
  constexpr double rough = 1.0;
  // Voxels up to which `cubic` may keep a second copy. More: more memory; fewer: large smooth data are only smoothed.
  constexpr std::int64_t most_voxels = std::int64_t{1} << 27;
  const double found = roughness(grid);
  if (found >= rough) return {Filter::smooth, "evens out noise, and edges too sharp for the voxels", found};
  if (grid.geometry.voxels() > most_voxels)
    return {Filter::smooth, "has no facets, and needs no second copy of so many voxels", found};
  return {Filter::cubic, "meets the voxels, which are smooth, and has no facets", found};
}

const GridView* grid_below(const Field& field) noexcept {
  if (const PosedView* view = posed_of(field)) return grid_below(*view->field);
  if (const MovingView* view = moving_of(field)) return grid_below(*view->field);
  if (const SeriesView* view = series_of(field)) return grid_below(*view->frames.front());
  return grid_behind(field);
}

FieldPtr filtered(FieldPtr field, Filter filter) {
  if (!field) throw std::invalid_argument("there is no field to filter");
  const GridView* grid = grid_below(*field);
  if (grid && grid->filter == filter) return detail::read_now(field);
  if (const SeriesView* series = series_of(*field); series && dynamic_cast<const Octaves*>(series->frames.front().get())) {
    std::vector<FieldPtr> frames;
    for (const FieldPtr& frame : series->frames) frames.push_back(filtered(frame, filter));
    return time_series(std::move(frames), series->period_s, series->between_frames);
  }
  if (const auto* octaves = dynamic_cast<const Octaves*>(field.get())) {
    if (octaves->shape().filter == filter) return field;
    Octaves::Shape shape = octaves->shape();
    shape.filter = filter;
    return std::make_shared<const Octaves>(std::move(shape));
  }
  return remade(field, [&](const GridView& of) { return made_of(of, filter, of.signless); });
}

bool has_detail(const Field& field) noexcept {
  const GridView* grid = grid_below(field);
  return grid && field.components() == 1 && grid->voxels.components == 1 && grid->filter == Filter::smooth && !grid->signless;
}

FieldPtr signless(FieldPtr field) {
  if (!field) throw std::invalid_argument("there is no field without a sign");
  if (is_axis_field(*field)) return field;
  return remade(field, [](const GridView& of) {
    return made_of(of, of.filter == Filter::trilinear ? Filter::trilinear : Filter::smooth, true);
  });
}

}  // namespace palpa
