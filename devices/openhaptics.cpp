// palpa-device-openhaptics.so: Touch, Touch X and Phantom of 3D Systems, by their driver's libHD, loaded at run time. Its
// functions and constants are declared here after the published reference; building needs nothing of the vendor's.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "devices/vendor_library.h"
#include "palpa/base/load_error.h"
#include "palpa/device/backend.h"
#include "palpa/device/described.h"
#include "palpa/device/latest.h"
#include "palpa/device/rest.h"
#include "palpa/device/turn_of.h"
#include "palpa/version.h"

PALPA_LOADS_AT_RUN_TIME(
    R"([{"feature":"openhaptics","description":"3D Systems Touch and Phantom haptic devices","priority":"suggested","soname":["libHD.so"]}])")

namespace palpa::openhaptics {
namespace {

using Clock = std::chrono::steady_clock;
using Handle = unsigned int;

constexpr Handle no_device = 0xFFFFFFFF;
constexpr double mm_per_m = 1e3;

// Parameter numbers of the library.
enum Parameter : unsigned {
  current_buttons = 0x2000,
  current_position = 0x2050,
  current_velocity = 0x2051,
  current_transform = 0x2052,
  device_model = 0x2501,
  device_serial_number = 0x2504,
  max_workspace = 0x2550,
  input_freedoms = 0x2553,
  max_stiffness = 0x2602,
  max_force = 0x2603,
  max_continuous_force = 0x2604,
  motor_temperature = 0x2605,
  max_damping = 0x2609,
  current_force = 0x2700,
  force_output = 0x4000,
  max_force_clamping = 0x4001,
};
constexpr unsigned calibrated = 0x5000;
constexpr unsigned calibration_needs_update = 0x5001;
constexpr unsigned callback_goes_on = 1;
constexpr unsigned short default_priority = 0x7FFF;

// Error [1] of a rotation matrix. More: a shear passes as an orientation; less: rounding in the library is a fault.
constexpr double rotation_error = 1e-3;
// Longer: a hung program pushes longer; shorter: a busy machine's pause drops the force.
constexpr std::chrono::milliseconds force_lifetime{20};
// Longer: stale positions count; shorter: a busy machine's pause is a fault.
constexpr double state_lifetime_s = 0.05;
// Motor temperature [1] above which the force is reduced towards the continuous limit. More: hotter motors; less: less force.
constexpr double warm = 0.7;
// Frames at zero force after an error. More: later back; fewer: an error in every second frame makes the force stutter.
constexpr int calm_frames = 20;
// Between attempts to reopen. Longer: later back; shorter: more futile attempts.
constexpr std::chrono::milliseconds retry_interval{300};

/// Result of hdGetError: twelve bytes, by value.
struct Error {
  unsigned code;
  int internal;
  Handle handle;
};

struct Api {
  explicit Api(const std::vector<std::string>& files) : library(files) {
    library.need("hdInitDevice", init);
    library.need("hdDisableDevice", disable_device);
    library.need("hdMakeCurrentDevice", make_current);
    library.need("hdEnable", enable);
    library.need("hdStartScheduler", start_scheduler);
    library.need("hdStopScheduler", stop_scheduler);
    library.need("hdScheduleAsynchronous", schedule);
    library.need("hdUnschedule", unschedule);
    library.need("hdBeginFrame", begin_frame);
    library.need("hdEndFrame", end_frame);
    library.need("hdGetDoublev", get_doubles);
    library.need("hdGetIntegerv", get_integers);
    library.need("hdSetDoublev", set_doubles);
    library.need("hdGetError", get_error);
    library.find("hdGetString", get_string);
    library.find("hdCheckCalibration", check_calibration);
    library.find("hdUpdateCalibration", update_calibration);
  }
  VendorLibrary library;
  Handle (*init)(const char* name) = nullptr;
  void (*disable_device)(Handle) = nullptr;
  void (*make_current)(Handle) = nullptr;
  void (*enable)(unsigned) = nullptr;
  void (*start_scheduler)() = nullptr;
  void (*stop_scheduler)() = nullptr;
  unsigned long (*schedule)(unsigned (*callback)(void*), void* with, unsigned short priority) = nullptr;
  void (*unschedule)(unsigned long) = nullptr;
  void (*begin_frame)(Handle) = nullptr;
  void (*end_frame)(Handle) = nullptr;
  void (*get_doubles)(unsigned, double*) = nullptr;
  void (*get_integers)(unsigned, int*) = nullptr;
  void (*set_doubles)(unsigned, const double*) = nullptr;
  Error (*get_error)() = nullptr;
  const char* (*get_string)(unsigned) = nullptr;
  unsigned (*check_calibration)() = nullptr;
  void (*update_calibration)(unsigned style) = nullptr;
};

const char* format_code(unsigned code) noexcept {
  switch (code) {
    case 0x0200: return "the motors are too warm; let them cool";
    case 0x0201: return "the device was asked for more force than it has";
    case 0x0202: return "the force changed faster than the device allows";
    case 0x0203: return "the device was moved faster than it allows";
    case 0x0204: return "the device makes no force";
    case 0x0300: return "the device has a fault; unplug it and plug it in again";
    case 0x0302: return "the device does not answer; is it plugged in?";
    case 0x0304: return "the device's thread lost its timer";
    default: return "the device's library reports an error";
  }
}
/// Errors after which the device has to be reopened.
bool is_gone(unsigned code) noexcept { return code == 0x0300 || code == 0x0302; }

/// The stylus' turn from a transform of 16 numbers by columns; none: not a rotation. It is none where the stylus lies along z,
/// with its tip away from the user.
std::optional<Turn> turn_in(const std::array<double, 16>& transform) noexcept {
  Mat3 rotation;
  for (int row = 0; row < 3; ++row) {
    const auto at = [&](int column) { return transform[static_cast<std::size_t>(4 * column + row)]; };
    rotation.row[row] = {at(0), at(1), at(2)};
  }
  return is_rotation(rotation, rotation_error) ? std::optional(turn_of(rotation)) : std::nullopt;
}

double seconds(Clock::time_point time) { return std::chrono::duration<double>(time.time_since_epoch()).count(); }

/// The library's scheduler is shared by all devices: started with the first, stopped with the last.
class Scheduler {
 public:
  void join(const Api& api) {
    const std::lock_guard lock(mutex_);
    if (users_++ == 0) api.start_scheduler();
  }
  void leave(const Api& api) {
    const std::lock_guard lock(mutex_);
    if (--users_ == 0) api.stop_scheduler();
  }

