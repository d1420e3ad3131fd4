#include "app/info_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpa/base/printed.h"
#include "palpa/data/length_unit.h"

namespace palpa::app {
namespace {

struct Unit {
  double metres;
  const char* name;
};

Unit unit_for(double metres) {
  for (const Unit& unit : {Unit{1e3, "km"}, Unit{1.0, "m"}, Unit{1e-3, "mm"}, Unit{1e-6, "µm"}, Unit{1e-9, "nm"}}) {
    if (metres >= 0.9999 * unit.metres) return unit;
  }
  return metres > 0.0 ? Unit{1e-10, "Å"} : Unit{1.0, "m"};
}

/// True if lengths are printed in file units: the file has no unit of length and no medical frame, which implies millimetres.
bool in_file_units(const Facts& facts) { return facts.file.volume.length_unit_assumed && !facts.file.volume.medical_frame; }

/// The unit of the file's own numbers.
Unit file_unit(const Facts& facts) {
  const auto assumed = detail::length_unit(facts.file.volume.length_unit);
  return {assumed ? assumed->metres : 1.0, "file units"};
}

/// The unit for lengths in a volume: that of the file's numbers where none is known, millimetres for patients and for files in
/// millimetres, else one that fits its size.
Unit unit_of(const Facts& facts) {
  if (in_file_units(facts)) return file_unit(facts);
  if (facts.file.volume.medical_frame || facts.file.volume.length_unit == "mm") return {1e-3, "mm"};
  return unit_for(largest_component(facts.placed.size_m));
}

}  // namespace

std::string line(std::string_view label, const std::string& text) {
  return text.empty() ? text : fmt::format("  {:<10}{}\n", label, text);
}

std::string for_shell(const std::string& path) {
  static constexpr const char* plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./,:+@%";
  if (!path.empty() && path.find_first_not_of(plain) == std::string::npos) return path;
  std::string quoted = "'";
  for (const char c : path) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string rounded_words(double value) {
  const double size = std::abs(value);
  if (size < 999.95 || size >= 1e9 || !std::isfinite(value)) return fmt::format("{:.4g}", value + 0.0);
  const std::string digits = fmt::format("{:.0f}", value);
  return size < 9999.5 ? digits : detail::grouped(digits);
}

std::string rounded_words(double value, double span) { return rounded_words(std::abs(value) < 1e-7 * span ? 0.0 : value); }

std::string length_words(double metres) {
  const Unit unit = unit_for(metres);
  return fmt::format("{:.4g} {}", metres / unit.metres, unit.name);
}

std::string length_words(const Facts& facts, double metres) {
  if (in_file_units(facts)) return rounded_words(metres / file_unit(facts).metres) + " " + file_unit(facts).name;
  return facts.file.volume.medical_frame ? fmt::format("{:.4g} mm", 1e3 * metres) : length_words(metres);
}

std::string sides_words(const Facts& facts, const Vec3& sides_m) {
  if (in_file_units(facts)) {
    const Vec3 sides = (1.0 / file_unit(facts).metres) * sides_m;
    return rounded_words(sides.x) + " × " + rounded_words(sides.y) + " × " + rounded_words(sides.z) + " file units";
  }
  const Unit unit = facts.file.volume.medical_frame ? Unit{1e-3, "mm"} : unit_for(largest_component(sides_m));
  const auto side = [&](double metres) { return fmt::format("{:.4g} {}", metres / unit.metres, unit.name); };
  return side(sides_m.x) + " × " + side(sides_m.y) + " × " + side(sides_m.z);
}

std::string assumed_words(const Facts& facts) {
  const Volume& volume = facts.file.volume;
  if (!volume.length_unit_assumed) return {};
  return (in_file_units(facts) ? ", taken as " : ", if the file's lengths are in ") + volume.length_unit;
}

std::string in_one_unit(const Facts& facts, const Vec3& world_m) {
  const Unit unit = unit_of(facts);
  const auto part = [&](double m) {
    const double number = m / unit.metres;
    return fmt::format("{:.6g}", std::abs(number) < 1e-9 * largest_component(facts.placed.size_m) / unit.metres ? 0.0 : number);
  };
  return "(" + part(world_m.x) + ", " + part(world_m.y) + ", " + part(world_m.z) + ") " + unit.name;
}

std::string bars_of(const Histogram& histogram) {
  constexpr std::size_t bar_classes = 48;  // [1] More: longer line; fewer: coarser
  static constexpr const char* bars[] = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  const Histogram shown = histogram.in_classes(bar_classes);
  const auto most = static_cast<double>(std::max<std::int64_t>(1, *std::max_element(shown.counts.begin(), shown.counts.end())));
  std::string text;
  for (const std::int64_t count : shown.counts) {
    text += bars[static_cast<std::size_t>(std::ceil(8.0 * std::sqrt(static_cast<double>(count) / most)))];
  }
  return text;
}

}  // namespace palpa::app
