// Traces: files as documented, read back to the bit.
#include "palpa/trace/trace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <sstream>

#include "palpa/base/sanitized.h"
#include "tests/trace/trace_fixture.h"

namespace palpa {
namespace trace_test {

namespace fs = std::filesystem;
using test::error_of;
using test::first_line;
using test::plain_frame;
using test::set_text;
using test::text_of;
using test::Trace;
using test::write_plain;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (std::isnan(a) && std::isnan(b));
}
bool same_bits(const Vec3& a, const Vec3& b) { return same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.z, b.z); }

// Doubles of every exponent, and the special ones.
class AnyDouble {
 public:
  double operator()() {
    switch (engine_() % 12) {
      case 0: return 0.0;
      case 1: return -0.0;
      case 2: return std::numeric_limits<double>::quiet_NaN();
      case 3: return -std::numeric_limits<double>::infinity();
      case 4: return std::numeric_limits<double>::denorm_min();
      case 5: return std::numeric_limits<double>::max();
      default: return std::bit_cast<double>(engine_());
    }
  }
  Vec3 vector() { return {(*this)(), (*this)(), (*this)()}; }
  std::uint64_t integer() { return engine_(); }

 private:
  std::mt19937_64 engine_{7};
};

TickFrame random_frame(AnyDouble& any, std::int64_t tick) {
  TickFrame frame{.tick = tick, .t_s = any(), .dt_s = any()};
  Tick& r = frame.result;
  r.probe_m = any.vector();
  r.probe_velocity_m_per_s = any.vector();
  r.probe_valid = any.integer() % 2 == 0;
  r.proxy_m = any.vector();
  r.proxy_velocity_m_per_s = any.vector();
  r.force_n = any.vector();
  r.error_bound_m = any();
  r.sub_steps = static_cast<int>(any.integer() % 33);
  r.iterations = static_cast<int>(any.integer());
  r.status = static_cast<TickStatus>(any.integer() % 4);
  r.dropped = static_cast<int>(any.integer() % 100);
  r.energy = {any(), any(), any(), any(), any(), any(), any(), any(), any()};
  frame.command.work_on_hand_j = any();
  frame.command.withheld_j = any();
  frame.command.force_n = any.vector();
  frame.command.guard = static_cast<GuardState>(any.integer() % 3);
  frame.buttons = static_cast<std::uint32_t>(any.integer());
  return frame;
}

// ---- file contents ----

TEST_F(Trace, FilesHaveTheColumnsThatAreDocumented) {
  TraceWriter(folder(), {.primitives = true}, scene, {}).finish();
  EXPECT_EQ(
      first_line(folder() / "ticks.csv"),
      "tick,t_s,dt_s,probe_x_m,probe_y_m,probe_z_m,probe_velocity_x_m_per_s,probe_velocity_y_m_per_s,probe_velocity_z_m_per_s,"
      "probe_valid,proxy_x_m,proxy_y_m,proxy_z_m,proxy_velocity_x_m_per_s,proxy_velocity_y_m_per_s,proxy_velocity_z_m_per_s,"
      "force_x_n,force_y_n,force_z_n,command_x_n,command_y_n,command_z_n,error_bound_m,sub_steps,iterations,status,dropped,"
      "stored_j,dissipated_j,injected_j,path_j,damper_j,moved_j,work_on_hand_j,guard,buttons,"
      "let_go_j,held_back_j,ticks_j,ticks_bound_j,elastic_j,guard_cause,circumstances");
  EXPECT_EQ(first_line(folder() / "modes.csv"),
            "tick,mode,force_x_n,force_y_n,force_z_n,dissipated_j,injected_j,primitives,split_shared");
  EXPECT_EQ(
      first_line(folder() / "balances.csv"),
      "tick,sub_step,dt_s,start_x_m,start_y_m,start_z_m,probe_x_m,probe_y_m,probe_z_m,k_n_per_m,directed_x_n,directed_y_n,"
      "directed_z_n,balance_x_m,balance_y_m,balance_z_m,error_bound_m,stage,iterations,status,primitives,move_fraction,stop,"
      "proxy_x_m,proxy_y_m,proxy_z_m,energy_before_j,energy_after_j");
  EXPECT_EQ(
      first_line(folder() / "primitives.csv"),
      "tick,sub_step,mode,slot,kind,position_x_m,position_y_m,position_z_m,direction_x,direction_y,direction_z,strength_n,"
      "drag_ns_per_m,captured_value,force_x_n,force_y_n,force_z_n,state,"
      "stiffness_n_per_m,friction_coefficient,friction_plane,rides");
  EXPECT_EQ(first_line(folder() / "events.csv"), "tick,t_s,kind,subject,value");
  EXPECT_EQ(first_line(folder() / "timing.csv"), "tick,late_us,tick_us,device_us");
  EXPECT_EQ(text_of(folder() / "scene.toml"), scene);
  EXPECT_EQ(first_line(folder() / "trace.toml"), "complete = true");
}

