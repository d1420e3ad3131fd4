#include "palpa/file/store_writer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>

#include "palpa/base/input_file.h"
#include "palpa/data/parallel.h"
#include "palpa/file/protocol_voxels.h"
#include "palpa/file/store_array.h"
#include "palpa/file/store_image.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;
using detail::allow_open_files, detail::ArrayFiles, detail::ArrayPlan, detail::FileBatch, detail::NewImage, detail::ShardFile;
using Index = std::array<std::int64_t, 3>;

constexpr std::int64_t side = 32;                          // [voxels] of a chunk
constexpr std::int64_t shard_side = 512;                   // [voxels]
constexpr std::int64_t loaded_bytes = 256'000'000;         // More: more memory; less: slices are read in more pieces
constexpr double chunks_for_shards = 1e6;                  // More: millions of files; less: shards where nothing needs them
constexpr std::int64_t most_side = std::int64_t{1} << 18;  // [voxels] that stores are read with

std::int64_t rows(std::int64_t voxels, std::int64_t each) { return (voxels + each - 1) / each; }

VoxelType common_type(const std::vector<WrittenField>& fields) {
  const VoxelType first = fields.front().type;
  if (std::all_of(fields.begin(), fields.end(), [&](const WrittenField& f) { return f.type == first; })) return first;
  const bool wide = std::any_of(fields.begin(), fields.end(), [](const WrittenField& f) {
    return f.type == VoxelType::float64 || f.type == VoxelType::int32;
  });
  return wide ? VoxelType::float64 : VoxelType::float32;
}

/// Directions of the grid's axes in the world: 1 or −1.
std::array<int, 3> directions(const GridGeometry& grid) {
  std::array<int, 3> result{1, 1, 1};
  for (int a = 0; a < 3; ++a) {
    const Vec3& row = grid.index_to_world_m.row[a];
    const double parts[] = {row.x, row.y, row.z};
    const double own = parts[a];
    for (int b = 0; b < 3; ++b) {
      if (b == a ? !(std::abs(own) > 0.0) : std::abs(parts[b]) > 1e-6 * std::abs(own)) {
        throw LoadError(
            "has a grid that is turned or sheared, and OME-Zarr 0.4 and 0.5 hold scale and place alone; resample "
            "it (--resample-m M)");
      }
    }
    result[static_cast<std::size_t>(a)] = own > 0.0 ? 1 : -1;
  }
  return result;
}

struct OmeUnit {
  const char* ours;
  const char* theirs;
  double metres;
};
constexpr OmeUnit ome_units[] = {{"m", "meter", 1.0},        {"cm", "centimeter", 1e-2}, {"mm", "millimeter", 1e-3},
                                 {"um", "micrometer", 1e-6}, {"µm", "micrometer", 1e-6}, {"nm", "nanometer", 1e-9},
                                 {"km", "kilometer", 1e3}};

/// Channel of a store: a component of a field.
struct Channel {
  std::size_t field = 0;
  int component = 0;
};

class Source {
 public:
  explicit Source(const WrittenVolume& volume)
      : volume_(volume), type_(common_type(volume.fields)), way_(directions(volume.grid)) {
    for (std::size_t f = 0; f < volume.fields.size(); ++f)
      for (int c = 0; c < volume.fields[f].components; ++c) channels_.push_back({f, c});
  }

  VoxelType type() const noexcept { return type_; }
  const Index& dims() const noexcept { return volume_.grid.dims; }
  const std::vector<Channel>& channels() const noexcept { return channels_; }

  NewImage image(const std::string& name, int zarr) const {
    NewImage image{.zarr = zarr, .name = name};
    const OmeUnit* unit = std::find_if(std::begin(ome_units), std::end(ome_units),
                                       [&](const OmeUnit& each) { return volume_.length_unit == each.ours; });
    if (unit == std::end(ome_units)) unit = ome_units;
    image.length_unit = unit->theirs;
    const Vec3& origin_m = volume_.grid.origin_m;
    const double first_m[] = {origin_m.x, origin_m.y, origin_m.z};
    for (std::size_t a = 0; a < 3; ++a) {
      const Vec3& row = volume_.grid.index_to_world_m.row[a];
      const double parts[] = {row.x, row.y, row.z};
      const double low_m = first_m[a] + (way_[a] < 0 ? parts[a] * static_cast<double>(dims()[a] - 1) : 0.0);
      image.spacing[a] = std::abs(parts[a]) / unit->metres;
      image.origin[a] = low_m / unit->metres;
    }
    for (const Channel& channel : channels_) {
      const WrittenField& field = volume_.fields[channel.field];
      image.channels.push_back(field.components == 1 ? field.name : field.name + "_" + "xyz"[channel.component]);
      image.units.push_back(field.unit);
    }
    image.window = type_ == VoxelType::uint8 ? std::array{0.0, 255.0} : std::array{0.0, 1.0};
    return image;
  }

