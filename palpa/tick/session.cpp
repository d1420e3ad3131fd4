#include "palpa/tick/session.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "palpa/core/solver.h"
#include "palpa/core/split.h"
#include "palpa/tick/watch.h"

namespace palpa {

namespace {

constexpr std::size_t max_primitives = 64;
constexpr std::size_t max_queued = 64;
constexpr std::size_t max_events = 16;
constexpr int most_refined = 16;
constexpr double largest_probe_m = 1e3;  // further away is no hand
constexpr double largest_time_step_s = 1.0;
constexpr int max_friction_passes = 3;
constexpr double trial_share = 1e-3;       // of a sample spacing: below, directions have not changed
constexpr double arrived_m = 1e-6;         // an event this close to the balance, or trial_share, is no stop
constexpr int max_halvings = 6;            // of a move that would raise the spring's energy
constexpr double rest_share = 0.02;        // of a sample spacing: a move shortened below this is rest
constexpr double rounding = 1e-12;         // of the directed forces: a change this small is none
constexpr double least_time_share = 1e-6;  // of a sub-step's time: a drag is never posed with none

bool usable(const Vec3& position_m) noexcept {
  return is_finite(position_m) && largest_component(position_m) <= largest_probe_m;
}

// A piece of the probe's path that still has to be walked.
struct Waypoint {
  Vec3 position_m;
  double time_s = 0.0;
};

// The part of the proxy's motion that is more than the probe's: a release, no motion of the hand.
Vec3 released(const Vec3& step_m, double probe_step_m) noexcept {
  const double length = norm(step_m);
  return length > probe_step_m ? (1.0 - probe_step_m / length) * step_m : Vec3{};
}

// A directed force as the last sub-step had it.
struct HeldForce {
  PrimitiveId id;
  Vec3 force_n;
};

// What one mode needs besides itself.
struct Part {
  std::size_t memory = 0;            // offset in the memories
  std::vector<std::int32_t> fields;  // all that it reads
  Captured standing;                 // the level that its plane carried in the last sub-step
  bool through = false;              // that plane was pressed through
  std::uint32_t faults = 0;          // refusals already told, a bit each
  bool held_back = false;            // told that a directed force of it changes too fast
};

// Finds every field that a mode reads, and gives its references their numbers: those of the scene's
// volumes, then what is derived from them, once each, behind.
class Resolver final : public ParameterVisitor {
 public:
  Resolver(const Scene& scene, std::vector<FieldPtr>& all, std::vector<std::int32_t>& fields, std::vector<Watch>& watches)
      : scene_(scene), all_(all), fields_(fields), watches_(watches) {}

  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (ref.name.empty()) return;
    resolve(ref, info.felt);
    if (info.name == "field") main_field_ = ref.index;
  }
  void strength(const ParameterInfo&, Strength& strength) override {
    if (strength.is_constant()) return;
    resolve(strength.of);
    watch(strength.of, strength.curve);
  }
  void number(const ParameterInfo& info, double& value) override {
    if (info.kind == ParameterKind::level) watches_.push_back({main_field_, value});
  }
  void list(const ParameterInfo&, ParameterList& list) override {
    for (std::size_t i = 0; i < list.size(); ++i) list.visit(i, *this);
  }
  void mask(Mask& mask) {
    resolve(mask.of);
    watch(mask.of, mask.curve);
  }

 private:
  void resolve(FieldRef& ref, std::optional<Derivation> felt = {}) {
    ref.index = felt ? -1 : scene_.index_of(ref);
    if (ref.index < 0) {
      const FieldPtr field = felt ? scene_.field(ref, *felt) : scene_.field(ref).field;
      const auto found = std::find(all_.begin(), all_.end(), field);
      ref.index = static_cast<std::int32_t>(found - all_.begin());
      if (found == all_.end()) all_.push_back(field);
    }
    if (std::find(fields_.begin(), fields_.end(), ref.index) == fields_.end()) fields_.push_back(ref.index);
  }
  // A strength can set in, or jump, only at its points.
  void watch(const FieldRef& ref, const TransferFunction& curve) {
    for (const TransferFunction::Point& point : curve.points()) watches_.push_back({ref.index, point.value});
  }

  const Scene& scene_;
  std::vector<FieldPtr>& all_;
  std::vector<std::int32_t>& fields_;
  std::vector<Watch>& watches_;
  std::int32_t main_field_ = -1;
};

}  // namespace

