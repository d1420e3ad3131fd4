#include "palpa/file/store_volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "palpa/base/printed.h"
#include "palpa/base/sanitized.h"
#include "palpa/base/web_address.h"
#include "palpa/base/wording.h"
#include "palpa/data/length_unit.h"
#include "palpa/file/octave_places.h"
#include "palpa/file/store_protocol.h"
#include "palpa/file/store_survey.h"
#include "palpa/file/store_voxels.h"

namespace palpa::detail {
namespace {

constexpr int slots = 64;  ///< chunks decoded at once. More: memory; fewer: the reader waits
constexpr std::uint64_t cache_bytes = 256'000'000;
constexpr double longest_survey_s = 2.0;  ///< More: slow to open; less: a range that is too small
/// Largest coarsest octave, which is in memory as a whole. More: slow to open, more memory; less: more octaves to prepare.
constexpr std::int64_t most_coarsest = 256;  ///< [voxels] along an axis

/// Bytes of an octave, of all fields at one frame.
double bytes_of(const StoreContents& contents, int octave) {
  double bytes = 0.0;
  for (const StoreField& field : contents.fields)
    bytes += static_cast<double>(size_of(field.type)) * field.components *
             static_cast<double>(contents.octaves[static_cast<std::size_t>(octave)].grid.voxels());
  return bytes;
}

/// Octaves that are halves of each other, from the finest.
int halved_octaves(const StoreContents& contents) {
  const auto& finest = contents.octaves.front().grid.dims;
  const auto is_halved = [&](int octave) {
    const auto& dims = contents.octaves[static_cast<std::size_t>(octave)].grid.dims;
    bool all = true;
    for (std::size_t a = 0; a < 3; ++a)
      all = all && dims[a] == std::max<std::int64_t>((finest[a] + (std::int64_t{1} << octave) - 1) >> octave, 1);
    return all;
  };
  const int most = std::min<int>(static_cast<int>(contents.octaves.size()), Octaves::most);
  int count = 1;
  while (count < most && is_halved(count)) ++count;
  return count;
}

/// Reason why a store cannot be felt through windows of so many octaves, as a sentence; empty: it can be.
std::string problem_with_octaves(const StoreContents& contents, int count, const OctavePlaces& places) {
  const auto& last = contents.octaves[static_cast<std::size_t>(count - 1)].grid.dims;
  const std::int64_t longest = *std::ranges::max_element(last);
  const std::string large = "is larger than memory, and its octaves ";
  if (longest > most_coarsest)
    return large + "end at " + std::to_string(longest) + " voxels along an axis; `palpa prepare` makes the rest";
  if (places.making == OctaveMaking::decimation)
    return large + "are every second voxel, not means; `palpa prepare --into` makes means";
  if (places.making == OctaveMaking::neither) return large + "are no means of octave 0; `palpa prepare --into` makes some";
  return {};
}

struct Wanted {
  std::string name, unit;
  std::int32_t field = 0;
};

std::vector<Wanted> wanted_fields(const VolumeRequest& request, const StoreContents& contents) {
  std::vector<Wanted> wanted;
  std::vector<std::string> names;
  for (const StoreField& field : contents.fields) names.push_back(field.name);
  if (request.fields.empty()) {
    for (std::size_t n = 0; n < names.size(); ++n)
      wanted.push_back({names[n], contents.fields[n].unit, static_cast<std::int32_t>(n)});
  }
  for (const VolumeRequest::FieldRequest& field : request.fields) {
    if (!field.arrays.empty())
      throw LoadError("is larger than memory, and field '" + field.name + "' is of three arrays; name one");
    const std::string array = field.array.empty() ? field.name : field.array;
    const auto found = std::ranges::find(names, array);
    if (found == names.end()) throw LoadError("has no array " + in_quotes(array) + "; " + suggestion(array, names));
    const auto n = static_cast<std::size_t>(found - names.begin());
    wanted.push_back({field.name, field.unit.empty() ? contents.fields[n].unit : field.unit, static_cast<std::int32_t>(n)});
  }
  return wanted;
}

/// Factor [1] of lengths for the unit of a request.
double length_factor(const VolumeRequest& request, const StoreContents& contents, Volume& volume) {
  volume.length_unit = contents.length_unit;
  volume.length_unit_assumed = contents.length_unit_assumed;
  if (request.length_unit.empty()) return 1.0;
  const auto asked = length_unit(request.length_unit), stated = length_unit(contents.length_unit);
  if (!asked)
    throw LoadError("is asked for with length_unit '" + request.length_unit + "', which is unknown; name one as mm or um");
  volume.length_unit = asked->name, volume.length_unit_assumed = false;
  return asked->metres / (stated && !contents.length_unit_assumed ? stated->metres : 1e-6);
}

/// Width [m] of the widest voxels that a request allows. Throws LoadError if those of the file are wider.
double coarsest_m(const VolumeRequest& request, const GridGeometry& finest) {
  if (!request.coarsest_mm) return std::numeric_limits<double>::infinity();
  const double width_mm = 1e3 * Octaves::voxel_width_m(finest), hair = 1e-9;
  if (width_mm > (1.0 + hair) * *request.coarsest_mm)
    throw LoadError(text("has voxels of %.6g mm, wider than coarsest_mm = %.6g; give at least their width", width_mm,
                         *request.coarsest_mm));
  return 1e-3 * *request.coarsest_mm;
}

/// Field of a store at a frame, or the series of all. Throws LoadError with a sentence.
FieldPtr field_of(Octaves::Shape shape, const std::shared_ptr<StoreCache>& cache, std::int32_t field, int frame) {
  const bool is_series = frame == VolumeRequest::all_frames;
  const int first = is_series ? 0 : std::max(frame, 0), last = is_series ? cache->contents().frames - 1 : first;
  std::vector<FieldPtr> frames;
  try {
    for (int n = first; n <= last; ++n) {
      shape.source = std::make_shared<StoreVoxels>(cache, field, n);
      const auto made = std::make_shared<const Octaves>(shape);
      shape.kept = made->shape().kept;
      frames.push_back(made);
    }
    return is_series ? time_series(std::move(frames), 1.0) : frames.front();
  } catch (const std::invalid_argument& problem) {
    throw LoadError("cannot be felt: " + std::string(problem.what()) +
                    "; get its chunks again, or make its octaves again by `palpa prepare --into`");
  }
}

/// `volume_in_octaves`, with sentences that may begin with the store's name.
std::optional<Volume> volume_of_store(const VolumeRequest& request, const ReadOptions& options, std::uint64_t limit_bytes) {
  std::unique_ptr<StoreReader> reader;
  try {
    reader = std::make_unique<StoreReader>(request.files.front(), options, slots);
  } catch (const LoadError&) {
    if (is_web_address(request.files.front())) throw;
    return std::nullopt;  // its chunks are too large for windows, or reading it as a whole says what is wrong with it
  }
  const StoreContents contents = reader->contents();
  const bool is_series = request.frame == VolumeRequest::all_frames;
  const double of_frames = is_series ? contents.frames : 1.0, bytes = of_frames * bytes_of(contents, 0);
  if (bytes <= most_whole_bytes(request)) return std::nullopt;

  const int count = halved_octaves(contents);
  const OctavePlaces places = octave_places(*reader);
  if (const std::string problem = problem_with_octaves(contents, count, places); !problem.empty()) {
    if (!request.memory_mb && bytes <= static_cast<double>(limit_bytes)) return std::nullopt;
    throw LoadError(problem);
  }
  if (const double coarsest = of_frames * bytes_of(contents, count - 1);
      is_series && coarsest > static_cast<double>(limit_bytes))
    throw LoadError("has " + std::to_string(contents.frames) + " frames, whose coarsest octaves take " +
                    protocol::readable_bytes(coarsest) + " of memory; name one frame, or convert fewer to a store");
  const StoreSurvey values = survey(*reader, longest_survey_s, longest_survey_s, true);
  if (request.frame >= contents.frames)
    throw LoadError("has " + std::to_string(contents.frames) + " frames, not frame " + std::to_string(request.frame) +
                    "; name one from 0 to " + std::to_string(contents.frames - 1));
  Volume volume;
  volume.format = "zarr";
  volume.frames = contents.frames;
  volume.warnings = contents.warnings;
  volume.warnings.insert(volume.warnings.end(), places.warnings.begin(), places.warnings.end());
  GridGeometry finest = places.octaves.empty() ? contents.octaves.front().grid : places.octaves.front().grid;
  const double factor = length_factor(request, contents, volume);
  for (Vec3& row : finest.index_to_world_m.row) row = factor * row;
  finest.origin_m = factor * finest.origin_m;

  const auto open = [store = request.files.front(), options] { return std::make_unique<StoreReader>(store, options, slots); };
  const auto cache = std::make_shared<StoreCache>(request.files.front().string(), std::move(reader), open, cache_bytes);
  for (const Wanted& wanted : wanted_fields(request, contents)) {
    const StoreField& field = contents.fields[static_cast<std::size_t>(wanted.field)];
    const StoreSurvey::Values& range = values.values[static_cast<std::size_t>(wanted.field)];
    const ValueRange found = range.min <= range.max ? ValueRange{range.min, range.max} : ValueRange{};
    Octaves::Shape shape{.finest = finest, .count = count, .type = field.type, .components = field.components};
    shape.filter = field.components == 1 ? Filter::smooth : Filter::trilinear;
    shape.ranges.assign(static_cast<std::size_t>(field.components), found);
    shape.coarsest_m = coarsest_m(request, finest);
    volume.fields.push_back({wanted.name, wanted.unit, field_of(std::move(shape), cache, wanted.field, request.frame)});
  }
  if (values.values.front().about)
    volume.warnings.push_back(std::string(contents.prepared ? "has more facts than could be read" : "is not prepared") +
                              ": its range of values is that of some chunks");
  if (values.lost + values.damaged > 0)
    volume.warnings.push_back("has " + std::to_string(values.lost) + " lost and " + std::to_string(values.damaged) +
                              " damaged chunks or more; a coarser octave is felt there");
  volume.files.push_back({request.files.front().string(), 0, {}});
  volume.request = std::make_shared<const VolumeRequest>(request);
  return volume;
}

}  // namespace

double most_whole_bytes(const VolumeRequest& request) {
  if (request.memory_mb) return 1e6 * *request.memory_mb;
  return is_web_address(request.files.front()) ? 0.0 : whole_bytes;
}

int felt_octaves(const StoreContents& contents, const OctavePlaces& places) {
  const int count = halved_octaves(contents);
  return problem_with_octaves(contents, count, places).empty() ? count : 0;
}

std::optional<Volume> volume_in_octaves(const VolumeRequest& request, const ReadOptions& options, std::uint64_t limit_bytes) {
  if (request.files.size() != 1 || !protocol::is_store(request.files.front())) return std::nullopt;
  try {
    return volume_of_store(request, options, limit_bytes);
  } catch (const LoadError& error) {
    const std::string sentence = error.what(), place = one_line(request.files.front().string()) + ": ";
    throw LoadError(sentence.starts_with(place) ? sentence.substr(place.size()) : sentence);
  }
}

}  // namespace palpa::detail
