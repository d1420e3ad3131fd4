// Pictures of scenes: that they are the same each time, and that things are where geometry says.
#include "palpa/view/scene_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <numbers>

#include "palpa/field/analytic.h"
#include "palpa/field/grid.h"
#include "palpa/mode/surface_and_friction.h"

namespace palpa {
namespace {

using testing::HasSubstr;
using Rgb = std::array<int, 3>;

Rgb pixel(const Picture& picture, int x, int y) {
  const std::size_t at = 3 * (static_cast<std::size_t>(y) * picture.width_px + x);
  return {picture.rgb.at(at), picture.rgb.at(at + 1), picture.rgb.at(at + 2)};
}

/// The ground is nearly white, and nothing of a picture is lighter.
bool is_ground(const Rgb& rgb) { return rgb[0] > 246 && rgb[1] > 246 && rgb[2] > 246; }
bool is_dark(const Rgb& rgb) { return rgb[0] + rgb[1] + rgb[2] < 240; }

double share_of(const Picture& picture, bool (*wanted)(const Rgb&)) {
  std::size_t count = 0;
  for (int y = 0; y < picture.height_px; ++y) {
    for (int x = 0; x < picture.width_px; ++x) count += wanted(pixel(picture, x, y));
  }
  return static_cast<double>(count) / (static_cast<double>(picture.width_px) * picture.height_px);
}

struct Place {
  int x;
  int y;
};

/// Where a point of the hand frame is on a picture, from the options alone: rows from the top.
Place projected(const Vec3& p_m, const ScenePictureOptions& options) {
  const Vec3 towards = normalized(options.from);
  const Vec3 right = normalized(cross(options.up, towards));
  const Vec3 up = cross(towards, right);
  const double px_per_m = 0.5 * options.height_px / options.half_height_m;
  return {static_cast<int>(std::floor(0.5 * options.width_px + px_per_m * dot(p_m - *options.centre_m, right))),
          static_cast<int>(std::floor(0.5 * options.height_px - px_per_m * dot(p_m - *options.centre_m, up)))};
}

ScenePictureOptions small(Vec3 from = {0, 0, 1}) {
  ScenePictureOptions options;
  options.width_px = 480;
  options.height_px = 360;
  options.from = from;
  options.half_height_m = 0.1;
  options.centre_m = Vec3{};
  return options;
}

/// A ball that is felt, its frame that of the hand.
Scene ball_scene(Volume ball, const Similarity& pose = {}) {
  Scene scene;
  scene.workspace.scale = 1.0;
  scene.workspace.center_m = Vec3{};
  scene.workspace.towards_user = "+z";
  scene.workspace.up = "+y";
  const FieldRef field = scene.add("ball", std::move(ball), pose);
  scene.add("skin", SurfaceAndFriction{.field = field, .levels = {{.value = 0.0, .strength_n = 1.0}}});
  return scene;
}

std::vector<PathPoint> helix() {
  std::vector<PathPoint> path;
  for (int i = 0; i < 3000; ++i) {
    const double t = 0.01 * i;
    const Vec3 p{0.06 * std::cos(t), 0.002 * t, 0.06 * std::sin(t)};
    path.push_back({p + Vec3{0, -0.002, 0}, p, {0, 0.05 * t, 0}});
  }
  return path;
}

Moment all_primitives() {
  Moment moment{.probe_m = {0, 0.03, 0.01}, .proxy_m = {0, 0.05, 0}, .primitives = {}, .mode_names = {"skin", "wind"}};
  for (const PrimitiveKind kind : {PrimitiveKind::point, PrimitiveKind::line, PrimitiveKind::plane, PrimitiveKind::directed}) {
    PlacedPrimitive placed;
    placed.primitive.kind = kind;
    placed.primitive.id.mode = kind == PrimitiveKind::directed ? 1 : 0;
    placed.primitive.position_m = {0, 0.05, 0};
    placed.primitive.direction = {0, 1, 0};
    placed.force_n = {0, 0.5, 0};
    moment.primitives.push_back(placed);
  }
  return moment;
}

TEST(ScenePicture, IsTheSameTwiceWithAndWithoutAScreen) {
  const Scene scene = ball_scene(sphere_field());
  unsetenv("DISPLAY");
  const std::string first = png_of(scene_picture(scene, helix(), all_primitives(), small()));
  const std::string second = png_of(scene_picture(scene, helix(), all_primitives(), small()));
  setenv("DISPLAY", ":987", 1);
  const std::string third = png_of(scene_picture(scene, helix(), all_primitives(), small()));
  unsetenv("DISPLAY");
  EXPECT_GT(first.size(), 5000U);
  EXPECT_TRUE(first == second);
  EXPECT_TRUE(first == third);
}

TEST(ScenePictureDeathTest, IsTheSameInAnotherProcess) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";  // the other process starts from nothing
  const auto hash = std::to_string(
      std::hash<std::string>{}(png_of(scene_picture(ball_scene(sphere_field()), helix(), all_primitives(), small()))));
  setenv("PALPA_TEST_HASH", hash.c_str(), 0);  // 0: the other process keeps that of the first
  EXPECT_EXIT(std::exit(getenv("PALPA_TEST_HASH") == hash ? 0 : 1), testing::ExitedWithCode(0), "");
  unsetenv("PALPA_TEST_HASH");
}

TEST(ScenePictureDeathTest, WithoutOpenGlSaysWhatToInstallAndNothingElse) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  const auto draw = [] {
    try {
      scene_picture(Scene(), helix(), {}, small());
      std::exit(1);
    } catch (const LoadError& error) {
      std::fprintf(stderr, "[%s]", error.what());
      std::exit(2);
    }
  };
  for (const auto* variable : {"__EGL_VENDOR_LIBRARY_DIRS", "LIBGL_DRIVERS_PATH"}) {
    setenv(variable, "/nonexistent", 1);
    EXPECT_EXIT(draw(), testing::ExitedWithCode(2), "^\\[pictures: no OpenGL [^\n]*; install libgl1-mesa-dri[^\n]*\\]$")
        << variable;
    unsetenv(variable);
  }
}

