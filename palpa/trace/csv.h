// CSV of traces: a line per row, numbers that parse to equal values, quotes only where needed.
#pragma once

#include <charconv>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/base/input_file.h"

namespace palpa::detail {

/// Appends `value` as the shortest decimal that parses to an equal value. Every NaN is "nan": its sign bit depends on the
/// compiler's constant folding.
template <class Number>
requires std::integral<Number> || std::floating_point<Number>
void put_number(std::string& line, Number value) {
  if constexpr (std::floating_point<Number>) {
    if (std::isnan(value)) {
      line += "nan";
      return;
    }
  }
  char digits[32];
  line.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

/// Parses a whole cell as a number; false if invalid.
template <class Number>
requires std::integral<Number> || std::floating_point<Number>
bool take_number(std::string_view cell, Number& value) {
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc{} && end == cell.data() + cell.size();
}

/// Appends a text as a cell: quoted if it has a comma or a quote; control characters, which would end the line, become spaces.
void put_text(std::string& line, std::string_view text);

/// Splits a line at its commas, except those in quotes. The cells point into `line`, quotes included.
void split(std::string_view line, std::vector<std::string_view>& cells);

/// Whole lines of a text file, in order. Text after the last line end is ignored: a killed writer may have left half a line
/// there.
class LineFile {
 public:
  /// A missing file has no lines. Throws LoadError if it is no regular file or cannot be read.
  explicit LineFile(std::filesystem::path path);

  bool exists() const noexcept { return file_.why_not() != NoInput::missing; }
  /// Next line without its end, valid until the next call; false after the last. Throws LoadError if the file cannot be read or
  /// a line is longer than any of a trace.
  bool next(std::string_view& line);
  /// Number of the last line from `next`, from 1.
  std::int64_t number() const noexcept { return number_; }
  /// "FILE:LINE" of that line, for messages.
  std::string place() const;

 private:
  InputFile file_;
  std::uint64_t read_ = 0;  ///< [bytes] read from it
  std::string buffer_;
  std::size_t begin_ = 0;
  std::int64_t number_ = 0;
};

}  // namespace palpa::detail
