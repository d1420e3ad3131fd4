// Ticks of data that could change with time and do not, beside those of plain grids: time and work, as ratios, in one run.
//
//   bench_timed                               a table
//   bench_timed count SCENE HAND DATA         the number of ticks under valgrind's callgrind, begun with --instr-atstart=no
//
// SCENE is one of "scan" and "flow", HAND and DATA as in the table.
#include <palpa/palpa.h>
#include <time.h>
#if __has_include(<valgrind/callgrind.h>)
#include <valgrind/callgrind.h>
#else  // no counts without valgrind's header
#define CALLGRIND_START_INSTRUMENTATION
#define CALLGRIND_STOP_INSTRUMENTATION
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string_view>
#include <vector>

#include "palpa/data/analytic.h"
#include "palpa/data/sampled.h"
#include "palpa/data/smooth_grid.h"

namespace {

using namespace palpa;

constexpr double dt_s = 1e-3, voxel_m = 1e-3;
constexpr std::int64_t voxels = 64;
constexpr double half_m = 0.5 * (voxels - 1) * voxel_m;
constexpr Vec3 middle_m{0.0, 0.022, 0.0};  // of the head
constexpr int approach = 300, measured = 2000, passes = 9;

// Data of a variant; `beside` is the plain one that it is compared with.
struct Data {
  std::string_view name;
  std::string_view beside;
};
constexpr Data all_data[] = {{"plain", "plain"}, {"frame", "plain"},   {"blend", "plain"},        {"ended", "plain"},
                             {"posed", "posed"}, {"at_pose", "posed"}, {"between_poses", "posed"}};
constexpr std::string_view hands[] = {"moving", "at_rest", "along_edge", "at_rest_at_edge"};

/// This thread's processor time, independent of other load.
double thread_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// A scanned head, soft over hard, cut off on its sides.
FieldPtr head() {
  std::vector<float> values;
  for (std::int64_t n = 0; n < voxels * voxels * voxels; ++n) {
    const Vec3 x_m{static_cast<double>(n % voxels) * voxel_m - half_m,
                   static_cast<double>(n / voxels % voxels) * voxel_m - half_m,
                   static_cast<double>(n / voxels / voxels) * voxel_m - half_m};
    const double r_m = norm(x_m - middle_m);
    const auto ramp = [&](double at_m) { return std::clamp((at_m - r_m) / (3.0 * voxel_m) + 0.5, 0.0, 1.0); };
    values.push_back(static_cast<float>(-1000.0 + 1050.0 * ramp(0.028) + 1200.0 * ramp(0.022)));
  }
  const GridGeometry geometry{
      {voxels, voxels, voxels}, {{{voxel_m, 0, 0}, {0, voxel_m, 0}, {0, 0, voxel_m}}}, {-half_m, -half_m, -half_m}};
  const auto kept = std::make_shared<std::vector<float>>(std::move(values));
  return smooth_grid_field(geometry, {VoxelType::float32, 1, {kept, kept->data()}});
}

/// A vortex on a grid, its axis along z.
FieldPtr flow() { return sampled(*lamb_oseen_vortex().fields[0].field, static_cast<int>(voxels)); }

Similarity turned(double angle, double shift_m) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {{{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}}, 1.0, {shift_m, 0.0, 0.0}};
}
const Similarity pose_of_data = turned(0.2, 1e-3);

/// At that pose in the beginning, or half way.
PoseTrack track_of(std::string_view data) {
  if (data == "at_pose") return {{0.0, pose_of_data}, {1.0, turned(0.5, 0.0)}};
  return {{0.0, {}}, {1.0, turned(0.4, 2e-3)}};
}

Scene scene_of(std::string_view name, const FieldPtr& grid, std::string_view data) {
  const bool is_scan = name == "scan", is_series = data == "frame" || data == "blend" || data == "ended";
  Volume volume;
  volume.fields.push_back({"value", "", is_series ? time_series({grid, grid}, 1.0) : grid});
  Scene scene({.stiffness_n_per_m = 500.0, .damping_ns_per_m = 0.0, .max_force_n = 20.0});
  const bool moves = data == "at_pose" || data == "between_poses";
  const FieldRef field = moves ? scene.add_moving("data", volume, track_of(data), Filter::smooth)
                               : scene.add("data", volume, data == "posed" ? pose_of_data : Similarity{}, Filter::smooth);
  if (is_scan) {
    scene.add("surface", SurfaceAndFriction{.field = field,
                                            .levels = {{.name = "skin", .value = -300.0, .strength_n = 0.8},
                                                       {.name = "bone", .value = 300.0, .strength_n = 1.7}},
                                            .friction_coefficient = 0.1});
    scene.add("inside", Viscosity{.field = field, .strength_n = 0.05, .drag_ns_per_m = 1.0});
  } else {
    scene.add("rail", Follow{.field = field, .strength_n = 0.3});
    scene.add("air", Viscosity{.field = field, .strength_n = 0.05, .drag_ns_per_m = 0.5});
    scene.add("tube", VortexPlane{.field = field, .strength_n = 0.3});
  }
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  const bool between = data == "blend" || data == "between_poses";
  if (data == "ended") scene.set(TimeOptions{TimeOptions::Play::once, 1.0, 10.0});
  if (between) scene.set(TimeOptions{TimeOptions::Play::hold, 1.0, 0.5});
  return scene;
}

