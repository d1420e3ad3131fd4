#include "tests/devices/vendor_rigs.h"

#include <dlfcn.h>

#include <stdexcept>

#include "palpa/device/open_device.h"
#include "tests/devices/dhd_stand_in.h"
#include "tests/devices/hd_stand_in.h"

namespace palpa {

namespace {

using test::DhdStandIn;
using test::HdStandIn;

void* opened_library(const std::string& file) {
  void* library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) throw std::runtime_error(::dlerror());
  return library;
}

/// At most two of each kind at a time.
class Numbers {
 public:
  bool is_taken(int n) const { return taken_[n]; }
  int take() {
    for (int n = 0; n < 2; ++n)
      if (!taken_[n]) {
        taken_[n] = true;
        return n;
      }
    throw std::runtime_error("the stand-in has two devices");
  }
  void give_back(int n) { taken_[n] = false; }

 private:
  bool taken_[2] = {};
};

class ForceDimensionRig final : public ForceDimensionRigBase {
 public:
  explicit ForceDimensionRig(DhdLibrary library)
      : file_(library == DhdLibrary::whole ? PALPA_TESTS_DHD : PALPA_TESTS_DHD_BY_INDEX),
        stand_in_(*static_cast<const DhdStandIn*>(::dlsym(opened_library(file_), "dhd_stand_in"))),
        number_(numbers().take()) {
    stand_in().reset(number_);
    if (!numbers().is_taken(1 - number_)) unplug_another();
  }
  ~ForceDimensionRig() override {
    unplug();
    numbers().give_back(number_);
  }
  std::unique_ptr<Device> open() override {
    // By its index among the connected devices.
    const bool is_second = number_ == 1 && (is_another_there_ || numbers().is_taken(0));
    return opened("force-dimension", {{"library", file_}, {"number", is_second ? "2" : "1"}});
  }
  // The vendor's words: x towards the user, y to the right of the user, z up.
  void hold(const Vec3& position_m, const Vec3& velocity_m_per_s) override {
    const double right = position_m.x, up = position_m.y, to_user = position_m.z;
    const double place[3] = {to_user, right, up};
    const double speed[3] = {velocity_m_per_s.z, velocity_m_per_s.x, velocity_m_per_s.y};
    stand_in().hold(number_, place, speed);
  }
  Vec3 force_n() override {
    double made[3];
    stand_in().force_n(number_, made);
    const double to_user = made[0], right = made[1], up = made[2];
    return {right, up, to_user};
  }
  void press_button(int number, bool down) override {
    buttons_ = down ? buttons_ | (1 << number) : buttons_ & ~(1 << number);
    set(DhdStandIn::What::buttons, buttons_);
  }
  bool brakes() override { return stand_in().brakes(number_); }
  void unplug() override { set(DhdStandIn::What::there, 0); }
  void plug() override { set(DhdStandIn::What::there, 1); }
  void plug_another() override {
    stand_in().reset(1 - number_);
    const double place[3] = {0.05, 0.05, 0.05}, speed[3] = {};
    stand_in().hold(1 - number_, place, speed);
    stand_in().set(1 - number_, DhdStandIn::What::buttons, 1);
    is_another_there_ = true;
  }
  void unplug_another() override {
    stand_in().set(1 - number_, DhdStandIn::What::there, 0);
    is_another_there_ = false;
  }
  bool is_another_touched() override { return stand_in().is_touched(1 - number_); }
  std::vector<Fault> faults() override {
    const auto fault = [this](const char* name, DhdStandIn::What what, int wrong) {
      return Fault{name, [this, what, wrong] { set(what, wrong); }, [this, what, wrong] { set(what, 1 - wrong); }};
    };
    return {fault("the power supply is off", DhdStandIn::What::power, 0),
            fault("not initialized", DhdStandIn::What::initialized, 0),
            fault("the button on the base", DhdStandIn::What::off_button, 1),
            fault("faster than its own limit", DhdStandIn::What::speed_brake, 1),
            fault("the library hangs", DhdStandIn::What::freezes, 1),
            fault("positions that are no numbers", DhdStandIn::What::lies, 1),
            fault("forces are refused", DhdStandIn::What::refuses, 1)};
  }

