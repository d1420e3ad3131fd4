// Tiles of finer octaves in slices of volumes larger than memory.
#include "explorer/slice_tiles.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>
#include <set>
#include <thread>

#include "driver.h"
#include "explorer/scene_views.h"
#include "explorer/slice_view.h"
#include "palpa/data/octave_parts.h"
#include "palpa/file/read_volume.h"
#include "tests/data/pyramid.h"

namespace palpa::explorer {
namespace slice_tiles_test {

/// Noise, so that each voxel counts.
FieldPtr noise(std::array<std::int64_t, 3> dims, int components = 1, Filter filter = Filter::smooth) {
  const GridGeometry grid{dims, {{{2e-3, 0, 0}, {0, 3e-3, 0}, {0, 0, 2e-3}}}, {0.1, -0.2, 0.3}, {}};
  const std::int64_t count = grid.voxels() * components;
  const std::shared_ptr<float[]> values(new float[static_cast<std::size_t>(count)]);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> value(0.0F, 100.0F);
  for (std::int64_t n = 0; n < count; ++n) values[static_cast<std::size_t>(n)] = value(random);
  return filtered(grid_field(grid, {VoxelType::float32, components, values}), filter);
}

/// Reads all that is missing for an area.
TilesOfArea read_all(SliceTiles& tiles, const SliceArea& area, int known) {
  const int priority = ::getpriority(PRIO_PROCESS, 0);
  TilesOfArea of = tiles.tiles_of(area, known);
  while (!of.missing.empty()) {
    tiles.keep(tiles.read(of.missing, {}));
    of = tiles.tiles_of(area, known);
  }
  EXPECT_EQ(::getpriority(PRIO_PROCESS, 0), priority) << "of the calling thread";
  return of;
}

/// A position of an area. \param u, v  [1] −1…1
Vec3 at(const SliceArea& area, double u, double v) { return area.centre_m + u * area.half_right_m + v * area.half_up_m; }

TEST(SliceTiles, HaveTheSamplesOfTheirOctaveToTheBitWithoutSeams) {
  for (const int components : {1, 3}) {
    const FieldPtr whole = noise({150, 90, 130}, components, components == 1 ? Filter::smooth : Filter::trilinear);
    const auto octaves = test::in_octaves(*whole, 4);
    SliceTiles tiles(octaves);
    const Vec3 size = octaves->bounds_m().size_m(), centre = octaves->bounds_m().centre_m();
    std::mt19937 random(3);
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    for (int n = 0; n < 12; ++n) {
      const int axis = n % 3, octave = n / 3 % 3;
      const Vec3 axes[] = {{0.5 * size.x, 0, 0}, {0, 0.5 * size.y, 0}, {0, 0, 0.5 * size.z}};
      SliceArea area{centre + 0.9 * share(random) * axes[axis], axes[(axis + 1) % 3], axes[(axis + 2) % 3],
                     1.01 * std::ldexp(octaves->spacing_m(), octave)};
      if (n >= 9) area.half_right_m += 0.4 * axes[axis], area.half_up_m += -0.2 * axes[axis];  // oblique
      const TilesOfArea of = read_all(tiles, area, 3);
      EXPECT_EQ(of.wanted, octave);
      EXPECT_EQ(std::pair(of.finest, of.coarsest), std::pair(octave, octave));
      const OctaveWindow all = octaves->window(octave, {}, octaves->sampled_grid(octave).dims);
      int within = 0;
      for (int sample = 0; sample < 4000; ++sample) {
        const Vec3 at_m = at(area, share(random), share(random));
        const auto expected = value_at(*all.grid, at_m);
        ASSERT_EQ(tiles.value_at(at_m, of.across, of.wanted), expected) << n;
        within += expected.has_value() ? 1 : 0;
      }
      EXPECT_GT(within, 2500);
      // On the borders of blocks and beside them, by less than the rounding of positions.
      const GridGeometry& grid = octaves->sampled_grid(octave);
      for (int sample = 0; sample < 200; ++sample) {
        Vec3 steps = octaves->steps_of(octave, at(area, share(random), share(random)));
        double* const along[] = {&steps.x, &steps.y, &steps.z};
        for (const int a : {(of.across + 1) % 3, (of.across + 2) % 3})
          *along[a] = std::round(*along[a] / 64.0) * 64.0 + 1e-13 * static_cast<double>(sample - 100);
        if (n >= 9) continue;  // off the plane
        const Vec3 at_m = grid.to_world({steps.x, steps.y, steps.z});
        ASSERT_EQ(tiles.value_at(at_m, of.across, of.wanted), value_at(*all.grid, at_m)) << n;
      }
    }
  }
}

TEST(SliceTiles, AreOfTheOctaveWithAVoxelASampleCoarseFirst) {
  const auto octaves = test::in_octaves(*noise({300, 200, 60}), 4);
  SliceTiles tiles(octaves);
  const Vec3 size = octaves->bounds_m().size_m();
  SliceArea area{octaves->bounds_m().centre_m(), {0.5 * size.x, 0, 0}, {0, 0.5 * size.y, 0}, 0.0};
  for (const auto& [step_m, wanted] : {std::pair(1e-9, 0), {3.9e-3, 0}, {4.1e-3, 1}, {7.9e-3, 1}, {8.1e-3, 2}, {1.0, 3}}) {
    area.step_m = step_m;
    EXPECT_EQ(tiles.tiles_of(area, 3).wanted, wanted) << step_m;
  }
  area.step_m = 2e-3;
  const TilesOfArea of = tiles.tiles_of(area, 3);
  EXPECT_EQ(std::pair(of.finest, of.coarsest), std::pair(3, 3)) << "nothing was read";
  EXPECT_TRUE(std::ranges::is_sorted(of.missing, std::greater(), &TilePlace::octave));
  EXPECT_EQ(of.missing.front().octave, 2);
  EXPECT_EQ(std::ranges::count(of.missing, 0, &TilePlace::octave), 5 * 4);  // 300 × 200 voxels in blocks of 64 × 64
  EXPECT_TRUE(std::ranges::all_of(of.missing, [](const TilePlace& place) { return place.across == 2; }));
  // Coarser tiles are for no one once finer ones are there.
  std::vector<TilePlace> finest;
  std::ranges::copy_if(of.missing, std::back_inserter(finest), [](const TilePlace& place) { return place.octave == 0; });
  for (std::size_t next = 0; next < finest.size();) {
    auto read = tiles.read({finest.begin() + static_cast<std::ptrdiff_t>(next), finest.end()}, {});
    ASSERT_FALSE(read.empty());
    next += read.size();
    tiles.keep(std::move(read));
  }
  EXPECT_TRUE(tiles.tiles_of(area, 3).missing.empty());
  area.centre_m = area.centre_m + 2.0 * size;
  EXPECT_TRUE(tiles.tiles_of(area, 3).missing.empty()) << "beside the data";
}

/// Source of a formula, of any size.
class Ramp final : public VoxelSource {
 public:
  bool read(int, const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& dims, std::byte* to) override {
    auto* value = reinterpret_cast<float*>(to);
    for (std::int64_t n = 0; n < dims[0] * dims[1] * dims[2]; ++n) {
      for (int c = 0; c < 3; ++c) *value++ = static_cast<float>(first[0] + n % dims[0]);
    }
    return true;
  }
  std::shared_ptr<VoxelSource> beside() const override { return std::make_shared<Ramp>(*this); }
};

TEST(SliceTiles, TakeBoundedMemory) {
  const Octaves::Shape shape{.finest = {{4096, 4096, 4096}, 1e-3 * Mat3::identity(), {}, {}},
                             .count = 7,
                             .components = 3,
                             .ranges = std::vector<ValueRange>(3, {0.0, 4096.0}),
                             .source = std::make_shared<Ramp>()};
  SliceTiles tiles(std::make_shared<const Octaves>(shape));
  // All of octave 0 would be 4096 tiles of 1.3 MB; an octave is taken that fits.
  SliceArea area{{2, 2, 2}, {2, 0, 0}, {0, 2, 0}, 1e-3};
  EXPECT_GE(tiles.tiles_of(area, 6).wanted, 2);
  area.half_right_m = {0.1, 0, 0}, area.half_up_m = {0, 0.1, 0};
  const TilesOfArea first = read_all(tiles, area, 1);
  EXPECT_EQ(first.wanted, 0);
  const SliceArea there = area;
  for (int n = 1; n < 20; ++n) {
    area.centre_m.z = 2.0 + 0.05 * n;
    read_all(tiles, area, 1);
    EXPECT_LT(tiles.bytes(), 257'000'000);
  }
  EXPECT_TRUE(tiles.tiles_of(area, 1).missing.empty()) << "the last are kept";
  EXPECT_FALSE(tiles.tiles_of(there, 1).missing.empty()) << "the first are dropped";
}

/// Source that has lost a part of octave 0, is slow, or cannot be opened for pictures.
class Troubled final : public VoxelSource {
 public:
  Troubled(std::shared_ptr<VoxelSource> of, std::int64_t lost_from, int delay_ms)
      : of_(std::move(of)), lost_from_(lost_from), delay_ms_(delay_ms) {}
  bool read(int octave, const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& dims,
            std::byte* to) override {
    if (is_beside_) std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms_)), ++reads;
    return !(octave == 0 && first[0] + dims[0] > lost_from_) && of_->read(octave, first, dims, to);
  }
  std::shared_ptr<VoxelSource> beside() const override {
    if (delay_ms_ < 0) throw LoadError("big.zarr: is gone; mount it again");
    auto other = std::make_shared<Troubled>(of_, lost_from_, delay_ms_);
    other->is_beside_ = true;
    return other;
  }
  static inline std::atomic<int> reads{0};  ///< for pictures, of all

