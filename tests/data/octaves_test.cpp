// Windows and octaves: samples of a large grid from parts of it.
#include "palpa/data/octaves.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "palpa/data/blend.h"
#include "palpa/data/field_at_moment.h"
#include "palpa/data/halton.h"
#include "palpa/data/octave_parts.h"
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
  InStock(const Field& whole, int count, const Vec3& about_m, std::int64_t size,
          double coarsest_m = std::numeric_limits<double>::infinity())
      : octaves(test::in_octaves(whole, count, coarsest_m)), stock(std::vector<FieldPtr>{octaves}) {
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

// Of voxels up to some width: up to the last octave that is felt all is as without the limit; from there depths fall, without a
// step, to zero at the next octave, from which on there are no data.
TEST(Octaves, FadeToNoDataWhereTheyAreCoarserThanAllowed) {
  const GridGeometry g = tilted({130, 110, 120});
  const FieldPtr whole = smooth_grid_field(g, waves<float>(g, 1, 1.0, 25.0));
  const Vec3 middle = whole->bounds_m().centre_m();
  const double width_m = norm(Vec3{g.index_to_world_m.row[0].z, g.index_to_world_m.row[1].z, g.index_to_world_m.row[2].z});
  const InStock all(*whole, 4, middle, 48), some(*whole, 4, middle, 48, 2.0 * width_m);
  RandomPlaces places(whole->bounds_m(), 12);
  for (int n = 0; n < 500; ++n) {
    const Vec3 x = n % 2 == 0 ? places.near(middle, 0.05) : places.next(0.05), y = places.near(x, 0.01);
    for (double octave = 0.0; octave <= 3.0; octave += 1.0 / 64.0) {
      const DataTime at = some.at(octave), without = all.at(octave);
      const double depth_m = some.octaves->depth_at(x, at);
      if (octave <= 1.0) {
        EXPECT_EQ(depth_m, all.octaves->depth_at(x, without));
      } else if (octave >= 2.0) {
        EXPECT_EQ(depth_m, std::min(0.0, all.octaves->depth_at(x, without)));
      } else {
        // Without a limit at octave 1, of four voxels of octave 1 half way, zero at octave 2.
        const double left = 2.0 - octave, fade_m = 4.0 * 2.0 * whole->spacing_m() * left / (1.0 - left);
        EXPECT_NEAR(depth_m, std::min(fade_m, all.octaves->depth_at(x, without)), 1e-15);
      }
      const ScalarSample s = some.octaves->scalar_at(x, at), t = all.octaves->scalar_at(x, without);
      const PolynomialPiece p = some.octaves->piece_along_at(x, y, 0.0, {1.0, -1.0}, at);
      if (octave < 2.0) {
        EXPECT_EQ(s.inside, t.inside);
        EXPECT_EQ(s.value, t.value);
        EXPECT_EQ(s.gradient, t.gradient);
        expect_equal(p, all.octaves->piece_along_at(x, y, 0.0, {1.0, -1.0}, without));
      } else {
        EXPECT_FALSE(s.inside);
        EXPECT_EQ(s.gradient, Vec3{});
        EXPECT_FALSE(p.inside);
        EXPECT_EQ(p.end, 1.0);
        EXPECT_EQ(some.octaves->lipschitz_bound_at(x, at).radius_m, 0.0);
        EXPECT_EQ(some.octaves->carried(x, some.at(octave - 0.5), at).position_m, x);
      }
    }
    EXPECT_EQ(some.octaves->scalar(x).value, all.octaves->scalar(x).value);  // pictures have the coarsest octave
    EXPECT_EQ(some.octaves->depth_m(x), all.octaves->depth_m(x));
  }
  EXPECT_THROW(test::in_octaves(*whole, 4, 0.9 * width_m), std::invalid_argument);
}

constexpr float nothing = std::numeric_limits<float>::quiet_NaN();

/// Sets holes of one kind: 0 voxels apart, 1 balls, 2 a bar along a diagonal, 3 a plane with a gap, 4 a corner of the grid.
void dig(std::vector<float>& values, const GridGeometry& g, int components, int kind, std::mt19937& random) {
  const auto& n = g.dims;
  const auto hole = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    if (i < 0 || j < 0 || k < 0 || i >= n[0] || j >= n[1] || k >= n[2]) return;
    values[static_cast<std::size_t>((i + n[0] * (j + n[1] * k)) * components) + random() % static_cast<unsigned>(components)] =
        nothing;
  };
  const auto place = [&](std::size_t a) { return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n[a])); };
  for (int count = 0; count < (kind == 0 ? 12 : kind == 1 ? 3 : 1); ++count) {
    const std::int64_t at[3] = {place(0), place(1), place(2)};
    const auto size = static_cast<std::int64_t>(2 + random() % 6);
    for (std::int64_t k = 0; k < n[2]; ++k) {
      for (std::int64_t j = 0; j < n[1]; ++j) {
        for (std::int64_t i = 0; i < n[0]; ++i) {
          const std::int64_t x = i - at[0], y = j - at[1], z = k - at[2];
          const bool is_hole = kind == 0   ? x == 0 && y == 0 && z == 0
                               : kind == 1 ? x * x + y * y + z * z < size * size
                               : kind == 2 ? std::abs(x - y) < 2 && std::abs(y - z) < 2
                               : kind == 3 ? x == 0 && std::abs(y) > size
                                           : i < size && j < size && k < size;
          if (is_hole) hole(i, j, k);
        }
      }
    }
  }
}

