// palpa-device-controller.so: game controllers by SDL; two sticks and the triggers steer the hand, rumble signals contacts.
#include <SDL.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>

#include "devices/rate_hand_device.h"
#include "palpa/base/load_error.h"
#include "palpa/device/backend.h"
#include "palpa/device/described.h"
#include "palpa/device/rest.h"
#include "palpa/version.h"

namespace palpa::controller {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double full_axis = 32767.0;
// Of an axis, [1]: sticks at rest are off centre. More: small motions are lost; less: the hand drifts.
constexpr double dead_zone = 0.15;
// Polling interval of the sticks. Longer: latency; shorter: more work.
constexpr std::chrono::milliseconds look_interval{4};
// Between searches for a lost controller. Longer: later back; shorter: more futile searches.
constexpr std::chrono::milliseconds retry_interval{200};
// Duration of a rumble request, renewed while it lasts. Longer: it outlasts the program; shorter: it stutters.
constexpr Uint32 rumble_ms = 100;
// Force of full rumble and force change of a full knock, in newtons. More: weaker; less: all contacts are alike.
constexpr double full_rumble_n = 3.0, full_knock_n = 1.0;
// Duration of a knock. Longer: knocks merge; shorter: they are missed.
constexpr std::chrono::milliseconds knock_time{60};
// Age at which a force stops rumbling. Longer: a hung program rumbles longer; shorter: a busy machine's pause stops it.
constexpr std::chrono::milliseconds force_lifetime{100};

constexpr const char* gone = "the controller is not there; plug it in or switch it on";

[[noreturn]] void refuse(const std::string& what) { throw LoadError("device controller: " + what); }

/// SDL, reference counted. A global lock guards it: its joystick list is global.
class Sdl {
 public:
  static std::recursive_mutex& mutex() {
    static std::recursive_mutex of_all;
    return of_all;
  }
  Sdl() {
    const std::lock_guard lock(mutex());
    // Read controllers without keyboard focus, too.
    SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
    if (SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER) != 0) refuse(std::string("SDL cannot begin: ") + SDL_GetError());
  }
  ~Sdl() {
    const std::lock_guard lock(mutex());
    SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
  }
  Sdl(const Sdl&) = delete;
  Sdl& operator=(const Sdl&) = delete;
};

/// SDL indices of the connected controllers.
std::vector<int> controllers() {
  std::vector<int> out;
  SDL_GameControllerUpdate();
  for (int n = 0; n < SDL_NumJoysticks(); ++n)
    if (SDL_IsGameController(n) == SDL_TRUE) out.push_back(n);
  return out;
}

/// Identifies a controller after a reconnection.
struct Identity {
  SDL_JoystickGUID model{};
  std::string serial;  // empty: no serial number, or not opened
};
bool is_same(const SDL_JoystickGUID& a, const SDL_JoystickGUID& b) { return std::memcmp(a.data, b.data, sizeof a.data) == 0; }
std::string serial_of(SDL_GameController* controller) {
  const char* serial = SDL_GameControllerGetSerial(controller);
  return serial != nullptr ? serial : "";
}

int number_of(const DeviceSettings& given) {
  int number = 1;
  for (const auto& [key, value] : given) {
    if (key != "number") refuse("it has no setting '" + key.substr(0, 40) + "'; known is number");
    if (!detail::read_number(value, number) || number < 1 || number > 16)
      refuse("number=" + value.substr(0, 40) + " cannot be; controllers are numbered from 1");
  }
  return number;
}

double stick(double axis) noexcept {
  const double share = std::clamp(axis / full_axis, -1.0, 1.0);
  const double beyond = std::abs(share) - dead_zone;
  return beyond <= 0.0 ? 0.0 : std::copysign(beyond / (1.0 - dead_zone), share);
}

