// A plug-in with a missing library.
#include "plugin_ridge.h"

void lab_table();

struct Groove {
  static constexpr auto type = "lab.groove";
  static void begin() { lab_table(); }
};
PALPA_MODES(palpa_test::RidgeOf<Groove>)
