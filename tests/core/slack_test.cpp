// Laws of what waits: it does not pull, it fades, and it brings in no energy whatever the proxy does in the meantime.
#include "palpa/core/slack.h"

#include <gtest/gtest.h>

#include <type_traits>

#include "tests/core/random_problems.h"

namespace palpa {
namespace slack_test {

constexpr double k = 500.0;

static_assert(std::is_trivially_copyable_v<Slack>);  // it lies in a session's LiveBlock

/// A slack that remembers what it has let be felt.
class Felt : public Slack {
 public:
  Vec3 felt_m(const Vec3& stretch_m, const Vec3& to_followed_m, double waits_s, const Vec3& probe_step_m) noexcept {
    return last_m_ = Slack::felt_m(stretch_m, to_followed_m, waits_s, last_m_ - probe_step_m);
  }
  /// Before anything has waited.
  Vec3 begin(const Vec3& stretch_m) { return last_m_ = stretch_m; }

 private:
  Vec3 last_m_;
};

// What is left of the spring is all of it: then it is felt to the bit, and there is no slack.
TEST(Slack, IsNoneWhereAllIsPaid) {
  test::Random random(1);
  Slack slack;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 stretch_m = random.in_cube(0.02);
    EXPECT_EQ(slack.felt_m(stretch_m, stretch_m, 0.0, random.uniform(1.0, 3.0) * (1.0 + 1e-15) * stretch_m), stretch_m);
    EXPECT_FALSE(slack.any());
  }
}

// The hand runs away from a proxy that gets nowhere: what is felt stays the force of the place that was followed, and fades.
TEST(Slack, DoesNotPull) {
  Felt slack;
  const Vec3 followed_m{0, 0, 0.002}, step_m{0.0002, 0, -0.0001};
  Vec3 probe_m, felt_m = slack.begin(followed_m);
  double last_m = norm(felt_m);
  for (int tick = 1; tick <= 60; ++tick) {
    probe_m += step_m;
    felt_m = slack.felt_m(followed_m - probe_m, followed_m, 1e-3 * tick, step_m);
    EXPECT_LE(norm(felt_m), last_m);
    EXPECT_NEAR(norm(felt_m), std::max(0.0, 1.0 - tick / 50.0) * norm(followed_m), 1e-15);
    EXPECT_EQ(slack.unfelt_m(), followed_m - probe_m - felt_m);
    last_m = norm(felt_m);
  }
  EXPECT_TRUE(Slack::has_faded(0.05));
  EXPECT_FALSE(Slack::has_faded(0.049));
}

// Anything that a proxy may do, and any hand: no tick brings in more than holding the force of a spring does.
TEST(Slack, BringsInNothing) {
  test::Random random(2);
  for (int run = 0; run < 200; ++run) {
    Felt slack;
    Vec3 proxy_m = random.in_cube(0.01), probe_m = random.in_cube(0.01);
    Vec3 felt_m = slack.begin(proxy_m - probe_m);
    double waits_s = 0.0;
    for (int tick = 0; tick < 300; ++tick) {
      const Vec3 step_m = random.in_cube(0.001);
      probe_m += step_m;
      proxy_m += random.in_cube(0.003);
      waits_s = random.uniform(0, 1) < 0.9 ? random.uniform(1e-3, 0.06) : 0.0;
      const Vec3 before_m = felt_m;
      const Vec3 followed_m = waits_s > 0.0 ? probe_m + random.in_cube(0.02) : probe_m;
      felt_m = slack.felt_m(proxy_m - probe_m, proxy_m - followed_m, waits_s, step_m);
      const double work_j = k * dot(before_m, step_m);
      const double lost_j = 0.5 * k * (norm_squared(before_m) - norm_squared(felt_m));
      ASSERT_LE(work_j, lost_j + 0.5 * k * norm_squared(step_m) + 1e-15);
    }
  }
}

// Once nothing waits the hand makes good what it did not feel, by its own motion and no faster; then all is as it was.
TEST(Slack, IsMadeGoodByTheHandAlone) {
  Felt slack;
  const Vec3 wall_m{};  // the proxy is held here, whatever the hand does
  Vec3 probe_m{0, 0, -0.004};
  for (int tick = 0; tick < 60; ++tick) slack.felt_m(wall_m - probe_m, {}, 1e-3 * tick, {});
  EXPECT_EQ(slack.felt_m(wall_m - probe_m, wall_m - probe_m, 0.0, {}), Vec3{}) << "a still hand is not pushed";
  for (int tick = 1; tick <= 100; ++tick) {  // pressed deeper, it is felt from there on
    probe_m.z -= 1e-5;
    EXPECT_NEAR(slack.felt_m(wall_m - probe_m, wall_m - probe_m, 0.0, {0, 0, -1e-5}).z, 1e-5 * tick, 1e-15);
  }
  for (int tick = 1; tick <= 200; ++tick) {  // drawn back, it is less, and none, but never a pull into the wall
    probe_m.z += 1e-5;
    EXPECT_NEAR(slack.felt_m(wall_m - probe_m, wall_m - probe_m, 0.0, {0, 0, 1e-5}).z, 1e-5 * std::max(0, 100 - tick), 1e-15);
  }
  EXPECT_EQ(slack.felt_m({}, {}, 0.0, {0, 0, 1e-5}), Vec3{}) << "free";
  const Vec3 pressed_m{0, 0, 0.001};
  EXPECT_EQ(slack.felt_m(pressed_m, pressed_m, 0.0, {0, 0, -1e-3}), pressed_m) << "as if nothing had waited";
}

}  // namespace slack_test
}  // namespace palpa
