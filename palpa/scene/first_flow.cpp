#include "palpa/scene/first_flow.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpa/data/derived.h"
#include "palpa/data/halton.h"
#include "palpa/data/octave_parts.h"
#include "palpa/data/quantile.h"
#include "palpa/data/volume.h"
#include "palpa/file/derived_name.h"

namespace palpa::detail {
namespace {

// [1] Share of noise in moving cells, above which noise is masked; clean flows have less than 0.01. Less: turbulence is masked;
// more: noise is felt.
constexpr double many = 0.15;
// [1] Share of the data that flow, below which another field locates tissue. More: it is used for wide flows, too; less:
// nothing is felt around narrow vessels.
constexpr double sparse = 0.2;
// [1] Share of all flowing cells in the object's parts. More: scattered noise widens the object; less: small branches are left
// out.
constexpr double enough = 0.9;
// [spacings] Shortest vortex: noise, smoothed over two spacings, makes blobs of four or five. Less: blobs are taken for
// vortices; more: small vortices are not felt.
constexpr double least_vortex = 6.0;

// [1] Least Q, as a share of the Q of a solid rotation with equal curl. In a shear layer, which deforms as much as it rotates,
// Q is 0. Less: shear layers become vortices; more: stretched vortices are lost.
constexpr double least_swirl = 0.3;

/// Flow at a cell of a lattice.
struct Cell {
  bool inside = false;
  bool moves = false;
  double speed = 0.0;
  double coherence = 1.0;  ///< [1] of moving cells
};

/// The field that is high nearly wherever there is flow, and low in much of the rest.
std::optional<FlowSignal> signal_of(const Lattice& lattice, const Volume& volume, std::size_t flow,
                                    const std::vector<Cell>& cells, const std::vector<char>& flows, bool noisy,
                                    const std::vector<Statistics>& values) {
  std::optional<FlowSignal> best;
  double best_share = 0.7;  // [1] of the data where the field may be high: with more, its mask would exclude hardly anything
  for (std::size_t f = 0; f < volume.fields.size(); ++f) {
    const Field& field = *volume.fields[f].field;
    const Statistics& v = values[f];
    if (f == flow || field.components() != 1 || !(v.max > v.min) || v.min < 0.0) continue;
    const auto level = dividing_value(v.histogram, v.min, std::max(v.histogram.percentile(0.999), v.histogram.edge(1)));
    if (!level) continue;
    std::size_t all = 0, high = 0, flowing = 0, flowing_high = 0, noise = 0, noise_high = 0;
    for (std::size_t n = 0; n < cells.size(); ++n) {
      if (!cells[n].inside) continue;
      const bool is_high = field.scalar(lattice.middle_m(n)).value >= *level;
      const bool is_noise = cells[n].moves && cells[n].coherence < coherence_of_noise;
      ++all, high += is_high;
      flowing += flows[n] != 0, flowing_high += flows[n] && is_high;
      noise += is_noise, noise_high += is_noise && is_high;
    }
    const double share = static_cast<double>(high) / static_cast<double>(std::max<std::size_t>(all, 1));
    const bool holds_the_flow = static_cast<double>(flowing_high) >= 0.8 * static_cast<double>(flowing);
    const bool leaves_noise_out = !noisy || static_cast<double>(noise_high) <= 0.2 * static_cast<double>(noise);
    if (!(share < best_share) || !holds_the_flow || !leaves_noise_out) continue;
    best_share = share;
    const double above = v.histogram.mean_between(*level, v.max);
    best = {f, rounded(*level, v.max - v.min), rounded(*level + 0.25 * (above - *level), v.max - v.min)};
  }
  return best;
}

/// Cells at most `way_m` along any axis from a cell without data or with a speed of at most `still`.
std::vector<char> near(const Lattice& lattice, const std::vector<Cell>& cells, double still, double way_m) {
  std::vector<char> found(lattice.size(), 0);
  for (std::size_t n = 0; n < cells.size(); ++n) found[n] = !cells[n].inside || cells[n].speed <= still;
  const int way = static_cast<int>(std::ceil(way_m / lattice.cell_m()));
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<char> before = found;
    for (std::size_t n = 0; n < before.size(); ++n) {
      if (!before[n]) continue;
      std::array<int, 3> at = lattice.indices(n);
      const int here = at[static_cast<std::size_t>(axis)];
      for (int i = std::max(here - way, 0); i <= std::min(here + way, lattice.count(axis) - 1); ++i) {
        at[static_cast<std::size_t>(axis)] = i;
        found[lattice.number(at[0], at[1], at[2])] = 1;
      }
    }
  }
  return found;
}

/// Field that separates fluid from wall: nearly all of its values lie near two values, and hardly a cell is on the wrong side.
std::optional<Wall> wall_of(const Lattice& lattice, const Volume& volume, std::size_t flow, const std::vector<Cell>& cells,
                            const std::vector<char>& flows, const std::vector<Statistics>& values) {
  // [1] Distance of values from the ends of the span, as a share of it, and the share of values within: a resampled mask has
  // fractions at its edge. More, less: an image is taken for a mask; less, more: a mask is missed.
  constexpr double near_an_end = 0.02, nearly_all = 0.85;
  // [1] Of the flow: largest share of cells on the wrong side; in a narrow vessel many lie on its edge. More: an unrelated mask
  // is a wall; less: vessels have none.
  constexpr double few = 0.25;
  for (std::size_t f = 0; f < volume.fields.size(); ++f) {
    const Field& field = *volume.fields[f].field;
    const Statistics& v = values[f];
    const double span = v.max - v.min;
    if (f == flow || field.components() != 1 || !(span > 0.0)) continue;
    const double low = v.histogram.share_between(v.min, v.min + near_an_end * span);
    const double high = v.histogram.share_between(v.max - near_an_end * span, v.max);
    const double between = std::max(0.0, 1.0 - low - high);
    if (low + high < nearly_all || between > 2.0 * std::min(low, high))
      continue;  // few voxels of an image are near its maximum
    const double level = 0.5 * (v.min + v.max);
    std::size_t flowing = 0, flowing_high = 0, all = 0, all_high = 0;
    for (std::size_t n = 0; n < cells.size(); ++n) {
      const ScalarSample s = cells[n].inside ? field.scalar(lattice.middle_m(n)) : ScalarSample{};
      if (!s.inside) continue;
      const bool is_high = s.value >= level;
      flowing += flows[n] != 0, flowing_high += flows[n] && is_high;
      ++all, all_high += is_high;
    }
    const bool fluid_is_high = 2 * flowing_high > flowing;
    const std::size_t astray = fluid_is_high ? flowing - flowing_high : flowing_high;
    const std::size_t behind = fluid_is_high ? all - all_high : all_high;
    if (flowing == 0 || behind == 0 || static_cast<double>(astray) > few * static_cast<double>(flowing)) continue;
    return Wall{f, rounded(level, span), rounded(level + (fluid_is_high ? 0.4 : -0.4) * span, span), all < 2 * behind};
  }
  return std::nullopt;
}

/// Number of the field of a store that is the curl of another.
std::optional<std::size_t> derived_curl(const Volume& volume, std::size_t flow) {
  const std::string name = name_of(DerivedArray{Derivation::curl, array_of(volume, flow)});
  for (std::size_t f = 0; f < volume.fields.size(); ++f) {
    if (array_of(volume, f) == name && volume.fields[f].field->components() == 3) return f;
  }
  return std::nullopt;
}

/// Lengths of a curl in the object: at its cells; of a field in octaves in blocks of octave 0, as means are shorter.
std::vector<double> lengths_in(const Lattice& lattice, const Field& curl, const Object& object) {
  std::vector<double> lengths;
  const auto add = [&](const Field& field, const Vec3& at_m) {
    if (const VectorSample c = field.vector(at_m); c.inside) lengths.push_back(norm(c.value));
  };
  if (const Octaves* octaves = octaves_of(curl)) {
    constexpr int places = 64;  // [1] of a block. More: slower; fewer: a less certain median
    for (const FieldPtr& block : octave_sample(*octaves))
      for (int n = 1; n <= places; ++n) {
        const Vec3 at_m = halton(n, block->bounds_m());
        if (const auto cell = lattice.cell_at(at_m); cell && object.cells[*cell]) add(*block, at_m);
      }
  } else {
    for (std::size_t n = 0; n < object.cells.size(); ++n) {
      if (object.cells[n]) add(curl, lattice.middle_m(n));
    }
  }
  return lengths;
}

/// Region where the flow rotates; none where it is uniform.
std::optional<Turning> turning_of(const Lattice& lattice, const FieldPtr& curl, const FlowPlaces& flow) {
  // A flow in solid rotation has a curl of twice its rate.
  Turning found;
  found.from = std::numbers::pi * flow.speeds.fast / largest_component(flow.object.box_m.size_m());
  std::vector<double> above;
  for (const double length : lengths_in(lattice, *curl, flow.object)) {
    found.most = std::max(found.most, length);
    if (length > found.from) above.push_back(length);
  }
  if (above.empty()) return std::nullopt;
  found.full = std::max(2.0 * found.from, median(above));
  for (const ValueRange& extent : curl->value_ranges())
    found.most = std::max({found.most, std::abs(extent.min), std::abs(extent.max)});
  found.from = rounded(found.from, found.from), found.full = rounded(found.full, found.full);
  return found;
}

/// Least Q of a vortex in this flow: above the rotation of the whole, and above noise.
Vortices least_vortices(const Field& field, const std::vector<Cell>& cells, const FlowPlaces& flow) {
  // A vortex rotates by more than a quarter turn while the stream crosses the object. Q of a solid rotation is its rate
  // squared.
  const double length_m = largest_component(flow.object.box_m.size_m()), spacing_m = field.spacing_m();
  const double rate = 0.5 * std::numbers::pi * flow.speeds.fast / length_m;
  // The coherence measures the deviation of vectors from their mean, by noise or by a slope. White noise with deviation σ,
  // smoothed over two spacings h, gives each derivative a deviation of 0.0187 σ/h; one Q in a million is above 17 times its
  // square.
  std::vector<double> deviations;
  for (std::size_t n = 0; n < cells.size(); ++n) {
    const Cell& c = cells[n];
    if (flow.object.cells[n]) deviations.push_back(c.speed * std::sqrt(std::max(0.0, 1.0 - c.coherence * c.coherence) / 3.0));
  }
  const double steepness = 0.0187 * median(deviations) / spacing_m;
  Vortices found;
  found.from = std::max(rate * rate, 20.0 * steepness * steepness);
  found.by_noise = found.from > rate * rate;
  return found;
}

std::optional<Vortices> vortices_of(const Lattice& lattice, const Field& field, const std::vector<Cell>& cells,
                                    const FlowPlaces& flow) {
  const FieldPtr q = derived(Derivation::q, FieldPtr(FieldPtr(), &field));
  const double spacing_m = field.spacing_m();
  Vortices found = least_vortices(field, cells, flow);

  // Beside walls a flow rotates without a vortex: cells near walls, or near the end of the data, are left out.
  const std::vector<char> walls = near(lattice, cells, 1e-6 * flow.speeds.fast, 4.0 * spacing_m);
  const FieldPtr smoothed = derived(Derivation::smooth_vector, FieldPtr(FieldPtr(), &field));
  std::vector<char> turns(lattice.size(), 0);
  std::vector<double> values(lattice.size(), 0.0), at_walls;
  for (std::size_t n = 0; n < cells.size(); ++n) {
    if (!flow.object.cells[n]) continue;
    const Vec3 at_m = lattice.middle_m(n);
    values[n] = q->scalar(at_m).value;
    if (walls[n]) {
      if (values[n] > found.from) at_walls.push_back(cells[n].coherence);
      continue;
    }
    const Mat3 j = smoothed->vector(at_m).jacobian;
    const Vec3 curl{j.row[2].y - j.row[1].z, j.row[0].z - j.row[2].x, j.row[1].x - j.row[0].y};
    turns[n] = values[n] > found.from && values[n] > least_swirl * 0.25 * norm_squared(curl);
  }
  const Object vortices = largest_parts(lattice, std::move(turns), enough);
  if (vortices.part.empty()) return std::nullopt;
  std::vector<double> inside, coherent;
  Vec3 low_m = lattice.middle_m(vortices.part.front()), high_m = low_m;
  for (const std::size_t n : vortices.part) {
    const Vec3 at_m = lattice.middle_m(n);
    low_m = {std::min(low_m.x, at_m.x), std::min(low_m.y, at_m.y), std::min(low_m.z, at_m.z)};
    high_m = {std::max(high_m.x, at_m.x), std::max(high_m.y, at_m.y), std::max(high_m.z, at_m.z)};
    if (values[n] > found.most) found.most = values[n], found.core_m = at_m;
    inside.push_back(values[n]);
    coherent.push_back(cells[n].coherence);
  }
  if (largest_component(high_m - low_m) + lattice.cell_m() < least_vortex * spacing_m) return std::nullopt;
  // In the stronger half of the vortex the pull has its full strength, even if its Q is hardly above `from`.
  found.full = std::min(std::max(2.0 * found.from, median(inside)), 0.5 * (found.from + found.most));
  if (10 * at_walls.size() > coherent.size()) {
    const double of_walls = median(at_walls), of_vortices = quantile(coherent, 0.05);
    if (of_walls < of_vortices) {
      found.coherence_from = rounded(0.5 * (of_walls + of_vortices), 1.0);
      found.coherence_full = rounded(std::max(of_vortices, found.coherence_from + 0.01), 1.0);
    }
  }
  found.from = rounded(found.from, found.from), found.full = rounded(found.full, found.full);
  found.most = std::max(found.most, q->value_ranges()[0].max);
  return found;
}

/// Share [1] of noise in what moves, of blocks of octave 0.
double noisy_share_of(const Octaves& octaves, double empty) {
  std::size_t moving = 0, noise = 0;
  for (const FieldPtr& block : octave_sample(octaves)) {
    const FieldPtr coherence = derived(Derivation::coherence, block);
    constexpr int places = 64;  // [1] of a block. More: slower; fewer: a less certain share
    for (int n = 1; n <= places; ++n) {
      const Vec3 at_m = halton(n, block->bounds_m());
      const VectorSample u = block->vector(at_m);
      const ScalarSample c = coherence->scalar(at_m);
      if (!u.inside || !c.inside || !(norm(u.value) > empty)) continue;
      ++moving, noise += c.value < coherence_of_noise;
    }
  }
  return static_cast<double>(noise) / static_cast<double>(std::max<std::size_t>(moving, 1));
}

/// Flow at each cell of the lattice, and the noise in it.
std::vector<Cell> cells_of(const Lattice& lattice, const FieldPtr& field, const FirstFlow& speeds, FlowPlaces& found) {
  std::vector<Cell> cells(lattice.size());
  const bool has_coherence = !speeds.directions && !found.in_octaves;
  const FieldPtr coherence = has_coherence ? derived(Derivation::coherence, field) : nullptr;
  std::size_t moving = 0, noise = 0;
  for (std::size_t n = 0; n < cells.size(); ++n) {
    const Vec3 at_m = lattice.middle_m(n);
    const VectorSample u = field->vector(at_m);
    if (!u.inside) continue;
    Cell& cell = cells[n];
    cell.inside = true;
    cell.speed = norm(u.value);
    cell.moves = cell.speed > speeds.empty;
    if (cell.moves && coherence) {
      const ScalarSample c = coherence->scalar(at_m);
      if (c.inside) cell.coherence = c.value;  // unknown beside a hole in the data: stays 1
    }
    moving += cell.moves, noise += cell.moves && cell.coherence < coherence_of_noise;
  }
  found.noisy_share = static_cast<double>(noise) / static_cast<double>(std::max<std::size_t>(moving, 1));
  if (const Octaves* octaves = octaves_of(*field); octaves && !speeds.directions)
    found.noisy_share = noisy_share_of(*octaves, speeds.empty);
  found.noisy = found.noisy_share > many;
  return cells;
}

/// Speeds without noise, which may be faster than the flow.
void leave_noise_out(const std::vector<Cell>& cells, FirstFlow& speeds) {
  std::vector<double> streams;
  for (const Cell& c : cells) {
    if (c.moves && c.coherence >= coherence_of_flow) streams.push_back(c.speed);
  }
  const double fast = quantile(streams, 0.995);
  if (!(fast > 0.0)) return;
  speeds.fast = rounded(fast, fast), speeds.empty = rounded(0.05 * fast, 0.05 * fast);
  speeds.moderate = rounded(std::max(median(streams), 2.0 * speeds.empty), fast);
}

}  // namespace

