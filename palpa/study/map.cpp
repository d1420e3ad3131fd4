#include "palpa/study/map.h"

#include <sys/mman.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <mutex>

#include "palpa/base/limits.h"
#include "palpa/base/load_error.h"
#include "palpa/base/printed.h"
#include "palpa/loop/window_feed.h"
#include "palpa/study/feeler.h"
#include "palpa/study/reach_lattice.h"

namespace palpa {
namespace {

// Time step of a held hand, largest number of its ticks, and largest change of the spring's force between ticks that counts as
// steady. Longer ticks: slow drag settles in fewer of them; a smaller change, or more ticks: slower.
constexpr double held_tick_s = 0.1;
constexpr int most_held_ticks = 50;
constexpr double settled_n = 1e-4;
// [1] Ticks at rest for a proxy whose path exceeded a tick's budget. More: slower on hostile data.
constexpr int most_waiting_ticks = 32;
// Least time between two calls of `keep`, and as a multiple of the last call's duration. Shorter: slower; longer: more is lost.
constexpr std::chrono::duration<double> least_between_keeping{2.0};
constexpr double keeping_share = 20.0;

using Clock = std::chrono::steady_clock;

Scene at_rest(Scene scene) {
  scene.edit<TimeOptions>([&](auto& time) { time.play = TimeOptions::Play::hold; });
  return scene;
}

/// Samples paths in turn. One thread.
class MapFeeler {
 public:
  MapFeeler(const Scene& scene, const MapLattice& lattice)
      : lattice_(lattice),
        tool_(scene.tool(), scene.coupling()),
        max_force_n_(scene.coupling().max_force_n),
        stiffness_n_per_m_(scene.coupling().stiffness_n_per_m),
        fresh_(scene),
        session_(scene),
        held_(scene) {
    fresh_.set_force_limit(max_force_n_);
    const double last_z_m = lattice.place_m(0, 0, lattice.points[2] - 1).z;
    begin_z_m_ = std::max(last_z_m, detail::half_m) + detail::before_m + tool_.reach_m();
  }

  void feel(int i, int j, MapPoints& points) {
    session_.copy_state_from(fresh_);
    broken_levels_ = 0;
    Vec3 at_m = lattice_.place_m(i, j, 0);
    at_m.z = begin_z_m_;
    Tick tick = come_to(at_m, detail::way_step_s);
    for (int k = lattice_.points[2] - 1; k >= 0; --k) {
      const Vec3 to_m = lattice_.place_m(i, j, k);
      const double way_m = at_m.z - to_m.z;
      const int steps = std::max(1, static_cast<int>(std::ceil(way_m / detail::way_step_m - 1e-9)));
      const double step_s = std::max(way_m, 1e-9) / steps * detail::way_step_s / detail::way_step_m;
      for (int n = 1; n <= steps; ++n) {
        const Vec3 step_m = n == steps ? to_m : at_m - Vec3{0.0, 0.0, way_m * n / steps};
        tick = come_to(step_m, step_s);
      }
      for (int n = 0; n < most_waiting_ticks && tick.status == TickStatus::waiting; ++n) tick = come_to(to_m, step_s);
      at_m = to_m;
      points[lattice_.number(i, j, k)] = held(tick);
    }
  }

  std::int64_t ticks() const noexcept { return ticks_; }

 private:
  Tick come_to(const Vec3& place_m, double time_step_s) {
    ++ticks_;
    const Tick tick = feed_.tick({.position_m = place_m}, time_step_s);
    for (const SessionEvent& event : session_.events()) broken_levels_ += event.kind == SessionEventKind::break_through;
    return tick;
  }

  MapPoint held(const Tick& arrived) {
    MapPoint point{.first_contact_n = limited(arrived.force_n), .broken_levels = broken_levels_, .unsettled = true};
    held_.copy_state_from(session_);
    Tick tick = arrived;
    for (int n = 0; n < most_held_ticks && point.unsettled; ++n) {
      ++ticks_;
      const Tick next = held_feed_.tick({.position_m = arrived.probe_m, .velocity_m_per_s = Vec3{}}, held_tick_s);
      point.unsettled = next.status == TickStatus::waiting ||
                        !(stiffness_n_per_m_ * length(tool_.motion(pose_of(tick), pose_of(next))) <= settled_n);
      tick = next;
    }
    point.steady_n = limited(tick.force_n);
    point.proxy_distance_m = distance(tick.proxy_m, tick.probe_m);
    return point;
  }

