// CSV as traces use it: one line per row, numbers that read back the same, no quotes unless needed.
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

/// Appends `value` as the shortest decimal that reads back the same. Every NaN is "nan": its sign bit
/// depends on how the compiler folded the operation that made it.
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

/// Reads a whole cell as a number; false when it is none.
template <class Number>
requires std::integral<Number> || std::floating_point<Number>
bool take_number(std::string_view cell, Number& value) {
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc{} && end == cell.data() + cell.size();
}

/// Appends a text as one cell: in quotes where it holds a comma or a quote; control characters, which
/// would end the line, become spaces.
void put_text(std::string& line, std::string_view text);

/// Splits a line at its commas, not at those in quotes. The cells point into `line`, quotes and all.
void split(std::string_view line, std::vector<std::string_view>& cells);

/// The whole lines of a text file, one at a time. What follows the last line end is ignored: a writer that was killed may have
/// left half a line there.
class LineFile {
 public:
  /// A file that is not there has no lines. Throws LoadError where it is no ordinary file or cannot be read.
  explicit LineFile(std::filesystem::path path);

  bool exists() const noexcept { return file_.why_not() != NoInput::missing; }
  /// The next line without its end, valid until the next call; false after the last. Throws LoadError
  /// where the file cannot be read or a line is longer than any of a trace.
  bool next(std::string_view& line);
  /// Number of the line that `next` gave last, counted from 1.
  std::int64_t number() const noexcept { return number_; }
  /// "FILE:LINE" of that line, for messages.
  std::string place() const;

 private:
  InputFile file_;
  std::uint64_t read_ = 0;  ///< [bytes] of it
  std::string buffer_;
  std::size_t begin_ = 0;
  std::int64_t number_ = 0;
};

}  // namespace palpa::detail
