// Random hands against the limiter: every command is checked against docs/safety.md; and the limiter's cost per tick.
//
//   bench_guard [TICKS [SEED]]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "tests/guard/guard_laws.h"

namespace {

using namespace palpa;

double nanoseconds_per_tick(const GuardOptions& options) {
  test::RandomHand hand(1);
  std::vector<GuardInput> inputs;
  for (int i = 0; i < 100'000; ++i) inputs.push_back(hand.next());
  Guard guard(options);
  double best_ns = 1e9, sum_n = 0;
  for (int round = 0; round < 20; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    for (const GuardInput& in : inputs) sum_n += guard.tick(in).command_n.x;
    const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - begin;
    best_ns = std::min(best_ns, spent.count() / static_cast<double>(inputs.size()));
  }
  return sum_n == 0.123 ? 0.0 : best_ns;
}

}  // namespace

int main(int argc, char** argv) {
  const long long wanted = argc > 1 ? std::atoll(argv[1]) : 10'000'000;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  constexpr int ticks_of_hand = 20'000;
  long long ticks = 0, broken = 0, hands = 0, felt = 0, returns = 0;
  const auto begin = std::chrono::steady_clock::now();
  for (; ticks < wanted; ++hands) {
    test::RandomHand hand(seed + static_cast<std::uint64_t>(hands));
    const GuardOptions options = hand.options();
    Guard guard(options);
    test::Judge judge(options);
    for (int i = 0; i < ticks_of_hand && ticks < wanted; ++i, ++ticks) {
      const GuardInput in = hand.next();
      const Guard::Passed out = guard.tick(in);
      felt += out.command_n != Vec3{};
      returns += out.begins;
      if (const char* promise = judge.broken_by(in, guard, out)) {
        if (++broken <= 10) std::printf("hand %lld, tick %d: broken: %s\n", hands, i, promise);
      }
    }
  }
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
  std::printf("%lld ticks of %lld random hands in %.1f s: %lld with a force, %lld returns, %lld broken promises\n", ticks,
              hands, spent.count(), felt, returns, broken);
  std::printf("a tick costs %.0f ns with all of it, %.0f ns as the limit alone\n", nanoseconds_per_tick({}),
              nanoseconds_per_tick({.motors = false}));
  return broken == 0 ? 0 : 1;
}
