// Reachable contact of a scene: its first contact with a hand, and the placement of a recorded hand.
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

/// Nearest contact to given positions.
struct Nearest {
  double distance_m = 0.0;
  Vec3 direction;  ///< [m] vector from the closest of the positions; its length is the distance
};

/// Placement of a recorded hand.
struct RecordingPlacement {
  double scale = 1.0;          ///< [1] factor of all positions
  Vec3 offset_m;               ///< displacement after scaling
  double contact_share = 0.0;  ///< [1] share of ticks in contact, in a trial over its first 120 s
};

/// Contact within the hand's reach. A session samples the scene along straight paths from the user, at 0.1 m/s, from the first
/// moment of its data on: valid for any modes, masks and plug-ins. Not in a tick: makes sessions, threads and memory, and takes
/// tenths of a second. Immutable; any thread.
class Reach {
 public:
  /// Samples a cube of 0.18 m about the centre of the workspace, and 20 mm in front of it.
  /// \param progress  called with the share done, 0…1, from this thread; may be empty
  /// Throws SceneError on a scene that cannot be felt.
  explicit Reach(const Scene& scene, const std::function<void(double)>& progress = {});

  /// No mode exerts a force that counts as contact on any path.
  bool is_empty() const noexcept { return is_empty_; }
  const Scene& scene() const noexcept { return scene_; }
  /// Encounter of a simulated hand: a place near the centre, with most contact around it, of most modes, and the most even
  /// front. The hand begins 20 mm before it. Its depth is half of the bearable depth: from the first level (or the first
  /// contact, without levels) to its end, its break-through, or the scene's force limit. A smaller motion or another depth is
  /// chosen if clearly better in a trial. The motion's radius is at most that of the contact around the place. Samples some
  /// hundred more paths. Programming error (assert) without contact.
  /// \param hold  of the hand: an arm has to aim deeper than it gets
  Encounter encounter(const SimulatedMotion& motion, Hold hold) const;
  /// Placement of a recording with most contact. All displacements by whole cells of 10 x 10 x 5 mm are ranked by the share of
  /// the time in cells with contact plus that of the modes met in more than 2 % of it; fronts count for more, a start behind a
  /// level for less. The best few are tried, and the one with the longest contact with the most modes is chosen, if its force
  /// stays below the limit. A motion wider than 0.25 m, impossible on a desktop device, is first scaled to 0.15 m. If trials
  /// are often at the force limit, as beside levels that hold, cells beyond the limit are avoided, then smaller motions tried.
  /// Programming error (assert) without contact.
  RecordingPlacement place_recording(const std::shared_ptr<const Target>& recording, Hold hold) const;
  /// Share [1] of these hand positions [m] in contact.
  double felt_share(std::span<const Vec3> places_m) const noexcept;
  /// Nearest contact to any of these hand positions [m]; none without contact or positions.
  std::optional<Nearest> nearest(std::span<const Vec3> places_m) const;

 private:
  Scene scene_;
  std::shared_ptr<const detail::ReachLattice> lattice_;
  bool is_empty_ = true;
};

/// "34 mm away: 12 mm to the right, 31 mm up".
std::string format_nearest(const Nearest& nearest);

/// [1] Share of contact below which a run reports reasons. More: sparse scenes explain themselves needlessly; less: misplaced
/// hands are not noticed.
inline constexpr double little_contact = 0.05;
/// Sentences for a person: the distance and direction of the nearest contact from these hand positions [m], and a setting that
/// would help.
/// \param remedy  option that places this hand in contact; empty: none
std::string explain_little_contact(const Reach& reach, std::span<const Vec3> places_m, const std::string& remedy);

}  // namespace palpa
