// Fields of a scene by name. Internal.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "palpa/data/field_name.h"
#include "palpa/scene/scene.h"

namespace palpa::detail {

std::vector<std::string> names_of(const std::vector<SceneVolume>& volumes);
/// Names by which the fields of volumes can be referred to.
std::vector<std::string> field_names(const std::vector<SceneVolume>& volumes);

struct FoundField {
  const VolumeField* field = nullptr;
  std::int32_t index = -1;
  std::string problem;  ///< empty: found
  int components = 0;   ///< after the derivations
  FieldName name{};
};

/// The field that a name refers to, derivations included.
FoundField find_field(const std::vector<SceneVolume>& volumes, const std::string& name);

}  // namespace palpa::detail
