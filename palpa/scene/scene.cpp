#include "palpa/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "palpa/grid/derived_fields.h"
#include "palpa/grid/filter.h"
#include "palpa/limits/limits.h"
#include "palpa/scene/keys.h"
#include "palpa/scene/scene_checks.h"
#include "palpa/survey/thin_parts.h"
#include "palpa/toml/wording.h"
#include "palpa/volume/field_name.h"
#include "palpa/volume/same_data.h"
#include "palpa/volume/volume.h"

namespace palpa {

namespace {

using detail::Finding;
using detail::in_quotes;
using detail::problem_with_name;
using detail::suggestion;
using detail::toml_number;

constexpr double reach_m = 0.15;  // of the hand, along a fitted volume's longest side. More: out of reach; less: crowded

[[noreturn]] void refuse(const std::string& text) { throw SceneError(detail::one_line("scene: " + text)); }

std::vector<std::string> names_of(const std::vector<SceneVolume>& volumes) {
  std::vector<std::string> names;
  for (const SceneVolume& volume : volumes) names.push_back(volume.name);
  return names;
}

/// Every field of the scene as a scene file would name it.
std::vector<std::string> field_names(const std::vector<SceneVolume>& volumes) {
  std::vector<std::string> names;
  for (const SceneVolume& volume : volumes) {
    if (volume.volume.fields.size() == 1) {
      names.push_back(volume.name);
    } else {
      for (const VolumeField& field : volume.volume.fields) names.push_back(volume.name + "." + field.name);
    }
  }
  return names;
}

struct Found {
  const VolumeField* field = nullptr;
  std::int32_t index = -1;
  std::string problem;
  int components = 0;  ///< after the derivations
  detail::FieldName name{};
};

Found find_plain_field(const std::vector<SceneVolume>& volumes, const std::string& name) {
  const std::size_t dot = name.find('.');
  const std::string volume_name = name.substr(0, dot);
  std::int32_t index = 0;
  for (const SceneVolume& volume : volumes) {
    const std::vector<VolumeField>& fields = volume.volume.fields;
    if (volume.name != volume_name) {
      index += static_cast<std::int32_t>(fields.size());
      continue;
    }
    if (dot == std::string::npos) {
      if (fields.size() == 1) return {&fields.front(), index, {}};
      return {nullptr, -1,
              "volume " + in_quotes(name) + " has several fields; name one of: " + detail::joined(field_names({volume}))};
    }
    for (const VolumeField& field : fields) {
      if (field.name == name.substr(dot + 1)) return {&field, index, {}};
      ++index;
    }
  }
  std::string problem = detail::problem_with_volume_of(name, names_of(volumes));
  if (problem.empty()) problem = "no field " + in_quotes(name) + "; " + suggestion(name, field_names(volumes));
  return {nullptr, -1, problem};
}

/// The plain field within a name, and what comes out of the functions around it.
Found find_field(const std::vector<SceneVolume>& volumes, const std::string& name) {
  const detail::FieldName parsed = detail::parse_field_name(name);
  if (!parsed.problem.empty()) return {nullptr, -1, parsed.problem};
  Found found = find_plain_field(volumes, parsed.plain);
  if (!found.field) return found;
  found.name = parsed;
  found.components = detail::components_after(parsed, found.field->field->components(), found.problem);
  if (!found.problem.empty()) return {nullptr, -1, found.problem};
  return found;
}

// ---- Checks

std::string call_item(const std::string& list, std::size_t item, const std::string& name) {
  return list + " " + (name.empty() ? std::to_string(item + 1) : in_quotes(name));
}

/// Looks into the parameters of a mode or of another part, and those of its lists, knowing where it is.
class CheckingVisitor : public ParameterVisitor {
 public:
  CheckingVisitor(const SceneMode& mode, std::size_t number, std::vector<Finding>& out)
      : out_(out), where_(detail::called(mode)) {
    part_.section = "mode";
    part_.mode = number;
  }
  CheckingVisitor(const std::string& section, std::vector<Finding>& out) : out_(out) { part_.section = section; }
  void list(const ParameterInfo& info, ParameterList& list) override {
    const std::string outer = where_;
    part_.list = info.name;
    for (part_.item = 0; part_.item < list.size(); ++part_.item) {
      ItemName name;
      list.visit(part_.item, name);
      where_ = call_item(part_.list, part_.item, name.value) + " of " + outer;
      list.visit(part_.item, *this);
    }
    where_ = outer;
    part_.list.clear();
    part_.item = 0;
  }

