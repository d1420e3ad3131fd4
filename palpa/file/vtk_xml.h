// Writer of VTK's XML files. Numbers are inline, as base64: the XML parser of ParaView 5.11 (Debian 12) fails on numbers at the
// end (`appended`).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "palpa/base/new_file.h"

namespace palpa::detail {

/// First lines of a file of a data type: "ImageData", "PolyData". It ends with "</VTKFile>\n".
std::string vtk_xml_begin(std::string_view type);

/// Array, written in pieces of any size. Throws LoadError as NewFile does.
class VtkArrayWriter {
 public:
  /// \param type   of its numbers: "Float64"
  /// \param name   escaped here
  /// \param bytes  total of its numbers
  VtkArrayWriter(NewFile& to, std::string_view type, std::string_view name, int components, std::uint64_t bytes);
  void write(const void* data, std::size_t bytes);
  void finish();

 private:
  void put_letters();

  NewFile& to_;
  std::uint32_t waiting_ = 0;  ///< pending bytes of a group of three, the last one lowest
  unsigned count_ = 0;         ///< number of pending bytes
  std::string text_;
};

}  // namespace palpa::detail
