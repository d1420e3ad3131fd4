// The paper's testable claims, measured: prints the table of docs/reproduction.md.
//   palpa_reproduction [FOLDER]      also draws its figure into FOLDER
#include <cstdio>
#include <exception>

#include "tools/figures/reproduction.h"

int main(int count, char** arguments) {
  if (count > 2) {
    std::fprintf(stderr, "usage: palpa_reproduction [FOLDER]\n");
    return 2;
  }
  try {
    std::fputs(palpa::to_markdown(palpa::reproduced_claims(PALPA_EXAMPLES_FOLDER)).c_str(), stdout);
    if (count == 2) palpa::write_figures(arguments[1], palpa::reproduction_figures());
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "palpa_reproduction: %s\n", error.what());
    return 2;
  }
}
