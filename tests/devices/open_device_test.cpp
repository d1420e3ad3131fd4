// Devices by name, and lower limits in a user's devices.toml.
#include "palpa/device/open_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <iterator>

#include "palpa/base/load_error.h"
#include "tests/devices/dhd_stand_in.h"
#include "tests/devices/vendor_rigs.h"

namespace palpa {
namespace open_device_test {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

std::string message_of(const std::function<void()>& refused) {
  try {
    refused();
  } catch (const LoadError& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(DeviceDescription, IsANameAndSettings) {
  const DeviceDescription description = device_description("inverse3,port=10002,id=04A=D");
  EXPECT_EQ(description.name, "inverse3");
  EXPECT_THAT(description.settings, ElementsAre(std::pair<std::string, std::string>("port", "10002"),
                                                std::pair<std::string, std::string>("id", "04A=D")));
  for (const char* wrong : {"", ",", "inverse3,port", "inverse3,=1", "inverse3,,", "../evil", "a b"})
    EXPECT_THAT(message_of([&] { device_description(wrong); }), HasSubstr("device: ")) << wrong;
}

TEST(DeviceBackends, AreAllThere) {
  std::vector<std::string> names;
  for (const DeviceBackend* backend : device_backends()) names.emplace_back(backend->name);
  EXPECT_THAT(names, ElementsAre("controller", "force-dimension", "igtl", "inverse3", "openhaptics", "spacemouse"));
  EXPECT_THAT(message_of([] { device_backend("inverse4"); }), AllOf(HasSubstr("inverse4"), HasSubstr("inverse3")));
  EXPECT_THAT(message_of([] { device_backend("foo"); }), AllOf(HasSubstr("inverse3"), HasSubstr("spacemouse")));
}

class DevicesToml : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "palpa-devices-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder = name;
    file = folder / "new" / "devices.toml";
  }
  void TearDown() override { fs::remove_all(folder); }
  void write(const std::string& text) const {
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  std::string refusal() const {
    return message_of([this] { device_notes(file, "touch"); });
  }
  std::string text() const {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  fs::path folder, file;
};

TEST_F(DevicesToml, IsNotNeeded) { EXPECT_EQ(device_notes(file, "touch"), DeviceNotes{}); }

TEST_F(DevicesToml, LowersLimits) {
  write("[touch]\nmax_force_n = 1.5\ncontinuous_force_n = 0.5\n[omega]\nmax_force_n = 9\n");
  const DeviceNotes notes = device_notes(file, "touch");
  const DeviceLimits limits = with_notes({.max_force_n = 3.3, .continuous_force_n = 0.88}, notes, "here");
  EXPECT_EQ(limits.max_force_n, 1.5);
  EXPECT_EQ(limits.continuous_force_n, 0.5);
  EXPECT_EQ(limits.max_stiffness_n_per_m, DeviceLimits{}.max_stiffness_n_per_m);
}

TEST_F(DevicesToml, NeverRaisesOne) {
  for (const char* line :
       {"max_force_n = 3.4", "continuous_force_n = 0.9", "max_stiffness_n_per_m = 2001", "max_damping_ns_per_m = 6",
        "max_torque_nm = 0.21", "max_turn_stiffness_nm_per_rad = 1.1", "max_turn_damping_nms_per_rad = 0.08"}) {
    write("[touch]\n" + std::string(line) + "\n");
    const std::string words = message_of([&] {
      with_notes({.max_force_n = 3.3,
                  .max_stiffness_n_per_m = 2000,
                  .continuous_force_n = 0.88,
                  .max_damping_ns_per_m = 5,
                  .max_torque_nm = 0.2,
                  .max_turn_stiffness_nm_per_rad = 1,
                  .max_turn_damping_nms_per_rad = 0.07},
                 device_notes(file, "touch"), "HERE");
    });
    EXPECT_THAT(words, AllOf(HasSubstr("HERE"), HasSubstr(std::string(line).substr(0, 12)), Not(HasSubstr("\n")))) << line;
  }
}

TEST_F(DevicesToml, ThatIsWrongIsRefusedWithItsPlace) {
  for (const char* wrong : {"[touch\n", "[touch]\nmax_force_n = \"3\"\n", "[touch]\nmax_force_n = nan\n",
                            "[touch]\nmax_force_n = -1\n", "[touch]\nmax_force = 1\n", "touch = 3\n",
                            "[touch]\nmax_force_n = 1e300\n", "[touch]\nmax_force_n = inf\n", "\xff\xfe"}) {
    write(wrong);
    EXPECT_THAT(refusal(), AllOf(HasSubstr("devices.toml"), Not(HasSubstr("\n")))) << wrong;
  }
  std::string deep = "[touch]\na";
  for (int n = 0; n < 100000; ++n) deep += ".a";
  write(deep + " = 1\n");
  EXPECT_THAT(refusal(), HasSubstr("devices.toml"));
  fs::remove(file);
  fs::create_directory(file);
  EXPECT_THAT(refusal(), HasSubstr("devices.toml"));
}

TEST_F(DevicesToml, KeepsWhatWasMeasuredAndAllElse) {
  keep_device_notes(file, "touch", {.encoder_step_m = 2e-5, .damping_ns_per_m = 0.4});
  EXPECT_EQ(device_notes(file, "touch"), (DeviceNotes{.encoder_step_m = 2e-5, .damping_ns_per_m = 0.4}));
  write("[touch]\nmax_force_n = 1\n[omega]\nmax_force_n = 9\n");
  DeviceNotes notes = device_notes(file, "touch");
  notes.encoder_step_m = 3e-5;
  keep_device_notes(file, "touch", notes);
  EXPECT_EQ(device_notes(file, "touch"), (DeviceNotes{.max_force_n = 1, .encoder_step_m = 3e-5}));
  EXPECT_EQ(device_notes(file, "omega").max_force_n, 9);
}

TEST_F(DevicesToml, HoldsADeviceThatIsOpened) {
  const DeviceDescription description{.name = "force-dimension", .settings = {{"library", PALPA_TESTS_DHD}}};
  const auto rig = force_dimension_rig();
  write("[force-dimension]\nmax_force_n = 2\nencoder_step_m = 1e-5\n");
  {
    const auto device = open_device(description, file);
    EXPECT_EQ(device->limits().max_force_n, 2.0);
    EXPECT_EQ(device->limits().encoder_step_m, 1e-5);
    for (int n = 0; n < 2000 && norm(rig->force_n()) == 0.0; ++n) {
      device->write({100, 0, 0});
      ::usleep(1000);
    }
    EXPECT_NEAR(norm(rig->force_n()), 2.0, 1e-9);
  }
  write("[force-dimension]\nmax_force_n = 13\n");
  EXPECT_THAT(message_of([&] { open_device(description, file); }), AllOf(HasSubstr("devices.toml"), HasSubstr("13")));
}

TEST_F(DevicesToml, HoldsTheTorqueOfADeviceThatIsOpened) {
  const DeviceDescription description{.name = "force-dimension", .settings = {{"library", PALPA_TESTS_DHD}}};
  const auto rig = force_dimension_rig(DhdLibrary::whole, Rig::Wrist::driven);
  write("[force-dimension]\nmax_torque_nm = 0.05\nmax_turn_stiffness_nm_per_rad = 0.5\n");
  const auto device = open_device(description, file);
  EXPECT_EQ(device->limits().max_torque_nm, 0.05);
  EXPECT_EQ(device->limits().max_turn_stiffness_nm_per_rad, 0.5);
  for (int n = 0; n < 2000 && norm(rig->torque_nm()) == 0.0; ++n) {
    device->write({1, 0, 0}, {0, 3, 4});
    ::usleep(1000);
  }
  EXPECT_NEAR(distance(rig->torque_nm(), {0, 0.03, 0.04}), 0.0, 1e-9);
  EXPECT_NEAR(distance(rig->force_n(), {1, 0, 0}), 0.0, 1e-9);
}

TEST_F(DevicesToml, LiesWhereTheUserHasSuchFiles) {
  ::unsetenv("PALPA_DEVICES");
  ::setenv("XDG_CONFIG_HOME", "/config", 1);
  EXPECT_EQ(device_notes_file(), "/config/palpa/devices.toml");
  ::unsetenv("XDG_CONFIG_HOME");
  ::setenv("HOME", "/home/somebody", 1);
  EXPECT_EQ(device_notes_file(), "/home/somebody/.config/palpa/devices.toml");
  ::setenv("PALPA_DEVICES", "/tmp/mine.toml", 1);
  EXPECT_EQ(device_notes_file(), "/tmp/mine.toml");
  ::unsetenv("PALPA_DEVICES");
}

}  // namespace open_device_test
}  // namespace palpa
