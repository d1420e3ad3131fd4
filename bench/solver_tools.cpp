#include "solver_tools.h"

#include <palpa/solver/pose_solver.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "tests/solver/pose_problems.h"

namespace palpa::bench {

namespace {

using test::PoseProblem;
using test::Random;

constexpr int feet_of_tools[] = {1, 8, 16, 64, 256};
constexpr int ticks = 4000, repeats = 3, most_balances = 4;
constexpr double pi = std::numbers::pi;
constexpr double near_m = 0.001;           // a foot looks this far
constexpr double contact_m = 1e-9;         // a foot is on the surface
constexpr double strength_n = 20.0;        // of all feet together
constexpr double friction_n = 1.0;         // likewise
constexpr double tolerance_m = 1e-8;       // of a tick's last balance
constexpr double stiffness_n_per_m = 500;  // of the coupling

/// The nearest place on a surface, and the normal out of the solid.
struct Place {
  Vec3 at_m, normal;
};

struct Walk {
  const char* name;
  ToolOptions tool;
  std::function<Place(const Vec3& foot_m)> nearest;
  std::function<Pose(double t_s)> device;
};

Pose pose_of(const Vec3& position_m, const Vec3& turn_rad) { return {position_m, turn_by(turn_rad)}; }

std::vector<Walk> walks() {
  ToolOptions pad, peg;
  pad.shape = ToolOptions::Shape::pad, pad.radius_m = 0.01;
  peg.shape = ToolOptions::Shape::rod, peg.length_m = 0.04, peg.radius_m = 0.005;
  const auto sway = [](double t_s) {
    return Vec3{0.1 * std::sin(2 * pi * 0.7 * t_s), 0.1 * std::sin(2 * pi * 0.9 * t_s + 1.0),
                0.2 * std::sin(2 * pi * 0.5 * t_s)};
  };
  const auto loop_m = [](double t_s) { return Vec3{0.02 * std::cos(pi * t_s), 0.02 * std::sin(pi * t_s), 0.0}; };
  constexpr double ball_m = 0.04, hole_m = 0.0055;
  return {
      {"pad on a plane", pad,
       [](const Vec3& x) {
         return Place{{x.x, x.y, 0}, {0, 0, 1}};
       },
       [=](double t_s) {
         return pose_of(loop_m(t_s) + Vec3{0, 0, -0.002 + 0.001 * std::sin(5 * t_s)}, sway(t_s));
       }},
      {"pad on a sphere", pad,
       [](const Vec3& x) {
         return Place{ball_m * normalized(x), normalized(x)};
       },
       [=](double t_s) {
         const Vec3 over_m = loop_m(t_s);
         const Vec3 out = normalized({over_m.x, over_m.y, ball_m});
         return pose_of((ball_m - 0.002) * out, cross({0, 0, 1}, out) + sway(t_s));
       }},
      {"peg in a hole", peg,
       [](const Vec3& x) {
         const Vec3 in = normalized({-x.x, -x.y, 1e-12});
         return Place{Vec3{0, 0, x.z} - hole_m * in, in};
       },
       [=](double t_s) {
         return pose_of(0.1 * loop_m(t_s) + Vec3{0, 0, 0.01 * std::sin(3 * t_s)}, 1.5 * sway(t_s));
       }},
  };
}

/// A tool's walk, balance by balance.
class Walker {
 public:
  Walker(const Walk& walk, int feet, bool friction, const Clock& clock)
      : walk_(walk), friction_(friction), clock_(clock), set_(capacity(feet)), solver_(capacity(feet), feet) {
    ToolOptions options = walk.tool;
    options.points = feet, options.share = 1.0 / feet;
    CouplingOptions coupling;
    coupling.stiffness_n_per_m = stiffness_n_per_m;
    tool_ = Tool(options, coupling);
    on_.assign(tool_.feet(), false);
    levers_m_.resize(tool_.feet());
  }

  void run(ToolTimes& times, bool first) {
    pose_ = walk_.device(0.0);
    solver_.reset();
    std::fill(on_.begin(), on_.end(), false);
    std::size_t number = 0;
    for (int tick = 0; tick < ticks; ++tick) {
      const Pose device = walk_.device(1e-3 * tick);
      for (int i = 0; i < most_balances; ++i) {
        const Pose before = pose_;
        const double ns = balance(device, times, first);
        if (first) times.times_ns.push_back(ns);
        times.times_ns[number] = std::min(times.times_ns[number], ns);
        ++number;
        if (tool_.way_m(before, pose_) < tolerance_m) break;
      }
    }
    times.rows = rows_ / static_cast<double>(number);
    rows_ = 0.0;
  }

