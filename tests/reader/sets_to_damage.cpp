#include "sets_to_damage.h"

#include "data_sets.h"
#include "dicom_file.h"
#include "hdf5_file.h"
#include "openfoam_case.h"

namespace palpa::test {
namespace {

const FileGrid grid{{6, 5, 4}, {{{0.5, 0, 0}, {0, 0.25, 0}, {0, 0, 2}}}, {1, 2, 3}};

std::string numbers_of(const FileGrid& of = grid) {
  return linear_voxels<double>(of, [](const Vec3& p) { return p; });
}

SetToDamage dicom(const std::string& name, gdcm::TransferSyntax::TSType syntax, bool whole_folder) {
  return {name, [=](const TemporaryFolder& folder) {
            DicomSeries series;
            series.columns = 40, series.rows = 32;
            for (int n = 0; n < 5; ++n) {
              const fs::path file =
                  folder.write("i" + std::to_string(n), series.file(series.image(series.at_mm({0, 0, double(n)}), n)));
              if (syntax != gdcm::TransferSyntax::ExplicitVRLittleEndian) compress_dicom(file, syntax);
            }
            return whole_folder ? folder.path() : folder.path() / "i0";
          }};
}

SetToDamage hdf5_array() {
  VolumeRequest request;
  request.layout.spacing_m = {0.5, 0.25, 2};
  return {"array.h5",
          [](const TemporaryFolder& folder) {
            const fs::path path = folder.path() / "array.h5";
            const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
            write_array<double>(file, "/flow/p", {4, 5, 6}, numbers_of(), true);
            H5Fclose(file);
            return path;
          },
          {},
          request};
}

SetToDamage hdf5_image() {
  return {"image.vtkhdf", [](const TemporaryFolder& folder) {
            const fs::path path = folder.path() / "image.vtkhdf";
            const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
            write_array<double>(file, "/VTKHDF/PointData/p", {4, 5, 6}, numbers_of());
            const hid_t root = H5Gopen2(file, "VTKHDF", H5P_DEFAULT);
            write_text(root, "Type", "ImageData");
            write_numbers(root, "WholeExtent", {0, 5, 0, 4, 0, 3});
            H5Gclose(root), H5Fclose(file);
            return path;
          }};
}

SetToDamage raw() {
  VolumeRequest request;
  request.layout = {.type = "float64", .header_bytes = 8, .dims = {6, 5, 4}, .spacing_m = {0.5, 0.25, 2}};
  return {"numbers.raw",
          [](const TemporaryFolder& folder) { return folder.write("numbers.raw", "12345678" + numbers_of()); },
          {},
          request};
}

std::string text_of_numbers(std::size_t count, double step) {
  std::string text;
  for (std::size_t n = 0; n < count; ++n) text += std::to_string(step * static_cast<double>(n * n + n)) + " ";
  return text;
}

std::string array(const std::string& name, const std::string& numbers, int components = 1,
                  const std::string& type = "Float64") {
  return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" + std::to_string(components) +
         "\" format=\"ascii\">" + numbers + "</DataArray>";
}

/// A file of VTK's XML with this piece, for 4 × 3 × 3 points.
std::string xml(const std::string& kind, const std::string& piece) {
  const bool cells = kind == "UnstructuredGrid";
  const std::string extent = "0 3 0 2 0 2";
  return "<VTKFile type=\"" + kind + "\" version=\"1.0\" byte_order=\"LittleEndian\"><" + kind +
         (cells ? "><Piece NumberOfPoints=\"36\" NumberOfCells=\"12\">"
                : " WholeExtent=\"" + extent + "\"><Piece Extent=\"" + extent + "\">") +
         piece + "<PointData>" + array("p", text_of_numbers(36, 0.5)) + "</PointData></Piece></" + kind + "></VTKFile>";
}

/// Points of a bent grid.
std::string points() {
  std::string text;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 4; ++i)
        text += std::to_string(i + 0.1 * j * j) + " " + std::to_string(j + 0.05 * i * k) + " " + std::to_string(k) + " ";
  return "<Points>" + array("points", text, 3) + "</Points>";
}

std::string boxes() {
  std::string corners, ends, types;
  for (int k = 0, n = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 3; ++i) {
        const int a = i + 4 * (j + 3 * k);
        for (const int p : {a, a + 1, a + 5, a + 4, a + 12, a + 13, a + 17, a + 16}) corners += std::to_string(p) + " ";
        ends += std::to_string(8 * ++n) + " ", types += "12 ";
      }
  return "<Cells>" + array("connectivity", corners, 1, "Int64") + array("offsets", ends, 1, "Int64") +
         array("types", types, 1, "UInt8") + "</Cells>";
}

SetToDamage vtk_xml(const std::string& name, const std::string& kind, const std::string& piece) {
  return {name, [=](const TemporaryFolder& folder) { return folder.write(name, xml(kind, piece)); }};
}

/// A grid in one piece, which lies beside the file.
SetToDamage vtk_in_pieces() {
  return {"pieces.pvtu",
          [](const TemporaryFolder& folder) {
            folder.write("piece.vtu", xml("UnstructuredGrid", points() + boxes()));
            return folder.write(
                "pieces.pvtu",
                "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\"><PUnstructuredGrid "
                "GhostLevel=\"0\"><PPointData><PDataArray type=\"Float64\" Name=\"p\"/></PPointData><PPoints>"
                "<PDataArray type=\"Float64\" NumberOfComponents=\"3\"/></PPoints><Piece Source=\"piece.vtu\"/>"
                "</PUnstructuredGrid></VTKFile>");
          },
          {"piece.vtu"}};
}

}  // namespace

std::vector<SetToDamage> sets_to_damage(const fs::path& data_folder) {
  std::vector<SetToDamage> sets;
  for (const std::vector<DataSet>& kind : {data_sets(), refused_sets()}) {
    for (const DataSet& set : kind) {
      sets.push_back({set.file, [file = data_folder / set.file](const TemporaryFolder&) { return file; }, set.with});
    }
  }
  using Syntax = gdcm::TransferSyntax;
  for (const bool folder : {false, true}) {
    const std::string what = folder ? "dicom_folder_" : "dicom_";
    sets.push_back(dicom(what + "plain", Syntax::ExplicitVRLittleEndian, folder));
    sets.push_back(dicom(what + "jpeg", Syntax::JPEGLosslessProcess14_1, folder));
    sets.push_back(dicom(what + "jpeg_ls", Syntax::JPEGLSLossless, folder));
    sets.push_back(dicom(what + "jpeg_2000", Syntax::JPEG2000Lossless, folder));
    sets.push_back(dicom(what + "rle", Syntax::RLELossless, folder));
  }
  sets.push_back({"openfoam", [](const TemporaryFolder& folder) {
                    write_openfoam_case(folder);
                    return folder.path();
                  }});
  sets.push_back(hdf5_array());
  sets.push_back(hdf5_image());
  sets.push_back(raw());
  sets.push_back(vtk_xml("planes.vtr", "RectilinearGrid",
                         "<Coordinates>" + array("x", text_of_numbers(4, 0.1)) + array("y", text_of_numbers(3, 0.2)) +
                             array("z", text_of_numbers(3, 0.3)) + "</Coordinates>"));
  sets.push_back(vtk_xml("bent.vts", "StructuredGrid", points()));
  sets.push_back(vtk_xml("cells.vtu", "UnstructuredGrid", points() + boxes()));
  sets.push_back(vtk_in_pieces());
  return sets;
}

}  // namespace palpa::test
