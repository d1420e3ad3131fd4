// A renderer: another program, driven line by line.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa::haptics {

struct Answer {
  enum class End {
    whole,
    unsupported,  ///< it rejected the rule
    failed,       ///< it broke the protocol or its time
  };
  End end = End::whole;
  std::string reason;
  std::vector<Vec3> forces_n;      ///< one per probe; zero from a failure on
  double load_s = 0.0;             ///< from its start to its first line
  std::vector<double> outside_us;  ///< from a probe's line to its force's line, with the pipes
  std::vector<double> inside_us;   ///< as it reports itself; empty: it does not
};

struct Limits {
  double load_s = 120.0;
  double tick_s = 5.0;
  double case_s = 300.0;
};

/// Starts `command CASE_FILE` in a shell, sends each line after the answer to the line before, and ends it. Forces above
/// `limit_n` [N] are shortened, as a device would. Throws LoadError if no process starts.
Answer render(const std::string& command, const std::filesystem::path& case_file, const std::vector<std::string>& probe_lines,
              double limit_n, const Limits& limits = {});

}  // namespace palpa::haptics
