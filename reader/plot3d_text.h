// PLOT3D as Fortran text ("formatted"): numbers separated by blanks.
#pragma once

#include <vtkDataSet.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

namespace palpa::reader {

/// True if the file begins like numbers as text.
bool is_plot3d_text(const std::string& path);

/// Blocks of a grid and its solution, with the arrays Density, Momentum and StagnationEnergy; points with IBLANK 0 are hidden.
/// Throws LoadError if their counts do not match.
std::vector<vtkSmartPointer<vtkDataSet>> read_plot3d_text(const std::string& grid, const std::string& solution);

}  // namespace palpa::reader
