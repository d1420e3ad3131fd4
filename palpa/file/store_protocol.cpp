#include "palpa/file/store_protocol.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <system_error>

#include "palpa/base/limits.h"
#include "palpa/base/web_address.h"

namespace palpa::protocol {
namespace {

using Counts = std::array<std::int64_t, 3>;

constexpr std::uint64_t page_bytes = 1 << 16;  // a multiple of the page size of any machine

std::int64_t pieces(std::int64_t whole, std::int64_t piece) noexcept { return (whole + piece - 1) / piece; }

/// Product of sides that `problem_with` has found to be small.
std::uint64_t product(const Counts& counts) noexcept {
  std::uint64_t all = 1;
  for (const std::int64_t n : counts) all *= static_cast<std::uint64_t>(n);
  return all;
}

std::uint64_t chunk_bytes(const StoreOctave& octave, const StoreField& field) noexcept {
  return product(octave.chunk) * static_cast<std::uint64_t>(field.components) * size_of(field.type);
}

std::uint64_t facts_bytes(const StoreOctave& octave) noexcept {
  return octave.facts[0] == 0 ? 0 : product(octave.facts) * sizeof(ChunkFacts);
}

const char* problem_with(const StoreField& field) noexcept {
  if (field.components != 1 && field.components != 3) return "has a field of neither 1 nor 3 components";
  if (field.type > VoxelType::float64) return "has a field of an unknown type";
  const Histogram& h = field.histogram;
  if (!std::isfinite(h.low) || !std::isfinite(h.high) || h.low > h.high || h.counts.size() > most_histogram_classes ||
      std::ranges::any_of(h.counts, [](std::int64_t n) { return n < 0 || n > most_counted; }))
    return "has a histogram that cannot be";
  return nullptr;
}

const char* problem_with(const StoreOctave& octave) noexcept {
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t n = octave.grid.dims[a];
    if (n < 1 || n > most_side_voxels) return "has an octave of no voxel, or of more than 262144, along an axis";
    if (octave.chunk[a] < 1 || octave.chunk[a] > most_side_voxels)
      return "has chunks of no voxel, or of more than 262144, along an axis";
    if (octave.shard[a] < octave.chunk[a] || octave.shard[a] % octave.chunk[a] != 0)
      return "has shards that are no whole number of chunks";
    if (octave.facts[a] < 0 || octave.facts[a] > most_facts_side || (octave.facts[a] == 0) != (octave.facts[0] == 0))
      return "has facts of chunks in another layout than palpa prepare writes";
    if (!octave.grid.planes[a].empty()) return "has planes at uneven distances";
  }
  return palpa::problem_with(octave.grid);
}

void put(Packer& to, const Counts& counts) {
  for (const std::int64_t n : counts) to.number(n);
}
void get(Unpacker& from, Counts& counts) {
  for (std::int64_t& n : counts) n = from.number<std::int64_t>();
}

void put(Packer& to, const StoreChunk& chunk) {
  to.number(chunk.octave), to.number(chunk.frame), to.number(chunk.field), to.number(static_cast<std::uint8_t>(chunk.facts));
  put(to, chunk.at), to.number(static_cast<std::uint8_t>(chunk.presence));
}
void get(Unpacker& from, StoreChunk& chunk) {
  chunk.octave = from.number<std::int32_t>(), chunk.frame = from.number<std::int32_t>();
  chunk.field = from.number<std::int32_t>(), chunk.facts = from.truth();
  get(from, chunk.at), chunk.presence = from.truth();
}

}  // namespace

bool is_store(const std::filesystem::path& path) {
  if (is_web_address(path)) return true;
  std::error_code none;
  if (!std::filesystem::is_directory(path, none)) return false;
  for (const char* metadata : {".zarray", ".zgroup", ".zattrs", "zarr.json"}) {
    if (std::filesystem::is_regular_file(path / metadata, none)) return true;
  }
  return false;
}

