// Exchange with an Inverse Service on a simulated clock: which messages carry a force, whatever happens when.
#include "palpa/device/inverse3_exchange.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tests/fuzz/choices.h"

namespace palpa {
namespace inverse3_exchange_test {

using inverse3::answer_deadline_s;
using inverse3::answers_to_trust;
using inverse3::Exchange;
using inverse3::force_lifetime_s;
using inverse3::state_at;
using inverse3::state_lifetime_s;
using nlohmann::json;
using Due = Exchange::Due;

constexpr double tick_s = 1e-3;
constexpr double answer_s = 1e-4;
// Longer than any deadline of the exchange.
constexpr double long_s = 2.0;

/// State of a service with one Inverse3, at rest.
struct Service {
  std::vector<std::string> ids{"049D"};
  bool has_power = true, is_calibrated = true, says_where = true, makes_force = true;

  std::string text(const Vec3& force_n = {}) const {
    json arms = json::array();
    for (const std::string& id : ids) {
      json state = {{"current_cursor_force", vector_of(makes_force && has_power ? force_n : Vec3{})}};
      if (says_where) state["cursor_position"] = vector_of({0.01, 0.02, 0.03});
      arms.push_back(
          {{"device_id", id}, {"state", state}, {"status", {{"calibrated", is_calibrated}, {"power_supply", has_power}}}});
    }
    return json{{"inverse3", arms}}.dump();
  }
  static json vector_of(const Vec3& v) { return {{"x", v.x}, {"y", v.y}, {"z", v.z}}; }
};

/// Force of a message, in the service's axes; zero: it is a question alone.
Vec3 force_of(const std::string& message) {
  const json parsed = json::parse(message);
  if (!parsed.contains("inverse3")) return {};
  const json& command = parsed["inverse3"][0]["commands"]["set_cursor_force"];
  const json& force = command.contains("vector") ? command["vector"] : command["values"];
  return {force["x"], force["y"], force["z"]};
}

/// A program with an exchange and a connection, as is due, to a service that answers as it is told.
class Program {
 public:
  explicit Program(inverse3::ExchangeOptions options = {}) : exchange(std::move(options)) {}

  /// One event of the program's loop.
  void look() {
    exchange.look(now_s);
    follow();
    send();
  }
  void write(const Vec3& force_n) {
    written_n = force_n;
    written_s = now_s;
    exchange.write({.force_n = force_n, .number = ++writes, .time_s = now_s});
    send();
  }
  void take(const std::string& text) {
    is_awaiting = false;
    exchange.take(text, now_s);
    follow();
    send();
  }
  void close() {
    is_open = is_awaiting = false;
    exchange.lose(now_s);
  }
  /// The service's answer to the last message.
  void take_answer() { take(service.text(sent.empty() ? Vec3{} : sent.back().force_n)); }

  /// A tick of a program that is felt: the answer comes, and a force is written.
  void tick(const Vec3& force_n) {
    now_s += answer_s;
    if (is_open && is_awaiting && answers) take_answer();
    now_s += tick_s - answer_s;
    look();
    write(force_n);
  }
  void ticks(int count, const Vec3& force_n) {
    for (int n = 0; n < count; ++n) tick(force_n);
  }
  /// Until a force is sent. False: none within seconds.
  bool is_felt(const Vec3& force_n) {
    for (int n = 0; n < 5000; ++n) {
      tick(force_n);
      if (!sent.empty() && sent.back().force_n != Vec3{}) return true;
    }
    return false;
  }

  struct Sent {
    double time_s;
    Vec3 force_n;
  };

  Exchange exchange;
  Service service;
  double now_s = 1e5;
  bool answers = true;
  bool is_open = false, is_awaiting = false;
  int connections = 0, handshakes = 0;
  std::vector<Sent> sent;  // of all connections
  std::vector<std::string> texts;
  Vec3 written_n;
  double written_s = 0.0;
  std::uint64_t writes = 0;
  std::function<void(const Sent&)> on_sent = [](const Sent&) {};

