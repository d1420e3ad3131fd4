// The four haptic primitives of the paper (Eqs. 2–7), the corner of several planes, and the set of primitives.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "palpa/solver/vec3.h"

namespace palpa {

enum class PrimitiveKind : std::uint8_t { point, line, plane, directed, corner };

/// State of the proxy at a primitive, from the residual at the unique balance.
enum class PrimitiveState : std::uint8_t {
  stick,  ///< the proxy lies on it; the force keeps the balance, up to the strength
  slip,   ///< the proxy was pulled off it; the force is the full strength (plus drag)
  off,    ///< no residual: the proxy is on the free side of the plane or corner; every directed force
};

/// "point", "line", …; "facet" for a corner, because a primitive of that kind is one facet.
const char* name_of(PrimitiveKind kind) noexcept;
const char* name_of(PrimitiveState state) noexcept;

/// Mode, slot and foot of a primitive. A slot is a small number chosen by the mode, constant from tick to tick: the key of warm
/// starts. A foot is a contact point of the tool; a point tool has the foot 0 alone.
struct PrimitiveId {
  std::uint16_t mode = 0;
  std::uint16_t slot = 0;
  std::uint16_t foot = 0;
  friend constexpr bool operator==(const PrimitiveId&, const PrimitiveId&) = default;
};

/// A primitive, in the hand frame. Plain data.
///
/// With x the proxy, a the position, q the unit direction, s the strength, c the drag and T the time of the sub-step, the force
/// on the proxy is −∂R/∂x of the dissipation
///     R(r) = s|r| + c/(2T) |r|²,      r the residual of the primitive:
///   point     r = a − x                                   (Eq. 3)
///   line      r = (I − q qᵀ)(a − x)                       (Eqs. 4, 5)
///   plane     r = max(0, q·(a − x))                       (Eqs. 6, 7)
///   directed  force s q, at any proxy                     (Eq. 2)
/// At r = 0 the paper's equations jump; there the balance selects the force among the vectors of the primitive's span up to
/// length s (a plane: t q with 0 ≤ t ≤ s), so a proxy can rest *on* a plane. The drag term is viscosity, which the paper's
/// strengths alone cannot express.
///
/// A corner is one strength for several planes: R(r) = s|r| with r the shortest vector from x to the region free of all of
/// them. It is stored as consecutive primitives of kind corner, with a common id and strength, each a facet: a plane through
/// its position whose direction points out of the solid. Its force is Σ tᵢ qᵢ over the facets, tᵢ ≥ 0, not longer than s. A
/// corner of one facet is a plane; no corner has a drag.
///
/// A plane or a corner may be elastic, with a stiffness κ: it deflects by |r|, with a force of κ|r| up to s. Its R is Huber's
/// function of |r| (1964): κ|r|²/2 up to |r| = s/κ, s|r| − s²/2κ beyond. It returns energy, so it must not have a drag.
struct Primitive {
  PrimitiveKind kind = PrimitiveKind::point;
  PrimitiveId id;
  Vec3 position_m;             ///< unused by directed
  Vec3 direction;              ///< [1] unit length; unused by point
  double strength_n = 0.0;     ///< >= 0
  double drag_ns_per_m = 0.0;  ///< >= 0; 0 for directed
  /// Of an elastic plane or corner, > 0; infinity: rigid.
  double stiffness_n_per_m = std::numeric_limits<double>::infinity();

