// Command line of the program, assembled from the command lines in command_lines.h.
#pragma once

#include <atomic>

namespace palpa::app {

/// Parses the command line and runs its command. Returns exit code 0 or 1, or 2 after an error in the command line; throws the
/// command's exceptions.
int run_command_line(int argc, char** argv, const std::atomic<bool>& stop);

}  // namespace palpa::app
