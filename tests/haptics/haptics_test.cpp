// The benchmark itself: published data, truths, scores, and the protocol under faulty renderers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>

#include "bench/haptics/run.h"
#include "bench/haptics/score.h"
#include "bench/haptics/shape.h"
#include "bench/haptics/suite.h"
#include "palpa/base/load_error.h"
#include "tests/shared_data.h"

namespace palpa::haptics {
namespace haptics_test {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::IsSubsetOf;
using testing::Not;

const fs::path sources = fs::path(PALPA_SOURCE_FOLDER) / "bench/haptics";
const fs::path scripts = fs::path(PALPA_SOURCE_FOLDER) / "tests/haptics";

std::string python(const fs::path& script) { return std::string("'") + PALPA_PYTHON3 + "' '" + script.string() + "'"; }

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  EXPECT_TRUE(in) << file;
  return {std::istreambuf_iterator<char>(in), {}};
}

std::set<std::string> lines_of(const fs::path& file) {
  std::ifstream in(file);
  std::set<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.insert(line);
  return lines;
}

class Folder {
 public:
  Folder() {
    char name[] = "/tmp/palpa-haptics-XXXXXX";
    path = ::mkdtemp(name);
  }
  ~Folder() { fs::remove_all(path); }
  fs::path path;
};

/// The whole set without scans, made once.
const fs::path& made() {
  static const Folder folder;
  static const bool done = [] {
    make(folder.path, {.sources = sources});
    return true;
  }();
  EXPECT_TRUE(done);
  return folder.path;
}

const fs::path& made_quick() {
  static const Folder folder;
  static const bool done = [] {
    make(folder.path, {.sources = sources, .quick = true});
    return true;
  }();
  EXPECT_TRUE(done);
  return folder.path;
}

const std::vector<MadeCase>& cases() {
  static const std::vector<MadeCase> all = read_cases(made(), false);
  return all;
}

std::vector<Vec3> truth_of(const MadeCase& one) {
  std::vector<Vec3> forces_n;
  for (const Touch& touch : one.touches) forces_n.push_back(touch.force_n);
  return forces_n;
}

TEST(Data, AreThoseThatWerePublished) {
  const std::set<std::string> published = lines_of(sources / "SHA256SUMS"), own = lines_of(made() / "SHA256SUMS");
  EXPECT_GT(own.size(), 150u);
  EXPECT_THAT(own, IsSubsetOf(published));
}

TEST(Data, OfTheScanAreThoseThatWerePublished) {
  const fs::path head = palpa::test::shared_data("ct_head_cranium/cranium.nhdr");
  const char* bin = std::getenv("PALPA_BIN");
  const fs::path reader = fs::path(bin ? bin : "") / "palpa-read";
  if (!fs::exists(head) || !fs::exists(reader)) GTEST_SKIP() << "without the CT head, or without palpa-read";
  ::setenv("PALPA_READER", reader.c_str(), 1);
  const Folder folder;
  make(folder.path, {.sources = sources, .head_file = head});
  EXPECT_EQ(lines_of(folder.path / "SHA256SUMS"), lines_of(sources / "SHA256SUMS"));
  for (const MadeCase& one : read_cases(folder.path, false)) {
    if (one.family != "scans") continue;
    for (const auto& [name, value] : score(one, truth_of(one), folder.path / "truth")) EXPECT_LT(std::abs(value), 1e-3) << name;
  }
}

TEST(Shapes, KnowTheirDistanceAndTheirNormal) {
  const nlohmann::json shapes[] = {{{"kind", "plane"}, {"turn", {5, 1, 2, -1}}},
                                   {{"kind", "sphere"}, {"radius_m", 0.025}},
                                   {{"kind", "bumpy_sphere"}, {"radius_m", 0.025}},
                                   {{"kind", "torus"}, {"radius_m", 0.020}, {"tube_m", 0.009}, {"turn", {1, 1, 0, 0}}},
                                   {{"kind", "plate"}, {"thickness_m", 0.003}},
                                   {{"kind", "wedge"}, {"opening_deg", 30}},
                                   {{"kind", "groove"}, {"opening_deg", 60}, {"turn", {3, 1, -2, 1}}}};
  Noise random(5);
  for (const auto& description : shapes) {
    const Shape shape = shape_of(description, {});
    int near = 0;
    for (int i = 0; i < 3000; ++i) {
      const Vec3 x = 0.02 * Vec3{random.next(), random.next(), random.next()};
      const double depth_m = shape.depth_m(x);
      if (std::abs(depth_m) > 1e-3) continue;
      ++near;
      constexpr double h_m = 1e-7;
      const Vec3 uphill = Vec3{shape.depth_m(x + Vec3{h_m, 0, 0}) - depth_m, shape.depth_m(x + Vec3{0, h_m, 0}) - depth_m,
                               shape.depth_m(x + Vec3{0, 0, h_m}) - depth_m} /
                          h_m;
      EXPECT_NEAR(norm(uphill), 1.0, 0.03) << description;
      // An edge has no single normal.
      const Vec3 nearest = x + depth_m * shape.outward(x);
      if (description["kind"] != "wedge" && description["kind"] != "groove") {
        EXPECT_LT(std::abs(shape.depth_m(nearest)), 0.05 * std::abs(depth_m) + 1e-9) << description;
      }
    }
    EXPECT_GT(near, 20) << description;
  }
}

// For any maker: the hand's spring ends on the shape, and pulls along its normal without friction.
TEST(Truth, IsOnTheShapeAndAlongItsNormal) {
  int looked_at = 0;
  for (const MadeCase& one : cases()) {
    if (one.shape.is_null()) continue;
    const Shape shape = shape_of(one.shape, made() / "truth");
    const bool edges = one.shape["kind"] == "groove";
    for (const Touch& touch : one.touches) {
      if (norm(touch.force_n) < 0.01) continue;
      const Vec3 place = touch.probe_m + touch.force_n / stiffness_n_per_m;
      ASSERT_LT(std::abs(shape.depth_m(place)), 1e-8) << one.name;
      ++looked_at;
      if (!shape.outward || edges) continue;
      const Vec3 n = shape.outward(place);
      const double across = norm(cross(touch.force_n, n)), along = dot(touch.force_n, n);
      ASSERT_GT(along, 0.0) << one.name;
      ASSERT_LE(across / along, std::tan(one.friction_deg * M_PI / 180.0) + 1e-5) << one.name;
      if (touch.phase == Phase::sliding) {
        ASSERT_NEAR(across / along, std::tan(one.friction_deg * M_PI / 180.0), 1e-5) << one.name;
      }
    }
  }
  EXPECT_GT(looked_at, 50000);
}

// A groove's free space is convex: the proxy is the nearest free point.
TEST(Truth, OfGroovesIsTheNearestFreePlace) {
  Noise random(3);
  for (const MadeCase& one : cases()) {
    if (one.family != "grooves") continue;
    const Shape shape = shape_of(one.shape, {});
    for (std::size_t i = 0; i < one.touches.size(); i += 50) {
      const Touch& touch = one.touches[i];
      const Vec3 place = touch.probe_m + touch.force_n / stiffness_n_per_m;
      for (int k = 0; k < 50; ++k) {
        const Vec3 other = place + 1e-3 * Vec3{random.next(), random.next(), random.next()};
        if (shape.depth_m(other) <= 0.0) {
          ASSERT_GT(distance(other, touch.probe_m), distance(place, touch.probe_m) - 1e-8);
        }
      }
    }
  }
}

TEST(Hands, MoveLikeHands) {
  for (const MadeCase& one : cases()) {
    for (std::size_t i = 1; i < one.touches.size(); ++i)
      ASSERT_LT(distance(one.touches[i].probe_m, one.touches[i - 1].probe_m), 5.01e-3) << one.name << ", tick " << i;
  }
}

TEST(Volumes, HaveTheirSurfaceAtTheLevelThatRenderersAreTold) {
  const Sampling sampling{.samples = 64};
  const nlohmann::json description{{"kind", "torus"}, {"radius_m", 0.020}, {"tube_m", 0.009}};
  const SampledVolume volume = sampled(description, sampling);
  const double level = surface_rule(sampling)["levels"][0]["value"];
  for (int i = 0; i < 100; ++i) {
    const double around = 0.063 * i, tube = 0.41 * i;
    const Vec3 from_axis{std::cos(around), std::sin(around), 0};
    const Vec3 n = std::cos(tube) * from_axis + Vec3{0, 0, std::sin(tube)};
    const Vec3 place = 0.020 * from_axis + 0.009 * n;
    EXPECT_LT(std::abs(volume.value(place) - level) / norm(volume.slope_per_m(place)), 0.05 * volume.grid.spacing_m.x);
    EXPECT_LT(norm(cross(normalized(volume.slope_per_m(place)), n)), 0.05);
  }
}

TEST(Scores, FindNothingWrongWithTheTruth) {
  for (const MadeCase& one : cases()) {
    const Scores scores = score(one, truth_of(one), made() / "truth");
    EXPECT_FALSE(scores.empty()) << one.name;
    for (const auto& [name, value] : scores) EXPECT_NEAR(value, 0.0, 1e-5) << one.name << ": " << name;
  }
}

TEST(Scores, FindNothingRightWithoutAForce) {
  for (const MadeCase& one : cases()) {
    const Scores scores = score(one, std::vector<Vec3>(one.touches.size()), made() / "truth");
    const auto is = [&](const char* name, double value) {
      if (scores.contains(name)) {
        EXPECT_NEAR(scores.at(name), value, 1e-6) << one.name << ": " << name;
      }
    };
    is("force_share", 100.0);
    is("lost_share", 100.0);
    is("direction_p50_deg", 180.0);
    is("false_rest_share", 100.0);
    is("friction_p50_deg", one.friction_deg);
    for (const char* name : {"drift_um", "energy_mj", "ripple_mn"}) {
      if (scores.contains(name)) {
        EXPECT_TRUE(std::isinf(scores.at(name))) << one.name << ": " << name;
      }
    }
    for (const char* name : {"surface_p50_mm", "break_n"}) {
      if (scores.contains(name)) {
        EXPECT_GT(scores.at(name), 0.5) << one.name << ": " << name;
      }
    }
  }
}

/// A hand `turns` times round a ball of 25 mm at a depth of 1 N, then still.
MadeCase round_a_ball(int period_ticks, int turns, int still_ticks) {
  MadeCase one{.shape = {{"kind", "sphere"}, {"radius_m", 0.025}}, .period_ticks = period_ticks};
  for (int i = 0; i <= turns * period_ticks + still_ticks; ++i) {
    const double angle = 2.0 * M_PI * std::min(i, turns * period_ticks) / period_ticks;
    const Vec3 n{std::cos(angle), std::sin(angle), 0};
    one.touches.push_back({0.023 * n, 1.0 * n, i > turns * period_ticks ? Phase::still : Phase::moving});
  }
  return one;
}

/// The scores of a falsified truth.
Scores score_of(MadeCase one, std::vector<std::string> wanted, const std::function<Vec3(std::size_t, const Touch&)>& wrong) {
  one.scores = std::move(wanted);
  std::vector<Vec3> forces_n;
  for (std::size_t i = 0; i < one.touches.size(); ++i) forces_n.push_back(wrong(i, one.touches[i]));
  return score(one, forces_n, {});
}

TEST(Scores, OfASurfaceThatIsElsewhereAreHowFar) {
  const Scores scores = score_of(round_a_ball(500, 2, 0), {"surface", "direction", "force"},
                                 [](std::size_t, const Touch& touch) { return 0.9 * touch.force_n; });
  EXPECT_NEAR(scores.at("surface_p50_mm"), 0.2, 1e-9);
  EXPECT_NEAR(scores.at("surface_p99_mm"), 0.2, 1e-9);
  EXPECT_NEAR(scores.at("direction_p99_deg"), 0.0, 1e-6);
  EXPECT_NEAR(scores.at("force_rms_n"), 0.1, 1e-9);
  EXPECT_NEAR(scores.at("force_share"), 10.0, 1e-9);
}

TEST(Scores, OfAForceThatIsTurnedAreTheAngle) {
  const double angle = 3.0 * M_PI / 180.0;
  const Scores scores = score_of(round_a_ball(500, 2, 0), {"direction"}, [&](std::size_t, const Touch& touch) {
    const Vec3 n = normalized(touch.force_n);
    return std::cos(angle) * touch.force_n + std::sin(angle) * cross(Vec3{0, 0, 1}, n);
  });
  EXPECT_NEAR(scores.at("direction_p50_deg"), 3.0, 1e-9);
}

TEST(Scores, OfADragAreItsWorkAndNoDrift) {
  // 0.1 N against the motion, all round a circle of 23 mm.
  const Scores scores = score_of(round_a_ball(2000, 3, 0), {"energy", "drift"}, [](std::size_t, const Touch& touch) {
    return touch.force_n - 0.1 * cross(Vec3{0, 0, 1}, normalized(touch.force_n));
  });
  EXPECT_NEAR(scores.at("energy_mj"), -1e3 * 0.1 * 2.0 * M_PI * 0.023, 1e-4);
  EXPECT_NEAR(scores.at("drift_um"), 0.0, 1e-6);
}

TEST(Scores, OfWhatCreepsAreHowFarInATurn) {
  const Scores scores = score_of(round_a_ball(400, 5, 0), {"drift"}, [](std::size_t i, const Touch& touch) {
    const double crept_m = 2e-6 * std::max(0.0, static_cast<double>(i) / 400.0 - 1.0);
    return touch.force_n + Vec3{0, 0, stiffness_n_per_m * crept_m};
  });
  EXPECT_NEAR(scores.at("drift_um"), 2.0, 1e-9);
}

TEST(Scores, OfAForceThatRattlesAreItsSteps) {
  const Scores scores = score_of(round_a_ball(400, 2, 200), {"ripple", "rest"}, [](std::size_t i, const Touch& touch) {
    return touch.force_n + Vec3{0, 0, i % 2 == 0 ? 0.01 : -0.01};
  });
  EXPECT_NEAR(scores.at("ripple_mn"), 20.0, 1e-9);
  EXPECT_EQ(scores.at("restless_share"), 100.0);
  EXPECT_EQ(scores.at("false_rest_share"), 0.0);
}

TEST(Scores, OfAHandThatStopsShortAreAFalseRest) {
  const Scores scores = score_of(round_a_ball(400, 2, 200), {"rest", "lost"}, [](std::size_t, const Touch& touch) {
    return touch.force_n + Vec3{0, 0, 0.2};
  });
  EXPECT_EQ(scores.at("false_rest_share"), 100.0);
  EXPECT_EQ(scores.at("restless_share"), 0.0);
  EXPECT_EQ(scores.at("lost_share"), 0.0);
}

TEST(Scores, OfWhatLetsGoAreTheShareThatIsLost) {
  const Scores scores = score_of(round_a_ball(400, 1, 0), {"lost", "break"},
                                 [](std::size_t i, const Touch& touch) { return i < 100 ? Vec3{} : 1.3 * touch.force_n; });
  EXPECT_NEAR(scores.at("lost_share"), 100.0 * 100 / 401, 1e-9);
  EXPECT_NEAR(scores.at("break_n"), 0.3, 1e-9);
}

TEST(Scores, OfLessThanHalfAForceAreALoss) {
  const auto lost = [](double share) {
    return score_of(round_a_ball(400, 1, 0), {"lost"}, [=](std::size_t, const Touch& touch) { return share * touch.force_n; })
        .at("lost_share");
  };
  EXPECT_EQ(lost(0.51), 0.0);
  EXPECT_EQ(lost(0.49), 100.0);
  EXPECT_EQ(lost(-1.0), 100.0);
}

TEST(Scores, OfFrictionAreTheAngleThatIsMissing) {
  MadeCase one{.shape = {{"kind", "plane"}}};
  const auto at_deg = [](double angle) { return Vec3{std::sin(angle * M_PI / 180.0), std::cos(angle * M_PI / 180.0), 0}; };
  for (int i = 0; i < 100; ++i)
    one.touches.push_back({{1e-5 * i, -2e-3, 0}, at_deg(20.0), i < 50 ? Phase::moving : Phase::sliding});
  const Scores scores = score_of(one, {"friction"}, [&](std::size_t i, const Touch&) { return at_deg(i < 50 ? 0.0 : 17.0); });
  EXPECT_NEAR(scores.at("friction_p50_deg"), 3.0, 1e-9);
  EXPECT_NEAR(scores.at("friction_p99_deg"), 3.0, 1e-9);
}

// ---- The protocol

const MadeCase& small_case() {
  static const std::vector<MadeCase> few = read_cases(made_quick(), true);
  return *std::find_if(few.begin(), few.end(), [](const MadeCase& one) { return one.name == "groove-60"; });
}

Answer answer_of(const std::string& command, const Limits& limits = {}) {
  return render(command, small_case().file, small_case().probe_lines, force_limit_n, limits);
}

TEST(Protocol, BringsTheTruthBackAsItIs) {
  const Answer answer = answer_of(python(scripts / "play_truth.py"));
  EXPECT_EQ(answer.end, Answer::End::whole) << answer.reason;
  EXPECT_EQ(answer.forces_n, truth_of(small_case()));
  EXPECT_TRUE(answer.inside_us.empty());
}

/// A renderer in a line of shell; $0 is the case.
std::string shell(const std::string& line) { return "sh -c '" + line + "'"; }

TEST(Protocol, BearsWhateverARendererDoes) {
  struct Wrong {
    const char* line;
    const char* reason;
  };
  const Wrong wrong[] = {
      {"exit 3", "no first line"},
      {"echo hello; cat", "hello"},
      {"echo ready; exit 0", "tick 0"},
      {"echo ready; read p; echo 1 2 3; exit 0", "tick 1"},
      {"echo ready; while read p; do echo 1 2; done", "tick 0: '1 2' is no force"},
      {"echo ready; while read p; do echo 1 2 nan; done", "is no force"},
      {"echo ready; while read p; do echo 1 2 3 4 5; done", "is no force"},
      {"echo ready; while read p; do echo 1 2 3 four; done", "is no force"},
      {"echo ready; read p; sleep 60", "no answer"},
      {"echo ready; read p; head -c 5000 /dev/zero", "no answer"},
      {"sleep 60", "no first line"},
  };
  for (const Wrong& one : wrong) {
    const Answer answer = answer_of(shell(one.line), {.load_s = 2.0, .tick_s = 1.0});
    EXPECT_EQ(answer.end, Answer::End::failed) << one.line;
    EXPECT_THAT(answer.reason, HasSubstr(one.reason)) << one.line;
    EXPECT_EQ(answer.forces_n.size(), small_case().touches.size());
    EXPECT_EQ(answer.forces_n.back(), Vec3{});
  }
}

TEST(Protocol, HasAnEndForACase) {
  const Answer answer = answer_of(shell("echo ready; while read p; do sleep 0.1; echo 0 0 0; done"), {.case_s = 0.5});
  EXPECT_EQ(answer.end, Answer::End::failed);
  EXPECT_THAT(answer.reason, HasSubstr("the time for a case is over"));
}

TEST(Protocol, LetsARendererSayThatItDoesNotKnowARule) {
  const Answer answer = answer_of(shell("echo unsupported: no grooves"));
  EXPECT_EQ(answer.end, Answer::End::unsupported);
  EXPECT_EQ(answer.reason, " no grooves");
}

TEST(Protocol, ShortensWhatNoDeviceWouldGiveAndTakesTheRenderersOwnTime) {
  const Answer answer = answer_of(shell("echo ready; while read p; do echo 0 -30 40 12.5; done"));
  EXPECT_EQ(answer.end, Answer::End::whole) << answer.reason;
  EXPECT_NEAR(norm(answer.forces_n.front()), force_limit_n, 1e-12);
  EXPECT_NEAR(answer.forces_n.front().z, 0.8 * force_limit_n, 1e-12);
  EXPECT_EQ(answer.inside_us, std::vector<double>(small_case().touches.size(), 12.5));
}

// ---- The runner

std::string palpa_by(const std::string& law) {
  const char* bin = std::getenv("PALPA_BIN");
  return "'" + std::string(bin ? bin : ".") + "/bench_haptics_palpa' --law " + law;
}

TEST(Runner, MeasuresEveryRendererTwiceAlike) {
  const std::vector<NamedRenderer> renderers{{"truth", python(scripts / "play_truth.py")},
                                             {"exact", palpa_by("exact")},
                                             {"paper-2005", palpa_by("paper-2005")},
                                             {"penalty", python(sources / "penalty.py")}};
  const std::vector<Result> once = run(made_quick(), renderers, true), again = run(made_quick(), renderers, true);
  EXPECT_EQ(score_rows(once), score_rows(again));
  EXPECT_EQ(tables(once), tables(again));
  for (const Result& result : once) {
    EXPECT_NE(result.end, Answer::End::failed) << result.renderer << ", " << result.name << ": " << result.reason;
    if (result.renderer != "truth") continue;
    for (const auto& [name, value] : result.scores) EXPECT_NEAR(value, 0.0, 1e-5) << result.name << ": " << name;
  }
  EXPECT_THAT(tables(once), HasSubstr("| penalty | 0 of 1 | – |")) << "of a family that it does not know";
}

TEST(Runner, CountsWhatFailsAsNoForce) {
  const std::vector<Result> results = run(made_quick(), {named("broken=" + shell("echo ready; exit 0"))}, true);
  for (const Result& result : results) {
    EXPECT_EQ(result.end, Answer::End::failed);
    if (result.scores.contains("force_share")) {
      EXPECT_NEAR(result.scores.at("force_share"), 100.0, 1e-9);
    }
  }
  EXPECT_THAT(tables(results), HasSubstr("| broken | 1 of 1, 1 failed |"));
}

TEST(Runner, SaysWhatIsWrongWithItsFolder) {
  const Folder empty;
  try {
    read_cases(empty.path, false);
    FAIL() << "an empty folder has cases";
  } catch (const LoadError& error) {
    EXPECT_THAT(error.what(), HasSubstr("make them with bench_haptics make"));
  }
  make(empty.path, {.sources = sources, .quick = true});
  const fs::path truth = empty.path / "truth/groove-60.csv";
  fs::resize_file(truth, fs::file_size(truth) / 2);
  EXPECT_THROW(read_cases(empty.path, false), LoadError);
  std::ofstream(empty.path / "truth/groove-60.json") << "{}";
  EXPECT_THROW(read_cases(empty.path, false), LoadError);
}

TEST(Runner, TakesARenderersNameBeforeItsCommand) {
  EXPECT_EQ(named("a=b c=d").name, "a");
  EXPECT_EQ(named("a=b c=d").command, "b c=d");
  EXPECT_EQ(named("./a b=c").command, "./a b=c");
}

// Data makers and scores use only Palpa's vectors, sine, checksum and files.
TEST(Measure, KnowsNothingOfHowPalpaFeels) {
  static const std::regex include(R"re(#include [<"](palpa/[^>"]+)[>"])re");
  const std::set<std::string> allowed{"palpa/solver/vec3.h",      "palpa/base/load_error.h", "palpa/device/sine_cosine.h",
                                      "palpa/base/input_file.h",  "palpa/base/new_file.h",   "palpa/data/sha256.h",
                                      "palpa/file/read_volume.h", "palpa/data/filter.h",     "palpa/data/grid_base.h"};
  int files = 0;
  for (const auto& entry : fs::directory_iterator(sources)) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with(".h") && !name.ends_with(".cpp")) continue;
    const std::string text = text_of(entry.path());
    std::vector<std::string> included;
    for (std::sregex_iterator at(text.begin(), text.end(), include), end; at != end; ++at) included.push_back((*at)[1]);
    if (name == "palpa_renderer.cpp") {
      EXPECT_THAT(included, Contains("palpa/palpa.h"));
      EXPECT_THAT(included, Not(Contains(HasSubstr("haptics"))));
    } else {
      EXPECT_THAT(included, IsSubsetOf(allowed)) << name;
    }
    ++files;
  }
  EXPECT_GT(files, 10);
}

}  // namespace haptics_test
}  // namespace palpa::haptics
