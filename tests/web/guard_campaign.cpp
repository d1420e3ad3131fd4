// Campaign of the guard as a program of WebAssembly: guard_campaign SEED TICKS.
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/campaigns.h"

int main(int count, char** words) {
  if (count != 3) {
    std::fprintf(stderr, "usage: guard_campaign SEED TICKS\n");
    return 2;
  }
  std::vector<palpa::fuzz::Campaign> campaigns;
  palpa::fuzz::add_guard(campaigns);
  const palpa::fuzz::Attempt attempt = campaigns.front().begin({});
  const long long most = std::atoll(words[2]);
  long long ticks = 0, broken = 0, cases = 0;
  for (std::uint64_t seed = std::strtoull(words[1], nullptr, 10); ticks < most; ++seed, ++cases) {
    palpa::fuzz::Choices choices(seed);
    const palpa::fuzz::Tried tried = attempt(choices, {});
    ticks += tried.tries;
    if (tried.broken.empty()) continue;
    ++broken;
    std::printf("seed %llu: %s\n", static_cast<unsigned long long>(seed), tried.broken.c_str());
  }
  std::printf("%lld ticks, %lld cases, %lld broken promises\n", ticks, cases, broken);
  return broken == 0 ? 0 : 1;
}
