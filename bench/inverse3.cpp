// An Inverse3 end to end: the loop, its link, and a stand-in for Haply's Inverse Service on this machine.
//
//   bench_inverse3 SCENE HAND [rigid|relaxed|firm] [DATA_FOLDER]
//   bench_inverse3 stand-in SCENE HAND [rigid|relaxed|firm] [DATA_FOLDER]     the stand-in alone, for 70 s: prints its port
//
// The round trip is from a written force to the receipt of a state sent after it. Then the scene runs for 60 s at 1 kHz, with
// the stand-in's handle on the path of the run's hand.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string_view>
#include <thread>
#include <vector>

#include "palpa/device/open_device.h"
#include "palpa/loop/loop.h"
#include "run_arguments.h"
#include "tests/devices/inverse3_rig.h"

namespace {

using namespace palpa;
using Clock = std::chrono::steady_clock;
using std::chrono::microseconds;

double now_s() { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); }

void measure_round_trips(Device& device) {
  constexpr int trips = 10'000;
  std::vector<double> times_us;
  auto next = Clock::now();
  for (int n = 0; n < trips; ++n) {
    const double begin_s = now_s();
    device.write({1e-3 * (n % 100), 0, 0});
    while (device.read().time_s < begin_s && now_s() < begin_s + 0.1) std::this_thread::yield();
    times_us.push_back(1e6 * (now_s() - begin_s));
    std::this_thread::sleep_until(next += microseconds(1000));
  }
  std::sort(times_us.begin(), times_us.end());
  const auto at = [&](double share) { return times_us[static_cast<std::size_t>(share * (trips - 1))]; };
  std::printf("round trip of %d: p50 %.0f us, p99 %.0f us, p99.9 %.0f us, max %.0f us\n", trips, at(0.5), at(0.99), at(0.999),
              at(1.0));
}

void feel(Device& device, test::Inverse3StandIn& service, const PreparedRun& prepared) {
  LiveScene scene(prepared.loaded.scene);
  LiveOptions options{.duration_s = 60.0};
  options.guard = guard_options_for(device.limits(), prepared.loaded.scene.coupling().max_force_n);
  LiveLoop loop(scene, device, options);
  std::atomic<bool> stop{false}, ended{false};
  long felt = 0, faults = 0;
  std::thread haptic([&] {
    const RealTimeThread real_time;
    loop.run(stop, [&](const TickFrame& frame, const Session&) {
      felt += norm(frame.command.force_n) > 1e-3;
      faults += (frame.circumstances & bit_of(Circumstance::device_fault)) != 0;
    });
    ended = true;
  });
  const double begin_s = now_s();
  while (!ended) {
    service.hold(test::service_from_hand(prepared.target->at(now_s() - begin_s).position_m), {});
    std::this_thread::sleep_for(microseconds(900));
  }
  haptic.join();
  const LoopStatistics statistics = loop.statistics();
  std::printf("felt at 1 kHz: %lld ticks, %lld missed, %ld with a fault of the device, %ld with a force\n",
              static_cast<long long>(statistics.ticks), static_cast<long long>(statistics.missed), faults, felt);
  std::printf("  late p50 %.0f us, p99 %.0f us, max %.0f us; tick p50 %.1f us, p99 %.1f us, max %.1f us\n",
              statistics.late.p50_us, statistics.late.p99_us, statistics.late.max_us, statistics.tick.p50_us,
              statistics.tick.p99_us, statistics.tick.max_us);
  std::printf("  the service answered %lld messages\n", static_cast<long long>(service.messages()));
}

void measure(const RunOptions& options) {
  const PreparedRun prepared = prepare(options);
  test::Inverse3StandIn service;
  const auto device = device_backend("inverse3").open({{"port", std::to_string(service.port())}});
  measure_round_trips(*device);
  feel(*device, service, prepared);
}

void stand_in(const RunOptions& options) {
  const PreparedRun prepared = prepare(options);
  test::Inverse3StandIn service;
  std::printf("%u\n", unsigned{service.port()});
  std::fflush(stdout);
  for (const double begin_s = now_s(); now_s() < begin_s + 70.0;) {
    service.hold(test::service_from_hand(prepared.target->at(now_s() - begin_s).position_m), {});
    std::this_thread::sleep_for(microseconds(900));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "stand-in")
    return run_with_arguments(argc - 1, argv + 1, "bench_inverse3", stand_in);
  return run_with_arguments(argc, argv, "bench_inverse3", measure);
}
