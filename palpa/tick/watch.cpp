#include "palpa/tick/watch.h"

#include <algorithm>

namespace palpa {

namespace {
constexpr int halvings = 12;  // of half a step of at most half a sample spacing: to 1e-3 of a spacing and better
}

Watches::Watches(std::span<const Watch> watches) {
  for (const Watch& watch : watches) {
    if (std::find(watches_.begin(), watches_.end(), watch) == watches_.end()) watches_.push_back(watch);
  }
  sides_.assign(watches_.size(), Side::none);
  attention_.assign(watches_.size(), Attention::stop);
}

void Watches::reset() noexcept { std::fill(sides_.begin(), sides_.end(), Side::none); }

Watches::Side Watches::side_at(Samples& samples, const Watch& watch) const noexcept {
  const ScalarSample& sample = samples.scalar(watch.field);
  if (!sample.inside) return Side::none;
  return sample.value >= watch.value ? Side::above : Side::below;
}

void Watches::look(Samples& samples) noexcept {
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    const Side side = side_at(samples, watches_[i]);
    if (side == Side::none || sides_[i] == Side::none) sides_[i] = side;
  }
}

void Watches::attend_all() noexcept { std::fill(attention_.begin(), attention_.end(), Attention::stop); }

void Watches::attend(const Watch& watch, Attention attention) noexcept {
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    // Of two planes on one level the one that holds decides.
    if (watches_[i] == watch && attention_[i] != Attention::held) attention_[i] = attention;
  }
}

Watches::Met Watches::first_crossing(Samples& samples, const Vec3& start_m, const Vec3& end_m,
                                     std::vector<Crossing>& crossings) noexcept {
  if (watches_.empty() || start_m == end_m) return {};
  const auto position = [&](double share) { return share < 1.0 ? start_m + share * (end_m - start_m) : end_m; };
  const auto changed = [&](std::size_t i) {
    if (attention_[i] == Attention::held || sides_[i] == Side::none) return false;
    const Side side = side_at(samples, watches_[i]);
    return side != Side::none && side != sides_[i];
  };
  const auto stops = [&](double share) {
    samples.move_to(position(share));
    for (std::size_t i = 0; i < watches_.size(); ++i) {
      if (attention_[i] == Attention::stop && changed(i)) return true;
    }
    return false;
  };

  Met met;
  // The middle is looked at as well: within half a sample spacing a thin layer can begin and end.
  double before = 0.0;
  if (stops(0.5)) {
    met = {0.5, true};
  } else if (stops(1.0)) {
    before = 0.5;
    met.stopped = true;
  }
  for (int i = 0; met.stopped && i < halvings; ++i) {
    const double middle = 0.5 * (before + met.share);
    (stops(middle) ? met.share : before) = middle;
  }
  samples.move_to(position(met.share));
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    if (!changed(i)) continue;
    sides_[i] = sides_[i] == Side::below ? Side::above : Side::below;
    crossings.push_back({watches_[i].field, watches_[i].value, sides_[i] == Side::above});
  }
  return met;
}

}  // namespace palpa
