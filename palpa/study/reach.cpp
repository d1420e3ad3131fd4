#include "palpa/study/reach.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>

#include "palpa/base/printed.h"
#include "palpa/study/reach_lattice.h"

namespace palpa {

using namespace detail;

namespace {

/// The scene with few feet of its tool, which a search of places needs: the one that is first on the way from the user, then
/// each time the farthest from all before. Their strengths are together those of all, up to the whole of each.
Scene with_few_feet(Scene scene) {
  constexpr std::size_t most = 3;  // more: a slower start of runs; fewer: a tool hits with feet that the search leaves out
  const Tool tool(scene.tool(), scene.coupling());
  if (tool.feet() <= most) return scene;
  std::vector<Vec3> levers_m;
  for (std::size_t foot = 0; foot < tool.feet(); ++foot) levers_m.push_back(tool.lever_m({}, foot));
  std::vector<Vec3> chosen_m{*std::ranges::min_element(levers_m, {}, &Vec3::z)};
  const auto apart_m = [&](const Vec3& lever_m) {
    double least_m = std::numeric_limits<double>::infinity();
    for (const Vec3& one_m : chosen_m) least_m = std::min(least_m, distance(one_m, lever_m));
    return least_m;
  };
  while (chosen_m.size() < most) chosen_m.push_back(*std::ranges::max_element(levers_m, {}, apart_m));
  const double all = tool.share() * static_cast<double>(tool.feet());
  const ToolOptions few{.shape = ToolOptions::Shape::points,
                        .points_m = std::move(chosen_m),
                        .share = std::min(1.0, all / most),
                        .turning_radius_m = std::min(1.0, tool.turning_radius_m())};
  if (!problem_with(few)) scene.set(few);  // levers may be longer than points
  return scene;
}

}  // namespace

Reach::Reach(const Scene& scene, const std::function<void(double)>& progress) : scene_(with_few_feet(scene)) {
  auto lattice = std::make_shared<ReachLattice>();
  const auto sessions = feelers(scene_);
  in_parallel(
      sessions.size(), across * across,
      [&](std::size_t worker, int n) {
        const int i = n % across, j = n / across;
        int first_felt = -2, last_felt = -2;
        const auto note = [&](double way_m, double force_n, const Session& session) {
          const int k = std::min(along - 1, static_cast<int>(way_m / cell_z_m));
          if (force_n >= scene_.coupling().max_force_n) lattice->cells[ReachLattice::number(i, j, k)].beyond = true;
          if (k == last_felt) return;
          if (k != last_felt + 1) first_felt = k;
          last_felt = k;
          ReachLattice::Cell& cell = lattice->cells[ReachLattice::number(i, j, k)];
          cell.front = k <= first_felt + 1;
          for (std::size_t m = 0; m < session.modes().size(); ++m) {
            if (norm(session.modes()[m].force_n) > contact_force_n)
              cell.modes |= std::uint64_t{1} << std::min<std::size_t>(m, 63);
          }
        };
        lattice->ways.way[static_cast<std::size_t>(n)] =
            sessions[worker]->feel(ReachLattice::way_begin_m(i, j), {0, 0, -1}, along * cell_z_m, Feeler::Until::end, note);
      },
      progress);
  // A level may begin without any force, from the side that it lets in.
  is_empty_ = std::ranges::none_of(lattice->cells, [](const ReachLattice::Cell& cell) { return cell.modes != 0; });
  lattice->set_worth();
  lattice_ = std::move(lattice);
}

double Reach::felt_share(std::span<const Vec3> places_m) const noexcept {
  std::size_t felt = 0;
  for (const Vec3& place_m : places_m) {
    const auto cell = [](double m, double size_m) { return static_cast<int>(std::lround(std::clamp(m / size_m, -1e6, 1e6))); };
    const double before_lattice_m = half_m + before_m - place_m.z;
    felt += lattice_->felt(cell(place_m.x, cell_m) + across / 2, cell(place_m.y, cell_m) + across / 2,
                           cell(before_lattice_m - 0.5 * cell_z_m, cell_z_m));
  }
  return places_m.empty() ? 0.0 : static_cast<double>(felt) / static_cast<double>(places_m.size());
}

std::optional<Nearest> Reach::nearest(std::span<const Vec3> places_m) const {
  std::optional<Nearest> best;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < along; ++k)
    for (int j = 0; j < across; ++j)
      for (int i = 0; i < across; ++i) {
        if (!lattice_->felt(i, j, k)) continue;
        const Vec3 contact_m = ReachLattice::middle_m(i, j, k);
        for (const Vec3& place_m : places_m) {
          const double away = norm_squared(contact_m - place_m);
          if (!(away < least)) continue;
          least = away;
          best = Nearest{std::sqrt(away), contact_m - place_m};
        }
      }
  return best;
}

