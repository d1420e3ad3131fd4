#include "palpa/mode/here.h"

#include <limits>

namespace palpa {

// The samples of one kind at the places that are remembered.
template <class Sample>
struct Samples::Memory {
  std::array<Sample, remembered> samples{};
  std::array<std::uint64_t, remembered> visits{};

  template <class Take>
  const Sample& at(std::size_t place, std::uint64_t visit, Take&& take) {
    if (visits[place] != visit) {
      visits[place] = visit;
      samples[place] = take();
    }
    return samples[place];
  }
};

struct Samples::Slot {
  const Field* field = nullptr;
  const TimedField* timed = nullptr;  // the same one, if it changes with time
  Memory<ScalarSample> scalar;
  Memory<VectorSample> vector;
  Memory<Mat3> hessian;
  Memory<double> depth_m;
};

Samples::Samples(std::span<const FieldPtr> fields, const Similarity& map)
    : fields_(fields), map_(map), slots_(new Slot[fields.size() + 1]) {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    ranges_.push_back(fields[i]->components() == 1 ? fields[i]->extents().front() : Extent{});
    slots_[i].field = fields[i].get();
    slots_[i].timed = timed(*fields[i]);
    any_timed_ = any_timed_ || slots_[i].timed;
  }
}

void Samples::prefetch(std::int32_t field, const Vec3& hand_m) const noexcept {
  if (field < 0 || static_cast<std::size_t>(field) >= fields_.size()) return;
  slots_[static_cast<std::size_t>(field)].field->prefetch(map_.to_world(hand_m));
}

void Samples::move_to(const Vec3& hand_m) noexcept {
  for (std::size_t i = 0; i < remembered; ++i) {
    if (places_[i].visit > 0 && places_[i].hand_m == hand_m) {
      here_ = i;
      return;
    }
  }
  here_ = (here_ + 1) % remembered;
  places_[here_] = {hand_m, map_.to_world(hand_m), ++visits_};
}

void Samples::set_time(DataTime at, DataTime came_from) noexcept {
  came_from_ = came_from;
  if (at == at_) return;
  at_ = at;
  if (!any_timed_) return;
  for (Place& place : places_) {
    if (place.visit > 0) place.visit = ++visits_;
  }
}

const ScalarSample& Samples::scalar(std::int32_t field) noexcept {
  static constexpr ScalarSample outside;
  if (field < 0 || static_cast<std::size_t>(field) >= fields_.size()) return outside;
  Slot& slot = slots_[static_cast<std::size_t>(field)];
  return slot.scalar.at(here_, place().visit, [&] {
    const Vec3& world_m = place().world_m;
    ScalarSample sample = slot.timed ? slot.timed->scalar_at(world_m, at_) : slot.field->scalar(world_m);
    sample.gradient = map_.gradient_to_hand(sample.gradient);
    // A gradient per hand metre can overflow where the one per world metre did not.
    return is_finite(sample.gradient) ? sample : ScalarSample{};
  });
}

const VectorSample& Samples::vector(std::int32_t field) noexcept {
  static constexpr VectorSample outside;
  if (field < 0 || static_cast<std::size_t>(field) >= fields_.size()) return outside;
  Slot& slot = slots_[static_cast<std::size_t>(field)];
  return slot.vector.at(here_, place().visit, [&] {
    const Vec3& world_m = place().world_m;
    VectorSample sample = slot.timed ? slot.timed->vector_at(world_m, at_) : slot.field->vector(world_m);
    sample.value = map_.turned_to_hand(sample.value);
    sample.jacobian = map_.jacobian_to_hand(sample.jacobian);
    return is_finite(sample.value) && is_finite(sample.jacobian) ? sample : VectorSample{};
  });
}

const Mat3& Samples::hessian(std::int32_t field) noexcept {
  static constexpr Mat3 none{};
  if (field < 0 || static_cast<std::size_t>(field) >= fields_.size()) return none;
  Slot& slot = slots_[static_cast<std::size_t>(field)];
  return slot.hessian.at(here_, place().visit, [&] {
    const Vec3& world_m = place().world_m;
    // The gradient per hand metre is the turned gradient times the scale; so is its derivative once more.
    const Mat3 hessian =
        map_.scale * map_.jacobian_to_hand(slot.timed ? slot.timed->hessian_at(world_m, at_) : slot.field->hessian(world_m));
    return is_finite(hessian) ? hessian : Mat3{};
  });
}