TEST(ScenePicture, ShowsAPathWhereItIs) {
  const Scene scene;
  for (const Vec3& from : {Vec3{0, 0, 1}, Vec3{1, 0.2, 0.3}, Vec3{-0.4, 0.9, 0.5}, Vec3{0, -0.7, -0.7}}) {
    const ScenePictureOptions options = small(from);
    for (const Vec3& at : {Vec3{}, Vec3{0.03, 0.02, 0.01}, Vec3{-0.02, -0.05, 0.03}}) {
      const Vec3 along = normalized(cross(options.up, normalized(from)));
      std::vector<PathPoint> path;
      for (int i = -20; i <= 20; ++i) {
        const Vec3 p = at + 0.0005 * i * along;
        path.push_back({p + Vec3{10, 0, 0}, p, {0, 0, 2.0}});
      }
      const Picture picture = scene_picture(scene, path, {}, options);
      const Place place = projected(at, options);
      EXPECT_TRUE(is_dark(pixel(picture, place.x, place.y))) << "the largest force is the darkest colour";
      EXPECT_TRUE(is_ground(pixel(picture, place.x, place.y + 8)));
      EXPECT_TRUE(is_ground(pixel(picture, place.x, place.y - 8)));
      EXPECT_TRUE(is_ground(pixel(picture, place.x - 30, place.y))) << "beyond its end";
    }
  }
}

TEST(ScenePicture, ColoursAPathByForce) {
  std::vector<PathPoint> path;
  for (int i = 0; i <= 100; ++i) {
    const Vec3 p{-0.05 + 0.001 * i, 0, 0};
    path.push_back({p, p, {0, 0, 0.01 * i}});
  }
  const Picture picture = scene_picture(Scene(), path, {}, small());
  int last = 1000;
  for (const double x : {-0.045, -0.02, 0.0, 0.02, 0.045}) {
    const Place place = projected({x, 0, 0}, small());
    const Rgb rgb = pixel(picture, place.x, place.y);
    EXPECT_LT(rgb[0] + rgb[1] + rgb[2], last) << "darker with the force, at " << x;
    last = rgb[0] + rgb[1] + rgb[2];
  }
}

