// A small case of OpenFOAM.
#include "openfoam_case.h"

namespace palpa::test {
namespace openfoam_test {

class OpenFoam : public ReaderTest {
 protected:
  static const VolumeField& field_of(const Volume& volume, const std::string& name) {
    for (const VolumeField& f : volume.fields) {
      if (f.name == name) return f;
    }
    throw std::runtime_error("no field " + name + " (" + all_warnings(volume) + ")");
  }
};

TEST_F(OpenFoam, TheLatestMomentOrTheOneAskedFor) {
  write_openfoam_case(folder_);
  const Volume latest = read(folder_.path());
  EXPECT_EQ(latest.format, "openfoam");
  EXPECT_TRUE(warns_of(latest, "3 moments: the latest, 2 s"));
  EXPECT_EQ(field_of(latest, "U").unit, "m/s");
  EXPECT_EQ(field_of(latest, "p").unit, "m2/s2");
  EXPECT_GT(latest.files.size(), 6U);
  VolumeRequest request;
  request.time_s = 1.0;
  const Volume first = read(folder_.path(), request);
  for (const auto& [volume, t] : {std::pair{&latest, 2.0}, std::pair{&first, 1.0}}) {
    // Between centres of cells away from walls, where averages of linear values are right.
    const Vec3 at{1.1, 0.75, 0.5};
    const VectorSample u = field_of(*volume, "U").field->vector(at);
    ASSERT_TRUE(u.inside);
    EXPECT_NEAR(u.value.x, t * at.x, 1e-4);
    EXPECT_NEAR(u.value.y, 2 * t * at.y, 1e-4);
    EXPECT_NEAR(field_of(*volume, "p").field->scalar(at).value, t + at.x, 1e-4);
  }
  request.time_s = 1.5;
  EXPECT_NE(error_of([&] { read(folder_.path(), request); }).find("from 0 to 2 s"), std::string::npos);
  folder_.write("case.foam", " ");
  EXPECT_EQ(read(folder_.path() / "case.foam").format, "openfoam");
  EXPECT_EQ(read(folder_.path() / "system" / "controlDict").format, "openfoam");
}

TEST_F(OpenFoam, WhatIsMissingIsSaid) {
  write_openfoam_case(folder_);
  std::filesystem::remove(folder_.path() / "constant/polyMesh/owner");
  error_of([&] { read(folder_.path()); });
  std::filesystem::remove_all(folder_.path() / "constant");
  EXPECT_NE(error_of([&] { read(folder_.path()); }).find("polyMesh"), std::string::npos);
  std::filesystem::create_directories(folder_.path() / "processor0");
  EXPECT_NE(error_of([&] { read(folder_.path()); }).find("reconstructPar"), std::string::npos);
}

}  // namespace openfoam_test
}  // namespace palpa::test
