// Zero force on a device after every stop of the real program, in a terminal of its own, with stand-ins for two kinds of
// devices that outlive it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "program.h"
#include "tests/devices/dhd_stand_in.h"
#include "tests/devices/inverse3_stand_in.h"

namespace palpa {
namespace stops_test {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using test::DhdSeen;
using test::Inverse3StandIn;

// Far above any run; only a failure takes it.
constexpr std::chrono::seconds patience{60};
constexpr double felt_n = 0.25;

bool comes(const std::function<bool()>& condition) {
  for (const auto end = Clock::now() + patience; Clock::now() < end; std::this_thread::sleep_for(milliseconds(1)))
    if (condition()) return true;
  return false;
}

/// A device that outlives the program, with a hand that moves in and out of the head.
class Device {
 public:
  virtual ~Device() = default;
  virtual std::string description() const = 0;
  virtual Environment environment() const { return {}; }
  virtual double last_word_n() = 0;  ///< magnitude of the last commanded force [N]

 protected:
  virtual void hold(double right_m, double up_m, double to_user_m) = 0;
  void begin() {
    hand_ = std::thread([this] {
      for (double angle = 0.0; !ends_; angle += 0.02, std::this_thread::sleep_for(milliseconds(2)))
        hold(0.0, 0.0, 0.08 + 0.04 * std::cos(angle));
    });
  }
  void end() {
    ends_ = true;
    hand_.join();
  }

 private:
  std::atomic<bool> ends_{false};
  std::thread hand_;
};

class Inverse3 final : public Device {
 public:
  Inverse3() { begin(); }
  ~Inverse3() override { end(); }
  std::string description() const override { return "inverse3,port=" + std::to_string(service_.port()); }
  double last_word_n() override { return norm(service_.last_word_n()); }

 private:
  // x to the right, y away from the user, z up
  void hold(double right_m, double up_m, double to_user_m) override { service_.hold({right_m, -to_user_m, up_m}, {}); }
  Inverse3StandIn service_;
};

class Omega final : public Device {
 public:
  explicit Omega(const std::filesystem::path& folder) : file_(folder / "seen") {
    const int descriptor = ::open(file_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (::ftruncate(descriptor, sizeof(DhdSeen)) != 0) throw std::runtime_error("no file");
    seen_ = static_cast<volatile DhdSeen*>(::mmap(nullptr, sizeof(DhdSeen), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0));
    ::close(descriptor);
    begin();
  }
  ~Omega() override { end(); }
  std::string description() const override { return "force-dimension,library=" PALPA_TESTS_DHD; }
  Environment environment() const override { return {{"PALPA_TESTS_DHD_SEEN", file_}}; }
  double last_word_n() override { return std::hypot(seen_->last_word_n[0], seen_->last_word_n[1], seen_->last_word_n[2]); }

 private:
  // x towards the user, y to the right, z up
  void hold(double right_m, double up_m, double to_user_m) override {
    seen_->place_m[0] = to_user_m;
    seen_->place_m[1] = right_m;
    seen_->place_m[2] = up_m;
  }
  std::filesystem::path file_;
  volatile DhdSeen* seen_ = nullptr;
};

class Stops : public ProgramTest, public testing::WithParamInterface<const char*> {
 protected:
  std::unique_ptr<Device> device() const {
    const std::filesystem::path own = folder / ("device" + std::to_string(devices_++));
    std::filesystem::create_directory(own);
    if (GetParam() == std::string("inverse3")) return std::make_unique<Inverse3>();
    return std::make_unique<Omega>(own);
  }
  // An unbreakable skin.
  void SetUp() override { write_scene("scene.toml", "strength_n = 0.8", "strength_n = 20"); }
  std::vector<std::string> run_with(const Device& device) const {
    // A machine busy with tests has late ticks: at 200 Hz three of them are no fault.
    return {"run", "scene.toml", "--device", device.description(), "--rate-hz", "200"};
  }
  static testing::AssertionResult is_felt(Device& device) {
    if (comes([&] { return device.last_word_n() > felt_n; })) return testing::AssertionSuccess();
    return testing::AssertionFailure() << "nothing is felt";
  }
  /// Success if an ended or stopped program left its device without force.
  static testing::AssertionResult is_left_at_rest(Device& device) {
    std::this_thread::sleep_for(milliseconds(100));  // commands in transit
    const double word_n = device.last_word_n();
    if (word_n == 0.0) return testing::AssertionSuccess();
    return testing::AssertionFailure() << "the last word is " << word_n << " N";
  }
  static char state_of(pid_t process) {
    const std::string stat = file_of(process);
    const std::size_t at = stat.rfind(") ");
    return at == std::string::npos ? 'X' : stat[at + 2];
  }