 private:
  void follow() {
    if (is_open && !exchange.wants_connection()) is_open = is_awaiting = false;
    if (is_open || !exchange.wants_connection() || exchange.is_over()) return;
    is_open = true;
    ++connections;
    exchange.open(std::nullopt);
    if (answers) take(service.text());
  }
  void send() {
    if (!is_open) return;
    const Due due = exchange.due(now_s);
    if (due == Due::nothing) return;
    if (due == Due::handshake) {
      exchange.say_goodbye();
      ++handshakes;
      return;
    }
    texts.push_back(exchange.message(now_s));
    sent.push_back({now_s, force_of(texts.back())});
    is_awaiting = true;
    on_sent(sent.back());
  }
};

constexpr Vec3 force_n{1.0, 0.0, 0.0};

TEST(Inverse3Exchange, TrustsAfterAnswersInTime) {
  Program program;
  for (int n = 0; n < 30; ++n) program.tick(force_n);
  for (int n = 0; n < answers_to_trust; ++n) EXPECT_EQ(program.sent[static_cast<std::size_t>(n)].force_n, Vec3{}) << n;
  EXPECT_EQ(program.sent[answers_to_trust].force_n, force_n);
  EXPECT_TRUE(program.exchange.is_linked() && program.exchange.state().valid);
  EXPECT_EQ(program.exchange.state().fault, nullptr);
  EXPECT_EQ(program.exchange.state().position_m, (Vec3{0.01, 0.03, -0.02}));
}

struct Fault {
  const char* name;
  std::function<void(Program&)> begin, end;
};

std::vector<Fault> faults() {
  const auto of = [](const char* name, auto change) {
    return Fault{name, [=](Program& p) { change(p.service); }, [](Program& p) { p.service = {}; }};
  };
  return {of("no power", [](Service& s) { s.has_power = false; }),
          of("not calibrated", [](Service& s) { s.is_calibrated = false; }),
          of("no position since the connection", [](Service& s) { s.says_where = false; }),
          of("device gone", [](Service& s) { s.ids.clear(); }),
          of("another device", [](Service& s) { s.ids = {"0BEE"}; }),
          of("no force", [](Service& s) { s.makes_force = false; }),
          {"no answers", [](Program& p) { p.answers = false; }, [](Program& p) { p.answers = true; }},
          {"connection lost", [](Program& p) { p.close(); }, [](Program&) {}}};
}

TEST(Inverse3Exchange, SendsNoForceFromAFaultOn) {
  for (const Fault& fault : faults()) {
    SCOPED_TRACE(fault.name);
    Program program;
    ASSERT_TRUE(program.is_felt(force_n));
    fault.begin(program);
    if (std::string(fault.name).starts_with("no position")) program.close();
    bool is_detected = false;
    program.on_sent = [&](const Program::Sent& sent) {
      is_detected = is_detected || program.exchange.state().fault != nullptr;
      if (is_detected) {
        EXPECT_EQ(sent.force_n, Vec3{});
      }
    };
    for (int n = 0; n < 3000; ++n) {
      program.tick(force_n);
      is_detected = is_detected || program.exchange.state().fault != nullptr;
      if (std::string(fault.name) == "connection lost" && n == 100) break;
    }
    EXPECT_TRUE(is_detected);
    program.on_sent = [](const Program::Sent&) {};
    fault.end(program);
    // A force that was not rendered is tried again after the device was gone.
    if (std::string(fault.name) == "no force") program.close();
    EXPECT_TRUE(program.is_felt(force_n));
  }
}

TEST(Inverse3Exchange, SendsNoForceOlderThanItsLifetime) {
  Program program;
  ASSERT_TRUE(program.is_felt(force_n));
  const double written_s = program.written_s;
  while (program.now_s < written_s + 1.0) {
    program.now_s += answer_s;
    if (program.is_awaiting) program.take_answer();
    program.look();
    if (program.now_s > written_s + force_lifetime_s + 2 * answer_s) {
      ASSERT_EQ(program.sent.back().force_n, Vec3{});
    }
  }
  for (const Program::Sent& sent : program.sent) {
    if (sent.force_n != Vec3{}) {
      EXPECT_LE(sent.time_s - written_s, force_lifetime_s);
    }
  }
  program.tick(force_n);
  EXPECT_EQ(program.sent.back().force_n, force_n) << "the link went on without it";
}

/// Messages without a force from now on until the first with one; the answers among them are in time.
int messages_to_trust(Program& program) {
  const std::size_t before = program.sent.size();
  for (int n = 0; n < 5000; ++n) {
    program.tick(force_n);
    for (std::size_t at = before; at < program.sent.size(); ++at)
      if (program.sent[at].force_n != Vec3{}) return static_cast<int>(at - before);
  }
  return -1;
}

TEST(Inverse3Exchange, FindsAPauseByTheNextCallsTime) {
  // The call after the pause, of a program that stopped behind a message, or between an answer and the next message.
  const std::vector<std::pair<const char*, std::function<void(Program&)>>> next{
      {"look", [](Program& p) { p.look(); }},
      {"write", [](Program& p) { p.write(force_n); }},
      {"answer", [](Program& p) { p.take_answer(); }},
      {"answer, write", [](Program& p) { p.take_answer(), p.write(force_n); }},
      {"loss", [](Program& p) { p.close(); }}};
  for (const double pause_s : {0.051, 0.2, 0.499, 0.501, 3.0, 3600.0, 1e6}) {
    for (const bool is_awaiting : {true, false}) {
      for (const auto& [name, call] : next) {
        SCOPED_TRACE(std::string(name) + (is_awaiting ? ", awaiting, " : ", ") + std::to_string(pause_s) + " s");
        Program program;
        ASSERT_TRUE(program.is_felt(force_n));
        if (!is_awaiting) {
          program.now_s += answer_s;
          program.take_answer();
        }
        const std::size_t before = program.sent.size();
        program.now_s += pause_s;
        call(program);
        for (std::size_t at = before; at < program.sent.size(); ++at) EXPECT_EQ(program.sent[at].force_n, Vec3{});
        const int sent = static_cast<int>(program.sent.size() - before);
        EXPECT_GE(messages_to_trust(program) + sent, answers_to_trust);
      }
    }
  }
}

TEST(Inverse3Exchange, FindsALateAnswer) {
  Program program;
  ASSERT_TRUE(program.is_felt(force_n));
  ASSERT_TRUE(program.is_awaiting);
  program.now_s += 1.01 * answer_deadline_s;
  program.take_answer();
  program.write(force_n);
  EXPECT_EQ(program.sent.back().force_n, Vec3{});
  EXPECT_GE(messages_to_trust(program) + 1, answers_to_trust);
}

TEST(Inverse3Exchange, HasNoForceAfterAMessageThatWasNotRequested) {
  Program program;
  ASSERT_TRUE(program.is_felt(force_n));
  while (program.is_awaiting) program.take_answer();
  program.take(program.service.text(force_n));
  program.write(force_n);
  EXPECT_EQ(program.sent.back().force_n, Vec3{});
  EXPECT_GE(messages_to_trust(program) + 1, answers_to_trust);
  EXPECT_EQ(program.connections, 1) << "one alone costs no connection";
}

TEST(Inverse3Exchange, AnOldStateHasNoPosition) {
  Program program;
  ASSERT_TRUE(program.is_felt(force_n));
  const DeviceState state = program.exchange.state();
  EXPECT_TRUE(state_at(state.time_s + 0.99 * state_lifetime_s, state).valid);
  for (const double age_s : {1.01 * state_lifetime_s, 1e6, std::numeric_limits<double>::quiet_NaN()}) {
    const DeviceState old = state_at(state.time_s + age_s, state);
    EXPECT_FALSE(old.valid);
    EXPECT_NE(old.fault, nullptr);
  }
}

TEST(Inverse3Exchange, EndsWithAForceOfZeroAtOnce) {
  for (const bool is_awaiting : {true, false}) {
    for (const bool answers : {true, false}) {
      Program program;
      ASSERT_TRUE(program.is_felt(force_n));
      if (!is_awaiting) {
        program.now_s += answer_s;
        program.take_answer();
      }
      const std::size_t before = program.sent.size();
      program.answers = answers;
      program.write(force_n);
      program.exchange.end(program.now_s);
      program.look();
      ASSERT_GT(program.sent.size(), before);
      EXPECT_EQ(program.sent.back().force_n, Vec3{}) << "in the first look";
      const double begin_s = program.now_s;
      while (!program.exchange.is_over() && program.now_s < begin_s + long_s) program.tick(force_n);
      EXPECT_TRUE(program.exchange.is_over());
      EXPECT_LT(program.now_s - begin_s, inverse3::end_deadline_s + 3 * tick_s);
      EXPECT_EQ(program.sent.back().force_n, Vec3{});
      EXPECT_EQ(program.handshakes, answers ? 1 : 0);
      EXPECT_FALSE(program.exchange.wants_connection());
      EXPECT_FALSE(program.exchange.state().valid);
      const std::size_t end = program.sent.size();
      program.ticks(2000, force_n);
      EXPECT_EQ(program.sent.size(), end) << "and begins nothing new";
      EXPECT_EQ(program.connections, 1);
    }
  }
}

TEST(Inverse3Exchange, EndsBeforeItsServiceHasAnswered) {
  Program program;
  program.answers = false;
  program.look();
  EXPECT_TRUE(program.is_open);
  program.exchange.end(program.now_s);
  program.look();
  EXPECT_TRUE(program.exchange.is_over());
  EXPECT_TRUE(program.sent.empty());
}

TEST(Inverse3Exchange, StaysWithTheFirstDeviceThatWasListed) {
  Program program({.profile = "a:b"});
  program.service.ids = {};
  program.ticks(20, force_n);
  EXPECT_STREQ(program.exchange.state().fault, "the Inverse3 is not connected to the service");
  EXPECT_EQ(json::parse(program.texts.front())["session"]["configure"]["profile"]["name"], "a:b");
  program.service.ids = {"0BEE", "049D"};
  ASSERT_TRUE(program.is_felt(force_n));
  EXPECT_EQ(json::parse(program.texts.back())["inverse3"][0]["device_id"], "0BEE");
  program.service.ids = {"049D"};
  program.ticks(2, force_n);
  EXPECT_FALSE(program.exchange.state().valid);
  program.ticks(2000, force_n);
  for (const std::string& text : program.texts) EXPECT_EQ(text.find("049D"), std::string::npos);
}

TEST(Inverse3Exchange, KnowsWhenTheMotorsRest) {
  Program program;
  ASSERT_TRUE(program.is_felt(force_n));
  const std::uint64_t force = program.writes;
  program.ticks(5, force_n);
  EXPECT_LT(program.exchange.resting_number(), force);
  program.ticks(3, {});
  EXPECT_GT(program.exchange.resting_number(), force + 4);
  program.is_felt(force_n);
  program.close();
  program.look();
  EXPECT_EQ(program.exchange.resting_number(), program.writes) << "a force ends with its connection";
}

TEST(Inverse3Exchange, BearsAWrongClockAndAWrongForce) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  Program program;
  ASSERT_TRUE(program.is_felt({300, 400, 0}));
  EXPECT_NEAR(norm(program.sent.back().force_n), 3.0, 1e-12);
  for (const double wrong_s : {-1.0, nan, -infinite, infinite}) {
    program.exchange.look(wrong_s);
    EXPECT_EQ(program.exchange.state().fault, nullptr) << wrong_s;
  }
  for (const Vec3& wrong_n : {Vec3{nan, 0, 0}, Vec3{0, -infinite, 0}}) {
    program.ticks(2, wrong_n);
    EXPECT_EQ(program.sent.back().force_n, Vec3{});
  }
  // A force of a later or no time is one of its message's time, or none.
  for (const double wrong_s : {program.now_s + 1e9, nan}) {
    program.exchange.write({.force_n = force_n, .number = ++program.writes, .time_s = wrong_s});
    for (int n = 0; n < 100; ++n) {
      program.now_s += tick_s;
      if (program.is_awaiting) program.take_answer();
      program.look();
    }
    EXPECT_EQ(program.sent.back().force_n, Vec3{}) << wrong_s;
  }
  EXPECT_FALSE(program.exchange.take(std::string(inverse3::longest_message_bytes + 1, ' '), program.now_s));
}

// ---- any order, any pauses ----

/// Counts beside the exchange whether a force may be sent.
struct Witness {
  int answers_in_time = 0;  // consecutive, of this connection
  double asked_s = 0.0, answered_s = 0.0;
  bool is_there = false, is_fine = false;  // by the last answer
  bool has_ended = false;