 private:
  static Numbers& numbers() {
    static Numbers all;
    return all;
  }
  const DhdStandIn& stand_in() const { return stand_in_; }
  void set(DhdStandIn::What what, int value) { stand_in().set(number_, what, value); }

  const std::string file_;
  const DhdStandIn& stand_in_;
  const int number_;
  bool is_another_there_ = false;
  int buttons_ = 0;
};

class OpenHapticsRig final : public OpenHapticsRigBase {
 public:
  OpenHapticsRig() : number_(numbers().take()) {
    stand_in().reset(number_);
    if (!numbers().is_taken(1 - number_)) unplug_another();
  }
  ~OpenHapticsRig() override {
    unplug();
    numbers().give_back(number_);
  }
  std::unique_ptr<Device> open() override {
    DeviceSettings settings{{"library", PALPA_TESTS_HD}};
    if (number_ == 1) settings.emplace_back("name", "second");
    return opened("openhaptics", settings);
  }
  // The vendor's words: millimetres, x to the right, y up, z towards the user.
  void hold(const Vec3& position_m, const Vec3& velocity_m_per_s) override {
    const double place[3] = {1000 * position_m.x, 1000 * position_m.y, 1000 * position_m.z};
    const double speed[3] = {1000 * velocity_m_per_s.x, 1000 * velocity_m_per_s.y, 1000 * velocity_m_per_s.z};
    stand_in().hold(number_, place, speed);
  }
  Vec3 force_n() override {
    double made[3];
    stand_in().force_n(number_, made);
    return {made[0], made[1], made[2]};
  }
  void press_button(int number, bool down) override {
    buttons_ = down ? buttons_ | (1 << number) : buttons_ & ~(1 << number);
    set(HdStandIn::What::buttons, buttons_);
  }
  void warm(double share) override { set(HdStandIn::What::warm, static_cast<int>(100.0 * share)); }
  void unplug() override { set(HdStandIn::What::there, 0); }
  void plug() override { set(HdStandIn::What::there, 1); }
  void plug_another() override {
    stand_in().reset(1 - number_);
    const double place[3] = {50, 50, 50}, speed[3] = {};
    stand_in().hold(1 - number_, place, speed);
    stand_in().set(1 - number_, HdStandIn::What::buttons, 1);
  }
  void unplug_another() override { stand_in().set(1 - number_, HdStandIn::What::there, 0); }
  bool is_another_touched() override { return stand_in().is_touched(1 - number_); }
  std::vector<Fault> faults() override {
    std::vector<Fault> all;
    for (const int code : {0x0200, 0x0201, 0x0202, 0x0203, 0x0204, 0x0300, 0x0302, 0x0304, 0x0999})
      all.push_back({"error " + std::to_string(code), [this, code] { set(HdStandIn::What::error, code); },
                     [this] { set(HdStandIn::What::error, 0); }});
    all.push_back(
        {"not calibrated", [this] { set(HdStandIn::What::calibrated, 0); }, [this] { set(HdStandIn::What::calibrated, 1); }});
    all.push_back({"the library's thread stalls", [this] { set(HdStandIn::What::stalls, 1); },
                   [this] { set(HdStandIn::What::stalls, 0); }});
    return all;
  }

 private:
  static Numbers& numbers() {
    static Numbers all;
    return all;
  }
  static const HdStandIn& stand_in() {
    static const auto* const found = static_cast<const HdStandIn*>(::dlsym(opened_library(PALPA_TESTS_HD), "hd_stand_in"));
    return *found;
  }
  void set(HdStandIn::What what, int value) { stand_in().set(number_, what, value); }

  int number_;
  int buttons_ = 0;
};

}  // namespace

std::unique_ptr<ForceDimensionRigBase> force_dimension_rig(DhdLibrary library) {
  return std::make_unique<ForceDimensionRig>(library);
}
std::unique_ptr<OpenHapticsRigBase> openhaptics_rig() { return std::make_unique<OpenHapticsRig>(); }

}  // namespace palpa