/// Grids with holes of a kind, scalars and vectors, in both filters.
std::vector<FieldPtr> with_holes(const GridGeometry& g, int kind, std::mt19937& random) {
  std::vector<FieldPtr> fields;
  for (const int components : {1, 3}) {
    const auto values = std::make_shared<std::vector<float>>();
    for (std::int64_t n = 0; n < g.voxels() * components; ++n) values->push_back(std::sin(0.01F * static_cast<float>(n)));
    dig(*values, g, components, kind, random);
    const Voxels voxels{VoxelType::float32, components, {values, values->data()}};
    fields.push_back(grid_field(g, voxels));
    fields.push_back(smooth_grid_field(g, voxels));
  }
  return fields;
}

bool has_value(const TimedField& field, const Vec3& x, DataTime at) {
  return field.components() == 1 ? field.scalar_at(x, at).inside : field.vector_at(x, at).inside;
}
bool has_value(const Field& field, const Vec3& x) {
  return field.components() == 1 ? field.scalar(x).inside : field.vector(x).inside;
}

/// Octaves with windows laid anywhere near a place, in each octave another.
struct InAnyWindows : InStock {
  InAnyWindows(const Field& whole, const Vec3& about_m, RandomPlaces& places, std::mt19937& random)
      : InStock(whole, 4, about_m, 8) {
    for (int octave = 0; octave < 3; ++octave) {
      if (random() % 8 == 0) continue;
      const double way_m = std::ldexp(8.0, octave) * whole.spacing_m();
      const Vec3 middle = places.near(about_m, way_m);
      stock.lay(0, octave, test::window_about(*octaves, octave, middle, 16 + 8 * static_cast<std::int64_t>(random() % 4)));
    }
    stock.put_in_force({&about_m, 1}, {}, {});
  }
};

// Depths in data with holes, of windows laid anywhere: data end where a depth is zero, in each felt octave; none is more than
// the way to a place where octave 0 has no data; at λ = 0 they are those of the whole grid as far as the window's faces are
// further than these.
TEST(Octaves, HaveDepthsInHolesFromBelow) {
  std::mt19937 random(17);
  int bounded = 0, equal = 0, ends = 0;
  for (int kind = 0; kind < 5; ++kind) {
    const GridGeometry g = kind % 2 == 0 ? tilted({61, 50, 44}) : GridGeometry{{61, 50, 44}, 1e-3 * Mat3::identity(), {}, {}};
    for (const FieldPtr& whole : with_holes(g, kind, random)) {
      RandomPlaces places(whole->bounds_m(), static_cast<unsigned>(random()));
      std::vector<Vec3> empty;  // places without data, within the grid and beyond
      for (int n = 0; n < 40000 && empty.size() < 3000; ++n)
        if (const Vec3 x = places.next(0.1); !has_value(*whole, x)) empty.push_back(x);
      for (int n = 0; n < 12; ++n) {
        const Vec3 middle = n % 2 == 0 ? places.next() : empty[random() % empty.size()];
        const InAnyWindows in(*whole, middle, places, random);
        for (int m = 0; m < 60; ++m) {
          const Vec3 x = places.near(middle, 0.02);
          double way_m = std::numeric_limits<double>::infinity();
          for (const Vec3& at : empty) way_m = std::min(way_m, distance(at, x));
          for (const double octave : {0.0, 0.25, 1.0, 1.5, 2.0, 2.9, 3.0}) {
            const double depth_m = in.octaves->depth_at(x, in.at(octave));
            const bool inside = has_value(*in.octaves, x, in.at(octave));
            EXPECT_TRUE(inside || depth_m <= 0.0) << kind << " " << octave << " " << depth_m;
            EXPECT_LE(depth_m, way_m) << kind << " " << octave;
            bounded += depth_m > 0.5 * way_m;
            ends += !inside && has_value(*whole, x);
          }
          const double room_m = in.stock.room_m(0, {&x, 1}, {}, 0.0), whole_m = whole->depth_m(x);
          if (room_m < 0.0) continue;
          EXPECT_EQ(has_value(*in.octaves, x, in.at(0.0)), has_value(*whole, x));
          EXPECT_GE(in.octaves->depth_at(x, in.at(0.0)), std::min(whole_m, room_m / 2.5));
          if (whole_m > room_m / 2.5) continue;
          EXPECT_EQ(in.octaves->depth_at(x, in.at(0.0)), whole_m);
          equal += has_value(*whole, x);
        }
      }
    }
  }
  EXPECT_GT(bounded, 1000);
  EXPECT_GT(equal, 1000);
  EXPECT_GT(ends, 1000);
}

