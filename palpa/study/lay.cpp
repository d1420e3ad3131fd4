// Placement of a recorded hand.
#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include "palpa/study/reach.h"
#include "palpa/study/reach_lattice.h"
#include "palpa/study/trial.h"

namespace palpa {

using namespace detail;

namespace {

// Limits of the search: duration of a trial, and of its first part, which a place that is often at the force limit does not
// survive; number of places, and their least distance. Longer, or more places: slower; shorter, or fewer: a good place may be
// missed, or the force limit reached later. Closer places are effectively tried twice.
constexpr double longest_s = 120.0;
constexpr double first_part_s = 20.0;
// [1] Share of contact that needs no further places. More: slower, and motions are narrowed; less: better places are missed.
constexpr double plenty = 0.4;
// [1] Weight of a place where the hand begins behind a level, and may stay behind it. More: such places win; less: they lose to
// places with little contact.
constexpr double behind_a_level = 0.25;
constexpr std::size_t most_tried = 4, most_below = 8;
// [1] Cost of a cell beyond the force limit, in cells in contact, in places sought below the limit. More: hardly any contact;
// less: the limit is reached.
constexpr double beyond_cost = 20.0;

constexpr double apart_m = 0.02;

/// Number of a recording's samples in a cell; cells are counted from the centre of the workspace.
struct Stay {
  int i, j, k, count;
  auto cell() const { return std::tie(i, j, k); }
};
/// Displacement by whole cells, and its estimated contact.
struct Place {
  double worth;
  int i, j, k;
  Vec3 offset_m() const { return {i * cell_m, j * cell_m, -k * cell_z_m}; }
  double far() const { return 4.0 * i * i + 4.0 * j * j + 1.0 * k * k; }  // a hand may be far away: its squares overflow int
};

std::vector<Vec3> places_of(const Target& recording) {
  constexpr double sample_s = 0.01;  // less: slower; more: fast motion skips cells
  std::vector<Vec3> places_m;
  const double duration_s = std::min(longest_s, recording.duration_s());
  for (double t_s = 0.0; t_s <= duration_s; t_s += sample_s) {
    const Target::Point point = recording.at(t_s);
    if (point.valid) places_m.push_back(point.position_m);
  }
  return places_m;
}

/// Factor [1] that narrows a motion too wide for a desktop device; else 1.
double scale_of(const std::vector<Vec3>& places_m) {
  // Widest unscaled motion, and the width of scaled ones. More: motions leave the sampled region; less: real recordings are
  // felt at a wrong size.
  constexpr double widest_m = 0.25, narrowed_m = 0.15;
  Vec3 low_m{1e300, 1e300, 1e300}, high_m = -low_m;
  for (const Vec3& x : places_m) {
    low_m = {std::min(low_m.x, x.x), std::min(low_m.y, x.y), std::min(low_m.z, x.z)};
    high_m = {std::max(high_m.x, x.x), std::max(high_m.y, x.y), std::max(high_m.z, x.z)};
  }
  const double width_m = largest_component(high_m - low_m);
  return width_m > widest_m ? narrowed_m / width_m : 1.0;
}

/// Stay for each cell, in the order of the cells.
std::vector<Stay> stays_of(const std::vector<Vec3>& places_m, double scale) {
  std::vector<Stay> stays;
  for (const Vec3& place_m : places_m) {
    const Vec3 m = scale * place_m;
    stays.push_back({static_cast<int>(std::lround(m.x / cell_m)), static_cast<int>(std::lround(m.y / cell_m)),
                     static_cast<int>(std::lround(-m.z / cell_z_m)), 1});
  }
  std::sort(stays.begin(), stays.end(), [](const Stay& a, const Stay& b) { return a.cell() < b.cell(); });
  std::size_t kept = 0;
  for (std::size_t n = 1; n < stays.size(); ++n) {
    if (stays[kept].cell() == stays[n].cell()) {
      ++stays[kept].count;
    } else {
      stays[++kept] = stays[n];
    }
  }
  stays.resize(kept + 1);
  return stays;
}

/// Worth of a cell in a ranking.
struct Weights {
  int front = 1;        // factor of cells at a front
  double beyond = 0.0;  // cost of a cell beyond the force limit; 0: as others
};
/// All displacements with contact, the best first, by an estimate of what a trial measures (worth_of).
template <class BeginsBehind>
std::vector<Place> ranked_places(const ReachLattice& lattice, const std::vector<Stay>& stays, const Weights& weights,
                                 const BeginsBehind& begins_behind) {
  Stay low = stays.front(), high = stays.front();
  for (const Stay& stay : stays) {
    low = {std::min(low.i, stay.i), std::min(low.j, stay.j), std::min(low.k, stay.k), 0};
    high = {std::max(high.i, stay.i), std::max(high.j, stay.j), std::max(high.k, stay.k), 0};
  }
  // The centre of the workspace is in these cells of the lattice.
  constexpr int i0 = across / 2, j0 = across / 2, k0 = static_cast<int>((half_m + before_m) / cell_z_m);
  double samples = 0.0;
  for (const Stay& stay : stays) samples += stay.count;
  std::uint64_t all_modes = 0;
  for (const ReachLattice::Cell& cell : lattice.cells) all_modes |= cell.modes;
  const int all_kinds = std::max(1, std::popcount(all_modes));
  std::array<int, 64> met{};  // samples by mode
  std::vector<Place> places;
  for (int i = -high.i - i0; i <= across - 1 - low.i - i0; ++i)
    for (int j = -high.j - j0; j <= across - 1 - low.j - j0; ++j)
      for (int k = -high.k - k0; k <= along - 1 - low.k - k0; ++k) {
        Place place{0.0, i, j, k};
        double contact = 0.0;
        met.fill(0);
        for (const Stay& stay : stays) {
          const ReachLattice::Cell cell = lattice.at(stay.i + i + i0, stay.j + j + j0, stay.k + k + k0);
          if (cell.modes == 0) continue;
          const bool beyond = cell.beyond && weights.beyond > 0.0;
          contact += stay.count * (beyond ? -weights.beyond : cell.front ? weights.front : 1.0);
          for (std::uint64_t modes = cell.modes; modes != 0; modes &= modes - 1) met[std::countr_zero(modes)] += stay.count;
        }
        if (contact <= 0.0) continue;
        const auto kinds = std::count_if(met.begin(), met.end(), [&](int count) { return count > some_contact * samples; });
        place.worth = contact / (weights.front * samples) + static_cast<double>(kinds) / static_cast<double>(all_kinds);
        if (begins_behind(place.offset_m())) place.worth *= behind_a_level;
        places.push_back(place);
      }
  std::sort(places.begin(), places.end(),
            [](const Place& a, const Place& b) { return a.worth != b.worth ? a.worth > b.worth : a.far() < b.far(); });
  return places;
}

/// Best places more than `apart_m` from each other.
std::vector<Vec3> best_apart(const std::vector<Place>& places, std::size_t most) {
  std::vector<Vec3> offsets_m;
  for (const Place& place : places) {
    const Vec3 offset_m = place.offset_m();
    const bool is_new = std::all_of(offsets_m.begin(), offsets_m.end(),
                                    [&](const Vec3& other_m) { return distance(other_m, offset_m) > apart_m; });
    if (is_new) offsets_m.push_back(offset_m);
    if (offsets_m.size() == most) break;
  }
  return offsets_m;
}

}  // namespace

RecordingPlacement Reach::place_recording(const std::shared_ptr<const Target>& recording, Hold hold) const {
  assert(!is_empty());
  const std::vector<Vec3> places_m = places_of(*recording);
  if (places_m.empty()) return {};
  struct Try {
    double worth;
    RecordingPlacement laid;
    bool limited;
  };
  std::vector<Try> tried_out;
  const auto try_places = [&](double scale, const std::vector<Stay>& stays, const Weights& weights) {
    const auto begins_behind = [&](const Vec3& offset_m) {
      return lattice_->is_behind_a_level(scale * places_m.front() + offset_m);
    };
    const std::vector<Vec3> offsets_m =
        best_apart(ranked_places(*lattice_, stays, weights, begins_behind), weights.beyond > 0.0 ? most_below : most_tried);
    std::vector<Summary> summaries(offsets_m.size());
    in_parallel(feeling_threads(), static_cast<int>(offsets_m.size()), [&](std::size_t, int n) {
      const auto at = static_cast<std::size_t>(n);
      const std::shared_ptr<const Target> displaced_hand = displaced(recording, offsets_m[at], scale);
      summaries[at] = tried(scene_, displaced_hand, hold, first_part_s);
      if (recording->duration_s() > first_part_s && !is_often_limited(summaries[at]))
        summaries[at] = tried(scene_, displaced_hand, hold, longest_s);
    });
    for (std::size_t n = 0; n < summaries.size(); ++n) {
      const double worth = worth_of(summaries[n]) - (begins_behind(offsets_m[n]) ? 1.0 - behind_a_level : 0.0);
      tried_out.push_back({worth, {scale, offsets_m[n], summaries[n].contact_share}, is_often_limited(summaries[n])});
    }
    std::stable_sort(tried_out.begin(), tried_out.end(), [](const Try& a, const Try& b) { return a.worth > b.worth; });
  };
  const double widest = scale_of(places_m);
  const std::vector<Stay> stays = stays_of(places_m, widest);
  try_places(widest, stays, {.front = 2});
  try_places(widest, stays, {.front = 1});
  const auto is_good = [&] {
    return !tried_out.empty() && !tried_out.front().limited && tried_out.front().laid.contact_share >= plenty;
  };
  // Beside levels that hold, most contact of a motion may lie beyond the limit: places below it, then of a narrower motion.
  const bool limits = std::any_of(tried_out.begin(), tried_out.end(), [](const Try& one) { return one.limited; });
  for (const double smaller : {1.0, 0.7, 0.5, 0.35, 0.25, 0.18}) {
    if (!limits || is_good()) break;
    try_places(smaller * widest, stays_of(places_m, smaller * widest), {.front = 1, .beyond = beyond_cost});
  }
  const auto unlimited = std::find_if(tried_out.begin(), tried_out.end(), [](const Try& one) { return !one.limited; });
  if (unlimited != tried_out.end()) return unlimited->laid;
  return tried_out.empty() ? RecordingPlacement{} : tried_out.front().laid;
}

}  // namespace palpa
