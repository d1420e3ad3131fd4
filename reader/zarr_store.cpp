#include "zarr_store.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>

#include "palpa/base/limits.h"
#include "palpa/base/wording.h"
#include "palpa/data/length_unit.h"
#include "palpa/file/store_protocol.h"
#include "zarr_half.h"
#include "zarr_vectors.h"

namespace palpa::reader {
namespace {

constexpr double micrometre_m = 1e-6;

std::size_t length_along(const std::vector<std::int64_t>& lengths, std::size_t index) {
  return index == SIZE_MAX ? 1 : static_cast<std::size_t>(lengths[index]);
}

std::array<std::int64_t, 3> in_space(const ZarrAxes& axes, const std::vector<std::int64_t>& lengths,
                                     std::int64_t otherwise = 1) {
  std::array<std::int64_t, 3> found{otherwise, otherwise, otherwise};
  for (std::size_t a = 0; a < 3; ++a) {
    if (axes.space[a] != SIZE_MAX) found[a] = lengths[axes.space[a]];
  }
  return found;
}

/// [s] of a unit of time; 0: unknown.
double seconds_of(const std::string& unit) {
  static constexpr std::pair<std::string_view, double> known[] = {
      {"second", 1.0},      {"s", 1.0},   {"millisecond", 1e-3}, {"ms", 1e-3},     {"microsecond", 1e-6}, {"us", 1e-6},
      {"nanosecond", 1e-9}, {"ns", 1e-9}, {"minute", 60.0},      {"hour", 3600.0}, {"day", 86400.0}};
  for (const auto& [name, seconds] : known) {
    if (unit == name) return seconds;
  }
  return 0.0;
}

struct Voxels3 {
  std::array<std::int64_t, 3> dims, stride;
};

/// Copies one component of a chunk's voxels.
void copy_component(const ZarrType& type, const std::byte* from, std::int64_t offset, const Voxels3& of, std::byte* to,
                    int components, int component) {
  const auto copy = [&](auto from_value, auto to_value, auto converted) {
    using From = decltype(from_value);
    using To = decltype(to_value);
    std::byte* out = to + static_cast<std::size_t>(component) * sizeof(To);
    const std::size_t step = static_cast<std::size_t>(components) * sizeof(To);
    for (std::int64_t k = 0; k < of.dims[2]; ++k) {
      for (std::int64_t j = 0; j < of.dims[1]; ++j) {
        std::int64_t at = offset + k * of.stride[2] + j * of.stride[1];
        for (std::int64_t i = 0; i < of.dims[0]; ++i, at += of.stride[0], out += step) {
          std::array<std::byte, sizeof(From)> bytes;
          std::memcpy(bytes.data(), from + at * static_cast<std::int64_t>(sizeof(From)), sizeof(From));
          if (type.swapped) std::reverse(bytes.begin(), bytes.end());
          const To value = converted(std::bit_cast<From>(bytes));
          std::memcpy(out, &value, sizeof value);
        }
      }
    }
  };
  if (type.half) return copy(std::uint16_t{}, float{}, [](std::uint16_t bits) { return half_number(bits); });
  protocol::with_type(type.raw, [&](auto from_value) {
    protocol::with_type(type.delivered, [&](auto to_value) {
      copy(from_value, to_value, [](auto number) { return static_cast<decltype(to_value)>(number); });
    });
  });
}

/// Fills one component of voxels with a value.
void fill_component(const StoreField& field, std::span<std::byte> to, int component) {
  protocol::with_type(field.type, [&](auto typed) {
    const auto value = static_cast<decltype(typed)>(field.fill);
    const std::size_t step = static_cast<std::size_t>(field.components) * sizeof value;
    for (std::size_t at = static_cast<std::size_t>(component) * sizeof value; at + sizeof value <= to.size(); at += step)
      std::memcpy(&to[at], &value, sizeof value);
  });
}

}  // namespace

ZarrStore::ZarrStore(const std::string& path, std::uint64_t most_chunk_bytes, int fetch)
    : folder_(path, fetch), image_(read_zarr_image(folder_, most_chunk_bytes)) {
  contents_.format = image_.format;
  contents_.warnings = image_.warnings;
  take_fields();
  take_octaves();
  take_facts();
}

void ZarrStore::take_fields() {
  const ZarrArray& finest = image_.levels.front().array;
  const std::size_t frames = length_along(finest.shape, image_.axes.time);
  if (limit::frames.is_passed_by(static_cast<double>(frames)))
    throw LoadError("has " + std::to_string(frames) + " frames, " + more_than(limit::frames));
  contents_.frames = static_cast<int>(frames);
  const std::size_t channels = length_along(finest.shape, image_.axes.channel);
  if (channels > protocol::most_store_fields)
    throw LoadError("has " + std::to_string(channels) + " channels, more than 256; write fewer into one store");
  const bool is_plain = image_.format.starts_with("Zarr");
  const ZarrFields named = fields_of_channels(image_.channels, channels, is_plain);
  names_fields_ = named.are_named;
  for (const ZarrFields::Field& found : named.fields) {
    StoreField field;
    field.name = found.name, field.file_type = finest.type.name, field.type = finest.type.delivered, field.fill = finest.fill;
    field.components = static_cast<int>(found.channels.size());
    const auto channel = static_cast<std::size_t>(found.channels.front());
    if (channel < image_.units.size()) field.unit = image_.units[channel];
    if (const std::size_t f = contents_.fields.size(); f < image_.histograms.size()) field.histogram = image_.histograms[f];
    contents_.fields.push_back(field);
    channels_.push_back(found.channels);
  }
}

/// [m] Steps along i, j and k as columns; without a transformation in the file 1 micrometre.
Mat3 ZarrStore::steps_m(const ZarrLevel& level) const {
  const auto element = [&](std::size_t row, std::size_t column) {
    const std::size_t r = image_.axes.space[row], c = image_.axes.space[column];
    if (r == SIZE_MAX || c == SIZE_MAX) return 0.0;
    if (level.matrix.empty()) return row == column ? micrometre_m : 0.0;
    return level.matrix[r * image_.axes.rank + c] * axis_unit_m_[row];
  };
  Mat3 steps;
  for (std::size_t row = 0; row < 3; ++row) steps.row[row] = {element(row, 0), element(row, 1), element(row, 2)};
  if (image_.axes.space[2] == SIZE_MAX) {  // a slice
    const Mat3 columns = transposed(steps);
    steps.row[2].z = std::min(norm(columns.row[0]), norm(columns.row[1]));
  }
  return steps;
}

/// Whether an octave's voxels have steps that are `times` those of the finest, to rounding of sizes.
bool ZarrStore::has_steps_of(const ZarrLevel& level, const Mat3& finest, double times,
                             const std::array<std::int64_t, 3>& dims) const {
  if (level.matrix.empty()) return true;
  const Mat3 there = transposed(steps_m(level)), expected = times * transposed(finest);
  for (std::size_t a = 0; a < 3; ++a) {
    const double way_m = norm(there.row[a] - expected.row[a]);
    const bool is_one = contents_.octaves.empty() ? dims[a] == 1 : contents_.octaves.front().grid.dims[a] == 1;
    if (!is_one && !(way_m <= (1e-3 + 1.0 / static_cast<double>(dims[a])) * norm(expected.row[a]))) return false;
  }
  return true;
}

void ZarrStore::take_octaves() {
  const ZarrLevel& finest = image_.levels.front();
  bool has_unit = false;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::string& name = image_.axes.length_unit[a];
    const auto unit = detail::length_unit(name);
    if (!unit && !detail::leaves_length_unit_open(name))
      contents_.warnings.push_back("has lengths in " + detail::in_quotes(name) + ", an unknown unit");
    if (!unit) continue;
    axis_unit_m_[a] = unit->metres;
    if (!has_unit) contents_.length_unit = unit->name, unit_m_ = unit->metres;
    has_unit = true;
  }
  contents_.length_unit_assumed = !has_unit;
  if (!has_unit) contents_.length_unit = "um";
  if (finest.matrix.empty() && !image_.format.starts_with("Zarr"))
    contents_.warnings.push_back("says no distances of voxels: 1 µm is taken");
  if (image_.axes.time != SIZE_MAX && contents_.frames > 1 && !finest.matrix.empty())
    contents_.period_s = finest.matrix[image_.axes.time * (image_.axes.rank + 1)] * seconds_of(image_.axes.time_unit);
  const Mat3 steps = steps_m(finest);
  for (std::size_t n = 0; n < image_.levels.size(); ++n) {
    const ZarrLevel& level = image_.levels[n];
    StoreOctave octave;
    octave.grid.dims = in_space(image_.axes, level.array.shape);
    octave.chunk = in_space(image_.axes, level.array.chunk), octave.shard = in_space(image_.axes, level.array.shard);
    octave.codec = level.array.codec_words;
    const double times = std::ldexp(1.0, static_cast<int>(n));
    octave.grid.index_to_world_m = times * steps;
    double* const origin[] = {&octave.grid.origin_m.x, &octave.grid.origin_m.y, &octave.grid.origin_m.z};
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t index = image_.axes.space[a];
      if (index != SIZE_MAX && !level.translation.empty()) *origin[a] = level.translation[index] * axis_unit_m_[a];
    }
    const bool is_alike =
        level.array.type.delivered == finest.array.type.delivered &&
        length_along(level.array.shape, image_.axes.time) == length_along(finest.array.shape, image_.axes.time) &&
        length_along(level.array.shape, image_.axes.channel) == length_along(finest.array.shape, image_.axes.channel);
    bool is_half = has_steps_of(level, steps, times, octave.grid.dims);
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int64_t whole = contents_.octaves.empty() ? octave.grid.dims[a] : contents_.octaves.front().grid.dims[a];
      const double exact = static_cast<double>(whole) / times, there = static_cast<double>(octave.grid.dims[a]);
      is_half = is_half && there >= std::max(1.0, std::floor(exact)) && there <= std::ceil(exact);
    }
    if (!is_alike || !is_half) {
      contents_.warnings.push_back(
          "has an octave '" + level.array.path +
          "' that is no half of the one before, of the same type: " + "it and coarser ones are left out");
      break;
    }
    contents_.octaves.push_back(octave);
  }
  image_.levels.erase(image_.levels.begin() + static_cast<std::ptrdiff_t>(contents_.octaves.size()), image_.levels.end());
}

