#include "palpa/data/derive_on_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "palpa/data/grid_base.h"
#include "palpa/data/grid_work.h"
#include "palpa/data/parallel.h"
#include "palpa/data/quantile.h"
#include "palpa/data/smooth_grid.h"

// Streams over slices: each thread reads a slice, smooths it along i and j into a ring as long as the Gaussian's support along
// k, keeps three completely smoothed slices, and differentiates the middle one. Rows are contiguous floats, a plane per
// component, so that every loop over i vectorises.

namespace palpa::detail {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

bool only_smooths(Derivation derivation) noexcept {
  return derivation == Derivation::smooth || derivation == Derivation::smooth_vector;
}

/// Values of the source at the nodes, row by row: its voxels, or samples of any field.
class Nodes {
 public:
  Nodes(const Field& of, const GridGeometry& geometry)
      : of_(of), grid_(grid_behind(of)), geometry_(geometry), box_(of.bounds_m()), components_(of.components()) {
    if (grid_ && grid_->geometry.is_rectilinear()) grid_ = nullptr;
  }

  int components() const noexcept { return components_; }
  const GridGeometry& geometry() const noexcept { return geometry_; }
  bool has_gaps() const noexcept { return !grid_ || grid_->valid_share < 1.0; }

  /// Row at (j, k), components interleaved; a node with a non-finite value is NaN in all.
  void row(std::int64_t j, std::int64_t k, double* out) const noexcept {
    const std::int64_t n = geometry_.dims[0];
    if (grid_) {
      const std::int64_t first = (k * geometry_.dims[1] + j) * n * components_;
      with_values_of(grid_->voxels, [&](const auto* values) {
        for (std::int64_t v = 0; v < n * components_; ++v) {
          out[v] = static_cast<double>(values[first + v]) * grid_->scale + grid_->offset;
        }
      });
    } else {
      for (std::int64_t i = 0; i < n; ++i) sample({double(i), double(j), double(k)}, out + i * components_);
    }
    if (components_ == 3 && has_gaps()) {
      for (double* v = out; v < out + 3 * n; v += 3) {
        if (!std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2])) v[0] = v[1] = v[2] = nan;
      }
    }
  }

 private:
  void sample(const GridPoint& p, double* out) const noexcept {
    const Vec3 at = within(box_, geometry_.to_world(p));
    if (components_ == 1) {
      const ScalarSample s = of_.scalar(at);
      out[0] = s.inside ? s.value : nan;
      return;
    }
    const VectorSample s = of_.vector(at);
    out[0] = s.inside ? s.value.x : nan;
    out[1] = s.inside ? s.value.y : nan;
    out[2] = s.inside ? s.value.z : nan;
  }

  const Field& of_;
  const GridView* grid_;
  GridGeometry geometry_;
  Box box_;
  int components_;
};

/// Normalisation of floats: value = centre + unit · float, so that neither a large offset nor an unusual unit costs digits.
/// Centre: median; unit: geometric mean (as a power of two), over some 4000 nodes: a marker like −1e30 for "no data" moves
/// neither.
struct Normal {
  double centre[3] = {0.0, 0.0, 0.0};
  double unit = 1.0;
};

