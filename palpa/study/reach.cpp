#include "palpa/study/reach.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <thread>
#include <tuple>

#include "palpa/baseline/path.h"
#include "palpa/field/quantile.h"
#include "palpa/loop/loop.h"
#include "palpa/study/summary.h"
#include "palpa/tick/session.h"

namespace palpa {
namespace {

constexpr double half_m = 0.09;         // of the cube that is looked at
constexpr double before_m = 0.02;       // how far before it a way begins, and before the front a hand does
constexpr double cell_m = 0.01;         // across
constexpr double cell_z_m = 0.005;      // along the ways
constexpr int across = 19, along = 40;  // cells
constexpr double step_m = 1e-3;         // of a way: at 0.1 m/s
constexpr double step_s = 0.01;
constexpr double usual_radius_m = 0.03;

/// Does `work(worker, n)` for all n below `count`, in as many threads as are good for it; `worker` below that number.
template <class Work>
void in_parallel(std::size_t workers, int count, const Work& work, const std::function<void(double)>& progress = {}) {
  std::atomic<int> next{0};
  const auto run = [&](std::size_t worker) {
    for (int n = next++; n < count; n = next++) {
      work(worker, n);
      if (worker == 0 && progress) progress(static_cast<double>(n) / count);
    }
  };
  std::vector<std::jthread> threads;
  for (std::size_t worker = 1; worker < workers; ++worker) threads.emplace_back(run, worker);
  run(0);
}

/// What is felt along one straight way, from the first level that it meets or, where it meets none, from its first contact on.
struct Way {
  std::optional<double> onset_m;  // from its beginning
  double bears_m = 0.0;           // from there to where it ends, lets go, or the force is at its limit
  double half_force_n = 0.0;      // in the middle of that
  bool at_level = false;          // it begins at a level
  bool lets_go = false;           // that is where it ends
  double deepened_m(double arm_stiffness_n_per_m) const { return 0.5 * bears_m + half_force_n / arm_stiffness_n_per_m; }
};

/// Sessions that feel ways, each of which begins where no hand has been.
class Feeler {
 public:
  explicit Feeler(const Scene& scene) : scene_(scene), fresh_(scene, baseline::path), session_(scene, baseline::path) {}

  /// \param until  how far to go: as far as the first contact lasts, as far as the first level does, or to the end
  /// \param at     called with the way [m] and the session wherever something is felt, step by step
  enum class Until { contact, level, end };
  template <class At>
  Way feel(const Vec3& from_m, const Vec3& direction, double length_m, Until until, const At& at) {
    session_.continue_from(fresh_);
    Way way;
    forces_n_.clear();
    bool over = false;
    const int steps = static_cast<int>(std::ceil(length_m / step_m));
    const auto enough = [&] { return over && (until == Until::contact || (until == Until::level && way.at_level)); };
    for (int n = 0; n <= steps && !enough(); ++n) {
      const double way_m = n * step_m;
      const Tick tick = session_.tick({.position_m = from_m + way_m * direction}, step_s);
      const double force_n = scene_.coupling.stiffness_n_per_m * distance(tick.proxy_m, tick.probe_m);
      const bool felt = force_n > contact_force_n;
      if (felt) at(way_m, session_);
      const auto happens = [&](SessionEventKind kind) {
        const auto events = session_.events();
        return std::any_of(events.begin(), events.end(), [&](const SessionEvent& event) { return event.kind == kind; });
      };
      const bool meets_level = !way.at_level && happens(SessionEventKind::onset);
      if (meets_level || (felt && !way.onset_m)) {
        way.onset_m = way_m;
        way.at_level = meets_level;
        over = false;
        forces_n_.clear();
      }
      if (!way.onset_m || over) continue;
      way.lets_go = happens(SessionEventKind::break_through);
      over = (!felt && !forces_n_.empty()) || way.lets_go || force_n >= scene_.coupling.max_force_n;
      if (felt) forces_n_.push_back(force_n);
    }
    if (!way.onset_m) return way;
    way.bears_m = step_m * static_cast<double>(forces_n_.size());
    if (!forces_n_.empty()) way.half_force_n = forces_n_[forces_n_.size() / 2];
    return way;
  }
  Way feel(const Vec3& from_m, const Vec3& direction, double length_m, Until until) {
    return feel(from_m, direction, length_m, until, [](double, const Session&) {});
  }

