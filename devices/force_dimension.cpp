// palpa-device-force-dimension.so: omega, delta, sigma and lambda of Force Dimension and Novint's Falcon, by the vendor's
// libdrd or libdhd, loaded at run time. Its functions are declared here after the published reference; building needs nothing
// of the vendor's.
#include <algorithm>
#include <array>
#include <bitset>
#include <cctype>
#include <cstdlib>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "devices/exchange_thread.h"
#include "devices/vendor_library.h"
#include "palpa/base/load_error.h"
#include "palpa/device/backend.h"
#include "palpa/device/described.h"
#include "palpa/device/turn_of.h"
#include "palpa/version.h"

PALPA_LOADS_AT_RUN_TIME(
    R"([{"feature":"force-dimension","description":"Force Dimension and Falcon haptic devices","priority":"suggested","soname":["libdrd.so.3","libdhd.so.3"]}])")

namespace palpa::force_dimension {
namespace {

// The device's watchdog, in its unit of 125 us: 10 ms. More: a hung program pushes longer; fewer: a busy machine's pause
// switches the force off.
constexpr unsigned char watchdog_steps = 80;
// Consecutive failed exchanges until the device counts as lost. More: reported later; fewer: a single error of the link ends
// it.
constexpr int failures_to_lose = 5;
// Speed below which a device that was too fast gets its force back. Faster: it is switched off again; slower: later back.
constexpr double calm_m_per_s = 0.1;
// Error [1] of a rotation matrix. More: a shear passes as an orientation; less: rounding in the library is a fault.
constexpr double rotation_error = 1e-3;
// Limits of the motors of every wrist that has some, which the library does not report; values of CHAI3D 3.3.
constexpr double wrist_nm = 0.2;
constexpr double wrist_nm_per_rad = 1.0;
constexpr double wrist_nms_per_rad = 0.07;

/// Functions of the vendor's library; optional except for the needs of `Api`.
struct Api {
  explicit Api(const std::vector<std::string>& files) : library(files) {
    library.need("dhdGetDeviceCount", device_count);
    library.need("dhdOpenID", open);
    library.need("dhdClose", close);
    library.need("dhdGetPosition", position);
    library.need("dhdSetForce", set_force);
    library.need("dhdEnableForce", enable_force);
    library.need("dhdGetStatus", status);
    library.find("dhdGetLinearVelocity", velocity);
    library.find("dhdGetButtonMask", button_mask);
    library.find("dhdHasWrist", has_wrist);
    library.find("dhdHasActiveWrist", has_active_wrist);
    library.find("dhdGetOrientationFrame", orientation_frame);
    library.find("dhdSetForceAndTorqueAndGripperForce", set_force_and_torque);
    library.find("dhdGetSystemName", system_name);
    library.find("dhdGetSerialNumber", serial_number);
    library.find("dhdOpenSerial", open_serial);
    library.find("dhdSetBrakes", set_brakes);
    library.find("dhdSetWatchdog", set_watchdog);
    library.find("dhdEnableExpertMode", enable_expert);
    library.find("dhdDisableExpertMode", disable_expert);
    library.find("dhdGetSDKVersion", version);
    library.find("drdIsInitialized", is_initialized);
    library.find("drdAutoInit", auto_init);
    library.find("drdStop", stop_regulation);
  }

