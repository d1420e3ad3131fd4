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
#include "palpa/scene/mode_inputs.h"
#include "palpa/session/contact_fade.h"
#include "palpa/session/contact_table.h"
#include "palpa/session/sub_step.h"
#include "palpa/solver/state_arena.h"
#include "palpa/solver/tool.h"

namespace palpa {

/// Modes of a session at each foot of the tool, with their fields, samples, and memories, kept in a StateArena. A mode at a
/// foot works in ignorance of the other feet. Construction allocates and throws SceneError; nothing else does. One thread.
class ModeRuntime {
 public:
  /// \param map       hand to world
  /// \param tool      outlives this
  /// \param contacts  of the session; outlive this
  ModeRuntime(StateArena& live, const Scene& scene, const Similarity& map, const Tool& tool, const ContactTable& contacts);
  ModeRuntime(const ModeRuntime&) = delete;
  ModeRuntime& operator=(const ModeRuntime&) = delete;

  std::size_t size() const noexcept { return size_; }
  std::size_t fields() const noexcept { return fields_.size(); }
  bool enabled(std::size_t m) const noexcept { return modes_[m].enabled; }
  bool any_enabled() const noexcept { return std::ranges::any_of(modes_, &SceneMode::enabled); }
  /// Whether a mode is enabled and acts at a foot.
  bool acts(std::size_t m, std::size_t foot) const noexcept { return enabled(m) && (foot == 0 || parts_[m].at_all_feet); }
  bool has_memory(std::size_t m) const noexcept { return parts_[m].has_memory; }
  const Tool& tool() const noexcept { return tool_; }
  /// Samples of a foot.
  Samples& samples(std::size_t foot) noexcept { return *samples_[foot]; }
  /// Sets the data's time.
  void set_time(DataTime at) noexcept { set_time(at, at); }
  /// Whether any field changes with time.
  bool any_timed() const noexcept { return samples_[0]->any_timed(); }
  const std::vector<FieldPtr>& all_fields() const noexcept { return fields_; }
  /// End of the longest field that changes with time and plays once [s]; 0 without any.
  double data_end_s() const noexcept;
  /// Work of all modes at all feet [units of tick_work.h].
  int work() const noexcept { return static_cast<int>(tool_.feet()) * samples_[0]->work_of_modes(size_); }
  /// Work of the last placement: of a point that of all modes; of a tool that of the modes at feet that placed primitives, and
  /// of all modes once.
  int work_of(const PrimitiveSet& placed) const noexcept { return tool_.is_point() ? work() : body_work_of(placed); }
  /// Thresholds of strengths, masks and levels of all enabled modes.
  const std::vector<Threshold>& watches() const noexcept { return watches_; }

  /// Whether `other` has equal modes on equal levels and fields, whatever their strengths.
  bool has_same_contacts_as(const ModeRuntime& other) const noexcept;

  /// See Session.
  void set_force_limit(double most_n) noexcept { most_n_ = most_n; }

  void start() noexcept;

