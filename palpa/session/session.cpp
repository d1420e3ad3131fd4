#include "palpa/session/session.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "palpa/baseline/law.h"
#include "palpa/mode/tick_work.h"
#include "palpa/session/coupling_force.h"
#include "palpa/session/ledger.h"
#include "palpa/session/proxy_path.h"
#include "palpa/solver/solver.h"
#include "palpa/solver/split.h"
#include "palpa/solver/state_arena.h"

namespace palpa {

namespace {

constexpr double largest_probe_m = 1e3;  // [m] larger is bad input. More: wrong units pass; less: large rooms do not
constexpr double turn_tolerance = 1e-3;  // [1] of a quaternion's length. More: no rotation passes; less: rounded files do not
// [rad] from the device to the proxy. More: the torque could reverse within a tick; less: a strong twist ends sooner.
constexpr double longest_turn_rad = 3.0;
constexpr double largest_time_step_s = 1.0;  // [s] longer is bad input. More: a late tick moves far; less: slow replays fail

bool usable(const Vec3& position_m) noexcept { return is_within(position_m, largest_probe_m); }

/// Earlier systems: one step a tick, straight to the balance; without a proxy, data sampled at the probe.
Steps steps_of(std::string_view law) noexcept {
  return law == "exact" ? Steps::refined : law == "no-proxy" ? Steps::one_at_probe : Steps::one_at_proxy;
}

}  // namespace

class Session::State {
 public:
  State(const Scene& given, std::unique_ptr<Law> law, Steps steps, double encoder_step_m)
      : scene(given),
        map(scene.hand_to_world()),
        path(live, scene, map, std::move(law), steps),
        coupling_force(live.add<CouplingForce>()),
        held_j(live.add<double>()),
        ledger(scene.modes().size(), path.tool()),
        mode_ticks(scene.modes().size()),
        shown(ContactProblem::most_primitives(path.tool().feet())) {
    coupling_force = CouplingForce(Damper(scene.coupling().damping_ns_per_m, encoder_step_m, !path.tool().is_point()));
  }

  Tick tick(const Probe& probe, double dt) noexcept;
  void reset() noexcept {
    path.reset();
    coupling_force.reset();
  }
  void copy_state_from(const State& other) noexcept {
    live.copy(other.live);
    path.after_state_copy(other.path);
  }
  void resume_in_changed_scene(const State& other) noexcept;
  std::span<const ModeForce> forces_by_mode() noexcept;

  Scene scene;
  Similarity map;
  StateArena live;
  ProxyPath path;

 private:
  // The rotational spring reverses at half a turn: near it the tool begins anew, as after a gap.
  bool is_overturned(const Pose& probe) const noexcept {
    const Tool& tool = path.tool();
    return !tool.is_point() && path.started() &&
           norm(tool.motion(probe, path.proxy()).arc_m) > longest_turn_rad * tool.turning_radius_m();
  }
  void gather(const Walk& walk, Tick& result) noexcept;

