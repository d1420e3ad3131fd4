// Families of balance problems, easy and degenerate: identical on every machine.
#pragma once

#include <span>
#include <string_view>

#include "tests/solver/random_problems.h"

namespace palpa::test {

/// A generator of problems of n primitives, 0 <= n <= 1000, all of which a PrimitiveSet accepts. `drags`
/// also puts about half of the primitives at the start and gives them a drag: mostly up to 20 N·s/m, some
/// 1e-9, some 1e5 N·s/m.
///
/// Unless said otherwise k is 300 to 3000 N/m, strengths are up to 5 N, the probe is some millimetres from
/// the start, and anchors are at the start or some millimetres off it.
///
/// Ordinary:
///   random                  anchors within centimetres of the start, the probe too
///   haptic                  as modes place them: most anchors at the start, the rest within a millimetre
///   haptic_slipping         likewise, with strengths that together cannot hold the probe back
///   at_proxy                all anchors at the start, exactly
/// Degenerate, one difficulty each:
///   parallel_planes         planes of one normal or its opposite
///   coincident              points and lines, several at each of a few points
///   nearly_parallel_lines   directions 1e-9 to 1e-2 rad apart
///   nearly_parallel_planes  normals, also opposed, 1e-9 to 1e-2 rad apart
///   zero_strengths          every other strength is zero
///   wide_strengths          strengths of 1e-6 to 1e3 N, log-uniform
///   probe_on_primitives     the probe lies on every primitive
///   stiff_coupling          k of 1e6 to 1e9 N/m
///   far_anchors             anchors up to 1e3 m away
///   stick_threshold         every primitive sticks with its full strength, to 1e-12 of it
///   slab_and_wedge          planes that cannot all be satisfied
///   soft_coupling           k of 1 to 30 N/m
///   mixture                 all of the above in one problem
/// Special positions:
///   all_strengths_zero      nothing pulls, but drags
///   demand_on_anchors       probe + directed/k is exactly every anchor
///   planes_meeting          two or three planes meet at the balance
///   overdetermined          all primitives stick at one point, more than there are dimensions
///   opposed_planes          pairs of opposed planes with equal strength
///   duplicated              every primitive twice
///   resting_corner          at rest at the start between facing planes, lines, a point: all stick
/// Corners of up to eight facets, with up to four others of the first families; at most n primitives, facets counted:
///   corner                  normals about an axis, anchors at the start or within a millimetre
///   groove                  two facets, 1 to 150 degrees open
///   pit                     three facets or more through one point
///   corner_at_yield         holds with its full strength, to 1e-12 of it
///   nearly_parallel_facets  normals 1e-9 to 1e-2 rad apart
///   narrow_groove           two facets, 0.12 to 3 degrees open
///   duplicated_facets       facets twice, whole corners twice
///   corner_at_proxy         all at the start, exactly, with friction
///   corner_on_border        its pull is on the border of two faces
///   two_corners             two of the first
///   wide_strength_corner    strengths of 1e-5 to 1e3 N, log-uniform
///   soft_coupling_corner    k of 1 to 30 N/m
///   corner_mixture          two of all these, with others of all families
/// Elastic families, most of their planes and corners of a stiffness about that of the coupling, some 1e-9 or 1e9 times that:
///   elastic_NAME            the families above
///   elastic_at_yield        planes at their largest deflection, to 1e-12 of it, among primitives that stick
struct Family {
  const char* name;
  bool at_proxy;  ///< all anchors are exactly at the start
  Problem (*make)(Random& random, int n, bool drags);
  bool is_new = false;  ///< corners or elastic: unknown to earlier laws
};

std::span<const Family> families();

/// The family of this name; nullptr without it.
const Family* family_named(std::string_view name);

}  // namespace palpa::test