std::string array_of(const Volume& volume, std::size_t field) {
  const std::string& name = volume.fields[field].name;
  for (const auto& asked : volume.request ? volume.request->fields : std::vector<VolumeRequest::FieldRequest>{}) {
    if (asked.name == name && !asked.array.empty()) return asked.array;
  }
  return name;
}

FlowPlaces flow_places(const Lattice& lattice, const Volume& volume, std::size_t flow, const FirstFlow& speeds,
                       const std::vector<Statistics>& values) {
  const FieldPtr& field = volume.fields[flow].field;
  FlowPlaces found;
  found.speeds = speeds;
  found.in_octaves = octaves_of(*field) != nullptr;
  const std::vector<Cell> cells = cells_of(lattice, field, speeds, found);
  if (found.noisy && !found.in_octaves) leave_noise_out(cells, found.speeds);
  std::vector<char> flows(lattice.size(), 0);
  std::size_t flowing = 0, inside = 0;
  for (std::size_t n = 0; n < cells.size(); ++n) {
    flows[n] = cells[n].speed > found.speeds.empty && (!found.noisy || cells[n].coherence >= coherence_of_flow);
    flowing += flows[n] != 0, inside += cells[n].inside;
  }
  if (!speeds.directions) found.wall = wall_of(lattice, volume, flow, cells, flows, values);
  if (!found.wall && (found.noisy || static_cast<double>(flowing) < sparse * static_cast<double>(inside))) {
    found.signal = signal_of(lattice, volume, flow, cells, flows, found.noisy, values);
  }
  found.object = largest_parts(lattice, std::move(flows), enough);
  if (speeds.directions) return found;
  if (found.in_octaves) {
    found.curl = derived_curl(volume, flow);
    if (found.curl) found.turning = turning_of(lattice, volume.fields[*found.curl].field, found);
    return found;
  }
  found.turning = turning_of(lattice, derived(Derivation::curl, field), found);
  found.vortices = vortices_of(lattice, *field, cells, found);
  return found;
}

}  // namespace palpa::detail
