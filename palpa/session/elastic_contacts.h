// Contacts of the proxy with elastic levels.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "palpa/solver/primitives.h"

namespace palpa {

/// Feet of the proxy. Trivially copyable, for a StateArena; surplus feet are dropped, and their levels use the proxy's
/// position. Allocates nothing.
class ElasticContacts {
 public:
  void clear() noexcept { size_ = 0; }
  /// Appends a foot; feet are ordered by mode.
  void put(const Foot& foot) noexcept {
    if (size_ < feet_.size()) feet_[size_++] = foot;
  }
  std::span<const Foot> all() const noexcept { return {feet_.data(), size_}; }
  std::span<const Foot> of(std::size_t mode) const noexcept {
    if (size_ == 0) return {};
    return std::ranges::equal_range(all(), mode, {}, [](const Foot& foot) { return std::size_t{foot.id.mode}; });
  }
  /// Vector from the proxy to the foot on a primitive [m], zero if it has none there.
  Vec3 offset_m(const PrimitiveId& id) const noexcept {
    const auto foot = std::ranges::find(all(), id, &Foot::id);
    return foot == all().end() ? Vec3{} : foot->offset_m;
  }

 private:
  std::array<Foot, 16> feet_;
  std::size_t size_ = 0;
};

}  // namespace palpa
