#include "tests/devices/inverse3_rig.h"

#include "palpa/device/open_device.h"

namespace palpa {

namespace test {

Vec3 service_from_hand(const Vec3& hand) {
  const double right = hand.x, up = hand.y, towards_user = hand.z;
  return {right, -towards_user, up};
}
Vec3 hand_from_service(const Vec3& service) {
  const double right = service.x, forward = service.y, up = service.z;
  return {right, up, -forward};
}

}  // namespace test

namespace {

class Inverse3Rig final : public Rig {
 public:
  std::unique_ptr<Device> open() override {
    return opened("inverse3", {{"id", "049D"}, {"port", std::to_string(service_.port())}});
  }
  void hold(const Vec3& position_m, const Vec3& velocity_m_per_s) override {
    service_.hold(test::service_from_hand(position_m), test::service_from_hand(velocity_m_per_s));
  }
  void turn(const Turn& turn) override {
    const Vec3 axis = test::service_from_hand({turn.x, turn.y, turn.z});
    service_.turn_grip({turn.w, axis.x, axis.y, axis.z});
  }
  Wrist wrist() const override { return Wrist::sensed; }
  double turn_rate_hz() const override { return 50.0; }
  Vec3 force_n() override { return test::hand_from_service(service_.force_n()); }
  void press_button(int number, bool down) override { service_.press_wireless(number, down); }
  void unplug() override { service_.connect_device(false); }
  void plug() override { service_.connect_device(true); }
  void plug_another() override { service_.connect_second_device(true); }
  void unplug_another() override { service_.connect_second_device(false); }
  bool is_another_touched() override { return service_.is_second_touched(); }
  std::vector<Fault> ways_to_go() override {
    std::vector<Fault> ways = Rig::ways_to_go();
    ways.push_back({"the service ends", [this] { service_.stop(); }, [this] { service_.start(); }});
    return ways;
  }
  std::vector<Fault> ways_of_a_handle_to_go() override {
    return {{"out of the list", [this] { service_.connect_grip(false); }, [this] { service_.connect_grip(true); }},
            {"not connected", [this] { service_.tell_grip_is_gone(true); }, [this] { service_.tell_grip_is_gone(false); }}};
  }
  std::vector<Fault> faults() override {
    using Manner = test::Inverse3StandIn::Manner;
    const auto sends = [this](const char* name, Manner manner) {
      return Fault{name, [this, manner] { service_.send(manner); }, [this] { service_.send(Manner::whole); }};
    };
    return {
        {"the power supply is off", [this] { service_.turn_power(false); }, [this] { service_.turn_power(true); }},
        {"not calibrated", [this] { service_.calibrate(false); }, [this] { service_.calibrate(true); }},
        {"the service ends", [this] { service_.stop(); }, [this] { service_.start(); }},
        {"no JSON", [this] { service_.change_texts([](const std::string&) { return "{"; }); },
         [this] { service_.change_texts(nullptr); }},
        sends("answers stay out", Manner::silent),
        sends("slow answers", Manner::slow),
        sends("answers that drip", Manner::drip),
        sends("a flood", Manner::flood),
        sends("a huge frame", Manner::huge),
        sends("the service goes away", Manner::goes_away),
    };
  }

 private:
  test::Inverse3StandIn service_;
};

}  // namespace

std::unique_ptr<Device> opened(const std::string& backend, const DeviceSettings& settings) {
  return open_device({.name = backend, .settings = settings}, "/nowhere/devices.toml");
}

std::unique_ptr<Rig> inverse3_rig() { return std::make_unique<Inverse3Rig>(); }

}  // namespace palpa
