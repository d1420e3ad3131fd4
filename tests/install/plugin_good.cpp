// A valid plug-in that reports whether any of its code ran.
#include <cstdlib>

#include "plugin_ridge.h"

namespace {

[[gnu::constructor]] void say_that_it_ran() { ::setenv("PALPA_TEST_PLUGIN_RAN", "yes", 1); }

struct Good {
  static constexpr auto type = "lab.ridge";
};

}  // namespace

PALPA_MODES(palpa_test::RidgeOf<Good>)