  bool is_elastic() const noexcept { return stiffness_n_per_m < std::numeric_limits<double>::infinity(); }
};

/// Residual r of `primitive` at `x_m` [m]: the vector from the proxy to the primitive within its span; zero for directed and on
/// a plane's free side; a facet counts as a plane. Reads only its arguments.
Vec3 residual(const Primitive& primitive, const Vec3& x_m) noexcept;
/// Residual of `primitives[i]`, or of the whole corner that it is a facet of. \param x_m  [m] the proxy
Vec3 residual(std::span<const Primitive> primitives, std::size_t i, const Vec3& x_m) noexcept;

/// Vector [m] from `x_m` [m] to the footing of the elastic `primitives[i]`, or of the whole corner that it is a facet of
/// (docs/theory.md 8.11). Its length is at most strength / stiffness, where the primitive slips; zero for a rigid primitive.
/// Reads only its arguments.
Vec3 way_to_footing_m(std::span<const Primitive> primitives, std::size_t i, const Vec3& x_m) noexcept;

/// Primitives that act together with `primitives[i]`: all facets of its corner, or itself alone.
std::span<const Primitive> whole_of(std::span<const Primitive> primitives, std::size_t i) noexcept;

/// Level of a field on which a plane lies. `field` is the session's number of the field.
struct HeldLevel {
  std::int32_t field = -1;    ///< -1: the plane stands on no level
  double value = 0.0;         ///< in the field's own unit
  double pressed_to = value;  ///< in the field's own unit: position of the plane, deeper than `value` after yielding
  bool limited = false;       ///< data end nearby: the strength is reduced
  bool goes_along = false;    ///< of a material: the level of the foot, wherever it gets to
  bool any() const noexcept { return field >= 0; }
  /// Ignores `pressed_to`.
  friend bool operator==(const HeldLevel& a, const HeldLevel& b) noexcept { return a.field == b.field && a.value == b.value; }
};

/// Coefficient of a line whose strength is coefficient × the force of a plane of its mode (Coulomb friction).
struct Friction {
  std::int32_t plane = -1;   ///< handle of that plane (`PrimitiveSet::row`); -1: fixed strength
  double coefficient = 0.0;  ///< [1] >= 0
  bool any() const noexcept { return plane >= 0; }
};

/// Limits on primitives, far beyond any hand. Larger values could overflow and make a set unsolvable.
inline constexpr double largest_position_m = 1e6;
inline constexpr double largest_strength_n = 1e9;
inline constexpr double largest_drag_ns_per_m = 1e9;
/// [N/m] Least stiffness of an elastic plane: imperceptibly soft. Less: its compliance could overflow.
inline constexpr double softest_level_n_per_m = 1e-12;

/// [s] Minimum duration of sub-steps for drags; any drag is rigid as a wall there. Less: c/(kT) could overflow.
inline constexpr double shortest_time_s = 1e-15;

/// [1] Largest number of facets of a corner. More: arrays and balances grow; fewer: facets are dropped or refused sooner.
inline constexpr std::size_t most_facets = 8;
/// [1] Least σ of a corner: σ = max over unit vectors e of minᵢ e·qᵢ, for a groove the sine of half its opening. Less:
/// rounding, multiplied by 1/σ, can leave no free region; more: sharp grooves lose a facet.
inline constexpr double narrowest_corner = 1e-3;

/// Reason of a refusal.
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

/// A refused primitive, and the reason.
struct Refused {
  PrimitiveId id;
  Refusal reason;
};

/// Primitives of one sub-step. Fixed capacity: allocates at construction only; never throws. Always solvable: a primitive with
/// a value not finite or negative, a direction not of unit length, or a drag and a nonzero residual at the start is refused,
/// logged with its mode and reason, and counted.
///
/// One thread at a time.
class PrimitiveSet {
 public:
  /// Allocates for `capacity` [1] primitives (>= 1). Throws std::bad_alloc.
  explicit PrimitiveSet(std::size_t capacity = 64);
  PrimitiveSet(const PrimitiveSet&) = delete;
  PrimitiveSet& operator=(const PrimitiveSet&) = delete;

  /// Empties the set for a sub-step that starts at `start_m` [m]; a drag is accepted only with zero residual there (elsewhere
  /// it would be a spring, not a dissipation).
  void clear(const Vec3& start_m) noexcept;
  /// Assigns later primitives to foot number `foot`, which starts at `start_m` [m].
  void begin_foot(std::uint16_t foot, const Vec3& start_m) noexcept {
    foot_ = foot;
    foot_start_m_ = carried_start_m_ = start_m;
  }
  /// Assigns later primitives to mode number `mode`.
  void begin_mode(std::uint16_t mode) noexcept { begin_mode(mode, foot_start_m_); }
  /// Likewise for moving data: a drag is accepted with zero residual at `carried_start_m` [m], the foot's start displaced with
  /// the data.
  void begin_mode(std::uint16_t mode, const Vec3& carried_start_m) noexcept {
    mode_ = mode;
    carried_start_m_ = carried_start_m;
  }

  // Each of these adds a primitive, or refuses it (`refused`). Strengths and drags are >= 0; a slot is used once per mode and
  // foot.

  /// Point primitive at `position_m`: holds the proxy in every direction.
  void point(std::uint16_t slot, const Vec3& position_m, double strength_n, double drag_ns_per_m = 0.0) noexcept;
  /// Line primitive through `position_m` along the unit vector `direction` [1]: holds the proxy across it.
  void line(std::uint16_t slot, const Vec3& position_m, const Vec3& direction, double strength_n,
            double drag_ns_per_m = 0.0) noexcept;
  /// Plane primitive through `position_m`: pushes along the unit vector `normal` [1] while the proxy is behind the plane.
  /// `captured`: the level on which it lies; no sub-step crosses it.
  void plane(std::uint16_t slot, const Vec3& position_m, const Vec3& normal, double strength_n, const HeldLevel& captured = {},
             double drag_ns_per_m = 0.0) noexcept;
  /// Elastic plane with the unit vector `normal` [1], deflected by its force divided by `stiffness_n_per_m`, > 0.
  void elastic_plane(std::uint16_t slot, const Vec3& position_m, const Vec3& normal, double strength_n,
                     double stiffness_n_per_m, const HeldLevel& captured = {}) noexcept;
  /// Directed force of `strength_n` along the unit vector `direction` [1].
  void directed(std::uint16_t slot, const Vec3& direction, double strength_n) noexcept;
  /// Coulomb friction: a line through the plane of slot `plane_slot` (placed before by this mode) at `position_m`, along that
  /// plane's normal, with strength `coefficient` [1] times the plane's force. Its drag does not depend on that force.
  void friction(std::uint16_t slot, std::uint16_t plane_slot, const Vec3& position_m, double coefficient,
                double drag_ns_per_m = 0.0) noexcept;
  /// Adds a facet to the plane or corner of a handle (`row`), in the row behind its last facet, on its level: the plane through
  /// `position_m` with the unit vector `normal` [1] out of the solid. Refuses it and returns false if the set is full, the
  /// corner has `most_facets`, would be narrower than `narrowest_corner`, or has a drag.
  bool add_facet(std::size_t handle, const Vec3& position_m, const Vec3& normal) noexcept;
  /// Adds any primitive, with the current mode and foot in its id. A facet with the slot of the corner before it becomes a
  /// facet of that corner.
  void add(Primitive primitive, const HeldLevel& captured = {}, const Friction& friction = {}) noexcept {
    take(primitive, captured, friction);
  }