  VendorLibrary library;
  int (*device_count)() = nullptr;
  int (*open)(char index) = nullptr;
  int (*close)(char id) = nullptr;
  int (*position)(double*, double*, double*, char id) = nullptr;
  int (*set_force)(double, double, double, char id) = nullptr;
  int (*enable_force)(unsigned char on, char id) = nullptr;
  int (*status)(int* all, char id) = nullptr;
  int (*velocity)(double*, double*, double*, char id) = nullptr;
  unsigned (*button_mask)(char id) = nullptr;
  bool (*has_wrist)(char id) = nullptr;
  bool (*has_active_wrist)(char id) = nullptr;
  int (*orientation_frame)(double rows[3][3], char id) = nullptr;
  int (*set_force_and_torque)(double, double, double, double, double, double, double gripper_n, char id) = nullptr;
  const char* (*system_name)(char id) = nullptr;
  int (*serial_number)(unsigned short* number, char id) = nullptr;
  int (*open_serial)(int number) = nullptr;
  int (*set_brakes)(int on, char id) = nullptr;
  int (*set_watchdog)(unsigned char steps, char id) = nullptr;
  int (*enable_expert)() = nullptr;
  int (*disable_expert)() = nullptr;
  void (*version)(int*, int*, int*, int*) = nullptr;
  bool (*is_initialized)(char id) = nullptr;
  int (*auto_init)(char id) = nullptr;
  int (*stop_regulation)(bool forces_stay_on, char id) = nullptr;
};

// Indices into the result of dhdGetStatus.
enum Status : std::size_t { power = 0, reset = 3, force = 5, force_off_cause = 14 };
// Versions of the library fill 12 to 17 elements.
using StatusList = std::array<int, 64>;

/// Reason why the device has switched its force off.
const char* format_cause(int cause) noexcept {
  switch (cause) {
    case 1: return "the force was switched off by the button on the base; press it to have it back";
    case 2: return "the device was faster than its limit and holds by its brakes; let it come to rest";
    case 3: return "the device has waited too long for a force and switched it off";
    case 4: return "the force was switched off by a program";
    case 5: return "the device was unplugged";
    case 6: return "the hand is not on the handle";
    default: return "the force is switched off";
  }
}

// Vendor's axes: x towards the user, y to the right, z up.
Vec3 hand_of(const Vec3& vendor) noexcept { return {vendor.y, vendor.z, vendor.x}; }
Vec3 vendor_of(const Vec3& hand) noexcept { return {hand.z, hand.x, hand.y}; }
/// The handle's turn about the hand's axes; none: not a rotation. It is none in the vendor's reference orientation.
std::optional<Turn> hand_of(const double rows[3][3]) noexcept {
  Mat3 vendor;
  for (int i = 0; i < 3; ++i) vendor.row[i] = {rows[i][0], rows[i][1], rows[i][2]};
  if (!is_rotation(vendor, rotation_error)) return std::nullopt;
  const Turn turn = turn_of(vendor);
  const Vec3 axis = hand_of({turn.x, turn.y, turn.z});
  return Turn{turn.w, axis.x, axis.y, axis.z};
}

/// Limits that the library does not report: force [N], stiffness [N/m], radius [m], damping [N·s/m], by prefix of the device's
/// name; values of CHAI3D 3.3.
struct Model {
  const char* name;
  double force_n, stiffness_n_per_m, radius_m, damping_ns_per_m;
};
constexpr Model models[] = {{"delta", 20.0, 5000.0, 0.15, 30.0},
                            {"omega", 12.0, 5000.0, 0.075, 30.0},
                            {"sigma", 12.0, 4000.0, 0.075, 30.0},
                            {"lambda", 12.0, 8000.0, 0.1125, 30.0},
                            {"falcon", 8.0, 3000.0, 0.04, 20.0}};
// For unknown names: the smallest of all.
constexpr Model unknown{"", 8.0, 3000.0, 0.04, 20.0};

const Model& model_of(std::string name) noexcept {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const Model& model : models)
    if (name.find(model.name) != std::string::npos) return model;
  return unknown;
}

std::string name_of(const Api& api, char id) {
  const char* name = api.system_name != nullptr ? api.system_name(id) : nullptr;
  std::string text = name != nullptr ? name : "device";
  std::erase_if(text, [](char c) { return c < ' ' || c > '~'; });
  return "Force Dimension " + text.substr(0, 60);
}

/// Opens devices, and finds a lost device again. The vendor's indices shift when a device is lost, so a device is identified by
/// its serial number; without a number, only at its index if it is the only device.
class Finder {
 public:
  explicit Finder(const Api& api) : api_(api) {}

  /// Opens the device at an index from 0; none: impossible, or open in this program already.
  std::optional<char> open(int index) {
    const std::lock_guard lock(mutex());
    const int id = api_.open(static_cast<char>(index));
    if (id < 0 || held().test(static_cast<std::size_t>(id))) return std::nullopt;
    index_ = index;
    number_ = number_of(static_cast<char>(id));
    name_ = name_of(api_, static_cast<char>(id));
    due_count_ = api_.device_count();
    was_alone_ = due_count_ == 1;
    // Older models cannot be opened by number. An open device is returned again.
    const int same = number_ && api_.open_serial != nullptr ? api_.open_serial(*number_) : -1;
    is_opened_by_number_ = same == id;
    if (same >= 0 && same != id) leave(same);
    return take(id);
  }
  /// Reopens the device; none: not connected. Of other devices at most the number is read, if it cannot be opened by number.
  std::optional<char> open_again() {
    const std::lock_guard lock(mutex());
    if (!number_) {
      const int id = was_alone_ && api_.device_count() == 1 ? api_.open(0) : -1;
      if (id < 0) return std::nullopt;
      return is_it(id) ? take(id) : leave(id);
    }
    if (is_opened_by_number_) {
      const int id = api_.open_serial(*number_);
      if (id < 0) return std::nullopt;
      return is_it(id) ? take(id) : leave(id);
    }
    // Try each index, if at least as many devices are connected as with this device.
    const int count = std::clamp(api_.device_count(), 0, most_devices);
    if (count < due_count_) {
      due_count_ = count + 1;
      return std::nullopt;
    }
    bool is_each_known = true;
    for (int n = 0; n < count; ++n) {
      const int index = (index_ + n) % count, id = api_.open(static_cast<char>(index));
      is_each_known = is_each_known && id >= 0;
      if (id < 0) continue;
      if (!is_it(id)) {
        leave(id);
        continue;
      }
      index_ = index;
      return take(id);
    }
    if (is_each_known) due_count_ = count + 1;
    return std::nullopt;
  }
  void close(char id) {
    const std::lock_guard lock(mutex());
    held().reset(static_cast<std::size_t>(id));
    api_.close(id);
  }

