#include "palpa/data/fine_detail.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpa/data/filter.h"
#include "palpa/data/halton.h"

namespace palpa::detail {

FineDetail::FineDetail(FieldPtr of)
    : of_(std::move(of)),
      smooth_(has_detail(*of_) ? dynamic_cast<const GridBase*>(of_.get()) : nullptr),
      kept_(smooth_ ? filtered(of_, Filter::trilinear) : nullptr),
      linear_(dynamic_cast<const GridBase*>(kept_.get())),
      scale_(smooth_ ? find_scale() : 0.0) {}

double FineDetail::find_scale() const {
  constexpr int places = 4096;  // [1] more: slower to load; fewer: a less certain scale
  // [1] of the range: the least scale. Less: rounding of smooth data becomes texture; more: fine texture is weaker.
  constexpr double least_share = 0.001;
  const GridGeometry& geometry = smooth_->view().geometry;
  const auto index = [&](double share, std::size_t axis) { return share * static_cast<double>(geometry.dims[axis] - 1); };
  double squares = 0.0;
  int counted = 0;
  for (int i = 1; i <= places; ++i) {
    GridBase::Place place = smooth_->place_of(
        geometry.to_world({index(radical_inverse<2>(i), 0), index(radical_inverse<3>(i), 1), index(radical_inverse<5>(i), 2)}));
    const ScalarSample smooth = smooth_->scalar_in(place), linear = linear_->scalar_in(place);
    if (!smooth.inside || !linear.inside) continue;
    const double difference = linear.value - smooth.value;
    squares += difference * difference;
    ++counted;
  }
  const ValueRange range = smooth_->value_ranges().front();
  const double scale = std::max(3.0 * std::sqrt(squares / std::max(counted, 1)), least_share * (range.max - range.min));
  return std::isfinite(scale) ? scale : 0.0;
}

ScalarSample FineDetail::scalar_in(GridBase::Place& place) const noexcept {
  const ScalarSample smooth = smooth_->scalar_in(place);
  if (!smooth.inside) return {};
  const ScalarSample linear = linear_->scalar_in(place);
  const ScalarSample none{.inside = true};
  if (!linear.inside || !(scale_ > 0.0)) return none;
  const double share = (linear.value - smooth.value) / scale_;
  if (!(std::abs(share) < 1.0)) return std::isnan(share) ? none : ScalarSample{std::copysign(1.0, share), {}, true};
  const Vec3 gradient = (linear.gradient - smooth.gradient) / scale_;
  return is_finite(gradient) ? ScalarSample{share, gradient, true} : none;
}

ScalarSample FineDetail::scalar(const Vec3& world_m) const noexcept {
  if (!smooth_) return {.inside = of_->scalar(world_m).inside};
  GridBase::Place place = smooth_->place_of(world_m);
  return scalar_in(place);
}

std::vector<ValueRange> FineDetail::value_ranges() const {
  const double most = scale_ > 0.0 ? 1.0 : 0.0;
  return {{-most, most}};
}

}  // namespace palpa::detail
