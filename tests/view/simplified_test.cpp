// Surfaces in fewer triangles: as near and as closed as before.
#include "palpa/view/simplified.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

namespace palpa::detail {
namespace simplified_test {

constexpr double wide_m = 0.05, thick_m = 0.02;  // radii of the ring

/// Ring of 2 · around · across triangles.
Mesh ring(std::uint32_t around, std::uint32_t across) {
  Mesh mesh;
  const auto number = [&](std::uint32_t i, std::uint32_t j) { return (i % around) * across + j % across; };
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) {
      const double u = 2.0 * std::numbers::pi * i / around, v = 2.0 * std::numbers::pi * j / across;
      const double from_axis_m = wide_m + thick_m * std::cos(v);
      mesh.points_m.push_back({from_axis_m * std::cos(u), from_axis_m * std::sin(u), thick_m * std::sin(v)});
      mesh.triangles.push_back({number(i, j), number(i + 1, j), number(i + 1, j + 1)});
      mesh.triangles.push_back({number(i, j), number(i + 1, j + 1), number(i, j + 1)});
    }
  return mesh;
}

double from_ring_m(const Vec3& p) { return std::hypot(std::hypot(p.x, p.y) - wide_m, p.z) - thick_m; }

/// Number of triangles on each directed edge.
std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges_of(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& corner : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++edges[{corner[k], corner[(k + 1) % 3]}];
  return edges;
}

TEST(Simplified, ARingStaysOneClosedRingOnItsSurface) {
  const Mesh fine = ring(300, 120);
  for (const std::size_t most : {std::size_t{40'000}, std::size_t{10'000}, std::size_t{2000}}) {
    const SimplerMesh mesh = simplified(fine, most);
    EXPECT_LE(mesh.triangles.size(), most);
    EXPECT_GT(mesh.triangles.size() + 2, most - 2);
    const auto edges = edges_of(mesh);
    for (const auto& [edge, count] : edges) {
      EXPECT_EQ(count, 1);
      EXPECT_TRUE(edges.contains({edge.second, edge.first}));
    }
    const auto faces = static_cast<std::int64_t>(mesh.triangles.size());
    EXPECT_EQ(static_cast<std::int64_t>(mesh.points_m.size()) - static_cast<std::int64_t>(edges.size()) / 2 + faces, 0);
    // Chord of a mean triangle over the thin radius.
    const double deep_m = 4.0 * std::numbers::pi * std::numbers::pi * wide_m / static_cast<double>(faces);
    ASSERT_EQ(mesh.like.size(), mesh.points_m.size());
    for (std::size_t i = 0; i < mesh.points_m.size(); ++i) {
      EXPECT_LT(std::abs(from_ring_m(mesh.points_m[i])), 0.5 * deep_m);
      EXPECT_LT(distance(mesh.points_m[i], fine.points_m[mesh.like[i]]), 3.0 * std::sqrt(deep_m * thick_m));
    }
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vec3 middle_m = (mesh.points_m[a] + mesh.points_m[b] + mesh.points_m[c]) / 3.0;
      EXPECT_LT(std::abs(from_ring_m(middle_m)), 2.0 * deep_m);
    }
  }
}

TEST(Simplified, ASquareKeepsItsBorderAndHasTrianglesOfLikeSize) {
  constexpr std::uint32_t n = 100;
  Mesh fine;
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= n; ++i) fine.points_m.push_back({1e-3 * i, 1e-3 * j, 0.0});
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t at = j * (n + 1) + i;
      fine.triangles.push_back({at, at + 1, at + n + 2});
      fine.triangles.push_back({at, at + n + 2, at + n + 1});
    }
  const SimplerMesh mesh = simplified(fine, 2000);
  EXPECT_LE(mesh.triangles.size(), 2000u);
  double area_m2 = 0.0, largest_m2 = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const double one_m2 = 0.5 * cross(mesh.points_m[b] - mesh.points_m[a], mesh.points_m[c] - mesh.points_m[a]).z;
    EXPECT_GT(one_m2, 0.0);
    area_m2 += one_m2;
    largest_m2 = std::max(largest_m2, one_m2);
  }
  EXPECT_NEAR(area_m2, 0.01, 1e-5);
  EXPECT_LT(largest_m2, 8.0 * 0.01 / 2000);
}

TEST(Simplified, FewTrianglesStayAsTheyAreAndUnusedPointsGo) {
  Mesh fine = ring(20, 10);
  fine.points_m.insert(fine.points_m.begin(), Vec3{1.0, 1.0, 1.0});
  for (auto& triangle : fine.triangles)
    for (std::uint32_t& corner : triangle) ++corner;
  const SimplerMesh mesh = simplified(fine, fine.triangles.size());
  ASSERT_EQ(mesh.triangles.size(), fine.triangles.size());
  EXPECT_EQ(mesh.points_m.size(), 200u);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(mesh.points_m[mesh.triangles[t][k]], fine.points_m[fine.triangles[t][k]]);
      EXPECT_EQ(mesh.like[mesh.triangles[t][k]], fine.triangles[t][k]);
    }
  EXPECT_TRUE(simplified({}, 10).triangles.empty());
}

}  // namespace simplified_test
}  // namespace palpa::detail
