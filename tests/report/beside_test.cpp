// The page of two traces: lists differences, and refuses two hands.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "palpa/base/load_error.h"
#include "palpa/report/path_names.h"
#include "palpa/report/recorded.h"
#include "palpa/report/report.h"
#include "tests/report/markup.h"
#include "tests/study/study_fixture.h"

namespace palpa {
namespace beside_test {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class BesideReport : public StudyTest {
 protected:
  BesideReport() { run(options("first", 1.5)); }

  /// The first trace's hand in a changed scene.
  void feel_again(const std::string& name, const std::string& key = {}, const std::string& value = {}) const {
    RunOptions again = options(name, 1.5);
    again.hand = (folder / "first/ticks.csv").string();
    if (!key.empty()) again.scene_options.sets.emplace_back(key, value);
    run(again);
  }
  std::string page(const std::string& first, const std::string& second) const {
    return report_html(folder / first, {.beside = folder / second});
  }
};

TEST_F(BesideReport, OfATraceBesideItselfSaysThatNothingDiffers) {
  const std::string html = page("first", "first");
  EXPECT_EQ(markup_error(html, true), "");
  EXPECT_THAT(html, AllOf(HasSubstr("identical, to the bit"), Not(HasSubstr("Intervals in which a hand would tell"))));
}

TEST_F(BesideReport, TheSameHandInTheSameSceneFeelsTheSame) {
  feel_again("again");
  EXPECT_THAT(page("first", "again"), HasSubstr("identical, to the bit"));
}

TEST_F(BesideReport, SaysWhereAndByHowMuchAWeakerLevelDiffers) {
  feel_again("weak", "mode.skin.level.skin.strength_n", "0.2");
  for (const std::string& html : {page("first", "weak"), page("weak", "first")}) {
    EXPECT_EQ(markup_error(html, true), "");
    for (const char* words :
         {"A hand would tell the two apart in", "The largest difference is", "id=\"plot-difference\"", "id=\"plot-direction\"",
          "Intervals in which a hand would tell", "force, 20 to 500 Hz, root mean square", "limited by the guard",
          "id=\"spectrum-", "The path of the hand", "strength_n=0.2", "Break-throughs: "}) {
      EXPECT_THAT(html, HasSubstr(words));
    }
  }
}

TEST_F(BesideReport, RefusesTwoHandsAndSaysWhereTheyPart) {
  RunOptions other = options("other", 1.5);
  other.hand = "sim:press";
  run(other);
  const auto problem = [&](const std::string& second) -> std::string {
    try {
      page("first", second);
    } catch (const LoadError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(problem("other"), AllOf(HasSubstr("has another hand"), HasSubstr("from tick "), HasSubstr("--hand")));
  RunOptions slow = options("slow", 1.5);
  slow.hand = (folder / "first/ticks.csv").string();
  slow.rate_hz = 500.0;
  run(slow);
  EXPECT_THAT(problem("slow"), HasSubstr("times"));
  EXPECT_THAT(problem("nothing"), HasSubstr("is no trace"));
}

TEST_F(BesideReport, IsWrittenBesideTheFirstAndTheSameTwice) {
  feel_again("weak", "mode.skin.level.skin.strength_n", "0.2");
  const fs::path file = write_report(folder / "first", {}, {.beside = folder / "weak"});
  EXPECT_EQ(file, folder / "first/beside.html");
  EXPECT_FALSE(fs::exists(folder / "first/report.html"));
  const std::string once = read(file);
  EXPECT_EQ(once, page("first", "weak"));
  write_report(folder / "first", folder / "page.html", {.beside = folder / "weak", .pictures = folder / "pictures"});
  for (const char* name : {"force.svg", "difference.svg", "direction.svg", "where.svg", "spectrum.svg"})
    EXPECT_EQ(markup_error(read(folder / "pictures" / name), false), "") << name;
}

TEST_F(BesideReport, ItsTitleSaysWhatDiffers) {
  const auto title = [](const std::string& html) {
    const std::size_t at = html.find("<h1>");
    return html.substr(at, html.find("</h1>", at) - at);
  };
  feel_again("paper", "law.method", "paper-2005");
  EXPECT_THAT(title(page("first", "paper")), HasSubstr("law.method: exact / paper-2005"));
  EXPECT_THAT(title(page("paper", "first")), HasSubstr("law.method: paper-2005 / exact"));
  feel_again("weak", "mode.skin.level.skin.strength_n", "0.25");
  EXPECT_THAT(title(page("first", "weak")), HasSubstr("mode.skin.level.skin.strength_n: 0.8 / 0.25"));
  const std::string two = page("paper", "weak");
  EXPECT_THAT(title(two), HasSubstr("2 values of the scene differ"));
  EXPECT_THAT(two, AllOf(HasSubstr("<li>law.method: paper-2005 / exact</li>"), HasSubstr("strength_n: 0.8 / 0.25</li>")));
  feel_again("again");
  EXPECT_THAT(title(page("first", "again")), HasSubstr("one scene, recorded twice"));
}

TEST(PathNames, KeepNoPartOfAFolderOfAValue) {
  const std::string file = "/home/M\u00fcller, Hans (1970)/scan 1/head.mhd";
  detail::Recorded own;
  own.header.data_files.push_back({.path = file});
  for (const detail::Recorded& recorded : {own, detail::Recorded{}}) {
    const detail::PathNames names(recorded, "/tmp/trace", false);
    EXPECT_EQ(names.of_value(file), "head.mhd");
    for (const char* value : {"exact", "m/s", "0.8", "[0.1, 0.2]", ""}) EXPECT_EQ(names.of_value(value), value);
    EXPECT_EQ(detail::PathNames(recorded, "/tmp/trace", true).of_value(file), file);
  }
  EXPECT_EQ(detail::PathNames(own, "/tmp/trace", false).of_value("[" + file + "]"), "[head.mhd]");
}

TEST_F(BesideReport, NamesOfStrangersStayTexts) {
  feel_again("weak", "mode.skin.level.skin.strength_n", "0.2");
  fs::rename(folder / "weak", folder / "<script>alert(1)<&");
  const std::string html = page("first", "<script>alert(1)<&");
  EXPECT_EQ(markup_error(html, true), "");
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
}

}  // namespace beside_test
}  // namespace palpa
