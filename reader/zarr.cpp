// OME-Zarr and plain Zarr arrays, versions 2 and 3: octave 0 as any volume, or all chunks one by one.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <future>
#include <set>

#include "palpa/base/web_address.h"
#include "palpa/file/store_protocol.h"
#include "source.h"
#include "zarr_serve.h"
#include "zarr_store.h"

namespace palpa::reader {
namespace {

/// Chunk of a volume that is read as a whole. More: a codec cannot; less: sound arrays of one chunk are refused.
constexpr std::uint64_t most_chunk_bytes_of_whole = std::uint64_t{1} << 30;

/// Threads that read a store as a whole by a network. More: memory; fewer: round trips add up.
constexpr std::uint64_t most_readers = 32, most_bytes_of_readers = 256'000'000, reader_stack_bytes = std::uint64_t{8} << 20;

class ZarrSource final : public Source {
 public:
  explicit ZarrSource(const protocol::Request& request)
      : store_(request.path,
               request.store ? protocol::most_chunk_bytes : std::min(most_chunk_bytes_of_whole, request.max_bytes),
               is_web_address(request.path) ? request.memory : -1),
        folder_(request.path) {
    const StoreContents& contents = store_.contents();
    if (request.store) {
      if (const char* problem = protocol::problem_with(contents))
        throw LoadError(std::string(problem) + "; write the store again, or convert it by palpa convert");
      return;
    }
    header.format = "zarr";
    header.warnings = contents.warnings;
    header.length_unit = contents.length_unit_assumed ? "" : contents.length_unit;
    header.default_unit = "um";
    header.named = store_.names_fields();
    header.working_bytes = store_.scratch_bytes();
    first_ = choose_frames(request, contents.frames);
    const GridGeometry& grid = contents.octaves.front().grid;
    for (const StoreField& of : contents.fields) {
      protocol::FieldHeader field;
      field.name = of.name, field.unit = of.unit, field.type = of.type, field.components = of.components;
      field.grid = {grid.dims, (1.0 / store_.unit_m()) * grid.index_to_world_m, (1.0 / store_.unit_m()) * grid.origin_m};
      header.fields.push_back(field);
    }
    check_count();
    if (store_.is_fetched()) {
      readers_ = std::clamp<std::uint64_t>(most_bytes_of_readers / store_.scratch_bytes(), 1, most_readers);
      header.working_bytes = readers_ * (reader_stack_bytes + store_.scratch_bytes());
      return;  // the caller names the address
    }
    for (const std::string& file : store_.metadata_files()) files.push_back(folder_ + "/" + file);
    list_files();
  }

  void serve_chunks(int socket) override { serve_store(socket, store_); }

  void read(const std::vector<std::uint32_t>& wanted, const std::vector<std::byte*>& to) override {
    for (std::size_t n = 0; n < to.size(); ++n) {
      const std::uint32_t field = wanted[n % wanted.size()];
      read_field(field, static_cast<std::int64_t>(n / wanted.size()), to[n]);
    }
    if (absent_ > 0)
      warnings.push_back("lacks " + std::to_string(absent_) + " of " + std::to_string(absent_ + present_) +
                         " chunks, which have the fill value");
  }

 private:
  /// Calls `use` with each chunk of octave 0 of a frame and field.
  template <class Use>
  void for_each_chunk(std::uint32_t field, std::int64_t frame, const Use& use) const {
    const StoreOctave& octave = store_.contents().octaves.front();
    StoreChunk chunk{.frame = static_cast<std::int32_t>(first_ + frame), .field = static_cast<std::int32_t>(field)};
    std::array<std::int64_t, 3> count{};
    for (std::size_t a = 0; a < 3; ++a) count[a] = (octave.grid.dims[a] + octave.chunk[a] - 1) / octave.chunk[a];
    for (chunk.at[2] = 0; chunk.at[2] < count[2]; ++chunk.at[2])
      for (chunk.at[1] = 0; chunk.at[1] < count[1]; ++chunk.at[1])
        for (chunk.at[0] = 0; chunk.at[0] < count[0]; ++chunk.at[0]) use(chunk);
  }