const char* problem_with(const StoreContents& contents) noexcept {
  if (contents.fields.empty() || contents.fields.size() > most_store_fields) return "has no field, or more than 256";
  if (contents.octaves.empty() || contents.octaves.size() > most_octaves) return "has no octave, or more than 24";
  if (contents.frames < 1 || limit::frames.is_passed_by(contents.frames)) return "has no frame, or more than 100000";
  if (!std::isfinite(contents.period_s) || contents.period_s < 0.0) return "has frames at no finite distance of time";
  for (const StoreField& field : contents.fields) {
    if (const char* problem = problem_with(field)) return problem;
  }
  for (const StoreOctave& octave : contents.octaves) {
    if (const char* problem = problem_with(octave)) return problem;
    for (const StoreField& field : contents.fields) {
      // Three sides of at most 2¹⁸ and 24 bytes a voxel stay below 2⁶⁰.
      if (chunk_bytes(octave, field) > most_chunk_bytes) return "has chunks of more than 32 MB";
    }
  }
  return nullptr;
}

bool has_place(const StoreContents& contents, const StoreChunk& chunk) noexcept {
  if (chunk.octave < 0 || static_cast<std::size_t>(chunk.octave) >= contents.octaves.size()) return false;
  if (chunk.field < 0 || static_cast<std::size_t>(chunk.field) >= contents.fields.size()) return false;
  if (chunk.frame < 0 || chunk.frame >= contents.frames) return false;
  const StoreOctave& octave = contents.octaves[static_cast<std::size_t>(chunk.octave)];
  const bool of_facts = chunk.facts || chunk.presence;
  if ((chunk.facts && chunk.presence) || (of_facts && octave.facts[0] == 0)) return false;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t chunks = pieces(octave.grid.dims[a], octave.chunk[a]);
    if (chunk.at[a] < 0 || chunk.at[a] >= (of_facts ? pieces(chunks, octave.facts[a]) : chunks)) return false;
  }
  return true;
}

std::uint64_t content_bytes(const StoreContents& contents, const StoreChunk& chunk) noexcept {
  const StoreOctave& octave = contents.octaves[static_cast<std::size_t>(chunk.octave)];
  if (chunk.presence) return octave.facts[0] == 0 ? 0 : product(octave.facts);
  return chunk.facts ? facts_bytes(octave) : chunk_bytes(octave, contents.fields[static_cast<std::size_t>(chunk.field)]);
}

std::uint64_t slot_bytes(const StoreContents& contents) noexcept {
  std::uint64_t most = 1;
  for (const StoreOctave& octave : contents.octaves) {
    most = std::max(most, facts_bytes(octave));
    for (const StoreField& field : contents.fields) most = std::max(most, chunk_bytes(octave, field));
  }
  return (most + page_bytes - 1) / page_bytes * page_bytes;
}

StoreContents contents_by_rows(const Header& header) {
  // [bytes] More: more memory for each chunk ahead; less: more requests.
  constexpr std::int64_t chunk_bytes_by_rows = std::int64_t{8} << 20;
  constexpr std::int64_t rows_of_chunks = 32;  // as palpa writes
  StoreContents contents;
  if (header.fields.empty() || !header.reads_rows) return contents;
  StoreOctave octave{.grid = header.fields.front().grid};
  std::int64_t widest = 1;  // [bytes] of a voxel
  for (const FieldHeader& field : header.fields) {
    if (field.grid != octave.grid || !voxel_bytes(field)) return contents;
    contents.fields.push_back({field.name, field.unit, name_of(field.type), field.type, field.components, 0.0});
    widest = std::max(widest, static_cast<std::int64_t>(size_of(field.type)) * field.components);
  }
  const Counts& dims = octave.grid.dims;
  const std::int64_t fitting = chunk_bytes_by_rows / (std::min(dims[0], most_side_voxels) * widest);
  const std::int64_t rows = fitting < rows_of_chunks ? fitting : fitting / rows_of_chunks * rows_of_chunks;
  octave.chunk = octave.shard = {dims[0], std::clamp<std::int64_t>(rows, 1, dims[1]), 1};
  contents.octaves.push_back(octave);
  if (problem_with(contents)) contents.octaves.clear();
  return contents;
}

