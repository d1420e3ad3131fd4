// Measures of paths along and across fields: drift of a follower, order of convergence, rate independence.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "palpa/session/session.h"
#include "tests/path/shapes.h"

namespace palpa::test {

/// A hand on circles with a follower, 0.1 mm per tick, held 1 mm off its streamline towards the axis.
struct FollowDrift {
  double per_turn_m = 0.0;  ///< from streamline to streamline, over the turns after the first
  double first_turn_m = 0.0;
};
inline constexpr double follow_step_m = 1e-4;
/// \param field     turns about z through the origin
/// \param radius_m  [m] of the streamline
/// \param rise_m    [m] of the streamlines along z per radian; 0: circles
FollowDrift measure_follow(const FieldPtr& field, double radius_m, double rise_m, int turns);
/// u = (−y, x, rise), in m/s for a turn of 1 rad/s.
FieldPtr helical_field(double rise_m, double sign = 1.0);

/// Errors of the path that shrink with the step: one scene, one curved hand path without onsets and break-throughs.
struct OrderCase {
  std::string name;
  std::string scene;
  Vec3 centre_m;
  double radius_m = 0.0;
  double step_m = 3e-4;  ///< of the hand, straight; in one tick or several
  friend std::ostream& operator<<(std::ostream& out, const OrderCase& one) { return out << one.name; }
};
struct Order {
  static constexpr std::array<int, 5> steps{1, 2, 4, 8, 16};  ///< ticks per step of the hand
  std::array<double, 4> errors_m{};                           ///< largest distance of 1, 2, 4, 8 ticks to the path in 16
  std::array<double, 4> differences_m{};                      ///< largest distance between the paths in 1 and 2, 2 and 4, …
  std::array<double, 3> orders{};                             ///< binary logarithms of the ratios of successive differences
  double settled_m = 0.0;                                     ///< indeterminacy of a resting proxy: 5e-4 of the finest spacing
  int events = 0;                                             ///< 0 is expected
  bool slides = false;                                        ///< the proxy's path is at least a tenth of the hand's
};
/// The cases that the modes of this build allow.
std::vector<OrderCase> order_cases();
/// \param in_steps  false: the exact law in one step per tick, like an earlier law
Order measure_order(const OrderCase& wanted, bool in_steps = true);

/// One path of the hand at several speeds.
struct RateCase {
  const Scene* scene = nullptr;
  std::vector<Vec3> corners_m;  ///< straight between them, a tick each at ten times the speed
};
struct Rate {
  double slow_p99_h =
      0.0;  ///< a tenth of the speed against the speed itself: distance of the proxies at the corners, in half finest spacings
  double slow_max_h = 0.0;
  double fast_p99_h = 0.0;  ///< ten times the speed against it
  double fast_max_h = 0.0;
  int corners = 0;    ///< compared: with a force at any speed
  int waiting = 0;    ///< left out: the cap was reached
  int differing = 0;  ///< left out: the three runs differ in met or pressed-through levels
};
Rate measure_rate(const RateCase& wanted);

/// True for an onset or a break-through of a shell, where two paths diverge; at a plane of a material or a vortex the next
/// point holds as well.
bool of_a_shell(const Scene& scene, const SessionEvent& event);
/// The finest sample spacing [hand m] of the scene's volumes.
double finest_spacing_m(const Scene& scene);
Scene scene_of(const std::string& toml, const ModeCatalog& modes = standard_modes());

}  // namespace palpa::test
