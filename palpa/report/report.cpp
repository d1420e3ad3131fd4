#include "palpa/report/report.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <optional>
#include <system_error>

#include "palpa/base/new_file.h"
#include "palpa/data/octave_parts.h"
#include "palpa/report/beside.h"
#include "palpa/report/hands.h"
#include "palpa/report/html.h"
#include "palpa/report/moments.h"
#include "palpa/report/page.h"
#include "palpa/report/parts.h"
#include "palpa/report/path_names.h"
#include "palpa/report/plots.h"
#include "palpa/report/recorded.h"
#include "palpa/report/signal.h"
#include "palpa/report/tables.h"
#include "palpa/report/view_3d.h"
#include "palpa/report/words.h"
#include "palpa/view/picture.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;
using namespace detail;

constexpr std::size_t most_moments = 500;  // [1] with primitives. More: a larger page; fewer: the view jumps

std::string image(const ReportOptions& options, const char* name, const Picture& picture, const std::string& alt,
                  const std::string& caption) {
  const std::string png = png_of(picture);
  keep(options, name, png);
  return figure("<img width=\"" + std::to_string(picture.width_px) + "\" height=\"" + std::to_string(picture.height_px) +
                    "\" alt=\"" + escaped(alt) + "\" src=\"" + png_address(png) + "\">",
                caption);
}

void tell(const ReportOptions& options, double share_done) {
  if (options.progress) options.progress(share_done);
}

/// Perceptible properties of the signal: bands, spectrum, steps.
std::string felt_signal(const Recorded& recorded, const Scene* scene, const ReportOptions& options) {
  const Signal signal = signal_of(recorded, scene);
  if (signal.run.stiffness_n_per_m == 0.0 || recorded.summary.force_max_n <= contact_force_n)
    return "<p class=\"soft\">Nothing was touched, so there is nothing to measure.</p>\n";
  std::string out = signal_markup(signal);
  if (signal.command.step_hz > 0.0) {
    const Plot plot = spectrum_plot("Spectrum of the force on the hand",
                                    {amplitudes(signal.spring, "k \u00b7 probe", CurveColor::orange, Stroke::dashed),
                                     amplitudes(signal.command, "on the hand", CurveColor::black, Stroke::solid)});
    std::string svg = svg_of(plot, 760, 320, "spectrum-");
    keep(options, "spectrum.svg", svg);
    svg.insert(4, " role=\"img\" aria-label=\"Spectrum of the force on the hand, and of k times the probe.\"");
    out += figure(svg,
                  "In contact and away from events. Skin feels frequencies from 20 to 500 Hz as roughness. Force in this band "
                  "beyond k times the probe does not come from the hand or its device.");
  }
  return out + steps_markup(signal);
}

/// Picture of the scene; none, with the reason, on failure.
std::optional<Picture> drawn(const Scene& scene, const std::vector<PathPoint>& path, const std::optional<Moment>& moment,
                             const ScenePictureOptions& look, std::string& why_not) {
  try {
    return scene_picture(scene, path, moment, look);
  } catch (const LoadError& error) {
    why_not = std::string("No picture: ") + error.what();
    return {};
  }
}

/// Close-up of the busiest moment.
std::string picture_of_moment(const Recorded& recorded, const Scene& scene, const std::vector<RecordedMoment>& moments,
                              const std::vector<PathPoint>& path, const ReportOptions& options) {
  const std::optional<std::size_t> chosen = busiest_row(recorded);
  if (!chosen) return "<p class=\"soft\">No mode pushed, so there is no moment to look at closely.</p>\n";
  const auto found =
      std::find_if(moments.begin(), moments.end(), [&](const RecordedMoment& moment) { return moment.row == *chosen; });
  if (found == moments.end() || found->primitives.empty()) return {};
  const TickFrame& frame = recorded.ticks[*chosen];
  const Moment moment{.probe_m = frame.result.probe_m,
                      .proxy_m = frame.result.proxy_m,
                      .primitives = found->primitives,
                      .mode_names = recorded.modes,
                      .time_s = frame.t_s,
                      .probe_turn = frame.result.probe_turn,
                      .proxy_turn = frame.result.proxy_turn};
  const double reach_m = distance(moment.probe_m, moment.proxy_m);
  std::string why_not;
  const std::optional<Picture> picture = drawn(scene, path, moment, close_up(scene, moment), why_not);
  if (!picture) return notice(why_not);
  std::string who;
  for (std::size_t m = 0; m < recorded.modes.size(); ++m) {
    const double force_n = norm(recorded.pushes[m][*chosen].force_n);
    if (force_n > contact_force_n) who += (who.empty() ? "" : ", ") + recorded.modes[m] + text(" %.2f N", force_n);
  }
  const double hand_n = norm(frame.command.force_n), asked_n = norm(frame.result.force_n);
  const std::string cut =
      frame.command.guard != GuardState::limited ? "" : text(" (%.2f N requested, before the guard)", asked_n);
  const std::string caption =
      text("The moment at %.3f s, with the most modes in contact and the largest force: ", frame.t_s) + who +
      text("; force on the hand %.2f N", hand_n) + cut + text(", the proxy is %.2f mm from the probe. ", 1e3 * reach_m) +
      std::to_string(moment.primitives.size()) + (moment.primitives.size() == 1 ? " primitive." : " primitives.");
  return image(options, "moment.png", *picture, "Close-up of probe, proxy and primitives. " + caption, caption);
}

