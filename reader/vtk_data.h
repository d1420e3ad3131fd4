// Fields of a volume from VTK data sets of any reader.
#pragma once

#include <vtkDataSet.h>
#include <vtkFieldData.h>
#include <vtkSmartPointer.h>

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "source.h"
#include "vtk_grids.h"

namespace palpa::reader {

/// Source whose fields are VTK arrays on the points and cells of one affine or rectilinear grid.
class GridSource : public Source {
 protected:
  GridSource(const protocol::Request& request, const char* format);

  void set_grids(PointsAndCells grids) { grids_ = std::move(grids); }
  /// Adds a field for an array, or a warning with the reason. Returns true if added.
  bool add(std::string name, int vtk_type, int components, bool of_cells);
  void add_all(vtkDataSet& data);
  /// Refuses a file without fields; requests memory for one copy of them.
  void finish_header();
  /// Copies the wanted arrays out and frees each.
  void copy_out(vtkDataSet& data, const std::vector<std::uint32_t>& wanted, const std::vector<std::byte*>& to);

  struct Array {
    std::string name;
    bool of_cells;
    RawVoxels raw;
    VectorTurn turn;
  };
  std::vector<Array> arrays_;  ///< one per field

 private:
  bool along_index_ = false;  ///< vectors are along the grid's axes
  PointsAndCells grids_;
  std::set<std::string> names_;
};

/// Reason why an array is unusable, half a sentence; empty if usable.
std::string why_left_out(const std::string& name, int vtk_type, int components, RawType& type);

/// Time to read [s]: the requested one, else the latest. Throws LoadError if it is not among them.
/// \param times_s  [s] of the data, rising
double chosen_time(const std::vector<double>& times_s, const std::optional<double>& wanted_s);
/// Warns that the latest of several moments is read.
void warn_of_moments(const std::vector<double>& times_s, std::vector<std::string>& warnings);

/// Source of data sets in memory: on their own grid if that is affine or rectilinear, else resampled.
/// \param unit_of  label of an array's unit by its name
std::unique_ptr<Source> source_of(const protocol::Request& request, const char* format,
                                  std::vector<vtkSmartPointer<vtkDataSet>> blocks, std::vector<std::string> files,
                                  const std::function<std::string(const std::string&)>& unit_of = {});

}  // namespace palpa::reader
