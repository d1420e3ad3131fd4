#include "palpa/data/derived.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>

#include "palpa/data/axis_grid.h"
#include "palpa/data/derive_on_grid.h"
#include "palpa/data/fine_detail.h"
#include "palpa/data/grid_base.h"
#include "palpa/data/grid_work.h"
#include "palpa/data/octaves.h"
#include "palpa/data/parallel.h"
#include "palpa/data/pointwise.h"
#include "palpa/data/timed_field.h"

namespace palpa {
namespace {

struct Naming {
  Derivation derivation;
  const char* name;
  int taken, given;
};
constexpr std::array<Naming, 13> namings{{
    {Derivation::magnitude, "magnitude", 3, 1},
    {Derivation::gradient_magnitude, "gradient_magnitude", 1, 1},
    {Derivation::curl, "curl", 3, 3},
    {Derivation::divergence, "divergence", 3, 1},
    {Derivation::q, "q", 3, 1},
    {Derivation::lambda2, "lambda2", 3, 1},
    {Derivation::coherence, "coherence", 3, 1},
    {Derivation::component_x, "component_x", 3, 1},
    {Derivation::component_y, "component_y", 3, 1},
    {Derivation::component_z, "component_z", 3, 1},
    {Derivation::smooth, "smooth", 1, 1},
    {Derivation::smooth_vector, "smooth_vector", 3, 3},
    {Derivation::detail, "detail", 1, 1},
}};
const Naming& naming_of(Derivation derivation) noexcept { return namings[static_cast<std::size_t>(derivation)]; }

/// Base of magnitude and components: forwards all but the sample to the source.
class OfSample : public Field {
 public:
  explicit OfSample(FieldPtr of) : of_(std::move(of)) {}
  const FieldPtr& of() const noexcept { return of_; }
  int components() const noexcept override { return 1; }
  int values_per_sample() const noexcept override { return of_->values_per_sample(); }
  double spacing_m() const noexcept override { return of_->spacing_m(); }
  Box bounds_m() const noexcept override { return of_->bounds_m(); }
  double local_spacing_m(const Vec3& world_m) const noexcept override { return of_->local_spacing_m(world_m); }
  double depth_m(const Vec3& world_m) const noexcept override { return of_->depth_m(world_m); }

 protected:
  FieldPtr of_;
};

ValueRange magnitudes_within(const std::vector<ValueRange>& e) noexcept {
  const auto reach = [](const ValueRange& x) { return std::max(std::abs(x.min), std::abs(x.max)); };
  return {0.0, std::min(norm({reach(e[0]), reach(e[1]), reach(e[2])}), std::numeric_limits<double>::max())};
}

class Magnitude final : public OfSample {
 public:
  explicit Magnitude(FieldPtr of)
      : OfSample(std::move(of)), grid_(dynamic_cast<const detail::GridBase*>(of_.get())), extents_(find_extents()) {}
  ScalarSample scalar(const Vec3& world_m) const noexcept override {
    return detail::taken_of(of_->vector(world_m), detail::Pointwise::magnitude);
  }
  /// With cells of different sizes, a quarter of the current cell: no more, and not beyond its face, where finer ones may be.
  PolynomialPiece piece_along(const Vec3& from_m, const Vec3& to_m, double begin,
                              const ValueRange& quiet) const noexcept override {
    if (!grid_ || !grid_->is_rectilinear()) return OfSample::piece_along(from_m, to_m, begin, quiet);
    const double end = grid_->end_of_cell(from_m, to_m, begin);
    const double quarter_m = 0.25 * grid_->local_spacing_m(from_m + 0.5 * (begin + end) * (to_m - from_m));
    return cubic_piece(from_m, to_m, begin, std::min(quarter_m, (end - begin) * distance(from_m, to_m)));
  }
  /// A length changes by no more than the vector.
  LipschitzBound lipschitz_bound(const Vec3& world_m) const noexcept override { return of_->lipschitz_bound(world_m); }
  std::vector<ValueRange> value_ranges() const override { return {extents_}; }

