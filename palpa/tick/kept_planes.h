// Planes of a level that were met a moment ago, kept where the surface is concave.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "palpa/core/law.h"
#include "palpa/mode/here.h"

namespace palpa {

/// In a crease or a narrow valley each side's tangent plane leads into the other side: with one plane at a time
/// the proxy swings between the two for ever. So the planes met in this tick and the last are kept in
/// the same balance while the proxy stays near them: at most eight beside the one that a mode places now, of distinct
/// normals. A plane that the proxy has got behind bounds no concave place, a convex one turns away from its own
/// tangents; it is forgotten. Fixed memory; one thread.
class KeptPlanes {
 public:
  void clear() noexcept { size_ = 0; }
  std::size_t size() const noexcept { return size_; }
  /// What neither was met nor held the proxy since the last tick began is forgotten.
  void begin_tick() noexcept;
  /// Moves the planes with the data that they stand on, from the moment in which the samples came to theirs.
  void carry(const Samples& samples) noexcept;
  /// Meets the planes that the modes have placed.
  void meet(const PrimitiveSet& set) noexcept;
  /// Forgets planes that stand further than `reach_m` [m] from `position_m` [m].
  void forget_beyond(const Vec3& position_m, double reach_m) noexcept;
  /// Puts planes that are kept beside those of the set that stand on the same level of the same mode: those that the proxy of
  /// `found` would have got behind by more than `behind_m` [m]; none beside one that slips there, since more of them hold no
  /// more. False where there is none. They share one strength, that of the plane placed by the mode: it limits the length of
  /// the sum of their forces, which the caller checks; each by itself, also that one, may exert a hundred times as much, as the
  /// sides of a wedge do. Two planes, each in front of the other's foot, are a hollow. Noise, or a proxy that is below the
  /// bottom, may tilt or push them: with a `slack_m` above 0 [m] those are a hollow too of which one is in front, or both are
  /// behind by no more than that, or which face each other; the caller checks that their balance is on the level. They are put
  /// back half as far as the start of the sub-step, which both should leave free. \param own_n  [N] strengths of the modes' own
  /// primitives, which come first in the set
  bool add_to(PrimitiveSet& set, std::span<const double> own_n, const Balance& found, double behind_m,
              double slack_m) const noexcept;
  static constexpr double wedge = 100.0;  ///< [1]
  /// Ends a sub-step with the proxy at `proxy_m` [m]: planes of levels on which no mode stands any more, those more than
  /// 0.75 `spacing_m` [m] away are forgotten.
  void end_step(const PrimitiveSet& set, const Balance& balance, const Vec3& proxy_m, double spacing_m) noexcept;

 private:
  struct Plane {
    PrimitiveId id;  // of the mode's own plane
    Captured level;
    Vec3 position_m;
    Vec3 normal;
    int age_ticks = 0;
  };
  static constexpr std::size_t most = 9;  // eight beside the newest one

  template <class Drop>
  void drop_if(Drop&& drop) noexcept;

  std::array<Plane, most> planes_;
  std::size_t size_ = 0;  // newest first
};

}  // namespace palpa
