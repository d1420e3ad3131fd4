#include "scene.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <optional>
#include <sstream>

#include "arrays.h"
#include "interruptible.h"
#include "modes.h"
#include "palpa/base/wording.h"
#include "palpa/data/analytic.h"
#include "palpa/data/filter.h"
#include "palpa/data/length_unit.h"
#include "palpa/file/read_volume.h"
#include "palpa/scene/load_scene.h"
#include "parameters.h"
#include "pickling.h"
#include "python_mode.h"

namespace palpa::python {
namespace {

namespace fs = std::filesystem;

py::tuple box_of(const Box& box) { return py::make_tuple(array_of(box.low_m), array_of(box.high_m)); }

/// Interpolation filter of a field's voxels; None for a field without its own grid.
py::object filter_of(const VolumeField& field) {
  const GridView* const grid = grid_below(*field.field);
  return grid ? py::object(py::str(name_of(grid->filter))) : py::object(py::none());
}

/// Kind of a field, and the voxels and filter of a grid.
std::string format_field(const VolumeField& field) {
  const std::string kind = field.field->components() == 3 ? "vectors" : "scalars";
  const GridView* const grid = grid_below(*field.field);
  if (!grid) return kind;
  const auto& dims = grid->geometry.dims;
  return kind + ", " + std::to_string(dims[0]) + " x " + std::to_string(dims[1]) + " x " + std::to_string(dims[2]) +
         " voxels (x, y, z), filter '" + name_of(grid->filter) + "'";
}

/// A function of the module for a formula with these arguments.
template <class... Arguments, class... Names>
void bind_formula(py::module_& module, const char* name, Volume (*make)(Arguments...), const char* doc, const Names&... names) {
  const auto of = [=](Arguments... given) { return of_formula(name, {given...}, make(given...)); };
  if constexpr (sizeof...(Names) == 0) {
    module.def(name, of, doc);
  } else {
    module.def(name, of, py::kw_only(), names..., doc);
  }
}

void bind_formulas(py::module_& module) {
  bind_formula(module, "plane_field", &plane_field,
               "A half space: signed distance [m] below the plane z = 0, over a cube about the origin.",
               py::arg("size_m") = 0.2);
  bind_formula(module, "sphere_field", &sphere_field, "A ball: radius - |x| [m], positive inside.", py::arg("radius_m") = 0.05);
  bind_formula(module, "bored_block", &bored_block,
               "A half space below z = 0 with a round hole along -z, its rim rounded: signed distance [m] below the surface.",
               py::arg("radius_m") = 5.5e-3, py::arg("depth_m") = 30e-3, py::arg("rim_m") = 1.5e-3);
  bind_formula(module, "head_phantom", &head_phantom, "A head as CT would see it, in HU, in the medical frame.");
  bind_formula(module, "lamb_oseen_vortex", &lamb_oseen_vortex, "A Lamb-Oseen vortex along z: velocity [m/s].",
               py::arg("circulation_m2_per_s") = 0.02, py::arg("core_radius_m") = 0.01);
  bind_formula(module, "burgers_vortex", &burgers_vortex, "A Burgers vortex along z: velocity [m/s].",
               py::arg("circulation_m2_per_s") = 0.02, py::arg("core_radius_m") = 0.01, py::arg("strain_per_s") = 0.2);
  bind_formula(module, "ring_vortex", &ring_vortex,
               "A vortex ring in a closed chamber, at one moment of the heartbeat: velocity [m/s] and signal.",
               py::arg("beat") = 0.25);
  bind_formula(module, "beating_chamber", &beating_chamber, "The same chamber with the heart beating: one beat of 0.8 s.");
  bind_formula(module, "wing_wake", &wing_wake, "The wake of a wing: velocity [m/s] and pressure [m2/s2].");
}

void bind_fields(py::module_& module) {
  py::class_<VolumeField>(module, "Field", "A scalar or vector field, sampled at places of the world [m].")
      .def_readonly("name", &VolumeField::name, "how scenes name it")
      .def_readonly("unit", &VolumeField::unit, "a label; converts nothing")
      .def_property_readonly(
          "components", [](const VolumeField& f) { return f.field->components(); }, "1 or 3")
      .def_property_readonly(
          "spacing_m", [](const VolumeField& f) { return f.field->spacing_m(); },
          "[m] the length over which it may change its course")
      .def_property_readonly(
          "bounds_m", [](const VolumeField& f) { return box_of(f.field->bounds_m()); },
          "[m] low and high corner of a box outside which it has no data")
      .def_property_readonly(
          "value_ranges",
          [](const VolumeField& f) {
            py::list value_ranges;
            for (const ValueRange& e : f.field->value_ranges()) value_ranges.append(py::make_tuple(e.min, e.max));
            return value_ranges;
          },
          "smallest and largest value of each component")
      .def_property_readonly(
          "voxels",
          [](const VolumeField& f) {
            const FieldPtr field = f.field;
            return voxels_of(field);
          },
          "its voxels, indexed [z, y, x] or [z, y, x, component], where they are: not to be written; None of a formula")
      .def_property_readonly(
          "affine_m", [](const VolumeField& f) { return affine_of(*f.field); },
          "[m] from indices (x, y, z) of its voxels to the world, shape (4, 4); None of a formula, and of uneven planes")
      .def_property_readonly(
          "filter", [](const VolumeField& f) { return filter_of(f); },
          "\"trilinear\", \"smooth\" or \"cubic\": how it is felt between its voxels; None of a formula. Of a volume that is "
          "in\n"
          "no scene yet it is \"trilinear\": a scene chooses when it takes it.")
      .def("__repr__",
           [](const VolumeField& f) {
             return "Field('" + f.name + "': " + format_field(f) + (f.unit.empty() ? "" : ", in " + f.unit) + ")";
           })
      .def(
          "__call__", [](const VolumeField& f, const py::object& points_m) { return sample(*f.field, points_m); },
          py::arg("points_m"),
          "Values and gradients at places of the world: on all cores, other threads go on.\n\n"
          "points_m: numbers of shape (..., 3), in metres.\n"
          "Returns (values, gradients): of a scalar field shapes (...) and (..., 3), of a vector field (..., 3) and\n"
          "(..., 3, 3), row = component; gradients per metre. NaN where the field has no data.");
}

void bind_volumes(py::module_& module) {
  py::class_<Volume>(module, "Volume",
                     "A named data set: one or more fields on one grid, or one formula. The voxels are shared.")
      .def("_fields",
           [](const Volume& v) {
             py::dict fields;
             for (const VolumeField& field : v.fields) fields[py::str(field.name)] = field;
             return fields;
           })
      .def_readonly("medical_frame", &Volume::medical_frame,
                    "the world is LPS: x to the patient's left, y to the back, z to the head")
      .def_readonly("format", &Volume::format, "\"dicom\", \"nrrd\", …; \"formula\" or \"grid\" of embedded data and arrays")
      .def_readonly("modality", &Volume::modality, "\"CT\", \"MR\", …; empty if its file does not say it")
      .def_readonly("length_unit", &Volume::length_unit, "of the file, before its lengths became metres")
      .def_readonly("frames", &Volume::frames, "that its file holds")
      .def_readonly("warnings", &Volume::warnings, "what its file leaves open")
      .def_property_readonly(
          "filter", [](const Volume& v) { return v.fields.empty() ? py::object(py::none()) : filter_of(v.fields.front()); },
          "of its first field: see Field.filter")
      .def("__repr__",
           [](const Volume& v) {
             std::string fields;
             for (const VolumeField& f : v.fields)
               fields += (fields.empty() ? "" : "; ") + (f.name.empty() ? format_field(f) : f.name + ": " + format_field(f));
             return "Volume(" + v.format + "; " + fields + ")";
           })
      .def_property_readonly(
          "files",
          [](const Volume& v) {
            std::vector<std::string> paths;
            for (const SourceFile& file : v.files) paths.push_back(file.path);
            return paths;
          },
          "that it was read from")
      .def_property_readonly(
          "bounds_m", [](const Volume& v) { return box_of(v.bounds_m()); }, "[m] low and high corner");
}

void bind_volume_functions(py::module_& module) {
  module.def("read_volume", [](const std::vector<fs::path>& files, const py::dict& how) {
    StructPart part(VolumeRequest{});
    for (const auto& [key, value] : how) set_value(part, key.cast<std::string>(), value);
    VolumeRequest request = part.value();
    request.files = files;
    Volume volume = interruptible(
        [&](const std::atomic<bool>&, std::stop_token stop) { return read_volume(request, {.stop = std::move(stop)}); });
    remember_files(volume);
    return volume;
  });
  module.def(
      "array_volume",
      [](const py::object& array, const py::object& spacing_m, const std::array<double, 9>& axes, const py::object& origin_m,
         const std::optional<std::array<std::vector<double>, 3>>& planes_m, const std::string& unit, bool copy) {
        PlacedArray placed{.planes_m = planes_m};
        const Vec3 s = vector_of(spacing_m, "spacing_m");
        for (const double each_m : {s.x, s.y, s.z}) {
          if (!(each_m > 0.0))
            throw py::value_error("'spacing_m' is " + detail::toml_number(each_m) +
                                  "; it lies above 0, a reversed array has reversed axes");
        }
        for (std::size_t r = 0; r < 3; ++r)
          placed.steps_m.row[r] = {axes[3 * r] * s.x, axes[3 * r + 1] * s.y, axes[3 * r + 2] * s.z};
        if (!origin_m.is_none()) placed.origin_m = vector_of(origin_m, "origin_m");
        return array_volume(array, placed, unit, copy);
      },
      py::arg("array"), py::arg("spacing_m"), py::arg("axes"), py::arg("origin_m"), py::arg("planes_m"), py::arg("unit"),
      py::arg("copy"));
  module.def("in_other_unit", [](Volume volume, double metres_per_unit) {
    volume.files.clear();
    volume.request.reset();
    volume.length_unit.clear();
    return metres_per_unit == 1.0 ? volume : posed(volume, {.scale = metres_per_unit});
  });
  module.def("in_medical_frame", [](Volume volume) {
    volume.medical_frame = true;
    return volume;
  });
  module.def("metres_of_unit", [](const std::string& unit) -> std::optional<double> {
    const auto known = detail::length_unit(unit);
    return known ? std::optional(known->metres) : std::nullopt;
  });
  module.def("joined_volume", [](const std::vector<std::pair<std::string, Volume>>& parts, std::vector<std::string> warnings) {
    Volume joined;
    joined.format = "grid";
    joined.warnings = std::move(warnings);
    for (const auto& [name, part] : parts) {
      joined.fields.push_back(part.fields.front());
      joined.fields.back().name = name;
    }
    return joined;
  });
}

template <class T>
PartPtr options_of(const std::shared_ptr<Scene>& scene, const T& (Scene::*get)() const noexcept) {
  return std::make_shared<OptionsPart<T>>(scene, get);
}

std::optional<Filter> filter_of(const py::object& name) {
  if (name.is_none()) return {};
  const auto word = name.cast<std::string>();
  for (const Filter filter : {Filter::trilinear, Filter::smooth, Filter::cubic}) {
    if (word == name_of(filter)) return filter;
  }
  throw py::value_error("no filter '" + word + "'; there are: trilinear, smooth, cubic");
}

const SceneMode& mode_of(const std::shared_ptr<Scene>& scene, const std::string& name) {
  return SceneModePart(scene, name).mode();
}

std::vector<Mask> masks_of(const py::iterable& masks) {
  std::vector<Mask> all;
  for (const py::handle mask : masks) {
    if (!py::isinstance<Mask>(mask))
      throw py::type_error("'masks' takes a list of palpa.Mask, not of " +
                           mask.get_type().attr("__name__").cast<std::string>());
    all.push_back(mask.cast<Mask>());
  }
  return all;
}

constexpr std::array feet_words{"all", "first"};  // of SceneMode::Feet

std::optional<SceneMode::Feet> feet_of(const py::object& word) {
  if (word.is_none()) return {};
  for (std::size_t n = 0; n < feet_words.size(); ++n) {
    if (py::isinstance<py::str>(word) && word.cast<std::string>() == feet_words[n]) return static_cast<SceneMode::Feet>(n);
  }
  throw py::value_error("'feet' is 'all', 'first' or None, not " +
                        detail::one_line(py::repr(word).cast<std::string>().substr(0, 60)));
}

/// Modes of a scene.
void bind_modes_of(py::class_<Scene, std::shared_ptr<Scene>>& bound) {
  bound
      .def("_mode", [](const std::shared_ptr<Scene>& scene,
                       const std::string& name) { return PartPtr(std::make_shared<SceneModePart>(scene, name)); })
      .def("_mode_names",
           [](const Scene& scene) {
             std::vector<std::string> names;
             for (const SceneMode& mode : scene.modes()) names.push_back(mode.name);
             return names;
           })
      .def("_is_enabled",
           [](const std::shared_ptr<Scene>& scene, const std::string& name) { return mode_of(scene, name).enabled; })
      .def("_enable",
           [](const std::shared_ptr<Scene>& scene, const std::string& name, bool enabled) {
             mode_of(scene, name), scene->edit_mode(name, [&](SceneMode& mode) { mode.enabled = enabled; });
           })
      .def("_feet",
           [](const std::shared_ptr<Scene>& scene, const std::string& name) -> py::object {
             const auto feet = mode_of(scene, name).feet;
             return feet ? py::object(py::str(feet_words[static_cast<std::size_t>(*feet)])) : py::none();
           })
      .def("_set_feet",
           [](const std::shared_ptr<Scene>& scene, const std::string& name, const py::object& feet) {
             mode_of(scene, name), scene->edit_mode(name, [&](SceneMode& mode) { mode.feet = feet_of(feet); });
           })
      .def("_masks",
           [](const std::shared_ptr<Scene>& scene, const std::string& name) {
             py::list all;
             for (const Mask& mask : mode_of(scene, name).masks) all.append(mask);
             return py::tuple(all);
           })
      .def("_set_masks", [](const std::shared_ptr<Scene>& scene, const std::string& name, const py::iterable& masks) {
        mode_of(scene, name), scene->edit_mode(name, [&](SceneMode& mode) { mode.masks = masks_of(masks); });
      });
}

/// Volumes and modes of a scene.
void bind_parts_of(py::class_<Scene, std::shared_ptr<Scene>>& bound) {
  bound
      .def("_add_volume",
           [](Scene& scene, const std::string& name, const Volume& volume, const py::object& filter) {
             const auto by = filter_of(filter);
             Scene copy = scene;
             std::string added;
             {
               const py::gil_scoped_release release;
               added = copy.add(name, volume, {}, by).name;
             }
             scene = std::move(copy);
             return added;
           })
      .def("_add_mode",
           [](Scene& scene, const std::string& name, const PartPtr& mode, const py::iterable& masks, bool enabled,
              const py::object& feet) {
             auto* const own = dynamic_cast<ModePart*>(mode.get());
             auto* const of_scene = dynamic_cast<SceneModePart*>(mode.get());
             if (!own && !of_scene) throw py::type_error("a mode is added to a scene");
             scene.add(detail::CheckedMode(
                 {name, named(own ? own->mode() : of_scene->mode().mode, name), enabled, masks_of(masks), feet_of(feet)},
                 scene.modes().size()));
           })
      .def("_volumes",
           [](const Scene& scene) {
             py::dict volumes;
             for (const SceneVolume& volume : scene.volumes()) volumes[py::str(volume.name)] = volume.volume;
             return volumes;
           })
      .def(
          "remove_mode", [](Scene& scene, const std::string& name) { scene.remove_mode(name); }, py::arg("name"),
          "Takes a mode away; nothing where there is none of this name.");
}

ToolOptions tool_of(const PartPtr& part) {
  if (auto* const own = dynamic_cast<StructPart<ToolOptions>*>(part.get())) return own->value();
  return dynamic_cast<OptionsPart<ToolOptions>&>(*part).value();
}

/// Parts of a scene with a list of parameters, and its hands.
void bind_options_of(py::module_& module, py::class_<Scene, std::shared_ptr<Scene>>& bound) {
  bound.def("_coupling", [](const std::shared_ptr<Scene>& scene) { return options_of(scene, &Scene::coupling); })
      .def("_workspace", [](const std::shared_ptr<Scene>& scene) { return options_of(scene, &Scene::workspace); })
      .def("_time", [](const std::shared_ptr<Scene>& scene) { return options_of(scene, &Scene::time); })
      .def("_tool", [](const std::shared_ptr<Scene>& scene) { return options_of(scene, &Scene::tool); })
      .def("_set_tool", [](Scene& scene, const PartPtr& part) { scene.set(tool_of(part)); });
  bound
      .def("_hands",
           [](const Scene& scene) {
             py::list all;
             for (const SceneHand& hand : scene.hands())
               all.append(py::make_tuple(hand.name, array_of(hand.at_m),
                                         PartPtr(std::make_shared<StructPart<ToolOptions>>(hand.tool))));
             return all;
           })
      .def("_add_hand",
           [](Scene& scene, const std::string& name, const py::object& at_m, const PartPtr& tool) {
             scene.add_hand({name, vector_of(at_m, "at_m"), tool_of(tool)});
           })
      .def("_of_hand", [](const Scene& scene, const std::string& name) { return scene.of_hand(name); })
      .def("_of_hand", [](const Scene& scene, std::size_t number) { return scene.of_hand(number); });
  module.def("new_tool", [] { return PartPtr(std::make_shared<StructPart<ToolOptions>>(ToolOptions{})); });
}

}  // namespace

void bind_scene(py::module_& module) {
  bind_fields(module);
  bind_volumes(module);
  bind_volume_functions(module);
  bind_formulas(module);
  // Base of the Python class `Scene`.
  py::class_<Scene, std::shared_ptr<Scene>> bound(module, "Scene");
  bound.def(py::init<>())
      .def(py::init<const Scene&>())
      .def_readwrite("title", &Scene::title, "what the scene is, in one line")
      .def_property("law", &Scene::law, &Scene::set_law, "name of the law that finds the balance: one of palpa.laws()")
      .def_property(
          "needs", [](const Scene& scene) { return py::tuple(py::cast(scene.needs)); },
          [](Scene& scene, const std::vector<std::string>& needs) { scene.needs = needs; },
          "types of modes that plug-ins must bring");
  bind_options_of(module, bound);
  bind_modes_of(bound);
  bind_parts_of(bound);
  bound
      .def(
          "field",
          [](const Scene& scene, const std::string& name) {
            const Scene copy = scene;
            const py::gil_scoped_release release;
            return copy.field(FieldRef{name});
          },
          py::arg("name"), "The field of this name: 'volume', 'volume.field', or derived from it, 'magnitude(volume.field)'.")
      .def(
          "check",
          [](const Scene& scene) {
            const Scene copy = scene;
            const py::gil_scoped_release release;
            return copy.check();
          },
          "Raises SceneError at the first thing that does not fit together; returns warnings.")
      .def(
          "to_toml", [](const Scene& scene) { return to_toml(scene); }, "The scene as TOML, as `load_scene` reads it.")
      .def(
          "hand_to_world", [](const Scene& scene) { return matrix_of(scene.hand_to_world()); },
          "The map from the hand frame to the world [m], shape (4, 4).")
      .def(
          "__eq__", [](const Scene& a, const Scene& b) { return a == b; }, py::is_operator());

  module.def("load_scene", [](const fs::path& path, const std::vector<fs::path>& data,
                              const std::vector<std::pair<std::string, std::string>>& sets) {
    const SceneOptions options{.data_folders = data, .sets = sets};
    const ModeCatalog modes = known_modes();
    LoadedScene loaded = interruptible([&](const std::atomic<bool>&, std::stop_token stop) {
      return load_scene(path, volume_reader({.stop = std::move(stop)}), modes, options);
    });
    remember_sources(loaded.scene);
    return py::make_tuple(std::move(loaded.scene), loaded.warnings);
  });
}

}  // namespace palpa::python