 private:
  const Scene& scene_;
  const Session fresh_;
  Session session_;
  std::vector<double> forces_n_;
};

std::size_t workers() { return std::clamp(std::thread::hardware_concurrency(), 1u, 8u); }
std::vector<std::unique_ptr<Feeler>> feelers(const Scene& scene) {
  std::vector<std::unique_ptr<Feeler>> all;
  for (std::size_t n = 0; n < workers(); ++n) all.push_back(std::make_unique<Feeler>(scene));
  return all;
}

/// Ways side by side, as a picture of them: `columns` x `rows`.
struct Ways {
  int columns = 0, rows = 0;
  bool turns = false;  // the columns go round
  std::vector<Way> way;
  const Way& at(int column, int row) const { return way[static_cast<std::size_t>(row * columns + column)]; }
};

/// `value(way)` of each way; where nothing is felt, what its neighbours have.
template <class Value>
std::vector<double> filled(const Ways& ways, const Value& value) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> heights;
  for (const Way& way : ways.way) heights.push_back(way.onset_m ? value(way) : none);
  const auto at = [&](int i, int j) {
    if (ways.turns) i = (i + ways.columns) % ways.columns;
    if (i < 0 || j < 0 || i >= ways.columns || j >= ways.rows) return none;
    return heights[static_cast<std::size_t>(j * ways.columns + i)];
  };
  for (bool gaps = true; gaps;) {
    gaps = false;
    std::vector<double> next = heights;
    for (int j = 0; j < ways.rows; ++j)
      for (int i = 0; i < ways.columns; ++i) {
        double& here = next[static_cast<std::size_t>(j * ways.columns + i)];
        if (!std::isnan(here)) continue;
        double sum = 0.0;
        int count = 0;
        for (const double beside : {at(i - 1, j), at(i + 1, j), at(i, j - 1), at(i, j + 1)}) {
          if (!std::isnan(beside)) sum += beside, ++count;
        }
        if (count > 0) here = sum / count;
        gaps = true;
      }
    heights = std::move(next);
  }
  return heights;
}

/// [N/m] of the arm; infinite: it goes where it wants.
double stiffness_of(Hold hold) {
  return hold == Hold::rigid     ? std::numeric_limits<double>::infinity()
         : hold == Hold::relaxed ? relaxed_arm.stiffness_n_per_m
                                 : firm_arm.stiffness_n_per_m;
}

}  // namespace

/// What was felt, cell by cell; cell 0 of each axis at the left, at the bottom, next to the user.
struct Reach::Lattice {
  struct Cell {
    std::uint64_t modes = 0;  // that push here, one bit each: of more than 64 the last bit is that of all others
    bool front = false;       // something begins in this cell or the one before
    double worth = 0.0;       // 1 on average: the more, the more modes push here that do elsewhere but rarely
  };
  static std::size_t number(int i, int j, int k) { return static_cast<std::size_t>((k * across + j) * across + i); }
  static Vec3 way_begin_m(int i, int j) { return {(i - across / 2) * cell_m, (j - across / 2) * cell_m, half_m + before_m}; }
  static Vec3 middle_m(int i, int j, int k) { return way_begin_m(i, j) - Vec3{0.0, 0.0, (k + 0.5) * cell_z_m}; }
  Cell at(int i, int j, int k) const {
    if (i < 0 || j < 0 || k < 0 || i >= across || j >= across || k >= along) return {};
    return cells[number(i, j, k)];
  }
  bool felt(int i, int j, int k) const { return at(i, j, k).modes != 0; }
  /// Whether a way from the user meets a level before it comes to this place of a hand [m], or the way that is next to it.
  bool is_behind_a_level(const Vec3& place_m) const {
    const auto column = [](double m) {
      return std::clamp(static_cast<int>(std::lround(m / cell_m)) + across / 2, 0, across - 1);
    };
    const Way& way = ways.at(column(place_m.x), column(place_m.y));
    return way.at_level && half_m + before_m - place_m.z > *way.onset_m;
  }
  /// The modes that push anywhere along a way.
  std::uint64_t modes_along(int i, int j) const {
    std::uint64_t modes = 0;
    for (int k = 0; k < along; ++k) modes |= at(i, j, k).modes;
    return modes;
  }
  void set_worth() {
    std::array<double, 64> cells_of{};
    for (const Cell& cell : cells) {
      for (std::size_t m = 0; m < 64; ++m) cells_of[m] += static_cast<double>(cell.modes >> m & 1);
    }
    double sum = 0.0, felt_cells = 0.0;
    for (Cell& cell : cells) {
      for (std::size_t m = 0; m < 64; ++m) {
        if (cell.modes >> m & 1) cell.worth += 1.0 / std::sqrt(cells_of[m]);
      }
      sum += cell.worth;
      felt_cells += cell.modes != 0;
    }
    for (Cell& cell : cells) cell.worth *= felt_cells / std::max(sum, 1e-300);
  }

