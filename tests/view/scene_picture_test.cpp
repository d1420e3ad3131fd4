// Pictures of scenes: reproducible, and geometrically right.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <numbers>

#include "palpa/data/analytic.h"
#include "palpa/data/grid.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/view/colors.h"
#include "palpa/view/picture.h"
#include "palpa/view/streamlines.h"

namespace palpa {
namespace scene_picture_test {

using testing::HasSubstr;
using Rgb = std::array<int, 3>;

Rgb pixel(const Picture& picture, int x, int y) {
  const std::size_t at = 3 * (static_cast<std::size_t>(y) * picture.width_px + x);
  return {picture.rgb.at(at), picture.rgb.at(at + 1), picture.rgb.at(at + 2)};
}

/// The ground is nearly white, and no object is lighter.
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

/// Position of a point of the hand frame in a picture, from the options alone: rows from the top.
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

/// A ball under a mode, its frame that of the hand.
Scene ball_scene(Volume ball, const Similarity& pose = {}) {
  Scene scene;
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}, .towards_user = "+z", .up = "+y"});
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

/// A foot under force is red.
bool is_red(const Rgb& rgb) { return rgb[0] > 110 && rgb[0] > 2 * rgb[1] && rgb[0] > 2 * rgb[2]; }

TEST(ScenePicture, ShowsTheFeetOfAToolWhereTheyAreRedByForce) {
  Scene scene = ball_scene(sphere_field());
  const Vec3 bearing_m{-0.04, 0, 0}, free_m{0.05, 0, 0};
  scene.set(ToolOptions{.shape = ToolOptions::Shape::points, .points_m = {bearing_m, free_m}});
  PlacedPrimitive placed;
  placed.primitive.kind = PrimitiveKind::directed;
  placed.primitive.direction = {0, 0, 1};  // towards the viewer: an arrow is hidden behind its foot
  placed.force_n = {0, 0, 1.0};
  Moment moment{.probe_m = {0, 0.03, 0}, .proxy_m = {0, 0.05, 0}, .primitives = {placed}, .mode_names = {"wind"}};
  moment.proxy_turn = turn_by({0, 0, std::numbers::pi / 2});  // the first foot points down, the second up
  const Picture picture = scene_picture(scene, {}, moment, small());
  const Tool tool(scene.tool(), scene.coupling());
  const Pose proxy{moment.proxy_m, moment.proxy_turn}, probe{moment.probe_m, moment.probe_turn};
  const auto at = [&](const Vec3& p_m) { return projected(p_m, small()); };
  const Place red = at(tool.foot_m(proxy, 0)), black = at(tool.foot_m(proxy, 1)), pale = at(tool.foot_m(probe, 1));
  EXPECT_TRUE(is_red(pixel(picture, red.x, red.y)));
  EXPECT_TRUE(is_dark(pixel(picture, black.x, black.y))) << "a foot without force";
  const Rgb at_device = pixel(picture, pale.x, pale.y);
  EXPECT_FALSE(is_dark(at_device) || is_red(at_device)) << "the tool at the device is pale";
  scene.set(ToolOptions{});
  const Picture of_point = scene_picture(scene, {}, moment, small());
  EXPECT_FALSE(is_red(pixel(of_point, red.x, red.y))) << "a point has no feet";
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
      std::fputs("[drawn]", stderr);
      std::exit(1);
    } catch (const LoadError& error) {
      std::fprintf(stderr, "[%s]", error.what());
      std::exit(2);
    }
  };
  const std::string refused = "pictures: no OpenGL [^\n]*; install libgl1-mesa-dri[^\n]*";
  setenv("__EGL_VENDOR_LIBRARY_DIRS", "/nonexistent", 1);
  EXPECT_EXIT(draw(), testing::ExitedWithCode(2), "^\\[" + refused + "\\]$");
  unsetenv("__EGL_VENDOR_LIBRARY_DIRS");
  // Mesa 25 (Debian 13) holds its drivers in one library and draws nevertheless.
  setenv("LIBGL_DRIVERS_PATH", "/nonexistent", 1);
  EXPECT_EXIT(
      draw(), [](int status) { return WIFEXITED(status) && WEXITSTATUS(status) != 0; }, "^\\[(" + refused + "|drawn)\\]$");
  unsetenv("LIBGL_DRIVERS_PATH");
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