Normal normal_of(const Nodes& nodes) {
  const auto& dims = nodes.geometry().dims;
  const int components = nodes.components();
  constexpr std::int64_t rows = 64, in_row = 64;  // values sampled. More: slower; fewer: a less certain median
  std::vector<double> row(static_cast<std::size_t>(dims[0]) * components);
  std::vector<double> found[3];
  const std::int64_t all_rows = dims[1] * dims[2];
  const std::int64_t row_count = std::min(rows, all_rows), count = std::min(in_row, dims[0]);
  for (std::int64_t r = 0; r < row_count; ++r) {
    const std::int64_t at = (2 * r + 1) * (all_rows / row_count) / 2;
    nodes.row(at % dims[1], at / dims[1], row.data());
    for (std::int64_t i = 0; i < count; ++i) {
      for (int c = 0; c < components; ++c) {
        const double value = row[(2 * i + 1) * (dims[0] / count) / 2 * components + c];
        if (std::isfinite(value)) found[c].push_back(value);
      }
    }
  }
  Normal normal;
  double sum = 0.0;
  std::int64_t terms = 0;
  for (int c = 0; c < components; ++c) {
    if (found[c].empty()) continue;
    normal.centre[c] = median(found[c]);
    for (const double value : found[c]) {
      const double far = std::abs(value - normal.centre[c]);
      if (!(far > 0.0) || !std::isfinite(far)) continue;
      sum += std::log2(far);
      ++terms;
    }
  }
  if (terms > 0) normal.unit = std::exp2(std::clamp(std::round(sum / static_cast<double>(terms)), -1000.0, 1000.0));
  return normal;
}

/// Gaussian along an axis: weight of the nodes t = 0…radius steps away, and for every node the factor that compensates the
/// weights beyond the border.
struct Blur {
  std::int64_t radius = 0;
  std::vector<float> weight;
  std::vector<float> border;

  Blur(double sigma_voxels, std::int64_t n) {
    constexpr double reach = 4.0;  // [σ] 6e-5 of the weight lie beyond. More: slower; less: a visible step at the cut
    if (sigma_voxels > 0.0) {
      radius = static_cast<std::int64_t>(std::min(std::ceil(reach * sigma_voxels), static_cast<double>(n - 1)));
    }
    std::vector<double> w(static_cast<std::size_t>(radius) + 1, 1.0);
    double total = 1.0;
    for (std::int64_t t = 1; t <= radius; ++t) {
      const double u = static_cast<double>(t) / sigma_voxels;
      w[t] = std::exp(-0.5 * u * u);
      total += 2.0 * w[t];
    }
    std::vector<double> up_to(w.size());  // Σ w[0…t] / total
    for (std::size_t t = 0; t < w.size(); ++t) {
      w[t] /= total;
      weight.push_back(static_cast<float>(w[t]));
      up_to[t] = w[t] + (t > 0 ? up_to[t - 1] : 0.0);
    }
    for (std::int64_t i = 0; i < n; ++i) {
      const double in_range = up_to[std::min(i, radius)] + up_to[std::min(n - 1 - i, radius)] - w[0];
      border.push_back(static_cast<float>(1.0 / in_range));
    }
  }
};

struct Plan {
  Derivation derivation;
  Nodes nodes;
  Normal normal;
  bool gaps;
  bool smoothed;
  Blur blur[3];
  float index_to_world[9];  ///< row = axis of the grid, column = of the world: index derivatives times this are per spacing
  float* out;
};

/// Σ w[t] (row −t + row +t) of the rows of `row_at`, nullptr beyond the border.
template <class RowAt>
void add_rows(const Blur& blur, std::int64_t at, std::int64_t count, std::int64_t n, float* __restrict out, RowAt row_at) {
  const float* here = row_at(at);
  for (std::int64_t i = 0; i < n; ++i) out[i] = blur.weight[0] * here[i];
  for (std::int64_t t = 1; t <= blur.radius; ++t) {
    const float w = blur.weight[t];
    const float* below = at - t >= 0 ? row_at(at - t) : nullptr;
    const float* above = at + t < count ? row_at(at + t) : nullptr;
    if (below && above) {
      for (std::int64_t i = 0; i < n; ++i) out[i] += w * (below[i] + above[i]);
    } else if (const float* one = below ? below : above) {
      for (std::int64_t i = 0; i < n; ++i) out[i] += w * one[i];
    }
  }
  const float border = blur.border[at];
  for (std::int64_t i = 0; i < n; ++i) out[i] *= border;
}