  std::vector<Cell> cells = std::vector<Cell>(static_cast<std::size_t>(across * across * along));
  Ways ways{across, across, false, std::vector<Way>(static_cast<std::size_t>(across* across))};
};

Reach::Reach(const Scene& scene, const std::function<void(double)>& progress) : scene_(scene) {
  auto lattice = std::make_shared<Lattice>();
  const auto sessions = feelers(scene_);
  in_parallel(
      sessions.size(), across * across,
      [&](std::size_t worker, int n) {
        const int i = n % across, j = n / across;
        int first_felt = -2, last_felt = -2;
        const auto note = [&](double way_m, const Session& session) {
          const int k = std::min(along - 1, static_cast<int>(way_m / cell_z_m));
          if (k == last_felt) return;
          if (k != last_felt + 1) first_felt = k;
          last_felt = k;
          Lattice::Cell& cell = lattice->cells[Lattice::number(i, j, k)];
          cell.front = k <= first_felt + 1;
          for (std::size_t m = 0; m < session.modes().size(); ++m) {
            if (norm(session.modes()[m].force_n) > contact_force_n)
              cell.modes |= std::uint64_t{1} << std::min<std::size_t>(m, 63);
          }
        };
        lattice->ways.way[static_cast<std::size_t>(n)] =
            sessions[worker]->feel(Lattice::way_begin_m(i, j), {0, 0, -1}, along * cell_z_m, Feeler::Until::end, note);
      },
      progress);
  for (const Way& way : lattice->ways.way) felt_ways_ += way.onset_m.has_value();
  lattice->set_worth();
  lattice_ = std::move(lattice);
}

namespace {

/// A node of a picture of ways as the middle of a motion.
struct Middle {
  int column = 0, row = 0;
  double radius = 0.0;  // in nodes
};
double share_of_disc(const Ways& ways, int column, int row, double radius) {
  const int reach = static_cast<int>(std::ceil(radius));
  int felt = 0, all = 0;
  for (int j = row - reach; j <= row + reach; ++j)
    for (int i = column - reach; i <= column + reach; ++i) {
      const double di = i - column, dj = j - row;
      if (di * di + dj * dj > radius * radius + 1e-9) continue;
      ++all;
      felt += i >= 0 && j >= 0 && i < ways.columns && j < ways.rows && ways.at(i, j).onset_m;
    }
  return static_cast<double>(felt) / all;
}

/// [1] how much the front falls or rises about a way that feels something, on average.
double slope_of_disc(const Ways& ways, int column, int row, double radius) {
  const int reach = static_cast<int>(std::ceil(radius));
  double sum = 0.0, all = 0.0;
  for (int j = std::max(0, row - reach); j <= std::min(ways.rows - 1, row + reach); ++j)
    for (int i = std::max(0, column - reach); i <= std::min(ways.columns - 1, column + reach); ++i) {
      const double away = std::hypot(i - column, j - row);
      if (away == 0.0 || away > radius || !ways.at(i, j).onset_m) continue;
      sum += std::min(2.0, std::abs(*ways.at(i, j).onset_m - *ways.at(column, row).onset_m) / (away * cell_m));
      ++all;
    }
  return all > 0.0 ? sum / all : 0.0;
}

}  // namespace

