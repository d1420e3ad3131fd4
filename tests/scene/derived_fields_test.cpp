// FUNC(FIELD) names, smoothing_m and view layers in scenes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "palpa/data/derived.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "tests/scene/scene_files.h"

namespace palpa {
namespace derived_fields_test {

using testing::HasSubstr;

Scene flow_scene() {
  Scene scene;
  scene.add("flow", lamb_oseen_vortex());
  scene.add("ball", sphere_field());
  return scene;
}

std::string error_of(const Scene& scene, const std::string& field) {
  try {
    scene.field({field});
  } catch (const SceneError& error) {
    return error.what();
  }
  return "no error";
}

TEST(DerivedField, IsWhatItsNameSays) {
  const Scene scene = flow_scene();
  const Vec3 x{0.011, 0.004, 0.01};
  const FieldPtr velocity = scene.field({"flow"}).field;
  EXPECT_EQ(scene.field({"magnitude(flow.velocity)"}).field->scalar(x).value, norm(velocity->vector(x).value));
  EXPECT_EQ(scene.field({"component_y(flow)"}).field->scalar(x).value, velocity->vector(x).value.y);
  const VolumeField turning = scene.field({"magnitude(curl(flow))"});
  EXPECT_EQ(turning.name, "magnitude(curl(velocity))");
  EXPECT_EQ(turning.field->components(), 1);
  EXPECT_NEAR(turning.field->scalar(x).value, norm(scene.field({"curl(flow)"}).field->vector(x).value), 1e-12);
  EXPECT_EQ(scene.index_of({"flow.velocity"}), 0);
  EXPECT_EQ(scene.index_of({"magnitude(flow)"}), -1);
}

TEST(DerivedField, IsComputedOnceForASceneAndItsCopies) {
  const Scene scene = flow_scene();
  const Scene copy = scene;
  EXPECT_EQ(scene.field({"q(flow)"}).field, copy.field({"q(flow.velocity)"}).field);
  EXPECT_EQ(scene.field({"flow"}, Derivation::q), scene.field({"q(flow)"}).field);
  EXPECT_NE(scene.field({"q(flow)"}).field, flow_scene().field({"q(flow)"}).field);
}

TEST(DerivedField, WrongNamesSayWhatWouldBeRight) {
  const Scene scene = flow_scene();
  EXPECT_THAT(error_of(scene, "magnitud(flow)"), HasSubstr("no function 'magnitud' of a field; did you mean 'magnitude'?"));
  EXPECT_THAT(error_of(scene, "smooth(ball)"), HasSubstr("no function 'smooth'"));
  EXPECT_THAT(error_of(scene, "magnitude(ball)"),
              HasSubstr("cannot be taken of the scalar field within it; it takes a vector"));
  EXPECT_THAT(error_of(scene, "curl(magnitude(flow))"), HasSubstr("'curl' cannot be taken of the scalar field"));
  EXPECT_THAT(error_of(scene, "magnitude(flwo)"), HasSubstr("no volume 'flwo'; did you mean 'flow'?"));
  for (const char* name :
       {"magnitude(flow", "magnitude(flow))", "magnitude flow)", "(flow)", "magnitude()", "magnitude(", ")"}) {
    EXPECT_THAT(error_of(scene, name), HasSubstr(";")) << name;
  }
  std::string deep = "flow";
  for (int i = 0; i < 5000; ++i) deep = "curl(" + deep + ")";
  EXPECT_THAT(error_of(scene, deep), HasSubstr("is no field; write VOLUME"));
}

const std::string vortex = R"toml(palpa = 1
[volume.flow]
analytic = "lamb_oseen_vortex"
sampled = 24
smoothing_m = 0.02
[[mode]]
name = "core"
type = "vortex_force"
field = "flow"
strength_n = {of = "magnitude(flow)", points = [[0, 0], [1, 1]]}
[[view.layer]]
show = "streamlines"
field = "flow"
[[view.layer]]
show = "surface"
field = "q(flow)"
level = 2.5
colors = {points = [[2.5, "#56b4e9", 0.35]]}
)toml";

TEST(SceneFile, SmoothsAsTheVolumeSays) {
  const Scene smooth = test::parse(vortex).scene;
  EXPECT_EQ(smooth.volumes()[0].smoothing_m, 0.02);
  const Scene rough = test::parse(vortex, {.data_folders = {}, .sets = {{"volume.flow.smoothing_m", "0.006"}}}).scene;
  EXPECT_LT(smooth.field({"q(flow)"}).field->value_ranges()[0].max,
            0.5 * rough.field({"q(flow)"}).field->value_ranges()[0].max);
  EXPECT_THAT(test::error_of(vortex, {.data_folders = {}, .sets = {{"volume.flow.smoothing_m", "0"}}}), HasSubstr("above 0"));
}

TEST(SceneFile, KeepsItsViewLayersAndPrintsThem) {
  const Scene scene = test::parse(vortex).scene;
  ASSERT_EQ(scene.layers.size(), 2u);
  EXPECT_EQ(scene.layers[0].show, ViewLayer::Show::streamlines);
  EXPECT_EQ(scene.layers[1].field.name, "q(flow)");
  EXPECT_EQ(scene.layers[1].level, 2.5);
  ASSERT_EQ(scene.layers[1].colors.size(), 1u);
  EXPECT_EQ(scene.layers[1].colors[0].color, "#56b4e9");
  const Scene again = test::parse(to_toml(scene)).scene;
  EXPECT_EQ(again.layers, scene.layers);
  EXPECT_EQ(to_toml(again), to_toml(scene));
}

TEST(SceneFile, AVectorModeOnAScalarFieldIsOneLine) {
  for (const char* type : {"follow", "vector_force", "vortex_force", "vortex_plane"}) {
    const std::string text = std::string("palpa = 1\n[volume.ball]\nanalytic = 'sphere'\n[[mode]]\nname = 'm'\ntype = '") +
                             type + "'\nfield = 'ball'\n";
    EXPECT_THAT(test::error_of(text),
                HasSubstr("s.toml:7:9: 'field' in mode 'm' must be a vector field; 'ball' is a scalar field"));
  }
  EXPECT_THAT(test::error_of("palpa = 1\n[volume.v]\nanalytic = 'lamb_oseen_vortex'\n[[mode]]\nname = 'm'\n"
                             "type = 'gradient_force'\nfield = 'v'\n"),
              HasSubstr("must be a scalar field; 'v' is a vector field"));
}

}  // namespace derived_fields_test
}  // namespace palpa
