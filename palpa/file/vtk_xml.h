// VTK's XML files as they are written here. Numbers stand within the text, as base64: ParaView 5.11 of Debian 12 opens no file
// that has them behind it (`appended`), as its XML parser does not get past them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "palpa/base/new_file.h"

namespace palpa::detail {

/// The first lines of a file of this type of data: "ImageData", "PolyData". It ends with "</VTKFile>\n".
std::string vtk_xml_begin(std::string_view type);

/// An array, in as many parts as its bytes come in. Throws LoadError as NewFile does.
class VtkArrayWriter {
 public:
  /// \param type   of its numbers: "Float64"
  /// \param name   cleaned here
  /// \param bytes  of all its numbers together
  VtkArrayWriter(NewFile& to, std::string_view type, std::string_view name, int components, std::uint64_t bytes);
  void write(const void* data, std::size_t bytes);
  void finish();

 private:
  void put_letters();

  NewFile& to_;
  std::uint32_t waiting_ = 0;  ///< bytes that wait for a third, the last one lowest
  unsigned count_ = 0;         ///< how many
  std::string text_;
};

}  // namespace palpa::detail
