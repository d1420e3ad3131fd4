// Runs renderers over the cases, and writes the tables.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/haptics/renderer.h"
#include "bench/haptics/score.h"

namespace palpa::haptics {

struct NamedRenderer {
  std::string name;
  std::string command;
};
/// `NAME=COMMAND`, or a command that is its own name.
NamedRenderer named(const std::string& argument);

struct Result {
  std::string renderer;
  std::string family;
  std::string name;
  Answer::End end = Answer::End::whole;
  std::string reason;
  Scores scores;  ///< after a failure: of the forces before it, with zeros after it
  double load_s = 0.0;
  std::size_t ticks = 0;
  double outside_p50_us = 0.0;
  double outside_p99_us = 0.0;
  double inside_p50_us = -1.0;  ///< below 0: not reported
  double inside_p99_us = -1.0;
};

/// Runs each renderer over the cases of a folder, with progress on stderr. Throws LoadError.
std::vector<Result> run(const std::filesystem::path& folder, const std::vector<NamedRenderer>& renderers, bool quick);

/// A Markdown table for each family: a row for each renderer, figures are means over the supported cases.
std::string tables(const std::vector<Result>& results);
/// The times, which differ from run to run.
std::string time_table(const std::vector<Result>& results);
std::string score_rows(const std::vector<Result>& results);
std::string time_rows(const std::vector<Result>& results);

}  // namespace palpa::haptics