namespace {

/// What a hand feels, tried out for a while.
Summary tried(const Scene& scene, std::shared_ptr<const Target> target, Hold hold, double longest_s) {
  const double duration_s = std::min(longest_s, target->duration_s());
  Session session(scene, baseline::path);
  SummaryBuilder builder(scene);
  const auto hand = hand_device(std::move(target), hold);
  run_simulated(session, *hand, {.duration_s = duration_s, .time_ticks = false}, nullptr,
                [&](const TickFrame& frame, const Session& felt) { builder.add(frame, felt); });
  return builder.finish(1.0);
}

/// The share of the modes that were met for more than a moment.
double kinds_met(const Summary& summary) {
  constexpr double some_contact = 0.02;
  const auto met = std::count_if(summary.modes.begin(), summary.modes.end(),
                                 [](const ModeSummary& mode) { return mode.contact_share > some_contact; });
  return static_cast<double>(met) / static_cast<double>(std::max<std::size_t>(1, summary.modes.size()));
}
/// How good that is: contact, with all modes that there are, a force that is rarely at its limit, and a proxy that follows.
double worth_of(const Summary& summary) {
  constexpr double rarely = 0.002;
  const double ticks = static_cast<double>(std::max<std::int64_t>(1, summary.ticks));
  const double limited = static_cast<double>(summary.guard_limited_ticks) / ticks;
  return summary.contact_share + kinds_met(summary) - (limited > rarely ? 1.0 + limited : 0.0) -
         (summary.waiting_ticks > 0 ? 0.5 : 0.0);
}

}  // namespace