void pack(Packer& to, const StoreContents& m) {
  to.text(m.format), to.text(m.length_unit), to.number(static_cast<std::uint8_t>(m.length_unit_assumed));
  to.list(m.fields, [&](const StoreField& f) {
    to.text(f.name), to.text(f.unit), to.text(f.file_type);
    to.number(static_cast<std::uint8_t>(f.type)), to.number(static_cast<std::int32_t>(f.components)), to.number(f.fill);
    to.number(f.histogram.low), to.number(f.histogram.high);
    to.list(f.histogram.counts, [&](std::int64_t n) { to.number(n); });
  });
  to.list(m.octaves, [&](const StoreOctave& o) {
    put(to, o.grid.dims);
    for (const Vec3& row : o.grid.index_to_world_m.row) to.vector(row);
    to.vector(o.grid.origin_m);
    put(to, o.chunk), put(to, o.shard), put(to, o.facts);
    to.text(o.codec);
  });
  to.number(static_cast<std::int32_t>(m.frames)), to.number(m.period_s), to.number(static_cast<std::uint8_t>(m.prepared));
  to.list(m.warnings, [&](const std::string& w) { to.text(w); });
}
void unpack(Unpacker& from, StoreContents& m) {
  m.format = from.text(), m.length_unit = from.text(), m.length_unit_assumed = from.truth();
  m.fields = from.list<StoreField>([&] {
    StoreField f;
    f.name = from.text(), f.unit = from.text(), f.file_type = from.text();
    const auto type = from.number<std::uint8_t>();
    if (type > static_cast<std::uint8_t>(VoxelType::float64)) from.refuse();
    f.type = static_cast<VoxelType>(type);
    f.components = from.number<std::int32_t>(), f.fill = from.number<double>();
    f.histogram.low = from.number<double>(), f.histogram.high = from.number<double>();
    f.histogram.counts = from.list<std::int64_t>([&] { return from.number<std::int64_t>(); });
    return f;
  });
  m.octaves = from.list<StoreOctave>([&] {
    StoreOctave o;
    get(from, o.grid.dims);
    for (Vec3& row : o.grid.index_to_world_m.row) row = from.vector();
    o.grid.origin_m = from.vector();
    get(from, o.chunk), get(from, o.shard), get(from, o.facts);
    o.codec = from.text();
    return o;
  });
  m.frames = from.number<std::int32_t>(), m.period_s = from.number<double>(), m.prepared = from.truth();
  m.warnings = from.list<std::string>([&] { return from.text(); });
}

void pack(Packer& to, const StoreRoom& m) { to.number(m.slots), to.number(m.slot_bytes); }
void unpack(Unpacker& from, StoreRoom& m) {
  m.slots = from.number<std::int32_t>(), m.slot_bytes = from.number<std::uint64_t>();
}

void pack(Packer& to, const ChunkRequest& m) { put(to, m.chunk), to.number(m.slot); }
void unpack(Unpacker& from, ChunkRequest& m) { get(from, m.chunk), m.slot = from.number<std::int32_t>(); }

void pack(Packer& to, const ChunkAnswer& m) {
  put(to, m.chunk), to.number(m.slot), to.number(static_cast<std::uint8_t>(m.state)), to.number(m.bytes), to.text(m.sentence);
}
void unpack(Unpacker& from, ChunkAnswer& m) {
  get(from, m.chunk), m.slot = from.number<std::int32_t>();
  const auto state = from.number<std::uint8_t>();
  if (state > static_cast<std::uint8_t>(ChunkState::damaged)) from.refuse();
  m.state = static_cast<ChunkState>(state);
  m.bytes = from.number<std::uint64_t>(), m.sentence = from.text();
}

void pack(Packer& to, const FetchRequest& m) {
  to.number(m.number), to.text(m.name), to.number(m.first), to.number(m.bytes);
  to.number(static_cast<std::uint8_t>(m.from_end)), to.number(m.most_bytes);
}
void unpack(Unpacker& from, FetchRequest& m) {
  m.number = from.number<std::uint32_t>(), m.name = from.path(), m.first = from.number<std::uint64_t>();
  m.bytes = from.number<std::uint64_t>(), m.from_end = from.truth(), m.most_bytes = from.number<std::uint64_t>();
}

void pack(Packer& to, const FetchAnswer& m) {
  to.number(m.number), to.number(static_cast<std::uint8_t>(m.state)), to.number(m.first), to.number(m.whole_bytes);
  to.number(static_cast<std::uint8_t>(m.is_forbidden)), to.text(m.sentence);
}
void unpack(Unpacker& from, FetchAnswer& m) {
  m.number = from.number<std::uint32_t>();
  const auto state = from.number<std::uint8_t>();
  if (state > static_cast<std::uint8_t>(FetchState::failed)) from.refuse();
  m.state = static_cast<FetchState>(state);
  m.first = from.number<std::uint64_t>(), m.whole_bytes = from.number<std::uint64_t>();
  m.is_forbidden = from.truth(), m.sentence = from.text();
}

}  // namespace palpa::protocol
