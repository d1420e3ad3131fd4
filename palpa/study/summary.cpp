#include "palpa/study/summary.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "palpa/base/printed.h"
#include "palpa/study/energy_table.h"

namespace palpa {
namespace {

using detail::text;

// [1] of a tick's largest injection: below, it counts as zero. Less: rounding counts as energy; more: energy is not reported.
constexpr double rounding = 1e-9;
// [s] Duration from which a force that no strength balances is a catch. Less: single ticks of a moving hand count; more: short
// catches are not reported.
constexpr double lasting_s = 0.02;

double share(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

std::string millijoules(double joules) { return text("%.3f mJ", 1e3 * joules + 0.0); }

/// Formats rows of cells, each column as wide as its widest cell: the first `left` columns flush left, the others flush right.
std::string aligned(const std::vector<std::vector<std::string>>& rows, std::size_t left) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string result;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string padding(widths[c] - row[c].size(), ' ');
      line += "  " + (c < left ? row[c] + padding : padding + row[c]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    result += line + '\n';
  }
  return result;
}

std::vector<ModeSummary> modes_of(const Scene& scene) {
  std::vector<ModeSummary> modes;
  for (const SceneMode& mode : scene.modes()) {
    ModeSummary& summary = modes.emplace_back();
    summary.name = mode.name;
    summary.type = mode.mode.type();
  }
  return modes;
}

}  // namespace

namespace {

void add(const Energy& tick, Energy& sum) noexcept {
  sum.stored_j = tick.stored_j;
  sum.elastic_j = tick.elastic_j;
  sum.dissipated_j += tick.dissipated_j;
  sum.injected_j += tick.injected_j;
  sum.path_and_release_j += tick.path_and_release_j;
  sum.damper_j += tick.damper_j;
  sum.data_motion_j += tick.data_motion_j;
  sum.released_j += tick.released_j;
  sum.sampling_j += tick.sampling_j;
  sum.sampling_bound_j += tick.sampling_bound_j;
}

void add(const SessionEvent& event, double t_s, Summary& summary) noexcept {
  const auto m = static_cast<std::size_t>(event.mode);
  const bool of_mode = event.mode >= 0 && m < summary.modes.size();
  if (event.kind == SessionEventKind::fault) ++summary.faults;
  if (event.kind == SessionEventKind::onset && of_mode) ++summary.modes[m].onsets;
  if (event.kind == SessionEventKind::break_through) {
    if (of_mode) ++summary.modes[m].break_throughs;
    if (summary.first_break_through_s < 0.0) summary.first_break_through_s = t_s;
  }
}

}  // namespace

SummaryBuilder::SummaryBuilder(const Scene& scene) : SummaryBuilder(modes_of(scene), spacing_of_octaves_m(scene)) {}

SummaryBuilder::SummaryBuilder(std::vector<ModeSummary> modes, double octave_spacing_m) : octaves_(octave_spacing_m) {
  summary_.modes = std::move(modes);
  mode_force_sum_n_.resize(summary_.modes.size());
  mode_contact_ticks_.resize(summary_.modes.size());
}

void SummaryBuilder::add(const TickFrame& frame, std::span<const ModeForce> modes,
                         std::span<const SessionEvent> events) noexcept {
  const Tick& tick = frame.result;
  ++summary_.ticks;
  summary_.duration_s += frame.dt_s;

  tick_times_.add(frame.tick_us);
  octaves_.add(tick.felt_octave, tick.forced_octave, tick.proxy_m);

  bool contact = false;
  for (std::size_t m = 0; m < std::min(modes.size(), summary_.modes.size()); ++m) {
    ModeSummary& mode = summary_.modes[m];
    const double force_n = norm(modes[m].force_n);
    mode.force_max_n = std::max(mode.force_max_n, force_n);
    mode.dissipated_j += modes[m].dissipated_j;
    mode.injected_j += modes[m].injected_j;
    if (force_n > contact_force_n) {
      contact = true;
      ++mode_contact_ticks_[m];
      mode_force_sum_n_[m] += force_n;
    }
  }
  const double command_n = norm(frame.command.force_n);
  summary_.force_max_n = std::max(summary_.force_max_n, command_n);
  summary_.asked_force_max_n = std::max(summary_.asked_force_max_n, norm(tick.force_n));
  if (contact) {
    ++contact_ticks_;
    force_sum_n_ += command_n;
  }

  sub_steps_ += tick.sub_steps;
  summary_.sub_steps_max = std::max(summary_.sub_steps_max, tick.sub_steps);
  summary_.waiting_ticks += tick.status == TickStatus::waiting;
  summary_.capped_ticks += tick.status == TickStatus::capped;
  summary_.bad_input_ticks += tick.status == TickStatus::bad_input;
  summary_.invalid_probe_ticks += !tick.probe_valid;
  summary_.unborne_ticks += tick.unborne_n > unborne_felt_n;
  summary_.unborne_max_n = std::max(summary_.unborne_max_n, tick.unborne_n);
  if (tick.status != TickStatus::waiting) unborne_s_ = tick.unborne_n > unborne_felt_n ? unborne_s_ + frame.dt_s : 0.0;
  if (unborne_s_ >= lasting_s) summary_.unborne_lasting_n = std::max(summary_.unborne_lasting_n, tick.unborne_n);
  summary_.error_bound_max_m = std::max(summary_.error_bound_max_m, tick.error_bound_m);
  summary_.dropped_primitives += tick.dropped;
  summary_.guard_limited_ticks += frame.command.guard == GuardState::limited;
  summary_.faults += frame.command.guard == GuardState::fault;

  summary_.work_on_hand_j += frame.command.work_on_hand_j;
  summary_.withheld_j += frame.command.withheld_j;
  summary_.unfelt_j += frame.command.unfelt_j;
  palpa::add(tick.energy, summary_.energy);
  const bool known = tick.probe_valid && tick.status != TickStatus::bad_input;
  if (known && last_probe_m_ && tick.energy.sampling_j > rounding * tick.energy.sampling_bound_j) {
    summary_.sampling_gained_j += tick.energy.sampling_j;
    summary_.gaining_m2_per_s += norm_squared(tick.probe_m - *last_probe_m_) / frame.dt_s;
  }
  last_probe_m_ = known ? std::optional(tick.probe_m) : std::nullopt;

  for (const SessionEvent& event : events) palpa::add(event, frame.t_s, summary_);
}

Summary SummaryBuilder::finish(double wall_s) const {
  Summary summary = summary_;
  summary.wall_s = wall_s;
  summary.ticks_per_s = wall_s > 0.0 ? static_cast<double>(summary.ticks) / wall_s : 0.0;
  summary.tick_p50_us = tick_times_.percentile_us(0.50);
  summary.tick_p99_us = tick_times_.percentile_us(0.99);
  summary.tick_max_us = tick_times_.max_us();
  if (!octaves_.empty()) summary.octaves = octaves_.finish();
  summary.contact_share = share(contact_ticks_, summary.ticks);
  summary.force_mean_n = contact_ticks_ > 0 ? force_sum_n_ / static_cast<double>(contact_ticks_) : 0.0;
  summary.sub_steps_mean = share(sub_steps_, summary.ticks);
  for (std::size_t m = 0; m < summary.modes.size(); ++m) {
    const std::int64_t ticks = mode_contact_ticks_[m];
    summary.modes[m].contact_share = share(ticks, summary.ticks);
    summary.modes[m].force_mean_n = ticks > 0 ? mode_force_sum_n_[m] / static_cast<double>(ticks) : 0.0;
  }
  return summary;
}

/// Formats a loop's timing.
static std::string table_of(const LoopStatistics& loop) {
  const auto us = [](double time_us) { return text("%.1f us", time_us); };
  std::vector<std::vector<std::string>> rows{{"loop", "mean", "p50", "p99", "p99.9", "max"}};
  const auto add = [&](const char* what, const LoopStatistics::Times& t) {
    rows.push_back({what, us(t.mean_us), us(t.p50_us), us(t.p99_us), us(t.p999_us), us(t.max_us)});
  };
  add("start of tick, late by", loop.late);
  add("tick period", loop.period);
  add("processor time", loop.tick);
  std::string result = aligned(rows, 1);
  const auto count = [](std::int64_t number) { return detail::grouped(std::to_string(number)); };
  result += "  missed " + count(loop.missed) + " of " + count(loop.ticks + loop.missed) + " ticks";
  if (loop.scenes > 0) result += ", the scene changed " + count(loop.scenes) + " times";
  if (loop.unrecorded > 0) result += ", " + count(loop.unrecorded) + " ticks were not recorded";
  result += '\n';
  if (loop.windows.made > 0)
    result += "  " + count(loop.windows.made) + text(" windows made in %.1f s, ", loop.windows.busy_s) +
              count(loop.windows.lost) + " not\n";
  std::string costs;
  for (const LoopStatistics::ModeCost& mode : loop.modes)
    costs += (costs.empty() ? "  modes, time per tick: " : ", ") + mode.name + " " + us(mode.mean_us);
  return costs.empty() ? result : result + costs + '\n';
}

std::string to_table(const Summary& s) {
  const auto percent = [](double part) { return text("%.1f %%", 100.0 * part); };
  const auto newtons = [](double force_n) { return text("%.3f N", force_n); };
  const auto count = [](std::int64_t number) { return detail::grouped(std::to_string(number)); };
  const std::string cut = s.guard_limited_ticks > 0 ? text(" (requested %.3f N; the guard limited ", s.asked_force_max_n) +
                                                          count(s.guard_limited_ticks) + " ticks)"
                                                    : "";

  std::vector<std::vector<std::string>> rows{
      {"ticks", count(s.ticks) + text(" (%.3f s of hand motion)", s.duration_s)},
      {"speed", detail::grouped(text("%.0f", s.ticks_per_s)) + " ticks/s"},
      {"tick time", text("p50 %.1f us, p99 %.1f us, max %.1f us%s", s.tick_p50_us, s.tick_p99_us, s.tick_max_us,
                         s.loop ? "" : " (not in real time: a long tick was interrupted by other programs)")},
      {"sub-steps", text("mean %.2f, max %d per tick", s.sub_steps_mean, s.sub_steps_max)},
      {"largest error bound", text("%.2g m", s.error_bound_max_m)},
      {"in contact", percent(s.contact_share) + " of the ticks"},
      {"force on the hand", text("mean in contact %.3f N, max %.3f N", s.force_mean_n, s.force_max_n) + cut},
      {"first break-through", s.first_break_through_s < 0.0 ? "none" : text("at %.3f s", s.first_break_through_s)},
  };
  if (s.octaves)
    rows.push_back({"felt octave", percent(s.octaves->finest_share) + " of the ticks at the finest, " +
                                       percent(s.octaves->as_fine_as_way_share) + " as fine as the way of a tick; " +
                                       count(s.octaves->forced_ticks) + " raised at once"});
  // Failures are listed only if there were any.
  const auto say = [&](const char* name, std::int64_t number, const char* what) {
    if (number > 0) rows.push_back({name, count(number) + what});
  };
  const auto say_ticks = [&](const char* name, std::int64_t number, const std::string& what) {
    say(name, number, ((number == 1 ? " tick" : " ticks") + what).c_str());
  };
  say_ticks("waiting", s.waiting_ticks, " in which the work budget ran out before the proxy converged");
  say_ticks("off balance", s.unborne_ticks,
            text(" in which no strength balanced up to %.2f N of the force: a fault of the proxy's path", s.unborne_max_n));
  say_ticks("capped", s.capped_ticks, " with an error bound above 1e-9 m");
  say_ticks("bad input", s.bad_input_ticks, "");
  say_ticks("probe not valid", s.invalid_probe_ticks, "");
  say("faults", s.faults, "");
  say("refused primitives", s.dropped_primitives, "");
  std::string result = aligned(rows, 2);

  std::vector<std::vector<std::string>> modes{
      {"mode", "type", "in contact", "mean on proxy", "max on proxy", "dissipated", "injected", "onsets", "break-throughs"}};
  for (const ModeSummary& m : s.modes) {
    modes.push_back({m.name, m.type, percent(m.contact_share), newtons(m.force_mean_n), newtons(m.force_max_n),
                     millijoules(m.dissipated_j), millijoules(m.injected_j), count(m.onsets), count(m.break_throughs)});
  }
  result += '\n' + aligned(modes, 2) + '\n';

  result += to_table(energy_table(s));
  if (s.loop) result += '\n' + table_of(*s.loop);
  for (const std::string& note : s.notes) result += "\n" + note + "\n";
  return result;
}

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const LoopStatistics& loop) {
  const auto times = [](const LoopStatistics::Times& t) {
    return Json{
        {"mean_us", t.mean_us}, {"p50_us", t.p50_us}, {"p99_us", t.p99_us}, {"p999_us", t.p999_us}, {"max_us", t.max_us}};
  };
  Json costs = Json::array();
  for (const LoopStatistics::ModeCost& mode : loop.modes) costs.push_back({{"name", mode.name}, {"mean_us", mode.mean_us}});
  return {{"ticks", loop.ticks},
          {"missed", loop.missed},
          {"unrecorded", loop.unrecorded},
          {"scenes", loop.scenes},
          {"late", times(loop.late)},
          {"period", times(loop.period)},
          {"processor", times(loop.tick)},
          {"modes", costs},
          {"windows", {{"made", loop.windows.made}, {"lost", loop.windows.lost}, {"busy_s", loop.windows.busy_s}}}};
}

}  // namespace