void ZarrStore::take_facts() {
  facts_.resize(contents_.octaves.size());
  for (std::size_t n = 0; n < facts_.size(); ++n) {
    StoreOctave& octave = contents_.octaves[n];
    const std::string path = joined_path(image_.folder, "palpa/facts/" + std::to_string(n));
    try {
      if (!folder_.has_json(joined_path(path, ".zarray")) && !folder_.has_json(joined_path(path, "zarr.json"))) continue;
      ZarrArray array = read_zarr_array(folder_, path, protocol::most_chunk_bytes);
      std::vector<std::int64_t> shape{contents_.frames, static_cast<std::int64_t>(contents_.fields.size())};
      for (std::size_t a = 3; a-- > 0;) shape.push_back((octave.grid.dims[a] + octave.chunk[a] - 1) / octave.chunk[a]);
      shape.push_back(4);
      std::array<std::int64_t, 3> u{};
      for (std::size_t a = 0; a < 3 && array.chunk.size() == 6; ++a) u[a] = array.chunk[4 - a];
      const bool is_of_chunks = array.shape == shape && array.chunk == std::vector<std::int64_t>{1, 1, u[2], u[1], u[0], 4} &&
                                *std::max_element(u.begin(), u.end()) <= protocol::most_facts_side &&
                                array.type.name == "float64" && array.stride.back() == 1;
      if (!is_of_chunks) throw LoadError("of another shape, or of another type than float64");
      octave.facts = u;
      facts_[n] = std::move(array);
    } catch (const LoadError& problem) {
      contents_.warnings.push_back("has facts in '" + path + "' that are not used: " + problem.what());
    }
  }
  contents_.prepared = contents_.octaves.front().facts[0] != 0;
}

