#include "palpa/field/derived.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "palpa/field/grid.h"

namespace palpa {
namespace {

struct Naming {
  Derivation derivation;
  const char* name;
  int taken, given;
};
constexpr std::array<Naming, 10> namings{{
    {Derivation::magnitude, "magnitude", 3, 1},
    {Derivation::gradient_magnitude, "gradient_magnitude", 1, 1},
    {Derivation::curl, "curl", 3, 3},
    {Derivation::divergence, "divergence", 3, 1},
    {Derivation::q, "q", 3, 1},
    {Derivation::lambda2, "lambda2", 3, 1},
    {Derivation::component_x, "component_x", 3, 1},
    {Derivation::component_y, "component_y", 3, 1},
    {Derivation::component_z, "component_z", 3, 1},
    {Derivation::smooth, "smooth", 1, 1},
}};
const Naming& naming_of(Derivation derivation) noexcept { return namings[static_cast<std::size_t>(derivation)]; }

/// What magnitude and components share: all but the sample is the source's.
class Pointwise : public Field {
 public:
  explicit Pointwise(FieldPtr of) : of_(std::move(of)) {}
  int components() const noexcept override { return 1; }
  double spacing_m() const noexcept override { return of_->spacing_m(); }
  Box bounds_m() const noexcept override { return of_->bounds_m(); }
  double depth_m(const Vec3& world_m) const noexcept override { return of_->depth_m(world_m); }

 protected:
  FieldPtr of_;
};

/// |u|, with gradient Jᵀu/|u|; 0 where u is, the kink of |u|.
class Magnitude final : public Pointwise {
 public:
  explicit Magnitude(FieldPtr of) : Pointwise(std::move(of)), extents_(find_extents()) {}
  ScalarSample scalar(const Vec3& world_m) const noexcept override {
    const VectorSample u = of_->vector(world_m);
    if (!u.inside) return {};
    const ScalarSample s{norm(u.value), transposed_times(u.jacobian, normalized(u.value)), true};
    return std::isfinite(s.value) && is_finite(s.gradient) ? s : ScalarSample{};
  }
  std::vector<Extent> extents() const override { return {extents_}; }

 private:
  Extent find_extents() const {
    Vec3 largest;
    const std::vector<Extent> e = of_->extents();
    const auto reach = [](const Extent& x) { return std::max(std::abs(x.min), std::abs(x.max)); };
    return {0.0, norm({reach(e[0]), reach(e[1]), reach(e[2])})};
  }
  Extent extents_;
};

class Component final : public Pointwise {
 public:
  Component(FieldPtr of, int axis) : Pointwise(std::move(of)), axis_(axis) {}
  ScalarSample scalar(const Vec3& world_m) const noexcept override {
    const VectorSample u = of_->vector(world_m);
    if (!u.inside) return {};
    const double values[3] = {u.value.x, u.value.y, u.value.z};
    return {values[axis_], u.jacobian.row[axis_], true};
  }
  std::vector<Extent> extents() const override { return {of_->extents()[axis_]}; }

 private:
  int axis_;
};

/// A function of the source's own derivative, to be sampled.
class OfDerivative final : public Pointwise {
 public:
  OfDerivative(FieldPtr of, Derivation derivation) : Pointwise(std::move(of)), derivation_(derivation) {}
  int components() const noexcept override { return components_given(derivation_); }
  ScalarSample scalar(const Vec3& world_m) const noexcept override {
    if (derivation_ == Derivation::gradient_magnitude || derivation_ == Derivation::smooth) {
      const ScalarSample s = of_->scalar(world_m);
      return {derivation_ == Derivation::smooth ? s.value : norm(s.gradient), {}, s.inside};
    }
    const VectorSample u = of_->vector(world_m);
    const Mat3& j = u.jacobian;
    if (derivation_ == Derivation::divergence) return {j.row[0].x + j.row[1].y + j.row[2].z, {}, u.inside};
    return {-0.5 * (dot(j.row[0], transposed(j).row[0]) + dot(j.row[1], transposed(j).row[1]) +
                    dot(j.row[2], transposed(j).row[2])),
            {},
            u.inside};
  }
  VectorSample vector(const Vec3& world_m) const noexcept override {
    const VectorSample u = of_->vector(world_m);
    const Mat3& j = u.jacobian;
    return {{j.row[2].y - j.row[1].z, j.row[0].z - j.row[2].x, j.row[1].x - j.row[0].y}, {}, u.inside};
  }
  std::vector<Extent> extents() const override { return {}; }

 private:
  Derivation derivation_;
};

}  // namespace

std::optional<Derivation> derivation_named(std::string_view name) noexcept {
  for (const Naming& n : namings) {
    if (n.derivation != Derivation::smooth && n.name == name) return n.derivation;
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
  if (!std::isfinite(smoothing_m) || smoothing_m < 0.0) {
    throw std::invalid_argument("the smoothing must be a length of 0 m or more");
  }
  switch (derivation) {
    case Derivation::magnitude: return std::make_shared<const Magnitude>(of);
    case Derivation::component_x: return std::make_shared<const Component>(of, 0);
    case Derivation::component_y: return std::make_shared<const Component>(of, 1);
    case Derivation::component_z: return std::make_shared<const Component>(of, 2);
    default: break;
  }
  const double longest = largest_component(of->bounds_m().size_m()) / of->spacing_m();
  return sampled(OfDerivative(of, derivation), std::clamp(static_cast<int>(std::min(longest, 255.0)) + 1, 2, 256));
}

}  // namespace palpa
