// Random hands against the limiter's promises (docs/safety.md).
#include "tests/fuzz/campaigns.h"
#include "tests/guard/guard_laws.h"

namespace palpa::fuzz {
namespace {

Tried guarded(Choices& choices, const fs::path&) {
  test::RandomHand hand(choices.below(std::uint64_t{1} << 32));
  const std::uint64_t ticks = 1 + choices.below(20'000);
  const GuardOptions options = hand.options();
  Guard guard(options);
  test::Judge judge(options);
  Tried result{.tries = static_cast<std::int64_t>(ticks)};
  for (std::uint64_t n = 0; n < ticks; ++n) {
    const GuardInput in = hand.next();
    const Guard::Passed out = guard.tick(in);
    if (const char* broken = judge.broken_by(in, guard, out)) {
      result.broken = broken + (": tick " + std::to_string(n));
      break;
    }
  }
  return result;
}

}  // namespace

void add_guard(std::vector<Campaign>& to) {
  to.push_back(
      {.name = "guard", .of = "ticks", .long_tries = 1'000'000'000, .begin = [](const fs::path&) { return Attempt(guarded); }});
}

}  // namespace palpa::fuzz
