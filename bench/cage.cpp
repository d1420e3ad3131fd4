// What the cage costs: the start of palpa-read, from the request of a small file to its voxels, by two builds in turn.
//
//   bench_cage READER OTHER_READER FILE [TIMES]
//
// READER is this build's palpa-read, OTHER_READER one without a cage (built of an earlier version); FILE is best a small one.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/data/volume.h"
#include "palpa/file/read_volume.h"

namespace {

double seconds_of(const char* file, const char* reader) {
  palpa::ReadOptions options;
  options.reader = reader;
  const auto start = std::chrono::steady_clock::now();
  palpa::read_volume(file, options);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 4) {
    std::fputs("bench_cage READER OTHER_READER FILE [TIMES]\n", stderr);
    return 2;
  }
  const int times = count > 4 ? std::atoi(arguments[4]) : 200;
  std::vector<double> with_s, without_s, more_s;
  try {
    for (int n = 0; n < times; ++n) {  // in turn, so that what else the machine does meets both
      with_s.push_back(seconds_of(arguments[3], arguments[1]));
      without_s.push_back(seconds_of(arguments[3], arguments[2]));
      more_s.push_back(with_s.back() - without_s.back());
    }
  } catch (const palpa::LoadError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  std::printf("with %.2f ms, without %.2f ms, ratio %.3f, more %.2f ms (medians of %d)\n", 1e3 * median(with_s),
              1e3 * median(without_s), median(with_s) / median(without_s), 1e3 * median(more_s), times);
  return 0;
}