const char* name_of(TickStatus status) noexcept {
  switch (status) {
    case TickStatus::resting: return "resting";
    case TickStatus::waiting: return "waiting";
    case TickStatus::capped: return "capped";
    case TickStatus::bad_input: return "bad_input";
  }
  return "?";
}

const char* name_of(Stop stop) noexcept {
  switch (stop) {
    case Stop::full: return "full";
    case Stop::event: return "event";
    case Stop::release: return "release";
    case Stop::energy: return "energy";
    case Stop::cap: return "cap";
  }
  return "?";
}

const char* name_of(SessionEventKind kind) noexcept {
  switch (kind) {
    case SessionEventKind::onset: return "onset";
    case SessionEventKind::break_through: return "break_through";
    case SessionEventKind::fault: return "fault";
    case SessionEventKind::warning: return "warning";
  }
  return "?";
}

class Session::State {
 public:
  State(const Scene& given, std::unique_ptr<Law> given_law, double encoder_step_m)
      : scene(given),
        map(scene.hand_to_world()),
        law(std::move(given_law)),
        damper(scene.coupling.damping_ns_per_m, encoder_step_m),
        ledger(scene.modes().size()),
        primitives(max_primitives) {
    scene.check();
    if (!is_usable(map))
      throw SceneError("workspace: the map from the hand to the world is not a similarity; give a positive scale");
    for (const SceneVolume& volume : scene.volumes()) {
      for (const VolumeField& field : volume.volume.fields) fields.push_back(field.field);
    }

    std::size_t memory_bytes = 0;
    std::vector<Watch> found;
    std::vector<std::int32_t> active;
    for (const SceneMode& given_mode : scene.modes()) {
      SceneMode mode = given_mode;
      Part part;
      std::vector<Watch> watches_of_mode;
      Resolver resolver(scene, fields, part.fields, watches_of_mode);
      mode.mode.visit(resolver);
      for (Mask& mask : mode.masks) resolver.mask(mask);
      part.memory = memory_bytes;
      memory_bytes += (mode.mode.memory_bytes() + 15) / 16 * 16;
      if (mode.enabled) {
        found.insert(found.end(), watches_of_mode.begin(), watches_of_mode.end());
        active.insert(active.end(), part.fields.begin(), part.fields.end());
      }
      modes.push_back(std::move(mode));
      parts.push_back(std::move(part));
    }
    samples = std::make_unique<Samples>(fields, map);
    memories.resize(memory_bytes);
    watches = Watches(found);

    finest_m = std::numeric_limits<double>::infinity();
    for (const std::int32_t index : active) {
      const Field& field = *fields[static_cast<std::size_t>(index)];
      finest_m = std::min(finest_m, map.length_to_hand(field.spacing_m()));
      active_boxes.push_back(field.bounds_m());
    }
    mode_ticks.resize(modes.size());
    split_n.reserve(max_primitives);
    sub_steps.reserve(max_sub_steps);
    placed.reserve(max_sub_steps * max_primitives);
    events.reserve(max_events);
    slots.reserve(max_primitives);
    held.reserve(max_primitives);
    crossings.reserve(watches.size());
    reset();
  }

  Tick tick(const Probe& probe, double dt) noexcept;
  void reset() noexcept;
  void refine_path(int times);
  void continue_from(const State& other) noexcept;
  std::span<const ModeTick> who_pushed() noexcept;

  Scene scene;
  Similarity map;
  std::vector<SubStep> sub_steps;
  std::vector<PlacedPrimitive> placed;
  std::vector<SessionEvent> events;

 private:
  void walk(Tick& result) noexcept;
  Stop sub_step(const Vec3& probe_m, double time_s, double probe_step_m, double& move_fraction) noexcept;
  double descending_share(const Balance& to, const Vec3& start, const Vec3& probe_m, double share) noexcept;
  void place(const Vec3& start_m, const Vec3& at_m, const Vec3& probe_m, double time_s) noexcept;
  void hold_back_directed(const Vec3& at_m) noexcept;
  void keep_directed() noexcept;
  Balance balance(const Vec3& probe_m, double time_s) noexcept;
  void settle(const Balance& at, const Vec3& probe_m, double time_s) noexcept;
  void tell_contact(const Balance& at) noexcept;
  void record(SubStep step) noexcept;
  void gather(Tick& result) noexcept;
  bool path_meets_data(const Vec3& from_m, const Vec3& to_m) const noexcept;
  Here here_at(std::size_t mode, const Vec3& start_m, const Vec3& probe_m, double time_s) noexcept;
  double longest_step_m() const noexcept { return 0.5 * finest_m / refined; }
  void emit(SessionEvent event) noexcept {
    if (events.size() < max_events) events.push_back(event);
  }

