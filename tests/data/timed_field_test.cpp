// Time-dependent data: blends, moving poses, carried points and derived fields.
#include "palpa/data/timed_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "palpa/data/analytic.h"
#include "palpa/data/derived.h"
#include "palpa/data/field_at_moment.h"
#include "palpa/data/frame_shift.h"
#include "palpa/data/sampled.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/volume.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace timed_field_test {

using namespace test;

/// A soft wall with level 0 at height z [m]: tanh of the depth over half a width, as a grid of 1 mm over a cube of 40 mm.
FieldPtr wall_at(double z_m, double half_width_m, int samples = 41, double noise = 0.0, std::mt19937* random = nullptr) {
  const double step_m = 0.04 / (samples - 1);
  const GridGeometry geometry{
      {samples, samples, samples}, {{{step_m, 0, 0}, {0, step_m, 0}, {0, 0, step_m}}}, {-0.02, -0.02, -0.02}};
  std::vector<double> values;
  for (int k = 0; k < samples; ++k) {
    for (int n = 0; n < samples * samples; ++n) {
      values.push_back(std::tanh((z_m - (-0.02 + k * step_m)) / half_width_m) +
                       (random ? uniform(*random, -noise, noise) : 0.0));
    }
  }
  return smooth_grid_field(geometry, voxels_of(std::move(values)));
}

const TimedField& as_timed(const FieldPtr& field) { return *timed(*field); }

std::vector<FieldPtr> beating_frames(const char* name, int frames) {
  std::vector<FieldPtr> series;
  const Volume heart = beating_chamber();
  for (const VolumeField& f : heart.fields) {
    if (f.name != name) continue;
    for (int i = 0; i < frames; ++i) series.push_back(sampled(*frozen(f.field, 0.8 * i / frames), 33));
  }
  return series;
}

PoseTrack some_track(std::mt19937& random, int poses) {
  PoseTrack track;
  Mat3 turned = rotation(random);
  for (int i = 0; i < poses; ++i) {
    track.push_back(
        {0.1 * i * (1.0 + 0.1 * i),
         {turned, uniform(random, 0.5, 2.0), {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)}}});
    const double angle = uniform(random, 0.1, 2.5);
    const Mat3 about_z{{{std::cos(angle), -std::sin(angle), 0}, {std::sin(angle), std::cos(angle), 0}, {0, 0, 1}}};
    const Mat3 q = rotation(random);
    turned = q * about_z * transposed(q) * turned;
  }
  return track;
}

TEST(TimeSeries, is_each_frame_at_its_moment_and_the_blend_of_two_between) {
  std::mt19937 random(1);
  for (const char* name : {"signal", "velocity"}) {
    const std::vector<FieldPtr> frames = beating_frames(name, 5);
    const double period_s = 0.1;
    const FieldPtr series = time_series(frames, period_s);
    const TimedField& field = as_timed(series);
    EXPECT_DOUBLE_EQ(field.cycle_s(), 0.5);
    for (int n = 0; n < 300; ++n) {
      const Vec3 x = within(random, series->bounds_m());
      for (int i = 0; i < 5; ++i) {
        for (const bool loop : {false, true}) {
          EXPECT_EQ(field.scalar_at(x, {i * period_s, loop}).value, frames[i]->scalar(x).value);
          EXPECT_EQ(field.scalar_at(x, {i * period_s, loop}).gradient, frames[i]->scalar(x).gradient);
          EXPECT_EQ(field.vector_at(x, {i * period_s, loop}).jacobian, frames[i]->vector(x).jacobian);
          EXPECT_EQ(field.hessian_at(x, {i * period_s, loop}), frames[i]->hessian(x));
        }
        EXPECT_EQ(field.scalar_at(x, {i * period_s + 5e3 * period_s, true}).inside, frames[i]->scalar(x).inside);
      }
      const double u = uniform(random, 0.01, 0.99);
      const int i = n % 5, next = (i + 1) % 5;
      const DataTime at{(i + u) * period_s, true};
      const ScalarSample a = frames[i]->scalar(x), b = frames[next]->scalar(x), s = field.scalar_at(x, at);
      EXPECT_NEAR(s.value, (1 - u) * a.value + u * b.value, 1e-12);
      EXPECT_LT(norm(s.gradient - (1 - u) * a.gradient - u * b.gradient), 1e-9);
      const VectorSample c = frames[i]->vector(x), d = frames[next]->vector(x), v = field.vector_at(x, at);
      EXPECT_LT(norm(v.value - (1 - u) * c.value - u * d.value), 1e-12);
      EXPECT_EQ(s.inside, a.inside && b.inside);
      EXPECT_EQ(v.inside, c.inside && d.inside);
    }
  }
}

