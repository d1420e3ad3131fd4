// palpa serve: data for hands on other machines, and for viewers.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>

#include "app/access_token.h"
#include "app/commands.h"
#include "app/hand_trace.h"
#include "app/igtl_view.h"
#include "app/live_terminal.h"
#include "app/net_library.h"
#include "app/terminal.h"
#include "palpa/base/load_error.h"
#include "palpa/base/printed.h"
#include "palpa/base/sanitized.h"
#include "palpa/device/blocked_signals.h"
#include "palpa/mode/plugin.h"
#include "palpa/serve/data_side.h"

namespace palpa::app {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr std::size_t most_hands = 4;       // [1] more: a machine's cores do not suffice for their sessions
constexpr std::size_t most_viewers = 16;    // [1] more: views take the cores of hands
constexpr auto view_interval = 16ms;        // of a viewer. Longer: it jerks; shorter: more work
constexpr auto watch_interval = 20ms;       // of the terminal
constexpr double status_interval_s = 10.0;  // without a terminal. Longer: later; shorter: a longer log

double now_s() { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); }

Json json_of(const Vec3& v) { return {v.x, v.y, v.z}; }

/// Forces and links of all hands, for status and viewers. Any thread.
class FarHands {
 public:
  void post(int hand, const std::string& name, const DataSideFacts& facts, const char* way) {
    const std::lock_guard lock(mutex_);
    Hand& its = hands_[hand];
    its.name = name;
    its.way = way;
    const double now = now_s();
    if (its.since_s == 0.0) its.since_s = now, its.models_then = facts.models;
    if (now - its.since_s >= 1.0) {
      its.models_per_s = static_cast<double>(facts.models - its.models_then) / (now - its.since_s);
      its.since_s = now, its.models_then = facts.models;
    }
    its.facts = facts;
  }
  void leave(int hand) {
    const std::lock_guard lock(mutex_);
    hands_.erase(hand);
  }
  /// A line for each hand.
  std::vector<std::string> lines() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> lines;
    for (const auto& [number, hand] : hands_) {
      const ProbeReport& felt = hand.facts.felt;
      std::string guard = name_of(felt.guard);
      if (felt.cause != GuardCause::none) guard += std::string(" (") + name_of(felt.cause) + ")";
      lines.push_back(detail::text("hand %d  %s  %.1f ms away%s, %.1f %% lost, model %.0f ms old, %.0f a second, guard %s",
                                   number, hand.name.c_str(), 0.5e3 * hand.facts.round_trip_s, hand.way,
                                   100.0 * hand.facts.lost, 1e3 * felt.model_age_s, hand.models_per_s, guard.c_str()));
    }
    return lines;
  }
  std::string json(const std::string& scene) const {
    Json hands = Json::array();
    {
      const std::lock_guard lock(mutex_);
      for (const auto& [number, hand] : hands_) {
        const ProbeReport& felt = hand.facts.felt;
        const Tick& tick = hand.facts.frame.result;
        hands.push_back({{"hand", number},
                         {"name", hand.name},
                         {"probe_m", json_of(tick.probe_m)},
                         {"proxy_m", json_of(tick.proxy_m)},
                         {"force_n", json_of(tick.force_n)},
                         {"felt_n", json_of(felt.command_n)},
                         {"guard", name_of(felt.guard)},
                         {"cause", name_of(felt.cause)},
                         {"away_ms", 0.5e3 * hand.facts.round_trip_s},
                         {"lost", hand.facts.lost},
                         {"model_age_ms", 1e3 * felt.model_age_s},
                         {"models_per_s", hand.models_per_s}});
      }
    }
    return Json{{"scene", scene}, {"hands", hands}}.dump(-1, ' ', false, Json::error_handler_t::replace);
  }

 private:
  struct Hand {
    std::string name;
    DataSideFacts facts;
    double since_s = 0.0, models_per_s = 0.0;  // the rate is that of the last second
    std::int64_t models_then = 0;
    const char* way = "";  // of probes and models, a literal
  };
  mutable std::mutex mutex_;
  std::map<int, Hand> hands_;
};