  /// Refuses more chunks than are read one after the other in a minute. Throws LoadError.
  void check_count() const {
    const StoreOctave& octave = store_.contents().octaves.front();
    double chunks = static_cast<double>(header.fields.size()) * static_cast<double>(frames_read);
    for (std::size_t a = 0; a < 3; ++a)
      chunks *= std::ceil(static_cast<double>(octave.grid.dims[a]) / static_cast<double>(octave.chunk[a]));
    if (chunks > most_chunks)
      throw LoadError(
          "has more chunks than are read into memory as one volume, which is a million; give a coarser octave of it, as "
          "STORE/2");
  }

  /// Adds the files of all chunks that are there.
  void list_files() {
    std::set<std::string> listed;
    for (std::uint32_t field = 0; field < header.fields.size(); ++field) {
      for (std::int64_t frame = 0; frame < frames_read; ++frame) {
        for_each_chunk(field, frame, [&](const StoreChunk& chunk) {
          for (const std::string& name : store_.files_of(chunk)) {
            if (listed.insert(name).second && is_there(name)) files.push_back(folder_ + "/" + name);
          }
        });
      }
    }
  }

  /// Reads a field by `readers_` threads, of which each blocks for its own chunk.
  void read_field(std::uint32_t field, std::int64_t frame, std::byte* to) {
    std::vector<StoreChunk> chunks;
    for_each_chunk(field, frame, [&](const StoreChunk& chunk) { chunks.push_back(chunk); });
    std::atomic<std::size_t> next = 0;
    const auto work = [&] {
      std::vector<std::byte> room;
      ZarrScratch scratch;
      for (std::size_t n = next++; n < chunks.size(); n = next++) read_chunk(chunks[n], field, to, room, scratch);
    };
    std::vector<std::future<void>> others;
    for (std::uint64_t n = 1; n < readers_; ++n) others.push_back(std::async(std::launch::async, work));
    work();
    for (std::future<void>& other : others) other.get();
  }

  void read_chunk(const StoreChunk& chunk, std::uint32_t field, std::byte* to, std::vector<std::byte>& room,
                  ZarrScratch& scratch) {
    const StoreContents& contents = store_.contents();
    const StoreOctave& octave = contents.octaves.front();
    const StoreField& of = contents.fields[field];
    const std::size_t voxel_bytes = size_of(of.type) * static_cast<std::size_t>(of.components);
    std::array<std::int64_t, 3> first{}, count{};
    for (std::size_t a = 0; a < 3; ++a) {
      first[a] = chunk.at[a] * octave.chunk[a];
      count[a] = std::min(octave.chunk[a], octave.grid.dims[a] - first[a]);
    }
    room.resize(protocol::content_bytes(contents, chunk));
    const ZarrRead read = store_.read(chunk, room, scratch);
    if (read.state == ChunkState::damaged)
      throw LoadError("holds a damaged chunk: " + read.sentence + "; get the whole store, or write it again");
    ++(read.state == ChunkState::absent ? absent_ : present_);
    if (read.state == ChunkState::absent) fill(of, room);
    for (std::int64_t k = 0; k < count[2]; ++k) {
      for (std::int64_t j = 0; j < count[1]; ++j) {
        const std::int64_t from = (k * octave.chunk[1] + j) * octave.chunk[0];
        const std::int64_t there = ((first[2] + k) * octave.grid.dims[1] + first[1] + j) * octave.grid.dims[0] + first[0];
        std::memcpy(to + static_cast<std::size_t>(there) * voxel_bytes, &room[static_cast<std::size_t>(from) * voxel_bytes],
                    static_cast<std::size_t>(count[0]) * voxel_bytes);
      }
    }
  }

  static void fill(const StoreField& field, std::vector<std::byte>& room) {
    protocol::with_type(field.type, [&](auto typed) {
      const auto value = static_cast<decltype(typed)>(field.fill);
      for (std::size_t at = 0; at + sizeof value <= room.size(); at += sizeof value)
        std::memcpy(&room[at], &value, sizeof value);
    });
  }

  bool is_there(const std::string& name) const {
    std::error_code none;
    return std::filesystem::is_regular_file(folder_ + "/" + name, none);
  }

  static constexpr double most_chunks = 1e6;  ///< More: a hostile header costs time; fewer: sound stores are refused.

  ZarrStore store_;
  std::string folder_;
  std::int64_t first_ = 0;
  std::atomic<std::int64_t> absent_ = 0, present_ = 0;
  std::uint64_t readers_ = 1;  ///< threads; more than one where each chunk takes a round trip
};

}  // namespace

std::unique_ptr<Source> open_zarr(const protocol::Request& request) { return std::make_unique<ZarrSource>(request); }

}  // namespace palpa::reader
