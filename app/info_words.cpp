#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/info_text.h"
#include "palpa/field/thin_parts.h"

namespace palpa::app {
namespace {

std::string text_of(const Vec3& v) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x, v.y, v.z); }

std::string text_of(const std::vector<Extent>& extents, double Extent::*end) {
  if (extents.size() == 1) return fmt::format("{:.6g}", extents[0].*end);
  std::string text;
  for (const Extent& extent : extents) text += fmt::format("{}{:.4g}", text.empty() ? "" : ", ", extent.*end);
  return "(" + text + ")";
}

/// A length in the unit in which people would say it.
std::string text_of_length(double metres) {
  static constexpr struct {
    double at_least_m, metres;
    const char* unit;
  } units[] = {{1e3, 1e3, "km"}, {1.0, 1.0, "m"}, {1e-3, 1e-3, "mm"}, {1e-6, 1e-6, "µm"}, {0.0, 1e-9, "nm"}};
  for (const auto& [at_least_m, unit_m, unit] : units) {
    if (metres >= at_least_m) return fmt::format("{:.4g} {}", metres / unit_m, unit);
  }
  return fmt::format("{:.4g} m", metres);
}

std::string text_of_lengths(const Vec3& v) {
  return fmt::format("{} × {} × {}", text_of_length(v.x), text_of_length(v.y), text_of_length(v.z));
}

/// A histogram in one line of bars; heights go by the square root, so that what is rare is seen beside what fills the volume.
std::string bars_of(const Histogram& histogram) {
  static constexpr const char* bars[] = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  const Histogram shown = histogram.in_classes(48);
  const auto most = static_cast<double>(std::max<std::int64_t>(1, *std::max_element(shown.counts.begin(), shown.counts.end())));
  std::string text;
  for (const std::int64_t count : shown.counts) {
    text += bars[static_cast<std::size_t>(std::ceil(8.0 * std::sqrt(static_cast<double>(count) / most)))];
  }
  return text;
}

void print_placement(const Facts& facts) {
  const Volume& volume = facts.file.volume;
  const Placement& placed = facts.placed;
  const auto& dims = placed.grid.dims;
  fmt::print("  grid     {} × {} × {} voxels of {}{}\n", dims[0], dims[1], dims[2], text_of_lengths(placed.spacing_m),
             placed.grid.is_rectilinear() ? " on average: its planes are at uneven distances" : "");
  fmt::print(
      "  size     {}, {:.3g} MB in memory{}\n", text_of_lengths(placed.size_m), static_cast<double>(facts.memory_bytes) / 1e6,
      volume.length_unit_assumed ? fmt::format("; the file says no unit of length, {} is taken", volume.length_unit) : "");
  const char* to = volume.medical_frame ? "to " : "along ";
  std::string turned;
  if (placed.oblique_deg > 0.5) turned += fmt::format(", oblique by {:.3g}°", placed.oblique_deg);
  if (placed.sheared_deg > 0.1) turned += fmt::format(", sheared by {:.3g}°", placed.sheared_deg);
  if (placed.mirrored) turned += ", left-handed";
  fmt::print("  axes     i {}{}, j {}{}, k {}{}{}\n", to, placed.towards[0], to, placed.towards[1], to, placed.towards[2],
             turned);
  const Box box = volume.bounds_m();
  fmt::print("  world    {} to {} m, {}\n", text_of(box.low_m), text_of(box.high_m),
             volume.medical_frame ? "medical frame (x to the left, y to the back, z to the head)" : "the file's own axes");
  if (facts.file.frames > 1) fmt::print("  frames   {}\n", facts.file.frames);
  if (const double share = facts.valid_share(); share < 1.0) fmt::print("  valid    {:.4g} % of the voxels\n", 100.0 * share);
}

