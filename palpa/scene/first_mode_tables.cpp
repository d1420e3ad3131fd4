#include "palpa/scene/first_mode_tables.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>

#include "palpa/base/wording.h"
#include "palpa/scene/first_scene_lines.h"

namespace palpa::detail {
namespace {

std::string points(std::initializer_list<std::pair<double, double>> list) {
  std::string all;
  for (const auto& [value, result] : list) {
    all += (all.empty() ? "[" : ", [") + toml_number(value) + ", " + toml_number(result) + "]";
  }
  return "[" + all + "]";
}

/// 0 up to `zero_at`, `result` from `full_at` to `beyond`, which lies outside of all values.
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
                        opacity < 1.0 ? "translucent" : "opaque");
}

std::string mode_head(const char* name, const char* type, const std::string& field) {
  return std::string("name = \"") + name + "\"\ntype = \"" + type + "\"\nfield = " + toml_string(field) + "\n";
}

/// 0.1, between the lining of a bowel (0.007 to 0.054 under steel: Lyle et al. 2013) and dry skin (above 0.2, 0.5 as a rule:
/// Derler and Gerhardt 2012). More would hide the shape of a surface from a hand gliding over it.
std::string friction_line() {
  return reasoned("friction_coefficient = 0.1",
                  "a smooth wall: sliding costs a tenth of the pressure; wet tissue 0.01 to 0.05, dry skin 0.2 to 0.5");
}

// [1] Most labels with a mode of their own. More: time of each tick and memory, and more colours are needed below; fewer: parts
// that are worth feeling are left out.
constexpr std::size_t most_labels = 6;

std::string label_name(double value) {
  std::string name = value < 0.0 ? "label_minus_" : "label_";
  return name + with_digits(std::abs(value), 17);
}

/// [N/m] Of a level that yields before it breaks; its source is in a comment of the scene and in docs/modes.
constexpr double soft_n_per_m = 300.0;

std::string level_tables(const std::vector<FirstLevel>& levels) {
  std::string out;
  for (const FirstLevel& level : levels) {
    out += "\n[[mode.level]]\nname = " + toml_string(level.name) + "\n";
    out += reasoned("value = " + toml_number(level.value), level.why_value);
    out += reasoned("strength_n = " + toml_number(level.strength_n), level.why_strength);
    if (level.soft)
      out += reasoned("stiffness_n_per_m = " + toml_number(soft_n_per_m),
                      "pressed in by up to " + size_words({level.strength_n / soft_n_per_m}) +
                          " of hand, then it breaks: a level to get through; a harder one below is felt through it");
  }
  return out;
}

/// Strength of a material: that of a level from half way to it on, zero before the first. Breaks nowhere.
std::string material_strength(const std::string& field, const Statistics& values, const FirstLevels& first) {
  const double span = values.max - values.min, sign = first.solid_is_high ? 1.0 : -1.0;
  // [1] Of the values' span, over which a strength rises. More: levels run into one another; less: a step, which releases a
  // hand like a break.
  constexpr double edge = 0.04;
  std::vector<std::pair<double, double>> curve;
  double before_n = 0.0, last = 0.0;
  for (std::size_t n = 0; n < first.levels.size(); ++n) {
    const FirstLevel& level = first.levels[n];
    double half = 0.5 * edge * span;
    for (const std::size_t beside : {n - 1, n + 1}) {
      if (beside < first.levels.size()) half = std::min(half, 0.4 * std::abs(first.levels[beside].value - level.value));
    }
    curve.emplace_back(rounded(level.value - sign * half, span), before_n);
    curve.emplace_back(last = rounded(level.value + sign * half, span), level.strength_n);
    before_n = level.strength_n;
  }
  const double extreme = first.solid_is_high ? std::max(values.max, last) : std::min(values.min, last);
  curve.emplace_back(rounded(extreme + span * sign, span), before_n);
  if (!first.solid_is_high) std::ranges::reverse(curve);
  std::string list;
  for (const auto& [value, strength] : curve)
    list += (list.empty() ? "[" : ", [") + toml_number(value) + ", " + toml_number(strength) + "]";
  std::string out = reasoned("strength_n = {of = " + toml_string(field) + ", points = [" + list + "]}",
                             "a material: every value yields at its own strength, as tissue does, instead of bursting");
  for (const FirstLevel& level : first.levels) {
    out += "# " + with_digits(level.strength_n, 3) + " N from " + with_digits(level.value, 4) + " on: it " + level.why_value +
           "; " + level.why_strength + "\n";
  }
  return out;
}

