// Maps of forces: closed forms of a ball and a viscous medium; independence of threads and pieces.
#include "palpa/study/map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpa/data/analytic.h"
#include "palpa/mode/modes.h"
#include "palpa/study/feeler.h"
#include "palpa/study/map_file.h"
#include "study_fixture.h"

namespace palpa {
namespace map_test {

using testing::HasSubstr;

constexpr double radius_m = 0.05, stiffness_n_per_m = 500.0, limit_n = 3.3;

/// A ball about the middle of the workspace as one rigid shell.
Scene ball(double strength_n, double damping_ns_per_m = 0.0) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m, .damping_ns_per_m = damping_ns_per_m, .max_force_n = limit_n});
  const FieldRef depth = scene.add("ball", sphere_field(radius_m));
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}, .towards_user = "+z", .up = "+y"});
  scene.add("shell", SurfaceAndFriction{.field = depth, .levels = {{.name = "shell", .strength_n = strength_n}}});
  return scene;
}

ForceMap felt(const Scene& scene, const MapLattice& lattice, int threads = 2) {
  ForceMap map(lattice);
  feel_map(scene, map, {.threads = threads});
  return map;
}

// A tool arrives upright, with all its feet outside: before a ball its foremost foot is the hand of a point's map.
TEST(Map, ATipBeforeTheHandFeelsWhatAPointDoesThere) {
  const double tip_m = 0.03;
  Scene tool = ball(100.0);
  tool.set(
      ToolOptions{.shape = ToolOptions::Shape::points, .points_m = {{0, 0, -tip_m}, {0, 0, 0.02}}, .turning_radius_m = 1.0});
  MapLattice at{.points = {1, 1, 9}, .low_m = {0.0, 0.0, 0.04}, .spacing_m = 1e-3};
  const ForceMap point = felt(ball(100.0), at);
  at.low_m.z += tip_m;
  const ForceMap tip = felt(tool, at);
  for (std::size_t n = 0; n < point.points.size(); ++n) {
    EXPECT_LT(distance(tip.points[n].steady_n, point.points[n].steady_n), 1e-6) << n;
    EXPECT_FALSE(tip.points[n].unsettled);
  }
  EXPECT_GT(norm(tip.points.front().steady_n), 1.0);
}

TEST(Map, ABallPushesAwayFromItsMiddleAsFarAsTheHandIsInIt) {
  const ForceMap map = felt(ball(100.0), map_slice(0, 0.0, 0.16, 65));
  ASSERT_TRUE(map.is_whole());
  int inside = 0;
  for (int j = 0; j < 65; ++j) {
    for (int k = 0; k < 65; ++k) {
      const Vec3 place_m = map.lattice.place_m(0, j, k);
      const MapPoint& point = map.points[map.lattice.number(0, j, k)];
      EXPECT_LE(norm(point.first_contact_n), limit_n * (1 + 1e-12));
      EXPECT_EQ(point.broken_levels, 0);
      EXPECT_FALSE(point.unsettled);
      const double depth_m = radius_m - norm(place_m);
      if (depth_m < 0.0 && place_m.z > 0.0) {
        EXPECT_LT(norm(point.steady_n), 1e-9) << place_m.y << " " << place_m.z;
      }
      // A smoothing spline lies below a ball's crown by about spacing²/(6 R).
      if (depth_m < 1e-3 || depth_m > 6e-3 || place_m.z < 0.01) continue;
      ++inside;
      const Vec3 expected_n = (stiffness_n_per_m * depth_m / norm(place_m)) * place_m;
      EXPECT_LT(distance(point.steady_n, expected_n), 0.12 + 0.05 * norm(expected_n)) << place_m.y << " " << place_m.z;
      EXPECT_NEAR(stiffness_n_per_m * point.proxy_distance_m, norm(point.steady_n), 1e-6);
    }
  }
  EXPECT_GT(inside, 50);
}

TEST(Map, WhatADrivenHandFeelsOfSyrupIsGoneWhenItIsHeld) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m, .damping_ns_per_m = 0.0, .max_force_n = limit_n});
  const FieldRef depth = scene.add("ball", sphere_field(radius_m));
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}, .towards_user = "+z", .up = "+y"});
  constexpr double drag_ns_per_m = 4.0;
  scene.add("syrup", Viscosity{.field = depth, .drag_ns_per_m = drag_ns_per_m});
  const ForceMap map = felt(scene, map_slice(0, 0.0, 0.06, 25));
  const double speed_m_per_s = detail::way_step_m / detail::way_step_s;
  const MapPoint& middle = map.points[map.lattice.number(0, 12, 2)];
  EXPECT_NEAR(middle.first_contact_n.z, drag_ns_per_m * speed_m_per_s, 0.02) << "towards where the hand comes from";
  EXPECT_LT(norm(middle.steady_n), 1e-3);
  EXPECT_FALSE(middle.unsettled);
}