std::uint64_t ZarrStore::scratch_bytes() const noexcept {
  std::uint64_t most = protocol::slot_bytes(contents_);
  for (const ZarrLevel& level : image_.levels) most = std::max(most, level.array.chunk_bytes());
  return 4 * most;  // a chunk, its bytes in the file, and their growth
}

ZarrStore::Place ZarrStore::place_of(const ZarrArray& array, const StoreChunk& chunk, std::int64_t channel) const {
  Place place;
  const auto set = [&](std::size_t index, std::int64_t number) {
    if (index == SIZE_MAX) return;
    place.at.at(index) = number / array.chunk[index];
    place.offset += number % array.chunk[index] * array.stride[index];
  };
  set(image_.axes.time, chunk.frame);
  set(image_.axes.channel, channel);
  for (std::size_t a = 0; a < 3; ++a) {
    if (image_.axes.space[a] != SIZE_MAX) place.at.at(image_.axes.space[a]) = chunk.at[a];
  }
  return place;
}

/// Whether a chunk of the file has the bytes of the delivered one.
bool ZarrStore::is_as_delivered(const ZarrArray& array, const StoreField& field) const {
  const auto dims = in_space(image_.axes, array.chunk), stride = in_space(image_.axes, array.stride, 0);
  if (field.components != 1 || array.type.half || array.type.swapped ||
      protocol::size_of(array.type.raw) != size_of(field.type))
    return false;
  std::uint64_t voxels = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    if (dims[a] > 1 && static_cast<std::uint64_t>(stride[a]) != voxels) return false;
    voxels *= static_cast<std::uint64_t>(dims[a]);
  }
  return voxels == array.chunk_numbers();
}