  /// Advances the data from `from` to `to`, `time_step_s` [s] later. Their motion carries the feet of the proxy at `start`
  /// [m], or a footing on an elastic level, deep inside which the motion may be undefined. A mode whose level jumps before
  /// `tick_end` fades instead (ContactFade); `jumped(m)` is called when a fade begins.
  template <class Jumped>
  void advance(const Pose& start, DataTime from, DataTime to, DataTime tick_end, double time_step_s, Jumped&& jumped) noexcept {
    set_time(to, from);
    furthest_carried_m_ = 0.0;
    for_each_part([&](std::size_t m, std::size_t foot) {
      if (!acts(m, foot)) return;
      const std::int32_t field = parts_[m].inputs.main_field;
      Live& live = live_[part_of(m, foot)];
      const Vec3 at_m = carried_at(m, foot, tool_.foot_m(start, foot));
      const Carried carried = samples(foot).carried(field, at_m, from, to);
      const bool is_known = carried.known && (tick_end == to || samples(foot).carried(field, at_m, from, tick_end).known);
      if (live.fade.advance(is_known, time_step_s)) modes_[m].mode.start(memory(m, foot));
      if (!is_known && !live.fade.is_leaving() && live.fade.begin_fade_out(samples(foot))) jumped(m);
      live.carried_m = is_known && !live.fade.is_leaving() ? carried.position_m - at_m : Vec3{};
      furthest_carried_m_ = std::max(furthest_carried_m_, norm(live.carried_m));
    });
  }
  /// Begins a step of the proxy at `start` [m]: the feet there, carried along by the data, are the origins of all resistance
  /// to motion. The moves that settle the step start elsewhere but keep these origins.
  void begin_step(const Pose& start) noexcept {
    for (std::size_t foot = 0; foot < tool_.feet(); ++foot) {
      const Vec3 foot_m = tool_.foot_m(start, foot);
      for (Live& live : live_.subspan(part_of(0, foot), size_)) live.origin_m = foot_m + live.carried_m;
    }
  }
  // Of a primitive's mode and foot:
  /// Origin of the step [m], carried along.
  const Vec3& origin_m(const PrimitiveId& id) const noexcept { return live_at(id).origin_m; }
  /// Ends the sub-step: resets the carried motion to zero.
  void arrive() noexcept;
  /// Motion with the data in this sub-step [m]; and the longest of all [m].
  const Vec3& carried_m(const PrimitiveId& id) const noexcept { return live_at(id).carried_m; }
  double furthest_carried_m() const noexcept { return furthest_carried_m_; }
  const ContactTable& contacts() const noexcept { return contacts_; }
  /// Whether strengths are reduced because the level has jumped.
  bool fades(const PrimitiveId& id) const noexcept { return live_at(id).fade.share() < 1.0; }
  /// Whether any mode fades because a level has jumped.
  bool any_fades() const noexcept {
    return std::ranges::any_of(live_, [](const Live& live) { return live.fade.is_under_way(); });
  }
  /// Whether yielding of the level is no break-through: the level has jumped, or data end nearby.
  bool only_yields(const PrimitiveId& id) const noexcept { return fades(id) || live_at(id).at_edge; }
  /// Longest motion [m] of a foot with any mode's data between two times, for the proxy at `proxy` [m].
  double motion_m(const Pose& proxy, DataTime from, DataTime to) noexcept;
  /// Adds the data's motion since the start of the sub-step, with the foot at `start_m` [m], and jumped levels, to the event
  /// search of a foot.
  void configure_events(std::size_t foot, Crossings& crossings, EventPolicy& policy, const Vec3& start_m) noexcept;

  /// Lets every enabled mode place its primitives for each foot in the emptied set. A mode samples its data with the proxy at
  /// `at` [m], after the share `data_fraction` [1] of the data's motion in the sub-step; or, if one of its planes stands on a
  /// level, at `level` [m], with the data carried along.
  void place(const StepContext& context, const Pose& at, const Pose& level, double data_fraction, PrimitiveSet& out) noexcept;
  /// Reports a sub-step that ended with the proxy at `proxy` [m], after the share `data_fraction` [1] of the data's motion,
  /// its contacts, and the event of each foot, to the modes.
  void on_step_accepted(const StepContext& context, const Pose& proxy, double data_fraction, const PrimitiveSet& placed,
                        std::span<const Event> events) noexcept;

  /// Free flight: whether all forces stay zero from a step's start until a watched value is crossed or the data of a field in
  /// `entered` begin.
  bool is_free_at(const StepContext& context, std::vector<std::int32_t>& entered) noexcept;

  /// Finest sample spacing of any enabled mode's data [hand m]; infinity without any.
  double finest_m() const noexcept { return finest_m_; }
  /// Finest spacing at a foot of the proxy at `at` [hand m] of the modes whose data the foot's path, with the proxy from
  /// `from` to `to`, can meet, or infinity.
  double finest_m(const Pose& at, const Pose& from, const Pose& to) const noexcept;