  void connect(const Program& program) {
    answers_in_time = 0;
    answered_s = program.now_s;
    is_there = !program.service.ids.empty();
    is_fine = false;
  }
  void check(const Program& program, const Program::Sent& sent) {
    note_pause(program.now_s);
    asked_s = sent.time_s;
    if (sent.force_n == Vec3{}) return;
    EXPECT_EQ(program.exchange.state().fault, nullptr);
    EXPECT_FALSE(has_ended);
    EXPECT_TRUE(is_fine);
    EXPECT_GE(answers_in_time, answers_to_trust);
    EXPECT_LE(program.now_s - program.written_s, force_lifetime_s);
    EXPECT_LT(std::abs(norm(sent.force_n) - norm(inverse3::limited_force_n(program.written_n))), 1e-12);
  }
  void answer(const Program& program) {
    note_pause(program.now_s);
    answers_in_time = program.now_s - asked_s > answer_deadline_s ? 0 : answers_in_time + 1;
    answered_s = program.now_s;
    is_there = !program.service.ids.empty();
    is_fine = is_there && program.service.has_power && program.service.is_calibrated;
  }

 private:
  void note_pause(double now_s) {
    if (is_there && now_s - answered_s > state_lifetime_s) answers_in_time = 0;
  }
};

class RandomEvents {
 public:
  explicit RandomEvents(std::uint64_t seed) : choices_(seed) {
    program_.on_sent = [this](const Program::Sent& sent) {
      witness_.check(program_, sent);
      forces += sent.force_n != Vec3{};
    };
  }