  // State of the next tick besides the path.
  CouplingForce& coupling_force;
  double& held_j;  // by spring and elastic levels since the last tick
  Ledger ledger;
  std::vector<ModeForce> mode_ticks;
  bool has_forces_by_mode = true;  // mode_ticks are those of the last tick
  ShownForces shown;
};

void Session::State::resume_in_changed_scene(const State& other) noexcept {
  const Damper own = coupling_force.damper();
  const bool after_state_copy = live.has_parts_of(other.live) && path.has_same_contacts_as(other.path);
  after_state_copy ? copy_state_from(other) : path.start_at_proxy_of(other.path);
  const bool keeps_damper = after_state_copy && scene.coupling().damping_ns_per_m == other.scene.coupling().damping_ns_per_m;
  const Motion extension_m = path.tool().motion(other.coupling_force.last_probe(), path.proxy());
  coupling_force.resume_in_changed_scene(other.coupling_force, own, keeps_damper, extension_m);
  held_j = other.held_j;
}

// Main path: modes place primitives, the law balances them, the coupling pulls the hand.
Tick Session::State::tick(const Probe& probe, double dt) noexcept {
  has_forces_by_mode = false;
  Tick result;
  result.probe_valid = probe.valid;
  result.probe_m = probe.position_m;
  if (probe.velocity_m_per_s) result.probe_velocity_m_per_s = *probe.velocity_m_per_s;
  const Tool& tool = path.tool();
  const bool turn_usable = tool.is_point() || is_unit(probe.turn, turn_tolerance);
  const Pose given{probe.position_m, tool.is_point() || !turn_usable ? Turn{} : unit_turn(probe.turn)};
  if (!tool.is_point()) result.probe_turn = probe.turn;
  const bool time_usable = dt > 0.0 && dt <= largest_time_step_s;
  if (time_usable) path.advance_clock(dt);
  const bool velocity_usable = !probe.velocity_m_per_s || is_finite(*probe.velocity_m_per_s);
  if (!probe.valid || !time_usable || !velocity_usable || !turn_usable || !usable(probe.position_m)) {
    reset();
    ledger.clear();
    result.energy.released_j = std::exchange(held_j, 0.0);
    if (probe.valid) result.status = TickStatus::bad_input;
    if (!probe.valid && turn_usable && usable(probe.position_m)) path.put(given);
    result.proxy_m = path.proxy().position_m;
    result.proxy_turn = path.proxy().turn;
    return result;
  }
  dt = std::max(dt, shortest_time_s);  // velocities stay finite
  double lost_j = 0.0;
  if (is_overturned(given)) reset();
  if (!path.started()) {
    path.start(given, dt);
    coupling_force.start(given);
    lost_j = held_j;
  }
  ledger.begin(path.proxy(), coupling_force.last_probe(), path.processed_up_to(), path.contacts());
  const Walk& walk = path.walk(given, dt);
  const CouplingForce::Update force = coupling_force.update(walk, given, scene.coupling(), tool, dt);
  result.energy = ledger.end(walk.proxy, given, force.probe_step_m, scene.coupling().stiffness_n_per_m, path.sub_steps(),
                             path.placed(), path.contacts());
  result.energy.released_j += lost_j;
  result.energy.damper_j = force.damper_j;
  held_j = result.energy.stored_j + result.energy.elastic_j;

  result.probe_step_m = force.probe_step_m.way_m;
  if (!probe.velocity_m_per_s) result.probe_velocity_m_per_s = result.probe_step_m / dt;
  result.proxy_m = walk.proxy.position_m;
  result.proxy_turn = walk.proxy.turn;
  if (!tool.is_point()) result.probe_turn_step_rad = force.probe_step_m.arc_m / tool.turning_radius_m();
  result.torque_nm = force.torque_nm;
  result.proxy_velocity_m_per_s = result.probe_velocity_m_per_s + force.relative_m_per_s;
  result.force_n = force.force_n;
  result.given_back_n = force.given_back_n;
  if (force.has_just_faded)
    path.warn("the data take more work than a tick may do: nothing is felt until the proxy has caught up with the hand");
  gather(walk, result);
  return result;
}

// Totals of the tick. Forces by mode are computed on demand.
void Session::State::gather(const Walk& walk, Tick& result) noexcept {
  result.status = walk.is_complete ? TickStatus::complete : TickStatus::waiting;
  result.work = walk.work;
  result.sub_steps = static_cast<int>(path.sub_steps().size());
  for (const SubStep& step : path.sub_steps()) {
    result.error_bound_m = std::max(result.error_bound_m, step.balance.error_bound_m);
    result.iterations += step.balance.iterations;
    if (step.balance.status == BalanceStatus::capped && result.status == TickStatus::complete)
      result.status = TickStatus::capped;
    if (step.balance.status == BalanceStatus::bad_input) result.status = TickStatus::bad_input;
  }
  result.dropped = walk.dropped;
  result.felt_octave = path.felt_octave().octave();
  result.forced_octave = path.felt_octave().is_forced();
  if (result.status != TickStatus::waiting) result.unborne_n = scene.coupling().stiffness_n_per_m * walk.unreached_m;
}

// Works by mode in the last tick, and forces in its last sub-step, for reports.
std::span<const ModeForce> Session::State::forces_by_mode() noexcept {
  if (has_forces_by_mode) return mode_ticks;
  has_forces_by_mode = true;
  for (std::size_t m = 0; m < mode_ticks.size(); ++m) {
    const double work_j = ledger.works_j()[m];
    mode_ticks[m] = {};
    (work_j >= 0.0 ? mode_ticks[m].injected_j : mode_ticks[m].dissipated_j) = std::abs(work_j);
  }
  if (path.sub_steps().empty()) return mode_ticks;
  const SubStep& last = path.sub_steps().back();
  const auto placed = path.placed().subspan(last.first_primitive, last.primitives);
  const std::span<const Vec3> forces_n = shown.of(placed, last);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    ModeForce& mode = mode_ticks[placed[i].primitive.id.mode];
    mode.split_shared = mode.split_shared || shown.is_shared(i);
    mode.force_n += forces_n[i];
    ++mode.primitives;
  }
  return mode_ticks;
}

const int Session::most_work = tick_work::most;

Session::Session(const Scene& scene, double encoder_step_m)
    : Session(std::make_unique<State>(scene, baseline::law(scene.law()), steps_of(scene.law()), encoder_step_m)) {}
Session::Session(const Scene& scene, std::unique_ptr<Law> law, double encoder_step_m)
    : Session(std::make_unique<State>(scene, std::move(law), Steps::refined, encoder_step_m)) {}
Session::Session(std::unique_ptr<State> state) noexcept : state_(std::move(state)) {}

Session Session::in_one_step(const Scene& scene) {
  return Session(std::make_unique<State>(scene, std::make_unique<Solver>(), Steps::one_at_proxy, 0.0));
}

Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

Tick Session::tick(const Probe& probe, double time_step_s) noexcept { return state_->tick(probe, time_step_s); }
void Session::reset() noexcept { state_->reset(); }
void Session::set_force_limit(double most_n) noexcept { state_->path.set_force_limit(most_n); }
Stock& Session::stock() noexcept { return state_->path.stock(); }
const Stock& Session::stock() const noexcept { return state_->path.stock(); }
WindowNeed Session::window_need(const Probe& probe, double time_step_s) noexcept {
  return state_->path.window_need({probe.position_m, probe.turn}, probe.valid, time_step_s);
}
void Session::refine_path(int times) { state_->path.refine(times); }
void Session::copy_state_from(const Session& other) noexcept { state_->copy_state_from(*other.state_); }
void Session::resume_in_changed_scene(const Session& other) noexcept { state_->resume_in_changed_scene(*other.state_); }
const Scene& Session::scene() const noexcept { return state_->scene; }
const Similarity& Session::hand_to_world() const noexcept { return state_->map; }
std::span<const ModeForce> Session::modes() const noexcept { return state_->forces_by_mode(); }
std::span<const SubStep> Session::sub_steps() const noexcept { return state_->path.sub_steps(); }
std::span<const PlacedPrimitive> Session::primitives() const noexcept { return state_->path.placed(); }
std::span<const SessionEvent> Session::events() const noexcept { return state_->path.events(); }

}  // namespace palpa
