// A patient's name in a file gets into nothing that leaves the program: words, JSON, scene, trace, report.
#include <array>
#include <cmath>
#include <cstring>

#include "program.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;

constexpr const char* patient = "Doe^Jane";

/// A ball of whole numbers, 20 voxels along each axis.
std::string ball() {
  std::string voxels;
  for (int k = 0; k < 20; ++k)
    for (int j = 0; j < 20; ++j)
      for (int i = 0; i < 20; ++i) {
        const double r = std::sqrt((i - 9.5) * (i - 9.5) + (j - 9.5) * (j - 9.5) + (k - 9.5) * (k - 9.5));
        voxels += static_cast<char>(r < 7.0 ? 200 : r < 8.0 ? 100 : 0);
      }
  return voxels;
}

std::string nifti() {
  std::string header(352, '\0');
  const auto put = [&](std::size_t at, const auto& value) { std::memcpy(header.data() + at, &value, sizeof value); };
  const auto text = [&](std::size_t at) { std::memcpy(header.data() + at, patient, std::strlen(patient)); };
  put(0, std::int32_t{348});
  const std::int16_t dim[] = {3, 20, 20, 20, 1, 1, 1, 1};
  put(40, dim);
  put(70, std::int16_t{2}), put(72, std::int16_t{8});
  const float pixdim[] = {1, 5, 5, 5};
  put(76, pixdim);
  put(108, 352.0F);
  header[123] = 2;                 // millimetres
  text(14), text(148), text(228);  // db_name, descrip, aux_file
  put(344, std::array{'n', '+', '1', '\0'});
  return header + ball();
}

/// A file of this name with a patient's name wherever its format has room for words.
std::string content_of(const std::string& name) {
  const std::string who = patient;
  if (name == "a.nrrd") {
    return "NRRD0004\n# " + who +
           "\ntype: uint8\ndimension: 3\nsizes: 20 20 20\nspacings: 5 5 5\nencoding: raw\ncontent: " + who +
           "\nPatientName:=" + who + "\n\n" + ball();
  }
  if (name == "a.mha") {
    return "ObjectType = Image\nNDims = 3\nComment = " + who + "\nName = " + who +
           "\nDimSize = 20 20 20\nElementSpacing = 5 5 5\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + ball();
  }
  if (name == "a.vtk") {
    return "# vtk DataFile Version 3.0\n" + who +
           "\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 20 20 20\nORIGIN 0 0 0\nSPACING 1 1 1\n"
           "POINT_DATA 8000\nSCALARS density unsigned_char 1\nLOOKUP_TABLE default\n" +
           ball();
  }
  return nifti();
}

class Privacy : public ProgramTest, public testing::WithParamInterface<const char*> {};

TEST_P(Privacy, OfAPatientIsKept) {
  if (!fs::exists(fs::path(PALPA_PROGRAM).parent_path() / "palpa-read")) GTEST_SKIP() << "palpa-read is not built";
  const std::string name = GetParam(), bytes = content_of(name);
  ASSERT_NE(bytes.find(patient), std::string::npos);
  write(name, bytes);
  const auto expect_nothing_in = [&](const Ended& ended) {
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ((ended.out + ended.err).find(patient), std::string::npos) << ended.out << ended.err;
  };
  expect_nothing_in(palpa({"info", name}));
  expect_nothing_in(palpa({"info", name, "--json"}));
  expect_nothing_in(palpa({"info", name, "--scene", "first.toml"}));
  expect_nothing_in(palpa({"convert", name, "out.nrrd"}));
  expect_nothing_in(palpa({"run", "first.toml", "--hand", "sim:press", "--duration-s", "0.5", "--out", "trace"}));
  if (const Ended report = palpa({"report", "trace"}); report.code == 0) expect_nothing_in(report);
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.path().filename() == name) continue;
    EXPECT_EQ(read(entry.path()).find(patient), std::string::npos) << entry.path();
  }
}

INSTANTIATE_TEST_SUITE_P(Files, Privacy, testing::Values("a.nrrd", "a.mha", "a.nii", "a.vtk"),
                         [](const auto& file) { return std::string(file.param).substr(2); });

}  // namespace
}  // namespace palpa