  std::size_t size() const noexcept { return size_; }
  bool empty() const noexcept { return size_ == 0; }
  std::size_t capacity() const noexcept { return capacity_; }
  const Primitive& operator[](std::size_t i) const noexcept { return primitives_[i]; }
  /// Row of the primitive with this *handle*: its number in the order of placing. A handle stays valid until `clear`; its row
  /// moves with the facets that `add_facet` puts before it. Such facets have no handle of their own.
  std::size_t row(std::size_t handle) const noexcept { return rows_[handle]; }
  std::span<const Primitive> primitives() const noexcept { return {primitives_.get(), size_}; }
  const HeldLevel& captured(std::size_t i) const noexcept { return captured_[i]; }
  const Friction& friction_of(std::size_t i) const noexcept { return friction_[i]; }
  const Vec3& start_m() const noexcept { return start_m_; }
  /// Whether any primitive has a strength, a drag or friction.
  bool can_pull() const noexcept;

  // For the tick only.

  /// Drops all but the first `count` [1], before any `add_facet`.
  void truncate(std::size_t count) noexcept { size_ = count < size_ ? count : size_; }

  /// Removes the facet in row i, which `add_facet` has added.
  void remove_facet(std::size_t i) noexcept;

  /// Replaces primitive i by another with the same id.
  void replace(std::size_t i, const Primitive& primitive, const HeldLevel& captured) noexcept {
    primitives_[i] = primitive;
    captured_[i] = captured;
  }

  /// Sets the strength of primitive i; for friction lines, computed from the plane's force.
  void set_strength(std::size_t i, double strength_n) noexcept { primitives_[i].strength_n = strength_n; }

  /// Multiplies strength and drag of primitive i by `share` [1], 0…1.
  void fade(std::size_t i, double share) noexcept {
    primitives_[i].strength_n *= share;
    primitives_[i].drag_ns_per_m *= share;
  }

  /// Reduces primitive i to a `share` [1], 0…1, of itself: strength, drag and the stiffness of an elastic plane.
  void bear(std::size_t i, double share) noexcept {
    fade(i, share);
    primitives_[i].stiffness_n_per_m *= share;
  }

  /// Sets the force of a directed primitive [N].
  void set_directed(std::size_t i, const Vec3& force_n) noexcept;

  /// First refusals since `clear`; `dropped()` counts all.
  std::span<const Refused> refused() const noexcept { return {refused_, refused_size_}; }
  int dropped() const noexcept { return dropped_; }

 private:
  PrimitiveId id_of(std::uint16_t slot) const noexcept { return {mode_, slot, foot_}; }
  void take(Primitive& p, const HeldLevel& captured, const Friction& friction) noexcept;
  void refuse(PrimitiveId id, Refusal reason) noexcept;
  std::span<std::size_t> handles() noexcept { return {rows_.get(), size_ - facets_}; }
  bool takes_facet(std::size_t first, std::size_t count, const Vec3& normal) noexcept;

  static constexpr std::size_t max_refused = 16;  // [1] logged with their reason; `dropped` counts all

  std::size_t capacity_;
  std::unique_ptr<Primitive[]> primitives_;
  std::unique_ptr<HeldLevel[]> captured_;
  std::unique_ptr<Friction[]> friction_;
  std::unique_ptr<std::size_t[]> rows_;  // by handle
  std::size_t size_ = 0;
  std::size_t facets_ = 0;  // rows without a handle
  Vec3 start_m_;
  Vec3 foot_start_m_, carried_start_m_;
  std::uint16_t mode_ = 0, foot_ = 0;
  Refused refused_[max_refused] = {};
  std::size_t refused_size_ = 0;
  int dropped_ = 0;
};

}  // namespace palpa
