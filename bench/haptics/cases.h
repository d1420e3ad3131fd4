// The cases: what is felt, by which hand, and what the answer is.
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

/// What the hand does in a tick, as far as scores ask for it.
enum class Phase { moving, still, sliding };

/// One tick: where the hand is, and the force that is right.
struct Touch {
  Vec3 probe_m;
  Vec3 force_n;
  Phase phase = Phase::moving;
};

/// Adds ticks in the frame of a shape, turned as it is.
class Trajectory {
 public:
  explicit Trajectory(const Mat3& turn = Mat3::identity()) : turn_(turn) {}

  /// A hand that was made of the force: it is so deep under a place of the surface that the spring has that force.
  /// \param outward  [1] unit vector, along which the force is; a negative force [N] is a hand before the surface, which feels
  /// none
  void press(const Vec3& place_m, const Vec3& outward, double force_n, Phase phase = Phase::moving);
  /// A hand, and where it is held: the spring between the two is the force.
  void held(const Vec3& probe_m, const Vec3& place_m, Phase phase = Phase::moving);

  std::vector<Touch> touches;

 private:
  Mat3 turn_;
};

struct Case {
  std::string name;
  std::string family;
  std::string volume;  ///< of the suite's
  nlohmann::json rule;
  nlohmann::json shape;             ///< that a felt place is held against; null: none
  std::vector<std::string> scores;  ///< names of score.h
  std::vector<Touch> touches;
  bool quick = false;         ///< one of the few that a test runs
  int period_ticks = 0;       ///< after which the hand comes by again; 0: never
  double friction_deg = 0.0;  ///< angle of the friction cone
};

/// All cases, and the volumes that they name, each made when it is asked for.
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

/// A shape as a scanner would have it.
struct Sampling {
  int samples = 128;  ///< along each side of the cube
  double edge_m = 0.072;
  int bits = 12;
  double noise = 0.0;   ///< [1] deviation, as a share of the step from outside to inside
  int ramp_voxels = 3;  ///< from the surface to where the values stay as they are, to either side
};
/// The rule for a surface that never lets go, at the level of such a volume.
nlohmann::json surface_rule(const Sampling& sampling, double friction_coefficient = 0.0);
/// The voxels: 0.1 of what the bits hold outside, 0.9 inside, a ramp between.
SampledVolume sampled(const nlohmann::json& shape, const Sampling& sampling);
/// What it adds to a name: "-64-8bit-noise3".
std::string words_of(const Sampling& sampling);

/// A shape, and how volumes and cases of it are named.
struct Body {
  std::string name;
  nlohmann::json shape;
};
/// Adds a case of a surface: its volume, unless that is there, and the rule for a surface that never lets go, unless the case
/// has another.
void add_surface_case(Suite& suite, const Body& body, const Sampling& sampling, Case told);

}  // namespace palpa::haptics
