#include "palpa/data/unread_grid.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <utility>

namespace palpa {
namespace {

class UnreadGrid final : public Field {
 public:
  UnreadGrid(const GridGeometry& geometry, Voxels voxels, double scale, double offset)
      : voxels_(std::move(voxels)),
        looked_at_(preview_grid_field(geometry, voxels_, scale, offset, geometry.dims[1] * geometry.dims[2])) {}

  const FieldPtr& whole() const {
    std::call_once(once_, [this] {
      const GridView& grid = *grid_of(*looked_at_);
      whole_ = grid_field(grid.geometry, voxels_, grid.scale, grid.offset);
      read_.store(whole_.get(), std::memory_order_release);
    });
    return whole_;
  }
  /// Loaded grid, or the placeholder on out-of-memory.
  const Field& as_known() const noexcept {
    if (const Field* const read = read_.load(std::memory_order_acquire)) return *read;
    try {
      return *whole();
    } catch (const std::exception&) {
      return *looked_at_;
    }
  }
  const Field& looked_at() const noexcept { return *looked_at_; }

  int components() const noexcept override { return looked_at_->components(); }
  int values_per_sample() const noexcept override { return looked_at_->values_per_sample(); }
  double spacing_m() const noexcept override { return looked_at_->spacing_m(); }
  double local_spacing_m(const Vec3& world_m) const noexcept override { return looked_at_->local_spacing_m(world_m); }
  Box bounds_m() const noexcept override { return looked_at_->bounds_m(); }
  ScalarSample scalar(const Vec3& world_m) const noexcept override { return looked_at_->scalar(world_m); }
  VectorSample vector(const Vec3& world_m) const noexcept override { return looked_at_->vector(world_m); }
  Mat3 hessian(const Vec3& world_m) const noexcept override { return looked_at_->hessian(world_m); }

  PolynomialPiece piece_along(const Vec3& from_m, const Vec3& to_m, double begin,
                              const ValueRange& quiet) const noexcept override {
    return as_known().piece_along(from_m, to_m, begin, quiet);
  }
  LipschitzBound lipschitz_bound(const Vec3& world_m) const noexcept override { return as_known().lipschitz_bound(world_m); }
  double depth_m(const Vec3& world_m) const noexcept override { return as_known().depth_m(world_m); }
  std::vector<ValueRange> value_ranges() const override { return whole()->value_ranges(); }

 private:
  const Voxels voxels_;
  const FieldPtr looked_at_;
  mutable std::once_flag once_;
  mutable FieldPtr whole_;
  mutable std::atomic<const Field*> read_{nullptr};
};

const UnreadGrid* unread(const Field& field) noexcept { return dynamic_cast<const UnreadGrid*>(&field); }

}  // namespace

FieldPtr unread_grid_field(const GridGeometry& geometry, Voxels voxels, double scale, double offset) {
  if (const char* problem = problem_with(geometry)) throw std::invalid_argument(problem);
  return std::make_shared<const UnreadGrid>(geometry, std::move(voxels), scale, offset);
}

namespace detail {

FieldPtr read_now(const FieldPtr& field) {
  const UnreadGrid* const grid = unread(*field);
  return grid ? grid->whole() : field;
}

const GridView* view_read_now(const Field& field) noexcept {
  const UnreadGrid* const grid = unread(field);
  return grid ? grid_of(grid->as_known()) : nullptr;
}

const Field& sampler_of(const Field& field) noexcept {
  const UnreadGrid* const grid = unread(field);
  return grid ? grid->looked_at() : field;
}

}  // namespace detail
}  // namespace palpa
