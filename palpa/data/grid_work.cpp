#include "palpa/data/grid_work.h"

#include <stdexcept>
#include <string>

#include "palpa/base/free_memory.h"
#include "palpa/base/printed.h"

namespace palpa::detail {
namespace {

std::string format_grids(const GridGeometry& geometry, double grids) {
  return text("%.0f × %lld × %lld × %lld samples", grids, static_cast<long long>(geometry.dims[0]),
              static_cast<long long>(geometry.dims[1]), static_cast<long long>(geometry.dims[2]));
}

}  // namespace

void expect_few_samples(const GridGeometry& geometry, double grids, const Limit& limit) {
  if (!limit.is_passed_by(static_cast<double>(geometry.voxels()) * grids)) return;
  throw std::invalid_argument(format_grids(geometry, grids) + " are " + more_than(limit));
}

void expect_memory(const GridGeometry& geometry, double grids, int components, std::string_view right) {
  const double bytes = static_cast<double>(geometry.voxels()) * grids * components * sizeof(float);
  const auto free_bytes = static_cast<double>(free_memory_bytes());
  if (bytes <= free_bytes) return;
  throw std::invalid_argument(format_grids(geometry, grids) +
                              text(" need %.3g GB where %.3g GB are free; ", 1e-9 * bytes, 1e-9 * free_bytes) +
                              std::string(right));
}

}  // namespace palpa::detail
