// Laws of traces: what is written reads back to the bit, a trace that was cut off reads as far as it is
// whole, and two traces are the same exactly where every value is.
#include "palpa/trace/trace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <bit>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>

#include "palpa/base/sanitized.h"

namespace palpa {
namespace trace_test {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}
void set_text(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }
std::string first_line(const fs::path& file) {
  const std::string text = text_of(file);
  return text.substr(0, text.find('\n'));
}

template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const LoadError& error) {
    return error.what();
  }
  return "(no error)";
}

class Trace : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "palpa-trace-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
  }
  void TearDown() override { fs::remove_all(root_); }
  fs::path folder(const std::string& name = "trace") const { return root_ / name; }

  static constexpr const char* scene = "palpa = 1\n# \xc3\xa9 byte for byte\r\n\n";

 private:
  fs::path root_;
};

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
  r.energy = {any(), any(), any(), any(), any(), any(), any(), any(), any(), any(), any()};
  frame.command_n = any.vector();
  frame.guard = static_cast<GuardState>(any.integer() % 3);
  frame.buttons = static_cast<std::uint32_t>(any.integer());
  return frame;
}

// A plain tick number `i` whose values differ from tick to tick.
TickFrame plain_frame(std::int64_t i) {
  TickFrame frame{.tick = i, .t_s = static_cast<double>(i) / 1000, .dt_s = 1e-3};
  frame.result.probe_m = {0.0, 0.001 * static_cast<double>(i), 1.0 / 3.0};
  frame.result.force_n = frame.command_n = {0.0, 0.5, 0.0};
  return frame;
}

void write_plain(TraceWriter& writer, std::int64_t from, std::int64_t to) {
  const ModeForce modes[] = {{.force_n = {0, 0, 1}, .primitives = 2}, {.split_shared = true}};
  for (std::int64_t i = from; i < to; ++i) writer.append(plain_frame(i), modes, {}, {}, {});
}