Stretch Samples::stretch(std::int32_t field, const Vec3& from_hand_m, const Vec3& to_hand_m, double begin,
                         const Extent& quiet) const noexcept {
  if (field < 0 || static_cast<std::size_t>(field) >= fields_.size()) return {};
  const Vec3 from_m = map_.to_world(from_hand_m), to_m = map_.to_world(to_hand_m);
  const Slot& slot = slots_[static_cast<std::size_t>(field)];
  return slot.timed ? slot.timed->stretch_at(from_m, to_m, begin, quiet, at_) : slot.field->stretch(from_m, to_m, begin, quiet);
}

double Samples::spacing_m(std::int32_t field) const noexcept {
  if (field < 0 || static_cast<std::size_t>(field) >= fields_.size()) return 0.0;
  return map_.length_to_hand(fields_[static_cast<std::size_t>(field)]->spacing_m());
}

const Extent& Samples::range(std::int32_t field) const noexcept {
  static constexpr Extent none;
  if (field < 0 || static_cast<std::size_t>(field) >= ranges_.size()) return none;
  return ranges_[static_cast<std::size_t>(field)];
}

double Samples::depth_m(std::int32_t field) noexcept {
  if (field < 0 || static_cast<std::size_t>(field) >= fields_.size()) return 0.0;
  Slot& slot = slots_[static_cast<std::size_t>(field)];
  return slot.depth_m.at(here_, place().visit, [&] {
    const Vec3& world_m = place().world_m;
    return map_.length_to_hand(slot.timed ? slot.timed->depth_at(world_m, at_) : slot.field->depth_m(world_m));
  });
}

Carried Samples::carried(std::int32_t field, const Vec3& hand_m, DataTime from, DataTime to) const noexcept {
  if (field < 0 || static_cast<std::size_t>(field) >= fields_.size()) return {hand_m};
  const TimedField* timed = slots_[static_cast<std::size_t>(field)].timed;
  if (!timed || from == to) return {hand_m};
  const Carried world = timed->carried(map_.to_world(hand_m), from, to);
  const Vec3 moved_m = map_.to_hand(world.position_m);
  return world.known && is_finite(moved_m) ? Carried{moved_m} : Carried{hand_m, false};
}

double Here::value_at_start(const FieldRef& field) const noexcept {
  const Vec3 here_m = samples_->position_m();
  samples_->move_to(proxy_m);
  const ScalarSample& start = samples_->scalar(field.index);
  samples_->move_to(here_m);
  return start.inside ? start.value : samples_->scalar(field.index).value;
}

double Here::mask() const noexcept {
  double factor = 1.0;
  for (const Mask& mask : masks_) {
    const ScalarSample& sample = samples_->scalar(mask.of.index);
    factor *= sample.inside ? mask.curve.at(sample.value) : 0.0;
  }
  return factor;
}

double Here::depth_m() const noexcept {
  double least_m = std::numeric_limits<double>::infinity();
  for (const std::int32_t field : fields_) least_m = std::min(least_m, samples_->depth_m(field));
  return least_m;
}

// What is negative or not a number goes through as it is: the set of primitives refuses it by name.
double Here::limited_n(double strength_n) const noexcept {
  if (!(strength_n > 0.0)) return strength_n;
  const double depth = depth_m();
  if (!(depth > 0.0)) return 0.0;
  return std::min(strength_n * mask(), 0.5 * stiffness_n_per_m * depth);
}

double Here::newtons(const Strength& strength) const noexcept { return newtons(strength, {}, TransferFunction::Side::above); }

double Here::newtons(const Strength& strength, const Captured& level, TransferFunction::Side side) const noexcept {
  if (strength.is_constant()) return limited_n(strength.constant_n);
  if (level.any() && level.field == strength.of.index) return limited_n(strength.curve.at(level.value, side));
  const ScalarSample& sample = samples_->scalar(strength.of.index);
  return sample.inside ? limited_n(strength.curve.at(sample.value, side)) : 0.0;
}

double Here::drag(double drag_ns_per_m) const noexcept {
  if (!(drag_ns_per_m > 0.0)) return drag_ns_per_m;
  constexpr double fade_n = 1.0;  // the strength whose fade a drag borrows: over 2 N / k
  const double depth = depth_m();
  if (!(depth > 0.0)) return 0.0;
  return drag_ns_per_m * mask() * std::min(1.0, 0.5 * stiffness_n_per_m * depth / fade_n);
}

double Here::steepness_per_m(const Vec3& gradient) const noexcept { return norm(gradient) / samples_->hand_to_world().scale; }

Vec3 Here::carried(const FieldRef& field, const Vec3& x_m) const noexcept {
  return samples_->carried_m(field.index, x_m, samples_->came_from(), samples_->time());
}

}  // namespace palpa
