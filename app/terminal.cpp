#include "app/terminal.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>

#include "palpa/base/printed.h"
#include "palpa/base/sanitized.h"
#include "palpa/device/blocked_signals.h"

namespace palpa::app {

namespace {

constexpr std::size_t longest_line_bytes = 500;  // of an error. More: a long path hides the error; less: sentences are cut

void put(const std::string& text, std::FILE* to) { std::fwrite(text.data(), 1, text.size(), to); }

/// Prints `before` whole and shortens the middle of the message.
void put_line(const std::string& before, std::string_view message) {
  put(before + detail::shortened(detail::sanitized(message), longest_line_bytes - before.size() - 1) + "\n", stderr);
}

}  // namespace

void print(std::string_view text) { put(detail::sanitized(text, true), stdout); }
void tell(std::string_view text) { put(detail::sanitized(text, true), stderr); }

void print_error(std::string_view message) { put_line("palpa: ", message); }

void print_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) put_line("palpa: warning: ", warning);
}

Progress::Progress(std::string what) : what_(detail::sanitized(what)) {
  if (::isatty(STDERR_FILENO) != 1) return;
  // All signals are blocked in the drawing thread, so that an interrupt reaches the working thread, whose system call it must
  // end.
  const detail::BlockedSignals in_the_drawing_thread;
  drawing_ = std::thread([this] { draw(); });
}

Progress::~Progress() {
  if (!drawing_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  ends_.notify_one();
  drawing_.join();
  std::fputs("\r\033[K", stderr);
}

void Progress::draw() {
  using namespace std::chrono_literals;
  const auto begin = std::chrono::steady_clock::now();
  std::unique_lock lock(mutex_);
  for (auto pause = 500ms; !ends_.wait_for(lock, pause, [this] { return over_; }); pause = 200ms) {
    const double spent_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const double share = share_done_;
    if (share > 0.0) {
      std::fputs(
          detail::text("\r\033[K%s: %.0f %%, about %.0f s left", what_.c_str(), 100.0 * share, spent_s * (1.0 - share) / share)
              .c_str(),
          stderr);
    } else {
      std::fputs(detail::text("\r\033[K%s: %.0f s", what_.c_str(), spent_s).c_str(), stderr);
    }
    std::fflush(stderr);
  }
}

}  // namespace palpa::app
