#include "app/terminal.h"

#include <unistd.h>

#include <cstdio>

#include "palpa/scene/wording.h"

namespace palpa::app {

void print_error(std::string_view message) { std::fprintf(stderr, "palpa: %s\n", detail::one_line(message).c_str()); }

void print_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) std::fprintf(stderr, "palpa: warning: %s\n", detail::one_line(warning).c_str());
}

Progress::Progress(std::string what)
    : what_(std::move(what)),
      on_terminal_(::isatty(STDERR_FILENO) == 1),
      begin_(std::chrono::steady_clock::now()),
      shown_(begin_) {}

Progress::~Progress() {
  if (on_terminal_) std::fputs("\r\033[K", stderr);
}

void Progress::show(double share_done) {
  const auto now = std::chrono::steady_clock::now();
  if (!on_terminal_ || now - shown_ < std::chrono::milliseconds(200) || share_done <= 0.0) return;
  shown_ = now;
  const double spent_s = std::chrono::duration<double>(now - begin_).count();
  std::fprintf(stderr, "\r\033[K%s: %.0f %%, about %.0f s left", what_.c_str(), 100.0 * share_done,
               spent_s * (1.0 - share_done) / share_done);
  std::fflush(stderr);
}

}  // namespace palpa::app