 private:
  static constexpr int most_devices = 16;

  /// Global: each search needs a list that no other open or close changes.
  static std::mutex& mutex() {
    static std::mutex of_all;
    return of_all;
  }
  /// Ids open in this program: the library returns the id of an open device again.
  std::bitset<128>& held() const {
    static std::map<const Api*, std::bitset<128>> of_libraries;
    return of_libraries[&api_];
  }
  std::optional<char> take(int id) {
    held().set(static_cast<std::size_t>(id));
    return static_cast<char>(id);
  }
  std::optional<char> leave(int id) {
    if (!held().test(static_cast<std::size_t>(id))) api_.close(static_cast<char>(id));
    return std::nullopt;
  }
  bool is_it(int id) const {
    return !held().test(static_cast<std::size_t>(id)) && number_of(static_cast<char>(id)) == number_ &&
           name_of(api_, static_cast<char>(id)) == name_;
  }
  std::optional<int> number_of(char id) const {
    unsigned short number = 0;
    if (api_.serial_number == nullptr || api_.serial_number(&number, id) < 0 || number == 0) return std::nullopt;
    return number;
  }

  const Api& api_;
  int index_ = 0;
  std::optional<int> number_;
  std::string name_;
  bool was_alone_ = false;
  bool is_opened_by_number_ = false;
  int due_count_ = 0;  // devices expected once this device is back
};

/// Exchange with a device; for the exchange's thread.
class Link {
 public:
  explicit Link(const Api& api) : api_(api), finder_(api) {}

  /// Opens the device at an index from 0.
  bool open(int index) { return begin(finder_.open(index)); }
  bool open() { return begin(finder_.open_again()); }
  void close() noexcept {
    if (id_ < 0) return;
    send({});
    api_.enable_force(0, id_);
    finder_.close(std::exchange(id_, char{-1}));
  }

  bool is_lost() const noexcept { return failures_ >= failures_to_lose; }

  DeviceState exchange(const Wrench& wrench, bool brakes) noexcept {
    DeviceState state;
    Vec3 place, speed;
    StatusList status{};
    const bool is_read =
        api_.position(&place.x, &place.y, &place.z, id_) >= 0 && is_finite(place) && api_.status(status.data(), id_) >= 0;
    if (is_read) {
      state.position_m = hand_of(place);
      state.fault = fault_of(status);
      state.valid = !is_uninitialized(status);
      if (!read_turn(state)) {
        state.valid = false;
        if (state.fault == nullptr) state.fault = "the orientation of the device's wrist cannot be read";
      }
      if (api_.velocity != nullptr && api_.velocity(&speed.x, &speed.y, &speed.z, id_) >= 0 && is_finite(speed))
        state.velocity_m_per_s = hand_of(speed);
      if (state.valid && api_.button_mask != nullptr) state.buttons = api_.button_mask(id_);
      if (status[Status::force] == 0 && status[Status::power] != 0) give_back(status, state, wrench);
    } else {
      state.fault = "the device does not answer; is it plugged in?";
    }
    if (brakes != brakes_ && api_.set_brakes != nullptr && api_.set_brakes(brakes ? 1 : 0, id_) >= 0) brakes_ = brakes;
    const bool is_written = send(state.fault != nullptr ? Wrench{} : wrench);
    if (is_read && !is_written && state.fault == nullptr) state.fault = "the device takes no force";
    failures_ = is_read ? 0 : failures_ + 1;
    return state;
  }

  char id() const noexcept { return id_; }
  bool senses_turn() const noexcept { return senses_turn_; }
  bool drives_torque() const noexcept { return drives_torque_; }

