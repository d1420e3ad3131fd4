#include "tests/fuzz/program.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

namespace palpa::fuzz {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr double most_bytes = 8e9;  // the sanitizer's own memory counts
#else
constexpr double most_bytes = 1.5e9;
#endif
constexpr std::size_t longest_line = 3000;  // [1] characters

std::string content(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

void redirect(const fs::path& file, int flags, int stream) {
  const int descriptor = ::open(file.c_str(), flags, 0600);
  ::dup2(descriptor, stream);
  if (descriptor != stream) ::close(descriptor);
}

bool is_obeyed_by_terminals(const std::string& text) {
  return std::any_of(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return (byte < 0x20 && c != '\n' && c != '\t') || byte == 0x7f;
  });
}

std::string last_line(const std::string& text) {
  const std::size_t end = text.find_last_not_of('\n');
  if (end == std::string::npos) return {};
  const std::size_t before = text.rfind('\n', end);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  return text.substr(begin, end + 1 - begin);
}

}  // namespace

Ended ended(const Start& start) {
  const std::string program = start.program.string();
  std::vector<char*> arguments{const_cast<char*>(program.c_str())};
  for (const std::string& argument : start.arguments) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  // Beside the folder, which may be full or read-only.
  std::string streams = (fs::temp_directory_path() / "palpa-streams-XXXXXX").string();
  if (::mkdtemp(streams.data()) == nullptr) throw std::runtime_error(streams + ": cannot be made; is the disk full?");
  const fs::path out = fs::path(streams) / "out", err = fs::path(streams) / "err";

  const auto begin = std::chrono::steady_clock::now();
  // Not fork: it copies the page tables, which takes as long as many a run.
  const pid_t process = ::vfork();
  if (process < 0) throw std::runtime_error("no process can be started; are there too many?");
  if (process == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) ::signal(number, SIG_DFL);
    redirect("/dev/null", O_RDONLY, STDIN_FILENO);
    redirect(out, O_WRONLY | O_CREAT | O_TRUNC, STDOUT_FILENO);
    redirect(err, O_WRONLY | O_CREAT | O_TRUNC, STDERR_FILENO);
    if (::chdir(start.folder.c_str()) != 0) ::_exit(127);
    if (start.before) start.before();
    ::execv(program.c_str(), arguments.data());
    ::_exit(127);
  }
  if (start.meanwhile) start.meanwhile(process);
  int status = 0;
  rusage usage{};
  double spent_s = 0.0;
  for (auto pause = std::chrono::microseconds(200); ::wait4(process, &status, WNOHANG, &usage) == 0;) {
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, std::chrono::microseconds(5000));
    spent_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (spent_s > start.patience_s) ::kill(process, SIGKILL);
  }
  spent_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  Ended result{.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
               .out = content(out),
               .err = content(err),
               .spent_s = spent_s,
               .peak_bytes = 1024.0 * static_cast<double>(usage.ru_maxrss)};
  if (spent_s > start.patience_s) result.code = 128 + SIGKILL;
  fs::remove_all(streams);
  return result;
}

fs::path programs_folder() {
  const char* folder = std::getenv("PALPA_BIN");
  return folder ? fs::path(folder) : fs::path();
}

std::string missing_program(const std::string& name) {
  const fs::path folder = programs_folder();
  if (folder.empty()) return "PALPA_BIN does not name the folder of the built programs";
  return fs::exists(folder / name) ? "" : (folder / name).string() + " is not built";
}

std::string broken_by_run(const Ended& run, bool may_answer_no) {
  const std::string line = last_line(run.err);
  const auto with = [&](const std::string& promise) { return promise + ": " + line.substr(0, 300); };
  if (run.code == 128 + SIGKILL) return with("a run ends: not within its time, or killed");
  if (run.code > 2) return with("a run ends with 0, 1 or 2: " + std::to_string(run.code));
  if (run.code == 1 && !may_answer_no) return with("a run ends with 1 only where that is an answer");
  if (run.peak_bytes > most_bytes)
    return with("a run takes no memory without bound: " + std::to_string(static_cast<long>(run.peak_bytes / 1e6)) + " MB");
  if (is_obeyed_by_terminals(run.out) || is_obeyed_by_terminals(run.err))
    return with("nothing is printed that a terminal obeys");
  if (run.code != 2) return {};
  const std::size_t place = line.find(": ", 7);
  if (!line.starts_with("palpa: ") || place == std::string::npos || line.find("; ", place) == std::string::npos)
    return with("an error says its place, what is wrong and what would be right");
  if (line.find("report this as a bug") != std::string::npos) return with("wrong input is not called a bug of Palpa");
  if (line.size() > longest_line) return with("an error is a line that can be read: " + std::to_string(line.size()));
  return {};
}

}  // namespace palpa::fuzz
