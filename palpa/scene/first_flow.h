// Where a vector field flows, where it is noise, and where it turns: the basis of a first scene of it.
#pragma once

#include <optional>

#include "palpa/data/statistics.h"
#include "palpa/data/volume.h"
#include "palpa/scene/first_levels.h"
#include "palpa/scene/first_object.h"

namespace palpa::detail {

/// Another field of the volume that says where there is something that can flow: the magnitude image of a velocity MR.
struct FlowSignal {
  std::size_t field = 0;  ///< its number in the volume
  double from = 0.0;      ///< below, nothing is there; in that field's own unit
  double full = 0.0;      ///< from here on the mask is 1; in that field's own unit
};

/// Where a flow turns about a core, by Q of its smoothed velocity (docs/modes/vortex_force.md), in (unit of the field/m)².
struct Vortices {
  double from = 0.0;            ///< Q at which a pull onto the core begins
  double full = 0.0;            ///< Q from which it has all its strength
  double most = 0.0;            ///< the largest Q
  Vec3 core_m;                  ///< where Q is largest within the largest vortex
  bool by_noise = false;        ///< true: noise stays below `from`; false: `from` is a quarter turn while the stream passes
  double coherence_from = 0.0;  ///< [1] below, it is a wall, where Q is high as well; 0: no such walls
  double coherence_full = 0.0;  ///< [1] from here on it is no wall
};

/// Where a flow turns or shears, by the length of its curl, in unit of the field/m: there it differs from place to place, and
/// rails show it. A uniform stream has none.
struct Turning {
  double from = 0.0;  ///< a quarter turn while the stream crosses the object
  double full = 0.0;  ///< the median of what turns faster
  double most = 0.0;  ///< the largest
};

/// Another field of the volume that is one number where it flows and another one where there is a wall.
struct Wall {
  std::size_t field = 0;  ///< its number in the volume
  double level = 0.0;     ///< half way; in that field's own unit
  double fluid = 0.0;     ///< from here on it is fluid, without the edge's fractions; in that field's own unit
  bool around = false;    ///< the wall is around the flow, as that of a vessel; else a body is in the stream

  bool fluid_is_high() const noexcept { return fluid > level; }
};

/// Where a vector field flows.
struct FlowPlaces {
  Object object;                     ///< where it flows, noise left out
  FirstFlow speeds;                  ///< of what is not noise
  double noisy_share = 0.0;          ///< [1] of what moves, the part whose vectors are at odds with those around them
  bool noisy = false;                ///< `noisy_share` is so large that noise has to be masked
  std::optional<FlowSignal> signal;  ///< of a flow that is noisy or fills little of the data
  std::optional<Vortices> vortices;
  std::optional<Turning> turning;
  std::optional<Wall> wall;
};

/// [1] `coherence` of moving vectors: below the first they are noise, from the second on a stream. More: parts of turbulent
/// flows are masked; less: noise is felt.
constexpr double coherence_of_noise = 0.2, coherence_of_flow = 0.35;

/// \param flow    number of the vector field
/// \param speeds  of that field, from its statistics
/// \param values  statistics of each field of the volume
/// Derives coherence and Q of the field, but of directions.
FlowPlaces flow_places(const Lattice& lattice, const Volume& volume, std::size_t flow, const FirstFlow& speeds,
                       const std::vector<Statistics>& values);

}  // namespace palpa::detail
