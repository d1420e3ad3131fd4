// Selection of a CT's voxel values.
#include "palpa/data/ct.h"

#include <gtest/gtest.h>

#include <random>
#include <string_view>

namespace palpa {
namespace ct_test {

/// Tissues of these values, each with a share [1] of the voxels and a little noise.
struct Tissue {
  double value, share;
};
Statistics of_tissues(std::initializer_list<Tissue> tissues, double shift = 0.0) {
  constexpr std::int64_t side = 40;
  const auto raw = std::make_shared<std::vector<std::int16_t>>();
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 6.0);
  for (const Tissue& tissue : tissues) {
    for (double n = 0; n < tissue.share * side * side * side && raw->size() < side * side * side; ++n)
      raw->push_back(static_cast<std::int16_t>(std::max(tissue.value + noise(random), -1024.0) + shift));
  }
  raw->resize(side * side * side, static_cast<std::int16_t>(-1000.0 + shift));
  const GridGeometry grid{{side, side, side}, Mat3::identity(), {}};
  return statistics(*grid_field(grid, {VoxelType::int16, 1, {raw, raw->data()}}));
}

const std::initializer_list<Tissue> head{{-1000, 0.55}, {-600, 0.04}, {-90, 0.01}, {35, 0.28}, {60, 0.02}, {900, 0.1}};
const std::initializer_list<Tissue> chest{{-1000, 0.4}, {-800, 0.3}, {-100, 0.1}, {50, 0.15}, {700, 0.05}};
const std::initializer_list<Tissue> belly{{-1000, 0.4}, {-100, 0.2}, {55, 0.35}, {600, 0.05}};
const std::initializer_list<Tissue> dry_skull{{-1000, 0.8}, {500, 0.1}, {1200, 0.1}};

TEST(Ct, ItsWaterIsFoundWithAndWithoutTheOffset) {
  for (const auto& tissues : {head, chest, belly}) {
    EXPECT_EQ(ct_water(of_tissues(tissues), ""), 0.0);
    EXPECT_EQ(ct_water(of_tissues(tissues), "HU"), 0.0);
    EXPECT_FALSE(ct_water(of_tissues(tissues), "K"));
  }
  EXPECT_EQ(ct_water(of_tissues(head, 1024.0), ""), 1024.0);
  EXPECT_FALSE(ct_water(of_tissues({{0, 0.4}, {300, 0.3}, {600, 0.2}, {900, 0.1}}, 1000.0), "")) << "values on no scale of CT";
}

TEST(Ct, WhatTheFileSaysGoesBeforeWhatItsValuesLookLike) {
  for (const auto& tissues : {head, chest, belly}) {
    for (const double offset : {0.0, 1024.0}) {
      const Statistics values = of_tissues(tissues, offset);
      for (const char* modality : {"MR", "PT", "NM", "US", "RTDOSE", "SEG", "OT"}) {
        EXPECT_FALSE(ct_water(values, "", modality)) << modality;
        EXPECT_FALSE(looks_like_hounsfield(values, "", modality)) << modality;
      }
      EXPECT_EQ(ct_water(values, "", "CT"), ct_water(values, ""));
      EXPECT_FALSE(ct_water(values, "K", "CT"));
    }
    EXPECT_TRUE(looks_like_hounsfield(of_tissues(tissues), "", "CT"));
  }
}

TEST(Ct, TheWindowShowsWhatIsThere) {
  const auto name = [](const Statistics& values, double water, const char* body_part, double widest_m = 0.25) {
    return std::string_view(ct_window(values, water, body_part, widest_m).name);
  };
  EXPECT_EQ(name(of_tissues(head), 0, ""), "brain");
  EXPECT_EQ(name(of_tissues(head), 0, "brain"), "brain");
  EXPECT_EQ(name(of_tissues(head, 1024), 1024, ""), "brain") << "the offset does not matter";
  EXPECT_EQ(name(of_tissues(head), 0, "", 0.5), "soft tissue") << "no head is that wide";
  EXPECT_EQ(name(of_tissues(chest), 0, ""), "lung");
  EXPECT_EQ(name(of_tissues(chest), 0, "chest"), "lung");
  EXPECT_EQ(name(of_tissues(belly), 0, "", 0.4), "soft tissue");
  EXPECT_EQ(name(of_tissues(belly), 0, "abdomen", 0.4), "soft tissue");
  EXPECT_EQ(name(of_tissues(belly), 0, "spine", 0.4), "bone");
  EXPECT_EQ(name(of_tissues(dry_skull), 0, "head"), "bone") << "where no brain is, its window shows nothing";
}

}  // namespace ct_test
}  // namespace palpa
