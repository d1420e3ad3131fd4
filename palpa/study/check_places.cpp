#include "palpa/study/check_places.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "palpa/device/front.h"
#include "palpa/study/feeler.h"
#include "palpa/study/reach_lattice.h"

namespace palpa {
namespace {

using detail::before_m;
using detail::Feeler;
using detail::half_m;
using detail::way_step_m;

/// Forces along a path.
struct Felt {
  double force_n = 0.0, turn_n = 0.0, uneven_n = 0.0;
  Vec3 largest_n;
};

/// Against a force towards the user, else straight on.
Vec3 inwards_of(const Vec3& force_n) {
  constexpr double towards_user = 0.3;
  const Vec3 direction = norm(force_n) > 0.0 ? normalized(force_n) : Vec3{};
  return direction.z > towards_user ? -1.0 * direction : Vec3{0.0, 0.0, -1.0};
}

Vec3 force_of_modes_n(const Session& session) {
  Vec3 sum_n;
  for (const ModeForce& mode : session.modes()) sum_n += mode.force_n;
  return sum_n;
}

/// Records the force of all modes along a path.
class Follower {
 public:
  explicit Follower(const Scene& scene) : spring_n_(scene.coupling().stiffness_n_per_m * way_step_m) {}
  void at(double way_m, const Session& session) {
    const Vec3 force_n = force_of_modes_n(session);
    if (norm(force_n) > felt.force_n) {
      felt.force_n = norm(force_n);
      felt.largest_n = force_n;
    }
    if (last_m_ && way_m - *last_m_ < 1.5 * way_step_m) {
      const double change_n = norm(force_n - last_n_), growth_n = norm(force_n) - norm(last_n_);
      felt.turn_n = std::max(felt.turn_n, std::sqrt(std::max(0.0, change_n * change_n - growth_n * growth_n)));
      felt.uneven_n = std::max(felt.uneven_n, change_n - spring_n_);
    }
    last_m_ = way_m;
    last_n_ = force_n;
  }
  Felt felt;

 private:
  double spring_n_;
  std::optional<double> last_m_;
  Vec3 last_n_;
};

/// Place where the way from `begin_m` meets the data, all but its facing.
CheckPlace place_on(const detail::Way& way, const Felt& felt, const Vec3& begin_m, const char* why) {
  CheckPlace place{.why = why,
                   .front_m = begin_m - Vec3{0.0, 0.0, *way.onset_m},
                   .inwards = inwards_of(felt.largest_n),
                   .force_n = felt.force_n,
                   .turn_n = felt.turn_n,
                   .uneven_n = felt.uneven_n,
                   .met = {},
                   .deeper_n = way.half_force_n};
  place.met.before_m = before_m;
  place.met.depth_m = 0.5 * way.bears_m;
  place.met.radius_m = 0.02;
  return place;
}

}  // namespace

std::vector<CheckPlace> check_places(const Scene& given, double spacing_m, const std::function<void(double)>& progress) {
  Scene scene = given;
  scene.edit<CouplingOptions>([&](auto& coupling) { coupling.stiffness_n_per_m = sampling_stiffness_n_per_m; });
  const int side = 2 * static_cast<int>(std::lround(half_m / spacing_m)) + 1;
  const auto count = static_cast<std::size_t>(side * side);
  detail::Ways ways{side, side, false, std::vector<detail::Way>(count)};
  std::vector<Felt> felt(count);
  const auto begin_m = [&](std::size_t n) {
    const int i = static_cast<int>(n) % side, j = static_cast<int>(n) / side;
    return Vec3{(i - side / 2) * spacing_m, (j - side / 2) * spacing_m, half_m + before_m};
  };
  const auto threads = detail::feelers(scene);
  detail::in_parallel(
      threads.size(), static_cast<int>(count),
      [&](std::size_t worker, int number) {
        const auto n = static_cast<std::size_t>(number);
        Follower follower(scene);
        ways.way[n] = threads[worker]->feel(begin_m(n), {0.0, 0.0, -1.0}, 2.0 * half_m + before_m, Feeler::Until::end,
                                            [&](double way_m, double, const Session& session) { follower.at(way_m, session); });
        felt[n] = follower.felt;
      },
      progress);

  // Of equally good places the nearest to the centre; a random choice would change with a bit.
  constexpr double clearly = 1.02;
  std::vector<std::size_t> from_middle;
  for (std::size_t n = 0; n < count; ++n) {
    if (ways.way[n].onset_m) from_middle.push_back(n);
  }
  if (from_middle.empty()) return {};
  const auto aside_m = [&](std::size_t n) { return std::hypot(begin_m(n).x, begin_m(n).y); };
  std::stable_sort(from_middle.begin(), from_middle.end(),
                   [&](std::size_t a, std::size_t b) { return aside_m(a) < aside_m(b); });
  const auto most = [&](double Felt::*figure) {
    std::size_t found = from_middle.front();
    for (const std::size_t n : from_middle) {
      if (felt[n].*figure > clearly * felt[found].*figure) found = n;
    }
    return found;
  };
  const std::vector<double> fronts_m =
      detail::filled(ways, [&](const detail::Way& way) { return half_m + before_m - *way.onset_m; });
  std::vector<CheckPlace> places;
  std::vector<std::size_t> taken;
  const auto take = [&](const char* why, std::size_t n) {
    if (std::find(taken.begin(), taken.end(), n) != taken.end()) return;
    taken.push_back(n);
    const int i = static_cast<int>(n) % side, j = static_cast<int>(n) / side;
    CheckPlace place = place_on(ways.way[n], felt[n], begin_m(n), why);
    place.met.facing = relief_facing(place.front_m, Relief(fronts_m, side, side, false), i, j, spacing_m);
    places.push_back(std::move(place));
  };
  take("strongest", most(&Felt::force_n));
  take("most curved", most(&Felt::turn_n));
  take("most uneven", most(&Felt::uneven_n));
  take("middle", from_middle.front());
  return places;
}

}  // namespace palpa
