// Written and read numbers under a decimal comma, equal in all bytes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "palpa/base/printed.h"
#include "palpa/data/analytic.h"
#include "palpa/data/statistics.h"
#include "palpa/device/hand.h"
#include "palpa/device/open_device.h"
#include "palpa/file/convert.h"
#include "palpa/file/read_volume.h"
#include "palpa/loop/loop.h"
#include "palpa/report/report.h"
#include "palpa/scene/first_scene.h"
#include "palpa/study/check.h"
#include "palpa/study/compare_laws.h"
#include "palpa/study/map.h"
#include "palpa/study/map_file.h"
#include "palpa/trace/export_trace.h"
#include "palpa/view/map_picture.h"
#include "palpa/view/picture.h"
#include "palpa/view/plot.h"
#include "palpa/view/volume_picture.h"
#include "tests/report/comma_locale.h"
#include "tests/study/study_fixture.h"

namespace palpa {
namespace locale_test {

namespace fs = std::filesystem;

/// The phantom with a cloud and slices, whose drawing has shaders with numbers in them.
constexpr const char* seen_scene = R"(
[[view.layer]]
field = "head"
show = "volume"
[[view.layer]]
field = "head"
show = "slices"
)";

/// Two traces, recorded once for all tests: the scene's, and one of a weaker skin under the same hand.
struct Traces : StudyFolder {
  Traces() {
    RunOptions primitives = options("recorded", 1.2345);
    primitives.primitives = true;
    run(primitives);
    RunOptions weaker = options("weaker", 1.2345);
    weaker.hand = (folder / "recorded/ticks.csv").string();
    weaker.scene_options.sets.emplace_back("mode.skin.level.skin.strength_n", "0.25");
    run(weaker);
  }
};

class Locale : public StudyTest {
 protected:
  using Bytes = std::map<std::string, std::string>;

  static void SetUpTestSuite() { traces = std::make_unique<Traces>(); }
  static void TearDownTestSuite() { traces.reset(); }
  static fs::path trace(const char* name) { return traces->folder / name; }

  /// Expects equal output of `make` in the classic locale and with commas, set in each way.
  void is_the_same(const std::function<Bytes(const fs::path& folder)>& make) const {
    fs::create_directories(folder / "classic");
    const Bytes classic = make(folder / "classic");
    EXPECT_FALSE(classic.empty());
    for (const auto& [of, way] : {std::pair{LocaleOf::set_locale, "set_locale"}, std::pair{LocaleOf::use_locale, "use_locale"},
                                  std::pair{LocaleOf::streams, "streams"}}) {
      SCOPED_TRACE(way);
      fs::create_directories(folder / way);
      Bytes commas;
      {
        const CommaLocale locale(of, folder / "locales");
        commas = make(folder / way);
      }
      are_the_same(classic, commas);
    }
  }
  static void are_the_same(const Bytes& classic, const Bytes& commas) {
    ASSERT_EQ(classic.size(), commas.size());
    for (const auto& [name, bytes] : classic) {
      ASSERT_TRUE(commas.contains(name)) << name;
      EXPECT_FALSE(bytes.empty()) << name;
      const std::string& other = commas.at(name);
      if (bytes == other) continue;
      const auto at =
          static_cast<std::size_t>(std::mismatch(bytes.begin(), bytes.end(), other.begin(), other.end()).first - bytes.begin());
      ADD_FAILURE() << name << " differs at byte " << at << ": " << bytes.substr(at - std::min<std::size_t>(at, 60), 90)
                    << "\n  with commas: " << other.substr(at - std::min<std::size_t>(at, 60), 90);
    }
  }
  /// All reproducible files of a folder.
  Bytes files_of(const fs::path& of) const {
    Bytes files;
    for (const auto& entry : fs::recursive_directory_iterator(of)) {
      if (entry.is_regular_file() && entry.path().filename() != "timing.csv")
        files[fs::relative(entry.path(), of).string()] = read(entry.path());
    }
    return files;
  }

