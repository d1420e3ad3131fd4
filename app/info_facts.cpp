#include "app/info_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "app/info_kind.h"
#include "app/info_numbers.h"
#include "palpa/data/body_hint.h"
#include "palpa/data/read_series.h"
#include "palpa/data/volume.h"
#include "palpa/file/components.h"
#include "palpa/file/directions.h"

namespace palpa::app {
namespace {

/// Time from frame to frame of a series; any value will do, because nothing that is said of a series depends on it.
constexpr double any_period_s = 1.0;

/// Up to the first number all voxels are looked at; of more about the second, in whole rows, so that a mapped file is not read
/// as a whole. More: slower; fewer: a range that is too small.
constexpr std::int64_t most_voxels_at_all = std::int64_t{1} << 24;
constexpr std::int64_t most_voxels_of_many = std::int64_t{1} << 20;

void find_suspicious_values(const Facts& facts, std::size_t f, std::vector<std::string>& suspicious) {
  const VolumeField& field = facts.file.volume.fields[f];
  const Statistics& values = facts.values[f];
  const auto say = [&](const std::string& words) { suspicious.push_back("field '" + field.name + "' " + words); };
  if (values.counted == 0) return say("has no finite value at all");
  if (values.max <= values.min) return say(fmt::format("has the value {:g} everywhere", values.min));
  if (!facts.labels[f].labels.empty()) return;
  const auto n = static_cast<double>(values.counted);
  if (const double zeros = static_cast<double>(values.zeros) / n; zeros > 0.3 && zeros < 1.0) {
    say(fmt::format("is exactly 0 in {:.0f} % of the voxels: probably background, without data", 100.0 * zeros));
  }
  const Histogram& h = values.histogram;
  const GridView& grid = *grid_of(*field.field);
  const bool whole_voxels = grid.voxels.type != VoxelType::float32 && grid.voxels.type != VoxelType::float64;
  if (field.field->components() == 1 && whole_voxels && values.max - values.min >= 200.0 * std::abs(grid.scale)) {
    const double at_top = static_cast<double>(h.counts.back()) / n,
                 beside = static_cast<double>(h.counts[h.counts.size() / 16 * 15]) / n;
    if (at_top > 1e-3 && at_top > 10.0 * beside) {
      say(fmt::format("has its largest value {:.4g} in {:.2g} % of the voxels: what is above was probably cut off", values.max,
                      100.0 * at_top));
    }
  }
  if (h.percentile(0.999) - h.percentile(0.001) < 0.02 * (values.max - values.min)) {
    say("has a few values far from all others: outliers, or a code for 'no data'");
  }
  // No flow is that fast: the file's numbers must be in other units.
  if (field.unit == "a∞" && values.max > 20.0) {
    say(fmt::format("goes up to {:.0f} times the speed of sound: its numbers are probably not divided by a∞, as PLOT3D asks",
                    values.max));
  }
  if (looks_like_hounsfield(values, field.unit, facts.file.volume.modality) && values.min < -1100.0) {
    say(fmt::format("goes down to {:g}, where air is -1000 HU: {:.2g} % of the voxels are padding, where nothing was measured",
                    values.min, 100.0 * h.share_between(values.min, -1100.0)));
  }
}

std::vector<std::string> suspicious_things(const Facts& facts) {
  std::vector<std::string> suspicious;
  const Placement& placed = facts.placed;
  const double longest_m = largest_component(placed.size_m);
  if (looks_like_scan(facts) && (longest_m > longest_body_m || longest_m < 0.5e-3)) {
    const bool in_metres = facts.file.volume.length_unit == "m" && longest_m > longest_body_m;
    suspicious.push_back(
        fmt::format("is {} long, which no scan of a body is: the unit of length is probably {}, which --set "
                    "length_unit={} takes",
                    length_words(longest_m), in_metres ? "mm" : "another", in_metres ? "mm" : "UNIT"));
  }
  if (const auto hint = too_long_for(facts.file.volume, {facts.name}); hint && suspicious.empty())
    suspicious.push_back(
        fmt::format("is {} long, which no {} is, as which '{}' reads: the unit of length is probably mm, which --set "
                    "length_unit=mm takes",
                    length_words(longest_m), hint->part, hint->name));
  const double steps_m[] = {placed.spacing_m.x, placed.spacing_m.y, placed.spacing_m.z};
  const auto [shortest, longest] = std::minmax_element(steps_m, steps_m + 3);
  if (*longest > 4.0 * *shortest) {
    suspicious.push_back(
        fmt::format("has voxels {:.2g} times as long along {} as along {}: what is finer than {} is lost there",
                    *longest / *shortest, "ijk"[longest - steps_m], "ijk"[shortest - steps_m], length_words(facts, *longest)));
  }
  for (std::size_t a = 0; a < 3; ++a) {
    if (placed.grid.dims[a] == 1)
      suspicious.push_back(fmt::format("is one voxel thick along {}: a slice, constant across", "ijk"[a]));
  }
  for (std::size_t f = 0; f < facts.values.size(); ++f) find_suspicious_values(facts, f, suspicious);
  for (const VolumeRequest::FieldRequest& vector : separate_vectors(facts.file.volume)) {
    const std::string fields = "fields={" + vector.name + "={arrays=[\"" + vector.arrays[0] + "\",\"" + vector.arrays[1] +
                               "\",\"" + vector.arrays[2] + "\"]}}";
    suspicious.push_back("has the components of one vector in the arrays '" + vector.arrays[0] + "', '" + vector.arrays[1] +
                         "' and '" + vector.arrays[2] + "': --scene and --picture take them so, and so does --set '" + fields +
                         "'");
  }
  return suspicious;
}

}  // namespace

double Facts::valid_share() const {
  double share = 1.0;
  for (const VolumeField& field : file.volume.fields) share = std::min(share, grid_of(*field.field)->valid_share);
  return share;
}

Facts facts_of(const Asked& asked, const ReadOptions& read, bool all_frames) {
  VolumeRequest first = asked.request;
  if (asked.is_series) first.files = {asked.request.files.front()};
  Facts facts{.name = asked.name, .file = read_volume_file(first, read)};
  for (const VolumeField& field : facts.file.volume.fields) {
    const GridView& grid = *grid_of(*field.field);
    const bool many = grid.geometry.voxels() > most_voxels_at_all;
    facts.values.push_back(statistics(*field.field, many ? most_voxels_of_many : most_voxels_at_all));
    facts.labels.push_back(labels_in(facts.file.volume, field, facts.values.back()));
    facts.memory_bytes += static_cast<std::uint64_t>(grid.geometry.voxels()) *
                          static_cast<std::uint64_t>(grid.voxels.components) * size_of(grid.voxels.type);
  }
  facts.placed = placement_of(facts.file.volume);
  facts.suspicious = suspicious_things(facts);
  const auto directions = as_directions(first, facts.file, read);
  facts.directions = directions.has_value();
  if (directions) {
    facts.suspicious.push_back("has three frames that are the components of vectors of length 1: --set as=vector" +
                               std::string(directions->components_along == "index" ? " --set components_along=index" : "") +
                               " takes them so");
  }
  if (all_frames && (asked.is_series || (facts.file.frames > 1 && asked.request.frame < 0 && !directions))) {
    try {
      facts.series = read_series(asked.request, any_period_s, BetweenFrames::linear, volume_reader(read));
    } catch (const std::invalid_argument& error) {
      throw LoadError(error.what());
    }
    facts.file.frames = facts.series->frames;
    facts.file.volume.files = facts.series->files;
  }
  facts.what = kind_of(facts);
  return facts;
}

std::optional<VolumeRequest> request_to_feel(const Asked& asked, const Facts& facts, const ReadOptions& read) {
  if (asked.is_series) return std::nullopt;
  if (facts.directions) return as_directions(asked.request, facts.file, read);
  return with_vectors_joined(asked.request, facts.file.volume);
}

std::optional<FrameShift> shift_of(const Facts& facts, std::size_t field, const std::optional<double>& level) {
  if (!facts.series) return std::nullopt;
  const FrameShift shift = frame_shift(*series_of(*facts.series->fields[field].field), level);
  return shift.places > 0 ? std::optional(shift) : std::nullopt;
}

}  // namespace palpa::app
