// Palpa's parsers under libFuzzer: libfuzzer NAME; see the script beside it.
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "tests/fuzz/parsers.h"

namespace {

using namespace palpa::fuzz;

Parser chosen;
fs::path folder;

}  // namespace

/// $PALPA_PARSER names the parser; its seeds go into the corpus, the first folder among the arguments.
extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
  const char* name = std::getenv("PALPA_PARSER");
  std::vector<Parser> all = parsers();
#if PALPA_HAS_READER
  for (Parser& parser : parsers_of_reader()) all.push_back(parser);
#endif
  for (const Parser& parser : all) {
    if (name != nullptr && parser.name == name) chosen = parser;
  }
  if (chosen.broken_by == nullptr) {
    std::fputs("PALPA_PARSER names none of the parsers:", stderr);
    for (const Parser& parser : all) std::fprintf(stderr, " %s", parser.name.c_str());
    std::fputs("\n", stderr);
    std::exit(2);
  }
  std::string made = (fs::temp_directory_path() / "palpa-libfuzzer-XXXXXX").string();
  folder = ::mkdtemp(made.data());
  std::atexit([] { fs::remove_all(folder); });
  for (int n = 1; n < *count; ++n) {
    if ((*arguments)[n][0] == '-' || !fs::is_directory((*arguments)[n])) continue;
    int number = 0;
    for (const std::string& seed : chosen.seeds())
      std::ofstream(fs::path((*arguments)[n]) / ("seed-" + std::to_string(++number)), std::ios::binary) << seed;
    break;
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* bytes, std::size_t size) {
  const std::string broken = chosen.broken_by({reinterpret_cast<const char*>(bytes), size}, folder);
  if (broken.empty()) return 0;
  std::fprintf(stderr, "%s\n", broken.c_str());
  std::abort();
}