std::string to_json(const Summary& s) {
  Json modes = Json::array();
  for (const ModeSummary& m : s.modes) {
    modes.push_back({{"name", m.name},
                     {"type", m.type},
                     {"contact_share", m.contact_share},
                     {"force_mean_n", m.force_mean_n},
                     {"force_max_n", m.force_max_n},
                     {"dissipated_j", m.dissipated_j},
                     {"injected_j", m.injected_j},
                     {"onsets", m.onsets},
                     {"break_throughs", m.break_throughs}});
  }
  const EnergyTable energy = energy_table(s);
  Json json{
      {"ticks", s.ticks},
      {"duration_s", s.duration_s},
      {"wall_s", s.wall_s},
      {"ticks_per_s", s.ticks_per_s},
      {"tick_p50_us", s.tick_p50_us},
      {"tick_p99_us", s.tick_p99_us},
      {"tick_max_us", s.tick_max_us},
      {"sub_steps_mean", s.sub_steps_mean},
      {"sub_steps_max", s.sub_steps_max},
      {"error_bound_max_m", s.error_bound_max_m},
      {"contact_share", s.contact_share},
      {"force_mean_n", s.force_mean_n},
      {"force_max_n", s.force_max_n},
      {"asked_force_max_n", s.asked_force_max_n},
      {"first_break_through_s", s.first_break_through_s < 0.0 ? Json(nullptr) : Json(s.first_break_through_s)},
      {"waiting_ticks", s.waiting_ticks},
      {"unborne_ticks", s.unborne_ticks},
      {"unborne_max_n", s.unborne_max_n},
      {"capped_ticks", s.capped_ticks},
      {"bad_input_ticks", s.bad_input_ticks},
      {"invalid_probe_ticks", s.invalid_probe_ticks},
      {"guard_limited_ticks", s.guard_limited_ticks},
      {"faults", s.faults},
      {"dropped_primitives", s.dropped_primitives},
      {"energy_j", Json::parse(to_json(energy))},
      {"ticks_gained_j", energy.sampling_gained_j},
      {"ticks_bound_j", energy.sampling_bound_j},
      {"covering_damping_ns_per_m", energy.covering_damping_ns_per_m},
      {"modes", modes},
      {"notes", s.notes},
  };
  if (s.octaves)
    json["felt_octaves"] = {{"finest_share", s.octaves->finest_share},
                            {"as_fine_as_way_share", s.octaves->as_fine_as_way_share},
                            {"mean", s.octaves->mean},
                            {"forced_ticks", s.octaves->forced_ticks}};
  if (s.loop) json["loop"] = json_of(*s.loop);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace palpa
