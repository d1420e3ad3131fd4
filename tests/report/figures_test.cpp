// The numbers in the figures obey the paper's closed forms; the files are there and well-formed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <numbers>
#include <random>

#include "palpa/base/load_error.h"
#include "tests/report/markup.h"
#include "tools/figures/paper_figures.h"

namespace palpa {
namespace figures_test {

namespace fs = std::filesystem;

TEST(Figure1, ExertedForcesAreTheStrengthAndFeltOnesTheSpringUpToIt) {
  constexpr double s = 1.3, k = 400.0;
  for (const PrimitiveKind kind : {PrimitiveKind::point, PrimitiveKind::line, PrimitiveKind::plane, PrimitiveKind::directed}) {
    const detail::ForceLaw law = detail::force_law(kind, s, k);
    ASSERT_GT(law.places_mm.size(), 50u);
    for (std::size_t i = 0; i < law.places_mm.size(); ++i) {
      const double place_mm = law.places_mm[i], pull_n = -1e-3 * k * place_mm;
      const double sign = place_mm > 0 ? -1.0 : place_mm < 0 ? 1.0 : 0.0;
      const double exerted_n = kind == PrimitiveKind::directed ? s
                               : kind == PrimitiveKind::plane  ? s * std::max(0.0, sign)
                                                               : s * sign;
      const double felt_n = kind == PrimitiveKind::directed ? s
                            : kind == PrimitiveKind::plane  ? std::clamp(pull_n, 0.0, s)
                                                            : std::clamp(pull_n, -s, s);
      EXPECT_NEAR(law.exerted_n[i], exerted_n, 1e-12) << name_of(kind) << " at " << place_mm;
      EXPECT_NEAR(law.felt_n[i], felt_n, 1e-9 * k) << name_of(kind) << " at " << place_mm;
    }
  }
}

TEST(Figure2, ForcesCancelAndEachIsOneThatItsPrimitiveCanExert) {
  const detail::PlaneAndPoint b = detail::plane_and_point();
  EXPECT_LT(norm(b.plane_force_n + b.point_force_n + b.spring_force_n), 1e-6);
  EXPECT_NEAR(norm(b.plane_force_n), dot(b.plane_force_n, b.plane.direction), 1e-12);
  EXPECT_LE(norm(b.plane_force_n), b.plane.strength_n + 1e-12);
  EXPECT_NEAR(norm(b.point_force_n), b.point.strength_n, 1e-9) << "the proxy is away from the point";
  EXPECT_GT(dot(b.point_force_n, b.point.position_m - b.proxy_m), 0.0);
  EXPECT_NEAR(b.proxy_m.y, 0.0, 1e-9) << "the plane holds";
  EXPECT_LT(norm(b.spring_force_n - b.stiffness_n_per_m * (b.probe_m - b.proxy_m)), 1e-12);
}

TEST(Figure3, TheProxyLeadsByAtMostStrengthOverStiffness) {
  constexpr double s = 0.8, k = 200.0;  // s/k = 4 mm
  const std::vector<double> probes_mm{6, 1, 0, -1, -3.9, -4, -4.1, -20, -2, 5};
  const std::vector<double> proxies_mm = detail::proxies_over_plane_mm(probes_mm, s, k);
  for (std::size_t i = 0; i < probes_mm.size(); ++i) {
    EXPECT_NEAR(proxies_mm[i], probes_mm[i] + std::clamp(-probes_mm[i], 0.0, 4.0), 1e-6) << probes_mm[i];
  }
}

TEST(Figure4, FrictionIsAPlayOfStrengthOverStiffness) {
  constexpr double k = 100.0, line_n = 0.4;
  const detail::FrictionLoop loop = detail::friction_loop(0.006, 1.0, line_n, k, 0.02, 150);
  double play_mm = 0.0;  // the play operator: the proxy follows where the probe is more than s/k away
  for (std::size_t i = 0; i < loop.probe_mm.size(); ++i) {
    play_mm = std::clamp(play_mm, loop.probe_mm[i] - 1e3 * line_n / k, loop.probe_mm[i] + 1e3 * line_n / k);
    EXPECT_NEAR(loop.proxy_mm[i], play_mm, 1e-5) << i;
    EXPECT_NEAR(loop.normal_n[i], k * 0.006, 1e-6) << i;
    EXPECT_NEAR(loop.friction_n[i], k * 1e-3 * (play_mm - loop.probe_mm[i]), 1e-6) << i;
  }
}

TEST(Figure5, TheLawOf2003IsOffByTheCosineAndOursIsNot) {
  const Vec3 probe_m{0.004, 0.009, 0.0};
  for (int angle_deg = 5; angle_deg < 180; angle_deg += 5) {
    const double cosine = std::abs(std::cos(angle_deg * std::numbers::pi / 180.0));
    EXPECT_NEAR(distance(detail::proxy_between_free_planes("ikits-2003", angle_deg, probe_m), probe_m), cosine * norm(probe_m),
                1e-12)
        << angle_deg;
    EXPECT_LT(distance(detail::proxy_between_free_planes("exact", angle_deg, probe_m), probe_m), 1e-9) << angle_deg;
  }
}

TEST(Figure6, SharesAreThoseOfTheValues) {
  std::mt19937_64 random(3);
  std::lognormal_distribution<double> spread(-8.0, 4.0);
  std::vector<double> values{0.0, 0.0, 1e-7, 1e-7, 2.0};
  for (int i = 0; i < 500; ++i) values.push_back(spread(random));
  std::sort(values.begin(), values.end());
  constexpr double low = 1e-6;
  const Series shares = detail::shares_up_to(values, low);
  ASSERT_EQ(shares.xs.size(), shares.ys.size());
  EXPECT_EQ(shares.xs.front(), low);
  EXPECT_EQ(shares.xs.back(), values.back());
  EXPECT_EQ(shares.ys.back(), 100.0);
  EXPECT_TRUE(std::is_sorted(shares.ys.begin(), shares.ys.end()));
  EXPECT_EQ(std::adjacent_find(shares.xs.begin(), shares.xs.end(), std::greater_equal()), shares.xs.end());
  for (std::size_t i = 0; i < shares.xs.size(); ++i) {
    const auto up_to = std::count_if(values.begin(), values.end(), [&](double value) { return value <= shares.xs[i]; });
    EXPECT_NEAR(shares.ys[i], 100.0 * static_cast<double>(up_to) / static_cast<double>(values.size()), 1e-9);
  }
  EXPECT_TRUE(detail::shares_up_to({}, low).xs.empty());
}

/// The share [%] that a curve shows at a place: that of its last point up to there.
double share_at(const Series& curve, double x) {
  const auto after = std::upper_bound(curve.xs.begin(), curve.xs.end(), x);
  return after == curve.xs.begin() ? 0.0 : curve.ys[static_cast<std::size_t>(after - curve.xs.begin() - 1)];
}

TEST(Figure6, OursIsProvenEarlierOnesAreOffWhereConstraintsAreObliqueAndExactWhereTheyAreNot) {
  const Figure figure = laws_figure(PALPA_SCENES_FOLDER);
  ASSERT_EQ(figure.sheet.panels.size(), 4u);
  std::vector<Plot> plots;
  for (const auto& panel : figure.sheet.panels) plots.push_back(std::get<Plot>(panel));
  for (const Plot& plot : plots) {
    ASSERT_EQ(plot.series.size(), 10u) << plot.title << ": a curve and its signs for each of five laws";
    for (std::size_t law = 0; law < 5; ++law) {
      const Series &curve = plot.series[law], &signs = plot.series[5 + law];
      EXPECT_TRUE(std::is_sorted(curve.xs.begin(), curve.xs.end())) << plot.title << law;
      EXPECT_TRUE(std::is_sorted(curve.ys.begin(), curve.ys.end())) << plot.title << law;
      EXPECT_EQ(curve.ys.back(), 100.0) << plot.title << law;
      ASSERT_EQ(signs.xs.size(), 2u);
      for (std::size_t i = 0; i < 2; ++i) {
        if (signs.xs[i] < plot.x_range->first) continue;
        // Where many values are the same the curve goes straight up.
        EXPECT_GE(share_at(curve, signs.xs[i]), signs.ys[i] - 0.1) << plot.title << law << ": signs lie on the curve";
        EXPECT_LE(share_at(curve, (1.0 - 1e-12) * signs.xs[i]), signs.ys[i] + 0.1) << plot.title << law;
      }
    }
  }
  enum : std::size_t { exact, paper_2005, ikits_2003, sequential, no_proxy };
  constexpr double proven_mm = 1e-6, felt_mm = 0.1;
  for (const std::size_t panel : {0u, 2u}) EXPECT_EQ(share_at(plots[panel].series[exact], proven_mm), 100.0);
  for (const std::size_t panel : {1u, 3u}) EXPECT_EQ(share_at(plots[panel].series[exact], 1e-4), 100.0) << "it is the measure";
  for (const std::size_t law : {ikits_2003, sequential, no_proxy})
    EXPECT_LT(share_at(plots[0].series[law], felt_mm), 50.0) << law;
  for (const std::size_t law : {ikits_2003, sequential}) EXPECT_EQ(share_at(plots[2].series[law], 1e-9), 100.0) << law;
  EXPECT_LT(share_at(plots[2].series[paper_2005], proven_mm), 50.0);
}

TEST(Figure6, SaysWhichSceneIsNotThere) {
  try {
    laws_figure("/no/such/folder");
    ADD_FAILURE();
  } catch (const LoadError& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("/no/such/folder/many_phantom.toml"));
  }
}

class FigureFiles : public testing::Test {
 protected:
  FigureFiles() {
    std::string name = (fs::temp_directory_path() / "palpa-figures-test-XXXXXX").string();
    folder = ::mkdtemp(name.data());
  }
  ~FigureFiles() override { fs::remove_all(folder); }
  static std::string read(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path folder;
};

TEST_F(FigureFiles, AreThereWellFormedAndTheSameTwice) {
  const std::vector<fs::path> files = write_figures(folder / "a");
  EXPECT_EQ(files.size(), 2 * paper_figures().size());
  write_figures(folder / "b");
  for (const fs::path& file : files) {
    const std::string bytes = read(file);
    EXPECT_EQ(bytes, read(folder / "b" / file.filename())) << file;
    if (file.extension() == ".svg") {
      EXPECT_EQ(markup_error(bytes, false), "") << file;
    } else {
      EXPECT_TRUE(bytes.starts_with("\x89PNG\r\n")) << file;
    }
  }
}

TEST_F(FigureFiles, CannotGoWhereNothingCanBeWritten) {
  std::ofstream(folder / "file") << "x";
  fs::create_directories(folder / "taken" / "fig1-primitives.svg");  // holds for root as well
  for (const fs::path& out : {folder / "file", folder / "file" / "below", folder / "taken"}) {
    try {
      write_figures(out);
      ADD_FAILURE() << out;
    } catch (const LoadError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith(out.string())) << out;
      EXPECT_THAT(error.what(), testing::HasSubstr("--out"));
    }
  }
}

}  // namespace figures_test
}  // namespace palpa
