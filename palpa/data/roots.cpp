#include "palpa/data/roots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace palpa {
namespace {

using Controls = std::array<double, largest_degree + 1>;

// De Casteljau: `low` and `high` become the polynomial before and after `share`. `low` may alias `whole`.
void split(const double* whole, int degree, double share, double* low, double* high) noexcept {
  Controls c;
  std::copy(whole, whole + degree + 1, c.begin());
  for (int left = degree; left >= 0; --left) {
    low[degree - left] = c[0];
    high[left] = c[static_cast<std::size_t>(left)];
    for (int i = 0; i < left; ++i) {
      const auto n = static_cast<std::size_t>(i);
      c[n] += share * (c[n + 1] - c[n]);
    }
  }
}

// Interval of the share, with the coefficients over it minus the level, negated if need be so that positive is beyond.
struct Interval {
  double begin, end;
  Controls q;
};

// A value at the level is beyond on the way up only.
struct Beyond {
  bool up;
  bool operator()(double q) const noexcept { return up ? q >= 0.0 : q > 0.0; }
};

// Root of a polynomial that goes beyond once: false position, with bisection on slow convergence.
double single_root(const Interval& in, int degree, Beyond beyond) noexcept {
  double low = 0.0, high = 1.0;
  double at_low = in.q[0], at_high = in.q[static_cast<std::size_t>(degree)];
  bool halve = false;
  while (high - low > 1e-15 && at_high > 0.0) {
    const double before = high - low;
    double middle = 0.5 * (low + high);
    if (!halve) {
      const double secant = low + before * (at_low / (at_low - at_high));
      // Slightly beyond the secant from the nearer end, so that both ends close in.
      const double min_offset = std::max(1e-16, 0.01 * std::min(secant - low, high - secant));
      const double nearer = secant - low < high - secant ? secant + min_offset : secant - min_offset;
      if (nearer > low && nearer < high) middle = nearer;
    }
    if (!(middle > low && middle < high)) break;
    const double value = value_of(in.q.data(), degree, middle);
    (beyond(value) ? high : low) = middle;
    (beyond(value) ? at_high : at_low) = value;
    halve = high - low > 0.5 * before;
  }
  return in.begin + high * (in.end - in.begin);
}

}  // namespace

double value_of(const double* control, int degree, double share) noexcept {
  Controls c;
  std::copy(control, control + degree + 1, c.begin());
  for (int left = degree; left > 0; --left) {
    for (int i = 0; i < left; ++i) {
      const auto n = static_cast<std::size_t>(i);
      c[n] += share * (c[n + 1] - c[n]);
    }
  }
  return c[0];
}

double first_passage(const double* control, int degree, double level, bool up, double from) noexcept {
  if (degree < 0 || degree > largest_degree || !(from <= 1.0)) return no_passage;
  const auto n = static_cast<std::size_t>(degree);
  const Beyond beyond{up};
  Interval whole{0.0, 1.0, {}};
  double largest = std::abs(level);
  bool may = false;
  for (std::size_t i = 0; i <= n; ++i) {
    whole.q[i] = up ? control[i] - level : level - control[i];
    may = may || beyond(whole.q[i]);
    largest = std::max(largest, std::abs(control[i]));
  }
  if (!may) return no_passage;
  if (from > 0.0) {
    Controls before;
    split(Controls(whole.q).data(), degree, from, before.data(), whole.q.data());
    whole.begin = from;
  }
  if (beyond(whole.q[0])) return from;

  // Depth first, left before right: the right half of every bisected interval is stacked. Limits on the bisections of an
  // interval and of all. More: longer worst case; fewer: passages close together are missed (four touches take half of them).
  constexpr int deepest = 48;
  constexpr int most_halvings = 512;
  const double touch = 4.0 * std::numeric_limits<double>::epsilon() * largest;
  std::array<Interval, deepest + 1> waiting;
  std::array<int, deepest + 1> depth;
  int count = 1;
  waiting[0] = whole;
  depth[0] = 0;
  for (int halvings = 0; count > 0 && halvings < most_halvings;) {
    const Interval now = waiting[static_cast<std::size_t>(--count)];
    const int deep = depth[static_cast<std::size_t>(count)];
    if (beyond(now.q[0])) return now.begin;
    int changes = 0;
    double highest = now.q[0];
    for (std::size_t i = 1; i <= n; ++i) {
      changes += beyond(now.q[i]) != beyond(now.q[i - 1]);
      highest = std::max(highest, now.q[i]);
    }
    if (changes == 0) continue;
    if (changes == 1) return single_root(now, degree, beyond);
    if (deep == deepest || (highest <= touch && !beyond(now.q[n]))) {
      if (beyond(now.q[n])) return now.end;
      continue;
    }
    ++halvings;
    const double middle = 0.5 * (now.begin + now.end);
    Interval left{now.begin, middle, {}}, right{middle, now.end, {}};
    split(now.q.data(), degree, 0.5, left.q.data(), right.q.data());
    waiting[static_cast<std::size_t>(count)] = right;
    depth[static_cast<std::size_t>(count++)] = deep + 1;
    waiting[static_cast<std::size_t>(count)] = left;
    depth[static_cast<std::size_t>(count++)] = deep + 1;
  }
  return no_passage;
}

}  // namespace palpa