  /// Rows that are loaded at once: whole chunks, as many as memory is given for where rows are read.
  std::int64_t rows_at_once() const noexcept {
    std::int64_t row_bytes = 0, each = side;
    for (const WrittenField& field : volume_.fields) {
      if (in_place(field)) continue;
      if (!reads_rows(field)) return dims()[1];  // a slice is computed as a whole
      row_bytes += side * dims()[0] * field.components * static_cast<std::int64_t>(size_of(type_));
      each = std::max(each, field.rows_at_once / side * side);
    }
    const std::int64_t fitting = row_bytes > 0 ? loaded_bytes / row_bytes : dims()[1];
    return fitting >= dims()[1] ? dims()[1] : std::max(fitting >= each ? fitting / each * each : fitting / side * side, side);
  }

  /// Loads rows of the slices of a row of chunks, unless the voxels are in memory. \param range  of the store
  void load(const SliceRows& range) {
    loaded_ = range;
    SliceRows there = range;
    if (way_[2] < 0) there.first_slice = dims()[2] - range.first_slice - range.slices;
    if (way_[1] < 0) there.first_row = dims()[1] - range.first_row - range.rows;
    room_.resize(volume_.fields.size());
    for (std::size_t f = 0; f < volume_.fields.size(); ++f) {
      const WrittenField& field = volume_.fields[f];
      if (in_place(field)) continue;
      room_[f].resize(static_cast<std::size_t>(range.slices * range.rows * dims()[0] * field.components) * size_of(type_));
      if (reads_rows(field)) {
        field.rows(there, room_[f].data());
      } else {
        protocol::with_type(type_, [&](auto number) { load_slices<decltype(number)>(field, there, room_[f]); });
      }
    }
  }

  /// Voxels of a chunk of the loaded row, with zeros beyond the grid.
  void take(const Channel& channel, const Index& at, std::vector<std::byte>& chunk) const {
    chunk.assign(static_cast<std::size_t>(side * side * side) * size_of(type_), std::byte{0});
    protocol::with_type(type_, [&](auto number) { take_as<decltype(number)>(channel, at, chunk); });
  }

 private:
  bool in_place(const WrittenField& field) const noexcept { return field.voxels && field.type == type_; }
  bool reads_rows(const WrittenField& field) const noexcept { return field.rows && field.type == type_; }

  /// \param range  all rows of some slices
  template <class T>
  void load_slices(const WrittenField& field, const SliceRows& range, std::vector<std::byte>& room) const {
    std::vector<double> values(static_cast<std::size_t>(range.rows * dims()[0] * field.components));
    T* to = reinterpret_cast<T*>(room.data());
    for (std::int64_t k = range.first_slice; k < range.first_slice + range.slices; ++k) {
      field.slice(k, values.data());
      for (const double value : values) *to++ = static_cast<T>(value);
    }
  }

  template <class T>
  void take_as(const Channel& channel, const Index& at, std::vector<std::byte>& chunk) const {
    const WrittenField& field = volume_.fields[channel.field];
    const bool whole = in_place(field);
    const T* const memory = reinterpret_cast<const T*>(whole ? field.voxels : room_[channel.field].data());
    const std::int64_t n = field.components, step = way_[0] * n;
    const Index& d = dims();
    const SliceRows box = whole ? SliceRows{0, d[2], 0, d[1]} : loaded_;  // of the memory, in the store's directions
    T* const to = reinterpret_cast<T*>(chunk.data());
    Index low{}, high{};
    for (std::size_t a = 0; a < 3; ++a) low[a] = at[a] * side, high[a] = std::min(low[a] + side, d[a]);
    for (std::int64_t k = low[2]; k < high[2]; ++k)
      for (std::int64_t j = low[1]; j < high[1]; ++j) {
        const std::int64_t from_k = way_[2] > 0 ? k - box.first_slice : box.first_slice + box.slices - 1 - k;
        const std::int64_t from_j = way_[1] > 0 ? j - box.first_row : box.first_row + box.rows - 1 - j;
        const std::int64_t from_i = way_[0] > 0 ? low[0] : d[0] - 1 - low[0];
        const T* const from = memory + ((from_k * box.rows + from_j) * d[0] + from_i) * n + channel.component;
        T* const row = to + ((k - low[2]) * side + (j - low[1])) * side;
        const std::int64_t count = high[0] - low[0];
        if (step == 1) {
          std::memcpy(row, from, static_cast<std::size_t>(count) * sizeof(T));
        } else {
          for (std::int64_t i = 0; i < count; ++i) row[i] = from[i * step];
        }
      }
  }

