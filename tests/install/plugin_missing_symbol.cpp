// A plug-in that was not linked with all that it uses.
#include "plugin_ridge.h"

void lab_table();

struct Groove {
  static constexpr auto type = "lab.groove";
  static void begin() { lab_table(); }
};
PALPA_MODES(palpa_test::RidgeOf<Groove>)
