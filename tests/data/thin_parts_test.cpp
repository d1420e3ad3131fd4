// Loss of thin parts by the smoothing filter, against countable shapes and a recount.
#include "palpa/data/thin_parts.h"

#include <algorithm>

#include "palpa/data/analytic.h"
#include "palpa/data/filter.h"
#include "palpa/data/sampled.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/timed_field.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace thin_parts_test {

using namespace test;

const GridGeometry box{{12, 11, 10}, 1e-3 * Mat3::identity(), {}};

template <class Solid>
std::vector<std::int16_t> voxels_where(const GridGeometry& g, Solid solid, std::int16_t in = 1000, std::int16_t out = 0) {
  std::vector<std::int16_t> values;
  for (std::int64_t k = 0; k < g.dims[2]; ++k)
    for (std::int64_t j = 0; j < g.dims[1]; ++j)
      for (std::int64_t i = 0; i < g.dims[0]; ++i) values.push_back(solid(i, j, k) ? in : out);
  return values;
}

TEST(ThinParts, a_plate_of_one_voxel_is_thin_and_one_of_two_is_not) {
  for (int a = 0; a < 3; ++a) {
    const auto plate = [&](int thick) {
      return grid_field(box, voxels_of(voxels_where(box, [&](auto i, auto j, auto k) {
                          const std::int64_t at = a == 0 ? i : a == 1 ? j : k;
                          return at >= 5 && at < 5 + thick;
                        })));
    };
    const std::int64_t area = box.voxels() / box.dims[a];
    // A plate of one voxel keeps 4/6 of its value, a plate of two 5/6.
    const ThinParts below = thin_parts(*plate(1), 600), above = thin_parts(*plate(1), 700), two = thin_parts(*plate(2), 700);
    EXPECT_EQ(below.solid, area);
    EXPECT_EQ(below.thin, area);
    EXPECT_EQ(below.lost, 0);
    EXPECT_EQ(above.thin, area);
    EXPECT_EQ(above.lost, area);
    EXPECT_EQ(above.lost_share(), 1.0);
    EXPECT_EQ(two.solid, 2 * area);
    EXPECT_EQ(two.thin, 0);
    EXPECT_EQ(two.lost_share(), 0.0);
  }
}

TEST(ThinParts, low_is_the_mirror_of_high) {
  std::mt19937 random(1);
  std::vector<float> values, negative;
  for (std::int64_t n = 0; n < box.voxels(); ++n) {
    values.push_back(static_cast<float>(uniform(random, -1, 1)));
    negative.push_back(-values.back());
  }
  const ThinParts high = thin_parts(*grid_field(box, voxels_of(values)), 0.2, SolidSide::high);
  const ThinParts low = thin_parts(*grid_field(box, voxels_of(negative)), -0.2, SolidSide::low);
  EXPECT_EQ(high.solid, low.solid);
  EXPECT_EQ(high.thin, low.thin);
  EXPECT_EQ(high.lost, low.lost);
  EXPECT_GT(high.lost, 0);
}

TEST(ThinParts, are_what_a_plain_count_finds_with_samples_of_the_smooth_field) {
  std::mt19937 random(2);
  for (const std::array<std::int64_t, 3> dims :
       {std::array<std::int64_t, 3>{12, 11, 10}, {2, 2, 2}, {5, 1, 6}, {1, 7, 1}, {6, 5, 1}, {1, 1, 1}, {4, 4, 3}, {3, 3, 2}}) {
    const GridGeometry g{dims, 1e-3 * Mat3::identity(), {}};
    for (const double share : {0.3, 0.7, 0.95}) {
      std::vector<float> values;
      for (std::int64_t n = 0; n < g.voxels(); ++n) values.push_back(static_cast<float>(uniform(random, 0, 1)));
      if (g.voxels() > 100) values[77] = std::numeric_limits<float>::quiet_NaN();
      const double level = 1.0 - share;
      const FieldPtr field = grid_field(g, voxels_of(values), 2.0, 1.0);
      const auto solid = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        return values[static_cast<std::size_t>((k * g.dims[1] + j) * g.dims[0] + i)] * 2.0 + 1.0 >= level * 2.0 + 1.0;
      };
      const auto full = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        for (std::int64_t c = 0; c < 8; ++c) {
          const std::int64_t at[3] = {i + (g.dims[0] > 1 ? c & 1 : 0), j + (g.dims[1] > 1 ? c >> 1 & 1 : 0),
                                      k + (g.dims[2] > 1 ? c >> 2 : 0)};
          for (int a = 0; a < 3; ++a) {
            if (at[a] < 0 || at[a] >= g.dims[a]) return false;
          }
          if (!solid(at[0], at[1], at[2])) return false;
        }
        return true;
      };
      const FieldPtr smooth = smooth_grid_field(g, voxels_of(values), 2.0, 1.0);
      ThinParts wanted;
      for (std::int64_t k = 0; k < g.dims[2]; ++k)
        for (std::int64_t j = 0; j < g.dims[1]; ++j)
          for (std::int64_t i = 0; i < g.dims[0]; ++i) {
            if (!solid(i, j, k)) continue;
            ++wanted.solid;
            bool thick = false;
            for (int c = 0; c < 8; ++c) thick = thick || full(i - (c & 1), j - (c >> 1 & 1), k - (c >> 2));
            if (thick) continue;
            ++wanted.thin;
            double smoothed = 0.0;
            for (int c = 0; c < 27; ++c) {
              const int di = c % 3 - 1, dj = c / 3 % 3 - 1, dk = c / 9 - 1;
              const auto at = [](std::int64_t n, std::int64_t count) { return std::clamp<std::int64_t>(n, 0, count - 1); };
              const std::int64_t v =
                  (at(k + dk, g.dims[2]) * g.dims[1] + at(j + dj, g.dims[1])) * g.dims[0] + at(i + di, g.dims[0]);
              smoothed += (di ? 1.0 : 4.0) * (dj ? 1.0 : 4.0) * (dk ? 1.0 : 4.0) / 216.0 * (2.0 * values[v] + 1.0);
            }
            const ScalarSample s = smooth->scalar(g.to_world({double(i), double(j), double(k)}));
            if (s.inside) {
              EXPECT_NEAR(s.value, smoothed, 1e-6);
            }
            wanted.lost += smoothed < level * 2.0 + 1.0;
          }
      for (const FieldPtr& same : {field, smooth, posed(field, {rotation(random), 3.0, {1, 2, 3}})}) {
        const ThinParts found = thin_parts(*same, level * 2.0 + 1.0);
        EXPECT_EQ(found.solid, wanted.solid);
        EXPECT_EQ(found.thin, wanted.thin);
        EXPECT_EQ(found.lost, wanted.lost);
      }
    }
  }
}

TEST(ThinParts, need_voxels_of_numbers) {
  EXPECT_THROW(thin_parts(*sphere_field().fields[0].field, 0.0), std::invalid_argument);
  EXPECT_THROW(thin_parts(*sampled(*lamb_oseen_vortex().fields[0].field, 8), 0.0), std::invalid_argument);
}

}  // namespace thin_parts_test
}  // namespace palpa
