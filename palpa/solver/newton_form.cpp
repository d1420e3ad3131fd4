#include "palpa/solver/newton_form.h"

namespace palpa::detail {

LeastWay Corner::pull(const Vec3& Z, double tau, const Face& guess) const noexcept {
  double c[most_facets];
  for (std::size_t i = 0; i < normals.size(); ++i) c[i] = tau * residual(i, Z) + dot(normals[i], u);
  return least_way(normals, c, guess);
}

void Corner::answer(const LeastWay& way, double tau) noexcept {
  face = way.face;
  u = compliance > 0.0 ? way.w / (1.0 + compliance * tau) : way.w;
  confine(norm_squared(u) > s * s);
}

void Corner::confine(bool slips) noexcept {
  face.shares(u, t);
  for (int a = 0; a < face.size; ++a) t[a] = std::max(0.0, t[a]);
  gather(slips);
}

void Corner::gather(bool full) noexcept {
  u = {};
  for (int a = 0; a < face.size; ++a) u += t[a] * normals[static_cast<std::size_t>(face.facet[a])];
  const double squared = norm_squared(u);
  if (squared > s * s || (full && squared > 0.0)) {
    const double share = s / std::sqrt(squared);
    u *= share;
    for (double& one : t) one *= share;
  }
}

void Corner::give(Vec3* forces_n) const noexcept {
  std::fill_n(&forces_n[index], normals.size(), Vec3{});
  for (int a = 0; a < face.size; ++a) {
    const auto i = static_cast<std::size_t>(face.facet[a]);
    forces_n[index + i] = t[a] * normals[i];
  }
}

namespace {

struct CornerGap {
  Gap gap;
  bool clear = false;  // the hull of the face is free of all other facets, rounding included
};

// Adds φ(|w|) + c|u|²/2 − u·w of an elastic corner: |w − cu|²/2c while it holds, beyond as in `elastic_gap`, and the angle.
void add_elastic(Gap& gap, const Corner& p, const Vec3& w, double off) noexcept {
  const double c = p.compliance;
  const double reach = std::sqrt(norm_squared(w)), length = std::sqrt(norm_squared(p.u));
  const double v = std::min(reach / c, p.s);
  off += 8.0 * epsilon * (reach + c * (v + length));
  const Vec3 should = reach > 0.0 ? (v / reach) * w : Vec3{};
  const double miss = norm(should - p.u) + 8.0 * epsilon * (v + length);
  double plain = 0.0;
  if (v < p.s) {
    plain = 0.5 * norm_squared(w - c * p.u) / c;
  } else {
    const double pull = dot(p.u, w);
    const double turned = pull > 0.0 ? norm_squared(cross(p.u, w)) / (length * reach + pull) : length * reach - pull;
    plain = std::max(0.0, (v - length) * (reach - 0.5 * c * (v + length))) + turned;
  }
  gap.plain += plain;
  gap.rounded += plain * (1.0 + 16.0 * epsilon) + off * std::min(miss + 0.5 * off / c, p.s + length + miss);
}

// Adds s|w| − u·w, with w off by `off` at most and Σ t `pressed`; and the distance of u from the corner's exact force.
void add_direction(Gap& gap, const Corner& p, const Vec3& w, double off, double pressed) noexcept {
  const double reach = std::sqrt(norm_squared(w));
  const double pull = dot(p.u, w);
  const double length = std::sqrt(norm_squared(p.u));
  gap.slack = 6.0 * epsilon * (p.s + pressed) + std::max(0.0, length - p.s);
  if (p.compliance > 0.0) return add_elastic(gap, p, w, off);
  if (std::abs(length - p.s) <= 16.0 * epsilon * (p.s + pressed)) {
    // Exactly s but for rounding: the remaining error is the angle between the force and w.
    gap.slack += std::abs(length - p.s) + 12.0 * epsilon * (p.s + pressed);
    if (pull > 0.0 && reach > 4.0 * off) {
      const double turned = norm_squared(cross(p.u, w));
      const double raise = p.s * (off + 8.0 * epsilon * reach);
      gap.plain += turned / (p.s * reach + pull);
      gap.rounded += (1.25 * turned + 5.0 * raise * raise) / (p.s * (reach - 4.0 * off) + pull);
      return;
    }
  }
  const double short_of = std::max(0.0, p.s * reach - pull);
  gap.plain += short_of;
  gap.rounded += short_of + p.s * (2.0 * off + 8.0 * epsilon * reach);
}

// Gap for the w of the face A.
CornerGap gap_at(const Corner& p, const Vec3& Z, const Face& A) noexcept {
  const std::size_t m = p.normals.size();
  double r[most_facets], beyond[most_facets], delta[most_facets];  // beyond = n·w − r
  bool in_A[most_facets] = {};
  for (std::size_t i = 0; i < m; ++i) r[i] = p.residual(i, Z);
  const Vec3 w = A.hull(r);
  const double size = size_of(Z) + size_of(w);
  for (std::size_t i = 0; i < m; ++i) {
    beyond[i] = dot(p.normals[i], w) - r[i];
    delta[i] = plane_rounding * (std::abs(p.b[i]) + size);
  }
  double miss = 0.0;
  for (int a = 0; a < A.size; ++a) {
    const auto i = static_cast<std::size_t>(A.facet[a]);
    in_A[i] = true;
    miss = std::max(miss, std::abs(beyond[i]) + delta[i]);
  }
  // The exact hull is within h of w.
  const double h = A.size > 0 ? 2.0 * miss * A.inverse_norm() : 0.0;
  CornerGap result;
  result.clear = true;
  double lacking = 0.0, raised_lacking = 0.0, pressed = 0.0;
  for (std::size_t i = 0; i < m; ++i) {
    result.clear = result.clear && (in_A[i] || beyond[i] > delta[i] + h);
    lacking = std::max(lacking, -beyond[i]);
    raised_lacking = std::max(raised_lacking, delta[i] - beyond[i]);
  }
  Gap& gap = result.gap;
  for (int a = 0; a < p.face.size; ++a) {
    const auto i = static_cast<std::size_t>(p.face.facet[a]);
    pressed += p.t[a];
    if (result.clear && in_A[i]) continue;
    gap.plain += p.t[a] * std::max(0.0, beyond[i]);
    gap.rounded += p.t[a] * std::max(0.0, beyond[i] + delta[i] + (result.clear ? h : 0.0));
  }
  if (!result.clear) {
    const double width = width_of(p.normals);
    const bool wide = width >= 0.5 * narrowest_corner;  // a narrower corner may be empty: no bound
    gap.plain += wide ? p.s / width * lacking : std::numeric_limits<double>::infinity();
    gap.rounded += wide ? p.s / width * raised_lacking : std::numeric_limits<double>::infinity();
  }
  add_direction(gap, p, w, result.clear ? h : 0.0, pressed);
  return result;
}

// Largest inverse norm of all possible faces of these facets: the motion of the least way per shift of theirs.
double most_moved(std::span<const Vec3> normals, const bool* among) noexcept {
  double most = 0.0;
  const int m = static_cast<int>(normals.size());
  const auto differ_too_little = [&](int i, const Face& face) {
    for (int a = 0; a < face.size; ++a) {
      if (normals[static_cast<std::size_t>(face.facet[a])] == normals[static_cast<std::size_t>(i)]) return false;
    }
    return true;
  };
  for (int i = 0; i < m; ++i) {
    for (int j = i; j < m; ++j) {
      for (int l = j; l < m; ++l) {
        if (!among[i] || !among[j] || !among[l]) continue;
        Face face;
        for (const int one : {i, j, l}) {
          const bool again = (one == j && j == i) || (one == l && l == j);
          if (again || face.take(one, normals[static_cast<std::size_t>(one)])) continue;
          if (differ_too_little(one, face)) return std::numeric_limits<double>::infinity();
        }
        most = std::max(most, face.inverse_norm());
      }
    }
  }
  return most;
}

// Off the corner, beyond its deflection, the exact force is s w*/|w*| with w* the exact least way; a nearby force may replace
// it. w = Σ t n is the exact least way for c that are off by `shift` at most; the least way is continuous in c and linear in
// each face, so w* is within `reach` of it.
Gap gap_off(const Corner& p, const Vec3& Z, const LeastWay& way) noexcept {
  const std::size_t m = p.normals.size();
  Vec3 w;
  double pressed = 0.0, shift = 0.0;
  bool in_face[most_facets] = {}, near[most_facets] = {};
  for (int a = 0; a < way.face.size; ++a) {
    const auto i = static_cast<std::size_t>(way.face.facet[a]);
    in_face[i] = true;
    w += way.t[a] * p.normals[i];
    pressed += way.t[a];
  }
  const double rounding = 6.0 * epsilon * pressed;
  double beyond[most_facets];
  for (std::size_t i = 0; i < m; ++i) {
    beyond[i] = dot(p.normals[i], w) - p.residual(i, Z);
    const double raise = plane_rounding * (std::abs(p.b[i]) + size_of(Z) + size_of(w)) + rounding;
    shift = std::max(shift, (in_face[i] ? std::abs(beyond[i]) : std::max(0.0, -beyond[i])) + raise);
  }
  double reach = 0.0;
  for (double next = shift; next > reach;) {
    reach = next;
    for (std::size_t i = 0; i < m; ++i) near[i] = in_face[i] || beyond[i] <= reach + 2.0 * shift;
    next = 2.0 * shift * most_moved(p.normals, near);
  }
  const double length = std::sqrt(norm_squared(w));
  Gap gap;
  const bool is_off = p.compliance * p.s + reach + rounding < length;
  gap.slack = is_off && reach + rounding < 0.25 * length
                  ? norm((p.s / length) * w - p.u) + 2.0 * p.s * (reach + rounding) / length + 16.0 * epsilon * p.s
                  : std::numeric_limits<double>::infinity();
  return gap;
}

}  // namespace

Gap gap(const Corner& p, const Vec3& Z) noexcept {
  const CornerGap own = gap_at(p, Z, p.face);
  if (own.clear) return own.gap;
  double r[most_facets];
  for (std::size_t i = 0; i < p.normals.size(); ++i) r[i] = p.residual(i, Z);
  const LeastWay way = least_way(p.normals, r);
  const CornerGap seen = gap_at(p, Z, way.face);
  if (seen.clear) return seen.gap;
  const auto cost = [](const Gap& gap) { return gap.slack + std::sqrt(gap.rounded); };
  Gap best = cost(seen.gap) < cost(own.gap) ? seen.gap : own.gap;
  if (Gap off = gap_off(p, Z, way); cost(off) < cost(best)) {
    off.plain = best.plain;
    best = off;
  }
  return best;
}

}  // namespace palpa::detail
