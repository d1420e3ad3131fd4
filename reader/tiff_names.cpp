#include "tiff_names.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <string_view>

namespace palpa::reader {
namespace {

namespace fs = std::filesystem;

bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }

/// Part of a name: all digits, or none.
std::string_view next_part(std::string_view& text) noexcept {
  std::size_t end = 1;
  while (end < text.size() && is_digit(text[end]) == is_digit(text[0])) ++end;
  const std::string_view part = text.substr(0, end);
  text.remove_prefix(end);
  return part;
}

std::string_view without_zeros(std::string_view digits) noexcept {
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size() - 1));
  return digits;
}

/// A name's letters with '#' for its numbers, and these.
struct NumberedName {
  std::string pattern;
  std::vector<std::int64_t> numbers;  ///< −1: more digits than a number of 64 bits has
};

NumberedName numbered(std::string_view name) {
  NumberedName result;
  while (!name.empty()) {
    const std::string_view part = next_part(name);
    if (!is_digit(part[0])) {
      result.pattern += part;
      continue;
    }
    std::int64_t number = -1;
    const auto read = std::from_chars(part.data(), part.data() + part.size(), number);
    result.numbers.push_back(read.ec == std::errc{} ? number : -1);
    result.pattern += '#';
  }
  return result;
}

/// Index of the only number that differs from name to name; SIZE_MAX: none, or several.
std::size_t counting_number(const std::vector<NumberedName>& names) {
  std::size_t counting = SIZE_MAX;
  for (std::size_t n = 0; n < names.front().numbers.size(); ++n) {
    const auto is_same = [&](const NumberedName& name) { return name.numbers[n] == names.front().numbers[n]; };
    if (std::ranges::all_of(names, is_same)) continue;
    if (counting != SIZE_MAX) return SIZE_MAX;
    counting = n;
  }
  return counting;
}

constexpr std::size_t most_gaps_named = 3;  // More: long lines; fewer: the pattern is hidden

}  // namespace

bool is_tiff_name(const std::string& name) noexcept {
  const auto ends = [&](std::string_view ending) {
    return name.size() > ending.size() && std::equal(ending.rbegin(), ending.rend(), name.rbegin(), [](char a, char b) {
             return a == (b >= 'A' && b <= 'Z' ? static_cast<char>(b - 'A' + 'a') : b);
           });
  };
  return ends(".tif") || ends(".tiff");
}

bool is_tiff_folder(const std::string& path) {
  std::int64_t tiff = 0, others = 0;
  std::error_code problem;
  for (fs::directory_iterator entry(path, problem), end; !problem && entry != end; entry.increment(problem)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with(".")) continue;
    ++(is_tiff_name(name) ? tiff : others);
  }
  return tiff > others;
}

bool naturally_before(const std::string& a, const std::string& b) noexcept {
  std::string_view left = a, right = b;
  while (!left.empty() && !right.empty()) {
    const std::string_view one = next_part(left), other = next_part(right);
    if (!is_digit(one[0]) || !is_digit(other[0])) {
      if (one != other) return one < other;
      continue;
    }
    const std::string_view first = without_zeros(one), second = without_zeros(other);
    if (first != second) return first.size() != second.size() ? first.size() < second.size() : first < second;
  }
  if (left.empty() != right.empty()) return left.empty();
  return a < b;
}

std::vector<std::string> tiff_names_in(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code problem;
  for (fs::directory_iterator entry(folder, problem), end; !problem && entry != end; entry.increment(problem)) {
    std::string name = entry->path().filename().string();
    if (is_tiff_name(name) && !name.starts_with(".")) names.push_back(std::move(name));
  }
  std::ranges::sort(names, naturally_before);
  return names;
}

std::vector<std::string> warnings_of_names(const std::vector<std::string>& names) {
  std::vector<NumberedName> all;
  for (const std::string& name : names) all.push_back(numbered(name));
  const auto other = std::ranges::find_if(all, [&](const NumberedName& n) { return n.pattern != all.front().pattern; });
  if (other != all.end())
    return {"has slices of several sequences ('" + names.front() + "', '" +
            names[static_cast<std::size_t>(other - all.begin())] + "'): they are stacked in the order of their names"};
  const std::size_t counting = all.size() < 2 ? SIZE_MAX : counting_number(all);
  if (counting == SIZE_MAX) return {};
  std::int64_t step = INT64_MAX;
  for (std::size_t n = 1; n < all.size(); ++n) {
    const std::int64_t before = all[n - 1].numbers[counting], number = all[n].numbers[counting];
    if (before < 0 || number < 0) return {};
    if (number == before) return {"has '" + names[n - 1] + "' and '" + names[n] + "' of the same number: both are taken"};
    step = std::min(step, number - before);
  }
  std::int64_t missing = 0;
  std::size_t gaps = 0;
  std::string places;
  for (std::size_t n = 1; n < all.size(); ++n) {
    const std::int64_t lost = (all[n].numbers[counting] - all[n - 1].numbers[counting]) / step - 1;
    if (lost == 0) continue;
    missing += lost;
    if (++gaps <= most_gaps_named) places += (places.empty() ? " behind '" : ", '") + names[n - 1] + "'";
  }
  if (missing == 0) return {};
  return {"lacks " + std::to_string(missing) + (missing == 1 ? " slice" : " slices") + places +
          (gaps > most_gaps_named ? " and elsewhere" : "") + ": the others are stacked without gaps"};
}

}  // namespace palpa::reader
