#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/info_kind.h"
#include "app/info_numbers.h"
#include "app/info_text.h"
#include "app/terminal.h"
#include "palpa/file/protocol.h"
#include "palpa/grid/filter.h"
#include "palpa/survey/thin_parts.h"
#include "palpa/volume/volume.h"

namespace palpa::app {
namespace {

std::string text_of(const std::vector<Extent>& extents, double Extent::*end) {
  double span = 0.0;
  for (const Extent& extent : extents) span = std::max(span, extent.max - extent.min);
  if (extents.size() == 1) return rounded_words(extents[0].*end, span);
  std::string text;
  for (const Extent& extent : extents) text += (text.empty() ? "" : ", ") + rounded_words(extent.*end, span);
  return "(" + text + ")";
}

/// Bytes as "7.53 MB".
std::string text_of_bytes(std::uint64_t bytes) { return protocol::readable_bytes(static_cast<double>(bytes)); }

/// The usual name of a format.
std::string format_words(const std::string& format) {
  for (const auto& [name, words] : {std::pair{"dicom", "DICOM"},
                                    {"nifti", "NIfTI"},
                                    {"nrrd", "NRRD"},
                                    {"metaimage", "MetaImage"},
                                    {"vtk", "VTK (legacy .vtk)"},
                                    {"plot3d", "PLOT3D"},
                                    {"openfoam", "OpenFOAM"},
                                    {"hdf5", "HDF5"},
                                    {"raw", "bare numbers"}}) {
    if (format == name) return words;
  }
  return format.find("vt") != std::string::npos ? "VTK (." + format + ")" : format;
}

/// "a, b": the parts that are not empty.
std::string joined(const std::vector<std::string>& parts) {
  std::string all;
  for (const std::string& part : parts) all += (all.empty() || part.empty() ? "" : ", ") + part;
  return all;
}

/// A histogram in one line of bars. Heights are square roots, so that rare values are seen beside those that fill the volume.
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

/// How a scan was made: "120 kVp, slices 5 mm thick"; the known words of its protocol; the scanner.
void print_scan(const Volume& volume) {
  const auto words = [&](ScanFactKind kind) {
    for (const ScanFact& fact : volume.scan) {
      if (fact.kind == kind) return fact.words;
    }
    return std::string();
  };
  const auto number = [&](ScanFactKind kind, const char* form) {
    for (const ScanFact& fact : volume.scan) {
      if (fact.kind == kind) return fmt::format(fmt::runtime(form), fact.number);
    }
    return std::string();
  };
  const std::string kernel = words(ScanFactKind::kernel);
  const std::string made = joined(
      {number(ScanFactKind::field_strength_t, "{:.3g} T"), words(ScanFactKind::sequence),
       number(ScanFactKind::repetition_time_ms, "TR {:.4g} ms"), number(ScanFactKind::echo_time_ms, "TE {:.3g} ms"),
       number(ScanFactKind::inversion_time_ms, "TI {:.4g} ms"), number(ScanFactKind::flip_angle_deg, "flip angle {:.3g}°"),
       number(ScanFactKind::b_value_s_per_mm2, "b = {:.4g} s/mm²"),
       number(ScanFactKind::velocity_range_cm_per_s, "VENC {:.4g} cm/s"), number(ScanFactKind::tube_voltage_kv, "{:.4g} kVp"),
       number(ScanFactKind::tube_current_ma, "{:.4g} mA"), kernel.empty() ? "" : "kernel " + kernel,
       number(ScanFactKind::slice_thickness_mm, "slices {:.3g} mm thick")});
  if (!made.empty()) print(fmt::format("  scan      {}\n", made));
  if (const std::string protocol = words(ScanFactKind::protocol); !protocol.empty())
    print(fmt::format("  protocol  {} (only words that are known to name nobody)\n", protocol));
  if (const std::string scanner = words(ScanFactKind::scanner); !scanner.empty())
    print(fmt::format("  scanner   {}\n", scanner));
}

void print_placement(const Facts& facts) {
  const Volume& volume = facts.file.volume;
  const Placement& placed = facts.placed;
  const auto& dims = placed.grid.dims;
  const bool resampled = volume.fields.front().resampling.has_value();
  print(fmt::format("  grid      {} × {} × {} voxels of {}{}\n", dims[0], dims[1], dims[2],
                    sides_words(facts, placed.spacing_m),
                    placed.grid.is_rectilinear() ? " on average: its planes are at uneven distances" : ""));
  if (resampled) {
    const auto& n = volume.fields.front().resampling->dims;
    print(fmt::format("            made from the file's own, of {}\n",
                      n[1] == 1 && n[2] == 1 ? rounded_words(static_cast<double>(n[0])) + " points in cells of any shape"
                                             : fmt::format("{} × {} × {} points along curved lines", n[0], n[1], n[2])));
  }
  print(fmt::format("  size      {}{}, {} in memory\n", sides_words(facts, placed.size_m), assumed_words(facts),
                    text_of_bytes(facts.memory_bytes)));
  const char* to = volume.medical_frame ? "to " : "along ";
  std::string turned;
  if (placed.oblique_deg > 0.5) turned += fmt::format(", oblique by {:.3g}°", placed.oblique_deg);
  const std::string tilt = gantry_tilt(facts);
  if (!tilt.empty())
    turned += ", sheared by a " + tilt;
  else if (placed.sheared_deg > least_shear_deg)
    turned += fmt::format(", sheared by {:.3g}°", placed.sheared_deg);
  if (placed.mirrored) turned += ", left-handed";
  print(fmt::format("  axes      i {}{}, j {}{}, k {}{}{}{}\n", to, placed.towards[0], to, placed.towards[1], to,
                    placed.towards[2], volume.medical_frame ? ": " + placed.letters : "", turned));
  print(fmt::format("  position  {}{}\n", words_of(facts, volume.bounds_m()),
                    volume.medical_frame ? "" : ", along the file's own x, y, z"));
  if (facts.file.frames > 1) print(fmt::format("  frames    {}\n", facts.file.frames));
  if (const double share = facts.valid_share(); share < 1.0) {
    print(fmt::format("  data      in {:.3g} % of the voxels; the others are {}\n", 100.0 * share,
                      volume.format == "dicom"  ? "padding, where nothing was measured"
                      : resampled               ? "outside of the file's cells"
                      : volume.format == "hdf5" ? "without a value: not finite, or marked so by the file"
                                                : "not finite"));
  }
}

void print_fields(const Facts& facts) {
  const std::vector<VolumeField>& fields = facts.file.volume.fields;
  std::size_t width = 5;
  for (const VolumeField& field : fields) width = std::max(width, field.name.size());
  print(fmt::format("\n  {:<{}}  {:<8}  {:<9}  {:<26}  max\n", "field", width, "unit", "stored as", "min"));
  bool resampled = false;
  for (const VolumeField& field : fields) {
    const std::vector<Extent> extents = field.resampling ? field.resampling->extents : field.field->extents();
    resampled = resampled || field.resampling;
    const std::string type = std::string(name_of(grid_of(*field.field)->voxels.type)) + (extents.size() == 3 ? "×3" : "");
    print(fmt::format("  {:<{}}  {:<8}  {:<9}  {:<26}  {}\n", field.name, width, field.unit.empty() ? "–" : field.unit, type,
                      text_of(extents, &Extent::min), text_of(extents, &Extent::max)));
  }
  if (resampled)
    print(fmt::format("  {:<{}}  min and max are those of the file; the histograms below are of the new grid, which is felt\n",
                      "", width));
  print("\n");
  for (const VolumeField& field : fields) {
    const FilterChoice felt = default_filter(*grid_of(*field.field));
    print(fmt::format("  {:<{}}  felt through the {} filter: {}{}\n", field.name, width, name_of(felt.filter), felt.why,
                      felt.roughness ? fmt::format(" (roughness {:.2g})", *felt.roughness) : ""));
  }
  print("\n");
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const Statistics& values = facts.values[f];
    if (values.counted == 0) continue;
    const bool lengths = fields[f].field->components() == 3;
    const double span = values.max - values.min;
    // Percentiles of whole numbers are printed as whole numbers, although a class of the histogram may be wider than one.
    const auto quantile = [&](double share) {
      const double value = values.percentile(share);
      return rounded_words(values.whole_numbers ? std::round(value) : value, span);
    };
    const std::string unit = fields[f].unit.empty() ? "" : " " + fields[f].unit;
    print(fmt::format("  {:<{}}  {}median {}, mean {}, 99 % up to {}{}{}\n", fields[f].name, width, lengths ? "length: " : "",
                      quantile(0.5), rounded_words(values.mean, span), quantile(0.99), unit,
                      values.one_in > 1 ? fmt::format(" (of one row of voxels in {})", values.one_in) : ""));
    print(fmt::format("  {:<{}}  {} ▕{}▏ {}{}\n", "", width, rounded_words(values.min, span), bars_of(values.histogram),
                      rounded_words(values.max), unit));
  }
}

void print_resampling(const Facts& facts) {
  std::size_t width = 5;
  for (const VolumeField& field : facts.file.volume.fields) width = std::max(width, field.name.size());
  const auto percent = [](double share) {
    return share > 0.0 && share < 1e-4 ? std::string("< 0.01 %") : fmt::format("{:.2g} %", 100.0 * share);
  };
  bool first = true;
  for (const VolumeField& field : facts.file.volume.fields) {
    if (!field.resampling) continue;
    if (std::exchange(first, false)) {
      print(fmt::format(
          "\n  error of the new grid against the file's own, as a share of the field's range: by cell, where boundary layers "
          "count "
          "most, and by volume, as a hand meets it\n"));
      print(fmt::format("  {:<{}}  {:<9}  {:<9}  {:<10}  {:<9}  with data\n", "field", width, "places", "median", "99 % below",
                        "worst"));
    }
    for (const auto& [by, e] : {std::pair{"by cell", field.resampling->by_cell}, {"by volume", field.resampling->by_volume}}) {
      print(fmt::format("  {:<{}}  {:<9}  {:<9}  {:<10}  {:<9}  {:.3g} %\n", field.name, width, by, percent(e.p50),
                        percent(e.p99), percent(e.max), 100.0 * e.covered));
    }
  }
}

void print_at_level(const Facts& facts, const std::optional<double>& level) {
  const std::vector<VolumeField>& fields = facts.file.volume.fields;
  if (level) print("\n");
  for (const VolumeField& field : fields) {
    if (!level || field.field->components() != 1) continue;
    const ThinParts parts = thin_parts(*field.field, *level);
    print(fmt::format(
        "  level {:g} of {}: {:.2g} % of what is above is thinner than 2 voxels; the smooth filter loses {:.2g} % of that\n",
        *level, field.name, 100.0 * parts.thin_share(), 100.0 * parts.lost_share()));
  }
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const auto shift = shift_of(facts, f, level);
    if (!shift) continue;
    print(fmt::format(
        "\n  from frame to frame {} {} moves by {:.2g} of the width of its edge (median; 90 % by less than {:.2g}; {:.2g} % "
        "vanishes)\n",
        level ? fmt::format("level {:g} of", *level) : "the steepest tenth of", fields[f].name, shift->median, shift->p90,
        100.0 * shift->lost_share));
    print(fmt::format("  {}\n", shift->p90 < 1.0 ? "so a surface moves on from frame to frame, and carries the hand"
                                                 : "so a surface jumps from frame to frame: its strength fades out and in"));
  }
}

