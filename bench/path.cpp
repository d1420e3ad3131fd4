// Accuracy of the proxy's path: a table for each figure that the theory quotes.
//
//   bench_path [--part NAME]… [--scene FILE]… [--count N] [DATA_FOLDER]
//
// Without --part all parts that need no data, and with a folder of data all. --count: strokes, places or ticks instead of the
// part's own. Scenes are read from scenes/ beside the source.
#include "bench/path.h"

#include <palpa/base/load_error.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace {

using palpa::bench::PathOptions;

struct Part {
  std::string_view name;
  void (*measure)(const PathOptions&);
};
constexpr Part parts[] = {
    {"drift", palpa::bench::drift}, {"bumpy", palpa::bench::bumpy},   {"grooves", palpa::bench::grooves},
    {"walls", palpa::bench::walls}, {"skull", palpa::bench::skull},   {"follow", palpa::bench::follow},
    {"order", palpa::bench::order}, {"rate", palpa::bench::rate},     {"halving", palpa::bench::halving},
    {"still", palpa::bench::still}, {"energy", palpa::bench::energy},
};

int usage() {
  std::fprintf(stderr, "usage: bench_path [--part NAME]... [--scene FILE]... [--count N] [DATA_FOLDER]\nparts:");
  for (const Part& part : parts) std::fprintf(stderr, " %s", std::string(part.name).c_str());
  std::fprintf(stderr, "\n");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  PathOptions options;
  options.scenes_folder = PALPA_SCENES_FOLDER;
  std::vector<std::string_view> wanted;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    const bool more = i + 1 < argc;
    if (argument == "--part" && more) {
      wanted.emplace_back(argv[++i]);
    } else if (argument == "--scene" && more) {
      options.scenes.emplace_back(argv[++i]);
    } else if (argument == "--count" && more) {
      options.count = std::atoi(argv[++i]);
    } else if (!argument.starts_with("-")) {
      options.data_folder = argument;
    } else {
      return usage();
    }
  }
  for (const std::string_view name : wanted) {
    bool known = false;
    for (const Part& part : parts) known = known || part.name == name;
    if (!known) return usage();
  }
  try {
    for (const Part& part : parts) {
      bool measured = wanted.empty();
      for (const std::string_view name : wanted) measured = measured || name == part.name;
      if (!measured) continue;
      std::printf("== %s\n", std::string(part.name).c_str());
      part.measure(options);
      std::printf("\n");
    }
  } catch (const palpa::LoadError& error) {
    std::fprintf(stderr, "bench_path: %s\n", error.what());
    return 2;
  }
  return 0;
}
