#include "zarr_chunks.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "zarr_codec.h"

namespace palpa::reader {
namespace {

/// Of indices that are kept. More: more memory; less: indices are read again.
constexpr std::uint64_t most_kept_bytes = std::uint64_t{64} << 20;
constexpr std::uint64_t piece_bytes = 16;
constexpr std::uint64_t absent = UINT64_MAX;

/// Little-endian number.
std::uint64_t number_at(const std::byte* bytes) noexcept {
  std::uint64_t number = 0;
  for (unsigned n = 0; n < 8; ++n) number |= static_cast<std::uint64_t>(bytes[n]) << (8 * n);
  return number;
}

/// [bytes] Of a shard's index.
std::uint64_t index_bytes(const ZarrArray& array) noexcept {
  return array.chunks_in_file() * piece_bytes + (array.index_has_checksum ? 4 : 0);
}

}  // namespace

std::shared_ptr<const ZarrChunks::ShardIndex> ZarrChunks::index_of(const ZarrArray& array, const std::string& name,
                                                                   const ZarrFile& file) const {
  const std::timespec changed = file.changed();
  const auto is_of_file = [&](const std::shared_ptr<const ShardIndex>& index) {
    return index->file == name && index->bytes == file.bytes() && index->changed.tv_sec == changed.tv_sec &&
           index->changed.tv_nsec == changed.tv_nsec;
  };
  {
    const std::scoped_lock lock(mutex_);
    if (const auto found = std::ranges::find_if(indices_, is_of_file); found != indices_.end()) {
      indices_.splice(indices_.begin(), indices_, found);
      return indices_.front();
    }
  }
  const std::uint64_t chunks = array.chunks_in_file(), bytes = index_bytes(array);
  if (file.bytes() < bytes) throw LoadError("'" + name + "': is shorter than its index");
  std::vector<std::byte> stored(bytes), plain(chunks * piece_bytes);
  if (file.read(array.index_at_end ? file.bytes() - bytes : 0, stored.data(), bytes) != bytes)
    throw LoadError("'" + name + "': was cut short while it was read");
  const std::vector<ZarrCodec> codecs(array.index_has_checksum ? 1 : 0, ZarrCodec::crc32c);
  if (const std::string fault = decode_chunk(codecs, stored, plain); !fault.empty())
    throw LoadError("'" + name + "': its index " + fault);
  auto made = std::make_shared<ShardIndex>();
  made->file = name, made->bytes = file.bytes(), made->changed = changed;
  made->pieces.resize(chunks);
  for (std::size_t n = 0; n < chunks; ++n)
    made->pieces[n] = {number_at(&plain[n * piece_bytes]), number_at(&plain[n * piece_bytes + 8])};
  const std::scoped_lock lock(mutex_);
  std::erase_if(indices_, [&](const auto& index) { return index->file == name; });
  indices_.push_front(made);
  std::uint64_t kept_bytes = 0;
  for (auto index = indices_.begin(); index != indices_.end();) {
    kept_bytes += (*index)->pieces.size() * sizeof(Piece);
    index = index != indices_.begin() && kept_bytes > most_kept_bytes ? indices_.erase(index) : std::next(index);
  }
  return made;
}

std::shared_ptr<const ZarrFile> ZarrChunks::opened(const ZarrArray& array, const std::string& name) const {
  if (array.has_shards) return folder_.open_in_parts(name, index_bytes(array), array.index_at_end);
  return folder_.open(name, most_packed_bytes(array.chunk_bytes()));
}

std::string ZarrChunks::file_of(const ZarrArray& array, std::span<const std::int64_t> at) {
  std::array<std::int64_t, 8> of_file{};
  for (std::size_t n = 0; n < at.size(); ++n) of_file.at(n) = at[n] / (array.shard[n] / array.chunk[n]);
  return array.file_of(std::span(of_file).first(at.size()));
}

/// Number of a chunk within its shard.
std::size_t ZarrChunks::position_of(const ZarrArray& array, std::span<const std::int64_t> at) noexcept {
  std::int64_t position = 0;
  for (std::size_t n = 0; n < at.size(); ++n) {
    const std::int64_t in_file = array.shard[n] / array.chunk[n];
    position = position * in_file + at[n] % in_file;
  }
  return static_cast<std::size_t>(position);
}

bool ZarrChunks::has(const ZarrArray& array, std::span<const std::int64_t> at, KnownShards& known) const {
  const std::string name = file_of(array, at);
  if (!array.has_shards) return folder_.has(name);
  const auto [shard, is_new] = known.try_emplace(name);
  if (is_new) {
    const auto file = opened(array, name);
    if (file) shard->second = index_of(array, name, *file);
  }
  if (!shard->second) return false;
  const Piece piece = shard->second->pieces.at(position_of(array, at));
  return piece.offset != absent || piece.bytes != absent;
}

ZarrChunks::Piece ZarrChunks::piece_of(const ZarrArray& array, std::span<const std::int64_t> at, const std::string& name,
                                       const ZarrFile& file) const {
  if (!array.has_shards) return {0, file.bytes()};
  const Piece piece = index_of(array, name, file)->pieces.at(position_of(array, at));
  if (piece.offset == absent && piece.bytes == absent) return {absent, absent};
  if (piece.bytes > file.bytes() || piece.offset > file.bytes() - piece.bytes)
    throw LoadError("'" + name + "': its index points beyond its end");
  return piece;
}

ZarrRead ZarrChunks::read(const ZarrArray& array, std::span<const std::int64_t> at, std::vector<std::byte>& packed,
                          std::span<std::byte> to) const {
  const std::string name = file_of(array, at);
  try {
    const auto file = opened(array, name);
    if (!file) return {ChunkState::absent};
    const Piece piece = piece_of(array, at, name, *file);
    if (piece.bytes == absent) return {ChunkState::absent};
    if (piece.bytes > most_packed_bytes(to.size()))
      return {ChunkState::damaged, 0, "'" + name + "': is longer than any chunk of " + std::to_string(to.size()) + " bytes"};
    packed.resize(static_cast<std::size_t>(piece.bytes));
    if (file->read(piece.offset, packed.data(), packed.size()) != packed.size())
      return {ChunkState::damaged, 0, "'" + name + "': was cut short while it was read"};
    std::string fault = decode_chunk(array.codecs, packed, to);
    if (!fault.empty()) return {ChunkState::damaged, piece.bytes, "'" + name + "': " + fault};
    return {ChunkState::present, piece.bytes};
  } catch (const LoadError& problem) {
    return {ChunkState::damaged, 0, problem.what()};
  }
}

}  // namespace palpa::reader
