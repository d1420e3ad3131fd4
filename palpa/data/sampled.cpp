#include "palpa/data/sampled.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "palpa/base/limits.h"
#include "palpa/base/printed.h"
#include "palpa/data/grid_base.h"
#include "palpa/data/grid_work.h"
#include "palpa/data/parallel.h"
#include "palpa/data/timed_field.h"

namespace palpa {
namespace {

/// NaN on overflow of a float: its cells are outside rather than wrong.
float as_sample(double value, bool inside) noexcept {
  const bool fits = inside && std::abs(value) <= std::numeric_limits<float>::max();
  return fits ? static_cast<float>(value) : std::numeric_limits<float>::quiet_NaN();
}

/// Refuses requests beyond the available time or memory, before allocation.
void check_work(const Field& field, const GridGeometry& geometry, int frames) {
  detail::expect_few_samples(geometry, frames, limit::samples);
  detail::expect_memory(geometry, frames, 2 * field.components(),  // a filter may keep a second copy
                        limit::samples.remedy);
}

}  // namespace

FieldPtr sampled(const Field& field, int longest) {
  if (longest < 2 || longest > 1024) {
    throw std::invalid_argument("a field cannot be sampled " + std::to_string(longest) +
                                " times along its longest side; 2 to 1024 can be");
  }
  const Box box = field.bounds_m();
  const GridGeometry geometry = detail::geometry_over(box, longest);
  check_work(field, geometry, 1);
  const int components = field.components();
  const std::shared_ptr<float[]> data(new float[static_cast<std::size_t>(geometry.voxels()) * components]);
  const auto fill = [&](std::int64_t first, std::int64_t last) {
    float* out = data.get() + first * geometry.dims[1] * geometry.dims[0] * components;
    for (std::int64_t k = first; k < last; ++k) {
      for (std::int64_t j = 0; j < geometry.dims[1]; ++j) {
        for (std::int64_t i = 0; i < geometry.dims[0]; ++i) {
          const Vec3 at = detail::within(box, geometry.to_world({double(i), double(j), double(k)}));
          if (components == 1) {
            const ScalarSample s = field.scalar(at);
            *out++ = as_sample(s.value, s.inside);
          } else {
            const VectorSample s = field.vector(at);
            *out++ = as_sample(s.value.x, s.inside);
            *out++ = as_sample(s.value.y, s.inside);
            *out++ = as_sample(s.value.z, s.inside);
          }
        }
      }
    }
  };
  detail::in_parts(geometry.dims[2], 2, fill);
  return grid_field(geometry, {VoxelType::float32, components, data});
}

FieldPtr sampled(const FieldPtr& field, int longest, int frames, BetweenFrames between_frames) {
  const TimedField* source = field ? timed(*field) : nullptr;
  if (!source) throw std::invalid_argument("the field does not change with time, so it has no frames to sample");
  if (frames < 1 || limit::sampled_frames.is_passed_by(frames)) {
    throw std::invalid_argument("a time series cannot have " + std::to_string(frames) + " frames; 1 to " +
                                detail::text("%.0f", limit::sampled_frames.most) + " it can");
  }
  if (longest >= 2) check_work(*field, detail::geometry_over(field->bounds_m(), longest), frames);
  const double period_s = source->cycle_s() / frames;
  std::vector<FieldPtr> grids;
  for (int i = 0; i < frames; ++i) grids.push_back(sampled(*frozen(field, i * period_s), longest));
  return time_series(std::move(grids), period_s, between_frames);
}

}  // namespace palpa
