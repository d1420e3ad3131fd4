// Contact problem of one move: primitives, their balance, and cutting planes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "palpa/mode/tick_work.h"
#include "palpa/session/directed_force_limiter.h"
#include "palpa/session/level_estimate.h"
#include "palpa/session/mode_runtime.h"
#include "palpa/solver/coulomb_friction.h"
#include "palpa/solver/tool_law.h"

namespace palpa {

/// Contact with a level that holds a foot in one move: a plane, or the facets of a corner.
struct LevelContact {
  PrimitiveId id;
  HeldLevel level;
  std::size_t plane = 0;   ///< handle of its plane in the set, whose facets follow in the next rows
  std::size_t facets = 1;  ///< rows of the set
  std::int32_t line = -1;  ///< handle of its friction line; -1: none
  bool solid_is_high = true;
  bool bounds = true;                            ///< a constraint; false while fading
  bool can_break = true;                         ///< may break through; false where the level ends because data end nearby
  bool breaks_at_step_end = false;               ///< holds up to the end of the sub-step and yields beyond
  bool is_shut = false;                          ///< its feasible set is the foot's position alone: a point of its strength
  PrimitiveState state = PrimitiveState::stick;  ///< in the last balance
  Vec3 pressed{};                                ///< [1] direction of its force there; zero: none
  Primitive plane_as_placed{};                   ///< its plane as the mode placed it
  LevelEstimate start{};  ///< at the start of the move: at the foot, or at its footing if the level is elastic
  LevelEstimate last{};   ///< of the most recent sample
  bool is_rigid() const noexcept { return !plane_as_placed.is_elastic(); }
};

/// Primitives of a move and their balance. The modes' primitives stay unchanged during the move. A level is sampled again
/// wherever a move would end; its plane there becomes a further facet of its corner. P, the polyhedron of points known to be
/// feasible, always contains the *witness*, the foot's own position: so no wrong facet can press the foot through a level
/// (docs/theory.md). A predicted plane may exclude the witness by `shallow`; it is reverted before its level breaks. On an
/// elastic level, which lets the foot in, the *footing* is the witness, and must be free at the end. A level that blocks
/// without an explaining facet is *shut*: its P is the foot's position alone, a point of its strength, so that it bears no
/// more, and yields. Facets live for one move. Positions of moves are those of the proxy, which carries the feet. The input of
/// the next balance is kept in a StateArena; allocates at construction only; one thread.
class ContactProblem {
 public:
  /// [1] Most primitives per balance with this number of feet; more are dropped. More: memory, longer worst tick.
  static constexpr std::size_t most_primitives(std::size_t feet) noexcept { return 60 + 4 * feet; }

  /// \param work  budget of the tick, spent here
  ContactProblem(StateArena& live, std::unique_ptr<Law> law, ModeRuntime& modes, double stiffness_n_per_m, WorkBudget& work);

  void clear() noexcept;
  void forget_warm_start() noexcept { law_.reset(); }

  /// Begins a move: removes all facets.
  void begin_move(const StepContext& context, double spacing_m) noexcept;
  /// Lets the modes place primitives from data at `middle` [m], or at `level` [m] for planes on a level. Keeps this move's
  /// facets. `data_fraction` [1]: see ModeRuntime::place; `moved_n` [N]: see DirectedForceLimiter. Returns the mode whose force
  /// was limited, or -1.
  std::int32_t place(const StepContext& context, const Pose& middle, const Pose& level, double data_fraction,
                     double moved_n) noexcept;
  /// Linearises the levels at the expected end `end` [m] of the move instead of at the proxy, which saves a move. Skips
  /// levels that turn fast or whose plane would exclude the witness by more than `shallow`. Samples.
  void predict_planes(const Pose& end) noexcept;
  /// Predicts once more, from the end found. False if done before, if nothing was predicted, or if no elastic level holds.
  bool repredict_once(const Pose& end) noexcept;
  /// Linearises planes at the proxy again for the rest of the move. False without a prediction.
  bool revert_prediction() noexcept;
  /// Valid until the next.
  const Balance& balance(const Pose& probe, double time_step_s) noexcept;
  /// Of a whole move in which no mode places a primitive. Spends no work.
  const Balance& balance_of_nothing(const StepContext& context) noexcept;
  const Balance& last_balance() const noexcept { return found_; }
  /// Pose of a balance of this move for the device at `probe` [m].
  Pose pose_of(const Balance& balance, const Pose& probe) const noexcept { return law_.pose_of(balance, probe); }

  /// Whether a shell (a level with a fixed value, no material) gives way in the last balance.
  bool any_gives_way(const Crossings& crossings) const noexcept;
  /// Force beyond the strength of the shell that is nearest to giving way in the last balance, as a share of its strength [1]:
  /// above 0 where one gives way, -1 without shells.
  double overload(const Crossings& crossings) const noexcept;
  bool any_holds() const noexcept {
    return std::ranges::any_of(contacts_, [](const LevelContact& c) { return c.state != PrimitiveState::off; });
  }
  /// Whether the proxy may end its move at `end` [m], a `fraction` [1] of the way to the balance at `balance` [m]: in front
  /// of every constraint, or up to `deepest` [1] spacings behind it if the energy decreased sufficiently. Samples.
  bool accepts(const Pose& end, double deepest, const Pose& balance, double fraction, const Pose& probe,
               double time_step_s) noexcept;
  /// Adds facets that exclude the rejected end `end` [m]. False if no facet is new. Samples.
  bool add_cutting_planes(const Pose& end) noexcept;
  /// Shuts the levels in front of the last rejected end for the rest of the move. False if there are none.
  bool shut() noexcept;
  bool any_shut() const noexcept { return std::ranges::any_of(contacts_, &LevelContact::is_shut); }
  /// Upper bound on the further motion from an accepted end if the levels that hold the proxy were sampled again there [m];
  /// infinity off any of them. Samples.
  double unsettled_m(const Pose& end) noexcept;
  /// Configures the event search of a foot from the start to `end` [m]: levels that hold it are not crossed, nor entered
  /// deeper than `piercing` or the start. Samples.
  void configure_events(std::size_t foot, const Crossings& crossings, const Pose& end, EventPolicy& policy) noexcept;

