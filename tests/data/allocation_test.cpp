#include <cstdlib>

#include "palpa/data/analytic.h"
#include "palpa/data/derived.h"
#include "palpa/data/sampled.h"
#include "palpa/data/timed_field.h"
#include "palpa/data/volume.h"
#include "palpa/mode/parameters.h"
#include "tests/data/test_fields.h"
#include "tests/solver/counted_allocations.h"

namespace palpa {
namespace allocation_test {

TEST(Allocation, sampling_a_derived_field_allocates_nothing) {
  std::mt19937 random(2);
  const FieldPtr vortex = sampled(*burgers_vortex().fields[0].field, 17);
  const FieldPtr ball = sphere_field().fields[0].field;
  std::vector<FieldPtr> fields;
  for (int n = 0; n <= static_cast<int>(Derivation::smooth); ++n) {
    const auto derivation = static_cast<Derivation>(n);
    const FieldPtr of = components_taken(derivation) == 3 ? vortex : sampled(*ball, 17);
    fields.push_back(derived(derivation, of));
    fields.push_back(derived(derivation, posed(of, {test::rotation(random), 2.0, {0.1, 0.2, 0.3}})));
  }
  const long at_start = test::allocations;
  double sum = 0.0;
  for (const FieldPtr& field : fields) {
    for (int n = 0; n < 1000; ++n) {
      const Vec3 at = test::within(random, field->bounds_m());
      sum += field->scalar(at).value + field->vector(at).value.x + field->hessian(at).row[0].x + field->depth_m(at);
    }
  }
  EXPECT_EQ(test::allocations, at_start);
  EXPECT_TRUE(std::isfinite(sum));
}

TEST(Allocation, sampling_and_carrying_data_that_change_with_time_allocates_nothing) {
  std::mt19937 random(3);
  const Volume heart = beating_chamber();
  const PoseTrack track{{0.0, {}}, {0.3, {test::rotation(random), 1.5, {0.01, 0.0, 0.02}}}};
  std::vector<FieldPtr> fields;
  for (const VolumeField& f : heart.fields) {
    const FieldPtr series = sampled(f.field, 17, 4);
    fields.insert(fields.end(), {f.field, series, moving(f.field, track), moving(series, track)});
    fields.push_back(derived(f.name == "velocity" ? Derivation::magnitude : Derivation::smooth, series));
  }
  const long at_start = test::allocations;
  double sum = 0.0;
  for (const FieldPtr& field : fields) {
    const TimedField& f = *timed(*field);
    for (int n = 0; n < 1000; ++n) {
      const Vec3 at = test::within(random, field->bounds_m());
      const DataTime when{1e-3 * n, n % 2 == 0};
      sum += f.scalar_at(at, when).value + f.vector_at(at, when).value.x + f.hessian_at(at, when).row[0].x +
             f.depth_at(at, when) + f.carried_m(at, when, {when.time_s + 1e-3, when.loop}).x;
    }
  }
  EXPECT_EQ(test::allocations, at_start);
  EXPECT_TRUE(std::isfinite(sum));
}

TEST(Allocation, sampling_allocates_nothing) {
  std::mt19937 random(1);
  std::vector<FieldPtr> fields;
  for (const AnalyticVolume& a : analytic_volumes()) {
    const FieldPtr formula = a.make().fields[0].field;
    fields.insert(fields.end(),
                  {formula, sampled(*formula, 9), posed(formula, {test::rotation(random), 2.0, {0.1, 0.2, 0.3}})});
  }
  const TransferFunction f({{-300, 0.8}, {300, 0.8}, {300, 4}, {1000, 4}});
  const long at_start = test::allocations;
  double sum = 0.0;
  for (const FieldPtr& field : fields) {
    for (int n = 0; n < 1000; ++n) {
      const Vec3 at = test::within(random, {field->bounds_m().low_m - Vec3{0.1, 0.1, 0.1}, field->bounds_m().high_m});
      sum +=
          f.at(field->scalar(at).value) + f.slope_at(sum) + field->vector(at).value.x + field->depth_m(at) + field->spacing_m();
    }
  }
  EXPECT_EQ(test::allocations, at_start);
  EXPECT_TRUE(std::isfinite(sum));
  EXPECT_GT(test::allocations, 0);  // guards the counter itself
}

}  // namespace allocation_test
}  // namespace palpa
