// Path of the proxy through the data between probe positions.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "palpa/mode/crossings.h"
#include "palpa/mode/tick_work.h"
#include "palpa/session/contact_problem.h"
#include "palpa/session/contact_table.h"
#include "palpa/session/data_moments.h"
#include "palpa/session/mode_runtime.h"
#include "palpa/session/probe_queue.h"
#include "palpa/session/session.h"
#include "palpa/session/step_record.h"
#include "palpa/solver/state_arena.h"

namespace palpa {

/// Refinement of the proxy's path in a tick.
enum class Steps : std::uint8_t {
  refined,       ///< in sub-steps as short as the data need (docs/path.md)
  one_at_proxy,  ///< in one step, straight to the balance, data sampled at the proxy
  one_at_probe,  ///< likewise, data sampled at the probe
};

/// Result of one tick's walk.
struct Walk {
  Pose from, proxy;          ///< [m] proxy before and after it
  Pose followed;             ///< [m] pose of the probe's path up to which the proxy has followed it
  Motion released_m;         ///< [m] part of the proxy's motion that was a release
  bool is_complete = true;   ///< false: a cap was reached, part of the probe's path stays queued
  double unreached_m = 0.0;  ///< [m] from the proxy to the last balance; at rest below the tolerances of the path
  int dropped = 0;           ///< primitives refused
  int work = 0;              ///< [1] units (tick_work.h)
};

/// Walks the proxy after the probe. A tick of the paper is one step of incremental minimisation of a continuous,
/// rate-independent law; here the step is refined until the path is that of the law, as described in docs/path.md, section 2.
/// Caps on sub-steps and work bound a tick; the rest of the probe's path stays queued. Construction allocates and throws
/// SceneError; walking does neither. One thread.
class ProxyPath {
 public:
  /// Uses the scene's law, which must exist. \param live  keeps the state of the walk
  ProxyPath(StateArena& live, const Scene& scene, const Similarity& map, std::unique_ptr<Law> law, Steps steps);

  /// Clears the state; the next walk begins at its probe.
  void reset() noexcept;
  /// Sets the pose of a proxy that is not walked [m].
  void put(const Pose& proxy) noexcept { state_.proxy = proxy; }
  /// Windows of volumes larger than memory.
  Stock& stock() noexcept { return moments_.stock(); }
  const FeltOctave& felt_octave() const noexcept { return moments_.felt_octave(); }
  WindowNeed window_need(const Pose& probe, bool valid, double time_step_s) noexcept;
  /// See Session.
  void set_force_limit(double most_n) noexcept { modes_.set_force_limit(most_n); }
  void refine(int times);
  /// Continues after the StateArena was copied from another session.
  void after_state_copy(const ProxyPath& other) noexcept;
  /// Whether another path has equal modes on equal levels.
  bool has_same_contacts_as(const ProxyPath& other) const noexcept { return modes_.has_same_contacts_as(other.modes_); }
  /// Starts with the proxy at another path's proxy, at that path's time.
  void start_at_proxy_of(const ProxyPath& other) noexcept;

  /// Advances the data's time by `time_step_s` [s], walking or not.
  void advance_clock(double time_step_s) noexcept { moments_.advance_clock(time_step_s); }
  /// Starts with the proxy on the probe at `probe` [m], `time_step_s` [s] ago.
  void start(const Pose& probe, double time_step_s) noexcept;
  /// Walks to the next probe pose [m], `time_step_s` [s] later, as far as the caps allow. Requires `start`.
  const Walk& walk(const Pose& probe, double time_step_s) noexcept;

  const Tool& tool() const noexcept { return tool_; }
  const Pose& proxy() const noexcept { return state_.proxy; }
  bool started() const noexcept { return state_.started; }
  /// End of the processed part of the probe's path [m].
  const Pose& processed_up_to() const noexcept { return queue_.processed_up_to(); }
  /// Contacts with the primitives of the last sub-step.
  std::span<const Contact> contacts() const noexcept { return contacts_.all(); }
  void warn(const char* sentence) noexcept { contacts_.warn(sentence); }
  std::span<const SubStep> sub_steps() const noexcept { return record_.sub_steps(); }
  std::span<const PlacedPrimitive> placed() const noexcept { return record_.placed(); }
  std::span<const SessionEvent> events() const noexcept { return contacts_.events(); }

 private:
  void go_with_probe() noexcept;
  void sub_step(ProbeSegment& segment) noexcept;
  void one_step(const ProbeSegment& segment) noexcept;

  // Pending work at a probe position: the rest of a stopped move, or the check for rest.
  enum class Pending : std::uint8_t { nothing, path, settling };

