// Tool in the hand: the contact points of the proxy with the data.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa {

/// Contact points of the proxy with the data, its *feet*. Modes sample the data at each foot and place primitives that act
/// there. A point tool, the default, has a single foot, at the proxy itself. Any thread.
class Tool {
 public:
  Tool() : Tool({Vec3{}}) {}
  /// \param points_m  [m] feet, from the proxy; at least one. Allocates.
  explicit Tool(std::vector<Vec3> points_m) : points_m_(std::move(points_m)), feet_(points_m_.size()) {
    is_point_ = feet_ == 1 && points_m_[0] == Vec3{};
  }

  std::size_t feet() const noexcept { return feet_; }
  /// Position of a foot [m] for the proxy at `proxy_m` [m]; of a point tool the proxy to the bit. Allocates nothing.
  Vec3 foot_m(const Vec3& proxy_m, std::size_t foot) const noexcept { return is_point_ ? proxy_m : proxy_m + points_m_[foot]; }
  /// Position of the proxy [m] with this foot at `foot_m` [m]. Allocates nothing.
  Vec3 proxy_m(const Vec3& foot_m, std::size_t foot) const noexcept { return is_point_ ? foot_m : foot_m - points_m_[foot]; }

 private:
  std::vector<Vec3> points_m_;
  std::size_t feet_;
  bool is_point_;
};

}  // namespace palpa
