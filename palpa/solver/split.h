// Unique split of force over redundant primitives, for reports.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "palpa/solver/law.h"

namespace palpa {

/// Feet of a tool's primitives. The default is of a point.
struct FeetOfRows {
  std::span<const Vec3> levers_m{};  ///< by primitive, from the device's point
  double turning_radius_m = 0.0;     ///< ρ; 0: a point
  bool is_point() const noexcept { return turning_radius_m == 0.0; }
};

/// Whether `primitives[i]`, or the whole corner that it is a facet of, can exchange force with others at `balance`, as its foot
/// has it: it has a strength and sticks, so that any force within its strength can balance. Other forces are unique: slip
/// determines the force; without contact it is zero. A drag makes no difference: it is zero without motion.
bool is_exchangeable(std::span<const Primitive> primitives, std::size_t i, const Balance& balance) noexcept;

/// Whether the forces of these primitives can be exchanged: more directions are held than their spans have dimensions.
bool split_is_shared(std::span<const Primitive> primitives, const Balance& balance, const FeetOfRows& feet = {}) noexcept;

/// Replaces the forces of the exchangeable primitives by the split of their total, of a tool of their total wrench, with the
/// least Σ|u|²/s (u a force, s its primitive's strength). It is unique, so it depends on the balance alone: not on the order of
/// the primitives, nor on a warm start. Coincident primitives share in proportion to their strengths. All other forces stay;
/// any that is not finite becomes zero.
///
/// Takes microseconds for typical modes, so it is no part of a tick. Reads and writes only its arguments; allocates nothing;
/// bounded number of steps; the result is finite for any arguments.
/// \param forces_n  [N] a valid split, in the order of `primitives`; at least as many
/// \return [N] length of the lost part of the total: rounding, about 1e-14 of forces and strengths
double least_split(std::span<const Primitive> primitives, const Balance& balance, std::span<Vec3> forces_n,
                   const FeetOfRows& feet = {}) noexcept;

/// Forces of a recorded sub-step for reports: the least split of a balance; the recorded forces if an earlier system's law
/// found no balance. Allocates at construction; one thread.
class ShownForces {
 public:
  explicit ShownForces(std::size_t most_primitives);
  /// Force of each row [N]; valid until the next call. Allocates nothing up to `most_primitives` rows.
  std::span<const Vec3> of(std::span<const PlacedPrimitive> placed, const SubStep& step) noexcept;
  /// Whether row `i` of the last call shares its force with others.
  bool is_shared(std::size_t i) const noexcept { return shared_[i]; }

 private:
  std::vector<Primitive> primitives_;
  std::vector<Vec3> levers_m_;
  std::vector<Vec3> forces_n_;
  std::vector<bool> shared_;
};

}  // namespace palpa
