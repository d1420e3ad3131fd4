// Every tick of random scenes under random hands, against a tick's promises.
#include <time.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <vector>

#include "palpa/loop/loop.h"
#include "tests/fuzz/campaigns.h"
#include "tests/fuzz/parsers.h"
#include "tests/fuzz/program.h"
#include "tests/fuzz/scenes.h"
#include "tests/laws/balance_formula.h"
#include "tests/solver/counted_allocations.h"

namespace palpa::fuzz {
namespace {

struct Moment {
  Probe probe;
  double time_step_s = 1e-3;
};

/// A hand that moves in pieces, near or far, smoothly or not, with some invalid positions.
class AnyHand {
 public:
  /// \param turns  with an orientation
  AnyHand(Choices& choices, bool turns) : choices_(choices), turns_(turns) {}

  Moment next() {
    if (left_ == 0) begin_stretch();
    --left_;
    const double reach_m = 0.1;
    switch (way_) {
      case Way::straight: position_m_ += step_m_; break;
      case Way::shaking: position_m_ += (left_ % 2 == 0 ? 1.0 : -1.0) * step_m_; break;
      case Way::round: {
        const double turn = 0.01 * static_cast<double>(left_);
        position_m_ = middle_m_ + Vec3{std::cos(turn) * step_m_.x, std::sin(turn) * step_m_.y, std::sin(2 * turn) * step_m_.z};
        break;
      }
      case Way::odd: break;
    }
    if (way_ != Way::odd && largest_component(position_m_) > reach_m) step_m_ = -1.0 * step_m_;
    Moment moment{{.position_m = position_m_}, time_step_s_};
    if (way_ == Way::odd) {
      double* const numbers[] = {&moment.probe.position_m.x, &moment.probe.position_m.y, &moment.probe.position_m.z};
      *choices_.one_of(numbers) = odd_number(choices_, 0.05);
      if (choices_.one_in(3)) moment.time_step_s = odd_number(choices_, 1e-15);
      moment.probe.valid = !choices_.one_in(4);
    }
    if (turns_) turn(moment.probe);
    if (has_velocity_) moment.probe.velocity_m_per_s = step_m_ / time_step_s_;
    if (has_velocity_ && way_ == Way::odd) moment.probe.velocity_m_per_s->y = odd_number(choices_, 1.0);
    return moment;
  }

 private:
  enum class Way { straight, shaking, round, odd };

  void begin_stretch() {
    constexpr std::array ways{Way::straight, Way::straight, Way::straight, Way::round, Way::round, Way::shaking, Way::odd};
    constexpr std::array time_steps_s{1e-3, 1e-3, 1e-3, 1e-4, 2e-3, 0.02, 1.0, 1e-9, 1e-15, 1e-300};
    way_ = choices_.one_of(ways);
    left_ = way_ == Way::odd ? 1 + choices_.below(3) : 1 + choices_.below(300);
    time_step_s_ = choices_.one_in(4) ? choices_.one_of(time_steps_s) : 1e-3;
    has_velocity_ = choices_.one_in(3);
    const auto anywhere = [&](double size_m) {
      const double x = choices_.between(-size_m, size_m), y = choices_.between(-size_m, size_m);
      return Vec3{x, y, choices_.between(-size_m, size_m)};
    };
    if (turns_) {
      turn_step_rad_ = anywhere(choices_.one_in(5) ? choices_.log_between(1e-12, 3.0) : choices_.log_between(1e-5, 5e-2));
      if (choices_.one_in(6)) turn_ = turn_by(anywhere(3.0));
    }
    if (way_ == Way::round) {
      middle_m_ = anywhere(0.05), step_m_ = anywhere(0.05);
    } else {
      step_m_ = anywhere(choices_.one_in(5) ? choices_.log_between(1e-12, 0.05) : choices_.log_between(1e-6, 5e-4));
      if (choices_.one_in(6)) position_m_ = anywhere(0.08);
    }
  }

