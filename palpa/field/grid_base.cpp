#include "palpa/field/grid_base.h"

#include <array>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

namespace palpa::detail {
namespace {

struct Found {
  std::array<Extent, 3> ranges;  ///< raw; min > max where nothing is finite
  std::int64_t valid = 0;        ///< voxels that are finite altogether
};

/// Of one row in `step`.
template <int Components, class T>
Found find_range(const T* first, std::int64_t width, std::int64_t rows, std::int64_t step) noexcept {
  T least[Components], greatest[Components];
  for (int c = 0; c < Components; ++c) {
    least[c] = std::numeric_limits<T>::max();
    greatest[c] = std::numeric_limits<T>::lowest();
  }
  Found found;
  for (std::int64_t row = 0; row < rows; row += step) {
    const T* voxels = first + row * width * Components;
    for (std::int64_t v = 0; v < width; ++v, voxels += Components) {
      bool finite = true;
      for (int c = 0; c < Components; ++c) {
        if constexpr (std::is_floating_point_v<T>) {
          if (!std::isfinite(voxels[c])) {
            finite = false;
            continue;
          }
        }
        least[c] = std::min(least[c], voxels[c]);
        greatest[c] = std::max(greatest[c], voxels[c]);
      }
      found.valid += finite;
    }
  }
  for (int c = 0; c < Components; ++c) found.ranges[c] = {static_cast<double>(least[c]), static_cast<double>(greatest[c])};
  return found;
}

}  // namespace

Mat3 scaled_inverse(const Mat3& steps_m) noexcept {
  const double largest =
      std::max({largest_component(steps_m.row[0]), largest_component(steps_m.row[1]), largest_component(steps_m.row[2])});
  const double factor = std::scalbn(1.0, -std::ilogb(largest));
  return factor * inverse(factor * steps_m);
}

void check_grid(const GridGeometry& geometry, const Voxels& voxels, double scale, double offset) {
  if (const char* problem = problem_with(geometry)) throw std::invalid_argument(problem);
  if (!voxels.data) throw std::invalid_argument("the grid has no voxels in memory");
  if (voxels.components != 1 && voxels.components != 3) {
    throw std::invalid_argument("the grid has " + std::to_string(voxels.components) + " components; a field has 1 or 3");
  }
  if (!std::isfinite(scale) || !std::isfinite(offset))
    throw std::invalid_argument("the grid's scale and offset must be finite");
  with_values_of(voxels, [&](const auto* values) {
    if (reinterpret_cast<std::uintptr_t>(values) % alignof(decltype(*values)) != 0) {
      throw std::invalid_argument("the grid's voxels are not aligned in memory; place them at a multiple of their size");
    }
  });
}

GridGeometry geometry_over(const Box& box, int samples) {
  const Vec3 size_m = box.size_m();
  const double sides_m[3] = {size_m.x, size_m.y, size_m.z};
  const double wanted_m = largest_component(size_m) / (samples - 1);
  if (!std::isfinite(wanted_m) || !(wanted_m > 0.0)) throw std::invalid_argument("the field's box has no size to sample");

  // Both ends of every side are samples, so steps differ a little from axis to axis.
  GridGeometry geometry;
  double step_m[3];
  for (int a = 0; a < 3; ++a) {
    geometry.dims[a] = std::max<std::int64_t>(std::llround(sides_m[a] / wanted_m), sides_m[a] > 0.0 ? 1 : 0) + 1;
    step_m[a] = geometry.dims[a] > 1 ? sides_m[a] / static_cast<double>(geometry.dims[a] - 1) : wanted_m;
  }
  geometry.index_to_world_m = {{{step_m[0], 0, 0}, {0, step_m[1], 0}, {0, 0, step_m[2]}}};
  geometry.origin_m = box.low_m;
  return geometry;
}

GridBase::GridBase(const GridGeometry& geometry, Voxels voxels, double scale, double offset, Filter filter, bool signless,
                   std::shared_ptr<const void> coefficients, std::int64_t one_row_in)
    : view_{geometry, std::move(voxels), scale, offset, 1.0, filter, signless},
      coefficients_(coefficients ? std::move(coefficients) : view_.voxels.data),
      world_to_steps_(scaled_inverse(geometry.index_to_world_m)) {
  std::int64_t stride = view_.voxels.components;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t n = geometry.dims[a];
    last_[a] = static_cast<double>(n - 1);
    half_[a] = n > 1 ? 0.0 : 0.5;
    beyond_[a] = half_[a] + face_tolerance_voxels;
    cells_[a] = std::max<std::int64_t>(n - 1, 1);
    stride_[a] = stride;
    stride *= n;
    plane_distance_m_[a] = 1.0 / norm(world_to_steps_.row[a]);
    const std::vector<double>& planes = view_.geometry.planes[static_cast<std::size_t>(a)];
    planes_[a] = planes.empty() ? nullptr : planes.data();
    double least = 1.0;
    for (std::size_t i = 1; i < planes.size(); ++i) least = std::min(least, planes[i] - planes[i - 1]);
    spacing_m_ = a == 0 ? least * plane_distance_m_[a] : std::min(spacing_m_, least * plane_distance_m_[a]);
  }
  for (int corner = 0; corner < 8; ++corner) {
    const auto at = [&](int a) { return corner >> a & 1 ? last_[a] + half_[a] : -half_[a]; };
    const Vec3 world = geometry.index_to_world_m * Vec3{at(0), at(1), at(2)} + geometry.origin_m;
    if (corner == 0) bounds_m_ = {world, world};
    bounds_m_.low_m = {std::min(bounds_m_.low_m.x, world.x), std::min(bounds_m_.low_m.y, world.y),
                       std::min(bounds_m_.low_m.z, world.z)};
    bounds_m_.high_m = {std::max(bounds_m_.high_m.x, world.x), std::max(bounds_m_.high_m.y, world.y),
                        std::max(bounds_m_.high_m.z, world.z)};
  }

