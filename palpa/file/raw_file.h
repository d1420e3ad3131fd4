// Files of bare numbers, with a shape from the request.
#pragma once

#include <memory>

#include "palpa/base/mapped_file.h"
#include "palpa/file/protocol.h"
#include "palpa/file/protocol_voxels.h"

namespace palpa::detail {

/// Unparsed file of numbers, so without palpa-read. Mapped for the lifetime of this object and of voxels inside the mapping.
class RawFile {
 public:
  /// Maps the file of `request.layout`. Allocates no voxels. Throws LoadError with a sentence.
  explicit RawFile(const protocol::Request& request);

  protocol::Header header;  ///< of one field

  /// Whether the file's numbers are the voxels, in place.
  bool kept_in_place() const noexcept;

  /// Voxels in the mapping. Requires kept_in_place().
  std::shared_ptr<const std::byte> mapped() const;
  /// Immutable copy.
  std::shared_ptr<const std::byte> copied() const;
  /// False if the file was truncated meanwhile: lost voxels were read as zeros.
  bool is_whole() const noexcept;

 private:
  const std::byte* first() const noexcept { return file_->data() + offset_; }

  std::shared_ptr<const MappedFile> file_;
  std::uint64_t offset_ = 0;  ///< [bytes] of the first voxel
  protocol::RawVoxels raw_;
};

}  // namespace palpa::detail