  /// Marks the levels that give way in the last balance: they hold up to the end of this sub-step.
  void stop_at_bound() noexcept {
    for (LevelContact& contact : contacts_) contact.breaks_at_step_end = contact.state == PrimitiveState::slip;
  }
  /// Ends the move: later directed forces are limited against those of this move.
  void end_move() noexcept { held_.keep(set_, placed_at_); }
  /// Whether a row's contact is kept: it stands on a level, is elastic, or its mode has a memory.
  bool keeps_contact_at(std::size_t row) const noexcept {
    return set_.captured(row).any() || set_[row].is_elastic() || modes_.has_memory(set_[row].id.mode);
  }
  /// Contact with the primitive whose first row this is, of a proxy that ended the move at `proxy` [m] towards the balance
  /// `to`.
  Contact contact_at(std::size_t row, const Pose& proxy, const Balance& to) const noexcept;

  const ToolLaw& law() const noexcept { return law_; }
  const PrimitiveSet& set() const noexcept { return set_; }
  std::span<const LevelContact> contacts() const noexcept { return contacts_; }
  /// Contact that a row of the set belongs to; nullptr if none.
  const LevelContact* contact_of(std::size_t row) const noexcept;
  /// Whether a primitive stands on no level: its direction is sampled at the middle of the move.
  bool has_directions() const noexcept { return has_directions_; }

 private:
  struct Facet {
    PrimitiveId id;
    HeldLevel level;
    Vec3 position_m;
    Vec3 normal;
  };
  // Of the planes in this move.
  enum class Prediction : std::uint8_t { none, made, refined, reverted };

  const LevelEstimate& estimate_at(LevelContact& contact, const Vec3& x_m) noexcept;
  LevelEstimate seen_from(const LevelContact& contact, const Vec3& x_m) noexcept {
    Samples& samples = modes_.samples(contact.id.foot);
    work_.spend(samples.work_of_look(contact.level.field));
    return estimate_level(samples.scalar(contact.level.field, x_m), contact.level, contact.solid_is_high, x_m, spacing_m_);
  }
  const Tool& tool() const noexcept { return law_.tool(); }
  Vec3 foot_m(const PrimitiveId& id, const Pose& proxy) const noexcept { return tool().foot_m(proxy, id.foot); }
  Vec3 off_line_m(const PrimitiveId& id, const Pose& end) const noexcept;
  Vec3 way_to_footing_at(std::size_t row, const PrimitiveId& id, const Pose& proxy) const noexcept;
  Vec3 footing_m(const LevelContact& contact, const Pose& proxy) const noexcept;
  Vec3 witness_of(const LevelContact& contact) const noexcept;
  bool holds(const LevelContact& contact) const noexcept {
    return contact.bounds && !contact.is_shut && contact.state != PrimitiveState::slip;
  }
  void stand_on(const LevelContact& contact, const Primitive& plane) noexcept;
  bool turn_line(const LevelContact& contact, const Vec3& direction) noexcept;
  bool is_shell(const LevelContact& contact, const Crossings& crossings) const noexcept {
    return contact.can_break && crossings.is_watched({contact.level.field, contact.level.value});
  }
  double depth_m(const Pose& proxy) noexcept;
  Pose put_back(const Pose& proxy) noexcept;
  Pose put_back_all_feet(const Pose& proxy) noexcept;
  const Pose& find_feasible_pose() noexcept;
  void find_contacts() noexcept;
  void add_learnt() noexcept;
  bool add_facet(LevelContact& contact, const Vec3& position_m, const Vec3& normal) noexcept;
  void forget_idle(LevelContact& contact) noexcept;
  void remove_facet(LevelContact& contact, std::size_t row) noexcept {
    set_.remove_facet(row);
    --contact.facets;
  }
  std::size_t first_row(const LevelContact& contact) const noexcept { return set_.row(contact.plane); }
  void close(LevelContact& contact) noexcept;
  bool comes_out(const Pose& end) noexcept;
  bool turn_friction() noexcept;
  void solve(const Pose& probe, double time_step_s) noexcept;
  double gain_j(const Pose& to, bool on_levels, const Pose& probe, double time_step_s) noexcept;

  ModeRuntime& modes_;
  ToolLaw law_;
  double stiffness_n_per_m_;
  WorkBudget& work_;
  PrimitiveSet set_;
  CoulombFriction friction_;
  DirectedForceLimiter held_;
  std::vector<LevelContact> contacts_, before_;  // of this placement, and of the previous one
  std::vector<Facet> learnt_;                    // in this move
  Balance found_;                                // the last one
  Pose start_, placed_at_;
  std::optional<Pose> witness_;  // of the proxy, found on demand
  Pose refused_;                 // the last rejected end
  double spacing_m_ = 0.0, start_depth_m_ = 0.0;
  Prediction prediction_ = Prediction::none;
  bool has_directions_ = false;
  // Of a tool, to put all feet back on their levels at once:
  std::unique_ptr<ToolLaw> back_law_;
  std::unique_ptr<PrimitiveSet> back_;
};

}  // namespace palpa