  std::unique_ptr<Law> law;
  Damper damper;
  Ledger ledger;
  PrimitiveSet primitives;
  std::vector<FieldPtr> fields;
  std::unique_ptr<Samples> samples;
  std::vector<SceneMode> modes;  // with their references resolved
  std::vector<Part> parts;
  std::vector<std::byte> memories;
  Watches watches;
  std::vector<Box> active_boxes;  // of the fields that enabled modes read
  std::vector<SlotState> slots;
  std::vector<Crossing> crossings;
  std::vector<ModeTick> mode_ticks;
  bool who_pushed_known = true;  // mode_ticks hold the forces of the last sub-step
  std::vector<Vec3> split_n;     // of the last sub-step, as it is shown
  std::vector<HeldForce> held;   // the directed forces of the last sub-step …
  Vec3 held_at_m;                // … and where they were looked up
  bool holding = false;
  Vec3 placed_at_m;
  double finest_m = 0.0;
  int refined = 1;      // see refine_path
  double path_m = 0.0;  // length of the probe's path in this tick

  bool started = false;
  Vec3 proxy;
  Vec3 walked;  // how far along its path the probe has been followed
  Vec3 last_probe;
  Vec3 released_m;
  int dropped = 0;    // primitives refused in this tick
  Vec3 damper_force;  // held since the last tick
  std::array<Waypoint, max_queued> queue;
  std::size_t queued = 0;
  // A sub-step that was stopped on its way is taken up again at the same probe.
  bool unfinished = false;
  Waypoint unfinished_step;
  double whole_time_s = 0.0;  // of that sub-step, before it was stopped
};

void Session::State::reset() noexcept {
  started = false;
  queued = 0;
  unfinished = false;
  damper_force = {};
  held.clear();
  holding = false;
  law->reset();
  watches.reset();
  for (std::size_t m = 0; m < modes.size(); ++m) {
    modes[m].mode.start(memories.data() + parts[m].memory);
    parts[m].standing = {};
    parts[m].through = false;
  }
}

void Session::State::refine_path(int times) {
  refined = std::clamp(times, 1, most_refined);
  sub_steps.reserve(static_cast<std::size_t>(max_sub_steps * refined));
  placed.reserve(static_cast<std::size_t>(max_sub_steps * refined) * max_primitives);
}

void Session::State::continue_from(const State& other) noexcept {
  assert(modes.size() == other.modes.size() && memories.size() == other.memories.size());
  damper = other.damper;
  std::copy(other.memories.begin(), other.memories.end(), memories.begin());
  for (std::size_t m = 0; m < parts.size(); ++m) {
    parts[m].standing = other.parts[m].standing;
    parts[m].through = other.parts[m].through;
  }
  watches = other.watches;
  held = other.held;
  held_at_m = other.held_at_m;
  holding = other.holding;
  started = other.started;
  proxy = other.proxy;
  walked = other.walked;
  last_probe = other.last_probe;
  damper_force = other.damper_force;
  queue = other.queue;
  queued = other.queued;
  unfinished = other.unfinished;
  unfinished_step = other.unfinished_step;
  whole_time_s = other.whole_time_s;
  law->reset();
}

