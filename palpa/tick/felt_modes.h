// The modes of a session as the tick uses them: names resolved, memories, what each of them reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "palpa/scene/scene.h"
#include "palpa/tick/watch.h"

namespace palpa {

/// What a mode is told about a sub-step besides its data.
struct Moment {
  Vec3 start_m;  ///< the proxy where the sub-step begins
  Vec3 probe_m;
  double time_step_s = 0.0;
  double stiffness_n_per_m = 0.0;
};

/// The modes of a session with their fields, memories and samples. Construction allocates and throws
/// SceneError; nothing else does. One thread.
class FeltModes {
 public:
  /// \param map  hand to world
  FeltModes(const Scene& scene, const Similarity& map);
  FeltModes(const FeltModes&) = delete;
  FeltModes& operator=(const FeltModes&) = delete;

  std::size_t size() const noexcept { return modes_.size(); }
  std::size_t fields() const noexcept { return fields_.size(); }
  bool enabled(std::size_t m) const noexcept { return modes_[m].enabled; }
  Samples& samples() noexcept { return *samples_; }
  /// Where a strength, a mask or a level may set in, over all enabled modes.
  const std::vector<Watch>& watches() const noexcept { return watches_; }

  /// Fresh memories.
  void start() noexcept;
  /// Takes over the memories of the same modes of another session.
  void continue_from(const FeltModes& other) noexcept;

  /// Empties the set and lets every enabled mode place its primitives, looking at the data at `at_m` [m].
  void place(const Moment& moment, const Vec3& at_m, PrimitiveSet& out) noexcept;
  /// Lets the modes whose planes in the set stand on a level look for it again, at `at_m` [m]; all else stays.
  void place_levels(const Moment& moment, const Vec3& at_m, PrimitiveSet& out) noexcept;
  /// Tells the modes what became of a sub-step that ended with the proxy at `proxy_m` [m]. `state` gives the
  /// state of primitive i of `placed`.
  template <class State>
  void settle(const Moment& moment, const Vec3& proxy_m, const PrimitiveSet& placed, std::span<const Crossing> crossings,
              State&& state) noexcept {
    samples_->move_to(proxy_m);
    for (std::size_t m = 0; m < modes_.size(); ++m) {
      if (!enabled(m) || modes_[m].mode.memory_bytes() == 0) continue;
      slots_.clear();
      for (std::size_t i = 0; i < placed.size(); ++i) {
        const Primitive& p = placed[i];
        if (p.id.mode == m && p.id.slot < first_slot_of_the_tick) slots_.push_back({p.id.slot, state(i), placed.captured(i)});
      }
      const Here here = here_at(m, {proxy_m, moment.probe_m, moment.time_step_s, moment.stiffness_n_per_m}, proxy_m);
      modes_[m].mode.settle({here, slots_, crossings}, memories_.data() + parts_[m].memory);
    }
  }

  /// Whether nothing is felt at `at_m` [m] and nothing can set in before a watch is crossed or the data of a field in
  /// `entered` begin: then any way up to there is free. Places primitives to find out.
  bool silent_at(const Moment& moment, const Vec3& at_m, PrimitiveSet& scratch, std::vector<std::int32_t>& entered) noexcept;

  /// The finest sample spacing [hand m] of the modes whose data the way from `from_m` to `to_m` [m] can meet;
  /// infinity where there are none.
  double finest_m(const Vec3& from_m, const Vec3& to_m) const noexcept;

  /// Slots from here on are the tick's own.
  static constexpr std::uint16_t first_slot_of_the_tick = 0x8000;

 private:
  struct Part {
    std::size_t memory = 0;            // offset in the memories
    std::vector<std::int32_t> fields;  // all that it reads
    std::int32_t main_field = -1;      // its parameter `field`
    // Where the mode places nothing, only a watch can make it place something.
    bool onset_is_watched = false;
    std::vector<const Strength*> strengths;  // those that are functions
  };
  class Resolver;

  Here here_at(std::size_t m, const Moment& moment, const Vec3& start_m) noexcept;
  bool silence_is_watched(std::size_t m, std::vector<std::int32_t>& entered) noexcept;

  Similarity map_;
  std::vector<FieldPtr> fields_;
  std::unique_ptr<Samples> samples_;
  std::vector<SceneMode> modes_;  // with their references resolved
  std::vector<Part> parts_;
  std::vector<Box> boxes_;  // of the fields
  std::vector<std::byte> memories_;
  std::vector<Watch> watches_;
  std::vector<SlotState> slots_;
  PrimitiveSet levels_;  // what place_levels finds
  double finest_m_ = 0.0;
};

}  // namespace palpa
