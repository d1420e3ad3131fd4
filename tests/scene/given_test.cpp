// Volumes that a program gives, for tables without 'file' and 'analytic'.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "palpa/mode/modes.h"
#include "tests/scene/ball_scene.h"

namespace palpa {
namespace given_test {

using test::error_of;
using test::parse;
using testing::HasSubstr;
using testing::StartsWith;

std::string scene(const std::string& body, const std::string& more = "") {
  return "palpa = 1\n[volume.v]\n" + body +
         "[[mode]]\nname = \"skin\"\ntype = \"surface_and_friction\"\nfield = \"v\"\nlevel = [{name = \"outside\", value = 0, "
         "strength_n = 1}]\n" +
         more;
}

GivenVolumes a_ball() { return {{"v", sampled(sphere_field(), 20)}}; }

TEST(Given, IsFeltAsTheSameVolumeOfAFormula) {
  const GivenVolumes given = a_ball();
  const Scene of_program = parse(scene("filter = \"smooth\"\npose = {scale = 2}\n"), {.given = &given}).scene;
  const Scene of_text = parse(scene("analytic = \"sphere\"\nsampled = 20\nfilter = \"smooth\"\npose = {scale = 2}\n")).scene;
  const FieldPtr a = of_program.field({"v"}).field, b = of_text.field({"v"}).field;
  for (const double x : {0.0, 0.01, 0.03, 0.05})
    EXPECT_EQ(a->scalar({x, 0.01, -0.02}).value, b->scalar({x, 0.01, -0.02}).value);
  EXPECT_EQ(to_toml(parse(to_toml(of_program), {.given = &given}).scene), to_toml(of_program));
}

TEST(Given, AValidTextWithoutItsDataIsToldFromAnInvalidOne) {
  const GivenVolumes none;
  EXPECT_THROW(parse(scene(""), {.given = &none}), MissingData);
  EXPECT_EQ(error_of(scene(""), {.given = &none}), "s.toml:2:1: volume 'v' has no data yet; give it a grid");
  EXPECT_THAT(error_of(scene("", "[coupling]\nstiffnes = 1\n"), {.given = &none}), HasSubstr("unknown key 'stiffnes'"));
  EXPECT_THAT(error_of(scene("", "friction = 1\n"), {.given = &none}), HasSubstr("unknown key 'friction'"));
}

TEST(Given, HasNoKeysOfFiles) {
  const GivenVolumes given = a_ball();
  const auto error = [&](const std::string& body) { return error_of(scene(body), {.given = &given}); };
  EXPECT_EQ(error("length_unit = \"mm\"\n"),
            "s.toml:3:15: 'length_unit' in volume 'v' speaks of a file, and there is none; leave it out");
  EXPECT_THAT(error("sampled = 20\n"), HasSubstr("is for embedded data; leave it out"));
  EXPECT_THAT(error("frame_period_s = 1\n"), HasSubstr("is for a time series"));
  EXPECT_THAT(error("analytic = \"sphere\"\n"),
              StartsWith("volume 'v': the scene has no table [volume.v] without 'file' and 'analytic'"));
}

TEST(Given, IsAnErrorWhereNoProgramGives) {
  EXPECT_EQ(error_of(scene("")), "s.toml:2:1: volume 'v' has no data; give either 'file' or 'analytic'");
}

}  // namespace given_test
}  // namespace palpa
