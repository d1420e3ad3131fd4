#include "itk_image.h"

#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkImageFileReader.h>
#include <itkImageSeriesReader.h>
#include <itkNiftiImageIO.h>

#include <limits>

namespace palpa::test {
namespace {

using Image = itk::Image<double, 3>;

ItkImage copied(const Image& image) {
  const auto size = image.GetLargestPossibleRegion().GetSize();
  ItkImage copy;
  for (unsigned a = 0; a < 3; ++a) copy.dims[a] = static_cast<std::int64_t>(size[a]);
  const auto& direction = image.GetDirection();
  const auto& spacing = image.GetSpacing();
  for (unsigned r = 0; r < 3; ++r) {
    copy.index_to_world_mm.row[r] = {direction[r][0] * spacing[0], direction[r][1] * spacing[1], direction[r][2] * spacing[2]};
  }
  copy.origin_mm = {image.GetOrigin()[0], image.GetOrigin()[1], image.GetOrigin()[2]};
  copy.values.assign(image.GetBufferPointer(), image.GetBufferPointer() + size[0] * size[1] * size[2]);
  return copy;
}

}  // namespace

double ItkImage::at(const Vec3& world_mm) const {
  const Vec3 index = inverse(index_to_world_mm) * (world_mm - origin_mm);
  const double position[3] = {index.x, index.y, index.z};
  double value = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::int64_t at = 0, stride = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      if (!(position[a] >= 0 && position[a] <= static_cast<double>(dims[a] - 1)))
        return std::numeric_limits<double>::quiet_NaN();
      const auto low = std::min(static_cast<std::int64_t>(position[a]), dims[a] - 2);
      const double f = position[a] - static_cast<double>(low);
      const bool high = (corner >> a & 1) != 0;
      weight *= high ? f : 1 - f;
      at += stride * (low + (high ? 1 : 0)), stride *= dims[a];
    }
    value += weight * values[static_cast<std::size_t>(at)];
  }
  return value;
}

ItkImage dicom_by_itk(const std::filesystem::path& folder) {
  const auto names = itk::GDCMSeriesFileNames::New();
  names->SetDirectory(folder.string());
  const auto reader = itk::ImageSeriesReader<Image>::New();
  reader->SetImageIO(itk::GDCMImageIO::New());
  reader->SetFileNames(names->GetFileNames(names->GetSeriesUIDs().front()));
  reader->ForceOrthogonalDirectionOff();
  reader->Update();
  return copied(*reader->GetOutput());
}

ItkImage nifti_by_itk(const std::filesystem::path& file) {
  const auto reader = itk::ImageFileReader<Image>::New();
  reader->SetImageIO(itk::NiftiImageIO::New());
  reader->SetFileName(file.string());
  reader->Update();
  return copied(*reader->GetOutput());
}

}  // namespace palpa::test
