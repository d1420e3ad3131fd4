#include "palpa/scene/first_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "palpa/core/load_error.h"
#include "palpa/scene/field_name.h"
#include "palpa/scene/first_levels.h"
#include "palpa/scene/reach.h"
#include "palpa/scene/request_toml.h"
#include "palpa/scene/wording.h"

namespace palpa {
namespace {

using detail::toml_number;
using detail::toml_string;

constexpr double reach_m = 0.15;            // of the hand: what `fit` makes of a volume's longest side
constexpr double behind_surface_m = 0.015;  // of the hand: a hand about its middle is as often inside as outside
constexpr double wanted_share = 0.5;        // of the middle of the reach that can be felt
constexpr std::size_t comment_at = 40;      // column

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

std::string with_digits(double value, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

/// The field to feel, and how a scene names it.
struct Felt {
  const VolumeField& field;
  const Statistics& values;
  std::string name;  ///< as a plain word
};

/// A name that scenes can write: what is no letter, digit, '_' or '-' becomes '_'.
std::string plain_word(const std::string& name, const std::string& otherwise) {
  if (detail::is_plain_word(name)) return name;
  std::string word;
  for (const char c : name) word += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return detail::is_plain_word(word) ? word : otherwise;
}

std::string volume_table(const Volume& volume, const VolumeRequest& request, const Felt& felt) {
  std::string out = "[volume.data]\n";
  out += detail::file_line(request);
  const Vec3 size_m = volume.bounds_m().size_m();
  if (!volume.length_unit.empty() && (volume.length_unit_assumed || !request.length_unit.empty())) {
    const std::string size =
        with_digits(size_m.x, 3) + " x " + with_digits(size_m.y, 3) + " x " + with_digits(size_m.z, 3) + " m";
    out += line("length_unit = " + toml_string(volume.length_unit),
                volume.length_unit_assumed
                    ? "ASSUMED, the file says none: the data are then " + size + "; correct it if they are not"
                    : "as asked for: the data are " + size);
  }
  if (volume.frames > 1) {
    const int frame = std::max(request.frame, 0);
    out += line("frame = " + std::to_string(frame),
                "of " + std::to_string(volume.frames) + "; frame_period_s in its place feels all of them, as time goes");
  }
  out += detail::asked_for(request);
  if (!request.as.empty()) out += line("as = " + toml_string(request.as), "its three frames are the components of one vector");
  const auto asked = std::find_if(request.fields.begin(), request.fields.end(),
                                  [&](const auto& field) { return field.name == felt.field.name; });
  const bool others = volume.fields.size() > 1;
  if (asked != request.fields.end()) {
    out += line("fields = {" + detail::field_entry(*asked) + "}", "as asked for");
  } else if (others || felt.name != felt.field.name) {
    out += line("fields = {" + detail::field_entry({felt.name, felt.field.name, ""}) + "}",
                others ? "one of " + std::to_string(volume.fields.size()) + " in the file: the others need not be in memory"
                       : "what the file calls it is no plain word");
  }
  return out;
}

/// The hand's place in the world. \param start_m  [m] its middle, just below the object's surface; none: the reach's
std::string workspace_table(const Volume& volume, const detail::Reach& reach, const std::optional<Vec3>& start_m) {
  std::string out = "[workspace]\n";
  const double span_m = largest_component(volume.bounds_m().size_m());
  if (reach.whole) {
    out += line("fit = \"data\"", "all of it: its longest side becomes 0.15 m of hand");
  } else {
    out += line("scale = " + toml_number(detail::rounded(reach.side_m / reach_m, reach.side_m / reach_m)),
                "0.15 m of hand are " + with_digits(reach.side_m, 3) + " m of the data, whose longest side is " +
                    with_digits(span_m, 3) + " m: so wide, the middle of the reach has " + with_digits(100.0 * reach.share, 2) +
                    " % that can be felt");
  }
  if (!reach.whole || start_m) {
    const Vec3 at_m = start_m.value_or(reach.centre_m);
    const auto rounded = [&](double m) { return toml_number(detail::rounded(m, span_m)); };
    out += line("center = [" + rounded(at_m.x) + ", " + rounded(at_m.y) + ", " + rounded(at_m.z) + "]",
                start_m ? "15 mm of hand below the surface that one meets, coming from the user" : "where most can be felt");
  }
  if (volume.medical_frame) {
    out += line("towards_user = \"anterior\"", "the patient's front faces the user,");
    out += line("up = \"superior\"", "the head is up");
  } else {
    out += line("towards_user = \"+z\"", "the file does not say where its axes point: its z comes towards the user,");
    out += line("up = \"+y\"", "its y is up; turn them if that is wrong");
  }
  return out;
}

/// A function that is 0 on one side of an edge and `result` on the other; `beyond` is outside of all values.
std::string ramp(const std::string& of, double zero_at, double full_at, double beyond, double result) {
  return "{of = " + toml_string(of) + ", points = " +
         (zero_at < full_at ? points({{zero_at, 0}, {full_at, result}, {beyond, result}})
                            : points({{beyond, result}, {full_at, result}, {zero_at, 0}})) +
         "}";
}

std::string surface_modes(const Felt& felt, const detail::FirstLevels& first) {
  const double span = felt.values.max - felt.values.min;
  std::string out = "[[mode]]\nname = \"surface\"\ntype = \"surface_and_friction\"\nfield = \"data\"\n";
  out += line(std::string("solid = ") + (first.solid_is_high ? "\"high\"" : "\"low\""), first.why_solid);
  out += line("friction_coefficient = 0.1", "a smooth wall: sliding costs a tenth of the pressure");
  for (const detail::FirstLevel& level : first.levels) {
    out += "\n[[mode.level]]\nname = " + toml_string(level.name) + "\n";
    out += line("value = " + toml_number(level.value), level.why_value);
    out += line("strength_n = " + toml_number(level.strength_n), level.why_strength);
  }
  const double level = first.levels.front().value;
  const double towards_solid = first.solid_is_high ? 1.0 : -1.0;
  const bool from_skin = first.hounsfield && level < 0.0;  // to water
  const double full = from_skin ? 0.0 : detail::rounded(level + 0.05 * span * towards_solid, span);
  const double extreme = first.solid_is_high ? std::max(felt.values.max, full) : std::min(felt.values.min, full);
  const double beyond = detail::rounded(extreme + span * towards_solid, span);
  out += "\n[[mode]]\nname = \"inside\"\ntype = \"viscosity\"\nfield = \"data\"\n";
  out += line("drag_ns_per_m = 1.0", "a stroke of 0.1 m/s within costs 0.1 N: one feels what is solid and what is not");
  out += line("mask = [" + ramp("data", level, full, beyond, 1.0) + "]",
              from_skin ? "none in air, all of it in soft tissue" : "none outside of the first level");
  return out;
}

std::string flow_modes(const Felt& felt, const detail::FirstFlow& flow) {
  const std::string speed = "magnitude(data)";
  // Between voxels of unit vectors the length says how well they agree (docs/scene.md, Axes).
  const double empty = flow.directions ? 0.3 : flow.empty, moderate = flow.directions ? 0.7 : flow.moderate;
  const double beyond = detail::rounded(2.0 * felt.values.max, felt.values.max);
  const std::string unit = felt.field.unit.empty() ? "" : " " + felt.field.unit;
  std::string out = line("[[mode]]", "free along the flow, held across it");
  out += "name = \"stream\"\ntype = \"follow\"\nfield = \"data\"\n";
  out += line("strength_n = " + ramp(speed, empty, moderate, beyond, 1.2),
              flow.directions ? "where neighbours disagree (0.3 of their length is left) there is no rail"
                              : "from 5 % of the fast part (99.5 % of all is slower than " + with_digits(flow.fast, 3) + unit +
                                    ") to the median of what moves");
  out += "\n" + line("[[mode]]", flow.directions ? "thick where there are directions"
                                                 : "thick where it flows: one feels where the flow is");
  out += "name = \"fluid\"\ntype = \"viscosity\"\nfield = \"data\"\n";
  out += line("drag_ns_per_m = 1.0", "a stroke of 0.1 m/s costs 0.1 N");
  out += line("mask = [" + ramp(speed, 0.5 * empty, empty, beyond, 1.0) + "]", "not where the field is empty");
  return out;
}

}  // namespace

std::optional<std::size_t> field_to_feel(const Volume& volume, const std::vector<Statistics>& values) {
  for (const int components : {3, 1}) {
    for (std::size_t f = 0; f < volume.fields.size(); ++f) {
      if (volume.fields[f].field->components() != components || values[f].counted == 0) continue;
      if (values[f].max > (components == 3 ? 0.0 : values[f].min)) return f;
    }
  }
  return std::nullopt;
}

std::string first_scene(const Volume& volume, const VolumeRequest& request) {
  std::vector<Statistics> values;
  for (const VolumeField& field : volume.fields) values.push_back(statistics(*field.field));
  const auto number = field_to_feel(volume, values);
  if (!number) throw LoadError("has no field that varies; there is nothing to feel");
  const bool is_flow = volume.fields[*number].field->components() == 3;
  const Felt felt{volume.fields[*number], values[*number], plain_word(volume.fields[*number].name, is_flow ? "flow" : "value")};
  const Field& field = *felt.field.field;

  std::string modes, title;
  detail::Reach reach;
  std::optional<Vec3> start_m;
  bool directions = false;
  if (is_flow) {
    const detail::FirstFlow flow = detail::first_flow(felt.values);
    directions = flow.directions;
    title = directions ? "A first touch: rails along directions" : "A first touch: a flow as rails, thick where it flows";
    modes = flow_modes(felt, flow);
    reach = detail::reach_with(
        volume.bounds_m(), [&](const Vec3& x) { return norm(field.vector(x).value) > flow.empty; }, wanted_share);
  } else {
    const detail::FirstLevels first = detail::first_levels(field, felt.values, felt.field.unit);
    if (first.levels.empty()) throw LoadError("has no two classes of values; there is no surface to feel");
    title = !first.hounsfield          ? "A first touch: surfaces between classes of values"
            : first.levels.size() == 2 ? "A first touch of a CT scan: skin gives way, bone holds"
                                       : "A first touch of a CT scan: " + first.levels.front().name;
    modes = surface_modes(felt, first);
    const double level = first.levels.front().value;
    const auto solid = [&](const Vec3& x) {
      const ScalarSample s = field.scalar(x);
      return s.inside && (s.value >= level) == first.solid_is_high;
    };
    reach = detail::reach_with(volume.bounds_m(), solid, wanted_share);
    const Vec3 towards_user = volume.medical_frame ? Vec3{0, -1, 0} : Vec3{0, 0, 1};
    const Vec3 met_m = detail::surface_before(reach, volume.bounds_m(), towards_user, solid);
    start_m = met_m - (reach.side_m * behind_surface_m / reach_m) * towards_user;
  }

  std::string out = "# Suggested by palpa info --scene. Behind each number stands why it is so: change what feels wrong.\n";
  out += "palpa = 1\ntitle = " + toml_string(title) + "\n\n[coupling]\n";
  out += line("stiffness_n_per_m = 500", "what desktop devices hold without humming");
  out += line("damping_ns_per_m = 0.2", "calms the hand a little at a surface");
  out += line("max_force_n = 3.3",
              "what small devices can give; all strengths below, friction and the drag of 0.4 m/s stay under it");
  out += "\n" + volume_table(volume, request, felt);
  if (directions) out += line("sign = \"none\"", "every vector has length 1: directions, whose sign means nothing");
  if (directions && request.components_along == "index")
    out +=
        "# components_along: along the axes of the grid, as FSL writes directions; \"file\" takes the world's, which mirrors "
        "them\n";
  out += "\n" + workspace_table(volume, reach, start_m) + "\n" + modes;
  return out;
}

}  // namespace palpa
