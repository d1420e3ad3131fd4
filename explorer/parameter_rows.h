// Parameters as indexed rows, for forms.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "palpa/mode/parameters.h"

namespace palpa::explorer {

/// Passes a visitor to a part of a scene, for reading or changing it.
using Visit = std::function<void(ParameterVisitor&)>;

struct ParameterRow {
  /// One alternative per kind of parameter: number, optional number, flag, text, choice, whole number, numbers, field,
  /// strength.
  struct Choice {
    int index = 0;
    friend bool operator==(const Choice&, const Choice&) = default;
  };
  using Value = std::variant<double, std::optional<double>, bool, std::string, Choice, std::optional<std::int64_t>,
                             std::vector<double>, FieldRef, Strength>;
  ParameterInfo info{};  ///< without choices, whose lifetime is the visit
  std::vector<std::string> choices{};
  std::string group{};  ///< of a list item: "level 2"; empty: of the part itself
  Value value{};
};

/// All rows of a part; items of a list follow the list's name. Parameters without a simple value have no row.
std::vector<ParameterRow> rows_of(const Visit& part);
/// Sets row number `row`; no effect if there is no such row of that kind.
void set_row(const Visit& part, std::size_t row, const ParameterRow::Value& value);
/// Name and length of a list of a part.
struct ParameterListSize {
  std::string name;
  std::size_t size;
};
std::vector<ParameterListSize> lists_of(const Visit& part);
/// Appends an item with default values to a list.
void append_to(const Visit& part, const std::string& list);

/// True for rows that show at first: fields, levels, and one strength or drag; the others are under "More".
bool is_basic(const std::vector<ParameterRow>& rows, std::size_t row);
/// Multiplies all strengths and drags of a part by `factor` [1].
void scale_strengths(const Visit& part, double factor);

/// Name of a parameter in the window, without its unit: "dry friction" of "friction_n".
std::string words_of_parameter(std::string_view parameter);
/// Name of a choice of a parameter in the window: "large ones" of "large" of "parts".
std::string words_of_choice(std::string_view parameter, const std::string& choice);

/// "friction", and its unit "N", of "friction_n".
struct NamedUnit {
  std::string name, unit;
};
NamedUnit named_unit(std::string_view parameter);

}  // namespace palpa::explorer