TEST(TimeSeries, stays_at_its_ends_unless_it_is_looped) {
  const FieldPtr series = time_series({wall_at(0.0, 2e-3), wall_at(1e-3, 2e-3), wall_at(2e-3, 2e-3)}, 0.1);
  const TimedField& field = as_timed(series);
  const Vec3 x{1e-3, 2e-3, 0.7e-3};
  EXPECT_EQ(field.scalar_at(x, 0.2).value, field.scalar_at(x, 7.0).value);
  EXPECT_EQ(field.scalar_at(x, 0.0).value, field.scalar_at(x, -7.0).value);
  EXPECT_EQ(field.scalar_at(x, 0.0).value, field.scalar_at(x, std::nan("")).value);
  EXPECT_EQ(field.scalar_at(x, 0.0).value, field.scalar_at(x, {std::numeric_limits<double>::infinity(), true}).value);
  // The last frame blends into the first after one period.
  const double last = field.scalar_at(x, 0.2).value, first = field.scalar_at(x, 0.0).value;
  EXPECT_NEAR(field.scalar_at(x, {0.25, true}).value, 0.5 * (last + first), 1e-12);
  EXPECT_NEAR(field.scalar_at(x, {-0.05, true}).value, 0.5 * (last + first), 1e-12);
  EXPECT_NEAR(field.scalar_at(x, {0.3 - 1e-9, true}).value, first, 1e-6);
}

TEST(TimeSeries, the_nearer_frame_if_asked_for) {
  const std::vector<FieldPtr> frames{wall_at(0.0, 2e-3), wall_at(1e-3, 2e-3)};
  const FieldPtr series = time_series(frames, 0.1, BetweenFrames::nearest);
  const Vec3 x{1e-3, 2e-3, 0.7e-3};
  EXPECT_EQ(as_timed(series).scalar_at(x, 0.049).value, frames[0]->scalar(x).value);
  EXPECT_EQ(as_timed(series).scalar_at(x, 0.051).value, frames[1]->scalar(x).value);
  EXPECT_EQ(as_timed(series).scalar_at(x, {0.151, true}).value, frames[0]->scalar(x).value);
}

TEST(TimeSeries, its_derivatives_are_those_of_its_values) {
  std::mt19937 random(2);
  const FieldPtr signal = time_series({wall_at(0.0, 4e-3), wall_at(1e-3, 4e-3), wall_at(3e-3, 4e-3)}, 0.1);
  const FieldPtr velocity = time_series(beating_frames("velocity", 4), 0.2);
  for (int n = 0; n < 200; ++n) {
    const DataTime at{uniform(random, 0.0, 0.3), true};
    const FieldPtr a = frozen(signal, at), b = frozen(velocity, at);
    const Vec3 x = 0.9 * within(random, a->bounds_m());
    EXPECT_LT(norm(a->scalar(x).gradient - numeric_gradient(*a, x, 1e-5)), 1e-3 * (1.0 + norm(a->scalar(x).gradient)));
    Mat3 numeric;
    for (int i = 0; i < 3; ++i) {
      numeric.row[i] = (a->scalar(x + 1e-6 * axis(i)).gradient - a->scalar(x - 1e-6 * axis(i)).gradient) / 2e-6;
    }
    EXPECT_LT(largest_difference(a->hessian(x), transposed(numeric)), 1.0) << "of up to 1e5 per m²";
    EXPECT_EQ(b->scalar(x).inside, false);
  }
}

/// A polynomial from its Bernstein coefficients (P. de Casteljau).
double value_of(const PolynomialPiece& piece, double share) {
  double b[10];
  std::copy(piece.control, piece.control + 10, b);
  for (int n = piece.degree; n > 0; --n) {
    for (int i = 0; i < n; ++i) b[i] += share * (b[i + 1] - b[i]);
  }
  return b[0];
}

TEST(TimedField, along_a_straight_way_it_is_pieces_that_hold_its_values) {
  std::mt19937 random(15);
  const PoseTrack track = some_track(random, 3);
  const FieldPtr smooth = time_series({wall_at(0.0, 2e-3), wall_at(1e-3, 2e-3), wall_at(2e-3, 2e-3)}, 0.1);
  const FieldPtr linear = time_series(beating_frames("signal", 4), 0.1);
  for (const FieldPtr& field :
       {smooth, linear, moving(smooth, track), moving(linear, track), moving(series_of(*linear)->frames[0], track)}) {
    const TimedField& f = as_timed(field);
    for (int n = 0; n < 40; ++n) {
      const DataTime at{uniform(random, 0.0, 0.4), n % 2 == 0};
      const Similarity pose = moving_of(*field) ? pose_at(track, at) : Similarity{};
      const Vec3 from = pose.to_world(1.2 * within(random, smooth->bounds_m()));
      const Vec3 to = pose.to_world(1.2 * within(random, smooth->bounds_m()));
      const ValueRange quiet = n % 4 < 2 ? ValueRange{0.3, 0.9} : ValueRange{1.0, -1.0};
      int pieces = 0;
      for (double begin = 0.0; begin < 1.0 && pieces < 5000; ++pieces) {
        const PolynomialPiece piece = f.piece_along_at(from, to, begin, quiet, at);
        ASSERT_GT(piece.end, begin);
        for (const double share : {0.1, 0.5, 0.9}) {
          const double s = begin + share * (piece.end - begin);
          const ScalarSample sample = f.scalar_at(from + s * (to - from), at);
          ASSERT_EQ(sample.inside, piece.inside) << n << ": " << s;
          if (!piece.inside) continue;
          if (piece.degree < 0) {
            ASSERT_TRUE(sample.value > quiet.min && sample.value < quiet.max);
          } else {
            ASSERT_NEAR(value_of(piece, share), sample.value, 1e-9) << n << ": " << s;
          }
        }
        begin = piece.end;
      }
      ASSERT_LT(pieces, 5000);
    }
  }
}

