#include "palpa/study/check_judge.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpa/base/printed.h"
#include "palpa/study/summary.h"

namespace palpa {
namespace {

using detail::text;
using detail::TrialMade;

/// Trial with the largest figure among these acts, with this share of the device's friction.
template <class Figure>
const TrialMade* worst_of(const std::vector<TrialMade>& all, std::initializer_list<Act> acts, const Figure& figure,
                          double friction = 1.0) {
  const TrialMade* worst = nullptr;
  for (const TrialMade& made : all) {
    if (made.trial.friction != friction || std::find(acts.begin(), acts.end(), made.trial.act) == acts.end()) continue;
    if (!worst || figure(made.figures) > figure(worst->figures)) worst = &made;
  }
  return worst;
}

std::string where_of(const TrialMade& made, const CheckPlace& place) {
  return format_trial(made.trial) + " at the " + place.why +
         text(" place (%+.0f, %+.0f, %+.0f mm)", 1e3 * place.front_m.x, 1e3 * place.front_m.y, 1e3 * place.front_m.z);
}

const char* format_unrest(const TrialFigures& figures) {
  if (figures.thrown_off) return "is thrown off its place";
  return detail::grade_of_rest(figures) == Grade::stop ? "shakes" : "hums";
}

class Judge {
 public:
  Judge(const Scene& scene, CheckReport& report, const std::vector<TrialMade>& all)
      : scene_(scene), report_(report), all_(all) {}

  void rest(const char* key, std::initializer_list<Act> acts) {
    const TrialMade* worst = worst_of(all_, acts, [](const TrialFigures& f) { return f.hum_m_per_s2; });
    if (!worst) return;
    const TrialFigures& figures = worst->figures;
    const Grade grade = detail::grade_of_rest(figures);
    add({.key = key,
         .grade = grade,
         .measured = figures.hum_m_per_s2,
         .threshold = grade == Grade::stop ? borne_acceleration_m_per_s2 : felt_acceleration_m_per_s2,
         .unit = "m/s^2",
         .words = grade == Grade::fine
                      ? std::string("stable")
                      : std::string(format_unrest(figures)) + text(" by %.0f mN, which accelerate the device by %.2g m/s^2",
                                                                   1e3 * figures.rest_n, figures.hum_m_per_s2)},
        worst);
  }

  /// Tests for rest at much less than the device's assumed friction.
  void margin() {
    const TrialMade* worst = worst_of(
        all_, {Act::released, Act::lean}, [](const TrialFigures& f) { return f.hum_m_per_s2; }, sure_friction);
    if (!worst) return;
    const double k = report_.coupling.stiffness_n_per_m, hum = worst->figures.hum_m_per_s2;
    const bool rests = detail::grade_of_rest(worst->figures) == Grade::fine;
    const double share_percent = 100.0 * sure_friction;
    add({.key = "margin",
         .grade = rests ? Grade::fine : Grade::warn,
         .measured = hum,
         .threshold = felt_acceleration_m_per_s2,
         .unit = "m/s^2",
         .words = rests ? text("at k = %g N/m stable also with %g %% of the device's friction", k, share_percent)
                        : text("at k = %g N/m stable only thanks to the assumed device friction: with %g %% of it the device "
                               "%s by %.2g m/s^2",
                               k, share_percent, format_unrest(worst->figures), hum)},
        worst);
  }