  static Pose pose_of(const Tick& tick) { return {tick.proxy_m, tick.proxy_turn}; }

  Vec3 limited(const Vec3& force_n) const {
    const double asked_n = norm(force_n);
    return asked_n > max_force_n_ ? max_force_n_ / asked_n * force_n : force_n;
  }

  MapLattice lattice_;
  Tool tool_;
  double max_force_n_;
  double stiffness_n_per_m_;
  double begin_z_m_ = 0.0;
  Session fresh_, session_, held_;
  WindowFeed feed_{session_}, held_feed_{held_};
  int broken_levels_ = 0;
  std::int64_t ticks_ = 0;
};

/// Number of a place on a Z-order curve: the bits of both coordinates in turn.
std::uint64_t morton(std::uint32_t i, std::uint32_t j) noexcept {
  const auto spread = [](std::uint64_t n) {
    for (const auto& [shift, mask] : {std::pair{16, 0x0000ffff0000ffffULL},
                                      {8, 0x00ff00ff00ff00ffULL},
                                      {4, 0x0f0f0f0f0f0f0f0fULL},
                                      {2, 0x3333333333333333ULL},
                                      {1, 0x5555555555555555ULL}})
      n = (n | n << shift) & mask;
    return n;
  };
  return spread(i) | spread(j) << 1;
}

/// Marks paths as done, and keeps the map periodically. Any thread.
class Progress {
 public:
  /// \param ways       [1] paths of the part
  /// \param ways_done  [1] of them
  Progress(ForceMap& map, const MapOptions& options, std::int64_t ways, std::int64_t ways_done)
      : map_(map), options_(options), ways_(ways), ways_done_(ways_done) {}

  bool goes_on() const noexcept { return !problem_is_known_ && !(options_.stop && *options_.stop); }

  void way_is_done(int way) noexcept {
    const std::lock_guard lock(mutex_);
    map_.done[static_cast<std::size_t>(way)] = 1;
    ++ways_done_;
    try {
      if (options_.progress) options_.progress(static_cast<double>(ways_done_) / static_cast<double>(ways_));
      if (options_.keep && Clock::now() >= next_keeping_) keep();
    } catch (...) {
      problem_ = std::current_exception();
      problem_is_known_ = true;
    }
  }

  void rethrow() const {
    if (problem_) std::rethrow_exception(problem_);
  }

 private:
  void keep() {
    const Clock::time_point begin = Clock::now();
    options_.keep(map_);
    const std::chrono::duration<double> pause =
        std::max(least_between_keeping, keeping_share * std::chrono::duration<double>(Clock::now() - begin));
    next_keeping_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(pause);
  }

