// A report in a browser: rotation, time, zoom; and without scripts and WebGL.
#include "tests/report/browser.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "palpa/report/report.h"
#include "palpa/solver/pose.h"
#include "tests/study/study_fixture.h"

namespace palpa {
namespace browser_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

/// The test's script in the page: `drag` moves the pressed mouse over an element, `tell` writes numbers into the document. Each
/// part of `use` has time to be drawn.
std::string script_that(const std::string& use) {
  return R"(
const drag = (element, from, by, steps) => {
  const edge = element.getBoundingClientRect();
  const at = (share) => ({bubbles: true, cancelable: true, view: window, button: 0, buttons: 1,
    clientX: edge.left + from[0] + share * by[0], clientY: edge.top + from[1] + share * by[1]});
  element.dispatchEvent(new PointerEvent('pointerdown', at(0)));
  element.dispatchEvent(new MouseEvent('mousedown', at(0)));
  for (let i = 1; i <= steps; ++i) element.dispatchEvent(new MouseEvent('mousemove', at(i / steps)));
  element.dispatchEvent(new PointerEvent('pointerup', at(1)));
  element.dispatchEvent(new MouseEvent('mouseup', at(1)));
};
const stage = document.getElementById('stage');
const canvas = () => stage.querySelector('canvas');
const cursors = () => [...document.querySelectorAll('.cursor')].map((cursor) => cursor.hidden ? -1 : parseFloat(cursor.style.left));
const windows = () => Plots.graphs.map((one) => one.graph.xAxisRange());
const told = {};
const later = (act) => new Promise((done) => setTimeout(() => { act(); setTimeout(done, 300); }, 300));
(async () => {
  )" + use +
         R"(
  const edge = stage.getBoundingClientRect();
  told.stage = [edge.left, edge.top, edge.width, edge.height];
  const root = document.createElement('pre');
  root.id = 'told';
  root.hidden = true;
  root.textContent = JSON.stringify(told);
  document.body.append(root);
})();
)";
}

/// A trace of three seconds and its report, made once for all tests.
struct Recording : StudyFolder {
  Recording() {
    run(options("trace", 3.0));
    html = report_html(folder / "trace");
  }
  std::string html;
};

class Browser : public StudyTest {
 protected:
  void SetUp() override {
    if (!has_browser()) GTEST_SKIP() << "no chromium; install the package chromium to look at reports in a browser";
    if (!recording) recording = std::make_unique<Recording>();
    html = recording->html;
  }
  static void TearDownTestSuite() { recording.reset(); }

  Shown open(const std::string& page, const std::vector<std::string>& options = {}) const {
    write("page.html", page);
    Shown shown = open_page(folder / "page.html", folder, options);
    EXPECT_THAT(shown.console, IsEmpty());
    return shown;
  }
  Shown use(const std::string& how) const { return open(with_script(html, script_that(how), folder)); }

  static bool holds(const Shown& shown, const char* text) { return shown.document.find(text) != std::string::npos; }
  /// True if the document's root has the class.
  static bool became(const Shown& shown, const char* name) {
    const std::size_t at = shown.document.find("<html");
    return shown.document.substr(at, shown.document.find('>', at) - at).find(name) != std::string::npos;
  }
  static nlohmann::json told(const Shown& shown) {
    const std::string begin = "<pre id=\"told\" hidden=\"\">";
    const std::size_t at = shown.document.rfind(begin);
    if (at == std::string::npos) {
      ADD_FAILURE() << "the script told nothing";
      return {};
    }
    const std::size_t from = at + begin.size();
    return nlohmann::json::parse(shown.document.substr(from, shown.document.find("</pre>", from) - from));
  }

