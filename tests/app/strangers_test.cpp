// Untrusted files: dangerous links, terminal controls, output targets.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "palpa/base/sanitized.h"
#include "palpa/base/utf8.h"
#include "program.h"

namespace palpa {
namespace strangers_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class Strangers : public ProgramTest {
 protected:
  Strangers() {
    write_scene("scene.toml");
    has_reader = fs::exists(fs::path(PALPA_PROGRAM).parent_path() / "palpa-read");
  }

  /// Runs the program; ends it after 30 s.
  Ended in_time(const std::vector<std::string>& arguments) const {
    const pid_t process = start(arguments);
    for (int waited_ms = 0; waited_ms < 30'000; waited_ms += 20) {
      siginfo_t ended{};
      ::waitid(P_PID, static_cast<id_t>(process), &ended, WEXITED | WNOHANG | WNOWAIT);
      if (ended.si_pid == process) return wait(process);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    ::kill(process, SIGKILL);
    return wait(process);
  }
  void expect_refused(const std::vector<std::string>& arguments, const std::string& words) const {
    const Ended ended = in_time(arguments);
    const std::string shown = testing::PrintToString(arguments);
    EXPECT_EQ(ended.code, 2) << shown << '\n' << ended.err;
    EXPECT_THAT(ended.err, testing::MatchesRegex("palpa: [^\n]*\n")) << shown;
    EXPECT_THAT(ended.err, HasSubstr(words)) << shown;
    EXPECT_THAT(ended.err, Not(HasSubstr("report this as a bug"))) << shown;
    EXPECT_LE(ended.err.size(), 500U) << shown;
    expect_nothing_steers(ended.err);
  }
  /// Expects no terminal control but line ends and tabs.
  static void expect_nothing_steers(std::string_view text) {
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t length = detail::utf8_length(text.substr(at));
      ASSERT_GT(length, 0U) << "no UTF-8: " << text.substr(at, 80);
      if (text[at] != '\n' && text[at] != '\t') {
        ASSERT_EQ(detail::steering_length(text.substr(at)), 0U) << text.substr(at, 80);
      }
      at += length;
    }
  }
  /// Records a short run of the scene; false on failure.
  bool has_trace(const std::string& name = "trace") const {
    return palpa({"run", "scene.toml", "--hand", "sim:press", "--duration-s", "0.2", "--out", name}).code == 0;
  }
  static bool has_pictures() {
    return fs::exists(fs::path(PALPA_PROGRAM).parent_path().parent_path() / "libexec/palpa/palpa-pictures.so");
  }
  /// A volume of zeros; `value` is the first voxel's.
  static std::string nrrd(char value) {
    return std::string("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspacings: 1 1 1\nencoding: raw\n\n") + value +
           std::string(63, '\0');
  }
  void make_pipe(const std::string& name) const { ASSERT_EQ(::mkfifo((folder / name).c_str(), 0600), 0); }

