#include "tests/laws/trace_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "palpa/base/load_error.h"
#include "tests/laws/balance_formula.h"

namespace palpa::test {

namespace {

// Older traces without stiffness have rigid levels.
double stiffness_of(const CsvRows& primitives) {
  const std::string column = "stiffness_n_per_m";
  return primitives.has(column) && !primitives.text(column).empty() ? primitives.number(column) : 0.0;
}

// Mode, slot and foot, which the facets of a corner have in common.
std::string owner_of(const CsvRows& primitives) {
  return std::string(primitives.text("mode")) + ',' + std::string(primitives.text("slot")) +
         (primitives.has("foot") ? ',' + std::string(primitives.text("foot")) : "");
}

struct Corner {
  std::string owner;
  Facets facets;
  std::vector<Vec3> forces_n;
  double strength_n = 0.0, stiffness_n_per_m = 0.0;

  void put_into(BalanceFormula& formula) {
    if (!facets.empty()) formula.add_corner(facets, strength_n, stiffness_n_per_m, forces_n);
    facets.clear(), forces_n.clear();
  }
};

}  // namespace

CsvRows::CsvRows(const std::filesystem::path& file) : lines_(file) {
  if (!lines_.exists())
    throw LoadError(file.string() +
                    ": does not exist; name the folder of a trace, for its balances one recorded with --primitives");
  std::string_view header;
  if (!lines_.next(header)) throw LoadError(file.string() + ": is empty; a trace's files begin with a header");
  std::vector<std::string_view> names;
  detail::split(header, names);
  for (const std::string_view name : names) columns_.emplace(name, columns_.size());
}

bool CsvRows::next() {
  std::string_view line;
  if (!lines_.next(line)) return false;
  detail::split(line, cells_);
  if (cells_.size() < columns_.size()) {
    throw LoadError(place() + ": " + std::to_string(cells_.size()) + " cells under " + std::to_string(columns_.size()) +
                    " columns; each row has one of each");
  }
  return true;
}

std::string_view CsvRows::text(const std::string& column) const {
  const auto found = columns_.find(column);
  if (found == columns_.end()) throw LoadError(place() + ": no column '" + column + "'; this is no trace of ours");
  return cells_[found->second];
}

double CsvRows::number(const std::string& column) const {
  double value = 0.0;
  if (!detail::take_number(text(column), value)) {
    throw LoadError(place() + ": column " + column + ": '" + std::string(text(column)) + "' is no number");
  }
  return value;
}

std::int64_t CsvRows::integer(const std::string& column) const {
  std::int64_t value = 0;
  if (!detail::take_number(text(column), value)) {
    throw LoadError(place() + ": column " + column + ": '" + std::string(text(column)) + "' is no whole number");
  }
  return value;
}

Vec3 CsvRows::vector(const std::string& name, const std::string& unit) const {
  const std::string tail = unit.empty() ? "" : "_" + unit;
  return {number(name + "_x" + tail), number(name + "_y" + tail), number(name + "_z" + tail)};
}

Turn CsvRows::turn(const std::string& name) const {
  return {number(name + "_w"), number(name + "_x"), number(name + "_y"), number(name + "_z")};
}

void check_balances(const std::filesystem::path& trace, const std::function<void(const CheckedBalance&)>& visit) {
  CsvRows balances(trace / "balances.csv"), primitives(trace / "primitives.csv");
  bool more = primitives.next();
  while (balances.next()) {
    CheckedBalance checked;
    checked.tick = balances.integer("tick");
    checked.sub_step = balances.integer("sub_step");
    checked.status = balances.text("status");
    checked.claimed_m = balances.number("error_bound_m");
    BalanceFormula formula(balances.vector("balance", "m"), balances.vector("probe", "m"), balances.vector("directed", "n"),
                           balances.number("k_n_per_m"), balances.number("dt_s"));
    const bool is_of_tool = balances.has("turning_radius_m") && balances.number("turning_radius_m") > 0.0;
    if (is_of_tool) {
      formula.turns(balances.vector("turn", "rad"), balances.turn("start_turn"), balances.turn("probe_turn"),
                    balances.number("turning_radius_m"));
    }
    const std::int64_t expected = balances.integer("primitives");
    Corner corner;
    for (std::int64_t i = 0; i < expected; ++i, more = primitives.next()) {
      if (!more || primitives.integer("tick") != checked.tick || primitives.integer("sub_step") != checked.sub_step) {
        throw LoadError(primitives.place() + (more ? ": does not belong to" : ": is the last row, before those of") +
                        " the sub-step of " + balances.place());
      }
      const std::string_view kind = primitives.text("kind");
      const std::string owner = kind == "facet" ? owner_of(primitives) : std::string();
      if (owner != corner.owner) corner.put_into(formula), corner.owner = owner;
      if (is_of_tool) formula.at_foot(primitives.vector("lever", "m"));
      if (kind == "directed") {
        formula.add_directed(primitives.vector("force", "n"));
        continue;
      }
      if (kind == "facet") {
        corner.strength_n = primitives.number("strength_n");
        corner.stiffness_n_per_m = stiffness_of(primitives);
        corner.facets.push_back({primitives.vector("position", "m"), primitives.vector("direction", "")});
        corner.forces_n.push_back(primitives.vector("force", "n"));
        continue;
      }
      if (kind != "point" && kind != "line" && kind != "plane") {
        throw LoadError(primitives.place() + ": unknown kind '" + std::string(kind) +
                        "'; point, line, plane, facet or directed");
      }
      formula.add(kind, primitives.vector("position", "m"), primitives.vector("direction", ""), primitives.number("strength_n"),
                  primitives.number("drag_ns_per_m"), stiffness_of(primitives), primitives.vector("force", "n"));
    }
    corner.put_into(formula);
    checked.bound_m = formula.bound_m();
    checked.rounding_m = formula.rounding_m();
    visit(checked);
  }
  if (more) throw LoadError(primitives.place() + ": belongs to no row of balances.csv");
}

namespace {

// The set of forces of a primitive or a corner at a point: the nearest to a given force.
struct Exertable {
  std::string kind, owner;
  std::vector<Vec3> at_m, directions;
  double strength_n = 0.0, drag_n_per_m = 0.0, stiffness_n_per_m = 0.0;
  Vec3 force_n;

