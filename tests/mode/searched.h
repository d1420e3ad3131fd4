// Shared parts of the crossing tests: grids, paths, searches.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "palpa/data/grid.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/timed_field.h"
#include "palpa/mode/crossings.h"

namespace palpa::test::searched {

using CrossingRule = EventPolicy::CrossingRule;

inline constexpr int most_pieces = 512;  // budget of one search

inline double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
}
inline Vec3 in_box(std::mt19937& random, const Box& box) {
  return {uniform(random, box.low_m.x, box.high_m.x), uniform(random, box.low_m.y, box.high_m.y),
          uniform(random, box.low_m.z, box.high_m.z)};
}

using MakeGrid = FieldPtr (*)(const GridGeometry&, Voxels, double, double);
inline constexpr MakeGrid both[] = {grid_field, smooth_grid_field};

/// A grid of 1 mm whose voxels are value(i, j, k).
template <class Value>
FieldPtr grid_with(MakeGrid make, const std::array<std::int64_t, 3>& dims, Value value) {
  const auto data = std::make_shared<std::vector<float>>();
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) data->push_back(static_cast<float>(value(i, j, k)));
    }
  }
  const GridGeometry geometry{dims, 1e-3 * Mat3::identity(), {}};
  return make(geometry, {VoxelType::float32, 1, std::shared_ptr<const void>(data, data->data())}, 1.0, 0.0);
}

/// Fields, watched values, and a search along a path.
struct Searched {
  std::vector<FieldPtr> fields;
  Samples samples;
  StateArena live;
  Crossings sides;
  EventPolicy policy;
  Event event;
  std::vector<Crossing> crossings;
  std::vector<std::int32_t> edges;

  struct Met {
    double share = 1.0;
    bool stopped = false;
    bool edge = false;
    bool out_of_work = false;
  };

  Searched(std::vector<FieldPtr> given, std::vector<Threshold> watched, const Similarity& map = {})
      : fields(std::move(given)),
        samples(fields, map),
        sides(live, watched, fields.size()),
        policy(sides.policy()),
        event(sides.event()) {}
  /// Sides are taken anew at the next search's start.
  void forget() { sides.reset(); }
  void stand(const Vec3& at_m) {
    sides.reset();
    search(at_m, at_m + Vec3{1e-6, 0.0, 0.0});
  }
  Met search(const Vec3& from_m, const Vec3& to_m) {
    policy.clear();
    return search_as_configured(from_m, to_m);
  }
  Met search_as_configured(const Vec3& from_m, const Vec3& to_m) {
    for (const std::int32_t field : edges) policy.fields[static_cast<std::size_t>(field)].stops_at_edges = true;
    WorkBudget pieces(most_pieces);
    sides.first_event(0, from_m, to_m, policy, samples, pieces, event);
    sides.apply(0, event);
    crossings = event.crossings;
    const bool stopped = event.kind != Event::Kind::none;
    return {event.share, stopped, event.kind == Event::Kind::edge, event.kind == Event::Kind::out_of_work};
  }
  bool above(const Vec3& at_m, double level) {
    const ScalarSample s = fields[0]->scalar(at_m);
    return s.value >= level;
  }
};

}  // namespace palpa::test::searched
