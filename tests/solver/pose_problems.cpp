#include "tests/solver/pose_problems.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/solver/problem_families.h"

namespace palpa::test {

void fill(PrimitiveSet& set, const PoseProblem& problem) {
  set.clear(problem.start.position_m);
  const ToolStep step = problem.step();
  for (const Primitive& p : problem.primitives) {
    set.begin_foot(p.id.foot, step.foot_m(p.id.foot));
    set.add(p);
  }
}

PoseSolved solved(const PoseProblem& problem, PoseSolver& solver, PrimitiveSet& set) {
  fill(set, problem);
  PoseSolved result;
  result.balance = solver.solve(set, problem.step());
  result.forces_n.assign(solver.forces_n().begin(), solver.forces_n().end());
  return result;
}

PoseSolved solved(const PoseProblem& problem) {
  const std::size_t capacity = std::max<std::size_t>(2, problem.primitives.size());
  PoseSolver solver(capacity, problem.levers_m.size());
  PrimitiveSet set(capacity);
  return solved(problem, solver, set);
}

Turn random_turn(Random& random, double most_rad) { return turn_by(random.uniform(0.0, most_rad) * random.direction()); }

namespace of_tools {
namespace {

struct Maker {
  Random& random;
  PoseProblem problem;
  Vec3 axis = random.direction();
  Vec3 side = normalized(cross(axis, random.direction()));
  double share = 1.0;  // of the strength
  std::uint16_t slot = 0;

