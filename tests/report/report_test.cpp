// Reports: content, escaped foreign text, incomplete traces.
#include "palpa/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "palpa/data/sha256.h"
#include "palpa/loop/loop.h"
#include "palpa/report/html.h"
#include "tests/report/markup.h"
#include "tests/study/study_fixture.h"

namespace palpa {
namespace report_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

/// A trace of one second, recorded once for all tests, and its report, which takes seconds.
class Recording : public StudyFolder {
 public:
  Recording() { run(options("trace")); }
  fs::path trace() const { return folder / "trace"; }
  const std::string& html() {
    if (html_.empty()) html_ = report_html(trace());
    return html_;
  }

 private:
  std::string html_;
};

class Report : public StudyTest {
 protected:
  static void SetUpTestSuite() { recording = std::make_unique<Recording>(); }
  static void TearDownTestSuite() { recording.reset(); }

  /// A trace of one second, to be changed.
  fs::path trace() const {
    fs::copy(recording->trace(), folder / "trace", fs::copy_options::recursive);
    return folder / "trace";
  }
  fs::path trace(const std::string& name, double duration_s, bool primitives = false) const {
    RunOptions o = options(name, duration_s);
    o.primitives = primitives;
    run(o);
    return folder / name;
  }
  static const std::string& html_of_trace() {
    EXPECT_EQ(markup_error(recording->html(), true), "");
    return recording->html();
  }
  /// The report's text; a machine without EGL has no pictures, which the report mentions.
  static std::string html_of(const fs::path& trace) {
    const std::string html = report_html(trace);
    EXPECT_EQ(markup_error(html, true), "");
    return html;
  }
  std::string error_of(const fs::path& trace) const {
    try {
      report_html(trace);
    } catch (const LoadError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.what();
    }
    return {};
  }
  void exchange(const fs::path& file, const std::string& from, const std::string& to) const {
    std::string text = read(file);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    std::ofstream(file, std::ios::binary) << text;
  }

