// What deriving costs: time and memory of Q, lambda2 and curl at load, and of a sample in a tick.
//
//   bench_derived [N]     N³ voxels of float velocity (256)
#include "palpa/data/derived.h"

#include <palpa/palpa.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>

#include "palpa/data/grid.h"

namespace {

using namespace palpa;

/// A line of /proc/self/status in bytes.
double status_bytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(key + ":")) return 1024.0 * std::atof(line.c_str() + key.size() + 1);
  }
  return 0.0;
}

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Vortices of many sizes: u = (sin z + cos y, sin x + cos z, sin y + cos x), in several wavelengths.
FieldPtr velocity(int n) {
  const std::int64_t voxels = std::int64_t{n} * n * n;
  const std::shared_ptr<float[]> data(new float[static_cast<std::size_t>(3 * voxels)]);
  float* out = data.get();
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const float x = 0.2F * static_cast<float>(i), y = 0.13F * static_cast<float>(j), z = 0.17F * static_cast<float>(k);
        *out++ = std::sin(z) + std::cos(y);
        *out++ = std::sin(x) + std::cos(z);
        *out++ = std::sin(y) + std::cos(x);
      }
    }
  }
  return grid_field({{n, n, n}, 1e-3 * Mat3::identity(), {}}, {VoxelType::float32, 3, data});
}

/// One sample [s] at places along a slow path: hot caches, as in a tick.
template <class Sample>
double sample_time_s(const Field& field, Sample sample) {
  const Vec3 centre = field.bounds_m().centre_m();
  const double step = 0.01 * field.spacing_m();
  constexpr int count = 1'000'000;
  double best = 1.0, sum = 0.0;
  for (int repeat = 0; repeat < 3; ++repeat) {
    const double start = seconds();
    for (int i = 0; i < count; ++i) sum += sample(centre + Vec3{step * (i % 997), step * (i % 311), step * (i % 173)});
    best = std::min(best, (seconds() - start) / count);
  }
  if (!std::isfinite(sum)) std::puts("a sample was not finite");
  return best;
}

}  // namespace

int main(int argc, char** argv) {
  const int n = argc > 1 ? std::atoi(argv[1]) : 256;
  if (n < 8 || n > 1024) {
    std::fputs("bench_derived: the number of voxels along a side is 8 to 1024\n", stderr);
    return 2;
  }
  const FieldPtr source = velocity(n);
  const double field_bytes = 3.0 * sizeof(float) * n * n * n;
  std::printf("%d³ voxels of float velocity, %.0f MB\n", n, field_bytes / 1e6);
  std::printf("%-20s %10s %18s\n", "derived", "time [s]", "peak / field [1]");
  FieldPtr q;
  for (const Derivation derivation : {Derivation::q, Derivation::lambda2, Derivation::curl}) {
    std::ofstream("/proc/self/clear_refs") << 5;  // the high-water mark starts again here
    const double before = status_bytes("VmRSS");
    const double start = seconds();
    const FieldPtr field = derived(derivation, source);
    const double took_s = seconds() - start;
    std::printf("%-20s %10.2f %18.2f\n", name_of(derivation), took_s, (status_bytes("VmHWM") - before) / field_bytes);
    if (derivation == Derivation::q) q = field;
  }
  const FieldPtr magnitude = derived(Derivation::magnitude, source);
  std::printf("%-40s %6.0f ns\n", "sample of q, value and gradient",
              1e9 * sample_time_s(*q, [&](const Vec3& x) noexcept { return q->scalar(x).gradient.x; }));
  std::printf("%-40s %6.0f ns\n", "Hessian of q",
              1e9 * sample_time_s(*q, [&](const Vec3& x) noexcept { return q->hessian(x).row[0].x; }));
  std::printf("%-40s %6.0f ns\n", "sample of magnitude, value and gradient",
              1e9 * sample_time_s(*magnitude, [&](const Vec3& x) noexcept { return magnitude->scalar(x).gradient.x; }));
  return 0;
}
