// A plug-in whose mode's construction throws.
#include <stdexcept>

#include "plugin_ridge.h"

struct Sulking {
  static constexpr auto type = "lab.sulking";
  static void begin() { throw std::runtime_error("no table of constants"); }
};
PALPA_MODES(palpa_test::RidgeOf<Sulking>)