 private:
  static std::string file_of(pid_t process) {
    std::string text(512, '\0');
    const int descriptor = ::open(("/proc/" + std::to_string(process) + "/stat").c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return {};
    const ssize_t read = ::read(descriptor, text.data(), text.size());
    ::close(descriptor);
    text.resize(read < 0 ? 0 : static_cast<std::size_t>(read));
    return text;
  }
  mutable int devices_ = 0;
};

/// The program in the foreground of a terminal, below a minimal shell.
class Terminal {
 public:
  Terminal(const std::filesystem::path& folder, const std::vector<std::string>& words, const Environment& environment) {
    int told[2];
    if (::pipe(told) != 0) throw std::runtime_error("no pipe");
    shell_ = ::forkpty(&terminal_, nullptr, nullptr, nullptr);
    if (shell_ == 0) {
      ::signal(SIGTTOU, SIG_IGN);
      const pid_t job = ::fork();
      if (job == 0) {
        ::setpgid(0, 0);
        ::tcsetpgrp(STDIN_FILENO, ::getpid());
        ::signal(SIGTTOU, SIG_DFL);
        for (const auto& [name, value] : environment) ::setenv(name.c_str(), value.c_str(), 1);
        std::vector<char*> argv{const_cast<char*>("palpa")};
        for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
        argv.push_back(nullptr);
        if (::chdir(folder.c_str()) == 0) ::execv(PALPA_PROGRAM, argv.data());
        ::_exit(127);
      }
      [[maybe_unused]] const ssize_t written = ::write(told[1], &job, sizeof job);
      int status = 0;
      while (::waitpid(job, &status, WUNTRACED) == job && WIFSTOPPED(status)) {
      }
      ::_exit(WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status));
    }
    if (::read(told[0], &job_, sizeof job_) != sizeof job_) throw std::runtime_error("no job");
    ::close(told[0]);
    ::close(told[1]);
    shown_ = std::thread([this] {
      char text[4096];
      while (::read(terminal_, text, sizeof text) > 0) {
      }
    });
  }
  ~Terminal() {
    if (!is_over_) {
      ::kill(job_, SIGKILL);
      wait();
    }
    ::close(terminal_);
  }
  void press(char key) const { ASSERT_EQ(::write(terminal_, &key, 1), 1); }
  pid_t job() const { return job_; }
  /// Its exit code; 128 + signal after a signal.
  int wait() {
    int status = 0;
    ::waitpid(shell_, &status, 0);
    is_over_ = true;
    shown_.join();
    return WEXITSTATUS(status);
  }

