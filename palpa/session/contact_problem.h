// What one move of the proxy is solved with: primitives that stand for the data near by.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "palpa/mode/tick_work.h"
#include "palpa/session/coulomb_friction.h"
#include "palpa/session/directed_force_limiter.h"
#include "palpa/session/level_estimate.h"
#include "palpa/session/mode_runtime.h"
#include "palpa/solver/law.h"

namespace palpa {

/// A level that a mode holds the proxy on, in one move: the rows of a set that stand on it, a plane or the facets of a corner.
struct LevelContact {
  PrimitiveId id;
  HeldLevel level;
  std::size_t first = 0;   ///< row of the set
  std::size_t facets = 1;  ///< rows
  std::int32_t line = -1;  ///< row of the line that is friction on it; -1: none
  bool solid_is_high = true;
  bool bounds = true;     ///< the proxy is to stay out of it; false where its mode fades, which is not where the proxy is yet
  bool can_break = true;  ///< gives way by breaking; false where it does so because data end nearby
  bool breaks_at_step_end = false;  ///< holds up to the end of the sub-step and yields beyond
  bool is_shut = false;             ///< leaves nothing free but the proxy's own place: a point of its strength there
  PrimitiveState state = PrimitiveState::stick;  ///< in the last balance
  Vec3 pressed{};                                ///< [1] direction of its force there; zero: none
  Primitive own{};                               ///< its plane as the mode placed it
  LevelEstimate start{};                         ///< from where the move begins: the proxy, or its foot if it is elastic
  LevelEstimate last{};                          ///< from where it was looked at last
  bool is_rigid() const noexcept { return !own.is_elastic(); }
};

/// The primitives of a move and their balance. What the modes place stays as it is during the move. A level is sampled again
/// wherever a move would end; its plane there becomes one more facet of its corner. P, the polyhedron of places known to be
/// free, always contains the *witness*, the proxy's own place: so no wrong facet can press the proxy through a level
/// (docs/theory.md). A foreseen plane may shut the witness out by `shallow`; it is taken back before its level gives way. For
/// an elastic level, which lets the proxy in, the *foot* takes the proxy's part: it is the witness, and must be free at the
/// end. A level that blocks, though none of its facets says how, is *shut*: its P is the proxy's own place alone, a point of
/// its strength, so that it bears no more than that, and yields. Facets live for one move. Keeps in a block what the next
/// balance depends on; allocates at construction only; one thread.
class ContactProblem {
 public:
  static constexpr std::size_t max_primitives = 64;  // [1] per balance; more are dropped. More: memory, longer worst tick

  /// \param work  of the tick, spent here
  ContactProblem(StateArena& live, std::unique_ptr<Law> law, ModeRuntime& modes, double stiffness_n_per_m, WorkBudget& work);

  void clear() noexcept;
  /// The next balance starts without a warm start.
  void forget_warm_start() noexcept { law_->reset(); }

  /// Begins a move: forgets all facets.
  void begin_move(const StepContext& context, double spacing_m) noexcept;
  /// Lets the modes place primitives, looking at the data at `middle_m` [m]; what stands on a level looks at `level_m` [m].
  /// Facets that were learnt in this move stay. `moved_n` [N]: see DirectedForceLimiter. Returns the mode that had to be held
  /// back, or -1.
  std::int32_t place(const StepContext& context, const Vec3& middle_m, const Vec3& level_m, double moved_n) noexcept;
  /// Takes the planes of the levels from the expected end of the move, `end_m` [m], instead of from the proxy: no further move
  /// is needed then. Skips levels that turn fast or whose plane would shut the witness out by more than `shallow`. Samples.
  void predict_planes(const Vec3& end_m) noexcept;
  /// Foresees once more, from the end that was found. False if done before, nothing was foreseen, or no elastic level holds.
  bool refine(const Vec3& end_m) noexcept;
  /// Takes back what was foreseen, for the rest of the move: planes are from the proxy again. False if there is nothing.
  bool revert_prediction() noexcept;
  /// Balances what was placed.
  Balance balance(const Vec3& probe_m, double time_step_s) noexcept;

