#include "palpa/data/read_series.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "palpa/base/wording.h"
#include "palpa/data/grid.h"
#include "palpa/data/octave_parts.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/volume.h"

namespace palpa {

namespace {

/// Wildcard match. Each star matches as little as possible; on a mismatch the last star takes a character more.
bool matches(std::string_view pattern, std::string_view name) noexcept {
  std::size_t p = 0, n = 0, star = std::string_view::npos, from = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      from = n;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n])) {
      ++p, ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      n = ++from;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

/// Order of names: numbers in them by value, with or without leading zeros; other text by character.
bool is_before(std::string_view a, std::string_view b) noexcept {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto number = [&](std::string_view& text) {
    std::size_t end = 0;
    while (end < text.size() && is_digit(text[end])) ++end;
    std::string_view digits = text.substr(0, end);
    text.remove_prefix(end);
    digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
    return digits;
  };
  const std::string_view whole_a = a, whole_b = b;
  while (!a.empty() && !b.empty()) {
    if (is_digit(a.front()) && is_digit(b.front())) {
      const std::string_view x = number(a), y = number(b);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else {
      if (a.front() != b.front()) return a.front() < b.front();
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  return a.empty() != b.empty() ? a.empty() : whole_a < whole_b;
}

double bytes_of(const Field& field) noexcept {
  const GridView* grid = grid_of(field);
  if (!grid) grid = smooth_grid_of(field);
  if (!grid) return 0.0;
  return static_cast<double>(grid->geometry.voxels()) * grid->voxels.components *
         static_cast<double>(size_of(grid->voxels.type));
}

struct Frame {
  std::string name;  ///< for messages
  Volume volume;
};

/// Reads a file for each frame.
std::vector<Frame> read_files(const VolumeRequest& given, const VolumeReader& read_volume) {
  std::vector<Frame> frames;
  VolumeRequest request = given;
  for (const std::filesystem::path& file : given.files) {
    request.files = {file};
    frames.push_back({file.string(), read_volume(request)});
  }
  return frames;
}

/// Reads the frames of a file, each by its own request.
std::vector<Frame> read_frames(VolumeRequest request, int count, const VolumeReader& read_volume) {
  std::vector<Frame> frames;
  const std::string file = request.files.front().string();
  for (request.frame = 0; request.frame < count; ++request.frame) {
    frames.push_back({file + ", frame " + std::to_string(request.frame) + ",", read_volume(request)});
  }
  return frames;
}

/// Volumes as the frames of one, a second apart.
Volume joined(const std::vector<Frame>& frames) {
  Volume series = frames.front().volume;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const Volume& volume = frames[i].volume;
    if (volume.fields.size() != series.fields.size()) {
      throw std::invalid_argument(frames[i].name + " has " + std::to_string(volume.fields.size()) + " fields and the first " +
                                  std::to_string(series.fields.size()) + "; all frames must have the same");
    }
    for (const SourceFile& file : volume.files) {
      if (std::ranges::find(series.files, file.path, &SourceFile::path) == series.files.end()) series.files.push_back(file);
    }
    for (const std::string& warning : volume.warnings) {
      if (std::ranges::find(series.warnings, warning) == series.warnings.end()) series.warnings.push_back(warning);
    }
  }
  for (std::size_t f = 0; f < series.fields.size(); ++f) {
    VolumeField& first = series.fields[f];
    if (octaves_of(*first.field))
      throw std::invalid_argument(frames.front().name + " is larger than memory; a series of such is one store with an axis t");
    std::vector<FieldPtr> fields;
    for (const Frame& frame : frames) {
      const VolumeField& field = frame.volume.fields[f];
      if (field.name != first.name) {
        throw std::invalid_argument(frame.name + " has a field " + detail::in_quotes(field.name) + " where the first has " +
                                    detail::in_quotes(first.name) + "; all frames must have the same");
      }
      if (const char* problem = problem_with_frame(*first.field, *field.field)) {
        throw std::invalid_argument(frame.name + " " + problem);
      }
      fields.push_back(field.field);
    }
    first.field = time_series(std::move(fields), 1.0);
  }
  series.frames = static_cast<int>(frames.size());
  return series;
}

/// Frames of a file, a second apart: by a single request, or one by one if the reader does not support that.
Volume series_in_file(VolumeRequest request, const VolumeReader& read_volume) {
  request.frame = VolumeRequest::all_frames;
  const Volume volume = read_volume(request);
  if (volume.frames < 2) {
    throw std::invalid_argument(request.files.front().string() +
                                " holds one frame, so it is no time series; leave 'frame_period_s' out");
  }
  const auto is_series = [](const VolumeField& field) { return series_of(*field.field) != nullptr; };
  return std::ranges::all_of(volume.fields, is_series) ? volume : joined(read_frames(request, volume.frames, read_volume));
}

}  // namespace

std::vector<std::filesystem::path> files_matching(const std::filesystem::path& pattern) {
  std::vector<std::filesystem::path> found;
  const std::filesystem::path folder = pattern.has_parent_path() ? pattern.parent_path() : ".";
  const std::string name = pattern.filename().string();
  std::error_code problem;
  for (std::filesystem::directory_iterator entry(folder, problem), end; !problem && entry != end; entry.increment(problem)) {
    const std::filesystem::path file = entry->path().filename();
    if (matches(name, file.string())) found.push_back(pattern.has_parent_path() ? folder / file : file);
  }
  std::ranges::sort(found,
                    [](const auto& a, const auto& b) { return is_before(a.filename().string(), b.filename().string()); });
  return found;
}

Volume read_series(const VolumeRequest& request, double frame_period_s, BetweenFrames between_frames,
                   const VolumeReader& read_volume) {
  if (request.files.empty()) throw std::invalid_argument("there are no files for a time series");
  Volume series = request.files.size() > 1 ? joined(read_files(request, read_volume)) : series_in_file(request, read_volume);
  series.request = std::make_shared<const VolumeRequest>(request);
  double bytes = 0.0;
  for (VolumeField& field : series.fields) {
    std::vector<FieldPtr> frames = series_of(*field.field)->frames;
    for (const FieldPtr& frame : frames) bytes += bytes_of(*frame);
    field.field = time_series(std::move(frames), frame_period_s, between_frames);
  }
  // Memory of a series without a warning. More: computers with little memory swap without a hint; less: usual series warn.
  constexpr double most_quiet_bytes = 2e9;
  if (bytes > most_quiet_bytes) {
    series.warnings.push_back("its " + std::to_string(series.frames) + " frames take " +
                              detail::toml_number(std::round(bytes / 1e8) / 10.0) +
                              " GB of memory; fewer frames or a coarser grid take less");
  }
  return series;
}

}  // namespace palpa