// ---- what stands in the files ----

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
      "stiffness_n_per_m");
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
  EXPECT_EQ(where, detail::shown(where));
  set_text(folder("b") / "trace.toml", "format = 1\ndt_s = 0.001\nsets = [\"two\\nlines\"]\n");
  const std::string error = error_of([&] { TraceReader{folder("b")}; });
  EXPECT_THAT(error, HasSubstr("has no '='; "));
  EXPECT_EQ(error, detail::shown(error));
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
  EXPECT_THAT(text_of(folder() / "primitives.csv"), HasSubstr("\n5,0,skin,3,plane,0,0,0.5,0,0,1,0.8,0,-300,0,0,0.5,stick,\n"
                                                              "5,0,\"with,comma\",0,point,0,0,0,0,0,0,1,0,,0,0,0,off,\n"
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
  const std::string row = "skin,3,facet,0,0,0,0,0,1,0.8,0,,0,0,0.5,stick,\n";
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
    frame.guard = states[i];
    if (states[i] == GuardState::fault) frame.guard_cause = GuardCause::not_finite;
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
    frame.snap_n = snap_n;
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
    ASSERT_TRUE(same_bits(p.force_n, q.force_n) && same_bits(a.command_n, b.command_n));
    ASSERT_EQ(p.probe_valid, q.probe_valid);
    ASSERT_TRUE(same_bits(p.error_bound_m, q.error_bound_m));
    ASSERT_EQ(p.sub_steps, q.sub_steps);
    ASSERT_EQ(p.iterations, q.iterations);
    ASSERT_EQ(p.status, q.status);
    ASSERT_EQ(p.dropped, q.dropped);
    ASSERT_TRUE(same_bits(p.energy.stored_j, q.energy.stored_j) && same_bits(p.energy.dissipated_j, q.energy.dissipated_j));
    ASSERT_TRUE(same_bits(p.energy.injected_j, q.energy.injected_j) && same_bits(p.energy.path_j, q.energy.path_j));
    ASSERT_TRUE(same_bits(p.energy.damper_j, q.energy.damper_j) && same_bits(p.energy.moved_j, q.energy.moved_j));
    ASSERT_TRUE(same_bits(p.energy.work_on_hand_j, q.energy.work_on_hand_j));
    ASSERT_TRUE(same_bits(p.energy.let_go_j, q.energy.let_go_j) && same_bits(p.energy.held_back_j, q.energy.held_back_j));
    ASSERT_TRUE(same_bits(p.energy.ticks_j, q.energy.ticks_j) && same_bits(p.energy.ticks_bound_j, q.energy.ticks_bound_j));
    ASSERT_EQ(a.guard, b.guard);
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
  EXPECT_EQ(ticks[2].frame.command_n, (Vec3{0.0, 0.5, 0.0}));
}

// ---- errors ----

TEST_F(Trace, AFolderThatCannotBeMadeIsRefused) {
  fs::create_directory(folder());
  const auto write_to = [&](const fs::path& where) { return error_of([&] { TraceWriter(where, {}, scene, {}); }); };
  EXPECT_THAT(write_to(folder()), AllOf(HasSubstr("exists already"), HasSubstr("; name a new folder")));
  EXPECT_THAT(write_to(folder() / "no" / "parent"), HasSubstr("parent folder does not exist"));
  set_text(folder() / "file", "");
  EXPECT_THAT(write_to(folder() / "file" / "trace"), HasSubstr("cannot be written"));
}

TEST_F(Trace, AFolderThatIsNoTraceIsRefused) {
  const auto read = [&] { return error_of([&] { TraceReader reader(folder()); }); };
  EXPECT_THAT(read(), HasSubstr("is no trace"));
  fs::create_directory(folder());
  EXPECT_THAT(read(), HasSubstr("is no trace"));
  set_text(folder() / "trace.toml", "complete = tru");
  EXPECT_THAT(read(), HasSubstr("trace.toml:1:"));
  set_text(folder() / "trace.toml", "complete = true\nformat = 2\ndt_s = 0.001\n");
  EXPECT_THAT(read(), HasSubstr("format 2"));
  for (const char* no_whole_number : {"1.0", "1e308", "-1e308", "nan", "9223372036854775807", "true", "\"1\""}) {
    set_text(folder() / "trace.toml", std::string("complete = true\nformat = ") + no_whole_number + "\ndt_s = 0.001\n");
    EXPECT_THAT(read(), HasSubstr("this palpa reads format 1")) << no_whole_number;
  }
  set_text(folder() / "trace.toml", "complete = true\nformat = 1\n");
  EXPECT_THAT(read(), HasSubstr("dt_s"));
  set_text(folder() / "trace.toml", "complete = true\nformat = 1\ndt_s = 0.001\n");
  EXPECT_THAT(read(), HasSubstr("scene.toml"));
}

TEST_F(Trace, BadRowsAreNamedByFileAndLine) {
  {
    TraceWriter writer(folder(), {}, scene, {});
    write_plain(writer, 0, 3);
    writer.finish();
  }
  const std::string good = text_of(folder() / "ticks.csv");
  const auto read_with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    set_text(folder() / "ticks.csv", text);
    return error_of([&] { TraceReader(folder()).ticks(); });
  };
  EXPECT_THAT(read_with("\n1,0.001,", "\n1,0.001x,"), AllOf(HasSubstr("ticks.csv:3: "), HasSubstr("'0.001x'")));
  EXPECT_THAT(read_with("\n1,0.001,", "\n1,,"), HasSubstr("ticks.csv:3: "));
  EXPECT_THAT(read_with("\n1,0.001,", "\n1,7,0.001,"), HasSubstr("ticks.csv:3: has 44 cells; the header has 43"));
  EXPECT_THAT(read_with("resting", "sleeping"), AllOf(HasSubstr("ticks.csv:2: "), HasSubstr("'sleeping'")));
  EXPECT_THAT(read_with("force_y_n", "force_y_lb"), AllOf(HasSubstr("ticks.csv:1: "), HasSubstr("'force_y_n' is missing")));
  EXPECT_THAT(read_with(good, std::string(3'000'000, 'x')), HasSubstr("ticks.csv:1: the line is longer"));
}