  const WrittenVolume& volume_;
  VoxelType type_;
  std::array<int, 3> way_;
  std::vector<Channel> channels_;
  std::vector<std::vector<std::byte>> room_;  ///< loaded rows of each field not in place, in `type_`
  SliceRows loaded_;                          ///< of the store
};

class StoreWriter {
 public:
  StoreWriter(Source& source, ArrayFiles& files, const StoreWriting& how)
      : source_(source), files_(files), how_(how), has_channels_(source.channels().size() > 1) {}

  void write() {
    const Index& d = source_.dims();
    const std::int64_t row = files_.plan().shard.empty() ? side : shard_side;
    if (row == shard_side) {  // those of a row of shards are written at once
      allow_open_files(static_cast<std::size_t>(rows(d[0], row) * rows(d[1], row)) * source_.channels().size());
    }
    const std::int64_t at_once = source_.rows_at_once();
    const std::int64_t units = rows(d[2], row), first = how_.part.first(units), end = how_.part.end(units);
    for (std::int64_t unit = first; unit < end; ++unit) {
      if (row == shard_side && has_files(unit, {0, rows(d[1], row)}, row)) continue;
      for (std::int64_t k = unit * row; k < std::min((unit + 1) * row, d[2]); k += side) {
        for (std::int64_t j = 0; j < d[1]; j += at_once) {
          const SliceRows loaded{k, std::min(side, d[2] - k), j, std::min(at_once, d[1] - j)};
          if (row == shard_side || !has_files(k / side, {j / side, rows(j + loaded.rows, side)}, side)) {
            source_.load(loaded);
            write_rows(loaded);
          }
          if (how_.progress) {
            const double slices = static_cast<double>(k - first * row) + static_cast<double>(loaded.slices) *
                                                                             static_cast<double>(j + loaded.rows) /
                                                                             static_cast<double>(d[1]);
            how_.progress(slices / static_cast<double>(std::min(end * row, d[2]) - first * row));
          }
        }
      }
      for (auto& [at, shard] : shards_) shard.finish(batch_);
      shards_.clear();
      batch_.finish();
    }
    batch_.finish();
  }

 private:
  std::vector<std::int64_t> place(std::size_t channel, const Index& at) const {
    std::vector<std::int64_t> place;
    if (has_channels_) place.push_back(static_cast<std::int64_t>(channel));
    place.insert(place.end(), {at[2], at[1], at[0]});
    return place;
  }

  /// Whether all files are there that rows of chunks or shards need. \param along_j  [chunks, or shards] first and end
  bool has_files(std::int64_t k, const std::array<std::int64_t, 2>& along_j, std::int64_t each) const {
    if (!how_.keeps_rows) return false;
    for (std::size_t c = 0; c < source_.channels().size(); ++c)
      for (std::int64_t j = along_j[0]; j < along_j[1]; ++j)
        for (std::int64_t i = 0; i < rows(source_.dims()[0], each); ++i) {
          if (!files_.has(place(c, {i, j, k}))) return false;
        }
    return true;
  }

  void write_rows(const SliceRows& loaded) {
    const std::int64_t nx = rows(source_.dims()[0], side), k = loaded.first_slice / side;
    const std::int64_t begin = nx * (loaded.first_row / side), end = nx * rows(loaded.first_row + loaded.rows, side);
    for (std::size_t c = 0; c < source_.channels().size(); ++c) {
      // Packed in groups of some thousand chunks: more take memory, fewer leave cores idle.
      constexpr std::int64_t group = 4096;
      for (std::int64_t first = begin; first < end; first += group) {
        const std::int64_t count = std::min(group, end - first);
        files_.plan().shard.empty() ? write_files(c, k, first, count) : write_in_shards(c, k, first, count);
      }
    }
  }

  std::vector<std::byte> packed(std::size_t channel, const Index& at, std::vector<std::byte>& voxels) const {
    source_.take(source_.channels()[channel], at, voxels);
    return detail::packed_chunk(voxels, size_of(source_.type()));
  }

  void write_files(std::size_t channel, std::int64_t k, std::int64_t first, std::int64_t count) {
    const std::int64_t nx = rows(source_.dims()[0], side);
    detail::in_parts(count, 4, [&](std::int64_t from, std::int64_t to) {
      FileBatch batch;
      std::vector<std::byte> voxels;
      for (std::int64_t n = first + from; n < first + to; ++n) {
        const Index at{n % nx, n / nx, k};
        files_.write(place(channel, at), packed(channel, at, voxels), batch);
      }
      batch.finish();
    });
  }

