#include "palpa/file/store_array.h"

#include <blosc.h>
#include <sys/resource.h>

#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

#include "palpa/base/input_file.h"
#include "palpa/base/load_error.h"

static_assert(std::endian::native == std::endian::little, "the metadata say so");

namespace palpa::detail {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// [1] Effort of lz4, 0…9. More: slower for a few percent; less: larger.
constexpr int effort = 5;
constexpr const char* codec = "lz4";

std::string type_name(const ArrayPlan& plan) {
  if (plan.stored == StoredAs::int8) return plan.zarr == 2 ? "|i1" : "int8";
  if (plan.stored == StoredAs::uint32) return plan.zarr == 2 ? "<u4" : "uint32";
  static constexpr const char* second[] = {"|u1", "<i2", "<u2", "<i4", "<f4", "<f8"};
  return plan.zarr == 2 ? second[static_cast<std::size_t>(plan.type)] : name_of(plan.type);
}

Json blosc_of_3(std::size_t number_bytes) {
  return {{"name", "blosc"},
          {"configuration",
           {{"cname", codec}, {"clevel", effort}, {"shuffle", "bitshuffle"}, {"typesize", number_bytes}, {"blocksize", 0}}}};
}

Json bytes_of_3() { return {{"name", "bytes"}, {"configuration", {{"endian", "little"}}}}; }

Json codecs_of_3(const ArrayPlan& plan) {
  Json inner = Json::array({bytes_of_3()});
  if (plan.is_packed) inner.push_back(blosc_of_3(stored_bytes(plan.stored, plan.type)));
  if (plan.shard.empty()) return inner;
  return Json::array({{{"name", "sharding_indexed"},
                       {"configuration",
                        {{"chunk_shape", plan.chunk},
                         {"codecs", inner},
                         {"index_codecs", Json::array({bytes_of_3(), {{"name", "crc32c"}}})},
                         {"index_location", "end"}}}}});
}

[[noreturn]] void fail(const fs::path& name, const std::error_code& error) {
  throw LoadError(name.string() + ": cannot be made (" + error.message() + "); name a folder that may be written to");
}

/// Writes metadata, unless the same bytes are there: parts of a job write the same.
void write_metadata(const fs::path& name, const std::string& text) {
  const InputFile there(name);
  if (there.is_open()) {
    std::string bytes(text.size(), '\0');
    if (there.bytes() == text.size() && there.read(0, bytes.data(), bytes.size()) == bytes.size() && bytes == text) return;
    throw LoadError(name.string() + ": describes another array than would be written; name a new store, or remove this one");
  }
  write_whole(name, text, Existing::replaced);
}

/// The reader of a group takes any metadata of its version.
void write_group(const fs::path& folder, int zarr) {
  const fs::path name = folder / (zarr == 2 ? ".zgroup" : "zarr.json");
  if (InputFile(name).is_open()) return;
  write_whole(name, group_metadata(zarr), Existing::replaced);
}

}  // namespace

std::size_t stored_bytes(StoredAs stored, VoxelType type) noexcept {
  return stored == StoredAs::int8 ? 1 : stored == StoredAs::uint32 ? 4 : size_of(type);
}

std::string array_metadata(const ArrayPlan& plan) {
  Json json;
  if (plan.zarr == 2) {
    json = {{"zarr_format", 2},          {"shape", plan.shape}, {"chunks", plan.chunk}, {"dtype", type_name(plan)},
            {"compressor", nullptr},     {"fill_value", 0},     {"order", "C"},         {"filters", nullptr},
            {"dimension_separator", "/"}};
    if (plan.is_packed)
      json["compressor"] = {{"id", "blosc"}, {"cname", codec}, {"clevel", effort}, {"shuffle", 2}, {"blocksize", 0}};
  } else {
    json = {{"zarr_format", 3},
            {"node_type", "array"},
            {"shape", plan.shape},
            {"data_type", type_name(plan)},
            {"chunk_grid",
             {{"name", "regular"}, {"configuration", {{"chunk_shape", plan.shard.empty() ? plan.chunk : plan.shard}}}}},
            {"chunk_key_encoding", {{"name", "default"}, {"configuration", {{"separator", "/"}}}}},
            {"fill_value", 0},
            {"codecs", codecs_of_3(plan)},
            {"attributes", Json::object()}};
    if (!plan.axes.empty()) json["dimension_names"] = plan.axes;
  }
  return json.dump(2) + "\n";
}

std::string group_metadata(int zarr) {
  const Json json =
      zarr == 2 ? Json{{"zarr_format", 2}} : Json{{"zarr_format", 3}, {"node_type", "group"}, {"attributes", Json::object()}};
  return json.dump(2) + "\n";
}

std::vector<std::byte> packed_chunk(std::span<const std::byte> voxels, std::size_t number_bytes) {
  std::vector<std::byte> packed(voxels.size() + BLOSC_MAX_OVERHEAD);
  const int bytes = blosc_compress_ctx(effort, BLOSC_BITSHUFFLE, number_bytes, voxels.size(), voxels.data(), packed.data(),
                                       packed.size(), codec, 0, 1);
  if (bytes <= 0) throw LoadError("cannot be packed by blosc; install its library anew");
  packed.resize(static_cast<std::size_t>(bytes));
  return packed;
}

FileBatch::FileBatch() {
  // Every core may fill a batch; a quarter of the files that a process may open leaves room for others.
  rlimit open_files{};
  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t most = ::getrlimit(RLIMIT_NOFILE, &open_files) == 0 ? static_cast<std::size_t>(open_files.rlim_cur) : 256;
  most_ = std::clamp<std::size_t>(most / (4 * cores), 8, 256);
}