 private:
  std::mutex mutex_;
  int users_ = 0;
};

struct Wanted {
  std::vector<std::string> files;
  std::string name;  // empty: the default device
  std::string description = "openhaptics";
};

/// An open device; the library's thread exchanges force for state in each frame.
class Servo {
 public:
  struct Wish {
    Vec3 force_n;
    std::uint64_t number = 0;
    Clock::time_point time{};
  };
  Servo(const Api& api, Scheduler& scheduler, std::string name) : api_(api), scheduler_(scheduler), name_(std::move(name)) {}
  ~Servo() { close(); }

  /// False: not connected. The first call accepts any device of that name, later calls only that device.
  bool open() {
    // Null opens the default device; other names are given by the user.
    handle_ = api_.init(name_.empty() ? nullptr : name_.c_str());
    if (handle_ == no_device || api_.get_error().code != 0) {
      if (handle_ != no_device) api_.disable_device(handle_);
      handle_ = no_device;
      return false;
    }
    api_.make_current(handle_);
    const std::string found = identity();
    if (identity_.empty()) identity_ = found;
    if (found != identity_) {
      api_.disable_device(handle_);
      handle_ = no_device;
      return false;
    }
    api_.enable(Parameter::force_output);
    api_.enable(Parameter::max_force_clamping);
    return true;
  }
  /// Starts the exchange on the library's thread.
  void start() {
    gone_ = false;
    calm_ = calm_frames;
    last_code_ = 0;
    framed_at_ = Clock::now();
    scheduler_.join(api_);
    callback_ = api_.schedule([](void* self) { return static_cast<Servo*>(self)->frame(); }, this, default_priority);
    is_started_ = true;
  }
  void close() {
    if (handle_ == no_device) return;
    closing_ = true;
    // One frame at zero force, with a timeout in case the library's thread has stopped.
    const Clock::time_point end = Clock::now() + std::chrono::milliseconds(50);
    while (is_started_ && !rested_ && !gone_ && Clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (is_started_) {
      api_.unschedule(callback_);
      scheduler_.leave(api_);
    }
    api_.disable_device(handle_);
    handle_ = no_device;
    closing_ = rested_ = is_started_ = false;
  }
  /// Marks forces as not rendered while the device is closed.
  void note_absence() { rest.give_none(wishes.take().number); }
  bool is_open() const noexcept { return handle_ != no_device; }
  bool is_gone_now() const noexcept { return gone_ || Clock::now() - framed_at_.load() > longest_without_frame; }
  bool waits_for_inkwell() const noexcept { return calibration_ == calibration_needs_update; }
  void calibrate() {
    if (api_.update_calibration == nullptr) return;
    api_.make_current(handle_);
    api_.update_calibration(inkwell_style);
  }

  Latest<DeviceState> states;
  Latest<Wish> wishes;
  Rest rest;
  double most_n = 0.0, continuous_n = 0.0;  // set before `start`
  bool senses_turn = false;                 // likewise

 private:
  // Age of the last frame at which the device counts as lost. Longer: reported later; shorter: a busy machine loses it.
  static constexpr std::chrono::milliseconds longest_without_frame{200};
  static constexpr unsigned inkwell_style = 4;

  /// Model and serial number of the current device, if the library reports them.
  std::string identity() const {
    std::string text = ".";
    if (api_.get_string == nullptr) return text;
    for (const unsigned what : {Parameter::device_model, Parameter::device_serial_number}) {
      const char* said = api_.get_string(what);
      if (api_.get_error().code == 0 && said != nullptr) text += said;
      text += '.';
    }
    return text;
  }

  unsigned frame() noexcept {
    DeviceState state;
    std::array<double, 3> place{}, speed{}, force{};
    std::array<double, 16> transform{};
    int buttons = 0;
    double temperature = 0.0;
    api_.begin_frame(handle_);
    api_.get_doubles(Parameter::current_position, place.data());
    api_.get_doubles(Parameter::current_velocity, speed.data());
    if (senses_turn) api_.get_doubles(Parameter::current_transform, transform.data());
    api_.get_integers(Parameter::current_buttons, &buttons);
    api_.get_doubles(Parameter::motor_temperature, motors_.data());
    for (const double motor : motors_) temperature = std::max(temperature, motor);
    framed_at_ = Clock::now();
    calibration_ = api_.check_calibration != nullptr ? api_.check_calibration() : calibrated;
    const bool is_calibrated = calibration_ == calibrated;
    const Wish& wish = wishes.take();
    const bool is_fresh = Clock::now() - wish.time < force_lifetime;
    const bool may_push = calm_ == 0 && is_calibrated && is_fresh && !closing_;
    if (may_push) {
      const Vec3 sent_n = shortened(wish.force_n, let_n(temperature));
      force = {sent_n.x, sent_n.y, sent_n.z};
    }
    api_.set_doubles(Parameter::current_force, force.data());
    api_.end_frame(handle_);
    const unsigned code = api_.get_error().code;
    if (force == std::array<double, 3>{} && !is_gone(code)) rest.give_none(wish.number);

    state.position_m = Vec3{place[0], place[1], place[2]} / mm_per_m;
    state.velocity_m_per_s = Vec3{speed[0], speed[1], speed[2]} / mm_per_m;
    state.time_s = seconds(Clock::now());
    if (senses_turn) state.turn = turn_in(transform);
    const bool has_pose = is_finite(state.position_m) && state.turn.has_value() == senses_turn;
    state.valid = is_calibrated && has_pose && !is_gone(code);
    state.buttons = state.valid ? static_cast<std::uint32_t>(buttons) : 0u;
    if (code != 0) {
      calm_ = calm_frames;
      last_code_ = code;
    } else if (calm_ > 0) {
      --calm_;
    }
    if (!is_calibrated)
      state.fault = "the device is not calibrated: put the stylus into the inkwell";
    else if (calm_ > 0)
      state.fault = last_code_ != 0 ? format_code(last_code_) : "the device has only just answered";
    gone_ = is_gone(code);
    states.give(state);
    rested_ = closing_.load();
    return callback_goes_on;
  }
  /// Force limit: decreases to the continuous limit at the highest motor temperature.
  double let_n(double temperature) const noexcept {
    const double share = std::clamp((temperature - warm) / (1.0 - warm), 0.0, 1.0);
    return (1.0 - share) * most_n + share * std::min(most_n, continuous_n);
  }

  const Api& api_;
  Scheduler& scheduler_;
  const std::string name_;
  std::string identity_;  // of the device opened first; empty: none yet
  Handle handle_ = no_device;
  unsigned long callback_ = 0;
  std::array<double, 16> motors_{};
  int calm_ = 0;
  unsigned last_code_ = 0;
  bool is_started_ = false;
  std::atomic<bool> gone_{false}, closing_{false}, rested_{false};
  std::atomic<unsigned> calibration_{calibrated};
  std::atomic<Clock::time_point> framed_at_{};
};

[[noreturn]] void refuse(const std::string& what) { throw LoadError("device openhaptics: " + what); }
constexpr const char* how_to_get =
    "install the Touch Device Driver of 3D Systems (support.3dsystems.com, 'OpenHaptics for Linux'), which brings libHD.so, or "
    "name that file by library=/path/libHD.so";

Wanted wanted(const DeviceSettings& given) {
  Wanted out{.files = {"libHD.so", "libHD.so.3.4", "/usr/lib/libHD.so", "/usr/local/lib/libHD.so"}};
  for (const auto& [key, value] : given) {
    out.description += "," + key + "=" + value;
    if (key == "name") {
      out.name = value;
    } else if (key == "library") {
      out.files = {value};
    } else {
      refuse("it has no setting '" + key.substr(0, 40) + "'; known are name and library");
    }
  }
  return out;
}

struct Library {
  explicit Library(const std::vector<std::string>& files) : api(files) {}
  Api api;
  Scheduler scheduler;
};

Library& library_of(const Wanted& want) {
  static std::mutex mutex;
  static std::map<std::string, std::unique_ptr<Library>> loaded;
  const std::lock_guard lock(mutex);
  std::unique_ptr<Library>& library = loaded[want.files.front()];
  if (!library || !library->api.library.is_there()) library = std::make_unique<Library>(want.files);
  const VendorLibrary& file = library->api.library;
  if (!file.is_there()) refuse("its library cannot be loaded (" + file.complaint() + "); " + how_to_get);
  if (!file.missing().empty()) refuse(file.file() + " has no " + file.missing() + "; it is another library: " + how_to_get);
  return *library;
}

std::vector<DeviceSetting> settings() {
  return {{"name", "as the device is called in the driver's Touch Setup; without it the default device"},
          {"library", "path of libHD.so; without it looked for where the system has libraries"}};
}

DeviceSearch search(const DeviceSettings& given) {
  const Wanted want = wanted(given);
  try {
    Library& library = library_of(want);
    const Handle handle = library.api.init(want.name.empty() ? nullptr : want.name.c_str());
    const unsigned code = library.api.get_error().code;
    if (handle != no_device) library.api.disable_device(handle);
    if (handle != no_device && code == 0) return {.found = {{want.description, "the driver's device"}}, .missing = {}};
  } catch (const LoadError& error) {
    return {.found = {}, .missing = {error.what()}};
  }
  return {.found = {},
          .missing = {"the driver is there, but no device; plug it in and set it up with the driver's Touch Setup"}};
}

class OpenHaptics final : public Device {
 public:
  OpenHaptics(Library& library, const Wanted& want)
      : api_(library.api), name_(want.name.empty() ? "default device" : want.name), servo_(api_, library.scheduler, want.name) {
    if (!servo_.open())
      refuse("the " + name_ +
             " cannot be opened; plug it in, set it up with the driver's Touch Setup, and end other programs "
             "that use it");
    ask_limits();
    servo_.start();
    watch_ = std::thread([this] { watch(); });
  }
  ~OpenHaptics() override {
    ends_ = true;
    watch_.join();
    servo_.close();
  }
  std::string name() const override { return "3D Systems " + name_; }
  DeviceLimits limits() const override { return limits_; }
  DeviceState read() noexcept override {
    DeviceState state = servo_.states.take();
    if (seconds(Clock::now()) - state.time_s > state_lifetime_s) {
      state.valid = false;
      state.buttons = 0;
      if (state.fault == nullptr) state.fault = "the device does not answer; is it plugged in?";
    }
    return state;
  }
  bool write(const Vec3& force_n) noexcept override {
    const Vec3 wanted_n = is_finite(force_n) ? shortened(force_n, limits_.max_force_n) : Vec3{};
    servo_.wishes.give({wanted_n, servo_.rest.ask(wanted_n != Vec3{}), Clock::now()});
    return !is_gone_.load(std::memory_order_relaxed);
  }
  bool rests() const noexcept override { return servo_.rest.is_reached(); }