// The main path. Modes place primitives, the law balances them, the coupling pulls the hand.
Tick Session::State::tick(const Probe& probe, double dt) noexcept {
  sub_steps.clear();
  placed.clear();
  events.clear();
  std::fill(mode_ticks.begin(), mode_ticks.end(), ModeTick{});
  who_pushed_known = true;
  Tick result;
  result.probe_valid = probe.valid;
  result.probe_m = proxy;
  result.proxy_m = proxy;

  const bool time_usable = std::isfinite(dt) && dt > 0.0 && dt <= largest_time_step_s;
  const bool velocity_usable = !probe.velocity_m_per_s || is_finite(*probe.velocity_m_per_s);
  if (!probe.valid) {
    reset();
    if (usable(probe.position_m)) result.probe_m = probe.position_m;
    result.proxy_m = proxy = result.probe_m;
    return result;
  }
  if (!time_usable || !velocity_usable || !usable(probe.position_m)) {
    reset();
    result.status = TickStatus::bad_input;
    return result;
  }

  const Vec3 p = probe.position_m;
  const double k = scene.coupling.stiffness_n_per_m;
  if (!started) {
    started = true;
    proxy = walked = last_probe = p;
    damper.reset({});
    samples->move_to(proxy);
    watches.look(*samples);
  }
  const Vec3 probe_step = p - last_probe;
  ledger.begin(proxy);
  released_m = {};
  dropped = 0;

  if (queued == max_queued) --queued;  // a path this long is no hand's: its last corner is cut
  queue[queued++] = {p, dt};
  path_m = norm(probe_step);
  walk(result);

  result.probe_m = p;
  result.proxy_m = proxy;
  const Vec3 stretch = proxy - p;
  const Vec3 relative = damper.relative_velocity(stretch, released_m, dt, k);
  result.probe_velocity_m_per_s = probe.velocity_m_per_s.value_or(probe_step / dt);
  result.proxy_velocity_m_per_s = result.probe_velocity_m_per_s + relative;
  const Vec3 damping_n = scene.coupling.damping_ns_per_m * relative;
  result.force_n = k * stretch + damping_n;  // Eq. 1

  result.energy = ledger.end(proxy, p, k);
  result.energy.damper_j = dot(damper_force, probe_step);
  damper_force = damping_n;
  last_probe = p;
  gather(result);
  return result;
}

// Follows the probe's path in pieces short enough that nothing in the data is jumped over.
void Session::State::walk(Tick& result) noexcept {
  const bool in_steps = law->walk() == Law::Walk::steps;
  result.status = TickStatus::resting;
  while (queued > 0 || unfinished) {
    if (static_cast<int>(sub_steps.size()) == max_sub_steps * refined) {
      result.status = TickStatus::waiting;
      sub_steps.back().stop = Stop::cap;
      return;
    }
    double probe_step_m = 0.0;
    if (!unfinished) {
      Waypoint& next = queue[0];
      const double length = distance(next.position_m, walked);
      const bool short_steps = in_steps && path_meets_data(walked, next.position_m);
      double longest = short_steps ? longest_step_m() : std::numeric_limits<double>::infinity();
      if (refined > 1 && short_steps) longest = std::min(longest, path_m / refined);
      unfinished_step = next;
      probe_step_m = length;
      if (length > longest) {
        const double share = longest / length;
        unfinished_step = {walked + share * (next.position_m - walked), share * next.time_s};
        next.time_s -= unfinished_step.time_s;
        probe_step_m = longest;
      } else {
        std::copy(queue.begin() + 1, queue.begin() + static_cast<std::ptrdiff_t>(queued), queue.begin());
        --queued;
      }
      walked = unfinished_step.position_m;
      whole_time_s = unfinished_step.time_s;
    }
    const Vec3 before = proxy;
    double move_fraction = 1.0;
    const Stop stop = sub_step(unfinished_step.position_m, unfinished_step.time_s, probe_step_m, move_fraction);
    unfinished = stop == Stop::energy ? distance(proxy, before) > rest_share * finest_m : stop != Stop::full;
    unfinished_step.time_s = std::max(least_time_share * whole_time_s, (1.0 - move_fraction) * unfinished_step.time_s);
  }
}

