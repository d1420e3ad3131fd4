// Windows and octaves: samples of a large grid from parts of it.
#include "palpa/data/octaves.h"

#include <gtest/gtest.h>

#include <random>

#include "palpa/data/smooth_grid.h"
#include "tests/data/pyramid.h"

namespace palpa {
namespace {

GridGeometry tilted(std::array<std::int64_t, 3> dims) {
  GridGeometry g;
  g.dims = dims;
  g.index_to_world_m = {{{1.1e-3, 2e-4, 0}, {-1e-4, 9e-4, 1e-4}, {5e-5, 0, 1.3e-3}}};
  g.origin_m = {0.03, -0.02, 0.011};
  return g;
}

template <class T>
Voxels waves(const GridGeometry& g, int components, double amplitude, double length_voxels, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-0.05, 0.05);
  const std::shared_ptr<T[]> data(new T[static_cast<std::size_t>(g.voxels() * components)]);
  T* to = data.get();
  const double w = 2.0 * 3.141592653589793 / length_voxels;
  for (std::int64_t k = 0; k < g.dims[2]; ++k) {
    for (std::int64_t j = 0; j < g.dims[1]; ++j) {
      for (std::int64_t i = 0; i < g.dims[0]; ++i) {
        for (int c = 0; c < components; ++c) {
          const double x = w * static_cast<double>(i), y = w * static_cast<double>(j), z = w * static_cast<double>(k + c);
          const double v = std::sin(x) * std::cos(y) + std::sin(y) * std::cos(z) + std::sin(z) * std::cos(x) +
                           (seed > 0 ? noise(random) : 0.0);
          *to++ = static_cast<T>(amplitude * v);
        }
      }
    }
  }
  const VoxelType type = std::is_same_v<T, float>          ? VoxelType::float32
                         : std::is_same_v<T, std::int16_t> ? VoxelType::int16
                                                           : VoxelType::float64;
  return {type, components, data};
}

class RandomPlaces {
 public:
  RandomPlaces(const Box& box, unsigned seed) : box_(box), random_(seed) {}
  Vec3 next(double beyond = 0.0) {
    const Vec3 size = box_.size_m();
    std::uniform_real_distribution<double> share(-beyond, 1.0 + beyond);
    return box_.low_m + Vec3{share(random_) * size.x, share(random_) * size.y, share(random_) * size.z};
  }
  Vec3 near(const Vec3& at, double way_m) {
    std::uniform_real_distribution<double> along(-way_m, way_m);
    return at + Vec3{along(random_), along(random_), along(random_)};
  }

