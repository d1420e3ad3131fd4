#include "palpa/data/grid_base.h"

#include <array>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "palpa/data/parallel.h"
#include "palpa/data/row_samples.h"
#include "palpa/data/unread_grid.h"

namespace palpa::detail {
namespace {

struct Found {
  std::array<ValueRange, 3> ranges;  ///< raw; min > max if none is finite
  std::int64_t valid = 0;            ///< voxels with all components finite

  void join(const Found& other) noexcept {
    for (std::size_t c = 0; c < 3; ++c) {
      ranges[c] = {std::min(ranges[c].min, other.ranges[c].min), std::max(ranges[c].max, other.ranges[c].max)};
    }
    valid += other.valid;
  }
};

/// Number of finite voxels of samples, from one to before another.
template <int Components, class T>
std::int64_t finite_voxels(const T* voxels, std::int64_t width, const RowSamples& rows, std::int64_t from,
                           std::int64_t to) noexcept {
  std::int64_t count = 0;
  for (std::int64_t sample = from; sample < to; ++sample) {
    const T* voxel = voxels + rows[sample] * width * Components;
    for (std::int64_t v = 0; v < width; ++v, voxel += Components) {
      T poison{};
      for (int c = 0; c < Components; ++c) poison += voxel[c] - voxel[c];
      count += poison == T{};
    }
  }
  return count;
}

/// Range over samples, from one to before another. By value in lanes, which the compiler vectorises.
template <int Components, class T>
Found find_range(const T* voxels, std::int64_t width, const RowSamples& rows, std::int64_t from, std::int64_t to) noexcept {
  constexpr std::int64_t lanes = 48;                 // [values] of whole registers and whole voxels
  T least[lanes], greatest[lanes], poison[lanes]{};  // the last: NaN after a value that was not finite
  std::fill(least, least + lanes, std::numeric_limits<T>::max());
  std::fill(greatest, greatest + lanes, std::numeric_limits<T>::lowest());
  const auto take = [&](T value, std::int64_t lane) {
    if constexpr (std::is_floating_point_v<T>) {
      const T bad = value - value;
      poison[lane] += bad;
      value += bad;  // NaN, neither less nor greater, if not finite
    }
    least[lane] = value < least[lane] ? value : least[lane];
    greatest[lane] = value > greatest[lane] ? value : greatest[lane];
  };
  const std::int64_t at_once = rows.step == 1 ? to - from : 1, values = at_once * width * Components;
  for (std::int64_t sample = from; sample < to; sample += at_once) {
    const T* value = voxels + rows[sample] * width * Components;
    std::int64_t v = 0;
    for (; v + lanes <= values; v += lanes) {
      for (std::int64_t lane = 0; lane < lanes; ++lane) take(value[v + lane], lane);
    }
    for (std::int64_t lane = 0; v < values; ++v, ++lane) take(value[v], lane);
  }
  Found found{.valid = (to - from) * width};
  if constexpr (std::is_floating_point_v<T>) {
    if (std::any_of(poison, poison + lanes, [](T bad) { return bad != T{}; }))
      found.valid = finite_voxels<Components>(voxels, width, rows, from, to);
  }
  for (int c = 0; c < Components; ++c) {
    for (std::int64_t lane = c + Components; lane < lanes; lane += Components) {
      least[c] = std::min(least[c], least[lane]);
      greatest[c] = std::max(greatest[c], greatest[lane]);
    }
    found.ranges[c] = {static_cast<double>(least[c]), static_cast<double>(greatest[c])};
  }
  return found;
}

/// Ranges of all components, on all cores.
template <class T>
Found find_ranges(const T* voxels, int components, std::int64_t width, const RowSamples& rows) {
  constexpr std::int64_t worth_a_thread = 1 << 16;  // [voxels] fewer: thread overhead; more: idle cores
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Found all;
  all.ranges.fill({infinity, -infinity});
  std::mutex joining;
  in_parts(rows.count(), worth_a_thread / width + 1, [&](std::int64_t first, std::int64_t last) {
    const Found found =
        components == 1 ? find_range<1>(voxels, width, rows, first, last) : find_range<3>(voxels, width, rows, first, last);
    const std::lock_guard lock(joining);
    all.join(found);
  });
  return all;
}

/// \param one_row_in  as of GridBase
VoxelFacts facts_of(const GridGeometry& geometry, const Voxels& voxels, std::int64_t one_row_in) {
  VoxelFacts facts{geometry.dims, {}, 1.0, {}};
  const bool is_felt = one_row_in == 0;
  if (is_felt) facts.bricks = Bricks(geometry, voxels);
  with_values_of(voxels, [&]<class T>(const T* values) {
    constexpr bool held_by_bricks = std::is_same_v<T, float> || sizeof(T) <= 2;  // exactly
    if (held_by_bricks && is_felt && facts.bricks.whole(0)) {
      for (int c = 0; c < voxels.components; ++c) {
        const Bricks::Range whole = *facts.bricks.whole(c);
        facts.ranges[static_cast<std::size_t>(c)] = {whole.min, whole.max};
      }
      return;
    }
    const std::int64_t width = geometry.dims[0];
    const RowSamples rows{geometry.dims[1] * geometry.dims[2], is_felt ? 1 : one_row_in};
    const Found found = find_ranges(values, voxels.components, width, rows);
    facts.ranges = found.ranges;
    facts.valid_share = static_cast<double>(found.valid) / static_cast<double>(rows.count() * width);
  });
  return facts;
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

  // Both ends of every side are samples, so steps differ a little between axes.
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
                   std::shared_ptr<const void> coefficients, std::int64_t one_row_in, const GridWindow* window)
    : view_{geometry, std::move(voxels), scale, offset, 1.0, filter, signless},
      coefficients_(coefficients ? std::move(coefficients) : view_.voxels.data),
      world_to_steps_(scaled_inverse(geometry.index_to_world_m)),
      window_(window ? *window : GridWindow{{}, geometry.dims, {}, {}}) {
  find_place(window != nullptr);
  find_steepest();
  if (one_row_in != 0) {
    find_extents(facts_of(geometry, view_.voxels, one_row_in));
    if (one_row_in == 1 && view_.valid_share < 1.0) find_holes();
    return;
  }
  std::shared_ptr<const VoxelFacts>& facts = view_.voxels.facts;
  const GridGeometry in_memory = of_memory();
  if (!facts || facts->dims != in_memory.dims) facts = std::make_shared<const VoxelFacts>(facts_of(in_memory, view_.voxels, 0));
  find_extents(*facts);
  bricks_ = {facts, &facts->bricks};
  if (coefficients_ != view_.voxels.data) {
    bricks_ = std::make_shared<const Bricks>(in_memory, Voxels{view_.voxels.type, components(), coefficients_});
  }
  if (!bricks_->whole(0)) find_holes();
}

void GridBase::find_holes() {
  const Voxels values{view_.voxels.type, components(), coefficients_};
  holes_ = Holes(of_memory(), values, world_to_steps_, view_.filter == Filter::trilinear ? 1 : 2);
}

/// Geometry of the voxels in memory.
GridGeometry GridBase::of_memory() const {
  GridGeometry part = view_.geometry;
  part.dims = window_.dims;
  return part;
}

void GridBase::find_place(bool is_window) {
  const GridGeometry& geometry = view_.geometry;
  is_rectilinear_ = geometry.is_rectilinear();
  std::int64_t stride = components();
  for (int a = 0; a < 3; ++a) {
    const std::int64_t n = geometry.dims[a];
    const auto axis = static_cast<std::size_t>(a);
    last_[a] = static_cast<double>(n - 1);
    const double half = n > 1 ? 0.0 : 0.5, beyond = half + face_tolerance_voxels;
    box_.low[a] = -half, box_.high[a] = last_[a] + half;
    extent_.low[a] = -beyond, extent_.high[a] = last_[a] + beyond;
    if (is_window) find_extent_of_window(a);
    cells_[a] = std::max<std::int64_t>(n - 1, 1);
    stride_[a] = stride;
    before_window_ += stride * window_.first[axis];
    first_brick_[a] = window_.first[axis] >> Bricks::shift;
    stride *= window_.dims[axis];
    planes_per_m_[a] = norm(world_to_steps_.row[a]);
    plane_distance_m_[a] = 1.0 / planes_per_m_[a];
    const std::vector<double>& planes = geometry.planes[static_cast<std::size_t>(a)];
    planes_[a] = planes.empty() ? nullptr : planes.data();
    double least = 1.0;
    for (std::size_t i = 1; i < planes.size(); ++i) least = std::min(least, planes[i] - planes[i - 1]);
    spacing_m_ = a == 0 ? least * plane_distance_m_[a] : std::min(spacing_m_, least * plane_distance_m_[a]);
  }
  for (int corner = 0; corner < 8; ++corner) {
    const auto at = [&](int a) { return corner >> a & 1 ? box_.high[a] : box_.low[a]; };
    const Vec3 world = geometry.index_to_world_m * Vec3{at(0), at(1), at(2)} + geometry.origin_m;
    if (corner == 0) bounds_m_ = {world, world};
    bounds_m_.low_m = {std::min(bounds_m_.low_m.x, world.x), std::min(bounds_m_.low_m.y, world.y),
                       std::min(bounds_m_.low_m.z, world.z)};
    bounds_m_.high_m = {std::max(bounds_m_.high_m.x, world.x), std::max(bounds_m_.high_m.y, world.y),
                        std::max(bounds_m_.high_m.z, world.z)};
  }
}

/// Along an axis: samples need voxels beyond their cell, but at the borders of the whole grid, where the outermost repeat.
void GridBase::find_extent_of_window(int axis) {
  const auto a = static_cast<std::size_t>(axis);
  const std::int64_t end = window_.first[a] + window_.dims[a];
  const double reach = view_.filter == Filter::trilinear ? 0.0 : 1.0;
  box_.low[axis] = window_.data_low[a], box_.high[axis] = window_.data_high[a];
  extent_.low[axis] = box_.low[axis] - face_tolerance_voxels, extent_.high[axis] = box_.high[axis] + face_tolerance_voxels;
  if (window_.first[a] > 0) extent_.low[axis] = std::max(extent_.low[axis], static_cast<double>(window_.first[a]) + reach);
  // On the last plane a sample would be in the cell behind it.
  if (end < view_.geometry.dims[a])
    extent_.high[axis] = std::min(extent_.high[axis], std::nextafter(static_cast<double>(end - 1) - reach, 0.0));
}

void GridBase::find_extents(const VoxelFacts& facts) {
  view_.valid_share = facts.valid_share;
  for (int c = 0; c < components(); ++c) {
    extents_.push_back({});
    const ValueRange& raw = facts.ranges[static_cast<std::size_t>(c)];
    if (!(raw.min <= raw.max)) continue;
    const auto [min, max] = std::minmax({raw.min * view_.scale + view_.offset, raw.max * view_.scale + view_.offset});
    if (!std::isfinite(min) || !std::isfinite(max)) {
      throw std::invalid_argument("scale and offset take the grid's values beyond the largest number; use smaller ones");
    }
    extents_.back() = {min, max};
  }
}

namespace {

/// Empty range, to request polynomials: no value is quiet.
constexpr ValueRange polynomials{1.0, -1.0};

struct Axis {
  double from = 0.0;               ///< [steps] start of the segment
  double way = 0.0;                ///< [steps] from start to end
  double low = 0.0;                ///< [steps] start of the data
  double high = 0.0;               ///< [steps] end of the data
  double last = 0.0;               ///< [steps] last voxel
  const double* planes = nullptr;  ///< [steps] of a rectilinear axis
  /// [voxels] The segment is between voxels zone and zone + 1; −1 and `last`: before the first and behind the last, where the
  /// values at the edge continue to the end of the data.
  std::int64_t zone = 0;