 private:
  std::shared_ptr<VoxelSource> of_;
  std::int64_t lost_from_;
  int delay_ms_;
  bool is_beside_ = false;
};

constexpr std::int64_t nothing_lost = 1'000'000;

std::shared_ptr<const Octaves> troubled(const Field& whole, int count, std::int64_t lost_from, int delay_ms) {
  Octaves::Shape shape = test::in_octaves(whole, count)->shape();
  shape.source = std::make_shared<Troubled>(shape.source, lost_from, delay_ms);
  return std::make_shared<const Octaves>(std::move(shape));
}

TEST(SliceTiles, AreReplacedByCoarserOnesWhereVoxelsAreLost) {
  const auto octaves = troubled(*noise({200, 100, 40}), 3, 100, 0);
  SliceTiles tiles(octaves);
  const Vec3 size = octaves->bounds_m().size_m();
  const SliceArea area{octaves->bounds_m().centre_m(), {0.5 * size.x, 0, 0}, {0, 0.5 * size.y, 0}, 2e-3};
  const TilesOfArea of = read_all(tiles, area, 2);
  EXPECT_EQ(std::pair(of.finest, of.coarsest), std::pair(0, 1));
  const OctaveWindow coarse = octaves->window(1, {}, octaves->sampled_grid(1).dims);
  const Vec3 lost_m = at(area, 0.8, 0.1);
  EXPECT_EQ(tiles.value_at(lost_m, of.across, 0), value_at(*coarse.grid, lost_m));
}