TEST_F(Trace, TheReferenceNamesEveryColumnOfEveryFile) {
  TraceWriter(folder(), {.primitives = true}, scene, {}).finish();
  const std::string reference = trace_reference_markdown();
  for (const char* file : {"ticks.csv", "modes.csv", "balances.csv", "primitives.csv", "events.csv", "timing.csv"}) {
    EXPECT_THAT(reference, HasSubstr(file));
    std::istringstream header(first_line(folder() / file));
    for (std::string name; std::getline(header, name, ',');) EXPECT_THAT(reference, HasSubstr("`" + name + "`"));
  }
}

TEST_F(Trace, AnyScaleOfItsMapComesBackAndWhatIsNoMapIsRefused) {
  for (const double scale : {1e-150, 1.0, 1e150}) {
    TraceHeader header;
    header.hand_to_world = {rotation_about({0.0, 0.6, 0.8}, 30.0), scale, {1.0, 2.0, 3.0}};
    const fs::path at = folder("trace" + std::to_string(std::log10(scale)));
    TraceWriter(at, header, scene, {}).finish();
    EXPECT_NEAR(TraceReader(at).header().hand_to_world.scale / scale, 1.0, 1e-12);
  }
  TraceWriter(folder(), {}, scene, {}).finish();
  for (const char* none : {"[[nan, 0, 0, 0]]", "[[0, 0, 0, 0]]", "[[-1, 0, 0, 0]]", "[[2, 0, 0, 0]]"}) {
    set_text(folder() / "trace.toml", std::string("format = 1\ndt_s = 0.001\nhand_to_world = ") + none + "\n");
    EXPECT_THAT(error_of([&] { TraceReader{folder()}; }), HasSubstr("hand_to_world is no rotation, move and scale; ")) << none;
  }
}

TEST_F(Trace, WhatStrangersWroteInItSteersNothing) {
  for (const char* name : {"a", "b"}) {
    TraceWriter writer(folder(name), {}, scene, {"skin", "bone"});
    write_plain(writer, 0, 3);
    writer.finish();
  }
  std::string text = text_of(folder("b") / "modes.csv");
  text.replace(text.find("skin"), 4, "\x1b[31m\u202e\xff");
  set_text(folder("b") / "modes.csv", text);
  const std::string where = compare_traces(folder("a"), folder("b")).where;
  EXPECT_THAT(where, HasSubstr("skin against \\u001B[31m"));
  EXPECT_EQ(where, detail::sanitized(where));
  set_text(folder("b") / "trace.toml", "format = 1\ndt_s = 0.001\nsets = [\"two\\nlines\"]\n");
  const std::string error = error_of([&] { TraceReader{folder("b")}; });
  EXPECT_THAT(error, HasSubstr("has no '='; "));
  EXPECT_EQ(error, detail::sanitized(error));
}

TEST_F(Trace, WithoutPrimitivesThereAreNoFilesOfThem) {
  TraceWriter(folder(), {}, scene, {}).finish();
  EXPECT_FALSE(fs::exists(folder() / "balances.csv"));
  EXPECT_FALSE(fs::exists(folder() / "primitives.csv"));
}

