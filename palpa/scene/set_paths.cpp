// Paths of `--set`, for completion, and requests made of them.
#include <utility>

#include "palpa/base/wording.h"
#include "palpa/scene/load_scene.h"
#include "palpa/scene/load_volumes.h"
#include "palpa/scene/set_path.h"

namespace palpa {

using namespace detail::scene_file;

namespace {

void add_paths(const std::string& before, const Keys& keys, std::vector<std::string>& paths) {
  for (const Key& key : keys) {
    if (key.name == "name") continue;  // what the path itself says
    const std::string path = before + key.name;
    paths.push_back(path);
    for (const std::string& choice : key.choices) paths.push_back(path + "=" + choice);
    if (key.kind == ParameterKind::flag) paths.insert(paths.end(), {path + "=true", path + "=false"});
  }
}

/// The plain words under `name` in the tables of a list.
std::vector<std::pair<std::string, const toml::table*>> named_in(const toml::table& owner, std::string_view list) {
  std::vector<std::pair<std::string, const toml::table*>> named;
  if (const toml::array* items = owner[list].as_array()) {
    for (const toml::node& item : *items) {
      const toml::table* table = item.as_table();
      const auto name = table ? (*table)["name"].value<std::string>() : std::nullopt;
      if (name && detail::is_plain_word(*name)) named.emplace_back(*name, table);
    }
  }
  return named;
}

}  // namespace

std::vector<std::string> set_paths(const std::string& text, const ModeCatalog& modes) {
  std::vector<std::string> paths;
  add_paths("coupling.", detail::keys_of<CouplingOptions>(), paths);
  add_paths("law.", detail::keys_of<detail::LawPart>(), paths);
  add_paths("workspace.", detail::keys_of<Workspace>(), paths);
  add_paths("time.", detail::keys_of<TimeOptions>(), paths);
  add_paths("tool.", detail::keys_of<ToolOptions>(), paths);
  toml::table root;
  try {
    root = parse_toml(text, "scene");
  } catch (const SceneError&) {
    return paths;
  }
  if (const toml::table* volumes = root["volume"].as_table()) {
    for (const auto& [name, volume] : *volumes) {
      if (detail::is_plain_word(name.str()))
        add_paths("volume." + std::string(name.str()) + ".", detail::keys_of<detail::VolumePart>(), paths);
    }
  }
  for (const auto& [name, unused] : named_in(root, "hand")) {
    paths.insert(paths.end(), {"only_hand=" + name, "hand." + name + ".at_m"});
    add_paths("hand." + name + ".tool.", detail::keys_of<ToolOptions>(), paths);
  }
  for (const auto& [name, table] : named_in(root, "mode")) {
    const std::string before = "mode." + name + ".";
    add_paths(before, detail::keys_of<detail::ModePart>(), paths);
    const Mode* mode = modes.find((*table)["type"].value_or(std::string()));
    if (!mode) continue;
    for (const Key& key : detail::parameter_keys(*mode)) {
      if (key.items.empty()) {
        add_paths(before, {key}, paths);
      } else {
        for (const auto& [item, unused] : named_in(*table, key.name))
          add_paths(before + key.name + "." + item + ".", key.items, paths);
      }
    }
  }
  return paths;
}

std::vector<std::string> how_to_read_paths() {
  std::vector<std::string> paths;
  add_paths("", detail::keys_of<VolumeRequest>(), paths);
  return paths;
}

VolumeRequest how_to_read(const std::vector<std::pair<std::string, std::string>>& keys) {
  toml::table table;
  for (const auto& [key, value] : keys) SetPath::put(&table, key, value, std::string(set_mark) + key);
  VolumeRequest request;
  check_request(read(table, "--set", request), request);
  return request;
}

}  // namespace palpa
