#include "app/info_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/info_kind.h"
#include "app/info_numbers.h"
#include "palpa/base/wording.h"
#include "palpa/data/filter.h"
#include "palpa/data/thin_parts.h"
#include "palpa/data/volume.h"
#include "palpa/file/protocol.h"

namespace palpa::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t histogram_classes = 64;  // [1] More: longer output; fewer: coarser. Programs may count on it

/// A number that JSON can hold; null for one that is not finite.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json vector(const Vec3& v) { return Json::array({number(v.x), number(v.y), number(v.z)}); }

Json matrix(const GridGeometry& grid) {
  const double origin[3] = {grid.origin_m.x, grid.origin_m.y, grid.origin_m.z};
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) {
    rows.push_back(vector(grid.index_to_world_m.row[r]));
    rows.back().push_back(number(origin[r]));
  }
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  return rows;
}

/// Bytes as "7.53 MB".
std::string bytes_words(std::uint64_t bytes) { return protocol::readable_bytes(static_cast<double>(bytes)); }

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
                                    {"zarr", "Zarr"},
                                    {"raw", "bare numbers"}}) {
    if (format == name) return words;
  }
  return format.find("vt") != std::string::npos ? "VTK (." + format + ")" : format;
}

/// Acquisition: "120 kVp, slices 5 mm thick"; the known words of its protocol; the scanner.
void add_scan(InfoTable& table, const Volume& volume) {
  Json& scan = table.json["scan"] = Json::object();
  for (const ScanFact& fact : volume.scan)
    scan[std::string(name_of(fact.kind))] = is_number(fact.kind) ? number(fact.number) : Json(fact.words);
  using enum ScanFactKind;
  std::vector<std::string> made;
  for (const auto& [kind, form] : {std::pair{field_strength_t, "{:.3g} T"},
                                   {sequence, "{}"},
                                   {repetition_time_ms, "TR {:.4g} ms"},
                                   {echo_time_ms, "TE {:.3g} ms"},
                                   {inversion_time_ms, "TI {:.4g} ms"},
                                   {flip_angle_deg, "flip angle {:.3g}°"},
                                   {b_value_s_per_mm2, "b = {:.4g} s/mm²"},
                                   {velocity_range_cm_per_s, "VENC {:.4g} cm/s"},
                                   {tube_voltage_kv, "{:.4g} kVp"},
                                   {tube_current_ma, "{:.4g} mA"},
                                   {kernel, "kernel {}"},
                                   {slice_thickness_mm, "slices {:.3g} mm thick"}})
    if (std::string words = scan_fact(volume, kind, form); !words.empty()) made.push_back(std::move(words));
  table.words += line("scan", detail::joined(made)) +
                 line("protocol", scan_fact(volume, protocol, "{} (only words that are known to name nobody)")) +
                 line("scanner", scan_fact(volume, scanner));
}

void add_files(InfoTable& table, const Volume& volume) {
  std::uint64_t bytes = 0;
  Json& files = table.json["files"] = Json::array();
  for (const SourceFile& source : volume.files) {
    files.push_back({{"path", source.path}, {"bytes", source.bytes}, {"sha256", source.sha256.text()}});
    bytes += source.bytes;
  }
  table.words += line("format", fmt::format("{}, {} {}, {}", format_words(volume.format), files.size(),
                                            files.size() == 1 ? "file" : "files", bytes_words(bytes)));
}

/// Series of a folder and labels of a segmentation.
void add_parts(InfoTable& table, const FileContents& contents) {
  Json series = Json::array(), labels = Json::object();
  std::vector<std::string> names;
  for (const FilePart& part : contents.series)
    series.push_back({{"uid", part.name}, {"words", part.words}, {"images", part.number}});
  for (const FilePart& label : contents.labels) {
    labels[label.name] = label.number;
    names.push_back(fmt::format("{} {}", label.number, label.name));
  }
  if (!contents.series.empty()) table.json["series"] = std::move(series);
  if (!names.empty()) table.json["labels"] = std::move(labels);
  table.words += line("labels", detail::joined(names));
}

