// The command line: only command_line.cpp and reference.cpp know CLI11.
#pragma once

#include <atomic>

namespace palpa::app {

/// Reads the command line and runs its command. Returns the exit code 0 or 1, or 2 after the one line
/// that says what is wrong with the command line; throws what the command throws.
int run_command_line(int argc, char** argv, const std::atomic<bool>& stop);

}  // namespace palpa::app