 private:
  /// False: the device has a wrist, and it cannot be read.
  bool read_turn(DeviceState& state) const noexcept {
    if (!senses_turn_) return true;
    double rows[3][3] = {};
    if (api_.orientation_frame(rows, id_) >= 0) state.turn = hand_of(rows);
    return state.turn.has_value();
  }
  bool send(const Wrench& wrench) noexcept {
    const Vec3 force_n = vendor_of(wrench.force_n), torque_nm = vendor_of(wrench.torque_nm);
    if (!drives_torque_) return api_.set_force(force_n.x, force_n.y, force_n.z, id_) >= 0;
    return api_.set_force_and_torque(force_n.x, force_n.y, force_n.z, torque_nm.x, torque_nm.y, torque_nm.z, 0.0, id_) >= 0;
  }
  bool begin(std::optional<char> id) {
    if (!id) return false;
    id_ = *id;
    failures_ = 0;
    brakes_ = false;
    if (api_.set_watchdog != nullptr) {
      if (api_.enable_expert != nullptr) api_.enable_expert();
      api_.set_watchdog(watchdog_steps, id_);
      if (api_.disable_expert != nullptr) api_.disable_expert();
    }
    senses_turn_ = api_.orientation_frame != nullptr && api_.has_wrist != nullptr && api_.has_wrist(id_);
    drives_torque_ =
        senses_turn_ && api_.set_force_and_torque != nullptr && api_.has_active_wrist != nullptr && api_.has_active_wrist(id_);
    send({});
    api_.enable_force(1, id_);
    return true;
  }
  bool is_uninitialized(const StatusList& status) const noexcept {
    return status[Status::reset] != 0 || (api_.is_initialized != nullptr && !api_.is_initialized(id_));
  }
  const char* fault_of(const StatusList& status) const noexcept {
    if (status[Status::power] == 0) return "the power supply is off: no force";
    if (is_uninitialized(status)) return "the device has no valid position: initialize it with the vendor's HapticInit";
    if (status[Status::force] == 0) return format_cause(status[Status::force_off_cause]);
    return nullptr;
  }
  /// Re-enables a force that the device has switched off only while the commanded force is zero (no surprise), and never
  /// against the user's button.
  void give_back(const StatusList& status, const DeviceState& state, const Wrench& wrench) noexcept {
    const int cause = status[Status::force_off_cause];
    const bool is_a_persons = cause == 1 || cause == 6;
    const bool is_calm = !state.velocity_m_per_s || norm(*state.velocity_m_per_s) < calm_m_per_s;
    if (!is_a_persons && is_calm && wrench == Wrench{}) api_.enable_force(1, id_);
  }

