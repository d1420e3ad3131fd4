// Curl, Q and λ2 of flows with known vortices.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "palpa/data/analytic.h"
#include "palpa/data/sampled.h"
#include "palpa/data/smooth_grid.h"
#include "tests/data/derived_grids.h"

namespace palpa {
namespace derived_vortex_test {

using namespace test;
using namespace test::derived_grids;

TEST(Derived, solid_rotation_is_a_vortex_and_pure_strain_is_none) {
  std::mt19937 random(3);
  const Vec3 rate{2, -1, 3};  // Ω
  const FieldPtr turning = vectors(wide, [&](const Vec3& x) { return cross(rate, x); });
  const FieldPtr q = derived(Derivation::q, turning), lambda2 = derived(Derivation::lambda2, turning);
  const FieldPtr curl = derived(Derivation::curl, turning);
  const Mat3 strain{{{1, 0.5, 0}, {0.5, -2, 0.25}, {0, 0.25, 1}}};
  const FieldPtr straining = vectors(wide, [&](const Vec3& x) { return strain * x; });
  const FieldPtr q_strain = derived(Derivation::q, straining), lambda2_strain = derived(Derivation::lambda2, straining);
  double s2 = 0.0;
  for (const Vec3& row : strain.row) s2 += norm_squared(row);
  for (int n = 0; n < 200; ++n) {
    const Vec3 x = random_world(random, wide, 14.0);
    EXPECT_LT(norm(curl->vector(x).value - 2.0 * rate), 1e-4);
    EXPECT_NEAR(q->scalar(x).value, norm_squared(rate), 1e-3);
    EXPECT_NEAR(lambda2->scalar(x).value, -norm_squared(rate), 1e-3);
    EXPECT_NEAR(q_strain->scalar(x).value, -0.5 * s2, 1e-3);
    EXPECT_GT(lambda2_strain->scalar(x).value, 0.0);
  }
}

Mat3 symmetric_part(const Mat3& m) {
  Mat3 half = 0.5 * m;
  const Mat3 other = 0.5 * transposed(m);
  for (int i = 0; i < 3; ++i) half.row[i] += other.row[i];
  return half;
}

/// Number of eigenvalues of a symmetric matrix below `t`: the negative pivots of its elimination (Sylvester).
int eigenvalues_below(const Mat3& m, double t) {
  const auto [xx, xy, xz] = m.row[0];
  const double first = xx - t;
  const double yy = m.row[1].y - t - xy * xy / first, yz = m.row[1].z - xy * xz / first;
  const double last = m.row[2].z - t - xz * xz / first - yz * yz / yy;
  return (first < 0.0) + (yy < 0.0) + (last < 0.0);
}

TEST(Derived, lambda2_is_the_middle_eigenvalue) {
  std::mt19937 random(8);
  for (int n = 0; n < 40; ++n) {
    Mat3 j;
    for (Vec3& row : j.row) row = {uniform(random, -3, 3), uniform(random, -3, 3), uniform(random, -3, 3)};
    if (n % 4 == 1) j = symmetric_part(j);                                      // strain only
    if (n % 4 == 2) j = {{{0, 0, 0}, {j.row[0].x, 0, 0}, {0, 0, j.row[2].z}}};  // shear
    if (n % 4 == 3) j = {{{j.row[0].x, 0, 0}, {0, j.row[0].x, 0}, j.row[2]}};   // two eigenvalues close together
    const FieldPtr lambda2 = derived(Derivation::lambda2, vectors(wide, [&](const Vec3& x) { return j * x; }));
    const Mat3 m = symmetric_part(j * j);
    double size = 0.0;
    for (const Vec3& row : j.row) size += norm_squared(row);
    const double value = lambda2->scalar(random_world(random, wide, 18.0)).value, tolerance = 1e-5 * size;
    EXPECT_LE(eigenvalues_below(m, value - tolerance), 1) << n;
    EXPECT_GE(eigenvalues_below(m, value + tolerance), 2) << n;
  }
}

TEST(Derived, curl_converges_with_the_square_of_the_spacing) {
  std::mt19937 random(5);
  const FieldPtr vortex = lamb_oseen_vortex(0.02, 0.01).fields[0].field;
  std::vector<Vec3> places;
  for (int n = 0; n < 300; ++n) places.push_back(0.3 * within(random, vortex->bounds_m()));
  double error[3];
  for (int n = 0; n < 3; ++n) {
    const FieldPtr curl = derived(Derivation::curl, grid_of_doubles(*vortex, (24 << n) + 1));
    error[n] = 0.0;
    for (const Vec3& x : places) {
      const double r2 = (x.x * x.x + x.y * x.y) / 1e-4;
      const double exact = 0.02 / (std::numbers::pi * 1e-4) * std::exp(-r2);
      error[n] = std::max(error[n], norm(curl->vector(x).value - Vec3{0, 0, exact}));
    }
  }
  EXPECT_NEAR(std::log2(error[1] / error[2]), 2.0, 0.25);
  EXPECT_GT(error[0], error[1]);
}

TEST(Derived, scaling_a_grid_by_a_power_of_two_changes_only_exponents) {
  std::mt19937 random(9);
  const auto flow = [](const Vec3& x) { return Vec3{std::sin(30 * x.y), std::cos(25 * x.z), std::sin(20 * x.x)}; };
  const FieldPtr plain = vectors(wide, flow);
  for (const int exponent : {-30, -3, 20}) {
    const double f = std::ldexp(1.0, exponent);
    const GridGeometry scaled{wide.dims, f * wide.index_to_world_m, f * wide.origin_m};
    const FieldPtr large = vectors(scaled, [&](const Vec3& x) { return flow(x / f); });
    const FieldPtr q = derived(Derivation::q, plain), q_large = derived(Derivation::q, large);
    for (int n = 0; n < 200; ++n) {
      const Vec3 x = random_world(random, wide, 0.1);
      EXPECT_EQ(q->scalar(x).value, f * f * q_large->scalar(f * x).value);
      EXPECT_EQ(q->scalar(x).gradient, f * f * f * q_large->scalar(f * x).gradient);
    }
  }
}

TEST(Derived, neither_an_offset_nor_the_unit_costs_digits) {
  std::mt19937 random(10);
  const auto flow = [](const Vec3& x) { return Vec3{std::sin(30 * x.y), std::cos(25 * x.z), std::sin(20 * x.x)}; };
  const FieldPtr q = derived(Derivation::q, vectors(wide, flow));
  const double size = q->value_ranges()[0].max;
  const FieldPtr far = derived(Derivation::q, vectors(wide, [&](const Vec3& x) { return flow(x) + Vec3{1e6, -1e6, 1e5}; }));
  const FieldPtr tiny = derived(Derivation::q, vectors(wide, [&](const Vec3& x) { return 1e-30 * flow(x); }));
  const FieldPtr huge = derived(Derivation::q, vectors(wide, [&](const Vec3& x) { return 1e40 * flow(x); }));
  for (int n = 0; n < 300; ++n) {
    const Vec3 x = random_world(random, wide, 0.1);
    const double value = q->scalar(x).value;
    EXPECT_NEAR(far->scalar(x).value, value, 1e-5 * size);
    EXPECT_NEAR(tiny->scalar(x).value / 1e-60, value, 1e-5 * size);
    EXPECT_NEAR(huge->scalar(x).value / 1e80, value, 1e-5 * size);
  }
}

/// Middle eigenvalue of (m + mᵀ)/2 by Jacobi's rotations.
double middle_of_symmetric_part(const Mat3& m) {
  const Mat3 t = transposed(m);
  double a[3][3];
  for (int i = 0; i < 3; ++i) {
    const Vec3 row = 0.5 * (m.row[i] + t.row[i]);
    a[i][0] = row.x, a[i][1] = row.y, a[i][2] = row.z;
  }
  for (int sweep = 0; sweep < 30; ++sweep) {
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        const double angle = 0.5 * std::atan2(2.0 * a[p][q], a[q][q] - a[p][p]);
        const double c = std::cos(angle), s = std::sin(angle);
        for (auto& row : a) {
          const double x = row[p], y = row[q];
          row[p] = c * x - s * y, row[q] = s * x + c * y;
        }
        for (int k = 0; k < 3; ++k) {
          const double x = a[p][k], y = a[q][k];
          a[p][k] = c * x - s * y, a[q][k] = s * x + c * y;
        }
      }
    }
  }
  double values[3] = {a[0][0], a[1][1], a[2][2]};
  std::sort(values, values + 3);
  return values[1];
}

