#include "palpa/tick/session.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "palpa/core/damper.h"
#include "palpa/core/live_block.h"
#include "palpa/core/slack.h"
#include "palpa/core/solver.h"
#include "palpa/core/split.h"
#include "palpa/core/tick_work.h"
#include "palpa/tick/proxy_path.h"

namespace palpa {

namespace {

constexpr double largest_probe_m = 1e3;      // [m] further away is bad input. More: wrong units pass; less: large rooms do not
constexpr double largest_time_step_s = 1.0;  // [s] longer is bad input. More: a late tick moves far; less: slow replays fail

bool usable(const Vec3& position_m) noexcept {
  return is_finite(position_m) && largest_component(position_m) <= largest_probe_m;
}

std::unique_ptr<ProxyPath> exact_path(LiveBlock& live, const Scene& scene, const Similarity& map) {
  return std::make_unique<ProxyPath>(live, scene, map, std::make_unique<Solver>(ProxyPath::max_primitives));
}

}  // namespace

class Session::State {
 public:
  State(const Scene& given, PathMaker make_path, double encoder_step_m)
      : scene(checked(given)),
        map(scene.hand_to_world()),
        path(make_path(live, scene, map)),
        coupling(live.add<CouplingState>()),
        ledger(scene.modes().size()),
        mode_ticks(scene.modes().size()) {
    coupling.damper = Damper(scene.coupling.damping_ns_per_m, encoder_step_m);
  }

  Tick tick(const Probe& probe, double dt) noexcept;
  void reset() noexcept {
    path->reset();
    coupling.damper_force = {};
    coupling.slack.reset();
  }
  void continue_from(const State& other) noexcept {
    live.copy(other.live);
    path->goes_on();
  }
  void take_over(const State& other) noexcept;
  std::span<const ModeTick> who_pushed() noexcept;

  Scene scene;
  Similarity map;
  LiveBlock live;
  std::unique_ptr<ProxyPath> path;

 private:
  static const Scene& checked(const Scene& scene) {
    scene.check();
    return scene;
  }
  void gather(Tick& result) noexcept;

  // What the next tick depends on besides the path.
  struct CouplingState {
    Damper damper{0.0};
    Slack slack;
    Vec3 last_probe;
    Vec3 damper_force;      // held since the last tick
    double stored_j = 0.0;  // in the spring and in elastic levels since then
  };

