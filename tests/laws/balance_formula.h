// The check of a balance by docs/trace.md without the solver, in arithmetic of 113 bits.
#pragma once

#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "tests/solver/all_faces.h"

namespace palpa::test {

namespace formula {

using Quad = __float128;

inline constexpr double ulp = std::numeric_limits<double>::epsilon();

struct Quad3 {
  Quad x = 0, y = 0, z = 0;
};
inline Quad3 wide(const Vec3& a) { return {a.x, a.y, a.z}; }
inline Quad3 operator+(const Quad3& a, const Quad3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Quad3 operator-(const Quad3& a, const Quad3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Quad3 operator*(Quad f, const Quad3& a) { return {f * a.x, f * a.y, f * a.z}; }
inline Quad dot(const Quad3& a, const Quad3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Quad3 cross(const Quad3& a, const Quad3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Two steps of Newton's method from the root of 64 bits.
inline Quad root(Quad a) {
  if (!(a > 0)) return 0;
  Quad y = std::sqrt(static_cast<long double>(a));
  if (!(y > 0)) return 0;
  for (int i = 0; i < 2; ++i) y = (y + a / y) / 2;
  return y;
}
inline Quad length(const Quad3& a) { return root(dot(a, a)); }
inline Quad largest(Quad a, Quad b) { return a > b ? a : b; }

// Stored energy of a primitive of strength `s` at distance `d`: Huber's function of d with a stiffness, else s d.
inline Quad held_j(double s, double stiffness_n_per_m, Quad d) {
  const Quad stiffness = stiffness_n_per_m;
  if (!(stiffness > 0)) return s * d;
  return stiffness * d <= s ? stiffness / 2 * d * d : s * d - Quad(s) * s / (2 * stiffness);
}

/// The formula of one balance, summed primitive by primitive, independent of the library's solver.
class BalanceFormula {
 public:
  /// \param x_m         the balance
  /// \param directed_n  sum of the directed forces
  /// \param k           [N/m] of the coupling
  /// \param T           [s] of the sub-step
  BalanceFormula(const Vec3& x_m, const Vec3& probe_m, const Vec3& directed_n, double k, double T)
      : x_(wide(x_m)), foot_(x_), left_(Quad(k) * (wide(x_m) - wide(probe_m)) - wide(directed_n)), k_(k), T_(T) {
    foot_ulp_m_ = position_ulp_m_ = ulp * largest_component(x_m);
    rho_rounding_ = k * position_ulp_m_;
  }

  /// Makes the balance that of a tool with an orientation.
  /// \param turn_rad  from the start to the balance
  /// \param start, probe  orientations
  /// \param radius_m  turning radius
  void turns(const Vec3& turn_rad, const Turn& start, const Turn& probe, double radius_m) {
    const Vec3 ahead_rad = rotation_between_rad(start, probe);
    turn_ = wide(turn_rad);
    radius_m_ = radius_m;
    left_nm_ = k_ * radius_m * radius_m * (turn_ - wide(ahead_rad));
    rho_rounding_ += 8.0 * ulp * static_cast<double>(k_) * radius_m * (1.0 + norm(ahead_rad) + norm(turn_rad));
  }
  /// Later primitives act at the foot with this lever [m], whose place is a sum in doubles.
  void at_foot(const Vec3& lever_m) {
    lever_ = wide(lever_m);
    foot_ = x_ + lever_ + cross(turn_, lever_);
    foot_ulp_m_ = position_ulp_m_ + 2.0 * ulp * norm(lever_m);
    rho_rounding_ += static_cast<double>(k_) * ulp * norm(lever_m);
  }
  /// A directed force, whose sum was given to the constructor: its torque.
  void add_directed(const Vec3& force_n) { left_nm_ = left_nm_ - cross(lever_, wide(force_n)); }

  /// A primitive that is neither directed nor a facet, with its kind as the trace calls it; stiffness 0: rigid.
  void add(std::string_view kind, const Vec3& position_m, const Vec3& direction, double s, double c, double stiffness_n_per_m,
           const Vec3& force_n) {
    Quad3 q = wide(direction);
    if (kind != "point") q = (1 / length(q)) * q;
    const Quad3 d = wide(position_m) - foot_;
    Quad3 u = wide(force_n);
    Quad3 R = d;
    if (kind == "line") {
      u = u - dot(q, u) * q;
      R = d - dot(q, d) * q;
    }
    if (kind == "plane") {
      u = largest(0, dot(q, u)) * q;
      R = dot(q, d) * q;
    }
    if (c == 0.0 && length(u) > s) u = (s / length(u)) * u;
    const Quad reach = kind == "plane" ? largest(0, dot(q, d)) : length(R);
    const Quad force = length(u);
    pull(u);
    epsilon_ = epsilon_ + held_j(s, stiffness_n_per_m, reach) + Quad(c) / (2 * Quad(T_)) * reach * reach - dot(u, R);
    if (stiffness_n_per_m > 0.0) epsilon_ = epsilon_ + force * force / (2 * Quad(stiffness_n_per_m));
    if (c > 0.0) {
      const Quad over = largest(0, force - s);
      epsilon_ = epsilon_ + Quad(T_) / (2 * Quad(c)) * over * over;
    }
    const double size_n = s + static_cast<double>(force);
    rho_rounding_ += 4.0 * ulp * size_n;
    epsilon_rounding_ += size_n * (foot_ulp_m_ + 8.0 * ulp * static_cast<double>(length(R)));
  }

  /// The facets of a corner of strength `s`, elastic if its stiffness is above 0; `forces_n` point along their normals.
  void add_corner(const Facets& facets, double s, double stiffness_n_per_m, const std::vector<Vec3>& forces_n) {
    Quad3 u;
    Quad held = 0, largest_m = 0, sizes = 0;
    for (std::size_t i = 0; i < facets.size(); ++i) {
      const Quad3 n = (1 / length(wide(facets[i].normal))) * wide(facets[i].normal);
      const Quad3 d = wide(facets[i].position_m) - foot_;
      const Quad t = largest(0, dot(n, wide(forces_n[i])));
      u = u + t * n;
      held = held + t * dot(n, d);
      largest_m = largest(largest_m, length(d));
      sizes = sizes + t;
    }
    const Quad share = length(u) > s ? s / length(u) : Quad(1);
    const Vec3 x{static_cast<double>(foot_.x), static_cast<double>(foot_.y), static_cast<double>(foot_.z)};
    pull(share * u);
    epsilon_ = epsilon_ + held_j(s, stiffness_n_per_m, Quad(norm(way_out_by_all_faces(facets, x)))) - share * held;
    if (stiffness_n_per_m > 0.0) epsilon_ = epsilon_ + share * share * dot(u, u) / (2 * Quad(stiffness_n_per_m));
    const double size_n = s + static_cast<double>(sizes);
    rho_rounding_ += 4.0 * ulp * size_n;
    epsilon_rounding_ += size_n * (foot_ulp_m_ + 8.0 * ulp * static_cast<double>(largest_m));
  }

  /// The proven distance to the exact balance.
  double bound_m() const {
    Quad rho = length(left_);
    if (radius_m_ > 0.0) rho = root(rho * rho + dot(left_nm_, left_nm_) / (Quad(radius_m_) * radius_m_));
    return static_cast<double>((rho + root(rho * rho + 4 * k_ * largest(0, epsilon_))) / (2 * k_));
  }
  /// The part due to rounding: position and forces are doubles, and the bound has a root over both.
  double rounding_m() const {
    const auto k = static_cast<double>(k_);
    return rho_rounding_ / k + std::sqrt(epsilon_rounding_ / k);
  }

 private:
  /// Takes the force of a primitive from what is left.
  void pull(const Quad3& u) {
    left_ = left_ - u;
    left_nm_ = left_nm_ - cross(lever_, u);
  }

  Quad3 x_, turn_{}, lever_{};
  Quad3 foot_;
  Quad3 left_, left_nm_{};
  double radius_m_ = 0.0;  // 0: a point
  Quad k_, T_, epsilon_ = 0;
  double position_ulp_m_ = 0.0, foot_ulp_m_ = 0.0, rho_rounding_ = 0.0, epsilon_rounding_ = 0.0;
};

}  // namespace formula

using formula::BalanceFormula;

}  // namespace palpa::test