ZarrRead ZarrStore::read(const StoreChunk& chunk, std::span<std::byte> to, ZarrScratch& scratch) const {
  if (chunk.facts) return read_facts(chunk, to, scratch);
  if (chunk.presence) return look_for_chunks(chunk, to);
  const ZarrArray& array = image_.levels.at(static_cast<std::size_t>(chunk.octave)).array;
  const auto f = static_cast<std::size_t>(chunk.field);
  const StoreField& field = contents_.fields.at(f);
  if (is_as_delivered(array, field)) {
    const Place place = place_of(array, chunk, channels_[f].front());
    return chunks_.read(array, std::span(place.at).first(array.shape.size()), scratch.packed, to);
  }
  scratch.raw.resize(array.chunk_bytes());
  const Voxels3 voxels{in_space(image_.axes, array.chunk), in_space(image_.axes, array.stride, 0)};
  ZarrRead read;
  std::uint64_t bytes = 0;
  bool is_anywhere = false;
  for (int c = 0; c < field.components; ++c) {
    const Place place = place_of(array, chunk, channels_[f][static_cast<std::size_t>(c)]);
    const Place before = place_of(array, chunk, channels_[f][static_cast<std::size_t>(std::max(c - 1, 0))]);
    if (c == 0 || place.at != before.at) {
      read = chunks_.read(array, std::span(place.at).first(array.shape.size()), scratch.packed, scratch.raw);
      bytes += read.bytes;
    }
    if (read.state == ChunkState::damaged) return read;
    if (read.state == ChunkState::absent) {
      fill_component(field, to, c);
    } else {
      copy_component(array.type, scratch.raw.data(), place.offset, voxels, to.data(), field.components, c);
      is_anywhere = true;
    }
  }
  return {is_anywhere ? ChunkState::present : ChunkState::absent, bytes};
}

