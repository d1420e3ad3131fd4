// Energy that friction lines take from a wandering hand.
#pragma once

#include <gtest/gtest.h>

#include "palpa/session/session.h"
#include "tests/session/hands.h"

namespace palpa::test {

/// In no tick the lines bring energy in, and over three seconds they take some.
inline void expect_that_friction_takes(Session& session, const Wander& hand) {
  constexpr double dt_s = 1e-3;
  double taken_j = 0.0;
  for (int i = 0; i < 3000; ++i) {
    session.tick({.position_m = hand.at(dt_s * i)}, dt_s);
    double brought_j = 0.0;
    for (const SubStep& step : session.sub_steps()) {
      for (const PlacedPrimitive& row : session.primitives().subspan(step.first_primitive, step.primitives)) {
        if (row.primitive.kind == PrimitiveKind::line) brought_j += work_j(step, row);
      }
    }
    ASSERT_LE(brought_j, 1e-12) << "tick " << i;
    taken_j -= brought_j;
  }
  EXPECT_GT(taken_j, 0.0);
}

}  // namespace palpa::test
