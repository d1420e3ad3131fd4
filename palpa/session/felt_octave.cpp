#include "palpa/session/felt_octave.h"

#include <algorithm>
#include <cmath>

namespace palpa {
namespace {

constexpr double finer_s = 0.025;      // [s] an octave. Shorter: a step under the hand; longer: detail comes late
constexpr double coarser_s = 0.05;     // [s] an octave. Shorter: a step; longer: the face of a window is reached first
constexpr double least_stay_s = 0.02;  // [s] Shorter: octaves are taken up and lost at once; longer: coarser than need be
// [voxels] to a face, beside the way of the tick. More: a fast hand feels coarser octaves; less: moves end at faces more often.
constexpr double live_margin_voxels = Stock::sample_voxels + 4.0;
constexpr double steady_s = 0.005;  // [s] of the mean velocity. Shorter: single steps decide; longer: a start is late

}  // namespace

void FeltOctave::advance(const Stock& stock, std::span<const Vec3> feet_m, double way_m, double time_step_s,
                         DataTime pose_time) noexcept {
  const Vec3 step_m = started_ ? feet_m.front() - last_m_ : Vec3{};
  last_m_ = feet_m.front();
  velocity_m_per_s_ += std::min(1.0, time_step_s / steady_s) * (step_m / time_step_s - velocity_m_per_s_);
  if (!is_finite(velocity_m_per_s_)) velocity_m_per_s_ = {};

  const int last = stock.count() - 1;
  const bool is_complete = stock.is_complete();
  // Complete windows are those of the finest octave alone; else the felt octave comes from the coarsest, through all of them.
  const auto finest = [&](auto&& suits) {
    int octave = is_complete ? 0 : last;
    if (is_complete) {
      while (octave < last && !suits(octave)) ++octave;
    } else {
      while (octave > 0 && suits(octave - 1)) --octave;
    }
    return octave;
  };
  const double margin_voxels = is_complete ? Stock::margin_voxels : live_margin_voxels;
  const auto has_room = [&](int octave) { return stock.room_m(octave, feet_m, pose_time, margin_voxels) >= way_m; };
  const auto stays_s = [&](int octave) { return stock.stays_s(octave, feet_m, velocity_m_per_s_, pose_time, margin_voxels); };
  const int hard = finest(has_room);
  const int steady = is_complete ? hard : finest([&](int octave) { return stays_s(octave) >= least_stay_s; });
  const int wish = std::clamp(stock.finest(), std::max(hard, steady), last);

  forced_ = false;
  if (!started_) octave_ = wish;
  started_ = true;
  if (octave_ > wish) {
    octave_ = std::max<double>(wish, octave_ - time_step_s / finer_s);
  } else if (octave_ < wish) {
    const double left_s = stays_s(static_cast<int>(octave_));
    const double rate = std::max(1.0 / coarser_s, (wish - octave_) / std::max(left_s, time_step_s));
    octave_ = std::min<double>(wish, octave_ + rate * time_step_s);
  }
  forced_ = octave_ < hard;
  octave_ = std::max<double>(octave_, hard);
}

}  // namespace palpa
