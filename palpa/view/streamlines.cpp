#include "palpa/view/streamlines.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_set>

namespace palpa::detail {
namespace {

/// Direction of the field; none without data, or if slower than `least`.
std::optional<Vec3> direction_at(const Field& field, const Vec3& x_m, double least, double* speed = nullptr) {
  const VectorSample sample = field.vector(x_m);
  const double length = norm(sample.value);
  if (speed) *speed = length;
  if (!sample.inside || !(length > least)) return {};
  return sample.value / length;
}

/// Line from `start_m`, excluding it, along the field or, for `step_m` < 0, against it. Ends when it returns to `start_m`, with
/// `closed` set.
Streamline half_line(const Field& field, const Box& box, const Vec3& start_m, double step_m, double longest_m, double least,
                     bool& closed) {
  Streamline line;
  Vec3 x = start_m;
  const auto within = [&](const Vec3& p) {
    return p.x >= box.low_m.x && p.y >= box.low_m.y && p.z >= box.low_m.z && p.x <= box.high_m.x && p.y <= box.high_m.y &&
           p.z <= box.high_m.z;
  };
  const auto steps = static_cast<int>(std::min(longest_m / std::abs(step_m), 4000.0));
  for (int i = 0; i < steps; ++i) {
    const auto a = direction_at(field, x, least);
    if (!a) break;
    const auto b = direction_at(field, x + (0.5 * step_m) * *a, least);
    if (!b) break;
    const auto c = direction_at(field, x + (0.5 * step_m) * *b, least);
    if (!c) break;
    const auto d = direction_at(field, x + step_m * *c, least);
    if (!d) break;
    x += (step_m / 6.0) * (*a + 2.0 * *b + 2.0 * *c + *d);
    double speed = 0.0;
    if (!within(x) || !direction_at(field, x, least, &speed)) break;
    line.push_back({x, speed});
    if (i > 8 && distance(x, start_m) < 0.6 * std::abs(step_m)) {
      closed = true;
      break;
    }
  }
  return line;
}

/// Set of lattice cells crossed by streamlines.
class SeedLattice {
 public:
  explicit SeedLattice(double cell_m) : cell_m_(cell_m) {}
  bool near(const Vec3& p) const { return taken_.contains(key(p)); }
  void take(const Vec3& p) { taken_.insert(key(p)); }

 private:
  std::uint64_t key(const Vec3& p) const {
    const auto cell = [&](double x) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x / cell_m_)) + (1 << 20)) & 0x1fffffU;
    };
    return cell(p.x) << 42 | cell(p.y) << 21 | cell(p.z);
  }
  double cell_m_;
  std::unordered_set<std::uint64_t> taken_;
};

}  // namespace

Box shared_part(const Box& a, const Box& b) noexcept {
  const auto high_of = [](double x, double y, double low) { return std::max(std::min(x, y), low); };
  const Vec3 low{std::max(a.low_m.x, b.low_m.x), std::max(a.low_m.y, b.low_m.y), std::max(a.low_m.z, b.low_m.z)};
  return {
      low,
      {high_of(a.high_m.x, b.high_m.x, low.x), high_of(a.high_m.y, b.high_m.y, low.y), high_of(a.high_m.z, b.high_m.z, low.z)}};
}

std::vector<Vec3> grid_positions(const Box& box, int longest) {
  const Vec3 size = box.size_m();
  const double step_m = largest_component(size) / longest;
  if (!(step_m > 0.0)) return {};
  const auto count = [&](double side_m) { return std::max(1, static_cast<int>(std::lround(side_m / step_m))); };
  const int nx = count(size.x), ny = count(size.y), nz = count(size.z);
  std::vector<Vec3> positions;
  positions.reserve(static_cast<std::size_t>(nx) * ny * nz);
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        positions.push_back(box.low_m + Vec3{(i + 0.5) / nx * size.x, (j + 0.5) / ny * size.y, (k + 0.5) / nz * size.z});
      }
    }
  }
  return positions;
}