  void jump() {
    const TrialMade* worst = worst_of(all_, moving, [](const TrialFigures& f) { return f.jump_n; });
    if (!worst) return;
    const TrialFigures& figures = worst->figures;
    add({.key = "jump",
         .grade = figures.jump_n > borne_jump_n ? Grade::stop : Grade::fine,
         .measured = figures.jump_n,
         .threshold = borne_jump_n,
         .unit = "N",
         .words = figures.jump_n > 0.0
                      ? text("the force steps by %.2g N within one tick (%s)", figures.jump_n, name_of(figures.jump_cause))
                      : text("no perceptible step of the force")},
        worst);
  }
  void noise() {
    const TrialMade* worst = worst_of(all_, moving, [](const TrialFigures& f) { return f.unexplained_jumps / f.duration_s; });
    if (!worst) return;
    const double per_s = worst->figures.unexplained_jumps / worst->figures.duration_s;
    const std::string whose = worst->figures.jump_mode.empty() ? "" : " by '" + worst->figures.jump_mode + "'";
    add({.key = "noise",
         .grade = worst->figures.unexplained_jumps > 0 ? Grade::warn : Grade::fine,
         .measured = per_s,
         .threshold = 0.0,
         .unit = "1/s",
         .words = worst->figures.unexplained_jumps > 0
                      ? text("%.1f unexplained force steps a second above %.0f mN%s: strength or "
                             "direction varies faster than the proxy moves",
                             per_s, 1e3 * felt_step_n, whose.c_str())
                      : text("no unexplained force steps above %.0f mN", 1e3 * felt_step_n)},
        worst);
  }
  void ripple() {
    const TrialMade* worst = worst_of(all_, {Act::stroke}, [](const TrialFigures& f) { return f.rough_n; });
    if (!worst) return;
    const double measured = worst->figures.rough_n / report_.plant.mass_kg;
    add({.key = "ripple",
         .grade = measured > felt_acceleration_m_per_s2 ? Grade::warn : Grade::fine,
         .measured = measured,
         .threshold = felt_acceleration_m_per_s2,
         .unit = "m/s^2",
         .words = text("%.2g mN between 100 and 500 Hz in a stroke", 1e3 * worst->figures.rough_n)},
        worst);
  }
  void saturation() {
    constexpr double seldom = 0.01;
    const TrialMade* worst =
        worst_of(all_, {Act::hold, Act::stroke, Act::press}, [](const TrialFigures& f) { return f.overfull; });
    if (!worst) return;
    const TrialFigures& figures = worst->figures;
    std::string pushing;
    for (std::size_t m = 0; m < figures.pushed_n.size(); ++m) {
      if (figures.pushed_n[m] > 0.0)
        pushing += (pushing.empty() ? " by '" : ", '") + report_.modes[m] + text("' (%.2g N)", figures.pushed_n[m]);
    }
    add({.key = "saturation",
         .grade = figures.overfull > seldom ? Grade::warn : Grade::fine,
         .measured = figures.overfull,
         .threshold = seldom,
         .unit = "1",
         .words = figures.overfull > seldom
                      ? text("the force is at its limit, %g N, in %.0f %% of the ticks, pushed", scene_.coupling().max_force_n,
                             100.0 * figures.overfull) +
                            pushing
                      : text("the force is below its limit, %g N, except on stronger levels", scene_.coupling().max_force_n)},
        worst);
  }
  void torque() {
    constexpr double seldom = 0.01;
    const TrialMade* worst = worst_of(all_, everything, [](const TrialFigures& f) { return f.over_torque; });
    if (!worst || report_.turning_radius_m == 0.0) return;
    const double limit_nm = scene_.coupling().max_torque_nm, measured = worst->figures.over_torque;
    const bool drives = report_.plant.limits.max_torque_nm > 0.0;
    add({.key = "torque",
         .grade = drives && measured > seldom ? Grade::warn : Grade::fine,
         .measured = measured,
         .threshold = drives ? seldom : INFINITY,
         .unit = "1",
         .words = !drives
                      ? text("the device drives no torque: up to %.2g N·m of the tool are not felt, and turning it brings in "
                             "their work",
                             report_.most_torque_nm)
                  : measured > seldom
                      ? text("the torque is at its limit, %g N·m, in %.0f %% of the ticks", limit_nm, 100.0 * measured)
                      : text("the torque is below its limit, %g N·m", limit_nm)},
        worst);
  }
  /// A tool pressed along a lever b by a force F tips over from Fb > κ on; half of that leaves its moves a steady end.
  void tips() {
    if (report_.turning_radius_m == 0.0) return;
    const CouplingOptions& coupling = scene_.coupling();
    const double kappa = coupling.stiffness_n_per_m * report_.turning_radius_m * report_.turning_radius_m;
    const double least = 2.0 * coupling.max_force_n * report_.reach_m;
    const bool stands = kappa >= least * (1.0 - 1e-9);
    add({.key = "tips",
         .grade = stands ? Grade::fine : Grade::warn,
         .measured = kappa,
         .threshold = least,
         .unit = "N*m/rad",
         .words = text(stands ? "turning has %.3g N·m/rad, enough for a tool pressed along its lever (%.3g)"
                              : "a tool pressed along its lever tips over: turning has %.3g N·m/rad, less than twice the force "
                                "limit times the longest lever, %.3g",
                       kappa, least)},
        nullptr);
  }
  void budget() {
    constexpr double seldom = 1e-3;  // a proxy that lags for a tick pulls a tick later
    const TrialMade* worst = worst_of(all_, everything, [](const TrialFigures& f) { return f.over_budget; });
    if (!worst) return;
    add({.key = "over_budget",
         .grade = worst->figures.over_budget > seldom ? Grade::warn : Grade::fine,
         .measured = worst->figures.over_budget,
         .threshold = seldom,
         .unit = "1",
         .words = text("the solver ran out of its work budget in %.2g %% of the ticks", 100.0 * worst->figures.over_budget)},
        worst);
  }
  void unborne() {
    const TrialMade* worst = worst_of(all_, everything, [](const TrialFigures& f) { return f.unborne_n; });
    if (!worst) return;
    const double measured_n = worst->figures.unborne_n;
    const bool is_borne = measured_n <= unborne_felt_n;
    add({.key = "unborne",
         .grade = is_borne ? Grade::fine : Grade::stop,
         .measured = measured_n,
         .threshold = unborne_felt_n,
         .unit = "N",
         .words = is_borne ? "strengths balance the whole force"
                           : text("no strength balances %.2g N of the force: a fault of the proxy's path", measured_n)},
        worst);
  }
  void energy() {
    for (std::size_t m = 0; m < scene_.modes().size(); ++m) {
      const SceneMode& mode = scene_.modes()[m];
      if (!mode.enabled) continue;
      // A spring returns its energy; only the net is injected.
      const auto net_j = [m](const TrialFigures& f) { return f.injected_j[m] - f.dissipated_j[m]; };
      const TrialMade* worst = worst_of(all_, everything, net_j);
      const double injected_j = worst ? std::max(0.0, net_j(worst->figures)) : 0.0;
      // The push of wind, gradients and vortex cores is legitimate: their energy is the data's.
      const bool may = drives(mode.mode.type());
      add({.key = "energy",
           .grade = !may && injected_j > borne_energy_j ? Grade::warn : Grade::fine,
           .measured = injected_j,
           .threshold = may ? INFINITY : borne_energy_j,
           .unit = "J",
           .words = "mode '" + mode.name + text("' adds at most %.2g mJ", 1e3 * injected_j)},
          worst);
    }
  }

