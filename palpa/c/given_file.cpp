#include "palpa/c/given_file.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "palpa/base/load_error.h"
#include "palpa/base/wording.h"
#include "palpa/scene/to_toml.h"

namespace palpa::c {
namespace {

/// \param place  the file, for an error
const VolumeField& field_named(const Volume& file, const std::string& name, const std::string& place) {
  const auto found = std::ranges::find(file.fields, name, &VolumeField::name);
  if (found != file.fields.end()) return *found;
  std::vector<std::string> names;
  for (const VolumeField& field : file.fields) names.push_back(field.name);
  throw LoadError(place + ": has no array " + detail::in_quotes(name) + "; it has " + detail::joined(names));
}

}  // namespace

Volume requested(const Volume& file, const VolumeRequest& request) {
  const std::string place = request.files.front().string();
  VolumeRequest plain;  // all that is done here
  plain.files = request.files;
  plain.fields = request.fields;
  plain.length_unit = request.length_unit;
  const auto same = [](const detail::Said& a, const detail::Said& b) { return a.key == b.key && a.value == b.value; };
  const bool is_plain = std::ranges::equal(detail::said(plain), detail::said(request), same);
  if (!is_plain || std::ranges::any_of(request.fields, [](const auto& field) { return !field.arrays.empty(); }))
    throw LoadError(place +
                    ": was read by the program, which has its arrays as they are; leave out keys that speak of the file");
  if (!request.length_unit.empty() && request.length_unit != file.length_unit)
    throw LoadError(place + ": was read in " + file.length_unit + "; leave out 'length_unit', or scale the volume by 'pose'");
  Volume made = file;
  made.length_unit_assumed = file.length_unit_assumed && request.length_unit.empty();
  made.request = std::make_shared<const VolumeRequest>(request);
  if (request.fields.empty()) return made;
  made.fields.clear();
  for (const VolumeRequest::FieldRequest& wanted : request.fields) {
    const bool is_only_one = file.fields.size() == 1 && wanted.array.empty();
    const VolumeField& field =
        is_only_one ? file.fields.front() : field_named(file, wanted.array.empty() ? wanted.name : wanted.array, place);
    made.fields.push_back({.name = wanted.name, .unit = wanted.unit.empty() ? field.unit : wanted.unit, .field = field.field});
  }
  return made;
}

}  // namespace palpa::c
