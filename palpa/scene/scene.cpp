#include "palpa/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "palpa/base/limits.h"
#include "palpa/base/wording.h"
#include "palpa/data/derived_fields.h"
#include "palpa/data/filter.h"
#include "palpa/data/same_data.h"
#include "palpa/data/volume.h"
#include "palpa/scene/field_lookup.h"
#include "palpa/scene/keys.h"
#include "palpa/scene/scene_checks.h"
#include "palpa/scene/workspace_map.h"

namespace palpa {

namespace {

using detail::Finding;
using detail::in_quotes;
using detail::problem_with_name;
using detail::suggestion;
using detail::toml_number;

[[noreturn]] void refuse(const std::string& text) { throw SceneError(detail::one_line("scene: " + text)); }

}  // namespace

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
    refuse("volume " + in_quotes(name) + " cannot be used: " + problem.what());
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
  const std::vector<Finding> found = detail::mode_findings(*this, added, modes_.size());
  if (!found.empty()) throw detail::SceneProblem(found.front());
  modes_.push_back(std::move(added));
}

void Scene::remove_mode(std::string_view name) noexcept {
  std::erase_if(modes_, [&](const SceneMode& mode) { return mode.name == name; });
}

SceneVolume* Scene::find_volume(std::string_view name) noexcept {
  const auto found = std::ranges::find(volumes_, name, &SceneVolume::name);
  return found == volumes_.end() ? nullptr : &*found;
}

std::string Scene::no_mode_to_edit(std::string_view name, std::string_view type) const {
  for (const SceneMode& mode : modes_) {
    if (mode.name == name)
      return "mode " + in_quotes(name) + " is a " + std::string(mode.mode.type()) + ", not a " + std::string(type);
  }
  std::vector<std::string> names;
  for (const SceneMode& mode : modes_) names.push_back(mode.name);
  return "no mode " + in_quotes(name) + "; " + suggestion(name, names);
}

SceneMode* Scene::find_mode(std::string_view name) noexcept {
  const auto found = std::ranges::find(modes_, name, &SceneMode::name);
  return found == modes_.end() ? nullptr : &*found;
}

VolumeField Scene::field(const FieldRef& ref) const {
  const detail::FoundField found = detail::find_field(volumes_, ref.name);
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
  const detail::FoundField found = detail::find_field(volumes_, ref.name);
  if (!found.field) refuse(found.problem);
  return found.name.derivations.empty() ? found.index : -1;
}

Similarity Scene::hand_to_world() const {
  try {
    return detail::workspace_map(workspace, volumes_);
  } catch (const detail::WorkspaceProblem& problem) {
    throw SceneError(detail::one_line("workspace: " + problem.text));
  }
}

std::vector<std::string> Scene::check() const {
  std::vector<std::string> warnings;
  for (const Finding& finding : detail::findings(*this)) {
    if (!finding.warning) throw detail::SceneProblem(finding);
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
