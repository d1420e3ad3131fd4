// Page on the traces of several hands: it links and summarizes the page of each.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "palpa/report/report.h"
#include "tests/report/markup.h"
#include "tests/study/study_fixture.h"

namespace palpa {
namespace hands_report_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

/// All texts between two marks.
std::vector<std::string> between(const std::string& page, const std::string& begin, const std::string& end) {
  std::vector<std::string> found;
  for (std::size_t at = page.find(begin); at != page.npos; at = page.find(begin, at)) {
    at += begin.size();
    found.push_back(page.substr(at, page.find(end, at) - at));
  }
  return found;
}

class HandsReport : public StudyTest {
 protected:
  HandsReport() {
    write("two.toml", R"(palpa = 1
title = "two on a ball"
[[hand]]
name = "thumb"
at_m = [-0.02, 0, 0]
[hand.tool]
shape = "ball"
radius_m = 0.006
points = 12
[[hand]]
name = "finger"
at_m = [0.02, 0.01, 0]
[workspace]
scale = 1
[volume.ball]
analytic = "sphere"
[[mode]]
name = "surface"
type = "surface_and_friction"
field = "ball"
[[mode.level]]
name = "skin"
value = 0
strength_n = 4
)");
    RunOptions o = options("both", 0.4);
    o.scene = folder / "two.toml";
    o.arguments = {"run", "two.toml", "--hand", "sim:press", "--hand", "sim:stroke"};
    run_hands(prepare_hands(o, {"sim:press", "sim:stroke"}, {}));
  }
  std::string error_of(const ReportOptions& o, const fs::path& out = {}) const {
    try {
      write_report(folder / "both", out, o);
    } catch (const LoadError& error) {
      return error.what();
    }
    return "no error";
  }
};

TEST_F(HandsReport, LinksAndSummarizesThePageOfEach) {
  const fs::path file = write_report(folder / "both");
  EXPECT_EQ(file, folder / "both/report.html");
  const std::string index = read(file);
  EXPECT_EQ(markup_error(index, true), "");
  std::set<std::string> linked;
  for (const std::string& link : between(index, "<a href=\"", "\"")) {
    if (link.starts_with('#')) continue;
    linked.insert(link);
    EXPECT_TRUE(fs::exists(folder / "both" / link)) << link;
  }
  EXPECT_EQ(linked, (std::set<std::string>{"finger/report.html", "thumb/report.html"}));
  const std::string pages = read(folder / "both/finger/report.html") + read(folder / "both/thumb/report.html");
  std::size_t sentences = 0;
  for (const std::string& list : between(index, "<ul class=\"felt\">", "</ul>")) {
    for (const std::string& sentence : between(list, "<li>", "</li>")) {
      ++sentences;
      EXPECT_THAT(pages, HasSubstr(sentence));
    }
  }
  EXPECT_GE(sentences, 4U);
  for (const std::string& row : between(index, "<tr>", "</tr>")) {
    const std::size_t cells = between(row, "<td", "</td>").size() + between(row, "<th", "</th>").size();
    EXPECT_EQ(cells, 3U) << "a column for each hand: " << row;
  }
  EXPECT_THAT(index, HasSubstr("torque on the hand, largest"));
  EXPECT_EQ(report_html(folder / "both"), index);
  EXPECT_NO_THROW(write_report(folder / "both")) << "an earlier report is replaced";
}

TEST_F(HandsReport, EachPageNamesItsOwnHand) {
  write_report(folder / "both");
  EXPECT_THAT(read(folder / "both/thumb/report.html"), HasSubstr("under the hand sim:press,"));
  EXPECT_THAT(read(folder / "both/finger/report.html"), HasSubstr("under the hand sim:stroke,"));
}

TEST_F(HandsReport, NamesInTheAddressAndTheTextAreSafe) {
  const std::string name = "a b'<&\"#?%:.d";
  fs::rename(folder / "both/thumb", folder / "both" / name);
  const std::string index = report_html(folder / "both");
  EXPECT_EQ(markup_error(index, true), "");
  EXPECT_THAT(index, HasSubstr("href=\"a%20b%27%3C%26%22%23%3F%25%3A.d/report.html\""));
}

TEST_F(HandsReport, OptionsForOneTraceAreRefused) {
  const std::string all = (folder / "both").string() + ": holds a trace of each hand, and --out, --beside and --pictures are ";
  EXPECT_THAT(error_of({}, folder / "page.html"), StartsWith(all));
  EXPECT_THAT(error_of({.beside = folder / "both/thumb"}), StartsWith(all));
  EXPECT_THAT(error_of({.pictures = folder / "pictures"}), StartsWith(all));
  EXPECT_FALSE(fs::exists(folder / "both/report.html"));
}

}  // namespace hands_report_test
}  // namespace palpa
