#include "palpa/view/simplified.h"

#include <algorithm>
#include <bit>
#include <optional>
#include <utility>

namespace palpa::detail {
namespace {

constexpr std::uint32_t none = UINT32_MAX;
// [1] Weight of a triangle's corners beside its plane. More: equal triangles on flat and curved parts; less: slivers on flat
// ones.
constexpr double corner_weight = 1e-5;
// [1] Least cosine between a triangle's normals before and after a collapse. More: fewer collapses; less: folds.
constexpr double least_cosine = 0.2;

/// Sum of squared distances [m⁴] of a position to planes and points, each weighted by an area: x·Ax − 2 b·x + c, with a
/// symmetric A.
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
  /// Position with the least sum; not finite without one.
  Vec3 least_m() const noexcept {
    const Vec3 x = cross(a.row[1], a.row[2]), y = cross(a.row[2], a.row[0]), z = cross(a.row[0], a.row[1]);
    return Vec3{dot(x, b), dot(y, b), dot(z, b)} / dot(a.row[0], x);
  }
};

/// Edge that may be collapsed, unless one of its ends has changed since.
struct Edge {
  std::uint32_t a, b;
  std::uint32_t changes;  // of both ends
};

/// Edges by their costs, to an eighth: the last one put in first.
class Queue {
 public:
  void push(double cost, const Edge& edge) {
    const std::size_t level = std::bit_cast<std::uint32_t>(static_cast<float>(std::max(cost, 0.0))) >> 20;
    levels_[level].push_back(edge);
    first_ = std::min(first_, level);
  }
  std::optional<Edge> pop() {
    while (first_ < levels_.size() && levels_[first_].empty()) ++first_;
    if (first_ == levels_.size()) return {};
    const Edge edge = levels_[first_].back();
    levels_[first_].pop_back();
    return edge;
  }

 private:
  std::vector<std::vector<Edge>> levels_ = std::vector<std::vector<Edge>>(1 << 11);  // by exponent and 3 bits of a float
  std::size_t first_ = 0;                                                            // no edges below
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
        changes_(points_m_.size(), 0),
        mark_(points_m_.size(), 0) {
    for (std::uint32_t i = 0; i < like_.size(); ++i) like_[i] = i;
    for (std::uint32_t corner = 0; corner < next_.size(); ++corner)
      next_[corner] = std::exchange(first_[triangles_[corner / 3][corner % 3]], corner);
  }

  void reduce_to(std::size_t most) {
    if (left_ <= most) return;
    measure();
    while (left_ > most) {
      const std::optional<Edge> edge = edges_.pop();
      if (!edge) break;
      if (edge->changes == changes_[edge->a] + changes_[edge->b] && !is_merged(edge->a) && !is_merged(edge->b))
        collapse(edge->a, edge->b);
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
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      const Vec3 normal = normal_m2(t);
      const double area_m2 = 0.5 * norm(normal);
      for (const std::uint32_t corner : triangles_[t]) {
        quadrics_[corner].add(normalized(normal), points_m_[corner], area_m2);
        for (const Vec3& axis : Mat3::identity().row) quadrics_[corner].add(axis, points_m_[corner], corner_weight * area_m2);
      }
    }
    std::vector<std::array<std::uint32_t, 2>> sides;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
        bool is_border = true;
        each_triangle(b, [&](const Triangle& other, std::uint32_t at) { is_border = is_border && other[(at + 1) % 3] != a; });
        if (is_border) keep_border(a, b, t);
        if (is_border || a < b) sides.push_back({a, b});
      }
    for (const auto& [a, b] : sides) enqueue(a, b);
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
  /// Position with the least sum, or the middle where rounding leaves none near by.
  Vec3 best_m(const Quadric& quadric, std::uint32_t a, std::uint32_t b) const noexcept {
    const Vec3 best_m = quadric.least_m(), middle_m = 0.5 * (points_m_[a] + points_m_[b]);
    return norm_squared(best_m - middle_m) <= 4.0 * norm_squared(points_m_[a] - points_m_[b]) ? best_m : middle_m;
  }
  void enqueue(std::uint32_t a, std::uint32_t b) {
    const Quadric quadric = sum_of(a, b);
    edges_.push(quadric.at(best_m(quadric, a, b)), {a, b, changes_[a] + changes_[b]});
  }
  bool is_merged(std::uint32_t point) const noexcept { return first_[point] == none; }

  /// Whether a triangle of `point`, but none of `other`, would fold or vanish with its corner at `to_m`.
  bool folds(std::uint32_t point, std::uint32_t other, const Vec3& to_m) {
    bool any = false;
    each_triangle(point, [&](const Triangle& triangle, std::uint32_t corner) {
      if (any || has(triangle, other)) return;
      const Vec3 &b = points_m_[triangle[(corner + 1) % 3]], &c = points_m_[triangle[(corner + 2) % 3]];
      const Vec3 before = cross(b - points_m_[point], c - points_m_[point]), after = cross(b - to_m, c - to_m);
      const double both = dot(before, after), squares = norm_squared(before) * norm_squared(after);
      any = !(both >= 0.0 && both * both >= least_cosine * least_cosine * squares) || norm_squared(after) == 0.0;
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
    ++changes_[a];
    first_[b] = none;
    ++round_;
    mark_[a] = round_;
    each_triangle(a, [&](const Triangle& triangle, std::uint32_t) {
      for (const std::uint32_t corner : triangle) {
        if (std::exchange(mark_[corner], round_) == round_) continue;
        enqueue(a, corner);
      }
    });
  }

  const Mesh& given_;
  std::vector<Vec3> points_m_;
  std::vector<Triangle> triangles_;  // all corners alike: gone
  std::size_t left_;                 // [1] triangles
  std::vector<std::uint32_t> like_;
  std::vector<Quadric> quadrics_;       // by point
  std::vector<std::uint32_t> first_;    // by point: a corner of its triangles, numbered 3 * triangle + corner
  std::vector<std::uint32_t> next_;     // by corner: another one of its point
  std::vector<std::uint32_t> changes_;  // by point: collapses into it
  std::vector<std::uint32_t> mark_;     // by point: last round that met it
  std::uint32_t round_ = 0;
  Queue edges_;
};

}  // namespace

SimplerMesh simplified(const Mesh& surface, std::size_t most_triangles) {
  Simplifier simplifier(surface);
  simplifier.reduce_to(most_triangles);
  return simplifier.result();
}

}  // namespace palpa::detail