ZarrRead ZarrStore::read_facts(const StoreChunk& chunk, std::span<std::byte> to, ZarrScratch& scratch) const {
  const ZarrArray& array = facts_.at(static_cast<std::size_t>(chunk.octave));
  const std::array<std::int64_t, 6> at{chunk.frame, chunk.field, chunk.at[2], chunk.at[1], chunk.at[0], 0};
  scratch.raw.resize(array.chunk_bytes());
  ZarrRead read = chunks_.read(array, at, scratch.packed, scratch.raw);
  if (read.state != ChunkState::present) return read;
  const auto numbers = static_cast<std::int64_t>(array.chunk_numbers());
  copy_component(array.type, scratch.raw.data(), 0, {{numbers, 1, 1}, {1, 0, 0}}, to.data(), 1, 0);
  return read;
}

ZarrRead ZarrStore::look_for_chunks(const StoreChunk& of_facts, std::span<std::byte> to) const {
  const ZarrArray& array = image_.levels.at(static_cast<std::size_t>(of_facts.octave)).array;
  const StoreOctave& octave = contents_.octaves.at(static_cast<std::size_t>(of_facts.octave));
  ZarrChunks::KnownShards known;
  try {
    for (std::size_t n = 0; n < to.size(); ++n) {
      StoreChunk chunk = of_facts;
      auto rest = static_cast<std::int64_t>(n);
      bool is_there = true, is_present = false;
      for (std::size_t a = 0; a < 3; ++a) {
        chunk.at[a] = of_facts.at[a] * octave.facts[a] + rest % octave.facts[a];
        rest /= octave.facts[a];
        is_there = is_there && chunk.at[a] * octave.chunk[a] < octave.grid.dims[a];
      }
      for (const std::int64_t channel : channels_.at(static_cast<std::size_t>(chunk.field))) {
        if (!is_there || is_present) break;
        const Place place = place_of(array, chunk, channel);
        is_present = chunks_.has(array, std::span(place.at).first(array.shape.size()), known);
      }
      to[n] = static_cast<std::byte>(is_present);
    }
  } catch (const LoadError& problem) {
    return {ChunkState::damaged, 0, problem.what()};
  }
  return {ChunkState::present, to.size()};
}

std::vector<std::string> ZarrStore::metadata_files() const {
  std::vector<std::string> found;
  std::vector<std::string> folders{"", image_.folder};
  for (const ZarrLevel& level : image_.levels) folders.push_back(level.array.path);
  std::sort(folders.begin(), folders.end());
  folders.erase(std::unique(folders.begin(), folders.end()), folders.end());
  for (const std::string& folder : folders) {
    for (const char* name : {".zgroup", ".zattrs", ".zarray", "zarr.json"}) {
      if (const std::string path = joined_path(folder, name); folder_.has_json(path)) found.push_back(path);
    }
  }
  return found;
}

std::vector<std::string> ZarrStore::files_of(const StoreChunk& chunk) const {
  const ZarrArray& array = image_.levels.at(static_cast<std::size_t>(chunk.octave)).array;
  std::vector<std::string> files;
  for (const std::int64_t channel : channels_.at(static_cast<std::size_t>(chunk.field))) {
    Place place = place_of(array, chunk, channel);
    for (std::size_t n = 0; n < array.shape.size(); ++n) place.at[n] /= array.shard[n] / array.chunk[n];
    std::string name = array.file_of(std::span(place.at).first(array.shape.size()));
    if (std::ranges::find(files, name) == files.end()) files.push_back(std::move(name));
  }
  return files;
}

}  // namespace palpa::reader
