// Files of a scene as a page gives them: given_files SCENE FOLDER reads them by palpa-read and writes FOLDER/files.json, and
// the voxels of each field beside it.
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "palpa/data/grid.h"
#include "palpa/file/read_volume.h"
#include "palpa/mode/mode.h"
#include "palpa/scene/load_scene.h"

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json json_of(const palpa::Vec3& v) { return {v.x, v.y, v.z}; }

Json given(const palpa::VolumeField& field, const fs::path& voxels) {
  const palpa::GridView& grid = *palpa::grid_of(*field.field);
  const palpa::Mat3 axes = transposed(grid.geometry.index_to_world_m);
  const auto bytes = static_cast<std::streamsize>(static_cast<std::size_t>(grid.geometry.voxels() * grid.voxels.components) *
                                                  palpa::size_of(grid.voxels.type));
  std::ofstream(voxels, std::ios::binary).write(reinterpret_cast<const char*>(grid.voxels.data.get()), bytes);
  return {{"name", field.name},
          {"unit", field.unit},
          {"type", palpa::name_of(grid.voxels.type)},
          {"components", grid.voxels.components},
          {"dims", grid.geometry.dims},
          {"origin_m", json_of(grid.geometry.origin_m)},
          {"axes_m", {json_of(axes.row[0]), json_of(axes.row[1]), json_of(axes.row[2])}},
          {"slope", grid.scale},
          {"intercept", grid.offset},
          {"voxels", voxels.filename().string()}};
}

Json given(const palpa::Volume& volume, const fs::path& folder, std::size_t number) {
  Json fields = Json::array(), sources = Json::array();
  for (const palpa::VolumeField& field : volume.fields)
    fields.push_back(given(field, folder / (std::to_string(number) + "-" + std::to_string(fields.size()))));
  for (const palpa::SourceFile& file : volume.files)
    sources.push_back({{"name", file.path}, {"bytes", file.bytes}, {"sha256", file.sha256.text()}});
  return {{"format", volume.format},
          {"modality", volume.modality},
          {"length_unit", volume.length_unit},
          {"length_unit_assumed", volume.length_unit_assumed},
          {"medical_frame", volume.medical_frame},
          {"sources", sources},
          {"fields", fields}};
}

}  // namespace

int main(int count, char** words) {
  if (count != 3) {
    std::fprintf(stderr, "usage: given_files SCENE FOLDER\n");
    return 2;
  }
  try {
    const fs::path folder = words[2];
    fs::create_directories(folder);
    const palpa::VolumeReader reader = palpa::volume_reader();
    Json files = Json::array();
    palpa::load_scene(
        words[1],
        [&](const palpa::VolumeRequest& request) {
          palpa::VolumeRequest whole = request;
          whole.fields.clear();
          files.push_back(given(reader(whole), folder, files.size()));
          return reader(request);
        },
        palpa::standard_modes());
    std::ofstream(folder / "files.json") << files.dump(1);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "given_files: %s\n", error.what());
    return 1;
  }
}