TEST(TimedField, at_a_moment_it_is_one_field_to_the_bit) {
  std::mt19937 random(16);
  const PoseTrack track = some_track(random, 3), other = some_track(random, 2);
  const FieldPtr signal = time_series(beating_frames("signal", 4), 0.1), flow = time_series(beating_frames("velocity", 4), 0.1);
  const FieldPtr moved = moving(signal, track, 1);
  const FieldPtr formula = beating_chamber().fields[0].field;
  for (const FieldPtr& field : {signal, flow, moved, moving(moved, other), moving(flow, track), moving(formula, track), formula,
                                derived(Derivation::magnitude, moving(flow, track)), derived(Derivation::component_x, flow)}) {
    const TimedField& f = as_timed(field);
    for (int n = 0; n < 60; ++n) {
      const DataTime at{n % 3 == 0 ? 0.1 * (n % 4) : uniform(random, 0.0, 0.4), n % 2 == 0};
      const FieldAtMoment now = f.at_moment(at);
      const FieldPtr kept = frozen(field, at);
      const Vec3 x = within(random, field->bounds_m()), y = within(random, field->bounds_m());
      EXPECT_EQ(now.scalar(x).value, f.scalar_at(x, at).value);
      EXPECT_EQ(now.scalar(x).gradient, f.scalar_at(x, at).gradient);
      EXPECT_EQ(now.vector(x).jacobian, f.vector_at(x, at).jacobian);
      EXPECT_EQ(now.hessian(x), f.hessian_at(x, at));
      EXPECT_EQ(now.depth_m(x), f.depth_at(x, at));
      EXPECT_EQ(now.local_spacing_m(x), f.local_spacing_at(x, at));
      EXPECT_EQ(now.lipschitz_bound(x).radius_m, f.lipschitz_bound_at(x, at).radius_m);
      EXPECT_EQ(kept->lipschitz_bound(x).slope_per_m, f.lipschitz_bound_at(x, at).slope_per_m);
      const PolynomialPiece a = now.piece_along(x, y, 0.1, {1.0, -1.0}), b = f.piece_along_at(x, y, 0.1, {1.0, -1.0}, at);
      EXPECT_EQ(a.end, b.end);
      EXPECT_TRUE(std::ranges::equal(a.control, b.control));
    }
  }
}

TEST(TimedField, that_stands_at_a_frame_is_that_frame) {
  const std::vector<FieldPtr> frames = beating_frames("signal", 2);
  const FieldPtr series = time_series(frames, 0.1);
  EXPECT_EQ(as_timed(series).at_moment(0.0).plain(), frames[0].get());
  EXPECT_EQ(as_timed(series).at_moment(7.0).plain(), frames[1].get());
  EXPECT_EQ(as_timed(series).at_moment(0.0).values_per_sample(), frames[0]->values_per_sample());
  EXPECT_EQ(as_timed(series).at_moment(0.05).values_per_sample(), 2 * frames[0]->values_per_sample());
}

TEST(TimeSeries, refuses_what_is_no_series) {
  const FieldPtr wall = wall_at(0.0, 2e-3);
  EXPECT_THROW(time_series({}, 0.1), std::invalid_argument);
  EXPECT_THROW(time_series({wall, nullptr}, 0.1), std::invalid_argument);
  EXPECT_THROW(time_series({wall, wall_at(0.0, 2e-3, 31)}, 0.1), std::invalid_argument);
  EXPECT_THROW(time_series({wall, posed(wall, {Mat3::identity(), 1.0, {1e-3, 0, 0}})}, 0.1), std::invalid_argument);
  EXPECT_THROW(time_series({wall, lamb_oseen_vortex().fields[0].field}, 0.1), std::invalid_argument);
  EXPECT_THROW(time_series({time_series({wall}, 0.1)}, 0.1), std::invalid_argument);
  for (const double period_s : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(time_series({wall, wall}, period_s), std::invalid_argument);
  }
}