  bool has_reader = false;
};

TEST_F(Strangers, APipeIsNotWaitedFor) {
  make_pipe("pipe");
  make_pipe("pipe.toml");
  make_pipe("pipe.csv");
  expect_refused({"run", "pipe.toml", "--hand", "sim:press"}, "pipe.toml: is no ordinary file");
  expect_refused({"run", "pipe", "--hand", "sim:press"}, "pipe: is no ordinary file");
  expect_refused({"run", "scene.toml", "--hand", "pipe.csv"}, "pipe.csv: is no ordinary file");
  expect_refused({"run", "scene.toml", "--hand", "sim:press", "--plugin", "pipe"}, "pipe: is no file");
  expect_refused({"info", "pipe"}, "pipe: is no ordinary file");
  write("raw.toml",
        "palpa = 1\n[volume.a]\nfile = \"pipe\"\ntype = \"uint8\"\ndims = [4, 4, 4]\nspacing_m = [1, 1, 1]\n[[mode]]\nname = "
        "\"m\"\n"
        "type = \"viscosity\"\nfield = \"a\"\ndrag_ns_per_m = 1\n");
  expect_refused({"run", "raw.toml", "--hand", "sim:press"}, "is no ordinary file");
}

TEST_F(Strangers, APipeOrAFolderInATraceIsNotWaitedFor) {
  for (const char* name : {"trace.toml", "scene.toml", "ticks.csv"}) {
    for (const bool pipe : {true, false}) {
      ASSERT_TRUE(has_trace());
      fs::remove(folder / "trace" / name);
      const std::string place = std::string("trace/") + name;
      pipe ? make_pipe(place) : static_cast<void>(fs::create_directory(folder / place));
      expect_refused({"replay", "trace"}, place + (pipe ? ": is no ordinary file" : ": is a folder"));
      fs::remove_all(folder / "trace");
    }
  }
  // Without an end.
  ASSERT_TRUE(has_trace());
  fs::remove(folder / "trace/scene.toml");
  fs::create_symlink("/dev/zero", folder / "trace/scene.toml");
  expect_refused({"replay", "trace"}, "is no ordinary file");
}

TEST_F(Strangers, AReportGoesThroughNoLink) {
  if (!has_pictures()) GTEST_SKIP() << "built without pictures";
  ASSERT_TRUE(has_trace());
  write("victim", "");  // empty files may be replaced, even by a report
  fs::create_symlink("../victim", folder / "trace/report.html");
  fs::create_symlink("victim", folder / "out.html");
  fs::create_directory(folder / "pictures");
  for (const char* name : {"scene.png", "force.svg"}) fs::create_symlink("../victim", folder / "pictures" / name);
  expect_refused({"report", "trace"}, "trace/report.html: cannot be written: it is a link");
  expect_refused({"report", "trace", "--out", "out.html"}, "out.html: cannot be written: it is a link");
  expect_refused({"report", "trace", "--out", "out.html", "--force"}, "out.html: cannot be written: it is a link");
  fs::remove(folder / "trace/report.html");
  for (const char* force : {"", "--force"}) {
    std::vector<std::string> arguments{"report", "trace", "--out", "whole.html", "--pictures", "pictures"};
    if (*force) arguments.emplace_back(force);
    expect_refused(arguments, "pictures/");
    EXPECT_FALSE(fs::exists(folder / "whole.html"));
    EXPECT_EQ(read(folder / "victim"), "");
    EXPECT_TRUE(fs::is_symlink(folder / "pictures/scene.png"));
  }
}

TEST_F(Strangers, WhatIsThereIsReplacedOnlyByForce) {
  if (!has_reader) GTEST_SKIP() << "built without palpa-read";
  write("a.nrrd", nrrd('\x7f'));
  write("b.nrrd", "mine");
  write("b.toml", "mine");
  expect_refused({"convert", "a.nrrd", "b.nrrd"}, "b.nrrd: exists already");
  expect_refused({"info", "a.nrrd", "--scene", "b.toml"}, "b.toml: exists already");
  EXPECT_EQ(read(folder / "b.nrrd") + read(folder / "b.toml"), "minemine");
  EXPECT_EQ(palpa({"convert", "a.nrrd", "b.nrrd", "--force"}).code, 0);
  EXPECT_EQ(palpa({"info", "a.nrrd", "--scene", "b.toml", "--force"}).code, 0);
  EXPECT_EQ(palpa({"info", "b.nrrd"}).code, 0);
  EXPECT_THAT(read(folder / "b.toml"), HasSubstr("palpa = 1"));
  if (!has_pictures()) return;
  write("b.png", "mine");
  expect_refused({"info", "a.nrrd", "--picture", "b.png"}, "b.png: exists already");
  EXPECT_EQ(read(folder / "b.png"), "mine");
  EXPECT_EQ(palpa({"info", "a.nrrd", "--picture", "b.png", "--force"}).code, 0);
  EXPECT_EQ(read(folder / "b.png").substr(1, 3), "PNG");
  ASSERT_TRUE(has_trace());
  write("page.html", "mine");
  expect_refused({"report", "trace", "--out", "page.html"}, "is no report of palpa");
  EXPECT_EQ(read(folder / "page.html"), "mine");
  EXPECT_EQ(palpa({"report", "trace", "--out", "page.html", "--force"}).code, 0);
  EXPECT_EQ(palpa({"report", "trace", "--out", "page.html"}).code, 0) << "an earlier report is replaced";
}

TEST_F(Strangers, AFullDiskLeavesNothing) {
  if (!has_reader) GTEST_SKIP() << "built without palpa-read";
  write("a.nrrd", nrrd('\x7f'));
  ASSERT_TRUE(has_trace());
  const auto on_full_disk = [&](const std::vector<std::string>& arguments) {
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    const rlimit small{512, before.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
    const pid_t process = start(arguments);
    ::setrlimit(RLIMIT_FSIZE, &before);
    const Ended ended = wait(process);
    EXPECT_EQ(ended.code, 2) << testing::PrintToString(arguments) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("cannot be written (File too large); make room"));
  };
  on_full_disk({"info", "a.nrrd", "--scene", "x.toml"});
  EXPECT_FALSE(fs::exists(folder / "x.toml"));
  if (has_pictures()) {
    on_full_disk({"report", "trace"});
    EXPECT_FALSE(fs::exists(folder / "trace/report.html"));
    on_full_disk({"info", "a.nrrd", "--picture", "x.png"});
    EXPECT_FALSE(fs::exists(folder / "x.png"));
  }
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    EXPECT_THAT(entry.path().filename().string(), Not(testing::StartsWith(".palpa"))) << entry.path();
}

TEST_F(Strangers, ASignalLeavesNothingHalfDone) {
  if (!has_reader) GTEST_SKIP() << "built without palpa-read";
  constexpr std::size_t voxels = 200;
  write("a.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 200 200 200\nspacings: 1 1 1\nencoding: raw\n\n" +
                      std::string(voxels * voxels * voxels, 'x'));
  for (int after_ms = 20; after_ms < 400; after_ms += 40) {
    const pid_t process = start({"convert", "a.nrrd", "out.vti"});
    std::this_thread::sleep_for(std::chrono::milliseconds(after_ms));
    for (const int signal : {SIGTERM, SIGTERM, SIGKILL}) ::kill(process, signal);  // the second ends it at once
    wait(process);
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (name == "out.vti") {
        EXPECT_THAT(read(entry.path()), testing::EndsWith("</VTKFile>\n"));
      } else {
        EXPECT_TRUE(name == "a.nrrd" || name == "scene.toml" || name == ".out" || name == ".err") << name;
      }
    }
    fs::remove(folder / "out.vti");
  }
}

