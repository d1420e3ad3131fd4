// Detail of a grid's voxels that a smoothing filter removes.
#pragma once

#include <vector>

#include "palpa/data/grid_base.h"

namespace palpa::detail {

/// Trilinear interpolant of a scalar field's voxels minus the field's filtered value, over three times the root mean square of
/// that difference, and clamped: −1…1 [1]. Normal noise is within ±1/3 at two places of three. That root mean square is
/// computed once, at 4096 places of the grid; three of it are at least a thousandth of the field's range, so that the rounding
/// of smooth data is not amplified.
///
/// 0 wherever the field has data, if it has no detail (`has_detail`). Box, depth and spacing are the field's own. Its
/// derivative jumps between cells, as for a trilinear field, and is 0 where clamped. Sampling is as for every field.
class FineDetail final : public Field {
 public:
  /// \param of  a scalar field that does not change with time
  /// Allocates, and reads the voxels about those places.
  explicit FineDetail(FieldPtr of);

  /// Source grid of the detail; nullptr if none.
  const GridBase* grid() const noexcept { return smooth_; }
  const FieldPtr& of() const noexcept { return of_; }
  /// Sample at a place of that grid's geometry; only with a grid.
  ScalarSample scalar_in(GridBase::Place& place) const noexcept;

  int components() const noexcept override { return 1; }
  ScalarSample scalar(const Vec3& world_m) const noexcept override;
  int values_per_sample() const noexcept override { return of_->values_per_sample() + 2 * 2 * 2; }
  double spacing_m() const noexcept override { return of_->spacing_m(); }
  double local_spacing_m(const Vec3& world_m) const noexcept override { return of_->local_spacing_m(world_m); }
  Box bounds_m() const noexcept override { return of_->bounds_m(); }
  double depth_m(const Vec3& world_m) const noexcept override { return of_->depth_m(world_m); }
  std::vector<ValueRange> value_ranges() const override;

 private:
  double find_scale() const;  ///< in the field's own unit; 0: no detail

  FieldPtr of_;
  const GridBase* smooth_;  ///< `of_` as a grid
  FieldPtr kept_;
  const GridBase* linear_;  ///< its voxels, trilinear
  double scale_ = 0.0;      ///< the field's own unit
};

}  // namespace palpa::detail