  /// Share of the stage's pixels that `differ` from pixel to pixel.
  template <class Differ>
  static double share_of_stage(const Shown& shown, Differ differ) {
    const std::vector<double> stage = told(shown)["stage"];
    double all = 0.0, some = 0.0;
    for (int y = static_cast<int>(stage[1]) + 2; y < static_cast<int>(stage[1] + stage[3]) - 2; ++y) {
      for (int x = static_cast<int>(stage[0]) + 2; x < static_cast<int>(stage[0] + stage[2]) - 2; ++x) {
        if (x >= shown.screen.width_px || y >= shown.screen.height_px) continue;
        all += 1.0;
        some += differ(x, y);
      }
    }
    EXPECT_GT(all, 1e5) << "the stage is not on the screen";
    return some / all;
  }
  static bool unlike(const std::uint8_t* a, const std::uint8_t* b) {
    constexpr int eye = 24;  // levels of 256
    return std::abs(a[0] - b[0]) > eye || std::abs(a[1] - b[1]) > eye || std::abs(a[2] - b[2]) > eye;
  }
  static double difference(const Shown& one, const Shown& other) {
    return share_of_stage(one, [&](int x, int y) { return unlike(one.screen.at(x, y), other.screen.at(x, y)); });
  }

  std::string html;
  static inline std::unique_ptr<Recording> recording;
};

TEST_F(Browser, TurnsTheSceneAndBack) {
  const std::string there = "drag(canvas(), [300, 250], [170, 60], 12)", back = "drag(canvas(), [470, 310], [-170, -60], 12)";
  const Shown first = use("await later(() => {});");
  const Shown turned = use("await later(() => " + there + ");");
  const Shown returned = use("await later(() => " + there + "); await later(() => " + back + ");");

  const std::uint8_t* ground =
      first.screen.at(static_cast<int>(told(first)["stage"][0]) + 4, static_cast<int>(told(first)["stage"][1]) + 4);
  EXPECT_GT(share_of_stage(first, [&](int x, int y) { return unlike(first.screen.at(x, y), ground); }), 0.1) << "blank";
  EXPECT_GT(difference(first, turned), 0.02);
  EXPECT_LT(difference(first, returned), 0.002);
}

TEST_F(Browser, OneTimeForAllPlotsAndTheView) {
  const Shown shown = use(R"(
    const slider = document.getElementById('time');
    const move = (to) => { slider.value = to; slider.dispatchEvent(new Event('input', {bubbles: true})); };
    const places = () => Plots.graphs.map((one) => one.graph.toDomXCoord(Report.moment().t));
    await later(() => move(0.25 * slider.max));
    told.early = {time: Report.moment().t, cursors: cursors(), places: places(), now: document.getElementById('now').textContent,
      moment: document.getElementById('moment').textContent};
    await later(() => move(0.75 * slider.max));
    told.late = {time: Report.moment().t, cursors: cursors(), places: places(), now: document.getElementById('now').textContent,
      moment: document.getElementById('moment').textContent};
    await later(() => document.querySelector('a[data-time]').click());
    told.event = {wanted: +document.querySelector('a[data-time]').dataset.time, time: Report.moment().t};
  )");
  const nlohmann::json what = told(shown);
  for (const char* when : {"early", "late"}) {
    ASSERT_GE(what[when]["cursors"].size(), 4u);
    for (std::size_t i = 0; i < what[when]["cursors"].size(); ++i)
      EXPECT_NEAR(what[when]["cursors"][i].get<double>(), what[when]["places"][i].get<double>(), 1.0) << when << i;
  }
  for (std::size_t i = 0; i < what["early"]["cursors"].size(); ++i)
    EXPECT_LT(what["early"]["cursors"][i].get<double>() + 20.0, what["late"]["cursors"][i].get<double>());
  EXPECT_LT(what["early"]["time"].get<double>(), what["late"]["time"].get<double>());
  EXPECT_NE(what["early"]["now"], what["late"]["now"]);
  EXPECT_NE(what["early"]["moment"], what["late"]["moment"]);
  EXPECT_NEAR(what["event"]["time"].get<double>(), what["event"]["wanted"].get<double>(), 1e-5);
}

