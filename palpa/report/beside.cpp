#include "palpa/report/beside.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "palpa/base/load_error.h"
#include "palpa/report/html.h"
#include "palpa/report/page.h"
#include "palpa/report/parts.h"
#include "palpa/report/path_names.h"
#include "palpa/report/scene_differences.h"
#include "palpa/report/signal.h"
#include "palpa/study/beside.h"
#include "palpa/study/beside_words.h"

namespace palpa::detail {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_intervals = 20;  // [1] listed, the largest first. More: a longer page; fewer: causes are missed
// Smallest distance of drawn points of the hand's path [mm]. More: bends are cut; less: a larger page.
constexpr double drawn_apart_mm = 0.3;
constexpr palpa::CurveColor first_color = palpa::CurveColor::blue, second_color = palpa::CurveColor::vermilion;

/// One of the two traces.
struct Side {
  std::string name;  ///< of its folder
  PathNames paths;
  std::string scene_text;  ///< with all values, if its data can be loaded
  Recorded recorded;
  std::string no_scene;  ///< why its data cannot be loaded; empty: loaded
  Signal signal;
};

/// Last component of a path that is not empty.
std::string name_of(const fs::path& folder) {
  const fs::path whole = fs::absolute(folder).lexically_normal();
  return (whole.has_filename() ? whole.filename() : whole.parent_path().filename()).string();
}

Side side_of(const fs::path& folder, const ReportOptions& options) {
  Recorded recorded = read_recorded(folder);
  const PathNames paths(recorded, folder, options.full_paths);
  Side side{.name = name_of(folder),
            .paths = paths,
            .scene_text = recorded.scene_text,
            .recorded = std::move(recorded),
            .no_scene = {},
            .signal = {}};
  const std::optional<LoadedScene> loaded = scene_of(folder, side.recorded, options, side.no_scene);
  if (loaded) side.scene_text = to_toml(loaded->scene);
  side.signal = signal_of(side.recorded, loaded ? &loaded->scene : nullptr);
  if (side.recorded.ticks.empty()) throw LoadError(folder.string() + ": has no ticks to compare; record a trace that is felt");
  return side;
}

/// Both traces and their comparison.
struct Pair {
  Side first, second;
  FeltDifference difference;

