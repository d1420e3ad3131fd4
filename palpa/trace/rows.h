// Rows of a trace's files, by column names.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/solver/vec3.h"
#include "palpa/trace/csv.h"
#include "palpa/trace/trace.h"

namespace palpa::detail {

/// Row of a trace's file: the cells of the requested columns.
class Row {
 public:
  Row(const LineFile& file, const std::vector<std::string>& names, std::span<const std::string_view> cells)
      : file_(file), names_(names), cells_(cells) {}

  template <class Number>
  Number number(std::size_t column) const {
    Number value{};
    if (!take_number(cells_[column], value)) refuse(column);
    return value;
  }
  Vec3 vector(std::size_t column) const {
    return {number<double>(column), number<double>(column + 1), number<double>(column + 2)};
  }
  /// Text without its quotes.
  std::string text(std::size_t column) const;
  [[noreturn]] void refuse(std::size_t column) const;

 private:
  const LineFile& file_;
  const std::vector<std::string>& names_;
  std::span<const std::string_view> cells_;
};

/// Calls `use` with every whole row until it returns false; a missing file has none. Throws LoadError with file and line on a
/// missing column, and on rows of another length.
void each_row(const std::filesystem::path& path, const std::vector<std::string>& names,
              const std::function<bool(const Row&)>& use);

}  // namespace palpa::detail
