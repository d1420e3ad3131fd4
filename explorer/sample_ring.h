// Ring of ticks from the loop to the window; the loop never blocks.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>

#include "palpa/session/foot_forces.h"
#include "palpa/solver/primitives.h"
#include "palpa/solver/tool.h"
#include "palpa/trace/trace.h"

namespace palpa::explorer {

/// [1] Modes with a force curve of their own. More: curves hide each other.
inline constexpr std::size_t most_shown_modes = 8;
/// [1] Primitives drawn of a moment. More: they hide each other.
inline constexpr std::size_t most_shown_primitives = 24;

/// One tick with the forces of its modes.
struct Sample {
  TickFrame frame;
  std::array<ModeForce, most_shown_modes> modes{};
  std::size_t count = 0;  ///< of `modes`
  std::size_t hand = 0;
};

/// One tick as drawn in the scene. Trivially copyable.
struct Moment {
  std::int64_t tick = -1;  ///< -1: none
  double t_s = 0.0;
  Vec3 probe_m, proxy_m, command_n;
  std::array<PlacedPrimitive, most_shown_primitives> primitives{};
  std::size_t count = 0;
  // Of a tool:
  bool has_tool = false;
  Turn probe_turn{}, proxy_turn{};
  Vec3 torque_nm{};                       ///< sent to the device
  std::array<float, most_feet> feet_n{};  ///< [N] on each foot
  // Of a volume larger than memory:
  bool has_window = false;
  std::array<Vec3, 8> window_m{};  ///< corners of the window of the felt octave, bit a of the number: the high end of axis a

  /// Moves all positions to a frame in which the own frame's origin is here, with equal axes. Allocates nothing.
  void shift(const Vec3& origin_m) noexcept {
    probe_m += origin_m;
    proxy_m += origin_m;
    for (std::size_t i = 0; i < count; ++i) primitives[i].primitive.position_m += origin_m;
    for (Vec3& corner : window_m) corner += origin_m;
  }

  /// Takes turns, torque and forces of feet from a tick of a tool. Allocates nothing.
  void take_tool(const Tick& felt, const Vec3& sent_nm, std::span<const PlacedPrimitive> placed) noexcept {
    has_tool = true;
    probe_turn = felt.probe_turn;
    proxy_turn = felt.proxy_turn;
    torque_nm = sent_nm;
    std::array<Vec3, most_feet> forces_n{};
    add_foot_forces(placed, forces_n);
    for (std::size_t foot = 0; foot < most_feet; ++foot) feet_n[foot] = static_cast<float>(norm(forces_n[foot]));
  }

  /// True if a redraw can be skipped.
  bool looks_like(const Moment& other) const noexcept {
    constexpr double moved_m = 1e-6, changed_n = 1e-3;  // less than a pixel
    if ((tick < 0) != (other.tick < 0) || count != other.count || distance(probe_m, other.probe_m) > moved_m ||
        distance(proxy_m, other.proxy_m) > moved_m ||
        std::lround(100.0 * norm(command_n)) != std::lround(100.0 * norm(other.command_n)))  // the digits of the number
      return false;
    if (!looks_like_tool_of(other) || has_window != other.has_window || window_m != other.window_m) return false;
    for (std::size_t i = 0; i < count; ++i) {
      const PlacedPrimitive &a = primitives[i], &b = other.primitives[i];
      if (a.primitive.id != b.primitive.id || distance(a.primitive.direction, b.primitive.direction) > changed_n ||
          distance(a.primitive.position_m, b.primitive.position_m) > moved_m || distance(a.force_n, b.force_n) > changed_n)
        return false;
    }
    return true;
  }

 private:
  bool looks_like_tool_of(const Moment& other) const noexcept {
    constexpr double turned_rad = 1e-4;
    constexpr float changed_n = 1e-3F;
    if (has_tool != other.has_tool) return false;
    if (!has_tool) return true;
    return norm(rotation_between_rad(probe_turn, other.probe_turn)) < turned_rad &&
           norm(rotation_between_rad(proxy_turn, other.proxy_turn)) < turned_rad &&
           std::lround(1e3 * norm(torque_nm)) == std::lround(1e3 * norm(other.torque_nm)) &&
           std::ranges::equal(feet_n, other.feet_n, [](float a, float b) { return std::abs(a - b) < changed_n; });
  }
};

/// Lock-free SPSC ring of samples. A full ring drops new samples. Allocates at construction.
class SampleRing {
 public:
  static constexpr std::size_t size = 1U << 12;  // 4 s at 1 kHz. More: memory; fewer: gaps when the window is slow

  /// Loop's side. Never blocks.
  void give(const Sample& sample) noexcept {
    const std::uint64_t at = given_.load(std::memory_order_relaxed);
    if (at - taken_.load(std::memory_order_acquire) >= size) return;
    (*samples_)[at % size] = sample;
    given_.store(at + 1, std::memory_order_release);
  }
  /// Window's side. False: empty.
  bool take(Sample& sample) noexcept {
    const std::uint64_t at = taken_.load(std::memory_order_relaxed);
    if (at == given_.load(std::memory_order_acquire)) return false;
    sample = (*samples_)[at % size];
    taken_.store(at + 1, std::memory_order_release);
    return true;
  }

 private:
  std::unique_ptr<std::array<Sample, size>> samples_ = std::make_unique<std::array<Sample, size>>();
  std::atomic<std::uint64_t> given_{0}, taken_{0};
};

}  // namespace palpa::explorer
