#include "palpa/session/probe_queue.h"

#include <algorithm>

#include "palpa/solver/primitives.h"

namespace palpa {

void ProbeQueue::start(const Pose& probe) noexcept {
  size_ = 0;
  walked_ = probe;
}

double ProbeQueue::push(const Pose& probe, double time_s, const Tool& tool) noexcept {
  const auto is_fast = [](double offset_m, double in_s) { return offset_m > fastest_m_per_s * in_s; };
  if (is_fast(tool.way_m(before(size_), probe), time_s)) {
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
  const double offset_m = tool.way_m(before(size_), probe);
  corners_[size_++] = {probe, time_s};
  return offset_m;
}

void ProbeQueue::pop(const ProbeSegment& walked) noexcept {
  walked_ = walked.to;
  corners_[0].time_s = std::max(corners_[0].time_s - walked.time_s, shortest_time_s);  // rounding may leave none
  if (walked.to != corners_[0].pose) return;
  std::copy(corners_.begin() + 1, corners_.begin() + static_cast<std::ptrdiff_t>(size_), corners_.begin());
  --size_;
}

double ProbeQueue::time_behind_s(const ProbeSegment& next) const noexcept {
  double behind_s = corners_[0].time_s - next.time_s;
  for (std::size_t i = size_; i-- > 1;) behind_s += corners_[i].time_s;
  return behind_s;
}

}  // namespace palpa
