#include "palpa/report/hands.h"

#include <algorithm>
#include <cctype>

#include "palpa/base/load_error.h"
#include "palpa/report/html.h"
#include "palpa/report/page.h"
#include "palpa/report/path_names.h"
#include "palpa/report/recorded.h"
#include "palpa/report/words.h"

namespace palpa::detail {
namespace {

namespace fs = std::filesystem;

/// Name in an address: a folder can have any.
std::string in_address(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' || c == '.';
    out += is_plain ? std::string(1, c) : text("%%%02X", static_cast<unsigned char>(c));
  }
  return out;
}

std::string hand_of(const fs::path& trace) { return trace.filename().string(); }

/// A row for each quantity, a column for each hand.
std::string beside_each_other(const std::vector<fs::path>& traces, const std::vector<Recorded>& hands) {
  std::vector<std::string> head{"hand"};
  for (const fs::path& trace : traces) head.push_back(hand_of(trace));
  std::vector<std::vector<std::string>> rows;
  const auto row = [&](const char* quantity, const auto& cell) {
    std::vector<std::string>& cells = rows.emplace_back(std::vector<std::string>{quantity});
    for (const Recorded& hand : hands) cells.push_back(cell(hand));
  };
  const auto millinewton_metres = [](double torque_nm) { return text("%.3f mN\u00b7m", 1e3 * torque_nm); };
  row("ticks", [](const Recorded& hand) { return grouped(static_cast<long long>(hand.summary.ticks)); });
  row("duration", [](const Recorded& hand) { return text("%.3f s", hand.summary.duration_s); });
  row("in contact", [](const Recorded& hand) { return text("%.1f %%", 100.0 * hand.summary.contact_share); });
  row("force on the hand, largest", [](const Recorded& hand) { return text("%.3f N", hand.summary.force_max_n); });
  if (std::ranges::any_of(hands, [](const Recorded& hand) { return hand.header.has_tool; })) {
    const auto torque = [&](const char* quantity, double LargestTorques::*largest) {
      row(quantity, [&](const Recorded& hand) {
        const double most_nm = largest_torques(hand).*largest;
        return !hand.header.has_tool ? std::string("no tool")
               : most_nm > 0.0       ? millinewton_metres(most_nm)
                                     : std::string("none");
      });
    };
    torque("torque on the hand, largest", &LargestTorques::on_hand_nm);
    torque("torque of the coupling, largest", &LargestTorques::coupling_nm);
  }
  row("first break-through", [](const Recorded& hand) {
    return hand.summary.first_break_through_s < 0.0 ? std::string("none") : text("%.3f s", hand.summary.first_break_through_s);
  });
  row("largest proven error of a balance", [](const Recorded& hand) { return text("%.2g m", hand.summary.error_bound_max_m); });
  return table(head, rows, 1);
}

}  // namespace

std::string hands_html(const fs::path& folder, const std::vector<fs::path>& traces, const ReportOptions& options) {
  std::vector<Recorded> hands;
  for (const fs::path& trace : traces) hands.push_back(read_recorded(trace));
  const PathNames names(hands.front(), folder, options.full_paths);
  const std::string& title = hands.front().title;
  Page page(title.empty() ? "Traces without a title" : names.in_text(title));
  page.begin_with("<p class=\"soft\">" + std::to_string(hands.size()) + (hands.size() == 1 ? " hand" : " hands on one clock") +
                  ", each with a page of its own.</p>\n");
  page.section("hands", "Side by side", beside_each_other(traces, hands));
  for (std::size_t h = 0; h < hands.size(); ++h) {
    const std::string name = hand_of(traces[h]);
    const PathNames of_hand(hands[h], traces[h], options.full_paths);
    std::string words = "<p><a href=\"" + in_address(name) + "/report.html\">Report of " + escaped(name) +
                        "</a></p>\n<p class=\"soft\">" + escaped(subtitle_of(hands[h])) + "</p>\n<ul class=\"felt\">\n";
    for (const std::string& sentence : format_recorded(hands[h]))
      words += "<li>" + escaped(of_hand.in_text(sentence)) + "</li>\n";
    page.section("hand" + std::to_string(h), name, words + "</ul>\n");
  }
  return page.html();
}

void check_options_of_hands(const fs::path& folder, const std::vector<fs::path>& traces, const fs::path& out,
                            const ReportOptions& options) {
  if (out.empty() && options.beside.empty() && options.pictures.empty()) return;
  throw LoadError(folder.string() +
                  ": holds a trace of each hand, and --out, --beside and --pictures are for one; name it, as in " +
                  traces.front().string());
}

}  // namespace palpa::detail
