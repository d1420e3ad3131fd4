// Balances and ledger of 10⁵ ticks of random scenes, checked from balances.csv, primitives.csv, modes.csv and ticks.csv alone.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "palpa/data/sampled.h"
#include "palpa/palpa.h"
#include "palpa/trace/trace.h"
#include "tests/session/hands.h"
#include "tests/solver/all_faces.h"

namespace palpa {
namespace recorded_balances_test {

namespace fs = std::filesystem;

constexpr int scenes = 20;
constexpr int ticks_per_scene = 5000;
constexpr double dt = 1e-3;

// A field of directed force, so that the check meets all four kinds.
struct Push {
  static constexpr auto type = "test.push";
  FieldRef field;
  double strength_n = 0.3;
  static constexpr auto parameters() {
    return std::tuple{vector_param("field", &Push::field, "direction of the push"),
                      param("strength_n", &Push::strength_n, "force", Range{0, 10})};
  }
  void place(const ModeContext& here, PrimitiveSink out) const noexcept {
    const VectorSample sample = here.vector(field);
    if (sample.inside && norm(sample.value) > 0) out.directed(3, normalized(sample.value), here.newtons(strength_n));
  }
};

Scene random_scene(test::Random& random, int number) {
  Scene scene({.stiffness_n_per_m = random.uniform(200, 2000), .damping_ns_per_m = 0.0});
  const FieldRef head = scene.add("head", sampled(head_phantom(), 40));
  const FieldRef flow = scene.add("flow", sampled(burgers_vortex(), 24), {.scale = 2.5});
  SurfaceAndFriction surface{.field = head};
  if (number % 3 == 2) {
    surface.strength_n = {head, TransferFunction({{-600, 0.0}, {0, 0.5}, {1000, 4.0}})};
  } else {
    surface.levels = {{.name = "skin", .value = -300, .strength_n = random.uniform(0.3, 1.5)},
                      {.name = "bone", .value = 300, .strength_n = random.uniform(2.0, 6.0)}};
    if (number % 3 == 1) surface.levels[0].stiffness_n_per_m = random.uniform(50, 1000);
  }
  (number % 2 ? surface.friction_n : surface.friction_coefficient) = random.uniform(0.05, 0.4);
  scene.add("surface", surface);
  if (number % 4 != 0)
    scene.add("rail",
              Follow{.field = flow, .strength_n = random.uniform(0.1, 1.0), .drag_ns_per_m = number % 5 == 1 ? 1.5 : 0.0});
  if (number % 4 >= 2) scene.add("air", Viscosity{.strength_n = 0.05, .drag_ns_per_m = random.uniform(0.0, 2.0)});
  if (number % 5 == 4) scene.add("push", Push{.field = flow});
  return scene;
}

// A CSV file by the plainest parser: column name → text, row by row.
class Table {
 public:
  explicit Table(const fs::path& file) : in_(file) {
    std::string line;
    std::getline(in_, line);
    std::istringstream names(line);
    for (std::string name; std::getline(names, name, ',');) index_[name] = index_.size();
  }
  bool next() {
    std::string line;
    if (!std::getline(in_, line)) return false;
    cells_.clear();
    std::size_t begin = 0;
    for (;;) {
      const std::size_t end = line.find(',', begin);
      cells_.push_back(line.substr(begin, end - begin));
      if (end == std::string::npos) break;
      begin = end + 1;
    }
    return true;
  }
  const std::string& text(const std::string& name) const { return cells_.at(index_.at(name)); }
  double number(const std::string& name) const { return std::strtod(text(name).c_str(), nullptr); }
  Vec3 vector(const std::string& name, const std::string& unit) const {
    const std::string tail = unit.empty() ? "" : "_" + unit;
    return {number(name + "_x" + tail), number(name + "_y" + tail), number(name + "_z" + tail)};
  }

