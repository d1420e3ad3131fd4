// The testable claims of the paper of 2005, each with a number that this library works out: docs/reproduction.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/figures/paper_figures.h"

namespace palpa {

enum class Verdict : std::uint8_t { holds, holds_with_a_condition, does_not_hold };

/// One claim, what was measured, and what that says.
struct ClaimResult {
  int number = 0;        ///< 1 … 17
  std::string claim;     ///< of the paper, in few words
  std::string measured;  ///< the numbers, with their units
  Verdict verdict = Verdict::holds;
  std::string condition;  ///< empty where the verdict is `holds`
};

/// All claims, in order. The same numbers on every run of one machine; half a minute. A verdict is read from the numbers, never
/// written beside them. Throws LoadError where `examples_folder` has no mode to count.
std::vector<ClaimResult> reproduced_claims(const std::filesystem::path& examples_folder);

/// Figures of claims 5 and 6, 11, 13, and 16 and 17.
std::vector<Figure> reproduction_figures();

/// The claims as a Markdown table.
std::string to_markdown(const std::vector<ClaimResult>& claims);

}  // namespace palpa