void allow_open_files(std::size_t count) noexcept {
  constexpr std::size_t of_others = 512;  // readers, batches, libraries
  rlimit open_files{};
  if (::getrlimit(RLIMIT_NOFILE, &open_files) != 0 || open_files.rlim_cur >= count + of_others) return;
  open_files.rlim_cur = std::min<rlim_t>(count + of_others, open_files.rlim_max);
  ::setrlimit(RLIMIT_NOFILE, &open_files);
}

void FileBatch::add(std::unique_ptr<NewFile> file, const fs::path& name) {
  files_.emplace_back(std::move(file), name);
  if (files_.size() >= most_) finish();
}

void FileBatch::finish() {
  constexpr std::size_t worth_a_sync = 4;  // Fewer: each by itself, so that files of others need not be waited for
  const bool is_synced = files_.size() >= worth_a_sync && files_.front().first->sync_with_others();
  for (auto& [file, name] : files_) {
    try {
      file->finish(is_synced);
    } catch (const LoadError& error) {
      throw LoadError(name.string() + ": " + error.what());
    }
    file.reset();
  }
  files_.clear();
}

ArrayFiles::ArrayFiles(fs::path store, ArrayPlan plan) : store_(std::move(store)), plan_(std::move(plan)) {}

void ArrayFiles::make() {
  const fs::path folder = store_ / plan_.path;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail(folder, error);
  for (fs::path group = fs::path(plan_.path).parent_path(); !group.empty(); group = group.parent_path())
    write_group(store_ / group, plan_.zarr);
  write_metadata(folder / (plan_.zarr == 2 ? ".zarray" : "zarr.json"), array_metadata(plan_));
}

fs::path ArrayFiles::file(std::span<const std::int64_t> at) const {
  std::string name = (store_ / plan_.path).string();
  if (plan_.zarr == 3) name += "/c";
  for (const std::int64_t index : at) name += '/' + std::to_string(index);
  return name;
}

bool ArrayFiles::has(std::span<const std::int64_t> at) const {
  std::error_code none;
  return fs::is_regular_file(file(at), none);
}

std::unique_ptr<NewFile> ArrayFiles::begin(std::span<const std::int64_t> at) {
  const fs::path name = file(at);
  const std::string folder = name.parent_path().string();
  bool made = false;
  {
    const std::lock_guard lock(mutex_);
    made = folders_.contains(folder);
  }
  if (!made) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) fail(folder, error);
    const std::lock_guard lock(mutex_);
    folders_.insert(folder);
  }
  try {
    return std::make_unique<NewFile>(name, Existing::replaced);
  } catch (const LoadError& error) {
    throw LoadError(name.string() + ": " + error.what());
  }
}

void ArrayFiles::write(std::span<const std::int64_t> at, std::span<const std::byte> packed, FileBatch& batch) {
  auto next = begin(at);
  try {
    next->write(packed.data(), packed.size());
  } catch (const LoadError& error) {
    throw LoadError(file(at).string() + ": " + error.what());
  }
  batch.add(std::move(next), file(at));
}

ShardFile::ShardFile(ArrayFiles& of, std::vector<std::int64_t> at) : of_(of), at_(std::move(at)), file_(of.begin(at_)) {
  std::size_t chunks = 1;
  for (std::size_t a = 0; a < of.plan().chunk.size(); ++a) {
    chunks_.push_back(of.plan().shard[a] / of.plan().chunk[a]);
    chunks *= static_cast<std::size_t>(chunks_.back());
  }
  index_.assign(2 * chunks, ~std::uint64_t{0});  // of an absent chunk
}

void ShardFile::append(std::span<const std::int64_t> inside, std::span<const std::byte> packed) {
  std::size_t number = 0;
  for (std::size_t a = 0; a < inside.size(); ++a)
    number = number * static_cast<std::size_t>(chunks_[a]) + static_cast<std::size_t>(inside[a]);
  try {
    file_->write(packed.data(), packed.size());
  } catch (const LoadError& error) {
    throw LoadError(of_.file(at_).string() + ": " + error.what());
  }
  index_[2 * number] = end_;
  index_[2 * number + 1] = packed.size();
  end_ += packed.size();
}

void ShardFile::finish(FileBatch& batch) {
  const auto bytes = std::as_bytes(std::span(index_));
  const std::uint32_t crc = crc32c(bytes);
  try {
    file_->write(bytes.data(), bytes.size());
    file_->write(&crc, sizeof crc);
  } catch (const LoadError& error) {
    throw LoadError(of_.file(at_).string() + ": " + error.what());
  }
  batch.add(std::move(file_), of_.file(at_));
}

std::uint32_t crc32c(std::span<const std::byte> bytes) noexcept {
  static constexpr auto table = [] {
    std::array<std::uint32_t, 256> made{};
    for (std::uint32_t n = 0; n < 256; ++n) {
      std::uint32_t rest = n;
      for (int bit = 0; bit < 8; ++bit) rest = (rest >> 1) ^ (rest % 2 == 1 ? 0x82f63b78u : 0u);
      made[n] = rest;
    }
    return made;
  }();
  std::uint32_t crc = ~0u;
  for (const std::byte byte : bytes) crc = table[(crc ^ static_cast<std::uint32_t>(byte)) & 0xff] ^ (crc >> 8);
  return ~crc;
}

}  // namespace palpa::detail