class Controller final : public Device {
 public:
  explicit Controller(int number) : number_(number) {
    {
      const std::lock_guard lock(Sdl::mutex());
      if (!open_first()) refuse("there is no controller " + std::to_string(number) + "; plug one in or switch it on");
      const char* given = SDL_GameControllerName(controller_);
      name_ = given != nullptr ? given : "controller";
      std::erase_if(name_, [](char c) { return c < ' ' || c > '~'; });
    }
    thread_ = std::thread([this] { run(); });
  }
  ~Controller() override {
    ends_ = true;
    thread_.join();
  }
  std::string name() const override { return name_.substr(0, 60); }
  DeviceLimits limits() const override { return RateHandDevice::limits(); }
  DeviceState read() noexcept override { return hand_.read(); }
  bool write(const Vec3& force_n) noexcept override {
    const Vec3 felt_n = is_finite(force_n) ? force_n : Vec3{};
    wishes_.give({felt_n, rest_.ask(felt_n != Vec3{}), Clock::now()});
    return hand_.write(force_n);
  }
  bool rests() const noexcept override { return rest_.is_reached(); }

 private:
  struct Wish {
    Vec3 force_n;
    std::uint64_t number = 0;
    Clock::time_point time{};
  };

  bool open_first() {
    const std::vector<int> there = controllers();
    if (there.size() < static_cast<std::size_t>(number_)) return false;
    const int n = there[static_cast<std::size_t>(number_) - 1];
    controller_ = SDL_GameControllerOpen(n);
    if (controller_ == nullptr) return false;
    identity_ = {.model = SDL_JoystickGetDeviceGUID(n), .serial = serial_of(controller_)};
    note_those_that_are_there();
    return true;
  }
  /// Reopens the controller: equal model and serial number, connected after the loss. Without a serial number, two candidates
  /// are ambiguous: none is opened.
  bool open_again() {
    std::vector<int> candidates;
    for (const int n : controllers()) {
      const SDL_JoystickID id = SDL_JoystickGetDeviceInstanceID(n);
      if (id > newest_ && is_same(SDL_JoystickGetDeviceGUID(n), identity_.model) && !others_.contains(id))
        candidates.push_back(n);
    }
    if (identity_.serial.empty() && candidates.size() != 1) return false;
    for (const int n : candidates) {
      const SDL_JoystickID id = SDL_JoystickGetDeviceInstanceID(n);
      controller_ = SDL_GameControllerOpen(n);
      if (controller_ == nullptr) continue;
      if (serial_of(controller_) == identity_.serial) return true;
      others_.insert(id);
      SDL_GameControllerClose(controller_);
      controller_ = nullptr;
    }
    return false;
  }
  /// Called while connected: SDL's ids of later connections are larger.
  void note_those_that_are_there() {
    for (int n = 0; n < SDL_NumJoysticks(); ++n) newest_ = std::max(newest_, SDL_JoystickGetDeviceInstanceID(n));
  }
  void close() {
    if (controller_ == nullptr) return;
    SDL_GameControllerRumble(controller_, 0, 0, 0);
    SDL_GameControllerClose(controller_);
    controller_ = nullptr;
  }

