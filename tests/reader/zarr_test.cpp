// Voxels, places and names of OME-Zarr stores: of zarr-python in version 2, written here in version 3.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "store_test.h"

namespace palpa::test {
namespace zarr_test {

using testing::HasSubstr;

/// Expects ramp at each voxel of a volume's field.
void expect_ramp(const Volume& volume, double highest = 100.0) {
  const GridView& grid = *grid_of(*volume.fields.front().field);
  std::size_t wrong = 0;
  for (std::int64_t k = 0; k < grid.geometry.dims[2]; ++k)
    for (std::int64_t j = 0; j < grid.geometry.dims[1]; ++j)
      for (std::int64_t i = 0; i < grid.geometry.dims[0]; ++i) {
        const Vec3 at_m = grid.geometry.to_world({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
        const double expected = std::min(ramp(i, j, k), highest);
        wrong += std::abs(volume.fields.front().field->scalar(at_m).value - expected) > 1e-9;
      }
  EXPECT_EQ(wrong, 0u);
}

TEST_F(PythonStores, EveryTypeCodecAndLayoutGivesItsVoxels) {
  int tried = 0;
  for (const auto& entry : fs::directory_iterator(stores())) {
    const std::string name = entry.path().filename();
    if (!name.starts_with("type ") && !name.starts_with("codec ") && !name.starts_with("layout ") && name != "planes" &&
        name != "one chunk" && name != "plain" && name != "no unit")
      continue;
    SCOPED_TRACE(name);
    ++tried;
    const double highest = name == "type b1" ? 1.0 : 100.0;
    StoreReader reader = open(entry.path());
    expect_voxels(reader, {}, [&](std::int64_t i, std::int64_t j, std::int64_t k) { return std::min(ramp(i, j, k), highest); });
    const Volume volume = read(entry.path());
    EXPECT_EQ(volume.format, "zarr");
    expect_ramp(volume, highest);
  }
  EXPECT_GE(tried, 40);
}

TEST_F(PythonStores, NarrowTypesWidenAndOthersStay) {
  for (const auto& [name, type, of_file] : {std::tuple{"i1", VoxelType::int16, "int8"},
                                            {"lu4", VoxelType::float64, "uint32"},
                                            {"lf2", VoxelType::float32, "float16"},
                                            {"b1", VoxelType::uint8, "bool"},
                                            {"bi4", VoxelType::int32, "int32"},
                                            {"lu2", VoxelType::uint16, "uint16"}}) {
    const StoreReader reader = open(stores() / (std::string("type ") + name));
    EXPECT_EQ(reader.contents().fields[0].type, type) << name;
    EXPECT_EQ(reader.contents().fields[0].file_type, of_file) << name;
  }
}

TEST_F(PythonStores, FramesAndChannelsAreFramesAndFields) {
  for (const char* name : {"five", "five together"}) {
    SCOPED_TRACE(name);
    StoreReader reader = open(stores() / name);
    const StoreContents& contents = reader.contents();
    EXPECT_EQ(contents.format, "OME-Zarr 0.4, Zarr v2");
    EXPECT_EQ(contents.frames, 3);
    EXPECT_DOUBLE_EQ(contents.period_s, 0.02);
    EXPECT_EQ(contents.length_unit, "nm");
    EXPECT_FALSE(contents.length_unit_assumed);
    ASSERT_EQ(contents.fields.size(), 2u);
    EXPECT_EQ(contents.fields[0].name, "p");
    EXPECT_EQ(contents.fields[1].components, 3);
    const GridGeometry& grid = contents.octaves[0].grid;
    EXPECT_EQ(grid.dims, (std::array<std::int64_t, 3>{8, 7, 6}));
    EXPECT_NEAR(grid.index_to_world_m.row[0].x, 0.25e-9, 1e-20);
    EXPECT_NEAR(grid.index_to_world_m.row[2].z, 2e-9, 1e-20);
    for (std::int32_t frame = 0; frame < 3; ++frame) {
      expect_voxels(reader, {.frame = frame}, [&](auto i, auto j, auto k) { return ramp(i, j, k) + 1000.0 * frame; });
      // Channels 1, 3 and 2 are x, y and z.
      const std::vector<double> vectors = numbers(reader, {.frame = frame, .field = 1, .at = {1, 1, 1}});
      ASSERT_EQ(vectors.size(), 192u);
      const double base = ramp(5, 6, 4) + 1000.0 * frame;
      const std::size_t first = 3 * static_cast<std::size_t>((0 * 4 + 2) * 4 + 1);
      EXPECT_EQ(vectors[first], base + 100.0);
      EXPECT_EQ(vectors[first + 1], base + 300.0);
      EXPECT_EQ(vectors[first + 2], base + 200.0);
    }
    VolumeRequest request;
    request.frame = 2;
    const Volume volume = read(stores() / name, request);
    ASSERT_EQ(volume.fields.size(), 2u);
    const Vec3 at_m = grid.to_world({5, 6, 4});
    EXPECT_DOUBLE_EQ(volume.fields[0].field->scalar(at_m).value, ramp(5, 6, 4) + 2000.0);
    EXPECT_DOUBLE_EQ(volume.fields[1].field->vector(at_m).value.z, ramp(5, 6, 4) + 2200.0);
  }
}

TEST_F(PythonStores, UnitsAreOfTheFileOrMicrometresWithAWarning) {
  const StoreReader reader = open(stores() / "no unit");
  EXPECT_TRUE(reader.contents().length_unit_assumed);
  EXPECT_EQ(reader.contents().length_unit, "um");
  EXPECT_DOUBLE_EQ(reader.contents().octaves[0].grid.index_to_world_m.row[0].x, 1e-6);
  const Volume volume = read(stores() / "no unit");
  EXPECT_TRUE(volume.length_unit_assumed);
  EXPECT_TRUE(warns_of(volume, "micrometres are taken")) << all_warnings(volume);
  VolumeRequest request;
  request.length_unit = "mm";
  EXPECT_NEAR(read(stores() / "no unit", request).bounds_m().high_m.x, 0.04, 1e-12);
}

TEST_F(PythonStores, APlainArrayIsOneOctaveWithWarnings) {
  const StoreReader reader = open(stores() / "plain");
  EXPECT_EQ(reader.contents().octaves.size(), 1u);
  EXPECT_EQ(reader.contents().format, "Zarr v2");
  EXPECT_THAT(reader.contents().warnings, testing::Contains(HasSubstr("1 µm apart")));
}

TEST_F(PythonStores, AbsentChunksHaveTheFillValue) {
  StoreReader reader = open(stores() / "sparse");
  EXPECT_TRUE(std::isnan(reader.contents().fields[0].fill));
  StoreRead how;
  EXPECT_EQ(numbers(reader, {}, &how).at(9), 5.0);
  EXPECT_GT(how.bytes, 0u);
  numbers(reader, {.at = {1, 0, 0}}, &how);
  EXPECT_EQ(how.state, ChunkState::absent);
  const Volume volume = read(stores() / "sparse");
  EXPECT_TRUE(warns_of(volume, "lacks 26 of 27 chunks")) << all_warnings(volume);
  EXPECT_FALSE(volume.fields[0].field->scalar({3e-5, 1e-5, 1e-5}).inside);
}

TEST_F(PythonStores, WhatIsNotReadIsRefusedInOneLine) {
  EXPECT_THAT(error_of_store(stores() / "refused int64"),
              HasSubstr("int64, which is not read; convert it to int32 or float64"));
  EXPECT_THAT(error_of_store(stores() / "refused complex64"), HasSubstr("magnitude"));
  EXPECT_THAT(error_of_store(stores() / "refused filters"), HasSubstr("filters, which are not read"));
  EXPECT_THAT(error_of_store(stores() / "refused lzma"),
              HasSubstr("'lzma', which is not read; blosc, zstd, gzip and zlib are"));
  EXPECT_THAT(error_of([&] { read(stores() / "refused int64"); }), HasSubstr("'0/.zarray'"));
}

TEST_F(StoreTest, Version3IsReadWithAndWithoutShards) {
  for (const char* codec : {"raw", "gzip", "zstd", "blosc"}) {
    for (int variant = 0; variant < 5; ++variant) {
      SCOPED_TRACE(std::string(codec) + " " + std::to_string(variant));
      ZarrToWrite array{.format = 3, .shape = {19, 37, 41}, .chunk = {8, 8, 16}, .type = "uint16", .codec = codec};
      if (variant > 0) array.shard = {16, 16, 32};
      array.has_checksum = variant == 1 || variant == 3;
      array.index_at_end = variant != 3 && variant != 4;
      const fs::path store = write(std::string(codec) + std::to_string(variant), array);
      StoreReader reader = open(store);
      EXPECT_EQ(reader.contents().format, "OME-Zarr 0.5, Zarr v3");
      EXPECT_EQ(reader.contents().octaves[0].chunk, (std::array<std::int64_t, 3>{16, 8, 8}));
      EXPECT_EQ(reader.contents().octaves[0].shard[0], variant > 0 ? 32 : 16);
      expect_voxels(reader, {}, ramp);
      expect_ramp(read(store));
    }
  }
}

TEST_F(StoreTest, ChunksOfAShardMayBeAbsent) {
  ZarrToWrite array{.format = 3, .shape = {32, 32, 32}, .chunk = {8, 8, 8}, .shard = {16, 16, 16}, .fill = "9"};
  array.has_chunk = [](const std::vector<std::int64_t>& chunk) { return chunk[0] != 3 && chunk[2] == 1; };
  StoreReader reader = open(write("sparse", array));
  expect_voxels(reader, {}, [](auto i, auto j, auto k) { return k < 24 && i / 8 == 1 ? ramp(i, j, k) : 9.0; });
}

TEST_F(StoreTest, CoordinateSystemsOfVersion06AreRead) {
  const std::string attributes =
      R"("multiscales":[{"version":"0.6","coordinateSystems":[{"name":"array","axes":[{"name":"z"},{"name":"y"},{"name":"x"}]},)"
      R"({"name":"world","axes":[{"name":"z","type":"space","unit":"millimeter"},{"name":"y","type":"space","unit":"millimeter"},)"
      R"({"name":"x","type":"space","unit":"millimeter"}]}],"datasets":[{"path":"0","coordinateTransformations":[{"type":"sequence",)"
      R"("input":"0","output":"world","transformations":[{"type":"scale","scale":[3,2,1]},{"type":"translation","translation":[5,6,7]}]}]}]}])";
  const StoreReader reader = open(write("six", {.format = 3, .shape = {8, 8, 8}, .chunk = {8, 8, 8}}, attributes));
  const GridGeometry& grid = reader.contents().octaves[0].grid;
  EXPECT_NEAR(grid.index_to_world_m.row[2].z, 3e-3, 1e-15);
  EXPECT_NEAR(norm(grid.origin_m - Vec3{7e-3, 6e-3, 5e-3}), 0.0, 1e-15);
}

/// Attributes of 0.6 whose dataset lies in "own", with further transformations of the image.
std::string image_in_systems(const std::string& further) {
  std::string systems;
  for (const auto& [name, unit] :
       {std::pair{"far", "meter"}, {"own", "micrometer"}, {"stage", "millimeter"}, {"other", "meter"}}) {
    std::string axes;
    for (const char* axis : {"z", "y", "x"})
      axes +=
          (axes.empty() ? "" : ",") + (R"({"name":")" + std::string(axis) + R"(","type":"space","unit":")" + unit + R"("})");
    systems += (systems.empty() ? "" : ",") + (R"({"name":")" + std::string(name) + R"(","axes":[)" + axes + "]}");
  }
  return R"("multiscales":[{"version":"0.6","coordinateSystems":[)" + systems +
         R"(],"datasets":[{"path":"0","coordinateTransformations":[{"type":"scale","scale":[3,2,1],"input":{"path":"0"},"output":{"name":"own"}}]}],)" +
         R"("coordinateTransformations":[)" + further + "]}]";
}

std::string scale_between(const std::string& by, const std::string& input, const std::string& output) {
  return R"({"type":"scale","scale":[)" + by + "," + by + "," + by + R"(],"input":{"name":")" + input + R"("},"output":)" +
         output + "}";
}

TEST_F(StoreTest, AnImageLiesInTheOnlyCoordinateSystemThatItLeadsTo) {
  int number = 0;
  const auto expect_step = [&](const std::string& further, double z_step_m, bool is_warned) {
    const StoreReader reader = open(write("s" + std::to_string(number++), {.format = 3, .shape = {8, 8, 8}, .chunk = {8, 8, 8}},
                                          image_in_systems(further)));
    EXPECT_NEAR(reader.contents().octaves[0].grid.index_to_world_m.row[2].z / z_step_m, 1.0, 1e-12) << further;
    const auto& warnings = reader.contents().warnings;
    EXPECT_EQ(std::ranges::any_of(warnings, [](const std::string& w) { return w.find("several") != std::string::npos; }),
              is_warned);
  };
  const std::string to_stage = scale_between("10", "own", R"({"name":"stage"})");
  const std::string to_far = scale_between("7", "stage", R"({"name":"far"})");
  const std::string to_other = scale_between("5", "own", R"({"name":"other"})");
  const std::string outside = scale_between("9", "own", R"({"name":"far","path":"elsewhere"})");
  const std::string back = scale_between("1", "far", R"({"name":"own"})");
  expect_step(to_stage, 30e-3, false);
  expect_step(to_stage + "," + to_far, 210.0, false);
  expect_step(to_far + "," + to_stage, 210.0, false);
  expect_step(to_stage + "," + to_other, 3e-6, true);
  expect_step(outside, 3e-6, false);
  expect_step(scale_between("4", "far", R"({"name":"stage"})"), 3e-6, false);
  open(write("cycle", {.format = 3, .shape = {8, 8, 8}, .chunk = {8, 8, 8}},
             image_in_systems(to_stage + "," + to_far + "," + back)));
}

/// Attributes of an image of axes z, y, x in millimetres, with this transformation.
std::string image_with(const std::string& transform) {
  std::string axes;
  for (const char* name : {"z", "y", "x"})
    axes += (axes.empty() ? "" : ",") + (R"({"name":")" + std::string(name) + R"(","type":"space","unit":"millimeter"})");
  return R"("multiscales":[{"version":"0.6","axes":[)" + axes + R"(],"datasets":[{"path":"0","coordinateTransformations":[)" +
         transform + "]}]}]";
}

TEST_F(StoreTest, RotationsAndAffinesTurnAndShearTheGrid) {
  const std::string transforms =
      R"({"type":"sequence","transformations":[{"type":"scale","scale":[3,2,1]},)"
      R"({"type":"rotation","rotation":[[1,0,0],[0,0.8,0.6],[0,-0.6,0.8]]},{"type":"translation","translation":[0,1,0]},)"
      R"({"type":"affine","affine":[[1,0.5,0,7],[0,1,0,0],[0,0,-2,4]]}]})";
  // By hand, at (i, j, k) = (5, 3, 2), in z, y, x: scaled (6, 6, 5); turned (6, 7.8, 0.4); moved (6, 8.8, 0.4); sheared (6
  // + 4.4 + 7, 8.8, 4 - 0.8).
  const Vec3 expected_m{3.2e-3, 8.8e-3, 17.4e-3};
  const StoreReader reader = open(write("turned", {.shape = {8, 8, 8}, .chunk = {8, 8, 8}}, image_with(transforms)));
  const GridGeometry& grid = reader.contents().octaves[0].grid;
  EXPECT_NEAR(norm(grid.to_world({5, 3, 2}) - expected_m), 0.0, 1e-15);
  const Volume volume = read(at("turned"));
  EXPECT_DOUBLE_EQ(volume.fields.front().field->scalar(expected_m).value, ramp(5, 3, 2));
}

TEST_F(StoreTest, TransformationsThatNoGridHasAreSaidInOneLine) {
  const auto error_of_transform = [&](const std::string& transform) {
    fs::remove_all(at("wrong"));
    return error_of_store(write("wrong", {.shape = {8, 8, 8}, .chunk = {8, 8, 8}}, image_with(transform)));
  };
  EXPECT_THAT(error_of_transform(R"({"type":"rotation","rotation":[1]})"), HasSubstr("no list of 3 lists of 3 numbers"));
  EXPECT_THAT(error_of_transform(R"({"type":"affine","affine":[[1,0,0],[0,1,0],[0,0,1]]})"), HasSubstr("of 4 numbers"));
  EXPECT_THAT(error_of_transform(R"({"type":"affine","affine":[[1,0,0,0],[0,1,0,"x"],[0,0,1,0]]})"), HasSubstr("of 4 numbers"));
  EXPECT_THAT(error_of_transform(R"({"type":"displacements","path":"d"})"),
              HasSubstr("'displacements', which is not read; scale, translation, rotation and affine are"));
  EXPECT_THAT(error_of_transform(R"({"type":"affine","affine":[[1,0,0,0],[1,0,0,0],[0,0,1,0]]})"), HasSubstr("; "));
  const std::string mixed = R"("multiscales":[{"axes":["t","z","y","x"],"datasets":[{"path":"0","coordinateTransformations":[)"
                            R"({"type":"rotation","rotation":[[1,0,0,0.5],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}]}])";
  EXPECT_THAT(error_of_store(write("mixed", {.shape = {2, 8, 8, 8}, .chunk = {1, 8, 8, 8}}, mixed)),
              HasSubstr("mixes space with time or channels"));
}

TEST_F(StoreTest, OctavesThatAreNoHalvesAreLeftOut) {
  write("odd", {.shape = {32, 32, 32}, .chunk = {16, 16, 16}}, multiscales(3, true));
  write_zarr_array(at("odd") / "1", {.shape = {16, 16, 16}, .chunk = {16, 16, 16}, .value = [](const auto&) { return 1.0; }});
  write_zarr_array(at("odd") / "2", {.shape = {4, 4, 4}, .chunk = {16, 16, 16}, .value = [](const auto&) { return 1.0; }});
  const StoreReader reader = open(at("odd"));
  EXPECT_EQ(reader.contents().octaves.size(), 2u);
  EXPECT_THAT(reader.contents().warnings, testing::Contains(HasSubstr("'2' that is no half")));
}

TEST_F(StoreTest, GroupsSayWhichFolderToName) {
  write_text_file(at("plate") / ".zattrs", R"({"plate":{}})");
  EXPECT_THAT(error_of_store(at("plate")), HasSubstr("is a plate of many images; name one"));
  write_text_file(at("series") / ".zattrs", R"({"bioformats2raw.layout":3})");
  write_zarr_image(at("series") / "0", 32, 2, "raw", ramp);
  EXPECT_EQ(open(at("series")).contents().octaves.size(), 3u);
  write_zarr_image(at("series") / "1", 32, 2, "raw", ramp);
  EXPECT_THAT(error_of_store(at("series")), HasSubstr("holds several images; name one, as STORE/0"));
  write_text_file(at("arrays") / ".zgroup", R"({"zarr_format":2})");
  EXPECT_THAT(error_of_store(at("arrays")), HasSubstr("without an array or image"));
}

TEST_F(StoreTest, OtherFormatsOfChunksSayWhatMakesAZarrOfThem) {
  write_text_file(at("a.n5") / "attributes.json", R"({"n5":"2.5.1"})");
  EXPECT_THAT(error_of_store(at("a.n5")), HasSubstr("is N5, which is not read; zarr-python 2 makes a Zarr of it"));
  write_text_file(at("pre") / "info", R"({"@type": "neuroglancer_multiscale_volume"})");
  EXPECT_THAT(error_of_store(at("pre")), HasSubstr("neuroglancer precomputed"));
  EXPECT_THAT(error_of([&] { read(folder_.write("a.vdb", std::string(" BDV\0\0\0\0", 8))); }), HasSubstr("OpenVDB"));
  EXPECT_THAT(error_of([&] { read(folder_.write("a.segy", "C 1 CLIENT")); }), HasSubstr("SEG-Y"));
  EXPECT_THAT(error_of_store(folder_.write("a.nrrd", "NRRD0004\n")), HasSubstr("is no OME-Zarr"));
  EXPECT_THAT(error_of_store(at("none")), HasSubstr("none: "));
}

TEST_F(StoreTest, ChecksumsCoverMetadataAndChunks) {
  const fs::path store = write("sums", {.shape = {20, 20, 20}, .chunk = {16, 16, 16}, .codec = "zlib"});
  const Volume volume = read(store);
  EXPECT_EQ(volume.files.size(), 3u + 8u);
  for (const SourceFile& file : volume.files) EXPECT_EQ(file.sha256.text().size(), 64u) << file.path;
}

}  // namespace zarr_test
}  // namespace palpa::test
