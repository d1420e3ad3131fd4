// A report's signal section: stiffness, band of a known shaking, break-through.
#include "palpa/report/signal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "palpa/report/report.h"
#include "palpa/report/view_3d.h"
#include "tests/report/markup.h"
#include "tests/study/study_fixture.h"

namespace palpa::detail {
namespace signal_test {

using testing::HasSubstr;
using testing::Not;

constexpr double stiffness_n_per_m = 600.0;

/// Two seconds on a wall; the probe shakes at 120 Hz, and the force is the spring's.
Recorded shaking() {
  Recorded recorded;
  recorded.header.dt_s = 1e-3;
  recorded.modes = {"wall"};
  recorded.pushes.resize(1);
  recorded.summary.modes = {{.name = "wall", .type = "surface_and_friction"}};
  for (int i = 0; i < 2000; ++i) {
    TickFrame frame{.tick = i, .t_s = 1e-3 * i, .dt_s = 1e-3};
    const double depth_m = 2e-3 + 1e-5 * std::sin(2.0 * std::numbers::pi * 120.0 * frame.t_s);
    frame.result.probe_m = {0, 0, -depth_m};
    frame.result.energy.stored_j = 0.5 * stiffness_n_per_m * depth_m * depth_m;
    frame.command.force_n = frame.result.force_n = {0, 0, stiffness_n_per_m * depth_m};
    recorded.ticks.push_back(frame);
    recorded.pushes[0].push_back({.force_n = frame.command.force_n});
  }
  return recorded;
}

TEST(Signal, KnowsTheStiffnessFromTheRecording) {
  EXPECT_NEAR(felt_run_of(shaking()).stiffness_n_per_m, stiffness_n_per_m, 1e-6);
}

TEST(Signal, HasTheBandOfAKnownShaking) {
  const Signal signal = signal_of(shaking(), nullptr);
  const double rms_n = stiffness_n_per_m * 1e-5 / std::numbers::sqrt2;
  EXPECT_NEAR(signal.command.band_rms(tactile_low_hz, tactile_high_hz), rms_n, 1e-5);
  EXPECT_NEAR(signal.spring.band_rms(tactile_low_hz, tactile_high_hz), rms_n, 1e-5);
  EXPECT_THAT(signal_markup(signal), HasSubstr("4.24 mN"));
  EXPECT_THAT(signal_markup(signal), HasSubstr("data not available"));
  EXPECT_THAT(steps_markup(signal), HasSubstr("None.</p>"));
}

TEST(Signal, ListsStepsWithTheirCauseAndMode) {
  Recorded recorded = shaking();
  for (std::size_t i = 1000; i < recorded.ticks.size(); ++i)
    recorded.ticks[i].command.force_n = recorded.pushes[0][i].force_n = {0, 0, 0.5};
  recorded.modes[0] = "wall <b>";
  const std::string unexplained = steps_markup(signal_of(recorded, nullptr));
  for (const char* words : {"strength", "wall &lt;b&gt;", "data-time=\"1.000000\""}) EXPECT_THAT(unexplained, HasSubstr(words));
  recorded.events.push_back({.tick = 1000, .t_s = 1.0, .kind = "break_through", .subject = "wall", .value = "0"});
  const std::string told = steps_markup(signal_of(recorded, nullptr));
  EXPECT_THAT(told, HasSubstr("break-through"));
  EXPECT_THAT(told, Not(HasSubstr("data-time"))) << "an event tells of it";
}

// During the fade of a broken level command and force differ without the limiter's action.
TEST(View, SaysWhatWasAskedWhereTheGuardShortenedIt) {
  Recorded recorded = shaking();
  std::vector<RecordedMoment> moments(1);
  for (const double asked_share : {0.5, 1.0, 1.5}) {
    for (const GuardState guard : {GuardState::pass, GuardState::limited, GuardState::fault}) {
      recorded.ticks[0].command.guard = guard;
      recorded.ticks[0].result.force_n = asked_share * recorded.ticks[0].command.force_n;
      const bool says = json_of_view(recorded, nullptr, moments, {0, 0, 1}).find("\"asked\"") != std::string::npos;
      EXPECT_EQ(says, guard == GuardState::limited) << asked_share;
    }
  }
}

class FeltSignal : public StudyTest {};

TEST_F(FeltSignal, IsASectionOfAReport) {
  run(options("trace", 3.0));
  const std::string html = report_html(folder / "trace");
  EXPECT_EQ(markup_error(html, true), "");
  for (const char* words : {"Force signal", "force, 100 to 500 Hz, root mean square", "limited by the guard", "id=\"spectrum-",
                            "steepest fall at a break-through", "<h3>Steps</h3>"}) {
    EXPECT_THAT(html, HasSubstr(words));
  }
}

TEST_F(FeltSignal, OfAHandThatTouchesNothingIsSaidToBeNone) {
  run(options("trace", 0.05));  // the hand is still approaching
  EXPECT_THAT(report_html(folder / "trace"), HasSubstr("nothing to measure"));
}

}  // namespace signal_test
}  // namespace palpa::detail
