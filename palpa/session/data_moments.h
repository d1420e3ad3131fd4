// Moments of the data along the proxy's path: their time, and the felt octave of volumes larger than memory.
#pragma once

#include <span>
#include <vector>

#include "palpa/data/octaves.h"
#include "palpa/scene/scene.h"
#include "palpa/session/felt_octave.h"
#include "palpa/session/mode_runtime.h"
#include "palpa/session/session.h"
#include "palpa/solver/state_arena.h"
#include "palpa/solver/tool.h"

namespace palpa {

/// Times and felt octave at which a session samples its data, up to which its proxy has followed them, and the windows that
/// allow that octave. Poses of the proxy and lengths are in metres of the hand, octaves in [1]. Construction allocates; nothing
/// else does. One thread.
class DataMoments {
 public:
  /// \param live   keeps the moments
  /// \param modes  of the session, with their fields; outlive this
  /// \param tool   outlives this
  DataMoments(StateArena& live, const TimeOptions& time, ModeRuntime& modes, const Tool& tool);

  /// Whether the data can change from tick to tick.
  bool can_change() const noexcept { return can_change_; }
  Stock& stock() noexcept { return stock_; }
  const FeltOctave& felt_octave() const noexcept { return felt_octave_; }

  double elapsed_s() const noexcept { return state_.elapsed_s; }  ///< [s] since the session began
  double view_s() const noexcept { return state_.view_s; }        ///< [s] of the samples
  /// Moment at the felt octave, `elapsed_s` [s] after the session began.
  DataTime at(double elapsed_s) const noexcept { return at(elapsed_s, felt_octave_.octave()); }
  DataTime now() const noexcept { return at(state_.elapsed_s); }
  /// Moment of the samples.
  DataTime view() const noexcept { return at(state_.view_s, state_.view_octave); }
  /// Whether octaves fade: samples or proxy are not yet at the felt octave, or a mode whose level jumped fades.
  bool octaves_fade() const noexcept;
  /// Way [m] that the proxy may go in `time_s` [s] while octaves fade, the hand moves by `hand_m` and the data by `data_m` [m].
  /// A level that is lost, or slides out from under the proxy, is a step of the data and none of the hand: the proxy leaves it
  /// in many ticks.
  static double fading_way_m(double hand_m, double data_m, double time_s, double stiffness_n_per_m) noexcept;
  /// Moment up to which the proxy has followed the data.
  DataTime followed() const noexcept { return at(state_.followed_s, state_.followed_octave); }

  /// Part of a sub-step that the data change in.
  struct Step {
    double passed_s = 0.0;       ///< [s] since the last sub-step
    double behind_s = 0.0;       ///< [s] between what the proxy has followed and the samples
    double behind_octave = 0.0;  ///< [1] likewise
  };

  /// Forgets octaves and motion; times go on.
  void reset() noexcept;
  /// Continues from a session of an equal scene whose state was copied.
  void take_windows_of(const DataMoments& other) noexcept { stock_.take_windows_of(other.stock_); }
  /// Continues from a session of another scene.
  void resume(const DataMoments& other) noexcept;

  void advance_clock(double time_step_s) noexcept { state_.elapsed_s += time_step_s; }
  /// Begins `time_step_s` [s] ago with the proxy at a pose. \param way_m  [m] longest way of a foot in the tick
  void start(const Pose& proxy, double way_m, double time_step_s) noexcept;
  /// Chooses windows and felt octave of a tick, if there are any.
  /// \param way_m        [m] longest way of a foot in the tick
  /// \param time_step_s  [s] since the last tick
  void choose_octave(const Pose& proxy, double way_m, double time_step_s) noexcept;
  /// Advances the samples to a time [s], never back, and to the felt octave.
  Step advance_view(double to_s) noexcept;
  /// The proxy has followed the data up to the samples.
  void follow() noexcept { follow({}, 0.0); }
  /// Likewise but for a part of a step. \param share_behind  [1]
  void follow(const Step& step, double share_behind) noexcept;
  /// In a tick without change: samples and proxy are at the tick's end.
  void stand_still() noexcept { state_.view_s = state_.followed_s = state_.elapsed_s; }

  /// Way [m] of any foot within the windows that are sampled, less the voxels of a sample; infinite without windows.
  double reach_m(const Pose& proxy) noexcept;
  /// Likewise on the straight way to a pose; at least that.
  double reach_m(const Pose& proxy, const Pose& to) noexcept;
  /// Windows needed by the tick in `time_step_s` [s] that begins at a pose, towards a probe, and moves a foot by `way_m` [m].
  /// Valid until the next.
  WindowNeed need(const Pose& start, const Pose& probe, double way_m, double time_step_s) noexcept;

 private:
  struct State {
    double elapsed_s = 0.0;
    double view_s = 0.0, followed_s = 0.0;
    double view_octave = 0.0, followed_octave = 0.0;
  };
  DataTime at(double elapsed_s, double octave) const noexcept;
  const Similarity& map() noexcept { return modes_.samples(0).hand_to_world(); }
  std::span<const Vec3> feet_in_world(const Pose& pose) noexcept { return feet_in_world(pose, feet_in_world_); }
  std::span<const Vec3> feet_in_world(const Pose& pose, std::vector<Vec3>& feet_m) noexcept;
  int sampled_octave(std::size_t field, std::span<const Vec3> feet_m) const noexcept;

  TimeOptions time_;
  ModeRuntime& modes_;
  const Tool& tool_;
  Stock stock_;
  FeltOctave& felt_octave_;
  State& state_;
  double end_s_;                                  // of the data, if they play once
  bool can_change_;                               // from tick to tick
  std::vector<Vec3> feet_in_world_, feet_ahead_;  // [m, world]
  bool is_ahead_known_ = false;                   // feet_ahead_ are of the `need` of the tick that begins
};

}  // namespace palpa