Encounter Reach::encounter(const SimulatedMotion& motion, Hold hold) const {
  assert(!is_empty());
  const double arm_stiffness_n_per_m = stiffness_of(hold);
  const Ways& coarse = lattice_->ways;
  const bool has_levels = std::any_of(coarse.way.begin(), coarse.way.end(), [](const Way& way) { return way.at_level; });
  const Feeler::Until until = has_levels ? Feeler::Until::level : Feeler::Until::contact;
  const double wanted_radius_m = motion.radius_m.value_or(usual_radius_m);

  // The coarse place: most to feel within the radius, of most modes, and near the middle of the workspace.
  std::vector<std::uint64_t> modes_along;
  std::uint64_t all_modes = 0;
  for (int n = 0; n < across * across; ++n) {
    all_modes |= modes_along.emplace_back(lattice_->modes_along(n % across, n / across));
  }
  double best = -1.0;
  int column = 0, row = 0;
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < across; ++i) {
      if (!coarse.at(i, j).onset_m) continue;
      const double off = std::hypot(i - across / 2, j - across / 2) / across;
      const double radius = std::clamp(wanted_radius_m, cell_m, usual_radius_m) / cell_m;
      std::uint64_t modes = 0;
      for (int b = std::max(0, j - 1); b <= std::min(across - 1, j + 1); ++b)
        for (int a = std::max(0, i - 1); a <= std::min(across - 1, i + 1); ++a)
          modes |= modes_along[static_cast<std::size_t>(b * across + a)];
      const double kinds = static_cast<double>(std::popcount(modes)) / static_cast<double>(std::popcount(all_modes));
      const double worth = share_of_disc(coarse, i, j, radius) + kinds - 0.5 * off - 0.5 * slope_of_disc(coarse, i, j, radius);
      if (worth > best) best = worth, column = i, row = j;
    }
  const Vec3 above_m = Lattice::way_begin_m(column, row);

  // Finer ways about it, each from a little before where its neighbourhood begins.
  const double spacing_m = std::max(0.003, wanted_radius_m / 10.0);
  const int side = 2 * static_cast<int>(std::ceil(wanted_radius_m / spacing_m)) + 5;
  Ways fine{side, side, false, std::vector<Way>(static_cast<std::size_t>(side * side))};
  const auto sessions = feelers(scene_);
  const auto begin_m = [&](int i, int j) {
    return above_m + Vec3{(i - side / 2) * spacing_m, (j - side / 2) * spacing_m, 0.0};
  };
  in_parallel(sessions.size(), side * side, [&](std::size_t worker, int n) {
    fine.way[static_cast<std::size_t>(n)] =
        sessions[worker]->feel(begin_m(n % side, n / side), {0, 0, -1}, along * cell_z_m, until);
  });

  // The motion's radius: the largest, up to the wanted one, of a disc that can mostly be felt.
  constexpr double mostly = 0.7;
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
  if (middle_worth < 0.0) {
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i) {
        const double worth = fine.at(i, j).onset_m ? share_of_disc(fine, i, j, 2.0) : -1.0;
        if (worth > middle_worth) middle_worth = worth, middle = {i, j, 1.0};
      }
  }

  // As deep as half of what most of these ways can bear; the arm has to want more than it gets.
  std::vector<double> depths_m;
  std::size_t lets_go = 0;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const Way& way = fine.at(i, j);
      if (!way.onset_m || std::hypot(i - middle.column, j - middle.row) > middle.radius + 0.5) continue;
      depths_m.push_back(way.deepened_m(arm_stiffness_n_per_m));
      lets_go += way.lets_go;
    }

  Encounter met;
  met.before_m = before_m;
  // A level that has given way is felt again from outside; data that move may have come after the hand.
  met.retreat_m = scene_.time.play == TimeOptions::Play::hold ? 0.002 : 0.01;
  met.depth_m = depths_m.empty() ? step_m : detail::median(depths_m);
  met.lifts = 2 * lets_go > depths_m.size();
  met.radius_m = middle.radius * spacing_m;
  const double top_m = half_m + before_m;
  const Vec3 place_m = begin_m(middle.column, middle.row);
  const auto height_m = [&](const Way& way) { return top_m - *way.onset_m; };
  met.facing = relief_facing({place_m.x, place_m.y, 0.0}, Relief(filled(fine, height_m), side, side, false), middle.column,
                             middle.row, spacing_m);
  if (motion.kind != SimulatedMotion::Kind::helix) return best_of(variants(met, motion, place_m), motion, hold);

  // Around: the axis goes through the middle of what is felt at the place's height.
  const int level = std::clamp(static_cast<int>(std::lround(place_m.y / cell_m)) + across / 2, 0, across - 1);
  Vec3 sum_m;
  int count = 0;
  for (int k = 0; k < along; ++k)
    for (int j = std::max(0, level - 1); j <= std::min(across - 1, level + 1); ++j)
      for (int i = 0; i < across; ++i) {
        if (lattice_->felt(i, j, k)) sum_m += Lattice::middle_m(i, j, k), ++count;
      }
  met.axis_m = count > 0 ? sum_m / count : place_m;
  met.axis_m.y = place_m.y;
  constexpr int angles = 32, heights = 9;
  // Not up to where the object ends, where it is narrow.
  int up = level, down = level;
  while (up + 1 < across && coarse.at(column, up + 1).onset_m) ++up;
  while (down > 0 && coarse.at(column, down - 1).onset_m) --down;
  met.half_height_m = std::min(met.half_height_m, 0.5 * cell_m * std::max(1, std::min(up - level, level - down)));
  const double height_spacing_m = 2.0 * met.half_height_m / (heights - 1);
  Ways around{angles, heights, true, std::vector<Way>(angles * heights)};
  in_parallel(sessions.size(), angles * heights, [&](std::size_t worker, int n) {
    const double turns = static_cast<double>(n % angles) / angles;
    const double y_m = (n / angles - heights / 2) * height_spacing_m;
    const Vec3 from_m = cylinder_around(met.axis_m, top_m)->at(turns, y_m, 0.0);
    const Vec3 to_m = met.axis_m + Vec3{0.0, y_m, 0.0};
    around.way[static_cast<std::size_t>(n)] = sessions[worker]->feel(from_m, normalized(to_m - from_m), top_m, until);
  });
  if (std::none_of(around.way.begin(), around.way.end(), [](const Way& way) { return way.onset_m; })) return met;
  met.around = relief_around(met.axis_m, Relief(filled(around, height_m), angles, heights, true), 1.0 / angles,
                             0.5 * (heights - 1), height_spacing_m);
  depths_m.clear();
  for (const Way& way : around.way) {
    if (way.onset_m) depths_m.push_back(way.deepened_m(arm_stiffness_n_per_m));
  }
  met.depth_m = detail::median(depths_m);
  return best_of(variants(met, motion, place_m), motion, hold);
}