/// A ball of 50 mm covers exactly the disc of its outline, for any kind of field.
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
  // The ball is half as large in the hand, and 30 mm to the right of its middle.
  scene.edit<Workspace>([&](auto& workspace) { workspace.scale = 2.0, workspace.center_m = Vec3{-0.06, 0.0, 0.0}; });
  expect_ball_at(scene_picture(scene, {}, {}, small()), {0.03, 0, 0}, 0.025, small());
}

TEST(ScenePicture, DrawsNoWallWhereDataEnd) {
  // Value 1 in one half, no data in the other: there is no isosurface of 0.5.
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

/// Balls on a grid: value = depth in the nearest of them.
Scene balls_scene(const std::vector<std::pair<Vec3, double>>& balls) {
  constexpr int n = 61;
  const GridGeometry geometry{
      .dims = {n, n, n}, .index_to_world_m = 0.003 * Mat3::identity(), .origin_m = {-0.09, -0.09, -0.09}};
  auto values = std::make_shared<std::vector<float>>();
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        double depth_m = -1.0;
        for (const auto& [centre_m, radius_m] : balls) {
          depth_m = std::max(depth_m, radius_m - distance(centre_m, geometry.to_world({double(i), double(j), double(k)})));
        }
        values->push_back(static_cast<float>(depth_m));
      }
    }
  }
  Volume volume{.fields = {{"value", "", grid_field(geometry, {VoxelType::float32, 1, {values, values->data()}})}},
                .format = "grid"};
  Scene scene = ball_scene(std::move(volume));
  scene.layers = {{.show = ViewLayer::Show::surface, .field = {"ball"}, .level = 0.0}};
  return scene;
}

TEST(ScenePicture, LeavesOutPartsThatAreSmallBesideTheLargest) {
  const Vec3 left{-0.03, 0, 0}, right{0.05, 0, 0};
  const auto shows_right = [&](const Scene& scene) {
    const Place place = projected(right, small());
    return !is_ground(pixel(scene_picture(scene, {}, {}, small()), place.x, place.y));
  };
  Scene scene = balls_scene({{left, 0.03}, {right, 0.01}});
  EXPECT_FALSE(shows_right(scene)) << "a ninth of the surface";
  expect_ball_at(scene_picture(scene, {}, {}, small()), left, 0.03, small());
  scene.layers[0].all_parts = true;
  EXPECT_TRUE(shows_right(scene));
  EXPECT_TRUE(shows_right(balls_scene({{left, 0.03}, {right, 0.025}}))) << "a sizeable share";
  EXPECT_TRUE(shows_right(balls_scene({{right, 0.03}, {left, 0.01}}))) << "the larger stays, wherever it is";
}

bool is_like(const Rgb& a, const Rgb& b, int tolerance) {
  return std::abs(a[0] - b[0]) <= tolerance && std::abs(a[1] - b[1]) <= tolerance && std::abs(a[2] - b[2]) <= tolerance;
}

TEST(ScenePicture, LegendHasTheColourThatIsSeenOfWhatFacesTheViewer) {
  for (const double opacity : {0.3, 0.6, 1.0}) {
    Scene scene = ball_scene(plane_field());
    scene.layers = {{.show = ViewLayer::Show::surface, .field = {"ball"}, .level = 0.0, .colors = {{0.0, "#3070b0", opacity}}}};
    const Picture picture = scene_picture(scene, {}, {}, small());
    const Rgb seen = pixel(picture, 190, 200);
    const auto over_ground = [&](int color) { return static_cast<int>(std::lround(opacity * color + (1.0 - opacity) * 251)); };
    EXPECT_TRUE(is_like(seen, {over_ground(0x30), over_ground(0x70), over_ground(0xb0)}, 6)) << opacity;
    int in_legend = 0;
    for (int y = 0; y < 60; ++y) {
      for (int x = 390; x < 440; ++x) in_legend += is_like(pixel(picture, x, y), seen, 6);
    }
    EXPECT_GT(in_legend, 20) << opacity;
  }
}

