// Files of bare numbers, whose shape the request says.
#pragma once

#include <memory>

#include "palpa/base/mapped_file.h"
#include "palpa/file/protocol.h"
#include "palpa/file/protocol_voxels.h"

namespace palpa::detail {

/// A file of numbers alone: nothing in it is parsed, so no palpa-read is needed. It is mapped while this object lives, and as
/// long as voxels that are the file's own do.
class RawFile {
 public:
  /// Maps the file that `request.layout` describes. Allocates nothing for voxels. Throws LoadError with a sentence.
  explicit RawFile(const protocol::Request& request);

  protocol::Header header;  ///< of one field

  /// Whether the numbers of the file are what is kept, as they lie there.
  bool kept_in_place() const noexcept;

  /// The voxels as they lie in the file. Only where kept_in_place().
  std::shared_ptr<const std::byte> mapped() const;
  /// A copy that nobody can change.
  std::shared_ptr<const std::byte> copied() const;
  /// False where somebody has cut the file short meanwhile: voxels that are gone were read as zeros.
  bool is_whole() const noexcept;

 private:
  const std::byte* first() const noexcept { return file_->data() + offset_; }

  std::shared_ptr<const MappedFile> file_;
  std::uint64_t offset_ = 0;  ///< [bytes] of the first voxel
  protocol::RawVoxels raw_;
};

}  // namespace palpa::detail