// What else a description leaves open: nearer to where it is met, where the front is more even; less deep, where it gives way
// easily; deeper, where the front has gaps; and as deep as what is rare lies behind it.
std::vector<Encounter> Reach::variants(const Encounter& met, const SimulatedMotion& motion, const Vec3& place_m) const {
  std::vector<Encounter> all{met};
  constexpr double nearer = 0.4;
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
  if (motion.kind == SimulatedMotion::Kind::helix) return all;
  const double radius = met.radius_m / cell_m + 0.5;
  const double i0 = place_m.x / cell_m + across / 2, j0 = place_m.y / cell_m + across / 2;
  std::array<double, along> worth{};
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < across; ++i) {
      const Way& way = lattice_->ways.at(i, j);
      if (!way.onset_m || std::hypot(i - i0, j - j0) > radius) continue;
      const int front = static_cast<int>(*way.onset_m / cell_z_m);
      for (int k = front; k < along; ++k) worth[static_cast<std::size_t>(k - front)] += lattice_->at(i, j, k).worth;
    }
  Encounter deeper = met;
  deeper.lifts = false;
  deeper.depth_m = cell_z_m * (0.5 + static_cast<double>(std::max_element(worth.begin(), worth.end()) - worth.begin()));
  if (deeper.depth_m > met.depth_m + cell_z_m) all.push_back(deeper);
  return all;
}

// The first, or one that is clearly better when it is tried out.
Encounter Reach::best_of(const std::vector<Encounter>& all, const SimulatedMotion& motion, Hold hold) const {
  constexpr double for_s = 10.0, clearly = 0.1;
  constexpr double plenty = 0.5;
  const auto felt = [&](const Encounter& one) { return tried(scene_, simulated_target(motion, one), hold, for_s); };
  const Summary first = felt(all.front());
  if (first.contact_share >= plenty && kinds_met(first) == 1.0) return all.front();
  std::vector<double> worths(all.size(), worth_of(first));
  in_parallel(workers(), static_cast<int>(all.size()) - 1, [&](std::size_t, int n) {
    const auto at = static_cast<std::size_t>(n) + 1;
    worths[at] = worth_of(felt(all[at]));
  });
  const auto best = std::max_element(worths.begin(), worths.end());
  return *best > worths.front() + clearly ? all[static_cast<std::size_t>(best - worths.begin())] : all.front();
}

