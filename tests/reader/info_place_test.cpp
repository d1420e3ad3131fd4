// Positions as people write them: all forms of one position give an equal value.
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/info.h"
#include "files.h"

namespace palpa::test {
namespace info_place_test {

using Json = nlohmann::json;
using app::asked_place;
using app::asked_place_m;

class InfoPlace : public ReaderTest {
 protected:
  std::string printed(const fs::path& file, const std::vector<app::AskedPlace>& places, bool json) const {
    app::InfoArguments arguments;
    arguments.files = {file}, arguments.json = json, arguments.read = options_, arguments.places = places;
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(app::run_info(arguments), 0);
    errors_ = ::testing::internal::GetCapturedStderr();
    return ::testing::internal::GetCapturedStdout();
  }
  Json samples(const fs::path& file, const std::vector<app::AskedPlace>& places) const {
    return Json::parse(printed(file, places, true))["samples"];
  }
  /// 3 x 4 x 5 voxels of 1 x 2 x 4 mm with its axes to the right, front and head, in LPS.
  fs::path patient() const {
    std::string voxels;
    for (int n = 0; n < 60; ++n) voxels += static_cast<char>(n * n % 97);
    return folder_.write("p.nrrd",
                         "NRRD0005\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 3 4 5\nspace directions: "
                         "(-1,0,0) (0,-2,0) (0,0,4)\nspace origin: (10,20,30)\nspace units: \"mm\" \"mm\" \"mm\"\nencoding: "
                         "raw\n\n" +
                             voxels);
  }
  mutable std::string errors_;
};

TEST_F(InfoPlace, VoxelMillimetresMetresAndLettersAreOnePlace) {
  const Json all =
      samples(patient(), {asked_place("1.5,2,3"), asked_place("8.5mm,16mm,42mm"), asked_place("8.5,16,42mm"),
                          asked_place("0.85cm,1.6cm,4.2cm"), asked_place("L8.5,P16,S42"), asked_place("S42,L8.5,P16"),
                          asked_place("r-8.5mm, a-16mm, i-42mm"), asked_place_m("0.0085,0.016,0.042")});
  ASSERT_EQ(all.size(), 8U);
  for (const Json& sample : all) {
    EXPECT_EQ(sample["inside"], true);
    EXPECT_NEAR(sample["values"]["value"].get<double>(), all[0]["values"]["value"].get<double>(), 1e-9);
    EXPECT_NEAR(sample["at_ijk"][0].get<double>(), 1.5, 1e-9);
    EXPECT_NEAR(sample["at_ijk"][1].get<double>(), 2.0, 1e-9);
    EXPECT_NEAR(sample["at_ijk"][2].get<double>(), 3.0, 1e-9);
    EXPECT_NEAR(sample["at_m"][0].get<double>(), 0.0085, 1e-12);
  }
}

TEST_F(InfoPlace, APlaneAmongUnevenOnesIsItsIndex) {
  const fs::path file =
      folder_.write("r.vtr",
                    "<?xml version=\"1.0\"?><VTKFile type=\"RectilinearGrid\" version=\"1.0\" "
                    "byte_order=\"LittleEndian\"><RectilinearGrid WholeExtent=\"0 3 0 1 0 1\"><Piece Extent=\"0 3 0 1 0 "
                    "1\"><PointData><DataArray type=\"Float32\" Name=\"p\" format=\"ascii\">0 1 2 3 0 1 2 3 0 1 2 3 0 1 2 "
                    "3</DataArray></PointData><Coordinates><DataArray type=\"Float32\" Name=\"x\" format=\"ascii\">0 1 3 "
                    "7</DataArray><DataArray type=\"Float32\" Name=\"y\" format=\"ascii\">0 1</DataArray><DataArray "
                    "type=\"Float32\" Name=\"z\" format=\"ascii\">0 1</DataArray></Coordinates></Piece></"
                    "RectilinearGrid></VTKFile>");
  for (const double i : {0.0, 0.25, 1.0, 1.5, 2.75, 3.0}) {
    const Json sample = samples(file, {asked_place(std::to_string(i) + ",0.5,0.5")})[0];
    EXPECT_NEAR(sample["at_ijk"][0].get<double>(), i, 1e-6);
    EXPECT_NEAR(sample["values"]["p"].get<double>(), i, 1e-6) << "the value is the index";
  }
}

TEST_F(InfoPlace, LettersAreOfPatientsOnly) {
  const fs::path file =
      folder_.write("n.nrrd", "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: raw\n\n12345678");
  EXPECT_NE(error_of([&] {
              app::run_info({.files = {file}, .at_m = {}, .read = options_, .places = {asked_place("R1,A1,S1")}});
            }).find("how a patient lies"),
            std::string::npos);
  for (const char* wrong :
       {"", "1,2", "1,2,3,4", "1mm,2,3", "R1,A2,L3", "R1,A2,3", "X1,Y2,Z3", "1furlong,2furlong,3furlong", "nan,1,2", "a,b,c"})
    EXPECT_NE(error_of([&] { asked_place(wrong); }).find("--at"), std::string::npos) << wrong;
}

TEST_F(InfoPlace, WordsAreRoundedAndFarPlacesAskForTheirUnit) {
  const fs::path file = patient();
  const std::string words = printed(file, {asked_place("1.3,1.4,1.7")}, false);
  EXPECT_NE(words.find("L 8.7, P 17.2, S 36.8 mm"), std::string::npos) << words;
  EXPECT_NE(words.find("voxel 1.3, 1.4, 1.7"), std::string::npos) << words;
  const std::string far = printed(file, {asked_place_m("8,16,42")}, false);
  EXPECT_NE(far.find("outside of the data"), std::string::npos) << far;
  EXPECT_NE(far.find("metres?"), std::string::npos) << far;
  EXPECT_EQ(printed(file, {asked_place("9,9,9")}, false).find("metres?"), std::string::npos);
}

TEST_F(InfoPlace, LettersAgreeInEveryOrientation) {
  if (shared_file("nifti_orientations").empty())
    GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
  double expected = std::nan("");
  int files = 0;
  for (const auto& entry : fs::directory_iterator(shared_file("nifti_orientations"))) {
    const std::string words = printed(entry.path(), {asked_place("R30,A10,S20")}, false);
    EXPECT_NE(words.find("R 30.0, A 10.0, S 20.0 mm"), std::string::npos) << words;
    const std::string letters = entry.path().filename().string().substr(0, 3);
    EXPECT_NE(words.find("): " + letters), std::string::npos) << words;
    for (const char letter : letters) EXPECT_NE(words.find(std::string(" (") + letter + ")"), std::string::npos) << words;
    const Json sample = samples(entry.path(), {asked_place("R30,A10,S20")})[0];
    const double value = sample["values"].front();
    if (files++ == 0) expected = value;
    EXPECT_NEAR(value, expected, 1e-4 * std::abs(expected)) << entry.path();
    const Json& ijk = sample["at_ijk"];
    const std::string by_index = ijk[0].dump() + "," + ijk[1].dump() + "," + ijk[2].dump();
    EXPECT_NEAR(samples(entry.path(), {asked_place(by_index)})[0]["values"].front().get<double>(), value,
                1e-6 * std::abs(value));
  }
  EXPECT_EQ(files, 12);
}

}  // namespace info_place_test
}  // namespace palpa::test
