// Data at the proxy in the hand frame, for modes.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/data/timed_field.h"
#include "palpa/mode/parameters.h"
#include "palpa/solver/primitives.h"
#include "palpa/solver/similarity.h"

namespace palpa {

/// Samples of a session's fields at positions in the hand frame. Caches the last few positions, since a tick repeats them.
/// Allocates at construction only. One thread.
///
/// Evaluation is shared, as planned at construction: a position is looked up once in all grids of equal geometry, with its
/// spline weights, also for their `FineDetail`; a magnitude or a component reuses the sample of its vector; and a second
/// derivative is computed with value and gradient, from the same voxels. A field of which it has been requested after a sample
/// computes it with every sample.
class Samples {
 public:
  /// \param fields  the session's fields, by index; must outlive this object
  /// \param map     hand to world
  Samples(std::span<const FieldPtr> fields, const Similarity& map);

  /// Sets the data's time for later samples; `came_from`: its time at the sub-step's start. Clears the cache on a change.
  void set_time(DataTime at, DataTime came_from) noexcept;
  void set_time(DataTime at) noexcept { set_time(at, at); }
  DataTime time() const noexcept { return at_; }
  DataTime came_from() const noexcept { return came_from_; }
  /// Whether any field changes with time.
  bool any_timed() const noexcept { return any_timed_; }
  /// Number of a field's moment so far, for caches: another one whenever a field that changes with time is set to another
  /// moment; always 0 for other fields. The index must be valid.
  std::uint64_t moment_of(std::int32_t field) const noexcept { return moments_[static_cast<std::size_t>(field)]; }

  /// Value at a position in the hand frame [m], and gradient per hand metre. Not `inside` if the index is no scalar field.
  /// References returned here and below are valid until `remembered` other positions have been sampled.
  const ScalarSample& scalar(std::int32_t field, const Vec3& hand_m) noexcept {
    static constexpr ScalarSample outside;
    if (!is_field(field)) return outside;
    const auto index = static_cast<std::size_t>(field);
    const std::size_t place = place_at(hand_m);
    const Memory<ScalarSample>& known = scalars_[index];
    return known.knows(place, places_[place].visit) ? known.samples[place] : take_scalar(index, place);
  }
  /// Value rotated into the hand frame, and Jacobian per hand metre. Not `inside` if the index is no vector field.
  const VectorSample& vector(std::int32_t field, const Vec3& hand_m) noexcept;
  /// Second derivative of a scalar field [unit per hand metre²]; zero outside.
  Mat3 hessian(std::int32_t field, const Vec3& hand_m) noexcept;
  /// Depth within the field's data [hand m].
  double depth_m(std::int32_t field, const Vec3& hand_m) noexcept {
    if (!is_field(field)) return 0.0;
    const auto index = static_cast<std::size_t>(field);
    const std::size_t place = place_at(hand_m);
    const Memory<double>& known = *depths_[index];
    return known.knows(place, places_[place].visit) ? known.samples[place] : take_depth(index, place);
  }
  /// Piece of the straight path between two positions in the hand frame [m] from the share `begin` [1] on (Field::piece_along).
  /// One piece without data if the index is no scalar field.
  PolynomialPiece piece_along(std::int32_t field, const Vec3& from_hand_m, const Vec3& to_hand_m, double begin,
                              const ValueRange& quiet) const noexcept;
  /// Lipschitz bound of a field around a position in the hand frame [m] (Field::lipschitz_bound), per hand metre.
  LipschitzBound lipschitz_bound(std::int32_t field, const Vec3& hand_m) noexcept;
  /// Sample spacing of a field [hand m], at least `min_spacing_m`; 0 for an invalid index.
  double spacing_m(std::int32_t field) const noexcept {
    return is_field(field) ? spacings_m_[static_cast<std::size_t>(field)] : 0.0;
  }
  /// Local sample spacing [hand m] at a position in the world [m] (Field::local_spacing_m).
  double local_spacing_m(std::int32_t field, const Vec3& world_m) const noexcept;
  /// Range of a scalar field's values; 0 to 0 for others.
  const ValueRange& range(std::int32_t field) const noexcept;
  /// Largest difference of two samples of a scalar field by rounding alone, in the field's own unit; 0 for others.
  double rounding(std::int32_t field) const noexcept {
    return is_field(field) ? roundings_[static_cast<std::size_t>(field)] : 0.0;
  }
  /// Position at time `to` of a field's data point that is at `hand_m` [m] at time `from` (TimedField::carried). Unchanged for
  /// an invalid index or a static field.
  Carried carried(std::int32_t field, const Vec3& hand_m, DataTime from, DataTime to) noexcept;
  Vec3 carried_m(std::int32_t field, const Vec3& hand_m, DataTime from, DataTime to) noexcept {
    return carried(field, hand_m, from, to).position_m;
  }
  /// Work of a sample [units of tick_work.h]; 1 for an invalid index.
  int work_of_look(std::int32_t field) const noexcept { return is_field(field) ? works_[static_cast<std::size_t>(field)] : 1; }
  /// Work of `modes` [1] modes that sample all fields at one position: 1 unit a mode; extra cost of a field once (cached).
  int work_of_modes(std::size_t modes) const noexcept { return static_cast<int>(modes) + work_beyond_; }
  const Similarity& hand_to_world() const noexcept { return map_; }

