#include "palpa/mode/mode_context.h"

#include <algorithm>
#include <limits>

#include "palpa/data/field_at_moment.h"
#include "palpa/data/fine_detail.h"
#include "palpa/data/grid_base.h"
#include "palpa/data/octaves.h"
#include "palpa/data/pointwise.h"
#include "palpa/mode/tick_work.h"

namespace palpa {

// Evaluation of a field.
struct Samples::Slot {
  const Field* field = nullptr;
  const TimedField* timed = nullptr;         // same field, if it changes with time
  FieldAtMoment now{};                       // this one at the data's time
  const Field* plain = nullptr;              // the plain field that it is then, if any
  const detail::GridBase* grid = nullptr;    // same field, if it is a grid, or one at that time
  int lattice = -1;                          // lattice of the field or of its source
  int of = -1;                               // slot of its source field; -1: none
  int axis = 0;                              // component or magnitude of the source vector field
  const detail::FineDetail* fine = nullptr;  // set for the fine detail of a field
  bool with_hessian = false;                 // samples compute it: it was requested after one
  Memory<VectorSample> vector{};
  Memory<VectorSample> world_vector{};  // in the world frame
  Memory<Mat3> world_hessian{};
  Memory<double> depth_m{};
  // Motions with the data. A sub-step needs a position's again and again, a tick that of its end, too.
  struct Motion {
    Vec3 hand_m;
    DataTime from, to;  // equal: none
    Carried end;
  };
  std::array<Motion, 2> motions{};
  std::size_t last_motion = 0;
};

// Evaluation shared between fields.
class Samples::Plan {
 public:
  explicit Plan(std::span<const FieldPtr> fields) {
    for (const FieldPtr& field : fields) add(*field);
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const auto* fine = dynamic_cast<const detail::FineDetail*>(fields[i].get());
      const auto taken = detail::pointwise_of(*fields[i]);
      if (fine && fine->grid()) {
        slots_[i].fine = fine;
        take(i, *fine->of());
      } else if (taken) {
        slots_[i].axis = taken->axis;
        take(i, *taken->of);
      }
    }
  }

  Slot& operator[](std::int32_t field) noexcept { return slots_[static_cast<std::size_t>(field)]; }
  // A derived field has the depth of its source. So do grids of equal geometry, but for holes.
  Slot& source_of(std::size_t field) noexcept {
    const int of = slots_[field].of;
    return slots_[of >= 0 ? static_cast<std::size_t>(of) : field];
  }
  // Grids of equal geometry: a position looked up in one holds for all.
  struct Lattice {
    const detail::GridBase* grid;
    Memory<detail::GridBase::Place> places{};
    Memory<double> depth_m{};

    detail::GridBase::Place& at(std::size_t place, const Place& position) noexcept {
      detail::GridBase::Place& at = places.samples[place];
      if (!places.knows(place, position.visit)) grid->locate(position.world_m, at);
      places.visits[place] = position.visit;
      return at;
    }
  };
  Lattice& lattice_of(const Slot& slot) noexcept { return lattices_[static_cast<std::size_t>(slot.lattice)]; }

  // Resolves the fields that change with time.
  void set_time(DataTime at) noexcept {
    for (Slot& slot : slots_) {
      if (!slot.timed) continue;
      slot.now = slot.timed->at_moment(at);
      if (slot.now.plain() == slot.plain) continue;
      slot.plain = slot.now.plain();
      slot.grid = dynamic_cast<const detail::GridBase*>(slot.plain);
      const auto known = lattice_like(slot.grid);
      slot.lattice = static_cast<int>(known - lattices_.begin());
      if (known == lattices_.end()) slot.grid = nullptr;
    }
  }

