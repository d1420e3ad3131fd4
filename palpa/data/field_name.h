// Names of fields: VOLUME, VOLUME.FIELD or FUNC(FIELD).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "palpa/data/derived.h"

namespace palpa::detail {

/// A field's name taken apart: `magnitude(curl(flow.velocity))` is curl, then magnitude, of flow.velocity.
struct FieldName {
  std::string plain;                      ///< VOLUME or VOLUME.FIELD
  std::vector<Derivation> derivations{};  ///< innermost first
  std::string problem{};                  ///< empty, or what is wrong with the form; what would be right
  std::string volume() const { return plain.substr(0, plain.find('.')); }
};
FieldName parse_field_name(std::string_view name);

/// The number of components that comes out of the derivations when the plain field has `components`; 0 and
/// a sentence in `problem` where one of them cannot take what it is given.
int components_after(const FieldName& name, int components, std::string& problem);

}  // namespace palpa::detail