/// [N] Strengths of a flow. Together with the drag of 0.4 m/s they stay under the force limit.
constexpr double rail_n = 0.9, push_n = 0.3, pull_n = 1.0, vessel_n = 0.5;

/// A mask, and its reason; empty: none.
struct Where {
  std::string mask, why;
};

/// Mask of possible flow: on the fluid's side of a wall, where there is a signal, or where vectors agree.
Where where_it_flows(const SceneNames& names, const std::vector<Statistics>& values, const FlowPlaces& flow) {
  const std::string field = names.of(names.used.front());
  const auto beyond = [&](std::size_t of) { return rounded(2.0 * values[of].max, values[of].max); };
  if (const auto& wall = flow.wall) {
    const Statistics& v = values[wall->field];
    const double far = wall->fluid_is_high() ? v.max + (v.max - v.min) : v.min - (v.max - v.min);
    return {ramp(names.of(wall->field), wall->level, wall->fluid, rounded(far, v.max - v.min), 1.0), "only in the fluid"};
  }
  if (const auto& signal = flow.signal)
    return {ramp(names.of(signal->field), signal->from, signal->full, beyond(signal->field), 1.0),
            flow.noisy ? "only where the signal is: in air the vectors are noise" : "only where the signal is"};
  if (flow.noisy && !flow.in_octaves)
    return {ramp("coherence(" + field + ")", coherence_of_noise, coherence_of_flow, 2.0, 1.0),
            "not where vectors are at odds with those around them, as " + percent(flow.noisy_share) + " of what moves: noise"};
  return {};
}

std::string mask_line(const Where& where) {
  return where.mask.empty() ? std::string() : reasoned("mask = [" + where.mask + "]", where.why);
}

/// Rails where neighbours agree: between voxels of unit vectors the length of the mean measures the agreement.
std::string direction_rails(const std::string& field, const std::string& speed, double beyond) {
  return reasoned("[[mode]]", "free along the directions, held across them") + mode_head("stream", "follow", field) +
         reasoned("strength_n = " + ramp(speed, 0.3, 0.7, beyond, 1.2),
                  "where neighbours disagree (0.3 of their length is left) there is no rail");
}

/// Noise that no mask leaves out.
std::string noise_comment(const FlowPlaces& flow, const Where& where) {
  if (!flow.in_octaves || !flow.noisy || !where.mask.empty()) return {};
  return "# " + percent(flow.noisy_share) +
         " of what moves is noise, which nothing leaves out: a volume larger than memory has no coherence()\n";
}

/// Command that writes the curl of a flow in octaves, as a comment; none for a file of several frames, of which none is
/// derived.
std::string curl_comment(const Volume& volume, std::size_t flow) {
  if (volume.frames > 1) return {};
  const auto is_plain = [](const std::string& name) {
    return std::ranges::all_of(name, [](unsigned char c) {
      return std::isalnum(c) || std::string_view("/._-+").find(static_cast<char>(c)) != std::string_view::npos;
    });
  };
  const std::string store = volume.request ? volume.request->files.front().string() : "", array = array_of(volume, flow);
  return "# palpa prepare " + (store.empty() || !is_plain(store) ? "STORE" : store) +
         " --derive curl=" + (is_plain(array) ? array : "FIELD") +
         " writes its curl: then rails are suggested only where it turns\n";
}

/// Rails along a flow in octaves without its curl.
std::string plain_rails(const std::string& field, const std::string& speed, const FlowPlaces& flow, double beyond,
                        const Where& where, const std::string& curl_command) {
  std::string out = reasoned("[[mode]]", "free along the flow, held across it");
  out += mode_head("stream", "follow", field);
  out += reasoned("strength_n = " + ramp(speed, flow.speeds.empty, flow.speeds.moderate, beyond, rail_n),
                  "wherever it moves, all of it from the median on: a volume larger than memory has no curl() to follow");
  return out + curl_command + noise_comment(flow, where) + mask_line(where) + "\n";
}

