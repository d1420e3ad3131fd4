// Voxels that lie in a file as bare numbers are read in pieces by several threads: they are those of the same file packed,
// which a library reads in one.
#include "files.h"
#include "palpa/data/timed_field.h"

namespace palpa::test {
namespace raw_rows_test {

class RawRows : public ReaderTest {
 protected:
  /// Expects equal voxels and facts of two files, in every frame.
  void expect_same(const fs::path& bare, const fs::path& packed, VolumeRequest request = {}) const {
    SCOPED_TRACE(bare);
    request.frame = VolumeRequest::all_frames;
    const Volume one = read(bare, request), other = read(packed, request);
    ASSERT_EQ(one.fields.size(), other.fields.size());
    EXPECT_EQ(one.warnings, other.warnings);
    for (std::size_t f = 0; f < one.fields.size(); ++f) {
      const std::vector<FieldPtr> frames = frames_of(one.fields[f].field), same = frames_of(other.fields[f].field);
      ASSERT_EQ(frames.size(), same.size());
      for (std::size_t n = 0; n < frames.size(); ++n) {
        const GridView &a = *grid_of(*frames[n]), &b = *grid_of(*same[n]);
        EXPECT_EQ(a.geometry, b.geometry);
        ASSERT_EQ(a.voxels.type, b.voxels.type);
        ASSERT_EQ(a.voxels.components, b.voxels.components);
        const std::size_t bytes = static_cast<std::size_t>(a.geometry.voxels() * a.voxels.components) * size_of(a.voxels.type);
        EXPECT_EQ(std::memcmp(a.voxels.data.get(), b.voxels.data.get(), bytes), 0) << "frame " << n;
        EXPECT_EQ(a.valid_share, b.valid_share);
        EXPECT_EQ(frames[n]->value_ranges().front().max, same[n]->value_ranges().front().max);
      }
    }
  }
  static std::vector<FieldPtr> frames_of(const FieldPtr& field) {
    const SeriesView* const series = series_of(*field);
    return series ? series->frames : std::vector<FieldPtr>{field};
  }
};

/// Numbers of a type, which repeat in no piece.
template <class T>
std::string numbers(std::int64_t count, bool big) {
  std::string bytes;
  for (std::int64_t n = 0; n < count; ++n) bytes += bytes_of(static_cast<T>(n % 120 - n / 120 % 7), big);
  return bytes;
}

constexpr std::int64_t dims[] = {131, 67, 61};  // several pieces, none of them whole rows
constexpr std::int64_t voxels = dims[0] * dims[1] * dims[2];
const std::string sizes = "131 67 61";

TEST_F(RawRows, OfNrrdInEveryTypeAndByteOrderWithVectorsAndFrames) {
  const auto expect = [&](const std::string& type, auto number, int components, int frames) {
    for (const bool big : {false, true}) {
      SCOPED_TRACE(type);
      const std::string all = numbers<decltype(number)>(voxels * components * frames, big);
      const auto header = [&](const std::string& encoding) {
        std::string text = "NRRD0005\ntype: " + type + "\ndimension: " + std::to_string(3 + (components > 1) + (frames > 1)) +
                           "\nspace: LPS\nsizes:" + (components > 1 ? " 3 " : " ") + sizes +
                           (frames > 1 ? " " + std::to_string(frames) : "") +
                           "\nspace directions:" + (components > 1 ? " none" : "") + " (1,0,0) (0,1,0) (0,0,1)" +
                           (frames > 1 ? " none" : "") + "\nkinds:" + (components > 1 ? " vector" : "") +
                           " domain domain domain" + (frames > 1 ? " time" : "") + "\nspace units: \"mm\" \"mm\" \"mm\"\n";
        if (components > 1) text += "measurement frame: (0,1,0) (-1,0,0) (0,0,1)\n";
        return text + "endian: " + (big ? "big" : "little") + "\nencoding: " + encoding + "\n\n";
      };
      expect_same(folder_.write("a.nrrd", header("raw") + all), folder_.write("b.nrrd", header("gzip") + gzipped(all)));
    }
  };
  expect("int8", std::int8_t{}, 1, 1);
  expect("uint8", std::uint8_t{}, 1, 3);
  expect("int16", std::int16_t{}, 1, 2);
  expect("int64", std::int64_t{}, 1, 1);
  expect("float", float{}, 3, 2);
}

TEST_F(RawRows, OfMetaImageAndNifti) {
  for (const bool big : {false, true}) {
    const std::string all = numbers<std::int16_t>(2 * voxels, big);
    const auto meta = [&](const std::string& more) {
      return "ObjectType = Image\nNDims = 4\nBinaryData = True\nBinaryDataByteOrderMSB = " +
             std::string(big ? "True" : "False") + "\nDimSize = " + sizes + " 2\nElementSpacing = 1 1 1 1\n" + more +
             "ElementType = MET_SHORT\nElementDataFile = LOCAL\n";
    };
    expect_same(folder_.write("a.mha", meta("") + all), folder_.write("b.mha", meta("CompressedData = True\n") + gzipped(all)));

    std::string nifti(352, '\0');
    const auto put = [&](std::size_t at, auto value) { nifti.replace(at, sizeof value, bytes_of(value, big)); };
    put(0, std::int32_t{348}), put(40, std::int16_t{4}), put(48, std::int16_t{2}), put(70, std::int16_t{4});
    for (std::size_t a = 0; a < 3; ++a) put(42 + 2 * a, static_cast<std::int16_t>(dims[a]));
    put(72, std::int16_t{16}), put(108, 352.0F);
    for (std::size_t a = 0; a < 5; ++a) put(76 + 4 * a, 1.0F);
    nifti[123] = 2;
    nifti.replace(344, 4, std::string("n+1\0", 4));
    expect_same(folder_.write("a.nii", nifti + all), folder_.write("a.nii.gz", gzipped(nifti + all)));
  }
}

}  // namespace raw_rows_test
}  // namespace palpa::test