 private:
  /// Over the voxels of a grid; else from 0 to the farthest corner of the components' ranges.
  ValueRange find_extents() const {
    if (const GridView* grid = grid_behind(*of_)) return voxel_extent(*grid);
    return magnitudes_within(of_->value_ranges());
  }

  static ValueRange voxel_extent(const GridView& grid) {
    ValueRange extent{std::numeric_limits<double>::max(), 0.0};
    std::mutex joining;
    constexpr std::int64_t worth_a_thread = 1 << 16;  // [voxels] fewer: thread overhead; more: idle cores
    detail::with_values_of(grid.voxels, [&](const auto* voxels) {
      detail::in_parts(grid.geometry.voxels(), worth_a_thread, [&](std::int64_t first, std::int64_t last) {
        ValueRange part{std::numeric_limits<double>::max(), 0.0};
        for (const auto* v = voxels + 3 * first; v != voxels + 3 * last; v += 3) {
          const double length =
              norm({static_cast<double>(v[0]) * grid.scale + grid.offset, static_cast<double>(v[1]) * grid.scale + grid.offset,
                    static_cast<double>(v[2]) * grid.scale + grid.offset});
          if (std::isfinite(length)) part = {std::min(part.min, length), std::max(part.max, length)};
        }
        const std::lock_guard lock(joining);
        extent = {std::min(extent.min, part.min), std::max(extent.max, part.max)};
      });
    });
    return extent.min <= extent.max ? extent : ValueRange{};
  }

  const detail::GridBase* grid_;  // source grid of the length; or nullptr
  ValueRange extents_;
};

class Component final : public OfSample {
 public:
  Component(FieldPtr of, int axis)
      : OfSample(std::move(of)), axis_(axis), grid_(dynamic_cast<const detail::GridBase*>(of_.get())) {}
  ScalarSample scalar(const Vec3& world_m) const noexcept override { return detail::taken_of(of_->vector(world_m), axis_); }
  PolynomialPiece piece_along(const Vec3& from_m, const Vec3& to_m, double begin,
                              const ValueRange& quiet) const noexcept override {
    if (!grid_) return OfSample::piece_along(from_m, to_m, begin, quiet);
    return grid_->stretch_of(axis_, from_m, to_m, begin, quiet);
  }
  LipschitzBound lipschitz_bound(const Vec3& world_m) const noexcept override {
    return grid_ ? grid_->certificate_in(grid_->place_of(world_m), axis_, 1) : LipschitzBound{};
  }
  std::vector<ValueRange> value_ranges() const override { return {of_->value_ranges()[axis_]}; }
  int axis() const noexcept { return axis_; }

 private:
  int axis_;
  const detail::GridBase* grid_;  // source grid of the component; or nullptr
};

/// |u|², to be smoothed.
class SquaredMagnitude final : public OfSample {
 public:
  using OfSample::OfSample;
  ScalarSample scalar(const Vec3& world_m) const noexcept override {
    const VectorSample u = of_->vector(world_m);
    const ScalarSample s{norm_squared(u.value), 2.0 * transposed_times(u.jacobian, u.value), u.inside};
    return std::isfinite(s.value) && is_finite(s.gradient) ? s : ScalarSample{};
  }
  std::vector<ValueRange> value_ranges() const override {
    const double longest = magnitudes_within(of_->value_ranges()).max;
    return {{0.0, std::min(longest * longest, std::numeric_limits<double>::max())}};
  }
};

/// |mean of u| / √(mean of |u|²), from both means.
class Coherence final : public OfSample {
 public:
  Coherence(FieldPtr mean, FieldPtr mean_square) : OfSample(std::move(mean)), mean_square_(std::move(mean_square)) {}
  ScalarSample scalar(const Vec3& world_m) const noexcept override {
    const VectorSample mean = of_->vector(world_m);
    const ScalarSample square = mean_square_->scalar(world_m);
    if (!mean.inside || !square.inside) return {};
    const double length = norm(mean.value), root = std::sqrt(std::max(square.value, 0.0));
    if (!(length > 0.0) || !(root > 0.0)) return {.inside = true};
    const double share = length / root;
    const Vec3 gradient =
        (1.0 / root) * transposed_times(mean.jacobian, mean.value / length) - (0.5 * share / square.value) * square.gradient;
    return is_finite(gradient) ? ScalarSample{std::min(share, 1.0), gradient, true} : ScalarSample{.inside = true};
  }
  double depth_m(const Vec3& world_m) const noexcept override {
    return std::min(of_->depth_m(world_m), mean_square_->depth_m(world_m));
  }
  int values_per_sample() const noexcept override { return of_->values_per_sample() + mean_square_->values_per_sample(); }
  std::vector<ValueRange> value_ranges() const override { return {{0.0, 1.0}}; }