 private:
  // Makes slot i derive from another field, which is added if it is none of the session's.
  void take(std::size_t i, const Field& from) {
    auto of = std::find_if(slots_.begin(), slots_.end(), [&](const Slot& slot) { return slot.field == &from; });
    if (of == slots_.end()) {
      add(from);
      of = slots_.end() - 1;
    }
    slots_[i].of = static_cast<int>(of - slots_.begin());
    slots_[i].lattice = of->lattice;
  }
  void add(const Field& field) {
    Slot slot{.field = &field, .timed = timed(field)};
    const SeriesView* const series = series_of(field);
    const Field& first = series ? *series->frames.front() : field;
    const auto* const grid = dynamic_cast<const detail::GridBase*>(&first);
    if (!series) slot.grid = grid;
    const auto known = lattice_like(grid);
    slot.lattice = static_cast<int>(known - lattices_.begin());
    if (grid && known == lattices_.end()) lattices_.push_back({grid});
    slots_.push_back(slot);
  }
  std::vector<Lattice>::iterator lattice_like(const detail::GridBase* grid) noexcept {
    return std::find_if(lattices_.begin(), lattices_.end(),
                        [&](const Lattice& lattice) { return grid && lattice.grid->view().geometry == grid->view().geometry; });
  }

  std::vector<Slot> slots_;  // of the fields, then of their sources
  std::vector<Lattice> lattices_;
};

namespace {
// [1] of a field's largest value: rounding of a sum over a stencil's voxels. Between equal voxels a spline's gradient is pure
// rounding. Less: its direction is taken for real; more: true weak gradients are ignored.
constexpr double sum_rounding = 64.0 * std::numeric_limits<double>::epsilon();
}  // namespace

Samples::Samples(std::span<const FieldPtr> fields, const Similarity& map)
    : fields_(fields), map_(map), scalars_(fields.size()), plan_(new Plan(fields)) {
  for (const FieldPtr& field : fields) {
    ranges_.push_back(field->components() == 1 ? field->value_ranges().front() : ValueRange{});
    const double spacing_m = map_.length_to_hand(field->spacing_m());
    spacings_m_.push_back(std::max(spacing_m, min_spacing_m));
    const double largest = std::max(std::abs(ranges_.back().min), std::abs(ranges_.back().max));
    const SeriesView* const series = series_of(*field);
    const Field& first = series ? *series->frames.front() : *field;
    const bool of_voxels = dynamic_cast<const detail::GridBase*>(&first) || dynamic_cast<const Octaves*>(&first);
    least_slopes_.push_back(of_voxels && std::isfinite(largest) ? sum_rounding * largest / spacing_m : 0.0);
    roundings_.push_back(std::isfinite(largest) ? 2.0 * sum_rounding * largest : 0.0);
    works_.push_back(tick_work::of_sample(field->values_per_sample()));
    any_timed_ = any_timed_ || timed(*field);
  }
  moments_.resize(fields.size());
  depths_.resize(fields.size());
  find_moments();
}

// Resolves the fields that change with time, and the work of their samples.
void Samples::find_moments() noexcept {
  if (any_timed_) plan_->set_time(at_);
  work_beyond_ = 0;
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const Slot& slot = (*plan_)[static_cast<std::int32_t>(i)];
    Slot& source = plan_->source_of(i);
    depths_[i] = source.grid && !source.grid->has_holes() ? &plan_->lattice_of(source).depth_m : &source.depth_m;
    if (slot.timed) {
      works_[i] = tick_work::of_sample(slot.now.values_per_sample());
      ++moments_[i];
    }
    work_beyond_ += works_[i] - 1;
  }
}

// A new place replaces the least recently used one.
std::size_t Samples::find_place(const Vec3& hand_m) noexcept {
  for (std::size_t i = 0; i < remembered; ++i) {
    if (places_[i].hand_m != hand_m || places_[i].visit == 0) continue;
    places_[i].asked = ++asked_;
    return last_ = i;
  }
  last_ = 0;
  for (std::size_t i = 1; i < remembered; ++i) {
    if (places_[i].asked < places_[last_].asked) last_ = i;
  }
  places_[last_] = {hand_m, map_.to_world(hand_m), ++visits_, ++asked_};
  return last_;
}

void Samples::set_time(DataTime at, DataTime came_from) noexcept {
  came_from_ = came_from;
  if (at == at_) return;
  at_ = at;
  if (!any_timed_) return;
  find_moments();
  for (Place& place : places_) {
    if (place.visit > 0) place.visit = ++visits_;
  }
}

const ScalarSample& Samples::take_scalar(std::size_t field, std::size_t place) noexcept {
  return keep_scalar(field, place, scalar_in_world((*plan_)[static_cast<std::int32_t>(field)], place));
}

