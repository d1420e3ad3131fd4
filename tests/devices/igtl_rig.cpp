#include "tests/devices/igtl_rig.h"

#include "palpa/device/open_device.h"
#include "palpa/solver/pose.h"
#include "tests/devices/igtl_stand_in.h"

namespace palpa {

namespace test {

// The protocol's words: R to the patient's right, A to the front, S to the head. The user is in front of the patient.
Vec3 ras_from_hand(const Vec3& hand) {
  const double right = hand.x, up = hand.y, towards_user = hand.z;
  return {-right, towards_user, up};
}

}  // namespace test

namespace {

class IgtlRig final : public Rig {
 public:
  IgtlRig() { plug(); }
  std::unique_ptr<Device> open() override { return opened("igtl", {{"port", std::to_string(server_.port())}}); }
  void hold(const Vec3& position_m, const Vec3&) override {
    pose_.place_mm = 1e3 * test::ras_from_hand(position_m);
    if (is_there_) plug();
  }
  void turn(const Turn& turn) override {
    const auto axis = [&](const Vec3& of_hand) { return test::ras_from_hand(rotated(turn, of_hand)); };
    // Images of the axes of RAS, that is of the hand's -x, z and y.
    const Vec3 r = -axis({1, 0, 0}), a = axis({0, 0, 1}), s = axis({0, 1, 0});
    pose_.rotation = {{{r.x, a.x, s.x}, {r.y, a.y, s.y}, {r.z, a.z, s.z}}};
    if (is_there_) plug();
  }
  Wrist wrist() const override { return Wrist::sensed; }
  double turn_rate_hz() const override { return 100.0; }
  double position_step_m() const override { return 1e-7; }
  bool has_buttons() const override { return false; }
  Vec3 force_n() override { return {}; }
  void press_button(int, bool) override {}
  void unplug() override {
    is_there_ = false;
    server_.hide("Stylus");
  }
  void plug() override {
    is_there_ = true;
    server_.hold("Stylus", pose_);
  }
  void plug_another() override { server_.hold("Another", {.rotation = Mat3::identity(), .place_mm = {900, 900, 900}}); }
  void unplug_another() override { server_.hide("Another"); }
  bool is_another_touched() override { return server_.has_received(); }
  std::vector<Fault> ways_to_go() override {
    std::vector<Fault> ways = Rig::ways_to_go();
    ways.push_back({"the server ends", [this] { server_.stop(); }, [this] { server_.start(); }});
    return ways;
  }
  std::vector<Fault> faults() override {
    const auto sends = [this](const char* name, std::function<std::string(const std::string&)> change) {
      return Fault{name, [this, change] { server_.change(change); }, [this] { server_.change(nullptr); }};
    };
    return {sends("wrong checksums", [](std::string message) { return ++message.back(), message; }),
            sends("messages that are cut", [](const std::string& message) { return message.substr(0, 50); }),
            sends("a huge length", [](std::string message) { return message[42] = 0x10, message; }),
            sends("no OpenIGTLink", [](const std::string&) { return std::string("HTTP/1.1 400 Bad Request\r\n\r\n"); }),
            sends("no rotation", [](const std::string&) {
              return test::transform_message("Stylus", {.rotation = 2.0 * Mat3::identity(), .place_mm = {}});
            })};
  }

 private:
  test::IgtlStandIn server_;
  test::SentPose pose_;
  bool is_there_ = true;
};

}  // namespace

std::unique_ptr<Rig> igtl_rig() { return std::make_unique<IgtlRig>(); }

}  // namespace palpa
