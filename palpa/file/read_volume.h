// Volumes from files, through the program palpa-read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>

#include "palpa/base/load_error.h"
#include "palpa/data/volume.h"

namespace palpa {

/// How palpa-read is run, and what it may take.
struct ReadOptions {
  std::filesystem::path reader;  ///< palpa-read; empty: $PALPA_READER, beside this program, libexec
  std::uint64_t max_bytes =
      0;                       ///< voxels larger than this are refused before memory is taken; 0: two thirds of the free memory
  double idle_limit_s = 10.0;  ///< without progress (CPU time or bytes read) the reader is ended; > 0
  bool preview = false;  ///< only to look at: a file of bare numbers is mapped, not copied, and a large one not read as a whole
  bool checksums = true;   ///< of the files, which recordings keep; without them plain voxels are read twice as fast
  std::stop_token stop{};  ///< once it is asked to stop the reader is ended within 0.1 s, with a LoadError
};

/// Opens the file(s) of a request. The files are parsed by a child program with limits of its own, so
/// that no damaged file can crash, hang or fill this process. Returns the fields in world metres (LPS
/// for medical data). Throws LoadError with one line: `FILE: what is wrong; what would be right`.
///
/// A file of bare numbers (`layout.type`) needs no parser and no child.
///
/// The voxels lie in memory that nobody can change any more, and stay as long as a field of the
/// volume does. Blocks while the file is read; any number of threads may open files at once.
Volume read_volume(const VolumeRequest& request, const ReadOptions& options = {});
/// One file with its defaults.
Volume read_volume(const std::filesystem::path& file, const ReadOptions& options = {});

/// `read_volume` with these options, for `load_scene`.
VolumeReader volume_reader(ReadOptions options = {});

/// A volume and what its file holds beside it.
struct VolumeFile {
  Volume volume;
  int frames = 1;  ///< of which the volume is one
};
/// `read_volume`, and what else is to know.
VolumeFile read_volume_file(const VolumeRequest& request, const ReadOptions& options = {});

}  // namespace palpa