// A derivative per hand metre can overflow where its world counterpart did not.
const ScalarSample& Samples::keep_scalar(std::size_t field, std::size_t place, const ScalarSample& world) noexcept {
  ScalarSample& sample = scalars_[field].keep(place, places_[place].visit, world);
  sample.gradient = map_.gradient_to_hand(sample.gradient);
  if (is_within(sample.gradient, least_slopes_[field])) sample.gradient = {};
  if (!is_finite(sample.gradient)) sample = {};
  return sample;
}

ScalarSample Samples::scalar_in_world(Slot& slot, std::size_t place) noexcept {
  if (slot.fine) return slot.fine->scalar_in(plan_->lattice_of(slot).at(place, places_[place]));
  if (slot.of >= 0) return detail::taken_of(vector_in_world((*plan_)[slot.of], place), slot.axis);
  if (!slot.grid) {
    const Vec3& world_m = places_[place].world_m;
    return slot.timed ? slot.now.scalar(world_m) : slot.field->scalar(world_m);
  }
  detail::GridBase::Place& at = plan_->lattice_of(slot).at(place, places_[place]);
  return slot.with_hessian ? slot.grid->scalar_in(at, slot.world_hessian.keep(place, places_[place].visit, {}))
                           : slot.grid->scalar_in(at);
}

const VectorSample& Samples::vector_in_world(Slot& slot, std::size_t place) noexcept {
  const std::uint64_t visit = places_[place].visit;
  if (slot.world_vector.knows(place, visit)) return slot.world_vector.samples[place];
  const Vec3& world_m = places_[place].world_m;
  return slot.world_vector.keep(place, visit,
                                slot.grid    ? slot.grid->vector_in(plan_->lattice_of(slot).at(place, places_[place]))
                                : slot.timed ? slot.now.vector(world_m)
                                             : slot.field->vector(world_m));
}

const VectorSample& Samples::vector(std::int32_t field, const Vec3& hand_m) noexcept {
  static constexpr VectorSample outside;
  if (!is_field(field)) return outside;
  Slot& slot = (*plan_)[field];
  const std::size_t place = place_at(hand_m);
  const std::uint64_t visit = places_[place].visit;
  if (slot.vector.knows(place, visit)) return slot.vector.samples[place];
  VectorSample sample = vector_in_world(slot, place);
  sample.value = map_.direction_to_hand(sample.value);
  sample.jacobian = map_.jacobian_to_hand(sample.jacobian);
  return slot.vector.keep(place, visit, is_finite(sample.value) && is_finite(sample.jacobian) ? sample : VectorSample{});
}

Mat3 Samples::hessian(std::int32_t field, const Vec3& hand_m) noexcept {
  if (!is_field(field)) return {};
  Slot& slot = (*plan_)[field];
  const std::size_t place = place_at(hand_m);
  const std::uint64_t visit = places_[place].visit;
  if (!slot.world_hessian.knows(place, visit)) {
    const Vec3& world_m = places_[place].world_m;
    if (slot.grid && slot.of < 0 && slot.grid->has_curvature()) {
      slot.with_hessian = slot.with_hessian || scalars_[static_cast<std::size_t>(field)].knows(place, visit);
      Mat3& kept = slot.world_hessian.keep(place, visit, {});
      keep_scalar(static_cast<std::size_t>(field), place,
                  slot.grid->scalar_in(plan_->lattice_of(slot).at(place, places_[place]), kept));
    } else {
      slot.world_hessian.keep(place, visit, slot.timed ? slot.now.hessian(world_m) : slot.field->hessian(world_m));
    }
  }
  // The gradient per hand metre is the rotated gradient times the scale; its derivative has another such factor.
  const Mat3 hessian = map_.scale * map_.jacobian_to_hand(slot.world_hessian.samples[place]);
  return is_finite(hessian) ? hessian : Mat3{};
}

