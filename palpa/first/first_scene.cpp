#include "palpa/first/first_scene.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "palpa/core/load_error.h"
#include "palpa/core/printed.h"
#include "palpa/first/first_flow.h"
#include "palpa/first/first_levels.h"
#include "palpa/first/object.h"
#include "palpa/grid/filter.h"
#include "palpa/scene/to_toml.h"
#include "palpa/survey/labels.h"
#include "palpa/survey/thin_parts.h"
#include "palpa/toml/wording.h"
#include "palpa/volume/field_name.h"
#include "palpa/volume/volume.h"

namespace palpa {
namespace {

using detail::toml_number;
using detail::toml_string;

// Length of the hand's motion over the longest side of the object; sentences below say it as well. More: beyond the reach of
// small devices; less: details become too small for a hand.
constexpr double reach_m = 0.15;
// [1] Share of all that is solid which the object's parts hold; the table of a scanner is a tenth. More: the table belongs to
// the object; less: limbs are left out.
constexpr double enough = 0.85;
// [1] Share of its box that is object, below which a hand would search for it (an ellipsoid fills half). Then drag begins
// before the surface, in the second share of the box. More: drag around compact objects, or nearly everywhere; less: sparse
// objects are hard to find.
constexpr double sparse = 0.35;
constexpr double felt_part = 0.5;
constexpr std::size_t comment_at = 40;  // column in which reasons begin

/// `key = value` and why, the reason in a column of its own.
std::string line(const std::string& what, const std::string& why) {
  const std::string gap(what.size() < comment_at ? comment_at - what.size() : 2, ' ');
  return what + gap + "# " + why + "\n";
}

std::string points(std::initializer_list<std::pair<double, double>> list) {
  std::string all;
  for (const auto& [value, result] : list) {
    all += (all.empty() ? "[" : ", [") + toml_number(value) + ", " + toml_number(result) + "]";
  }
  return "[" + all + "]";
}

std::string with_digits(double value, int digits) { return detail::text("%.*g", digits, value); }

std::string percent(double share) { return with_digits(100.0 * share, 2) + " %"; }

/// "182 x 230 x 151 mm", in the unit in which the longest has one to three digits before the point.
std::string size_words(std::initializer_list<double> lengths_m) {
  constexpr std::pair<const char*, double> units[] = {{"km", 1e3}, {"m", 1.0}, {"mm", 1e-3}, {"um", 1e-6}, {"nm", 1e-9}};
  const double longest_m = std::max(lengths_m);
  const auto* unit = std::ranges::find_if(units, [&](const auto& u) { return longest_m >= u.second; });
  if (unit == std::end(units)) unit = std::end(units) - 1;
  std::string all;
  for (const double length_m : lengths_m) {
    const double length = length_m / unit->second;
    all += (all.empty() ? "" : " x ") + with_digits(length, length < 1000.0 ? 3 : 4);
  }
  return all + " " + unit->first;
}
std::string size_words(const Vec3& size_m) { return size_words({size_m.x, size_m.y, size_m.z}); }

/// A name that scenes can write: what is no letter, digit, '_' or '-' becomes '_'.
std::string plain_word(const std::string& name, const std::string& otherwise) {
  if (detail::is_plain_word(name)) return name;
  std::string word;
  for (const char c : name) word += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return detail::is_plain_word(word) ? word : otherwise;
}

/// A volume is named after its file; not DICOM, whose folders are often named after patients.
std::string volume_name(const Volume& volume, const VolumeRequest& request, bool is_flow) {
  const std::string kind = is_flow ? "flow" : volume.medical_frame ? "scan" : "data";
  if (volume.format == "dicom") {
    std::string modality;
    for (const char c : volume.modality) modality += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return plain_word(modality, "scan");
  }
  std::string stem = place_in_file(request.files.front()).file.filename().string();
  if (const std::size_t dot = stem.find('.'); dot != 0 && dot != std::string::npos) stem.resize(dot);
  return stem.size() > 24 ? kind : plain_word(stem, kind);
}

/// How a scene names what it feels.
struct Names {
  std::string volume;
  std::vector<std::string> fields;  ///< of the volume, as plain words
  std::vector<std::size_t> used;    ///< their numbers, the felt one first
  bool only_one = false;            ///< the volume has no other