  const Api& api_;
  Finder finder_;
  char id_ = -1;
  int failures_ = 0;
  bool brakes_ = false;
  bool senses_turn_ = false, drives_torque_ = false;
};

[[noreturn]] void refuse(const std::string& what) { throw LoadError("device force-dimension: " + what); }
constexpr const char* how_to_get =
    "get the Force Dimension SDK (forcedimension.com/software/sdk), and set FORCEDIM_SDK to its folder or name the file by "
    "library=/path/libdhd.so.3";

struct Wanted {
  std::vector<std::string> files;
  std::string description = "force-dimension";  // of any device of the vendor
  int number = 1;
  bool may_move = false;
};

Wanted wanted(const DeviceSettings& given) {
  Wanted out;
  for (const auto& [key, value] : given) {
    if (key == "number") {
      if (!detail::read_number(value, out.number) || out.number < 1 || out.number > 16)
        refuse("number=" + value.substr(0, 40) + " cannot be; devices are numbered from 1");
    } else if (key == "library") {
      out.files = {value};
      out.description += ",library=" + value;
    } else if (key == "autoinit") {
      if (value != "yes" && value != "no") refuse("autoinit=" + value.substr(0, 40) + " is not known; give yes or no");
      out.may_move = value == "yes";
    } else {
      refuse("it has no setting '" + key.substr(0, 40) + "'; known are number, library and autoinit");
    }
  }
  if (!out.files.empty()) return out;
  for (const char* name : {"libdrd.so.3", "libdrd.so", "libdhd.so.3", "libdhd.so"}) {
    if (const char* sdk = std::getenv("FORCEDIM_SDK"))
      for (const char* folder : {"/lib/release/lin-x86_64-gcc/", "/lib/", "/"})
        out.files.push_back(sdk + std::string(folder) + name);
    out.files.push_back(name);
  }
  return out;
}

/// Library, loaded once per file. Throws LoadError.
const Api& api_of(const Wanted& want) {
  static std::mutex mutex;
  static std::map<std::string, std::unique_ptr<Api>> loaded;
  const std::lock_guard lock(mutex);
  std::unique_ptr<Api>& api = loaded[want.files.front()];
  if (!api || !api->library.is_there()) api = std::make_unique<Api>(want.files);
  if (!api->library.is_there()) refuse("its library cannot be loaded (" + api->library.complaint() + "); " + how_to_get);
  if (!api->library.missing().empty())
    refuse(api->library.file() + " has no " + api->library.missing() +
           "; it is not the library that this needs: " + how_to_get);
  return *api;
}

std::vector<DeviceSetting> settings() {
  return {{"number", "which of several devices, from 1; without it the first"},
          {"library", "path of libdrd or libdhd; without it looked for in $FORCEDIM_SDK and where the system has libraries"},
          {"autoinit", "yes: an arm that does not know its place may move by itself to find it, hands off; without it no"}};
}

DeviceSearch search(const DeviceSettings& given) {
  const Wanted want = wanted(given);
  const Api* api = nullptr;
  try {
    api = &api_of(want);
  } catch (const LoadError& error) {
    return {.found = {}, .missing = {error.what()}};
  }
  DeviceSearch out;
  const int count = std::clamp(api->device_count(), 0, 16);
  for (int n = 0; n < count; ++n) {
    std::string description = want.description;
    if (n > 0) description += ",number=" + std::to_string(n + 1);
    out.found.push_back(
        {description, "device " + std::to_string(n + 1) + " of those that " + api->library.file() + " has found"});
  }
  if (count == 0)
    out.missing.push_back(
        "no device is plugged in, or this user may not use it: the vendor's udev rules for USB 1451 are needed");
  return out;
}

class ForceDimension final : public Device {
 public:
  ForceDimension(const Api& api, const Wanted& want) {
    auto link = std::make_unique<Link>(api);
    if (want.number > api.device_count() || !link->open(want.number - 1))
      refuse("device " + std::to_string(want.number) +
             " cannot be opened; is it plugged in, and is no other program using it?");
    if (want.may_move && api.auto_init != nullptr && api.is_initialized != nullptr && !api.is_initialized(link->id())) {
      api.auto_init(link->id());
      if (api.stop_regulation != nullptr) api.stop_regulation(true, link->id());
    }
    name_ = force_dimension::name_of(api, link->id());
    model_ = model_of(name_);
    has_brakes_ = api.set_brakes != nullptr;
    senses_turn_ = link->senses_turn();
    most_nm_ = link->drives_torque() ? wrist_nm : 0.0;
    exchange_ = std::make_unique<ExchangeThread<Link>>(std::move(link));
  }
  std::string name() const override { return name_; }
  DeviceLimits limits() const override {
    DeviceLimits limits{.max_force_n = model_.force_n,
                        .max_stiffness_n_per_m = model_.stiffness_n_per_m,
                        .workspace_radius_m = model_.radius_m,
                        .max_damping_ns_per_m = model_.damping_ns_per_m,
                        .senses_turn = senses_turn_,
                        .max_torque_nm = most_nm_};
    if (most_nm_ > 0.0) {
      limits.max_turn_stiffness_nm_per_rad = wrist_nm_per_rad;
      limits.max_turn_damping_nms_per_rad = wrist_nms_per_rad;
    }
    return limits;
  }
  DeviceState read() noexcept override { return exchange_->read(); }
  bool write(const Vec3& force_n) noexcept override { return write(force_n, {}); }
  bool write(const Vec3& force_n, const Vec3& torque_nm) noexcept override {
    return exchange_->write({force_n, torque_nm}, model_.force_n, most_nm_);
  }
  bool brake(bool on) noexcept override {
    exchange_->brake(on);
    return has_brakes_;
  }
  bool rests() const noexcept override { return exchange_->rests(); }

 private:
  std::string name_;
  Model model_;
  bool has_brakes_ = false, senses_turn_ = false;
  double most_nm_ = 0.0;
  std::unique_ptr<ExchangeThread<Link>> exchange_;
};

std::unique_ptr<Device> open(const DeviceSettings& given) {
  const Wanted want = wanted(given);
  return std::make_unique<ForceDimension>(api_of(want), want);
}

}  // namespace
}  // namespace palpa::force_dimension

extern "C" __attribute__((visibility("default"))) const palpa::DeviceBackend palpa_device_backend;
const palpa::DeviceBackend palpa_device_backend{
    palpa::version,
    "force-dimension",
    "Force Dimension omega, delta, sigma and lambda, and Novint Falcon, by the DHD library",
    "x towards the user, y to the right, z up",
    palpa::force_dimension::settings,
    palpa::force_dimension::search,
    palpa::force_dimension::open};