TEST(TimeSeries, a_point_keeps_its_value_and_moves_along_the_gradient) {
  // Frames a quarter of the edge's half-width apart: the blend moves the level nearly evenly.
  std::vector<FieldPtr> frames;
  for (int i = 0; i < 9; ++i) frames.push_back(wall_at(0.5e-3 * i, 2e-3));
  const FieldPtr series = time_series(std::move(frames), 0.05);
  const TimedField& field = as_timed(series);
  std::mt19937 random(3);
  for (int n = 0; n < 300; ++n) {
    const double from_s = uniform(random, 0.0, 0.38), to_s = from_s + uniform(random, 0.001, 0.02);
    const Vec3 x{uniform(random, -0.01, 0.01), uniform(random, -0.01, 0.01),
                 0.5e-3 * from_s / 0.05 + uniform(random, -1e-3, 1e-3)};
    const Carried there = field.carried(x, from_s, to_s);
    ASSERT_TRUE(there.known);
    EXPECT_NEAR(field.scalar_at(there.position_m, to_s).value, field.scalar_at(x, from_s).value, 1e-6);
    EXPECT_NEAR(there.position_m.z - x.z, 0.5e-3 * (to_s - from_s) / 0.05, 0.1 * 0.5e-3 * (to_s - from_s) / 0.05);
    EXPECT_NEAR(there.position_m.x, x.x, 1e-12);
    const Carried back = field.carried(there.position_m, to_s, from_s);
    ASSERT_TRUE(back.known);
    EXPECT_LT(distance(back.position_m, x), 1e-9);
    EXPECT_EQ(field.carried_m(x, from_s, from_s), x);
  }
}

TEST(TimeSeries, in_many_small_steps_a_point_rides_on_its_level) {
  std::vector<FieldPtr> frames;
  for (int i = 0; i < 9; ++i) frames.push_back(wall_at(0.5e-3 * i, 2e-3));
  const FieldPtr series = time_series(std::move(frames), 0.05);
  const TimedField& field = as_timed(series);
  Vec3 x{1e-3, -2e-3, 0.3e-3};
  const double value = field.scalar_at(x, 0.0).value;
  for (int tick = 0; tick < 400; ++tick) x = field.carried_m(x, tick * 1e-3, (tick + 1) * 1e-3);
  EXPECT_NEAR(field.scalar_at(x, 0.4).value, value, 1e-7);
  EXPECT_NEAR(x.z, 4.3e-3, 1e-5);  // at a frame the wall equals the first, moved
}

// Findings 24: a level's shift beyond its edge's width makes a linear blend jump.
TEST(TimeSeries, says_where_a_level_jumps_instead_of_carrying_it) {
  for (const double half_widths : {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0}) {
    const double half_m = 1e-3, shift_m = half_widths * half_m;
    const FieldPtr series = time_series({wall_at(-0.5 * shift_m, half_m, 81), wall_at(0.5 * shift_m, half_m, 81)}, 0.04);
    const TimedField& field = as_timed(series);
    Vec3 x{0, 0, -0.5 * shift_m};
    const double value = field.scalar_at(x, 0.0).value;
    bool known = true;
    double fastest_m = 0.0;
    for (int tick = 0; tick < 40; ++tick) {
      const Carried there = field.carried(x, tick * 1e-3, (tick + 1) * 1e-3);
      EXPECT_TRUE(there.known || there.position_m == x);
      known = known && there.known;
      fastest_m = std::max(fastest_m, distance(there.position_m, x));
      x = there.position_m;
    }
    EXPECT_LE(fastest_m, 0.5 * series->spacing_m());
    EXPECT_TRUE(known || half_widths > 2.0) << half_widths;
    EXPECT_TRUE(!known || half_widths < 6.0) << half_widths;
    EXPECT_NEAR(field.scalar_at(x, 0.04).value, value, known ? 1e-6 : 2.0);
  }
}

TEST(TimeSeries, carries_nothing_where_a_gradient_is_noise) {
  std::mt19937 random(4);
  std::vector<FieldPtr> frames;
  for (int i = 0; i < 3; ++i) frames.push_back(wall_at(0.2e-3 * i, 2e-3, 41, 0.05, &random));
  const FieldPtr series = time_series(std::move(frames), 0.05);
  const TimedField& field = as_timed(series);
  int lost = 0, carried = 0;
  for (int n = 0; n < 1000; ++n) {
    const Vec3 flat{uniform(random, -0.015, 0.015), uniform(random, -0.015, 0.015), uniform(random, 0.012, 0.018)};
    lost += !field.carried(flat, 0.01, 0.011).known;
    const Vec3 edge{flat.x, flat.y, uniform(random, -0.5e-3, 0.5e-3)};
    carried += field.carried(edge, 0.01, 0.011).known;
  }
  EXPECT_GT(lost, 900);
  EXPECT_EQ(carried, 1000);
}