  void run() {
    while (!ends_) {
      bool is_there = false;
      {
        const std::lock_guard lock(Sdl::mutex());
        is_there = look();
      }
      std::this_thread::sleep_for(is_there ? look_interval : retry_interval);
    }
    const std::lock_guard lock(Sdl::mutex());
    close();
  }
  bool look() {
    if (controller_ == nullptr && !open_again()) {
      rest_.give_none(wishes_.take().number);
      return false;
    }
    SDL_GameControllerUpdate();
    if (SDL_GameControllerGetAttached(controller_) != SDL_TRUE) {
      close();
      hand_.deflections.give({.share = {}, .buttons = 0, .fault = gone});
      return false;
    }
    note_those_that_are_there();
    const auto axis = [this](SDL_GameControllerAxis which) {
      return static_cast<double>(SDL_GameControllerGetAxis(controller_, which));
    };
    Deflection now;
    // SDL: y is positive towards the user; triggers start at 0.
    now.share = {stick(axis(SDL_CONTROLLER_AXIS_LEFTX)), -stick(axis(SDL_CONTROLLER_AXIS_RIGHTY)),
                 stick(axis(SDL_CONTROLLER_AXIS_LEFTY))};
    for (int button = 0; button < SDL_CONTROLLER_BUTTON_MAX; ++button)
      if (SDL_GameControllerGetButton(controller_, static_cast<SDL_GameControllerButton>(button)) != 0)
        now.buttons |= 1u << button;
    hand_.deflections.give(now);
    rumble();
    return true;
  }
  /// The slow motor renders the force, the fast motor its change: contacts are knocks.
  void rumble() {
    const Clock::time_point now = Clock::now();
    const Wish& wish = wishes_.take();
    const Vec3 force_n = now - wish.time < force_lifetime ? wish.force_n : Vec3{};
    const double change_n = distance(force_n, last_n_);
    last_n_ = force_n;
    if (change_n > 0.1 * full_knock_n && change_n >= knock_n_ * (now < knock_ends_)) {
      knock_n_ = change_n;
      knock_ends_ = now + knock_time;
    }
    const auto strength = [](double share) { return static_cast<Uint16>(65535.0 * std::min(1.0, share)); };
    const Uint16 slow = strength(norm(force_n) / full_rumble_n),
                 fast = now < knock_ends_ ? strength(knock_n_ / full_knock_n) : Uint16{0};
    const bool is_due = now - rumbled_at_ > std::chrono::milliseconds(rumble_ms / 2);
    const bool is_rest = slow == 0 && fast == 0;
    if (slow != slow_ || fast != fast_ || (is_due && !is_rest)) {
      slow_ = slow;
      fast_ = fast;
      rumbled_at_ = now;
      SDL_GameControllerRumble(controller_, slow, fast, rumble_ms);
    }
    if (is_rest) rest_.give_none(wish.number);
  }

  Sdl sdl_;
  int number_;
  std::string name_;
  SDL_GameController* controller_ = nullptr;
  Identity identity_;
  SDL_JoystickID newest_ = -1;       // largest id while connected
  std::set<SDL_JoystickID> others_;  // ids connected after the loss that proved to be other controllers
  RateHandDevice hand_;
  Latest<Wish> wishes_;
  Rest rest_;
  Vec3 last_n_;
  double knock_n_ = 0.0;
  Clock::time_point knock_ends_{}, rumbled_at_{};
  Uint16 slow_ = 0, fast_ = 0;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

std::vector<DeviceSetting> settings() { return {{"number", "which of several controllers, from 1; without it the first"}}; }

DeviceSearch search(const DeviceSettings& given) {
  number_of(given);
  const Sdl sdl;
  const std::lock_guard lock(Sdl::mutex());
  DeviceSearch out;
  for (const int n : controllers()) {
    const char* name = SDL_GameControllerNameForIndex(n);
    std::string description = "controller";
    if (!out.found.empty()) description += ",number=" + std::to_string(out.found.size() + 1);
    out.found.push_back({description, name != nullptr ? name : "a controller"});
  }
  if (out.found.empty()) out.missing.push_back("no game controller is there; plug one in or switch it on");
  return out;
}

std::unique_ptr<Device> open(const DeviceSettings& given) { return std::make_unique<Controller>(number_of(given)); }

}  // namespace
}  // namespace palpa::controller

extern "C" __attribute__((visibility("default"))) const palpa::DeviceBackend palpa_device_backend;
const palpa::DeviceBackend palpa_device_backend{palpa::version,
                                                "controller",
                                                "game controllers, by SDL: a hand that is steered, with rumble for touches",
                                                "left stick: right and towards the user; right stick: up",
                                                palpa::controller::settings,
                                                palpa::controller::search,
                                                palpa::controller::open};
