// Modes of a session within the tick: memories, primitives, notifications.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "palpa/mode/crossings.h"
#include "palpa/mode/state_arena.h"
#include "palpa/scene/mode_inputs.h"
#include "palpa/session/contact_fade.h"
#include "palpa/session/contact_table.h"
#include "palpa/session/sub_step.h"

namespace palpa {

/// Modes of a session with their fields, samples, and memories, kept in a StateArena. Construction allocates and throws
/// SceneError; nothing else does. One thread.
class ModeRuntime {
 public:
  /// \param map       hand to world
  /// \param contacts  of the session; outlive this
  ModeRuntime(StateArena& live, const Scene& scene, const Similarity& map, const ContactTable& contacts);
  ModeRuntime(const ModeRuntime&) = delete;
  ModeRuntime& operator=(const ModeRuntime&) = delete;

  std::size_t size() const noexcept { return modes_.size(); }
  std::size_t fields() const noexcept { return fields_.size(); }
  bool enabled(std::size_t m) const noexcept { return modes_[m].enabled; }
  bool has_memory(std::size_t m) const noexcept { return parts_[m].has_memory; }
  Samples& samples() noexcept { return *samples_; }
  /// Thresholds of strengths, masks and levels of all enabled modes.
  const std::vector<Threshold>& watches() const noexcept { return watches_; }

  /// Whether `other` has equal modes on equal levels and fields, whatever their strengths.
  bool has_same_contacts_as(const ModeRuntime& other) const noexcept;

  /// See Session.
  void set_force_limit(double most_n) noexcept { most_n_ = most_n; }

  void start() noexcept;

  /// Advances the data from `from` to `to`, `time_step_s` [s] later. Their motion carries the proxy from `start_m` [m], or its
  /// foot on an elastic level, deep inside which the motion may be undefined. A mode whose level jumps before `tick_end` fades
  /// instead (ContactFade); `jumped(m)` is called when a fade begins.
  template <class Jumped>
  void advance(const Vec3& start_m, DataTime from, DataTime to, DataTime tick_end, double time_step_s,
               Jumped&& jumped) noexcept {
    samples_->set_time(to, from);
    furthest_carried_m_ = 0.0;
    for (std::size_t m = 0; m < modes_.size(); ++m) {
      Part& part = parts_[m];
      ContactFade& fade = live_[m].fade;
      if (!enabled(m)) continue;
      const Vec3 at_m = carried_at(m, start_m);
      const Carried carried = samples_->carried(part.inputs.main_field, at_m, from, to);
      const bool is_known = carried.known && samples_->carried(part.inputs.main_field, at_m, from, tick_end).known;
      if (fade.advance(is_known, time_step_s)) modes_[m].mode.start(memory(m));
      if (!is_known && !fade.is_leaving() && fade.begin_fade_out(*samples_)) jumped(m);
      part.carried_m = is_known && !fade.is_leaving() ? carried.position_m - at_m : Vec3{};
      furthest_carried_m_ = std::max(furthest_carried_m_, norm(part.carried_m));
    }
  }
  /// Begins a step at `start_m` [m], the origin of all resistance to motion, carried along by the data. The moves that settle
  /// the step start elsewhere but keep this origin.
  void begin_step(const Vec3& start_m) noexcept {
    for (std::size_t m = 0; m < size(); ++m) live_[m].origin_m = start_m + parts_[m].carried_m;
  }
  /// Origin of a mode's step [m], carried along.
  const Vec3& origin_m(std::size_t m) const noexcept { return live_[m].origin_m; }
  /// Ends the sub-step: resets the carried motion to zero.
  void arrive() noexcept;
  /// Motion of the proxy with a mode's data in this sub-step [m], and the longest of all modes [m].
  const Vec3& carried_m(std::size_t m) const noexcept { return parts_[m].carried_m; }
  double furthest_carried_m() const noexcept { return furthest_carried_m_; }
  const ContactTable& contacts() const noexcept { return contacts_; }
  /// Whether a mode's strengths are reduced because its level has jumped.
  bool fades(std::size_t m) const noexcept { return live_[m].fade.share() < 1.0; }
  /// Whether yielding of this mode's level is no break-through: the level has jumped, or data end nearby.
  bool only_yields(std::size_t m) const noexcept { return fades(m) || live_[m].at_edge; }
  /// Longest motion [m] with any mode's data of the position `at_m` [m] between two times.
  double motion_m(const Vec3& at_m, DataTime from, DataTime to) const noexcept;
  /// Adds the data's motion since the sub-step's start `start_m` [m], and jumped levels, to an event search.
  void configure_events(Crossings& crossings, EventPolicy& policy, const Vec3& start_m) noexcept;

