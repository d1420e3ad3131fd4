#include "palpa/c/scene_recipe.h"

#include <algorithm>

#include "palpa/base/wording.h"
#include "palpa/c/given_file.h"
#include "palpa/file/read_volume.h"
#include "palpa/scene/to_toml.h"

namespace palpa::c {

namespace {

/// Whether a setting could depend on an earlier one: on a name, or on a table within it.
bool may_depend(std::string_view later, std::string_view earlier) {
  return later.ends_with(".name") || later.starts_with(earlier) || earlier.starts_with(later);
}

std::string key_of(const VolumeRequest& request) {
  std::string key;
  for (const detail::Said& said : detail::said(request)) key += said.key + " = " + said.value + "\n";
  return key;
}

}  // namespace

SceneRecipe::SceneRecipe(std::string text, std::string name, std::filesystem::path folder, GivenVolumes files)
    : text_(std::move(text)), name_(std::move(name)), folder_(std::move(folder)), files_(std::move(files)) {
  make();
}

void SceneRecipe::set(std::string path, std::string value) {
  SceneRecipe changed = *this;
  // A slider sets one path a thousand times: the earlier value goes.
  const auto earlier =
      std::ranges::find(changed.sets_.rbegin(), changed.sets_.rend(), path, &std::pair<std::string, std::string>::first);
  if (earlier != changed.sets_.rend() &&
      std::none_of(changed.sets_.rbegin(), earlier, [&](const auto& later) { return may_depend(later.first, path); }))
    changed.sets_.erase(std::next(earlier).base());
  changed.sets_.emplace_back(std::move(path), std::move(value));
  changed.make();
  *this = std::move(changed);
}

void SceneRecipe::give(const std::string& name, Volume volume) {
  SceneRecipe changed = *this;
  changed.given_.insert_or_assign(name, std::move(volume));
  changed.make();
  *this = std::move(changed);
}

const Scene& SceneRecipe::scene() const {
  if (!scene_) throw MissingData(warnings_.front());
  return *scene_;
}

void SceneRecipe::make() {
  const VolumeReader reader = volume_reader();
  const VolumeReader once = [&](const VolumeRequest& request) {
    if (const auto file = files_.find(request.files.front().string()); file != files_.end())
      return requested(file->second, request);
    const std::string key = key_of(request);
    if (const auto found = read_.find(key); found != read_.end()) return found->second;
    return read_.emplace(key, reader(request)).first->second;
  };
  SceneOptions options;
  options.sets = sets_;
  options.given = &given_;
  options.files = &files_;
  try {
    LoadedScene loaded = parse_scene(text_, name_, folder_, once, standard_modes(), options);
    scene_ = std::make_shared<const Scene>(std::move(loaded.scene));
    warnings_ = std::move(loaded.warnings);
  } catch (const MissingData& missing) {
    scene_.reset();
    warnings_ = {missing.what()};
  }
}

}  // namespace palpa::c
