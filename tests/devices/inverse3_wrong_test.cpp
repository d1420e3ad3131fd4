// Faulty services of an Inverse3: the force is lost, never the program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <chrono>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>

#include "palpa/device/inverse3_messages.h"
#include "tests/devices/inverse3_fixture.h"

namespace palpa {
namespace inverse3_wrong_test {

using nlohmann::json;
using std::chrono::milliseconds;
using test::Clock;
using test::Inverse3;
using test::Inverse3StandIn;
using test::Manner;
using test::message_of;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

struct Wrong {
  const char* name;
  std::function<void(Inverse3StandIn&)> begin;
};
void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.name; }

Wrong sends(const char* name, Manner manner) {
  return {name, [manner](Inverse3StandIn& service) { service.send(manner); }};
}
Wrong says(const char* name, const std::string& text) {
  return {name, [text](Inverse3StandIn& service) { service.change_texts([text](const std::string&) { return text; }); }};
}
/// Replaces a value by a text, which need not be JSON.
std::string with(const std::string& message, const std::string& pointer, const std::string& text) {
  json changed = json::parse(message);
  constexpr const char* mark = "\"the place\"";
  changed[json::json_pointer(pointer)] = "the place";
  std::string out = changed.dump();
  return out.replace(out.find(mark), std::string_view(mark).size(), text);
}
Wrong puts(const char* name, const std::string& pointer, const std::string& text) {
  return {name, [=](Inverse3StandIn& service) {
            service.change_texts([=](const std::string& message) { return with(message, pointer, text); });
          }};
}
std::string times(std::size_t count, const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < count; ++i) out += text;
  return out;
}

