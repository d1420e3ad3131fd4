// Invalid modes: the compiler's error lists a mode's parts (tests/mode/CMakeLists.txt).
#include <tuple>

#include "palpa/mode/mode.h"

namespace {

struct Named {
  static constexpr auto type = "lab.wrong";
};
struct Right : Named {
  static constexpr auto parameters() { return std::tuple{}; }
  void place(const palpa::ModeContext&, palpa::PrimitiveSink) const noexcept {}
};
struct WithoutParameters : Named {
  void place(const palpa::ModeContext&, palpa::PrimitiveSink) const noexcept {}
};
struct Throwing : Named {
  static constexpr auto parameters() { return std::tuple{}; }
  void place(const palpa::ModeContext&, palpa::PrimitiveSink) const {}
};
struct WithoutPlace : Named {
  static constexpr auto parameters() { return std::tuple{}; }
};
struct Forgetting : Right {
  struct Memory {
    int times = 0;
  };
};

}  // namespace

palpa::Mode made() { return MODE{}; }
