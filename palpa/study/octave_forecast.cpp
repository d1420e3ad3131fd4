#include "palpa/study/octave_forecast.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <deque>
#include <limits>
#include <memory>
#include <set>
#include <tuple>

#include "palpa/loop/window_policy.h"
#include "palpa/session/felt_octave.h"

namespace palpa {
namespace {

constexpr double tick_s = 1e-3;

/// Voxels of value zero.
class NoVoxels final : public VoxelSource {
 public:
  bool read(int, const std::array<std::int64_t, 3>&, const std::array<std::int64_t, 3>& dims, std::byte* to) override {
    std::memset(to, 0, static_cast<std::size_t>(dims[0] * dims[1] * dims[2]));
    return true;
  }
};

/// Chunks in memory, the first read dropped first.
class ChunkMemory {
 public:
  ChunkMemory(const ForecastStore& store, std::int64_t most) : store_(store), most_(most) {}
  /// Reads the chunks of a window. Returns the number of those that were not in memory.
  std::int64_t read(const WindowPlace& place) {
    const std::array<std::int64_t, 3>& chunk = store_.chunks[static_cast<std::size_t>(place.octave)];
    std::array<std::int64_t, 3> low{}, end{};
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int64_t first = place.first[a] - Octaves::border(place.octave);
      low[a] = std::max<std::int64_t>(first, 0) / chunk[a];
      end[a] = (first + place.dims[a] - 1) / chunk[a] + 1;
    }
    std::int64_t missing = 0;
    for (std::int64_t k = low[2]; k < end[2]; ++k)
      for (std::int64_t j = low[1]; j < end[1]; ++j)
        for (std::int64_t i = low[0]; i < end[0]; ++i) missing += read_one({place.octave, i, j, k});
    return missing;
  }

 private:
  using Key = std::tuple<int, std::int64_t, std::int64_t, std::int64_t>;
  bool read_one(const Key& key) {
    if (!kept_.insert(key).second) return false;
    order_.push_back(key);
    if (static_cast<std::int64_t>(order_.size()) > most_) kept_.erase(order_.front()), order_.pop_front();
    return true;
  }

  const ForecastStore& store_;
  std::int64_t most_;
  std::set<Key> kept_;
  std::deque<Key> order_;
};

/// Loader on a simulated clock.
class VirtualLoader {
 public:
  VirtualLoader(const ForecastStore& store, Stock& stock, const ChunkSupply& supply)
      : stock_(stock), policy_(stock), memory_(store, supply.cache), supply_(supply) {}

  /// Lays the window that has come by now, and begins the next.
  void step(double now_s, const FeetMotion& motion) {
    if (now_s < done_s_) return;
    if (place_.of) {
      const OctaveWindow window = place_.of->window(place_.octave, place_.first, place_.dims);
      stock_.lay(*place_.of, place_.octave, window);
      policy_.made(place_);
    }
    place_ = policy_.next(motion).value_or(WindowPlace{});
    if (!place_.of) return;
    const std::int64_t missing = memory_.read(place_);
    const auto second = static_cast<std::size_t>(now_s);
    if (by_second_.size() <= second) by_second_.resize(second + 1);
    by_second_[second] += missing;
    chunks_ += missing;
    done_s_ = now_s + supply_.window_s + std::ceil(static_cast<double>(missing) / supply_.at_once) * supply_.chunk_s;
  }
  std::int64_t chunks() const { return chunks_; }
  std::int64_t most_per_s() const { return by_second_.empty() ? 0 : *std::ranges::max_element(by_second_); }

 private:
  Stock& stock_;
  WindowPolicy policy_;
  ChunkMemory memory_;
  ChunkSupply supply_;
  WindowPlace place_;
  double done_s_ = 0.0;
  std::int64_t chunks_ = 0;
  std::vector<std::int64_t> by_second_;
};

}  // namespace

OctaveForecast forecast_octaves(const ForecastStore& store, const Target& hand, const Similarity& hand_to_world, double speed,
                                double duration_s, const ChunkSupply& supply) {
  Octaves::Shape shape{.finest = store.finest, .count = static_cast<int>(store.chunks.size()), .type = VoxelType::uint8};
  shape.ranges = {{0.0, 1.0}};
  shape.source = std::make_shared<NoVoxels>();
  const auto octaves = std::make_shared<const Octaves>(std::move(shape));
  const FieldPtr field = octaves;
  Stock stock({&field, 1});
  VirtualLoader loader(store, stock, supply);
  FeltOctave felt;
  FeltOctavesBuilder builder(octaves->spacing_m() / hand_to_world.scale);
  Vec3 last_m;
  for (std::int64_t tick = 0; static_cast<double>(tick) * tick_s < duration_s; ++tick) {
    const double now_s = static_cast<double>(tick) * tick_s;
    const double end_s = hand.duration_s();
    const double of_hand_s = std::isfinite(end_s) && end_s > 0.0 ? std::fmod(now_s * speed, end_s) : now_s * speed;
    const Vec3 hand_m = hand.at(of_hand_s).position_m, world_m = hand_to_world.to_world(hand_m);
    const double way_m = tick > 0 ? distance(world_m, last_m) : 0.0;
    last_m = world_m;
    loader.step(now_s, {{world_m, world_m}, felt.velocity_m_per_s(), hand_to_world.scale, {}});
    stock.put_in_force({&world_m, 1}, {}, {});
    felt.advance(stock, {&world_m, 1}, way_m, tick_s, {});
    builder.add(felt.octave(), felt.is_forced(), hand_m);
  }
  return {builder.finish(), static_cast<double>(loader.chunks()) / duration_s, static_cast<double>(loader.most_per_s())};
}

}  // namespace palpa