 private:
  int terminal_ = -1;
  pid_t shell_ = -1, job_ = -1;
  bool is_over_ = false;
  std::thread shown_;
};

constexpr char ctrl_z = 0x1a, ctrl_backslash = 0x1c, ctrl_c = 0x03;

TEST_P(Stops, CtrlZLeavesNoForceAndFgBringsItBackByTheRamp) {
  const auto arm = device();
  Terminal terminal(folder, run_with(*arm), arm->environment());
  for (int n = 0; n < 3; ++n) {
    ASSERT_TRUE(is_felt(*arm));
    terminal.press(ctrl_z);
    ASSERT_TRUE(comes([&] { return state_of(terminal.job()) == 'T'; }));
    EXPECT_TRUE(is_left_at_rest(*arm));
    ::kill(terminal.job(), SIGCONT);
    // A seventh of a second is a fifth of the ramp.
    double largest_n = 0.0;
    for (const auto end = Clock::now() + milliseconds(70); Clock::now() < end; std::this_thread::sleep_for(milliseconds(1)))
      largest_n = std::max(largest_n, arm->last_word_n());
    EXPECT_LT(largest_n, felt_n);
  }
  ASSERT_TRUE(is_felt(*arm));
  terminal.press('q');
  EXPECT_EQ(terminal.wait(), 0);
  EXPECT_TRUE(is_left_at_rest(*arm));
}

TEST_P(Stops, KeysThatEndItLeaveNoForce) {
  for (const auto& [key, code] : {std::pair(ctrl_backslash, 128 + SIGQUIT), std::pair(ctrl_c, 128 + SIGINT)}) {
    const auto arm = device();
    Terminal terminal(folder, run_with(*arm), arm->environment());
    ASSERT_TRUE(is_felt(*arm));
    terminal.press(key);
    EXPECT_EQ(terminal.wait(), code);
    EXPECT_TRUE(is_left_at_rest(*arm));
  }
}

TEST_P(Stops, SignalsThatStopItLeaveNoForce) {
  const auto arm = device();
  Terminal terminal(folder, run_with(*arm), arm->environment());
  for (const int signal : {SIGTTIN, SIGTTOU, SIGTSTP}) {
    ASSERT_TRUE(is_felt(*arm)) << signal;
    ::kill(terminal.job(), signal);
    ASSERT_TRUE(comes([&] { return state_of(terminal.job()) == 'T'; })) << signal;
    EXPECT_TRUE(is_left_at_rest(*arm)) << signal;
    ::kill(terminal.job(), SIGCONT);
  }
}

// All signals of the system, so that none is forgotten.
TEST_P(Stops, SignalsThatEndItLeaveNoForce) {
  std::vector<int> signals{SIGRTMIN, SIGRTMIN + 5, SIGRTMAX};
  for (int number = 1; number < 32; ++number) {
    bool ends = true;
    for (const int other : {SIGKILL, SIGSTOP, SIGCONT, SIGCHLD, SIGURG, SIGWINCH, SIGTSTP, SIGTTIN, SIGTTOU, SIGXFSZ})
      ends = ends && number != other;
    if (ends) signals.push_back(number);
  }
  for (const int signal : signals) {
    const auto arm = device();
    const pid_t process = start(run_with(*arm), arm->environment());
    EXPECT_TRUE(is_felt(*arm)) << "signal " << signal;
    ::kill(process, signal);
    EXPECT_EQ(wait(process).code, 128 + signal);
    EXPECT_TRUE(is_left_at_rest(*arm)) << "signal " << signal;
  }
}

TEST_P(Stops, ASecondInterruptLeavesNoForce) {
  for (const int pause_ms : {0, 1, 5}) {
    const auto arm = device();
    const pid_t process = start(run_with(*arm), arm->environment());
    ASSERT_TRUE(is_felt(*arm));
    ::kill(process, SIGTERM);
    std::this_thread::sleep_for(milliseconds(pause_ms));
    ::kill(process, SIGINT);
    EXPECT_GT(wait(process).code, 128);
    EXPECT_TRUE(is_left_at_rest(*arm)) << pause_ms;
  }
}

class OwnProgram {
 public:
  OwnProgram(Device& device, const std::string& how) {
    int in[2], out[2];
    if (::pipe(in) != 0 || ::pipe(out) != 0) throw std::runtime_error("no pipe");
    process_ = ::fork();
    if (process_ == 0) {
      ::dup2(in[0], STDIN_FILENO);
      ::dup2(out[1], STDOUT_FILENO);
      ::dup2(::open("/dev/null", O_WRONLY), STDERR_FILENO);
      for (const int descriptor : {in[0], in[1], out[0], out[1]}) ::close(descriptor);
      for (const auto& [name, value] : device.environment()) ::setenv(name.c_str(), value.c_str(), 1);
      ::execl(PALPA_TESTS_STOPPED_PROGRAM, "stopped_program", device.description().c_str(), how.c_str(), nullptr);
      ::_exit(127);
    }
    ::close(in[0]);
    ::close(out[1]);
    in_ = in[1];
    out_ = out[0];
  }
  ~OwnProgram() {
    ::close(in_);
    ::close(out_);
  }
  pid_t process() const { return process_; }
  void go_on() const { ASSERT_EQ(::write(in_, "x", 1), 1); }
  std::string said() const {
    char text[64];
    const ssize_t read = ::read(out_, text, sizeof text);
    return {text, read < 0 ? 0 : static_cast<std::size_t>(read)};
  }
  int wait() const {
    int status = 0;
    ::waitpid(process_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  pid_t process_ = -1;
  int in_ = -1, out_ = -1;
};

TEST_P(Stops, AProgramOfOnesOwnThatFailsLeavesNoForce) {
  const std::vector<std::pair<const char*, int>> hows{{"terminate", 128 + SIGABRT},
                                                      {"throw", 128 + SIGABRT},
                                                      {"throw_in_a_thread", 128 + SIGABRT},
                                                      {"throw_in_the_loop", 128 + SIGABRT},
                                                      {"abort", 128 + SIGABRT},
                                                      {"exit", 3},
                                                      {"quick_exit", 3},
                                                      {"crash", 128 + SIGSEGV},
                                                      {"crash_in_a_thread", 128 + SIGSEGV},
                                                      {"crash_in_the_loop", 128 + SIGSEGV},
                                                      {"illegal", 128 + SIGILL},
                                                      {"own_handler", 128 + SIGTERM}};
  for (const auto& [how, code] : hows) {
    const auto arm = device();
    const OwnProgram program(*arm, how);
    EXPECT_TRUE(is_felt(*arm)) << how;
    program.go_on();
    EXPECT_EQ(program.wait(), code) << how;
    EXPECT_TRUE(is_left_at_rest(*arm)) << how;
  }
}

TEST_P(Stops, WhatEndsAChildOfAProgramTakesNoForceFromIt) {
  const auto arm = device();
  const OwnProgram program(*arm, "forked_child_ends");
  ASSERT_TRUE(is_felt(*arm));
  program.go_on();
  EXPECT_EQ(program.said(), "ended\n");
  EXPECT_TRUE(is_felt(*arm));
  ::kill(program.process(), SIGQUIT);
  EXPECT_EQ(program.wait(), 128 + SIGQUIT);
  EXPECT_TRUE(is_left_at_rest(*arm));
}

std::string name_of(const testing::TestParamInfo<const char*>& kind) { return kind.param[0] == 'i' ? "Inverse3" : "Omega"; }
INSTANTIATE_TEST_SUITE_P(All, Stops, testing::Values("inverse3", "force-dimension"), name_of);

}  // namespace stops_test
}  // namespace palpa