 protected:
  void find(std::string_view key, std::string text, bool warning = false) {
    detail::Part part = part_;
    part.key = key;
    out_.push_back({std::move(part), std::move(text), warning});
  }
  std::string the(std::string_view key) const { return in_quotes(key) + (where_.empty() ? "" : " in " + where_); }
  const detail::Part& part() const noexcept { return part_; }

 private:
  struct ItemName : ParameterVisitor {
    void text(const ParameterInfo& info, std::string& text) override {
      if (info.name == "name") value = text;
    }
    std::string value;
  };
  std::vector<Finding>& out_;
  detail::Part part_;
  std::string where_;
};

class ParameterChecks final : public CheckingVisitor {
 public:
  using CheckingVisitor::CheckingVisitor;
  void number(const ParameterInfo& info, double& value) override {
    if (info.kind == ParameterKind::level) {
      if (!std::isfinite(value)) find(info.name, the(info.name) + " is not finite; a level is a value of the field");
    } else {
      in_range(info.name, info.range, value);
    }
  }
  void optional_number(const ParameterInfo& info, std::optional<double>& value) override {
    if (value) in_range(info.name, info.range, *value);
  }
  void numbers(const ParameterInfo& info, std::vector<double>& value) override {
    if (std::ranges::all_of(value, [](double number) { return std::isfinite(number); })) return;
    find(info.name, the(info.name) + " is not finite; give " + std::string(info.form));
  }
  void strength(const ParameterInfo& info, Strength& strength) override {
    if (strength.is_constant()) return in_range(info.name, info.range, strength.constant_n);
    function(info.name, info.range, strength.curve);
  }
  void text(const ParameterInfo& info, std::string& value) override {
    const std::string& list = part().list;
    if (info.name != "name" || value.empty() || list.empty()) return;
    if (const std::string problem = problem_with_name(list, value); !problem.empty()) find(info.name, problem);
    if (!names_.emplace(list, value).second) {
      find(info.name, detail::name_is_taken(list, value));
    }
  }
  void function(std::string_view key, Range range, const TransferFunction& function) {
    if (function.points().empty()) return find(key, the(key) + " is a function without points; give at least one");
    for (const TransferFunction::Point& point : function.points()) in_range(key, range, point.result);
    in_range(key, range, function.outside());
  }

 private:
  void in_range(std::string_view key, Range range, double value) {
    const bool fits = range.contains(value) && std::isfinite(value);
    if (!fits) find(key, the(key) + " is " + toml_number(value) + "; it must be " + detail::sentence_of(range));
  }
  std::set<std::pair<std::string, std::string>> names_;
};

/// Those that look at the fields of the scene.
class SceneChecks : public CheckingVisitor {
 public:
  SceneChecks(const Scene& scene, const SceneMode& mode, std::size_t number, std::vector<Finding>& out)
      : CheckingVisitor(mode, number, out), scene_(scene) {}

 protected:
  const Scene& scene_;
};

class FieldChecks final : public SceneChecks {
 public:
  using SceneChecks::SceneChecks;
  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (info.kind == ParameterKind::optional_field && ref.name.empty()) return;
    const int components = info.kind == ParameterKind::scalar_field ? 1 : info.kind == ParameterKind::vector_field ? 3 : 0;
    resolve(info.name, ref, components);
  }
  void strength(const ParameterInfo& info, Strength& strength) override {
    if (!strength.is_constant()) resolve(info.name, strength.of, 1);
  }
  void resolve(std::string_view key, const FieldRef& ref, int components) {
    if (ref.name.empty()) return find(key, the(key) + " names no field; " + suggestion("", field_names(scene_.volumes())));
    const Found found = find_field(scene_.volumes(), ref.name);
    if (!found.field) return find(key, found.problem);
    const int has = found.components;
    if (components != 0 && has != components) {
      find(key,
           the(key) + " must be a " + kind(components) + " field; " + in_quotes(ref.name) + " is a " + kind(has) + " field");
    }
  }