TEST_F(Trace, RowsOfModesBalancesPrimitivesAndEvents) {
  const ModeForce modes[] = {{.force_n = {0.25, 0, -1}, .dissipated_j = 1e-5, .primitives = 2}, {.split_shared = true}};
  PlacedPrimitive plane{.primitive = {.kind = PrimitiveKind::plane,
                                      .id = {0, 3},
                                      .position_m = {0, 0, 0.5},
                                      .direction = {0, 0, 1},
                                      .strength_n = 0.8},
                        .captured = {.field = 0, .value = -300},
                        .force_n = {0, 0, 0.5},
                        .state = PrimitiveState::stick};
  PlacedPrimitive point{.primitive = {.id = {1, 0}, .strength_n = 1}};
  const PlacedPrimitive placed[] = {plane, point, plane};
  SubStep first{.time_step_s = 1e-3, .stiffness_n_per_m = 500, .move_fraction = 1, .first_primitive = 0, .primitives = 2};
  SubStep second{.time_step_s = 0.25, .stop = Stop::event, .first_primitive = 2, .primitives = 1};
  const SubStep steps[] = {first, second};
  const SessionEvent events[] = {{.kind = SessionEventKind::onset, .mode = 0, .value = -300},
                                 {.kind = SessionEventKind::fault, .mode = 1, .text = "strength is negative, \"so\""}};
  TraceWriter writer(folder(), {.primitives = true}, scene, {"skin", "with,comma"});
  writer.append(plain_frame(5), modes, steps, placed, events);
  writer.append_event(6, 0.006, "warning", "session", "two\nlines");
  writer.finish();
  EXPECT_THAT(text_of(folder() / "modes.csv"), HasSubstr("\n5,skin,0.25,0,-1,1e-05,0,2,0\n5,\"with,comma\",0,0,0,0,0,0,1\n"));
  EXPECT_THAT(text_of(folder() / "primitives.csv"), HasSubstr("\n5,0,skin,3,plane,0,0,0.5,0,0,1,0.8,0,-300,0,0,0.5,stick,,,,0\n"
                                                              "5,0,\"with,comma\",0,point,0,0,0,0,0,0,1,0,,0,0,0,off,,,,0\n"
                                                              "5,1,skin,3,plane,"));
  EXPECT_THAT(text_of(folder() / "balances.csv"),
              AllOf(HasSubstr("\n5,0,0.001,"), HasSubstr("\n5,1,0.25,"), HasSubstr(",event,")));
  EXPECT_EQ(text_of(folder() / "events.csv"),
            "tick,t_s,kind,subject,value\n5,0.005,onset,skin,-300\n5,0.005,fault,\"with,comma\",\"strength is negative, "
            "\"\"so\"\"\"\n"
            "6,0.006,warning,session,two lines\n");
}

TEST_F(Trace, ACornerIsTheRowsOfItsFacetsThatCarryForce) {
  PlacedPrimitive facet{.primitive = {.kind = PrimitiveKind::corner, .id = {0, 3}, .direction = {0, 0, 1}, .strength_n = 0.8},
                        .force_n = {0, 0, 0.5},
                        .state = PrimitiveState::stick};
  PlacedPrimitive idle = facet;
  idle.force_n = {};
  const PlacedPrimitive placed[] = {facet, idle, facet, facet};
  const SubStep steps[] = {{.first_primitive = 0, .primitives = 3}, {.first_primitive = 3, .primitives = 1}};
  TraceWriter writer(folder(), {.primitives = true}, scene, {"skin"});
  writer.append(plain_frame(5), {}, steps, placed, {});
  writer.finish();
  const std::string row = "skin,3,facet,0,0,0,0,0,1,0.8,0,,0,0,0.5,stick,,,,0\n";
  EXPECT_THAT(text_of(folder() / "primitives.csv"), EndsWith("\n5,0," + row + "5,0," + row + "5,1," + row));
  EXPECT_THAT(text_of(folder() / "balances.csv"), AllOf(HasSubstr(",exact,2,"), HasSubstr(",exact,1,")));
}

TEST_F(Trace, RowsOfWorksAndBreakThroughs) {
  const PlacedPrimitive plane{
      .primitive = {.kind = PrimitiveKind::plane, .id = {0, 3}}, .force_n = {0, 0, 2}, .carried_m = {0, 0, 0.5}};
  const SubStep step{.move_fraction = 0.5, .proxy_m = {0, 0, 0.125}, .primitives = 1};
  const SessionEvent events[] = {{.kind = SessionEventKind::onset, .mode = 0, .value = -300},
                                 {.kind = SessionEventKind::break_through, .mode = 0, .value = -300, .depth_m = 0.0016}};
  TraceWriter writer(folder(), {.primitives = true}, scene, {"skin"});
  writer.append(plain_frame(5), {}, {&step, 1}, {&plane, 1}, events);
  writer.finish();
  // Half of the sub-step was gone: data carried the proxy by 0.25 m, it went by 0.125 m, so 2 N have taken out 0.25 J.
  EXPECT_EQ(text_of(folder() / "works.csv"),
            "tick,sub_step,mode,slot,carried_x_m,carried_y_m,carried_z_m,work_j\n5,0,skin,3,0,0,0.5,-0.25\n");
  EXPECT_EQ(text_of(folder() / "break_throughs.csv"), "tick,t_s,mode,level,depth_m\n5,0.005,skin,-300,0.0016\n");
}

