#include "palpa/view/simplified.h"

#include <algorithm>
#include <functional>
#include <tuple>
#include <utility>

namespace palpa::detail {
namespace {

constexpr std::uint32_t none = UINT32_MAX;
// [1] Weight of a triangle's corners beside its plane. More: equal triangles on flat and curved parts; less: slivers on flat
// ones.
constexpr double corner_weight = 1e-5;
// [1] Least cosine between a triangle's normals before and after a collapse. More: fewer collapses; less: folds.
constexpr double least_cosine = 0.2;

/// Sum of squared distances [m⁴] of a position to planes and points, each weighted by an area: x·Ax − 2 b·x + c.
struct Quadric {
  Mat3 a;
  Vec3 b;
  double c = 0.0;

  void add(const Vec3& normal, const Vec3& on_m, double weight_m2) noexcept {
    const double d = dot(normal, on_m);
    a.row[0] += weight_m2 * normal.x * normal;
    a.row[1] += weight_m2 * normal.y * normal;
    a.row[2] += weight_m2 * normal.z * normal;
    b += weight_m2 * d * normal;
    c += weight_m2 * d * d;
  }
  Quadric& operator+=(const Quadric& other) noexcept {
    for (int i = 0; i < 3; ++i) a.row[i] += other.a.row[i];
    b += other.b;
    c += other.c;
    return *this;
  }
  double at(const Vec3& x_m) const noexcept { return dot(x_m, a * x_m) - 2.0 * dot(b, x_m) + c; }
};

class Simplifier {
 public:
  explicit Simplifier(const Mesh& surface)
      : given_(surface),
        points_m_(surface.points_m),
        triangles_(surface.triangles),
        left_(surface.triangles.size()),
        like_(points_m_.size()),
        first_(points_m_.size(), none),
        next_(3 * triangles_.size()),
        stamp_(points_m_.size(), 0),
        mark_(points_m_.size(), 0) {
    for (std::uint32_t i = 0; i < like_.size(); ++i) like_[i] = i;
    for (std::uint32_t corner = 0; corner < next_.size(); ++corner)
      next_[corner] = std::exchange(first_[triangles_[corner / 3][corner % 3]], corner);
  }

  void reduce_to(std::size_t most) {
    if (left_ <= most) return;
    measure();
    while (left_ > most && !edges_.empty()) {
      std::ranges::pop_heap(edges_, later);
      const Edge edge = edges_.back();
      edges_.pop_back();
      if (edge.stamp == stamp_[edge.a] + std::uint64_t{stamp_[edge.b]}) collapse(edge.a, edge.b);
    }
  }

  SimplerMesh result() const {
    SimplerMesh mesh;
    std::vector<std::uint32_t> number(points_m_.size(), none);
    for (const auto& triangle : triangles_) {
      if (is_gone(triangle)) continue;
      std::array<std::uint32_t, 3>& corners = mesh.triangles.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        std::uint32_t& at = number[triangle[k]];
        if (at == none) {
          at = static_cast<std::uint32_t>(mesh.points_m.size());
          mesh.points_m.push_back(points_m_[triangle[k]]);
          mesh.like.push_back(like_[triangle[k]]);
        }
        corners[k] = at;
      }
    }
    return mesh;
  }

 private:
  using Triangle = std::array<std::uint32_t, 3>;

  /// Edge that may be collapsed, unless one of its ends has changed since.
  struct Edge {
    double cost;
    std::uint32_t a, b;
    std::uint64_t stamp;
  };
  static bool later(const Edge& x, const Edge& y) noexcept { return std::tie(x.cost, x.a, x.b) > std::tie(y.cost, y.a, y.b); }
  static bool is_gone(const Triangle& triangle) noexcept { return triangle[0] == triangle[1]; }

  /// Triangles of a point; those that are gone are unlinked.
  template <class Act>
  void each_triangle(std::uint32_t point, const Act& act) {
    for (std::uint32_t* at = &first_[point]; *at != none;) {
      const Triangle& triangle = triangles_[*at / 3];
      if (is_gone(triangle)) {
        *at = next_[*at];
      } else {
        act(triangle, *at % 3);
        at = &next_[*at];
      }
    }
  }
  static bool has(const Triangle& triangle, std::uint32_t point) noexcept {
    return triangle[0] == point || triangle[1] == point || triangle[2] == point;
  }

