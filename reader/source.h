// A file that palpa-read has opened: its header is known at once, its voxels are read when the caller has memory for them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "palpa/core/load_error.h"
#include "palpa/file/protocol.h"
#include "palpa/file/protocol_voxels.h"
#include "palpa/volume/volume.h"

namespace palpa::reader {

using protocol::RawType;
using protocol::RawVoxels;
using protocol::Turn;

class Source {
 public:
  virtual ~Source() = default;

  protocol::Header header;         ///< complete once opened
  std::vector<std::string> files;  ///< every file that the voxels come from

  struct {
    bool crop = false, time = false, partners = false, inside = false, layout = false, series = false, index_axes = false;
  } takes;  ///< which options of a request this format knows; others are refused

  std::int64_t frames_read = 1;  ///< which `read` writes: one, or all of the file

  std::vector<Resampling> resampled;  ///< one for each wanted field, once read; empty if the grid is the file's own

  std::vector<std::string> warnings;  ///< those that are known only after reading

  /// Copies voxels to a place behind a pointer that `read` got. Faster than writing there, because a page fault for every page
  /// of shared memory takes twice as long as the copy. Thread-safe for places that do not overlap.
  std::function<void(std::byte* to, const std::byte* from, std::uint64_t bytes)> put;

  /// Writes the voxels of field `wanted[i]` to `to[i]`, and those of the n-th frame that is read to `to[i + n *
  /// wanted.size()]`. Throws LoadError with a sentence.
  virtual void read(const std::vector<std::uint32_t>& wanted, const std::vector<std::byte*>& to) = 0;

  /// Checks what the library does not: damage that leaves the voxels complete but wrong. Runs during `read` in another thread,
  /// so it must not use what `read` changes. Throws LoadError with a sentence.
  virtual void check_files() const {}

 protected:
  /// Notes how many frames the file has, and which of them are read: the one asked for, all, or the first, with a warning.
  /// \return  the number of the first that is read. Throws LoadError.
  std::int64_t choose_frames(const protocol::Request& request, std::int64_t frames);
};

// Each format has in reader/NAME.cpp its
//   std::unique_ptr<Source> open_NAME(const protocol::Request& request);
// which throws LoadError with "what is wrong; what would be right", without the file's name, and takes no memory for voxels (a
// legacy VTK file does, but no more than it has bytes). It is declared by format_program.cpp.

/// Notes bytes of a file behind its voxels, which may stand before them as well, so that all voxels would be shifted.
/// \param key  of the header, that says where the voxels begin
void note_left_over(std::uint64_t there, std::uint64_t needed, const char* key, std::vector<std::string>& warnings);

/// Where the file lies that a packed one was unpacked into, in memory.
inline constexpr const char* unpacked_folder = "/proc/self/fd/";

/// Bytes of a file, or of all files in a folder; 0 where that cannot be found out.
std::uint64_t file_bytes(const std::string& path);

}  // namespace palpa::reader