PolynomialPiece Samples::piece_along(std::int32_t field, const Vec3& from_hand_m, const Vec3& to_hand_m, double begin,
                                     const ValueRange& quiet) const noexcept {
  if (!is_field(field)) return {};
  const Vec3 from_m = map_.to_world(from_hand_m), to_m = map_.to_world(to_hand_m);
  const Slot& slot = (*plan_)[field];
  return slot.timed ? slot.now.piece_along(from_m, to_m, begin, quiet) : slot.field->piece_along(from_m, to_m, begin, quiet);
}

double Samples::local_spacing_m(std::int32_t field, const Vec3& world_m) const noexcept {
  if (!is_field(field)) return 0.0;
  const Slot& slot = (*plan_)[field];
  const double spacing_m = slot.timed ? slot.now.local_spacing_m(world_m) : slot.field->local_spacing_m(world_m);
  return std::max(map_.length_to_hand(spacing_m), min_spacing_m);
}

LipschitzBound Samples::lipschitz_bound(std::int32_t field, const Vec3& hand_m) noexcept {
  if (!is_field(field)) return {};
  const Slot& slot = (*plan_)[field];
  const std::size_t place = place_at(hand_m);
  const Vec3& world_m = places_[place].world_m;
  if (slot.fine) return {};
  // No magnitude changes faster than its vector.
  const Slot& by = slot.of >= 0 ? (*plan_)[slot.of] : slot;
  const bool is_component = slot.of >= 0 && slot.axis != detail::Pointwise::magnitude;
  const LipschitzBound found =
      by.grid      ? by.grid->certificate_in(plan_->lattice_of(by).at(place, places_[place]), is_component ? slot.axis : 0,
                                        is_component ? 1 : by.grid->components())
           : slot.timed ? slot.now.lipschitz_bound(world_m)
                   : slot.field->lipschitz_bound(world_m);
  const double shift_m = 16.0 * std::numeric_limits<double>::epsilon() * (norm(world_m) + norm(map_.translation_m));
  return found.scaled(1.0 / map_.scale, shift_m);
}

const ValueRange& Samples::range(std::int32_t field) const noexcept {
  static constexpr ValueRange none;
  if (field < 0 || static_cast<std::size_t>(field) >= ranges_.size()) return none;
  return ranges_[static_cast<std::size_t>(field)];
}

double Samples::take_depth(std::size_t field, std::size_t place) noexcept {
  Slot& slot = plan_->source_of(field);
  const Vec3& world_m = places_[place].world_m;
  const double depth = slot.grid    ? slot.grid->depth_in(plan_->lattice_of(slot).at(place, places_[place]))
                       : slot.timed ? slot.now.depth_m(world_m)
                                    : slot.field->depth_m(world_m);
  return depths_[field]->keep(place, places_[place].visit, map_.length_to_hand(depth));
}

Carried Samples::carried(std::int32_t field, const Vec3& hand_m, DataTime from, DataTime to) noexcept {
  if (!is_field(field)) return {hand_m};
  Slot& slot = (*plan_)[field];
  if (!slot.timed || from == to) return {hand_m};
  for (const Slot::Motion& known : slot.motions) {
    if (known.hand_m == hand_m && known.from == from && known.to == to) return known.end;
  }
  const Carried world = slot.timed->carried(map_.to_world(hand_m), from, to);
  const Vec3 moved_m = map_.to_hand(world.position_m);
  slot.last_motion = 1 - slot.last_motion;
  Slot::Motion& motion = slot.motions[slot.last_motion];
  motion = {hand_m, from, to, world.known && is_finite(moved_m) ? Carried{moved_m} : Carried{hand_m, false}};
  return motion.end;
}

double ModeContext::value_at_start(const FieldRef& field) const noexcept {
  const ScalarSample& start = samples_->scalar(number_of(field), proxy_m);
  return start.inside ? start.value : scalar(field).value;
}

double ModeContext::mask() const noexcept {
  double factor = 1.0;
  for (const Mask& mask : masks_) {
    const ScalarSample& sample = scalar(mask.of);
    factor *= sample.inside ? mask.curve.at(sample.value) : 0.0;
  }
  return factor;
}

double ModeContext::depth_m() const noexcept {
  double least_m = std::numeric_limits<double>::infinity();
  for (const std::int32_t field : fields_) least_m = std::min(least_m, samples_->depth_m(field, at_m));
  return least_m;
}

