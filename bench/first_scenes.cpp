// How the first scenes feel that `palpa info --scene` suggests: a table, one row for each file.
//
//   bench_first_scenes RECORDING FILE…
#include "tests/study/first_scenes.h"

#include <palpa/palpa.h>

#include <cstdio>

using namespace palpa;

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: %s RECORDING FILE...\n", argv[0]);
    return 2;
  }
  std::puts("| file | contact | below the limit | largest force / N | buzz at rest / mN | faults |\n|---|---|---|---|---|---|");
  for (int n = 2; n < argc; ++n) {
    const std::string file = std::filesystem::path(argv[n]).filename().string();
    try {
      const test::FirstTouch touch = test::first_touch(argv[n], argv[1], {});
      std::printf("| %s | %.0f %% | %.2f %% | %.2f | %.3g | %ld |\n", file.c_str(), 100.0 * touch.contact_share,
                  100.0 * touch.below_limit_share, touch.force_max_n, 1e3 * touch.buzz_n, touch.faults);
    } catch (const LoadError& error) {
      std::printf("| %s | not felt: %s | | | | |\n", file.c_str(), error.what());
    }
    std::fflush(stdout);
  }
  return 0;
}