  /// [m] Lower bound of spacings. Smaller: budget exceeded by a slow hand in thin cells; larger: details coarser than an
  /// encoder step are skipped.
  static constexpr double min_spacing_m = 2e-5;
  static constexpr std::size_t remembered = 4;  ///< positions; more: longer searches and more memory, fewer: repeated sampling

 private:
  struct Place {
    Vec3 hand_m;
    Vec3 world_m;
    std::uint64_t visit = 0;  // 0: never
    std::uint64_t asked = 0;  // last use
  };
  // Cached samples at the cached positions.
  template <class Sample>
  struct Memory {
    std::array<Sample, remembered> samples{};
    std::array<std::uint64_t, remembered> visits{};

    bool knows(std::size_t place, std::uint64_t visit) const noexcept { return visits[place] == visit; }
    Sample& keep(std::size_t place, std::uint64_t visit, const Sample& sample) noexcept {
      visits[place] = visit;
      return samples[place] = sample;
    }
  };
  struct Slot;
  bool is_field(std::int32_t field) const noexcept { return static_cast<std::size_t>(field) < fields_.size() && field >= 0; }
  std::size_t place_at(const Vec3& hand_m) noexcept {
    return places_[last_].hand_m == hand_m && places_[last_].visit > 0 ? last_ : find_place(hand_m);
  }
  std::size_t find_place(const Vec3& hand_m) noexcept;
  const ScalarSample& take_scalar(std::size_t field, std::size_t place) noexcept;
  const ScalarSample& keep_scalar(std::size_t field, std::size_t place, const ScalarSample& world) noexcept;
  double take_depth(std::size_t field, std::size_t place) noexcept;
  ScalarSample scalar_in_world(Slot& slot, std::size_t place) noexcept;
  const VectorSample& vector_in_world(Slot& slot, std::size_t place) noexcept;
  void find_moments() noexcept;

  std::span<const FieldPtr> fields_;
  Similarity map_;
  std::array<Place, remembered> places_;
  std::size_t last_ = 0;  // place last used
  DataTime at_;
  DataTime came_from_;
  bool any_timed_ = false;
  std::uint64_t visits_ = 0;
  std::uint64_t asked_ = 0;
  std::vector<Memory<ScalarSample>> scalars_;  // by field
  std::vector<Memory<double>*> depths_;        // [hand m] by field: those of its source, or of all grids of its geometry
  std::vector<double> spacings_m_;             // [hand m]
  std::vector<double> least_slopes_;           // [unit per hand metre] gradients up to this are rounding
  std::vector<ValueRange> ranges_;
  std::vector<double> roundings_;
  std::vector<std::uint64_t> moments_;  // changes of each field's moment
  std::vector<int> works_;              // [units] of a sample
  int work_beyond_ = 0;                 // [units] of a sample of each field, beyond one
  class Plan;
  std::shared_ptr<Plan> plan_;
};

/// Contact with a primitive of the last accepted sub-step.
struct Contact {
  /// Of the level: free → held → yielding → free. A level that yields stays so until it is free.
  enum class Phase : std::uint8_t { free, held, yielding };

  PrimitiveId id;
  PrimitiveState state = PrimitiveState::off;
  Phase phase = Phase::free;
  bool yields = false;  ///< strength reduced (data end nearby, or its level jumped): a slip is no break-through
  HeldLevel level;      ///< level of its placement; none if it stands on no level
  /// [hand m] From the proxy to its *footing*, the point of an elastic level from which the proxy has pressed it in
  /// (docs/theory.md 8.11); zero if it has not.
  Vec3 offset_m;
  double held_j = 0.0;  ///< energy stored in the level
};

/// Strength of a plane on a level.
struct LevelStrength {
  double newtons = 0.0;
  bool limited = false;  ///< reduced near the border of the data: the level yields, without a break-through
};

/// Inputs of a mode's `place`, in the hand frame: metres, rotated directions, derivatives per hand metre; values keep the
/// data's own unit.
///
/// The primitives of a sub-step pass through `proxy_m`, its start. The data may be sampled elsewhere (a trial point of the
/// path), so a mode samples by the functions below and derives no sample position from `proxy_m`.
class ModeContext {
 public:
  Vec3 proxy_m;                    ///< [m] proxy at the start of the sub-step, displaced with the mode's data
  Vec3 probe_m;                    ///< [m]
  Vec3 at_m;                       ///< [m] sample position; usually the proxy
  double time_step_s = 0.0;        ///< [s] of the sub-step
  double stiffness_n_per_m = 0.0;  ///< [N/m] k of Eq. 1
  double finest_m = 0.0;           ///< [m] finest sample spacing of the session's fields near the proxy
  /// [N] force limit: near a border a stronger level fades from this value
  double most_n = std::numeric_limits<double>::infinity();
  std::span<const Contact> contacts;  ///< of the mode, in the last accepted sub-step