TEST(FrameShift, is_the_way_of_a_level_by_the_width_of_its_edge) {
  // A tanh over half a width w rises by 2 tanh(1.82) = 1.9 where it is at least a tenth as steep as at its middle: 1.9 w.
  const double half_m = 2e-3, width_m = 1.9 * half_m;
  for (const double shift_m : {0.2e-3, 1e-3, 4e-3, 8e-3}) {
    std::vector<FieldPtr> frames;
    for (int i = 0; i < 3; ++i) frames.push_back(wall_at(-8e-3 + shift_m * i, half_m, 81));
    const FieldPtr series = time_series(std::move(frames), 0.1);
    for (const bool at_level : {false, true}) {
      const FrameShift shift = frame_shift(*series_of(*series), at_level ? std::optional(0.0) : std::optional<double>());
      EXPECT_GT(shift.places, 100);
      EXPECT_NEAR(shift.median, shift_m / width_m, 0.1 * shift_m / width_m) << shift_m;
      EXPECT_NEAR(shift.p90, shift_m / width_m, 0.15 * shift_m / width_m);
      EXPECT_EQ(shift.lost_share, 0.0);
    }
  }
  // A wall that vanishes in the next frame, and fields that are no scalar series.
  const FieldPtr gone = time_series({wall_at(0.0, half_m), wall_at(1.0, half_m)}, 0.1);
  EXPECT_EQ(frame_shift(*series_of(*gone), 0.0).lost_share, 1.0);
  EXPECT_TRUE(std::isinf(frame_shift(*series_of(*gone), 0.0).median));
  EXPECT_EQ(frame_shift(*series_of(*time_series(beating_frames("velocity", 2), 0.1))).places, 0);
  EXPECT_EQ(frame_shift(*series_of(*time_series({wall_at(0.0, half_m)}, 0.1))).places, 0);
}

TEST(Moving, is_the_posed_field_at_every_moment) {
  std::mt19937 random(5);
  const FieldPtr ball = sampled(*sphere_field().fields[0].field, 33), vortex = burgers_vortex().fields[0].field;
  for (int n = 0; n < 20; ++n) {
    const PoseTrack track = some_track(random, 4);
    const FieldPtr moving_ball = moving(ball, track), moving_vortex = moving(vortex, track);
    for (int m = 0; m < 50; ++m) {
      const bool at_a_pose = m < 4;
      const DataTime at{at_a_pose ? track[static_cast<std::size_t>(m)].time_s : uniform(random, -0.2, 1.0), m % 8 >= 4};
      const Similarity pose = pose_at(track, at);
      ASSERT_TRUE(is_usable(pose));
      EXPECT_TRUE(!at_a_pose || pose == track[static_cast<std::size_t>(m)].pose);
      const FieldPtr still_ball = posed(ball, pose), still_vortex = posed(vortex, pose);
      const Vec3 x = pose.to_world(within(random, ball->bounds_m()));
      const ScalarSample a = as_timed(moving_ball).scalar_at(x, at), b = still_ball->scalar(x);
      EXPECT_EQ(a.value, b.value);
      EXPECT_EQ(a.gradient, b.gradient);
      EXPECT_EQ(as_timed(moving_ball).hessian_at(x, at), still_ball->hessian(x));
      EXPECT_EQ(as_timed(moving_ball).depth_at(x, at), still_ball->depth_m(x));
      const VectorSample u = as_timed(moving_vortex).vector_at(x, at), v = still_vortex->vector(x);
      EXPECT_EQ(u.value, v.value);
      EXPECT_EQ(u.jacobian, v.jacobian);
      const Box box = moving_ball->bounds_m();
      EXPECT_TRUE(!b.inside || (x.x >= box.low_m.x && x.y >= box.low_m.y && x.z >= box.low_m.z && x.x <= box.high_m.x &&
                                x.y <= box.high_m.y && x.z <= box.high_m.z));
    }
  }
}

