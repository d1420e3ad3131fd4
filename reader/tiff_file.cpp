#include "tiff_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "palpa/base/load_error.h"

namespace palpa::reader {
namespace {

using protocol::RawType;

constexpr std::size_t most_images = std::size_t{1}
                                    << 18;  // [1] of a file. More: a hostile list takes longer; fewer: refuses stacks
constexpr std::int64_t most_side = std::int64_t{1} << 18;          // [pixels] as of stores
constexpr std::uint64_t most_tile_bytes = std::uint64_t{1} << 28;  // More: memory of a hostile file; less: refuses single tiles

std::optional<RawType> type_of(int bits, int format) {
  if (format == SAMPLEFORMAT_IEEEFP)
    return bits == 32 ? std::optional(RawType::float32) : bits == 64 ? std::optional(RawType::float64) : std::nullopt;
  const bool has_sign = format == SAMPLEFORMAT_INT;
  if (!has_sign && format != SAMPLEFORMAT_UINT && format != SAMPLEFORMAT_VOID) return std::nullopt;
  switch (bits) {
    case 8: return has_sign ? RawType::int8 : RawType::uint8;
    case 16: return has_sign ? RawType::int16 : RawType::uint16;
    case 32: return has_sign ? RawType::int32 : RawType::uint32;
    case 64: return has_sign ? RawType::int64 : RawType::uint64;
    default: return std::nullopt;
  }
}

}  // namespace

TiffFile::TiffFile(const std::string& path) : stream_(new Stream{detail::InputFile(path)}) {
  TIFFSetErrorHandler(nullptr), TIFFSetWarningHandler(nullptr);
  if (!stream_->file.is_open()) throw LoadError(stream_->file.problem() + "; give a file that can be read");
  const auto read = [](thandle_t handle, void* to, tmsize_t bytes) -> tmsize_t {
    auto* const stream = static_cast<Stream*>(handle);
    try {
      const std::size_t got = stream->file.read(stream->at, to, static_cast<std::size_t>(std::max<tmsize_t>(bytes, 0)));
      stream->at += got;
      stream->met_end = stream->met_end || got < static_cast<std::size_t>(bytes);
      return static_cast<tmsize_t>(got);
    } catch (const LoadError&) {
      return -1;
    }
  };
  const auto seek = [](thandle_t handle, toff_t offset, int from) -> toff_t {
    auto* const stream = static_cast<Stream*>(handle);
    return stream->at = offset + (from == SEEK_CUR ? stream->at : from == SEEK_END ? stream->file.bytes() : 0);
  };
  const auto size = [](thandle_t handle) -> toff_t { return static_cast<Stream*>(handle)->file.bytes(); };
  // "m": no mapping, which a file that is cut meanwhile would turn into a signal.
  tiff_.reset(TIFFClientOpen(
      path.c_str(), "rm", stream_.get(), read, [](thandle_t, void*, tmsize_t) -> tmsize_t { return -1; }, seek,
      [](thandle_t) { return 0; }, size, [](thandle_t, void**, toff_t*) { return 0; }, [](thandle_t, void*, toff_t) {}));
  if (!tiff_) throw LoadError("cannot be read as TIFF; check that the file is whole");
  place_ = TIFFCurrentDirOffset(tiff_.get());
}

std::vector<std::uint64_t> TiffFile::images() {
  std::vector<std::uint64_t> places;
  do {
    place_ = TIFFCurrentDirOffset(tiff_.get());
    const bool is_preview = (number(TIFFTAG_SUBFILETYPE, 0) & FILETYPE_REDUCEDIMAGE) != 0;
    if (!is_preview || places.empty()) places.push_back(place_);
    if (places.size() > most_images) throw LoadError("holds more than 262144 images; write it as several files");
    // For libtiff a list whose link to the next image is cut is at its end.
    if (TIFFLastDirectory(tiff_.get()) != 0 && !stream_->met_end) return places;
  } while (!stream_->met_end && TIFFReadDirectory(tiff_.get()) == 1);
  throw LoadError("has a list of images that is cut or damaged behind image " + std::to_string(places.size()) +
                  "; get the whole file");
}

void TiffFile::go_to(std::uint64_t place) {
  if (place == place_) return;
  if (TIFFSetSubDirectory(tiff_.get(), place) != 1) throw LoadError("was changed while it was read; try again");
  place_ = place;
}

std::uint32_t TiffFile::number(std::uint32_t tag, std::uint32_t otherwise) const {
  std::uint32_t value = 0;
  return TIFFGetField(tiff_.get(), tag, &value) == 1 ? value : otherwise;
}

std::uint16_t TiffFile::short_number(std::uint32_t tag, std::uint16_t otherwise) const {
  std::uint16_t value = 0;
  return TIFFGetFieldDefaulted(tiff_.get(), tag, &value) == 1 ? value : otherwise;
}

TiffImage TiffFile::image() const {
  TiffImage image{number(TIFFTAG_IMAGEWIDTH, 0), number(TIFFTAG_IMAGELENGTH, 0)};
  if (image.columns < 1 || image.rows < 1) throw LoadError("has an image without pixels; get the whole file");
  if (image.columns > most_side || image.rows > most_side)
    throw LoadError("claims an image of " + std::to_string(image.columns) + " × " + std::to_string(image.rows) +
                    " pixels, where 262144 along an axis can be; the file is damaged, or has to be cut");
  const int samples = short_number(TIFFTAG_SAMPLESPERPIXEL, 1),
            light = short_number(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  const bool is_grey =
      samples == 1 && (light == PHOTOMETRIC_MINISBLACK || light == PHOTOMETRIC_MINISWHITE || light == PHOTOMETRIC_PALETTE);
  if (!is_grey)
    throw LoadError("holds colours, or " + std::to_string(samples) +
                    " numbers a pixel, where one can be felt; export it as grey values");
  const int bits = short_number(TIFFTAG_BITSPERSAMPLE, 1), format = short_number(TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
  const std::optional<RawType> type = type_of(bits, format);
  if (!type)
    throw LoadError("has numbers of " + std::to_string(bits) + " bits" +
                    (format == SAMPLEFORMAT_IEEEFP ? " with fractions" : "") +
                    ", which are not read; export it with 8, 16 or 32 bits");
  image.type = *type;
  if (TIFFIsCODECConfigured(short_number(TIFFTAG_COMPRESSION, COMPRESSION_NONE)) != 1)
    throw LoadError("is compressed by a method that libtiff lacks here; write it without compression (tiffcp -c none IN OUT)");
  const auto row = static_cast<std::uint64_t>(image.columns) * protocol::size_of(image.type);
  const bool fits = TIFFIsTiled(tiff_.get()) != 0 ? TIFFTileSize64(tiff_.get()) > 0 : TIFFScanlineSize64(tiff_.get()) == row;
  if (!fits) throw LoadError("has rows of another length than its size says; the file is damaged");
  if (TIFFIsTiled(tiff_.get()) != 0 && TIFFTileSize64(tiff_.get()) > most_tile_bytes)
    throw LoadError("has tiles of more than 256 MB; write it in smaller ones");
  return image;
}

double TiffFile::resolution(std::uint32_t tag) const {
  float value = 0;
  return TIFFGetField(tiff_.get(), tag, &value) == 1 && std::isfinite(value) && value > 0 ? static_cast<double>(value) : 0.0;
}

int TiffFile::resolution_unit() const { return short_number(TIFFTAG_RESOLUTIONUNIT, RESUNIT_INCH); }

std::string TiffFile::description() const {
  const char* text = nullptr;
  return TIFFGetField(tiff_.get(), TIFFTAG_IMAGEDESCRIPTION, &text) == 1 && text != nullptr ? text : "";
}

std::uint64_t TiffFile::first_voxel() const { return TIFFIsTiled(tiff_.get()) != 0 ? 0 : TIFFGetStrileOffset(tiff_.get(), 0); }

bool TiffFile::is_compressed() const { return short_number(TIFFTAG_COMPRESSION, COMPRESSION_NONE) != COMPRESSION_NONE; }

bool TiffFile::is_big_endian() const { return TIFFIsBigEndian(tiff_.get()) != 0; }

bool TiffFile::is_in_one_piece() const {
  if (TIFFIsTiled(tiff_.get()) != 0 || is_compressed()) return false;
  std::uint64_t end = first_voxel();
  for (std::uint32_t n = 0; n < TIFFNumberOfStrips(tiff_.get()); ++n) {
    if (TIFFGetStrileOffset(tiff_.get(), n) != end) return false;
    end += TIFFGetStrileByteCount(tiff_.get(), n);
  }
  return true;
}

bool TiffFile::has_colour_table() const {
  return short_number(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK) == PHOTOMETRIC_PALETTE;
}

bool TiffFile::is_turned() const { return short_number(TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT) != ORIENTATION_TOPLEFT; }

std::uint64_t TiffFile::working_bytes() const {
  if (TIFFIsTiled(tiff_.get()) != 0) return 2 * TIFFTileSize64(tiff_.get());
  return std::min<std::uint64_t>(stream_->file.bytes(), TIFFStripSize64(tiff_.get()));
}

void TiffFile::read_rows(const TiffImage& image, std::int64_t first, std::int64_t count, std::byte* to) {
  if (TIFFIsTiled(tiff_.get()) != 0) return read_tiles(image, first, count, to);
  const std::size_t row_bytes = static_cast<std::size_t>(image.columns) * protocol::size_of(image.type);
  for (std::int64_t row = first; row < first + count; ++row, to += row_bytes) {
    if (TIFFReadScanline(tiff_.get(), to, static_cast<std::uint32_t>(row), 0) != 1)
      throw LoadError("is cut or damaged at row " + std::to_string(row) + "; get the whole file");
  }
}

void TiffFile::read_unlisted_rows(const TiffImage& image, std::uint64_t at, std::int64_t first, std::int64_t count,
                                  std::byte* to) {
  const std::size_t number_bytes = protocol::size_of(image.type);
  const auto row_bytes = static_cast<std::uint64_t>(image.columns) * number_bytes;
  const std::uint64_t bytes = row_bytes * static_cast<std::uint64_t>(count);
  if (stream_->file.read(at + row_bytes * static_cast<std::uint64_t>(first), to, bytes) != bytes)
    throw LoadError("was cut while it was read; get the whole file");
  if (!is_big_endian()) return;
  const auto numbers = static_cast<tmsize_t>(bytes / number_bytes);
  if (number_bytes == 2) TIFFSwabArrayOfShort(reinterpret_cast<std::uint16_t*>(to), numbers);
  if (number_bytes == 4) TIFFSwabArrayOfLong(reinterpret_cast<std::uint32_t*>(to), numbers);
  if (number_bytes == 8) TIFFSwabArrayOfLong8(reinterpret_cast<std::uint64_t*>(to), numbers);
}

void TiffFile::read_tiles(const TiffImage& image, std::int64_t first, std::int64_t count, std::byte* to) {
  const std::size_t bytes = protocol::size_of(image.type);
  const std::int64_t width = number(TIFFTAG_TILEWIDTH, 0), height = number(TIFFTAG_TILELENGTH, 0);
  tile_.resize(static_cast<std::size_t>(TIFFTileSize64(tiff_.get())));
  if (width < 1 || height < 1 || static_cast<std::uint64_t>(width * height) * bytes != tile_.size())
    throw LoadError("has tiles of another size than it says; the file is damaged");
  for (std::int64_t top = first / height * height; top < first + count; top += height)
    for (std::int64_t left = 0; left < image.columns; left += width) {
      const auto read =
          TIFFReadTile(tiff_.get(), tile_.data(), static_cast<std::uint32_t>(left), static_cast<std::uint32_t>(top), 0, 0);
      if (read != static_cast<tmsize_t>(tile_.size()))
        throw LoadError("is cut or damaged in the tile at row " + std::to_string(top) + "; get the whole file");
      const std::int64_t end = std::min({top + height, first + count, image.rows});
      const std::size_t piece = static_cast<std::size_t>(std::min(width, image.columns - left)) * bytes;
      for (std::int64_t row = std::max(top, first); row < end; ++row)
        std::memcpy(to + static_cast<std::size_t>((row - first) * image.columns + left) * bytes,
                    tile_.data() + static_cast<std::size_t>((row - top) * width) * bytes, piece);
    }
}

}  // namespace palpa::reader
