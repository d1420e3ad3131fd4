// A stand-in for the Inverse Service as a program: a command per line, answered by a line of JSON; ends with its input.
//
//   inverse3_service [PORT]          prints its port
//
//   send MANNER                      a Manner of the stand-in: whole, paced, silent, flood, …
//   say [TEXT]                       every answer is TEXT; without it the state again
//   power on|off                     likewise calibrated, device, service, vector, values
//   hold X Y Z                       [m] position in the service's axes
//   scale FACTOR                     of forces
//   begin                            forgets the messages that came
//   log                              messages since then, and force [N] by the service now
#include <algorithm>
#include <array>
#include <cstdlib>
#include <iostream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/devices/inverse3_stand_in.h"

namespace palpa::test {
namespace {

using nlohmann::json;
using Manner = Inverse3StandIn::Manner;

constexpr std::array<const char*, 15> manners = {"whole", "fragments", "pings",       "paced",     "slow",
                                                 "drip",  "silent",    "flood",       "twice",     "binary",
                                                 "huge",  "endless",   "wrong_frame", "goes_away", "hangs_up"};
static_assert(static_cast<std::size_t>(Manner::hangs_up) + 1 == manners.size());
// Of a log. More: memory; fewer: a fault's first messages are missing.
constexpr std::size_t most_forces = 400;

/// Messages that came, by the server's thread.
class Log {
 public:
  void add(const Inverse3StandIn::Received& received) {
    const std::lock_guard guard(lock_);
    reactions_us_.push_back(1e6 * received.reaction_s);
    if (forces_n_.size() < most_forces) forces_n_.push_back(norm(received.force_n));
    last_n_ = norm(received.force_n);
  }
  void begin() {
    const std::lock_guard guard(lock_);
    reactions_us_.clear();
    forces_n_.clear();
  }
  json text() {
    const std::lock_guard guard(lock_);
    std::vector<double> sorted = reactions_us_;
    std::ranges::sort(sorted);
    const auto at = [&](double share) {
      return sorted.empty() ? 0.0 : sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
    };
    return {{"messages", sorted.size()},
            {"forces_n", forces_n_},
            {"last_n", last_n_},
            {"reaction_us", {{"p50", at(0.5)}, {"p99", at(0.99)}, {"p999", at(0.999)}, {"max", at(1.0)}}}};
  }

 private:
  std::mutex lock_;
  std::vector<double> reactions_us_, forces_n_;
  double last_n_ = 0.0;
};

class Service {
 public:
  explicit Service(std::uint16_t port) : stand_in_(port) {
    stand_in_.watch([this](const Inverse3StandIn::Received& received) { log_.add(received); });
  }
  std::uint16_t port() const { return stand_in_.port(); }

  json obey(const std::string& line) {
    std::istringstream words(line);
    std::string command, word;
    words >> command;
    if (command == "log") return log_of();
    if (command == "begin") {
      log_.begin();
    } else if (command == "say") {
      const std::string text = line.size() > 4 ? line.substr(4) : "";
      stand_in_.change_texts(text.empty() ? std::function<std::string(const std::string&)>()
                                          : [text](const std::string&) { return text; });
    } else if (command == "hold") {
      Vec3 position_m;
      words >> position_m.x >> position_m.y >> position_m.z;
      stand_in_.hold(position_m, {});
    } else if (command == "scale") {
      double factor = 1.0;
      words >> factor;
      stand_in_.scale_forces(factor);
    } else if (words >> word; command == "send") {
      const auto found = std::ranges::find(manners, word);
      if (found == manners.end()) return {{"error", "no manner " + word}};
      stand_in_.send(static_cast<Manner>(found - manners.begin()));
    } else {
      return turn(command, word == "on") ? json{{"ok", true}} : json{{"error", "no command " + command}};
    }
    return {{"ok", !words.fail()}};
  }

 private:
  bool turn(const std::string& what, bool on) {
    if (what == "power") {
      stand_in_.turn_power(on);
    } else if (what == "calibrated") {
      stand_in_.calibrate(on);
    } else if (what == "device") {
      stand_in_.connect_device(on);
    } else if (what == "service") {
      on ? stand_in_.start() : stand_in_.stop();
    } else if (what == "vector" || what == "values") {
      stand_in_.understand(what == "vector" && on, what == "values" && on);
    } else {
      return false;
    }
    return true;
  }
  json log_of() {
    json log = log_.text();
    log["force_n"] = norm(stand_in_.force_n());
    log["good_byes"] = stand_in_.good_byes();
    log["connections"] = stand_in_.connections();
    return log;
  }

  Log log_;
  Inverse3StandIn stand_in_;
};

}  // namespace
}  // namespace palpa::test

int main(int argc, char** argv) {
  palpa::test::Service service(argc > 1 ? static_cast<std::uint16_t>(std::atoi(argv[1])) : std::uint16_t{0});
  std::cout << service.port() << std::endl;
  for (std::string line; std::getline(std::cin, line);) std::cout << service.obey(line) << std::endl;
}
