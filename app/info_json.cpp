#include <cmath>
#include <utility>

#include "app/info_text.h"
#include "palpa/data/thin_parts.h"
#include "palpa/data/volume.h"

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
    Json row = vector(grid.index_to_world_m.row[r]);
    row.push_back(number(origin[r]));
    rows.push_back(std::move(row));
  }
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  return rows;
}

Json as_json(const ResamplingError& error) {
  return {{"p50", error.p50}, {"p99", error.p99}, {"max", error.max}, {"covered", error.covered}};
}

/// For a resampled field, dims and range become those of the file; those of the grid that is felt get keys of their own.
void add_resampling(Json& entry, const Resampling& resampling) {
  Json least = Json::array(), greatest = Json::array();
  for (const ValueRange& extent : resampling.value_ranges)
    least.push_back(number(extent.min)), greatest.push_back(number(extent.max));
  const bool scalar = resampling.value_ranges.size() == 1;
  entry["felt_dims"] = std::exchange(entry["dims"], resampling.dims);
  entry["felt_min"] = std::exchange(entry["min"], scalar ? least[0] : least);
  entry["felt_max"] = std::exchange(entry["max"], scalar ? greatest[0] : greatest);
  entry["resampling_error"] = {{"by_cell", as_json(resampling.by_cell)}, {"by_volume", as_json(resampling.by_volume)}};
}

Json field_entry(const Facts& facts, std::size_t f, const std::optional<double>& level) {
  const VolumeField& field = facts.file.volume.fields[f];
  const GridView& grid = *grid_of(*field.field);
  const std::vector<ValueRange> value_ranges = field.field->value_ranges();
  Json least = Json::array(), greatest = Json::array();
  for (const ValueRange& extent : value_ranges) least.push_back(number(extent.min)), greatest.push_back(number(extent.max));
  const bool scalar = field.field->components() == 1;
  Json entry{{"name", field.name},
             {"unit", field.unit},
             {"components", field.field->components()},
             {"type", name_of(grid.voxels.type)},
             {"dims", grid.geometry.dims},
             {"min", scalar ? least[0] : least},
             {"max", scalar ? greatest[0] : greatest}};
  if (field.resampling) add_resampling(entry, *field.resampling);
  if (level && scalar) {
    const ThinParts parts = thin_parts(*field.field, *level);
    entry["level"] = number(*level);
    entry["thin_share"] = parts.thin_share();
    entry["lost_share"] = parts.lost_share();
  }
  if (const auto shift = shift_of(facts, f, level)) {
    entry["shift_per_edge_median"] = number(shift->median);
    entry["shift_per_edge_p90"] = number(shift->p90);
    entry["shift_lost_share"] = shift->lost_share;
  }
  if (grid.geometry != facts.placed.grid) entry["index_to_world_m"] = matrix(grid.geometry);
  return entry;
}

/// The values of a field, of vectors their lengths, in the field's own unit.
Json statistics_entry(const VolumeField& field, const Statistics& values) {
  const Histogram shown = values.histogram.in_classes(histogram_classes);
  Json percentiles = Json::object();
  for (const auto& [name, share] : {std::pair{"p1", 0.01}, {"p50", 0.5}, {"p99", 0.99}}) {
    percentiles[name] = number(values.percentile(share));
  }
  return {{"name", field.name},
          {"of", field.field->components() == 1 ? "value" : "length"},
          {"counted", values.counted},
          {"one_row_in", values.one_in},
          {"zeros", values.zeros},
          {"min", number(values.min)},
          {"max", number(values.max)},
          {"max_ijk", {values.max_at.i, values.max_at.j, values.max_at.k}},
          {"mean", number(values.mean)},
          {"deviation", number(values.deviation)},
          {"percentiles", std::move(percentiles)},
          {"histogram", {{"low", number(shown.low)}, {"high", number(shown.high)}, {"counts", shown.counts}}}};
}

Json sample(const Facts& facts, const Vec3& at_m) {
  const Volume& volume = facts.file.volume;
  Json values = Json::object();
  bool inside = false;
  for (const VolumeField& field : volume.fields) {
    values[field.name] = value_at(*field.field, at_m);
    inside = inside || !values[field.name].is_null();
  }
  const GridPoint voxel = voxel_of(facts, at_m);
  return {{"at_m", vector(at_m)},
          {"at_ijk", vector({voxel.i, voxel.j, voxel.k})},
          {"inside", inside},
          {"values", std::move(values)}};
}

}  // namespace

Json value_at(const Field& field, const Vec3& at_m) {
  if (field.components() == 1) {
    const ScalarSample sample = field.scalar(at_m);
    return sample.inside ? number(sample.value) : Json(nullptr);
  }
  const VectorSample sample = field.vector(at_m);
  return sample.inside ? vector(sample.value) : Json(nullptr);
}

Json as_json(const Facts& facts, const std::vector<AskedPlace>& places, const std::optional<double>& level) {
  const Volume& volume = facts.file.volume;
  const Placement& placed = facts.placed;
  Json info;
  info["what"] = facts.what;
  info["format"] = volume.format;
  info["modality"] = volume.modality;
  info["scan"] = Json::object();
  for (const ScanFact& fact : volume.scan) {
    info["scan"][std::string(name_of(fact.kind))] = is_number(fact.kind) ? number(fact.number) : Json(fact.words);
  }
  info["files"] = Json::array();
  for (const SourceFile& source : volume.files) {
    info["files"].push_back({{"path", source.path}, {"bytes", source.bytes}, {"sha256", source.sha256}});
  }
  info["fields"] = Json::array();
  info["statistics"] = Json::array();
  for (std::size_t f = 0; f < volume.fields.size(); ++f) {
    info["fields"].push_back(field_entry(facts, f, level));
    info["statistics"].push_back(statistics_entry(volume.fields[f], facts.values[f]));
  }
  info["index_to_world_m"] = matrix(placed.grid);
  if (placed.grid.is_rectilinear()) info["planes_steps"] = placed.grid.planes;
  info["spacing_m"] = vector(placed.spacing_m);
  info["size_m"] = vector(placed.size_m);
  info["origin_m"] = vector(placed.grid.origin_m);
  info["axes_towards"] = placed.letters;
  info["oblique_deg"] = number(placed.oblique_deg);
  info["sheared_deg"] = number(placed.sheared_deg);
  info["mirrored"] = placed.mirrored;
  info["medical_frame"] = volume.medical_frame;
  info["length_unit"] = volume.length_unit;
  info["length_unit_assumed"] = volume.length_unit_assumed;
  info["frames"] = facts.file.frames;
  info["valid_share"] = facts.valid_share();
  info["memory_bytes"] = facts.memory_bytes;
  info["suspicious"] = facts.suspicious;
  info["warnings"] = volume.warnings;
  if (!places.empty()) info["samples"] = Json::array();
  for (const AskedPlace& place : places) info["samples"].push_back(sample(facts, world_of(place, facts)));
  return info;
}

}  // namespace palpa::app
