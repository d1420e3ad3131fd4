// Lengths that the proxy's path does not tell apart, as shares of the finest spacing near it; what less and more would cost.
#pragma once

namespace palpa::path_tolerances {

inline constexpr double contact_tolerance =
    1e-9;  ///< [1] a place this near is on a level; less: contact lost to rounding, more: soft
inline constexpr double new_plane_min =
    1e-7;                               ///< [1] a facet that shuts out less is known; less: learnt for ever, more: stays inside
inline constexpr double still = 1e-6;   ///< [1] depth that needs no facet; less: facets of rounding, more: walls drift
inline constexpr double rest = 1e-4;    ///< [1] a step that goes on by less is settled; less: sub-steps, more: no still hand
inline constexpr double turned = 5e-4;  ///< [1] an end that changes less keeps directions; less: balances, more: bent rails
inline constexpr double shallow = 1e-3;   ///< [1] depth of an end that teaches nothing; less: stops in grooves, more: is felt
inline constexpr double piercing = 2e-2;  ///< [1] depth that stops a straight move; less: stops on curves, more: cuts walls
inline constexpr double sufficient_decrease =
    0.9;  ///< [1] of the promised energy that must be gained; less: creeps inwards, 1: stops

}  // namespace palpa::path_tolerances
