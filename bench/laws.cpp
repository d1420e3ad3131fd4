// How far earlier systems' laws are from the exact balance, in a scene under a hand: the tables of
// docs/laws.md.
//
//   bench_laws SCENE HAND [rigid|relaxed|firm] [DATA_FOLDER]
#include <palpa/palpa.h>

#include <cstdio>
#include <cstring>

using namespace palpa;

int main(int argc, char** argv) {
  if (argc < 3 || argc > 5) {
    std::fprintf(stderr, "usage: %s SCENE HAND [rigid|relaxed|firm] [DATA_FOLDER]\n", argv[0]);
    return 2;
  }
  RunOptions options;
  options.scene = argv[1];
  options.hand = argv[2];
  if (argc > 3)
    options.hold = std::strcmp(argv[3], "firm") == 0      ? Hold::firm
                   : std::strcmp(argv[3], "relaxed") == 0 ? Hold::relaxed
                                                          : Hold::rigid;
  if (argc > 4) options.scene_options.data_folders = {argv[4]};
  try {
    const std::vector<std::string> laws{"exact", "paper-2005", "ikits-2003", "ikits-2003-sequential", "no-proxy"};
    std::printf("%s", to_markdown(compare_laws(options, laws)).c_str());
    return 0;
  } catch (const LoadError& error) {
    std::fprintf(stderr, "bench_laws: %s\n", error.what());
    return 2;
  }
}
