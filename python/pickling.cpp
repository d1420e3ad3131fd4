#include "pickling.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <span>
#include <utility>

#include "arrays.h"
#include "interruptible.h"
#include "modes.h"
#include "palpa/base/web_address.h"
#include "palpa/base/wording.h"
#include "palpa/data/analytic.h"
#include "palpa/data/filter.h"
#include "palpa/file/read_volume.h"
#include "parameters.h"
#include "python_mode.h"

namespace palpa::python {
namespace {

/// Source of a field without its filter and poses: a formula, or a field of files.
struct Origin {
  std::string formula;
  std::vector<double> arguments;
  std::size_t index = 0;  // of the formula's field
  std::shared_ptr<const VolumeRequest> request;
  std::vector<SourceFile> files;
  std::string field;

  friend bool operator==(const Origin& a, const Origin& b) {
    return a.formula == b.formula && a.arguments == b.arguments && a.index == b.index && a.request == b.request &&
           a.field == b.field;
  }
};

/// Memory that a field shares with its other filters and poses.
std::shared_ptr<const void> memory_of(const FieldPtr& field) {
  const GridView* const grid = grid_behind(*field);
  return grid ? grid->voxels.data : std::shared_ptr<const void>(field);
}

struct Remembered {
  std::weak_ptr<const void> memory;
  Origin origin;
};
std::map<const void*, Remembered>& origins() {
  static auto& all = *new std::map<const void*, Remembered>;  // never destroyed: fields may outlive the module
  return all;
}

void remember(const FieldPtr& field, const Origin& origin) {
  std::erase_if(origins(), [](const auto& entry) { return entry.second.memory.expired(); });
  const auto memory = memory_of(field);
  const auto [entry, is_new] = origins().try_emplace(memory.get(), Remembered{memory, origin});
  if (!is_new && !(entry->second.origin == origin)) entry->second.origin = {};  // of two fields: neither is known by it
}

FieldPtr below_poses(const FieldPtr& field) {
  if (const PosedView* view = posed_of(*field)) return below_poses(view->field);
  if (const MovingView* view = moving_of(*field)) return below_poses(view->field);
  return field;
}

const Origin* origin_of(const FieldPtr& field) {
  const auto found = origins().find(memory_of(field).get());
  if (found == origins().end() || found->second.memory.expired()) return nullptr;
  const Origin& origin = found->second.origin;
  return origin.request || !origin.formula.empty() ? &origin : nullptr;
}

// ---- fields ----

using Pose = std::array<double, 13>;

Pose numbers_of(const Similarity& pose) {
  Pose numbers{};
  double* to = numbers.data();
  for (const Vec3& row : pose.rotation.row) to = put(to, row);
  *put(to, pose.translation_m) = pose.scale;
  return numbers;
}
Similarity similarity_of(const Pose& n) {
  return {{{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7], n[8]}}}, n[12], {n[9], n[10], n[11]}};
}

py::tuple state_of(const VolumeRequest& request) {
  std::vector<std::string> files;
  for (const auto& file : request.files) files.push_back(detail::absolute_place(file).string());
  return py::make_tuple(files, values_of(std::make_shared<StructPart<VolumeRequest>>(request)));
}
VolumeRequest request_of(const py::handle& state) {
  StructPart part(VolumeRequest{});
  for (const auto& [key, value] : state[py::int_(1)].cast<py::dict>()) {
    const bool says_nothing = value.is_none() || (PySequence_Check(value.ptr()) && py::len(value) == 0);
    if (!says_nothing) set_value(part, key.cast<std::string>(), value);
  }
  VolumeRequest request = part.value();
  for (const auto& file : state[py::int_(0)].cast<std::vector<std::string>>()) request.files.emplace_back(file);
  return request;
}

using FileFacts = std::tuple<std::string, std::uint64_t, std::string>;
std::vector<FileFacts> facts_of(const std::vector<SourceFile>& files) {
  std::vector<FileFacts> facts;
  for (const SourceFile& file : files) facts.emplace_back(file.path, file.bytes, file.sha256.text());
  return facts;
}
std::vector<SourceFile> files_of(const py::handle& facts) {
  std::vector<SourceFile> files;
  for (const auto& [path, bytes, sha256] : facts.cast<std::vector<FileFacts>>()) files.push_back({path, bytes, sha256});
  return files;
}