  Vec3 within_strength(const Vec3& wanted_n) const {
    const double length_n = norm(wanted_n);
    return length_n > strength_n ? strength_n / length_n * wanted_n : wanted_n;
  }
  // Of a plane or facet at depth `depth_m` of the proxy.
  double pressed_n(double depth_m) const {
    return stiffness_n_per_m > 0.0 ? std::min(strength_n, stiffness_n_per_m * depth_m) : strength_n + drag_n_per_m * depth_m;
  }
  Vec3 nearest_n(const Vec3& wanted_n, const Vec3& x_m, double tolerance_m) const {
    if (kind == "point" || kind == "line") {
      const auto across = [&](const Vec3& v) { return kind == "line" ? v - dot(directions[0], v) * directions[0] : v; };
      const Vec3 way_m = across(at_m[0] - x_m);
      const double length_m = norm(way_m);
      if (length_m <= tolerance_m) return within_strength(across(wanted_n));
      return (strength_n + drag_n_per_m * length_m) / length_m * way_m;
    }
    // A plane, or the facets of a corner: touched facets press as demanded, in sequence.
    Vec3 sum_n, left_n = wanted_n;
    for (int sweep = 0; sweep < 50; ++sweep) {
      sum_n = {};
      left_n = wanted_n;
      for (std::size_t i = 0; i < at_m.size(); ++i) {
        const double depth_m = dot(directions[i], at_m[i] - x_m);
        if (depth_m < -tolerance_m) continue;
        const bool is_fixed = at_m.size() == 1 && (depth_m > tolerance_m || stiffness_n_per_m > 0.0);
        const double press_n = is_fixed ? pressed_n(std::max(0.0, depth_m)) : std::max(0.0, dot(directions[i], left_n));
        sum_n += press_n * directions[i];
        left_n -= press_n * directions[i];
      }
    }
    return within_strength(sum_n);
  }
};

}  // namespace

void check_rests(const std::filesystem::path& trace, double tolerance_m, const std::function<void(const CheckedRest&)>& visit) {
  CsvRows ticks(trace / "ticks.csv"), balances(trace / "balances.csv"), primitives(trace / "primitives.csv");
  std::map<std::int64_t, bool> rests;
  while (ticks.next()) rests[ticks.integer("tick")] = ticks.text("status") == "resting";
  CheckedRest rest{.tick = -1};
  while (balances.next()) {
    if (balances.integer("tick") != rest.tick && rest.tick >= 0 && rests[rest.tick]) visit(rest);
    const Vec3 x_m = balances.vector("proxy", "m"), directed_n = balances.vector("directed", "n");
    const double k = balances.number("k_n_per_m"), dt_s = balances.number("dt_s");
    std::vector<Exertable> all;
    for (std::int64_t i = balances.integer("primitives"); i > 0; --i) {
      if (!primitives.next()) throw LoadError(balances.place() + ": its primitives are missing");
      const std::string kind(primitives.text("kind"));
      if (kind == "directed") continue;
      const std::string owner = std::string(primitives.text("mode")) + ',' + std::string(primitives.text("slot"));
      if (kind != "facet" || all.empty() || all.back().owner != owner) {
        all.push_back({kind,
                       owner,
                       {},
                       {},
                       primitives.number("strength_n"),
                       primitives.number("drag_ns_per_m") / dt_s,
                       stiffness_of(primitives),
                       {}});
      }
      all.back().at_m.push_back(primitives.vector("position", "m"));
      all.back().directions.push_back(kind == "point" ? Vec3{} : primitives.vector("direction", ""));
    }
    const Vec3 demand_n = k * (x_m - balances.vector("probe", "m")) - directed_n;
    // Each takes the others' remainder: exact for independent spans, convergent otherwise.
    Vec3 left_n = demand_n;
    for (int sweep = 0; sweep < 300 && norm(left_n) > 1e-6; ++sweep) {
      for (Exertable& one : all) {
        const Vec3 now_n = one.nearest_n(left_n + one.force_n, x_m, tolerance_m);
        left_n += one.force_n - now_n;
        one.force_n = now_n;
      }
    }
    rest = {balances.integer("tick"), directed_n != Vec3{}, norm(k * (x_m - balances.vector("probe", "m"))), norm(left_n)};
  }
  if (rest.tick >= 0 && rests[rest.tick]) visit(rest);
}

void check_works(const std::filesystem::path& trace, const std::function<void(const CheckedWork&)>& visit) {
  CsvRows balances(trace / "balances.csv"), primitives(trace / "primitives.csv");
  std::optional<CsvRows> works;
  if (std::filesystem::exists(trace / "works.csv")) works.emplace(trace / "works.csv");
  bool more = works && works->next();
  while (balances.next()) {
    const Vec3 start = balances.vector("start", "m"), step = balances.vector("proxy", "m") - start;
    const double fraction = balances.number("move_fraction");
    const bool is_of_tool = balances.has("turning_radius_m") && balances.number("turning_radius_m") > 0.0;
    const Vec3 turn_rad = is_of_tool ? rotation_between_rad(balances.turn("start_turn"), balances.turn("proxy_turn")) : Vec3{};
    for (std::int64_t i = balances.integer("primitives"); i > 0; --i) {
      if (!primitives.next()) throw LoadError(balances.place() + ": its primitives are missing");
      const auto is_of_this = [&](const char* column) { return works->text(column) == primitives.text(column); };
      const bool moved = more && is_of_this("tick") && is_of_this("sub_step") && is_of_this("mode") && is_of_this("slot");
      const Vec3 lever_m = is_of_tool ? primitives.vector("lever", "m") : Vec3{};
      const Vec3 turned_m = is_of_tool ? cross(turn_rad, lever_m) : Vec3{};
      const Vec3 force_n = primitives.vector("force", "n"), carried_m = moved ? works->vector("carried", "m") : Vec3{};
      CheckedWork checked;
      checked.tick = primitives.integer("tick");
      checked.sub_step = primitives.integer("sub_step");
      checked.mode = primitives.text("mode");
      checked.directed = primitives.text("kind") == "directed";
      checked.exact = balances.text("status") == "exact";
      checked.work_j = dot(force_n, step + turned_m - fraction * carried_m);
      checked.claimed_j = moved ? works->number("work_j") : checked.work_j;
      checked.data_motion_j = dot(force_n, fraction * carried_m);
      checked.carried_m = norm(carried_m);
      checked.may_bring_j = norm(force_n) * distance(primitives.vector("position", "m"), start + lever_m + carried_m);
      visit(checked);
      if (moved) more = works->next();
    }
  }
  if (primitives.next()) throw LoadError(primitives.place() + ": belongs to no row of balances.csv");
  if (more) throw LoadError(works->place() + ": belongs to no row of primitives.csv");
}

std::map<std::int64_t, ElasticEnergy> elastic_energies(const std::filesystem::path& trace) {
  struct Level {
    double stiffness_n_per_m = 0.0, strength_n = 0.0;
    bool slips = false;
    Facets planes;
  };
  std::map<std::int64_t, ElasticEnergy> all;
  CsvRows balances(trace / "balances.csv"), primitives(trace / "primitives.csv");
  while (balances.next()) {
    ElasticEnergy& held = all[balances.integer("tick")];
    held = {};  // earlier sub-steps' energy is gone
    std::map<std::string, Level> levels;
    for (std::int64_t i = balances.integer("primitives"); i > 0; --i) {
      if (!primitives.next()) throw LoadError(balances.place() + ": its primitives are missing");
      if (!(stiffness_of(primitives) > 0.0)) continue;
      held.mode = primitives.text("mode");
      Level& level = levels[held.mode + ',' + std::string(primitives.text("slot"))];
      level.stiffness_n_per_m = stiffness_of(primitives);
      level.strength_n = primitives.number("strength_n");
      level.slips = primitives.text("state") == "slip";
      level.planes.push_back({primitives.vector("position", "m"), primitives.vector("direction", "")});
    }
    for (const auto& [owner, level] : levels) {
      const double way_m = norm(way_out_by_all_faces(level.planes, balances.vector("proxy", "m")));
      const double longest_m = std::min(way_m, level.strength_n / level.stiffness_n_per_m);
      const double level_j = 0.5 * level.stiffness_n_per_m * longest_m * longest_m;
      held.most_j += level_j;
      if (!level.slips) held.least_j += level_j;
    }
  }
  return all;
}

}  // namespace palpa::test
