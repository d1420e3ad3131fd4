// `--set PATH=VALUE`: edits of a scene's tables before they are read.
#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

namespace palpa::detail::scene_file {

/// Edits the tables of a scene before anything is read from them, so that every check applies to what was set. Throws
/// SceneError at "--set PATH".
class SetPath {
 public:
  explicit SetPath(toml::table& root) : root_(root) {}

  /// Sets the value at a path, such as "mode.skin.strength_n".
  void set(const std::string& path, const std::string& value);
  /// Puts a value, as TOML or else as a text, under a key; `place` stands for the file in errors. Nothing for a null table.
  static void put(toml::table* table, const std::string& key, const std::string& value, const std::string& place);

 private:
  static toml::table& item(toml::table& owner, const std::string& list, const std::string& name, const std::string& kind,
                           const std::string& place);
  static toml::table* subtable(toml::table& owner, const std::string& key, const std::string& place);

  toml::table& root_;
};

}  // namespace palpa::detail::scene_file