/// Central difference: the derivative at the node of Keys' cubic through the nodes. `factor` is 1/2; 1 at a border, where `low`
/// or `high` is `here`. One-sided beside a gap; NaN in a gap and between two.
void difference(const float* low, const float* here, const float* high, float factor, bool gaps, std::int64_t n,
                float* __restrict out) noexcept {
  for (std::int64_t i = 0; i < n; ++i) out[i] = factor * (high[i] - low[i]);
  if (!gaps) return;
  for (std::int64_t i = 0; i < n; ++i) {
    if (std::isnan(here[i])) {
      out[i] = nan;
    } else if (factor == 0.5F && std::isnan(out[i])) {
      out[i] = std::isnan(high[i]) ? here[i] - low[i] : high[i] - here[i];
    }
  }
}

/// Middle eigenvalue of the symmetric part of J², which is S² + W². Without branches or angles, so that rows of it vectorise.
inline double middle_eigenvalue(const float (&j)[9]) noexcept {
  const double a = j[0], b = j[1], c = j[2], d = j[3], e = j[4], f = j[5], g = j[6], h = j[7], k = j[8];
  const double xy = 0.5 * (a * b + b * e + c * h + d * a + e * d + f * g);
  const double xz = 0.5 * (a * c + b * f + c * k + g * a + h * d + k * g);
  const double yz = 0.5 * (d * c + e * f + f * k + g * b + h * e + k * h);
  double xx = a * a + b * d + c * g, yy = d * b + e * e + f * h, zz = g * c + h * f + k * k;
  const double mean = (xx + yy + zz) * (1.0 / 3.0);
  xx -= mean, yy -= mean, zz -= mean;
  // The eigenvalues are mean + p x with x³ − 3x = 2r.
  const double p2 = (xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz)) * (1.0 / 6.0);
  const double p = std::sqrt(p2 + 1e-200);  // floats have no smaller squares but 0
  const double det = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  const double r = det / (2.0 * p * p * p);
  // The middle x is in [−1, 1], of sign opposite to r, and 1 − |x| = u with u²(3 − u) = 2(1 − |r|) = w². u/w goes from 1/√3 to
  // 1/√2, nearly straight: within 3 %, and within 3e-8 after two Newton steps.
  const double w = std::sqrt(std::abs(2.0 - 2.0 * std::abs(r)) + 1e-18);  // by rounding |r| may exceed 1
  double u = w * (0.5773502691896258 + 0.0917517095361369 * w);
  for (int step = 0; step < 2; ++step) u -= (u * u * (u - 3.0) + w * w) / (3.0 * u * (u - 2.0));
  return mean + p * std::copysign(1.0 - u, -r);
}

/// Derived values from index derivatives of a row, d[(component · 3 + axis) · n + i].
void combine_vector(Derivation derivation, const float* __restrict d, const float* m, std::int64_t n,
                    float* __restrict out) noexcept {
  const float a00 = m[0], a01 = m[1], a02 = m[2], a10 = m[3], a11 = m[4], a12 = m[5], a20 = m[6], a21 = m[7], a22 = m[8];
  const auto jacobian = [=](std::int64_t i, float(&j)[9]) {
    for (int c = 0; c < 3; ++c) {
      const float x = d[(3 * c) * n + i], y = d[(3 * c + 1) * n + i], z = d[(3 * c + 2) * n + i];
      j[3 * c] = x * a00 + y * a10 + z * a20;
      j[3 * c + 1] = x * a01 + y * a11 + z * a21;
      j[3 * c + 2] = x * a02 + y * a12 + z * a22;
    }
  };
  float j[9];
  switch (derivation) {
    case Derivation::curl:
      for (std::int64_t i = 0; i < n; ++i) {
        jacobian(i, j);
        out[3 * i] = j[7] - j[5];
        out[3 * i + 1] = j[2] - j[6];
        out[3 * i + 2] = j[3] - j[1];
      }
      return;
    case Derivation::divergence:
      for (std::int64_t i = 0; i < n; ++i) {
        jacobian(i, j);
        out[i] = j[0] + j[4] + j[8];
      }
      return;
    case Derivation::q:  // (|W|² − |S|²)/2 = −tr(J²)/2
      for (std::int64_t i = 0; i < n; ++i) {
        jacobian(i, j);
        out[i] = -0.5F * (j[0] * j[0] + j[4] * j[4] + j[8] * j[8]) - (j[1] * j[3] + j[2] * j[6] + j[5] * j[7]);
      }
      return;
    default:
      for (std::int64_t i = 0; i < n; ++i) {
        jacobian(i, j);
        out[i] = static_cast<float>(middle_eigenvalue(j));
      }
  }
}