  if (components() == 1 && one_row_in == 1) bricks_ = bricks_of(0);
  const std::int64_t width = geometry.dims[0], rows = geometry.dims[1] * geometry.dims[2];
  const std::int64_t count = (rows + one_row_in - 1) / one_row_in * width;
  const Found found = with_values_of(view_.voxels, [&]<class T>(const T* values) {
    if constexpr (std::is_same_v<T, float> || sizeof(T) <= 2) {  // what bricks hold exactly
      const bool of_voxels = !bricks_.empty() && coefficients_ == view_.voxels.data;
      if (const auto whole = of_voxels ? bricks_.whole() : std::nullopt) return Found{{{{whole->min, whole->max}}}, count};
    }
    return components() == 1 ? find_range<1>(values, width, rows, one_row_in) : find_range<3>(values, width, rows, one_row_in);
  });
  view_.valid_share = static_cast<double>(found.valid) / static_cast<double>(count);
  for (int c = 0; c < components(); ++c) {
    extents_.push_back({});
    const Extent& raw = found.ranges[c];
    if (!(raw.min <= raw.max)) continue;
    const auto [min, max] = std::minmax({raw.min * scale + offset, raw.max * scale + offset});
    if (!std::isfinite(min) || !std::isfinite(max)) {
      throw std::invalid_argument("scale and offset take the grid's values beyond the largest number; use smaller ones");
    }
    extents_.back() = {min, max};
  }
}

namespace {

/// No value is quiet: what a search for polynomials asks with.
constexpr Extent polynomials{1.0, -1.0};

/// The straight way along one axis of the grid.
struct Axis {
  double from = 0.0;               ///< [steps] where the whole way begins
  double way = 0.0;                ///< [steps] from there to its end
  double low = 0.0;                ///< [steps] where the data begin
  double high = 0.0;               ///< [steps] where they end
  double last = 0.0;               ///< [steps] the last voxel
  const double* planes = nullptr;  ///< [steps] of a rectilinear axis
  /// [voxels] The way is between voxels zone and zone + 1; −1 and `last`: before the first and behind the last, where the
  /// values at the edge go on as far as the data do.
  std::int64_t zone = 0;

  double at(double share) const noexcept { return from + share * way; }
  double plane(std::int64_t index) const noexcept { return planes ? planes[index] : static_cast<double>(index); }
  /// The share where the way reaches a place [steps]; infinite along an axis that it does not move along.
  double share_at(double place) const noexcept {
    return way != 0.0 ? (place - from) / way : std::numeric_limits<double>::infinity();
  }
  bool is_behind() const noexcept { return static_cast<double>(zone) >= last; }
  double far_face() const noexcept {
    if (way > 0.0) return is_behind() ? high : plane(zone + 1);
    return zone < 0 ? low : plane(zone);
  }
  /// The zone of a place: the one before it where it lies on a plane and `before` asks for that.
  std::int64_t zone_of(double place, bool before) const noexcept {
    if (!planes) return static_cast<std::int64_t>(std::clamp(before ? std::ceil(place) - 1.0 : std::floor(place), -1.0, last));
    const double* end = planes + static_cast<std::int64_t>(last) + 1;
    return (before ? std::lower_bound(planes, end, place) : std::upper_bound(planes, end, place)) - planes - 1;
  }
  /// Finds the zone where the way goes on at `share`: one whose far face lies ahead.
  void enter(double share) noexcept {
    zone = zone_of(at(share), way < 0.0);
    while (way > 0.0 && !is_behind() && share_at(far_face()) <= share) ++zone;
    while (way < 0.0 && zone >= 0 && share_at(far_face()) <= share) --zone;
  }
  std::int64_t first_voxel() const noexcept {
    return std::clamp<std::int64_t>(zone, 0, std::max<std::int64_t>(static_cast<std::int64_t>(last) - 1, 0));
  }
  /// Across the cell, at `share`.
  double fraction(double share) const noexcept {
    if (zone < 0) return 0.0;
    if (is_behind()) return last - static_cast<double>(first_voxel());
    return std::clamp((at(share) - plane(zone)) / (plane(zone + 1) - plane(zone)), 0.0, 1.0);
  }

