// Reading of volumes from files, by the program palpa-read.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/data/volume.h"

namespace palpa {

/// Part of a file that holds several.
struct FilePart {
  std::string name;         ///< UID of a series, path of an array, name of a label
  std::string words;        ///< modality, number and protocol of a series; lengths of an array's indices; of a label empty
  std::int64_t number = 0;  ///< images of a series, numbers in an array, value of a label
  friend bool operator==(const FilePart&, const FilePart&) = default;
};
/// Array that can be a field, or a component of one.
struct FileArray {
  std::string name;
  std::string unit;
  int components = 1;
  std::array<std::int64_t, 3> dims{};
};
/// Content of a file, known before its voxels are read.
struct FileContents {
  std::string format;            ///< as `Volume::format`
  std::vector<FilePart> series;  ///< of DICOM, in the order of their files
  std::vector<FilePart> labels;  ///< of a DICOM segmentation
  std::vector<FileArray> arrays;
  std::vector<FilePart> alternatives;  ///< arrays of which a request names one, as FILE:/PATH; empty: `arrays` is read
};

/// Options and limits of palpa-read.
struct ReadOptions {
  std::filesystem::path reader;  ///< palpa-read; empty: $PALPA_READER, beside this program, libexec
  std::uint64_t max_bytes = 0;   ///< larger voxels are refused before allocation; 0: two thirds of the free memory
  double idle_limit_s = 10.0;    ///< without progress (CPU time or bytes read) the reader is ended; > 0
  bool preview = false;    ///< for display only: a file of bare numbers is mapped, not copied, and a large one read in part
  Checksums checksums = Checksums::now;  ///< of the files, for recordings; later or without them the voxels come sooner
  std::stop_token stop{};  ///< a stop ends the reader within 0.1 s, with a LoadError
  std::function<void(const FileContents&)> found{};  ///< called before the voxels are read; may throw to end the reading
};

/// Opens the file(s) of a request. A child process with limits of its own parses them, so that no damaged file can crash, hang
/// or fill this process. Returns the fields in world metres (LPS for medical data). Throws LoadError with one line: `FILE: what
/// is wrong; what would be right`.
///
/// A file of bare numbers (`layout.type`) needs no parser and no child.
///
/// The voxels are in immutable memory, for the lifetime of the volume's fields. Blocks while the file is read; any number of
/// threads may open files at once.
Volume read_volume(const VolumeRequest& request, const ReadOptions& options = {});
/// A file with default options.
Volume read_volume(const std::filesystem::path& file, const ReadOptions& options = {});

/// `read_volume` with these options, for `load_scene`.
VolumeReader volume_reader(ReadOptions options = {});

/// Volume, with further content of its file.
struct VolumeFile {
  Volume volume;
  int frames = 1;  ///< total, of which the volume is one
  FileContents contents{};
};
/// `read_volume` with further content.
VolumeFile read_volume_file(const VolumeRequest& request, const ReadOptions& options = {});

}  // namespace palpa
