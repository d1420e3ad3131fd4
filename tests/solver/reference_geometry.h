// Vectors of any floating point, and the nearest point free of facets.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "tests/solver/reference.h"

namespace palpa::test::reference {

template <class T>
T root(T x) {
  return x > T(0) ? static_cast<T>(std::sqrt(x)) : T(0);
}
#if defined(__SIZEOF_FLOAT128__)
// From the root in double: two corrections, each of which doubles the digits.
template <>
inline Quad root(Quad x) {
  if (!(x > 0)) return 0;
  if (x < Quad(1e-290)) return root(x * Quad(0x1p960)) * Quad(0x1p-480);
  if (x > Quad(1e290)) return root(x * Quad(0x1p-960)) * Quad(0x1p480);
  const double y = std::sqrt(static_cast<double>(x));
  const double half = 0.5 / y;
  Quad r = y;
  for (int i = 0; i < 2; ++i) r += (x - r * r) * half;
  return r;
}
#endif

template <class T>
struct V {
  T x{}, y{}, z{};
  V() = default;
  V(T a, T b, T c) : x(a), y(b), z(c) {}
  template <class S>
  explicit V(const V<S>& v) : x(v.x), y(v.y), z(v.z) {}
  explicit V(const Vec3& v) : x(v.x), y(v.y), z(v.z) {}
};
template <class T>
V<T> operator+(const V<T>& a, const V<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
V<T> operator-(const V<T>& a, const V<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
V<T> operator*(T f, const V<T>& a) {
  return {f * a.x, f * a.y, f * a.z};
}
template <class T>
T dot(const V<T>& a, const V<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
T length(const V<T>& a) {
  return root(dot(a, a));
}
template <class T>
T positive(T a) {
  return a > T(0) ? a : T(0);
}

template <class T>
V<T> unit(const Primitive& p) {
  const V<T> q(p.direction);
  return p.kind == PrimitiveKind::point ? V<T>{} : (T(1) / length(q)) * q;
}

template <class T>
V<T> across(const V<T>& q, const V<T>& a) {
  return a - dot(q, a) * q;
}

inline std::size_t end_of_corner(const std::vector<Primitive>& primitives, std::size_t i) {
  const Primitive& first = primitives[i];
  while (i < primitives.size() && primitives[i].kind == first.kind && primitives[i].id == first.id) ++i;
  return i;
}

// The least w with n·w ≥ c for all facets, w = Σ t n, t ≥ 0, by a dual active set whose faces are orthonormal bases: q spans
// the face, n_A = q T.
template <class T>
struct LeastWay {
  V<T> w;
  std::vector<T> t;
  std::vector<std::size_t> face;
  std::vector<V<T>> q;
};

template <class T>
T rounding_of();
template <>
inline double rounding_of<double>() {
  return 0x1p-52;
}
template <>
inline Quad rounding_of<Quad>() {
  return Quad(0x1p-112);
}

template <class T>
class Projection {
 public:
  Projection(const std::vector<V<T>>& normals, const std::vector<T>& c) : n_(normals), c_(c), t_(normals.size(), T(0)) {}

  LeastWay<T> least_way() {
    for (int round = 0; round < 100; ++round) {
      const std::size_t j = furthest_behind();
      if (j == n_.size() || !press(j)) break;
    }
    settle();
    return {w_, t_, face_, q_};
  }

 private:
  std::size_t furthest_behind() const {
    T scale = length(w_);
    for (const T& c : c_) scale = std::max(scale, c > T(0) ? c : -c);
    T most = T(16) * rounding_of<T>() * scale;
    std::size_t worst = n_.size();
    for (std::size_t i = 0; i < n_.size(); ++i) {
      const T behind = c_[i] - dot(n_[i], w_);
      if (behind > most && std::find(face_.begin(), face_.end(), i) == face_.end()) most = behind, worst = i;
    }
    return worst;
  }

  // Components of `v` along the basis, and its rest.
  std::vector<T> parts(V<T>& v) const {
    std::vector<T> along(q_.size(), T(0));
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t i = 0; i < q_.size(); ++i) {
        const T part = dot(q_[i], v);
        along[i] += part;
        v = v - part * q_[i];
      }
    }
    return along;
  }
  std::vector<T> shares(std::vector<T> along) const {
    for (std::size_t i = along.size(); i-- > 0;) {
      for (std::size_t j = i + 1; j < along.size(); ++j) along[i] -= columns_[j][i] * along[j];
      along[i] /= columns_[i][i];
    }
    return along;
  }
  bool span(std::size_t j) {
    V<T> z = n_[j];
    std::vector<T> column = parts(z);
    const T beyond = length(z);
    if (face_.size() == 3 || !(beyond > independent())) return false;
    column.push_back(beyond);
    columns_.push_back(column);
    q_.push_back((T(1) / beyond) * z);
    face_.push_back(j);
    return true;
  }
  static T independent() { return T(1e4) * rounding_of<T>(); }

  // Presses facet j until it is reached, and drops facets that would have to pull; false if it is unreachable.
  bool press(std::size_t j) {
    T pressed(0);
    for (int round = 0; round < 20; ++round) {
      V<T> z = n_[j];
      const std::vector<T> r = shares(parts(z));
      const bool moves = face_.size() < 3 && length(z) > independent();
      std::size_t blocking = face_.size();
      for (std::size_t a = 0; a < face_.size(); ++a) {
        if (!(r[a] > T(0))) continue;
        if (blocking == face_.size() || t_[face_[a]] * r[blocking] < t_[face_[blocking]] * r[a]) blocking = a;
      }
      const bool blocked = blocking < face_.size();
      if (!moves && !blocked) return false;
      T step = moves ? (c_[j] - dot(n_[j], w_)) / dot(z, z) : t_[face_[blocking]] / r[blocking];
      const bool reaches = moves && !(blocked && t_[face_[blocking]] < step * r[blocking]);
      if (!reaches) step = t_[face_[blocking]] / r[blocking];
      for (std::size_t a = 0; a < face_.size(); ++a) t_[face_[a]] -= step * r[a];
      pressed += step;
      if (moves) w_ = w_ + step * z;
      if (reaches) {
        t_[j] = pressed;
        return span(j);
      }
      std::vector<std::size_t> rest = face_;
      t_[rest[blocking]] = T(0);
      rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(blocking));
      face_.clear(), q_.clear(), columns_.clear();
      for (const std::size_t i : rest) span(i);
    }
    return false;
  }

  void settle() {
    std::vector<T> y;
    w_ = {};
    for (std::size_t j = 0; j < face_.size(); ++j) {
      T rest = c_[face_[j]];
      for (std::size_t i = 0; i < j; ++i) rest -= columns_[j][i] * y[i];
      y.push_back(rest / columns_[j][j]);
      w_ = w_ + y[j] * q_[j];
    }
    const std::vector<T> t = shares(y);
    std::fill(t_.begin(), t_.end(), T(0));
    for (std::size_t a = 0; a < face_.size(); ++a) t_[face_[a]] = positive(t[a]);
  }

  const std::vector<V<T>>& n_;
  const std::vector<T>& c_;
  std::vector<T> t_;
  V<T> w_;
  std::vector<std::size_t> face_;
  std::vector<V<T>> q_;
  std::vector<std::vector<T>> columns_;
};

}  // namespace palpa::test::reference