void add_grid(InfoTable& table, const Facts& facts) {
  const GridGeometry& grid = facts.placed.grid;
  table.json["index_to_world_m"] = matrix(grid);
  if (grid.is_rectilinear()) table.json["planes_steps"] = grid.planes;
  table.json["spacing_m"] = vector(facts.placed.spacing_m);
  table.json["size_m"] = vector(facts.placed.size_m);
  table.json["origin_m"] = vector(grid.origin_m);
  table.words += line("grid", fmt::format("{} × {} × {} voxels of {}{}", grid.dims[0], grid.dims[1], grid.dims[2],
                                          sides_words(facts, facts.placed.spacing_m),
                                          grid.is_rectilinear() ? " on average: its planes are at uneven distances" : ""));
  if (const auto& resampling = facts.file.volume.fields.front().resampling) {
    const auto& n = resampling->dims;
    table.words +=
        line("", fmt::format("made from the file's own, of {}",
                             n[1] == 1 && n[2] == 1 ? rounded_words(static_cast<double>(n[0])) + " points in cells of any shape"
                                                    : fmt::format("{} × {} × {} points along curved lines", n[0], n[1], n[2])));
  }
  table.words += line("size", fmt::format("{}{}, {} in memory", sides_words(facts, facts.placed.size_m), assumed_words(facts),
                                          bytes_words(facts.memory_bytes)));
}

void add_axes(InfoTable& table, const Facts& facts) {
  const Placement& placed = facts.placed;
  const bool medical = facts.file.volume.medical_frame;
  table.json["axes_towards"] = placed.letters;
  table.json["oblique_deg"] = number(placed.oblique_deg);
  table.json["sheared_deg"] = number(placed.sheared_deg);
  table.json["mirrored"] = placed.mirrored;
  table.json["medical_frame"] = medical;
  const char* to = medical ? "to " : "along ";
  std::string axes = fmt::format("i {}{}, j {}{}, k {}{}{}", to, placed.towards[0], to, placed.towards[1], to,
                                 placed.towards[2], medical ? ": " + placed.letters : "");
  if (placed.oblique_deg > 0.5) axes += fmt::format(", oblique by {:.3g}°", placed.oblique_deg);
  if (const std::string tilt = gantry_tilt(facts); !tilt.empty())
    axes += ", sheared by a " + tilt;
  else if (placed.sheared_deg > least_shear_deg)
    axes += fmt::format(", sheared by {:.3g}°", placed.sheared_deg);
  if (placed.mirrored) axes += ", left-handed";
  table.words += line("axes", axes) + line("position", format_place(facts, facts.file.volume.bounds_m()) +
                                                           (medical ? "" : ", along the file's own x, y, z"));
}

void add_extent(InfoTable& table, const Facts& facts) {
  const Volume& volume = facts.file.volume;
  const double share = facts.valid_share();
  table.json["length_unit"] = volume.length_unit;
  table.json["length_unit_assumed"] = volume.length_unit_assumed;
  table.json["frames"] = facts.file.frames;
  table.json["valid_share"] = share;
  table.json["memory_bytes"] = facts.memory_bytes;
  if (facts.file.frames > 1) table.words += line("frames", fmt::format("{}", facts.file.frames));
  if (share < 1.0) {
    const char* others = volume.format == "dicom"           ? "padding, where nothing was measured"
                         : volume.fields.front().resampling ? "outside of the file's cells"
                         : volume.format == "hdf5"          ? "without a value: not finite, or marked so by the file"
                                                            : "not finite";
    table.words += line("data", fmt::format("in {:.3g} % of the voxels; the others are {}", 100.0 * share, others));
  }
}

