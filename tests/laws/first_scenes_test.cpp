// First scenes of measured data under slow hands and as maps: forces within the sum of strengths. Scans are cut off, and where
// a surface met the end of the data a proxy was once held by more.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "palpa/palpa.h"
#include "palpa/scene/first_scene.h"
#include "palpa/study/felt.h"
#include "palpa/study/map.h"
#include "palpa/study/summary.h"
#include "tests/laws/shipped_scenes.h"
#include "tests/today.h"

namespace palpa {
namespace first_scenes_test {

// One file of each data set.
const std::vector<std::string> files = {"ct_headphantom_dicom",
                                        "ct_head_cranium/cranium.mhd",
                                        "ct_head_headsq/quarter.nhdr",
                                        "mri_flow_carotid/carotid.vtk",
                                        "cfd_combustor/combxyz.bin",
                                        "cfd_bluntfin/bluntfinxyz.bin",
                                        "cfd_office/office.binary.vtk",
                                        "cfd_wing/wing.vti",
                                        "weather_isabel/isabel_30.vti",
                                        "dti_brain/FA.nii.gz",
                                        "mri_flair_nrrd/FLAIR.nrrd",
                                        "mra_avf_nrrd/avf_float_32.nrrd",
                                        "mri_mha_zlib/mha.mha",
                                        "mri_head_mhd/HeadMRVolume.mhd",
                                        "mri_avg152_bigendian/avg152T1_RL_nifti.nii.gz",
                                        "mri_epi_4d/example4d.nii.gz",
                                        "nifti_orientations/RAS.nii.gz",
                                        "mol_ironprot/ironProt.vtk",
                                        "mol_hydrogen/hydrogen.vti"};

class FirstSceneOf : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (const std::string missing = test::missing_for("real"); !missing.empty()) GTEST_SKIP() << missing;
    VolumeRequest request;
    request.files = {test::shared_data() / GetParam()};
    const VolumeReader read = volume_reader({.reader = test::reader()});
    scene_ = parse_scene(first_scene(read(request), request), "first", ".", read, standard_modes(),
                         {.sets = {{"time.play", "hold"}}})
                 .scene;
    scene_.edit<CouplingOptions>(
        [&](auto& coupling) { coupling.damping_ns_per_m = 0.0; });  // the damper's force is the coupling's, not the data's
  }
  Scene scene_;
};

/// The strengths [N] placed in a tick, of a corner once, plus drags at the proxy's speed.
double met_n(const Session& session) {
  double most_n = 0.0;
  for (const SubStep& step : session.sub_steps()) {
    double sum_n = 0.0;
    const auto placed = session.primitives().subspan(step.first_primitive, step.primitives);
    for (std::size_t i = 0; i < placed.size(); ++i) {
      const Primitive& p = placed[i].primitive;
      if (i > 0 && placed[i - 1].primitive.id == p.id) continue;
      sum_n += p.strength_n + p.drag_ns_per_m / step.time_step_s * distance(step.proxy_m, step.start_m);
    }
    most_n = std::max(most_n, sum_n);
  }
  return most_n;
}

/// True if a mode's forces move a proxy at rest, as on a vortex' core: there may be no balance, and after some turns the path
/// continues with the next probe position.
bool is_driven(const Scene& scene) {
  return std::ranges::any_of(scene.modes(), [](const SceneMode& mode) {
    return places_directed_forces(mode.mode.type()) || mode.mode.type() == "vortex_line";
  });
}

constexpr int across = 9, a_day = 15;

/// The hands of a square of so many across, in today's order: each nine have one in each row and column, and begin elsewhere
/// for nine days.
std::vector<int> hands_of_today() {
  std::vector<int> hands;
  for (int n = 0; n < across; ++n) {
    for (int hand = 0; hand < across * across; ++hand) {
      if ((hand % across + 2 * (hand / across) + n + test::today()) % across == 0) hands.push_back(hand);
    }
  }
  return hands;
}

