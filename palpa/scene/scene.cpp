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

template <class Options>
const Options& in_range(const Options& options) {
  detail::refuse_first(detail::range_findings(options));
  return options;
}

}  // namespace

class Scene::DerivedFields : public detail::DerivedFields {};

Scene::Scene(const CouplingOptions& coupling) : derived_(std::make_shared<DerivedFields>()) { set(coupling); }

void Scene::set(const CouplingOptions& coupling) { std::get<CouplingOptions>(options_) = in_range(coupling); }
void Scene::set(const Workspace& workspace) { std::get<Workspace>(options_) = in_range(workspace); }
void Scene::set(const TimeOptions& time) { std::get<TimeOptions>(options_) = in_range(time); }
void Scene::set(const ToolOptions& tool, std::size_t hand) {
  detail::refuse_first(detail::range_findings(tool));
  if (hand == 0) std::get<ToolOptions>(options_) = tool;
  if (!hands_.empty()) hands_[hand].tool = tool;
}

void Scene::add_hand(SceneHand hand) {
  if (hands_.size() >= limit::hands.count()) refuse(more_than(limit::hands));
  detail::refuse_first(detail::hand_findings(*this, hand, hands_.size()));
  if (hands_.empty()) std::get<ToolOptions>(options_) = hand.tool;
  hands_.push_back(std::move(hand));
}

Scene Scene::of_hand(std::size_t number) const {
  Scene one = *this;
  if (number >= hands_.size()) return one;
  one.hands_ = {hands_[number]};
  std::get<ToolOptions>(one.options_) = hands_[number].tool;
  return one;
}

Scene Scene::of_hand(std::string_view name) const {
  const auto found = std::ranges::find(hands_, name, &SceneHand::name);
  if (found != hands_.end()) return of_hand(static_cast<std::size_t>(found - hands_.begin()));
  if (hands_.empty()) refuse("no hand " + in_quotes(name) + "; its hand has no name, as there is no [[hand]]");
  refuse("no hand " + in_quotes(name) + "; " + suggestion(name, detail::names_of(hands_)));
}

void Scene::set_law(std::string name) {
  detail::refuse_first(detail::law_findings(name));
  law_ = std::move(name);
}

DataTime TimeOptions::at(double elapsed_s) const noexcept {
  if (play == Play::hold) return {start_s};
  return {start_s + speed * elapsed_s, play == Play::loop};
}

FieldRef Scene::add(std::string name, Volume volume, const Similarity& pose, std::optional<Filter> filter) {
  return add({std::move(name), std::move(volume), pose, {}}, filter);
}

FieldRef Scene::add_moving(std::string name, Volume volume, const PoseTrack& poses, std::optional<Filter> filter) {
  if (poses.empty()) refuse("the poses of volume " + in_quotes(name) + ": " + problem_with(poses));
  return add({std::move(name), std::move(volume), {}, poses}, filter);
}

FieldRef Scene::add(SceneVolume added, std::optional<Filter> filter) {
  const std::string& name = added.name;
  Volume& volume = added.volume;
  if (!is_usable(added.pose))
    refuse("the pose of volume " + in_quotes(name) + " is no similarity; use a rotation, a scale above 0 and finite numbers");
  if (const char* problem = added.poses.empty() ? nullptr : problem_with(added.poses))
    refuse("the poses of volume " + in_quotes(name) + ": " + problem);
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

detail::CheckedMode::CheckedMode(SceneMode mode, std::size_t number) : mode_(std::move(mode)) {
  refuse_first(parameter_findings(mode_, number));
}

void Scene::add(std::string name, Mode mode, std::vector<Mask> masks, bool enabled) {
  add(detail::CheckedMode({std::move(name), std::move(mode), enabled, std::move(masks)}, modes_.size()));
}

void Scene::add(detail::CheckedMode mode) {
  if (modes_.size() >= limit::modes.count()) refuse(more_than(limit::modes));
  detail::refuse_first(detail::mode_findings(*this, mode.get(), modes_.size()));
  modes_.push_back(mode.get());
}

void Scene::replace_mode(std::size_t number, SceneMode mode) {
  const detail::CheckedMode checked(std::move(mode), number);
  detail::refuse_first(detail::mode_findings(*this, checked.get(), number));
  modes_[number] = checked.get();
}

void Scene::remove_mode(std::string_view name) noexcept {
  std::erase_if(modes_, [&](const SceneMode& mode) { return mode.name == name; });
}

const SceneVolume* Scene::find_volume(std::string_view name) const noexcept {
  const auto found = std::ranges::find(volumes_, name, &SceneVolume::name);
  return found == volumes_.end() ? nullptr : &*found;
}

std::string Scene::not_of_type(const SceneMode& mode, std::string_view type) {
  return detail::called(mode) + " is a " + std::string(mode.mode.type()) + ", not a " + std::string(type);
}

std::size_t Scene::number_of_mode(std::string_view name) const {
  if (const SceneMode* const mode = find_mode(name)) return static_cast<std::size_t>(mode - modes_.data());
  std::vector<std::string> names;
  for (const SceneMode& mode : modes_) names.push_back(mode.name);
  throw SceneError("no mode " + in_quotes(name) + "; " + suggestion(name, names));
}

const SceneMode* Scene::find_mode(std::string_view name) const noexcept {
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
  Similarity map = detail::workspace_map(workspace(), volumes_);
  if (!hands_.empty() && hands_.front().at_m != Vec3{}) map.translation_m = map.to_world(hands_.front().at_m);
  return map;
}

std::vector<std::string> Scene::check() const {
  hand_to_world();
  std::vector<std::string> warnings;
  for (const Finding& finding : detail::warnings(*this)) warnings.push_back(detail::one_line(finding.text));
  return warnings;
}

bool operator==(const Scene& a, const Scene& b) {
  const auto same = [](const SceneVolume& x, const SceneVolume& y) {
    return detail::same_data(x.volume, y.volume, x.source == y.source && (!x.source.empty() || !x.volume.files.empty()));
  };
  return to_toml(a) == to_toml(b) && std::ranges::equal(a.volumes(), b.volumes(), same);
}

}  // namespace palpa
