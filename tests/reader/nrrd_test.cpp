#include <cmath>

#include "files.h"

namespace palpa::test {
namespace nrrd_test {

class Nrrd : public ReaderTest {};

std::string text_of(const Vec3& v) {
  char text[100];
  std::snprintf(text, sizeof text, "(%.17g,%.17g,%.17g)", v.x, v.y, v.z);
  return text;
}

std::string directions(const FileGrid& grid) {
  const Mat3 columns = transposed(grid.step);
  return text_of(columns.row[0]) + " " + text_of(columns.row[1]) + " " + text_of(columns.row[2]);
}

std::string header(const FileGrid& grid, const std::string& space, const std::string& type = "float",
                   const std::string& more = "") {
  return "NRRD0004\ntype: " + type + "\ndimension: 3\nspace: " + space + "\nsizes: " + std::to_string(grid.dims[0]) + " " +
         std::to_string(grid.dims[1]) + " " + std::to_string(grid.dims[2]) + "\nspace directions: " + directions(grid) +
         "\nspace origin: " + text_of(grid.origin) + "\nencoding: raw\n" + more;
}

const char* const little = "endian: little\n\n";

Vec3 lps_mm(const Vec3& p) { return 1e-3 * p; }
Vec3 ras_mm(const Vec3& p) { return 1e-3 * Vec3{-p.x, -p.y, p.z}; }
Vec3 las_mm(const Vec3& p) { return 1e-3 * Vec3{p.x, -p.y, p.z}; }
Vec3 left_handed_mm(const Vec3& p) { return 1e-3 * Vec3{-p.x, p.y, p.z}; }

// No byte of the header becomes a voxel.
TEST_F(Nrrd, ASkipFromTheEndDoesNotReachIntoTheHeader) {
  const FileGrid grid = sheared_grid();
  const std::string voxels = linear_voxels<float>(grid, lps_mm);
  const auto file = [&](const std::string& skip, const std::string& data) {
    return folder_.write("a.nrrd", header(grid, "LPS", "float", "byte skip: " + skip + "\n") + little + data);
  };
  expect_linear(*read(file("-1", voxels)).fields[0].field, grid, lps_mm);
  expect_linear(*read(file("-1", "12345678" + voxels)).fields[0].field, grid, lps_mm);
  expect_linear(*read(file("8", "12345678" + voxels)).fields[0].field, grid, lps_mm);
  for (const auto& path : {file("-1", voxels.substr(40)), file("-100", voxels), file("-1000000", voxels)}) {
    const std::string error = error_of([&] { read(path); });
    EXPECT_EQ(error.find("palpa-read"), std::string::npos) << error;
  }
  // A header that names itself as its data file.
  const std::string start = header(grid, "LPS", "float", "byte skip: 20\n") + "endian: little\ndata file: b.nrrd\n\n";
  EXPECT_NE(error_of([&] { read(folder_.write("b.nrrd", start + voxels)); }).find("within its header"), std::string::npos);
}

TEST_F(Nrrd, ShearedGridsLieWhereTheirSpaceSays) {
  const FileGrid grid = sheared_grid();
  const struct {
    const char* space;
    Vec3 (*to_world_m)(const Vec3&);
    bool medical;
  } spaces[] = {{"left-posterior-superior", lps_mm, true},
                {"right-anterior-superior", ras_mm, true},
                {"left-anterior-superior", las_mm, true},
                {"3D-right-handed", lps_mm, false},
                {"scanner-xyz", lps_mm, false},
                {"3D-left-handed", left_handed_mm, false}};
  for (const auto& [space, to_world_m, medical] : spaces) {
    SCOPED_TRACE(space);
    const Volume volume = read(folder_.write("a.nrrd", header(grid, space) + little + linear_voxels<float>(grid, to_world_m)));
    EXPECT_EQ(volume.medical_frame, medical);
    EXPECT_EQ(warns_of(volume, "left-handed"), std::string(space) == "3D-left-handed") << all_warnings(volume);
    expect_linear(*volume.fields[0].field, grid, to_world_m);
  }
}

TEST_F(Nrrd, UnitsOfTheFileAndOfTheRequestAreKept) {
  const FileGrid grid = sheared_grid();
  const auto microns = [](const Vec3& p) { return 1e-6 * p; };
  const auto metres = [](const Vec3& p) { return p; };
  const Linear steep{{3e5, 2e5, -4e5}, 3.0};
  const std::string space = "left-posterior-superior";
  const fs::path said = folder_.write("a.nrrd", header(grid, space, "float", "space units: \"um\" \"um\" \"um\"\n") + little +
                                                    linear_voxels<float>(grid, microns, false, steep));
  const Volume volume = read(said);
  EXPECT_FALSE(warns_of(volume, "unit of length")) << all_warnings(volume);
  expect_linear(*volume.fields[0].field, grid, microns, steep);

  VolumeRequest request;
  request.length_unit = "m";
  const Volume asked = read(folder_.write("b.nrrd", header(grid, space, "float", "space units: \"um\" \"um\" \"um\"\n") +
                                                        little + linear_voxels<float>(grid, metres)),
                            request);
  expect_linear(*asked.fields[0].field, grid, metres);

  const Volume silent = read(folder_.write("c.nrrd", header(grid, space) + little + linear_voxels<float>(grid, lps_mm)));
  EXPECT_TRUE(warns_of(silent, "millimetres are taken"));

  request.length_unit = "furlong";
  EXPECT_NE(error_of([&] { read(said, request); }).find("'furlong'"), std::string::npos);
}

TEST_F(Nrrd, AUnitOfLengthIsReadHoweverItIsSpeltOrRefused) {
  const FileGrid grid = sheared_grid();
  const auto said = [&](const std::string& a, const std::string& b, const std::string& c) {
    return folder_.write(
        "a.nrrd", header(grid, "left-posterior-superior", "float", "space units: \"" + a + "\" \"" + b + "\" \"" + c + "\"\n") +
                      little + linear_voxels<float>(grid, lps_mm));
  };
  const std::pair<const char*, double> units[] = {
      {"micrometers", 1e-6}, {"micrometre", 1e-6}, {"\u03bcm", 1e-6},     {"Micron", 1e-6}, {"nanometer", 1e-9},
      {"centimeters", 1e-2}, {"inch", 0.0254},     {"Millimetres", 1e-3}, {"1e-3 m", 1e-3}, {"KM", 1e3}};
  for (const auto& [unit, metres] : units) {
    SCOPED_TRACE(unit);
    const Volume volume = read(said(unit, unit, unit));
    EXPECT_FALSE(volume.length_unit_assumed);
    EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
    const GridGeometry& read_grid = grid_of(*volume.fields[0].field)->geometry;
    EXPECT_NEAR(norm(transposed(read_grid.index_to_world_m).row[0]), metres * norm(transposed(grid.step).row[0]),
                1e-12 * metres);
  }
  EXPECT_TRUE(read(said("mm", "Millimetre", "millimeters")).warnings.empty());
  for (const char* unit : {"furlong", "pixel", "Mm", "ms"}) {
    const std::string error = error_of([&] { read(said(unit, unit, unit)); });
    EXPECT_NE(error.find("has the unit of length '" + std::string(unit) + "', which is unknown; give it by length_unit"),
              std::string::npos)
        << error;
    VolumeRequest request;
    request.length_unit = "millimetre";
    const Volume volume = read(said(unit, unit, unit), request);
    EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
    expect_linear(*volume.fields[0].field, grid, lps_mm);
  }
  EXPECT_NE(error_of([&] { read(said("mm", "um", "mm")); }).find("different units ('mm' and 'um')"), std::string::npos);
  // A request against the file is obeyed, with a warning.
  VolumeRequest request;
  request.length_unit = "mm";
  EXPECT_TRUE(warns_of(read(said("um", "um", "um"), request), "has the unit of length 'um', in place of which"));
  EXPECT_TRUE(read(said("?", "?", "?")).length_unit_assumed);
}

TEST_F(Nrrd, EncodingsAndByteOrdersGiveTheSame) {
  const FileGrid grid = sheared_grid();
  const std::string space = "left-posterior-superior";
  const std::string raw = linear_voxels<float>(grid, lps_mm);
  const std::string start = header(grid, space);
  const std::string no_encoding = start.substr(0, start.find("encoding"));

  std::vector<fs::path> files;
  files.push_back(folder_.write("big.nrrd", start + "endian: big\n\n" + linear_voxels<float>(grid, lps_mm, true)));
  files.push_back(folder_.write("gzip.nrrd", no_encoding + "encoding: gzip\n" + little + gzipped(raw)));
  folder_.write("voxels.raw", raw);
  files.push_back(folder_.write("detached.nhdr", start + "endian: little\ndata file: voxels.raw\n"));
  const std::size_t slice = raw.size() / 4;
  for (std::size_t k = 0; k < 4; ++k)
    folder_.write("slice_" + std::string(k + 8 < 10 ? "0" : "") + std::to_string(k + 8), raw.substr(k * slice, slice));
  files.push_back(folder_.write("slices.nhdr", start + "endian: little\ndata file: slice_%02d 8 11 1\n"));
  std::string text;
  for (std::size_t v = 0; v < raw.size(); v += 4) {
    float value = 0;
    std::memcpy(&value, raw.data() + v, 4);
    text += std::to_string(value) + "\n";
  }
  files.push_back(folder_.write("text.nrrd", no_encoding + "encoding: ascii\n\n" + text));
  for (const fs::path& file : files) {
    SCOPED_TRACE(file);
    const Volume volume = read(file);
    expect_linear(*volume.fields[0].field, grid, lps_mm);
    for (const SourceFile& source : volume.files) {
      EXPECT_EQ(source.bytes, fs::file_size(source.path)) << source.path;
      EXPECT_EQ(source.sha256.text().size(), 64U);
    }
  }
  EXPECT_EQ(read(files[3]).files.size(), 5U);
}

TEST_F(Nrrd, ShortDataAreNotFilledUp) {
  const FileGrid grid = sheared_grid();
  const std::string raw = linear_voxels<float>(grid, lps_mm), packed = gzipped(raw);
  const std::string start = header(grid, "left-posterior-superior");
  const std::string no_encoding = start.substr(0, start.find("encoding"));
  error_of([&] { read(folder_.write("a.nrrd", start + little + raw.substr(0, raw.size() - 5))); });
  error_of(
      [&] { read(folder_.write("b.nrrd", no_encoding + "encoding: gzip\n" + little + packed.substr(0, packed.size() / 2))); });
  error_of([&] { read(folder_.write("c.nrrd", no_encoding + "encoding: gzip\n" + little + gzipped(raw.substr(0, 100)))); });
  error_of([&] { read(folder_.write("d.nrrd", no_encoding + "encoding: ascii\n\n1 2 3 4 5\n")); });
}

TEST_F(Nrrd, TypesAreKeptOrWidenedToTheNextExactOne) {
  const FileGrid grid{{3, 2, 2}, Mat3::identity(), {}};
  const auto type_of = [&](const std::string& type, const std::string& bytes) {
    const Volume volume = read(folder_.write("a.nrrd", header(grid, "left-posterior-superior", type) + little + bytes));
    EXPECT_EQ(warns_of(volume, "64-bit"), type.find("int64") != std::string::npos);
    const GridView& view = *grid_of(*volume.fields[0].field);
    EXPECT_EQ(volume.fields[0].field->scalar({1e-3, 0, 0}).value, 101.0) << type;
    return view.voxels.type;
  };
  const auto ramp = [](auto first) {
    std::string bytes;
    for (int v = 0; v < 12; ++v) bytes += bytes_of(static_cast<decltype(first)>(100 + v));
    return bytes;
  };
  EXPECT_EQ(type_of("int8", ramp(std::int8_t{})), VoxelType::int16);
  EXPECT_EQ(type_of("uint8", ramp(std::uint8_t{})), VoxelType::uint8);
  EXPECT_EQ(type_of("int16", ramp(std::int16_t{})), VoxelType::int16);
  EXPECT_EQ(type_of("uint16", ramp(std::uint16_t{})), VoxelType::uint16);
  EXPECT_EQ(type_of("int32", ramp(std::int32_t{})), VoxelType::int32);
  EXPECT_EQ(type_of("uint32", ramp(std::uint32_t{})), VoxelType::float64);
  EXPECT_EQ(type_of("int64", ramp(std::int64_t{})), VoxelType::float64);
  EXPECT_EQ(type_of("uint64", ramp(std::uint64_t{})), VoxelType::float64);
  EXPECT_EQ(type_of("float", ramp(float{})), VoxelType::float32);
  EXPECT_EQ(type_of("double", ramp(double{})), VoxelType::float64);
}

// The vector field v(x) = position: the world has v = x for any storage of the components and any measurement frame.
TEST_F(Nrrd, VectorsTurnWithPositions) {
  const FileGrid grid = sheared_grid();
  // Measured along axes turned by 30° about z: columns of the frame are those axes.
  const double c = std::sqrt(0.75), s = 0.5;
  const Mat3 frame{{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}};
  for (const bool last : {false, true}) {
    for (const bool measured : {false, true}) {
      SCOPED_TRACE(std::string(last ? "planes" : "interleaved") + (measured ? ", measurement frame" : ""));
      std::string voxels, planes[3];
      for (std::int64_t k = 0; k < grid.dims[2]; ++k)
        for (std::int64_t j = 0; j < grid.dims[1]; ++j)
          for (std::int64_t i = 0; i < grid.dims[0]; ++i) {
            const Vec3 at = grid.at({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
            const Vec3 v = measured ? transposed_times(frame, at) : at;
            const std::string parts[3] = {bytes_of(static_cast<float>(v.x)), bytes_of(static_cast<float>(v.y)),
                                          bytes_of(static_cast<float>(v.z))};
            for (int n = 0; n < 3; ++n) voxels += parts[n], planes[n] += parts[n];
          }
      if (last) voxels = planes[0] + planes[1] + planes[2];
      const std::string sizes = "6 5 4", kinds = "domain domain domain";
      const std::string text =
          "NRRD0005\ntype: float\ndimension: 4\nspace: right-anterior-superior\nsizes: " +
          (last ? sizes + " 3" : "3 " + sizes) +
          "\nspace directions: " + (last ? directions(grid) + " none" : "none " + directions(grid)) +
          "\nkinds: " + (last ? kinds + " 3-vector" : "3-vector " + kinds) + "\nspace origin: " + text_of(grid.origin) +
          (measured ? "\nmeasurement frame: " + text_of({c, s, 0}) + " " + text_of({-s, c, 0}) + " (0,0,1)" : "") +
          "\nencoding: raw\nendian: little\n\n";
      const Volume volume = read(folder_.write("v.nrrd", text + voxels));
      const Vec3 at_m = ras_mm(grid.at({2.3, 1.2, 2.6}));
      const VectorSample sample = volume.fields[0].field->vector(at_m);
      ASSERT_TRUE(sample.inside);
      EXPECT_LT(distance(sample.value, 1e3 * at_m), 1e-4) << sample.value.x << " " << sample.value.y << " " << sample.value.z;
    }
  }
}

TEST_F(Nrrd, FramesAreChosenOneByOne) {
  std::string voxels;
  for (int frame = 0; frame < 3; ++frame)
    for (int v = 0; v < 8; ++v) voxels += bytes_of(static_cast<std::int16_t>(10 * frame));
  for (const std::string kinds : {"kinds: domain domain domain list\n", "kinds: domain domain domain time\n", ""}) {
    const fs::path file = folder_.write("t.nrrd", "NRRD0004\ntype: short\ndimension: 4\nsizes: 2 2 2 3\n" + kinds +
                                                      "spacings: 1 1 1 2\nencoding: raw\n" + little + voxels);
    VolumeRequest request;
    for (int frame = 0; frame < 3; ++frame) {
      request.frame = frame;
      EXPECT_EQ(read(file, request).fields[0].field->scalar({5e-4, 5e-4, 5e-4}).value, 10.0 * frame);
    }
    EXPECT_TRUE(warns_of(read(file), "3 frames"));
    request.frame = 3;
    EXPECT_NE(error_of([&] { read(file, request); }).find("not frame 3"), std::string::npos);
    request.frame = -1, request.as = "vector";
    EXPECT_EQ(read(file, request).fields[0].field->vector({5e-4, 5e-4, 5e-4}).value, (Vec3{0, 10, 20}));
  }
}

TEST_F(Nrrd, PlainAxesTakeTheirCentresFromMinsAndCentring) {
  std::string voxels;
  for (int v = 0; v < 64; ++v) voxels += bytes_of(static_cast<std::uint8_t>(v));
  const std::string start = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\nspacings: 2 2 2\n";
  const Volume cells = read(folder_.write("a.nrrd", start + "axis mins: 10 0 0\ncenterings: cell cell cell\n\n" + voxels));
  EXPECT_NEAR(grid_of(*cells.fields[0].field)->geometry.origin_m.x, 11e-3, 1e-15);
  const Volume nodes = read(folder_.write("b.nrrd", start + "axis mins: 10 0 0\ncenterings: node node node\n\n" + voxels));
  EXPECT_NEAR(grid_of(*nodes.fields[0].field)->geometry.origin_m.x, 10e-3, 1e-15);
  EXPECT_FALSE(nodes.medical_frame);
}

TEST_F(Nrrd, WhatIsNoScalarAndNoVectorIsRefusedWithItsKind) {
  const std::string voxels(6 * 8 * 4, '\0');
  const auto refused = [&](const std::string& kind, int size) {
    return error_of([&] {
      read(folder_.write("a.nrrd", "NRRD0004\ntype: float\ndimension: 4\nsizes: " + std::to_string(size) +
                                       " 2 2 2\nkinds: " + kind + " domain domain domain\nencoding: raw\n" + little + voxels));
    });
  };
  EXPECT_NE(refused("3D-symmetric-matrix", 6).find("3D-symmetric-matrix"), std::string::npos);
  EXPECT_NE(refused("RGB-color", 3).find("RGB-color"), std::string::npos);
}

}  // namespace nrrd_test
}  // namespace palpa::test
