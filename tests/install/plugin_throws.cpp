// A plug-in whose mode cannot be made.
#include <stdexcept>

#include "plugin_ridge.h"

struct Sulking {
  static constexpr auto type = "lab.sulking";
  static void begin() { throw std::runtime_error("no table of constants"); }
};
PALPA_MODES(palpa_test::RidgeOf<Sulking>)
