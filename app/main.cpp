// Program palpa. Exit codes: 0 ok, 1 negative answer, 2 wrong usage or input, 128 + N ended by signal N.
#include <signal.h>
#include <sys/prctl.h>

#include <cstdio>
#include <new>
#include <system_error>

#include "app/command_line.h"
#include "app/terminal.h"
#include "palpa/base/load_error.h"
#include "palpa/loop/loop.h"

namespace {

std::atomic<bool> stop = false;
std::atomic<int> stopped_by = 0;
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free, "set in a signal handler");

/// The first interrupt, or a closed terminal, ends a run after the current tick; the second ends the program at once, with
/// forceless motors.
void stop_on_signals() {
  struct sigaction action = {};
  action.sa_handler = [](int number) {
    if (stop.exchange(true)) {
      const palpa::MotorsAtRest motors_at_rest;
      ::signal(number, SIG_DFL);
      ::raise(number);
    } else {
      stopped_by = number;
    }
  };
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) ::sigaction(number, &action, nullptr);
  // A file at its size limit is an error of its writer, like a full disk, and does not end the run.
  ::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace

int main(int argc, char** argv) {
  stop_on_signals();
  ::prctl(PR_SET_DUMPABLE,
          0);  // other programs of the user, readers included, can neither trace it nor read its memory
  int code = 2;
  try {
    code = palpa::app::run_command_line(argc, argv, stop);
  } catch (const palpa::LoadError& error) {
    if (!stop) palpa::app::print_error(error.what());
  } catch (const std::bad_alloc&) {
    palpa::app::print_error("memory: not enough; use smaller data");
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::resource_unavailable_try_again) {
      palpa::app::print_error(
          "memory: the system has no room for a thread; end other programs, or raise the limits of this user");
    } else {
      palpa::app::print_error(std::string("program: ") + error.what() + "; please report this as a bug of Palpa");
    }
  } catch (const std::exception& error) {
    palpa::app::print_error(std::string("program: ") + error.what() + "; please report this as a bug of Palpa");
  }
  if (stop) return 128 + stopped_by;
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) {
    palpa::app::print_error("standard output: cannot be written; is the disk full?");
    return 2;
  }
  return code;
}