/// Fields as tuples, and the files that they are read from.
class Writer {
 public:
  py::tuple state_of(const FieldPtr& field) {
    if (const PosedView* view = posed_of(*field)) return py::make_tuple("posed", state_of(view->field), numbers_of(view->pose));
    if (const MovingView* view = moving_of(*field)) {
      std::vector<std::pair<double, Pose>> track;
      for (const TimedPose& pose : view->track) track.emplace_back(pose.time_s, numbers_of(pose.pose));
      return py::make_tuple("moving", state_of(view->field), track, view->per_length);
    }
    if (const SeriesView* view = series_of(*field)) {
      py::list frames;
      for (const FieldPtr& frame : view->frames) frames.append(state_of(frame));
      return py::make_tuple("series", frames, view->period_s, static_cast<int>(view->between_frames));
    }
    const Origin* const origin = origin_of(field);
    if (origin && !origin->formula.empty()) return py::make_tuple("formula", origin->formula, origin->arguments, origin->index);
    const GridView* const grid = grid_behind(*field);
    if (!grid) {
      throw py::type_error(
          "a field that is computed from others, or made by a formula of C++, is not pickled; pickle the scene "
          "that it is of, or put its values into an array");
    }
    const auto filter = static_cast<int>(grid->filter);
    if (origin) return py::make_tuple("file", source(*origin), origin->field, filter, grid->signless);
    const GridGeometry& g = grid->geometry;
    return py::make_tuple("grid", raw_voxels_of(field), g.dims, numbers_of({g.index_to_world_m, 1.0, g.origin_m}), g.planes,
                          grid->scale, grid->offset, filter, grid->signless);
  }
  const py::list& sources() const noexcept { return sources_; }

 private:
  std::size_t source(const Origin& origin) {
    const auto [known, is_new] = numbers_.try_emplace(origin.request.get(), sources_.size());
    if (is_new) sources_.append(py::make_tuple(python::state_of(*origin.request), facts_of(origin.files)));
    return known->second;
  }
  py::list sources_;
  std::map<const VolumeRequest*, std::size_t> numbers_;
};

struct Formula {
  const char* name;
  Volume (*make)(std::span<const double> with);
};
constexpr Formula formulas[] = {
    {"plane_field", [](std::span<const double> with) { return plane_field(with[0]); }},
    {"sphere_field", [](std::span<const double> with) { return sphere_field(with[0]); }},
    {"bored_block", [](std::span<const double> with) { return bored_block(with[0], with[1], with[2]); }},
    {"lamb_oseen_vortex", [](std::span<const double> with) { return lamb_oseen_vortex(with[0], with[1]); }},
    {"burgers_vortex", [](std::span<const double> with) { return burgers_vortex(with[0], with[1], with[2]); }},
    {"ring_vortex", [](std::span<const double> with) { return ring_vortex(with[0]); }},
};

Volume formula(const std::string& name, const std::vector<double>& with) {
  if (with.empty()) {
    if (const AnalyticVolume* embedded = analytic_volume(name)) return of_formula(name, with, embedded->make());
  }
  const auto* const found = std::ranges::find(formulas, name, &Formula::name);
  if (found == std::end(formulas)) throw py::value_error("no formula " + detail::in_quotes(name));
  return of_formula(name, with, found->make(with));
}

/// Fields of their tuples.
class Reader {
 public:
  explicit Reader(py::list sources) : sources_(std::move(sources)), read_(sources_.size()) {}

