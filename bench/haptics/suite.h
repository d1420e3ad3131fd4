// The benchmark as files: one folder, made by one command.
#pragma once

#include <filesystem>
#include <vector>

#include "bench/haptics/cases.h"

namespace palpa::haptics {

struct MakeOptions {
  std::filesystem::path sources;    ///< the benchmark's own folder, with hand.csv
  std::filesystem::path head_file;  ///< the CT head; empty: without scans
  bool quick = false;               ///< only the cases that a test runs
};

/// Writes into a folder:
///   cases/NAME.json    what the renderer is told
///   volumes/NAME.nrrd
///   probes/NAME.csv    the hand, tick by tick
///   truth/NAME.json    what is scored, and against which shape
///   truth/NAME.csv     the right force, tick by tick
///   SHA256SUMS         of all of them, for sha256sum -c
/// The same bytes on every machine with IEEE arithmetic. Throws LoadError.
void make(const std::filesystem::path& folder, const MakeOptions& options);

/// A case as the runner needs it.
struct MadeCase {
  std::string name;
  std::string family;
  std::filesystem::path file;  ///< for the renderer
  bool quick = false;
  std::vector<std::string> scores;
  nlohmann::json shape;
  int period_ticks = 0;
  double friction_deg = 0.0;
  std::vector<std::string> probe_lines;  ///< as the renderer gets them
  std::vector<Touch> touches;
};
/// The cases of a folder, by family in the order of the tables, then by name. Throws LoadError.
std::vector<MadeCase> read_cases(const std::filesystem::path& folder, bool quick);

}  // namespace palpa::haptics
