#include "palpa/session/contact_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "palpa/session/path_tolerances.h"
#include "palpa/solver/corner.h"

namespace palpa {

using namespace path_tolerances;

namespace {
// [1] Strength of levels that put a tool back, in springs stretched by a sample spacing. More: larger rounding in the bound;
// less: a level could give way.
constexpr double unyielding = 1e3;
}  // namespace

ContactProblem::ContactProblem(StateArena& live, std::unique_ptr<Law> law, ModeRuntime& modes, double stiffness_n_per_m,
                               WorkBudget& work)
    : modes_(modes),
      law_(std::move(law), modes.tool(), most_primitives(modes.tool().feet())),
      stiffness_n_per_m_(stiffness_n_per_m),
      work_(work),
      set_(most_primitives(modes.tool().feet())),
      friction_(live, set_.capacity()),
      held_(live, set_.capacity()) {
  contacts_.reserve(set_.capacity());
  before_.reserve(set_.capacity());
  learnt_.reserve(set_.capacity());
  if (tool().is_point()) return;
  back_law_ = std::make_unique<ToolLaw>(nullptr, tool(), set_.capacity());
  back_ = std::make_unique<PrimitiveSet>(set_.capacity());
}

void ContactProblem::clear() noexcept {
  law_.reset();
  friction_.clear();
  held_.clear();
}

// Contacts are in the order of their rows.
const LevelContact* ContactProblem::contact_of(std::size_t row) const noexcept {
  const auto after = std::ranges::upper_bound(contacts_, row, {}, [this](const LevelContact& c) { return first_row(c); });
  if (after == contacts_.begin()) return nullptr;
  const LevelContact& contact = *(after - 1);
  return row - first_row(contact) < contact.facets ? &contact : nullptr;
}

void ContactProblem::begin_move(const StepContext& context, double spacing_m) noexcept {
  start_ = context.start;
  law_.begin_move(start_);
  spacing_m_ = spacing_m;
  witness_.reset();
  prediction_ = Prediction::none;
  contacts_.clear();
  learnt_.clear();
}

std::int32_t ContactProblem::place(const StepContext& context, const Pose& middle, const Pose& level, double data_fraction,
                                   double moved_n) noexcept {
  modes_.place(context, middle, level, data_fraction, set_);
  work_.spend(modes_.work_of(set_));
  placed_at_ = middle;
  const std::int32_t held_back = held_.hold_back(set_, middle, law_, stiffness_n_per_m_, moved_n);
  before_.swap(contacts_);
  find_contacts();
  add_learnt();
  return held_back;
}

void ContactProblem::add_learnt() noexcept {
  for (LevelContact& contact : contacts_) {
    for (const LevelContact& before : before_) {
      if (!(contact.id == before.id) || contact.level != before.level) continue;
      contact.pressed = before.pressed;
      if (before.is_shut) close(contact);
    }
    for (const Facet& facet : learnt_) {
      if (contact.is_shut || !(contact.id == facet.id) || contact.level != facet.level) continue;
      add_facet(contact, facet.position_m, facet.normal);
    }
  }
}

void ContactProblem::find_contacts() noexcept {
  contacts_.clear();
  has_directions_ = false;
  for (std::size_t i = 0; i < set_.size(); ++i) {
    const Primitive& p = set_[i];
    const auto rubs = p.kind != PrimitiveKind::line
                          ? contacts_.rend()
                          : std::find_if(contacts_.rbegin(), contacts_.rend(), [&](const LevelContact& contact) {
                              return contact.id.mode == p.id.mode && contact.id.foot == p.id.foot &&
                                     set_[contact.plane].direction == p.direction;
                            });
    if (rubs != contacts_.rend()) {
      rubs->line = static_cast<std::int32_t>(i);
    } else if (set_.captured(i).any() && p.strength_n > 0.0) {
      LevelContact& contact = contacts_.emplace_back(p.id, set_.captured(i), i);
      contact.plane_as_placed = p;
      const Vec3 from_m = foot_m(p.id, start_) + modes_.carried_m(p.id) + modes_.contacts().offset_m(p.id);
      Samples& samples = modes_.samples(p.id.foot);
      const ScalarSample& at = samples.scalar(contact.level.field, from_m);
      work_.spend(samples.work_of_look(contact.level.field));
      contact.solid_is_high = dot(at.gradient, p.direction) < 0.0;
      contact.start = contact.last = estimate_level(at, contact.level, contact.solid_is_high, from_m, spacing_m_);
      contact.bounds = !modes_.fades(p.id);
      contact.can_break = !modes_.only_yields(p.id);
    } else {
      has_directions_ = true;
    }
  }
}

// Turns each friction line along the sum of its facets' forces. False if no direction changes.
bool ContactProblem::turn_friction() noexcept {
  bool changed = false;
  for (const LevelContact& contact : contacts_) {
    if (contact.facets == 1 || contact.pressed == Vec3{}) continue;
    changed = turn_line(contact, contact.pressed) || changed;
  }
  return changed;
}

// Turns a contact's friction line, if it has one. False if its direction does not change.
bool ContactProblem::turn_line(const LevelContact& contact, const Vec3& direction) noexcept {
  if (contact.line < 0) return false;
  const std::size_t row = set_.row(static_cast<std::size_t>(contact.line));
  Primitive line = set_[row];
  const bool changes = line.direction != direction;
  line.direction = direction;
  set_.replace(row, line, {});
  return changes;
}

void ContactProblem::solve(const Pose& probe, double time_step_s) noexcept {
  const int size = static_cast<int>(set_.size());
  const bool is_point = tool().is_point();
  const int each = is_point ? tick_work::primitives_each : tick_work::tool_primitives_each;
  const int most_iterations = each * work_.left() / std::max(1, size);
  found_ = friction_.solve(law_, set_, probe, stiffness_n_per_m_, time_step_s, most_iterations);
  const int passed = found_.iterations * size;
  // Division by constants: by a variable it takes as long as a balance without primitives.
  work_.spend(1 + (is_point ? passed / tick_work::primitives_each : passed / tick_work::tool_primitives_each));
  for (LevelContact& contact : contacts_) {
    const std::size_t first = first_row(contact);
    contact.state = law_.at_foot(found_, contact.id, [&](const Balance& at) { return state_at(set_.primitives(), first, at); });
    contact.pressed =
        pressed_direction(set_.primitives().subspan(first, contact.facets), law_.forces_n().subspan(first, contact.facets));
  }
}

const Balance& ContactProblem::balance(const Pose& probe, double time_step_s) noexcept {
  turn_friction();
  solve(probe, time_step_s);
  if (work_.any() && turn_friction()) solve(probe, time_step_s);
  return found_;
}

const Balance& ContactProblem::balance_of_nothing(const StepContext& context) noexcept {
  set_.clear(context.start.position_m);
  contacts_.clear();
  law_.begin_move(start_ = context.start);
  return found_ = law_.solve(set_, context.probe, stiffness_n_per_m_, context.time_step_s);
}

bool ContactProblem::any_gives_way(const Crossings& crossings) const noexcept {
  return std::ranges::any_of(contacts_, [&](const LevelContact& contact) {
    return contact.state == PrimitiveState::slip && is_shell(contact, crossings);
  });
}

double ContactProblem::overload(const Crossings& crossings) const noexcept {
  double most = -1.0;
  for (const LevelContact& contact : contacts_) {
    if (contact.state == PrimitiveState::off || !is_shell(contact, crossings)) continue;
    const std::size_t first = first_row(contact);
    const Primitive& plane = set_[first];
    double over = 0.0;
    if (contact.state == PrimitiveState::slip) {
      const double depth_m = law_.at_foot(
          found_, contact.id, [&](const Balance& at) { return norm(residual(set_.primitives(), first, at.position_m)); });
      const double given_m = plane.is_elastic() ? plane.strength_n / plane.stiffness_n_per_m : 0.0;
      over = std::max(std::numeric_limits<double>::min(),
                      stiffness_n_per_m_ * (depth_m - given_m) / (law_.gain(contact.id) * plane.strength_n));
    } else {
      Vec3 force_n;
      for (const Vec3& facet_n : law_.forces_n().subspan(first, contact.facets)) force_n += facet_n;
      over = std::min(0.0, norm(force_n) / plane.strength_n - 1.0);
    }
    most = std::max(most, over);
  }
  return most;
}

const LevelEstimate& ContactProblem::estimate_at(LevelContact& contact, const Vec3& x_m) noexcept {
  if (x_m == contact.start.at_m) return contact.start;
  if (x_m != contact.last.at_m) contact.last = seen_from(contact, x_m);
  return contact.last;
}

// Departure of a foot that moves on an arc from the linear way that the primitives have it on; zero for a point.
Vec3 ContactProblem::off_line_m(const PrimitiveId& id, const Pose& end) const noexcept {
  return tool().is_point() ? Vec3{} : foot_m(id, end) - law_.linear_foot_m(id, end);
}

// From a foot to its footing on an elastic level. The facets are where they act on the foot's linear way.
Vec3 ContactProblem::way_to_footing_at(std::size_t row, const PrimitiveId& id, const Pose& proxy) const noexcept {
  return way_to_footing_m(set_.primitives(), row, foot_m(id, proxy) - off_line_m(id, proxy));
}

// Point that must be free of a level: the foot, or its footing on an elastic level.
Vec3 ContactProblem::footing_m(const LevelContact& contact, const Pose& proxy) const noexcept {
  const Vec3 x_m = foot_m(contact.id, proxy);
  return contact.is_rigid() ? x_m : x_m + way_to_footing_at(first_row(contact), contact.id, proxy);
}

Vec3 ContactProblem::witness_of(const LevelContact& contact) const noexcept {
  if (contact.is_rigid()) return foot_m(contact.id, *witness_);
  return contact.start.signed_distance_m < 0.0 ? contact.start.nearest_m : contact.start.at_m;
}

// Largest depth of a foot in the levels that hold it; 0 in front of all.
double ContactProblem::depth_m(const Pose& proxy) noexcept {
  double deepest_m = 0.0;
  for (LevelContact& contact : contacts_) {
    if (holds(contact)) deepest_m = std::max(deepest_m, -estimate_at(contact, footing_m(contact, proxy)).signed_distance_m);
  }
  return deepest_m;
}

// Nearest pose in front of every rigid level that holds a foot.
Pose ContactProblem::put_back(const Pose& proxy) noexcept {
  if (!tool().is_point()) return put_back_all_feet(proxy);
  Pose on_levels = proxy;
  for (LevelContact& contact : contacts_) {
    if (!holds(contact) || !contact.is_rigid()) continue;
    const LevelEstimate at = estimate_at(contact, on_levels.position_m);
    if (at.signed_distance_m < 0.0) on_levels.position_m = at.nearest_m;
  }
  return on_levels;
}

// By one motion of the tool: the balance of the levels alone, with the pose as the device.
Pose ContactProblem::put_back_all_feet(const Pose& proxy) noexcept {
  back_->clear(proxy.position_m);
  bool any = false;
  for (LevelContact& contact : contacts_) {
    if (!holds(contact) || !contact.is_rigid()) continue;
    const Vec3 foot = foot_m(contact.id, proxy);
    const LevelEstimate at = estimate_at(contact, foot);
    any = any || at.signed_distance_m < 0.0;
    back_->begin_foot(contact.id.foot, foot);
    back_->begin_mode(contact.id.mode);
    back_->plane(contact.id.slot, at.nearest_m, at.normal, unyielding * stiffness_n_per_m_ * spacing_m_);
  }
  if (!any) return proxy;
  back_law_->begin_move(proxy);
  work_.spend(1 + static_cast<int>(back_->size()) / tick_work::tool_primitives_each);
  return back_law_->pose_of(back_law_->solve(*back_, proxy, stiffness_n_per_m_, 1.0), proxy);
}

// Feasible pose (witness): the proxy, carried along by the data and put back in front of every rigid level that holds it.
const Pose& ContactProblem::find_feasible_pose() noexcept {
  if (witness_) return *witness_;
  start_depth_m_ = 0.0;
  Vec3 carried_m;
  for (LevelContact& contact : contacts_) {
    if (!holds(contact)) continue;
    const LevelEstimate& there = contact.is_rigid() ? estimate_at(contact, foot_m(contact.id, start_)) : contact.start;
    start_depth_m_ = std::max(start_depth_m_, -there.signed_distance_m);
    if (carried_m == Vec3{}) carried_m = modes_.carried_m(contact.id);
  }
  return witness_.emplace(put_back({start_.position_m + carried_m, start_.turn}));
}

// Decrease of energy from the witness to `to_m`: of the spring, of all primitives but holding levels, and stored in elastic
// levels. `on_levels`: footings are put back on their levels first. Products: differences of squares lose digits.
double ContactProblem::gain_j(const Pose& to, bool on_levels, const Pose& probe, double time_step_s) noexcept {
  const Pose& from = *witness_;
  const Vec3 &from_m = from.position_m, &to_m = to.position_m;
  double gain_j = stiffness_n_per_m_ * dot(from_m - to_m, 0.5 * (from_m + to_m) - probe.position_m);
  if (!tool().is_point()) {
    const Vec3 before_m = tool().motion(probe, from).arc_m, after_m = tool().motion(probe, to).arc_m;
    gain_j += 0.5 * stiffness_n_per_m_ * dot(before_m - after_m, before_m + after_m);
  }
  for (std::size_t i = 0; i < set_.size(); ++i) {
    const LevelContact* contact = contact_of(i);
    if (contact && holds(*contact)) continue;
    gain_j += fall_j(set_[i], foot_m(set_[i].id, from), foot_m(set_[i].id, to), time_step_s);
  }
  for (LevelContact& contact : contacts_) {
    if (!holds(contact) || contact.is_rigid()) continue;
    Vec3 footing = footing_m(contact, to);
    if (on_levels) {
      const LevelEstimate& at = estimate_at(contact, footing);
      if (at.signed_distance_m < 0.0) footing = at.nearest_m;
    }
    const Vec3 before_m = witness_of(contact) - foot_m(contact.id, from), after_m = footing - foot_m(contact.id, to);
    gain_j += 0.5 * contact.plane_as_placed.stiffness_n_per_m * dot(before_m - after_m, before_m + after_m);
  }
  return gain_j;
}

bool ContactProblem::accepts(const Pose& end, double deepest, const Pose& balance, double fraction, const Pose& probe,
                             double time_step_s) noexcept {
  const double deepest_m = depth_m(end);
  if (deepest_m <= contact_tolerance * spacing_m_) return true;
  refused_ = end;
  const Pose& witness = find_feasible_pose();
  // A proxy left deep inside a level by moving data must leave it, even if the energy rises.
  if (start_depth_m_ > piercing * spacing_m_) return comes_out(end);
  if (!(deepest_m <= deepest * spacing_m_)) return false;
  // Relative to the witness, in front of all levels: a position inside a level must gain nothing.
  const Pose promised = tool().moved(witness, fraction * tool().motion(witness, balance));
  const double promised_j = gain_j(promised, false, probe, time_step_s);
  return gain_j(put_back(end), true, probe, time_step_s) >= sufficient_decrease * promised_j;
}

// Whether an end is nearer to the free side than the start, for every level that it is deep in. Compares values: first-order
// estimates fail at depths of more than a spacing.
bool ContactProblem::comes_out(const Pose& end) noexcept {
  return std::ranges::all_of(contacts_, [&](LevelContact& contact) {
    if (!holds(contact)) return true;
    const double before = (contact.is_rigid() ? estimate_at(contact, foot_m(contact.id, start_)) : contact.start).behind;
    const LevelEstimate& at = estimate_at(contact, footing_m(contact, end));
    return -at.signed_distance_m <= piercing * spacing_m_ || at.behind < before;
  });
}

// Moves a contact to another plane, and its friction line to that plane's normal.
void ContactProblem::stand_on(const LevelContact& contact, const Primitive& plane) noexcept {
  set_.replace(first_row(contact), plane, contact.level);
  turn_line(contact, plane.direction);
}

void ContactProblem::predict_planes(const Pose& end) noexcept {
  if (prediction_ == Prediction::reverted || !learnt_.empty()) return;
  for (LevelContact& contact : contacts_) {
    if (!holds(contact)) continue;
    Primitive plane = contact.plane_as_placed;
    LevelEstimate there = estimate_at(contact, footing_m(contact, end));
    Vec3 turn = there.normal - contact.start.normal;
    plane.direction = normalized(plane.direction + turn);
    // The footing on an elastic level needs the normal at its own position: sample again there.
    const Vec3 foot_end_m = foot_m(contact.id, end);
    const Vec3 on_plane_m = foot_end_m + dot(plane.direction, there.nearest_m - foot_end_m) * plane.direction;
    if (!contact.is_rigid() && distance(on_plane_m, there.at_m) > turned * spacing_m_) {
      there = estimate_at(contact, on_plane_m);
      turn = there.normal - contact.start.normal;
      plane.direction = normalized(contact.plane_as_placed.direction + turn);
    }
    plane.position_m = there.nearest_m;
    if (!tool().is_point()) plane.position_m -= off_line_m(contact.id, end);
    find_feasible_pose();
    const bool shuts_out = dot(plane.direction, plane.position_m - witness_of(contact)) > shallow * spacing_m_;
    if (shuts_out || !(norm(turn) * spacing_m_ <= distance(foot_end_m, foot_m(contact.id, start_)))) continue;
    stand_on(contact, plane);
    if (prediction_ == Prediction::none) prediction_ = Prediction::made;
  }
}

Contact ContactProblem::contact_at(std::size_t row, const Pose& proxy, const Balance& to) const noexcept {
  using Phase = Contact::Phase;
  const Primitive& p = set_[row];
  const LevelContact* held = contact_of(row);  // none: a level that jumped and fades, or no level
  Contact now{.id = p.id,
              .state = held ? held->state : law_.at_foot(to, p.id, [&](const Balance& at) { return state_at(p, at); }),
              .level = set_.captured(row)};
  now.yields = now.level.any() && modes_.only_yields(p.id);
  if (held && now.state != PrimitiveState::off) {
    const bool gives_way = now.state == PrimitiveState::slip || held->breaks_at_step_end;
    now.phase = gives_way && held->can_break ? Phase::yielding : Phase::held;
  }
  const Vec3 foot_m = this->foot_m(p.id, proxy);
  double stiffness_n_per_m = 0.0;
  if (held && held->is_shut && !held->is_rigid() && now.state == PrimitiveState::stick) {
    now.offset_m = held->start.at_m - foot_m;  // held as it is
    stiffness_n_per_m = held->plane_as_placed.stiffness_n_per_m;
  } else if (p.is_elastic() && !(held && now.state == PrimitiveState::slip && held->can_break)) {
    now.offset_m = way_to_footing_at(row, p.id, proxy);
    stiffness_n_per_m = p.stiffness_n_per_m;
  }
  if (now.offset_m != Vec3{}) now.held_j = 0.5 * stiffness_n_per_m * norm_squared(now.offset_m);
  return now;
}

bool ContactProblem::repredict_once(const Pose& end) noexcept {
  const auto gives_way = [this](const LevelContact& contact) { return !contact.is_rigid() && holds(contact); };
  if (prediction_ != Prediction::made || std::ranges::none_of(contacts_, gives_way)) return false;
  prediction_ = Prediction::refined;
  predict_planes(end);
  return true;
}

bool ContactProblem::revert_prediction() noexcept {
  if (prediction_ != Prediction::made && prediction_ != Prediction::refined) return false;
  for (const LevelContact& contact : contacts_) {
    if (!contact.is_shut) stand_on(contact, contact.plane_as_placed);
  }
  prediction_ = Prediction::reverted;
  return true;
}

double ContactProblem::unsettled_m(const Pose& end) noexcept {
  double furthest_m = 0.0;
  for (LevelContact& contact : contacts_) {
    if (!holds(contact) || contact.state == PrimitiveState::off) continue;
    const LevelEstimate at = estimate_at(contact, footing_m(contact, end));
    if (std::abs(at.signed_distance_m) > still * spacing_m_) return std::numeric_limits<double>::infinity();
    const std::size_t first = first_row(contact);
    for (std::size_t row = first; row < first + contact.facets; ++row)
      furthest_m +=
          law_.gain(contact.id) * norm(law_.forces_n()[row]) / stiffness_n_per_m_ * distance(at.normal, set_[row].direction);
  }
  return furthest_m;
}

bool ContactProblem::add_cutting_planes(const Pose& end) noexcept {
  find_feasible_pose();
  bool any = false;
  for (std::size_t c = contacts_.size(); c-- > 0;) {  // backwards: the law's forces are by row, and earlier rows stay
    LevelContact& contact = contacts_[c];
    if (!holds(contact)) continue;
    const LevelEstimate at = estimate_at(contact, footing_m(contact, end));
    if (at.signed_distance_m >= 0.0) continue;
    const Vec3 off_m = off_line_m(contact.id, end);
    // A facet that excludes less than half the depth of this end is not added: a nearer end yields a better one.
    const Vec3 nearest_m = at.nearest_m - off_m;
    const Vec3 position_m = nearest_m - std::max(0.0, dot(at.normal, nearest_m - witness_of(contact))) * at.normal;
    if (!(dot(at.normal, position_m - (at.at_m - off_m)) >= std::max(new_plane_min * spacing_m_, -0.5 * at.signed_distance_m)))
      continue;
    // Of a tool, a facet that the start is behind by more excludes no part of the way from the end on: the foot comes out
    // there.
    const Vec3 start_m = foot_m(contact.id, start_) + modes_.carried_m(contact.id);
    const bool is_foot = !tool().is_point() && contact.is_rigid();
    if (is_foot && dot(at.normal, start_m - (at.at_m - off_m)) < 0.0) continue;
    if (contact.facets == most_facets) forget_idle(contact);
    if (!add_facet(contact, position_m, at.normal)) continue;
    learnt_.push_back({contact.id, contact.level, position_m, at.normal});
    any = true;
  }
  return any;
}

bool ContactProblem::add_facet(LevelContact& contact, const Vec3& position_m, const Vec3& normal) noexcept {
  // In a slit the path's own facet does not fit; a nearer end needs none. The mode is not at fault.
  if (!detail::can_take_facet(whole_of(set_.primitives(), first_row(contact)), normal)) return false;
  if (!set_.add_facet(contact.plane, position_m, normal)) return false;
  ++contact.facets;
  return true;
}

// Facets without force may be removed at any time (theory.md); the first facet is the mode's own.
void ContactProblem::forget_idle(LevelContact& contact) noexcept {
  const std::size_t first = first_row(contact);
  std::erase_if(learnt_, [&](const Facet& facet) {
    if (!(facet.id == contact.id) || facet.level != contact.level) return false;
    for (std::size_t row = first + 1; row < first + contact.facets; ++row) {
      if (set_[row].position_m != facet.position_m || set_[row].direction != facet.normal) continue;
      return law_.forces_n()[row] == Vec3{};
    }
    return false;
  });
  for (std::size_t row = first + contact.facets; row-- > first + 1;) {
    if (law_.forces_n()[row] == Vec3{}) remove_facet(contact, row);
  }
}

bool ContactProblem::shut() noexcept {
  bool any = false;
  for (LevelContact& contact : contacts_) {
    if (!holds(contact) ||
        !(estimate_at(contact, footing_m(contact, refused_)).signed_distance_m < -contact_tolerance * spacing_m_))
      continue;
    close(contact);
    any = true;
  }
  return any;
}

// Every P that contains the witness is valid (theory.md 8.7), and the witness alone is the smallest. Deep in the level the foot
// is held in place: the direction to the free side is unknown.
void ContactProblem::close(LevelContact& contact) noexcept {
  contact.is_shut = true;
  const std::size_t first = first_row(contact);
  while (contact.facets > 1) remove_facet(contact, first + contact.facets - 1);
  const Vec3 here_m = foot_m(contact.id, start_) + modes_.carried_m(contact.id);
  set_.replace(first, {PrimitiveKind::point, contact.id, here_m, {}, contact.plane_as_placed.strength_n}, contact.level);
}

void ContactProblem::configure_events(std::size_t foot, const Crossings& crossings, const Pose& end,
                                      EventPolicy& policy) noexcept {
  using CrossingRule = EventPolicy::CrossingRule;
  // Both ends are free, and no point between is further from both than half the length: too short to pierce a level.
  const Vec3 foot_start_m = tool().foot_m(start_, foot);
  const bool is_short = 0.5 * distance(foot_start_m, tool().foot_m(end, foot)) <= piercing * spacing_m_;
  for (const LevelContact& contact : contacts_) {
    if (contact.id.foot != foot) continue;
    const Threshold level{contact.level.field, contact.level.value};
    const bool high = contact.solid_is_high;
    if (contact.state == PrimitiveState::stick) crossings.configure_events(policy, level, CrossingRule::held);
    if (contact.state == PrimitiveState::off)
      crossings.configure_events(policy, level, high ? CrossingRule::leaves_down : CrossingRule::leaves_up);
    if (is_short || !holds(contact) || !contact.is_rigid()) continue;
    Samples& samples = modes_.samples(foot);
    const ScalarSample& here = samples.scalar(level.field, foot_start_m);
    // In flat data values do not determine the depth; only differences above rounding count.
    const double margin = piercing * spacing_m_ * norm(here.gradient) + samples.rounding(level.field);
    ValueRange& allowed = policy.fields[static_cast<std::size_t>(level.field)].allowed;
    if (high) allowed.max = std::min(allowed.max, std::max(level.value, here.value) + margin);
    if (!high) allowed.min = std::max(allowed.min, std::min(level.value, here.value) - margin);
  }
}

}  // namespace palpa
