#include "palpa/loop/loop.h"

namespace palpa {

Guard::Passed Guard::pass(const Vec3& force_n) noexcept {
  if (!is_finite(force_n)) return {.command_n = {}, .state = GuardState::fault};
  if (norm(force_n) <= max_force_n_) return {.command_n = force_n, .state = GuardState::pass};
  // A normalised vector may be a few ulp too long: shortened so that the command never exceeds the limit.
  constexpr double within = 1.0 - 0x1p-50;
  return {.command_n = (within * max_force_n_) * normalized(force_n), .state = GuardState::limited};
}

}  // namespace palpa