/// Variations of a flow as rails along it, and the flow as a push, which lets a hand feel its direction.
/// \param curl  name of its curl  \param curl_command  comment without one
std::string stream_modes(const std::string& field, const std::string& speed, const std::string& curl, const FlowPlaces& flow,
                         double beyond, const Where& where, const std::string& curl_command) {
  const FirstFlow& speeds = flow.speeds;
  const std::optional<Turning>& turning = flow.turning;
  const bool lacks_curl = flow.in_octaves && !flow.curl;
  std::string out = lacks_curl ? plain_rails(field, speed, flow, beyond, where, curl_command) : std::string();
  if (turning) {
    out += reasoned("[[mode]]", "free along the flow, held across it where it turns or shears; a uniform stream has no rail");
    out += mode_head("stream", "follow", field);
    out += reasoned("strength_n = " + ramp("magnitude(" + curl + ")", turning->from, turning->full,
                                           rounded(4.0 * turning->most, turning->most), rail_n),
                    "from where it turns by a quarter while the stream crosses the data to the median of what turns faster");
    out += noise_comment(flow, where) + mask_line(where) + "\n";
  }
  out += reasoned("[[mode]]", "carried along by the flow: upstream costs more than downstream; it drives an idle hand");
  out += mode_head("current", "vector_force", field);
  out += reasoned("strength_n = {of = " + toml_string(speed) + ", points = " +
                      points({{speeds.empty, 0},
                              {speeds.moderate, 0.5 * push_n},
                              {std::max(speeds.fast, 1.01 * speeds.moderate), push_n},
                              {beyond, push_n}}) +
                      "}",
                  "half of it at the median of what moves, all of it where 0.5 % are faster");
  return out + mask_line(where);
}

/// The wall of a fluid given by a 0/1 field.
std::string wall_mode(const SceneNames& names, const Wall& wall) {
  const bool solid_is_high = wall.around == wall.fluid_is_high();
  std::string out = "\n" + reasoned("[[mode]]", wall.around ? "the wall around the flow, felt from outside: a press gets in"
                                                            : "the body in the stream: it holds");
  out += mode_head("wall", "surface_and_friction", names.of(wall.field));
  out += reasoned(std::string("solid = ") + (solid_is_high ? "\"high\"" : "\"low\""),
                  wall.around ? "one comes from outside of the flow" : "where nothing flows");
  out += friction_line() + "\n[[mode.level]]\nname = \"wall\"\n";
  out += reasoned("value = " + toml_number(wall.level), "half way between fluid and what is none");
  if (!wall.around)
    return out + reasoned("strength_n = " + toml_number(holding_n), "above max_force_n: it cannot be pressed through");
  return out +
         reasoned("strength_n = " + toml_number(vessel_n), "gives way to a light press, so that the flow can be reached") +
         reasoned("stiffness_n_per_m = " + toml_number(soft_n_per_m),
                  "pressed in by up to " + size_words({vessel_n / soft_n_per_m}) + " of hand, then one is within");
}

std::string vortex_mode(const std::string& field, const Vortices& v) {
  std::string out =
      "\n" + reasoned("[[mode]]", "attracted to the vortex core line and held there, free along it; it drives an idle hand");
  out += mode_head("vortex", "vortex_line", field);
  out +=
      reasoned("strength_n = " + ramp("q(" + field + ")", v.from, v.full, rounded(4.0 * v.most, v.most), pull_n),
               v.by_noise ? "from 20 times the Q of the noise on: nothing where nothing turns"
                          : "from where it turns by a quarter while the stream crosses the data: nothing where nothing turns");
  if (v.coherence_from > 0.0)
    out += reasoned("mask = [" + ramp("coherence(" + field + ")", v.coherence_from, v.coherence_full, 2.0, 1.0) + "]",
                    "not beside walls, where Q is high and vectors change from one to the next");
  return out;
}

std::string flow_layers(const SceneNames& names, const std::string& field, const FlowPlaces& flow) {
  std::string out = "\n[[view.layer]]\nshow = \"streamlines\"\nfield = " + toml_string(field) + "\n";
  if (const auto& v = flow.vortices)
    out +=
        surface_layer("q(" + field + ")", v->full, "#cc79a7", 0.5, "the vortices, where the pull onto their core has set in");
  if (const auto& signal = flow.signal)
    out += surface_layer(names.of(signal->field), signal->full, "#d98880", 0.2, "where the signal is");
  if (const auto& wall = flow.wall)
    out += surface_layer(names.of(wall->field), wall->level, wall->around ? "#d98880" : "#c3c9cf", wall->around ? 0.2 : 1.0,
                         wall->around ? "the wall around the flow" : "the body in the stream");
  return out;
}

}  // namespace