TEST(ScenePicture, NothingOfTheSceneIsSeenBehindTitleAndLegend) {
  Scene scene;
  scene.title = "Round and round";
  scene.edit<Workspace>([&](auto& workspace) { workspace.fit = "wind"; });
  scene.add("wind", lamb_oseen_vortex());
  ScenePictureOptions options = small();
  options.half_height_m = 0.03;  // the vortex is larger than the picture
  const Picture picture = scene_picture(scene, {}, {}, options);
  const auto is_grey = [](const Rgb& rgb) { return std::abs(rgb[0] - rgb[1]) < 12 && std::abs(rgb[1] - rgb[2]) < 12; };
  int in_scene = 0;
  for (int y = 0; y < picture.height_px; ++y) {
    for (int x = 0; x < picture.width_px; ++x) {
      EXPECT_TRUE(y >= 20 || is_grey(pixel(picture, x, y))) << x << ' ' << y;
      EXPECT_TRUE(x <= 376 || x >= 382 || is_ground(pixel(picture, x, y))) << x << ' ' << y;
      if (x < 370) in_scene += !is_grey(pixel(picture, x, y));
    }
  }
  EXPECT_GT(in_scene, 1500);
}

/// A hand that is held on a ball of 50 mm, along a curve about a point on it.
std::vector<PathPoint> path_on_ball(const Vec3& about) {
  const Vec3 a = normalized(cross(about, {0.3, 1, 0.2}));
  const Vec3 b = cross(normalized(about), a);
  std::vector<PathPoint> path;
  for (int i = 0; i <= 200; ++i) {
    const double t = 2.0 * std::numbers::pi * i / 200.0;
    const Vec3 out = normalized(normalized(about) + 0.25 * std::cos(t) * a + 0.25 * std::sin(2 * t) * b);
    path.push_back({0.048 * out, 0.0503 * out, 1.0 * out});
  }
  return path;
}

TEST(Overview, SeesWhereTheHandTouched) {
  Scene scene = ball_scene(sphere_field(0.05));
  scene.layers = {{.show = ViewLayer::Show::surface, .field = {"ball"}, .level = 0.0, .colors = {{0.0, "#e0e0e0", 1.0}}}};
  for (const Vec3& about : {Vec3{-1, 0.2, 0.2}, Vec3{1, 0, 0.1}, Vec3{0.2, 1, 0.1}, Vec3{0, -0.6, 1}, Vec3{-0.5, -0.5, 1}}) {
    const std::vector<PathPoint> path = path_on_ball(about);
    ScenePictureOptions options = overview(scene, path);
    EXPECT_GT(normalized(options.from).z, 0.4) << "the viewer stays on the user's side";
    const ScenePictureOptions at = small(options.from);
    const Picture picture = scene_picture(scene, path, {}, at);
    int hidden = 0;
    for (std::size_t i = 0; i < path.size(); i += 10) {
      const Place place = projected(path[i].proxy_m, at);
      const Rgb rgb = pixel(picture, place.x, place.y);
      hidden += rgb[0] + rgb[1] + rgb[2] > 330;
    }
    EXPECT_LE(hidden, 1) << about.x << ' ' << about.y << ' ' << about.z;
  }
}

TEST(Overview, LooksStraightAtAPlaneAndWhereTheSceneSays) {
  Scene scene = ball_scene(sphere_field(0.05));
  std::vector<PathPoint> square;
  for (int i = 0; i <= 100; ++i) square.push_back({{0.001 * i, i < 50 ? 0.0 : 0.03, 0.02}, {0.001 * i, 0, 0.03}, {0, 0, 1}});
  EXPECT_EQ(overview(scene, square).from, (Vec3{0, 0, 1}));
  scene.view.from = Vec3{1, 0, 0};
  EXPECT_EQ(overview(scene, square).from, (Vec3{1, 0, 0}));
  scene.edit<Workspace>([&](auto& workspace) { workspace.towards_user = "+x"; });
  EXPECT_EQ(overview(scene, square).from, (Vec3{0, 0, 1}));
}

