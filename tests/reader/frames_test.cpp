// Time series in one file: all frames by one reader, each equal to a single read.
#include <algorithm>
#include <fstream>

#include "files.h"
#include "palpa/base/limits.h"
#include "palpa/data/read_series.h"
#include "palpa/data/timed_field.h"

namespace palpa::test {
namespace frames_test {

class Frames : public ReaderTest {
 protected:
  void SetUp() override {
    ReaderTest::SetUp();
    if (IsSkipped()) return;
    const fs::path script = folder_.write(
        "reader", "#!/bin/sh\necho >>'" + starts_file().string() + "'\nexec '" + options_.reader.string() + "'\n");
    fs::permissions(script, fs::perms::owner_all);
    counted_ = options_;
    counted_.reader = script;
  }
  fs::path starts_file() const { return folder_.path() / "starts"; }
  std::int64_t starts() const {
    std::ifstream file(starts_file());
    return std::count(std::istreambuf_iterator<char>(file), {}, '\n');
  }
  Volume series(const fs::path& file, VolumeRequest request = {}) const {
    request.files = {file};
    return read_series(request, 0.5, BetweenFrames::linear, volume_reader(counted_));
  }
  /// Expects one reader, and frames equal to single reads.
  void expect_each_as_alone(const fs::path& file, int frames, VolumeRequest request = {}) {
    SCOPED_TRACE(file);
    fs::remove(starts_file());
    const Volume all = series(file, request);
    EXPECT_EQ(starts(), 1);
    EXPECT_EQ(all.frames, frames);
    for (const std::string& warning : all.warnings) EXPECT_EQ(warning.find("the first is read"), std::string::npos) << warning;
    ASSERT_EQ(all.fields.size(), 1U);
    const SeriesView* const view = series_of(*all.fields[0].field);
    ASSERT_NE(view, nullptr);
    ASSERT_EQ(view->frames.size(), static_cast<std::size_t>(frames));
    EXPECT_EQ(view->period_s, 0.5);
    for (request.frame = 0; request.frame < frames; request.frame += std::max(1, frames / 7)) {
      const Volume alone = read(file, request);
      const Field &one = *view->frames[static_cast<std::size_t>(request.frame)], &same = *alone.fields[0].field;
      ASSERT_EQ(one.components(), same.components());
      const Box box = same.bounds_m();
      for (int n = 0; n < 50; ++n) {
        const Vec3 share{(n * 37 % 50) / 49.0, (n * 23 % 50) / 49.0, n / 49.0}, size = box.high_m - box.low_m;
        const Vec3 at = box.low_m + Vec3{share.x * size.x, share.y * size.y, share.z * size.z};
        EXPECT_EQ(one.scalar(at).value, same.scalar(at).value);
        EXPECT_EQ(one.vector(at).value, same.vector(at).value);
      }
    }
  }
  ReadOptions counted_;
};

std::string numbers(int count) {
  std::string bytes;
  for (int v = 0; v < count; ++v) bytes += bytes_of(static_cast<std::int16_t>(std::int64_t{v} * 7919 % 1000));
  return bytes;
}
std::string nrrd(const std::string& sizes, const std::string& more) {
  return "NRRD0004\ntype: short\ndimension: " + std::to_string(1 + std::count(sizes.begin(), sizes.end(), ' ')) +
         "\nsizes: " + sizes + "\nendian: little\n" + more + "\n";
}
/// A NIfTI-1 file of int16. \param dims  their count, then the sizes; \param intent  1007: the fifth are vectors
std::string nifti(const std::vector<std::int16_t>& dims, std::int16_t intent = 0) {
  std::string h(352, '\0');
  const auto put = [&](std::size_t at, auto value) { h.replace(at, sizeof value, bytes_of(value)); };
  put(0, std::int32_t{348});
  int count = 1;
  for (std::size_t d = 0; d < 8; ++d) put(40 + 2 * d, d < dims.size() ? dims[d] : std::int16_t{1});
  for (std::size_t d = 1; d < dims.size(); ++d) count *= dims[d];
  put(68, intent), put(70, std::int16_t{4}), put(72, std::int16_t{16});
  for (std::size_t d = 0; d < 8; ++d) put(76 + 4 * d, 1.0F);
  put(108, 352.0F);
  h[123] = 2;
  h.replace(344, 4, std::string("n+1\0", 4));
  return h + numbers(count);
}

TEST_F(Frames, OfNrrd) {
  expect_each_as_alone(folder_.write("last.nrrd", nrrd("3 4 5 6", "encoding: raw\n") + numbers(360)), 6);
  expect_each_as_alone(
      folder_.write("first.nrrd", nrrd("6 3 4 5", "kinds: list domain domain domain\nencoding: raw\n") + numbers(360)), 6);
  expect_each_as_alone(folder_.write("packed.nrrd", nrrd("3 4 5 6", "encoding: gzip\n") + gzipped(numbers(360))), 6);
  expect_each_as_alone(
      folder_.write("vectors.nrrd",
                    nrrd("3 3 4 5 2", "kinds: vector domain domain domain time\nencoding: raw\n") + numbers(360)),
      2);
}

TEST_F(Frames, OfNifti) {
  expect_each_as_alone(folder_.write("a.nii", nifti({4, 3, 4, 5, 6})), 6);
  expect_each_as_alone(folder_.write("a.nii.gz", gzipped(nifti({4, 3, 4, 5, 6}))), 6);
  expect_each_as_alone(folder_.write("vectors.nii", nifti({5, 3, 4, 5, 2, 3}, 1007)), 2);
  // One frame of vectors: the components lie behind one another.
  const Volume vectors = read(folder_.path() / "vectors.nii");
  EXPECT_EQ(vectors.fields[0].field->components(), 3);
  EXPECT_EQ(vectors.fields[0].field->vector({}).value, (Vec3{0, 120 * 7919 % 1000, 240 * 7919 % 1000}));
}

TEST_F(Frames, OfMetaImage) {
  expect_each_as_alone(folder_.write("a.mha",
                                     "ObjectType = Image\nNDims = 4\nDimSize = 3 4 5 6\nElementType = MET_SHORT\n"
                                     "ElementDataFile = LOCAL\n" +
                                         numbers(360)),
                       6);
}

TEST_F(Frames, OfRealData) {
  const fs::path file = shared_file("mri_epi_4d/example4d.nii.gz"), second = shared_file("mri_epi_4d/example_nifti2.nii.gz");
  if (file.empty()) GTEST_SKIP() << "no shared data";
  expect_each_as_alone(file, 2);
  expect_each_as_alone(second, 2);
}

// A process for each of them would take minutes.
TEST_F(Frames, AreReadByThousandsFromSmallFiles) {
  const int frames = static_cast<int>(limit::frames.most);
  const Volume all =
      series(folder_.write("a.nrrd", nrrd("2 2 2 " + std::to_string(frames), "encoding: raw\n") + numbers(8 * frames)));
  EXPECT_EQ(all.frames, frames);
  EXPECT_EQ(series(folder_.write("a.nii", nifti({4, 4, 4, 2, 32767}))).frames, 32767);
  EXPECT_EQ(starts(), 2);
}

TEST_F(Frames, HaveALimit) {
  const int frames = static_cast<int>(limit::frames.most) + 1;
  const fs::path file =
      folder_.write("a.nrrd", nrrd("2 2 2 " + std::to_string(frames), "encoding: raw\n") + numbers(8 * frames));
  EXPECT_EQ(error_of([&] { series(file); }),
            file.string() + ": has " + std::to_string(frames) + " frames, " + more_than(limit::frames));
  EXPECT_EQ(read(file).frames, frames) << "one of them is read all the same";
}

TEST_F(Frames, OfAFileThatIsCutShortAreRefused) {
  const std::string whole = nifti({4, 3, 4, 5, 6});
  EXPECT_NE(error_of([&] { series(folder_.write("a.nii", whole.substr(0, whole.size() - 100))); }).find("whole"),
            std::string::npos);
  const std::string packed = gzipped(whole);
  EXPECT_NE(error_of([&] { series(folder_.write("a.nii.gz", packed.substr(0, packed.size() / 2))); }).find("whole"),
            std::string::npos);
}

}  // namespace frames_test
}  // namespace palpa::test
