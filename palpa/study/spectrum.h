// How strong a signal is at which frequencies: whether fingers feel it as rough depends on these.
#pragma once

#include <span>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa {

/// The band in which skin feels vibration: below it, motion is felt; above 500 Hz little is felt, and a loop of 1 kHz cannot
/// make more. Other limits: bands of reports no longer compare with earlier ones, nor with what skin feels. (The Pacinian
/// channel answers from 40 to 500 Hz, best at 250; Meissner's from 10 to 60: Johansson and Flanagan 2009.)
inline constexpr double tactile_low_hz = 20.0;
inline constexpr double tactile_high_hz = 500.0;
/// Above this a hand at 5 cm/s on smooth data makes nothing: what is there is noise of the rendering. Lower: motion counts as
/// noise; higher: noise is missed.
inline constexpr double rough_low_hz = 100.0;

/// The power of a signal of vectors over frequency, the sum of its three components' powers, one-sided.
struct Spectrum {
  double step_hz = 0.0;              ///< between neighbouring frequencies; 0: the signal was too short for any
  std::vector<double> power_per_hz;  ///< [unit²/Hz] with the signal's own unit; of the frequencies i · `step_hz`

  /// Root mean square of what lies in a band [Hz], in the signal's own unit; 0 where nothing was measured.
  double band_rms(double low_hz, double high_hz) const noexcept;
};

/// Welch's estimate (1967): windows of about a quarter of a second that overlap by half, each without its straight line,
/// weighed by Hann's window; over all stretches together. The sum over all frequencies is the signal's mean square (Parseval).
/// \param stretches  in the signal's own unit; there are gaps between them, and those shorter than a window are left out
/// \param rate_hz    [Hz] > 0: samples per second
Spectrum spectrum_of(std::span<const std::vector<Vec3>> stretches, double rate_hz);
/// The same of one stretch.
/// \param signal  in its own unit
Spectrum spectrum_of(const std::vector<Vec3>& signal, double rate_hz);

}  // namespace palpa
