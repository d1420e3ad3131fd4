// Force signal on the hand: roughness, and steps not caused by the hand's motion.
#pragma once

#include <string>
#include <vector>

#include "palpa/report/recorded.h"
#include "palpa/study/felt.h"
#include "palpa/study/spectrum.h"
#include "palpa/view/plot.h"

namespace palpa::detail {

/// Amplitude spectrum as a curve: square root of the power, so that values are forces.
Series amplitudes(const Spectrum& spectrum, std::string name, CurveColor color, Stroke stroke);
/// Amplitude spectra, with the limits of the tactile band.
Plot spectrum_plot(std::string title, std::vector<Series> curves);

/// The trace as a run; its stiffness is computed from recorded energy and distance of probe and proxy: 0 without recorded
/// energy or contact.
FeltRun felt_run_of(const Recorded& recorded);

/// Measurements of a trace's force signal.
struct Signal {
  double rate_hz = 0.0;
  FeltRun run;
  Spectrum command, spring;        ///< [N] in contact and away from events: force on the hand, and k · probe
  std::vector<ExcessStep> steps;   ///< all perceptible steps
  double at_edges_n_per_ms = 0.0;  ///< below 0: no data
};
/// \param scene  nullptr: no data
Signal signal_of(const Recorded& recorded, const Scene* scene);

/// Bands, saturation, falls and ends of data.
std::string signal_markup(const Signal& signal);
/// Number and maximum of the steps by cause, if any.
std::string steps_markup(const Signal& signal);

}  // namespace palpa::detail