// A negative strength or NaN is passed on: PrimitiveSet refuses it by name.
double ModeContext::limited_n(double strength_n) const noexcept {
  if (!(strength_n > 0.0)) return strength_n;
  const double depth = depth_m();
  if (!(depth > 0.0)) return 0.0;
  return std::min(strength_n * mask(), 0.5 * stiffness_n_per_m * depth);
}

// Share of a level's strength near a border, 0…1 [1]. The filter's use of missing voxels reaches two spacings. A level fades
// over these, or over up to four if it would end with a jerk: friction pulls the proxy out as the level weakens, which turns a
// slope a of the strength into a/(1 − μa/k) under the hand.
double ModeContext::border_share(double strength_n) const noexcept {
  constexpr double reach = 2.0, furthest = 4.0;             // [1] spacings. Less: ends with a jerk; more: weak in intact data
  const double steepest_n_per_m = 1.5 * stiffness_n_per_m;  // Less: a wide rim; more: a jerk
  double share = 1.0;
  for (const std::int32_t field : fields_) {
    const double spacing_m = samples_->local_spacing_m(field, samples_->hand_to_world().to_world(at_m));
    const double over_m = std::clamp(strength_n / steepest_n_per_m, reach * spacing_m, furthest * spacing_m);
    share = std::min(share, samples_->depth_m(field, at_m) / over_m);
  }
  return share;
}

// The border nearest to the proxy, or to a footing on the mode's elastic levels, counts: a footing that left the data would
// take its level with it.
LevelStrength ModeContext::bordered(double strength_n) const noexcept {
  if (!(strength_n > 0.0)) return {strength_n};
  const double whole_n = strength_n * mask(), felt_n = std::min(whole_n, most_n);
  const auto left_at = [&](const ModeContext& there) -> LevelStrength {
    const double gentle_n = std::max(0.0, 0.5 * stiffness_n_per_m * there.depth_m());
    if (gentle_n >= felt_n) return {whole_n};
    const double share = std::max(0.0, there.border_share(felt_n));
    if (share >= 1.0) return {whole_n};
    return {std::max(gentle_n, share * felt_n), true};
  };
  LevelStrength least = left_at(*this);
  for (const Contact& contact : contacts) {
    if (contact.offset_m == Vec3{}) continue;
    ModeContext at_footing = *this;
    at_footing.at_m += contact.offset_m;
    const LevelStrength left = left_at(at_footing);
    least = {std::min(least.newtons, left.newtons), least.limited || left.limited};
  }
  return least;
}

double ModeContext::newtons(const Strength& strength) const noexcept {
  if (strength.is_constant()) return limited_n(strength.constant_n);
  const ScalarSample& sample = scalar(strength.of);
  return sample.inside ? limited_n(strength.curve.at(sample.value, TransferFunction::Side::above)) : 0.0;
}

LevelStrength ModeContext::newtons(const Strength& strength, const HeldLevel& level,
                                   TransferFunction::Side side) const noexcept {
  if (!level.any()) return {newtons(strength)};
  if (strength.is_constant()) return bordered(strength.constant_n);
  if (level.field == number_of(strength.of)) return bordered(strength.curve.at(level.value, side));
  const ScalarSample& sample = scalar(strength.of);
  return sample.inside ? bordered(strength.curve.at(sample.value, side)) : LevelStrength{};
}

double ModeContext::drag(double drag_ns_per_m) const noexcept {
  if (!(drag_ns_per_m > 0.0)) return drag_ns_per_m;
  // A drag fades in like a strength of 1 N, over 2 N / k from the edge. Less: a sudden onset; more: a wide rim.
  constexpr double fade_n = 1.0;
  const double depth = depth_m();
  if (!(depth > 0.0)) return 0.0;
  return drag_ns_per_m * mask() * std::min(1.0, 0.5 * stiffness_n_per_m * depth / fade_n);
}

double ModeContext::steepness_per_m(const Vec3& gradient) const noexcept {
  return norm(gradient) / samples_->hand_to_world().scale;
}

Vec3 ModeContext::carried(const FieldRef& field, const Vec3& x_m) const noexcept {
  return samples_->carried_m(number_of(field), x_m, samples_->came_from(), samples_->time());
}

}  // namespace palpa
