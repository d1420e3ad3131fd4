#include "palpa/file/components.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "palpa/data/grid_base.h"
#include "palpa/data/volume.h"

namespace palpa {
namespace {

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Name split into the components' common part and the component: 0, 1, 2.
struct Component {
  std::string common;
  std::size_t axis = 0;
  char way = ' ';  ///< notation of the component: a letter of x y z, of u v w, or a digit
};

std::optional<Component> component_in(const std::string& name) {
  if (name.empty()) return std::nullopt;
  const std::string small = lower(name);
  for (const std::string_view letters : {"xyz", "uvw", "012"}) {
    const std::size_t axis = letters.find(small.back());
    if (axis == std::string_view::npos) continue;
    std::string common = name.substr(0, name.size() - 1);
    const std::size_t bare = common.find_last_not_of("_-.: ") + 1;
    const bool apart = bare < common.size();
    common.resize(bare);
    // Without a separator a last letter belongs to the word, except for these words.
    static constexpr std::string_view joined[] = {"", "u", "v", "vel", "velocity", "wind", "b", "e", "f"};
    const bool known = std::ranges::find(joined, lower(common)) != std::end(joined);
    const bool alone = common.empty() && letters == "uvw" && !apart;
    const bool together = !apart && !common.empty() && letters == "xyz" && known;
    if (alone || together || (apart && !common.empty())) return Component{common, axis, letters.front()};
  }
  return std::nullopt;
}

/// Words of triples that are no vectors: positions, and the three images of a phase-contrast scan.
bool is_place(const std::string& common) {
  for (const char* word : {"coord", "point", "pos", "index", "normal", "mag", "venc", "mask"}) {
    if (lower(common).starts_with(word)) return true;
  }
  return false;
}

bool is_plain_word(const std::string& name) {
  return !name.empty() && std::isalpha(static_cast<unsigned char>(name.front())) &&
         std::ranges::all_of(name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-'; });
}

}  // namespace

std::vector<VolumeRequest::FieldRequest> separate_vectors(const Volume& volume) {
  std::vector<VolumeRequest::FieldRequest> vectors;
  for (const VolumeField& first : volume.fields) {
    const auto x = component_in(first.name);
    const GridView* grid = grid_of(*first.field);
    if (!x || x->axis != 0 || is_place(x->common) || !grid || first.field->components() != 1) continue;
    std::array<std::string, 3> names{first.name, "", ""};
    int found = 0;
    bool one_unit = true;
    for (const VolumeField& other : volume.fields) {
      const auto component = component_in(other.name);
      const GridView* there = grid_of(*other.field);
      if (!component || component->axis == 0 || component->common != x->common || component->way != x->way || !there ||
          other.field->components() != 1 || there->geometry != grid->geometry) {
        continue;
      }
      names[component->axis] = other.name, ++found;
      one_unit = one_unit && other.unit == first.unit;
    }
    if (found != 2 || names[1].empty() || names[2].empty() || !one_unit) continue;
    std::string name = x->common.size() > 1 && is_plain_word(x->common) ? x->common : "velocity";
    const bool taken = std::ranges::any_of(volume.fields, [&](const VolumeField& f) { return f.name == name; }) ||
                       std::ranges::any_of(vectors, [&](const auto& v) { return v.name == name; });
    if (taken) name += "_vector";
    vectors.push_back({name, "", "", {names.begin(), names.end()}});
  }
  return vectors;
}

std::optional<VolumeRequest> with_vectors_joined(const VolumeRequest& request, const Volume& volume) {
  if (!request.fields.empty()) return std::nullopt;
  VolumeRequest joined = request;
  joined.fields = separate_vectors(volume);
  if (joined.fields.empty()) return std::nullopt;
  const std::size_t vectors = joined.fields.size();
  for (const VolumeField& field : volume.fields) {
    const auto holds = [&](const VolumeRequest::FieldRequest& f) {
      return std::ranges::find(f.arrays, field.name) != f.arrays.end();
    };
    if (std::none_of(joined.fields.begin(), joined.fields.begin() + static_cast<std::ptrdiff_t>(vectors), holds)) {
      joined.fields.push_back({field.name, "", ""});
    }
  }
  return joined;
}

namespace detail {

const char* problem_with_components(const protocol::Header& header, const std::vector<std::uint32_t>& arrays) {
  if (arrays.size() == 1) return nullptr;
  const protocol::FieldHeader& first = header.fields[arrays.front()];
  for (const std::uint32_t array : arrays) {
    const protocol::FieldHeader& field = header.fields[array];
    if (field.components != 1) return "one of them holds vectors already; name three of numbers";
    if (field.grid != first.grid) return "they lie on different grids; name three on one";
  }
  return nullptr;
}

Voxels joined_components(const protocol::Header& header, const std::vector<std::uint32_t>& arrays,
                         const std::vector<std::shared_ptr<const void>>& voxels) {
  const auto count = static_cast<std::size_t>(header.fields[arrays.front()].grid.voxels());
  const bool wide = std::ranges::any_of(arrays, [&](std::uint32_t array) {
    return header.fields[array].type == VoxelType::float64 || header.fields[array].type == VoxelType::int32;
  });
  const auto fill = [&](auto number) {
    using Number = decltype(number);
    const std::shared_ptr<Number[]> joined(new Number[3 * count]);
    for (std::size_t c = 0; c < 3; ++c) {
      const protocol::FieldHeader& field = header.fields[arrays[c]];
      with_values_of({field.type, 1, voxels[c]}, [&](const auto* from) {
        for (std::size_t n = 0; n < count; ++n)
          joined[3 * n + c] = static_cast<Number>(static_cast<double>(from[n]) * field.scale + field.offset);
      });
    }
    return Voxels{wide ? VoxelType::float64 : VoxelType::float32, 3, joined};
  };
  return wide ? fill(double{}) : fill(float{});
}

Resampling joined_resampling(const std::vector<Resampling>& all, const std::vector<std::size_t>& parts) {
  Resampling joined = all[parts.front()];
  const auto worse = [](ResamplingError& of, const ResamplingError& other) {
    of.p50 = std::max(of.p50, other.p50), of.p99 = std::max(of.p99, other.p99), of.max = std::max(of.max, other.max);
    of.covered = std::min(of.covered, other.covered);
  };
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const Resampling& part = all[parts[n]];
    joined.value_ranges.insert(joined.value_ranges.end(), part.value_ranges.begin(), part.value_ranges.end());
    worse(joined.by_cell, part.by_cell), worse(joined.by_volume, part.by_volume);
  }
  return joined;
}

}  // namespace detail
}  // namespace palpa