TEST(Moving, goes_steadily_from_pose_to_pose) {
  std::mt19937 random(6);
  const PoseTrack track = some_track(random, 3);
  for (std::size_t i = 1; i < track.size(); ++i) {
    const double length_s = track[i].time_s - track[i - 1].time_s;
    const auto at = [&](double u) { return pose_at(track, track[i - 1].time_s + u * length_s); };
    const auto angle = [](const Similarity& a, const Similarity& b) {
      const Mat3 r = b.rotation * transposed(a.rotation);
      return std::acos(std::clamp(0.5 * (r.row[0].x + r.row[1].y + r.row[2].z - 1.0), -1.0, 1.0));
    };
    const double whole = angle(track[i - 1].pose, track[i].pose);
    for (double u = 0.1; u < 0.95; u += 0.1) {
      EXPECT_NEAR(angle(at(u), at(u + 0.05)), 0.05 * whole, 1e-6);
      EXPECT_NEAR(std::log(at(u + 0.05).scale / at(u).scale), 0.05 * std::log(track[i].pose.scale / track[i - 1].pose.scale),
                  1e-9);
      EXPECT_LT(norm(at(u + 0.05).translation_m - at(u).translation_m -
                     0.05 * (track[i].pose.translation_m - track[i - 1].pose.translation_m)),
                1e-12);
    }
    EXPECT_LT(distance(at(1.0 - 1e-9).translation_m, track[i].pose.translation_m), 1e-7);
    EXPECT_NEAR(angle(at(1.0 - 1e-7), track[i].pose), 0.0, 1e-5);
  }
}

TEST(Moving, carries_its_points_with_it_there_and_back) {
  std::mt19937 random(7);
  const FieldPtr ball = sphere_field().fields[0].field;
  for (int n = 0; n < 200; ++n) {
    const PoseTrack track = some_track(random, 3);
    const FieldPtr field = moving(ball, track);
    const double from_s = uniform(random, 0.0, 0.3), to_s = uniform(random, 0.0, 0.3);
    const Vec3 local = within(random, ball->bounds_m()), x = pose_at(track, from_s).to_world(local);
    const Carried there = as_timed(field).carried(x, from_s, to_s);
    ASSERT_TRUE(there.known);
    EXPECT_LT(distance(there.position_m, pose_at(track, to_s).to_world(local)), 1e-14);
    EXPECT_LT(distance(as_timed(field).carried_m(there.position_m, to_s, from_s), x), 1e-14);
    EXPECT_NEAR(as_timed(field).scalar_at(x, from_s).value, as_timed(field).scalar_at(there.position_m, to_s).value, 1e-12);
    // Data stand still after the last pose.
    EXPECT_EQ(as_timed(field).carried_m(x, 50.0, 51.0), x);
  }
}

TEST(Moving, a_loop_that_does_not_close_carries_nothing_across_its_seam) {
  const FieldPtr ball = sphere_field().fields[0].field;
  const FieldPtr open = moving(ball, {{0.0, {}}, {1.0, {Mat3::identity(), 1.0, {0.1, 0, 0}}}});
  const Vec3 x{0.02, 0, 0};
  EXPECT_FALSE(as_timed(open).carried(x, {0.999, true}, {1.001, true}).known);
  EXPECT_EQ(as_timed(open).carried_m(x, {0.999, true}, {1.001, true}), x);
  EXPECT_TRUE(as_timed(open).carried(x, {0.998, true}, {0.999, true}).known);
  const FieldPtr closed = moving(ball, {{0.0, {}}, {0.5, {Mat3::identity(), 1.0, {0.1, 0, 0}}}, {1.0, {}}});
  EXPECT_TRUE(as_timed(closed).carried(x, {0.999, true}, {1.001, true}).known);
}

TEST(Moving, a_series_that_moves_does_both) {
  std::mt19937 random(8);
  std::vector<FieldPtr> frames;
  for (int i = 0; i < 3; ++i) frames.push_back(wall_at(0.5e-3 * i, 2e-3));
  const FieldPtr series = time_series(std::move(frames), 0.1);
  const PoseTrack track = some_track(random, 3);
  const FieldPtr both = moving(series, track), still = posed(series, track[1].pose);
  ASSERT_NE(timed(*still), nullptr);
  for (int n = 0; n < 100; ++n) {
    const DataTime from = uniform(random, 0.0, 0.15), to = from.time_s + 0.002;
    const Vec3 local{uniform(random, -0.01, 0.01), uniform(random, -0.01, 0.01), uniform(random, -1e-3, 1e-3)};
    const Vec3 x = pose_at(track, from).to_world(local);
    EXPECT_NEAR(as_timed(both).scalar_at(x, from).value, as_timed(series).scalar_at(local, from).value, 1e-9);
    const Carried there = as_timed(both).carried(x, from, to);
    ASSERT_TRUE(there.known);
    EXPECT_LT(distance(there.position_m, pose_at(track, to).to_world(as_timed(series).carried_m(local, from, to))), 1e-11);
    EXPECT_NEAR(as_timed(still).scalar_at(track[1].pose.to_world(local), from).value,
                as_timed(series).scalar_at(local, from).value, 1e-9);
  }
}

