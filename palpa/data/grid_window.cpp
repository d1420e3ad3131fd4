#include "palpa/data/grid_window.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "palpa/data/bricks.h"
#include "palpa/data/grid_base.h"

namespace palpa {

FieldPtr window_field(const GridGeometry& whole, const GridWindow& window, Voxels voxels, Filter filter, double scale,
                      double offset) {
  if (whole.is_rectilinear()) throw std::invalid_argument("a rectilinear grid has no windows; it is felt as a whole");
  if (filter == Filter::cubic)
    throw std::invalid_argument("the coefficients of a cubic filter depend on the whole grid; use smooth");
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t first = window.first[a], dims = window.dims[a];
    const auto last = static_cast<double>(whole.dims[a] - 1);
    if (first < 0 || dims < 1 || first > whole.dims[a] - dims) throw std::invalid_argument("the window is not within the grid");
    if (first % detail::Bricks::cells != 0) throw std::invalid_argument("the window begins within a brick of its grid");
    if (!(window.data_low[a] >= -0.5 && window.data_low[a] <= window.data_high[a] && window.data_high[a] <= last + 0.5))
      throw std::invalid_argument("the data of the window's grid are not between its first and last voxel");
  }
  const auto make = filter == Filter::trilinear ? detail::trilinear_window : detail::smooth_window;
  return make(whole, window, std::move(voxels), scale, offset);
}

}  // namespace palpa

namespace palpa::detail {

namespace {
constexpr double unbounded = std::numeric_limits<double>::infinity();
}

template <class Visit>
void GridBase::for_each_face(const Vec3& steps, Visit&& visit) const noexcept {
  const double at[3] = {steps.x, steps.y, steps.z};
  for (std::size_t a = 0; a < 3; ++a) {
    if (window_.first[a] > 0) visit(a, at[a] - extent_.low[a], -1.0);
    if (window_.first[a] + window_.dims[a] < view_.geometry.dims[a]) visit(a, extent_.high[a] - at[a], 1.0);
  }
}

double GridBase::room_voxels(const Vec3& world_m) const noexcept {
  double room = unbounded;
  for_each_face(steps_of(world_m), [&](std::size_t, double way, double) { room = std::min(room, way); });
  return std::isnan(room) ? -unbounded : room;
}

double GridBase::stays_s(const Vec3& world_m, const Vec3& velocity_m_per_s, double margin) const noexcept {
  const Vec3 rate = world_to_steps_ * velocity_m_per_s;
  const double rates[3] = {rate.x, rate.y, rate.z};
  double time_s = unbounded;
  for_each_face(steps_of(world_m), [&](std::size_t a, double way, double side) {
    const double left = way - margin, towards = side * rates[a];
    if (!(left > 0.0)) time_s = 0.0;
    if (towards > 0.0) time_s = std::min(time_s, left / towards);
  });
  return std::max(time_s, 0.0);
}

std::array<double, 2> GridBase::passage(const Vec3& from_m, const Vec3& to_m) const noexcept {
  const Vec3 from = steps_of(from_m), way = steps_of(to_m) - from;
  const double ways[3] = {way.x, way.y, way.z};
  double enters = 0.0, leaves = 1.0;
  for_each_face(from, [&](std::size_t a, double left, double side) {
    const double towards = side * ways[a];
    if (towards > 0.0) leaves = std::min(leaves, left / towards);
    if (towards < 0.0) enters = std::max(enters, left / towards);
    if (!(towards < 0.0) && !(left >= 0.0)) leaves = -1.0;
  });
  return {enters, enters < leaves ? leaves : -1.0};
}

}  // namespace palpa::detail