/// A way in the world of unposed data: from outside onto the skin, or into the flow, and then along or still.
std::vector<Vec3> way_of(std::string_view scene, std::string_view hand, const FieldPtr& grid) {
  const bool at_edge = hand == "along_edge" || hand == "at_rest_at_edge", moves = hand == "moving" || hand == "along_edge";
  const Box box = grid->bounds_m();
  const double below_m = at_edge ? 0.5 * grid->spacing_m() : 0.25 * box.size_m().z;
  std::vector<Vec3> way_m;
  for (int i = 0; i < approach + measured; ++i) {
    const double in = std::min(1.0, i / (0.9 * approach)), along_m = moves ? 1e-4 * std::max(0, i - approach) : 0.0;
    if (scene == "scan") {
      // Around the ball, at the height of the edge or of its middle.
      const double radius_m = 0.0320 - 0.0048 * in, height_m = at_edge ? half_m - below_m - middle_m.y : 0.0;
      const double flat_m = std::sqrt(radius_m * radius_m - height_m * height_m), turn = along_m / flat_m;
      way_m.push_back(middle_m + Vec3{flat_m * std::sin(turn), height_m, flat_m * std::cos(turn)});
    } else {
      const double radius_m = 0.25 * box.size_m().x, turn = along_m / radius_m;
      const double height_m = 0.5 * box.size_m().z - below_m - 0.1 * (1.0 - in) * box.size_m().z;
      way_m.push_back(box.centre_m() + Vec3{radius_m * std::cos(turn), radius_m * std::sin(turn), height_m});
    }
  }
  return way_m;
}

struct Felt {
  double seconds = std::numeric_limits<double>::max();  // of a tick
  double work = 0.0;                                    // of a tick
  int pulls = 0;                                        // ticks with a force
};

/// The ticks after the approach.
Felt feel(const Scene& scene, const std::vector<Vec3>& way_m, bool counts) {
  Session session(scene);
  for (int i = 0; i < approach; ++i) session.tick({.position_m = way_m[static_cast<std::size_t>(i)]}, dt_s);
  Felt felt;
  if (counts) CALLGRIND_START_INSTRUMENTATION;
  const double begin_s = thread_seconds();
  for (std::size_t i = approach; i < way_m.size(); ++i) {
    const Tick tick = session.tick({.position_m = way_m[i]}, dt_s);
    felt.work += tick.work;
    felt.pulls += norm(tick.force_n) > 1e-3;
  }
  felt.seconds = (thread_seconds() - begin_s) / measured;
  if (counts) CALLGRIND_STOP_INSTRUMENTATION;
  felt.work /= measured;
  return felt;
}

struct Case {
  Scene scene;
  std::vector<Vec3> way_m;
};
Case case_of(std::string_view scene, std::string_view hand, std::string_view data, const FieldPtr& grid) {
  const bool is_posed = data == "posed" || data == "at_pose" || data == "between_poses";
  const Similarity pose = is_posed ? pose_of_data : Similarity{};
  Case made{scene_of(scene, grid, data), way_of(scene, hand, grid)};
  for (Vec3& x_m : made.way_m) x_m = made.scene.hand_to_world().to_hand(pose.to_world(x_m));
  return made;
}

void table() {
  std::puts("| scene | hand | data | µs a tick | of the plain grid's | work a tick | of the plain grid's | ticks with force |");
  std::puts("|---|---|---|---|---|---|---|---|");
  for (const std::string_view scene : {"scan", "flow"}) {
    const FieldPtr grid = scene == "scan" ? head() : flow();
    for (const std::string_view hand : hands) {
      std::vector<Case> cases;
      for (const Data& data : all_data) cases.push_back(case_of(scene, hand, data.name, grid));
      std::array<Felt, std::size(all_data)> felt;
      for (int pass = 0; pass < passes; ++pass) {
        for (std::size_t i = 0; i < cases.size(); ++i) {
          const double least_s = felt[i].seconds;
          felt[i] = feel(cases[i].scene, cases[i].way_m, false);
          felt[i].seconds = std::min(felt[i].seconds, least_s);
        }
      }
      for (std::size_t i = 0; i < cases.size(); ++i) {
        const auto* of = std::find_if(std::begin(all_data), std::end(all_data),
                                      [&](const Data& other) { return other.name == all_data[i].beside; });
        const Felt& plain = felt[static_cast<std::size_t>(of - std::begin(all_data))];
        std::printf("| %s | %s | %s | %.2f | %.2f | %.1f | %.2f | %d |\n", scene.data(), hand.data(), all_data[i].name.data(),
                    1e6 * felt[i].seconds, felt[i].seconds / plain.seconds, felt[i].work, felt[i].work / plain.work,
                    felt[i].pulls);
      }
      std::fflush(stdout);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 1) {
    table();
    return 0;
  }
  if (argc != 5 || std::string_view(argv[1]) != "count") {
    std::fprintf(stderr, "usage: %s [count scan|flow HAND DATA]\n", argv[0]);
    return 2;
  }
  const std::string_view scene = argv[2];
  const Case one = case_of(scene, argv[3], argv[4], scene == "scan" ? head() : flow());
  feel(one.scene, one.way_m, true);
  std::printf("%d\n", measured);
  return 0;
}
