#include "palpa/loop/window_feed.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "palpa/loop/window_policy.h"

namespace palpa {
namespace {

constexpr double window_voxels = 96.0;  // [voxels] least size. More: slower windows, larger steps; fewer: more windows
// [voxels] Windows begin at multiples of it, so that sessions near each other share them.
constexpr std::int64_t step_voxels = WindowPolicy::step_voxels;

}  // namespace

WindowFeed::WindowFeed(Session& session) : session_(session) { session_.stock().set_complete(true); }

void WindowFeed::lay(const WindowNeed& need) {
  Stock& stock = session_.stock();
  stock.keep_frames(need.from, need.time);
  stock.put_in_force(need.feet_m, need.ahead_m, need.time);
  std::vector<std::size_t> sampled;
  stock.for_each_sampled(need.from, need.time, [&](std::size_t n) { sampled.push_back(n); });
  for (const std::size_t field : sampled) {
    const int coarsest = stock.octaves(field).count() - 1;
    for (int octave = stock.finest(); octave < coarsest; ++octave) {
      // Where a level gives way the proxy flies to the probe in one tick.
      const auto has_room = [&](std::span<const Vec3> feet_m) {
        return stock.room_of_m(field, octave, feet_m, need.time, Stock::margin_voxels) >= need.way_m;
      };
      if (has_room(need.feet_m) && has_room(need.ahead_m)) break;
      if (lay_octave(field, octave, need, true) || has_room(need.feet_m) || lay_octave(field, octave, need, false)) break;
    }
  }
}

/// Lays a window about the feet, as far as the probe if it `reaches_ahead`; false if its voxels are lost, or too many.
bool WindowFeed::lay_octave(std::size_t field, int octave, const WindowNeed& need, bool reaches_ahead) {
  Stock& stock = session_.stock();
  const Octaves& octaves = stock.octaves(field);
  const GridGeometry& grid = octaves.sampled_grid(octave);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double low[3] = {infinity, infinity, infinity}, high[3] = {-infinity, -infinity, -infinity};
  const auto include = [&](const Vec3& foot_m) {
    const Vec3 steps = octaves.steps_of(octave, stock.pose(field, need.time).to_hand(foot_m));
    const double at[3] = {steps.x, steps.y, steps.z};
    for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], at[a]), high[a] = std::max(high[a], at[a]);
  };
  std::ranges::for_each(need.feet_m, include);
  if (reaches_ahead) std::ranges::for_each(need.ahead_m, include);
  const double spacing_m = std::ldexp(octaves.spacing_m(), octave) * stock.pose(field, need.time).scale;
  // Beside the feet as much again as the tick needs, so that a window serves many ticks.
  const double beside = 2.0 * Stock::margin_voxels + need.way_m / spacing_m;
  std::array<std::int64_t, 3> first{}, dims{};
  for (std::size_t a = 0; a < 3; ++a) {
    const double half = std::max(0.5 * window_voxels, beside + 0.5 * (high[a] - low[a])), middle = 0.5 * (low[a] + high[a]);
    const auto last = static_cast<double>(grid.dims[a] - 1);
    first[a] = static_cast<std::int64_t>(std::clamp(middle - half, 0.0, last)) / step_voxels * step_voxels;
    const auto end = static_cast<std::int64_t>(std::clamp(middle + half, 0.0, last)) / step_voxels * step_voxels + step_voxels;
    dims[a] = std::min(end, grid.dims[a]) - first[a];
  }
  const double bytes = static_cast<double>(dims[0]) * static_cast<double>(dims[1]) * static_cast<double>(dims[2]) *
                       static_cast<double>(size_of(octaves.shape().type)) * octaves.components();
  if (bytes > WindowPolicy::most_bytes || lost_.contains({field, octave, first})) return false;
  const OctaveWindow window = octaves.window(octave, first, dims);
  if (!window.grid) {
    lost_.insert({field, octave, first});
    return false;
  }
  stock.lay(field, octave, window);
  return true;
}

}  // namespace palpa