TEST(Moving, refuses_a_track_that_is_none) {
  const FieldPtr ball = sphere_field().fields[0].field;
  const Mat3 half{{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}};
  const PoseTrack wrong[] = {{},
                             {{0.5, {}}},
                             {{0.0, {}}, {0.0, {}}},
                             {{0.0, {}}, {1.0, {}}, {0.5, {}}},
                             {{0.0, {}}, {std::nan(""), {}}},
                             {{0.0, {}}, {1.0, {Mat3::identity(), 0.0, {}}}},
                             {{0.0, {}}, {1.0, {half, 1.0, {}}}}};
  for (const PoseTrack& track : wrong) {
    EXPECT_NE(problem_with(track), nullptr);
    EXPECT_THROW(moving(ball, track), std::invalid_argument);
  }
  EXPECT_EQ(problem_with(PoseTrack{{0.0, {}}, {1.0, {}}}), nullptr);
  EXPECT_EQ(timed(*moving(ball, {{0.0, {Mat3::identity(), 2.0, {}}}})), nullptr);
}

TEST(TimedDerived, is_the_derived_field_of_each_frame_at_its_moment) {
  std::mt19937 random(9);
  const std::vector<FieldPtr> velocity = beating_frames("velocity", 3), signal = beating_frames("signal", 3);
  for (int n = 0; n <= static_cast<int>(Derivation::smooth); ++n) {
    const auto derivation = static_cast<Derivation>(n);
    const std::vector<FieldPtr>& frames = components_taken(derivation) == 3 ? velocity : signal;
    const FieldPtr field = derived(derivation, time_series(frames, 0.1));
    ASSERT_NE(timed(*field), nullptr) << name_of(derivation);
    const FieldPtr second = derived(derivation, frames[1]);
    for (int m = 0; m < 100; ++m) {
      const Vec3 x = within(random, field->bounds_m());
      EXPECT_EQ(as_timed(field).scalar_at(x, 0.1).value, second->scalar(x).value) << name_of(derivation);
      EXPECT_EQ(as_timed(field).scalar_at(x, 0.1).gradient, second->scalar(x).gradient);
      EXPECT_EQ(as_timed(field).vector_at(x, 0.1).value, second->vector(x).value);
    }
  }
}

TEST(TimedDerived, of_a_field_that_moves_moves_with_it) {
  std::mt19937 random(10);
  const FieldPtr vortex = sampled(*burgers_vortex().fields[0].field, 33), ball = sampled(*sphere_field().fields[0].field, 33);
  const PoseTrack track = some_track(random, 3);
  for (int n = 0; n <= static_cast<int>(Derivation::smooth); ++n) {
    const auto derivation = static_cast<Derivation>(n);
    const FieldPtr of = components_taken(derivation) == 3 ? vortex : ball;
    const double smoothing_m = 2.0 * of->spacing_m();
    const FieldPtr field = derived(derivation, moving(of, track), smoothing_m * track.front().pose.scale);
    ASSERT_NE(timed(*field), nullptr) << name_of(derivation);
    for (int m = 0; m < 50; ++m) {
      const double at_s = uniform(random, 0.0, 0.25);
      const Similarity pose = pose_at(track, at_s);
      const FieldPtr still = derived(derivation, posed(of, pose), smoothing_m * pose.scale);
      const Vec3 x = pose.to_world(within(random, of->bounds_m()));
      const ValueRange range = still->value_ranges().front();
      const double size = 1e-5 * std::max(std::abs(range.min), std::abs(range.max));  // voxels of derived fields are floats
      EXPECT_NEAR(as_timed(field).scalar_at(x, at_s).value, still->scalar(x).value, size) << name_of(derivation);
      EXPECT_LT(norm(as_timed(field).vector_at(x, at_s).value - still->vector(x).value), size);
      if (m == 3) break;  // a field is derived for each
    }
  }
}

TEST(BeatingChamber, is_free_of_divergence_and_moves_with_its_wall) {
  std::mt19937 random(11);
  const Volume heart = beating_chamber();
  ASSERT_EQ(heart.fields.size(), 2u);
  const TimedField &velocity = as_timed(heart.fields[0].field), &signal = as_timed(heart.fields[1].field);
  double fastest = 0.0;
  for (int n = 0; n < 3000; ++n) {
    const Vec3 x = 0.98 * within(random, velocity.bounds_m());
    const DataTime at{uniform(random, 0.0, 3.0), true};
    const FieldPtr u = frozen(heart.fields[0].field, at), phi = frozen(heart.fields[1].field, at);
    const VectorSample v = u->vector(x);
    ASSERT_TRUE(v.inside);
    EXPECT_NEAR(v.jacobian.row[0].x + v.jacobian.row[1].y + v.jacobian.row[2].z, 0.0, 1e-10);
    EXPECT_LT(largest_difference(v.jacobian, numeric_jacobian(*u, x, 1e-5)), 1e-2) << "of up to 300 1/s";
    EXPECT_LT(norm(phi->scalar(x).gradient - numeric_gradient(*phi, x, 1e-6)), 1.0) << "of up to 1000 1/m";
    fastest = std::max(fastest, largest_component(v.value));

    // Carried points keep their signal; after the first moment they move with the wall.
    const DataTime later{at.time_s + 0.05, true};
    const Vec3 carried_m = signal.carried_m(x, at, later);
    EXPECT_NEAR(signal.scalar_at(carried_m, later).value, signal.scalar_at(x, at).value, 1e-12);
    EXPECT_LT(distance(signal.carried_m(carried_m, later, at), x), 1e-16);
    const DataTime soon{at.time_s + 1e-6, true};
    if (std::abs(signal.scalar_at(x, at).value) < 1e-3) {  // at the wall and beyond the blood moves with it
      EXPECT_LT(norm((signal.carried_m(x, at, soon) - x) / 1e-6 - v.value), 2e-3);
    }
  }
  EXPECT_LE(fastest, heart.fields[0].field->value_ranges()[0].max);
  EXPECT_GT(fastest, 0.4);
  const Vec3 x{0.01, 0.005, -0.01};
  EXPECT_LT(norm(velocity.vector_at(x, {0.1 + 8 * 0.8, true}).value - velocity.vector_at(x, {0.1, true}).value), 1e-12);
}

