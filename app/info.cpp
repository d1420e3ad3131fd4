#include "app/info.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "app/terminal.h"
#include "palpa/field/frame_shift.h"
#include "palpa/field/grid.h"
#include "palpa/field/thin_parts.h"
#include "palpa/scene/read_series.h"

namespace palpa::app {
namespace {

using Json = nlohmann::ordered_json;

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

/// Of a field that was resampled, dims and range are those of the file, and what is felt stands beside them.
void add_resampling(Json& entry, const Resampling& resampling) {
  Json least = Json::array(), greatest = Json::array();
  for (const Extent& extent : resampling.extents) least.push_back(number(extent.min)), greatest.push_back(number(extent.max));
  const bool scalar = resampling.extents.size() == 1;
  entry["felt_dims"] = std::exchange(entry["dims"], resampling.dims);
  entry["felt_min"] = std::exchange(entry["min"], scalar ? least[0] : least);
  entry["felt_max"] = std::exchange(entry["max"], scalar ? greatest[0] : greatest);
  entry["resampling_error"] = {{"by_cell", as_json(resampling.by_cell)}, {"by_volume", as_json(resampling.by_volume)}};
}

/// The field's value at a world position, null outside its data. Vectors are along the world's axes.
Json value_at(const Field& field, const Vec3& at_m) {
  if (field.components() == 1) {
    const ScalarSample sample = field.scalar(at_m);
    return sample.inside ? number(sample.value) : Json(nullptr);
  }
  const VectorSample sample = field.vector(at_m);
  return sample.inside ? vector(sample.value) : Json(nullptr);
}

double valid_share(const Volume& volume) {
  double share = 1.0;
  for (const VolumeField& field : volume.fields) share = std::min(share, grid_of(*field.field)->valid_share);
  return share;
}

/// What is known of a file, or of the first frame of a series, and the series.
struct Found {
  VolumeFile file;
  std::optional<Volume> series;
};

/// How far the levels of a field move from frame to frame; nothing where it is no series.
std::optional<FrameShift> shift_of(const Found& found, std::size_t field, const std::optional<double>& level) {
  if (!found.series) return std::nullopt;
  const FrameShift shift = frame_shift(*series_of(*found.series->fields[field].field), level);
  return shift.places > 0 ? std::optional(shift) : std::nullopt;
}

Json as_json(const Found& found, const std::vector<Vec3>& at_m, const std::optional<double>& level) {
  const VolumeFile& file = found.file;
  const Volume& volume = file.volume;
  const GridGeometry& first = grid_of(*volume.fields.front().field)->geometry;
  Json info;
  info["format"] = volume.format;
  info["files"] = Json::array();
  for (const SourceFile& source : volume.files) {
    info["files"].push_back({{"path", source.path}, {"bytes", source.bytes}, {"sha256", source.sha256}});
  }
  info["fields"] = Json::array();
  for (const VolumeField& field : volume.fields) {
    const GridView& grid = *grid_of(*field.field);
    const std::vector<Extent> extents = field.field->extents();
    Json least = Json::array(), greatest = Json::array();
    for (const Extent& extent : extents) least.push_back(number(extent.min)), greatest.push_back(number(extent.max));
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
    if (const auto shift = shift_of(found, info["fields"].size(), level)) {
      entry["shift_per_edge_median"] = number(shift->median);
      entry["shift_per_edge_p90"] = number(shift->p90);
      entry["shift_lost_share"] = shift->lost_share;
    }
    if (grid.geometry != first) entry["index_to_world_m"] = matrix(grid.geometry);
    info["fields"].push_back(std::move(entry));
  }
  info["index_to_world_m"] = matrix(first);
  info["medical_frame"] = volume.medical_frame;
  info["frames"] = file.frames;
  info["valid_share"] = valid_share(volume);
  info["warnings"] = volume.warnings;
  if (!at_m.empty()) info["samples"] = Json::array();
  for (const Vec3& at : at_m) {
    Json values = Json::object();
    bool inside = false;
    for (const VolumeField& field : volume.fields) {
      values[field.name] = value_at(*field.field, at);
      inside = inside || !values[field.name].is_null();
    }
    info["samples"].push_back({{"at_m", vector(at)}, {"inside", inside}, {"values", std::move(values)}});
  }
  return info;
}

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

void print_table(const std::string& name, const Found& found, const std::vector<Vec3>& at_m,
                 const std::optional<double>& level) {
  const VolumeFile& file = found.file;
  const Volume& volume = file.volume;
  std::uint64_t bytes = 0;
  for (const SourceFile& source : volume.files) bytes += source.bytes;
  fmt::print("{}\n", name);
  fmt::print("  format   {}, {} {}, {:.4g} MB\n", volume.format, volume.files.size(),
             volume.files.size() == 1 ? "file" : "files", static_cast<double>(bytes) / 1e6);

  const GridGeometry& grid = grid_of(*volume.fields.front().field)->geometry;
  const Mat3 steps = transposed(grid.index_to_world_m);
  fmt::print("  grid     {} × {} × {} voxels of {} × {} × {}\n", grid.dims[0], grid.dims[1], grid.dims[2],
             text_of_length(norm(steps.row[0])), text_of_length(norm(steps.row[1])), text_of_length(norm(steps.row[2])));
  const Box box = volume.bounds_m();
  fmt::print("  world    {} to {} m, {}\n", text_of(box.low_m), text_of(box.high_m),
             volume.medical_frame ? "medical frame (x left, y back, z up)" : "the file's own axes");
  if (file.frames > 1) fmt::print("  frames   {}\n", file.frames);
  if (const double share = valid_share(volume); share < 1.0) fmt::print("  valid    {:.4g} % of the voxels\n", 100.0 * share);

  std::size_t width = 5;
  for (const VolumeField& field : volume.fields) width = std::max(width, field.name.size());
  fmt::print("\n  {:<{}}  {:<8}  {:<8}  {:<26}  {:<26}\n", "field", width, "unit", "type", "min", "max");
  for (const VolumeField& field : volume.fields) {
    const std::vector<Extent> extents = field.field->extents();
    const std::string type = std::string(name_of(grid_of(*field.field)->voxels.type)) + (extents.size() == 3 ? "×3" : "");
    fmt::print("  {:<{}}  {:<8}  {:<8}  {:<26}  {:<26}\n", field.name, width, field.unit.empty() ? "–" : field.unit, type,
               text_of(extents, &Extent::min), text_of(extents, &Extent::max));
  }
  for (const VolumeField& field : volume.fields) {
    if (!field.resampling) continue;
    if (&field == &volume.fields.front())
      fmt::print(
          "\n  error of resampling, of the range: half of the places, 99 %, the worst looked at; places that have data\n");
    const auto text = [](const ResamplingError& e) {
      return fmt::format("{:.2g} %, {:.2g} %, {:.2g} %; {:.3g} %", 100.0 * e.p50, 100.0 * e.p99, 100.0 * e.max,
                         100.0 * e.covered);
    };
    fmt::print("  {:<{}}  by cell {}; by volume {}\n", field.name, width, text(field.resampling->by_cell),
               text(field.resampling->by_volume));
  }
  if (level) fmt::print("\n");
  for (const VolumeField& field : volume.fields) {
    if (!level || field.field->components() != 1) continue;
    const ThinParts parts = thin_parts(*field.field, *level);
    fmt::print(
        "  level {:g} of {}: {:.2g} % of what is above is thinner than 2 voxels; the smooth filter loses {:.2g} % of that\n",
        *level, field.name, 100.0 * parts.thin_share(), 100.0 * parts.lost_share());
  }
  for (std::size_t f = 0; f < volume.fields.size(); ++f) {
    const auto shift = shift_of(found, f, level);
    if (!shift) continue;
    fmt::print(
        "\n  {} {} moves by {:.2g} widths of its edge per frame (median; p90 {:.2g}; {:.2g} % of the places have none left)\n",
        level ? fmt::format("level {:g} of", *level) : "the steepest tenth of", volume.fields[f].name, shift->median,
        shift->p90, 100.0 * shift->lost_share);
    fmt::print("  {}\n", shift->p90 < 1.0
                             ? "below 1 a level moves from frame to frame, and carries the hand"
                             : "above 1 a level does not move between frames, it jumps: its strength fades out and in");
  }
  if (!at_m.empty()) fmt::print("\n");
  for (const Vec3& at : at_m) {
    for (const VolumeField& field : volume.fields) {
      const Json value = value_at(*field.field, at);
      fmt::print("  at {} m: {} = {}\n", text_of(at), field.name, value.is_null() ? "outside" : value.dump());
    }
  }
}

/// The time from frame to frame does not matter to what is said of a series.
constexpr double any_period_s = 1.0;

/// One file, with all its frames where it has several; or several files as one series.
Found find(const std::vector<std::filesystem::path>& files, const ReadOptions& read) {
  VolumeRequest request;
  request.files = {files.front()};
  Found found{read_volume_file(request, read), {}};
  if (files.size() == 1 && found.file.frames == 1) return found;
  request.files = files;
  try {
    found.series = read_series(request, any_period_s, BetweenFrames::linear, volume_reader(read));
  } catch (const std::invalid_argument& error) {
    throw LoadError(error.what());
  }
  found.file.frames = found.series->frames;
  found.file.volume.files = found.series->files;
  return found;
}

bool is_pattern(const std::filesystem::path& path) {
  std::error_code ignored;
  return path.filename().string().find_first_of("*?") != std::string::npos && !std::filesystem::exists(path, ignored);
}

}  // namespace

int run_info(const InfoArguments& arguments) {
  struct Asked {
    std::string name;
    std::vector<std::filesystem::path> files;
  };
  std::vector<Asked> all;
  for (const std::filesystem::path& path : arguments.files) {
    if (is_pattern(path)) {
      all.push_back({path.string(), files_matching(path)});
      if (all.back().files.empty()) throw LoadError(path.string() + ": no files match; check the folder and the pattern");
    } else if (arguments.series && !all.empty()) {
      all.front().files.push_back(path);
    } else {
      all.push_back({path.string(), {path}});
    }
  }
  Json list = Json::array();
  for (const Asked& asked : all) {
    const Found found = find(asked.files, arguments.read);
    if (arguments.json) {
      list.push_back(as_json(found, arguments.at_m, arguments.level));
      continue;
    }
    if (&asked != &all.front()) fmt::print("\n");
    print_table(asked.name, found, arguments.at_m, arguments.level);
    std::fflush(stdout);
    std::vector<std::string> warnings;
    for (const std::string& warning : found.file.volume.warnings) warnings.push_back(asked.name + ": " + warning);
    print_warnings(warnings);
  }
  if (arguments.json) {
    const Json& printed = list.size() == 1 ? list.front() : list;
    fmt::print("{}\n", printed.dump(2, ' ', false, Json::error_handler_t::replace));
  }
  return 0;
}

}  // namespace palpa::app
