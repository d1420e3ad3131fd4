// The recorded bound of a balance against the duality gap of docs/theory.md 3.1 in 113 bits.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "palpa/session/sub_step.h"
#include "palpa/solver/solver.h"
#include "tests/laws/balance_formula.h"
#include "tests/solver/solved.h"

namespace palpa::test {
namespace recorded_bound_test {

using Quad = __float128;

struct Quad3 {
  Quad x = 0, y = 0, z = 0;
};
Quad3 wide(const Vec3& a) { return {a.x, a.y, a.z}; }
Vec3 rounded(const Quad3& a) { return {static_cast<double>(a.x), static_cast<double>(a.y), static_cast<double>(a.z)}; }
Quad3 operator+(const Quad3& a, const Quad3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Quad3 operator-(const Quad3& a, const Quad3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Quad3 operator*(Quad f, const Quad3& a) { return {f * a.x, f * a.y, f * a.z}; }
Quad dot(const Quad3& a, const Quad3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Two steps of Newton's method from the root of 64 bits.
Quad root(Quad a) {
  if (!(a > 0)) return 0;
  Quad y = std::sqrt(static_cast<long double>(a));
  for (int i = 0; i < 2; ++i) y = (y + a / y) / 2;
  return y;
}
Quad length(const Quad3& a) { return root(dot(a, a)); }

Quad3 unit(const Vec3& a) { return 1 / length(wide(a)) * wide(a); }

/// A proxy in an exactly known balance, at a point that is no double, and its forces.
struct Known {
  std::vector<Primitive> primitives;
  std::vector<Quad3> forces_n;
  Quad3 place_m;
  double stiffness_n_per_m = 0.0;
  double time_step_s = 1e-3;

  // As it is recorded, with the tightest bound that a law can prove.
  Balance balance() const {
    Balance recorded;
    recorded.position_m = rounded(place_m);
    recorded.error_bound_m = std::nextafter(static_cast<double>(length(place_m - wide(recorded.position_m))), 1.0);
    return recorded;
  }
  std::vector<PlacedPrimitive> placed() const {
    std::vector<PlacedPrimitive> rows;
    for (std::size_t i = 0; i < primitives.size(); ++i)
      rows.push_back({primitives[i], {}, rounded(forces_n[i]), state_at(primitives, i, balance()), {}});
    return rows;
  }
  // (ρ + √(ρ² + 4kε)) / 2k with the exact forces, at the recorded position.
  double gap_bound_m() const {
    const Quad3 x_m = wide(balance().position_m);
    const Quad k = stiffness_n_per_m;
    const Quad rho = k * length(x_m - place_m);
    Quad epsilon = 0;
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      const Primitive& p = primitives[i];
      const Quad3 q = unit(p.direction), d = wide(p.position_m) - x_m;
      epsilon = epsilon - dot(forces_n[i], d);
      if (p.kind == PrimitiveKind::corner && i > 0) continue;
      Quad off = dot(q, d) > 0 ? dot(q, d) : 0;
      if (p.kind == PrimitiveKind::line) off = length(d - dot(q, d) * q);
      if (p.kind == PrimitiveKind::corner) off = norm(residual(primitives, i, rounded(x_m)));
      const Quad s = p.strength_n, stiffness = p.stiffness_n_per_m;
      if (p.is_elastic()) {
        epsilon = epsilon + (stiffness * off < s ? stiffness / 2 * off * off : s * off - s * s / (2 * stiffness));
        epsilon = epsilon + dot(forces_n[i], forces_n[i]) / (2 * stiffness);
      } else {
        epsilon = epsilon + s * off;
      }
      if (const Quad C = p.drag_ns_per_m / Quad(time_step_s); C > 0) {
        const Quad u = length(forces_n[i]), over = u > s ? u - s : 0;
        epsilon = epsilon + C / 2 * off * off + over * over / (2 * C);
      }
    }
    return static_cast<double>((rho + root(rho * rho + 4 * k * (epsilon > 0 ? epsilon : 0))) / (2 * k));
  }
};

Known drawn(Random& random) {
  Known known;
  known.stiffness_n_per_m = random.uniform(100, 3000);
  return known;
}

Primitive through(Random& random, PrimitiveKind kind, std::uint16_t slot, const Vec3& near_m) {
  return {kind, {0, slot}, near_m + random.in_cube(0.003), random.direction(), random.uniform(0.1, 5.0)};
}

// On one plane, pressed by any force within its strength; elastic, at that force's depth.
Known on_plane(Random& random, double stiffness_n_per_m) {
  Known known = drawn(random);
  const Vec3 near_m = random.in_cube(0.1);
  Primitive plane = through(random, PrimitiveKind::plane, 0, near_m);
  plane.stiffness_n_per_m = stiffness_n_per_m;
  const Quad pressed_n = random.uniform(0.0, plane.strength_n);
  const Quad3 n = unit(plane.direction);
  const Quad depth_m = plane.is_elastic() ? pressed_n / plane.stiffness_n_per_m : 0;
  known.place_m = wide(near_m) + (dot(n, wide(plane.position_m) - wide(near_m)) - depth_m) * n;
  known.primitives = {plane};
  known.forces_n = {pressed_n * n};
  return known;
}

// At the intersection of two planes, separate or as one corner.
Known on_two(Random& random, PrimitiveKind kind) {
  Known known = drawn(random);
  const Vec3 near_m = random.in_cube(0.1);
  Primitive a = through(random, kind, 0, near_m), b = through(random, kind, 1, near_m);
  while (std::abs(dot(a.direction, b.direction)) > 0.9) b.direction = random.direction();
  Quad share_n = 1;
  if (kind == PrimitiveKind::corner) b.id = a.id, b.strength_n = a.strength_n, share_n = 0.5;
  const Quad3 m = unit(a.direction), n = unit(b.direction), x_m = wide(near_m);
  const Quad mn = dot(m, n), to_a = dot(m, wide(a.position_m) - x_m), to_b = dot(n, wide(b.position_m) - x_m),
             det = 1 - mn * mn;
  known.place_m = x_m + (to_a - mn * to_b) / det * m + (to_b - mn * to_a) / det * n;
  known.primitives = {a, b};
  known.forces_n = {share_n * random.uniform(0.0, a.strength_n) * m, share_n * random.uniform(0.0, b.strength_n) * n};
  return known;
}

// On a line, or pulled off it by `off_m`, with all its strength then.
Known on_line(Random& random, double off_m) {
  Known known = drawn(random);
  const Primitive line = through(random, PrimitiveKind::line, 0, random.in_cube(0.1));
  const Quad3 q = unit(line.direction), any = wide(random.direction());
  const Quad3 across = any - dot(q, any) * q;
  const Quad3 e = 1 / length(across) * across;
  known.place_m = wide(line.position_m) + Quad(random.uniform(-0.003, 0.003)) * q - Quad(off_m) * e;
  known.primitives = {line};
  known.forces_n = {Quad(off_m > 0.0 ? line.strength_n : random.uniform(0.0, line.strength_n)) * e};
  return known;
}

// Off a line or plane by the distance that its drag allows under a force, in a time as short as `time_step_s`.
Known dragged(Random& random, PrimitiveKind kind, double time_step_s) {
  Known known = drawn(random);
  known.time_step_s = time_step_s;
  Primitive p = through(random, kind, 0, random.in_cube(0.1));
  p.drag_ns_per_m = random.uniform(0.1, 5.0);
  if (random.uniform(0.0, 1.0) < 0.5) p.strength_n = 0.0;
  const Quad3 q = unit(p.direction), any = wide(random.direction());
  const Quad3 across = any - dot(q, any) * q;
  const bool is_plane = kind == PrimitiveKind::plane;
  const Quad3 e = is_plane ? q : 1 / length(across) * across, along = is_plane ? across : q;
  const Quad over_n = std::exp(random.uniform(std::log(1e-8), std::log(3.0))),
             off_m = over_n * Quad(time_step_s) / Quad(p.drag_ns_per_m);
  known.place_m = wide(p.position_m) + Quad(random.uniform(-0.003, 0.003)) * along - off_m * e;
  known.primitives = {p};
  known.forces_n = {(Quad(p.strength_n) + over_n) * e};
  return known;
}

void expect_to_hold(const char* what, const std::function<Known()>& draw) {
  int needed = 0;
  for (int i = 0; i < 3000; ++i) {
    const Known known = draw();
    const Balance balance = known.balance();
    const double bound_m = recorded_bound_m(known.placed(), balance, known.stiffness_n_per_m, known.time_step_s);
    EXPECT_LE(known.gap_bound_m(), bound_m * (1.0 + 1e-12)) << what << ' ' << i;
    EXPECT_GE(bound_m, balance.error_bound_m);
    needed += known.gap_bound_m() > 1.5 * balance.error_bound_m;
  }
  EXPECT_GT(needed, 1000) << what;  // the law's own bound would be too small
}

TEST(RecordedBound, IsThatOfTheLawWhereNothingHolds) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Balance balance{random.in_cube(0.1), std::exp(random.uniform(-50.0, 0.0))};
    const double k = random.uniform(100, 3000);
    EXPECT_EQ(recorded_bound_m({}, balance, k, 1e-3), balance.error_bound_m);
    const PlacedPrimitive left{{PrimitiveKind::plane, {}, {}, random.direction(), 3.0}, {}, {}, PrimitiveState::off, {}};
    EXPECT_EQ(recorded_bound_m({&left, 1}, balance, k, 1e-3), balance.error_bound_m);
  }
}

TEST(RecordedBound, HoldsTheGapOfEveryKnownBalanceAtItsPlaceAsADouble) {
  Random random(2);
  expect_to_hold("plane", [&] { return on_plane(random, std::numeric_limits<double>::infinity()); });
  expect_to_hold("elastic plane", [&] { return on_plane(random, std::exp(random.uniform(std::log(10.0), std::log(1e9)))); });
  expect_to_hold("two planes", [&] { return on_two(random, PrimitiveKind::plane); });
  expect_to_hold("corner", [&] { return on_two(random, PrimitiveKind::corner); });
  expect_to_hold("line", [&] { return on_line(random, 0.0); });
  expect_to_hold("slipping off a line",
                 [&] { return on_line(random, std::exp(random.uniform(std::log(1e-18), std::log(1e-3)))); });
  // Over so short a time a drag is stiffer than any wall, and its position's rounding much of its force.
  for (const PrimitiveKind kind : {PrimitiveKind::line, PrimitiveKind::plane})
    expect_to_hold("drag", [&] { return dragged(random, kind, std::exp(random.uniform(std::log(1e-15), std::log(1e-12)))); });
}

TEST(RecordedBound, HoldsTheGapOfASolvedDragHoweverShortItsTimeAndFarItsProbe) {
  Random random(4);
  int stiff = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto log_between = [&](double low, double high) { return std::exp(random.uniform(std::log(low), std::log(high))); };
    const double k = log_between(0.01, 3000.0), T = log_between(shortest_time_s, 1e-3), c = log_between(0.1, 5.0);
    const Vec3 start_m = random.in_cube(0.1), probe_m = start_m + log_between(1e-3, 20.0) * random.direction();
    const Vec3 direction = random.direction();
    const double strength_n = i % 2 == 0 ? 0.0 : random.uniform(0.0, 1.0);
    PrimitiveSet set(4);
    set.clear(start_m);
    set.begin_mode(0);
    if (i % 3 == 0) set.point(0, start_m, strength_n, c);
    if (i % 3 == 1) set.line(0, start_m, direction, strength_n, c);
    if (i % 3 == 2)
      set.plane(0, start_m, dot(direction, probe_m - start_m) < 0.0 ? direction : -1.0 * direction, strength_n, {}, c);
    ASSERT_EQ(set.size(), 1U);
    Solver solver(4);
    const Balance balance = solver.solve(set, start_m, probe_m, k, T);
    const Primitive& p = set.primitives()[0];
    const PlacedPrimitive placed{p, {}, solver.forces_n()[0], state_at(set.primitives(), 0, balance), {}};
    const double bound_m = recorded_bound_m({&placed, 1}, balance, k, T);
    BalanceFormula formula(balance.position_m, probe_m, {}, k, T);
    formula.add(name_of(p.kind), p.position_m, p.direction, p.strength_n, c, 0.0, placed.force_n);
    EXPECT_LE(formula.bound_m(), bound_m + formula.rounding_m()) << i << ": k " << k << ", T " << T;
    stiff += c / T > 1e6 * k;
  }
  EXPECT_GT(stiff, 1000);
}

TEST(RecordedBound, TakesTheFacetsOfACornerForOne) {
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Known known = on_two(random, PrimitiveKind::corner);
    std::vector<PlacedPrimitive> rows = known.placed();
    const double bound_m = recorded_bound_m(rows, known.balance(), known.stiffness_n_per_m, known.time_step_s);
    rows[1].force_n += rows[0].force_n;
    EXPECT_EQ(bound_m, recorded_bound_m({&rows[1], 1}, known.balance(), known.stiffness_n_per_m, known.time_step_s));
  }
}

}  // namespace recorded_bound_test
}  // namespace palpa::test
