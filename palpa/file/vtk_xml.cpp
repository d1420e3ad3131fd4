#include "palpa/file/vtk_xml.h"

#include <bit>

#include "palpa/base/escaped.h"

static_assert(std::endian::native == std::endian::little, "the files say so");

namespace palpa::detail {

std::string vtk_xml_begin(std::string_view type) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + std::string(type) +
         "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";
}

VtkArrayWriter::VtkArrayWriter(NewFile& to, std::string_view type, std::string_view name, int components, std::uint64_t bytes)
    : to_(to) {
  to_.write("<DataArray type=\"" + std::string(type) + "\" Name=\"" + escaped(name) + "\" NumberOfComponents=\"" +
            std::to_string(components) + "\" format=\"binary\">\n");
  // One text for the number of bytes and the bytes themselves, as in VTK's uncompressed files.
  write(&bytes, sizeof bytes);
}

void VtkArrayWriter::write(const void* data, std::size_t bytes) {
  const auto* next = static_cast<const unsigned char*>(data);
  text_.clear();
  text_.reserve(bytes / 3 * 4 + 8);
  for (const unsigned char* const end = next + bytes; next != end; ++next) {
    waiting_ = waiting_ << 8 | *next;
    if (++count_ == 3) put_letters();
  }
  to_.write(text_);
}

void VtkArrayWriter::finish() {
  text_.clear();
  if (count_ > 0) {
    waiting_ <<= 8 * (3 - count_);
    put_letters();
  }
  to_.write(text_);
  to_.write("\n</DataArray>\n");
}

void VtkArrayWriter::put_letters() {
  static constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const char four[] = {letters[waiting_ >> 18 & 63], letters[waiting_ >> 12 & 63],
                       count_ > 1 ? letters[waiting_ >> 6 & 63] : '=', count_ > 2 ? letters[waiting_ & 63] : '='};
  text_.append(four, sizeof four);
  waiting_ = 0, count_ = 0;
}

}  // namespace palpa::detail