  CouplingState& coupling;
  Ledger ledger;
  std::vector<ModeTick> mode_ticks;
  bool who_pushed_known = true;  // mode_ticks hold the forces of the last sub-step
  ShownForces shown{ProxyPath::max_primitives};
};

void Session::State::take_over(const State& other) noexcept {
  const Damper own = coupling.damper;
  const bool goes_on = live.has_parts_of(other.live) && path->holds_on_as(*other.path);
  goes_on ? continue_from(other) : path->begin_where(*other.path);
  coupling = other.coupling;
  if (goes_on && scene.coupling.damping_ns_per_m == other.scene.coupling.damping_ns_per_m) return;
  coupling.damper = own;
  coupling.damper.reset(path->proxy_m() - coupling.last_probe - coupling.slack.unfelt_m());
  coupling.damper_force = {};
}

// The main path. Modes place primitives, the law balances them, the coupling pulls the hand.
Tick Session::State::tick(const Probe& probe, double dt) noexcept {
  CouplingState& c = coupling;
  std::fill(mode_ticks.begin(), mode_ticks.end(), ModeTick{});
  who_pushed_known = true;
  Tick result;
  result.probe_valid = probe.valid;
  result.probe_m = path->proxy_m();
  result.proxy_m = path->proxy_m();

  const bool time_usable = std::isfinite(dt) && dt > 0.0 && dt <= largest_time_step_s;
  if (time_usable) path->pass(dt);
  const bool velocity_usable = !probe.velocity_m_per_s || is_finite(*probe.velocity_m_per_s);
  if (!probe.valid || !time_usable || !velocity_usable || !usable(probe.position_m)) {
    reset();
    result.energy.let_go_j = std::exchange(c.stored_j, 0.0);
    if (probe.valid) result.status = TickStatus::bad_input;
    if (!probe.valid && usable(probe.position_m)) result.probe_m = result.proxy_m = probe.position_m;
    path->put(result.proxy_m);
    return result;
  }

  dt = std::max(dt, shortest_time_s);  // velocities stay finite
  const Vec3 p = probe.position_m;
  const double k = scene.coupling.stiffness_n_per_m;
  double lost_j = 0.0;
  if (!path->started()) {
    c.last_probe = p;
    c.damper.reset({});
    lost_j = c.stored_j;
  }
  const Vec3 probe_step = p - c.last_probe;
  const Vec3 before = path->proxy_m();
  result.status = path->walk(p, dt, ledger) ? TickStatus::resting : TickStatus::waiting;

  const Vec3 proxy = path->proxy_m();
  result.probe_m = p;
  result.probe_step_m = probe_step;
  result.proxy_m = proxy;
  Vec3 stretch = proxy - p, released = path->released_m();
  double held_back_j = 0.0;  // what waits does not pull
  if (path->waits_s() > 0.0 || c.slack.any()) {
    held_back_j = k * dot(c.slack.unfelt_m(), probe_step), released = {};
    stretch = c.slack.felt_m(stretch, proxy - path->followed_m(), path->waits_s(), before - p - c.slack.unfelt_m());
  }
  const Vec3 relative = c.damper.relative_velocity(stretch, released, dt, k);
  result.probe_velocity_m_per_s = probe.velocity_m_per_s.value_or(probe_step / dt);
  result.proxy_velocity_m_per_s = result.probe_velocity_m_per_s + relative;
  const Vec3 damping_n = scene.coupling.damping_ns_per_m * relative;
  result.force_n = k * stretch + damping_n;  // Eq. 1

  result.energy = ledger.end(proxy, p, probe_step, k);
  result.energy.let_go_j += lost_j;
  result.energy.damper_j = dot(c.damper_force, probe_step);
  result.energy.held_back_j = held_back_j;
  c.stored_j = result.energy.stored_j + result.energy.elastic_j;
  c.damper_force = damping_n;
  c.last_probe = p;
  gather(result);
  return result;
}

// The tick's totals. Who pushed is worked out when someone asks.
void Session::State::gather(Tick& result) noexcept {
  result.work = path->work();
  result.sub_steps = static_cast<int>(path->sub_steps().size());
  for (const SubStep& step : path->sub_steps()) {
    result.error_bound_m = std::max(result.error_bound_m, step.balance.error_bound_m);
    result.iterations += step.balance.iterations;
    if (step.balance.status == BalanceStatus::capped && result.status == TickStatus::resting)
      result.status = TickStatus::capped;
    if (step.balance.status == BalanceStatus::bad_input) result.status = TickStatus::bad_input;
  }
  result.dropped = path->dropped();
  for (std::size_t m = 0; m < mode_ticks.size(); ++m) {
    const double work_j = ledger.works_j()[m];
    (work_j >= 0.0 ? mode_ticks[m].injected_j : mode_ticks[m].dissipated_j) = std::abs(work_j);
  }
  who_pushed_known = path->sub_steps().empty();
}

// The modes' forces in the last sub-step, as they are shown.
std::span<const ModeTick> Session::State::who_pushed() noexcept {
  if (who_pushed_known) return mode_ticks;
  who_pushed_known = true;
  const SubStep& last = path->sub_steps().back();
  const auto placed = path->placed().subspan(last.first_primitive, last.primitives);
  const std::span<const Vec3> forces_n = shown.of(placed, last.balance);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    ModeTick& mode = mode_ticks[placed[i].primitive.id.mode];
    mode.split_shared = mode.split_shared || shown.is_shared(i);
    mode.force_n += forces_n[i];
    ++mode.primitives;
  }
  return mode_ticks;
}

const int Session::most_work = tick_work::most;

Session::Session(const Scene& scene, double encoder_step_m) : Session(scene, exact_path, encoder_step_m) {}

Session::Session(const Scene& scene, PathMaker path, double encoder_step_m)
    : state_(std::make_unique<State>(scene, path, encoder_step_m)) {}

Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

Tick Session::tick(const Probe& probe, double time_step_s) noexcept { return state_->tick(probe, time_step_s); }
void Session::reset() noexcept { state_->reset(); }
void Session::let_through(double most_n) noexcept { state_->path->let_through(most_n); }
void Session::refine_path(int times) { state_->path->refine(times); }
void Session::continue_from(const Session& other) noexcept { state_->continue_from(*other.state_); }
void Session::take_over(const Session& other) noexcept { state_->take_over(*other.state_); }
const Scene& Session::scene() const noexcept { return state_->scene; }
const Similarity& Session::hand_to_world() const noexcept { return state_->map; }
std::span<const ModeTick> Session::modes() const noexcept { return state_->who_pushed(); }
std::span<const SubStep> Session::sub_steps() const noexcept { return state_->path->sub_steps(); }
std::span<const PlacedPrimitive> Session::placed() const noexcept { return state_->path->placed(); }
std::span<const SessionEvent> Session::events() const noexcept { return state_->path->events(); }

}  // namespace palpa
