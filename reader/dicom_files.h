// Files of DICOM images: headers as slices, voxels.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "dicom_slices.h"

namespace palpa::reader {

class DicomFiles {
 public:
  /// Opens the DICOM files of a folder and its subfolders, by name; or one file. Reads only geometry, order, value scales and
  /// acquisition, never elements about a patient, and of free text only known words (dicom_words.h). Throws LoadError.
  /// \param memory  memory file for a compressed file, of at most `most_bytes` decompressed; -1: none
  DicomFiles(const std::string& path, int memory, std::uint64_t most_bytes);

  /// All usable images, file after file.
  const std::vector<Slice>& slices() const noexcept { return slices_; }
  /// Reasons against images, as half sentences, each with its number of files.
  const std::map<std::string, int>& refused() const noexcept { return refused_; }
  /// Number of files without an image, or damaged.
  int damaged() const noexcept { return damaged_; }

  const std::string& name(const Slice& slice) const { return names_[static_cast<std::size_t>(slice.file)]; }
  std::string modality(const Slice& slice) const;
  /// Unit of the values, from the file's standard code; for a CT without a code "HU". Empty: none.
  std::string unit(const Slice& slice) const;
  std::vector<ScanFact> scan(const Slice& slice) const;
  /// Modality, number and known words of the description of the series: "CT 201 head bone".
  std::string series_words(const Slice& slice) const;
  /// Names and numbers of the segments of a segmentation; empty for other files and for fractions.
  std::vector<FilePart> segments(const Slice& slice) const;
  /// True for a segmentation whose images are 1 in one segment and 0 elsewhere.
  bool is_binary(const Slice& slice) const;
  /// Bytes of all frames of the slice's file, in memory and in the file.
  std::uint64_t voxel_bytes(const Slice& slice) const;
  std::uint64_t stored_bytes(const Slice& slice) const;

  /// Reads all frames of the slice's file to `to`, of `voxel_bytes`. `masked`: clears bits outside of the stored ones. Throws
  /// LoadError with a half sentence.
  void load(const Slice& slice, bool masked, std::byte* to);

 private:
  class Reader;
  void add_slices(int file);
  std::string unpacked(const std::string& name) const;

  struct Delete {
    void operator()(Reader* reader) const;
  };
  std::unique_ptr<Reader, Delete> reader_;
  std::vector<std::string> names_;
  int memory_;
  std::uint64_t most_bytes_;
  std::vector<Slice> slices_;
  std::map<std::string, int> refused_;
  int damaged_ = 0;
};

}  // namespace palpa::reader
