// Contact of a simulated hand with a scene.
#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>

#include "palpa/data/quantile.h"
#include "palpa/device/front.h"
#include "palpa/study/reach.h"
#include "palpa/study/reach_lattice.h"
#include "palpa/study/trial.h"

namespace palpa {

using namespace detail;

namespace {

// Radius of a motion without one. More: fewer places have room for it; less: less of the front is felt.
constexpr double usual_radius_m = 0.03;
constexpr int angles = 32, heights = 9;      // paths around an axis. More: slower; fewer: small objects are missed
constexpr double top_m = half_m + before_m;  // start of all paths from the user

/// Node of `Ways` as the centre of a motion.
struct Middle {
  int column = 0, row = 0;
  double radius = 0.0;  // in nodes
};

/// [N/m] Stiffness of the arm; infinite for a rigid hand.
double stiffness_of(Hold hold) {
  return hold == Hold::rigid     ? std::numeric_limits<double>::infinity()
         : hold == Hold::relaxed ? relaxed_arm.stiffness_n_per_m
                                 : firm_arm.stiffness_n_per_m;
}

double height_m(const Way& way) { return top_m - *way.onset_m; }

/// Path with most contact within the radius, of most modes, on an even front, near the centre of the workspace.
Middle coarse_place(const ReachLattice& lattice, double wanted_radius_m) {
  const Ways& coarse = lattice.ways;
  std::vector<std::uint64_t> modes_along;
  std::uint64_t all_modes = 0;
  for (int n = 0; n < across * across; ++n) {
    all_modes |= modes_along.emplace_back(lattice.modes_along(n % across, n / across));
  }
  double best = -1.0;
  Middle place;
  place.radius = std::clamp(wanted_radius_m, cell_m, usual_radius_m) / cell_m;
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < across; ++i) {
      if (!coarse.at(i, j).onset_m) continue;
      const double off = std::hypot(i - across / 2, j - across / 2) / across;
      std::uint64_t modes = 0;
      for (int b = std::max(0, j - 1); b <= std::min(across - 1, j + 1); ++b)
        for (int a = std::max(0, i - 1); a <= std::min(across - 1, i + 1); ++a)
          modes |= modes_along[static_cast<std::size_t>(b * across + a)];
      const double kinds = static_cast<double>(std::popcount(modes)) / static_cast<double>(std::popcount(all_modes));
      const double worth = share_of_disc(coarse, i, j, place.radius) + kinds - 0.5 * off -
                           0.5 * slope_of_disc(coarse, i, j, place.radius, cell_m);
      if (worth > best) best = worth, place.column = i, place.row = j;
    }
  return place;
}

/// Largest disc, up to the wanted radius, with contact nearly everywhere, near the centre of these paths; if none, the node
/// with most contact around it.
Middle fine_place(const Ways& fine, double wanted_radius_m, double spacing_m) {
  // [1] Least share of contact in a disc. More: smaller motions on sparse data; less: the hand is often without contact.
  constexpr double mostly = 0.7;
  const int side = fine.columns;
  Middle middle{side / 2, side / 2, 1.0};
  double middle_worth = -1.0;
  for (double radius_m = wanted_radius_m; middle_worth < 0.0 && radius_m >= spacing_m; radius_m *= 0.8) {
    const double radius = radius_m / spacing_m;
    const int margin = static_cast<int>(std::ceil(radius));
    for (int j = margin; j < side - margin; ++j)
      for (int i = margin; i < side - margin; ++i) {
        const double share = share_of_disc(fine, i, j, radius);
        const double worth = share - 0.01 * std::hypot(i - side / 2, j - side / 2);
        if (fine.at(i, j).onset_m && share >= mostly && worth > middle_worth) middle_worth = worth, middle = {i, j, radius};
      }
  }
  if (middle_worth >= 0.0) return middle;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const double worth = fine.at(i, j).onset_m ? share_of_disc(fine, i, j, 2.0) : -1.0;
      if (worth > middle_worth) middle_worth = worth, middle = {i, j, 1.0};
    }
  return middle;
}