namespace {

/// Side, other than the user's, from which a hand on a straight path makes contact; null if none.
const char* side_to_feel_from(const Scene& scene) {
  constexpr std::pair<const char*, Vec3> sides[] = {
      {"the left", {1, 0, 0}}, {"the right", {-1, 0, 0}}, {"below", {0, 1, 0}}, {"above", {0, -1, 0}}, {"behind", {0, 0, 1}}};
  const auto sessions = feelers(scene);
  for (const auto& [side, direction] : sides) {
    const Vec3 right = std::abs(direction.x) > 0.5 ? Vec3{0, 1, 0} : Vec3{1, 0, 0}, up = cross(direction, right);
    std::atomic<bool> felt = false;
    in_parallel(sessions.size(), across * across, [&](std::size_t worker, int n) {
      const Vec3 from_m = (n % across - across / 2) * cell_m * right + (n / across - across / 2) * cell_m * up -
                          (half_m + before_m) * direction;
      if (!felt && sessions[worker]->feel(from_m, direction, along * cell_z_m, Feeler::Until::contact).onset_m) felt = true;
    });
    if (felt) return side;
  }
  return nullptr;
}

/// Reason why a scene has no contact at all, and a setting that was tested to change it.
std::string why_empty(const Scene& scene) {
  if (std::none_of(scene.modes().begin(), scene.modes().end(), [](const SceneMode& mode) { return mode.enabled; })) {
    return scene.modes().empty()
               ? "The scene has no mode: add a [[mode]]; palpa modes lists what there is."
               : "All modes are off: --set mode." + scene.modes().front().name + ".enabled=true turns one on.";
  }
  if (const char* const side = side_to_feel_from(scene)) {
    return std::string(
               "A hand that approaches straight from the user makes no contact within 9 cm of the middle of the workspace; "
               "from ") +
           side + " it does: turn the data by towards_user and up in [workspace], or guide the hand there.";
  }
  const std::string nowhere =
      "There is no contact within reach of the hand, 9 cm about the middle of the workspace, on straight paths from any of its "
      "six sides.";
  for (const SceneVolume& volume : scene.volumes()) {
    Scene whole = scene;
    whole.set(Workspace{.fit = volume.name});
    if (!Reach(whole).is_empty()) {
      return nowhere + " With all of '" + volume.name + "' in reach there is contact: write fit = \"" + volume.name +
             "\" into [workspace] instead of scale and center.";
    }
  }
  return nowhere + " Levels, strengths or masks may lie beyond the data's values: palpa run SCENE --dry-run prints these.";
}

}  // namespace

std::string format_nearest(const Nearest& nearest) {
  std::string words = detail::text("%.0f mm away", 1e3 * nearest.distance_m);
  const std::pair<double, std::pair<const char*, const char*>> axes[] = {
      {nearest.direction.x, {"to the right", "to the left"}},
      {nearest.direction.y, {"up", "down"}},
      {nearest.direction.z, {"towards the user", "away from the user"}}};
  bool first = true;
  for (const auto& [part_m, names] : axes) {
    if (std::abs(part_m) < 1e-3) continue;
    words +=
        detail::text("%s %.0f mm %s", first ? ":" : ",", 1e3 * std::abs(part_m), part_m > 0.0 ? names.first : names.second);
    first = false;
  }
  return words;
}

std::string explain_little_contact(const Reach& reach, std::span<const Vec3> places_m, const std::string& remedy) {
  if (reach.is_empty()) return why_empty(reach.scene());
  const auto nearest = reach.nearest(places_m);
  if (!nearest) return "The position of the hand is never known.";
  std::string words = "The nearest contact for a hand that approaches from the user is " + format_nearest(*nearest) + ".";
  if (!remedy.empty()) words += " " + remedy + " moves the hand to the position with the longest contact.";
  return words;
}

}  // namespace palpa