  // State that the next sub-step depends on.
  struct PathState {
    bool started = false;
    Pose proxy;
    Motion move_m;                        // last move of the proxy
    bool felt = false;                    // a force was possible in the last move
    Pose segment_start;                   // proxy before the last segment
    Motion probe_way_m;                   // of the last segment
    Motion extrapolated_m;                // sum of the expected moves: on an elastic level they shrink in a constant ratio
    int moves_without_extrapolation = 0;  // consecutive moves without it
    Pending pending = Pending::nothing;
    Pose step_start;                     // of the moves that settle a step
    double max_move_m = 0.0;             // bound on this segment's moves; less after each turn back
    int turns = 0;                       // of this segment: turned back, or without end
    bool is_held_back = false;           // its way in a tick was limited, and it went that far
    double left_s = 0.0, whole_s = 0.0;  // of the segment: pending and whole time
    Pose followed;                       // pose of the probe's path that the proxy has followed to
  };

  // Result of one move.
  struct Move {
    double fraction = 1.0;  // of the path to the balance, the last one of the problem
    Stop stop = Stop::full;
    double change_m = 0.0;   // of its end, in the last iteration
    bool bound_met = false;  // a shell breaks beyond its end
    Pose to_pose;            // of the balance
  };

  void find_changes() noexcept;
  bool next_segment(ProbeSegment& segment) noexcept;
  bool is_free() noexcept;
  double time_at_end_of(const ProbeSegment& segment) const noexcept {
    return moments_.elapsed_s() - queue_.time_behind_s(segment);
  }
  DataMoments::Step advance_data(const ProbeSegment& segment) noexcept;
  void log(const ProbeSegment& segment, const Move& made, const StepContext& context, bool settles) noexcept;
  void accept(const ProbeSegment& segment, const Move& made, const StepContext& context, bool settles) noexcept;
  Move move(ProbeSegment& segment, StepContext& context, bool settles) noexcept;
  Move move_freely(const StepContext& context, bool flies, double longest_m) noexcept;
  Pose stop_at_first_event(const Pose& start, bool flies, Move& move) noexcept;
  void find_events(const Pose& start, const Pose& end, bool flies) noexcept;
  bool reverses_last_crossing(std::size_t foot, const Vec3& start_m, const Vec3& end_m) const noexcept;
  const Event& first_event() const noexcept { return events_[first_foot_]; }
  [[gnu::always_inline]] Pose end_from(const Pose& start, const Move& move) const noexcept {
    Pose end = move.to_pose;
    if (move.fraction < 1.0) end = tool_.moved(start, move.fraction * tool_.motion(start, move.to_pose));
    return end;
  }
  double longest_flight_m() noexcept;
  // Share [1] of a motion, `way_m` long, up to the way `longest_m` of any foot, and up to a turn.
  double share_of(const Motion& motion, double way_m, double longest_m) const noexcept {
    const double share = way_m > longest_m ? longest_m / way_m : 1.0;
    return tool_.is_point() ? share : std::min(share, share_of_turn(motion));
  }
  double share_of_turn(const Motion& motion) const noexcept;
  void balance(Move& move, const Pose& probe, double time_step_s) noexcept;
  void place(const StepContext& context, const Pose& end, const Pose& whole_end) noexcept;
  bool end_is_free(const ProbeSegment& segment, const StepContext& context, bool flies, Move& move) noexcept;
  void advance(const ProbeSegment& segment, const Move& move, const Pose& end, const DataMoments::Step& follows,
               bool settled) noexcept;
  bool may_give_up() const noexcept;
  void give_up() noexcept;
  void leave_rest() noexcept;
  Pending pending_after(const Move& move, bool settled) const noexcept;
  void extrapolate_moves(const Motion& before_m, bool fresh) noexcept;
  Motion expected_m(const ProbeSegment& segment) const noexcept;
  bool locate_break_through(ProbeSegment& segment, const StepContext& context, Move& move) noexcept;
  void configure_events(std::size_t foot, const Pose& end, bool flies) noexcept;

  WorkBudget work_;  // of this tick
  double stiffness_n_per_m_;
  bool changes_ = false;    // the data change in this tick
  double allowed_m_ = 0.0;  // left of the way that the proxy may go in this tick
  Tool tool_;
  ContactTable contacts_;
  ModeRuntime modes_;
  Crossings crossings_;
  EventPolicy policy_;          // of one foot
  std::vector<Event> events_;   // by foot
  std::size_t first_foot_ = 0;  // whose event comes first
  DataMoments moments_;
  ContactProblem model_;
  PathState& state_;
  std::span<Crossing> stopped_by_;  // by foot, on the spot: without a field if it crossed nothing
  ProbeQueue& queue_;
  Steps steps_;
  bool goes_with_probe_;  // no mode is enabled
  double step_share_;     // [1] of the finest spacing: the longest segment and move, before refining
  int refined_ = 1;
  int patient_trials_ = 1;                 // of a move, however little work is left
  int spared_work_ = 0;                    // no move begins with less left
  double path_m_ = 0.0;                    // motion of probe or data, the longer one
  double moved_n_ = 0.0;                   // allowed change of directed forces for moving data
  double spacing_m_ = 0.0, step_m_ = 0.0;  // finest near this sub-step, and its longest move
  Walk walk_;                              // of this tick
  ProbeSegment segment_;                   // the next
  std::vector<std::int32_t> entered_;
  StepRecord record_;
};

}  // namespace palpa