  // Turns with the way; odd: no rotation at all, hardly one, or of either sign.
  void turn(Probe& probe) {
    if (way_ != Way::odd) turn_ = turned_further(turn_, (way_ == Way::shaking && left_ % 2 == 0 ? -1.0 : 1.0) * turn_step_rad_);
    probe.turn = turn_;
    if (choices_.one_in(16)) probe.turn = {-turn_.w, -turn_.x, -turn_.y, -turn_.z};
    if (way_ != Way::odd) return;
    double* const numbers[] = {&probe.turn.w, &probe.turn.x, &probe.turn.y, &probe.turn.z};
    if (choices_.one_in(2)) *choices_.one_of(numbers) = odd_number(choices_, 1.0);
    if (choices_.one_in(4)) probe.turn = {0.0, 0.0, 0.0, choices_.one_in(2) ? 0.0 : 1.0 + choices_.between(-1e-3, 1e-3)};
  }

  Choices& choices_;
  bool turns_;
  Turn turn_;
  Vec3 turn_step_rad_;
  Way way_ = Way::straight;
  std::uint64_t left_ = 0;
  double time_step_s_ = 1e-3;
  bool has_velocity_ = false;
  Vec3 position_m_, middle_m_, step_m_;
};

/// A hash of a tick's result, to the bit, for the traced quantities.
std::uint64_t mixed(std::uint64_t hash, const TickFrame& frame) {
  const Tick& t = frame.result;
  const std::array numbers{t.proxy_m.x,
                           t.proxy_m.y,
                           t.proxy_m.z,
                           t.force_n.x,
                           t.force_n.y,
                           t.force_n.z,
                           frame.command.force_n.x,
                           frame.command.force_n.y,
                           frame.command.force_n.z,
                           t.error_bound_m,
                           t.energy.stored_j,
                           t.energy.dissipated_j,
                           t.energy.injected_j,
                           t.energy.elastic_j,
                           t.energy.path_and_release_j,
                           t.energy.data_motion_j,
                           t.energy.sampling_j,
                           frame.command.withheld_j,
                           t.torque_nm.x,
                           t.torque_nm.y,
                           t.torque_nm.z,
                           t.proxy_turn.w,
                           frame.command.torque_nm.x};
  for (const double number : numbers) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &number, sizeof bits);
    hash = (hash ^ bits) * 0x100000001B3u;
    hash ^= hash >> 29;
  }
  return hash + static_cast<std::uint64_t>(t.sub_steps) + static_cast<std::uint64_t>(t.status) * 64;
}

bool is_finite_all(const TickFrame& frame) {
  const Energy& e = frame.result.energy;
  return std::isfinite(e.stored_j) && std::isfinite(e.elastic_j) && std::isfinite(e.dissipated_j) &&
         std::isfinite(e.injected_j) && std::isfinite(e.path_and_release_j) && std::isfinite(e.damper_j) &&
         std::isfinite(e.data_motion_j) && std::isfinite(frame.command.work_on_hand_j) && std::isfinite(e.released_j) &&
         std::isfinite(frame.command.withheld_j) && std::isfinite(e.sampling_j) && std::isfinite(e.sampling_bound_j);
}

/// Inputs for which docs/contracts/session.md excludes bad_input.
bool is_usable(const Moment& moment, bool turns) {
  const Probe& probe = moment.probe;
  return probe.valid && is_finite(probe.position_m) && (!probe.velocity_m_per_s || is_finite(*probe.velocity_m_per_s)) &&
         moment.time_step_s > 0.0 && moment.time_step_s <= 1.0 && (!turns || is_unit(probe.turn, 1e-3));
}

const char* broken_by_turning(const Moment& moment, const TickFrame& frame, double max_torque_nm) {
  const Tick& t = frame.result;
  if (!is_finite(frame.command.torque_nm)) return "a commanded torque is finite";
  if (norm(frame.command.torque_nm) > max_torque_nm * (1.0 + 1e-15)) return "a commanded torque is within the limit";
  if (!is_finite(t.torque_nm) || !is_finite(t.probe_turn_step_rad)) return "a torque is finite";
  if (!is_unit(t.proxy_turn, 1e-9)) return "a proxy's turn is a rotation";
  if (!std::isfinite(frame.command.unfelt_j)) return "unfelt work is finite";
  if (t.status == TickStatus::bad_input && t.torque_nm != Vec3{}) return "an unusable probe has no torque";
  return moment.probe.valid || frame.command.torque_nm == Vec3{} ? nullptr : "a hand without a position has no torque";
}