  std::size_t feet() const { return problem.levers_m.size(); }
  double strength_n() { return share * random.uniform(0, 5); }
  // At the foot, or up to `most_m` off it.
  Vec3 near(std::size_t foot, double most_m) {
    return problem.step().foot_m(foot) + (random.below(2) == 0 ? Vec3{} : random.in_cube(most_m));
  }
  Primitive& add(std::size_t foot, PrimitiveKind kind, const Vec3& position_m, const Vec3& direction, double strength_n) {
    Primitive p{kind, {}, position_m, kind == PrimitiveKind::point ? Vec3{} : direction, strength_n, 0.0};
    p.id.foot = static_cast<std::uint16_t>(foot), p.id.slot = slot++;
    if (kind == PrimitiveKind::directed) p.position_m = {};
    return problem.primitives.emplace_back(p);
  }
};

Maker maker(Random& random, int feet) {
  Maker m{random, {}};
  PoseProblem& problem = m.problem;
  problem.start = {random.in_cube(0.05), random_turn(random, 3.0)};
  problem.probe = {problem.start.position_m + random.in_cube(0.004),
                   turned_further(problem.start.turn, random.uniform(0, 0.3) * random.direction())};
  problem.stiffness_n_per_m = random.log_uniform(300, 3000);
  problem.turning_radius_m = random.log_uniform(0.005, 0.1);
  const double reach_m = random.log_uniform(0.005, 0.1);
  for (int i = 0; i < feet; ++i) problem.levers_m.push_back(random.in_cube(reach_m));
  m.share = 1.0 / feet;
  return m;
}

// Each lever along `axis` or across it alone.
void flatten(Maker& m, bool along) {
  for (Vec3& lever_m : m.problem.levers_m) {
    const Vec3 along_m = dot(lever_m, m.axis) * m.axis;
    lever_m = along ? along_m : lever_m - along_m;
  }
}

Vec3 nearly_along(Maker& m, double least_rad, double most_rad) {
  return normalized(m.axis + m.random.log_uniform(least_rad, most_rad) * m.random.direction());
}

Maker pad_maker(Random& random, int feet) {
  Maker m = maker(random, feet);
  flatten(m, false);
  const bool on_plane = random.below(2) == 0;
  for (std::size_t i = 0; i < m.feet(); ++i) {
    const double off_m = on_plane ? 0.0 : random.uniform(-0.0005, 0.0005);
    m.add(i, PrimitiveKind::plane, m.problem.step().foot_m(i) + off_m * m.axis, m.axis, m.strength_n());
  }
  m.problem.probe.position_m -= random.uniform(0, 0.004) * m.axis;
  return m;
}
PoseProblem pad(Random& random, int feet) { return pad_maker(random, feet).problem; }
PoseProblem pad_friction(Random& random, int feet) {
  Maker m = pad_maker(random, feet);
  for (std::size_t i = 0; i < m.feet(); ++i) {
    const Vec3 at_m = m.problem.step().foot_m(i);
    m.add(i, PrimitiveKind::line, at_m, m.axis, 0.3 * m.strength_n()).drag_ns_per_m = random.below(2) * m.share;
  }
  return m.problem;
}

PoseProblem groove(Random& random, int feet) {
  Maker m = maker(random, feet);
  const double half_rad = random.uniform(0.05, 1.4);
  for (std::size_t i = 0; i < m.feet(); ++i) {
    const double sign = random.below(2) == 0 ? 1.0 : -1.0;
    const Vec3 normal = normalized(std::sin(half_rad) * m.axis + sign * std::cos(half_rad) * m.side);
    m.add(i, PrimitiveKind::plane, m.near(i, 0.0005), normal, m.strength_n());
  }
  return m.problem;
}

PoseProblem peg(Random& random, int feet) {
  Maker m = maker(random, feet);
  flatten(m, true);
  const Vec3 third = cross(m.axis, m.side);
  for (std::size_t i = 0; i < m.feet(); ++i) {
    const double angle_rad = random.uniform(0, 2.0 * std::numbers::pi);
    const Vec3 out = std::cos(angle_rad) * m.side + std::sin(angle_rad) * third;
    const double gap_m = random.below(3) == 0 ? 0.0 : random.uniform(-0.0005, 0.001);
    const Vec3 foot_m = m.problem.step().foot_m(i);
    m.add(i, PrimitiveKind::plane, foot_m + gap_m * out, -out, m.strength_n());
    if (random.below(2) == 0) m.add(i, PrimitiveKind::plane, foot_m - gap_m * out, out, m.strength_n());
  }
  return m.problem;
}

PoseProblem bumps(Random& random, int feet) {
  Maker m = maker(random, feet);
  for (std::size_t i = 0; i < m.feet(); ++i)
    m.add(i, PrimitiveKind::plane, m.near(i, 0.0005), nearly_along(m, 0.01, 2.0), m.strength_n());
  return m.problem;
}

PoseProblem rails(Random& random, int feet) {
  Maker m = maker(random, feet);
  for (std::size_t i = 0; i < m.feet(); ++i)
    m.add(i, PrimitiveKind::line, m.near(i, 0.001), random.below(2) == 0 ? m.axis : random.direction(), m.strength_n());
  return m.problem;
}

PoseProblem drags(Random& random, int feet) {
  Maker m = maker(random, feet);
  for (std::size_t i = 0; i < m.feet(); ++i) {
    Primitive& p = m.add(i, static_cast<PrimitiveKind>(random.below(3)), m.problem.step().foot_m(i), random.direction(),
                         random.below(4) == 0 ? 0.0 : m.strength_n());
    const int which = random.below(8);
    p.drag_ns_per_m = m.share * (which == 0 ? 1e-9 : which == 1 ? 1e5 : random.uniform(0, 20));
  }
  return m.problem;
}

void add_corner(Maker& m, std::size_t foot) {
  const double strength_n = m.strength_n();
  const Vec3 axis = m.random.direction();
  const bool at_foot = m.random.below(2) == 0;
  const std::uint16_t slot = m.slot;
  std::vector<Primitive> facets;
  for (int i = 2 + m.random.below(3); i > 0; --i) {
    const Vec3 normal = normalized(axis + m.random.log_uniform(0.3, 3.0) * m.random.direction());
    m.add(foot, PrimitiveKind::corner, at_foot ? m.problem.step().foot_m(foot) : m.near(foot, 0.001), normal, strength_n)
        .id.slot = slot;
    // A set refuses corners that are too narrow.
    PrimitiveSet set(8);
    set.clear({});
    facets.push_back(m.problem.primitives.back());
    for (const Primitive& facet : facets) set.add(facet);
    if (set.size() < facets.size()) facets.pop_back(), m.problem.primitives.pop_back();
  }
  if (facets.size() == 1) m.problem.primitives.back().kind = PrimitiveKind::plane;
}
PoseProblem corners(Random& random, int feet) {
  Maker m = maker(random, feet);
  for (std::size_t i = 0; i < m.feet(); ++i) add_corner(m, i);
  return m.problem;
}

PoseProblem elastic(Random& random, int feet) {
  Maker m = maker(random, feet);
  for (std::size_t i = 0; i < m.feet(); ++i) {
    const double reach = random.below(5) == 0 ? 1e9 : 20.0;
    m.add(i, PrimitiveKind::plane, m.near(i, 0.0005), nearly_along(m, 0.01, 2.0), m.strength_n()).stiffness_n_per_m =
        m.share * m.problem.stiffness_n_per_m * random.log_uniform(1.0 / reach, reach);
  }
  return m.problem;
}

PoseProblem directed(Random& random, int feet) {
  Maker m = maker(random, feet);
  for (std::size_t i = 0; i < m.feet(); ++i) {
    m.add(i, PrimitiveKind::directed, {}, random.direction(), 0.2 * m.strength_n());
    if (random.below(2) == 0) m.add(i, PrimitiveKind::plane, m.near(i, 0.0005), nearly_along(m, 0.01, 2.0), m.strength_n());
  }
  return m.problem;
}

PoseProblem points(Random& random, int feet) {
  Maker m = maker(random, feet);
  for (std::size_t i = 0; i < m.feet(); ++i) m.add(i, PrimitiveKind::point, m.near(i, 0.002), {}, m.strength_n());
  return m.problem;
}

PoseProblem nearly_parallel(Random& random, int feet) {
  Maker m = maker(random, feet);
  for (std::size_t i = 0; i < m.feet(); ++i) {
    for (int one = 1 + random.below(2); one > 0; --one) {
      const Vec3 normal = nearly_along(m, 1e-9, 1e-2);
      m.add(i, PrimitiveKind::plane, m.near(i, 0.0005), random.below(2) == 0 ? normal : -normal, m.strength_n());
    }
  }
  return m.problem;
}

PoseProblem jammed(Random& random, int feet) {
  Maker m = maker(random, feet);
  const double off_rad = random.below(2) == 0 ? 1e-6 : 1.0;
  for (std::size_t i = 0; i < m.feet(); ++i) {
    const Vec3 normal = nearly_along(m, 1e-3 * off_rad, off_rad);
    m.add(i, PrimitiveKind::plane, m.near(i, 0.0005), random.below(2) == 0 ? normal : -normal, m.strength_n());
    m.add(i, PrimitiveKind::line, m.near(i, 0.0005), normal, 0.3 * m.strength_n());
  }
  return m.problem;
}

PoseProblem coincident(Random& random, int feet) {
  Maker m = maker(random, feet);
  for (std::size_t i = 2; i < m.feet(); ++i)
    m.problem.levers_m[i] = m.problem.levers_m[static_cast<std::size_t>(random.below(2))];
  for (std::size_t i = 0; i < m.feet(); ++i)
    m.add(i, random.below(2) == 0 ? PrimitiveKind::point : PrimitiveKind::plane, m.near(i, 0.0005),
          random.below(2) == 0 ? m.axis : -m.axis, m.strength_n());
  return m.problem;
}

PoseProblem mixed(Random& random, int feet) {
  Maker m = maker(random, feet);
  PoseProblem& problem = m.problem;
  if (random.below(3) == 0) problem.stiffness_n_per_m = random.log_uniform(1, 1e6);
  if (random.below(3) == 0)
    problem.probe.turn = turned_further(problem.start.turn, random.uniform(0, 2.8) * random.direction());
  if (random.below(4) == 0) m.share = 1.0;
  if (random.below(4) == 0) problem.levers_m[0] = {};
  for (std::size_t i = 0; i < m.feet(); ++i) {
    for (int one = random.below(3); one > 0; --one) {
      if (random.below(6) == 0) {
        add_corner(m, i);
        continue;
      }
      const auto kind = static_cast<PrimitiveKind>(random.below(4));
      const double strength_n = kind == PrimitiveKind::directed ? 0.2 * m.strength_n() : m.strength_n();
      Primitive& p =
          m.add(i, kind, m.near(i, 0.001), random.below(2) == 0 ? nearly_along(m, 1e-6, 1.0) : random.direction(), strength_n);
      if (kind == PrimitiveKind::directed) continue;
      const bool at_foot = p.position_m == problem.step().foot_m(i);
      if (at_foot && random.below(3) == 0) p.drag_ns_per_m = m.share * random.uniform(0, 20);
      if (p.drag_ns_per_m == 0.0 && kind == PrimitiveKind::plane && random.below(3) == 0)
        p.stiffness_n_per_m = problem.stiffness_n_per_m * random.log_uniform(0.05, 20.0);
    }
  }
  return problem;
}

PoseProblem spread(Random& random, int feet) {
  Maker m = maker(random, feet);
  const Family& family = families()[static_cast<std::size_t>(random.below(static_cast<int>(families().size())))];
  const Problem from = family.make(random, std::max(1, std::min(feet * (1 + random.below(2)), 300)), random.below(2) == 0);
  PoseProblem& problem = m.problem;
  problem.start.position_m = from.start_m;
  problem.probe.position_m = from.probe_m;
  problem.stiffness_n_per_m = from.stiffness_n_per_m;
  problem.time_step_s = from.time_step_s;
  // In the order of the feet, corners whole.
  std::vector<std::size_t> feet_of;
  for (std::size_t i = 0; i < from.primitives.size();) {
    const std::size_t size = whole_of(from.primitives, i).size(), foot = static_cast<std::size_t>(random.below(feet));
    feet_of.insert(feet_of.end(), size, foot);
    i += size;
  }
  for (std::size_t foot = 0; foot < m.feet(); ++foot) {
    const Vec3 foot_m = problem.step().foot_m(foot);
    for (std::size_t i = 0; i < from.primitives.size(); ++i) {
      if (feet_of[i] != foot) continue;
      Primitive& p = problem.primitives.emplace_back(from.primitives[i]);
      p.id.foot = static_cast<std::uint16_t>(foot);
      if (p.kind != PrimitiveKind::directed) p.position_m = foot_m + (p.position_m - from.start_m);
    }
  }
  return problem;
}

constexpr PoseFamily all[] = {
    {"pad", pad},           {"pad_friction", pad_friction},
    {"groove", groove},     {"peg", peg},
    {"bumps", bumps},       {"rails", rails},
    {"drags", drags},       {"corners", corners},
    {"elastic", elastic},   {"directed", directed},
    {"points", points},     {"nearly_parallel", nearly_parallel},
    {"jammed", jammed},     {"coincident", coincident},
    {"mixed", mixed, true}, {"spread", spread, true},
};

}  // namespace
}  // namespace of_tools

std::span<const PoseFamily> pose_families() { return of_tools::all; }

}  // namespace palpa::test
