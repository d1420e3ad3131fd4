// Damages files of the shared data, and made ones of the formats that they lack, at random, many times, and says what became of
// them: a row for each set.
//
//   mutate_data DATA_FOLDER [COUNT] [SEED] [PART_OF_A_NAME] [KEEP_FOLDER]
//
// 1 where something was wrong. A palpa-read that ended is not wrong: it is its user's one line. Both are said in lines below
// the row, and a copy of what they were about is put into KEEP_FOLDER.
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <map>

#include "data_sets.h"
#include "files.h"
#include "mutations.h"

int main(int argc, char** argv) {
  using namespace palpa::test;
  if (argc < 2) {
    std::fprintf(stderr, "usage: %s DATA_FOLDER [COUNT] [SEED] [PART_OF_A_NAME] [KEEP_FOLDER]\n", argv[0]);
    return 2;
  }
  const int count = argc > 2 ? std::atoi(argv[2]) : 1000;
  const auto seed = static_cast<std::uint32_t>(argc > 3 ? std::atoi(argv[3]) : 1);
  const std::string part = argc > 4 ? argv[4] : "";
  const fs::path keep = argc > 5 ? argv[5] : "";
  palpa::ReadOptions options = built_reader();
  if (options.reader.empty()) {
    std::fprintf(stderr, "%s: no palpa-read; set PALPA_BIN to the folder where it was built\n", argv[0]);
    return 2;
  }
  options.max_bytes = 1'000'000'000;
  options.idle_limit_s = 8.0;
  options.checksums = false;  // which would notice what a reader passes over
  std::puts(
      "| file | read | refused | of these palpa-read ended | slowest / s | memory, undamaged / MB | memory, at most / MB | "
      "wrong |");
  std::puts("|---|---|---|---|---|---|---|---|");
  bool wrong = false;
  for (const SetToDamage& set : sets_to_damage(argv[1])) {
    if (set.name.find(part) == std::string::npos) continue;
    std::fflush(stdout);
    // A process for each set, because the system says the peak over all children of one.
    const pid_t child = ::fork();
    if (child == 0) {
      const MutationResult r = read_mutations(set, count, seed, options, keep.empty() ? keep : keep / name_of({set.name}));
      std::printf("| %s | %d | %d | %zu | %.2f | %.0f | %.0f | %zu |\n", set.name.c_str(), r.read, r.refused, r.ended.size(),
                  r.slowest_s, r.true_peak_bytes / 1e6, r.peak_bytes / 1e6, r.wrong.size());
      if (!r.refused_undamaged.empty()) std::printf("  undamaged: %s\n", r.refused_undamaged.c_str());
      std::map<std::string, int> ended;
      for (const std::string& text : r.ended) ++ended[text];
      for (const auto& [text, times] : ended) std::printf("  ended %d times: %s\n", times, text.c_str());
      for (const std::string& text : r.wrong) std::printf("  wrong: %s\n", text.c_str());
      std::fflush(stdout);
      ::_exit(r.wrong.empty() ? 0 : 1);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    if (status != 0) wrong = true;
    if (WIFSIGNALED(status)) std::printf("| %s | CRASHED by signal %d | | | | | | 1 |\n", set.name.c_str(), WTERMSIG(status));
  }
  return wrong ? 1 : 0;
}
