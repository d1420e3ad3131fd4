#include "bench/haptics/renderer.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "palpa/base/load_error.h"

namespace palpa::haptics {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// A program with pipes to its two streams; the destructor ends it and its children.
class Process {
 public:
  Process(const std::string& command, const std::string& argument) {
    int to[2], from[2];
    if (::pipe2(to, O_CLOEXEC) != 0) throw LoadError(std::string("pipe: ") + std::strerror(errno) + "; try again");
    if (::pipe2(from, O_CLOEXEC) != 0) {
      ::close(to[0]), ::close(to[1]);
      throw LoadError(std::string("pipe: ") + std::strerror(errno) + "; try again");
    }
    const std::string line = "exec " + command + " \"$0\"";
    child_ = ::fork();
    if (child_ == 0) {
      ::setpgid(0, 0);
      ::signal(SIGPIPE, SIG_DFL);
      ::dup2(to[0], 0);
      ::dup2(from[1], 1);
      ::execl("/bin/sh", "sh", "-c", line.c_str(), argument.c_str(), nullptr);
      ::_exit(127);
    }
    ::close(to[0]), ::close(from[1]);
    in_ = to[1], out_ = from[0];
    if (child_ < 0) {
      ::close(in_), ::close(out_);
      throw LoadError(std::string("fork: ") + std::strerror(errno) + "; try again");
    }
    ::setpgid(child_, child_);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process() {
    ::close(in_), ::close(out_);
    // Time for a normal exit, then a kill.
    for (int i = 0; i < 100 && ::waitpid(child_, nullptr, WNOHANG) == 0; ++i) ::usleep(10000);
    if (::kill(-child_, SIGKILL) == 0) ::waitpid(child_, nullptr, 0);
  }

  /// False on a short write. A line is far shorter than a pipe's buffer.
  bool send(const std::string& line) const {
    return ::write(in_, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  }

  /// The next line, without its end; none after the limit or beyond the longest answer.
  std::optional<std::string> line(double limit_s) {
    constexpr std::size_t longest = 1000;
    const Clock::time_point begin = Clock::now();
    for (;;) {
      const std::size_t end = read_.find('\n');
      if (end != std::string::npos) {
        std::string found = read_.substr(0, end);
        read_.erase(0, end + 1);
        return found;
      }
      const double left_s = limit_s - seconds_since(begin);
      pollfd wait{out_, POLLIN, 0};
      if (read_.size() > longest || left_s <= 0.0 || ::poll(&wait, 1, static_cast<int>(1e3 * left_s) + 1) < 0) return {};
      if (wait.revents == 0) continue;
      char buffer[4096];
      const ssize_t bytes = ::read(out_, buffer, sizeof buffer);
      if (bytes <= 0) return {};
      read_.append(buffer, static_cast<std::size_t>(bytes));
    }
  }

 private:
  pid_t child_ = -1;
  int in_ = -1, out_ = -1;
  std::string read_;
};

struct Reply {
  Vec3 force_n;
  std::optional<double> inside_us;
};
std::optional<Reply> reply_of(const std::string& line) {
  double numbers[4] = {};
  int count = 0;
  const char* at = line.c_str();
  for (; count < 4; ++count) {
    char* end = nullptr;
    numbers[count] = std::strtod(at, &end);
    if (end == at) break;
    at = end;
  }
  at += std::strspn(at, " \t\r");
  const Vec3 force_n{numbers[0], numbers[1], numbers[2]};
  if (*at != '\0' || count < 3 || !is_finite(force_n)) return {};
  return Reply{force_n, count == 4 ? std::optional(numbers[3]) : std::nullopt};
}

}  // namespace

Answer render(const std::string& command, const std::filesystem::path& case_file, const std::vector<std::string>& probe_lines,
              double limit_n, const Limits& limits) {
  ::signal(SIGPIPE, SIG_IGN);  // a dead renderer shows as a missing answer
  Answer answer;
  answer.forces_n.resize(probe_lines.size());
  const auto fail = [&](std::string reason) {
    answer.end = Answer::End::failed;
    answer.reason = std::move(reason);
    return answer;
  };
  const Clock::time_point start = Clock::now();
  Process process(command, case_file.string());
  const std::optional<std::string> first = process.line(limits.load_s);
  answer.load_s = seconds_since(start);
  if (!first) return fail("no first line; the first line is 'ready' or 'unsupported: WHY'");
  constexpr std::string_view unsupported = "unsupported:";
  if (first->starts_with(unsupported)) {
    answer.end = Answer::End::unsupported;
    answer.reason = first->substr(unsupported.size());
    return answer;
  }
  if (*first != "ready") return fail("the first line is '" + *first + "'; it is 'ready' or 'unsupported: WHY'");

  const Clock::time_point begin = Clock::now();
  answer.outside_us.reserve(probe_lines.size());
  for (std::size_t i = 0; i < probe_lines.size(); ++i) {
    const auto at_tick = [&](const char* what) { return "tick " + std::to_string(i) + ": " + what; };
    if (seconds_since(begin) > limits.case_s) return fail(at_tick("the time for a case is over"));
    const Clock::time_point asked = Clock::now();
    if (!process.send(probe_lines[i])) return fail(at_tick("it has ended"));
    const std::optional<std::string> line = process.line(limits.tick_s);
    if (!line) return fail(at_tick("no answer; one line for each probe, flushed"));
    answer.outside_us.push_back(1e6 * seconds_since(asked));
    const std::optional<Reply> reply = reply_of(*line);
    if (!reply)
      return fail(at_tick(("'" + *line + "' is no force; three finite numbers [N], and if you like your time [us]").c_str()));
    answer.forces_n[i] = shortened(reply->force_n, limit_n);
    if (reply->inside_us) answer.inside_us.push_back(*reply->inside_us);
  }
  return answer;
}

}  // namespace palpa::haptics
