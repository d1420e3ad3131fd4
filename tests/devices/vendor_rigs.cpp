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
  ForceDimensionRig(DhdLibrary library, Wrist wrist)
      : wrist_(wrist),
        file_(library == DhdLibrary::whole ? PALPA_TESTS_DHD : PALPA_TESTS_DHD_BY_INDEX),
        stand_in_(*static_cast<const DhdStandIn*>(::dlsym(opened_library(file_), "dhd_stand_in"))),
        number_(numbers().take()) {
    stand_in().reset(number_);
    set(DhdStandIn::What::wrist, static_cast<int>(wrist_));
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
  // The vendor's words: a matrix whose columns are the handle's axes.
  void turn(const Turn& turn) override {
    const Vec3 to_user = rotated(turn, {0, 0, 1}), right = rotated(turn, {1, 0, 0}), up = rotated(turn, {0, 1, 0});
    const double rows[3][3] = {{to_user.z, right.z, up.z}, {to_user.x, right.x, up.x}, {to_user.y, right.y, up.y}};
    stand_in().turn(number_, rows);
  }
  Wrist wrist() const override { return wrist_; }
  Vec3 force_n() override {
    double made[3];
    stand_in().force_n(number_, made);
    const double to_user = made[0], right = made[1], up = made[2];
    return {right, up, to_user};
  }
  Vec3 torque_nm() override {
    double made[3];
    stand_in().torque_nm(number_, made);
    const double about_to_user = made[0], about_right = made[1], about_up = made[2];
    return {about_right, about_up, about_to_user};
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
    std::vector<Fault> all{fault("the power supply is off", DhdStandIn::What::power, 0),
                           fault("not initialized", DhdStandIn::What::initialized, 0),
                           fault("the button on the base", DhdStandIn::What::off_button, 1),
                           fault("faster than its own limit", DhdStandIn::What::speed_brake, 1),
                           fault("the library hangs", DhdStandIn::What::freezes, 1),
                           fault("positions that are no numbers", DhdStandIn::What::lies, 1),
                           fault("forces are refused", DhdStandIn::What::refuses, 1)};
    if (wrist_ != Wrist::none) all.push_back(fault("an orientation that is no rotation", DhdStandIn::What::wrist_lies, 1));
    return all;
  }

 private:
  static Numbers& numbers() {
    static Numbers all;
    return all;
  }
  const DhdStandIn& stand_in() const { return stand_in_; }
  void set(DhdStandIn::What what, int value) { stand_in().set(number_, what, value); }

  const Wrist wrist_;
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
  // The vendor's words: a matrix by columns, which are the stylus' axes.
  void turn(const Turn& turn) override {
    double transform[16] = {};
    for (int column = 0; column < 3; ++column) {
      const Vec3 axis = rotated(turn, {column == 0 ? 1.0 : 0.0, column == 1 ? 1.0 : 0.0, column == 2 ? 1.0 : 0.0});
      transform[4 * column] = axis.x;
      transform[4 * column + 1] = axis.y;
      transform[4 * column + 2] = axis.z;
    }
    transform[15] = 1.0;
    stand_in().turn(number_, transform);
  }
  Wrist wrist() const override { return Wrist::sensed; }
  void take_gimbal() override { set(HdStandIn::What::freedoms, 3); }
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
    all.push_back({"an orientation that is no rotation",
                   [this] {
                     const double none[16] = {};
                     stand_in().turn(number_, none);
                   },
                   [this] { turn({}); }});
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

std::unique_ptr<ForceDimensionRigBase> force_dimension_rig(DhdLibrary library, Rig::Wrist wrist) {
  return std::make_unique<ForceDimensionRig>(library, wrist);
}
std::unique_ptr<OpenHapticsRigBase> openhaptics_rig() { return std::make_unique<OpenHapticsRig>(); }

}  // namespace palpa
