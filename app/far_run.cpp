// A hand here, its data on another machine: palpa run --data-at and palpa check --data-at.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>

#include "app/access_token.h"
#include "app/commands.h"
#include "app/far_loop.h"
#include "app/live_terminal.h"
#include "app/net_library.h"
#include "app/terminal.h"
#include "palpa/base/load_error.h"
#include "palpa/base/printed.h"
#include "palpa/base/sanitized.h"
#include "palpa/device/blocked_signals.h"
#include "palpa/device/hand.h"
#include "palpa/device/open_device.h"
#include "palpa/device/paced_hand.h"

namespace palpa::app {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

// One way, up to which models are felt well (docs/far.md). More: surfaces come late; less: links of a building are refused.
constexpr double farthest_s = 0.020;
// The link is measured before the first force. Longer: a late begin; shorter: a mean of few messages.
constexpr double measured_s = 1.0;
constexpr auto watch_interval = 20ms;

/// The connection once it is open. Throws LoadError if the first attempt fails.
std::unique_ptr<NetClient> connected(const FarArguments& far, const NetPlace& place, const std::atomic<bool>& stop) {
  const bool has_tls = far.tls || !far.authority.empty();
  if (has_tls && far.datagrams)
    throw LoadError(std::string("--datagrams: are not encrypted, and ") + (far.tls ? "--tls" : "--ca") +
                    " asks for that; leave one out");
  if (!has_tls && !far.unencrypted && !is_loopback(place.host))
    throw LoadError("--data-at " + far.data_at +
                    ": is another machine, and the token would go there unencrypted; use ssh -L and 127.0.0.1, add " +
                    (far.datagrams ? "" : "--tls, or ") + "--unencrypted");
  const detail::BlockedSignals on_its_thread;
  auto client = net().connect({.host = place.host,
                               .port = place.port,
                               .has_tls = has_tls,
                               .authority = far.authority,
                               .may_be_lost = far.datagrams ? may_be_lost : nullptr});
  while (client->connection() == 0 && !stop) {
    if (const NetClient::Problem problem = client->problem(); !problem.words.empty()) throw LoadError(problem.words);
    std::this_thread::sleep_for(1ms);
  }
  return client;
}

/// The hand's device: real, or a simulated or recorded hand on the real clock.
struct FarHand {
  std::unique_ptr<Device> device;
  std::unique_ptr<SimulatedDevice> hand;
  double duration_s = std::numeric_limits<double>::infinity();
};

FarHand far_hand(const RunOptions& options) {
  FarHand made;
  if (options.hand.empty()) {
    if (options.device.empty())
      throw LoadError(
          "hand: none was named; give --device NAME, or --hand a recording or sim:press|stroke|circle|helix|random");
    made.device = open_device(device_description(options.device));
    made.duration_s = options.duration_s.value_or(made.duration_s);
    return made;
  }
  if (!options.scene.empty()) {
    PreparedRun prepared = prepare(options);
    made.hand = std::move(prepared.hand);
    made.duration_s = prepared.duration_s;
  } else {
    made.hand = open_hand(options.hand, options.hold, options.recording,
                          options.device.empty() ? DevicePlant{} : device_plant(options.device));
    constexpr double endless_s = 10.0;  // of a hand without an end, as in a run
    const double hand_s = made.hand->duration_s();
    made.duration_s = options.duration_s.value_or(std::isfinite(hand_s) ? hand_s : endless_s);
  }
  made.device = std::make_unique<PacedHand>(*made.hand);
  return made;
}

/// Throws LoadError for what only the data's side can do.
void expect_no_data(const RunArguments& given) {
  const RunOptions& options = given.options;
  if (given.hands.size() + given.devices.size() > 0)
    throw LoadError("run: --data-at feels with one hand; begin another palpa run for the next");
  if (!options.out.empty() || options.primitives)
    throw LoadError("run: the trace is where the data are; give --out and --primitives to palpa serve");
  if (!options.scene_options.sets.empty() || !options.plugins.empty())
    throw LoadError("run: the scene is where the data are; give --set and --plugin to palpa serve");
  if (given.dry_run) throw LoadError("run: --dry-run is of a scene; with --data-at try palpa check --data-at");
  if (!(options.rate_hz >= 100.0 && options.rate_hz <= 20000.0))
    throw LoadError(
        detail::text("rate: %g Hz cannot be kept; a rate in real time lies between 100 and 20000 Hz", options.rate_hz));
  if (options.duration_s && !(*options.duration_s > 0.0))
    throw LoadError(detail::text("duration: %g s cannot be used; it is above 0", *options.duration_s));
}

/// Loop on a thread of its own.
class LoopThread {
 public:
  explicit LoopThread(FarLoop& loop) : loop_(loop) {
    const detail::BlockedSignals in_the_loop;
    thread_ = std::thread([this] {
      const RealTimeThread real_time;
      refused_ = real_time.refused();
      loop_.run(ends_);
      has_ended_ = true;
    });
  }
  ~LoopThread() { end(); }
  LoopThread(const LoopThread&) = delete;
  LoopThread& operator=(const LoopThread&) = delete;

