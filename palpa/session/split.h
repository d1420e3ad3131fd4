// Who pushes: the one split of force over redundant primitives that is shown to people.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "palpa/solver/law.h"

namespace palpa {

/// Whether a primitive can hand force over to others at `balance`: it has a strength and sticks, so that its
/// force is whatever keeps balance. The forces of all others are unique: slip says the force, a plane that was
/// left has none. A drag makes no difference: it does nothing where nothing moves.
bool is_exchangeable(const Primitive& primitive, const Balance& balance) noexcept;
/// The same of `primitives[i]`, or of the whole corner that it is a facet of.
bool is_exchangeable(std::span<const Primitive> primitives, std::size_t i, const Balance& balance) noexcept;

/// True when the forces of these primitives can be exchanged between them: more directions are held
/// than their spans have dimensions.
bool split_is_shared(std::span<const Primitive> primitives, const Balance& balance) noexcept;

/// Replaces the forces of the exchangeable primitives by the split of the same total with the least
/// Σ|u|²/s (u a force, s its primitive's strength). It is unique, so it depends on nothing but the
/// balance: not on the order of the primitives, not on what a law was warm-started with. Coincident
/// primitives share in proportion to their strengths; one of zero strength gets nothing. All other
/// forces stay; any that is not finite becomes zero.
///
/// Takes some microseconds for what modes place, so it is no part of a tick. Reads and writes only its arguments; allocates
/// nothing; ends after a fixed number of steps; what it writes is finite, whatever it is given.
/// \param forces_n  [N] one valid split, in the order of `primitives`; at least as many
/// \return [N] length of the part of the total that was not kept: rounding, about 1e-14 of forces and strengths
double least_split(std::span<const Primitive> primitives, const Balance& balance, std::span<Vec3> forces_n) noexcept;

/// The forces of a recorded sub-step as they are shown to people: the least split where it is a balance; where an earlier
/// system's law found none its forces are nobody else's to take. Takes memory at construction; one thread.
class ShownForces {
 public:
  explicit ShownForces(std::size_t most_primitives);
  /// Of each row [N]; valid until the next call. Allocates nothing for as many rows as there is room for.
  std::span<const Vec3> of(std::span<const PlacedPrimitive> placed, const Balance& balance) noexcept;
  /// Whether row `i` of the last call shares its force with others.
  bool is_shared(std::size_t i) const noexcept { return shared_[i]; }

 private:
  std::vector<Primitive> primitives_;
  std::vector<Vec3> forces_n_;
  std::vector<bool> shared_;
};

}  // namespace palpa
