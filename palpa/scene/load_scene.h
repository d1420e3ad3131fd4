// Loading of scenes from TOML files.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/data/volume.h"
#include "palpa/mode/mode.h"
#include "palpa/scene/scene.h"

namespace palpa {

/// A scene whose text is valid as far as that is known without the data of a volume that its program gives.
class MissingData : public SceneError {
 public:
  using SceneError::SceneError;
};

/// Volumes that a program gives, by name.
using GivenVolumes = std::map<std::string, Volume, std::less<>>;

/// Options of loading a scene.
struct SceneOptions {
  std::vector<std::filesystem::path> data_folders;        ///< searched after the scene's own folder, then $PALPA_DATA
  std::vector<std::pair<std::string, std::string>> sets;  ///< `--set PATH=VALUE`, in order
  /// Data of each [volume.NAME] without 'file' and 'analytic'; MissingData is thrown where they are not there. nullptr: such a
  /// table is an error. Outlives the call.
  const GivenVolumes* given = nullptr;
  /// Files by the name in the scene that the reader has without opening them. nullptr: none. Outlives the call.
  const GivenVolumes* files = nullptr;
  bool thin_parts = false;  ///< also reports thin parts that the smoothing filter loses; reads all voxels for each level
};

/// A loaded scene with its text and warnings.
struct LoadedScene {
  Scene scene;
  std::string text;                   ///< the file, byte for byte
  std::vector<std::string> warnings;  ///< `PLACE: …` each
  std::vector<std::string> notes;     ///< sentences: losses of a filter that the scene names
};

/// Text of a scene file, byte for byte. Throws SceneError.
std::string read_scene_text(const std::filesystem::path& path);

/// Reads a scene file (docs/scene.md) with built-in modes, and its volumes by `palpa::read_volume`. Throws SceneError with
/// file, line and column.
LoadedScene load_scene(const std::filesystem::path& path, const SceneOptions& options = {});
/// Likewise, with another volume reader and other modes, such as those of plug-ins.
LoadedScene load_scene(const std::filesystem::path& path, const VolumeReader& read_volume, const ModeCatalog& modes,
                       const SceneOptions& options = {});
/// From text; `name` replaces the path in messages, `folder` the scene's own folder.
LoadedScene parse_scene(std::string text, const std::string& name, const std::filesystem::path& folder,
                        const VolumeReader& read_volume, const ModeCatalog& modes, const SceneOptions& options = {});

/// Valid PATHs of `--set` in this scene, such as "mode.skin.strength_n", for shell completion; keys with a fixed set of words
/// also with value ("law.method=exact"). Parts that cannot be parsed are omitted.
std::vector<std::string> set_paths(const std::string& text, const ModeCatalog& modes);
/// Likewise the keys of `how_to_read`.
std::vector<std::string> how_to_read_paths();

/// Request to read a file with these keys of `[volume.NAME]` (length_unit, as, dims, …) and their values as in `--set`. The
/// request has no file name yet. Throws SceneError.
VolumeRequest how_to_read(const std::vector<std::pair<std::string, std::string>>& keys);

/// Tables of docs/scene.md.
std::string scene_reference_markdown(const ModeCatalog& modes);
/// Table of a mode's page: its parameters as Markdown.
std::string mode_reference_markdown(const Mode& mode);
/// Output of `palpa modes TYPE`.
std::string mode_reference_text(const Mode& mode);

}  // namespace palpa