  double at(double share) const noexcept { return from + share * way; }
  double plane(std::int64_t index) const noexcept { return planes ? planes[index] : static_cast<double>(index); }
  /// Share of the segment at a position [steps]; infinite along an axis without motion.
  double share_at(double place) const noexcept {
    return way != 0.0 ? (place - from) / way : std::numeric_limits<double>::infinity();
  }
  bool is_behind() const noexcept { return static_cast<double>(zone) >= last; }
  double far_face() const noexcept {
    if (way > 0.0) return is_behind() ? high : plane(zone + 1);
    return zone < 0 ? low : plane(zone);
  }
  /// Zone of a position; with `before`, a position on a plane belongs to the zone before.
  std::int64_t zone_of(double place, bool before) const noexcept {
    if (!planes) return static_cast<std::int64_t>(std::clamp(before ? std::ceil(place) - 1.0 : std::floor(place), -1.0, last));
    const double* end = planes + static_cast<std::int64_t>(last) + 1;
    return (before ? std::lower_bound(planes, end, place) : std::upper_bound(planes, end, place)) - planes - 1;
  }
  /// Sets the zone ahead of `share`: its far face lies ahead.
  void enter(double share) noexcept {
    zone = zone_of(at(share), way < 0.0);
    while (way > 0.0 && !is_behind() && share_at(far_face()) <= share) ++zone;
    while (way < 0.0 && zone >= 0 && share_at(far_face()) <= share) --zone;
  }
  std::int64_t first_voxel() const noexcept {
    return std::clamp<std::int64_t>(zone, 0, std::max<std::int64_t>(static_cast<std::int64_t>(last) - 1, 0));
  }
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

/// Segment through the grid, and its part with data.
struct GridBase::Way {
  Axis axis[3];
  double enters = 0.0;  ///< [1]
  double leaves = 1.0;  ///< [1]