  VolumeField field_of(const py::handle& state) {
    const auto at = [&](int i) { return py::object(state[py::int_(i)]); };
    const auto kind = at(0).cast<std::string>();
    if (kind == "formula") {
      const Volume made = formula(at(1).cast<std::string>(), at(2).cast<std::vector<double>>());
      return made.fields.at(at(3).cast<std::size_t>());
    }
    if (kind == "file")
      return of_file(at(1).cast<std::size_t>(), at(2).cast<std::string>(), at(3).cast<int>(), at(4).cast<bool>());
    if (kind == "grid") return {.name = "", .unit = "", .field = grid_of(at)};
    if (kind == "series") {
      std::vector<FieldPtr> frames;
      for (const py::handle& frame : at(1)) frames.push_back(field_of(frame).field);
      return {"", "", time_series(std::move(frames), at(2).cast<double>(), static_cast<BetweenFrames>(at(3).cast<int>()))};
    }
    VolumeField field = field_of(at(1));
    if (kind == "posed") {
      field.field = posed(field.field, similarity_of(at(2).cast<Pose>()));
    } else {
      PoseTrack track;
      for (const auto& [time_s, pose] : at(2).cast<std::vector<std::pair<double, Pose>>>())
        track.push_back({time_s, similarity_of(pose)});
      field.field = moving(field.field, std::move(track), at(3).cast<int>());
    }
    return field;
  }

 private:
  static FieldPtr with_filter(FieldPtr field, int filter, bool without_sign) {
    const py::gil_scoped_release release;
    if (without_sign) field = signless(std::move(field));
    return filtered(std::move(field), static_cast<Filter>(filter));
  }
  template <class At>
  static FieldPtr grid_of(const At& at) {
    const Similarity affine = similarity_of(at(3).template cast<Pose>());
    GridGeometry geometry{.dims = at(2).template cast<std::array<std::int64_t, 3>>(),
                          .index_to_world_m = affine.rotation,
                          .origin_m = affine.translation_m,
                          .planes = at(4).template cast<std::array<std::vector<double>, 3>>()};
    const FieldPtr raw = array_volume(at(1), {}, "", false).fields.front().field;
    const double scale = at(5).template cast<double>(), offset = at(6).template cast<double>();
    return with_filter(grid_field(geometry, grid_behind(*raw)->voxels, scale, offset), at(7).template cast<int>(),
                       at(8).template cast<bool>());
  }
  VolumeField of_file(std::size_t n, const std::string& name, int filter, bool without_sign) {
    Volume& volume = read_.at(n);
    if (volume.fields.empty()) {
      const VolumeRequest request = request_of(sources_[n][py::int_(0)]);
      volume = interruptible(
          [&](const std::atomic<bool>&, std::stop_token stop) { return read_volume(request, {.stop = std::move(stop)}); });
      const auto same = [](const SourceFile& a, const SourceFile& b) { return a.bytes == b.bytes && a.sha256 == b.sha256; };
      if (!std::ranges::equal(volume.files, files_of(sources_[n][py::int_(1)]), same))
        throw LoadError(request.files.front().string() +
                        ": the file is another than when this was pickled; pickle the volume that was read from it anew");
      remember_files(volume);
    }
    const auto found = std::ranges::find(volume.fields, name, &VolumeField::name);
    if (found == volume.fields.end()) throw py::value_error("the file has no field " + detail::in_quotes(name));
    VolumeField field = *found;
    field.field = with_filter(field.field, filter, without_sign);
    return field;
  }

  py::list sources_;
  std::vector<Volume> read_;
};

// ---- volumes ----

py::tuple facts_of(const Volume& v) {
  std::vector<std::tuple<int, std::string, double>> scan;
  for (const ScanFact& fact : v.scan) scan.emplace_back(static_cast<int>(fact.kind), fact.words, fact.number);
  return py::make_tuple(v.medical_frame, v.format, v.modality, scan, v.frame_of_reference, v.length_unit, v.length_unit_assumed,
                        facts_of(v.files), v.frames, v.warnings,
                        v.request ? py::object(state_of(*v.request)) : py::object(py::none()));
}

Volume volume_of_facts(const py::tuple& facts) {
  Volume v;
  v.medical_frame = facts[0].cast<bool>();
  v.format = facts[1].cast<std::string>();
  v.modality = facts[2].cast<std::string>();
  for (const auto& [kind, words, number] : facts[3].cast<std::vector<std::tuple<int, std::string, double>>>())
    v.scan.push_back({static_cast<ScanFactKind>(kind), words, number});
  v.frame_of_reference = facts[4].cast<std::string>();
  v.length_unit = facts[5].cast<std::string>();
  v.length_unit_assumed = facts[6].cast<bool>();
  v.files = files_of(facts[7]);
  v.frames = facts[8].cast<int>();
  v.warnings = facts[9].cast<std::vector<std::string>>();
  if (!facts[10].is_none()) v.request = std::make_shared<const VolumeRequest>(request_of(facts[10]));
  return v;
}

