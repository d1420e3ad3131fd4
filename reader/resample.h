// Resampling of curvilinear and unstructured grids onto an affine grid.
#pragma once

#include <vtkPointSet.h>
#include <vtkSmartPointer.h>

#include <atomic>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "cell_values.h"
#include "palpa/data/field.h"
#include "palpa/data/grid.h"
#include "palpa/data/volume.h"

namespace palpa::reader {

inline constexpr float nan = std::numeric_limits<float>::quiet_NaN();
inline Vec3 vec(const double* p) { return {p[0], p[1], p[2]}; }

struct Resampled {
  Resampling report;
  std::optional<Box> worst;  ///< box of most positions with an error above `much_error`
};
inline constexpr double much_error = 0.05;  ///< [1] of the range. Less: more warnings; more: losses that are felt go unreported

/// Blocks of cells as one body of data. Resamples the cells' interpolants, their shape functions; cell values are averaged to
/// the points first. Blanked cells (hidden, or with a hidden point) count as holes.
/// All lengths are in the file's unit.
class Resampler {
 public:
  /// Chooses the affine grid: along the file's axes, with steps of half the lower quartile of the cells' extents, or longer
  /// steps if that would be too many voxels. Throws LoadError, with a sentence, if no cell has a volume.
  /// \param crop  wanted part of the data
  Resampler(std::vector<vtkSmartPointer<vtkPointSet>> blocks, const std::optional<Box>& crop);

  const GridGeometry& grid() const noexcept { return grid_; }
  /// "resampled to … voxels of …", and the reason for no more. Empty where a wanted part is as fine as its cells.
  std::string description() const;
  /// Memory for sampling beside the voxels, for this many numbers per point.
  std::uint64_t working_bytes(int components) const noexcept;

  /// Fills one grid of floats per array, NaN without data; then measures the loss at random positions. Uses two threads.
  std::vector<Resampled> sample(const std::vector<ArrayName>& arrays, const std::vector<float*>& to) const;

 private:
  struct Cell {
    std::int64_t block, id;
    float low[3], high[3];  ///< enlarged box, in units of `unit_` from `centre_`
  };
  void normalise();
  void find_cells(const std::optional<Box>& crop);
  void choose_grid(const std::optional<Box>& crop);
  void load(const Cell& cell, CellAt& to) const;
  /// Grid in units of `unit_` from `centre_`.
  struct Steps {
    double origin[3], step[3];
    double at(int axis, std::int64_t voxel) const noexcept { return origin[axis] + static_cast<double>(voxel) * step[axis]; }
  };
  struct Voxels {
    std::int64_t first = 0, end = 0;  ///< along an axis
    std::int64_t count() const noexcept { return end - first; }
  };
  Steps steps() const;
  Voxels voxels_between(const Steps& steps, std::size_t axis, double low, double high) const;
  bool narrow(const CellAt& cell, const Steps& steps, std::int64_t k, Voxels& i_range, Voxels& j_range) const;
  void fill(const std::vector<PointValues>& values, const std::vector<float*>& to, std::vector<std::uint8_t>& done,
            std::int64_t first_k, std::int64_t last_k, std::atomic<std::int64_t>& tests_left) const;
  struct Loss {
    ResamplingError error;
    std::optional<Box> worst;
  };
  /// Losses of each array, at random positions in random cells.
  /// \param sampled    the arrays so far, with known ranges
  /// \param by_volume  weights cells by their volume, as the probe meets them
  std::vector<Loss> look(const std::vector<PointValues>& values, const std::vector<float*>& to,
                         const std::vector<Resampled>& sampled, bool by_volume) const;

  std::vector<vtkSmartPointer<vtkPointSet>> blocks_;  ///< with points in units of `unit_`: shape functions fail on tiny cells
  std::vector<Cell> cells_;
  std::optional<Box> crop_;
  Vec3 centre_;
  double unit_ = 1.0;
  Box box_;  ///< of the cells
  double shortest_edge_ = 0.0;
  GridGeometry grid_;
  bool bounded_ = false;  ///< steps are longer than the cells require
};

}  // namespace palpa::reader