// One balance along the path: place, balance, move at most h towards it or to the first event, settle.
Stop Session::State::sub_step(const Vec3& probe_m, double time_s, double probe_step_m, double& move_fraction) noexcept {
  const Vec3 start = proxy;
  const bool in_steps = law->walk() == Law::Walk::steps;
  const double longest =
      in_steps && path_meets_data(start, probe_m) ? longest_step_m() : std::numeric_limits<double>::infinity();
  const auto share_of_move = [&](const Balance& to) {
    const double length = distance(to.position_m, start);
    return length > longest ? longest / length : 1.0;
  };

  const bool at_probe = law->placement() == Law::Placement::at_probe;
  place(start, at_probe ? probe_m : start, probe_m, time_s);
  Balance to = balance(probe_m, time_s);
  move_fraction = share_of_move(to);

  // Directions at the middle of the move: a line or plane looked up where the move begins would let the
  // proxy leave every curve on its outside.
  const double moved_m = move_fraction * distance(to.position_m, start);
  if (!primitives.empty() && in_steps && !at_probe && moved_m > trial_share * finest_m) {
    place(start, start + 0.5 * move_fraction * (to.position_m - start), probe_m, time_s);
    to = balance(probe_m, time_s);
    move_fraction = share_of_move(to);
  }

  Stop stop = move_fraction < 1.0 ? Stop::release : Stop::full;
  crossings.clear();
  watches.attend_all();
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const Captured& level = primitives.captured(i);
    if (!level.any() || !(primitives[i].strength_n > 0.0)) continue;
    const PrimitiveState state = state_at(primitives[i], to);
    if (state == PrimitiveState::stick) watches.attend({level.field, level.value}, Watches::Attention::held);
    if (state == PrimitiveState::off) watches.attend({level.field, level.value}, Watches::Attention::leave);
  }
  if (!in_steps) {
    // One step per tick stops nowhere; modes are told afterwards what it went through.
    Vec3 from = start;
    for (std::size_t i = 0; i < watches.size(); ++i) {
      const Watches::Met met = watches.first_crossing(*samples, from, to.position_m, crossings);
      if (!met.stopped) break;
      from += met.share * (to.position_m - from);
    }
  } else {
    const double wanted = move_fraction;
    move_fraction = descending_share(to, start, probe_m, wanted);
    if (move_fraction < wanted) stop = Stop::energy;
    const Vec3 end = move_fraction < 1.0 ? start + move_fraction * (to.position_m - start) : to.position_m;
    const Watches::Met met = watches.first_crossing(*samples, start, end, crossings);
    const double left_m = (1.0 - met.share) * distance(end, start);
    // Where the balance is all but reached, what sets in is placed in the next sub-step anyway; to stop
    // would only divide the rest of the time without end.
    if (met.stopped && left_m > std::min(arrived_m, trial_share * finest_m)) {
      move_fraction *= met.share;
      stop = Stop::event;
    }
  }
  proxy = stop == Stop::full ? to.position_m : start + move_fraction * (to.position_m - start);
  released_m += released(proxy - start, probe_step_m);

  SubStep step;
  step.time_step_s = time_s;
  step.start_m = start;
  step.probe_m = probe_m;
  step.balance = to;
  step.move_fraction = move_fraction;
  step.stop = stop;
  step.proxy_m = proxy;
  record(step);
  keep_directed();
  settle(to, probe_m, time_s);
  return stop;
}

// The share of the move after which the spring has less energy than before, both points put back on the
// level that holds the proxy. In a crease of a surface each side's plane leads into the other side; a
// full move would swing from one to the other for ever, a descending one comes to rest at the bottom.
double Session::State::descending_share(const Balance& to, const Vec3& start, const Vec3& probe_m, double share) noexcept {
  const Captured* level = nullptr;
  Vec3 directed_n;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    if (p.kind == PrimitiveKind::directed) directed_n += p.strength_n * p.direction;
    if (!level && primitives.captured(i).any() && p.strength_n > 0.0 && state_at(p, to) == PrimitiveState::stick) {
      level = &primitives.captured(i);
    }
  }
  const Vec3 move = to.position_m - start;
  if (!level || share * norm(move) <= trial_share * finest_m) return share;
  const double k = scene.coupling.stiffness_n_per_m;
  const auto energy_j = [&](const Vec3& x) {
    samples->move_to(x);
    const ScalarSample& sample = samples->scalar(level->field);
    const double steepness = norm(sample.gradient);
    Vec3 on_level = x;
    if (sample.inside && steepness > 0.0) {
      on_level += std::clamp((level->value - sample.value) / steepness, -finest_m, finest_m) * normalized(sample.gradient);
    }
    return 0.5 * k * norm_squared(on_level - probe_m) - dot(directed_n, on_level - start);
  };
  const double before_j = energy_j(start);
  for (int halving = 0; halving < max_halvings; ++halving, share *= 0.5) {
    if (energy_j(start + share * move) <= before_j) return share;
  }
  return 0.0;
}

