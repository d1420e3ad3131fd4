// Spectrum: shares of a signal's mean square.
#include "palpa/study/spectrum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace palpa {
namespace spectrum_test {

std::vector<Vec3> sine(double frequency_hz, const Vec3& amplitude, double rate_hz, double duration_s) {
  std::vector<Vec3> signal;
  for (int i = 0; i < static_cast<int>(duration_s * rate_hz); ++i)
    signal.push_back(std::sin(2.0 * std::numbers::pi * frequency_hz * i / rate_hz + 0.3) * amplitude);
  return signal;
}

TEST(Spectrum, AddsUpToTheMeanSquareOfNoise) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0.0, 0.7);
  std::vector<Vec3> signal;
  for (int i = 0; i < 200'000; ++i) signal.push_back({normal(random), normal(random), normal(random)});
  EXPECT_NEAR(spectrum_of(signal, 1000.0).band_rms(0.0, 1000.0), 0.7 * std::sqrt(3.0), 0.01);
  // White: a tenth of the frequencies have a tenth of the power.
  EXPECT_NEAR(spectrum_of(signal, 1000.0).band_rms(100.0, 150.0), 0.7 * std::sqrt(0.3), 0.01);
}

TEST(Spectrum, HasASineInItsBandAndNowhereElse) {
  for (const double frequency_hz : {23.0, 46.3, 100.0, 251.7}) {
    const Spectrum spectrum = spectrum_of(sine(frequency_hz, {0.3, 0.0, 0.4}, 1000.0, 3.0), 1000.0);
    EXPECT_NEAR(spectrum.band_rms(frequency_hz - 8.0, frequency_hz + 8.0), 0.5 / std::numbers::sqrt2, 1e-3) << frequency_hz;
    EXPECT_LT(spectrum.band_rms(frequency_hz + 20.0, 500.0), 1e-3) << frequency_hz;
    // The removed linear trend lies below 6 Hz.
    EXPECT_LT(spectrum.band_rms(6.0, frequency_hz - 18.0), 2e-3) << frequency_hz;
  }
}

TEST(Spectrum, GoesByTheRate) {
  const Spectrum slow = spectrum_of(sine(50.0, {1, 0, 0}, 1000.0, 2.0), 1000.0);
  const Spectrum fast = spectrum_of(sine(50.0, {1, 0, 0}, 4000.0, 2.0), 4000.0);
  EXPECT_NEAR(slow.band_rms(40.0, 60.0), fast.band_rms(40.0, 60.0), 1e-3);
}

TEST(Spectrum, ScalesWithTheSignalAndDoesNotSeeWhereItStands) {
  std::vector<Vec3> signal = sine(80.0, {0.01, 0.02, 0.03}, 1000.0, 2.0);
  const double before = spectrum_of(signal, 1000.0).band_rms(20.0, 500.0);
  for (std::size_t i = 0; i < signal.size(); ++i) signal[i] = -8.0 * signal[i] + Vec3{5.0, 1e-3 * static_cast<double>(i), 0.0};
  EXPECT_NEAR(spectrum_of(signal, 1000.0).band_rms(20.0, 500.0), 8.0 * before, 1e-9);
}

TEST(Spectrum, LeavesNothingOfASlowStrokeAboveTwentyHertz) {
  EXPECT_LT(spectrum_of(sine(1.0, {2.0, 0, 0}, 1000.0, 3.0), 1000.0).band_rms(20.0, 500.0), 1e-3);
}

TEST(Spectrum, OfStretchesIsThatOfEachAndNotOfTheJumpBetween) {
  const std::vector<Vec3> low(2000, Vec3{1, 0, 0}), high(2000, Vec3{7, 0, 0});
  EXPECT_LT(spectrum_of(std::vector{low, high}, 1000.0).band_rms(0.0, 500.0), 1e-12);
}

TEST(Spectrum, OfWhatIsTooShortIsEmpty) {
  const Spectrum spectrum = spectrum_of(sine(80.0, {1, 0, 0}, 1000.0, 0.1), 1000.0);
  EXPECT_EQ(spectrum.step_hz, 0.0);
  EXPECT_EQ(spectrum.band_rms(0.0, 500.0), 0.0);
  EXPECT_EQ(spectrum_of(std::vector<Vec3>{}, 1000.0).band_rms(0.0, 500.0), 0.0);
}

}  // namespace spectrum_test
}  // namespace palpa
