// Arguments of the benchmarks of a scene under a hand.
#pragma once

#include <palpa/palpa.h>

#include <cstdio>
#include <string_view>

#include "palpa/device/hand.h"
#include "palpa/study/run.h"

/// SCENE HAND [rigid|relaxed|firm] [DATA_FOLDER], then `measure(options)`; returns the exit code.
template <class Measure>
int run_with_arguments(int argc, char** argv, const char* name, Measure measure) {
  if (argc < 3 || argc > 5) {
    std::fprintf(stderr, "usage: %s SCENE HAND [rigid|relaxed|firm] [DATA_FOLDER]\n", argv[0]);
    return 2;
  }
  palpa::RunOptions options;
  options.scene = argv[1];
  options.hand = argv[2];
  options.recording.center = true;  // independent of the scene: figures are compared over versions
  if (argc > 3) {
    const std::string_view hold = argv[3];
    options.hold = hold == "firm" ? palpa::Hold::firm : hold == "relaxed" ? palpa::Hold::relaxed : palpa::Hold::rigid;
  }
  if (argc > 4) options.scene_options.data_folders = {argv[4]};
  try {
    measure(options);
    return 0;
  } catch (const palpa::LoadError& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 2;
  }
}
