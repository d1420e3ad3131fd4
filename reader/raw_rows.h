// Rows of voxels that lie in a file as bare numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "palpa/base/input_file.h"
#include "palpa/file/protocol_voxels.h"

namespace palpa::reader {

/// Voxels of a file from an offset on: rows of slices can be read alone where i is fastest, k slowest.
class RawRows {
 public:
  /// \param offset  [bytes] of the first voxel
  RawRows(const std::string& path, std::uint64_t offset, const protocol::RawVoxels& raw);

  /// Whether all voxels are there, in this order.
  bool can_read() const noexcept;
  /// Writes rows of a slice as `copy_voxels` does. Throws LoadError, with a sentence.
  void read(const protocol::VectorTurn& turn, const protocol::FieldHeader& field, std::int64_t slice, std::int64_t first,
            std::int64_t count, std::byte* to);

 private:
  detail::InputFile file_;
  std::uint64_t offset_;
  protocol::RawVoxels raw_;
  std::vector<std::byte> room_;
};

}  // namespace palpa::reader