/// A ball of 50 mm covers exactly the disc of its outline, whatever kind of field it is.
void expect_ball_at(const Picture& picture, const Vec3& centre_m, double radius_m, const ScenePictureOptions& options) {
  const Vec3 right = normalized(cross(options.up, normalized(options.from)));
  const Vec3 up = cross(normalized(options.from), right);
  for (int i = 0; i < 16; ++i) {
    const double angle = std::numbers::pi / 8 * i;
    const Vec3 out = std::cos(angle) * right + std::sin(angle) * up;
    const Place in_place = projected(centre_m + 0.94 * radius_m * out, options);
    const Place out_place = projected(centre_m + 1.06 * radius_m * out, options);
    EXPECT_FALSE(is_ground(pixel(picture, in_place.x, in_place.y))) << i;
    EXPECT_TRUE(is_ground(pixel(picture, out_place.x, out_place.y))) << i;
  }
  const Place middle = projected(centre_m, options);
  EXPECT_FALSE(is_ground(pixel(picture, middle.x, middle.y)));
}

TEST(ScenePicture, ShowsASurfaceOfAFormulaWhereItIs) {
  for (const Vec3& from : {Vec3{0, 0, 1}, Vec3{1, 0.5, 0.2}}) {
    expect_ball_at(scene_picture(ball_scene(sphere_field(0.05)), {}, {}, small(from)), {}, 0.05, small(from));
  }
}

TEST(ScenePicture, ShowsASurfaceOfAGridWhereItIs) {
  expect_ball_at(scene_picture(ball_scene(sampled(sphere_field(0.05), 40)), {}, {}, small()), {}, 0.05, small());
}

TEST(ScenePicture, ShowsASurfaceOfAPosedFieldWhereItIs) {
  const Similarity pose{.rotation = {{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}, .scale = 0.6, .translation_m = {0.03, -0.02, 0.01}};
  expect_ball_at(scene_picture(ball_scene(sphere_field(0.05), pose), {}, {}, small()), {0.03, -0.02, 0.01}, 0.03, small());
}

TEST(ScenePicture, ShowsAVolumeWhereItIs) {
  Scene scene = ball_scene(sphere_field(0.05));
  scene.layers = {{.show = ViewLayer::Show::volume,
                   .field = {"ball"},
                   .colors = {{-0.001, "#804020", 0.0}, {0.001, "#804020", 0.9}, {0.05, "#804020", 0.9}}}};
  for (int again = 0; again < 4; ++again) {
    expect_ball_at(scene_picture(scene, {}, {}, small()), {}, 0.05, small());
  }
}

TEST(ScenePicture, FollowsTheMapFromHandToWorld) {
  Scene scene = ball_scene(sphere_field(0.05));
  scene.workspace.scale = 2.0;                       // the ball is half as large in the hand
  scene.workspace.center_m = Vec3{-0.06, 0.0, 0.0};  // and 30 mm to the right of its middle
  expect_ball_at(scene_picture(scene, {}, {}, small()), {0.03, 0, 0}, 0.025, small());
}

TEST(ScenePicture, DrawsNoWallWhereDataEnd) {
  // Value 1 in one half, no data in the other: the level 0.5 is nowhere.
  const GridGeometry geometry{
      .dims = {17, 17, 17}, .index_to_world_m = 0.005 * Mat3::identity(), .origin_m = {-0.04, -0.04, -0.04}};
  auto values = std::make_shared<std::vector<float>>(17 * 17 * 17, 1.0F);
  for (std::size_t i = 0; i < values->size(); ++i) {
    if (i % 17 > 8) (*values)[i] = std::numeric_limits<float>::quiet_NaN();
  }
  Volume half{.fields = {{"value", "", grid_field(geometry, {VoxelType::float32, 1, {values, values->data()}})}},
              .format = "grid"};
  Scene scene = ball_scene(std::move(half));
  scene.layers = {{.show = ViewLayer::Show::surface, .field = {"ball"}, .level = 0.5}};
  const Picture picture = scene_picture(scene, {}, {}, small());
  for (int y = 120; y < 240; y += 4) {
    for (int x = 160; x < 320; x += 4) EXPECT_TRUE(is_ground(pixel(picture, x, y))) << x << ' ' << y;
  }
}

TEST(ScenePicture, DrawsEveryKindOfLayerAndTheDefaults) {
  Scene scene;
  scene.add("wind", lamb_oseen_vortex());
  const FieldRef head = scene.add("head", sampled(head_phantom(), 40));
  using Show = ViewLayer::Show;
  const std::vector<ViewLayer> kinds = {{.show = Show::surface, .field = head, .level = -300.0},
                                        {.show = Show::slices, .field = head},
                                        {.show = Show::slices, .field = {"wind"}},
                                        {.show = Show::volume, .field = head},
                                        {.show = Show::streamlines, .field = {"wind"}},
                                        {.show = Show::glyphs, .field = {"wind"}}};
  ScenePictureOptions options = small();
  options.half_height_m = 0.0;
  options.centre_m.reset();
  const double bare = share_of(scene_picture(Scene(), {}, {}, options), is_ground);
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    scene.layers = {kinds[i]};
    const Picture picture = scene_picture(scene, {}, {}, options);
    EXPECT_LT(share_of(picture, is_ground), bare - 0.01) << "layer " << i;
    EXPECT_GT(share_of(picture, is_ground), 0.05) << "layer " << i;
    EXPECT_TRUE(png_of(picture) == png_of(scene_picture(scene, {}, {}, options))) << "layer " << i;
  }
  scene.layers.clear();
  EXPECT_LT(share_of(scene_picture(scene, {}, {}, options), is_ground), bare - 0.01) << "no layers, no modes";
}

