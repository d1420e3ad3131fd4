// A real scan, four times coarser for renderers than for the reference.
#include <algorithm>
#include <cmath>

#include "bench/haptics/cases.h"
#include "bench/haptics/shape.h"
#include "palpa/base/load_error.h"
#include "palpa/data/filter.h"
#include "palpa/data/grid_base.h"
#include "palpa/device/sine_cosine.h"
#include "palpa/file/read_volume.h"

namespace palpa::haptics {

using nlohmann::json;

namespace {

SampledVolume voxels_of(const std::filesystem::path& file) {
  const Volume volume = read_volume(file);
  const GridView* grid = grid_below(*volume.fields.front().field);
  if (!grid || grid->voxels.type != VoxelType::int16 || grid->voxels.components != 1)
    throw LoadError(file.string() + ": is no CT of int16 on a grid; take the head of tools/get-ct-head");
  const auto& dims = grid->geometry.dims;
  const Mat3& steps = grid->geometry.index_to_world_m;
  const Vec3 spacing_m{steps.row[0].x, steps.row[1].y, steps.row[2].z};
  const bool upright = steps == Mat3{{{spacing_m.x, 0, 0}, {0, spacing_m.y, 0}, {0, 0, spacing_m.z}}} &&
                       std::min({spacing_m.x, spacing_m.y, spacing_m.z}) > 0.0;
  if (!upright || *std::min_element(dims.begin(), dims.end()) < 16)
    throw LoadError(file.string() + ": is no CT along the axes of its frame; take the head of tools/get-ct-head");
  SampledVolume fine{.grid = {.size = {static_cast<int>(dims[0]), static_cast<int>(dims[1]), static_cast<int>(dims[2])},
                              .spacing_m = spacing_m},
                     .type = "int16"};
  const auto* values = static_cast<const std::int16_t*>(grid->voxels.data.get());
  fine.samples.assign(values, values + fine.grid.samples());
  return fine;
}

/// Means of 4 × 4 × 4 voxels, as a coarser scanner has them.
SampledVolume four_times_coarser(const SampledVolume& fine) {
  SampledVolume coarse{.type = fine.type};
  const auto& size = fine.grid.size;
  coarse.grid.size = {size[0] / 4, size[1] / 4, size[2] / 4};
  coarse.grid.spacing_m = 4.0 * fine.grid.spacing_m;
  coarse.grid.origin_m = fine.grid.origin_m + 1.5 * fine.grid.spacing_m;
  for (int k = 0; k < coarse.grid.size[2]; ++k) {
    for (int j = 0; j < coarse.grid.size[1]; ++j) {
      for (int i = 0; i < coarse.grid.size[0]; ++i) {
        double sum = 0.0;
        for (int n = 0; n < 64; ++n) {
          const std::size_t at_i = 4 * i + n % 4, at_j = 4 * j + n / 4 % 4, at_k = 4 * k + n / 16;
          sum += fine.samples[(at_k * size[1] + at_j) * size[0] + at_i];
        }
        coarse.samples.push_back(static_cast<float>(std::floor(sum / 64.0 + 0.5)));
      }
    }
  }
  return coarse;
}

/// Presses on the fine surface from free space.
class Presses {
 public:
  Presses(const SampledVolume& fine, double level) : fine_(fine), level_(level) {
    const auto& size = fine.grid.size;
    middle_m_ = fine.grid.origin_m + 0.5 * Vec3{(size[0] - 1) * fine.grid.spacing_m.x, (size[1] - 1) * fine.grid.spacing_m.y,
                                                (size[2] - 1) * fine.grid.spacing_m.z};
  }

  /// Directions of a spiral over face and forehead, where they are reachable.
  std::vector<Touch> all() {
    constexpr int directions = 120;
    for (int i = 0; i < directions; ++i) {
      // Towards +y, the face; heights from −0.15 to 0.75 of the reach, 70° to either side.
      const double up = -0.15 + 0.90 * i / directions;
      const auto around = detail::sine_cosine(0.25 + 0.19 * detail::sine_cosine(0.382 * i).sine);
      const double across = std::sqrt(1.0 - up * up);
      press({across * around.cosine, across * around.sine, up});
    }
    return std::move(trajectory_.touches);
  }

