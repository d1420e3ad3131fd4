#include "palpa/data/field_name.h"

#include <algorithm>

#include "palpa/base/wording.h"

namespace palpa::detail {

namespace {

// [1] More: nonsensical names are parsed for longer; fewer: deep but sensible names are refused.
constexpr std::size_t most_derivations = 8;

std::vector<std::string> functions() {
  std::vector<std::string> names;
  for (int i = 0;; ++i) {
    const auto derivation = static_cast<Derivation>(i);
    if (derivation == Derivation::smooth) return names;
    names.emplace_back(name_of(derivation));
  }
}

std::string kind(int components) { return components == 1 ? "scalar" : "vector"; }

}  // namespace

FieldName parse_field_name(std::string_view name) {
  FieldName parsed;
  std::string_view rest = name;
  for (std::size_t open = rest.find('('); open != std::string_view::npos; open = rest.find('(')) {
    const std::string_view function = rest.substr(0, open);
    const auto derivation = derivation_named(function);
    if (!derivation) {
      parsed.problem = "no function " + in_quotes(function) + " of a field; " + suggestion(function, functions());
      return parsed;
    }
    if (rest.back() != ')' || parsed.derivations.size() == most_derivations) {
      parsed.problem =
          in_quotes(name) + " is no field; write VOLUME, VOLUME.FIELD or FUNC(FIELD), as in magnitude(flow.velocity)";
      return parsed;
    }
    parsed.derivations.push_back(*derivation);
    rest = rest.substr(open + 1, rest.size() - open - 2);
  }
  std::ranges::reverse(parsed.derivations);
  parsed.plain = rest;
  if (rest.find(')') != std::string_view::npos) {
    parsed.problem =
        in_quotes(name) + " is no field; write VOLUME, VOLUME.FIELD or FUNC(FIELD), as in magnitude(flow.velocity)";
  }
  return parsed;
}

int components_after(const FieldName& name, int components, std::string& problem) {
  for (const Derivation derivation : name.derivations) {
    if (components_taken(derivation) != components) {
      problem = in_quotes(name_of(derivation)) + " cannot be taken of the " + kind(components) +
                " field within it; it takes a " + kind(components_taken(derivation)) + " field";
      return 0;
    }
    components = components_given(derivation);
  }
  return components;
}

}  // namespace palpa::detail
