#include "palpa/scene/workspace_map.h"

#include <algorithm>

#include "palpa/base/wording.h"
#include "palpa/scene/field_lookup.h"
#include "palpa/scene/parts.h"
#include "palpa/scene/scene_checks.h"

namespace palpa::detail {

namespace {

constexpr double reach_m = 0.15;  // of the hand, along a fitted volume's longest side. More: out of reach; less: crowded

[[noreturn]] void refuse(const char* key, std::string text) {
  throw SceneProblem({{.section = "workspace", .list = {}, .key = key}, std::move(text)});
}

/// World direction of a word; zero for an unknown word.
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
    refuse(key, in_quotes(word) + " is no direction; " + suggestion(word, direction_words()));
  }
  const bool medical = word.front() != '+' && word.front() != '-';
  if (medical && !volume.volume.medical_frame) {
    refuse(key, in_quotes(word) + " is a medical word, and volume " + in_quotes(volume.name) +
                    " has no medical frame; use one of: +x, -x, +y, -y, +z, -z");
  }
  return along;
}

const SceneVolume& volume_named(const std::vector<SceneVolume>& volumes, const char* key, const std::string& name) {
  const auto found = std::ranges::find(volumes, name, &SceneVolume::name);
  if (found == volumes.end()) refuse(key, "no volume " + in_quotes(name) + "; " + suggestion(name, names_of(volumes)));
  return *found;
}

}  // namespace

Similarity workspace_map(const Workspace& workspace, const std::vector<SceneVolume>& volumes) {
  if (!workspace.fit.empty() && workspace.scale) {
    refuse("scale", "both 'fit' and 'scale' are given; use one of them");
  }
  if (!workspace.center_volume.empty() && workspace.center_m) {
    refuse("center", "a volume and a position are given as 'center'; use one of them");
  }
  if (volumes.empty() && workspace == Workspace{}) return {};
  if (volumes.empty()) refuse("", "a workspace without volumes has nothing to lie in; add a volume");

  const SceneVolume& fitted = workspace.fit.empty() ? volumes.front() : volume_named(volumes, "fit", workspace.fit);
  const SceneVolume& centered =
      workspace.center_volume.empty() ? fitted : volume_named(volumes, "center", workspace.center_volume);

  const bool medical = fitted.volume.medical_frame;
  const Vec3 z = direction_of("towards_user", workspace.towards_user, medical ? "anterior" : "+z", fitted);
  const Vec3 y = direction_of("up", workspace.up, medical ? "superior" : "+y", fitted);
  if (dot(y, z) != 0.0) {
    refuse(workspace.up.empty() ? "towards_user" : "up",
           "'up' and 'towards_user' lie along one axis; give two directions at a right angle");
  }
  const Vec3 x = cross(y, z);

  Similarity map;
  map.rotation = {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}};
  map.scale = workspace.scale ? *workspace.scale : largest_component(fitted.volume.bounds_m().size_m()) / reach_m;
  map.translation_m = workspace.center_m ? *workspace.center_m : centered.volume.bounds_m().centre_m();
  if (!is_usable(map)) {
    refuse(workspace.scale ? "scale" : "fit",
           "the box of volume " + in_quotes(fitted.name) + " has no usable size; give 'scale' and 'center' as numbers");
  }
  return map;
}

}  // namespace palpa::detail