  void next() {
    program_.now_s += time_step_s();
    const int connections = program_.connections;
    act(choices_.below(100));
    if (program_.connections != connections) witness_.connect(program_);
  }
  void end() {
    const bool is_open = program_.is_open;  // a lost connection has taken its force along
    program_.exchange.end(program_.now_s);
    witness_.has_ended = true;
    program_.look();
    for (int n = 0; n < 500; ++n) {
      if (is_open) {
        ASSERT_EQ(program_.sent.back().force_n, Vec3{});
      }
      program_.tick(force_n);
    }
    EXPECT_TRUE(program_.exchange.is_over());
  }

  int forces = 0;

 private:
  void act(std::uint64_t event) {
    if (event < 40) return answer();
    if (event < 70) return program_.write({choices_.between(0.1, 4.0), 0.0, 0.0});
    if (event < 96) return program_.look();
    if (event == 96) return program_.take(choices_.one_in(2) ? "{" : std::string(40, '['));
    if (event == 97 && choices_.one_in(20)) return program_.close();
    if (event == 98 && choices_.one_in(3)) return change();
    if (event == 99 && choices_.one_in(2000)) {
      program_.exchange.end(program_.now_s);
      witness_.has_ended = true;
    }
  }
  double time_step_s() {
    if (choices_.one_in(500)) return choices_.log_between(1e-3, 1e5);
    return choices_.one_in(10) ? 0.0 : choices_.between(0.0, 1e-3);
  }
  void answer() {
    if (!program_.is_open || (!program_.is_awaiting && !choices_.one_in(50))) return;
    if (program_.is_awaiting)
      witness_.answer(program_);
    else
      witness_.answers_in_time = 0;
    program_.take_answer();
  }
  void change() {
    Service& service = program_.service;
    service = {};
    service.has_power = !choices_.one_in(4);
    service.is_calibrated = !choices_.one_in(4);
    if (choices_.one_in(4)) service.ids.clear();
  }

  fuzz::Choices choices_;
  Program program_;
  Witness witness_;
};

TEST(Inverse3Exchange, SendsAForceOnlyWhileItTrustsWhateverHappensWhen) {
  int forces = 0;
  for (std::uint64_t seed = 0; seed < 60 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    RandomEvents events(seed);
    for (int n = 0; n < 3000; ++n) events.next();
    events.end();
    forces += events.forces;
  }
  EXPECT_GT(forces, 3000) << "it is felt, too";
}

}  // namespace inverse3_exchange_test
}  // namespace palpa
