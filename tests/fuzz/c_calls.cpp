// Random calls of the functions for C against their promises (docs/c.md).
#include "tests/c/random_calls.h"
#include "tests/fuzz/campaigns.h"

namespace palpa::fuzz {
namespace {

Tried called(Choices& choices, const fs::path&) {
  const std::uint64_t count = 1 + choices.below(2000);
  test::RandomCalls calls(choices);
  Tried result{.tries = static_cast<std::int64_t>(count)};
  for (std::uint64_t n = 0; n < count && result.broken.empty(); ++n) {
    calls.next();
    if (!calls.broken.empty()) result.broken = calls.broken + ": call " + std::to_string(n);
  }
  return result;
}

}  // namespace

void add_c_calls(std::vector<Campaign>& to) {
  to.push_back(
      {.name = "c", .of = "calls", .long_tries = 10'000'000, .begin = [](const fs::path&) { return Attempt(called); }});
}

}  // namespace palpa::fuzz
