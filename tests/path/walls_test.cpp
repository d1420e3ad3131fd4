// Walls: holding, and break-through at k·depth = s, after an onset.
#include "tests/path/walls.h"

#include <gtest/gtest.h>

#include "palpa/data/volume.h"
#include "palpa/file/read_volume.h"
#include "tests/laws/shipped_scenes.h"

namespace palpa::test {
namespace walls_test {

class Walls : public testing::TestWithParam<WallKind> {};

TEST_P(Walls, HoldWhateverIsWeaker) {
  const Held held = measure_held_walls({.kind = GetParam(), .strokes = 100});
  EXPECT_EQ(held.passed, 0) << "the first is stroke " << held.first_passed;
  EXPECT_EQ(held.unfinished, 0);
  const bool is_formula = GetParam() == WallKind::plate_formula || GetParam() == WallKind::shell_formula;
  if (is_formula) {
    EXPECT_EQ(held.through_holes + held.past_rims, 0) << "a formula has no holes";
  }
}

TEST_P(Walls, SayWhenTheyLetGo) {
  const WeakWallCounts counts = measure_weak_walls({.kind = GetParam(), .strokes = 100});
  EXPECT_GT(counts.break_throughs, 20);
  EXPECT_EQ(counts.without_onset, 0);
  EXPECT_EQ(counts.missing, 0);
}

TEST(BreakThroughs, HappenWhereStiffnessTimesDepthIsTheStrength) {
  const BreakThrough found = measure_break_through(200);
  EXPECT_GE(found.break_throughs, found.strokes);
  EXPECT_EQ(found.without_onset, 0);
  EXPECT_LT(found.depth_error_max_m, 1e-6);
}

class SkullHolds : public testing::TestWithParam<Filter> {};

TEST_P(SkullHolds, FastStrokes) {
  if (const std::string missing = missing_for("head"); !missing.empty()) GTEST_SKIP() << missing;
  VolumeRequest request;
  request.files = {shared_data() / "ct_head_cranium/cranium.mhd"};
  request.length_unit = "mm";
  const Volume head = read_volume(request, {.reader = reader()});
  const Skull skull = measure_skull(in_floats(*head.fields.front().field, GetParam()), {.strokes = 100});
  EXPECT_EQ(skull.passed, 0) << "the first is stroke " << skull.first_passed;
  EXPECT_EQ(skull.unfinished, 0);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Walls,
                         testing::Values(WallKind::plate_formula, WallKind::shell_formula, WallKind::trilinear,
                                         WallKind::smooth, WallKind::trilinear_binary, WallKind::smooth_binary),
                         [](const auto& one) {
                           std::string name = name_of(one.param);
                           std::erase(name, ',');
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });
INSTANTIATE_TEST_SUITE_P(Filters, SkullHolds, testing::Values(Filter::trilinear, Filter::smooth),
                         [](const auto& one) { return name_of(one.param); });

}  // namespace walls_test
}  // namespace palpa::test