/// Sets the median depth of these paths: half of the bearable depth. An arm has to aim deeper, because the force deflects it.
void set_depth(Encounter& met, const Ways& fine, const Middle& middle, double arm_stiffness_n_per_m) {
  std::vector<double> depths_m;
  std::size_t lets_go = 0;
  for (int j = 0; j < fine.rows; ++j)
    for (int i = 0; i < fine.columns; ++i) {
      const Way& way = fine.at(i, j);
      if (!way.onset_m || std::hypot(i - middle.column, j - middle.row) > middle.radius + 0.5) continue;
      depths_m.push_back(way.deepened_m(arm_stiffness_n_per_m));
      lets_go += way.lets_go;
    }
  met.depth_m = depths_m.empty() ? way_step_m : median(depths_m);
  met.lifts = 2 * lets_go > depths_m.size();
}

/// Axis of a motion around an object, through the middle of its contact at the place's height, and the height of that motion:
/// half of the distance to the nearer end of the object, which may be narrow there.
void set_axis(Encounter& met, const ReachLattice& lattice, int column, const Vec3& place_m) {
  const int level = std::clamp(static_cast<int>(std::lround(place_m.y / cell_m)) + across / 2, 0, across - 1);
  Vec3 sum_m;
  int count = 0;
  for (int k = 0; k < along; ++k)
    for (int j = std::max(0, level - 1); j <= std::min(across - 1, level + 1); ++j)
      for (int i = 0; i < across; ++i) {
        if (lattice.felt(i, j, k)) sum_m += ReachLattice::middle_m(i, j, k), ++count;
      }
  met.axis_m = count > 0 ? sum_m / count : place_m;
  met.axis_m.y = place_m.y;
  int up = level, down = level;
  while (up + 1 < across && lattice.ways.at(column, up + 1).onset_m) ++up;
  while (down > 0 && lattice.ways.at(column, down - 1).onset_m) --down;
  met.half_height_m = std::min(met.half_height_m, 0.5 * cell_m * std::max(1, std::min(up - level, level - down)));
}

/// Paths towards the axis, from all around.
Ways ways_around(const Encounter& met, const std::vector<std::unique_ptr<Feeler>>& sessions, double height_spacing_m,
                 Feeler::Until until) {
  Ways around{angles, heights, true, std::vector<Way>(angles * heights)};
  in_parallel(sessions.size(), angles * heights, [&](std::size_t worker, int n) {
    const double turns = static_cast<double>(n % angles) / angles;
    const double y_m = (n / angles - heights / 2) * height_spacing_m;
    const Vec3 from_m = cylinder_around(met.axis_m, top_m)->at(turns, y_m, 0.0);
    const Vec3 to_m = met.axis_m + Vec3{0.0, y_m, 0.0};
    around.way[static_cast<std::size_t>(n)] = sessions[worker]->feel(from_m, normalized(to_m - from_m), top_m, until);
  });
  return around;
}

/// The encounter and variants of its free parameters: a smaller motion, for a more even front near the place; half as deep, for
/// fronts that yield easily, and for those that hold, also smaller; four times as deep, for fronts with gaps; and the depth of
/// rare objects.
std::vector<Encounter> variants(const ReachLattice& lattice, const Encounter& met, const SimulatedMotion& motion,
                                const Vec3& place_m) {
  std::vector<Encounter> all{met};
  constexpr double nearer = 0.4;  // [1] of the radius. More: hardly another motion; less: almost none
  if (!motion.radius_m) {
    all.push_back(met);
    all.back().radius_m *= nearer;
    all.back().half_height_m *= nearer;
  }
  if (motion.depth_m) return all;
  for (const double times : {0.5, 4.0}) {
    all.push_back(met);
    all.back().depth_m *= times;
  }
  if (!motion.radius_m) {
    all.push_back(met);
    all.back().radius_m *= nearer;
    all.back().half_height_m *= nearer;
    all.back().depth_m *= 0.5;
  }
  if (motion.kind == SimulatedMotion::Kind::helix) return all;
  const double radius = met.radius_m / cell_m + 0.5;
  const double i0 = place_m.x / cell_m + across / 2, j0 = place_m.y / cell_m + across / 2;
  std::array<double, along> worth{};
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < across; ++i) {
      const Way& way = lattice.ways.at(i, j);
      if (!way.onset_m || std::hypot(i - i0, j - j0) > radius) continue;
      const int front = static_cast<int>(*way.onset_m / cell_z_m);
      for (int k = front; k < along; ++k) worth[static_cast<std::size_t>(k - front)] += lattice.at(i, j, k).worth;
    }
  Encounter deeper = met;
  deeper.lifts = false;
  deeper.depth_m = cell_z_m * (0.5 + static_cast<double>(std::max_element(worth.begin(), worth.end()) - worth.begin()));
  if (deeper.depth_m > met.depth_m + cell_z_m) all.push_back(deeper);
  return all;
}

