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

TEST_F(Tiff, LargeStacksOfImageJLieBehindTheirOnlyListedImage) {
  for (const bool big_endian : {false, true})
    for (const auto& [bits, format] : {std::pair{8, 1}, {16, 1}, {32, 3}}) {
      TiffToWrite tiff{.images = 1, .bits = bits, .format = format, .big_endian = big_endian, .rows_per_strip = 5};
      tiff.description = "ImageJ=1.53t\nimages=4\nslices=4\n";
      expect_values(read(folder_.write("large.tif", tiff.bytes_of_unlisted(4))));
      if (HasFailure()) FAIL() << bits << " bits, big endian: " << big_endian;
    }
}

// A voxel behind 4 GiB, in a sparse file.
TEST_F(Tiff, OfMoreThanFourGigabytesImageJListsOneImage) {
  TiffToWrite tiff{.columns = 256, .rows = 256, .images = 1, .big_endian = true, .rows_per_strip = 256};
  tiff.description = "ImageJ=1.53t\nimages=33000\nslices=33000\n";
  const std::uint64_t image_bytes = 256 * 256 * 2, offset = 8;  // of the first voxel
  const fs::path file = folder_.write("large.tif", tiff.bytes());
  fs::resize_file(file, offset + 33000 * image_bytes);
  {
    std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
    out.seekp(static_cast<std::streamoff>(offset + 32999 * image_bytes + (3 * 256 + 5) * 2));
    out.write("\x12\x34", 2);
  }
  VolumeRequest request;
  request.files = {file};
  const auto sliced = open_sliced_file(request, options_);
  ASSERT_TRUE(sliced);
  EXPECT_EQ(sliced->fields.at(0).grid.dims, (std::array<std::int64_t, 3>{256, 256, 33000}));
  std::vector<std::uint16_t> row(256);
  sliced->read(0, {.first_slice = 32999, .first_row = 3}, reinterpret_cast<std::byte*>(row.data()));
  EXPECT_EQ(row[5], 0x1234);
  EXPECT_EQ(std::ranges::count(row, 0), 255);
}

TEST_F(Tiff, HyperstacksOfImageJAreFieldsAndFrames) {
  for (const bool is_listed : {true, false}) {
    TiffToWrite tiff{.images = 24, .rows_per_strip = 5};
    tiff.description = "ImageJ=1.53t\nimages=24\nchannels=2\nslices=4\nframes=3\nhyperstack=true\n";
    if (!is_listed) tiff.images = 1;
    const fs::path file = folder_.write("hyper.tif", is_listed ? tiff.bytes() : tiff.bytes_of_unlisted(24));
    for (int frame = 0; frame < 3; ++frame) {
      VolumeRequest request;
      request.frame = frame;
      const Volume volume = read(file, request);
      EXPECT_EQ(volume.frames, 3);
      ASSERT_EQ(volume.fields.size(), 2u);
      request.files = {file};
      const auto sliced = open_sliced_file(request, options_);
      ASSERT_TRUE(sliced && sliced->fields.size() == 2);
      for (std::int64_t channel = 0; channel < 2; ++channel) {
        const auto& field = volume.fields[static_cast<std::size_t>(channel)];
        EXPECT_EQ(field.name, "channel" + std::to_string(channel));
        const GridGeometry& grid = grid_of(*field.field)->geometry;
        ASSERT_EQ(grid.dims, (std::array<std::int64_t, 3>{6, 5, 4}));
        for (std::int64_t k = 0; k < 4; ++k)
          EXPECT_EQ(field.field->scalar(grid.to_world({4, 2, static_cast<double>(k)})).value,
                    static_cast<double>(TiffToWrite::value(4, 2, (frame * 4 + k) * 2 + channel)));
        std::uint16_t row[6] = {};
        sliced->read(static_cast<std::size_t>(channel), {.first_slice = 3, .first_row = 2}, reinterpret_cast<std::byte*>(row));
        EXPECT_EQ(row[4], TiffToWrite::value(4, 2, (frame * 4 + 3) * 2 + channel));
      }
    }
    EXPECT_TRUE(warns(read(file), "holds 3 frames"));
    VolumeRequest series;
    series.frame = VolumeRequest::all_frames;
    const FieldPtr moving = read(file, series).fields[1].field;
    const Vec3 at_m = moving->bounds_m().centre_m();
    const TimedField* const series_field = timed(*moving);
    ASSERT_TRUE(series_field);
    EXPECT_NEAR(series_field->scalar_at(at_m, {1.0}).value - series_field->scalar_at(at_m, {0.0}).value, 8 * 50, 1e-9);
  }
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
  expect(refusal({.description = "ImageJ=1\nimages=4\nchannels=3\n"}), "3 channels and 1 moments, which 4 images cannot be");
  expect(refusal({.description = "ImageJ=1\nimages=4\nchannels=1000000000\nframes=900000000\n"}), "4 images cannot be");
  expect(refusal({.description = "<OME><Pixels SizeC=\"2\" SizeT=\"1\"/></OME>"}), "2 channels");
  expect(refusal({.images = 1, .description = "ImageJ=1\nimages=900\nslices=900\n"}), "of 900 images");
  expect(refusal({.images = 1, .deflated = true, .description = "ImageJ=1\nimages=4\nslices=4\n"}), "lacks 3 of 4 images");
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
