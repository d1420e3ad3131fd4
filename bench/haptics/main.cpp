// The benchmark of volume haptics (README.md beside this file): makes its data and measures renderers on them.
//
//   bench_haptics make DIR [--head FILE] [--quick]
//   bench_haptics run DIR --renderer [NAME=]COMMAND [--renderer …] [--quick] [--out DIR]
//
// --head: the CT head of tools/get-ct-head (cranium.mhd), for the cases of real scans. Tables go to stdout and, with the rows
// of each case, to OUT (default DIR/results): table.md, scores.csv, times.md and times.csv.
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "bench/haptics/run.h"
#include "bench/haptics/suite.h"
#include "palpa/base/load_error.h"
#include "palpa/base/new_file.h"

namespace {

namespace fs = std::filesystem;
using namespace palpa::haptics;

int usage() {
  std::fprintf(stderr,
               "usage: bench_haptics make DIR [--head FILE] [--quick]\n"
               "       bench_haptics run DIR --renderer [NAME=]COMMAND [--renderer ...] [--quick] [--out DIR]\n");
  return 2;
}

void write(const fs::path& file, const std::string& text) {
  palpa::detail::write_whole(file, text, palpa::detail::Existing::replaced);
}

void run_and_write(const fs::path& folder, const std::vector<NamedRenderer>& renderers, bool quick, const fs::path& out) {
  const std::vector<Result> results = run(folder, renderers, quick);
  fs::create_directories(out);
  write(out / "table.md", tables(results));
  write(out / "scores.csv", score_rows(results));
  write(out / "times.md", time_table(results));
  write(out / "times.csv", time_rows(results));
  std::printf("%s%s", tables(results).c_str(), time_table(results).c_str());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return usage();
  const std::string command = argv[1];
  const fs::path folder = argv[2];
  MakeOptions options{.sources = PALPA_HAPTICS_SOURCES};
  std::vector<NamedRenderer> renderers;
  fs::path out = folder / "results";
  for (int i = 3; i < argc; ++i) {
    const std::string argument = argv[i];
    const bool more = i + 1 < argc;
    if (argument == "--quick") {
      options.quick = true;
    } else if (argument == "--head" && more) {
      options.head_file = argv[++i];
    } else if (argument == "--renderer" && more) {
      renderers.push_back(named(argv[++i]));
    } else if (argument == "--out" && more) {
      out = argv[++i];
    } else {
      return usage();
    }
  }
  try {
    if (command == "make") {
      make(folder, options);
    } else if (command == "run" && !renderers.empty()) {
      run_and_write(folder, renderers, options.quick, out);
    } else {
      return usage();
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_haptics: %s\n", error.what());
    return 2;
  }
  return 0;
}
