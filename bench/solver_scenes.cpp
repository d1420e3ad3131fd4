#include "solver_scenes.h"

#include <palpa/solver/solver.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

namespace palpa::bench {

namespace {

using test::Problem;
using test::Random;

constexpr int ticks_per_scene = 6000;

/// Hand position: some centimetres to and fro at about 0.1 m/s, in and out of all contacts.
Vec3 hand_m(double t_s) {
  constexpr double pi = std::numbers::pi;
  return {0.020 * std::sin(2 * pi * 0.71 * t_s), 0.015 * std::sin(2 * pi * 0.93 * t_s + 1.0),
          0.004 * std::sin(2 * pi * 1.30 * t_s + 2.0)};
}

/// A direction that turns about `q` by up to 0.2 rad within some seconds.
Vec3 turned(const Vec3& q, double t_s, double phase) {
  const Vec3 side = normalized(cross(q, std::abs(q.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  return normalized(q + 0.2 * std::sin(1.7 * t_s + phase) * side + 0.2 * std::cos(1.1 * t_s + phase) * cross(q, side));
}

class Placed {
 public:
  Placed(Problem& problem, double t_s) : problem_(problem), t_s_(t_s) {}
  void add(PrimitiveKind kind, const Vec3& direction, double strength_n, double phase = 0.0) {
    Primitive p;
    p.kind = kind;
    p.id.slot = static_cast<std::uint16_t>(problem_.primitives.size());
    p.position_m = problem_.start_m;
    p.direction = turned(direction, t_s_, phase);
    p.strength_n = strength_n;
    problem_.primitives.push_back(p);
  }
  void groove(const Vec3& one, const Vec3& other, double strength_n) {
    add(PrimitiveKind::corner, one, strength_n);
    add(PrimitiveKind::corner, other, strength_n, 1.0);
    problem_.primitives.back().id = problem_.primitives[problem_.primitives.size() - 2].id;
  }
  void surface(const Vec3& normal, double strength_n, double friction_n, double phase) {
    add(PrimitiveKind::plane, normal, strength_n, phase);
    add(PrimitiveKind::line, normal, friction_n, phase);
  }

 private:
  Problem& problem_;
  double t_s_;
};

Scene recorded(const char* name, bool one_mode, const std::function<void(Placed&)>& place) {
  Scene scene{name, one_mode, 0, {}};
  PrimitiveSet set;
  Solver solver;
  Vec3 proxy_m = hand_m(0.0);
  for (int tick = 0; tick < ticks_per_scene; ++tick) {
    Problem problem;
    problem.start_m = proxy_m;
    problem.probe_m = hand_m(1e-3 * tick);
    Placed placed(problem, 1e-3 * tick);
    place(placed);
    test::fill(set, problem);
    proxy_m = solver.solve(set, proxy_m, problem.probe_m, problem.stiffness_n_per_m, problem.time_step_s).position_m;
    scene.primitives = static_cast<int>(problem.primitives.size());
    scene.ticks.push_back(std::move(problem));
  }
  return scene;
}

}  // namespace

std::vector<Scene> scenes() {
  const Vec3 up{0, 0, 1};
  const Vec3 leaning = normalized({0.7, 0.2, 0.7});
  std::array<Primitive, 16> many;
  Random random(16);
  for (Primitive& p : many) {
    p.kind = static_cast<PrimitiveKind>(random.below(3));
    p.direction = random.direction();
    p.strength_n = random.uniform(0.1, 1.0);
  }
  return {
      recorded("viscosity: point", true, [&](Placed& p) { p.add(PrimitiveKind::point, up, 1.0); }),
      recorded("follow: line", true,
               [&](Placed& p) {
                 p.add(PrimitiveKind::line, {1, 0, 0}, 1.0);
               }),
      recorded("surface and friction: plane + line", true, [&](Placed& p) { p.surface(up, 3.0, 0.6, 0.0); }),
      recorded("two crossing surfaces with friction", false,
               [&](Placed& p) {
                 p.surface(up, 3.0, 0.6, 0.0);
                 p.surface(leaning, 3.0, 0.6, 1.0);
               }),
      recorded("five modes: 5 + directed", false,
               [&](Placed& p) {
                 p.surface(up, 3.0, 0.6, 0.0);
                 p.add(PrimitiveKind::line, {1, 0, 0}, 1.0, 2.0);
                 p.add(PrimitiveKind::point, up, 0.3);
                 p.add(PrimitiveKind::plane, leaning, 2.0, 1.0);
                 p.add(PrimitiveKind::directed, {0, 1, 0}, 0.5, 3.0);
               }),
      recorded("16 at the proxy", false,
               [&](Placed& p) {
                 for (std::size_t i = 0; i < many.size(); ++i) {
                   p.add(many[i].kind, many[i].direction, many[i].strength_n, static_cast<double>(i));
                 }
               }),
      recorded("groove with friction: 2 facets + line", false,
               [&](Placed& p) {
                 p.groove(up, leaning, 3.0);
                 p.add(PrimitiveKind::line, normalized(up + leaning), 0.6, 0.5);
               }),
  };
}

}  // namespace palpa::bench
