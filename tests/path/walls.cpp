#include "tests/path/walls.h"

#include <cmath>
#include <limits>

#include "palpa/data/analytic.h"
#include "palpa/mode/modes.h"
#include "tests/solver/random_problems.h"

namespace palpa::test {

namespace {

constexpr double tick_s = 1e-3;
constexpr double voxel_m = 1e-3;
constexpr double k = 800.0;
constexpr int strokes_per_wall = 20;
// Strokes are shorter than 24 mm and stay within 12 mm of the middle: far enough from the edge of the data, where every
// strength fades to k/2 × the depth in them, for a wall to hold k × 24 mm.
constexpr double stroke_reach_m = 0.012;
constexpr int voxels = 131;

// A plate or a piece of a sphere's shell, its pose, and the direction through it.
struct Wall {
  Vec3 normal;  // from the near side to the far side; of a shell: at first contact
  Vec3 centre_m;
  double radius_m = 0;  // 0: a plate
  double thickness_m = 0;

  /// Below 0 on the near side of the middle, above on the far side.
  double beyond_m(const Vec3& x) const { return radius_m > 0 ? radius_m - norm(x - centre_m) : dot(normal, x - centre_m); }
  ScalarSample sample(const Vec3& x) const {
    const double beyond = beyond_m(x);
    const Vec3 up = radius_m > 0 ? -normalized(x - centre_m) : normal;
    return {0.5 * thickness_m - std::abs(beyond), beyond > 0 ? -up : up, true};
  }
};

Wall random_wall(Random& random, bool shell) {
  Wall wall;
  wall.normal = random.direction();
  wall.thickness_m = voxel_m * 0.3 * std::pow(8.0 / 0.3, random.uniform(0, 1));
  wall.centre_m = random.in_cube(0.5 * voxel_m);
  if (shell) {
    wall.radius_m = 0.05;
    wall.centre_m += 0.05 * wall.normal;
  }
  return wall;
}

FieldPtr field_of(const Wall& wall, WallKind kind) {
  switch (kind) {
    case WallKind::plate_formula:
    case WallKind::shell_formula:
      return formula([wall](const Vec3& x) { return wall.sample(x); }, voxels * voxel_m,
                     std::min(voxel_m, 0.5 * wall.thickness_m));
    case WallKind::trilinear:
    case WallKind::smooth:
    case WallKind::trilinear_binary:
    case WallKind::smooth_binary: break;
  }
  const bool binary = kind == WallKind::trilinear_binary || kind == WallKind::smooth_binary;
  const bool smooth = kind == WallKind::smooth || kind == WallKind::smooth_binary;
  return sampled_depth([wall](const Vec3& x) { return wall.sample(x).value; }, cube_of(voxels, voxel_m),
                       {.bits = 12, .ramp_voxels = binary ? 0.0 : 3.0}, smooth ? Filter::smooth : Filter::trilinear);
}

Scene wall_scene(const FieldPtr& field, double strength_n, double level = 0.0) {
  Scene scene = plain_scene({.stiffness_n_per_m = k});
  const FieldRef solid = scene.add("wall", volume_of(field), {}, filter_of(*field));
  scene.add("surface",
            SurfaceAndFriction{.field = solid, .levels = {{.name = "wall", .value = level, .strength_n = strength_n}}});
  return scene;
}

struct Stroke {
  Vec3 from_m, to_m;
  double speed_m_per_s;
};

Stroke random_stroke(Random& random, const Wall& wall) {
  const double clear_m = 0.5 * wall.thickness_m + 2.0 * voxel_m;
  Stroke stroke;
  do {
    stroke.from_m = stroke_reach_m * std::cbrt(random.uniform(0, 1)) * random.direction();
  } while (wall.beyond_m(stroke.from_m) > -clear_m);
  do {
    stroke.to_m = stroke_reach_m * std::cbrt(random.uniform(0, 1)) * random.direction();
  } while (wall.beyond_m(stroke.to_m) < clear_m);
  stroke.speed_m_per_s = 0.1 * std::pow(100.0, random.uniform(0, 1));
  return stroke;
}

// Runs the stroke, then holds until no motion is pending; visits the session after every tick. False: still pending.
template <class Visit>
bool feel(Session& session, const Stroke& stroke, Visit visit) {
  session.reset();
  const int ticks =
      std::max(1, static_cast<int>(std::ceil(distance(stroke.from_m, stroke.to_m) / (stroke.speed_m_per_s * tick_s))));
  Tick tick = session.tick({.position_m = stroke.from_m}, tick_s);
  for (int i = 1; i <= ticks; ++i) {
    const double share = static_cast<double>(i) / ticks;
    tick = session.tick({.position_m = stroke.from_m + share * (stroke.to_m - stroke.from_m)}, tick_s);
    visit(session);
  }
  for (int i = 0; i < 1000; ++i) {
    const bool waiting = tick.status == TickStatus::waiting;
    if (!waiting && i >= 10) return true;
    tick = session.tick({.position_m = stroke.to_m}, tick_s);
    visit(session);
  }
  return false;
}

// Points of a straight piece of the path, densely.
template <class Visit>
void along(const Vec3& from_m, const Vec3& to_m, double step_m, Visit visit) {
  const int pieces = std::max(1, static_cast<int>(std::ceil(distance(from_m, to_m) / step_m)));
  for (int i = 1; i <= pieces; ++i) visit(from_m + (static_cast<double>(i) / pieces) * (to_m - from_m));
}

// The contact events of a stroke, in order.
struct Contact {
  int onsets = 0;
  int break_throughs = 0;
  int without_onset = 0;
  void take(const Session& session) {
    for (const SessionEvent& event : session.events()) {
      if (event.kind == SessionEventKind::onset) ++onsets;
      if (event.kind != SessionEventKind::break_through) continue;
      ++break_throughs;
      without_onset += onsets < break_throughs;
    }
  }
};

// Depth of a half-voxel chord in the roughest surface between voxels.
constexpr double sag_voxels = 0.05;

// Crossings of the wall's middle from the near to the far side: in the solid, or in a hole.
struct MiddleCrossings {
  int solid = 0;
  int rims = 0;
  int holes = 0;
  double excess_m = 0.0;
  void take(const Wall& wall, const Field& field, const Session& session) {
    for (const SubStep& step : session.sub_steps()) {
      Vec3 before = step.start_m;
      along(step.start_m, step.proxy_m, 0.05 * std::min(voxel_m, wall.thickness_m), [&](const Vec3& x) {
        const ScalarSample sample = field.scalar(x);
        if (sample.inside) excess_m = std::max(excess_m, sample.value);
        const double a = wall.beyond_m(before), b = wall.beyond_m(x);
        if (a < 0.0 && b >= 0.0) {
          const Vec3 middle = before + (a / (a - b)) * (x - before);
          const double value_m = field.scalar(middle).value;
          (value_m > sag_voxels * voxel_m ? solid : value_m > 0.0 ? rims : holes) += 1;
        }
        before = x;
      });
    }
  }
};

// Pieces of a path in the solid: in and out by opposite faces is a pass; by one face, a straight step that cut a corner.
struct SolidPieces {
  int through = 0;
  void take(double depth_voxels, const Vec3& uphill) {
    if (depth_voxels > 0.0) {
      deepest_ = std::max(deepest_, depth_voxels);
      return;
    }
    through += deepest_ > 0.1 && dot(uphill, entered_) < 0.0;
    deepest_ = 0.0;
    entered_ = uphill;
  }