TEST_F(Trace, RecordingsFromBeforeTheEnergyTableAreStillRead) {
  fs::create_directories(folder());
  for (const char* name : {"new", "old"}) {
    TraceWriter writer(folder() / name, {}, scene, {});
    write_plain(writer, 0, 5);
    writer.finish();
  }
  const std::string whole = text_of(folder() / "old/ticks.csv");
  std::string cut;
  for (std::size_t at = 0; at < whole.size();) {
    std::string line = whole.substr(at, whole.find('\n', at) - at);
    at += line.size() + 1;
    for (int column = 0; column < 4; ++column) line.erase(line.rfind(','));
    cut += line + "\n";
  }
  set_text(folder() / "old/ticks.csv", cut);
  const TraceReader old(folder() / "old");
  EXPECT_FALSE(old.tells_energy());
  EXPECT_TRUE(TraceReader(folder() / "new").tells_energy());
  ASSERT_EQ(old.ticks().size(), 5u);
  EXPECT_EQ(old.ticks()[3].frame.result.proxy_m, TraceReader(folder() / "new").ticks()[3].frame.result.proxy_m);
  EXPECT_TRUE(compare_traces(folder() / "old", folder() / "new").same);
}

// A limit on file size stands for a full disk: write fails in the same way.
class SmallFiles {
 public:
  explicit SmallFiles(rlim_t bytes) {
    old_handler_ = ::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &old_);
    const rlimit small{bytes, old_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
  }
  ~SmallFiles() {
    ::setrlimit(RLIMIT_FSIZE, &old_);
    ::signal(SIGXFSZ, old_handler_);
  }

 private:
  rlimit old_{};
  void (*old_handler_)(int);
};

