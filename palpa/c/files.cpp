// Functions for C of files that the program reads itself.
#include <nlohmann/json.hpp>
#include <string>

#include "palpa/c.h"
#include "palpa/c/failure.h"
#include "palpa/c/given_file.h"
#include "palpa/c/grid_values.h"
#include "palpa/c/owned_text.h"
#include "palpa/c/scene_handle.h"
#include "palpa/c/sized.h"
#include "palpa/data/placement.h"
#include "palpa/data/statistics.h"
#include "palpa/scene/first_scene.h"

struct palpa_files {
  palpa::GivenVolumes by_name;
};

namespace palpa::c {
namespace {

using Json = nlohmann::ordered_json;

std::string text_or_none(const char* text) { return text ? text : ""; }

Volume volume_of(const palpa_file& file) {
  if (!file.fields || file.field_count == 0) throw WrongArgument("fields is NULL or empty; give at least one");
  Volume volume;
  volume.format = text_or_none(file.format);
  volume.modality = text_or_none(file.modality);
  volume.length_unit = text_or_none(file.length_unit);
  volume.length_unit_assumed = file.length_unit_assumed != 0;
  if (!file.sources && file.source_count > 0) throw WrongArgument("sources is NULL; give as many as source_count");
  for (const palpa_file_source& source : std::span(file.sources, file.source_count))
    volume.files.push_back(
        {.path = &given(source.name, "name of a source"), .bytes = source.bytes, .sha256 = text_or_none(source.sha256)});
  for (const palpa_file_field& field : std::span(file.fields, file.field_count)) {
    if (!is_known_size<palpa_grid>(given(field.grid, "grid").size))
      throw WrongArgument("size of the grid is wrong; set it to sizeof(palpa_grid)");
    const palpa_grid grid = whole(field.grid);
    volume.medical_frame = grid.medical_frame == 1;
    volume.fields.push_back({.name = &given(field.name, "name of a field"),
                             .unit = text_or_none(field.unit),
                             .field = grid_field(geometry_of(grid), voxels_of(grid), grid.slope, grid.intercept)});
  }
  return volume;
}

const Volume& file_named(const palpa_files* files, const char* name) {
  const auto found = given(files, "files").by_name.find(&given(name, "name"));
  if (found == files->by_name.end()) throw WrongArgument("no file has this name; add it first");
  return found->second;
}

Json json_of(const Vec3& v) { return {v.x, v.y, v.z}; }

Json facts_of(const Volume& file) {
  const Placement placed = placement_of(file);
  Json fields = Json::array();
  for (const VolumeField& field : file.fields) {
    const Statistics values = statistics(*field.field);
    fields.push_back({{"name", field.name},
                      {"unit", field.unit},
                      {"type", name_of(grid_of(*field.field)->voxels.type)},
                      {"components", field.field->components()},
                      {"min", values.min},
                      {"max", values.max},
                      {"mean", values.mean},
                      {"median", values.percentile(0.5)}});
  }
  return {{"format", file.format},
          {"modality", file.modality},
          {"length_unit", file.length_unit},
          {"length_unit_assumed", file.length_unit_assumed},
          {"grid",
           {{"dims", placed.grid.dims},
            {"spacing_m", json_of(placed.spacing_m)},
            {"size_m", json_of(placed.size_m)},
            {"axes", placed.letters}}},
          {"fields", std::move(fields)}};
}

}  // namespace
}  // namespace palpa::c

using namespace palpa::c;

extern "C" {

palpa_files* palpa_files_new(void) {
  return pointer_of("palpa_files_new", [] { return new palpa_files; });
}

void palpa_files_free(palpa_files* files) { delete files; }

palpa_result palpa_files_add(palpa_files* files, const char* name, const palpa_file* file) {
  return result_of("palpa_files_add", [&] {
    given(files, "files");
    if (!is_known_size<palpa_file>(given(file, "file").size))
      throw WrongArgument("size of the file is wrong; set it to sizeof(palpa_file)");
    if (given(name, "name") == '\0') throw WrongArgument("name is empty; give the file's name");
    files->by_name.insert_or_assign(name, volume_of(whole(file)));
  });
}

char* palpa_files_facts(const palpa_files* files, const char* name) {
  return pointer_of("palpa_files_facts", [&] {
    return owned_text(facts_of(file_named(files, name)).dump(-1, ' ', false, Json::error_handler_t::replace));
  });
}

char* palpa_files_first_scene(const palpa_files* files, const char* name) {
  return pointer_of("palpa_files_first_scene", [&] {
    palpa::VolumeRequest request;
    request.files = {name};
    const palpa::Volume volume = requested(file_named(files, name), request);
    try {
      return owned_text(first_scene(volume, request, {.folder = "."}));
    } catch (const palpa::LoadError& error) {
      throw palpa::LoadError(std::string(name) + ": " + error.what());
    }
  });
}

palpa_scene* palpa_scene_parse_with(const char* toml, const palpa_files* files) {
  return pointer_of("palpa_scene_parse_with", [&] {
    return new palpa_scene{SceneRecipe(&given(toml, "toml"), "scene", "", given(files, "files").by_name)};
  });
}
}