  /// Whether a shell (a level with a fixed value, no material) gives way in the last balance.
  bool any_gives_way(const Crossings& crossings) const noexcept;
  /// Whether a level holds the proxy in the last balance.
  bool any_holds() const noexcept {
    return std::ranges::any_of(contacts_, [](const LevelContact& c) { return c.state != PrimitiveState::off; });
  }
  /// Whether the proxy may end its move at `end_m` [m], a `fraction` [1] of the way to the balance at `balance_m` [m]: in front
  /// of every level that bounds it, or up to `deepest` [1] spacings behind one if the energy fell as promised. Samples.
  bool accepts(const Vec3& end_m, double deepest, const Vec3& balance_m, double fraction, const Vec3& probe_m,
               double time_step_s) noexcept;
  /// Adds facets that shut out `end_m` [m], an end that was not accepted. False where all are known already. Samples.
  bool add_cutting_planes(const Vec3& end_m) noexcept;
  /// Shuts the levels that the last end that was not accepted lies behind, for the rest of the move. False where there are
  /// none.
  bool shut() noexcept;
  /// Whether a level is shut.
  bool any_shut() const noexcept { return std::ranges::any_of(contacts_, &LevelContact::is_shut); }
  /// The longest way that the proxy could still move from an accepted end if the levels that hold it were sampled again
  /// there [m]; infinity where it is off one of them. Samples.
  double unsettled_m(const Vec3& end_m) noexcept;
  /// Sets the policy of a search for events from the start to `end_m` [m]: a level that holds the proxy is not crossed, and
  /// the way may go no deeper into it than `piercing`, or than the start is. Samples.
  void configure_events(const Crossings& crossings, const Vec3& end_m, EventPolicy& policy) noexcept;

  /// Marks the levels that give way in the last balance: they hold up to the end of this sub-step and yield there.
  void stop_at_bound() noexcept {
    for (LevelContact& contact : contacts_) contact.breaks_at_step_end = contact.state == PrimitiveState::slip;
  }
  /// Ends the move: later directed forces are limited against those of this move.
  void end_move() noexcept { held_.keep(set_, placed_at_m_); }
  /// Stores the feet that a proxy at `proxy_m` [m] has on elastic levels.
  void keep_feet(const Vec3& proxy_m) noexcept;

  const Law& law() const noexcept { return *law_; }
  const PrimitiveSet& set() const noexcept { return set_; }
  std::span<const LevelContact> contacts() const noexcept { return contacts_; }
  /// The contact that a row of the set belongs to; nullptr if none.
  const LevelContact* contact_of(std::size_t row) const noexcept;
  /// Whether a primitive was placed that stands on no level: its direction is taken at the middle of the move.
  bool has_directions() const noexcept { return has_directions_; }

 private:
  struct Facet {
    PrimitiveId id;
    HeldLevel level;
    Vec3 position_m;
    Vec3 normal;
  };
  const LevelEstimate& look(LevelContact& contact, const Vec3& x_m) noexcept;
  LevelEstimate seen_from(const LevelContact& contact, const Vec3& x_m) noexcept {
    work_.spend(modes_.samples().work_of_look(contact.level.field));
    return estimate_level(modes_.samples(), contact.level, contact.solid_is_high, x_m, spacing_m_);
  }
  Vec3 foot_m(const LevelContact& contact, const Vec3& x_m) const noexcept;
  Vec3 witness_of(const LevelContact& contact) const noexcept;
  bool holds(const LevelContact& contact) const noexcept {
    return contact.bounds && !contact.is_shut && contact.state != PrimitiveState::slip;
  }
  void stand_on(const LevelContact& contact, const Primitive& plane) noexcept;
  double depth_m(const Vec3& x_m) noexcept;
  Vec3 put_back(const Vec3& x_m) noexcept;
  void find_feasible_point() noexcept;
  void find_contacts() noexcept;
  void add_learnt() noexcept;
  bool add_facet(LevelContact& contact, const Vec3& position_m, const Vec3& normal) noexcept;
  void forget_idle(LevelContact& contact) noexcept;
  void remove_facet(LevelContact& contact, std::size_t row) noexcept;
  void close(LevelContact& contact) noexcept;
  bool comes_out(const Vec3& end_m) noexcept;
  bool turn_friction() noexcept;
  Balance solve(const Vec3& probe_m, double time_step_s) noexcept;
  double gain_j(const Vec3& to_m, bool on_levels, const Vec3& probe_m, double time_step_s) noexcept;

  std::unique_ptr<Law> law_;
  ModeRuntime& modes_;
  double stiffness_n_per_m_;
  WorkBudget& work_;
  PrimitiveSet set_;
  CoulombFriction friction_;
  DirectedForceLimiter held_;
  std::vector<LevelContact> contacts_, before_;  // of this placing, and of the one before
  std::vector<Facet> learnt_;                    // in this move
  Vec3 start_m_, witness_m_, placed_at_m_;
  Vec3 refused_m_;  // the last end that was not accepted
  double spacing_m_ = 0.0, start_depth_m_ = 0.0;
  bool witnessed_ = false, is_foreseen_ = false, is_refined_ = false, is_recanted_ = false, has_directions_ = false;
};

}  // namespace palpa