  std::int64_t brick() const noexcept { return first_voxel() >> Bricks::shift; }
  double far_face_of(std::int64_t brick) const noexcept {
    if (way > 0.0) {
      const std::int64_t face = (brick + 1) << Bricks::shift;
      return static_cast<double>(face) >= last ? high : plane(face);
    }
    return brick == 0 ? low : plane(brick << Bricks::shift);
  }
};

}  // namespace

/// A way through the grid, and the part of it that has data.
struct GridBase::Way {
  Axis axis[3];
  double enters = 0.0;  ///< [1]
  double leaves = 1.0;  ///< [1]

  Way(const Vec3& from, const Vec3& to, const GridBase& grid) noexcept {
    const double starts[3] = {from.x, from.y, from.z}, ends[3] = {to.x, to.y, to.z};
    for (int a = 0; a < 3; ++a) {
      const double last = grid.last_[a], beyond = grid.beyond_[a];
      axis[a] = {starts[a], ends[a] - starts[a], -beyond, last + beyond, last, grid.planes_[a], 0};
      const auto holds = [&](double place) { return place >= axis[a].low && place <= axis[a].high; };
      if (holds(starts[a]) && holds(ends[a])) continue;
      const double one = axis[a].share_at(axis[a].low), other = axis[a].share_at(axis[a].high);
      enters = std::max(enters, std::min(one, other));
      leaves = std::min(leaves, std::max(one, other));
      if (!std::isfinite(axis[a].way) || axis[a].way == 0.0) leaves = -1.0;
    }
  }
  bool has_data_after(double share) const noexcept { return enters < leaves && share < leaves && share < 1.0; }

  void enter(double begin) noexcept {
    for (Axis& a : axis) a.enter(begin);
  }

  /// The cell that was entered at `begin`, and where the way leaves it.
  Passage pass(double begin, double& end) const noexcept {
    double exits[3];
    end = leaves;
    for (int a = 0; a < 3; ++a) {
      exits[a] = axis[a].share_at(axis[a].far_face());
      end = std::min(end, exits[a]);
    }
    if (!(end > begin)) end = std::nextafter(begin, 2.0);
    Passage cell;
    for (int a = 0; a < 3; ++a) {
      cell.first[a] = axis[a].first_voxel();
      cell.begin[a] = axis[a].fraction(begin);
      // On the face itself where the way leaves by it: the next cell begins there.
      const bool between = axis[a].zone >= 0 && !axis[a].is_behind();
      cell.end[a] = between && exits[a] == end ? (axis[a].way > 0.0 ? 1.0 : 0.0) : axis[a].fraction(end);
    }
    return cell;
  }
};

bool GridBase::cross_bricks(const Bricks& bricks, const Way& way, const Extent& quiet, Stretch& piece) const noexcept {
  enum class Kind { mixed, still, none };
  const auto kind_of = [&](const std::int64_t(&b)[3]) {
    const Bricks::Range& range = bricks.at(b);
    if (range.min > range.max) return Kind::none;
    return is_quiet(range.min, range.max, quiet) ? Kind::still : Kind::mixed;
  };
  std::int64_t brick[3];
  for (int a = 0; a < 3; ++a) brick[a] = way.axis[a].brick();
  const Kind kind = kind_of(brick);
  if (kind == Kind::mixed) return false;

  constexpr int most_bricks = 64;
  double exits[3];
  for (int a = 0; a < 3; ++a) exits[a] = way.axis[a].share_at(way.axis[a].far_face_of(brick[a]));
  piece.inside = kind == Kind::still;
  for (int n = 0; n < most_bricks; ++n) {
    const auto a = static_cast<int>(std::min_element(exits, exits + 3) - exits);
    piece.end = std::min(exits[a], way.leaves);
    if (!(piece.end < way.leaves)) break;
    brick[a] += way.axis[a].way > 0.0 ? 1 : -1;
    if (kind_of(brick) != kind) break;
    exits[a] = way.axis[a].share_at(way.axis[a].far_face_of(brick[a]));
  }
  return true;
}