/// Path of all ticks with a known hand position.
std::vector<PathPoint> path_of(const Recorded& recorded) {
  std::vector<PathPoint> path;
  for (const TickFrame& frame : recorded.ticks) {
    if (frame.result.probe_valid && is_finite(frame.result.probe_m))
      path.push_back({frame.result.probe_m, frame.result.proxy_m, frame.command.force_n, frame.result.force_n,
                      frame.command.guard == GuardState::limited});
  }
  return path;
}

/// Meaning of the octaves that a key names; empty for a scene without volumes larger than memory.
std::string words_on_octaves(const Scene& scene) {
  for (const SceneVolume& volume : scene.volumes()) {
    for (const VolumeField& field : volume.volume.fields) {
      if (octaves_below(*field.field))
        return " Octave 0 has the voxels of the file, each next octave the means of 2 \u00d7 2 \u00d7 2 of them.";
    }
  }
  return {};
}

/// Pictures in place of the interactive view: scene with path, and busiest moment.
std::string stills(const Recorded& recorded, const Scene& scene, const std::vector<PathPoint>& path,
                   const ScenePictureOptions& look, const std::vector<RecordedMoment>& moments, const ReportOptions& options) {
  std::string why_not;
  const std::optional<Picture> picture = drawn(scene, path, std::nullopt, look, why_not);
  if (!picture) return notice(why_not);
  const std::string whole =
      image(options, "scene.png", *picture, "The scene with the path of the hand, coloured by force.",
            "The scene as the user sees it, with the path of probe and proxy, coloured by the force on the hand." +
                words_on_octaves(scene));
  tell(options, 0.8);
  return whole + picture_of_moment(recorded, scene, moments, path, options);
}

/// Container for view_3d.js, laid out by report.css.
constexpr const char* stage = R"(<div class="live live-view view">
<div class="stage" id="stage"></div>
<div class="beside">
<div class="looks" id="looks"></div>
<h3>Key</h3>
<div class="key" id="key"></div>
<h3>At this moment</h3>
<div class="now" id="moment"></div>
</div>
</div>
<p class="live live-view hint">Drag turns, right drag or shift and drag moves, a click and then the wheel zooms. On a touch screen one finger
turns, two zoom and move.</p>
<p class="hint" id="no-view" hidden="hidden">This browser shows no WebGL, so there is a picture in place of what could be turned.</p>
)";

/// Time bar of view and plots, at the lower edge of the window.
constexpr const char* time_bar = R"(<div class="live live-time timebar" id="timebar">
<button type="button" id="before" title="the previous event">&#9664;&#160;event</button>
<button type="button" id="play" title="play in real time">&#9654;</button>
<input type="range" id="time" min="0" max="1000" step="1" value="0" aria-label="moment">
<button type="button" id="after" title="the next event">event&#160;&#9654;</button>
<output id="now" for="time"></output>
</div>
)";

/// Moments with their primitives, recorded or replayed; the reason in `why_not` if there are none.
std::vector<RecordedMoment> moments_of(const fs::path& trace, const Recorded& recorded, const Scene* scene,
                                       const ReportOptions& options, std::string& why_not) {
  std::vector<RecordedMoment> moments = moments_at(rows_worth_a_look(recorded, most_moments));
  try {
    if (recorded.header.primitives) {
      recall_primitives(trace, recorded, moments);
    } else if (scene) {
      feel_primitives_again(trace, recorded, *scene, moments, [&](double share) { tell(options, 0.2 + 0.3 * share); });
    }
  } catch (const LoadError& error) {
    why_not = error.what();
  }
  return moments;
}

void add_scripts(Page& page, bool has_tool) {
  page.end_with(time_bar);
  for (const char* name : {"three.min.js", "OrbitControls.js", "LineSegmentsGeometry.js", "LineMaterial.js", "LineSegments2.js",
                           "dygraph.min.js", "synchronizer.js", "report.js", "plots.js", "view_3d.js"}) {
    page.script(name);
  }
  if (has_tool) page.script("tool.js");
  page.script("start.js");
}

