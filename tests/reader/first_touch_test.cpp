// Suggested scenes of each shared data set: contact of a recorded hand, limits, still forces at rest.
#include "data_sets.h"
#include "files.h"
#include "tests/study/first_scenes.h"

namespace palpa::test {
namespace first_touch_test {

class FirstScenes : public ReaderTest, public ::testing::WithParamInterface<DataSet> {};

TEST_P(FirstScenes, AreFeltUnderARecordedHand) {
  const fs::path data = shared_file(GetParam().file);
  const fs::path hand = shared_file("trajectories/inverse3_woodcarving_20231121_102837.csv");
  if (data.empty() || hand.empty()) GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
  const FirstTouch touch = first_touch(data, hand, options_);
  SCOPED_TRACE(touch.scene);
  EXPECT_EQ(touch.faults, 0);
  EXPECT_GE(touch.contact_share, 0.2);
  EXPECT_GE(touch.below_limit_share, 0.99);
  EXPECT_LT(touch.buzz_n, 5e-3);
}

// Two scenes that once stopped a proxy on a level by rounding alone: the force rose to the limit and stayed.
TEST_F(ReaderTest, FirstScenesLetTheProxyGoOn) {
  const std::pair<const char*, const char*> cases[] = {
      {"mri_flair_nrrd/FLAIR.nrrd", "trajectories/inverse3_woodcarving_20231121_103108.csv"},
      {"mri_head_mhd/HeadMRVolume.mhd", "trajectories/inverse3_woodcarving_20231123_143724.csv"}};
  for (const auto& [file, recording] : cases) {
    const fs::path data = shared_file(file), hand = shared_file(recording);
    if (data.empty() || hand.empty()) GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
    const FirstTouch touch = first_touch(data, hand, options_);
    EXPECT_EQ(touch.faults, 0) << file;
    EXPECT_GE(touch.below_limit_share, 0.99) << file;
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, FirstScenes, ::testing::ValuesIn(data_sets()),
                         [](const auto& set) { return name_of(set.param); });

}  // namespace first_touch_test
}  // namespace palpa::test
