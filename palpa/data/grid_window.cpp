#include "palpa/data/grid_window.h"

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
