// Files of bare numbers, whose shape is given by keys.
#include <cmath>
#include <fstream>

#include "files.h"

namespace palpa::test {
namespace raw_test {

const FileGrid grid{{6, 5, 4}, {{{0.5, 0, 0}, {0, 0.25, 0}, {0, 0, 2}}}, {1, 2, 3}};
Vec3 metres(const Vec3& p) { return p; }

VolumeRequest of_type(const std::string& type) {
  VolumeRequest request;
  request.layout = {.type = type, .dims = {6, 5, 4}, .spacing_m = {0.5, 0.25, 2}, .origin_m = Vec3{1, 2, 3}};
  return request;
}

class Raw : public ReaderTest {
 protected:
  /// Read for a session, and for inspection only.
  template <class Check>
  void both(const fs::path& file, const VolumeRequest& request, Check check) {
    for (const bool look : {false, true}) {
      options_.preview = look;
      check(read(file, request));
    }
    options_.preview = false;
  }
};

TEST_F(Raw, EveryTypeAndByteOrderBehindAnyHeader) {
  const auto expect = [&](const std::string& type, auto number) {
    for (const bool big : {false, true}) {
      for (const std::size_t header : {0UL, 13UL, 64UL}) {
        SCOPED_TRACE(type + (big ? " big " : " little ") + std::to_string(header));
        VolumeRequest request = of_type(type);
        request.layout.byte_order = big ? "big" : "little";
        request.layout.header_bytes = static_cast<std::int64_t>(header);
        const Linear linear{{2, 4, 1}, 30};
        const fs::path file =
            folder_.write("a.raw", std::string(header, '#') + linear_voxels<decltype(number)>(grid, metres, big, linear));
        both(file, request, [&](const Volume& volume) {
          EXPECT_EQ(volume.format, "raw");
          EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
          expect_linear(*volume.fields[0].field, grid, metres, linear);
        });
      }
    }
  };
  expect("int8", std::int8_t{});
  expect("uint8", std::uint8_t{});
  expect("int16", std::int16_t{});
  expect("uint16", std::uint16_t{});
  expect("int32", std::int32_t{});
  expect("uint32", std::uint32_t{});
  expect("float32", float{});
  expect("float64", double{});
  EXPECT_NE(error_of([&] { read(folder_.write("a.raw", "12"), of_type("int12")); }).find("int8 to int64"), std::string::npos);
}

TEST_F(Raw, OtherOrdersOfAxesAndVectors) {
  const std::string zyx = linear_voxels<float>(grid, metres);
  std::string xyz, first, last;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 5; ++j)
      for (std::size_t k = 0; k < 4; ++k) xyz += zyx.substr(4 * (i + 6 * (j + 5 * k)), 4);
  VolumeRequest request = of_type("float32");
  request.layout.axes = "xyz";
  both(folder_.write("a.raw", xyz), request,
       [&](const Volume& volume) { expect_linear(*volume.fields[0].field, grid, metres); });
  for (int v = 0; v < 6 * 5 * 4; ++v)
    for (const float c : {1.0F, 2.0F, 3.0F}) last += bytes_of(c);
  for (const float c : {1.0F, 2.0F, 3.0F})
    for (int v = 0; v < 6 * 5 * 4; ++v) first += bytes_of(c);
  request = of_type("float32");
  for (const auto& [said, bytes] : {std::pair{"first", first}, {"last", last}}) {
    request.layout.components = said;
    both(folder_.write("a.raw", bytes), request,
         [&](const Volume& volume) { EXPECT_EQ(volume.fields[0].field->vector({1.2, 2.1, 4}).value, (Vec3{1, 2, 3})); });
  }
}

TEST_F(Raw, SizesThatDoNotFitAreSaid) {
  const std::string bytes = linear_voxels<std::int16_t>(grid, metres);
  VolumeRequest request = of_type("int16");
  EXPECT_NE(error_of([&] { read(folder_.write("a.raw", bytes.substr(1)), request); }).find("239 bytes"), std::string::npos);
  EXPECT_TRUE(warns_of(read(folder_.write("a.raw", bytes + "ab"), request), "2 bytes more"));
  request.layout.header_bytes = 4;
  EXPECT_NE(error_of([&] { read(folder_.write("a.raw", bytes), request); }).find("need 244"), std::string::npos);
  request = of_type("int16");
  request.layout.dims = {1'000'000'000, 1'000'000'000, 1'000'000'000};
  error_of([&] { read(folder_.write("a.raw", bytes), request); });
  request.layout.dims = {0, 5, 4};
  EXPECT_NE(error_of([&] { read(folder_.write("a.raw", bytes), request); }).find("dims"), std::string::npos);
  request = of_type("int16");
  options_.max_bytes = 200;
  EXPECT_NE(error_of([&] { read(folder_.write("a.raw", bytes), request); }).find("are allowed"), std::string::npos);
  options_.max_bytes = 0;
  error_of([&] { read(folder_.path(), request); });
  request.as = "vector";
  EXPECT_NE(error_of([&] { read(folder_.write("a.raw", bytes), request); }).find("bare numbers"), std::string::npos);
}

TEST_F(Raw, ASessionHasItsOwnCopyAndTheChecksum) {
  const fs::path file = folder_.write("a.raw", linear_voxels<std::int16_t>(grid, metres));
  const Volume volume = read(file, of_type("int16"));
  EXPECT_EQ(volume.files.front().sha256.text().size(), 64U);
  fs::resize_file(file, 0);
  expect_linear(*volume.fields[0].field, grid, metres);
}

TEST_F(Raw, AFileThatIsCutShortWhileItIsLookedAtEndsNothing) {
  VolumeRequest request = of_type("int16");
  request.layout.dims = {64, 64, 64};
  const fs::path file = folder_.write("a.raw", std::string(2 * 64 * 64 * 64, '\x11'));
  options_.preview = true;
  const Volume volume = read(file, request);
  const Field& field = *volume.fields[0].field;
  const GridGeometry& grid64 = grid_of(field)->geometry;
  EXPECT_EQ(field.scalar(grid64.to_world({32, 32, 40})).value, 0x1111);
  fs::resize_file(file, 2 * 64 * 64 * 8);
  EXPECT_EQ(field.scalar(grid64.to_world({32, 32, 40})).value, 0.0);
  EXPECT_EQ(field.scalar(grid64.to_world({32, 32, 4})).value, 0x1111);
}

TEST_F(Raw, ALookAtALargeFileReadsOneRowInMany) {
  const fs::path file = folder_.write("a.raw", "");
  VolumeRequest request = of_type("int16");
  request.layout.dims = {300, 300, 300};
  fs::resize_file(file, 2 * 300 * 300 * 300);  // zeros without disk space
  const std::int64_t place[] = {17, 151, 3};   // of the one different voxel, in a skipped row
  {
    std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
    bytes.seekp(2 * (place[0] + 300 * (place[1] + 300 * place[2])));
    bytes << bytes_of(std::int16_t{7});
  }
  both(file, request, [&](const Volume& volume) {
    const Field& field = *volume.fields[0].field;
    const GridGeometry& large = grid_of(field)->geometry;
    const auto at = [&](int a) { return static_cast<double>(place[a]); };
    EXPECT_EQ(field.scalar(large.to_world({at(0), at(1), at(2)})).value, 7.0);
    const Vec3 from_m = large.to_world({at(0), at(1), 0}), to_m = large.to_world({at(0), at(1), 10});
    const ValueRange all{-1.0, 100.0};
    EXPECT_TRUE(field.piece_along(from_m, to_m, 0.31, all).inside);
    EXPECT_EQ(field.value_ranges()[0].max, options_.preview ? 0.0 : 7.0);
    EXPECT_EQ(all_warnings(volume).find("one row of voxels in 25") != std::string::npos, options_.preview);
  });
}

TEST_F(Raw, AStopLeavesNoChecksumOut) {
  VolumeRequest request = of_type("int16");
  request.layout.dims = {64, 64, 64};
  const fs::path file = folder_.write("a.raw", std::string(2 * 64 * 64 * 64, '\x11'));
  std::stop_source stop;
  stop.request_stop();
  options_.stop = stop.get_token();
  EXPECT_NE(error_of([&] { read(file, request); }).find("cancelled"), std::string::npos);
}

TEST_F(Raw, WithoutChecksums) {
  options_.checksums = Checksums::none;
  for (const char* name : {"a.raw", "a.nrrd"}) {
    const std::string header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 6 5 4\nspacings: 1 1 1\nencoding: raw\n\n";
    const bool raw = std::string(name) == "a.raw";
    VolumeRequest request;
    if (raw) request = of_type("uint8");
    const fs::path file = folder_.write(name, (raw ? "" : header) + std::string(120, 'x'));
    const Volume volume = read(file, request);
    ASSERT_EQ(volume.files.size(), 1U);
    EXPECT_EQ(volume.files[0].bytes, fs::file_size(file));
    EXPECT_EQ(volume.files[0].sha256, "");
  }
  options_.checksums = Checksums::now;
}

TEST_F(Raw, ChecksumsAreEqualSoonerOrLater) {
  const std::string header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 6 5 4\nspacings: 1 1 1\nencoding: raw\n";
  const fs::path numbers = folder_.write("a.raw", std::string(120, 'x'));
  for (const fs::path& file : {numbers, folder_.write("a.nrrd", header + "\n" + std::string(120, 'x')),
                               folder_.write("a.nhdr", header + "data file: a.raw\n")}) {
    const VolumeRequest request = file == numbers ? of_type("uint8") : VolumeRequest{};
    options_.checksums = Checksums::now;
    const Volume now = read(file, request);
    options_.checksums = Checksums::later;
    const Volume later = read(file, request);
    ASSERT_EQ(now.files.size(), later.files.size());
    for (std::size_t f = 0; f < now.files.size(); ++f) {
      EXPECT_EQ(now.files[f].sha256.text().size(), 64u);
      EXPECT_EQ(now.files[f].path, later.files[f].path);
      EXPECT_EQ(now.files[f].bytes, later.files[f].bytes);
      EXPECT_EQ(now.files[f].sha256, later.files[f].sha256) << file;
    }
  }
  options_.checksums = Checksums::now;
}

TEST_F(Raw, KeysOfShapeAreRefusedWhereTheFileSaysIt) {
  const fs::path file = folder_.write("a.nrrd",
                                      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: "
                                      "raw\n\n12345678");
  read(file);
  VolumeRequest request;
  request.layout.dims = {2, 2, 2};
  EXPECT_NE(error_of([&] { read(file, request); }).find("says its own shape"), std::string::npos);
}

}  // namespace raw_test
}  // namespace palpa::test
