// Flow, noise and vortices of a vector field: the basis of its first scene.
#pragma once

#include <optional>

#include "palpa/data/statistics.h"
#include "palpa/data/volume.h"
#include "palpa/scene/first_levels.h"
#include "palpa/scene/first_object.h"

namespace palpa::detail {

/// Field that locates flowing tissue: the magnitude image of a velocity MR.
struct FlowSignal {
  std::size_t field = 0;  ///< number in the volume
  double from = 0.0;      ///< below, there is no tissue; in that field's own unit
  double full = 0.0;      ///< the mask is 1 from here on; in that field's own unit
};

/// Region of rotation about a core, by Q of the smoothed velocity (docs/modes/vortex_force.md), in (unit of the field/m)².
struct Vortices {
  double from = 0.0;            ///< Q at which a pull onto the core begins
  double full = 0.0;            ///< Q of full strength
  double most = 0.0;            ///< largest Q
  Vec3 core_m;                  ///< position of the largest Q in the largest vortex
  bool by_noise = false;        ///< true: noise stays below `from`; false: `from` is a quarter turn while the stream passes
  double coherence_from = 0.0;  ///< [1] below, high Q is due to a wall; 0: no such walls
  double coherence_full = 0.0;  ///< [1] from here on there is no wall
};

/// Region of rotation or shear, by the length of the curl, in unit of the field/m: there the flow varies, and rails show it.
struct Turning {
  double from = 0.0;  ///< a quarter turn while the stream crosses the object
  double full = 0.0;  ///< median above `from`
  double most = 0.0;  ///< the largest
};

/// Field with one value in the fluid and another in the wall.
struct Wall {
  std::size_t field = 0;  ///< number in the volume
  double level = 0.0;     ///< half way; in that field's own unit
  double fluid = 0.0;     ///< fluid from here on, without the edge's fractions; in that field's own unit
  bool around = false;    ///< a wall around the flow, as of a vessel; else a body in the stream

  bool fluid_is_high() const noexcept { return fluid > level; }
};

/// Regions of a vector field.
struct FlowPlaces {
  Object object;                     ///< region of flow, without noise
  FirstFlow speeds;                  ///< without noise
  double noisy_share = 0.0;          ///< [1] part of the moving cells whose vectors disagree with their neighbours
  bool noisy = false;                ///< noise has to be masked
  bool in_octaves = false;           ///< no fields are derived from it on a grid: no coherence or Q
  std::optional<std::size_t> curl;   ///< of a field in octaves: number of its curl, which `palpa prepare --derive` wrote
  std::optional<FlowSignal> signal;  ///< of a flow that is noisy or fills little of the data
  std::optional<Vortices> vortices;
  std::optional<Turning> turning;
  std::optional<Wall> wall;
};

/// [1] `coherence` of moving vectors: noise below the first, a stream from the second on. More: turbulent flow is masked; less:
/// noise is felt.
constexpr double coherence_of_noise = 0.2, coherence_of_flow = 0.35;

/// Name of a field of the volume in its file. Allocates; any thread.
std::string array_of(const Volume& volume, std::size_t field);

/// Derives coherence and Q of the field, unless it has directions only; of a field in octaves the coherence of a sample of
/// octave 0 alone, and its turning by the curl in its store.
/// \param flow    number of the vector field
/// \param speeds  of that field, from its statistics
/// \param values  statistics of each field of the volume
FlowPlaces flow_places(const Lattice& lattice, const Volume& volume, std::size_t flow, const FirstFlow& speeds,
                       const std::vector<Statistics>& values);

}  // namespace palpa::detail
