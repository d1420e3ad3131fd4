// Shared parts of the scene tests: data without a reader, and the error of a text.
#pragma once

#include <string>
#include <vector>

#include "palpa/data/analytic.h"
#include "palpa/data/volume.h"
#include "palpa/scene/load_scene.h"

namespace palpa::test {

/// A stand-in for files: `scalar*` is a ball, `two*` a scalar and a vector field, `medical*` a head; the flows of the shipped
/// scenes have their files' fields.
inline Volume read_stand_in(const VolumeRequest& request) {
  const std::string file = request.files.front().filename().string();
  Volume volume = file.starts_with("medical") ? head_phantom() : sphere_field();
  if (file.starts_with("two"))
    volume.fields = {{"density", "", sphere_field().fields[0].field}, {"velocity", "m/s", lamb_oseen_vortex().fields[0].field}};
  const FieldPtr scalar = sphere_field().fields[0].field, vector = lamb_oseen_vortex().fields[0].field;
  if (file.starts_with("wing")) volume.fields = {{"velocity", "", vector}, {"pressure", "", scalar}, {"fluid", "", scalar}};
  if (file.starts_with("bluntfin")) volume.fields = {{"velocity", "", vector}, {"pressure", "", scalar}};
  if (file.starts_with("carotid")) volume.fields = {{"velocity", "", vector}, {"signal", "", scalar}};
  if (file.starts_with("broken")) throw LoadError(request.files.front().string() + ": ends in the middle; give a whole file");
  volume.files = {{request.files.front().string(), 1, "0"}};
  return volume;
}

inline LoadedScene parse(const std::string& text, const SceneOptions& options = {}, const std::filesystem::path& folder = {}) {
  return parse_scene(text, "s.toml", folder, read_stand_in, standard_modes(), options);
}

/// The error of `parse`; "no error" without one.
inline std::string error_of(const std::string& text, const SceneOptions& options = {},
                            const std::filesystem::path& folder = {}) {
  try {
    parse(text, options, folder);
  } catch (const LoadError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace palpa::test