 private:
  double deepest_ = 0.0;
  Vec3 entered_;
};

}  // namespace

const char* name_of(WallKind kind) noexcept {
  switch (kind) {
    case WallKind::plate_formula: return "plate, formula";
    case WallKind::shell_formula: return "shell, formula";
    case WallKind::trilinear: return "trilinear";
    case WallKind::smooth: return "smooth";
    case WallKind::trilinear_binary: return "trilinear, binary";
    case WallKind::smooth_binary: return "smooth, binary";
  }
  return "?";
}

Held measure_held_walls(const WallCase& wanted) {
  Random random(wanted.seed);
  Held held;
  std::vector<double> excess;
  while (held.strokes < wanted.strokes) {
    const Wall wall = random_wall(random, wanted.kind == WallKind::shell_formula);
    const FieldPtr field = field_of(wall, wanted.kind);
    Session session(wall_scene(field, 1.1 * k * 2.0 * stroke_reach_m));
    for (int i = 0; i < strokes_per_wall && held.strokes < wanted.strokes; ++i, ++held.strokes) {
      const Stroke stroke = random_stroke(random, wall);
      MiddleCrossings crossings;
      Contact contact;
      held.unfinished += !feel(session, stroke, [&](const Session& felt) {
        crossings.take(wall, *field, felt);
        contact.take(felt);
      });
      excess.push_back(crossings.excess_m / voxel_m);
      held.passed += crossings.solid > 0;
      held.past_rims += crossings.rims > 0;
      held.through_holes += crossings.holes > 0;
      held.never_felt += crossings.solid > 0 && contact.onsets == 0;
      if (crossings.solid > 0 && held.first_passed < 0) held.first_passed = held.strokes;
    }
  }
  held.excess_p99_voxels = quantile(excess, 0.99);
  held.excess_max_voxels = quantile(excess, 1.0);
  return held;
}

WeakWallCounts measure_weak_walls(const WallCase& wanted) {
  Random random(wanted.seed);
  WeakWallCounts counts;
  while (counts.strokes < wanted.strokes) {
    const Wall wall = random_wall(random, wanted.kind == WallKind::shell_formula);
    const FieldPtr field = field_of(wall, wanted.kind);
    Session session(wall_scene(field, k * random.uniform(0.1e-3, 4e-3)));
    for (int i = 0; i < strokes_per_wall && counts.strokes < wanted.strokes; ++i, ++counts.strokes) {
      MiddleCrossings crossings;
      Contact contact;
      feel(session, random_stroke(random, wall), [&](const Session& felt) {
        crossings.take(wall, *field, felt);
        contact.take(felt);
      });
      counts.break_throughs += contact.break_throughs;
      counts.without_onset += contact.without_onset;
      counts.missing += crossings.solid > 0 && contact.break_throughs == 0;
    }
  }
  return counts;
}

BreakThrough measure_break_through(int strokes) {
  const FieldPtr ball = sphere_field(0.05).fields.front().field;
  Random random(5);
  BreakThrough found;
  for (found.strokes = 0; found.strokes < strokes; ++found.strokes) {
    const double strength_n = k * random.uniform(0.2e-3, 8e-3);
    Session session(wall_scene(ball, strength_n));
    const Vec3 from = 0.055 * random.direction();
    const double speed = 0.1 * std::pow(100.0, random.uniform(0, 1));
    Contact contact;
    feel(session, {from, 0.02 * random.direction(), speed}, [&](const Session& felt) {
      contact.take(felt);
      for (const SessionEvent& event : felt.events()) {
        if (event.kind != SessionEventKind::break_through) continue;
        found.depth_error_max_m = std::max(found.depth_error_max_m, std::abs(event.depth_m - strength_n / k));
      }
    });
    found.break_throughs += contact.break_throughs;
    found.without_onset += contact.without_onset;
  }
  return found;
}

Skull measure_skull(const FieldPtr& field, const SkullCase& wanted) {
  const Box box = field->bounds_m();
  const double spacing_m = field->spacing_m();
  const double reach_m = norm(box.size_m());
  constexpr double longest_m = 0.03;
  Scene scene = wall_scene(field, 2.0 * k * longest_m, wanted.level);
  scene.edit<Workspace>([&](auto& workspace) { workspace.center_m = box.centre_m(); });
  Session session(scene);
  const Similarity& map = session.hand_to_world();
  Random random(wanted.seed);
  Skull skull;
  std::vector<double> excess;
  while (skull.strokes < wanted.strokes) {
    // From far outside towards a point in the middle, up to the first solid; the stroke begins 5 mm before.
    const Vec3 aim = box.centre_m() + random.in_cube(0.2 * reach_m / std::sqrt(3.0));
    const Vec3 way = random.direction();
    Vec3 front = aim - reach_m * way;
    double walked_m = 0.0;
    for (; walked_m < reach_m; walked_m += 0.1 * spacing_m) {
      const ScalarSample sample = field->scalar(front);
      if (sample.inside && sample.value >= wanted.level) break;
      front += 0.1 * spacing_m * way;
    }
    const Vec3 start = front - 5e-3 * way;
    Vec3 tilted = random.direction();
    if (dot(tilted, way) < 0.3) tilted = way;
    // Strengths fade to k/2 × the depth in the data, so that bone holds only a stroke deep in them.
    const double depth_m = std::min(field->depth_m(start), field->depth_m(start + longest_m * tilted)) - longest_m;
    const double length_m = std::min(longest_m, 0.4 * depth_m);
    if (walked_m >= reach_m || !field->scalar(start).inside || length_m < 8e-3) continue;
    const Stroke stroke{map.to_hand(start), map.to_hand(start + length_m * tilted), std::pow(10.0, random.uniform(0, 1))};
    double deepest = 0.0;
    int onsets = 0;
    SolidPieces pieces;
    skull.unfinished += !feel(session, stroke, [&](const Session& felt) {
      for (const SubStep& step : felt.sub_steps()) {
        along(map.to_world(step.start_m), map.to_world(step.proxy_m), 0.05 * spacing_m, [&](const Vec3& x) {
          const ScalarSample sample = field->scalar(x);
          if (!sample.inside) return;
          const double depth = (sample.value - wanted.level) / std::max(norm(sample.gradient) * spacing_m, wanted.least_slope);
          deepest = std::max(deepest, depth);
          pieces.take(depth, sample.gradient);
        });
      }
      for (const SessionEvent& event : felt.events()) onsets += event.kind == SessionEventKind::onset;
    });
    excess.push_back(deepest);
    skull.deep += deepest > 0.1;
    if (pieces.through > 0) {
      ++skull.passed;
      skull.never_felt += onsets == 0;
      if (skull.first_passed < 0) skull.first_passed = skull.strokes;
    }
    ++skull.strokes;
  }
  skull.excess_p99_voxels = quantile(excess, 0.99);
  skull.excess_max_voxels = quantile(excess, 1.0);
  return skull;
}

}  // namespace palpa::test
