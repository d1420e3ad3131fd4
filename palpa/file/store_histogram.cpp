#include "palpa/file/store_histogram.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <type_traits>

#include "palpa/base/load_error.h"
#include "palpa/file/protocol_voxels.h"
#include "palpa/file/store_chunks.h"

namespace palpa::detail {
namespace {

constexpr int most_classes = 256;

Histogram classes_of(const StoreField& field, double low, double high) {
  const bool is_whole = field.type != VoxelType::float32 && field.type != VoxelType::float64;
  Histogram classes;
  if (field.components == 3) {
    classes.high = std::numbers::sqrt3 * std::max(std::abs(low), std::abs(high));
  } else if (is_whole && high - low < most_classes) {
    classes.low = low - 0.5, classes.high = high + 0.5;
  } else {
    classes.low = low, classes.high = high;
  }
  const double width = classes.high - classes.low;
  classes.counts.resize(is_whole && field.components == 1 ? static_cast<std::size_t>(std::clamp(width, 1.0, 256.0))
                                                          : std::size_t{most_classes});
  return classes;
}

std::vector<StoreChunk> chunks_of(const StoreContents& contents, int field) {
  const auto along = chunks_along(contents.octaves.front());
  const std::int64_t in_frame = along[0] * along[1] * along[2], all = in_frame * contents.frames;
  const std::int64_t count = std::min(all, most_histogram_chunks);
  std::vector<StoreChunk> chunks;
  for (std::int64_t n = 0; n < count; ++n) {
    const std::int64_t at = all / count * n + all % count * n / count, in = at % in_frame;
    chunks.push_back({.frame = static_cast<std::int32_t>(at / in_frame),
                      .field = field,
                      .at = {in % along[0], in / along[0] % along[1], in / along[0] / along[1]}});
  }
  return chunks;
}

/// Adds the voxels of a chunk within the octave. \param voxels  none: all have the fill value
template <class T>
void add(const StoreOctave& octave, const StoreField& field, const StoreChunk& chunk, std::span<const std::byte> voxels,
         Histogram& to) {
  const double per_class = static_cast<double>(to.counts.size()) / std::max(to.high - to.low, 1e-300);
  const int c = field.components;
  std::array<std::int64_t, 3> valid{};
  for (std::size_t a = 0; a < 3; ++a) valid[a] = std::min(octave.chunk[a], octave.grid.dims[a] - chunk.at[a] * octave.chunk[a]);
  for (std::int64_t k = 0; k < valid[2]; ++k)
    for (std::int64_t j = 0; j < valid[1]; ++j) {
      const auto first = static_cast<std::size_t>((k * octave.chunk[1] + j) * octave.chunk[0] * c);
      for (std::int64_t i = 0; i < valid[0]; ++i) {
        T parts[3] = {static_cast<T>(field.fill), static_cast<T>(field.fill), static_cast<T>(field.fill)};
        if (!voxels.empty())
          std::memcpy(parts, voxels.data() + (first + static_cast<std::size_t>(i * c)) * sizeof(T),
                      static_cast<std::size_t>(c) * sizeof(T));
        double value = static_cast<double>(parts[0]);
        if (c == 3) value = std::hypot(value, static_cast<double>(parts[1]), static_cast<double>(parts[2]));
        if (!std::isfinite(value)) continue;
        const double at = std::clamp((value - to.low) * per_class, 0.0, static_cast<double>(to.counts.size() - 1));
        ++to.counts[static_cast<std::size_t>(at)];
      }
    }
}

}  // namespace

Histogram store_histogram(StoreReader& reader, int field, double low, double high, const std::function<bool()>& go_on) {
  const StoreContents& contents = reader.contents();
  const StoreOctave& octave = contents.octaves.front();
  const StoreField& of = contents.fields.at(static_cast<std::size_t>(field));
  Histogram histogram = classes_of(of, low, high);
  read_chunks(
      reader, chunks_of(contents, field),
      [&](const StoreRead& read, std::span<const std::byte> voxels) {
        if (read.state == ChunkState::damaged) throw LoadError("octave 0 has a damaged chunk (" + read.sentence + ")");
        protocol::with_type(of.type, [&](auto number) { add<decltype(number)>(octave, of, read.chunk, voxels, histogram); });
      },
      go_on);
  return histogram;
}

}  // namespace palpa::detail
