#include "app/terminal.h"

#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>

#include "palpa/toml/wording.h"

namespace palpa::app {

void print_error(std::string_view message) { std::fprintf(stderr, "palpa: %s\n", detail::one_line(message).c_str()); }

void print_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) std::fprintf(stderr, "palpa: warning: %s\n", detail::one_line(warning).c_str());
}

Progress::Progress(std::string what) : what_(detail::one_line(what)) {
  if (::isatty(STDERR_FILENO) != 1) return;
  // All signals are blocked in the drawing thread, so that an interrupt reaches the working thread, which may wait in a call
  // that has to end then.
  sigset_t all, before;
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  drawing_ = std::thread([this] { draw(); });
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
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
      std::fprintf(stderr, "\r\033[K%s: %.0f %%, about %.0f s left", what_.c_str(), 100.0 * share,
                   spent_s * (1.0 - share) / share);
    } else {
      std::fprintf(stderr, "\r\033[K%s: %.0f s", what_.c_str(), spent_s);
    }
    std::fflush(stderr);
  }
}

}  // namespace palpa::app
