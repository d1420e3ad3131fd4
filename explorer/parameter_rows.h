// A list of parameters as rows of values: what a form shows, and changes by number.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "palpa/mode/parameters.h"

namespace palpa::explorer {

/// Shows a visitor a part of a scene, to read it or to change it.
using Visit = std::function<void(ParameterVisitor&)>;

struct ParameterRow {
  /// By the kinds of parameters: number, optional number, flag, text, choice, whole number, numbers, field, strength.
  struct Choice {
    int index = 0;
    friend bool operator==(const Choice&, const Choice&) = default;
  };
  using Value = std::variant<double, std::optional<double>, bool, std::string, Choice, std::optional<std::int64_t>,
                             std::vector<double>, FieldRef, Strength>;
  ParameterInfo info{};  ///< but for its choices, which live no longer than the visit
  std::vector<std::string> choices{};
  std::string group{};  ///< of a list's item: "level 2"; empty: the part's own
  Value value{};
};

/// All rows of a part, those of its lists' items after their list's name. Parameters without a simple value have none.
std::vector<ParameterRow> rows_of(const Visit& part);
/// Gives row number `row` this value; nothing where there is no such row of its kind.
void set_row(const Visit& part, std::size_t row, const ParameterRow::Value& value);
/// The lists of a part by name, with their lengths.
struct ParameterListSize {
  std::string name;
  std::size_t size;
};
std::vector<ParameterListSize> lists_of(const Visit& part);
/// Adds an item with its defaults to the list of this name.
void append_to(const Visit& part, const std::string& list);

/// "friction", and its unit "N", of "friction_n".
struct NamedUnit {
  std::string name, unit;
};
NamedUnit named_unit(std::string_view parameter);

}  // namespace palpa::explorer
