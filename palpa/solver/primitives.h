// The four haptic primitives of the paper (Eqs. 2–7), the corner of several planes, and the set that modes place them in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "palpa/solver/vec3.h"

namespace palpa {

enum class PrimitiveKind : std::uint8_t { point, line, plane, directed, corner };

/// What the proxy does at a primitive, read from the residual at the unique balance.
enum class PrimitiveState : std::uint8_t {
  stick,  ///< the proxy lies on it; the force is what balance needs, up to the strength
  slip,   ///< the proxy was pulled off it; the force is the full strength (plus drag)
  off,    ///< a plane or corner that the proxy has left on its free side, and every directed force: no residual
};

/// "point", "line", …; "facet" for a corner, because a primitive of that kind is one facet.
const char* name_of(PrimitiveKind kind) noexcept;
const char* name_of(PrimitiveState state) noexcept;

/// Who placed a primitive. The slot is the mode's own small number and stays the same from tick to
/// tick: it is how forces are handed from one balance to the next.
struct PrimitiveId {
  std::uint16_t mode = 0;
  std::uint16_t slot = 0;
  friend constexpr bool operator==(const PrimitiveId&, const PrimitiveId&) = default;
};

/// One primitive, in the hand frame. Plain data.
///
/// With x the proxy, a the position, q the unit direction, s the strength, c the drag and T the time
/// of the sub-step, the force on the proxy is −∂R/∂x of the dissipation
///     R(r) = s|r| + c/(2T) |r|²,      r the residual of the primitive:
///   point     r = a − x                                   (Eq. 3)
///   line      r = (I − q qᵀ)(a − x)                       (Eqs. 4, 5)
///   plane     r = max(0, q·(a − x))                       (Eqs. 6, 7)
///   directed  force s q, wherever the proxy is            (Eq. 2)
/// At r = 0 the printed equations have a jump; there the force is any vector of the primitive's span
/// not longer than s (a plane: t q with 0 ≤ t ≤ s), and balance picks which: a proxy can rest *on* a
/// plane. The drag term is viscosity, which the paper's strengths alone cannot express.
///
/// A corner is one strength for several planes: R(r) = s|r| with r the shortest way from x to where all of
/// them leave it free. It is a run of consecutive primitives of kind corner with one id and one strength,
/// each of them a facet: a plane through its position whose direction points out of the solid. Its force is
/// Σ tᵢ qᵢ over the facets, tᵢ ≥ 0, not longer than s. A corner of one facet is a plane; none has a drag.
///
/// A plane or a corner may be elastic, with a stiffness κ: it gives way by |r|, with a force of κ|r| up to s, which it never
/// exceeds. Its R is Huber's function of |r| (1964): κ|r|²/2 up to |r| = s/κ, s|r| − s²/2κ beyond. As a spring it gives energy
/// back, so it may have no drag.
struct Primitive {
  PrimitiveKind kind = PrimitiveKind::point;
  PrimitiveId id;
  Vec3 position_m;             ///< unused by directed
  Vec3 direction;              ///< [1] unit length; unused by point
  double strength_n = 0.0;     ///< >= 0
  double drag_ns_per_m = 0.0;  ///< >= 0; 0 for directed
  /// Of an elastic plane or corner, > 0; infinity: rigid, as all others are.
  double stiffness_n_per_m = std::numeric_limits<double>::infinity();