void combine_scalar(const float* __restrict d, const float* m, std::int64_t n, float* __restrict out) noexcept {
  const float a00 = m[0], a01 = m[1], a02 = m[2], a10 = m[3], a11 = m[4], a12 = m[5], a20 = m[6], a21 = m[7], a22 = m[8];
  for (std::int64_t i = 0; i < n; ++i) {
    const float x = d[i], y = d[n + i], z = d[2 * n + i];
    const float gx = x * a00 + y * a10 + z * a20, gy = x * a01 + y * a11 + z * a21, gz = x * a02 + y * a12 + z * a22;
    out[i] = std::sqrt(gx * gx + gy * gy + gz * gz);
  }
}

/// Slices of a thread, and its memory.
class Pass {
 public:
  explicit Pass(const Plan& plan)
      : plan_(plan),
        nx_(plan.nodes.geometry().dims[0]),
        ny_(plan.nodes.geometry().dims[1]),
        nz_(plan.nodes.geometry().dims[2]),
        plane_(nx_ * ny_),
        components_(plan.nodes.components()),
        blurred_(components_ + (plan.smoothed && plan.gaps)),
        channels_(blurred_ + (plan.smoothed && plan.gaps)),
        slots_(std::min(2 * plan.blur[2].radius + 1, nz_)),
        ring_(static_cast<std::size_t>(slots_ * channels_ * plane_)),
        smooth_(static_cast<std::size_t>(3 * components_ * plane_)),
        scratch_(static_cast<std::size_t>(plane_)),
        padded_(static_cast<std::size_t>(nx_ + 2 * plan.blur[0].radius)),
        weight_(static_cast<std::size_t>(nx_)),
        derivatives_(static_cast<std::size_t>(9 * nx_)),
        row_(static_cast<std::size_t>(nx_ * components_)) {}

  void run(std::int64_t first, std::int64_t last) noexcept {
    const std::int64_t reach = plan_.blur[2].radius;
    const bool neighbours = !only_smooths(plan_.derivation);
    std::int64_t next = std::max<std::int64_t>(first - neighbours, 0);  // next to smooth
    std::int64_t unread = std::max<std::int64_t>(next - reach, 0);
    for (std::int64_t k = first; k < last; ++k) {
      for (; next <= std::min(k + neighbours, nz_ - 1); ++next) {
        for (; unread <= std::min(next + reach, nz_ - 1); ++unread) read(unread);
        smooth(next);
      }
      if (neighbours) {
        derive(k);
      } else {
        keep_smoothed(k);
      }
    }
  }

 private:
  float* read_plane(std::int64_t k, int channel) noexcept {
    return ring_.data() + ((k % slots_) * channels_ + channel) * plane_;
  }
  float* smoothed(std::int64_t k, int component) noexcept {
    return smooth_.data() + ((k % 3) * components_ + component) * plane_;
  }

  /// Reads slice k into the ring, smoothed along i and j.
  void read(std::int64_t k) noexcept {
    for (std::int64_t j = 0; j < ny_; ++j) {
      plan_.nodes.row(j, k, row_.data());
      for (int c = 0; c < components_; ++c) {
        float* out = read_plane(k, c) + j * nx_;
        const double centre = plan_.normal.centre[c], inverse_unit = 1.0 / plan_.normal.unit;
        for (std::int64_t i = 0; i < nx_; ++i) out[i] = static_cast<float>((row_[i * components_ + c] - centre) * inverse_unit);
      }
      if (plan_.gaps) mark_gaps(k, j);
    }
    if (!plan_.smoothed) return;
    for (int channel = 0; channel < blurred_; ++channel) {
      float* plane = read_plane(k, channel);
      for (std::int64_t j = 0; j < ny_; ++j) blur_row(plane + j * nx_, scratch_.data() + j * nx_);
      const auto row_at = [&](std::int64_t j) { return scratch_.data() + j * nx_; };
      for (std::int64_t j = 0; j < ny_; ++j) add_rows(plan_.blur[1], j, ny_, nx_, plane + j * nx_, row_at);
    }
  }

