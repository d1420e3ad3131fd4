#include "palpa/study/beside_words.h"

#include <algorithm>
#include <cmath>

#include "palpa/base/printed.h"

namespace palpa::detail {

std::string newtons(double force_n) { return text(std::abs(force_n) < 0.1 ? "%.3f N" : "%.2f N", force_n); }
std::string seconds(double time_s) { return text("%.3f s", time_s); }
std::string place_words(const Vec3& hand_m) {
  return text("%+.1f, %+.1f, %+.1f mm", 1e3 * hand_m.x, 1e3 * hand_m.y, 1e3 * hand_m.z);
}

std::vector<std::string> difference_sentences(const FeltRun& first, const FeltRun& second, const FeltDifference& d) {
  if (d.in_contact == 0) return {"No force reached the hand in either trace, so there is nothing to compare."};
  const FeltTick &a = first.ticks[d.largest], &b = second.ticks[d.largest];
  const double largest_n = d.difference_n[d.largest];
  if (largest_n == 0.0) return {"The two forces are identical, to the bit, in every tick."};
  std::vector<std::string> words;
  if (d.intervals.empty()) {
    words.push_back("A hand would not tell the two apart: the forces never differ by more than the discrimination threshold.");
  } else {
    const auto duration_s = [&](const NoticeableInterval& at) { return first.ticks[at.last].t_s - first.ticks[at.first].t_s; };
    const NoticeableInterval& longest = *std::ranges::max_element(d.intervals, {}, duration_s);
    words.push_back(
        text("A hand would tell the two apart in %.1f %% of the time with contact in either, in %zu %s; the longest is from "
             "%.3f to %.3f s.",
             100.0 * d.noticeable_share, d.intervals.size(), d.intervals.size() == 1 ? "interval" : "intervals",
             first.ticks[longest.first].t_s, first.ticks[longest.last].t_s));
  }
  words.push_back("The largest difference is " + newtons(largest_n) + ", at " + seconds(a.t_s) + ": " +
                  newtons(norm(a.command_n)) + " against " + newtons(norm(b.command_n)) +
                  text(", %.0f\u00b0 between them", turned_deg(a.command_n, b.command_n)) + "; the hand is at " +
                  place_words(a.probe_m) + " (right, up, towards you).");
  words.push_back("Over all that time the root mean square of the difference is " + newtons(d.rms_n) + ".");
  return words;
}

}  // namespace palpa::detail
