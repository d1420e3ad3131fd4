#include "tests/solver/problem_families.h"

#include <algorithm>

#include "palpa/solver/corner.h"

namespace palpa::test {

namespace {

// Shared state of one problem's primitives while it is made.
struct Maker {
  Random& random;
  bool drags;
  Problem problem;
  Vec3 axis = random.direction();
  Vec3 places_m[3];  // of coincident primitives

  // Problems made from their balance: the forces determine the probe at the end.
  bool from_balance = false;
  Vec3 balance_m;
  Vec3 held_n;
};

double strength(Random& random) { return random.uniform(0, 5); }
PrimitiveKind kind_that_holds(Random& random) { return static_cast<PrimitiveKind>(random.below(3)); }
PrimitiveKind any_kind(Random& random) { return random.below(12) == 0 ? PrimitiveKind::directed : kind_that_holds(random); }

// Modes place most primitives at the proxy.
Vec3 near_start(Maker& m, double most_m) {
  return m.problem.start_m + (m.random.below(2) == 0 ? Vec3{} : m.random.in_cube(most_m));
}

void add(Maker& m, PrimitiveKind kind, const Vec3& position_m, const Vec3& direction, double strength_n) {
  Primitive p{kind, {}, position_m, kind == PrimitiveKind::point ? Vec3{} : direction, strength_n, 0.0};
  p.id.slot = static_cast<std::uint16_t>(m.problem.primitives.size());
  if (kind == PrimitiveKind::directed) {
    p.position_m = {};
    p.strength_n *= 0.2;
  } else if (m.drags && m.random.below(2) == 0) {
    p.position_m = m.problem.start_m;
    const int which = m.random.below(6);
    p.drag_ns_per_m = which == 0 ? 1e-9 : which == 1 ? 1e5 : m.random.uniform(0, 20);
  }
  m.problem.primitives.push_back(p);
}

// Adds a primitive that exerts `force_n` at the balance: it passes through `balance_m + off_m`.
void add_holding(Maker& m, PrimitiveKind kind, const Vec3& direction, double strength_n, const Vec3& force_n,
                 const Vec3& off_m = {}) {
  Vec3 position_m = m.balance_m + off_m;
  if (m.random.below(2) == 0) {  // slid along itself without effect
    const double slide_m = m.random.uniform(-0.002, 0.002);
    if (kind == PrimitiveKind::line) position_m += slide_m * direction;
    if (kind == PrimitiveKind::plane) position_m += slide_m * normalized(cross(direction, m.random.direction()));
  }
  add(m, kind, position_m, direction, strength_n);
  m.held_n += force_n;
}

// A force of length `size_n` in the span of that kind and direction.
Vec3 force_in_span(Random& random, PrimitiveKind kind, const Vec3& direction, double size_n) {
  if (kind == PrimitiveKind::plane) return size_n * direction;
  if (kind == PrimitiveKind::line) return size_n * normalized(cross(direction, random.direction()));
  return size_n * random.direction();
}

void begin(Maker& m, double softest_n_per_m, double stiffest_n_per_m, double reach_m) {
  m.problem.start_m = m.random.in_cube(0.05);
  m.problem.stiffness_n_per_m = m.random.log_uniform(softest_n_per_m, stiffest_n_per_m);
  m.problem.probe_m = m.problem.start_m + m.random.in_cube(reach_m);
  for (Vec3& place_m : m.places_m) place_m = near_start(m, 0.003);
  m.balance_m = m.problem.start_m + (m.drags || m.random.below(2) == 0 ? Vec3{} : m.random.in_cube(0.002));
}
void begin_haptic(Maker& m) { begin(m, 300, 3000, 0.004); }
void begin_random(Maker& m) { begin(m, 300, 3000, 0.02); }
void begin_stiff(Maker& m) {
  begin(m, 1e6, 1e9, 0.004);
  // Half of them move as far as a hand's force moves it on this spring.
  if (m.random.below(2) == 0) m.problem.probe_m = m.problem.start_m + m.random.in_cube(10.0 / m.problem.stiffness_n_per_m);
}
void begin_soft(Maker& m) { begin(m, 1, 30, m.random.below(2) == 0 ? 0.004 : 0.2); }
void begin_at_probe(Maker& m) {
  begin_haptic(m);
  if (m.random.below(4) == 0) m.problem.probe_m = m.problem.start_m;
}
void begin_from_balance(Maker& m) {
  begin_haptic(m);
  m.from_balance = true;
}
void begin_from_balance_at_start(Maker& m) {
  begin_from_balance(m);
  m.balance_m = m.problem.start_m;
}
void begin_exact(Maker& m) {
  begin_haptic(m);
  // Numbers of few digits, so that probe + directed/k has no rounding.
  const auto rounded = [](const Vec3& a) {
    return Vec3{std::round(a.x * 0x1p24) * 0x1p-24, std::round(a.y * 0x1p24) * 0x1p-24, std::round(a.z * 0x1p24) * 0x1p-24};
  };
  m.problem.stiffness_n_per_m = 512;
  m.problem.start_m = rounded(m.problem.start_m);
  m.problem.probe_m = m.drags ? m.problem.start_m : rounded(m.problem.probe_m);
}

void add_random(Maker& m) {
  add(m, any_kind(m.random), m.problem.start_m + m.random.in_cube(0.05), m.random.direction(), strength(m.random));
}
void add_haptic(Maker& m) { add(m, any_kind(m.random), near_start(m, 0.001), m.random.direction(), strength(m.random)); }
void add_at_start(Maker& m) { add(m, any_kind(m.random), m.problem.start_m, m.random.direction(), strength(m.random)); }
void add_parallel_plane(Maker& m) {
  const Vec3 q = m.random.below(2) == 0 ? m.axis : -m.axis;
  add(m, PrimitiveKind::plane, near_start(m, 0.003), q, strength(m.random));
}
void add_coincident(Maker& m) {
  const Vec3& place_m = m.places_m[m.random.below(3)];
  const Vec3 q = m.random.below(2) == 0 ? m.axis : -m.axis;
  add(m, m.random.below(2) == 0 ? PrimitiveKind::point : PrimitiveKind::line, place_m, q, strength(m.random));
}
Vec3 nearly_along_axis(Maker& m) { return normalized(m.axis + m.random.log_uniform(1e-9, 1e-2) * m.random.direction()); }
void add_nearly_parallel_line(Maker& m) {
  add(m, PrimitiveKind::line, near_start(m, 0.003), nearly_along_axis(m), strength(m.random));
}
void add_nearly_parallel_plane(Maker& m) {
  const Vec3 q = nearly_along_axis(m);
  add(m, PrimitiveKind::plane, near_start(m, 0.003), m.random.below(2) == 0 ? q : -q, strength(m.random));
}
void add_zero_or_not(Maker& m) {
  const double s = m.problem.primitives.size() % 2 == 0 ? 0.0 : strength(m.random);
  add(m, any_kind(m.random), near_start(m, 0.003), m.random.direction(), s);
}
void add_zero(Maker& m) { add(m, any_kind(m.random), near_start(m, 0.003), m.random.direction(), 0.0); }
void add_wide(Maker& m) {
  add(m, any_kind(m.random), near_start(m, 0.003), m.random.direction(), m.random.log_uniform(1e-6, 1e3));
}
void add_through_probe(Maker& m) {
  const PrimitiveKind kind = kind_that_holds(m.random);
  const Vec3 q = m.random.direction();
  Vec3 position_m = m.problem.probe_m;
  if (kind == PrimitiveKind::line && m.random.below(2) == 0) position_m += m.random.uniform(-0.003, 0.003) * q;
  add(m, kind, position_m, q, strength(m.random));
}
void add_stiff(Maker& m) {
  const double reach_m = m.random.below(2) == 0 ? 0.003 : 10.0 / m.problem.stiffness_n_per_m;
  add(m, any_kind(m.random), near_start(m, reach_m), m.random.direction(), strength(m.random));
}
void add_far(Maker& m) {
  const PrimitiveKind kind = any_kind(m.random);
  const Vec3 q = m.random.direction();
  const double far_m = m.random.log_uniform(1e-3, 1e3);
  Vec3 away = m.random.direction();
  if (m.random.below(2) == 0) {  // its anchor alone is far; it passes close by
    if (kind == PrimitiveKind::line) away = q;
    if (kind == PrimitiveKind::plane) away = normalized(cross(q, away));
  }
  add(m, kind, m.problem.start_m + far_m * away, q, strength(m.random));
}
void add_at_threshold(Maker& m) {
  constexpr double offs[] = {0.0, 1e-12, -1e-12};
  const PrimitiveKind kind = kind_that_holds(m.random);
  const Vec3 q = m.random.direction();
  const double s = strength(m.random);
  add_holding(m, kind, q, s, force_in_span(m.random, kind, q, s * (1.0 + offs[m.random.below(3)])));
}
void add_conflicting(Maker& m) {
  const Vec3 q = normalized(m.axis + m.random.log_uniform(1e-3, 0.5) * m.random.direction());
  const bool even = m.problem.primitives.size() % 2 == 0;
  // Each of the two sides demands a proxy beyond itself, by up to some millimetres.
  const double beyond_m = m.random.uniform(-0.0005, 0.003);
  const Vec3 position_m = m.problem.start_m + (even ? beyond_m : -beyond_m) * m.axis;
  add(m, PrimitiveKind::plane, position_m, even ? q : -q, strength(m.random));
}
void add_soft(Maker& m) { add(m, any_kind(m.random), near_start(m, 0.003), m.random.direction(), strength(m.random)); }

void begin_mixture(Maker& m) {
  switch (m.random.below(3)) {
    case 0: begin_haptic(m); break;
    case 1: begin_stiff(m); break;
    default: begin_soft(m); break;
  }
}
void add_any(Maker& m) {
  constexpr void (*ways[])(Maker&) = {add_random,
                                      add_haptic,
                                      add_parallel_plane,
                                      add_coincident,
                                      add_nearly_parallel_line,
                                      add_nearly_parallel_plane,
                                      add_zero,
                                      add_wide,
                                      add_through_probe,
                                      add_stiff,
                                      add_far,
                                      add_at_threshold,
                                      add_conflicting};
  ways[m.random.below(std::size(ways))](m);
}

void add_where_demanded(Maker& m) {
  Problem& problem = m.problem;
  // One directed force in front moves the demand by an exact 2^-11 m.
  if (problem.primitives.empty() && m.random.below(2) == 0) {
    add(m, PrimitiveKind::directed, {}, {0, 0, 1}, 0.0);
    problem.primitives.back().strength_n = 0.25;
    return;
  }
  Vec3 demand_m = problem.probe_m;
  for (const Primitive& p : problem.primitives) {
    if (p.kind == PrimitiveKind::directed) demand_m += p.strength_n / problem.stiffness_n_per_m * p.direction;
  }
  add(m, kind_that_holds(m.random), demand_m, m.random.direction(), strength(m.random));
}
void add_meeting(Maker& m) {
  const double s = strength(m.random);
  const Vec3 q = m.random.direction();
  const std::size_t before = m.problem.primitives.size();
  if (before < 2 || (before == 2 && m.random.below(2) == 0)) {
    add_holding(m, PrimitiveKind::plane, q, s, m.random.uniform(0.0, 1.0) * s * q);
    return;
  }
  // The others are away from the balance: slipping at full strength, or planes left behind.
  if (m.random.below(3) == 0) {
    add_holding(m, PrimitiveKind::plane, q, s, {}, -m.random.uniform(1e-4, 0.003) * q);
    return;
  }
  const PrimitiveKind kind = kind_that_holds(m.random);
  const Vec3 force_n = force_in_span(m.random, kind, q, s);
  add_holding(m, kind, q, s, force_n, m.random.uniform(1e-4, 0.003) / std::max(s, 1e-9) * force_n);
}
void add_sticking(Maker& m) {
  const PrimitiveKind kind = kind_that_holds(m.random);
  const Vec3 q = m.random.direction();
  const double s = strength(m.random);
  add_holding(m, kind, q, s, force_in_span(m.random, kind, q, m.random.uniform(0.1, 0.9) * s));
}
void add_opposed(Maker& m) {
  const std::size_t i = m.problem.primitives.size();
  if (i % 2 == 1) {
    const Primitive facing = m.problem.primitives.back();
    const Vec3 apart_m = m.random.below(3) == 0 ? Vec3{} : m.random.uniform(-0.002, 0.002) * facing.direction;
    add(m, PrimitiveKind::plane, facing.position_m + apart_m, -facing.direction, facing.strength_n);
    return;
  }
  add(m, PrimitiveKind::plane, near_start(m, 0.002), m.random.direction(), strength(m.random));
}
void add_twice(Maker& m) {
  const std::size_t i = m.problem.primitives.size();
  if (i % 2 == 0) return add_haptic(m);
  Primitive again = m.problem.primitives.back();
  again.id.slot = static_cast<std::uint16_t>(i);
  m.problem.primitives.push_back(again);
}
void add_in_corner(Maker& m) {
  constexpr PrimitiveKind order[] = {PrimitiveKind::plane, PrimitiveKind::plane, PrimitiveKind::line,
                                     PrimitiveKind::line,  PrimitiveKind::point, PrimitiveKind::plane};
  const std::size_t i = m.problem.primitives.size() % std::size(order);
  const PrimitiveKind kind = order[i];
  const Vec3 q = i == 0 ? m.axis : i == 1 ? -m.axis : m.random.direction();
  const double s = m.random.uniform(0.5, 5);
  add(m, kind, m.problem.start_m, q, s);
  m.held_n += force_in_span(m.random, kind, q, m.random.uniform(0.0, 0.8) * s);
}

// Nearly all primitives slip if their sum cannot hold the probe back.
void weaken(Problem& problem, Random& random) {
  double sum_n = 0.0;
  for (const Primitive& p : problem.primitives) sum_n += p.strength_n;
  const double demanded_n = problem.stiffness_n_per_m * distance(problem.probe_m, problem.start_m);
  const double most_n = random.uniform(0.2, 0.9) * demanded_n;
  if (!(sum_n > most_n)) return;
  for (Primitive& p : problem.primitives) p.strength_n *= most_n / sum_n;
}

template <void (*start)(Maker&), void (*add_one)(Maker&)>
Problem make(Random& random, int n, bool drags) {
  Maker m{random, drags, {}};
  start(m);
  m.problem.primitives.reserve(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) add_one(m);
  if (m.from_balance) m.problem.probe_m = m.balance_m - m.held_n / m.problem.stiffness_n_per_m;
  return m.problem;
}

Problem make_slipping(Random& random, int n, bool drags) {
  Problem problem = make<begin_haptic, add_haptic>(random, n, drags);
  weaken(problem, random);
  return problem;
}

// Corners. Each adding function gets the largest number of facets, and leaves out facets that would make the corner too narrow.
class CornerMaker {
 public:
  CornerMaker(Maker& m, int most, double strength_n)
      : problem_(m.problem),
        most_(std::min<std::size_t>(static_cast<std::size_t>(most), most_facets)),
        slot_(static_cast<std::uint16_t>(m.problem.primitives.size())),
        strength_n_(strength_n) {}