const std::vector<Wrong>& wrongs() {
  static const std::string place = "/inverse3/0/state/cursor_position";
  static const std::vector<Wrong> all{
      sends("Slow", Manner::slow),
      sends("Drip", Manner::drip),
      sends("Silent", Manner::silent),
      sends("Flood", Manner::flood),
      sends("Binary", Manner::binary),
      sends("HugeFrame", Manner::huge),
      sends("EndlessFragments", Manner::endless),
      sends("WrongFrame", Manner::wrong_frame),
      sends("GoesAway", Manner::goes_away),
      sends("HangsUp", Manner::hangs_up),
      says("Empty", ""),
      says("NoJson", "{\"inverse3\":["),
      says("NoUtf8", "{\"inverse3\":\"\xff\xfe\"}"),
      says("Zeros", std::string(100, '\0')),
      says("Null", "null"),
      says("Number", "1e999"),
      says("Array", "[]"),
      says("Deep", times(100000, "[")),
      says("DeepAndClosed", times(50000, "{\"inverse3\":") + "1" + times(50000, "}")),
      says("ManyDevices", "{\"inverse3\":[" + times(9000, R"({"device_id":"049D"},)") + R"({"device_id":"049D"}]})"),
      says("Large", "{\"x\":\"" + std::string(std::size_t{300} << 10, 'x') + "\"}"),
      says("NoDevice", R"({"inverse3":[]})"),
      says("NoList", "{}"),
      puts("ListIsObject", "/inverse3", "{}"),
      puts("EntryIsNumber", "/inverse3/0", "1"),
      puts("EntryIsNull", "/inverse3/0", "null"),
      puts("IdIsNumber", "/inverse3/0/device_id", "49"),
      puts("IdIsLong", "/inverse3/0/device_id", '"' + std::string(1000, 'A') + '"'),
      puts("IdWithControlCharacters", "/inverse3/0/device_id", R"("\u001b[2J\n")"),
      puts("StateIsText", "/inverse3/0/state", "\"idle\""),
      puts("PlaceIsArray", place, "[1,2,3]"),
      puts("PlaceIsNull", place, "null"),
      puts("PlaceWithoutZ", place, R"({"x":0,"y":0})"),
      puts("PlaceIsText", place + "/x", "\"0\""),
      puts("PlaceIsTrue", place + "/y", "true"),
      puts("PlaceIsNan", place + "/z", "NaN"),
      puts("PlaceIsInfinite", place + "/z", "-Infinity"),
      puts("PlaceIsTooLarge", place + "/x", "1e999"),
      puts("PlaceIsFarAway", place + "/x", "-1e300"),
      puts("VelocityIsText", "/inverse3/0/state/cursor_velocity", "\"fast\""),
      puts("ForceIsNumber", "/inverse3/0/state/current_cursor_force", "1"),
      puts("StatusIsArray", "/inverse3/0/status", "[]"),
      puts("PowerIsNumber", "/inverse3/0/status/power_supply", "1"),
      puts("CalibratedIsText", "/inverse3/0/status/calibrated", "\"false\""),
      puts("GripsAreNumber", "/verse_grip", "7"),
      puts("ButtonIsText", "/verse_grip/0/state/button", "\"down\""),
      puts("ButtonsAreArray", "/wireless_verse_grip/0/state/buttons", "[true]"),
  };
  return all;
}

class Inverse3Wrong : public Inverse3, public testing::WithParamInterface<Wrong> {
 protected:
  void expect_no_force(Device& device) {
    const auto end = Clock::now() + milliseconds(100);
    while (Clock::now() < end) {
      EXPECT_TRUE(comes(device, {1, 1, 1}, [] { return true; }));
      EXPECT_NE(state.fault, nullptr);
      EXPECT_FALSE(state.valid);
      ASSERT_EQ(felt_n(), Vec3{});
    }
  }
};

TEST_P(Inverse3Wrong, CostsTheForceUntilItIsRightAgain) {
  const auto device = open();
  ASSERT_TRUE(is_felt(*device, {1, 0, 0}));
  GetParam().begin(service);
  EXPECT_TRUE(fails(*device, {1, 0, 0}));
  expect_no_force(*device);
  service.send(Manner::whole);
  service.change_texts(nullptr);
  EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
}

INSTANTIATE_TEST_SUITE_P(Services, Inverse3Wrong, testing::ValuesIn(wrongs()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_F(Inverse3, BearsAnAnswerTwice) {
  const auto device = open();
  EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
  service.send(Manner::twice);
  const std::int64_t messages = service.messages();
  EXPECT_TRUE(comes(*device, {1, 0, 0}, [&] { return service.messages() > messages + 50; }));
  service.send(Manner::whole);
  EXPECT_TRUE(is_felt(*device, {0, 0, 1}));
}

TEST_F(Inverse3, BearsAWordInBetweenThatItDoesNotUnderstand) {
  const auto device = open();
  EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
  int count = 0;
  service.change_texts([&count](const std::string& text) { return ++count % 3 == 0 ? text : "{"; });
  const std::int64_t messages = service.messages();
  EXPECT_TRUE(comes(*device, {1, 0, 0}, [&] { return service.messages() > messages + 50; }));
  EXPECT_TRUE(is_felt(*device, {0, 1, 0}));
  EXPECT_THAT(service.first_messages(), SizeIs(1)) << "it was never connected anew";
}

TEST_F(Inverse3, IsNotOpenedByAServiceThatBeginsWithNonsense) {
  for (const std::string text :
       {"", "{", "[]", R"({"inverse3":[{"device_id":"a b"}]})", R"({"inverse3":[{"device_id":"A"},{}]})"}) {
    service.change_texts([&](const std::string&) { return text; }, true);
    EXPECT_THAT(message_of([&] { open(); }), HasSubstr("device inverse3: the Inverse Service does not answer"));
    EXPECT_THAT(device_backend("inverse3").search(settings()).missing, SizeIs(1));
  }
  // After a good start the connection is retried.
  service.change_texts(nullptr);
  const auto device = open();
  service.change_texts([&](const std::string&) { return "{"; }, true);
  service.stop();
  service.start();
  EXPECT_TRUE(fails(*device, {1, 0, 0}));
  EXPECT_TRUE(
      comes(*device, {1, 0, 0}, [&] { return std::string_view(state.fault).find("understood") != std::string_view::npos; }));
  service.change_texts(nullptr);
  EXPECT_TRUE(is_felt(*device, {1, 0, 0}));
}

TEST(Inverse3Messages, WhateverIsChangedInThemIsReadOrRefused) {
  std::mt19937 random(1);  // NOLINT: the same each time
  const std::string message =
      R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":0.1,"y":-2e-3,"z":3},"cursor_velocity":{"x":0,"y":0,"z":0},)"
      R"("current_cursor_force":{"x":0,"y":0,"z":0}},"status":{"calibrated":true,"power_supply":false}}],)"
      R"("verse_grip":[{"device_id":"1","state":{"button":true}}],"wireless_verse_grip":[]})";
  const std::string pieces[] = {"{", "}", "[", "]", "\"", ":", ",", "1e999", "null", "true", "-", "\\u", "\xff", "x", "0"};
  int read = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string changed = message;
    for (int change = 0; change <= i % 3; ++change) {
      const std::size_t at = random() % changed.size(), bytes = random() % 4;
      changed.replace(at, bytes, pieces[random() % std::size(pieces)]);
    }
    inverse3::ServiceView view{.device_ids = {"before"}, .arm = inverse3::ServiceArm{.position_m = Vec3{1, 2, 3}}};
    if (!inverse3::read_message(changed, "", view)) {
      EXPECT_THAT(view.device_ids, ElementsAre("before"));
      EXPECT_EQ(view.arm->position_m, (Vec3{1, 2, 3}));
      continue;
    }
    ++read;
    if (!view.arm) continue;
    EXPECT_TRUE(inverse3::is_plain(view.device_ids.at(0)));
    EXPECT_TRUE(is_finite(view.arm->position_m.value()) && largest_component(*view.arm->position_m) <= 10.0);
    EXPECT_TRUE(is_finite(view.arm->velocity_m_per_s.value_or(Vec3{})));
  }
  EXPECT_GT(read, 500) << "some changes do no harm";
}

TEST(Inverse3Messages, AreJsonForAnyForce) {
  std::mt19937_64 random(1);  // NOLINT: the same each time
  for (int i = 0; i < 2000; ++i) {
    Vec3 force_n;
    for (double* part : {&force_n.x, &force_n.y, &force_n.z}) {
      do {
        *part = std::bit_cast<double>(random());
      } while (!std::isfinite(*part));
    }
    const json command = json::parse(inverse3::force_message("049D", force_n, inverse3::ForceWord::vector, "a:b"));
    const json& vector = command["inverse3"][0]["commands"]["set_cursor_force"]["vector"];
    EXPECT_EQ(test::hand_from_service({vector["x"], vector["y"], vector["z"]}), force_n);
  }
}

TEST(Inverse3Messages, AVersionIsReadFromWhateverIsAnswered) {
  using inverse3::ForceWord;
  using inverse3::word_of_version;
  EXPECT_EQ(word_of_version(R"({"ok":true,"data":{"git_tag":"v3.5.0","project_version":"3.5.0"}})"), ForceWord::vector);
  EXPECT_EQ(word_of_version(R"({"project_version":"3.4"})"), ForceWord::values);
  EXPECT_EQ(word_of_version(R"({"data":{"git_tag":"v3.1.7-dirty","project_version":null}})"), ForceWord::values);
  for (const char* no_version :
       {"", "3.5", "[]", R"({"data":[]})", R"({"data":{"project_version":3.5}})", R"({"project_version":"99999999999999.1"})",
        R"({"project_version":"3"})", R"({"project_version":"v."})", R"({"project_version":""})"})
    EXPECT_EQ(word_of_version(no_version), std::nullopt) << no_version;
}

}  // namespace inverse3_wrong_test
}  // namespace palpa