void print_fields(const Facts& facts) {
  const std::vector<VolumeField>& fields = facts.file.volume.fields;
  std::size_t width = 5;
  for (const VolumeField& field : fields) width = std::max(width, field.name.size());
  fmt::print("\n  {:<{}}  {:<8}  {:<9}  {:<26}  max\n", "field", width, "unit", "type", "min");
  for (const VolumeField& field : fields) {
    const std::vector<Extent> extents = field.field->extents();
    const std::string type = std::string(name_of(grid_of(*field.field)->voxels.type)) + (extents.size() == 3 ? "×3" : "");
    fmt::print("  {:<{}}  {:<8}  {:<9}  {:<26}  {}\n", field.name, width, field.unit.empty() ? "–" : field.unit, type,
               text_of(extents, &Extent::min), text_of(extents, &Extent::max));
  }
  fmt::print("\n");
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const Statistics& values = facts.values[f];
    if (values.counted == 0) continue;
    const bool lengths = fields[f].field->components() == 3;
    const std::string unit = fields[f].unit.empty() ? "" : " " + fields[f].unit;
    fmt::print("  {:<{}}  {} {:.4g} on average, half of all up to {:.4g}, 99 % up to {:.4g}{}{}\n", fields[f].name, width,
               lengths ? "length" : "value", values.mean, values.percentile(0.5), values.percentile(0.99), unit,
               values.one_in > 1 ? fmt::format(" (of one row of voxels in {})", values.one_in) : "");
    fmt::print("  {:<{}}  {:.4g} ▕{}▏ {:.4g}{}\n", "", width, values.min, bars_of(values.histogram), values.max, unit);
  }
}

void print_resampling(const Facts& facts) {
  std::size_t width = 5;
  for (const VolumeField& field : facts.file.volume.fields) width = std::max(width, field.name.size());
  const auto percent = [](double share) { return fmt::format("{:.2g} %", 100.0 * share); };
  bool first = true;
  for (const VolumeField& field : facts.file.volume.fields) {
    if (!field.resampling) continue;
    if (std::exchange(first, false)) {
      fmt::print(
          "\n  error of resampling, as a share of the range: of half of the places, of 99 %, the worst; places with data\n");
      fmt::print("  {:<{}}  {:<9}  {:<9}  {:<9}  {:<9}  covered\n", "field", width, "places", "half", "99 %", "worst");
    }
    for (const auto& [by, e] : {std::pair{"by cell", field.resampling->by_cell}, {"by volume", field.resampling->by_volume}}) {
      fmt::print("  {:<{}}  {:<9}  {:<9}  {:<9}  {:<9}  {:.3g} %\n", field.name, width, by, percent(e.p50), percent(e.p99),
                 percent(e.max), 100.0 * e.covered);
    }
  }
}

void print_at_level(const Facts& facts, const std::optional<double>& level) {
  const std::vector<VolumeField>& fields = facts.file.volume.fields;
  if (level) fmt::print("\n");
  for (const VolumeField& field : fields) {
    if (!level || field.field->components() != 1) continue;
    const ThinParts parts = thin_parts(*field.field, *level);
    fmt::print(
        "  level {:g} of {}: {:.2g} % of what is above is thinner than 2 voxels; the smooth filter loses {:.2g} % of that\n",
        *level, field.name, 100.0 * parts.thin_share(), 100.0 * parts.lost_share());
  }
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const auto shift = shift_of(facts, f, level);
    if (!shift) continue;
    fmt::print(
        "\n  {} {} moves by {:.2g} widths of its edge per frame (median; p90 {:.2g}; {:.2g} % of the places have none left)\n",
        level ? fmt::format("level {:g} of", *level) : "the steepest tenth of", fields[f].name, shift->median, shift->p90,
        100.0 * shift->lost_share);
    fmt::print("  {}\n", shift->p90 < 1.0
                             ? "below 1 a level moves from frame to frame, and carries the hand"
                             : "above 1 a level does not move between frames, it jumps: its strength fades out and in");
  }
}

}  // namespace

void print_words(const Facts& facts, const std::vector<Vec3>& at_m, const std::optional<double>& level) {
  const Volume& volume = facts.file.volume;
  std::uint64_t bytes = 0;
  for (const SourceFile& source : volume.files) bytes += source.bytes;
  fmt::print("{}\n", facts.name);
  fmt::print("  what     {}\n", facts.what);
  fmt::print("  format   {}, {} {}, {:.4g} MB\n", volume.format, volume.files.size(),
             volume.files.size() == 1 ? "file" : "files", static_cast<double>(bytes) / 1e6);
  print_placement(facts);
  print_fields(facts);
  print_resampling(facts);
  print_at_level(facts, level);
  if (!facts.suspicious.empty()) fmt::print("\n");
  for (const std::string& thing : facts.suspicious) fmt::print("  look at  {}\n", thing);
  if (!at_m.empty()) fmt::print("\n");
  for (const Vec3& at : at_m) {
    for (const VolumeField& field : volume.fields) {
      const auto value = value_at(*field.field, at);
      fmt::print("  at {} m: {} = {}\n", text_of(at), field.name, value.is_null() ? "outside" : value.dump());
    }
  }
}

}  // namespace palpa::app
