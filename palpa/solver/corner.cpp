#include "palpa/solver/corner.h"

#include <algorithm>
#include <limits>

#include "palpa/solver/double2.h"
#include "palpa/solver/newton_form.h"

namespace palpa::detail {

namespace {

// [1] In exact arithmetic each step raises the proven distance, so that no face recurs; with rounding it could. More: a longer
// worst case; fewer: w may be returned before it is in front of all facets.
constexpr int max_steps = 64;
// [1] Sine below which a normal counts as spanned by the face. Less: division by rounding; more: facets at a small angle to
// each other count as equal.
constexpr double dependent = 1e-12;

}  // namespace

bool Face::take(int j, const Vec3& n) noexcept {
  if (size == 3) return false;
  Vec3 z = n;
  for (int i = 0; i < size; ++i) T[i][size] = 0.0;
  for (int pass = 0; pass < 2; ++pass) {
    for (int i = 0; i < size; ++i) {
      const double along = dot(q[i], z);
      T[i][size] += along;
      z -= along * q[i];
    }
  }
  const double length = std::sqrt(norm_squared(z));
  if (!(length > dependent)) return false;
  q[size] = (1.0 / length) * z;
  T[size][size] = length;
  facet[size++] = j;
  return true;
}

Vec3 Face::hull(const double* c) const noexcept {
  Vec3 w;
  double y[3];
  for (int j = 0; j < size; ++j) {
    y[j] = c[facet[j]];
    for (int i = 0; i < j; ++i) y[j] -= T[i][j] * y[i];
    y[j] /= T[j][j];
    w += y[j] * q[j];
  }
  return w;
}

void Face::shares(const Vec3& v, double* t) const noexcept {
  for (int i = size; i-- > 0;) {
    t[i] = dot(q[i], v);
    for (int j = i + 1; j < size; ++j) t[i] -= T[i][j] * t[j];
    t[i] /= T[i][i];
  }
}

double Face::inverse_norm() const noexcept {
  double squared = 0.0;
  for (int i = 0; i < size; ++i) {
    double t[3];
    shares(q[i], t);
    for (int j = 0; j < size; ++j) squared += t[j] * t[j];
  }
  return std::sqrt(squared);
}

namespace {

// State of `least_way` between its steps.
class Projection {
 public:
  Projection(std::span<const Vec3> normals, const double* c) noexcept : normals_(normals), c_(c) {
    for (std::size_t i = 0; i < normals.size(); ++i) largest_ = std::max(largest_, std::abs(c[i]));
  }

  LeastWay run(const Face& guess) noexcept {
    if (guess.size > 0) {
      face() = guess;
      compute_from_face();
      if (std::none_of(least_.t, least_.t + guess.size, [](double t) { return t < 0.0; }) && furthest_behind() < 0)
        return least_;
      least_ = {};
    }
    for (int j = furthest_behind(); j >= 0 && steps_ < max_steps; j = furthest_behind()) press(j);
    compute_from_face();
    for (int a = 0; a < face().size; ++a) least_.t[a] = std::max(0.0, least_.t[a]);
    return least_;
  }

 private:
  // From the face alone: the steps have accumulated rounding.
  void compute_from_face() noexcept {
    least_.w = face().hull(c_);
    face().shares(least_.w, least_.t);
  }

  Face& face() noexcept { return least_.face; }
  const Vec3& normal(int i) const noexcept { return normals_[static_cast<std::size_t>(i)]; }

  // Facet furthest from being satisfied, beyond rounding; -1: none.
  int furthest_behind() noexcept {
    int furthest = -1;
    double most = 4.0 * epsilon * (largest_ + size_of(least_.w));
    for (int i = 0; i < static_cast<int>(normals_.size()); ++i) {
      const double behind = c_[i] - dot(normal(i), least_.w);
      if (behind > most && std::find(face().facet, face().facet + face().size, i) == face().facet + face().size) {
        most = behind, furthest = i;
      }
    }
    return furthest;
  }

  // Moves w until facet j is satisfied, dropping facets whose share would become negative (they would pull).
  void press(int j) noexcept {
    constexpr double never = std::numeric_limits<double>::infinity();
    const Vec3& n = normal(j);
    double pressed = 0.0;
    for (; steps_ < max_steps; ++steps_) {
      Vec3 z = n - face().across(n);
      z -= face().across(z);
      double r[3];
      face().shares(n, r);
      double first = never;
      int blocking = -1;
      for (int a = 0; a < face().size; ++a) {
        if (r[a] > 0.0 && least_.t[a] < first * r[a]) first = least_.t[a] / r[a], blocking = a;
      }
      const double squared = norm_squared(z);
      const bool moves = face().size < 3 && squared > dependent * dependent;
      const double whole = moves ? (c_[j] - dot(n, least_.w)) / squared : never;
      if (!moves && blocking < 0) {
        least_.found = false;
        steps_ = max_steps;
        return;
      }
      const double step = std::max(0.0, std::min(first, whole));
      for (int a = 0; a < face().size; ++a) least_.t[a] -= step * r[a];
      pressed += step;
      if (moves) least_.w += step * z;
      if (whole <= first) {
        if (face().take(j, n)) least_.t[face().size - 1] = pressed;
        ++steps_;
        return;
      }
      drop(blocking);
    }
  }

  void drop(int blocking) noexcept {
    Face rest;
    int kept = 0;
    for (int a = 0; a < face().size; ++a) {
      if (a == blocking) continue;
      least_.t[kept++] = least_.t[a];
      rest.take(face().facet[a], normal(face().facet[a]));
    }
    face() = rest;
  }

  std::span<const Vec3> normals_;
  const double* c_;
  double largest_ = 0.0;
  LeastWay least_;
  int steps_ = 0;
};

}  // namespace

LeastWay least_way(std::span<const Vec3> normals, const double* c, const Face& guess) noexcept {
  return Projection(normals, c).run(guess);
}

double width_of(std::span<const Vec3> normals) noexcept {
  double ones[most_facets];
  std::fill_n(ones, normals.size(), 1.0);
  const LeastWay way = least_way(normals, ones);
  if (!way.found) return 0.0;
  const Vec3 e = normalized(way.w);
  double least = 1.0;
  for (const Vec3& n : normals) least = std::min(least, dot(n, e) - 4.0 * epsilon);
  return std::max(0.0, least);
}

bool can_take_facet(std::span<const Primitive> facets, const Vec3& normal) noexcept {
  if (facets.size() >= most_facets) return false;
  Vec3 normals[most_facets];
  for (std::size_t j = 0; j < facets.size(); ++j) normals[j] = facets[j].direction;
  normals[facets.size()] = normal;
  return width_of({normals, facets.size() + 1}) >= narrowest_corner;
}

Vec3 way_out(std::span<const Primitive> facets, const Vec3& x_m) noexcept {
  Vec3 normals[most_facets];
  double c[most_facets];
  for (std::size_t i = 0; i < facets.size(); ++i) {
    normals[i] = facets[i].direction;
    c[i] = slide(normals[i], facets[i].position_m, x_m).along;
  }
  return least_way({normals, facets.size()}, c).w;
}

}  // namespace palpa::detail
