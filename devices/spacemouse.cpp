// palpa-device-spacemouse.so: a SpaceMouse of 3Dconnexion, by spacenavd's library.
#include <poll.h>
#include <spnav.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <optional>
#include <thread>

#include "devices/rate_hand_device.h"
#include "palpa/base/load_error.h"
#include "palpa/device/backend.h"
#include "palpa/device/described.h"
#include "palpa/version.h"

namespace palpa::spacemouse {
namespace {

// Counts of full deflection. Larger: slower hand; smaller: full speed early.
constexpr double full_counts = 350.0;
// Polling timeout, also for the end of the thread. Longer: it ends later; shorter: more wake-ups.
constexpr int look_ms = 50;
// Between attempts to reconnect to spacenavd. Longer: later back; shorter: more futile attempts.
constexpr std::chrono::milliseconds retry_interval{300};

constexpr const char* gone = "spacenavd, which reads the SpaceMouse, is not there";
constexpr const char* unplugged = "the SpaceMouse is not there; plug it in or switch it on";
constexpr const char* how_to_get = "install it by 'sudo apt install spacenavd', and plug the SpaceMouse in";

[[noreturn]] void refuse(const std::string& what) { throw LoadError("device spacemouse: " + what); }

/// libspnav has one connection per process: the first device owns it.
std::atomic<bool> is_taken{false};

/// Model of a SpaceMouse: spacenavd reports no serial numbers, and merges the motions of several.
struct Kind {
  int type = 0;
  unsigned usb_vendor = 0, usb_product = 0;
  friend bool operator==(const Kind&, const Kind&) = default;
};

/// Reply of spacenavd to the request for its first SpaceMouse.
struct Answer {
  bool is_none = false;      // no SpaceMouse
  std::optional<Kind> kind;  // none also for an earlier spacenavd without the request
};
Answer ask() {
  if (spnav_protocol() < 1) return {};
  // The library mistakes a preceding event for the reply.
  constexpr int tries = 3;
  Kind kind{.type = -1};
  for (int n = 0; n < tries && kind.type < 0; ++n) {
    kind.type = spnav_dev_type();
    if (kind.type < 0 && spnav_cfg_get_sens() < 0.0f) return {};
  }
  if (kind.type < 0) return {.is_none = true, .kind = std::nullopt};
  // A serial SpaceMouse has no USB id.
  if (spnav_dev_usbid(&kind.usb_vendor, &kind.usb_product) < 0) kind.usb_vendor = kind.usb_product = 0;
  return {.is_none = false, .kind = kind};
}

struct Options {
  double full = full_counts;
};

Options options_of(const DeviceSettings& given) {
  Options out;
  for (const auto& [key, value] : given) {
    if (key != "full_counts") refuse("it has no setting '" + key.substr(0, 40) + "'; known is full_counts");
    if (!detail::read_number(value, out.full) || !(out.full >= 1.0 && out.full <= 1e4))
      refuse("full_counts=" + value.substr(0, 40) + " cannot be; give 1 to 10000");
  }
  return out;
}

class SpaceMouse final : public Device {
 public:
  explicit SpaceMouse(const Options& options) : options_(options) {
    if (is_taken.exchange(true)) refuse("this program has it already");
    if (spnav_open() < 0) {
      is_taken = false;
      refuse(std::string(gone) + "; " + how_to_get);
    }
    const Answer answer = ask();
    if (answer.is_none) {
      spnav_close();
      is_taken = false;
      refuse(unplugged);
    }
    kind_ = answer.kind;
    thread_ = std::thread([this] { run(); });
  }
  ~SpaceMouse() override {
    ends_ = true;
    thread_.join();
    is_taken = false;
  }
  std::string name() const override { return "SpaceMouse"; }
  DeviceLimits limits() const override { return RateHandDevice::limits(); }
  DeviceState read() noexcept override { return hand_.read(); }
  bool write(const Vec3& force_n) noexcept override { return hand_.write(force_n); }
  bool rests() const noexcept override { return true; }