 private:
  static inline std::unique_ptr<Traces> traces;
};

TEST_F(Locale, TextAndRounding) {
  is_the_same([](const fs::path&) { return Bytes{{"text", detail::text("%.3f %g %d", 1234.5, 0.25, 1234567)}}; });
}

TEST_F(Locale, RunsAndTheirTraces) {
  is_the_same([&](const fs::path& out) {
    for (const char* hand : {"sim:stroke", "sim:press,depth_m=0.0125"}) {
      RunOptions o = options("", 0.5);
      o.hand = hand;
      o.rate_hz = 1234.5;
      o.primitives = true;
      o.out = out / std::string(hand).substr(4, 5);
      o.scene_options.sets.emplace_back("coupling.stiffness_n_per_m", "612.5");
      run(o);
    }
    RunOptions recorded = options("", 0.5);
    recorded.hand = (trace("recorded") / "ticks.csv").string();
    recorded.out = out / "again";
    const RunResult felt = run(recorded);
    Bytes all = files_of(out);
    Summary summary = felt.summary;
    summary.wall_s = summary.ticks_per_s = summary.tick_p50_us = summary.tick_p99_us = summary.tick_max_us = 1234.5;
    all["table"] = to_table(summary);
    all["json"] = to_json(summary);
    for (auto& [name, bytes] : all) {  // the trace's own folder
      for (std::size_t at = bytes.find(out.string()); at != std::string::npos; at = bytes.find(out.string()))
        bytes.erase(at, out.string().size());
    }
    return all;
  });
}

TEST_F(Locale, Reports) {
  is_the_same([&](const fs::path& out) {
    Bytes all;
    all["beside.html"] = report_html(trace("recorded"), {.beside = trace("weaker")});
    write_report(trace("recorded"), out / "page.html", {.pictures = out / "pictures"});  // the page of report_html
    all.merge(files_of(out));
    return all;
  });
}

TEST_F(Locale, PicturesOfCloudsAndSlices) {
  const Scene scene = parse_scene(std::string(phantom_scene) + seen_scene, "scene.toml", folder, {}, standard_modes()).scene;
  const std::vector<PathPoint> path{{{0, 0, 0.06}, {0, 0, 0.06}, {}}, {{0.01, 0, 0.04}, {0.01, 0, 0.045}, {0, 0, 1.25}}};
  is_the_same([&](const fs::path&) {
    return Bytes{{"scene.png", png_of(scene_picture(scene, path, {}, {.width_px = 400, .height_px = 300}))}};
  });
}

TEST_F(Locale, PlotsOfAllKinds) {
  is_the_same([](const fs::path&) {
    Plot plot{.title = "Force",
              .x_label = "time / s",
              .y_label = "force / N",
              .marks = {{0.25, "onset"}, {1.5, "snap"}, {2.5, "fault"}, {3.5, "more"}}};
    for (const Stroke stroke : {Stroke::solid, Stroke::dashed, Stroke::dotted})
      plot.series.push_back({.name = "curve", .xs = {0.125, 1234.5, 2500.25}, .ys = {0.5, 12345.6, 7.25}, .stroke = stroke});
    plot.series.push_back({.name = "dots", .xs = {0.5, 1500.5}, .ys = {1.5, 2.25}, .points_only = true});
    Plot powers = plot;
    powers.x_log = powers.y_log = true;
    return Bytes{{"svg", svg_of(plot)}, {"powers", svg_of(powers)}, {"png", png_of(picture_of(plot, 500, 240))}};
  });
}

TEST_F(Locale, ExportsOfTraces) {
  is_the_same([&](const fs::path& out) {
    for (const char* name : {"felt.vtp", "felt.csv", "felt.mrk.json", "felt.h5"}) export_trace(trace("recorded"), out / name);
    return files_of(out);
  });
}

TEST_F(Locale, MapsKeptWrittenAndDrawn) {
  const LoadedScene loaded = load_scene(folder / "scene.toml", volume_reader(), standard_modes());
  is_the_same([&](const fs::path& out) {
    ForceMap map(map_slice(1, 0.0015, 0.1234, 12));
    feel_map(loaded.scene, map, {.threads = 1});
    const std::string identity = identity_of_map(loaded.scene, {}, map.lattice);
    keep_map(map, identity, out / "map.vti.part");
    ForceMap taken(map_slice(1, 0.0015, 0.1234, 12));
    EXPECT_EQ(take_kept_map(taken, identity, out / "map.vti.part"), KeptMap::taken);
    write_map(taken, loaded.scene.hand_to_world(), out / "map.vti", detail::Existing::refused);
    Bytes all = files_of(out);
    all["png"] = png_of(map_picture(loaded.scene, map));
    return all;
  });
}

TEST_F(Locale, ScenesWrittenAndRead) {
  is_the_same([&](const fs::path&) {
    const LoadedScene loaded = load_scene(folder / "scene.toml", volume_reader(), standard_modes());
    const std::string text = to_toml(loaded.scene);
    return Bytes{{"scene", text},
                 {"again", to_toml(parse_scene(text, "scene.toml", folder, volume_reader(), standard_modes()).scene)}};
  });
}

TEST_F(Locale, WordsOfChecksLawsAndDevices) {
  const LoadedScene loaded = load_scene(folder / "scene.toml", volume_reader(), standard_modes());
  is_the_same([&](const fs::path& out) {
    const CheckReport report = check_quickly(loaded.scene, device_presets().front());
    const std::vector<std::string> laws{"exact", "paper-2005"};
    keep_device_notes(out / "devices.toml", "touch", {.max_force_n = 1.25, .encoder_step_m = 1.5e-5});
    EXPECT_EQ(device_notes(out / "devices.toml", "touch").max_force_n, 1.25);
    Bytes all = files_of(out);
    all["laws"] = to_markdown(compare_laws(options("", 0.25), laws));
    all["check"] = to_table(report);
    all["check.json"] = to_json(report);
    all["device"] = format_plant(device_plant("touch,coulomb_friction_n=0.125"));
    all["notes"] = [&] {
      std::string words;
      RunOptions unreal = options("", 0.25);
      unreal.rate_hz = 0.25;
      try {
        run(unreal);
      } catch (const std::exception& error) {
        words = error.what();
      }
      return words;
    }();
    return all;
  });
}

#ifdef PALPA_READERS
TEST_F(Locale, VolumesWrittenAndRead) {
  ReadOptions with;
  with.reader = fs::path(PALPA_READERS) / "palpa-read";
  const Volume ball = sampled(sphere_field(), 24);
  is_the_same([&](const fs::path& out) {
    Bytes all;
    for (const char* name : {"a.nrrd", "a.vti", "a.nhdr"}) {
      convert(ball, out / name, {.resample_m = 0.0123});
      VolumeRequest request;
      request.files = {out / name};
      const Volume back = read_volume(request, with);
      const Statistics values = statistics(*back.fields.front().field);
      all[std::string(name) + ".statistics"] = detail::text("%.17g %.17g", values.min, values.max);
      all[std::string(name) + ".png"] = png_of(volume_picture(back, 0, values, name));
      std::string scene = first_scene(back, request);
      for (std::size_t at = scene.find(out.string()); at != std::string::npos; at = scene.find(out.string()))
        scene.erase(at, out.string().size());
      all[std::string(name) + ".toml"] = scene;
    }
    all.merge(files_of(out));
    return all;
  });
}
#endif

}  // namespace locale_test
}  // namespace palpa