/// Lines from other threads for the terminal's.
class Lines {
 public:
  void add(std::string line) {
    const std::lock_guard lock(mutex_);
    lines_.push_back(std::move(line));
  }
  std::vector<std::string> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(lines_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> lines_;
};

/// One of a bounded number of places, until destruction.
class Place {
 public:
  /// Throws LoadError if all are taken.
  Place(std::atomic<std::size_t>& taken, std::size_t most, const char* of) : taken_(taken) {
    if (taken_.fetch_add(1) < most) return;
    taken_.fetch_sub(1);
    throw LoadError(detail::text("there are %zu %s already; one of them has to go first", most, of));
  }
  ~Place() { taken_.fetch_sub(1); }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;

 private:
  std::atomic<std::size_t>& taken_;
};

/// Far hands in a view for OpenIGTLink, each at the first place that is free. Any thread.
class ViewedHands {
 public:
  explicit ViewedHands(IgtlView& view) : view_(view) {}
  std::size_t take_place() {
    const std::lock_guard lock(mutex_);
    const auto free = std::ranges::find(taken_, false);
    if (free == taken_.end()) return taken_.size();  // not seen
    *free = true;
    return static_cast<std::size_t>(free - taken_.begin());
  }
  void leave(std::size_t place) {
    const std::lock_guard lock(mutex_);
    view_.leave(place);
    if (place < taken_.size()) taken_[place] = false;
  }
  /// With the guard's state as the hand reports it.
  void tick(std::size_t place, TickFrame frame, const Session& felt, const ProbeReport& report) {
    frame.command.guard = report.guard;
    frame.command.cause = report.cause;
    view_.tick(place, frame, felt);
  }

 private:
  IgtlView& view_;
  std::mutex mutex_;
  std::array<bool, most_hands> taken_{};
};

/// State common to all connections; outlives the server.
struct House {
  const ServeArguments& arguments;
  const LoadedScene loaded;
  const AccessTokens tokens;
  FarHands felt{};
  Lines lines{};
  std::atomic<std::size_t> hands{0}, viewers{0};
  std::atomic<int> last_hand{0};
  std::optional<ViewedHands> viewed{};
};

/// Name of the hand's device, of any origin.
std::string name_of(const HandHello& hello) {
  const std::string name(hello.name.begin(), std::ranges::find(hello.name, '\0'));
  return name.empty() ? "unnamed" : detail::sanitized(name);
}

/// A hand on another machine: a session of its own.
class FarHandUser final : public NetUser {
 public:
  FarHandUser(House& house, const HandHello& hello, std::span<const std::byte> message)
      : house_(house), place_(house.hands, most_hands, "hands"), number_(++house.last_hand), name_(name_of(hello)) {
    const DeviceLimits limits{.max_force_n = hello.max_force_n,
                              .max_stiffness_n_per_m = hello.max_stiffness_n_per_m,
                              .encoder_step_m = hello.encoder_step_m,
                              .max_damping_ns_per_m = hello.max_damping_ns_per_m};
    if (!house.arguments.options.out.empty()) trace_.emplace(house.arguments.options, house.loaded, limits, number_);
    data_.emplace(house.loaded.scene);
    if (house.viewed) view_place_ = house.viewed->take_place();
    data_->record(trace_ ? trace_->recorder() : nullptr,
                  [this](const TickFrame& frame, const Session& felt, const ProbeReport& report) {
                    if (trace_) trace_->add(frame, report);
                    if (house_.viewed) house_.viewed->tick(view_place_, frame, felt, report);
                  });
    if (!data_->take(message, now_s())) throw LoadError("the hello cannot be used; palpa run --data-at sends one that can");
    house_.lines.add(detail::text("hand %d  %s comes, with up to %g N", number_, name_.c_str(), hello.max_force_n));
  }
  ~FarHandUser() override {
    house_.felt.leave(number_);
    if (house_.viewed) house_.viewed->leave(view_place_);
    std::string words = detail::text("hand %d  %s has gone", number_, name_.c_str());
    if (data_) words += detail::text(", after %lld samples", static_cast<long long>(data_->facts().samples));
    if (trace_) {
      data_.reset();
      if (const std::string problem = trace_->finish(); !problem.empty()) words += ": " + problem;
    }
    house_.lines.add(words);
  }
  std::string take(std::span<const std::byte> message) override {
    ProbeReport unused;
    // A late report is no fault.
    if (!data_->take(message, now_s()) && !read_message(message, unused)) return "a message that is none of a hand's";
    house_.felt.post(number_, name_, data_->facts(), way());
    return {};
  }
  bool may_be_lost(std::span<const std::byte> message) const noexcept override { return app::may_be_lost(message); }
  void set_by_datagrams(bool are_used) override { is_by_datagrams_ = are_used; }
  std::size_t give(std::span<std::byte> to) override { return data_->give(to, now_s()); }

