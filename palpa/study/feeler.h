// Sampling of a scene's contact along straight paths from the user.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "palpa/loop/window_feed.h"
#include "palpa/session/session.h"
#include "palpa/study/summary.h"

namespace palpa::detail {

// Step along a path, and its tick: 0.1 m/s, a hand's approach. Longer steps: coarser depths and ends; shorter: slower.
inline constexpr double way_step_m = 1e-3, way_step_s = 0.01;

/// Number of sampling threads. More than eight are not faster: memory bandwidth is exhausted.
inline std::size_t feeling_threads() { return std::clamp(std::thread::hardware_concurrency(), 1u, 8u); }

/// Calls `work(worker, n)` for all n below `count` in `workers` threads, numbered by `worker`, and returns after the last.
/// `progress` is called from this thread with the share done, 0…1.
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

/// Contact along a straight path, from the first level or, without levels, from first contact on.
struct Way {
  std::optional<double> onset_m;  // its start, from the start of the path; none: no contact
  double bears_m = 0.0;           // distance from there to loss of contact, break-through of a level, or the force limit
  double half_force_n = 0.0;      // force half way of that
  bool at_level = false;          // begins at a level
  bool lets_go = false;           // ends at a break-through
  // Aim of a hand on an arm to reach half of the bearable depth.
  double deepened_m(double arm_stiffness_n_per_m) const { return 0.5 * bears_m + half_force_n / arm_stiffness_n_per_m; }
};

/// Prepares a session for a search of places: of volumes larger than memory it feels the finest octave with at most 256 voxels
/// along each axis, or the coarsest, with all of it in memory. Reads it: blocks. Throws LoadError if the source of voxels
/// fails.
void feel_octave_of_search(Session& session);

/// Samples paths, each with a fresh session: no level is broken, no state of other paths. A tool is upright; volumes larger
/// than memory are felt as `feel_octave_of_search` prepares them. One thread each.
class Feeler {
 public:
  explicit Feeler(const Scene& scene)
      : scene_(scene), fresh_(scene), session_(scene), reach_m_(Tool(scene.tool(), scene.coupling()).reach_m()) {
    feel_octave_of_search(session_);
  }

  /// \param until  stop at the end of the first contact, of the first level, or of the path
  /// \param at     called with the path length [m] so far, the force [N] and the session, at each step in contact
  enum class Until { contact, level, end };
  template <class At>
  Way feel(const Vec3& from_m, const Vec3& direction, double length_m, Until until, const At& at) {
    session_.copy_state_from(fresh_);
    Way way;
    forces_n_.clear();
    bool over = false;
    // A tool begins earlier by its reach, so that none of its feet begins in the data.
    for (int n = static_cast<int>(std::ceil(reach_m_ / way_step_m)); n > 0; --n) tick_at(from_m - n * way_step_m * direction);
    const int steps = static_cast<int>(std::ceil(length_m / way_step_m));
    const auto enough = [&] { return over && (until == Until::contact || (until == Until::level && way.at_level)); };
    for (int n = 0; n <= steps && !enough(); ++n) {
      const double way_m = n * way_step_m;
      const Tick tick = tick_at(from_m + way_m * direction);
      const double force_n = scene_.coupling().stiffness_n_per_m * distance(tick.proxy_m, tick.probe_m);
      const bool felt = force_n > contact_force_n;
      if (felt) at(way_m, force_n, session_);
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
      over = (!felt && !forces_n_.empty()) || way.lets_go || force_n >= scene_.coupling().max_force_n;
      if (felt) forces_n_.push_back(force_n);
    }
    if (!way.onset_m) return way;
    way.bears_m = way_step_m * static_cast<double>(forces_n_.size());
    if (!forces_n_.empty()) way.half_force_n = forces_n_[forces_n_.size() / 2];
    return way;
  }
  Way feel(const Vec3& from_m, const Vec3& direction, double length_m, Until until) {
    return feel(from_m, direction, length_m, until, [](double, double, const Session&) {});
  }

 private:
  Tick tick_at(const Vec3& place_m) { return feed_.tick({.position_m = place_m}, way_step_s); }

  const Scene& scene_;
  const Session fresh_;
  Session session_;
  WindowFeed feed_{session_};
  double reach_m_;  // of the tool
  std::vector<double> forces_n_;
};

/// One feeler per thread.
std::vector<std::unique_ptr<Feeler>> feelers(const Scene& scene);

/// Parallel paths, in `columns` x `rows`.
struct Ways {
  int columns = 0, rows = 0;
  bool turns = false;  // the columns are a ring: the first follows the last
  std::vector<Way> way;
  const Way& at(int column, int row) const { return way[static_cast<std::size_t>(row * columns + column)]; }
};

/// Share [1] of a disc about a node with contact. \param radius  [nodes]
double share_of_disc(const Ways& ways, int column, int row, double radius);
/// Mean slope [1] of the front in a disc about a path with contact. \param radius  [nodes]
/// \param spacing_m  [m] between nodes
double slope_of_disc(const Ways& ways, int column, int row, double radius, double spacing_m);
/// `value(way)` of each path; for paths without contact the mean of their neighbours, from the nearest outwards; NaN
/// without any contact.
std::vector<double> filled(const Ways& ways, const std::function<double(const Way&)>& value);

}  // namespace palpa::detail