py::tuple state_of(const Volume& volume) {
  Writer writer;
  py::list fields;
  for (const VolumeField& field : volume.fields)
    fields.append(py::make_tuple(field.name, field.unit, writer.state_of(field.field)));
  return py::make_tuple(facts_of(volume), fields, writer.sources());
}

VolumeField renamed(VolumeField field, const py::handle& name, const py::handle& unit) {
  field.name = name.cast<std::string>();
  field.unit = unit.cast<std::string>();
  return field;
}

Volume volume_of(const py::tuple& state) {
  Volume volume = volume_of_facts(state[0]);
  Reader reader(state[2]);
  for (const py::handle& field : state[1])
    volume.fields.push_back(renamed(reader.field_of(field[py::int_(2)]), field[py::int_(0)], field[py::int_(1)]));
  return volume;
}

// ---- scenes ----

template <class T>
py::dict values_of_struct(const T& given) {
  return values_of(std::make_shared<StructPart<T>>(given));
}
void fill(Part& part, const py::handle& values) {
  for (const auto& [key, value] : values.cast<py::dict>()) {
    const bool says_nothing = value.is_none() || (py::isinstance<py::str>(value) && py::len(value) == 0);
    if (!says_nothing) set_value(part, key.cast<std::string>(), value);
  }
}
template <class T>
T filled(const py::handle& values) {
  StructPart part(T{});
  fill(part, values);
  return part.value();
}

/// The volume before the pose that its scene gave it.
Volume unposed(const SceneVolume& given) {
  Volume volume = given.volume;
  if (given.pose == Similarity{} && given.poses.empty()) return volume;
  for (VolumeField& field : volume.fields) {
    if (const PosedView* view = posed_of(*field.field)) {
      field.field = FieldPtr(view->field);
    } else if (const MovingView* moved = moving_of(*field.field)) {
      field.field = FieldPtr(moved->field);
    }
  }
  return volume;
}

/// Filter of all fields; none if they differ, or have none.
std::optional<Filter> filter_of(const Volume& volume) {
  std::optional<Filter> filter;
  for (const VolumeField& field : volume.fields) {
    const GridView* const grid = grid_below(*field.field);
    if (!grid || (filter && *filter != grid->filter)) return {};
    filter = grid->filter;
  }
  return filter;
}

py::tuple state_of(const SceneVolume& given) {
  std::vector<std::pair<double, Pose>> poses;
  for (const TimedPose& pose : given.poses) poses.emplace_back(pose.time_s, numbers_of(pose.pose));
  return py::make_tuple(given.name, state_of(unposed(given)), numbers_of(given.pose), poses, given.smoothing_m, given.source);
}
void add_volume(Scene& scene, const py::tuple& state) {
  SceneVolume volume{.name = state[0].cast<std::string>(),
                     .volume = volume_of(state[1]),
                     .pose = similarity_of(state[2].cast<Pose>()),
                     .smoothing_m = state[4].cast<double>(),
                     .source = state[5].cast<std::string>()};
  for (const auto& [time_s, pose] : state[3].cast<std::vector<std::pair<double, Pose>>>())
    volume.poses.push_back({time_s, similarity_of(pose)});
  const std::optional<Filter> filter = filter_of(volume.volume);
  scene.add(std::move(volume), filter);
}