/// The values at a place, rounded; vectors along the world's axes.
void print_place(const Facts& facts, const AskedPlace& place) {
  const Vec3 at_m = world_of(place, facts);
  const GridPoint voxel = voxel_of(facts, at_m);
  print(fmt::format("\n  at {}: {}, voxel {:.4g}, {:.4g}, {:.4g}\n", place.text, words_of(facts, at_m), voxel.i + 0.0,
                    voxel.j + 0.0, voxel.k + 0.0));
  bool anywhere = false;
  for (const VolumeField& field : facts.file.volume.fields) {
    const std::string unit = field.unit.empty() ? "" : " " + field.unit;
    if (field.field->components() == 1) {
      const ScalarSample s = field.field->scalar(at_m);
      print(fmt::format("    {} = {}\n", field.name, s.inside ? rounded_words(s.value) + unit : "no data"));
      anywhere = anywhere || s.inside;
      continue;
    }
    const VectorSample v = field.field->vector(at_m);
    anywhere = anywhere || v.inside;
    print(fmt::format("    {} = {}\n", field.name,
                      v.inside ? "(" + rounded_words(v.value.x) + ", " + rounded_words(v.value.y) + ", " +
                                     rounded_words(v.value.z) + ")" + unit + ", length " + rounded_words(norm(v.value)) + unit
                               : "no data"));
  }
  if (!anywhere) print(fmt::format("    {}\n", why_outside(place, facts, at_m)));
}

}  // namespace

void print_words(const Facts& facts, const std::vector<AskedPlace>& places, const std::optional<double>& level) {
  const Volume& volume = facts.file.volume;
  std::uint64_t bytes = 0;
  for (const SourceFile& source : volume.files) bytes += source.bytes;
  print(fmt::format("{}\n", facts.name));
  print(fmt::format("  what      {}\n", facts.what));
  print_scan(volume);
  print(fmt::format("  format    {}, {} {}, {}\n", format_words(volume.format), volume.files.size(),
                    volume.files.size() == 1 ? "file" : "files", text_of_bytes(bytes)));
  print_placement(facts);
  print_fields(facts);
  print_resampling(facts);
  print_at_level(facts, level);
  if (!facts.suspicious.empty()) print("\n");
  for (const std::string& thing : facts.suspicious)
    print(fmt::format("  note      {}{}\n", thing.rfind("field ", 0) == 0 ? "" : "the file ", thing));
  for (const AskedPlace& place : places) print_place(facts, place);
}

}  // namespace palpa::app