  void add(const Vec3& position_m, const Vec3& normal) {
    if (normals_.size() == most_) return;
    normals_.push_back(normal);
    if (detail::width_of(normals_) < 1.001 * narrowest_corner) return normals_.pop_back();
    problem_.primitives.push_back({PrimitiveKind::corner, {0, slot_}, position_m, normal, strength_n_, 0.0});
  }
  const std::vector<Vec3>& normals() const { return normals_; }

 private:
  Problem& problem_;
  std::size_t most_;
  std::uint16_t slot_;
  double strength_n_;
  std::vector<Vec3> normals_;
};

Vec3 about(Maker& m, const Vec3& axis) { return normalized(axis + m.random.log_uniform(0.3, 10.0) * m.random.direction()); }
int facets_of(Maker& m, int least) { return least + m.random.below(static_cast<int>(most_facets) + 1 - least); }

void add_random_corner_of(Maker& m, int most, double strength_n) {
  CornerMaker corner(m, most, strength_n);
  const Vec3 axis = m.random.direction();
  for (int i = facets_of(m, 1); i > 0; --i) corner.add(near_start(m, 0.001), about(m, axis));
}
void add_random_corner(Maker& m, int most) { add_random_corner_of(m, most, strength(m.random)); }
void add_wide_corner(Maker& m, int most) { add_random_corner_of(m, most, m.random.log_uniform(1e-5, 1e3)); }

void add_groove_of(Maker& m, int most, double opening_rad) {
  CornerMaker corner(m, most, strength(m.random));
  const Vec3 out = m.random.direction();
  const Vec3 side = normalized(cross(out, m.random.direction()));
  const Vec3 edge_m = near_start(m, 0.001);
  for (const double sign : {1.0, -1.0}) {
    corner.add(edge_m, normalized(std::sin(0.5 * opening_rad) * out + sign * std::cos(0.5 * opening_rad) * side));
  }
}
constexpr double degree = 3.14159265358979323846 / 180.0;
void add_groove(Maker& m, int most) { add_groove_of(m, most, m.random.uniform(1.0, 150.0) * degree); }
void add_narrow(Maker& m, int most) { add_groove_of(m, most, m.random.log_uniform(0.12, 3.0) * degree); }

void add_pit(Maker& m, int most) {
  CornerMaker corner(m, most, strength(m.random));
  const Vec3 axis = m.random.direction(), apex_m = near_start(m, 0.001);
  for (int i = facets_of(m, 3); i > 0; --i) corner.add(apex_m, about(m, axis));
}
void add_nearly_parallel_facets(Maker& m, int most) {
  CornerMaker corner(m, most, strength(m.random));
  for (int i = facets_of(m, 2); i > 0; --i) corner.add(near_start(m, 0.001), nearly_along_axis(m));
}
void add_corner_at_start(Maker& m, int most) {
  CornerMaker corner(m, std::max(1, most - 1), strength(m.random));
  const Vec3 axis = m.random.direction();
  for (int i = facets_of(m, 1); i > 0; --i) corner.add(m.problem.start_m, about(m, axis));
  if (most == 1) return;
  // Its friction, along a facet's normal or between two.
  const Vec3 q = m.random.below(2) == 0 ? corner.normals().back() : normalized(corner.normals().front() + 0.5 * axis);
  add(m, PrimitiveKind::line, m.problem.start_m, q, 0.3 * strength(m.random));
}
void add_duplicated_corner(Maker& m, int most) {
  CornerMaker corner(m, most, strength(m.random));
  const Vec3 axis = m.random.direction();
  for (int i = facets_of(m, 1); i > 0; --i) {
    const Vec3 position_m = near_start(m, 0.001), normal = about(m, axis);
    for (int twice = 0; twice < 1 + m.random.below(2); ++twice) corner.add(position_m, normal);
  }
  const auto added = static_cast<std::ptrdiff_t>(corner.normals().size());
  if (2 * added > most || m.random.below(2) == 0) return;
  std::vector<Primitive> again(m.problem.primitives.end() - added, m.problem.primitives.end());
  for (Primitive& facet : again) facet.id.slot = static_cast<std::uint16_t>(m.problem.primitives.size());
  m.problem.primitives.insert(m.problem.primitives.end(), again.begin(), again.end());
}

// A corner with its vertex at the balance, where it exerts `share` of its strength: along a facet's normal, on the border of
// the faces beside it, or between up to three.
void add_holding_corner(Maker& m, int most, double share, bool on_border) {
  const double s = strength(m.random);
  CornerMaker corner(m, most, s);
  const Vec3 axis = m.random.direction();
  for (int i = facets_of(m, 2); i > 0; --i) corner.add(m.balance_m, about(m, axis));
  Vec3 along;
  for (std::size_t i = 0; i < std::min<std::size_t>(corner.normals().size(), on_border ? 1 : 3); ++i) {
    along += m.random.uniform(0.1, 1.0) * corner.normals()[i];
  }
  m.held_n += share * s * normalized(along);
}
void add_corner_at_yield(Maker& m, int most) {
  constexpr double offs[] = {0.0, 1e-12, -1e-12};
  add_holding_corner(m, most, 1.0 + offs[m.random.below(3)], m.random.below(2) == 0);
}
void add_corner_on_border(Maker& m, int most) { add_holding_corner(m, most, m.random.uniform(0.1, 1.5), true); }

using AddCorner = void (*)(Maker&, int most);
void add_any_corner(Maker& m, int most) {
  constexpr AddCorner ways[] = {
      add_random_corner,   add_wide_corner,       add_groove,          add_narrow,          add_pit, add_nearly_parallel_facets,
      add_corner_at_start, add_duplicated_corner, add_corner_at_yield, add_corner_on_border};
  ways[m.random.below(std::size(ways))](m, most);
}

// Up to `corners` corners, each within the others' remainder of the n primitives, and other primitives for the rest.
template <void (*start)(Maker&), AddCorner add_corner, int corners, void (*add_other)(Maker&), int others>
Problem make_corners(Random& random, int n, bool drags) {
  Maker m{random, drags, {}};
  start(m);
  const std::vector<Primitive>& made = m.problem.primitives;
  const int few = std::min(random.below(others + 1), n / 2);
  const auto left = [&] { return n - few - static_cast<int>(made.size()); };
  for (int i = 0; i < corners && left() > 0; ++i) add_corner(m, std::max(1, left() / (corners - i)));
  // Beyond the requested most, the rest of a large n is of any kind.
  const bool large = n > static_cast<int>(most_facets) * corners + others;
  const int wanted = large ? n : static_cast<int>(made.size()) + few;
  while (static_cast<int>(made.size()) < std::min(n, wanted)) add_other(m);
  if (m.from_balance) m.problem.probe_m = m.balance_m - m.held_n / m.problem.stiffness_n_per_m;
  return m.problem;
}

// A plane at its largest deflection, to 1e-12 of it, with its full strength.
void add_elastic_at_yield(Maker& m) {
  if (m.random.below(2) == 0) return add_sticking(m);
  constexpr double offs[] = {-1e-12, 0.0, 1e-12};
  const Vec3 direction = m.random.direction();
  const double s = strength(m.random), stiffness_n_per_m = m.problem.stiffness_n_per_m * m.random.log_uniform(0.05, 20.0);
  const double way_m = s / stiffness_n_per_m * (1.0 + offs[m.random.below(3)]);
  add_holding(m, PrimitiveKind::plane, direction, s, s * direction, way_m * direction);
  Primitive& plane = m.problem.primitives.back();
  if (plane.drag_ns_per_m == 0.0) plane.stiffness_n_per_m = stiffness_n_per_m;
}

// The rigid family with most of its planes and corners elastic: mostly about as stiff as the coupling.
template <Problem (*rigid)(Random&, int, bool)>
Problem make_elastic(Random& random, int n, bool drags) {
  Problem problem = rigid(random, n, drags);
  for (std::size_t i = 0; i < problem.primitives.size();) {
    const bool is_soft = random.below(4) > 0;
    const double reach = random.below(5) == 0 ? 1e9 : 20.0;
    const double stiffness_n_per_m = problem.stiffness_n_per_m * random.log_uniform(1.0 / reach, reach);
    const PrimitiveKind kind = problem.primitives[i].kind;
    const std::size_t end = kind == PrimitiveKind::corner ? i + whole_of(problem.primitives, i).size() : i + 1;
    for (; i < end; ++i) {
      Primitive& p = problem.primitives[i];
      const bool can_be = (kind == PrimitiveKind::plane || kind == PrimitiveKind::corner) && p.drag_ns_per_m == 0.0;
      if (is_soft && can_be) p.stiffness_n_per_m = std::max(softest_level_n_per_m, stiffness_n_per_m);
    }
  }
  return problem;
}

constexpr Family all[] = {
    {"random", false, make<begin_random, add_random>},
    {"haptic", false, make<begin_haptic, add_haptic>},
    {"haptic_slipping", false, make_slipping},
    {"at_proxy", true, make<begin_haptic, add_at_start>},
    {"parallel_planes", false, make<begin_haptic, add_parallel_plane>},
    {"coincident", false, make<begin_haptic, add_coincident>},
    {"nearly_parallel_lines", false, make<begin_haptic, add_nearly_parallel_line>},
    {"nearly_parallel_planes", false, make<begin_haptic, add_nearly_parallel_plane>},
    {"zero_strengths", false, make<begin_haptic, add_zero_or_not>},
    {"wide_strengths", false, make<begin_haptic, add_wide>},
    {"probe_on_primitives", false, make<begin_at_probe, add_through_probe>},
    {"stiff_coupling", false, make<begin_stiff, add_stiff>},
    {"far_anchors", false, make<begin_haptic, add_far>},
    {"stick_threshold", false, make<begin_from_balance_at_start, add_at_threshold>},
    {"slab_and_wedge", false, make<begin_haptic, add_conflicting>},
    {"soft_coupling", false, make<begin_soft, add_soft>},
    {"mixture", false, make<begin_mixture, add_any>},
    {"all_strengths_zero", false, make<begin_haptic, add_zero>},
    {"demand_on_anchors", false, make<begin_exact, add_where_demanded>},
    {"planes_meeting", false, make<begin_from_balance, add_meeting>},
    {"overdetermined", false, make<begin_from_balance, add_sticking>},
    {"opposed_planes", false, make<begin_haptic, add_opposed>},
    {"duplicated", false, make<begin_haptic, add_twice>},
    {"resting_corner", true, make<begin_from_balance_at_start, add_in_corner>},
    {"corner", false, make_corners<begin_haptic, add_random_corner, 1, add_haptic, 4>, true},
    {"groove", false, make_corners<begin_haptic, add_groove, 1, add_haptic, 2>, true},
    {"pit", false, make_corners<begin_haptic, add_pit, 1, add_haptic, 2>, true},
    {"corner_at_yield", false, make_corners<begin_from_balance, add_corner_at_yield, 1, add_at_threshold, 2>, true},
    {"nearly_parallel_facets", false, make_corners<begin_haptic, add_nearly_parallel_facets, 1, add_haptic, 2>, true},
    {"narrow_groove", false, make_corners<begin_haptic, add_narrow, 1, add_haptic, 2>, true},
    {"duplicated_facets", false, make_corners<begin_haptic, add_duplicated_corner, 1, add_twice, 2>, true},
    {"corner_at_proxy", true, make_corners<begin_haptic, add_corner_at_start, 1, add_at_start, 2>, true},
    {"corner_on_border", false, make_corners<begin_from_balance, add_corner_on_border, 1, add_sticking, 2>, true},
    {"two_corners", false, make_corners<begin_haptic, add_random_corner, 2, add_haptic, 3>, true},
    {"wide_strength_corner", false, make_corners<begin_haptic, add_wide_corner, 1, add_wide, 3>, true},
    {"soft_coupling_corner", false, make_corners<begin_soft, add_random_corner, 1, add_soft, 3>, true},
    {"corner_mixture", false, make_corners<begin_mixture, add_any_corner, 2, add_any, 3>, true},
    {"elastic_random", false, make_elastic<make<begin_random, add_random>>, true},
    {"elastic_haptic", false, make_elastic<make<begin_haptic, add_haptic>>, true},
    {"elastic_slipping", false, make_elastic<make_slipping>, true},
    {"elastic_parallel_planes", false, make_elastic<make<begin_haptic, add_parallel_plane>>, true},
    {"elastic_nearly_parallel", false, make_elastic<make<begin_haptic, add_nearly_parallel_plane>>, true},
    {"elastic_wide_strengths", false, make_elastic<make<begin_haptic, add_wide>>, true},
    {"elastic_stiff_coupling", false, make_elastic<make<begin_stiff, add_stiff>>, true},
    {"elastic_soft_coupling", false, make_elastic<make<begin_soft, add_soft>>, true},
    {"elastic_far_anchors", false, make_elastic<make<begin_haptic, add_far>>, true},
    {"elastic_at_yield", false, make<begin_from_balance, add_elastic_at_yield>, true},
    {"elastic_slab_and_wedge", false, make_elastic<make<begin_haptic, add_conflicting>>, true},
    {"elastic_mixture", false, make_elastic<make<begin_mixture, add_any>>, true},
    {"elastic_corner", false, make_elastic<make_corners<begin_haptic, add_random_corner, 1, add_haptic, 4>>, true},
    {"elastic_groove", false, make_elastic<make_corners<begin_haptic, add_groove, 1, add_haptic, 2>>, true},
    {"elastic_pit", false, make_elastic<make_corners<begin_haptic, add_pit, 1, add_haptic, 2>>, true},
    {"elastic_duplicated_facets", false, make_elastic<make_corners<begin_haptic, add_duplicated_corner, 1, add_twice, 2>>,
     true},
    {"elastic_two_corners", false, make_elastic<make_corners<begin_haptic, add_random_corner, 2, add_haptic, 3>>, true},
    {"elastic_corner_mixture", false, make_elastic<make_corners<begin_mixture, add_any_corner, 2, add_any, 3>>, true},
};

}  // namespace

std::span<const Family> families() { return all; }

const Family* family_named(std::string_view name) {
  for (const Family& family : families()) {
    if (family.name == name) return &family;
  }
  return nullptr;
}

}  // namespace palpa::test
