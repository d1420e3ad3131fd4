// Unwritable and unreadable traces: place and reason of the error, readable earlier rows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include "tests/trace/trace_fixture.h"

namespace palpa {
namespace trace_errors_test {

namespace fs = std::filesystem;
using test::error_of;
using test::set_text;
using test::text_of;
using test::Trace;
using test::write_plain;
using testing::AllOf;
using testing::HasSubstr;

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
  EXPECT_FALSE(old.has_energy());
  EXPECT_TRUE(TraceReader(folder() / "new").has_energy());
  ASSERT_EQ(old.ticks().size(), 5u);
  EXPECT_EQ(old.ticks()[3].frame.result.proxy_m, TraceReader(folder() / "new").ticks()[3].frame.result.proxy_m);
  EXPECT_TRUE(compare_traces(folder() / "old", folder() / "new").same);
}

// A limit on file size stands for a full disk: write fails alike.
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

}  // namespace trace_errors_test
}  // namespace palpa
