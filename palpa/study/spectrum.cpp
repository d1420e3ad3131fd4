#include "palpa/study/spectrum.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace palpa {
namespace {

using Complex = std::complex<double>;

// Approximate length of a window. Longer: finer frequencies but fewer windows, so less certain powers; shorter: tactile bands
// blur.
constexpr double window_s = 0.25;

/// Power of two nearest to a window's samples.
std::size_t window_samples(double rate_hz) {
  std::size_t samples = 16;
  while (static_cast<double>(samples) * std::numbers::sqrt2 < window_s * rate_hz) samples *= 2;
  return samples;
}

/// Cooley and Tukey's transform in place, of a power of two of values.
void transform(std::vector<Complex>& values) {
  const std::size_t count = values.size();
  for (std::size_t i = 1, j = 0; i < count; ++i) {
    std::size_t bit = count >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(values[i], values[j]);
  }
  for (std::size_t length = 2; length <= count; length *= 2) {
    const Complex turn = std::polar(1.0, -2.0 * std::numbers::pi / static_cast<double>(length));
    for (std::size_t begin = 0; begin < count; begin += length) {
      Complex factor = 1.0;
      for (std::size_t k = begin; k < begin + length / 2; ++k, factor *= turn) {
        const Complex even = values[k], odd = factor * values[k + length / 2];
        values[k] = even + odd;
        values[k + length / 2] = even - odd;
      }
    }
  }
}

/// Detrended (least squares) and weighted window.
std::vector<Complex> weighed(std::span<const Vec3> window, double Vec3::*component, const std::vector<double>& weights) {
  const double count = static_cast<double>(window.size()), middle = 0.5 * (count - 1.0);
  double mean = 0.0, along = 0.0, length = 0.0;
  for (std::size_t i = 0; i < window.size(); ++i) {
    const double t = static_cast<double>(i) - middle;
    mean += window[i].*component / count;
    along += t * (window[i].*component);
    length += t * t;
  }
  std::vector<Complex> values(window.size());
  for (std::size_t i = 0; i < window.size(); ++i) {
    const double line = mean + along / length * (static_cast<double>(i) - middle);
    values[i] = weights[i] * (window[i].*component - line);
  }
  return values;
}

}  // namespace

double Spectrum::band_rms(double low_hz, double high_hz) const noexcept {
  double square = 0.0;
  for (std::size_t i = 0; i < power_per_hz.size(); ++i) {
    const double middle_hz = static_cast<double>(i) * step_hz;
    const double from_hz = std::max(low_hz, middle_hz - 0.5 * step_hz), to_hz = std::min(high_hz, middle_hz + 0.5 * step_hz);
    if (to_hz > from_hz) square += power_per_hz[i] * (to_hz - from_hz);
  }
  return std::sqrt(square);
}

Spectrum spectrum_of(std::span<const std::vector<Vec3>> segments, double rate_hz) {
  const std::size_t samples = window_samples(rate_hz);
  std::vector<double> weights(samples);
  double weights_squared = 0.0;
  for (std::size_t i = 0; i < samples; ++i) {
    weights[i] = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(samples));
    weights_squared += weights[i] * weights[i];
  }
  std::vector<double> sums(samples / 2 + 1);
  int windows = 0;
  for (const std::vector<Vec3>& segment : segments) {
    for (std::size_t begin = 0; begin + samples <= segment.size(); begin += samples / 2, ++windows) {
      for (double Vec3::*component : {&Vec3::x, &Vec3::y, &Vec3::z}) {
        std::vector<Complex> values = weighed(std::span(segment).subspan(begin, samples), component, weights);
        transform(values);
        for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += std::norm(values[i]);
      }
    }
  }
  if (windows == 0) return {};
  Spectrum spectrum{.step_hz = rate_hz / static_cast<double>(samples), .power_per_hz = std::move(sums)};
  for (std::size_t i = 0; i < spectrum.power_per_hz.size(); ++i) {
    const double sides = i == 0 || i == samples / 2 ? 1.0 : 2.0;  // negative frequencies fold onto positive ones
    spectrum.power_per_hz[i] *= sides / (rate_hz * weights_squared * windows);
  }
  return spectrum;
}

Spectrum spectrum_of(const std::vector<Vec3>& signal, double rate_hz) { return spectrum_of(std::span(&signal, 1), rate_hz); }

}  // namespace palpa
