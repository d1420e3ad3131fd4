// Deviation of earlier systems' laws from the exact balance, in a scene under a hand: the tables of docs/laws.md.
//
//   bench_laws SCENE HAND [rigid|relaxed|firm] [DATA_FOLDER]
#include "palpa/study/compare_laws.h"
#include "palpa/study/run.h"
#include "run_arguments.h"

using namespace palpa;

int main(int argc, char** argv) {
  return run_with_arguments(argc, argv, "bench_laws", [](const RunOptions& options) {
    const std::vector<std::string> laws{"exact", "paper-2005", "ikits-2003", "ikits-2003-sequential", "no-proxy"};
    std::printf("%s", to_markdown(compare_laws(options, laws)).c_str());
  });
}
