// Written NRRD and VTI, read back by ITK and VTK, are equal.
#include "palpa/file/convert.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <random>

#include "data_sets.h"
#include "files.h"
#include "palpa/data/volume.h"

namespace palpa::test {
namespace convert_test {

class Convert : public ReaderTest {
 protected:
  Volume converted(const Volume& volume, const std::string& name, const ConvertOptions& options = {},
                   VolumeRequest request = {}) {
    lost_ = convert(volume, folder_.path() / name, options);
    return read(folder_.path() / name, std::move(request));
  }
  /// The folder holds only the named files.
  void expect_files(std::vector<std::string> names) {
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder_.path())) found.push_back(entry.path().filename().string());
    std::sort(found.begin(), found.end()), std::sort(names.begin(), names.end());
    EXPECT_EQ(found, names);
  }
  std::vector<std::string> lost_;
};

/// Expects equal values all over the first box and, if the second is no larger, an equal outside.
void expect_same(const Field& a, const Field& b, double tolerance, bool larger = false) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  const Box box = a.bounds_m();
  const Vec3 size_m = box.size_m();
  const double mm = 1e-9 * largest_component(size_m);
  ASSERT_EQ(a.components(), b.components());
  for (int n = 0; n < 500; ++n) {
    const Vec3 x = box.low_m + Vec3{part(random) * size_m.x, part(random) * size_m.y, part(random) * size_m.z};
    if (std::abs(a.depth_m(x)) < mm) continue;
    if (a.components() == 1) {
      const ScalarSample s = a.scalar(x), t = b.scalar(x);
      if (larger && !s.inside) continue;
      ASSERT_EQ(s.inside, t.inside);
      ASSERT_NEAR(s.value, t.value, tolerance);
    } else {
      const VectorSample s = a.vector(x), t = b.vector(x);
      ASSERT_EQ(s.inside, t.inside);
      ASSERT_LT(distance(s.value, t.value), tolerance);
    }
  }
}

double span_of(const Field& field) {
  double span = 0.0;
  for (const ValueRange& extent : field.value_ranges()) span = std::max(span, extent.max - extent.min);
  return span;
}

Volume made(VoxelType type, const std::shared_ptr<const void>& data, int components, double scale = 1.0, double offset = 0.0) {
  const FileGrid grid = sheared_grid();
  Volume volume;
  volume.fields = {{"made", "HU",
                    grid_field({{grid.dims[0], grid.dims[1], grid.dims[2]}, 1e-3 * grid.step, 1e-3 * grid.origin},
                               {type, components, data}, scale, offset)}};
  volume.medical_frame = true;
  volume.length_unit = "mm";
  return volume;
}

TEST_F(Convert, KeepsShearedGridsTypesAndUnits) {
  const auto raw = std::make_shared<std::vector<std::int16_t>>(120);
  std::mt19937 random(2);
  for (auto& v : *raw) v = static_cast<std::int16_t>(random());
  const Volume volume = made(VoxelType::int16, {raw, raw->data()}, 1);
  for (const char* name : {"a.nrrd", "b.nhdr"}) {
    const Volume again = converted(volume, name);
    EXPECT_TRUE(again.medical_frame);
    EXPECT_EQ(again.fields[0].unit, "HU");
    EXPECT_FALSE(again.length_unit_assumed);
    EXPECT_EQ(grid_of(*again.fields[0].field)->voxels.type, VoxelType::int16);
    EXPECT_EQ(std::memcmp(grid_of(*again.fields[0].field)->voxels.data.get(), raw->data(), 240), 0);
    expect_same(*volume.fields[0].field, *again.fields[0].field, 1e-6);
  }
  expect_files({"a.nrrd", "b.nhdr", "b.raw"});
  EXPECT_NE(error_of([&] { converted(volume, "c.vti"); }).find("--resample-m"), std::string::npos);
  expect_files({"a.nrrd", "b.nhdr", "b.raw"});
}

