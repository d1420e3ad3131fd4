#include "palpa/session/data_moments.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace palpa {
namespace {

// [N/s] of the spring's force as which the proxy may move beside the hand while octaves fade, if the data move less. More: a
// lost level lets go with a kick; less: the proxy is late.
constexpr double fading_n_per_s = 10.0;

}  // namespace

DataMoments::DataMoments(StateArena& live, const TimeOptions& time, ModeRuntime& modes, const Tool& tool)
    : time_(time),
      modes_(modes),
      tool_(tool),
      stock_(modes.all_fields()),
      felt_octave_(live.add<FeltOctave>()),
      state_(live.add<State>()),
      end_s_(modes.data_end_s()),
      can_change_((modes.any_timed() && time.play != TimeOptions::Play::hold) || !stock_.empty()),
      feet_in_world_(tool.feet()),
      feet_ahead_(tool.feet()) {
  stock_.set_data_speed(time.play == TimeOptions::Play::hold ? 0.0 : time.speed);
}

// Data that play once end with the longest of their fields, so that equal moments are found equal.
DataTime DataMoments::at(double elapsed_s, double octave) const noexcept {
  DataTime at = time_.at(elapsed_s);
  if (!at.loop) at.time_s = std::min(at.time_s, end_s_);
  at.octave = octave;
  at.stock = stock_.empty() ? nullptr : &stock_;
  return at;
}

bool DataMoments::octaves_fade() const noexcept {
  const double felt = felt_octave_.octave();
  // On a simulated clock modes fade by the time of the data alone, as in memory.
  const bool modes_fade = !stock_.is_complete() && modes_.any_fades();
  return !stock_.empty() && (state_.view_octave != felt || state_.followed_octave != felt || modes_fade);
}

double DataMoments::fading_way_m(double hand_m, double data_m, double time_s, double stiffness_n_per_m) noexcept {
  return hand_m + std::max(data_m, fading_n_per_s * time_s / stiffness_n_per_m);
}

void DataMoments::reset() noexcept {
  state_.view_octave = state_.followed_octave = 0.0;
  stand_still();
  felt_octave_.reset();
}

void DataMoments::resume(const DataMoments& other) noexcept {
  state_ = other.state_;
  felt_octave_ = other.felt_octave_;
  take_windows_of(other);
}

void DataMoments::start(const Pose& proxy, double way_m, double time_step_s) noexcept {
  choose_octave(proxy, way_m, time_step_s);
  state_.view_s = state_.followed_s = state_.elapsed_s - time_step_s;
  state_.view_octave = state_.followed_octave = felt_octave_.octave();
}

void DataMoments::choose_octave(const Pose& proxy, double way_m, double time_step_s) noexcept {
  if (stock_.empty()) return;
  const DataTime pose_time = time_.at(state_.elapsed_s);
  const std::span<const Vec3> feet_m = feet_in_world(proxy);
  if (!stock_.is_complete())
    stock_.keep_frames(time_.at(state_.followed_s), time_.at(state_.elapsed_s + Stock::frames_ahead_s));
  // Complete windows were laid for this tick's `need`.
  const bool looks_ahead = std::exchange(is_ahead_known_, false) && stock_.is_complete();
  stock_.put_in_force(feet_m, looks_ahead ? std::span<const Vec3>(feet_ahead_) : std::span<const Vec3>{}, pose_time);
  felt_octave_.advance(stock_, feet_m, way_m * map().scale, time_step_s, pose_time);
}

DataMoments::Step DataMoments::advance_view(double to_s) noexcept {
  const double before_s = state_.view_s;
  state_.view_s = std::max(before_s, to_s);
  state_.view_octave = felt_octave_.octave();
  return {state_.view_s - before_s, state_.view_s - state_.followed_s, state_.view_octave - state_.followed_octave};
}

void DataMoments::follow(const Step& step, double share_behind) noexcept {
  state_.followed_s = state_.view_s - share_behind * step.behind_s;
  state_.followed_octave = state_.view_octave - share_behind * step.behind_octave;
}

// Feet [m, world].
std::span<const Vec3> DataMoments::feet_in_world(const Pose& pose, std::vector<Vec3>& feet_m) noexcept {
  for (std::size_t foot = 0; foot < tool_.feet(); ++foot) feet_m[foot] = map().to_world(tool_.foot_m(pose, foot));
  return feet_m;
}

// The finest octave of a field, from the felt one on, whose window holds all feet [m, world]. Not from that of the last
// samples: its window may be left, and the next sub-step samples at the felt octave.
int DataMoments::sampled_octave(std::size_t field, std::span<const Vec3> feet_m) const noexcept {
  auto octave = static_cast<int>(felt_octave_.octave());
  while (stock_.room_of_m(field, octave, feet_m, time_.at(state_.view_s), 0.0) < 0.0) ++octave;
  return octave;
}

double DataMoments::reach_m(const Pose& proxy) noexcept {
  double reach_m = std::numeric_limits<double>::infinity();
  if (stock_.empty()) return reach_m;
  const std::span<const Vec3> feet_m = feet_in_world(proxy);
  const DataTime view = time_.at(state_.view_s);
  stock_.for_each_sampled(view, [&](std::size_t n) {
    reach_m = std::min(reach_m, stock_.room_of_m(n, sampled_octave(n, feet_m), feet_m, view, Stock::sample_voxels));
  });
  return std::max(0.0, reach_m) / map().scale;
}

double DataMoments::reach_m(const Pose& proxy, const Pose& to) noexcept {
  const double least_m = reach_m(proxy), way_m = tool_.way_m(proxy, to);
  if (!(least_m < way_m)) return least_m;
  const std::span<const Vec3> feet_m = feet_in_world(proxy), ends_m = feet_in_world(to, feet_ahead_);
  const DataTime view = time_.at(state_.view_s);
  double share = 1.0;
  stock_.for_each_sampled(view, [&](std::size_t n) {
    share = std::min(share, stock_.share_within(n, sampled_octave(n, feet_m), feet_m, ends_m, view, Stock::sample_voxels));
  });
  return std::max(least_m, share * way_m);
}

WindowNeed DataMoments::need(const Pose& start, const Pose& probe, double way_m, double time_step_s) noexcept {
  is_ahead_known_ = true;
  return {feet_in_world(start),
          feet_in_world(probe, feet_ahead_),
          way_m * map().scale,
          felt_octave_.velocity_m_per_s(),
          time_.at(state_.elapsed_s + time_step_s),
          time_.at(state_.followed_s)};
}

}  // namespace palpa