 private:
  static std::string kind(int components) { return components == 1 ? "scalar" : "vector"; }
};

/// Compares the levels of a mode with what its parameter `field` holds.
class LevelChecks final : public SceneChecks {
 public:
  using SceneChecks::SceneChecks;
  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (info.name == "field") ref_ = ref;
  }
  void number(const ParameterInfo& info, double& value) override {
    if (info.kind != ParameterKind::level || ref_.name.empty()) return;
    if (!extent_) extent_ = scene_.field(ref_).field->extents().front();
    if (value >= extent_->min && value <= extent_->max) return;
    find(info.name,
         the(info.name) + " is " + toml_number(value) + ", outside the data of " + in_quotes(ref_.name) +
             " and never met; they go from " + toml_number(extent_->min) + " to " + toml_number(extent_->max),
         true);
  }

 private:
  FieldRef ref_;
  std::optional<Extent> extent_;
};

/// Looks for a texture of a field that has none.
class TextureChecks final : public SceneChecks {
 public:
  using SceneChecks::SceneChecks;
  void companion(FieldRef&, const FieldRef& of, Derivation felt) override {
    if (felt != Derivation::detail || of.name.empty() || has_detail(*scene_.field(of).field)) return;
    find("texture_ratio",
         the("texture_ratio") + " is not felt: nothing of " + in_quotes(of.name) +
             " is finer than its filter; of a scalar volume from voxels filter = \"smooth\" leaves such detail",
         true);
  }
};

/// Looks for levels of a mode at which the smoothing filter loses much of what is thin.
class ThinPartChecks final : public SceneChecks {
 public:
  ThinPartChecks(const Scene& scene, const SceneMode& mode, std::size_t number, const std::vector<std::string>& chose,
                 std::vector<Finding>& out)
      : SceneChecks(scene, mode, number, out), chose_(chose) {}
  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (info.name != "field" || ref.name.empty()) return;
    if (std::ranges::find(chose_, detail::parse_field_name(ref.name).volume()) != chose_.end()) return;
    const FieldPtr field = scene_.field(ref).field;
    const GridView* grid = grid_below(*field);
    if (grid && grid->filter == Filter::smooth && grid->voxels.components == 1) field_ = field;
  }
  void choice(const ParameterInfo& info, int& value) override {
    if (info.name == "solid") solid_ = info.choices[static_cast<std::size_t>(value)];
  }
  void number(const ParameterInfo& info, double& value) override {
    if (info.kind != ParameterKind::level || !field_) return;
    // [1] Shares lost, of thin parts and of the whole, that are worth a finding. More: losses stay unknown; less: noise is
    // told. Of what is thin for the most part, as a shell is, what is lost of the whole counts alone: each is a hole in a wall.
    constexpr double much = 0.1, much_of_all = 0.01, mostly = 0.5;
    ThinParts worst;
    for (const auto& [side, left_out] : {std::pair{SolidSide::high, "low"}, std::pair{SolidSide::low, "high"}}) {
      if (solid_ == left_out) continue;
      const ThinParts parts = thin_parts(*field_, value, side);
      if (parts.lost_share() > worst.lost_share()) worst = parts;
    }
    const bool is_much = worst.lost_share() > much || worst.thin_share() > mostly;
    if (!is_much || !(worst.thin_share() * worst.lost_share() > much_of_all)) return;
    const auto percent = [](double share) { return toml_number(std::round(1000.0 * share) / 10.0) + " %"; };
    find(info.name,
         the(info.name) + ": the smooth filter loses " + toml_number(std::round(100.0 * worst.lost_share())) +
             " % of the parts thinner than 2 voxels there, " + percent(worst.thin_share() * worst.lost_share()) +
             " of the whole; filter = \"trilinear\" of the volume keeps them",
         true);
  }

 private:
  const std::vector<std::string>& chose_;
  FieldPtr field_;
  std::string_view solid_ = "high";
};

