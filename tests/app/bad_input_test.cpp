// Wrong input: exit code, one-line error with remedy, no leftover output.
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "program.h"

namespace palpa {
namespace bad_input_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

class BadInput : public ProgramTest {
 protected:
  /// A refused run must leave no trace.
  void expect_scene_refused(const std::string& scene, const std::vector<std::string>& pieces) const {
    expect_refusal({"run", scene, "--hand", "sim:press", "--duration-s", "0.1", "--out", "trace"}, pieces);
    EXPECT_FALSE(fs::exists(folder / "trace")) << scene;
  }
};

TEST_F(BadInput, CommandLine) {
  write_scene("scene.toml");
  expect_refusal({"replya"}, {"'replya'", "did you mean 'replay'?"});
  expect_refusal({"exhale"}, {"'exhale'"});
  expect_refusal({"run"}, {"SCENE"});
  expect_refusal({"run", "scene.toml"}, {"--hand"});
  expect_refusal({"run", "scene.toml", "--hnad", "sim:press"}, {"'--hnad'", "did you mean '--hand'?"});
  expect_refusal({"run", "scene.toml", "--hand", "sim:press", "--duratoin-s", "3"},
                 {"'--duratoin-s'", "did you mean '--duration-s'?"});
  expect_refusal({"run", "scene.toml", "--hand", "sim:press", "--device", "phantom"}, {"device: no preset 'phantom'", "touch"});
  expect_refusal({"run", "scene.toml", "--hand", "sim:press", "--device", "touch,step=1"}, {"'step'", "encoder_step_m"});
  expect_refusal({"run", "scene.toml", "--hand", "sim:press", "--device", "touch,encoder_step_m=55um"}, {"'55um'", "metres"});
  expect_refusal({"demo", "--device", "phantom"}, {"device: no preset 'phantom'"});
  expect_refusal({"run", "scene.toml", "other.toml", "--hand", "sim:press"}, {"'other.toml'", "one argument too many"});
  expect_refusal({"run", "scene.toml", "--hand", "sim:press", "--rate-hz", "fast"}, {"--rate-hz", "fast"});
  expect_refusal({"run", "scene.toml", "--hand", "sim:press", "--rate-hz", "0"}, {"rate"});
  expect_refusal({"run", "scene.toml", "--hand", "sim:press", "--rate-hz", "nan"}, {"rate"});
  expect_refusal({"run", "scene.toml", "--hand", "sim:press", "--duration-s", "-1"}, {"duration"});
  expect_refusal({"run", "scene.toml", "--hand", "sim:press", "--duration-s", "inf"}, {"duration"});
  expect_refusal({"run", "scene.toml", "--hand", "sim:press", "--hand-hold", "loose"}, {"--hand-hold", "loose"});
  expect_refusal({"run", "scene.toml", "--hand", "sim:press", "--hand-center", "maybe"}, {"--hand-center"});
  expect_refusal({"demo", "heart"}, {"heart"});
  expect_refusal({"demo", "--data", "nowhere"}, {"nowhere"});
  expect_refusal({"modes", "viscocity"}, {"did you mean 'viscosity'?"});
  expect_refusal({"info"}, {"FILE"});
  expect_refusal({"info", "scene.toml", "--at-m", "1,2"}, {"X,Y,Z"});
  expect_refusal({"info", "scene.toml", "--at-m", "1,2,3,4"}, {"X,Y,Z"});
  expect_refusal({"info", "scene.toml", "--at-m", "nan,0,0"}, {"finite"});
  expect_refusal({"info", "nowhere.nrrd"}, {"nowhere.nrrd"});
  expect_refusal({"replay"}, {"TRACE"});
  expect_refusal({"replay", "nowhere"}, {"nowhere"});
  expect_refusal({"--print", "nonsense"}, {"'nonsense'", "man, bash"});
}

TEST_F(BadInput, Scenes) {
  expect_scene_refused("missing.toml", {"missing.toml"});
  write("empty.toml", "");
  expect_scene_refused("empty.toml", {"empty.toml"});
  write("text.toml", "This is a letter to my aunt.\nIt is no scene.\n");
  expect_scene_refused("text.toml", {"text.toml:1:"});
  write("binary.toml", std::string("\0\1\2\377\376", 5));
  expect_scene_refused("binary.toml", {"binary.toml"});
  fs::create_directory(folder / "folder.toml");
  expect_scene_refused("folder.toml", {"folder.toml"});
  write("scan.mhd", "ObjectType = Image\nNDims = 3\n");
  expect_scene_refused("scan.mhd", {"scan.mhd: no scene", "palpa info scan.mhd --scene"});

  const auto expect_change_refused = [&](const std::string& from, const std::string& to,
                                         const std::vector<std::string>& pieces) {
    write_scene("scene.toml", from, to);
    expect_scene_refused("scene.toml", pieces);
  };
  expect_change_refused("strength_n = 0.8", "strenght_n = 0.8",
                        {"scene.toml:16:", "'strenght_n'", "did you mean 'strength_n'?"});
  expect_change_refused("stiffness_n_per_m = 800", "stiffness_n_per_m = \"stiff\"", {"scene.toml:4:", "stiffness_n_per_m"});
  expect_change_refused("stiffness_n_per_m = 800", "stiffness_n_per_m = nan", {"stiffness"});
  expect_change_refused("strength_n = 0.8", "strength_n = -0.8", {"scene.toml:16:", "-0.8"});
  expect_change_refused("type = \"surface_and_friction\"", "type = \"surfaces\"", {"'surfaces'"});
  expect_change_refused("type = \"surface_and_friction\"", "type = \"vortex_sheet\"", {"'vortex_sheet'"});
  expect_change_refused("field = \"head\"", "field = \"haed\"", {"haed", "head"});
  expect_change_refused("analytic = \"head_phantom\"", "analytic = \"heart\"", {"heart"});
  expect_change_refused("analytic = \"head_phantom\"", "file = \"nowhere.nrrd\"", {"nowhere.nrrd"});
  expect_change_refused("palpa = 1", "palpa = 99", {"99"});
  expect_change_refused("title = \"phantom\"", "[law]\nmethod = \"paper-2007\"", {"paper-2007"});

  write("modeless.toml", "palpa = 1\n[volume.head]\nanalytic = \"head_phantom\"\n");
  expect_scene_refused("modeless.toml", {"mode"});
}

TEST_F(BadInput, Settings) {
  write_scene("scene.toml");
  const auto expect_set_refused = [&](const std::string& set, const std::vector<std::string>& pieces) {
    expect_refusal({"run", "scene.toml", "--hand", "sim:press", "--duration-s", "0.1", "--out", "trace", "--set", set}, pieces);
    EXPECT_FALSE(fs::exists(folder / "trace")) << set;
  };
  expect_set_refused("coupling.stiffness_n_per_m", {"coupling.stiffness_n_per_m=500"});
  expect_set_refused("=5", {"--set"});
  expect_set_refused("coupling.stifness_n_per_m=500", {"stifness_n_per_m", "did you mean"});
  expect_set_refused("coupling.stiffness_n_per_m=much", {"must be a number"});
  expect_set_refused("mode.bone.friction_n=1", {"bone"});
  expect_set_refused("mode.surface.level.skin.strength_n=-1", {"-1"});
}

TEST_F(BadInput, Hands) {
  write_scene("scene.toml");
  const auto expect_hand_refused = [&](const std::string& hand, const std::vector<std::string>& pieces) {
    expect_refusal({"run", "scene.toml", "--hand", hand, "--out", "trace"}, pieces);
    EXPECT_FALSE(fs::exists(folder / "trace")) << hand;
  };
  expect_hand_refused("nowhere.csv", {"nowhere.csv"});
  write("empty.csv", "");
  expect_hand_refused("empty.csv", {"empty.csv"});
  write("columns.csv", "time,force\n0,1\n1,2\n");
  expect_hand_refused("columns.csv", {"columns.csv", "t_s,x_m,y_m,z_m"});
  write("untimed.csv", "x,y,z\n0,0,0.1\n0,0,0.09\n");
  expect_hand_refused("untimed.csv", {"untimed.csv", "hand-rate-hz"});
  write("word.csv", "t_s,x_m,y_m,z_m\n0,0,0,0.1\n0.1,0,zero,0.1\n");
  expect_hand_refused("word.csv", {"word.csv:3"});
  expect_hand_refused("sim:jump", {"jump", "sim:press|stroke|circle|helix|random"});
  expect_hand_refused("sim:press,speed_m_per_s=fast", {"fast"});
  expect_hand_refused("sim:press,sped=1", {"sped"});
}

TEST_F(BadInput, OutputFolders) {
  write_scene("scene.toml");
  const auto expect_out_refused = [&](const std::string& out, const std::vector<std::string>& pieces) {
    expect_refusal({"run", "scene.toml", "--hand", "sim:press", "--duration-s", "0.1", "--out", out}, pieces);
  };
  fs::create_directory(folder / "there");
  write("there/mine", "kept");
  expect_out_refused("there", {"there: exists already"});
  EXPECT_EQ(read(folder / "there/mine"), "kept");
  write("file", "kept");
  expect_out_refused("file", {"file: exists already"});
  expect_out_refused("no/trace", {"no/trace"});
  expect_out_refused("file/trace", {"file/trace"});
  if (::geteuid() != 0) {  // root may write anywhere
    fs::create_directory(folder / "locked");
    ::chmod((folder / "locked").c_str(), 0500);
    expect_out_refused("locked/trace", {"locked/trace"});
    ::chmod((folder / "locked").c_str(), 0700);
  }
  expect_out_refused("/proc/trace", {"/proc"});
}

TEST_F(BadInput, VolumesWithoutAReaderSayHowToGetOne) {
  write_scene("scene.toml", "analytic = \"head_phantom\"", "file = \"head.nrrd\"");
  write("head.nrrd", "This is a letter to my aunt.\n");
  expect_scene_refused("scene.toml", {"head.nrrd"});
  expect_refusal({"run", "scene.toml", "--hand", "sim:press", "--reader", "/nowhere/palpa-read"}, {"palpa-read"});
}

TEST_F(BadInput, AFullDiskLeavesATraceThatSaysItIsIncomplete) {
  write_scene("scene.toml");
  // A limit on the size of files stands for a full disk.
  const std::string command = "cd " + folder.string() + " && trap '' XFSZ && ulimit -f 64 && " + PALPA_PROGRAM +
                              " run scene.toml --hand sim:stroke --duration-s 5 --out trace >out 2>err";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 2);
  const std::string err = read(folder / "err");
  EXPECT_THAT(err, StartsWith("palpa: "));
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
  EXPECT_THAT(read(folder / "trace/trace.toml"), HasSubstr("complete = false"));
}