  /// A node without value is NaN; before smoothing it is 0 with weight 0, and the NaN is kept in a plane of its own.
  void mark_gaps(std::int64_t k, std::int64_t j) noexcept {
    for (std::int64_t i = j * nx_; i < (j + 1) * nx_; ++i) {
      bool gap = false;
      for (int c = 0; c < components_; ++c) gap = gap || !std::isfinite(read_plane(k, c)[i]);
      for (int c = 0; gap && c < components_; ++c) read_plane(k, c)[i] = plan_.smoothed ? 0.0F : nan;
      if (!plan_.smoothed) continue;
      read_plane(k, components_)[i] = gap ? 0.0F : 1.0F;
      read_plane(k, components_ + 1)[i] = gap ? nan : 0.0F;
    }
  }

  void blur_row(const float* row, float* __restrict out) noexcept {
    const Blur& blur = plan_.blur[0];
    std::copy_n(row, nx_, padded_.data() + blur.radius);  // zeros on both sides
    const float* __restrict here = padded_.data() + blur.radius;
    for (std::int64_t i = 0; i < nx_; ++i) out[i] = blur.weight[0] * here[i];
    for (std::int64_t t = 1; t <= blur.radius; ++t) {
      const float w = blur.weight[t];
      for (std::int64_t i = 0; i < nx_; ++i) out[i] += w * (here[i - t] + here[i + t]);
    }
    for (std::int64_t i = 0; i < nx_; ++i) out[i] *= blur.border[i];
  }

  /// Smooths slice k along k.
  void smooth(std::int64_t k) noexcept {
    for (std::int64_t j = 0; j < ny_; ++j) {
      const auto add = [&](int channel, float* out) {
        add_rows(plan_.blur[2], k, nz_, nx_, out, [&](std::int64_t at) { return read_plane(at, channel) + j * nx_; });
      };
      for (int c = 0; c < components_; ++c) add(c, smoothed(k, c) + j * nx_);
      if (!plan_.smoothed || !plan_.gaps) continue;
      add(components_, weight_.data());
      const float* gap = read_plane(k, components_ + 1) + j * nx_;
      for (int c = 0; c < components_; ++c) {
        float* out = smoothed(k, c) + j * nx_;
        for (std::int64_t i = 0; i < nx_; ++i) out[i] = out[i] / weight_[i] + gap[i];
      }
    }
  }

  /// Stores slice k, components interleaved. They share the first's offset, so the floats contain the others' centres.
  void keep_smoothed(std::int64_t k) noexcept {
    for (int c = 0; c < components_; ++c) {
      const auto offset = static_cast<float>((plan_.normal.centre[c] - plan_.normal.centre[0]) / plan_.normal.unit);
      const float* in = smoothed(k, c);
      float* out = plan_.out + k * plane_ * components_ + c;
      for (std::int64_t i = 0; i < plane_; ++i) out[i * components_] = in[i] + offset;
    }
  }

