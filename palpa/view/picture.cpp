#include "palpa/view/picture.h"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>

#include <cstring>

#include "palpa/base/new_file.h"
#include "palpa/view/offscreen.h"

namespace palpa {

std::string png_of(const Picture& picture) {
  detail::QuietVtk quiet;
  vtkNew<vtkImageData> image;
  image->SetDimensions(picture.width_px, picture.height_px, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(picture.width_px);
  for (int row = 0; row < picture.height_px; ++row) {
    std::memcpy(image->GetScalarPointer(0, picture.height_px - 1 - row, 0), picture.rgb.data() + row * row_bytes, row_bytes);
  }
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputData(image);
  writer->WriteToMemoryOn();
  writer->Write();
  quiet.raise_error();
  const vtkUnsignedCharArray& bytes = *writer->GetResult();
  return {reinterpret_cast<const char*>(const_cast<vtkUnsignedCharArray&>(bytes).GetPointer(0)),
          static_cast<std::size_t>(bytes.GetNumberOfValues())};
}

void save_png(const Picture& picture, const std::filesystem::path& file) {
  detail::write_whole(file, png_of(picture), detail::Existing::replaced);
}

}  // namespace palpa