/// What is out of its range or not finite in a part of its own section.
template <class Part>
std::vector<Finding> part_findings(const std::string& section, Part part) {
  std::vector<Finding> found;
  ParameterChecks checks(section, found);
  detail::visit_parameters(part, checks);
  return found;
}

// ---- The workspace

struct WorkspaceProblem {
  std::string key;
  std::string text;
};

/// A world direction by its word; zero for no direction.
Vec3 direction(const std::string& word) {
  struct Direction {
    std::string_view medical, axis;
    Vec3 along;
  };
  // LPS: x to the patient's left, y to the back, z to the head.
  static constexpr Direction axes[] = {{"left", "+x", {1, 0, 0}},      {"right", "-x", {-1, 0, 0}},
                                       {"posterior", "+y", {0, 1, 0}}, {"anterior", "-y", {0, -1, 0}},
                                       {"superior", "+z", {0, 0, 1}},  {"inferior", "-z", {0, 0, -1}}};
  for (const Direction& d : axes) {
    if (word == d.medical || word == d.axis) return d.along;
  }
  return {};
}

Vec3 direction_of(const char* key, const std::string& given, const std::string& by_default, const SceneVolume& volume) {
  const std::string& word = given.empty() ? by_default : given;
  const Vec3 along = direction(word);
  if (along == Vec3{}) {
    throw WorkspaceProblem{key, in_quotes(word) + " is no direction; " + suggestion(word, detail::direction_words())};
  }
  const bool medical = word.front() != '+' && word.front() != '-';
  if (medical && !volume.volume.medical_frame) {
    throw WorkspaceProblem{key, in_quotes(word) + " is a medical word, and volume " + in_quotes(volume.name) +
                                    " has no medical frame; use one of: +x, -x, +y, -y, +z, -z"};
  }
  return along;
}

const SceneVolume& volume_named(const std::vector<SceneVolume>& volumes, const char* key, const std::string& name) {
  const auto found = std::ranges::find(volumes, name, &SceneVolume::name);
  if (found == volumes.end())
    throw WorkspaceProblem{key, "no volume " + in_quotes(name) + "; " + suggestion(name, names_of(volumes))};
  return *found;
}

Similarity map_of(const Workspace& workspace, const std::vector<SceneVolume>& volumes) {
  if (!workspace.fit.empty() && workspace.scale) {
    throw WorkspaceProblem{"scale", "both 'fit' and 'scale' are given; use one of them"};
  }
  if (!workspace.center_volume.empty() && workspace.center_m) {
    throw WorkspaceProblem{"center", "a volume and a position are given as 'center'; use one of them"};
  }
  if (const std::vector<Finding> found = part_findings("workspace", workspace); !found.empty()) {
    throw WorkspaceProblem{found.front().part.key, found.front().text};
  }
  if (volumes.empty() && workspace == Workspace{}) return {};
  if (volumes.empty()) throw WorkspaceProblem{"", "a workspace without volumes has nothing to lie in; add a volume"};

  const SceneVolume& fitted = workspace.fit.empty() ? volumes.front() : volume_named(volumes, "fit", workspace.fit);
  const SceneVolume& centered =
      workspace.center_volume.empty() ? fitted : volume_named(volumes, "center", workspace.center_volume);

  const bool medical = fitted.volume.medical_frame;
  const Vec3 z = direction_of("towards_user", workspace.towards_user, medical ? "anterior" : "+z", fitted);
  const Vec3 y = direction_of("up", workspace.up, medical ? "superior" : "+y", fitted);
  if (dot(y, z) != 0.0) {
    throw WorkspaceProblem{workspace.up.empty() ? "towards_user" : "up",
                           "'up' and 'towards_user' lie along one axis; give two directions at a right angle"};
  }
  const Vec3 x = cross(y, z);

  Similarity map;
  map.rotation = {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}};
  map.scale = workspace.scale ? *workspace.scale : largest_component(fitted.volume.bounds_m().size_m()) / reach_m;
  map.translation_m = workspace.center_m ? *workspace.center_m : centered.volume.bounds_m().centre_m();
  if (!is_usable(map)) {
    throw WorkspaceProblem{workspace.scale ? "scale" : "fit", "the box of volume " + in_quotes(fitted.name) +
                                                                  " has no usable size; give 'scale' and 'center' as numbers"};
  }
  return map;
}

}  // namespace