/// Facts of all fields, each kind of fact in a block of its own.
class FieldsTable {
 public:
  FieldsTable(const Facts& facts, const std::optional<double>& level) : facts_(facts), level_(level) {
    for (const VolumeField& field : facts.file.volume.fields) width_ = std::max(width_, field.name.size());
    ranges_ = fmt::format("\n  {:<{}}  {:<8}  {:<9}  {:<26}  max\n", "field", width_, "unit", "stored as", "min");
    if (level) levels_ = "\n";
    for (std::size_t f = 0; f < facts.file.volume.fields.size(); ++f) {
      Json& entry = fields.emplace_back(add_range(f));
      add_filter(f);
      add_statistics(f);
      add_level(f, entry);
      if (const GridGeometry& grid = grid_of(*field(f).field)->geometry; grid != facts.placed.grid)
        entry["index_to_world_m"] = matrix(grid);
    }
  }

  std::string words() const {
    const std::string of_file =
        errors_.empty()
            ? ""
            : row("") + "min and max are those of the file; the histograms below are of the new grid, which is felt\n";
    return ranges_ + of_file + "\n" + filters_ + "\n" + statistics_ + errors_ + levels_ + shifts_;
  }

  Json fields = Json::array(), statistics = Json::array();

 private:
  const VolumeField& field(std::size_t f) const { return facts_.file.volume.fields[f]; }
  std::string row(const std::string& name) const { return fmt::format("  {:<{}}  ", name, width_); }

  /// One end of a field's range; of vectors that of each component: "(-1, 0, 0.5)", [-1, 0, 0.5].
  static std::pair<std::string, Json> end_of(const std::vector<ValueRange>& value_ranges, double ValueRange::* end) {
    double span = 0.0;
    for (const ValueRange& extent : value_ranges) span = std::max(span, extent.max - extent.min);
    std::vector<std::string> words;
    Json json = Json::array();
    for (const ValueRange& extent : value_ranges) {
      words.push_back(rounded_words(extent.*end, span));
      json.push_back(number(extent.*end));
    }
    return words.size() == 1 ? std::pair{words[0], json[0]} : std::pair{"(" + detail::joined(words) + ")", json};
  }

  /// Of a resampled field, dims and range are those of the file; those of the grid that is felt have keys of their own.
  Json add_range(std::size_t f) {
    const VolumeField& of = field(f);
    const GridView& grid = *grid_of(*of.field);
    const std::string type(name_of(grid.voxels.type));
    const std::vector<ValueRange> felt = of.field->value_ranges();
    const auto& in_file = of.resampling ? of.resampling->value_ranges : felt;
    const auto least = end_of(in_file, &ValueRange::min), greatest = end_of(in_file, &ValueRange::max);
    ranges_ += row(of.name) + fmt::format("{:<8}  {:<9}  {:<26}  {}\n", of.unit.empty() ? "–" : of.unit,
                                          type + (in_file.size() == 3 ? "×3" : ""), least.first, greatest.first);
    Json entry{{"name", of.name},
               {"unit", of.unit},
               {"components", of.field->components()},
               {"type", type},
               {"dims", of.resampling ? of.resampling->dims : grid.geometry.dims},
               {"min", least.second},
               {"max", greatest.second}};
    if (of.resampling) {
      entry["felt_dims"] = grid.geometry.dims;
      entry["felt_min"] = end_of(felt, &ValueRange::min).second;
      entry["felt_max"] = end_of(felt, &ValueRange::max).second;
      add_errors(*of.resampling, of.name, entry["resampling_error"]);
    }
    return entry;
  }