  void write_in_shards(std::size_t channel, std::int64_t k, std::int64_t first, std::int64_t count) {
    const std::int64_t nx = rows(source_.dims()[0], side), each = shard_side / side;
    std::vector<std::vector<std::byte>> all(static_cast<std::size_t>(count));
    detail::in_parts(count, 4, [&](std::int64_t from, std::int64_t to) {
      std::vector<std::byte> voxels;
      for (std::int64_t n = from; n < to; ++n)
        all[static_cast<std::size_t>(n)] = packed(channel, {(first + n) % nx, (first + n) / nx, k}, voxels);
    });
    for (std::int64_t n = 0; n < count; ++n) {
      const Index at{(first + n) % nx, (first + n) / nx, k};
      const std::vector<std::int64_t> shard = place(channel, {at[0] / each, at[1] / each, at[2] / each});
      auto found = shards_.find(shard);
      if (found == shards_.end()) found = shards_.emplace(shard, ShardFile(files_, shard)).first;
      std::vector<std::int64_t> inside = place(0, {at[0] % each, at[1] % each, at[2] % each});
      found->second.append(inside, all[static_cast<std::size_t>(n)]);
    }
  }

  Source& source_;
  ArrayFiles& files_;
  const StoreWriting& how_;
  bool has_channels_;
  FileBatch batch_;
  std::map<std::vector<std::int64_t>, ShardFile> shards_;  ///< of one row of shards
};

ArrayPlan plan_of(const Source& source, int zarr) {
  const Index& d = source.dims();
  ArrayPlan plan{.zarr = zarr, .path = "0", .type = source.type(), .axes = {"z", "y", "x"}};
  plan.shape = {d[2], d[1], d[0]};
  plan.chunk = {side, side, side};
  double chunks = static_cast<double>(source.channels().size());
  for (const std::int64_t n : d) chunks *= static_cast<double>(rows(n, side));
  if (zarr == 0) plan.zarr = chunks >= chunks_for_shards ? 3 : 2;
  if (plan.zarr == 3) plan.shard = {shard_side, shard_side, shard_side};
  if (source.channels().size() > 1) {
    plan.shape.insert(plan.shape.begin(), static_cast<std::int64_t>(source.channels().size()));
    plan.chunk.insert(plan.chunk.begin(), 1);
    if (!plan.shard.empty()) plan.shard.insert(plan.shard.begin(), 1);
    plan.axes.insert(plan.axes.begin(), "c");
  }
  return plan;
}

void check_store(const fs::path& store, const StoreWriting& how) {
  std::error_code none;
  if (!fs::exists(fs::symlink_status(store, none))) return;
  if (!fs::is_directory(store, none)) throw LoadError("exists already and is no folder; name a new store");
  if (fs::exists(store / "palpa", none))
    throw LoadError(
        "is prepared already, and its octaves would be those of other voxels; name a new store, or remove this one");
  if (fs::is_empty(store, none) || how.shares_store) return;
  if (how.existing == detail::Existing::refused)
    throw LoadError("exists already; name a new store, or have its chunks written again (--force)");
}

/// Writes attributes, unless the same bytes are there.
void write_attributes(const fs::path& store, const NewImage& image) {
  const fs::path name = store / detail::attributes_file(image.zarr);
  const std::string text = image_metadata(image);
  const detail::InputFile there(name);
  if (there.is_open()) {
    std::string bytes(text.size(), '\0');
    if (there.bytes() == text.size() && there.read(0, bytes.data(), bytes.size()) == bytes.size() && bytes == text) return;
    throw LoadError("holds other data than would be written; name a new store, or remove this one");
  }
  detail::write_whole(name, text, detail::Existing::replaced);
}

}  // namespace

bool is_store(const fs::path& name) { return (name.has_filename() ? name : name.parent_path()).extension() == ".zarr"; }

void write_store(const WrittenVolume& volume, const fs::path& store, const StoreWriting& how) {
  try {
    Source source(volume);
    for (const std::int64_t n : source.dims()) {
      if (n > most_side) throw LoadError("would have more than 262144 voxels along an axis; take fewer");
    }
    check_store(store, how);
    ArrayFiles files(store, plan_of(source, how.zarr));
    std::error_code error;
    fs::create_directories(store, error);
    if (error) throw LoadError("cannot be made (" + error.message() + "); name a folder that may be written to");
    const fs::path name = store.has_filename() ? store.stem() : store.parent_path().stem();
    const int zarr = files.plan().zarr;
    if (zarr == 2 && !detail::InputFile(store / ".zgroup").is_open())
      detail::write_whole(store / ".zgroup", detail::group_metadata(2), detail::Existing::replaced);
    write_attributes(store, source.image(name.string(), zarr));
    files.make();
    StoreWriter(source, files, how).write();
  } catch (const LoadError& error) {
    const std::string problem = error.what();
    throw LoadError(problem.rfind(store.string(), 0) == 0 ? problem : store.string() + ": " + problem);
  }
}

}  // namespace palpa