/// Slices of a volume in octaves.
Scene scene_of(const std::shared_ptr<const Octaves>& octaves) {
  Volume volume;
  volume.fields.push_back({"value", "", octaves});
  Scene scene;
  const FieldRef field = scene.add("scan", volume);
  scene.layers.push_back({.show = ViewLayer::Show::slices, .field = field});
  return scene;
}

/// Turns the wheel with Ctrl in the middle of a slice.
void zoom(SliceView& slice, int notches) {
  const QPoint at = slice.rect().center();
  for (int n = 0; n < notches; ++n) {
    QWheelEvent event(at, slice.mapToGlobal(at), {}, QPoint(0, 120), {}, Qt::ControlModifier, Qt::NoScrollPhase, false);
    QApplication::sendEvent(&slice, &event);
  }
}

/// Texts of a slice's last picture.
std::string words_of(const SliceView& slice) {
  QStringList words;
  for (const PlacedText& text : slice.texts()) words << text.words;
  return words.join(" | ").toStdString();
}

bool names(const SliceView& slice, const std::string& octave) { return words_of(slice).find(octave) != std::string::npos; }

SliceView& slice_across_z(const QWidget& in) {
  const QList<SliceView*> all = in.findChildren<SliceView*>();
  return **std::ranges::find_if(all, [](const SliceView* slice) { return slice->title() == "Across z"; });
}

