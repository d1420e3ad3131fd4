#include "palpa/study/trial.h"

#include <algorithm>

#include "palpa/loop/loop.h"
#include "palpa/session/session.h"
#include "palpa/study/feeler.h"

namespace palpa::detail {

Summary tried(const Scene& scene, std::shared_ptr<const Target> target, Hold hold, double longest_s) {
  const double duration_s = std::min(longest_s, target->duration_s());
  Session session(scene);
  feel_octave_of_search(session);
  SummaryBuilder builder(scene);
  const auto hand = hand_device(std::move(target), hold);
  run_simulated(session, *hand, {.duration_s = duration_s, .time_ticks = false}, nullptr,
                [&](const TickFrame& frame, const Session& felt) { builder.add(frame, felt); });
  return builder.finish(1.0);
}

double kinds_met(const Summary& summary) {
  const auto met = std::count_if(summary.modes.begin(), summary.modes.end(),
                                 [](const ModeSummary& mode) { return mode.contact_share > some_contact; });
  return static_cast<double>(met) / static_cast<double>(std::max<std::size_t>(1, summary.modes.size()));
}

namespace {

/// [1] Share of ticks in which the guard limits the force.
double limited_share(const Summary& summary) {
  return static_cast<double>(summary.guard_limited_ticks) / static_cast<double>(std::max<std::int64_t>(1, summary.ticks));
}

}  // namespace

bool is_often_limited(const Summary& summary) {
  // [1] Share of ticks in which the guard may limit the force. More: hands are placed where they push in vain; less: one hard
  // contact spoils a good place.
  constexpr double rarely = 0.002;
  return limited_share(summary) > rarely;
}

double worth_of(const Summary& summary) {
  return summary.contact_share + kinds_met(summary) - (is_often_limited(summary) ? 1.0 + limited_share(summary) : 0.0) -
         (summary.waiting_ticks > 0 ? 0.5 : 0.0);
}

}  // namespace palpa::detail
