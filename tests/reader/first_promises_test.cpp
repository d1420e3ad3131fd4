// Promises in titles and comments of first scenes, on each set of the shared data.
#include <algorithm>
#include <cmath>

#include "data_sets.h"
#include "files.h"
#include "palpa/data/halton.h"
#include "palpa/file/directions.h"
#include "palpa/loop/loop.h"
#include "palpa/mode/modes.h"
#include "palpa/scene/first_scene.h"
#include "palpa/scene/load_scene.h"
#include "palpa/study/felt.h"
#include "palpa/study/run.h"
#include "palpa/study/unyielding.h"
#include "tests/today.h"

namespace palpa::test {
namespace first_promises_test {

struct Felt {
  Summary summary;
  std::vector<SessionEvent> broken;
};

class FirstPromises : public ReaderTest, public ::testing::WithParamInterface<DataSet> {
 protected:
  /// The first scene of the set; none without the data.
  std::optional<LoadedScene> first() const {
    const fs::path data = shared_file(GetParam().file);
    if (data.empty()) return std::nullopt;
    VolumeRequest request;
    request.files = {data};
    VolumeFile file = read_volume_file(request, options_);
    if (const auto directions = as_directions(request, file, options_)) {
      request = *directions;
      file = read_volume_file(request, options_);
    }
    return parse_scene(first_scene(file.volume, request), "first.toml", {}, volume_reader(options_), standard_modes());
  }

  static Felt feel(const LoadedScene& first, const std::string& hand, double duration_s) {
    RunOptions options;
    options.hand = hand;
    options.duration_s = duration_s;
    PreparedRun prepared = prepare(first, options);
    SummaryBuilder builder(first.scene);
    Session session(first.scene);
    Felt felt;
    run_simulated(session, *prepared.hand, {.duration_s = prepared.duration_s, .time_ticks = false}, nullptr,
                  [&](const TickFrame& frame, const Session& now) {
                    builder.add(frame, now);
                    for (const SessionEvent& event : now.events()) {
                      if (event.kind == SessionEventKind::break_through) felt.broken.push_back(event);
                    }
                  });
    felt.summary = builder.finish(1.0);
    return felt;
  }

  static void expect_promises(const LoadedScene& first, const Felt& felt) {
    const std::vector<SceneMode>& modes = first.scene.modes();
    for (const UnyieldingLevel& level : unyielding_levels(first.scene, first.scene.coupling().max_force_n)) {
      for (const double value : values_of(modes[level.mode], level.name)) {
        for (const SessionEvent& event : felt.broken)
          EXPECT_FALSE(event.mode == static_cast<int>(level.mode) && event.value == value) << level.name << " lets go";
      }
    }
    if (title_of(first).find("bone holds") != std::string::npos) {
      for (const double value : values_of(modes.front(), "bone")) {
        for (const SessionEvent& event : felt.broken) EXPECT_NE(event.value, value) << "bone lets go";
      }
    }
    for (std::size_t m = 0; m < modes.size(); ++m) {
      const ModeSummary& mode = felt.summary.modes[m];
      if (drives(modes[m].mode.type())) continue;
      EXPECT_LT(mode.injected_j - mode.dissipated_j, 1e-6) << mode.name << " brings energy in";
    }
    EXPECT_EQ(felt.summary.faults, 0);
    EXPECT_LE(felt.summary.force_max_n, first.scene.coupling().max_force_n + 1e-9);
  }

  static std::string title_of(const LoadedScene& first) {
    const std::size_t begin = first.text.find("title = ");
    return first.text.substr(begin, first.text.find('\n', begin) - begin);
  }

  /// Whether the set is an MR image: soft tissue, unless its title is of a flow or of labels.
  static bool is_of_tissue(const LoadedScene& first) {
    const std::string title = title_of(first);
    return fs::path(GetParam().file).string().starts_with("mr") && title.find(" flow") == std::string::npos &&
           title.find(" labels") == std::string::npos;
  }

