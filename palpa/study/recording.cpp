#include "palpa/study/recording.h"

#include "palpa/volume/volume.h"

namespace palpa::detail {

std::vector<SourceFile> data_files(const Scene& scene) {
  std::vector<SourceFile> files;
  for (const SceneVolume& volume : scene.volumes()) {
    for (SourceFile file : volume.volume.files) {
      file.path = std::filesystem::absolute(file.path).string();
      files.push_back(std::move(file));
    }
  }
  return files;
}

std::unique_ptr<TraceWriter> new_trace(const std::filesystem::path& folder, const TraceHeader& header,
                                       const std::string& scene_text, const Scene& scene) {
  std::vector<std::string> modes;
  for (const SceneMode& mode : scene.modes()) modes.push_back(mode.name);
  return std::make_unique<TraceWriter>(folder, header, scene_text, std::move(modes));
}

}  // namespace palpa::detail