Laid Reach::lay(const std::shared_ptr<const Target>& recording, Hold hold) const {
  assert(!is_empty());
  std::vector<Vec3> places_m;
  Vec3 low_m{1e300, 1e300, 1e300}, high_m = -low_m;
  constexpr double longest_s = 120.0, sample_s = 0.01;
  const double duration_s = std::min(longest_s, recording->duration_s());
  for (double t_s = 0.0; t_s <= duration_s; t_s += sample_s) {
    const Target::Point point = recording->at(t_s);
    if (!point.valid) continue;
    const Vec3& x = places_m.emplace_back(point.position_m);
    low_m = {std::min(low_m.x, x.x), std::min(low_m.y, x.y), std::min(low_m.z, x.z)};
    high_m = {std::max(high_m.x, x.x), std::max(high_m.y, x.y), std::max(high_m.z, x.z)};
  }
  if (places_m.empty()) return {};
  const Vec3 first_m = places_m.front();
  constexpr double widest_m = 0.25, narrowed_m = 0.15;
  const double width_m = largest_component(high_m - low_m);
  const double scale = width_m > widest_m ? narrowed_m / width_m : 1.0;

  // How long the hand is in which cell.
  struct Stay {
    int i, j, k, count;
  };
  std::vector<Stay> stays;
  for (const Vec3& place_m : places_m) {
    const Vec3 m = scale * place_m;
    const Stay stay{static_cast<int>(std::lround(m.x / cell_m)), static_cast<int>(std::lround(m.y / cell_m)),
                    static_cast<int>(std::lround(-m.z / cell_z_m)), 1};
    if (!stays.empty() && stays.back().i == stay.i && stays.back().j == stay.j && stays.back().k == stay.k) {
      ++stays.back().count;
    } else {
      stays.push_back(stay);
    }
  }
  std::sort(stays.begin(), stays.end(),
            [](const Stay& a, const Stay& b) { return std::tie(a.i, a.j, a.k) < std::tie(b.i, b.j, b.k); });
  std::size_t kept = 0;
  for (std::size_t n = 1; n < stays.size(); ++n) {
    Stay& last = stays[kept];
    if (last.i == stays[n].i && last.j == stays[n].j && last.k == stays[n].k) {
      last.count += stays[n].count;
    } else {
      stays[++kept] = stays[n];
    }
  }
  stays.resize(kept + 1);
  Stay low = stays.front(), high = stays.front();
  for (const Stay& stay : stays) {
    low = {std::min(low.i, stay.i), std::min(low.j, stay.j), std::min(low.k, stay.k), 0};
    high = {std::max(high.i, stay.i), std::max(high.j, stay.j), std::max(high.k, stay.k), 0};
  }

  // The middle of the workspace is in these cells of the lattice.
  constexpr int i0 = across / 2, j0 = across / 2, k0 = static_cast<int>((half_m + before_m) / cell_z_m);
  struct Place {
    double worth;
    int i, j, k;
  };
  const auto far = [](const Place& p) { return 4 * p.i * p.i + 4 * p.j * p.j + p.k * p.k; };

  // The best of them that are far from each other are tried out: first with fronts twice as good, for there is most to feel;
  // where that gives little, by time alone.
  constexpr std::size_t most_tried = 5;
  constexpr double plenty = 0.4, for_s = 30.0;
  struct Try {
    double worth;
    Laid laid;
  };
  // A hand that begins behind a level is in what it was to touch, and may never get out.
  constexpr double behind_a_level = 0.25;
  const auto begins_behind = [&](const Vec3& offset_m) { return lattice_->is_behind_a_level(scale * first_m + offset_m); };
  std::vector<Try> tried_out;
  for (const int front_worth : {2, 1}) {
    if (!tried_out.empty() && tried_out.front().laid.contact_share >= plenty) break;
    std::vector<Place> places;
    for (int i = -high.i - i0; i <= across - 1 - low.i - i0; ++i)
      for (int j = -high.j - j0; j <= across - 1 - low.j - j0; ++j)
        for (int k = -high.k - k0; k <= along - 1 - low.k - k0; ++k) {
          double worth = 0.0;
          for (const Stay& stay : stays) {
            const Lattice::Cell cell = lattice_->at(stay.i + i + i0, stay.j + j + j0, stay.k + k + k0);
            worth += stay.count * cell.worth * (cell.front ? front_worth : 1);
          }
          if (begins_behind({i * cell_m, j * cell_m, -k * cell_z_m})) worth *= behind_a_level;
          if (worth > 0.0) places.push_back({worth, i, j, k});
        }
    std::sort(places.begin(), places.end(),
              [&](const Place& a, const Place& b) { return a.worth != b.worth ? a.worth > b.worth : far(a) < far(b); });
    std::vector<Vec3> offsets_m;
    for (const Place& place : places) {
      const Vec3 offset_m{place.i * cell_m, place.j * cell_m, -place.k * cell_z_m};
      const bool is_new = std::all_of(offsets_m.begin(), offsets_m.end(),
                                      [&](const Vec3& other_m) { return distance(other_m, offset_m) > 0.02; });
      if (is_new) offsets_m.push_back(offset_m);
      if (offsets_m.size() == most_tried) break;
    }
    std::vector<Summary> summaries(offsets_m.size());
    in_parallel(workers(), static_cast<int>(offsets_m.size()), [&](std::size_t, int n) {
      const auto at = static_cast<std::size_t>(n);
      summaries[at] = tried(scene_, displaced(recording, offsets_m[at], scale), hold, for_s);
    });
    for (std::size_t n = 0; n < summaries.size(); ++n) {
      const double worth = worth_of(summaries[n]) - (begins_behind(offsets_m[n]) ? 1.0 - behind_a_level : 0.0);
      tried_out.push_back({worth, {scale, offsets_m[n], summaries[n].contact_share}});
    }
    std::stable_sort(tried_out.begin(), tried_out.end(), [](const Try& a, const Try& b) { return a.worth > b.worth; });
  }
  // What was tried for a while may still be stuck later on.
  for (const Try& one : tried_out) {
    if (duration_s <= for_s) break;
    const Summary all = tried(scene_, displaced(recording, one.laid.offset_m, scale), hold, longest_s);
    if (200 * all.guard_limited_ticks <= all.ticks) return one.laid;
  }
  return tried_out.empty() ? Laid{} : tried_out.front().laid;
}

