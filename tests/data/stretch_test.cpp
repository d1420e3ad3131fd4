// Pieces of straight paths: complete, equal to the samples, without hidden extrema.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "palpa/data/analytic.h"
#include "palpa/data/derived.h"
#include "palpa/data/field.h"
#include "palpa/data/grid.h"
#include "palpa/data/roots.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/volume.h"
#include "palpa/solver/similarity.h"
#include "test_fields.h"

namespace palpa {
namespace stretch_test {

using test::uniform;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr ValueRange nothing_is_quiet{infinity, -infinity};

std::vector<float> noise(std::mt19937& random, const std::array<std::int64_t, 3>& dims, int components = 1) {
  std::vector<float> values(static_cast<std::size_t>(dims[0] * dims[1] * dims[2] * components));
  for (float& v : values) v = static_cast<float>(uniform(random, -1, 1));
  return values;
}

// A tilted, sheared grid, aligned with no world axis.
GridGeometry tilted(std::mt19937& random, const std::array<std::int64_t, 3>& dims) {
  Mat3 steps = 1e-3 * test::rotation(random);
  steps.row[0].y += 2e-4;
  for (Vec3& row : steps.row) row.z *= 1.7;
  return {dims, steps, {0.01, -0.02, 0.03}};
}

struct Made {
  std::string name;
  FieldPtr field;
  double tolerance;  // of the largest value: required accuracy of the polynomial
};

std::vector<Made> noise_fields(std::mt19937& random) {
  const std::array<std::int64_t, 3> dims{19, 18, 27};
  std::vector<Made> made;
  const GridGeometry geometry = tilted(random, dims);
  made.push_back({"trilinear", grid_field(geometry, test::voxels_of(noise(random, dims)), 3.0, -0.5), 1e-12});
  made.push_back({"smooth", smooth_grid_field(geometry, test::voxels_of(noise(random, dims)), -2.0, 0.1), 1e-10});
  const FieldPtr vectors = grid_field(geometry, test::voxels_of(noise(random, dims, 3), 3));
  made.push_back({"component", derived(Derivation::component_y, vectors), 1e-12});
  const FieldPtr smooth_vectors = smooth_grid_field(geometry, test::voxels_of(noise(random, dims, 3), 3));
  made.push_back({"smooth component", derived(Derivation::component_z, smooth_vectors), 1e-10});
  made.push_back({"posed", posed(made[1].field, {test::rotation(random), 2.5, {0.1, 0.2, -0.1}}), 1e-10});
  const GridGeometry flat{{30, 1, 20}, geometry.index_to_world_m, {}};
  made.push_back({"flat", grid_field(flat, test::voxels_of(noise(random, flat.dims))), 1e-12});
  made.push_back({"flat smooth", smooth_grid_field(flat, test::voxels_of(noise(random, flat.dims))), 1e-10});
  return made;
}

// A path that begins and ends in or near the box.
std::pair<Vec3, Vec3> way_in(std::mt19937& random, const Field& field, double beyond = 0.1) {
  Box box = field.bounds_m();
  const Vec3 more = beyond * box.size_m();
  box = {box.low_m - more, box.high_m + more};
  return {test::within(random, box), test::within(random, box)};
}

// Calls act(piece, begin) for all pieces of a path and checks that they tile it.
void for_pieces(const Field& field, const Vec3& from, const Vec3& to, const ValueRange& quiet,
                const std::function<void(const PolynomialPiece&, double)>& act) {
  double begin = 0.0;
  int pieces = 0;
  while (begin < 1.0) {
    const PolynomialPiece piece = field.piece_along(from, to, begin, quiet);
    ASSERT_GT(piece.end, begin);
    ASSERT_LE(piece.end, 1.0);
    ASSERT_LT(++pieces, 100000);
    ASSERT_TRUE(piece.degree >= -1 && piece.degree <= 9);
    for (int i = 0; i <= piece.degree; ++i) ASSERT_TRUE(std::isfinite(piece.control[i]));
    act(piece, begin);
    begin = piece.end;
  }
}

TEST(PolynomialPiece, IsTheInterpolantAlongRandomWays) {
  std::mt19937 random(1);
  for (const Made& made : noise_fields(random)) {
    for (int n = 0; n < 100; ++n) {
      const auto [from, to] = way_in(random, *made.field);
      for_pieces(*made.field, from, to, nothing_is_quiet, [&](const PolynomialPiece& piece, double begin) {
        double least = infinity, greatest = -infinity;
        for (int i = 0; i <= piece.degree; ++i) {
          least = std::min(least, piece.control[i]);
          greatest = std::max(greatest, piece.control[i]);
        }
        for (const double share : {0.001, 0.3, 0.5, 0.77, 0.999}) {
          const double at = begin + share * (piece.end - begin);
          const ScalarSample sample = made.field->scalar(from + at * (to - from));
          if (piece.end - begin < 1e-6) continue;  // rounding decides about the cell
          ASSERT_EQ(piece.inside, sample.inside) << made.name;
          if (!piece.inside) continue;
          ASSERT_GE(piece.degree, 0);
          const double value = value_of(piece.control, piece.degree, share);
          ASSERT_NEAR(value, sample.value, made.tolerance * 3.0) << made.name << " at " << at;
          ASSERT_LE(sample.value, greatest + made.tolerance) << made.name;
          ASSERT_GE(sample.value, least - made.tolerance) << made.name;
        }
      });
    }
  }
}

TEST(PolynomialPiece, PiecesMeet) {
  std::mt19937 random(2);
  const std::array<std::int64_t, 3> dims{20, 20, 20};
  const GridGeometry geometry{dims, Mat3::identity(), {}};
  const FieldPtr fields[] = {grid_field(geometry, test::voxels_of(noise(random, dims))),
                             smooth_grid_field(geometry, test::voxels_of(noise(random, dims)))};
  const std::pair<Vec3, Vec3> ways[] = {
      {{0, 0, 0}, {19, 19, 19}},         // through corners
      {{19, 19, 19}, {0, 0, 0}},         // and back
      {{0, 3, 7}, {19, 3, 7}},           // along an edge
      {{19, 3, 7}, {0, 3, 7}},           //
      {{0.5, 3, 0.25}, {19, 3, 18.75}},  // in a face
      {{3, 3, 0}, {3, 3, 19}},           //
      {{0, 19, 19}, {19, 0, 19}},        // through edges, in the last face
      {{-5, 3.5, 3.5}, {25, 3.5, 3.5}},  // in and out
      {{2, 2, 2}, {2, 2, 2}},            // a path of length 0
      {{2.25, 2, 2}, {2.25, 2 + 1e-300, 2}},
      {{2.5, 2, 2}, {2.5 + 1e-12, 3, 2 - 1e-15}},
  };
  for (const FieldPtr& field : fields) {
    for (const auto& [from, to] : ways) {
      std::optional<double> last;
      int with_data = 0;
      for_pieces(*field, from, to, nothing_is_quiet, [&](const PolynomialPiece& piece, double begin) {
        if (!piece.inside) {
          last.reset();
          return;
        }
        ++with_data;
        const double value = piece.control[0];
        const ScalarSample sample = field->scalar(from + begin * (to - from));
        EXPECT_NEAR(value, sample.inside ? sample.value : value, 1e-11);
        EXPECT_NEAR(value, last.value_or(value), 1e-12);
        last = piece.control[piece.degree];
      });
      EXPECT_GT(with_data, 0);
      EXPECT_LT(with_data, 64);
    }
  }
}

TEST(PolynomialPiece, SaysWhereDataAreMissing) {
  std::mt19937 random(3);
  const std::array<std::int64_t, 3> dims{30, 26, 22};
  for (int kind = 0; kind < 4; ++kind) {
    std::vector<float> values = noise(random, dims, kind < 2 ? 1 : 3);
    for (float& v : values) {
      if (uniform(random, 0, 1) < 0.003) v = uniform(random, 0, 1) < 0.5 ? std::numeric_limits<float>::quiet_NaN() : INFINITY;
    }
    // And a corner without data: whole bricks of it.
    const int c = kind < 2 ? 1 : 3;
    for (std::int64_t k = 0; k < 22; ++k) {
      for (std::int64_t j = 0; j < 20; ++j) {
        for (std::int64_t i = 0; i < 20 * c; ++i) {
          values[static_cast<std::size_t>(i + 30 * c * (j + 26 * k))] = std::numeric_limits<float>::quiet_NaN();
        }
      }
    }
    const GridGeometry geometry = tilted(random, dims);
    const Voxels voxels = test::voxels_of(values, c);
    const FieldPtr field = kind % 2 == 0 ? grid_field(geometry, voxels) : smooth_grid_field(geometry, voxels);
    int missing = 0;
    for (int n = 0; n < 300; ++n) {
      const auto [from, to] = way_in(random, *field);
      for (const ValueRange& quiet : {nothing_is_quiet, ValueRange{-infinity, infinity}}) {
        for_pieces(*field, from, to, quiet, [&](const PolynomialPiece& piece, double begin) {
          if (piece.end - begin < 1e-6) return;
          for (const double share : {0.001, 0.5, 0.999}) {
            const Vec3 at = from + (begin + share * (piece.end - begin)) * (to - from);
            ASSERT_EQ(piece.inside, c == 1 ? field->scalar(at).inside : field->vector(at).inside) << kind;
          }
          missing += !piece.inside;
        });
      }
    }
    EXPECT_GT(missing, 300);
  }
}

TEST(PolynomialPiece, QuietPiecesAreQuiet) {
  std::mt19937 random(4);
  const std::array<std::int64_t, 3> dims{70, 40, 50};
  for (const bool smooth : {false, true}) {
    // Waves with some noise: some whole bricks are quiet.
    std::vector<float> values = noise(random, dims);
    std::size_t n = 0;
    for (int k = 0; k < 50; ++k) {
      for (int j = 0; j < 40; ++j) {
        for (int i = 0; i < 70; ++i, ++n) {
          values[n] = static_cast<float>(0.1 * values[n] + std::sin(0.09 * i) * std::cos(0.1 * j) * std::sin(0.08 * k + 1));
        }
      }
    }
    const GridGeometry geometry = tilted(random, dims);
    const Voxels voxels = test::voxels_of(values);
    const FieldPtr field = smooth ? smooth_grid_field(geometry, voxels) : grid_field(geometry, voxels);
    int long_pieces = 0;
    for (int w = 0; w < 300; ++w) {
      const auto [from, to] = way_in(random, *field, 0.0);
      const ValueRange quiet{uniform(random, -0.6, 0.2), uniform(random, 0.0, 0.8)};
      for_pieces(*field, from, to, quiet, [&](const PolynomialPiece& piece, double begin) {
        if (!piece.inside || piece.degree >= 0) return;
        long_pieces += (piece.end - begin) * distance(from, to) > 4.0 * field->spacing_m();
        for (int i = 1; i < 20; ++i) {
          const double value = field->scalar(from + (begin + i / 20.0 * (piece.end - begin)) * (to - from)).value;
          ASSERT_GE(value, quiet.min - 1e-12);
          ASSERT_LT(value, quiet.max + 1e-12);
        }
      });
    }
    EXPECT_GT(long_pieces, 20);
  }
}

TEST(PolynomialPiece, OfFormulasFollowsThem) {
  std::mt19937 random(5);
  const Volume ring = ring_vortex(), head = head_phantom();
  const FieldPtr fields[] = {ring.fields[1].field, head.fields[0].field, derived(Derivation::magnitude, ring.fields[0].field),
                             sphere_field().fields[0].field};
  for (const FieldPtr& field : fields) {
    const ValueRange range = field->value_ranges().front();
    for (int n = 0; n < 30; ++n) {
      const auto [from, to] = way_in(random, *field);
      for_pieces(*field, from, to, {-infinity, infinity}, [&](const PolynomialPiece& piece, double begin) {
        ASSERT_TRUE(!piece.inside || (piece.end - begin) * distance(from, to) <= 0.2501 * field->spacing_m());
        for (const double share : {0.01, 0.5, 0.9}) {
          const ScalarSample s = field->scalar(from + (begin + share * (piece.end - begin)) * (to - from));
          if (piece.end - begin < 1e-9) continue;
          ASSERT_EQ(s.inside, piece.inside);
          if (!piece.inside) continue;
          ASSERT_NEAR(value_of(piece.control, piece.degree, share), s.value, 2e-3 * (range.max - range.min));
        }
      });
    }
  }
}

TEST(PolynomialPiece, TakesAnyWay) {
  std::mt19937 random(6);
  std::vector<Made> all = noise_fields(random);
  all.push_back({"formula", head_phantom().fields[0].field, 0.0});
  all.push_back({"vectors", lamb_oseen_vortex().fields[0].field, 0.0});
  std::vector<Vec3> places = test::absurd_positions();
  places.insert(places.end(), {{0, 0, 0}, {0.02, -0.01, 0.05}, {1e300, 1e300, 1e300}, {-1e308, 1e308, 0}, {1e10, 0, 0}});
  for (const Made& made : all) {
    for (const Vec3& from : places) {
      for (const Vec3& to : places) {
        double begin = 0.0;
        for (int n = 0; n < 50 && begin < 1.0; ++n) {
          const PolynomialPiece piece = made.field->piece_along(from, to, begin, {-1, 1});
          ASSERT_GT(piece.end, begin);
          ASSERT_LE(piece.end, 1.0);
          for (const double c : piece.control) ASSERT_TRUE(std::isfinite(c));
          begin = piece.end;
        }
      }
    }
    for (const double begin : {nan, infinity, -infinity, -1.0, 2.0, 1.0}) {
      EXPECT_FALSE(made.field->piece_along({}, {0.1, 0, 0}, begin, {-1, 1}).inside);
    }
  }
}

// ---- Roots ----

TEST(FirstPassage, FindsTheFirstOfManyRoots) {
  std::mt19937 random(7);
  int found = 0;
  for (int n = 0; n < 20000; ++n) {
    const int degree = n % 2 == 0 ? 3 : 9;
    double c[10];
    for (int i = 0; i <= degree; ++i) c[i] = uniform(random, -1, 1);
    const double level = uniform(random, -0.7, 0.7), from = n % 3 == 0 ? uniform(random, 0, 1) : 0.0;
    const bool up = value_of(c, degree, from) < level;
    const auto beyond = [&](double s) { return (value_of(c, degree, s) >= level) == up; };
    const double share = first_passage(c, degree, level, up, from);
    // Brute force: no earlier sample is beyond the level, and this point is.
    const double end = share <= 1.0 ? share : 1.0;
    for (int i = 0; i <= 200; ++i) {
      const double s = from + (end - from) * i / 200.0;
      if (s < end - 1e-11) {
        ASSERT_FALSE(beyond(s) && std::abs(value_of(c, degree, s) - level) > 1e-14) << n << " at " << s << " of " << end;
      }
    }
    if (share > 1.0) continue;
    ++found;
    ASSERT_NEAR(value_of(c, degree, share), level, 1e-12);
    ASSERT_TRUE(beyond(std::min(1.0, share + 1e-12)) || share == 1.0 ||
                std::abs(value_of(c, degree, share + 1e-12) - level) < 1e-14);
  }
  EXPECT_GT(found, 5000);
}

// t^n about a half in Bernstein form, by sampling the polar form: (t − ½)^n has coefficients (−½)^(n−i) (½)^i.
void power_about_half(int n, double (&c)[10]) {
  for (int i = 0; i <= n; ++i) c[i] = std::pow(-0.5, n - i) * std::pow(0.5, i);
}

TEST(FirstPassage, TellsTouchingFromPassing) {
  for (const int n : {2, 4, 6, 8}) {
    for (const double depth : {0.0, 1e-12, 1e-8, 1e-4, -1e-12, -1e-8, -1e-4}) {
      double c[10];
      power_about_half(n, c);
      for (int i = 0; i <= n; ++i) c[i] = -c[i] + depth;  // a hill that reaches up to `depth`
      const double share = first_passage(c, n, 0.0, true);
      if (depth > 0.0) {
        ASSERT_NEAR(share, 0.5 - std::pow(depth, 1.0 / n), 1e-4 * std::pow(depth, 1.0 / n)) << n << " " << depth;
      } else if (depth < 0.0) {
        ASSERT_GT(share, 1.0) << n << " " << depth;
      }
      for (int i = 0; i <= n; ++i) c[i] = -c[i];  // a valley down to −depth: touching from above is not below
      const double down = first_passage(c, n, 0.0, false);
      if (depth <= 0.0) {
        ASSERT_GT(down, 1.0) << n << " " << depth;
      } else {
        ASSERT_NEAR(down, share, 1e-9);
      }
    }
  }
}

TEST(FirstPassage, AtItsEnds) {
  const double ramp[] = {0, 1};
  EXPECT_EQ(first_passage(ramp, 1, 1.0, true), 1.0);
  EXPECT_EQ(first_passage(ramp, 1, 0.0, true), 0.0);
  EXPECT_GT(first_passage(ramp, 1, 0.0, false), 1.0);
  EXPECT_NEAR(first_passage(ramp, 1, 0.3, true), 0.3, 1e-15);
  EXPECT_EQ(first_passage(ramp, 1, 0.3, true, 0.6), 0.6);
  const double flat[] = {2, 2, 2, 2};
  EXPECT_EQ(first_passage(flat, 3, 2.0, true), 0.0);
  EXPECT_GT(first_passage(flat, 3, 2.0, false), 1.0);
  EXPECT_GT(first_passage(flat, 3, 2.0001, true), 1.0);
  EXPECT_EQ(first_passage(flat, 0, 1.0, true), 0.0);
  EXPECT_GT(first_passage(flat, -1, 1.0, true), 1.0);
}

// Two dips within a millionth of the share: both are found.
TEST(FirstPassage, FindsThinDips) {
  std::mt19937 random(8);
  for (int n = 0; n < 2000; ++n) {
    const double a = uniform(random, 0.05, 0.95), width = std::pow(10.0, uniform(random, -6, -1)),
                 b = std::min(a + width, 0.99);
    // (t − a)(t − b) in Bernstein form of degree 2: negative between.
    const double c[] = {a * b, a * b - 0.5 * (a + b), (1 - a) * (1 - b)};
    const double share = first_passage(c, 2, 0.0, false);
    ASSERT_NEAR(share, std::min(a, b), 1e-9);
    ASSERT_NEAR(first_passage(c, 2, 0.0, true, 0.5 * (a + b)), std::max(a, b), 1e-9);
  }
}

}  // namespace stretch_test
}  // namespace palpa