  /// Session's number of a field, as in HeldLevel and Crossing.
  std::int32_t number_of(const FieldRef& field) const noexcept { return detail::field_numbers(field).field; }
  /// Sample at `at_m`. `inside` is false without data there.
  ScalarSample scalar(const FieldRef& field) const noexcept { return scalar(field, at_m); }
  VectorSample vector(const FieldRef& field) const noexcept { return samples_->vector(number_of(field), at_m); }
  /// At a position in the hand frame [m].
  ScalarSample scalar(const FieldRef& field, const Vec3& x_m) const noexcept { return samples_->scalar(number_of(field), x_m); }
  /// Likewise of the field's companion (`companion_param`).
  ScalarSample companion_scalar(const FieldRef& field, const Vec3& x_m) const noexcept {
    return samples_->scalar(detail::field_numbers(field).companion, x_m);
  }
  VectorSample companion_vector(const FieldRef& field) const noexcept {
    return samples_->vector(detail::field_numbers(field).companion, at_m);
  }
  /// Vector from the proxy to the footing of the elastic plane in `slot` [m] (`way_to_footing_m`); zero if it is not deflected.
  Vec3 footing_offset_m(std::uint16_t slot) const noexcept {
    for (const Contact& contact : contacts) {
      if (contact.id.slot == slot) return contact.offset_m;
    }
    return {};
  }
  /// Sample position for the level of the plane in `slot` [m]: its footing, or `at_m`.
  Vec3 footing_m(std::uint16_t slot) const noexcept { return at_m + footing_offset_m(slot); }
  /// Value of a scalar field, in its own unit, at `proxy_m`, where the sub-step starts: the level on which a material holds the
  /// proxy. Without data there, the value at `at_m`.
  double value_at_start(const FieldRef& field) const noexcept;
  /// Second derivative of a scalar field at `at_m` [unit per hand metre²]. Request it before the field's sample.
  Mat3 hessian(const FieldRef& field) const noexcept { return samples_->hessian(number_of(field), at_m); }
  /// Range of a scalar field's values.
  const ValueRange& range(const FieldRef& field) const noexcept { return samples_->range(number_of(field)); }

  /// Strength in newtons at this position: the number or the transfer function, times the mode's masks, faded towards the edges
  /// of its fields to at most k/2 × the depth (a fade steeper than the coupling would kick the hand at its end). Zero where any
  /// field of the mode has no data.
  double newtons(const Strength& strength) const noexcept;
  /// Strength of a plane on a level. A transfer function of the level's own field is evaluated at the level's value, at a step
  /// of the function as the limit from `side` (the level's solid side), so that rounding cannot make contact chatter. Fades
  /// near the border of the data (`border_share`), where the level yields.
  LevelStrength newtons(const Strength& strength, const HeldLevel& level, TransferFunction::Side side) const noexcept;
  /// Drag [N·s/m] at this position: `drag_ns_per_m` times masks, faded over a depth of 2 N / k.
  double drag(double drag_ns_per_m) const noexcept;
  /// Position [m] at the end of the sub-step of the data point that was at `x_m` [m] at its start.
  Vec3 carried(const FieldRef& field, const Vec3& x_m) const noexcept;

  /// Length of `gradient` [unit per hand metre] as the steepness used in scenes [unit per world metre].
  double steepness_per_m(const Vec3& gradient) const noexcept;
  /// Rotates `world`, a vector in the world in its own unit, into the hand frame.
  Vec3 direction_to_hand(const Vec3& world) const noexcept { return samples_->hand_to_world().direction_to_hand(world); }

  /// For the tick: shared samples, and masks and fields of a mode that samples at `seen_m` [m].
  ModeContext(Samples& samples, const Vec3& seen_m, std::span<const Mask> masks, std::span<const std::int32_t> fields) noexcept
      : at_m(seen_m), samples_(&samples), masks_(masks), fields_(fields) {}

 private:
  double limited_n(double strength_n) const noexcept;
  LevelStrength bordered(double strength_n) const noexcept;
  double border_share(double strength_n) const noexcept;
  double mask() const noexcept;
  double depth_m() const noexcept;

  Samples* samples_;
  std::span<const Mask> masks_;
  std::span<const std::int32_t> fields_;
};

}  // namespace palpa