const char* broken_by_tick(const Moment& moment, const TickFrame& frame, double max_force_n, bool turns) {
  const Tick& t = frame.result;
  if (!is_finite(frame.command.force_n)) return "a command is finite";
  if (norm(frame.command.force_n) > max_force_n) return "a command is within the limit";
  if (!is_finite(t.force_n)) return "a force is finite";
  if (!is_finite(t.proxy_m) || !is_finite(t.proxy_velocity_m_per_s)) return "a proxy and its velocity are finite";
  if (!std::isfinite(t.error_bound_m) || t.error_bound_m < 0.0) return "an error bound is finite";
  if (!is_finite_all(frame)) return "an energy is finite";
  if (t.work > 4 * Session::most_work) return "a tick's work is bounded";
  if (t.sub_steps > Session::max_sub_steps) return "there are no more sub-steps than the cap";
  if (t.status == TickStatus::bad_input && is_usable(moment, turns) && largest_component(moment.probe.position_m) < 100.0)
    return "a probe and a time step that can be used are not bad input";
  if (t.status != TickStatus::bad_input && moment.probe.valid && !is_usable(moment, turns))
    return "what cannot be used is bad input";
  return nullptr;
}

/// The force on a proxy that stays while its probe moves on is borne by strengths, but for a hundredth at most. Hostile data
/// may have no balance; then the proxy oscillates.
const char* broken_by_standing(const Tick& before, const Tick& t, double radius_m) {
  constexpr double still_m = 1e-12, still_rad = 1e-10, led_m = 1e-6;
  if (t.status != TickStatus::complete || before.status != TickStatus::complete) return nullptr;
  const bool stands = distance(before.proxy_m, t.proxy_m) <= still_m &&
                      norm(rotation_between_rad(before.proxy_turn, t.proxy_turn)) <= still_rad && norm(t.probe_step_m) > led_m;
  const double pull_n = std::hypot(norm(t.force_n), norm(t.torque_nm) / radius_m);
  return stands && t.unborne_n > 0.01 * pull_n + 1e-3 ? "a proxy that stands is held by strengths" : nullptr;
}

/// A balance of the exact law against the formula of docs/trace.md; empty, or the error.
std::string broken_by_balance(const SubStep& step, std::span<const PlacedPrimitive> placed) {
  if (step.balance.status != BalanceStatus::exact && step.balance.status != BalanceStatus::capped) return {};
  test::BalanceFormula formula(step.balance.position_m, step.probe_m, step.directed_n, step.stiffness_n_per_m,
                               std::max(step.time_step_s, shortest_time_s));
  const bool turns = step.turning_radius_m > 0.0;
  if (turns) formula.turns(step.balance.turn_rad, step.start_turn, step.probe_turn, step.turning_radius_m);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const Primitive& p = placed[i].primitive;
    const double stiffness_n_per_m = p.is_elastic() ? p.stiffness_n_per_m : 0.0;
    if (turns) formula.at_foot(placed[i].lever_m);
    if (p.kind == PrimitiveKind::directed) {
      if (turns) formula.add_directed(placed[i].force_n);
      continue;
    }
    if (p.kind != PrimitiveKind::corner) {
      formula.add(name_of(p.kind), p.position_m, p.direction, p.strength_n, p.drag_ns_per_m, stiffness_n_per_m,
                  placed[i].force_n);
      continue;
    }
    test::Facets facets;
    std::vector<Vec3> forces_n;
    for (; i < placed.size() && placed[i].primitive.kind == PrimitiveKind::corner && placed[i].primitive.id == p.id; ++i) {
      facets.push_back({placed[i].primitive.position_m, placed[i].primitive.direction});
      forces_n.push_back(placed[i].force_n);
    }
    --i;
    formula.add_corner(facets, p.strength_n, stiffness_n_per_m, forces_n);
  }
  const double claimed_m = std::max(step.balance.error_bound_m, exact_bound_m);
  if (formula.bound_m() <= claimed_m + formula.rounding_m()) return {};
  char text[300];
  std::snprintf(text, sizeof text,
                "a balance is within its bound: %.3g m where %.3g m are claimed and %.3g m are rounding; %s in stage %d, %zu "
                "primitives, k = %.3g N/m, T = %.3g s",
                formula.bound_m(), claimed_m, formula.rounding_m(), name_of(step.balance.status), step.balance.stage,
                placed.size(), step.stiffness_n_per_m, step.time_step_s);
  return text;
}

