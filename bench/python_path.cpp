// The path of python_costs.py in C++: prints the time of a tick [us].
//
//   bench_python_path TICKS
#include <palpa/palpa.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

int main(int count, char** arguments) {
  const std::size_t n = count > 1 ? std::strtoul(arguments[1], nullptr, 10) : 200000;
  palpa::Scene scene({.stiffness_n_per_m = 400});
  const auto head = scene.add("head", palpa::head_phantom());
  scene.add("skin",
            palpa::SurfaceAndFriction{.field = head, .levels = {{.value = -300, .strength_n = 0.8, .friction_n = 0.1}}});
  std::vector<palpa::Vec3> path_m;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) * 1e-3;
    path_m.push_back({0.03 * std::sin(t), 0.02 * std::cos(0.7 * t), 0.075 + 0.015 * std::sin(2 * t)});
  }
  std::vector<palpa::Tick> ticks(n);
  palpa::Session session(scene);
  const std::clock_t begin = std::clock();  // processor time, independent of other load
  for (std::size_t i = 0; i < n; ++i) ticks[i] = session.tick({.position_m = path_m[i]}, 1e-3);
  const double took_us = 1e6 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  std::printf("%.4f\n", took_us / static_cast<double>(n));
}
