// Comparison of earlier systems' laws with the exact law, on equal data and hands.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "palpa/session/session.h"
#include "palpa/study/run.h"

namespace palpa {

struct Spread {
  double p50 = 0.0;  ///< [unit of the member's name]
  double p99 = 0.0;  ///< [unit of the member's name]
  double max = 0.0;  ///< [unit of the member's name]
};

/// A law against the exact one.
struct LawErrors {
  std::string law;
  /// For identical balances (primitives, start, probe, k, T): the distance of its proxy from the exact one, and k times that,
  /// the error of the force on the hand.
  Spread posed_m;
  Spread posed_n;
  /// In a session of its own under equal probes: the distance of its proxy from the exact law's, tick by tick, and the
  /// difference of the two forces of Eq. 1.
  Spread alone_m;
  Spread alone_n;
  double alone_mean_n = 0.0;
  std::vector<double> posed_errors_m;  ///< ascending, one per balance
  std::vector<double> alone_errors_n;  ///< ascending, one per tick
};

struct LawComparison {
  std::int64_t ticks = 0;     ///< with a valid probe
  std::int64_t balances = 0;  ///< posed: sub-steps with at least one primitive
  std::int64_t left_out = 0;  ///< sub-steps whose exact balance is not proven to 1e-9 m, or includes a hollow's planes that the
                              ///< tick keeps and no earlier law has
  std::int64_t oblique_balances = 0;  ///< of `balances`, with planes or lines not orthogonal to each other
  std::vector<LawErrors> laws;
};

/// Whether two of these are planes or lines with spans not orthogonal to each other: no frame has axes for both. A directed
/// force has no span; a point is equal in every frame.
bool has_oblique_primitives(std::span<const PlacedPrimitive> placed) noexcept;

/// Runs `scene` with rigid levels, as in earlier systems, with the exact law under `probes`, a tick of `time_step_s` [s] each;
/// solves every sub-step's balance by each of `laws` as well; then runs a session of each. The law that the scene names is
/// ignored. Throws SceneError on a scene that cannot be felt or an unknown law.
LawComparison compare_laws(const Scene& scene, std::span<const Probe> probes, double time_step_s,
                           std::span<const std::string> laws);

/// Compares with the scene, hand, rate and duration of a run, under the probes of the exact law. Records nothing. Throws
/// LoadError.
LawComparison compare_laws(RunOptions options, std::span<const std::string> laws);

/// Formats the comparison as two Markdown tables, in mm and N.
std::string to_markdown(const LawComparison& comparison);

}  // namespace palpa
