// State copy to a second session, the basis of rehearsals of the next tick.
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "palpa/session/session.h"
#include "palpa/solver/solver.h"
#include "tests/session/busy_scene.h"
#include "tests/session/hands.h"

namespace palpa {
namespace rehearsal_test {

/// The exact law without a memory: the warm start, which is not copied, has no effect.
class Forgetful : public Law {
 public:
  Balance solve(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                double time_step_s) noexcept override {
    solver_.reset();
    return solver_.solve(primitives, start_m, probe_m, stiffness_n_per_m, time_step_s);
  }
  std::span<const Vec3> forces_n() const noexcept override { return solver_.forces_n(); }
  void reset() noexcept override { solver_.reset(); }

 private:
  Solver solver_;
};

struct Case {
  bool moves;
  bool as_grid;
};

class Rehearsal : public testing::TestWithParam<Case> {
 protected:
  Session session(double encoder_step_m = 1e-5) const {
    const auto [moves, as_grid] = GetParam();
    return {moves ? test::busy_moving_scene(as_grid) : test::busy_scene(as_grid), std::make_unique<Forgetful>(),
            encoder_step_m};
  }
  // A hand with jerks, so that ticks have pending motion and unfinished steps, and with losses.
  Probe probe(int tick) const {
    const Vec3 at_m = hand_.at(1e-3 * tick);
    return {.position_m = tick % 50 < 2 ? -1.0 * at_m : at_m, .valid = tick % 997 != 996};
  }

 private:
  test::Random random_{1};
  test::Wander hand_{random_, 0.09};
};

void expect_same(const Tick& a, const Tick& b, int tick) {
  ASSERT_EQ(a.proxy_m, b.proxy_m) << tick;
  ASSERT_EQ(a.force_n, b.force_n) << tick;
  ASSERT_EQ(a.status, b.status) << tick;
  ASSERT_EQ(a.sub_steps, b.sub_steps) << tick;
  ASSERT_EQ(a.energy.injected_j, b.energy.injected_j) << tick;
  ASSERT_EQ(a.energy.dissipated_j, b.energy.dissipated_j) << tick;
  ASSERT_EQ(a.energy.released_j, b.energy.released_j) << tick;
}

TEST_P(Rehearsal, GoesOnAsTheFirstDoes) {
  Session first = session(), other = session();
  first.set_force_limit(2.0);  // bone never breaks
  int waiting = 0, in_contact = 0;
  for (int tick = 0; tick < 5000; ++tick) {
    if (tick % 7 == 0) other.copy_state_from(first);
    if (tick % 1000 == 999) other = session(), other.copy_state_from(first);
    const Tick a = first.tick(probe(tick), 1e-3);
    const Tick b = other.tick(probe(tick), 1e-3);
    expect_same(a, b, tick);
    if (HasFatalFailure()) return;
    waiting += a.status == TickStatus::waiting;
    in_contact += norm(a.force_n) > 1e-3;
  }
  EXPECT_GT(in_contact, 500);
  EXPECT_GT(waiting, 20);
}

TEST_P(Rehearsal, LeavesNoTrace) {
  Session alone = session(), first = session(), other = session();
  for (int tick = 0; tick < 5000; ++tick) {
    other.copy_state_from(first);
    other.tick({.position_m = 1.1 * probe(tick).position_m}, 1e-3);
    const Tick a = alone.tick(probe(tick), 1e-3);
    const Tick b = first.tick(probe(tick), 1e-3);
    expect_same(a, b, tick);
    if (HasFatalFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(StillAndMoving, Rehearsal,
                         testing::Values(Case{false, false}, Case{false, true}, Case{true, false}, Case{true, true}),
                         [](const auto& given) {
                           return std::string(given.param.moves ? "Moving" : "Still") +
                                  (given.param.as_grid ? "Grid" : "Formula");
                         });

}  // namespace rehearsal_test
}  // namespace palpa
