#include "files.h"

namespace palpa::test {
namespace metaimage_test {

class MetaImage : public ReaderTest {};

std::string numbers(std::initializer_list<double> values) {
  std::string text;
  for (const double v : values) {
    char number[40];
    std::snprintf(number, sizeof number, " %.17g", v);
    text += number;
  }
  return text;
}

/// An oblique grid of MetaImage: unit directions in rows, spacing apart.
struct Oblique {
  FileGrid grid;
  std::string text;
};
Oblique oblique() {
  const Vec3 rows[3] = {{0.6, 0.8, 0}, {-0.8, 0.6, 0}, {0, 0, -1}};
  const double spacing[3] = {2, 3, 4};
  Oblique o;
  o.grid = {{5, 4, 3}, transposed(Mat3{{spacing[0] * rows[0], spacing[1] * rows[1], spacing[2] * rows[2]}}), {9, -8, 7}};
  o.text = "ObjectType = Image\nNDims = 3\nBinaryData = True\nTransformMatrix =";
  for (const Vec3& r : rows) o.text += numbers({r.x, r.y, r.z});
  o.text += "\nOffset =" + numbers({9, -8, 7}) + "\nElementSpacing =" + numbers({2, 3, 4}) + "\nDimSize = 5 4 3\n";
  return o;
}

Vec3 millimetres(const Vec3& p) { return 1e-3 * p; }

// No byte of the header becomes a voxel.
TEST_F(MetaImage, AHeaderSizeWithinTheHeaderIsRefused) {
  const Oblique o = oblique();
  const std::string raw = linear_voxels<float>(o.grid, millimetres), end = "ElementType = MET_FLOAT\nElementDataFile = ";
  const auto local = [&](const std::string& size) { return o.text + "HeaderSize = " + size + "\n" + end + "LOCAL\n"; };
  for (const char* size : {"1", "10", "100", "-5", "-2"}) {
    const std::string error = error_of([&] { read(folder_.write("a.mha", local(size) + raw)); });
    EXPECT_NE(error.find("HeaderSize"), std::string::npos) << size << ": " << error;
  }
  const std::string exact = std::to_string(local("999").size());
  expect_linear(*read(folder_.write("a.mha", local(exact) + raw)).fields[0].field, o.grid, millimetres);
  expect_linear(*read(folder_.write("a.mha", local("0") + raw)).fields[0].field, o.grid, millimetres);
  const std::string itself = o.text + end + "b.mhd\n";
  EXPECT_NE(error_of([&] { read(folder_.write("b.mhd", itself + raw)); }).find("HeaderSize"), std::string::npos);
  folder_.write("c.raw", "12345" + raw);
  for (const char* size : {"5", "-1"}) {
    const fs::path path = folder_.write("c.mhd", o.text + "HeaderSize = " + size + "\n" + end + "c.raw\n");
    expect_linear(*read(path).fields[0].field, o.grid, millimetres);
  }
}

TEST_F(MetaImage, CompressedVoxelsNeedNotSayTheirSize) {
  const Oblique o = oblique();
  for (const bool big : {false, true}) {
    const std::string raw = linear_voxels<float>(o.grid, millimetres, big);
    const std::string header = o.text + "CompressedData = True\n" + (big ? "BinaryDataByteOrderMSB = True\n" : "") +
                               "ElementType = MET_FLOAT\nElementDataFile = ";
    const std::string packed = gzipped(raw);
    expect_linear(*read(folder_.write("a.mha", header + "LOCAL\n" + packed)).fields[0].field, o.grid, millimetres);
    folder_.write("b.zraw", packed);
    expect_linear(*read(folder_.write("b.mhd", header + "b.zraw\n")).fields[0].field, o.grid, millimetres);
    const std::string short_one = gzipped(raw.substr(0, raw.size() - 4));
    EXPECT_NE(error_of([&] { read(folder_.write("c.mha", header + "LOCAL\n" + short_one)); }).find("shorter"),
              std::string::npos);
    error_of([&] { read(folder_.write("d.mha", header + "LOCAL\n" + packed.substr(0, packed.size() / 2))); });
  }
}

TEST_F(MetaImage, ObliqueGridsInAllStoragesAreTheSame) {
  const Oblique o = oblique();
  const std::string raw = linear_voxels<float>(o.grid, millimetres);
  const std::string packed = gzipped(raw);
  std::vector<fs::path> files;
  files.push_back(folder_.write("local.mha", o.text + "ElementType = MET_FLOAT\nElementDataFile = LOCAL\n" + raw));
  files.push_back(
      folder_.write("big.mha", o.text + "BinaryDataByteOrderMSB = True\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n" +
                                   linear_voxels<float>(o.grid, millimetres, true)));
  folder_.write("voxels.raw", raw);
  files.push_back(folder_.write("detached.mhd", o.text + "ElementType = MET_FLOAT\nElementDataFile = voxels.raw\n"));
  folder_.write("voxels.raw.gz", packed);
  files.push_back(
      folder_.write("packed.mhd", o.text + "CompressedData = True\nCompressedDataSize = " + std::to_string(packed.size()) +
                                      "\nElementType = MET_FLOAT\nElementDataFile = voxels.raw.gz\n"));
  const std::size_t slice = raw.size() / 3;
  std::string names;
  for (std::size_t k = 0; k < 3; ++k)
    folder_.write("s" + std::to_string(k), raw.substr(k * slice, slice)), names += "s" + std::to_string(k) + "\n";
  files.push_back(folder_.write("list.mhd", o.text + "ElementType = MET_FLOAT\nElementDataFile = LIST\n" + names));
  for (const fs::path& file : files) {
    SCOPED_TRACE(file);
    const Volume volume = read(file);
    EXPECT_FALSE(volume.medical_frame);
    expect_linear(*volume.fields[0].field, o.grid, millimetres);
  }
  EXPECT_EQ(read(files[4]).files.size(), 4U);
}

TEST_F(MetaImage, ValuesAreRescaledAndUnitsHonoured) {
  const Oblique o = oblique();
  const auto centimetres = [](const Vec3& p) { return 1e-2 * p; };
  // raw = 2·value − 6
  const Linear raw{{600, -400, 1000}, 2 * 7.0 - 6.0};
  const Volume volume = read(folder_.write(
      "a.mha", o.text +
                   "DistanceUnits = cm\nElementToIntensityFunctionSlope = 0.5\nElementToIntensityFunctionOffset = 3\n"
                   "AnatomicalOrientation = RAI\nElementType = MET_DOUBLE\nElementDataFile = LOCAL\n" +
                   linear_voxels<double>(o.grid, centimetres, false, raw)));
  EXPECT_FALSE(warns_of(volume, "unit of length")) << all_warnings(volume);
  EXPECT_TRUE(volume.medical_frame);
  EXPECT_TRUE(warns_of(volume, "does not agree with TransformMatrix")) << all_warnings(volume);
  expect_linear(*volume.fields[0].field, o.grid, centimetres);
}

TEST_F(MetaImage, AUnitOfLengthIsReadHoweverItIsSpeltOrRefused) {
  const Oblique o = oblique();
  const auto said = [&](const std::string& unit) {
    return folder_.write("a.mha", o.text + "DistanceUnits = " + unit + "\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n" +
                                      linear_voxels<float>(o.grid, millimetres));
  };
  const std::pair<const char*, double> units[] = {{"um", 1e-6},     {"micrometers", 1e-6}, {"\u03bcm", 1e-6},
                                                  {"Micron", 1e-6}, {"nanometer", 1e-9},   {"m", 1.0},
                                                  {"inch", 0.0254}, {"mm mm mm", 1e-3}};
  for (const auto& [unit, metres] : units) {
    SCOPED_TRACE(unit);
    const Volume volume = read(said(unit));
    EXPECT_FALSE(volume.length_unit_assumed);
    EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
    const GridGeometry& grid = grid_of(*volume.fields[0].field)->geometry;
    EXPECT_NEAR(norm(transposed(grid.index_to_world_m).row[0]), 2 * metres, 1e-12 * metres);
  }
  const std::string error = error_of([&] { read(said("furlong")); });
  EXPECT_NE(error.find("has the unit of length 'furlong', which is unknown; give it by length_unit"), std::string::npos)
      << error;
  EXPECT_TRUE(read(said("?")).length_unit_assumed);
}

TEST_F(MetaImage, ChannelsOfThreeAreAVectorAndBytesOfThreeAColour) {
  const Oblique o = oblique();
  std::string voxels;
  for (int v = 0; v < 60; ++v) voxels += bytes_of(1.0F) + bytes_of(-2.0F) + bytes_of(static_cast<float>(v));
  const std::string more = "ElementNumberOfChannels = 3\nElementType = ";
  const Volume volume = read(folder_.write("a.mha", o.text + more + "MET_FLOAT\nElementDataFile = LOCAL\n" + voxels));
  EXPECT_LT(distance(volume.fields[0].field->vector(1e-3 * o.grid.at({1, 0, 0})).value, {1, -2, 1}), 1e-12);
  EXPECT_NE(error_of([&] {
              read(folder_.write("b.mha", o.text + more + "MET_UCHAR\nElementDataFile = LOCAL\n" + std::string(180, 'x')));
            }).find("colours"),
            std::string::npos);
}

TEST_F(MetaImage, ShortDataAreNotFilledUp) {
  const Oblique o = oblique();
  const std::string raw = linear_voxels<float>(o.grid, millimetres);
  const std::string packed = gzipped(raw);
  const std::string start = o.text + "ElementType = MET_FLOAT\nElementDataFile = ";
  EXPECT_NE(error_of([&] { read(folder_.write("a.mha", start + "LOCAL\n" + raw.substr(0, raw.size() - 9))); }).find("a.mha: "),
            std::string::npos);
  folder_.write("v.raw", raw.substr(0, 100));
  EXPECT_NE(error_of([&] { read(folder_.write("b.mhd", start + "v.raw\n")); }).find("b.mhd: "), std::string::npos);
  folder_.write("v.gz", packed.substr(0, packed.size() / 2));
  EXPECT_NE(error_of([&] {
              read(folder_.write("c.mhd", "CompressedData = True\nCompressedDataSize = " + std::to_string(packed.size() / 2) +
                                              "\n" + start + "v.gz\n"));
            }).find("c.mhd: "),
            std::string::npos);
  std::string wrong = packed;
  wrong[packed.size() - 6] ^= 1;  // the checksum at its end
  folder_.write("wrong.gz", wrong);
  const std::string compressed = "CompressedData = True\nCompressedDataSize = " + std::to_string(wrong.size()) + "\n" + start;
  for (const auto& [name, data] : {std::pair{"e.mhd", std::string("wrong.gz\n")}, std::pair{"e.mha", "LOCAL\n" + wrong}}) {
    EXPECT_NE(error_of([&] { read(folder_.write(name, compressed + data)); }).find("compressed data are damaged"),
              std::string::npos);
  }
  EXPECT_NO_THROW(read(folder_.write("f.mha", compressed + "LOCAL\n" + packed)));
  EXPECT_NE(error_of([&] { read(folder_.write("d.mhd", start + "not-there.raw\n")); }).find("d.mhd: "), std::string::npos);
}

}  // namespace metaimage_test
}  // namespace palpa::test
