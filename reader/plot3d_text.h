// PLOT3D as text, as Fortran writes it ("formatted"): numbers with blanks between them.
#pragma once

#include <vtkDataSet.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

namespace palpa::reader {

/// Whether the first bytes of a file are those of numbers as text.
bool is_plot3d_text(const std::string& path);

/// The blocks of a grid and its solution, with the arrays Density, Momentum and StagnationEnergy; points with IBLANK 0 are
/// hidden. Throws LoadError where the counts in them do not fit.
std::vector<vtkSmartPointer<vtkDataSet>> read_plot3d_text(const std::string& grid, const std::string& solution);

}  // namespace palpa::reader