TEST_F(Browser, ZoomsAllPlotsTogether) {
  const Shown shown = use(R"(
    told.before = windows();
    const area = Plots.graphs[0].graph.getArea();
    const top = document.querySelector('#plot-force canvas:last-of-type');
    await later(() => drag(top, [area.x + 0.25 * area.w, area.y + 40], [0.5 * area.w, 0], 8));
    told.after = windows();
  )");
  const nlohmann::json what = told(shown);
  const double before_s = what["before"][0][1].get<double>() - what["before"][0][0].get<double>();
  for (const nlohmann::json& after : what["after"]) {
    EXPECT_NEAR(after[1].get<double>() - after[0].get<double>(), 0.5 * before_s, 0.05 * before_s);
    EXPECT_NEAR(after[0].get<double>(), what["after"][0][0].get<double>(), 1e-9);
  }
}

TEST_F(Browser, RunsNothingThatSlippedIn) {
  std::string page = html;
  page.insert(page.find("<main>") + 6, "<script>document.documentElement.className = 'slipped-in';</script>");
  write("page.html", page);
  const Shown shown = open_page(folder / "page.html", folder);
  EXPECT_FALSE(became(shown, "slipped-in"));
  EXPECT_TRUE(became(shown, "with-view"));
  ASSERT_FALSE(shown.console.empty());
  EXPECT_THAT(shown.console.front(), HasSubstr("Content Security Policy"));
}

/// Share of coloured pixels: of pictures, not of text.
double colourful(const Screen& screen) {
  double some = 0.0;
  for (std::size_t i = 0; i + 2 < screen.rgb.size(); i += 3) {
    const auto [low, high] = std::minmax({screen.rgb[i], screen.rgb[i + 1], screen.rgb[i + 2]});
    some += high - low > 24;
  }
  return 3.0 * some / static_cast<double>(screen.rgb.size());
}

TEST_F(Browser, ShowsThePictureWithoutScripts) {
  write("page.html", html);
  write("frame.html",
        "<!DOCTYPE html><title>frame</title><body style='margin: 0'><iframe sandbox src='page.html' "
        "style='border: 0; width: 1280px; height: 1600px'></iframe></body>");
  // In its page's process: virtual time does not wait for a frame in a process of its own, which is then not drawn.
  const Shown shown = open_page(folder / "frame.html", folder,
                                {"--disable-features=IsolateSandboxedIframes", "--disable-site-isolation-trials"});
  ASSERT_FALSE(shown.console.empty());
  EXPECT_THAT(shown.console.front(), HasSubstr("sandboxed")) << "scripts ran";
  EXPECT_GT(colourful(shown.screen), 0.02);
}

TEST_F(Browser, ShowsThePictureWithoutWebGl) {
  const Shown shown = open(html, {"--disable-3d-apis"});
  EXPECT_FALSE(became(shown, "with-view"));
  EXPECT_TRUE(became(shown, "with-plots"));
  EXPECT_FALSE(holds(shown, "id=\"no-view\" hidden"));
  EXPECT_GT(colourful(shown.screen), 0.02);
}

/// The report of a rod that strokes the head while it swings, made once for all tests.
const std::string& report_of_a_rod() {
  static const std::string page = [] {
    const StudyFolder at;
    at.write("rod.toml",
             std::string(phantom_scene) + "[tool]\nshape = \"rod\"\nlength_m = 0.05\npoints = 6\ncentre_m = [0, 0, 0.025]\n");
    RunOptions of_rod = at.options("rod", 2.0);
    of_rod.scene = at.folder / "rod.toml";
    of_rod.hand = "sim:stroke,tilt_rad=0.3";
    run(of_rod);
    return report_html(at.folder / "rod");
  }();
  return page;
}

/// The page's feet as it draws them: their places, by the pose of what they are drawn about.
constexpr const char* watch_feet = R"(
  const Drawn = THREE.Points;
  const feet = [];
  THREE.Points = function(geometry, material) {
    const place = geometry.getAttribute('position');
    if (place.count === Report.view.feet.length) feet.push(Array.from(place.array));
    return new Drawn(geometry, material);
  };
  const slider = document.getElementById('time');
  const move = (share) => {
    feet.length = 0;
    slider.value = Math.round(share * slider.max);
    slider.dispatchEvent(new Event('input', {bubbles: true}));
  };
  const tellFeet = () => {
    const now = Report.moment();
    return {levers: Report.view.feet, drawn: feet.slice(-2), probe: now.probe, proxy: now.proxy, probe_turn: now.probe_turn,
      proxy_turn: now.proxy_turn};
  };
)";

