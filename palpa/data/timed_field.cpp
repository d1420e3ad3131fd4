#include "palpa/data/timed_field.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpa/data/field_at_moment.h"

namespace palpa {
namespace {

/// Timed field at a moment, by its own functions alone: a reference to it.
class Moment final : public Field {
 public:
  Moment(const TimedField& field, DataTime at) noexcept : field_(field), at_(at) {}
  int components() const noexcept override { return field_.components(); }
  ScalarSample scalar(const Vec3& world_m) const noexcept override { return field_.scalar_at(world_m, at_); }
  VectorSample vector(const Vec3& world_m) const noexcept override { return field_.vector_at(world_m, at_); }
  double spacing_m() const noexcept override { return field_.spacing_m(); }
  Box bounds_m() const noexcept override { return field_.bounds_m(); }
  double depth_m(const Vec3& world_m) const noexcept override { return field_.depth_at(world_m, at_); }
  std::vector<ValueRange> value_ranges() const override { return field_.value_ranges(); }

 private:
  const TimedField& field_;
  DataTime at_;
};

/// Moment that owns its field.
class Frozen final : public Field {
 public:
  Frozen(FieldPtr field, DataTime at) : field_(std::move(field)), now_(timed(*field_)->at_moment(at)) {}
  int components() const noexcept override { return field_->components(); }
  ScalarSample scalar(const Vec3& world_m) const noexcept override { return now_.scalar(world_m); }
  VectorSample vector(const Vec3& world_m) const noexcept override { return now_.vector(world_m); }
  Mat3 hessian(const Vec3& world_m) const noexcept override { return now_.hessian(world_m); }
  PolynomialPiece piece_along(const Vec3& from_m, const Vec3& to_m, double begin,
                              const ValueRange& quiet) const noexcept override {
    return now_.piece_along(from_m, to_m, begin, quiet);
  }
  LipschitzBound lipschitz_bound(const Vec3& world_m) const noexcept override { return now_.lipschitz_bound(world_m); }
  int values_per_sample() const noexcept override { return now_.values_per_sample(); }
  double spacing_m() const noexcept override { return field_->spacing_m(); }
  double local_spacing_m(const Vec3& world_m) const noexcept override { return now_.local_spacing_m(world_m); }
  Box bounds_m() const noexcept override { return field_->bounds_m(); }
  double depth_m(const Vec3& world_m) const noexcept override { return now_.depth_m(world_m); }
  std::vector<ValueRange> value_ranges() const override { return field_->value_ranges(); }

 private:
  FieldPtr field_;
  FieldAtMoment now_;
};

}  // namespace

double DataTime::within(double cycle_s) const noexcept {
  if (!std::isfinite(time_s)) return 0.0;
  if (!loop) return std::clamp(time_s, 0.0, cycle_s);
  const double rest = std::fmod(time_s, cycle_s);
  return rest < 0.0 ? rest + cycle_s : rest;
}

ScalarSample TimedField::scalar_at(const Vec3&, DataTime) const noexcept { return {}; }
FieldAtMoment TimedField::at_moment(DataTime at) const noexcept { return {*this, at}; }
VectorSample TimedField::vector_at(const Vec3&, DataTime) const noexcept { return {}; }
Mat3 TimedField::hessian_at(const Vec3& world_m, DataTime at) const noexcept {
  return Moment(*this, at).hessian(world_m);  // Field's own, by differences
}

PolynomialPiece TimedField::piece_along_at(const Vec3& from_m, const Vec3& to_m, double begin, const ValueRange& quiet,
                                           DataTime at) const noexcept {
  return Moment(*this, at).piece_along(from_m, to_m, begin, quiet);  // likewise
}

Carried TimedField::carried_with_level(const Vec3& world_m, DataTime from, DataTime to, double noise) const noexcept {
  if (from == to) return {world_m};
  const ScalarSample start = scalar_at(world_m, from);
  if (!start.inside) return {world_m};  // no data there that could have moved
  const Carried lost{world_m, false};
  // Newton steps. More: longer worst tick; fewer: a bending level counts as lost and fades.
  constexpr int most_steps = 8;
  // [1] of a spacing: convergence, and acceptance after the last step. Larger: the proxy is carried off its level; smaller:
  // useless steps, or levels that count as lost.
  constexpr double on_level = 1e-9, near_level = 1e-3;
  const double h = local_spacing_at(world_m, from);
  const FieldAtMoment later = at_moment(to);
  Vec3 at_m = world_m;
  for (int step = 0;; ++step) {
    const ScalarSample now = later.scalar(at_m);
    if (!now.inside) return lost;
    const double rest = start.value - now.value;
    if (rest == 0.0) return {at_m};
    const double steepness = norm(now.gradient);
    if (!(steepness > noise)) return lost;
    const double way_m = rest / steepness;
    if (std::abs(way_m) <= on_level * h) return {at_m};
    if (step == most_steps) return std::abs(way_m) <= near_level * h ? Carried{at_m} : lost;
    at_m += way_m * (now.gradient / steepness);
    if (!(distance(at_m, world_m) <= 0.5 * h)) return lost;
  }
}

const TimedField* timed(const Field& field) noexcept { return dynamic_cast<const TimedField*>(&field); }

FieldPtr frozen(FieldPtr field, DataTime at) {
  if (!field || !timed(*field)) return field;
  return std::make_shared<const Frozen>(std::move(field), at);
}

}  // namespace palpa
