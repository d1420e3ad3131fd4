// The cases: volume, hand and right force.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/haptics/volume.h"

namespace palpa::haptics {

// Ruffaldi et al. 2006: 0.5 N/mm.
inline constexpr double stiffness_n_per_m = 500.0;
inline constexpr double time_step_s = 1e-3;
inline constexpr double force_limit_n = 8.0;

/// The hand's phase, which scores select by.
enum class Phase { moving, still, sliding };

struct Touch {
  Vec3 probe_m;
  Vec3 force_n;
  Phase phase = Phase::moving;
};

/// Adds ticks in a shape's rotated frame.
class Trajectory {
 public:
  explicit Trajectory(const Mat3& turn = Mat3::identity()) : turn_(turn) {}

  /// A hand derived from the force: below the surface by the spring's extension. \param outward  [1] unit vector along the
  /// force; a negative force [N]: a hand before the surface, without force
  void press(const Vec3& place_m, const Vec3& outward, double force_n, Phase phase = Phase::moving);
  /// A hand and its proxy: the spring between them is the force.
  void held(const Vec3& probe_m, const Vec3& place_m, Phase phase = Phase::moving);

  std::vector<Touch> touches;

 private:
  Mat3 turn_;
};

struct Case {
  std::string name;
  std::string family;
  std::string volume;  ///< a name in the suite
  nlohmann::json rule;
  nlohmann::json shape;             ///< reference for the proxy; null: none
  std::vector<std::string> scores;  ///< names in score.h
  std::vector<Touch> touches;
  bool quick = false;    ///< part of the tests
  int period_ticks = 0;  ///< of repetition; 0: never
  double friction_deg = 0.0;
};

/// All cases and their volumes, which are made on demand.
struct Suite {
  std::map<std::string, std::function<SampledVolume()>> volumes;
  std::vector<Case> cases;
};

void add_surface_cases(Suite& suite);
/// \param hand_file  the recorded hand, hand.csv beside the sources
void add_hand_cases(Suite& suite, const std::filesystem::path& hand_file);
void add_field_cases(Suite& suite);
/// \param head_file  the CT head of tools/get-ct-head
void add_scan_cases(Suite& suite, const std::filesystem::path& head_file);

struct Sampling {
  int samples = 128;  ///< along each side of the cube
  double edge_m = 0.072;
  int bits = 12;
  double noise = 0.0;   ///< [1] standard deviation over the step from outside to inside
  int ramp_voxels = 3;  ///< from the surface to constant values, on either side
};
/// Rule of an unbreakable surface at this volume's level.
nlohmann::json surface_rule(const Sampling& sampling, double friction_coefficient = 0.0);
/// The voxels: 0.1 of the type's range outside, 0.9 inside, a ramp between.
SampledVolume sampled(const nlohmann::json& shape, const Sampling& sampling);
/// Suffix of a name: "-64-8bit-noise3".
std::string format_sampling(const Sampling& sampling);

/// A shape, and the name stem of its volumes and cases.
struct Body {
  std::string name;
  nlohmann::json shape;
};
/// Adds a surface case and its volume, with the rule of an unbreakable surface unless the case has a rule.
void add_surface_case(Suite& suite, const Body& body, const Sampling& sampling, Case told);

}  // namespace palpa::haptics
