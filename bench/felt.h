// The parts of bench_felt: each measures some figures of what is felt, of one scene or of devices alone.
#pragma once

#include <palpa/palpa.h>
#include <palpa/study/felt.h>
#include <palpa/study/movement.h>
#include <palpa/study/reach.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "palpa/device/hand.h"

namespace palpa::bench {

/// A figure as the table has it.
struct Figure {
  std::string name;
  std::string measured;
  std::string asked;  ///< empty: nothing is
  bool met = true;
  double badness = 0.0;  ///< [1] larger is worse: by which scenes are compared
  bool applies = true;   ///< false: the scene has nothing that could be measured, and `measured` says what
};

/// A scene with all that hands need to know of it.
struct FeltScene {
  std::string name;
  std::string origin;  ///< its file
  Scene scene;
  Encounter rigid, held;  ///< what a rigid hand, and a relaxed one, comes upon
  EdgesOfData edges;
  double spacing_m = 0.0;  ///< [m] of hand, between the samples of the first field
};
/// The scenes that are measured, by name.
std::vector<std::string> felt_scene_names();
/// Loads one of them; throws LoadError.
FeltScene load_felt_scene(const std::string& name, const std::filesystem::path& scenes_folder,
                          const std::filesystem::path& data_folder);

inline constexpr double rate_hz = 1000.0;

/// In along the user's axis beside the place of the front, to 50 mm behind it.
std::shared_ptr<const Target> press_at(const Encounter& met, double u_m, double v_m, double speed_m_per_s);
inline constexpr double press_depth_m = 0.05;
double press_duration_s(const Encounter& met, double speed_m_per_s);

/// What a rigid hand in a device of this kind feels of a scene.
FeltRun feel(const Scene& scene, const std::shared_ptr<const Target>& target, double duration_s, const DevicePlant& plant = {});

/// The five devices.
std::vector<DevicePlant> device_plants();

std::vector<Figure> slides(const FeltScene& felt);
std::vector<Figure> tremor(const FeltScene& felt);
std::vector<Figure> breaks(const FeltScene& felt);
std::vector<Figure> stiffness(const FeltScene& felt);
std::vector<Figure> normals(const FeltScene& felt);
std::vector<Figure> held(const FeltScene& felt);
/// Needs no scene.
std::vector<Figure> let_go();

#ifdef PALPA_BENCH_PICTURES
/// HandSlide, press, held hand and spectra of a scene, as a PNG.
void save_felt_picture(const FeltScene& felt, const std::filesystem::path& file);
#endif

}  // namespace palpa::bench