TEST_F(Convert, KeepsVectorsAlongTheWorld) {
  const auto raw = std::make_shared<std::vector<float>>(360);
  std::mt19937 random(2);
  for (auto& v : *raw) v = std::normal_distribution<float>(0, 3)(random);
  const Volume volume = made(VoxelType::float32, {raw, raw->data()}, 3);
  expect_same(*volume.fields[0].field, *converted(volume, "v.nrrd").fields[0].field, 1e-6);
}

TEST_F(Convert, NiftiKeepsShearedGridsTypesAndVectors) {
  std::mt19937 random(2);
  const auto numbers = [&](auto number, std::size_t count) {
    using Number = decltype(number);
    auto raw = std::make_shared<std::vector<Number>>(count);
    for (auto& v : *raw) v = static_cast<Number>(random() % 251);
    return raw;
  };
  const auto expect_kept = [&](const Volume& volume, VoxelType kept) {
    const Volume again = converted(volume, "n" + std::to_string(random()) + ".nii");
    ASSERT_EQ(again.fields.size(), 1U);
    EXPECT_TRUE(again.medical_frame);
    EXPECT_EQ(again.length_unit, "mm");
    EXPECT_FALSE(again.length_unit_assumed);
    const GridView &before = *grid_of(*volume.fields[0].field), &after = *grid_of(*again.fields[0].field);
    EXPECT_EQ(after.voxels.type, kept);
    EXPECT_EQ(after.geometry.dims, before.geometry.dims);
    // The standard keeps the affine as float32.
    const double rounded_m = 1e-6 * (largest_component(before.geometry.origin_m) + norm(volume.bounds_m().size_m()));
    for (const GridPoint corner : {GridPoint{0, 0, 0}, {3, 0, 0}, {0, 4, 0}, {0, 0, 2}})
      EXPECT_LT(distance(after.geometry.to_world(corner), before.geometry.to_world(corner)), rounded_m);
    const std::int64_t count = before.geometry.voxels();
    for (std::int64_t n = 0; n < count; ++n) {
      const auto i = static_cast<double>(n % before.geometry.dims[0]),
                 j = static_cast<double>(n / before.geometry.dims[0] % before.geometry.dims[1]),
                 k = static_cast<double>(n / (before.geometry.dims[0] * before.geometry.dims[1]));
      const Vec3 a =
          0.998 * (before.geometry.to_world({i, j, k}) - volume.bounds_m().centre_m()) + volume.bounds_m().centre_m();
      const Field &first = *volume.fields[0].field, &second = *again.fields[0].field;
      if (first.components() == 1) {
        EXPECT_NEAR(second.scalar(a).value, first.scalar(a).value, 1e-2);
      } else {
        EXPECT_LT(distance(second.vector(a).value, first.vector(a).value), 1e-2);
      }
    }
  };
  const auto bytes = numbers(std::uint8_t{}, 120);
  expect_kept(made(VoxelType::uint8, {bytes, bytes->data()}, 1), VoxelType::uint8);
  const auto words = numbers(std::uint16_t{}, 120);
  expect_kept(made(VoxelType::uint16, {words, words->data()}, 1), VoxelType::uint16);
  const auto doubles = numbers(double{}, 120);
  expect_kept(made(VoxelType::float64, {doubles, doubles->data()}, 1), VoxelType::float64);
  const auto vectors = numbers(float{}, 360);
  expect_kept(made(VoxelType::float32, {vectors, vectors->data()}, 3), VoxelType::float32);
  const auto whole_vectors = numbers(std::uint8_t{}, 360);
  expect_kept(made(VoxelType::uint8, {whole_vectors, whole_vectors->data()}, 3), VoxelType::float32);
  EXPECT_EQ(lost_.size(), 1U) << "the unit";
}

