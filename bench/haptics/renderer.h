// A renderer: another program, spoken to in lines.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa::haptics {

/// What a renderer has answered to a case.
struct Answer {
  enum class End {
    whole,
    unsupported,  ///< it has said that it does not know the rule
    failed,       ///< it broke the protocol or its time
  };
  End end = End::whole;
  std::string reason;              ///< of what is not whole
  std::vector<Vec3> forces_n;      ///< as many as there were probes; zero from where it failed
  double load_s = 0.0;             ///< from its start to its first line
  std::vector<double> outside_us;  ///< from a probe's line to its force's line, pipes and all
  std::vector<double> inside_us;   ///< as it says itself; empty: it does not
};

struct Limits {
  double load_s = 120.0;
  double tick_s = 5.0;
  double case_s = 300.0;
};

/// Starts `command CASE_FILE` in a shell, sends it the lines one after another, each when the last is answered, and ends it.
/// Forces longer than `limit_n` [N] are shortened, as a device would. Throws LoadError where no process can be started.
Answer render(const std::string& command, const std::filesystem::path& case_file, const std::vector<std::string>& probe_lines,
              double limit_n, const Limits& limits = {});

}  // namespace palpa::haptics
