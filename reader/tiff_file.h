// Images of a TIFF file, row by row, by libtiff.
#pragma once

#include <tiffio.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "palpa/base/input_file.h"
#include "palpa/file/protocol_voxels.h"

namespace palpa::reader {

/// Properties of an image that all slices of a stack share.
struct TiffImage {
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  protocol::RawType type = protocol::RawType::uint8;
  friend bool operator==(const TiffImage&, const TiffImage&) = default;
};

/// Open TIFF or BigTIFF. One thread.
class TiffFile {
 public:
  /// Opens the file at its first image. Throws LoadError, with a sentence.
  explicit TiffFile(const std::string& path);

  /// Places of all images but previews, in their order. Leaves the file at another image. Throws LoadError.
  std::vector<std::uint64_t> images();
  /// Goes to an image. Throws LoadError.
  void go_to(std::uint64_t place);
  std::uint64_t place() const noexcept { return place_; }

  /// Checks the image, whose numbers must be single grey values. Throws LoadError.
  TiffImage image() const;
  /// Pixels in a direction per unit of resolution; 0 if not given. \param tag  TIFFTAG_XRESOLUTION or TIFFTAG_YRESOLUTION
  double resolution(std::uint32_t tag) const;
  /// RESUNIT_NONE, RESUNIT_INCH or RESUNIT_CENTIMETER.
  int resolution_unit() const;
  /// Text of the image; empty if there is none.
  std::string description() const;
  /// [bytes] Offset of the first voxel.
  std::uint64_t first_voxel() const;
  bool is_compressed() const;
  bool is_big_endian() const;
  /// Numbers lie uncompressed, row behind row, without a gap.
  bool is_in_one_piece() const;
  /// [bytes] Of the file.
  std::uint64_t bytes() const noexcept { return stream_->file.bytes(); }
  /// Numbers mean colours of a table.
  bool has_colour_table() const;
  /// Stored from another corner than the upper left one.
  bool is_turned() const;
  /// [bytes] Memory for decoding beside the rows.
  std::uint64_t working_bytes() const;

  /// Reads rows, in the byte order of the machine. Throws LoadError.
  void read_rows(const TiffImage& image, std::int64_t first, std::int64_t count, std::byte* to);
  /// Reads rows of an image that is in no list. Throws LoadError. \param at  [bytes] of its first number
  void read_unlisted_rows(const TiffImage& image, std::uint64_t at, std::int64_t first, std::int64_t count, std::byte* to);

 private:
  struct Closer {
    void operator()(TIFF* tiff) const { TIFFClose(tiff); }
  };
  void read_tiles(const TiffImage& image, std::int64_t first, std::int64_t count, std::byte* to);
  std::uint32_t number(std::uint32_t tag, std::uint32_t otherwise) const;
  std::uint16_t short_number(std::uint32_t tag, std::uint16_t otherwise) const;

  struct Stream {
    detail::InputFile file;
    std::uint64_t at = 0;  ///< [bytes]
    bool met_end = false;  ///< fewer bytes were there than wanted
  };
  std::unique_ptr<Stream> stream_;
  std::unique_ptr<TIFF, Closer> tiff_;
  std::uint64_t place_ = 0;
  std::vector<std::byte> tile_;
};

}  // namespace palpa::reader
