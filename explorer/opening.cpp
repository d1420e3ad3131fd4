#include "explorer/opening.h"

#include <algorithm>

#include "palpa/base/scenes_folder.h"
#include "palpa/mode/plugin.h"
#include "palpa/scene/first_scene.h"
#include "palpa/study/recorded_scene.h"
#include "palpa/trace/trace.h"

namespace palpa::explorer {

namespace fs = std::filesystem;

Opened open_any(const fs::path& path, const std::vector<fs::path>& data_folders, std::stop_token stop) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw LoadError(path.string() + ": there is no such file or folder; check the name");
  const ReadOptions read{.stop = stop};
  if (fs::exists(path / "trace.toml", ignored)) {
    const TraceReader trace(path);
    Opened opened{.loaded = load_recorded_scene(path, trace, data_folders, read, modes_with({})), .trace = path};
    opened.title = QString::fromStdString(path.filename().empty() ? path.parent_path().filename() : path.filename());
    return opened;
  }
  const QString name = QString::fromStdString(path.filename().string());
  if (path.extension() == ".toml" && fs::is_regular_file(path, ignored)) {
    return {.loaded = load_scene(path, volume_reader(read), modes_with({}), {.data_folders = data_folders}),
            .scene_file = fs::absolute(path),
            .trace = {},
            .title = name};
  }
  VolumeRequest request;
  request.files = {fs::absolute(path)};
  const Volume volume = read_volume(request, read);
  const std::string text = first_scene(volume, request);
  // The data are loaded already: do not read them again.
  const VolumeReader again = [&](const VolumeRequest& asked) {
    return asked.files == request.files ? volume : read_volume(asked, read);
  };
  return {.loaded = parse_scene(text, name.toStdString() + " (suggested scene)", fs::absolute(path).parent_path(), again,
                                modes_with({})),
          .scene_file = {},
          .trace = {},
          .title = name};
}

std::vector<fs::path> embedded_scenes() {
  std::vector<fs::path> scenes;
  try {
    for (const auto& entry : fs::directory_iterator(scenes_folder()))
      if (entry.path().filename().string().ends_with("_phantom.toml")) scenes.push_back(entry.path());
  } catch (const std::exception&) {  // the start page then has no pictures
  }
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

}  // namespace palpa::explorer