  bool is_elastic() const noexcept { return stiffness_n_per_m < std::numeric_limits<double>::infinity(); }
};

/// The residual r of `primitive` at `x_m` [m]: the vector from the proxy to the primitive within the
/// primitive's span; zero for directed and on a plane's free side; of a facet as of a plane. Reads only its arguments.
Vec3 residual(const Primitive& primitive, const Vec3& x_m) noexcept;
/// The same of `primitives[i]`, or of the whole corner that it is a facet of. \param x_m  [m] the proxy
Vec3 residual(std::span<const Primitive> primitives, std::size_t i, const Vec3& x_m) noexcept;

/// The way [m] from `x_m` [m] to the foot of the elastic `primitives[i]`, or of the whole corner that it is a facet of: the
/// place on the level from which the proxy pressed it in (docs/theory.md 8.11). Not longer than strength over stiffness, beyond
/// which it slips; zero for a rigid one. Reads only its arguments.
Vec3 way_to_foot_m(std::span<const Primitive> primitives, std::size_t i, const Vec3& x_m) noexcept;

/// The primitives that act as one with `primitives[i]`: all facets of its corner, or itself alone.
std::span<const Primitive> whole_of(std::span<const Primitive> primitives, std::size_t i) noexcept;

/// The level of a field that a plane stands on. `field` is the session's number of the field.
struct HeldLevel {
  std::int32_t field = -1;    ///< -1: the plane stands on no level
  double value = 0.0;         ///< in the field's own unit
  double pressed_to = value;  ///< in the field's own unit: where the plane stands, deeper than `value` once it yielded
  bool limited = false;       ///< data end nearby: the strength is less than deeper in the data
  bool any() const noexcept { return field >= 0; }
  /// Whether both are one level, wherever it has been pressed to.
  friend bool operator==(const HeldLevel& a, const HeldLevel& b) noexcept { return a.field == b.field && a.value == b.value; }
};

/// The *foot* of an elastic level that holds the proxy: the place on the level from which the proxy has pressed it in
/// (docs/theory.md 8.11).
struct Foot {
  PrimitiveId id;       ///< of the plane on the level
  Vec3 offset_m;        ///< [hand m] from the proxy to the foot
  double held_j = 0.0;  ///< energy stored in the level
};

/// A line whose strength is coefficient × the force of a plane of the same mode (Coulomb friction).
struct Friction {
  std::int32_t plane = -1;   ///< index in the set of that plane; -1: the strength stands as it is
  double coefficient = 0.0;  ///< [1] >= 0
  bool any() const noexcept { return plane >= 0; }
};

/// Limits on primitives: far beyond any hand, and far from overflow. Larger: a set might overflow and could not be solved.
inline constexpr double largest_position_m = 1e6;
inline constexpr double largest_strength_n = 1e9;
inline constexpr double largest_drag_ns_per_m = 1e9;
/// [N/m] Least stiffness of an elastic plane: far softer than can be felt. Less: its compliance could overflow.
inline constexpr double softest_level_n_per_m = 1e-12;

/// [s] Shorter sub-steps count as this long for drags, which hold like walls in either case. Less: c/(kT) could overflow.
inline constexpr double shortest_time_s = 1e-15;

/// [1] Facets a corner may have. More: arrays and balances grow; fewer: facets are forgotten or refused sooner.
inline constexpr std::size_t most_facets = 8;
/// [1] Least σ of a corner, σ the largest e·qᵢ that a unit vector e has with all its facets: sin of half the opening
/// of a groove. Less: rounding, multiplied by 1/σ, can make a corner empty; more: sharp grooves lose a facet.
inline constexpr double narrowest_corner = 1e-3;

/// Why a primitive was refused.
enum class Refusal : std::uint8_t {
  position_not_finite,
  direction_not_unit,
  strength_not_finite,
  strength_negative,
  drag_not_finite,
  drag_negative,
  drag_away_from_start,
  slot_used_twice,
  stiffness_not_positive,
  elastic_without_plane,
  elastic_with_drag,
  friction_without_plane,
  facet_without_plane,
  facet_with_drag,
  facets_full,
  corner_too_narrow,
  full,
};

/// The refusal as half a sentence: "strength is negative".
const char* sentence_of(Refusal refusal) noexcept;

/// A primitive that was asked for and is not in the set, and why.
struct Refused {
  PrimitiveId id;
  Refusal reason;
};

/// The primitives of one sub-step. Fixed capacity, taken at construction; nothing here allocates
/// after that, and nothing throws. Whatever is in the set is solvable: what is not finite, not of
/// unit length, negative, or has a drag away from the start of the sub-step is refused, remembered
/// with its mode and reason, and counted.
///
/// One thread at a time.
class PrimitiveSet {
 public:
  /// Takes memory for `capacity` primitives (>= 1). Throws std::bad_alloc.
  explicit PrimitiveSet(std::size_t capacity = 64);
  PrimitiveSet(const PrimitiveSet&) = delete;
  PrimitiveSet& operator=(const PrimitiveSet&) = delete;

  /// Empties the set for a sub-step that starts at `start_m` [m]; a drag is accepted only where the
  /// primitive's residual there is zero (elsewhere it would be a spring, not a dissipation).
  void clear(const Vec3& start_m) noexcept;
  /// From here on primitives belong to mode number `mode`.
  void begin_mode(std::uint16_t mode) noexcept { begin_mode(mode, start_m_); }
  /// The same for data that moved in the sub-step: a drag is accepted where the residual is zero at `carried_start_m` [m], the
  /// place to which they carried the start.
  void begin_mode(std::uint16_t mode, const Vec3& carried_start_m) noexcept {
    mode_ = mode;
    carried_start_m_ = carried_start_m;
  }

  // Each of these adds one primitive, or refuses it (`refused`). Strengths and drags are >= 0; a slot is used once per mode.