Here Session::State::here_at(std::size_t mode, const Vec3& start_m, const Vec3& probe_m, double time_s) noexcept {
  Here here(*samples, modes[mode].masks, parts[mode].fields);
  here.proxy_m = start_m;
  here.probe_m = probe_m;
  here.time_step_s = time_s;
  here.stiffness_n_per_m = scene.coupling.stiffness_n_per_m;
  here.finest_m = finest_m;
  return here;
}

void Session::State::place(const Vec3& start_m, const Vec3& at_m, const Vec3& probe_m, double time_s) noexcept {
  primitives.clear(start_m);
  samples->move_to(at_m);
  for (std::size_t m = 0; m < modes.size(); ++m) {
    if (!modes[m].enabled) continue;
    primitives.begin_mode(static_cast<std::uint16_t>(m));
    modes[m].mode.place(here_at(m, start_m, probe_m, time_s), memories.data() + parts[m].memory, primitives);
  }
  placed_at_m = at_m;
  if (law->walk() == Law::Walk::steps) hold_back_directed(at_m);
}

// A directed force d moves the proxy by d/k, where it is looked up again: with |∂d/∂x| ≥ k the proxy of a
// still hand would jump to and fro for ever. So along the proxy's path all directed forces together change
// by at most k/2 per metre, whatever modes and data say; then every jump is followed by one of at most 7/8 its
// length, trial points included, and a still hand comes to rest.
void Session::State::hold_back_directed(const Vec3& at_m) noexcept {
  if (!holding) return;
  const auto force_of = [&](std::size_t i) { return primitives[i].strength_n * primitives[i].direction; };
  const auto is_placed = [&](const HeldForce& before) {
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      if (primitives[i].kind == PrimitiveKind::directed && primitives[i].id == before.id) return true;
    }
    return false;
  };
  // A mode that has fallen silent wants no force: it is let go along the path like any other.
  for (const HeldForce& before : held) {
    if (before.force_n == Vec3{} || is_placed(before)) continue;
    primitives.begin_mode(before.id.mode);
    primitives.directed(before.id.slot, normalized(before.force_n), 0.0);
  }
  const auto held_force = [&](const PrimitiveId& id) {
    const auto before = std::find_if(held.begin(), held.end(), [&](const HeldForce& h) { return h.id == id; });
    return before == held.end() ? Vec3{} : before->force_n;
  };

  Vec3 change_n;
  double all_n = 0.0;
  double largest_n = 0.0;
  std::uint16_t fastest = 0;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    if (primitives[i].kind != PrimitiveKind::directed) continue;
    const Vec3 one_n = force_of(i) - held_force(primitives[i].id);
    change_n += one_n;
    all_n += primitives[i].strength_n;
    if (norm(one_n) > largest_n) {
      largest_n = norm(one_n);
      fastest = primitives[i].id.mode;
    }
  }
  const double most_n = 0.5 * scene.coupling.stiffness_n_per_m * distance(at_m, held_at_m);
  if (norm(change_n) <= most_n + rounding * all_n) return;

  const double share = most_n / norm(change_n);
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    if (primitives[i].kind != PrimitiveKind::directed) continue;
    const Vec3 before_n = held_force(primitives[i].id);
    primitives.set_directed(i, before_n + share * (force_of(i) - before_n));
  }
  if (parts[fastest].held_back) return;
  parts[fastest].held_back = true;
  emit({SessionEventKind::warning, fastest, 0.0,
        "a directed force changes faster than half the coupling's stiffness and is held back"});
}

void Session::State::keep_directed() noexcept {
  held.clear();
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    if (p.kind == PrimitiveKind::directed) held.push_back({p.id, p.strength_n * p.direction});
  }
  held_at_m = placed_at_m;
  holding = true;
}

