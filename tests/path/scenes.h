// Measures of whole scenes: halved steps, still hands, energy.
#pragma once

#include <string>
#include <vector>

#include "palpa/session/session.h"
#include "palpa/study/run.h"
#include "tests/path/shapes.h"
#include "tests/solver/random_problems.h"

namespace palpa::test {

/// The probes of a run's hand, tick by tick.
std::vector<Probe> felt_probes(const RunOptions& options);

/// The largest drag of a scene's enabled modes [N·s/m].
double scene_drag_ns_per_m(const Scene& scene);

/// Windows of 50 ms along a hand's path, replayed from an equal state in steps half as long.
struct Halving {
  double contact_s = 0.0;  ///< ticks with a force above 1 mN
  int identical = 0;       ///< of these: equal to the bit, left out
  int compared = 0;
  int after_differing = 0;  ///< left out: after an event in one of the two only, until the window ends
  double p50_voxels = 0.0;  ///< distance of the two proxies, of compared ticks
  double p99_voxels = 0.0;
  double max_voxels = 0.0;
  int worst_tick = -1;
  int differing_events = 0;
  double differing_per_10_s = 0.0;  ///< of contact
  std::vector<int> differing_ticks;
};
Halving measure_halving(const Scene& scene, const std::vector<Probe>& probes);

/// A hand at random points, approached from 20 mm away, after 100 ticks + 8 c/k.
struct StillCase {
  int places = 1000;
  double encoder_step_m = 0.0;
  bool tremor = false;  ///< 8 to 12 Hz, 20 to 100 µm to either side
  std::uint64_t seed = 7;
};
struct Still {
  int in_contact = 0;
  double force_p99_n = 0.0;  ///< peak to peak
  double force_max_n = 0.0;
  double beyond_max_n = -1e9;  ///< peak to peak beyond its bound: 1 mN + (k + 2π·150·D) × the probe's own
  int beyond = 0;
  Vec3 worst_m;
};
Still measure_still(const Scene& scene, const StillCase& wanted);

/// Bounds of a ledger, in every sub-step of a random motion.
struct Booked {
  std::int64_t ticks = 0;
  std::int64_t sub_steps = 0;
  std::int64_t primitives = 0;
  /// Largest work of a primitive beyond |u||position − start − carried|; of a corner in all, Σ over its facets.
  double primitive_beyond_j = 0.0;
  std::int64_t waiting = 0;            ///< ticks that reached the cap
  std::int64_t primitives_beyond = 0;  ///< of exact balances, by more than 1e-15 J
  double works_differ_j = 0.0;         ///< a mode's work against the sum over its primitives
  double path_differs_j = 0.0;         ///< path_and_release_j against its value from the recorded balances
  double path_beyond_j = 0.0;          ///< path_and_release_j beyond k Σ|x_j − x₀||δp_j|
  double identity_differs_j = 0.0;     ///< f₀·Δp = S₀ − S_m + k/2 |Δp|² + I
  double largest_path_j = 0.0;
};
/// Adds `ticks` random ticks within `reach_m` [m] of the middle of the hand's reach.
void measure_booked(const Scene& scene, int ticks, double reach_m, Random& random, Booked& booked);

/// A hand of 0.2 kg with b = kT/2 + D on the spring of a wandering arm, in a closed loop.
struct ClosedLoop {
  std::int64_t ticks = 0;
  double gained_j = -1e9;   ///< most that hand and spring hold beyond where a second began + the arm's, the modes' and the
                            ///< moving data's work, as it is booked
  double arm_work_j = 0.0;  ///< taken and given, for comparison
  double injected_j = 0.0;
  double path_and_release_j = 0.0;
};
void measure_closed_loop(const Scene& scene, int ticks, double reach_m, Random& random, ClosedLoop& loop);

/// Random modes of every type of this build, on the named scalar and vector FIELDs. TOML.
std::string random_modes(Random& random, const std::vector<std::string>& scalars, const std::vector<std::string>& vectors);

}  // namespace palpa::test