 private:
  bool is_free(const Vec3& from, const Vec3& to) const {
    constexpr double step_m = 2.5e-4;
    const int steps = static_cast<int>(distance(from, to) / step_m) + 1;
    for (int i = 0; i <= steps; ++i) {
      const Vec3 x = from + (static_cast<double>(i) / steps) * (to - from);
      if (fine_.holds(x) && fine_.value(x) >= level_) return false;
    }
    return true;
  }

  void press(const Vec3& direction) {
    // From outside to the surface along the ray.
    constexpr double step_m = 2.5e-4;
    double r = far_m;
    const auto inside = [&](double at) {
      const Vec3 x = middle_m_ + at * direction;
      return fine_.holds(x) && fine_.value(x) >= level_;
    };
    while (r > 0.0 && !inside(r)) r -= step_m;
    if (r <= 0.0) return;
    double low = r, high = r + step_m;
    for (int i = 0; i < 40; ++i) (inside(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
    const Vec3 place = middle_m_ + 0.5 * (low + high) * direction;
    const Vec3 outward = -normalized(fine_.slope_per_m(place));
    // Away from the data's faces, not grazing, a clear edge, and a free approach.
    const Vec3 margin{0.02, 0.02, 0.02};
    constexpr double before_m = 0.008, steep_per_m = 1e5;
    const Vec3 before = place + before_m * outward, far = middle_m_ + far_m * direction;
    const bool usable = fine_.holds(place - margin) && fine_.holds(place + margin) && dot(outward, direction) > 0.85 &&
                        norm(fine_.slope_per_m(place)) > steep_per_m && is_free(place + 1.5e-3 * outward, before) &&
                        is_free(before, far);
    if (!usable) return;
    travel(far);
    travel(before);
    constexpr double step_n = 0.02, deepest_n = 2.0;
    const double before_n = before_m * stiffness_n_per_m;
    const auto at = [&](double force_n, Phase phase) { trajectory_.press(place, outward, force_n, phase); };
    for (double force_n = -before_n; force_n < deepest_n; force_n += step_n) at(force_n, Phase::moving);
    for (int i = 0; i < 120; ++i) at(deepest_n, Phase::still);
    for (double force_n = deepest_n; force_n > -before_n; force_n -= 4.0 * step_n) at(force_n, Phase::moving);
    hand_m_ = before;
    travel(far);
  }

  // In free space, round the head where necessary.
  void travel(const Vec3& to) {
    constexpr double step_m = 4e-3;
    if (trajectory_.touches.empty()) hand_m_ = to;
    const Vec3 from = hand_m_;
    const bool round = distance(from, middle_m_) > 0.9 * far_m && distance(to, middle_m_) > 0.9 * far_m;
    const int ticks = static_cast<int>(distance(from, to) / step_m) + 1;
    for (int i = 1; i <= ticks; ++i) {
      hand_m_ = from + (static_cast<double>(i) / ticks) * (to - from);
      if (round) hand_m_ = middle_m_ + far_m * normalized(hand_m_ - middle_m_);
      trajectory_.held(hand_m_, hand_m_);
    }
  }

  static constexpr double far_m = 0.16;
  const SampledVolume& fine_;
  double level_;
  Vec3 middle_m_, hand_m_;
  Trajectory trajectory_;
};

}  // namespace

void add_scan_cases(Suite& suite, const std::filesystem::path& head_file) {
  const SampledVolume fine = voxels_of(head_file);
  suite.volumes["head-coarse"] = [=] { return four_times_coarser(fine); };
  suite.volumes["head-fine"] = [=] { return fine; };
  struct Level {
    const char* name;
    double value;  // [HU]
  };
  for (const auto& [name, value] : {Level{"head-skin", -300.0}, Level{"head-bone", 300.0}}) {
    std::vector<Touch> touches = Presses(fine, value).all();
    if (touches.empty()) throw LoadError(head_file.string() + ": has no surface to press; take the head of tools/get-ct-head");
    suite.cases.push_back({.name = name,
                           .family = "scans",
                           .volume = "head-coarse",
                           .rule = {{"kind", "surface"},
                                    {"solid", "high"},
                                    {"levels", json::array({{{"value", value}, {"strength_n", nullptr}}})},
                                    {"friction_coefficient", 0}},
                           .shape = {{"kind", "scan"}, {"file", "../volumes/head-fine.nrrd"}, {"level", value}},
                           .scores = {"surface", "direction", "force", "lost", "ripple"},
                           .touches = std::move(touches)});
  }
}

}  // namespace palpa::haptics
