// Grids with uneven planes: sampled natively, exact where affine grids are.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "palpa/data/derived.h"
#include "palpa/data/filter.h"
#include "palpa/data/roots.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/timed_field.h"
#include "test_fields.h"

namespace palpa {
namespace rectilinear_test {

using test::uniform;

std::vector<double> uneven(std::mt19937& random, int n, double ratio) {
  std::vector<double> at{0.0};
  for (int i = 1; i < n; ++i) at.push_back(at.back() + std::pow(ratio, uniform(random, 0, 1)));
  for (double& x : at) x *= (n - 1) / at.back();
  at.back() = n - 1;
  return at;
}

/// Sheared, and locally up to 30 times finer.
GridGeometry uneven_grid(std::mt19937& random, std::array<std::int64_t, 3> dims = {19, 18, 27}) {
  Mat3 steps = 1e-3 * test::rotation(random);
  steps.row[0].y += 2e-4;
  GridGeometry grid{dims, steps, {0.01, -0.02, 0.03}};
  for (std::size_t a = 0; a < 3; ++a) grid.planes[a] = uneven(random, static_cast<int>(dims[a]), 30.0);
  return grid;
}

std::vector<double> values_over(const GridGeometry& grid, const std::function<double(const Vec3&)>& value) {
  std::vector<double> values;
  for (std::int64_t k = 0; k < grid.dims[2]; ++k)
    for (std::int64_t j = 0; j < grid.dims[1]; ++j)
      for (std::int64_t i = 0; i < grid.dims[0]; ++i) values.push_back(value(grid.to_world({double(i), double(j), double(k)})));
  return values;
}

std::vector<float> noise(std::mt19937& random, std::int64_t count) {
  std::vector<float> values(static_cast<std::size_t>(count));
  for (float& v : values) v = static_cast<float>(uniform(random, -1, 1));
  return values;
}

/// A grid point away from planes, where slopes jump.
Vec3 inside_a_cell(std::mt19937& random, const GridGeometry& grid) {
  const auto index = [&](std::size_t a) {
    return std::floor(uniform(random, 0, static_cast<double>(grid.dims[a] - 1))) + uniform(random, 0.1, 0.9);
  };
  return grid.to_world({index(0), index(1), index(2)});
}

TEST(Rectilinear, LinearFunctionsAreExactAtAnyDistances) {
  std::mt19937 random(1);
  const Vec3 slope{300, -200, 500};
  for (int n = 0; n < 20; ++n) {
    const GridGeometry grid = uneven_grid(random);
    const FieldPtr field =
        grid_field(grid, test::voxels_of(values_over(grid, [&](const Vec3& x) { return dot(slope, x) + 7.0; })));
    for (int m = 0; m < 500; ++m) {
      const Vec3 at = inside_a_cell(random, grid);
      const ScalarSample s = field->scalar(at);
      ASSERT_TRUE(s.inside);
      ASSERT_NEAR(s.value, dot(slope, at) + 7.0, 1e-10);
      ASSERT_LT(norm(s.gradient - slope), 1e-7);
    }
    double least = 1.0;
    for (const auto& planes : grid.planes) {
      for (std::size_t i = 1; i < planes.size(); ++i) least = std::min(least, planes[i] - planes[i - 1]);
    }
    EXPECT_LT(field->spacing_m(), 1.1e-3 * least);
    EXPECT_GT(field->depth_m(grid.to_world({9, 9, 13})), 0.0);
  }
}

TEST(Rectilinear, EvenPlanesAreTheAffineGridToTheBit) {
  std::mt19937 random(2);
  GridGeometry even = uneven_grid(random);
  GridGeometry affine = even;
  affine.planes = {};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t i = 0; i < even.planes[a].size(); ++i) even.planes[a][i] = static_cast<double>(i);
  const Voxels voxels = test::voxels_of(noise(random, affine.voxels()));
  for (const Filter filter : {Filter::trilinear, Filter::smooth, Filter::cubic}) {
    const FieldPtr a = filtered(grid_field(affine, voxels), filter), b = filtered(grid_field(even, voxels), filter);
    for (int n = 0; n < 1000; ++n) {
      const Vec3 at = test::within(random, a->bounds_m());
      const ScalarSample x = a->scalar(at), y = b->scalar(at);
      ASSERT_EQ(x.inside, y.inside);
      ASSERT_EQ(x.value, y.value);
      ASSERT_EQ(x.gradient, y.gradient);
      ASSERT_EQ(a->depth_m(at), b->depth_m(at));
    }
  }
}

TEST(Rectilinear, DerivativesAreThoseOfTheInterpolant) {
  std::mt19937 random(3);
  const GridGeometry grid = uneven_grid(random);
  const Voxels voxels = test::voxels_of(noise(random, grid.voxels()));
  const Voxels vectors = test::voxels_of(noise(random, 3 * grid.voxels()), 3);
  for (const Filter filter : {Filter::trilinear, Filter::smooth}) {
    const FieldPtr field = filtered(grid_field(grid, voxels), filter);
    const FieldPtr flow = filtered(grid_field(grid, vectors), filter);
    const double h = 0.02 * field->spacing_m();
    for (int n = 0; n < 300; ++n) {
      const Vec3 at = inside_a_cell(random, grid);
      const Vec3 g = field->scalar(at).gradient;
      ASSERT_LT(norm(g - test::numeric_gradient(*field, at, h)), 1e-5 * (norm(g) + 1e3));
      const Mat3 j = flow->vector(at).jacobian;
      ASSERT_LT(test::largest_difference(j, test::numeric_jacobian(*flow, at, h)), 1e-5 * (norm(j.row[0]) + 1e3));
      if (filter == Filter::trilinear) continue;
      const Mat3 hessian = field->hessian(at);
      for (int a = 0; a < 3; ++a) {
        const Vec3 slope =
            (field->scalar(at + h * test::axis(a)).gradient - field->scalar(at - h * test::axis(a)).gradient) / (2.0 * h);
        ASSERT_LT(norm(hessian.row[a] - slope), 1e-3 * (norm(slope) + 1e6));
      }
    }
  }
}

TEST(Rectilinear, PiecesOfWaysAreTheInterpolantAndHideNothing) {
  std::mt19937 random(4);
  const GridGeometry grid = uneven_grid(random);
  GridGeometry mixed = grid;  // one axis even, one of a single plane
  mixed.dims[1] = 1;
  mixed.planes[1].clear(), mixed.planes[2].clear();
  const FieldPtr fields[] = {grid_field(grid, test::voxels_of(noise(random, grid.voxels()))),
                             smooth_grid_field(grid, test::voxels_of(noise(random, grid.voxels()))),
                             grid_field(mixed, test::voxels_of(noise(random, mixed.voxels()))),
                             grid_field(grid, test::voxels_of(values_over(grid, [](const Vec3& x) { return 30.0 * x.x; })))};
  for (const FieldPtr& field : fields) {
    Box box = field->bounds_m();
    box = {box.low_m - 0.1 * box.size_m(), box.high_m + 0.1 * box.size_m()};
    for (const ValueRange quiet : {ValueRange{1.0, -1.0}, ValueRange{-10.0, 0.4}}) {
      for (int n = 0; n < 200; ++n) {
        const Vec3 from = test::within(random, box), to = test::within(random, box);
        int pieces = 0;
        for (double begin = 0.0; begin < 1.0;) {
          const PolynomialPiece piece = field->piece_along(from, to, begin, quiet);
          ASSERT_GT(piece.end, begin);
          ASSERT_LE(piece.end, 1.0);
          ASSERT_LT(++pieces, 1000);
          for (const double share : {0.001, 0.3, 0.5, 0.999}) {
            const ScalarSample s = field->scalar(from + (begin + share * (piece.end - begin)) * (to - from));
            if (piece.end - begin < 1e-6) continue;  // rounding decides about the cell
            ASSERT_EQ(piece.inside, s.inside);
            if (!piece.inside) continue;
            if (piece.degree < 0) {
              ASSERT_GE(s.value, quiet.min - 1e-9);
              ASSERT_LT(s.value, quiet.max + 1e-9);
            } else {
              ASSERT_NEAR(value_of(piece.control, piece.degree, share), s.value, 1e-9);
            }
          }
          begin = piece.end;
        }
      }
    }
  }
}

TEST(Rectilinear, CoordinatesBecomePlanesOrAnAffineAxis) {
  const GridGeometry grid = rectilinear_geometry({{{0.01, 0.02, 0.5, 4.5}, {3.0, 2.0, 1.0}, {7.0}}});
  EXPECT_EQ(grid.dims, (std::array<std::int64_t, 3>{4, 3, 1}));
  EXPECT_EQ(grid.planes[0].size(), 4U);
  EXPECT_TRUE(grid.planes[1].empty());  // even, and falling
  EXPECT_TRUE(grid.planes[2].empty());
  EXPECT_LT(norm(grid.to_world({0, 0, 0}) - Vec3{0.01, 3, 7}), 1e-15);
  EXPECT_LT(norm(grid.to_world({1, 1, 0}) - Vec3{0.02, 2, 7}), 1e-15);
  EXPECT_LT(norm(grid.to_world({2, 2, 0}) - Vec3{0.5, 1, 7}), 1e-15);
  EXPECT_LT(norm(grid.to_world({3, 2, 0}) - Vec3{4.5, 1, 7}), 1e-15);
  EXPECT_EQ(grid.index_to_world_m.row[2].z, 1.0);  // as wide as the least mean step
  EXPECT_THROW(rectilinear_geometry({{{0.0, 2.0, 1.0}, {0.0, 1.0}, {0.0, 1.0}}}), std::invalid_argument);
  EXPECT_THROW(rectilinear_geometry({{{0.0, 1.0, 1.0, 2.0}, {0.0, 1.0}, {0.0, 1.0}}}), std::invalid_argument);
  EXPECT_THROW(rectilinear_geometry({{{0.0, std::nan(""), 2.0}, {0.0, 1.0}, {0.0, 1.0}}}), std::invalid_argument);
  EXPECT_THROW(rectilinear_geometry({{{}, {0.0, 1.0}, {0.0, 1.0}}}), std::invalid_argument);
}

TEST(Rectilinear, DerivedFieldsAreTakenEvenly) {
  std::mt19937 random(5);
  GridGeometry grid = rectilinear_geometry({{{0, 0.1, 0.3, 0.6, 1.0, 1.5}, {0, 0.4, 0.5, 1.2}, {0, 0.1, 0.7, 1.0, 1.4}}});
  std::vector<double> turning;
  for (std::int64_t k = 0; k < grid.dims[2]; ++k)
    for (std::int64_t j = 0; j < grid.dims[1]; ++j)
      for (std::int64_t i = 0; i < grid.dims[0]; ++i) {
        const Vec3 x = grid.to_world({double(i), double(j), double(k)});
        turning.insert(turning.end(), {-3.0 * x.y, 3.0 * x.x, 0.0});
      }
  const FieldPtr curl = derived(Derivation::curl, grid_field(grid, test::voxels_of(std::move(turning), 3)));
  for (int n = 0; n < 100; ++n) {
    const VectorSample s = curl->vector(test::within(random, curl->bounds_m()));
    ASSERT_TRUE(s.inside);
    ASSERT_LT(norm(s.value - Vec3{0, 0, 6}), 1e-5);
  }
}

std::vector<PolynomialPiece> pieces_of(const Field& field, const Vec3& from_m, const Vec3& to_m) {
  std::vector<PolynomialPiece> pieces;
  for (double begin = 0.0; begin < 1.0; begin = pieces.back().end)
    pieces.push_back(field.piece_along(from_m, to_m, begin, {1.0, -1.0}));
  return pieces;
}

// The length of a vector is no polynomial: pieces are quarters of a cell, each within that cell.
TEST(Rectilinear, AMagnitudeIsLookedAtCellByCell) {
  std::mt19937 random(8);
  for (int n = 0; n < 50; ++n) {
    GridGeometry grid = uneven_grid(random);
    for (std::size_t a = 0; a < 3; ++a) grid.planes[a] = uneven(random, static_cast<int>(grid.dims[a]), 1e3);
    const FieldPtr flow = grid_field(grid, test::voxels_of(noise(random, 3 * grid.voxels()), 3));
    const FieldPtr length = derived(Derivation::magnitude, flow);
    const Mat3 to_steps = inverse(grid.index_to_world_m);
    const auto cell_of = [&](const Vec3& x_m) {
      const Vec3 steps = to_steps * (x_m - grid.origin_m);
      const double at[] = {steps.x, steps.y, steps.z};
      std::array<std::ptrdiff_t, 3> cell{};
      for (std::size_t a = 0; a < 3; ++a)
        cell[a] = std::upper_bound(grid.planes[a].begin(), grid.planes[a].end(), at[a]) - grid.planes[a].begin();
      return cell;
    };
    const Vec3 from_m = inside_a_cell(random, grid), to_m = from_m + 0.2 * (inside_a_cell(random, grid) - from_m);
    const auto place = [&](double share) { return from_m + share * (to_m - from_m); };
    double begin = 0.0;
    for (const PolynomialPiece& piece : pieces_of(*length, from_m, to_m)) {
      ASSERT_TRUE(piece.inside && piece.degree == 3);
      ASSERT_NEAR(piece.control[0], length->scalar(place(begin)).value, 1e-9);
      ASSERT_NEAR(piece.control[3], length->scalar(place(piece.end)).value, 1e-9);
      const auto inwards = [&](double share) { return begin + share * (piece.end - begin); };
      const bool is_sliver = (piece.end - begin) * distance(from_m, to_m) < 1e-12;
      if (!is_sliver) {
        EXPECT_EQ(cell_of(place(inwards(0.001))), cell_of(place(inwards(0.999)))) << n;
      }
      EXPECT_LE((piece.end - begin) * distance(from_m, to_m), 0.2500001 * length->local_spacing_m(place(inwards(0.5)))) << n;
      begin = piece.end;
    }
  }
}

// A wall of thin cells among thick cells is found without fine pieces in the thick cells.
TEST(Rectilinear, AMagnitudesThinWallIsSeenInFewPieces) {
  GridGeometry grid{{7, 2, 2}, 1e-3 * Mat3::identity(), {}};
  grid.planes[0] = {0.0, 1.0, 2.0, 2.00001, 2.00002, 3.0, 6.0};
  std::vector<float> wall(3 * 7 * 4, 0.0F);
  for (std::size_t row = 0; row < 4; ++row) wall[3 * (7 * row + 3)] = 1.0F;
  const FieldPtr flow = grid_field(grid, test::voxels_of(wall, 3));
  const FieldPtr length = derived(Derivation::magnitude, flow);
  const std::vector<PolynomialPiece> pieces = pieces_of(*length, {3e-4, 5e-4, 5e-4}, {5.7e-3, 5e-4, 5e-4});
  EXPECT_LT(pieces.size(), 40U);
  double largest = 0.0;
  for (const PolynomialPiece& piece : pieces) largest = std::max(largest, piece.control[3]);
  EXPECT_NEAR(largest, 1.0, 1e-6);
}

TEST(LocalSpacing, OfDataThatMoveIsThatOfTheirCells) {
  std::mt19937 random(9);
  const GridGeometry grid = uneven_grid(random);
  const FieldPtr still = grid_field(grid, test::voxels_of(noise(random, grid.voxels())));
  const Similarity pose{test::rotation(random), 1.0, {0.1, 0.2, 0.3}};
  const FieldPtr moves = moving(still, {{0.0, {}}, {1.0, pose}});
  const FieldPtr frames = time_series({still, still}, 1.0);
  for (int n = 0; n < 100; ++n) {
    const Vec3 at_m = inside_a_cell(random, grid);
    const double spacing_m = still->local_spacing_m(at_m);
    EXPECT_NEAR(timed(*moves)->local_spacing_at(pose.to_world(at_m), 1.0), spacing_m, 1e-12 * spacing_m);
    EXPECT_EQ(moves->local_spacing_m(at_m), spacing_m);
    EXPECT_EQ(timed(*frames)->local_spacing_at(at_m, 0.5), spacing_m);
  }
}

}  // namespace rectilinear_test
}  // namespace palpa