std::string surface_modes(const std::string& field, const Statistics& values, const FirstLevels& first, double faint) {
  const double span = values.max - values.min;
  std::string out = "[[mode]]\n" + mode_head("surface", "surface_and_friction", field);
  out += reasoned(std::string("solid = ") + (first.solid_is_high ? "\"high\"" : "\"low\""), first.why_solid);
  out += friction_line();
  out += first.tissue ? material_strength(field, values, first) : level_tables(first.levels);
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

std::vector<std::string> label_names(const LabelMap& map, const std::vector<std::pair<std::string, double>>& given,
                                     const std::vector<std::string>& taken) {
  std::vector<std::string> names, all = taken;
  for (const Label& label : map.labels) {
    const auto said = std::ranges::find(given, label.value, &std::pair<std::string, double>::second);
    const std::string plain = label_name(label.value);
    std::string name = said == given.end() ? plain : plain_word(said->first, plain);
    if (std::ranges::find(all, name) != all.end()) name += "_" + with_digits(label.value, 17);
    names.push_back(name), all.push_back(name);
  }
  return names;
}

std::string labels_line(const LabelMap& map, const std::vector<std::string>& names) {
  std::string entries;
  for (std::size_t n = 0; n < std::min(map.labels.size(), most_labels); ++n) {
    entries += (n > 0 ? ", " : "") + names[n] + " = " + with_digits(map.labels[n].value, 17);
  }
  const std::size_t all = map.labels.size();
  return reasoned("labels = {" + entries + "}",
                  (all > most_labels ? "the " + std::to_string(most_labels) + " largest of " + std::to_string(all) + " labels"
                                     : "all labels") +
                      " but the background, " + with_digits(map.background, 17) + "; rename them as you like, here and below");
}

std::string label_modes(const std::string& volume, const std::string& field, const Statistics& values, const LabelMap& map,
                        const std::vector<std::string>& names) {
  constexpr const char* colors[] = {"#e69f00", "#56b4e9", "#009e73", "#cc79a7", "#d55e00", "#0072b2"};
  std::int64_t all = 0;
  for (const Label& label : map.labels) all += label.voxels;
  std::string out, layers;
  for (std::size_t n = 0; n < std::min(map.labels.size(), most_labels); ++n) {
    const Label& label = map.labels[n];
    const std::string &name = names[n], of = volume + "." + name;
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
  const double empty = speeds.directions ? 0.3 : speeds.empty;
  const double beyond = rounded(2.0 * values[felt].max, values[felt].max);
  const std::string unit = volume.fields[felt].unit.empty() ? "" : " " + volume.fields[felt].unit;
  const Where where = where_it_flows(names, values, flow);

  const std::string curl = flow.curl ? names.of(*flow.curl) : "curl(" + field + ")";
  std::string out = speeds.directions ? direction_rails(field, speed, beyond) + mask_line(where)
                                      : stream_modes(field, speed, curl, flow, beyond, where, curl_comment(volume, felt));
  out += "\n" + reasoned("[[mode]]", speeds.directions ? "viscous where there are directions"
                                                       : "viscous inside the flow: its extent can be felt");
  out += mode_head("fluid", "viscosity", field);
  out += reasoned("drag_ns_per_m = 1.0", "a stroke of 0.1 m/s costs 0.1 N");
  out += reasoned(
      "mask = [" + ramp(speed, 0.5 * empty, empty, beyond, 1.0) + (where.mask.empty() ? "" : ", " + where.mask) + "]",
      (speeds.directions ? std::string("not where the field is empty")
                         : "from 5 % of the fast part on (99.5 % of " + std::string(flow.noisy ? "what is no noise" : "all") +
                               " is slower than " + with_digits(speeds.fast, 3) + unit + ")") +
          (where.why.empty() ? "" : "; " + where.why));
  if (const auto& signal = flow.signal) {
    out += "\n" + reasoned("[[mode]]", "a signal without flow: a landmark for the hand");
    out += mode_head("tissue", "viscosity", names.of(signal->field));
    out += reasoned("drag_ns_per_m = 0.5", "half as thick as what flows, which adds its own");
    out += reasoned("mask = [" + where.mask + "]", "parts the signal best (Otsu) from what gives none");
  }
  if (flow.wall) out += wall_mode(names, *flow.wall);
  if (flow.vortices) out += vortex_mode(field, *flow.vortices);
  return out + flow_layers(names, field, flow);
}

}  // namespace palpa::detail
