// The built programs as their users start them, with limits, and what is promised of every run of one.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace palpa::fuzz {

namespace fs = std::filesystem;

/// A run of a program that came to its end.
struct Ended {
  int code = -1;  ///< exit code; 128 + signal where a signal ended it
  std::string out, err;
  double spent_s = 0.0;
  double peak_bytes = 0.0;  ///< most resident memory
};

#if defined(__SANITIZE_ADDRESS__)
constexpr bool is_sanitized = true;
#else
constexpr bool is_sanitized = false;
#endif
/// [1] How much longer a run may take than without sanitizers.
constexpr double slowness = is_sanitized ? 5.0 : 1.0;

struct Start {
  fs::path program;
  std::vector<std::string> arguments;
  fs::path folder;                               ///< where it runs
  double patience_s = 30.0;                      ///< after that it is killed
  std::function<void()> before = nullptr;        ///< in the new process, before it becomes the program
  std::function<void(int)> meanwhile = nullptr;  ///< in this process, with the other's id, once it runs
};

/// Starts it and waits for its end.
Ended ended(const Start& start);

/// The folder of built programs, $PALPA_BIN; empty where there is none.
fs::path programs_folder();
/// Why `name` cannot be run; empty: it can.
std::string missing_program(const std::string& name);

/// What every run of `palpa` promises: it ends, with exit code 0 or 2, or 1 where that is an answer; what is wrong is one line,
/// `palpa: PLACE: what is wrong; what would be right`; nothing is printed that a terminal obeys; memory stays within bounds.
/// Empty, or the promise that was broken.
std::string broken_by_run(const Ended& ended, bool may_answer_no = false);

}  // namespace palpa::fuzz