 private:
  static constexpr std::initializer_list<Act> moving = {Act::hold, Act::stroke, Act::press};
  static constexpr std::initializer_list<Act> everything = {Act::released, Act::lean, Act::hold, Act::stroke, Act::press};
  void add(CheckFinding finding, const TrialMade* made) {
    if (made) finding.where = where_of(*made, report_.places[made->place]);
    report_.findings.push_back(std::move(finding));
  }
  const Scene& scene_;
  CheckReport& report_;
  const std::vector<TrialMade>& all_;
};

void conclude(CheckReport& report) {
  std::stable_sort(report.findings.begin(), report.findings.end(),
                   [](const CheckFinding& a, const CheckFinding& b) { return a.grade > b.grade; });
  if (report.findings.empty()) {
    report.verdict = "no contact within reach of the hand";
    return;
  }
  const CheckFinding& gravest = report.findings.front();
  report.grade = gravest.grade;
  report.verdict = report.grade == Grade::fine
                       ? "fine on " + report.plant.name + ": stable when released and when held, also with half of its friction"
                       : std::string(name_of(report.grade)) + " on " + report.plant.name + ": " + gravest.words +
                             (gravest.where.empty() ? "" : ", " + gravest.where);
}

}  // namespace

const char* name_of(Grade grade) noexcept {
  switch (grade) {
    case Grade::fine: return "fine";
    case Grade::warn: return "warn";
    case Grade::stop: return "stop";
  }
  return "";
}

Grade detail::grade_of_rest(const TrialFigures& figures) noexcept {
  if (figures.hum_m_per_s2 > borne_acceleration_m_per_s2) return Grade::stop;
  return figures.hum_m_per_s2 > felt_acceleration_m_per_s2 ? Grade::warn : Grade::fine;
}

void detail::judge(const Scene& scene, const std::vector<TrialMade>& all, CheckReport& report) {
  Judge judge(scene, report, all);
  if (!all.empty()) {
    judge.rest("let_go", {Act::released, Act::lean});
    judge.rest("held", {Act::hold});
    judge.jump();
    judge.noise();
    judge.ripple();
    judge.saturation();
    judge.torque();
    judge.tips();
    judge.budget();
    judge.unborne();
    judge.energy();
    judge.margin();
  }
  conclude(report);
}

}  // namespace palpa