TEST_F(Convert, PackedNiftiHasTheBytesOfNifti) {
  // More than zlib's output of one call, and numbers that can be packed and that cannot.
  const GridGeometry grid{{90, 80, 70}, 1e-3 * Mat3::identity(), {}};
  const auto content = [](const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  std::mt19937 random(2);
  for (const bool is_noise : {false, true}) {
    const auto raw = std::make_shared<std::vector<std::int16_t>>(90 * 80 * 70);
    for (auto& v : *raw) v = is_noise ? static_cast<std::int16_t>(random()) : std::int16_t{7};
    Volume volume;
    volume.medical_frame = true, volume.length_unit = "mm";
    volume.fields = {{"made", "", grid_field(grid, {VoxelType::int16, 1, {raw, raw->data()}})}};
    const fs::path plain = folder_.path() / (is_noise ? "n.nii" : "c.nii"), packed = plain.string() + ".gz";
    convert(volume, plain);
    convert(volume, packed);
    const std::string bytes = content(packed);
    EXPECT_EQ(gunzipped(bytes), content(plain));
    EXPECT_EQ(bytes.substr(4, 4), std::string(4, '\0')) << "no time: the same data give the same file";
    if (!is_noise) {
      EXPECT_LT(bytes.size(), fs::file_size(plain) / 100);
    }
    const Volume again = read(packed);
    EXPECT_EQ(std::memcmp(grid_of(*again.fields[0].field)->voxels.data.get(), raw->data(), 2 * raw->size()), 0);
  }
  expect_files({"c.nii", "c.nii.gz", "n.nii", "n.nii.gz"});
}

TEST_F(Convert, NiftiSaysWhatItCannotHold) {
  const auto raw = std::make_shared<std::vector<float>>(120, 1.0F);
  Volume volume = made(VoxelType::float32, {raw, raw->data()}, 1);
  volume.medical_frame = false;
  converted(volume, "a.nii");
  ASSERT_EQ(lost_.size(), 2U);
  EXPECT_NE(lost_[0].find("medical frames only"), std::string::npos);
  EXPECT_NE(lost_[1].find("'made' is in HU"), std::string::npos);
  EXPECT_NE(error_of([&] { converted(volume, "a.nii"); }).find("a.nii"), std::string::npos) << "nothing is overwritten";
  volume.fields.push_back(volume.fields[0]), volume.fields[1].name = "other";
  EXPECT_NE(error_of([&] { converted(volume, "b.nii"); }).find("NIfTI holds one"), std::string::npos);
  const auto many = std::make_shared<std::vector<std::uint8_t>>(4 * 40'000);
  volume.fields = {
      {"long", "", grid_field({{40'000, 2, 2}, 1e-3 * Mat3::identity(), {}}, {VoxelType::uint8, 1, {many, many->data()}})}};
  EXPECT_NE(error_of([&] { converted(volume, "c.nii"); }).find("32767"), std::string::npos);
  expect_files({"a.nii"});
}

TEST_F(Convert, VtiHasItsVoxelsWithinTheText) {
  // ParaView 5.11 cannot open files with padding at the end. Byte counts with and without a factor of three.
  for (const std::int64_t length : {1, 2, 3, 4, 5}) {
    const GridGeometry grid{{length, 3, 2}, 1e-3 * Mat3::identity(), {}};
    Volume volume;
    const auto add = [&](const char* name, VoxelType type, int components, auto number) {
      using Number = decltype(number);
      const auto raw = std::make_shared<std::vector<Number>>();
      for (std::int64_t n = 0; n < 6 * length * components; ++n) raw->push_back(static_cast<Number>(17 * n % 251));
      volume.fields.push_back({name, "", grid_field(grid, {type, components, {raw, raw->data()}})});
    };
    add("a", VoxelType::uint8, 1, std::uint8_t{});
    add("b", VoxelType::int16, 1, std::int16_t{});
    add("c", VoxelType::float32, 3, float{});
    add("d", VoxelType::float64, 1, double{});
    add("e", VoxelType::int16, 3, std::int16_t{});
    const std::string name = "v" + std::to_string(length) + ".vti";
    const Volume again = converted(volume, name);
    ASSERT_EQ(again.fields.size(), volume.fields.size());
    for (std::size_t f = 0; f < volume.fields.size(); ++f) {
      const Voxels &before = grid_of(*volume.fields[f].field)->voxels, &after = grid_of(*again.fields[f].field)->voxels;
      ASSERT_EQ(after.type, before.type);
      const std::size_t bytes = static_cast<std::size_t>(6 * length * before.components) * size_of(before.type);
      EXPECT_EQ(std::memcmp(before.data.get(), after.data.get(), bytes), 0) << volume.fields[f].name;
    }
    std::ifstream file(folder_.path() / name);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    EXPECT_EQ(text.find("ppended"), std::string::npos);
    EXPECT_NE(text.find("format=\"binary\""), std::string::npos);
    EXPECT_TRUE(std::ranges::all_of(text, [](char c) { return c == '\n' || (c >= ' ' && c <= '~'); }));
  }
}

TEST_F(Convert, PutsScaleIntoTheNumbers) {
  const auto raw = std::make_shared<std::vector<std::uint16_t>>(120);
  for (std::size_t n = 0; n < 120; ++n) (*raw)[n] = static_cast<std::uint16_t>(500 * n);
  const Volume whole = made(VoxelType::uint16, {raw, raw->data()}, 1, 1.0, -1024.0);
  const Volume again = converted(whole, "whole.nrrd");
  EXPECT_EQ(grid_of(*again.fields[0].field)->voxels.type, VoxelType::int32);
  expect_same(*whole.fields[0].field, *again.fields[0].field, 1e-6);
  const Volume parts = made(VoxelType::uint16, {raw, raw->data()}, 1, 0.1, 0.0);
  expect_same(*parts.fields[0].field, *converted(parts, "parts.nrrd").fields[0].field, 1e-3);
}

TEST_F(Convert, CropsAndAverages) {
  const auto raw = std::make_shared<std::vector<float>>();
  for (std::int64_t k = 0; k < 4; ++k)
    for (std::int64_t j = 0; j < 5; ++j)
      for (std::int64_t i = 0; i < 6; ++i) raw->push_back(static_cast<float>(2 * i - 3 * j + 7 * k));
  const Volume volume = made(VoxelType::float32, {raw, raw->data()}, 1);
  const Field& field = *volume.fields[0].field;
  const Volume part = converted(volume, "part.nrrd", {.crop = VoxelRange{{1, 2, 1}, {4, 4, 3}}});
  EXPECT_EQ(grid_of(*part.fields[0].field)->geometry.dims, (std::array<std::int64_t, 3>{4, 3, 3}));
  expect_same(*part.fields[0].field, field, 1e-5, true);
  // A block mean of a linear function is its value at the block's middle.
  const Volume half = converted(volume, "half.nrrd", {.downsample = 2});
  EXPECT_EQ(grid_of(*half.fields[0].field)->geometry.dims, (std::array<std::int64_t, 3>{3, 2, 2}));
  expect_same(*half.fields[0].field, field, 1e-4, true);
  const Volume both = converted(volume, "both.nrrd", {.crop = VoxelRange{{0, 0, 0}, {3, 3, 3}}, .downsample = 2});
  expect_same(*both.fields[0].field, field, 1e-4, true);
  error_of([&] { converted(volume, "x.nrrd", {.crop = VoxelRange{{0, 0, 0}, {6, 4, 3}}}); });
  error_of([&] { converted(volume, "x.nrrd", {.crop = VoxelRange{{3, 0, 0}, {2, 4, 3}}}); });
  expect_files({"part.nrrd", "half.nrrd", "both.nrrd"});
}

TEST_F(Convert, ResamplesAlongTheWorld) {
  const auto raw = std::make_shared<std::vector<float>>();
  const FileGrid grid = sheared_grid();
  const Linear linear;
  for (std::int64_t k = 0; k < 4; ++k)
    for (std::int64_t j = 0; j < 5; ++j)
      for (std::int64_t i = 0; i < 6; ++i)
        raw->push_back(static_cast<float>(linear(1e-3 * grid.at({double(i), double(j), double(k)}))));
  const Volume volume = made(VoxelType::float32, {raw, raw->data()}, 1);
  for (const char* name : {"r.nrrd", "r.vti"}) {
    const Volume upright = converted(volume, name, {.resample_m = 0.5e-3});
    const Field& field = *upright.fields[0].field;
    const Mat3& steps = grid_of(field)->geometry.index_to_world_m;
    EXPECT_NEAR(steps.row[0].x, 0.5e-3, 1e-12);
    EXPECT_NEAR(steps.row[1].x, 0.0, 1e-15);
    int inside = 0;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> part(0.0, 1.0);
    for (int n = 0; n < 2000; ++n) {
      const Box box = field.bounds_m();
      const Vec3 size_m = box.size_m();
      const Vec3 x = box.low_m + Vec3{part(random) * size_m.x, part(random) * size_m.y, part(random) * size_m.z};
      const ScalarSample s = field.scalar(x);
      if (!s.inside) continue;
      ++inside;
      EXPECT_NEAR(s.value, linear(x), 1e-4);
    }
    EXPECT_GT(inside, 200);
  }
}

TEST_F(Convert, ResamplesGridsOfUnevenPlanes) {
  const GridGeometry uneven = rectilinear_geometry({{{0, 1e-3, 3e-3, 4e-3}, {0, 2e-3, 3e-3}, {-1e-3, 0, 4e-3, 5e-3}}});
  ASSERT_TRUE(uneven.is_rectilinear());
  const Linear linear;
  const auto raw = std::make_shared<std::vector<float>>();
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 4; ++i)
        raw->push_back(static_cast<float>(linear(uneven.to_world({double(i), double(j), double(k)}))));
  Volume volume;
  volume.fields = {{"made", "", grid_field(uneven, {VoxelType::float32, 1, {raw, raw->data()}})}};
  error_of([&] { converted(volume, "x.nrrd"); });
  error_of([&] { converted(volume, "x.nrrd", {.crop = VoxelRange{{0, 0, 0}, {1, 1, 1}}, .resample_m = 0.5e-3}); });
  for (const char* name : {"u.nrrd", "u.vti"}) {
    const Volume even = converted(volume, name, {.resample_m = 0.5e-3});
    EXPECT_EQ(grid_of(*even.fields[0].field)->geometry.dims, (std::array<std::int64_t, 3>{9, 7, 13}));
    expect_same(*even.fields[0].field, *volume.fields[0].field, 1e-4);
  }
}

TEST_F(Convert, KeepsHolesInVectorsThatAreCroppedAveragedAndResampled) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const auto value = [](const Vec3& x) { return Vec3{x.x - 2.0 * x.y, 3.0 * x.z, x.x + x.y + x.z}; };
  const GridGeometry grid{{16, 14, 12}, 1e-3 * Mat3::identity(), {1e-3, 2e-3, 3e-3}};
  const auto hole = [](int i, int j, int k) { return i >= 6 && i < 10 && j >= 4 && j < 10 && k >= 4 && k < 8; };
  const auto raw = std::make_shared<std::vector<float>>();
  for (int k = 0; k < 12; ++k)
    for (int j = 0; j < 14; ++j)
      for (int i = 0; i < 16; ++i) {
        const Vec3 v = 1e3 * value(grid.to_world({double(i), double(j), double(k)}));
        for (const double part : {v.x, v.y, v.z}) raw->push_back(hole(i, j, k) ? nan : static_cast<float>(part));
      }
  Volume volume;
  volume.fields = {{"flow", "", grid_field(grid, {VoxelType::float32, 3, {raw, raw->data()}})}};
  const ConvertOptions all{.crop = VoxelRange{{2, 2, 2}, {15, 13, 11}}, .downsample = 2, .resample_m = 0.7e-3};
  for (const char* name : {"h.nrrd", "h.vti"}) {
    const Volume again = converted(volume, name, all);
    const Field& made = *again.fields[0].field;
    int inside = 0, holes = 0;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> part(0.0, 1.0);
    for (int n = 0; n < 2000; ++n) {
      const Box box = made.bounds_m();
      const Vec3 size_m = box.size_m();
      const Vec3 x = box.low_m + Vec3{part(random) * size_m.x, part(random) * size_m.y, part(random) * size_m.z};
      const VectorSample s = made.vector(x);
      if (!s.inside) {
        ++holes;
        continue;
      }
      ++inside;
      EXPECT_LT(distance(s.value, 1e3 * value(x)), 1e-3);
      EXPECT_TRUE(volume.fields[0].field->vector(x).inside);
    }
    EXPECT_GT(inside, 500);
    EXPECT_GT(holes, 100);
  }
  error_of([&] { converted(volume, "x.nrrd", {.int16 = true}); });
}

TEST_F(Convert, WritesTheFrameThatIsAskedFor) {
  const fs::path data = shared_file("mri_epi_4d/example4d.nii.gz");
  if (data.empty()) GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
  VolumeRequest request;
  request.frame = 1;
  const Volume second = read(data, request), first = read(data);
  const Volume again = converted(second, "second.nrrd");
  ASSERT_EQ(lost_.size(), 1U);
  EXPECT_NE(lost_[0].find("one of 2 frames"), std::string::npos);
  const auto voxels = [](const Volume& v) { return grid_of(*v.fields[0].field)->voxels.data.get(); };
  const std::size_t bytes = 2U * 128 * 96 * 24;
  EXPECT_EQ(std::memcmp(voxels(again), voxels(second), bytes), 0);
  EXPECT_NE(std::memcmp(voxels(first), voxels(second), bytes), 0);
}

TEST_F(Convert, RoundsTo16BitsOrSaysWhyNot) {
  const auto raw = std::make_shared<std::vector<float>>(120);
  for (std::size_t n = 0; n < 120; ++n) (*raw)[n] = static_cast<float>(11.37 * static_cast<double>(n) - 400.0);
  const Volume volume = made(VoxelType::float32, {raw, raw->data()}, 1);
  const Volume whole = converted(volume, "w.nrrd", {.int16 = true});
  EXPECT_EQ(grid_of(*whole.fields[0].field)->voxels.type, VoxelType::int16);
  expect_same(*volume.fields[0].field, *whole.fields[0].field, 0.51);
  for (std::size_t n = 0; n < 120; ++n) (*raw)[n] = static_cast<float>(n) * 1e-3F;
  EXPECT_NE(error_of([&] {
              converted(made(VoxelType::float32, {raw, raw->data()}, 1), "x.nrrd", {.int16 = true});
            }).find("256"),
            std::string::npos);
  for (std::size_t n = 0; n < 120; ++n) (*raw)[n] = static_cast<float>(n) * 1e4F;
  error_of([&] { converted(made(VoxelType::float32, {raw, raw->data()}, 1), "x.nrrd", {.int16 = true}); });
}

TEST_F(Convert, NeverWritesOverAFileAndLeavesNothingHalf) {
  const auto raw = std::make_shared<std::vector<float>>(120, 1.0F);
  const Volume volume = made(VoxelType::float32, {raw, raw->data()}, 1);
  folder_.write("there.nrrd", "mine");
  EXPECT_NE(error_of([&] { convert(volume, folder_.path() / "there.nrrd"); }).find("exists already"), std::string::npos);
  EXPECT_NE(error_of([&] { convert(volume, folder_.path() / "a.png"); }).find(".nrrd"), std::string::npos);
  error_of([&] { convert(volume, folder_.path() / "none" / "a.nrrd"); });
  ConvertOptions stopped;
  stopped.progress = [](double share) {
    if (share > 0.4) throw LoadError("interrupted; try again");
  };
  for (const char* name : {"a.nrrd", "a.nhdr", "a.nii.gz"}) error_of([&] { convert(volume, folder_.path() / name, stopped); });
  // About 10^15 voxels: more than any disk has.
  error_of([&] { convert(volume, folder_.path() / "big.nrrd", {.resample_m = 2e-7}); });
  expect_files({"there.nrrd"});
}

TEST_F(Convert, AnEndingThatIsNotWrittenIsSaidBeforeHowManyFieldsThereAre) {
  const std::string array = "SCALARS s float\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8\n";
  std::string text =
      "# vtk DataFile Version 3.0\nmade\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nPOINT_DATA 8\n" + array;
  std::string second = array;
  const Volume volume = read(folder_.write("a.vtk", text + second.replace(8, 1, "t")));
  ASSERT_EQ(volume.fields.size(), 2U);
  const auto error = [&](const char* name) { return error_of([&] { convert(volume, folder_.path() / name); }); };
  for (const char* name : {"a.mhd", "a"})
    EXPECT_NE(error(name).find("ending of no format that is written"), std::string::npos) << error(name);
  EXPECT_NE(error("a.nrrd.gz").find("name it .nrrd"), std::string::npos) << error("a.nrrd.gz");
  for (const char* name : {"a.nrrd", "a.nii", "a.nii.gz"})
    EXPECT_NE(error(name).find("several fields ('s', 't')"), std::string::npos) << error(name);
}

class RoundTrips : public Convert, public ::testing::WithParamInterface<DataSet> {};

TEST_P(RoundTrips, ChangeNothing) {
  const fs::path data = shared_file(GetParam().file);
  if (data.empty()) GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
  const Volume volume = read(data);
  for (std::size_t f = 0; f < volume.fields.size(); ++f) {
    const VolumeField& field = volume.fields[f];
    ASSERT_TRUE(grid_of(*field.field));
    SCOPED_TRACE(field.name);
    if (grid_of(*field.field)->geometry.is_rectilinear()) {
      const std::string text = error_of([&] { convert(volume, folder_.path() / "a.vti"); });
      EXPECT_NE(text.find("uneven distances"), std::string::npos) << text;
      return;
    }
    const Volume again = converted(volume, "f" + std::to_string(f) + ".nrrd", {.field = field.name});
    EXPECT_EQ(again.medical_frame, volume.medical_frame);
    EXPECT_FALSE(again.length_unit_assumed);
    const GridGeometry &before = grid_of(*field.field)->geometry, &after = grid_of(*again.fields[0].field)->geometry;
    EXPECT_EQ(before.dims, after.dims);
    expect_same(*field.field, *again.fields[0].field, 1e-5 * span_of(*field.field));
    const auto value_ranges = field.field->value_ranges(), kept = again.fields[0].field->value_ranges();
    for (std::size_t c = 0; c < value_ranges.size(); ++c) {
      EXPECT_FLOAT_EQ(static_cast<float>(value_ranges[c].min), static_cast<float>(kept[c].min));
      EXPECT_FLOAT_EQ(static_cast<float>(value_ranges[c].max), static_cast<float>(kept[c].max));
    }
  }
  const Volume vti = converted(volume, "all.vti");
  ASSERT_EQ(vti.fields.size() + lost_.size() >= volume.fields.size(), true);
  expect_same(*volume.fields[0].field, *vti.fields[0].field, 1e-5 * span_of(*volume.fields[0].field));
}

INSTANTIATE_TEST_SUITE_P(Sets, RoundTrips, ::testing::ValuesIn(data_sets()),
                         [](const auto& set) { return name_of(set.param); });

}  // namespace convert_test
}  // namespace palpa::test