  const FeltTick& a(std::size_t i) const { return first.signal.run.ticks[i]; }
  const FeltTick& b(std::size_t i) const { return second.signal.run.ticks[i]; }
  std::size_t ticks() const { return difference.difference_n.size(); }
};

std::size_t count_of(const Recorded& recorded, const char* kind) {
  return static_cast<std::size_t>(std::count_if(recorded.events.begin(), recorded.events.end(),
                                                [&](const RecordedEvent& event) { return event.kind == kind; }));
}

/// Verdict whether the difference is perceptible, and further facts, one sentence each.
std::vector<std::string> format_pair(const Pair& pair) {
  std::vector<std::string> words = difference_sentences(pair.first.signal.run, pair.second.signal.run, pair.difference);
  if (pair.difference.in_contact == 0) return words;
  const std::size_t first_breaks = count_of(pair.first.recorded, "break_through"),
                    second_breaks = count_of(pair.second.recorded, "break_through");
  if (first_breaks + second_breaks > 0)
    words.push_back(text("Break-throughs: %zu in the first, %zu in the second.", first_breaks, second_breaks));
  return words;
}

std::vector<TimePlot> plots_of(const Pair& pair) {
  std::vector<Mark> breaks;
  for (const auto& [side, kind] :
       {std::pair{&pair.first, "break-through in the first"}, {&pair.second, "break-through in the second"}})
    for (const RecordedEvent& event : side->recorded.events)
      if (event.kind == "break_through") breaks.push_back({event.t_s, kind});
  const FeltDifference& d = pair.difference;
  const auto ticks = std::span(pair.first.signal.run.ticks).first(pair.ticks());
  TimePlot force{.id = "force",
                 .plot = {.title = "Force on the hand", .x_label = "time / s", .y_label = "force / N", .marks = breaks},
                 .label = "Both forces over time.",
                 .caption = "Force on the hand in each trace, after the guard."};
  force.plot.series = {
      over_time(ticks, "first", first_color, Stroke::solid, [&](std::size_t i) { return norm(pair.a(i).command_n); }),
      over_time(ticks, "second", second_color, Stroke::dashed, [&](std::size_t i) { return norm(pair.b(i).command_n); })};
  TimePlot difference{
      .id = "difference",
      .plot = {.title = "Difference of the forces", .x_label = "time / s", .y_label = "force / N"},
      .label = text("The difference over time: at most %.3f N.", d.difference_n[d.largest]),
      .caption =
          "The magnitude of the difference of the two forces, and the difference in strength alone. A hand tells "
          "the strengths apart where the second curve is above the dashed line: 7 % of the force, and at least "
          "30 mN."};
  difference.plot.series = {
      over_time(ticks, "|first \u2212 second|", palpa::CurveColor::purple, Stroke::solid,
                [&](std::size_t i) { return d.difference_n[i]; }),
      over_time(ticks, "in strength", palpa::CurveColor::black, Stroke::solid,
                [&](std::size_t i) { return std::abs(norm(pair.a(i).command_n) - norm(pair.b(i).command_n)); }),
      over_time(ticks, "discrimination threshold", palpa::CurveColor::grey, Stroke::dashed,
                [&](std::size_t i) { return discrimination_threshold_n(pair.a(i).command_n, pair.b(i).command_n); })};
  TimePlot direction{.id = "direction",
                     .plot = {.title = "Angle between the forces", .x_label = "time / s", .y_label = "angle / \u00b0"},
                     .label = "The angle between the two forces over time.",
                     .caption =
                         "The angle between the two forces, 0 where one of them is below 30 mN. A hand tells directions "
                         "apart above 30\u00b0 or so."};
  direction.plot.series = {over_time(ticks, "between first and second", palpa::CurveColor::green, Stroke::solid,
                                     [&](std::size_t i) { return turned_deg(pair.a(i).command_n, pair.b(i).command_n); }),
                           over_time(ticks, "discrimination threshold", palpa::CurveColor::grey, Stroke::dashed,
                                     [](std::size_t) { return discrimination_deg; })};
  return {force, difference, direction};
}

/// Difference of the forces at a point of the hand's path, least first.
enum class Shade : std::uint8_t { same, other, noticeable };
Shade shade_of(const FeltDifference& difference, std::size_t i) {
  return difference.noticeable[i] != 0                  ? Shade::noticeable
         : difference.difference_n[i] > contact_force_n ? Shade::other
                                                        : Shade::same;
}

constexpr double view_width_px = 380.0, view_height_px = 400.0;  // of one of the three views of the path

/// The hand's path along two axes of the hand, as SVG elements. Titles are constants and need no escape.
std::string way_along(const Pair& pair, const char* title, const Vec3& right, const Vec3& up, double half_mm,
                      const Vec3& middle_m) {
  constexpr double title_px = 26.0, margin_px = 6.0, side_px = view_height_px - title_px - 2.0 * margin_px;
  const double px_per_mm = 0.5 * side_px / half_mm;
  const auto mm = [&](std::size_t i) {
    const Vec3 from_m = pair.a(i).probe_m - middle_m;
    return std::array{1e3 * dot(from_m, right), 1e3 * dot(from_m, up)};
  };
  const auto px = [&](const std::array<double, 2>& at_mm) {
    return std::array{0.5 * view_width_px + px_per_mm * at_mm[0],
                      view_height_px - margin_px - 0.5 * side_px - px_per_mm * at_mm[1]};
  };
  std::string shapes =
      text("<text x=\"%.0f\" y=\"22\" text-anchor=\"middle\" font-size=\"14\" font-weight=\"bold\">%s</text>\n",
           0.5 * view_width_px, title);
  struct Look {
    Shade shade;
    const char* color;
    int width_px;
  };
  for (const Look& look :
       {Look{Shade::same, "#787878", 1}, Look{Shade::other, "#3e9cd1", 2}, Look{Shade::noticeable, "#d55e00", 3}}) {
    std::vector<std::array<double, 2>> line;  // [mm]
    const auto draw = [&] {
      if (line.size() > 1) {
        shapes += text("<polyline fill=\"none\" stroke=\"%s\" stroke-width=\"%d\" points=\"", look.color, look.width_px);
        for (const auto& at_mm : line) shapes += text("%.2f,%.2f ", px(at_mm)[0], px(at_mm)[1]);
        shapes += "\"/>\n";
      }
      line.clear();
    };
    for (std::size_t i = 0; i < pair.ticks(); ++i) {
      if (!pair.a(i).usable || shade_of(pair.difference, i) != look.shade) {
        if (pair.a(i).usable && !line.empty()) line.push_back(mm(i));
        draw();
        continue;
      }
      const std::array<double, 2> next = mm(i);
      if (line.empty() || std::hypot(next[0] - line.back()[0], next[1] - line.back()[1]) > drawn_apart_mm) line.push_back(next);
    }
    draw();
  }
  const double bar_mm = half_mm > 40.0 ? 20.0 : half_mm > 10.0 ? 10.0 : 2.0;
  const auto [x, y] = px({-0.95 * half_mm, -0.95 * half_mm});
  const double end = x + px_per_mm * bar_mm;
  shapes += text("<path stroke=\"#000000\" stroke-width=\"2.5\" d=\"M%.2f %.2fH%.2f\"/>\n", x, y, end);
  shapes += text("<text x=\"%.2f\" y=\"%.2f\" font-size=\"13\">%.0f mm</text>\n", end + 8.0, y + 4.0, bar_mm);
  if (pair.difference.difference_n[pair.difference.largest] > 0.0) {
    const auto at = px(mm(pair.difference.largest));
    shapes += text("<circle cx=\"%.2f\" cy=\"%.2f\" r=\"5\" fill=\"#ffffff\" stroke=\"#000000\" stroke-width=\"1.6\"/>\n",
                   at[0], at[1]);
  }
  return shapes;
}

std::string where_markup(const Pair& pair, const ReportOptions& options) {
  Vec3 low_m{1e300, 1e300, 1e300}, high_m{-1e300, -1e300, -1e300};
  for (std::size_t i = 0; i < pair.ticks(); ++i) {
    if (!pair.a(i).usable) continue;
    const Vec3& p = pair.a(i).probe_m;
    low_m = {std::min(low_m.x, p.x), std::min(low_m.y, p.y), std::min(low_m.z, p.z)};
    high_m = {std::max(high_m.x, p.x), std::max(high_m.y, p.y), std::max(high_m.z, p.z)};
  }
  if (!(low_m.x <= high_m.x)) return "<p class=\"soft\">The position of the hand was never known.</p>\n";
  const double half_mm = std::max(1.0, 0.55e3 * largest_component(high_m - low_m));
  const Vec3 middle_m = 0.5 * (low_m + high_m);
  std::string svg = text(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" viewBox=\"0 0 %.0f %.0f\" "
      "font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\">\n"
      "<rect width=\"100%%\" height=\"100%%\" fill=\"#ffffff\"/>\n",
      3.0 * view_width_px, view_height_px, 3.0 * view_width_px, view_height_px);
  double left_px = 0.0;
  for (const std::string& view : {way_along(pair, "from where you sit", {1, 0, 0}, {0, 1, 0}, half_mm, middle_m),
                                  way_along(pair, "from the left, you at the right", {0, 0, 1}, {0, 1, 0}, half_mm, middle_m),
                                  way_along(pair, "from above, you below", {1, 0, 0}, {0, 0, -1}, half_mm, middle_m)}) {
    svg += text("<g transform=\"translate(%.0f 0)\" stroke-linejoin=\"round\">\n", left_px) + view + "</g>\n";
    left_px += view_width_px;
  }
  svg += "</svg>\n";
  keep(options, "where.svg", svg);
  svg.insert(4, " role=\"img\" aria-label=\"The path of the hand from three sides, with the places where the two differ.\"");
  std::string out = figure(svg,
                           "The path of the hand: grey where the forces agree to 1 mN, light blue where they differ by less "
                           "than the discrimination threshold, red where by more; a ring at the largest difference.");

  std::vector<NoticeableInterval> largest = pair.difference.intervals;
  const auto by_size = [&](const NoticeableInterval& a, const NoticeableInterval& b) {
    return pair.difference.difference_n[a.largest] > pair.difference.difference_n[b.largest];
  };
  std::stable_sort(largest.begin(), largest.end(), by_size);
  if (largest.empty()) return out;
  const bool cut = largest.size() > most_intervals;
  largest.resize(std::min(largest.size(), most_intervals));
  std::vector<std::vector<std::string>> rows;
  for (const NoticeableInterval& interval : largest) {
    const FeltTick &a = pair.a(interval.largest), &b = pair.b(interval.largest);
    rows.push_back({seconds(pair.a(interval.first).t_s) + " \u2013 " + seconds(pair.a(interval.last).t_s),
                    newtons(pair.difference.difference_n[interval.largest]), newtons(norm(a.command_n)),
                    newtons(norm(b.command_n)), text("%.0f\u00b0", turned_deg(a.command_n, b.command_n)), seconds(a.t_s),
                    place_words(a.probe_m)});
  }
  return out +
         (cut ? "<p>The intervals with the largest differences:</p>\n"
              : "<p>Intervals in which a hand would tell the two apart:</p>\n") +
         table({"interval", "largest difference", "first", "second", "turned", "at", "hand (right, up, towards you)"}, rows, 1);
}

std::string felt_markup(const Pair& pair, const ReportOptions& options) {
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const char* what, const auto& of) {
    rows.push_back({what, of(pair.first.signal), of(pair.second.signal)});
  };
  const auto band = [](double low_hz) {
    return [low_hz](const Signal& s) {
      return s.command.step_hz > 0.0 ? text("%.2f mN", 1e3 * s.command.band_rms(low_hz, tactile_high_hz))
                                     : std::string("too short");
    };
  };
  add("force, 20 to 500 Hz, root mean square", band(tactile_low_hz));
  add("force, 100 to 500 Hz, root mean square", band(rough_low_hz));
  add("limited by the guard", [](const Signal& s) { return text("%.1f %%", 100.0 * saturated_share(s.run)); });
  add("steepest fall at a break-through", [](const Signal& s) { return text("%.3f N/ms", steepest_fall_n_per_ms(s.run)); });
  const auto steps = [](const Signal& s, const auto& counts) {
    const auto count = std::count_if(s.steps.begin(), s.steps.end(), counts);
    double largest_n = 0.0;
    for (const ExcessStep& step : s.steps)
      if (counts(step)) largest_n = std::max(largest_n, step.excess_n);
    return count == 0 ? std::string("none") : grouped(count) + text(", up to %.3f N", largest_n);
  };
  for (const StepCause cause : step_causes) {
    const auto is_of = [cause](const ExcessStep& step) { return step.cause == cause; };
    const bool some = std::any_of(pair.first.signal.steps.begin(), pair.first.signal.steps.end(), is_of) ||
                      std::any_of(pair.second.signal.steps.begin(), pair.second.signal.steps.end(), is_of);
    if (some) add((std::string("steps: ") + palpa::name_of(cause)).c_str(), [&](const Signal& s) { return steps(s, is_of); });
  }
  std::string out;
  if (pair.first.signal.command.step_hz > 0.0 && pair.second.signal.command.step_hz > 0.0) {
    const Plot plot = spectrum_plot("Spectra of the force on the hand",
                                    {amplitudes(pair.first.signal.command, "first", first_color, Stroke::solid),
                                     amplitudes(pair.second.signal.command, "second", second_color, Stroke::solid)});
    std::string svg = svg_of(plot, 760, 320, "spectrum-");
    keep(options, "spectrum.svg", svg);
    svg.insert(4, " role=\"img\" aria-label=\"Spectra of both forces on the hand, with the tactile band.\"");
    out +=
        figure(svg,
               "In contact and away from events. Skin feels what lies between 20 and 500 Hz, the tactile band, as rough; "
               "the hand's own motion is the same in both, so what differs there comes from the scene, the law or the device.");
  }
  return out + table({"quantity", "first", "second"}, rows, 1) +
         text(
             "<p class=\"hint\">Steps of more than %.0f mN within a tick beyond what the spring makes of the hand's own "
             "motion.</p>\n",
             1e3 * felt_step_n);
}