  bool has_ended() const noexcept { return has_ended_; }
  void end() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }
  /// After `end`.
  const std::vector<std::string>& refused() const noexcept { return refused_; }

 private:
  FarLoop& loop_;
  std::atomic<bool> ends_{false}, has_ended_{false};
  std::vector<std::string> refused_;
  std::thread thread_;
};

std::string format_guard(const FarView& view) {
  const HandTick& felt = view.tick;
  std::string words = name_of(felt.guard);
  if (view.device_fault != nullptr) return detail::shortened(words + ": " + detail::sanitized(view.device_fault), 100);
  if (felt.cause != GuardCause::none && felt.guard != GuardState::ramp) words += std::string(": ") + format_cause(felt.cause);
  return words;
}

/// Watches a loop: line, keys, changes of the link, and its length before the first force.
class Watching {
 public:
  Watching(FarLoop& loop, NetClient& client, const FarArguments& far)
      : loop_(loop), client_(client), asked_datagrams_(far.datagrams), has_measured_(far.far_anyway) {
    loop_.hold(!far.far_anyway);
  }

  /// False: q was pressed. Throws LoadError if the server refused, or the link is too long.
  bool watch() {
    view_ = loop_.latest();
    if (const NetClient::Problem problem = client_.problem(); problem.is_final) throw LoadError(problem.words);
    tell_change();
    measure();
    return terminal_.watch([&] { return line(); },
                           [&](char key) {
                             if (key == ' ') loop_.panic(is_held_ = !is_held_);
                           });
  }

 private:
  void tell_change() {
    if (const char* const fault = view_.device_fault; fault != fault_) {
      tell(detail::text("%.1f s  device: %s\n", view_.t_s, fault != nullptr ? fault : "its fault is over"));
      fault_ = fault;
    }
    const LinkState now = view_.tick.link;
    if (now == last_) return;
    if (last_ == LinkState::up || now == LinkState::up) {
      std::string words = detail::text("%.1f s  link %s", view_.t_s, name_of(now));
      if (now == LinkState::closed) words += ": " + client_.problem().words;
      if (now == LinkState::stale) words += ": the newest model is too old, no force";
      tell(words + "\n");
    }
    last_ = now;
  }
  void measure() {
    if (has_measured_ || view_.tick.link != LinkState::up) return;
    if (up_since_s_ < 0.0) up_since_s_ = view_.t_s;
    if (view_.t_s - up_since_s_ < measured_s) return;
    has_measured_ = true;
    const double away_s = 0.5 * view_.tick.round_trip_s;
    if (away_s > farthest_s)
      throw LoadError(
          detail::text("link: the data are %.0f ms away, and models are felt late beyond %.0f ms; feel them nearer, or "
                       "add --far-anyway",
                       1e3 * away_s, 1e3 * farthest_s));
    loop_.hold(false);
  }
  const char* way() const {
    if (!asked_datagrams_) return "";
    return client_.is_by_datagrams() ? " by datagrams" : " by WebSocket";
  }
  std::string line() const {
    const HandTick& felt = view_.tick;
    return detail::text("%.1f s  %4.2f N  %.1f ms away, model %.0f ms old  link %s%s  late p99 %.0f us  missed %lld  %s",
                        view_.t_s, norm(felt.command_n), 0.5e3 * felt.round_trip_s, 1e3 * felt.model_age_s, name_of(felt.link),
                        way(), loop_.totals().late.percentile_us(0.99), static_cast<long long>(view_.missed),
                        format_guard(view_).c_str());
  }

