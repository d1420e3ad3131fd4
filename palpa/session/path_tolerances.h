// Tolerances of the proxy's path, relative to the finest spacing near it.
#pragma once

#include <limits>

namespace palpa::path_tolerances {

/// [1] No limit, of shares and lengths alike.
inline constexpr double unbounded = std::numeric_limits<double>::infinity();

/// [1] A closer position is on a level; less: contact lost to rounding, more: soft contact.
inline constexpr double contact_tolerance = 1e-9;
/// [1] A facet that excludes less is not new; less: endless facets, more: stays inside.
inline constexpr double new_plane_min = 1e-7;
/// [1] Depth that needs no facet; less: facets from rounding, more: walls drift.
inline constexpr double still = 1e-6;
/// [1] A shorter move settles its step; less: sub-steps, more: a still hand is not still.
inline constexpr double rest = 1e-4;
/// [1] An end that changes less keeps directions; less: balances, more: bent rails.
inline constexpr double turned = 5e-4;
/// [1] Depth of an end that adds no facet; less: stops in grooves, more: can be felt.
inline constexpr double shallow = 1e-3;
/// [1] Depth that stops a straight move; less: stops on curves, more: cuts walls.
inline constexpr double piercing = 2e-2;
/// [1] Required share of the promised decrease of energy; less: creeps inwards, 1: stops.
inline constexpr double sufficient_decrease = 0.9;

}  // namespace palpa::path_tolerances