  /// Lets every enabled mode place its primitives in the emptied set. A mode samples its data at `at_m` [m], or at `level_m`
  /// [m] if one of its planes stands on a level.
  void place(const StepContext& context, const Vec3& at_m, const Vec3& level_m, PrimitiveSet& out) noexcept;
  /// Reports a sub-step that ended with the proxy at `proxy_m` [m], and its contacts, to the modes.
  void on_step_accepted(const StepContext& context, const Vec3& proxy_m, const PrimitiveSet& placed,
                        std::span<const Crossing> crossings) noexcept;

  /// Free flight: whether all forces stay zero from a step's start until a watched value is crossed or the data of a field in
  /// `entered` begin.
  bool is_free_at(const StepContext& context, std::vector<std::int32_t>& entered) noexcept;

  /// Finest sample spacing of any enabled mode's data [hand m]; infinity without any.
  double finest_m() const noexcept { return finest_m_; }
  /// Finest spacing at `at_m` [hand m] of the modes whose data the path from `from_m` to `to_m` can meet, or infinity.
  double finest_m(const Vec3& at_m, const Vec3& from_m, const Vec3& to_m) const noexcept;

 private:
  // Inputs of a mode, and values cached for it.
  struct Part {
    ModeInputs inputs;
    Box box_m;                                                  // world box of all of its inputs' data
    double finest_m = std::numeric_limits<double>::infinity();  // [hand m] their finest sample spacing, anywhere
    std::size_t memory = 0;                                     // offset in the memories
    bool has_memory = false;
    Vec3 carried_m;
  };
  struct Live {
    Vec3 origin_m;  // of the step
    ContactFade fade;
    bool stands = false;   // on a level, in its last placement
    bool at_edge = false;  // strengths were reduced because data end
  };
  using MemoryUnit = std::max_align_t;

  std::byte* memory(std::size_t m) noexcept { return reinterpret_cast<std::byte*>(memories_.data() + parts_[m].memory); }
  ModeContext here_at(std::size_t m, const StepContext& context, const Vec3& start_m, const Vec3& at_m) noexcept;
  void place_mode(std::size_t m, const StepContext& context, const Vec3& origin_m, const Vec3& at_m,
                  PrimitiveSet& out) noexcept;
  // Position carried by a mode's data: the foot of a proxy at `at_m`, or the proxy.
  Vec3 carried_at(std::size_t m, const Vec3& at_m) const noexcept {
    for (const Contact& contact : contacts_.of(m)) {
      if (contact.offset_m != Vec3{}) return at_m + contact.offset_m;
    }
    return at_m;
  }
  // Sample position of a mode, at the end of the sub-step, for a point carried to `at_m`.
  Vec3 seen_by(std::size_t m, const Vec3& at_m, double data_fraction) const noexcept {
    return at_m + (1.0 - data_fraction) * parts_[m].carried_m;
  }
  bool is_level(const HeldLevel& at) const noexcept { return std::ranges::count(watches_, Threshold{at.field, at.value}) > 0; }
  bool silence_is_watched(std::size_t m, const Vec3& at_m, std::vector<std::int32_t>& entered) noexcept;

  Similarity map_;
  std::vector<FieldPtr> fields_;
  std::unique_ptr<Samples> samples_;
  std::vector<SceneMode> modes_;  // with resolved references
  std::vector<Part> parts_;       // by mode
  std::span<Live> live_;          // by mode
  const ContactTable& contacts_;
  double& most_n_;  // force limit
  std::span<MemoryUnit> memories_;
  std::vector<Threshold> watches_;
  PrimitiveSet scratch_;
  double finest_m_ = 0.0, furthest_carried_m_ = 0.0;
};

}  // namespace palpa
