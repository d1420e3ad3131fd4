// Voxels that lie in a file as bare numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "palpa/base/input_file.h"
#include "palpa/file/protocol_voxels.h"

namespace palpa::reader {

/// Voxels of a file from an offset on: with i fastest, k slowest, and frame after frame, rows of slices can be read alone, and
/// whole frames by several threads.
class RawRows {
 public:
  /// \param offset  [bytes] of the first voxel of the first frame
  /// \param frames  [1] to read
  RawRows(const std::string& path, std::uint64_t offset, const protocol::RawVoxels& raw, std::int64_t frames);

  /// Whether all voxels are there, in this order.
  bool can_read() const noexcept;
  /// Writes rows of a slice of the first frame as `copy_voxels` does. Throws LoadError, with a sentence.
  void read(const protocol::VectorTurn& turn, const protocol::FieldHeader& field, std::int64_t slice, std::int64_t first,
            std::int64_t count, std::byte* to) const;
  /// Writes frame n to `to[n]` likewise. \param put  as of Source
  void read_frames(const protocol::VectorTurn& turn, const protocol::FieldHeader& field, const std::vector<std::byte*>& to,
                   const std::function<void(std::byte*, const std::byte*, std::uint64_t)>& put) const;

 private:
  void read_voxels(const protocol::VectorTurn& turn, const protocol::FieldHeader& field, std::int64_t first, std::int64_t count,
                   std::byte* to) const;

  detail::InputFile file_;
  std::uint64_t offset_;
  protocol::RawVoxels raw_;
  std::int64_t frames_;
};

}  // namespace palpa::reader