TEST(Map, AShellThatLetsGoIsToldBehindIt) {
  const ForceMap map = felt(ball(0.5), map_slice(0, 0.0, 0.12, 41));
  const MapPoint& before = map.points[map.lattice.number(0, 20, 40)];
  const MapPoint& behind = map.points[map.lattice.number(0, 20, 20)];
  EXPECT_EQ(before.broken_levels, 0);
  EXPECT_GE(behind.broken_levels, 1);
  EXPECT_LT(norm(behind.steady_n), 1e-6);
}

TEST(Map, IsTheSameToTheBitByAnyNumberOfThreadsAndInAnyPieces) {
  const Scene scene = ball(1.0, 0.5);
  const MapLattice lattice = map_slice(1, 0.0, 0.12, 33);
  const ForceMap once = felt(scene, lattice, 1);
  EXPECT_EQ(felt(scene, lattice, 3).points, once.points);

  ForceMap pieces(lattice);
  std::atomic<bool> stop = false;
  std::int64_t points = 0;
  int runs = 0;
  for (; !pieces.is_whole(); ++runs) {
    stop = false;
    int ways = 0;
    const MapWork work =
        feel_map(scene, pieces, {.threads = 2, .stop = &stop, .progress = [&](double) { stop = ++ways >= 10; }});
    EXPECT_GT(work.points, 0);
    points += work.points;
  }
  EXPECT_GT(runs, 1);
  EXPECT_EQ(points, lattice.count()) << "nothing twice";
  EXPECT_EQ(pieces.points, once.points);
}

TEST(Map, ASliceIsAPlaneOfTheGrid) {
  const Scene scene = ball(1.0);
  const ForceMap grid = felt(scene, map_grid(0.12, 17));
  for (const int axis : {0, 1}) {
    const ForceMap slice = felt(scene, map_slice(axis, 0.0, 0.12, 17));
    for (int n = 0; n < 17; ++n)
      for (int k = 0; k < 17; ++k) {
        const int i = axis == 0 ? 8 : n, j = axis == 0 ? n : 8;
        EXPECT_EQ(slice.points[slice.lattice.number(axis == 0 ? 0 : n, axis == 0 ? n : 0, k)],
                  grid.points[grid.lattice.number(i, j, k)]);
      }
  }
  // Across z each point has a path of its own, with other steps: an equal position, within a step's error.
  const ForceMap across = felt(scene, map_slice(2, 0.045, 0.12, 17));
  const ForceMap along = felt(scene, map_slice(0, 0.0, 0.09, 17));  // its last point is at z = 45 mm
  EXPECT_NEAR(along.lattice.place_m(0, 8, 16).z, 0.045, 1e-12);
  EXPECT_LT(
      distance(across.points[across.lattice.number(8, 8, 0)].steady_n, along.points[along.lattice.number(0, 8, 16)].steady_n),
      1e-3);
}

