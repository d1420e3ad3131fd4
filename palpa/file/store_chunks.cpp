#include "palpa/file/store_chunks.h"

#include <algorithm>
#include <cstring>

#include "palpa/file/protocol_voxels.h"

namespace palpa {
namespace {

/// [s] More: a hung program is noticed by the reader all the same; less: more wake-ups.
constexpr double patience_s = 1.0;

}  // namespace

void read_chunks(StoreReader& reader, std::span<const StoreChunk> chunks,
                 const std::function<void(const StoreRead&, std::span<const std::byte>)>& use,
                 const std::function<bool()>& go_on) {
  std::size_t next = 0;
  int pending = 0;
  const auto request_into = [&](int slot) {
    if (next == chunks.size() || (go_on && !go_on())) return;
    reader.request(chunks[next], slot);
    ++next, ++pending;
  };
  for (int slot = 0; slot < reader.slots(); ++slot) request_into(slot);
  while (pending > 0) {
    const std::optional<StoreRead> read = reader.next(patience_s);
    if (!read) continue;
    --pending;
    use(*read, read->state == ChunkState::present ? reader.content(read->slot) : std::span<const std::byte>());
    request_into(read->slot);
  }
}

std::array<std::int64_t, 3> chunks_along(const StoreOctave& octave) noexcept {
  std::array<std::int64_t, 3> count{};
  for (std::size_t a = 0; a < 3; ++a) count[a] = (octave.grid.dims[a] + octave.chunk[a] - 1) / octave.chunk[a];
  return count;
}

std::vector<double> numbers_in(const StoreField& field, std::span<const std::byte> content) {
  std::vector<double> numbers(content.size() / size_of(field.type));
  protocol::with_type(field.type, [&](auto typed) {
    for (std::size_t n = 0; n < numbers.size(); ++n) {
      std::memcpy(&typed, &content[n * sizeof typed], sizeof typed);
      numbers[n] = static_cast<double>(typed);
    }
  });
  return numbers;
}

std::optional<std::vector<double>> voxels_in(StoreReader& reader, const StoreChunk& place, const VoxelBox& box) {
  const StoreContents& contents = reader.contents();
  const StoreOctave& octave = contents.octaves.at(static_cast<std::size_t>(place.octave));
  const StoreField& field = contents.fields.at(static_cast<std::size_t>(place.field));
  std::vector<double> voxels(static_cast<std::size_t>(box.voxels()), field.fill);
  std::vector<StoreChunk> chunks;
  std::array<std::int64_t, 3> begin{}, end{};
  for (std::size_t a = 0; a < 3; ++a)
    begin[a] = box.first[a] / octave.chunk[a], end[a] = (box.first[a] + box.count[a] - 1) / octave.chunk[a] + 1;
  StoreChunk chunk = place;
  for (chunk.at[2] = begin[2]; chunk.at[2] < end[2]; ++chunk.at[2])
    for (chunk.at[1] = begin[1]; chunk.at[1] < end[1]; ++chunk.at[1])
      for (chunk.at[0] = begin[0]; chunk.at[0] < end[0]; ++chunk.at[0]) chunks.push_back(chunk);
  bool is_sound = true;
  read_chunks(reader, chunks, [&](const StoreRead& read, std::span<const std::byte> content) {
    is_sound = is_sound && read.state != ChunkState::damaged;
    if (read.state != ChunkState::present) return;
    std::array<std::int64_t, 3> from{}, to{};  // of the box, in this chunk
    for (std::size_t a = 0; a < 3; ++a) {
      from[a] = std::max(box.first[a], read.chunk.at[a] * octave.chunk[a]);
      to[a] = std::min(box.first[a] + box.count[a], (read.chunk.at[a] + 1) * octave.chunk[a]);
    }
    protocol::with_type(field.type, [&](auto typed) {
      const std::size_t voxel_bytes = sizeof typed * static_cast<std::size_t>(field.components);
      const auto in_chunk = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        const auto& c = octave.chunk;
        return static_cast<std::size_t>(((k % c[2]) * c[1] + j % c[1]) * c[0] + i % c[0]) * voxel_bytes;
      };
      for (std::int64_t k = from[2]; k < to[2]; ++k)
        for (std::int64_t j = from[1]; j < to[1]; ++j)
          for (std::int64_t i = from[0]; i < to[0]; ++i) {
            std::memcpy(&typed, &content[in_chunk(i, j, k)], sizeof typed);
            const std::int64_t at = ((k - box.first[2]) * box.count[1] + j - box.first[1]) * box.count[0] + i - box.first[0];
            voxels[static_cast<std::size_t>(at)] = static_cast<double>(typed);
          }
    });
  });
  if (!is_sound) return std::nullopt;
  return voxels;
}

}  // namespace palpa
