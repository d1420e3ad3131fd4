// Where a vector field flows, where it is noise, and where it turns: what a first scene of it stands on.
#pragma once

#include <optional>

#include "palpa/first/first_levels.h"
#include "palpa/first/object.h"
#include "palpa/survey/statistics.h"
#include "palpa/volume/volume.h"

namespace palpa::detail {

/// Another field of the volume that says where there is something that can flow: the magnitude image of a velocity MR.
struct Signal {
  std::size_t field = 0;  ///< its number in the volume
  double from = 0.0;      ///< nothing is there below, in that field's own unit
  double full = 0.0;      ///< in that field's own unit
};

/// Where a flow turns about a core, by Q of its smoothed velocity (docs/modes/vortex_force.md), in (unit of the field/m)².
struct Vortices {
  double from = 0.0;
  double full = 0.0;
  double most = 0.0;            ///< the largest Q
  Vec3 core_m;                  ///< where that is, in the largest of them
  bool by_noise = false;        ///< `from` is what noise does not reach, else what turns by a quarter while the stream passes
  double coherence_from = 0.0;  ///< [1] beside walls, where Q is high too, the field is less coherent; 0: no such walls
  double coherence_full = 0.0;  ///< [1]
};

/// Where a vector field flows.
struct FlowPlaces {
  Object object;                 ///< where it flows, noise left out
  FirstFlow speeds;              ///< of what is not noise
  double noisy_share = 0.0;      ///< [1] of what moves that is at odds with what is around it
  bool noisy = false;            ///< so much that it has to be masked
  std::optional<Signal> signal;  ///< of a flow that is noisy or fills little of the data
  std::optional<Vortices> vortices;
};

/// Below the first, vectors are noise, from the second on a stream: `coherence` of what moves.
constexpr double coherence_of_noise = 0.2, coherence_of_flow = 0.35;

/// \param flow    number of the vector field
/// \param speeds  of that field, from its statistics
/// \param values  statistics of each field of the volume
/// Derives coherence and Q of the field, but of directions.
FlowPlaces flow_places(const Lattice& lattice, const Volume& volume, std::size_t flow, const FirstFlow& speeds,
                       const std::vector<Statistics>& values);

}  // namespace palpa::detail
