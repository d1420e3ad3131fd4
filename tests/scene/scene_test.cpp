#include "palpa/scene/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "palpa/data/grid.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "scene_files.h"

namespace palpa {
namespace scene_test {

using testing::HasSubstr;
using testing::StartsWith;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

/// A ball over a box of unequal sides, off the origin.
Volume brick(double size_m, bool medical = false) {
  GridGeometry geometry;
  geometry.dims = {5, 3, 2};
  geometry.index_to_world_m = size_m * Mat3::identity();
  geometry.origin_m = {size_m, -2 * size_m, 3 * size_m};
  auto voxels = std::make_shared<std::array<float, 30>>();
  for (std::size_t i = 0; i < voxels->size(); ++i) (*voxels)[i] = static_cast<float>(i);
  Volume volume;
  volume.fields = {
      {"brick", "", grid_field(geometry, {VoxelType::float32, 1, std::shared_ptr<const void>(voxels, voxels->data())})}};
  volume.medical_frame = medical;
  volume.format = "grid";
  return volume;
}

template <class Action>
std::string error_of(Action&& action) {
  try {
    action();
  } catch (const SceneError& error) {
    return error.what();
  }
  return "no error";
}

Scene scene_of(Volume volume, Workspace workspace = {}) {
  Scene scene;
  scene.add("v", std::move(volume));
  scene.set(std::move(workspace));
  return scene;
}

// ---- Workspace

TEST(Workspace, FitsTheFirstVolumeByDefault) {
  for (const double size_m : {1e-10, 0.001, 1.0, 1e6}) {
    Scene scene = scene_of(brick(size_m));
    scene.add("other", sphere_field());
    const Similarity map = scene.hand_to_world();
    const Box box = scene.volumes()[0].volume.bounds_m();
    EXPECT_TRUE(is_usable(map));
    EXPECT_NEAR(largest_component(box.size_m()) / map.scale, 0.15, 1e-15);
    EXPECT_LT(norm(map.to_hand(box.centre_m())), 1e-15);
    EXPECT_EQ(map.rotation, Mat3::identity());
  }
}

TEST(Workspace, FitsAndCentersWhatItIsTold) {
  Scene scene = scene_of(brick(0.01));
  scene.add("ball", sphere_field(), {Mat3::identity(), 2.0, {1, 2, 3}});
  scene.edit<Workspace>([&](auto& workspace) { workspace.fit = "ball"; });
  EXPECT_EQ(scene.hand_to_world().to_world({}), (Vec3{1, 2, 3}));
  EXPECT_NEAR(scene.hand_to_world().scale, largest_component(scene.volumes()[1].volume.bounds_m().size_m()) / 0.15, 1e-12);
  scene.edit<Workspace>([&](auto& workspace) { workspace.center_volume = "v"; });
  EXPECT_EQ(scene.hand_to_world().to_world({}), scene.volumes()[0].volume.bounds_m().centre_m());
  scene.edit<Workspace>([&](auto& workspace) { workspace.center_volume.clear(), workspace.center_m = Vec3{7, 8, 9}; });
  EXPECT_EQ(scene.hand_to_world().to_world({}), (Vec3{7, 8, 9}));
  scene.edit<Workspace>([&](auto& workspace) { workspace.fit.clear(), workspace.scale = 1.6; });
  EXPECT_EQ(scene.hand_to_world().scale, 1.6);
  scene.edit<Workspace>([&](auto& workspace) { workspace.center_m.reset(); });
  EXPECT_EQ(scene.hand_to_world().to_world({}), scene.volumes()[0].volume.bounds_m().centre_m());
}

TEST(Workspace, AFaceLooksAtTheUserWithTheHeadUp) {
  const Similarity map = scene_of(brick(0.01, true)).hand_to_world();
  // LPS: the face looks along -y, the head is at +z. A patient facing the user has the left on the user's right.
  EXPECT_EQ(map.turned_to_world({0, 0, 1}), (Vec3{0, -1, 0}));
  EXPECT_EQ(map.turned_to_world({0, 1, 0}), (Vec3{0, 0, 1}));
  EXPECT_EQ(map.turned_to_world({1, 0, 0}), (Vec3{1, 0, 0}));
}

TEST(Workspace, TurnsProperlyForEveryPairOfDirections) {
  const std::pair<const char*, Vec3> directions[] = {
      {"left", {1, 0, 0}},     {"right", {-1, 0, 0}},    {"posterior", {0, 1, 0}}, {"anterior", {0, -1, 0}},
      {"superior", {0, 0, 1}}, {"inferior", {0, 0, -1}}, {"+x", {1, 0, 0}},        {"-x", {-1, 0, 0}},
      {"+y", {0, 1, 0}},       {"-y", {0, -1, 0}},       {"+z", {0, 0, 1}},        {"-z", {0, 0, -1}}};
  int maps = 0;
  for (const auto& [towards_user, z] : directions) {
    for (const auto& [up, y] : directions) {
      const Scene scene =
          scene_of(brick(0.01, true),
                   {.fit = {}, .scale = {}, .center_volume = {}, .center_m = {}, .towards_user = towards_user, .up = up});
      if (dot(y, z) != 0.0) {
        EXPECT_THAT(error_of([&] { scene.hand_to_world(); }), HasSubstr("lie along one axis"));
        continue;
      }
      const Similarity map = scene.hand_to_world();
      EXPECT_TRUE(is_usable(map));
      EXPECT_EQ(determinant(map.rotation), 1.0);
      EXPECT_EQ(map.turned_to_world({0, 0, 1}), z);
      EXPECT_EQ(map.turned_to_world({0, 1, 0}), y);
      EXPECT_EQ(map.direction_to_hand(z), (Vec3{0, 0, 1}));
      ++maps;
    }
  }
  EXPECT_EQ(maps, 12 * 8);
}

TEST(Workspace, PowersOfTwoChangeNoBit) {
  const Similarity map = scene_of(brick(0.013, true)).hand_to_world();
  const Vec3 hand_m{0.011, -0.023, 0.017};
  for (int power = -30; power <= 23; ++power) {
    const double factor = std::ldexp(1.0, power);
    const Similarity scaled = scene_of(brick(0.013 * factor, true)).hand_to_world();
    EXPECT_EQ(scaled.scale, factor * map.scale);
    EXPECT_EQ(scaled.to_world(hand_m), factor * map.to_world(hand_m));
    EXPECT_EQ(scaled.rotation, map.rotation);
  }
}

TEST(Workspace, WithoutVolumesIsTheIdentity) { EXPECT_EQ(Scene().hand_to_world(), Similarity{}); }

TEST(Workspace, RefusesWhatCannotBe) {
  const auto error = [](const Workspace& workspace, bool medical = false) {
    return error_of([&] { scene_of(brick(0.01, medical), workspace).hand_to_world(); });
  };
  Workspace w;
  w.up = "superior";
  EXPECT_THAT(error(w), StartsWith("workspace: 'superior' is a medical word, and volume 'v' has no medical frame; use"));
  EXPECT_EQ(error(w, true), "no error");
  w = {};
  w.up = "upwards";
  EXPECT_THAT(error(w), HasSubstr("'upwards' is no direction; "));
  w = {};
  w.fit = "w";
  EXPECT_THAT(error(w), HasSubstr("no volume 'w'; there are: v"));
  for (const double scale : {0.0, -1.0, nan, inf}) {
    w = {};
    w.scale = scale;
    EXPECT_THAT(error(w), HasSubstr("it must be above 0")) << scale;
  }
  w = {};
  w.center_m = Vec3{0, nan, 0};
  EXPECT_THAT(error(w), HasSubstr("not finite"));
  w = {};
  w.fit = "v";
  w.scale = 1;
  EXPECT_THAT(error(w), HasSubstr("both 'fit' and 'scale'"));
}

// ---- Building a scene in code

TEST(Scene, IsBuiltAsTheReadmeSays) {
  Scene scene({.stiffness_n_per_m = 400});
  const auto head = scene.add("head", head_phantom());
  EXPECT_EQ(head.name, "head");
  SurfaceAndFriction skin;
  skin.field = head;
  skin.levels = {{.name = {}, .value = -300, .strength_n = 0.8, .friction_n = 0.1, .friction_coefficient = {}}};
  scene.add("skin", skin);
  EXPECT_EQ(scene.coupling().stiffness_n_per_m, 400);
  EXPECT_TRUE(scene.check().empty());
  EXPECT_EQ(scene.index_of(head), 0);
  EXPECT_EQ(scene.field(head).field, scene.volumes()[0].volume.fields[0].field);
}

TEST(Scene, CountsFieldsOverAllVolumes) {
  Scene scene;
  Volume two = sphere_field();
  two.fields = {{"a", "", sphere_field().fields[0].field}, {"b", "", plane_field().fields[0].field}};
  EXPECT_EQ(scene.add("first", two).name, "first.a");
  EXPECT_EQ(scene.add("second", sphere_field()).name, "second");
  EXPECT_EQ(scene.add("third", two).name, "third.a");
  EXPECT_EQ(scene.index_of({"first.b"}), 1);
  EXPECT_EQ(scene.index_of({"second"}), 2);
  EXPECT_EQ(scene.index_of({"third.b"}), 4);
  const std::string own = "second." + sphere_field().fields[0].name;
  EXPECT_EQ(scene.index_of({own}), 2);
  EXPECT_THAT(error_of([&] { scene.index_of({"first"}); }), HasSubstr("several fields; name one of: first.a, first.b"));
  EXPECT_THAT(error_of([&] { scene.field({"first.c"}); }), HasSubstr("no field 'first.c'; did you mean"));
  EXPECT_THAT(error_of([&] { scene.field({""}); }), HasSubstr("no volume ''"));
}

TEST(Scene, RefusesVolumesThatCannotBe) {
  Scene scene;
  scene.add("v", sphere_field());
  EXPECT_THAT(error_of([&] { scene.add("v", sphere_field()); }), HasSubstr("volume name 'v' is taken"));
  for (const char* name : {"", "a.b", "1a", "a b", "f(x)", "é"}) {
    EXPECT_THAT(error_of([&] { scene.add(name, sphere_field()); }), HasSubstr("is no plain word")) << name;
  }
  EXPECT_THAT(error_of([&] { scene.add("empty", Volume{}); }), HasSubstr("has no fields"));
  Volume null = sphere_field();
  null.fields[0].field = nullptr;
  EXPECT_THAT(error_of([&] { scene.add("null", null); }), HasSubstr("has no data"));
  Volume twins = sphere_field();
  twins.fields.push_back(twins.fields[0]);
  EXPECT_THAT(error_of([&] { scene.add("twins", twins); }), HasSubstr("two fields"));
  EXPECT_THAT(error_of([&] {
                scene.add("mirror", sphere_field(), {-1.0 * Mat3::identity(), 1, {}});
              }),
              HasSubstr("no similarity"));
  EXPECT_EQ(scene.volumes().size(), 1u);
}

TEST(Scene, RefusesModesThatCannotBe) {
  Scene scene;
  const FieldRef ball = scene.add("ball", sphere_field());
  const FieldRef flow = scene.add("flow", lamb_oseen_vortex());
  const auto error = [&](Mode mode, std::vector<Mask> masks = {}) {
    return error_of([&] { Scene(scene).add("m", std::move(mode), std::move(masks)); });
  };
  const auto viscosity = [](Strength strength) {
    Viscosity mode;
    mode.strength_n = std::move(strength);
    return mode;
  };
  EXPECT_EQ(error(viscosity(1.0)), "no error");
  for (const double strength : {-1.0, 1e9, nan, inf})
    EXPECT_THAT(error(viscosity(strength)), HasSubstr("'strength_n' in mode 'm' is"));
  EXPECT_THAT(error(viscosity(0.0)), HasSubstr("mode 'm': neither strength_n nor drag"));
  EXPECT_THAT(error(viscosity({ball, {}})), HasSubstr("function without points"));
  EXPECT_THAT(error(viscosity({ball, TransferFunction({{0, -1}})})), HasSubstr("'strength_n' in mode 'm' is -1"));
  EXPECT_THAT(error(viscosity({ball, TransferFunction({{0, 1}}, -2)})), HasSubstr("'strength_n' in mode 'm' is -2"));
  EXPECT_THAT(error(viscosity({flow, TransferFunction({{0, 1}})})),
              HasSubstr("must be a scalar field; 'flow' is a vector field"));
  EXPECT_THAT(error(viscosity({{"gone"}, TransferFunction({{0, 1}})})), HasSubstr("no volume 'gone'"));
  EXPECT_THAT(error(viscosity(1.0), {{ball, TransferFunction({{0, 2}})}}),
              HasSubstr("'mask' in mode 'm' is 2; it must be between 0 and 1"));
  EXPECT_THAT(error(viscosity(1.0), {{ball, {}}}), HasSubstr("'mask' in mode 'm' is a function without points"));
  EXPECT_THAT(error(viscosity(1.0), {{flow, TransferFunction({{0, 1}})}}), HasSubstr("must be a scalar field"));
  EXPECT_THAT(error(Follow{}), HasSubstr("'field' in mode 'm' names no field"));
  Follow follow;
  follow.field = ball;
  EXPECT_THAT(error(follow), HasSubstr("must be a vector field; 'ball' is a scalar field"));
  SurfaceAndFriction surface;
  surface.field = ball;
  surface.levels = {{.name = "a", .value = nan, .strength_n = 1.0, .friction_n = {}, .friction_coefficient = {}}};
  EXPECT_THAT(error(surface), HasSubstr("'value' in level 'a' of mode 'm' is not finite"));
  scene.add("m", viscosity(1.0));
  EXPECT_THAT(error_of([&] { scene.add("m", viscosity(1.0)); }), HasSubstr("mode name 'm' is taken"));
}

TEST(Scene, IsValidAtAnyTime) {
  Scene scene;
  scene.add("ball", sphere_field());
  Viscosity thick;
  thick.strength_n = 1.0;
  scene.add("m", thick);
  scene.add("n", thick);
  EXPECT_TRUE(scene.check().empty());
  const std::string before = to_toml(scene);
  EXPECT_THAT(error_of([&] { scene.set(CouplingOptions{.stiffness_n_per_m = nan}); }), HasSubstr("'stiffness_n_per_m' is nan"));
  EXPECT_THAT(error_of([&] { scene.set_law("no-force"); }), HasSubstr("no law 'no-force'; there are: exact, paper-2005"));
  EXPECT_THAT(error_of([&] { scene.set(Workspace{.scale = 0.0}); }), StartsWith("workspace: 'scale' is 0"));
  EXPECT_THAT(error_of([&] { scene.edit<Viscosity>("m", [](auto& m) { m.strength_n = -1.0; }); }),
              HasSubstr("'strength_n' in mode 'm' is -1"));
  EXPECT_THAT(error_of([&] { scene.edit<Viscosity>("m", [](auto& m) { m.field = {"bal"}; }); }),
              HasSubstr("did you mean 'ball'?"));
  EXPECT_THAT(error_of([&] { scene.edit_mode("m", [](SceneMode& m) { m.name = "n"; }); }), HasSubstr("name 'n' is taken"));
  EXPECT_THAT(error_of([&] { scene.edit_mode("o", [](SceneMode&) {}); }), HasSubstr("no mode 'o'"));
  EXPECT_EQ(to_toml(scene), before) << "nothing is changed";
  scene.set(Workspace{.fit = "bal"});  // a volume that may still come
  EXPECT_THAT(error_of([&] { scene.check(); }), HasSubstr("did you mean 'ball'?"));
  EXPECT_EQ(scene.find_mode("o"), nullptr);
  EXPECT_EQ(scene.find_volume("ball")->name, "ball");
}

TEST(Scene, AcceptsTheCouplingsThatTheCouplingAccepts) {
  const double values[] = {
      -1,  0,  std::numeric_limits<double>::denorm_min(), 1, 100, std::nextafter(100, 200), 1e5, std::nextafter(1e5, 2e5),
      nan, inf};
  for (double CouplingOptions::*member : {&CouplingOptions::stiffness_n_per_m, &CouplingOptions::damping_ns_per_m,
                                          &CouplingOptions::max_force_n, &CouplingOptions::impact_ns_per_m}) {
    for (const double value : values) {
      CouplingOptions coupling;
      coupling.*member = value;
      EXPECT_EQ(error_of([&] { Scene{coupling}; }) == "no error", problem_with(coupling) == nullptr) << value;
    }
  }
}

TEST(Scene, IsAValue) {
  Scene scene;
  const FieldRef ball = scene.add("ball", sphere_field());
  Scene copy = scene;
  EXPECT_TRUE(copy == scene);
  EXPECT_EQ(copy.volumes()[0].volume.fields[0].field, scene.volumes()[0].volume.fields[0].field);
  Viscosity thick;
  thick.field = ball;
  thick.strength_n = 1.0;
  copy.add("m", thick);
  EXPECT_TRUE(scene.modes().empty());
  EXPECT_FALSE(copy == scene);
  Scene others;
  others.add("ball", sphere_field());
  EXPECT_FALSE(others == scene) << "data from code is the same only where it is shared";
}

TEST(Scene, PrintsAPoseFromCode) {
  // Through the text and back the pose is equal, for any axis and angle, half turns included.
  for (const Vec3 axis : {Vec3{1, 0, 0}, Vec3{0, -1, 0}, Vec3{1, 2, 3}, Vec3{-1, 1e-3, 0.5}}) {
    for (const double degrees : {0.0, 1e-3, 30.0, 90.0, 179.999999, 180.0, 270.0}) {
      const Vec3 a = normalized(axis);
      const double c = std::cos(degrees * std::numbers::pi / 180), s = std::sin(degrees * std::numbers::pi / 180);
      const Mat3 across{{{0, -a.z, a.y}, {a.z, 0, -a.x}, {-a.y, a.x, 0}}};
      Mat3 rotation = (1 - c) * (across * across);
      for (int i = 0; i < 3; ++i) rotation.row[i] += Mat3::identity().row[i] + s * across.row[i];
      Scene scene;
      Volume volume = sphere_field();
      volume.files = {{"/dev/null", 0, ""}};
      scene.add("v", volume, {rotation, 1.5, {0.25, 0.5, -1}});
      Viscosity thick;
      thick.strength_n = 1.0;
      scene.add("m", thick);
      const Similarity again = test::parse(to_toml(scene)).scene.volumes()[0].pose;
      for (int i = 0; i < 3; ++i) EXPECT_LT(distance(again.rotation.row[i], rotation.row[i]), 1e-12) << to_toml(scene);
      EXPECT_EQ(again.scale, 1.5);
      EXPECT_EQ(again.translation_m, (Vec3{0.25, 0.5, -1}));
    }
  }
}

// ---- Reference

TEST(Reference, ShowsEveryParameterOfEveryMode) {
  const std::string scene = scene_reference_markdown(standard_modes());
  for (const Mode& mode : standard_modes().modes()) {
    EXPECT_THAT(scene, HasSubstr("| [`" + std::string(mode.type()) + "`](modes/"));
    struct Names : ParameterVisitor {
      void number(const ParameterInfo& info, double&) override { names.emplace_back(info.name); }
      void optional_number(const ParameterInfo& info, std::optional<double>&) override { names.emplace_back(info.name); }
      void text(const ParameterInfo& info, std::string&) override { names.emplace_back(info.name); }
      void choice(const ParameterInfo& info, int&) override { names.emplace_back(info.name); }
      void field(const ParameterInfo& info, FieldRef&) override { names.emplace_back(info.name); }
      void strength(const ParameterInfo& info, Strength&) override { names.emplace_back(info.name); }
      void list(const ParameterInfo& info, ParameterList& list) override {
        names.emplace_back(info.name);
        list.visit_default(*this);
      }
      std::vector<std::string> names;
    } names;
    Mode copy = mode;
    copy.visit(names);
    ASSERT_FALSE(names.names.empty());
    for (const std::string& name : names.names) {
      EXPECT_THAT(mode_reference_markdown(mode), HasSubstr("| `" + name + "` |"));
      EXPECT_THAT(mode_reference_text(mode), HasSubstr("\n  " + name + " "));
    }
  }
  for (const AnalyticVolume& volume : analytic_volumes())
    EXPECT_THAT(scene, HasSubstr("| `" + std::string(volume.name) + "` |"));
  for (const char* key : {"stiffness_n_per_m", "towards_user", "rotate_axis_deg", "outside", "show"})
    EXPECT_THAT(scene, HasSubstr("| `" + std::string(key) + "` |"));
}

TEST(Scene, EditChangesTheParametersOfAModeOrNothing) {
  Scene scene = scene_of(brick(0.1));
  scene.add("drag", Viscosity{.strength_n = {0.5}});
  scene.edit<Viscosity>("drag", [](Viscosity& drag) { drag.strength_n = {0.7}; });
  EXPECT_EQ(scene.find_mode("drag")->mode.as<Viscosity>()->strength_n.constant_n, 0.7);
  const Scene before = scene;
  const auto change = [](auto&) { FAIL() << "no mode to change"; };
  EXPECT_THROW(scene.edit<Viscosity>("drga", change), SceneError);
  EXPECT_THROW(scene.edit<Follow>("drag", change), SceneError);
  EXPECT_THROW(scene.edit<Viscosity>("drag",
                                     [](Viscosity& drag) {
                                       drag.strength_n = {9.0};
                                       throw std::runtime_error("x");
                                     }),
               std::runtime_error);
  EXPECT_EQ(scene, before);
}

}  // namespace scene_test
}  // namespace palpa