  void measure() {
    quadrics_.resize(points_m_.size());
    std::vector<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> sides;  // ends in order, and triangle
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      const Triangle& corner = triangles_[t];
      const Vec3 twice_m2 = normal_m2(t);
      const double area_m2 = 0.5 * norm(twice_m2);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& p = points_m_[corner[k]];
        Quadric& quadric = quadrics_[corner[k]];
        quadric.add(normalized(twice_m2), p, area_m2);
        for (const Vec3& axis : Mat3::identity().row) quadric.add(axis, p, corner_weight * area_m2);
        const std::uint32_t other = corner[(k + 1) % 3];
        sides.emplace_back(std::min(corner[k], other), std::max(corner[k], other), t);
      }
    }
    std::ranges::sort(sides);
    for (std::size_t i = 0, end = 0; i < sides.size(); i = end) {
      const auto& [a, b, t] = sides[i];
      while (end < sides.size() && std::get<0>(sides[end]) == a && std::get<1>(sides[end]) == b) ++end;
      if (end == i + 1) keep_border(a, b, t);
    }
    edges_.reserve(2 * sides.size());
    for (std::size_t i = 0; i < sides.size(); ++i) {
      const auto& [a, b, t] = sides[i];
      if (i == 0 || std::get<0>(sides[i - 1]) != a || std::get<1>(sides[i - 1]) != b) edges_.push_back(edge_of(a, b));
    }
    std::ranges::make_heap(edges_, later);
  }

  Vec3 normal_m2(std::uint32_t t) const noexcept {
    const auto& [a, b, c] = triangles_[t];
    return cross(points_m_[b] - points_m_[a], points_m_[c] - points_m_[a]);
  }

  /// Adds the plane through an edge of one triangle, across that.
  void keep_border(std::uint32_t a, std::uint32_t b, std::uint32_t t) {
    const Vec3 edge_m = points_m_[b] - points_m_[a];
    const Vec3 across = normalized(cross(edge_m, normal_m2(t)));
    for (const std::uint32_t end : {a, b}) quadrics_[end].add(across, points_m_[a], norm_squared(edge_m));
  }

  Quadric sum_of(std::uint32_t a, std::uint32_t b) const noexcept { return Quadric(quadrics_[a]) += quadrics_[b]; }
  /// Position with the least sum; the middle where rounding leaves none.
  Vec3 best_m(const Quadric& quadric, std::uint32_t a, std::uint32_t b) const noexcept {
    const Vec3 best_m = inverse(quadric.a) * quadric.b, middle_m = 0.5 * (points_m_[a] + points_m_[b]);
    return distance(best_m, middle_m) <= 2.0 * distance(points_m_[a], points_m_[b]) ? best_m : middle_m;
  }
  Edge edge_of(std::uint32_t a, std::uint32_t b) const noexcept {
    const Quadric quadric = sum_of(a, b);
    return {quadric.at(best_m(quadric, a, b)), a, b, stamp_[a] + std::uint64_t{stamp_[b]}};
  }

  /// Whether a triangle of `point`, but none of `other`, would fold or vanish with its corner at `to_m`.
  bool folds(std::uint32_t point, std::uint32_t other, const Vec3& to_m) {
    bool any = false;
    each_triangle(point, [&](const Triangle& triangle, std::uint32_t corner) {
      if (any || has(triangle, other)) return;
      const Vec3 &b = points_m_[triangle[(corner + 1) % 3]], &c = points_m_[triangle[(corner + 2) % 3]];
      const Vec3 before = cross(b - points_m_[point], c - points_m_[point]), after = cross(b - to_m, c - to_m);
      any = !(dot(before, after) >= least_cosine * norm(before) * norm(after)) || norm_squared(after) == 0.0;
    });
    return any;
  }

  /// Whether the ends have a common neighbour beyond those of the edge's triangles: the surface would touch itself.
  bool pinches(std::uint32_t a, std::uint32_t b) {
    ++round_;
    int common = 0, shared = 0;
    each_triangle(a, [&](const Triangle& triangle, std::uint32_t) {
      shared += has(triangle, b);
      for (const std::uint32_t corner : triangle) mark_[corner] = round_;
    });
    mark_[a] = mark_[b] = 0;
    each_triangle(b, [&](const Triangle& triangle, std::uint32_t) {
      for (const std::uint32_t corner : triangle) common += std::exchange(mark_[corner], 0) == round_;
    });
    return common != shared;
  }

  /// Moves `b` into `a`, at the best position of both.
  void collapse(std::uint32_t a, std::uint32_t b) {
    const Quadric quadric = sum_of(a, b);
    const Vec3 to_m = best_m(quadric, a, b);
    if (folds(a, b, to_m) || folds(b, a, to_m) || pinches(a, b)) return;
    points_m_[a] = to_m;
    quadrics_[a] = quadric;
    if (distance(given_.points_m[like_[b]], to_m) < distance(given_.points_m[like_[a]], to_m)) like_[a] = like_[b];
    std::uint32_t* end = &first_[a];
    while (*end != none) end = &next_[*end];
    *end = first_[b];
    for (std::uint32_t corner = first_[b]; corner != none; corner = next_[corner]) {
      Triangle& triangle = triangles_[corner / 3];
      if (has(triangle, a)) triangle.fill(a), --left_;
      triangle[corner % 3] = a;
    }
    ++stamp_[a];
    stamp_[b] = none;
    ++round_;
    mark_[a] = round_;
    each_triangle(a, [&](const Triangle& triangle, std::uint32_t) {
      for (const std::uint32_t corner : triangle) {
        if (std::exchange(mark_[corner], round_) == round_) continue;
        edges_.push_back(edge_of(a, corner));
        std::ranges::push_heap(edges_, later);
      }
    });
  }

  const Mesh& given_;
  std::vector<Vec3> points_m_;
  std::vector<Triangle> triangles_;  // all corners alike: gone
  std::size_t left_;                 // [1] triangles
  std::vector<std::uint32_t> like_;
  std::vector<Quadric> quadrics_;     // by point
  std::vector<std::uint32_t> first_;  // by point: a corner of its triangles, numbered 3 * triangle + corner
  std::vector<std::uint32_t> next_;   // by corner: another one of its point
  std::vector<std::uint32_t> stamp_;  // by point: changes; none: it is gone
  std::vector<std::uint32_t> mark_;   // by point: last round that met it
  std::uint32_t round_ = 0;
  std::vector<Edge> edges_;  // heap
};

}  // namespace

SimplerMesh simplified(const Mesh& surface, std::size_t most_triangles) {
  Simplifier simplifier(surface);
  simplifier.reduce_to(most_triangles);
  return simplifier.result();
}

}  // namespace palpa::detail
