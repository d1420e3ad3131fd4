// Largest work of a tick: hostile scenes and hands (tests/session/hostile_scene.h), the work units of their ticks, and their
// processor time.
//
//   bench_work [SCENES [TICKS]]
#include <palpa/palpa.h>
#include <time.h>

#include <cstdio>
#include <cstdlib>
#include <vector>

#include "palpa/data/quantile.h"
#include "tests/session/hostile_scene.h"

namespace {

using namespace palpa;

double thread_s() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void print(const char* name, const char* unit, std::vector<double> all) {
  const auto at = [&](double share) { return detail::quantile(all, share); };
  std::printf("%-5s median %6.0f   p99 %6.0f   worst %6.0f %s\n", name, at(0.5), at(0.99), at(1.0), unit);
}

}  // namespace

int main(int argc, char** argv) {
  const int scenes = argc > 1 ? std::atoi(argv[1]) : 25, ticks = argc > 2 ? std::atoi(argv[2]) : 400;
  if (scenes < 1 || ticks < 1) {
    std::fprintf(stderr, "usage: %s [SCENES [TICKS]]; each one or more\n", argv[0]);
    return 2;
  }
  test::Random random(7);
  std::vector<double> work, us;
  int waiting = 0;
  for (int scene = 0; scene < scenes; ++scene) {
    Session session(test::hostile_scene(random, 400.0));
    test::HostileHand hand(random);
    for (int i = 0; i < ticks; ++i) {
      const Vec3 at_m = hand.next();
      const double begin_s = thread_s();
      const Tick tick = session.tick({.position_m = at_m}, 1e-3);
      us.push_back(1e6 * (thread_s() - begin_s));
      work.push_back(tick.work);
      waiting += tick.status == TickStatus::waiting;
    }
  }
  std::printf("%zu ticks, %d of them waiting; nothing is begun after %d units\n", work.size(), waiting, Session::most_work);
  print("work", "units", work);
  print("time", "us", us);
}