std::string title_of(const Side& side) {
  return side.recorded.title.empty() ? "(no title)" : side.paths.in_text(side.recorded.title);
}

std::string origin_markup(const Pair& pair) {
  const auto command = [](const Side& side) {
    std::string all;
    for (const std::string& word : side.recorded.header.arguments)
      all += (all.empty() ? "" : " ") + side.paths.of_argument(word);
    return all;
  };
  const auto sets = [](const Side& side) {
    std::string all;
    for (const auto& [key, value] : side.recorded.header.sets)
      all += (all.empty() ? "" : ", ") + side.paths.of_argument(key + "=" + value);
    return all.empty() ? std::string("none") : all;
  };
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const char* what, const auto& of) { rows.push_back({what, of(pair.first), of(pair.second)}); };
  add("trace", [](const Side& side) { return side.name; });
  add("scene", [](const Side& side) { return title_of(side); });
  add("settings", sets);
  add("command line", command);
  add("stiffness of the coupling", [](const Side& side) { return text("%.4g N/m", side.signal.run.stiffness_n_per_m); });
  add("in contact", [](const Side& side) { return text("%.1f %%", 100.0 * side.recorded.summary.contact_share); });
  add("largest force on the hand", [](const Side& side) { return newtons(side.recorded.summary.force_max_n); });
  add("mean force in contact", [](const Side& side) { return newtons(side.recorded.summary.force_mean_n); });
  add("ticks", [](const Side& side) { return grouped(static_cast<long long>(side.recorded.ticks.size())); });
  add("palpa", [](const Side& side) { return side.recorded.header.palpa_version; });
  return table({"", "first", "second"}, rows, 3) + (pair.first.recorded.scene_text == pair.second.recorded.scene_text
                                                        ? "<p>Both have the same scene file.</p>\n"
                                                        : "<p>The scene files differ.</p>\n");
}

