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

/// The nearest thing that can be felt from some places.
struct Nearest {
  double distance_m = 0.0;
  Vec3 direction;  ///< [m] from the place that comes nearest to it; as long as the distance
};

/// Where a recorded hand was laid.
struct RecordingPlacement {
  double scale = 1.0;          ///< [1] all its positions are multiplied by this
  Vec3 offset_m;               ///< and then moved by this
  double contact_share = 0.0;  ///< [1] share of ticks that feel something, in a trial over its first 30 s
};

/// What can be felt within the hand's reach. A session feels the scene along straight ways that come from the user, at 0.1 m/s,
/// from the first moment of its data on: this is what a hand will feel, whatever modes, masks and plug-ins do. Not for the
/// tick: makes sessions, threads and memory, and takes tenths of a second. Immutable; any thread.
class Reach {
 public:
  /// Looks at a cube of 0.18 m about the middle of the workspace, and 20 mm in front of it.
  /// \param progress  called with the share that is done, 0…1, from this thread; may be empty
  /// Throws SceneError on a scene that cannot be felt.
  explicit Reach(const Scene& scene, const std::function<void(double)>& progress = {});

  /// Nothing was felt along any way.
  bool is_empty() const noexcept { return felt_ways_ == 0; }
  const Scene& scene() const noexcept { return scene_; }
  /// Where a simulated hand meets the scene: a place near the middle, with most to feel around it, of most modes, and the most
  /// even front. The hand begins 20 mm before it. Its depth is half of what can be borne there: from the first level (or the
  /// first contact, where there is none) to where that ends, lets go, or the force reaches the scene's limit. A smaller motion
  /// or another depth is taken if a trial shows that it is clearly better. Where less than `radius_m` around the place can be
  /// felt, the motion's radius is less. Feels some hundred ways more. Programming error (assert) where nothing is felt.
  /// \param hold  who goes so deep: an arm has to aim deeper than it gets
  Encounter encounter(const SimulatedMotion& motion, Hold hold) const;
  /// Where a recording feels most. All displacements by whole cells of 10 x 10 x 5 mm are ranked by the time in cells where
  /// something was felt; fronts and rare modes count for more, a beginning behind a level for less. The best few are tried out,
  /// and the one with the longest contact with the most modes is taken, if its force stays below the limit. A motion wider than
  /// 0.25 m, which no desktop device could make, is first made 0.15 m wide. Programming error (assert) where nothing is felt.
  RecordingPlacement place_recording(const std::shared_ptr<const Target>& recording, Hold hold) const;
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

/// [1] Share of its time in contact below which a user is told why so little is felt. More: sparse scenes explain themselves
/// needlessly; less: misplaced hands are not noticed.
inline constexpr double little_contact = 0.05;
/// Sentences for a person: how far from these places of a hand [m] the nearest thing is that can be felt, in which direction,
/// and the one setting that would change it.
/// \param remedy  the option that lays this hand where it feels something; empty: there is none
std::string why_little_is_felt(const Reach& reach, std::span<const Vec3> places_m, const std::string& remedy);

}  // namespace palpa
