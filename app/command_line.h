// The command line: command_lines.h has the line of each command, of which this makes the program.
#pragma once

#include <atomic>

namespace palpa::app {

/// Reads the command line and runs its command. Returns the exit code 0 or 1, or 2 after the one line
/// that says what is wrong with the command line; throws what the command throws.
int run_command_line(int argc, char** argv, const std::atomic<bool>& stop);

}  // namespace palpa::app