/// First encounter, or another if clearly better in a trial.
Encounter best_of(const Scene& scene, const std::vector<Encounter>& all, const SimulatedMotion& motion, Hold hold) {
  // Duration of a trial, and the least gain [1] of another encounter. Longer: a slower start of runs; shorter: rare objects are
  // missed. More: worse ones stay; less: chance decides.
  constexpr double for_s = 10.0, clearly = 0.1;
  // [1] Share of contact that needs no further trials. More: a slower start; less: better places are missed.
  constexpr double plenty = 0.5;
  const auto felt = [&](const Encounter& one) { return tried(scene, simulated_target(motion, one), hold, for_s); };
  const Summary first = felt(all.front());
  if (first.contact_share >= plenty && kinds_met(first) == 1.0 && !is_often_limited(first)) return all.front();
  std::vector<double> worths(all.size(), worth_of(first));
  in_parallel(feeling_threads(), static_cast<int>(all.size()) - 1, [&](std::size_t, int n) {
    const auto at = static_cast<std::size_t>(n) + 1;
    worths[at] = worth_of(felt(all[at]));
  });
  const auto best = std::max_element(worths.begin(), worths.end());
  return *best > worths.front() + clearly ? all[static_cast<std::size_t>(best - worths.begin())] : all.front();
}

}  // namespace

Encounter Reach::encounter(const SimulatedMotion& motion, Hold hold) const {
  assert(!is_empty());
  const double arm_stiffness_n_per_m = stiffness_of(hold);
  const Ways& coarse = lattice_->ways;
  const bool has_levels = std::any_of(coarse.way.begin(), coarse.way.end(), [](const Way& way) { return way.at_level; });
  const Feeler::Until until = has_levels ? Feeler::Until::level : Feeler::Until::contact;
  const double wanted_radius_m = motion.radius_m.value_or(usual_radius_m);
  const Middle rough = coarse_place(*lattice_, wanted_radius_m);

  // Finer paths around that place.
  const double spacing_m = std::max(0.003, wanted_radius_m / 10.0);
  const int side = 2 * static_cast<int>(std::ceil(wanted_radius_m / spacing_m)) + 5;
  Ways fine{side, side, false, std::vector<Way>(static_cast<std::size_t>(side * side))};
  const auto sessions = feelers(scene_);
  const auto begin_m = [&](int i, int j) {
    return ReachLattice::way_begin_m(rough.column, rough.row) +
           Vec3{(i - side / 2) * spacing_m, (j - side / 2) * spacing_m, 0.0};
  };
  in_parallel(sessions.size(), side * side, [&](std::size_t worker, int n) {
    fine.way[static_cast<std::size_t>(n)] =
        sessions[worker]->feel(begin_m(n % side, n / side), {0, 0, -1}, along * cell_z_m, until);
  });
  const Middle middle = fine_place(fine, wanted_radius_m, spacing_m);

  Encounter met;
  met.before_m = before_m;
  // The hand retreats before the front, because a broken level is only felt again from outside; further if data move, as they
  // may have followed the hand.
  met.retreat_m = scene_.time().play == TimeOptions::Play::hold ? 0.002 : 0.01;
  set_depth(met, fine, middle, arm_stiffness_n_per_m);
  met.radius_m = middle.radius * spacing_m;
  const Vec3 place_m = begin_m(middle.column, middle.row);
  met.facing = relief_facing({place_m.x, place_m.y, 0.0}, Relief(filled(fine, height_m), side, side, false), middle.column,
                             middle.row, spacing_m);
  if (motion.kind == SimulatedMotion::Kind::helix) {
    set_axis(met, *lattice_, rough.column, place_m);
    const double height_spacing_m = 2.0 * met.half_height_m / (heights - 1);
    const Ways around = ways_around(met, sessions, height_spacing_m, until);
    std::vector<double> depths_m;
    for (const Way& way : around.way) {
      if (way.onset_m) depths_m.push_back(way.deepened_m(arm_stiffness_n_per_m));
    }
    if (depths_m.empty()) return met;
    met.around = relief_around(met.axis_m, Relief(filled(around, height_m), angles, heights, true), 1.0 / angles,
                               0.5 * (heights - 1), height_spacing_m);
    met.depth_m = median(depths_m);
  }
  return best_of(scene_, variants(*lattice_, met, motion, place_m), motion, hold);
}

}  // namespace palpa
