// Small files of VTK's own formats.
#include <array>

#include "sets_to_damage.h"

namespace palpa::test {
namespace {

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

std::string bent_points() {
  std::string text;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 4; ++i)
        text += std::to_string(i + 0.1 * j * j) + " " + std::to_string(j + 0.05 * i * k) + " " + std::to_string(k) + " ";
  return text;
}
std::string points() { return "<Points>" + array("points", bent_points(), 3) + "</Points>"; }

std::string coordinates() {
  return "<Coordinates>" + array("x", text_of_numbers(4, 0.1)) + array("y", text_of_numbers(3, 0.2)) +
         array("z", text_of_numbers(3, 0.3)) + "</Coordinates>";
}

/// Calls act(corners) for each box between the points.
void for_boxes(const std::function<void(const std::array<int, 8>&)>& act) {
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 3; ++i) {
        const int a = i + 4 * (j + 3 * k);
        act({a, a + 1, a + 5, a + 4, a + 12, a + 13, a + 17, a + 16});
      }
}

std::string boxes() {
  std::string corners, ends, types;
  int n = 0;
  for_boxes([&](const std::array<int, 8>& box) {
    for (const int corner : box) corners += std::to_string(corner) + " ";
    ends += std::to_string(8 * ++n) + " ", types += "12 ";
  });
  return "<Cells>" + array("connectivity", corners, 1, "Int64") + array("offsets", ends, 1, "Int64") +
         array("types", types, 1, "UInt8") + "</Cells>";
}

SetToDamage vtk_xml(const std::string& name, const std::string& kind, const std::string& piece) {
  return {name, [=](const TemporaryFolder& folder) { return folder.write(name, xml(kind, piece)); }};
}

/// A grid in one piece, which lies beside the file; `piece`: the piece's content, `all`: the file's description of it.
SetToDamage vtk_in_pieces(const std::string& end, const std::string& kind, const std::string& piece, const std::string& all) {
  return {"pieces.p" + end,
          [=](const TemporaryFolder& folder) {
            const bool cells = kind == "UnstructuredGrid";
            folder.write("piece." + end, xml(kind, piece));
            return folder.write(
                "pieces.p" + end,
                "<VTKFile type=\"P" + kind + "\" version=\"1.0\" byte_order=\"LittleEndian\"><P" + kind + " GhostLevel=\"0\"" +
                    (cells ? "" : " WholeExtent=\"0 3 0 2 0 2\" Spacing=\"0.5 0.5 0.5\"") +
                    "><PPointData><PDataArray type=\"Float64\" Name=\"p\"/></PPointData>" + all + "<Piece " +
                    (cells ? "" : "Extent=\"0 3 0 2 0 2\" ") + "Source=\"piece." + end + "\"/></P" + kind + "></VTKFile>");
          },
          {"piece." + end}};
}

SetToDamage legacy_vtk(const std::string& name, const std::string& grid) {
  return {name, [=](const TemporaryFolder& folder) {
            return folder.write(name, "# vtk DataFile Version 3.0\nmade\nASCII\nDATASET " + grid +
                                          "\nPOINT_DATA 36\nSCALARS p "
                                          "double 1\nLOOKUP_TABLE default\n" +
                                          text_of_numbers(36, 0.5) + "\n");
          }};
}

std::string legacy_cells() {
  std::string cells, types;
  for_boxes([&](const std::array<int, 8>& corners) {
    cells += "8 ";
    for (const int corner : corners) cells += std::to_string(corner) + " ";
    types += "12 ";
  });
  return "CELLS 12 108\n" + cells + "\nCELL_TYPES 12\n" + types;
}

}  // namespace

std::vector<SetToDamage> vtk_sets_to_damage() {
  const std::string points_of_pieces = "<PPoints><PDataArray type=\"Float64\" NumberOfComponents=\"3\"/></PPoints>";
  const std::string number = "<PDataArray type=\"Float64\"/>";
  return {
      vtk_xml("planes.vtr", "RectilinearGrid", coordinates()),
      vtk_xml("bent.vts", "StructuredGrid", points()),
      vtk_xml("cells.vtu", "UnstructuredGrid", points() + boxes()),
      vtk_in_pieces("vti", "ImageData", "", ""),
      vtk_in_pieces("vtr", "RectilinearGrid", coordinates(), "<PCoordinates>" + number + number + number + "</PCoordinates>"),
      vtk_in_pieces("vts", "StructuredGrid", points(), points_of_pieces),
      vtk_in_pieces("vtu", "UnstructuredGrid", points() + boxes(), points_of_pieces),
      legacy_vtk("image.vtk", "STRUCTURED_POINTS\nDIMENSIONS 4 3 3\nORIGIN 0 0 0\nSPACING 1 2 3"),
      legacy_vtk("planes.vtk", "RECTILINEAR_GRID\nDIMENSIONS 4 3 3\nX_COORDINATES 4 double\n" + text_of_numbers(4, 0.1) +
                                   "\nY_COORDINATES 3 double\n" + text_of_numbers(3, 0.2) + "\nZ_COORDINATES 3 double\n" +
                                   text_of_numbers(3, 0.3)),
      legacy_vtk("bent.vtk", "STRUCTURED_GRID\nDIMENSIONS 4 3 3\nPOINTS 36 double\n" + bent_points()),
      legacy_vtk("cells.vtk", "UNSTRUCTURED_GRID\nPOINTS 36 double\n" + bent_points() + "\n" + legacy_cells())};
}

}  // namespace palpa::test