  Way(const Vec3& from, const Vec3& to, const GridBase& grid) noexcept {
    const double starts[3] = {from.x, from.y, from.z}, ends[3] = {to.x, to.y, to.z};
    for (int a = 0; a < 3; ++a) {
      axis[a] = {starts[a], ends[a] - starts[a], grid.extent_.low[a], grid.extent_.high[a], grid.last_[a], grid.planes_[a], 0};
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

  /// Cell entered at `begin`, and the share of its exit.
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
      // Exactly on the exit face: the next cell begins there.
      const bool between = axis[a].zone >= 0 && !axis[a].is_behind();
      cell.end[a] = between && exits[a] == end ? (axis[a].way > 0.0 ? 1.0 : 0.0) : axis[a].fraction(end);
    }
    return cell;
  }
};

bool GridBase::cross_bricks(int component, const Way& way, const ValueRange& quiet, PolynomialPiece& piece) const noexcept {
  enum class Kind { mixed, still, none };
  const auto kind_of = [&](const std::int64_t(&b)[3]) {
    const Bricks::Range& range = brick_at(component, b);
    if (range.min > range.max) return Kind::none;
    return is_quiet(range.min, range.max, quiet) ? Kind::still : Kind::mixed;
  };
  std::int64_t brick[3];
  for (int a = 0; a < 3; ++a) brick[a] = way.axis[a].brick();
  const Kind kind = kind_of(brick);
  if (kind == Kind::mixed) return false;

  // [1] Bricks skipped in one piece. More: longer worst tick; fewer: quiet segments are cut into more pieces.
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
  PolynomialPiece piece;
  polynomial(component, cell, polynomials, piece);
  return std::all_of(piece.control, piece.control + piece.degree + 1, [](double c) { return std::isfinite(c); });
}

PolynomialPiece GridBase::stretch_of(int component, const Vec3& from_m, const Vec3& to_m, double begin,
                                     const ValueRange& quiet) const noexcept {
  Way way(steps_of(from_m), steps_of(to_m), *this);
  if (!(begin >= 0.0) || !way.has_data_after(begin)) return {};
  if (begin < way.enters) return {.end = way.enters};
  way.enter(begin);
  PolynomialPiece piece;
  if (bricks_ && cross_bricks(component, way, quiet, piece)) return piece;

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
  return piece.inside ? piece : PolynomialPiece{.end = piece.end};
}

double GridBase::end_of_cell(const Vec3& from_m, const Vec3& to_m, double begin) const noexcept {
  Way way(steps_of(from_m), steps_of(to_m), *this);
  double end = 1.0;
  if (!(begin >= way.enters) || !way.has_data_after(begin)) return end;
  way.enter(begin);
  way.pass(begin, end);
  return end;
}

PolynomialPiece GridBase::piece_along(const Vec3& from_m, const Vec3& to_m, double begin,
                                      const ValueRange& quiet) const noexcept {
  if (components() == 1) return stretch_of(0, from_m, to_m, begin, quiet);
  if (view_.valid_share == 1.0) {
    const Way way(steps_of(from_m), steps_of(to_m), *this);
    if (!(begin >= 0.0) || !way.has_data_after(begin)) return {};
    return {.end = begin < way.enters ? way.enters : way.leaves, .inside = begin >= way.enters};
  }
  const PolynomialPiece piece = stretch_of(0, from_m, to_m, begin, polynomials);
  return {.end = piece.end, .inside = piece.inside};
}

double GridBase::depth_at(const Vec3& steps) const noexcept {
  const double at[3] = {steps.x, steps.y, steps.z};
  double depth = std::numeric_limits<double>::max();
  for (int a = 0; a < 3; ++a) {
    const double low = at[a] - box_.low[a];
    const double high = box_.high[a] - at[a];
    if (!std::isfinite(low) || !std::isfinite(high)) return 0.0;
    depth = std::min(depth, std::min(low, high) * plane_distance_m_[a]);
  }
  return std::isfinite(depth) ? depth : 0.0;
}

double GridBase::depth_m(const Vec3& world_m) const noexcept {
  return holes_.empty() ? depth_at(steps_of(world_m)) : depth_in(place_of(world_m));
}

double GridBase::local_spacing_m(const Vec3& world_m) const noexcept {
  if (!is_rectilinear_) return spacing_m_;
  const Vec3 steps = steps_of(world_m);
  const double at[3] = {steps.x, steps.y, steps.z};
  double least_m = std::numeric_limits<double>::max();
  for (int a = 0; a < 3; ++a) {
    // A non-finite position counts as on the first plane.
    const std::int64_t cell = planes_[a] ? cell_at(a, at[a]) : 0;
    least_m = std::min(least_m, (planes_[a] ? planes_[a][cell + 1] - planes_[a][cell] : 1.0) * plane_distance_m_[a]);
  }
  return least_m;
}

void GridBase::find_steepest() {
  for (int a = 0; a < 3; ++a) {
    for (std::int64_t cell = 0; planes_[a] && cell < cells_[a]; ++cell) {
      if (cell % Bricks::cells == 0) finest_in_[a].push_back(0.0);
      finest_in_[a].back() = std::max(finest_in_[a].back(), 1.0 / (planes_[a][cell + 1] - planes_[a][cell]));
    }
  }
  const std::int64_t first[3]{};
  steepest_per_m_ = steepest(first, first);
}

double GridBase::steepest(const std::int64_t (&low)[3], const std::int64_t (&high)[3]) const noexcept {
  Vec3 per_m[3];
  for (int a = 0; a < 3; ++a) {
    double most = planes_[a] ? 0.0 : 1.0;
    for (std::int64_t b = low[a]; planes_[a] && b <= high[a]; ++b)
      most = std::max(most, finest_in_[a][static_cast<std::size_t>(b)]);
    per_m[a] = most * world_to_steps_.row[a];
  }
  // |s₀ r₀·v| + |r₁·v| + |r₂·v| over unit vectors v is the longest of the sums r₀ ± r₁ ± r₂.
  double squared = 0.0;
  for (const double j : {1.0, -1.0}) {
    for (const double k : {1.0, -1.0}) squared = std::max(squared, norm_squared(per_m[0] + j * per_m[1] + k * per_m[2]));
  }
  return std::sqrt(squared);
}

// An index derivative of either interpolant is a mean of differences of neighbouring voxels, so bounded by the largest in the
// bricks that the ball reaches; a value changes by at most that times the indices passed, summed over the axes. A second index
// derivative of the smooth interpolant is a mean of differences between two of these, and its gradient has no jumps.
LipschitzBound GridBase::certificate_in(const Place& place, int component, int count) const noexcept {
  const double depth = depth_at(place.steps), hair_m = 2.0 * face_tolerance_voxels * spacing_m_;
  if (!bricks_ || view_.signless) return {};  // an axis, interpolated by dyads, may turn at once
  if (!place.inside) return {std::max(0.0, -depth - hair_m)};
  LipschitzBound c{std::min(is_rectilinear_ ? cell_spacing_m(place.cells) : spacing_m_, depth - hair_m)};
  if (!(c.radius_m > 0.0)) return {};

  const double at[3] = {place.steps.x, place.steps.y, place.steps.z};
  const double furthest_m = largest_component(place.world_m) + largest_component(view_.geometry.origin_m);
  constexpr double eps = std::numeric_limits<double>::epsilon();
  std::int64_t low[3], high[3];
  double steps_m = 0.0;
  for (int a = 0; a < 3; ++a) {
    const double reach = c.radius_m * planes_per_m_[a];
    low[a] = cell_at(a, at[a] - reach) >> Bricks::shift;
    high[a] = cell_at(a, at[a] + reach) >> Bricks::shift;
    if (!(at[a] - reach >= extent_.low[a] && at[a] + reach <= extent_.high[a])) return {};  // beyond a window
    steps_m = std::max(steps_m, std::abs(at[a]) * plane_distance_m_[a]);
  }
  double squared = 0.0, largest = 0.0;
  Bricks::Range all{0.0F, 0.0F};
  for (int n = component; n < component + count; ++n) {
    all = brick_at(n, low);
    std::int64_t b[3];
    for (b[2] = low[2]; b[2] <= high[2]; ++b[2]) {
      for (b[1] = low[1]; b[1] <= high[1]; ++b[1]) {
        for (b[0] = low[0]; b[0] <= high[0]; ++b[0]) {
          const Bricks::Range& range = brick_at(n, b);
          if (!(range.min <= range.max)) return {};
          all = {std::min(all.min, range.min), std::max(all.max, range.max), std::max(all.step, range.step)};
        }
      }
    }
    const double step = std::min(static_cast<double>(all.max) - all.min, static_cast<double>(all.step));
    squared += step * step;
    largest = std::max(largest, std::max(std::abs(static_cast<double>(all.min)), std::abs(static_cast<double>(all.max))));
  }
  const double index_slope = std::abs(view_.scale) * std::sqrt(squared);
  c.slope_per_m = index_slope * (is_rectilinear_ ? steepest(low, high) : steepest_per_m_);
  if (count == 1) {
    const double one = all.min * view_.scale + view_.offset, other = all.max * view_.scale + view_.offset;
    c.values = {std::min(one, other), std::max(one, other)};
  }
  // Where cells of two sizes meet the gradient jumps.
  if (count == 1 && !is_rectilinear_ && has_curvature()) c.bend_per_m2 = 2.0 * index_slope * steepest_per_m_ * steepest_per_m_;
  const double shift_m = 32.0 * eps * (furthest_m + steps_m);  // rounding of positions
  c.rounding = 128.0 * eps * (std::abs(view_.scale) * largest + std::abs(view_.offset)) + c.slope_per_m * shift_m;
  return std::isfinite(c.slope_per_m + c.rounding) ? c : LipschitzBound{};
}

}  // namespace palpa::detail

namespace palpa {

const GridView* grid_behind(const Field& field) noexcept {
  const auto* grid = dynamic_cast<const detail::GridBase*>(&field);
  return grid ? &grid->view() : detail::view_read_now(field);
}

}  // namespace palpa
