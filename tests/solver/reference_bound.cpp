#include "tests/solver/reference_bound.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace palpa::test {
namespace reference {
namespace {

// Of an elastic primitive, with |r| = `reach` and a force of length t along r: φ + φ* − t|r| with its due force v = min(κ|r|,
// s), (v − t)(|r| − (v + t)/2κ); while it holds, (κ|r| − t)²/2κ.
Quad elastic_gap(Quad reach, Quad t, Quad s, Quad stiffness) {
  const Quad v = stiffness * reach < s ? stiffness * reach : s;
  return v < s ? (v - t) * (v - t) / (2 * stiffness) : (v - t) * (reach - (v + t) / (2 * stiffness));
}

// One primitive's share of the duality gap [N m], in the form without cancellation: with l = min(|u|, s), m = (|u| − s)₊ T/c, e
// = u/|u|
//   point, line:  (s − l)|r| + l|r|/2 |e − r/|r||² + c/2T |r − m e|²
//   plane:        (s − l) r₊ + |u| r₋ + c/2T (r₊ − m)²
// `u` is projected on the primitive's force set first.
Quad gap_of(const Primitive& p, const V<Quad>& q, const V<Quad>& x_m, Quad T, V<Quad>& u) {
  const Quad s = p.strength_n;
  const Quad c = p.drag_ns_per_m > 0.0 ? Quad(p.drag_ns_per_m) / T : Quad(0);
  const V<Quad> d = V<Quad>(p.position_m) - x_m;
  if (p.kind == PrimitiveKind::plane) {
    Quad t = positive(dot(q, u));
    if (c == 0 && t > s) t = s;
    u = t * q;
    const Quad r = dot(q, d);
    if (p.is_elastic()) return elastic_gap(positive(r), t, s, p.stiffness_n_per_m) + t * positive(-r);
    const Quad l = t < s ? t : s;
    Quad gap = (s - l) * positive(r) + t * positive(-r);
    if (c > 0) {
      const Quad miss = positive(r) - (t - l) / c;
      gap += c / 2 * miss * miss;
    }
    return gap;
  }
  V<Quad> r = d;
  if (p.kind == PrimitiveKind::line) u = across(q, u), r = across(q, d);
  Quad size = length(u);
  if (c == 0 && size > s) u = (s / size) * u, size = s;
  const Quad l = size < s ? size : s;
  const Quad reach = length(r);
  const V<Quad> e = size > 0 ? (1 / size) * u : V<Quad>{};
  Quad gap = (s - l) * reach;
  if (l > 0 && reach > 0) {
    const V<Quad> chord = e - (1 / reach) * r;
    gap += l * reach * dot(chord, chord) / 2;
  }
  if (c > 0) {
    const V<Quad> miss = r - ((size - l) / c) * e;
    gap += c / 2 * dot(miss, miss);
  }
  return gap;
}

// A corner's share for the forces `u` of its facets, which are projected first: with w the path from x to the nearest free
// point, (s|w| − u·w) + Σ t (n·w − n·(a − x))₊ + (s/σ) v, v the infeasibility of x + w.
Quad gap_of_corner(std::span<const Primitive> facets, const V<Quad>& x_m, std::span<V<Quad>> u) {
  const Quad s = facets[0].strength_n;
  std::vector<V<Quad>> normals;
  std::vector<Quad> c, t;
  V<Quad> sum;
  for (std::size_t i = 0; i < facets.size(); ++i) {
    normals.push_back(unit<Quad>(facets[i]));
    c.push_back(dot(normals[i], V<Quad>(facets[i].position_m) - x_m));
    t.push_back(positive(dot(normals[i], u[i])));
    sum = sum + t[i] * normals[i];
  }
  const Quad size = length(sum), share = size > s ? s / size : Quad(1);
  sum = share * sum;
  for (std::size_t i = 0; i < facets.size(); ++i) t[i] *= share, u[i] = t[i] * normals[i];
  const V<Quad> w = Projection<Quad>(normals, c).least_way().w;
  const Quad reach = length(w), l = share * size;
  // Off the corner its force is s w/|w|. The t of doubles add up to that but for rounding, which counts as it: the rest is
  // residual.
  const bool elastic = facets[0].is_elastic();
  const Quad stiffness = elastic ? Quad(facets[0].stiffness_n_per_m) : Quad(0);
  const Quad given = elastic && stiffness * reach < s ? stiffness * reach : s;
  const V<Quad> full = reach > 0 ? (given / reach) * w : sum;
  Quad sizes = s;
  for (const Quad& one : t) sizes += one;
  if (length(full - sum) <= Quad(2e-15) * sizes) {
    std::fill(u.begin(), u.end(), V<Quad>{});
    u[0] = full;
    return 0;
  }
  Quad gap = elastic ? elastic_gap(reach, l, s, stiffness) : (s - l) * reach, lacking = 0;
  if (l > 0 && reach > 0) {
    const V<Quad> chord = (1 / l) * sum - (1 / reach) * w;
    gap += l * reach * dot(chord, chord) / 2;
  }
  for (std::size_t i = 0; i < facets.size(); ++i) {
    gap += t[i] * positive(dot(normals[i], w) - c[i]);
    lacking = std::max(lacking, c[i] - dot(normals[i], w));
  }
  const std::vector<Quad> ones(facets.size(), Quad(1));
  return gap + s * length(Projection<Quad>(normals, ones).least_way().w) * lacking;
}

}  // namespace

Quad gap_of(std::span<const Primitive> whole, const V<Quad>& x_m, Quad time_step_s, std::span<V<Quad>> u) {
  const Primitive& p = whole[0];
  if (p.kind == PrimitiveKind::corner) return gap_of_corner(whole, x_m, u);
  if (p.kind != PrimitiveKind::directed) return gap_of(p, unit<Quad>(p), x_m, time_step_s, u[0]);
  u[0] = Quad(p.strength_n) * unit<Quad>(p);
  return 0;
}

std::size_t size_of_whole(const std::vector<Primitive>& primitives, std::size_t i) {
  return primitives[i].kind == PrimitiveKind::corner ? end_of_corner(primitives, i) - i : 1;
}

Quad bound_of(const Problem& problem, const V<Quad>& x_m, std::vector<V<Quad>> forces) {
  const Quad k = problem.stiffness_n_per_m;
  V<Quad> left = k * (x_m - V<Quad>(problem.probe_m));
  Quad gap = 0;
  for (std::size_t i = 0, size = 0; i < problem.primitives.size(); i += size) {
    size = size_of_whole(problem.primitives, i);
    gap += gap_of(std::span(problem.primitives).subspan(i, size), x_m, problem.time_step_s, std::span(forces).subspan(i, size));
  }
  for (const V<Quad>& force : forces) left = left - force;
  const Quad squared = dot(left, left);
  return (root(squared) + root(squared + 4 * k * gap)) / (2 * k);
}

}  // namespace reference

double plain_bound_m(const Problem& problem, std::span<const Vec3> forces_n, const Vec3& position_m, const Vec3& remainder_m) {
  // A double has s e only to a few ulp, which would cost s|R| ulp in the gap of any answer: a force whose length is its
  // strength but for rounding counts as exactly so long.
  std::vector<reference::V<Quad>> forces(forces_n.begin(), forces_n.end());
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const Primitive& p = problem.primitives[i];
    const std::size_t end = i + reference::size_of_whole(problem.primitives, i);
    reference::V<Quad> sum;
    Quad sizes = 0;
    for (std::size_t j = i; j < end; ++j) sum = sum + forces[j], sizes += reference::root(dot(forces[j], forces[j]));
    const Quad length = reference::root(dot(sum, sum)), s = p.strength_n, rounding = Quad(2e-15) * std::max(s, sizes);
    const bool full = p.drag_ns_per_m == 0.0 && length > 0 && length - s < rounding && s - length < rounding;
    for (; i < end; ++i) forces[i] = full ? (s / length) * forces[i] : forces[i];
    --i;
  }
  return static_cast<double>(
      reference::bound_of(problem, reference::V<Quad>(position_m) + reference::V<Quad>(remainder_m), forces));
}

}  // namespace palpa::test