// ---- detail

namespace detail {

std::string called(const SceneMode& mode) { return "mode " + in_quotes(mode.name); }

std::string problem_with_volume_of(const std::string& field, const std::vector<std::string>& volumes) {
  const FieldName name = parse_field_name(field);
  if (!name.problem.empty()) return name.problem;
  const std::string volume = name.volume();
  if (std::ranges::find(volumes, volume) != volumes.end()) return {};
  return "no volume " + in_quotes(volume) + "; " + suggestion(volume, volumes);
}

std::vector<Finding> parameter_findings(const SceneMode& scene_mode, std::size_t number) {
  std::vector<Finding> found;
  ParameterChecks checks(scene_mode, number, found);
  look_through(scene_mode.mode, checks);
  for (const Mask& mask : scene_mode.masks) checks.function("mask", {0, 1}, mask.curve);
  if (const std::string name = problem_with_name("mode", scene_mode.name); !name.empty()) {
    found.push_back({{.section = "mode", .mode = number, .list = {}, .key = "name"}, name});
  }
  if (!found.empty()) return found;
  if (const std::string problem = scene_mode.mode.problem(); !problem.empty()) {
    found.push_back({{.section = "mode", .mode = number, .list = {}, .key = {}}, called(scene_mode) + ": " + problem});
  }
  return found;
}

std::vector<Finding> field_findings(const Scene& scene, const SceneMode& scene_mode, std::size_t number) {
  std::vector<Finding> found;
  FieldChecks checks(scene, scene_mode, number, found);
  look_through(scene_mode.mode, checks);
  for (const Mask& mask : scene_mode.masks) checks.resolve("mask", mask.of, 1);
  return found;
}

std::vector<Finding> layer_findings(const Scene& scene, const std::vector<ViewLayer>& layers) {
  std::vector<Finding> found;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const ViewLayer::Show show = layers[i].show;
    const Found drawn = find_field(scene.volumes(), layers[i].field.name);
    const bool of_vectors = show == ViewLayer::Show::streamlines || show == ViewLayer::Show::glyphs;
    if (drawn.field && (show == ViewLayer::Show::slices || of_vectors == (drawn.components == 3))) continue;
    const char* const wrong = of_vectors ? " is a scalar field; streamlines and glyphs are drawn of a vector one"
                                         : " is a vector field; a surface or a volume is drawn of a scalar one, its magnitude";
    found.push_back({{.section = "view", .list = "layer", .item = i, .key = "field"},
                     drawn.field ? in_quotes(layers[i].field.name) + wrong : drawn.problem,
                     true});
  }
  return found;
}

std::vector<Finding> time_findings(const Scene& scene) {
  std::vector<Finding> found = part_findings("time", scene.time);
  const auto warn = [&](const char* key, std::string text) {
    found.push_back({{.section = "time", .list = {}, .key = key}, std::move(text), true});
  };
  const TimeOptions& time = scene.time;
  bool any = false;
  for (const SceneVolume& volume : scene.volumes()) {
    for (const VolumeField& field : volume.volume.fields) any = any || timed(*field.field);
    if (time.play == TimeOptions::Play::loop && !volume.poses.empty() &&
        volume.poses.front().pose != volume.poses.back().pose) {
      warn("play",
           "volume " + in_quotes(volume.name) + " jumps where its loop begins again; end its 'poses' with the first of them");
    }
  }
  if (time != TimeOptions{} && !any) {
    warn("", "nothing in the scene changes with time; give a volume 'files' or 'poses', or leave [time] out");
  }
  return found;
}

