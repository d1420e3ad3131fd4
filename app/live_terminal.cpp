#include "app/live_terminal.h"

#include <poll.h>
#include <unistd.h>

#include <cstdio>
#include <string>

#include "app/terminal.h"
#include "palpa/base/load_error.h"
#include "palpa/base/printed.h"
#include "palpa/base/sanitized.h"
#include "palpa/trace/trace.h"

namespace palpa::app {

namespace {
/// A background job must not change its terminal.
bool is_in_foreground() { return ::tcgetpgrp(STDIN_FILENO) == ::getpgrp(); }

std::string line_of(LiveLoop& loop) {
  const LoopStatistics statistics = loop.statistics();
  const LiveView& view = loop.latest();
  std::string guard = name_of(view.frame.command.guard);
  if (view.device_fault != nullptr)
    guard += std::string(": ") + view.device_fault;
  else if (view.frame.command.cause != GuardCause::none && view.frame.command.guard != GuardState::ramp)
    guard += std::string(": ") + format_cause(view.frame.command.cause);
  return detail::text("%.1f s  %4.2f N  late p99 %.0f us, max %.0f us  tick p99 %.0f us  missed %lld  %s", view.frame.t_s,
                      norm(view.frame.command.force_n), statistics.late.p99_us, statistics.late.max_us, statistics.tick.p99_us,
                      static_cast<long long>(statistics.missed), detail::shortened(detail::sanitized(guard), 100).c_str());
}
}  // namespace

LiveTerminal::LiveTerminal(const char* keys) : shows_(::isatty(STDERR_FILENO) == 1) {
  termios now{};
  if (::isatty(STDIN_FILENO) != 1 || !is_in_foreground() || ::tcgetattr(STDIN_FILENO, &now) != 0) return;
  before_ = now;
  take_keys();
  if (shows_) std::fputs((std::string(keys) + "\n").c_str(), stderr);
}

LiveTerminal::~LiveTerminal() {
  if (before_ && is_in_foreground()) ::tcsetattr(STDIN_FILENO, TCSANOW, &*before_);
  erase_line();
}

void LiveTerminal::erase_line() noexcept {
  if (shows_) std::fputs("\r\033[K", stderr);
}

// Keys are read one by one, without echo. After a stop the shell has reset that.
void LiveTerminal::take_keys() {
  termios now{};
  constexpr tcflag_t by_lines = ICANON | ECHO;
  if (::tcgetattr(STDIN_FILENO, &now) != 0 || (now.c_lflag & by_lines) == 0) return;
  now.c_lflag &= ~by_lines;
  ::tcsetattr(STDIN_FILENO, TCSANOW, &now);
}

bool LiveTerminal::watch(const std::function<std::string()>& line, const std::function<void(char)>& obey) {
  if (shows_ && looks_++ % looks_per_line == 0) {
    std::fputs(("\r\033[K" + line()).c_str(), stderr);
    std::fflush(stderr);
  }
  if (!before_ || !is_in_foreground()) return true;
  take_keys();
  pollfd keys{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  char key = 0;
  while (::poll(&keys, 1, 0) == 1 && ::read(STDIN_FILENO, &key, 1) == 1) {
    if (key == 'q') return false;
    obey(key);
  }
  return true;
}

bool LiveTerminal::watch(LiveLoop& loop, std::span<LiveScene* const> scenes) {
  return watch([&] { return line_of(loop); }, [&](char key) { obey(key, loop, scenes); });
}

void LiveTerminal::obey(char key, LiveLoop& loop, std::span<LiveScene* const> scenes) {
  if (key == ' ') {
    is_held_ = !is_held_;
    if (is_held_)
      loop.panic();
    else
      loop.resume();
  } else if (key >= '1' && key <= '9') {
    const std::size_t number = static_cast<std::size_t>(key - '1');
    try {
      for (LiveScene* const scene : scenes) {
        scene->change([&](Scene& changed) {
          if (number >= changed.modes().size()) return;
          changed.edit_mode(changed.modes()[number].name, [](SceneMode& mode) { mode.enabled = !mode.enabled; });
        });
      }
    } catch (const std::exception& error) {
      print_error(error.what());
    }
  }
}

}  // namespace palpa::app