bool handles(pid_t process, int signal) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("SigCgt:")) return (std::stoull(line.substr(7), nullptr, 16) >> (signal - 1)) & 1;
  }
  return false;
}

TEST_F(BadInput, WhatDrawsGivesUpInWords) {
  if (!fs::exists(fs::path(PALPA_PROGRAM).parent_path() / "../libexec/palpa/palpa-pictures.so"))
    GTEST_SKIP() << "no pictures are built";
  write_scene("scene.toml");
  ASSERT_EQ(palpa({"run", "scene.toml", "--hand", "sim:press", "--duration-s", "0.2", "--out", "trace"}).code, 0);
  // As a library does on exhausted memory, at any moment.
  for (const int signal : {SIGABRT, SIGSEGV}) {
    const pid_t process = start({"report", "trace", "--out", "page.html"});
    for (int n = 0; n < 20'000 && !handles(process, signal); ++n) ::usleep(1000);
    ::kill(process, signal);
    const Ended ended = wait(process);
    EXPECT_EQ(ended.code, 2) << ended.err;
    EXPECT_THAT(ended.err, testing::EndsWith(", or if there is enough, report this as a bug of Palpa\n"));
    EXPECT_THAT(ended.err, HasSubstr("\npalpa: pictures: "));
    for (const auto& entry : fs::directory_iterator(folder))
      EXPECT_THAT(entry.path().string(), Not(HasSubstr("page"))) << entry;
  }
}

TEST_F(BadInput, ASceneCannotNameAFileThatIsNoUtf8) {
  const std::string name = "\xff.nrrd";
  write(name, "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n\n" + std::string(32, '\x01') +
                  std::string(32, '\x64'));
  EXPECT_EQ(palpa({"info", name}).code, 0);
  expect_refusal({"info", name, "--scene", "scene.toml"}, {"UTF-8", "rename it"});
  EXPECT_FALSE(fs::exists(folder / "scene.toml"));
}

}  // namespace bad_input_test
}  // namespace palpa
