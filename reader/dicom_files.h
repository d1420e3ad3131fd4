// Files of DICOM images: their headers as slices, their voxels.
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
  /// The DICOM files of a folder and its subfolders, by name; or one file. Reads from their headers only what geometry, order
  /// and values need, and how the images were made. Elements about a patient are never read, and of elements that hold free
  /// text only known words are handed on (dicom_words.h). Throws LoadError.
  /// \param memory  a file of memory for one that has to be unpacked, into at most `most_bytes`; -1: none
  DicomFiles(const std::string& path, int memory, std::uint64_t most_bytes);

  /// All images that can be felt, file after file.
  const std::vector<Slice>& slices() const noexcept { return slices_; }
  /// Reasons why images cannot be felt, as half sentences, each with the number of files that it applies to.
  const std::map<std::string, int>& refused() const noexcept { return refused_; }
  /// Files that hold no image, or are damaged.
  int damaged() const noexcept { return damaged_; }

  const std::string& name(const Slice& slice) const { return names_[static_cast<std::size_t>(slice.file)]; }
  std::string modality(const Slice& slice) const;
  /// The unit of the values, as the file says it by a code of the standard; of a CT that says none: "HU". Empty: none.
  std::string unit(const Slice& slice) const;
  std::vector<ScanFact> scan(const Slice& slice) const;
  /// "CT, 201": modality and number of its series.
  std::string series_words(const Slice& slice) const;
  /// Bytes of all frames of the slice's file, in memory and in the file.
  std::uint64_t voxel_bytes(const Slice& slice) const;
  std::uint64_t stored_bytes(const Slice& slice) const;

  /// Reads all frames of the slice's file to `to`, which holds `voxel_bytes`. `masked`: bits beyond those of the numbers are
  /// cleared. Throws LoadError with a half sentence.
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