namespace {

/// Rotation rate about the flow's own direction [1/s], where rotation exceeds strain; 0 elsewhere. Excludes shear layers and
/// walls, where the flow rotates about a direction across it.
double swirl(const VectorSample& flow) noexcept {
  const Mat3& j = flow.jacobian;
  const double trace = j.row[0].x + j.row[1].y + j.row[2].z;
  const double squared = j.row[0].x * j.row[0].x + j.row[1].y * j.row[1].y + j.row[2].z * j.row[2].z +
                         2.0 * (j.row[0].y * j.row[1].x + j.row[0].z * j.row[2].x + j.row[1].z * j.row[2].y);
  if (trace * trace <= squared) return 0.0;
  const Vec3 curl{j.row[2].y - j.row[1].z, j.row[0].z - j.row[2].x, j.row[1].x - j.row[0].y};
  return 0.5 * std::abs(dot(curl, normalized(flow.value)));
}

struct Seed {
  Vec3 position_m;
  double speed;
  double swirl;
};

class Grown {
 public:
  Grown(const Field& field, const Box& box, double step_m, double least)
      : field_(field), box_(box), side_m_(largest_component(box.size_m())), step_m_(step_m), least_(least) {}

  /// Adds lines from seeds in order, at a distance from all others, up to `most`; false if more remain.
  bool grow(std::vector<Streamline>& lines, const std::vector<Seed>& seeds, std::size_t most, double apart_m) const {
    SeedLattice lattice(apart_m);
    for (const Streamline& line : lines) {
      for (const StreamPoint& point : line) lattice.take(point.position_m);
    }
    for (const Seed& seed : seeds) {
      if (lattice.near(seed.position_m)) continue;
      const Streamline line = through(seed);
      lattice.take(seed.position_m);
      for (const StreamPoint& point : line) lattice.take(point.position_m);
      if (static_cast<double>(line.size()) * step_m_ < 0.06 * side_m_) continue;  // too short to show a direction
      if (lines.size() == most) return false;
      lines.push_back(line);
    }
    return true;
  }

 private:
  Streamline through(const Seed& seed) const {
    const double longest_m = 2.0 * side_m_;
    bool closed = false;
    const Streamline ahead = half_line(field_, box_, seed.position_m, step_m_, longest_m, least_, closed);
    Streamline line;
    if (!closed) line = half_line(field_, box_, seed.position_m, -step_m_, longest_m, least_, closed);
    std::reverse(line.begin(), line.end());
    line.push_back({seed.position_m, seed.speed});
    line.insert(line.end(), ahead.begin(), ahead.end());
    if (closed) line.push_back({seed.position_m, seed.speed});
    return line;
  }

  const Field& field_;
  Box box_;
  double side_m_;
  double step_m_;
  double least_;
};

}  // namespace

std::vector<Streamline> streamlines(const Field& field, const Box& box, std::size_t most) {
  std::vector<Seed> seeds;
  for (const Vec3& position : grid_positions(box, 40)) {
    const VectorSample sample = field.vector(position);
    if (sample.inside && norm(sample.value) > 0.0) seeds.push_back({position, norm(sample.value), swirl(sample)});
  }
  std::stable_sort(seeds.begin(), seeds.end(), [](const Seed& a, const Seed& b) { return a.speed > b.speed; });
  if (seeds.empty()) return {};
  const double fast = seeds[seeds.size() / 200].speed;  // a quantile: measured data have outliers
  std::erase_if(seeds, [&](const Seed& seed) { return seed.speed < 0.2 * fast; });

  const double side_m = largest_component(box.size_m());
  const double step_m = std::clamp(0.5 * field.spacing_m(), side_m / 2000.0, side_m / 150.0);
  const Grown grown(field, box, step_m, 0.05 * fast);
  // [rad] Rotation while the flow crosses the box that counts as a vortex. Less: bends attract lines; more: weak vortices get
  // no lines of their own.
  constexpr double turns = 3.0;
  std::vector<Seed> in_vortices = seeds;
  std::erase_if(in_vortices, [&](const Seed& seed) { return seed.swirl * side_m < turns * fast; });
  std::stable_sort(in_vortices.begin(), in_vortices.end(), [](const Seed& a, const Seed& b) { return a.swirl > b.swirl; });

  std::vector<Streamline> winding;
  grown.grow(winding, in_vortices, most / 2, side_m / 60.0);
  for (double apart_m = side_m / 24.0;; apart_m *= 1.25) {
    std::vector<Streamline> lines = winding;
    if (grown.grow(lines, seeds, most, apart_m)) return lines;
  }
}

}  // namespace palpa::detail
