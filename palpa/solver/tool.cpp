#include "palpa/solver/tool.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace palpa {

namespace {

constexpr double furthest_point_m = 1.0;  // [m] further is a wrong unit
constexpr double largest_radius_m = 0.5;

constexpr double shortest_span_m = 1e-5;  // [m] nearer feet count as one

// [m] The balance has no smaller turning radius. More: small tools turn too stiffly; less: rounding of turns is felt.
constexpr double shortest_radius_m = 1e-6;

// [1] Share of the largest lever below which ρ never falls. Less: feet yield by turning far more than by moving.
constexpr double least_radius_share = 0.1;

using Shape = ToolOptions::Shape;

bool is_near(const Vec3& position_m) noexcept { return is_finite(position_m) && norm(position_m) <= furthest_point_m; }

// Evenly on a disc or a sphere: the golden angle between successive points (Vogel 1979).
Vec3 spiral_m(Shape shape, double radius_m, int i, int points) noexcept {
  const double angle_rad = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
  const double share = (i + 0.5) / points;
  const double z = shape == Shape::ball ? 1.0 - 2.0 * share : 0.0;
  const double across = shape == Shape::ball ? std::sqrt(1.0 - z * z) : std::sqrt(share);
  return radius_m * Vec3{across * std::cos(angle_rad), across * std::sin(angle_rad), z};
}

// Along the axis; with a radius in rings of up to eight about it, the last ring with what is left.
Vec3 rod_m(const ToolOptions& options, int i) noexcept {
  const int around = options.radius_m > 0.0 ? std::min(8, options.points) : 1;
  const int rings = (options.points + around - 1) / around;
  const double along = rings > 1 ? static_cast<double>(i / around) / (rings - 1) - 0.5 : 0.0;
  const double angle_rad = 2.0 * std::numbers::pi * (i % around) / around;
  return {options.radius_m * std::cos(angle_rad), options.radius_m * std::sin(angle_rad), along * options.length_m};
}

std::vector<Vec3> points_of(const ToolOptions& options) {
  if (options.shape == Shape::point) return {Vec3{}};
  if (options.shape == Shape::points) return options.points_m;
  std::vector<Vec3> points_m;
  for (int i = 0; i < options.points; ++i)
    points_m.push_back(options.shape == Shape::rod ? rod_m(options, i)
                                                   : spiral_m(options.shape, options.radius_m, i, options.points));
  return points_m;
}

// The turning radius of docs/theory.md 10.7: both springs give alike at the feet, and no press tips the tool over.
double default_radius_m(const std::vector<Vec3>& levers_m, double reach_m, const CouplingOptions& coupling) noexcept {
  double mean_m2 = 0.0;
  for (const Vec3& lever_m : levers_m) mean_m2 += norm_squared(lever_m) / static_cast<double>(levers_m.size());
  const double steady_m2 = 2.0 * coupling.max_force_n * reach_m / coupling.stiffness_n_per_m;
  return std::max({std::sqrt(std::max(mean_m2, steady_m2)), least_radius_share * reach_m});
}

}  // namespace

const char* problem_with(const ToolOptions& options) noexcept {
  const auto is_between = [](double value, double above, double at_most) { return value > above && value <= at_most; };
  if (options.shape == Shape::points) {
    if (options.points_m.empty()) return "points_m needs at least one point";
    if (options.points_m.size() > most_feet) return "points_m has more than 256 points";
    if (!std::ranges::all_of(options.points_m, is_near)) return "points_m must be finite and within 1 m";
  } else if (!options.points_m.empty()) {
    return "points_m needs no shape";
  }
  const bool is_formed = options.shape == Shape::rod || options.shape == Shape::pad || options.shape == Shape::ball;
  if (is_formed && !(options.points >= 1 && options.points <= static_cast<int>(most_feet)))
    return "points must be between 1 and 256";
  if (options.shape == Shape::rod && !is_between(options.length_m, 0.0, furthest_point_m))
    return "length_m of a rod must be above 0 and at most 1";
  if (options.shape == Shape::rod && !(options.radius_m >= 0.0 && options.radius_m <= largest_radius_m))
    return "radius_m of a rod must be between 0 and 0.5";
  const bool is_round = options.shape == Shape::pad || options.shape == Shape::ball;
  if (is_round && !is_between(options.radius_m, 0.0, largest_radius_m)) return "radius_m must be above 0 and at most 0.5";
  if (options.shape != Shape::rod && options.length_m != 0.0) return "length_m is of a rod";
  if (!is_formed && options.radius_m != 0.0) return "radius_m is of a rod, pad or ball";
  if (!is_between(options.share, 0.0, 1.0)) return "share must be above 0 and at most 1";
  if (!is_near(options.centre_m)) return "centre_m must be finite and within 1 m";
  if (options.turning_radius_m && !is_between(*options.turning_radius_m, 0.0, furthest_point_m))
    return "turning_radius_m must be above 0 and at most 1";
  return nullptr;
}

Tool::Tool(const ToolOptions& options, const CouplingOptions& coupling) {
  const char* problem = problem_with(options);
  if (!problem) problem = problem_with(coupling);
  if (problem) throw std::invalid_argument(problem);
  levers_m_ = points_of(options);
  feet_ = levers_m_.size();
  for (Vec3& lever_m : levers_m_) {
    lever_m -= options.centre_m;
    reach_m_ = std::max(reach_m_, norm(lever_m));
  }
  least_span_m_ = std::max(reach_m_, shortest_span_m);
  for (std::size_t i = 0; i < levers_m_.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double span_m = distance(levers_m_[i], levers_m_[j]);
      if (span_m > shortest_span_m) least_span_m_ = std::min(least_span_m_, span_m);
    }
  }
  share_ = options.share;
  is_point_ = feet() == 1 && reach_m_ == 0.0;
  if (is_point_) return;
  turning_radius_m_ = options.turning_radius_m.value_or(default_radius_m(levers_m_, reach_m_, coupling));
  turning_radius_m_ = std::max(shortest_radius_m, turning_radius_m_);
}

Vec3 Tool::body_arc_m(const Turn& from, const Turn& to) const noexcept {
  return turning_radius_m_ * rotation_between_rad(from, to);
}

Turn Tool::body_turn(const Turn& from, const Vec3& arc_m) const noexcept {
  return turned_further(from, arc_m / turning_radius_m_);
}

Turn Tool::body_middle(const Turn& a, const Turn& b) const noexcept {
  return turned_further(a, 0.5 * rotation_between_rad(a, b));
}

double Tool::body_way_m(const Motion& motion) const noexcept {
  return norm(motion.way_m) + reach_m_ / turning_radius_m_ * norm(motion.arc_m);
}

double Tool::body_length_m(const Pose& from, const Pose& to) const noexcept { return length(motion(from, to)); }

}  // namespace palpa
