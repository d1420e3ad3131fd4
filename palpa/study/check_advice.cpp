// Search for better settings by closed loops, and their check.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <utility>

#include "palpa/base/printed.h"
#include "palpa/study/check.h"
#include "palpa/study/feeler.h"
#include "palpa/study/released_device.h"

namespace palpa {
namespace {

using detail::text;

Scene with_coupling(Scene scene, double stiffness_n_per_m, double damping_ns_per_m) {
  scene.edit<CouplingOptions>([&](auto& coupling) {
    coupling.stiffness_n_per_m = stiffness_n_per_m;
    coupling.damping_ns_per_m = damping_ns_per_m;
  });
  return scene;
}

const CheckFinding* finding(const CheckReport& report, std::string_view key) {
  for (const CheckFinding& one : report.findings) {
    if (one.key == key) return &one;
  }
  return nullptr;
}
Grade grade_of(const CheckReport& report, std::string_view key) {
  const CheckFinding* const found = finding(report, key);
  return found ? found->grade : Grade::fine;
}

/// Whether the device rests at all places, released and in hands; released also with a fraction of its friction.
bool rests(const Scene& scene, const CheckReport& report) {
  constexpr Trial trials[] = {{Act::released},
                              {Act::lean},
                              {Act::hold, Hold::relaxed},
                              {Act::hold, Hold::firm},
                              {Act::released, Hold::relaxed, sure_friction},
                              {Act::lean, Hold::relaxed, sure_friction}};
  std::vector<char> moves(std::size(trials) * report.places.size());
  detail::in_parallel(detail::feeling_threads(), static_cast<int>(moves.size()), [&](std::size_t, int number) {
    const auto n = static_cast<std::size_t>(number);
    const TrialFigures figures =
        try_at(scene, report.plant, report.places[n / std::size(trials)], trials[n % std::size(trials)]);
    moves[n] = detail::grade_of_rest(figures) != Grade::fine;
  });
  return std::find(moves.begin(), moves.end(), char{1}) == moves.end();
}

/// Rounds down to two figures.
double rounded_down(double value) {
  if (!(value > 0.0)) return 0.0;
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::floor(value / unit + 1e-9) * unit;
}

/// Coupling at which the device rests; k is 0 if none was found.
CouplingOptions search(const Scene& scene, const CheckReport& report, const std::function<void(double)>& progress) {
  constexpr double least_n_per_m = 50.0, close_enough = 1.15;  // softer: shapes are lost
  const double asked = scene.coupling().stiffness_n_per_m;
  CouplingOptions best = scene.coupling();
  best.stiffness_n_per_m = 0.0;
  const double dampings[] = {scene.coupling().damping_ns_per_m, 0.5, 1.0};
  for (std::size_t n = 0; n < std::size(dampings); ++n) {
    const double damping = std::min(dampings[n], report.plant.limits.max_damping_ns_per_m);
    if (n > 0 && damping == dampings[0]) continue;
    const auto holds = [&](double k) { return rests(with_coupling(scene, k, damping), report); };
    double low = std::max(least_n_per_m, best.stiffness_n_per_m), high = asked;
    if (low < high && holds(low)) {
      if (holds(high)) low = high;
      while (high > close_enough * low) {
        const double middle = std::sqrt(low * high);
        (holds(middle) ? low : high) = middle;
      }
      // A different D must be worth it: it makes an encoder's steps rougher.
      constexpr double worth_it = 1.2;
      if (low > worth_it * best.stiffness_n_per_m) {
        best.stiffness_n_per_m = low;
        best.damping_ns_per_m = damping;
      }
    }
    if (progress) progress(static_cast<double>(n + 1) / static_cast<double>(std::size(dampings) + 1));
    if (best.stiffness_n_per_m >= asked) break;
  }
  return best;
}

}  // namespace

Scene changed(Scene scene, const std::vector<Change>& changes) {
  for (const Change& change : changes) {
    if (change.table != "coupling") continue;
    scene.edit<CouplingOptions>([&](auto& coupling) {
      if (change.key == "stiffness_n_per_m") coupling.stiffness_n_per_m = change.to;
      if (change.key == "damping_ns_per_m") coupling.damping_ns_per_m = change.to;
      if (change.key == "max_force_n") coupling.max_force_n = change.to;
    });
  }
  return scene;
}

namespace {

/// Checks the changes as a whole, and softens them until no finding is a stop; drops useless ones.
void follow(const Scene& scene, CheckReport& report, const std::function<void(double)>& progress) {
  constexpr int most_rounds = 4;
  constexpr double softer = 0.75;
  std::optional<CheckReport> best;
  std::vector<Change> changes = std::move(report.changes), best_changes;
  report.changes.clear();
  for (int round = 0; round < most_rounds && !changes.empty(); ++round) {
    CheckReport after = detail::judged(changed(scene, changes), report.plant, report.places, false, {});
    if (progress) progress(1.0);
    if (!best || detail::is_better(after, *best)) best = std::move(after), best_changes = changes;
    if (best->grade == Grade::fine || (best->grade < report.grade && round > 0)) break;
    for (Change& change : changes) {
      if (change.key != "damping_ns_per_m") change.to = rounded_down(softer * change.to);
    }
  }
  if (best && detail::is_better(*best, report)) {
    report.changes = std::move(best_changes);
    report.grade_after = best->grade;
    report.verdict_after = best->verdict;
  } else if (best) {
    report.advice.push_back("No better stiffness, damping or force limit was found.");
  }
}

/// Advice about the tool, whose turning radius is no key of the coupling.
void advise_turning(const Scene& scene, CheckReport& report) {
  const CouplingOptions& coupling = scene.coupling();
  if (const CheckFinding* const tips = finding(report, "tips"); tips && tips->grade != Grade::fine)
    report.advice.push_back(
        text("Against tipping over: tool.turning_radius_m of %.3g m or more, or coupling.max_force_n of at "
             "most %.3g N.",
             std::sqrt(tips->threshold / coupling.stiffness_n_per_m), coupling.max_force_n * tips->measured / tips->threshold));
  if (grade_of(report, "torque") != Grade::fine)
    report.advice.push_back(
        text("The tool asks for up to %.2g N·m, more than the limit of %g N·m: lower the strengths, or tool.turning_radius_m.",
             report.most_torque_nm, coupling.max_torque_nm));
}

}  // namespace

bool detail::is_better(const CheckReport& report, const CheckReport& than) noexcept {
  if (report.grade != than.grade) return report.grade < than.grade;
  const auto graves = [](const CheckReport& of) { return std::ranges::count(of.findings, of.grade, &CheckFinding::grade); };
  return report.grade != Grade::fine && graves(report) < graves(than);
}

void detail::advise(const Scene& scene, CheckReport& report, const std::function<void(double)>& progress) {
  report.grade_after = report.grade;
  if (report.places.empty()) return;
  const bool moves = std::ranges::any_of(std::initializer_list<std::string_view>{"let_go", "held", "margin"},
                                         [&](std::string_view key) { return grade_of(report, key) != Grade::fine; });
  const bool kicks = grade_of(report, "jump") == Grade::stop;
  CouplingOptions better = scene.coupling();
  if (moves) better = search(scene, report, progress);
  const auto set = [&](const char* key, double from, double to, const char* why) {
    if (from != to) report.changes.push_back({"coupling", key, from, to, why});
  };
  if (moves && better.stiffness_n_per_m > 0.0) {
    set("stiffness_n_per_m", scene.coupling().stiffness_n_per_m,
        better.stiffness_n_per_m < scene.coupling().stiffness_n_per_m ? rounded_down(better.stiffness_n_per_m)
                                                                      : scene.coupling().stiffness_n_per_m,
        "the largest stable stiffness, released and held");
    set("damping_ns_per_m", scene.coupling().damping_ns_per_m, better.damping_ns_per_m, "it makes a larger stiffness stable");
  } else if (moves) {
    report.advice.push_back(
        "No stiffness from 50 N/m on is stable: lower the strengths at the places named above, or require a dead-man button "
        "(--dead-man-button), so that there is force only while a hand holds the device.");
  }
  if (kicks) {
    const CheckFinding& jump = *finding(report, "jump");
    set("max_force_n", scene.coupling().max_force_n, rounded_down(scene.coupling().max_force_n * borne_jump_n / jump.measured),
        "the force step shrinks in proportion");
  }
  if (grade_of(report, "noise") != Grade::fine)
    report.advice.push_back(
        "Against noise: filter = \"smooth\" for that volume, with a larger smoothing, or a lower strength of the named mode.");
  if (grade_of(report, "saturation") != Grade::fine)
    report.advice.push_back(
        text("The named modes push with more than the limit of %g N together: lower their strengths until the sum is below it; "
             "a level that must not be pressed through needs a strength above it.",
             scene.coupling().max_force_n));
  advise_turning(scene, report);
  follow(scene, report, progress);
}

void detail::draw_map(const Scene& scene, CheckReport& report, const std::function<void(double)>& progress) {
  constexpr int columns = 14, rows = 9, curve = 16;
  constexpr double low_n_per_m = 50.0, high_n_per_m = 5000.0, most_damping = 4.0;
  report.curve.resize(curve);
  report.map.resize(report.places.empty() ? 0 : columns * rows);
  const auto count = static_cast<int>(report.map.size());
  in_parallel(
      feeling_threads(), count + curve,
      [&](std::size_t, int number) {
        const auto n = static_cast<std::size_t>(number);
        if (number >= count) {
          report.curve[n - report.map.size()] = stable_stiffness(report.plant, most_damping * (number - count) / (curve - 1));
          return;
        }
        MarginPoint& point = report.map[n];
        point.stiffness_n_per_m = low_n_per_m * std::pow(high_n_per_m / low_n_per_m, (number % columns) / (columns - 1.0));
        point.damping_ns_per_m = most_damping * (number / columns) / (rows - 1.0);
        const Scene tried = with_coupling(scene, point.stiffness_n_per_m, point.damping_ns_per_m);
        for (const CheckPlace& place : report.places) {
          for (const Act act : {Act::released, Act::lean})
            point.grade = std::max(point.grade, grade_of_rest(try_at(tried, report.plant, place, {act})));
        }
      },
      progress);
}

}  // namespace palpa