TEST_F(Trace, AFullDiskIsSaidAndLeavesATraceThatIsNotComplete) {
  TraceWriter writer(folder(), {}, scene, {"a", "b"});
  std::string said;
  std::string said_at_finish;
  {
    const SmallFiles full(20'000);
    said = error_of([&] { write_plain(writer, 0, 100'000); });
    said_at_finish = error_of([&] { writer.finish(); });
  }
  EXPECT_THAT(said, AllOf(HasSubstr("cannot be written (File too large); make room")));
  EXPECT_EQ(said_at_finish, said);
  const TraceReader reader(folder());
  EXPECT_FALSE(reader.header().complete);
  EXPECT_GT(reader.ticks().size(), 10u);
}

TEST_F(Trace, AFullDiskAtTheLastMomentIsSaidByFinish) {
  TraceWriter writer(folder(), {}, scene, {"a", "b"});
  write_plain(writer, 0, 100);
  {
    const SmallFiles full(10'000);
    EXPECT_THAT(error_of([&] { writer.finish(); }), HasSubstr("cannot be written"));
  }
  EXPECT_FALSE(TraceReader(folder()).header().complete);
}

TEST_F(Trace, NothingIsLeftWhereNotEvenTheBeginningFits) {
  const SmallFiles full(10);
  EXPECT_THAT(error_of([&] { TraceWriter(folder(), {}, scene, {}); }), HasSubstr("cannot be written"));
  EXPECT_FALSE(fs::exists(folder()));
}

// ---- traces that were cut off, and comparison ----

class Comparison : public Trace {
 protected:
  void record(const std::string& name, std::int64_t ticks, bool finish = true) {
    TraceWriter writer(folder(name), {}, scene, {"a", "b"});
    write_plain(writer, 0, ticks);
    if (finish) writer.finish();
  }
  void cut(const std::string& name, const char* file, std::size_t bytes) { fs::resize_file(folder(name) / file, bytes); }
  TraceDifference compare() { return compare_traces(folder("recorded"), folder("again")); }
};

TEST_F(Comparison, ATraceIsTheSameAsItsTwin) {
  record("recorded", 50);
  record("again", 50);
  set_text(folder("again") / "timing.csv", "other clocks\n");
  const TraceDifference difference = compare();
  EXPECT_TRUE(difference.same) << difference.where;
  EXPECT_EQ(difference.ticks, 50);
}

TEST_F(Comparison, ADifferenceIsNamedByFileLineAndColumn) {
  record("recorded", 50);
  record("again", 50);
  for (const auto& [file, from, to, where] :
       {std::tuple{"ticks.csv", "\n20,0.02,0.001,0,0.02,", "\n20,0.02,0.001,0,0.25,",
                   "ticks.csv:22: column probe_y_m: 0.02 against 0.25"},
        std::tuple{"modes.csv", "\n7,b,0,0,0,0,0,0,1", "\n7,b,0,0,0,0,0,0,0", "modes.csv:17: column split_shared: 1 against 0"},
        std::tuple{"scene.toml", "byte", "BYTE", "scene.toml"}}) {
    const std::string good = text_of(folder("again") / file);
    std::string bad = good;
    ASSERT_NE(bad.find(from), std::string::npos);
    bad.replace(bad.find(from), std::strlen(from), to);
    set_text(folder("again") / file, bad);
    EXPECT_FALSE(compare().same);
    EXPECT_THAT(compare().where, HasSubstr(where));
    set_text(folder("again") / file, good);
  }
  EXPECT_TRUE(compare().same);
}

TEST_F(Comparison, ACompleteTraceMustEndWhereItsTwinEnds) {
  record("recorded", 50);
  record("again", 49);
  EXPECT_THAT(compare().where, HasSubstr("ticks.csv:51: the recording goes on"));
  fs::remove_all(folder("again"));
  record("again", 51);
  EXPECT_THAT(compare().where, HasSubstr("ticks.csv:52: the recording ends"));
}

TEST_F(Comparison, AnUnfinishedTraceIsReadAndComparedToItsLastWholeLine) {
  record("recorded", 50, false);
  record("again", 50);
  EXPECT_FALSE(TraceReader(folder("recorded")).header().complete);
  const std::string whole = text_of(folder("recorded") / "ticks.csv");
  // The very end, in the middle of a row, just behind a row, in the header, and nothing at all.
  for (std::size_t bytes = 0; bytes <= whole.size(); bytes += bytes < 600 ? 1 : 37) {
    set_text(folder("recorded") / "ticks.csv", whole.substr(0, bytes));
    const std::int64_t lines = std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(bytes), '\n');
    const std::int64_t ticks = std::max<std::int64_t>(0, lines - 1);
    ASSERT_EQ(TraceReader(folder("recorded")).ticks().size(), static_cast<std::size_t>(ticks));
    const TraceDifference difference = compare();
    ASSERT_TRUE(difference.same) << difference.where;
    ASSERT_EQ(difference.ticks, ticks);
  }
}

TEST_F(Comparison, AnUnfinishedTraceOfWhichOtherFilesWentFurtherIsComparedToItsLastTick) {
  record("recorded", 50, false);
  record("again", 20);
  cut("recorded", "ticks.csv", text_of(folder("again") / "ticks.csv").size());
  EXPECT_TRUE(compare().same) << compare().where;
  // What was felt again has to reach as far, though.
  fs::remove_all(folder("again"));
  record("again", 19);
  EXPECT_FALSE(compare().same);
}

TEST_F(Comparison, AnUnfinishedTraceWithoutAnyCsvIsTheSameAsAny) {
  record("recorded", 3, false);
  record("again", 0);
  for (const char* file : {"ticks.csv", "modes.csv", "events.csv", "timing.csv"}) fs::remove(folder("recorded") / file);
  EXPECT_TRUE(compare().same) << compare().where;
  EXPECT_EQ(compare().ticks, 0);
}

TEST_F(Comparison, ACompleteTraceThatLostAFileIsDifferent) {
  record("recorded", 3);
  record("again", 3);
  fs::remove(folder("recorded") / "modes.csv");
  EXPECT_THAT(compare().where, HasSubstr("modes.csv: is missing"));
}

}  // namespace trace_test
}  // namespace palpa
