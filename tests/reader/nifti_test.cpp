#include <cmath>

#include "files.h"

namespace palpa::test {
namespace nifti_test {

class Nifti : public ReaderTest {};

/// A NIfTI-1 file, field by field.
struct File {
  std::vector<std::int16_t> dim{3, 6, 5, 4};
  float pixdim[4] = {1, 2, 3, 4};
  std::int16_t datatype = 16, bits = 32, intent = 0;
  float slope = 0, inter = 0;
  char units = 2;
  std::int16_t qform = 0, sform = 0;
  float quaternion[3] = {0, 0, 0}, offset[3] = {0, 0, 0};
  FileGrid grid = sheared_grid();
  bool big = false;
  bool pair = false;

  std::string header() const {
    std::string h(352, '\0');
    const auto put = [&](std::size_t at, auto value) { h.replace(at, sizeof value, bytes_of(value, big)); };
    put(0, std::int32_t{348});
    for (std::size_t d = 0; d < 8; ++d) put(40 + 2 * d, d < dim.size() ? dim[d] : std::int16_t{1});
    put(68, intent), put(70, datatype), put(72, bits);
    for (std::size_t d = 0; d < 8; ++d) put(76 + 4 * d, d < 4 ? pixdim[d] : 1.0F);
    put(108, pair ? 0.0F : 352.0F);
    put(112, slope), put(116, inter);
    h[123] = units;
    put(252, qform), put(254, sform);
    for (std::size_t n = 0; n < 3; ++n) put(256 + 4 * n, quaternion[n]), put(268 + 4 * n, offset[n]);
    const double origin[3] = {grid.origin.x, grid.origin.y, grid.origin.z};
    for (std::size_t r = 0; r < 3; ++r) {
      const Vec3& row = grid.step.row[r];
      put(280 + 16 * r, static_cast<float>(row.x)), put(284 + 16 * r, static_cast<float>(row.y));
      put(288 + 16 * r, static_cast<float>(row.z)), put(292 + 16 * r, static_cast<float>(origin[r]));
    }
    h.replace(344, 4, pair ? std::string("ni1\0", 4) : std::string("n+1\0", 4));
    return h;
  }
};

/// The grid in single precision.
FileGrid rounded(FileGrid grid) {
  const auto narrow = [](Vec3& v) { v = {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; };
  for (Vec3& row : grid.step.row) narrow(row);
  narrow(grid.origin);
  return grid;
}

Vec3 ras_mm(const Vec3& p) { return 1e-3 * Vec3{-p.x, -p.y, p.z}; }
Vec3 plain_mm(const Vec3& p) { return 1e-3 * p; }

TEST_F(Nifti, ShearedSformsOfEitherHandAndByteOrder) {
  for (const bool mirrored : {false, true}) {
    for (const bool big : {false, true}) {
      SCOPED_TRACE(std::string(mirrored ? "mirrored" : "direct") + (big ? ", big endian" : ""));
      File file;
      file.sform = 2, file.big = big;
      if (mirrored) file.grid.step = file.grid.step * Mat3{{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
      const FileGrid grid = rounded(file.grid);
      const std::string voxels = linear_voxels<float>(grid, ras_mm, big);
      for (const fs::path& path :
           {folder_.write("a.nii", file.header() + voxels), folder_.write("a.nii.gz", gzipped(file.header() + voxels))}) {
        const Volume volume = read(path);
        EXPECT_TRUE(volume.medical_frame);
        EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
        expect_linear(*volume.fields[0].field, grid, ras_mm);
      }
    }
  }
}

/// The header with other bytes at an offset.
template <class T>
std::string with(std::string header, std::size_t at, T value, bool big) {
  return header.replace(at, sizeof value, bytes_of(value, big));
}

// No byte of the header becomes a voxel, and no voxel is shifted.
TEST_F(Nifti, AnOffsetIntoTheHeaderIsRefusedOrTheHeadersEndIsTaken) {
  for (const bool big : {false, true}) {
    File file;
    file.sform = 2, file.big = big;
    const FileGrid grid = rounded(file.grid);
    const std::string voxels = linear_voxels<float>(grid, ras_mm, big), header = file.header();
    const auto nifti = [&](float offset, const std::string& start) {
      return folder_.write("a.nii", with(start, 108, offset, big) + voxels);
    };
    const Volume zero = read(nifti(0.0F, header));
    EXPECT_TRUE(warns_of(zero, "from byte 352 on"));
    expect_linear(*zero.fields[0].field, grid, ras_mm);
    for (const float offset :
         {std::nanf(""), INFINITY, -INFINITY, -1.0F, -352.0F, 1.0F, 16.0F, 347.0F, 349.0F, 351.0F, 352.5F, 1e30F}) {
      const std::string error = error_of([&] { read(nifti(offset, header)); });
      EXPECT_NE(error.find("vox_offset"), std::string::npos) << offset << ": " << error;
    }
    const Volume short_header = read(nifti(348.0F, header.substr(0, 348)));  // without the flag of extensions
    expect_linear(*short_header.fields[0].field, grid, ras_mm);
    error_of([&] { read(nifti(1e6F, header)); });
    // An extension of 32 bytes: before the voxels, or reaching into them.
    std::string extended = with(header, 348, std::int8_t{1}, false);
    extended += bytes_of(std::int32_t{32}, big) + bytes_of(std::int32_t{6}, big) + std::string(24, 'x');
    expect_linear(*read(nifti(384.0F, extended)).fields[0].field, grid, ras_mm);
    for (const float offset : {352.0F, 368.0F}) {
      const std::string error = error_of([&] { read(nifti(offset, extended)); });
      EXPECT_NE(error.find("extensions that end at byte 384"), std::string::npos) << error;
    }
  }
}

TEST_F(Nifti, QformsWithAndWithoutReversedSlices) {
  for (const float qfac : {1.0F, -1.0F}) {
    SCOPED_TRACE(qfac);
    File file;
    file.qform = 1;
    file.pixdim[0] = qfac;
    // 120° about (1,1,1): x → y → z → x.
    for (float& q : file.quaternion) q = 0.5F;
    file.offset[0] = 10, file.offset[1] = 20, file.offset[2] = -30;
    file.grid.step = {{{0, 0, qfac * 4.0}, {2, 0, 0}, {0, 3, 0}}};
    file.grid.origin = {10, 20, -30};
    const Volume volume = read(folder_.write("a.nii", file.header() + linear_voxels<float>(file.grid, ras_mm)));
    EXPECT_TRUE(volume.medical_frame);
    expect_linear(*volume.fields[0].field, file.grid, ras_mm);
    EXPECT_EQ(grid_of(*volume.fields[0].field)->geometry.origin_m, ras_mm(file.grid.origin));
  }
}

TEST_F(Nifti, TheSformGoesBeforeTheQform) {
  File file;
  file.qform = 1, file.sform = 1;
  file.offset[0] = 1000;
  file.pixdim[0] = -1;
  const FileGrid grid = rounded(file.grid);
  const Volume volume = read(folder_.write("a.nii", file.header() + linear_voxels<float>(grid, ras_mm)));
  expect_linear(*volume.fields[0].field, grid, ras_mm);
}

TEST_F(Nifti, WithoutEitherFormThereIsNoMedicalFrame) {
  File file;
  file.grid = {{6, 5, 4}, {{{2, 0, 0}, {0, 3, 0}, {0, 0, 4}}}, {}};
  file.units = 0;
  const Volume volume = read(folder_.write("a.nii", file.header() + linear_voxels<float>(file.grid, plain_mm)));
  EXPECT_FALSE(volume.medical_frame);
  EXPECT_TRUE(warns_of(volume, "millimetres are taken"));
  expect_linear(*volume.fields[0].field, file.grid, plain_mm);
}

TEST_F(Nifti, UnitsOfTheHeader) {
  File file;
  file.sform = 1, file.units = 3;
  const FileGrid grid = rounded(file.grid);
  const auto ras_um = [](const Vec3& p) { return 1e-6 * Vec3{-p.x, -p.y, p.z}; };
  const Linear steep{{3e5, 2e5, -4e5}, 3.0};
  expect_linear(*read(folder_.write("a.nii", file.header() + linear_voxels<float>(grid, ras_um, false, steep))).fields[0].field,
                grid, ras_um, steep);
}

TEST_F(Nifti, ACodeOfTheUnitThatIsNoneIsRefused) {
  File file;
  file.sform = 1;
  const FileGrid grid = rounded(file.grid);
  const std::string voxels = linear_voxels<float>(grid, ras_mm);
  for (const int code : {4, 5, 6, 7, 12 /* code 4, and a time in seconds */}) {
    file.units = static_cast<char>(code);
    const fs::path path = folder_.write("a.nii", file.header() + voxels);
    const std::string error = error_of([&] { read(path); });
    EXPECT_NE(error.find("of xyzt_units', which is unknown; give it by length_unit"), std::string::npos) << error;
    VolumeRequest request;
    request.length_unit = "mm";
    expect_linear(*read(path, request).fields[0].field, grid, ras_mm);
  }
  file.units = 10;  // millimetres and seconds
  EXPECT_TRUE(read(folder_.write("a.nii", file.header() + voxels)).warnings.empty());
}

TEST_F(Nifti, ValuesAreRescaledUnlessTheSlopeIsZero) {
  File file;
  file.sform = 1, file.datatype = 4, file.bits = 16, file.slope = 0.5F, file.inter = -1024;
  std::string voxels;
  for (int v = 0; v < 120; ++v) voxels += bytes_of(static_cast<std::int16_t>(100 + v));
  const Volume volume = read(folder_.write("a.nii", file.header() + voxels));
  const GridView& view = *grid_of(*volume.fields[0].field);
  EXPECT_EQ(view.voxels.type, VoxelType::int16);
  EXPECT_EQ(volume.fields[0].field->scalar(view.geometry.to_world({1, 0, 0})).value, 0.5 * 101 - 1024);
  EXPECT_EQ(volume.fields[0].field->value_ranges()[0].min, 0.5 * 100 - 1024);
  file.slope = 0;
  EXPECT_EQ(read(folder_.write("b.nii", file.header() + voxels)).fields[0].field->value_ranges()[0].min, 100.0);
  file.slope = std::nanf("");
  EXPECT_EQ(read(folder_.write("c.nii", file.header() + voxels)).fields[0].field->value_ranges()[0].min, 100.0);
}

// Vectors of RAS, stored in planes as in NIfTI: v(x) = position, scaled, in the world v = x too.
TEST_F(Nifti, VectorsTurnWithPositions) {
  File file;
  file.sform = 1;
  const FileGrid grid = rounded(file.grid);
  std::string planes[3];
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 5; ++j)
      for (int i = 0; i < 6; ++i) {
        const Vec3 at = grid.at({double(i), double(j), double(k)});
        planes[0] += bytes_of(static_cast<float>((at.x - 1) / 2)), planes[1] += bytes_of(static_cast<float>((at.y - 1) / 2));
        planes[2] += bytes_of(static_cast<float>((at.z - 1) / 2));
      }
  const std::string voxels = planes[0] + planes[1] + planes[2];
  file.slope = 2, file.inter = 1;

  const auto expect_positions = [&](const Volume& volume) {
    const Vec3 at_m = ras_mm(grid.at({2.3, 1.2, 2.6}));
    const VectorSample sample = volume.fields[0].field->vector(at_m);
    ASSERT_TRUE(sample.inside);
    EXPECT_LT(distance(sample.value, 1e3 * at_m), 1e-4);
  };
  VolumeRequest as_vector;
  as_vector.as = "vector";
  file.dim = {4, 6, 5, 4, 3};
  const fs::path four = folder_.write("4.nii", file.header() + voxels);
  expect_positions(read(four, as_vector));
  EXPECT_EQ(read(four).fields[0].field->components(), 1);
  EXPECT_TRUE(warns_of(read(four), "3 frames"));
  file.intent = 1007;
  expect_positions(read(folder_.write("4i.nii", file.header() + voxels)));
  file.dim = {5, 6, 5, 4, 1, 3};
  expect_positions(read(folder_.write("5i.nii", file.header() + voxels)));
  file.intent = 0;
  const fs::path five = folder_.write("5.nii", file.header() + voxels);
  expect_positions(read(five, as_vector));
  EXPECT_NE(error_of([&] { read(five); }).find("as = \"vector\""), std::string::npos);
  // A mirrored grid: its slices are reversed when read.
  file.grid.step = file.grid.step * Mat3{{{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}};
  file.intent = 1007;
  const Vec3 mirrored_m = ras_mm(rounded(file.grid).at({2, 1, 3}));
  EXPECT_LT(distance(read(folder_.write("5m.nii", file.header() + voxels)).fields[0].field->vector(mirrored_m).value,
                     1e3 * ras_mm(grid.at({2, 1, 3}))),
            1e-4);
}

TEST_F(Nifti, SformGoesBeforeQformAndDisagreementIsTold) {
  File file;
  file.sform = 1, file.qform = 1;
  const FileGrid qform{{6, 5, 4}, {{{2, 0, 0}, {0, 3, 0}, {0, 0, 4}}}, {10, 20, 30}};
  for (float& o : file.offset) o = 0;
  file.offset[0] = 10, file.offset[1] = 20, file.offset[2] = 30;
  file.pixdim[0] = 1, file.pixdim[1] = 2, file.pixdim[2] = 3, file.pixdim[3] = 4;
  for (const auto& [shift, warned] : {std::pair{0.05, false}, std::pair{0.15, true}}) {
    file.grid = qform;
    file.grid.origin.z += 4 * shift;
    const FileGrid grid = rounded(file.grid);
    const Volume volume = read(folder_.write("a.nii", file.header() + linear_voxels<float>(grid, ras_mm)));
    expect_linear(*volume.fields[0].field, grid, ras_mm);
    EXPECT_EQ(warns_of(volume, "sform and qform put a corner 0.15 voxels apart"), warned) << all_warnings(volume);
  }
  file.sform = 0;
  const Volume volume = read(folder_.write("a.nii", file.header() + linear_voxels<float>(qform, ras_mm)));
  expect_linear(*volume.fields[0].field, qform, ras_mm);
}

TEST_F(Nifti, ComponentsAlongTheGridTurnWithIt) {
  // Every voxel holds the first axis of the grid.
  File file;
  file.sform = 1, file.intent = 1007, file.dim = {5, 6, 5, 4, 1, 3};
  const std::string voxels =
      linear_voxels<float>(file.grid, [](const Vec3&) { return Vec3{}; }, false, {{}, 1}) + std::string(2 * 120 * 4, '\0');
  const fs::path path = folder_.write("a.nii", file.header() + voxels);
  VolumeRequest request;
  request.components_along = "index";
  const Vec3 at_m = ras_mm(rounded(file.grid).at({2, 2, 2}));
  const Vec3 along_i = ras_mm(rounded(file.grid).at({1, 0, 0})) - ras_mm(rounded(file.grid).at({0, 0, 0}));
  const Volume volume = read(path, request);
  EXPECT_LT(distance(volume.fields[0].field->vector(at_m).value, normalized(along_i)), 1e-6);
  EXPECT_FALSE(warns_of(volume, "right-handed"));
  EXPECT_LT(distance(read(path).fields[0].field->vector(at_m).value, {-1, 0, 0}), 1e-6);
  file.grid.step = file.grid.step * Mat3{{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  EXPECT_TRUE(warns_of(read(folder_.write("b.nii", file.header() + voxels), request), "right-handed"));
}

TEST_F(Nifti, FramesAreChosenOneByOne) {
  File file;
  file.sform = 1, file.datatype = 8, file.dim = {4, 6, 5, 4, 2};
  std::string voxels;
  for (int v = 0; v < 240; ++v) voxels += bytes_of(std::int32_t{v < 120 ? 5 : 9});
  const fs::path path = folder_.write("a.nii.gz", gzipped(file.header() + voxels));
  VolumeRequest request;
  request.frame = 1;
  EXPECT_EQ(read(path, request).fields[0].field->value_ranges()[0].min, 9.0);
  EXPECT_EQ(read(path).fields[0].field->value_ranges()[0].max, 5.0);
  request.frame = 2;
  EXPECT_NE(error_of([&] { read(path, request); }).find("not frame 2"), std::string::npos);
}

TEST_F(Nifti, HeaderAndImageInTwoFiles) {
  File file;
  file.sform = 1, file.pair = true;
  const FileGrid grid = rounded(file.grid);
  folder_.write("a.img", linear_voxels<float>(grid, ras_mm));
  const Volume volume = read(folder_.write("a.hdr", file.header().substr(0, 348)));
  expect_linear(*volume.fields[0].field, grid, ras_mm);
  EXPECT_EQ(volume.files.size(), 2U);
}

TEST_F(Nifti, OtherNumbersAreRefusedWithTheReason) {
  const auto refused = [&](std::int16_t datatype, std::int16_t bits) {
    File file;
    file.sform = 1, file.datatype = datatype, file.bits = bits;
    return error_of([&] { read(folder_.write("a.nii", file.header() + std::string(120 * 32, '\0'))); });
  };
  EXPECT_NE(refused(128, 24).find("colours (RGB)"), std::string::npos);
  EXPECT_NE(refused(2304, 32).find("colours (RGB)"), std::string::npos);
  EXPECT_NE(refused(32, 64).find("complex"), std::string::npos);
  EXPECT_NE(refused(1536, 128).find("data type 1536"), std::string::npos);
  EXPECT_NE(refused(1, 1).find("data type 1;"), std::string::npos);
}

TEST_F(Nifti, ShortDataAreNotFilledUp) {
  File file;
  file.sform = 1;
  const std::string voxels = linear_voxels<float>(file.grid, ras_mm);
  EXPECT_NE(error_of([&] { read(folder_.write("a.nii", file.header() + voxels.substr(0, 400))); }).find("whole"),
            std::string::npos);
  const std::string packed = gzipped(file.header() + voxels);
  EXPECT_NE(error_of([&] { read(folder_.write("a.nii.gz", packed.substr(0, packed.size() - 60))); }).find("a.nii.gz: "),
            std::string::npos);
  std::string wrong = packed;
  wrong[packed.size() - 6] ^= 1;
  error_of([&] { read(folder_.write("b.nii.gz", wrong)); });
  // Likewise with complete voxels before the end is read.
  file.dim = {3, 30, 30, 30};
  std::string hard_to_pack;
  for (std::uint32_t n = 0; n < 30 * 30 * 30; ++n) hard_to_pack += bytes_of(static_cast<float>(n * 2654435761U));
  std::string large = gzipped(file.header() + hard_to_pack);
  EXPECT_NO_THROW(read(folder_.write("c.nii.gz", large)));
  large[large.size() - 6] ^= 1;
  error_of([&] { read(folder_.write("d.nii.gz", large)); });
}

}  // namespace nifti_test
}  // namespace palpa::test