struct Slices {
  QApplication& qt = application();
  Jobs jobs;
  SceneViews views{jobs, false};
  Slices() {
    views.resize(900, 320);
    views.show();
    (void)QTest::qWaitForWindowExposed(&views);
  }
  SliceView& slice() { return slice_across_z(views); }
  bool is_done() {
    return Driver::wait_for([&] { return slice().is_fine() && !views.is_drawing() && jobs.words().isEmpty(); }, 60'000);
  }
};

TEST(SlicesOfOctaves, AreRefinedToAVoxelAPixelWhereTheUserZooms) {
  const auto octaves = test::in_octaves(*noise({700, 600, 40}), 4);
  Slices all;
  all.views.start(scene_of(octaves));

  ASSERT_TRUE(all.is_done());
  all.views.grab();
  EXPECT_TRUE(names(all.slice(), ", octave 1")) << words_of(all.slice());
  zoom(all.slice(), 12);
  ASSERT_TRUE(all.is_done());
  const QImage picture = all.slice().grab().toImage();
  EXPECT_TRUE(names(all.slice(), ", octave 0")) << words_of(all.slice());
  // Pixels are samples of the octave as a whole: grey values beside crosshair and texts.
  const OctaveWindow whole = octaves->window(0, {}, octaves->dims(0));
  const detail::View& view = all.slice().view();
  const SliceLook& look = all.views.look();
  int compared = 0;
  for (int x = 60; x < view.width_px - 60; x += 3) {
    for (int y = 80; y < view.height_px - 60; y += 3) {
      if (std::abs(x - view.width_px / 2) < 12 || std::abs(y - view.height_px / 2) < 12) continue;
      const double per_px = 1.0 / view.px_per_m();
      const Vec3 at_m = view.centre_m + (x + 0.5 - 0.5 * view.width_px) * per_px * view.right +
                        (0.5 * view.height_px - y - 0.5) * per_px * view.up;
      const double value = *value_at(*whole.grid, look.map.to_world(at_m));
      const double share = std::clamp((value - look.low) / (look.high - look.low), 0.0, 1.0);
      const QColor color = to_qt(look.colors.at(std::floor(255.0 * share) / 255.0).color);
      ASSERT_NEAR(qGray(picture.pixel(x, y)), qGray(color.rgb()), 1) << x << " " << y;
      ++compared;
    }
  }
  EXPECT_GT(compared, 1000);
}

// Of a series the tiles of the frame that is shown; they stay with it.
TEST(SlicesOfOctaves, AreOfTheFrameOfASeriesThatIsShown) {
  std::vector<FieldPtr> frames;
  for (int n = 0; n < 3; ++n) frames.push_back(test::in_octaves(*noise({80, 60, 40}), 2));
  Volume volume;
  volume.fields.push_back({"value", "", time_series(frames, 0.5)});
  Scene scene;
  const FieldRef field = scene.add("scan", volume);
  scene.layers.push_back({.show = ViewLayer::Show::slices, .field = field});
  for (const std::size_t frame : {2, 0, 1}) {
    scene.set(TimeOptions{.start_s = 0.5 * static_cast<double>(frame)});
    SliceLook look = slice_look_of(scene);
    take_tiles(scene, nullptr, look);
    ASSERT_TRUE(look.tiles);
    EXPECT_EQ(&look.tiles->octaves(), frames[frame].get());
    SliceLook again = slice_look_of(scene);
    take_tiles(scene, look.tiles, again);
    EXPECT_EQ(again.tiles, look.tiles);
  }
}

TEST(SlicesOfOctaves, DoNotWaitForASlowSourceAndEndWithTheWindow) {
  const FieldPtr whole = noise({400, 400, 300});
  int reads = 0;
  {
    Slices all;
    all.views.start(scene_of(troubled(*whole, 3, nothing_lost, 60)));
    Troubled::reads = 0;
    ASSERT_TRUE(Driver::wait_for([&] { return Troubled::reads > 0; }));
    const auto begin = std::chrono::steady_clock::now();
    zoom(all.slice(), 3);
    all.views.grab();
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(2));
    ASSERT_TRUE(Driver::wait_for([&] { return Troubled::reads > 4; })) << "tiles come one by one";
    all.views.start(scene_of(test::in_octaves(*whole, 3)));  // another scene
    reads = Troubled::reads;
    ASSERT_TRUE(all.is_done());
    EXPECT_LE(Troubled::reads, reads + 1) << "those of the scene before are not read";
    all.views.start(scene_of(troubled(*whole, 3, nothing_lost, 60)));
    reads = Troubled::reads;
    ASSERT_TRUE(Driver::wait_for([&] { return Troubled::reads > reads; }));
    reads = Troubled::reads;
  }
  EXPECT_LE(Troubled::reads, reads + 1);
}

