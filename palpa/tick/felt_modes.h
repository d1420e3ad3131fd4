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
struct Situation {
  Vec3 start_m;  ///< the proxy where the sub-step begins
  Vec3 probe_m;
  double time_step_s = 0.0;
  double stiffness_n_per_m = 0.0;
  double gone = 0.0;  ///< [1] share of the sub-step's move at which the data are looked at: so much of their motion is over
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

  /// The data go on: seen from here on as they are at `to`, and the proxy, at `start_m` [m] when they were as at `from`, is
  /// carried with them. Where a mode's plane stands on a level that jumps before the tick ends, `time_step_s` later than
  /// last time, as at `tick_end`, nothing is carried: the primitives that it has in `placed` stay and fade, then its
  /// memory is fresh and what it places fades in. Calls `jumped(m)` for each mode with which that begins.
  template <class Jumped>
  void go_on(const Vec3& start_m, DataTime from, DataTime to, DataTime tick_end, double time_step_s, const PrimitiveSet& placed,
             Jumped&& jumped) noexcept {
    samples_->set_time(to, from);
    any_carried_ = false;
    for (std::size_t m = 0; m < modes_.size(); ++m) {
      if (!enabled(m)) continue;
      const Carried carried = samples_->carried(parts_[m].main_field, start_m, from, to);
      const bool known = carried.known && samples_->carried(parts_[m].main_field, start_m, from, tick_end).known;
      if (fade(m, known, time_step_s, placed)) jumped(m);
      carried_m_[m] = known && !fades_[m].leaving ? carried.position_m - start_m : Vec3{};
      any_carried_ = any_carried_ || carried_m_[m] != Vec3{};
    }
  }
  /// The sub-step is over: nothing is carried.
  void arrive() noexcept;
  /// How far the data of a mode have carried the proxy in this sub-step [m].
  const Vec3& carried_m(std::size_t m) const noexcept { return carried_m_[m]; }
  bool any_carried() const noexcept { return any_carried_; }
  /// The longest of those ways [m].
  double furthest_carried_m() const noexcept;
  /// A mode's strengths are less than they will be, because its level has jumped.
  bool fades(std::size_t m) const noexcept { return fades_[m].share < 1.0; }
  /// The furthest that the data of a mode would carry a position [m] between two moments [m].
  double motion_m(const Vec3& at_m, DataTime from, DataTime to) const noexcept;
  /// Tells the watches how far their data have gone since the sub-step began at `start_m` [m], and where levels have jumped.
  void attend(Watches& watches, const Vec3& start_m) noexcept;

  /// Empties the set and lets every enabled mode place its primitives, looking at the data at `at_m` [m]; a mode one of whose
  /// planes stands on a level looks at `level_m` [m], where that is to hold the proxy.
  void place(const Situation& situation, const Vec3& at_m, const Vec3& level_m, PrimitiveSet& out) noexcept;
  /// Tells the modes what became of a sub-step that ended with the proxy at `proxy_m` [m]. `state` gives the
  /// state of primitive i of `placed`.
  template <class State>
  void settle(const Situation& situation, const Vec3& proxy_m, const PrimitiveSet& placed, std::span<const Crossing> crossings,
              State&& state) noexcept {
    for (std::size_t m = 0; m < modes_.size(); ++m) {
      if (!enabled(m) || modes_[m].mode.memory_bytes() == 0 || fades_[m].leaving) continue;
      samples_->move_to(seen_by(m, proxy_m, situation.gone));
      slots_.clear();
      for (std::size_t i = 0; i < placed.size(); ++i) {
        const Primitive& p = placed[i];
        if (p.id.mode == m && p.id.slot < first_slot_of_the_tick)
          slots_.push_back({p.id.slot, told(m, state(i), placed.captured(i)), placed.captured(i)});
      }
      const Here here = here_at(m, {proxy_m, situation.probe_m, situation.time_step_s, situation.stiffness_n_per_m}, proxy_m);
      modes_[m].mode.settle({here, slots_, crossings}, memories_.data() + parts_[m].memory);
    }
    samples_->move_to(proxy_m);
  }

  /// Whether nothing is felt at `at_m` [m] and nothing can set in before a watch is crossed or the data of a field in
  /// `entered` begin: then any way up to there is free. Places primitives to find out.
  bool silent_at(const Situation& situation, const Vec3& at_m, PrimitiveSet& scratch,
                 std::vector<std::int32_t>& entered) noexcept;

  /// Begins to bring what the enabled modes read at `at_m` [m] into the caches, all fields at once: a tick that begins with
  /// cold caches would wait for one after the other.
  void prefetch(const Vec3& at_m) const noexcept;

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
  // Where a field of an enabled mode has data; mode by mode and together in memory, since every piece of the way asks for them.
  struct Reach {
    Box box_m;                  // of the world
    double finest_m;            // [hand m] of the mode's fields up to this one
    bool last_of_mode = false;  // the next one is another mode's
  };
  class Resolver;
  // How a mode lets go of a level that has jumped, and takes hold again.
  struct Fade {
    double share = 1.0;           // [1] of its strengths
    bool leaving = false;         // what it had placed fades
    bool returns = false;         // it is over: whoever is beyond the level by now has crossed it
    Watch level;                  // that jumped …
    bool free_above = false;      // … and its free side
    std::vector<Primitive> last;  // … and this is it
  };

  Here here_at(std::size_t m, const Situation& situation, const Vec3& start_m) noexcept;
  void place_mode(std::size_t m, const Situation& situation, const Vec3& at_m, PrimitiveSet& out) noexcept;
  bool fade(std::size_t m, bool known, double time_step_s, const PrimitiveSet& placed) noexcept;
  // Where a mode looks for what is at `at_m` when its data have come to the end of the sub-step.
  Vec3 seen_by(std::size_t m, const Vec3& at_m, double gone) const noexcept {
    return any_carried_ ? at_m + (1.0 - gone) * carried_m_[m] : at_m;
  }
  // A level that is weak only because it has jumped does not let go.
  PrimitiveState told(std::size_t m, PrimitiveState state, const Captured& level) const noexcept {
    return fades(m) && level.any() && state == PrimitiveState::slip ? PrimitiveState::stick : state;
  }
  bool silence_is_watched(std::size_t m, std::vector<std::int32_t>& entered) noexcept;

  Similarity map_;
  std::vector<FieldPtr> fields_;
  std::unique_ptr<Samples> samples_;
  std::vector<SceneMode> modes_;  // with their references resolved
  std::vector<Part> parts_;
  std::vector<Reach> reaches_;
  std::vector<std::int32_t> read_;  // fields that enabled modes read, once each
  std::vector<std::byte> memories_;
  std::vector<Vec3> carried_m_;
  bool any_carried_ = false;
  std::vector<Fade> fades_;
  std::vector<Watch> watches_;
  std::vector<SlotState> slots_;
  std::vector<char> stands_;  // by mode: it stood on a level when it placed its primitives last
  double finest_m_ = 0.0;
};

}  // namespace palpa
