// Names of fields: VOLUME, VOLUME.FIELD or FUNC(FIELD).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "palpa/data/derived.h"

namespace palpa::detail {

/// Parsed field name: `magnitude(curl(flow.velocity))` is curl, then magnitude, of flow.velocity.
struct FieldName {
  std::string plain;                      ///< VOLUME or VOLUME.FIELD
  std::vector<Derivation> derivations{};  ///< innermost first
  std::string problem{};                  ///< empty, or fault of the form and remedy
  std::string volume() const { return plain.substr(0, plain.find('.')); }
};
FieldName parse_field_name(std::string_view name);

/// Number of components after the derivations of a plain field with `components`; 0 and a sentence in `problem` if a derivation
/// cannot be applied.
int components_after(const FieldName& name, int components, std::string& problem);

}  // namespace palpa::detail
