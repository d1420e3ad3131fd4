#include "palpa/scene/first_volume_table.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "palpa/base/load_error.h"
#include "palpa/base/utf8.h"
#include "palpa/base/web_address.h"
#include "palpa/base/wording.h"
#include "palpa/data/body_hint.h"
#include "palpa/data/field_name.h"
#include "palpa/data/filter.h"
#include "palpa/data/octave_parts.h"
#include "palpa/data/thin_parts.h"
#include "palpa/scene/first_scene_lines.h"
#include "palpa/scene/to_toml.h"

namespace palpa::detail {

std::string plain_word(const std::string& name, const std::string& otherwise) {
  if (is_plain_word(name)) return name;
  std::string word;
  for (const char c : name) word += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return is_plain_word(word) ? word : otherwise;
}

namespace {

/// From the file's name; not for DICOM, whose folders are often named after patients.
std::string volume_name(const Volume& volume, const VolumeRequest& request, bool is_flow) {
  const std::string kind = is_flow ? "flow" : volume.medical_frame ? "scan" : "data";
  if (volume.format == "dicom") {
    std::string modality;
    for (const char c : volume.modality) modality += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return plain_word(modality, "scan");
  }
  std::string stem = place_in_file(request.files.front()).file.filename().string();
  if (const std::size_t dot = stem.find('.'); dot != 0 && dot != std::string::npos) stem.resize(dot);
  return stem.size() > 24 ? kind : plain_word(stem, kind);
}

/// Remark on a size with an assumed unit.
std::string doubt_of_size(const Volume& volume, const VolumeRequest& request) {
  const auto hint = too_long_for(volume, request.files);
  if (!hint) return "; correct it if they are not";
  return "; no " + hint->part + " is that long, as which " + in_quotes(hint->name) + " reads: write \"mm\" if it is one";
}

/// Names of the files for a scene in this folder: see `first_scene`.
std::string files_of(const VolumeRequest& request, const std::filesystem::path& folder) {
  std::string all;
  for (const std::filesystem::path& file : request.files) {
    std::filesystem::path name = absolute_place(file, true);
    if (!folder.empty() && !is_web_address(file)) {
      const std::filesystem::path near = name.lexically_relative(std::filesystem::absolute(folder).lexically_normal());
      if (!near.empty() && (file.is_relative() || *near.begin() != "..")) name = near;
    }
    all += (all.empty() ? "" : ", ") + toml_string(name.string());
  }
  return request.files.size() == 1 ? all : "[" + all + "]";
}

}  // namespace

std::string SceneNames::of(std::size_t field) const {
  if (field >= fields.size()) return beside[field - fields.size()];
  const bool says_nothing = fields[field] == "value" || fields[field] == "vector";
  return only_one && says_nothing ? volume : volume + "." + fields[field];
}

SceneNames names_of(const Volume& volume, const VolumeRequest& request, std::size_t felt) {
  SceneNames names;
  const bool is_flow = volume.fields[felt].field->components() == 3;
  names.volume = volume_name(volume, request, is_flow);
  for (const VolumeField& field : volume.fields) {
    std::string word = plain_word(field.name, field.field->components() == 3 ? "flow" : "value");
    while (std::ranges::find(names.fields, word) != names.fields.end()) word += "_";
    names.fields.push_back(word);
  }
  names.used = {felt};
  names.only_one = volume.fields.size() == 1;
  return names;
}

SceneNames names_beside(const Volume& volume, SceneNames& first) {
  SceneNames names = names_of(volume, *volume.request, 0);
  if (names.volume == first.volume) names.volume += "_beside";
  names.used.clear();
  for (std::size_t f = 0; f < names.fields.size(); ++f) first.beside.push_back(names.of(f));
  return names;
}

std::string volume_table(const Volume& volume, const VolumeRequest& request, const SceneNames& names,
                         const std::filesystem::path& folder) {
  for (const std::filesystem::path& file : request.files) {
    if (!is_utf8(absolute_place(file).string()))
      throw LoadError("its name, or that of its folder, is no UTF-8, which a scene has to be; rename it");
  }
  std::string out = "[volume." + names.volume + "]\n";
  const std::vector<Said> how = said(request);
  out += "file = " + files_of(request, folder) + "\n";
  const Vec3 size_m = volume.bounds_m().size_m();
  if (volume.length_unit_assumed) {
    // A comment: as a key it would be an assumption no longer, and `run` would not repeat it.
    out += reasoned("# length_unit = " + toml_string(volume.length_unit),
                    "ASSUMED, the file says none: the data are then " + size_words(size_m) + doubt_of_size(volume, request) +
                        ", and take the first # away");
  } else if (!request.length_unit.empty()) {
    out += reasoned("length_unit = " + toml_string(request.length_unit), "as asked for: the data are " + size_words(size_m));
  }
  if (volume.frames > 1) {
    const int frame = std::max(request.frame, 0);
    out += reasoned("frame = " + std::to_string(frame),
                    "of " + std::to_string(volume.frames) + "; frame_period_s in its place feels all of them, as time goes");
  }
  // Written elsewhere, with reasons; all others are written as the user gave them.
  constexpr std::array<std::string_view, 5> explained{"file", "length_unit", "fields", "frame", "as"};
  for (const auto& [key, value] : how) {
    if (std::ranges::find(explained, key) == explained.end()) out += key + " = " + value + "\n";
  }
  if (!request.as.empty())
    out += reasoned("as = " + toml_string(request.as), "its three frames are the components of one vector");

  VolumeRequest named;
  bool asked_for = false, joined = false, renamed = false;
  for (const std::size_t f : names.used) {
    if (f >= volume.fields.size()) continue;  // of a second volume
    const std::string& array = volume.fields[f].name;
    const auto asked =
        std::find_if(request.fields.begin(), request.fields.end(), [&](const auto& field) { return field.name == array; });
    asked_for = asked_for || asked != request.fields.end();
    joined = joined || (asked != request.fields.end() && !asked->arrays.empty());
    renamed = renamed || names.fields[f] != array;
    named.fields.push_back(asked != request.fields.end() ? *asked : VolumeRequest::FieldRequest{names.fields[f], array, ""});
  }
  const std::size_t all = volume.fields.size(), used = named.fields.size();
  if (asked_for || all > used || renamed) {
    out += reasoned("fields = " + value_of(said(named), "fields"),
                    joined      ? "one vector, whose components the file has as arrays of their own"
                    : asked_for ? "as asked for"
                    : all > used
                        ? std::to_string(used) + " of " + std::to_string(all) + " in the file: the others need not be in memory"
                        : "the file's name for it is no plain word");
  }
  return out;
}

namespace {

/// [1] Share of what is solid that the smoothing spline loses at a level.
double lost_at(std::span<const FieldPtr> sample, double level, SolidSide side) {
  ThinParts all;
  for (const FieldPtr& block : sample) {
    const ThinParts parts = thin_parts(*block, level, side);
    all = {all.solid + parts.solid, all.thin + parts.thin, all.lost + parts.lost};
  }
  return all.thin_share() * all.lost_share();
}

}  // namespace

std::string filter_of_surfaces(const Field& field, std::span<const FieldPtr> sample, const std::vector<FirstLevel>& levels,
                               bool solid_is_high) {
  const GridView* grid = grid_behind(field);
  const bool in_octaves = octaves_of(field) != nullptr;
  if (!grid && !in_octaves) return {};
  const FilterChoice felt =
      grid ? default_filter(*grid) : FilterChoice{Filter::smooth, "has no facets, and needs no copy of all voxels"};
  if (felt.filter != Filter::smooth) return reasoned("filter = \"" + std::string(name_of(felt.filter)) + "\"", felt.why);
  double lost = 0.0;
  for (const FirstLevel& level : levels)
    lost = std::max(lost, lost_at(sample, level.value, solid_is_high ? SolidSide::high : SolidSide::low));
  return reasoned("filter = \"smooth\"", felt.why + std::string(in_octaves ? "; of a sample, loses " : "; loses ") +
                                             (lost < 1e-3 ? std::string("next to nothing")
                                                          : percent(lost) + " of what is solid, thinner than 2 voxels") +
                                             "; \"trilinear\" keeps all, with facets");
}

std::string filter_of_flow(const Volume& volume) {
  const bool any_scalar = std::ranges::any_of(volume.fields, [](const VolumeField& f) { return f.field->components() == 1; });
  const auto of_fractions = [](const VolumeField& f) {
    const GridView* grid = grid_behind(*f.field);
    return grid && (grid->voxels.type == VoxelType::float32 || grid->voxels.type == VoxelType::float64);
  };
  if (!any_scalar || !std::ranges::all_of(volume.fields, of_fractions)) return {};
  return reasoned("filter = \"trilinear\"",
                  "rails follow directions, which do not jump between voxels; masks keep their edges");
}

}  // namespace palpa::detail
