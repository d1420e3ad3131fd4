#include "palpa/file/store_voxels.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "palpa/base/load_error.h"
#include "palpa/base/printed.h"
#include "palpa/file/protocol_voxels.h"
#include "palpa/file/row_crc.h"
#include "palpa/file/store_chunks.h"
#include "palpa/file/store_protocol.h"

namespace palpa::detail {
namespace {

// [bytes] of chunks that are read together, so that their files are opened at once and no row of them is awaited before the
// next is requested. More: large chunks of others would not fit into memory; less: windows come late.
constexpr std::uint64_t most_bytes_at_once = 64'000'000;

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
std::uint32_t crc_of(const StoreOctave& octave, const StoreChunk& chunk, std::size_t voxel, const std::byte* content) {
  std::array<std::int64_t, 3> n{};
  for (std::size_t a = 0; a < 3; ++a) n[a] = std::min(octave.chunk[a], octave.grid.dims[a] - chunk.at[a] * octave.chunk[a]);
  RowCrc crc;
  for (std::int64_t k = 0; k < n[2]; ++k) {
    for (std::int64_t j = 0; j < n[1]; ++j) {
      const std::int64_t row = octave.chunk[0] * (j + octave.chunk[1] * k);
      crc.add(content + static_cast<std::size_t>(row) * voxel, static_cast<std::size_t>(n[0]) * voxel);
    }
  }
  return crc.value();
}

std::string name_of_chunk(const StoreChunk& chunk) {
  return text("chunk %lld, %lld, %lld of octave %d", static_cast<long long>(chunk.at[0]), static_cast<long long>(chunk.at[1]),
              static_cast<long long>(chunk.at[2]), chunk.octave);
}

}  // namespace

StoreCache::StoreCache(std::string name, std::unique_ptr<StoreReader> reader, Open open, std::uint64_t most_bytes)
    : name_(std::move(name)),
      reader_(std::move(reader)),
      contents_(reader_->contents()),
      open_(std::move(open)),
      most_bytes_(most_bytes) {}

std::vector<StoreCache::Bytes> StoreCache::chunks(const std::vector<StoreChunk>& wanted) {
  const std::lock_guard lock(busy_);
  read(wanted);
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

/// Reads the chunks that are not in memory, with a second reader if the first one ends.
void StoreCache::read(const std::vector<StoreChunk>& wanted) {
  try {
    read_missing(wanted);
  } catch (const LoadError&) {
    if (std::exchange(was_reopened_, true)) throw;
    reader_ = opened_again();
    read_missing(wanted);
  }
}

std::unique_ptr<StoreReader> StoreCache::opened_again() const {
  std::unique_ptr<StoreReader> reader = open_();
  if (reader->contents() != contents_) throw LoadError(name_ + ": has other metadata than when it was opened; load it again");
  return reader;
}

std::shared_ptr<StoreCache> StoreCache::beside(std::uint64_t most_bytes) const {
  return std::make_shared<StoreCache>(name_, opened_again(), open_, most_bytes);
}

void StoreCache::read_missing(const std::vector<StoreChunk>& wanted) {
  std::vector<StoreChunk> missing, absent;
  for (const StoreChunk& chunk : wanted) {
    if (!kept_.contains(chunk)) missing.push_back(chunk);
  }
  if (missing.empty()) return;
  if (contents_.prepared) read_facts(missing);
  read_chunks(*reader_, missing, [&](const StoreRead& read, std::span<const std::byte> content) {
    if (read.state == ChunkState::absent && !facts_of(read.chunk)) absent.push_back(read.chunk);
    keep(read.chunk, checked(read, content));
  });
  drop_lost(absent);
}

/// Of chunks that are absent, without facts that confirm it: those are lost at whose place the next octave has other values
/// than the fill value.
void StoreCache::drop_lost(const std::vector<StoreChunk>& absent) {
  for (const StoreChunk& chunk : absent) {
    if (is_filled_in_next_octave(chunk)) continue;
    Kept& kept = kept_.at(chunk);
    bytes_ -= kept.bytes ? kept.bytes->size() : 0;
    kept.bytes = refused(chunk, "is lost: the next octave has values there");
  }
}

bool StoreCache::is_filled_in_next_octave(const StoreChunk& chunk) {
  if (static_cast<std::size_t>(chunk.octave) + 1 >= contents_.octaves.size()) return true;
  const StoreOctave& octave = contents_.octaves[static_cast<std::size_t>(chunk.octave)];
  const StoreOctave& next = contents_.octaves[static_cast<std::size_t>(chunk.octave) + 1];
  std::array<std::int64_t, 3> low{}, end{};  // [voxels] in the next octave, of means of this chunk's voxels alone
  for (std::size_t a = 0; a < 3; ++a) {
    if (next.grid.dims[a] != (octave.grid.dims[a] + 1) / 2) return true;  // no means of this octave
    const std::int64_t last = std::min((chunk.at[a] + 1) * octave.chunk[a], octave.grid.dims[a]);
    low[a] = (chunk.at[a] * octave.chunk[a] + 1) / 2;
    end[a] = std::min((last == octave.grid.dims[a] ? last + 1 : last) / 2, next.grid.dims[a]);
    if (low[a] >= end[a]) return true;
  }
  std::vector<StoreChunk> above;
  StoreChunk one = chunk;
  ++one.octave;
  for (one.at[2] = low[2] / next.chunk[2]; one.at[2] * next.chunk[2] < end[2]; ++one.at[2])
    for (one.at[1] = low[1] / next.chunk[1]; one.at[1] * next.chunk[1] < end[1]; ++one.at[1])
      for (one.at[0] = low[0] / next.chunk[0]; one.at[0] * next.chunk[0] < end[0]; ++one.at[0]) above.push_back(one);
  read_missing(above);
  const Bytes fill = filled(chunk);
  const StoreField& field = contents_.fields[static_cast<std::size_t>(chunk.field)];
  const std::size_t voxel = size_of(field.type) * static_cast<std::size_t>(field.components);
  for (const StoreChunk& part : above) {
    const Bytes& bytes = kept_.at(part).bytes;
    if (!bytes) continue;
    std::array<std::int64_t, 3> from{}, to{};
    for (std::size_t a = 0; a < 3; ++a) {
      from[a] = std::max(low[a], part.at[a] * next.chunk[a]) - part.at[a] * next.chunk[a];
      to[a] = std::min(end[a], (part.at[a] + 1) * next.chunk[a]) - part.at[a] * next.chunk[a];
    }
    for (std::int64_t k = from[2]; k < to[2]; ++k)
      for (std::int64_t j = from[1]; j < to[1]; ++j)
        for (std::int64_t i = from[0]; i < to[0]; ++i) {
          const std::int64_t at = i + next.chunk[0] * (j + next.chunk[1] * k);
          if (std::memcmp(bytes->data() + static_cast<std::size_t>(at) * voxel, fill->data(), voxel) != 0) return false;
        }
  }
  return true;
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

/// The copy of a chunk that is as it was prepared, and as it was read before; null for others.
StoreCache::Bytes StoreCache::checked(const StoreRead& read, std::span<const std::byte> content) {
  if (read.state == ChunkState::damaged) return refused(read.chunk, "is damaged: " + read.sentence);
  const StoreOctave& octave = contents().octaves[static_cast<std::size_t>(read.chunk.octave)];
  const StoreField& field = contents().fields[static_cast<std::size_t>(read.chunk.field)];
  const Bytes bytes = read.state == ChunkState::absent
                          ? filled(read.chunk)
                          : std::make_shared<std::vector<std::byte>>(content.begin(), content.end());
  const ChunkFacts* facts = facts_of(read.chunk);
  const std::size_t voxel = size_of(field.type) * static_cast<std::size_t>(field.components);
  const std::uint32_t crc32 = crc_of(octave, read.chunk, voxel, bytes->data());
  if (facts && crc32 != facts->crc32) {
    const bool is_absent = read.state == ChunkState::absent;
    return refused(read.chunk, is_absent ? "is lost: it was there when the store was prepared"
                                         : "is not as it was when the store was prepared");
  }
  if (!is_as_before(read.chunk, crc32)) return refused(read.chunk, "has changed since it was read first");
  return bytes;
}

/// Null, with a sentence about the chunk.
StoreCache::Bytes StoreCache::refused(const StoreChunk& chunk, const std::string& reason) {
  constexpr std::size_t most_problems = 16;
  const std::string sentence = name_ + ": " + name_of_chunk(chunk) + " " + reason + "; coarser octaves are felt there";
  const std::lock_guard lock(sums_busy_);
  if (problems_.size() < most_problems && std::ranges::find(problems_, sentence) == problems_.end())
    problems_.push_back(sentence);
  return nullptr;
}

/// Whether a chunk has the checksum of its first reading. Throws LoadError where a recording has another one.
bool StoreCache::is_as_before(const StoreChunk& chunk, std::uint32_t crc32) {
  const std::lock_guard lock(sums_busy_);
  const auto [first, is_new] = first_sums_.emplace(chunk, crc32);
  if (is_new) sums_[{chunk.field, chunk.frame}].push_back({chunk.octave, chunk.at, crc32});
  if (first->second == crc32) return true;
  if (!expects_) return false;
  refuse_recorded(chunk);
}

void StoreCache::refuse_recorded(const StoreChunk& chunk) const {
  throw LoadError(name_ + ": has another " + name_of_chunk(chunk) +
                  " than when the trace was recorded; a replay needs the recorded data");
}

std::vector<ChunkSum> StoreCache::sums_from(std::int32_t field, std::int32_t frame, std::size_t from) const {
  const std::lock_guard lock(sums_busy_);
  const auto found = sums_.find({field, frame});
  if (found == sums_.end()) return {};
  const std::vector<ChunkSum>& all = found->second;
  return {all.begin() + static_cast<std::ptrdiff_t>(std::min(from, all.size())), all.end()};
}

void StoreCache::expect(std::int32_t field, std::int32_t frame, const std::vector<ChunkSum>& sums) {
  const std::lock_guard lock(busy_), sums_lock(sums_busy_);
  expects_ = true;
  for (const ChunkSum& sum : sums) {
    const StoreChunk chunk{sum.octave, frame, field, false, sum.at};
    const auto [first, is_new] = first_sums_.emplace(chunk, sum.crc32);
    if (!is_new && first->second != sum.crc32) refuse_recorded(chunk);
  }
}

std::vector<std::string> StoreCache::problems_from(std::size_t from) const {
  const std::lock_guard lock(sums_busy_);
  return {problems_.begin() + static_cast<std::ptrdiff_t>(std::min(from, problems_.size())), problems_.end()};
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

std::shared_ptr<VoxelSource> StoreVoxels::beside() const {
  constexpr std::uint64_t most_bytes = 64'000'000;  // of chunks that neighbouring parts of a picture share
  return std::make_shared<StoreVoxels>(cache_->beside(most_bytes), field_, frame_);
}

bool StoreVoxels::read(int octave, const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& dims,
                       std::byte* to) {
  const StoreContents& contents = cache_->contents();
  const StoreOctave& of = contents.octaves.at(static_cast<std::size_t>(octave));
  std::array<std::int64_t, 3> begin{}, end{};
  for (std::size_t a = 0; a < 3; ++a) {
    begin[a] = first[a] / of.chunk[a];
    end[a] = (first[a] + dims[a] - 1) / of.chunk[a] + 1;
  }
  const VoxelBox box{first, dims};
  std::vector<StoreChunk> wanted;
  std::uint64_t bytes = 0;
  for (std::int64_t k = begin[2]; k < end[2]; ++k) {
    for (std::int64_t j = begin[1]; j < end[1]; ++j) {
      for (std::int64_t i = begin[0]; i < end[0]; ++i) {
        wanted.push_back({octave, frame_, field_, false, {i, j, k}});
        bytes += protocol::content_bytes(contents, wanted.back());
      }
      const bool is_last = k + 1 == end[2] && j + 1 == end[1];
      if (bytes < most_bytes_at_once && !is_last) continue;
      if (!copy_chunks(wanted, box, to)) return false;
      wanted.clear(), bytes = 0;
    }
  }
  return true;
}

/// Copies the part of chunks that is within a box. False if one of them has no voxels.
bool StoreVoxels::copy_chunks(const std::vector<StoreChunk>& wanted, const VoxelBox& box, std::byte* to) {
  const StoreContents& contents = cache_->contents();
  const StoreField& field = contents.fields.at(static_cast<std::size_t>(field_));
  const auto voxel = static_cast<std::int64_t>(size_of(field.type)) * field.components;
  const std::vector<StoreCache::Bytes> chunks = cache_->chunks(wanted);
  for (std::size_t n = 0; n < wanted.size(); ++n) {
    if (!chunks[n]) return false;
    const std::array<std::int64_t, 3>& chunk = contents.octaves.at(static_cast<std::size_t>(wanted[n].octave)).chunk;
    std::int64_t origin[3], low[3], high[3];
    for (std::size_t a = 0; a < 3; ++a) {
      origin[a] = wanted[n].at[a] * chunk[a];
      low[a] = std::max(box.first[a], origin[a]);
      high[a] = std::min(box.first[a] + box.count[a], origin[a] + chunk[a]);
    }
    for (std::int64_t z = low[2]; z < high[2]; ++z) {
      for (std::int64_t y = low[1]; y < high[1]; ++y) {
        const std::int64_t from = (low[0] - origin[0]) + chunk[0] * ((y - origin[1]) + chunk[1] * (z - origin[2]));
        const std::int64_t at =
            (low[0] - box.first[0]) + box.count[0] * ((y - box.first[1]) + box.count[1] * (z - box.first[2]));
        std::memcpy(to + at * voxel, chunks[n]->data() + from * voxel, static_cast<std::size_t>((high[0] - low[0]) * voxel));
      }
    }
  }
  return true;
}

}  // namespace palpa::detail