std::vector<Finding> findings(const Scene& scene) {
  std::vector<Finding> found = part_findings("coupling", scene.coupling);
  const std::vector<std::string> laws = law_methods();
  if (std::ranges::find(laws, scene.law) == laws.end()) {
    found.push_back({{.section = "law", .list = {}, .key = "method"},
                     "no law " + in_quotes(scene.law) + "; " + suggestion(scene.law, laws)});
  }
  try {
    map_of(scene.workspace, scene.volumes());
  } catch (const WorkspaceProblem& problem) {
    found.push_back({{.section = "workspace", .list = {}, .key = problem.key}, problem.text});
  }
  std::ranges::move(time_findings(scene), std::back_inserter(found));
  std::set<std::string> names;
  for (std::size_t i = 0; i < scene.modes().size(); ++i) {
    const SceneMode& mode = scene.modes()[i];
    if (!names.insert(mode.name).second) {
      found.push_back({{.section = "mode", .mode = i, .list = {}, .key = "name"}, detail::name_is_taken("mode", mode.name)});
    }
    const std::size_t before = found.size();
    std::ranges::move(parameter_findings(mode, i), std::back_inserter(found));
    std::ranges::move(field_findings(scene, mode, i), std::back_inserter(found));
    if (found.size() != before) continue;
    LevelChecks levels(scene, mode, i, found);
    look_through(mode.mode, levels);
    TextureChecks texture(scene, mode, i, found);
    look_through(mode.mode, texture);
  }
  return found;
}

std::vector<Finding> thin_part_findings(const Scene& scene, const std::vector<std::string>& chose) {
  std::vector<Finding> found;
  for (std::size_t i = 0; i < scene.modes().size(); ++i) {
    ThinPartChecks checks(scene, scene.modes()[i], i, chose, found);
    look_through(scene.modes()[i].mode, checks);
  }
  return found;
}

}  // namespace detail

// ---- Scene

/// Those of a scene and its copies.
class Scene::DerivedFields : public detail::DerivedFields {};

Scene::Scene(CouplingOptions options) : coupling(options), derived_(std::make_shared<DerivedFields>()) {}

DataTime TimeOptions::at(double elapsed_s) const noexcept {
  if (play == Play::hold) return {start_s};
  return {start_s + speed * elapsed_s, play == Play::loop};
}

FieldRef Scene::add(std::string name, Volume volume, const Similarity& pose, std::optional<Filter> filter) {
  if (!is_usable(pose))
    refuse("the pose of volume " + in_quotes(name) + " is no similarity; use a rotation, a scale above 0 and finite numbers");
  return add({std::move(name), std::move(volume), pose, {}}, filter);
}

FieldRef Scene::add_moving(std::string name, Volume volume, const PoseTrack& poses, std::optional<Filter> filter) {
  if (const char* problem = problem_with(poses)) refuse("the poses of volume " + in_quotes(name) + ": " + problem);
  return add({std::move(name), std::move(volume), {}, poses}, filter);
}

FieldRef Scene::add(SceneVolume added, std::optional<Filter> filter) {
  const std::string& name = added.name;
  Volume& volume = added.volume;
  if (const std::string problem = problem_with_name("volume", name); !problem.empty()) refuse(problem);
  if (find_volume(name)) refuse(detail::name_is_taken("volume", name));
  if (volume.fields.empty()) refuse("volume " + in_quotes(name) + " has no fields; a volume has at least one");
  std::set<std::string> fields;
  for (const VolumeField& field : volume.fields) {
    if (!field.field)
      refuse("field " + in_quotes(field.name) + " of volume " + in_quotes(name) + " has no data; a field is never null");
    if (!fields.insert(field.name).second) {
      refuse("volume " + in_quotes(name) + " has two fields " + in_quotes(field.name) + "; give every field a name of its own");
    }
  }
  try {
    volume = filtered(std::move(volume), filter);
  } catch (const std::invalid_argument& problem) {
    refuse("volume " + in_quotes(name) + " cannot be felt so: " + problem.what());
  }
  if (!added.poses.empty()) {
    volume = moving(volume, added.poses);
  } else if (added.pose != Similarity{}) {
    volume = posed(volume, added.pose);
  }
  const std::string first = volume.fields.size() == 1 ? name : name + "." + volume.fields.front().name;
  volumes_.push_back(std::move(added));
  return {first};
}

