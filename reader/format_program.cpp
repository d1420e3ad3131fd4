// palpa-read-PROGRAM: one program for formats with common libraries, grouped by the build.
#include "serve.h"

namespace palpa::reader {
#define PALPA_FORMAT(name) std::unique_ptr<Source> open_##name(const protocol::Request& request);
PALPA_FORMATS
#undef PALPA_FORMAT
}  // namespace palpa::reader

int main(int, char** arguments) {
  using namespace palpa::reader;
#define PALPA_FORMAT(name) {#name, open_##name},
  return serve(arguments[1], {PALPA_FORMATS});
#undef PALPA_FORMAT
}
