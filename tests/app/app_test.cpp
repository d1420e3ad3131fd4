// Program runs without errors.
#include <gmock/gmock.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "palpa/trace/trace.h"
#include "program.h"
#include "tests/shared_data.h"

namespace palpa {
namespace app_test {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;

class Program : public ProgramTest {};

TEST_F(Program, SaysItsVersionAndHelpsWithAnExamplePerCommand) {
  EXPECT_THAT(palpa({"--version"}).out, testing::MatchesRegex("palpa [0-9]+\\.[0-9]+\\.[0-9]+\n"));
  const Ended help = palpa({"--help"});
  EXPECT_EQ(help.code, 0);
  for (const char* command : {"demo", "run", "info", "replay", "modes"}) {
    EXPECT_THAT(help.out, HasSubstr(command));
    const Ended of_command = palpa({command, "--help"});
    EXPECT_EQ(of_command.code, 0);
    EXPECT_THAT(of_command.out, HasSubstr(std::string("\n  palpa ") + command)) << "an example";
    EXPECT_THAT(of_command.err, IsEmpty());
  }
}

TEST_F(Program, AFileMayHaveTheNameOfACommand) {
  write_scene("map");
  EXPECT_EQ(palpa({"run", "map", "--hand", "sim:press", "--duration-s", "0.05", "--out", "report"}).code, 0);
  EXPECT_EQ(palpa({"replay", "report"}).code, 0);
}

TEST_F(Program, SaysWhatItWroteAndRefusesOtherEndings) {
  write_scene("scene.toml");
  ASSERT_EQ(palpa({"run", "scene.toml", "--hand", "sim:press", "--duration-s", "0.05", "--out", "trace"}).code, 0);
  const Ended exported = palpa({"export", "trace", "felt.csv"});
  EXPECT_EQ(exported.code, 0) << exported.err;
  EXPECT_THAT(exported.err, testing::AllOf(HasSubstr("Wrote felt.csv: 50 ticks, "), HasSubstr("B\n")));
  for (const char* name : {"page", "page.htm", "page.html.txt"})
    expect_refusal({"report", "trace", "--out", name}, {name, "has an ending of no format that is written; name it .html"});
  for (const char* name : {"margin", "margin.jpg"})
    expect_refusal({"check", "scene.toml", "--device", "touch", "--picture", name}, {name, "name it .png"});
}

TEST_F(Program, HelpsWhoeverAsksForNothing) {
  const Ended bare = palpa({});
  EXPECT_EQ(bare.code, 0);
  EXPECT_EQ(bare.out, palpa({"--help"}).out);
  EXPECT_THAT(bare.err, IsEmpty());
}

TEST_F(Program, DemoFeelsTheEmbeddedHead) {
  const Ended demo = palpa({"demo"});
  EXPECT_EQ(demo.code, 0) << demo.err;
  EXPECT_THAT(demo.err, IsEmpty());
  EXPECT_THAT(demo.out, testing::AllOf(HasSubstr("surface_and_friction"), HasSubstr("Try next:"), HasSubstr("palpa replay")));

  const json summary = json::parse(palpa({"demo", "head", "--json"}).out);
  EXPECT_EQ(summary["ticks"], 10000);
  EXPECT_GE(summary["modes"][0]["contact_share"].get<double>(), 0.3);
  EXPECT_LE(summary["modes"][0]["contact_share"].get<double>(), 0.9);
  EXPECT_TRUE(summary["first_break_through_s"].is_null() || summary["first_break_through_s"].get<double>() > 1.0);
}

TEST_F(Program, DemoFeelsTheRealHeadUnderARecordedHand) {
  const fs::path data = test::shared_data();
  if (!fs::exists(data / "ct_head_cranium")) GTEST_SKIP() << "the real data are not here: " << data;
  if (!fs::exists(fs::path(PALPA_PROGRAM).parent_path() / "palpa-read")) GTEST_SKIP() << "palpa-read is not built";
  const Ended demo = palpa({"demo", "--data", data, "--json"});
  ASSERT_EQ(demo.code, 0) << demo.err;
  const json summary = json::parse(demo.out);
  EXPECT_GT(summary["duration_s"].get<double>(), 20.0);
  EXPECT_GE(summary["modes"][0]["contact_share"].get<double>(), 0.3);
  EXPECT_LE(summary["modes"][0]["contact_share"].get<double>(), 0.9);
  EXPECT_TRUE(summary["first_break_through_s"].is_null() || summary["first_break_through_s"].get<double>() > 1.0);
}

TEST_F(Program, DemoFeelsTheHeadThatWasBroughtForIt) {
  const fs::path head = test::shared_data("ct_head_cranium");
  if (!fs::exists(head)) GTEST_SKIP() << "the real data are not here: " << head;
  if (!fs::exists(fs::path(PALPA_PROGRAM).parent_path() / "palpa-read")) GTEST_SKIP() << "palpa-read is not built";
  fs::create_directories(folder / "home/.local/share/palpa");
  fs::copy(head, folder / "home/.local/share/palpa/ct_head_cranium");
  const Environment home{{"HOME", folder / "home"}, {"XDG_DATA_HOME", ""}, {"PALPA_DATA", ""}};
  const Ended demo = palpa({"demo", "head", "--json"}, home);
  ASSERT_EQ(demo.code, 0) << demo.err;
  const json summary = json::parse(demo.out);
  EXPECT_GE(summary["modes"][0]["contact_share"].get<double>(), 0.3);
  EXPECT_LT(summary["force_max_n"].get<double>(), 7.0);
  EXPECT_EQ(json::parse(palpa({"demo", "flow", "--json"}, home).out)["ticks"], 10000) << "the flow stays embedded";
}

TEST_F(Program, ConvertsAndSuggestsAScene) {
  const fs::path file = test::shared_data("mra_avf_nrrd/avf_float_32.nrrd");
  if (!fs::exists(file)) GTEST_SKIP() << "the real data are not here: " << file;
  if (!fs::exists(fs::path(PALPA_PROGRAM).parent_path() / "palpa-read")) GTEST_SKIP() << "palpa-read is not built";
  const Ended convert = palpa({"convert", file, "small.nrrd", "--downsample", "2", "--crop", "0:73,10:92,0:19", "--int16"});
  EXPECT_EQ(convert.code, 0) << convert.err;
  EXPECT_THAT(convert.out, IsEmpty());
  const json info = json::parse(palpa({"info", "small.nrrd", "--json"}).out);
  EXPECT_EQ(info["fields"][0]["dims"], json::parse("[37, 41, 10]"));
  EXPECT_EQ(info["fields"][0]["type"], "int16");
  EXPECT_EQ(palpa({"convert", file, "small.nrrd"}).code, 2) << "nothing is written over";
  EXPECT_EQ(palpa({"convert", file, "other.nrrd", "--crop", "1:2,3:4"}).code, 2);

  const Ended scene = palpa({"info", "small.nrrd", "--scene"});
  EXPECT_EQ(scene.code, 0) << scene.err;
  EXPECT_EQ(palpa({"info", "small.nrrd", "--scene", "first.toml"}).out, "");
  EXPECT_EQ(read(folder / "first.toml"), scene.out);
  EXPECT_EQ(palpa({"info", "small.nrrd", "--scene", "first.toml"}).code, 2) << "nothing is written over";
  EXPECT_EQ(palpa({"info", "--scene", "small.nrrd"}).out, scene.out);
  const Ended felt = palpa({"run", "first.toml", "--hand", "sim:stroke", "--duration-s", "1", "--json"});
  EXPECT_EQ(felt.code, 0) << felt.err;
}

TEST_F(Program, RunsRecordsAndReplays) {
  write_scene("scene.toml");
  const Ended run = palpa({"run", "scene.toml", "--hand", "sim:stroke", "--duration-s", "1.5", "--out", "trace", "--primitives",
                           "--set", "mode.surface.level.skin.strength_n=1.5"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.err, IsEmpty()) << "silent in a pipe";
  EXPECT_THAT(run.out, HasSubstr("1 500 (1.500 s"));
  EXPECT_THAT(TraceReader(folder / "trace").header().arguments,
              testing::ElementsAre("run", "scene.toml", "--hand", "sim:stroke", "--duration-s", "1.5", "--out", "trace",
                                   "--primitives", "--set", "mode.surface.level.skin.strength_n=1.5"));

  const Ended same = palpa({"replay", "trace"});
  EXPECT_EQ(same.code, 0) << same.err;
  EXPECT_EQ(same.out, "identical in all 1500 ticks\n");
  EXPECT_EQ(json::parse(palpa({"replay", "trace", "--json"}).out)["same"], true);
  EXPECT_EQ(palpa({"replay", "trace/trace.toml"}).out, same.out) << "a trace by a file in it";
  EXPECT_THAT(run.out, testing::AllOf(HasSubstr("Recorded in trace\n"), HasSubstr("palpa report trace\n")));

  std::string ticks = read(folder / "trace/ticks.csv");
  ticks.replace(ticks.rfind('\n', ticks.size() - 2) + 1, 4, "9999");
  write("trace/ticks.csv", ticks);
  const Ended differs = palpa({"replay", "trace"});
  EXPECT_EQ(differs.code, 1);
  EXPECT_THAT(differs.out, HasSubstr("differs at "));
}

TEST_F(Program, ExportsWhatWasFelt) {
  write_scene("scene.toml");
  ASSERT_EQ(palpa({"run", "scene.toml", "--hand", "sim:press", "--duration-s", "0.2", "--out", "trace"}).code, 0);
  const Ended made = palpa({"export", "trace/ticks.csv", "felt.csv"});
  EXPECT_EQ(made.code, 0) << made.err;
  EXPECT_EQ(made.out, "");
  EXPECT_THAT(made.err, testing::StartsWith("Wrote felt.csv: 200 ticks, "));
  EXPECT_THAT(read(folder / "felt.csv"), testing::StartsWith("tick,t_s,proxy_x_m,"));
  const Ended again = palpa({"export", "trace", "felt.csv"});
  EXPECT_EQ(again.code, 2);
  EXPECT_EQ(again.err, "palpa: felt.csv: exists already; name a new file, or have it replaced (--force)\n");
  EXPECT_EQ(palpa({"export", "trace", "felt.csv", "--force"}).code, 0);
  EXPECT_THAT(palpa({"export", "trace", "felt.pdf"}).err, HasSubstr("felt.pdf: has an ending of no format that is written"));
}

TEST_F(Program, EnergyHasTheSameEntriesInRunAndReplay) {
  write_scene("scene.toml");
  const json run =
      json::parse(palpa({"run", "scene.toml", "--hand", "sim:stroke", "--out", "trace", "--json"}).out)["energy_j"];
  for (const char* entry : {"hand", "guard_held_back", "data", "ticks"}) EXPECT_TRUE(run["in"][entry].is_number()) << entry;
  for (const char* entry : {"surface", "let_go", "damper", "spring"}) EXPECT_TRUE(run["out"][entry].is_number()) << entry;
  EXPECT_EQ(json::parse(palpa({"replay", "trace", "--json"}).out)["energy_j"], run);
}

TEST_F(Program, DryRunChecksAndFeelsNothing) {
  write_scene("scene.toml");
  const Ended dry = palpa({"run", "scene.toml", "--hand", "sim:press", "--out", "trace", "--dry-run"});
  EXPECT_EQ(dry.code, 0) << dry.err;
  EXPECT_THAT(dry.out, testing::AllOf(HasSubstr("phantom"), HasSubstr("800 N/m"), HasSubstr("surface"), HasSubstr("head")));
  EXPECT_FALSE(fs::exists(folder / "trace"));
  const json what = json::parse(palpa({"run", "scene.toml", "--hand", "sim:press", "--dry-run", "--json"}).out);
  EXPECT_EQ(what["stiffness_n_per_m"], 800);
  EXPECT_EQ(what["duration_s"], 10);

  write_scene("wrong.toml", "strength_n", "strenght_n");
  EXPECT_EQ(palpa({"run", "wrong.toml", "--hand", "sim:press", "--dry-run"}).code, 2);
}

// A wall of one voxel is lost by the smooth filter: a warning where that is the default, a note where the scene names it.
TEST_F(Program, RunNamesAWallOfOneVoxelUnderANamedFilter) {
  std::string voxels;
  for (int v = 0; v < 12 * 12 * 12; ++v) voxels += v / 144 == 6 ? "900\n" : v / 144 < 3 ? "800\n" : "0\n";
  write("wall.nrrd",
        "NRRD0004\ntype: short\ndimension: 3\nsizes: 12 12 12\nencoding: ascii\n"
        "space: left-posterior-superior\nspace directions: (5,0,0) (0,5,0) (0,0,5)\nspace origin: (0,0,0)\n"
        "space units: \"mm\" \"mm\" \"mm\"\n\n" +
            voxels);
  const auto dry = [&](const std::string& filter) {
    write("wall.toml",
          "palpa = 1\n[volume.wall]\nfile = 'wall.nrrd'\n" + filter +
              "\n[[mode]]\nname = 's'\ntype = 'surface_and_friction'\nfield = 'wall'\n[[mode.level]]\nvalue = 700\n");
    return palpa({"run", "wall.toml", "--hand", "sim:press", "--dry-run"});
  };
  const auto lost = HasSubstr("% of the parts thinner than 2 voxels");
  const Ended by_default = dry(""), named = dry("filter = 'smooth'"), kept = dry("filter = 'trilinear'");
  ASSERT_EQ(by_default.code + named.code + kept.code, 0) << by_default.err << named.err << kept.err;
  EXPECT_THAT(by_default.err, lost);
  EXPECT_THAT(named.out, lost);
  EXPECT_THAT(named.err, testing::Not(lost));
  EXPECT_THAT(kept.out + kept.err, testing::Not(lost));
}

TEST_F(Program, ReadsARecordedHandInEveryWayItIsHeld) {
  write_scene("scene.toml");
  std::string rows = "x,y,z\n";
  for (int i = 0; i < 200; ++i) rows += "0.0," + std::to_string(0.0001 * i) + "," + std::to_string(0.09 - 0.0002 * i) + "\n";
  write("hand.csv", rows);
  for (const char* hold : {"rigid", "relaxed", "firm"}) {
    const Ended run = palpa({"run", "scene.toml", "--hand", "hand.csv", "--hand-rate-hz", "100", "--hand-center", "off",
                             "--hand-hold", hold, "--json"});
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_NEAR(json::parse(run.out)["duration_s"].get<double>(), 1.99, 0.011) << hold;
  }
}

TEST_F(Program, FeelsWithADeviceInTheHandAndReplaysIt) {
  write_scene("scene.toml");
  const Ended run = palpa(
      {"run", "scene.toml", "--hand", "sim:press", "--device", "touch,delay_ticks=1", "--duration-s", "1", "--out", "trace"});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("touch,delay_ticks=1: at most 3.3 N and 400 N/m, encoder step 55 um"));
  EXPECT_THAT(run.err, HasSubstr("--set coupling.stiffness_n_per_m=400"));
  EXPECT_EQ(palpa({"replay", "trace"}).code, 0);
  const json dry =
      json::parse(palpa({"run", "scene.toml", "--hand", "sim:press", "--device", "omega", "--dry-run", "--json"}).out);
  EXPECT_EQ(dry["device"], "omega");
}

TEST_F(Program, HelpNamesEveryDeviceAndEveryKeyOfIt) {
  write_scene("scene.toml");
  const std::string help = palpa({"run", "--help"}).out;
  for (const char* device : {"touch", "omega", "falcon", "inverse3", "desktop"}) {
    EXPECT_THAT(help, HasSubstr(std::string("\n  ") + device + " "));
    const Ended dry = palpa({"run", "scene.toml", "--hand", "sim:press", "--device", device, "--dry-run"});
    EXPECT_EQ(dry.code, 0) << dry.err;
  }
  for (const char* key : {"encoder_step_m", "max_force_n", "delay_ticks", "mass_kg", "damping_ns_per_m", "coulomb_friction_n",
                          "max_stiffness_n_per_m", "workspace_radius_m"}) {
    EXPECT_THAT(help, HasSubstr(std::string("\n  ") + key + " "));
    const Ended dry =
        palpa({"run", "scene.toml", "--hand", "sim:press", "--device", std::string("touch,") + key + "=?", "--dry-run"});
    EXPECT_THAT(dry.err, HasSubstr(std::string("cannot be used for ") + key));
  }
}

TEST_F(Program, ListsModesAndTheirParameters) {
  const Ended list = palpa({"modes"});
  EXPECT_EQ(list.code, 0);
  for (const char* type : {"surface_and_friction", "follow", "viscosity"}) EXPECT_THAT(list.out, HasSubstr(type));
  const Ended one = palpa({"modes", "surface_and_friction"});
  EXPECT_EQ(one.code, 0);
  for (const char* key : {"field", "solid", "strength_n", "friction_coefficient"}) EXPECT_THAT(one.out, HasSubstr(key));

  const json all = json::parse(palpa({"modes", "--json"}).out);
  ASSERT_EQ(all.size(), 10u);
  for (const json& mode : all) {
    EXPECT_EQ(json::parse(palpa({"modes", mode["type"], "--json"}).out), mode);
    for (const json& parameter : mode["parameters"]) {
      EXPECT_FALSE(parameter["sentence"].get<std::string>().empty());
      EXPECT_THAT(one.out.empty() ? "" : palpa({"modes", mode["type"]}).out, HasSubstr(parameter["name"].get<std::string>()));
    }
  }
}

TEST_F(Program, AnInterruptedRunIsCompleteAndReplays) {
  write_scene("scene.toml");
  const pid_t process = start({"run", "scene.toml", "--hand", "sim:stroke", "--duration-s", "1e6", "--out", "trace"});
  wait_for_ticks(folder / "trace");
  ASSERT_EQ(::kill(process, SIGINT), 0);
  const Ended run = wait(process);
  EXPECT_EQ(run.code, 130);
  EXPECT_THAT(run.err, IsEmpty());
  EXPECT_TRUE(TraceReader(folder / "trace").header().complete);
  const Ended replay = palpa({"replay", "trace"});
  EXPECT_EQ(replay.code, 0) << replay.out << replay.err;
}

TEST_F(Program, AKilledRunIsIncompleteAndReplays) {
  write_scene("scene.toml");
  const pid_t process = start({"run", "scene.toml", "--hand", "sim:stroke", "--duration-s", "1e6", "--out", "trace"});
  wait_for_ticks(folder / "trace");
  ASSERT_EQ(::kill(process, SIGKILL), 0);
  EXPECT_EQ(wait(process).code, 128 + SIGKILL);
  EXPECT_FALSE(TraceReader(folder / "trace").header().complete);
  const Ended replay = palpa({"replay", "trace"});
  EXPECT_EQ(replay.code, 0) << replay.out << replay.err;
}

TEST_F(Program, AMapThatIsInterruptedOrKilledGoesOnToTheSameBytes) {
  write_scene("scene.toml");
  const std::vector<std::string> map{"map", "scene.toml", "map.vti", "--points", "384", "--threads", "1"};
  Ended interrupted{.code = 0, .out = {}, .err = {}};
  for (int delay_ms = 160; interrupted.code == 0 && delay_ms > 0; delay_ms /= 2) {  // a fast machine may be done before
    fs::remove(folder / "map.vti");
    const pid_t first = start(map);
    std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
    ::kill(first, SIGINT);
    interrupted = wait(first);
  }
  EXPECT_EQ(interrupted.code, 130);
  EXPECT_THAT(interrupted.err, HasSubstr("map.vti.part"));
  ASSERT_TRUE(fs::exists(folder / "map.vti.part"));
  EXPECT_FALSE(fs::exists(folder / "map.vti"));

  const pid_t second = start(map);
  wait_for_words("going on");
  ASSERT_EQ(::kill(second, SIGKILL), 0);
  wait(second);
  ASSERT_TRUE(fs::exists(folder / "map.vti.part")) << "what was kept stays";
  EXPECT_FALSE(fs::exists(folder / "map.vti"));

  const Ended rest = palpa({"map", "scene.toml", "map.vti", "--points", "384", "--json"});
  ASSERT_EQ(rest.code, 0) << rest.err;
  EXPECT_THAT(rest.err, HasSubstr("going on"));
  const json summary = json::parse(rest.out);
  EXPECT_EQ(summary["points"], 384 * 384);
  EXPECT_LE(summary["points_felt_now"].get<int>(), 384 * 384);
  EXPECT_GT(summary["probes_per_s"].get<double>(), 0.0);
  EXPECT_FALSE(fs::exists(folder / "map.vti.part"));
  ASSERT_EQ(palpa({"map", "scene.toml", "whole.vti", "--points", "384"}).code, 0);
  EXPECT_TRUE(read(folder / "map.vti") == read(folder / "whole.vti"));
}

TEST_F(Program, AMapOfAnotherSceneBeginsAnewWithAWord) {
  write_scene("scene.toml");
  ASSERT_EQ(palpa({"map", "scene.toml", "one.vti", "--points", "12"}).code, 0);
  write("map.vti.part", "my notes");
  EXPECT_EQ(palpa({"map", "scene.toml", "map.vti", "--points", "12"}).code, 2) << "somebody else's file";
  EXPECT_EQ(read(folder / "map.vti.part"), "my notes");
  write("map.vti.part", "palpa: a map of forces that is not whole yet (1)\nof something else");
  const Ended map = palpa({"map", "scene.toml", "map.vti", "--points", "12"});
  EXPECT_EQ(map.code, 0) << map.err;
  EXPECT_THAT(map.err, HasSubstr("computed from the start"));
  EXPECT_TRUE(read(folder / "map.vti") == read(folder / "one.vti"));
  const Ended again = palpa({"map", "scene.toml", "map.vti", "--points", "12"});
  EXPECT_EQ(again.code, 2) << "nothing is written over";
  EXPECT_EQ(palpa({"map", "scene.toml", "map.vtk"}).code, 2);
  EXPECT_EQ(palpa({"map", "scene.toml", "m.vti", "--grid", "--picture", "m.png"}).code, 2);
  EXPECT_EQ(palpa({"map", "scene.toml", "m.vti", "--size-mm", "nan"}).code, 2);
}

}  // namespace app_test
}  // namespace palpa
