// Numbers as text, in the spellings of many languages and systems.
#pragma once

#include <charconv>
#include <cstdlib>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace palpa::reader {

/// Value of a whole word: also "nan", "inf" and "infinity" in any case and with a sign, "1.#INF" and "-1.#IND" of older
/// Windows; infinite on overflow. None for any other word ("1,5", "1d3", "--").
inline std::optional<double> text_number(std::string_view word) {
  const bool negative = word.starts_with("-");
  if (negative || word.starts_with("+")) word.remove_prefix(1);
  const double sign = negative ? -1.0 : 1.0;
  if (word.starts_with("-") || word.starts_with("+")) return std::nullopt;
  if (word.starts_with("1.#INF")) return sign * std::numeric_limits<double>::infinity();
  if (word.starts_with("1.#")) return std::numeric_limits<double>::quiet_NaN();
  double number = 0.0;
  const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (word.empty() || end != word.data() + word.size()) return std::nullopt;
  if (problem == std::errc::result_out_of_range) number = std::strtod(std::string(word).c_str(), nullptr);
  return sign * number;
}

}  // namespace palpa::reader