 private:
  std::ifstream in_;
  std::map<std::string, std::size_t> index_;
  std::vector<std::string> cells_;
};

struct Row {
  Primitive primitive;  // its id has the slot alone; stiffness 0: rigid
  std::string mode;
  Vec3 force_n;
};

struct Recomputed {
  double bound_m = 0.0;
  double rounding_m = 0.0;  // of this formula on numbers of 53 bits: |u| is s only to an ulp, and ε has a root over it
};

// Stored energy of a surface of strength s at depth d: Huber's function of d if elastic.
long double held_j(const Primitive& p, long double d) {
  const long double s = p.strength_n, stiffness = p.stiffness_n_per_m;
  if (!(stiffness > 0)) return s * d;
  return stiffness * d <= s ? stiffness / 2 * d * d : s * d - s * s / (2 * stiffness);
}
long double conjugate_j(const Primitive& p, const Vec3& u) {
  return p.stiffness_n_per_m > 0 ? norm_squared(u) / (2.0L * p.stiffness_n_per_m) : 0.0L;
}

// The check formula of a trace (docs/trace.md), in its plainest form.
Recomputed recomputed_bound(const std::vector<Row>& rows, const Vec3& x, const Vec3& probe, const Vec3& directed, double k,
                            double T) {
  Vec3 sum;
  long double eps = 0;
  double size = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Primitive& p = rows[i].primitive;
    if (p.kind == PrimitiveKind::directed) continue;
    if (p.kind == PrimitiveKind::corner) {
      test::Facets facets;
      Vec3 whole;
      long double uR = 0;
      double away = 0;
      const std::size_t first = i;
      for (; i < rows.size() && rows[i].primitive.kind == p.kind && rows[i].primitive.id == p.id &&
             rows[i].mode == rows[first].mode;
           ++i) {
        const Primitive& facet = rows[i].primitive;
        facets.push_back({facet.position_m, facet.direction});
        whole += rows[i].force_n;
        uR += dot(rows[i].force_n, facet.position_m - x);
        away = std::max(away, norm(facet.position_m - x));
        size += norm(rows[i].force_n) * norm(facet.position_m - x);
      }
      --i;
      size += p.strength_n * away;
      sum += whole;
      eps += held_j(p, norm(test::way_out_by_all_faces(facets, x))) + conjugate_j(p, whole) - uR;
      continue;
    }
    const Vec3& q = p.direction;
    Vec3 u = rows[i].force_n;
    if (p.kind == PrimitiveKind::line) u -= dot(q, u) * q;
    if (p.kind == PrimitiveKind::plane) u = std::max(0.0, dot(q, u)) * q;
    if (p.drag_ns_per_m == 0.0 && norm(u) > p.strength_n) u *= p.strength_n / norm(u);
    sum += u;
    const Vec3 d = p.position_m - x;
    Vec3 R = d;
    double reach = norm(d), uR = dot(u, d);
    if (p.kind == PrimitiveKind::line) R = d - dot(q, d) * q, reach = norm(R), uR = dot(u, R);
    if (p.kind == PrimitiveKind::plane) reach = std::max(0.0, dot(q, d)), uR = dot(u, q) * dot(q, d);
    const long double s = p.strength_n, C = p.drag_ns_per_m / T;
    const long double over = std::max(0.0L, static_cast<long double>(norm(u)) - s);
    size += std::max(p.strength_n, norm(u)) * norm(d);
    eps += held_j(p, reach) + conjugate_j(p, u) + C / 2 * reach * reach + (p.drag_ns_per_m > 0 ? over * over / (2 * C) : 0.0L) -
           uR;
  }
  const long double rho = norm(k * (x - probe) - directed - sum);
  return {static_cast<double>((rho + std::sqrt(rho * rho + 4 * k * std::max(0.0L, eps))) / (2 * k)),
          std::sqrt(16 * std::numeric_limits<double>::epsilon() * size / k)};
}

TEST(Trace, ProvesItsBalancesAndItsLedgerWithoutOurSolver) {
  test::Random random(2026);
  int balances = 0, capped = 0, capped_injections = 0, primitives_checked = 0, friction_rows = 0, drag_rows = 0,
      directed_rows = 0, elastic_rows = 0;
  double worst_bound = 0.0, worst_ledger_j = 0.0, worst_injection_j = 0.0, worst_path_j = 0.0;
  for (int number = 0; number < scenes; ++number) {
    const Scene scene = random_scene(random, number);
    const fs::path folder =
        fs::temp_directory_path() / ("palpa-laws-" + std::to_string(::getpid()) + "-" + std::to_string(number));
    fs::remove_all(folder);
    std::vector<std::string> mode_names;
    for (const SceneMode& mode : scene.modes()) mode_names.push_back(mode.name);
    {
      Session session(scene);
      TraceHeader header;
      header.hand_to_world = session.hand_to_world();
      header.primitives = true;
      TraceWriter writer(folder, header, to_toml(scene), mode_names);
      const test::Wander hand(random, 0.085);
      for (int i = 0; i < ticks_per_scene; ++i) {
        TickFrame frame;
        frame.tick = i;
        frame.t_s = i * dt;
        frame.dt_s = dt;
        frame.result = session.tick({.position_m = hand.at(i * dt)}, dt);
        frame.command.force_n = frame.result.force_n;
        writer.append(frame, session.modes(), session.sub_steps(), session.primitives(), session.events());
      }
      writer.finish();
    }

    Table ticks(folder / "ticks.csv"), modes(folder / "modes.csv"), steps(folder / "balances.csv"),
        placed(folder / "primitives.csv");
    bool more_steps = steps.next(), more_placed = placed.next(), more_modes = modes.next();
    const double k = scene.coupling().stiffness_n_per_m;
    Vec3 proxy_before, probe_before;
    double elastic_before_j = 0.0;
    bool first = true;
    while (ticks.next()) {
      const std::string tick = ticks.text("tick");
      const Vec3 proxy = ticks.vector("proxy", "m"), probe = ticks.vector("probe", "m");
      std::map<std::string, double> works;
      double spring_work = 0.0, path_limit = 0.0, forces = 0.0;
      Vec3 x0, x = proxy_before, walked;
      int rows_in_tick = 0;
      while (more_steps && steps.text("tick") == tick) {
        const Vec3 start = steps.vector("start", "m"), b = steps.vector("balance", "m"), p = steps.vector("probe", "m"),
                   end = steps.vector("proxy", "m");
        const Vec3 directed = steps.vector("directed", "n");
        const double T = steps.number("dt_s"), fraction = steps.number("move_fraction");
        if (rows_in_tick == 0) x0 = start, walked = p;
        if (!first || rows_in_tick > 0) {
          ASSERT_EQ(start, x) << "tick " << tick << ": a sub-step starts where the last one ended";
        }
        ASSERT_NEAR(distance(end, start + fraction * (b - start)), 0.0, 1e-16);
        ASSERT_GT(T, 0.0);
        const double after_walk = distance(p, walked);
        path_limit += k * distance(start, x0) * after_walk;
        walked = p;
        std::vector<Row> rows;
        while (more_placed && placed.text("tick") == tick && placed.text("sub_step") == steps.text("sub_step")) {
          Row row;
          row.mode = placed.text("mode");
          const std::string kind = placed.text("kind");
          row.primitive.kind = kind == "point"   ? PrimitiveKind::point
                               : kind == "line"  ? PrimitiveKind::line
                               : kind == "plane" ? PrimitiveKind::plane
                               : kind == "facet" ? PrimitiveKind::corner
                                                 : PrimitiveKind::directed;
          row.primitive.id.slot = static_cast<std::uint16_t>(placed.number("slot"));
          row.primitive.position_m = placed.vector("position", "m");
          row.primitive.direction = placed.vector("direction", "");
          row.primitive.strength_n = placed.number("strength_n");
          row.primitive.drag_ns_per_m = placed.number("drag_ns_per_m");
          row.primitive.stiffness_n_per_m = placed.number("stiffness_n_per_m");
          row.force_n = placed.vector("force", "n");
          rows.push_back(row);
          more_placed = placed.next();
        }
        ASSERT_EQ(static_cast<double>(rows.size()), steps.number("primitives"));
        const double returned = steps.number("error_bound_m");
        const Recomputed recomputed = recomputed_bound(rows, b, p, directed, k, T);
        ASSERT_LE(recomputed.bound_m, returned + recomputed.rounding_m) << "tick " << tick;
        const bool exact = steps.text("status") == "exact";
        capped += !exact;
        if (exact) {
          ASSERT_LE(returned, 1e-9);
        }
        worst_bound = std::max(worst_bound, returned);
        ++balances;
        Vec3 push;
        for (const Row& row : rows) {
          const Vec3 step = end - start;
          works[row.mode] += dot(row.force_n, step);
          forces += norm(row.force_n) * norm(step);
          directed_rows += row.primitive.kind == PrimitiveKind::directed;
          drag_rows += row.primitive.drag_ns_per_m > 0;
          friction_rows += row.primitive.kind == PrimitiveKind::line;
          elastic_rows += row.primitive.stiffness_n_per_m > 0;
          if (row.primitive.kind == PrimitiveKind::directed) {
            push += row.force_n;
            continue;
          }
          // No primitive injects more than its strength over the distance from the start to it.
          const double injects = dot(row.force_n, step) - norm(row.force_n) * distance(row.primitive.position_m, start);
          if (exact) {
            ASSERT_LE(injects, 1e-15) << "tick " << tick << " mode " << row.mode;
          } else {  // an inexact balance may hide its bound
            ASSERT_LE(injects, 1e-15 + k * returned * returned) << "tick " << tick << " mode " << row.mode;
            capped_injections += injects > 1e-15;
          }
          worst_injection_j = std::max(worst_injection_j, injects);
          ++primitives_checked;
        }
        ASSERT_NEAR(distance(push, directed), 0.0, 1e-15);
        spring_work += k * dot(b - p, end - start);
        x = end;
        ++rows_in_tick;
        more_steps = steps.next();
      }
      ASSERT_GT(rows_in_tick, 0);
      ASSERT_EQ(proxy, x);
      path_limit += k * distance(x, x0) * distance(probe, walked);

      // The ledger: per mode, and the path's share of the identity of the tick.
      const double elastic_j = ticks.number("elastic_j") - elastic_before_j;
      elastic_before_j = ticks.number("elastic_j");
      double injected = 0.0, dissipated = 0.0;
      while (more_modes && modes.text("tick") == tick) {
        const double work = modes.number("injected_j") - modes.number("dissipated_j");
        double books = works[modes.text("mode")];
        if (modes.text("mode") == "surface") books += elastic_j;  // the one mode with levels
        worst_ledger_j = std::max(worst_ledger_j, std::abs(work - books));
        injected += modes.number("injected_j");
        dissipated += modes.number("dissipated_j");
        more_modes = modes.next();
      }
      ASSERT_NEAR(injected, ticks.number("injected_j"), 1e-15);
      ASSERT_NEAR(dissipated, ticks.number("dissipated_j"), 1e-15);
      const double path = k * dot(x - x0, 0.5 * (x + x0) - probe) - spring_work;
      const double rounding = 1e-15 + 1e-9 * forces;  // forces and k (b − p) agree to the bound only
      ASSERT_NEAR(ticks.number("path_j"), path, rounding) << "tick " << tick;
      ASSERT_LE(ticks.number("path_j"), path_limit + rounding) << "tick " << tick;
      worst_path_j = std::max(worst_path_j, std::abs(ticks.number("path_j") - path));
      if (!first) {
        // f₀·Δp = S₀ − S_m + k/2 |Δp|² + I with I = ΣW + path (nothing moves here).
        const double I = injected - dissipated - elastic_j + ticks.number("path_j");
        const double left = k * dot(proxy_before - probe_before, probe - probe_before);
        const double right = 0.5 * k * norm_squared(proxy_before - probe_before) - ticks.number("stored_j") +
                             0.5 * k * norm_squared(probe - probe_before) + I;
        ASSERT_NEAR(left, right, 1e-13);
      }
      proxy_before = proxy;
      probe_before = probe;
      first = false;
    }
    EXPECT_FALSE(more_steps || more_placed || more_modes) << "every row belongs to a tick";
    fs::remove_all(folder);
  }
  std::cout << balances << " balances, " << capped << " capped, " << primitives_checked << " primitives; worst bound "
            << worst_bound << " m, worst difference of a mode's work " << worst_ledger_j << " J, of path_j " << worst_path_j
            << " J, worst injection beyond its bound " << worst_injection_j << " J (" << capped_injections
            << " above 1e-15 J, all in capped balances)\n";
  EXPECT_LT(worst_ledger_j, 1e-15);
  EXPECT_LT(capped, balances / 1000);
  EXPECT_GT(friction_rows, 10000);
  EXPECT_GT(drag_rows, 10000);
  EXPECT_GT(directed_rows, 1000);
  EXPECT_GT(elastic_rows, 1000);
}

}  // namespace recorded_balances_test
}  // namespace palpa
