// The force field of a scene: what a hand feels at each place of a slice or a grid of its workspace.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include "palpa/scene/scene.h"
#include "palpa/solver/vec3.h"

namespace palpa {

/// Places of the hand, evenly apart along the axes of its frame. Those with the same x and y are felt on one way, in which the
/// hand comes from the user; so a map that is deep along z costs hardly more ticks than it has points, and one that is flat
/// across z has a way for each of its points.
struct MapLattice {
  std::array<int, 3> points{1, 1, 1};  ///< [1] along x, y and z; at least 1 each
  Vec3 low_m;                          ///< the first of them, hand frame
  double spacing_m = 1e-3;             ///< from each to the next; above 0

  int ways() const noexcept { return points[0] * points[1]; }
  std::int64_t count() const noexcept { return std::int64_t{ways()} * points[2]; }
  /// x fastest, then y, then z.
  std::size_t number(int i, int j, int k) const noexcept {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(points[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(points[0]) +
           static_cast<std::size_t>(i);
  }
  Vec3 place_m(int i, int j, int k) const noexcept { return low_m + spacing_m * Vec3{1.0 * i, 1.0 * j, 1.0 * k}; }
  friend bool operator==(const MapLattice&, const MapLattice&) = default;
};

/// A square about the middle of the workspace, across one of the hand's axes. Throws LoadError, without a place, on more points
/// than a map may have, and on numbers that make no square.
/// \param axis    0, 1, 2: across x, y, z
/// \param at_m    where it cuts that axis
/// \param size_m  of its sides, above 0 and at most 1 m
/// \param points  [1] along each of its sides, at least 2
MapLattice map_slice(int axis, double at_m, double size_m, int points);
/// The same as a cube.
MapLattice map_grid(double size_m, int points);

/// What is felt at a place, in the hand frame. No force is longer than the scene's limit.
struct MapPoint {
  Vec3 first_contact_n;           ///< force on the hand at the moment at which it comes to the place, moving
  Vec3 steady_n;                  ///< force on the hand once it has been held there until the force does not change any more
  double proxy_distance_m = 0.0;  ///< from probe to proxy, held
  int broken_levels = 0;          ///< [1] broken through on the way to the place
  bool settled = true;            ///< false: the force still changed when it was given up
  friend bool operator==(const MapPoint&, const MapPoint&) = default;
};

/// A map while it is felt: which ways are done, and what was felt on them.
struct ForceMap {
  MapLattice lattice;
  std::vector<MapPoint> points;    ///< `lattice.number`; those of ways that are not done mean nothing
  std::vector<std::uint8_t> done;  ///< 1 for each way that is, x fastest

  explicit ForceMap(const MapLattice& of);
  bool is_whole() const noexcept;
};

struct MapOptions {
  int threads = 0;                          ///< [1] that feel; 0: one for each core
  const std::atomic<bool>* stop = nullptr;  ///< set from any thread: no way is begun any more
  /// Called with the share of the ways that are done, 0…1, by one of the threads; may be empty.
  std::function<void(double)> progress{};
  /// Called every few seconds with the map so far, by one of the threads while the others go on; what it throws ends the map
  /// and is thrown again. May be empty.
  std::function<void(const ForceMap&)> keep{};
};

/// What feeling a map took.
struct MapWork {
  std::int64_t points = 0;  ///< felt now, and not before
  std::int64_t ticks = 0;   ///< probe positions that were felt for that: on the way, at the points, and held there
  double seconds = 0.0;     ///< [s]
  int threads = 0;          ///< [1]
};

/// Feels the ways of a map that are not done. Each begins with a session as new (no level broken, nothing remembered of other
/// ways), 20 mm before all that is within the hand's reach, and goes straight to its last point at 0.1 m/s, in steps of at most
/// 1 mm. Data that move stay as they are at first. The same map, to the bit, whatever the number of threads, and in whatever
/// pieces it is felt.
/// Not for the tick: makes sessions, threads and memory. Throws SceneError on a scene that cannot be felt.
MapWork feel_map(const Scene& scene, ForceMap& map, const MapOptions& options = {});

}  // namespace palpa
