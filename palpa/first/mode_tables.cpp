#include "palpa/first/mode_tables.h"

#include <algorithm>
#include <cmath>

#include "palpa/first/scene_lines.h"
#include "palpa/toml/wording.h"

namespace palpa::detail {
namespace {

std::string points(std::initializer_list<std::pair<double, double>> list) {
  std::string all;
  for (const auto& [value, result] : list) {
    all += (all.empty() ? "[" : ", [") + toml_number(value) + ", " + toml_number(result) + "]";
  }
  return "[" + all + "]";
}

/// A function that is 0 up to `zero_at` and `result` from `full_at` to `beyond`, which lies outside of all values.
std::string ramp(const std::string& of, double zero_at, double full_at, double beyond, double result) {
  return "{of = " + toml_string(of) + ", points = " +
         (zero_at < full_at ? points({{zero_at, 0}, {full_at, result}, {beyond, result}})
                            : points({{beyond, result}, {full_at, result}, {zero_at, 0}})) +
         "}";
}

std::string surface_layer(const std::string& field, double level, const char* color, double opacity, const std::string& why) {
  std::string out = "\n[[view.layer]]\nshow = \"surface\"\nfield = " + toml_string(field) + "\n";
  out += reasoned("level = " + toml_number(level), why);
  return out + reasoned("colors = {points = [[" + toml_number(level) + ", " + toml_string(color) + ", " + toml_number(opacity) +
                            "]]}",
                        opacity < 1.0 ? "one sees through it" : "opaque");
}

std::string mode_head(const char* name, const char* type, const std::string& field) {
  return std::string("name = \"") + name + "\"\ntype = \"" + type + "\"\nfield = " + toml_string(field) + "\n";
}

/// 0.1, between the lining of a bowel (0.007 to 0.054 under steel: Lyle et al. 2013) and dry skin (above 0.2, 0.5 as a rule:
/// Derler and Gerhardt 2012). More friction would hide the shape of a surface, which a hand finds by gliding over it.
std::string friction_line() {
  return reasoned("friction_coefficient = 0.1",
                  "a smooth wall: sliding costs a tenth of the pressure; wet tissue 0.01 to 0.05, dry skin 0.2 to 0.5");
}

// [1] Labels that get a mode of their own, at most. More: time of each tick and memory, and more colours are needed below;
// fewer: parts that are worth feeling are left out.
constexpr std::size_t most_labels = 6;

/// A label as a scene names it.
std::string label_name(double value) {
  std::string name = value < 0.0 ? "label_minus_" : "label_";
  return name + with_digits(std::abs(value), 17);
}

}  // namespace

std::string surface_modes(const std::string& field, const Statistics& values, const FirstLevels& first, double faint) {
  const double span = values.max - values.min;
  std::string out = "[[mode]]\n" + mode_head("surface", "surface_and_friction", field);
  out += reasoned(std::string("solid = ") + (first.solid_is_high ? "\"high\"" : "\"low\""), first.why_solid);
  out += friction_line();
  for (const FirstLevel& level : first.levels) {
    out += "\n[[mode.level]]\nname = " + toml_string(level.name) + "\n";
    out += reasoned("value = " + toml_number(level.value), level.why_value);
    out += reasoned("strength_n = " + toml_number(level.strength_n), level.why_strength);
    if (level.soft)
      out += reasoned("stiffness_n_per_m = 300",
                      "and gives way before, like flesh under a finger: what is harder below is felt through it");
  }
  const double level = first.levels.front().value;
  const double towards_solid = first.solid_is_high ? 1.0 : -1.0;
  const bool from_skin = first.hounsfield && level < 0.0;  // to water
  const double full = from_skin ? 0.0 : rounded(level + 0.05 * span * towards_solid, span);
  const double extreme = first.solid_is_high ? std::max(values.max, full) : std::min(values.min, full);
  const double beyond = rounded(extreme + span * towards_solid, span);
  out += "\n[[mode]]\n" + mode_head("inside", "viscosity", field);
  out += reasoned("drag_ns_per_m = 1.0", "a stroke of 0.1 m/s within costs 0.1 N: one feels what is solid and what is not");
  out += reasoned("strength_n = 0.05", "and a hand that rests within is held a little, too");
  if (faint == level) {
    out += reasoned("mask = [" + ramp(field, level, full, beyond, 1.0) + "]",
                    from_skin ? "none in air, all of it in soft tissue" : "none outside of the first level");
  } else {
    const auto list = first.solid_is_high ? points({{faint, 0}, {level, 0.5}, {full, 1}, {beyond, 1}})
                                          : points({{beyond, 1}, {full, 1}, {level, 0.5}, {faint, 0}});
    out += reasoned("mask = [{of = " + toml_string(field) + ", points = " + list + "}]",
                    "so little is solid that a hand would search for it: half of the drag comes before the surface does");
  }
  constexpr std::pair<const char*, const char*> colors[] = {{"#e8b899", "#f4efe0"}, {"#9ecae1", "#e69f00"}};
  const auto& [outer, inner] = colors[first.hounsfield ? 0 : 1];
  for (std::size_t n = 0; n < first.levels.size(); ++n) {
    const bool last = n + 1 == first.levels.size();
    const bool bony = first.hounsfield && first.levels[n].value > 0.0;
    out += surface_layer(field, first.levels[n].value, n > 0 || bony ? inner : outer, last ? (n > 0 ? 1.0 : 0.6) : 0.35,
                         "the level '" + first.levels[n].name + "', for pictures");
  }
  return out;
}

std::string labels_line(const LabelMap& map) {
  std::string entries;
  for (std::size_t n = 0; n < std::min(map.labels.size(), most_labels); ++n) {
    entries += (n > 0 ? ", " : "") + label_name(map.labels[n].value) + " = " + with_digits(map.labels[n].value, 17);
  }
  const std::size_t all = map.labels.size();
  return reasoned("labels = {" + entries + "}",
                  (all > most_labels ? "the " + std::to_string(most_labels) + " largest of " + std::to_string(all) + " labels"
                                     : "all labels") +
                      " but the background, " + with_digits(map.background, 17) + "; rename them as you like, here and below");
}

std::string label_modes(const std::string& volume, const std::string& field, const Statistics& values, const LabelMap& map) {
  constexpr const char* colors[] = {"#e69f00", "#56b4e9", "#009e73", "#cc79a7", "#d55e00", "#0072b2"};
  std::int64_t all = 0;
  for (const Label& label : map.labels) all += label.voxels;
  std::string out, layers;
  for (std::size_t n = 0; n < std::min(map.labels.size(), most_labels); ++n) {
    const Label& label = map.labels[n];
    const std::string name = label_name(label.value), of = volume + "." + name;
    out += "[[mode]]\n" + mode_head(name.c_str(), "surface_and_friction", of);
    out += friction_line();
    out += "\n[[mode.level]]\nname = " + toml_string(name) + "\n";
    out +=
        reasoned("value = 0.5", "half way from what is outside (0) to the label (1), which is " +
                                    percent(static_cast<double>(label.voxels) / static_cast<double>(all)) + " of all labels");
    out +=
        reasoned("strength_n = 0.8", "gives way, so that one gets to what lies behind; where three labels meet, 2.4 N") + "\n";
    layers += surface_layer(of, 0.5, colors[n], map.labels.size() == 1 ? 1.0 : 0.4, "the label's surface, for pictures");
  }
  out += "[[mode]]\n" + mode_head("inside", "viscosity", field);
  out += reasoned("drag_ns_per_m = 1.0", "a stroke of 0.1 m/s within costs 0.1 N: one feels what is labelled and what is not");
  out += reasoned("strength_n = 0.05", "and a hand that rests within is held a little, too");
  const double b = map.background, low = std::min(values.min, b) - 1.0, high = std::max(values.max, b) + 1.0;
  const auto list = points({{low, 1}, {b - 0.75, 1}, {b - 0.25, 0}, {b + 0.25, 0}, {b + 0.75, 1}, {high, 1}});
  out += reasoned("mask = [{of = " + toml_string(field) + ", points = " + list + "}]",
                  "none in the background, " + with_digits(b, 17));
  return out + layers;
}

std::string flow_modes(const Volume& volume, const SceneNames& names, const std::vector<Statistics>& values,
                       const FlowPlaces& flow) {
  const std::size_t felt = names.used.front();
  const std::string field = names.of(felt), speed = "magnitude(" + field + ")";
  const FirstFlow& speeds = flow.speeds;
  // Between voxels of unit vectors the length of the mean says how well they agree (docs/scene.md, Axes).
  const double empty = speeds.directions ? 0.3 : speeds.empty, moderate = speeds.directions ? 0.7 : speeds.moderate;
  const double beyond = rounded(2.0 * values[felt].max, values[felt].max);
  const std::string unit = volume.fields[felt].unit.empty() ? "" : " " + volume.fields[felt].unit;

  std::string where, why_where;  // one more mask, where there is noise
  if (flow.signal) {
    const Statistics& signal = values[flow.signal->field];
    where =
        ramp(names.of(flow.signal->field), flow.signal->from, flow.signal->full, rounded(2.0 * signal.max, signal.max), 1.0);
    why_where = flow.noisy ? "only where the signal is: in air the vectors are noise" : "only where the signal is";
  } else if (flow.noisy) {
    where = ramp("coherence(" + field + ")", coherence_of_noise, coherence_of_flow, 2.0, 1.0);
    why_where =
        "not where vectors are at odds with those around them, as " + percent(flow.noisy_share) + " of what moves: noise";
  }

  std::string out = reasoned("[[mode]]", "free along the flow, held across it");
  out += mode_head("stream", "follow", field);
  out += reasoned("strength_n = " + ramp(speed, empty, moderate, beyond, 1.2),
                  speeds.directions
                      ? "where neighbours disagree (0.3 of their length is left) there is no rail"
                      : "from 5 % of the fast part (99.5 % of " + std::string(flow.noisy ? "what is no noise" : "all") +
                            " is slower than " + with_digits(speeds.fast, 3) + unit + ") to the median of what moves");
  if (!where.empty()) out += reasoned("mask = [" + where + "]", why_where);

  out += "\n" + reasoned("[[mode]]", speeds.directions ? "thick where there are directions"
                                                       : "thick where it flows: one feels where the flow is");
  out += mode_head("fluid", "viscosity", field);
  out += reasoned("drag_ns_per_m = 1.0", "a stroke of 0.1 m/s costs 0.1 N");
  out += reasoned("mask = [" + ramp(speed, 0.5 * empty, empty, beyond, 1.0) + (where.empty() ? "" : ", " + where) + "]",
                  where.empty() ? "not where the field is empty" : "not where the field is empty; " + why_where);

  if (const auto& signal = flow.signal) {
    out += "\n" + reasoned("[[mode]]", "what gives a signal and does not flow: a hand finds its way by it");
    out += mode_head("tissue", "viscosity", names.of(signal->field));
    out += reasoned("drag_ns_per_m = 0.5", "half as thick as what flows, which adds its own");
    out += reasoned("mask = [" + where + "]", "parts the signal best (Otsu) from what gives none");
  }
  if (const auto& v = flow.vortices) {
    out += "\n" + reasoned("[[mode]]", "drawn onto the core of a vortex and held there, free along it");
    out += mode_head("vortex", "vortex_line", field);
    out += reasoned("strength_n = " + ramp("q(" + field + ")", v->from, v->full, rounded(4.0 * v->most, v->most), 1.2),
                    v->by_noise
                        ? "from 20 times the Q of the noise on: nothing where nothing turns"
                        : "from where it turns by a quarter while the stream crosses the data: nothing where nothing turns");
    if (v->coherence_from > 0.0)
      out += reasoned("mask = [" + ramp("coherence(" + field + ")", v->coherence_from, v->coherence_full, 2.0, 1.0) + "]",
                      "not beside walls, where Q is high and vectors change from one to the next");
  }
  out += "\n[[view.layer]]\nshow = \"streamlines\"\nfield = " + toml_string(field) + "\n";
  if (const auto& v = flow.vortices)
    out +=
        surface_layer("q(" + field + ")", v->full, "#cc79a7", 0.5, "the vortices, where the pull onto their core has set in");
  if (const auto& signal = flow.signal)
    out += surface_layer(names.of(signal->field), signal->full, "#d98880", 0.2, "what gives a signal");
  return out;
}

}  // namespace palpa::detail