 private:
  const char* way() const {
    if (!house_.arguments.datagrams) return "";
    return is_by_datagrams_ ? " by datagrams" : " by WebSocket";
  }

  House& house_;
  const Place place_;
  const int number_;
  const std::string name_;
  std::size_t view_place_ = most_hands;
  bool is_by_datagrams_ = false;
  std::optional<HandTrace> trace_;
  std::optional<DataSide> data_;
};

class ViewerUser final : public NetUser {
 public:
  explicit ViewerUser(House& house) : house_(house), place_(house.viewers, most_viewers, "viewers") {}
  std::string take(std::span<const std::byte>) override { return "a message of a viewer; it only watches"; }
  std::size_t give(std::span<std::byte> to) override {
    const Clock::time_point now = Clock::now();
    if (now < next_) return 0;
    const std::string view = house_.felt.json(house_.loaded.scene.title);
    if (view.size() > to.size()) return 0;
    next_ = now + view_interval;
    std::ranges::copy(std::as_bytes(std::span(view)), to.begin());
    return view.size();
  }
  bool gives_text() const noexcept override { return true; }

 private:
  House& house_;
  const Place place_;
  Clock::time_point next_{};
};

class Service final : public NetService {
 public:
  explicit Service(House& house) : house_(house) {}
  std::unique_ptr<NetUser> admit(std::span<const std::byte> first_message) override {
    HandHello hello;
    if (!read_message(first_message, hello))
      throw LoadError("the first message is no hello of this version; both sides need one version of palpa");
    const bool touches = are_equal(hello.token, house_.tokens.touch), watches = are_equal(hello.token, house_.tokens.watch);
    if (hello.role == HandHello::Role::watch) {
      if (!touches && !watches) throw LoadError("the token is not one of these; take it from where palpa serve was begun");
      return std::make_unique<ViewerUser>(house_);
    }
    if (!touches)
      throw LoadError(watches ? "the token is that of viewers; a hand needs the one for touch"
                              : "the token is not that for touch; take it from where palpa serve was begun");
    return std::make_unique<FarHandUser>(house_, hello, first_message);
  }
  void report(const std::string& line) override { house_.lines.add(line); }