  void derive(std::int64_t k) noexcept {
    const auto factor = [](std::int64_t at, std::int64_t n) { return at > 0 && at < n - 1 ? 0.5F : 1.0F; };
    const std::int64_t below = std::max<std::int64_t>(k - 1, 0), above = std::min(k + 1, nz_ - 1);
    for (std::int64_t j = 0; j < ny_; ++j) {
      for (int c = 0; c < components_; ++c) {
        const float* here = smoothed(k, c) + j * nx_;
        float* d = derivatives_.data() + 3 * c * nx_;
        difference(here, here, here + (nx_ > 1), 1.0F, plan_.gaps, 1, d);
        if (nx_ > 2) difference(here, here + 1, here + 2, 0.5F, plan_.gaps, nx_ - 2, d + 1);
        if (nx_ > 1) difference(here + nx_ - 2, here + nx_ - 1, here + nx_ - 1, 1.0F, plan_.gaps, 1, d + nx_ - 1);
        difference(here - (j > 0) * nx_, here, here + (j < ny_ - 1) * nx_, factor(j, ny_), plan_.gaps, nx_, d + nx_);
        difference(smoothed(below, c) + j * nx_, here, smoothed(above, c) + j * nx_, factor(k, nz_), plan_.gaps, nx_,
                   d + 2 * nx_);
      }
      float* out = plan_.out + (k * plane_ + j * nx_) * components_given(plan_.derivation);
      if (components_ == 3) {
        combine_vector(plan_.derivation, derivatives_.data(), plan_.index_to_world, nx_, out);
      } else {
        combine_scalar(derivatives_.data(), plan_.index_to_world, nx_, out);
      }
    }
  }

  const Plan& plan_;
  std::int64_t nx_, ny_, nz_, plane_;
  int components_;
  int blurred_;   ///< smoothed planes of a slice: components, and the weight if there are gaps
  int channels_;  ///< planes of a slice
  std::int64_t slots_;
  std::vector<float> ring_, smooth_, scratch_, padded_, weight_, derivatives_;
  std::vector<double> row_;
};

}  // namespace

FieldPtr derive_on_grid(Derivation derivation, const Field& of, const GridGeometry& geometry, double smoothing_m,
                        double factor) {
  const Mat3 to_index = scaled_inverse(geometry.index_to_world_m);
  const double spacing_m =
      1.0 / std::max({norm(to_index.row[0]), norm(to_index.row[1]), norm(to_index.row[2])});  // least distance of planes
  const bool smoothed = derivation == Derivation::q || derivation == Derivation::lambda2 || only_smooths(derivation);
  const double sigma_m = smoothing_m > 0.0 ? smoothing_m : 2.0 * spacing_m;
  const auto blur = [&](int a) {
    return Blur(smoothed ? sigma_m / norm(transposed(geometry.index_to_world_m).row[a]) : 0.0, geometry.dims[a]);
  };
  const Nodes nodes(of, geometry);
  const int given = components_given(derivation);
  expect_memory(geometry, 1.0, given, "use smaller data");
  const std::shared_ptr<float[]> out(new float[static_cast<std::size_t>(geometry.voxels()) * given]);
  Plan plan{derivation, nodes, normal_of(nodes), nodes.has_gaps(), smoothed, {blur(0), blur(1), blur(2)}, {}, out.get()};
  for (int a = 0; a < 3; ++a) {
    const Vec3 row = spacing_m * to_index.row[a];
    plan.index_to_world[3 * a] = static_cast<float>(row.x);
    plan.index_to_world[3 * a + 1] = static_cast<float>(row.y);
    plan.index_to_world[3 * a + 2] = static_cast<float>(row.z);
  }
  // A part also smooths the Gaussian's support beyond it.
  in_parts(geometry.dims[2], 4 * plan.blur[2].radius + 1,
           [&](std::int64_t first, std::int64_t last) { Pass(plan).run(first, last); });
  const double per_spacing = plan.normal.unit / spacing_m;
  const bool squared = derivation == Derivation::q || derivation == Derivation::lambda2;
  if (only_smooths(derivation)) {
    return smooth_grid_field(geometry, {VoxelType::float32, given, out}, factor * plan.normal.unit,
                             factor * plan.normal.centre[0]);
  }
  return smooth_grid_field(geometry, {VoxelType::float32, given, out},
                           factor * (squared ? per_spacing * per_spacing : per_spacing));
}

}  // namespace palpa::detail
