// DICOM files for tests, written element by element, without a library whose mistakes the reader could share.
#pragma once

#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>

#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "files.h"

namespace palpa::test {

/// Elements of a data set, by tag 0xGGGGEEEE.
class DicomElements {
 public:
  void set(std::uint32_t tag, const char* vr, std::string value) {
    if (value.size() % 2 != 0) value += std::string(vr) == "UI" || std::string(vr) == "OB" ? '\0' : ' ';
    elements_[tag] = {vr, std::move(value)};
  }
  void set_short(std::uint32_t tag, int value, const char* vr = "US") {
    elements_[tag] = {vr, bytes_of(static_cast<std::uint16_t>(value))};
  }
  void set_items(std::uint32_t tag, const std::vector<DicomElements>& items) {
    std::string bytes;
    for (const DicomElements& item : items) {
      const std::string content = item.bytes(true);
      bytes += bytes_of(std::uint16_t{0xfffe}) + bytes_of(std::uint16_t{0xe000}) +
               bytes_of(static_cast<std::uint32_t>(content.size())) + content;
    }
    elements_[tag] = {"SQ", bytes};
  }
  void erase(std::uint32_t tag) { elements_.erase(tag); }

  /// Little endian, with or without the types of the elements.
  std::string bytes(bool explicit_types) const {
    std::string all;
    for (const auto& [tag, element] : elements_) {
      const auto& [vr, value] = element;
      const auto size = static_cast<std::uint32_t>(value.size());
      all += bytes_of(static_cast<std::uint16_t>(tag >> 16)) + bytes_of(static_cast<std::uint16_t>(tag));
      if (!explicit_types) {
        all += bytes_of(size);
      } else if (vr == "OW" || vr == "OB" || vr == "SQ" || vr == "UN") {
        all += vr + std::string(2, '\0') + bytes_of(size);
      } else {
        all += vr + bytes_of(static_cast<std::uint16_t>(size));
      }
      all += value;
    }
    return all;
  }

 private:
  std::map<std::uint32_t, std::pair<std::string, std::string>> elements_;
};

inline std::string decimal(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", number);
  return text;
}
inline std::string decimals(const Vec3& v) { return decimal(v.x) + "\\" + decimal(v.y) + "\\" + decimal(v.z); }

/// A series of CT images in LPS millimetres, whose values are a linear function of the position.
struct DicomSeries {
  std::int64_t columns = 8, rows = 6;
  double column_mm = 0.8, row_mm = 1.1;  ///< from column to column, from row to row
  Vec3 right{1, 0, 0}, down{0, 1, 0};
  Vec3 origin_mm{-20.5, 11.25, 700};
  Vec3 step_mm{0, 0, 2.5};
  std::string uid = "1.2.3";
  double slope = 1, intercept = -1024;
  bool negative = false;  ///< two's complement
  int stored = 16;        ///< [bits]
  Linear linear{{30'000, -20'000, 10'000}, -6'000};
  const char* syntax = "1.2.840.10008.1.2.1";

  Vec3 at_mm(const Vec3& index) const {
    return origin_mm + index.x * column_mm * right + index.y * row_mm * down + index.z * step_mm;
  }
  /// The pixels of a slice that begins at a position.
  std::string pixels(const Vec3& position_mm) const {
    std::string bytes;
    for (std::int64_t j = 0; j < rows; ++j) {
      for (std::int64_t i = 0; i < columns; ++i) {
        const Vec3 here_mm = position_mm + static_cast<double>(i) * column_mm * right + static_cast<double>(j) * row_mm * down;
        const double raw = std::round((linear(1e-3 * here_mm) - intercept) / slope);
        bytes += negative ? bytes_of(static_cast<std::int16_t>(raw)) : bytes_of(static_cast<std::uint16_t>(raw));
      }
    }
    return bytes;
  }
  DicomElements image(const Vec3& position_mm, int number) const {
    DicomElements e;
    e.set(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.2");
    e.set(0x00080018, "UI", uid + "." + std::to_string(number));
    e.set(0x00080060, "CS", "CT");
    e.set(0x00100010, "PN", "DOE^JANE");
    e.set(0x00100030, "DA", "19700101");
    e.set(0x00180050, "DS", "2.5");
    e.set(0x0020000d, "UI", "1.2");
    e.set(0x0020000e, "UI", uid);
    e.set(0x00200011, "IS", "7");
    e.set(0x00200013, "IS", std::to_string(number));
    e.set(0x00200032, "DS", decimals(position_mm));
    e.set(0x00200037, "DS", decimals(right) + "\\" + decimals(down));
    e.set(0x00200052, "UI", "1.2.9");
    e.set_short(0x00280002, 1);
    e.set(0x00280004, "CS", "MONOCHROME2");
    e.set_short(0x00280010, static_cast<int>(rows));
    e.set_short(0x00280011, static_cast<int>(columns));
    e.set(0x00280030, "DS", decimal(row_mm) + "\\" + decimal(column_mm));
    e.set_short(0x00280100, 16);
    e.set_short(0x00280101, stored);
    e.set_short(0x00280102, stored - 1);
    e.set_short(0x00280103, negative ? 1 : 0);
    e.set(0x00281052, "DS", decimal(intercept));
    e.set(0x00281053, "DS", decimal(slope));
    e.set(0x7fe00010, "OW", pixels(position_mm));
    return e;
  }
  std::string file(const DicomElements& elements) const {
    DicomElements meta;
    meta.set(0x00020001, "OB", std::string("\0\1", 2));
    meta.set(0x00020002, "UI", "1.2.840.10008.5.1.4.1.1.2");
    meta.set(0x00020003, "UI", "1.2.3.4");
    meta.set(0x00020010, "UI", syntax);
    const std::string rest = meta.bytes(true);
    meta.set(0x00020000, "UL", bytes_of(static_cast<std::uint32_t>(rest.size())));
    return std::string(128, '\0') + "DICM" + meta.bytes(true) + elements.bytes(std::string(syntax) != "1.2.840.10008.1.2");
  }
};

/// A file whose elements are deflated as a whole.
inline std::string deflated_file(DicomSeries series, const DicomElements& image) {
  series.syntax = "1.2.840.10008.1.2.1.99";
  const std::string whole = series.file(image), elements = image.bytes(true), packed = gzipped(elements);
  // Of gzip's frame, 10 bytes before and 8 behind are not deflate's.
  return whole.substr(0, whole.size() - elements.size()) + packed.substr(10, packed.size() - 18);
}

/// Compresses the image of a file, by GDCM.
inline void compress_dicom(const fs::path& file, gdcm::TransferSyntax::TSType type) {
  const std::string name = file.string();
  gdcm::ImageReader reader;
  reader.SetFileName(name.c_str());
  ASSERT_TRUE(reader.Read());
  gdcm::ImageChangeTransferSyntax change;
  change.SetTransferSyntax(gdcm::TransferSyntax(type));
  change.SetInput(reader.GetImage());
  ASSERT_TRUE(change.Change());
  gdcm::ImageWriter writer;
  writer.SetFileName(name.c_str());
  writer.SetFile(reader.GetFile());
  writer.SetImage(change.GetOutput());
  ASSERT_TRUE(writer.Write());
}

}  // namespace palpa::test
