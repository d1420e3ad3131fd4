// The explorer's window: time of a picture for each view, start time, and cost for the haptic loop.
//
//   bench_explorer [FRAMES] [SECONDS]    on a display of its own, at 800 x 600 pixels of the view
#include <QElapsedTimer>
#include <QOpenGLContext>
#include <QOpenGLFunctions>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <vector>

#include "driver.h"
#include "explorer/presets.h"
#include "tests/shared_data.h"

namespace palpa::explorer {
namespace {

struct Times {
  double p50_ms, p95_ms;
};
Times times_of(std::vector<double> ms) {
  std::sort(ms.begin(), ms.end());
  return {ms[ms.size() / 2], ms[ms.size() * 95 / 100]};
}

double picture_ms(View3D& view, double turn_deg) {
  QElapsedTimer timer;
  timer.start();
  turn_deg == 0.0 ? view.show_all() : view.turn(turn_deg, 0.0);
  view.repaint();
  view.makeCurrent();
  QOpenGLContext::currentContext()->functions()->glFinish();
  view.doneCurrent();
  return 1e-6 * static_cast<double>(timer.nsecsElapsed());
}

void frames(Driver& driver, const char* what, int count) {
  View3D& view = driver.view();
  std::vector<double> turning, resting;
  const std::clock_t before = std::clock();
  for (int i = 0; i < count; ++i) turning.push_back(picture_ms(view, 3.0));
  const double work_ms = 1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC / count;
  Driver::live(800);
  for (int i = 0; i < std::max(5, count / 4); ++i) resting.push_back(picture_ms(view, 0.0));
  const Times moves = times_of(turning), rests = times_of(resting);
  std::printf(
      "%-34s turning p50 %6.1f p95 %6.1f ms (%4.0f/s), of all cores %6.1f ms   at rest p50 %6.1f p95 %6.1f ms   %zu and %zu "
      "triangles\n",
      what, moves.p50_ms, moves.p95_ms, 1e3 / moves.p50_ms, work_ms, rests.p50_ms, rests.p95_ms,
      view.drawing().coarse_triangles, view.drawing().fine_triangles);
  std::fflush(stdout);
}

/// The embedded head with this many samples along its longest side.
std::filesystem::path head_of(int samples) {
  std::ifstream in(embedded("head_phantom.toml"));
  std::string text(std::istreambuf_iterator<char>(in), {});
  const std::string key = "sampled = ";
  const std::size_t at = text.find(key) + key.size();
  text.replace(at, text.find_first_not_of("0123456789", at) - at, std::to_string(samples));
  const std::filesystem::path file = fresh_folder("bench") / ("head_" + std::to_string(samples) + ".toml");
  std::ofstream(file) << text;
  return file;
}

int run(int count, int leg_s) {
  QElapsedTimer start;
  start.start();
  Driver driver;
  const std::filesystem::path real = test::shared_data_folder() / "ct_head_cranium/cranium.mhd";
  const bool has_real = std::filesystem::exists(real);
  if (!driver.open(has_real ? embedded("head.toml") : embedded("head_phantom.toml"))) {
    std::fprintf(stderr, "the first scene does not open; is palpa-read built beside this program, or PALPA_BIN its folder?\n");
    return 1;
  }
  picture_ms(driver.view(), 0.0);
  std::printf("start to first picture of %s: %.2f s\n", has_real ? "the CT head" : "the embedded head",
              1e-3 * static_cast<double>(start.elapsed()));
  driver.view().setFixedSize(800, 600);
  Driver::live(300);
  std::printf("view of %d x %d pixels\n", driver.view().width(), driver.view().height());
  if (has_real) frames(driver, "CT head, two surfaces", count);
  for (const int samples : {128, 256}) {
    driver.open(head_of(samples));
    Driver::live(300);
    frames(driver, (std::to_string(samples) + "^3, two surfaces").c_str(), count);
    driver.window().document().edit("preset", -1, [](Scene& scene) { scene.layers = apply(presets()[0], scene).layers; });
    Driver::wait_for([&] { return !driver.view().drawing().clouds.empty(); });
    Driver::live(1500);
    frames(driver, (std::to_string(samples) + "^3, cloud (CT: bone)").c_str(), std::max(5, count / 4));
    SliceView& slice = *driver.window().findChildren<SliceView*>().front();
    std::vector<double> ms;
    for (int i = 0; i < count; ++i) {
      QElapsedTimer timer;
      timer.start();
      slice.set_cross({0.0, 0.0, 1e-3 * (i % 40)});
      slice.set_cross({1e-3 * (i % 40), 1e-3 * (i % 40), 1e-3 * (i % 40)});
      slice.repaint();
      ms.push_back(1e-6 * static_cast<double>(timer.nsecsElapsed()));
    }
    std::printf("%-34s moving  p50 %6.1f p95 %6.1f ms\n", (std::to_string(samples) + "^3, a slice").c_str(),
                times_of(ms).p50_ms, times_of(ms).p95_ms);
  }

  std::printf("the loop at 1 kHz, in turn:      late p50, p99, max us; missed\n");
  for (int leg = 0; leg < 3; ++leg) {
    for (const bool busy : {false, true}) {
      driver.open(embedded("head_phantom.toml"));
      if (!busy) driver.window().hide();
      QElapsedTimer timer;
      timer.start();
      while (timer.elapsed() < 1000 * leg_s) {
        if (busy) picture_ms(driver.view(), 2.0);
        Driver::live(busy ? 1 : 30);
      }
      const LoopStatistics statistics = driver.window().touch().loop()->statistics();
      std::printf("  %-28s %6.0f %6.0f %6.0f  %lld of %lld\n", busy ? "window drawing without pause" : "window hidden",
                  statistics.late.p50_us, statistics.late.p99_us, statistics.late.max_us,
                  static_cast<long long>(statistics.missed), static_cast<long long>(statistics.ticks));
      std::fflush(stdout);
      driver.window().show();
    }
  }
  return 0;
}

}  // namespace
}  // namespace palpa::explorer

int main(int argc, char** argv) {
  return palpa::explorer::run(argc > 1 ? std::atoi(argv[1]) : 60, argc > 2 ? std::atoi(argv[2]) : 20);
}
