#include "stand_ins.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkRectilinearGrid.h>

#include <cctype>
#include <cstdint>
#include <limits>
#include <sstream>
#include <string_view>

#include "palpa/base/input_file.h"

namespace palpa::reader {
namespace {

/// Near the largest of single precision, far above measurements, with digits that are unlikely by chance.
constexpr const char *nan_text = "3.0183746e38", *infinity_text = "3.0271828e38";
constexpr double nan_stand_in = 3.0183746e38, infinity_stand_in = 3.0271828e38;

enum class Word : std::uint8_t { number, not_a_number, infinity, other };

Word kind_of(std::string_view word) {
  if (!word.empty() && (word.front() == '-' || word.front() == '+')) word.remove_prefix(1);
  if (word.empty()) return Word::other;
  if (word.starts_with("1.#")) return word.starts_with("1.#INF") ? Word::infinity : Word::not_a_number;  // older Windows
  if (std::isdigit(static_cast<unsigned char>(word.front())) != 0 || word.front() == '.') return Word::number;
  std::string small(word);
  for (char& c : small) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (small == "inf" || small == "infinity") return Word::infinity;
  return small == "nan" || (small.starts_with("nan(") && small.ends_with(")")) ? Word::not_a_number : Word::other;
}

/// Line with stand-ins; false if it has none, or other words than numbers.
bool replace_in(const std::string& line, std::string& with) {
  std::istringstream words(line);
  bool any = false;
  with.clear();
  for (std::string word; words >> word;) {
    const Word kind = kind_of(word);
    if (kind == Word::other) return false;
    any = any || kind != Word::number;
    with += kind == Word::number         ? word
            : kind == Word::not_a_number ? nan_text
                                         : (word.front() == '-' ? "-" : "") + std::string(infinity_text);
    with += ' ';
  }
  return any;
}

template <class Array>
void put_back(Array* array) {
  using Number = typename Array::ValueType;
  constexpr auto nan = static_cast<Number>(nan_stand_in), infinity = static_cast<Number>(infinity_stand_in);
  if (array == nullptr) return;
  Number* const numbers = array->GetPointer(0);
  for (vtkIdType n = 0; n < array->GetNumberOfValues(); ++n) {
    if (numbers[n] == nan) numbers[n] = std::numeric_limits<Number>::quiet_NaN();
    if (numbers[n] == infinity) numbers[n] = std::numeric_limits<Number>::infinity();
    if (numbers[n] == -infinity) numbers[n] = -std::numeric_limits<Number>::infinity();
  }
}

void put_back_in(vtkAbstractArray* array) {
  put_back(vtkFloatArray::SafeDownCast(array));
  put_back(vtkDoubleArray::SafeDownCast(array));
}

}  // namespace

std::optional<std::string> with_stand_ins(const std::string& path) {
  detail::InputStream file(path);
  if (file.file().bytes() > static_cast<std::uint64_t>(std::numeric_limits<int>::max() / 2)) return std::nullopt;
  std::string text, line, changed;
  bool any = false;
  for (int n = 0; std::getline(file, line); ++n) {
    if (n == 2 && line.find("ASCII") == std::string::npos && line.find("ascii") == std::string::npos) return std::nullopt;
    const bool here = n > 2 && replace_in(line, changed);
    any = any || here;
    text += here ? changed : line;
    text += '\n';
  }
  if (!any) return std::nullopt;
  return text;
}

void put_back_not_finite(vtkDataSet& data) {
  for (vtkFieldData* arrays :
       {static_cast<vtkFieldData*>(data.GetPointData()), static_cast<vtkFieldData*>(data.GetCellData())}) {
    for (int a = 0; a < arrays->GetNumberOfArrays(); ++a) put_back_in(arrays->GetAbstractArray(a));
  }
  if (auto* points = vtkPointSet::SafeDownCast(&data); points != nullptr && points->GetPoints() != nullptr)
    put_back_in(points->GetPoints()->GetData());
  if (auto* planes = vtkRectilinearGrid::SafeDownCast(&data)) {
    for (vtkDataArray* along : {planes->GetXCoordinates(), planes->GetYCoordinates(), planes->GetZCoordinates()})
      put_back_in(along);
  }
}

}  // namespace palpa::reader
