// SceneRecipe: a scene's text with what a program has set and given since, and the scene made of them.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "palpa/scene/load_scene.h"

namespace palpa::c {

/// A scene as a text, settings in their order and grids; each change makes the scene anew, without reading files again. A
/// value; copies share voxels. One thread at a time.
class SceneRecipe {
 public:
  /// Throws SceneError for a text that cannot be used.
  /// \param name    of the text in errors
  /// \param folder  of the files that the text names
  /// \param files   by name, before those of the folder
  SceneRecipe(std::string text, std::string name, std::filesystem::path folder, GivenVolumes files = {});

  /// Sets a value as `--set PATH=VALUE`. Throws SceneError, with nothing changed.
  void set(std::string path, std::string value);
  /// Gives the data of a volume without 'file' and 'analytic'. Throws SceneError, with nothing changed.
  void give(const std::string& name, Volume volume);

  /// Throws MissingData as long as a volume has no data.
  const Scene& scene() const;
  const std::vector<std::string>& warnings() const noexcept { return warnings_; }
  /// As it was given.
  const std::string& text() const noexcept { return text_; }
  /// In their order.
  const std::vector<std::pair<std::string, std::string>>& sets() const noexcept { return sets_; }

 private:
  void make();

  std::string text_;
  std::string name_;
  std::filesystem::path folder_;
  GivenVolumes files_;
  std::vector<std::pair<std::string, std::string>> sets_;
  GivenVolumes given_;
  std::map<std::string, Volume> read_;  // by request: what files held when they were first read
  std::shared_ptr<const Scene> scene_;  // null: data are missing
  std::vector<std::string> warnings_;
};

}  // namespace palpa::c
