// The parts of bench_felt: figures of one scene or of devices alone.
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

struct Figure {
  std::string name;
  std::string measured;
  std::string asked;  ///< empty: no limit
  bool met = true;
  double badness = 0.0;  ///< [1] larger is worse: ranks the scenes
  bool applies = true;   ///< false: not measurable in this scene; `measured` has the reason
};

/// A scene and the data that its hands need.
struct FeltScene {
  std::string name;
  std::string origin;
  Scene scene;
  Encounter rigid, held;  ///< first contact of a rigid and of a relaxed hand
  EdgesOfData edges;
  double spacing_m = 0.0;  ///< [m] of hand, between the samples of the first field
};
std::vector<std::string> felt_scene_names();
/// Throws LoadError.
/// \param in_place_folder  NAME.toml in it replaces a suggested scene; empty: none
FeltScene load_felt_scene(const std::string& name, const std::filesystem::path& scenes_folder,
                          const std::filesystem::path& data_folder, const std::filesystem::path& in_place_folder);

inline constexpr double rate_hz = 1000.0;

/// Press along the user's axis beside the front, to 50 mm behind it.
std::shared_ptr<const Target> press_at(const Encounter& met, double u_m, double v_m, double speed_m_per_s);
inline constexpr double press_depth_m = 0.05;
double press_duration_s(const Encounter& met, double speed_m_per_s);

/// Run of a rigid hand in a device of this kind.
FeltRun feel(const Scene& scene, const std::shared_ptr<const Target>& target, double duration_s, const DevicePlant& plant = {});

std::vector<DevicePlant> device_plants();

std::vector<Figure> slides(const FeltScene& felt);
std::vector<Figure> tremor(const FeltScene& felt);
std::vector<Figure> breaks(const FeltScene& felt);
std::vector<Figure> stiffness(const FeltScene& felt);
std::vector<Figure> normals(const FeltScene& felt);
std::vector<Figure> held(const FeltScene& felt);
/// Needs no scene.
std::vector<Figure> released_device_figures();

#ifdef PALPA_BENCH_PICTURES
/// HandSlide, press, held hand and spectra of a scene, as a PNG.
void save_felt_picture(const FeltScene& felt, const std::filesystem::path& file);
#endif

}  // namespace palpa::bench