/// The header's promise in its plainest form, in double: Gaussian over the finite voxels within reach, then differences; NaN
/// stays NaN.
struct Reference {
  GridGeometry g;
  std::vector<Vec3> u;

  std::int64_t at(std::int64_t i, std::int64_t j, std::int64_t k) const { return (k * g.dims[1] + j) * g.dims[0] + i; }

  std::vector<Vec3> smoothed(double sigma_m) const {
    const Mat3 steps = transposed(g.index_to_world_m);
    double sigma[3];
    for (int a = 0; a < 3; ++a) sigma[a] = sigma_m / norm(steps.row[a]);
    std::vector<Vec3> out(u.size(), Vec3{nan, nan, nan});
    for (std::int64_t k = 0; k < g.dims[2]; ++k)
      for (std::int64_t j = 0; j < g.dims[1]; ++j)
        for (std::int64_t i = 0; i < g.dims[0]; ++i) {
          if (!is_finite(u[at(i, j, k)])) continue;
          Vec3 sum;
          double total = 0.0;
          for (std::int64_t n = 0; n < g.dims[2]; ++n)
            for (std::int64_t m = 0; m < g.dims[1]; ++m)
              for (std::int64_t l = 0; l < g.dims[0]; ++l) {
                const double d[3] = {double(l - i) / sigma[0], double(m - j) / sigma[1], double(n - k) / sigma[2]};
                if (!is_finite(u[at(l, m, n)])) continue;
                const double w = std::exp(-0.5 * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
                sum += w * u[at(l, m, n)];
                total += w;
              }
          out[at(i, j, k)] = sum / total;
        }
    return out;
  }

  /// Jacobian at a voxel; false where it is undefined.
  bool jacobian(const std::vector<Vec3>& v, std::int64_t i, std::int64_t j, std::int64_t k, Mat3& out) const {
    const Vec3 here = v[at(i, j, k)];
    if (!is_finite(here)) return false;
    Mat3 along;  // row = axis of the grid
    for (int a = 0; a < 3; ++a) {
      const auto beside = [&](int step) {
        std::int64_t other[3] = {i, j, k};
        other[a] += step;
        if (other[a] < 0 || other[a] >= g.dims[a]) return Vec3{nan, nan, nan};
        return v[at(other[0], other[1], other[2])];
      };
      const Vec3 low = beside(-1), high = beside(1);
      if (g.dims[a] == 1) continue;
      if (is_finite(low) && is_finite(high)) {
        along.row[a] = 0.5 * (high - low);
      } else if (is_finite(high)) {
        along.row[a] = high - here;
      } else if (is_finite(low)) {
        along.row[a] = here - low;
      } else {
        return false;
      }
    }
    out = transposed(along) * inverse(g.index_to_world_m);
    return true;
  }
};

TEST(Derived, q_and_curl_agree_with_a_plain_reference_gaps_and_all) {
  std::mt19937 random(11);
  const Mat3 steps{{{1e-3, 2e-4, 0}, {0, 1.6e-3, 1e-4}, {0, 0, 2.2e-3}}};
  for (const std::array<std::int64_t, 3> dims : {std::array<std::int64_t, 3>{13, 11, 9}, {12, 1, 6}, {3, 2, 15}, {2, 2, 1}}) {
    for (const double gap_share : {0.0, 0.1, 0.5}) {
      Reference reference{{dims, steps, {}}, {}};
      std::vector<float> values;
      for (std::int64_t n = 0; n < reference.g.voxels(); ++n) {
        float v[3];
        for (float& c : v) c = static_cast<float>(uniform(random, -1, 1));
        if (uniform(random, 0, 1) < gap_share) v[random() % 3] = static_cast<float>(nan);
        reference.u.push_back({v[0], v[1], v[2]});
        values.insert(values.end(), v, v + 3);
      }
      const FieldPtr source = grid_field(reference.g, voxels_of(std::move(values), 3));
      const double sigma_m = 2e-3;
      const std::vector<Vec3> smoothed = reference.smoothed(sigma_m);
      for (const Derivation d : {Derivation::q, Derivation::lambda2, Derivation::curl}) {
        const FieldPtr field = derived(d, source, sigma_m);
        const GridView& found = *smooth_grid_of(*field);
        const auto* raw = static_cast<const float*>(found.voxels.data.get());
        for (std::int64_t k = 0; k < dims[2]; ++k)
          for (std::int64_t j = 0; j < dims[1]; ++j)
            for (std::int64_t i = 0; i < dims[0]; ++i) {
              Mat3 jac;
              const std::int64_t at = reference.at(i, j, k);
              const bool defined = reference.jacobian(d == Derivation::curl ? reference.u : smoothed, i, j, k, jac);
              if (d == Derivation::curl) {
                const Vec3 curl{jac.row[2].y - jac.row[1].z, jac.row[0].z - jac.row[2].x, jac.row[1].x - jac.row[0].y};
                const Vec3 is{raw[3 * at] * found.scale, raw[3 * at + 1] * found.scale, raw[3 * at + 2] * found.scale};
                ASSERT_EQ(is_finite(is), defined);
                EXPECT_TRUE(!defined || norm(is - curl) < 1e-3);
                continue;
              }
              const double is = raw[at] * found.scale + found.offset;
              ASSERT_EQ(std::isfinite(is), defined);
              if (!defined) continue;
              const Mat3 j2 = jac * jac;
              const double q = -0.5 * (j2.row[0].x + j2.row[1].y + j2.row[2].z);
              double j_norm = 0.0;
              for (const Vec3& row : jac.row) j_norm += norm_squared(row);
              if (d == Derivation::q) {
                EXPECT_NEAR(is, q, 2e-3 * j_norm + 1e-9);
              } else {
                EXPECT_NEAR(is, middle_of_symmetric_part(j2), 4e-3 * j_norm + 1e-9);
              }
            }
      }
    }
  }
}

TEST(Derived, a_mark_for_no_data_spoils_only_its_neighbourhood) {
  const GridGeometry g{{40, 40, 40}, 1e-3 * Mat3::identity(), {}};
  const auto flow = [](const Vec3& x) { return Vec3{std::sin(300 * x.y), std::cos(250 * x.z), std::sin(200 * x.x)}; };
  const FieldPtr clean = derived(Derivation::q, vectors(g, flow));
  const FieldPtr marked = derived(Derivation::q, vectors(g, [&](const Vec3& x) {
                                    return norm(x) < 4e-3 ? Vec3{-9.97e36, -9.97e36, -9.97e36} : flow(x);
                                  }));
  std::mt19937 random(13);
  for (int n = 0; n < 300; ++n) {
    const Vec3 x = within(random, {{20e-3, 20e-3, 20e-3}, {38e-3, 38e-3, 38e-3}});
    EXPECT_NEAR(marked->scalar(x).value, clean->scalar(x).value, 1e-4 * clean->value_ranges()[0].max);
  }
  for (int n = 0; n < 1000; ++n) {
    const ScalarSample s = marked->scalar(within(random, g.dims[0] ? marked->bounds_m() : Box{}));
    EXPECT_TRUE(std::isfinite(s.value) && is_finite(s.gradient));
  }
}

TEST(Derived, signs_tell_a_vortex_core_from_its_surroundings) {
  const FieldPtr vortex = sampled(*lamb_oseen_vortex(0.02, 0.01).fields[0].field, 97);
  const FieldPtr q = derived(Derivation::q, vortex), lambda2 = derived(Derivation::lambda2, vortex);
  for (const double angle : {0.0, 1.0, 2.5, 4.0}) {
    for (const double z : {-0.02, 0.0, 0.03}) {
      const auto at = [&](double r) { return Vec3{r * std::cos(angle), r * std::sin(angle), z}; };
      for (const double r : {0.0, 0.004, 0.008}) {
        EXPECT_GT(q->scalar(at(r)).value, 0.0);
        EXPECT_LT(lambda2->scalar(at(r)).value, 0.0);
      }
      for (const double r : {0.018, 0.025, 0.04}) {
        EXPECT_LT(q->scalar(at(r)).value, 0.0);
        EXPECT_GT(lambda2->scalar(at(r)).value, 0.0);
      }
    }
  }
}

/// Findings 9: sampled vortices with cores of 3 voxels and more, on any grid, with and without cross-flow: ∇Q points to the
/// core within 2° at p99, wherever Q is above 5 % of its largest and r >= 0.3 r_c.
TEST(Derived, gradient_of_q_points_to_the_core_of_a_vortex) {
  std::mt19937 random(15);
  constexpr double core_m = 0.01, rate_per_s = 30.0;
  double worst = 0.0;
  for (const double voxels_per_core : {3.0, 4.0, 6.0}) {
    for (const double strain_per_s : {0.0, 0.05 * rate_per_s}) {
      for (const double cross_flow : {0.0, 0.5, 1.0}) {
        for (int orientation = 0; orientation < 3; ++orientation) {
          const Mat3 turn = orientation == 0 ? Mat3::identity() : rotation(random);  // grid → vortex
          const double step_m = core_m / voxels_per_core;
          const auto n = static_cast<std::int64_t>(2.0 * std::ceil(4.5 * voxels_per_core)) + 1;
          const Vec3 shift{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
          const GridGeometry g{
              {n, n, n}, step_m * turn, turn * (-0.5 * step_m * (Vec3{double(n - 1), double(n - 1), double(n - 1)} + shift))};
          const Vec3 across = cross_flow * 0.6382 * rate_per_s * core_m *
                              normalized({uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)});
          const FieldPtr flow = vectors(g, [&](const Vec3& x) {
            const double s = (x.x * x.x + x.y * x.y) / (core_m * core_m);
            const double w = rate_per_s * (s > 1e-12 ? -std::expm1(-s) / s : 1.0);
            return Vec3{-w * x.y - 0.5 * strain_per_s * x.x, w * x.x - 0.5 * strain_per_s * x.y, strain_per_s * x.z} + across;
          });
          const FieldPtr q = derived(Derivation::q, flow);
          const double largest = q->value_ranges()[0].max;
          std::vector<double> angles;
          for (int m = 0; m < 4000; ++m) {
            const double r = uniform(random, 0.3, 2.0) * core_m, angle = uniform(random, 0, 2.0 * std::numbers::pi);
            const Vec3 x{r * std::cos(angle), r * std::sin(angle), uniform(random, -1, 1) * core_m};
            const ScalarSample s = q->scalar(x);
            if (!s.inside || s.value < 0.05 * largest) continue;
            const Vec3 to_core{-std::cos(angle), -std::sin(angle), 0.0};
            const Vec3 felt = normalized(s.gradient);
            angles.push_back(std::atan2(norm(cross(felt, to_core)), dot(felt, to_core)) * 180.0 / std::numbers::pi);
          }
          ASSERT_GT(angles.size(), 1000u);
          std::sort(angles.begin(), angles.end());
          const double p99 = angles[angles.size() * 99 / 100];
          worst = std::max(worst, p99);
          EXPECT_LE(p99, 2.0) << voxels_per_core << " voxels, strain " << strain_per_s << ", cross-flow " << cross_flow;
        }
      }
    }
  }
  RecordProperty("worst_p99_deg", std::to_string(worst));
}

}  // namespace derived_vortex_test
}  // namespace palpa
