#include "program.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

namespace palpa {

namespace fs = std::filesystem;

ProgramTest::ProgramTest() {
  std::string name = (fs::temp_directory_path() / "palpa-app-test-XXXXXX").string();
  folder = ::mkdtemp(name.data());
}

ProgramTest::~ProgramTest() { fs::remove_all(folder); }

pid_t ProgramTest::start(const std::vector<std::string>& arguments, const Environment& environment) const {
  const std::string program = PALPA_PROGRAM;
  const std::string out = folder / ".out", err = folder / ".err";
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);

  const pid_t process = ::fork();
  if (process != 0) return process;
  const auto redirect = [](const std::string& file, int flags, int stream) {
    ::dup2(::open(file.c_str(), flags, 0600), stream);
  };
  redirect("/dev/null", O_RDONLY, STDIN_FILENO);
  redirect(out, O_WRONLY | O_CREAT | O_TRUNC, STDOUT_FILENO);
  redirect(err, O_WRONLY | O_CREAT | O_TRUNC, STDERR_FILENO);
  for (const auto& [name, value] : environment) ::setenv(name.c_str(), value.c_str(), 1);
  if (::chdir(folder.c_str()) == 0) ::execv(program.c_str(), argv.data());
  ::_exit(127);
}

Ended ProgramTest::wait(pid_t process) const {
  int status = 0;
  ::waitpid(process, &status, 0);
  return {.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
          .out = read(folder / ".out"),
          .err = read(folder / ".err")};
}

Ended ProgramTest::palpa(const std::vector<std::string>& arguments, const Environment& environment) const {
  return wait(start(arguments, environment));
}

void ProgramTest::wait_for_words(const std::string& piece) const {
  for (int i = 0; i < 20000; ++i) {
    if (read(folder / ".err").find(piece) != std::string::npos) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  FAIL() << "not said in 20 s: " << piece;
}

void ProgramTest::wait_for_ticks(const fs::path& trace) const {
  // By its size: a reader of the growing file of a simulated run would never reach its end.
  std::error_code none;
  for (int i = 0; i < 6000; ++i) {
    if (fs::file_size(trace / "ticks.csv", none) > 20'000 && !none) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  FAIL() << "no ticks were recorded in 60 s";
}

void ProgramTest::expect_refusal(const std::vector<std::string>& arguments, const std::vector<std::string>& pieces) const {
  const Ended ended = palpa(arguments);
  const std::string shown = testing::PrintToString(arguments);
  EXPECT_EQ(ended.code, 2) << shown << '\n' << ended.err;
  EXPECT_EQ(ended.out, "") << shown;
  EXPECT_THAT(ended.err, testing::MatchesRegex("palpa: [^\n]*: [^\n]*; [^\n]*\n")) << shown;
  EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << shown << '\n' << ended.err;
  for (const std::string& piece : pieces) EXPECT_THAT(ended.err, testing::HasSubstr(piece)) << shown;
}

void ProgramTest::write(const std::string& name, const std::string& text) const {
  std::ofstream(folder / name, std::ios::binary) << text;
}

std::string ProgramTest::read(const fs::path& file) const {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

void ProgramTest::write_scene(const std::string& name, const std::string& from, const std::string& to) const {
  std::string text = R"(palpa = 1
title = "phantom"
[coupling]
stiffness_n_per_m = 800
damping_ns_per_m = 0.3
max_force_n = 3.3
[volume.head]
analytic = "head_phantom"
[[mode]]
name = "surface"
type = "surface_and_friction"
field = "head"
[[mode.level]]
name = "skin"
value = -300
strength_n = 0.8
friction_n = 0.1
)";
  if (!from.empty()) {
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  }
  write(name, text);
}

}  // namespace palpa
