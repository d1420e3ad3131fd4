#include "palpa/report/moments.h"

#include <algorithm>
#include <set>

#include "palpa/base/load_error.h"
#include "palpa/loop/loop.h"
#include "palpa/loop/window_feed.h"
#include "palpa/report/html.h"
#include "palpa/session/session.h"

namespace palpa::detail {

std::optional<std::size_t> busiest_row(const Recorded& recorded) {
  std::optional<std::size_t> best;
  std::pair<int, double> most{0, 0.0};
  for (std::size_t i = 0; i < recorded.ticks.size(); ++i) {
    int modes = 0;
    for (const auto& pushes : recorded.pushes) modes += norm(pushes[i].force_n) > contact_force_n;
    const std::pair<int, double> now{modes, norm(recorded.ticks[i].command.force_n)};
    if (modes > 0 && (!best || now > most)) {
      most = now;
      best = i;
    }
  }
  return best;
}

std::vector<std::size_t> rows_worth_a_look(const Recorded& recorded, std::size_t most) {
  const auto& ticks = recorded.ticks;
  if (ticks.empty() || most == 0) return {};
  std::set<std::size_t> rows;
  if (const auto busiest = busiest_row(recorded)) rows.insert(*busiest);
  for (const RecordedEvent& event : recorded.events) {
    if (rows.size() >= most / 2) break;
    const auto found = std::lower_bound(ticks.begin(), ticks.end(), event.tick,
                                        [](const TickFrame& frame, std::int64_t wanted) { return frame.tick < wanted; });
    if (found != ticks.end()) rows.insert(static_cast<std::size_t>(found - ticks.begin()));
  }
  const std::size_t left = most - std::min(most, rows.size());
  for (std::size_t i = 0; i < left; ++i) rows.insert(left == 1 ? 0 : i * (ticks.size() - 1) / (left - 1));
  return {rows.begin(), rows.end()};
}

std::vector<RecordedMoment> moments_at(const std::vector<std::size_t>& rows) {
  std::vector<RecordedMoment> moments(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) moments[i].row = rows[i];
  return moments;
}

void recall_primitives(const std::filesystem::path& trace, const Recorded& recorded, std::vector<RecordedMoment>& moments) {
  std::vector<std::int64_t> ticks;
  for (const RecordedMoment& moment : moments) ticks.push_back(recorded.ticks[moment.row].tick);
  std::vector<std::vector<PlacedPrimitive>> primitives = recorded_primitives(trace, recorded, ticks);
  for (std::size_t i = 0; i < moments.size(); ++i) moments[i].primitives = std::move(primitives[i]);
}

void feel_primitives_again(const std::filesystem::path& trace, const Recorded& recorded, const Scene& scene,
                           std::vector<RecordedMoment>& moments, const std::function<void(double)>& progress) {
  Session session(scene, recorded.header.device_encoder_step_m);
  session.set_force_limit(force_limit_n(scene, recorded.header.device_max_force_n));
  WindowFeed feed(session);
  std::vector<std::vector<PlacedPrimitive>> felt;
  std::size_t row = 0;
  for (const RecordedMoment& moment : moments) {
    Vec3 proxy_m;
    for (; row <= moment.row; ++row) {
      const Tick& was = recorded.ticks[row].result;
      const Probe probe{.position_m = was.probe_m,
                        .velocity_m_per_s = was.probe_velocity_m_per_s,
                        .valid = was.probe_valid,
                        .buttons = recorded.ticks[row].buttons,
                        .turn = was.probe_turn};
      proxy_m = feed.tick(probe, recorded.ticks[row].dt_s).proxy_m;
    }
    // Tolerance of the replayed proxy. More: another version's primitives are shown as recorded; less: rounding on another
    // machine is refused.
    constexpr double same_place_m = 1e-6;
    const double apart_m = distance(proxy_m, recorded.ticks[moment.row].result.proxy_m);
    if (!(apart_m <= same_place_m)) {
      throw LoadError(trace.string() + text(": in the replay the proxy is %.3g mm from the recorded one; ", 1e3 * apart_m) +
                      "record with --primitives, or use the palpa that recorded it");
    }
    auto& placed = felt.emplace_back();
    if (!session.sub_steps().empty()) {
      const SubStep& last = session.sub_steps().back();
      const auto all = session.primitives().subspan(last.first_primitive, last.primitives);
      placed.assign(all.begin(), all.end());
    }
    progress(static_cast<double>(row) / static_cast<double>(recorded.ticks.size()));
  }
  for (std::size_t i = 0; i < moments.size(); ++i) moments[i].primitives = std::move(felt[i]);
}

}  // namespace palpa::detail