 private:
  Box box_;
  std::mt19937 random_;
};

void expect_equal(const PolynomialPiece& a, const PolynomialPiece& b) {
  EXPECT_EQ(a.end, b.end);
  EXPECT_EQ(a.inside, b.inside);
  ASSERT_EQ(a.degree, b.degree);
  for (int i = 0; i <= a.degree; ++i) EXPECT_EQ(a.control[i], b.control[i]);
}

/// The field of a window and of the whole grid at places deep enough in the window: all results equal to the bit.
void expect_window_equals_whole(const FieldPtr& whole, std::int64_t size) {
  const auto octaves = test::in_octaves(*whole, 3);
  RandomPlaces places(whole->bounds_m(), 5);
  int compared = 0;
  for (int n = 0; n < 12; ++n) {
    const Vec3 middle = places.next();
    const OctaveWindow window = test::window_about(*octaves, 0, middle, size);
    const detail::GridBase& part = *window.grid;
    for (int m = 0; m < 200; ++m) {
      const Vec3 x = places.near(middle, 0.02), y = places.near(x, 0.004);
      if (!(part.room_voxels(x) > 8.0) || !(part.room_voxels(y) > 8.0)) continue;
      ++compared;
      EXPECT_EQ(part.depth_m(x), whole->depth_m(x));
      const LipschitzBound b = part.lipschitz_bound(x), c = whole->lipschitz_bound(x);
      EXPECT_EQ(b.radius_m, c.radius_m);
      EXPECT_EQ(b.slope_per_m, c.slope_per_m);
      EXPECT_EQ(b.rounding, c.rounding);
      if (whole->components() == 3) {
        const VectorSample s = part.vector(x), t = whole->vector(x);
        EXPECT_EQ(s.inside, t.inside);
        EXPECT_EQ(s.value, t.value);
        for (int r = 0; r < 3; ++r) EXPECT_EQ(s.jacobian.row[r], t.jacobian.row[r]);
        continue;
      }
      const ScalarSample s = part.scalar(x), t = whole->scalar(x);
      EXPECT_EQ(s.inside, t.inside);
      EXPECT_EQ(s.value, t.value);
      EXPECT_EQ(s.gradient, t.gradient);
      for (int r = 0; r < 3; ++r) EXPECT_EQ(part.hessian(x).row[r], whole->hessian(x).row[r]);
      for (const ValueRange quiet : {ValueRange{1.0, -1.0}, ValueRange{-0.2, 0.2}}) {
        for (double begin = 0.0; begin < 1.0;) {
          const PolynomialPiece p = part.piece_along(x, y, begin, quiet);
          expect_equal(p, whole->piece_along(x, y, begin, quiet));
          begin = p.end;
        }
      }
    }
  }
  EXPECT_GT(compared, 500);
}

TEST(GridWindow, HasTheSamplesOfTheWholeGridToTheBit) {
  const GridGeometry g = tilted({90, 75, 83});
  expect_window_equals_whole(grid_field(g, waves<float>(g, 1, 1.0, 13.0)), 48);
  expect_window_equals_whole(grid_field(g, waves<std::int16_t>(g, 1, 1000.0, 13.0), 0.01, -1.0), 48);
  expect_window_equals_whole(smooth_grid_field(g, waves<std::int16_t>(g, 1, 1000.0, 13.0), 0.01, -1.0), 48);
  expect_window_equals_whole(smooth_grid_field(g, waves<float>(g, 1, 1.0, 13.0)), 56);
  expect_window_equals_whole(grid_field(g, waves<double>(g, 3, 1.0, 13.0)), 40);
  expect_window_equals_whole(smooth_grid_field(g, waves<float>(g, 3, 1.0, 13.0)), 40);
}

TEST(GridWindow, HasNoDataWhereASampleNeedsVoxelsOutside) {
  const GridGeometry g = tilted({64, 64, 64});
  for (const Filter filter : {Filter::trilinear, Filter::smooth}) {
    const FieldPtr whole = filtered(grid_field(g, waves<float>(g, 1, 1.0, 13.0)), filter);
    const auto octaves = test::in_octaves(*whole, 2);
    const OctaveWindow window = octaves->window(0, {8, 16, 24}, {24, 24, 24});
    RandomPlaces places(whole->bounds_m(), 3);
    int inside = 0;
    for (int n = 0; n < 20000; ++n) {
      const Vec3 x = places.next(0.05);
      const ScalarSample s = window.grid->scalar(x);
      if (!s.inside) continue;
      ++inside;
      EXPECT_EQ(s.value, whole->scalar(x).value);
      EXPECT_EQ(s.gradient, whole->scalar(x).gradient);
    }
    EXPECT_GT(inside, 300);
    EXPECT_THROW(octaves->window(0, {4, 16, 24}, {24, 24, 24}), std::invalid_argument);
    EXPECT_THROW(octaves->window(0, {48, 16, 24}, {24, 24, 24}), std::invalid_argument);
  }
}

/// Octaves with windows of a stock about a position.
struct InStock {
  std::shared_ptr<const Octaves> octaves;
  Stock stock;
  InStock(const Field& whole, int count, const Vec3& about_m, std::int64_t size)
      : octaves(test::in_octaves(whole, count)), stock(std::vector<FieldPtr>{octaves}) {
    for (int n = 0; n + 1 < count; ++n) stock.lay(0, n, test::window_about(*octaves, n, about_m, size));
  }
  DataTime at(double octave) const {
    DataTime t;
    t.octave = octave, t.stock = &stock;
    return t;
  }
};

// One function: pieces of the blend agree with samples along the way, within a window and beyond its faces.
TEST(Octaves, PiecesAreTheSamplesAtEachFeltOctave) {
  const GridGeometry g = tilted({130, 110, 120});
  for (const Filter filter : {Filter::trilinear, Filter::smooth}) {
    const FieldPtr whole = filtered(grid_field(g, waves<float>(g, 1, 1.0, 25.0)), filter);
    RandomPlaces places(whole->bounds_m(), 8);
    const Vec3 middle = whole->bounds_m().centre_m();
    const InStock in(*whole, 3, middle, 40);
    for (int n = 0; n < 60; ++n) {
      const Vec3 x = places.near(middle, 0.06), y = places.near(x, 0.03);
      for (const double octave : {0.0, 0.3, 1.0, 1.9, 2.0}) {
        const DataTime at = in.at(octave);
        int pieces = 0;
        for (double begin = 0.0; begin < 1.0 && pieces < 2000; ++pieces) {
          const PolynomialPiece p = in.octaves->piece_along_at(x, y, begin, {1.0, -1.0}, at);
          ASSERT_GT(p.end, begin);
          const double middle_share = begin + 0.37 * (std::min(p.end, 1.0) - begin);
          const ScalarSample s = in.octaves->scalar_at(x + middle_share * (y - x), at);
          if (std::min(p.end, 1.0) - begin > 1e-9) {
            EXPECT_EQ(s.inside, p.inside);
            if (p.inside && s.inside) {
              double c[10];
              std::copy(p.control, p.control + 10, c);
              const double share = (middle_share - begin) / (p.end - begin);
              for (int level = 1; level <= p.degree; ++level) {
                for (int i = 0; i + level <= p.degree; ++i) c[i] = (1.0 - share) * c[i] + share * c[i + 1];
              }
              EXPECT_NEAR(c[0], s.value, 1e-9) << octave << " " << n;
            }
          }
          begin = p.end;
        }
        EXPECT_LT(pieces, 2000);
      }
    }
  }
}

// |φ − φ₀| ≤ max − min of octave 0 over the support of the coarser sample: a mean of voxels is within their range.
TEST(Octaves, StayWithinTheRangeOfTheFinestVoxelsAboutThem) {
  const GridGeometry g = tilted({70, 64, 61});
  for (const Filter filter : {Filter::trilinear, Filter::smooth}) {
    const FieldPtr whole = filtered(grid_field(g, waves<float>(g, 1, 1.0, 9.0)), filter);
    const InStock in(*whole, 4, whole->bounds_m().centre_m(), 64);
    const float* voxels = static_cast<const float*>(grid_behind(*whole)->voxels.data.get());
    RandomPlaces places(whole->bounds_m(), 21);
    int held = 0;
    for (int n = 0; n < 2000; ++n) {
      const Vec3 x = places.next();
      if (!whole->scalar(x).inside) continue;
      for (int octave = 1; octave < 4; ++octave) {
        const ScalarSample s = in.octaves->scalar_at(x, in.at(octave));
        EXPECT_TRUE(s.inside);  // octaves have data wherever the finest has
        const double reach = std::ldexp(filter == Filter::trilinear ? 1.5 : 2.5, octave) + 1.0;
        const Vec3 steps = detail::scaled_inverse(g.index_to_world_m) * (x - g.origin_m);
        const double at[3] = {steps.x, steps.y, steps.z};
        float low = 1e30F, high = -1e30F;
        std::int64_t from[3], to[3];
        for (std::size_t a = 0; a < 3; ++a) {
          from[a] = std::max<std::int64_t>(static_cast<std::int64_t>(std::floor(at[a] - reach)), 0);
          to[a] = std::min<std::int64_t>(static_cast<std::int64_t>(std::ceil(at[a] + reach)), g.dims[a] - 1);
        }
        for (std::int64_t k = from[2]; k <= to[2]; ++k) {
          for (std::int64_t j = from[1]; j <= to[1]; ++j) {
            for (std::int64_t i = from[0]; i <= to[0]; ++i) {
              const float v = voxels[i + g.dims[0] * (j + g.dims[1] * k)];
              low = std::min(low, v), high = std::max(high, v);
            }
          }
        }
        EXPECT_LE(std::abs(s.value - whole->scalar(x).value), static_cast<double>(high - low) + 1e-6);
        ++held;
      }
    }
    EXPECT_GT(held, 4000);
  }
}

// On smooth data the error of an octave falls with the square of its spacing.
TEST(Octaves, ErrorsFallWithTheSquareOfTheSpacing) {
  const GridGeometry g = tilted({160, 160, 160});
  const FieldPtr whole = smooth_grid_field(g, waves<double>(g, 1, 1.0, 160.0, 0));
  const InStock in(*whole, 4, whole->bounds_m().centre_m(), 160);
  double error[4]{};
  RandomPlaces places(whole->bounds_m(), 2);
  for (int n = 0; n < 4000; ++n) {
    const Vec3 x = whole->bounds_m().centre_m() + 0.5 * (places.next() - whole->bounds_m().centre_m());
    for (int octave = 1; octave < 4; ++octave)
      error[octave] = std::max(
          error[octave], std::abs(in.octaves->scalar_at(x, in.at(octave)).value - in.octaves->scalar_at(x, in.at(0)).value));
  }
  for (int octave = 2; octave < 4; ++octave) {
    const double ratio = error[octave] / error[octave - 1];
    EXPECT_GT(ratio, 3.3) << error[octave];
    EXPECT_LT(ratio, 5.5) << error[octave];
  }
}

TEST(Octaves, EndWhereTheFinestEnds) {
  const GridGeometry g = tilted({33, 40, 21});
  const FieldPtr whole = grid_field(g, waves<float>(g, 1, 1.0, 9.0));
  const InStock in(*whole, 4, whole->bounds_m().centre_m(), 64);
  RandomPlaces places(whole->bounds_m(), 4);
  for (int n = 0; n < 5000; ++n) {
    const Vec3 x = places.next(0.1);
    const double depth = whole->depth_m(x);
    if (std::abs(depth) < 1e-8) continue;
    for (const double octave : {0.0, 0.5, 1.0, 2.5, 3.0}) {
      EXPECT_EQ(in.octaves->scalar_at(x, in.at(octave)).inside, depth > 0.0) << octave;
      EXPECT_NEAR(in.octaves->depth_at(x, in.at(octave)), depth, 1e-12);
    }
  }
}

}  // namespace
}  // namespace palpa