  void add_errors(const Resampling& resampling, const std::string& name, Json& entry) {
    const auto percent = [](double share) {
      return share > 0.0 && share < 1e-4 ? std::string("< 0.01 %") : fmt::format("{:.2g} %", 100.0 * share);
    };
    const auto columns = [&](const std::string& of, const char* by, const std::string& p50, const std::string& p99,
                             const std::string& max, const std::string& covered) {
      errors_ += row(of) + fmt::format("{:<9}  {:<9}  {:<10}  {:<9}  {}\n", by, p50, p99, max, covered);
    };
    if (errors_.empty()) {
      errors_ =
          "\n  error of the new grid against the file's own, as a share of the field's range: by cell, where boundary layers "
          "count most, and by volume, as a hand meets it\n";
      columns("field", "places", "median", "99 % below", "worst", "with data");
    }
    for (const auto& [by, key, e] :
         {std::tuple{"by cell", "by_cell", resampling.by_cell}, {"by volume", "by_volume", resampling.by_volume}}) {
      columns(name, by, percent(e.p50), percent(e.p99), percent(e.max), fmt::format("{:.3g} %", 100.0 * e.covered));
      entry[key] = {{"p50", e.p50}, {"p99", e.p99}, {"max", e.max}, {"covered", e.covered}};
    }
  }

  void add_filter(std::size_t f) {
    const FilterChoice felt = default_filter(*grid_of(*field(f).field));
    filters_ += row(field(f).name) + fmt::format("felt through the {} filter: {}{}\n", name_of(felt.filter), felt.why,
                                                 felt.roughness ? fmt::format(" (roughness {:.2g})", *felt.roughness) : "");
  }

  /// The values of a field, of vectors their lengths, in the field's own unit.
  void add_statistics(std::size_t f) {
    const Statistics& values = facts_.values[f];
    const bool lengths = field(f).field->components() == 3;
    const Histogram shown = values.histogram.in_classes(histogram_classes);
    statistics.push_back({{"name", field(f).name},
                          {"of", lengths ? "length" : "value"},
                          {"counted", values.counted},
                          {"one_row_in", values.one_in},
                          {"zeros", values.zeros},
                          {"min", number(values.min)},
                          {"max", number(values.max)},
                          {"max_ijk", {values.max_at.i, values.max_at.j, values.max_at.k}},
                          {"mean", number(values.mean)},
                          {"deviation", number(values.deviation)},
                          {"percentiles",
                           {{"p1", number(values.percentile(0.01))},
                            {"p50", number(values.percentile(0.5))},
                            {"p99", number(values.percentile(0.99))}}},
                          {"histogram", {{"low", number(shown.low)}, {"high", number(shown.high)}, {"counts", shown.counts}}}});
    if (values.counted == 0) return;
    const double span = values.max - values.min;
    // Percentiles of whole numbers are printed as whole numbers, although a class of the histogram may be wider than one.
    const auto quantile = [&](double share) {
      const double value = values.percentile(share);
      return rounded_words(values.whole_numbers ? std::round(value) : value, span);
    };
    const std::string unit = field(f).unit.empty() ? "" : " " + field(f).unit;
    statistics_ += row(field(f).name) +
                   fmt::format("{}median {}, mean {}, 99 % up to {}{}{}\n", lengths ? "length: " : "", quantile(0.5),
                               rounded_words(values.mean, span), quantile(0.99), unit,
                               values.one_in > 1 ? fmt::format(" (of one row of voxels in {})", values.one_in) : "") +
                   row("") +
                   fmt::format("{} ▕{}▏ {}{}\n", rounded_words(values.min, span), bars_of(values.histogram),
                               rounded_words(values.max), unit);
  }

