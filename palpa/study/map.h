// Force field of a scene: forces on a hand over a slice or a grid of its workspace.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <new>
#include <utility>
#include <vector>

#include "palpa/file/work_part.h"
#include "palpa/scene/scene.h"
#include "palpa/solver/vec3.h"

namespace palpa {

/// Lattice of hand positions along the axes of the hand frame. Positions of equal x and y are on one path from the user; so a
/// map deep along z costs hardly more ticks than points, and one flat across z has a path for each point.
struct MapLattice {
  std::array<int, 3> points{1, 1, 1};  ///< [1] along x, y and z; at least 1 each
  Vec3 low_m;                          ///< first position, hand frame
  double spacing_m = 1e-3;             ///< distance of neighbours; above 0

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

/// Square about the centre of the workspace, across an axis of the hand frame. Throws LoadError, without a place, above the
/// maximum of map points in a part, and on invalid numbers.
/// \param axis    0, 1, 2: across x, y, z
/// \param at_m    position on that axis
/// \param size_m  of its sides, above 0 and at most 1 m
/// \param points  [1] along each of its sides, 2…32768
/// \param parts   [1] of equal size in which the map is felt, at least 1
MapLattice map_slice(int axis, double at_m, double size_m, int points, int parts = 1);
/// Cube about the centre of the workspace; `map_slice` otherwise.
MapLattice map_grid(double size_m, int points, int parts = 1);

/// Forces at a position, in the hand frame, within the scene's limit.
struct MapPoint {
  Vec3 first_contact_n;           ///< force on the hand at its arrival, moving
  Vec3 steady_n;                  ///< force on the hand held there until the force is constant
  double proxy_distance_m = 0.0;  ///< from probe to proxy, held
  int broken_levels = 0;          ///< [1] broken through on the path
  bool unsettled = false;         ///< the force still changed at the last tick
  friend bool operator==(const MapPoint&, const MapPoint&) = default;
};

namespace detail {
/// Zeros, for `UntouchedMemory`. Throws std::bad_alloc. \param bytes  [bytes] above 0
void* take_untouched(std::size_t bytes);
void give_untouched(void* memory, std::size_t bytes) noexcept;

/// Zeros whose pages the system provides when they are first written: a process that feels a part has no memory for the others.
template <class T>
struct UntouchedMemory {
  using value_type = T;
  UntouchedMemory() = default;
  template <class U>
  explicit UntouchedMemory(const UntouchedMemory<U>&) noexcept {}
  T* allocate(std::size_t count) { return static_cast<T*>(take_untouched(count * sizeof(T))); }
  void deallocate(T* memory, std::size_t count) noexcept { give_untouched(memory, count * sizeof(T)); }
  template <class U>
  void construct(U*) noexcept {}  // stays zero
  template <class U, class... Values>
  void construct(U* at, Values&&... values) {
    ::new (static_cast<void*>(at)) U(std::forward<Values>(values)...);
  }
  friend bool operator==(const UntouchedMemory&, const UntouchedMemory&) noexcept { return true; }
};
}  // namespace detail

/// Points of a map.
using MapPoints = std::vector<MapPoint, detail::UntouchedMemory<MapPoint>>;

/// Map in progress: finished paths, and their forces.
struct ForceMap {
  MapLattice lattice;
  MapPoints points;                ///< `lattice.number`; undefined on unfinished paths
  std::vector<std::uint8_t> done;  ///< 1 for each finished path, x fastest

  explicit ForceMap(const MapLattice& of);
  bool is_whole() const noexcept;
};

/// Numbers of the paths of a part, x fastest, in the order in which they are felt: along a Z-order curve over x and y, so that
/// neighbours share the windows of a volume larger than memory. Allocates; any thread.
std::vector<int> ways_of(const MapLattice& lattice, const WorkPart& part);

struct MapOptions {
  int threads = 0;                          ///< [1] sampling threads; 0: one per core
  const std::atomic<bool>* stop = nullptr;  ///< set from any thread: no further path begins
  WorkPart part{};                          ///< contiguous paths of `ways_of`; the others stay as they are
  /// Called with the share of finished paths of the part, 0…1, by one of the threads; may be empty.
  std::function<void(double)> progress{};
  /// Called every few seconds with the map so far, by one of the threads while the others continue; an exception ends the map
  /// and is rethrown. May be empty.
  std::function<void(const ForceMap&)> keep{};
};

/// Work for a map.
struct MapWork {
  std::int64_t points = 0;  ///< newly computed
  std::int64_t ticks = 0;   ///< probe positions for these: on the path, at the points, and held there
  double seconds = 0.0;     ///< [s]
  int threads = 0;          ///< [1]
};

/// Computes the unfinished paths of a map. Each begins with a fresh session (no level broken, no state of other paths), 20 mm
/// outside of the hand's reach, of a tool further by its own, upright, and goes straight to its last point at 0.1 m/s, in steps
/// of at most 1 mm. Data that move stay at their first moment. Independent, to the bit, of the number of threads and of
/// interruptions. Not in a tick: makes sessions, threads and memory. Throws SceneError on a scene that cannot be felt.
MapWork feel_map(const Scene& scene, ForceMap& map, const MapOptions& options = {});

}  // namespace palpa
