// Shared parts of field tests: random positions, grids of known functions, finite differences.
#pragma once

#include <gmock/gmock.h>

#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "palpa/data/grid.h"

namespace palpa::test {

inline double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
}
inline Vec3 within(std::mt19937& random, const Box& box) {
  return {uniform(random, box.low_m.x, box.high_m.x), uniform(random, box.low_m.y, box.high_m.y),
          uniform(random, box.low_m.z, box.high_m.z)};
}
inline Mat3 rotation(std::mt19937& random) {
  const Vec3 a = normalized({uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)});
  const Vec3 b = normalized(cross(a, {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)}));
  return {{a, b, cross(a, b)}};
}

template <class T>
struct VoxelTypeOf;
template <>
struct VoxelTypeOf<std::uint8_t> {
  static constexpr auto value = VoxelType::uint8;
};
template <>
struct VoxelTypeOf<std::int16_t> {
  static constexpr auto value = VoxelType::int16;
};
template <>
struct VoxelTypeOf<std::uint16_t> {
  static constexpr auto value = VoxelType::uint16;
};
template <>
struct VoxelTypeOf<std::int32_t> {
  static constexpr auto value = VoxelType::int32;
};
template <>
struct VoxelTypeOf<float> {
  static constexpr auto value = VoxelType::float32;
};
template <>
struct VoxelTypeOf<double> {
  static constexpr auto value = VoxelType::float64;
};

template <class T>
Voxels voxels_of(std::vector<T> values, int components = 1) {
  auto owner = std::make_shared<std::vector<T>>(std::move(values));
  return {VoxelTypeOf<T>::value, components, std::shared_ptr<const void>(owner, owner->data())};
}

/// A grid of double over a field's box, n voxels along every axis: no rounding of voxels.
inline FieldPtr grid_of_doubles(const Field& field, int n) {
  const Box box = field.bounds_m();
  const Vec3 step = box.size_m() / (n - 1);
  const GridGeometry geometry{{n, n, n}, {{{step.x, 0, 0}, {0, step.y, 0}, {0, 0, step.z}}}, box.low_m};
  std::vector<double> values;
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        Vec3 at = geometry.to_world({double(i), double(j), double(k)});
        at = {std::min(at.x, box.high_m.x), std::min(at.y, box.high_m.y), std::min(at.z, box.high_m.z)};
        if (field.components() == 1) {
          values.push_back(field.scalar(at).value);
        } else {
          const Vec3 v = field.vector(at).value;
          values.insert(values.end(), {v.x, v.y, v.z});
        }
      }
    }
  }
  return grid_field(geometry, voxels_of(std::move(values), field.components()));
}

inline Vec3 axis(int a) { return {a == 0 ? 1.0 : 0.0, a == 1 ? 1.0 : 0.0, a == 2 ? 1.0 : 0.0}; }

/// The gradient by central differences of fourth order.
inline Vec3 numeric_gradient(const Field& field, const Vec3& at, double h) {
  double g[3];
  for (int a = 0; a < 3; ++a) {
    const auto f = [&](double steps) { return field.scalar(at + steps * h * axis(a)).value; };
    g[a] = (8.0 * (f(1) - f(-1)) - (f(2) - f(-2))) / (12.0 * h);
  }
  return {g[0], g[1], g[2]};
}
inline Mat3 numeric_jacobian(const Field& field, const Vec3& at, double h) {
  Mat3 columns;
  for (int a = 0; a < 3; ++a) {
    const auto f = [&](double steps) { return field.vector(at + steps * h * axis(a)).value; };
    columns.row[a] = (8.0 * (f(1) - f(-1)) - (f(2) - f(-2))) / (12.0 * h);
  }
  return transposed(columns);
}

inline double largest_difference(const Mat3& a, const Mat3& b) {
  double largest = 0.0;
  for (int i = 0; i < 3; ++i) largest = std::max(largest, largest_component(a.row[i] - b.row[i]));
  return largest;
}

/// Invalid positions: each coordinate NaN, infinite or huge, alone and together.
inline std::vector<Vec3> absurd_positions() {
  std::vector<Vec3> positions;
  const double absurd[] = {std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity(),
                           1.7e308,
                           -1.7e308,
                           1e200,
                           1e20,
                           -1e20};
  for (const double a : absurd) {
    positions.insert(positions.end(), {{a, 0, 0}, {0, a, 0}, {0, 0, a}, {a, a, a}, {a, -a, a}});
  }
  return positions;
}

/// For any field and position: outside is all zero, and every number is finite.
inline void expect_outside_and_finite(const Field& field, const Vec3& at) {
  const ScalarSample s = field.scalar(at);
  EXPECT_FALSE(s.inside);
  EXPECT_EQ(s.value, 0.0);
  EXPECT_EQ(s.gradient, Vec3{});
  const VectorSample v = field.vector(at);
  EXPECT_FALSE(v.inside);
  EXPECT_EQ(v.value, Vec3{});
  EXPECT_EQ(v.jacobian, Mat3{});
  EXPECT_LE(field.depth_m(at), 0.0);
  EXPECT_TRUE(std::isfinite(field.depth_m(at)));
}

}  // namespace palpa::test