  static inline std::unique_ptr<Recording> recording;
};

TEST_F(Report, NamesEveryModeEventSettingAndTheScene) {
  const fs::path made = trace("trace", 3.0);
  const std::string html = html_of(made);
  for (const char* text :
       {"<title>phantom", "surface_and_friction", "viscosity", "skin was in contact for", "syrup ", "Overview",
        "run scene.toml", "id=\"force-", "id=\"energy-", "drag_ns_per_m = 0.5", "The first onset came at"}) {
    EXPECT_THAT(html, HasSubstr(text));
  }
  std::istringstream events(read(made / "events.csv"));
  std::string line;
  std::getline(events, line);
  int rows = 0;
  while (std::getline(events, line) && rows < 50) {
    const std::string kind = line.substr(line.find(',', line.find(',') + 1) + 1);
    EXPECT_THAT(html, HasSubstr("<td>" + kind.substr(0, kind.find(',')) + "</td>"));
    ++rows;
  }
  EXPECT_GT(rows, 0) << "nothing happened in the run";
  EXPECT_THAT(html, Not(HasSubstr("<script src")));
  EXPECT_THAT(html, Not(HasSubstr("src=\"http")));
}

TEST_F(Report, ShowsTheSceneAndAMoment) {
  const std::string& html = html_of_trace();
  EXPECT_THAT(html, HasSubstr("src=\"data:image/png;base64,iVBORw0KGgo"));
  EXPECT_THAT(html, HasSubstr("The moment at "));
  EXPECT_THAT(html, Not(HasSubstr("No picture")));
}

TEST_F(Report, TheMomentIsTheSameRecordedOrFeltAgain) {
  const auto moment_of = [](const std::string& html) {
    const std::size_t at = html.find("<figcaption>The moment at ");
    return at == std::string::npos ? std::string() : html.substr(at, html.find("</figcaption>", at) - at);
  };
  const std::string recorded = html_of(trace("with", 1.0, true)), &felt_again = html_of_trace();
  EXPECT_FALSE(moment_of(recorded).empty());
  EXPECT_EQ(moment_of(recorded), moment_of(felt_again));
}

TEST_F(Report, IsTheSameTwiceWithItsPicturesBesideItOrNot) {
  const fs::path written = write_report(recording->trace(), folder / "page.html", {.pictures = folder / "pictures"});
  EXPECT_EQ(read(written), recording->html());
  EXPECT_FALSE(fs::is_empty(folder / "pictures"));
}

TEST_F(Report, StaysBelowFiveMegabytesForTenSeconds) {
  const fs::path made = trace("long", 10.0);
  const fs::path written = write_report(made);
  EXPECT_EQ(written, made / "report.html");
  EXPECT_LT(fs::file_size(written), 5'000'000u);
  EXPECT_EQ(write_report(made, folder / "elsewhere.html"), folder / "elsewhere.html");
  EXPECT_EQ(read(folder / "elsewhere.html"), read(written));
}

TEST_F(Report, EscapesWhatOthersWrote) {
  std::string scene = phantom_scene;
  scene.replace(scene.find("title = \"phantom\""), 17, "title = \"<script>alert(1)</script> & 'x'\"");
  scene += "# </code></pre><script>alert(2)</script>\n";
  write("scene.toml", scene);
  RunOptions o = options("trace", 3.0);
  o.arguments = {"run", "<img src=x onerror=alert(3)>", "\"'&"};
  run(o);
  exchange(folder / "trace" / "events.csv", "skin", "<b>skin");
  std::string modes = read(folder / "trace" / "modes.csv");
  for (std::size_t at = modes.find("syrup"); at != std::string::npos; at = modes.find("syrup", at + 12)) {
    modes.replace(at, 5, "<i>&syrup</i>");
  }
  std::ofstream(folder / "trace" / "modes.csv", std::ios::binary) << modes;
  const std::string html = html_of(folder / "trace");
  for (const char* tag : {"<script>alert", "<img src=x", "<b>skin", "<i>&"}) EXPECT_THAT(html, Not(HasSubstr(tag)));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;alert(2)&lt;/script&gt;"));
  EXPECT_THAT(html, HasSubstr("&lt;i&gt;&amp;syrup&lt;/i&gt;"));
}

TEST_F(Report, MayRunNoScriptsButItsOwn) {
  const std::string& html = html_of_trace();
  const std::string begin = "<meta http-equiv=\"Content-Security-Policy\" content=\"";
  const std::size_t at = html.find(begin);
  ASSERT_NE(at, std::string::npos);
  const std::string policy = html.substr(at + begin.size(), html.find("\">", at) - at - begin.size());
  for (const char* nothing : {"default-src 'none'", "base-uri 'none'", "form-action 'none'"})
    EXPECT_THAT(policy, HasSubstr(nothing));
  const std::size_t of_scripts = policy.find("script-src");
  ASSERT_NE(of_scripts, std::string::npos);
  const std::string scripts = policy.substr(of_scripts, policy.find(';', of_scripts) - of_scripts);
  EXPECT_THAT(scripts, Not(HasSubstr("unsafe")));
  int count = 0;
  const std::string open = "<script>";
  for (std::size_t script = html.find(open); script != std::string::npos; script = html.find(open, script + 1)) {
    const std::size_t from = script + open.size();
    std::ofstream(folder / "script", std::ios::binary) << html.substr(from, html.find("</script>", from) - from);
    const std::string hex = detail::sha256_of_file((folder / "script").string());
    std::string bytes;
    for (std::size_t n = 0; n < hex.size(); n += 2) bytes += static_cast<char>(std::stoi(hex.substr(n, 2), nullptr, 16));
    EXPECT_THAT(scripts, HasSubstr("'sha256-" + detail::base64(bytes) + "'"));
    ++count;
  }
  EXPECT_GT(count, 0);
}

TEST_F(Report, RefusesAFolderThatIsNoTrace) {
  EXPECT_THAT(error_of(folder), HasSubstr("is no trace"));
  EXPECT_THAT(error_of(folder / "nowhere"), HasSubstr("is no trace"));
  EXPECT_THAT(error_of(folder / "scene.toml"), HasSubstr("is no trace"));
}

TEST_F(Report, GoesAsFarAsAnIncompleteTrace) {
  const fs::path made = trace();
  exchange(made / "trace.toml", "complete = true", "complete = false");
  for (const char* name : {"ticks.csv", "modes.csv", "timing.csv"})
    fs::resize_file(made / name, fs::file_size(made / name) / 2);
  const std::string html = html_of(made);
  EXPECT_THAT(html, HasSubstr("This recording is incomplete"));
  EXPECT_THAT(html, HasSubstr("skin"));

  // Before its first tick, and without any of its rows.
  for (const char* name : {"ticks.csv", "modes.csv", "timing.csv", "events.csv"}) fs::resize_file(made / name, 0);
  EXPECT_THAT(html_of(made), HasSubstr("ends before its first tick"));
  for (const char* name : {"ticks.csv", "modes.csv", "timing.csv", "events.csv"}) fs::remove(made / name);
  EXPECT_THAT(html_of(made), HasSubstr("ends before its first tick"));
}

TEST_F(Report, SaysWhyThereAreNoPicturesWithoutTheData) {
  const fs::path made = trace();
  exchange(made / "scene.toml", "analytic = \"head_phantom\"", "file = \"gone.nrrd\"");
  const std::string html = html_of(made);
  EXPECT_THAT(html, HasSubstr("No picture: "));
  EXPECT_THAT(html, HasSubstr("gone.nrrd"));
  EXPECT_THAT(html, HasSubstr("syrup was in contact for"));
  EXPECT_THAT(html, HasSubstr("id=\"force-"));
}

TEST_F(Report, SaysThatItsPluginMustBeNamed) {
  const fs::path made = trace();
  exchange(made / "trace.toml", "plugins = []", "plugins = [\"/nowhere/ridge.so\"]");
  EXPECT_THAT(html_of(made), HasSubstr("name it with --plugin"));
}

TEST_F(Report, ADamagedFileIsOneLine) {
  const fs::path made = trace();
  exchange(made / "modes.csv", "\n0,skin,", "\n0,skin,nonsense");
  EXPECT_THAT(error_of(made), HasSubstr("modes.csv:2: column 'force_x_n' cannot be"));
}

/// A trace whose hand, data, plug-in and settings lie in folders with a person's name.
TEST_F(Report, HoldsLastNamesOfPathsUnlessWholeOnesAreAskedFor) {
  const fs::path home = folder / "Jane Doe 1970" / "st-mary";
  fs::create_directories(home / "data");
  std::string scene = phantom_scene;
  scene += "# from " + (home / "data/scan 1.nrrd").string() + " and ../Jane/notes.txt, at 500 N/m\n";
  std::ofstream(home / "scene.toml") << scene;
  run(options("first", 0.4));
  RunOptions o = options("", 0.4);
  o.scene = home / "scene.toml";
  o.hand = (home / "hand.csv").string();
  fs::copy_file(folder / "first/ticks.csv", o.hand);
  o.out = home / "trace";
  o.arguments = {"run",      (home / "scene.toml").string(),
                 "--hand",   o.hand,
                 "--set",    "volume.head.note=" + (home / "a.toml").string(),
                 "--out",    (home / "trace").string(),
                 "--data",   "/srv/Jane Doe, 1970/scans",
                 "--device", "kind,file=/srv/Jane, D/a,key=/b/c"};
  run(o);
  const fs::path made = home / "trace";
  exchange(made / "trace.toml", "notes = [", "notes = [\"" + (home / "hand.csv").string() + " was moved\", ");
  std::string header = read(made / "trace.toml");
  for (int n = 0; n < 20; ++n)
    header +=
        "\n[[data_file]]\npath = \"" + (home / ("data/IM" + std::to_string(n))).string() + "\"\nbytes = 100\nsha256 = \"ab\"\n";
  std::ofstream(made / "trace.toml", std::ios::binary) << header;
  exchange(made / "scene.toml", "analytic = \"head_phantom\"", "file = \"" + (home / "data/IM0").string() + "\"");
  const std::string html = html_of(made);
  for (const char* secret : {"Jane", "st-mary", "IM7"}) EXPECT_THAT(html, Not(HasSubstr(secret)));
  EXPECT_THAT(html, Not(HasSubstr(folder.string())));
  for (const char* name : {"hand.csv", "scene.toml", "IM0 and 19 more", "2\u202f000 bytes", "file = &quot;IM0&quot;", "500 N/m",
                           "scan 1.nrrd", "notes.txt", "--data scans", "kind,file=a,key=c", "No picture: "})
    EXPECT_THAT(html, HasSubstr(name)) << name;
  const std::string whole = report_html(made, {.full_paths = true});
  for (const fs::path& path : {home / "hand.csv", home / "data/IM0"}) EXPECT_THAT(whole, HasSubstr(path.string()));
}

TEST_F(Report, EventsSayWhyWithTheirUnit) {
  const fs::path made = trace();
  std::ofstream(made / "events.csv", std::ios::app)
      << "900,0.9,snap,proxy,0.20453085586987022\n901,0.901,lost_ticks,recorder,1\n";
  const std::string html = html_of(made);
  EXPECT_THAT(html, HasSubstr("the force fell by 0.20 N"));
  EXPECT_THAT(html, HasSubstr("one tick was not recorded"));
  EXPECT_THAT(html, Not(HasSubstr("0.2045308")));
  EXPECT_THAT(html, Not(HasSubstr("brought 0.00 mJ in")));
  EXPECT_THAT(html, HasSubstr("not in real time"));
}

/// A rod in the phantom, or a point.
std::string tool_scene(const char* tool) { return std::string(phantom_scene) + tool; }
constexpr const char* rod = "[tool]\nshape = \"rod\"\nlength_m = 0.04\npoints = 5\n";

class ReportOfATool : public StudyTest {
 protected:
  fs::path trace(const std::string& name, const char* tool, const char* hand, bool primitives = false) const {
    write("scene.toml", tool_scene(tool));
    RunOptions o = options(name);
    o.hand = hand;
    o.primitives = primitives;
    run(o);
    return folder / name;
  }
  static std::string html_of(const fs::path& trace) {
    const std::string html = report_html(trace);
    EXPECT_EQ(markup_error(html, true), "");
    return html;
  }
};

TEST_F(ReportOfATool, ShowsTorqueBesideForceAndFeet) {
  const std::string html = html_of(trace("rod", rod, "sim:stroke,tilt_rad=0.3", true));
  for (const char* text : {"id=\"torque-", "torque / mN\u00b7m", "torque on the hand", "\"feet\":[[0.0,0.0,",
                           "\"proxy_turn\":[", "\"coupling_torque\":", "feet of the tool at the proxy"}) {
    EXPECT_THAT(html, HasSubstr(text));
  }
  EXPECT_LT(html.find("id=\"force-"), html.find("id=\"torque-"));
  EXPECT_LT(html.find("id=\"torque-"), html.find("id=\"modes-"));
}

TEST_F(ReportOfATool, ForcesOfItsFeetAreTheSameRecordedOrFeltAgain) {
  const auto feet_of = [](const std::string& html) {
    std::vector<std::string> feet;
    const std::string key = "\"coupling_torque\":";
    for (std::size_t at = html.find(key); at != std::string::npos; at = html.find(key, at + 1))
      feet.push_back(html.substr(at, html.find('}', at) - at));
    return feet;
  };
  const std::vector<std::string> recorded = feet_of(html_of(trace("with", rod, "sim:stroke,tilt_rad=0.3", true)));
  EXPECT_EQ(recorded, feet_of(html_of(trace("without", rod, "sim:stroke,tilt_rad=0.3"))));
  EXPECT_TRUE(std::any_of(recorded.begin(), recorded.end(), [](const std::string& one) { return !one.ends_with("[]"); }));
}

TEST_F(ReportOfATool, OfAPointHasNoWordOfTools) {
  const std::string html = html_of(trace("point", "", "sim:stroke"));
  for (const char* text : {"torque", "feet", "_turn", "unfelt"}) EXPECT_THAT(html, Not(HasSubstr(text)));
}

TEST_F(ReportOfATool, SaysWhatTurningBroughtInUnfelt) {
  const fs::path made = trace("rod", rod, "sim:stroke,tilt_rad=0.3");
  std::string ticks = read(made / "ticks.csv");
  std::istringstream header(ticks.substr(0, ticks.find('\n')));
  std::size_t column = 0;
  for (std::string name; std::getline(header, name, ',') && name != "unfelt_j";) ++column;
  // 2 mJ in the first row.
  std::size_t at = ticks.find('\n');
  for (std::size_t i = 0; i < column; ++i) at = ticks.find(',', at + 1);
  ticks.replace(at + 1, ticks.find_first_of(",\n", at + 1) - at - 1, "0.002");
  std::ofstream(made / "ticks.csv", std::ios::binary) << ticks;
  const std::string html = html_of(made);
  EXPECT_THAT(html, HasSubstr("energy brought in by turning, unfelt"));
  EXPECT_THAT(html, HasSubstr("Turning the handle brought in 2."));
}

TEST_F(Report, CannotBeWrittenJustAnywhere) {
  const fs::path made = trace();
  exchange(made / "scene.toml", "analytic = \"head_phantom\"", "file = \"gone.nrrd\"");  // pictures would take seconds
  for (const fs::path& out : {folder, folder / "no" / "such" / "place.html"}) {
    try {
      write_report(made, out);
      ADD_FAILURE() << out;
    } catch (const LoadError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith(out.string() + ": cannot be written"));
    }
  }
}

}  // namespace report_test
}  // namespace palpa
