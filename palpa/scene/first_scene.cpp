#include "palpa/scene/first_scene.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "palpa/base/load_error.h"
#include "palpa/base/wording.h"
#include "palpa/data/halton.h"
#include "palpa/data/labels.h"
#include "palpa/data/octave_parts.h"
#include "palpa/scene/first_flow.h"
#include "palpa/scene/first_levels.h"
#include "palpa/scene/first_mode_tables.h"
#include "palpa/scene/first_object.h"
#include "palpa/scene/first_scene_lines.h"
#include "palpa/scene/first_volume_table.h"
#include "palpa/scene/first_workspace_table.h"

namespace palpa {
namespace {

using detail::reasoned;
using detail::toml_string;

// [1] Share of the solid in the object's parts; the table of a scanner is a tenth. More: the table belongs to the object; less:
// limbs are left out.
constexpr double enough = 0.85;
// [1] Share of its box in the object, below which a hand would search for it (an ellipsoid fills half). Then drag begins before
// the surface, in the second share of the box. More: drag around compact objects, or nearly everywhere; less: sparse objects
// are hard to find.
constexpr double sparse = 0.35;
constexpr double felt_part = 0.5;

bool contains(const Box& box, const Vec3& x) {
  return x.x >= box.low_m.x && x.y >= box.low_m.y && x.z >= box.low_m.z && x.x <= box.high_m.x && x.y <= box.high_m.y &&
         x.z <= box.high_m.z;
}

/// Whether a field is a velocity by name: preferred to others, such as a momentum, because it flows and rotates.
bool is_velocity(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name == "u" || name == "v" || name.starts_with("vel") || name.starts_with("wind");
}

/// Contents of a first scene.
struct Draft {
  std::string title, filter, modes;
  bool holds = false;  // one of its levels cannot be pressed through
  detail::Object object;
  detail::CloseUp close;
  double lying_at_y = 0.0;  // position of a patient's table; see facing_of
  bool directions = false;  // vectors whose sign has no meaning
};

std::string title_of(const detail::FlowPlaces& flow) {
  if (flow.speeds.directions) return "A first touch: rails along directions";
  std::string title = "A first touch of a flow: it carries the hand along";
  if (flow.turning) title += ", rails where it turns";
  if (flow.in_octaves && !flow.curl) title += ", rails along it";
  if (flow.vortices) title += ", a pull near the cores of its vortices";
  if (flow.wall)
    title += flow.wall->around ? ", a wall around it that gives way when pressed" : ", a body in it that holds when touched";
  return title;
}

Draft draft_of_flow(const Volume& volume, const std::vector<Statistics>& values, std::size_t number,
                    const detail::Lattice& lattice, detail::SceneNames& names) {
  const detail::FlowPlaces flow = detail::flow_places(lattice, volume, number, detail::first_flow(values[number]), values);
  if (flow.signal) names.used.push_back(flow.signal->field);
  if (flow.wall) names.used.push_back(flow.wall->field);
  if (flow.curl && flow.turning) names.used.push_back(*flow.curl);
  Draft draft;
  draft.directions = flow.speeds.directions && !flow.in_octaves;  // without a sign they are read as a whole
  draft.title = title_of(flow);
  draft.holds = flow.wall && !flow.wall->around;
  draft.modes = detail::flow_modes(volume, names, values, flow);
  draft.filter = detail::filter_of_flow(volume);
  draft.object = flow.object;
  if (flow.vortices) draft.close = {flow.vortices->core_m, 0.0, "the strongest vortex"};
  return draft;
}

Draft draft_of_labels(const Field& field, const Statistics& values, const LabelMap& map, std::size_t number,
                      const detail::Lattice& lattice, detail::SceneNames& names,
                      const std::vector<std::pair<std::string, double>>& said) {
  names.only_one = false;
  const std::vector<std::string> labels = detail::label_names(map, said, names.fields);
  Draft draft;
  draft.title = "A first touch of labels: a surface each";
  draft.filter = reasoned("filter = \"smooth\"", "evens out the steps from voxel to voxel; \"trilinear\" keeps them") +
                 detail::labels_line(map, labels);
  std::vector<char> labelled(lattice.size(), 0);
  for (std::size_t n = 0; n < lattice.size(); ++n) {
    const ScalarSample s = field.scalar(lattice.middle_m(n));
    labelled[n] = s.inside && std::abs(s.value - map.background) >= 0.5;
  }
  draft.object = detail::largest_parts(lattice, std::move(labelled), 1.0);
  draft.modes = detail::label_modes(names.volume, names.of(number), values, map, labels);
  return draft;
}

/// Whether the data are of a part of a body: in a patient frame, or in a format of scanners.
bool is_scan(const Volume& volume) {
  return volume.medical_frame || volume.format == "nrrd" || volume.format == "metaimage" || volume.format == "nifti" ||
         volume.format == "dicom";
}

/// The field, or of a field in octaves blocks of octave 0, whose values are not means.
std::vector<FieldPtr> voxels_of(const FieldPtr& field) {
  const Octaves* octaves = octaves_of(*field);
  return octaves ? octave_sample(*octaves) : std::vector<FieldPtr>{field};
}

/// Values of a sample within a box.
std::vector<double> values_in(const std::vector<FieldPtr>& sample, const Box& box) {
  constexpr int places = 128;  // [1] of a block. More: slower; fewer: less certain
  std::vector<double> values;
  for (const FieldPtr& block : sample) {
    for (int n = 1; n <= places; ++n) {
      const Vec3 at_m = detail::halton(n, block->bounds_m());
      const ScalarSample s = contains(box, at_m) ? block->scalar(at_m) : ScalarSample{};
      if (s.inside) values.push_back(s.value);
    }
  }
  return values;
}

Draft draft_of_surfaces(const Volume& volume, const Statistics& values, std::size_t number, const detail::Lattice& lattice,
                        const detail::SceneNames& names) {
  const VolumeField& of = volume.fields[number];
  const Field& field = *of.field;
  const std::vector<FieldPtr> sample = voxels_of(of.field);
  const auto labels = octaves_of(field) ? detail::level_around_labels(sample, values, of.unit, volume.modality) : std::nullopt;
  const detail::FirstLevels first =
      labels ? *labels : detail::first_levels(field, sample, values, of.unit, volume.modality, is_scan(volume));
  if (first.levels.empty()) throw LoadError("has no two classes of values; there is no surface to feel");
  Draft draft;
  draft.title = labels         ? "A first touch of labels: one surface around all of them"
                : first.tissue ? "A first touch: a material that yields to a press, firmer from one class of values to the next"
                : !first.hounsfield        ? "A first touch: surfaces between classes of values"
                : first.levels.size() == 2 ? "A first touch of a CT scan: skin gives way, bone holds"
                                           : "A first touch of a CT scan: " + first.levels.front().name;
  draft.filter = detail::filter_of_surfaces(field, sample, first.levels, first.solid_is_high);
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
    if (octaves_of(field)) in_box = values_in(sample, draft.object.box_m);
    for (std::size_t n = 0; n < lattice.size() && !octaves_of(field); ++n) {
      if (here[n] && contains(draft.object.box_m, lattice.middle_m(n))) in_box.push_back(*here[n]);
    }
    faint = detail::faint_value(std::move(in_box), first, felt_part);
  }
  draft.modes = detail::surface_modes(names.of(number), values, first, faint);
  draft.holds = std::ranges::any_of(first.levels, &detail::FirstLevel::holds);
  return draft;
}

std::string coupling_keys(const Draft& draft) {
  std::string out =
      reasoned("stiffness_n_per_m = 500", "stable on touch, omega, falcon and inverse3; palpa check tests your device");
  out += reasoned("damping_ns_per_m = 0.2", "calms the hand a little at a surface");
  out += reasoned("max_force_n = " + detail::toml_number(detail::first_max_force_n),
                  draft.holds ? "the force of small devices; all that gives way, friction and the drag of 0.4 m/s stay under "
                                "it, what holds is above it"
                              : "the force of small devices; all strengths below, friction and the drag of 0.4 m/s stay under "
                                "it");
  if (draft.holds)
    out += reasoned("# impact_ns_per_m = 5",
                    "contact transient at levels that hold: a spring alone feels like foam; remove the first # to feel it");
  return out;
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

std::string first_scene(const Volume& volume, const VolumeRequest& request, const FirstSceneOptions& options) {
  std::vector<Statistics> values;
  for (const VolumeField& field : volume.fields) values.push_back(statistics(*field.field));
  const auto number = field_to_feel(volume, values);
  if (!number) throw LoadError("has no field that varies; there is nothing to feel");
  const Field& field = *volume.fields[*number].field;
  const bool is_flow = field.components() == 3;
  detail::SceneNames names = detail::names_of(volume, request, *number);
  if (!options.volume.empty()) names.volume = options.volume;
  const Volume* const beside = is_flow ? options.beside : nullptr;
  Volume all = volume;  // with the fields beside it
  std::optional<detail::SceneNames> names_beside;
  if (beside) {
    for (const VolumeField& of : beside->fields) all.fields.push_back(of), values.push_back(statistics(*of.field));
    names_beside = detail::names_beside(*beside, names);
  }

  const detail::Lattice lattice(volume.bounds_m());
  const LabelMap map =
      is_flow ? LabelMap{} : label_map_unless_said(field, values[*number], volume.fields[*number].unit, volume.modality);
  Draft draft = is_flow               ? draft_of_flow(all, values, *number, lattice, names)
                : !map.labels.empty() ? draft_of_labels(field, values[*number], map, *number, lattice, names, options.labels)
                                      : draft_of_surfaces(volume, values[*number], *number, lattice, names);

  const Box data_m = volume.bounds_m();  // the lattice may reach beyond it
  const auto within = [&](const Vec3& x) {
    return Vec3{std::clamp(x.x, data_m.low_m.x, data_m.high_m.x), std::clamp(x.y, data_m.low_m.y, data_m.high_m.y),
                std::clamp(x.z, data_m.low_m.z, data_m.high_m.z)};
  };
  detail::Object& object = draft.object;
  object.box_m = {within(object.box_m.low_m), within(object.box_m.high_m)};
  const detail::Facing facing = detail::facing_of(volume, is_flow, object.box_m.size_m(), draft.lying_at_y);
  detail::CloseUp& close = draft.close;
  close.side_m = largest_component(object.box_m.size_m()) / 3.0;
  if (close.what.empty()) {
    const auto met = is_flow ? std::nullopt : detail::met_from(lattice, object, object.box_m.centre_m(), facing.towards_m);
    close.what = met ? "the first contact, coming from the user" : "the region with most contact";
    close.centre_m = met ? *met : detail::fullest_cube_m(lattice, object, close.side_m);
  }

  std::string out =
      "# Suggested by palpa info --scene. The comment behind each number gives its reason: change what feels wrong.\n";
  out += "palpa = 1\ntitle = " + toml_string(draft.title) + "\n\n[coupling]\n";
  out += coupling_keys(draft);
  out += "\n" + detail::volume_table(volume, request, names, options.folder) + draft.filter;
  if (draft.directions) out += reasoned("sign = \"none\"", "every vector has length 1: directions, whose sign means nothing");
  if (draft.directions && request.components_along == "index")
    out +=
        "# components_along: along the axes of the grid, as FSL writes directions; \"file\" takes the world's, which mirrors "
        "them\n";
  if (names_beside && std::ranges::any_of(names.used, [&](std::size_t f) { return f >= volume.fields.size(); })) {
    for (const std::size_t f : names.used)
      if (f >= volume.fields.size()) names_beside->used.push_back(f - volume.fields.size());
    out += "\n" + detail::volume_table(*beside, *beside->request, *names_beside, options.folder);
  }
  out +=
      "\n" + detail::workspace_table(volume, field, names, object.box_m, facing, close, lattice.cell_m()) + "\n" + draft.modes;
  return out;
}

}  // namespace palpa
