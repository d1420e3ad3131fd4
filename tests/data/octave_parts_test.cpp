// Parts of volumes larger than memory: samples of octave 0, and octaves for pictures.
#include "palpa/data/octave_parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/data/pyramid.h"

namespace palpa {
namespace {

/// Two classes of values that alternate every other voxel within a body: gone in the first coarser octave.
FieldPtr fine_grains(std::array<std::int64_t, 3> dims, int components = 1) {
  GridGeometry grid{dims, {{{2e-3, 0, 0}, {0, 3e-3, 0}, {0, 0, 2e-3}}}, {0.1, -0.2, 0.3}, {}};
  const std::shared_ptr<float[]> values(new float[static_cast<std::size_t>(grid.voxels() * components)]);
  std::mt19937 random(5);
  std::normal_distribution<float> noise(0.0F, 3.0F);
  float* to = values.get();
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const bool within = i > dims[0] / 3;
        for (int c = 0; c < components; ++c)
          *to++ = (within ? ((i + j + k) % 2 == 0 ? 200.0F : 100.0F) : 10.0F) + noise(random);
      }
    }
  }
  return grid_field(grid, {VoxelType::float32, components, values});
}

TEST(OctaveParts, HaveTheVoxelsOfTheWholeAndThePlacesOfTheirOctave) {
  const FieldPtr whole = fine_grains({70, 45, 50});
  const auto octaves = test::in_octaves(*whole, 3);
  const FieldPtr part = octave_part(*octaves, 0, {5, 6, 7}, {20, 10, 12});
  for (std::int64_t n = 0; n < 12; ++n) {
    const Vec3 at = grid_behind(*whole)->geometry.to_world({5.0 + static_cast<double>(n), 8.0, 9.0});
    EXPECT_NEAR(part->scalar(at).value, whole->scalar(at).value, 1e-9);
  }
  // The middle of a voxel of octave 1 is that of the 2 × 2 × 2 finer ones, and its value their mean.
  const FieldPtr coarse = octave_part(*octaves, 1, {}, octaves->dims(1));
  const Vec3 middle = grid_behind(*whole)->geometry.to_world({10.5, 20.5, 30.5});
  double mean = 0.0;
  for (int n = 0; n < 8; ++n)
    mean +=
        whole->scalar(grid_behind(*whole)->geometry.to_world({10.0 + (n & 1), 20.0 + (n >> 1 & 1), 30.0 + (n >> 2)})).value / 8;
  EXPECT_NEAR(coarse->scalar(middle).value, mean, 1e-4);
}

TEST(OctaveParts, StatisticsAreThoseOfTheVoxelsNotOfMeans) {
  for (const int components : {1, 3}) {
    const FieldPtr whole = fine_grains({200, 150, 180}, components);
    const auto octaves = test::in_octaves(*whole, 3);
    const Statistics all = statistics(*whole), sample = statistics(*octaves);
    EXPECT_GT(sample.counted, 1'000'000);
    for (const double share : {0.1, 0.25, 0.5, 0.75, 0.9})
      EXPECT_NEAR(sample.percentile(share), all.percentile(share), 0.04 * (all.max - all.min)) << share;
    EXPECT_NEAR(sample.mean, all.mean, 0.05 * (all.max - all.min));
    if (components == 3) continue;
    EXPECT_EQ(std::pair(sample.min, sample.max), std::pair(all.min, all.max));
    // The law would fail on the coarsest octave, whose largest values are means of both classes.
    EXPECT_LT(octaves->coarsest().grid->value_ranges().front().max, 180.0);
  }
}

TEST(OctaveParts, ASampleOfASmallGridIsAllOfIt) {
  const FieldPtr whole = fine_grains({90, 70, 33});
  const Statistics all = statistics(*whole), sample = statistics(*test::in_octaves(*whole, 2));
  EXPECT_EQ(sample.counted, all.counted);
  EXPECT_EQ(sample.one_in, 1);
  EXPECT_EQ(sample.histogram.counts, all.histogram.counts);
  EXPECT_NEAR(sample.deviation, all.deviation, 1e-9 * all.deviation);
}

TEST(OctaveParts, APictureTakesTheCoarsestOctaveThatIsFineEnough) {
  const FieldPtr whole = fine_grains({600, 40, 40});
  const auto octaves = test::in_octaves(*whole, 4);
  const Box box = whole->bounds_m();
  const auto octave_of = [&](const Box& within, double step_m) { return drawn_octave(*octaves, {}, within, step_m)->octave; };
  EXPECT_EQ(octave_of(box, 0.0161), 3);
  EXPECT_EQ(octave_of(box, 0.0159), 2);
  EXPECT_EQ(octave_of(box, 1e-6), 2);  // 150 voxels; octave 1 has 300, which are too many
  EXPECT_EQ(octave_of(box, 1.0), 3);
  const Box near{box.low_m, box.low_m + 0.2 * box.size_m()};
  EXPECT_EQ(octave_of(near, 1e-6), 0);
  EXPECT_FALSE(drawn_octave(*octaves, {}, {box.low_m - Vec3{2, 2, 2}, box.low_m - Vec3{1, 1, 1}}, 1e-3));
  EXPECT_FALSE(drawn_octave(*whole, {}, box, 1e-3));

  // Below a pose the same voxels, where the pose puts them.
  const Similarity pose{rotation_about({0, 0, 1}, 30.0), 2.0, {1, 2, 3}};
  const FieldPtr moved = posed(octaves, pose);
  const auto drawn = drawn_octave(*moved, {}, moved->bounds_m(), 0.0321);
  ASSERT_TRUE(drawn);
  EXPECT_EQ(drawn->octave, 3);
  EXPECT_NEAR(drawn->voxel_m, 0.032, 1e-12);
  const Vec3 place = box.centre_m();
  EXPECT_NEAR(drawn->field->scalar(pose.to_world(place)).value, octaves->scalar(place).value, 1e-3);
  EXPECT_EQ(statistics(*moved).histogram.counts, statistics(*octaves).histogram.counts);
  EXPECT_EQ(octaves_below(*moved), octaves.get());
  EXPECT_FALSE(changes_with_time(*moved));
  EXPECT_TRUE(changes_with_time(*moving(octaves, {{0.0, {}}, {1.0, pose}})));
  EXPECT_FALSE(changes_with_time(*whole));
}

/// A source that has lost octave 1.
class Lossy final : public VoxelSource {
 public:
  explicit Lossy(std::shared_ptr<VoxelSource> of) : of_(std::move(of)) {}
  bool read(int octave, const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& dims,
            std::byte* to) override {
    return octave != 1 && !(octave == 0 && first[0] > 0) && of_->read(octave, first, dims, to);
  }

 private:
  std::shared_ptr<VoxelSource> of_;
};

TEST(OctaveParts, LostVoxelsAreLeftOut) {
  Octaves::Shape shape = test::in_octaves(*fine_grains({100, 64, 64}), 3)->shape();
  shape.source = std::make_shared<Lossy>(shape.source);
  const Octaves octaves(std::move(shape));
  EXPECT_EQ(drawn_octave(octaves, {}, octaves.bounds_m(), 7e-3)->octave, 2);
  EXPECT_EQ(octave_sample(octaves).size(), 4U);  // of 4 × 2 × 2 blocks
  EXPECT_GT(statistics(octaves).counted, 0);
}

}  // namespace
}  // namespace palpa
