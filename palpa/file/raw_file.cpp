#include "palpa/file/raw_file.h"

#include <sys/mman.h>

#include <bit>
#include <cstdint>
#include <cstring>

#include "palpa/base/load_error.h"
#include "palpa/data/parallel.h"

namespace palpa::detail {
namespace {

std::shared_ptr<const MappedFile> map_file(const std::string& path) {
  const InputFile file(path);
  if (!file.is_open()) throw LoadError(file.problem() + "; give a file of bare numbers that can be read");
  return std::make_shared<const MappedFile>(file);
}

/// Anonymous memory, in large pages if the system has some.
std::shared_ptr<std::byte> fresh_memory(std::uint64_t bytes) {
  void* memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) {
    throw LoadError("cannot be read: no memory of " + protocol::readable_bytes(static_cast<double>(bytes)) +
                    "; crop or downsample the volume");
  }
  ::madvise(memory, bytes, MADV_HUGEPAGE);
  return {static_cast<std::byte*>(memory), [bytes](std::byte* m) { ::munmap(m, bytes); }};
}

}  // namespace

RawFile::RawFile(const protocol::Request& request) {
  const ArrayLayout& layout = request.layout;
  if (!request.partners.empty() || !request.inside.empty() || !request.as.empty() || !request.series.empty() ||
      request.frame > 0 || request.time_s || request.crop) {
    throw LoadError("is read as bare numbers, of which 'type' and its shape are all; leave other keys of reading out");
  }
  for (const std::int64_t n : layout.dims) {
    if (n < 1) throw LoadError("has numbers of a type that is given, but in no shape; give dims = [x, y, z], too");
  }
  const std::string axes = protocol::axes_of(layout);
  std::vector<std::int64_t> lengths;
  for (const char axis : axes) lengths.push_back(layout.dims[static_cast<std::size_t>(axis - 'x')]);
  if (layout.components == "first") lengths.insert(lengths.begin(), 3);
  if (layout.components == "last") lengths.push_back(3);
  raw_ = arranged(protocol::type_named(layout.type), lengths, layout);
  raw_.swapped = (layout.byte_order == "big") == (std::endian::native == std::endian::little);

  header.format = "raw";
  header.default_unit = "m";
  protocol::FieldHeader field;
  field.name = raw_.components == 3 ? "vector" : "value";
  field.grid = protocol::placed_by(layout, header);
  protocol::VectorTurn none;  // the grid's axes are the world's
  keep(raw_, none, field, header.warnings);
  header.fields.push_back(field);

  std::uint64_t wanted = 0;
  file_ = map_file(request.path);
  const std::uint64_t bytes = file_->bytes();
  offset_ = static_cast<std::uint64_t>(layout.header_bytes);
  const auto counted = protocol::voxel_bytes(field);
  const bool possible = counted && !__builtin_mul_overflow(*counted / size_of(field.type), size_of(raw_.type), &wanted) &&
                        !__builtin_add_overflow(wanted, offset_, &wanted);
  if (!possible) throw LoadError("cannot have as many voxels as dims says; correct dims");
  if (wanted > bytes) {
    throw LoadError("has " + std::to_string(bytes) + " bytes, where dims, type and header_bytes need " +
                    std::to_string(wanted) + "; correct them, or get the whole file");
  }
  if (wanted < bytes) {
    header.warnings.push_back("has " + std::to_string(bytes - wanted) +
                              " bytes more than dims, type and header_bytes need: if they are before the voxels, header_bytes "
                              "has to count them");
  }
}

bool RawFile::kept_in_place() const noexcept {
  return offset_ % size_of(raw_.type) == 0 && kept_as_they_are(raw_, {}, header.fields[0]);
}

bool RawFile::is_whole() const noexcept { return file_->is_whole(); }

std::shared_ptr<const std::byte> RawFile::mapped() const { return {file_, first()}; }

std::shared_ptr<const std::byte> RawFile::copied() const {
  const std::uint64_t bytes = protocol::voxel_bytes(header.fields[0]).value();
  const std::shared_ptr<std::byte> voxels = fresh_memory(bytes);
  if (kept_as_they_are(raw_, {}, header.fields[0])) {
    constexpr std::int64_t worth_a_thread = 1 << 20;  // [bytes] fewer: thread overhead; more: idle cores
    in_parts(static_cast<std::int64_t>(bytes), worth_a_thread, [&](std::int64_t from, std::int64_t to) {
      std::memcpy(voxels.get() + from, first() + from, static_cast<std::size_t>(to - from));
    });
  } else {
    copy_voxels(first(), raw_, {}, header.fields[0], voxels.get());
  }
  return voxels;
}

}  // namespace palpa::detail
