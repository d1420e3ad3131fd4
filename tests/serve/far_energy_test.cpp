// Energy account and steps of a felt extension under random models.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <utility>

#include "palpa/far/energy_account.h"
#include "palpa/far/local_model.h"
#include "tests/session/hands.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace far_energy_test {

constexpr double dt = 1e-3;
constexpr double k = 500.0;

ModelUpdate any_model(test::Random& random, const Vec3& proxy_m) {
  ModelUpdate model;
  model.proxy_m = proxy_m + random.uniform(0.0, 2e-3) * random.direction();
  model.count = static_cast<std::uint16_t>(random.below(5));
  for (std::size_t n = 0; n < model.count; ++n) {
    ModelRow& row = model.rows[n];
    row.kind = static_cast<PrimitiveKind>(random.below(4));
    row.slot = static_cast<std::uint16_t>(n);
    row.rides = row.kind == PrimitiveKind::point || (row.kind == PrimitiveKind::line && random.below(2) == 0);
    row.direction = row.kind == PrimitiveKind::point ? Vec3{} : random.direction();
    row.offset_m = random.uniform(0.0, 1e-3) * random.direction();
    row.strength_n = static_cast<float>(random.uniform(0.0, 3.0));
    if (row.kind == PrimitiveKind::plane && random.below(3) == 0) row.stiffness_n_per_m = 300.0f;
  }
  return model;
}

// docs/theory.md 11: the work on the hand is at most what the account and the sources have given, k/2 |step|² of each tick, and
// the debt.
TEST(FarEnergy, IsThatOfAccountAndSources) {
  test::Random random(11);
  double most_debt_j = 0.0;
  int in_debt = 0, ticks = 0;
  for (int run = 0; run < 100; ++run) {
    LocalModel model;
    EnergyAccount account;
    const test::Wander wander(random, random.uniform(0.002, 0.02));
    Vec3 proxy_m = wander.at(0.0), probe_m = proxy_m, extension_m;
    double work_j = 0.0, allowed_j = EnergyAccount::full_j, elastic_j = 0.0;
    const int every = 1 + random.below(40);
    for (int n = 1; n < 2000; ++n) {
      const Vec3 next_m = wander.at(n * dt), step_m = next_m - probe_m;
      if (n % every == 0) {
        model.take(any_model(random, proxy_m));
        proxy_m = model.move(model.session_proxy_m(), probe_m, dt, 0.0, k);
        const double before_j = std::exchange(elastic_j, model.elastic_j());
        account.update(extension_m, proxy_m - probe_m, elastic_j - before_j);
        extension_m = proxy_m - probe_m;
      }
      work_j += k * dot(account.felt_m(), step_m);
      proxy_m = model.move(proxy_m, next_m, dt, 0.0, k);
      const double before_j = std::exchange(elastic_j, model.elastic_j()), source_j = model.source_j();
      account.felt_m({.before_m = std::exchange(extension_m, proxy_m - next_m),
                      .now_m = proxy_m - next_m,
                      .probe_step_m = step_m,
                      .time_step_s = dt,
                      .source_j = source_j,
                      .elastic_j = elastic_j - before_j,
                      .stiffness_n_per_m = k});
      probe_m = next_m;
      allowed_j += EnergyAccount::income_w * dt + 0.5 * k * norm_squared(step_m) + std::max(0.0, source_j);
      const double debt_j = std::max(0.0, -account.account_j());
      most_debt_j = std::max(most_debt_j, debt_j);
      in_debt += debt_j > 0.0, ++ticks;
      ASSERT_LE(work_j + 0.5 * k * norm_squared(account.felt_m()), allowed_j + debt_j + 1e-9) << run << " " << n;
    }
  }
  // In debt for what elastic levels hold, and not for long.
  EXPECT_LE(most_debt_j, 20e-3);
  EXPECT_LE(in_debt, ticks / 4);
  std::printf("largest debt %.3f mJ, in debt in %.2f %% of the ticks\n", 1e3 * most_debt_j, 100.0 * in_debt / ticks);
}

TEST(FarEnergy, IsFiniteWhereAnEmptySpringIsInDebt) {
  EnergyAccount account;
  account.update({}, {}, 1.0);  // levels hold more than there was
  EXPECT_EQ(account.felt_m({.time_step_s = 1e-3, .stiffness_n_per_m = 500.0}), Vec3{});
  EXPECT_EQ(account.offset_m(), Vec3{});
  EXPECT_TRUE(std::isfinite(account.account_j()));
  EXPECT_EQ(account.link_j(), 0.0);
}

// An update steps the force by no more than the hand's own motion, the model's, and the spread.
TEST(FarEnergy, StepsNoFurtherThanAnUpdateIsSpread) {
  test::Random random(12);
  EnergyAccount account;
  Vec3 felt_m, extension_m;
  for (int n = 0; n < 1'000'000; ++n) {
    const auto any_m = [&](double most_m) { return random.uniform(0.0, most_m) * random.direction(); };
    if (n % 3 == 0) {
      const Vec3 to_m = any_m(6e-3);
      account.update(extension_m, to_m, random.uniform(-1e-4, 1e-4));
      extension_m = to_m;
    }
    const Vec3 step_m = any_m(5e-4), now_m = extension_m - step_m + any_m(5e-4);
    const EnergyAccount::Step step{
        .before_m = extension_m, .now_m = now_m, .probe_step_m = step_m, .time_step_s = dt, .stiffness_n_per_m = k};
    const double offset_m = norm(account.offset_m());
    const Vec3 next_m = account.felt_m(step);
    const double own_m = distance(now_m, extension_m);
    const double allowed_m = 2.0 * own_m + 2.0 * norm(step_m) + EnergyAccount::shrinks_m(offset_m, step) * 2.0 +
                             EnergyAccount::shrinks_m(norm(now_m) + offset_m, step);
    ASSERT_LE(distance(next_m, felt_m), allowed_m + 1e-12) << n;
    felt_m = next_m;
    extension_m = now_m;
  }
}

}  // namespace far_energy_test
}  // namespace palpa
