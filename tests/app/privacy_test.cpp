// A patient's name in a file reaches no output: messages, JSON, scene, trace, report.
#include <array>
#include <cmath>
#include <cstring>

#include "program.h"

namespace palpa {
namespace privacy_test {

namespace fs = std::filesystem;

constexpr const char* patient = "Doe^Jane";

/// A ball of integers, 20 voxels along each axis.
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
  header[123] = 2;
  text(14), text(148), text(228);  // db_name, descrip, aux_file
  put(344, std::array{'n', '+', '1', '\0'});
  return header + ball();
}

/// The ball as one file of 20 frames, with a person's name in every text element.
std::string dicom() {
  std::string bytes;
  const auto number = [](std::size_t value, std::size_t size) {
    std::string little;
    for (std::size_t b = 0; b < size; ++b) little += static_cast<char>(value >> (8 * b) & 255);
    return little;
  };
  const auto put = [&](unsigned group, unsigned element, const std::string& type, std::string value) {
    if (value.size() % 2 != 0) value += type == "UI" ? '\0' : ' ';
    const bool is_long = type == "OB" || type == "UT";
    bytes += number(group, 2) + number(element, 2) + type;
    bytes += is_long ? std::string(2, '\0') + number(value.size(), 4) : number(value.size(), 2);
    bytes += value;
  };
  const std::string who = patient;
  put(0x0002, 0x0010, "UI", "1.2.840.10008.1.2.1");
  const std::string meta = bytes;
  bytes.clear();
  put(0x0002, 0x0000, "UL", number(meta.size(), 4));
  bytes = std::string(128, '\0') + "DICM" + bytes + meta;
  put(0x0008, 0x0008, "CS", "ORIGINAL\\PRIMARY\\" + who);
  put(0x0008, 0x0050, "SH", who);
  put(0x0008, 0x0060, "CS", "CT");
  put(0x0008, 0x0070, "LO", "SIEMENS " + who);
  put(0x0008, 0x0080, "LO", who);
  put(0x0008, 0x0081, "ST", who);
  put(0x0008, 0x0090, "PN", who);
  put(0x0008, 0x1010, "SH", who);
  put(0x0008, 0x1030, "LO", who);
  put(0x0008, 0x103e, "LO", who);
  put(0x0008, 0x1050, "PN", who);
  put(0x0008, 0x1070, "PN", who);
  put(0x0008, 0x1090, "LO", who);
  put(0x0010, 0x0010, "PN", who);
  put(0x0010, 0x0020, "LO", who);
  put(0x0010, 0x1001, "PN", who);
  put(0x0010, 0x1040, "LO", who);
  put(0x0010, 0x1060, "PN", who);
  put(0x0010, 0x4000, "LT", who);
  put(0x0018, 0x0010, "LO", who);
  put(0x0018, 0x0015, "CS", "HEAD " + who);
  put(0x0018, 0x0020, "CS", who);
  put(0x0018, 0x0021, "CS", who);
  put(0x0018, 0x0024, "SH", who);
  put(0x0018, 0x0088, "DS", "5");
  put(0x0018, 0x1030, "LO", "Head " + who);
  put(0x0018, 0x1210, "SH", who);
  put(0x0020, 0x000e, "UI", "1.2.3");
  put(0x0020, 0x0032, "DS", "0\\0\\0");
  put(0x0020, 0x0037, "DS", "1\\0\\0\\0\\1\\0");
  put(0x0020, 0x4000, "LT", who);
  put(0x0028, 0x0002, "US", number(1, 2));
  put(0x0028, 0x0004, "CS", "MONOCHROME2");
  put(0x0028, 0x0008, "IS", "20");
  put(0x0028, 0x0010, "US", number(20, 2));
  put(0x0028, 0x0011, "US", number(20, 2));
  put(0x0028, 0x0030, "DS", "5\\5");
  for (const unsigned bits : {0x0100U, 0x0101U}) put(0x0028, bits, "US", number(8, 2));
  put(0x0028, 0x0102, "US", number(7, 2));
  put(0x0028, 0x0103, "US", number(0, 2));
  put(0x7fe0, 0x0010, "OB", ball());
  return bytes;
}

/// A file of this name with a patient's name in every text field of its format.
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
  return name == "a.dcm" ? dicom() : nifti();
}

class Privacy : public ProgramTest, public testing::WithParamInterface<const char*> {};

TEST_P(Privacy, OfAPatientIsKept) {
  if (!fs::exists(fs::path(PALPA_PROGRAM).parent_path() / "palpa-read")) GTEST_SKIP() << "palpa-read is not built";
  const std::string name = GetParam(), bytes = content_of(name);
  ASSERT_NE(bytes.find(patient), std::string::npos);
  write(name, bytes);
  const auto expect_nothing_in = [&](const Ended& ended) {
    EXPECT_EQ(ended.code, 0) << ended.err;
    for (const char* word : {patient, "Jane", "jane"})
      EXPECT_EQ((ended.out + ended.err).find(word), std::string::npos) << ended.out << ended.err;
  };
  expect_nothing_in(palpa({"info", name}));
  expect_nothing_in(palpa({"info", name, "--json"}));
  expect_nothing_in(palpa({"info", name, "--scene", "first.toml"}));
  expect_nothing_in(palpa({"convert", name, "out.nrrd"}));
  expect_nothing_in(palpa({"run", "first.toml", "--hand", "sim:press", "--duration-s", "0.5", "--out", "trace"}));
  if (const Ended report = palpa({"report", "trace"}); report.code == 0) expect_nothing_in(report);
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.path().filename() == name) continue;
    // In a page four letters come by chance, in inlined pictures and scripts.
    const bool page = entry.path().extension() == ".html";
    for (const char* part : {patient, "Jane", "jane"}) {
      if (page && part != patient) continue;
      EXPECT_EQ(read(entry.path()).find(part), std::string::npos) << entry.path();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Files, Privacy, testing::Values("a.nrrd", "a.mha", "a.nii", "a.vtk", "a.dcm"),
                         [](const auto& file) { return std::string(file.param).substr(2); });

}  // namespace privacy_test
}  // namespace palpa
