// Comparison of traces, complete and truncated.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <tuple>

#include "tests/trace/trace_fixture.h"

namespace palpa {
namespace comparison_test {

namespace fs = std::filesystem;
using test::set_text;
using test::text_of;
using test::Trace;
using test::write_plain;
using testing::HasSubstr;

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
  EXPECT_THAT(compare().where, HasSubstr("ticks.csv:51: the recording continues"));
  fs::remove_all(folder("again"));
  record("again", 51);
  EXPECT_THAT(compare().where, HasSubstr("ticks.csv:52: the recording ends"));
}

TEST_F(Comparison, AnUnfinishedTraceIsReadAndComparedToItsLastWholeLine) {
  record("recorded", 50, false);
  record("again", 50);
  EXPECT_FALSE(TraceReader(folder("recorded")).header().complete);
  const std::string whole = text_of(folder("recorded") / "ticks.csv");
  // The very end, in the middle of a row, just behind a row, in the header, and empty.
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
  // A replay must reach as far, though.
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

}  // namespace comparison_test
}  // namespace palpa