py::tuple state_of(const SceneMode& mode) {
  py::object content = python_object_of(mode.mode);
  if (content.is_none()) {
    const auto type = std::string(mode.mode.type());
    if (!known_modes().find(type)) {
      throw py::type_error("mode " + detail::in_quotes(mode.name) +
                           " is a function of C, whose address is of this process; remove it, and add it in the other process");
    }
    content = py::make_tuple(type, values_of(std::make_shared<python::ModePart>(mode.mode)));
  }
  return py::make_tuple(mode.name, content, mode.masks, mode.enabled, mode.feet ? static_cast<int>(*mode.feet) : -1);
}
void add_mode(Scene& scene, const py::tuple& state) {
  const auto name = state[0].cast<std::string>();
  PartPtr part;
  if (py::isinstance<py::tuple>(state[1])) {
    const auto type = state[1][py::int_(0)].cast<std::string>();
    const Mode* const fresh = known_modes().find(type);
    if (!fresh) {
      throw py::value_error("mode " + detail::in_quotes(name) + " is of type " + detail::in_quotes(type) +
                            ", which a plug-in has; load it in this process before: palpa.load_plugin(file)");
    }
    part = std::make_shared<python::ModePart>(*fresh);
    fill(*part, state[1][py::int_(1)]);
  } else {
    part = state[1].attr("_to_part")().cast<PartPtr>();
  }
  const Mode& mode = dynamic_cast<python::ModePart&>(*part).mode();
  const int feet = state[4].cast<int>();
  scene.add(detail::CheckedMode({name, named(mode, name), state[3].cast<bool>(), state[2].cast<std::vector<Mask>>(),
                                 feet < 0 ? std::nullopt : std::optional(static_cast<SceneMode::Feet>(feet))},
                                scene.modes().size()));
}

py::list state_of(const std::vector<ViewLayer>& layers) {
  py::list all;
  for (const ViewLayer& layer : layers) {
    py::list colors;
    for (const ViewLayer::ColorPoint& point : layer.colors)
      colors.append(py::make_tuple(point.value, point.color, point.opacity));
    all.append(py::make_tuple(values_of_struct(layer), colors));
  }
  return all;
}
std::vector<ViewLayer> layers_of(const py::handle& state) {
  std::vector<ViewLayer> layers;
  for (const py::handle& each : state) {
    ViewLayer& layer = layers.emplace_back(filled<ViewLayer>(each[py::int_(0)]));
    using Color = std::tuple<double, std::string, double>;
    for (const auto& [value, color, opacity] : each[py::int_(1)].cast<std::vector<Color>>())
      layer.colors.push_back({value, color, opacity});
  }
  return layers;
}

py::dict state_of(const Scene& scene) {
  py::list volumes, modes, hands;
  for (const SceneHand& hand : scene.hands())
    hands.append(py::make_tuple(hand.name, array_of(hand.at_m), values_of_struct(hand.tool)));
  for (const SceneVolume& volume : scene.volumes()) volumes.append(state_of(volume));
  for (const SceneMode& mode : scene.modes()) modes.append(state_of(mode));
  py::dict state;
  state["title"] = scene.title;
  state["needs"] = scene.needs;
  state["law"] = scene.law();
  state["coupling"] = values_of_struct(scene.coupling());
  state["workspace"] = values_of_struct(scene.workspace());
  state["time"] = values_of_struct(scene.time());
  state["tool"] = values_of_struct(scene.tool());
  state["view"] = values_of_struct(scene.view);
  state["layers"] = state_of(scene.layers);
  state["volumes"] = volumes;
  state["modes"] = modes;
  state["hands"] = hands;
  return state;
}

std::shared_ptr<Scene> scene_of(const py::dict& state) {
  const auto scene = std::make_shared<Scene>();
  scene->title = state["title"].cast<std::string>();
  scene->needs = state["needs"].cast<std::vector<std::string>>();
  scene->set_law(state["law"].cast<std::string>());
  for (const py::handle& volume : state["volumes"]) add_volume(*scene, volume.cast<py::tuple>());
  for (const py::handle& mode : state["modes"]) add_mode(*scene, mode.cast<py::tuple>());
  scene->set(filled<CouplingOptions>(state["coupling"]));
  scene->set(filled<Workspace>(state["workspace"]));
  scene->set(filled<TimeOptions>(state["time"]));
  scene->set(filled<ToolOptions>(state["tool"]));
  for (const py::handle& hand : state["hands"])
    scene->add_hand(
        {hand[py::int_(0)].cast<std::string>(), vector_of(hand[py::int_(1)], "at_m"), filled<ToolOptions>(hand[py::int_(2)])});
  scene->view = filled<ViewOptions>(state["view"]);
  scene->layers = layers_of(state["layers"]);
  return scene;
}

// ---- ticks ----

