// The benchmark as files in one folder, made by one command.
#pragma once

#include <filesystem>
#include <vector>

#include "bench/haptics/cases.h"

namespace palpa::haptics {

struct MakeOptions {
  std::filesystem::path sources;    ///< the benchmark's own folder, with hand.csv
  std::filesystem::path head_file;  ///< the CT head; empty: without scans
  bool quick = false;               ///< only the cases of the tests
};

/// Writes into a folder:
///   cases/NAME.json    a renderer's input
///   volumes/NAME.nrrd
///   probes/NAME.csv    the hand, tick by tick
///   truth/NAME.json    the scores and their reference shape
///   truth/NAME.csv     the right force, tick by tick
///   SHA256SUMS         of all of them, for sha256sum -c
/// Byte-identical on every machine with IEEE arithmetic. Throws LoadError.
void make(const std::filesystem::path& folder, const MakeOptions& options);

struct MadeCase {
  std::string name;
  std::string family;
  std::filesystem::path file;
  bool quick = false;
  std::vector<std::string> scores;
  nlohmann::json shape;
  int period_ticks = 0;
  double friction_deg = 0.0;
  std::vector<std::string> probe_lines;
  std::vector<Touch> touches;
};
/// A folder's cases, by family in the tables' order, then by name. Throws LoadError.
std::vector<MadeCase> read_cases(const std::filesystem::path& folder, bool quick);

}  // namespace palpa::haptics
