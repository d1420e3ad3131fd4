// DICOM and NIfTI by ITK, the independent reader: right except for gantry tilt, sheared sforms and missing slices.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa::test {

struct ItkImage {
  std::array<std::int64_t, 3> dims;
  Mat3 index_to_world_mm;  ///< world: LPS
  Vec3 origin_mm;
  std::vector<double> values;  ///< i fastest

  /// The value at a position, trilinear; NaN outside.
  double at(const Vec3& world_mm) const;
};

ItkImage dicom_by_itk(const std::filesystem::path& folder);
ItkImage nifti_by_itk(const std::filesystem::path& file);

}  // namespace palpa::test