TEST(Map, RefusesWhatIsNoMap) {
  const auto problem_with = [](const auto& make) -> std::string {
    try {
      make();
    } catch (const LoadError& error) {
      return error.what();
    }
    return "";
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(problem_with([] { map_slice(0, 0.0, 0.1, 1); }), HasSubstr("2 or more"));
  for (const double size_m : {0.0, -1.0, 2.0, nan})
    EXPECT_THAT(problem_with([&] { map_slice(0, 0.0, size_m, 8); }), HasSubstr("at most 1000 mm"));
  EXPECT_THAT(problem_with([] { map_slice(0, nan, 0.1, 8); }), HasSubstr("within 1000 mm"));
  EXPECT_THAT(problem_with([] { map_grid(0.1, 1000); }), HasSubstr("--points"));
  EXPECT_THAT(problem_with([] { map_grid(0.1, 1000, 64); }), HasSubstr("more parts"));
  EXPECT_EQ(problem_with([] { map_grid(0.1, 1000, 128); }), "");
  EXPECT_THAT(problem_with([] { map_slice(2, 0.0, 0.1, 40000, 1 << 20); }), HasSubstr("32768"));
}

TEST(Map, WhatEndsItsKeepingEndsIt) {
  const Scene scene = ball(1.0);
  ForceMap map(map_slice(0, 0.0, 0.12, 9));
  EXPECT_THROW(feel_map(scene, map, {.threads = 2, .progress = [](double) { throw LoadError("full"); }}), LoadError);
}

TEST(Map, PartsAreBlocksOfAllPaths) {
  const MapLattice lattice{.points = {37, 21, 2}};
  for (const int of : {1, 2, 7, 800}) {
    std::vector<int> ways;
    for (int part = 1; part <= of; ++part) {
      for (const int way : ways_of(lattice, {part, of})) ways.push_back(way);
    }
    std::ranges::sort(ways);
    ASSERT_EQ(ways.size(), 37u * 21u);
    for (int n = 0; n < 37 * 21; ++n) ASSERT_EQ(ways[static_cast<std::size_t>(n)], n);
  }
  const std::vector<int> block = ways_of({.points = {64, 64, 1}}, {6, 64});
  ASSERT_EQ(block.size(), 64u);
  for (const int way : block) EXPECT_TRUE(way % 64 / 8 == 3 && way / 64 / 8 == 0) << way;
}

class MapFile : public StudyTest {
 protected:
  const Scene scene = ball(1.0);
  const MapLattice lattice = map_slice(0, 0.0, 0.12, 17);
  const std::string identity = identity_of_map(scene, {}, lattice);

  ForceMap half() const {
    ForceMap map(lattice);
    std::atomic<bool> stop = false;
    feel_map(scene, map, {.threads = 1, .stop = &stop, .progress = [&](double share) { stop = share > 0.4; }});
    EXPECT_FALSE(map.is_whole());
    return map;
  }
};

TEST_F(MapFile, WhatIsKeptIsTakenAndGoesOnToTheSameMap) {
  const ForceMap kept = half();
  keep_map(kept, identity, folder / "map.part");
  ForceMap map(lattice);
  ASSERT_EQ(take_kept_map(map, identity, folder / "map.part"), KeptMap::taken);
  EXPECT_EQ(map.done, kept.done);
  feel_map(scene, map);
  EXPECT_EQ(map.points, felt(scene, lattice).points);
}

TEST_F(MapFile, WhatIsOfAnotherMapIsNotTaken) {
  keep_map(half(), identity, folder / "map.part");
  ForceMap map(lattice);
  EXPECT_EQ(take_kept_map(map, identity, folder / "nothing"), KeptMap::none);
  EXPECT_EQ(take_kept_map(map, identity_of_map(ball(2.0), {}, lattice), folder / "map.part"), KeptMap::another);
  ForceMap larger(map_slice(0, 0.0, 0.13, 17));
  EXPECT_EQ(take_kept_map(larger, identity_of_map(scene, {}, larger.lattice), folder / "map.part"), KeptMap::another);
  EXPECT_EQ(map.points, ForceMap(lattice).points) << "untouched";
}

TEST_F(MapFile, WhatIsCutShortOrDamagedIsNotTaken) {
  keep_map(half(), identity, folder / "map.part");
  const std::string whole = read(folder / "map.part");
  const std::size_t title = whole.find('\n') + 1, flags = whole.find('\0') + 1;
  for (const std::size_t bytes : {title, title + 20, flags - 1, flags + 3, whole.size() / 2, whole.size() - 1}) {
    write("cut.part", whole.substr(0, bytes));
    ForceMap map(lattice);
    EXPECT_EQ(take_kept_map(map, identity, folder / "cut.part"), KeptMap::another) << bytes;
  }
  std::string odd = whole;
  odd[flags] = '\7';
  for (const std::string& other : {whole + "x", whole + std::string(1 << 20, '\1'), odd}) {
    write("long.part", other);
    ForceMap map(lattice);
    EXPECT_EQ(take_kept_map(map, identity, folder / "long.part"), KeptMap::another);
    EXPECT_EQ(map.points, ForceMap(lattice).points) << "untouched";
  }
}

TEST_F(MapFile, WhatSomebodyElseKeepsThereIsRefused) {
  ForceMap map(lattice);
  for (const char* text : {"", "my notes", "palpa: a map of"}) {
    write("map.part", text);
    EXPECT_THROW(take_kept_map(map, identity, folder / "map.part"), LoadError) << text;
    EXPECT_EQ(read(folder / "map.part"), text);
  }
  EXPECT_THROW(take_kept_map(map, identity, folder), LoadError) << "a folder";
}

TEST_F(MapFile, TheSameMapIsTheSameBytes) {
  const Similarity turned{rotation_about({0, 1, 0}, 30.0), 2.0, {1, 2, 3}};
  write_map(felt(scene, lattice, 1), turned, folder / "one.vti", detail::Existing::refused);
  write_map(felt(scene, lattice, 2), turned, folder / "two.vti", detail::Existing::refused);
  EXPECT_EQ(read(folder / "one.vti"), read(folder / "two.vti"));
  EXPECT_THAT(read(folder / "one.vti"), testing::Not(HasSubstr("appended"))) << "ParaView of Debian 12 does not open that";
  EXPECT_THROW(write_map(felt(scene, lattice), turned, folder / "one.vti", detail::Existing::refused), LoadError);
}

}  // namespace map_test
}  // namespace palpa
