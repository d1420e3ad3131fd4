// TIFF: files of one or several images, stacks, and rows of slices of all formats that read them alone.
#include <algorithm>
#include <fstream>

#include "files.h"
#include "palpa/file/sliced_file.h"
#include "sets_to_damage.h"
#include "tiff_writer.h"

namespace palpa::test {
namespace tiff_test {

class Tiff : public ReaderTest {
 protected:
  /// Voxels of a volume, which must be those of `TiffToWrite::value`.
  void expect_values(const Volume& volume, std::int64_t images = 4) const {
    const GridView& view = *grid_of(*volume.fields.at(0).field);
    ASSERT_EQ(view.geometry.dims, (std::array<std::int64_t, 3>{6, 5, images}));
    for (std::int64_t k = 0; k < images; ++k)
      for (std::int64_t j = 0; j < 5; ++j)
        for (std::int64_t i = 0; i < 6; ++i) {
          const Vec3 at_m = view.geometry.to_world({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
          ASSERT_NEAR(volume.fields[0].field->scalar(at_m).value, static_cast<double>(TiffToWrite::value(i, j, k)), 1e-6);
        }
  }
  bool warns(const Volume& volume, const std::string& words) const {
    return std::ranges::any_of(volume.warnings, [&](const std::string& w) { return w.find(words) != std::string::npos; });
  }
  std::string refusal(const TiffToWrite& tiff) {
    const fs::path file = folder_.write("refused.tif", tiff.bytes());
    return error_of([&] { read(file); });
  }
};

TEST_F(Tiff, EveryLayoutHasTheSameVoxels) {
  int number = 0;
  for (const bool is_bigtiff : {false, true})
    for (const bool big_endian : {false, true})
      for (const bool deflated : {false, true})
        for (const std::int64_t tile : {0, 16})
          for (const auto& [bits, format] : {std::pair{8, 1}, {16, 1}, {16, 2}, {32, 1}, {32, 2}, {32, 3}, {64, 3}}) {
            TiffToWrite tiff{.bits = bits, .format = format, .is_bigtiff = is_bigtiff, .big_endian = big_endian};
            tiff.deflated = deflated, tiff.tile = tile, tiff.rows_per_strip = 1 + number % 6;
            const fs::path file = folder_.write("a" + std::to_string(number++) + ".tif", tiff.bytes());
            expect_values(read(file));
            if (HasFailure()) FAIL() << file;
          }
}

TEST_F(Tiff, StacksAreInTheOrderOfTheirNumbers) {
  const fs::path stack = folder_.path() / "stack";
  write_tiff_stack(stack, {}, folder_);
  const Volume volume = read(stack);
  expect_values(volume);
  EXPECT_EQ(volume.files.size(), 4u);
  EXPECT_FALSE(warns(volume, "lacks"));
  fs::remove(stack / "slice10.tif");
  EXPECT_TRUE(warns(read(stack), "lacks 1 slice behind 'slice9.tif'"));
  fs::copy(stack / "slice11.tif", stack / "slice011.tif");
  EXPECT_TRUE(warns(read(stack), "of the same number"));
  fs::copy(stack / "slice11.tif", stack / "other.tif");
  EXPECT_TRUE(warns(read(stack), "several sequences"));
  folder_.write("stack/notes.txt", "text");
  EXPECT_EQ(grid_of(*read(stack).fields[0].field)->geometry.dims[2], 5);
}

TEST_F(Tiff, SpacingIsFromResolutionTextOrRequest) {
  TiffToWrite tiff{.pixels_per_cm = 2000};
  const auto spacing_um = [&](VolumeRequest request = {}) {
    const Volume volume = read(folder_.write("s.tif", tiff.bytes()), std::move(request));
    const Mat3& m = grid_of(*volume.fields[0].field)->geometry.index_to_world_m;
    return std::pair(Vec3{1e6 * m.row[0].x, 1e6 * m.row[1].y, 1e6 * m.row[2].z}, warns(volume, "no distance of its slices"));
  };
  const auto expect = [&](const std::pair<Vec3, bool>& found, const Vec3& um, bool warned) {
    EXPECT_NEAR(distance(found.first, um), 0.0, 1e-6 * norm(um));
    EXPECT_EQ(found.second, warned);
  };
  expect(spacing_um(), {5, 5, 5}, true);
  VolumeRequest asked;
  asked.layout.spacing_m = {1e-6, 2e-6, 3e-6};
  expect(spacing_um(asked), {1, 2, 3}, false);
  tiff.description = "ImageJ=1.53t\nimages=4\nslices=4\nunit=micron\nspacing=2.5\n";
  tiff.pixels_per_cm = 0.5;  // of the text's unit
  expect(spacing_um(), {2, 2, 2.5}, false);
  tiff.description =
      "<?xml version=\"1.0\"?><OME><Image><Pixels SizeC=\"1\" SizeT=\"1\" PhysicalSizeX=\"0.5\" PhysicalSizeY=\"0.5\" "
      "PhysicalSizeZ=\"2\"/></Image></OME>";
  expect(spacing_um(), {0.5, 0.5, 2}, false);
}

TEST_F(Tiff, WrongFilesAreOneLine) {
  const auto expect = [&](const std::string& line, const std::string& words) {
    EXPECT_NE(line.find(words), std::string::npos) << line;
  };
  expect(refusal({.also = {{277, 3}, {262, 2}}}), "colours");
  expect(refusal({.also = {{258, 12}}}), "12 bits");
  expect(refusal({.also = {{258, 16}, {339, 3}}}), "with fractions");
  expect(refusal({.also = {{256, 4'000'000'000}}}), "4000000000");
  expect(refusal({.also = {{256, 200'000}, {257, 200'000}}}), "; ");
  expect(refusal({.also = {{257, 0}}}), "; ");
  expect(refusal({.also = {{259, 34712}}}), "compressed by a method");
  expect(refusal({.tile = 16, .also = {{322, 1 << 17}, {323, 1 << 17}}}), "; ");
  expect(refusal({.description = "ImageJ=1\nimages=4\nchannels=2\n"}), "2 channels");
  expect(refusal({.images = 1, .description = "ImageJ=1\nimages=900\nslices=900\n"}),
         "--set dims=[6,5,900] --set header_bytes=8");
  const std::string whole = TiffToWrite{}.bytes();
  for (std::size_t bytes = 1; bytes < whole.size(); bytes += 7) {
    const fs::path file = folder_.write("cut.tif", whole.substr(0, bytes));
    SCOPED_TRACE(std::to_string(bytes) + " of " + std::to_string(whole.size()));
    error_of([&] { read(file); });
  }
  const fs::path stack = folder_.path() / "stack";
  write_tiff_stack(stack, {}, folder_);
  folder_.write("stack/slice9.tif", TiffToWrite{.columns = 7, .images = 1}.bytes());
  expect(error_of([&] { read(stack); }), "'slice9.tif' that has 7 × 5 pixels where the first slice has 6 × 5");
  folder_.write("stack/slice9.tif", TiffToWrite{.images = 1, .bits = 8}.bytes());
  expect(error_of([&] { read(stack); }), "another type");
  folder_.write("stack/slice9.tif", "no image");
  expect(error_of([&] { read(stack); }), "'slice9.tif' that cannot be read as TIFF");
  VolumeRequest shaped;
  shaped.layout.dims = {6, 5, 4};
  expect(error_of([&] { read(stack, shaped); }), "its own shape");
  expect(error_of([&] { read(folder_.write("text.tif", "text")); }), "is no TIFF file");
}

/// Rows of slices in uneven pieces are the voxels of the whole volume.
class Rows : public ReaderTest, public ::testing::WithParamInterface<SetToDamage> {};

TEST_P(Rows, AreThoseOfTheWholeVolume) {
  const SetToDamage& set = GetParam();
  const fs::path original = set.original(folder_);
  if (!fs::exists(original) || set.chunks || !set.frames.empty()) GTEST_SKIP() << "no volume of its own";
  VolumeRequest request = set.request;
  request.files = {original};
  std::unique_ptr<SlicedFile> file;
  try {
    file = open_sliced_file(request, options_);
  } catch (const LoadError&) {
    EXPECT_THROW(read_volume(request, options_), LoadError);  // a set to be refused
  }
  if (!file) GTEST_SKIP() << "is read as a whole";
  const Volume whole = read_volume(request, options_);
  ASSERT_EQ(file->fields.size(), whole.fields.size());
  EXPECT_EQ(file->volume.medical_frame, whole.medical_frame);
  for (std::size_t f = 0; f < whole.fields.size(); ++f) {
    const GridView& view = *grid_of(*whole.fields[f].field);
    const SlicedFile::Field& field = file->fields[f];
    EXPECT_EQ(field.name, whole.fields[f].name);
    EXPECT_EQ(field.grid, view.geometry);
    ASSERT_EQ(field.type, view.voxels.type);
    ASSERT_EQ(field.components, view.voxels.components);
    EXPECT_EQ(field.scale, view.scale);
    const auto& n = field.grid.dims;
    const std::size_t row = static_cast<std::size_t>(n[0] * field.components) * size_of(field.type);
    for (const SliceRows& part : {SliceRows{0, n[2], 0, n[1]}, SliceRows{n[2] / 2, 1, n[1] / 3, 1},
                                  SliceRows{n[2] / 3, n[2] - n[2] / 3, n[1] / 2, n[1] - n[1] / 2}}) {
      std::vector<std::byte> rows(static_cast<std::size_t>(part.slices * part.rows) * row);
      file->read(f, part, rows.data());
      for (std::int64_t k = 0; k < part.slices; ++k) {
        const std::byte* const expected = static_cast<const std::byte*>(view.voxels.data.get()) +
                                          static_cast<std::size_t>((part.first_slice + k) * n[1] + part.first_row) * row;
        const std::size_t bytes = static_cast<std::size_t>(part.rows) * row;
        ASSERT_EQ(std::memcmp(rows.data() + static_cast<std::size_t>(k) * bytes, expected, bytes), 0) << "slice " << k;
      }
    }
  }
}

std::string test_name(const ::testing::TestParamInfo<SetToDamage>& set) {
  std::string name = set.param.name;
  std::ranges::replace_if(name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Files, Rows, ::testing::ValuesIn(sets_to_damage(shared_file("facts.json").parent_path())), test_name);

}  // namespace tiff_test
}  // namespace palpa::test
