#include "tests/laws/trace_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "palpa/core/load_error.h"
#include "tests/core/all_faces.h"

namespace palpa::test {

namespace {

using Quad = __float128;

constexpr double ulp = std::numeric_limits<double>::epsilon();

struct Quad3 {
  Quad x = 0, y = 0, z = 0;
};
Quad3 wide(const Vec3& a) { return {a.x, a.y, a.z}; }
Quad3 operator+(const Quad3& a, const Quad3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Quad3 operator-(const Quad3& a, const Quad3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Quad3 operator*(Quad f, const Quad3& a) { return {f * a.x, f * a.y, f * a.z}; }
Quad dot(const Quad3& a, const Quad3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Two steps of Newton's method from the root of 64 bits.
Quad root(Quad a) {
  if (!(a > 0)) return 0;
  Quad y = std::sqrt(static_cast<long double>(a));
  if (!(y > 0)) return 0;
  for (int i = 0; i < 2; ++i) y = (y + a / y) / 2;
  return y;
}
Quad length(const Quad3& a) { return root(dot(a, a)); }
Quad largest(Quad a, Quad b) { return a > b ? a : b; }

// What a primitive holds of strength `s` that is `d` away: Huber's function of d if it has a stiffness, of none s d.
Quad held_j(double s, double stiffness_n_per_m, Quad d) {
  const Quad stiffness = stiffness_n_per_m;
  if (!(stiffness > 0)) return s * d;
  return stiffness * d <= s ? stiffness / 2 * d * d : s * d - Quad(s) * s / (2 * stiffness);
}

// ρ and ε of the formula, summed up primitive by primitive, and how far rounding may have raised each.
class Formula {
 public:
  Formula(const Vec3& x_m, const Vec3& probe_m, const Vec3& directed_n, double k, double T)
      : x_(wide(x_m)), left_(Quad(k) * (wide(x_m) - wide(probe_m)) - wide(directed_n)), k_(k), T_(T) {
    position_ulp_m_ = ulp * largest_component(x_m);
    rho_rounding_ = k * position_ulp_m_;
  }

  void add(std::string_view kind, const Vec3& position_m, const Vec3& direction, double s, double c, double stiffness_n_per_m,
           const Vec3& force_n) {
    Quad3 q = wide(direction);
    if (kind != "point") q = (1 / length(q)) * q;
    const Quad3 d = wide(position_m) - x_;
    Quad3 u = wide(force_n);
    Quad3 R = d;
    if (kind == "line") {
      u = u - dot(q, u) * q;
      R = d - dot(q, d) * q;
    }
    if (kind == "plane") {
      u = largest(0, dot(q, u)) * q;
      R = dot(q, d) * q;
    }
    if (c == 0.0 && length(u) > s) u = (s / length(u)) * u;
    const Quad reach = kind == "plane" ? largest(0, dot(q, d)) : length(R);
    const Quad force = length(u);
    left_ = left_ - u;
    epsilon_ = epsilon_ + held_j(s, stiffness_n_per_m, reach) + Quad(c) / (2 * Quad(T_)) * reach * reach - dot(u, R);
    if (stiffness_n_per_m > 0.0) epsilon_ = epsilon_ + force * force / (2 * Quad(stiffness_n_per_m));
    if (c > 0.0) {
      const Quad over = largest(0, force - s);
      epsilon_ = epsilon_ + Quad(T_) / (2 * Quad(c)) * over * over;
    }
    const double size_n = s + static_cast<double>(force);
    rho_rounding_ += 4.0 * ulp * size_n;
    epsilon_rounding_ += size_n * (position_ulp_m_ + 8.0 * ulp * static_cast<double>(length(R)));
  }

  // The facets of a corner of strength `s`, elastic if it has a stiffness; `forces_n` point along their normals.
  void add_corner(const Facets& facets, double s, double stiffness_n_per_m, const std::vector<Vec3>& forces_n) {
    Quad3 u;
    Quad held = 0, largest_m = 0, sizes = 0;
    for (std::size_t i = 0; i < facets.size(); ++i) {
      const Quad3 n = (1 / length(wide(facets[i].normal))) * wide(facets[i].normal);
      const Quad3 d = wide(facets[i].position_m) - x_;
      const Quad t = largest(0, dot(n, wide(forces_n[i])));
      u = u + t * n;
      held = held + t * dot(n, d);
      largest_m = largest(largest_m, length(d));
      sizes = sizes + t;
    }
    const Quad share = length(u) > s ? s / length(u) : Quad(1);
    const Vec3 x{static_cast<double>(x_.x), static_cast<double>(x_.y), static_cast<double>(x_.z)};
    left_ = left_ - share * u;
    epsilon_ = epsilon_ + held_j(s, stiffness_n_per_m, Quad(norm(way_out_by_all_faces(facets, x)))) - share * held;
    if (stiffness_n_per_m > 0.0) epsilon_ = epsilon_ + share * share * dot(u, u) / (2 * Quad(stiffness_n_per_m));
    const double size_n = s + static_cast<double>(sizes);
    rho_rounding_ += 4.0 * ulp * size_n;
    epsilon_rounding_ += size_n * (position_ulp_m_ + 8.0 * ulp * static_cast<double>(largest_m));
  }

  double bound_m() const {
    const Quad rho = length(left_);
    return static_cast<double>((rho + root(rho * rho + 4 * k_ * largest(0, epsilon_))) / (2 * k_));
  }
  double rounding_m() const {
    const auto k = static_cast<double>(k_);
    return rho_rounding_ / k + std::sqrt(epsilon_rounding_ / k);
  }

 private:
  Quad3 x_, left_;
  Quad k_, T_, epsilon_ = 0;
  double position_ulp_m_ = 0.0, rho_rounding_ = 0.0, epsilon_rounding_ = 0.0;
};

// Traces from before levels had one are of rigid ones.
double stiffness_of(const CsvRows& primitives) {
  const std::string column = "stiffness_n_per_m";
  return primitives.has(column) && !primitives.text(column).empty() ? primitives.number(column) : 0.0;
}

// The rows of one corner, as they are met.
struct Corner {
  std::string owner;
  Facets facets;
  std::vector<Vec3> forces_n;
  double strength_n = 0.0, stiffness_n_per_m = 0.0;

  void put_into(Formula& formula) {
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

void check_balances(const std::filesystem::path& trace, const std::function<void(const CheckedBalance&)>& visit) {
  CsvRows balances(trace / "balances.csv"), primitives(trace / "primitives.csv");
  bool more = primitives.next();
  while (balances.next()) {
    CheckedBalance checked;
    checked.tick = balances.integer("tick");
    checked.sub_step = balances.integer("sub_step");
    checked.status = balances.text("status");
    checked.claimed_m = balances.number("error_bound_m");
    Formula formula(balances.vector("balance", "m"), balances.vector("probe", "m"), balances.vector("directed", "n"),
                    balances.number("k_n_per_m"), balances.number("dt_s"));
    const std::int64_t expected = balances.integer("primitives");
    Corner corner;
    for (std::int64_t i = 0; i < expected; ++i, more = primitives.next()) {
      if (!more || primitives.integer("tick") != checked.tick || primitives.integer("sub_step") != checked.sub_step) {
        throw LoadError(primitives.place() + (more ? ": does not belong to" : ": is the last row, before those of") +
                        " the sub-step of " + balances.place());
      }
      const std::string_view kind = primitives.text("kind");
      if (kind == "directed") continue;
      if (kind == "facet") {
        const std::string owner = std::string(primitives.text("mode")) + ',' + std::string(primitives.text("slot"));
        if (owner != corner.owner) corner.put_into(formula), corner.owner = owner;
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

void check_works(const std::filesystem::path& trace, const std::function<void(const CheckedWork&)>& visit) {
  CsvRows balances(trace / "balances.csv"), primitives(trace / "primitives.csv");
  std::optional<CsvRows> works;
  if (std::filesystem::exists(trace / "works.csv")) works.emplace(trace / "works.csv");
  bool more = works && works->next();
  while (balances.next()) {
    const Vec3 start = balances.vector("start", "m"), step = balances.vector("proxy", "m") - start;
    const double fraction = balances.number("move_fraction");
    for (std::int64_t i = balances.integer("primitives"); i > 0; --i) {
      if (!primitives.next()) throw LoadError(balances.place() + ": its primitives are missing");
      const auto is_of_this = [&](const char* column) { return works->text(column) == primitives.text(column); };
      const bool moved = more && is_of_this("tick") && is_of_this("sub_step") && is_of_this("mode") && is_of_this("slot");
      const Vec3 force_n = primitives.vector("force", "n"), carried_m = moved ? works->vector("carried", "m") : Vec3{};
      CheckedWork checked;
      checked.tick = primitives.integer("tick");
      checked.sub_step = primitives.integer("sub_step");
      checked.mode = primitives.text("mode");
      checked.directed = primitives.text("kind") == "directed";
      checked.exact = balances.text("status") == "exact";
      checked.work_j = dot(force_n, step - fraction * carried_m);
      checked.claimed_j = moved ? works->number("work_j") : checked.work_j;
      checked.moved_j = dot(force_n, fraction * carried_m);
      checked.carried_m = norm(carried_m);
      checked.may_bring_j = norm(force_n) * distance(primitives.vector("position", "m"), start + carried_m);
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
    held = {};                            // what earlier sub-steps had is gone
    std::map<std::string, Level> levels;  // by mode and slot
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