double Reach::felt_share(std::span<const Vec3> places_m) const noexcept {
  std::size_t felt = 0;
  for (const Vec3& place_m : places_m) {
    const auto cell = [](double m, double size_m) { return static_cast<int>(std::lround(std::clamp(m / size_m, -1e6, 1e6))); };
    const double before_lattice_m = half_m + before_m - place_m.z;
    felt += lattice_->felt(cell(place_m.x, cell_m) + across / 2, cell(place_m.y, cell_m) + across / 2,
                           cell(before_lattice_m - 0.5 * cell_z_m, cell_z_m));
  }
  return places_m.empty() ? 0.0 : static_cast<double>(felt) / static_cast<double>(places_m.size());
}

std::optional<Nearest> Reach::nearest(std::span<const Vec3> places_m) const {
  std::optional<Nearest> best;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < along; ++k)
    for (int j = 0; j < across; ++j)
      for (int i = 0; i < across; ++i) {
        if (!lattice_->felt(i, j, k)) continue;
        const Vec3 felt_m = Lattice::middle_m(i, j, k);
        for (const Vec3& place_m : places_m) {
          const double away = norm_squared(felt_m - place_m);
          if (!(away < least)) continue;
          least = away;
          best = Nearest{std::sqrt(away), felt_m - place_m};
        }
      }
  return best;
}

namespace {

/// Why a whole scene cannot be felt, and the one setting that would change it, where that was tried and helps.
std::string why_empty(const Scene& scene) {
  if (std::none_of(scene.modes().begin(), scene.modes().end(), [](const SceneMode& mode) { return mode.enabled; })) {
    return scene.modes().empty()
               ? "The scene has no mode: add a [[mode]]; palpa modes lists what there is."
               : "All modes are off: --set mode." + scene.modes().front().name + ".enabled=true turns one on.";
  }
  const std::string nowhere = "Nothing in reach of the hand, 9 cm about the middle of the workspace, can be felt.";
  for (const SceneVolume& volume : scene.volumes()) {
    Scene whole = scene;
    whole.workspace = {};
    whole.workspace.fit = volume.name;
    if (!Reach(whole).is_empty()) {
      return nowhere + " With all of '" + volume.name + "' in reach there is: write fit = \"" + volume.name +
             "\" into [workspace] in place of scale and center.";
    }
  }
  return nowhere + " Levels, strengths or masks may lie beyond the data's values: palpa run SCENE --dry-run prints these.";
}

}  // namespace

std::string words_of(const Nearest& nearest) {
  char text[160];
  std::snprintf(text, sizeof text, "%.0f mm away", 1e3 * nearest.distance_m);
  std::string words = text;
  const std::pair<double, std::pair<const char*, const char*>> axes[] = {
      {nearest.direction.x, {"to the right", "to the left"}},
      {nearest.direction.y, {"up", "down"}},
      {nearest.direction.z, {"towards the user", "away from the user"}}};
  bool first = true;
  for (const auto& [part_m, names] : axes) {
    if (std::abs(part_m) < 1e-3) continue;
    std::snprintf(text, sizeof text, "%s %.0f mm %s", first ? ":" : ",", 1e3 * std::abs(part_m),
                  part_m > 0.0 ? names.first : names.second);
    words += text;
    first = false;
  }
  return words;
}

std::string why_little_is_felt(const Reach& reach, std::span<const Vec3> places_m, const std::string& remedy) {
  if (reach.is_empty()) return why_empty(reach.scene());
  const auto nearest = reach.nearest(places_m);
  if (!nearest) return "The hand's place is never known.";
  std::string words = "The nearest thing that a hand coming from the user can feel is " + words_of(*nearest) + ".";
  if (!remedy.empty()) words += " " + remedy + " lays the hand where it feels most.";
  return words;
}

}  // namespace palpa