TEST_F(Trace, AnEventStandsWhereTheGuardChangesItsMind) {
  TraceWriter writer(folder(), {}, scene, {});
  const GuardState states[] = {GuardState::pass, GuardState::limited, GuardState::limited, GuardState::fault, GuardState::pass};
  for (std::int64_t i = 0; i < 5; ++i) {
    TickFrame frame = plain_frame(i);
    frame.command.guard = states[i];
    if (states[i] == GuardState::fault) frame.command.cause = GuardCause::not_finite;
    writer.append(frame, {}, {}, {}, {});
  }
  writer.finish();
  EXPECT_EQ(text_of(folder() / "events.csv"),
            "tick,t_s,kind,subject,value\n1,0.001,guard,limited,the force is above the limit\n"
            "3,0.003,fault,guard,the force is not finite\n4,0.004,guard,pass,\n");
}

TEST_F(Trace, AnEventSaysBySoMuchTheForceWouldHaveStepped) {
  TraceWriter writer(folder(), {}, scene, {});
  for (const double snap_n : {0.0, 0.25, 0.0}) {
    TickFrame frame = plain_frame(snap_n > 0.0);
    frame.command.snap_n = snap_n;
    writer.append(frame, {}, {}, {}, {});
  }
  writer.finish();
  EXPECT_EQ(text_of(folder() / "events.csv"), "tick,t_s,kind,subject,value\n1,0.001,snap,proxy,0.25\n");
}

// ---- round trips ----

TEST_F(Trace, TicksReadBackToTheBit) {
  AnyDouble any;
  std::vector<TickFrame> written;
  for (std::int64_t i = 0; i < 2000; ++i) written.push_back(random_frame(any, i));
  TraceWriter writer(folder(), {}, scene, {});
  for (const TickFrame& frame : written) writer.append(frame, {}, {}, {}, {});
  writer.finish();

  const std::vector<TraceTick> read = TraceReader(folder()).ticks();
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    const TickFrame& a = written[i];
    const TickFrame& b = read[i].frame;
    const Tick& p = a.result;
    const Tick& q = b.result;
    ASSERT_EQ(a.tick, b.tick);
    ASSERT_TRUE(same_bits(a.t_s, b.t_s) && same_bits(a.dt_s, b.dt_s));
    ASSERT_TRUE(same_bits(p.probe_m, q.probe_m) && same_bits(p.probe_velocity_m_per_s, q.probe_velocity_m_per_s));
    ASSERT_TRUE(same_bits(p.proxy_m, q.proxy_m) && same_bits(p.proxy_velocity_m_per_s, q.proxy_velocity_m_per_s));
    ASSERT_TRUE(same_bits(p.force_n, q.force_n) && same_bits(a.command.force_n, b.command.force_n));
    ASSERT_EQ(p.probe_valid, q.probe_valid);
    ASSERT_TRUE(same_bits(p.error_bound_m, q.error_bound_m));
    ASSERT_EQ(p.sub_steps, q.sub_steps);
    ASSERT_EQ(p.iterations, q.iterations);
    ASSERT_EQ(p.status, q.status);
    ASSERT_EQ(p.dropped, q.dropped);
    ASSERT_TRUE(same_bits(p.energy.stored_j, q.energy.stored_j) && same_bits(p.energy.dissipated_j, q.energy.dissipated_j));
    ASSERT_TRUE(same_bits(p.energy.injected_j, q.energy.injected_j) &&
                same_bits(p.energy.path_and_release_j, q.energy.path_and_release_j));
    ASSERT_TRUE(same_bits(p.energy.damper_j, q.energy.damper_j) && same_bits(p.energy.data_motion_j, q.energy.data_motion_j));
    ASSERT_TRUE(same_bits(a.command.work_on_hand_j, b.command.work_on_hand_j));
    ASSERT_TRUE(same_bits(p.energy.released_j, q.energy.released_j) && same_bits(a.command.withheld_j, b.command.withheld_j));
    ASSERT_TRUE(same_bits(p.energy.sampling_j, q.energy.sampling_j) &&
                same_bits(p.energy.sampling_bound_j, q.energy.sampling_bound_j));
    ASSERT_EQ(a.command.guard, b.command.guard);
    ASSERT_EQ(a.buttons, b.buttons);
  }
}