/// A page on each trace, and one on all of them.
fs::path write_report_of_hands(const fs::path& folder, const std::vector<fs::path>& traces, const ReportOptions& options) {
  const auto count = static_cast<double>(traces.size());
  for (std::size_t h = 0; h < traces.size(); ++h) {
    ReportOptions of_hand = options;
    of_hand.progress = [&, done = static_cast<double>(h)](double share) { tell(options, (done + share) / count); };
    write_report(traces[h], {}, of_hand);
  }
  const fs::path file = folder / "report.html";
  const Existing existing = what_becomes_of(file, options);
  write_whole(file, hands_html(folder, traces, options), existing);
  return file;
}

}  // namespace

std::string report_html(const fs::path& trace, const ReportOptions& options) {
  if (const std::vector<fs::path> traces = traces_in(trace); traces.front() != trace) {
    check_options_of_hands(trace, traces, {}, options);
    return hands_html(trace, traces, options);
  }
  if (!options.beside.empty()) return beside_html(trace, options);
  const Recorded recorded = read_recorded(trace);
  tell(options, 0.1);
  const PathNames names(recorded, trace, options.full_paths);
  Page page(recorded.title.empty() ? "A trace without a title" : names.in_text(recorded.title));
  page.begin_with("<p class=\"soft\">" + escaped(subtitle_of(recorded)) + "</p>\n");
  if (!recorded.header.complete) page.begin_with(notice("This recording is incomplete. The report covers the recorded part."));

  std::string words = "<ul class=\"felt\">\n";
  for (const std::string& sentence : format_recorded(recorded)) words += "<li>" + escaped(names.in_text(sentence)) + "</li>\n";
  page.section("felt", "Overview", words + "</ul>\n");

  std::string no_scene, no_primitives;
  const std::optional<LoadedScene> loaded = scene_of(trace, recorded, options, no_scene);
  tell(options, 0.2);
  const Scene* const scene = loaded ? &loaded->scene : nullptr;
  if (const std::string why = explain_little_contact(recorded, scene); !why.empty())
    page.begin_with(notice(names.in_text(why)));
  const std::vector<RecordedMoment> moments = moments_of(trace, recorded, scene, options, no_primitives);
  tell(options, 0.5);
  std::string view = no_scene.empty() ? "" : notice("No picture: " + names.in_text(no_scene));
  if (!no_primitives.empty()) view += notice("No primitives: " + names.in_text(no_primitives));
  const std::vector<PathPoint> path = path_of(recorded);
  const ScenePictureOptions look = scene ? overview(*scene, path) : ScenePictureOptions{};
  tell(options, 0.55);
  std::future<std::string> json;  // made beside the pictures
  if (!moments.empty()) {
    view += stage;
    json = std::async(std::launch::async, [&] { return json_of_view(recorded, scene, moments, look.from); });
  }
  if (scene) view += "<div class=\"still still-view\">\n" + stills(recorded, *scene, path, look, moments, options) + "</div>\n";
  if (json.valid()) page.data("view-data", json.get());
  page.section("view", "Scene and path", view);
  if (!recorded.ticks.empty()) {
    const std::vector<TimePlot> over_time = time_plots(recorded);
    page.section("plots", "Over time", plots_markup(over_time, true, options));
    std::vector<std::size_t> looked_at;
    for (const RecordedMoment& moment : moments) looked_at.push_back(moment.row);
    page.data("plots-data", json_of(over_time, most_plot_rows, looked_at));
  }
  tell(options, 0.9);
  if (!recorded.ticks.empty()) page.section("signal", "Force signal", felt_signal(recorded, scene, options));
  page.section("summary", "Summary", summary_markup(recorded));
  page.section("energy", "Energy", energy_markup(recorded));
  page.section("modes", "Modes", modes_markup(recorded));
  page.section("events", "Events", events_markup(recorded, names));
  page.section("origin", "Origin", origin_markup(recorded, names));
  page.section("scene", "Scene",
               "<pre><code>" + escaped(names.in_text(recorded.scene_text)) + "</code></pre>\n" + software_markup());
  if (!recorded.ticks.empty()) add_scripts(page, recorded.header.has_tool);
  return page.html();
}

fs::path write_report(const fs::path& trace, const fs::path& out, const ReportOptions& options) {
  if (const std::vector<fs::path> traces = traces_in(trace); traces.front() != trace) {
    check_options_of_hands(trace, traces, out, options);
    return write_report_of_hands(trace, traces, options);
  }
  if (!options.pictures.empty()) {
    std::error_code error;
    fs::create_directories(options.pictures, error);
    if (error) throw LoadError(options.pictures.string() + ": cannot be made (" + error.message() + "); choose another folder");
  }
  const fs::path file = !out.empty() ? out : trace / (options.beside.empty() ? "report.html" : "beside.html");
  const Existing existing = what_becomes_of(file, options);
  write_whole(file, report_html(trace, options), existing);
  return file;
}

}  // namespace palpa
