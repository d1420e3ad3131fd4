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

TEST_F(OpenFoam, RegionsAreReadOneAtATime) {
  write_openfoam_case(folder_);
  const auto move_to = [&](const std::string& region) {
    std::filesystem::create_directories(folder_.path() / "constant" / region);
    std::filesystem::rename(folder_.path() / "constant/polyMesh", folder_.path() / "constant" / region / "polyMesh");
    for (const char* time : {"0", "1", "2"}) {
      std::filesystem::create_directories(folder_.path() / time / region);
      for (const char* name : {"U", "p"})
        std::filesystem::rename(folder_.path() / time / name, folder_.path() / time / region / name);
    }
  };
  const auto expect_moment = [&](const Volume& volume, double t) {
    const Vec3 at{1.1, 0.75, 0.5};
    const ScalarSample p = field_of(volume, "p").field->scalar(at);
    ASSERT_TRUE(p.inside);
    EXPECT_NEAR(p.value, t + at.x, 1e-4);
  };
  move_to("fluid");
  const Volume only = read(folder_.path());
  expect_moment(only, 2.0);
  EXPECT_TRUE(warns_of(only, "'fluid'"));
  EXPECT_GT(only.files.size(), 6U);
  write_openfoam_case(folder_);
  std::filesystem::rename(folder_.path() / "constant/fluid", folder_.path() / "constant/away");
  move_to("solid");
  std::filesystem::rename(folder_.path() / "constant/away", folder_.path() / "constant/fluid");
  const std::string several = error_of([&] { read(folder_.path()); });
  EXPECT_NE(several.find("several regions (fluid, solid)"), std::string::npos) << several;
  VolumeRequest request;
  request.time_s = 1.0;
  for (const char* region : {"fluid", "solid"}) expect_moment(read(folder_.path().string() + ":/" + region, request), 1.0);
  EXPECT_NE(error_of([&] { read(folder_.path().string() + ":/air"); }).find("it has fluid, solid"), std::string::npos);
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
