// Octaves that a hand felt of volumes larger than memory.
#pragma once

#include <cstdint>

#include "palpa/scene/scene.h"
#include "palpa/solver/vec3.h"

namespace palpa {

/// Felt octaves of a run.
struct FeltOctaves {
  double finest_share = 0.0;  ///< [1] of ticks at octave 0
  /// [1] of ticks whose felt octave has voxels no wider than the proxy's way in the tick, rounded up to an octave
  double as_fine_as_way_share = 0.0;
  double mean = 0.0;              ///< [1] felt octave
  std::int64_t forced_ticks = 0;  ///< whose octave was raised at once
};

/// Accumulates felt octaves by tick. Allocates nothing.
class FeltOctavesBuilder {
 public:
  /// \param spacing_m  [m] of octave 0, in hand metres; 0: no volume is larger than memory
  explicit FeltOctavesBuilder(double spacing_m) : spacing_m_(spacing_m) {}
  /// \param octave   [1] λ
  /// \param proxy_m  [m] in hand metres
  void add(double octave, bool is_forced, const Vec3& proxy_m) noexcept;
  bool empty() const noexcept { return spacing_m_ == 0.0 || ticks_ == 0; }
  FeltOctaves finish() const noexcept;

 private:
  double spacing_m_;
  std::int64_t ticks_ = 0, finest_ = 0, as_fine_ = 0, forced_ = 0;
  double sum_ = 0.0;
  Vec3 last_m_;
};

/// [m] Least sample spacing of a scene's volumes larger than memory, in hand metres; 0 without any.
double spacing_of_octaves_m(const Scene& scene);

}  // namespace palpa
