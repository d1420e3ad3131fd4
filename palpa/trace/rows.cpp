#include "palpa/trace/rows.h"

#include <algorithm>

#include "palpa/base/load_error.h"
#include "palpa/base/wording.h"

namespace palpa::detail {

std::string Row::text(std::size_t column) const {
  std::string_view cell = cells_[column];
  if (cell.size() < 2 || cell.front() != '"' || cell.back() != '"') return std::string(cell);
  cell = cell.substr(1, cell.size() - 2);
  std::string plain;
  for (std::size_t i = 0; i < cell.size(); ++i) {
    plain += cell[i];
    if (cell[i] == '"' && i + 1 < cell.size() && cell[i + 1] == '"') ++i;
  }
  return plain;
}

void Row::refuse(std::size_t column) const {
  throw LoadError(file_.place() + ": column '" + names_[column] + "' cannot be " + in_quotes(cells_[column]) +
                  "; docs/trace.md says what it holds");
}

void each_row(const std::filesystem::path& path, const std::vector<std::string>& names,
              const std::function<bool(const Row&)>& use) {
  LineFile file(path);
  std::string_view line;
  if (!file.next(line)) return;
  std::vector<std::string_view> cells;
  split(line, cells);
  const std::size_t width = cells.size();
  std::vector<std::size_t> at;
  for (const std::string& name : names) {
    const auto found = std::find(cells.begin(), cells.end(), name);
    if (found == cells.end()) {
      throw LoadError(file.place() + ": column '" + name + "' is missing; a trace has all columns of docs/trace.md");
    }
    at.push_back(static_cast<std::size_t>(found - cells.begin()));
  }
  std::vector<std::string_view> own(names.size());
  while (file.next(line)) {
    split(line, cells);
    if (cells.size() != width) {
      throw LoadError(file.place() + ": has " + std::to_string(cells.size()) + " cells; the header has " +
                      std::to_string(width));
    }
    for (std::size_t i = 0; i < at.size(); ++i) own[i] = cells[at[i]];
    if (!use(Row(file, names, own))) return;
  }
}

}  // namespace palpa::detail