// Balances, with Coulomb friction as strong as its plane in this very sub-step: where the plane does
// not feel the friction (same normal) the second pass is exact. Where the plane shares its load with others, its
// force is that of one split of several, the law's, and so is the friction.
Balance Session::State::balance(const Vec3& probe_m, double time_s) noexcept {
  const double k = scene.coupling.stiffness_n_per_m;
  bool has_friction = false;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    if (primitives.friction_of(i).any()) {
      has_friction = true;
      primitives.set_strength(i, 0.0);
    }
  }
  Balance found = law->solve(primitives, primitives.start_m(), probe_m, k, time_s);
  for (int pass = 0; has_friction && pass < max_friction_passes; ++pass) {
    bool changed = false;
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      const Friction& friction = primitives.friction_of(i);
      if (!friction.any()) continue;
      const double strength_n = friction.coefficient * norm(law->forces_n()[static_cast<std::size_t>(friction.plane)]);
      if (std::abs(strength_n - primitives[i].strength_n) <= 1e-12 * strength_n) continue;
      primitives.set_strength(i, strength_n);
      changed = true;
    }
    if (!changed) break;
    const int iterations = found.iterations;
    found = law->solve(primitives, primitives.start_m(), probe_m, k, time_s);
    found.iterations += iterations;
  }
  return found;
}

void Session::State::settle(const Balance& at, const Vec3& probe_m, double time_s) noexcept {
  tell_contact(at);
  samples->move_to(proxy);
  watches.look(*samples);
  for (std::size_t m = 0; m < modes.size(); ++m) {
    if (!modes[m].enabled || modes[m].mode.memory_bytes() == 0) continue;
    slots.clear();
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      if (primitives[i].id.mode == m)
        slots.push_back({primitives[i].id.slot, state_at(primitives[i], at), primitives.captured(i)});
    }
    const Here here = here_at(m, proxy, probe_m, time_s);
    modes[m].mode.settle({here, slots, crossings}, memories.data() + parts[m].memory);
  }
}

// Onsets, break-throughs and refusals, each told once.
void Session::State::tell_contact(const Balance& at) noexcept {
  for (std::size_t m = 0; m < modes.size(); ++m) {
    Part& part = parts[m];
    Captured standing;
    bool through = false;
    for (std::size_t i = 0; i < primitives.size() && !standing.any(); ++i) {
      const Primitive& p = primitives[i];
      if (p.id.mode != m || !primitives.captured(i).any() || !(p.strength_n > 0.0)) continue;
      const PrimitiveState state = state_at(p, at);
      if (state == PrimitiveState::off) continue;
      standing = primitives.captured(i);
      through = state == PrimitiveState::slip;
    }
    const auto mode = static_cast<std::int32_t>(m);
    if (standing.any() && !part.standing.any()) emit({SessionEventKind::onset, mode, standing.value, nullptr});
    if (through && !part.through) emit({SessionEventKind::break_through, mode, standing.value, nullptr});
    part.standing = standing;
    part.through = through;
  }
  for (const Refused& refused : primitives.refused()) {
    Part& part = parts[refused.id.mode];
    const std::uint32_t bit = 1u << static_cast<unsigned>(refused.reason);
    if ((part.faults & bit) == 0) {
      part.faults |= bit;
      emit({SessionEventKind::fault, refused.id.mode, 0.0, sentence_of(refused.reason)});
    }
  }
}

void Session::State::record(SubStep step) noexcept {
  const double k = scene.coupling.stiffness_n_per_m;
  const std::span<const Vec3> forces = law->forces_n();
  const Vec3& position_m = step.balance.position_m;
  double held_n = 0.0;
  step.stiffness_n_per_m = k;
  step.first_primitive = static_cast<std::uint32_t>(placed.size());
  step.primitives = static_cast<std::uint32_t>(primitives.size());
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    placed.push_back({p, primitives.captured(i), forces[i], state_at(p, step.balance)});
    if (p.kind == PrimitiveKind::directed) step.directed_n += forces[i];
    if (placed.back().state == PrimitiveState::stick) held_n += p.strength_n + norm(forces[i]);
    ledger.book(p.id.mode, forces[i], step.proxy_m - step.start_m, {});
  }
  const auto energy_j = [&](const Vec3& x) {
    return 0.5 * k * norm_squared(x - step.probe_m) - dot(step.directed_n, x - step.start_m);
  };
  // The law's bound is about the balance before its position was rounded to what is recorded. Whoever checks
  // the record by the duality gap pays a root for that rounding where the proxy rests on something.
  const double rounding_m =
      0.5 * std::numeric_limits<double>::epsilon() * (std::abs(position_m.x) + std::abs(position_m.y) + std::abs(position_m.z));
  step.balance.error_bound_m += std::sqrt(held_n * rounding_m / k);
  dropped += primitives.dropped();
  step.energy_before_j = energy_j(step.start_m);
  step.energy_after_j = energy_j(step.proxy_m);
  sub_steps.push_back(step);
}