bool GridBase::is_finite_on(int component, const Passage& cell) const noexcept {
  Stretch piece;
  polynomial(component, cell, polynomials, piece);
  return std::all_of(piece.control, piece.control + piece.degree + 1, [](double c) { return std::isfinite(c); });
}

Stretch GridBase::stretch_of(int component, const Bricks* bricks, const Vec3& from_m, const Vec3& to_m, double begin,
                             const Extent& quiet) const noexcept {
  Way way(steps_of(from_m), steps_of(to_m), *this);
  if (!(begin >= 0.0) || !way.has_data_after(begin)) return {};
  if (begin < way.enters) return {.end = way.enters};
  way.enter(begin);
  Stretch piece;
  if (bricks && cross_bricks(*bricks, way, quiet, piece)) return piece;

  const Passage cell = way.pass(begin, piece.end);
  polynomial(component, cell, quiet, piece);
  piece.inside = true;
  for (int i = 0; i <= piece.degree; ++i) {
    piece.control[i] = piece.control[i] * view_.scale + view_.offset;
    piece.inside = piece.inside && std::isfinite(piece.control[i]);
  }
  for (int c = 0; c < components() && piece.inside && view_.valid_share < 1.0; ++c) {
    if (c != component) piece.inside = is_finite_on(c, cell);
  }
  return piece.inside ? piece : Stretch{.end = piece.end};
}

Stretch GridBase::stretch(const Vec3& from_m, const Vec3& to_m, double begin, const Extent& quiet) const noexcept {
  if (components() == 1) return stretch_of(0, bricks_.empty() ? nullptr : &bricks_, from_m, to_m, begin, quiet);
  if (view_.valid_share == 1.0) {
    const Way way(steps_of(from_m), steps_of(to_m), *this);
    if (!(begin >= 0.0) || !way.has_data_after(begin)) return {};
    return {.end = begin < way.enters ? way.enters : way.leaves, .inside = begin >= way.enters};
  }
  const Stretch piece = stretch_of(0, nullptr, from_m, to_m, begin, polynomials);
  return {.end = piece.end, .inside = piece.inside};
}

// The rows of values along i that the interpolant reads: one or two lines of the cache each.
void GridBase::prefetch(const Vec3& world_m) const noexcept {
  Cell cells[3];
  if (!locate(world_m, cells)) return;
  const std::int64_t reach = view_.filter == Filter::trilinear ? 0 : 1;
  const auto bytes = static_cast<std::int64_t>(size_of(view_.voxels.type));
  std::int64_t first[3], last[3];
  for (int a = 0; a < 3; ++a) {
    first[a] = std::max<std::int64_t>(cells[a].first - reach, 0);
    last[a] = std::min(cells[a].first + 1 + reach, view_.geometry.dims[a] - 1);
  }
  const auto* values = static_cast<const char*>(coefficients_.get()) + bytes * first[0] * stride_[0];
  const std::int64_t length = bytes * ((last[0] - first[0] + 1) * stride_[0]) - 1;
  for (std::int64_t k = first[2]; k <= last[2]; ++k) {
    for (std::int64_t j = first[1]; j <= last[1]; ++j) {
      const char* row = values + bytes * (k * stride_[2] + j * stride_[1]);
      __builtin_prefetch(row);
      __builtin_prefetch(row + length);
    }
  }
}

double GridBase::depth_m(const Vec3& world_m) const noexcept {
  const Vec3 p = steps_of(world_m);
  const double at[3] = {p.x, p.y, p.z};
  double depth = std::numeric_limits<double>::max();
  for (int a = 0; a < 3; ++a) {
    const double low = at[a] + half_[a];
    const double high = last_[a] + half_[a] - at[a];
    if (!std::isfinite(low) || !std::isfinite(high)) return 0.0;
    depth = std::min(depth, std::min(low, high) * plane_distance_m_[a]);
  }
  return std::isfinite(depth) ? depth : 0.0;
}

}  // namespace palpa::detail

namespace palpa {

const GridView* grid_behind(const Field& field) noexcept {
  const auto* grid = dynamic_cast<const detail::GridBase*>(&field);
  return grid ? &grid->view() : nullptr;
}

}  // namespace palpa
