#include "palpa/loop/window_policy.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpa {
namespace {

// [s] More: windows lie ahead of a hand that turns back; less: a fast hand is at a face when its window comes.
constexpr double lead_s = 0.03;
// [voxels] of the lead. More: the face behind the hand comes near; less: windows come late.
constexpr double longest_lead_voxels = 32.0;
// [voxels] that the place may move before the window is made again. More: faces come near; less: more windows.
constexpr double most_off_voxels = 24.0;
// [s] whose way half a voxel at least is. More: a moving hand feels coarser octaves; less: windows that no tick can follow.
constexpr double tick_s = 1e-3;
// [m] of the hand: smaller voxels are not felt. More: detail is missing; less: windows that no hand can follow.
constexpr double finest_hand_m = 10e-6;

}  // namespace

FeetMotion motion_of(const WindowNeed& need, double hand_scale) noexcept {
  Box box{need.feet_m.front(), need.feet_m.front()};
  for (const Vec3& at_m : need.feet_m) {
    box.low_m = {std::min(box.low_m.x, at_m.x), std::min(box.low_m.y, at_m.y), std::min(box.low_m.z, at_m.z)};
    box.high_m = {std::max(box.high_m.x, at_m.x), std::max(box.high_m.y, at_m.y), std::max(box.high_m.z, at_m.z)};
  }
  return {box, need.velocity_m_per_s, hand_scale, need.time};
}

bool can_be_felt_live(const WindowPlace& place) noexcept {
  if (place.octave < 0 || place.octave >= place.of->count() - 1) return false;
  double bytes = static_cast<double>(size_of(place.of->shape().type)) * place.of->components();
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t all = place.of->sampled_grid(place.octave).dims[a];
    const bool is_within = place.first[a] >= 0 && place.first[a] % 8 == 0 && place.first[a] < all && place.dims[a] > 0 &&
                           place.dims[a] <= all - place.first[a];
    if (!is_within) return false;
    bytes *= static_cast<double>(place.dims[a]);
  }
  return bytes <= WindowPolicy::most_bytes;
}

WindowPolicy::WindowPolicy(const Stock& stock) : stock_(stock) {
  stock_.clear();
  for (std::size_t n = 0; n < stock_.size(); ++n)
    laid_.push_back({std::vector<WindowPlace>(static_cast<std::size_t>(stock_.octaves(n).count() - 1))});
}

std::optional<WindowPlace> WindowPolicy::next(const FeetMotion& motion) noexcept {
  const bool is_usable = is_finite(motion.feet_m.low_m) && is_finite(motion.feet_m.high_m) &&
                         is_finite(motion.velocity_m_per_s) && motion.hand_scale > 0.0;
  if (!is_usable) return std::nullopt;
  for (Laid& laid : laid_) laid.wait_s = -1.0;
  stock_.for_each_needed_live(motion.time, [&](std::size_t field, double wait_s) { laid_[field].wait_s = wait_s; });
  for (Laid& laid : laid_)
    if (laid.wait_s < 0.0) std::ranges::fill(laid.places, WindowPlace{});  // as sessions drop them
  for (int octave = stock_.count() - 2; octave >= 0; --octave) {
    std::optional<WindowPlace> soonest;
    double least_wait_s = std::numeric_limits<double>::infinity();
    for (std::size_t field = 0; field < stock_.size(); ++field) {
      const Laid& laid = laid_[field];
      if (!(laid.wait_s >= 0.0 && laid.wait_s < least_wait_s) || octave >= stock_.octaves(field).count() - 1) continue;
      const std::optional<Wish> wanted = wish(field, octave, motion);
      if (!wanted || serves(laid.places[static_cast<std::size_t>(octave)], *wanted)) continue;
      if (!lost_.contains(key_of(wanted->place))) soonest = wanted->place, least_wait_s = laid.wait_s;
    }
    if (soonest) return soonest;
  }
  return std::nullopt;
}