  ForceMap& map_;
  const MapOptions& options_;
  std::int64_t ways_, ways_done_;
  Clock::time_point next_keeping_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(least_between_keeping);
  std::mutex mutex_;
  std::exception_ptr problem_;
  std::atomic<bool> problem_is_known_ = false;
};

MapLattice lattice_about_middle(double size_m, int points) {
  if (!(size_m > 0.0 && size_m <= 1.0))
    throw LoadError(detail::text("a side of %g mm is out of range; it must be above 0 and at most 1000 mm", 1e3 * size_m));
  if (points < 2) throw LoadError(detail::text("%d points a side are too few; use 2 or more", points));
  MapLattice lattice;
  lattice.points = {points, points, points};
  lattice.spacing_m = size_m / (points - 1);
  lattice.low_m = {-0.5 * size_m, -0.5 * size_m, -0.5 * size_m};
  return lattice;
}

/// \param side    [1] points
/// \param points  [1] of all parts
void check_count(int side, double points, int parts) {
  constexpr int most_side = 32768;  // [1] More: paths are no longer counted by an int
  if (side > most_side) throw LoadError(detail::text("%d points a side are too many; use 32768 or fewer", side));
  const double in_part = points / parts;
  if (limit::map_points.is_passed_by(in_part))
    throw LoadError(detail::text(parts > 1 ? "a part of %.0f points is " : "a map of %.0f points is ", in_part) +
                    more_than(limit::map_points) + (parts > 1 ? ", or more parts" : ", or feel it in parts (--part 1/64)"));
}

}  // namespace

void* detail::take_untouched(std::size_t bytes) {
  // Not reserved: the system would refuse more than its memory, of which most is never written to.
  void* const memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  return memory;
}

void detail::give_untouched(void* memory, std::size_t bytes) noexcept { ::munmap(memory, bytes); }

MapLattice map_slice(int axis, double at_m, double size_m, int points, int parts) {
  if (!(std::abs(at_m) <= 1.0))
    throw LoadError(detail::text("a slice at %g mm is out of range; it must lie within 1000 mm of the middle", 1e3 * at_m));
  check_count(points, 1.0 * points * points, parts);
  MapLattice lattice = lattice_about_middle(size_m, points);
  lattice.points[static_cast<std::size_t>(axis)] = 1;
  (axis == 0 ? lattice.low_m.x : axis == 1 ? lattice.low_m.y : lattice.low_m.z) = at_m;
  return lattice;
}

MapLattice map_grid(double size_m, int points, int parts) {
  check_count(points, 1.0 * points * points * points, parts);
  return lattice_about_middle(size_m, points);
}

ForceMap::ForceMap(const MapLattice& of)
    : lattice(of), points(static_cast<std::size_t>(of.count())), done(static_cast<std::size_t>(of.ways())) {}

bool ForceMap::is_whole() const noexcept {
  return std::all_of(done.begin(), done.end(), [](std::uint8_t is_done) { return is_done == 1; });
}

std::vector<int> ways_of(const MapLattice& lattice, const WorkPart& part) {
  std::vector<std::pair<std::uint64_t, int>> order;
  for (int j = 0; j < lattice.points[1]; ++j)
    for (int i = 0; i < lattice.points[0]; ++i)
      order.emplace_back(morton(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)), j * lattice.points[0] + i);
  std::ranges::sort(order);
  std::vector<int> ways;
  for (std::int64_t n = part.first(lattice.ways()); n < part.end(lattice.ways()); ++n)
    ways.push_back(order[static_cast<std::size_t>(n)].second);
  return ways;
}

MapWork feel_map(const Scene& given, ForceMap& map, const MapOptions& options) {
  const Clock::time_point begin = Clock::now();
  const Scene scene = at_rest(given);
  std::vector<int> ways = ways_of(map.lattice, options.part);
  const auto all = static_cast<std::int64_t>(ways.size());
  std::erase_if(ways, [&](int way) { return map.done[static_cast<std::size_t>(way)] == 1; });
  MapWork work;
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  work.threads = std::clamp(options.threads > 0 ? options.threads : cores, 1, std::max(1, static_cast<int>(ways.size())));
  std::vector<std::unique_ptr<MapFeeler>> feelers;
  for (int n = 0; n < work.threads; ++n) feelers.push_back(std::make_unique<MapFeeler>(scene, map.lattice));
  Progress progress(map, options, all, all - static_cast<std::int64_t>(ways.size()));
  std::atomic<std::int64_t> points = 0;
  detail::in_parallel(static_cast<std::size_t>(work.threads), static_cast<int>(ways.size()), [&](std::size_t worker, int n) {
    if (!progress.goes_on()) return;
    const int way = ways[static_cast<std::size_t>(n)];
    feelers[worker]->feel(way % map.lattice.points[0], way / map.lattice.points[0], map.points);
    points += map.lattice.points[2];
    progress.way_is_done(way);
  });
  progress.rethrow();
  work.points = points;
  for (const auto& feeler : feelers) work.ticks += feeler->ticks();
  work.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return work;
}

}  // namespace palpa