/// A store of 512 × 512 × 32 voxels, made by the programs.
std::filesystem::path make_store(const std::filesystem::path& folder) {
  constexpr int side = 512, depth = 32;
  std::vector<unsigned char> voxels;
  for (int n = 0; n < side * side * depth; ++n)
    voxels.push_back(static_cast<unsigned char>(128 + 100 * std::sin(0.4 * (n % side)) * std::sin(0.02 * (n / side % side))));
  std::ofstream(folder / "fine.raw", std::ios::binary).write(reinterpret_cast<const char*>(voxels.data()), side * side * depth);
  const std::string command = std::string(std::getenv("PALPA_BIN")) + "/palpa convert " + (folder / "fine.raw").string() + " " +
                              (folder / "fine.zarr").string() +
                              " --set type=uint8 --set 'dims=[512,512,32]' --set 'spacing_m=[1e-6,1e-6,1e-6]' > /dev/null";
  EXPECT_EQ(std::system(command.c_str()), 0);
  return folder / "fine.zarr";
}

TEST(SlicesOfOctaves, AreReadBesideTheSourceOfTheHand) {
  VolumeRequest request;
  request.files = {make_store(fresh_folder("beside"))};
  request.memory_mb = 1.0;
  const Volume volume = read_volume(request);
  const auto source = octaves_of(*volume.fields.front().field)->shape().source;
  const std::size_t known = source->sums_from(0).size();
  const auto beside = source->beside();
  std::vector<std::byte> of_hand(64 * 64 * 8), of_picture(64 * 64 * 8);
  ASSERT_TRUE(beside->read(0, {100, 33, 7}, {64, 64, 8}, of_picture.data()));
  EXPECT_EQ(source->sums_from(0).size(), known) << "a trace has the chunks of the hand alone";
  ASSERT_TRUE(source->read(0, {100, 33, 7}, {64, 64, 8}, of_hand.data()));
  EXPECT_EQ(of_hand, of_picture);
  EXPECT_GT(source->sums_from(0).size(), known);
}

TEST(SlicesOfOctaves, AreReadFromAStoreWhileAHandFeelsIt) {
  const std::filesystem::path folder = fresh_folder("tiles");
  make_store(folder);
  std::ofstream(folder / "fine.toml") << R"(palpa = 1
[volume.fine]
file = "fine.zarr"
memory_mb = 1
[workspace]
fit = "fine"
[[mode]]
name = "wall"
type = "surface_and_friction"
field = "fine"
[[mode.level]]
value = 128
strength_n = 1.0
[[view.layer]]
show = "slices"
field = "fine"
)";
  Driver driver;
  ASSERT_TRUE(driver.open(folder / "fine.toml"));
  SliceView& slice = slice_across_z(driver.window());
  const auto is_done = [&] { return Driver::wait_for([&] { return slice.is_fine() && !driver.window().is_busy(); }, 120'000); };
  ASSERT_TRUE(is_done());
  slice.grab();
  EXPECT_TRUE(names(slice, ", octave 1")) << words_of(slice);
  driver.look("tiles-whole");
  zoom(slice, 9);
  ASSERT_TRUE(is_done());
  driver.look("tiles-zoomed");
  EXPECT_TRUE(names(slice, ", octave 0")) << words_of(slice);
  EXPECT_TRUE(driver.run_ticks(100)) << "the hand goes on";
}

TEST(SlicesOfOctaves, StayCoarseWhereTheStoreIsGone) {
  Slices all;
  QStringList said;
  QObject::connect(&all.views, &SceneViews::said, [&](const QString& words, bool) { said << words; });
  all.views.start(scene_of(troubled(*noise({300, 100, 100}), 3, nothing_lost, -1)));
  ASSERT_TRUE(all.is_done());
  all.views.grab();
  EXPECT_EQ(said.count("big.zarr: is gone; mount it again"), 1) << said.join("; ").toStdString();
  EXPECT_TRUE(names(all.slice(), ", octave ")) << words_of(all.slice());
}

}  // namespace slice_tiles_test
}  // namespace palpa::explorer
