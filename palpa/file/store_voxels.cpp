#include "palpa/file/store_voxels.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "palpa/file/protocol_voxels.h"
#include "palpa/file/store_chunks.h"
#include "palpa/file/store_protocol.h"

namespace palpa::detail {
namespace {

/// Chunk of facts that holds those of a chunk, and their index in it.
std::pair<StoreChunk, std::size_t> place_of_facts(const StoreOctave& octave, const StoreChunk& chunk) {
  StoreChunk facts = chunk;
  facts.facts = true;
  std::array<std::int64_t, 3> within{};
  for (std::size_t a = 0; a < 3; ++a) {
    facts.at[a] = chunk.at[a] / octave.facts[a];
    within[a] = chunk.at[a] % octave.facts[a];
  }
  return {facts, static_cast<std::size_t>(within[0] + octave.facts[0] * (within[1] + octave.facts[1] * within[2]))};
}

/// CRC-32 of the voxels of a chunk that are within the octave.
double crc_of(const StoreOctave& octave, const StoreChunk& chunk, std::size_t voxel, const std::byte* content) {
  std::array<std::int64_t, 3> n{};
  for (std::size_t a = 0; a < 3; ++a) n[a] = std::min(octave.chunk[a], octave.grid.dims[a] - chunk.at[a] * octave.chunk[a]);
  uLong crc = ::crc32(0, nullptr, 0);
  for (std::int64_t k = 0; k < n[2]; ++k) {
    for (std::int64_t j = 0; j < n[1]; ++j) {
      const std::int64_t row = octave.chunk[0] * (j + octave.chunk[1] * k);
      crc = ::crc32_z(crc, reinterpret_cast<const Bytef*>(content + static_cast<std::size_t>(row) * voxel),
                      static_cast<std::size_t>(n[0]) * voxel);
    }
  }
  return static_cast<double>(crc);
}

}  // namespace

StoreCache::StoreCache(std::unique_ptr<StoreReader> reader, std::uint64_t most_bytes)
    : reader_(std::move(reader)), most_bytes_(most_bytes) {}

std::vector<StoreCache::Bytes> StoreCache::chunks(const std::vector<StoreChunk>& wanted) {
  const std::lock_guard lock(busy_);
  std::vector<StoreChunk> missing;
  for (const StoreChunk& chunk : wanted) {
    if (!kept_.contains(chunk)) missing.push_back(chunk);
  }
  read(missing);
  std::vector<Bytes> all;
  for (const StoreChunk& chunk : wanted) {
    Kept& kept = kept_.at(chunk);
    used_.splice(used_.begin(), used_, kept.place);
    all.push_back(kept.bytes);
  }
  for (auto last = used_.end(); bytes_ > most_bytes_ && used_.size() > wanted.size();) {
    --last;
    const auto found = kept_.find(*last);
    bytes_ -= found->second.bytes ? found->second.bytes->size() : 0;
    kept_.erase(found);
    last = used_.erase(last);
  }
  return all;
}

void StoreCache::read(const std::vector<StoreChunk>& missing) {
  if (missing.empty()) return;
  if (contents().prepared) read_facts(missing);
  read_chunks(*reader_, missing,
              [&](const StoreRead& read, std::span<const std::byte> content) { keep(read.chunk, checked(read, content)); });
}

void StoreCache::keep(const StoreChunk& chunk, Bytes bytes) {
  bytes_ += bytes ? bytes->size() : 0;
  used_.push_front(chunk);
  kept_.emplace(chunk, Kept{std::move(bytes), used_.begin()});
}

void StoreCache::read_facts(const std::vector<StoreChunk>& of) {
  constexpr std::size_t most_facts = 64;  // [chunks of facts] about a megabyte each
  if (facts_.size() > most_facts) facts_.clear();
  std::vector<StoreChunk> missing;
  for (const StoreChunk& chunk : of) {
    const StoreOctave& octave = contents().octaves[static_cast<std::size_t>(chunk.octave)];
    if (octave.facts[0] == 0) continue;
    const StoreChunk facts = place_of_facts(octave, chunk).first;
    if (!facts_.contains(facts) && std::ranges::find(missing, facts) == missing.end()) missing.push_back(facts);
  }
  read_chunks(*reader_, missing, [&](const StoreRead& read, std::span<const std::byte> content) {
    std::vector<ChunkFacts>& facts = facts_[read.chunk];
    facts.resize(content.size() / sizeof(ChunkFacts));
    if (!facts.empty()) std::memcpy(facts.data(), content.data(), facts.size() * sizeof(ChunkFacts));
  });
}

const ChunkFacts* StoreCache::facts_of(const StoreChunk& chunk) const {
  const StoreOctave& octave = contents().octaves[static_cast<std::size_t>(chunk.octave)];
  if (octave.facts[0] == 0) return nullptr;
  const auto [place, index] = place_of_facts(octave, chunk);
  const auto found = facts_.find(place);
  return found != facts_.end() && index < found->second.size() ? &found->second[index] : nullptr;
}

/// The copy of a chunk that is as it was prepared; null for others.
StoreCache::Bytes StoreCache::checked(const StoreRead& read, std::span<const std::byte> content) {
  if (read.state == ChunkState::damaged) return nullptr;
  const StoreOctave& octave = contents().octaves[static_cast<std::size_t>(read.chunk.octave)];
  const StoreField& field = contents().fields[static_cast<std::size_t>(read.chunk.field)];
  const Bytes bytes = read.state == ChunkState::absent
                          ? filled(read.chunk)
                          : std::make_shared<std::vector<std::byte>>(content.begin(), content.end());
  const ChunkFacts* facts = facts_of(read.chunk);
  const std::size_t voxel = size_of(field.type) * static_cast<std::size_t>(field.components);
  if (facts && crc_of(octave, read.chunk, voxel, bytes->data()) != facts->crc32) return nullptr;
  return bytes;
}

StoreCache::Bytes StoreCache::filled(const StoreChunk& chunk) const {
  const StoreField& field = contents().fields[static_cast<std::size_t>(chunk.field)];
  auto bytes = std::make_shared<std::vector<std::byte>>(protocol::content_bytes(contents(), chunk));
  protocol::with_type(field.type, [&](auto typed) {
    typed = static_cast<decltype(typed)>(field.fill);
    for (std::size_t at = 0; at + sizeof typed <= bytes->size(); at += sizeof typed)
      std::memcpy(bytes->data() + at, &typed, sizeof typed);
  });
  return bytes;
}

bool StoreVoxels::read(int octave, const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& dims,
                       std::byte* to) {
  const StoreContents& contents = cache_->contents();
  const StoreOctave& of = contents.octaves.at(static_cast<std::size_t>(octave));
  const StoreField& field = contents.fields.at(static_cast<std::size_t>(field_));
  const auto voxel = static_cast<std::int64_t>(size_of(field.type)) * field.components;
  std::array<std::int64_t, 3> begin{}, end{};
  for (std::size_t a = 0; a < 3; ++a) {
    begin[a] = first[a] / of.chunk[a];
    end[a] = (first[a] + dims[a] - 1) / of.chunk[a] + 1;
  }
  // A row of chunks at a time: large chunks of others would not fit into memory together.
  for (std::int64_t k = begin[2]; k < end[2]; ++k) {
    for (std::int64_t j = begin[1]; j < end[1]; ++j) {
      std::vector<StoreChunk> wanted;
      for (std::int64_t i = begin[0]; i < end[0]; ++i) wanted.push_back({octave, frame_, field_, false, {i, j, k}});
      const std::vector<StoreCache::Bytes> chunks = cache_->chunks(wanted);
      for (std::size_t n = 0; n < wanted.size(); ++n) {
        if (!chunks[n]) return false;
        std::int64_t low[3], high[3];
        for (std::size_t a = 0; a < 3; ++a) {
          low[a] = std::max(first[a], wanted[n].at[a] * of.chunk[a]);
          high[a] = std::min(first[a] + dims[a], (wanted[n].at[a] + 1) * of.chunk[a]);
        }
        for (std::int64_t z = low[2]; z < high[2]; ++z) {
          for (std::int64_t y = low[1]; y < high[1]; ++y) {
            const std::int64_t from = (low[0] - wanted[n].at[0] * of.chunk[0]) +
                                      of.chunk[0] * ((y - j * of.chunk[1]) + of.chunk[1] * (z - k * of.chunk[2]));
            const std::int64_t at = (low[0] - first[0]) + dims[0] * ((y - first[1]) + dims[1] * (z - first[2]));
            std::memcpy(to + at * voxel, chunks[n]->data() + from * voxel,
                        static_cast<std::size_t>((high[0] - low[0]) * voxel));
          }
        }
      }
    }
  }
  return true;
}

}  // namespace palpa::detail
