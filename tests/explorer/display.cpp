#include "display.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

namespace palpa::explorer {

std::string start_display() {
  const std::filesystem::path home =
      std::filesystem::temp_directory_path() / ("palpa-explorer-test-" + std::to_string(::getpid()));
  std::filesystem::create_directories(home);
  std::filesystem::permissions(home, std::filesystem::perms::owner_all);
  ::setenv("HOME", home.c_str(), 1);
  ::setenv("XDG_RUNTIME_DIR", home.c_str(), 1);
  for (const char* variable : {"XDG_CONFIG_HOME", "XDG_DATA_HOME", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"}) ::unsetenv(variable);

  int told[2];
  if (::pipe(told) != 0) return "no pipe";
  const pid_t server = ::fork();
  if (server == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::close(told[0]);
    const int nothing = ::open("/dev/null", O_WRONLY);
    ::dup2(nothing, STDOUT_FILENO);
    ::dup2(nothing, STDERR_FILENO);
    const std::string number = std::to_string(told[1]);
    ::execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", "1600x1000x24", "-nolisten", "tcp", nullptr);
    ::_exit(127);
  }
  ::close(told[1]);
  std::string number;
  char letter = 0;
  pollfd ready{.fd = told[0], .events = POLLIN, .revents = 0};
  while (::poll(&ready, 1, 20'000) == 1 && ::read(told[0], &letter, 1) == 1 && letter != '\n') number += letter;
  ::close(told[0]);
  if (number.empty()) return "Xvfb does not start; on Debian: apt install xvfb";
  ::setenv("DISPLAY", (":" + number).c_str(), 1);
  return {};
}

}  // namespace palpa::explorer