TEST_F(Trace, TheHeaderReadsBack) {
  TraceHeader header;
  header.palpa_version = "0.1.0";
  header.arguments = {"palpa", "run", "a \"b\"\\\n\x01 \xc3\xa4.toml", "latin-1 \xe4", "--hand", "sim:press"};
  header.sets = {{"coupling.stiffness_n_per_m", "400"}, {"mode.skin.mask", "a=b"}};
  header.plugins = {"./ridge.so"};
  header.hand_to_world = {.rotation = {{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}}, .scale = 1.6, .translation_m = {0.1, -2, 1e6}};
  header.dt_s = 1.0 / 3000.0;
  header.device_name = "touch,max_force_n=3.3";
  header.device_max_force_n = 3.3;
  header.device_encoder_step_m = 55e-6;
  header.data_files = {{.path = "/data/head.nrrd", .bytes = 123456789012, .sha256 = "00ff"}, {.path = "b"}};
  header.seeds = {0, 7, (std::uint64_t{1} << 63) - 1};
  TraceWriter(folder(), header, scene, {}).finish();

  const TraceReader reader(folder());
  const TraceHeader& read = reader.header();
  EXPECT_EQ(reader.scene_text(), scene);
  EXPECT_TRUE(read.complete);
  EXPECT_EQ(read.palpa_version, "0.1.0");
  header.arguments[3] = "latin-1 ?";
  EXPECT_EQ(read.arguments, header.arguments);
  EXPECT_EQ(read.sets, header.sets);
  EXPECT_EQ(read.plugins, header.plugins);
  EXPECT_NEAR(read.hand_to_world.scale, 1.6, 1e-15);
  EXPECT_NEAR(distance(read.hand_to_world.to_world({1, 2, 3}), header.hand_to_world.to_world({1, 2, 3})), 0, 1e-9);
  EXPECT_EQ(read.dt_s, header.dt_s);
  EXPECT_EQ(read.device_name, "touch,max_force_n=3.3");
  EXPECT_EQ(read.device_max_force_n, 3.3);
  EXPECT_EQ(read.device_encoder_step_m, 55e-6);
  ASSERT_EQ(read.data_files.size(), 2u);
  EXPECT_EQ(read.data_files[0].path, "/data/head.nrrd");
  EXPECT_EQ(read.data_files[0].bytes, 123456789012u);
  EXPECT_EQ(read.data_files[0].sha256, "00ff");
  EXPECT_EQ(read.seeds, header.seeds);
  EXPECT_FALSE(read.primitives);
}

/// Checksums that a test makes known.
class PromisedChecksums final : public LateChecksums {
 public:
  bool are_known() const override { return is_kept; }
  std::string text(std::size_t file) const override { return std::string(1, static_cast<char>('a' + file)); }
  bool is_kept = false;
};

TEST_F(Trace, ChecksumsAreWrittenOnceTheyAreKnown) {
  const auto later = std::make_shared<PromisedChecksums>();
  TraceHeader header;
  header.data_files = {{"/data/head.mhd", 1, Checksum(later, 0)}, {"/data/head.raw", 2, Checksum(later, 1)}};
  const auto written = [&] { return TraceReader(folder()).header().data_files.at(1).sha256.text(); };
  TraceWriter writer(folder(), header, scene, {});
  writer.flush();
  EXPECT_EQ(written(), "");
  later->is_kept = true;
  writer.flush();
  EXPECT_EQ(written(), "b") << "a killed recording has them";
  EXPECT_FALSE(TraceReader(folder()).header().complete);
  later->is_kept = false;
  writer.finish();
  EXPECT_EQ(written(), "b") << "finish waits for them";
}

TEST_F(Trace, ColumnsMayStandInAnyOrderAmongOthersThatAreUnknown) {
  {
    TraceWriter writer(folder(), {}, scene, {});
    write_plain(writer, 0, 3);
    writer.finish();
  }
  std::istringstream lines(text_of(folder() / "ticks.csv"));
  std::string turned;
  for (std::string line; std::getline(lines, line);) {
    std::string reversed;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) reversed = cell + (reversed.empty() ? "" : "," + reversed);
    turned += "new,\"a,b\"," + reversed + "\n";
  }
  set_text(folder() / "ticks.csv", turned);
  const std::vector<TraceTick> ticks = TraceReader(folder()).ticks();
  ASSERT_EQ(ticks.size(), 3u);
  EXPECT_EQ(ticks[2].frame.result.probe_m, plain_frame(2).result.probe_m);
  EXPECT_EQ(ticks[2].frame.command.force_n, (Vec3{0.0, 0.5, 0.0}));
}

}  // namespace trace_test
}  // namespace palpa