/// Window of an octave for this motion; none if the octave is finer than the hand can feel, or its window too large.
std::optional<WindowPolicy::Wish> WindowPolicy::wish(std::size_t field, int octave, const FeetMotion& motion) const noexcept {
  const Octaves& octaves = stock_.octaves(field);
  const Similarity pose = stock_.pose(field, motion.time);
  const double spacing_m = std::ldexp(octaves.spacing_m(), octave) * pose.scale;
  const double speed_m_per_s = norm(motion.velocity_m_per_s);
  if (spacing_m < 0.5 * tick_s * speed_m_per_s || spacing_m < finest_hand_m * motion.hand_scale) return std::nullopt;

  const double lead_m = std::min(lead_s * speed_m_per_s, longest_lead_voxels * spacing_m);
  const Vec3 ahead_m = speed_m_per_s > 0.0 ? lead_m / speed_m_per_s * motion.velocity_m_per_s : Vec3{};
  std::array<double, 3> low, high;
  low.fill(std::numeric_limits<double>::infinity()), high.fill(-std::numeric_limits<double>::infinity());
  for (int corner = 0; corner < 8; ++corner) {
    const auto end = [&](int axis, double a, double b) { return corner >> axis & 1 ? b : a; };
    const Vec3 at_m{end(0, motion.feet_m.low_m.x, motion.feet_m.high_m.x),
                    end(1, motion.feet_m.low_m.y, motion.feet_m.high_m.y),
                    end(2, motion.feet_m.low_m.z, motion.feet_m.high_m.z)};
    const Vec3 steps = octaves.steps_of(octave, pose.to_hand(at_m + ahead_m));
    const double at[3] = {steps.x, steps.y, steps.z};
    for (std::size_t a = 0; a < 3; ++a) low[a] = std::min(low[a], at[a]), high[a] = std::max(high[a], at[a]);
  }
  Wish made{{&octaves, octave}};
  double bytes = static_cast<double>(size_of(octaves.shape().type)) * octaves.components();
  const auto border = static_cast<double>(Octaves::border(octave));
  for (std::size_t a = 0; a < 3; ++a) {
    const auto all = static_cast<double>(octaves.sampled_grid(octave).dims[a]);
    const double step = step_voxels;
    const double size = static_cast<double>(size_voxels) + std::ceil(std::min(high[a] - low[a], all) / step) * step;
    made.first[a] = std::clamp(0.5 * (low[a] + high[a]) - 0.5 * size, 0.0, std::max(all - size, 0.0));
    // Of whole chunks: beside the border voxels of the octave the window begins and ends within them, and by multiples of 8.
    const double chunks_first = std::round(made.first[a] / step) * step, chunks_end = chunks_first + size;
    const double first = chunks_first > 0.0 && border > 0.0 ? chunks_first + 8.0 : chunks_first;
    // A remainder smaller than a step belongs to the window before it.
    const double end = chunks_end + step > all ? all : chunks_end + border;
    made.place.first[a] = static_cast<std::int64_t>(first), made.place.dims[a] = static_cast<std::int64_t>(end - first);
    bytes *= end - first;
  }
  if (bytes > most_bytes) return std::nullopt;
  return made;
}

bool WindowPolicy::serves(const WindowPlace& laid, const Wish& wish) noexcept {
  if (!laid.of) return false;
  if (laid.first == wish.place.first && laid.dims == wish.place.dims) return true;
  for (std::size_t a = 0; a < 3; ++a) {
    if (std::abs(static_cast<double>(laid.first[a]) - wish.first[a]) > most_off_voxels) return false;
    // Beside the borders of the grid windows differ in size by a remainder; elsewhere by the size of a tool that has turned.
    if (laid.dims[a] + step_voxels <= wish.place.dims[a]) return false;
  }
  return true;
}

void WindowPolicy::made(const WindowPlace& place) noexcept {
  for (std::size_t n = 0; n < stock_.size(); ++n)
    if (&stock_.octaves(n) == place.of) laid_[n].places[static_cast<std::size_t>(place.octave)] = place;
}

void WindowPolicy::forget() noexcept {
  for (Laid& laid : laid_) std::ranges::fill(laid.places, WindowPlace{});
}

void WindowPolicy::take_over(const WindowPolicy& other) noexcept {
  for (std::size_t n = 0; n < stock_.size(); ++n) {
    for (std::size_t m = 0; m < other.stock_.size(); ++m)
      if (&stock_.octaves(n) == &other.stock_.octaves(m)) laid_[n] = other.laid_[m];
  }
}

}  // namespace palpa
