#include "palpa/scene/field_lookup.h"

#include <algorithm>

#include "palpa/base/wording.h"
#include "palpa/scene/scene_checks.h"

namespace palpa::detail {

std::vector<std::string> names_of(const std::vector<SceneVolume>& volumes) {
  std::vector<std::string> names;
  for (const SceneVolume& volume : volumes) names.push_back(volume.name);
  return names;
}

std::vector<std::string> field_names(const std::vector<SceneVolume>& volumes) {
  std::vector<std::string> names;
  for (const SceneVolume& volume : volumes) {
    if (volume.volume.fields.size() == 1) {
      names.push_back(volume.name);
    } else {
      for (const VolumeField& field : volume.volume.fields) names.push_back(volume.name + "." + field.name);
    }
  }
  return names;
}

static FoundField find_plain_field(const std::vector<SceneVolume>& volumes, const std::string& name) {
  const std::size_t dot = name.find('.');
  const std::string volume_name = name.substr(0, dot);
  std::int32_t index = 0;
  for (const SceneVolume& volume : volumes) {
    const std::vector<VolumeField>& fields = volume.volume.fields;
    if (volume.name != volume_name) {
      index += static_cast<std::int32_t>(fields.size());
      continue;
    }
    if (dot == std::string::npos) {
      if (fields.size() == 1) return {&fields.front(), index, {}};
      return {nullptr, -1, "volume " + in_quotes(name) + " has several fields; name one of: " + joined(field_names({volume}))};
    }
    for (const VolumeField& field : fields) {
      if (field.name == name.substr(dot + 1)) return {&field, index, {}};
      ++index;
    }
  }
  std::string problem = problem_with_volume_of(name, names_of(volumes));
  if (problem.empty()) problem = "no field " + in_quotes(name) + "; " + suggestion(name, field_names(volumes));
  return {nullptr, -1, problem};
}

/// Plain field within a name, and the result of the functions around it.
FoundField find_field(const std::vector<SceneVolume>& volumes, const std::string& name) {
  const FieldName parsed = parse_field_name(name);
  if (!parsed.problem.empty()) return {nullptr, -1, parsed.problem};
  FoundField found = find_plain_field(volumes, parsed.plain);
  if (!found.field) return found;
  found.name = parsed;
  found.components = components_after(parsed, found.field->field->components(), found.problem);
  if (!found.problem.empty()) return {nullptr, -1, found.problem};
  return found;
}

}  // namespace palpa::detail