  void add_level(std::size_t f, Json& entry) {
    if (level_ && field(f).field->components() == 1) {
      const ThinParts parts = thin_parts(*field(f).field, *level_);
      entry["level"] = number(*level_);
      entry["thin_share"] = parts.thin_share();
      entry["lost_share"] = parts.lost_share();
      levels_ += fmt::format(
          "  level {:g} of {}: {:.2g} % of what is above is thinner than 2 voxels; the smooth filter loses {:.2g} % of that\n",
          *level_, field(f).name, 100.0 * parts.thin_share(), 100.0 * parts.lost_share());
    }
    if (const auto shift = shift_of(facts_, f, level_)) {
      entry["shift_per_edge_median"] = number(shift->median);
      entry["shift_per_edge_p90"] = number(shift->p90);
      entry["shift_lost_share"] = shift->lost_share;
      shifts_ += fmt::format(
          "\n  from frame to frame {} {} moves by {:.2g} of the width of its edge (median; 90 % by less than {:.2g}; {:.2g} % "
          "vanishes)\n  so a surface {}\n",
          level_ ? fmt::format("level {:g} of", *level_) : "the steepest tenth of", field(f).name, shift->median, shift->p90,
          100.0 * shift->lost_share,
          shift->p90 < 1.0 ? "moves on from frame to frame, and carries the hand"
                           : "jumps from frame to frame: its strength fades out and in");
    }
  }

  const Facts& facts_;
  const std::optional<double>& level_;
  std::size_t width_ = 5;
  std::string ranges_, filters_, statistics_, errors_, levels_, shifts_;
};

/// The values at a place, in words rounded; vectors along the world's axes.
void add_place(InfoTable& table, const Facts& facts, const AskedPlace& place) {
  const Vec3 at_m = world_of(place, facts);
  const GridPoint voxel = voxel_of(facts, at_m);
  table.words += fmt::format("\n  at {}: {}, voxel {:.4g}, {:.4g}, {:.4g}\n", place.text, format_place(facts, at_m),
                             voxel.i + 0.0, voxel.j + 0.0, voxel.k + 0.0);
  bool anywhere = false;
  Json values = Json::object();
  for (const VolumeField& field : facts.file.volume.fields) {
    const bool scalar = field.field->components() == 1;
    const ScalarSample s = scalar ? field.field->scalar(at_m) : ScalarSample{};
    const VectorSample v = scalar ? VectorSample{} : field.field->vector(at_m);
    const std::string unit = field.unit.empty() ? "" : " " + field.unit;
    std::string words = "no data";
    Json& value = values[field.name] = nullptr;
    if (scalar ? s.inside : v.inside) {
      anywhere = true;
      value = scalar ? number(s.value) : vector(v.value);
      words = scalar ? rounded_words(s.value) + unit
                     : "(" + rounded_words(v.value.x) + ", " + rounded_words(v.value.y) + ", " + rounded_words(v.value.z) +
                           ")" + unit + ", length " + rounded_words(norm(v.value)) + unit;
    }
    table.words += fmt::format("    {} = {}\n", field.name, words);
  }
  if (!anywhere) table.words += fmt::format("    {}\n", why_outside(place, facts, at_m));
  table.json["samples"].push_back({{"at_m", vector(at_m)},
                                   {"at_ijk", vector({voxel.i, voxel.j, voxel.k})},
                                   {"inside", anywhere},
                                   {"values", std::move(values)}});
}

}  // namespace

InfoTable info_table(const Facts& facts, const std::vector<AskedPlace>& places, const std::optional<double>& level) {
  const Volume& volume = facts.file.volume;
  InfoTable table{facts.name + "\n" + line("what", facts.what), {}};
  table.json["what"] = facts.what;
  table.json["format"] = volume.format;
  table.json["modality"] = volume.modality;
  add_scan(table, volume);
  add_files(table, volume);
  add_parts(table, facts.file.contents);
  FieldsTable fields(facts, level);
  table.json["fields"] = std::move(fields.fields);
  table.json["statistics"] = std::move(fields.statistics);
  add_grid(table, facts);
  add_axes(table, facts);
  add_extent(table, facts);
  table.words += fields.words();
  table.json["suspicious"] = facts.suspicious;
  table.json["warnings"] = volume.warnings;
  if (!facts.suspicious.empty()) table.words += "\n";
  for (const std::string& thing : facts.suspicious)
    table.words += line("note", (thing.rfind("field ", 0) == 0 ? "" : "the file ") + thing);
  for (const AskedPlace& place : places) add_place(table, facts, place);
  return table;
}

}  // namespace palpa::app