TEST(BeatingChamber, frames_of_it_come_close_to_it_as_they_grow_in_number) {
  std::mt19937 random(12);
  const FieldPtr signal = beating_chamber().fields[1].field;
  double worst[2];
  for (int i = 0; i < 2; ++i) {
    std::vector<FieldPtr> frames;
    const int count = i == 0 ? 20 : 80;
    for (int n = 0; n < count; ++n) frames.push_back(frozen(signal, 0.8 * n / count));
    const FieldPtr series = time_series(std::move(frames), 0.8 / count);
    std::mt19937 places(13);
    worst[i] = 0.0;
    for (int n = 0; n < 5000; ++n) {
      const Vec3 x = within(places, series->bounds_m());
      const DataTime at{uniform(places, 0.0, 0.8), true};
      worst[i] =
          std::max(worst[i], std::abs(as_timed(series).scalar_at(x, at).value - as_timed(signal).scalar_at(x, at).value));
    }
  }
  EXPECT_LT(worst[1], 0.2 * worst[0]);
  EXPECT_LT(worst[0], 0.15);
  const FieldPtr series = sampled(signal, 81, 20);
  ASSERT_NE(series_of(*series), nullptr);
  EXPECT_EQ(series_of(*series)->frames.size(), 20u);
  EXPECT_NEAR(as_timed(series).cycle_s(), 0.8, 1e-15);
}

TEST(TimedField, is_finite_whatever_the_position_and_the_moment) {
  std::mt19937 random(14);
  const PoseTrack track = some_track(random, 4);
  const FieldPtr signal = time_series(beating_frames("signal", 3), 0.1),
                 velocity = time_series(beating_frames("velocity", 3), 0.1);
  const Volume heart = beating_chamber();
  const std::vector<FieldPtr> fields{signal,
                                     velocity,
                                     moving(signal, track),
                                     moving(sphere_field().fields[0].field, track),
                                     moving(burgers_vortex().fields[0].field, track),
                                     heart.fields[0].field,
                                     heart.fields[1].field,
                                     derived(Derivation::magnitude, velocity),
                                     derived(Derivation::component_y, moving(velocity, track)),
                                     derived(Derivation::q, moving(velocity, track)),
                                     derived(Derivation::smooth, signal)};
  std::vector<Vec3> positions = absurd_positions();
  for (int n = 0; n < 300; ++n) positions.push_back(within(random, {{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}}));
  for (int n = 0; n < 300; ++n) positions.push_back(within(random, {{-0.03, -0.03, -0.03}, {0.03, 0.03, 0.03}}));
  const double moments[] = {0.0, 0.05, 0.123, -1.0, 1e300, -1e300, std::nan(""), std::numeric_limits<double>::infinity(), 1e9};
  bool finite = true;
  for (const FieldPtr& field : fields) {
    const TimedField& f = *timed(*field);
    for (const Vec3& x : positions) {
      for (const double moment : moments) {
        for (const bool loop : {false, true}) {
          const DataTime at{moment, loop};
          const ScalarSample s = f.scalar_at(x, at);
          const VectorSample v = f.vector_at(x, at);
          finite = finite && std::isfinite(s.value) && is_finite(s.gradient) && is_finite(v.value) && is_finite(v.jacobian) &&
                   is_finite(f.hessian_at(x, at)) && std::isfinite(f.depth_at(x, at));
          if (is_finite(x)) finite = finite && is_finite(f.carried_m(x, at, {moment + 0.001, loop}));
        }
      }
    }
  }
  EXPECT_TRUE(finite);
}

}  // namespace timed_field_test
}  // namespace palpa