TEST(ScenePicture, RefusesALayerOfTheOtherKindOfField) {
  Scene scene;
  scene.add("wind", lamb_oseen_vortex());
  scene.layers = {{.show = ViewLayer::Show::surface, .field = {"wind"}}};
  try {
    scene_picture(scene, {}, {}, small());
    FAIL() << "a surface of a vector field";
  } catch (const LoadError& error) {
    EXPECT_THAT(error.what(), HasSubstr("vector field; "));
  }
  scene.layers = {{.show = ViewLayer::Show::surface, .field = {"storm"}}};
  EXPECT_THROW(scene_picture(scene, {}, {}, small()), LoadError);
}

TEST(ScenePicture, HasMarksOfThePatientInAMedicalFrameOnly) {
  // At the middle of the left edge.
  const auto has_mark = [](const Picture& picture) {
    for (int y = 170; y < 190; ++y) {
      for (int x = 0; x < 24; ++x) {
        if (is_dark(pixel(picture, x, y))) return true;
      }
    }
    return false;
  };
  Scene scene = ball_scene(sphere_field(0.02));
  EXPECT_FALSE(has_mark(scene_picture(scene, {}, {}, small())));
  scene.find_volume("ball")->volume.medical_frame = true;
  EXPECT_TRUE(has_mark(scene_picture(scene, {}, {}, small())));
}

TEST(ScenePicture, FramesWhatIsFelt) {
  ScenePictureOptions options;
  options.width_px = 480;
  options.height_px = 360;
  std::vector<PathPoint> path = helix();
  for (PathPoint& point : path) {
    point.proxy_m += Vec3{5, -7, 3};
    point.probe_m += Vec3{5, -7, 3};
    point.force_n = {0, 3, 0};
  }
  const Picture picture = scene_picture(Scene(), path, {}, options);
  int dark = 0;
  for (int y = 60; y < 330; ++y) {
    for (int x = 40; x < 400; ++x) dark += is_dark(pixel(picture, x, y));
  }
  EXPECT_GT(dark, 1500);
}

TEST(ScenePicture, RefusesACameraWithoutADirection) {
  ScenePictureOptions options = small({0, 1, 0});
  EXPECT_THROW(scene_picture(Scene(), {}, {}, options), LoadError);
  options.from = {};
  EXPECT_THROW(scene_picture(Scene(), {}, {}, options), LoadError);
  options = small();
  options.width_px = -3;
  EXPECT_THROW(scene_picture(Scene(), {}, {}, options), LoadError);
}

TEST(ScenePicture, LivesWithForcesAndPlacesThatAreNotFinite) {
  std::vector<PathPoint> path = helix();
  path[5].proxy_m.x = std::numeric_limits<double>::quiet_NaN();
  path[700].force_n.z = std::numeric_limits<double>::infinity();
  EXPECT_LT(share_of(scene_picture(Scene(), path, {}, small()), is_ground), 0.98);
}

TEST(Png, IsWrittenAsItIs) {
  Picture picture{3, 2, {255, 0, 0, 0, 255, 0, 0, 0, 255, 1, 2, 3, 4, 5, 6, 7, 8, 9}};
  const std::string png = png_of(picture);
  EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(png.find("tIME"), png.npos);
  const std::string file = testing::TempDir() + "palpa_picture.png";
  save_png(picture, file);
  std::ifstream in(file, std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), png);
  EXPECT_THROW(save_png(picture, "/nonexistent/a.png"), LoadError);
}

}  // namespace
}  // namespace palpa