 private:
  FieldPtr mean_square_;
};

/// Magnitude or component of a field that changes with time: of its sample at that moment, so exact, too.
class TimedPointwise final : public TimedField {
 public:
  TimedPointwise(FieldPtr of, int axis) : of_(std::move(of)), timed_(*timed(*of_)), axis_(axis) {}
  const FieldPtr& of() const noexcept { return of_; }
  int axis() const noexcept { return axis_; }
  int components() const noexcept override { return 1; }
  int values_per_sample() const noexcept override { return of_->values_per_sample(); }
  double spacing_m() const noexcept override { return of_->spacing_m(); }
  double local_spacing_at(const Vec3& world_m, DataTime at) const noexcept override {
    return timed_.local_spacing_at(world_m, at);
  }
  Box bounds_m() const noexcept override { return of_->bounds_m(); }
  double cycle_s() const noexcept override { return timed_.cycle_s(); }
  double time_spacing_s() const noexcept override { return timed_.time_spacing_s(); }
  double depth_at(const Vec3& world_m, DataTime at) const noexcept override { return timed_.depth_at(world_m, at); }
  ScalarSample scalar_at(const Vec3& world_m, DataTime at) const noexcept override {
    const VectorSample u = timed_.vector_at(world_m, at);
    return detail::taken_of(u, axis_);
  }
  /// Neither a length nor a component changes by more than the vector.
  LipschitzBound lipschitz_bound_at(const Vec3& world_m, DataTime at) const noexcept override {
    return timed_.lipschitz_bound_at(world_m, at);
  }
  Carried carried(const Vec3& world_m, DataTime from, DataTime to) const noexcept override {
    return carried_with_level(world_m, from, to, 0.0);
  }
  std::vector<ValueRange> value_ranges() const override {
    const std::vector<ValueRange> e = of_->value_ranges();
    return {axis_ == detail::Pointwise::magnitude ? magnitudes_within(e) : e[static_cast<std::size_t>(axis_)]};
  }