void Scene::add(std::string name, Mode mode, std::vector<Mask> masks, bool enabled) {
  if (find_mode(name)) refuse(detail::name_is_taken("mode", name));
  if (modes_.size() >= limit::modes.count()) refuse(more_than(limit::modes));
  SceneMode added{std::move(name), std::move(mode), enabled, std::move(masks)};
  std::vector<Finding> found = detail::parameter_findings(added, modes_.size());
  std::ranges::move(detail::field_findings(*this, added, modes_.size()), std::back_inserter(found));
  if (!found.empty()) refuse(found.front().text);
  modes_.push_back(std::move(added));
}

void Scene::remove_mode(std::string_view name) noexcept {
  std::erase_if(modes_, [&](const SceneMode& mode) { return mode.name == name; });
}

SceneVolume* Scene::find_volume(std::string_view name) noexcept {
  const auto found = std::ranges::find(volumes_, name, &SceneVolume::name);
  return found == volumes_.end() ? nullptr : &*found;
}

SceneMode* Scene::find_mode(std::string_view name) noexcept {
  const auto found = std::ranges::find(modes_, name, &SceneMode::name);
  return found == modes_.end() ? nullptr : &*found;
}

VolumeField Scene::field(const FieldRef& ref) const {
  const Found found = find_field(volumes_, ref.name);
  if (!found.field) refuse(found.problem);
  VolumeField field = *found.field;
  const double smoothing_m = std::ranges::find(volumes_, found.name.volume(), &SceneVolume::name)->smoothing_m;
  for (const Derivation derivation : found.name.derivations) {
    field.field = derived_->get(derivation, field.field, smoothing_m);
    field.unit = unit_of(derivation, field.unit);
    field.name = std::string(name_of(derivation)) + "(" + field.name + ")";
  }
  return field;
}

FieldPtr Scene::field(const FieldRef& ref, Derivation derivation) const {
  const FieldPtr of = field(ref).field;
  if (of->components() != components_taken(derivation)) {
    refuse(in_quotes(name_of(derivation)) + " of " + in_quotes(ref.name) + " cannot be taken: it is a field of the other kind");
  }
  const std::string volume = detail::parse_field_name(ref.name).volume();
  return derived_->get(derivation, of, std::ranges::find(volumes_, volume, &SceneVolume::name)->smoothing_m);
}

std::int32_t Scene::index_of(const FieldRef& ref) const {
  const Found found = find_field(volumes_, ref.name);
  if (!found.field) refuse(found.problem);
  return found.name.derivations.empty() ? found.index : -1;
}

Similarity Scene::hand_to_world() const {
  try {
    return map_of(workspace, volumes_);
  } catch (const WorkspaceProblem& problem) {
    throw SceneError(detail::one_line("workspace: " + problem.text));
  }
}

std::vector<std::string> Scene::check() const {
  std::vector<std::string> warnings;
  for (const Finding& finding : detail::findings(*this)) {
    if (!finding.warning) refuse(finding.text);
    warnings.push_back(detail::one_line(finding.text));
  }
  return warnings;
}

bool operator==(const Scene& a, const Scene& b) {
  const auto same = [](const SceneVolume& x, const SceneVolume& y) {
    return detail::same_data(x.volume, y.volume, x.source == y.source && (!x.source.empty() || !x.volume.files.empty()));
  };
  return to_toml(a) == to_toml(b) && std::ranges::equal(a.volumes(), b.volumes(), same);
}

}  // namespace palpa