// Members of a result, in the order of their numbers.
template <class Act>
void each_member(Energy& e, const Act& act) {
  for (double* number : {&e.stored_j, &e.elastic_j, &e.dissipated_j, &e.injected_j, &e.path_and_release_j, &e.damper_j,
                         &e.data_motion_j, &e.released_j, &e.sampling_j})
    act(*number);
}
template <class Act>
void each_member(Tick& t, const Act& act) {
  for (Vec3* v : {&t.probe_m, &t.probe_velocity_m_per_s, &t.probe_step_m, &t.proxy_m, &t.proxy_velocity_m_per_s, &t.force_n,
                  &t.probe_turn_step_rad, &t.torque_nm})
    for (double* number : {&v->x, &v->y, &v->z}) act(*number);
  for (Turn* turn : {&t.probe_turn, &t.proxy_turn})
    for (double* number : {&turn->w, &turn->x, &turn->y, &turn->z}) act(*number);
  for (double* number : {&t.given_back_n, &t.error_bound_m, &t.unborne_n}) act(*number);
  for (int* number : {&t.sub_steps, &t.iterations, &t.dropped, &t.work}) act(*number);
  act(t.probe_valid);
  act(t.status);
  each_member(t.energy, act);
}
template <class Act>
void each_member(ModeForce& m, const Act& act) {
  for (double* number : {&m.force_n.x, &m.force_n.y, &m.force_n.z, &m.dissipated_j, &m.injected_j}) act(*number);
  act(m.primitives);
  act(m.split_shared);
}

template <class T>
auto by_members() {
  return py::pickle(
      [](const T& given) {
        T copy = given;
        py::list numbers;
        each_member(copy, [&]<class N>(N& number) { numbers.append(static_cast<double>(number)); });
        return py::tuple(numbers);
      },
      [](const py::tuple& numbers) {
        T made;
        py::size_t n = 0;
        each_member(made, [&]<class N>(N& number) { number = static_cast<N>(numbers[n++].cast<double>()); });
        return made;
      });
}

template <class T>
py::class_<T> class_of(const py::module_& module, const char* name) {
  return py::reinterpret_borrow<py::class_<T>>(module.attr(name));
}

}  // namespace

Volume of_formula(const std::string& name, std::vector<double> arguments, Volume volume) {
  for (std::size_t n = 0; n < volume.fields.size(); ++n) {
    const FieldPtr field = below_poses(volume.fields[n].field);
    if (!grid_below(*field)) remember(field, {.formula = name, .arguments = arguments, .index = n});
  }
  return volume;
}

void remember_files(const Volume& volume) {
  if (!volume.request) return;
  for (const VolumeField& each : volume.fields) {
    const FieldPtr field = below_poses(each.field);
    if (grid_behind(*field)) remember(field, {.request = volume.request, .files = volume.files, .field = each.name});
  }
}

void remember_sources(const Scene& scene) {
  const std::string of_formula_key = "analytic = \"";
  for (const SceneVolume& each : scene.volumes()) {
    const std::string& source = each.source;
    if (source.starts_with("labels = ") || source.find("\nlabels = ") != std::string::npos) continue;  // fields of no file
    const auto key = source.starts_with(of_formula_key) ? 0 : source.find("\n" + of_formula_key);
    if (key == std::string::npos) {
      remember_files(each.volume);
    } else {
      const auto name = source.find('"', key) + 1;
      of_formula(source.substr(name, source.find('"', name) - name), {}, each.volume);
    }
  }
}

void bind_pickling(py::module_& module) {
  class_of<Volume>(module, "Volume").def(py::pickle([](const Volume& v) { return state_of(v); }, &volume_of));
  class_of<VolumeField>(module, "Field")
      .def(py::pickle(
          [](const VolumeField& f) {
            Writer writer;
            const py::tuple state = writer.state_of(f.field);
            return py::make_tuple(f.name, f.unit, state, writer.sources());
          },
          [](const py::tuple& state) { return renamed(Reader(state[3]).field_of(state[2]), state[0], state[1]); }));
  class_of<Energy>(module, "Energy").def(by_members<Energy>());
  class_of<Tick>(module, "Tick").def(by_members<Tick>());
  class_of<ModeForce>(module, "ModeForce").def(by_members<ModeForce>());
  module.def("scene_state", [](const Scene& scene) { return state_of(scene); });
  module.def("scene_of", &scene_of);
}

}  // namespace palpa::python
