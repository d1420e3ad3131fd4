// Formatting of a check's report.
#include <cmath>
#include <nlohmann/json.hpp>

#include "palpa/base/printed.h"
#include "palpa/study/check.h"

namespace palpa {
namespace {

using detail::text;
using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string newtons_per_m(double value) { return std::isfinite(value) ? text("%.0f N/m", value) : std::string("any"); }

Json json_of(const StableStiffness& stable) {
  return {{"damping_ns_per_m", stable.damping_ns_per_m},
          {"without_friction_n_per_m", stable.alone_n_per_m},
          {"with_friction_n_per_m", stable.friction_n_per_m},
          {"passive_bound_n_per_m", number(stable.bounds.passive_n_per_m)},
          {"encoder_bound_n_per_m", number(stable.bounds.encoder_n_per_m)},
          {"stable_bound_n_per_m", number(stable.bounds.stable_n_per_m)}};
}

double turn_stiffness_of(const CheckReport& report) {
  return report.coupling.stiffness_n_per_m * report.turning_radius_m * report.turning_radius_m;
}

}  // namespace

std::string to_table(const CheckReport& report) {
  std::string out = report.verdict + "\n\n  device     " + report.plant.name + ": " + format_plant(report.plant) + "\n";
  out += text("  coupling   k = %g N/m, D = %g N·s/m, at most %g N; the largest force was %.2f N\n",
              report.coupling.stiffness_n_per_m, report.coupling.damping_ns_per_m, report.coupling.max_force_n,
              report.most_force_n);
  if (report.turning_radius_m > 0.0)
    out += text("  turning    %.3g N·m/rad (turning radius %.3g m), at most %g N·m; the largest torque was %.3g N·m\n",
                turn_stiffness_of(report), report.turning_radius_m, report.coupling.max_torque_nm, report.most_torque_nm);
  const StableStiffness& stable = report.stable;
  out += text("  stable k   %.0f N/m without device friction at this D, %.0f N/m with it (closed loops on a wall)\n",
              stable.alone_n_per_m, stable.friction_n_per_m);
  out += "  bounds     " + newtons_per_m(stable.bounds.stable_n_per_m) + " by linear stability (Gil, Hulin), " +
         newtons_per_m(stable.bounds.passive_n_per_m) + " passive (Colgate), " + newtons_per_m(stable.bounds.encoder_n_per_m) +
         " with the encoder (Abbott and Okamura)\n";
  const bool ends_search = report.largest_damping_ns_per_m > 99.0;
  out += report.largest_damping_ns_per_m > 0.0 ? text("  stable D   up to %s%.3g N·s/m at this k, of the device alone\n",
                                                      ends_search ? "more than " : "", report.largest_damping_ns_per_m)
                                               : "  stable D   none at this k, of the device alone\n";
  for (const CheckPlace& place : report.places)
    out += text("  place      %-12s (%+.0f, %+.0f, %+.0f mm): %.2f N, changes direction by %.2f N in a millimetre\n",
                place.why.c_str(), 1e3 * place.front_m.x, 1e3 * place.front_m.y, 1e3 * place.front_m.z, place.force_n,
                place.turn_n);
  for (const CheckedOctaves& octaves : report.octaves)
    out += "  octaves    " + octaves.volume + ": " + words_of(octaves.expected) + "\n";
  out += "\n";
  for (const CheckFinding& finding : report.findings)
    out += text("  %-5s%-12s", name_of(finding.grade), finding.key.c_str()) + finding.words +
           (finding.where.empty() ? "" : "; " + finding.where) + "\n";
  if (!report.changes.empty() || !report.advice.empty()) out += "\n";
  for (const Change& change : report.changes)
    out += text("  change     %s.%s = %g (from %g): ", change.table.c_str(), change.key.c_str(), change.to, change.from) +
           change.why + "\n";
  if (!report.changes.empty())
    out += "  then       " + (report.verdict_after.empty() ? report.verdict : report.verdict_after) + "\n";
  for (const std::string& sentence : report.advice) out += "  advice     " + sentence + "\n";
  return out;
}

std::string to_json(const CheckReport& report) {
  Json places = Json::array(), findings = Json::array(), changes = Json::array(), modes = Json::array();
  for (const CheckPlace& place : report.places)
    places.push_back({{"why", place.why},
                      {"front_m", {place.front_m.x, place.front_m.y, place.front_m.z}},
                      {"force_n", place.force_n},
                      {"turn_n_per_mm", place.turn_n},
                      {"uneven_n_per_mm", place.uneven_n}});
  for (const CheckFinding& finding : report.findings)
    findings.push_back({{"key", finding.key},
                        {"grade", name_of(finding.grade)},
                        {"measured", number(finding.measured)},
                        {"threshold", number(finding.threshold)},
                        {"unit", finding.unit},
                        {"where", finding.where},
                        {"words", finding.words}});
  for (const Change& change : report.changes)
    changes.push_back(
        {{"path", change.table + "." + change.key}, {"from", change.from}, {"to", change.to}, {"why", change.why}});
  for (std::size_t m = 0; m < report.modes.size(); ++m)
    modes.push_back(
        {{"name", report.modes[m]}, {"injected_j", report.injected_j[m]}, {"dissipated_j", report.dissipated_j[m]}});
  Json json{{"verdict", name_of(report.grade)},
            {"reason", report.verdict},
            {"device", report.plant.name},
            {"delay_ticks", report.plant.delay_ticks},
            {"stiffness_n_per_m", report.coupling.stiffness_n_per_m},
            {"damping_ns_per_m", report.coupling.damping_ns_per_m},
            {"max_force_n", report.coupling.max_force_n},
            {"force_max_n", report.most_force_n},
            {"stable", json_of(report.stable)},
            {"largest_stable_damping_ns_per_m", report.largest_damping_ns_per_m},
            {"places", places},
            {"findings", findings},
            {"modes", modes},
            {"changes", changes},
            {"verdict_after_changes", name_of(report.grade_after)},
            {"reason_after_changes", report.verdict_after.empty() ? report.verdict : report.verdict_after},
            {"advice", report.advice}};
  for (const CheckedOctaves& octaves : report.octaves)
    json["felt_live"][octaves.volume] = Json::parse(to_json(octaves.expected));
  if (report.turning_radius_m > 0.0) {
    json["turn_stiffness_nm_per_rad"] = turn_stiffness_of(report);
    json["turning_radius_m"] = report.turning_radius_m;
    json["max_torque_nm"] = report.coupling.max_torque_nm;
    json["torque_max_nm"] = report.most_torque_nm;
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace palpa
