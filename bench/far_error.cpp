// Error of the force of a far hand beside the undelayed session on the same path, by link.
//
//   bench_far SCENE HAND [SECONDS [LINK…]]
//
// LINK is as of `palpa run --link`, each way; with `outage_ms=50,` before it nothing passes for so long in each second. The
// hand is rigid. Left out: delays from 0 to 100 ms.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/device/hand.h"
#include "palpa/scene/load_scene.h"
#include "palpa/serve/linked_hand.h"

using namespace palpa;

namespace {

constexpr double dt_s = 1e-3;
constexpr std::size_t settling_ticks = 500;  // before the first that counts

struct FarErrors {
  double rms_n = 0.0, p99_n = 0.0, largest_n = 0.0;
  double place_p99_m = 0.0;  // of the proxy
  double bytes_per_s = 0.0, models_per_s = 0.0;
  double least_account_j = 1.0, link_j = 0.0;
};

double of_share(std::vector<double> values, double share) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

FarErrors errors_of(const Scene& scene, const std::vector<Vec3>& hand_m, const LinkOptions& link, double outage_s) {
  Session undelayed(scene);
  LinkedHand linked(scene, link);
  const double most_n = scene.coupling().max_force_n;
  const auto cut = [&](const Vec3& force_n) { return std::min(1.0, most_n / std::max(1e-9, norm(force_n))) * force_n; };
  std::vector<double> errors_n, places_m;
  FarErrors errors;
  double sum_n2 = 0.0;
  for (std::size_t n = 0; n < hand_m.size(); ++n) {
    linked.is_up = static_cast<double>(n % 1000) * dt_s >= outage_s || n < settling_ticks;
    const Tick there = undelayed.tick({.position_m = hand_m[n]}, dt_s);
    const HandTick here = linked.tick({.position_m = hand_m[n]}, dt_s);
    if (n < settling_ticks) continue;
    errors_n.push_back(norm(cut(here.force_n) - cut(there.force_n)));
    sum_n2 += errors_n.back() * errors_n.back();
    places_m.push_back(distance(here.proxy_m, there.proxy_m));
    errors.least_account_j = std::min(errors.least_account_j, here.account_j);
    errors.link_j += here.link_j;
  }
  errors.rms_n = std::sqrt(sum_n2 / static_cast<double>(errors_n.size()));
  errors.p99_n = of_share(errors_n, 0.99);
  errors.largest_n = of_share(errors_n, 1.0);
  errors.place_p99_m = of_share(places_m, 0.99);
  const DataSideFacts& facts = linked.data.facts();
  errors.bytes_per_s = static_cast<double>(facts.bytes) / linked.now_s;
  errors.models_per_s = static_cast<double>(facts.models) / linked.now_s;
  return errors;
}

std::vector<Vec3> positions_m(const char* hand, double seconds) {
  const auto device = open_hand(hand, Hold::rigid);
  std::vector<Vec3> all_m;
  for (double t_s = 0.0; t_s < std::min(seconds, device->duration_s()); t_s += dt_s) {
    all_m.push_back(device->read().position_m);
    device->write({});
    device->advance(dt_s);
  }
  return all_m;
}

// Takes `outage_ms=N,` off the beginning of a link's description.
double outage_s_of(std::string& link) {
  constexpr std::string_view key = "outage_ms=";
  if (!link.starts_with(key)) return 0.0;
  double outage_ms = 0.0;
  const char* const end = std::from_chars(link.data() + key.size(), link.data() + link.size(), outage_ms).ptr;
  link.erase(0, static_cast<std::size_t>(end - link.data()) + (end < link.data() + link.size()));
  return 1e-3 * outage_ms;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return std::fputs("usage: bench_far SCENE HAND [SECONDS [LINK…]]\n", stderr), 2;
  try {
    const Scene scene = load_scene(argv[1]).scene;
    const std::vector<Vec3> hand_m = positions_m(argv[2], argc > 3 ? std::atof(argv[3]) : 20.0);
    std::vector<std::string> links(argv + std::min(argc, 4), argv + argc);
    if (links.empty())
      for (const char* delay_ms : {"0", "1", "2", "5", "10", "20", "50", "100"})
        links.push_back(std::string("delay_ms=") + delay_ms);
    std::puts(
        "| link | error RMS / N | p99 / N | largest / N | proxy p99 / mm | models/s | kB/s | least account / mJ | link / mJ |");
    std::puts("|---|---|---|---|---|---|---|---|---|");
    for (const std::string& name : links) {
      std::string link = name;
      const double outage_s = outage_s_of(link);
      const FarErrors e = errors_of(scene, hand_m, link_options(link), outage_s);
      std::printf("| %s | %.4f | %.3f | %.2f | %.3f | %.0f | %.1f | %.2f | %.2f |\n", name.c_str(), e.rms_n, e.p99_n,
                  e.largest_n, 1e3 * e.place_p99_m, e.models_per_s, 1e-3 * e.bytes_per_s, 1e3 * e.least_account_j,
                  1e3 * e.link_j);
    }
    return 0;
  } catch (const LoadError& error) {
    std::fprintf(stderr, "bench_far: %s\n", error.what());
    return 2;
  }
}
