#include "palpa/data/length_unit.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace palpa::detail {
namespace {

struct Named {
  std::string_view name;
  double metres;
};

/// Symbols and short words, in lower case. The first of a size is its name.
constexpr Named symbols[] = {{"m", 1.0},
                             {"dm", 1e-1},
                             {"cm", 1e-2},
                             {"mm", 1e-3},
                             {"um", 1e-6},
                             {"nm", 1e-9},
                             {"pm", 1e-12},
                             {"fm", 1e-15},
                             {"dam", 10.0},
                             {"hm", 100.0},
                             {"km", 1e3},
                             {"angstrom", 1e-10},
                             {"a", 1e-10},
                             {"micron", 1e-6},
                             {"in", 0.0254},
                             {"inch", 0.0254},
                             {"inche", 0.0254},
                             {"thou", 0.0254e-3},
                             {"ft", 0.3048},
                             {"foot", 0.3048},
                             {"feet", 0.3048},
                             {"yd", 0.9144},
                             {"yard", 0.9144},
                             {"mi", 1609.344},
                             {"mile", 1609.344},
                             {"nmi", 1852.0},
                             {"nauticalmile", 1852.0},
                             {"bohr", 5.29177210903e-11},
                             {"ly", 9460730472580800.0},
                             {"lightyear", 9460730472580800.0},
                             {"pc", 3.0856775814913673e16},
                             {"kpc", 3.0856775814913673e19},
                             {"mpc", 3.0856775814913673e22}};

constexpr Named prefixes[] = {{"", 1.0},       {"deca", 10.0},  {"deka", 10.0}, {"hecto", 100.0}, {"kilo", 1e3},
                              {"mega", 1e6},   {"giga", 1e9},   {"deci", 1e-1}, {"centi", 1e-2},  {"milli", 1e-3},
                              {"micro", 1e-6}, {"mikro", 1e-6}, {"nano", 1e-9}, {"pico", 1e-12},  {"femto", 1e-15}};
constexpr Named stems[] = {{"meter", 1.0}, {"metre", 1.0}, {"parsec", 3.0856775814913673e16}};

/// Letters beyond ASCII, in UTF-8 and, for old files, in Latin-1.
constexpr std::pair<std::string_view, std::string_view> folded[] = {
    {"\u00b5", "u"}, {"\u03bc", "u"}, {"\u212b", "a"}, {"\u00c5", "a"}, {"\u00e5", "a"},
    {"\u030a", ""},  {"\u00f6", "o"}, {"\u00d6", "o"}, {"\u00d7", "*"}, {"\u2212", "-"},
    {"\u00a0", " "}, {"\xb5", "u"},   {"\xc5", "a"},   {"\xe5", "a"},   {"\xf6", "o"}};

/// ASCII form, without a unit's surroundings (blanks, quotes, brackets, a full stop) unless nothing would remain.
std::string plain(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const auto* fold = std::ranges::find_if(folded, [&](const auto& f) { return text.starts_with(f.first); });
    const bool known = fold != std::end(folded);
    out += known ? fold->second : text.substr(0, 1);
    text.remove_prefix(known ? fold->first.size() : 1);
  }
  const auto is_around = [](char c) { return std::string_view(" \t\r\n\"'[](){}<>.").find(c) != std::string_view::npos; };
  while (!out.empty() && (is_around(out.back()) || out.back() == '\0')) out.pop_back();
  if (out.ends_with("(s") || out.ends_with("(S")) out.resize(out.size() - 2);  // "metre(s)"
  const auto begin = std::ranges::find_if_not(out, [&](char c) { return is_around(c) && c != '.'; });
  return {begin, out.end()};
}

std::string lower(std::string_view text) {
  std::string small(text);
  for (char& c : small) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return small;
}

/// Removes a factor at the start of a text: "1e-3 ", "10^-6 ", "2.5*". None if invalid.
std::optional<double> factor_before(std::string& text) {
  double factor = 1.0;
  if (text.find_first_of("+-.0123456789") != 0) return factor;  // "nanometre" begins with a parsable NaN
  const auto number = std::from_chars(text.data(), text.data() + text.size(), factor);
  std::string_view rest(number.ptr, static_cast<std::size_t>(text.data() + text.size() - number.ptr));
  if (rest.starts_with("^") || rest.starts_with("**")) {
    rest.remove_prefix(rest.starts_with("^") ? 1 : 2);
    double power = 0.0;
    const auto read = std::from_chars(rest.data(), rest.data() + rest.size(), power);
    if (read.ec != std::errc{}) return std::nullopt;
    factor = std::pow(factor, power);
    rest.remove_prefix(static_cast<std::size_t>(read.ptr - rest.data()));
  }
  while (rest.starts_with(" ") || rest.starts_with("*")) rest.remove_prefix(1);
  if (number.ec != std::errc{} || !(factor > 0.0) || !std::isfinite(factor)) return std::nullopt;
  text = std::string(rest);
  return factor;
}

/// [m] Word of a unit, in lower case without blanks; 0: no length.
double metres_of_singular(std::string_view word) {
  for (const auto& [name, metres] : symbols) {
    if (word == name) return metres;
  }
  for (const auto& [prefix, factor] : prefixes) {
    for (const auto& [stem, metres] : stems) {
      if (word.size() == prefix.size() + stem.size() && word.starts_with(prefix) && word.ends_with(stem)) {
        return factor * metres;
      }
    }
  }
  return 0.0;
}

/// [m] Word as above, or its plural. Symbols have none: "ms" is a time.
double metres_of_word(std::string_view word) {
  constexpr std::size_t shortest_plural = 5;
  const double metres = metres_of_singular(word);
  const bool is_plural = metres == 0.0 && word.size() >= shortest_plural && word.back() == 's';
  return is_plural ? metres_of_singular(word.substr(0, word.size() - 1)) : metres;
}

}  // namespace

std::optional<LengthUnit> length_unit(std::string_view text) {
  std::string said = plain(text);
  const std::optional<double> factor = factor_before(said);
  if (!factor) return std::nullopt;
  // Symbols whose capitals make another unit: megametre, petametre, nautical mile.
  for (const std::string_view two : {"Mm", "Pm", "NM"}) {
    if (said == two) return std::nullopt;
  }
  std::string word = lower(said);
  std::erase_if(word, [](char c) { return c == ' ' || c == '-' || c == '_'; });
  const double metres = *factor * metres_of_word(word);
  if (!(metres > 0.0) || !std::isfinite(metres)) return std::nullopt;
  const auto* same = std::ranges::find_if(symbols, [&](const Named& n) { return n.metres == metres; });
  return LengthUnit{metres, same != std::end(symbols) ? std::string(same->name) : plain(text)};
}

bool leaves_length_unit_open(std::string_view text) {
  const std::string word = lower(plain(text));
  if (word.find_first_not_of('?') == std::string::npos) return true;
  constexpr std::string_view words[] = {"unknown", "none", "unspecified", "undefined", "n/a"};
  return std::ranges::find(words, word) != std::end(words);
}

}  // namespace palpa::detail