// A series in octaves has the noise and, at λ = 0, the values of the series in memory; frames are all in octaves, or none is.
TEST(Octaves, AreFramesOfASeries) {
  const GridGeometry g = tilted({100, 94, 91});
  std::vector<FieldPtr> whole, octaves;
  for (unsigned seed = 1; seed < 4; ++seed) {
    whole.push_back(smooth_grid_field(g, waves<std::int16_t>(g, 1, 1000.0, 17.0, seed), 0.01, -1.0));
    octaves.push_back(test::in_octaves(*whole.back(), 3));
  }
  const auto place = [&](int n) { return detail::halton(n, whole.front()->bounds_m()); };
  const double noise = octaves_of(*octaves.front())->noise_of_finest(500, place);
  EXPECT_GT(noise, 0.0);
  EXPECT_EQ(noise, detail::noise_of_gradient(*whole.front(), 500, place));

  const FieldPtr in_memory = time_series(whole, 0.5), in_octaves = time_series(octaves, 0.5);
  const Vec3 middle = whole.front()->bounds_m().centre_m();
  Stock stock(std::vector<FieldPtr>{in_octaves});
  ASSERT_EQ(stock.size(), 3u);
  for (std::size_t n = 0; n < 3; ++n) stock.lay(n, 0, test::window_about(stock.octaves(n), 0, middle, 64));
  RandomPlaces places(whole.front()->bounds_m(), 6);
  for (int n = 0; n < 300; ++n) {
    const Vec3 x = places.near(middle, 0.01), y = places.near(x, 0.004);
    DataTime at(0.01 * n, n % 2 == 0);
    const FieldAtMoment expected = timed(*in_memory)->at_moment(at);
    at.stock = &stock;
    const FieldAtMoment now = timed(*in_octaves)->at_moment(at);
    EXPECT_EQ(now.scalar(x).value, expected.scalar(x).value);
    EXPECT_EQ(now.scalar(x).gradient, expected.scalar(x).gradient);
    EXPECT_EQ(now.depth_m(x), expected.depth_m(x));
    EXPECT_EQ(now.values_per_sample(), expected.values_per_sample());
    EXPECT_EQ(now.lipschitz_bound(x).slope_per_m, expected.lipschitz_bound(x).slope_per_m);
    for (int row = 0; row < 3; ++row) EXPECT_EQ(now.hessian(x).row[row], expected.hessian(x).row[row]);
    expect_equal(now.piece_along(x, y, 0.0, {-0.2, 0.2}), expected.piece_along(x, y, 0.0, {-0.2, 0.2}));
    DataTime from(0.01 * n + 0.003, n % 2 == 0);
    const Carried carried = timed(*in_memory)->carried(x, from, DataTime(0.01 * n, n % 2 == 0));
    from.stock = &stock;
    EXPECT_EQ(timed(*in_octaves)->carried(x, from, at).position_m, carried.position_m);
    EXPECT_EQ(timed(*in_octaves)->carried(x, from, at).known, carried.known);
  }
  EXPECT_THROW(time_series({octaves[0], whole[1]}, 0.5), std::invalid_argument);
  EXPECT_THROW(time_series({whole[0], octaves[1]}, 0.5), std::invalid_argument);
}

}  // namespace
}  // namespace palpa