 private:
  static std::size_t capacity(int feet) { return static_cast<std::size_t>(2 * feet + 2); }

  double balance(const Pose& device, ToolTimes& times, bool first) {
    const auto share_n = [&](double all_n) { return all_n * tool_.share(); };
    set_.clear(pose_.position_m);
    for (std::size_t foot = 0; foot < tool_.feet(); ++foot) {
      levers_m_[foot] = tool_.lever_m(pose_.turn, foot);
      const Vec3 foot_m = pose_.position_m + levers_m_[foot];
      const Place place = walk_.nearest(foot_m);
      const double out_m = dot(place.normal, foot_m - place.at_m);
      if (out_m > near_m) {
        on_[foot] = false;
        continue;
      }
      set_.begin_foot(static_cast<std::uint16_t>(foot), foot_m);
      set_.plane(0, std::abs(out_m) < 1e-13 ? foot_m : place.at_m, place.normal, share_n(strength_n));
      if (friction_ && on_[foot]) set_.line(1, foot_m, place.normal, share_n(friction_n));
    }
    rows_ += static_cast<double>(set_.size());
    const ToolStep step{pose_, device, levers_m_, stiffness_n_per_m, tool_.turning_radius_m(), 1e-3};
    const std::uint64_t begin = Clock::now();
    const Balance balance = solver_.solve(set_, step);
    const std::uint64_t end = Clock::now();
    if (first) {
      times.largest_bound_m = std::max(times.largest_bound_m, balance.error_bound_m);
      times.capped += balance.status != BalanceStatus::exact;
    }
    for (std::size_t i = 0; i < set_.size(); ++i) {
      if (set_[i].kind != PrimitiveKind::plane) continue;
      const Vec3 at_m = balance_at_foot(balance, levers_m_[set_[i].id.foot], tool_.turning_radius_m()).position_m;
      on_[set_[i].id.foot] = dot(set_[i].direction, set_[i].position_m - at_m) > -contact_m;
    }
    pose_ = {balance.position_m, turned_further(pose_.turn, balance.turn_rad)};
    return std::max(0.0, clock_.ns_between(begin, end) - clock_.own_ns());
  }

  const Walk& walk_;
  bool friction_;
  const Clock& clock_;
  PrimitiveSet set_;
  PoseSolver solver_;
  Tool tool_;
  Pose pose_;
  std::vector<Vec3> levers_m_;
  std::vector<bool> on_;
  double rows_ = 0.0;
};

}  // namespace

std::vector<ToolTimes> times_of_walks(const Clock& clock) {
  std::vector<ToolTimes> all;
  const std::vector<Walk> every = walks();
  for (const Walk& walk : every) {
    for (const int feet : feet_of_tools) {
      for (const bool friction : {false, true}) {
        ToolTimes& times = all.emplace_back(ToolTimes{walk.name, feet, friction, 0.0, {}});
        Walker walker(walk, feet, friction, clock);
        for (int repeat = 0; repeat < repeats; ++repeat) walker.run(times, repeat == 0);
      }
    }
  }
  return all;
}

std::vector<ToolTimes> times_jammed(const Clock& clock, int problems) {
  const auto families = test::pose_families();
  const auto jammed =
      std::ranges::find_if(families, [](const auto& family) { return std::string_view(family.name) == "jammed"; });
  std::vector<ToolTimes> all;
  for (const int feet : feet_of_tools) {
    ToolTimes& times = all.emplace_back(ToolTimes{"jammed at random, cold", feet, true, 2.0 * feet, {}});
    for (int i = 0; i < problems; ++i) {
      Random random(static_cast<std::uint64_t>(i));
      const PoseProblem problem = jammed->make(random, feet);
      PrimitiveSet set(problem.primitives.size());
      test::fill(set, problem);
      PoseSolver solver(problem.primitives.size(), problem.levers_m.size());
      double best_ns = 1e300;
      Balance balance;
      for (int repeat = 0; repeat < repeats; ++repeat) {
        solver.reset();
        const std::uint64_t begin = Clock::now();
        balance = solver.solve(set, problem.step());
        best_ns = std::min(best_ns, clock.ns_between(begin, Clock::now()));
      }
      times.times_ns.push_back(best_ns);
      times.largest_bound_m = std::max(times.largest_bound_m, balance.error_bound_m);
      times.capped += balance.status != BalanceStatus::exact;
    }
  }
  return all;
}

}  // namespace palpa::bench