TEST_F(Strangers, TheFileThatIsNamedIsTheOneThatIsRead) {
  if (!has_reader) GTEST_SKIP() << "built without palpa-read";
  // As bytes: with a tab, a line end, an escape, and invalid UTF-8.
  write("a b.nrrd", nrrd('\x01'));
  int value = 40;
  for (const std::string name : {"a\tb.nrrd", "a\nb.nrrd", "a\033b.nrrd", "a\xff\x62.nrrd"}) {
    write(name, nrrd(static_cast<char>(++value)));
    const Ended told = palpa({"info", name, "--json"});
    EXPECT_EQ(told.code, 0) << told.err;
    EXPECT_THAT(told.out, HasSubstr(": " + std::to_string(value))) << told.out;
    expect_nothing_steers(told.out);
  }
  expect_refused({"info", "c\td.nrrd"}, "c\\u0009d.nrrd: does not exist");
}

TEST_F(Strangers, NothingThatTheySaySteersATerminal) {
  const std::string steering = "\\u001b]0;owned\\u0007\\u009b31m\\u202e";
  write_scene("titled.toml", "title = \"phantom\"", "title = \"" + steering + "\"");
  const Ended dry = palpa({"run", "titled.toml", "--hand", "sim:press", "--dry-run"});
  EXPECT_EQ(dry.code, 0) << dry.err;
  EXPECT_THAT(dry.out, HasSubstr("owned"));
  expect_nothing_steers(dry.out + dry.err);
  expect_nothing_steers(palpa({"run", "titled.toml", "--hand", "sim:press", "--dry-run", "--json"}).out);
  const std::string name = "a\033[31m\a\u202eb";
  const Ended run = palpa({"run", "titled.toml", "--hand", "sim:press", "--duration-s", "0.1", "--out", name});
  EXPECT_EQ(run.code, 0) << run.err;
  expect_nothing_steers(run.out + run.err);
  write("hand.csv", "t_s,x_m,y_m,z_m\n0,0,0,\033[31m\u202e\n");
  expect_refused({"run", "scene.toml", "--hand", "hand.csv"}, "\\u001B[31m\\u202E");
  fs::rename(folder / name, folder / "trace");
  const std::string ticks = read(folder / "trace/ticks.csv");
  write("trace/ticks.csv", ticks.substr(0, ticks.find('\n') + 1) + "\033[31m" + ticks.substr(ticks.find('\n') + 1));
  expect_refused({"replay", "trace"}, "\\u001B[31m0");
  if (!has_pictures()) return;
  write("trace/ticks.csv", ticks);
  const Ended report = palpa({"report", "trace"});
  EXPECT_EQ(report.code, 0) << report.err;
  expect_nothing_steers(read(folder / "trace/report.html"));
}

TEST_F(Strangers, AnErrorIsOneLineOfAtMost500Bytes) {
  const std::string text(20'000, 'x');
  write("long.csv", "t_s,x_m,y_m,z_m\n0,0,0," + text + "\n");
  expect_refused({"run", "scene.toml", "--hand", "long.csv"}, "is no number; every cell");
  std::string path = "./";
  for (int n = 0; n < 900; ++n) path += n % 100 == 99 ? "/" : "ä";
  expect_refused({"run", path + "/scene.toml", "--hand", "sim:press"}, "no such scene");
  expect_refused({"replay", path}, "is no trace");
  ASSERT_TRUE(has_trace());
  const std::string ticks = read(folder / "trace/ticks.csv");
  write("trace/ticks.csv", ticks.substr(0, ticks.find('\n') + 1) + text + ticks.substr(ticks.find('\n') + 1));
  expect_refused({"replay", "trace"}, "; docs/trace.md says what it holds");
  // A NUL does not cut it short.
  write("nul.csv", std::string("t_s,x_m,y_m,z_m\n0,0,0,a\0b\n", 27));
  expect_refused({"run", "scene.toml", "--hand", "nul.csv"}, "'a\\u0000b' is no number; every cell");
}

}  // namespace strangers_test
}  // namespace palpa