  FarLoop& loop_;
  NetClient& client_;
  LiveTerminal terminal_{"Keys: space turns the force off and on, q ends."};
  FarView view_;
  LinkState last_ = LinkState::waiting;
  const char* fault_ = nullptr;
  double up_since_s_ = -1.0;
  const bool asked_datagrams_;
  bool has_measured_, is_held_ = false;
};

Json summary_of(const FarLoop& loop, const NetClient& client, double rate_hz) {
  const FarTotals& t = loop.totals();
  const double felt_s = std::max(t.felt_s, 1e-3), up = static_cast<double>(std::max<std::int64_t>(1, t.up));
  return {{"duration_s", t.felt_s},
          {"rate_hz", rate_hz},
          {"ticks", t.ticks},
          {"missed", t.missed},
          {"late_p99_us", t.late.percentile_us(0.99)},
          {"late_max_us", t.late.max_us()},
          {"models", t.models},
          {"models_per_s", static_cast<double>(t.models) / felt_s},
          {"round_trip_ms", 1e3 * t.round_trips_s / up},
          {"model_age_mean_ms", 1e-3 * t.age.mean_us()},
          {"model_age_p99_ms", 1e-3 * t.age.percentile_us(0.99)},
          {"beyond_ticks", t.beyond},
          {"link_up_ticks", t.up},
          {"outages", t.outages},
          {"longest_outage_s", t.longest_outage_s},
          {"largest_command_n", t.largest_command_n},
          {"work_on_hand_j", t.work_j},
          {"stored_j", t.stored_j},
          {"sampling_j", t.sampling_j},
          {"model_j", t.model_j},
          {"link_j", t.link_j},
          {"released_j", t.released_j},
          {"largest_debt_j", std::max(0.0, -t.least_account_j)},
          {"sent_bytes_per_s", static_cast<double>(client.sent_bytes()) / felt_s},
          {"received_bytes_per_s", static_cast<double>(client.received_bytes()) / felt_s},
          {"sent_datagrams", client.sent_datagrams()},
          {"received_datagrams", client.received_datagrams()}};
}

void print_summary(const Json& s) {
  const auto number = [&](const char* key) { return s[key].get<double>(); };
  print(detail::text("felt      %.1f s at %g Hz: %.0f ticks, %.0f missed, late p99 %.0f us, max %.0f us\n",
                     number("duration_s"), number("rate_hz"), number("ticks"), number("missed"), number("late_p99_us"),
                     number("late_max_us")));
  print(detail::text("link      %.1f ms round trip; %.0f models, %.0f a second, %.1f ms old (p99 %.1f)\n",
                     number("round_trip_ms"), number("models"), number("models_per_s"), number("model_age_mean_ms"),
                     number("model_age_p99_ms")));
  print(detail::text("bytes     %.1f kB/s sent, %.1f kB/s received\n", 1e-3 * number("sent_bytes_per_s"),
                     1e-3 * number("received_bytes_per_s")));
  if (number("sent_datagrams") + number("received_datagrams") > 0.0)
    print(detail::text("datagrams %.0f sent, %.0f received\n", number("sent_datagrams"), number("received_datagrams")));
  print(detail::text("outages   %.0f, the longest %.2f s\n", number("outages"), number("longest_outage_s")));
  print(
      detail::text("energy    %.2f mJ on the hand by the spring: %.2f model, %.2f link, %.2f sampling, less %.2f stored, %.2f "
                   "released; debt at most %.2f\n",
                   1e3 * number("work_on_hand_j"), 1e3 * number("model_j"), 1e3 * number("link_j"), 1e3 * number("sampling_j"),
                   1e3 * number("stored_j"), 1e3 * number("released_j"), 1e3 * number("largest_debt_j")));
  print(detail::text("command   at most %.3f N\n", number("largest_command_n")));
}

/// Rests in the middle of the workspace.
class StillHand final : public Device {
 public:
  std::string name() const override { return "still"; }
  DeviceLimits limits() const override { return {}; }
  DeviceState read() noexcept override { return {.position_m = {}, .valid = true}; }
  bool write(const Vec3&) noexcept override { return true; }
  bool rests() const noexcept override { return true; }
};