 private:
  House& house_;
};

/// Throws LoadError where other machines could come in without what that needs.
void check_openness(const ServeArguments& given) {
  const bool has_tls = !given.certificate.empty();
  if (has_tls && given.unencrypted) throw LoadError("--unencrypted: contradicts --tls; leave one out");
  if (has_tls && given.datagrams) throw LoadError("--datagrams: are not encrypted, and --tls asks for that; leave one out");
  if (is_loopback(given.listen)) return;
  const std::string place = "--listen " + given.listen + ": lets other machines in";
  if (given.token_file.empty()) throw LoadError(place + "; add --token-file FILE, which only you can read");
  if (given.datagrams && !given.unencrypted)
    throw LoadError("--datagrams: are not encrypted, and --listen " + given.listen +
                    " lets other machines in; add --unencrypted, or leave them out");
  if (!has_tls && !given.unencrypted) throw LoadError(place + "; add --tls CERT KEY, or the word --unencrypted");
}

/// Throws LoadError if there is something by that name.
void expect_new(const std::filesystem::path& out) {
  std::error_code unknown;
  if (std::filesystem::exists(std::filesystem::symlink_status(out, unknown)))
    throw LoadError(out.string() + ": exists already; traces go into a new folder");
}
void make_new(const std::filesystem::path& out) {
  std::error_code error;
  if (!std::filesystem::create_directory(out, error))
    throw LoadError(out.string() + ": the folder of the traces cannot be made; choose another, new one");
}

void print_welcome(const House& house, std::uint16_t port) {
  const ServeArguments& given = house.arguments;
  const bool is_alone = is_loopback(given.listen), has_tls = !given.certificate.empty();
  const std::string at =
      (given.listen.find(':') != std::string::npos ? "[" + given.listen + "]" : given.listen) + ":" + std::to_string(port);
  print("hands and viewers may come to " + at + (is_alone ? " (this machine alone)" : " (from other machines)") +
        (has_tls    ? ", over TLS\n"
         : is_alone ? "\n"
                    : ", UNENCRYPTED\n"));
  if (is_alone) print("  from elsewhere first: ssh -L " + std::to_string(port) + ":" + at + " you@HOST\n");
  print("  palpa run --data-at " + at +
        (has_tls     ? " --tls"
         : !is_alone ? " --unencrypted"
                     : "") +
        (given.datagrams ? " --datagrams" : "") + " --device inverse3    asks for the token\n");
  if (given.token_file.empty()) {
    print("  touch " + format_token(house.tokens.touch) + "\n  watch " + format_token(house.tokens.watch) + "\n");
  } else {
    print("  tokens in " + given.token_file.string() + "\n");
  }
  std::fflush(stdout);
}

/// One line for a terminal.
std::string terminal_line(const std::vector<std::string>& hands, bool is_open) {
  std::string line;
  for (const std::string& hand : hands) line += (line.empty() ? "" : "   ") + hand;
  if (hands.empty()) line = "no hand";
  return line + (is_open ? ", UNENCRYPTED" : "");
}

/// Prints lines and status until an interrupt or q.
void watch(House& house, IgtlView* igtl, const std::atomic<bool>& stop) {
  const bool is_open = !is_loopback(house.arguments.listen) && house.arguments.certificate.empty();
  const std::string after = is_open ? ", UNENCRYPTED\n" : "\n";
  LiveTerminal terminal("Keys: q ends.");
  double next_s = now_s() + status_interval_s;
  bool goes_on = true;
  while (goes_on && !stop) {
    const std::vector<std::string> lines = house.lines.take();
    if (!lines.empty()) terminal.erase_line();
    for (const std::string& line : lines) tell(line + after);
    goes_on = terminal.watch([&] { return terminal_line(house.felt.lines(), is_open); }, [](char) {});
    if (!terminal.shows() && now_s() >= next_s) {
      for (const std::string& line : house.felt.lines()) tell(line + after);
      next_s = now_s() + status_interval_s;
    }
    if (igtl) igtl->watch([&] { return house.loaded.scene; });
    std::this_thread::sleep_for(watch_interval);
  }
  terminal.erase_line();
}

}  // namespace

int run_serve(const ServeArguments& arguments, const std::atomic<bool>& stop) {
  check_openness(arguments);
  const AccessTokens tokens = arguments.token_file.empty() ? random_tokens() : kept_tokens(arguments.token_file);
  const RunOptions& options = arguments.options;
  if (!options.out.empty()) expect_new(options.out);
  std::optional<Progress> progress(std::in_place, "loading " + options.scene.filename().string());
  ReadOptions read = options.read;
  read.checksums = options.out.empty() ? Checksums::none : Checksums::later;
  House house{arguments, load_scene(options.scene, volume_reader(read), modes_with(options.plugins), options.scene_options),
              tokens};
  progress.reset();
  print_warnings(house.loaded.warnings);
  if (const std::vector<SceneHand>& hands = house.loaded.scene.hands(); hands.size() > 1)
    throw LoadError(
        options.scene.string() +
        ": the scene has several hands, and each far hand feels alone; serve one, --set only_hand=" + hands.front().name);
  {
    const DataSide can_be_felt(house.loaded.scene);
  }
  std::optional<IgtlView> igtl;
  if (arguments.igtl_port) house.viewed.emplace(igtl.emplace(*arguments.igtl_port));
  Service service(house);
  std::unique_ptr<NetServer> server;
  {
    const detail::BlockedSignals on_its_threads;
    server = net().serve({.address = arguments.listen,
                          .port = arguments.port,
                          .certificate = arguments.certificate,
                          .key = arguments.key,
                          .datagrams = arguments.datagrams},
                         service);
  }
  if (!options.out.empty()) make_new(options.out);
  print_welcome(house, server->port());
  if (igtl) tell("OpenIGTLink at 127.0.0.1:" + std::to_string(igtl->port()) + ", for clients on this machine alone\n");
  watch(house, igtl ? &*igtl : nullptr, stop);
  server.reset();
  for (const std::string& line : house.lines.take()) tell(line + "\n");
  if (!options.out.empty() && house.last_hand > 0)
    print("\nRecorded in " + options.out.string() + "\nNext: palpa replay " + options.out.string() + "\n");
  return 0;
}

}  // namespace palpa::app
