// The signal that the hand got: how rough it is, and which of its steps are not the hand's own.
#pragma once

#include <string>
#include <vector>

#include "palpa/report/recorded.h"
#include "palpa/study/felt.h"
#include "palpa/study/spectrum.h"
#include "palpa/view/plot.h"

namespace palpa::detail {

/// A spectrum as a curve: the root of the power, so that heights are forces.
Series amplitudes(const Spectrum& spectrum, std::string name, CurveColor color, Stroke stroke);
/// Such curves, with the limits of the tactile band.
Plot spectrum_plot(std::string title, std::vector<Series> curves);

/// The trace as a run; its stiffness from the energy that was recorded with each distance of probe and proxy, so 0 in a trace
/// that does not tell energy, or that never was in contact.
FeltRun felt_run_of(const Recorded& recorded);

/// A trace's signal, measured.
struct Signal {
  double rate_hz = 0.0;
  FeltRun run;
  Spectrum command, spring;        ///< [N] in contact and away from events: what reached the hand, and k · probe
  std::vector<ExcessStep> steps;   ///< all that are felt as such
  double at_edges_n_per_ms = 0.0;  ///< below 0: data not available
};
/// \param scene  nullptr: its data are not there
Signal signal_of(const Recorded& recorded, const Scene* scene);

/// Bands, saturation, falls and ends of data.
std::string signal_markup(const Signal& signal);
/// How many steps each cause made, and the largest of them, as far as there are some.
std::string steps_markup(const Signal& signal);

}  // namespace palpa::detail
