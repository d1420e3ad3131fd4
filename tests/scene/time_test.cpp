// Time in scenes: series of files, moving volumes, clocks.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "palpa/data/grid.h"
#include "palpa/data/read_series.h"
#include "palpa/data/volume.h"
#include "tests/scene/scene_files.h"

namespace palpa {
namespace time_test {

namespace fs = std::filesystem;
using test::error_of;
using test::parse;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

const std::string mode = "\n[[mode]]\nname = \"m\"\ntype = \"viscosity\"\nfield = \"v\"\nstrength_n = 1\n";
std::string scene_with(const std::string& volume, const std::string& more = "") {
  return "palpa = 1\n" + more + "[volume.v]\n" + volume + mode;
}

/// A grid with the number in its file's name as its value; names with "far" have another position.
Volume read_numbered(const VolumeRequest& request) {
  const std::string name = request.files.front().filename().string();
  const auto at = name.find_first_of("0123456789");
  const float value = name.starts_with("4d") ? static_cast<float>(request.frame) : std::stof(name.substr(at));
  auto voxels = std::make_shared<std::vector<float>>(27, value);
  GridGeometry geometry{{3, 3, 3}, {{{0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}}}, {}};
  if (name.find("far") != std::string::npos) geometry.origin_m = {1, 0, 0};
  Volume volume;
  volume.format = "nrrd";
  const FieldPtr field = grid_field(geometry, {VoxelType::float32, 1, {voxels, voxels->data()}});
  volume.fields = {{name.find("other") != std::string::npos ? "other" : "value", "", field}};
  if (name.find("two") != std::string::npos) volume.fields.push_back({"second", "", field});
  volume.files = {{request.files.front().string(), 1, "0"}};
  if (name.starts_with("4d")) volume.frames = 4;
  volume.warnings = {"has no unit"};
  return volume;
}

class SeriesFiles : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  void touch(const std::string& name) const { std::ofstream(folder_ / name) << "x"; }
  LoadedScene load(const std::string& text) const {
    return parse_scene(text, "s.toml", folder_, read_numbered, standard_modes());
  }
  std::string error(const std::string& text) const {
    try {
      load(text);
    } catch (const LoadError& error) {
      return error.what();
    }
    return "no error";
  }
  const fs::path folder_ = fs::temp_directory_path() / ("palpa-series-" + std::to_string(::getpid()));
};

TEST_F(SeriesFiles, AreThoseThatMatchInTheOrderOfTheirNumbers) {
  for (const char* name : {"phase_10.vti", "phase_2.vti", "phase_1.vti", "phase_002b.vti", "phase_3.txt", "other_1.vti"})
    touch(name);
  const auto names = [&](const char* pattern) {
    std::vector<std::string> found;
    for (const fs::path& file : files_matching(folder_ / pattern)) found.push_back(file.filename().string());
    return found;
  };
  EXPECT_THAT(names("phase_*.vti"), ElementsAre("phase_1.vti", "phase_2.vti", "phase_002b.vti", "phase_10.vti"));
  EXPECT_THAT(names("phase_?.vti"), ElementsAre("phase_1.vti", "phase_2.vti"));
  EXPECT_THAT(names("*_1*"), ElementsAre("other_1.vti", "phase_1.vti", "phase_10.vti"));
  EXPECT_THAT(names("phase_1.vti"), ElementsAre("phase_1.vti"));
  EXPECT_THAT(names("*.nrrd"), IsEmpty());
  EXPECT_THAT(files_matching("/no/such/folder/*"), IsEmpty());
}

TEST_F(SeriesFiles, AreFramesOfOneVolume) {
  for (const char* name : {"p_10.vti", "p_2.vti", "p_1.vti"}) touch(name);
  const LoadedScene loaded = load(scene_with("files = \"p_*.vti\"\nframe_period_s = 0.04\n"));
  const Volume& volume = loaded.scene.volumes().front().volume;
  EXPECT_EQ(volume.frames, 3);
  EXPECT_EQ(volume.files.size(), 3u);
  EXPECT_EQ(volume.warnings.size(), 1u) << "that of each file is one";
  const TimedField& field = *timed(*volume.fields.front().field);
  const Vec3 x{0.1, 0.1, 0.1};
  EXPECT_EQ(field.scalar_at(x, 0.0).value, 1.0);
  EXPECT_EQ(field.scalar_at(x, 0.04).value, 2.0);
  EXPECT_NEAR(field.scalar_at(x, 0.06).value, 6.0, 1e-12);
  EXPECT_EQ(field.scalar_at(x, 0.08).value, 10.0);
  EXPECT_NEAR(field.scalar_at(x, {0.10, true}).value, 5.5, 1e-12);
  const LoadedScene nearest = load(scene_with("files = \"p_*.vti\"\nframe_period_s = 0.04\nbetween_frames = \"nearest\"\n"));
  EXPECT_EQ(timed(*nearest.scene.volumes().front().volume.fields.front().field)->scalar_at(x, 0.055).value, 2.0);
  EXPECT_THAT(to_toml(loaded.scene), HasSubstr("files = \"p_*.vti\"\nframe_period_s = 0.04\n"));
  EXPECT_TRUE(load(to_toml(loaded.scene)).scene == loaded.scene);
}

TEST_F(SeriesFiles, OrTheFramesOfOneFile) {
  touch("4d.nii");
  touch("1.nii");
  const LoadedScene loaded = load(scene_with("file = \"4d.nii\"\nframe_period_s = 0.5\n"));
  const Volume& volume = loaded.scene.volumes().front().volume;
  EXPECT_EQ(volume.frames, 4);
  EXPECT_EQ(volume.files.size(), 1u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(timed(*volume.fields.front().field)->scalar_at({0.1, 0.1, 0.1}, 0.5 * i).value, i);
  }
  EXPECT_EQ(timed(*load(scene_with("file = \"4d.nii\"\nframe = 2\n")).scene.volumes().front().volume.fields.front().field),
            nullptr);
  EXPECT_THAT(error(scene_with("file = \"1.nii\"\nframe_period_s = 0.5\n")), HasSubstr("holds one frame"));
  EXPECT_THAT(error(scene_with("file = \"4d.nii\"\nframe = 1\nframe_period_s = 0.5\n")), StartsWith("s.toml:4:9: 'frame'"));
}

TEST_F(SeriesFiles, SayWhatIsWrongWithThem) {
  for (const char* name : {"a1.vti", "a2far.vti", "b1.vti", "b2other.vti", "c1.vti", "c2two.vti", "d1.vti", "e1.vti", "e2.vti"})
    touch(name);
  const std::string period = "frame_period_s = 0.04\n";
  EXPECT_THAT(error(scene_with("files = \"a*.vti\"\n" + period)), HasSubstr("a2far.vti lies on another grid than the first"));
  EXPECT_THAT(error(scene_with("files = \"b*.vti\"\n" + period)),
              HasSubstr("b2other.vti has a field 'other' where the first has"));
  EXPECT_THAT(error(scene_with("files = \"c*.vti\"\n" + period)), HasSubstr("c2two.vti has 2 fields and the first 1"));
  EXPECT_THAT(error(scene_with("files = \"d*.vti\"\n" + period)), HasSubstr("s.toml:3:9: only '"));
  EXPECT_THAT(error(scene_with("files = \"x*.vti\"\n" + period)), StartsWith("s.toml:3:9: no files match 'x*.vti'"));
  EXPECT_THAT(error(scene_with("files = \"e*.vti\"\n")), StartsWith("s.toml:3:9: 'files' in volume 'v' is a time series"));
  EXPECT_THAT(error(scene_with("files = \"\"\n" + period)), HasSubstr("is no pattern of paths"));
  EXPECT_THAT(error(scene_with("files = \"e*.vti\"\nfile = \"e1.vti\"\n" + period)), HasSubstr("has two sources"));
  EXPECT_THAT(error(scene_with("files = \"e*.vti\"\nframe = 1\n" + period)), StartsWith("s.toml:4:9: 'frame'"));
  EXPECT_THAT(error(scene_with("files = \"e*.vti\"\nframe_period_s = 0\n")), HasSubstr("it must be above 0"));
  EXPECT_THAT(error(scene_with("file = \"e1.vti\"\nbetween_frames = \"linear\"\n")),
              StartsWith("s.toml:4:18: 'between_frames'"));
  EXPECT_EQ(error(scene_with("files = \"e*.vti\"\n" + period)), "no error");
}

TEST(TimeInScenes, EmbeddedDataBeatAsAFormulaAndAsFrames) {
  const std::string beating = "palpa = 1\n[volume.v]\nanalytic = \"beating_chamber\"\n";
  const std::string felt = "[[mode]]\nname = \"m\"\ntype = \"viscosity\"\nfield = \"v.signal\"\nstrength_n = 1\n";
  const Scene formula = parse(beating + felt).scene;
  ASSERT_NE(timed(*formula.field({"v.signal"}).field), nullptr);
  EXPECT_EQ(series_of(*formula.field({"v.signal"}).field), nullptr);
  const auto frames = [&](const std::string& keys) {
    return *series_of(*parse(beating + keys + felt).scene.field({"v.velocity"}).field);
  };
  EXPECT_EQ(frames("sampled = 17\n").frames.size(), 20u);
  EXPECT_DOUBLE_EQ(frames("sampled = 17\n").period_s, 0.04);
  EXPECT_EQ(frames("sampled = 17\nframes = 4\n").frames.size(), 4u);
  EXPECT_DOUBLE_EQ(frames("sampled = 17\nframes = 4\n").period_s, 0.2);
  EXPECT_DOUBLE_EQ(frames("sampled = 17\nframes = 4\nframe_period_s = 0.3\n").period_s, 0.3);
  EXPECT_EQ(frames("sampled = 17\nframes = 4\nbetween_frames = \"nearest\"\n").between_frames, BetweenFrames::nearest);
  EXPECT_THAT(error_of(beating + "frames = 4\n" + felt), StartsWith("s.toml:4:10: 'frames'"));
  EXPECT_THAT(error_of(beating + "frame_period_s = 4\n" + felt), StartsWith("s.toml:4:18: 'frame_period_s'"));
  EXPECT_THAT(error_of(scene_with("analytic = \"sphere\"\nsampled = 9\nframes = 4\n")), StartsWith("s.toml:5:10: 'frames'"));
}

TEST(TimeInScenes, VolumesMoveFromPoseToPose) {
  const std::string moving =
      "analytic = \"sphere\"\nposes = [{time_s = 0}, {time_s = 2, translate_m = [0.1, 0, 0], rotate_axis_deg = [0, 0, 1, 90], "
      "scale = 2}]\n";
  const LoadedScene loaded = parse(scene_with(moving, "[time]\nplay = \"once\"\nspeed = 0.5\n"));
  EXPECT_THAT(loaded.warnings, IsEmpty());
  const SceneVolume& volume = loaded.scene.volumes().front();
  ASSERT_EQ(volume.poses.size(), 2u);
  EXPECT_EQ(volume.poses[1].pose.translation_m, (Vec3{0.1, 0, 0}));
  const TimedField& field = *timed(*volume.volume.fields.front().field);
  EXPECT_NEAR(field.scalar_at({0.1, 0, 0}, loaded.scene.time().at(4.0)).value, 0.05, 1e-12);
  EXPECT_NEAR(field.scalar_at({0.05, 0, 0}, loaded.scene.time().at(2.0)).value, 0.05, 1e-12);
  EXPECT_TRUE(parse(to_toml(loaded.scene)).scene == loaded.scene);

  const auto wrong = [](const std::string& poses) {
    return error_of(scene_with("analytic = \"sphere\"\nposes = " + poses + "\n"));
  };
  EXPECT_THAT(wrong("[{time_s = 0}, {time_s = 2}, {time_s = 1}]"), StartsWith("s.toml:4:38: 'poses' of volume 'v': the times"));
  EXPECT_THAT(wrong("[{time_s = 1}, {time_s = 2}]"), StartsWith("s.toml:4:10: 'poses' of volume 'v': the first pose"));
  EXPECT_THAT(wrong("[{time_s = 0}]"), HasSubstr("'poses' of volume 'v' has one"));
  EXPECT_THAT(wrong("[{}, {time_s = 2}]"), HasSubstr("no key 'time_s' in 'poses' of volume 'v'"));
  EXPECT_THAT(wrong("[{time_s = 0}, {time_s = 2, rotate_axis_deg = [1, 0, 0, 180]}]"), HasSubstr("goes either way round"));
  EXPECT_THAT(wrong("[{time_s = 0}, {time_s = 2, turn = 1}]"), HasSubstr("unknown key 'turn'"));
  EXPECT_THAT(wrong("[{time_s = 0}, {time_s = 2}]\npose = {scale = 2}"), HasSubstr("both 'pose' and 'poses'"));
}

TEST(TimeInScenes, VolumesFromCodeMoveToo) {
  Scene scene;
  const FieldRef ball =
      scene.add_moving("ball", sphere_field(), PoseTrack{{0.0, {}}, {1.0, {Mat3::identity(), 1.0, {0.1, 0, 0}}}});
  scene.set(TimeOptions{TimeOptions::Play::loop});
  ASSERT_NE(timed(*scene.field(ball).field), nullptr);
  EXPECT_THAT(scene.check(), ElementsAre(HasSubstr("jumps where its loop begins again")));
  EXPECT_THAT(to_toml(scene), HasSubstr("[time]\nplay = \"loop\"\nspeed = 1\nstart_s = 0\n"));
  EXPECT_THROW(scene.add_moving("none", sphere_field(), PoseTrack{}), SceneError);
  EXPECT_THROW(scene.set(TimeOptions{.speed = -1.0}), SceneError);
}

TEST(TimeInScenes, GoesOnOnlyWhereItIsPlayed) {
  TimeOptions time;
  EXPECT_EQ(time.at(17.0), DataTime(0.0));
  time.start_s = 0.3;
  EXPECT_EQ(time.at(17.0), DataTime(0.3));
  time.play = TimeOptions::Play::once;
  time.speed = 2.0;
  EXPECT_EQ(time.at(1.0), DataTime(2.3, false));
  time.play = TimeOptions::Play::loop;
  EXPECT_EQ(time.at(1.0), DataTime(2.3, true));
}

TEST(TimeInScenes, SaysWhatIsWrongWithIt) {
  const std::string ball = "analytic = \"sphere\"\n";
  EXPECT_THAT(error_of(scene_with(ball, "[time]\nplay = \"lopo\"\n")),
              StartsWith("s.toml:3:8: 'play' in [time] cannot be 'lopo'; did you mean 'loop'"));
  EXPECT_THAT(error_of(scene_with(ball, "[time]\nspeed = 0\n")), HasSubstr("'speed' in [time] is 0; it must be above 0"));
  EXPECT_THAT(error_of(scene_with(ball, "[time]\nstart_s = -1\n")), HasSubstr("'start_s' in [time] is -1"));
  EXPECT_THAT(error_of(scene_with(ball, "[time]\nspeeed = 1\n")),
              HasSubstr("unknown key 'speeed' in [time]; did you mean 'speed'?"));
  EXPECT_THAT(parse(scene_with(ball, "[time]\nplay = \"loop\"\n")).warnings,
              ElementsAre(HasSubstr("s.toml:2:1: nothing in the scene changes with time")));
}

TEST(TimeInScenes, CanBeSetFromOutside) {
  const std::string moving = "analytic = \"sphere\"\nposes = [{time_s = 0}, {time_s = 2, scale = 2}]\n";
  const Scene scene = parse(scene_with(moving, "[time]\nplay = \"loop\"\n"),
                            {.data_folders = {}, .sets = {{"time.play", "hold"}, {"time.start_s", "1.5"}}})
                          .scene;
  EXPECT_EQ(scene.time(), (TimeOptions{TimeOptions::Play::hold, 1.0, 1.5}));
  EXPECT_EQ(parse(scene_with(moving), {.data_folders = {}, .sets = {{"time.speed", "3"}}}).scene.time().speed, 3.0);
}

}  // namespace time_test
}  // namespace palpa
