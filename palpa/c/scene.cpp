// Functions for C of scenes.
#include "palpa/c.h"
#include "palpa/c/failure.h"
#include "palpa/c/grid_values.h"
#include "palpa/c/owned_text.h"
#include "palpa/c/scene_handle.h"
#include "palpa/c/sized.h"

using namespace palpa::c;

extern "C" {

palpa_scene* palpa_scene_load(const char* path) {
  return pointer_of("palpa_scene_load", [&] {
    const std::filesystem::path file(&given(path, "path"));
    return new palpa_scene{SceneRecipe(palpa::read_scene_text(file), file.string(), file.parent_path())};
  });
}

palpa_scene* palpa_scene_parse(const char* toml, const char* folder) {
  return pointer_of("palpa_scene_parse",
                    [&] { return new palpa_scene{SceneRecipe(&given(toml, "toml"), "scene", folder ? folder : "")}; });
}

palpa_scene* palpa_scene_copy(const palpa_scene* scene) {
  return pointer_of("palpa_scene_copy", [&] { return new palpa_scene(given(scene, "scene")); });
}

void palpa_scene_free(palpa_scene* scene) { delete scene; }

palpa_result palpa_scene_add_grid(palpa_scene* scene, const char* name, const palpa_grid* grid) {
  return result_of("palpa_scene_add_grid", [&] {
    given(scene, "scene");
    given(name, "name");
    if (!is_known_size<palpa_grid>(given(grid, "grid").size))
      throw WrongArgument("size of the grid is " + std::to_string(grid->size) + "; set it to sizeof(palpa_grid)");
    scene->recipe.give(name, volume_of(whole(grid)));
  });
}

palpa_result palpa_scene_set(palpa_scene* scene, const char* path, const char* value) {
  return result_of("palpa_scene_set", [&] {
    given(scene, "scene");
    scene->recipe.set(&given(path, "path"), &given(value, "value"));
  });
}

char* palpa_scene_text(const palpa_scene* scene) {
  return pointer_of("palpa_scene_text", [&] { return owned_text(to_toml(given(scene, "scene").recipe.scene())); });
}

char* palpa_scene_warnings(const palpa_scene* scene) {
  return pointer_of("palpa_scene_warnings", [&] {
    std::string lines;
    for (const std::string& warning : given(scene, "scene").recipe.warnings()) lines += (lines.empty() ? "" : "\n") + warning;
    return owned_text(lines);
  });
}
}