  std::string of(std::size_t field) const {
    const bool says_nothing = fields[field] == "value" || fields[field] == "vector";
    return only_one && says_nothing ? volume : volume + "." + fields[field];
  }
};

Names names_of(const Volume& volume, const VolumeRequest& request, std::size_t felt) {
  Names names;
  const bool is_flow = volume.fields[felt].field->components() == 3;
  names.volume = volume_name(volume, request, is_flow);
  for (const VolumeField& field : volume.fields) {
    std::string word = plain_word(field.name, field.field->components() == 3 ? "flow" : "value");
    while (std::ranges::find(names.fields, word) != names.fields.end()) word += "_";
    names.fields.push_back(word);
  }
  names.used = {felt};
  names.only_one = volume.fields.size() == 1;
  return names;
}

/// What lies between the voxels of a scan, and what that costs.
std::string filter_line(const Field& field, const std::vector<detail::FirstLevel>& levels, bool solid_is_high) {
  const GridView* grid = grid_behind(field);
  if (!grid) return {};
  const FilterChoice felt = default_filter(*grid);
  if (felt.filter != Filter::smooth) return line("filter = \"" + std::string(name_of(felt.filter)) + "\"", felt.why);
  double lost = 0.0;
  for (const detail::FirstLevel& level : levels) {
    const ThinParts parts = thin_parts(field, level.value, solid_is_high ? SolidSide::high : SolidSide::low);
    lost = std::max(lost, parts.thin_share() * parts.lost_share());
  }
  return line("filter = \"smooth\"",
              felt.why + std::string("; loses ") +
                  (lost < 1e-3 ? std::string("next to nothing") : percent(lost) + " of what is solid, thinner than 2 voxels") +
                  "; \"trilinear\" keeps all, with facets");
}

/// The filter of a flow whose numbers are fractions: trilinear, because a smoothing one would blur the edges of the scalar
/// fields that masks read.
std::string flow_filter_line(const Volume& volume) {
  const bool any_scalar = std::ranges::any_of(volume.fields, [](const VolumeField& f) { return f.field->components() == 1; });
  const auto of_fractions = [](const VolumeField& f) {
    const GridView* grid = grid_behind(*f.field);
    return grid && (grid->voxels.type == VoxelType::float32 || grid->voxels.type == VoxelType::float64);
  };
  if (!any_scalar || !std::ranges::all_of(volume.fields, of_fractions)) return {};
  return line("filter = \"trilinear\"", "rails follow directions, which do not jump between voxels; masks keep their edges");
}

std::string volume_table(const Volume& volume, const VolumeRequest& request, const Names& names) {
  std::string out = "[volume." + names.volume + "]\n";
  const std::vector<detail::Said> how = detail::said(request);
  out += "file = " + detail::value_of(how, "file") + "\n";
  const Vec3 size_m = volume.bounds_m().size_m();
  if (!volume.length_unit.empty() && (volume.length_unit_assumed || !request.length_unit.empty())) {
    out += line("length_unit = " + toml_string(volume.length_unit),
                volume.length_unit_assumed
                    ? "ASSUMED, the file says none: the data are then " + size_words(size_m) + "; correct it if they are not"
                    : "as asked for: the data are " + size_words(size_m));
  }
  if (volume.frames > 1) {
    const int frame = std::max(request.frame, 0);
    out += line("frame = " + std::to_string(frame),
                "of " + std::to_string(volume.frames) + "; frame_period_s in its place feels all of them, as time goes");
  }
  // These keys are written elsewhere, each with its reason; all others are written as the user gave them.
  constexpr std::array<std::string_view, 5> explained{"file", "length_unit", "fields", "frame", "as"};
  for (const auto& [key, value] : how) {
    if (std::ranges::find(explained, key) == explained.end()) out += key + " = " + value + "\n";
  }
  if (!request.as.empty()) out += line("as = " + toml_string(request.as), "its three frames are the components of one vector");

  VolumeRequest named;
  bool asked_for = false, joined = false, renamed = false;
  for (const std::size_t f : names.used) {
    const std::string& array = volume.fields[f].name;
    const auto asked =
        std::find_if(request.fields.begin(), request.fields.end(), [&](const auto& field) { return field.name == array; });
    asked_for = asked_for || asked != request.fields.end();
    joined = joined || (asked != request.fields.end() && !asked->arrays.empty());
    renamed = renamed || names.fields[f] != array;
    named.fields.push_back(asked != request.fields.end() ? *asked : VolumeRequest::FieldRequest{names.fields[f], array, ""});
  }
  const std::size_t all = volume.fields.size(), used = names.used.size();
  if (asked_for || all > used || renamed) {
    out += line("fields = " + detail::value_of(detail::said(named), "fields"),
                joined      ? "one vector, whose components the file has as arrays of their own"
                : asked_for ? "as asked for"
                : all > used
                    ? std::to_string(used) + " of " + std::to_string(all) + " in the file: the others need not be in memory"
                    : "what the file calls it is no plain word");
  }
  return out;
}

/// From which side the hand comes, and why.
struct View {
  std::string towards_user, up;
  std::string why_towards_user, why_up;
  Vec3 towards_m;  ///< [1] that direction of the world
};

/// \param lying_at_y  [1] where along y, from -1 to 1, lies what is solid but no part of the object; 0: nowhere
View view_of(const Volume& volume, bool is_flow, const Vec3& size_m, double lying_at_y) {
  // [1] Height over the next longer side, below which a scan is a slab of slices, not a part of a body. More: parts of bodies
  // are seen from the feet; less: slabs are seen edge-on.
  constexpr double flat = 0.6;
  if (volume.medical_frame && size_m.z < flat * std::min(size_m.x, size_m.y))
    return {"inferior",
            "anterior",
            "a slab of slices, seen as they are read: from the feet,",
            "the patient's front is up",
            {0, 0, -1}};
  if (volume.medical_frame)
    return {"anterior", "superior", "the patient's front faces the user,", "the head is up", {0, -1, 0}};
  const std::string turn = "; turn both if that is wrong";
  const bool is_scan = !is_flow && (volume.format == "nrrd" || volume.format == "metaimage" || volume.format == "nifti");
  if (is_scan && lying_at_y < -0.5)
    return {"+y",
            "+z",
            "the file does not say where its axes point: what looks like a head rest or a table lies at its low y,",
            "so its y is the front, and its z is taken as up" + turn,
            {0, 1, 0}};
  if (is_scan)
    return {"-y",
            "+z",
            "the file does not say where its axes point: taken as most scanners have them,",
            "y to the back and z to the head" + turn,
            {0, -1, 0}};
  const double sides_m[] = {size_m.x, size_m.y, size_m.z};
  // The shortest side, z if no other one is clearly shorter.
  const int shortest = sides_m[2] <= 1.1 * std::min(sides_m[0], sides_m[1]) ? 2 : sides_m[1] <= sides_m[0] ? 1 : 0;
  const bool is_cube = largest_component(size_m) <= 1.1 * std::min({sides_m[0], sides_m[1], sides_m[2]});
  // Flat data of this width are air or sea, and are seen from above. Less: large machines are taken for weather; more: small
  // parts of weather are not.
  constexpr double wide_m = 1e4;
  const bool is_weather = largest_component(size_m) >= wide_m && 2.0 * sides_m[shortest] < largest_component(size_m);
  const std::string face = is_weather ? "seen from above, as on a map: the flat side of the data faces the user,"
                           : is_cube  ? "the file does not say where its axes point: its z comes towards the user,"
                                      : "the largest side of the object faces the user,";
  if (shortest == 2) return {"+z", "+y", face, "its x is to the right, its y is up" + turn, {0, 0, 1}};
  if (shortest == 0) return {"+x", "+z", face, "its y is to the right, its z is up" + turn, {1, 0, 0}};
  if (is_weather) return {"+y", "-z", face, "its x is to the right, its y is the height" + turn, {0, 1, 0}};
  return {"-y", "+z", face, "its x is to the right, its z is up" + turn, {0, -1, 0}};
}

/// A closer look at a part of the data.
struct CloseUp {
  Vec3 centre_m;
  double side_m = 0.0;
  std::string what;
};

std::string workspace_table(const Volume& volume, const Names& names, const Box& object_m, const View& view,
                            const CloseUp& close, double cell_m) {
  const Box data_m = volume.bounds_m();
  const Vec3 size_m = object_m.size_m();
  const double longest_m = largest_component(size_m), span_m = largest_component(data_m.size_m());
  const bool whole = largest_component(object_m.low_m - data_m.low_m) <= 1.5 * cell_m &&
                     largest_component(object_m.high_m - data_m.high_m) <= 1.5 * cell_m;
  const auto scale = [&](double side_m) {
    return "scale = " + toml_number(detail::rounded(side_m / reach_m, side_m / reach_m));
  };
  const auto centre = [&](const Vec3& at_m) {
    const auto rounded = [&](double m) { return toml_number(detail::rounded(m, 0.1 * span_m)); };
    return "center = [" + rounded(at_m.x) + ", " + rounded(at_m.y) + ", " + rounded(at_m.z) + "]";
  };
  std::string out = "[workspace]\n";
  if (whole) {
    out += line("fit = " + toml_string(names.volume),
                "all of it, " + size_words(size_m) + ": its longest side becomes 0.15 m of hand");
  } else {
    out += line(scale(longest_m), "all of the object, " + size_words(size_m) + " of the data's " + size_words(data_m.size_m()) +
                                      ": its longest side becomes 0.15 m of hand");
    out += line(centre(object_m.centre_m()), "its middle");
  }
  out += line("towards_user = " + toml_string(view.towards_user), view.why_towards_user);
  out += line("up = " + toml_string(view.up), view.why_up);
  const std::string instead = whole ? "fit" : "scale and center";
  out += "# A close-up of " + close.what + ", " + size_words({close.side_m}) + " of it: these two lines instead of " + instead +
         ".\n";
  out += line("# " + scale(close.side_m), "0.15 m of hand are " + size_words({close.side_m}) + " of the data");
  out += line("# " + centre(close.centre_m), close.what);
  return out;
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
  out += line("level = " + toml_number(level), why);
  return out +
         line("colors = {points = [[" + toml_number(level) + ", " + toml_string(color) + ", " + toml_number(opacity) + "]]}",
              opacity < 1.0 ? "one sees through it" : "opaque");
}

std::string mode_head(const char* name, const char* type, const std::string& field) {
  return std::string("name = \"") + name + "\"\ntype = \"" + type + "\"\nfield = " + toml_string(field) + "\n";
}

bool contains(const Box& box, const Vec3& x) {
  return x.x >= box.low_m.x && x.y >= box.low_m.y && x.z >= box.low_m.z && x.x <= box.high_m.x && x.y <= box.high_m.y &&
         x.z <= box.high_m.z;
}

/// 0.1, between the lining of a bowel (0.007 to 0.054 under steel: Lyle et al. 2013) and dry skin (above 0.2, 0.5 as a rule:
/// Derler and Gerhardt 2012). More friction would hide the shape of a surface, which a hand finds by gliding over it.
std::string friction_line() {
  return line("friction_coefficient = 0.1",
              "a smooth wall: sliding costs a tenth of the pressure; wet tissue 0.01 to 0.05, dry skin 0.2 to 0.5");
}

/// \param faint  where drag begins: of a sparse object a value that half of its box is beyond; else the first level
std::string surface_modes(const std::string& field, const Statistics& values, const detail::FirstLevels& first, double faint) {
  const double span = values.max - values.min;
  std::string out = "[[mode]]\n" + mode_head("surface", "surface_and_friction", field);
  out += line(std::string("solid = ") + (first.solid_is_high ? "\"high\"" : "\"low\""), first.why_solid);
  out += friction_line();
  for (const detail::FirstLevel& level : first.levels) {
    out += "\n[[mode.level]]\nname = " + toml_string(level.name) + "\n";
    out += line("value = " + toml_number(level.value), level.why_value);
    out += line("strength_n = " + toml_number(level.strength_n), level.why_strength);
    if (level.soft)
      out += line("stiffness_n_per_m = 300",
                  "and gives way before, like flesh under a finger: what is harder below is felt through it");
  }
  const double level = first.levels.front().value;
  const double towards_solid = first.solid_is_high ? 1.0 : -1.0;
  const bool from_skin = first.hounsfield && level < 0.0;  // to water
  const double full = from_skin ? 0.0 : detail::rounded(level + 0.05 * span * towards_solid, span);
  const double extreme = first.solid_is_high ? std::max(values.max, full) : std::min(values.min, full);
  const double beyond = detail::rounded(extreme + span * towards_solid, span);
  out += "\n[[mode]]\n" + mode_head("inside", "viscosity", field);
  out += line("drag_ns_per_m = 1.0", "a stroke of 0.1 m/s within costs 0.1 N: one feels what is solid and what is not");
  out += line("strength_n = 0.05", "and a hand that rests within is held a little, too");
  if (faint == level) {
    out += line("mask = [" + ramp(field, level, full, beyond, 1.0) + "]",
                from_skin ? "none in air, all of it in soft tissue" : "none outside of the first level");
  } else {
    const auto list = first.solid_is_high ? points({{faint, 0}, {level, 0.5}, {full, 1}, {beyond, 1}})
                                          : points({{beyond, 1}, {full, 1}, {level, 0.5}, {faint, 0}});
    out += line("mask = [{of = " + toml_string(field) + ", points = " + list + "}]",
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

// [1] Labels that get a mode of their own, at most. More: time of each tick and memory, and more colours are needed below;
// fewer: parts that are worth feeling are left out.
constexpr std::size_t most_labels = 6;

/// A label as a scene names it.
std::string label_name(double value) {
  std::string name = value < 0.0 ? "label_minus_" : "label_";
  return name + with_digits(std::abs(value), 17);
}

std::string labels_line(const LabelMap& map) {
  std::string entries;
  for (std::size_t n = 0; n < std::min(map.labels.size(), most_labels); ++n) {
    entries += (n > 0 ? ", " : "") + label_name(map.labels[n].value) + " = " + with_digits(map.labels[n].value, 17);
  }
  const std::size_t all = map.labels.size();
  return line("labels = {" + entries + "}",
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
    out += line("value = 0.5", "half way from what is outside (0) to the label (1), which is " +
                                   percent(static_cast<double>(label.voxels) / static_cast<double>(all)) + " of all labels");
    out += line("strength_n = 0.8", "gives way, so that one gets to what lies behind; where three labels meet, 2.4 N") + "\n";
    layers += surface_layer(of, 0.5, colors[n], map.labels.size() == 1 ? 1.0 : 0.4, "the label's surface, for pictures");
  }
  out += "[[mode]]\n" + mode_head("inside", "viscosity", field);
  out += line("drag_ns_per_m = 1.0", "a stroke of 0.1 m/s within costs 0.1 N: one feels what is labelled and what is not");
  out += line("strength_n = 0.05", "and a hand that rests within is held a little, too");
  const double b = map.background, low = std::min(values.min, b) - 1.0, high = std::max(values.max, b) + 1.0;
  const auto list = points({{low, 1}, {b - 0.75, 1}, {b - 0.25, 0}, {b + 0.25, 0}, {b + 0.75, 1}, {high, 1}});
  out += line("mask = [{of = " + toml_string(field) + ", points = " + list + "}]",
              "none in the background, " + with_digits(b, 17));
  return out + layers;
}

std::string flow_modes(const Volume& volume, const Names& names, const std::vector<Statistics>& values,
                       const detail::FlowPlaces& flow) {
  const std::size_t felt = names.used.front();
  const std::string field = names.of(felt), speed = "magnitude(" + field + ")";
  const detail::FirstFlow& speeds = flow.speeds;
  // Between voxels of unit vectors the length of the mean says how well they agree (docs/scene.md, Axes).
  const double empty = speeds.directions ? 0.3 : speeds.empty, moderate = speeds.directions ? 0.7 : speeds.moderate;
  const double beyond = detail::rounded(2.0 * values[felt].max, values[felt].max);
  const std::string unit = volume.fields[felt].unit.empty() ? "" : " " + volume.fields[felt].unit;

  std::string where, why_where;  // one more mask, where there is noise
  if (flow.signal) {
    const Statistics& signal = values[flow.signal->field];
    where = ramp(names.of(flow.signal->field), flow.signal->from, flow.signal->full,
                 detail::rounded(2.0 * signal.max, signal.max), 1.0);
    why_where = flow.noisy ? "only where the signal is: in air the vectors are noise" : "only where the signal is";
  } else if (flow.noisy) {
    where = ramp("coherence(" + field + ")", detail::coherence_of_noise, detail::coherence_of_flow, 2.0, 1.0);
    why_where =
        "not where vectors are at odds with those around them, as " + percent(flow.noisy_share) + " of what moves: noise";
  }

  std::string out = line("[[mode]]", "free along the flow, held across it");
  out += mode_head("stream", "follow", field);
  out +=
      line("strength_n = " + ramp(speed, empty, moderate, beyond, 1.2),
           speeds.directions ? "where neighbours disagree (0.3 of their length is left) there is no rail"
                             : "from 5 % of the fast part (99.5 % of " + std::string(flow.noisy ? "what is no noise" : "all") +
                                   " is slower than " + with_digits(speeds.fast, 3) + unit + ") to the median of what moves");
  if (!where.empty()) out += line("mask = [" + where + "]", why_where);

  out += "\n" + line("[[mode]]", speeds.directions ? "thick where there are directions"
                                                   : "thick where it flows: one feels where the flow is");
  out += mode_head("fluid", "viscosity", field);
  out += line("drag_ns_per_m = 1.0", "a stroke of 0.1 m/s costs 0.1 N");
  out += line("mask = [" + ramp(speed, 0.5 * empty, empty, beyond, 1.0) + (where.empty() ? "" : ", " + where) + "]",
              where.empty() ? "not where the field is empty" : "not where the field is empty; " + why_where);

  if (const auto& signal = flow.signal) {
    out += "\n" + line("[[mode]]", "what gives a signal and does not flow: a hand finds its way by it");
    out += mode_head("tissue", "viscosity", names.of(signal->field));
    out += line("drag_ns_per_m = 0.5", "half as thick as what flows, which adds its own");
    out += line("mask = [" + where + "]", "parts the signal best (Otsu) from what gives none");
  }
  if (const auto& v = flow.vortices) {
    out += "\n" + line("[[mode]]", "drawn onto the core of a vortex and held there, free along it");
    out += mode_head("vortex", "vortex_line", field);
    out +=
        line("strength_n = " + ramp("q(" + field + ")", v->from, v->full, detail::rounded(4.0 * v->most, v->most), 1.2),
             v->by_noise ? "from 20 times the Q of the noise on: nothing where nothing turns"
                         : "from where it turns by a quarter while the stream crosses the data: nothing where nothing turns");
    if (v->coherence_from > 0.0)
      out += line("mask = [" + ramp("coherence(" + field + ")", v->coherence_from, v->coherence_full, 2.0, 1.0) + "]",
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

/// The label map that a scalar field is; none of Hounsfield units, whatever they look like.
LabelMap scan_of_labels(const Field& field, const Statistics& values, const std::string& unit) {
  return values.whole_numbers && !looks_like_hounsfield(values, unit) ? label_map(field) : LabelMap{};
}

/// Whether a field's name says velocity: it is preferred to others, such as a momentum, because it says what flows and turns.
bool is_velocity(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name == "u" || name == "v" || name.starts_with("vel") || name.starts_with("wind");
}

/// What a first scene says of its data.
struct Draft {
  std::string title, filter, modes;
  detail::Object object;
  CloseUp close;
  double lying_at_y = 0.0;  // where a patient's table is; see view_of
  bool directions = false;  // vectors whose sign means nothing
};

Draft draft_of_flow(const Volume& volume, const std::vector<Statistics>& values, std::size_t number,
                    const detail::Lattice& lattice, Names& names) {
  const detail::FlowPlaces flow = detail::flow_places(lattice, volume, number, detail::first_flow(values[number]), values);
  if (flow.signal) names.used.push_back(flow.signal->field);
  Draft draft;
  draft.directions = flow.speeds.directions;
  draft.title = draft.directions ? "A first touch: rails along directions"
                : flow.vortices
                    ? "A first touch: a flow as rails, thick where it flows, its vortices as rails along their cores"
                    : "A first touch: a flow as rails, thick where it flows";
  draft.modes = flow_modes(volume, names, values, flow);
  draft.filter = flow_filter_line(volume);
  draft.object = flow.object;
  if (flow.vortices) draft.close = {flow.vortices->core_m, 0.0, "the strongest vortex"};
  return draft;
}

Draft draft_of_labels(const Field& field, const Statistics& values, const LabelMap& map, std::size_t number,
                      const detail::Lattice& lattice, Names& names) {
  names.only_one = false;
  Draft draft;
  draft.title = "A first touch of labels: a surface each";
  draft.filter =
      line("filter = \"smooth\"", "evens out the steps from voxel to voxel; \"trilinear\" keeps them") + labels_line(map);
  std::vector<char> labelled(lattice.size(), 0);
  for (std::size_t n = 0; n < lattice.size(); ++n) {
    const ScalarSample s = field.scalar(lattice.middle_m(n));
    labelled[n] = s.inside && std::abs(s.value - map.background) >= 0.5;
  }
  draft.object = detail::largest_parts(lattice, std::move(labelled), 1.0);
  draft.modes = label_modes(names.volume, names.of(number), values, map);
  return draft;
}

Draft draft_of_surfaces(const VolumeField& of, const Statistics& values, std::size_t number, const detail::Lattice& lattice,
                        const Names& names) {
  const Field& field = *of.field;
  const detail::FirstLevels first = detail::first_levels(field, values, of.unit);
  if (first.levels.empty()) throw LoadError("has no two classes of values; there is no surface to feel");
  Draft draft;
  draft.title = !first.hounsfield          ? "A first touch: surfaces between classes of values"
                : first.levels.size() == 2 ? "A first touch of a CT scan: skin gives way, bone holds"
                                           : "A first touch of a CT scan: " + first.levels.front().name;
  draft.filter = filter_line(field, first.levels, first.solid_is_high);
  const double level = first.levels.front().value;
  std::vector<std::optional<double>> here(lattice.size());
  std::vector<char> solid(lattice.size(), 0);
  for (std::size_t n = 0; n < lattice.size(); ++n) {
    const ScalarSample s = field.scalar(lattice.middle_m(n));
    if (!s.inside) continue;
    here[n] = s.value;
    solid[n] = (s.value >= level) == first.solid_is_high;
  }
  draft.object = detail::largest_parts(lattice, solid, enough);
  draft.lying_at_y = first.hounsfield ? detail::beside_at_y(lattice, draft.object, solid) : 0.0;
  double faint = level;
  if (draft.object.share < sparse) {
    std::vector<double> in_box;
    for (std::size_t n = 0; n < lattice.size(); ++n) {
      if (here[n] && contains(draft.object.box_m, lattice.middle_m(n))) in_box.push_back(*here[n]);
    }
    faint = detail::faint_value(std::move(in_box), first, felt_part);
  }
  draft.modes = surface_modes(names.of(number), values, first, faint);
  return draft;
}

}  // namespace

std::optional<std::size_t> field_to_feel(const Volume& volume, const std::vector<Statistics>& values) {
  for (const int components : {3, 1}) {
    std::optional<std::size_t> first;
    for (std::size_t f = 0; f < volume.fields.size(); ++f) {
      if (volume.fields[f].field->components() != components || values[f].counted == 0) continue;
      if (!(values[f].max > (components == 3 ? 0.0 : values[f].min))) continue;
      if (components == 3 && is_velocity(volume.fields[f].name)) return f;
      if (!first) first = f;
    }
    if (first) return first;
  }
  return std::nullopt;
}

std::string first_scene(const Volume& volume, const VolumeRequest& request) {
  std::vector<Statistics> values;
  for (const VolumeField& field : volume.fields) values.push_back(statistics(*field.field));
  const auto number = field_to_feel(volume, values);
  if (!number) throw LoadError("has no field that varies; there is nothing to feel");
  const Field& field = *volume.fields[*number].field;
  const bool is_flow = field.components() == 3;
  Names names = names_of(volume, request, *number);

  const detail::Lattice lattice(volume.bounds_m());
  const LabelMap map = is_flow ? LabelMap{} : scan_of_labels(field, values[*number], volume.fields[*number].unit);
  Draft draft = is_flow               ? draft_of_flow(volume, values, *number, lattice, names)
                : !map.labels.empty() ? draft_of_labels(field, values[*number], map, *number, lattice, names)
                                      : draft_of_surfaces(volume.fields[*number], values[*number], *number, lattice, names);

  const Box data_m = volume.bounds_m();  // the lattice may reach beyond it
  const auto within = [&](const Vec3& x) {
    return Vec3{std::clamp(x.x, data_m.low_m.x, data_m.high_m.x), std::clamp(x.y, data_m.low_m.y, data_m.high_m.y),
                std::clamp(x.z, data_m.low_m.z, data_m.high_m.z)};
  };
  detail::Object& object = draft.object;
  object.box_m = {within(object.box_m.low_m), within(object.box_m.high_m)};
  const View view = view_of(volume, is_flow, object.box_m.size_m(), draft.lying_at_y);
  CloseUp& close = draft.close;
  close.side_m = largest_component(object.box_m.size_m()) / 3.0;
  if (close.what.empty()) {
    const auto met = is_flow ? std::nullopt : detail::met_from(lattice, object, object.box_m.centre_m(), view.towards_m);
    close.what = met ? "what one meets first, coming from the user" : "where most can be felt";
    close.centre_m = met ? *met : detail::fullest_cube_m(lattice, object, close.side_m);
  }

  std::string out = "# Suggested by palpa info --scene. Behind each number stands why it is so: change what feels wrong.\n";
  out += "palpa = 1\ntitle = " + toml_string(draft.title) + "\n\n[coupling]\n";
  out += line("stiffness_n_per_m = 500", "what desktop devices hold without humming");
  out += line("damping_ns_per_m = 0.2", "calms the hand a little at a surface");
  out += line("max_force_n = 3.3",
              "what small devices can give; all strengths below, friction and the drag of 0.4 m/s stay under it");
  out += "\n" + volume_table(volume, request, names) + draft.filter;
  if (draft.directions) out += line("sign = \"none\"", "every vector has length 1: directions, whose sign means nothing");
  if (draft.directions && request.components_along == "index")
    out +=
        "# components_along: along the axes of the grid, as FSL writes directions; \"file\" takes the world's, which mirrors "
        "them\n";
  out += "\n" + workspace_table(volume, names, object.box_m, view, close, lattice.cell_m()) + "\n" + draft.modes;
  return out;
}

}  // namespace palpa