HandSideOptions side_options(const Device& device, const AccessToken& token, const RunOptions& options) {
  HandSideOptions made{.device = device.limits(), .motors = true, .token = token};
  if (options.live) made.dead_man_buttons = options.live->dead_man_buttons;
  const std::string& name = !options.hand.empty() ? options.hand : !options.device.empty() ? options.device : "check";
  // Without settings, which are none of the other machine's business, or the folders of a recording.
  const std::string word = name.substr(name.find_last_of('/') + 1);
  std::ranges::copy_n(word.begin(), static_cast<std::ptrdiff_t>(std::min({word.find(','), word.size(), made.name.size()})),
                      made.name.begin());
  return made;
}

}  // namespace

int run_far(const RunArguments& arguments, const std::atomic<bool>& stop) {
  const RunOptions& options = arguments.options;
  expect_no_data(arguments);
  const NetPlace place = net_place(arguments.far.data_at);
  FarLoopOptions loop_options{.rate_hz = options.rate_hz};
  if (!arguments.far.link.empty()) loop_options.link = link_options(arguments.far.link);
  const AccessToken token = token_for(arguments.far.token);
  const FarHand hand = far_hand(options);
  loop_options.duration_s = hand.duration_s;
  loop_options.grip = {.workspace_radius_m = hand.device->limits().workspace_radius_m,
                       .clutch_buttons = options.live->clutch_buttons,
                       .goes_on_at_border = options.live->goes_on_at_border};
  const std::unique_ptr<NetClient> client = connected(arguments.far, place, stop);
  FarLoop loop(*hand.device, *client, side_options(*hand.device, token, options), loop_options);
  std::vector<std::string> refused;
  {
    LoopThread thread(loop);
    Watching watching(loop, *client, arguments.far);
    while (!thread.has_ended() && !stop && watching.watch()) std::this_thread::sleep_for(watch_interval);
    thread.end();
    refused = thread.refused();
  }
  // A loop that ended by itself may have been refused in its last moments.
  if (const NetClient::Problem problem = client->problem(); problem.is_final) throw LoadError(problem.words);
  print_warnings(refused);
  const Json summary = summary_of(loop, *client, options.rate_hz);
  if (arguments.json)
    print(summary.dump(2) + "\n");
  else
    print_summary(summary);
  return 0;
}

int check_link(const FarArguments& arguments, bool as_json, const std::atomic<bool>& stop) {
  const NetPlace place = net_place(arguments.data_at);
  const AccessToken token = token_for(arguments.token);
  const std::unique_ptr<NetClient> client = connected(arguments, place, stop);
  StillHand device;
  constexpr double duration_s = 3.0;
  FarLoop loop(device, *client, side_options(device, token, {}), {.rate_hz = 1000.0, .duration_s = duration_s});
  {
    LoopThread thread(loop);
    while (!thread.has_ended() && !stop && !client->problem().is_final) std::this_thread::sleep_for(watch_interval);
  }
  if (const NetClient::Problem problem = client->problem(); problem.is_final) throw LoadError(problem.words);
  const FarTotals& t = loop.totals();
  const double away_s = t.up > 0 ? 0.5 * t.round_trips_s / static_cast<double>(t.up) : std::numeric_limits<double>::infinity();
  constexpr double not_at_all_s = 0.1;  // one way. More: contacts come after the hand has passed them
  const char* const answer = away_s <= farthest_s ? "models" : away_s <= not_at_all_s ? "windows" : "not";
  if (as_json) {
    Json json{{"answer", answer}, {"models", t.models}, {"model_age_max_ms", 1e-3 * t.age.max_us()}};
    json["away_ms"] = t.up > 0 ? Json(1e3 * away_s) : Json(nullptr);
    print(json.dump(2) + "\n");
  } else if (t.up == 0) {
    print("not: no model came within 3 s\n");
  } else {
    const std::string measured =
        detail::text("%.1f ms away, models at most %.0f ms old\n", 1e3 * away_s, 1e-3 * t.age.max_us());
    const char* const advice = away_s <= farthest_s     ? "models: "
                               : away_s <= not_at_all_s ? "windows of voxels, not models (or run --far-anyway): "
                                                        : "not: ";
    print(advice + measured);
  }
  return away_s <= farthest_s ? 0 : 1;
}

}  // namespace palpa::app
