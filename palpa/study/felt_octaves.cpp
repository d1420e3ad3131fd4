#include "palpa/study/felt_octaves.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpa/trace/windows.h"

namespace palpa {

void FeltOctavesBuilder::add(double octave, bool is_forced, const Vec3& proxy_m) noexcept {
  const double way_m = ticks_ > 0 ? distance(proxy_m, last_m_) : 0.0;
  last_m_ = proxy_m;
  ++ticks_;
  finest_ += octave == 0.0;
  as_fine_ += octave == 0.0 || octave <= std::ceil(std::log2(std::max(way_m / spacing_m_, 1.0)));
  forced_ += is_forced;
  sum_ += octave;
}

FeltOctaves FeltOctavesBuilder::finish() const noexcept {
  const double ticks = static_cast<double>(std::max<std::int64_t>(ticks_, 1));
  return {static_cast<double>(finest_) / ticks, static_cast<double>(as_fine_) / ticks, sum_ / ticks, forced_};
}

double spacing_of_octaves_m(const Scene& scene) {
  double spacing_m = std::numeric_limits<double>::infinity();
  const std::vector<TracedField> fields = traced_fields(scene);
  for (const TracedField& field : fields)
    spacing_m = std::min(spacing_m, field.posed->spacing_m() / scene.hand_to_world().scale);
  return fields.empty() ? 0.0 : spacing_m;
}

}  // namespace palpa
