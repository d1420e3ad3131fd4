// palpa in real time: ends, gaps of the recording, keys.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "devices/igtl_messages.h"
#include "palpa/trace/trace.h"
#include "program.h"
#include "tests/devices/igtl_stand_in.h"

namespace palpa {
namespace live_run_test {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using Clock = std::chrono::steady_clock;

class LiveRun : public ProgramTest {
 protected:
  void SetUp() override { write_scene("scene.toml"); }
  std::vector<std::string> run(const std::vector<std::string>& more) const {
    std::vector<std::string> words{"run", "scene.toml", "--hand", "sim:stroke", "--realtime"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  static std::size_t lines(const std::string& text) {
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  }
};

TEST_F(LiveRun, TakesAsLongAsItLastsAndTellsHowItsLoopKeptTime) {
  const auto begin = Clock::now();
  const Ended ended = palpa(run({"--duration-s", "1.5", "--json"}));
  EXPECT_GE(Clock::now() - begin, std::chrono::milliseconds(1500));
  ASSERT_EQ(ended.code, 0) << ended.err;
  const json summary = json::parse(ended.out), &loop = summary["loop"];
  EXPECT_EQ(loop["ticks"].get<int>() + loop["missed"].get<int>(), 1500);
  for (const char* what : {"late", "period", "processor"})
    for (const char* share : {"mean_us", "p50_us", "p99_us", "p999_us", "max_us"})
      EXPECT_GE(loop[what][share].get<double>(), 0.0);
  EXPECT_FALSE(loop["modes"].empty());
}

TEST_F(LiveRun, IsWholeHoweverItIsEnded) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const std::string trace = "trace" + std::to_string(signal);
    const pid_t process = start(run({"--duration-s", "1000", "--out", trace}));
    wait_for_ticks(folder / trace);
    ASSERT_EQ(::kill(process, signal), 0);
    EXPECT_EQ(wait(process).code, 128 + signal);
    EXPECT_TRUE(TraceReader(folder / trace).header().complete);
    const Ended replay = palpa({"replay", trace});
    EXPECT_EQ(replay.code, 0) << replay.out << replay.err;
  }
}

TEST_F(LiveRun, GoesOnWithoutItsRecordingWhereTheDiskIsFull) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{.rlim_cur = 100'000, .rlim_max = before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const pid_t process = start(run({"--duration-s", "2", "--json", "--out", "trace"}));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  const Ended ended = wait(process);
  EXPECT_EQ(ended.code, 1) << ended.err;
  EXPECT_THAT(ended.err, AllOf(HasSubstr("cannot be written"), HasSubstr("the run continued")));
  const json loop = json::parse(ended.out)["loop"];
  EXPECT_EQ(loop["ticks"].get<int>() + loop["missed"].get<int>(), 2000) << "all of it was felt";
  EXPECT_GT(loop["unrecorded"].get<int>(), 0);
  const TraceReader reader(folder / "trace");
  EXPECT_FALSE(reader.header().complete);
  EXPECT_GT(reader.ticks().size(), 50u) << "what was written before stays";
  const Ended replay = palpa({"replay", "trace"});
  EXPECT_EQ(replay.code, 0) << replay.out << replay.err;
}

TEST_F(LiveRun, ObeysKeysOnATerminal) {
  int terminal = -1;
  const pid_t process = ::forkpty(&terminal, nullptr, nullptr, nullptr);
  ASSERT_GE(process, 0);
  if (process == 0) {
    std::filesystem::current_path(folder);
    ::execl(PALPA_PROGRAM, "palpa", "run", "scene.toml", "--hand", "sim:stroke", "--realtime", "--duration-s", "100", nullptr);
    ::_exit(127);
  }
  std::string shown;
  const auto shows = [&](const char* words) {
    shown.clear();
    for (const auto end = Clock::now() + std::chrono::seconds(30); Clock::now() < end;) {
      pollfd out{.fd = terminal, .events = POLLIN, .revents = 0};
      char text[4096];
      if (::poll(&out, 1, 100) != 1) continue;
      const ssize_t read = ::read(terminal, text, sizeof text);
      if (read <= 0) return false;
      shown.append(text, static_cast<std::size_t>(read));
      if (shown.find(words) != std::string::npos) return true;
    }
    return false;
  };
  const auto press = [&](char key) { ASSERT_EQ(::write(terminal, &key, 1), 1); };
  EXPECT_TRUE(shows("Keys:")) << shown;
  EXPECT_TRUE(shows("missed"));
  press(' ');
  EXPECT_TRUE(shows("off: ")) << shown;
  press(' ');
  EXPECT_TRUE(shows("ramp")) << shown;
  press('1');
  EXPECT_TRUE(shows("missed"));
  press('q');
  EXPECT_TRUE(shows("the scene changed 1 times")) << shown;
  while (shows("\xff")) {
  }
  int status = 0;
  ASSERT_EQ(::waitpid(process, &status, 0), process);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  ::close(terminal);
}

TEST_F(LiveRun, RefusesInALineWhatCannotBe) {
  const std::vector<std::string> own{"run", "scene.toml"};
  const auto refusal = [&](std::vector<std::string> words) {
    const Ended ended = palpa(words);
    EXPECT_EQ(ended.code, 2) << testing::PrintToString(words);
    EXPECT_EQ(lines(ended.err), 1u) << ended.err;
    EXPECT_EQ(ended.out, "");
    return ended.err;
  };
  EXPECT_THAT(refusal(own), HasSubstr("--device NAME"));
  EXPECT_THAT(refusal({"run", "scene.toml", "--device", "inverse4"}), HasSubstr("inverse4"));
  EXPECT_THAT(refusal({"run", "scene.toml", "--device", "inverse3,port=1"}), HasSubstr("127.0.0.1:1"));
  EXPECT_THAT(refusal({"run", "scene.toml", "--device", "inverse3,host=192.0.2.1"}), HasSubstr("remote=yes"));
  EXPECT_THAT(refusal({"run", "scene.toml", "--device", "force-dimension,library=/nowhere.so"}), HasSubstr("/nowhere.so"));
  EXPECT_THAT(refusal(run({"--rate-hz", "50"})), HasSubstr("between 100 and 20000"));
  EXPECT_THAT(refusal({"run", "scene.toml", "--hand", "sim:press", "--dead-man-button", "1"}), HasSubstr("--realtime"));
  EXPECT_THAT(refusal({"run", "scene.toml", "--device", "igtl,host=192.0.2.1"}), HasSubstr("remote=yes"));
  EXPECT_THAT(refusal({"run", "scene.toml", "--hand", "sim:press", "--igtl", "18944"}), HasSubstr("--realtime"));
  EXPECT_THAT(refusal(run({"--igtl", "70000"})), HasSubstr("--igtl"));
  EXPECT_THAT(refusal({"devices", "inverse4"}), HasSubstr("inverse4"));
  EXPECT_THAT(refusal({"devices", "--setup"}), HasSubstr("name"));
  EXPECT_THAT(refusal({"devices", "inverse3", "--setup"}), HasSubstr("terminal"));
}

// Contents of the messages: tests/app/igtl_view_test.cpp.
TEST_F(LiveRun, IsShownToClientsOfOpenIGTLinkWithEqualTicks) {
  const Ended shown = palpa(run({"--duration-s", "0.3", "--igtl", "0", "--json"}));
  ASSERT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.err, HasSubstr("OpenIGTLink at 127.0.0.1:"));
  EXPECT_EQ(json::parse(shown.out)["ticks"].get<int>() + json::parse(shown.out)["loop"]["missed"].get<int>(), 300);
}

/// The place [mm, RAS] of a TRANSFORM that a run shows at this port; none within 20 s.
std::optional<Vec3> place_shown(std::uint16_t port, const std::string& name) {
  std::optional<Vec3> place_mm;
  igtl::MessageStream stream;
  const auto take = [&](const igtl::Head& head, std::span<const std::byte> body) {
    if (igtl::word_of(head.type) != "TRANSFORM" || igtl::word_of(head.name) != name) return;
    if (const auto pose = igtl::pose_of(body)) place_mm = pose->place_mm;
  };
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  for (const auto end = Clock::now() + std::chrono::seconds(20); !place_mm && Clock::now() < end;) {
    const int client = ::socket(AF_INET, SOCK_STREAM, 0);
    if (::connect(client, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) {
      std::byte bytes[4096];
      for (ssize_t length; !place_mm && (length = ::recv(client, bytes, sizeof bytes, 0)) > 0;)
        stream.take(std::span(bytes).first(static_cast<std::size_t>(length)), take);
    }
    ::close(client);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return place_mm;
}

TEST_F(LiveRun, ATrackerIsShownWhereItIsInTheScan) {
  test::IgtlStandIn server;
  const Vec3 place_mm{12, -34, 156};  // above the ball
  server.hold("Stylus", {.rotation = Mat3::identity(), .place_mm = place_mm});
  const std::uint16_t port = test::IgtlStandIn().port();  // free again
  const pid_t process =
      start({"run", "scene.toml", "--device", "igtl,name=Stylus,port=" + std::to_string(server.port()), "--igtl",
             std::to_string(port), "--duration-s", "1000", "--set", "workspace.scale=1", "--set", "workspace.center=[0, 0, 0]",
             "--set", "workspace.towards_user='-y'", "--set", "workspace.up='+z'"});
  const std::optional<Vec3> shown_mm = place_shown(port, "PalpaProbe");
  ::kill(process, SIGINT);
  const Ended ended = wait(process);
  ASSERT_TRUE(shown_mm) << ended.err;
  EXPECT_LT(distance(*shown_mm, place_mm), 1e-3);
}

TEST_F(LiveRun, ListsEveryKindOfDeviceWithWhatIsMissing) {
  const Ended list = palpa({"devices"});
  EXPECT_EQ(list.code, 0) << list.err;
  for (const char* kind : {"inverse3", "force-dimension", "igtl", "openhaptics", "spacemouse", "controller"})
    EXPECT_THAT(list.out, HasSubstr(std::string(kind) + ": "));
  const json all = json::parse(palpa({"devices", "--json"}).out);
  EXPECT_EQ(all["devices"].size(), 6u);
  for (const json& kind : all["devices"]) {
    EXPECT_FALSE(kind["axes"].get<std::string>().empty());
    EXPECT_FALSE(kind["found"].empty() && kind["missing"].empty());
  }
}

}  // namespace live_run_test
}  // namespace palpa
