// Which numbers of a CT are looked at, and what is a label map.
#include "palpa/field/ct.h"

#include <gtest/gtest.h>

#include <random>
#include <string_view>

#include "palpa/field/labels.h"

namespace palpa {
namespace {

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

TEST(Labels, AreWholeNumbersOfPartsSideBySide) {
  constexpr std::int64_t side = 32;
  const GridGeometry grid{{side, side, side}, Mat3::identity(), {}};
  const auto field = [&](auto value, auto number) {
    using Number = decltype(number);
    const auto raw = std::make_shared<std::vector<Number>>();
    for (std::int64_t k = 0; k < side; ++k)
      for (std::int64_t j = 0; j < side; ++j)
        for (std::int64_t i = 0; i < side; ++i) raw->push_back(static_cast<Number>(value(i, j, k)));
    const VoxelType type = std::is_same_v<Number, std::uint8_t> ? VoxelType::uint8 : VoxelType::float32;
    return grid_field(grid, {type, 1, {raw, raw->data()}});
  };
  const auto labels = [](const FieldPtr& f) { return is_label_map(*f); };
  const auto octants = [](auto i, auto j, auto k) { return i / 16 + 2 * (j / 16) + 4 * (k / 16); };
  std::mt19937 random(5);
  EXPECT_TRUE(labels(field(octants, std::uint8_t{})));
  EXPECT_TRUE(labels(field(octants, float{}))) << "the type does not matter";
  EXPECT_TRUE(labels(field([](auto i, auto, auto) { return i > 7 && i < 20 ? 1 : 0; }, std::uint8_t{}))) << "a mask";
  EXPECT_FALSE(labels(field([&](auto, auto, auto) { return random() % 200; }, std::uint8_t{}))) << "noise";
  EXPECT_FALSE(labels(field([](auto i, auto j, auto k) { return 2 * i + j + k; }, std::uint8_t{}))) << "a ramp";
  EXPECT_FALSE(labels(field([&](auto i, auto j, auto k) { return 0.5 + octants(i, j, k); }, float{}))) << "fractions";
  EXPECT_FALSE(labels(field([](auto, auto, auto) { return 3; }, std::uint8_t{}))) << "one value";
}

}  // namespace
}  // namespace palpa
