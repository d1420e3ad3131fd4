#include "palpa/report/words.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "palpa/report/html.h"
#include "palpa/study/reach.h"
#include "palpa/trace/csv.h"

namespace palpa::detail {
namespace {

std::string percent(double share) {
  if (share <= 0.0) return "0 %";
  return share < 0.001 ? "less than 0.1 %" : text("%.1f %%", 100.0 * share);
}

std::string newtons(double force_n) { return force_n < 0.1 ? text("%.0f mN", 1e3 * force_n) : text("%.2f N", force_n); }

std::string newton_metres(double torque_nm) {
  return torque_nm < 1.0 ? text("%.3g mN\u00b7m", 1e3 * torque_nm) : text("%.2f N\u00b7m", torque_nm);
}

std::string millijoules(double energy_j) { return text("%.2f mJ", 1e3 * energy_j + 0.0); }

std::string counted(long long number, const char* one, const char* many) {
  return number == 1 ? std::string("one ") + one : grouped(number) + " " + many;
}

std::string times(long long number) { return number == 1 ? "once" : number == 2 ? "twice" : grouped(number) + " times"; }

std::string first_of(const Recorded& recorded, const char* kind, const char* what) {
  const auto found = std::find_if(recorded.events.begin(), recorded.events.end(),
                                  [&](const RecordedEvent& event) { return event.kind == kind; });
  if (found == recorded.events.end()) return {};
  return text("The first %s came at %.3f s: ", what, found->t_s) + level_of(recorded, *found) + ".";
}

/// Sentence on the torques of a tool.
std::string format_torque(const Recorded& recorded) {
  const LargestTorques most = largest_torques(recorded);
  if (most.coupling_nm == 0.0 && most.on_hand_nm == 0.0) return "There was no torque.";
  if (most.on_hand_nm == 0.0)
    return "The torque of the coupling was at most " + newton_metres(most.coupling_nm) + text(", at %.3f s; ", most.at_s) +
           "the device drives no torque, so the hand felt the force alone.";
  const bool is_cut = newton_metres(most.coupling_nm) != newton_metres(most.on_hand_nm);
  return "Beside the force there was a torque on the hand of at most " + newton_metres(most.on_hand_nm) +
         text(", at %.3f s", most.at_s) +
         (is_cut ? ", of " + newton_metres(most.coupling_nm) + " that the coupling gave before the guard." : ".");
}

/// Sentence of a warning.
std::string sentence_of(const RecordedEvent& event) {
  std::string words = event.value.empty() ? event.subject : event.value;
  if (!words.empty() && words.back() != '.') words += '.';
  return words;
}

}  // namespace

std::string subtitle_of(const Recorded& recorded) {
  const TraceHeader& header = recorded.header;
  std::string hand = std::filesystem::path(header.hand).filename().string();
  for (std::size_t i = 0; i + 1 < header.arguments.size() && !is_one_of_several(header); ++i) {
    if (header.arguments[i] == "--hand") hand = std::filesystem::path(header.arguments[i + 1]).filename().string();
  }
  return "Report of a trace" + text(" of %.3g s", recorded.summary.duration_s) +
         (hand.empty() ? "" : " under the hand " + hand) + ", recorded by palpa " + header.palpa_version + ".";
}

std::string explain_little_contact(const Recorded& recorded, const Scene* scene) {
  const double share = recorded.summary.contact_share;
  if (recorded.ticks.empty() || share >= little_contact) return {};
  std::string warned;
  for (const RecordedEvent& event : recorded.events) {
    if (event.kind == "warning") warned += " " + sentence_of(event);
  }
  // A complete run has recorded this note.
  for (const std::string& note : recorded.header.notes) {
    if (note.starts_with("Nothing was felt") || note.starts_with("Little was felt")) return note + warned;
  }
  const std::string words =
      (share > 0.0 ? "Little was felt: for " + percent(share) + " of the time." : "Nothing was felt: no mode pushed.") + warned;
  if (!scene) return words;
  constexpr std::size_t most_places = 2048;  // [1] of the path. More: slower; fewer: a less certain nearest position
  const std::size_t stride = recorded.ticks.size() / most_places + 1;
  std::vector<Vec3> places_m;
  for (std::size_t i = 0; i < recorded.ticks.size(); i += stride) {
    const Tick& tick = recorded.ticks[i].result;
    if (tick.probe_valid && is_finite(tick.probe_m)) places_m.push_back(tick.probe_m);
  }
  // For a recording placed by an option, suggest the fitted placement.
  const auto& arguments = recorded.header.arguments;
  const bool left_there = std::any_of(arguments.begin(), arguments.end(), [](const std::string& one) {
    return one.starts_with("--hand-place") || one.starts_with("--hand-fit") || one.starts_with("--hand-center");
  });
  return words + " " + palpa::explain_little_contact(Reach(*scene), places_m, left_there ? "--hand-place fitted" : "");
}

std::string level_of(const Recorded& recorded, const RecordedEvent& event) {
  double value = 0.0;
  if (!take_number(event.value, value)) return event.subject;
  for (const NamedLevel& level : recorded.levels) {
    if (level.mode == event.subject && level.value == value) return "level " + level.name + " of " + event.subject;
  }
  return event.subject + text(" at the value %.6g", value);
}

std::string why_of(const RecordedEvent& event) {
  if (event.kind == "onset" || event.kind == "break_through") return {};
  double value = 0.0;
  if (!take_number(event.value, value)) return event.value;
  if (event.kind == "snap") return "the force fell by " + newtons(value);
  if (event.kind == "lost_ticks")
    return counted(static_cast<long long>(value), "tick was not recorded", "ticks were not recorded");
  if (event.kind == "lost_rows")
    return counted(static_cast<long long>(value), "row was not recorded", "rows were not recorded");
  return event.value;
}

bool was_in_real_time(const Recorded& recorded) {
  return std::any_of(recorded.ticks.begin(), recorded.ticks.end(), [](const TickFrame& tick) { return tick.late_us > 0.0; });
}

std::string format_contact(const ModeSummary& mode, const Summary& s) {
  if (mode.contact_share <= 0.0) return mode.name + " was never in contact.";
  std::string sentence = mode.name + " was in contact for " + percent(mode.contact_share) + " of the time, with " +
                         newtons(mode.force_mean_n) + " on average and " + newtons(mode.force_max_n) + " at most";
  if (mode.force_max_n > s.force_max_n && s.guard_limited_ticks > 0) sentence += ", on the proxy, before the guard";
  if (mode.onsets > 0) sentence += "; contact began " + times(mode.onsets);
  if (mode.break_throughs > 0) sentence += " and was broken through " + times(mode.break_throughs);
  return sentence + ".";
}

std::vector<std::string> format_recorded(const Recorded& recorded) {
  const Summary& s = recorded.summary;
  std::vector<std::string> words;
  const auto say = [&](const std::string& sentence) {
    if (!sentence.empty()) words.push_back(sentence);
  };
  if (s.ticks == 0) {
    say("Nothing was recorded: the trace ends before its first tick.");
    return words;
  }
  if (!recorded.header.complete) {
    say(text("This recording is incomplete: it ends after %.3f s, and the report covers that part.", s.duration_s));
  }
  if (s.contact_share > 0.0) {
    say(text("In %.3f s (", s.duration_s) + counted(s.ticks, "tick", "ticks") + ") the hand was in contact for " +
        percent(s.contact_share) + " of the time, with " + newtons(s.force_mean_n) + " on average and " +
        newtons(s.force_max_n) + " at most.");
    std::set<std::string> said;
    for (const RecordedEvent& event : recorded.events) {
      if (event.kind == "warning" && said.insert(event.value).second) say("Warning: " + sentence_of(event));
    }
  } else {
    say(text("In %.3f s (", s.duration_s) + counted(s.ticks, "tick", "ticks") + ") nothing was felt: no mode pushed.");
  }
  if (recorded.header.has_tool && s.contact_share > 0.0) say(format_torque(recorded));
  if (s.contact_share > 0.0) {
    for (const std::string& note : recorded.header.notes) say(note);
  }
  for (const ModeSummary& mode : s.modes) say(format_contact(mode, s));
  say(first_of(recorded, "onset", "onset"));
  say(first_of(recorded, "break_through", "break-through"));
  const std::string injected = millijoules(s.energy.injected_j);
  const bool drives = injected != millijoules(0.0);
  if (s.contact_share > 0.0)
    say("The modes dissipated " + millijoules(s.energy.dissipated_j) + " of the hand's energy" +
        (drives ? " and injected " + injected + "." : "."));
  if (s.energy.data_motion_j != 0.0) say("Moving data added " + millijoules(s.energy.data_motion_j) + ".");
  const auto& notes = recorded.header.notes;
  const bool is_noted = std::any_of(notes.begin(), notes.end(),
                                    [](const std::string& note) { return note.starts_with("Turning the handle brought in"); });
  if (s.unfelt_j != 0.0 && !is_noted)
    say("Turning the handle brought in " + millijoules(s.unfelt_j) + " unfelt: the device drives no torque.");
  const auto share = [&](std::int64_t ticks) {
    return counted(ticks, "tick", "ticks") + " (" + percent(static_cast<double>(ticks) / static_cast<double>(s.ticks)) + ")";
  };
  if (s.waiting_ticks > 0) say("In " + share(s.waiting_ticks) + " the work budget ran out before the proxy converged.");
  if (s.capped_ticks > 0) say("In " + share(s.capped_ticks) + " a balance was not proven to 1e-9 m.");
  if (s.bad_input_ticks + s.invalid_probe_ticks > 0) {
    say("In " + share(std::max(s.bad_input_ticks, s.invalid_probe_ticks)) + " the position of the hand was not known.");
  }
  if (s.guard_limited_ticks > 0)
    say(std::string(recorded.header.has_tool ? "The guard limited force or torque in " : "The guard limited the force in ") +
        share(s.guard_limited_ticks) + ".");
  if (s.faults > 0) say("Faults: " + grouped(s.faults) + ".");
  if (s.waiting_ticks + s.capped_ticks + s.bad_input_ticks + s.invalid_probe_ticks + s.guard_limited_ticks + s.faults == 0) {
    say("All ticks converged; no force was limited.");
  }
  return words;
}

}  // namespace palpa::detail
