// A small case of OpenFOAM, written as text.
#pragma once

#include <string>
#include <vector>

#include "files.h"

namespace palpa::test {

namespace openfoam {

constexpr int nx = 4, ny = 3, nz = 2;
inline Vec3 centre(int i, int j, int k) { return {0.5 * (i + 0.5), 0.5 * (j + 0.5), 0.5 * (k + 0.5)}; }

inline void write_file(const TemporaryFolder& folder, const std::string& name, const std::string& kind,
                       const std::string& body) {
  fs::create_directories((folder.path() / name).parent_path());
  folder.write(name, "FoamFile\n{\n    version 2.0;\n    format ascii;\n    class " + kind + ";\n    object " +
                         fs::path(name).filename().string() + ";\n}\n" + body);
}

inline std::string list(const std::vector<std::string>& items) {
  std::string text = std::to_string(items.size()) + "\n(\n";
  for (const std::string& item : items) text += item + "\n";
  return text + ")\n";
}

}  // namespace openfoam

/// A block of cells of 0.5 m, and at each moment U = t·(x, 2y, 0) and p = t + x at the centres of cells.
inline void write_openfoam_case(const TemporaryFolder& folder) {
  using namespace openfoam;
  std::vector<std::string> points, faces, owner, neighbour;
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        points.push_back("(" + std::to_string(0.5 * i) + " " + std::to_string(0.5 * j) + " " + std::to_string(0.5 * k) + ")");
  const auto point = [](int i, int j, int k) { return std::to_string(i + (nx + 1) * (j + (ny + 1) * k)); };
  const auto cell = [](int i, int j, int k) { return i + nx * (j + ny * k); };
  // The face at the low end (side 0) or high end (1) of a cell along an axis; its normal points out of the cell at the high
  // end.
  const auto face = [&](int axis, int i, int j, int k, int side) {
    const int d[3] = {axis == 0 ? side : 0, axis == 1 ? side : 0, axis == 2 ? side : 0};
    i += d[0], j += d[1], k += d[2];
    std::string corners[4];
    if (axis == 0)
      corners[0] = point(i, j, k), corners[1] = point(i, j + 1, k), corners[2] = point(i, j + 1, k + 1),
      corners[3] = point(i, j, k + 1);
    if (axis == 1)
      corners[0] = point(i, j, k), corners[1] = point(i, j, k + 1), corners[2] = point(i + 1, j, k + 1),
      corners[3] = point(i + 1, j, k);
    if (axis == 2)
      corners[0] = point(i, j, k), corners[1] = point(i + 1, j, k), corners[2] = point(i + 1, j + 1, k),
      corners[3] = point(i, j + 1, k);
    if (side == 0) std::swap(corners[1], corners[3]);
    return "4(" + corners[0] + " " + corners[1] + " " + corners[2] + " " + corners[3] + ")";
  };
  const int last[3] = {nx - 1, ny - 1, nz - 1};
  for (const bool inner : {true, false}) {
    for (int k = 0; k < nz; ++k)
      for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i)
          for (int axis = 0; axis < 3; ++axis) {
            const int at[3] = {i, j, k};
            if (inner && at[axis] < last[axis]) {
              faces.push_back(face(axis, i, j, k, 1));
              owner.push_back(std::to_string(cell(i, j, k)));
              neighbour.push_back(std::to_string(cell(i + (axis == 0), j + (axis == 1), k + (axis == 2))));
            }
            for (const int side : {0, 1}) {
              if (inner || at[axis] != (side == 0 ? 0 : last[axis])) continue;
              faces.push_back(face(axis, i, j, k, side));
              owner.push_back(std::to_string(cell(i, j, k)));
            }
          }
  }
  const std::string mesh = "constant/polyMesh/";
  write_file(folder, mesh + "points", "vectorField", list(points));
  write_file(folder, mesh + "faces", "faceList", list(faces));
  write_file(folder, mesh + "owner", "labelList", list(owner));
  write_file(folder, mesh + "neighbour", "labelList", list(neighbour));
  write_file(folder, mesh + "boundary", "polyBoundaryMesh",
             "1\n(\nwalls\n{\n    type wall;\n    nFaces " + std::to_string(faces.size() - neighbour.size()) +
                 ";\n    startFace " + std::to_string(neighbour.size()) + ";\n}\n)\n");
  write_file(folder, "system/controlDict", "dictionary",
             "application icoFoam;\nstartFrom startTime;\nstartTime 0;\nstopAt endTime;\nendTime 2;\ndeltaT 1;\nwriteControl "
             "timeStep;\nwriteInterval 1;\n");
  for (const int t : {0, 1, 2}) {
    std::vector<std::string> u, p;
    for (int k = 0; k < nz; ++k)
      for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i) {
          const Vec3 x = centre(i, j, k);
          u.push_back("(" + std::to_string(t * x.x) + " " + std::to_string(2 * t * x.y) + " 0)");
          p.push_back(std::to_string(t + x.x));
        }
    const std::string walls = "boundaryField\n{\n    walls\n    {\n        type zeroGradient;\n    }\n}\n";
    write_file(folder, std::to_string(t) + "/U", "volVectorField",
               "dimensions [0 1 -1 0 0 0 0];\ninternalField nonuniform List<vector>\n" + list(u) + ";\n" + walls);
    write_file(folder, std::to_string(t) + "/p", "volScalarField",
               "dimensions [0 2 -2 0 0 0 0];\ninternalField nonuniform List<scalar>\n" + list(p) + ";\n" + walls);
  }
}

}  // namespace palpa::test
