#include "vtk_blocks.h"

#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLUtilities.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "data_file.h"
#include "library_words.h"
#include "messages.h"
#include "palpa/base/load_error.h"
#include "source.h"
#include "vtk_data.h"

namespace palpa::reader {
namespace {

namespace fs = std::filesystem;

// Limits of an index. Larger: a damaged one can cost more time and memory; smaller: large cases are refused.
constexpr std::uint64_t most_bytes = 10'000'000;
constexpr std::size_t most_files = 10'000;

struct Named {
  std::string file;
  std::optional<double> time_s;
};

void collect(vtkXMLDataElement& element, const fs::path& folder, std::vector<Named>& found) {
  if (const char* file = element.GetAttribute("file"); file != nullptr && *file != '\0') {
    if (found.size() >= most_files)
      throw LoadError("names more than " + std::to_string(most_files) + " files; give a part of them");
    Named named{(folder / file).string(), {}};
    double time_s = 0.0;
    if (element.GetScalarAttribute("timestep", time_s) != 0) named.time_s = time_s;
    found.push_back(std::move(named));
  }
  for (int n = 0; n < element.GetNumberOfNestedElements(); ++n) collect(*element.GetNestedElement(n), folder, found);
}

}  // namespace

bool is_vtk_index(const std::string& type) {
  static const std::set<std::string> types{"vtkMultiBlockDataSet", "Collection", "vtkPartitionedDataSet",
                                           "vtkPartitionedDataSetCollection"};
  return types.count(type) > 0;
}

VtkIndex read_vtk_index(const std::string& path, const std::optional<double>& time_s) {
  check_not_unpacked(path);
  if (file_bytes(path) > most_bytes) throw LoadError("is too large for a list of files; give one of the files that it names");
  const auto root = vtkSmartPointer<vtkXMLDataElement>::Take(vtkXMLUtilities::ReadElementFromFile(path.c_str()));
  if (library_complained() || root == nullptr)
    throw LoadError("cannot be read as VTK's XML (" + take_library_error() + "); check that the file is whole");
  std::vector<Named> found;
  collect(*root, fs::path(path).parent_path(), found);
  if (found.empty()) throw LoadError("names no file; save it again, with its data");
  VtkIndex index;
  for (const Named& named : found) {
    if (named.time_s) index.times_s.push_back(*named.time_s);
  }
  std::ranges::sort(index.times_s);
  index.times_s.erase(std::unique(index.times_s.begin(), index.times_s.end()), index.times_s.end());
  if (!index.times_s.empty()) index.time_s = chosen_time(index.times_s, time_s);
  if (index.times_s.empty() && time_s) throw LoadError("has no moments to choose from; leave 'time' out");
  for (const Named& named : found) {
    if (named.time_s.value_or(index.time_s) != index.time_s) continue;
    check_data_file(path, named.file);
    index.files.push_back(named.file);
  }
  return index;
}

}  // namespace palpa::reader
