// DICOM series made here, with known truth.
#include <fstream>
#include <sstream>

#include "dicom_file.h"

namespace palpa::test {
namespace dicom_test {

using Change = std::function<void(int slice, DicomElements& image)>;

class Dicom : public ReaderTest {
 protected:
  /// Slices at these positions along the step; file names in reverse.
  void write(const DicomSeries& series, const std::vector<double>& places, const Change& change = {},
             const std::string& prefix = "") const {
    for (std::size_t n = 0; n < places.size(); ++n) {
      DicomElements image = series.image(series.at_mm({0, 0, places[n]}), static_cast<int>(n));
      if (change) change(static_cast<int>(n), image);
      folder_.write(prefix + "i" + std::to_string(900 - n), series.file(image));
    }
  }
  Volume open(VolumeRequest request = {}) const { return read(folder_.path(), std::move(request)); }
};

const std::vector<double> six{0, 1, 2, 3, 4, 5};

/// Expects the values of the series between its first and last slice, to `tolerance` of its own unit.
void expect_values(const Volume& volume, const DicomSeries& series, double slices, double tolerance = 0.51) {
  const Field& field = *volume.fields[0].field;
  for (int n = 0; n < 60; ++n) {
    const auto part = [&](double step) { return std::fmod(0.01 + n * step, 1.0); };
    const Vec3 index{part(0.618034) * static_cast<double>(series.columns - 1),
                     part(0.754878) * static_cast<double>(series.rows - 1), part(0.569840) * (slices - 1)};
    const Vec3 world_m = 1e-3 * series.at_mm(index);
    const ScalarSample sample = field.scalar(world_m);
    ASSERT_TRUE(sample.inside) << index.x << " " << index.y << " " << index.z;
    EXPECT_NEAR(sample.value, series.linear(world_m), tolerance);
  }
  EXPECT_FALSE(field.scalar(1e-3 * series.at_mm({0, 0, -0.6})).inside);
  EXPECT_FALSE(field.scalar(1e-3 * series.at_mm({0, 0, slices - 0.4})).inside);
}

TEST_F(Dicom, SlicesAreSortedByPosition) {
  DicomSeries series;
  write(series, {3, 1, 0, 5, 2, 4});
  const Volume volume = open();
  expect_values(volume, series, 6);
  EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
  EXPECT_TRUE(volume.medical_frame);
  EXPECT_EQ(volume.format, "dicom");
  EXPECT_EQ(volume.modality, "CT");
  EXPECT_EQ(volume.files.size(), 6U);
  const GridView& view = *grid_of(*volume.fields[0].field);
  EXPECT_EQ(view.geometry.dims, (std::array<std::int64_t, 3>{8, 6, 6}));
  EXPECT_EQ(view.voxels.type, VoxelType::uint16);
  EXPECT_EQ(view.offset, -1024.0);
}

TEST_F(Dicom, ObliqueAndBackwardSeriesLieWhereTheySay) {
  DicomSeries series;
  series.right = normalized(Vec3{0.9, 0.3, -0.2});
  series.down = normalized(cross(Vec3{0.1, -0.4, 1}, series.right));
  series.step_mm = -3.0 * cross(series.right, series.down);
  write(series, six);
  const Volume volume = open();
  expect_values(volume, series, 6);
  EXPECT_GT(determinant(grid_of(*volume.fields[0].field)->geometry.index_to_world_m), 0.0);
}

TEST_F(Dicom, AGantryTiltIsAShearAndExact) {
  DicomSeries series;
  const double tilt = 20 * 3.14159265358979 / 180;
  series.down = {0, std::cos(tilt), std::sin(tilt)};
  write(series, six);
  const Volume volume = open();
  expect_values(volume, series, 6);
  EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
  const Mat3 columns = transposed(grid_of(*volume.fields[0].field)->geometry.index_to_world_m);
  EXPECT_NEAR(std::abs(dot(normalized(columns.row[1]), normalized(columns.row[2]))), std::sin(tilt), 1e-9);
}

TEST_F(Dicom, AMissingSliceIsTold) {
  DicomSeries series;
  write(series, {0, 1, 2, 4, 5, 6});
  const Volume volume = open();
  expect_values(volume, series, 7, 1.01);
  EXPECT_TRUE(warns_of(volume, "1 slice is missing, between 705 and 710 mm")) << all_warnings(volume);
}

TEST_F(Dicom, UnevenSlicesAreResampledAlongTheirNormal) {
  DicomSeries series;
  series.step_mm = {0, 0.5, 2};
  write(series, {0, 1, 2, 3, 5.5, 8});
  const Volume volume = open();
  expect_values(volume, series, 9, 1.01);
  EXPECT_TRUE(warns_of(volume, "2 to 5 mm apart: resampled along their normal to 2 mm")) << all_warnings(volume);
  EXPECT_EQ(grid_of(*volume.fields[0].field)->geometry.dims[2], 9);
}

TEST_F(Dicom, OfSeveralSeriesTheLargestOrTheOneAskedFor) {
  DicomSeries large, small;
  small.uid = "1.2.77", small.intercept = -2000;
  write(large, six, {}, "a");
  write(small, {0, 1, 2}, {}, "b");
  const Volume volume = open();
  EXPECT_EQ(volume.files.size(), 6U);
  EXPECT_TRUE(warns_of(volume, "holds 2 series: the largest, '1.2.3', is read")) << all_warnings(volume);
  EXPECT_TRUE(warns_of(volume, "'1.2.77' (CT 7, 3 slices)"));
  VolumeRequest request;
  request.series = "1.2.77";
  const Volume other = open(request);
  EXPECT_EQ(other.files.size(), 3U);
  EXPECT_TRUE(other.warnings.empty()) << all_warnings(other);
  request.series = "1.2.78";
  EXPECT_NE(error_of([&] { open(request); }).find("has no series '1.2.78'; it has '1.2.3' (CT 7, 6 slices)"),
            std::string::npos);
}

TEST_F(Dicom, OtherOrientationsOfASeriesAreLeftOut) {
  DicomSeries series, side;
  side.down = {0, 0, 1}, side.step_mm = {0, 2.5, 0};
  write(series, six, {}, "a");
  write(
      side, {0, 1}, [&](int n, DicomElements& e) { e.set(0x00080018, "UI", "9." + std::to_string(n)); }, "b");
  const Volume volume = open();
  expect_values(volume, series, 6);
  EXPECT_TRUE(warns_of(volume, "2 of 8 are left out")) << all_warnings(volume);
}

TEST_F(Dicom, PaddingIsOutside) {
  for (const bool unsigned_padding : {false, true}) {
    SCOPED_TRACE(unsigned_padding);
    DicomSeries series;
    series.negative = true, series.intercept = 0, series.linear = {{300, 0, 0}, 0};
    write(series, six, [&](int, DicomElements& e) {
      std::string pixels = series.pixels({0, 0, 0});
      for (std::size_t row = 0; row < 6; ++row) pixels.replace(16 * row, 2, bytes_of(std::int16_t{-2000}));
      e.set(0x7fe00010, "OW", pixels);
      e.set_short(0x00280120, -2000, unsigned_padding ? "US" : "SS");
    });
    const Volume volume = open();
    const Field& field = *volume.fields[0].field;
    EXPECT_FALSE(field.scalar(1e-3 * series.at_mm({0.5, 2, 2})).inside);
    EXPECT_TRUE(field.scalar(1e-3 * series.at_mm({1.5, 2, 2})).inside);
    EXPECT_EQ(field.value_ranges()[0].min, 0.0);
    EXPECT_DOUBLE_EQ(grid_of(field)->valid_share, 7.0 / 8);
  }
}

TEST_F(Dicom, RepeatedPositionsAreFrames) {
  // Two phases, slice by slice, numbered phase by phase.
  DicomSeries series;
  const auto phases = [&](const char* first, const char* second) {
    for (int phase = 0; phase < 2; ++phase) {
      series.linear.at_origin = phase == 0 ? -6000 : -5500;
      write(
          series, six,
          [&](int n, DicomElements& e) {
            e.set(0x00080018, "UI", "5." + std::to_string(10 * phase + n));
            e.set(0x00200013, "IS", std::to_string(10 * phase + n));
            e.set(0x00181060, "DS", phase == 0 ? first : second);
          },
          std::to_string(phase));
    }
  };
  phases("0", "40");
  VolumeRequest request;
  for (request.frame = 0; request.frame < 2; ++request.frame) {
    const Volume volume = open(request);
    series.linear.at_origin = request.frame == 0 ? -6000 : -5500;
    expect_values(volume, series, 6);
    EXPECT_EQ(volume.frames, 2);
    EXPECT_EQ(volume.files.size(), 6U);
  }
  EXPECT_TRUE(warns_of(open(), "holds 2 frames"));
  phases("40", "0");  // the trigger time precedes the number
  request.frame = 0;
  series.linear.at_origin = -5500;
  expect_values(open(request), series, 6);
}

TEST_F(Dicom, AnImageThatIsThereTwiceIsOne) {
  DicomSeries series;
  write(series, six);
  folder_.write("copy", series.file(series.image(series.at_mm({0, 0, 2}), 2)));
  const Volume volume = open();
  expect_values(volume, series, 6);
  EXPECT_EQ(volume.frames, 1);
  EXPECT_TRUE(warns_of(volume, "1 image is there twice"));
}

TEST_F(Dicom, EnhancedMultiFrame) {
  DicomSeries series;
  series.step_mm = {0, 0.4, -2.5};
  const auto group = [](std::uint32_t tag, const DicomElements& of) {
    DicomElements items;
    items.set_items(tag, {of});
    return items;
  };
  DicomElements image = series.image(series.origin_mm, 1), orientation, measures, rescale;
  for (const std::uint32_t tag : {0x00200032, 0x00200037, 0x00280030, 0x00281052, 0x00281053}) image.erase(tag);
  orientation.set(0x00200037, "DS", decimals(series.right) + "\\" + decimals(series.down));
  measures.set(0x00280030, "DS", decimal(series.row_mm) + "\\" + decimal(series.column_mm));
  rescale.set(0x00281052, "DS", decimal(series.intercept));
  rescale.set(0x00281053, "DS", decimal(series.slope));
  DicomElements shared = group(0x00209116, orientation);
  shared.set_items(0x00289110, {measures});
  shared.set_items(0x00289145, {rescale});
  image.set_items(0x52009229, {shared});
  std::vector<DicomElements> frames;
  std::string pixels;
  for (const double place : {2.0, 0.0, 1.0, 4.0, 3.0}) {
    DicomElements position;
    position.set(0x00200032, "DS", decimals(series.at_mm({0, 0, place})));
    frames.push_back(group(0x00209113, position));
    pixels += series.pixels(series.at_mm({0, 0, place}));
  }
  image.set_items(0x52009230, frames);
  image.set(0x00280008, "IS", "5");
  image.set(0x7fe00010, "OW", pixels);
  const Volume volume = read(folder_.write("enhanced.dcm", series.file(image)));
  expect_values(volume, series, 5);
  EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
}

TEST_F(Dicom, FramesOfOneFileAreSpacedAsItSays) {
  DicomSeries series;
  DicomElements image = series.image(series.origin_mm, 1);
  std::string pixels;
  for (const double place : six) pixels += series.pixels(series.at_mm({0, 0, place}));
  image.set(0x00280008, "IS", "6");
  image.set(0x00180088, "DS", "2.5");
  image.set(0x7fe00010, "OW", pixels);
  expect_values(read(folder_.write("spacing.dcm", series.file(image))), series, 6);
  image.erase(0x00180088);
  image.set(0x3004000c, "DS", "0\\2.5\\5\\7.5\\10\\12.5");
  expect_values(read(folder_.write("offsets.dcm", series.file(image))), series, 6);
  image.erase(0x3004000c);  // without evidence of slices
  EXPECT_EQ(read(folder_.write("cine.dcm", series.file(image))).frames, 6);
}

TEST_F(Dicom, SlopesOfSlicesBecomeACommonStepOrFloatingPoint) {
  for (const bool decimal_step : {true, false}) {
    DicomSeries series;
    std::vector<double> slopes{0.5, 1.5, 2, 0.5, 1, 2.5};
    if (!decimal_step) slopes = {0.512347, 1.33371, 1.9, 0.74, 1, 2.2};
    write(series, six, [&](int n, DicomElements& e) {
      DicomSeries own = series;
      own.slope = slopes[static_cast<std::size_t>(n)], own.intercept = -1024 + n;
      e = own.image(series.at_mm({0, 0, static_cast<double>(n)}), n);
    });
    const Volume volume = open();
    expect_values(volume, series, 6, 1.3);
    const GridView& view = *grid_of(*volume.fields[0].field);
    EXPECT_EQ(view.voxels.type, decimal_step ? VoxelType::int32 : VoxelType::float32);
    EXPECT_EQ(view.scale, decimal_step ? 0.5 : 1.0);
  }
}

TEST_F(Dicom, PlainSyntaxesAndBitsBeyondTheNumber) {
  DicomSeries series;
  series.syntax = "1.2.840.10008.1.2";  // no types
  write(series, six);
  expect_values(open(), series, 6);
  DicomSeries twelve;
  twelve.stored = 12, twelve.linear = {{3000, -2000, 1000}, 0}, twelve.intercept = -1024;
  write(twelve, six, [&](int n, DicomElements& e) {
    std::string pixels = twelve.pixels(twelve.at_mm({0, 0, static_cast<double>(n)}));
    for (std::size_t high = 1; high < pixels.size(); high += 2) pixels[high] = static_cast<char>(pixels[high] | 0x50);
    e.set(0x7fe00010, "OW", pixels);
  });
  expect_values(open(), twelve, 6);
}

TEST_F(Dicom, FilesWithoutPreambleAreTheSame) {
  for (const char* syntax : {"1.2.840.10008.1.2", "1.2.840.10008.1.2.1"}) {
    for (const bool with_meta : {false, true}) {
      SCOPED_TRACE(std::string(syntax) + (with_meta ? ", with a meta header" : ""));
      DicomSeries series;
      series.syntax = syntax;
      write(series, six);
      for (int n = 0; n < 6; ++n) {
        const DicomElements image = series.image(series.at_mm({0, 0, static_cast<double>(n)}), n);
        const std::string whole = series.file(image), bare = image.bytes(std::string(syntax) != "1.2.840.10008.1.2");
        folder_.write("i" + std::to_string(900 - n), with_meta ? whole.substr(132) : bare);
      }
      const Volume volume = open();
      expect_values(volume, series, 6);
      EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
      EXPECT_EQ(read(folder_.path() / "i900").format, "dicom");
    }
  }
}

TEST_F(Dicom, NumbersThatBeginAtAHigherBitAreTheSame) {
  for (const bool negative : {false, true}) {
    SCOPED_TRACE(negative);
    DicomSeries series;
    series.stored = 12, series.negative = negative, series.intercept = negative ? 0 : -1024;
    series.linear = {{3000, -2000, 1000}, 0};
    for (const int shift : {0, 3, 4}) {
      write(series, six, [&](int n, DicomElements& e) {
        const std::string plain = series.pixels(series.at_mm({0, 0, static_cast<double>(n)}));
        std::string pixels;
        for (std::size_t at = 0; at < plain.size(); at += 2) {
          const unsigned raw = static_cast<unsigned char>(plain[at]) | static_cast<unsigned char>(plain[at + 1]) << 8;
          // Around the 12 bits lie other bits.
          pixels += bytes_of(static_cast<std::uint16_t>((raw & 0xfff) << shift | (shift > 0 ? 1U : 0U)));
        }
        e.set_short(0x00280102, 11 + shift);
        e.set(0x7fe00010, "OW", pixels);
      });
      expect_values(open(), series, 6);
    }
  }
}

TEST_F(Dicom, AFileWithItsMarkButWithoutAMetaHeaderIsRead) {
  for (const char* syntax : {"1.2.840.10008.1.2.1", "1.2.840.10008.1.2"}) {
    DicomSeries series;
    series.syntax = syntax;
    for (int n = 0; n < 6; ++n) {
      const DicomElements image = series.image(series.at_mm({0, 0, static_cast<double>(n)}), n);
      folder_.write("i" + std::to_string(n),
                    std::string(128, '\0') + "DICM" + image.bytes(std::string(syntax) != "1.2.840.10008.1.2"));
    }
    expect_values(open(), series, 6);
  }
}

TEST_F(Dicom, DeflatedFilesAreReadAsTheOthers) {
  DicomSeries series;
  write(series, six);
  const fs::path last = folder_.path() / "i895";
  for (const char* padding : {"", "\1"}) {  // padding to even length need not be zero
    for (int n = 0; n < 6; n += n == 0 ? 2 : 1)
      folder_.write("i" + std::to_string(900 - n),
                    deflated_file(series, series.image(series.at_mm({0, 0, static_cast<double>(n)}), n)) + padding);
    const Volume volume = open();
    EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
    expect_values(volume, series, 6);
    EXPECT_EQ(volume.files.size(), 6U);
    EXPECT_EQ(volume.files.front().path.find("/proc"), std::string::npos) << volume.files.front().path;
  }
  EXPECT_EQ(grid_of(*read(last).fields[0].field)->geometry.dims[2], 1);
  const std::string whole = deflated_file(series, series.image(series.at_mm({0, 0, 5}), 5));
  folder_.write("i895", whole.substr(0, whole.size() - 20));
  EXPECT_TRUE(warns_of(open(), "1 file is left out: each cannot be read: its compression is damaged or not whole"))
      << all_warnings(open());
  EXPECT_NE(error_of([&] { read(last); }).find("its compression is damaged or not whole; get the file again"),
            std::string::npos);
}

TEST_F(Dicom, CompressedSlicesAreTheSame) {
  DicomSeries series;
  series.columns = 64, series.rows = 48;
  for (const auto type : {gdcm::TransferSyntax::JPEGLosslessProcess14_1, gdcm::TransferSyntax::JPEGLSLossless,
                          gdcm::TransferSyntax::JPEG2000Lossless, gdcm::TransferSyntax::RLELossless}) {
    SCOPED_TRACE(gdcm::TransferSyntax::GetTSString(type));
    write(series, six);
    for (const auto& entry : fs::directory_iterator(folder_.path())) compress_dicom(entry.path(), type);
    const Volume volume = open();
    expect_values(volume, series, 6);
    EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
    const fs::path cut = folder_.path() / "i898";
    fs::resize_file(cut, fs::file_size(cut) - 60);
    const Volume without = open();
    EXPECT_TRUE(warns_of(without, "1 DICOM file is left out") && warns_of(without, "1 slice is missing"));
  }
}

TEST_F(Dicom, Monochrome1IsAMatterOfDisplay) {
  DicomSeries series;
  write(series, six, [](int, DicomElements& e) { e.set(0x00280004, "CS", "MONOCHROME1"); });
  expect_values(open(), series, 6);
}

TEST_F(Dicom, WhatHasNoOneValueIsRefusedWithTheReason) {
  const DicomSeries series;
  const auto refused = [&](const Change& change) {
    write(series, six, change);
    return error_of([&] { open(); });
  };
  EXPECT_NE(refused([](int, DicomElements& e) { e.set_short(0x00280002, 3); }).find("colours (RGB)"), std::string::npos);
  EXPECT_NE(refused([](int, DicomElements& e) { e.set(0x00280004, "CS", "PALETTE COLOR"); }).find("colours"),
            std::string::npos);
  EXPECT_NE(refused([](int, DicomElements& e) { e.set(0x00080008, "CS", "ORIGINAL\\PRIMARY\\M\\MOSAIC"); }).find("mosaic"),
            std::string::npos);
  EXPECT_NE(refused([](int n, DicomElements& e) {
              if (n == 2) e.set(0x00200032, "DS", "-19\\11.25\\705");
            }).find("beside the line"),
            std::string::npos);
  EXPECT_NE(refused([](int n, DicomElements& e) {
              if (n == 2) e.set(0x00200032, "DS", "-19\\11.25\\1e300");
            }).find("not finite"),
            std::string::npos);
  write(series, six);
  VolumeRequest vector;
  vector.as = "vector";
  EXPECT_NE(error_of([&] { open(vector); }).find("no vectors"), std::string::npos);
  // Beside valid images they are left out.
  write(series, six, [](int n, DicomElements& e) {
    if (n == 5) e.set_short(0x00280002, 3);
  });
  EXPECT_TRUE(warns_of(open(), "1 file is left out: each holds colours"));
}

TEST_F(Dicom, DifferentFramesOfReferenceWarn) {
  const DicomSeries series;
  write(series, six, [](int n, DicomElements& e) { e.set(0x00200052, "UI", n < 3 ? "1.2.9" : "1.2.10"); });
  EXPECT_TRUE(warns_of(open(), "different frames of reference"));
}

TEST_F(Dicom, WithoutPositionsNothingIsMedical) {
  const DicomSeries series;
  write(series, six, [](int, DicomElements& e) { e.erase(0x00200032), e.erase(0x00280030); });
  const Volume volume = open();
  EXPECT_FALSE(volume.medical_frame);
  EXPECT_TRUE(warns_of(volume, "no positions"));
  EXPECT_TRUE(warns_of(volume, "no unit of length"));
  EXPECT_EQ(grid_of(*volume.fields[0].field)->geometry.dims[2], 6);
}

TEST_F(Dicom, AnImageOfJpeg2000IsAsLargeAsItsHeaderSays) {
  const DicomSeries series;
  const fs::path file = folder_.write("one.dcm", series.file(series.image(series.at_mm({0, 0, 0}), 0)));
  compress_dicom(file, gdcm::TransferSyntax::JPEG2000Lossless);
  read(file);
  std::ostringstream content;
  content << std::ifstream(file, std::ios::binary).rdbuf();
  std::string bytes = content.str();
  const std::size_t image = bytes.find("\xff\x4f\xff\x51");
  ASSERT_NE(image, std::string::npos);
  bytes[image + 9] = 16;  // a million columns more
  EXPECT_NE(error_of([&] { read(folder_.write("one.dcm", bytes)); }).find("of another size than its header says"),
            std::string::npos);
}

TEST_F(Dicom, DamagedFilesAreTold) {
  const DicomSeries series;
  write(series, six);
  const std::string whole = series.file(series.image(series.at_mm({0, 0, 2}), 2));
  folder_.write("i898", whole.substr(0, whole.size() - 20));
  for (const std::size_t size : {whole.size() - 20, std::size_t{400}}) {
    folder_.write("i898", whole.substr(0, size));
    const Volume volume = open();
    EXPECT_TRUE(warns_of(volume, "1 DICOM file is left out")) << all_warnings(volume);
    EXPECT_TRUE(warns_of(volume, "1 slice is missing"));
  }
  // In the meta header: an invalid type, zeros, and an element beyond the file's end.
  std::string damaged = whole;
  for (const auto& [at, bytes] : std::vector<std::pair<std::size_t, std::string>>{
           {136, std::string("U\0", 2)}, {158, std::string(60, '\0')}, {152, "\xff\xff\xff\x7f"}}) {
    damaged = whole;
    damaged.replace(at, bytes.size(), bytes);
    folder_.write("i898", damaged);
    EXPECT_TRUE(warns_of(open(), "1 DICOM file is left out")) << at;
  }
  folder_.write("notes.txt", "not an image");
  EXPECT_EQ(open().files.size(), 5U);
  std::string without_length = whole;
  without_length.erase(132, 12);  // of the group, which the standard requires first
  EXPECT_EQ(read(folder_.write("one.dcm", without_length)).files.size(), 1U);
  EXPECT_NE(error_of([&] { read(folder_.write("one.dcm", whole.substr(0, 400))); }).find("no DICOM image"), std::string::npos);
}

TEST_F(Dicom, NoNameOfAPatientComesOut) {
  const DicomSeries series;
  write(series, six);
  const Volume volume = open();
  std::string said = volume.format + volume.modality + volume.fields[0].name + volume.fields[0].unit + all_warnings(volume);
  for (const SourceFile& file : volume.files) said += file.path;
  EXPECT_EQ(said.find("DOE"), std::string::npos);
  EXPECT_EQ(said.find("1970"), std::string::npos);
}

TEST_F(Dicom, AThousandSlicesHaveAThousandChecksums) {
  DicomSeries series;
  series.columns = series.rows = 2, series.linear = {{0, 0, 1000}, 0};
  std::vector<double> places;
  for (int n = 0; n < 1100; ++n) places.push_back(n);
  write(series, places, [&](int n, DicomElements& e) { e.set(0x00200013, "IS", std::to_string(n)); });
  const Volume volume = open();
  EXPECT_EQ(volume.files.size(), 1100U);
  EXPECT_EQ(volume.files.back().sha256.text().size(), 64U);
}

}  // namespace dicom_test
}  // namespace palpa::test
