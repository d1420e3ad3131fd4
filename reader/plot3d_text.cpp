#include "plot3d_text.h"

#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStructuredGrid.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

#include "first_bytes.h"
#include "palpa/base/input_file.h"
#include "palpa/base/load_error.h"
#include "source.h"

namespace palpa::reader {
namespace {

using Dims = std::array<std::int64_t, 3>;

/// All numbers of a text: separated by blanks or commas, with exponents of E or D, "3*1.5" for three of them.
std::vector<double> numbers_in(const std::string& path) {
  std::vector<double> numbers;
  detail::InputStream text(path);
  const auto most = static_cast<std::size_t>(text.file().bytes());  // repeats may exceed it, but not in a flow
  std::string word;
  const auto take = [&] {
    for (char& c : word) c = c == 'd' || c == 'D' ? 'e' : c;
    std::size_t count = 1, at = 0;
    const char* const end = word.data() + word.size();
    if (const std::size_t star = word.find('*'); star != std::string::npos) {
      const auto [last, error] = std::from_chars(word.data(), word.data() + star, count);
      if (error != std::errc() || last != word.data() + star) count = SIZE_MAX;
      at = star + 1;
    }
    if (at < word.size() && word[at] == '+') ++at;
    double number = 0.0;
    const auto [last, error] = std::from_chars(word.data() + at, end, number);
    if (error != std::errc() || last != end)
      throw LoadError("has a word that is no number behind " + std::to_string(numbers.size()) + " numbers; export it again");
    if (count > most || numbers.size() + count > most)
      throw LoadError("repeats a number more often than its size allows; export it again");
    numbers.insert(numbers.end(), count, number);
    word.clear();
  };
  constexpr std::size_t longest = 100;
  for (char c = 0; text.get(c);) {
    const bool between = std::isspace(static_cast<unsigned char>(c)) != 0 || c == ',';
    if (!between) word += c;
    if ((between && !word.empty()) || word.size() > longest) take();
  }
  if (!word.empty()) take();
  return numbers;
}

/// Dimensions of the blocks at the start of these numbers, and the index behind them; empty if there are none.
std::vector<Dims> dims_in(const std::vector<double>& numbers, bool counted, std::size_t& end) {
  constexpr double most = 1e9;
  const auto count_at = [&](std::size_t at) {
    const double n = at < numbers.size() ? numbers[at] : 0.0;
    return n >= 1.0 && n <= most && n == std::floor(n) ? static_cast<std::int64_t>(n) : 0;
  };
  const std::int64_t blocks = counted ? count_at(0) : 1;
  std::vector<Dims> all;
  end = counted ? 1 : 0;
  for (std::int64_t b = 0; b < blocks && static_cast<std::size_t>(b) < numbers.size(); ++b) {
    Dims dims{};
    for (std::int64_t& n : dims) n = count_at(end++);
    if (dims[0] * dims[1] == 0 || dims[2] == 0) return {};
    all.push_back(dims);
  }
  return all;
}

double points_in(const Dims& dims) {
  return static_cast<double>(dims[0]) * static_cast<double>(dims[1]) * static_cast<double>(dims[2]);
}

struct Layout {
  std::vector<Dims> blocks;
  std::size_t first = 0;  ///< index of the first coordinate
  bool counted = false;   ///< the file begins with its number of blocks
  bool blanks = false;    ///< IBLANK follows the coordinates of each block
};

/// Only grid layout with this count of numbers. Throws LoadError.
Layout layout_of(const std::vector<double>& numbers) {
  for (const bool counted : {false, true}) {
    Layout layout;
    layout.counted = counted;
    layout.blocks = dims_in(numbers, counted, layout.first);
    if (layout.blocks.empty()) continue;
    double points = 0;
    for (const Dims& dims : layout.blocks) points += points_in(dims);
    for (const bool blanks : {false, true}) {
      layout.blanks = blanks;
      if (static_cast<double>(layout.first) + (blanks ? 4.0 : 3.0) * points == static_cast<double>(numbers.size()))
        return layout;
    }
  }
  throw LoadError("is PLOT3D as text, whose " + std::to_string(numbers.size()) +
                  " numbers are not as many as those of a grid in three dimensions that it begins with; get the whole file");
}

vtkSmartPointer<vtkStructuredGrid> grid_of(const Dims& dims, const double* at, bool blanks) {
  auto grid = vtkSmartPointer<vtkStructuredGrid>::New();
  grid->SetDimensions(static_cast<int>(dims[0]), static_cast<int>(dims[1]), static_cast<int>(dims[2]));
  const auto count = static_cast<vtkIdType>(points_in(dims));
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(count);
  for (vtkIdType p = 0; p < count; ++p) points->SetPoint(p, at[p], at[count + p], at[2 * count + p]);
  grid->SetPoints(points);
  for (vtkIdType p = 0; blanks && p < count; ++p) {
    if (at[3 * count + p] == 0.0) grid->BlankPoint(p);
  }
  return grid;
}

void add_solution(vtkStructuredGrid& grid, const double* at) {
  const vtkIdType count = grid.GetNumberOfPoints();
  vtkNew<vtkFloatArray> density, momentum, energy;
  density->SetName("Density"), momentum->SetName("Momentum"), energy->SetName("StagnationEnergy");
  momentum->SetNumberOfComponents(3);
  for (vtkFloatArray* array : {density.Get(), momentum.Get(), energy.Get()}) array->SetNumberOfTuples(count);
  for (vtkIdType p = 0; p < count; ++p) {
    density->SetComponent(p, 0, at[p]);
    for (int c = 0; c < 3; ++c) momentum->SetComponent(p, c, at[(1 + c) * count + p]);
    energy->SetComponent(p, 0, at[4 * count + p]);
  }
  for (vtkFloatArray* array : {density.Get(), momentum.Get(), energy.Get()}) grid.GetPointData()->AddArray(array);
}

}  // namespace

bool is_plot3d_text(const std::string& path) {
  const std::string start = first_bytes(path);
  return start.find_first_not_of("0123456789+-.eEdD*nNaAiIfF, \t\r\n") == std::string::npos;
}

std::vector<vtkSmartPointer<vtkDataSet>> read_plot3d_text(const std::string& grid, const std::string& solution) {
  constexpr std::size_t of_block = 4, of_point = 5;  // numbers: Mach number, angle, Reynolds number, time; density and so on
  const std::vector<double> xyz = numbers_in(grid);
  const Layout layout = layout_of(xyz);
  const std::vector<double> q = numbers_in(solution);
  std::size_t at_q = 0;
  const bool fits = dims_in(q, layout.counted, at_q) == layout.blocks;
  double points = 0;
  for (const Dims& dims : layout.blocks) points += points_in(dims);
  const double needed = static_cast<double>(at_q) + static_cast<double>(of_block * layout.blocks.size()) + of_point * points;
  if (!fits || needed != static_cast<double>(q.size()))
    throw LoadError(
        "is PLOT3D as text, and its solution does not have the numbers of a solution on this grid; check that they belong "
        "together, and are whole");
  std::vector<vtkSmartPointer<vtkDataSet>> blocks;
  std::size_t at_xyz = layout.first;
  for (const Dims& dims : layout.blocks) {
    const vtkSmartPointer<vtkStructuredGrid> block = grid_of(dims, xyz.data() + at_xyz, layout.blanks);
    const auto count = static_cast<std::size_t>(points_in(dims));
    add_solution(*block, q.data() + at_q + of_block);
    at_xyz += (layout.blanks ? 4 : 3) * count, at_q += of_block + of_point * count;
    blocks.emplace_back(block);
  }
  return blocks;
}

}  // namespace palpa::reader