/// Fifteen hands a day, and further ones until enough is felt; with PALPA_TESTS_LONG in the environment all.
TEST_P(FirstSceneOf, HoldsNoSlowHandWithMoreThanItsStrengths) {
  constexpr double reach_m = 0.072, begin_m = 0.11, end_m = -0.06, speed_m_per_s = 0.025, dt_s = 1e-3;
  int felt = 0, tried = 0;
  double worst_n = 0.0, largest_n = 0.0;
  for (const int hand : hands_of_today()) {
    if (!test::all_days() && ++tried > a_day && felt > 1000) break;
    const auto at = [&](int i) { return reach_m * (2.0 * i / (across - 1) - 1.0); };
    Session session(scene_);
    GuardedSession guarded(session, scene_.coupling().max_force_n);
    for (int i = 0; begin_m - i * speed_m_per_s * dt_s > end_m; ++i) {
      const Vec3 probe_m{at(hand % across), at(hand / across), begin_m - i * speed_m_per_s * dt_s};
      const TickFrame frame = guarded.tick(i, i * dt_s, dt_s, {.position_m = probe_m});
      const Tick& tick = frame.result;
      largest_n = std::max(largest_n, norm(frame.command.force_n));
      if (tick.status == TickStatus::waiting) continue;
      const double force_n = norm(tick.force_n);
      felt += force_n > 0.1;
      const double unexplained_n = is_driven(scene_) ? 0.1 * unborne_felt_n : 1e-3;
      worst_n = std::max(worst_n, tick.unborne_n);
      ASSERT_LE(tick.unborne_n, 0.01 * force_n + unexplained_n) << probe_m.x << ", " << probe_m.y << ", " << probe_m.z;
      // A level stronger than the output limit holds a rigid hand at any depth: there the limiter acts.
      ASSERT_LE(force_n, 1.01 * met_n(session) + 1e-3) << probe_m.x << ", " << probe_m.y << ", " << probe_m.z;
    }
  }
  std::printf("%s: at most %.3f N reach the hand, at most %.3g N are borne by no strength; the limit is %g N\n",
              GetParam().c_str(), largest_n, worst_n, scene_.coupling().max_force_n);
  EXPECT_LE(largest_n, (1.0 + 1e-12) * scene_.coupling().max_force_n);
  EXPECT_GT(felt, 1000) << "too little was met";
}

/// Largest force of the scene's modes on a hand at rest [N].
double strengths_of(const Scene& scene) {
  // Taken from placed primitives along any path: the largest of all points.
  double most_n = 0.0;
  Session session(scene);
  session.set_force_limit(scene.coupling().max_force_n);
  for (int way = 0; way < 400; ++way) {
    session.reset();
    const double x_m = 0.15 * ((way % 20) / 19.0 - 0.5), y_m = 0.15 * (std::floor(way / 20.0) / 19.0 - 0.5);
    for (double z_m = 0.1; z_m > -0.08; z_m -= 5e-4) {
      session.tick({.position_m = {x_m, y_m, z_m}}, 5e-3);
      double sum_n = 0.0;
      const auto placed = session.primitives();
      for (std::size_t i = session.sub_steps().back().first_primitive; i < placed.size(); ++i) {
        if (i == 0 || !(placed[i - 1].primitive.id == placed[i].primitive.id)) sum_n += placed[i].primitive.strength_n;
      }
      most_n = std::max(most_n, sum_n);
    }
  }
  return most_n;
}

TEST_P(FirstSceneOf, HasNoPlaceOnItsMapWithMoreThanItsStrengths) {
  const double strengths_n = strengths_of(scene_);
  const auto number = std::ranges::find(files, GetParam()) - files.begin();
  for (int axis = 0; axis < 3; ++axis) {
    if (!test::is_of_today(number + axis, 3)) continue;
    ForceMap map(map_slice(axis, 0.0, 0.18, 64));
    feel_map(scene_, map);
    double most_n = 0.0;
    for (const MapPoint& point : map.points) most_n = std::max(most_n, norm(point.steady_n));
    EXPECT_LE(most_n, 1.01 * strengths_n + 1e-3) << "across axis " << axis;
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, FirstSceneOf, testing::ValuesIn(files), [](const auto& file) {
  std::string name = file.param.substr(0, file.param.find('/'));
  return name;
});

}  // namespace first_scenes_test
}  // namespace palpa
