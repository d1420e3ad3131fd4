#include "palpa/device/front.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "palpa/device/hand.h"
#include "palpa/device/sine_cosine.h"

namespace palpa {

namespace {

// Ball of `ball_facing` in hand.h. Other radii: recorded results of simulated hands without a scene change.
constexpr double ball_radius_m = 0.075;
// [1] Distance from the axis, as a share of the radius, from which a ball is followed as a cone. More: the hand moves in and
// out faster than an arm can; less: it leaves the ball sooner.
constexpr double steepest_share = 0.8;

class BallFacing final : public Front {
 public:
  // At any depth the hand follows a ball of radius R − depth.
  Vec3 at(double x_m, double y_m, double depth_m) const noexcept override {
    const double radius_m = std::max(0.0, ball_radius_m - depth_m);
    const double edge_m = steepest_share * radius_m;
    const double aside_m = std::sqrt(x_m * x_m + y_m * y_m);
    if (aside_m <= edge_m) return {x_m, y_m, std::sqrt(radius_m * radius_m - x_m * x_m - y_m * y_m)};
    const double height_m = std::sqrt(radius_m * radius_m - edge_m * edge_m);
    const double slope = steepest_share / std::sqrt(1.0 - steepest_share * steepest_share);
    return {x_m, y_m, height_m - slope * (aside_m - edge_m)};
  }
};

class ReliefFacing final : public Front {
 public:
  ReliefFacing(const Vec3& place_m, Relief relief, double column, double row, double spacing_m)
      : place_m_(place_m), relief_(std::move(relief)), column_(column), row_(row), spacing_m_(spacing_m) {}
  Vec3 at(double x_m, double y_m, double depth_m) const noexcept override {
    const double z_m = relief_.at(column_ + x_m / spacing_m_, row_ + y_m / spacing_m_);
    return {place_m_.x + x_m, place_m_.y + y_m, z_m - depth_m};
  }

 private:
  Vec3 place_m_;
  Relief relief_;
  double column_, row_, spacing_m_;
};

Vec3 on_turn(const Vec3& centre_m, double turns, double height_m, double radius_m) noexcept {
  const detail::SineCosine angle = detail::sine_cosine(turns);
  return centre_m + Vec3{radius_m * angle.sine, height_m, radius_m * angle.cosine};
}

class CylinderAround final : public Front {
 public:
  CylinderAround(const Vec3& centre_m, double radius_m) : centre_m_(centre_m), radius_m_(radius_m) {}
  Vec3 at(double turns, double height_m, double depth_m) const noexcept override {
    return on_turn(centre_m_, turns, height_m, std::max(0.0, radius_m_ - depth_m));
  }

 private:
  Vec3 centre_m_;
  double radius_m_;
};

class ReliefAround final : public Front {
 public:
  ReliefAround(const Vec3& centre_m, Relief relief, double turns_per_column, double row, double spacing_m)
      : centre_m_(centre_m),
        relief_(std::move(relief)),
        turns_per_column_(turns_per_column),
        row_(row),
        spacing_m_(spacing_m) {}
  Vec3 at(double turns, double height_m, double depth_m) const noexcept override {
    const double radius_m = relief_.at((turns - std::floor(turns)) / turns_per_column_, row_ + height_m / spacing_m_);
    return on_turn(centre_m_, turns, height_m, std::max(0.0, radius_m - depth_m));
  }

 private:
  Vec3 centre_m_;
  Relief relief_;
  double turns_per_column_, row_, spacing_m_;
};

/// Weights of a uniform cubic B-spline at the share `t` [1] of a cell.
struct Weights {
  double w[4];
};
Weights weights(double t) noexcept {
  const double s = 1.0 - t;
  return {{s * s * s / 6.0, (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0, (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
           t * t * t / 6.0}};
}

}  // namespace

Relief::Relief(std::vector<double> heights, int columns, int rows, bool u_turns)
    : heights_(std::move(heights)), columns_(columns), rows_(rows), u_turns_(u_turns) {
  assert(columns_ > 0 && rows_ > 0 && heights_.size() == static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
}

double Relief::at(double column, double row) const noexcept {
  // Flat beyond the lattice: from two cells outside on, all weights apply to its last heights.
  if (!u_turns_) column = std::clamp(column, -2.0, columns_ + 1.0);
  row = std::clamp(row, -2.0, rows_ + 1.0);
  const double i0 = std::floor(column), j0 = std::floor(row);
  const Weights u = weights(column - i0), v = weights(row - j0);
  double height_m = 0.0;
  for (int b = 0; b < 4; ++b) {
    const int j = std::clamp(static_cast<int>(j0) + b - 1, 0, rows_ - 1);
    double along_m = 0.0;
    for (int a = 0; a < 4; ++a) {
      const int i = static_cast<int>(i0) + a - 1;
      const int turned = ((i % columns_) + columns_) % columns_;
      const int held = u_turns_ ? turned : std::clamp(i, 0, columns_ - 1);
      along_m += u.w[a] * heights_[static_cast<std::size_t>(j * columns_ + held)];
    }
    height_m += v.w[b] * along_m;
  }
  return height_m;
}

std::shared_ptr<const Front> ball_facing() { return std::make_shared<BallFacing>(); }
std::shared_ptr<const Front> cylinder_around(const Vec3& centre_m, double radius_m) {
  return std::make_shared<CylinderAround>(centre_m, radius_m);
}
std::shared_ptr<const Front> relief_facing(const Vec3& place_m, Relief relief, double column, double row, double spacing_m) {
  return std::make_shared<ReliefFacing>(place_m, std::move(relief), column, row, spacing_m);
}
std::shared_ptr<const Front> relief_around(const Vec3& centre_m, Relief relief, double turns_per_column, double row,
                                           double spacing_m) {
  return std::make_shared<ReliefAround>(centre_m, std::move(relief), turns_per_column, row, spacing_m);
}

}  // namespace palpa