 private:
  // Inputs of a mode, and values cached for it.
  struct Part {
    ModeInputs inputs;
    std::span<const Mask> masks;                                // of the mode
    Box box_m;                                                  // world box of all of its inputs' data
    double finest_m = std::numeric_limits<double>::infinity();  // [hand m] their finest sample spacing, anywhere
    std::size_t memory = 0;                                     // offset in the memories
    bool has_memory = false;
    bool at_all_feet = true;
  };
  // State of a mode at a foot.
  struct Live {
    Vec3 origin_m;   // of the step
    Vec3 carried_m;  // in this sub-step
    ContactFade fade;
    bool stands = false;   // on a level, in its last placement
    bool at_edge = false;  // strengths were reduced because data end
  };
  using MemoryUnit = std::max_align_t;

  int body_work_of(const PrimitiveSet& placed) const noexcept;
  std::size_t part_of(std::size_t m, std::size_t foot) const noexcept { return foot * size_ + m; }
  const Live& live_at(const PrimitiveId& id) const noexcept { return live_[part_of(id.mode, id.foot)]; }
  // Calls `visit(m, foot)` for each mode at each foot.
  template <class Visit>
  void for_each_part(Visit&& visit) const {
    for (std::size_t foot = 0; foot < tool_.feet(); ++foot) {
      for (std::size_t m = 0; m < size_; ++m) visit(m, foot);
    }
  }
  std::byte* memory(std::size_t m, std::size_t foot) noexcept {
    return reinterpret_cast<std::byte*>(memories_.data() + foot * memory_units_ + parts_[m].memory);
  }
  void set_time(DataTime at, DataTime came_from) noexcept {
    motion_.furthest_m = -1.0;
    for (const auto& of_foot : samples_) of_foot->set_time(at, came_from);
  }
  // A foot in a sub-step.
  struct Foot {
    std::size_t number;
    Vec3 probe_m;
  };
  Foot foot_of(std::size_t foot, const StepContext& context) const noexcept {
    return {foot, tool_.foot_m(context.probe, foot)};
  }
  ModeContext here_at(std::size_t m, const Foot& foot, const StepContext& context, const Vec3& start_m,
                      const Vec3& at_m) noexcept;
  static constexpr double carried_along = 0.0;  // `data_fraction` of a contact: the data as carried along with it
  void place_mode(std::size_t m, const Foot& foot, const StepContext& context, const Vec3& origin_m, const Vec3& at_m,
                  double data_fraction, PrimitiveSet& out) noexcept;
  // Position carried by a mode's data: the footing of a foot at `at_m`, or the foot.
  Vec3 carried_at(std::size_t m, std::size_t foot, const Vec3& at_m) const noexcept {
    for (const Contact& contact : contacts_.of(m, foot)) {
      if (contact.offset_m != Vec3{}) return at_m + contact.offset_m;
    }
    return at_m;
  }
  // Sample position of a mode, at the end of the sub-step, for a point carried to `at_m`.
  Vec3 seen_by(std::size_t m, std::size_t foot, const Vec3& at_m, double data_fraction) const noexcept {
    return at_m + (1.0 - data_fraction) * live_[part_of(m, foot)].carried_m;
  }
  bool is_level(const HeldLevel& at) const noexcept { return std::ranges::count(watches_, Threshold{at.field, at.value}) > 0; }
  bool silence_is_watched(std::size_t m, std::size_t foot, const Vec3& at_m, std::vector<std::int32_t>& entered) noexcept;

  Similarity map_;
  const Tool& tool_;
  std::vector<FieldPtr> fields_;
  std::vector<std::unique_ptr<Samples>> samples_;  // by foot: each keeps its own positions
  std::vector<SceneMode> modes_;                   // with resolved references
  std::size_t size_;                               // of them, used a hundred times in a tick
  std::vector<Part> parts_;                        // by mode
  std::span<Live> live_;                           // by foot, then mode
  const ContactTable& contacts_;
  double& most_n_;                  // force limit
  std::span<MemoryUnit> memories_;  // by foot, then mode
  std::size_t memory_units_ = 0;    // of a foot
  std::vector<Threshold> watches_;
  PrimitiveSet scratch_;
  double finest_m_ = 0.0, furthest_carried_m_ = 0.0;
  // The last result of motion_m: a tick of one segment needs it twice.
  struct {
    Pose proxy;
    DataTime from, to;
    double furthest_m = -1.0;  // none
  } motion_;
};

}  // namespace palpa