  /// A point primitive at `position_m`: holds the proxy in every direction.
  void point(std::uint16_t slot, const Vec3& position_m, double strength_n, double drag_ns_per_m = 0.0) noexcept;
  /// A line primitive through `position_m` along the unit vector `direction` [1]: holds the proxy across it.
  void line(std::uint16_t slot, const Vec3& position_m, const Vec3& direction, double strength_n,
            double drag_ns_per_m = 0.0) noexcept;
  /// A plane primitive through `position_m`: pushes along the unit vector `normal` [1] while the proxy is
  /// behind it. `captured` names the level it stands on, so that the tick lets no step cross that level unnoticed.
  void plane(std::uint16_t slot, const Vec3& position_m, const Vec3& normal, double strength_n, HeldLevel captured = {},
             double drag_ns_per_m = 0.0) noexcept;
  /// An elastic plane, with the unit vector `normal` [1]: it gives way by its force over `stiffness_n_per_m`, > 0.
  void elastic_plane(std::uint16_t slot, const Vec3& position_m, const Vec3& normal, double strength_n,
                     double stiffness_n_per_m, HeldLevel captured = {}) noexcept;
  /// A directed force of `strength_n` along the unit vector `direction` [1].
  void directed(std::uint16_t slot, const Vec3& direction, double strength_n) noexcept;
  /// Coulomb friction: a line through the plane of slot `plane_slot` (placed before by the same mode)
  /// at `position_m`, along that plane's normal, as strong as `coefficient` [1] times the plane's force
  /// in the same sub-step. Its drag does not depend on the plane's force.
  void friction(std::uint16_t slot, std::uint16_t plane_slot, const Vec3& position_m, double coefficient,
                double drag_ns_per_m = 0.0) noexcept;
  /// Gives the plane or corner that begins at index `i` one more facet: the plane through `position_m` with the unit
  /// vector `normal` [1] out of the solid, on the corner's level. It is inserted behind the corner's last facet, so that later
  /// primitives move up by one. Returns false, and refuses it, where the set is full, there are `most_facets`, the corner would
  /// be narrower than `narrowest_corner`, or it has a drag.
  bool add_facet(std::size_t i, const Vec3& position_m, const Vec3& normal) noexcept;
  /// Any primitive; the mode of its id is replaced by the current one. A facet with the slot of the corner before it becomes
  /// another facet of that corner.
  void add(Primitive primitive, HeldLevel captured = {}, Friction friction = {}) noexcept;

  std::size_t size() const noexcept { return size_; }
  bool empty() const noexcept { return size_ == 0; }
  std::size_t capacity() const noexcept { return capacity_; }
  const Primitive& operator[](std::size_t i) const noexcept { return primitives_[i]; }
  std::span<const Primitive> primitives() const noexcept { return {primitives_.get(), size_}; }
  const HeldLevel& captured(std::size_t i) const noexcept { return captured_[i]; }
  const Friction& friction_of(std::size_t i) const noexcept { return friction_[i]; }
  const Vec3& start_m() const noexcept { return start_m_; }
  /// Whether any primitive has a strength, a drag or friction: false where all have faded away.
  bool can_pull() const noexcept;

  // The functions below are for the tick only.

  /// Drops all but the first `count`.
  void truncate(std::size_t count) noexcept { size_ = count < size_ ? count : size_; }

  /// Takes the i-th out. It must not be a plane that a friction line depends on.
  void remove(std::size_t i) noexcept;

  /// Puts another primitive with the same id in the place of the i-th.
  void replace(std::size_t i, const Primitive& primitive, HeldLevel captured) noexcept {
    primitives_[i] = primitive;
    captured_[i] = captured;
  }

  /// Sets the strength of the i-th: of a friction line, from its plane's force.
  void set_strength(std::size_t i, double strength_n) noexcept { primitives_[i].strength_n = strength_n; }

  /// Multiplies strength and drag of the i-th by `share` [1], 0…1.
  void fade(std::size_t i, double share) noexcept {
    primitives_[i].strength_n *= share;
    primitives_[i].drag_ns_per_m *= share;
  }

  /// Replaces the force of a directed primitive [N].
  void set_directed(std::size_t i, const Vec3& force_n) noexcept;

  /// What was refused since `clear`: the first few of them; `dropped()` counts all.
  std::span<const Refused> refused() const noexcept { return {refused_, refused_size_}; }
  int dropped() const noexcept { return dropped_; }

 private:
  void refuse(PrimitiveId id, Refusal reason) noexcept;
  bool takes_facet(std::size_t first, std::size_t count, const Vec3& normal) noexcept;

  static constexpr std::size_t max_refused = 16;  // [1] remembered with their reason; `dropped` counts all

  std::size_t capacity_;
  std::unique_ptr<Primitive[]> primitives_;
  std::unique_ptr<HeldLevel[]> captured_;
  std::unique_ptr<Friction[]> friction_;
  std::size_t size_ = 0;
  Vec3 start_m_;
  Vec3 carried_start_m_;
  std::uint16_t mode_ = 0;
  Refused refused_[max_refused] = {};
  std::size_t refused_size_ = 0;
  int dropped_ = 0;
};

}  // namespace palpa