TEST(ScenePicture, ShowsTheForceThatReachedTheHandAndWhereTheGuardCutIt) {
  std::vector<PathPoint> path;
  for (int i = 0; i <= 100; ++i) {
    const Vec3 p{-0.05 + 0.001 * i, 0, 0};
    path.push_back({p, p, {0, 0, 2.0}, {0, 0, 2.0}});
  }
  const auto banded = [](const Picture& picture) {
    int blue = 0;
    for (int y = 150; y < 210; ++y) {
      for (int x = 100; x < 380; ++x) {
        const Rgb rgb = pixel(picture, x, y);
        blue += rgb[2] > rgb[0] + 90 && rgb[1] > rgb[0] + 60;
      }
    }
    return blue;
  };
  const Picture whole = scene_picture(Scene(), path, {}, small());
  EXPECT_EQ(banded(whole), 0);
  for (PathPoint& point : path) point.asked_n = {};
  EXPECT_EQ(scene_picture(Scene(), path, {}, small()).rgb, whole.rgb) << "nothing more was asked for";
  for (std::size_t i = 0; i < 50; ++i) path[i].asked_n = {0, 0, 5.0};
  EXPECT_EQ(scene_picture(Scene(), path, {}, small()).rgb, whole.rgb) << "a force on its way up to what is asked was not cut";
  for (std::size_t i = 0; i < 50; ++i) path[i].limited = true;
  const Picture cut = scene_picture(Scene(), path, {}, small());
  EXPECT_GT(banded(cut), 50);
  const Place uncut = projected({0.03, 0, 0}, small());
  EXPECT_EQ(pixel(cut, uncut.x, uncut.y), pixel(whole, uncut.x, uncut.y)) << "colours are of what reached the hand";
}

TEST(Colors, OfForcesAndSpeedsFallInLightnessAllTheWay) {
  for (const detail::ColorMap& map : {detail::force_colors(1.0), detail::magnitude_colors(0.0, 1.0)}) {
    double last = 100.0;
    for (int i = 0; i <= 100; ++i) {
      const double now = detail::lightness(map.at(0.01 * i).color);
      EXPECT_LT(now, last) << i;
      EXPECT_GT(now, last - 25.0) << i << ": evenly";
      last = now;
    }
    EXPECT_GT(detail::lightness(map.at(0.0).color) - last, 50.0);
  }
}

TEST(Streamlines, WindInVortices) {
  const FieldPtr wind = wing_wake().fields[0].field;
  const Box box = wind->bounds_m();
  const std::vector<detail::Streamline> lines = detail::streamlines(*wind, box, 80);
  EXPECT_LE(lines.size(), 80U);
  // The core of the tip vortex at y = -1.4 m is a circle of some 0.2 m in a box of 3.8 m by 1.2 m.
  const auto near_core = [](const detail::Streamline& line) {
    return std::any_of(line.begin(), line.end(), [](const detail::StreamPoint& point) {
      return point.position_m.x > 1.5 && std::hypot(point.position_m.y + 1.4, point.position_m.z) < 0.2;
    });
  };
  EXPECT_GT(std::count_if(lines.begin(), lines.end(), near_core), 8);
  EXPECT_GT(std::count_if(lines.begin(), lines.end(), [&](const auto& line) { return !near_core(line); }), 30);
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
  Volume ball = sphere_field(0.02);
  EXPECT_FALSE(has_mark(scene_picture(ball_scene(ball), {}, {}, small())));
  ball.medical_frame = true;
  EXPECT_TRUE(has_mark(scene_picture(ball_scene(ball), {}, {}, small())));
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

}  // namespace scene_picture_test
}  // namespace palpa