 private:
  /// Reads the device's limits; values outside the plausible range are replaced.
  void ask_limits() {
    const auto ask = [&](Parameter parameter, double least, double most, double otherwise) {
      std::array<double, 16> values{};
      api_.get_doubles(parameter, values.data());
      if (api_.get_error().code != 0 || !(values[0] >= least && values[0] <= most)) return otherwise;
      return values[0];
    };
    // Defaults of a Touch.
    limits_.max_force_n = ask(Parameter::max_force, 0.5, 37.5, 3.3);
    limits_.continuous_force_n = ask(Parameter::max_continuous_force, 0.1, limits_.max_force_n, 0.88);
    limits_.max_stiffness_n_per_m = mm_per_m * ask(Parameter::max_stiffness, 0.1, 3.5, 0.4);
    limits_.max_damping_ns_per_m = mm_per_m * ask(Parameter::max_damping, 1e-4, 0.05, 0.005);
    std::array<double, 16> box{};  // smallest x, y, z, largest x, y, z [mm]
    api_.get_doubles(Parameter::max_workspace, box.data());
    double radius_mm = 75.0;
    if (api_.get_error().code == 0) {
      double least = 1e9;
      for (std::size_t axis = 0; axis < 3; ++axis) least = std::min(least, (box[3 + axis] - box[axis]) / 2.0);
      if (least >= 20.0 && least <= 500.0) radius_mm = least;
    }
    limits_.workspace_radius_m = radius_mm / mm_per_m;
    int freedoms = 0;
    api_.get_integers(Parameter::input_freedoms, &freedoms);
    limits_.senses_turn = api_.get_error().code == 0 && freedoms >= 6;
    servo_.senses_turn = limits_.senses_turn;
    servo_.continuous_n = limits_.continuous_force_n;
    servo_.most_n = limits_.max_force_n;
  }
  /// Detects a loss, calibrates a device in its inkwell, and reopens a lost device.
  void watch() {
    while (!ends_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      if (servo_.is_open() && !servo_.is_gone_now()) {
        if (servo_.waits_for_inkwell()) servo_.calibrate();
        continue;
      }
      is_gone_ = true;
      servo_.close();
      const Clock::time_point end = Clock::now() + retry_interval;
      while (!ends_ && Clock::now() < end) {
        servo_.note_absence();
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
      if (ends_ || !servo_.open()) continue;
      servo_.start();
      is_gone_ = false;
    }
  }

  const Api& api_;
  std::string name_;
  DeviceLimits limits_;
  Servo servo_;
  std::atomic<bool> is_gone_{false}, ends_{false};
  std::thread watch_;
};

std::unique_ptr<Device> open(const DeviceSettings& given) {
  const Wanted want = wanted(given);
  return std::make_unique<OpenHaptics>(library_of(want), want);
}

}  // namespace
}  // namespace palpa::openhaptics

extern "C" __attribute__((visibility("default"))) const palpa::DeviceBackend palpa_device_backend;
const palpa::DeviceBackend palpa_device_backend{palpa::version,
                                                "openhaptics",
                                                "3D Systems Touch, Touch X and Phantom, by the driver's libHD",
                                                "x to the right, y up, z towards the user",
                                                palpa::openhaptics::settings,
                                                palpa::openhaptics::search,
                                                palpa::openhaptics::open};
