// What a mode sees: the data at the proxy, in the hand frame.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "palpa/core/primitives.h"
#include "palpa/field/field.h"
#include "palpa/field/timed_field.h"
#include "palpa/mode/parameters.h"

namespace palpa {

/// The fields of a session at one position, each sampled at most once; samples of the last few positions are remembered, since
/// a sub-step comes back to its start and its end. Takes its memory at construction; then never allocates. One thread.
class Samples {
 public:
  /// \param fields  the session's fields, by index; they outlive this
  /// \param map     hand to world
  Samples(std::span<const FieldPtr> fields, const Similarity& map);

  /// Begins to bring what samples of a field at a position of the hand frame [m] read into the caches (Field::prefetch).
  void prefetch(std::int32_t field, const Vec3& hand_m) const noexcept;

  /// Moves to a position of the hand frame [m].
  void move_to(const Vec3& hand_m) noexcept;
  const Vec3& position_m() const noexcept { return places_[here_].hand_m; }
  /// From here on everything is sampled as it is at this moment of the data; `came_from` is the one that the sub-step began at.
  /// Forgets what was sampled where it changes.
  void set_time(DataTime at, DataTime came_from) noexcept;
  void set_time(DataTime at) noexcept { set_time(at, at); }
  DataTime time() const noexcept { return at_; }
  DataTime came_from() const noexcept { return came_from_; }
  /// Any of the fields changes with time.
  bool any_timed() const noexcept { return any_timed_; }

  /// Value, and gradient per hand metre. Outside for an index that is no scalar field.
  const ScalarSample& scalar(std::int32_t field) noexcept;
  /// Value turned into the hand frame, and Jacobian per hand metre. Outside for an index that is no vector field.
  const VectorSample& vector(std::int32_t field) noexcept;
  /// Second derivative of a scalar field [unit per hand metre²]; zero outside.
  const Mat3& hessian(std::int32_t field) noexcept;
  /// The piece of the straight way between two positions of the hand frame [m] that begins at the share `begin` [1]
  /// (Field::stretch). No data as far as the end for an index that is no scalar field. Leaves the position as it is.
  Stretch stretch(std::int32_t field, const Vec3& from_hand_m, const Vec3& to_hand_m, double begin,
                  const Extent& quiet) const noexcept;
  /// Sample spacing of a field [hand m]; 0 for an index that is none.
  double spacing_m(std::int32_t field) const noexcept;
  /// The range of a scalar field's values; 0 to 0 for others.
  const Extent& range(std::int32_t field) const noexcept;
  /// Depth within the field's data [hand m].
  double depth_m(std::int32_t field) noexcept;
  /// Where the data's point of a field that is at `hand_m` [m] at one moment is at another (TimedField::carried). The position
  /// itself for an index that is no field, or a field that stays as it is.
  Carried carried(std::int32_t field, const Vec3& hand_m, DataTime from, DataTime to) const noexcept;
  Vec3 carried_m(std::int32_t field, const Vec3& hand_m, DataTime from, DataTime to) const noexcept {
    return carried(field, hand_m, from, to).position_m;
  }
  const Similarity& hand_to_world() const noexcept { return map_; }

 private:
  static constexpr std::size_t remembered = 4;
  struct Place {
    Vec3 hand_m;
    Vec3 world_m;
    std::uint64_t visit = 0;  // 0: never
  };
  template <class Sample>
  struct Memory;
  struct Slot;
  const Place& place() const noexcept { return places_[here_]; }

  std::span<const FieldPtr> fields_;
  Similarity map_;
  std::array<Place, remembered> places_;
  std::size_t here_ = 0;
  DataTime at_;
  DataTime came_from_;
  bool any_timed_ = false;
  std::uint64_t visits_ = 0;
  std::shared_ptr<Slot[]> slots_;
  std::vector<Extent> ranges_;
};

/// Everything a mode may look at when it places primitives. All of it is in the hand frame: metres,
/// directions turned, derivatives per hand metre; but values keep the data's own unit.
///
/// The primitives of a sub-step pass through `proxy_m`, where the sub-step starts. The data may be
/// sampled elsewhere (a trial point on the way), so a mode asks `here` for them and computes nothing
/// from the proxy's position itself.
class Here {
 public:
  Vec3 proxy_m;                    ///< [m] the proxy at the start of the sub-step, carried with the mode's data to its end
  Vec3 probe_m;                    ///< [m]
  Vec3 at_m;                       ///< [m] where the data are sampled; usually the proxy
  double time_step_s = 0.0;        ///< [s] of the sub-step
  double stiffness_n_per_m = 0.0;  ///< [N/m] k of Eq. 1
  double finest_m = 0.0;           ///< [m] finest sample spacing of the session's fields

  /// The field's sample at `at_m`. `inside` is false for a field without data there.
  const ScalarSample& scalar(const FieldRef& field) const noexcept { return samples_->scalar(field.index); }
  const VectorSample& vector(const FieldRef& field) const noexcept { return samples_->vector(field.index); }
  /// A scalar field's value, in its own unit, at `proxy_m`, where the sub-step starts: the level that a material holds the
  /// proxy on, wherever the data are looked at. That at `at_m` where there are no data.
  double value_at_start(const FieldRef& field) const noexcept;
  /// How a scalar field's gradient changes at `at_m` [unit per hand metre²].
  const Mat3& hessian(const FieldRef& field) const noexcept { return samples_->hessian(field.index); }
  /// The smallest and the largest value of a scalar field, wherever they are.
  const Extent& range(const FieldRef& field) const noexcept { return samples_->range(field.index); }

  /// The strength in newtons at this place: the number or the transfer function, times the mode's
  /// masks, faded towards the edges of the mode's fields so that it never exceeds k/2 × the depth
  /// (a fade steeper than the coupling would kick the hand at its end). Zero where any field
  /// of the mode has no data.
  double newtons(const Strength& strength) const noexcept;
  /// The same for a plane that stands on a level: a transfer function of the level's own field is taken
  /// at the level's value instead of the sample's, at a step as the limit from `side` (the level's solid
  /// side), so that rounding cannot make contact chatter.
  double newtons(const Strength& strength, const Captured& level, TransferFunction::Side side) const noexcept;
  /// A drag [N·s/m] at this place: `drag_ns_per_m` times masks and fade (over 2 N / k of depth).
  double drag(double drag_ns_per_m) const noexcept;
  /// Where the data point of `field` that was at `x_m` [m] when the sub-step began is at its end [m].
  Vec3 carried(const FieldRef& field, const Vec3& x_m) const noexcept;

  /// The length of `gradient` [unit per hand metre] as the steepness that scenes speak of [unit per world metre].
  double steepness_per_m(const Vec3& gradient) const noexcept;
  /// `world`, a vector along the axes of the world in its own unit, as a scene gives it, turned into the hand frame.
  Vec3 turned_to_hand(const Vec3& world) const noexcept { return samples_->hand_to_world().turned_to_hand(world); }

  /// For the tick: the shared samples, and the masks and fields of the mode that looks.
  Here(Samples& samples, std::span<const Mask> masks, std::span<const std::int32_t> fields) noexcept
      : at_m(samples.position_m()), samples_(&samples), masks_(masks), fields_(fields) {}

 private:
  double limited_n(double strength_n) const noexcept;
  double mask() const noexcept;
  double depth_m() const noexcept;

  Samples* samples_;
  std::span<const Mask> masks_;
  std::span<const std::int32_t> fields_;
};

}  // namespace palpa
