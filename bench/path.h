// The parts of bench_path: each prints one table.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palpa::bench {

struct PathOptions {
  std::filesystem::path data_folder;  ///< empty: no real data
  std::filesystem::path scenes_folder;
  std::vector<std::string> scenes;  ///< files; empty: all in `scenes_folder`
  int count = 0;                    ///< strokes, places or ticks; 0: the part's own
};

void drift(const PathOptions& options);
void bumpy(const PathOptions& options);
void grooves(const PathOptions& options);
void walls(const PathOptions& options);
void skull(const PathOptions& options);
void follow(const PathOptions& options);
void order(const PathOptions& options);
void rate(const PathOptions& options);
void halving(const PathOptions& options);
void still(const PathOptions& options);
void energy(const PathOptions& options);

}  // namespace palpa::bench
