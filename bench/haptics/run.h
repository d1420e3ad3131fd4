// Runs renderers over the cases, and writes the tables.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/haptics/renderer.h"
#include "bench/haptics/score.h"

namespace palpa::haptics {

/// A renderer with the name that tables have for it.
struct NamedRenderer {
  std::string name;
  std::string command;
};
/// `NAME=COMMAND`, or a command that is its own name.
NamedRenderer named(const std::string& argument);

/// What one renderer made of one case.
struct Result {
  std::string renderer;
  std::string family;
  std::string name;
  Answer::End end = Answer::End::whole;
  std::string reason;
  Scores scores;  ///< where it failed: of the forces up to there, and none from there on
  double load_s = 0.0;
  std::size_t ticks = 0;
  double outside_p50_us = 0.0;
  double outside_p99_us = 0.0;
  double inside_p50_us = -1.0;  ///< below zero: it does not say
  double inside_p99_us = -1.0;
};

/// Runs each over the cases of a folder. Tells on stderr how far it is. Throws LoadError.
std::vector<Result> run(const std::filesystem::path& folder, const std::vector<NamedRenderer>& renderers, bool quick);

/// A table in Markdown for each family: a row for each renderer, each figure the mean over the cases that it knows.
std::string tables(const std::vector<Result>& results);
/// The times, which differ from run to run.
std::string time_table(const std::vector<Result>& results);
/// One row for each case and renderer.
std::string score_rows(const std::vector<Result>& results);
std::string time_rows(const std::vector<Result>& results);

}  // namespace palpa::haptics
