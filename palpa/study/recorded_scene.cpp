#include "palpa/study/recorded_scene.h"

#include <algorithm>

#include "palpa/data/volume.h"
#include "palpa/study/recording.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;

/// Search folders for recorded data by relative paths of the scene: all folders above the data files.
std::vector<fs::path> folders_above(const std::vector<SourceFile>& files) {
  std::vector<fs::path> folders;
  for (const SourceFile& file : files) {
    fs::path folder = fs::path(file.path).parent_path();
    for (; folder.has_relative_path(); folder = folder.parent_path()) {
      if (std::find(folders.begin(), folders.end(), folder) == folders.end()) folders.push_back(folder);
    }
  }
  return folders;
}

void check_data(const std::vector<SourceFile>& recorded, const std::vector<SourceFile>& found) {
  for (std::size_t i = 0; i < std::max(recorded.size(), found.size()); ++i) {
    if (i < recorded.size() && i < found.size() && recorded[i].sha256 == found[i].sha256) continue;
    const std::string& path = i < found.size() ? found[i].path : recorded[i].path;
    const std::string was =
        i < recorded.size() ? recorded[i].path + " with sha256 " + recorded[i].sha256.text() : std::string("no such file");
    throw LoadError(path + ": differs from the recorded file (" + was + "); name the folder of the recorded data with --data");
  }
}

}  // namespace

LoadedScene load_recorded_scene(const fs::path& folder, const TraceReader& trace, const std::vector<fs::path>& data_folders,
                                const ReadOptions& read, const ModeCatalog& modes, bool has_all_hands) {
  const TraceHeader& header = trace.header();
  SceneOptions options{.data_folders = data_folders, .sets = header.sets};
  if (has_all_hands) std::erase_if(options.sets, [](const auto& set) { return set.first == "only_hand"; });
  const std::vector<fs::path> folders = folders_above(header.data_files);
  options.data_folders.insert(options.data_folders.end(), folders.begin(), folders.end());
  LoadedScene loaded =
      parse_scene(trace.scene_text(), (folder / "scene.toml").string(), folder, volume_reader(read), modes, options);
  check_data(header.data_files, detail::data_files(loaded.scene));
  return loaded;
}

}  // namespace palpa
