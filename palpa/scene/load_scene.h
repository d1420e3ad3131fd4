// Scenes from TOML files.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/data/volume.h"
#include "palpa/mode/mode.h"
#include "palpa/scene/scene.h"

namespace palpa {

/// What is said beside a scene's file.
struct SceneOptions {
  std::vector<std::filesystem::path> data_folders;        ///< searched after the scene's own folder, then $PALPA_DATA
  std::vector<std::pair<std::string, std::string>> sets;  ///< `--set PATH=VALUE`, in order
  bool thin_parts = false;  ///< warns, too, of levels whose thin parts the smoothing filter loses; reads all voxels for each
};

/// A scene as its file has it, and what there is to say of it.
struct LoadedScene {
  Scene scene;
  std::string text;                   ///< the file, byte for byte
  std::vector<std::string> warnings;  ///< `PLACE: …` each
};

/// Reads a scene file (docs/scene.md), with the modes of the library, and its volumes by `read_volume`. Throws SceneError with
/// file, line and column.
LoadedScene load_scene(const std::filesystem::path& path, const SceneOptions& options = {});
/// Likewise, with volumes by another reader and with other modes, such as those of plug-ins.
LoadedScene load_scene(const std::filesystem::path& path, const VolumeReader& read_volume, const ModeCatalog& modes,
                       const SceneOptions& options = {});
/// Likewise from text; `name` stands for the path in messages, `folder` for the scene's own folder.
LoadedScene parse_scene(std::string text, const std::string& name, const std::filesystem::path& folder,
                        const VolumeReader& read_volume, const ModeCatalog& modes, const SceneOptions& options = {});

/// The PATHs that `--set` takes in this scene, "coupling.stiffness_n_per_m" or "mode.skin.strength_n", for completion; each
/// with the values that it may have behind it, "law.method=exact", where these are words. The scene need not be right: of what
/// cannot be read there are none.
std::vector<std::string> set_paths(const std::string& text, const ModeCatalog& modes);
/// The same of the keys that `how_to_read` takes.
std::vector<std::string> how_to_read_paths();

/// How a file is read with these keys of `[volume.NAME]` (length_unit, as, dims, …), each with its value as `--set` gives it.
/// Names no file. Throws SceneError.
VolumeRequest how_to_read(const std::vector<std::pair<std::string, std::string>>& keys);

/// The tables of docs/scene.md, from the same list of keys that loading checks against.
std::string scene_reference_markdown(const ModeCatalog& modes);
/// A mode's page table: its parameters as Markdown.
std::string mode_reference_markdown(const Mode& mode);
/// What `palpa modes TYPE` prints.
std::string mode_reference_text(const Mode& mode);

}  // namespace palpa
