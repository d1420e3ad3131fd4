// Source: an opened file, with its header; voxels are read later, when the caller has memory for them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/data/volume.h"
#include "palpa/file/protocol.h"
#include "palpa/file/protocol_voxels.h"

namespace palpa::reader {

using protocol::RawType;
using protocol::RawVoxels;
using protocol::VectorTurn;

class Source {
 public:
  virtual ~Source() = default;

  protocol::Header header;         ///< complete once opened
  std::vector<std::string> files;  ///< all files with voxels

  struct {
    bool crop = false, time = false, partners = false, inside = false, layout = false, series = false, index_axes = false;
  } takes;  ///< options of a request for this format; others are refused

  std::int64_t frames_read = 1;  ///< frames that `read` writes: one, or all of the file

  std::vector<Resampling> resampled;  ///< one per wanted field, once read; empty if the grid is the file's own

  std::vector<std::string> warnings;  ///< known only after reading

  /// Copies voxels behind a pointer of `read`. Writing there is slower: a fault per page of shared memory takes twice as long
  /// as the copy. Thread-safe for separate ranges.
  std::function<void(std::byte* to, const std::byte* from, std::uint64_t bytes)> put;

  /// Writes the voxels of field `wanted[i]` to `to[i]`, and those of the n-th read frame to `to[i + n * wanted.size()]`. Throws
  /// LoadError with a sentence.
  virtual void read(const std::vector<std::uint32_t>& wanted, const std::vector<std::byte*>& to) = 0;

  /// Writes rows of a slice of a field, in the frame to read; of formats with `header.reads_rows`. Throws LoadError with a
  /// sentence. \param slice  [voxels] along k \param first  [voxels] along j
  virtual void read_rows(std::uint32_t field, std::int64_t slice, std::int64_t first, std::int64_t count, std::byte* to);

  /// Answers requests for chunks until the caller leaves. Throws LoadError with a sentence, also for a format without chunks.
  virtual void serve_chunks(int socket);

  /// Checks for damage that the library does not detect: complete but wrong voxels. Runs in another thread during `read`, so it
  /// must not use data that changes there. Throws LoadError with a sentence.
  virtual void check_files() const {}

 protected:
  /// Stores the number of frames, and the frames to read: the requested one, all, or the first with a warning.
  /// \return  index of the first frame to read. Throws LoadError.
  std::int64_t choose_frames(const protocol::Request& request, std::int64_t frames);
};

// Each format defines in reader/NAME.cpp
//   std::unique_ptr<Source> open_NAME(const protocol::Request& request);
// which throws LoadError with "what is wrong; what would be right", without the file's name, and takes no memory for voxels (a
// legacy VTK file does, at most its file size). Declared by format_program.cpp.

/// Warns of bytes behind the voxels: if they belong before them, all voxels are shifted.
/// \param key  header key of the voxels' offset
void note_left_over(std::uint64_t there, std::uint64_t needed, const char* key, std::vector<std::string>& warnings);

/// Folder of the memory file with a decompressed file.
inline constexpr const char* unpacked_folder = "/proc/self/fd/";

/// Bytes of a file, or of all files in a folder; 0 if unknown.
std::uint64_t file_bytes(const std::string& path);

}  // namespace palpa::reader
