// Power spectra of signals, for the roughness that fingers feel.
#pragma once

#include <span>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa {

/// Band of vibration felt by skin: below it, motion is felt; above 500 Hz little is felt, and a loop of 1 kHz cannot produce
/// more. Other limits: bands of reports no longer compare with earlier ones, nor with skin. (The Pacinian channel responds from
/// 40 to 500 Hz, best at 250; Meissner's from 10 to 60: Johansson and Flanagan 2009.)
inline constexpr double tactile_low_hz = 20.0;
inline constexpr double tactile_high_hz = 500.0;
/// Above this a hand at 5 cm/s on smooth data produces nothing: power there is noise of the rendering. Lower: motion counts as
/// noise; higher: noise is missed.
inline constexpr double rough_low_hz = 100.0;

/// Power of a vector signal over frequency, the sum over its three components, one-sided.
struct Spectrum {
  double step_hz = 0.0;              ///< between neighbouring frequencies; 0: the signal was too short
  std::vector<double> power_per_hz;  ///< [unit²/Hz] with the signal's own unit; at the frequencies i · `step_hz`

  /// Root mean square in a band [Hz], in the signal's own unit; 0 without data.
  double band_rms(double low_hz, double high_hz) const noexcept;
};

/// Welch's estimate (1967): windows of about a quarter of a second that overlap by half, each detrended and weighted by Hann's
/// window; over all intervals together. The sum over all frequencies is the signal's mean square (Parseval).
/// \param segments  in the signal's own unit; with gaps between them; those shorter than a window are ignored
/// \param rate_hz    [Hz] > 0: samples per second
Spectrum spectrum_of(std::span<const std::vector<Vec3>> segments, double rate_hz);
/// Spectrum of one interval.
/// \param signal  in its own unit
Spectrum spectrum_of(const std::vector<Vec3>& signal, double rate_hz);

}  // namespace palpa
