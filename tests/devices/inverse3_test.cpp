// The Inverse3 alone: axes, messages, discovery and end. Faulty services: inverse3_wrong_test.cpp.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/devices/inverse3_fixture.h"
#include "tests/solver/counted_allocations.h"

namespace palpa {
namespace inverse3_test {

using nlohmann::json;
using std::chrono::milliseconds;
using std::chrono::seconds;
using test::Clock;
using test::force_step_n;
using test::Inverse3;
using test::Manner;
using test::message_of;
using test::patience;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

TEST_F(Inverse3, TurnsPlacesAndForcesIntoTheHandsAxes) {
  const auto device = open();
  // The service's words: x to the right, y away from the user, z up.
  const struct {
    Vec3 service, hand;
  } axes[] = {{{0.01, 0, 0}, {0.01, 0, 0}}, {{0, 0.02, 0}, {0, 0, -0.02}}, {{0, 0, 0.03}, {0, 0.03, 0}}};
  for (const auto& axis : axes) {
    service.hold(axis.service, 2.0 * axis.service);
    EXPECT_TRUE(comes(*device, {}, [&] { return state.position_m == axis.hand && state.velocity_m_per_s == 2.0 * axis.hand; }));
    EXPECT_TRUE(
        comes(*device, 50.0 * axis.hand, [&] { return distance(service.force_n(), 50.0 * axis.service) < force_step_n; }));
  }
}

TEST_F(Inverse3, CallsAForceAsTheServicesVersionDoes) {
  const struct {
    const char* version;
    bool vector;
  } versions[] = {{"3.5.1", true}, {"v3.4.9-rc1", false}, {"3.10.0", true}, {"4.0", true}, {"2.9", false},
                  {"", true},      {"new", true}};
  for (const auto& [version, vector] : versions) {
    service.set_version(version);
    service.understand(vector, !vector);
    EXPECT_TRUE(is_felt(*open(), {0.5, 1.0, -1.5})) << version;
  }
}

TEST_F(Inverse3, CallsAForceAsItIsTold) {
  service.understand(false, true);
  EXPECT_TRUE(is_felt(*open({{"force", "values"}}), {0.5, 1.0, -1.5}));
  service.set_version("3.4.0");
  service.understand(true, false);
  EXPECT_TRUE(is_felt(*open({{"force", "vector"}}), {0.5, 1.0, -1.5}));
}

TEST_F(Inverse3, SaysThatTheMotorsMakeNoForce) {
  service.understand(false, true);
  const auto device = open();
  EXPECT_TRUE(comes(*device, {1, 0, 0}, [&] { return state.fault != nullptr; }));
  EXPECT_TRUE(state.valid);
  EXPECT_THAT(state.fault, HasSubstr("values"));
  // The fault is latched: the force does not return until the power was off.
  service.understand(true, true);
  const std::int64_t messages = service.messages();
  EXPECT_TRUE(comes(*device, {1, 0, 0}, [&] { return service.messages() > messages + 20; }));
  EXPECT_THAT(state.fault, HasSubstr("values"));
  EXPECT_EQ(felt_n(), Vec3{});
  service.turn_power(false);
  EXPECT_TRUE(comes(*device, {}, [&] { return std::string_view(state.fault).find("power") != std::string_view::npos; }));
  service.turn_power(true);
  EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
}

TEST_F(Inverse3, AsksForNoMoreThanItsMotorsBear) {
  const auto device = open();
  EXPECT_EQ(device->limits().max_force_n, 3.0);
  EXPECT_TRUE(is_felt(*device, {0, 300, 400}, {0, 1.8, 2.4}));
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  for (const Vec3& no_force : {Vec3{nan, 0, 0}, Vec3{0, infinite, 0}, Vec3{1, 1, -infinite}}) {
    EXPECT_TRUE(is_felt(*device, {0, 1, 0}));
    EXPECT_TRUE(is_felt(*device, no_force, {}));
  }
  EXPECT_TRUE(is_felt(*device, {1e308, 1e308, 0}, {3 / std::sqrt(2.0), 3 / std::sqrt(2.0), 0}));
  EXPECT_TRUE(is_felt(*device, {1e-320, 0, 0}, {}));
}

TEST_F(Inverse3, NamesItsSessionFirstAndWithoutAForce) {
  { EXPECT_TRUE(is_felt(*open({{"profile", "org.example:lab"}}), {1, 0, 0})); }
  ASSERT_THAT(service.first_messages(), SizeIs(1));
  const json first = json::parse(service.first_messages().front());
  EXPECT_EQ(first["session"]["configure"]["profile"]["name"], "org.example:lab");
  EXPECT_EQ(first["inverse3"][0]["device_id"], "049D");
  EXPECT_EQ(first["inverse3"][0]["commands"]["set_cursor_force"]["vector"], json({{"x", 0}, {"y", 0}, {"z", 0}}));
  EXPECT_FALSE(json::parse(service.last_messages(1).front()).contains("session"));
}

TEST_F(Inverse3, EndsWithAForceOfZeroAndAGoodBye) {
  { EXPECT_TRUE(is_felt(*open(), {1, 0, 0})); }
  const json end = json::parse(service.last_messages(1).front());
  EXPECT_EQ(end["inverse3"][0]["commands"]["set_cursor_force"]["vector"], json({{"x", 0}, {"y", 0}, {"z", 0}}));
  EXPECT_EQ(felt_n(), Vec3{});
  const auto until = Clock::now() + patience;
  while (service.good_byes() == 0 && Clock::now() < until) std::this_thread::sleep_for(milliseconds(1));
  EXPECT_EQ(service.good_byes(), 1);
}

TEST_F(Inverse3, EndsWhateverTheServiceDoes) {
  for (const Manner manner : {Manner::silent, Manner::drip, Manner::flood, Manner::endless, Manner::slow, Manner::hangs_up}) {
    auto device = open();
    EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
    service.send(manner);
    device->write({1, 0, 0});
    std::this_thread::sleep_for(milliseconds(3));
    const auto begin = Clock::now();
    device.reset();
    EXPECT_LT(Clock::now() - begin, seconds(5)) << "of which a busy machine takes most";
    EXPECT_EQ(felt_n(), Vec3{});
    service.send(Manner::whole);
  }
}

TEST_F(Inverse3, LetsGoOfAForceThatNobodyWritesAnyMore) {
  const auto device = open();
  EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
  const std::int64_t messages = service.messages();
  const auto end = Clock::now() + patience;
  while ((felt_n() != Vec3{} || service.messages() < messages + 20) && Clock::now() < end)
    std::this_thread::sleep_for(milliseconds(1));
  EXPECT_EQ(felt_n(), Vec3{});
  EXPECT_GE(service.messages(), messages + 20) << "the link goes on without a force";
  EXPECT_TRUE(is_felt(*device, {0, 1, 0})) << "and with one when it is written again";
}

TEST_F(Inverse3, NeitherReadsNorWritesWithMemoryOfItsOwn) {
  const auto device = open();
  const long before = test::allocations;
  for (int i = 0; i < 100; ++i) {
    device->write({0.001 * i, 0, 0});
    device->read();
  }
  EXPECT_EQ(test::allocations, before);
}

TEST_F(Inverse3, ShowsTheButtonsOfBothHandles) {
  const auto device = open();
  EXPECT_TRUE(comes(*device, {}, [&] { return state.valid && state.buttons == 0; }));
  service.press_wired(true);
  EXPECT_TRUE(comes(*device, {}, [&] { return state.buttons == 1; }));
  service.press_wired(false);
  service.press_wireless(1, true);
  EXPECT_TRUE(comes(*device, {}, [&] { return state.buttons == 2; }));
  service.press_wireless(2, true);
  EXPECT_TRUE(comes(*device, {}, [&] { return state.buttons == 6; }));
}

TEST_F(Inverse3, KeepsWhatAMessageLeavesOut) {
  service.hold({0.01, 0.02, 0.03}, {});
  service.press_wireless(0, true);
  const auto device = open();
  service.tell_all(false);
  EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
  const auto left_out = json::parse(R"({"device_id":"049D"})");
  service.change_texts([&](const std::string& text) {
    json message = json::parse(text);
    message["inverse3"] = json::array({left_out});
    message.erase("wireless_verse_grip");
    return message.dump();
  });
  const std::int64_t messages = service.messages();
  EXPECT_TRUE(comes(*device, {}, [&] { return service.messages() > messages + 20 && state.valid; }));
  EXPECT_EQ(state.position_m, (Vec3{0.01, 0.03, -0.02}));
  EXPECT_EQ(state.buttons, 1u);
  service.change_texts(nullptr);
  service.hold({0, 0, 0.04}, {});
  EXPECT_TRUE(comes(*device, {}, [&] { return state.position_m == Vec3{0, 0.04, 0}; }));
}

TEST_F(Inverse3, StaysWithItsDeviceWhenThereAreTwo) {
  service.connect_second_device(true);
  service.hold({0.01, 0, 0}, {});
  const auto device = open({{"id", "049D"}});
  EXPECT_EQ(device->name(), "Haply Inverse3 049D");
  EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
  EXPECT_EQ(state.position_m, (Vec3{0.01, 0, 0}));
  service.connect_device(false);
  EXPECT_TRUE(fails(*device, {1, 0, 0}));
  EXPECT_FALSE(state.valid);
  EXPECT_THAT(state.fault, HasSubstr("not connected"));
  service.connect_device(true);
  EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
  EXPECT_EQ(state.position_m, (Vec3{0.01, 0, 0}));
  EXPECT_EQ(open()->name(), "Haply Inverse3 0BEE") << "the first";
}

TEST_F(Inverse3, SaysWhatKeepsItFromWorking) {
  const auto device = open();
  EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
  service.turn_power(false);
  EXPECT_TRUE(fails(*device, {1, 0, 0}));
  EXPECT_STREQ(state.fault, "the power supply is off: no force");
  EXPECT_TRUE(state.valid) << "it still knows its place";
  service.turn_power(true);
  EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
  service.calibrate(false);
  EXPECT_TRUE(fails(*device, {1, 0, 0}));
  EXPECT_THAT(state.fault, HasSubstr("not calibrated"));
  EXPECT_FALSE(state.valid);
  service.calibrate(true);
  EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
  service.stop();
  EXPECT_TRUE(fails(*device, {1, 0, 0}));
  EXPECT_STREQ(state.fault, "the Inverse Service is not there");
  EXPECT_FALSE(state.valid);
  EXPECT_TRUE(comes(*device, {1, 0, 0}, [&] { return !is_linked; }));
  service.start();
  EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
  EXPECT_TRUE(comes(*device, {1, 0, 0}, [&] { return is_linked; }));
}

TEST_F(Inverse3, FollowsOtherRightWaysToSendAnAnswer) {
  const auto device = open();
  for (const Manner manner : {Manner::fragments, Manner::pings}) {
    service.send(manner);
    EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
    const std::int64_t messages = service.messages();
    EXPECT_TRUE(comes(*device, {1, 0, 0}, [&] { return service.messages() > messages + 50; }));
    EXPECT_TRUE(is_felt(*device, {0, 1, 0}));
  }
}

// ---- before there is a device ----

TEST_F(Inverse3, IsFoundWithTheWordsThatOpenIt) {
  service.connect_second_device(true);
  const DeviceSearch search = device_backend("inverse3").search(settings());
  ASSERT_THAT(search.found, SizeIs(2));
  const std::string port = ",port=" + std::to_string(service.port());
  EXPECT_EQ(search.found[0].description, "inverse3,id=0BEE" + port);
  EXPECT_EQ(search.found[1].description, "inverse3,id=049D" + port);
  EXPECT_THAT(search.found[1].words, HasSubstr("Inverse3 049D"));
  EXPECT_THAT(search.missing, IsEmpty());
}

TEST_F(Inverse3, ThatIsNotThereIsMissedWithWhatToDo) {
  service.connect_device(false);
  EXPECT_THAT(device_backend("inverse3").search(settings()).found, IsEmpty());
  EXPECT_THAT(device_backend("inverse3").search(settings()).missing, ElementsAre(HasSubstr("switch on")));
  EXPECT_THAT(message_of([&] { open(); }), AllOf(HasSubstr("device inverse3: "), HasSubstr("has no Inverse3; plug one in")));
  service.connect_second_device(true);
  EXPECT_THAT(message_of([&] { open({{"id", "049D"}}); }), HasSubstr("no Inverse3 with id=049D; it has 0BEE"));
  service.stop();
  EXPECT_THAT(device_backend("inverse3").search(settings()).missing, ElementsAre(HasSubstr("haply-inverse-service")));
  EXPECT_THAT(message_of([&] { open(); }), HasSubstr("does not answer at 127.0.0.1:"));
}

TEST_F(Inverse3, IsNotOpenedWhereNothingComesBack) {
  service.send(Manner::silent);
  EXPECT_THAT(message_of([&] { open(); }), HasSubstr("device inverse3: the service does not answer"));
}

TEST(Inverse3Settings, ThatCannotBeAreRefusedWithWhatCan) {
  const struct {
    DeviceSettings settings;
    const char* words;
  } refused[] = {
      {{{"speed", "3"}}, "no setting 'speed'; known are id, host, port, force, grip, profile and remote"},
      {{{"a\nb", ""}}, "no setting 'a?b'"},
      {{{"host", "192.168.1.20"}}, "give remote=yes"},
      {{{"host", "::ffff:10.0.0.1"}}, "give remote=yes"},
      {{{"host", "0.0.0.0"}}, "give remote=yes"},
      {{{"remote", "no"}, {"host", "8.8.8.8"}}, "give remote=yes"},
      {{{"remote", "maybe"}}, "give yes or no"},
      {{{"host", "haply.example"}}, "is no address"},
      {{{"host", ""}}, "is no address"},
      {{{"port", "0"}}, "1 to 65535"},
      {{{"port", "65536"}}, "1 to 65535"},
      {{{"port", "10001x"}}, "1 to 65535"},
      {{{"port", ""}}, "1 to 65535"},
      {{{"force", "both"}}, "auto, vector or values"},
      {{{"id", ""}}, "letters"},
      {{{"id", "\"},{"}}, "letters"},
      {{{"profile", "a b"}}, "letters"},
      {{{"profile", std::string(10000, 'a')}}, "letters"},
  };
  for (const auto& [settings, words] : refused) {
    for (const auto& use : {std::function<void()>([&] { device_backend("inverse3").open(settings); }),
                            std::function<void()>([&] { device_backend("inverse3").search(settings); })}) {
      const std::string said = message_of(use);
      EXPECT_THAT(said, AllOf(testing::StartsWith("device inverse3: "), HasSubstr(words)));
      EXPECT_THAT(said, Not(HasSubstr("\n")));
      EXPECT_LT(said.size(), 400u);
    }
  }
  EXPECT_THAT(device_backend("inverse3").settings(), SizeIs(7));
}

// ---- a service of another making ----

/// tests/devices/inverse3_peer.py, until the end of this object.
class Peer {
 public:
  Peer() {
    int to[2], from[2];
    if (pipe(to) != 0 || pipe(from) != 0) throw std::runtime_error("no pipe");
    child_ = fork();
    if (child_ == 0) {
      dup2(to[0], STDIN_FILENO);
      dup2(from[1], STDOUT_FILENO);
      for (const int end : {to[0], to[1], from[0], from[1]}) close(end);
      execl("/usr/bin/python3", "python3", PALPA_TESTS_INVERSE3_PEER, nullptr);
      _exit(3);
    }
    close(to[0]);
    close(from[1]);
    input_ = to[1];
    char line[16] = {};
    std::FILE* output = fdopen(from[0], "r");
    if (std::fgets(line, sizeof line, output) != nullptr) port_ = line;
    std::fclose(output);
    while (!port_.empty() && port_.back() == '\n') port_.pop_back();
  }
  ~Peer() {
    close(input_);
    waitpid(child_, nullptr, 0);
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  const std::string& port() const { return port_; }  ///< empty: not started

 private:
  pid_t child_ = 0;
  int input_ = -1;
  std::string port_;
};

TEST(Inverse3Peer, AgreesWithAnotherServersWebSocket) {
  const Peer peer;
  if (peer.port().empty()) GTEST_SKIP() << "python3-websockets is not here";
  const auto device = device_backend("inverse3").open({{"port", peer.port()}});
  EXPECT_EQ(device->name(), "Haply Inverse3 PY01");
  // Its arm is a spring of 100 N/m.
  for (const Vec3& force_n : {Vec3{1, 0, 0}, Vec3{0, 1.5, 0}, Vec3{0, 0, 2}, Vec3{-0.5, 1, 0.25}}) {
    DeviceState state;
    const auto end = Clock::now() + patience;
    do {
      device->write(force_n);
      std::this_thread::sleep_for(milliseconds(1));
      state = device->read();
    } while (!(state.valid && distance(state.position_m, force_n / 100.0) < 1e-12) && Clock::now() < end);
    EXPECT_LT(distance(state.position_m, force_n / 100.0), 1e-12);
    EXPECT_EQ(state.fault, nullptr);
    ASSERT_TRUE(state.turn);
    EXPECT_LT(distance(rotated(*state.turn, {1, 0, 0}), {0, -1, 0}), 1e-9) << "to the right becomes down";
  }
  DeviceState state = device->read();
  for (const auto end = Clock::now() + patience; state.position_m != Vec3{} && Clock::now() < end; state = device->read())
    std::this_thread::sleep_for(milliseconds(1));
  EXPECT_EQ(state.position_m, Vec3{}) << "the force ends when nobody writes";
}

}  // namespace inverse3_test
}  // namespace palpa