std::string broken_by_balances(const Session& session) {
  for (const SubStep& step : session.sub_steps()) {
    const std::string broken = broken_by_balance(step, session.primitives().subspan(step.first_primitive, step.primitives));
    if (!broken.empty()) return broken;
  }
  return {};
}

double now_s(clockid_t clock) {
  timespec time{};
  ::clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

class AnySession {
 public:
  explicit AnySession(const Scene& scene)
      : session_(scene),
        guarded_(session_, GuardOptions{.max_force_n = max_device_n, .motors = false, .max_torque_nm = max_device_nm}),
        max_force_n_(force_limit_n(scene, max_device_n)),
        max_torque_nm_(torque_limit_nm(scene, max_device_nm)) {}

  TickFrame tick(std::int64_t number, const Moment& moment) {
    return guarded_.tick(number, 1e-3 * static_cast<double>(number), moment.time_step_s, moment.probe);
  }
  const Session& session() const { return session_; }
  double max_force_n() const { return max_force_n_; }
  double max_torque_nm() const { return max_torque_nm_; }

 private:
  static constexpr double max_device_n = 10.0, max_device_nm = 0.4;
  Session session_;
  GuardedSession guarded_;
  double max_force_n_, max_torque_nm_;
};

/// Keeps the scene and the last moments of a failure for inspection.
void keep(const fs::path& folder, const Scene& scene, const std::vector<Moment>& moments, std::uint64_t last) {
  std::ofstream(folder / "scene.toml") << to_toml(scene);
  std::ofstream out(folder / "hand.csv");
  out << std::setprecision(17)
      << "tick,dt_s,probe_x_m,probe_y_m,probe_z_m,probe_velocity_y_m_per_s,probe_valid,turn_w,turn_x,turn_y,turn_z\n";
  for (std::uint64_t n = 0; n <= last; ++n) {
    const Probe& probe = moments[n].probe;
    out << n << ',' << moments[n].time_step_s << ',' << probe.position_m.x << ',' << probe.position_m.y << ','
        << probe.position_m.z << ',' << (probe.velocity_m_per_s ? probe.velocity_m_per_s->y : 0.0) << ',' << probe.valid << ','
        << probe.turn.w << ',' << probe.turn.x << ',' << probe.turn.y << ',' << probe.turn.z << '\n';
  }
}

constexpr std::array earlier_laws{"paper-2005", "ikits-2003", "ikits-2003-sequential", "no-proxy"};

Tried felt(Choices& choices, const fs::path& folder, bool with_tool) {
  std::optional<Scene> scene;
  std::optional<AnySession> first, second;
  bool earlier_law = false;
  try {
    scene = random_scene(choices);
    if (with_tool) set_random_tool(choices, *scene);
    earlier_law = !with_tool && choices.one_in(16);
    if (earlier_law) scene->set_law(choices.one_of(earlier_laws));
    first.emplace(*scene);
  } catch (const LoadError& problem) {
    return {.broken = broken_by_refusal(problem.what()), .tries = 0, .slowest_s = 0.0, .refused = 1};
  } catch (const std::invalid_argument&) {  // refused by the grid's own function, with a message
    return {.tries = 0, .slowest_s = 0.0, .refused = 1};
  }
  // A scene costs as much as ten thousand ticks, and most failures are early.
  const auto ticks = static_cast<std::uint64_t>(choices.log_between(1e3, 2e5));
  AnyHand hand(choices, with_tool);
  const double radius_m = Tool(scene->tool(), scene->coupling()).turning_radius_m();
  std::vector<Moment> moments;
  for (std::uint64_t n = 0; n < ticks; ++n) moments.push_back(hand.next());

  constexpr std::uint64_t balance_in = 64;  // a check costs more than a tick
  // At full budget a hundred ticks cost as much as a long session.
  constexpr std::int64_t most_work = 500'000;
  Tried result{.slowest_s = 0.0};
  std::int64_t work = 0;
  std::uint64_t hash = 0;
  Tick before{.status = TickStatus::bad_input};
  // The thread's own clock costs as much as a tick, except under sanitizers.
  constexpr clockid_t clock = is_sanitized ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC;
  double begin_s = now_s(clock);
  for (std::uint64_t n = 0; n < ticks && work < most_work && result.broken.empty(); ++n) {
    const long allocations = test::allocations;
    const TickFrame frame = first->tick(static_cast<std::int64_t>(n), moments[n]);
    const double end_s = now_s(clock);
    result.slowest_s = std::max(result.slowest_s, end_s - begin_s);
    begin_s = end_s;
    hash = mixed(hash, frame);
    work += frame.result.work;
    result.tries = static_cast<std::int64_t>(n) + 1;
    const char* broken = test::allocations != allocations ? "a tick allocates nothing"
                                                          : broken_by_tick(moments[n], frame, first->max_force_n(), with_tool);
    if (!broken && with_tool) broken = broken_by_turning(moments[n], frame, first->max_torque_nm());
    const char* standing = earlier_law ? nullptr : broken_by_standing(before, frame.result, radius_m);
    before = frame.result;
    if (broken) {
      result.broken = broken;
    } else if (standing) {
      result.broken = standing;
    } else if (n % balance_in == 0 && !earlier_law) {
      result.broken = broken_by_balances(first->session());
      begin_s = now_s(clock);
    }
    if (result.broken.empty()) continue;
    result.broken += ": tick " + std::to_string(n);
    keep(folder, *scene, moments, n);
  }
  if (!result.broken.empty()) return result;
  // A repeated session is equal to the bit. Slow ticks are repeated up to three times: a thread's clock may count a stalled
  // machine.
  constexpr double slow_s = 2e-3 * slowness;
  const bool once_more = choices.one_in(16);
  for (int more = 0; more < 3 && ((more == 0 && once_more) || result.slowest_s >= slow_s); ++more) {
    second.emplace(*scene);
    std::uint64_t again = 0;
    double slowest_s = 0.0;
    begin_s = now_s(CLOCK_THREAD_CPUTIME_ID);
    for (std::uint64_t n = 0; n < static_cast<std::uint64_t>(result.tries); ++n) {
      again = mixed(again, second->tick(static_cast<std::int64_t>(n), moments[n]));
      const double end_s = now_s(CLOCK_THREAD_CPUTIME_ID);
      slowest_s = std::max(slowest_s, end_s - begin_s);
      begin_s = end_s;
    }
    result.slowest_s = std::min(result.slowest_s, slowest_s);
    if (again == hash) continue;
    result.broken = "felt again it is the same to the bit";
    keep(folder, *scene, moments, static_cast<std::uint64_t>(result.tries) - 1);
    break;
  }
  return result;
}

Attempt attempt(bool with_tool) {
  return [with_tool](Choices& choices, const fs::path& folder) { return felt(choices, folder, with_tool); };
}

}  // namespace

void add_ticks(std::vector<Campaign>& to) {
  to.push_back({.name = "ticks",
                .of = "ticks",
                .long_tries = 1'000'000'000,
                .begin = [](const fs::path&) { return attempt(false); },
                .patience_s = 600.0});
  to.push_back({.name = "tool",
                .of = "ticks",
                .long_tries = 10'000'000,
                .begin = [](const fs::path&) { return attempt(true); },
                .patience_s = 600.0});
}

}  // namespace palpa::fuzz
