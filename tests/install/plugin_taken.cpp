// A plug-in whose second mode has a name of Palpa's modes.
#include "plugin_ridge.h"

struct Other {
  static constexpr auto type = "lab.other";
};
struct Follow {
  static constexpr auto type = "follow";
};
PALPA_MODES(palpa_test::RidgeOf<Other>, palpa_test::RidgeOf<Follow>)
