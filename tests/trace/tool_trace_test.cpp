// Traces of a tool with an orientation: more columns than those of a point, read back to the bit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/trace/trace_fixture.h"

namespace palpa {
namespace tool_trace_test {

using test::error_of;
using test::first_line;
using test::plain_frame;
using test::set_text;
using test::text_of;
using test::Trace;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

const Turn half{0.5, 0.5, -0.5, 0.5}, third{1.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0, 0.0};

TickFrame turned_frame(std::int64_t i) {
  TickFrame frame = plain_frame(i);
  frame.result.probe_turn = turn_by({0.01 * static_cast<double>(i), 0.0, 1.0 / 3.0});
  frame.result.proxy_turn = third;
  frame.result.torque_nm = {0.0, -0.25, 1e-3 / 3.0};
  frame.command.torque_nm = {0.0, -0.125, 0.0};
  frame.command.unfelt_j = 1.0 / 7.0;
  return frame;
}

class ToolTrace : public Trace {
 protected:
  void record(const std::string& name, std::int64_t ticks, bool has_tool = true) const {
    TraceHeader header{.device_max_torque_nm = 0.75, .device_max_turn_damping_nms_per_rad = 0.125};
    header.primitives = true;
    header.has_tool = has_tool;
    TraceWriter writer(folder(name), header, scene, {"skin"});
    for (std::int64_t i = 0; i < ticks; ++i) writer.append(turned_frame(i), {}, {}, {}, {});
    writer.finish();
  }
};

TEST_F(ToolTrace, HasTheColumnsOfAPointAndThenThoseOfATool) {
  record("tool", 2);
  record("point", 2, false);
  for (const auto& [file, more] :
       {std::pair{"ticks.csv",
                  ",probe_turn_w,probe_turn_x,probe_turn_y,probe_turn_z,proxy_turn_w,proxy_turn_x,proxy_turn_y,proxy_turn_z,"
                  "torque_x_nm,torque_y_nm,torque_z_nm,command_torque_x_nm,command_torque_y_nm,command_torque_z_nm,unfelt_j"},
        std::pair{"balances.csv",
                  ",start_turn_w,start_turn_x,start_turn_y,start_turn_z,probe_turn_w,probe_turn_x,probe_turn_y,probe_turn_z,"
                  "turn_x_rad,turn_y_rad,turn_z_rad,proxy_turn_w,proxy_turn_x,proxy_turn_y,proxy_turn_z,turning_radius_m"},
        std::pair{"primitives.csv", ",foot,lever_x_m,lever_y_m,lever_z_m"}, std::pair{"modes.csv", ""},
        std::pair{"events.csv", ""}, std::pair{"timing.csv", ""}}) {
    EXPECT_EQ(first_line(folder("tool") / file), first_line(folder("point") / file) + more) << file;
  }
  EXPECT_THAT(text_of(folder("tool") / "trace.toml"), HasSubstr("\nmax_torque_nm = 0.75\n"));
  EXPECT_THAT(text_of(folder("point") / "trace.toml"), Not(HasSubstr("torque")));
  EXPECT_EQ(TraceReader(folder("tool")).header().device_max_torque_nm, 0.75);
  EXPECT_EQ(TraceReader(folder("tool")).header().device_max_turn_damping_nms_per_rad, 0.125);
  EXPECT_TRUE(TraceReader(folder("tool")).header().has_tool);
  EXPECT_FALSE(TraceReader(folder("point")).header().has_tool);
  EXPECT_TRUE(TraceReader(folder("tool")).has_energy());
  EXPECT_TRUE(TraceReader(folder("point")).has_energy());
}

TEST_F(ToolTrace, TheReferenceNamesEveryColumn) {
  record("tool", 0);
  const std::string reference = trace_reference_markdown();
  for (const char* file : {"ticks.csv", "balances.csv", "primitives.csv"}) {
    std::istringstream header(first_line(folder("tool") / file));
    for (std::string name; std::getline(header, name, ',');) EXPECT_THAT(reference, HasSubstr("`" + name + "`"));
  }
}

TEST_F(ToolTrace, TicksReadBackToTheBit) {
  record("tool", 50);
  const std::vector<TraceTick> ticks = TraceReader(folder("tool")).ticks();
  ASSERT_EQ(ticks.size(), 50u);
  for (const auto& [read] : ticks) {
    const TickFrame written = turned_frame(read.tick);
    EXPECT_EQ(read.result.probe_turn, written.result.probe_turn);
    EXPECT_EQ(read.result.proxy_turn, written.result.proxy_turn);
    EXPECT_EQ(read.result.torque_nm, written.result.torque_nm);
    EXPECT_EQ(read.command.torque_nm, written.command.torque_nm);
    EXPECT_EQ(read.command.unfelt_j, written.command.unfelt_j);
  }
  record("point", 1, false);
  EXPECT_EQ(TraceReader(folder("point")).ticks()[0].frame.result.probe_turn, Turn{});
}

TEST_F(ToolTrace, RowsOfBalancesAndPrimitives) {
  SubStep step{.time_step_s = 1e-3, .stiffness_n_per_m = 500, .move_fraction = 1, .primitives = 1};
  step.start_turn = half;
  step.probe_turn = {0, 1, 0, 0};
  step.balance.turn_rad = {0.25, 0, -0.125};
  step.proxy_turn = {0, 0, 1, 0};
  step.turning_radius_m = 0.03;
  PlacedPrimitive plane{
      .primitive = {.kind = PrimitiveKind::plane, .id = {0, 3, 7}, .direction = {0, 0, 1}, .strength_n = 0.8}};
  plane.lever_m = {0, 0.01, -0.05};
  TraceWriter writer(folder(), {.primitives = true, .has_tool = true}, scene, {"skin"});
  writer.append(turned_frame(0), {}, {&step, 1}, {&plane, 1}, {});
  writer.finish();
  EXPECT_THAT(text_of(folder() / "balances.csv"), EndsWith(",0,0,0.5,0.5,-0.5,0.5,0,1,0,0,0.25,0,-0.125,0,0,1,0,0.03\n"));
  EXPECT_THAT(text_of(folder() / "primitives.csv"), EndsWith(",off,,,,0,7,0,0.01,-0.05\n"));
}

TEST_F(ToolTrace, IsComparedInEveryColumnThatItHas) {
  record("recorded", 20);
  record("again", 20);
  const auto compare = [&] { return compare_traces(folder("recorded"), folder("again")); };
  EXPECT_TRUE(compare().same) << compare().where;
  const std::string good = text_of(folder("again") / "ticks.csv");
  std::string bad = good;
  const std::size_t at = bad.rfind("-0.125");
  bad.replace(at, 6, "-0.375");
  set_text(folder("again") / "ticks.csv", bad);
  EXPECT_THAT(compare().where, HasSubstr("ticks.csv:21: column command_torque_y_nm: -0.125 against -0.375"));
  std::filesystem::remove_all(folder("again"));
  record("again", 20, false);
  EXPECT_THAT(compare().where, HasSubstr("ticks.csv:1: column probe_turn_w is missing in the replay"));
  EXPECT_TRUE(compare_traces(folder("again"), folder("recorded")).same) << "a recording without them";
}

TEST_F(ToolTrace, ErrorsNameFileLineAndColumn) {
  record("tool", 3);
  std::string text = text_of(folder("tool") / "ticks.csv");
  const std::string turn = "0.3333333333333333,-0.6666666666666666";
  ASSERT_NE(text.find(turn), std::string::npos);
  text.replace(text.find(turn), turn.size(), "0.3333333333333333,high");
  set_text(folder("tool") / "ticks.csv", text);
  EXPECT_THAT(
      error_of([&] { TraceReader(folder("tool")).ticks(); }),
      HasSubstr("ticks.csv:2: column 'proxy_turn' cannot be '0.3333333333333333', 'high', '0.6666666666666666', '0'; "));
}

TEST_F(ToolTrace, APathHasTurnsAndTorquesInTheFrameOfTheData) {
  TraceHeader header{.has_tool = true};
  header.hand_to_world = {rotation_about({0, 0, 1}, 90.0), 2.0, {1, 0, 0}};
  TickFrame frame = plain_frame(0);
  frame.result.probe_turn = {0.6, 0.8, 0, 0};
  frame.result.proxy_turn = {0.6, 0, 0.8, 0};
  frame.result.torque_nm = {0.5, 0, 0};
  frame.command.torque_nm = {0, 0.5, 0};
  TraceWriter writer(folder(), header, scene, {});
  writer.append(frame, {}, {}, {}, {});
  writer.finish();
  const FeltPath path = felt_path(folder());
  // x of the hand is y of the world; newton metres are not scaled.
  const auto near = [](std::vector<double> expected) {
    std::vector<testing::Matcher<double>> each;
    for (const double value : expected) each.push_back(testing::DoubleNear(value, 1e-15));
    return testing::ElementsAreArray(each);
  };
  EXPECT_THAT(path.column("probe_turn").values, near({0.6, 0, 0.8, 0}));
  EXPECT_THAT(path.column("proxy_turn").values, near({0.6, -0.8, 0, 0}));
  EXPECT_THAT(path.column("torque_nm").values, near({0, 0.5, 0}));
  EXPECT_THAT(path.column("command_torque_nm").values, near({-0.5, 0, 0}));
  EXPECT_EQ(path.column("probe_turn").components, 4);
  record("point", 1, false);
  EXPECT_TRUE(std::ranges::none_of(felt_path(folder("point")).columns,
                                   [](const FeltColumn& c) { return c.name.find("turn") != std::string::npos; }));
}

}  // namespace tool_trace_test
}  // namespace palpa