  static std::vector<double> values_of(const SceneMode& mode, const std::string& name) {
    std::vector<double> values;
    for (const SurfaceAndFriction::Level& level : mode.mode.as<SurfaceAndFriction>()->levels) {
      if (level.name == name) values.push_back(level.value);
    }
    return values;
  }
};

void expect_that_tissue_does_not_keep_popping(const Felt& felt) {
  EXPECT_LT(static_cast<double>(felt.broken.size()) / felt.summary.duration_s, 0.5) << "break-throughs per second";
  EXPECT_GT(felt.summary.modes.front().contact_share, 0.1) << "it is felt all the same";
}

/// [N] Mean resistance to a rigid hand on a path of 20 mm at 50 mm/s.
double against_n(const Scene& scene, const Vec3& from_m, const Vec3& way) {
  constexpr double speed_m_per_s = 0.05, length_m = 0.02, dt_s = 1e-3;
  Session session(scene);
  double sum_n = 0.0;
  int ticks = 0;
  for (double at_m = 0.0; at_m < length_m; at_m += speed_m_per_s * dt_s, ++ticks)
    sum_n -= dot(session.tick({.position_m = from_m + at_m * way}, dt_s).force_n, way);
  return sum_n / ticks;
}

void expect_that_upstream_costs_more_than_downstream(const Scene& scene, bool is_flow) {
  const auto current = std::ranges::find_if(scene.modes(), [](const SceneMode& mode) { return mode.mode.as<VectorForce>(); });
  if (!is_flow) return;
  ASSERT_NE(current, scene.modes().end()) << "the flow's direction is not felt";
  const VectorForce& push = *current->mode.as<VectorForce>();
  const Field& flow = *scene.field(push.field).field;
  const Field& speed = *scene.field(push.strength_n.of).field;
  const Similarity map = scene.hand_to_world();
  int places = 0, told = 0;
  for (int n = 1; n <= 4000 && places < 30; ++n) {
    const Vec3 at_m = detail::halton(n, {{-0.06, -0.06, -0.06}, {0.06, 0.06, 0.06}});
    const auto flow_at = [&](const Vec3& hand_m) { return flow.vector(map.to_world(hand_m)); };
    const VectorSample here = flow_at(at_m);
    if (!here.inside || !(norm(here.value) > 0.0)) continue;
    const Vec3 way = normalized(map.gradient_to_hand(normalized(here.value)));
    // Where the flow's direction is constant along the path.
    bool even = true;
    for (double m = 0.0; m <= 0.02; m += 0.005) {
      const VectorSample there = flow_at(at_m + m * way);
      double factor = 1.0;
      for (const Mask& mask : current->masks)
        factor *= mask.curve.at(scene.field(mask.of).field->scalar(map.to_world(at_m + m * way)).value);
      const double pushed_n = push.strength_n.curve.at(speed.scalar(map.to_world(at_m + m * way)).value) * factor;
      even = even && there.inside && dot(normalized(there.value), normalized(here.value)) > 0.95 && pushed_n > 0.1;
    }
    if (!even) continue;
    ++places;
    const double down_n = against_n(scene, at_m, way), up_n = against_n(scene, at_m + 0.02 * way, -1.0 * way);
    told += up_n > down_n + 0.1;
  }
  ASSERT_GT(places, 0);
  EXPECT_GE(told, 0.9 * places);
}

// One test for three promises: the set takes longer to read than to feel. Each second set a day for the recorded hand.
TEST_P(FirstPromises, AreKeptUnderAStrokeUnderARecordedHandAndUpstream) {
  const auto first = this->first();
  if (!first) GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
  SCOPED_TRACE(first->text);
  {
    SCOPED_TRACE("under a stroke");
    expect_promises(*first, feel(*first, "sim:stroke", 10.0));
  }
  {
    SCOPED_TRACE("upstream");
    expect_that_upstream_costs_more_than_downstream(first->scene, title_of(*first).find(" a flow") != std::string::npos);
  }
  const std::vector<DataSet> sets = data_sets();
  const auto number = std::ranges::find(sets, GetParam().file, &DataSet::file) - sets.begin();
  if (!is_of_today(number, 2)) return;
  const fs::path hand = shared_file("trajectories/inverse3_woodcarving_20231123_143724.csv");
  if (hand.empty()) GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
  SCOPED_TRACE("under a recorded hand");
  const Felt felt = feel(*first, hand.string(), 13.0);
  expect_promises(*first, felt);
  if (is_of_tissue(*first)) expect_that_tissue_does_not_keep_popping(felt);
}

INSTANTIATE_TEST_SUITE_P(Sets, FirstPromises, ::testing::ValuesIn(data_sets()),
                         [](const auto& set) { return name_of(set.param); });

}  // namespace first_promises_test
}  // namespace palpa::test
