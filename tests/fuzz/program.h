// The built programs as processes with limits, and the promises of every run.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace palpa::fuzz {

namespace fs = std::filesystem;

/// Result of a finished run.
struct Ended {
  int code = -1;  ///< exit code; 128 + signal after a signal
  std::string out, err;
  double spent_s = 0.0;
  double peak_bytes = 0.0;
};

#if defined(__SANITIZE_ADDRESS__)
constexpr bool is_sanitized = true;
#else
constexpr bool is_sanitized = false;
#endif
/// [1] Factor on a run's time under sanitizers.
constexpr double slowness = is_sanitized ? 5.0 : 1.0;

struct Start {
  fs::path program;
  std::vector<std::string> arguments;
  fs::path folder;
  double patience_s = 30.0;                      ///< then killed
  std::function<void()> before = nullptr;        ///< in the new process, before exec
  std::function<void(int)> meanwhile = nullptr;  ///< in this process, with the other's id, once it runs
};

/// Starts it and waits for its end.
Ended ended(const Start& start);

/// The folder of built programs, $PALPA_BIN; empty without it.
fs::path programs_folder();
/// The reason why `name` cannot be run; empty: none.
std::string missing_program(const std::string& name);

/// The promise of every run of `palpa`: an end with exit code 0 or 2, or 1 as an answer; errors of one line, `palpa: PLACE:
/// what is wrong; what would be right`; no terminal controls; bounded memory. Empty, or the broken promise.
std::string broken_by_run(const Ended& ended, bool may_answer_no = false);

}  // namespace palpa::fuzz
