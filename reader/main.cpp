// palpa-read: opens one volume file for the program that started it (palpa/file/read_volume.cpp). What can go wrong with a
// file of somebody else goes wrong here, where it costs one line. It looks at what the file begins with and becomes the program
// that the library for it is linked into: all libraries together take longer to start than most files to read.
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "file_names.h"
#include "first_bytes.h"
#include "palpa/core/load_error.h"
#include "program.h"

namespace palpa::reader {
namespace {

struct Reader {
  const char* program;
  const char* format;  ///< of those that it knows
};

bool ends_with(std::string_view text, std::string_view end) {
  return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

/// Throws LoadError where there is none.
Reader reader_of(const std::string& path) {
  constexpr Reader dicom{"palpa-read-dicom", "dicom"};
  if (!openfoam_case(path).empty()) return {"palpa-read-cfd", "openfoam"};
  if (std::filesystem::is_directory(path)) return dicom;
  const std::string start = first_bytes(path);
  const std::string_view name = path;
  if (start.size() >= 132 && start.substr(128, 4) == "DICM") return dicom;
  if (start.substr(0, 8) == "\x89HDF\r\n\x1a\n") return {"palpa-read-hdf5", "hdf5"};
  if (ends_with(name, ".h5") || ends_with(name, ".hdf5") || ends_with(name, ".vtkhdf") || ends_with(name, ".hdf")) {
    throw LoadError("is no HDF5 file: it has not its signature; get the whole file, or convert an old HDF4 one (h4toh5)");
  }
  if (start.substr(0, 4) == "NRRD") return {"palpa-read-itk", "nrrd"};
  if (ends_with(name, ".nrrd") || ends_with(name, ".nhdr")) {
    throw LoadError("is no NRRD file: it does not begin with 'NRRD'; give it its right name or export it again");
  }

  const bool nifti_1 = start.size() >= 348 && (start.substr(344, 3) == "n+1" || start.substr(344, 3) == "ni1");
  const bool nifti_2 = start.size() >= 540 && (start.substr(4, 3) == "n+2" || start.substr(4, 3) == "ni2");
  if (nifti_1 || nifti_2) return {"palpa-read-dicom", "nifti"};
  if (ends_with(name, ".nii") || ends_with(name, ".nii.gz")) {
    throw LoadError("is no NIfTI file: its header has no 'n+1' or 'n+2'; export it again");
  }

  if (start.substr(0, 14) == "# vtk DataFile") return {"palpa-read-vtk", "legacy"};
  if (start.find("<VTKFile") != std::string::npos) return {"palpa-read-vtk", "xml"};
  if (ends_with(name, ".vti")) throw LoadError("is no VTI file: it has no '<VTKFile'; export it again");

  const std::string first = first_word(start);
  if (ends_with(name, ".dx") || (first == "object" && start.find("class") != std::string::npos)) {
    throw LoadError(
        "is OpenDX, which is not read; its header says where the numbers are: write a NRRD header for them (data "
        "file, byte skip, sizes with the last index first, space directions), or convert it with numpy");
  }
  if (first == "ObjectType" || first == "NDims" || first == "DimSize" || first == "Comment" || ends_with(name, ".mha") ||
      ends_with(name, ".mhd")) {
    return {"palpa-read-itk", "metaimage"};
  }
  if (plot3d_part(path) != Plot3dPart::unknown) return {"palpa-read-cfd", "plot3d"};
  return dicom;  // whose files need not have a mark
}

void become_reader(int socket) {
  const Reader reader = reader_of(receive_request(socket, false).path);
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe").replace_filename(reader.program);
  ::execl(program.c_str(), reader.program, reader.format, nullptr);
  throw LoadError("cannot be opened: the program " + std::string(reader.program) + " beside palpa-read does not start (" +
                  std::strerror(errno) + "); build or install both anew");
}

}  // namespace
}  // namespace palpa::reader

int main() { return palpa::reader::run_program(palpa::reader::become_reader); }
