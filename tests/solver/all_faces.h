// Corners for tests, and the nearest free point by a search over all faces.
#pragma once

#include <cmath>
#include <vector>

#include "palpa/solver/corner.h"
#include "tests/solver/random_problems.h"

namespace palpa::test {

struct Facet {
  Vec3 position_m, normal;
};
using Facets = std::vector<Facet>;

inline void add_corner(Problem& problem, const Facets& facets, double strength_n) {
  const auto slot = static_cast<std::uint16_t>(problem.primitives.size());
  for (const Facet& facet : facets) {
    problem.primitives.push_back({PrimitiveKind::corner, {0, slot}, facet.position_m, facet.normal, strength_n, 0.0});
  }
}

/// Normals about an axis, never so far apart that the corner would be too narrow.
inline Facets some_facets(Random& random, const Vec3& near_m, double within_m, int count) {
  const Vec3 axis = random.direction();
  const double spread = random.uniform(0.2, 4.0);
  Facets facets;
  std::vector<Vec3> normals;
  while (static_cast<int>(facets.size()) < count) {
    const Vec3 normal = normalized(axis + spread * random.direction());
    normals.push_back(normal);
    if (detail::width_of(normals) < 0.01) {
      normals.pop_back();
      continue;
    }
    facets.push_back({near_m + random.in_cube(within_m), normal});
  }
  return facets;
}

/// From x to the nearest free point, by trying every face of up to three facets: any t ≥ 0 is a lower bound, so the largest
/// dual value wins. In long double, without the library's code.
inline Vec3 way_out_by_all_faces(const Facets& facets, const Vec3& x_m) {
  using Real = long double;
  const std::size_t m = facets.size();
  const auto product = [](const Vec3& a, const Vec3& b) { return Real(a.x) * b.x + Real(a.y) * b.y + Real(a.z) * b.z; };
  std::vector<Real> c;
  for (const Facet& f : facets) {
    const Vec3 &n = f.normal, &a_m = f.position_m;
    c.push_back(n.x * (Real(a_m.x) - x_m.x) + n.y * (Real(a_m.y) - x_m.y) + n.z * (Real(a_m.z) - x_m.z));
  }
  Real best = 0.0L;
  Vec3 way_m;
  for (std::size_t mask = 1; mask < (std::size_t{1} << m); ++mask) {
    std::vector<std::size_t> face;
    for (std::size_t i = 0; i < m; ++i) {
      if (mask >> i & 1) face.push_back(i);
    }
    if (face.size() > 3) continue;
    // Σ t n·n = c by elimination, the largest pivot first.
    Real rows[3][4] = {};
    const std::size_t size = face.size();
    for (std::size_t a = 0; a < size; ++a) {
      for (std::size_t b = 0; b < size; ++b) rows[a][b] = product(facets[face[a]].normal, facets[face[b]].normal);
      rows[a][3] = c[face[a]];
    }
    bool singular = false;
    for (std::size_t a = 0; a < size; ++a) {
      std::size_t pivot = a;
      for (std::size_t b = a; b < size; ++b) pivot = std::abs(rows[b][a]) > std::abs(rows[pivot][a]) ? b : pivot;
      std::swap(rows[a], rows[pivot]);
      singular = singular || std::abs(rows[a][a]) < 1e-12L;
      if (singular) break;
      for (std::size_t b = 0; b < size; ++b) {
        const Real factor = b == a ? 0.0L : rows[b][a] / rows[a][a];
        for (std::size_t column = a; column < 4; ++column) rows[b][column] -= factor * rows[a][column];
      }
    }
    if (singular) continue;
    Real value = 0.0L;
    Vec3 w;
    bool pushes = true;
    for (std::size_t a = 0; a < size; ++a) {
      const Real t = rows[a][3] / rows[a][a];
      pushes = pushes && t >= 0.0L;
      value += t * c[face[a]];
      w += static_cast<double>(t) * facets[face[a]].normal;
    }
    value -= 0.5L * product(w, w);
    if (pushes && value > best) best = value, way_m = w;
  }
  return way_m;
}

}  // namespace palpa::test