// The tick's totals. Who pushed is worked out when someone asks.
void Session::State::gather(Tick& result) noexcept {
  result.sub_steps = static_cast<int>(sub_steps.size());
  for (const SubStep& step : sub_steps) {
    result.error_bound_m = std::max(result.error_bound_m, step.balance.error_bound_m);
    result.iterations += step.balance.iterations;
    if (step.balance.status == BalanceStatus::capped && result.status == TickStatus::resting)
      result.status = TickStatus::capped;
    if (step.balance.status == BalanceStatus::bad_input) result.status = TickStatus::bad_input;
  }
  result.dropped = dropped;
  for (std::size_t m = 0; m < modes.size(); ++m) {
    const double work_j = ledger.works_j()[m];
    (work_j >= 0.0 ? mode_ticks[m].injected_j : mode_ticks[m].dissipated_j) = std::abs(work_j);
  }
  who_pushed_known = sub_steps.empty();
}

// The modes' forces in the last sub-step, whose primitives are still placed. Where several can hold the same
// load the law's split is one of many, and depends on their order; what is shown is the least one. An earlier
// system's law finds no balance, so its forces are nobody else's to take.
std::span<const ModeTick> Session::State::who_pushed() noexcept {
  if (who_pushed_known) return mode_ticks;
  who_pushed_known = true;
  const SubStep& last = sub_steps.back();
  split_n.clear();
  for (std::size_t i = 0; i < last.primitives; ++i) split_n.push_back(placed[last.first_primitive + i].force_n);
  const bool balanced = last.balance.status == BalanceStatus::exact || last.balance.status == BalanceStatus::capped;
  const bool shared = balanced && split_is_shared(primitives.primitives(), last.balance);
  for (std::size_t i = 0; shared && i < split_n.size(); ++i) {
    ModeTick& mode = mode_ticks[primitives[i].id.mode];
    mode.split_shared = mode.split_shared || is_exchangeable(primitives[i], last.balance);
  }
  if (shared) least_split(primitives.primitives(), last.balance, split_n);
  for (std::size_t i = 0; i < split_n.size(); ++i) {
    ModeTick& mode = mode_ticks[primitives[i].id.mode];
    mode.force_n += split_n[i];
    ++mode.primitives;
  }
  return mode_ticks;
}

// Whether the straight way between two hand positions comes near the data of any active field: boxes
// overlap. Elsewhere there is nothing to jump over.
bool Session::State::path_meets_data(const Vec3& from_m, const Vec3& to_m) const noexcept {
  const Vec3 a = map.to_world(from_m);
  const Vec3 b = map.to_world(to_m);
  for (const Box& box : active_boxes) {
    if (std::max(a.x, b.x) >= box.low_m.x && std::min(a.x, b.x) <= box.high_m.x && std::max(a.y, b.y) >= box.low_m.y &&
        std::min(a.y, b.y) <= box.high_m.y && std::max(a.z, b.z) >= box.low_m.z && std::min(a.z, b.z) <= box.high_m.z) {
      return true;
    }
  }
  return false;
}

Session::Session(const Scene& scene, double encoder_step_m)
    : Session(scene, std::make_unique<Solver>(max_primitives), encoder_step_m) {}

Session::Session(const Scene& scene, std::unique_ptr<Law> law, double encoder_step_m)
    : state_(std::make_unique<State>(scene, std::move(law), encoder_step_m)) {}

Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

Tick Session::tick(const Probe& probe, double time_step_s) noexcept { return state_->tick(probe, time_step_s); }
void Session::reset() noexcept { state_->reset(); }
void Session::refine_path(int times) { state_->refine_path(times); }
void Session::continue_from(const Session& other) noexcept { state_->continue_from(*other.state_); }
const Scene& Session::scene() const noexcept { return state_->scene; }
const Similarity& Session::hand_to_world() const noexcept { return state_->map; }
std::span<const ModeTick> Session::modes() const noexcept { return state_->who_pushed(); }
std::span<const SubStep> Session::sub_steps() const noexcept { return state_->sub_steps; }
std::span<const PlacedPrimitive> Session::placed() const noexcept { return state_->placed; }
std::span<const SessionEvent> Session::events() const noexcept { return state_->events; }

}  // namespace palpa