/// Title of the page: the differing value, or the number of them.
std::string title_of(const Pair& pair, const std::vector<SceneDifference>& differences) {
  if (differences.empty()) return pair.first.name + " beside " + pair.second.name + ": one scene, recorded twice";
  if (differences.size() > 1) return text("%zu values of the scene differ", differences.size());
  return format_difference(differences.front());
}

std::string scenes_of(const Pair& pair) {
  const std::string first = title_of(pair.first), second = title_of(pair.second);
  return first == second ? "Both in the scene: " + first : "Their scenes: " + first + " / " + second;
}

/// Differing values, as first / second.
std::string differences_markup(const std::vector<SceneDifference>& differences) {
  if (differences.size() < 2) return {};
  constexpr std::size_t most = 12;  // [1] listed. More: a long list on top; fewer: causes are missed
  std::string out = "<ul class=\"felt\">\n";
  for (std::size_t i = 0; i < std::min(most, differences.size()); ++i)
    out += "<li>" + escaped(format_difference(differences[i])) + "</li>\n";
  if (differences.size() > most) out += text("<li>and %zu more</li>\n", differences.size() - most);
  return out + "</ul>\n";
}

constexpr const char* how_it_is_judged =
    "<p class=\"hint\">A hand is said to tell two forces apart where they differ in strength by more than 7\u00a0% (Pang, Tan "
    "and "
    "Durlach 1991, for 2.5 to 10\u00a0N) and by at least 30\u00a0mN, or in direction by more than 30\u00b0 where both are "
    "above 30\u00a0mN. "
    "These were measured on forces that are held and compared one after the other; for changes of a few milliseconds read the "
    "spectra and steps.</p>\n";

}  // namespace

