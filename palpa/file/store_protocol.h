// Messages between StoreReader and palpa-read-zarr, which serves chunks of a store as long as its caller lives.
#pragma once

#include <cstdint>
#include <filesystem>

#include "palpa/file/packer.h"
#include "palpa/file/protocol.h"
#include "palpa/file/store_contents.h"

/// Sequence over the socket of protocol.h:
///
///     caller                              palpa-read-zarr
///     Request (store = true)         ──►
///                                    ◄──  StoreContents                      or Failure
///     StoreRoom (slots, + memory)    ──►
///     ChunkRequest …                 ──►
///                                    ◄──  ChunkAnswer …, in any order        or Failure, and the end
///
/// The program ends with its caller's end of the socket. A file of another format whose header permits it (`reads_rows`)
/// gives rows of its slices as chunks, in the order of the requests:
///
///     Request (rows = true)          ──►
///                                    ◄──  Header                             or Failure
///     StoreRoom, ChunkRequest …      ──►
///                                    ◄──  ChunkAnswer …                      or Failure, and the end
///
/// A store at a web address is fetched by a third program, the only one with a network. The caller starts it, sends it the
/// address, and gives its own end of their socket to palpa-read-zarr, with the Request:
///
///     caller, palpa-read-zarr             palpa-fetch
///     Request (path: the address)    ──►
///     FetchRequest …                 ──►
///                                    ◄──  FetchAnswer …, in any order (+ memory)
namespace palpa::protocol {

// Limits of a store, checked at both ends. More of any: hostile metadata take more memory or time; less: sound stores are
// refused.
inline constexpr std::size_t most_octaves = 24;
inline constexpr std::size_t most_store_fields = 256;
inline constexpr std::int64_t most_side_voxels = std::int64_t{1} << 18;
inline constexpr std::uint64_t most_chunk_bytes = std::uint64_t{32} << 20;  ///< of the file, and of delivered voxels
inline constexpr std::int64_t most_facts_side = 64;                         ///< [chunks] of a chunk of facts
inline constexpr std::int32_t most_slots = 1 << 16;
inline constexpr std::size_t most_histogram_classes = 256, most_histograms = 32;  ///< in a message
// A file that is fetched. Longer: a dead server holds windows up; shorter: slow ones lose chunks.
inline constexpr double longest_fetch_s = 60.0;
// [bytes] Of a file with several chunks that comes as a whole, as its server gives no parts. More: time and memory for one
// chunk; less: small shards are refused.
inline constexpr std::uint64_t most_whole_file_bytes = std::uint64_t{64} << 20;
inline constexpr std::int64_t most_counted = std::int64_t{1} << 50;  ///< [voxels] of a class

/// Whether a path is a folder with metadata of Zarr: .zarray, .zgroup, .zattrs or zarr.json; or a web address, where nothing
/// else is read. Parses nothing, fetches nothing; any thread.
bool is_store(const std::filesystem::path& path);

/// Fault of a store's content, as a half sentence; nullptr if valid. Allocates nothing; any thread.
const char* problem_with(const StoreContents& contents) noexcept;
/// Whether a store has a place for this chunk, present or absent. `contents` must be valid. Allocates nothing; any thread.
bool has_place(const StoreContents& contents, const StoreChunk& chunk) noexcept;
/// [bytes] of a chunk's content in a slot; the chunk must have a place. Allocates nothing; any thread.
std::uint64_t content_bytes(const StoreContents& contents, const StoreChunk& chunk) noexcept;
/// [bytes] of a slot that holds any chunk of a valid store: a multiple of the page size. Allocates nothing; any thread.
std::uint64_t slot_bytes(const StoreContents& contents) noexcept;

/// Content of a file that is read by rows: a chunk is some megabytes of rows of a slice. Fields without one grid, or with more
/// voxels than a store may have: no octaves. Allocates; any thread.
StoreContents contents_by_rows(const Header& header);

// For protocol.cpp.
void pack(Packer& to, const StoreContents& m);
void unpack(Unpacker& from, StoreContents& m);
void pack(Packer& to, const StoreRoom& m);
void unpack(Unpacker& from, StoreRoom& m);
void pack(Packer& to, const ChunkRequest& m);
void unpack(Unpacker& from, ChunkRequest& m);
void pack(Packer& to, const ChunkAnswer& m);
void unpack(Unpacker& from, ChunkAnswer& m);
void pack(Packer& to, const FetchRequest& m);
void unpack(Unpacker& from, FetchRequest& m);
void pack(Packer& to, const FetchAnswer& m);
void unpack(Unpacker& from, FetchAnswer& m);

}  // namespace palpa::protocol
