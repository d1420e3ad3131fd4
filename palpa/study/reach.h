// What can be felt in a scene, where a hand meets it first, and where a recorded hand feels most.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palpa/device/hand.h"
#include "palpa/scene/scene.h"

namespace palpa {

namespace detail {
struct ReachLattice;
}

/// The nearest thing that can be felt, as seen from somewhere.
struct Nearest {
  double distance_m = 0.0;
  Vec3 direction;  ///< [m] from the place that comes nearest to it; as long as the distance
};

/// Where a recorded hand was laid.
struct Laid {
  double scale = 1.0;          ///< [1] what all its positions are multiplied by
  Vec3 offset_m;               ///< and then moved by
  double contact_share = 0.0;  ///< [1] of its ticks that feel something there, tried over its first 30 s
};

/// What can be felt within the hand's reach, asked of the scene itself: a session feels it along straight ways that come from
/// the user, at 0.1 m/s, as the moment of its data's beginning. So whatever modes, masks and plug-ins do, it is what a hand
/// will feel. Not for the tick: makes sessions, threads and memory, and takes tenths of a second. Immutable; any thread.
class Reach {
 public:
  /// Looks at the cube of 0.18 m about the middle of the workspace, and 20 mm before it.
  /// \param progress  called with the share that is done, 0…1, from this thread; may be empty
  /// Throws SceneError on a scene that cannot be felt.
  explicit Reach(const Scene& scene, const std::function<void(double)>& progress = {});

  /// Nothing was felt along any way.
  bool is_empty() const noexcept { return felt_ways_ == 0; }
  const Scene& scene() const noexcept { return scene_; }
  /// What a simulated hand comes upon: the place near the middle with most to feel around it, of most modes, and the most even
  /// front; 20 mm before it as the beginning; the front around it; and half of what can be borne there as the depth: from
  /// the first level, or from the first contact where there is none, up to where it ends, lets go, or the force reaches
  /// the scene's limit. Nearer to the place, or deeper, where that is clearly better when it is tried out. Where less than
  /// `radius_m` about the place can be felt, the motion's radius is less. Feels some hundred ways more. Programming error
  /// (assert) where nothing is felt. \param hold  what wants to be so deep: an arm has to want more than it gets
  Encounter encounter(const SimulatedMotion& motion, Hold hold) const;
  /// Where a recording feels most: of all displacements by whole cells of 10 x 10 x 5 mm the few with most time at what was
  /// felt, where fronts and what is rare count for more, and a beginning behind a level for less, tried out; the one with the
  /// longest contact with the most modes whose force stays below the limit. A motion wider than 0.25 m, which no desktop device
  /// could make, is first made 0.15 m wide. Programming error where nothing is felt.
  Laid lay(const std::shared_ptr<const Target>& recording, Hold hold) const;
  /// The share [1] of these places of a hand [m] at which something was felt.
  double felt_share(std::span<const Vec3> places_m) const noexcept;
  /// What is nearest to any of these places of a hand [m]; nothing where nothing is felt or there is no place.
  std::optional<Nearest> nearest(std::span<const Vec3> places_m) const;

 private:
  Scene scene_;
  std::shared_ptr<const detail::ReachLattice> lattice_;
  int felt_ways_ = 0;
};

/// "34 mm away: 12 mm to the right, 31 mm up".
std::string words_of(const Nearest& nearest);

/// A hand that is in contact for a smaller share [1] of its time than this is told why.
inline constexpr double little_contact = 0.05;
/// For a person: how far from these places of a hand [m] the nearest thing that can be felt is, in which direction, and the one
/// setting that would change it.
/// \param remedy  the option that lays this hand where it feels something; empty: there is none
std::string why_little_is_felt(const Reach& reach, std::span<const Vec3> places_m, const std::string& remedy);

}  // namespace palpa
