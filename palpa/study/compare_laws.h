// Compares laws of earlier systems with the exact one, on the same data under the same hand.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "palpa/session/session.h"
#include "palpa/study/run.h"

namespace palpa {

/// Percentiles of numbers of one kind.
struct Spread {
  double p50 = 0.0;  ///< [unit of the member's name]
  double p99 = 0.0;  ///< [unit of the member's name]
  double max = 0.0;  ///< [unit of the member's name]
};

/// One law against the exact one.
struct LawErrors {
  std::string law;
  /// For the very same balances (primitives, start, probe, k, T): the distance of its answer from the exact one, and k times
  /// that, the error of the force on the hand.
  Spread posed_m;
  Spread posed_n;
  /// When it feels the scene by itself under the same probes: the distance of its proxy from the exact law's, tick by tick, and
  /// the difference of the two forces of Eq. 1.
  Spread alone_m;
  Spread alone_n;
  double alone_mean_n = 0.0;
  std::vector<double> posed_errors_m;  ///< ascending, one for each balance
  std::vector<double> alone_errors_n;  ///< ascending, one for each tick
};

struct LawComparison {
  std::int64_t ticks = 0;     ///< with a valid probe
  std::int64_t balances = 0;  ///< posed: sub-steps with at least one primitive
  std::int64_t left_out = 0;  ///< sub-steps whose exact balance is not proven to 1e-9 m, or holds planes of a hollow that
                              ///< the tick keeps and no earlier law knows
  std::int64_t oblique_balances = 0;  ///< of `balances`, with planes or lines that are not orthogonal to each other
  std::vector<LawErrors> laws;
};

/// True when two of these are planes or lines whose spans are not orthogonal to each other: no one frame has
/// axes for both. A directed force has no span, and a point is the same in every frame.
bool has_oblique_primitives(std::span<const PlacedPrimitive> placed) noexcept;

/// Feels `scene`, its levels rigid as those of earlier systems were, with the exact law under `probes`, one tick of
/// `time_step_s` [s] each; poses every sub-step's balance to each of `laws` as well; then lets each of them feel the scene by
/// itself. The law that the scene names is ignored. Throws SceneError on a scene that cannot be felt or an unknown law.
LawComparison compare_laws(const Scene& scene, std::span<const Probe> probes, double time_step_s,
                           std::span<const std::string> laws);

/// The same with the scene, hand, rate and duration that a run would have, under the probes that the exact law
/// is felt with. Records nothing. Throws LoadError.
LawComparison compare_laws(RunOptions options, std::span<const std::string> laws);

/// The comparison as two Markdown tables, in mm and N.
std::string to_markdown(const LawComparison& comparison);

}  // namespace palpa
