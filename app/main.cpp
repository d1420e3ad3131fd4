// palpa: the program. Exit codes: 0 ok, 1 it ran and the answer is no, 2 wrong usage or input, 128 + N ended by signal N: 130
// interrupted.
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

/// The first interrupt, or a terminal that is closed, ends a run after the current tick; the second one ends the program at
/// once, with no motor under force.
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
  // A file that may not grow any more is an error of its writer, like a full disk, and not the end of a run.
  ::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace

int main(int argc, char** argv) {
  stop_on_signals();
  ::prctl(PR_SET_DUMPABLE,
          0);  // what runs as the same user, a reader of files as well, can neither trace it nor see its memory
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