 private:
  FieldPtr of_;
  const TimedField& timed_;
  int axis_;
};

/// Nodes of the grid behind a field, or a grid over a formula's box. A rectilinear grid at the mean distances of its planes.
GridGeometry nodes_of(const Field& field) {
  if (const GridView* grid = grid_behind(field)) {
    GridGeometry geometry = grid->geometry;
    geometry.planes = {};
    return geometry;
  }
  if (const auto* pointwise = dynamic_cast<const OfSample*>(&field)) return nodes_of(*pointwise->of());
  if (const PosedView* moved = posed_of(field)) {
    GridGeometry geometry = nodes_of(*moved->field);
    geometry.origin_m = moved->pose.to_world(geometry.origin_m);
    geometry.index_to_world_m = moved->pose.scale * (moved->pose.rotation * geometry.index_to_world_m);
    return geometry;
  }
  // [1] Samples along the longest side. More: memory (64 MiB of float32 per component at 256); fewer: a coarser grid.
  constexpr int most = 256;
  const Box box = field.bounds_m();
  const double samples = std::ceil(largest_component(box.size_m()) / field.spacing_m()) + 1.0;
  return detail::geometry_over(box, static_cast<int>(std::clamp(samples, 2.0, double(most))));
}

/// Power of length of a derivation: the values of a field enlarged by a scale are divided by the scale to it.
int powers_of_length(Derivation derivation) noexcept {
  switch (derivation) {
    case Derivation::gradient_magnitude:
    case Derivation::curl:
    case Derivation::divergence: return 1;
    case Derivation::q:
    case Derivation::lambda2: return 2;
    default: return 0;
  }
}

FieldPtr derive(Derivation derivation, const FieldPtr& of, double smoothing_m, double factor);

/// Refuses a derivation of a volume larger than memory, whose voxels are not at hand.
[[noreturn]] void refuse_octaves(Derivation derivation) {
  const std::string name = name_of(derivation);
  if (derivation == Derivation::detail || derivation == Derivation::coherence || derivation == Derivation::smooth ||
      derivation == Derivation::smooth_vector)
    throw std::invalid_argument("a volume larger than memory has no " + name +
                                " field, which needs all of its voxels; crop it (palpa convert --crop), or raise memory_mb");
  throw std::invalid_argument("a volume larger than memory has no " + name +
                              " until it is written: palpa prepare STORE --derive " + name + "=FIELD; then name the field " +
                              name + "_FIELD");
}

/// Derives a field that changes with time: below its poses, then frame by frame.
FieldPtr derive_timed(Derivation derivation, const FieldPtr& of, double smoothing_m, double factor) {
  switch (derivation) {
    case Derivation::component_x: return std::make_shared<const TimedPointwise>(of, 0);
    case Derivation::component_y: return std::make_shared<const TimedPointwise>(of, 1);
    case Derivation::component_z: return std::make_shared<const TimedPointwise>(of, 2);
    default: break;
  }
  if (const MovingView* moved = moving_of(*of)) {
    const double scale = moved->track.front().pose.scale;
    // Detail is a share: no power of a length.
    const int per_length = derivation == Derivation::detail ? 0 : moved->per_length + powers_of_length(derivation);
    return moving(derive(derivation, moved->field, smoothing_m / scale, factor), moved->track, per_length);
  }
  if (derivation == Derivation::magnitude) return std::make_shared<const TimedPointwise>(of, detail::Pointwise::magnitude);
  if (dynamic_cast<const Octaves*>(of.get())) refuse_octaves(derivation);
  std::vector<FieldPtr> frames;
  if (const SeriesView* series = series_of(*of)) {
    for (const FieldPtr& frame : series->frames) frames.push_back(derive(derivation, frame, smoothing_m, factor));
    return time_series(std::move(frames), series->period_s, series->between_frames);
  }
  const TimedField& formula = *timed(*of);
  // A track of many poses has as many moments, each a grid over the volume's whole range of motion.
  const double moments = std::max(1.0, std::round(formula.cycle_s() / formula.time_spacing_s()));
  detail::expect_few_samples(nodes_of(*of), moments, limit::derived_samples);
  const double period_s = moments > 1.0 ? formula.cycle_s() / moments : 1.0;
  for (int i = 0; i < static_cast<int>(moments); ++i)
    frames.push_back(derive(derivation, frozen(of, i * period_s), smoothing_m, factor));
  return time_series(std::move(frames), period_s);
}

/// \param factor  [1] on the values: the division by outer poses' scales
FieldPtr derive(Derivation derivation, const FieldPtr& of, double smoothing_m, double factor) {
  if (timed(*of)) return derive_timed(derivation, of, smoothing_m, factor);
  switch (derivation) {
    case Derivation::component_x: return std::make_shared<const Component>(of, 0);
    case Derivation::component_y: return std::make_shared<const Component>(of, 1);
    case Derivation::component_z: return std::make_shared<const Component>(of, 2);
    default: break;
  }
  if (const PosedView* moved = posed_of(*of)) {
    const double scale = moved->pose.scale;
    const int powers = powers_of_length(derivation);
    for (int n = 0; n < powers; ++n) factor /= scale;
    if (!std::isfinite(factor)) {
      throw std::invalid_argument("a scale this small takes its " + std::string(name_of(derivation)) +
                                  " beyond the largest number; use a larger scale");
    }
    return posed(derive(derivation, moved->field, smoothing_m / scale, factor), moved->pose);
  }
  if (derivation == Derivation::magnitude) return std::make_shared<const Magnitude>(of);
  if (derivation == Derivation::detail) return std::make_shared<const detail::FineDetail>(of);
  if (derivation == Derivation::coherence) {
    const GridGeometry nodes = nodes_of(*of);
    return std::make_shared<const Coherence>(
        detail::derive_on_grid(Derivation::smooth_vector, *of, nodes, smoothing_m, 1.0),
        detail::derive_on_grid(Derivation::smooth, SquaredMagnitude(of), nodes, smoothing_m, 1.0));
  }
  return detail::derive_on_grid(derivation, *of, nodes_of(*of), smoothing_m, factor);
}

}  // namespace

namespace detail {

std::optional<Pointwise> pointwise_of(const Field& field) noexcept {
  if (const auto* length = dynamic_cast<const Magnitude*>(&field)) return Pointwise{length->of()};
  if (const auto* component = dynamic_cast<const Component*>(&field)) return Pointwise{component->of(), component->axis()};
  if (const auto* taken = dynamic_cast<const TimedPointwise*>(&field)) return Pointwise{taken->of(), taken->axis()};
  return std::nullopt;
}

ScalarSample taken_of(const VectorSample& u, int axis) noexcept {
  if (!u.inside) return {};
  if (axis != Pointwise::magnitude) {
    const double values[3] = {u.value.x, u.value.y, u.value.z};
    return {values[axis], u.jacobian.row[axis], true};
  }
  const ScalarSample s{norm(u.value), transposed_times(u.jacobian, normalized(u.value)), true};
  return std::isfinite(s.value) && is_finite(s.gradient) ? s : ScalarSample{};
}

}  // namespace detail

std::optional<Derivation> derivation_named(std::string_view name) noexcept {
  for (const Naming& n : namings) {
    if (n.derivation < Derivation::smooth && n.name == name) return n.derivation;
  }
  return std::nullopt;
}
const char* name_of(Derivation derivation) noexcept { return naming_of(derivation).name; }
int components_taken(Derivation derivation) noexcept { return naming_of(derivation).taken; }
int components_given(Derivation derivation) noexcept { return naming_of(derivation).given; }

std::string unit_of(Derivation derivation, std::string_view unit) {
  if (unit.empty()) return {};
  const std::string u(unit);
  const bool simple = u.find_first_of("/· *") == std::string::npos;
  switch (derivation) {
    case Derivation::gradient_magnitude: return simple ? u + "/m" : "(" + u + ")/m";
    case Derivation::curl:
    case Derivation::divergence: return u == "m/s" ? "1/s" : simple ? u + "/m" : "(" + u + ")/m";
    case Derivation::q:
    case Derivation::lambda2: return u == "m/s" ? "1/s²" : "(" + u + ")²/m²";
    case Derivation::coherence:
    case Derivation::detail: return {};
    default: return u;
  }
}

FieldPtr derived(Derivation derivation, const FieldPtr& of, double smoothing_m) {
  if (!of) throw std::invalid_argument("there is no field to derive from");
  const int taken = components_taken(derivation);
  if (of->components() != taken) {
    throw std::invalid_argument(std::string(name_of(derivation)) + " is made from a " + (taken == 3 ? "vector" : "scalar") +
                                " field, and this is a " + (taken == 3 ? "scalar" : "vector") + " field");
  }
  if (derivation != Derivation::magnitude && is_axis_field(*of)) {
    throw std::invalid_argument(std::string(name_of(derivation)) +
                                " cannot be taken of axes, whose sign means nothing; their magnitude can");
  }
  if (!std::isfinite(smoothing_m) || smoothing_m < 0.0) {
    throw std::invalid_argument("the smoothing must be a length of 0 m or more");
  }
  return derive(derivation, of, smoothing_m, 1.0);
}

}  // namespace palpa