std::string beside_html(const fs::path& folder, const ReportOptions& options) {
  Pair pair{side_of(folder, options), side_of(options.beside, options), {}};
  if (const std::string part = where_hands_part(pair.first.signal.run, pair.second.signal.run); !part.empty()) {
    throw LoadError(options.beside.string() + ": has another hand than " + folder.string() + ", " + part +
                    "; run its scene with that hand: palpa run SCENE --hand " + (folder / "ticks.csv").string());
  }
  pair.difference = compare_felt(pair.first.signal.run, pair.second.signal.run);
  if (options.progress) options.progress(0.6);

  std::vector<SceneDifference> differences = scene_differences(pair.first.scene_text, pair.second.scene_text);
  for (SceneDifference& one : differences) {
    one.first = pair.first.paths.of_value(one.first);
    one.second = pair.second.paths.of_value(one.second);
  }
  Page page(title_of(pair, differences));
  page.begin_with("<p class=\"soft\">" +
                  escaped(text("Two traces of the same hand, %.3f s: ", pair.a(pair.ticks() - 1).t_s) + "first " +
                          pair.first.name + ", second " + pair.second.name + ". " + scenes_of(pair)) +
                  "</p>\n");
  page.begin_with(differences_markup(differences));
  if (pair.first.recorded.ticks.size() != pair.second.recorded.ticks.size()) {
    const auto ticks = [](const Side& side) { return std::to_string(side.recorded.ticks.size()); };
    page.begin_with("<p class=\"soft\">" +
                    escaped("The first has " + ticks(pair.first) + " ticks, the second " + ticks(pair.second) +
                            "; compared are those that both have.") +
                    "</p>\n");
  }
  for (const Side* side : {&pair.first, &pair.second}) {
    if (!side->recorded.header.complete)
      page.begin_with(notice(side->name + " is incomplete. The comparison covers the recorded part."));
  }
  std::string words = "<ul class=\"felt\">\n";
  for (const std::string& sentence : format_pair(pair)) words += "<li>" + escaped(sentence) + "</li>\n";
  page.section("felt", "Differences", words + "</ul>\n" + how_it_is_judged);
  const std::vector<TimePlot> over_time = plots_of(pair);
  page.section("plots", "Over time", plots_markup(over_time, false, options));
  page.data("plots-data", json_of(over_time, most_plot_rows, {pair.difference.largest}));
  page.section("where", "Where", where_markup(pair, options));
  if (options.progress) options.progress(0.9);
  page.section("signal", "Force signal", felt_markup(pair, options));
  page.section("origin", "The two traces", origin_markup(pair) + software_markup());
  for (const char* name : {"dygraph.min.js", "synchronizer.js", "report.js", "plots.js", "view_3d.js", "start.js"})
    page.script(name);
  return page.html();
}

}  // namespace palpa::detail