Vec3 vec_of(const nlohmann::json& json, std::size_t first = 0) {
  return {json[first].get<double>(), json[first + 1].get<double>(), json[first + 2].get<double>()};
}

TEST_F(Browser, AToolsFeetGoWithTheSlider) {
  const std::string& page = report_of_a_rod();
  const nlohmann::json all = told(open(with_script(page, script_that(std::string(watch_feet) + R"(
    await later(() => move(0.2));
    told.early = tellFeet();
    await later(() => move(0.8));
    told.late = tellFeet();
  )"),
                                                   folder)));
  for (const char* when : {"early", "late"}) {
    const nlohmann::json& feet = all[when];
    ASSERT_EQ(feet["drawn"].size(), 2U) << "at the probe, then at the proxy";
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec3 at_mm = vec_of(feet[i == 0 ? "probe" : "proxy"]);
      const nlohmann::json& w = feet[i == 0 ? "probe_turn" : "proxy_turn"];
      const Turn turn{w[0].get<double>(), w[1].get<double>(), w[2].get<double>(), w[3].get<double>()};
      for (std::size_t foot = 0; foot < 6; ++foot) {
        const Vec3 due_mm = at_mm + rotated(turn, vec_of(feet["levers"][foot]));
        EXPECT_LT(distance(vec_of(feet["drawn"][i], 3 * foot), due_mm), 1e-3) << when << foot;
      }
    }
  }
  EXPECT_GT(distance(vec_of(all["early"]["drawn"][1]), vec_of(all["late"]["drawn"][1])), 1.0) << "[mm] the first foot moved";
}

TEST_F(Browser, AToolsFeetAreDrawnUntilTheyAreTurnedOff) {
  const std::string& page = report_of_a_rod();
  const auto look = [&](const char* use) {
    return open(with_script(page, script_that(std::string(watch_feet) + "await later(() => move(0.5));" + use), folder));
  };
  const char* const off = R"(
    await later(() => {
      for (const label of document.querySelectorAll('#key label'))
        if (/feet of the tool|the tool as/.test(label.textContent)) label.querySelector('input').click();
    });)";
  const Shown with = look(""), again = look(""), without = look(off);
  EXPECT_GT(difference(with, without), 2e-4) << "six dots at the proxy, six at the probe";
  EXPECT_LT(difference(with, without), 0.02) << "nothing but the feet";
  EXPECT_EQ(difference(with, again), 0.0);
}

TEST_F(Browser, TwoTracesAreZoomedTogetherAndSayTheirNamesAtOnce) {
  RunOptions again = options("again", 3.0);
  again.hand = (recording->folder / "trace/ticks.csv").string();
  again.scene_options.sets.emplace_back("mode.skin.level.skin.strength_n", "0.2");
  run(again);
  const std::string pair = report_html(recording->folder / "trace", {.beside = folder / "again"});
  const std::string zoom = script_that(R"(
    told.curves = Plots.graphs.map((one) => one.values.textContent);
    await later(() => drag(document.querySelector('#plot-force canvas:last-of-type'), [150, 60], [200, 0], 10));
    told.windows = windows();
    await later(() => Report.show(1.0));
  )");
  // The page has no stage; the script reports one.
  const std::string stage = "<div id=\"stage\"></div></main>";
  std::string staged = pair;
  staged.replace(staged.rfind("</main>"), 7, stage);
  const Shown shown = open(with_script(staged, zoom, folder));
  EXPECT_TRUE(became(shown, "with-plots"));
  const nlohmann::json all = told(shown);
  ASSERT_EQ(all["windows"].size(), 3u);
  EXPECT_EQ(all["windows"][0], all["windows"][1]);
  EXPECT_EQ(all["windows"][0], all["windows"][2]);
  EXPECT_LT(all["windows"][0][1].get<double>() - all["windows"][0][0].get<double>(), 2.0) << "zoomed";
  for (const char* name : {"first", "second"}) EXPECT_THAT(all["curves"][0].get<std::string>(), HasSubstr(name));
}

}  // namespace browser_test
}  // namespace palpa
