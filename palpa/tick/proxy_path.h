// The proxy's path through the data: from one probe position to the next.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "palpa/core/law.h"
#include "palpa/core/ledger.h"
#include "palpa/tick/contact_events.h"
#include "palpa/tick/felt_modes.h"
#include "palpa/tick/held_forces.h"
#include "palpa/tick/joint_balance.h"
#include "palpa/tick/session.h"
#include "palpa/tick/watch.h"

namespace palpa {

/// Walks the proxy after the probe. One tick of the paper is one step of incremental minimisation of a continuous,
/// rate-independent law (docs/path.md); here the step is refined until the path is that of the law:
///
/// - the probe's path is cut into pieces of at most half the finest sample spacing of the data that it can meet, and no
///   move of the proxy is longer; where nothing is felt and nothing can set in, it goes all the way;
/// - directions are those at the middle of a move;
/// - a move stops where a level is met, a strength sets in or data begin (Watches), and the probe's piece
///   where a level gives way;
/// - planes of a concave place are kept in one balance (KeptPlanes);
/// - a move after which the spring, put back on the level that holds it, has more energy is halved;
/// - at the end the proxy is settled: one more sub-step would not move it;
/// - of data that change with time a sub-step sees the moment of its end, and each mode's primitives start where its data
///   have carried the proxy; where a level jumps instead, the mode lets go of it in 50 ms and takes hold again.
///
/// The cap on sub-steps bounds a tick; what is left of the probe's path waits in a queue.
/// Construction allocates and throws SceneError; walking does neither. One thread.
class ProxyPath {
 public:
  ProxyPath(const Scene& scene, const Similarity& map, std::unique_ptr<Law> law);

  /// Forgets everything; the next walk begins at its probe.
  void reset() noexcept;
  /// Where the proxy is while it is not walked [m].
  void put(const Vec3& proxy_m) noexcept { course_.proxy = proxy_m; }
  /// See Session.
  void refine(int times);
  void continue_from(const ProxyPath& other) noexcept;

  /// The data's time goes on by so much [s], whether the proxy is walked or not.
  void pass(double time_step_s) noexcept { course_.elapsed_s += time_step_s; }
  /// Goes on to the next probe position [m], `time_step_s` later. False where the cap was reached.
  bool walk(const Vec3& probe_m, double time_step_s, Ledger& ledger) noexcept;

  const Vec3& proxy_m() const noexcept { return course_.proxy; }
  bool started() const noexcept { return course_.started; }
  /// Of the last walk: the part of the proxy's motion that was a release [m], and primitives refused.
  const Vec3& released_m() const noexcept { return released_m_; }
  int dropped() const noexcept { return dropped_; }

  std::span<const SubStep> sub_steps() const noexcept { return sub_steps_; }
  std::span<const PlacedPrimitive> placed() const noexcept { return placed_; }
  std::span<const SessionEvent> events() const noexcept { return events_.events(); }
  static constexpr std::size_t max_primitives = JointBalance::max_primitives;

 private:
  static constexpr std::size_t max_queued = 64;

  // A piece of the probe's path that still has to be walked, up to this position.
  struct Waypoint {
    Vec3 position_m;
    double time_s = 0.0;
  };
  // Where the session is on its way.
  struct Course {
    bool started = false;
    Vec3 proxy;
    Vec3 walked;       // how far the probe's path has been followed
    Vec3 move_m;       // of the proxy in the last sub-step …
    Vec3 probe_way_m;  // … and of the probe
    std::array<Waypoint, max_queued> queue;
    std::size_t queued = 0;
    // A sub-step that was stopped on its way is taken up again at the same probe.
    bool unfinished = false;
    bool settling = false;    // it has ended; whether the proxy rests there is being asked
    double left_s = 0.0;      // of its time
    double whole_s = 0.0;     // its time before it was stopped
    double elapsed_s = 0.0;   // since the session began
    double view_s = 0.0;      // the data are seen as they were then …
    double followed_s = 0.0;  // … and have carried the proxy up to then
  };
  struct Piece {
    Vec3 from_m;  // the probe's path …
    Vec3 to_m;
    double time_s = 0.0;
    bool fresh = true;  // no repeat at the same probe
  };

  // What becomes of a sub-step.
  struct Move {
    Balance to;
    double fraction = 1.0;  // of the way there
    Stop stop = Stop::full;
    double change_m = 0.0;   // by how much the last look moved its end
    bool bound_met = false;  // a shell gives way beyond
    Vec3 end_from(const Vec3& start_m) const noexcept {
      return fraction < 1.0 ? start_m + fraction * (to.position_m - start_m) : to.position_m;
    }
  };

  bool next_piece(Piece& piece) noexcept;
  double time_at_end_of(const Piece& piece) const noexcept;
  double see(const Piece& piece, const Vec3& start_m) noexcept;
  void sub_step(Piece piece, Ledger& ledger) noexcept;
  Move step(Piece& piece, Situation& situation) noexcept;
  Move leap(const Piece& piece, Situation& situation) noexcept;
  void limit(const Piece& piece, const Situation& situation, double longest, Move& move) noexcept;
  void go_on(const Piece& piece, const Move& move, double follows_s, bool settled) noexcept;
  Balance look(const Situation& situation, const Vec3& at_m, const Vec3& end_m) noexcept;
  Vec3 expected_m(const Piece& piece) const noexcept;
  double approach(const Situation& situation, const Vec3& expected_m, double longest, Balance& to) noexcept;
  bool is_other_sheet(const Vec3& start_m) const noexcept;
  bool a_shell_yields() const noexcept;
  void press_through() noexcept;
  bool meet_bound(Piece& piece, const Situation& situation, Balance& to) noexcept;
  void attend_levels(const Balance& to) noexcept;
  void record(SubStep step, Ledger& ledger) noexcept;
  bool silent_at(const Vec3& at_m) noexcept;
  double step_m(const Vec3& from_m, const Vec3& to_m) noexcept;

  double stiffness_n_per_m_;
  TimeOptions time_;
  bool playing_ = false;  // the data's time goes on
  bool in_steps_;
  bool at_probe_;
  FeltModes modes_;
  Watches watches_;
  JointBalance joint_;
  HeldForces held_;
  ContactEvents events_;
  Course course_;
  int refined_ = 1;
  double path_m_ = 0.0;           // length of the probe's path in this tick, or of the data's
  double moved_n_ = 0.0;          // by which directed forces may change in this sub-step because the data do
  double spacing_m_ = 0.0;        // finest, of the data near this sub-step
  bool relaxed_ = false;          // see KeptPlanes::add_to
  Vec3 placed_at_m_;              // where directions were looked up
  std::vector<Primitive> first_;  // those found at the start, or last
  Vec3 released_m_;
  int dropped_ = 0;
  int located_ = 0;  // places where a level gave way, in this tick
  std::vector<std::int32_t> entered_;
  std::vector<Crossing> crossings_;
  std::vector<SubStep> sub_steps_;
  std::vector<PlacedPrimitive> placed_;
};

}  // namespace palpa
