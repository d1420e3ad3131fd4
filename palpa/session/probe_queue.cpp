#include "palpa/session/probe_queue.h"

namespace palpa {

void ProbeQueue::start(const Pose& probe) noexcept {
  size_ = 0;
  walked_ = probe;
}

double ProbeQueue::push(const Pose& probe, double time_s, const Tool& tool) noexcept {
  const auto is_fast = [](double offset_m, double in_s) { return offset_m > fastest_m_per_s * in_s; };
  double offset_m = tool.way_m(before(size_), probe);
  const std::size_t last = size_;
  if (is_fast(offset_m, time_s)) {
    double excursion_s = 0.0;
    for (std::size_t i = size_; i-- > 0;) {
      excursion_s += corners_[i].time_s;
      if (!is_fast(tool.way_m(before(i), corners_[i].pose), corners_[i].time_s)) continue;
      size_ = i;
      time_s += excursion_s;
      break;
    }
  }
  if (size_ == corners_.size()) --size_;
  if (size_ != last) offset_m = tool.way_m(before(size_), probe);
  corners_[size_++] = {probe, time_s};
  return offset_m;
}

double ProbeQueue::time_behind_s(const ProbeSegment& next) const noexcept {
  double behind_s = corners_[0].time_s - next.time_s;
  for (std::size_t i = size_; i-- > 1;) behind_s += corners_[i].time_s;
  return behind_s;
}

}  // namespace palpa