 private:
  void run() {
    bool is_open = true;
    while (!ends_) {
      if (is_open && take()) continue;
      if (is_open) spnav_close();
      hand_.deflections.give(now_ = {.share = {}, .buttons = 0, .fault = gone});
      const auto end = std::chrono::steady_clock::now() + retry_interval;
      while (!ends_ && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(5));
      is_open = !ends_ && spnav_open() >= 0;
      if (is_open) begin_again();
    }
    if (is_open) spnav_close();
  }
  /// After reconnecting to spacenavd.
  void begin_again() {
    const Answer answer = ask();
    if (!kind_) kind_ = answer.kind;
    is_gone_ = answer.is_none || (answer.kind && answer.kind != kind_);
    hand_.deflections.give(now_ = {.share = {}, .buttons = 0, .fault = is_gone_ ? unplugged : nullptr});
  }
  /// Handles plug and unplug events: axes and buttons are released; while this model is unplugged, events are of another.
  void change(const spnav_event_dev& event) {
    const Kind kind{event.devtype, static_cast<unsigned>(event.usbid[0]), static_cast<unsigned>(event.usbid[1])};
    if (!kind_) kind_ = kind;
    if (event.op == SPNAV_DEV_RM) {
      is_gone_ = is_gone_ || kind == *kind_;
      now_.share = {};
      now_.buttons = 0;
    } else if (kind == *kind_) {
      is_gone_ = false;
    }
    now_.fault = is_gone_ ? unplugged : nullptr;
  }
  /// Reads pending events; false: the connection is closed.
  bool take() {
    pollfd socket{.fd = spnav_fd(), .events = POLLIN, .revents = 0};
    if (::poll(&socket, 1, look_ms) <= 0) return true;
    spnav_event event{};
    bool is_any = false;
    while (spnav_poll_event(&event) != 0) {
      is_any = true;
      if (event.type == SPNAV_EVENT_DEV) {
        change(event.dev);
      } else if (is_gone_) {
        continue;
      } else if (event.type == SPNAV_EVENT_MOTION) {
        // Pushing away from the user counts up along z.
        now_.share = Vec3{static_cast<double>(event.motion.x), static_cast<double>(event.motion.y),
                          -static_cast<double>(event.motion.z)} /
                     options_.full;
      } else if (event.type == SPNAV_EVENT_BUTTON && event.button.bnum >= 0 && event.button.bnum < 32) {
        const std::uint32_t bit = 1u << event.button.bnum;
        now_.buttons = event.button.press != 0 ? now_.buttons | bit : now_.buttons & ~bit;
      }
    }
    if (is_any) hand_.deflections.give(now_);
    return is_any;  // readable without an event: closed
  }

  Options options_;
  std::optional<Kind> kind_;  // of this device; none: unknown
  bool is_gone_ = false;
  RateHandDevice hand_;
  Deflection now_;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

std::vector<DeviceSetting> settings() {
  return {{"full_counts", "counts of a full deflection, 1 to 10000; fewer: it is more sensitive; without it 350"}};
}

DeviceSearch search(const DeviceSettings& given) {
  options_of(given);
  if (is_taken.exchange(true)) return {.found = {{"spacemouse", "the SpaceMouse that this program uses"}}, .missing = {}};
  const bool is_there = spnav_open() >= 0;
  const Answer answer = is_there ? ask() : Answer{};
  if (is_there) spnav_close();
  is_taken = false;
  if (!is_there) return {.found = {}, .missing = {std::string(gone) + "; " + how_to_get}};
  if (answer.is_none) return {.found = {}, .missing = {"spacenavd is there, but no SpaceMouse; plug it in or switch it on"}};
  return {.found = {{"spacemouse", answer.kind ? "what spacenavd reads"
                                               : "what spacenavd reads, which does not say whether a SpaceMouse is there"}},
          .missing = {}};
}

std::unique_ptr<Device> open(const DeviceSettings& given) { return std::make_unique<SpaceMouse>(options_of(given)); }

}  // namespace
}  // namespace palpa::spacemouse

extern "C" __attribute__((visibility("default"))) const palpa::DeviceBackend palpa_device_backend;
const palpa::DeviceBackend palpa_device_backend{
    palpa::version,
    "spacemouse",
    "SpaceMouse of 3Dconnexion, by spacenavd: a hand that is steered, without force",
    "x to the right, y up, z away from the user",
    palpa::spacemouse::settings,
    palpa::spacemouse::search,
    palpa::spacemouse::open};
