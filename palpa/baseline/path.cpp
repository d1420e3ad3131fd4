#include "palpa/baseline/path.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "palpa/baseline/law.h"
#include "palpa/session/proxy_path.h"
#include "palpa/solver/solver.h"

namespace palpa::baseline {

namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();

enum class Looks { at_proxy, at_probe };  // where modes look at the data and place primitives

class OneStepPath final : public ProxyPath {
 public:
  OneStepPath(StateArena& live, const Scene& scene, const Similarity& map, std::unique_ptr<Law> law, Looks looks)
      : ProxyPath(live, scene, map, std::move(law), unbounded), at_probe_(looks == Looks::at_probe) {}

 private:
  void sub_step(ProbeSegment segment) noexcept override {
    const Vec3 start = state_.proxy;
    spacing_m_ = std::min(modes_.finest_m(start, start, segment.to_m), 1.0);
    StepContext context{start, segment.to_m, segment.time_s, stiffness_n_per_m_, spacing_m_, at_probe_ ? 1.0 : 0.0};
    const double follows_s = playing_ ? advance_data(segment) : 0.0;
    modes_.begin_step(state_.step_start_m = start);

    model_.begin_move(context, spacing_m_);
    const Vec3& at = at_probe_ ? segment.to_m : start;
    model_.place(context, at, at, unbounded);
    const Move made{.to = model_.balance(context.probe_m, context.time_step_s)};
    configure_events(start, false);
    // No crossing stops the way. But a level whose plane holds the proxy stays held: on a round surface a step along that plane
    // ends off the level, which must not count as leaving it.
    using CrossingRule = EventPolicy::CrossingRule;
    std::ranges::replace_if(
        policy_.passing, [](CrossingRule passing) { return passing != CrossingRule::held; }, CrossingRule::passes);
    crossings_.first_event(start, made.to.position_m, policy_, modes_.samples(), work_left_, event_);

    advance(segment, made, follows_s, true);
    accept(segment, made, context, false);
    modes_.arrive();
  }

  bool at_probe_;
};

}  // namespace

std::unique_ptr<ProxyPath> path(StateArena& live, const Scene& scene, const Similarity& map) {
  if (scene.law == "exact") return std::make_unique<ProxyPath>(live, scene, map, law(scene));
  const Looks looks = scene.law == "no-proxy" ? Looks::at_probe : Looks::at_proxy;
  return std::make_unique<OneStepPath>(live, scene, map, law(scene), looks);
}

std::unique_ptr<ProxyPath> one_step(StateArena& live, const Scene& scene, const Similarity& map) {
  return std::make_unique<OneStepPath>(live, scene, map, std::make_unique<Solver>(), Looks::at_proxy);
}

}  // namespace palpa::baseline
